//! Each mode of a single-mode method is tested: one pole, close modes, or a repeated pole. Findings
//! report every weakness of a mode with its value and limit.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::modal::Pole;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::peak_detection::{self, DetectedPeaks, Peak, PeakRejection};
use crate::identify::error::IdentifyError;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::residues;
use crate::identify::sdof::repeated_poles::{self, IsolatedLines, PairTable, ShapeCount};
use crate::identify::sdof::single_mode_method::Resonance;
use crate::identify::sdof::single_mode_test::{self, Excess};

/// Minimum number of lines in a half-power band for an estimate of damping.
const MIN_LINES_PER_BANDWIDTH: f64 = 5.0;
/// Minimum length of a record in time constants of a mode.
const MIN_TIME_CONSTANTS: f64 = 6.0;
/// Bias of damping by leakage, over damping, above which it is reported: a resonance of 4 lines
/// under a Hann window. At 5 % resonances of the 5 lines that peak-picking needs would be reported;
/// at 30 % the bias of a bridge of 2 lines would not.
pub(in crate::identify) const MAX_LEAKAGE_BIAS: f64 = 0.1;
/// Maximum relative standard deviation of a damping surface (Ewins 2000, section 4.3: 4 to 5 % is
/// good).
const MAX_DAMPING_SPREAD: f64 = 0.05;
/// Minimum separation of two visible peaks in half-power bandwidths; closer ones bias each other.
const MIN_SEPARATION_BANDWIDTHS: f64 = 3.0;

/// Data, peaks, fits and verdicts that the findings report on.
pub(in crate::identify) struct Context<'a> {
    /// The FRFs as given.
    pub set: &'a FrfSet,
    /// Their receptances in the band.
    pub data: &'a BandFrfs,
    /// Detected peaks.
    pub found: &'a DetectedPeaks,
    /// Fitted modes in ascending frequency.
    pub resonances: &'a [Resonance],
    /// Results of the close-mode tests by mode.
    pub verdicts: &'a [SdofVerdict],
}

/// Whether one pole explains a peak, and the residues that follow.
pub(in crate::identify) struct SdofVerdict {
    /// The first test that failed.
    pub excess: Option<Excess>,
    /// Modes that share the pole.
    pub multiplicity: usize,
    /// Residues by function, m/(N s).
    pub residues: Vec<Complex64>,
}

/// Tests every mode for a second pole under its peak (a visible neighbour, FRFs that disagree on
/// the frequency, a frequency dependence of more than one pole), then for several shapes with one
/// pole. Above a highest frequency, where the anti-alias filter falls off, shapes are not counted:
/// its truncated ringing would show many.
///
/// # Errors
/// [`IdentifyError::Linalg`] when singular values do not converge.
pub(in crate::identify) fn verdicts(
    data: &FitData,
    found: &DetectedPeaks,
    resonances: &[Resonance],
    residues: &[Vec<Complex64>],
    table: Option<&PairTable>,
    highest_rad_s: f64,
) -> Result<Vec<SdofVerdict>, IdentifyError> {
    let poles: Vec<Complex64> = resonances.iter().map(|r| r.lambda).collect();
    let verdict = |mode: usize| {
        let mode_residues = &residues[mode];
        let neighbour = nearest(&data.frfs, found, resonances, mode);
        if neighbour.is_some() {
            return Ok(SdofVerdict {
                excess: neighbour,
                multiplicity: 1,
                residues: mode_residues.clone(),
            });
        }
        let lines = resonances[mode].lines.clone();
        let isolated = residues::remainder(&data.frfs, &poles, residues, &[mode], lines.clone());
        let functions = 0..data.frfs.functions();
        let variance: Vec<f64> = functions
            .map(|f| data.noise.mean_variance(f, lines.clone()))
            .collect();
        let shape = single_mode_test::second_shape(&isolated, &variance)?;
        let pole = single_mode_test::second_pole(
            &data.frfs.omega[lines.clone()],
            poles[mode],
            mode_residues,
            &isolated,
            &variance,
        );
        let residues = match shape {
            Some(_) => residues::residues_at_individual_frequencies(
                &data.frfs,
                poles[mode],
                &isolated,
                lines,
            ),
            None => mode_residues.clone(),
        };
        let table = table.filter(|_| poles[mode].im <= highest_rad_s);
        let judgement = match (table, shape.or(pole)) {
            (_, Some(excess)) => ShapeCount::SeparatePoles(excess),
            (None, None) => ShapeCount::OnePole(1),
            (Some(table), None) => {
                let lines = IsolatedLines {
                    omega: &data.frfs.omega[resonances[mode].lines.clone()],
                    lambda: poles[mode],
                    values: &isolated,
                    variance: data.noise.is_stated().then_some(&variance),
                };
                repeated_poles::count_shapes(table, &lines)?
            }
        };
        let (excess, multiplicity) = match judgement {
            ShapeCount::SeparatePoles(excess) => (Some(excess), 1),
            ShapeCount::OnePole(multiplicity) => (None, multiplicity),
        };
        Ok(SdofVerdict {
            excess,
            multiplicity,
            residues,
        })
    };
    (0..resonances.len()).into_par_iter().map(verdict).collect()
}

/// Findings of some modes, in order of frequency, then those of the rejected peaks.
pub(in crate::identify) fn findings(context: &Context, modes: &[usize]) -> Vec<Finding> {
    let modes = modes.iter().flat_map(|mode| mode_findings(context, *mode));
    let mut findings: Vec<Finding> = modes.collect();
    let dropped = context.found.dropped.iter();
    findings.extend(dropped.map(|(peak, drop)| rejected_peak_finding(context.data, peak, drop)));
    findings
}

/// The finding of a rejected peak.
pub(in crate::identify) fn rejected_peak_finding(
    data: &BandFrfs,
    peak: &Peak,
    drop: &PeakRejection,
) -> Finding {
    let (value, limit) = match drop {
        PeakRejection::NotHighest(ratio) => (*ratio, 2.0),
        PeakRejection::Unstable(turn) => (*turn, 0.0),
        PeakRejection::NotTurning(turn) => (*turn, peak_detection::MIN_PHASE_CHANGE_RATIO),
    };
    let location = Location::Mode(peak_detection::hz(data, peak.line));
    Finding::new(Severity::Info, Code::PeakDropped, location)
        .value(value, "")
        .limit(limit)
}

/// Location of a finding: the frequency of the mode without the damping of the window.
fn location(context: &Context, resonance: &Resonance) -> Location {
    let pole = Pole {
        lambda: resonance.lambda,
    };
    let pole = pole.without_added_damping(context.set.added_damping_rad_s);
    Location::Mode(pole.natural_frequency_hz())
}

fn mode_findings(context: &Context, mode: usize) -> Vec<Finding> {
    let resonance = &context.resonances[mode];
    let decay = -resonance.lambda.re;
    let (data, location) = (context.data, location(context, resonance));
    let warning = |code, value: f64, unit: &str, limit: f64| {
        Finding::new(Severity::Warning, code, location.clone())
            .value(value, unit)
            .limit(limit)
    };
    let mut findings = Vec::new();
    if let Some(excess) = context.verdicts[mode].excess {
        findings.push(warning(Code::CloseModes, excess.value, "", excess.limit));
    }
    let multiplicity = context.verdicts[mode].multiplicity;
    if multiplicity > 1 {
        let finding = Finding::new(Severity::Info, Code::RepeatedRoot, location.clone());
        findings.push(finding.value(multiplicity as f64, ""));
    }
    if resonance.fit.is_none() {
        findings.push(Finding::new(
            Severity::Warning,
            Code::NotFitted,
            location.clone(),
        ));
    }
    let lines = 2.0 * decay / data.step;
    if lines < MIN_LINES_PER_BANDWIDTH {
        findings.push(warning(Code::FewLines, lines, "", MIN_LINES_PER_BANDWIDTH));
    }
    if resonance.fit.is_some_and(|fit| fit.one_sided) {
        findings.push(Finding::new(
            Severity::Warning,
            Code::HalfPowerMissing,
            location.clone(),
        ));
    }
    if let Some(spread) = resonance
        .fit
        .and_then(|fit| fit.spread)
        .filter(|s| *s > MAX_DAMPING_SPREAD)
    {
        findings.push(warning(Code::DampingSpread, spread, "", MAX_DAMPING_SPREAD));
    }
    findings.extend(reach(context.set, data, resonance.lambda, &location));
    findings
}

/// Findings of a pole whose record is too short, or whose half-power band reaches an end of the
/// band.
pub(in crate::identify) fn reach(
    set: &FrfSet,
    data: &BandFrfs,
    lambda: Complex64,
    location: &Location,
) -> Vec<Finding> {
    let (decay, mut findings) = (-lambda.re, Vec::new());
    let warning = |code, value: f64, unit: &str, limit: f64| {
        Finding::new(Severity::Warning, code, location.clone())
            .value(value, unit)
            .limit(limit)
    };
    let constants = set.record_duration_s.map(|duration| decay * duration);
    if let Some(constants) = constants.filter(|n| *n < MIN_TIME_CONSTANTS) {
        let limit = MIN_TIME_CONSTANTS;
        findings.push(warning(Code::FewTimeConstants, constants, "", limit));
    }
    findings.extend(leakage(data, lambda, location));
    let last = data.omega[data.lines() - 1];
    let margin = (lambda.im - data.omega[0]).min(last - lambda.im);
    if margin < 2.0 * decay {
        let limit = 2.0 * decay / TAU;
        findings.push(warning(Code::NearBandEdge, margin / TAU, "Hz", limit));
    }
    findings
}

/// The finding of a resonance so narrow that leakage biases its damping, where the leakage was not
/// corrected and the data do not contradict it.
fn leakage(data: &BandFrfs, lambda: Complex64, location: &Location) -> Option<Finding> {
    let shape = (data.leakage).filter(|_| !data.line_shape.is_smoothed())?;
    let bias = shape.leakage_bias(-lambda.re)?;
    let finding = Finding::new(Severity::Warning, Code::DampingBiasedHigh, location.clone());
    let finding = finding.detail(shape.window_name());
    let value = |finding: Finding| {
        finding
            .value(100.0 * bias, "%")
            .limit(100.0 * MAX_LEAKAGE_BIAS)
    };
    (bias > MAX_LEAKAGE_BIAS).then(|| match bias.is_finite() {
        true => value(finding),
        false => finding,
    })
}

/// The finding of a stated exponential window whose added damping is not specified.
pub(in crate::identify) fn window_decay(set: &FrfSet) -> Option<Finding> {
    let mut windows = set.window.iter().chain(&set.mixed_windows);
    let is_unknown =
        set.added_damping_rad_s <= 0.0 && windows.any(|window| window.is_exponential());
    let code = Code::WindowDecayUnknown;
    is_unknown.then(|| Finding::new(Severity::Warning, code, Location::Whole))
}

/// Separation from the nearest other visible peak, rejected ones included, in half-power bandwidths
/// of the mode, where it is too small.
fn nearest(
    data: &BandFrfs,
    found: &DetectedPeaks,
    resonances: &[Resonance],
    mode: usize,
) -> Option<Excess> {
    let lambda = resonances[mode].lambda;
    let others = resonances.iter().enumerate().filter(|(j, _)| *j != mode);
    let dropped = found.dropped.iter();
    others
        .map(|(_, other)| other.lambda.im)
        .chain(dropped.map(|(peak, _)| data.omega[peak.line]))
        .map(|omega| (omega - lambda.im).abs() / (2.0 * lambda.re.abs()))
        .min_by(f64::total_cmp)
        .filter(|widths| *widths < MIN_SEPARATION_BANDWIDTHS)
        .map(|widths| Excess {
            value: widths,
            limit: MIN_SEPARATION_BANDWIDTHS,
        })
}

#[cfg(test)]
mod tests {
    use crate::identify::sdof::findings::*;
    use crate::identify::synthetic::{Measurement, Structure};

    #[test]
    fn peak_without_a_fit_is_reported() {
        let axis = crate::axis::FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.1,
            len: 1001,
        };
        let structure = Structure {
            modes: vec![(60.0, 0.01, vec![1.0])],
        };
        let set = structure.measured(&Measurement::of_sensors(1, axis));
        let band = crate::axis::Band::new(1.0, 100.0).unwrap();
        let lambda = Pole::from_frequency(60.0, 0.01).lambda;
        let context = Context {
            set: &set,
            data: &BandFrfs::new(&set, band).unwrap(),
            found: &DetectedPeaks::default(),
            resonances: &[Resonance {
                initial: lambda,
                lambda,
                fit: None,
                lines: 500..700,
            }],
            verdicts: &[SdofVerdict {
                excess: None,
                multiplicity: 1,
                residues: vec![Complex64::ONE],
            }],
        };
        let codes: Vec<Code> = findings(&context, &[0])
            .iter()
            .map(|finding| finding.code)
            .collect();
        assert_eq!(codes, [Code::NotFitted]);
        assert!(findings(&context, &[]).is_empty());
    }
}

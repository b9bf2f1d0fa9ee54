//! Findings of the maximum likelihood method about its modes and about the poles that it removed.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::{FrfSet, shifted_run};
use crate::modal::Pole;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::data::residual::PredictedResponse;
use crate::identify::fit::fit_data::FitData;
use crate::identify::pole_model::pole_metrics::{
    MAX_PHASE_DIFFERENCE_RAD, MIN_CONTRIBUTION_WITH_MISFIT, PoleMetrics, Rejection,
};
use crate::identify::run_variation::RunShifts;
use crate::identify::run_variation::loaded_shapes::{MAX_SHAPE_CHANGE, Unloaded};
use crate::identify::run_variation::run_means::RunMean;
use crate::identify::run_variation::separate_responses::{by_point, run_partners};
use crate::identify::sdof::findings::{reach, rejected_peak_finding};
use crate::linalg::sort_ascending_by;

/// Minimum number of frequency lines in a half-power band; below it the damping depends on the
/// model alone.
const MIN_LINES_PER_BANDWIDTH: f64 = 1.0;
/// Standard deviation of the damping by narrower bands, in percent of it, above which it is
/// reported: the limit for misfit. Larger: hammer recordings whose damping changes by 14 % from
/// band to band are not reported.
const MAX_BAND_DEVIATION_PERCENT: f64 = 10.0;
/// Maximum distance of a peak from its mode, half-power bandwidths or frequency lines.
const PEAK_BANDWIDTHS: f64 = 1.0;
const PEAK_LINES: f64 = 3.0;

/// Reason for the removal of a pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum DropReason {
    /// Its significance does not exceed the limit for noise: value and limit.
    BelowNoise(f64, f64),
    /// Its standard deviation is too large: standard deviation over decay rate.
    PoleUndetermined(f64),
    /// It is inseparable from a stronger pole: distance in standard deviations.
    NotSeparable(f64),
    /// Its half-power bandwidth is not that of a resonance: Hz.
    NotResonant(f64),
    /// It is spurious although it is above the noise.
    Rejected(Rejection),
}

/// A removed pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Dropped {
    /// The pole at its removal, rad/s.
    pub lambda: Complex64,
    /// Reason for the removal.
    pub reason: DropReason,
}

/// Half-power bandwidth, lines, below which a pole at a multiple of the mains frequency is hum: 50
/// and 100 Hz in averaged records leave 0.02 and 0.07. Larger: modes with a third of a line, in
/// records that end early, may be left out. Smaller: hum is a mode
/// (`mains_hum_in_the_recordings_is_no_mode`).
const MAX_HUM_LINES: f64 = 0.1;
/// Mains frequencies, Hz, the highest multiple, and the largest deviation from it as a fraction:
/// that of a grid in normal operation is 0.001 (50 mHz at 50 Hz).
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const MAX_MAINS_MULTIPLE: f64 = 10.0;
const MAX_MAINS_DEVIATION: f64 = 1e-3;

/// Whether a pole is that of mains hum: without damping beside that of a window, at a multiple of a
/// mains frequency. `step`: spacing of the lines, rad/s.
pub(in crate::identify) fn is_mains_hum(pole: &ModelPole, added_damping: f64, step: f64) -> bool {
    let hz = pole.lambda.im / TAU;
    let is_multiple = |mains: &f64| {
        let multiple = (hz / mains).round();
        (1.0..=MAX_MAINS_MULTIPLE).contains(&multiple)
            && (hz - multiple * mains).abs() <= MAX_MAINS_DEVIATION * hz
    };
    // Less damping than that of the window is not determined, and no sign of hum.
    let decay = (pole.decay() - added_damping).abs() + 2.0 * pole.quality.pole_std;
    2.0 * decay < MAX_HUM_LINES * step && MAINS_HZ.iter().any(is_multiple)
}

/// Data and results from which the findings are made.
pub(in crate::identify) struct FindingContext<'a> {
    /// The FRFs before preparation.
    pub set: &'a FrfSet,
    /// Its receptances on band and guard lines.
    pub data: &'a FitData,
    /// Response of all poles and out-of-band terms.
    pub described: PredictedResponse<'a>,
    /// The requested band.
    pub band: Band,
    /// Peaks of the indicator.
    pub found: &'a DetectedPeaks,
    /// Reported modes.
    pub kept: &'a [(&'a ModelPole, &'a PoleMetrics)],
    /// The mean of each of their frequencies over runs that differ.
    pub means: &'a [Option<RunMean>],
    /// Each of them without the mass of a roving sensor, where that shifts the modes.
    pub unloaded: &'a [Option<Unloaded>],
    /// Poles of mains hum in the band.
    pub hum: &'a [&'a ModelPole],
    /// Poles removed during the fit.
    pub dropped: &'a [Dropped],
    /// Number of poles when their phases were found to be scattered.
    pub scattered: Option<usize>,
    /// Modes whose frequency shifts between runs.
    pub run_shifts: &'a RunShifts,
    /// Poles of modes that have companions, and how large these are.
    pub companions: &'a [(Complex64, f64)],
}

impl FindingContext<'_> {
    /// Findings of the modes in ascending frequency, then of removed poles and of peaks without a
    /// mode.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        if !self.data.noise.is_stated() {
            findings.push(Finding::new(
                Severity::Info,
                Code::NoiseFromFit,
                Location::Whole,
            ));
        }
        if self.data.frfs.line_shape.is_smoothed() {
            findings.push(Finding::new(
                Severity::Info,
                Code::WindowLineShape,
                Location::Whole,
            ));
        }
        if let Some(rate) = self.data.noise.unreported_window_decay(self.data.frfs.step) {
            let finding = Finding::new(Severity::Warning, Code::LinesShareNoise, Location::Whole);
            findings.push(match rate {
                Some(rate) => finding.value(rate, "1/s"),
                None => finding,
            });
        }
        if let Some(poles) = self.scattered {
            let finding = Finding::new(Severity::Warning, Code::PhasesScatter, Location::Whole);
            findings.push(finding.value(poles as f64, ""));
        }
        findings.extend(self.run_finding());
        findings.extend(self.misfit_findings());
        for ((pole, metrics), unloaded) in self.kept.iter().zip(self.unloaded) {
            findings.extend(self.mode_findings(pole, metrics, unloaded.as_ref()));
        }
        findings.extend(self.run_partner_findings());
        findings.extend(self.rejection_findings());
        findings.extend(self.hum.iter().map(|pole| self.hum_finding(pole)));
        findings.extend(self.peak_findings());
        findings
    }

    /// A pole of mains hum.
    fn hum_finding(&self, pole: &ModelPole) -> Finding {
        let decay = pole.decay() - self.set.added_damping_rad_s;
        let location = self.location(pole.lambda);
        Finding::new(Severity::Warning, Code::MainsHum, location)
            .value(2.0 * decay / self.data.frfs.step, "lines")
            .limit(MAX_HUM_LINES)
    }

    /// The run farthest from the others, where no check of the set reported it.
    fn run_finding(&self) -> Option<Finding> {
        let is_reported =
            |finding: &Finding| matches!(finding.code, Code::RunsDisagree | Code::MassLoading);
        if self.set.findings.iter().any(is_reported) {
            return None;
        }
        let away = self.run_shifts.outlying_run()?;
        let function = &self.set.functions()[away.function];
        let location = Location::Function {
            response: Some(function.response.clone()),
            reference: Some(function.reference.clone()),
        };
        let finding = Finding::new(Severity::Warning, Code::RunsDisagree, location);
        Some(
            finding
                .value(100.0 * away.shift, "%")
                .limit(100.0 * away.limit)
                .detail(shifted_run(self.set.functions(), away.function, away.omega)),
        )
    }

    /// Close modes that respond in separate runs.
    fn run_partner_findings(&self) -> Vec<Finding> {
        let kept: Vec<&ModelPole> = self.kept.iter().map(|(pole, _)| *pole).collect();
        let partners = run_partners(&kept, &by_point(self.set.functions())).into_iter();
        let finding = |(lambda, widths): (Complex64, f64)| {
            Finding::new(Severity::Warning, Code::RunsApart, self.location(lambda))
                .value(widths, "")
        };
        partners.map(finding).collect()
    }

    fn mode_findings(
        &self,
        pole: &ModelPole,
        metrics: &PoleMetrics,
        unloaded: Option<&Unloaded>,
    ) -> Vec<Finding> {
        let location = self.location(pole.lambda);
        let warning = |code, value: f64, unit: &str, limit: f64| {
            Finding::new(Severity::Warning, code, location.clone())
                .value(value, unit)
                .limit(limit)
        };
        let mut findings = Vec::new();
        let mean = self.mean(pole.lambda);
        let merged = self.run_shifts.of(pole.lambda);
        let scatter = mean
            .map(|mean| mean.scatter)
            .or(merged.map(|mode| mode.scatter));
        if let Some(scatter) = scatter {
            let code = match merged {
                Some(_) => Code::RunsMerged,
                None => Code::RunsScatter,
            };
            let finding = Finding::new(Severity::Warning, code, location.clone());
            findings.push(finding.value(100.0 * scatter / pole.lambda.im, "%"));
        }
        let change = unloaded.map(|unloaded| unloaded.change);
        if let Some(change) = change.filter(|change| *change > MAX_SHAPE_CHANGE) {
            findings.push(warning(Code::LoadedShape, change, "", MAX_SHAPE_CHANGE));
        }
        let multiplicity = unloaded.map_or(pole.multiplicity(), |unloaded| unloaded.multiplicity);
        if multiplicity > 1 {
            let finding = Finding::new(Severity::Info, Code::RepeatedRoot, location.clone());
            findings.push(finding.value(multiplicity as f64, ""));
        }
        let companion = self
            .companions
            .iter()
            .find(|(lambda, _)| *lambda == pole.lambda);
        if let Some((_, size)) = companion {
            let finding = Finding::new(
                Severity::Warning,
                Code::AmplitudeDependent,
                location.clone(),
            );
            findings.push(finding.value(*size, ""));
        }
        let decay = pole.decay() - self.set.added_damping_rad_s;
        let limit = MAX_BAND_DEVIATION_PERCENT;
        let percent = 100.0 * metrics.band_deviation / decay;
        if percent > limit && decay > 0.0 {
            findings.push(warning(Code::BandDependent, percent, "%", limit));
        } else if metrics.band_deviation > 0.0 && decay <= 0.0 {
            // The decay is that of the window: the damping is not determined.
            findings.push(Finding::new(
                Severity::Warning,
                Code::BandDependent,
                location.clone(),
            ));
        }
        let lines = pole.width() / self.data.frfs.step;
        if lines < MIN_LINES_PER_BANDWIDTH {
            findings.push(warning(Code::FewLines, lines, "", MIN_LINES_PER_BANDWIDTH));
        }
        findings.extend(reach(self.set, &self.data.frfs, pole.lambda, &location));
        findings
    }

    /// Rejected poles above the noise, with the last reason of each.
    fn rejection_findings(&self) -> Vec<Finding> {
        let mut reported: Vec<(Complex64, Finding)> = Vec::new();
        for dropped in self.dropped.iter().rev() {
            let DropReason::Rejected(rejection) = dropped.reason else {
                continue;
            };
            let lambda = dropped.lambda;
            let same = |(other, _): &(Complex64, Finding)| (other - lambda).norm() < -lambda.re;
            if !self.in_band(lambda) || reported.iter().any(same) {
                continue;
            }
            let (code, value, unit, limit) = match rejection {
                Rejection::LowContribution(share) => {
                    (Code::RootMinor, share, "", MIN_CONTRIBUTION_WITH_MISFIT)
                }
                Rejection::BelowLinearity(share, least) => (Code::RootMinor, share, "", least),
                Rejection::WrongPhase(phase) => (
                    Code::RootPhase,
                    phase.to_degrees(),
                    "°",
                    MAX_PHASE_DIFFERENCE_RAD.to_degrees(),
                ),
            };
            let finding = Finding::new(Severity::Info, code, self.location(lambda));
            reported.push((lambda, finding.value(value, unit).limit(limit)));
        }
        sort_ascending_by(&mut reported, |entry| entry.0.im);
        reported.into_iter().map(|(_, finding)| finding).collect()
    }

    /// Detected peaks without a mode, those whose pole was rejected among them.
    fn peak_findings(&self) -> Vec<Finding> {
        let found = self.found;
        let line = |line: usize| self.data.frfs.omega[line];
        let has_no_mode = |omega: f64| {
            let at = |width: f64, lambda: Complex64| {
                let reach = (PEAK_BANDWIDTHS * width).max(PEAK_LINES * self.data.frfs.step);
                (lambda.im - omega).abs() < reach
            };
            let inside = self.band.lo_hz * TAU <= omega && omega <= self.band.hi_hz * TAU;
            inside
                && !self
                    .kept
                    .iter()
                    .map(|(pole, _)| pole)
                    .chain(self.hum)
                    .any(|pole| at(pole.width(), pole.lambda))
        };
        let mut findings: Vec<Finding> = found
            .dropped
            .iter()
            .filter(|(peak, _)| has_no_mode(line(peak.line)))
            .map(|(peak, drop)| rejected_peak_finding(&self.data.frfs, peak, drop))
            .collect();
        let peaks = found.peaks.iter().map(|peak| line(peak.line));
        findings.extend(
            peaks
                .filter(|omega| has_no_mode(*omega))
                .map(|omega| self.peak_finding(omega)),
        );
        findings
    }

    /// The last removal near a peak without a mode.
    fn peak_finding(&self, omega: f64) -> Finding {
        let near = |dropped: &&Dropped| {
            let reach =
                (-2.0 * PEAK_BANDWIDTHS * dropped.lambda.re).max(PEAK_LINES * self.data.frfs.step);
            (dropped.lambda.im - omega).abs() < reach
        };
        let finding = Finding::new(
            Severity::Info,
            Code::PeakWithoutMode,
            Location::Mode(omega / TAU),
        );
        match self
            .dropped
            .iter()
            .rev()
            .find(near)
            .map(|dropped| dropped.reason)
        {
            Some(DropReason::BelowNoise(value, limit)) => finding.value(value, "").limit(limit),
            Some(DropReason::PoleUndetermined(value)) => finding.value(value, "decay rates"),
            Some(DropReason::NotSeparable(value)) => finding.value(value, "deviations"),
            Some(DropReason::NotResonant(value)) => finding.value(value, "Hz"),
            Some(DropReason::Rejected(_)) | None => finding,
        }
    }

    fn in_band(&self, lambda: Complex64) -> bool {
        let hz = lambda.norm() / TAU;
        self.band.lo_hz <= hz && hz <= self.band.hi_hz
    }

    /// The mean over runs of the frequency of a pole.
    fn mean(&self, lambda: Complex64) -> Option<RunMean> {
        let mut of_pole = self.kept.iter().zip(self.means);
        let found = of_pole.find(|((pole, _), _)| pole.lambda == lambda);
        found.and_then(|(_, mean)| *mean)
    }

    /// The row of a finding: the mode's frequency without the damping of the window.
    pub(in crate::identify) fn location(&self, lambda: Complex64) -> Location {
        let shift = self.mean(lambda).map_or(0.0, |mean| mean.shift);
        let lambda = lambda + Complex64::new(0.0, shift);
        let pole = Pole { lambda }.without_added_damping(self.set.added_damping_rad_s);
        Location::Mode(pole.natural_frequency_hz())
    }
}

//! FRF curves show selected FRFs on selected lines, with the curve of the identified modes.

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::linalg::{complex_matrix, least_squares};
use crate::modal::ModalModel;

use super::rounding::{rounded, to_decimals};

/// Maximum number of FRFs of one test that are shown.
pub(super) const MAX_FUNCTIONS: usize = 24;
/// Maximum number of lines on which the residual terms are fitted.
const MAX_FITTED_LINES: usize = 1000;
/// Minimum magnitude of a line, over the largest, whose error is relative.
const MIN_MAGNITUDE_RATIO: f64 = 1e-9;
/// Maximum number of lines around the circle of a mode.
const MAX_LINES_PER_CIRCLE: usize = 31;
/// Largest angle of these lines from the resonance, rad.
const MAX_ANGLE_RAD: f64 = 0.9 * std::f64::consts::PI;
/// Margin of curves beyond the band, as a fraction of its width.
const MARGIN_OVER_BAND: f64 = 0.15;

/// Functions of a test with the curves of its modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrfFigure {
    /// Frequency of line 0, Hz.
    pub start_hz: f64,
    /// Spacing of the lines, Hz.
    pub step_hz: f64,
    /// Band in which modes were identified, Hz.
    pub band_hz: [f64; 2],
    /// Number of functions of the test, of which `curves` holds some.
    pub functions: usize,
    /// Number of lines of the whole curve in the range that is shown.
    pub whole_lines: usize,
    /// The functions that are shown.
    pub curves: Vec<Curve>,
}

/// One FRF on the lines of the largest and smallest magnitude of each interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Response.
    pub response: String,
    /// Reference (hit).
    pub reference: String,
    /// Receptance, mobility or accelerance.
    pub kind: String,
    /// Its SI unit.
    pub unit: String,
    /// Lines, from 0.
    pub lines: Vec<usize>,
    /// Magnitude at these lines, SI.
    pub magnitude: Vec<f64>,
    /// Phase there, degrees, over -180 to 180.
    pub phase_deg: Vec<f64>,
    /// Magnitude of the identified modes with two residual terms; `None` outside the band. Empty
    /// where modes have no residues.
    pub fit_magnitude: Vec<Option<f64>>,
    /// Their phase, degrees.
    pub fit_phase_deg: Vec<Option<f64>>,
    /// Coherence; empty where it is not known.
    pub coherence: Vec<f64>,
}

/// The curves of a set with `points` points each; `None` for a set without a band.
pub(super) fn frf_figure(set: &FrfSet, modes: &ModalModel, points: usize) -> Option<FrfFigure> {
    let axis = set.axis();
    let band = modes.band.or(set.valid_band).or_else(|| axis.band())?;
    let reach = MARGIN_OVER_BAND * band.width_hz();
    let shown = Band::new((band.lo_hz - reach).max(0.0), band.hi_hz + reach).ok()?;
    let mut lines = axis.lines(&shown);
    lines.start = lines.start.max(usize::from(axis.start_hz <= 0.0));
    if lines.len() < 2 {
        return None;
    }
    let fitted = axis.lines(&band);
    let curve = |i: &usize| curve(set, *i, modes, &lines, &fitted, points);
    Some(FrfFigure {
        start_hz: axis.start_hz,
        step_hz: axis.step_hz,
        band_hz: [band.lo_hz, band.hi_hz],
        functions: set.len(),
        whole_lines: lines.len(),
        curves: shown_functions(set, &lines).iter().map(curve).collect(),
    })
}

/// Indices of the FRFs that are shown: all of a small set; of a large one driving points, then the
/// strongest, in the order of the set.
pub(super) fn shown_functions(set: &FrfSet, lines: &Range<usize>) -> Vec<usize> {
    let strength = |i: &usize| {
        let function = &set.functions()[*i];
        let d = 1 - function.kind.derivative_order();
        let value =
            |k: usize| set.values(*i)[k].norm_sqr() * set.axis().rad_s(k).max(1e-9).powi(2 * d);
        let sum: f64 = lines.clone().map(value).sum();
        let driving = function.response.positive() == function.reference.positive();
        (driving, sum)
    };
    let mut ranked: Vec<(usize, (bool, f64))> = (0..set.len()).map(|i| (i, strength(&i))).collect();
    ranked.sort_by(|(_, a), (_, b)| b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)));
    let mut kept: Vec<usize> = ranked.iter().map(|(i, _)| *i).take(MAX_FUNCTIONS).collect();
    kept.sort_unstable();
    kept
}

fn curve(
    set: &FrfSet,
    i: usize,
    modes: &ModalModel,
    lines: &Range<usize>,
    fitted: &Range<usize>,
    points: usize,
) -> Curve {
    let function = &set.functions()[i];
    let values = set.values(i);
    let magnitude: Vec<f64> = values.iter().map(|h| h.norm()).collect();
    let arcs = arc_lines(set, modes, lines, points / 2);
    let mut kept = kept_lines(&magnitude, lines.clone(), points - arcs.len());
    kept.extend(arcs);
    kept.sort_unstable();
    kept.dedup();
    let fit = fit(set, i, modes, fitted, &kept);
    let of_fit = |part: fn(Complex64) -> f64| {
        let each = fit.iter().map(|value| value.map(part));
        each.collect::<Vec<Option<f64>>>()
    };
    let degrees = |h: Complex64| to_decimals(h.arg().to_degrees(), 1);
    let coherence = set.coherence(i).map(|all| {
        let each = kept.iter().map(|k| to_decimals(all[*k], 3));
        each.collect()
    });
    Curve {
        response: function.response.to_string(),
        reference: function.reference.to_string(),
        kind: function.kind.to_string(),
        unit: function.kind.si_unit().to_owned(),
        magnitude: kept.iter().map(|k| rounded(magnitude[*k], 4)).collect(),
        phase_deg: kept.iter().map(|k| degrees(values[*k])).collect(),
        fit_magnitude: of_fit(|h| rounded(h.norm(), 4)),
        fit_phase_deg: of_fit(|h| to_decimals(h.arg().to_degrees(), 1)),
        coherence: coherence.unwrap_or_default(),
        lines: kept,
    }
}

/// Lines at even angles around the circle of each mode, `ω = ω_d + σ tan(θ/2)`, so that a Nyquist
/// diagram of thinned lines stays round: no more than `points` together, and none where all lines
/// are kept anyway.
fn arc_lines(set: &FrfSet, modes: &ModalModel, lines: &Range<usize>, points: usize) -> Vec<usize> {
    let steps = (points / modes.modes.len().max(1)).min(MAX_LINES_PER_CIRCLE);
    if lines.len() <= 2 * points || steps < 4 {
        return Vec::new();
    }
    let mut found = Vec::new();
    for pole in modes.modes.iter().filter_map(|mode| mode.pole()) {
        let decay = set.added_damping_rad_s - pole.lambda.re;
        for n in 0..steps {
            let angle = MAX_ANGLE_RAD * (2.0 * n as f64 / (steps - 1) as f64 - 1.0);
            let hz = (pole.lambda.im + decay * (0.5 * angle).tan()) / TAU;
            let line = (hz - set.axis().start_hz) / set.axis().step_hz;
            found.extend((line >= 0.0).then(|| line.round() as usize));
        }
    }
    found.retain(|line| lines.contains(line));
    found.sort_unstable();
    found.dedup();
    found
}

/// All lines where they are few; else the lines of the largest and smallest value of each interval,
/// and both ends.
pub(super) fn kept_lines(values: &[f64], lines: Range<usize>, points: usize) -> Vec<usize> {
    if lines.len() <= points.max(4) {
        return lines.collect();
    }
    let intervals = (points.saturating_sub(2) / 2).max(1);
    let edge = |n: usize| lines.start + n * lines.len() / intervals;
    let mut kept = vec![lines.start];
    for n in 0..intervals {
        let interval = edge(n)..edge(n + 1);
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        kept.extend(interval.clone().min_by(by_value));
        kept.extend(interval.max_by(by_value));
    }
    kept.push(lines.end - 1);
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Identified modes with two residual terms at the kept lines of the band: `s^d [Σ A/(s − λ) +
/// conj. + U + L/s²]`, `U` and `L` by least squares of relative errors over the band. Empty where a
/// mode has no residue of this function.
fn fit(
    set: &FrfSet,
    i: usize,
    modes: &ModalModel,
    band: &Range<usize>,
    kept: &[usize],
) -> Vec<Option<Complex64>> {
    let Some(terms) = modal_terms(set, i, modes) else {
        return Vec::new();
    };
    let d = set.functions()[i].kind.derivative_order();
    let s = |k: usize| Complex64::new(set.added_damping_rad_s, set.axis().rad_s(k));
    let modal = |s: Complex64| terms.iter().map(|term| term.value(s)).sum();
    let stride = band.len().div_ceil(MAX_FITTED_LINES).max(1);
    let used: Vec<usize> = band
        .clone()
        .step_by(stride)
        .filter(|k| s(*k).norm() > 0.0)
        .collect();
    let middle = used.get(used.len() / 2).map_or(1.0, |k| s(*k).norm());
    let [upper, lower] = if used.len() < 4 {
        [Complex64::ZERO; 2]
    } else {
        let receptance = |k: usize| set.values(i)[k] / s(k).powi(d);
        let at_line = |k: usize| -> Complex64 { modal(s(k)) };
        // Relative errors: with absolute ones the residual terms would fit the errors at the peaks,
        // at the cost of the lines between them.
        let size = |k: &usize| receptance(*k).norm() + at_line(*k).norm();
        let largest = used.iter().map(size).fold(0.0, f64::max);
        let least = (MIN_MAGNITUDE_RATIO * largest).max(f64::MIN_POSITIVE.sqrt());
        let size: Vec<f64> = used.iter().map(|k| size(k).max(least)).collect();
        let left = complex_matrix(used.len(), 2, |row, column| {
            let x = s(used[row]) / middle;
            let term = if column == 0 {
                Complex64::ONE
            } else {
                (x * x).inv()
            };
            term / size[row]
        });
        let right = complex_matrix(used.len(), 1, |row, _| {
            (receptance(used[row]) - at_line(used[row])) / size[row]
        });
        least_squares(&left, &right).map_or([Complex64::ZERO; 2], |solved| {
            [solved[(0, 0)], solved[(1, 0)]]
        })
    };
    let value = |k: &usize| {
        let s = s(*k);
        let modal: Complex64 = modal(s);
        let residual = upper + lower * middle * middle / (s * s);
        band.contains(k).then(|| (modal + residual) * s.powi(d))
    };
    kept.iter().map(value).collect()
}

/// Partial fraction of a mode in one FRF.
pub(super) struct ModalTerm {
    lambda: Complex64,
    residue: Complex64,
}

impl ModalTerm {
    /// `A/(s − λ) + A*/(s − λ*)`.
    pub(super) fn value(&self, s: Complex64) -> Complex64 {
        self.residue / (s - self.lambda) + self.conjugate_value(s)
    }

    /// `A*/(s − λ*)`.
    pub(super) fn conjugate_value(&self, s: Complex64) -> Complex64 {
        self.residue.conj() / (s - self.lambda.conj())
    }
}

/// The term of every mode in FRF `i`; `None` where a pole or residue is not known.
pub(super) fn modal_terms(set: &FrfSet, i: usize, modes: &ModalModel) -> Option<Vec<ModalTerm>> {
    let function = &set.functions()[i];
    let pair = (function.response.clone(), function.reference.clone());
    let term = |mode: &crate::modal::Mode| {
        Some(ModalTerm {
            residue: *mode.residues.get(&pair)?,
            lambda: mode.pole()?.lambda,
        })
    };
    modes.modes.iter().map(term).collect()
}

/// The only set of a test; a test on several axes is not fitted and not drawn.
pub(super) fn single_set(sets: &[FrfSet]) -> Option<&FrfSet> {
    match sets {
        [set] => Some(set),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::dof::Dof;
    use crate::frf::{Function, FunctionData, Residues, synthesise};
    use crate::modal::{Mode, ModeShape, Pole, Scaling};
    use crate::quantity::FrfKind;

    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.25,
        len: 2001,
    };

    fn dof(text: &str) -> Dof {
        text.parse().unwrap()
    }

    /// Two modes inside the band and one above it, as accelerances.
    fn measured(added: f64) -> (FrfSet, ModalModel) {
        let pair = (dof("1:+Z"), dof("2:+Z"));
        let mode = |hz: f64, residue: f64| {
            let residues = Residues::from([(pair.clone(), Complex64::new(0.0, -residue))]);
            (Pole::from_frequency(hz, 0.01), residues)
        };
        let all = [mode(100.0, 1e-3), mode(220.0, 2e-3), mode(900.0, 4e-3)];
        let terms: Vec<(Pole, &Residues)> = all.iter().map(|(p, r)| (*p, r)).collect();
        let pairs = [pair.clone()];
        let set = synthesise(&terms, AXIS, &pairs, FrfKind::Accelerance, added).unwrap();
        let known = all[..2].iter().map(|(pole, residues)| Mode {
            residues: residues.clone(),
            ..Mode::new(
                pole.natural_frequency_hz(),
                Some(pole.damping_ratio()),
                ModeShape::default(),
                Scaling::Unknown,
            )
        });
        let model = ModalModel {
            modes: known.collect(),
            band: Some(Band::new(50.0, 300.0).unwrap()),
            ..ModalModel::default()
        };
        (set, model)
    }

    #[test]
    fn the_curve_of_the_modes_follows_the_data_to_the_residual_of_what_lies_outside() {
        for added in [0.0, 3.0] {
            let (set, model) = measured(added);
            let figure = frf_figure(&set, &model, 300).unwrap();
            let curve = &figure.curves[0];
            assert_eq!(curve.fit_magnitude.len(), curve.lines.len());
            let largest = curve.magnitude.iter().copied().fold(0.0, f64::max);
            for (n, line) in curve.lines.iter().enumerate() {
                let hz = AXIS.hz(*line);
                let inside = (50.0..=300.0).contains(&hz);
                assert_eq!(curve.fit_magnitude[n].is_some(), inside, "{hz} Hz");
                // A mode at three times the band's end is a constant but for (300/900)² of it.
                if let Some(fit) = curve.fit_magnitude[n] {
                    assert!((fit - curve.magnitude[n]).abs() < 2e-3 * largest, "{hz} Hz");
                }
            }
        }
    }

    #[test]
    fn small_phase_errors_of_residues_keep_the_curve_between_the_peaks() {
        let (set, mut model) = measured(0.0);
        for mode in &mut model.modes {
            for residue in mode.residues.values_mut() {
                *residue *= Complex64::from_polar(1.0, 0.05);
            }
        }
        let figure = frf_figure(&set, &model, 2000).unwrap();
        let curve = &figure.curves[0];
        // With lines weighed by their absolute errors -0.048, -0.161 and 0.159.
        for hz in [50.0, 130.0, 300.0] {
            let n = curve
                .lines
                .iter()
                .position(|k| (AXIS.hz(*k) - hz).abs() < 1e-9)
                .unwrap();
            let error = curve.fit_magnitude[n].unwrap() / curve.magnitude[n] - 1.0;
            assert!(error.abs() < 0.06, "{hz} Hz: {error}");
        }
    }

    #[test]
    fn circles_of_thinned_curves_keep_lines_all_around() {
        let (set, model) = measured(0.0);
        let figure = frf_figure(&set, &model, 120).unwrap();
        let curve = &figure.curves[0];
        assert!(curve.lines.len() <= 120, "{}", curve.lines.len());
        // Half-power width of the mode at 220 Hz: 4.4 Hz, 17 lines, of which 60 points could
        // keep 2.
        let near = curve
            .lines
            .iter()
            .filter(|k| (AXIS.hz(**k) - 220.0).abs() <= 2.2);
        assert!(near.count() >= 12);
    }

    #[test]
    fn without_residues_no_curve_is_drawn() {
        let (set, mut model) = measured(0.0);
        model.modes[1].residues.clear();
        let figure = frf_figure(&set, &model, 300).unwrap();
        assert!(figure.curves[0].fit_magnitude.is_empty());
    }

    #[test]
    fn thinned_lines_keep_every_peak_and_every_dip() {
        let mut values = vec![1.0; 5000];
        for (place, value) in [(700, 9.0), (701, 0.1), (4999, 3.0), (2500, 7.0)] {
            values[place] = value;
        }
        let kept = kept_lines(&values, 10..5000, 100);
        assert!(kept.len() <= 100 && kept.windows(2).all(|two| two[0] < two[1]));
        for place in [10, 700, 701, 2500, 4999] {
            assert!(kept.contains(&place), "{place}");
        }
        assert_eq!(kept_lines(&values, 3..60, 100), (3..60).collect::<Vec<_>>());
    }

    #[test]
    fn of_a_large_set_driving_points_and_the_strongest_are_shown() {
        let mut set = FrfSet::new(AXIS);
        for n in 1..=40 {
            let function = Function {
                response: dof(&format!("{n}:+Z")),
                reference: dof("7:-Z"),
                kind: FrfKind::Mobility,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let size = if n == 7 { 1e-3 } else { f64::from(n) };
            let values = vec![Complex64::new(size, 0.0); AXIS.len];
            let data = FunctionData {
                values,
                ..FunctionData::default()
            };
            set.push(function, data).unwrap();
        }
        let expected: Vec<usize> = [6].into_iter().chain(17..40).collect();
        assert_eq!(shown_functions(&set, &(1..100)), expected);
    }
}

//! The mass line of each FRF: the part of the accelerance that is constant between the modes of the
//! suspension and the first elastic mode.
//!
//! The real part of the accelerance is fitted by the mass line and terms of the modes on both
//! sides, of which the nearest have their poles: plain powers of the frequency up to the fourth
//! would bias the mass by half its deviation.

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::frf::peaks::clear_peaks;
use crate::linalg::{RealMatrix, real_matrix, solve_definite};

/// Lower end of the band over the frequency of the suspension's highest clear peak. Smaller, at
/// 1.2: the mass is wrong by more than its deviation
/// (`a_suspension_without_clear_peaks_does_not_bias_the_mass`). Larger, at 6: few gains
/// are seen (`a_wrong_sensor_is_named_and_repaired`).
const ABOVE_SUSPENSION: f64 = 3.5;
/// Upper end of the band over the frequency of the first elastic mode. Larger, at 0.6: higher modes
/// bias the mass by more than its deviation (`modes_beside_the_band_do_not_bias_the_mass`).
/// Smaller, at 0.3: few gains are seen (`a_wrong_sensor_is_named_and_repaired`).
const BELOW_ELASTIC: f64 = 0.45;
/// Least ratio of the ends of the band. Smaller, at 1.2: a band between two modes of the suspension
/// is taken. Larger, at 3: a suspension at a twentieth of the first elastic mode has no band
/// (`a_band_between_modes_of_the_suspension_is_no_mass_line`).
const MIN_BAND_RATIO: f64 = 1.6;
/// Fewest lines.
const MIN_LINES: usize = 8;
/// Height of a peak over the lower quartile of the mean accelerance in the valid band that makes it
/// a mode, as power. Larger, at 200: of 40 tests one has a mass instead of 15
/// (`the_mass_has_its_stated_deviation`). Smaller: noise has peaks, at 1 none in
/// these tests.
const MIN_PEAK_OVER_LOWER_QUARTILE: f64 = 4.0;
/// Deviations of the residual over its freedom from 1 beyond which stated variances are too small.
/// Smaller, at 0: the scatter of the residual alone enlarges half of the variances. Larger, at 100:
/// variances stated as a third stay (`stated_variances_hold_where_the_residual_agrees`).
const MAX_EXCESS_DEVIATIONS: f64 = 3.0;
/// Root mean square of the suspension's terms at the lower end of the band over that of the mass
/// lines, up to which they give a mass; with the highest mode at `lo_hz / ABOVE_SUSPENSION` it is
/// about a twelfth. Larger, at 1: a band that begins below a mode without a clear peak gives a mass
/// that is wrong by four deviations (`a_suspension_without_clear_peaks_does_not_bias_the_mass`).
/// Smaller, at 0.02: no mass is left (`the_mass_has_its_stated_deviation`).
const MAX_SUSPENSION_PART: f64 = 0.3;
/// Terms of the accelerance.
const TERMS: usize = 5;
/// Those of the suspension.
const SUSPENSION_TERMS: [usize; 2] = [2, 4];

/// The constant accelerance of one FRF with its variance, m/s² per N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MassLine {
    pub value: f64,
    pub variance: f64,
}

/// The band of the mass line, with the modes on both sides of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MassLineBand {
    band: Band,
    /// The highest clear peak below it.
    suspension_hz: Option<f64>,
    /// The lowest clear peak above it.
    elastic_hz: Option<f64>,
}

impl MassLineBand {
    /// The terms of the accelerance at a frequency.
    ///
    /// The rigid body gives 1. An elastic mode at `ω_1` gives `ω²/(ω_1² − ω²)`, which is `ω²` and
    /// `ω⁴/(1 − (ω/ω_1)²)` with factors; modes above the first one add little to the second term.
    /// A mode of the suspension at `ω_s` gives `ω²/(ω² − ω_s²)`, which is 1, `ω⁻²` and
    /// `ω⁻⁴/(1 − (ω_s/ω)²)`. Frequencies are over `middle_hz`.
    fn terms(&self, hz: f64, middle_hz: f64) -> [f64; TERMS] {
        let square = (hz / middle_hz).powi(2);
        let above = self.elastic_hz.map_or(0.0, |mode| (hz / mode).powi(2));
        let below = self.suspension_hz.map_or(0.0, |mode| (mode / hz).powi(2));
        let (elastic, suspension) = (square * square, (square * square).recip());
        [
            1.0,
            square,
            square.recip(),
            elastic / (1.0 - above),
            suspension / (1.0 - below),
        ]
    }
}

/// The band between the suspension and the first elastic mode: below the lowest clear peak of the
/// mean accelerance that is far enough above the one before.
fn find_band(set: &FrfSet) -> Option<MassLineBand> {
    let axis = set.axis();
    let first = (0..axis.len).find(|k| axis.hz(*k) > 0.0)?;
    let usable_hz = set.valid_band.map_or(axis.hz(first), |band| band.lo_hz);
    let mut suspension_hz = None;
    for elastic_hz in peaks_hz(set)? {
        let lo_hz = suspension_hz.map_or(usable_hz, |hz: f64| usable_hz.max(ABOVE_SUSPENSION * hz));
        let band = Band::new(lo_hz, BELOW_ELASTIC * elastic_hz).ok();
        let is_wide = |band: &Band| {
            band.hi_hz >= MIN_BAND_RATIO * band.lo_hz && axis.lines(band).len() >= MIN_LINES
        };
        if let Some(band) = band.filter(is_wide) {
            return Some(MassLineBand {
                band,
                suspension_hz,
                elastic_hz: Some(elastic_hz),
            });
        }
        suspension_hz = Some(elastic_hz);
    }
    None
}

/// Clear peaks of the mean accelerance on both sides of a mass line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeighbouringPeaks {
    /// The highest below its band, Hz. A mode of the suspension above it may have no clear peak.
    pub below_hz: Option<f64>,
    /// The lowest above its band, Hz.
    pub above_hz: Option<f64>,
}

/// The peaks on both sides of the band.
pub(super) fn find_neighbouring_peaks(set: &FrfSet) -> NeighbouringPeaks {
    let band = find_band(set);
    NeighbouringPeaks {
        below_hz: band.and_then(|band| band.suspension_hz),
        above_hz: band.and_then(|band| band.elastic_hz),
    }
}

/// Frequencies of the clear peaks of the mean accelerance, up to the end of the valid band: above
/// it the force is too weak, and noise has peaks.
pub(super) fn peaks_hz(set: &FrfSet) -> Option<Vec<f64>> {
    let axis = set.axis();
    let first = (0..axis.len).find(|k| axis.hz(*k) > 0.0)?;
    let valid = match set.valid_band {
        Some(band) => axis.lines(&band),
        None => first..axis.len,
    };
    let (lowest, end) = (valid.start.max(first), valid.end);
    let power: Vec<f64> = (first..end)
        .map(|k| (0..set.len()).map(|i| accelerance_power(set, i, k)).sum())
        .collect();
    let mut sorted = power.get(lowest - first..)?.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let floor = MIN_PEAK_OVER_LOWER_QUARTILE * sorted.get(sorted.len() / 4)?;
    let peaks = clear_peaks(&power, &vec![floor; power.len()], 0.0);
    let hz = |line: usize| axis.hz(first + line);
    Some(peaks.iter().map(|peak| hz(peak.line)).collect())
}

fn accelerance_power(set: &FrfSet, i: usize, k: usize) -> f64 {
    let order = set.functions()[i].kind.derivative_order();
    set.values(i)[k].norm_sqr() * set.axis().rad_s(k).powi(2 * (2 - order))
}

/// The mass lines of the FRFs of a set, in their order, with the band that was used.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MassLines {
    pub band: Band,
    pub lines: Vec<MassLine>,
    /// Whether modes of the suspension without a clear peak are in the band. Sensors move as a
    /// rigid body in these too, but the mass would be wrong.
    pub has_suspension: bool,
}

/// The mass line of every FRF in the band between suspension and first elastic mode. Below the
/// first mode of a structure that stands on the ground there is none.
pub(super) fn find_mass_lines(set: &FrfSet) -> Option<MassLines> {
    let band = find_band(set)?;
    let fitted = fit(set, &band)?;
    fitted.has_mass_line.then_some(MassLines {
        band: band.band,
        lines: fitted.lines,
        has_suspension: fitted.suspension_part > MAX_SUSPENSION_PART,
    })
}

/// The terms of the accelerance of every FRF.
struct Fit {
    lines: Vec<MassLine>,
    /// Root mean square of the terms of the suspension at the lower end of the band over that of
    /// the mass lines.
    suspension_part: f64,
    /// Whether the mass lines are larger than all other terms in the middle of the band.
    has_mass_line: bool,
}

/// Least squares of the real part of the accelerances with the variances of the set, or with those
/// of the residuals where it states none.
fn fit(set: &FrfSet, band: &MassLineBand) -> Option<Fit> {
    let axis = set.axis();
    let lines = axis.lines(&band.band);
    if lines.len() < MIN_LINES {
        return None;
    }
    let middle_hz = axis.hz(lines.start + lines.len() / 2);
    let of_lines: Vec<[f64; TERMS]> = lines
        .clone()
        .map(|line| band.terms(axis.hz(line), middle_hz))
        .collect();
    let basis = real_matrix(lines.len(), TERMS, |line, term| of_lines[line][term]);
    let fitted: Option<Vec<FittedTerms>> = (0..set.len())
        .map(|i| fit_terms(set, i, lines.start, &basis))
        .collect();
    let fitted = fitted?;
    let sum = |value: &dyn Fn(&FittedTerms) -> f64| -> f64 {
        fitted.iter().map(|terms| value(terms).powi(2)).sum()
    };
    let at = |terms: &FittedTerms, line: usize, of: &[usize]| -> f64 {
        of.iter()
            .map(|term| basis[(line, *term)] * terms.coefficients[*term])
            .sum()
    };
    let constant = sum(&|terms| terms.coefficients[0]);
    let suspension = sum(&|terms| at(terms, 0, &SUSPENSION_TERMS));
    let others = sum(&|terms| terms.coefficients[1..].iter().sum());
    Some(Fit {
        suspension_part: (suspension / constant).sqrt(),
        has_mass_line: constant > others,
        lines: fitted.into_iter().map(|terms| terms.line).collect(),
    })
}

/// The fitted terms of an FRF, and its mass line.
struct FittedTerms {
    coefficients: [f64; TERMS],
    line: MassLine,
}

fn fit_terms(set: &FrfSet, i: usize, first: usize, basis: &RealMatrix) -> Option<FittedTerms> {
    let order = set.functions()[i].kind.derivative_order();
    let count = basis.nrows();
    let scale = |line: usize| {
        let omega = set.axis().rad_s(first + line);
        num_complex::Complex64::new(set.added_damping_rad_s, omega).powi(2 - order)
    };
    let value = |line: usize| (set.values(i)[first + line] * scale(line)).re;
    let stated = set.variance(i).map(|variance| {
        let of_real = |line| (0.5 * variance[first + line] * scale(line).norm_sqr()).max(0.0);
        (0..count).map(of_real).collect::<Vec<f64>>()
    });
    let stated = stated.filter(|variance| variance.iter().all(|v| *v > 0.0 && v.is_finite()));
    let weight = |line: usize| {
        stated
            .as_ref()
            .map_or(1.0, |variance| variance[line].recip())
    };
    let terms = TERMS;
    let normal = real_matrix(terms, terms, |a, b| {
        (0..count)
            .map(|l| weight(l) * basis[(l, a)] * basis[(l, b)])
            .sum()
    });
    let right = real_matrix(terms, 1 + terms, |a, column| match column {
        0 => (0..count)
            .map(|l| weight(l) * basis[(l, a)] * value(l))
            .sum(),
        column => f64::from(u8::from(column == a + 1)),
    });
    let solved = solve_definite(&normal, &right).ok()?;
    let fitted = |line: usize| {
        (0..terms)
            .map(|a| basis[(line, a)] * solved[(a, 0)])
            .sum::<f64>()
    };
    let residual: f64 = (0..count)
        .map(|line| weight(line) * (value(line) - fitted(line)).powi(2))
        .sum();
    let freedom = (count - terms) as f64;
    let per_freedom = residual / freedom;
    // Stated variances that the fit contradicts are too small.
    let is_contradicted = per_freedom > 1.0 + MAX_EXCESS_DEVIATIONS * (2.0 / freedom).sqrt();
    let excess = match stated.is_some() && !is_contradicted {
        true => 1.0,
        false => per_freedom,
    };
    let line = MassLine {
        value: solved[(0, 0)],
        variance: excess * solved[(0, 1)],
    };
    Some(FittedTerms {
        coefficients: std::array::from_fn(|term| solved[(term, 0)]),
        line,
    })
}

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
/// Least ratio of the ends of the band.
const MIN_BAND_RATIO: f64 = 1.6;
/// Fewest lines.
const MIN_LINES: usize = 8;
/// Height of a peak over the median of the mean accelerance that makes it a mode, as power.
const PEAK_OVER_MEDIAN: f64 = 4.0;
/// Deviations of the residual over its freedom from 1 beyond which stated variances are too small.
/// Smaller, at 0: the scatter of the residual alone enlarges half of the variances. Larger, at 100:
/// variances stated as a third stay (`stated_variances_hold_where_the_residual_agrees`).
const MAX_EXCESS_DEVIATIONS: f64 = 3.0;
/// Root mean square of the suspension's terms at the lower end of the band over that of the mass
/// lines; with the highest mode at `lo_hz / ABOVE_SUSPENSION` it is about a twelfth. Larger, at 1:
/// a band that begins below a mode without a clear peak gives a mass that is wrong by several
/// deviations (`a_suspension_without_clear_peaks_does_not_bias_the_mass`). Smaller, at 0.02: bands
/// are narrowed until few are left (`the_mass_has_its_stated_deviation`).
const MAX_SUSPENSION_PART: f64 = 0.3;
/// Factor of the lower end of the band where they are larger.
const RAISE_OF_BAND: f64 = 1.2;
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
    /// A stated band, with the modes of these FRFs on both sides of it.
    fn stated(set: &FrfSet, band: Band) -> Self {
        let peaks = peaks_hz(set).unwrap_or_default();
        Self {
            band,
            suspension_hz: peaks.iter().copied().rfind(|hz| *hz < band.lo_hz),
            elastic_hz: peaks.iter().copied().find(|hz| *hz > band.hi_hz),
        }
    }

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

/// Modes of a suspended structure on both sides of its mass line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuspensionModes {
    /// Highest mode of the suspension, Hz: the stated one, else the highest clear peak below the
    /// band of the mass line.
    pub rigid_body_hz: Option<f64>,
    /// First elastic mode, Hz: the lowest clear peak above.
    pub elastic_hz: Option<f64>,
}

/// The modes on both sides of the band.
pub(super) fn find_suspension_modes(set: &FrfSet) -> SuspensionModes {
    let band = find_band(set);
    SuspensionModes {
        rigid_body_hz: band.and_then(|band| band.suspension_hz),
        elastic_hz: band.and_then(|band| band.elastic_hz),
    }
}

/// Frequencies of the clear peaks of the mean accelerance.
pub(super) fn peaks_hz(set: &FrfSet) -> Option<Vec<f64>> {
    let axis = set.axis();
    let first = (0..axis.len).find(|k| axis.hz(*k) > 0.0)?;
    let power: Vec<f64> = (first..axis.len)
        .map(|k| (0..set.len()).map(|i| accelerance_power(set, i, k)).sum())
        .collect();
    let mut sorted = power.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let floor = PEAK_OVER_MEDIAN * sorted.get(sorted.len() / 4)?;
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
}

/// The mass line of every FRF in the band between suspension and first elastic mode. Where modes of
/// the suspension have no clear peak, its terms are large at the lower end, which is raised until
/// they are small.
pub(super) fn find_mass_lines(set: &FrfSet) -> Option<MassLines> {
    let mut band = find_band(set)?;
    loop {
        let fitted = fit(set, &band)?;
        if fitted.suspension_part <= MAX_SUSPENSION_PART {
            return fitted.checked(band.band);
        }
        let lo_hz = RAISE_OF_BAND * band.band.lo_hz;
        if band.band.hi_hz < MIN_BAND_RATIO * lo_hz {
            return None;
        }
        band.band = Band::new(lo_hz, band.band.hi_hz).ok()?;
    }
}

/// The mass line of every FRF in a stated band.
pub(super) fn stated_mass_lines(set: &FrfSet, band: Band) -> Option<MassLines> {
    fit(set, &MassLineBand::stated(set, band))?.checked(band)
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

impl Fit {
    /// Below the first mode of a structure that stands on the ground there is no mass line.
    fn checked(self, band: Band) -> Option<MassLines> {
        let lines = self.lines;
        self.has_mass_line.then_some(MassLines { band, lines })
    }
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

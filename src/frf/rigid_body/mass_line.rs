//! The mass line of each FRF: the part of the accelerance that is constant between the modes of the
//! suspension and the first elastic mode.

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::frf::peaks::clear_peaks;
use crate::linalg::{RealMatrix, real_matrix, solve_definite};

/// Frequency above the highest mode of the suspension, over it. Smaller: terms of its series beyond
/// `(f_s/f)⁴` count. Larger: few lines are left.
const ABOVE_SUSPENSION: f64 = 3.5;
/// Frequency below the first elastic mode, over it. Larger: terms of its series beyond `(f/f_1)⁴`
/// count. Smaller: few lines are left.
const BELOW_ELASTIC: f64 = 0.4;
/// Least ratio of the ends of the band.
const MIN_BAND_RATIO: f64 = 1.6;
/// Fewest lines.
const MIN_LINES: usize = 8;
/// Height of a peak over the median of the mean accelerance that makes it a mode, as power.
const PEAK_OVER_MEDIAN: f64 = 4.0;
/// Terms of the accelerance: the rigid body, elastic modes above (ω², ω⁴), the suspension below
/// (ω⁻², ω⁻⁴).
const POWERS: [i32; 5] = [0, 2, -2, 4, -4];

/// The constant accelerance of one FRF with its variance, m/s² per N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MassLine {
    pub value: f64,
    pub variance: f64,
}

/// The band between the suspension and the first elastic mode: below the lowest clear peak of the
/// mean accelerance that is far enough above the one before.
pub(super) fn find_band(set: &FrfSet) -> Option<Band> {
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
    let usable = set.valid_band.map_or(hz(0), |band| band.lo_hz);
    let mut below = usable / ABOVE_SUSPENSION;
    for peak in peaks {
        let (lo_hz, hi_hz) = (ABOVE_SUSPENSION * below, BELOW_ELASTIC * hz(peak.line));
        let band = Band::new(lo_hz, hi_hz).ok();
        let is_wide = |band: &Band| {
            band.hi_hz >= MIN_BAND_RATIO * band.lo_hz && axis.lines(band).len() >= MIN_LINES
        };
        if let Some(band) = band.filter(is_wide) {
            return Some(band);
        }
        below = hz(peak.line);
    }
    None
}

fn accelerance_power(set: &FrfSet, i: usize, k: usize) -> f64 {
    let order = set.functions()[i].kind.derivative_order();
    set.values(i)[k].norm_sqr() * set.axis().rad_s(k).powi(2 * (2 - order))
}

/// The mass line of every FRF of a set, by least squares of the real part of its accelerance with
/// the variances of the set, or with that of its residual where it states none.
pub(super) fn mass_lines(set: &FrfSet, band: Band) -> Option<Vec<MassLine>> {
    let axis = set.axis();
    let lines = axis.lines(&band);
    if lines.len() < MIN_LINES {
        return None;
    }
    let middle = axis.rad_s(lines.start + lines.len() / 2);
    let basis = real_matrix(lines.len(), POWERS.len(), |line, term| {
        (axis.rad_s(lines.start + line) / middle).powi(POWERS[term])
    });
    let fitted: Option<Vec<(MassLine, f64)>> = (0..set.len())
        .map(|i| mass_line(set, i, lines.start, &basis))
        .collect();
    let fitted = fitted?;
    let constant: f64 = fitted.iter().map(|(line, _)| line.value * line.value).sum();
    let rest: f64 = fitted.iter().map(|(_, rest)| rest * rest).sum();
    // Below the first mode of a structure that stands on the ground there is no mass line.
    (constant > rest).then(|| fitted.into_iter().map(|(line, _)| line).collect())
}

/// The mass line of an FRF, and the other terms in the middle of the band.
fn mass_line(set: &FrfSet, i: usize, first: usize, basis: &RealMatrix) -> Option<(MassLine, f64)> {
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
    let terms = POWERS.len();
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
    // Stated variances that the fit contradicts are too small.
    let per_freedom = residual / (count - terms) as f64;
    let excess = if stated.is_some() {
        per_freedom.max(1.0)
    } else {
        per_freedom
    };
    let line = MassLine {
        value: solved[(0, 0)],
        variance: excess * solved[(0, 1)],
    };
    let rest = (1..terms).map(|a| solved[(a, 0)]).sum();
    Some((line, rest))
}

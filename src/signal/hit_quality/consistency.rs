//! Consistency of the hits of a series: the level of a hit, and its FRF beside those of the others.

use num_complex::Complex64;

use super::{Check, HitQualityLimits, Outcome, Rule};

/// Fewest hits of which one can be far from the median.
const MIN_HITS_FOR_LEVEL: usize = 3;
/// Fewest hits of which one can be rejected as odd: the others then show their scatter with two
/// degrees of freedom.
const MIN_HITS_FOR_CONSISTENCY: usize = 4;

/// Peak force of each hit over the median of the series, one check per hit; the signs do not
/// matter.
///
/// Noted beyond a factor (structures and noise are not linear), rejected beyond a larger one, see
/// [`HitQualityLimits`].
pub fn assess_levels(peaks_n: &[f64], limits: &HitQualityLimits) -> Vec<Check> {
    let sizes: Vec<f64> = peaks_n.iter().map(|p| p.abs()).collect();
    let middle = median(&sizes);
    let assess = |size: &f64| {
        let value = size / middle;
        let factor = value.max(1.0 / value);
        // A comparison with NaN (all peaks 0) is false: not decidable.
        let outcome = if sizes.len() < MIN_HITS_FOR_LEVEL || factor.is_nan() {
            Outcome::NotDecidable
        } else if factor > limits.level_rejected {
            Outcome::Rejected
        } else if factor > limits.level_noted {
            Outcome::Noted
        } else {
            Outcome::Passed
        };
        let check = Check::new(Rule::Level, outcome);
        if value.is_finite() {
            check.value(value, limits.level_noted, "")
        } else {
            check
        }
    };
    sizes.iter().map(assess).collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 0 => 0.5 * (sorted[half - 1] + sorted[half]),
        _ => sorted[half],
    }
}

/// Each hit's response against what H1 of the other hits makes of its force, one check per hit.
///
/// `force[i]` and `response[i]` are spectra of hit i at the usable lines. With `H` and `S = Σ|F|²`
/// from the other hits, `e_i = X_i - H F_i` has `1 + |F_i|²/S` times the variance of the noise,
/// which the others show as `Q/(n-2)`, `Q` their residual. The value is
///
/// `R = (n-2) Σ_k |e_i|²/(1 + |F_i|²/S) / Σ_k Q`,
///
/// the sums over lines, so that lines count by their energy. The number of independent lines is
/// unknown (a hit beside its point differs at all lines at once), so the minimum is taken: `F(2,
/// 2(n-2))`, exact for a scatter that is one complex Gaussian factor of a common shape, and further
/// from the limit for any that is not. Its quantile is `(n-2) (p^(-1/(n-2)) - 1)`, p the allowed
/// false alarms over n. A hit is rejected when R is beyond it and `Σ|e_i|² > d² Σ|X_i|²`, d the
/// least difference that matters. Three hits are not decidable, and of fewer nothing is measured.
///
/// # Reference
/// Bendat and Piersol (2010), Random Data, 4th ed., section 9.1 (variance of H); Johnson, Kotz and
/// Balakrishnan (1995), Continuous Univariate Distributions 2, chapter 27 (F with two degrees of
/// freedom in closed form).
pub fn inconsistent_hits(
    force: &[&[Complex64]],
    response: &[&[Complex64]],
    limits: &HitQualityLimits,
) -> Vec<Check> {
    let n = force.len().min(response.len());
    let others = n.saturating_sub(2) as f64;
    let assess = |residual: Option<Residual>| {
        let Some(residual) = residual else {
            return Check::new(Rule::InconsistentHit, Outcome::NotDecidable);
        };
        let limit =
            others * ((limits.inconsistency_false_alarms / n as f64).powf(-1.0 / others) - 1.0);
        let outcome = if n < MIN_HITS_FOR_CONSISTENCY {
            Outcome::NotDecidable
        } else if residual.ratio <= limit {
            Outcome::Passed
        } else if residual.difference > limits.inconsistent_difference {
            Outcome::Rejected
        } else {
            Outcome::Noted
        };
        Check::new(Rule::InconsistentHit, outcome).value(residual.ratio, limit, "")
    };
    let residuals = residuals(&force[..n], &response[..n]);
    residuals.into_iter().map(assess).collect()
}

struct Residual {
    /// R of [`inconsistent_hits`].
    ratio: f64,
    /// `sqrt(Σ|e|²/Σ|X|²)`.
    difference: f64,
}

/// Sums of spectra over some hits at a line.
#[derive(Clone, Copy, Default)]
struct LineSums {
    /// `Σ|F|²`.
    force: f64,
    /// `Σ conj(F) X`.
    cross: Complex64,
    /// `Σ|X|²`.
    response: f64,
}

impl LineSums {
    fn of(force: Complex64, response: Complex64) -> Self {
        Self {
            force: force.norm_sqr(),
            cross: force.conj() * response,
            response: response.norm_sqr(),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            force: self.force + other.force,
            cross: self.cross + other.cross,
            response: self.response + other.response,
        }
    }
}

/// The sums over lines of one hit.
#[derive(Clone, Copy, Default)]
struct HitSums {
    /// `Σ_k |e|²/(1 + |F|²/S)`.
    deleted: f64,
    /// `Σ_k |e|²`.
    residual: f64,
    /// `Σ_k |X|²`.
    response: f64,
    /// `Σ_k Q`.
    others: f64,
}

/// The residual of each hit; `None` for fewer than three hits, and where nothing scatters or
/// nothing is there.
///
/// The sums over the others are those of the hits before and after it, added: a difference from the
/// sum of all would leave its rounding, and a sum for each hit takes the square of their number.
fn residuals(force: &[&[Complex64]], response: &[&[Complex64]]) -> Vec<Option<Residual>> {
    let n = force.len();
    let lines = force.iter().chain(response).map(|x| x.len()).min();
    let lines = lines.filter(|_| n >= 3).unwrap_or(0);
    let mut sums = vec![HitSums::default(); n];
    let mut after = vec![LineSums::default(); n + 1];
    for k in 0..lines {
        for hit in (0..n).rev() {
            after[hit] = after[hit + 1].plus(LineSums::of(force[hit][k], response[hit][k]));
        }
        let mut before = LineSums::default();
        for (hit, sums) in sums.iter_mut().enumerate() {
            let others = before.plus(after[hit + 1]);
            let (f, x) = (force[hit][k], response[hit][k]);
            before = before.plus(LineSums::of(f, x));
            if others.force <= 0.0 {
                continue;
            }
            let e = (x - others.cross / others.force * f).norm_sqr();
            sums.deleted += e / (1.0 + f.norm_sqr() / others.force);
            sums.residual += e;
            sums.response += x.norm_sqr();
            sums.others += (others.response - others.cross.norm_sqr() / others.force).max(0.0);
        }
    }
    let residual = |sums: &HitSums| {
        let ratio = n.saturating_sub(2) as f64 * sums.deleted / sums.others;
        let difference = (sums.residual / sums.response).sqrt();
        let is_known = ratio.is_finite() && difference.is_finite();
        is_known.then_some(Residual { ratio, difference })
    };
    sums.iter().map(residual).collect()
}

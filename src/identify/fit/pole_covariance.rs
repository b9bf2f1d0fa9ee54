//! What noise does to the poles of a fit, as it is: hanging together over the lines, going with the
//! response, shared by functions.
//!
//! A fit weights its lines as if noise were white and every function's own, with a level for each
//! function and a course `c_k` over the lines. To first order it moves a pole by
//!
//! ```text
//! δλ = Σ_f Σ_k conj(w_fk) ε_fk      w_fk = a_f g_k / (W l_f² c_k)      W = |g|² Σ_f |a_f|²/l_f²
//! ```
//!
//! with the residues a, the levels l, and g what background and the poles around leave of `1/(iω −
//! λ)²` over the course. Noise of the response has the variance `(1 − p) v` and is every function's
//! own; that of the force, `p v`, is an error `e H`, which functions of one hit point share in
//! part. Both hang together over the lines by `ρ(k − l)`, so that
//!
//! ```text
//! E|Σ conj(u_k) n_k|² = Σ_t s_t |Σ_k u_k e^(2πikt/N)|²      s_t = Σ_m ρ(m) e^(2πimt/N) / N
//! ```
//!
//! which is the noise's course over the record weighted with what the pole takes of it.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;
use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::model_pole::Root;
use crate::identify::data::out_of_band_basis::Background;
use crate::identify::data::residual::Rest;
use crate::identify::fit::block_descent::window;
use crate::identify::ml::estimator::Fit;
use crate::identify::noise::band_profile::Profile;
use crate::identify::noise::line_correlation::Correlation;

/// Half-power bandwidths on either side in which the common error of the functions is estimated
/// from the residual, and fewest lines: within 2 the fit leaves too few values, beyond 5 other
/// noise is more than that of the resonance.
const ALONG_HALF_POWER_WIDTHS: f64 = 3.0;
const MIN_ALONG_LINES: usize = 6;
/// Complex values that the fit took of them: pole, residue, constant and slope.
const FITTED: f64 = 4.0;
/// Fewest degrees of freedom: a Student variable of 3 has a variance of 3; of 2 and fewer, none.
const MIN_FREEDOM: f64 = 3.0;
/// Least part of the derivative's course that nothing else explains.
const OWN: f64 = 1e-6;

impl Fit {
    /// Deviations of the poles with the noise as it is.
    pub fn reckon_with_noise(&mut self) {
        let rest = self.data.line_shape.is_smoothed().then(|| self.rest());
        let factor = |root: &Root| {
            let along = rest
                .as_ref()
                .map(|rest| power_along(&self.data, rest, root));
            raised(&self.data, &self.roots, (root, along.unwrap_or(0.0)))
        };
        let factors: Vec<Option<f64>> = self.roots.par_iter().map(factor).collect();
        for (root, factor) in self.roots.iter_mut().zip(factors) {
            if let Some(factor) = factor {
                root.quality.pole_std = root.quality.pole_bound * factor.sqrt();
            }
        }
    }
}

/// Power of the residual along the residues of a root, over what functions with independent errors
/// would leave there.
///
/// Under steady random force leakage is an error of a mode's response to the force, which all
/// functions hold in the ratio of their residues `a`: `E|Σ_f conj(a_f) r_f/l_f²|²` is then up to n
/// times `Σ_f |a_f|² v_f/l_f⁴` of n functions, and so is the variance of the pole. The residual
/// tells it on the lines of the resonance, less what the fit took of these.
fn power_along(data: &Receptances, rest: &Rest, root: &Root) -> f64 {
    let side = (ALONG_HALF_POWER_WIDTHS * root.width() / data.step).ceil() as usize;
    let (side, top) = (side.max(MIN_ALONG_LINES), data.line_of(root.lambda));
    let lines = top.saturating_sub(side)..(top + side + 1).min(data.lines());
    let functions = 0..data.functions();
    let variance: Vec<f64> = functions
        .map(|f| data.mean_variance(f, lines.clone()))
        .collect();
    let (mut along, mut alone) = (0.0, 0.0);
    for k in lines.clone() {
        let mut sum = Complex64::ZERO;
        for (f, a) in root.residues.iter().enumerate() {
            let weight = a.conj() * (data.deviation(f, k) / variance[f]);
            sum += weight * rest.at(f, k);
            alone += weight.norm_sqr();
        }
        along += sum.norm_sqr();
    }
    // Independent complex values, and the degrees of freedom that the fit leaves of them; a
    // deviation from few of these is that of a Student variable.
    let values = lines.len() as f64 / data.correlation.alike();
    let freedom = (2.0 * (values - FITTED)).max(MIN_FREEDOM);
    let ratio = along / alone * (2.0 * values / freedom) * (freedom / (freedom - 2.0));
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Variance of a pole over that in noise as the fit weights it, at least `along` times that of
/// functions with independent errors; `None` where its lines do not tell it from what is around.
fn raised(data: &Receptances, roots: &[Root], (root, along): (&Root, f64)) -> Option<f64> {
    let lines = window(data, std::iter::once(root));
    let profile = Profile::new(data, lines.clone());
    let fit = FitLines {
        background: Background::new(&data.omega, &lines, data.outside()),
        course: &profile.course,
        lines: lines.clone(),
    };
    let course = orthogonal_derivative(data, (roots, root), &fit)?;
    let energy = course.iter().map(Complex64::norm_sqr).sum::<f64>();
    let over = |f: usize| profile.level[f] * profile.level[f];
    let weights = root.residues.iter().enumerate();
    let weights: f64 = weights.map(|(f, a)| a.norm_sqr() / over(f)).sum();
    // Of the response and of the force where it is not shared, mean squares over the functions;
    // along the response, by hit point.
    let (mut own, mut single) = (vec![0.0; lines.len()], vec![0.0; lines.len()]);
    let mut alone = vec![0.0; lines.len()];
    let mut turn = vec![Complex64::ZERO; lines.len()];
    let mut shared = Vec::new();
    for (group, part) in data.shared.parts_of_groups() {
        let mut along = vec![Complex64::ZERO; lines.len()];
        for f in group {
            let a = root.residues[*f].conj() / over(*f);
            let values = &data.values[*f][lines.clone()];
            let variance = &data.variance[*f][lines.clone()];
            let by_force = &data.by_force[*f][lines.clone()];
            for (k, ((h, v), p)) in values.iter().zip(variance).zip(by_force).enumerate() {
                let p = p.clamp(0.0, 1.0);
                own[k] += a.norm_sqr() * v * (1.0 - p);
                alone[k] += a.norm_sqr() * v;
                single[k] += (1.0 - part) * a.norm_sqr() * v * p;
                let size = h.norm().max(f64::MIN_POSITIVE);
                along[k] += a * h * ((v * p).sqrt() / size);
                turn[k] += a * h;
            }
        }
        if part > 0.0 {
            let root_of_part = part.sqrt();
            along.iter_mut().for_each(|value| *value *= root_of_part);
            shared.push(along);
        }
    }
    let over_course = |k: usize| course[k].conj() / profile.course[k];
    let each = |values: &dyn Fn(usize) -> Complex64| -> Vec<Complex64> {
        (0..lines.len())
            .map(|k| over_course(k) * values(k))
            .collect()
    };
    let plan = ComplexPlan::inverse((2 * lines.len()).next_power_of_two());
    let by_response = Spectrum::new(&plan, &data.correlation, lines.len());
    let by_force = Spectrum::new(&plan, data.shared.along(), lines.len());
    let mut variance = by_response.power(&plan, each(&|k| own[k].sqrt().into()));
    if single.iter().any(|v| *v > 0.0) {
        let phase = |k: usize| turn[k] / turn[k].norm().max(f64::MIN_POSITIVE);
        variance += by_force.power(&plan, each(&|k| phase(k) * single[k].sqrt()));
    }
    for along in shared {
        variance += by_force.power(&plan, each(&|k| along[k]));
    }
    if along > 0.0 {
        let alone = by_response.power(&plan, each(&|k| alone[k].sqrt().into()));
        variance = variance.max(along * alone);
    }
    let factor = variance / (energy * weights);
    // Correlation that chance makes lowers nothing.
    factor.is_finite().then_some(factor.max(1.0))
}

/// Lines on which a pole is fitted.
pub(in crate::identify) struct FitLines<'a> {
    pub lines: Range<usize>,
    /// Profile of the noise over these lines.
    pub course: &'a [f64],
    /// Out-of-band terms of these lines.
    pub background: Background<'a>,
}

/// Part of a pole's derivative, over the profile of the noise, that out-of-band terms and the poles
/// around do not explain; `None` where there are too few lines.
pub(in crate::identify) fn orthogonal_derivative(
    data: &Receptances,
    (roots, root): (&[Root], &Root),
    fit: &FitLines,
) -> Option<Vec<Complex64>> {
    let FitLines {
        lines,
        course,
        background,
    } = fit;
    let omega = &data.omega[lines.clone()];
    let (lo, hi) = (omega[0], omega[omega.len() - 1]);
    let near: Vec<&Root> = (roots.iter())
        .filter(|other| other.lambda.im > lo - other.width())
        .filter(|other| other.lambda.im < hi + other.width())
        .collect();
    let columns = background.columns();
    if lines.len() < columns + near.len() + 2 {
        return None;
    }
    let power = |k: usize, root: &Root, n: usize| {
        data.line_shape
            .power(root.decay(), (omega[k], root.lambda), n)
    };
    let others = linalg::complex_matrix(lines.len(), columns + near.len(), |k, column| {
        let value = match column.checked_sub(columns) {
            Some(place) => power(k, near[place], 1),
            None => background.value(column, omega, k),
        };
        value / course[k]
    });
    let second = linalg::complex_matrix(lines.len(), 1, |k, _| power(k, root, 2) / course[k]);
    let basis: ComplexMatrix = linalg::thin_qr(&others).ok()?.q;
    let own = &second - &basis * (basis.adjoint() * &second);
    let enough = own.norm_l2() > OWN * second.norm_l2();
    enough.then(|| own.col_as_slice(0).to_vec())
}

/// The course over the record of noise that hangs together over the lines.
struct Spectrum(Vec<f64>);

impl Spectrum {
    /// Of so many lines, in the length of a plan.
    fn new(plan: &ComplexPlan, correlation: &Correlation, lines: usize) -> Self {
        let mut lags = vec![Complex64::ZERO; plan.len()];
        lags[0] = Complex64::ONE;
        for m in 1..lines {
            // ρ(m) is E n_k n*_(k+m), and the sign of the plan that of an inverse.
            let rho = correlation.lag(m);
            lags[m] = rho.conj();
            lags[plan.len() - m] = rho;
        }
        plan.run(&mut lags, &mut plan.scratch());
        let over = plan.len() as f64;
        Self(lags.iter().map(|value| value.re / over).collect())
    }

    /// `E|Σ u_k n_k|²`.
    fn power(&self, plan: &ComplexPlan, taken: Vec<Complex64>) -> f64 {
        // The conjugates are what the transform over the record is of.
        let mut taken: Vec<Complex64> = taken.iter().map(Complex64::conj).collect();
        taken.resize(plan.len(), Complex64::ZERO);
        plan.run(&mut taken, &mut plan.scratch());
        let terms = taken.iter().zip(&self.0).map(|(w, s)| s * w.norm_sqr());
        terms.sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::fit::pole_covariance::*;
    use crate::identify::synthetic::windowed_noise;

    #[test]
    fn the_power_of_a_sum_is_that_of_noise_under_the_window() {
        const LINES: usize = 64;
        const RECORD: usize = 512;
        // aT = 20 over the record: lines hang together over several.
        let at_end = 20.0;
        let correlation = Correlation::of_window(at_end, (std::f64::consts::TAU, LINES));
        let plan = ComplexPlan::inverse(2 * LINES);
        let spectrum = Spectrum::new(&plan, &correlation, LINES);
        for turn in [-0.9, -0.2, 0.3, 0.8] {
            // Values that turn one way take other noise than those that turn the other way.
            let taken: Vec<Complex64> = (0..LINES)
                .map(|k| Complex64::from_polar((-0.05 * k as f64).exp(), turn * k as f64))
                .collect();
            let told = spectrum.power(&plan, taken.clone());
            let (mut seen, mut size) = (0.0, 0.0);
            for seed in 0..2000 {
                let noise = windowed_noise(RECORD, at_end, seed);
                let pairs = taken.iter().zip(&noise);
                seen += pairs.map(|(u, n)| u * n).sum::<Complex64>().norm_sqr();
                size += noise[..LINES].iter().map(Complex64::norm_sqr).sum::<f64>() / LINES as f64;
            }
            // The power of one value has the deviation of its mean.
            assert!(
                (seen / size / told - 1.0).abs() < 0.12,
                "{turn}: {} {told}",
                seen / size
            );
        }
    }
}

//! Variance of the poles of a fit in noise that is correlated between lines, grows with the
//! response, and is common to FRFs.
//!
//! A fit weights its lines as for white noise that is independent between FRFs, with a level for
//! each FRF and a profile `c_k` over the lines. To first order the error of a pole is
//!
//! ```text
//! δλ = Σ_f Σ_k conj(w_fk) ε_fk      w_fk = a_f g_k / (W l_f² c_k)      W = |g|² Σ_f |a_f|²/l_f²
//! ```
//!
//! with the residues a, the levels l, and g the component of `1/(iω − λ)²` over the profile
//! orthogonal to out-of-band terms and the poles around. Response noise has the variance `(1 − p)
//! v` and is independent between FRFs; force noise, `p v`, is an error `e H`, which the FRFs of one
//! reference have partly in common. Both have the line correlation `ρ(k − l)`, so that
//!
//! ```text
//! E|Σ conj(u_k) n_k|² = Σ_t s_t |Σ_k u_k e^(2πikt/N)|²      s_t = Σ_m ρ(m) e^(2πimt/N) / N
//! ```
//!
//! which is the power of the noise over the record, weighted with the sensitivity of the pole.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;
use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::data::residual::Residual;
use crate::identify::fit::block_descent::window;
use crate::identify::fit::fit_data::FitData;
use crate::identify::noise::band_profile::BandProfile;
use crate::identify::noise::line_correlation::LineCorrelation;

/// Half-power bandwidths on either side in which the common error of the FRFs is estimated from the
/// residual, and minimum number of lines: within 2 the fit leaves too few values, beyond 5 other
/// noise exceeds that of the resonance.
const RESIDUAL_BANDWIDTHS: f64 = 3.0;
const MIN_RESIDUAL_LINES: usize = 6;
/// Complex values that the fit absorbs: pole, residue, constant and slope.
const FITTED_VALUES: f64 = 4.0;
/// Minimum degrees of freedom: a Student variable of 3 has a variance of 3; of 2 and fewer, none.
const MIN_FREEDOM: f64 = 3.0;
/// Minimum independent component of the derivative, over its length.
const MIN_INDEPENDENT_FRACTION: f64 = 1e-6;

/// Sets the standard deviations of the poles with the estimated noise model.
pub(in crate::identify) fn add_noise_model_uncertainty(data: &FitData, roots: &mut [ModelPole]) {
    let is_smoothed = data.frfs.line_shape.is_smoothed();
    let residual = is_smoothed.then(|| data.residual(roots));
    let factor = |root: &ModelPole| {
        let common_power = residual
            .as_ref()
            .map(|residual| power_along(data, residual, root));
        variance_inflation(data, roots, root, common_power.unwrap_or(0.0))
    };
    let factors: Vec<Option<f64>> = roots.par_iter().map(factor).collect();
    for (root, factor) in roots.iter_mut().zip(factors) {
        if let Some(factor) = factor {
            root.quality.pole_std = root.quality.pole_bound * factor.sqrt();
        }
    }
}

/// Power of the residual along the residues of a pole, over that of independent errors.
///
/// Under steady random force leakage is an error of the modal response to the force, which all FRFs
/// contain in the ratio of their residues `a`: for n FRFs `E|Σ_f conj(a_f) r_f/l_f²|²` is then up
/// to n times `Σ_f |a_f|² v_f/l_f⁴`, and so is the variance of the pole. It is estimated from the
/// residual on the lines of the resonance, with the degrees of freedom of the fit subtracted.
fn power_along(data: &FitData, rest: &Residual, root: &ModelPole) -> f64 {
    let side = (RESIDUAL_BANDWIDTHS * root.width() / data.frfs.step).ceil() as usize;
    let (side, top) = (side.max(MIN_RESIDUAL_LINES), data.frfs.line_of(root.lambda));
    let lines = top.saturating_sub(side)..(top + side + 1).min(data.frfs.lines());
    let functions = 0..data.frfs.functions();
    let variance: Vec<f64> = functions
        .map(|f| data.noise.mean_variance(f, lines.clone()))
        .collect();
    let (mut along, mut independent) = (0.0, 0.0);
    for k in lines.clone() {
        let mut sum = Complex64::ZERO;
        for (f, a) in root.residues.iter().enumerate() {
            let weight = a.conj() * (data.noise.std(f, k) / variance[f]);
            sum += weight * rest.at(f, k);
            independent += weight.norm_sqr();
        }
        along += sum.norm_sqr();
    }
    // Independent complex values, and the degrees of freedom that the fit leaves; a standard
    // deviation from few of these is that of a Student variable.
    let values = lines.len() as f64 / data.noise.line_correlation.lines_per_effective_line();
    let freedom = (2.0 * (values - FITTED_VALUES)).max(MIN_FREEDOM);
    let ratio = along / independent * (2.0 * values / freedom) * (freedom / (freedom - 2.0));
    if ratio.is_finite() { ratio } else { 0.0 }
}

/// Variance of a pole over that in noise as the fit weights it, at least `along` times that of
/// independent errors; `None` where the lines do not separate the pole from the others.
fn variance_inflation(
    data: &FitData,
    roots: &[ModelPole],
    root: &ModelPole,
    along: f64,
) -> Option<f64> {
    let lines = window(&data.frfs, std::iter::once(root));
    let profile = BandProfile::new(&data.noise, lines.clone());
    let fit = FitLines {
        background: OutOfBandBasis::new(&data.frfs.omega, &lines, data.out_of_band_terms()),
        noise_profile: &profile.noise_profile,
        lines: lines.clone(),
    };
    let sensitivity = orthogonal_derivative(&data.frfs, roots, root, &fit)?;
    let energy = sensitivity.iter().map(Complex64::norm_sqr).sum::<f64>();
    let over = |f: usize| profile.level[f] * profile.level[f];
    let weights = root.residues.iter().enumerate();
    let weights: f64 = weights.map(|(f, a)| a.norm_sqr() / over(f)).sum();
    // Response noise and independent force noise, summed over the FRFs; force noise along the
    // response, by reference.
    let (mut response, mut single) = (vec![0.0; lines.len()], vec![0.0; lines.len()]);
    let mut independent = vec![0.0; lines.len()];
    let mut phasor = vec![Complex64::ZERO; lines.len()];
    let mut shared = Vec::new();
    for (group, fraction) in data.noise.force_noise.common_fractions() {
        let mut along = vec![Complex64::ZERO; lines.len()];
        for f in group {
            let a = root.residues[*f].conj() / over(*f);
            let values = data.frfs.values.of(*f, lines.clone());
            let noise = &data.noise.by_frf[*f];
            let power = a.norm_sqr();
            let lines_of_frf = values
                .iter()
                .zip(noise.variances(lines.clone()))
                .enumerate();
            for (k, (h, v)) in lines_of_frf.clone() {
                independent[k] += power * v;
                phasor[k] = phasor[k] + a * h;
            }
            let Some(force_fraction) = noise.force_fractions(lines.clone()) else {
                for (k, (_, v)) in lines_of_frf {
                    response[k] += power * v;
                }
                continue;
            };
            for ((k, (h, v)), p) in lines_of_frf.zip(force_fraction) {
                let p = f64::from(*p).clamp(0.0, 1.0);
                response[k] += power * v * (1.0 - p);
                single[k] += (1.0 - fraction) * power * v * p;
                let size = h.norm().max(f64::MIN_POSITIVE);
                along[k] = along[k] + a * h * ((v * p).sqrt() / size);
            }
        }
        if fraction > 0.0 {
            let amplitude = fraction.sqrt();
            along.iter_mut().for_each(|value| *value *= amplitude);
            shared.push(along);
        }
    }
    let weighted = |k: usize| sensitivity[k].conj() / profile.noise_profile[k];
    let each = |values: &dyn Fn(usize) -> Complex64| -> Vec<Complex64> {
        (0..lines.len()).map(|k| weighted(k) * values(k)).collect()
    };
    let plan = ComplexPlan::inverse((2 * lines.len()).next_power_of_two());
    let response_spectrum = Spectrum::new(&plan, &data.noise.line_correlation, lines.len());
    let force_spectrum = Spectrum::new(
        &plan,
        data.noise.force_noise.line_correlation(),
        lines.len(),
    );
    let mut variance = response_spectrum.power(&plan, each(&|k| response[k].sqrt().into()));
    if single.iter().any(|v| *v > 0.0) {
        let phase = |k: usize| phasor[k] / phasor[k].norm().max(f64::MIN_POSITIVE);
        variance += force_spectrum.power(&plan, each(&|k| phase(k) * single[k].sqrt()));
    }
    for along in shared {
        variance += force_spectrum.power(&plan, each(&|k| along[k]));
    }
    if along > 0.0 {
        let independent = response_spectrum.power(&plan, each(&|k| independent[k].sqrt().into()));
        variance = variance.max(along * independent);
    }
    let factor = variance / (energy * weights);
    // A factor below 1 is a random error of the correlation.
    factor.is_finite().then_some(factor.max(1.0))
}

/// Lines on which a pole is fitted.
pub(in crate::identify) struct FitLines<'a> {
    pub lines: Range<usize>,
    /// Profile of the noise over these lines.
    pub noise_profile: &'a [f64],
    /// Out-of-band terms of these lines.
    pub background: OutOfBandBasis<'a>,
}

/// Part of a pole's derivative, over the profile of the noise, that out-of-band terms and the poles
/// around do not explain; `None` where there are too few lines.
pub(in crate::identify) fn orthogonal_derivative(
    frfs: &BandFrfs,
    roots: &[ModelPole],
    root: &ModelPole,
    fit: &FitLines,
) -> Option<Vec<Complex64>> {
    let FitLines {
        lines,
        noise_profile,
        background,
    } = fit;
    let omega = &frfs.omega[lines.clone()];
    let (lo, hi) = (omega[0], omega[omega.len() - 1]);
    let near: Vec<&ModelPole> = (roots.iter())
        .filter(|other| other.lambda.im > lo - other.width())
        .filter(|other| other.lambda.im < hi + other.width())
        .collect();
    let columns = background.columns();
    if lines.len() < columns + near.len() + 2 {
        return None;
    }
    let power = |k: usize, root: &ModelPole, n: usize| {
        frfs.line_shape
            .power(root.decay(), omega[k], root.lambda, n)
    };
    let others = linalg::complex_matrix(lines.len(), columns + near.len(), |k, column| {
        let value = match column.checked_sub(columns) {
            Some(index) => power(k, near[index], 1),
            None => background.value(column, omega, k),
        };
        value / noise_profile[k]
    });
    let second =
        linalg::complex_matrix(lines.len(), 1, |k, _| power(k, root, 2) / noise_profile[k]);
    let basis: ComplexMatrix = linalg::thin_qr(&others).ok()?.q;
    let component = &second - &basis * (basis.adjoint() * &second);
    let is_independent = component.norm_l2() > MIN_INDEPENDENT_FRACTION * second.norm_l2();
    is_independent.then(|| component.col_as_slice(0).to_vec())
}

/// Power over the record of noise with line correlation.
struct Spectrum(Vec<f64>);

impl Spectrum {
    /// Spectrum of noise on `lines` lines, in the length of a plan.
    fn new(plan: &ComplexPlan, correlation: &LineCorrelation, lines: usize) -> Self {
        let mut lags = vec![Complex64::ZERO; plan.len()];
        lags[0] = Complex64::ONE;
        for m in 1..lines {
            // ρ(m) is E n_k n*_(k+m), and the sign of the plan that of an inverse.
            let rho = correlation.lag(m);
            lags[m] = rho.conj();
            lags[plan.len() - m] = rho;
        }
        plan.run(&mut lags, &mut plan.scratch());
        let length = plan.len() as f64;
        Self(lags.iter().map(|value| value.re / length).collect())
    }

    /// `E|Σ u_k n_k|²`.
    fn power(&self, plan: &ComplexPlan, weights: Vec<Complex64>) -> f64 {
        // The transform over the record is that of the conjugates.
        let mut weights: Vec<Complex64> = weights.iter().map(Complex64::conj).collect();
        weights.resize(plan.len(), Complex64::ZERO);
        plan.run(&mut weights, &mut plan.scratch());
        let terms = weights.iter().zip(&self.0).map(|(w, s)| s * w.norm_sqr());
        terms.sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::fit::pole_covariance::*;
    use crate::identify::synthetic::windowed_noise;

    #[test]
    fn power_of_a_weighted_sum_is_that_of_simulated_noise_under_the_window() {
        const LINES: usize = 64;
        const RECORD: usize = 512;
        // aT = 20 over the record: the noise is correlated over several lines.
        let at_end = 20.0;
        let correlation = LineCorrelation::of_window(at_end, std::f64::consts::TAU, LINES);
        let plan = ComplexPlan::inverse(2 * LINES);
        let spectrum = Spectrum::new(&plan, &correlation, LINES);
        for rotation in [-0.9, -0.2, 0.3, 0.8] {
            // Weights of opposite rotation have different noise.
            let weights: Vec<Complex64> = (0..LINES)
                .map(|k| Complex64::from_polar((-0.05 * k as f64).exp(), rotation * k as f64))
                .collect();
            let computed = spectrum.power(&plan, weights.clone());
            let (mut simulated, mut size) = (0.0, 0.0);
            for seed in 0..2000 {
                let noise = windowed_noise(RECORD, at_end, seed);
                let pairs = weights.iter().zip(&noise);
                simulated += pairs.map(|(u, n)| u * n).sum::<Complex64>().norm_sqr();
                size += noise[..LINES].iter().map(Complex64::norm_sqr).sum::<f64>() / LINES as f64;
            }
            // The power of one value has a standard deviation equal to its mean.
            assert!(
                (simulated / size / computed - 1.0).abs() < 0.12,
                "{rotation}: {} {computed}",
                simulated / size
            );
        }
    }
}

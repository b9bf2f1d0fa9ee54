//! The maximum likelihood method estimates the multiplicity of a pole from residues that are free
//! in each FRF, before any participation factor is fitted.
//!
//! The normal equations of many references give a repeated pole as fewer poles than it has modes.
//! With every FRF as an output of one input, a pole of any multiplicity is one pole. Its residues,
//! outputs × inputs over their noise, have as many singular values above those of noise as the pole
//! has modes, and the right singular vectors are the participation factors (the CMIF of Shih et al.
//! 1988, at a pole instead of a frequency line).

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, LinalgError, RealMatrix};

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{ModelPole, combined};
use crate::identify::fit::detection_threshold::uneven_noise_norm_quantile;
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::mode_strength::Strength;
use crate::identify::pole_model::pole_metrics::{MAX_CHI_SQUARE, PoleMetrics};

/// Minimum strength of a mode of a repeated pole over that of the strongest mode: the residual of a
/// single pole is weaker.
const MIN_RELATIVE_STRENGTH: f64 = 0.03;
/// Distance, in decay rates, below which two estimates are the same pole.
const MATCH_DECAY_RATES: f64 = 1.0;

/// One single pole for each distinct pole of FRFs that are outputs of one input.
pub(in crate::identify) fn distinct_poles(estimates: &[ModelPole]) -> Vec<ModelPole> {
    let mut poles: Vec<Complex64> = Vec::new();
    for estimate in estimates {
        let near = |pole: &Complex64| (*pole - estimate.lambda).norm() < 0.5 * estimate.decay();
        if !poles.iter().any(near) {
            poles.push(estimate.lambda);
        }
    }
    let functions = estimates
        .first()
        .map_or(0, |estimate| estimate.residues.len());
    let estimate = |pole: &Complex64| ModelPole::single(*pole, &[Complex64::ONE], functions);
    poles.iter().map(estimate).collect()
}

/// Completes the multiplicities of poles. `free` are the poles of FRFs as outputs of one input,
/// with free residues. Where a free pole has more modes than the poles near it, or is near one pole
/// or none, its modes replace them. Free poles at which the model misfits the data are ignored.
pub(in crate::identify) fn complete_multiplicities(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    estimates: Vec<ModelPole>,
    free: &[ModelPole],
    pole_metrics: &[PoleMetrics],
    false_alarm_probability: f64,
) -> Vec<ModelPole> {
    let nearest = |estimate: &ModelPole| {
        let distance = |pole: &usize| (free[*pole].lambda - estimate.lambda).norm();
        let pole = (0..free.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(&pole) < MATCH_DECAY_RATES * estimate.decay().max(free[pole].decay()))
            .then_some(pole)
    };
    let mut groups: Vec<Vec<ModelPole>> = vec![Vec::new(); free.len()];
    let mut completed = Vec::new();
    for estimate in estimates {
        match nearest(&estimate) {
            Some(pole) => groups[pole].push(estimate),
            None => completed.push(estimate),
        }
    }
    for (index, group) in groups.into_iter().enumerate() {
        if pole_metrics[index].reduced_chi_square > MAX_CHI_SQUARE {
            completed.extend(group);
            continue;
        }
        let factors = participation_factors(
            data,
            frf_matrix,
            &free[index],
            &pole_metrics[index],
            false_alarm_probability,
        );
        let keep_group =
            factors.len() < group.len() || (factors.len() == group.len() && group.len() > 1);
        if keep_group {
            completed.extend(group);
        } else {
            completed.extend(split_pole(&free[index], factors));
        }
    }
    completed
}

/// Single pole with the participation factor of the strongest rank-one term of its residues,
/// without a test against noise.
pub(in crate::identify) fn strongest(
    frf_matrix: &FrfMatrix,
    pole: &ModelPole,
) -> Result<ModelPole, LinalgError> {
    let svd = linalg::singular_vectors(&frf_matrix.matrix(|f| pole.residues[f]))?;
    let factors: Vec<Complex64> = (0..frf_matrix.inputs)
        .map(|i| svd.right[(i, 0)].conj())
        .collect();
    Ok(ModelPole::single(
        pole.lambda,
        &factors,
        pole.residues.len(),
    ))
}

/// Two modes as two poles, which can separate in the fit; more modes as one repeated pole.
fn split_pole(pole: &ModelPole, mut factors: Vec<Vec<Complex64>>) -> Vec<ModelPole> {
    let functions = pole.residues.len();
    let single = |part: &Vec<Complex64>| ModelPole::single(pole.lambda, part, functions);
    if factors.len() <= 2 {
        return factors.iter().map(single).collect();
    }
    let mut repeated = single(&factors[0]);
    repeated.join(factors.split_off(1));
    vec![repeated]
}

/// Participation factors of the modes of one pole.
fn participation_factors(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    pole: &ModelPole,
    metrics: &PoleMetrics,
    false_alarm_probability: f64,
) -> Vec<Vec<Complex64>> {
    let line = data.frfs.line_of(pole.lambda);
    let level: Vec<f64> = (0..data.frfs.functions())
        .map(|f| data.noise.std(f, line))
        .collect();
    // The strength of a pole is twice the energy of its residues over their noise.
    let over = |(a, s): (&Complex64, &f64)| (a / s).norm_sqr();
    let energy: f64 = pole.residues.iter().zip(&level).map(over).sum();
    let noise_factor = pole.quality.amplitude_noise_factor * metrics.reduced_chi_square.max(1.0);
    let noise = (2.0 * energy / pole.quality.significance() * noise_factor).sqrt();
    let residues = frf_matrix.matrix(|f| pole.residues[f]);
    let deviations = linalg::real_matrix(frf_matrix.outputs.len(), frf_matrix.inputs, |o, i| {
        noise * level[frf_matrix.outputs[o][i].1]
    });
    let above = terms_above_noise(&residues, &deviations, false_alarm_probability);
    independent_terms(&residues, &deviations, above)
}

/// Participation factors of the rank-one terms of residues (outputs × inputs) above their noise.
fn terms_above_noise(
    residues: &ComplexMatrix,
    deviations: &RealMatrix,
    false_alarm_probability: f64,
) -> Vec<Vec<Complex64>> {
    let (outputs, inputs) = (residues.nrows(), residues.ncols());
    let (by_output, by_input) = separable_factors(deviations);
    let over = |o: usize, i: usize| by_output[o] * by_input[i];
    let whitened = linalg::complex_matrix(outputs, inputs, |o, i| residues[(o, i)] / over(o, i));
    let Ok(svd) = linalg::singular_vectors(&whitened) else {
        return Vec::new();
    };
    let uneven = |o: usize, i: usize| deviations[(o, i)] / over(o, i);
    let limit = uneven_noise_norm_quantile(outputs, inputs, uneven, false_alarm_probability);
    let count = svd.values.iter().take_while(|s| **s > limit).count();
    // A = U S Vᴴ, so that the row space is that of conj(V).
    let factor = |rank: usize, i: usize| svd.right[(i, rank)].conj() * by_input[i];
    (0..count)
        .map(|rank| (0..inputs).map(|i| factor(rank, i)).collect())
        .collect()
}

/// Independent combinations of rank-one terms whose strength over all outputs is not far below that
/// of the strongest.
fn independent_terms(
    residues: &ComplexMatrix,
    deviations: &RealMatrix,
    factors: Vec<Vec<Complex64>>,
) -> Vec<Vec<Complex64>> {
    if factors.len() < 2 {
        return factors;
    }
    let inputs = residues.ncols();
    let mut strength = Strength::none(factors.len());
    for o in 0..residues.nrows() {
        // Row o of the residues is ψᵀL over its noise.
        let columns = linalg::complex_matrix(inputs, factors.len(), |i, part| {
            factors[part][i] / deviations[(o, i)]
        });
        let values =
            linalg::complex_matrix(inputs, 1, |i, _| residues[(o, i)] / deviations[(o, i)]);
        let Ok(qr) = linalg::thin_qr(&columns) else {
            return factors;
        };
        let inverse = linalg::inverse_upper(&qr.r);
        let shape = &inverse * (qr.q.adjoint() * values);
        strength.add(&inverse * inverse.adjoint(), shape);
    }
    let strengths = strength.values();
    let Some(strongest) = strengths.values.last() else {
        return factors;
    };
    let weak = |s: &&f64| **s < MIN_RELATIVE_STRENGTH * MIN_RELATIVE_STRENGTH * strongest;
    let weakest = strengths.values.iter().take_while(weak).count();
    let mut kept = combined(&factors, &strengths.combinations).split_off(weakest);
    kept.reverse();
    kept
}

/// Factors of outputs and of inputs whose products are nearest to values by output and input, in
/// the mean of logarithms.
///
/// A matrix divided by such products keeps its rank; divided by arbitrary values of each element it
/// does not.
fn separable_factors(values: &RealMatrix) -> (Vec<f64>, Vec<f64>) {
    let (outputs, inputs) = (values.nrows(), values.ncols());
    let log = |o: usize, i: usize| values[(o, i)].ln();
    let of_output = |o: usize| (0..inputs).map(|i| log(o, i)).sum::<f64>() / inputs as f64;
    let of_input = |i: usize| (0..outputs).map(|o| log(o, i)).sum::<f64>() / outputs as f64;
    let mean = (0..outputs).map(of_output).sum::<f64>() / outputs as f64;
    let by_output = (0..outputs).map(|o| of_output(o).exp());
    let by_input = (0..inputs).map(|i| (of_input(i) - mean).exp());
    (by_output.collect(), by_input.collect())
}

#[cfg(test)]
mod tests {
    use crate::identify::pole_model::multiplicity::*;
    use crate::modal::mac;

    const OUTPUTS: usize = 9;
    const INPUTS: usize = 5;

    /// Participation factor of a mode at an input.
    fn factor(mode: usize, input: usize) -> f64 {
        ((1 + mode) as f64 * (0.4 + input as f64)).sin()
    }

    fn residues(weakest: f64) -> ComplexMatrix {
        linalg::complex_matrix(OUTPUTS, INPUTS, |o, i| {
            let mode = |m: usize| ((2 + m) as f64 * (0.3 + o as f64)).cos() * factor(m, i);
            Complex64::from(mode(0) + mode(1) + weakest * mode(2))
        })
    }

    /// Noise that is not a product of factors of outputs and inputs, with a hundred times more at
    /// one FRF.
    fn deviations(size: f64) -> RealMatrix {
        linalg::real_matrix(OUTPUTS, INPUTS, |o, i| {
            size * match (o, i) {
                (3, 2) => 100.0,
                _ => (1 + o) as f64 * (1.0 + (o * i % 3) as f64),
            }
        })
    }

    fn modes(weakest: f64, noise: f64) -> Vec<Vec<Complex64>> {
        let (residues, deviations) = (residues(weakest), deviations(noise));
        let above = terms_above_noise(&residues, &deviations, 1e-6);
        independent_terms(&residues, &deviations, above)
    }

    #[test]
    fn residues_of_three_modes_give_three_participation_factors() {
        let factors = modes(1.0, 1e-5);
        assert_eq!(factors.len(), 3);
        // Every true factor is a combination of the estimated ones.
        let basis = linalg::complex_matrix(INPUTS, 3, |i, part| factors[part][i]);
        for mode in 0..3 {
            let expected =
                linalg::complex_matrix(INPUTS, 1, |i, _| Complex64::from(factor(mode, i)));
            let fitted = &basis * linalg::least_squares(&basis, &expected).unwrap();
            let column =
                |m: &ComplexMatrix| -> Vec<Complex64> { (0..INPUTS).map(|i| m[(i, 0)]).collect() };
            assert!(mac(&column(&expected), &column(&fitted)) > Some(1.0 - 1e-9));
        }
    }

    #[test]
    fn a_term_below_the_noise_or_far_weaker_than_the_strongest_is_dropped() {
        assert_eq!(modes(1e-5, 1e-3).len(), 2);
        assert_eq!(modes(1e-3, 1e-9).len(), 2);
        assert_eq!(modes(0.3, 1e-9).len(), 3);
    }

    #[test]
    fn factors_of_a_product_of_outputs_and_inputs_are_found() {
        let values = linalg::real_matrix(2, 3, |o, i| [2.0, 5.0][o] * [1.0, 3.0, 9.0][i]);
        let (by_output, by_input) = separable_factors(&values);
        for o in 0..2 {
            for i in 0..3 {
                assert!((by_output[o] * by_input[i] / values[(o, i)] - 1.0).abs() < 1e-12);
            }
        }
    }
}

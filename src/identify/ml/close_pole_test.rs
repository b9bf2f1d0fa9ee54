//! The close-pole test detects a pole that stands for two close poles.
//!
//! Two poles `λ ± δ` with residues a and b are `(a + b)/(s − λ) + δ (a − b)/(s − λ)² + …`. A fit of
//! one pole has the first term, and of the second the part that all FRFs have in common. The
//! remaining part of the second term spreads thinly over the resonance, below the noise of single
//! lines. A matched filter detects it: the sum over the FRFs of `2 |⟨r, d⟩|²`, with the residual r
//! and with d the profile of the second term of norm 1, orthogonal to the profiles of the poles
//! around, is a chi-squared of two degrees of freedom for each FRF where there is one pole only.

use num_complex::Complex64;

use crate::linalg;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::Residual;
use crate::identify::fit::detection_threshold::upper_quantile;
use crate::identify::fit::fit_data::FitData;
use crate::identify::ml::residual_peaks::strongest_inputs;
use crate::identify::noise::band_profile::BandProfile;
use crate::identify::pole_model::pole_metrics::reduced_chi_square;
use crate::linalg::sort_descending_by;

/// Half-width of the band of the test, half-power bandwidths: beyond it the second term has a
/// hundredth of its energy.
const HALF_WIDTH_BANDWIDTHS: f64 = 3.0;
/// Reduced chi-square above which the test does not apply: the residual has other causes.
const MAX_CHI_SQUARE_CLOSE_PAIR: f64 = 4.0;
/// Minimum fraction of the second term that the poles around do not explain.
const MIN_UNEXPLAINED_FRACTION: f64 = 1e-3;
/// Distance of the trial pole from the first, half-power bandwidths.
const TRIAL_OFFSET_BANDWIDTHS: f64 = 0.25;

/// Indices of poles that stand for two, each with a trial pole near it, the most significant first.
/// Noise produces one of them with less than the false-alarm probability.
pub(in crate::identify) fn close_pair_candidates(
    data: &FitData,
    frf_matrix: &FrfMatrix,
    poles: &[ModelPole],
    residual: &Residual,
    false_alarm_probability: f64,
) -> Vec<(usize, ModelPole)> {
    if poles.is_empty() {
        return Vec::new();
    }
    let functions = data.frfs.functions();
    let quantile = upper_quantile(
        2.0 * functions as f64,
        false_alarm_probability / poles.len() as f64,
    );
    let second = |j: usize| {
        let pole = &poles[j];
        if reduced_chi_square(data, residual, pole) > MAX_CHI_SQUARE_CLOSE_PAIR {
            return None;
        }
        let terms = second_terms(data, poles, pole, residual)?;
        let top = data.frfs.line_of(pole.lambda);
        let energy = data
            .noise
            .noise_weighted_energy(&data.frfs, residual, top, |f| terms[f]);
        let correlation_factor = data
            .noise
            .line_correlation
            .amplitude_noise_factor(pole.decay(), data.frfs.step);
        if 2.0 * energy <= correlation_factor * quantile {
            return None;
        }
        let physical = |f: usize| terms[f] * data.noise.std(f, top);
        let parts = strongest_inputs(frf_matrix, 1, physical);
        let lambda = pole.lambda + Complex64::new(0.0, TRIAL_OFFSET_BANDWIDTHS * pole.width());
        Some((energy, j, ModelPole::single(lambda, &parts[0], functions)))
    };
    let mut found: Vec<_> = (0..poles.len()).filter_map(second).collect();
    sort_descending_by(&mut found, |entry| entry.0);
    found.into_iter().map(|(_, j, pole)| (j, pole)).collect()
}

/// Amplitude of the second term in the residual of each FRF, over its noise; `None` where the poles
/// around explain its profile.
fn second_terms(
    data: &FitData,
    poles: &[ModelPole],
    pole: &ModelPole,
    residual: &Residual,
) -> Option<Vec<Complex64>> {
    let lines = data.frfs.lines_around(pole.lambda, HALF_WIDTH_BANDWIDTHS);
    let (lo, hi) = (data.frfs.omega[lines.start], data.frfs.omega[lines.end - 1]);
    let inside = |pole: &&ModelPole| {
        pole.lambda.im > lo - pole.width() && pole.lambda.im < hi + pole.width()
    };
    let near: Vec<&ModelPole> = poles.iter().filter(inside).collect();
    // Constant and slope for out-of-band terms, and enough lines to separate all columns.
    if lines.len() < near.len() + 3 {
        return None;
    }
    let profile = BandProfile::new(&data.noise, lines.clone()).noise_profile;
    let power = |k: usize, pole: &ModelPole, n: usize| {
        let omega = data.frfs.omega[lines.start + k];
        data.frfs
            .line_shape
            .power(pole.decay(), omega, pole.lambda, n)
    };
    let middle = 0.5 * lines.len() as f64;
    let others = linalg::complex_matrix(lines.len(), near.len() + 2, |k, column| {
        let value = match near.get(column) {
            Some(pole) => power(k, pole, 1),
            None if column == near.len() => Complex64::ONE,
            None => Complex64::from(k as f64 / middle - 1.0),
        };
        value / profile[k]
    });
    let second = linalg::complex_matrix(lines.len(), 1, |k, _| power(k, pole, 2) / profile[k]);
    let basis = linalg::thin_qr(&others).ok()?.q;
    let unexplained = &second - &basis * (basis.adjoint() * &second);
    let norm = unexplained.norm_l2();
    if norm < MIN_UNEXPLAINED_FRACTION * second.norm_l2() {
        return None;
    }
    let term = |f: usize| -> Complex64 {
        let products = lines
            .clone()
            .map(|k| unexplained[(k - lines.start, 0)].conj() * residual.at(f, k));
        products.sum::<Complex64>() / norm
    };
    Some((0..data.frfs.functions()).map(term).collect())
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::ml::close_pole_test::*;
    use crate::identify::synthetic::{Measurement, Structure, white_noise};
    use crate::modal::Pole;

    const SENSORS: usize = 8;

    /// One mode, its pole, and a residual of noise.
    fn fitted(seed: u64) -> (FitData, FrfMatrix, ModelPole, Residual) {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.05,
            len: 3000,
        };
        let structure = Structure {
            modes: vec![(100.0, 0.01, vec![1.0; SENSORS])],
        };
        let set = structure.measured(&Measurement {
            snr_db: Some(60.0),
            ..Measurement::of_sensors(SENSORS, axis)
        });
        let data = FitData::guarded(&set, Band::new(80.0, 120.0).unwrap()).unwrap();
        let pole = ModelPole::single(
            Pole::from_frequency(100.0, 0.01).lambda,
            &[Complex64::ONE],
            SENSORS,
        );
        let noise: Vec<Vec<Complex64>> = (0..SENSORS as u64)
            .map(|f| white_noise(data.frfs.lines(), 1.0, 100 * seed + f))
            .collect();
        let residual = linalg::complex_matrix(data.frfs.lines(), SENSORS, |k, f| noise[f][k]);
        let residual = Residual::of_all(&residual);
        (data, FrfMatrix::new(set.functions()), pole, residual)
    }

    #[test]
    fn a_close_pair_below_the_noise_of_every_line_is_detected() {
        let (data, frf_matrix, pole, noise) = fitted(1);
        let second = |k: usize| {
            let first = pole.decay() / (Complex64::new(0.0, data.frfs.omega[k]) - pole.lambda);
            first * first
        };
        // At most 0.8 of the noise; of alternating sign over the sensors, so that no shift of the
        // pole explains it.
        let residual = linalg::complex_matrix(data.frfs.lines(), SENSORS, |k, f| {
            let sign = if f % 2 == 0 { 0.8 } else { -0.8 };
            noise.at(f, k) + sign * second(k)
        });
        let residual = Residual::of_all(&residual);
        let found = close_pair_candidates(
            &data,
            &frf_matrix,
            std::slice::from_ref(&pole),
            &residual,
            1e-3,
        );
        let [(index, other)] = &found[..] else {
            panic!("{} poles", found.len());
        };
        assert_eq!(*index, 0);
        assert!((other.lambda - pole.lambda).norm() < pole.width());
    }

    #[test]
    fn noise_alone_is_no_close_pair() {
        for seed in 0..20 {
            let (data, frf_matrix, pole, residual) = fitted(seed);
            assert!(close_pair_candidates(&data, &frf_matrix, &[pole], &residual, 1e-3).is_empty());
        }
        let (data, frf_matrix, _, residual) = fitted(0);
        assert!(close_pair_candidates(&data, &frf_matrix, &[], &residual, 1e-3).is_empty());
    }
}

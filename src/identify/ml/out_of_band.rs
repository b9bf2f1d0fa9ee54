//! Out-of-band terms: how many the data need, and the bias of the poles by those that are dropped.
//!
//! Modes outside the band are first modelled by poles outside it with free residues in every FRF.
//! This is unbiased, but raises the variance of poles near the band edges. The contribution of such
//! modes within the band is a few basis functions that all FRFs have in common. As few are kept as
//! reduce the out-of-band part of the residual to the noise.

use num_complex::Complex64;

use crate::identify::data::model_pole::{ModelPole, PoleQuality};
use crate::identify::data::out_of_band_basis::{OutOfBandTerm, OutOfBandTerms};
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::fit::fit_data::FitData;
use crate::identify::pole_model::PoleModel;

/// Maximum rounds in which out-of-band terms and poles are fitted alternately.
const MAX_ROUNDS: usize = 12;
/// Step of a pole between rounds, in its standard deviations, below which the rounds have
/// converged.
const CONVERGED_STEP_STDS: f64 = 0.05;
/// Ratio of a squared error to its mean that noise exceeds with probability 0.05: the distribution
/// is exponential.
const MAX_NOISE_RATIO: f64 = 3.0;
/// Maximum number of terms per FRF: more terms have hardly fewer unknowns than the free poles.
const MAX_TERMS_PER_FRF: f64 = 0.5;

impl PoleModel {
    /// Reduces the out-of-band terms to those that the data need: none where the residual of the
    /// poles has no significant out-of-band part, else the terms that all FRFs have in common. The
    /// response of a wide mode inside the band may have been part of the free terms: it is searched
    /// for without them.
    pub fn reduce_out_of_band_terms(&mut self) {
        let shared = self.strongest_terms(usize::MAX);
        let few = (1..=max_terms(self.data.frfs.functions())).contains(&shared.len());
        if !self.try_terms(Vec::new()) && few {
            self.try_terms(shared);
        }
    }

    /// Tries a set of out-of-band terms. Returns whether they are sufficient; otherwise nothing
    /// changes.
    fn try_terms(&mut self, terms: Vec<OutOfBandTerm>) -> bool {
        let before = self.snapshot();
        self.alternate_terms_and_poles(terms);
        if self.out_of_band_is_significant() && self.search().is_some() {
            self.refine_and_prune(Convergence::ResidualTest);
        }
        let enough = !self.out_of_band_is_significant() && self.poles.len() >= before.poles.len();
        if !enough {
            self.data.set_out_of_band_terms(OutOfBandTerms::Anywhere);
            self.restore(before);
        }
        enough
    }

    /// Fits out-of-band terms and poles alternately until both converge: terms estimated with
    /// biased poles are not optimal.
    fn alternate_terms_and_poles(&mut self, mut terms: Vec<OutOfBandTerm>) {
        let mut count = terms.len();
        for _ in 0..MAX_ROUNDS {
            let before: Vec<Complex64> = self.poles.iter().map(|pole| pole.lambda).collect();
            self.data
                .set_out_of_band_terms(OutOfBandTerms::BasisFunctions(terms));
            mark_unconverged(&mut self.poles);
            self.refine(Convergence::ResidualTest);
            let moved = |(pole, before): (&ModelPole, &Complex64)| {
                (pole.lambda - before).norm() > CONVERGED_STEP_STDS * pole.quality.pole_std
            };
            let same = self.poles.len() == before.len();
            if count == 0 || same && !self.poles.iter().zip(&before).any(moved) {
                return;
            }
            terms = self.strongest_terms(count);
            count = terms.len();
        }
    }

    /// Terms of the residual of the poles above the noise, at most a given number.
    fn strongest_terms(&self, most: usize) -> Vec<OutOfBandTerm> {
        let fit = self.data.fit_of_terms(&OutOfBandTerms::Anywhere);
        fit.strongest(
            &self.poles,
            self.data.noise.line_correlation.lines_per_effective_line(),
            most,
        )
    }

    /// Whether free out-of-band poles explain more of the residual than they would of white noise.
    /// They always do where noise is correlated between lines; there they are kept, and the
    /// standard deviations include them.
    fn out_of_band_is_significant(&self) -> bool {
        let all = self.data.fit_of_terms(&OutOfBandTerms::Anywhere);
        let (with, many) = all.explained(&self.poles);
        let (without, few) = self.data.out_of_band_fit().explained(&self.poles);
        // Two real numbers of variance 1/2 for each unknown.
        let unknowns = (many - few) as f64;
        with - without > unknowns + unknowns.sqrt()
    }

    /// Adds the uncertainty of the out-of-band terms to the standard deviations, and sets the bias
    /// of each pole by the dropped terms.
    ///
    /// With free out-of-band poles a pole has the information `1/σ_f²`, with known terms `1/σ²`.
    /// The error of the terms reduces it in the FRFs that contain them: by the fraction `p = Σ_r
    /// |v_rᴴψ|²/|ψ|²` of `1/σ² − 1/σ_f²`, with the residues `ψ` and the factors `v_r` of the terms
    /// in the FRFs, both over the noise.
    ///
    /// With free out-of-band poles the pole would move by `δ`: by noise, `E|δ|² = 2(σ_f² − σ²)`,
    /// and by the dropped terms. Above the limit that noise exceeds with probability 0.05 the bias
    /// is `√(|δ|² − E|δ|²)` along `δ`, else none.
    pub fn add_out_of_band_uncertainty(&mut self) {
        let OutOfBandTerms::BasisFunctions(terms) = self.data.out_of_band_terms().clone() else {
            return;
        };
        let free = self.with_free_poles();
        if free.len() != self.poles.len() {
            // A pole that free out-of-band poles displace or remove is an artefact of the reduced
            // terms.
            self.data.set_out_of_band_terms(OutOfBandTerms::Anywhere);
            self.refine_and_prune(Convergence::Fine);
            return;
        }
        for (pole, free) in self.poles.iter_mut().zip(&free) {
            let fraction = fraction_along_terms(&self.data, pole, &terms);
            pole.quality.add_term_uncertainty(&free.quality, fraction);
        }
    }

    /// The poles, fixed, with the quality of a fit with free out-of-band poles.
    fn with_free_poles(&mut self) -> Vec<ModelPole> {
        let terms = self.data.set_out_of_band_terms(OutOfBandTerms::Anywhere);
        let poles = self.poles.clone();
        mark_unconverged(&mut self.poles);
        self.refine(Convergence::Residues);
        self.data.set_out_of_band_terms(terms);
        std::mem::replace(&mut self.poles, poles)
    }
}

impl PoleQuality {
    /// Adds the uncertainty of the terms, from a fit with free out-of-band poles; `fraction`: part
    /// of the residues along the terms.
    fn add_term_uncertainty(&mut self, free: &Self, fraction: f64) {
        let (bound, all) = (self.pole_bound, free.pole_bound);
        // Where free out-of-band poles leave a pole undetermined, the terms are its only
        // information.
        if !(bound > 0.0 && bound <= all && bound.is_finite()) {
            return;
        }
        let [fixed_terms, free_terms] = [bound, all].map(|deviation| deviation.powi(-2));
        let raised = (fixed_terms - fraction * (fixed_terms - free_terms))
            .sqrt()
            .recip();
        let by_noise = self.pole_std / bound;
        let expected = 2.0 * by_noise.powi(2) * (all * all - bound * bound);
        let moved = free.offset.norm_sqr();
        let error = if moved > MAX_NOISE_RATIO * expected {
            free.offset * (1.0 - expected / moved).sqrt()
        } else {
            Complex64::ZERO
        };
        self.bias = Some(error);
        self.pole_std *= raised / bound;
        self.pole_bound = raised;
    }
}

/// Fraction of the residue energy of a pole along the out-of-band terms, over the noise.
fn fraction_along_terms(data: &FitData, pole: &ModelPole, terms: &[OutOfBandTerm]) -> f64 {
    let line = data.frfs.line_of(pole.lambda);
    let over = |f: usize| pole.residues[f] / data.noise.std(f, line);
    let residues: Vec<Complex64> = (0..data.frfs.functions()).map(over).collect();
    let all: f64 = residues.iter().map(Complex64::norm_sqr).sum();
    let along = |term: &OutOfBandTerm| {
        let products = term
            .frf_amplitudes
            .iter()
            .zip(&residues)
            .map(|(v, a)| v.conj() * a);
        products.sum::<Complex64>().norm_sqr()
    };
    if all > 0.0 {
        (terms.iter().map(along).sum::<f64>() / all).min(1.0)
    } else {
        1.0
    }
}

fn max_terms(functions: usize) -> usize {
    (MAX_TERMS_PER_FRF * functions as f64) as usize
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::data::frf_matrix::FrfMatrix;
    use crate::identify::estimator::MethodOptions;
    use crate::identify::fit::fit_data::FitData;
    use crate::identify::ml::out_of_band::*;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    /// Two modes from 80 to 150 Hz and one above, at eight sensors.
    fn structure() -> Structure {
        let shape = |a: f64| (1..=8).map(|p| (a * f64::from(p)).cos()).collect();
        Structure {
            modes: vec![
                (100.0, 0.01, shape(0.3)),
                (130.0, 0.012, shape(0.7)),
                (175.0, 0.01, shape(1.3)),
            ],
        }
    }

    /// A fit of the two modes from their true poles, with given out-of-band terms.
    fn fitted(snr_db: f64, seed: u64, outside: OutOfBandTerms) -> PoleModel {
        let axis = FrequencyAxis {
            start_hz: 80.0,
            step_hz: 0.1,
            len: 701,
        };
        let how = Measurement {
            snr_db: Some(snr_db),
            seed,
            ..Measurement::of_sensors(8, axis)
        };
        let set = structure().measured(&how);
        let data = FitData::guarded(&set, Band::new(80.0, 150.0).unwrap()).unwrap();
        let frf_matrix = FrfMatrix::new(set.functions());
        let mut fit = PoleModel::new(data, frf_matrix, MethodOptions::default());
        let one = [Complex64::ONE];
        fit.poles = truth()
            .map(|lambda| ModelPole::single(lambda, &one, 8))
            .to_vec();
        fit.data.set_out_of_band_terms(outside);
        fit.refine(Convergence::Fine);
        fit
    }

    fn truth() -> [Complex64; 2] {
        let modes = structure().modes;
        [0, 1].map(|j| Pole::from_frequency(modes[j].0, modes[j].1).lambda)
    }

    #[test]
    fn the_reported_bias_is_that_of_a_dropped_out_of_band_mode() {
        let mut fit = fitted(70.0, 1, OutOfBandTerms::BasisFunctions(Vec::new()));
        fit.add_out_of_band_uncertainty();
        for (pole, truth) in fit.poles.iter().zip(truth()) {
            let made = truth - pole.lambda;
            let bias = pole.quality.bias.unwrap();
            // Noise shifts a pole by one standard deviation, free out-of-band poles by several.
            assert!(made.norm() > 20.0 * pole.quality.pole_bound);
            assert!((bias - made).norm() < 0.2 * made.norm(), "{bias} {made}");
        }
    }

    #[test]
    fn without_dropped_terms_no_bias_is_reported() {
        let mut free = fitted(50.0, 2, OutOfBandTerms::Anywhere);
        free.add_out_of_band_uncertainty();
        assert!(free.poles.iter().all(|pole| pole.quality.bias.is_none()));
        free.reduce_out_of_band_terms();
        free.refine(Convergence::Fine);
        free.add_out_of_band_uncertainty();
        let relative_bias =
            |pole: &ModelPole| pole.quality.bias.unwrap().norm() / pole.quality.pole_bound;
        assert!(free.poles.iter().all(|pole| relative_bias(pole) < 1.0));
    }

    #[test]
    fn an_out_of_band_mode_is_a_term_common_to_all_frfs() {
        let mut fit = fitted(50.0, 3, OutOfBandTerms::Anywhere);
        let free: Vec<f64> = fit.poles.iter().map(|r| r.quality.pole_bound).collect();
        fit.reduce_out_of_band_terms();
        let OutOfBandTerms::BasisFunctions(terms) = fit.data.out_of_band_terms() else {
            panic!("free poles are kept");
        };
        assert!((1..=2).contains(&terms.len()), "{}", terms.len());
        fit.refine(Convergence::Fine);
        let with_terms: Vec<f64> = fit.poles.iter().map(|r| r.quality.pole_bound).collect();
        fit.add_out_of_band_uncertainty();
        for ((pole, free), with_terms) in fit.poles.iter().zip(free).zip(with_terms) {
            let std = pole.quality.pole_bound;
            assert!(with_terms < std && std < free, "{with_terms} {std} {free}");
        }
        for (pole, truth) in fit.poles.iter().zip(truth()) {
            // Four standard deviations of each part: exceeded by six parts in 100,000 seeds.
            let error = pole.lambda - truth;
            assert!(error.re.abs().max(error.im.abs()) < 4.0 * pole.quality.pole_bound);
        }
    }

    #[test]
    fn few_frfs_keep_free_out_of_band_poles() {
        assert_eq!([1, 2, 20].map(max_terms), [0, 1, 10]);
    }
}

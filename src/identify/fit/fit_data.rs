//! Data of a fit: FRFs of a band, their noise model, and the terms of the modes outside the band.

use std::sync::OnceLock;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandTerms;
use crate::identify::data::residual::{OutOfBandFit, PredictedResponse, Residual};
use crate::identify::error::IdentifyError;
use crate::identify::noise::band_profile::BandProfile;
use crate::identify::noise::line_correlation::LineCorrelation;
use crate::identify::noise::model::NoiseModel;

/// FRFs of a band with their noise and out-of-band terms.
///
/// The values and their variances change by its methods alone: what was computed from them is then
/// out of date.
pub(in crate::identify) struct FitData {
    /// Receptances on the lines of the band.
    pub frfs: BandFrfs,
    /// Noise of the FRFs.
    pub noise: NoiseModel,
    /// Model of the modes outside the lines.
    out_of_band_terms: OutOfBandTerms,
    /// Their fit to all lines, valid until the version changes.
    out_of_band_fit: OnceLock<OutOfBandFit>,
    /// Counts changes of values, line shape, variances and out-of-band terms.
    version: u64,
}

impl FitData {
    /// The FRFs of a set on the lines of a band.
    ///
    /// # Errors
    /// As [`BandFrfs::new`].
    pub fn new(set: &FrfSet, band: Band) -> Result<Self, IdentifyError> {
        Ok(Self::of(set, BandFrfs::new(set, band)?))
    }

    /// As [`Self::new`], with guard lines on each side as far as the set has them.
    ///
    /// # Errors
    /// As [`BandFrfs::guarded`].
    pub fn guarded(set: &FrfSet, band: Band) -> Result<Self, IdentifyError> {
        Ok(Self::of(set, BandFrfs::guarded(set, band)?))
    }

    fn of(set: &FrfSet, frfs: BandFrfs) -> Self {
        Self {
            noise: NoiseModel::new(set, &frfs),
            frfs,
            out_of_band_terms: OutOfBandTerms::Anywhere,
            out_of_band_fit: OnceLock::new(),
            version: 0,
        }
    }

    /// Some of the FRFs, by their numbers, with their noise.
    pub fn sample(&self, functions: &[usize]) -> Self {
        Self {
            frfs: self.frfs.sample(functions),
            noise: self.noise.sample(functions),
            out_of_band_terms: self.out_of_band_terms.clone(),
            out_of_band_fit: OnceLock::new(),
            version: 0,
        }
    }

    /// Version number: it changes with values, line shape, variances and out-of-band terms.
    pub fn version(&self) -> u64 {
        self.version
    }

    fn invalidate(&mut self) {
        self.out_of_band_fit = OnceLock::new();
        self.version += 1;
    }

    /// Model of the modes outside the lines.
    pub fn out_of_band_terms(&self) -> &OutOfBandTerms {
        &self.out_of_band_terms
    }

    /// Replaces the model of the modes outside the lines and returns the previous one.
    pub fn set_out_of_band_terms(&mut self, terms: OutOfBandTerms) -> OutOfBandTerms {
        self.invalidate();
        std::mem::replace(&mut self.out_of_band_terms, terms)
    }

    /// Fit of the out-of-band terms to all lines.
    pub fn out_of_band_fit(&self) -> &OutOfBandFit {
        self.out_of_band_fit
            .get_or_init(|| self.fit_of_terms(&self.out_of_band_terms))
    }

    /// Fit of given out-of-band terms to all lines.
    pub fn fit_of_terms(&self, terms: &OutOfBandTerms) -> OutOfBandFit {
        let BandProfile {
            level,
            noise_profile,
        } = BandProfile::new(&self.noise, 0..self.frfs.lines());
        OutOfBandFit::new(&self.frfs, terms, level, &noise_profile)
    }

    /// Prediction of the lines by poles and out-of-band terms.
    pub fn predict<'a>(&'a self, poles: &'a [ModelPole]) -> PredictedResponse<'a> {
        self.out_of_band_fit()
            .predict(&self.frfs, &self.noise.by_frf, poles)
    }

    /// Residual of poles and out-of-band terms on all lines.
    pub fn residual(&self, poles: &[ModelPole]) -> Residual {
        self.predict(poles).residual(0..self.frfs.lines())
    }

    /// Sets the line shape of poles, with the line correlation of the noise that it implies.
    pub fn set_line_shape(&mut self, line_shape: LineShape) {
        self.frfs.line_shape = line_shape;
        if let Some(lags) = line_shape.noise_correlation() {
            self.noise.line_correlation = LineCorrelation::of_lags(lags);
        }
        self.invalidate();
    }

    /// Adds a correction to an FRF, a function of frequency in rad/s.
    pub fn correct(&mut self, function: usize, by: impl Fn(f64) -> Complex64) {
        self.frfs.correct(function, by);
        self.invalidate();
    }

    /// Replaces the noise model.
    pub fn set_noise(&mut self, noise: NoiseModel) {
        self.noise = noise;
        self.invalidate();
    }

    /// As [`NoiseModel::estimate_variance_and_correlation`].
    pub fn estimate_noise(&mut self, rest: &mut Residual) {
        self.noise
            .estimate_variance_and_correlation(&self.frfs, rest);
        self.invalidate();
    }

    /// As [`NoiseModel::raise_to_misfit`].
    pub fn raise_noise_to_misfit(&mut self, rest: &Residual) {
        self.noise.raise_to_misfit(&self.frfs, rest);
        self.invalidate();
    }

    /// As [`NoiseModel::detect_correlated_noise`].
    pub fn detect_correlated_noise(&mut self, rest: &mut Residual) -> bool {
        let is_detected = self.noise.detect_correlated_noise(&self.frfs, rest);
        if is_detected {
            self.invalidate();
        }
        is_detected
    }
}

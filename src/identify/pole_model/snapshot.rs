//! The state of a pole model to which a trial returns that is not kept.

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandTerms;
use crate::identify::noise::model::NoiseModel;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::findings::Dropped;

/// Poles, dropped poles and, where a trial changes them, noise and out-of-band terms.
pub(in crate::identify) struct Snapshot {
    pub poles: Vec<ModelPole>,
    dropped: Vec<Dropped>,
    scattered: Option<usize>,
    noise: Option<(NoiseModel, OutOfBandTerms)>,
}

impl PoleModel {
    /// The state before a trial that leaves noise and out-of-band terms as they are.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            poles: self.poles.clone(),
            dropped: self.dropped.clone(),
            scattered: self.scattered,
            noise: None,
        }
    }

    /// The state before a trial that estimates the noise.
    pub fn snapshot_with_noise(&self) -> Snapshot {
        let terms = self.data.out_of_band_terms().clone();
        Snapshot {
            noise: Some((self.data.noise.clone(), terms)),
            ..self.snapshot()
        }
    }

    /// Returns to an earlier state.
    pub fn restore(&mut self, before: Snapshot) {
        self.poles = before.poles;
        self.dropped = before.dropped;
        self.scattered = before.scattered;
        if let Some((noise, terms)) = before.noise {
            self.data.set_noise(noise);
            self.data.set_out_of_band_terms(terms);
        }
    }
}

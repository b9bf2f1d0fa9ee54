//! The state of a pole model to which a trial returns that is not kept.

use crate::identify::data::model_pole::ModelPole;
use crate::identify::noise::model::NoiseModel;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::findings::Dropped;

/// Poles, dropped poles and, where a trial changes it, the noise.
pub(in crate::identify) struct Snapshot {
    pub poles: Vec<ModelPole>,
    dropped: Vec<Dropped>,
    scattered: Option<usize>,
    noise: Option<NoiseModel>,
}

impl PoleModel {
    /// The state before a trial that leaves the noise as it is.
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
        Snapshot {
            noise: Some(self.data.noise.clone()),
            ..self.snapshot()
        }
    }

    /// Returns to an earlier state.
    pub fn restore(&mut self, before: Snapshot) {
        self.poles = before.poles;
        self.dropped = before.dropped;
        self.scattered = before.scattered;
        if let Some(noise) = before.noise {
            self.data.set_noise(noise);
        }
    }
}

//! A model's mass matrix at the sensors of a test.

use crate::correlate::CorrelateError;
use crate::correlate::measures::{ReducedMass, Reduction, SensorRow, reduced_mass};
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::linalg::real_matrix;
use crate::theory::{ModeOptions, coordinate_sensors, modes};

use super::SceneError;
use super::model::LoadedModel;

impl LoadedModel {
    /// The mass matrix reduced to some degrees of freedom of the sensors at which the model was solved (without any, its own
    /// coordinates); SEREP keeps the modes of these indices in the solved model's list.
    ///
    /// # Errors
    /// [`CorrelateError::NotACoordinate`] also for a degree of freedom that no sensor has; the model's own reasons.
    pub fn reduced_mass(
        &self,
        sensors: &[Sensor],
        dofs: &[Dof],
        reduction: Reduction,
        kept: &[usize],
    ) -> Result<ReducedMass, SceneError> {
        let matrices = self.model.assemble(&self.values)?;
        let own = match sensors {
            [] => coordinate_sensors(&matrices.coordinates),
            _ => sensors.to_vec(),
        };
        let row = |dof: &Dof| -> Result<SensorRow, SceneError> {
            let mut known = own.iter();
            let sensor = known.find(|sensor| sensor.dof.positive() == dof.positive());
            let dof = dof.clone();
            let sensor = sensor.ok_or(CorrelateError::NotACoordinate { dof: dof.clone() })?;
            let mut row = self.model.observation_row(&sensor.target)?;
            row.iter_mut().for_each(|b| *b *= dof.sign());
            Ok(SensorRow { dof, row })
        };
        let rows: Vec<SensorRow> = dofs.iter().map(row).collect::<Result<_, _>>()?;
        let solved = modes(
            self.model.as_ref(),
            &self.values,
            &own,
            &ModeOptions::default(),
        )?;
        let vectors = &solved.vectors;
        let kept = real_matrix(vectors.nrows(), kept.len(), |i, j| vectors[(i, kept[j])]);
        Ok(reduced_mass(&matrices, &rows, reduction, &kept)?)
    }
}

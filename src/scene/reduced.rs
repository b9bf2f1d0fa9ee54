//! A model's mass matrix at the sensors of a test.

use crate::correlate::measures::{ReducedMass, Reduction, SensorRow, reduced_mass};
use crate::correlate::{CorrelateError, Reading};
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::linalg::real_matrix;
use crate::theory::{ModeOptions, coordinate_sensors, modes};

use super::SceneError;
use super::model::LoadedModel;

impl LoadedModel {
    /// The mass matrix reduced to readings, each named as a comparison names it and a sum of the
    /// sensors at which the model was solved (without any, at its coordinates); SEREP keeps the
    /// modes of these indices in the solved model's list.
    ///
    /// # Errors
    /// [`CorrelateError::NotACoordinate`] also for a degree of freedom that no sensor has; the
    /// The error of the model.
    pub fn reduced_mass(
        &self,
        sensors: &[Sensor],
        readings: &[(Dof, Reading)],
        reduction: Reduction,
        kept: &[usize],
    ) -> Result<ReducedMass, SceneError> {
        let matrices = self.model.assemble(&self.values)?;
        let sensors_of_model = match sensors {
            [] => coordinate_sensors(&matrices.coordinates),
            _ => sensors.to_vec(),
        };
        let read = |dof: &Dof| -> Result<Vec<f64>, SceneError> {
            let mut known = sensors_of_model.iter();
            let sensor = known.find(|sensor| sensor.dof.positive() == dof.positive());
            let sensor =
                sensor.ok_or_else(|| CorrelateError::NotACoordinate { dof: dof.clone() })?;
            Ok(self.model.observation_row(&self.values, &sensor.target)?)
        };
        let row = |(name, reading): &(Dof, Reading)| -> Result<SensorRow, SceneError> {
            let mut row = vec![0.0; matrices.coordinates.len()];
            for (dof, part) in reading {
                let shape_values = read(dof)?;
                row.iter_mut()
                    .zip(shape_values)
                    .for_each(|(sum, b)| *sum += part * b);
            }
            let dof = name.clone();
            Ok(SensorRow { dof, row })
        };
        let rows: Vec<SensorRow> = readings.iter().map(row).collect::<Result<_, _>>()?;
        let solved = modes(
            self.model.as_ref(),
            &self.values,
            &sensors_of_model,
            &ModeOptions::default(),
        )?;
        let vectors = &solved.vectors;
        let kept = real_matrix(vectors.nrows(), kept.len(), |i, j| vectors[(i, kept[j])]);
        Ok(reduced_mass(&matrices, &rows, reduction, &kept)?)
    }

    /// The model's coordinates as degrees of freedom, in the order of its matrices; none where a
    /// coordinate is not one of a body.
    ///
    /// # Errors
    /// The error of the model.
    pub fn coordinate_dofs(&self) -> Result<Vec<Dof>, SceneError> {
        let coordinates = self.model.assemble(&self.values)?.coordinates;
        let sensors = coordinate_sensors(&coordinates).into_iter();
        Ok(sensors.map(|sensor| sensor.dof).collect())
    }
}

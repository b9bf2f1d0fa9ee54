//! What was measured, as residuals need it: frequencies and shapes with their uncertainty.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::correlate::DofMap;
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::linalg::{RealMatrix, real_matrix};
use crate::modal::{ModalModel, Mode};
use crate::theory::TheoreticalModel;

use super::{UpdateError, UpdateOptions};

/// The modes of a test, or a list of published frequencies: modes without shapes, several of one group number for a root
/// of higher multiplicity.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredModes<'a> {
    /// Name.
    pub name: &'a str,
    /// Its modes.
    pub modes: &'a ModalModel,
    /// Number of each mode in labels; none for their places, from 1.
    pub numbers: &'a [usize],
}

impl<'a> MeasuredModes<'a> {
    /// Modes that are numbered by their places, from 1.
    pub fn new(name: &'a str, modes: &'a ModalModel) -> Self {
        Self {
            name,
            modes,
            numbers: &[],
        }
    }

    fn number(&self, mode: usize) -> usize {
        self.numbers.get(mode).copied().unwrap_or(mode + 1)
    }
}

/// One measured root: a mode, or several modes of one group number, which have one frequency.
#[derive(Clone, Debug)]
pub struct Target {
    /// `name f3`, by the number of its first mode in its test.
    pub label: String,
    /// Index of the test.
    pub test: usize,
    /// Indices of its modes in the test.
    pub modes: Vec<usize>,
    /// Frequency, Hz.
    pub hz: f64,
    /// Deviation of that as the test states it, Hz.
    pub hz_std: Option<f64>,
    /// Deviation that the residual is divided by, a fraction: the test's and the floor's, as independent.
    pub relative_std: f64,
    /// Shapes, where they take part.
    pub(super) shapes: Option<TargetShapes>,
}

impl Target {
    /// How many of its residuals say something where it has as many modes of the model as its own: its frequency, and its
    /// shapes less their free directions.
    pub(super) fn informative(&self) -> usize {
        let vectors = self.shapes.iter().flat_map(|shapes| &shapes.vectors);
        let of_shape = vectors.map(|v| v.len().saturating_sub(self.modes.len()));
        1 + of_shape.sum::<usize>()
    }
}

/// Shapes of a target at the degrees of freedom that test and model share, everything divided by the deviations.
#[derive(Clone, Debug)]
pub(super) struct TargetShapes {
    /// One row for each degree of freedom, one column for each coordinate of the model.
    pub rows: RealMatrix,
    /// One vector for each mode.
    pub vectors: Vec<Vec<f64>>,
}

/// What ties the shapes of a test to a model.
pub(super) struct ShapeRows {
    pairs: Vec<(Dof, f64, Vec<f64>)>,
    floor: f64,
}

impl ShapeRows {
    /// The common degrees of freedom of a test and the sensors, each with its sign and weight and its observation row.
    pub fn new(
        (model, values): (&dyn TheoreticalModel, &[f64]),
        sensors: &[Sensor],
        test: &ModalModel,
        options: &UpdateOptions,
        floor: f64,
    ) -> Result<Self, UpdateError> {
        let shapes = test.modes.iter().map(|mode| &mode.shape);
        let dofs = shapes.flat_map(|shape| shape.iter().map(|(dof, _)| dof));
        let own: Vec<Dof> = sensors.iter().map(|sensor| sensor.dof.positive()).collect();
        let map = DofMap::new(dofs, own.iter());
        let mixed = map.pairs.iter().any(|p| !p.test.axis().is_rotation());
        let length = options.pair.rotation_length_m.filter(|_| mixed);
        let mut pairs = Vec::with_capacity(map.len());
        for pair in &map.pairs {
            let sensor = sensors.iter().find(|s| s.dof.positive() == pair.theory);
            let Some(sensor) = sensor else { continue };
            let turns = pair.test.axis().is_rotation();
            let weight = if turns { length.unwrap_or(1.0) } else { 1.0 };
            let row = model.observation_row(values, &sensor.target)?;
            let row = row.iter().map(|part| weight * part).collect();
            pairs.push((pair.test.clone(), pair.sign * weight, row));
        }
        Ok(Self { pairs, floor })
    }

    /// The shapes of some modes of one root; `None` where fewer than two degrees of freedom are common to all of them and
    /// the model: a MAC over one says nothing.
    fn of(&self, modes: &[&Mode]) -> Option<TargetShapes> {
        let all = |dof: &Dof| modes.iter().all(|mode| mode.shape.get(dof).is_some());
        let kept: Vec<&(Dof, f64, Vec<f64>)> =
            self.pairs.iter().filter(|(dof, _, _)| all(dof)).collect();
        if kept.len() < 2 {
            return None;
        }
        let values = |mode: &&Mode| -> Vec<Complex64> {
            let value = |(dof, weight, _): &&(Dof, f64, Vec<f64>)| {
                mode.shape.get(dof).unwrap_or_default() * *weight
            };
            kept.iter().map(value).collect()
        };
        let real: Vec<Option<(Vec<f64>, f64)>> =
            modes.iter().map(|mode| real_shape(&values(mode))).collect();
        let real: Vec<(Vec<f64>, f64)> = real.into_iter().collect::<Option<_>>()?;
        let deviation = |d: usize| -> f64 {
            let (dof, weight, _) = kept[d];
            let of_mode = |(mode, (_, scale)): (&&Mode, &(Vec<f64>, f64))| {
                let std = std_at(mode.shape_std.as_ref(), dof);
                (std * weight * scale).powi(2)
            };
            let pairs = modes.iter().zip(&real);
            let variance = pairs.map(of_mode).sum::<f64>() / modes.len() as f64;
            (variance + self.floor * self.floor).sqrt()
        };
        let std: Vec<f64> = (0..kept.len()).map(deviation).collect();
        let columns = kept[0].2.len();
        let vectors = real.iter().map(|(values, _)| {
            let whitened = values.iter().zip(&std);
            whitened.map(|(value, std)| value / std).collect()
        });
        Some(TargetShapes {
            rows: real_matrix(kept.len(), columns, |d, i| kept[d].2[i] / std[d]),
            vectors: vectors.collect(),
        })
    }
}

fn std_at(stds: Option<&BTreeMap<Dof, f64>>, dof: &Dof) -> f64 {
    stds.and_then(|stds| stds.get(dof)).copied().unwrap_or(0.0)
}

/// A complex shape turned to where it is most real and scaled to components of root mean square 1, with that scale: an
/// undamped model has nothing to say of the rest. `None` for a zero shape.
fn real_shape(values: &[Complex64]) -> Option<(Vec<f64>, f64)> {
    let square: Complex64 = values.iter().map(|v| v * v).sum();
    let turn = Complex64::from_polar(1.0, -0.5 * square.arg());
    let turned: Vec<f64> = values.iter().map(|v| (v * turn).re).collect();
    let mean = turned.iter().map(|v| v * v).sum::<f64>() / turned.len() as f64;
    let scale = mean.sqrt().recip();
    let scaled = turned.iter().map(|v| v * scale).collect();
    scale.is_finite().then_some((scaled, scale))
}

/// The targets of one test.
pub(super) fn targets_of(
    test: usize,
    measured: &MeasuredModes<'_>,
    rows: Option<&ShapeRows>,
    options: &UpdateOptions,
) -> Result<Vec<Target>, UpdateError> {
    let model = measured.modes;
    let elastic = |own: &Vec<usize>| model.modes[own[0]].frequency_hz > 0.0;
    let roots = model.roots().into_iter().filter(elastic);
    let target = |own: Vec<usize>| {
        let modes: Vec<&Mode> = own.iter().map(|&i| &model.modes[i]).collect();
        let hz = modes.iter().map(|m| m.frequency_hz).sum::<f64>() / modes.len() as f64;
        let label = format!("{} f{}", measured.name, measured.number(own[0]));
        let hz_std = modes
            .iter()
            .filter_map(|m| m.frequency_uncertainty_hz())
            .reduce(f64::max);
        let relative_std = (hz_std.unwrap_or(0.0) / hz).hypot(options.frequency_floor);
        if !(relative_std.is_finite() && relative_std > 0.0) {
            return Err(UpdateError::NoUncertainty { label });
        }
        Ok(Target {
            label,
            test,
            shapes: rows.and_then(|rows| rows.of(&modes)),
            modes: own,
            hz,
            hz_std,
            relative_std,
        })
    };
    roots.map(target).collect()
}

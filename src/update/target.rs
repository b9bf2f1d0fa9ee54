//! Targets hold measured frequencies and shapes with their standard deviations.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::correlate::DofMap;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::linalg::real_matrix;
use crate::modal::{ModalModel, Mode};

use super::dynamic::DynamicTarget;
use super::target_shapes::TargetShapes;
use super::{UpdateError, UpdateOptions};

/// The modes of a test, or a list of published frequencies: modes without shapes, several of one
/// group number for a root of higher multiplicity.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredModes<'a> {
    /// Name.
    pub name: &'a str,
    /// Its modes.
    pub modes: &'a ModalModel,
    /// Number of each mode in labels; none for their places, from 1.
    pub numbers: &'a [usize],
    /// The FRFs that the modes are of; none where these are not at hand.
    pub frfs: &'a [FrfSet],
}

impl<'a> MeasuredModes<'a> {
    /// Modes that are numbered by their places, from 1.
    pub fn new(name: &'a str, modes: &'a ModalModel) -> Self {
        Self {
            name,
            modes,
            numbers: &[],
            frfs: &[],
        }
    }

    fn number(&self, mode: usize) -> usize {
        self.numbers.get(mode).copied().unwrap_or(mode + 1)
    }
}

/// Sensors of one test with the opposite sign of the model.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReversedSensors {
    /// Name of the test.
    pub test: String,
    /// The sensors, as the test names them.
    pub dofs: Vec<Dof>,
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
    /// Mean damping ratio of its modes; `None` where none is known.
    pub damping_ratio: Option<f64>,
    /// Standard deviation of the frequency as the test states it, Hz.
    pub hz_std: Option<f64>,
    /// Deviation that the residual is divided by, a fraction: the test's and the floor's, as
    /// independent. The floor is the model's, so that its variance is shared by all tests that
    /// measure the root: each of `k` is given `k` times it.
    pub relative_std: f64,
    /// Source of the deviations of its shapes; `None` where shapes take no part.
    pub shape_weights: Option<ShapeWeights>,
    /// Shapes, where they take part.
    pub(super) shapes: Option<TargetShapes>,
    /// Data of its modal dynamic residuals, where these are requested.
    pub(super) dynamic: Option<DynamicTarget>,
}

/// Source of the deviations of measured shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeWeights {
    /// From the test.
    Test,
    /// The test states none for some component: [`UpdateOptions::assumed_shape_std`] stands for it.
    Assumed,
}

impl Target {
    /// Sets the deviation of the residual from that of the test, the scatter between tests, and the
    /// model's floor shared by `tests` tests of the root.
    pub(super) fn weigh(
        &mut self,
        floor: f64,
        scatter: f64,
        tests: usize,
    ) -> Result<(), UpdateError> {
        let stated = self.hz_std.unwrap_or(0.0) / self.hz;
        let of_test = stated.hypot(scatter);
        self.relative_std = of_test.hypot(floor * (tests as f64).sqrt());
        if self.relative_std.is_finite() && self.relative_std > 0.0 {
            return Ok(());
        }
        let label = self.label.clone();
        Err(UpdateError::NoUncertainty { label })
    }

    /// Number of its independent residuals where the model's root has as many modes as were
    /// measured: its frequency, and its shapes less their free directions.
    pub(super) fn independent_count(&self) -> usize {
        let vectors = self.shapes.iter().flat_map(|shapes| &shapes.vectors);
        let of_shape = vectors.map(|v| v.len().saturating_sub(self.modes.len()));
        1 + of_shape.sum::<usize>()
    }
}

/// The correspondence of the shapes of a test with a model.
pub(super) struct ShapeRows {
    pairs: Vec<ShapeRow>,
    floor: f64,
    assumed: f64,
}

/// A degree of freedom that a test and the model share.
struct ShapeRow {
    /// As the test names it.
    test: Dof,
    /// As the model's sensor has it.
    sensor: Dof,
    /// Sign and weight.
    factor: f64,
    /// Observation row, weighted.
    row: Vec<f64>,
}

impl ShapeRows {
    /// The common degrees of freedom of a test and of the sensors of the model, given with their
    /// observation rows; without the test's reversed sensors and what it did not measure.
    pub fn new(
        sensors: &[(Dof, Vec<f64>)],
        test: &ModalModel,
        reversed: &[Dof],
        options: &UpdateOptions,
        floor: f64,
    ) -> Self {
        let unmeasured = test.unmeasured_dofs();
        let shapes = test.modes.iter().map(|mode| &mode.shape);
        let dofs = shapes.flat_map(|shape| shape.iter().map(|(dof, _)| dof));
        let dofs = dofs.filter(|dof| !unmeasured.contains(dof));
        let map = DofMap::new(dofs, sensors.iter().map(|(sensor, _)| sensor));
        let mixed = map.pairs.iter().any(|p| !p.test.axis().is_rotation());
        let length = options.pair.rotation_length_m.filter(|_| mixed);
        let mut pairs = Vec::with_capacity(map.len());
        for pair in map
            .pairs
            .iter()
            .filter(|pair| !reversed.contains(&pair.test))
        {
            let observed = sensors.iter().find(|(sensor, _)| *sensor == pair.theory);
            let Some((_, row)) = observed else { continue };
            let turns = pair.test.axis().is_rotation();
            let weight = if turns { length.unwrap_or(1.0) } else { 1.0 };
            pairs.push(ShapeRow {
                test: pair.test.clone(),
                sensor: pair.theory.clone(),
                factor: pair.sign * weight,
                row: row.iter().map(|part| weight * part).collect(),
            });
        }
        Self {
            pairs,
            floor,
            assumed: options.assumed_shape_std,
        }
    }

    /// Whether it has a sensor of the model.
    pub fn reads(&self, sensor: &Dof) -> bool {
        self.pairs.iter().any(|pair| pair.sensor == *sensor)
    }

    /// The shapes of some modes of one root; `None` where fewer than two degrees of freedom are
    /// common to all of them and the model: a MAC over one is always 1. `tests` counts the tests
    /// that measure the root at a sensor.
    pub fn of(
        &self,
        modes: &[&Mode],
        tests: impl Fn(&Dof) -> usize,
    ) -> Option<(TargetShapes, ShapeWeights)> {
        let all = |dof: &Dof| modes.iter().all(|mode| mode.shape.get(dof).is_some());
        let kept: Vec<&ShapeRow> = self.pairs.iter().filter(|pair| all(&pair.test)).collect();
        if kept.len() < 2 {
            return None;
        }
        let values = |mode: &&Mode| -> Vec<Complex64> {
            let value =
                |pair: &&ShapeRow| mode.shape.get(&pair.test).unwrap_or_default() * pair.factor;
            kept.iter().map(value).collect()
        };
        let real: Vec<Option<(Vec<f64>, f64)>> =
            modes.iter().map(|mode| real_shape(&values(mode))).collect();
        let real: Vec<(Vec<f64>, f64)> = real.into_iter().collect::<Option<_>>()?;
        let mut weights = ShapeWeights::Test;
        let mut deviation = |pair: &ShapeRow| -> f64 {
            let mut variance = 0.0;
            for (mode, (_, scale)) in modes.iter().zip(&real) {
                let stated = stated_std(mode, &pair.test).map(|std| std * pair.factor * scale);
                if stated.is_none() {
                    weights = ShapeWeights::Assumed;
                }
                variance += stated.unwrap_or(self.assumed).powi(2) / modes.len() as f64;
            }
            (variance + tests(&pair.sensor) as f64 * self.floor * self.floor).sqrt()
        };
        let std: Vec<f64> = kept.iter().map(|pair| deviation(pair)).collect();
        let columns = kept[0].row.len();
        let vectors = real.iter().map(|(values, _)| {
            let whitened = values.iter().zip(&std);
            whitened.map(|(value, std)| value / std).collect()
        });
        let shapes = TargetShapes {
            rows: real_matrix(kept.len(), columns, |d, i| kept[d].row[i] / std[d]),
            vectors: vectors.collect(),
        };
        Some((shapes, weights))
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let all: Vec<f64> = values.collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

fn stated_std(mode: &Mode, dof: &Dof) -> Option<f64> {
    mode.shape_std.as_ref()?.get(dof).copied()
}

/// A complex shape turned to where it is most real and scaled to components of root mean square 1,
/// with that scale: an undamped model has no imaginary part to compare. `None` for a zero shape.
fn real_shape(values: &[Complex64]) -> Option<(Vec<f64>, f64)> {
    let square: Complex64 = values.iter().map(|v| v * v).sum();
    let turn = Complex64::from_polar(1.0, -0.5 * square.arg());
    let turned: Vec<f64> = values.iter().map(|v| (v * turn).re).collect();
    let mean = turned.iter().map(|v| v * v).sum::<f64>() / turned.len() as f64;
    let scale = mean.sqrt().recip();
    let scaled = turned.iter().map(|v| v * scale).collect();
    scale.is_finite().then_some((scaled, scale))
}

/// The targets of one test, weighted as if no other test measured their roots; without shapes.
pub(super) fn targets_of(
    test: usize,
    measured: &MeasuredModes<'_>,
    floor: f64,
) -> Result<Vec<Target>, UpdateError> {
    let model = measured.modes;
    let elastic = |modes: &Vec<usize>| model.modes[modes[0]].frequency_hz > 0.0;
    let roots = model.roots().into_iter().filter(elastic);
    let target = |group: Vec<usize>| {
        let modes: Vec<&Mode> = group.iter().map(|&i| &model.modes[i]).collect();
        let hz = modes.iter().map(|m| m.frequency_hz).sum::<f64>() / modes.len() as f64;
        let hz_std = modes
            .iter()
            .filter_map(|m| m.frequency_uncertainty_hz())
            .reduce(f64::max);
        let mut target = Target {
            label: format!("{} f{}", measured.name, measured.number(group[0])),
            test,
            modes: group,
            hz,
            hz_std,
            damping_ratio: mean(modes.iter().filter_map(|m| m.damping_ratio)),
            relative_std: 0.0,
            shape_weights: None,
            shapes: None,
            dynamic: None,
        };
        // Scatter between tests, which is not known yet, may be the only uncertainty.
        target.weigh(floor.max(f64::MIN_POSITIVE), 0.0, 1)?;
        Ok(target)
    };
    roots.map(target).collect()
}

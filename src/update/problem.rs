//! An update problem holds model, free parameters and targets; it computes residuals and their
//! derivatives at any point.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::axis::Band;
use crate::correlate::PairOptions;
use crate::correlate::measures::reversed_sensors;
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::linalg::real_matrix;
use crate::modal::{ModalModel, Mode};
use crate::theory::{
    ModeDerivatives, ModeOptions, TheoreticalModel, TheoryError, TheoryModes, check_values,
    mode_derivatives, modes, modes_of_matrices,
};

use super::configuration::{Configuration, Part, parts_of};
use super::frfs::FrfTarget;
use super::mode_tracking::{PairedModes, follow, with_whole_roots, without_unseen};
use super::model_state::ModelState;
use super::residual::RootPairResidual;
use super::scatter::{Scatter, scatter};
use super::target::{ReversedSensors, ShapeRows, targets_of};
use super::{
    Evaluation, FreeParameter, MeasuredModes, ParameterChoice, Residuals, RootPair, Target,
    UpdateError, UpdateOptions,
};

/// Frequency gate of pairing at a start and after an iteration, a fraction: from half the frequency
/// to twice.
const MAX_START_FREQUENCY_ERROR: f64 = 1.0;

/// Models whose parameters are updated to measured modes: one, or one for each configuration of a
/// machine.
#[derive(Clone, Debug)]
pub struct UpdateProblem<'a> {
    /// The configurations; the first one has the model that is updated.
    pub(super) parts: Vec<Part<'a>>,
    /// The parameters that may change.
    pub free: Vec<FreeParameter>,
    /// Measured modes that have a partner in the model at the start.
    pub targets: Vec<Target>,
    /// Labels and frequencies (Hz) of measured modes without a partner; they take no part.
    pub left_out: Vec<(String, f64)>,
    /// Targets, by their index, whose partner at the start is outside the frequency gate.
    pub(super) far: Vec<usize>,
    /// Sensors of each test with the opposite sign of the model at the start; their values take no
    /// part.
    pub reversed: Vec<ReversedSensors>,
    /// Scatter between the tests of a configuration, where it was requested and can be estimated.
    pub(super) scatter: Option<Scatter>,
    /// Options.
    pub options: UpdateOptions,
    pub(super) tests: Vec<PairedModes>,
    /// Weight of the prior's rows.
    pub(super) prior_weight: f64,
    /// The FRFs that are compared; none where the options compare modes.
    pub(super) frfs: Arc<Vec<FrfTarget>>,
    /// Number of FRFs of the tests, those that no sensor of the model reads included.
    pub(super) frfs_given: usize,
    /// Whether the FRFs are the residuals now.
    pub(super) compares_frfs: bool,
}

impl<'a> UpdateProblem<'a> {
    /// A problem that starts from these values. Modes at 0 Hz take no part.
    ///
    /// # Errors
    /// [`UpdateError`] for an invalid option, parameter or mode, and when no mode was paired.
    pub fn new(
        model: &'a dyn TheoreticalModel,
        values: &[f64],
        choices: &[ParameterChoice],
        measured: &[MeasuredModes<'_>],
        sensors: &'a [Sensor],
        options: UpdateOptions,
    ) -> Result<Self, UpdateError> {
        let only = Configuration {
            name: "",
            model,
            values,
            sensors,
            measured,
            held: &[],
            separate: &[],
        };
        Self::of_configurations(&[only], choices, options)
    }

    /// A problem of several configurations with shared parameters, which starts from the values of
    /// the first configuration that has each.
    ///
    /// # Errors
    /// As [`UpdateProblem::new`]; [`UpdateError::SharedValue`] for a shared parameter with another
    /// value in a later configuration.
    pub fn of_configurations(
        configurations: &[Configuration<'a, '_>],
        choices: &[ParameterChoice],
        options: UpdateOptions,
    ) -> Result<Self, UpdateError> {
        options.validate()?;
        for Configuration { model, values, .. } in configurations {
            check_values(model.name(), model.parameters(), values)?;
        }
        let (parts, free) = parts_of(configurations, choices, &options)?;
        let measured: Vec<MeasuredModes<'_>> = configurations
            .iter()
            .flat_map(|configuration| configuration.measured.iter().copied())
            .collect();
        let measured = measured.as_slice();
        let mut targets = Vec::new();
        for (test, set) in measured.iter().enumerate() {
            targets.extend(targets_of(test, set, options.frequency_floor)?);
        }
        let mut problem = Self {
            parts,
            free,
            targets,
            left_out: Vec::new(),
            far: Vec::new(),
            reversed: Vec::new(),
            scatter: None,
            options,
            tests: Vec::new(),
            prior_weight: 1.0,
            frfs: Arc::default(),
            frfs_given: 0,
            compares_frfs: false,
        };
        problem.keep_paired(measured)?;
        problem.reversed = problem.reversed_sensors(measured)?;
        problem.weigh(measured)?;
        if problem.options.residuals == Residuals::ModalDynamic {
            let start = problem.start(&vec![0.0; problem.free.len()])?;
            problem.prepare_dynamic(&start)?;
        }
        if problem.options.residuals.of_frfs() {
            problem.prepare_frfs(measured)?;
        }
        Ok(problem)
    }

    /// Frequencies and shapes with their deviations, the model's floor shared by the tests that
    /// measure a root.
    fn weigh(&mut self, measured: &[MeasuredModes<'_>]) -> Result<(), UpdateError> {
        let root_pairs = self.root_pairs(&self.initial(), &self.options.pair)?;
        if self.options.scatter_between_tests {
            self.scatter = scatter(&self.targets, &root_pairs);
        }
        let mut rows: Vec<Option<ShapeRows>> = Vec::with_capacity(measured.len());
        for part in &self.parts {
            let sensors = part.observation_rows()?;
            rows.extend(part.tests.clone().map(|test| {
                let (modes, reversed) = (measured[test].modes, &self.reversed[test].dofs);
                let rows = |floor| ShapeRows::new(&sensors, modes, reversed, &self.options, floor);
                self.options.shape_floor.map(rows)
            }));
        }
        for t in 0..self.targets.len() {
            let others = others_of(t, &root_pairs, &self.targets);
            let floor = self.options.frequency_floor;
            let scatter = self.scatter.map_or(0.0, |scatter| scatter.relative_std);
            let target = &mut self.targets[t];
            target.weigh(floor, scatter, 1 + others.len())?;
            let Some(pairing_rows) = &rows[target.test] else {
                continue;
            };
            let reads = |test: usize, dof: &Dof| rows[test].as_ref().is_some_and(|r| r.reads(dof));
            let tests = |dof: &Dof| 1 + others.iter().filter(|&&test| reads(test, dof)).count();
            let model = measured[target.test].modes;
            let modes: Vec<&Mode> = target.modes.iter().map(|&i| &model.modes[i]).collect();
            let shapes = pairing_rows.of(&modes, tests);
            (target.shapes, target.shape_weights) = shapes.unzip();
        }
        Ok(())
    }

    /// Sensors of each test with the opposite sign of the model at the start, where values of
    /// sensors take part. A sensor that is reversed twice, alone and with its group, is not.
    fn reversed_sensors(
        &self,
        measured: &[MeasuredModes<'_>],
    ) -> Result<Vec<ReversedSensors>, UpdateError> {
        let takes_part =
            self.options.shape_floor.is_some() || self.options.residuals == Residuals::FrfComplex;
        if !takes_part {
            let none = |set: &MeasuredModes<'_>| ReversedSensors {
                test: set.name.to_owned(),
                dofs: Vec::new(),
            };
            return Ok(measured.iter().map(none).collect());
        }
        let mut all = Vec::with_capacity(measured.len());
        for (part, values) in self.parts.iter().zip(self.initial()) {
            let theory = self.theory(part, &values)?.model;
            for (test, paired) in measured[part.tests.clone()]
                .iter()
                .zip(&self.tests[part.tests.clone()])
            {
                let found = reversed_sensors(&paired.modes, &theory, &self.options.pair)?;
                all.push(ReversedSensors {
                    test: test.name.to_owned(),
                    dofs: named_odd_times(found.into_iter().map(|sensor| sensor.dof)),
                });
            }
        }
        Ok(all)
    }

    /// Leaves out measured roots without a partner at the start. One outside the frequency gate is
    /// kept where its partner from half the frequency to twice is a root of the model that no other
    /// has; without shapes, where all together have partners there.
    fn keep_paired(&mut self, measured: &[MeasuredModes<'_>]) -> Result<(), UpdateError> {
        self.tests = self.paired_modes(measured.iter().map(|set| set.modes));
        let near = self.root_pairs(&self.initial(), &self.options.pair)?;
        let linked = |root_pairs: &[RootPair], t: usize| {
            let mut root_pairs = root_pairs.iter();
            root_pairs.any(|root_pair| root_pair.targets.contains(&t))
        };
        let count = self.targets.len();
        let mut kept: Vec<bool> = (0..count).map(|t| linked(&near, t)).collect();
        let mut far = vec![false; count];
        if kept.contains(&false) {
            let test = |root_pair: &RootPair| self.targets[root_pair.targets[0]].test;
            for root_pair in self.root_pairs(&self.initial(), &self.wide_gate())? {
                let is_free = !self.tests[test(&root_pair)].has_shapes()
                    || near.iter().all(|known| {
                        test(known) != test(&root_pair)
                            || known
                                .modes
                                .iter()
                                .all(|mode| !root_pair.modes.contains(mode))
                    });
                for &t in root_pair.targets.iter().filter(|t| is_free && !kept[**t]) {
                    far[t] = true;
                }
            }
        }
        for (kept, far) in kept.iter_mut().zip(&far) {
            *kept |= far;
        }
        if !kept.contains(&true) {
            return Err(UpdateError::NothingPaired {
                modes: self.targets.len(),
            });
        }
        let all = std::mem::take(&mut self.targets);
        for ((target, kept), far) in all.into_iter().zip(kept).zip(far) {
            if kept {
                if far {
                    self.far.push(self.targets.len());
                }
                self.targets.push(target);
            } else {
                self.left_out.push((target.label, target.hz));
            }
        }
        self.tests = self.paired_modes(measured.iter().map(|set| set.modes));
        Ok(())
    }

    /// The same problem without the targets whose partner at the start is outside the frequency
    /// gate; `None` where there are none, or no other.
    pub(super) fn without_far(&self) -> Option<Self> {
        if self.far.is_empty() || self.far.len() == self.targets.len() {
            return None;
        }
        let mut near = self.clone();
        for &t in self.far.iter().rev() {
            let target = &self.targets[t];
            near.left_out.push((target.label.clone(), target.hz));
            near = near.without_target(t);
        }
        near.far.clear();
        Some(near)
    }

    /// Options of a pairing from half the frequency to twice.
    fn wide_gate(&self) -> PairOptions {
        PairOptions {
            max_frequency_error: self.start_gate(),
            ..self.options.pair.clone()
        }
    }

    fn paired_modes<'b>(&self, models: impl Iterator<Item = &'b ModalModel>) -> Vec<PairedModes> {
        let of_test = |(test, model)| PairedModes::new(test, model, &self.targets);
        models.enumerate().map(of_test).collect()
    }

    /// The same problem with some of its free parameters, by their index.
    pub fn with_free(&self, places: &[usize]) -> Self {
        Self {
            free: places.iter().map(|&j| self.free[j].clone()).collect(),
            parts: self
                .parts
                .iter()
                .map(|part| part.with_free(places))
                .collect(),
            ..self.clone()
        }
    }

    /// The same problem with a free parameter that has another value in one configuration.
    pub(super) fn with_separate(&self, configuration: usize, j: usize) -> Self {
        let mut separate = self.clone();
        separate.free.push(self.free[j].clone());
        for (c, part) in separate.parts.iter_mut().enumerate() {
            *part = match c == configuration {
                true => part.with_separate(j),
                false => part.with_another(),
            };
        }
        separate
    }

    /// The same problem with another weight of the prior's rows.
    pub(super) fn with_prior_weight(&self, prior_weight: f64) -> Self {
        Self {
            prior_weight,
            ..self.clone()
        }
    }

    /// The same problem with shapes of another weight.
    pub(super) fn with_shape_weight(&self, weight: f64) -> Self {
        let mut weighted = self.clone();
        for target in &mut weighted.targets {
            if let Some(shapes) = &mut target.shapes {
                *shapes = shapes.scaled(weight);
            }
        }
        weighted
    }

    /// The same problem with larger deviations of frequencies, of shapes, or of all residuals.
    pub(super) fn with_grown_deviations(&self, frequency: f64, shape: f64, other: f64) -> Self {
        let mut grown = self.with_shape_weight(shape.recip());
        for target in &mut grown.targets {
            target.relative_std *= frequency;
        }
        // A prior of a larger weight is data of a smaller one.
        grown.prior_weight *= other;
        grown
    }

    /// The same problem without one of its targets.
    pub fn without_target(&self, gone: usize) -> Self {
        let mut reduced = self.clone();
        reduced.targets.remove(gone);
        for test in &mut reduced.tests {
            let kept: Vec<usize> = (0..test.target.len())
                .filter(|&i| test.target[i] != gone)
                .collect();
            let modes = &test.modes.modes;
            test.modes.modes = kept.iter().map(|&i| modes[i].clone()).collect();
            let renumbered = |t: usize| if t > gone { t - 1 } else { t };
            test.target = kept.iter().map(|&i| renumbered(test.target[i])).collect();
        }
        reduced
    }

    /// All parameters of the model of each configuration with the free ones at `z`.
    pub fn values(&self, z: &[f64]) -> Vec<Vec<f64>> {
        let values = self.free.iter().zip(z);
        let values: Vec<f64> = values.map(|(parameter, z)| parameter.value(*z)).collect();
        self.parts.iter().map(|part| part.values(&values)).collect()
    }

    /// The values at the start.
    fn initial(&self) -> Vec<Vec<f64>> {
        self.values(&vec![0.0; self.free.len()])
    }

    /// Index of the configuration of a test.
    pub(super) fn part_of(&self, test: usize) -> usize {
        let mut parts = self.parts.iter();
        let found = parts.position(|part| part.tests.contains(&test));
        found.expect("each test has its configuration")
    }

    pub(super) fn root_pairs(
        &self,
        values: &[Vec<f64>],
        pair: &PairOptions,
    ) -> Result<Vec<RootPair>, UpdateError> {
        let mut all = Vec::new();
        for (c, (part, values)) in self.parts.iter().zip(values).enumerate() {
            all.extend(self.root_pairs_of(c, part, values, pair)?);
        }
        Ok(all)
    }

    fn root_pairs_of(
        &self,
        configuration: usize,
        part: &Part<'_>,
        values: &[f64],
        pair: &PairOptions,
    ) -> Result<Vec<RootPair>, UpdateError> {
        if part.tests.is_empty() {
            return Ok(Vec::new());
        }
        let theory = self.theory(part, values)?;
        let mut root_pairs = Vec::new();
        for test in &self.tests[part.tests.clone()] {
            root_pairs.extend(test.root_pairs(
                configuration,
                &theory.model,
                &self.targets,
                pair,
            )?);
        }
        let gate = self.start_gate().ln_1p();
        for root_pair in &mut root_pairs {
            let hz = root_pair
                .modes
                .iter()
                .map(|&k| theory.model.modes[k].frequency_hz);
            let hz = hz.sum::<f64>() / root_pair.modes.len() as f64;
            // Pairing may take errors as parts of the model's frequency, which then has no upper
            // limit.
            let near = |t: &usize| (hz / self.targets[*t].hz).ln().abs() <= gate;
            root_pair.targets.retain(near);
        }
        root_pairs.retain(|root_pair| !root_pair.targets.is_empty());
        Ok(root_pairs)
    }

    /// Modes of a model that can be partners of a target.
    fn theory(&self, part: &Part<'_>, values: &[f64]) -> Result<TheoryModes, UpdateError> {
        let options = ModeOptions {
            band: self.partner_band(part),
            ..ModeOptions::default()
        };
        Ok(modes(part.model, values, part.sensors, &options)?)
    }

    /// Band from 0 to the highest frequency that a partner can have, in which the modes of a sparse
    /// model are computed. `None` without a target, and for an infinite frequency.
    fn partner_band(&self, part: &Part<'_>) -> Option<Band> {
        let targets = self.targets.iter();
        let targets = targets.filter(|target| part.tests.contains(&target.test));
        let highest = targets.map(|target| target.hz).reduce(f64::max);
        highest.and_then(|hz| Band::new(0.0, hz * (1.0 + self.start_gate())).ok())
    }

    fn start_gate(&self) -> f64 {
        self.options
            .pair
            .max_frequency_error
            .max(MAX_START_FREQUENCY_ERROR)
    }

    /// The model at `z`, paired with the test there; where a target stays without a partner, paired
    /// from half the frequency to twice, as a start may be far off.
    ///
    /// # Errors
    /// [`UpdateError::Theory`], [`UpdateError::Correlate`].
    pub fn start(&self, z: &[f64]) -> Result<Evaluation, UpdateError> {
        let values = self.values(z);
        let mut root_pairs = self.root_pairs(&values, &self.options.pair)?;
        if self.unpaired(&root_pairs).next().is_some() {
            root_pairs = self.root_pairs(&values, &self.wide_gate())?;
        }
        self.evaluate(z, |_| root_pairs)
    }

    /// The model at `z` with its modes followed from a point nearby; `None` where it has no modes
    /// there.
    ///
    /// # Errors
    /// [`UpdateError::Linalg`].
    pub fn follow(&self, z: &[f64], from: &Evaluation) -> Result<Option<Evaluation>, UpdateError> {
        let followed = |states: &[ModelState]| follow_all(from, states);
        match self.evaluate(z, followed) {
            Ok(found) => Ok(Some(found)),
            Err(UpdateError::Theory(
                TheoryError::OutOfBounds { .. }
                | TheoryError::PropertyOutOfRange { .. }
                | TheoryError::NegativeStiffness { .. }
                | TheoryError::Mass(_)
                | TheoryError::Linalg(_),
            )) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn evaluate(
        &self,
        z: &[f64],
        root_pairs: impl FnOnce(&[ModelState]) -> Vec<RootPair>,
    ) -> Result<Evaluation, UpdateError> {
        let state = |(part, values): (&Part<'_>, Vec<f64>)| {
            let matrices = part.model.assemble(&values)?;
            let modes = modes_of_matrices(&matrices, &ModeOptions::default())?;
            Ok(ModelState {
                values,
                modes,
                matrices,
            })
        };
        let states = self.parts.iter().zip(self.values(z)).map(state);
        let states: Vec<ModelState> = states.collect::<Result<_, UpdateError>>()?;
        let root_pairs = without_unseen(root_pairs(&states), &self.targets, &states);
        let root_pairs = with_whole_roots(root_pairs, &self.targets, &states);
        let mut residual = self.data_residuals(&states, &root_pairs)?;
        let data_rows = residual.len();
        residual.extend(z.iter().map(|z| self.prior_weight * z));
        Ok(Evaluation {
            z: z.to_vec(),
            root_pairs,
            states,
            residual,
            data_rows,
        })
    }

    /// Targets without a partner.
    pub(super) fn unpaired<'b>(
        &'b self,
        root_pairs: &'b [RootPair],
    ) -> impl Iterator<Item = &'b Target> {
        let alone = |t: &usize| {
            !root_pairs
                .iter()
                .any(|root_pair| root_pair.targets.contains(t))
        };
        (0..self.targets.len())
            .filter(alone)
            .map(|t| &self.targets[t])
    }

    /// The model at `z` with given root pairs.
    pub(super) fn at_root_pairs(
        &self,
        z: &[f64],
        root_pairs: Vec<RootPair>,
    ) -> Result<Evaluation, UpdateError> {
        self.evaluate(z, |_| root_pairs)
    }

    /// The residuals of all root pairs, in their order.
    pub(super) fn residuals<'b>(&'b self, at: &'b Evaluation) -> Vec<RootPairResidual<'b>> {
        let root_pairs = at.root_pairs.iter();
        let residuals =
            root_pairs.map(|root_pair| RootPairResidual::new(root_pair, &self.targets, &at.states));
        residuals.collect()
    }

    /// Derivatives of the modes of every root pair by each free parameter, and its `dp/dz`.
    pub(super) fn derivatives(
        &self,
        at: &Evaluation,
        residuals: &[RootPairResidual<'_>],
    ) -> Result<Vec<(Vec<ModeDerivatives>, f64)>, UpdateError> {
        let mut all: Vec<(Vec<ModeDerivatives>, f64)> = self
            .free
            .iter()
            .zip(&at.z)
            .map(|(parameter, z)| (Vec::new(), parameter.slope(parameter.value(*z))))
            .collect();
        for (c, state) in at.states.iter().enumerate() {
            let pairs = at.root_pairs.iter().zip(residuals);
            let roots = pairs.filter(|(root_pair, _)| root_pair.configuration == c);
            let roots: Vec<&[usize]> = roots
                .map(|(_, residual)| residual.modes_of_root_pair())
                .collect();
            let by = self.parts[c].derivatives(state)?;
            for ((column, _), by) in all.iter_mut().zip(&by) {
                match by {
                    Some(by) => column.extend(mode_derivatives(&state.modes, &roots, by)?),
                    None => column.extend(roots.iter().map(|root| unchanged(state, root.len()))),
                }
            }
        }
        for (place, residual) in residuals.iter().enumerate() {
            let mut of_root_pair: Vec<(&mut ModeDerivatives, f64)> = all
                .iter_mut()
                .map(|(column, slope)| (&mut column[place], *slope))
                .collect();
            residual.split(&mut of_root_pair)?;
        }
        Ok(all)
    }

    /// Frequency of the model (Hz) and MAC of each target; `None` for one without a partner.
    pub fn fits(&self, at: &Evaluation) -> Vec<Option<(f64, Option<f64>)>> {
        let mut fits = vec![None; self.targets.len()];
        for root_pair in &at.root_pairs {
            let residual = RootPairResidual::new(root_pair, &self.targets, &at.states);
            for (place, hz) in residual.frequencies_hz().into_iter().enumerate() {
                fits[root_pair.targets[place]] = Some((hz, residual.mac(place)));
            }
        }
        fits
    }
}

/// The other tests that measure a mode of the model that a target measures.
fn others_of(target: usize, root_pairs: &[RootPair], targets: &[Target]) -> Vec<usize> {
    let test = |root_pair: &RootPair| targets[root_pair.targets[0]].test;
    let of_target = root_pairs
        .iter()
        .find(|root_pair| root_pair.targets.contains(&target));
    let Some(followed) = of_target else {
        return Vec::new();
    };
    let meets = |root_pair: &&RootPair| {
        let mut modes = root_pair.modes.iter();
        root_pair.configuration == followed.configuration
            && modes.any(|mode| followed.modes.contains(mode))
    };
    let mut others: Vec<usize> = root_pairs.iter().filter(meets).map(test).collect();
    others.retain(|&other| other != targets[target].test);
    others.sort_unstable();
    others.dedup();
    others
}

/// Derivatives of the modes of a root by a parameter that its model does not have.
fn unchanged(state: &ModelState, modes: usize) -> ModeDerivatives {
    let coordinates = state.modes.vectors.nrows();
    ModeDerivatives {
        projected: real_matrix(modes, modes, |_, _| 0.0),
        vectors: real_matrix(coordinates, modes, |_, _| 0.0),
    }
}

/// The root pairs of an evaluation after the modes of the models have changed, those of each
/// configuration by its model.
fn follow_all(from: &Evaluation, after: &[ModelState]) -> Vec<RootPair> {
    let of_configuration = |(c, (before, after)): (usize, (&ModelState, &ModelState))| {
        let pairs = from.root_pairs.iter();
        let pairs = pairs.filter(|root_pair| root_pair.configuration == c);
        let pairs: Vec<RootPair> = pairs.cloned().collect();
        follow(&pairs, &before.modes, &before.matrices.mass, &after.modes)
    };
    let states = from.states.iter().zip(after).enumerate();
    states.flat_map(of_configuration).collect()
}

/// The sensors that are named an odd number of times, in order.
fn named_odd_times(dofs: impl Iterator<Item = Dof>) -> Vec<Dof> {
    let mut odd: BTreeSet<Dof> = BTreeSet::new();
    for dof in dofs {
        if !odd.remove(&dof) {
            odd.insert(dof);
        }
    }
    odd.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_reversed_alone_and_with_its_group_keeps_its_sign() {
        let dofs = |names: &[&str]| -> Vec<Dof> {
            names.iter().map(|name| name.parse().unwrap()).collect()
        };
        let found = dofs(&["1:+Y", "2:+Y", "3:+Y", "2:+Y"]);
        assert_eq!(named_odd_times(found.into_iter()), dofs(&["1:+Y", "3:+Y"]));
    }
}

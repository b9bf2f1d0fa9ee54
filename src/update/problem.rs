//! An update problem holds model, free parameters and targets; it computes residuals and their
//! derivatives at any point.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::axis::Band;
use crate::correlate::PairOptions;
use crate::correlate::measures::reversed_sensors;
use crate::dof::Dof;
use crate::geometry::Sensor;
use crate::modal::{ModalModel, Mode};
use crate::theory::{
    ModeDerivatives, ModeOptions, TheoreticalModel, TheoryError, TheoryModes, check_values,
    mode_derivatives, modes, modes_of_matrices,
};

use super::frfs::FrfTarget;
use super::mode_tracking::{PairedModes, follow, with_whole_roots, without_unseen};
use super::parameter::free_parameters;
use super::residual::LinkResidual;
use super::target::{ReversedSensors, ShapeRows, targets_of};
use super::{
    Evaluation, FreeParameter, Link, MeasuredModes, ParameterChoice, Residuals, Target,
    UpdateError, UpdateOptions,
};

/// Frequency gate of pairing at a start and after an iteration, a fraction to both sides: within
/// twice the frequency.
const START_GATE: f64 = 1.0;

/// A model to be brought to measured modes.
#[derive(Clone, Debug)]
pub struct UpdateProblem<'a> {
    pub(super) model: &'a dyn TheoreticalModel,
    pub(super) sensors: &'a [Sensor],
    /// Values of all parameters at the start.
    pub initial: Vec<f64>,
    /// The parameters that may change.
    pub free: Vec<FreeParameter>,
    /// Measured modes that have a partner in the model at the start.
    pub targets: Vec<Target>,
    /// Labels and frequencies (Hz) of what was measured and has none; these play no part.
    pub left_out: Vec<(String, f64)>,
    /// Sensors of each test with the opposite sign of the model at the start; their values take no
    /// part.
    pub reversed: Vec<ReversedSensors>,
    /// Options.
    pub options: UpdateOptions,
    pub(super) tests: Vec<PairedModes>,
    /// Weight of the prior's rows.
    pub(super) prior_weight: f64,
    /// The functions, where the options ask for them.
    pub(super) frfs: Arc<Vec<FrfTarget>>,
    /// Number of functions of the tests, with those that no sensor of the model reads.
    pub(super) frfs_given: usize,
    /// Whether they are the residuals now.
    pub(super) compares_frfs: bool,
}

impl<'a> UpdateProblem<'a> {
    /// A problem that starts from these values. Modes at 0 Hz play no part.
    ///
    /// # Errors
    /// [`UpdateError`] for an option, a parameter or a mode that cannot be meant, and when nothing
    /// was paired.
    pub fn new(
        model: &'a dyn TheoreticalModel,
        values: &[f64],
        choices: &[ParameterChoice],
        measured: &[MeasuredModes<'_>],
        sensors: &'a [Sensor],
        options: UpdateOptions,
    ) -> Result<Self, UpdateError> {
        options.validate()?;
        check_values(model.name(), model.parameters(), values)?;
        let free = free_parameters(model, values, choices, &options)?;
        let mut targets = Vec::new();
        for (test, set) in measured.iter().enumerate() {
            targets.extend(targets_of(test, set, options.frequency_floor)?);
        }
        let mut problem = Self {
            model,
            sensors,
            initial: values.to_vec(),
            free,
            targets,
            left_out: Vec::new(),
            reversed: Vec::new(),
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
            problem.prepare_dynamic(&start.modes, &start.links)?;
        }
        if problem.options.residuals.of_frfs() {
            problem.prepare_frfs(measured)?;
        }
        Ok(problem)
    }

    /// Frequencies and shapes with their deviations, the model's floor shared by the tests that
    /// measure a root.
    fn weigh(&mut self, measured: &[MeasuredModes<'_>]) -> Result<(), UpdateError> {
        let links = self.links(&self.initial, &self.options.pair)?;
        let sensors = self.observation_rows()?;
        let rows = measured.iter().zip(&self.reversed).map(|(set, reversed)| {
            let rows =
                |floor| ShapeRows::new(&sensors, set.modes, &reversed.dofs, &self.options, floor);
            self.options.shape_floor.map(rows)
        });
        let rows: Vec<Option<ShapeRows>> = rows.collect();
        for t in 0..self.targets.len() {
            let others = others_of(t, &links, &self.targets);
            let floor = self.options.frequency_floor;
            let target = &mut self.targets[t];
            target.weigh(floor, 1 + others.len())?;
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

    /// The sensors of the model, each with its observation row at the start.
    pub(super) fn observation_rows(&self) -> Result<Vec<(Dof, Vec<f64>)>, UpdateError> {
        let row = |sensor: &Sensor| {
            let row = self.model.observation_row(&self.initial, &sensor.target)?;
            Ok((sensor.dof.positive(), row))
        };
        self.sensors.iter().map(row).collect()
    }

    /// Sensors of each test with the opposite sign of the model at the start, where values of
    /// sensors take part. A sensor that is reversed twice, alone and with its group, is not.
    fn reversed_sensors(
        &self,
        measured: &[MeasuredModes<'_>],
    ) -> Result<Vec<ReversedSensors>, UpdateError> {
        let names = measured.iter().map(|set| set.name.to_owned());
        let takes_part =
            self.options.shape_floor.is_some() || self.options.residuals == Residuals::FrfComplex;
        if !takes_part {
            let none = |test| ReversedSensors {
                test,
                dofs: Vec::new(),
            };
            return Ok(names.map(none).collect());
        }
        let theory = self.theory(&self.initial)?.model;
        let of_test = |(test, paired): (String, &PairedModes)| {
            let found = reversed_sensors(&paired.modes, &theory, &self.options.pair)?;
            let dofs = named_odd_times(found.into_iter().map(|sensor| sensor.dof));
            Ok(ReversedSensors { test, dofs })
        };
        names.zip(&self.tests).map(of_test).collect()
    }

    /// Leaves out what has no partner at the start.
    fn keep_paired(&mut self, measured: &[MeasuredModes<'_>]) -> Result<(), UpdateError> {
        self.tests = self.paired_modes(measured.iter().map(|set| set.modes));
        let links = self.links(&self.initial, &self.options.pair)?;
        let linked = |t: usize| links.iter().any(|link| link.targets.contains(&t));
        let kept: Vec<bool> = (0..self.targets.len()).map(linked).collect();
        if !kept.contains(&true) {
            return Err(UpdateError::NothingPaired {
                modes: self.targets.len(),
            });
        }
        let all = std::mem::take(&mut self.targets);
        for (target, kept) in all.into_iter().zip(kept) {
            if kept {
                self.targets.push(target);
            } else {
                self.left_out.push((target.label, target.hz));
            }
        }
        self.tests = self.paired_modes(measured.iter().map(|set| set.modes));
        Ok(())
    }

    fn paired_modes<'b>(&self, models: impl Iterator<Item = &'b ModalModel>) -> Vec<PairedModes> {
        let of_test = |(test, model)| PairedModes::new(test, model, &self.targets);
        models.enumerate().map(of_test).collect()
    }

    /// The same problem with some of its free parameters, by their place.
    pub fn with_free(&self, places: &[usize]) -> Self {
        Self {
            free: places.iter().map(|&j| self.free[j].clone()).collect(),
            ..self.clone()
        }
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

    /// All parameters with the free ones at `z`.
    pub fn values(&self, z: &[f64]) -> Vec<f64> {
        let mut values = self.initial.clone();
        for (parameter, z) in self.free.iter().zip(z) {
            values[parameter.index] = parameter.value(*z);
        }
        values
    }

    pub(super) fn links(
        &self,
        values: &[f64],
        pair: &PairOptions,
    ) -> Result<Vec<Link>, UpdateError> {
        let theory = self.theory(values)?;
        let mut links = Vec::new();
        for test in &self.tests {
            links.extend(test.links(&theory.model, &self.targets, pair)?);
        }
        let gate = self.start_gate().ln_1p();
        for link in &mut links {
            let hz = link
                .modes
                .iter()
                .map(|&k| theory.model.modes[k].frequency_hz);
            let hz = hz.sum::<f64>() / link.modes.len() as f64;
            // Pairing may take errors as parts of the model's frequency, which then has no upper
            // limit.
            let near = |t: &usize| (hz / self.targets[*t].hz).ln().abs() <= gate;
            link.targets.retain(near);
        }
        links.retain(|link| !link.targets.is_empty());
        Ok(links)
    }

    /// Modes of the model that a target may be.
    fn theory(&self, values: &[f64]) -> Result<TheoryModes, UpdateError> {
        let options = ModeOptions {
            band: self.reach(),
            ..ModeOptions::default()
        };
        Ok(modes(self.model, values, self.sensors, &options)?)
    }

    /// From 0 to the highest frequency that a partner can have: of a sparse model so many modes are
    /// computed. `None` without a target, or for one at a frequency without bounds.
    fn reach(&self) -> Option<Band> {
        let highest = self.targets.iter().map(|target| target.hz).reduce(f64::max);
        highest.and_then(|hz| Band::new(0.0, hz * (1.0 + self.start_gate())).ok())
    }

    fn start_gate(&self) -> f64 {
        self.options.pair.max_frequency_error.max(START_GATE)
    }

    /// The model at `z`, paired with the test there; where that leaves a target alone, from half
    /// the frequency to twice: a start may be far off.
    ///
    /// # Errors
    /// [`UpdateError::Theory`], [`UpdateError::Correlate`].
    pub fn start(&self, z: &[f64]) -> Result<Evaluation, UpdateError> {
        let values = self.values(z);
        let wide = PairOptions {
            max_frequency_error: self.start_gate(),
            ..self.options.pair.clone()
        };
        let mut links = self.links(&values, &self.options.pair)?;
        if self.unpaired(&links).next().is_some() {
            links = self.links(&values, &wide)?;
        }
        self.evaluate(z, |_| links)
    }

    /// The model at `z` with its modes followed from a point nearby; `None` where it has no modes
    /// there.
    ///
    /// # Errors
    /// [`UpdateError::Linalg`].
    pub fn follow(&self, z: &[f64], from: &Evaluation) -> Result<Option<Evaluation>, UpdateError> {
        let followed = |modes: &_| follow(&from.links, &from.modes, &from.matrices.mass, modes);
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
        links: impl FnOnce(&crate::theory::TheoryModes) -> Vec<Link>,
    ) -> Result<Evaluation, UpdateError> {
        let values = self.values(z);
        let matrices = self.model.assemble(&values)?;
        let modes = modes_of_matrices(&matrices, &ModeOptions::default())?;
        let links = without_unseen(links(&modes), &self.targets, &modes);
        let links = with_whole_roots(links, &self.targets, &modes);
        let mut residual = self.data_residuals(&matrices, &modes, &links)?;
        let data_rows = residual.len();
        residual.extend(z.iter().map(|z| self.prior_weight * z));
        Ok(Evaluation {
            z: z.to_vec(),
            values,
            links,
            modes,
            residual,
            data_rows,
            matrices,
        })
    }

    /// Targets without a partner.
    pub(super) fn unpaired<'b>(&'b self, links: &'b [Link]) -> impl Iterator<Item = &'b Target> {
        let alone = |t: &usize| !links.iter().any(|link| link.targets.contains(t));
        (0..self.targets.len())
            .filter(alone)
            .map(|t| &self.targets[t])
    }

    /// The model at `z` with links that are known.
    pub(super) fn at_links(&self, z: &[f64], links: Vec<Link>) -> Result<Evaluation, UpdateError> {
        self.evaluate(z, |_| links)
    }

    /// The residuals of all links, in their order.
    pub(super) fn residuals<'b>(&'b self, at: &'b Evaluation) -> Vec<LinkResidual<'b>> {
        let links = at.links.iter();
        let residuals = links.map(|link| LinkResidual::new(link, &self.targets, &at.modes));
        residuals.collect()
    }

    /// Derivatives of the modes of every link by each free parameter, and the parameter's `dp/dz`.
    pub(super) fn derivatives(
        &self,
        at: &Evaluation,
        residuals: &[LinkResidual<'_>],
    ) -> Result<Vec<(Vec<ModeDerivatives>, f64)>, UpdateError> {
        let roots: Vec<&[usize]> = residuals.iter().map(LinkResidual::modes_of_link).collect();
        let of = |parameter: &FreeParameter| {
            let by = self.model.derivative(&at.values, parameter.index)?;
            let slope = parameter.slope(at.values[parameter.index]);
            Ok((mode_derivatives(&at.modes, &roots, &by)?, slope))
        };
        let all = self.free.iter().map(of);
        let mut all = all.collect::<Result<Vec<_>, UpdateError>>()?;
        for (place, residual) in residuals.iter().enumerate() {
            let mut of_link: Vec<(&mut ModeDerivatives, f64)> = all
                .iter_mut()
                .map(|(column, slope)| (&mut column[place], *slope))
                .collect();
            residual.split(&mut of_link)?;
        }
        Ok(all)
    }

    /// Frequency of the model (Hz) and MAC of each target; `None` for one without a partner.
    pub fn fits(&self, at: &Evaluation) -> Vec<Option<(f64, Option<f64>)>> {
        let mut fits = vec![None; self.targets.len()];
        for link in &at.links {
            let residual = LinkResidual::new(link, &self.targets, &at.modes);
            for (place, hz) in residual.frequencies_hz().into_iter().enumerate() {
                fits[link.targets[place]] = Some((hz, residual.mac(place)));
            }
        }
        fits
    }
}

/// The other tests that measure a mode of the model that a target measures.
fn others_of(target: usize, links: &[Link], targets: &[Target]) -> Vec<usize> {
    let test = |link: &Link| targets[link.targets[0]].test;
    let of_target = links.iter().find(|link| link.targets.contains(&target));
    let Some(followed) = of_target else {
        return Vec::new();
    };
    let meets = |link: &&Link| link.modes.iter().any(|mode| followed.modes.contains(mode));
    let mut others: Vec<usize> = links.iter().filter(meets).map(test).collect();
    others.retain(|&other| other != targets[target].test);
    others.sort_unstable();
    others.dedup();
    others
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

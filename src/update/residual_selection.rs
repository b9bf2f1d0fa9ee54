//! Residual selection collects the residuals of modes, of the equations of motion or of FRFs, and
//! their derivatives.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::dof::Dof;
use crate::frf::{FrfSet, Function};
use crate::linalg::{RealMatrix, real_matrix};
use crate::theory::SystemDerivative;

use super::dynamic::DynamicTarget;
use super::frfs::{FrfSelection, FrfTarget};
use super::model_state::ModelState;
use super::residual::RootPairResidual;
use super::{
    Evaluation, FrfCount, MeasuredModes, Residuals, RootPair, Target, UpdateError, UpdateOptions,
    UpdateProblem,
};

impl UpdateProblem<'_> {
    /// Residuals of the data.
    ///
    /// # Errors
    /// [`UpdateError::Theory`].
    pub(super) fn data_residuals(
        &self,
        states: &[ModelState],
        root_pairs: &[RootPair],
    ) -> Result<Vec<f64>, UpdateError> {
        if self.compares_frfs {
            let values = |set: &FrfTarget| set.values(&states[self.part_of(set.test)].matrices);
            return Ok(self.frfs.iter().flat_map(values).collect());
        }
        if self.options.residuals == Residuals::ModalDynamic {
            let of_target = |(test, shapes, dynamic): DynamicPair<'_>| {
                let ModelState {
                    modes, matrices, ..
                } = &states[self.part_of(test)];
                dynamic.values(shapes, matrices, modes.condensation.as_deref())
            };
            let parts: Vec<Vec<f64>> = self.dynamic().map(of_target).collect::<Result<_, _>>()?;
            return Ok(parts.concat());
        }
        let of_root_pair =
            |root_pair| RootPairResidual::new(root_pair, &self.targets, states).values();
        let mut all: Vec<f64> = root_pairs.iter().flat_map(of_root_pair).collect();
        all.extend(self.unpaired(root_pairs).flat_map(unexplained));
        Ok(all)
    }

    /// Derivatives of the residuals (rows) by the free parameters `z` (columns).
    ///
    /// # Errors
    /// [`UpdateError::Theory`], [`UpdateError::Linalg`]; [`UpdateError::Derivative`] where one is
    /// not finite.
    pub fn jacobian(&self, at: &Evaluation) -> Result<RealMatrix, UpdateError> {
        let columns = if self.compares_frfs {
            let by = self.system_derivatives(at)?;
            let part = |set: &FrfTarget| {
                let c = self.part_of(set.test);
                let columns =
                    |by: &[SystemDerivative]| Ok(set.derivatives(&at.states[c].matrices, by));
                columns_of_known(&by[c], set.len(), columns)
            };
            joined(
                self.frfs
                    .iter()
                    .map(part)
                    .collect::<Result<_, UpdateError>>()?,
            )
        } else if self.options.residuals == Residuals::ModalDynamic {
            let by = self.system_derivatives(at)?;
            let of_target = |(test, shapes, dynamic): DynamicPair<'_>| {
                let c = self.part_of(test);
                let ModelState {
                    modes, matrices, ..
                } = &at.states[c];
                let columns = |by: &[SystemDerivative]| {
                    dynamic.derivatives(shapes, matrices, modes.condensation.as_deref(), by)
                };
                columns_of_known(&by[c], dynamic.len(shapes), columns)
            };
            let parts = self.dynamic().map(of_target);
            joined(parts.collect::<Result<_, UpdateError>>()?)
        } else {
            let residuals = self.residuals(at);
            let by = self.derivatives(at, &residuals)?;
            let column = |(by, _): &(Vec<crate::theory::ModeDerivatives>, f64)| {
                let pairs = residuals.iter().zip(by);
                pairs
                    .flat_map(|(residual, by)| residual.derivatives(by))
                    .collect()
            };
            by.iter().map(column).collect()
        };
        self.with_prior(at, &columns)
    }

    /// The derivatives by `z` from those by the parameters, and the rows of the prior.
    fn with_prior(&self, at: &Evaluation, columns: &[Vec<f64>]) -> Result<RealMatrix, UpdateError> {
        let data = at.data_rows;
        let n = self.free.len();
        let mut jacobian = real_matrix(data + n, n, |_, _| 0.0);
        for (j, (parameter, column)) in self.free.iter().zip(columns).enumerate() {
            let value = parameter.value(at.z[j]);
            let slope = parameter.slope(value);
            for (row, by) in column.iter().enumerate() {
                jacobian[(row, j)] = by * slope;
            }
            if (0..data).any(|row| !jacobian[(row, j)].is_finite()) {
                let name = parameter.name.clone();
                return Err(UpdateError::Derivative { name, value });
            }
            jacobian[(data + j, j)] = self.prior_weight;
        }
        Ok(jacobian)
    }

    /// Derivatives of the matrices of each configuration by each free parameter; `None` for one
    /// that its model does not have.
    fn system_derivatives(
        &self,
        at: &Evaluation,
    ) -> Result<Vec<Vec<Option<SystemDerivative>>>, UpdateError> {
        let parts = self.parts.iter().zip(&at.states);
        parts.map(|(part, state)| part.derivatives(state)).collect()
    }

    /// Index of the configuration of each residual of data.
    pub(super) fn configurations_of_rows(&self, at: &Evaluation) -> Vec<usize> {
        let repeated = |configuration: usize, count: usize| vec![configuration; count];
        if self.compares_frfs {
            let sets = self.frfs.iter();
            let rows = sets.map(|set| repeated(self.part_of(set.test), set.len()));
            return rows.collect::<Vec<_>>().concat();
        }
        if self.options.residuals == Residuals::ModalDynamic {
            let rows = self
                .dynamic()
                .map(|(test, shapes, dynamic)| repeated(self.part_of(test), dynamic.len(shapes)));
            return rows.collect::<Vec<_>>().concat();
        }
        let pairs = self.residuals(at);
        let pairs = pairs
            .iter()
            .zip(&at.root_pairs)
            .map(|(residual, root_pair)| {
                repeated(root_pair.configuration, residual.values().len())
            });
        let unpaired = self.unpaired(&at.root_pairs);
        let unpaired =
            unpaired.map(|target| repeated(self.part_of(target.test), unexplained(target).count()));
        pairs.chain(unpaired).collect::<Vec<_>>().concat()
    }

    /// Number of independent residuals of data.
    pub fn data_count(&self, at: &Evaluation) -> usize {
        if self.compares_frfs {
            return self.frfs.iter().map(FrfTarget::len).sum();
        }
        if self.options.residuals == Residuals::ModalDynamic {
            // The motion of all coordinates is free and takes as many residuals as the force has.
            // The shape outside the root's modes and its one frequency remain.
            return self.targets.iter().map(Target::independent_count).sum();
        }
        let root_pair = |root_pair| {
            RootPairResidual::new(root_pair, &self.targets, &at.states).independent_count()
        };
        let unpaired = self.unpaired(&at.root_pairs).map(Target::independent_count);
        at.root_pairs.iter().map(root_pair).sum::<usize>() + unpaired.sum::<usize>()
    }

    /// Number of FRFs that are compared; `None` where the residuals are of modes.
    pub(super) fn frf_count(&self) -> Option<FrfCount> {
        let sum = |of: fn(&FrfTarget) -> usize| self.frfs.iter().map(of).sum::<usize>();
        self.compares_frfs.then(|| FrfCount {
            compared: sum(FrfTarget::function_count),
            given: self.frfs_given,
            lines: sum(FrfTarget::line_count),
        })
    }

    fn dynamic(&self) -> impl Iterator<Item = DynamicPair<'_>> {
        let targets = self.targets.iter();
        targets.filter_map(|target| {
            Some((
                target.test,
                target.shapes.as_ref()?,
                target.dynamic.as_ref()?,
            ))
        })
    }

    /// Modal dynamic residuals of the targets, weighted at the start.
    pub(super) fn prepare_dynamic(&mut self, start: &Evaluation) -> Result<(), UpdateError> {
        for (t, target) in self.targets.iter_mut().enumerate() {
            let root_pair = start
                .root_pairs
                .iter()
                .find(|root_pair| root_pair.targets.contains(&t));
            let (hz, std) = (target.hz, target.relative_std);
            let shaped = target.shapes.as_ref().zip(root_pair);
            target.dynamic = shaped.and_then(|(shapes, root_pair)| {
                let modes = &start.states[root_pair.configuration].modes;
                DynamicTarget::new(hz, std, shapes, modes, &root_pair.modes)
            });
            if target.dynamic.is_none() {
                let label = target.label.clone();
                return Err(UpdateError::NoShapes { label });
            }
        }
        Ok(())
    }

    /// The functions of the tests that the sensors of the model read.
    ///
    /// # Errors
    /// [`UpdateError::NoVariance`], [`UpdateError::NoFrfs`], [`UpdateError::Theory`].
    pub(super) fn prepare_frfs(
        &mut self,
        measured: &[MeasuredModes<'_>],
    ) -> Result<(), UpdateError> {
        let mut all = Vec::new();
        for part in &self.parts {
            let sensors = part.observation_rows()?;
            for test in part.tests.clone() {
                let test_data = &measured[test];
                let selection = selection(&self.options, test_data);
                let is_reversed = self.at_reversed_sensor(test, test_data.frfs);
                for set in test_data.frfs {
                    self.frfs_given += set.len();
                    all.extend(FrfTarget::new(
                        test,
                        set,
                        &sensors,
                        &selection,
                        &is_reversed,
                    )?);
                }
            }
        }
        if all.is_empty() {
            return Err(UpdateError::NoFrfs);
        }
        self.frfs = Arc::new(all);
        Ok(())
    }

    /// Whether a function of a test is at a reversed sensor, where its sign counts. Sensors are the
    /// side with more DOFs, as in identification.
    fn at_reversed_sensor(
        &self,
        test: usize,
        sets: &[FrfSet],
    ) -> impl Fn(&Function) -> bool + use<> {
        let functions = || sets.iter().flat_map(FrfSet::functions);
        let responses: BTreeSet<&Dof> = functions().map(|function| &function.response).collect();
        let references: BTreeSet<&Dof> = functions().map(|function| &function.reference).collect();
        let hits_rove = responses.len() < references.len();
        let counts = self.options.residuals == Residuals::FrfComplex;
        let reversed = self.reversed[test].dofs.iter().map(Dof::positive);
        let reversed: Vec<Dof> = reversed.filter(|_| counts).collect();
        move |function: &Function| {
            let sensor = if hits_rove {
                &function.reference
            } else {
                &function.response
            };
            reversed.contains(&sensor.positive())
        }
    }

    /// The same problem with FRFs for residuals, with the damping of the modes at a point.
    ///
    /// # Errors
    /// [`UpdateError::NoDamping`].
    pub(super) fn with_frfs(&self, at: &Evaluation) -> Result<Self, UpdateError> {
        let mut frfs = self.frfs.as_ref().clone();
        for set in &mut frfs {
            let ratios = self.damping_ratios(set.test, at)?;
            let ModelState {
                modes, matrices, ..
            } = &at.states[self.part_of(set.test)];
            set.set_damping(&matrices.mass, modes, &ratios);
        }
        Ok(Self {
            frfs: Arc::new(frfs),
            compares_frfs: true,
            ..self.clone()
        })
    }

    /// A damping ratio for every mode of the model: that of its partners in a test, else their
    /// mean.
    fn damping_ratios(&self, test: usize, at: &Evaluation) -> Result<Vec<f64>, UpdateError> {
        let of_test = |t: &&usize| self.targets[**t].test == test;
        let mean = |targets: &mut dyn Iterator<Item = &usize>| {
            let known = targets.filter(of_test);
            let known: Vec<f64> = known
                .filter_map(|&t| self.targets[t].damping_ratio)
                .collect();
            let count = known.len() as f64;
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / count)
        };
        let configuration = self.part_of(test);
        let root_pairs = || {
            let all = at.root_pairs.iter();
            all.filter(|root_pair| root_pair.configuration == configuration)
        };
        let all = mean(&mut root_pairs().flat_map(|root_pair| &root_pair.targets));
        let all = all.ok_or(UpdateError::NoDamping { test })?;
        let of_mode = |r: usize| {
            let root_pairs = root_pairs().filter(|root_pair| root_pair.modes.contains(&r));
            mean(&mut root_pairs.flat_map(|root_pair| &root_pair.targets)).unwrap_or(all)
        };
        let count = at.states[configuration].modes.omega_rad_s.len();
        Ok((0..count).map(of_mode).collect())
    }
}

/// The test, the shapes and the residuals of a target.
type DynamicPair<'a> = (
    usize,
    &'a super::target_shapes::TargetShapes,
    &'a DynamicTarget,
);

/// The columns of the parameters that a model has, and columns of zeros of the others.
fn columns_of_known(
    by: &[Option<SystemDerivative>],
    rows: usize,
    columns: impl Fn(&[SystemDerivative]) -> Result<Vec<Vec<f64>>, UpdateError>,
) -> Result<Vec<Vec<f64>>, UpdateError> {
    let known: Vec<SystemDerivative> = by.iter().flatten().cloned().collect();
    let mut known = columns(&known)?.into_iter();
    let column = |by: &Option<SystemDerivative>| {
        let column = by.as_ref().and_then(|_| known.next());
        column.unwrap_or_else(|| vec![0.0; rows])
    };
    Ok(by.iter().map(column).collect())
}

/// The columns of several parts, one part below the other.
fn joined(parts: Vec<Vec<Vec<f64>>>) -> Vec<Vec<f64>> {
    let count = parts.first().map_or(0, Vec::len);
    let column = |j: usize| parts.iter().flat_map(|part| part[j].clone()).collect();
    (0..count).map(column).collect()
}

fn selection(options: &UpdateOptions, set: &MeasuredModes<'_>) -> FrfSelection {
    FrfSelection {
        band: set.modes.band,
        most_lines: options.frf_lines,
        floor: options.frf_floor,
        logarithms: options.residuals == Residuals::FrfLogMagnitude,
    }
}

/// Residuals of a target without a partner: a relative frequency error of 1 and shapes with a MAC
/// of 0, which is more than any partner leaves.
fn unexplained(target: &Target) -> impl Iterator<Item = f64> {
    let vectors = target.shapes.iter().flat_map(|shapes| &shapes.vectors);
    std::iter::once(target.relative_std.recip()).chain(vectors.flatten().copied())
}

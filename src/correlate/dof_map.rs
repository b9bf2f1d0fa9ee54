//! The DOF map assigns degrees of freedom of the test to those of the theory by label, never by
//! index.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::{Axis, Dof};
use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::{ModalModel, ModeShape};

use super::{CorrelateError, PairOptions};

/// Maximum number of degrees of freedom without a partner that get a finding each; more are
/// counted.
const MAX_NAMED: usize = 4;

/// One degree of freedom that both have.
#[derive(Clone, Debug, PartialEq)]
pub struct DofPair {
    /// As the test names it, with its sign.
    pub test: Dof,
    /// As the theory names it, with its sign.
    pub theory: Dof,
    /// Factor that turns the test's value to the theory's direction: the product of both signs.
    pub sign: f64,
}

/// The degrees of freedom that test and theory have in common, in order.
///
/// Two are the same when point (with its component) and axis are equal. Of several that name the
/// same point and axis in one set (repeated measurements, a second sensor the other way round) the
/// first in order is taken. The map of two models leaves out the degrees of freedom that the test
/// did not measure ([`ModalModel::unmeasured_dofs`]).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct DofMap {
    /// The common ones.
    pub pairs: Vec<DofPair>,
    /// Those of the test that the theory does not have.
    pub test_alone: Vec<Dof>,
    /// Those that the test did not measure and where the theory moves.
    pub unmeasured: Vec<Dof>,
    /// Those where the theory is 0 in every mode and the test moves.
    pub zero_in_theory: Vec<Dof>,
}

type Label = (String, Axis);

fn first_of_each<'a>(dofs: impl Iterator<Item = &'a Dof>) -> BTreeMap<Label, Dof> {
    let sorted: BTreeSet<&Dof> = dofs.collect();
    let mut first = BTreeMap::new();
    for dof in sorted {
        first
            .entry((dof.point().to_owned(), dof.axis()))
            .or_insert_with(|| dof.clone());
    }
    first
}

impl DofMap {
    /// The map between two lists of degrees of freedom, in any order.
    pub fn new<'a>(
        test: impl Iterator<Item = &'a Dof>,
        theory: impl Iterator<Item = &'a Dof>,
    ) -> Self {
        let theory = first_of_each(theory);
        let mut map = Self::default();
        for (label, dof) in first_of_each(test) {
            match theory.get(&label) {
                Some(partner) => map.pairs.push(DofPair {
                    sign: dof.sign() * partner.sign(),
                    theory: partner.clone(),
                    test: dof,
                }),
                None => map.test_alone.push(dof),
            }
        }
        map.pairs.sort_by(|a, b| a.test.cmp(&b.test));
        map.test_alone.sort();
        map
    }

    /// The map between all degrees of freedom at which any mode of either model has a value.
    pub fn of_models(test: &ModalModel, theory: &ModalModel) -> Self {
        fn dofs(model: &ModalModel) -> impl Iterator<Item = &Dof> {
            let shapes = model.modes.iter().map(|mode| &mode.shape);
            shapes.flat_map(|shape| shape.iter().map(|(dof, _)| dof))
        }
        let mut map = Self::new(dofs(test), dofs(theory));
        map.leave_out_unmeasured(test, theory);
        let at_rest = map.pairs.iter();
        let at_rest =
            at_rest.filter(|pair| moves(test, &pair.test) && !moves(theory, &pair.theory));
        map.zero_in_theory = at_rest.map(|pair| pair.test.clone()).collect();
        map
    }

    /// Leaves out what the test did not measure. Where the theory is 0 too, nothing is lost.
    fn leave_out_unmeasured(&mut self, test: &ModalModel, theory: &ModalModel) {
        let unmeasured = test.unmeasured_dofs();
        self.test_alone.retain(|dof| !unmeasured.contains(dof));
        let pairs = std::mem::take(&mut self.pairs).into_iter();
        let (left_out, kept): (Vec<DofPair>, Vec<DofPair>) =
            pairs.partition(|pair| unmeasured.contains(&pair.test));
        self.pairs = kept;
        let left_out = left_out.into_iter();
        let left_out = left_out.filter(|pair| moves(theory, &pair.theory));
        self.unmeasured = left_out.map(|pair| pair.test).collect();
    }

    /// The map of the translations alone, and the number of rotations that it leaves out.
    pub(super) fn without_rotations(mut self) -> (Self, usize) {
        let all = self.len();
        self.pairs.retain(|pair| !pair.test.axis().is_rotation());
        let left_out = all - self.len();
        (self, left_out)
    }

    /// Whether it has rotations among translations.
    pub(super) fn has_both_kinds(&self) -> bool {
        let is_rotation = |pair: &DofPair| pair.test.axis().is_rotation();
        self.pairs.iter().any(is_rotation) && !self.pairs.iter().all(is_rotation)
    }

    /// How many degrees of freedom both have.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether they have none in common.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Whether the theory is 0 in every mode at all of them, though the test moves there.
    pub fn is_still_in_theory(&self) -> bool {
        !self.pairs.is_empty() && self.zero_in_theory.len() == self.pairs.len()
    }

    /// Factor of each common degree of freedom in a MAC: 1, or the stated length for a rotation
    /// among translations.
    pub(super) fn weights(&self, options: &PairOptions) -> Result<Vec<f64>, CorrelateError> {
        if !self.has_both_kinds() {
            return Ok(vec![1.0; self.len()]);
        }
        let turns = |pair: &&DofPair| pair.test.axis().is_rotation();
        let rotations = self.pairs.iter().filter(turns).count();
        let translations = self.len() - rotations;
        let length = options
            .rotation_length_m
            .ok_or(CorrelateError::MixedUnits {
                translations,
                rotations,
            })?;
        let weight = |pair: &DofPair| if turns(&pair) { length } else { 1.0 };
        Ok(self.pairs.iter().map(weight).collect())
    }

    /// The test shape along the theory's directions; `None` where it has no value.
    pub(super) fn test_values(&self, shape: &ModeShape, weights: &[f64]) -> Vec<Option<Complex64>> {
        let value = |(pair, weight): (&DofPair, &f64)| {
            shape.get(&pair.test).map(|v| v * pair.sign * *weight)
        };
        self.pairs.iter().zip(weights).map(value).collect()
    }

    /// The theory shape in the directions of the theory; `None` where it has no value.
    pub(super) fn theory_values(
        &self,
        shape: &ModeShape,
        weights: &[f64],
    ) -> Vec<Option<Complex64>> {
        let value = |(pair, weight): (&DofPair, &f64)| shape.get(&pair.theory).map(|v| v * *weight);
        self.pairs.iter().zip(weights).map(value).collect()
    }

    /// Findings on the map: degrees of freedom that were not measured, that are 0 in the theory or
    /// that have no partner (each, or their number where they are many), and a common number below
    /// the limit. Nothing for a test without shapes.
    ///
    /// `distinct` of the common degrees of freedom differ: those that move alike in every mode of
    /// the theory are one.
    pub fn findings(&self, distinct: usize, min_dofs: usize) -> Vec<Finding> {
        let alone = &self.test_alone;
        let warn = |code, location| Finding::new(Severity::Warning, code, location);
        let mut findings = Vec::new();
        for (code, dofs) in [
            (Code::UnmeasuredLeftOut, &self.unmeasured),
            (Code::ZeroInModel, &self.zero_in_theory),
        ] {
            if !dofs.is_empty() {
                let finding = warn(code, Location::Whole).value(dofs.len() as f64, "");
                findings.push(finding.detail(first_names(dofs)));
            }
        }
        if self.is_empty() && alone.is_empty() {
            return findings;
        }
        if alone.len() <= MAX_NAMED {
            findings.extend(alone.iter().map(|dof| {
                let location = Location::Function {
                    response: Some(dof.clone()),
                    reference: None,
                };
                warn(Code::DofWithoutPartner, location)
            }));
        } else {
            let count = alone.len() as f64;
            findings.push(warn(Code::DofWithoutPartner, Location::Whole).value(count, ""));
        }
        if distinct < min_dofs {
            let few = warn(Code::FewDofs, Location::Whole);
            let few = few.value(distinct as f64, "").limit(min_dofs as f64);
            findings.push(match distinct == self.len() {
                true => few,
                false => few.detail(format!(
                    "of {} in common several move alike in every mode of the model and count once",
                    self.len()
                )),
            });
        }
        findings
    }
}

/// Whether a mode has a value other than 0 at a degree of freedom.
fn moves(model: &ModalModel, dof: &Dof) -> bool {
    let mut values = model.modes.iter().filter_map(|mode| mode.shape.get(dof));
    values.any(|value| value != Complex64::ZERO)
}

/// The first degrees of freedom by name, as many as get a finding each, and the number of others.
fn first_names(dofs: &[Dof]) -> String {
    let names: Vec<String> = dofs.iter().take(MAX_NAMED).map(Dof::to_string).collect();
    let others = dofs.len().saturating_sub(MAX_NAMED);
    match others {
        0 => names.join(", "),
        _ => format!("{} and {others} more", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dofs(text: &[&str]) -> Vec<Dof> {
        text.iter().map(|t| t.parse().unwrap()).collect()
    }

    fn map(test: &[&str], theory: &[&str]) -> DofMap {
        DofMap::new(dofs(test).iter(), dofs(theory).iter())
    }

    #[test]
    fn labels_meet_with_the_product_of_their_signs() {
        let map = map(
            &["10:-Z", "2:+X", "3:-Y", "2:+Z", "a.2:+X"],
            &["2:+X", "3:-Y", "10:+Z", "2:+Y"],
        );
        let text: Vec<String> = map
            .pairs
            .iter()
            .map(|p| format!("{} {} {}", p.test, p.theory, p.sign))
            .collect();
        assert_eq!(text, ["2:+X 2:+X 1", "3:-Y 3:-Y 1", "10:-Z 10:+Z -1"]);
        assert_eq!(map.test_alone, dofs(&["2:+Z", "a.2:+X"]));
    }

    #[test]
    fn a_repeated_or_reversed_measurement_counts_once() {
        let map = map(&["1:+Z#2", "1:+Z", "1:-Z"], &["1:+Z"]);
        assert_eq!((map.len(), map.test_alone.len()), (1, 0));
        assert_eq!(map.pairs[0].test.to_string(), "1:+Z");
    }

    #[test]
    fn few_missing_ones_are_named_and_many_are_counted() {
        let named = map(&["1:+Z", "2:+Z"], &["1:+Z"]).findings(1, 4);
        let places: Vec<String> = named.iter().map(|f| f.location.to_string()).collect();
        assert_eq!(places, ["channel 2:+Z", "whole test"]);
        assert_eq!((named[1].value, named[1].limit), (Some(1.0), Some(4.0)));
        let counted = map(&["1:+Z", "2:+Z", "3:+Z", "4:+Z", "5:+Z"], &[]).findings(0, 0);
        assert_eq!((counted.len(), counted[0].value), (1, Some(5.0)));
        assert!(map(&[], &["1:+Z"]).findings(0, 4).is_empty());
    }

    #[test]
    fn rotations_among_translations_need_a_length() {
        let mixed = map(&["1:+X", "1:+RY"], &["1:+X", "1:+RY"]);
        let mut options = PairOptions::default();
        assert_eq!(
            mixed.weights(&options),
            Err(CorrelateError::MixedUnits {
                translations: 1,
                rotations: 1
            })
        );
        options.rotation_length_m = Some(0.25);
        assert_eq!(mixed.weights(&options), Ok(vec![1.0, 0.25]));
        assert_eq!(map(&["1:+RX"], &["1:+RX"]).weights(&options), Ok(vec![1.0]));
    }
}

//! What a test's degrees of freedom are called in the theory, where the names differ: by a list, or by nearest node.

use std::collections::{BTreeMap, BTreeSet};

use crate::dof::{Axis, Dof};
use crate::finding::{Code, Finding, Place, Severity};
use crate::geometry::Geometry;
use crate::linalg::Vector3;
use crate::modal::{ModalModel, ModeShape};

use super::CorrelateError;

/// Pairs of degrees of freedom that read the same: the test's sensor, with its sign, and the theory's.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct DofNames {
    pairs: Vec<(Dof, Dof)>,
}

impl DofNames {
    /// Reads a list: a line for each pair, the test's degree of freedom and the theory's, separated by a comma. A heading
    /// `test,theory`, blank lines and lines that begin with `#` are passed over.
    ///
    /// ```
    /// use modalign::correlate::DofNames;
    /// let names = DofNames::parse("test,theory\n1:+Z,node.101:-Z\n").unwrap();
    /// assert_eq!(names.len(), 1);
    /// assert!(DofNames::parse("1:+Z").is_err());
    /// ```
    ///
    /// # Errors
    /// [`CorrelateError::DofList`] with the line: something else than two degrees of freedom, a test's one that stands
    /// there twice, or no pair at all.
    pub fn parse(text: &str) -> Result<Self, CorrelateError> {
        let mut names = Self::default();
        let mut known = BTreeSet::new();
        for (index, line) in text.lines().enumerate() {
            let plain = line.trim_start_matches('\u{feff}').trim();
            if plain.is_empty() || plain.starts_with('#') || plain == "test,theory" {
                continue;
            }
            let error = |expected| CorrelateError::DofList {
                line: index + 1,
                got: plain.to_owned(),
                expected,
            };
            let pair = plain.split_once(',').and_then(|(test, theory)| {
                Some((
                    test.trim().parse::<Dof>().ok()?,
                    theory.trim().parse().ok()?,
                ))
            });
            let (test, theory) =
                pair.ok_or_else(|| error("TEST,THEORY, two degrees of freedom such as 1:+Z"))?;
            if !known.insert(test.positive()) {
                return Err(error("each degree of freedom of the test once"));
            }
            names.pairs.push((test, theory));
        }
        if names.is_empty() {
            return Err(CorrelateError::DofList {
                line: text.lines().count().max(1),
                got: "no pair".to_owned(),
                expected: "a line TEST,THEORY for each pair",
            });
        }
        Ok(names)
    }

    /// Ties each degree of freedom of the test to the theory's of the same axis at the nearest node, as far as that lies
    /// within `tolerance_m`. Both geometries must be in one frame.
    ///
    /// The finding tells the largest distance. Degrees of freedom without a position or a node near enough stay without a
    /// partner.
    pub fn nearest(
        test: (&ModalModel, &Geometry),
        theory: (&ModalModel, &Geometry),
        tolerance_m: f64,
    ) -> (Self, Finding) {
        let test_nodes = positions(test.1);
        let theory_nodes = positions(theory.1);
        let mut of_axis: BTreeMap<Axis, Vec<(Vector3, Dof)>> = BTreeMap::new();
        for dof in dofs(theory.0) {
            if let Some(at) = theory_nodes.get(dof.point()) {
                of_axis.entry(dof.axis()).or_default().push((*at, dof));
            }
        }
        let mut names = Self::default();
        let mut largest = 0.0_f64;
        for own in dofs(test.0) {
            let Some(at) = test_nodes.get(own.point()) else {
                continue;
            };
            let partners = of_axis.get(&own.axis()).into_iter().flatten();
            let distances = partners.map(|(place, dof)| ((place - at).norm(), dof));
            let near = distances.filter(|(distance, _)| *distance <= tolerance_m);
            if let Some((distance, dof)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) {
                largest = largest.max(distance);
                names.pairs.push((own.positive(), dof.positive()));
            }
        }
        names.pairs.dedup();
        let finding = Finding::new(Severity::Info, Code::DofsByNode, Place::Whole)
            .value(largest, "m")
            .limit(tolerance_m);
        (names, finding)
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there is no pair.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// What the theory itself calls a degree of freedom of the test, with the sign of the theory's sensor.
    pub fn in_theory(&self, test: &Dof) -> Option<&Dof> {
        let mut pairs = self.pairs.iter();
        pairs.find(|(own, _)| own == test).map(|(_, theory)| theory)
    }

    /// The theory under the names of the test: each shape at the test's degrees of freedom, as far as a pair names them
    /// and the shape has a value there.
    pub fn rename(&self, theory: &ModalModel) -> ModalModel {
        let mut renamed = theory.clone();
        for mode in &mut renamed.modes {
            let value = |(test, own): &(Dof, Dof)| {
                let value = mode.shape.along_positive(own)?;
                Some((test.clone(), value * own.sign()))
            };
            mode.shape = ModeShape::new(self.pairs.iter().filter_map(value));
            (mode.shape_std, mode.residues) = (None, Default::default());
        }
        renamed
    }
}

fn positions(geometry: &Geometry) -> BTreeMap<&str, Vector3> {
    let nodes = geometry.nodes.iter();
    nodes.map(|node| (node.point.as_str(), node.at_m)).collect()
}

/// Every degree of freedom at which a mode has a value, in order.
fn dofs(model: &ModalModel) -> BTreeSet<Dof> {
    let shapes = model.modes.iter().map(|mode| &mode.shape);
    shapes
        .flat_map(|shape| shape.iter().map(|(dof, _)| dof.clone()))
        .collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::geometry::Node;
    use crate::modal::{Mode, Scaling};

    fn model(values: &[(&str, f64)]) -> ModalModel {
        let shape = values
            .iter()
            .map(|(dof, value)| (dof.parse().unwrap(), Complex64::new(*value, 0.0)));
        let mode = Mode::new(10.0, None, ModeShape::new(shape), Scaling::Unknown);
        ModalModel {
            modes: vec![mode],
            ..ModalModel::default()
        }
    }

    fn geometry(nodes: &[(&str, f64)]) -> Geometry {
        let nodes = nodes
            .iter()
            .map(|(point, x)| Node::new(*point, Vector3::new(*x, 0.0, 0.0)));
        Geometry {
            nodes: nodes.collect(),
            ..Geometry::default()
        }
    }

    fn values(model: &ModalModel) -> Vec<(String, f64)> {
        let shape = &model.modes[0].shape;
        shape.iter().map(|(d, v)| (d.to_string(), v.re)).collect()
    }

    #[test]
    fn a_list_turns_signs_of_both_sides() {
        let names = DofNames::parse("# beam\n1:+Z,101:-X\n2:-Z,102:+X\n3:+Z,103:+X\n").unwrap();
        let renamed = names.rename(&model(&[("101:+X", 2.0), ("102:-X", 3.0)]));
        let expected = [("1:+Z".to_owned(), -2.0), ("2:-Z".to_owned(), -3.0)];
        assert_eq!(values(&renamed), expected);
        let own = names.in_theory(&"1:+Z".parse().unwrap());
        assert_eq!(own.map(ToString::to_string), Some("101:-X".to_owned()));
    }

    #[test]
    fn a_bad_line_is_named() {
        for (text, line) in [
            ("1:+Z,2:+Z\n1:-Z,3:+Z", 2),
            ("test,theory\n\n1:+Z;2:+Z", 3),
            ("", 1),
        ] {
            let error = DofNames::parse(text).unwrap_err();
            assert!(
                matches!(error, CorrelateError::DofList { line: got, .. } if got == line),
                "{text:?}: {error}"
            );
        }
    }

    #[test]
    fn the_nearest_node_of_the_same_axis_is_taken_within_the_tolerance() {
        let test = model(&[("1:+Z", 1.0), ("2:-Z", 1.0), ("3:+Z", 1.0), ("9:+Z", 1.0)]);
        let theory = model(&[
            ("11:+Z", 5.0),
            ("12:+Z", 6.0),
            ("12:+X", 7.0),
            ("13:+Z", 8.0),
        ]);
        let (names, finding) = DofNames::nearest(
            (&test, &geometry(&[("1", 0.0), ("2", 0.104), ("3", 0.2)])),
            (
                &theory,
                &geometry(&[("11", 0.001), ("12", 0.1), ("13", 0.25)]),
            ),
            0.01,
        );
        let expected = [("1:+Z".to_owned(), 5.0), ("2:+Z".to_owned(), 6.0)];
        assert_eq!(values(&names.rename(&theory)), expected);
        assert!((finding.value.unwrap() - 0.004).abs() < 1e-12);
    }
}

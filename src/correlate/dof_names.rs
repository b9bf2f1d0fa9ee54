//! DOF names match degrees of freedom of the test with those of the theory, by a list or by nearest
//! node.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::{Axis, Dof};
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::Geometry;
use crate::linalg::Vector3;
use crate::modal::{ModalModel, ModeShape};

use super::CorrelateError;
use super::alignment::MAX_DISTANCE_OF_EQUAL_POINTS;
use super::error::Extents;
use super::similarity::{Similarity, extent};

/// Minimum component of a unit direction along an axis of the theory that the reading includes.
const MIN_DIRECTION_COMPONENT: f64 = 1e-3;

/// The reading of the theory for each degree of freedom of the test.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct DofNames {
    pairs: BTreeMap<Dof, Reading>,
}

/// A weighted sum of the theory's degrees of freedom along their positive axes: one, or several
/// where the test's axis is oblique to the theory's.
pub type Reading = Vec<(Dof, f64)>;

/// Modes with the positions of their points.
#[derive(Clone, Copy, Debug)]
pub struct LocatedModes<'a> {
    /// The modes.
    pub modes: &'a ModalModel,
    /// The nodes at which their points are.
    pub geometry: &'a Geometry,
}

impl<'a> LocatedModes<'a> {
    fn positions(&self) -> BTreeMap<&'a str, Vector3> {
        let nodes = self.geometry.nodes.iter();
        nodes.map(|node| (node.point.as_str(), node.at_m)).collect()
    }

    /// Positions of the points at which a mode has a value, each once.
    pub fn sensor_positions(&self) -> Vec<Vector3> {
        let positions = self.positions();
        let dofs = self.dofs();
        let points: BTreeSet<&str> = dofs.iter().map(Dof::point).collect();
        let located = points.iter().filter_map(|point| positions.get(point));
        located.copied().collect()
    }

    /// Every degree of freedom at which a mode has a value, in order.
    fn dofs(&self) -> BTreeSet<Dof> {
        let shapes = self.modes.modes.iter().map(|mode| &mode.shape);
        shapes
            .flat_map(|shape| shape.iter().map(|(dof, _)| dof.clone()))
            .collect()
    }
}

impl DofNames {
    /// Reads a list: a line for each pair, the test's degree of freedom and the theory's, separated
    /// by a comma. A heading `test,theory`, blank lines and lines that begin with `#` are
    /// ignored.
    ///
    /// ```
    /// use modalign::correlate::DofNames;
    /// let names = DofNames::parse("test,theory\n1:+Z,node.101:-Z\n").unwrap();
    /// assert_eq!(names.len(), 1);
    /// assert!(DofNames::parse("1:+Z").is_err());
    /// ```
    ///
    /// # Errors
    /// [`CorrelateError::DofList`] with the line that has no two degrees of freedom or repeats one
    /// of the test, and for a list without a pair.
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
            let (test, theory): (Dof, Dof) =
                pair.ok_or_else(|| error("TEST,THEORY, two degrees of freedom such as 1:+Z"))?;
            if !known.insert(test.positive()) {
                return Err(error("each degree of freedom of the test once"));
            }
            let reading = vec![(theory.positive(), theory.sign())];
            names.pairs.insert(test, reading);
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

    /// The matched pairs of points, by the names of both, each once and in order.
    pub fn points(&self) -> Vec<(&str, &str)> {
        let pairs = self.pairs.iter();
        let named = pairs.flat_map(|(test, reading)| {
            let theory = reading.iter();
            theory.map(|(dof, _)| (test.point(), dof.point()))
        });
        named.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Matches each degree of freedom of the test with the theory's at the nearest node within
    /// `tolerance_m`: a test's point `x` lies at `s R x + t`, its axis along `R e`. Where that is
    /// oblique to the theory's axes, the reading is the sum of the components, all of which the
    /// node must have. Rotations match rotations, scalars match scalars.
    ///
    /// The first finding has the largest distance, and is a warning where sensors have no node
    /// within the tolerance; another one names the sensors at different positions that share a
    /// node.
    ///
    /// # Errors
    /// [`CorrelateError::NoNearNode`] where no sensor has a node within the tolerance, or less than
    /// half of them while the extents of both geometries differ as units of length do;
    /// [`CorrelateError::NoLocatedSensor`] where no sensor has a position and a node with its axis.
    pub fn nearest(
        test: &LocatedModes<'_>,
        theory: &LocatedModes<'_>,
        frame: &Similarity,
        tolerance_m: f64,
    ) -> Result<(Self, Vec<Finding>), CorrelateError> {
        let nearest = nearest_nodes(test, theory, frame);
        if nearest.is_empty() {
            return Err(CorrelateError::NoLocatedSensor {
                sensors: test.dofs().len(),
            });
        }
        let (near, far): (Vec<&NearestNode>, Vec<&NearestNode>) =
            (nearest.iter()).partition(|node| node.distance_m <= tolerance_m);
        let test_extent_m = frame.scale * extent(&test.sensor_positions());
        let extents = Extents {
            test_m: test_extent_m,
            theory_m: extent(&theory.sensor_positions()),
        };
        if near.is_empty() || (extents.differ_in_unit() && near.len() <= far.len()) {
            return Err(CorrelateError::NoNearNode {
                near: near.len(),
                sensors: nearest.len(),
                nearest_m: smallest_distance(&nearest),
                farthest_m: largest_distance(&nearest),
                tolerance_m,
                extents,
            });
        }
        let pairs = near
            .iter()
            .map(|node| (node.sensor.clone(), node.reading()));
        let names = Self {
            pairs: pairs.collect(),
        };
        let severity = match far.is_empty() {
            true => Severity::Info,
            false => Severity::Warning,
        };
        let finding = Finding::new(severity, Code::DofsByNode, Location::Whole)
            .value(largest_distance(near.iter().copied()), "m")
            .limit(tolerance_m);
        let matched = match far.is_empty() {
            true => finding,
            false => finding.detail(format!(
                "{} of {} sensors; the others are {:.3e} m to {:.3e} m off",
                near.len(),
                nearest.len(),
                smallest_distance(far.iter().copied()),
                largest_distance(far.iter().copied())
            )),
        };
        let shared = shared_nodes(&near, extents.theory_m);
        Ok((names, [matched].into_iter().chain(shared).collect()))
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there is no pair.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The reading of the theory for a degree of freedom of the test.
    pub fn reading(&self, test: &Dof) -> Option<&Reading> {
        self.pairs.get(test)
    }

    /// The theory with its shapes at the test's degrees of freedom, where they are matched and the
    /// shape has values.
    pub fn rename(&self, theory: &ModalModel) -> ModalModel {
        let mut renamed = theory.clone();
        for mode in &mut renamed.modes {
            let value = |(test, reading): (&Dof, &Reading)| {
                let parts = reading.iter();
                let parts = parts.map(|(dof, part)| Some(mode.shape.along_positive(dof)? * *part));
                let sum: Option<Complex64> = parts.sum();
                Some((test.clone(), sum?))
            };
            mode.shape = ModeShape::new(self.pairs.iter().filter_map(value));
            (mode.shape_std, mode.residues) = (None, Default::default());
        }
        renamed
    }
}

/// The theory's node nearest to a sensor of the test, of those with all components of its axis.
struct NearestNode {
    /// The sensor, on its positive axis.
    sensor: Dof,
    /// Position of the sensor in the theory's frame, m.
    at: Vector3,
    /// Name of the node.
    point: String,
    distance_m: f64,
    /// Components of the sensor's axis along the theory's axes.
    components: Vec<(Axis, f64)>,
}

impl NearestNode {
    fn reading(&self) -> Reading {
        let parts = self.components.iter();
        let parts = parts
            .filter_map(|&(axis, part)| Some((Dof::new(&self.point, axis, false).ok()?, part)));
        parts.collect()
    }
}

/// The nearest node of each sensor that has a position, at any distance.
fn nearest_nodes(
    test: &LocatedModes<'_>,
    theory: &LocatedModes<'_>,
    frame: &Similarity,
) -> Vec<NearestNode> {
    let (test_nodes, theory_nodes) = (test.positions(), theory.positions());
    let mut of_point: BTreeMap<String, BTreeSet<Axis>> = BTreeMap::new();
    for dof in theory.dofs() {
        let axes = of_point.entry(dof.point().to_owned()).or_default();
        axes.insert(dof.axis());
    }
    let sensors: BTreeSet<Dof> = test.dofs().iter().map(Dof::positive).collect();
    let nearest = |sensor: Dof| {
        let at = frame.position(test_nodes.get(sensor.point())?);
        let components = axis_components(frame, sensor.axis());
        let full = of_point
            .iter()
            .filter(|(_, axes)| components.iter().all(|(axis, _)| axes.contains(axis)));
        let placed = full.filter_map(|(point, _)| {
            let position = theory_nodes.get(point.as_str())?;
            Some(((position - at).norm(), point))
        });
        let (distance_m, point) = placed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(NearestNode {
            sensor,
            at,
            point: point.clone(),
            distance_m,
            components,
        })
    };
    sensors.into_iter().filter_map(nearest).collect()
}

fn smallest_distance<'a>(nodes: impl IntoIterator<Item = &'a NearestNode>) -> f64 {
    let distances = nodes.into_iter().map(|node| node.distance_m);
    distances.fold(f64::INFINITY, f64::min)
}

fn largest_distance<'a>(nodes: impl IntoIterator<Item = &'a NearestNode>) -> f64 {
    let distances = nodes.into_iter().map(|node| node.distance_m);
    distances.fold(0.0, f64::max)
}

/// The finding on sensors at different positions that read the same node, where there are any.
fn shared_nodes(near: &[&NearestNode], extent_m: f64) -> Option<Finding> {
    let mut readers: BTreeMap<(&str, Axis), Vec<&NearestNode>> = BTreeMap::new();
    for node in near {
        let key = (node.point.as_str(), node.sensor.axis());
        readers.entry(key).or_default().push(node);
    }
    let is_shared = |sensors: &&Vec<&NearestNode>| {
        let apart = |node: &&NearestNode| (node.at - sensors[0].at).norm();
        sensors.iter().map(apart).fold(0.0, f64::max) > MAX_DISTANCE_OF_EQUAL_POINTS * extent_m
    };
    let shared: Vec<&Vec<&NearestNode>> = readers.values().filter(is_shared).collect();
    let first = shared.first()?;
    let names: Vec<String> = first.iter().map(|node| node.sensor.to_string()).collect();
    let detail = format!("{} at node {}", names.join(", "), first[0].point);
    let count: usize = shared.iter().map(|sensors| sensors.len()).sum();
    let finding = Finding::new(Severity::Warning, Code::NodeShared, Location::Whole);
    Some(finding.value(count as f64, "").detail(detail))
}

/// Components of a test's positive axis along the theory's axes.
fn axis_components(frame: &Similarity, axis: Axis) -> Vec<(Axis, f64)> {
    let Some(unit) = axis.unit_vector() else {
        return vec![(axis, 1.0)];
    };
    let of_kind = match axis.is_rotation() {
        true => [Axis::RX, Axis::RY, Axis::RZ],
        false => [Axis::X, Axis::Y, Axis::Z],
    };
    let direction = frame.rotation * Vector3::from(unit);
    let parts = of_kind.into_iter().zip(direction.iter().copied());
    parts
        .filter(|(_, part)| part.abs() > MIN_DIRECTION_COMPONENT)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Node;
    use crate::modal::{Mode, Scaling};

    fn model(values: &[(&str, f64)]) -> ModalModel {
        let shape = values.iter().map(|(dof, value)| {
            (
                dof.parse().expect("a degree of freedom"),
                Complex64::new(*value, 0.0),
            )
        });
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
        let names = DofNames::parse("# beam\n1:+Z,101:-X\n2:-Z,102:+X\n3:+Z,103:+X\n")
            .expect("a sound list");
        let renamed = names.rename(&model(&[("101:+X", 2.0), ("102:-X", 3.0)]));
        let expected = [("1:+Z".to_owned(), -2.0), ("2:-Z".to_owned(), -3.0)];
        assert_eq!(values(&renamed), expected);
        let readings = names.reading(&"1:+Z".parse().expect("a degree of freedom"));
        assert_eq!(
            readings,
            Some(&vec![(
                "101:+X".parse().expect("a degree of freedom"),
                -1.0
            )])
        );
        assert_eq!(names.points(), [("1", "101"), ("2", "102"), ("3", "103")]);
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
        let (names, findings) = DofNames::nearest(
            &LocatedModes {
                modes: &test,
                geometry: &geometry(&[("1", 0.0), ("2", 0.104), ("3", 0.2)]),
            },
            &LocatedModes {
                modes: &theory,
                geometry: &geometry(&[("11", 0.001), ("12", 0.1), ("13", 0.25)]),
            },
            &Similarity::identity(),
            0.01,
        )
        .expect("two near nodes");
        let expected = [("1:+Z".to_owned(), 5.0), ("2:+Z".to_owned(), 6.0)];
        assert_eq!(values(&names.rename(&theory)), expected);
        assert_eq!((findings.len(), findings[0].code), (1, Code::DofsByNode));
        assert!((findings[0].value.expect("a value") - 0.004).abs() < 1e-12);
        // Sensor 3 is 50 mm off, and 9 has no position.
        let text = findings[0].to_string();
        assert_eq!(findings[0].severity, Severity::Warning);
        assert!(
            text.contains("2 of 3 sensors") && text.contains("5.000e-2"),
            "{text}"
        );
    }

    #[test]
    fn a_turned_axis_reads_the_sum_of_the_theorys_components() {
        // The test's x and z turned by 30 degrees about the theory's y; a point at 2 mm of a scale
        // of 1000.
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let frame = Similarity {
            scale: 1e-3,
            rotation: crate::linalg::Matrix3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos),
            shift_m: Vector3::new(0.0, 0.5, 0.0),
        };
        let test = model(&[("1:-X", 1.0), ("1:+Y", 1.0), ("2:+X", 1.0)]);
        let theory = model(&[("7:+X", 2.0), ("7:+Y", 3.0), ("7:-Z", 4.0), ("8:+X", 9.0)]);
        let at = |point: &str, at: [f64; 3]| Node::new(point, at.into());
        let of = |nodes: Vec<Node>| Geometry {
            nodes,
            ..Geometry::default()
        };
        let nodes = of(vec![at("1", [2.0, 0.0, 0.0]), at("2", [500.0, 0.0, 0.0])]);
        let test = LocatedModes {
            modes: &test,
            geometry: &nodes,
        };
        let place = [2e-3 * cos, 0.5, -2e-3 * sin];
        let other = of(vec![at("7", place), at("8", [0.5 * cos, 0.5, -0.5 * sin])]);
        let located = LocatedModes {
            modes: &theory,
            geometry: &other,
        };
        let (names, _) = DofNames::nearest(&test, &located, &frame, 1e-6).expect("a node");
        // Point 8 has no z component and cannot give the reading of 2:+X.
        let found = values(&names.rename(&theory));
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].0.as_str(), found[1].0.as_str()), ("1:+X", "1:+Y"));
        assert!(
            (found[0].1 - (2.0 * cos + 4.0 * sin)).abs() < 1e-12,
            "{found:?}"
        );
        assert!((found[1].1 - 3.0).abs() < 1e-12);
    }

    /// Matches the points of a line test with those of a theory within a tolerance.
    fn line_match(
        test: &[(&str, f64)],
        theory: &[(&str, f64)],
        tolerance_m: f64,
    ) -> Result<(DofNames, Vec<Finding>), CorrelateError> {
        let shape = |points: &[(&str, f64)]| {
            let dofs: Vec<String> = points.iter().map(|(p, _)| format!("{p}:+Z")).collect();
            let values: Vec<(&str, f64)> = dofs.iter().map(|dof| (dof.as_str(), 1.0)).collect();
            model(&values)
        };
        let (test_modes, theory_modes) = (shape(test), shape(theory));
        let (test_nodes, theory_nodes) = (geometry(test), geometry(theory));
        let of = |modes, geometry| LocatedModes { modes, geometry };
        let (test, theory) = (
            of(&test_modes, &test_nodes),
            of(&theory_modes, &theory_nodes),
        );
        DofNames::nearest(&test, &theory, &Similarity::identity(), tolerance_m)
    }

    #[test]
    fn test_without_a_near_node_is_an_error_with_its_distances() {
        let theory = [("11", 0.0), ("12", 0.1), ("13", 0.2)];
        let error = line_match(&[("1", 0.02), ("2", 0.13)], &theory, 0.01).unwrap_err();
        let text = error.to_string();
        for part in ["2.000e-2", "3.000e-2", "1.000e-2", "--align"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(!text.contains("millimetres"), "{text}");
        // In millimetres the origin alone is near; the reason is the unit.
        let millimetres = [("1", 0.0), ("2", 100.0), ("3", 200.0)];
        let text = line_match(&millimetres, &theory, 0.01)
            .unwrap_err()
            .to_string();
        assert!(
            text.contains("1 of 3") && text.contains("millimetres"),
            "{text}"
        );
        // No position at all.
        let error = line_match(&[], &theory, 0.01).unwrap_err();
        assert_eq!(error, CorrelateError::NoLocatedSensor { sensors: 0 });
    }

    #[test]
    fn sensors_at_different_positions_that_share_a_node_are_reported() {
        let theory = [("11", 0.0), ("12", 0.1)];
        let shared = |test: &[(&str, f64)]| {
            let (_, findings) = line_match(test, &theory, 0.04).expect("near nodes");
            let mut found = findings.into_iter();
            found.find(|finding| finding.code == Code::NodeShared)
        };
        let finding = shared(&[("1", 0.0), ("2", 0.03), ("3", 0.1)]).expect("a shared node");
        assert_eq!(finding.value, Some(2.0));
        assert!(
            finding.to_string().contains("1:+Z, 2:+Z at node 11"),
            "{finding}"
        );
        // Two sensors at one position belong to one node.
        assert_eq!(shared(&[("1", 0.0), ("2", 0.0), ("3", 0.1)]), None);
    }
}

//! Geometry and modes written and read back.

use std::collections::BTreeMap;

use num_complex::Complex64;
use proptest::prelude::*;

use super::file_builder::{PATH, dataset, open};
use crate::dof::Dof;
use crate::finding::{Finding, Location};
use crate::geometry::{CoordinateSystem, Element, Geometry, Group, Node, SystemKind, TraceLine};
use crate::io::formats::uff::geometry::write::write_geometry;
use crate::io::formats::uff::modes::write::write_modes;
use crate::io::{Catalog, ModeEntry};
use crate::linalg::Vector3;
use crate::modal::{Mode, ModeShape, Scaling};

/// Geometry and modes as read back, in SI units, and the findings of the writers.
fn read_back(geometry: &Geometry, modes: &[ModeEntry]) -> (Geometry, Vec<ModeEntry>, Vec<Finding>) {
    let mut file = dataset(&["   164", "1", "1. 1. 1.", "0."], "\n");
    let mut findings = write_modes(&mut file, modes, geometry, "Machine", PATH).unwrap();
    findings.extend(write_geometry(&mut file, geometry, PATH).unwrap());
    let longest = file.split(|byte| *byte == b'\n').map(<[u8]>::len).max();
    assert!(longest <= Some(80), "{longest:?}");
    let source = open(file).unwrap();
    let Catalog {
        geometry,
        modes,
        damage,
        ..
    } = source.catalog();
    assert!(damage.is_empty(), "{damage:?}");
    (geometry.clone(), modes.clone(), findings)
}

fn reported_counts(findings: &[Finding]) -> BTreeMap<String, f64> {
    let name = |finding: &Finding| match &finding.location {
        Location::Parameter(what) => (what.clone(), finding.value.unwrap()),
        location => panic!("{location}"),
    };
    findings.iter().map(name).collect()
}

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        -10.0..10.0,
        any::<f64>().prop_filter("finite", |v| v.is_finite())
    ]
}

fn vector() -> impl Strategy<Value = Vector3> {
    (finite(), finite(), finite()).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

/// Axes turned by three angles.
fn axes() -> impl Strategy<Value = [Vector3; 3]> {
    (-3.0..3.0, -1.5..1.5, -3.0..3.0).prop_map(|(a, b, c): (f64, f64, f64)| {
        let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
        [
            Vector3::new(ca * cb, sa * cb, -sb),
            Vector3::new(ca * sb * sc - sa * cc, sa * sb * sc + ca * cc, cb * sc),
            Vector3::new(ca * sb * cc + sa * sc, sa * sb * cc - ca * sc, cb * cc),
        ]
    })
}

fn system() -> impl Strategy<Value = CoordinateSystem> {
    let kinds = prop_oneof![
        Just(SystemKind::Cartesian),
        Just(SystemKind::Cylindrical),
        Just(SystemKind::Spherical)
    ];
    let name = "[a-z][a-z0-9 ]{0,90}[a-z]|";
    (1i64..1_000_000_000, name, kinds, vector(), axes()).prop_map(
        |(label, name, kind, origin_m, axes)| CoordinateSystem {
            label,
            name: name.chars().take(60).collect::<String>().trim().to_owned(),
            kind,
            origin_m,
            axes,
        },
    )
}

fn point() -> impl Strategy<Value = String> {
    (1i64..1_000_000_000).prop_map(|label| label.to_string())
}

fn geometry() -> impl Strategy<Value = Geometry> {
    let systems = proptest::collection::btree_map(0i64..1000, system(), 0..4);
    let node = (vector(), proptest::option::of(2i64..1_000_000_000));
    let nodes = proptest::collection::btree_map(point(), node, 0..6);
    let drawn = proptest::collection::vec(proptest::option::of(point()), 0..20);
    let lines = proptest::collection::vec(("[a-z]{0,9}", drawn), 0..3);
    let element = (
        0i64..1_000_000_000,
        prop_oneof![Just(11i64), 0i64..200],
        proptest::collection::vec(point(), 1..20),
    );
    let member = (0i64..50, 0i64..1_000_000_000);
    let members = proptest::collection::vec(member, 0..9);
    let groups = proptest::collection::vec((0i64..1_000_000_000, "[A-Z]{0,9}", members), 0..3);
    (
        systems,
        nodes,
        lines,
        proptest::collection::vec(element, 0..4),
        groups,
    )
        .prop_map(|(systems, nodes, lines, elements, groups)| Geometry {
            systems: distinct(systems.into_values()),
            nodes: nodes.into_iter().map(node_of).collect(),
            lines: lines
                .into_iter()
                .map(|(name, points)| TraceLine { name, points })
                .collect(),
            elements: elements
                .into_iter()
                .map(|(label, descriptor, points)| Element {
                    label,
                    descriptor,
                    points,
                })
                .collect(),
            groups: groups
                .into_iter()
                .map(|(label, name, members)| Group {
                    label,
                    name,
                    members,
                })
                .collect(),
        })
}

fn distinct(systems: impl Iterator<Item = CoordinateSystem>) -> Vec<CoordinateSystem> {
    let by_label: BTreeMap<i64, CoordinateSystem> =
        systems.map(|system| (system.label, system)).collect();
    by_label.into_values().collect()
}

fn node_of((point, (at_m, displacement_system)): (String, (Vector3, Option<i64>))) -> Node {
    Node {
        point,
        at_m,
        displacement_system,
    }
}

/// Values that the six digits of the format hold.
fn value() -> impl Strategy<Value = Complex64> {
    let digits = -999_999i32..999_999;
    (digits.clone(), digits).prop_map(|(re, im)| Complex64::new(f64::from(re), f64::from(im)))
}

/// A mode at nodes 1 to 5, along every axis, so that none is filled up.
fn mode() -> impl Strategy<Value = Mode> {
    (
        0.0..1e6f64,
        proptest::option::of(-0.5..0.99f64),
        proptest::option::of(1e-3..1e3f64),
        proptest::option::of(any::<u32>()),
        proptest::collection::vec(value(), 15),
        0usize..3,
    )
        .prop_map(|(frequency_hz, damping, mass, group, values, scaling)| {
            let dofs = (1i64..=5)
                .flat_map(|node| (1..=3).filter_map(move |axis| Dof::from_node(node, axis)));
            let scaling = [Scaling::Unknown, Scaling::UnitModalMass, Scaling::UnitMax][scaling];
            let shape = ModeShape::new(dofs.zip(values));
            let mut mode = Mode::new(frequency_hz + 1e-3, damping, shape, scaling);
            (mode.modal_mass_kg, mode.group) = (mass, group);
            mode
        })
}

proptest! {
    #[test]
    fn geometry_comes_back_to_the_bit(geometry in geometry()) {
        let (read, _, findings) = read_back(&geometry, &[]);
        prop_assert!(findings.is_empty(), "{:?}", findings);
        prop_assert_eq!(read, geometry);
    }

    #[test]
    fn modes_come_back_with_every_digit_of_the_pole(modes in proptest::collection::vec(mode(), 1..4)) {
        let entries: Vec<ModeEntry> = modes.iter().cloned().map(ModeEntry::new).collect();
        let (_, read, findings) = read_back(&Geometry::default(), &entries);
        prop_assert_eq!(read.len(), modes.len());
        prop_assert!(findings.is_empty(), "{:?}", findings);
        for (read, mode) in read.iter().zip(&modes) {
            let read_mode = &read.mode;
            prop_assert_eq!(read_mode.frequency_hz.to_bits(), mode.frequency_hz.to_bits());
            prop_assert_eq!(read_mode.damping_ratio.map(f64::to_bits), mode.damping_ratio.map(f64::to_bits));
            prop_assert_eq!(read_mode.modal_mass_kg, mode.modal_mass_kg);
            prop_assert_eq!(read_mode.group, mode.group);
            prop_assert_eq!(&read_mode.shape, &mode.shape);
            prop_assert_eq!(&read.title, &["Machine".to_owned()]);
        }
    }

    #[test]
    fn shapes_at_nodes_with_local_systems_come_back(
        systems in (system(), system()),
        at in (-10.0..10.0f64, -10.0..10.0f64, -10.0..10.0f64),
        mode in mode(),
    ) {
        let mut systems = [systems.0, systems.1];
        (systems[0].label, systems[1].label) = (2, 3);
        systems.iter_mut().for_each(|system| system.origin_m = Vector3::new(1.0, 2.0, 3.0));
        let node = |label: i64, system| Node {
            point: label.to_string(),
            at_m: Vector3::new(at.0, at.1, at.2),
            displacement_system: system,
        };
        let nodes = vec![node(1, Some(2)), node(2, Some(3)), node(3, None)];
        let geometry = Geometry { nodes, systems: systems.to_vec(), ..Geometry::default() };
        let (read, modes, _) = read_back(&geometry, &[ModeEntry::new(mode.clone())]);
        prop_assert_eq!(read, geometry);
        let largest = mode.shape.largest().map_or(0.0, |(_, value)| value.norm());
        for (dof, value) in mode.shape.iter() {
            let read = modes[0].mode.shape.get(dof).unwrap_or_default();
            prop_assert!((read - value).norm() <= 3e-5 * largest, "{} {} {}", dof, read, value);
        }
    }
}

fn plain(values: &[(&str, f64)]) -> Mode {
    let values = values
        .iter()
        .map(|(dof, v)| (dof.parse().unwrap(), Complex64::new(*v, 0.0)));
    Mode::new(10.0, None, ModeShape::new(values), Scaling::Unknown)
}

#[test]
fn mode_properties_beyond_dataset_55_are_counted() {
    let mut mode = plain(&[
        ("5:-Z", 2.0),
        ("5:+X", 3.0),
        ("5:-X", 3.0),
        ("bearing:+Z", 1.0),
        ("box.5:+Y", 1.0),
        ("7:+S", 1.0),
        ("6:+X", 0.0),
        ("7:+X", f64::NAN),
    ]);
    mode.frequency_std_hz = Some(0.1);
    mode.frequency_bias_hz = Some(0.2);
    mode.mpc = Some(0.9);
    mode.method = Some("circle".to_owned());
    let residue = ("5:+Z".parse().unwrap(), "5:+Z".parse().unwrap());
    mode.residues = BTreeMap::from([(residue, Complex64::default())]);
    let second = plain(&[("5:+Z", 1.0)]);
    let lost = Mode::new(f64::NAN, None, ModeShape::default(), Scaling::Unknown);
    let mut entries = [mode, second, lost].map(ModeEntry::new);
    entries[0].title = (0..7).map(|i| format!("line {i}")).collect();
    let (_, modes, findings) = read_back(&Geometry::default(), &entries);
    let expected = [
        ("biases of frequency and damping", 1.0),
        ("degrees of freedom that are 0 in every mode", 1.0),
        ("method and order of modes", 1.0),
        ("missing shape values, written as 0", 1.0),
        ("modes without a frequency", 1.0),
        ("phase collinearity of modes", 1.0),
        ("residues of modes", 1.0),
        ("shape values of repeated measurements", 1.0),
        ("shape values that are not finite", 1.0),
        ("scalar shape values beside directions", 1.0),
        ("shape values without node number", 2.0),
        ("standard deviations of modes", 1.0),
        ("title lines of modes", 3.0),
    ];
    let expected = expected.map(|(what, count)| (what.to_owned(), count));
    assert_eq!(reported_counts(&findings), BTreeMap::from(expected));
    assert_eq!(modes.len(), 2);
    assert_eq!(modes[0].title, ["line 0", "line 1", "line 2", "line 3"]);
    let shape: Vec<String> = modes[0]
        .mode
        .shape
        .iter()
        .map(|(dof, value)| format!("{dof} {}", value.re))
        .collect();
    assert_eq!(shape, ["5:+X 3", "5:+Z -2"], "turned to the positive axis");
}

/// Degrees of freedom and values of a real shape that was written and read, and the findings of the
/// writer.
fn shape_read_back(values: &[(&str, f64)]) -> (Vec<(String, f64)>, usize) {
    let (_, modes, findings) = read_back(&Geometry::default(), &[ModeEntry::new(plain(values))]);
    let shape = modes[0].mode.shape.iter();
    let shape = shape.map(|(dof, value)| (dof.to_string(), value.re));
    (shape.collect(), findings.len())
}

#[test]
fn measured_zeros_are_read_as_zeros_and_unmeasured_directions_as_missing() {
    for values in [
        &[
            ("5:+X", 0.0),
            ("5:+Y", 0.0),
            ("5:+Z", 0.0),
            ("6:+X", 0.0),
            ("6:+Y", 2.0),
            ("6:+Z", 0.0),
        ][..],
        &[("5:+Z", 1.0), ("6:+X", -2.0)],
        &[("5:+S", 1.0), ("6:+S", 0.0)],
    ] {
        let expected = values.iter().map(|(dof, v)| ((*dof).to_owned(), *v));
        assert_eq!(shape_read_back(values), (expected.collect(), 0));
    }
    let unknown = shape_read_back(&[("5:+Z", 1.0), ("6:+X", 0.0)]);
    assert_eq!(unknown, (vec![("5:+Z".to_owned(), 1.0)], 1));
}

#[test]
fn rotations_take_six_values_and_real_modes_stay_real() {
    let mode = plain(&[("5:+X", 1.5), ("5:+RZ", -2.5)]);
    let (_, modes, findings) = read_back(&Geometry::default(), &[ModeEntry::new(mode.clone())]);
    assert!(findings.is_empty(), "{findings:?}");
    assert_eq!((&modes[0].mode, modes[0].modal_a), (&mode, None));
    let mut file = Vec::new();
    write_modes(
        &mut file,
        &[ModeEntry::new(mode)],
        &Geometry::default(),
        "",
        PATH,
    )
    .unwrap();
    let text = String::from_utf8(file).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(
        rows[7],
        "         1         2         3         8         2         6"
    );
    assert_eq!(
        rows[9],
        "  1.00000E+01  0.00000E+00  0.00000E+00  0.00000E+00"
    );
    assert_eq!(rows[11].len(), 78);
}

#[test]
fn a_rotation_with_unknown_components_is_omitted() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let oblique = CoordinateSystem {
        label: 2,
        name: String::new(),
        kind: SystemKind::Cartesian,
        origin_m: Vector3::zeros(),
        axes: [
            Vector3::new(half, half, 0.0),
            Vector3::new(-half, half, 0.0),
            Vector3::z(),
        ],
    };
    let mut node = Node::new("5", Vector3::zeros());
    node.displacement_system = Some(2);
    let geometry = Geometry {
        nodes: vec![node],
        systems: vec![oblique],
        ..Geometry::default()
    };
    let round = |values: &[(&str, f64)]| {
        let (_, modes, findings) = read_back(&geometry, &[ModeEntry::new(plain(values))]);
        let dofs: Vec<String> = modes[0]
            .mode
            .shape
            .iter()
            .map(|(dof, _)| dof.to_string())
            .collect();
        (dofs.join(" "), findings.len())
    };
    assert_eq!(
        round(&[("5:+X", 1.0), ("5:+Y", 1.0)]),
        ("5:+X 5:+Y".to_owned(), 0)
    );
    assert_eq!(round(&[("5:+Z", 1.0)]), ("5:+Z".to_owned(), 0));
    assert_eq!(round(&[("5:+X", 1.0)]), (String::new(), 1));
}

#[test]
fn a_note_contradicting_the_printed_values_is_ignored() {
    let mut mode = plain(&[("5:+X", 1.0)]);
    mode.damping_ratio = Some(0.0123456789);
    mode.group = Some(4);
    let mut file = Vec::new();
    write_modes(
        &mut file,
        &[ModeEntry::new(mode)],
        &Geometry::default(),
        "",
        PATH,
    )
    .unwrap();
    let text = String::from_utf8(file).unwrap();
    let kept = open(text.clone().into_bytes()).unwrap();
    assert_eq!(
        kept.catalog().modes[0].mode.damping_ratio,
        Some(0.0123456789)
    );
    let edited = text.replace("-7.75702E-01", "-7.75802E-01");
    assert_ne!(edited, text);
    let read = open(edited.into_bytes()).unwrap();
    let mode = &read.catalog().modes[0].mode;
    assert!((mode.damping_ratio.unwrap() - 0.0123456789).abs() > 1e-6);
    assert_eq!(mode.group, None);
}

#[test]
fn geometry_without_numeric_labels_is_counted_as_lost() {
    let node = |point: &str, x| Node::new(point, Vector3::new(x, 0.0, 0.0));
    let element = |point: &str| Element {
        label: 1,
        descriptor: 41,
        points: vec![point.to_owned()],
    };
    let mut flat = Geometry {
        nodes: vec![
            node("007", 1.0),
            node("a", 1.0),
            node("8", f64::NAN),
            node("9", 1.0),
        ],
        ..Geometry::default()
    };
    flat.nodes[3].displacement_system = Some(1_000_000_000);
    flat.lines.push(TraceLine {
        name: "-1".to_owned(),
        points: ["9", "bearing", "9"].map(|p| Some(p.to_owned())).to_vec(),
    });
    flat.elements = vec![element("9"), element("1000000000")];
    let (read, _, findings) = read_back(&flat, &[]);
    let expected = [
        ("nodes", 3.0),
        ("displacement systems of nodes", 1.0),
        ("elements", 1.0),
        ("points of trace lines", 1.0),
    ];
    let expected = expected.map(|(what, count)| (what.to_owned(), count));
    assert_eq!(reported_counts(&findings), BTreeMap::from(expected));
    assert_eq!((read.nodes.len(), read.elements.len()), (1, 1));
    let drawn = [Some("9".to_owned()), None, Some("9".to_owned())];
    assert_eq!(read.lines[0].points, drawn);
}

#[test]
fn modal_a_and_b_follow_from_the_modal_mass() {
    // λ = −3 + 4i rad/s.
    let mut mode = plain(&[("5:+X", 1.0)]);
    mode.frequency_hz = 5.0 / std::f64::consts::TAU;
    mode.damping_ratio = Some(0.6);
    mode.modal_mass_kg = Some(0.5);
    let mut file = Vec::new();
    let entries = [ModeEntry::new(mode.clone())];
    write_modes(&mut file, &entries, &Geometry::default(), "", PATH).unwrap();
    let text = String::from_utf8(file).unwrap();
    assert_eq!(
        text.lines().nth(9),
        Some(" -3.00000E+00  4.00000E+00  0.00000E+00  4.00000E+00  1.60000E+01  1.20000E+01")
    );
    let read = open(text.into_bytes()).unwrap();
    let read = &read.catalog().modes[0];
    assert_eq!(
        read.mode, mode,
        "kept without dataset 164, for the note says kg"
    );
    assert_eq!(read.modal_a, Some(Complex64::new(0.0, 4.0)));
    let mut stated = ModeEntry::new(mode);
    stated.modal_a = Some(Complex64::new(1.0, 4.0));
    let (_, read, findings) = read_back(&Geometry::default(), &[stated]);
    assert_eq!(read[0].modal_a, Some(Complex64::new(1.0, 4.0)));
    assert_eq!(read[0].mode.modal_mass_kg, None);
    assert!(reported_counts(&findings).contains_key("modal masses"));
}

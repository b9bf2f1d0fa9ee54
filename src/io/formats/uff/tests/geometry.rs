//! Coordinate systems, nodes, elements and groups from bytes.

use super::file_builder::{dataset, open};
use crate::finding::{Code, Finding};
use crate::geometry::{Geometry, SystemKind};
use crate::io::IoError;

/// System 2 stands on system 3, which stands behind it; its x, y, z are global y, z, x.
const CHAIN: [&str; 9] = [
    "    18",
    "         2         1         3         8         1",
    "Ring",
    "  1.00000E+00  0.00000E+00  0.00000E+00  1.00000E+00  1.00000E+00  0.00000E+00",
    "  2.00000E+00  0.00000E+00  0.00000E+00",
    "         3         0         0",
    "Frame",
    " 10. 20. 30. 11. 20. 30. 10.",
    " 20. 31.",
];

fn read(parts: &[&[&str]]) -> (Geometry, Vec<IoError>, Vec<Finding>) {
    let file: Vec<Vec<u8>> = parts.iter().map(|lines| dataset(lines, "\r\n")).collect();
    let mut source = open(file.concat()).unwrap();
    let damage = source.take_damage().into_iter();
    let damage = damage.map(|part| part.error).collect();
    let catalog = source.catalog();
    (catalog.geometry.clone(), damage, catalog.findings.clone())
}

fn assert_at(geometry: &Geometry, point: &str, expected: [f64; 3]) {
    let at = geometry.node(point).unwrap().at_m;
    let error = (at - crate::linalg::Vector3::from(expected)).norm();
    assert!(error < 1e-12, "{point} at {at:?} instead of {expected:?}");
}

#[test]
fn nodes_are_placed_through_chains_of_systems() {
    let nodes = [
        "   781",
        "         5         2         3        11",
        "   2.0000000000000000D+00   9.0000000000000000D+01   5.0000000000000000D+00",
        "2 3 2 11",
        " 1.0D+00 2.0D+00 3.0D+00",
        "4 1 1 11",
        " 1.0D+00 2.0D+00 3.0D+00",
    ];
    let (geometry, damage, findings) = read(&[&nodes, &CHAIN]);
    assert!(damage.is_empty(), "{damage:?}");
    let codes: Vec<Code> = findings.iter().map(|f| f.code).collect();
    assert_eq!(codes, [Code::Assumption], "metres");
    // Local x, y, z of the ring are y, z, x of the frame, whose axes are the global ones.
    assert_at(&geometry, "5", [10.0 + 1.0 + 5.0, 20.0, 30.0 + 2.0]);
    assert_at(&geometry, "2", [11.0, 22.0, 33.0]);
    assert_at(&geometry, "4", [1.0, 2.0, 3.0]);
    let systems: Vec<Option<i64>> = geometry
        .nodes
        .iter()
        .map(|node| node.displacement_system)
        .collect();
    assert_eq!(systems, [Some(3), Some(2), None]);
    let ring = geometry.system(2).unwrap();
    assert_eq!(
        (ring.name.as_str(), ring.kind),
        ("Ring", SystemKind::Cylindrical)
    );
}

#[test]
fn lengths_of_systems_have_the_units_of_the_file() {
    let spherical = [
        "  2420",
        "         1",
        "Part",
        "         1         2         0",
        "NONE",
        " 0.0D+00 1.0D+00 0.0D+00",
        " 0.0D+00 0.0D+00 1.0D+00",
        " 1.0D+00 0.0D+00 0.0D+00",
        " 1000.0 2000.0 3000.0",
    ];
    let nodes = [
        "    15",
        "7 1 1 1 4000.0 60.0 45.0",
        "8 0 0 1 1000.0 0.0 0.0",
    ];
    let millimetre = ["   164", "5", "1.0D+03 1.0D+00 1.0D+00", "0.0"];
    let (geometry, damage, findings) = read(&[&nodes, &spherical, &millimetre]);
    assert!(
        damage.is_empty() && findings.is_empty(),
        "{damage:?} {findings:?}"
    );
    let root6 = 6f64.sqrt();
    assert_at(&geometry, "7", [1.0 + 2.0, 2.0 + root6, 3.0 + root6]);
    assert_at(&geometry, "8", [1.0, 0.0, 0.0]);
    assert_eq!(geometry.node("7").unwrap().displacement_system, Some(1));
}

#[test]
fn an_undescribed_coordinate_system_is_reported_and_its_node_kept() {
    let nodes = ["    15", "7 6 5 1 1. 2. 3.", "8 6 5 1 2. 2. 3."];
    let units = ["   164", "1", "1. 1. 1.", "0."];
    let unplaced = ["    18", "3 0 17 8 1", "A", "0 0 0 1 0 0", "0 0 1"];
    let (geometry, damage, findings) = read(&[&nodes, &units, &unplaced]);
    assert!(damage.is_empty());
    assert_at(&geometry, "8", [2.0, 2.0, 3.0]);
    assert_eq!(geometry.node("7").unwrap().displacement_system, Some(5));
    let reported: Vec<_> = findings.iter().map(|f| (f.code, f.value)).collect();
    let unknown = |label| (Code::UnknownSystem, Some(label));
    assert_eq!(reported, [unknown(17.0), unknown(6.0), unknown(5.0)]);
}

#[test]
fn bad_systems_are_damage_and_cycles_end() {
    let cycle = [
        "    18",
        "1 0 2 8 1",
        "A",
        "0 0 0 1 0 0",
        "0 0 1",
        "2 0 1 8 1",
        "B",
        "0 0 0 1 0 0",
        "0 0 1",
        "3 0 1 8 1",
        "C",
        "0 0 0 1 0 0",
        "0 0 1",
        "4 0 4 8 1",
        "local",
        "0 0 0 1 0 0",
        "0 0 1",
    ];
    let (geometry, damage, _) = read(&[&cycle]);
    assert_eq!(damage.len(), 3, "{damage:?}");
    assert_eq!(geometry.systems.len(), 1);
    assert!(geometry.systems[0].is_aligned());
    for (lines, what) in [
        (
            vec!["    18", "0 0 0 8 1", "A", "0 0 0 1 0 0", "0 0 1"],
            "label of a coordinate system",
        ),
        (
            vec!["    18", "1 3 0 8 1", "A", "0 0 0 1 0 0", "0 0 1"],
            "coordinate system of dataset 18",
        ),
        (
            vec!["    18", "1 0 0 8 2", "A", "0 0 0 1 0 0", "0 0 1"],
            "coordinate system of dataset 18",
        ),
        (
            vec!["    18", "1 0 0 8 1", "A", "0 0 0 1 0 0", "2 0 0"],
            "coordinate system",
        ),
        (
            vec!["    18", "1 0 0 8 1", "A", "0 0 0 0 0 0", "0 0 1"],
            "coordinate system",
        ),
        (
            vec!["    18", "1 0 0 8 1", "A", "0 0 0 1 0 0", "0 0"],
            "points of a coordinate system",
        ),
        (
            vec!["    18", "1 0 0 8 1", "A", "0 0 0 1 0 0", "0 0 NaN"],
            "points of a coordinate system",
        ),
        (
            vec![
                "  2420", "1", "P", "1 0 0", "A", "1 0 0", "0 1 0", "0 0 -1", "0 0 0",
            ],
            "coordinate system",
        ),
        (
            vec![
                "  2420", "1", "P", "1 0 0", "A", "2 0 0", "0 2 0", "0 0 2", "0 0 0",
            ],
            "coordinate system",
        ),
    ] {
        let (geometry, damage, _) = read(&[&lines]);
        assert!(geometry.systems.is_empty());
        let [IoError::Text { what: got, .. }] = &damage[..] else {
            panic!("{lines:?}: {damage:?}")
        };
        assert_eq!(*got, what, "{lines:?}");
    }
    let again = ["    18", "3 1 0", "Frame", "0 0 0 1 0 0", "0 0 1"];
    let (geometry, damage, _) = read(&[&CHAIN, &CHAIN, &again]);
    assert_eq!((geometry.systems.len(), damage.len()), (2, 1), "{damage:?}");
    assert_eq!(geometry.system(3).unwrap().kind, SystemKind::Cartesian);
}

#[test]
fn a_long_chain_of_systems_is_walked_without_recursion() {
    let mut lines = vec!["    18".to_owned()];
    let count = 20_000;
    for label in 1..=count {
        let reference = if label == count { 0 } else { label + 1 };
        lines.push(format!("{label} 0 {reference} 8 1"));
        lines.extend(["A", "1. 0 0 2. 0 0", "1. 0 1."].map(str::to_owned));
    }
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    let (geometry, damage, _) = read(&[&lines]);
    assert!(damage.is_empty());
    let first = geometry.systems[0].origin_m;
    assert!((first.x - f64::from(count)).abs() < 1e-6 && first.y == 0.0);
}

#[test]
fn elements_with_and_without_beam_lines_are_read() {
    let lines = [
        "  2412",
        "         1        11         2         1         7         2",
        "         0         1         1",
        "         6         8",
        "         9        24         2         1         7         3",
        "         0         1         1",
        "         6         8         9",
        "         2       116         1         1         8        20",
        "         1         2         3         4         5         6         7         8",
        "         9        10        11        12        13        14        15        16",
        "        17        18        19        20",
        " 3 44 1 1 8 4",
        "1000000001100000000210000000031000000004",
    ];
    let (geometry, damage, _) = read(&[&lines[..11]]);
    assert!(damage.is_empty(), "{damage:?}");
    let read_back: Vec<_> = geometry
        .elements
        .iter()
        .map(|element| (element.label, element.descriptor, element.points.len()))
        .collect();
    assert_eq!(read_back, [(1, 11, 2), (9, 24, 3), (2, 116, 20)]);
    assert_eq!(geometry.elements[1].points, ["6", "8", "9"]);
    assert_eq!(geometry.elements[2].points[19], "20");
    let (geometry, damage, _) = read(&[&lines]);
    assert_eq!((geometry.elements.len(), damage.len()), (4, 0));
    assert_eq!(
        geometry.elements[3].points[1], "1000000002",
        "fields that touch"
    );
    for lines in [
        ["  2412", "1 41 1 1 8 3", "1 2"],
        ["  2412", "1 41 1 1 8 2", "1 2 3"],
        ["  2412", "1 41 1 1 8 0", "1 2"],
        ["  2412", "1 41 1 1 8 999999999999", "1 2"],
        ["  2412", "1 41 1 1 8", "1 2"],
        ["  2412", "1 41 1 1 8 2", "1 -2"],
    ] {
        let (geometry, damage, _) = read(&[&lines]);
        assert_eq!((geometry.elements.len(), damage.len()), (0, 1), "{lines:?}");
    }
}

#[test]
fn groups_of_every_number_are_read() {
    let four = [
        "1 0 0 0 0 0 0 3",
        "Left",
        "8 110 0 0 8 117 0 0",
        "7 5 0 0",
        "2 0 0 0 0 0 0 0",
        "",
    ];
    let two = [
        "1 0 0 0 0 0 0 3",
        "Left",
        "8 110 8 117 7 5 0 0",
        "2 0 0 0 0 0 0 0",
        "",
    ];
    for number in crate::io::formats::uff::geometry::dataset_2467::NUMBERS {
        let first = format!("{number:>6}");
        let body: &[&str] = match number {
            2435 | 2452 | 2467 | 2477 => &four,
            _ => &two,
        };
        let lines: Vec<&str> = std::iter::once(first.as_str())
            .chain(body.iter().copied())
            .collect();
        let (geometry, damage, _) = read(&[&lines]);
        assert!(damage.is_empty(), "{number}: {damage:?}");
        let groups = &geometry.groups;
        assert_eq!((groups.len(), groups[0].name.as_str()), (2, "Left"));
        assert_eq!(groups[0].members, [(8, 110), (8, 117), (7, 5)], "{number}");
        assert_eq!((groups[1].label, groups[1].members.len()), (2, 0));
    }
    let endless = [
        "  2467",
        "1 0 0 0 0 0 0 4611686018427387904",
        "Left",
        "8 110 0 0 8 117 0 0",
    ];
    let (geometry, damage, _) = read(&[&endless]);
    assert_eq!((geometry.groups.len(), damage.len()), (0, 1));
}

#[test]
fn the_model_name_is_the_title_where_there_is_no_other() {
    let head = [
        "  2400",
        "1 7 -1 0",
        "Gearbox",
        "P-1",
        "0 0",
        "27-FEB-26",
        "0",
    ];
    let title = |parts: &[&[&str]]| {
        let file: Vec<Vec<u8>> = parts.iter().map(|lines| dataset(lines, "\n")).collect();
        open(file.concat()).unwrap().catalog().title.clone()
    };
    assert_eq!(title(&[&head]), ["Gearbox"]);
    assert_eq!(title(&[&head, &["   151", "Machine"]]), ["Machine"]);
}

#[test]
fn a_node_printed_twice_keeps_its_finer_digits_and_one_displacement_system() {
    let coarse = ["    15", "5 1 0 11  3.33333E-01  0.00000E+00 -2.00000E+00"];
    let fine = [
        "  2411",
        "5 0 1 11",
        "   3.333333333333333D-01   0.000000000000000D+00  -2.000000000000000D+00",
    ];
    let third: f64 = "3.333333333333333E-01".parse().unwrap();
    for parts in [[&coarse[..], &fine[..]], [&fine[..], &coarse[..]]] {
        let (geometry, damage, _) = read(&parts);
        assert!(damage.is_empty(), "{damage:?}");
        assert_eq!(geometry.nodes.len(), 1);
        assert_eq!(geometry.nodes[0].at_m.x.to_bits(), f64::to_bits(third));
    }
    let moved = ["    15", "5 1 0 11  3.33335E-01  0.00000E+00 -2.00000E+00"];
    let turned = ["    15", "5 1 7 11  3.33333E-01  0.00000E+00 -2.00000E+00"];
    for (second, expected) in [
        (moved, "second position of a node"),
        (turned, "second displacement system of a node"),
    ] {
        let (geometry, damage, _) = read(&[&fine, &second]);
        let [IoError::Text { what, .. }] = &damage[..] else {
            panic!("{damage:?}")
        };
        assert_eq!((*what, geometry.nodes.len()), (expected, 1));
        assert_eq!(geometry.nodes[0].displacement_system, None);
    }
}

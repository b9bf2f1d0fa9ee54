//! Modes of datasets 55 and 2414 from bytes, with the odd layouts of real writers.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use num_complex::Complex64;
use proptest::prelude::*;

use super::file_builder::{dataset, open};
use crate::finding::Code;
use crate::io::formats::uff::modes::names_measurement_system;
use crate::io::{IoError, ModeEntry, Source};
use crate::modal::Scaling;

const UNITS: [&str; 4] = ["   164", "1", "  1.0D+00  1.0D+00  1.0D+00", "0."];
const MILLIMETRE: [&str; 4] = ["   164", "1", "  1.0D+03  2.0D+00  1.0D+00", "0."];

/// ID lines and records 6 to 8 of a complex mode, as Testlab writes them: λ = −3 + 4i, modal A =
/// 8i, B = 32 + 24i.
const COMPLEX: [&str; 9] = [
    "    55",
    "Bench  ",
    "Export of Test.Lab",
    "MODE NO. 1, FREQUENCY 0.636620(Hz), DAMPING 0.600000",
    "None",
    "",
    "         1         3         2         8         5         3",
    "         2         6         1         1",
    " -3.00000e+00  4.00000e+00  0.00000e+00  8.00000e+00  3.20000e+01  2.40000e+01",
];

const NORMAL: [&str; 8] = [
    "    55",
    "NONE",
    "NONE",
    "NONE",
    "NONE",
    "NONE",
    "         1         2         2         8         2         3",
    "         2         4         1         1",
];

fn opened(parts: &[Vec<&str>]) -> Box<dyn Source> {
    let file: Vec<Vec<u8>> = parts.iter().map(|lines| dataset(lines, "\n")).collect();
    let source = open(file.concat()).unwrap();
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    source
}

fn modes(parts: &[Vec<&str>]) -> Vec<ModeEntry> {
    opened(parts).catalog().modes.clone()
}

fn with<'a>(head: &[&'a str], rows: &[&'a str]) -> Vec<&'a str> {
    [head, rows].concat()
}

fn shape(entry: &ModeEntry) -> Vec<(String, f64, f64)> {
    let values = entry.mode.shape.iter();
    values
        .map(|(dof, v)| (dof.to_string(), v.re, v.im))
        .collect()
}

fn component(dof: &str, re: f64, im: f64) -> (String, f64, f64) {
    (dof.to_owned(), re, im)
}

#[test]
fn a_complex_mode_has_the_frequency_and_damping_of_its_eigenvalue() {
    let rows = [
        "        12",
        "  2.99110e-02-10.00000e-05  0.00000e+00  0.00000e+00 -1.00000e+00  0.00000e+00",
    ];
    let modes = modes(&[with(&COMPLEX, &rows), UNITS.to_vec()]);
    let (entry, mode) = (&modes[0], &modes[0].mode);
    assert!(
        (mode.frequency_hz - 5.0 / TAU).abs() < 1e-15,
        "|lambda|, not the damped one"
    );
    assert!((mode.damping_ratio.unwrap() - 0.6).abs() < 1e-15);
    assert_eq!(
        entry.title,
        [
            "Bench",
            "Export of Test.Lab",
            "MODE NO. 1, FREQUENCY 0.636620(Hz), DAMPING 0.600000"
        ]
    );
    assert_eq!(entry.modal_a, Some(Complex64::new(0.0, 8.0)));
    assert_eq!(entry.modal_b, Some(Complex64::new(32.0, 24.0)));
    assert_eq!(
        (mode.modal_mass_kg, mode.scaling),
        (Some(1.0), Scaling::UnitModalMass)
    );
    assert_eq!(entry.line, Some(2));
    let expected = [
        component("12:+X", 2.9911e-2, -1e-4),
        component("12:+Z", -1.0, 0.0),
    ];
    assert_eq!(
        shape(entry),
        expected,
        "the direction that is never anything but 0 is no DOF"
    );
}

#[test]
fn a_direction_measured_in_one_mode_is_kept_in_all() {
    let first = with(
        &NORMAL,
        &["10.0 0. 0. 0.", "5", "1. 0. 0.", "6", "0. 0. 0."],
    );
    let second = with(&NORMAL, &["20.0 0. 0. 0.", "5", "2. 3. 0."]);
    let theory = opened(&[first.clone(), second.clone()]);
    let [one, two] = &theory.catalog().modes[..] else {
        panic!("two modes")
    };
    assert_eq!((one.mode.shape.len(), two.mode.shape.len()), (6, 3));
    assert_eq!(theory.catalog().findings, []);
    let title = vec!["   151", "Simcenter Testlab", "", "", "", "", "", ""];
    let source = opened(&[first, second, title]);
    let reported = source.catalog().findings.iter();
    let reported: Vec<_> = reported
        .map(|finding| (finding.code, finding.value))
        .collect();
    assert_eq!(reported, [(Code::UnmeasuredLeftOut, Some(4.0))]);
    let modes = &source.catalog().modes;
    assert_eq!(
        shape(&modes[0]),
        [component("5:+X", 1.0, 0.0), component("5:+Y", 0.0, 0.0)]
    );
    assert_eq!(
        shape(&modes[1]),
        [component("5:+X", 2.0, 0.0), component("5:+Y", 3.0, 0.0)]
    );
}

#[test]
fn normal_modes_have_mass_and_either_damping() {
    for (record, frequency, damping, mass, scaling) in [
        (
            "1.0D+01 2.0D+00 3.0D-02 0.0",
            10.0,
            Some(0.03),
            Some(2.0),
            Scaling::Unknown,
        ),
        (
            " 1.00000E+01-1.00000E+00-3.00000E-02 5.00000E-02",
            10.0,
            Some(-0.03),
            Some(-1.0),
            Scaling::Unknown,
        ),
        (
            "10. 1. 0. .05",
            10.0,
            Some(0.025),
            Some(1.0),
            Scaling::UnitModalMass,
        ),
        ("10.", 10.0, None, None, Scaling::Unknown),
        ("0. 0. 0. 0.", 0.0, None, None, Scaling::Unknown),
        ("-1.5-105 0. 0. 0.", 1.5e-105, None, None, Scaling::Unknown),
    ] {
        let other = with(&NORMAL, &["20.", "5", "0. 1. 0."]);
        let mode = with(&NORMAL, &[record, "5", "1. 0. 0."]);
        let modes = modes(&[UNITS.to_vec(), mode, other]);
        let mode = &modes[0].mode;
        assert_eq!(
            (mode.frequency_hz, mode.damping_ratio),
            (frequency, damping),
            "{record}"
        );
        assert_eq!(
            (mode.modal_mass_kg, mode.scaling),
            (mass, scaling),
            "{record}"
        );
    }
    let unstated = modes(&[with(&NORMAL, &["10. 1. 0. 0.", "5", "1. 0. 0."])]);
    assert_eq!(
        unstated[0].mode.modal_mass_kg, None,
        "no dataset says what its unit is"
    );
}

#[test]
fn a_modal_scale_without_unit_is_omitted_and_reported() {
    let rows = ["5", "1. 0. 0. 0. 0. 0."];
    let mut acceleration = with(&COMPLEX, &rows);
    acceleration[6] = "         1         3         2        12         5         3";
    let normal = with(&NORMAL, &["10. 2. 0. 0.", "5", "1. 0. 0."]);
    for parts in [
        vec![with(&COMPLEX, &rows)],
        vec![UNITS.to_vec(), acceleration],
        vec![normal],
    ] {
        let source = opened(&parts);
        let (entry, findings) = (&source.catalog().modes[0], &source.catalog().findings);
        assert_eq!((entry.modal_a, entry.modal_b), (None, None));
        assert_eq!(entry.mode.modal_mass_kg, None);
        let scale = findings
            .iter()
            .find(|finding| finding.code == Code::ModalScaleUnknown);
        assert_eq!(scale.map(|finding| finding.value), Some(Some(1.0)));
    }
}

#[test]
fn theory_of_the_same_maker_is_no_measurement() {
    for (line, expected) in [
        ("Analysis of LMS Test.Lab 17", true),
        ("Simcenter Testlab 2021", true),
        ("SIMCENTER", true),
        ("LMS Virtual.Lab", false),
        ("Simcenter Nastran", false),
        ("Simcenter 3D 2206", false),
        ("films", false),
        ("", false),
    ] {
        assert_eq!(names_measurement_system(line), expected, "{line}");
    }
}

#[test]
fn negative_damping_and_poles_at_the_origin_break_nothing() {
    let with_pole = |record: &'static str| {
        let mut lines = with(&COMPLEX, &["5", "1. 2. 0. 0. 0. 0."]);
        lines[8] = record;
        let stable = with(&COMPLEX, &["5", "1. 2. 0. 0. 0. 0."]);
        modes(&[lines, stable, UNITS.to_vec()]).remove(0)
    };
    let unstable = with_pole("3. 4. 0. 0. 0. 0.");
    assert!((unstable.mode.damping_ratio.unwrap() + 0.6).abs() < 1e-15);
    assert_eq!(
        (unstable.modal_a, unstable.mode.modal_mass_kg),
        (None, None)
    );
    let rigid = with_pole("0. 0. 0. 8. 0. 0.");
    assert_eq!(
        (rigid.mode.frequency_hz, rigid.mode.damping_ratio),
        (0.0, None)
    );
    assert_eq!(rigid.mode.modal_mass_kg, None);
    let undamped = with_pole("0. 4. 0. 0. 0. 0.");
    assert_eq!(undamped.mode.damping_ratio, Some(0.0));
    let conjugate = with_pole("-3. -4. 0. -8. 32. -24.");
    assert_eq!(shape(&conjugate), [component("5:+X", 1.0, -2.0)]);
    assert_eq!(conjugate.modal_a, Some(Complex64::new(0.0, 8.0)));
    assert_eq!(conjugate.mode.modal_mass_kg, Some(1.0));
    let general = with_pole("-3. 4. 1. 8. 0. 0.");
    assert_eq!(
        general.mode.modal_mass_kg, None,
        "modal A / 2i omega is not real"
    );
}

#[test]
fn lengths_are_turned_to_metres_and_masses_with_them() {
    let rows = ["10. 5. 0. 0.", "5", "1000. 0. 0. 0. 0. .5"];
    let mut six = with(&NORMAL, &rows);
    six[1] = "Test.Lab";
    six[6] = "         1         2         3         8         2         6";
    let modes = modes(&[MILLIMETRE.to_vec(), six]);
    assert_eq!(
        shape(&modes[0]),
        [component("5:+X", 1.0, 0.0), component("5:+RZ", 0.5, 0.0)]
    );
    // (mm)² N s²/mm over 1000 mm to the metre and 2 units of force to the newton.
    assert_eq!(modes[0].mode.modal_mass_kg, Some(5.0 / 2000.0));
}

#[test]
fn shapes_at_nodes_with_local_systems_are_turned_at_the_end_of_the_file() {
    let mut six = with(
        &NORMAL,
        &[
            "10. 0. 0. 0.",
            "1",
            "1. 2. 0. 0. 0. 3.",
            "2",
            "1. 0. 0. 0. 0. 0.",
            "3",
            "0. 0. 4. 0. 0. 0.",
        ],
    );
    six[6] = "         1         2         3         8         2         6";
    six[1] = "LMS";
    // At 45° of a cylindrical system; global y, z, x as local x, y, z with rounding; a half turn
    // about y.
    let nodes = vec![
        "    15",
        "1 0 4 1 1. 1. 5.",
        "2 0 5 1 0. 0. 0.",
        "3 0 6 1 0. 0. 0.",
        "4 0 6 1 0. 0. 0.",
    ];
    let systems = vec![
        "    18",
        "4 1 0 8 1",
        "ring",
        "0. 0. 0. 1. 0. 0.",
        "0. 0. 1.",
        "5 0 0 8 1",
        "turned",
        "0. 0. 0. 0. 1. -8.74228e-08",
        "1. 0. 0.",
        "6 0 0 8 1",
        "half",
        "0. 0. 0. -1. 0. -8.74228e-08",
        "-1. 0. -1.",
    ];
    let source = opened(&[six, UNITS.to_vec(), nodes, systems]);
    let catalog = source.catalog();
    let reported: Vec<_> = catalog.findings.iter().map(|f| (f.code, f.value)).collect();
    let expected = [
        (Code::UnmeasuredLeftOut, Some(13.0)),
        (Code::LocalSystemApplied, Some(3.0)),
    ];
    assert_eq!(reported, expected);
    let expected = [
        component("1:+X", -FRAC_1_SQRT_2, 0.0),
        component("1:+Y", 3.0 * FRAC_1_SQRT_2, 0.0),
        component("1:+RZ", 3.0, 0.0),
        component("2:+Y", 1.0, 0.0),
        component("3:+Z", -4.0, 0.0),
    ];
    let got = shape(&catalog.modes[0]);
    assert_eq!(got.len(), expected.len(), "{got:?}");
    for ((dof, re, im), (name, value, _)) in got.iter().zip(&expected) {
        assert_eq!(dof, name);
        assert!((re - value).abs() < 1e-12 && *im == 0.0, "{dof} {re}");
    }
}

#[test]
fn six_complex_values_are_wrapped_and_scalars_have_no_direction() {
    let rows = [
        "5",
        "1. 2. 3. 4. 5. 6.",
        "7. 8. 9. 10. 11. 12.",
        "",
        "7",
        "1. 2. 3. 4. 5. 6. 7. 8. 9. 10. 11. 12.",
    ];
    let mut six = with(&COMPLEX, &rows);
    six[6] = "         1         3         3         8         5         6";
    let mut scalar = with(&COMPLEX, &["5", "1.5", "2.5"]);
    scalar[6] = "         1         3         1         8         5         1";
    let modes = modes(&[six, scalar]);
    let six = shape(&modes[0]);
    assert_eq!((six.len(), &six[5]), (12, &component("5:+RZ", 11.0, 12.0)));
    assert_eq!(six[6], component("7:+X", 1.0, 2.0));
    assert_eq!(shape(&modes[1]), [component("5:+S", 1.5, 2.5)]);
}

#[test]
fn dataset_2414_has_the_same_modes() {
    let head = [
        "  2414",
        "         1",
        "Bench",
        "1",
        "NONE",
        "NONE",
        "NONE",
        "second line",
        "NONE",
    ];
    let real = [
        "1 2 2 8 2 3",
        "0 0 0 0 0 1 0 0",
        "0 0",
        "  0.00000E+00  1.00000E+01  3.94784E+03  2.00000E+00  1.00000E-02",
        "  0.00000E+00",
        "5",
        "1. 2. 3.",
    ];
    let complex = [
        "1 3 2 8 6 3",
        "0 0 0 0 0 1 0 0",
        "0 0",
        "0. 0. 0. 0. 0. 0. -3. 4. 0. 8. 32. 24.",
        "5",
        "1. 2. 3. 4. 5. 6.",
    ];
    let modes = modes(&[UNITS.to_vec(), with(&head, &real), with(&head, &complex)]);
    let first = &modes[0].mode;
    assert_eq!(
        (first.frequency_hz, first.damping_ratio),
        (10.0, Some(0.01))
    );
    assert_eq!(first.modal_mass_kg, Some(2.0));
    assert_eq!(modes[0].title, ["Bench", "second line"]);
    assert_eq!(shape(&modes[0])[2], component("5:+Z", 3.0, 0.0));
    assert!((modes[1].mode.frequency_hz - 5.0 / TAU).abs() < 1e-15);
    assert_eq!(shape(&modes[1])[2], component("5:+Z", 5.0, 6.0));
}

#[test]
fn a_duplicate_node_in_a_mode_is_damage() {
    let twice = with(
        &NORMAL,
        &["10.", "5", "1. 2. 3.", "6", "1. 1. 1.", "5", "3. 2. 1."],
    );
    let source = open(dataset(&twice, "\n")).unwrap();
    let catalog = source.catalog();
    let damage: Vec<&IoError> = catalog
        .damage
        .iter()
        .map(|damaged| &damaged.error)
        .collect();
    let [IoError::Text { line: 15, got, .. }] = damage[..] else {
        panic!("{:?}", catalog.damage)
    };
    assert_eq!((got.trim(), catalog.modes.len()), ("5", 0));
}

#[test]
fn a_mode_of_dataset_2414_states_its_frequency() {
    let mode = |analysis: &'static str, rows: [&'static str; 2]| {
        let mut lines = vec!["  2414", "1", "Bench", "1", "", "", "", "", "", analysis];
        lines.extend(["0", "0"].iter().chain(&rows).chain(&["5", "1. 2. 3."]));
        open(dataset(&lines, "\n")).unwrap().take_damage().len()
    };
    let (normal, complex) = ("1 2 2 8 2 3", "1 3 2 8 2 3");
    assert_eq!(mode(normal, ["0. 10.", "0."]), 0);
    assert_eq!(mode(normal, ["0.", "0."]), 1);
    assert_eq!(mode(complex, ["0.", "-3. 4."]), 0);
    assert_eq!(mode(complex, ["0.", "0."]), 1);
}

#[test]
fn datasets_55_without_modes_are_reported_once() {
    let mut transient = with(&NORMAL, &["0.5", "5", "1. 2. 3."]);
    transient[6] = "         1         4         2         8         2         3";
    let mut stress = with(&NORMAL, &["10. 0. 0. 0.", "5", "1. 2. 3. 4. 5. 6."]);
    stress[6] = "         1         2         4         2         2         6";
    let on_elements = vec![
        "  2414",
        "1",
        "T",
        "2",
        "",
        "",
        "",
        "",
        "",
        "1 1 1 5 2 1",
        "0",
        "0",
        "x",
    ];
    let parts = [transient.clone(), stress, transient, on_elements];
    let source = opened(&parts);
    let reported: Vec<_> = source
        .catalog()
        .findings
        .iter()
        .map(|f| (f.code, f.value))
        .collect();
    let other = |analysis| (Code::NotModes, Some(analysis));
    assert_eq!(reported, [other(4.0), other(2.0), other(1.0)]);
    assert!(source.catalog().modes.is_empty());
}

#[test]
fn a_damaged_mode_is_left_out_and_placed() {
    let good = with(&NORMAL, &["10. 0. 0. 0.", "5", "1. 2. 3."]);
    for (index, text, line) in [
        (6, "1 2 2 8 2", 8),
        (6, "1 2 2 8 3 3", 8),
        (6, "1 2 2 8 2 -3", 8),
        (6, "1 2 2 8 2 6", 12),
        (7, "2 999999999999 1 1", 9),
        (7, "2", 9),
        (8, "1. 2. 3. 4. 5.", 10),
        (8, "1. 2. NaN 4.", 10),
        (7, "2 0 1 1", 9),
        (8, "", 9),
        (9, "-5", 11),
        (9, "5.5", 11),
        (10, "1. 2. 3. 4.", 12),
        (10, "1. 2.", 12),
        (10, "1. x 3.", 12),
        (10, "1. inf 3.", 12),
    ] {
        let mut lines = good.clone();
        lines[index] = text;
        let file = [dataset(&lines, "\n"), dataset(&good, "\n")].concat();
        let mut source = open(file).unwrap();
        assert_eq!(source.catalog().modes.len(), 1, "{text}");
        let damage = source.take_damage();
        let damage: Vec<&IoError> = damage.iter().map(|damaged| &damaged.error).collect();
        let [IoError::Text { line: at, .. }] = damage[..] else {
            panic!("{text}: {damage:?}")
        };
        assert_eq!(*at, line, "{text}");
    }
}

/// Frequencies with damping ratios, and codes with values of findings.
type PolesAndFindings = (Vec<(f64, Option<f64>)>, Vec<(Code, Option<f64>)>);

/// Poles and findings of normal modes of dataset 55 with these records 8.
fn normal_poles(records: &[&str]) -> PolesAndFindings {
    let of_record = |record: &&str| {
        let rows = [*record, "5", "1. 2. 3."];
        dataset(&with(&NORMAL, &rows), "\n")
    };
    let file: Vec<Vec<u8>> = records.iter().map(of_record).collect();
    let source = open(file.concat()).unwrap();
    let catalog = source.catalog();
    let modes = catalog.modes.iter().map(|entry| &entry.mode);
    let poles = modes.map(|mode| (mode.frequency_hz, mode.damping_ratio));
    let findings = catalog.findings.iter();
    let findings = findings.map(|finding| (finding.code, finding.value));
    (poles.collect(), findings.collect())
}

#[test]
fn percent_of_a_lightly_damped_structure_is_recognised() {
    let (poles, findings) = normal_poles(&["10. 0. .2 0.", "20. 0. 1.2 0.", "30. 0. 0. .8"]);
    let ratios: Vec<f64> = poles.iter().filter_map(|pole| pole.1).collect();
    for (got, expected) in ratios.iter().zip([0.002, 0.012, 0.004]) {
        assert!((got - expected).abs() < 1e-15, "{ratios:?}");
    }
    assert_eq!(findings, [(Code::DampingInPercent, Some(1.2))]);
}

#[test]
fn plausible_and_unknown_damping_is_not_reported() {
    for record in ["10. 0. .15 0.", "10. 0. 0. .3", "10.", "10. 0. 0. 0."] {
        let (poles, findings) = normal_poles(&[record, "20. 0. .1 0."]);
        assert_eq!((poles.len(), findings), (2, vec![]), "{record}");
    }
    // Impossible as percent, too.
    let (poles, findings) = normal_poles(&["10. 0. 150. 0."]);
    assert_eq!(poles, [(10.0, Some(150.0))]);
    assert_eq!(findings, [(Code::DampingImplausible, Some(150.0))]);
}

#[test]
fn modes_without_any_frequency_are_damage_and_one_of_zero_hertz_beside_others_is_not() {
    assert_eq!(normal_poles(&["0. 0. 0. 0.", "20."]).0.len(), 2);
    let mode = dataset(&with(&NORMAL, &["0. 0. 0. 0.", "5", "1. 2. 3."]), "\n");
    let mut source = open([mode.clone(), mode].concat()).unwrap();
    assert!(source.catalog().modes.is_empty());
    let damage = source.take_damage();
    let damage: Vec<String> = damage
        .iter()
        .map(|damaged| damaged.error.to_string())
        .collect();
    assert_eq!(damage.len(), 2);
    assert!(
        damage[0].contains(":2: frequency of a mode: got"),
        "{damage:?}"
    );
    assert!(
        damage[0].contains("export the modes with their frequencies"),
        "{damage:?}"
    );
}

proptest! {
    #[test]
    fn a_convention_changes_no_frequency_and_damping_by_sign_or_percent_alone(
        numbers in proptest::collection::vec((-1e3..1e3f64, -1e3..1e3f64), 1..6),
    ) {
        let of_pole = |(re, im): &(f64, f64)| {
            let record = format!("{re:e} {im:e} 0. 0. 0. 0.");
            let mut lines = with(&COMPLEX, &["5", "1. 2. 0. 0. 0. 0."]);
            lines[8] = &record;
            dataset(&lines, "\n")
        };
        let file: Vec<Vec<u8>> = numbers.iter().map(of_pole).collect();
        let source = open(file.concat()).unwrap();
        let modes = &source.catalog().modes;
        prop_assert_eq!(modes.len(), numbers.len());
        let are_all_positive = numbers.iter().all(|(re, _)| *re >= 0.0);
        for (entry, (re, im)) in modes.iter().zip(&numbers) {
            let norm = re.hypot(*im);
            prop_assert!((entry.mode.frequency_hz * TAU - norm).abs() <= 1e-9 * norm);
            let ratio = if are_all_positive { re / norm } else { -re / norm };
            prop_assert!((entry.mode.damping_ratio.unwrap() - ratio).abs() <= 1e-9);
        }
    }
}

/// A file of nodes on two lines along x and normal modes at 0 Hz with these displacements along z,
/// printed with five digits.
fn modes_at_zero_hertz(shapes: &[fn(f64, f64) -> f64]) -> (usize, usize) {
    modes_far_from_the_origin(shapes, 0.0)
}

/// The same with this added to the coordinates along y of the file.
fn modes_far_from_the_origin(shapes: &[fn(f64, f64) -> f64], distance_m: f64) -> (usize, usize) {
    let nodes: Vec<[f64; 2]> = (0..8)
        .map(|node| [0.3 * f64::from(node / 2), 0.2 * f64::from(node % 2)])
        .collect();
    let numbered = || (1..).zip(&nodes);
    let records =
        numbered().map(|(label, [x, y])| format!("{label} 0 0 1 {x} {} 0.1", y + distance_m));
    let nodes_lines: Vec<String> = ["    15".to_owned()].into_iter().chain(records).collect();
    let lines =
        |lines: &[String]| dataset(&lines.iter().map(String::as_str).collect::<Vec<_>>(), "\n");
    let mut file = lines(&nodes_lines);
    for shape in shapes {
        let mut mode: Vec<String> = NORMAL.map(str::to_owned).to_vec();
        mode.push("0. 0. 0. 0.".to_owned());
        for (label, [x, y]) in numbered() {
            mode.push(label.to_string());
            mode.push(format!("0. 0. {:.4e}", shape(*x, *y)));
        }
        file.extend(lines(&mode));
    }
    let source = open(file).unwrap();
    (source.catalog().modes.len(), source.catalog().damage.len())
}

#[test]
fn a_file_of_rigid_body_modes_alone_is_not_damage() {
    let rigid: [fn(f64, f64) -> f64; 3] = [
        |_, _| 0.81234,
        |x, _| 0.3 - 1.23456 * x,
        |x, y| 0.1 + 0.7 * x - 2.34567 * y,
    ];
    assert_eq!(modes_at_zero_hertz(&rigid), (3, 0));
    // More than six modes are not all rigid-body modes, whatever their shapes.
    assert_eq!(modes_at_zero_hertz(&[rigid[0]; 7]), (0, 7));
}

#[test]
fn rigid_body_modes_far_from_the_origin_are_not_damage() {
    let roll: fn(f64, f64) -> f64 = |_, y| y - 0.1;
    assert_eq!(modes_far_from_the_origin(&[roll], 100.0), (1, 0));
}

#[test]
fn modes_at_zero_hertz_that_bend_are_damage() {
    // The first bending mode of a clamped beam is about x² (3 l - x).
    let bending: fn(f64, f64) -> f64 = |x, _| x * x * (2.7 - x);
    assert_eq!(modes_at_zero_hertz(&[bending]), (0, 1));
    assert_eq!(modes_at_zero_hertz(&[|x, _| 1.0 - x, bending]), (0, 2));
}

//! Units in the spellings of measurement systems, and units that a scene states.

use super::universal_file::{
    DAMPING, FREQUENCY_HZ, Function, OneFile, RESIDUES, Values, accelerances, file_of,
    finds_the_mode, modes_of_run, on_file,
};

/// The three accelerances in another unit of `factor` m/s² per N.
fn in_unit(ordinate: &str, denominator: &str, factor: f64) -> Vec<Function> {
    let mut functions = accelerances();
    for function in &mut functions {
        function.ordinate.unit = ordinate.to_owned();
        function.denominator.unit = denominator.to_owned();
        if let Values::Complex(values) = &mut function.values {
            values.iter_mut().for_each(|value| *value /= factor);
        }
    }
    functions
}

/// The residue of the driving point that `identify` states, in m/(N s).
fn driving_point_residue(json: &serde_json::Value) -> f64 {
    let residue = &json["modes"][0]["residues"]["1:+Z|1:+Z"];
    let part = |index: usize| residue[index].as_f64().unwrap();
    part(0).hypot(part(1))
}

#[test]
fn every_spelling_of_a_unit_gives_the_factor_of_the_unit() {
    let pound = 4.448_221_615_260_5;
    for (ordinate, denominator, factor) in [
        ("g", "lb", 9.806_65 / pound),
        ("m/s**2", "N", 1.0),
        ("mm/s\u{b2}", "N", 1e-3),
        ("in/s\u{b2}", "lbf", 0.0254 / pound),
        ("mg", "Newton", 9.806_65e-3),
        ("m/sec^2", "daN", 0.1),
        ("mm/sec/sec", "kgf", 1e-3 / 9.806_65),
        ("M/S2", "KN", 1e-3),
        ("\u{b5}g", "mN", 9.806_65e-3),
        ("(m/s^2)/N", "", 1.0),
        ("m.s-2", "[N]", 1.0),
    ] {
        let file = OneFile::new("u.uff", file_of(&in_unit(ordinate, denominator, factor)));
        let ran = finds_the_mode(&file.path(), &[]);
        let expected = RESIDUES[0] / (2.0 * std::f64::consts::TAU * FREQUENCY_HZ);
        let got = driving_point_residue(&ran.json());
        let error = got * (1.0 - DAMPING * DAMPING).sqrt() / expected - 1.0;
        assert!(error.abs() < 2e-3, "{ordinate} over {denominator}: {error}");
    }
}

#[test]
fn an_unknown_unit_is_named_in_the_error() {
    let file = OneFile::new("u.uff", file_of(&in_unit("furlong/s2", "N", 1.0)));
    let ran = on_file("identify", &file.path(), &[]);
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.error.contains("furlong/s2"), "{ran:?}");
}

/// A scene of one test with a unit of its FRFs.
fn scene(unit: &str) -> String {
    format!(
        "schema = \"modalign-scene/1\"\ntitle = \"units\"\n[[test]]\nname = \"t\"\nfiles = \
         [\"u.uff\"]\n[[test.channel]]\ncolumn = 1\nunit = \"{unit}\"\n"
    )
}

/// The modes that `run` finds in a folder with the file and the scene, with the whole output.
fn modes_of_scene(file: &OneFile, unit: &str) -> (serde_json::Value, String) {
    modes_of_run(file, &scene(unit))
}

#[test]
fn a_scene_states_receptances_where_the_head_has_a_fixed_code_and_no_unit() {
    let mut functions = in_unit("NONE", "NONE", 1.0);
    for function in &mut functions {
        let (start, step) = function.axis;
        if let Values::Complex(values) = &mut function.values {
            for (line, value) in values.iter_mut().enumerate() {
                let omega = std::f64::consts::TAU * (start + step * line as f64);
                *value /= -omega * omega;
            }
        }
    }
    let file = OneFile::new("u.uff", file_of(&functions));
    let (modes, said) = modes_of_scene(&file, "m/N");
    let expected = RESIDUES[0] / (2.0 * std::f64::consts::TAU * FREQUENCY_HZ);
    let error = driving_point_residue(&modes) / expected - 1.0;
    assert!(error.abs() < 2e-3, "{error}");
    assert!(said.contains("unit-contradicts-file"), "{said}");
}

#[test]
fn a_unit_of_the_scene_precedes_another_one_of_the_file() {
    let file = OneFile::new("u.uff", file_of(&accelerances()));
    let (modes, said) = modes_of_scene(&file, "g/N");
    let expected = 9.806_65 * RESIDUES[0] / (2.0 * std::f64::consts::TAU * FREQUENCY_HZ);
    let error = driving_point_residue(&modes) / expected - 1.0;
    assert!(error.abs() < 2e-3, "{error}");
    assert!(said.contains("unit-contradicts-file"), "{said}");
    let (_, said) = modes_of_scene(&file, "(m/s^2)/N");
    assert!(!said.contains("unit-contradicts-file"), "{said}");
}

#[test]
fn a_unit_of_the_scene_is_not_put_on_another_quantity() {
    for (data_type, unit) in [
        (15, "Pa"),
        (3, "uE"),
        (15, "NONE"),
        (0, "V"),
        (12, "rad/s^2"),
    ] {
        let mut functions = in_unit("NONE", "NONE", 1.0);
        let mut other = functions[1].clone();
        (other.response.name, other.response.node) = ("Mic".to_owned(), 9);
        (other.ordinate.data_type, other.ordinate.unit) = (data_type, unit.to_owned());
        functions.push(other);
        let file = OneFile::new("u.uff", file_of(&functions));
        let (modes, said) = modes_of_scene(&file, "(m/s2)/N");
        let shape = modes["modes"][0]["shape"].as_object().unwrap();
        assert_eq!(shape.len(), 3, "{data_type} {unit}: {shape:?}");
        assert!(said.contains("function-left-out"), "{said}");
    }
}

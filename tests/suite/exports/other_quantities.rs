//! A function of another quantity leaves the others usable.

use num_complex::Complex64;

use super::universal_file::{
    AxisLabel, Function, OneFile, Point, RESIDUES, accelerance_at, accelerances, even_lines,
    file_of, finds_the_mode, modes_of_run, on_file,
};
use crate::command::write;

/// The accelerances and a function that differs from the second one.
fn with(change: impl Fn(&mut Function)) -> OneFile {
    let mut functions = accelerances();
    let mut other = functions[1].clone();
    other.response = Point {
        name: "Extra".to_owned(),
        ..Point::new(9, 0)
    };
    change(&mut other);
    functions.push(other);
    OneFile::new("other.uff", file_of(&functions))
}

#[test]
fn a_function_of_another_quantity_is_left_out() {
    let ordinate = |data_type, unit: &'static str| AxisLabel::new(data_type, "Other", unit);
    for (ordinate, denominator) in [
        (ordinate(15, "Pa"), ordinate(13, "N")),
        (ordinate(15, "NONE"), ordinate(13, "N")),
        (ordinate(3, "µm/m"), ordinate(13, "N")),
        (ordinate(0, "mV"), ordinate(13, "N")),
        (ordinate(13, "N"), ordinate(13, "N")),
        (ordinate(12, "rad/s²"), ordinate(13, "N")),
        (ordinate(12, "m/s2"), ordinate(0, "V")),
        (ordinate(12, "m/s2"), ordinate(12, "m/s2")),
    ] {
        let file = with(|other| {
            (other.ordinate, other.denominator) = (ordinate.clone(), denominator.clone());
        });
        let ran = finds_the_mode(&file.path(), &[]);
        let units = format!("{ordinate:?} {denominator:?}");
        assert!(ran.findings().contains("function-left-out"), "{units}");
        let shape = &ran.json()["modes"][0]["shape"];
        assert_eq!(shape.as_object().unwrap().len(), 3, "{units}");
    }
}

#[test]
fn rotations_and_moments_of_a_virtual_point_are_left_out() {
    let file = with(|other| {
        (other.response.name, other.response.direction) = ("VP1".to_owned(), 5);
        other.ordinate.unit = "rad/s^2".to_owned();
    });
    let mut functions = accelerances();
    let mut moment = functions[1].clone();
    moment.reference = Point::new(4, 4);
    moment.denominator = AxisLabel::new(13, "Moment", "Nm");
    functions.push(moment);
    let by_moment = OneFile::new("moment.uff", file_of(&functions));
    for file in [file, by_moment] {
        assert!(
            finds_the_mode(&file.path(), &[])
                .findings()
                .contains("function-left-out")
        );
    }
}

#[test]
fn time_records_without_a_force_are_left_out_beside_frfs() {
    let response = Function::record(1, false, vec![0.5; 200]);
    let two = [
        response.clone(),
        Function::record(2, false, vec![0.25; 200]),
    ];
    let force = Function::record(1, true, vec![1.0; 200]);
    for records in [&two[..1], &two[..], &[force][..]] {
        let mut functions = accelerances();
        functions.extend(records.iter().cloned());
        let file = OneFile::new("mixed.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("records-passed-over"), "{ran:?}");
        // Before them as well.
        functions.rotate_right(records.len());
        finds_the_mode(&OneFile::new("mixed.uff", file_of(&functions)).path(), &[]);
    }
}

/// A function of motions times a factor, by this power of the circular frequency.
fn response(node: i64, unit: &'static str, factor: Complex64, power: i32) -> Function {
    let value = |hz: &f64| {
        let omega = Complex64::new(0.0, std::f64::consts::TAU * hz);
        factor * accelerance_at(*hz, RESIDUES[0]) * omega.powi(power - 2)
    };
    let values = even_lines().iter().map(value).collect();
    Function {
        response: Point {
            name: "Extra".to_owned(),
            ..Point::new(node, 0)
        },
        ordinate: AxisLabel::new(0, "Other", unit),
        ..Function::accelerance(node, values)
    }
}

/// The modes of `run` with these tables of channels, and all output.
fn run_with(functions: &[Function], channels: &str) -> (serde_json::Value, String) {
    let file = OneFile::new("other.uff", file_of(functions));
    let scene = format!(
        "schema = \"modalign-scene/1\"\ntitle = \"others\"\n[[test]]\nname = \"t\"\nfiles = \
         [\"other.uff\"]\n{channels}"
    );
    modes_of_run(&file, &scene)
}

#[test]
fn responses_of_another_quantity_are_used_where_the_scene_says_so() {
    let pressure = Complex64::new(3e4, -2e4);
    let strain = Complex64::new(-0.7, 0.0);
    let rotation = Complex64::new(1.5, 0.0);
    let mut functions = accelerances();
    functions.push(response(7, "mPa", 1e3 * pressure, 2));
    functions.push(response(8, "um/m", 1e6 * strain, 0));
    let mut turned = response(9, "rad/s^2", rotation, 2);
    turned.response.direction = 5;
    functions.push(turned);
    functions.push(response(6, "V", Complex64::ONE, 0));
    let channels = "[[test.channel]]\ncolumn = 1\nunit = \"mPa/N\"\n[[test.channel]]\ncolumn = \
                    2\ndof = \"Extra.8:+S\"\nunit = \"(um/m)/N\"\n[[test.channel]]\ncolumn = 3\nunit = \
                    \"(rad/s^2)/N\"\n";
    let (modes, said) = run_with(&functions, channels);
    assert!(
        said.contains("function-left-out") && said.contains("Extra.6:+S"),
        "{said}"
    );
    assert!(!said.contains("sensor-scale"), "{said}");
    let modes = modes["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1, "{modes:?}");
    let value = |group: &serde_json::Value, dof: &str| {
        let part = |i: usize| group[dof][i].as_f64().unwrap();
        Complex64::new(part(0), part(1))
    };
    let shape = &modes[0]["shape"];
    assert_eq!(shape.as_object().unwrap().len(), 3, "{shape}");
    let others = &modes[0]["other_shapes"];
    for (group, dof, expected) in [
        ("Pa s2", "Extra.7:+S", pressure),
        ("m/m", "Extra.8:+S", strain),
        ("rad", "Extra.9:+RY", rotation),
    ] {
        let ratio = value(&others[group], dof) / value(shape, "1:+Z");
        assert!(
            (ratio / expected - 1.0).norm() < 5e-3,
            "{group}: {ratio} {others}"
        );
    }
    let frequency = modes[0]["frequency_hz"].as_f64().unwrap();
    assert!((frequency - 20.0).abs() < 2e-3, "{frequency}");
}

#[test]
fn pressures_of_hits_are_used_again_from_the_files_of_frfs() {
    let mut functions = Vec::new();
    for hit in 0..3 {
        let mut force = vec![0.0; 512];
        force[8 + hit] = 1.0;
        let decay = |sample: usize, size: f64| {
            let t = sample as f64 - 8.0 - hit as f64;
            let (omega, rate) = (std::f64::consts::TAU * 20.0 / 256.0, 0.02);
            if t < 0.0 {
                0.0
            } else {
                size * (-rate * t).exp() * (omega * t).sin()
            }
        };
        let record = |size: f64| (0..512).map(|sample| decay(sample, size)).collect();
        let mut pressure = Function::record(9, false, record(2.5));
        pressure.ordinate = AxisLabel::new(0, "Other", "Pa");
        let response = Function::record(2, false, record(1.0));
        for mut function in [Function::record(1, true, force), response, pressure] {
            function.version = 1 + hit as i64;
            functions.push(function);
        }
    }
    let file = OneFile::new("other.uff", file_of(&functions));
    let scene = "schema = \"modalign-scene/1\"\ntitle = \"others\"\n[[test]]\nname = \"t\"\nfiles = \
                 [\"other.uff\"]\n[[test.channel]]\ncolumn = 3\nunit = \"Pa\"\n";
    write(file.folder(), &[("scene.toml", scene)]);
    for name in ["o.h5", "o.npz", "o.mat"] {
        let out = file.folder().join(name);
        let ran = on_file("frf", file.folder(), &["-o", out.to_str().unwrap()]);
        assert!(matches!(ran.code, Some(0 | 1)), "{ran:?}");
        let ran = on_file("identify", &out, &["--json"]);
        let mode = &ran.json()["modes"][0];
        let parts = |value: &serde_json::Value| {
            let part = |i: usize| value[i].as_f64().unwrap();
            Complex64::new(part(0), part(1))
        };
        let residue = |response: &str| parts(&mode["residues"][format!("{response}|1:+Z")]);
        // A pressure of the form of the acceleration.
        let ratio = residue("9:+Z") / residue("2:+Z");
        assert!((ratio - 2.5).norm() < 0.01, "{name}: {ran:?}");
    }
}

#[test]
fn a_microphone_gives_the_shape_of_a_roving_hammer() {
    let functions: Vec<Function> = (1..=3)
        .zip(RESIDUES)
        .map(|(node, residue)| {
            let factor = Complex64::new(residue / RESIDUES[0], 0.0);
            let mut function = response(9, "Pa", 2e3 * factor, 2);
            function.reference = Point::new(node, 3);
            function
        })
        .collect();
    let (modes, said) = run_with(
        &functions,
        "[[test.channel]]\ncolumn = 1\nunit = \"Pa/N\"\n",
    );
    let shape = modes["modes"][0]["shape"].as_object().unwrap();
    assert_eq!(shape.len(), 3, "{said}");
    for (node, residue) in (1..=3).zip(RESIDUES) {
        let value = |dof: &str| shape[dof][0].as_f64().unwrap();
        let ratio = value(&format!("{node}:+Z")) / value("1:+Z");
        assert!(
            (ratio - residue / RESIDUES[0]).abs() < 5e-3,
            "{node}: {ratio}"
        );
    }
}

#[test]
fn strains_alone_are_a_shape_apart() {
    let strain =
        |node: i64, factor: f64| response(node, "um/m", Complex64::new(1e6 * factor, 0.0), 0);
    let functions = [strain(7, 1.0), strain(8, -0.5)];
    let (modes, said) = run_with(
        &functions,
        "[[test.channel]]\ncolumn = 1\nunit = \"(um/m)/N\"\n",
    );
    let mode = &modes["modes"][0];
    assert_eq!(mode["shape"].as_object().unwrap().len(), 0, "{said}");
    let value = |dof: &str| mode["other_shapes"]["m/m"][dof][0].as_f64().unwrap();
    assert!(
        (value("Extra.8:+S") / value("Extra.7:+S") + 0.5).abs() < 5e-3,
        "{mode}"
    );
}

#[test]
fn the_unit_of_a_response_precedes_that_of_all_and_contradictions_are_said() {
    let mut functions = accelerances();
    let mut other = response(7, "", Complex64::new(2.0, 0.0), 2);
    other.denominator.unit = String::new();
    functions.push(other);
    functions.push(response(8, "mPa", Complex64::new(3e3, 0.0), 2));
    let channels = "[[test.channel]]\ncolumn = 1\nunit = \"(m/s2)/N\"\n[[test.channel]]\ncolumn = 2\nunit = \"Pa/N\"\ndof = \"Extra.7:+S\"\n[[test.channel]]\ncolumn = 3\nunit = \"Pa/N\"\n";
    let (modes, said) = run_with(&functions, channels);
    let mode = &modes["modes"][0];
    let first = mode["shape"]["1:+Z"][0].as_f64().unwrap();
    let value = |dof: &str| mode["other_shapes"]["Pa s2"][dof][0].as_f64().unwrap() / first;
    assert!((value("Extra.7:+S") - 2.0).abs() < 0.01, "{mode}");
    // The unit of the scene precedes that of the header, and it is said.
    assert!((value("Extra.8:+S") - 3e3).abs() < 10.0, "{mode}");
    assert!(said.contains("unit-contradicts-file"), "{said}");
}

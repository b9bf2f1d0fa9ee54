//! A body on a soft suspension, with positions in the file: its mass line checks the sensors.

use num_complex::Complex64;

use super::universal_file::{Function, OneFile, Point, Values, on_file};

const MASS_KG: f64 = 20.0;
/// About the axes through the centre, kg m².
const INERTIA: [f64; 3] = [0.6, 0.9, 1.1];
const SUSPENSION_HZ: f64 = 2.0;
const ELASTIC_HZ: f64 = 110.0;

/// Position in m and direction code of each node: sensors 1 to 12, hits 21 to 23.
fn points() -> Vec<(i64, [f64; 3], i32)> {
    let sensor = |number: i64| {
        let angle = 2.4 * number as f64;
        let height = [-0.2, 0.15, 0.25][(number % 3) as usize];
        let at = [0.4 * angle.cos(), 0.3 * angle.sin(), height];
        (number, at, (number % 3 + 1) as i32)
    };
    let hits = [
        (21, [0.35, -0.1, 0.25], 3),
        (22, [0.1, 0.3, -0.2], 2),
        (23, [-0.4, 0.05, 0.2], 1),
    ];
    (1..=12).map(sensor).chain(hits).collect()
}

/// Translation and rotation of the body that a point along its axis drives or reads.
fn row([x, y, z]: [f64; 3], direction: i32) -> [f64; 6] {
    match direction {
        1 => [1.0, 0.0, 0.0, 0.0, z, -y],
        2 => [0.0, 1.0, 0.0, -z, 0.0, x],
        _ => [0.0, 0.0, 1.0, y, -x, 0.0],
    }
}

/// The FRFs, each sensor's times its gain.
fn functions(gain: impl Fn(i64) -> f64) -> Vec<Function> {
    let mass = [
        MASS_KG, MASS_KG, MASS_KG, INERTIA[0], INERTIA[1], INERTIA[2],
    ];
    let points = points();
    let (hits, sensors): (Vec<_>, Vec<_>) = points.into_iter().partition(|point| point.0 > 20);
    let mut functions = Vec::new();
    for (hit, at_hit, hit_direction) in &hits {
        for (sensor, at, direction) in &sensors {
            let (of_hit, of_sensor) = (row(*at_hit, *hit_direction), row(*at, *direction));
            let rigid: f64 = (0..6).map(|a| of_hit[a] * of_sensor[a] / mass[a]).sum();
            let bending = |at: &[f64; 3]| (9.0 * at[0] * at[0] - 0.6) / MASS_KG.sqrt();
            let elastic = bending(at_hit) * bending(at);
            let value = |line: usize| {
                let hz = 1.0 + 0.5 * line as f64;
                let ratio = SUSPENSION_HZ / hz;
                let hung = rigid / Complex64::new(1.0 - ratio * ratio, -0.05 * ratio * ratio);
                let ratio = ELASTIC_HZ / hz;
                let bent = elastic / Complex64::new(1.0 - ratio * ratio, -0.02 * ratio);
                gain(*sensor) * (hung + bent)
            };
            let mut function = Function::accelerance(*sensor, Vec::new());
            function.response = Point::new(*sensor, *direction);
            function.reference = Point::new(*hit, *hit_direction);
            function.axis = (1.0, 0.5);
            function.values = Values::Complex((0..300).map(value).collect());
            functions.push(function);
        }
    }
    functions
}

/// The file with nodes (dataset 15, in the units of dataset 164).
fn file(functions: &[Function]) -> OneFile {
    let mut text = "    -1\n   164\n         1SI                           2\n  1.0D+00  1.0D+00  \
                    1.0D+00\n  0.0D+00\n    -1\n    -1\n    15\n"
        .to_owned();
    for (node, [x, y, z], _) in points() {
        text += &format!(
            "{node:>10}{:>10}{:>10}{:>10}{x:>13.5E}{y:>13.5E}{z:>13.5E}\n",
            0, 0, 0
        );
    }
    text += "    -1\n";
    text += &super::universal_file::file_of(functions);
    OneFile::new("hung.uff", text)
}

#[test]
fn the_mass_line_gives_the_mass() {
    let ran = on_file("identify", &file(&functions(|_| 1.0)).path(), &["--json"]);
    let findings = ran.json()["findings"].clone();
    let mass = findings
        .as_array()
        .unwrap()
        .iter()
        .find(|f| f["code"] == "mass-of-mass-line");
    let mass = mass.unwrap_or_else(|| panic!("{findings}"))["value"]
        .as_f64()
        .unwrap();
    assert!((mass / MASS_KG - 1.0).abs() < 0.01, "{mass}");
    assert!(!ran.findings().contains("sensor-not-rigid"), "{ran:?}");
}

#[test]
fn a_sensor_that_does_not_fit_the_mass_line_is_named() {
    for (gain, text) in [
        (-1.0, "other sign"),
        (1.2, "1.2"),
        (9.80665, "m/s2 taken for g"),
    ] {
        let of = |sensor: i64| if sensor == 7 { gain } else { 1.0 };
        let ran = on_file("identify", &file(&functions(of)).path(), &["--json"]);
        let findings = ran.json()["findings"].clone();
        let all = findings.as_array().unwrap();
        let fault = all.iter().find(|f| f["code"] == "sensor-not-rigid");
        let fault = fault
            .unwrap_or_else(|| panic!("{gain}: {findings}"))
            .to_string();
        assert!(fault.contains(text) && fault.contains("7:+Y"), "{fault}");
    }
}

#[test]
fn several_reversed_sensors_are_no_rigid_body_and_give_no_mass() {
    let of = |sensor: i64| {
        if [2, 7, 9].contains(&sensor) {
            -1.0
        } else {
            1.0
        }
    };
    let ran = on_file("identify", &file(&functions(of)).path(), &["--json"]);
    let findings = ran.json()["findings"].clone();
    let all = findings.as_array().unwrap();
    let found = |code: &str| all.iter().find(|finding| finding["code"] == code);
    let several = found("sensors-not-rigid").unwrap_or_else(|| panic!("{findings}"));
    assert!(several["value"].as_f64() > several["limit"].as_f64());
    assert!(found("sensor-not-rigid").is_none() && found("mass-of-mass-line").is_none());
}

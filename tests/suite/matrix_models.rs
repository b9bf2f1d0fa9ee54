//! Models whose matrices come from files, from `model.toml` to every verb that takes a model: a
//! chain of equal masses between walls, whose frequencies are known in closed form.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;

use num_complex::Complex64;
use serde_json::Value;

use crate::command::{json, succeed, write};

/// Mass of each, kg, and stiffness of each spring, N/m.
const MASS: f64 = 2.0;
const STIFFNESS: f64 = 5e5;

const SCENE: &str = r#"
    schema = "modalign-scene/1"
    title = "chain"
    [model]
    file = "model.toml"
    [[test]]
    name = "measured"
    modes = "modes.json"
    [update]
    parameters = ["wall"]
"#;

/// A symmetric matrix by its lower triangle, rows and columns from 1.
pub fn matrix_market(size: usize, entries: &[(usize, usize, f64)]) -> String {
    let count = entries.len();
    let mut text =
        format!("%%MatrixMarket matrix coordinate real symmetric\n{size} {size} {count}\n");
    for (i, j, value) in entries {
        writeln!(text, "{i} {j} {value}").unwrap();
    }
    text
}

/// A chain of `size` masses: springs between them fixed, those to the walls scaled by the parameter
/// `wall`.
fn chain(size: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let masses: Vec<_> = (1..=size).map(|i| (i, i, MASS)).collect();
    let mut springs = Vec::new();
    for i in 1..size {
        let end = |number: usize| {
            if number == 1 || number == size {
                1.0
            } else {
                2.0
            }
        };
        springs.push((i, i, end(i) * STIFFNESS));
        springs.push((i + 1, i, -STIFFNESS));
    }
    springs.push((size, size, STIFFNESS));
    let walls = [(1, 1, STIFFNESS), (size, size, STIFFNESS)];
    let dofs: Vec<String> = (1..=size).map(|i| format!("{i}:+X")).collect();
    let model = r#"
        schema = "modalign-model/1"
        title = "chain"
        [matrices]
        dofs = "dofs.txt"
        mass = "m.mtx"
        stiffness = "k.mtx"
        [[matrices.group]]
        parameter = "wall"
        stiffness = "wall.mtx"
        [[parameter]]
        name = "wall"
        unit = "-"
        nominal = 1.0
        lower = 0.1
        upper = 10.0
        status = "assumed"
        [damping]
        stiffness_s = 1e-6
    "#;
    write(
        folder.path(),
        &[
            ("m.mtx", &matrix_market(size, &masses)),
            ("k.mtx", &matrix_market(size, &springs)),
            ("wall.mtx", &matrix_market(size, &walls)),
            ("dofs.txt", &dofs.join("\n")),
            ("model.toml", model),
            ("scene.toml", SCENE),
        ],
    );
    folder
}

/// Natural frequency `number` (from 1) between walls as stiff as the chain, Hz.
fn closed_form(size: usize, number: usize) -> f64 {
    let angle = 0.5 * std::f64::consts::PI * number as f64 / (size + 1) as f64;
    2.0 * (STIFFNESS / MASS).sqrt() * angle.sin() / std::f64::consts::TAU
}

fn theory(folder: &Path, arguments: &[&str]) -> Value {
    let model = folder.join("model.toml");
    let first = ["theory".as_ref(), model.as_os_str(), "--json".as_ref()];
    let all = first.into_iter().chain(arguments.iter().map(OsStr::new));
    serde_json::from_str(&succeed(all)).unwrap()
}

/// Writes the modes of the chain with other walls as those of a test.
fn measure(folder: &Path, wall: &str) {
    let (model, modes) = (folder.join("model.toml"), folder.join("modes.json"));
    let set = format!("wall={wall}");
    let verb: [&OsStr; 6] = [
        "theory".as_ref(),
        model.as_os_str(),
        "--set".as_ref(),
        set.as_ref(),
        "-o".as_ref(),
        modes.as_os_str(),
    ];
    succeed(verb);
}

fn frequency(mode: &Value) -> f64 {
    mode["frequency_hz"].as_f64().unwrap()
}

#[test]
fn a_dense_model_is_solved_swept_compared_run_and_updated() {
    let size = 6;
    let folder = chain(size);
    let path = folder.path();
    let sweep = ["--sweep", "wall=0.5:2:3", "--energies", "--sensitivities"];
    let found = theory(path, &sweep);
    assert_eq!(found["schema"], "modalign-sweep/1");
    let solution = &found["theory"];
    for number in 1..=size {
        let hz = closed_form(size, number);
        let energy = &solution["energies"][number - 1];
        assert!((frequency(energy) / hz - 1.0).abs() < 1e-12, "{energy}");
        let shares = energy["kinetic"].as_object().unwrap();
        assert_eq!(shares.len(), size);
        let sum: f64 = shares.values().map(|share| share.as_f64().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        // df/f = U/2 dtheta/theta of a parameter that scales stiffness alone.
        let strain = &energy["strain"];
        assert_eq!(strain.as_object().unwrap().len(), 2, "{strain}");
        let [wall, rest] = ["wall", "rest"].map(|name| strain[name].as_f64().unwrap());
        assert!((wall + rest - 1.0).abs() < 1e-12, "{strain}");
        // Of a chain between walls: phi_1 is sqrt(2/(n + 1)/m) sin(j pi/(n + 1)), and dlambda = 2 k
        // phi_1^2.
        let angle = std::f64::consts::PI * number as f64 / (size + 1) as f64;
        let phi2 = 2.0 / (size + 1) as f64 / MASS * angle.sin().powi(2);
        let lambda = (std::f64::consts::TAU * hz).powi(2);
        let expected = 0.5 * 2.0 * STIFFNESS * phi2 / lambda;
        let found_relative = &solution["sensitivities"][number - 1]["by"]["wall"]["relative"];
        assert!(
            (found_relative.as_f64().unwrap() - expected).abs() < 1e-12,
            "{found_relative} {expected}"
        );
        assert!((0.5 * wall - expected).abs() < 1e-12, "{wall} {expected}");
        let locus = &found["sweeps"][0]["loci"][number - 1]["frequency_hz"];
        let rises = locus[0].as_f64() < locus[1].as_f64() && locus[1].as_f64() < locus[2].as_f64();
        assert!(rises, "{locus}");
    }
    measure(path, "1.21");
    let model = path.join("model.toml");
    let modes = path.join("modes.json");
    let correlate: [&OsStr; 6] = [
        "correlate".as_ref(),
        "--test".as_ref(),
        modes.as_os_str(),
        "--theory".as_ref(),
        model.as_os_str(),
        "--json".as_ref(),
    ];
    let table: Value = serde_json::from_str(&succeed(correlate)).unwrap();
    let out = path.join("out");
    succeed([
        "run".as_ref(),
        path.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    for table in [table, json(&out.join("comparison.json"))] {
        let rows = table["rows"].as_array().unwrap();
        assert_eq!(rows.len(), size);
        for (number, row) in (1..).zip(rows) {
            assert_eq!(row["tests"][0]["status"], "paired", "{row}");
            let hz = row["theory"]["hz"].as_f64().unwrap();
            assert!((hz / closed_form(size, number) - 1.0).abs() < 1e-12);
            let error = row["tests"][0]["error_percent"].as_f64().unwrap();
            assert!(error > 0.1, "stiffer walls: {error}");
        }
    }
    let update = ["update".as_ref(), path.as_os_str(), "--json".as_ref()];
    let updated: Value = serde_json::from_str(&succeed(update)).unwrap();
    let wall = updated["parameters"][0]["updated"].as_f64().unwrap();
    // The prior pulls by the square of the deviations' ratio: a thousandth over three tenths.
    assert!((wall / 1.21 - 1.0).abs() < 1e-3, "{wall}");
}

#[test]
fn a_sparse_model_is_solved_run_swept_and_described_by_its_largest_bodies() {
    let size = 1200;
    let folder = chain(size);
    let path = folder.path();
    let found = theory(path, &["--band", "0:1", "--sensitivities"]);
    let modes = found["modes"].as_array().unwrap();
    let expected: Vec<f64> = (1..=size)
        .map(|number| closed_form(size, number))
        .take_while(|hz| *hz <= 1.0)
        .collect();
    assert_eq!(modes.len(), expected.len());
    for (mode, hz) in modes.iter().zip(&expected) {
        assert!((frequency(mode) / hz - 1.0).abs() < 1e-9, "{hz}");
        let damping = mode["damping_ratio"].as_f64().unwrap();
        let proportional = 0.5 * 1e-6 * std::f64::consts::TAU * hz;
        assert!((damping / proportional - 1.0).abs() < 1e-9, "{damping}");
    }
    let per_mode = found["theory"]["sensitivities"].as_array().unwrap();
    assert_eq!(per_mode.len(), expected.len());
    let model = path.join("model.toml");
    let energies: [&OsStr; 5] = [
        "theory".as_ref(),
        model.as_os_str(),
        "--energies".as_ref(),
        "--band".as_ref(),
        "0:0.3".as_ref(),
    ];
    let text = succeed(energies);
    assert!(text.contains("T others (%)"), "{text}");
    let sweep: [&OsStr; 7] = [
        "theory".as_ref(),
        model.as_os_str(),
        "--sweep".as_ref(),
        "wall=0.5:1.5:3".as_ref(),
        "--band".as_ref(),
        "0:0.9".as_ref(),
        "--json".as_ref(),
    ];
    let file: Value = serde_json::from_str(&succeed(sweep)).unwrap();
    let loci = file["sweeps"][0]["loci"].as_array().unwrap();
    assert_eq!(loci.len(), 4);
    for (number, locus) in (1..).zip(loci) {
        let hz = locus["frequency_hz"][1].as_f64().unwrap();
        let expected = closed_form(size, number);
        assert!((hz / expected - 1.0).abs() < 1e-9, "{hz} {expected}");
    }
    measure(path, "1");
    let table = succeed(["run".as_ref(), path.as_os_str(), "--json".as_ref()]);
    let table: Value = serde_json::from_str(&table).unwrap();
    let rows = table["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 30, "the lowest thirty");
    for row in rows {
        assert_eq!(row["tests"][0]["status"], "paired", "{row}");
        assert!(
            row["tests"][0]["mac"].as_f64().unwrap() > 1.0 - 1e-9,
            "{row}"
        );
    }
}

/// Two masses of which one has a damper to ground: no ratio by mode describes it.
#[test]
fn a_damping_matrix_that_couples_the_modes_gives_complex_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let (m, k, c) = ([2.0, 3.0], [[9e5, -4e5], [-4e5, 7e5]], 150.0);
    let model = r#"
        schema = "modalign-model/1"
        title = "one damper"
        [matrices]
        dofs = ["1:+X", "2:+X"]
        mass = "m.mtx"
        damping = "c.mtx"
        stiffness = "k.mtx"
    "#;
    let stiffness = [(1, 1, k[0][0]), (2, 1, k[1][0]), (2, 2, k[1][1])];
    write(
        path,
        &[
            ("m.mtx", &matrix_market(2, &[(1, 1, m[0]), (2, 2, m[1])])),
            ("c.mtx", &matrix_market(2, &[(1, 1, c)])),
            ("k.mtx", &matrix_market(2, &stiffness)),
            ("model.toml", model),
        ],
    );
    let found = theory(path, &["--damped"]);
    let modes = found["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 2);
    let complex =
        |value: &Value| Complex64::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap());
    let s = Complex64::new(0.0, 500.0);
    let mut receptance = Complex64::ZERO;
    for mode in modes {
        let lambda = complex(&mode["pole_rad_s"]);
        let shape = ["1:+X", "2:+X"].map(|dof| complex(&mode["shape"][dof]));
        // (λ²M + λC + K)φ = 0, over its largest term.
        for i in 0..2 {
            let damping = if i == 0 { c } else { 0.0 };
            let inertia = (lambda * lambda * m[i] + lambda * damping) * shape[i];
            let elastic = k[i][0] * shape[0] + k[i][1] * shape[1];
            assert!((inertia + elastic).norm() < 1e-10 * 1e6 * shape[0].norm());
        }
        assert!(mode["mpc"].as_f64().unwrap() < 0.999, "{mode}");
        let residue = shape[0] * shape[0] / Complex64::new(0.0, 2.0 * lambda.im);
        receptance += residue / (s - lambda) + residue.conj() / (s - lambda.conj());
    }
    let dynamic = |i: usize| s * s * m[i] + k[i][i];
    let determinant = (dynamic(0) + s * c) * dynamic(1) - k[0][1] * k[1][0];
    let expected = dynamic(1) / determinant;
    assert!(
        (receptance / expected - 1.0).norm() < 1e-10,
        "{receptance} {expected}"
    );
    // Without the option ratios are of first order and shapes real.
    let real = theory(path, &[]);
    for mode in real["modes"].as_array().unwrap() {
        assert!(complex(&mode["shape"]["1:+X"]).im.abs() <= 0.0, "{mode}");
    }
}

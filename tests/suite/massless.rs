//! A lumped-mass space frame whose rotations carry no mass, through the verbs that take a model,
//! against the condensed problem in numpy (`tests/reference/massless_frame.py`, which makes the
//! same frame).

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;

use serde_json::Value;

use crate::command::{json, succeed, write};
use crate::matrix_models::matrix_market;

const COLUMNS_X: usize = 4;
const COLUMNS_Y: usize = 5;
const LENGTH_M: f64 = 4.0;
/// Equal to numpy within this part: both programs round the condensed matrices.
const EQUAL: f64 = 1e-9;

/// EA, GJ, and EI for bending along the first and the second axis after that of the member, in the
/// order x, y, z, x, ...
type Section = [f64; 4];
const COLUMN: Section = [4.0e9, 3.2e7, 6.4e7, 1.28e8];
const BEAM_X: Section = [2.0e9, 1.6e7, 3.2e7, 9.6e7];
const BEAM_Y: Section = [2.4e9, 2.4e7, 1.28e8, 4.8e7];

/// Storey, row and column of a node.
type Node = [usize; 3];
type Entries = BTreeMap<(usize, usize), f64>;

/// The matrices of a frame over all coordinates, six for each node.
struct Frame {
    nodes: Vec<Node>,
    columns: Entries,
    beams: Entries,
    permanent: Entries,
    live: Entries,
}

impl Frame {
    fn new(storeys: usize) -> Self {
        let left_out = |node: &Node| node[0] == storeys && node[1] + 1 == COLUMNS_Y && node[2] > 1;
        let all = (0..=storeys)
            .flat_map(|s| (0..COLUMNS_Y).flat_map(move |y| (0..COLUMNS_X).map(move |x| [s, y, x])));
        let nodes: Vec<Node> = all.filter(|node| !left_out(node)).collect();
        let place = |node: Node| nodes.iter().position(|other| *other == node);
        let (mut columns, mut beams) = (Entries::new(), Entries::new());
        let (mut permanent, mut live) = (Entries::new(), Entries::new());
        for (i, &[s, y, x]) in nodes.iter().enumerate() {
            let number = (s * COLUMNS_Y + y) * COLUMNS_X + x + 1;
            for along in 0..3 {
                let at = (6 * i + along, 6 * i + along);
                permanent.insert(at, 2000.0 + 100.0 * (number % 7) as f64);
                live.insert(at, if s % 2 == 0 { 800.0 } else { 0.0 });
            }
            if s == 0 {
                continue;
            }
            let below = place([s - 1, y, x]).unwrap();
            member(&mut columns, [below, i], 2, COLUMN);
            for (neighbour, axis, section) in
                [([s, y, x + 1], 0, BEAM_X), ([s, y + 1, x], 1, BEAM_Y)]
            {
                if let Some(other) = place(neighbour) {
                    member(&mut beams, [i, other], axis, section);
                }
            }
        }
        Self {
            nodes,
            columns,
            beams,
            permanent,
            live,
        }
    }

    /// Coordinates that neither the feet nor the prop hold.
    fn free(&self) -> Vec<usize> {
        let propped = 6 * self
            .nodes
            .iter()
            .position(|node| *node == [4, 0, 0])
            .unwrap();
        let feet = 6 * COLUMNS_X * COLUMNS_Y;
        let free = |i: &usize| *i >= feet && *i != propped && *i != propped + 1;
        (0..6 * self.nodes.len()).filter(free).collect()
    }

    /// The degree of freedom of a coordinate.
    fn dof(&self, coordinate: usize) -> String {
        let [s, y, x] = self.nodes[coordinate / 6];
        let number = (s * COLUMNS_Y + y) * COLUMNS_X + x + 1;
        let axis = ["X", "Y", "Z", "RX", "RY", "RZ"][coordinate % 6];
        format!("{number}:+{axis}")
    }

    /// Writes matrices, a model of them and a scene; a sensor on every seventh coordinate.
    fn write(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let free = self.free();
        let market = |of: &Entries| {
            let place = |i: usize| free.binary_search(&i).ok().map(|at| at + 1);
            let inside = of.iter().filter(|((i, j), _)| i >= j);
            let inside = inside.filter_map(|((i, j), v)| Some((place(*i)?, place(*j)?, *v)));
            matrix_market(free.len(), &inside.collect::<Vec<_>>())
        };
        let dofs: Vec<String> = free.iter().map(|&i| self.dof(i)).collect();
        let sensor =
            |dof: &String| format!("[[sensor]]\ndof = \"{dof}\"\ncoordinate = \"{dof}\"\n");
        let sensors: String = dofs.iter().step_by(7).map(sensor).collect();
        write(
            folder.path(),
            &[
                ("columns.mtx", &market(&self.columns)),
                ("beams.mtx", &market(&self.beams)),
                ("permanent.mtx", &market(&self.permanent)),
                ("live.mtx", &market(&self.live)),
                ("dofs.txt", &dofs.join("\n")),
                ("model.toml", &(MODEL.to_owned() + &sensors)),
                ("scene.toml", SCENE),
            ],
        );
        folder
    }
}

/// Adds a member along an axis between two nodes: axial force, torsion, and bending in two planes.
fn member(matrix: &mut Entries, [first, second]: [usize; 2], axis: usize, section: Section) {
    let h = LENGTH_M;
    let [axial, torsion, bending @ ..] = section;
    for (offset, k) in [(axis, axial / h), (3 + axis, torsion / h)] {
        let at = [6 * first + offset, 6 * second + offset];
        add(matrix, &at, &[[k, -k], [-k, k]]);
    }
    for (turn, ei) in bending.into_iter().enumerate() {
        let (across, about) = ((axis + 1 + turn) % 3, (axis + 2 - turn) % 3);
        let r = if turn == 0 { h } else { -h };
        let at = [
            6 * first + across,
            6 * first + 3 + about,
            6 * second + across,
            6 * second + 3 + about,
        ];
        let k = ei / (h * h * h);
        let element = [
            [12.0, 6.0 * r, -12.0, 6.0 * r],
            [6.0 * r, 4.0 * h * h, -6.0 * r, 2.0 * h * h],
            [-12.0, -6.0 * r, 12.0, -6.0 * r],
            [6.0 * r, 2.0 * h * h, -6.0 * r, 4.0 * h * h],
        ];
        add(matrix, &at, &element.map(|row| row.map(|entry| k * entry)));
    }
}

fn add<const N: usize>(matrix: &mut Entries, at: &[usize; N], element: &[[f64; N]; N]) {
    for (row, i) in element.iter().zip(at) {
        for (value, j) in row.iter().zip(at) {
            *matrix.entry((*i, *j)).or_default() += value;
        }
    }
}

const MODEL: &str = r#"
    schema = "modalign-model/1"
    title = "lumped-mass frame"
    [matrices]
    dofs = "dofs.txt"
    mass = "permanent.mtx"
    [[matrices.group]]
    parameter = "columns"
    stiffness = "columns.mtx"
    [[matrices.group]]
    parameter = "beams"
    stiffness = "beams.mtx"
    [[matrices.group]]
    parameter = "live"
    mass = "live.mtx"
    [[parameter]]
    name = "columns"
    unit = "-"
    nominal = 1.0
    lower = 0.2
    upper = 5.0
    status = "assumed"
    [[parameter]]
    name = "beams"
    unit = "-"
    nominal = 1.0
    lower = 0.2
    upper = 5.0
    status = "assumed"
    [[parameter]]
    name = "live"
    unit = "-"
    nominal = 1.0
    lower = 0.2
    upper = 5.0
    status = "assumed"
"#;

const SCENE: &str = r#"
    schema = "modalign-scene/1"
    title = "lumped-mass frame"
    [model]
    file = "model.toml"
    [[test]]
    name = "measured"
    modes = "modes.json"
    [pair]
    rotation_length_m = 4.0
    [update]
    parameters = ["columns", "beams", "live"]
    shapes = false
    frequency_floor = 1e-6
    prior_std = 0.03
    starts = 1
"#;

/// What numpy gives for a frame.
#[derive(Default)]
struct Reference {
    hz: Vec<f64>,
    /// `p/f df/dp` of columns, beams and live mass.
    relative: Vec<[f64; 3]>,
    updated: Vec<f64>,
}

impl Reference {
    fn of(name: &str) -> Self {
        let mut values = Self::default();
        for line in include_str!("../reference/massless_frame.txt").lines() {
            let Some(rest) = line.strip_prefix(name) else {
                continue;
            };
            let words: Vec<&str> = rest.split_whitespace().collect();
            let numbers: Vec<f64> = words[1..]
                .iter()
                .map(|word| word.parse().unwrap())
                .collect();
            match words[0] {
                "mode" => {
                    values.hz.push(numbers[0]);
                    values.relative.push([numbers[1], numbers[2], numbers[3]]);
                }
                "updated" => values.updated = numbers,
                _ => {}
            }
        }
        assert_eq!(values.hz.len(), 30, "{name}");
        values
    }
}

fn near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < EQUAL
}

fn theory(folder: &Path, arguments: &[&str]) -> Value {
    let model = folder.join("model.toml");
    let first = ["theory".as_ref(), model.as_os_str(), "--json".as_ref()];
    let all = first.into_iter().chain(arguments.iter().map(OsStr::new));
    serde_json::from_str(&succeed(all)).unwrap()
}

/// Frequencies and sensitivities of `theory` are those of numpy, and it says how many coordinates
/// were condensed.
fn check_theory(folder: &Path, reference: &Reference, massless: f64) {
    let end = format!("0:{}", 0.5 * (reference.hz[28] + reference.hz[29]));
    let found = theory(folder, &["--band", &end, "--sensitivities"]);
    let modes = found["modes"].as_array().unwrap();
    let sensitivities = found["theory"]["sensitivities"].as_array().unwrap();
    assert_eq!((modes.len(), sensitivities.len()), (29, 29));
    for (j, (mode, sensitivity)) in modes.iter().zip(sensitivities).enumerate() {
        let hz = mode["frequency_hz"].as_f64().unwrap();
        assert!(near(hz, reference.hz[j]), "{j}: {hz} {}", reference.hz[j]);
        for (name, expected) in ["columns", "beams", "live"]
            .iter()
            .zip(reference.relative[j])
        {
            let found_relative = sensitivity["by"][name]["relative"].as_f64().unwrap();
            assert!(
                (found_relative - expected).abs() < EQUAL * 0.5,
                "{j} {name}: {found_relative} {expected}"
            );
        }
    }
    let findings = found["findings"].as_array().unwrap();
    let said = findings
        .iter()
        .find(|finding| finding["code"] == "massless-condensed");
    assert_eq!(
        said.unwrap()["value"].as_f64(),
        Some(massless),
        "{findings:?}"
    );
}

/// Writes the lowest 12 modes of the frame with other parameters as those of a test.
fn measure(folder: &Path, end_hz: &str) {
    let [model, modes] = ["model.toml", "modes.json"].map(|name| folder.join(name));
    let verb: Vec<&OsStr> = vec![
        "theory".as_ref(),
        model.as_os_str(),
        "--set".as_ref(),
        "columns=1.1".as_ref(),
        "--set".as_ref(),
        "beams=0.93".as_ref(),
        "--set".as_ref(),
        "live=1.2".as_ref(),
        "--band".as_ref(),
        end_hz.as_ref(),
        "-o".as_ref(),
        modes.as_os_str(),
    ];
    succeed(verb);
    assert_eq!(json(&modes)["modes"].as_array().unwrap().len(), 12);
}

/// `run` and `update` give the frequencies and parameters of numpy, and say what was condensed.
fn check_run_and_update(folder: &Path, reference: &Reference) {
    let out = folder.join("out");
    succeed([
        "run".as_ref(),
        folder.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ]);
    let rows = json(&out.join("comparison.json"))["rows"].clone();
    let with_theory = rows.as_array().unwrap().iter();
    let with_theory: Vec<f64> = with_theory
        .filter_map(|row| row["theory"]["hz"].as_f64())
        .collect();
    assert!(with_theory.len() >= 12);
    for (found, expected) in with_theory.iter().zip(&reference.hz) {
        assert!(near(*found, *expected), "{found} {expected}");
    }
    let update = ["update".as_ref(), folder.as_os_str(), "--json".as_ref()];
    let updated: Value = serde_json::from_str(&succeed(update)).unwrap();
    let parameters = updated["parameters"].as_array().unwrap();
    for (parameter, expected) in parameters.iter().zip(&reference.updated) {
        let found = parameter["updated"].as_f64().unwrap();
        assert!(near(found, *expected), "{parameter} {expected}");
    }
}

#[test]
fn a_frame_of_946_coordinates_of_which_474_are_massless_is_the_condensed_problem_in_numpy() {
    let frame = Frame::new(8);
    assert_eq!(frame.free().len(), 946);
    let reference = Reference::of("dense");
    let folder = frame.write();
    check_theory(folder.path(), &reference, 474.0);
    measure(folder.path(), "0:8.87");
    check_run_and_update(folder.path(), &reference);
}

#[test]
fn a_small_frame_with_massless_rotations_is_the_condensed_problem_in_numpy() {
    let folder = Frame::new(4).write();
    let reference = Reference::of("small");
    check_theory(folder.path(), &reference, 234.0);
    measure(folder.path(), "0:13.4");
    check_run_and_update(folder.path(), &reference);
}

#[test]
fn a_frame_that_is_solved_sparse_is_the_condensed_problem_in_numpy() {
    let frame = Frame::new(11);
    assert_eq!(frame.free().len(), 1306);
    let folder = frame.write();
    let reference = Reference::of("sparse");
    check_theory(folder.path(), &reference, 654.0);
}

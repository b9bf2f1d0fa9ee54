//! From a hammer test that misses modes to one that sees all that any disc point of the cycloid
//! ball transmission shows.

use std::fmt::Write;
use std::path::Path;

use modalign::correlate::Placement;
use modalign::dof::Dof;
use modalign::scene::{Scene, SceneResult, run};

use crate::command::{fail, write};

/// Degree of freedom, body, place and direction of points on the discs, and of one ball.
const POINTS: [(&str, &str, [f64; 3]); 12] = [
    ("input.1:+X", "input", [0.0, 0.0, 0.0]),
    ("input.1:+Y", "input", [0.0, 0.0, 0.0]),
    ("input.2:+Y", "input", [0.002, 0.0, 0.0]),
    ("centre.1:+X", "centre-disc", [0.0, 0.0, 0.0]),
    ("centre.1:+Y", "centre-disc", [0.0, 0.0, 0.0]),
    ("centre.2:+Y", "centre-disc", [0.01, 0.0, 0.0]),
    ("planet.1:+X", "planet-disc", [0.0, 0.0024, 0.0]),
    ("planet.1:+Y", "planet-disc", [0.0, 0.0024, 0.0]),
    ("planet.2:+Y", "planet-disc", [0.012, 0.0024, 0.0]),
    ("output.1:+X", "output", [0.0, 0.0, 0.0]),
    ("output.1:+Y", "output", [0.0, 0.0, 0.0]),
    ("output.2:+Y", "output", [0.012, 0.0, 0.0]),
];

fn sensors() -> String {
    let mut text = String::new();
    for (dof, body, at) in POINTS {
        writeln!(
            text,
            "[[sensor]]\ndof = {dof:?}\nbody = {body:?}\nat_m = {at:?}"
        )
        .unwrap();
    }
    text
}

/// A test of the machine with six stiffnesses that the model has wrong, hit at some points, and
/// what to add.
fn tested(folder: &Path, hits: &[String], responses: &[String]) -> SceneResult {
    let spec = format!(
        r#"
schema = "modalign-synth/1"
title = "Hits on the discs (synthetic)"
seed = 11
averages = 3
[truth]
name = "cycloid-ball"
parameters = {{ k_01x = 5.5e7, k_03y = 7.4e7, k_1x = 6.5e7, k_5y = 5.6e7, k_a = 7.7e6, k_da = 8.2e6 }}
damping_ratio = 0.002
[record]
sampling_rate_hz = 65536.0
samples = 65536
pretrigger_s = 0.002
response = "acceleration"
[pulse]
duration_s = 2.5e-5
duration_spread = 0.03
peak_n = 50.0
peak_spread = 0.2
[noise]
force_snr_db = 80.0
response_snr_db = 60.0
[[hit]]
dofs = {hits:?}
responses = {responses:?}
{}"#,
        sensors()
    );
    let scene = format!(
        r#"
schema = "modalign-scene/1"
title = "Points for the discs"
[model]
name = "cycloid-ball"
[[test]]
name = "discs"
synth = "discs.toml"
band_hz = [500.0, 13000.0]
[[placement]]
test = "discs"
sensors = ["centre.2:+Y", "planet.*"]
{}"#,
        sensors()
    );
    write(folder, &[("discs.toml", &spec), ("scene.toml", &scene)]);
    run(&Scene::load(&folder.join("scene.toml")).unwrap()).unwrap()
}

fn placement(result: &SceneResult) -> &Placement {
    result.placements[0].placement.as_ref().unwrap()
}

/// Modes of the model in the test's band that found a partner.
fn paired(result: &SceneResult) -> usize {
    let summary = &result.table.as_ref().unwrap().summary[0];
    summary.paired + summary.ambiguous
}

#[test]
fn the_points_that_are_proposed_show_every_mode_that_disc_points_can_show() {
    let folder = tempfile::tempdir().unwrap();
    let one = vec!["output.2:+Y".to_owned()];
    let first = tested(folder.path(), &one, &one);
    let plan = placement(&first);
    let count = |modes: fn(&modalign::correlate::PlannedRoot) -> usize| -> usize {
        plan.roots.iter().map(modes).sum()
    };
    let (seen, planned) = (count(|root| root.seen), count(|root| root.planned));
    // Balls alone move in f6 and f12: no point on a disc sees them.
    let never: Vec<(usize, [bool; 2])> = plan
        .roots
        .iter()
        .filter(|root| root.planned == 0)
        .map(|root| (root.modes.len(), root.at_nodes))
        .collect();
    assert_eq!(never, [(4, [true, true]), (8, [true, true])]);
    assert_eq!(count(|root| root.modes.len()), planned + 12);
    assert!(
        !plan.steps.is_empty() && plan.steps.len() <= 3,
        "{:?}",
        plan.steps
    );
    assert!(seen < planned, "{seen} {planned}");
    // Modes of the balls alone move no disc and are not compared.
    let set = first.placements[0].sensor_set.as_ref().unwrap();
    assert_eq!(set.at_nodes.len(), 12);
    assert!(
        set.sensors.len() < set.candidates || !set.is_met(),
        "{set:?}"
    );
    assert_eq!(set.auto_mac.len(), set.modes.len());
    // The first test finds its observable modes and no others.
    assert!(paired(&first) <= seen, "{} {seen}", paired(&first));

    let (mut hits, mut responses) = (one.clone(), one);
    for step in &plan.steps {
        let text = |dof: &Option<Dof>| dof.as_ref().map(Dof::to_string);
        hits.extend(text(&step.hit));
        responses.extend(text(&step.sensor));
    }
    let second = tested(folder.path(), &hits, &responses);
    assert_eq!(paired(&second), planned);
    assert!(placement(&second).steps.is_empty());
    assert_eq!(second.table.unwrap().summary[0].extra, 0);
}

#[test]
fn unknown_tests_and_points_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |placement: &str| {
        let text = format!(
            "schema = \"modalign-scene/1\"\ntitle = \"t\"\n[model]\nname = \"cycloid-ball\"\n[[placement]]\n{placement}\n{}",
            sensors()
        );
        write(folder.path(), &[("scene.toml", &text)]);
        fail(["run", folder.path().to_str().unwrap()])
    };
    let error = scene("test = \"a\"");
    assert!(
        error.contains("[[placement]] test") && error.contains("\"a\""),
        "{error}"
    );
    let test = "[[test]]\nname = \"a\"\nfrfs = [\"a.uff\"]\n";
    let error = scene(&format!("test = \"a\"\nmax_auto_mac = 1.5\n{test}"));
    assert!(
        error.contains("max_auto_mac") && error.contains("1.5"),
        "{error}"
    );
}

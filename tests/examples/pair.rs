//! Modes of a test are paired with the modes of a model by MAC and frequency. The MAC of all modes
//! and the comparison table, with the frequency error of each pair, are printed.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use modalign::ModalModel;
use modalign::axis::Band;
use modalign::frf::evaluate_hammer_test;
use modalign::identify::{IdentifyOptions, identify};
use modalign::report::{Renderer, Terminal, comparison_of_all_tests};
use modalign::scene::{NamedTest, Scene, compare_tests, load_model, test_data};
use modalign::theory::ModeOptions;

/// The modes of the only test of a scene; `scene::load_modes` reads modes from a file.
fn test_modes(scene: &Scene) -> Result<ModalModel, Box<dyn Error>> {
    let [test] = scene.tests.as_slice() else {
        return Err("expected a scene with one test".into());
    };
    let recording = test_data(scene, test)?.ingested.recording;
    let mut recording = recording.ok_or("expected recorded hits")?;
    let hammer = test.hammer_options(&scene.hammer);
    let frfs = evaluate_hammer_test(recording.as_mut(), &hammer)?
        .estimated
        .set;
    let options = IdentifyOptions {
        band: test.band,
        ..IdentifyOptions::default()
    };
    Ok(identify(&frfs, &options)?)
}

/// Prints the MAC and the comparison table.
pub fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new("measurements/free-free-beam");
    let scene = Scene::load(folder)?;
    let test = test_modes(&scene)?;

    let model = load_model(&folder.join("model.toml"), &BTreeMap::new())?;
    let options = ModeOptions {
        band: Some(Band::new(0.0, 3500.0)?),
        ..ModeOptions::default()
    };
    let theory = model.solve(&scene.sensors, &options)?;

    let named = NamedTest {
        name: "hammer",
        modes: &test,
        frfs: &[],
    };
    let comparison = compare_tests(&theory.modes, &[named], &scene.pair)?;

    println!("MAC, test modes by rows, model modes by columns:");
    for row in comparison.pairings.iter().flat_map(|pairing| &pairing.mac) {
        let text = |mac: &Option<f64>| mac.map_or("    -".to_owned(), |mac| format!("{mac:.3}"));
        let cells: Vec<String> = row.iter().map(text).collect();
        println!("{}", cells.join("  "));
    }
    let blocks = comparison_of_all_tests(&comparison.table, &theory);
    println!("\n{}", Terminal { width: None }.render(&blocks));
    for finding in comparison
        .findings
        .iter()
        .flat_map(|(_, findings)| findings)
    {
        println!("{}: {finding}", finding.severity);
    }
    Ok(())
}

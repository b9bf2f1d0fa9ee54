//! Two parameters of a model are updated to the modes of a test, and each gets a standard deviation
//! and a verdict on whether the data determine it. The bar of the synthetic test has a Young's
//! modulus of 204 GPa and carries 12 g; the model starts at 210 GPa without the sensor.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use modalign::scene::{Scene, load_model, run};
use modalign::update::{
    MeasuredModes, ParameterChoice, UpdateOptions, UpdateProblem, UpdateResult, update,
};

/// The fit of the model before and after, and its parameters.
pub fn updated() -> Result<UpdateResult, Box<dyn Error>> {
    let folder = Path::new("measurements/free-free-beam");
    let scene = Scene::load(folder)?;
    let tests = run(&scene)?.tests;
    let measured: Vec<MeasuredModes> = tests
        .iter()
        .map(|test| MeasuredModes::new(&test.name, &test.modes))
        .collect();
    let model = load_model(&folder.join("model.toml"), &BTreeMap::new())?;
    let choices = ["youngs_modulus", "sensor_mass"].map(|name| ParameterChoice {
        name: name.to_owned(),
        ..ParameterChoice::default()
    });
    let options = UpdateOptions {
        frequency_floor: 0.0005,
        pair: scene.pair.clone(),
        ..UpdateOptions::default()
    };
    let problem = UpdateProblem::new(
        model.model.as_ref(),
        &model.values,
        &choices,
        &measured,
        &scene.sensors,
        options,
    )?;
    Ok(update(&problem)?)
}

/// Prints the frequency errors before and after, and the parameters.
pub fn main() -> Result<(), Box<dyn Error>> {
    let result = updated()?;
    for (name, fit) in [("before", &result.before), ("after", &result.after)] {
        let rms = fit.rms_percent.ok_or("expected a paired mode")?;
        println!(
            "{name}: rms frequency error {rms:.3} % of {} modes",
            fit.paired()
        );
    }
    for parameter in &result.parameters {
        let (name, unit, verdict) = (&parameter.name, &parameter.unit, parameter.verdict.name());
        let (initial, value, std) = (parameter.initial, parameter.updated, parameter.std);
        println!("{name}: {initial:.4e} to {value:.4e} {unit}, std {std:.1e} {unit}, {verdict}");
    }
    println!("{}.", result.stop_reason.sentence());
    for finding in result.findings() {
        println!("{}: {finding}", finding.severity);
    }
    Ok(())
}

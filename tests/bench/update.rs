//! Updating: time to converge, and analytic sensitivities beside differences. Prints times and
//! ratios; asserts no timing.
//!
//! `cargo bench --bench update`. The tests are modes of the models with other parameter values,
//! without noise.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use modalign::geometry::Sensor;
use modalign::modal::{ModalModel, Mode, Scaling};
use modalign::theory::{
    LumpedFile, LumpedModel, ModeOptions, TheoreticalModel, built_in, coordinate_sensors, modes,
    nominal_values,
};
use modalign::update::{MeasuredModes, ParameterChoice, UpdateOptions, UpdateProblem, solve};

type Failure = Box<dyn std::error::Error>;

/// Each measurement is repeated, and the fastest counts.
const REPEATS: usize = 3;

fn main() -> Result<(), Failure> {
    let cycloid = [
        "m_0", "m_1", "m_3", "m_5", "k_01x", "k_01y", "k_03x", "k_03y", "k_1x", "k_5y",
    ];
    let spider = built_in("spider-reducer")?;
    let first: Vec<String> = spider
        .parameters()
        .iter()
        .filter(|spec| spec.nominal > 0.0 && spec.unit == "N/m")
        .map(|spec| spec.name.clone())
        .take(10)
        .collect();
    let first: Vec<&str> = first.iter().map(String::as_str).collect();
    converge("cycloid-ball", built_in("cycloid-ball")?.as_ref(), &cycloid)?;
    converge("spider-reducer", spider.as_ref(), &first)?;
    let names: Vec<String> = (1..=10).map(|n| format!("k{n}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let count = 1000;
    sensitivities(&chain(count)?, count, &names)
}

/// The modes of a model with these parameters 10 % higher and lower in turn, as a test.
fn changed(
    model: &dyn TheoreticalModel,
    names: &[&str],
    sensors: &[Sensor],
    count: usize,
) -> Result<ModalModel, Failure> {
    let mut values = nominal_values(model.parameters());
    for (i, name) in names.iter().enumerate() {
        let place = model
            .parameters()
            .iter()
            .position(|spec| spec.name == *name);
        values[place.ok_or("a parameter of the model")?] *= if i % 2 == 0 { 1.1 } else { 0.9 };
    }
    let true_model = modes(model, &values, sensors, &ModeOptions::default())?.model;
    let measured = |mode: &Mode| {
        let shape = mode.shape.clone();
        Mode::new(mode.frequency_hz, None, shape, Scaling::Unknown)
    };
    let elastic = true_model
        .modes
        .iter()
        .filter(|mode| mode.frequency_hz > 0.0);
    Ok(ModalModel {
        modes: elastic.take(count).map(measured).collect(),
        ..ModalModel::default()
    })
}

fn choices(names: &[&str]) -> Vec<ParameterChoice> {
    let choice = |name: &&str| ParameterChoice {
        name: (*name).to_owned(),
        ..ParameterChoice::default()
    };
    names.iter().map(choice).collect()
}

fn options() -> UpdateOptions {
    let mut options = UpdateOptions::default();
    options.pair.rotation_length_m = Some(0.05);
    options
}

/// From the nominal values to the optimum, on the calling thread.
fn converge(name: &str, model: &dyn TheoreticalModel, names: &[&str]) -> Result<(), Failure> {
    let values = nominal_values(model.parameters());
    let matrices = model.assemble(&values)?;
    let sensors = coordinate_sensors(&matrices.coordinates);
    let test = changed(model, names, &sensors, usize::MAX)?;
    let measured = [MeasuredModes::new(name, &test)];
    let problem = UpdateProblem::new(
        model,
        &values,
        &choices(names),
        &measured,
        &sensors,
        options(),
    )?;
    let mut fastest = Duration::MAX;
    let mut steps = 0;
    for _ in 0..REPEATS {
        let start = Instant::now();
        let found = solve(&problem, &vec![0.0; names.len()])?;
        fastest = fastest.min(start.elapsed());
        steps = found.history.len();
    }
    println!(
        "{name}: {} coordinates, {} parameters, {} modes: {:.1} ms in {steps} iterations",
        matrices.coordinates.len(),
        names.len(),
        problem.targets.len(),
        1e3 * fastest.as_secs_f64()
    );
    Ok(())
}

/// Derivatives of the residuals of 10 modes by 10 parameters, in closed form and by one further
/// solution for each.
fn sensitivities(model: &LumpedModel, count: usize, names: &[&str]) -> Result<(), Failure> {
    let values = nominal_values(model.parameters());
    let test = changed(model, names, &[], 10)?;
    let measured = [MeasuredModes::new("chain", &test)];
    let problem = UpdateProblem::new(model, &values, &choices(names), &measured, &[], options())?;
    let at = problem.start(&vec![0.0; names.len()])?;
    let start = Instant::now();
    let jacobian = problem.jacobian(&at)?;
    let analytic = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let h = 1e-4;
    let mut worst = 0.0f64;
    for j in 0..names.len() {
        let mut z = at.z.clone();
        z[j] += h;
        let moved = problem.follow(&z, &at)?.ok_or("a model nearby")?;
        for row in 0..at.data_rows {
            let slope = (moved.residual[row] - at.residual[row]) / h;
            worst = worst.max((slope - jacobian[(row, j)]).abs());
        }
    }
    let differences = start.elapsed().as_secs_f64();
    println!(
        "chain of {count}: derivatives of 10 modes by 10 parameters {analytic:.3} s, by differences {differences:.2} s: {:.0} times; largest distance {worst:.1e}",
        differences / analytic
    );
    Ok(())
}

/// Bodies of 1 kg on springs in a row, the first on the ground; each of 10 parameters is the
/// stiffness of a tenth of them.
fn chain(count: usize) -> Result<LumpedModel, Failure> {
    let mut text = "schema = \"modalign-model/1\"\n".to_owned();
    for n in 1..=10 {
        writeln!(
            text,
            "[[parameter]]\nname = \"k{n}\"\nunit = \"N/m\"\nnominal = 1.0e6\nlower = 0.0\nstatus = \"assumed\""
        )?;
    }
    for i in 1..=count {
        let to = match i {
            1 => "ground".to_owned(),
            _ => format!("p{}", i - 1),
        };
        writeln!(
            text,
            "[[body]]\nname = \"b{i}\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = 1.0\nfree = [\"x\"]\n\
             [[point]]\nname = \"p{i}\"\nbody = \"b{i}\"\nat_m = [0.0, 0.0, 0.0]\n\
             [[spring]]\nname = \"s{i}\"\nfrom = \"p{i}\"\nto = \"{to}\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"k{}\"",
            1 + (i - 1) * 10 / count
        )?;
    }
    Ok(LumpedModel::new(toml::from_str::<LumpedFile>(&text)?)?)
}

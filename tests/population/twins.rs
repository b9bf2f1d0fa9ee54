//! Synthetic twins of a machine: parameters drawn from the stated prior, modes of that machine with
//! Gaussian errors of stated deviation, and the model updated from its nominal values. Nothing here
//! was measured.

use modalign::geometry::Sensor;
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::theory::{
    LumpedFile, LumpedModel, ModeOptions, TheoreticalModel, coordinate_sensors, modes,
    nominal_values,
};
use modalign::update::{
    MeasuredModes, ParameterChoice, UpdateOptions, UpdateProblem, UpdateResult, update,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Prior deviation of every stiffness: two of them are 40 %.
pub const PRIOR: f64 = 0.2;
/// Deviation of a measured frequency, a fraction: about that of a mode of 1 % damping over noise of
/// 40 dB.
const FREQUENCY_STD: f64 = 2e-4;
/// Deviation of a shape component, as a part of the root mean square of the shape.
const SHAPE_STD: f64 = 0.02;

/// A machine and the stiffnesses that its twins differ in.
pub struct Machine {
    pub model: Box<dyn TheoreticalModel>,
    pub parameters: Vec<&'static str>,
    /// A stiffness that no sensor sees, which must be reported.
    pub unseen: Option<&'static str>,
    sensors: Vec<Sensor>,
}

impl Machine {
    /// With a sensor on every coordinate but those of a body named `spare`.
    pub fn new(
        model: Box<dyn TheoreticalModel>,
        parameters: Vec<&'static str>,
        unseen: Option<&'static str>,
    ) -> Self {
        let matrices = model.assemble(&nominal_values(model.parameters())).unwrap();
        let mut sensors = coordinate_sensors(&matrices.coordinates);
        sensors.retain(|sensor| sensor.dof.point() != "spare");
        Self {
            model,
            parameters,
            unseen,
            sensors,
        }
    }
}

/// Four bodies on springs in a row and a fifth one on a separate spring, which carries no sensor.
pub fn lumped() -> Machine {
    let mut text = "schema = \"modalign-model/1\"\n".to_owned();
    let bodies = [
        ("b1", "k1", 2.0, 4.0e5, "ground"),
        ("b2", "k2", 1.5, 3.0e5, "p-b1"),
        ("b3", "k3", 1.0, 5.0e5, "p-b2"),
        ("b4", "k4", 0.7, 2.0e5, "p-b3"),
        ("spare", "k5", 1.0, 9.0e5, "ground"),
    ];
    for (body, k, mass, stiffness, to) in bodies {
        text += &format!(
            "[[parameter]]\nname = \"{k}\"\nunit = \"N/m\"\nnominal = {stiffness:?}\nlower = 0.0\nstatus = \"assumed\"\n\
             [[body]]\nname = \"{body}\"\nat_m = [0.0, 0.0, 0.0]\nmass_kg = {mass:?}\nfree = [\"x\"]\n\
             [[point]]\nname = \"p-{body}\"\nbody = \"{body}\"\nat_m = [0.0, 0.0, 0.0]\n\
             [[spring]]\nname = \"{k}\"\nfrom = \"p-{body}\"\nto = \"{to}\"\ndirection = [1.0, 0.0, 0.0]\nparameter = \"{k}\"\n"
        );
    }
    let file = toml::from_str::<LumpedFile>(&text).unwrap();
    let model = Box::new(LumpedModel::new(file).unwrap());
    Machine::new(model, vec!["k1", "k2", "k3", "k4", "k5"], Some("k5"))
}

/// The torsional planetary gear, whose planet modes are one root.
pub fn torsional() -> Machine {
    let model = modalign::theory::built_in("torsional-planetary").unwrap();
    Machine::new(model, vec!["k_r", "k_s", "k_cu"], None)
}

/// The parameters of a twin and the result of its update.
pub struct Twin {
    pub truth: Vec<f64>,
    pub result: UpdateResult,
    /// Largest frequency error of the updated model against the exact frequencies of the twin,
    /// percent.
    pub largest_error_percent: f64,
}

/// Draws the twin of a number and updates the model to it.
pub fn twin(machine: &Machine, number: u64) -> Twin {
    let mut random = ChaCha8Rng::seed_from_u64(number);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let model = machine.model.as_ref();
    let nominal = nominal_values(model.parameters());
    let place = |name: &str| {
        let mut all = model.parameters().iter();
        all.position(|spec| spec.name == name).unwrap()
    };
    let mut values = nominal.clone();
    for name in &machine.parameters {
        values[place(name)] *= (PRIOR * normal()).exp();
    }
    let all = ModeOptions::default();
    let true_model = modes(model, &values, &machine.sensors, &all).unwrap().model;
    let test = noisy(&true_model, &mut normal);
    let measured = [MeasuredModes::new("twin", &test)];
    let choice = |name: &&str| ParameterChoice {
        name: (*name).to_owned(),
        ..ParameterChoice::default()
    };
    let choices: Vec<ParameterChoice> = machine.parameters.iter().map(choice).collect();
    let mut options = UpdateOptions {
        frequency_floor: 0.0,
        // The deviations of the shapes are those of the test; the model has no error.
        shape_floor: Some(1e-6),
        prior_std: PRIOR,
        ..UpdateOptions::default()
    };
    options.pair.max_frequency_error = 0.6;
    let sensors = &machine.sensors;
    let problem = UpdateProblem::new(model, &nominal, &choices, &measured, sensors, options);
    let result = update(&problem.unwrap()).unwrap();
    let updated = modes(model, &result.values, &machine.sensors, &all)
        .unwrap()
        .model;
    let seen = |mode: &&Mode| mode.frequency_hz > 0.0 && is_seen(mode);
    let pairs = true_model
        .modes
        .iter()
        .filter(seen)
        .zip(updated.modes.iter().filter(seen));
    let errors = pairs.map(|(a, b)| 100.0 * (b.frequency_hz / a.frequency_hz - 1.0).abs());
    Twin {
        largest_error_percent: errors.fold(0.0, f64::max),
        truth: machine
            .parameters
            .iter()
            .map(|name| values[place(name)])
            .collect(),
        result,
    }
}

/// Whether any sensor reads a mode.
fn is_seen(mode: &Mode) -> bool {
    mode.shape
        .largest()
        .is_some_and(|(_, value)| value.norm() > 1e-6)
}

/// The modes that the sensors see, with errors of the stated deviations; modes of one root have one
/// error of frequency.
fn noisy(model: &ModalModel, normal: &mut impl FnMut() -> f64) -> ModalModel {
    let mut test = ModalModel::default();
    for root in model.roots() {
        let error = 1.0 + FREQUENCY_STD * normal();
        for &j in &root {
            let mode = &model.modes[j];
            if mode.frequency_hz == 0.0 || !is_seen(mode) {
                continue;
            }
            let squares: f64 = mode.shape.iter().map(|(_, value)| value.norm_sqr()).sum();
            let std = SHAPE_STD * (squares / mode.shape.len() as f64).sqrt();
            let values = mode.shape.iter();
            let shape = ModeShape::new(values.map(|(dof, v)| (dof.clone(), v + std * normal())));
            let stds = mode.shape.iter().map(|(dof, _)| (dof.clone(), std));
            test.modes.push(Mode {
                frequency_std_hz: Some(FREQUENCY_STD * mode.frequency_hz),
                group: mode.group,
                shape_std: Some(stds.collect()),
                ..Mode::new(mode.frequency_hz * error, None, shape, Scaling::Unknown)
            });
        }
    }
    test
}

/// Results of many twins.
#[derive(Default, Debug)]
pub struct Tally {
    pub inside: usize,
    pub intervals: usize,
    pub largest_error_percent: f64,
    pub unseen_named: usize,
    pub twins: usize,
}

impl Tally {
    pub fn add(&mut self, machine: &Machine, twin: &Twin) {
        self.twins += 1;
        for (parameter, truth) in twin.result.parameters.iter().zip(&twin.truth) {
            let (lower, upper) = parameter.interval_95;
            self.intervals += 1;
            self.inside += usize::from(lower <= *truth && *truth <= upper);
            let unseen = machine.unseen == Some(parameter.name.as_str());
            let named = parameter.verdict == modalign::update::ParameterVerdict::NotSupported;
            self.unseen_named += usize::from(unseen && named && parameter.held);
        }
        self.largest_error_percent = self.largest_error_percent.max(twin.largest_error_percent);
    }
}

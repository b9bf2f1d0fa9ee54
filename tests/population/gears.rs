//! Synthetic twins of the four transmissions: stiffnesses drawn from the stated prior, FRFs of the
//! twin in white noise at stated sensors, their modes by the identification under test, and the
//! model updated to these. Nothing here was measured.

use modalign::axis::{Band, FrequencyAxis};
use modalign::dof::Dof;
use modalign::frf::{FrfSet, Function, FunctionData};
use modalign::geometry::{Sensor, Target};
use modalign::identify::{IdentifyOptions, identify};
use modalign::modal::{ModalModel, Mode, Pole};
use modalign::quantity::FrfKind;
use modalign::theory::{
    ModeOptions, TheoreticalModel, TheoryModes, built_in, modes, nominal_values, residues,
};
use modalign::update::{
    Fit, FitRow, MeasuredModes, ParameterChoice, UpdateOptions, UpdateProblem, UpdateResult, update,
};
use num_complex::Complex64;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Prior deviation of the logarithm of every stiffness.
pub const PRIOR: f64 = 0.2;
/// Draws of the prior beyond 40 % (of the logarithm) are drawn again.
const MAX_LOG_CHANGE: f64 = 0.4;
/// Signal-to-noise ratio of every function, dB: rms over the band over rms noise of a line.
const SNR_DB: (f64, f64) = (40.0, 60.0);
/// Values below this fraction of the largest, or of 1 for a shape of unit modal mass, are zero by
/// symmetry.
const MIN_RELATIVE_RESPONSE: f64 = 1e-6;
/// Each twin is a stream of this seed.
const SEED: u64 = 90_901;

/// A transmission with its test.
pub struct Gear {
    pub name: &'static str,
    pub model: Box<dyn TheoreticalModel>,
    /// Stiffnesses of which each twin draws some.
    pub stiffnesses: &'static [&'static str],
    /// A stiffness that this test cannot determine; it is free in every twin and must be reported.
    pub unseen: Option<&'static str>,
    pub sensors: Vec<Sensor>,
    pub hits: Vec<Dof>,
    pub band: Band,
    pub lines: usize,
    /// Damping ratios of the twin's modes.
    pub damping: (f64, f64),
}

fn sensors(named: &[(&str, &str)]) -> Vec<Sensor> {
    let sensor = |(dof, coordinate): &(&str, &str)| Sensor {
        dof: dof.parse().unwrap(),
        target: Target::Coordinate((*coordinate).to_owned()),
    };
    named.iter().map(sensor).collect()
}

/// Sensors on coordinates that are named like degrees of freedom.
fn on_coordinates(model: &dyn TheoreticalModel, dofs: &[&str]) -> Vec<Sensor> {
    let matrices = model.assemble(&nominal_values(model.parameters())).unwrap();
    let all = modalign::theory::coordinate_sensors(&matrices.coordinates);
    let sensor = |dof: &&str| {
        let dof: Dof = dof.parse().unwrap();
        all.iter()
            .find(|sensor_of_model| sensor_of_model.dof == dof)
            .unwrap()
            .clone()
    };
    dofs.iter().map(sensor).collect()
}

/// The four transmissions. The band of each begins below its first elastic mode that the sensors
/// see.
pub fn gears() -> Vec<Gear> {
    let dofs = |names: &[&str]| names.iter().map(|name| name.parse().unwrap()).collect();
    let model = |name: &str| built_in(name).unwrap();
    let cycloid = model("cycloid-ball");
    let torsional = model("torsional-planetary");
    let spider = model("spider-reducer");
    vec![
        Gear {
            name: "cycloid-ball",
            // Sensors in y alone: motion in x, and what turns, is no part of these modes.
            sensors: on_coordinates(
                cycloid.as_ref(),
                &["input:+Y", "centre-disc:+Y", "planet-disc:+Y", "output:+Y"],
            ),
            model: cycloid,
            stiffnesses: &["k_01y", "k_03y", "k_1y", "k_5y"],
            unseen: Some("k_1x"),
            hits: dofs(&["input:+Y", "output:+Y"]),
            band: Band::new(1000.0, 9500.0).unwrap(),
            lines: 700,
            damping: (0.005, 0.015),
        },
        Gear {
            name: "torsional-planetary",
            sensors: on_coordinates(
                torsional.as_ref(),
                &[
                    "ring:+S",
                    "sun:+S",
                    "carrier:+S",
                    "planet-1:+S",
                    "planet-2:+S",
                    "planet-3:+S",
                    "planet-4:+S",
                ],
            ),
            model: torsional,
            stiffnesses: &["k_r", "k_s", "k_cu"],
            unseen: None,
            hits: dofs(&["planet-1:+S", "planet-2:+S", "planet-3:+S"]),
            band: Band::new(800.0, 17000.0).unwrap(),
            lines: 1200,
            damping: (0.01, 0.015),
        },
        Gear {
            name: "spider-reducer",
            sensors: on_coordinates(
                spider.as_ref(),
                &[
                    "output:+X",
                    "output:+Y",
                    "input:+X",
                    "input:+Y",
                    "gear-1:+X",
                    "gear-1:+Y",
                    "gear-2:+X",
                    "gear-2:+Y",
                ],
            ),
            model: spider,
            stiffnesses: &["k_o1", "k_o2", "k_i1", "k_i2", "k_a", "k_s1"],
            unseen: None,
            hits: dofs(&["output:+X", "input:+Y"]),
            band: Band::new(40.0, 350.0).unwrap(),
            lines: 700,
            damping: (0.004, 0.01),
        },
        Gear {
            name: "helical-planetary",
            model: model("helical-planetary"),
            sensors: sensors(&[
                ("carrier:+X", "xc"),
                ("carrier:+Y", "yc"),
                ("sun:+X", "xs"),
                ("sun:+Y", "ys"),
                ("carrier:+RZ", "thc"),
                ("sun:+RZ", "ths"),
                ("planet-1:+X", "radial_1"),
                ("planet-1:+Y", "tangential_1"),
            ]),
            stiffnesses: &["k_sp", "k_rp", "k_c", "k_s", "k_p"],
            unseen: Some("mesh_max"),
            hits: dofs(&["carrier:+X", "sun:+Y", "carrier:+RZ"]),
            band: Band::new(400.0, 2800.0).unwrap(),
            lines: 800,
            damping: (0.003, 0.006),
        },
    ]
}

/// A twin: its parameters and the result of its update.
pub struct GearTwin {
    pub parameters: Vec<&'static str>,
    pub truth: Vec<f64>,
    pub snr_db: f64,
    pub test: ModalModel,
    pub result: UpdateResult,
    /// Largest frequency error of the updated model, percent, against the modes of the twin that
    /// the table has.
    pub largest_error_percent: f64,
}

impl Gear {
    fn place(&self, name: &str) -> usize {
        let mut all = self.model.parameters().iter();
        all.position(|spec| spec.name == name).unwrap()
    }

    fn modes(&self, values: &[f64]) -> TheoryModes {
        let all = ModeOptions::default();
        modes(self.model.as_ref(), values, &self.sensors, &all).unwrap()
    }

    /// A damping ratio for each elastic mode, one for all modes of a root: damping does not split
    /// it.
    fn ratios(&self, theory: &TheoryModes, random: &mut ChaCha8Rng) -> Vec<f64> {
        let omega = &theory.omega_rad_s;
        let mut ratios: Vec<f64> = Vec::with_capacity(omega.len());
        for r in theory.rigid..omega.len() {
            let same = r > theory.rigid && omega[r].to_bits() == omega[r - 1].to_bits();
            let drawn = random.random_range(self.damping.0..self.damping.1);
            ratios.push(if same {
                ratios[ratios.len() - 1]
            } else {
                drawn
            });
        }
        ratios
    }

    /// Whether the roots of the band that some function has are at least the sum of their
    /// half-power bandwidths apart. No test separates closer roots.
    fn roots_are_separated(&self, theory: &TheoryModes, ratios: &[f64]) -> bool {
        let mut roots: Vec<(f64, f64)> = Vec::new();
        for (mode, ratio) in theory.model.modes[theory.rigid..].iter().zip(ratios) {
            let value = |dof: &Dof| mode.shape.get(dof).unwrap().norm();
            let hit = self.hits.iter().map(value).fold(0.0, f64::max);
            let read = self
                .sensors
                .iter()
                .map(|sensor| value(&sensor.dof))
                .fold(0.0, f64::max);
            let hz = mode.frequency_hz;
            let new = roots
                .last()
                .is_none_or(|(last, _)| hz > *last * (1.0 + 1e-9));
            if new && self.band.contains(hz) && hit.min(read) > MIN_RELATIVE_RESPONSE {
                roots.push((hz, 2.0 * ratio * hz));
            }
        }
        roots
            .windows(2)
            .all(|pair| pair[1].0 - pair[0].0 >= pair[0].1 + pair[1].1)
    }

    /// The functions without noise.
    fn exact(&self, theory: &TheoryModes, ratios: &[f64]) -> FrfSet {
        let responses = self.sensors.iter().map(|sensor| &sensor.dof);
        let pairs: Vec<(Dof, Dof)> = self
            .hits
            .iter()
            .flat_map(|hit| responses.clone().map(|dof| (dof.clone(), hit.clone())))
            .collect();
        let axis = FrequencyAxis {
            start_hz: self.band.lo_hz,
            step_hz: self.band.width_hz() / (self.lines - 1) as f64,
            len: self.lines,
        };
        let mut set = FrfSet::new(axis);
        for residue in residues(theory, ratios, &pairs).unwrap() {
            let value = |k: usize| {
                let s = Complex64::new(0.0, axis.rad_s(k));
                let part = |(pole, a): &(Pole, Complex64)| {
                    a / (s - pole.lambda) + a.conj() / (s - pole.lambda.conj())
                };
                let sum: Complex64 = residue.elastic.iter().map(part).sum();
                s * s * sum + residue.rigid_body_accelerance_per_kg
            };
            let function = Function {
                response: residue.response.clone(),
                reference: residue.hit.clone(),
                kind: FrfKind::Accelerance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values: (0..axis.len).map(value).collect(),
                ..FunctionData::default()
            };
            set.push(function, data).unwrap();
        }
        set
    }

    /// The functions with white noise; that of a function which vanishes by the symmetry of the
    /// machine is as if it were as large as the others of its response and its hit.
    fn measured(&self, exact: &FrfSet, snr_db: f64, random: &mut ChaCha8Rng) -> FrfSet {
        let axis = *exact.axis();
        let power = |i: usize| {
            let values = exact.values(i).iter();
            values.map(Complex64::norm_sqr).sum::<f64>() / axis.len as f64
        };
        let powers: Vec<f64> = (0..exact.len()).map(power).collect();
        let functions = exact.functions();
        let largest = |of: &dyn Fn(&Function) -> bool| {
            let powers_of_functions = functions.iter().zip(&powers);
            let powers_of_functions = powers_of_functions.filter(|(function, _)| of(function));
            powers_of_functions
                .map(|(_, power)| *power)
                .fold(0.0, f64::max)
        };
        let all = largest(&|_| true);
        let mut set = FrfSet::new(axis);
        for (i, function) in functions.iter().enumerate() {
            let response = largest(&|other| other.response == function.response);
            let hit = largest(&|other| other.reference == function.reference);
            let usual = response * hit / all;
            let vanishes = powers[i] < MIN_RELATIVE_RESPONSE * MIN_RELATIVE_RESPONSE * usual;
            let reference = if vanishes { usual } else { powers[i] };
            let variance = reference * 10f64.powf(-snr_db / 10.0);
            let mut noise = || -> f64 {
                let part: f64 = StandardNormal.sample(random);
                part * (0.5 * variance).sqrt()
            };
            let values = exact.values(i).iter();
            let noisy = values.map(|h| h + Complex64::new(noise(), noise()));
            let data = FunctionData {
                values: noisy.collect(),
                coherence: None,
                variance: Some(vec![variance; axis.len]),
            };
            set.push(function.clone(), data).unwrap();
        }
        set
    }

    /// Some changed stiffnesses, and the free parameters: the changed ones and the one that the
    /// test cannot determine.
    fn draw(&self, nominal: &[f64], random: &mut ChaCha8Rng) -> (Vec<&'static str>, Vec<f64>) {
        let count = random.random_range(1..=self.stiffnesses.len());
        let chosen = self.stiffnesses.choose_multiple(random, count);
        let mut free: Vec<&str> = chosen.copied().collect();
        free.extend(self.unseen);
        let mut values = nominal.to_vec();
        for name in &free {
            let change = loop {
                let drawn: f64 = StandardNormal.sample(random);
                if (PRIOR * drawn).abs() <= MAX_LOG_CHANGE {
                    break PRIOR * drawn;
                }
            };
            values[self.place(name)] *= change.exp();
        }
        (free, values)
    }

    /// The twin of a number, updated from the nominal values.
    pub fn twin(&self, number: u64) -> GearTwin {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(number);
        let nominal = nominal_values(self.model.parameters());
        let (parameters, values, exact) = loop {
            let (parameters, values) = self.draw(&nominal, &mut random);
            let theory = self.modes(&values);
            let ratios = self.ratios(&theory, &mut random);
            if self.roots_are_separated(&theory, &ratios) {
                break (parameters, values, self.exact(&theory, &ratios));
            }
        };
        let snr_db = random.random_range(SNR_DB.0..SNR_DB.1);
        let set = self.measured(&exact, snr_db, &mut random);
        let options = IdentifyOptions {
            band: Some(self.band),
            ..IdentifyOptions::default()
        };
        let test = identify(&set, &options).unwrap();
        let result = self.updated(&nominal, &parameters, &test);
        GearTwin {
            largest_error_percent: self.largest_error_percent(&values, &result.after),
            truth: parameters.iter().map(|n| values[self.place(n)]).collect(),
            parameters,
            snr_db,
            test,
            result,
        }
    }

    fn updated(&self, nominal: &[f64], parameters: &[&str], test: &ModalModel) -> UpdateResult {
        let choice = |name: &&str| ParameterChoice {
            name: (*name).to_owned(),
            ..ParameterChoice::default()
        };
        let choices: Vec<ParameterChoice> = parameters.iter().map(choice).collect();
        let mut options = UpdateOptions {
            // The model is right but for its stiffnesses: the deviations of the test are all there
            // is.
            frequency_floor: 0.0,
            shape_floor: Some(1e-6),
            prior_std: PRIOR,
            ..UpdateOptions::default()
        };
        options.pair.max_frequency_error = 0.4;
        options.pair.rotation_length_m = Some(0.05);
        let measured = [MeasuredModes::new("twin", test)];
        let problem = UpdateProblem::new(
            self.model.as_ref(),
            nominal,
            &choices,
            &measured,
            &self.sensors,
            options,
        );
        update(&problem.unwrap()).unwrap()
    }

    /// Of the rows of the table: the updated model's frequency against that of the twin's mode
    /// nearest to what was measured, of those that the sensors read.
    fn largest_error_percent(&self, truth: &[f64], fit: &Fit) -> f64 {
        let twin = self.modes(truth).model;
        let seen = |mode: &&Mode| {
            let largest = mode.shape.largest();
            mode.frequency_hz > 0.0
                && largest.is_some_and(|(_, value)| value.norm() > MIN_RELATIVE_RESPONSE)
        };
        let all: Vec<f64> = twin
            .modes
            .iter()
            .filter(seen)
            .map(|m| m.frequency_hz)
            .collect();
        let error = |row: &FitRow| {
            let distance = |hz: &f64| (hz - row.test_hz).abs();
            let near = |a: &f64, b: &f64| distance(a).total_cmp(&distance(b));
            let nearest = all.iter().copied().min_by(near)?;
            Some(100.0 * (row.model_hz? / nearest - 1.0).abs())
        };
        fit.rows.iter().filter_map(error).fold(0.0, f64::max)
    }
}

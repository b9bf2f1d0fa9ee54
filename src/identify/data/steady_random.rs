//! FRF sets of a test under steady random force, computed from its time series, for the tests of
//! this stage.
//!
//! The force is white. Each mode responds by the recursion `y_n = e^(λΔt) y_(n−1) + f_n`, which is
//! exact for the sampled force and includes the truncation of records at their ends. Successive
//! records are weighted with a window, transformed and averaged to H1 and its coherence.

use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::axis::{Band, FrequencyAxis};
use crate::fourier::ForwardPlan;
use crate::frf::{FrfSet, Function, FunctionData, Window, variance_from_coherence};
use crate::modal::Pole;
use crate::quantity::FrfKind;

use crate::identify::data::line_shape::cosines;
use crate::identify::synthetic::Structure;

/// Measurement of a structure under steady random force.
#[derive(Clone, Debug)]
pub(in crate::identify) struct SteadyRandomTest {
    pub rate_hz: f64,
    /// Samples of a record.
    pub record: usize,
    pub averages: usize,
    /// Response noise over the root mean square of each response.
    pub noise: f64,
    pub window: Window,
    pub coherence_given: bool,
    pub seed: u64,
}

impl SteadyRandomTest {
    fn weights(&self) -> Vec<f64> {
        let cosines = cosines(self.window).unwrap_or([1.0, 0.0, 0.0, 0.0, 0.0]);
        let turn = |n: usize| std::f64::consts::TAU * n as f64 / self.record as f64;
        let weight = |n: usize| {
            let terms = cosines.iter().enumerate();
            terms.map(|(k, a)| a * (k as f64 * turn(n)).cos()).sum()
        };
        (0..self.record).map(weight).collect()
    }

    /// Accelerances of points 1, 2, ... for a force at point 1, on the lines of a band.
    pub fn measured(&self, structure: &Structure, band: Band) -> FrfSet {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        let decays = structure.modes.iter().map(|mode| pole(mode).re.abs());
        let slowest = decays.fold(f64::MAX, f64::min);
        let before = (12.0 / slowest * self.rate_hz) as usize;
        let samples = before + self.averages * self.record;
        let force: Vec<f64> = (0..samples).map(|_| normal()).collect();
        let accelerations: Vec<Vec<f64>> = (structure.modes.iter())
            .map(|mode| acceleration(pole(mode), self.rate_hz, &force))
            .collect();
        let plan = ForwardPlan::new(self.record);
        let weights = self.weights();
        let spectra = |signal: &[f64]| -> Vec<Vec<Complex64>> {
            let records = signal[before..].chunks_exact(self.record);
            let weighted = |record: &[f64]| -> Vec<f64> {
                record.iter().zip(&weights).map(|(x, w)| x * w).collect()
            };
            records
                .map(|record| plan.transform(&weighted(record)))
                .collect()
        };
        let forces = spectra(&force);
        let step_hz = self.rate_hz / self.record as f64;
        let whole = FrequencyAxis {
            start_hz: 0.0,
            step_hz,
            len: self.record / 2,
        };
        let lines = whole.lines(&band);
        let mut set = FrfSet::new(FrequencyAxis {
            start_hz: whole.hz(lines.start),
            step_hz,
            len: lines.len(),
        });
        for point in 0..structure.modes[0].2.len() {
            let mut response = vec![0.0; samples];
            for (mode, acceleration) in structure.modes.iter().zip(&accelerations) {
                let factor = mode.2[point] * mode.2[0];
                response
                    .iter_mut()
                    .zip(acceleration)
                    .for_each(|(x, q)| *x += factor * q);
            }
            let power = response.iter().map(|x| x * x).sum::<f64>() / samples as f64;
            response
                .iter_mut()
                .for_each(|x| *x += self.noise * power.sqrt() * normal());
            let responses = spectra(&response);
            let (values, coherence) = h1(&forces, &responses, lines.clone());
            let averages = self.averages as u32;
            let variance = variance_from_coherence(&values, &coherence, averages);
            let given = self.coherence_given;
            let function = Function {
                response: format!("{}:+Z", point + 1).parse().unwrap(),
                reference: "1:+Z".parse().unwrap(),
                kind: FrfKind::Accelerance,
                averages: Some(averages),
                estimator: None,
                variance_dof: given.then(|| 2.0 * f64::from(averages - 1)),
            };
            let data = FunctionData {
                values,
                coherence: given.then_some(coherence),
                variance: given.then_some(variance),
            };
            set.push(function, data).unwrap();
        }
        set
    }
}

fn pole(mode: &(f64, f64, Vec<f64>)) -> Complex64 {
    Pole::from_frequency(mode.0, mode.1).lambda
}

/// Acceleration of a mode of unit mass.
fn acceleration(lambda: Complex64, rate_hz: f64, force: &[f64]) -> Vec<f64> {
    let step_s = rate_hz.recip();
    let (turn, factor) = (
        (lambda * step_s).exp(),
        lambda * lambda * step_s / lambda.im,
    );
    let mut state = Complex64::ZERO;
    let mut next = |f: &f64| {
        state = turn * state + f;
        f + (factor * state).im
    };
    force.iter().map(&mut next).collect()
}

/// H1 and coherence on a range of lines.
fn h1(
    forces: &[Vec<Complex64>],
    responses: &[Vec<Complex64>],
    lines: std::ops::Range<usize>,
) -> (Vec<Complex64>, Vec<f64>) {
    let of_line = |k: usize| {
        let (mut cross, mut force, mut response) = (Complex64::ZERO, 0.0, 0.0);
        for (f, x) in forces.iter().zip(responses) {
            cross += f[k].conj() * x[k];
            force += f[k].norm_sqr();
            response += x[k].norm_sqr();
        }
        (cross / force, cross.norm_sqr() / (force * response))
    };
    lines.map(of_line).unzip()
}

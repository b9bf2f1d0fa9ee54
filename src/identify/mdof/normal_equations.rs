//! Transforms of weighted lines: the blocks of the normal equations of the polyreference LSCF
//! ([`plscf`](crate::identify::mdof::plscf)), all of Toeplitz structure, hold nothing else.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::mdof::plscf::{Plane, circle};

/// Error of the model relative to the response, squared: strong resonances far above the noise
/// would leave nothing of weak ones in the normal equations. Once poles are known, weak ones have
/// been found.
const MODEL: f64 = 1e-6;
const MODEL_OF_KNOWN: f64 = 1e-10;
/// Outputs whose sums are formed by one thread.
pub(in crate::identify) const TOGETHER: usize = 8;

/// Transforms over the lines, of which all blocks of the normal equations are made.
pub(in crate::identify) struct Transforms {
    /// Number of inputs.
    pub inputs: usize,
    /// Highest order.
    pub order: usize,
    /// How the circle lies over the lines.
    pub plane: Plane,
    /// By output.
    pub outputs: Vec<Output>,
    /// Of `w² H_p^* H_q`, summed over the outputs, by p, then by q.
    pub products: Vec<Lags>,
}

/// Transforms of one output.
pub(in crate::identify) struct Output {
    /// Of `w²`.
    pub weight: Lags,
    /// Of `w² H` of each input.
    pub functions: Vec<Lags>,
}

/// `Σ_k x_k z_k^lag` for lags of both signs up to an order, the lowest first.
pub(in crate::identify) struct Lags(Vec<Complex64>);

impl Transforms {
    /// Of some lines for equations up to an order; `sides` must be complete. Every line is weighted
    /// by one over what the denominator of known poles, rad/s, makes of its noise.
    pub fn new(
        data: &Receptances,
        sides: &Sides,
        (lines, order, known): (Range<usize>, usize, &[Complex64]),
    ) -> Self {
        let plan = ComplexPlan::inverse(circle(lines.len(), 2 * order + 2));
        let step_s = std::f64::consts::TAU / (plan.len() as f64 * data.step);
        let of_lines = Lines {
            course: course(&data.omega[lines.clone()], step_s, known),
            model: if known.is_empty() {
                MODEL
            } else {
                MODEL_OF_KNOWN
            },
            data,
            lines: lines.clone(),
            plan,
            order,
        };
        let m = sides.inputs;
        let chunks: Vec<(Vec<Output>, Vec<Vec<Complex64>>)> = sides
            .outputs
            .par_chunks(TOGETHER)
            .map(|outputs| of_lines.transformed(outputs))
            .collect();
        let mut sums = vec![vec![Complex64::ZERO; lines.len()]; m * m];
        let mut outputs = Vec::with_capacity(sides.outputs.len());
        for (own, products) in chunks {
            outputs.extend(own);
            for (sum, product) in sums.iter_mut().zip(products) {
                sum.iter_mut().zip(product).for_each(|(s, p)| *s += p);
            }
        }
        let mut scratch = of_lines.plan.scratch();
        Self {
            inputs: m,
            order,
            plane: Plane {
                omega_0: data.omega[lines.start],
                step_s,
            },
            outputs,
            products: sums
                .into_iter()
                .map(|sum| of_lines.lags(sum, &mut scratch))
                .collect(),
        }
    }
}

/// Lines on their way into transforms.
struct Lines<'a> {
    data: &'a Receptances,
    lines: Range<usize>,
    /// Weight that known poles give every line.
    course: Vec<f64>,
    /// Error of the model relative to the response, squared.
    model: f64,
    plan: ComplexPlan,
    order: usize,
}

impl Lines<'_> {
    /// Transforms of some outputs, and the sums of their products, line by line.
    fn transformed(&self, outputs: &[Vec<(usize, usize)>]) -> (Vec<Output>, Vec<Vec<Complex64>>) {
        let m = outputs[0].len();
        let mut sums = vec![vec![Complex64::ZERO; self.lines.len()]; m * m];
        let mut scratch = self.plan.scratch();
        let of_output = |output: &Vec<(usize, usize)>| {
            let weights = self.weights(output);
            let functions: Vec<&[Complex64]> = output
                .iter()
                .map(|(_, f)| &self.data.values[*f][self.lines.clone()])
                .collect();
            for (place, sum) in sums.iter_mut().enumerate() {
                let (p, q) = (functions[place / m], functions[place % m]);
                let pairs = p.iter().zip(q).zip(&weights);
                sum.iter_mut()
                    .zip(pairs)
                    .for_each(|(sum, ((p, q), w))| *sum += w * (p.conj() * q));
            }
            let weighted = |h: &&[Complex64]| {
                let line = h.iter().zip(&weights).map(|(h, w)| w * h).collect();
                self.lags(line, &mut scratch)
            };
            let functions = functions.iter().map(weighted).collect();
            let plain = weights.iter().map(|w| Complex64::from(*w)).collect();
            Output {
                weight: self.lags(plain, &mut scratch),
                functions,
            }
        };
        let outputs = outputs.iter().map(of_output).collect();
        (outputs, sums)
    }

    /// One weight per line and output: the mean precision of its functions, which no resonance
    /// exceeds by more than the error of the model allows.
    fn weights(&self, output: &[(usize, usize)]) -> Vec<f64> {
        let m = output.len() as f64;
        let mut powers = vec![0.0; self.lines.len()];
        for (_, f) in output {
            let values = &self.data.values[*f][self.lines.clone()];
            let own = values.iter().map(Complex64::norm_sqr);
            powers
                .iter_mut()
                .zip(own)
                .for_each(|(sum, p)| *sum += p / m);
        }
        let mut weights = vec![0.0; self.lines.len()];
        for (_, f) in output {
            let variance = &self.data.variance[*f][self.lines.clone()];
            for ((sum, v), power) in weights.iter_mut().zip(variance).zip(&powers) {
                *sum += 1.0 / (v + self.model * power);
            }
        }
        weights
            .iter()
            .zip(&self.course)
            .map(|(sum, course)| course * sum / m)
            .collect()
    }

    fn lags(&self, mut line: Vec<Complex64>, scratch: &mut [Complex64]) -> Lags {
        let circle = self.plan.len();
        line.resize(circle, Complex64::ZERO);
        self.plan.run(&mut line, scratch);
        Lags([&line[circle - self.order..], &line[..=self.order]].concat())
    }
}

impl Lags {
    /// Entry (i, j) of a Toeplitz block: the transform at j − i.
    pub fn at(&self, i: usize, j: usize) -> Complex64 {
        self.0[self.0.len() / 2 + j - i]
    }
}

/// `1/Π |z − z_r|²` at every line over the known poles among the lines: the noise of an equation is
/// that of its line times the denominator (Sanathanan and Koerner 1963, IEEE Trans. Automatic
/// Control 8(1)).
fn course(omega: &[f64], step_s: f64, known: &[Complex64]) -> Vec<f64> {
    let z = |s: Complex64| ((s - Complex64::new(0.0, omega[0])) * step_s).exp();
    let inside = |pole: &&Complex64| pole.im > omega[0] && pole.im < omega[omega.len() - 1];
    let known: Vec<Complex64> = known.iter().filter(inside).map(|pole| z(*pole)).collect();
    let at = |w: &f64| {
        let own = z(Complex64::new(0.0, *w));
        let factors = known.iter().map(|pole| (own - pole).norm_sqr());
        factors.product::<f64>().recip()
    };
    omega.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::mdof::normal_equations::*;
    use crate::identify::synthetic::{Measurement, Structure};

    #[test]
    fn transforms_are_the_sums_over_the_lines() {
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz: 1.0,
            len: 61,
        };
        let shapes = [vec![1.0, 0.5, -0.7], vec![0.4, -0.9, 0.6]];
        let modes = [20.0, 33.0].into_iter().zip(shapes);
        let modes = modes.map(|(hz, shape)| (hz, 0.02, shape)).collect();
        let mut how = Measurement::of_sensors(3, axis);
        for i in 0..3 {
            how.pairs
                .push((how.pairs[i].0.clone(), how.pairs[1].0.clone()));
        }
        let set = Structure { modes }.measured(&how);
        let data = Receptances::new(&set, Band::new(5.0, 50.0).unwrap()).unwrap();
        let (sides, order) = (Sides::new(set.functions()), 4);
        let own = Transforms::new(&data, &sides, (0..data.lines(), order, &[]));
        let z = |k: usize, lag: i32| {
            let angle = (data.omega[k] - own.plane.omega_0) * own.plane.step_s;
            Complex64::from_polar(1.0, angle * f64::from(lag))
        };
        let value = |o: usize, p: usize, k: usize| data.values[sides.outputs[o][p].1][k];
        let weight = |o: usize, k: usize| {
            let power = (value(o, 0, k).norm_sqr() + value(o, 1, k).norm_sqr()) / 2.0;
            let precision = |p: usize| {
                let variance = data.variance[sides.outputs[o][p].1][k];
                1.0 / (variance + MODEL * power)
            };
            (precision(0) + precision(1)) / 2.0
        };
        let near = |told: Complex64, course: &dyn Fn(usize) -> Complex64, lag: i32| {
            let sum: Complex64 = (0..data.lines()).map(|k| course(k) * z(k, lag)).sum();
            let size: f64 = (0..data.lines()).map(|k| course(k).norm()).sum();
            assert!((told - sum).norm() < 1e-12 * size, "{told} {sum} {lag}");
        };
        for (i, j, lag) in [(0, 0, 0), (0, 4, 4), (3, 1, -2)] {
            for (o, output) in own.outputs.iter().enumerate() {
                near(output.weight.at(i, j), &|k| weight(o, k).into(), lag);
                near(
                    output.functions[1].at(i, j),
                    &|k| weight(o, k) * value(o, 1, k),
                    lag,
                );
            }
            let product = |k: usize| -> Complex64 {
                let of = |o: usize| weight(o, k) * value(o, 0, k).conj() * value(o, 1, k);
                (0..3).map(of).sum()
            };
            near(own.products[1].at(i, j), &product, lag);
        }
    }
}

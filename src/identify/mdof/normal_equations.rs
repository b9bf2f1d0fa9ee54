//! Fourier transforms of weighted frequency lines give the Toeplitz blocks of the normal equations
//! of the polyreference LSCF ([`plscf`](crate::identify::mdof::plscf)).

use std::borrow::Cow;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::z_plane::{ZPlane, circle_points};

/// Error of the model relative to the response, squared. Without it, strong resonances far above
/// the noise would suppress weak ones in the normal equations. In the estimate with lines weighted
/// by poles, weak resonances have been found already.
const MODEL_ERROR_VARIANCE_RATIO: f64 = 1e-6;
const REWEIGHTED_ERROR_VARIANCE_RATIO: f64 = 1e-10;
/// Number of outputs whose sums one thread forms.
pub(in crate::identify) const CHUNK_OUTPUTS: usize = 8;
/// Number of such sums that are held at once: each has as many values as the FRFs of its inputs.
const CHUNKS_AT_ONCE: usize = 16;

/// Transforms over the lines, from which all blocks of the normal equations are formed.
pub(in crate::identify) struct Transforms {
    /// Number of inputs.
    pub inputs: usize,
    /// Highest order.
    pub order: usize,
    /// Mapping of the lines to the unit circle.
    pub plane: ZPlane,
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
    /// Transforms of some lines for equations up to an order; `frf_matrix` must be complete. Every
    /// line is weighted by one over the factor that the denominator of `weight_poles`, rad/s,
    /// applies to its noise.
    pub fn new(
        data: &FitData,
        frf_matrix: &FrfMatrix,
        lines: Range<usize>,
        order: usize,
        weight_poles: &[Complex64],
    ) -> Self {
        let plan = ComplexPlan::inverse(circle_points(lines.len(), 2 * order + 2));
        let step_s = std::f64::consts::TAU / (plan.len() as f64 * data.frfs.step);
        let weighted = Lines {
            denominator_weight: denominator_weight(
                &data.frfs.omega[lines.clone()],
                step_s,
                weight_poles,
            ),
            model_error: if weight_poles.is_empty() {
                MODEL_ERROR_VARIANCE_RATIO
            } else {
                REWEIGHTED_ERROR_VARIANCE_RATIO
            },
            data,
            lines: lines.clone(),
            plan,
            order,
        };
        let m = frf_matrix.inputs;
        let mut sums = vec![vec![Complex64::ZERO; lines.len()]; m * m];
        let mut outputs = Vec::with_capacity(frf_matrix.outputs.len());
        for chunks in frf_matrix.outputs.chunks(CHUNKS_AT_ONCE * CHUNK_OUTPUTS) {
            let chunks = chunks.par_chunks(CHUNK_OUTPUTS);
            let chunks: Vec<(Vec<Output>, Vec<Vec<Complex64>>)> = chunks
                .map(|outputs| weighted.transformed(outputs))
                .collect();
            for (chunk_outputs, products) in chunks {
                outputs.extend(chunk_outputs);
                for (sum, product) in sums.iter_mut().zip(products) {
                    sum.iter_mut().zip(product).for_each(|(s, p)| *s = *s + p);
                }
            }
        }
        let mut scratch = weighted.plan.scratch();
        Self {
            inputs: m,
            order,
            plane: ZPlane {
                omega_0: data.frfs.omega[lines.start],
                step_s,
            },
            outputs,
            products: sums
                .into_iter()
                .map(|sum| weighted.lags(sum, &mut scratch))
                .collect(),
        }
    }
}

/// Weighted lines and the plan of their transforms.
struct Lines<'a> {
    data: &'a FitData,
    lines: Range<usize>,
    /// Weight of every line by the denominator of given poles.
    denominator_weight: Vec<f64>,
    /// Error of the model relative to the response, squared.
    model_error: f64,
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
            let functions: Vec<Cow<'_, [Complex64]>> = output
                .iter()
                .map(|(_, f)| self.data.frfs.values.of(*f, self.lines.clone()))
                .collect();
            for (position, sum) in sums.iter_mut().enumerate() {
                let (p, q) = (&functions[position / m], &functions[position % m]);
                let pairs = p.iter().zip(q.iter()).zip(&weights);
                sum.iter_mut()
                    .zip(pairs)
                    .for_each(|(sum, ((p, q), w))| *sum += w * (p.conj() * q));
            }
            let weighted = |h: &Cow<'_, [Complex64]>| {
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
            let values = self.data.frfs.values.of(*f, self.lines.clone());
            let squares = values.iter().map(Complex64::norm_sqr);
            powers
                .iter_mut()
                .zip(squares)
                .for_each(|(sum, p)| *sum += p / m);
        }
        let mut weights = vec![0.0; self.lines.len()];
        for (_, f) in output {
            let variances = self.data.noise.by_frf[*f].variances(self.lines.clone());
            for ((sum, v), power) in weights.iter_mut().zip(variances).zip(&powers) {
                *sum += 1.0 / (v + self.model_error * power);
            }
        }
        weights
            .iter()
            .zip(&self.denominator_weight)
            .map(|(sum, denominator_weight)| denominator_weight * sum / m)
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

/// `1/Π |z − z_r|²` at every line over those of the given poles that lie among the lines: the noise
/// of an equation is that of its line times the denominator (Sanathanan and Koerner 1963, IEEE
/// Trans. Automatic Control 8(1)).
fn denominator_weight(omega: &[f64], step_s: f64, weight_poles: &[Complex64]) -> Vec<f64> {
    let z = |s: Complex64| ((s - Complex64::new(0.0, omega[0])) * step_s).exp();
    let inside = |pole: &&Complex64| pole.im > omega[0] && pole.im < omega[omega.len() - 1];
    let weight_poles: Vec<Complex64> = weight_poles
        .iter()
        .filter(inside)
        .map(|pole| z(*pole))
        .collect();
    let weight = |w: &f64| {
        let line_z = z(Complex64::new(0.0, *w));
        let factors = weight_poles.iter().map(|pole| (line_z - pole).norm_sqr());
        factors.product::<f64>().recip()
    };
    omega.iter().map(weight).collect()
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
        let data = FitData::new(&set, Band::new(5.0, 50.0).unwrap()).unwrap();
        let (frf_matrix, order) = (FrfMatrix::new(set.functions()), 4);
        let transforms = Transforms::new(&data, &frf_matrix, 0..data.frfs.lines(), order, &[]);
        let z = |k: usize, lag: i32| {
            let angle = (data.frfs.omega[k] - transforms.plane.omega_0) * transforms.plane.step_s;
            Complex64::from_polar(1.0, angle * f64::from(lag))
        };
        let value =
            |o: usize, p: usize, k: usize| data.frfs.values.at(frf_matrix.outputs[o][p].1, k);
        let weight = |o: usize, k: usize| {
            let power = (value(o, 0, k).norm_sqr() + value(o, 1, k).norm_sqr()) / 2.0;
            let precision = |p: usize| {
                let variance = data.noise.by_frf[frf_matrix.outputs[o][p].1].variance(k);
                1.0 / (variance + MODEL_ERROR_VARIANCE_RATIO * power)
            };
            (precision(0) + precision(1)) / 2.0
        };
        let assert_near = |transform: Complex64, term: &dyn Fn(usize) -> Complex64, lag: i32| {
            let sum: Complex64 = (0..data.frfs.lines()).map(|k| term(k) * z(k, lag)).sum();
            let size: f64 = (0..data.frfs.lines()).map(|k| term(k).norm()).sum();
            assert!(
                (transform - sum).norm() < 1e-12 * size,
                "{transform} {sum} {lag}"
            );
        };
        for (i, j, lag) in [(0, 0, 0), (0, 4, 4), (3, 1, -2)] {
            for (o, output) in transforms.outputs.iter().enumerate() {
                assert_near(output.weight.at(i, j), &|k| weight(o, k).into(), lag);
                assert_near(
                    output.functions[1].at(i, j),
                    &|k| weight(o, k) * value(o, 1, k),
                    lag,
                );
            }
            let product = |k: usize| -> Complex64 {
                let of = |o: usize| weight(o, k) * value(o, 0, k).conj() * value(o, 1, k);
                (0..3).map(of).sum()
            };
            assert_near(transforms.products[1].at(i, j), &product, lag);
        }
    }
}

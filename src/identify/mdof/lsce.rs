//! The least-squares complex exponential method estimates poles from impulse responses; with
//! several references it is the polyreference time domain method.
//!
//! The inverse transform of the lines of a band is a complex impulse response that runs at the
//! width of the band: `h_m = Σ_k W_k H_k e^{i2πkm/N}`, in which a pole is `z^m` with `z = e^{(λ −
//! iω_0)T}`, `T = 2π/(N Δω)`. The samples of all outputs obey one recurrence `Σ_j h_{m+j} A_j = 0`
//! with square matrices `A_j` of the number of inputs; with the *lowest* coefficient fixed it runs
//! backwards in time, and the poles of noise come out unstable. The normal equations are sums of
//! products of shifted responses, each entry from the one before on its diagonal; those of lower
//! orders are leading blocks, as in [`plscf`](crate::identify::mdof::plscf), which solves both.
//!
//! *Band.* The first line is ω_0, whatever its frequency: a pole goes back by `λ = iω_0 + ln(z)/T`,
//! the shift undone before a natural frequency is formed. A band that is cut off sharply would ring
//! in its impulse responses; its edges fall off as squared cosines `W` over [`EDGE_FRACTION`] of
//! the lines, and the first samples, which contain the edges and all terms smooth over the band,
//! are left out. The other samples are exponentials and the remaining ringing of the edges. This
//! ringing limits the accuracy without noise, and modes that decay within the first samples are not
//! detected. The taper weakens modes within the edges; poles in the outer third of an edge are not
//! reported.
//!
//! *Length.* Samples are used until the responses have decayed to their noise, which is estimated
//! before the time zero.
//!
//! *Limits.* As in all normal equations, contributions below `√ε ≈ 1e-8` of the largest response
//! are lost. The estimate is not consistent. Fewer than 65 lines leave too few samples after the
//! first ones, and give no poles.
//!
//! References: Brown, Allemang, Zimmerman and Mergeay (1979), Parameter estimation techniques for
//! modal analysis, SAE 790221; Vold, Kundrat, Rocklin and Russell (1982), A multi-input modal
//! estimation algorithm for mini-computers, SAE 820194; Kumaresan and Tufts (1982), IEEE Trans.
//! ASSP 30(6), for the direction of time.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::fourier::ComplexPlan;
use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::error::IdentifyError;
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::lscf::{highest_order, split_band};
use crate::identify::mdof::plscf::Lscf;
use crate::identify::mdof::stabilization::{BandSegment, MultiModeMethod};
use crate::identify::mdof::z_plane::{ZPlane, circle_points};

/// Fraction of the lines over which each edge of the band falls off.
const EDGE_FRACTION: f64 = 0.1;
/// Samples that are left out, in inverse widths of an edge: there the transform of a squared cosine
/// has fallen to 1e-3 of its first sample, and responses exceed it by their number of lines.
const RINGING_INVERSE_EDGES: f64 = 2.5;
/// Minimum number of used samples per order.
const MIN_SAMPLES_PER_ORDER: usize = 3;
/// Minimum mean square of used samples over that of the noise.
const MIN_POWER_OVER_NOISE: f64 = 2.0;
/// Number of samples in a block whose mean square is compared with the noise.
const BLOCK_SAMPLES: usize = 8;

/// Least-squares complex exponentials.
pub(in crate::identify) struct ComplexExponentials {
    /// Highest order; without it the number of peaks determines it.
    pub max_order: Option<usize>,
}

impl MultiModeMethod for ComplexExponentials {
    fn name(&self) -> &'static str {
        "lsce"
    }

    fn gives_participation(&self) -> bool {
        true
    }

    fn weights_lines(&self) -> bool {
        false
    }

    fn segments(
        &self,
        data: &FitData,
        frf_matrix: &FrfMatrix,
        found: &DetectedPeaks,
        _weight_poles: &[Complex64],
    ) -> Result<Vec<BandSegment>, IdentifyError> {
        let segments = split_band(&data.frfs, |end| {
            let top = highest_order(end, found, frf_matrix.inputs, self.max_order);
            let responses = Responses::new(data, frf_matrix, 0..end);
            if !responses.has_enough_samples() {
                return Ok(Vec::new());
            }
            responses.reduced_equations(frf_matrix, top)?.tables()
        });
        // The taper removes the outer third of an edge; the lowest segment has the lowest edge.
        let mut segments = segments?;
        let margin = |lines: usize| (EDGE_FRACTION / 3.0 * lines as f64) as usize;
        let last = data.frfs.lines() - 1 - margin(data.frfs.lines());
        for segment in &mut segments {
            segment.to_rad_s = segment.to_rad_s.min(data.frfs.omega[last]);
        }
        if let Some(lowest) = segments.last_mut() {
            let lines = data.frfs.omega.iter().filter(|w| **w < lowest.to_rad_s);
            lowest.from_rad_s = data.frfs.omega[margin(lines.count())];
        }
        Ok(segments)
    }
}

/// Impulse responses of all functions, over the noise of their outputs.
struct Responses {
    samples: Vec<Vec<Complex64>>,
    plane: ZPlane,
    /// First sample that is used.
    first: usize,
}

impl Responses {
    fn new(data: &FitData, frf_matrix: &FrfMatrix, lines: Range<usize>) -> Self {
        let count = lines.len();
        let points = circle_points(count, 0);
        let plan = ComplexPlan::inverse(points);
        let edge = ((EDGE_FRACTION * count as f64).round() as usize).max(1);
        let levels = levels(data, frf_matrix, &lines);
        let response = |f: usize| {
            let value = |k: usize| {
                data.frfs.values.at(f, lines.start + k) * (taper(k, count, edge) / levels[f])
            };
            let mut samples: Vec<Complex64> = (0..count).map(value).collect();
            samples.resize(points, Complex64::ZERO);
            plan.run(&mut samples, &mut plan.scratch());
            samples
        };
        let ringing = RINGING_INVERSE_EDGES * points as f64 / edge as f64;
        Self {
            samples: (0..data.frfs.functions())
                .into_par_iter()
                .map(response)
                .collect(),
            plane: ZPlane {
                omega_0: data.frfs.omega[lines.start],
                step_s: std::f64::consts::TAU / (points as f64 * data.frfs.step),
            },
            first: ringing.ceil() as usize,
        }
    }

    /// Whether the half of the circle after the time zero has enough samples.
    fn has_enough_samples(&self) -> bool {
        self.first + MIN_SAMPLES_PER_ORDER + BLOCK_SAMPLES <= self.samples[0].len() / 2
    }

    /// Reduced normal equations of the recurrence up to an order.
    fn reduced_equations(
        &self,
        frf_matrix: &FrfMatrix,
        order: usize,
    ) -> Result<Lscf, IdentifyError> {
        let order = order
            .min((self.samples[0].len() / 2).saturating_sub(self.first) / MIN_SAMPLES_PER_ORDER);
        let order = order.max(1);
        let used = self.first..self.end(order);
        let size = (order + 1) * frf_matrix.inputs;
        let products: Vec<ComplexMatrix> = frf_matrix
            .outputs
            .par_iter()
            .map(|output| self.products(output, &used, order))
            .collect();
        let mut sum = linalg::complex_matrix(size, size, |_, _| Complex64::ZERO);
        for product in products {
            sum += product;
        }
        let scale =
            (0..frf_matrix.inputs).map(|p| sum[(p, p)].re).sum::<f64>() / frf_matrix.inputs as f64;
        Ok(Lscf::of_reduced(
            &sum,
            frf_matrix.inputs,
            order,
            scale,
            self.plane,
        )?)
    }

    /// End of the samples from which a recurrence of an order starts.
    fn end(&self, order: usize) -> usize {
        let points = self.samples[0].len();
        let power = |m: usize| self.samples.iter().map(|h| h[m].norm_sqr()).sum::<f64>();
        let mean = |range: Range<usize>| {
            let count = range.len().max(1) as f64;
            range.map(power).sum::<f64>() / count
        };
        // Before the time zero, away from the ringing, there is only noise.
        let noise = mean(points * 5 / 8..points * 7 / 8);
        let min_end = self.first + MIN_SAMPLES_PER_ORDER * order;
        let max_end = (points * 5 / 8).saturating_sub(order).max(min_end);
        let is_noise = |start: &usize| {
            mean(*start..(start + BLOCK_SAMPLES).min(points)) < MIN_POWER_OVER_NOISE * noise
        };
        let noise_start = (self.first..max_end).step_by(BLOCK_SAMPLES).find(is_noise);
        noise_start
            .unwrap_or(max_end)
            .clamp(min_end, max_end)
            .min(points - order)
    }

    /// `Σ_m h̄_{p,m+i} h_{q,m+j}` of one output, inputs p and q innermost: each entry is the one
    /// before on its diagonal, without its first and with one more product.
    fn products(
        &self,
        output: &[(usize, usize)],
        used: &Range<usize>,
        order: usize,
    ) -> ComplexMatrix {
        let m = output.len();
        let h = |p: usize| self.samples[output[p].1].as_slice();
        let size = (order + 1) * m;
        let mut sums = linalg::complex_matrix(size, size, |_, _| Complex64::ZERO);
        for p in 0..m {
            for q in 0..m {
                for lag in 0..=order {
                    let pair = |t: usize| h(p)[t].conj() * h(q)[t + lag];
                    let mut sum: Complex64 = used.clone().map(pair).sum();
                    for i in 0..=order - lag {
                        sums[(i * m + p, (i + lag) * m + q)] = sum;
                        sums[((i + lag) * m + q, i * m + p)] = sum.conj();
                        if i < order - lag {
                            sum += pair(used.end + i) - pair(used.start + i);
                        }
                    }
                }
            }
        }
        sums
    }
}

/// Divisor of each FRF: one noise level for all inputs of an output, the root of the inverse of
/// their mean precision. One level per FRF would change the participation factors from output to
/// output, which share one recurrence.
fn levels(data: &FitData, frf_matrix: &FrfMatrix, lines: &Range<usize>) -> Vec<f64> {
    let mut levels = vec![1.0; data.frfs.functions()];
    for output in &frf_matrix.outputs {
        let precision = |(_, f): &(usize, usize)| 1.0 / data.noise.mean_variance(*f, lines.clone());
        let mean = output.iter().map(precision).sum::<f64>() / output.len() as f64;
        for (_, f) in output {
            levels[*f] = mean.sqrt().recip();
        }
    }
    levels
}

/// A band that falls off at its edges as squared cosines.
fn taper(k: usize, count: usize, edge: usize) -> f64 {
    let inside = (k + 1).min(count - k);
    if inside > edge {
        return 1.0;
    }
    let phase = std::f64::consts::FRAC_PI_2 * inside as f64 / (edge + 1) as f64;
    phase.sin().powi(2)
}

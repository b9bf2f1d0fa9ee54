//! The only place that names an FFT crate: one-sided transforms of real records and complex ones of
//! lines, with shared plans.

use std::sync::Arc;

use num_complex::Complex64;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Forward transform of real records of one length, `X_k = sum_n x_n exp(-2 pi i k n / N)`, `k = 0
/// ..= N/2`, unscaled.
///
/// Cheap to clone; each thread keeps one [`Scratch`].
#[derive(Clone)]
pub struct ForwardPlan {
    transform: Arc<dyn RealToComplex<f64>>,
}

/// Working memory of one thread for one plan.
pub struct Scratch {
    input: Vec<f64>,
    work: Vec<Complex64>,
}

impl ForwardPlan {
    /// A plan for records of `len` samples.
    pub fn new(len: usize) -> Self {
        Self {
            transform: RealFftPlanner::<f64>::new().plan_fft_forward(len),
        }
    }

    /// Record length.
    pub fn len(&self) -> usize {
        self.transform.len()
    }

    /// Whether the plan is for records without samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of lines, `len / 2 + 1`.
    pub fn lines(&self) -> usize {
        self.transform.complex_len()
    }

    /// Working memory for this plan.
    pub fn scratch(&self) -> Scratch {
        Scratch {
            input: self.transform.make_input_vec(),
            work: self.transform.make_scratch_vec(),
        }
    }

    /// Transforms the samples into `output`, which must have [`Self::lines`] places.
    ///
    /// # Panics
    /// When the number of samples or of output places is not that of the plan.
    pub fn forward(
        &self,
        samples: impl IntoIterator<Item = f64>,
        output: &mut [Complex64],
        scratch: &mut Scratch,
    ) {
        let mut count = 0;
        for (place, sample) in scratch.input.iter_mut().zip(samples) {
            *place = sample;
            count += 1;
        }
        assert_eq!(count, self.len(), "samples for the plan");
        self.process(&mut scratch.input, output, &mut scratch.work);
    }

    /// Transforms samples into `output`; the samples are lost.
    ///
    /// # Panics
    /// When the number of samples or of output places is not that of the plan, or the scratch is of
    /// another plan.
    pub fn run(&self, samples: &mut [f64], output: &mut [Complex64], scratch: &mut Scratch) {
        self.process(samples, output, &mut scratch.work);
    }

    fn process(&self, samples: &mut [f64], output: &mut [Complex64], work: &mut [Complex64]) {
        self.transform
            .process_with_scratch(samples, output, work)
            .expect("buffer lengths come from the plan");
    }

    /// The transform as a new vector.
    pub fn transform(&self, samples: &[f64]) -> Vec<Complex64> {
        let mut output = vec![Complex64::ZERO; self.lines()];
        self.forward(samples.iter().copied(), &mut output, &mut self.scratch());
        output
    }
}

/// Inverse transform of complex lines, `x_m = Σ_k X_k exp(2πi k m / N)`, unscaled.
#[derive(Clone)]
pub struct ComplexPlan {
    transform: Arc<dyn Fft<f64>>,
}

impl ComplexPlan {
    /// A plan for `len` lines.
    pub fn inverse(len: usize) -> Self {
        Self {
            transform: FftPlanner::<f64>::new().plan_fft_inverse(len),
        }
    }

    /// Number of lines.
    pub fn len(&self) -> usize {
        self.transform.len()
    }

    /// Whether the plan is for no lines.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Working memory for [`Self::run`].
    pub fn scratch(&self) -> Vec<Complex64> {
        vec![Complex64::ZERO; self.transform.get_inplace_scratch_len()]
    }

    /// Transforms in place.
    ///
    /// # Panics
    /// When the number of lines is not that of the plan.
    pub fn run(&self, lines: &mut [Complex64], scratch: &mut [Complex64]) {
        self.transform.process_with_scratch(lines, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_cosine_lands_on_its_line_with_its_phase() {
        for n in [32usize, 45] {
            let phase = 0.3;
            let samples: Vec<f64> = (0..n)
                .map(|i| (TAU * 5.0 * i as f64 / n as f64 + phase).cos())
                .collect();
            let lines = ForwardPlan::new(n).transform(&samples);
            let expected = Complex64::from_polar(n as f64 / 2.0, phase);
            assert!((lines[5] - expected).norm() < 1e-12 * n as f64);
            assert!(lines[6].norm() < 1e-12 * n as f64);
        }
    }
}

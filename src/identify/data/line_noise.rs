//! The noise of an FRF has at every line a standard deviation and the fraction of its variance that
//! is force noise.
//!
//! Both are in single precision, a quarter of the memory of the FRF each, in place of a half: noise
//! is known to some per cent, single precision to 6e-8. Standard deviations are relative to a scale
//! of the FRF, so that FRFs of any size have them. Copies share the numbers.

use std::ops::Range;
use std::sync::Arc;

/// Maximum rounding of a force fraction, and of a variance over its value: of variances that are
/// converted from accelerances and back 1e-15, of single precision 1.2e-7. Larger, at 0.1: force
/// noise is lost. Smaller, at 0: fractions of FRFs without force noise take memory, and noise at
/// its minimum changes. Tests `noise_of_any_size_is_exact_to_single_precision`,
/// `raised_noise_changes_where_it_is_below_the_minimum`.
const MAX_ROUNDING: f64 = 1e-6;
/// Largest finite standard deviation over the scale; single precision holds 1e-38 to 3e38. Larger,
/// at 1e38: an infinite standard deviation becomes three times the largest finite one. Smaller, at
/// 1: beside an unknown variance of 3e38, noise below 1e-19 m/N is lost. Test:
/// `an_outlier_leaves_the_noise_of_the_other_lines`.
const MAX_RELATIVE_STD: f64 = 1e20;
/// Lines that are summed at once: each sum waits for the one before.
const LANES: usize = 8;

/// Noise of one FRF by line.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct LineNoise {
    /// The power of two below the largest finite standard deviation, m/N, over
    /// [`MAX_RELATIVE_STD`]: variances of other lines stay what they are where one is raised.
    scale: f64,
    /// Standard deviation over the scale.
    relative: Arc<[f32]>,
    /// Fraction of the variance that is force noise; `None` where it is 0 at all lines.
    force_fraction: Option<Arc<[f32]>>,
}

impl LineNoise {
    /// Noise of given variances, (m/N)², with the force fraction of each. Fractions of rounding are
    /// those of no force noise.
    pub fn new(variance: &[f64], force_fraction: &[f64]) -> Self {
        let mut noise = Self {
            scale: 0.0,
            relative: Arc::new([]),
            force_fraction: None,
        };
        noise.set_variance(variance);
        if force_fraction
            .iter()
            .any(|fraction| fraction.abs() > MAX_ROUNDING)
        {
            let fractions = force_fraction.iter().map(|fraction| *fraction as f32);
            noise.force_fraction = Some(fractions.collect());
        }
        noise
    }

    fn set_variance(&mut self, variance: &[f64]) {
        let stds = variance.iter().map(|variance| variance.sqrt());
        let largest = stds.filter(|std| std.is_finite()).fold(0.0, f64::max);
        self.scale = match largest > 0.0 {
            true => power_of_two_below(largest / MAX_RELATIVE_STD),
            false => 1.0,
        };
        let relative = |variance: &f64| {
            ((variance.sqrt() / self.scale) as f32).clamp(f32::MIN_POSITIVE, f32::MAX)
        };
        self.relative = variance.iter().map(relative).collect();
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.relative.len()
    }

    /// Standard deviation at a line, m/N.
    #[inline]
    pub fn std(&self, line: usize) -> f64 {
        self.scale * f64::from(self.relative[line])
    }

    /// Standard deviations on a range of lines, m/N.
    #[inline]
    pub fn stds(&self, lines: Range<usize>) -> impl ExactSizeIterator<Item = f64> + Clone {
        let scale = self.scale;
        let relative = self.relative[lines].iter();
        relative.map(move |relative| scale * f64::from(*relative))
    }

    /// Variance at a line, (m/N)².
    #[inline]
    pub fn variance(&self, line: usize) -> f64 {
        let std = self.std(line);
        std * std
    }

    /// Variances on a range of lines, (m/N)².
    #[inline]
    pub fn variances(&self, lines: Range<usize>) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.stds(lines).map(|std| std * std)
    }

    /// Mean variance on a range of lines, (m/N)².
    pub fn mean_variance(&self, lines: Range<usize>) -> f64 {
        let count = lines.len().max(1) as f64;
        let (lanes, last) = self.relative[lines].as_chunks::<LANES>();
        let square = |relative: f32| f64::from(relative) * f64::from(relative);
        let mut sums = [0.0; LANES];
        for relative in lanes {
            for lane in 0..LANES {
                sums[lane] += square(relative[lane]);
            }
        }
        let last: f64 = last.iter().map(|relative| square(*relative)).sum();
        let sum = sums.iter().sum::<f64>() + last;
        // The square of the scale may be too small for a number.
        self.scale * (self.scale * (sum / count))
    }

    /// Fractions of the variance that are force noise on a range of lines, where there are any.
    pub fn force_fractions(&self, lines: Range<usize>) -> Option<&[f32]> {
        self.force_fraction
            .as_ref()
            .map(|fractions| &fractions[lines])
    }

    /// Raises every variance to a minimum at its line, from which rounding is no difference.
    pub fn raise(&mut self, minimum: impl Iterator<Item = f64> + Clone) {
        let pairs = self.variances(0..self.lines()).zip(minimum);
        let is_below = |(variance, minimum): (f64, f64)| variance < (1.0 - MAX_ROUNDING) * minimum;
        if pairs.clone().any(is_below) {
            let raised = pairs.map(|(variance, minimum)| variance.max(minimum));
            let raised: Vec<f64> = raised.collect();
            self.set_variance(&raised);
        }
    }
}

/// The power of two that is a normal number or the next below it.
fn power_of_two_below(number: f64) -> f64 {
    f64::from_bits(number.to_bits() & f64::INFINITY.to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_any_size_is_exact_to_single_precision() {
        for size in [1e-300, 1e-40, 1.0, 1e150] {
            let variance = [4.0, 1e-12, 0.25, 3.0].map(|v| v * size);
            let noise = LineNoise::new(&variance, &[0.0, 0.5, 0.0, 1.0]);
            for (k, v) in variance.into_iter().enumerate() {
                assert!((noise.variance(k) / v - 1.0).abs() < 3e-7, "{size} {k}");
                let mean = noise.mean_variance(k..k + 1);
                assert!((mean / v - 1.0).abs() < 3e-7, "{size} {k}: {mean}");
            }
            assert_eq!(noise.force_fractions(1..4), Some(&[0.5, 0.0, 1.0][..]));
        }
        let without = LineNoise::new(&[1.0; 3], &[0.0, 1e-16, -1e-16]);
        assert_eq!(without.force_fractions(0..3), None);
    }

    #[test]
    fn an_outlier_leaves_the_noise_of_the_other_lines() {
        // An unknown variance, beside noise of 1e-20 m/N.
        let variance = [3.4e38, 1e-40, 2e-40];
        let noise = LineNoise::new(&variance, &[0.0; 3]);
        for (k, v) in variance.into_iter().enumerate() {
            assert!((noise.variance(k) / v - 1.0).abs() < 3e-7, "{k}");
        }
        let noise = LineNoise::new(&[f64::NAN, 4.0, 0.0, f64::INFINITY], &[0.0; 4]);
        assert!(noise.std(0).is_nan() && noise.std(2) < 1e-30 && noise.std(3) > 1e18);
        assert!((noise.std(1) - 2.0).abs() < 1e-6);
        // A line without noise.
        let noise = LineNoise::new(&[1e-20, f64::MIN_POSITIVE, 4e-20], &[0.0; 3]);
        for (k, v) in [(0, 1e-20), (2, 4e-20)] {
            assert!((noise.variance(k) / v - 1.0).abs() < 3e-7, "{k}");
        }
        assert!(noise.std(1) < 1e-60);
    }

    #[test]
    fn the_mean_variance_is_that_of_its_lines_alone() {
        let variance: Vec<f64> = (0..19).map(|k| f64::from(k * k + 1)).collect();
        let noise = LineNoise::new(&variance, &[0.0; 19]);
        for lines in [0..19, 3..16, 18..19] {
            let mean = variance[lines.clone()].iter().sum::<f64>() / lines.len() as f64;
            assert!(
                (noise.mean_variance(lines.clone()) / mean - 1.0).abs() < 3e-7,
                "{lines:?}"
            );
        }
    }

    #[test]
    fn raised_noise_changes_where_it_is_below_the_minimum() {
        let mut noise = LineNoise::new(&[1.0, 4.0, 9.0], &[0.0; 3]);
        let before = noise.clone();
        noise.raise([1.0, 1.0, 1.0].into_iter());
        assert_eq!(noise, before);
        noise.raise([16.0, 1.0, 10.0].into_iter());
        let raised: Vec<f64> = noise.variances(0..3).collect();
        for (v, expected) in raised.into_iter().zip([16.0, 4.0, 10.0]) {
            assert!((v / expected - 1.0).abs() < 3e-7);
        }
        // The larger scale leaves the others as they are, to the last bit.
        let mut noise = LineNoise::new(&[0.1, 0.2, 0.3], &[0.0; 3]);
        let before: Vec<f64> = noise.variances(0..3).collect();
        noise.raise([7e9, 0.0, 0.0].into_iter());
        let after: Vec<f64> = noise.variances(0..3).collect();
        assert_eq!(before[1..], after[1..]);
    }
}

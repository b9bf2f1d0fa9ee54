//! The byte order of binary values, judged by the values where the stated one is wrong.
//!
//! Values of a measurement have ordinary magnitudes, and neighbouring values have similar ones.
//! Read in the wrong byte order, the last bits of the mantissa become sign and exponent: numbers
//! of full precision are spread over the whole range of the format, and numbers of few digits
//! become smaller than any measured value. Only where the stated order shows the one and the
//! opposite order the other is the stated order wrong.

use std::collections::BTreeSet;

use super::binary_samples::BinaryBlock;
use super::value_width::numbers_per_value;
use crate::io::SampleFormat;

/// Distinct numbers that the judgement needs. With fewer, chance makes a few values smooth in the
/// opposite order; with more, a short record in the wrong order is not recognised. With 16, fewer
/// than one block in 1e9 of random bits passes (`correct_values_keep_the_stated_order`).
const MIN_DISTINCT_NUMBERS: usize = 16;
/// Largest binary exponent of an ordinary magnitude, 1e±30. With less, power spectral densities of
/// displacement in m²/Hz are not ordinary; with more, 32-bit numbers in the wrong order are, for
/// their range ends at 2^±127 (`values_in_the_opposite_order_are_recognised`).
const MAX_ORDINARY_EXPONENT: i32 = 100;
/// Largest fraction of numbers of other magnitude or not finite in a block that makes sense. With
/// more, blocks of random bits come closer to passing; with none, one missing line of a function
/// hides that its order is wrong (`values_in_the_opposite_order_are_recognised`).
const MAX_EXTRAORDINARY_FRACTION: f64 = 1.0 / 32.0;
/// Largest median difference of neighbouring binary exponents in a block that makes sense, a factor
/// of 16; Gaussian noise has 1. With less, noise with outliers fails; random bits have 85 in 32-bit
/// numbers and 600 in 64-bit ones (`correct_values_keep_the_stated_order`).
const MAX_SENSIBLE_STEP: i32 = 4;
/// Smallest median difference of neighbouring binary exponents in a block that makes none. With
/// less, spiky records make none; with more than 85, 32-bit numbers in the wrong order do
/// (`values_in_the_opposite_order_are_recognised`).
const MIN_SENSELESS_STEP: i32 = 16;

/// What the values of a block show of its byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) enum Evidence {
    /// They make sense in the stated order alone.
    Stated,
    /// They make sense in the opposite order alone.
    Opposite,
    /// They make sense in both or in none, or are too few.
    None,
}

/// Judges whole values of a block, abscissae before them where the block has any.
pub(in crate::io::formats::uff) fn evidence(bytes: &[u8], block: &BinaryBlock) -> Evidence {
    let stated = Magnitudes::of(bytes, block, block.little_endian);
    if !stated.is_varied {
        return Evidence::None;
    }
    let opposite = Magnitudes::of(bytes, block, !block.little_endian);
    if stated.are_senseless() && opposite.are_sensible() {
        Evidence::Opposite
    } else if stated.are_sensible() && opposite.are_senseless() {
        Evidence::Stated
    } else {
        Evidence::None
    }
}

/// Magnitudes of the numbers of a block in one byte order.
struct Magnitudes {
    /// Whether there are enough distinct numbers other than zero.
    is_varied: bool,
    /// Fraction of the numbers other than zero that are not finite or of no ordinary magnitude.
    extraordinary: f64,
    /// Median difference of the binary exponents of neighbouring numbers other than zero; of a
    /// complex function, of real parts and of imaginary parts.
    median_step: i32,
}

impl Magnitudes {
    fn of(bytes: &[u8], block: &BinaryBlock, little_endian: bool) -> Self {
        let is_single = matches!(
            block.format,
            SampleFormat::RealF32 | SampleFormat::ComplexF32
        );
        let width = if is_single { 4 } else { 8 };
        let number = |bytes: &[u8]| match (bytes.first_chunk::<8>(), bytes.first_chunk::<4>()) {
            (Some(bytes), _) if little_endian => f64::from_le_bytes(*bytes),
            (Some(bytes), _) => f64::from_be_bytes(*bytes),
            (_, Some(bytes)) if little_endian => f32::from_le_bytes(*bytes).into(),
            (_, Some(bytes)) => f32::from_be_bytes(*bytes).into(),
            _ => f64::NAN,
        };
        let values = bytes.chunks_exact(block.stride());
        let numbers: Vec<f64> = values
            .flat_map(|value| value[block.abscissa_bytes..].chunks_exact(width))
            .map(number)
            .collect();
        let exponents: Vec<Option<i32>> = numbers.iter().map(|number| exponent(*number)).collect();
        let is_extraordinary = |exponent: &&i32| exponent.abs() > MAX_ORDINARY_EXPONENT;
        let all = exponents.iter().flatten();
        let extraordinary = all.clone().filter(is_extraordinary).count();
        let neighbours = exponents
            .iter()
            .skip(numbers_per_value(block.format) as usize);
        let steps = exponents.iter().zip(neighbours);
        let mut steps: Vec<i32> = steps
            .filter_map(|(before, behind)| Some((before.as_ref()? - behind.as_ref()?).abs()))
            .collect();
        steps.sort_unstable();
        Self {
            is_varied: is_varied(&numbers),
            extraordinary: extraordinary as f64 / all.count().max(1) as f64,
            median_step: steps.get(steps.len() / 2).copied().unwrap_or(0),
        }
    }

    fn are_sensible(&self) -> bool {
        self.extraordinary <= MAX_EXTRAORDINARY_FRACTION && self.median_step <= MAX_SENSIBLE_STEP
    }

    fn are_senseless(&self) -> bool {
        self.extraordinary >= 0.5 || self.median_step >= MIN_SENSELESS_STEP
    }
}

fn is_varied(numbers: &[f64]) -> bool {
    let mut distinct = BTreeSet::new();
    numbers.iter().any(|number| {
        if exponent(*number).is_some() {
            distinct.insert(number.to_bits());
        }
        distinct.len() >= MIN_DISTINCT_NUMBERS
    })
}

/// The binary exponent of a number, that of infinity where it is not finite; `None` for zero.
fn exponent(number: f64) -> Option<i32> {
    const BIAS: i32 = 1023;
    let field = (number.to_bits() >> 52 & 0x7ff) as i32;
    (number != 0.0).then_some(field - BIAS)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    const FORMATS: [SampleFormat; 4] = [
        SampleFormat::RealF32,
        SampleFormat::RealF64,
        SampleFormat::ComplexF32,
        SampleFormat::ComplexF64,
    ];

    /// Kinds of values that measurements and calculations give.
    const KINDS: usize = 12;
    /// Those that are measured. In the opposite order the bits of an even ramp change evenly, which
    /// does not look senseless, so that ramps keep the stated order.
    const MEASURED_KINDS: &[usize] = &[2, 4, 5, 6, 7, 9];

    /// Numbers of a kind.
    fn numbers(kind: usize, count: usize, scale: f64, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut level = 0.0;
        let mut number = |index: usize| {
            let t = index as f64;
            let noise: f64 = StandardNormal.sample(&mut random);
            let whole = f64::from(random.random_range(-2000..2000));
            match kind {
                0 => 0.0,
                1 => 1.0,
                2 => whole,
                3 => t,
                4 => whole / 32768.0,
                5 => noise,
                6 => (-0.05 * t).exp() * t.sin(),
                7 => 1.0 / (1.0 - (t / 40.0).powi(2) + 1e-3 * noise),
                8 => t * t * 0.01,
                9 => {
                    level += noise;
                    level
                }
                10 => f64::from(random.random::<u32>()) * f64::from(random.random::<u32>()),
                _ if index.is_multiple_of(7) => f64::NAN,
                _ => noise.powi(9),
            }
        };
        (0..count).map(|index| scale * number(index)).collect()
    }

    fn block(format: SampleFormat, little_endian: bool) -> BinaryBlock {
        BinaryBlock {
            byte: 0,
            little_endian,
            format,
            abscissa_bytes: 0,
        }
    }

    fn bytes(numbers: &[f64], block: &BinaryBlock) -> Vec<u8> {
        let mut bytes = Vec::new();
        for number in numbers {
            let single = *number as f32;
            match (block.format, block.little_endian) {
                (SampleFormat::RealF32 | SampleFormat::ComplexF32, true) => {
                    bytes.extend(single.to_le_bytes());
                }
                (SampleFormat::RealF32 | SampleFormat::ComplexF32, false) => {
                    bytes.extend(single.to_be_bytes());
                }
                (_, true) => bytes.extend(number.to_le_bytes()),
                (_, false) => bytes.extend(number.to_be_bytes()),
            }
        }
        bytes
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4_000))]

        #[test]
        fn correct_values_keep_the_stated_order(
            kind in 0..KINDS,
            format in 0usize..4,
            little_endian: bool,
            is_single: bool,
            count in 1usize..400,
            decade in -320i32..310,
            seed: u64,
        ) {
            let numbers = numbers(kind, count, 10f64.powi(decade), seed);
            let round = |number: &f64| if is_single { f64::from(*number as f32) } else { *number };
            let numbers: Vec<f64> = numbers.iter().map(round).collect();
            let block = block(FORMATS[format], little_endian);
            let found = evidence(&bytes(&numbers, &block), &block);
            prop_assert_ne!(found, Evidence::Opposite, "kind {}", kind);
        }

        #[test]
        fn random_bits_keep_the_stated_order(
            bytes in proptest::collection::vec(any::<u8>(), 0..1_000),
            format in 0usize..4,
            little_endian: bool,
        ) {
            let found = evidence(&bytes, &block(FORMATS[format], little_endian));
            prop_assert_ne!(found, Evidence::Opposite);
        }

        #[test]
        fn values_in_the_opposite_order_are_recognised(
            kind in proptest::sample::select(MEASURED_KINDS),
            format in 0usize..4,
            little_endian: bool,
            count in 100usize..400,
            decade in -20i32..20,
            missing: bool,
            seed: u64,
        ) {
            let mut numbers = numbers(kind, count, 10f64.powi(decade), seed);
            if missing {
                numbers[0] = f64::NAN;
                numbers[1] = f64::NAN;
            }
            let written = block(FORMATS[format], little_endian);
            let stated = block(FORMATS[format], !little_endian);
            let found = evidence(&bytes(&numbers, &written), &stated);
            prop_assert_eq!(found, Evidence::Opposite, "kind {}", kind);
        }
    }
}

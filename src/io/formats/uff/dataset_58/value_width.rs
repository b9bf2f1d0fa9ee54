//! The sample format of dataset 58 sets bytes and numbers of one value.

use crate::io::SampleFormat;

/// Bytes of one value.
pub(in crate::io::formats::uff) fn value_bytes(format: SampleFormat) -> u64 {
    match format {
        SampleFormat::RealF32 => 4,
        SampleFormat::RealF64 | SampleFormat::ComplexF32 => 8,
        SampleFormat::ComplexF64 => 16,
    }
}

/// Numbers of one value: a real one, or real and imaginary part.
pub(super) fn numbers_per_value(format: SampleFormat) -> u64 {
    match format {
        SampleFormat::RealF32 | SampleFormat::RealF64 => 1,
        SampleFormat::ComplexF32 | SampleFormat::ComplexF64 => 2,
    }
}

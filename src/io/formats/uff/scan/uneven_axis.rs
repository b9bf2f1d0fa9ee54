//! Abscissae that stand before each value, read while a file is opened: they decide what axis a
//! function has.

use std::io;

use crate::io::formats::uff::dataset_58::axis::Abscissae;
use crate::io::formats::uff::dataset_58::binary_samples::{BinaryBlock, read_abscissa};
use crate::io::formats::uff::dataset_58::text_samples::{TextBlock, copy_abscissa, read_text};
use crate::io::formats::uff::fields::lines::LineReader;
use crate::io::{IoError, ReadSeek};

/// Abscissae of a text block, with how exactly they were printed.
pub(super) fn text_abscissae(
    lines: &mut LineReader<Box<dyn ReadSeek>>,
    block: &TextBlock,
    path: &str,
) -> io::Result<Result<Abscissae, IoError>> {
    let read = lines.with_input(|input| read_text(input.as_mut(), block, true, path))?;
    Ok(read.map(|numbers| {
        let mut values = Vec::new();
        copy_abscissa(
            &numbers.values,
            block,
            0..block.points as usize,
            &mut values,
        );
        let half_units = numbers.half_units.map(|(_, half_units)| half_units);
        Abscissae {
            values,
            half_units: half_units.unwrap_or_default(),
        }
    }))
}

/// Abscissae of a binary block; in single precision each is off by half its last bit.
pub(super) fn binary_abscissae(
    lines: &mut LineReader<Box<dyn ReadSeek>>,
    block: &BinaryBlock,
    points: u64,
) -> io::Result<Abscissae> {
    let mut values = Vec::new();
    let range = 0..points as usize;
    lines.with_input(|input| read_abscissa(input, block, range, &mut values))??;
    let half_bit = |value: &f64| match block.abscissa_bytes {
        4 => value.abs() * f64::from(f32::EPSILON) / 2.0,
        _ => 0.0,
    };
    let half_units = values.iter().map(half_bit).collect();
    Ok(Abscissae { values, half_units })
}

//! Datasets 55 and 2414 share the description of values and the values at nodes.

use std::collections::BTreeSet;

use num_complex::Complex64;

use crate::io::formats::uff::fields::records::{Records, is_label};
use crate::io::formats::uff::fields::{FieldError, Line, integer, integer_or_zero, numeric_record};

/// The meaning of the values of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) struct Definition {
    /// 2 normal mode, 3 complex eigenvalue of first, 7 of second order; others are no modes.
    pub analysis: i64,
    /// 1 scalar, 2 translations, 3 translations and rotations, 4 and higher tensors, 0 unknown.
    pub characteristic: i64,
    /// 8 displacement, 11 velocity, 12 acceleration, 0 unknown, 1 general, others no motion.
    pub quantity: i64,
    pub complex: bool,
    /// Values at a node.
    pub per_node: usize,
}

impl Definition {
    /// Reads the record with six fields.
    pub fn read(line: &Line) -> Result<Self, FieldError> {
        let what = "record of what the data at nodes are";
        let refuse = |expected: &str| FieldError::line(line, what, expected);
        let parse = |fields: &[&[u8]]| {
            let mut numbers = [0i64; 6];
            for (number, field) in numbers.iter_mut().zip(fields) {
                *number = integer_or_zero(field)?;
            }
            Some(numbers)
        };
        let [_, analysis, characteristic, quantity, data_type, per_node] =
            numeric_record(&line.bytes, &[10; 6], parse)
                .ok_or_else(|| refuse("six whole numbers"))?;
        let complex = match data_type {
            1 | 2 | 4 => false,
            5 | 6 => true,
            _ => return Err(refuse("data type 1, 2, 4 (real), 5 or 6 (complex)")),
        };
        let per_node = usize::try_from(per_node).ok().filter(|count| *count > 0);
        Ok(Self {
            analysis,
            characteristic,
            quantity,
            complex,
            per_node: per_node.ok_or_else(|| refuse("a positive number of values per node"))?,
        })
    }

    /// Whether the values are the shape of a mode: one, three or six values of motion at a node.
    pub fn is_mode(&self) -> bool {
        matches!(self.analysis, 2 | 3 | 7)
            && matches!(self.characteristic, 0..=3)
            && matches!(self.quantity, 0 | 1 | 8 | 11 | 12)
            && matches!(self.per_node, 1 | 3 | 6)
    }
}

/// Reads the nodes and their values to the end of the dataset.
pub(super) fn node_values(
    records: &mut Records<'_>,
    definition: Definition,
) -> Result<(Vec<i64>, Vec<Complex64>), FieldError> {
    let parts = definition.per_node * if definition.complex { 2 } else { 1 };
    let (mut nodes, mut values, mut row) = (Vec::new(), Vec::new(), Vec::new());
    let mut known = BTreeSet::new();
    while let Some(line) = records.peek() {
        let label = integer(&line.bytes).filter(|label| *label > 0);
        let refuse = || FieldError::line(line, "node of data at nodes", "a positive node label");
        let label = label.ok_or_else(refuse)?;
        if !known.insert(label) {
            let expected = "each node once in a mode";
            return Err(FieldError::line(line, "node of data at nodes", expected));
        }
        nodes.push(label);
        records.filled("node of data at nodes")?;
        row.clear();
        records.numbers(parts, 13, "values at a node", &mut row)?;
        if definition.complex {
            let pairs = row.chunks_exact(2);
            values.extend(pairs.map(|pair| Complex64::new(pair[0], pair[1])));
        } else {
            values.extend(row.iter().map(|value| Complex64::new(*value, 0.0)));
        }
    }
    Ok((nodes, values))
}

/// Reads `count` parameters of an analysis, of which the last may be missing; the label of a node
/// ends them.
pub(super) fn real_parameters(
    records: &mut Records<'_>,
    count: usize,
) -> Result<Vec<f64>, FieldError> {
    let what = "parameters of an analysis";
    let mut numbers = Vec::new();
    while numbers.len() < count {
        if records.peek().is_none_or(is_label) {
            break;
        }
        let line = records.number_row(13, what, &mut numbers)?;
        if numbers.len() > count {
            return Err(FieldError::line(line, what, &format!("{count} numbers")));
        }
    }
    Ok(numbers)
}

/// The parameters of an analysis of dataset 2414.
pub(super) struct TwoRows<'a> {
    /// The first of their lines.
    pub at: &'a Line,
    /// Twelve numbers; those that are not stated are 0.
    pub numbers: Vec<f64>,
    /// How many of the first and of the last six are stated.
    pub stated: [usize; 2],
}

/// Reads twelve parameters on two lines, either of which may be short.
pub(super) fn two_rows_of_parameters<'a>(
    records: &mut Records<'a>,
) -> Result<TwoRows<'a>, FieldError> {
    let what = "parameters of an analysis";
    let mut numbers = Vec::new();
    let at = records.number_row(13, what, &mut numbers)?;
    let first = numbers.len();
    if first == 12 {
        let stated = [6, 6];
        return Ok(TwoRows {
            at,
            numbers,
            stated,
        });
    }
    if first > 6 {
        return Err(FieldError::line(at, what, "six numbers"));
    }
    numbers.resize(6, 0.0);
    let line = records.number_row(13, what, &mut numbers)?;
    let second = numbers.len() - 6;
    if second > 6 {
        return Err(FieldError::line(line, what, "six numbers"));
    }
    numbers.resize(12, 0.0);
    let stated = [first, second];
    Ok(TwoRows {
        at,
        numbers,
        stated,
    })
}

/// The error of a mode without a stated frequency or eigenvalue; `line` is the line where it should
/// be.
pub(super) fn no_root(line: &Line, stated: usize) -> FieldError {
    FieldError {
        at: line.at,
        what: "parameters of a mode",
        got: format!("{stated} numbers"),
        expected: "a frequency, or the real and imaginary part of an eigenvalue".to_owned(),
    }
}

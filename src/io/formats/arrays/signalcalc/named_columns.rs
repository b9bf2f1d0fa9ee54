//! Names and columns of the arrays: `H1_2` is a function of two channels, `X1` a record of one.

use crate::io::formats::arrays::store::{Elements, NamedArray};
use crate::io::{ArrayInfo, Block, FunctionType, IoError};

/// A function of two channels by the name of its array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FunctionName {
    pub function_type: FunctionType,
    pub reference: u32,
    pub response: u32,
}

/// The function that an array holds: `H1_2` where it is complex, `C1_2` where it is real, with the
/// columns of an axis and of values.
pub(super) fn function_of(info: &ArrayInfo) -> Option<FunctionName> {
    let function_type = match (info.name.get(..1)?, info.kind.starts_with("complex")) {
        ("H", true) => FunctionType::Frf,
        ("C", false) if info.kind != "text" => FunctionType::Coherence,
        _ => return None,
    };
    let (reference, response) = info.name[1..].split_once('_')?;
    let name = FunctionName {
        function_type,
        reference: channel_number(reference)?,
        response: channel_number(response)?,
    };
    matches!(info.shape.as_slice(), [_, 2]).then_some(name)
}

/// The channel of `X1` for the letter X.
pub(super) fn record_channel(info: &ArrayInfo, letter: char) -> Option<u32> {
    let channel = channel_number(info.name.strip_prefix(letter)?)?;
    matches!(info.shape.as_slice(), [_, 2]).then_some(channel)
}

fn channel_number(text: &str) -> Option<u32> {
    let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| is_number)
}

/// The two columns of an array: an axis, and values.
pub(super) struct AxisAndValues {
    pub axis: Vec<f64>,
    pub values: Block,
}

pub(super) fn columns_of(array: NamedArray, path: &str) -> Result<AxisAndValues, IoError> {
    let real = |values: Vec<f64>| AxisAndValues {
        axis: values.iter().copied().step_by(2).collect(),
        values: Block::F64(values.into_iter().skip(1).step_by(2).collect()),
    };
    match array.elements {
        Elements::F64(values) => Ok(real(values)),
        Elements::F32(values) => Ok(real(values.into_iter().map(f64::from).collect())),
        Elements::Complex(values) => Ok(AxisAndValues {
            axis: values.iter().map(|value| value.re).step_by(2).collect(),
            values: Block::Complex(values.into_iter().skip(1).step_by(2).collect()),
        }),
        Elements::Text(_) => Err(IoError::Grouping {
            path: path.to_owned(),
            what: "reading an array of an axis and values",
            got: format!("texts in {}", array.name),
            expected: "numbers".to_owned(),
        }),
    }
}

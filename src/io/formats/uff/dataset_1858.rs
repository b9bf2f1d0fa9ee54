//! Dataset 1858, qualifiers of the function (58) that it stands beside.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 6 I12 | record number, octave format, run number, not used |
//! | 2 | 12 I6 | weighting, **window type** (1 Hann narrow, 2 Hann broad, 3 flat top, 4 exponential, 5 impact, 6 impact and exponential), amplitude units, normalization, data type qualifiers, sampling, not used |
//! | 3-5 | 5 E15.7 | z values and number of samples; user values and the exponential window's damping factor; not used |
//! | 6, 7 | | response and reference direction; not used |
//!
//! The window alone is read and written, all else is 0. The damping factor has no stated unit, so
//! it is no decay rate. The dataset is written behind its function.

use std::io::{self, Write};

use super::fields::{FieldError, Line, columns, integer, integer_or_zero, words};
use crate::io::Window;

/// The window of a function; `first` is the dataset's first line, for messages.
pub(super) fn window(lines: &[Line], first: &Line) -> Result<Option<Window>, FieldError> {
    let refuse = |line: &Line| {
        let expected = "weighting, window type and ten further numbers";
        FieldError::line(line, "qualifiers of dataset 1858", expected)
    };
    let [_, types, ..] = lines else {
        return Err(refuse(lines.first().unwrap_or(first)));
    };
    let words = words(&types.bytes);
    let code = match words.get(1) {
        Some(word) => integer(word),
        None => integer_or_zero(columns(&types.bytes, &[6, 6])[1]),
    };
    code.map(Window::from_code).ok_or_else(|| refuse(types))
}

/// Writes the window of the function that stands before.
pub(super) fn write(out: &mut dyn Write, window: Window) -> io::Result<()> {
    let first = format!("{:>12}", 0).repeat(6);
    let unknown = format!("{:>6}", 0);
    let second = format!("{unknown}{:>6}{}", window.code(), unknown.repeat(10));
    let zeros = "  0.0000000E+00".repeat(5);
    let rows = format!("{zeros}\n").repeat(3);
    write!(
        out,
        "    -1\n  1858\n{first}\n{second}\n{rows}NONE  NONE\nNONE\n    -1\n"
    )
}

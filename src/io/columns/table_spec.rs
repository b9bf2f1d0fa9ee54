//! A scene describes a table of numbers whose file does not state the meaning of its columns.

use crate::dof::Dof;
use crate::quantity::{FrfUnit, Unit};

/// The separator of the fields of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delimiter {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// Tabulator.
    Tab,
    /// Any run of blanks and tabulators.
    Blank,
}

/// Which column of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ColumnName {
    /// By its heading.
    Heading(String),
    /// By its number from 1.
    Number(usize),
}

/// The role of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnRole {
    /// Time, s.
    Time,
    /// Frequency, Hz.
    Frequency,
    /// Force of the hammer at this excitation point (`None`: the file's reference says).
    Force {
        /// Hit point.
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: Unit,
    },
    /// A response (`None`: the file's response says).
    Response {
        /// Where it measures.
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: Unit,
    },
    /// Real part of an FRF.
    Real {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: FrfUnit,
    },
    /// Imaginary part of the FRF whose real part has the same response.
    Imaginary {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: FrfUnit,
    },
    /// An FRF as complex numbers.
    Complex {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: FrfUnit,
    },
    /// Magnitude of an FRF.
    Magnitude {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
        /// Unit of the numbers.
        unit: FrfUnit,
    },
    /// Phase, in degrees, of the FRF whose magnitude has the same response.
    PhaseDegrees {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
    },
    /// Coherence of the FRF with the same response.
    Coherence {
        /// Response (`None`: the file's response says).
        dof: Option<Dof>,
    },
}

/// The meaning of one dimension of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Hits, one after the other.
    Hit,
    /// Channels; a channel's number in the scene is its place here, from 1.
    Channel,
    /// Samples of a channel, or lines of a function.
    Sample,
}

/// One column that is to be read.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Which one.
    pub column: ColumnName,
    /// Its role.
    pub role: ColumnRole,
    /// Calibration: value in the stated unit = `scale` × number in the file.
    pub scale: f64,
}

/// How to read a table. Columns that are not named are passed over.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TableSpec {
    /// Field separator; `None`: judged by the content.
    pub delimiter: Option<Delimiter>,
    /// Lines that are passed over before the heading is looked for.
    pub skip_lines: usize,
    /// The meaning of the dimensions of an array, slowest first; `None`: rows are samples and
    /// columns are channels.
    pub dimensions: Option<Vec<Dimension>>,
    /// Samples per second, where no time column says.
    pub sampling_rate_hz: Option<f64>,
    /// Factor of the stated unit of the time or frequency column to s or Hz; `None`: the heading
    /// says, or else s or Hz.
    pub axis_to_si: Option<f64>,
    /// Columns.
    pub columns: Vec<TableColumn>,
}

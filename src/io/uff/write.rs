//! Universal files out: hammer-test records and FRF sets, in SI units, with title (151) and units (164).
//!
//! What the format cannot hold is lost: the origin of a hit, the number of a repeated measurement (`#2`; the functions
//! stay in their order), the variance of FRFs, steps and starts beyond seven digits (a time step of a whole number of
//! samples per second comes back exactly), and digits beyond thirteen in text. An FRF's averages, estimator, added
//! damping, record length and valid band stand in ID lines 4 and 5, as far as they are known ([`FunctionNote`]).

use std::io::{self, Write};

use super::dataset_58_write::{Abscissa, FunctionHeader, line_text, write_binary, write_text};
use super::dof_fields::DofFields;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function};
use crate::io::{FunctionNote, FunctionType, IoError, SampleFormat};
use crate::quantity::Quantity;
use crate::record::{Channel, Hit, Role};

/// Version numbers fill at most 4 of their 5 columns, so that fields stay apart.
const MOST_HITS: usize = 9_999;

/// What a file says beyond its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileLabel<'a> {
    /// Path, for messages.
    pub path: &'a str,
    /// Title, in dataset 151 and the first ID line.
    pub title: &'a str,
}

/// Width of the numbers of a binary block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32 bits, as measurement systems export.
    #[default]
    Single,
    /// 64 bits.
    Double,
}

/// How the values of a function are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Encoding {
    /// 58b, 64 bits, to the bit.
    #[default]
    Binary,
    /// 58, 13 digits.
    Text,
}

/// Writes hits as a measurement system exports them: datasets 151, 164 and, hit after hit, the force and then the
/// responses as time records (58b, little endian) with the hit's number as version. The force record's response is the
/// hit point; the responses' reference is it too. Values are in SI units.
///
/// # Errors
/// [`IoError::Unwritable`] for a channel whose length is not the axis's, a step that is not positive, a sample that
/// overflows single precision or more than 9,999 hits; [`IoError::Dof`] for a degree of freedom that has no fields;
/// [`IoError::System`] when writing fails.
pub fn write_time_records(
    out: &mut dyn Write,
    label: &FileLabel<'_>,
    hits: &[Hit],
    precision: Precision,
) -> Result<(), IoError> {
    check_hits(label, hits)?;
    let system = |source| write_failed(label, source);
    write_head(out, label).map_err(system)?;
    for (i, hit) in hits.iter().enumerate() {
        for channel in channels(hit) {
            let mut header = record_header(label, hit, channel)?;
            header.id_lines[1] = format!("hit {}", i + 1);
            header.version = i + 1;
            if precision == Precision::Double {
                header.format = SampleFormat::RealF64;
            }
            let bytes = sample_bytes(label, channel, precision)?;
            write_binary(out, &header, &bytes).map_err(system)?;
        }
    }
    Ok(())
}

/// The force, then the responses.
fn channels(hit: &Hit) -> impl Iterator<Item = &Channel> {
    std::iter::once(&hit.force).chain(&hit.responses)
}

/// The header of a channel in single precision.
fn record_header(
    label: &FileLabel<'_>,
    hit: &Hit,
    channel: &Channel,
) -> Result<FunctionHeader, IoError> {
    let reference = match channel.role {
        Role::Force => DofFields::none(),
        Role::Response => dof_fields(label, &hit.force.dof)?,
    };
    Ok(FunctionHeader {
        id_lines: id_lines(label, &Default::default()),
        function_type: FunctionType::Time.code(),
        version: 0,
        load_case: 1,
        response: dof_fields(label, &channel.dof)?,
        reference,
        format: SampleFormat::RealF32,
        points: channel.samples.len(),
        abscissa: Abscissa {
            time: true,
            start: hit.axis.start_s,
            step: hit.axis.step_s,
        },
        numerator: Some(channel.quantity),
        denominator: None,
    })
}

/// Writes an FRF set: datasets 151, 164, every function (type 4, complex of 64 bits, numerator and denominator by kind),
/// then the coherences that there are (type 6, real of 64 bits) with the same degrees of freedom. See the module head for
/// what is lost.
///
/// # Errors
/// [`IoError::Unwritable`] for a step that is not positive; [`IoError::Dof`] for a degree of freedom that has no fields;
/// [`IoError::System`] when writing fails.
pub fn write_frfs(
    out: &mut dyn Write,
    label: &FileLabel<'_>,
    set: &FrfSet,
    encoding: Encoding,
) -> Result<(), IoError> {
    check_axis(label, set.axis().start_hz, set.axis().step_hz)?;
    for function in set.functions() {
        dof_fields(label, &function.response)?;
        dof_fields(label, &function.reference)?;
    }
    let system = |source| write_failed(label, source);
    write_head(out, label).map_err(system)?;
    for (i, function) in set.functions().iter().enumerate() {
        let mut header = function_header(label, set, function)?;
        header.function_type = FunctionType::Frf.code();
        header.format = SampleFormat::ComplexF64;
        header.numerator = Some(function.kind.response_quantity());
        header.denominator = Some(Quantity::Force);
        let numbers: Vec<f64> = set.values(i).iter().flat_map(|h| [h.re, h.im]).collect();
        write_function(out, &header, &numbers, encoding).map_err(system)?;
    }
    for (i, function) in set.functions().iter().enumerate() {
        if let Some(coherence) = set.coherence(i) {
            let header = function_header(label, set, function)?;
            write_function(out, &header, coherence, encoding).map_err(system)?;
        }
    }
    Ok(())
}

/// The header of a coherence; an FRF differs by type and ordinate.
fn function_header(
    label: &FileLabel<'_>,
    set: &FrfSet,
    function: &Function,
) -> Result<FunctionHeader, IoError> {
    Ok(FunctionHeader {
        id_lines: id_lines(label, &known(set, function)),
        function_type: FunctionType::Coherence.code(),
        version: 0,
        load_case: 0,
        response: dof_fields(label, &function.response)?,
        reference: dof_fields(label, &function.reference)?,
        format: SampleFormat::RealF64,
        points: set.axis().len,
        abscissa: Abscissa {
            time: false,
            start: set.axis().start_hz,
            step: set.axis().step_hz,
        },
        numerator: None,
        denominator: None,
    })
}

fn write_function(
    out: &mut dyn Write,
    header: &FunctionHeader,
    numbers: &[f64],
    encoding: Encoding,
) -> io::Result<()> {
    match encoding {
        Encoding::Text => write_text(out, header, numbers),
        Encoding::Binary => {
            let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
            write_binary(out, header, &bytes)
        }
    }
}

/// ID lines 4 and 5: what is known of an FRF beyond its values.
fn known(set: &FrfSet, function: &Function) -> [String; 2] {
    let note = FunctionNote {
        averages: function.averages,
        estimator: function.estimator,
        added_damping_rad_s: Some(set.added_damping_rad_s).filter(|decay| *decay > 0.0),
        record_s: set.record_duration_s,
        valid_hz: set.valid_band.map(|band| (band.lo_hz, band.hi_hz)),
    };
    note.to_lines()
}

fn id_lines(label: &FileLabel<'_>, [fourth, fifth]: &[String; 2]) -> [String; 5] {
    let mut lines: [String; 5] = Default::default();
    lines[0] = line_text(label.title);
    lines[3] = fourth.clone();
    lines[4] = fifth.clone();
    lines
}

/// Datasets 151 and 164. No date is written: the same data give the same bytes.
fn write_head(out: &mut dyn Write, label: &FileLabel<'_>) -> io::Result<()> {
    let title = line_text(label.title);
    let title = if title.is_empty() { "NONE" } else { &title };
    let head = format!("    -1\n   151\n{title}\nNONE\nmodalign\n\n\nmodalign\n\n    -1\n");
    out.write_all(head.as_bytes())?;
    let one = "  1.00000000000000000D+00";
    let offset = "  2.73149999999999977D+02";
    let units = format!(
        "    -1\n   164\n{:>10}{:<20}{:>10}\n{one}{one}{one}\n{offset}\n    -1\n",
        1, "SI: Meter (newton)", 2
    );
    out.write_all(units.as_bytes())
}

fn check_hits(label: &FileLabel<'_>, hits: &[Hit]) -> Result<(), IoError> {
    if hits.len() > MOST_HITS {
        let expected = format!("at most {MOST_HITS}");
        return Err(unwritable(
            label,
            "number of hits",
            hits.len().to_string(),
            expected,
        ));
    }
    for hit in hits {
        check_axis(label, hit.axis.start_s, hit.axis.step_s)?;
        for channel in channels(hit) {
            dof_fields(label, &channel.dof)?;
            if channel.samples.len() != hit.axis.len {
                let got = format!("{} of {}", channel.samples.len(), channel.dof);
                let expected = format!("{} (the axis)", hit.axis.len);
                return Err(unwritable(label, "number of samples", got, expected));
            }
        }
    }
    Ok(())
}

fn check_axis(label: &FileLabel<'_>, start: f64, step: f64) -> Result<(), IoError> {
    if step > 0.0 && step.is_finite() && start.is_finite() {
        return Ok(());
    }
    let got = format!("start {start}, step {step}");
    let expected = "a finite start and a positive step".to_owned();
    Err(unwritable(label, "axis", got, expected))
}

fn sample_bytes(
    label: &FileLabel<'_>,
    channel: &Channel,
    precision: Precision,
) -> Result<Vec<u8>, IoError> {
    let values = channel.samples.iter().map(|v| v * channel.to_si);
    if precision == Precision::Double {
        return Ok(values.flat_map(f64::to_le_bytes).collect());
    }
    let mut bytes = Vec::with_capacity(channel.samples.len() * 4);
    for value in values {
        let single = value as f32;
        if value.is_finite() && single.is_infinite() {
            let expected = "at most 3.4e38 in single precision".to_owned();
            return Err(unwritable(label, "sample", value.to_string(), expected));
        }
        bytes.extend(single.to_le_bytes());
    }
    Ok(bytes)
}

fn dof_fields(label: &FileLabel<'_>, dof: &Dof) -> Result<DofFields, IoError> {
    DofFields::from_dof(dof).map_err(|source| IoError::Dof {
        path: label.path.to_owned(),
        source,
    })
}

fn unwritable(label: &FileLabel<'_>, what: &'static str, got: String, expected: String) -> IoError {
    IoError::Unwritable {
        path: label.path.to_owned(),
        what,
        got,
        expected,
    }
}

fn write_failed(label: &FileLabel<'_>, source: io::Error) -> IoError {
    IoError::System {
        path: label.path.to_owned(),
        action: "write",
        source,
    }
}

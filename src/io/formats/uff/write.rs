//! Universal files out: title (151), units (164, SI), geometry, modes, and every function as 58b
//! or 58.
//!
//! Values are written as they are stored, with their unit in the header; a factor to SI that no
//! unit has makes them SI values. What the format has no field for goes into ID lines 4 and 5
//! (`dataset_58::entry_header`), so that bytes come back to the bit; text keeps 13 digits of 64
//! bits, 6 of 32 and 7 of uneven abscissae; the latter two are reported. Lost are the origin of a
//! hit, variances, and arrays without a meaning.

use std::io::{self, Write};

use super::dataset_1858;
use crate::dof::Dof;
use crate::finding::Finding;
use crate::frf::FrfSet;
use crate::io::error::write_failed;
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::formats::uff::dataset_58::dof_fields::DofFields;
use crate::io::formats::uff::dataset_58::entry_header::{Fitted, fit};
use crate::io::formats::uff::dataset_58::write_values::{Target, written_format};
use crate::io::formats::uff::fields::fixed_columns::line_text;
use crate::io::formats::uff::geometry::write::write_geometry;
use crate::io::formats::uff::modes::write::write_modes;
use crate::io::{
    Encoding, FunctionType, IoError, Precision, Source, Window, WriteOptions, frf_source,
    hit_source,
};
use crate::record::{Channel, Hit};

/// Version numbers fill at most 4 of their 5 columns, so that fields stay apart.
const MAX_HITS: usize = 9_999;
/// Lines of dataset 151, of which the sixth is the program that wrote the file.
const TITLE_LINES: usize = 7;

/// The description of a file beyond its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileLabel<'a> {
    /// Path, for messages.
    pub path: &'a str,
    /// Title, in dataset 151 and the first ID line.
    pub title: &'a str,
}

/// Writes a source; `in_si` asks for values in SI units.
pub(super) fn write_source(
    out: &mut dyn Write,
    source: &mut dyn Source,
    options: &WriteOptions,
    in_si: bool,
) -> Result<Vec<Finding>, IoError> {
    let mut lost = DroppedContent::default();
    let count = source.catalog().entries.len();
    let mut targets = Vec::new();
    for entry in 0..count {
        let entry = &source.catalog().entries[entry];
        let Some(function_type) = entry.function_type.code() else {
            lost.add("variance of FRFs", 1);
            targets.push(None);
            continue;
        };
        let format = written_format(entry.format, options.precision);
        let Fitted {
            header,
            factor,
            lost: kinds,
        } = fit(entry, function_type, format, in_si, &options.path)?;
        for kind in kinds {
            lost.add(kind, 1);
        }
        targets.push(Some(Target::new(header, factor, options)));
    }
    let catalog = source.catalog();
    let title_lost = catalog.title.len().saturating_sub(TITLE_LINES - 1);
    lost.add("arrays without a meaning", catalog.arrays.len());
    lost.add("title lines", title_lost);
    write_head(out, &catalog.title).map_err(|source| write_failed(&options.path, source))?;
    let (geometry, path) = (&catalog.geometry, &options.path);
    let mut findings = write_geometry(out, geometry, path)?;
    let title = catalog.title.first().map_or("", String::as_str);
    findings.extend(write_modes(out, &catalog.modes, geometry, title, path)?);
    for (entry, target) in targets.into_iter().enumerate() {
        if let Some(target) = target {
            target.write(out, source, entry, &mut lost)?;
            match source.catalog().entries[entry].note.window {
                // Dataset 1858 has one number for no window and an unknown one.
                Some(Window::Rectangular) => lost.add("statements of no window", 1),
                Some(window) => dataset_1858::write(out, window)
                    .map_err(|source| write_failed(&options.path, source))?,
                None => {}
            }
        }
    }
    findings.extend(lost.findings());
    Ok(findings)
}

/// Writes hits as a measurement system exports them: datasets 151, 164 and, hit after hit, the
/// force and then the responses as time records (58b, little endian) with the hit's number as
/// version. The force record's response is the excitation point; the responses' reference is it
/// too. Values are in SI units.
///
/// # Errors
/// [`IoError::Unwritable`] for a channel whose length is not the axis's, a step that is not
/// positive, a sample that overflows single precision or more than 9,999 hits; [`IoError::Dof`] for
/// a degree of freedom that has no fields; [`IoError::System`] when writing fails.
pub fn write_time_records(
    out: &mut dyn Write,
    label: &FileLabel<'_>,
    hits: &[Hit],
    precision: Precision,
) -> Result<(), IoError> {
    check_hits(label, hits)?;
    let options = WriteOptions {
        path: label.path.to_owned(),
        encoding: Encoding::Binary,
        precision: Some(precision),
    };
    let source = &mut hit_source(hits, label.title);
    write_source(out, source, &options, true).map(|_| ())
}

/// Writes an FRF set: datasets 151, 164, every function (type 4, complex of 64 bits, numerator and
/// denominator by kind), then the coherences that there are (type 6, real of 64 bits) with the same
/// degrees of freedom. Variances are lost.
///
/// # Errors
/// [`IoError::Unwritable`] for a step that is not positive; [`IoError::Dof`] for a degree of
/// freedom that has no fields; [`IoError::System`] when writing fails.
pub fn write_frfs(
    out: &mut dyn Write,
    label: &FileLabel<'_>,
    set: &FrfSet,
    encoding: Encoding,
) -> Result<(), IoError> {
    check_axis(label, set.axis().start_hz, set.axis().step_hz)?;
    let options = WriteOptions {
        path: label.path.to_owned(),
        encoding,
        precision: None,
    };
    let mut source = frf_source(set, label.title);
    let number = source.catalog.entries.iter().position(is_variance);
    if let Some(first) = number {
        source.catalog.entries.truncate(first);
    }
    write_source(out, &mut source, &options, false).map(|_| ())
}

fn is_variance(entry: &crate::io::Entry) -> bool {
    entry.function_type == FunctionType::Variance
}

/// Datasets 151 and 164. No date is written: the same data give the same bytes.
fn write_head(out: &mut dyn Write, title: &[String]) -> io::Result<()> {
    let mut lines: Vec<String> = title.iter().map(|line| line_text(line)).collect();
    lines.truncate(TITLE_LINES - 1);
    lines.resize(TITLE_LINES - 1, "NONE".to_owned());
    lines.insert(TITLE_LINES - 2, "modalign".to_owned());
    write!(out, "    -1\n   151\n{}\n    -1\n", lines.join("\n"))?;
    let one = "  1.00000000000000000D+00";
    let offset = "  2.73149999999999977D+02";
    write!(
        out,
        "    -1\n   164\n{:>10}{:<20}{:>10}\n{one}{one}{one}\n{offset}\n    -1\n",
        1, "SI: Meter (newton)", 2
    )
}

fn check_hits(label: &FileLabel<'_>, hits: &[Hit]) -> Result<(), IoError> {
    if hits.len() > MAX_HITS {
        let expected = format!("at most {MAX_HITS}");
        return Err(unwritable(
            label,
            "number of hits",
            hits.len().to_string(),
            expected,
        ));
    }
    for hit in hits {
        check_axis(label, hit.axis.start_s, hit.axis.step_s)?;
        for channel in std::iter::once(&hit.force).chain(&hit.responses) {
            check_dof(label, &channel.dof)?;
            check_channel(label, hit, channel)?;
        }
    }
    Ok(())
}

fn check_channel(label: &FileLabel<'_>, hit: &Hit, channel: &Channel) -> Result<(), IoError> {
    if channel.samples.len() == hit.axis.len {
        return Ok(());
    }
    let got = format!("{} of {}", channel.samples.len(), channel.dof);
    let expected = format!("{} (the axis)", hit.axis.len);
    Err(unwritable(label, "number of samples", got, expected))
}

fn check_axis(label: &FileLabel<'_>, start: f64, step: f64) -> Result<(), IoError> {
    if step > 0.0 && step.is_finite() && start.is_finite() {
        return Ok(());
    }
    let got = format!("start {start}, step {step}");
    let expected = "a finite start and a positive step".to_owned();
    Err(unwritable(label, "axis", got, expected))
}

fn check_dof(label: &FileLabel<'_>, dof: &Dof) -> Result<(), IoError> {
    let fields = DofFields::from_dof(dof).map(|_| ());
    fields.map_err(|source| IoError::Dof {
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

//! Modes as a table, one row for each: `.csv`.
//!
//! ```text
//! frequency_hz,damping_ratio,group,1:+Z,2:+Z
//! 12.25,0.004,,1,0.62
//! 31.5,,1,0.3,-0.8
//! ```
//!
//! The heading begins with `frequency_hz` (also `frequency [Hz]`, `f_hz`, `f [Hz]`, round brackets
//! likewise) and `damping_ratio`. A table without shapes may have no damping ratios. One column of
//! frequencies needs no heading where the file is opened as this format. Commas, semicolons or
//! tabulators part the cells, `#` (blanks may stand before it) begins a line of remarks, a line
//! whose cells are all empty is skipped. An empty cell or `NaN` is a value that is not known: a
//! degree of freedom without one is not in that shape. Where cells are not parted by commas, a
//! number may have a decimal comma. The text is UTF-8 or UTF-16.
//!
//! | column | meaning |
//! |---|---|
//! | `mode` | a number or a name of the mode, anywhere in the row; not read (also `mode no`, `no`, `nr`, `#`) |
//! | `frequency_hz` | natural frequency, Hz, 0 or more |
//! | `damping_ratio` | a fraction |
//! | `frequency_std_hz`, `damping_std` | their standard deviations, 0 or more |
//! | `group` | a whole number; modes of one repeated root have the same |
//! | `modal_mass_kg` | modal mass, above 0 |
//! | `scaling` | `unit-modal-mass`, `unit-max` or `unknown` (also without the column) |
//! | `1:+Z` | the shape at this degree of freedom, real |
//! | `1:+Z re`, `1:+Z im` | its real and imaginary part, both or none |
//!
//! Damping ratios in percent are recognised and divided by 100, unless a line of remarks is
//! `# damping ratios are fractions`.
//!
//! A degree of freedom stands there with one sign: `1:+Z` and `1:-Z` are one.

use crate::finding::Finding;
use crate::modal::Mode;

use super::damping_ratios::{StatedMode, correct_damping_ratios};
use super::text_coding::{decoded_bytes, decoded_head};
use crate::io::{
    Catalog, Confidence, Format, Hints, IoError, MemorySource, ReadSeek, Source, WriteOptions,
    WriteSeek,
};

mod column;
mod read;
#[cfg(test)]
mod tests;
mod write;

use read::{heading, read, states_fractions};
use write::{dropped_content, text, unwritable};

/// A table of modes.
pub struct ModesCsv;

impl Format for ModesCsv {
    fn name(&self) -> &'static str {
        "modes-csv"
    }

    fn written_extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    /// Modes and no functions, which another table holds.
    fn takes(&self, catalog: &Catalog) -> bool {
        !catalog.modes.is_empty() && catalog.entries.is_empty()
    }

    /// Certain for a heading that begins as this format's.
    fn detect(&self, head: &[u8]) -> Confidence {
        if heading(&decoded_head(head)).1.is_some() {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(&self, input: Box<dyn ReadSeek>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
        let bytes = decoded_bytes(input, &hints.path)?;
        let (mut modes, damage) = read(&bytes, &hints.path)?;
        let stated = modes.iter_mut().map(|entry| StatedMode {
            mode: &mut entry.mode,
            line: entry.line,
        });
        let findings = match states_fractions(&bytes) {
            true => Vec::new(),
            false => correct_damping_ratios(&mut stated.collect::<Vec<_>>(), &hints.path),
        };
        let mut catalog = Catalog {
            format: "modes-csv",
            path: hints.path.clone(),
            modes,
            findings,
            ..Catalog::default()
        };
        for error in damage {
            catalog.note_damage(error, crate::io::Part::Mode);
        }
        Ok(Box::new(MemorySource {
            catalog,
            ..MemorySource::default()
        }))
    }

    /// Writes the modes; records, functions, geometry, residues and what tells of an identification
    /// are not carried.
    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        let catalog = source.catalog();
        let modes: Vec<&Mode> = catalog.modes.iter().map(|entry| &entry.mode).collect();
        if modes.is_empty() {
            return Err(IoError::Unwritable {
                path: options.path.clone(),
                what: "modes",
                got: "a file without modes".to_owned(),
                expected: "modes; identify them first".to_owned(),
            });
        }
        let text = text(&modes);
        // What this reader refuses is not written.
        let refused = match read(text.as_bytes(), &options.path) {
            Ok((_, damage)) => damage.into_iter().next(),
            Err(error) => Some(error),
        };
        if let Some(error) = refused {
            return Err(unwritable(error, &options.path));
        }
        out.write_all(text.as_bytes())
            .map_err(|source| IoError::System {
                path: options.path.clone(),
                action: "write",
                source,
            })?;
        Ok(dropped_content(catalog))
    }
}

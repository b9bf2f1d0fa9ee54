//! Modes as a table, one row for each: `.csv`.
//!
//! ```text
//! frequency_hz,damping_ratio,group,1:+Z,2:+Z
//! 12.25,0.004,,1,0.62
//! 31.5,,1,0.3,-0.8
//! ```
//!
//! The heading begins with `frequency_hz` and `damping_ratio`; commas, semicolons or tabulators part the cells, `#` begins a
//! line of remarks. An empty cell is a value that is not known: a degree of freedom without one is not in that shape.
//!
//! | column | meaning |
//! |---|---|
//! | `frequency_hz` | natural frequency, Hz, 0 or more |
//! | `damping_ratio` | a fraction |
//! | `frequency_std_hz`, `damping_std` | their standard deviations |
//! | `group` | a whole number; modes of one repeated root have the same |
//! | `modal_mass_kg` | modal mass |
//! | `scaling` | `unit-modal-mass`, `unit-max` or `unknown` (also without the column) |
//! | `1:+Z` | the shape at this degree of freedom, real |
//! | `1:+Z re`, `1:+Z im` | its real and imaginary part, both or none |

use std::collections::BTreeMap;
use std::io::Read;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::Finding;
use crate::modal::{Mode, ModeShape, Scaling};

use super::not_carried::NotCarried;
use super::{
    Catalog, Confidence, Format, Hints, IoError, MemorySource, ModeEntry, ReadSeek, Source,
    WriteOptions, WriteSeek,
};

/// A table of modes.
pub struct ModesCsv;

/// The first two headings, by which the format is known.
const FIRST: [&str; 2] = ["frequency_hz", "damping_ratio"];
const DELIMITERS: [u8; 3] = [b',', b';', b'\t'];

impl Format for ModesCsv {
    fn name(&self) -> &'static str {
        "modes-csv"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    /// Modes and no functions, which another table holds.
    fn takes(&self, catalog: &Catalog) -> bool {
        !catalog.modes.is_empty() && catalog.entries.is_empty()
    }

    /// Certain for a heading that begins as this format's.
    fn detect(&self, head: &[u8]) -> Confidence {
        if delimiter(head).is_some() {
            Confidence::Certain
        } else {
            Confidence::No
        }
    }

    fn open(
        &self,
        mut input: Box<dyn ReadSeek>,
        hints: &Hints,
    ) -> Result<Box<dyn Source>, IoError> {
        let mut bytes = Vec::new();
        input
            .read_to_end(&mut bytes)
            .map_err(|source| IoError::System {
                path: hints.path.clone(),
                action: "read",
                source,
            })?;
        let modes = read(&bytes, &hints.path)?;
        Ok(Box::new(MemorySource {
            catalog: Catalog {
                format: "modes-csv",
                path: hints.path.clone(),
                modes,
                ..Catalog::default()
            },
            ..MemorySource::default()
        }))
    }

    /// Writes the modes; records, functions, geometry, residues and what tells of an identification are not carried.
    fn write(
        &self,
        out: &mut dyn WriteSeek,
        source: &mut dyn Source,
        options: &WriteOptions,
    ) -> Result<Vec<Finding>, IoError> {
        let catalog = source.catalog();
        let modes: Vec<&Mode> = catalog.modes.iter().map(|own| &own.mode).collect();
        if modes.is_empty() {
            return Err(IoError::Unwritable {
                path: options.path.clone(),
                what: "modes",
                got: "a file without modes".to_owned(),
                expected: "modes; identify them first".to_owned(),
            });
        }
        out.write_all(text(&modes).as_bytes())
            .map_err(|source| IoError::System {
                path: options.path.clone(),
                action: "write",
                source,
            })?;
        Ok(not_carried(catalog))
    }
}

/// The first line that is no remark.
fn heading(bytes: &[u8]) -> Option<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let lines = bytes.split(|byte| *byte == b'\n');
    let mut lines = lines.map(<[u8]>::trim_ascii);
    lines.find(|line| !line.is_empty() && !line.starts_with(b"#"))
}

/// What parts the cells of a table of modes.
fn delimiter(bytes: &[u8]) -> Option<u8> {
    let line = heading(bytes)?;
    DELIMITERS.into_iter().find(|delimiter| {
        let cells = line.split(|byte| byte == delimiter);
        let mut cells = cells.map(|cell| cell.trim_ascii());
        FIRST
            .iter()
            .all(|name| cells.next() == Some(name.as_bytes()))
    })
}

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Column {
    Frequency,
    Damping,
    FrequencyStd,
    DampingStd,
    Group,
    ModalMass,
    Scaling,
    Shape(Dof, Part),
}

/// Which part of a shape's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Whole,
    Real,
    Imaginary,
}

/// Columns that every mode has one value of.
const NAMED: [(&str, Column); 7] = [
    ("frequency_hz", Column::Frequency),
    ("damping_ratio", Column::Damping),
    ("frequency_std_hz", Column::FrequencyStd),
    ("damping_std", Column::DampingStd),
    ("group", Column::Group),
    ("modal_mass_kg", Column::ModalMass),
    ("scaling", Column::Scaling),
];

/// Where a text is wrong.
struct Reader<'a> {
    path: &'a str,
    line: u64,
}

impl Reader<'_> {
    fn error(&self, what: &'static str, got: &str, expected: &str) -> IoError {
        IoError::Text {
            path: self.path.to_owned(),
            line: self.line,
            what,
            got: got.to_owned(),
            expected: expected.to_owned(),
        }
    }

    fn column(&self, name: &str) -> Result<Column, IoError> {
        if let Some((_, column)) = NAMED.iter().find(|(own, _)| *own == name) {
            return Ok(column.clone());
        }
        let (dof, part) = match name.rsplit_once(' ') {
            Some((dof, "re")) => (dof, Part::Real),
            Some((dof, "im")) => (dof, Part::Imaginary),
            _ => (name, Part::Whole),
        };
        let dof = dof.trim().parse::<Dof>().map_err(|_| {
            let names: Vec<&str> = NAMED.iter().map(|(own, _)| *own).collect();
            let names = names.join(", ");
            let expected =
                format!("{names}, or a degree of freedom such as 12:+Z, 12:+Z re, 12:+Z im");
            self.error("column", name, &expected)
        })?;
        Ok(Column::Shape(dof, part))
    }

    /// The columns, each once, a real part with its imaginary one.
    fn columns(&self, names: &csv::StringRecord) -> Result<Vec<Column>, IoError> {
        let columns = names.iter().map(|name| self.column(name));
        let columns: Vec<Column> = columns.collect::<Result<_, _>>()?;
        for (i, column) in columns.iter().enumerate() {
            let name = &names[i];
            if columns[..i].contains(column) {
                return Err(self.error("column", name, "each column once"));
            }
            let Column::Shape(dof, part) = column else {
                continue;
            };
            let has = |part: Part| columns.contains(&Column::Shape(dof.clone(), part));
            let alone = match part {
                Part::Whole => !has(Part::Real) && !has(Part::Imaginary),
                Part::Real => has(Part::Imaginary),
                Part::Imaginary => has(Part::Real),
            };
            if !alone {
                let expected = format!("{dof}, or {dof} re and {dof} im");
                return Err(self.error("column", name, &expected));
            }
        }
        Ok(columns)
    }

    fn number(&self, what: &'static str, text: &str) -> Result<Option<f64>, IoError> {
        if text.is_empty() {
            return Ok(None);
        }
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| self.error(what, text, "a finite number or nothing"))?;
        Ok(Some(value))
    }

    fn mode(&self, columns: &[Column], row: &csv::StringRecord) -> Result<Mode, IoError> {
        let mut mode = Mode::new(f64::NAN, None, ModeShape::default(), Scaling::Unknown);
        let mut shape: BTreeMap<Dof, Complex64> = BTreeMap::new();
        for (column, cell) in columns.iter().zip(row) {
            match column {
                Column::Frequency => {
                    let own = self.number("frequency_hz", cell)?;
                    let own = own.filter(|hz| *hz >= 0.0);
                    let expected = "a frequency of 0 Hz or more";
                    mode.frequency_hz =
                        own.ok_or_else(|| self.error("frequency_hz", cell, expected))?;
                }
                Column::Damping => mode.damping_ratio = self.number("damping_ratio", cell)?,
                Column::FrequencyStd => {
                    mode.frequency_std_hz = self.number("frequency_std_hz", cell)?;
                }
                Column::DampingStd => mode.damping_std = self.number("damping_std", cell)?,
                Column::ModalMass => mode.modal_mass_kg = self.number("modal_mass_kg", cell)?,
                Column::Group if cell.is_empty() => {}
                Column::Group => {
                    let own = cell.parse().ok();
                    let own = own.ok_or_else(|| self.error("group", cell, "a whole number"));
                    mode.group = Some(own?);
                }
                Column::Scaling if cell.is_empty() => {}
                Column::Scaling => {
                    let expected = "unit-modal-mass, unit-max or unknown";
                    let own = Scaling::from_name(cell);
                    mode.scaling = own.ok_or_else(|| self.error("scaling", cell, expected))?;
                }
                Column::Shape(dof, part) => {
                    let Some(value) = self.number("shape", cell)? else {
                        continue;
                    };
                    let own = shape.entry(dof.clone()).or_default();
                    match part {
                        Part::Whole | Part::Real => own.re = value,
                        Part::Imaginary => own.im = value,
                    }
                }
            }
        }
        mode.shape = ModeShape::new(shape);
        Ok(mode)
    }
}

fn read(bytes: &[u8], path: &str) -> Result<Vec<ModeEntry>, IoError> {
    let mut reader = Reader { path, line: 1 };
    let Some(delimiter) = delimiter(bytes) else {
        let line = heading(bytes).unwrap_or_default();
        let got = String::from_utf8_lossy(line).into_owned();
        return Err(reader.error("heading", &got, "frequency_hz,damping_ratio,... first"));
    };
    let mut rows = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .has_headers(false)
        .from_reader(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut columns: Option<Vec<Column>> = None;
    let mut modes = Vec::new();
    for row in rows.records() {
        let row = row.map_err(|error| {
            reader.line = error.position().map_or(reader.line, csv::Position::line);
            let expected = "UTF-8 text with as many cells as the heading";
            reader.error("row", &error.to_string(), expected)
        })?;
        reader.line = row.position().map_or(reader.line, csv::Position::line);
        let Some(columns) = &columns else {
            columns = Some(reader.columns(&row)?);
            continue;
        };
        modes.push(ModeEntry {
            line: Some(reader.line),
            ..ModeEntry::new(reader.mode(columns, &row)?)
        });
    }
    Ok(modes)
}

/// A column with its cells.
type Cells<'a> = (String, Box<dyn Fn(&Mode) -> Option<String> + 'a>);

/// The table of these modes: columns that no mode has a value of are left out.
fn text(modes: &[&Mode]) -> String {
    let mut columns: Vec<Cells<'_>> = NAMED
        .iter()
        .map(|(name, column)| -> Cells<'_> {
            (
                (*name).to_owned(),
                Box::new(|mode| named_cell(mode, column)),
            )
        })
        .filter(|(name, cell)| {
            FIRST.contains(&name.as_str()) || modes.iter().any(|mode| cell(mode).is_some())
        })
        .collect();
    let shapes = || modes.iter().flat_map(|mode| mode.shape.iter());
    let complex = shapes().any(|(_, value)| value.im.abs() > 0.0);
    let dofs: std::collections::BTreeSet<Dof> = shapes().map(|(dof, _)| dof.clone()).collect();
    for dof in dofs {
        let own = dof.clone();
        let real: Cells<'_> = (
            if complex {
                format!("{dof} re")
            } else {
                dof.to_string()
            },
            Box::new(move |mode| mode.shape.get(&own).map(|value| value.re.to_string())),
        );
        columns.push(real);
        if complex {
            let name = format!("{dof} im");
            let imaginary = move |mode: &Mode| mode.shape.get(&dof).map(|v| v.im.to_string());
            columns.push((name, Box::new(imaginary)));
        }
    }
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for mode in modes {
        let cells = columns
            .iter()
            .map(|(_, cell)| cell(mode).unwrap_or_default());
        text += &cells.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

fn named_cell(mode: &Mode, column: &Column) -> Option<String> {
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    match column {
        Column::Frequency => number(Some(mode.frequency_hz)),
        Column::Damping => number(mode.damping_ratio),
        Column::FrequencyStd => number(mode.frequency_std_hz),
        Column::DampingStd => number(mode.damping_std),
        Column::ModalMass => number(mode.modal_mass_kg),
        Column::Group => mode.group.map(|group| group.to_string()),
        Column::Scaling => {
            let known = mode.scaling != Scaling::Unknown;
            known.then(|| mode.scaling.name().to_owned())
        }
        Column::Shape(..) => None,
    }
}

fn not_carried(catalog: &Catalog) -> Vec<Finding> {
    let mut lost = NotCarried::default();
    lost.add("records and functions", catalog.entries.len());
    lost.add("geometry", catalog.geometry.len());
    lost.add("arrays without a meaning", catalog.arrays.len());
    let modal = |own: &&ModeEntry| own.modal_a.or(own.modal_b).is_some();
    lost.add("modal A or B", catalog.modes.iter().filter(modal).count());
    let titled = |own: &&ModeEntry| !own.title.is_empty();
    lost.add(
        "titles of modes",
        catalog.modes.iter().filter(titled).count(),
    );
    let count = |has: fn(&Mode) -> bool| catalog.modes.iter().filter(|m| has(&m.mode)).count();
    lost.add("residues", count(|mode| !mode.residues.is_empty()));
    lost.add(
        "deviations of shapes",
        count(|mode| mode.shape_std.is_some()),
    );
    let told = count(|mode| {
        mode.order.is_some() || mode.method.as_ref().is_some_and(|own| own != "theory")
    });
    lost.add("methods and orders of modes", told);
    lost.findings()
}

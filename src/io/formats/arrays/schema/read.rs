//! Arrays that follow the schema become a source. Samples are read when they are asked for.

use std::ops::Range;

use num_complex::Complex64;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::io::catalog::sample_range::uneven_without_values;
use crate::io::formats::arrays::store::bytes::count;
use crate::io::formats::arrays::store::{ArrayStore, Elements};
use crate::io::{
    Block, Catalog, Domain, Entry, EntryAxis, FunctionType, GeneralAxis, IoError, Part,
    SampleFormat, Source,
};
use crate::linalg::sort_ascending_by;

use super::array_index::{ArrayIndex, same_shape};
use super::arrays::SCHEMA;
use super::entry_fields::{NUMBERS, TEXTS, domain_of, format_of};
use super::{geometry, modes};

/// Arrays of the samples of a group.
#[derive(Clone, Copy, Debug)]
enum Values {
    Real(usize),
    Complex(usize, usize),
}

/// Where the samples of an entry lie.
#[derive(Clone, Copy, Debug)]
struct Place {
    values: Values,
    /// First element in the arrays.
    first: usize,
    /// Array of the abscissa, of an uneven one.
    abscissa: Option<usize>,
}

/// A source over arrays in the schema of modalign.
pub(in crate::io) struct SchemaSource {
    catalog: Catalog,
    store: Box<dyn ArrayStore>,
    places: Vec<Place>,
}

/// A file of any size may have so many functions ...
const MIN_FUNCTION_LIMIT: u64 = 1024;

/// ... and one more for so many bytes of it. Smaller than 1: numbers of functions that deflate well
/// ask for a thousand times the memory of the file. Larger than 110: 10,000 functions in 1 MB are
/// refused (both `functions_are_no_more_than_the_file_can_hold`).
const MIN_FILE_BYTES_PER_FUNCTION: u64 = 16;

/// A text of more bytes does not name this schema.
const MAX_SCHEMA_BYTES: u64 = 1024;

/// Whether the arrays state this schema. A file of another program may also have a `schema`.
///
/// # Errors
/// [`IoError::Grouping`] for this schema with another number.
pub(in crate::io) fn follows_schema(
    store: &mut dyn ArrayStore,
    path: &str,
) -> Result<bool, IoError> {
    let mut array_index = ArrayIndex::new(store, path);
    let short = array_index
        .bytes("schema")
        .is_some_and(|bytes| bytes <= MAX_SCHEMA_BYTES);
    let schema = match short {
        true => array_index
            .text("schema")
            .ok()
            .flatten()
            .unwrap_or_default(),
        false => return Ok(false),
    };
    let name = SCHEMA.trim_end_matches(|c| c != '/');
    match schema == SCHEMA {
        false if schema.starts_with(name) => {
            Err(array_index.error("schema", format!("{schema:?}"), SCHEMA))
        }
        same => Ok(same),
    }
}

/// Makes the source; `catalog` has format, path and what the store had to say. A group that cannot
/// be used is left out with its error.
pub(in crate::io) fn open_with_schema(
    mut store: Box<dyn ArrayStore>,
    catalog: Catalog,
) -> SchemaSource {
    let mut catalog = catalog;
    let path = catalog.path.clone();
    let mut array_index = ArrayIndex::new(store.as_mut(), &path);
    let mut errors = Vec::new();
    let mut found: Vec<(f64, Entry, Place)> = Vec::new();
    for group in groups(&array_index) {
        match read_group(&mut array_index, &group, found.len()) {
            Ok(entries) => found.extend(entries),
            Err(error) => errors.push((error, part_of(&mut array_index, &group))),
        }
    }
    let mut keep =
        |read: Result<(), IoError>, part| errors.extend(read.err().map(|error| (error, part)));
    let title = array_index.texts("title", None);
    keep(
        title.map(|title| catalog.title = title.unwrap_or_default()),
        Part::Other,
    );
    keep(
        geometry::read(&mut array_index, &mut catalog.geometry),
        Part::Nodes,
    );
    keep(
        modes::read(&mut array_index, &mut catalog.modes),
        Part::Mode,
    );
    for (error, part) in errors {
        catalog.note_damage(error, part);
    }
    sort_ascending_by(&mut found, |entry| entry.0);
    let (entries, places) = found
        .into_iter()
        .map(|(_, entry, place)| (entry, place))
        .unzip();
    catalog.entries = entries;
    SchemaSource {
        catalog,
        store,
        places,
    }
}

/// Names of the groups of functions.
fn groups(array_index: &ArrayIndex) -> Vec<String> {
    let names = array_index
        .names()
        .filter_map(|name| name.strip_suffix("/function_type"));
    names.map(str::to_owned).collect()
}

/// The contents of a group with an unreadable part.
fn part_of(array_index: &mut ArrayIndex, group: &str) -> Part {
    let name = format!("{group}/function_type");
    named(array_index, &name, FunctionType::from_name).map_or(Part::Function, Part::of_function)
}

/// The functions of a group; `known` are those of the groups before it.
fn read_group(
    array_index: &mut ArrayIndex,
    group: &str,
    known: usize,
) -> Result<Vec<(f64, Entry, Place)>, IoError> {
    let name = |field: &str| format!("{group}/{field}");
    let function_type = named(array_index, &name("function_type"), FunctionType::from_name)?;
    let format = named(array_index, &name("stored"), format_of)?;
    let positions = array_index.needed_numbers(&name("position"), None)?;
    let most = MIN_FUNCTION_LIMIT + array_index.file_bytes() / MIN_FILE_BYTES_PER_FUNCTION;
    if (known + positions.len()) as u64 > most {
        let got = format!("{} functions", known + positions.len());
        let expected = format!("{most} or fewer in a file of this size");
        return Err(array_index.error(&name("position"), got, expected));
    }
    let (values, lines) = values(array_index, group, format, positions.len())?;
    let (axis, abscissa) = read_axis(array_index, group, lines)?;
    let mut entries = vec![Entry::new(function_type, axis, format); positions.len()];
    describe(array_index, group, &mut entries)?;
    let numbered = positions.into_iter().zip(entries).enumerate();
    let placed = numbered.map(|(row, (position, entry))| {
        let place = Place {
            values,
            first: row * lines,
            abscissa,
        };
        (position, entry, place)
    });
    Ok(placed.collect())
}

/// A text that must be there and mean something.
fn named<T>(
    array_index: &mut ArrayIndex,
    name: &str,
    meaning: impl Fn(&str) -> Option<T>,
) -> Result<T, IoError> {
    let text = array_index.text(name)?.unwrap_or_default();
    meaning(&text)
        .ok_or_else(|| array_index.error(name, format!("{text:?}"), "a name of the layout"))
}

/// The arrays of samples and the number of lines of each function.
fn values(
    array_index: &ArrayIndex,
    group: &str,
    format: SampleFormat,
    functions: usize,
) -> Result<(Values, usize), IoError> {
    let array = |field: &str| {
        let name = format!("{group}/{field}");
        let found = array_index.place(&name).zip(array_index.shape(&name));
        let (place, shape) = found
            .ok_or_else(|| array_index.error(&name, "nothing", "an array [function, line]"))?;
        let lines = lines_of(shape, functions).ok_or_else(|| {
            let expected = format!("shape [{functions}, lines]");
            array_index.error(&name, format!("shape {shape:?}"), expected)
        })?;
        Ok((place, lines))
    };
    match format {
        SampleFormat::RealF32 | SampleFormat::RealF64 => {
            let (real, lines) = array("values")?;
            Ok((Values::Real(real), lines))
        }
        SampleFormat::ComplexF32 | SampleFormat::ComplexF64 => {
            let ((re, lines), (im, other)) = (array("re")?, array("im")?);
            if lines != other {
                let got = format!("{lines} and {other} lines");
                return Err(array_index.error(group, got, "re and im of one shape"));
            }
            Ok((Values::Complex(re, im), lines))
        }
    }
}

/// Lines of each function in an array [function, line]; `None` for any other shape.
fn lines_of(shape: &[usize], functions: usize) -> Option<usize> {
    let lines = count(shape)?.checked_div(functions).unwrap_or(0);
    same_shape(shape, &[functions, lines]).then_some(lines)
}

fn read_axis(
    array_index: &mut ArrayIndex,
    group: &str,
    len: usize,
) -> Result<(EntryAxis, Option<usize>), IoError> {
    let name = |field: &str| format!("{group}/{field}");
    let domain = named(array_index, &name("domain"), domain_of)?;
    let is_even = named(array_index, &name("axis"), |text| match text {
        "even" => Some(true),
        "general" => Some(false),
        _ => None,
    })?;
    let start = array_index.number(&name("start"))?;
    let even = start.zip(array_index.number(&name("step"))?);
    if let Some((start, step)) = even {
        check_even(array_index, group, is_even, start, step)?;
    }
    let axis = match (is_even, domain, even) {
        (true, Domain::Time, Some((start_s, step_s))) => EntryAxis::Time(TimeAxis {
            start_s,
            step_s,
            len,
        }),
        (true, Domain::Frequency, Some((start_hz, step_hz))) => {
            EntryAxis::Frequency(FrequencyAxis {
                start_hz,
                step_hz,
                len,
            })
        }
        (true, ..) => {
            return Err(array_index.error(
                group,
                "an even axis",
                "time or frequency, start and step",
            ));
        }
        (false, ..) => EntryAxis::General(GeneralAxis { domain, even, len }),
    };
    if even.is_some() {
        return Ok((axis, None));
    }
    let array = name("abscissa");
    match (array_index.place(&array), array_index.shape(&array)) {
        (Some(place), Some(shape)) if same_shape(shape, &[len]) => Ok((axis, Some(place))),
        (_, None) => Err(array_index.error(&array, "nothing", format!("shape [{len}]"))),
        (_, Some(shape)) => {
            let got = format!("shape {shape:?}");
            Err(array_index.error(&array, got, format!("shape [{len}]")))
        }
    }
}

/// Start and step are finite; a time or frequency axis ascends.
fn check_even(
    array_index: &ArrayIndex,
    group: &str,
    ascends: bool,
    start: f64,
    step: f64,
) -> Result<(), IoError> {
    if !start.is_finite() {
        return Err(array_index.error(&format!("{group}/start"), start, "a finite number"));
    }
    let name = format!("{group}/step");
    match ascends {
        true if !(step.is_finite() && step > 0.0) => {
            Err(array_index.error(&name, step, "a finite number above 0"))
        }
        false if !step.is_finite() => Err(array_index.error(&name, step, "a finite number")),
        _ => Ok(()),
    }
}

fn describe(
    array_index: &mut ArrayIndex,
    group: &str,
    entries: &mut [Entry],
) -> Result<(), IoError> {
    let count = entries.len();
    for field in TEXTS {
        let name = format!("{group}/{}", field.name);
        let values = array_index
            .texts(&name, Some(&[count]))?
            .unwrap_or_default();
        for (entry, text) in entries.iter_mut().zip(values) {
            if !text.is_empty() && !(field.set)(entry, &text) {
                return Err(array_index.error(&name, format!("{text:?}"), "a value of the layout"));
            }
        }
    }
    for field in NUMBERS {
        let name = format!("{group}/{}", field.name);
        let values = array_index
            .numbers(&name, Some(&[count]))?
            .unwrap_or_default();
        for (entry, value) in entries.iter_mut().zip(values) {
            if !value.is_nan() && !(field.set)(entry, value) {
                return Err(array_index.error(&name, value, "a value of the layout"));
            }
        }
    }
    let lines = array_index.texts(&format!("{group}/id_lines"), Some(&[count, 5]))?;
    let lines = lines.unwrap_or_default();
    for (entry, id_lines) in entries.iter_mut().zip(lines.chunks_exact(5)) {
        entry.identification.lines.clone_from_slice(id_lines);
    }
    let name = format!("{group}/valid_hz");
    let valid = array_index.numbers(&name, Some(&[count, 2]))?;
    let valid = valid.unwrap_or_default();
    for (entry, limits) in entries.iter_mut().zip(valid.chunks_exact(2)) {
        if limits[0].is_nan() != limits[1].is_nan() {
            return Err(array_index.error(
                &name,
                format!("{limits:?}"),
                "two limits, or NaN twice",
            ));
        }
        entry.note.valid_hz = (!limits[0].is_nan()).then_some((limits[0], limits[1]));
    }
    Ok(())
}

impl SchemaSource {
    fn wrong_kind(&self, entry: usize) -> IoError {
        IoError::Grouping {
            path: self.catalog.path.clone(),
            what: "reading layout modalign-frf/1",
            got: format!("samples of entry {} of another kind", entry + 1),
            expected: "numbers, as many as lines".to_owned(),
        }
    }

    fn reals(
        &mut self,
        entry: usize,
        array: usize,
        range: Range<usize>,
    ) -> Result<Vec<f64>, IoError> {
        let count = range.len();
        match self.store.read_part(array, range)? {
            Elements::F64(values) if values.len() == count => Ok(values),
            Elements::F32(values) if values.len() == count => {
                Ok(values.into_iter().map(f64::from).collect())
            }
            _ => Err(self.wrong_kind(entry)),
        }
    }
}

impl Source for SchemaSource {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn catalog_mut(&mut self) -> &mut Catalog {
        &mut self.catalog
    }

    fn read_samples(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        let place = self.places[entry];
        let part = place.first + range.start..place.first + range.end;
        if let (Values::Real(array), Block::F32(values)) = (&place.values, &mut *block)
            && self.store.read_singles(*array, part.clone(), values)?
        {
            return Ok(());
        }
        *block = match place.values {
            Values::Complex(re, im) => {
                let re = self.reals(entry, re, part.clone())?;
                let im = self.reals(entry, im, part)?;
                let pairs = re.into_iter().zip(im);
                Block::Complex(pairs.map(|(re, im)| Complex64::new(re, im)).collect())
            }
            Values::Real(array) => match self.store.read_part(array, part)? {
                Elements::F32(values) if values.len() == range.len() => Block::F32(values),
                Elements::F64(values) if values.len() == range.len() => Block::F64(values),
                _ => return Err(self.wrong_kind(entry)),
            },
        };
        Ok(())
    }

    fn read_abscissa(
        &mut self,
        entry: usize,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        let array = self.places[entry].abscissa;
        let array = array.ok_or_else(|| uneven_without_values(&self.catalog, entry))?;
        *out = self.reals(entry, array, range)?;
        Ok(())
    }
}

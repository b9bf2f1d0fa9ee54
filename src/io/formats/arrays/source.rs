//! Arrays become a source: by the schema of modalign, by a scene's description, by the names of a
//! measurement system, or as a plain list of arrays.
//!
//! A container of arrays does not say what its arrays mean, unless modalign or a known measurement
//! system wrote it. A scene's
//! `[[test.channel]]` names an array by its path in the file (levels separated by `/` or `.`) and,
//! where it holds several channels, the channel by its number: `H1_2:2`. Without `dimensions` the
//! rows of a two-dimensional array are samples and its columns are channels, as MATLAB and NumPy
//! users keep them; three dimensions have no such custom and must be stated.

use crate::finding::{Code, Finding, Location, Severity};

use super::limited::Limited;
use super::schema;
use super::signalcalc;
use super::store::{ArrayStore, Elements};
use crate::io::columns::{Columns, RowLines, entries_from_columns};
use crate::io::{
    ArrayInfo, Block, Catalog, ColumnName, Dimension, Hints, IoError, MemorySource, Part, Source,
    TableSpec,
};

/// So many names are listed in an error.
const MAX_LISTED_NAMES: usize = 40;

/// Makes a source of the arrays of a container.
///
/// # Errors
/// [`IoError::MissingArray`] for an array that the scene names and the file does not have, or the
/// first damage of the file; [`IoError::NotStated`] for dimensions that are not stated; errors of
/// [`entries_from_columns`] and the store.
pub(in crate::io) fn open_arrays(
    format: &'static str,
    store: Box<dyn ArrayStore>,
    hints: &Hints,
) -> Result<Box<dyn Source>, IoError> {
    let mut store: Box<dyn ArrayStore> = Box::new(Limited::new(store, &hints.path));
    let (damage, findings) = (store.take_damage(), unread_findings(store.as_ref()));
    let mut catalog = Catalog {
        format,
        path: hints.path.clone(),
        ..Catalog::default()
    };
    catalog.findings.extend(findings);
    catalog.findings.extend(store.take_findings());
    let spec = hints.table.as_ref().filter(|spec| !spec.columns.is_empty());
    let follows_schema = schema::follows_schema(store.as_mut(), &hints.path)?;
    // Where a scene names the arrays that it needs, the others are not needed.
    let part = match spec {
        Some(_) if !follows_schema => Part::Other,
        _ => Part::Any,
    };
    for error in damage {
        catalog.note_damage(error, part);
    }
    if follows_schema {
        return Ok(Box::new(schema::open_with_schema(store, catalog)));
    }
    let Some(spec) = spec else {
        if signalcalc::is_signalcalc(store.as_ref()) {
            return Ok(Box::new(signalcalc::open(store.as_mut(), catalog)));
        }
        catalog.arrays = store.list().to_vec();
        return Ok(Box::new(MemorySource {
            catalog,
            ..MemorySource::default()
        }));
    };
    let sets = match read_columns(store.as_mut(), spec, &hints.path) {
        // The array that is missing may be the one that is damaged.
        Err(IoError::MissingArray { .. }) if !catalog.damage.is_empty() => {
            return Err(catalog.damage.swap_remove(0).error);
        }
        sets => sets?,
    };
    let mut source = entries_from_columns(format, spec, sets, &hints.path)?;
    source.catalog.damage = catalog.damage;
    source.catalog.findings.extend(catalog.findings);
    Ok(Box::new(source))
}

/// One finding for each array that is listed but cannot be read.
fn unread_findings(store: &dyn ArrayStore) -> Vec<Finding> {
    let unread = (0..store.list().len()).filter(|index| !store.can_read(*index));
    unread
        .map(|index| {
            let location = Location::Parameter(store.list()[index].name.clone());
            Finding::new(Severity::Info, Code::ArrayNotRead, location)
        })
        .collect()
}

/// Where hits, channels and samples of an array lie: `(count, stride)` of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Arrangement {
    hits: (usize, usize),
    channels: (usize, usize),
    samples: (usize, usize),
}

/// Array and channel (from 0; `None` where no number is given) of one column of the spec.
#[derive(Clone, Copy, Debug)]
struct SelectedChannel {
    array: usize,
    channel: Option<usize>,
}

/// The columns that the spec names, one set for each hit.
fn read_columns(
    store: &mut dyn ArrayStore,
    spec: &TableSpec,
    path: &str,
) -> Result<Vec<Columns>, IoError> {
    let selected = spec
        .columns
        .iter()
        .map(|column| find_column(store, &column.column, path));
    let selected: Vec<SelectedChannel> = selected.collect::<Result<_, _>>()?;
    let mut hits = 1;
    let mut values: Vec<Vec<Block>> = vec![Vec::new(); selected.len()];
    for (first, place) in selected.iter().enumerate() {
        if !values[first].is_empty() {
            continue;
        }
        // Each array is read once and let go before the next one.
        let array = store.read(place.array)?;
        let info = &store.list()[place.array];
        if array.shape.iter().product::<usize>() != array.elements.len() {
            return Err(not_numeric_error(info, path));
        }
        let arrangement = find_arrangement(info, &array.shape, spec, path)?;
        hits = common_hits(hits, arrangement.hits.0, info, path)?;
        let of_array = selected.iter().enumerate().skip(first);
        for (column, selected) in of_array.filter(|(_, selected)| selected.array == place.array) {
            let channel = channel_index(selected.channel, &arrangement, info, path)?;
            for hit in 0..arrangement.hits.0 {
                let block = channel_samples(&array.elements, &arrangement, hit, channel);
                values[column].push(block.ok_or_else(|| not_numeric_error(info, path))?);
            }
        }
    }
    (0..hits)
        .map(|hit| columns_of_hit(&values, hit, path))
        .collect()
}

fn not_numeric_error(info: &ArrayInfo, path: &str) -> IoError {
    IoError::Grouping {
        path: path.to_owned(),
        what: "reading an array as a channel",
        got: format!("{} ({})", info.name, info.kind),
        expected: "numbers".to_owned(),
    }
}

/// Arrays with one hit (a time column) go with every number of hits.
fn common_hits(known: usize, hits: usize, info: &ArrayInfo, path: &str) -> Result<usize, IoError> {
    match (known, hits) {
        (1, hits) => Ok(hits),
        (known, 1) => Ok(known),
        (known, hits) if known == hits => Ok(known),
        (known, hits) => Err(IoError::Grouping {
            path: path.to_owned(),
            what: "reading arrays as hits",
            got: format!("{hits} hits in {}", info.name),
            expected: format!("{known}, as in the arrays before it"),
        }),
    }
}

fn columns_of_hit(values: &[Vec<Block>], hit: usize, path: &str) -> Result<Columns, IoError> {
    let of_hit = |blocks: &Vec<Block>| blocks.get(hit).or(blocks.first()).cloned();
    let values: Vec<Block> = values.iter().filter_map(of_hit).collect();
    let rows = values.first().map_or(0, block_len);
    match values.iter().find(|block| block_len(block) != rows) {
        None => Ok(Columns {
            values,
            rows,
            lines: RowLines::default(),
        }),
        Some(other) => Err(IoError::Grouping {
            path: path.to_owned(),
            what: "reading arrays as channels",
            got: format!("{} samples", block_len(other)),
            expected: format!("{rows}, as in the first channel"),
        }),
    }
}

fn block_len(block: &Block) -> usize {
    match block {
        Block::F32(values) => values.len(),
        Block::F64(values) => values.len(),
        Block::Complex(values) => values.len(),
    }
}

/// Names compare with `.` and `/` as the same mark.
pub(in crate::io) fn same_name(stored: &str, asked: &str) -> bool {
    let level = |c: char| if c == '.' { '/' } else { c };
    stored.chars().map(level).eq(asked.chars().map(level))
}

fn find_column(
    store: &dyn ArrayStore,
    column: &ColumnName,
    path: &str,
) -> Result<SelectedChannel, IoError> {
    let position = |asked: &str| {
        let names = store.list().iter();
        names
            .clone()
            .position(|info| info.name == asked)
            .or_else(|| {
                let mut names = names;
                names.position(|info| same_name(&info.name, asked))
            })
    };
    let missing = |expected: String| IoError::MissingArray {
        path: path.to_owned(),
        got: describe_arrays(store),
        expected,
    };
    match column {
        ColumnName::Heading(text) => {
            if let Some(array) = position(text) {
                return Ok(SelectedChannel {
                    array,
                    channel: None,
                });
            }
            let numbered = text.rsplit_once(':').and_then(|(name, number)| {
                let channel = number.parse::<usize>().ok()?.checked_sub(1)?;
                Some((position(name)?, channel))
            });
            let (array, channel) = numbered.ok_or_else(|| missing(text.clone()))?;
            Ok(SelectedChannel {
                array,
                channel: Some(channel),
            })
        }
        ColumnName::Number(number) => {
            let mut with_numbers = (0..store.list().len())
                .filter(|index| store.can_read(*index) && store.list()[*index].kind != "text");
            let only = (
                with_numbers.next(),
                with_numbers.next(),
                number.checked_sub(1),
            );
            let (Some(array), None, Some(channel)) = only else {
                return Err(missing(format!("NAME:{number}")));
            };
            Ok(SelectedChannel {
                array,
                channel: Some(channel),
            })
        }
    }
}

/// The arrays that are there, for messages.
pub(in crate::io) fn describe_arrays(store: &dyn ArrayStore) -> String {
    let list = store.list();
    if list.is_empty() {
        return "no arrays".to_owned();
    }
    let described = list.iter().take(MAX_LISTED_NAMES).map(|info| {
        let lengths: Vec<String> = info.shape.iter().map(ToString::to_string).collect();
        format!("{} ({} {})", info.name, lengths.join(" x "), info.kind)
    });
    let described: Vec<String> = described.collect();
    let more = list.len().saturating_sub(MAX_LISTED_NAMES);
    let rest = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    format!("arrays {}{rest}", described.join(", "))
}

/// Which dimension is which.
fn find_arrangement(
    info: &ArrayInfo,
    shape: &[usize],
    spec: &TableSpec,
    path: &str,
) -> Result<Arrangement, IoError> {
    // A vector (n, n x 1, 1 x n) is one channel, such as the time of all others.
    if shape.iter().filter(|len| **len != 1).count() <= 1 {
        return Ok(Arrangement {
            hits: (1, 0),
            channels: (1, 0),
            samples: (shape.iter().product(), 1),
        });
    }
    let dimensions: &[Dimension] = match (spec.dimensions.as_deref(), shape.len()) {
        // MATLAB drops lengths of 1 behind the others.
        (Some(stated), count) if stated.len() >= count => stated,
        (Some(stated), count) => {
            return Err(IoError::NotStated {
                path: path.to_owned(),
                what: format!("what the {count} dimensions of {} are", info.name),
                expected: format!("as many dimensions in [[test]], got {}", stated.len()),
            });
        }
        (None, 2) => &[Dimension::Sample, Dimension::Channel],
        (None, count) => {
            return Err(IoError::NotStated {
                path: path.to_owned(),
                what: format!("what the {count} dimensions of {} are", info.name),
                expected: "dimensions = [\"hit\", \"channel\", \"sample\"] in [[test]], in the order of the array"
                    .to_owned(),
            });
        }
    };
    let mut found = Arrangement {
        hits: (1, 0),
        channels: (1, 0),
        samples: (1, 0),
    };
    let mut stride = 1;
    let lengths = shape.iter().chain(std::iter::repeat(&1));
    let lengths: Vec<&usize> = lengths.take(dimensions.len()).collect();
    for (dimension, len) in dimensions.iter().zip(lengths).rev() {
        let place = match dimension {
            Dimension::Hit => &mut found.hits,
            Dimension::Channel => &mut found.channels,
            Dimension::Sample => &mut found.samples,
        };
        *place = (*len, stride);
        stride *= len;
    }
    let distinct = |d: &Dimension| dimensions.iter().filter(|other| *other == d).count() == 1;
    if dimensions.iter().all(distinct) {
        return Ok(found);
    }
    Err(IoError::Grouping {
        path: path.to_owned(),
        what: "reading dimensions of [[test]]",
        got: format!("{dimensions:?}"),
        expected: "hit, channel and sample once each at most".to_owned(),
    })
}

/// The channel that is asked for; the only one where no number is given.
fn channel_index(
    asked: Option<usize>,
    arrangement: &Arrangement,
    info: &ArrayInfo,
    path: &str,
) -> Result<usize, IoError> {
    let count = arrangement.channels.0;
    match asked {
        Some(channel) if channel < count => Ok(channel),
        None if count == 1 => Ok(0),
        _ => Err(IoError::MissingArray {
            path: path.to_owned(),
            got: format!("{} with {count} channels", info.name),
            expected: match asked {
                Some(channel) => format!("{}:{}", info.name, channel + 1),
                None => format!("{}:NUMBER", info.name),
            },
        }),
    }
}

/// Samples of one channel of one hit; nothing for texts.
fn channel_samples(
    elements: &Elements,
    arrangement: &Arrangement,
    hit: usize,
    channel: usize,
) -> Option<Block> {
    let (samples, stride) = arrangement.samples;
    let first = hit * arrangement.hits.1 + channel * arrangement.channels.1;
    let places = (0..samples).map(|sample| first + sample * stride);
    match elements {
        Elements::F32(values) => Some(Block::F32(places.map(|i| values[i]).collect())),
        Elements::F64(values) => Some(Block::F64(places.map(|i| values[i]).collect())),
        Elements::Complex(values) => Some(Block::Complex(places.map(|i| values[i]).collect())),
        Elements::Text(_) => None,
    }
}

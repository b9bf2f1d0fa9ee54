//! The schema of modalign for named arrays, `modalign-frf/1`, holds everything in a source,
//! to the bit.
//!
//! HDF5, MATLAB and NumPy files hold named arrays, and this is the set of names and shapes that
//! modalign gives them. Others read these files with `h5py`, `scipy.io.loadmat`, `numpy.load` or
//! MATLAB, so the schema is a promise: a change that breaks a reader raises the number after the
//! slash. Names have at most two levels (`frf/re`: a group or a struct field) of letters, digits
//! and `_`. A number that is not known is NaN, a text that is not known is empty. A reader passes
//! over arrays that it does not know and takes a missing array as "nothing known". Text arrays are
//! UTF-8 (HDF5), `<U` (NumPy), or cells of char (MATLAB, where every array has two dimensions or
//! more, n values being n x 1).
//!
//! # The file
//!
//! | array | shape | content |
//! |---|---|---|
//! | `schema` | text | `modalign-frf/1` |
//! | `producer` | text | program and version |
//! | `title` | \[line\] text | title lines; absent without any |
//!
//! # Functions
//!
//! Records and functions of one type, axis and sample format are one group `G`: the name of the
//! type with `_` for `-` (`frf`, `time`, `coherence`, `variance`, `auto_spectrum`, ...), further
//! ones with `_2`, `_3` behind it.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `G/function_type` | text | name of the type, `frf`; `type-99` for a number of universal file dataset 58 without name |
//! | `G/stored` | text | how the values are stored: `f32`, `f64`, `complex f32`, `complex f64` |
//! | `G/domain` | text | what the abscissa measures: `time` (s), `frequency` (Hz), `type-19` (dataset 58, unit of the file) |
//! | `G/axis` | text | `even`: a time or frequency axis; `general`: any other |
//! | `G/start`, `G/step` | number | first abscissa and spacing, of an even abscissa |
//! | `G/abscissa` | \[line\] | the abscissa itself, of an uneven one |
//! | `G/frequency_hz` | \[line\] | start + i step of an even frequency axis, Hz; for the user, readers take start and step |
//! | `G/position` | \[function\] | place in the file, from 0, over all groups |
//! | `G/response`, `G/reference` | \[function\] text | degree of freedom, `12:+Z` |
//! | `G/quantity`, `G/denominator` | \[function\] text | `force`, `displacement`, `velocity`, `acceleration`, `pressure`, ... |
//! | `G/unit`, `G/axis_unit` | \[function\] text | unit texts as the file gave them |
//! | `G/to_si` | \[function\] | SI value = `to_si` x value |
//! | `G/role` | \[function\] text | `force`, `response` |
//! | `G/version`, `G/load_case` | \[function\] | version (hit) number and load case |
//! | `G/id_lines` | \[function, 5\] text | ID lines |
//! | `G/averages` | \[function\] | number of averages |
//! | `G/estimator` | \[function\] text | `h1`, `h2`, `hv` |
//! | `G/window` | \[function\] text | window of the records: `hann-narrow`, `exponential`, `force`, `force-and-exponential`, ... |
//! | `G/added_damping_rad_s` | \[function\] | decay rate of the exponential window still in the values, rad/s |
//! | `G/record_s` | \[function\] | length of the records, s |
//! | `G/interpolated` | \[function\] | 1 where the lines were interpolated from unevenly measured ones |
//! | `G/variance_degrees_of_freedom` | \[function\] | degrees of freedom of the variance of a function, real numbers |
//! | `G/valid_hz` | \[function, 2\] | where the function is valid, Hz |
//! | `G/values` | \[function, line\] | real values, as stored |
//! | `G/re`, `G/im` | \[function, line\] | complex values, as stored |
//!
//! # Geometry
//!
//! | array | shape | content |
//! |---|---|---|
//! | `geometry/point`, `geometry/at_m` | \[node\] text, \[node, 3\] | name and global position, m |
//! | `geometry/displacement_system` | \[node\] | label of the system of displacements; NaN: global |
//! | `geometry/line_name`, `geometry/line_count` | \[line\] text, \[line\] | name and number of points of each trace line |
//! | `geometry/line_point` | \[Σ count\] text | points of all lines, one line after the other; empty lifts the pen |
//! | `geometry/system_label`, `_name`, `_kind` | \[system\] | local systems; `cartesian`, `cylindrical`, `spherical` |
//! | `geometry/system_origin_m`, `_axes` | \[system, 3\], \[system, 3, 3\] | origin, m; unit vectors x, y, z as rows |
//! | `geometry/element_label`, `_descriptor`, `_count` | \[element\] | number, descriptor of dataset 2412, points |
//! | `geometry/element_point` | \[Σ count\] text | points of all elements |
//! | `geometry/group_label`, `_name`, `_count` | \[group\] | number, name, members |
//! | `geometry/group_type`, `_member` | \[Σ count\] | entity type of dataset 2467 and label of all members |
//!
//! # Modes
//!
//! In ascending frequency. The reader takes `json`; the other arrays say the same to users of h5py
//! and MATLAB.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `modes/json` | text | `modes.json`, schema `modalign-modes/1` |
//! | `modes/position` | \[mode\] | place in the file, from 0 |
//! | `modes/title` | \[mode\] text | text that names it, lines separated by line feeds |
//! | `modes/modal_a`, `modes/modal_b` | \[mode, 2\] | real and imaginary part of modal A and B of dataset 55 |
//! | `modes/frequency_hz`, `modes/damping_ratio` | \[mode\] | natural frequency and damping as a fraction |
//! | `modes/dof` | \[dof\] text | degrees of freedom of all shapes |
//! | `modes/shape_re`, `modes/shape_im` | \[mode, dof\] | shapes; NaN where a mode has no value |

mod array_index;
mod arrays;
mod entry_fields;
mod functions;
mod geometry;
mod modes;
mod read;

#[cfg(test)]
pub(in crate::io) mod drawn_sources;
#[cfg(test)]
mod tests;

pub(in crate::io) use read::{follows_schema, open_with_schema};

use crate::finding::Finding;
use crate::io::formats::dropped_content::DroppedContent;

use super::store::NamedArray;
use crate::io::{IoError, Precision, Source};
use arrays::{Put, SCHEMA, Wanted, text, texts};

/// Emits everything that a source holds as arrays, one after the other, samples in a stated width
/// or as stored. Arrays of one group follow each other, its samples last.
///
/// # Errors
/// Errors of the source and of `put`.
pub(in crate::io) fn write_with_schema(
    source: &mut dyn Source,
    precision: Option<Precision>,
    put: &mut Put,
) -> Result<Vec<Finding>, IoError> {
    let wanted = Wanted {
        samples: true,
        precision,
    };
    emit(source, wanted, put)
}

/// Names of the arrays that [`write_with_schema`] emits, in their order, without reading samples.
///
/// # Errors
/// As [`write_with_schema`].
pub(in crate::io) fn array_names(
    source: &mut dyn Source,
    precision: Option<Precision>,
) -> Result<Vec<String>, IoError> {
    let mut names = Vec::new();
    let mut keep = |array: NamedArray| {
        names.push(array.name);
        Ok(())
    };
    let wanted = Wanted {
        samples: false,
        precision,
    };
    emit(source, wanted, &mut keep)?;
    Ok(names)
}

fn emit(source: &mut dyn Source, wanted: Wanted, put: &mut Put) -> Result<Vec<Finding>, IoError> {
    let mut lost = DroppedContent::default();
    put(text("schema", SCHEMA))?;
    let producer = concat!("modalign ", env!("CARGO_PKG_VERSION"));
    put(text("producer", producer))?;
    let title = source.catalog().title.clone();
    if !title.is_empty() {
        put(texts("title", &[title.len()], title))?;
    }
    functions::write(source, wanted, put, &mut lost)?;
    let catalog = source.catalog();
    geometry::write(&catalog.geometry, put, &mut lost)?;
    modes::write(&catalog.modes, put, &mut lost)?;
    lost.add("arrays without a stated meaning", catalog.arrays.len());
    Ok(lost.findings())
}

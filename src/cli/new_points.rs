//! Lists of points, `POINT,X,Y,Z` in every line.

use std::collections::BTreeSet;
use std::path::Path;

use crate::dof::Dof;
use crate::error::Error;
use crate::geometry::{Geometry, Node};
use crate::io::Catalog;
use crate::linalg::Vector3;
use crate::scene::{TableContent, read_text};

/// Format of tables of text.
pub(super) const TABLE_FORMAT: &str = "table";

/// Points of a list of lines `POINT,X,Y,Z`; a heading, a first line without numbers, and comments
/// (`#`) are ignored.
pub(super) fn read_points(path: &Path) -> Result<Geometry, Error> {
    let name = path.display().to_string();
    let text = read_text(path)?;
    let mut geometry = Geometry::default();
    let mut known = BTreeSet::new();
    let mut has_heading = false;
    for (index, line) in text.lines().enumerate() {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let numbers: Vec<f64> = fields[1..]
            .iter()
            .filter_map(|text| text.parse().ok())
            .collect();
        let is_finite = numbers.iter().all(|value| value.is_finite());
        let is_point = is_finite && format!("{}:+X", fields[0]).parse::<Dof>().is_ok();
        let expected = match numbers.as_slice() {
            [x, y, z] if is_point && fields.len() == 4 => {
                if known.insert(fields[0]) {
                    let place = Vector3::new(*x, *y, *z);
                    geometry.nodes.push(Node::new(fields[0], place));
                    continue;
                }
                "every point once"
            }
            _ if line.trim().is_empty() || line.starts_with('#') => continue,
            [] if index == 0 => {
                has_heading = true;
                continue;
            }
            _ => {
                "POINT,X,Y,Z in metres in every line, such as `1,0.25,0,0`, below an optional \
                 heading such as `point,x,y,z`"
            }
        };
        let heading = match has_heading {
            true => " (line 1 was taken as the heading)",
            false => "",
        };
        let got = format!("{line:?} in line {} of {name}{heading}", index + 1);
        return Err(Error::Argument {
            argument: "--points",
            got,
            expected: expected.to_owned(),
        });
    }
    Ok(geometry)
}

/// The points of a table without a column of a test, under a heading of coordinates or with names
/// in whole numbers from 1.
pub(super) fn list_of_points(path: &Path, catalog: &Catalog) -> Option<Geometry> {
    let is_candidate = match TableContent::of(catalog) {
        Some(table) => !table.has_known_column && catalog.format == TABLE_FORMAT,
        None => false,
    };
    let points = is_candidate.then(|| read_points(path).ok()).flatten()?;
    let text = read_text(path).ok()?;
    let heading = text.lines().next().unwrap_or_default().to_lowercase();
    let names: Vec<&str> = heading.split(',').map(str::trim).skip(1).collect();
    let has_heading = names
        .iter()
        .zip(["x", "y", "z"])
        .all(|(name, axis)| name.starts_with(axis));
    let mut numbers = points.nodes.iter().zip(1_usize..);
    let is_counted = numbers
        .all(|(node, number)| node.point.parse() == Ok::<usize, std::num::ParseIntError>(number));
    let is_short = points.nodes.len() < MIN_SAMPLES;
    (names.len() == 3 && has_heading || is_counted && is_short).then_some(points)
}

/// Minimum number of rows of four unnamed columns that are taken for samples, where the first
/// counts them from 1. Larger: a record whose samples are counted is taken for points. Smaller: the
/// points of a test are drafted as its record. Test
/// `lists_of_points_alone_are_no_recordings`.
const MIN_SAMPLES: usize = 256;

/// The option that takes coordinates of points.
pub(super) const POINTS_OPTION: &str =
    "coordinates of points are an option of `new`, --points FILE";

/// Whether a file has a line with three numbers, as coordinates of points have.
pub(super) fn may_hold_points(path: &Path) -> bool {
    let has_three_numbers = |line: &str| {
        let fields = line.split([',', ';', '\t', ' ']);
        let numbers = fields.filter(|field| field.trim().parse::<f64>().is_ok());
        numbers.count() >= 3
    };
    read_text(path).is_ok_and(|text| text.lines().any(has_three_numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_points_is_read_in_full_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_points(&path).map(|geometry| geometry.nodes.len())
        };
        assert_eq!(
            read("point,x,y,z\n1,0,0,0\n\n# end\n2,0.1,0,0\n").unwrap(),
            2
        );
        for (text, line) in [
            ("1,0.1,0\n2,0,0,0\n", "line 1"),
            ("1,0.1,0,here\n2,0,0,0\n", "line 1"),
            ("1,inf,0,0\n", "line 1"),
            ("1,0,0,0\n2,0,NaN,0\n", "line 2"),
            ("1,0,0,0\n2,0,0,0\n1,0,0,1\n", "line 3"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(line), "{error}");
        }
    }
}

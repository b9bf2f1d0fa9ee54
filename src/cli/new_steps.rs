//! The text of `new` says what the user has still to state, with the options that state it, and the
//! next command.

use std::path::Path;

use crate::geometry::Geometry;
use crate::io::FunctionType;
use crate::linalg::Vector3;
use crate::printable::counted;
use crate::scene::{Draft, DraftFile, ModelDraft, OpenLine, TableContent, open_lines};

use super::args::NewArgs;
use super::first_names::first_names;

/// Options that fill in lines of a draft: the key of the line, the beginning of what it expects,
/// and the option.
const OPTIONS_OF_LINES: &[(&str, &str, &str)] = &[
    ("response", "", "--response DOF"),
    ("dof", "the sensor", "--response DOF"),
    ("reference", "", "--reference DOF"),
    ("dof", "the hit point", "--reference DOF"),
    ("unit", "(", "--unit '(m/s2)/N'"),
    ("unit", "of the FRFs", "--unit '(m/s2)/N'"),
    ("unit", "", "--unit UNIT"),
    ("sampling_rate_hz", "", "--sampling-rate HZ"),
    ("at_m", "", "--points FILE"),
];

/// The open lines of the scene, the options that fill them in, and the next command.
pub(super) fn next_steps(
    args: &NewArgs,
    files: &[DraftFile],
    draft: &Draft,
    points: Option<&Geometry>,
    has_positions: bool,
) -> String {
    let path = args.folder.join("scene.toml");
    let open = open_lines(&draft.scene);
    let mut paragraphs = vec![match open.is_empty() {
        true if same_pair_count(files).is_some() => {
            format!(
                "{}: complete, but several files have the same DOFs (below).",
                path.display()
            )
        }
        true => format!("{}: nothing is left to fill in.", path.display()),
        false => {
            let lines = open_text(&open);
            let count = counted(open.len(), "line");
            format!("{}: {count} to be filled in:{lines}", path.display())
        }
    }];
    let mut options: Vec<&str> = Vec::new();
    for line in &open {
        let mut known = OPTIONS_OF_LINES.iter();
        let option =
            known.find(|(key, begins, _)| line.key == *key && line.expected.starts_with(begins));
        if let Some((.., option)) = option
            && !options.contains(option)
        {
            options.push(option);
        }
    }
    if !options.is_empty() {
        paragraphs.push(format!(
            "Options of `modalign new` fill in such lines, in a new folder: {}.",
            options.join(", ")
        ));
    }
    paragraphs.extend(unstated_of_columns(files));
    if let Some(count) = same_pair_count(files) {
        paragraphs.push(format!(
            "{count} files have the same response and reference: FRFs of one pair, measured again. \
             A roving test needs one DOF for each file: --reference DOF,DOF,...{}",
            match files.iter().any(|file| file.responses.len() > 1) {
                true => "",
                false => " or --response DOF,DOF,...",
            }
        ));
    }
    if !has_positions {
        paragraphs.push(
            "No positions are stated: figures of shapes have the points in a row (--points FILE with \
             lines POINT,X,Y,Z in metres)."
                .to_owned(),
        );
    }
    if let Some(extent_m) = extent_m(points, files).filter(|extent_m| *extent_m > MAX_EXTENT_M) {
        paragraphs.push(format!(
            "The points extend over {extent_m:.0} m. Positions are in metres: write 0.25 for \
             250 mm."
        ));
    }
    if !draft.points_without_position.is_empty() {
        let mut points = draft.points_without_position.clone();
        points.sort_by_cached_key(|point| point.parse::<u64>().unwrap_or(u64::MAX));
        let points = first_names(&points);
        paragraphs.push(format!("No position is stated for: {points}."));
    }
    paragraphs.push(
        "SOURCE.md (where the data come from) and expected.toml (published results) are optional."
            .to_owned(),
    );
    if let Some(model) = args.model.as_deref().and_then(ModelDraft::at) {
        let path = args.folder.join(ModelDraft::FILE);
        let values = match (model.kind, draft.line) {
            ("beam", Some(line)) => format!(
                "its length of {} m is a guess, the distance of the outermost points: state the \
                 true ends, from_m and to_m; bending is that of the hits; the other values are \
                 those",
                (1e4 * line.length_m()).round() / 1e4
            ),
            _ => "the values are those".to_owned(),
        };
        paragraphs.push(format!(
            "{}: {values} of an example; state those of the structure.",
            path.display()
        ));
    }
    let next = if args.model.is_some() {
        "the comparison table"
    } else {
        "the modes; a [model] makes them a comparison"
    };
    paragraphs.push(format!(
        "Then: modalign run {} prints {next}.",
        shell_quoted(&args.folder)
    ));
    paragraphs.join("\n")
}

/// Maximum extent of a structure without a remark on the unit of its positions.
/// Larger: positions in millimetres of a part below that many millimetres are taken as metres.
/// Smaller: footbridges, and aircraft in a ground vibration test, have the remark.
/// No measurement supports the value, so that it decides about a remark alone. The test is
/// `positions_that_may_be_millimetres_are_named`.
const MAX_EXTENT_M: f64 = 50.0;

/// The diagonal of the box around the stated points and those of the files.
fn extent_m(points: Option<&Geometry>, files: &[DraftFile]) -> Option<f64> {
    let of_files = files.iter().map(|file| &file.catalog.geometry);
    let nodes = points
        .into_iter()
        .chain(of_files)
        .flat_map(|all| &all.nodes);
    let positions: Vec<Vector3> = nodes.map(|node| node.at_m).collect();
    let first = positions.first()?;
    let corners = positions.iter().fold((*first, *first), |(low, high), at| {
        let bound = |bound: fn(f64, f64) -> f64, to: &Vector3| {
            Vector3::new(
                bound(to[0], at[0]),
                bound(to[1], at[1]),
                bound(to[2], at[2]),
            )
        };
        (bound(f64::min, &low), bound(f64::max, &high))
    });
    let squares = (0..3).map(|axis| (corners.1[axis] - corners.0[axis]).powi(2));
    Some(squares.sum::<f64>().sqrt())
}

/// Number of files with FRFs, where all of them take both DOFs from the options, the same ones;
/// `None` for a single file.
fn same_pair_count(files: &[DraftFile]) -> Option<usize> {
    let is_open = |file: &&DraftFile| {
        let mut entries = file.catalog.entries.iter();
        let is_table = TableContent::of(file.catalog).is_some_and(|table| table.is_functions);
        is_table
            || entries.any(|entry| {
                entry.function_type == FunctionType::Frf
                    && entry.response.is_none()
                    && entry.reference.is_none()
            })
    };
    let open: Vec<&DraftFile> = files.iter().filter(is_open).collect();
    let is_same = |file: &&DraftFile| {
        !file.responses.is_empty()
            && file.reference.is_some()
            && (file.responses, file.reference) == (open[0].responses, open[0].reference)
    };
    (open.len() > 1 && open.iter().all(is_same)).then_some(open.len())
}

/// The statements that columns without a known heading need in addition to their roles, each with
/// its option, as far as none is stated; `None` where nothing is missing.
fn unstated_of_columns(files: &[DraftFile]) -> Option<String> {
    let is_unnamed = |file: &&DraftFile| {
        TableContent::of(file.catalog)
            .is_some_and(|table| table.unknown_columns > 0 && table.responses == 0)
    };
    let file = files.iter().find(is_unnamed)?;
    let (units, has_frf_unit) = (file.units, file.units.frf.is_some());
    let missing = [
        (
            units.force.or(units.response).or(units.frf).is_none(),
            "unit of each force, response or FRF: --unit N,m/s2, or of FRFs --unit '(m/s2)/N'",
        ),
        (
            file.responses.is_empty() && !has_frf_unit,
            "point and direction of each response: --response DOF,...",
        ),
        (
            file.reference.is_none() && !has_frf_unit,
            "point and direction of the hit: --reference DOF, or one for each file",
        ),
        (
            file.sampling_rate_hz.is_none() && !has_frf_unit,
            "samples per second, where no column is time or frequency: --sampling-rate HZ",
        ),
    ];
    let missing: Vec<&str> = missing
        .into_iter()
        .filter_map(|(is_missing, what)| is_missing.then_some(what))
        .collect();
    (!missing.is_empty()).then(|| {
        format!(
            "Columns without a heading also need (`run` asks once their roles are stated):\n  {}",
            missing.join("\n  ")
        )
    })
}

/// The open lines, those of one key and expectation together.
fn open_text(open: &[OpenLine]) -> String {
    // A position begins with its point.
    let expected = |line: &OpenLine| -> String {
        let text = line.expected.as_str();
        let position = text.split_once(": ").filter(|_| line.key == "at_m");
        position.map_or(text, |(_, expected)| expected).to_owned()
    };
    let mut alike: Vec<(&OpenLine, Vec<String>)> = Vec::new();
    for line in open {
        let number = line.line.to_string();
        let same = |(first, _): &&mut (&OpenLine, Vec<String>)| {
            (&first.key, expected(first)) == (&line.key, expected(line))
        };
        match alike.iter_mut().find(same) {
            Some((_, numbers)) => numbers.push(number),
            None => alike.push((line, vec![number])),
        }
    }
    let text = |(line, numbers): &(&OpenLine, Vec<String>)| {
        let lines = if numbers.len() == 1 { "line" } else { "lines" };
        let numbers = numbers.join(", ");
        format!("\n  {lines} {numbers}: {}: {}", line.key, expected(line))
    };
    alike.iter().map(text).collect()
}

/// A path quoted for a shell.
pub(super) fn shell_quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain =
        |c: char| c.is_alphanumeric() || "/._-+:,@%=".contains(c) || (cfg!(windows) && c == '\\');
    if text.chars().all(is_plain) {
        text
    } else if cfg!(windows) {
        format!("\"{text}\"")
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_path_is_quoted_where_a_shell_would_part_it() {
        assert_eq!(shell_quoted(Path::new("out/beam-1")), "out/beam-1");
        assert_eq!(shell_quoted(Path::new("the beam")), "'the beam'");
        assert_eq!(shell_quoted(Path::new("it's")), r"'it'\''s'");
    }
}

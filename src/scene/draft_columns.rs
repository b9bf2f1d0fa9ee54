//! Columns and arrays in a drafted scene, whose contents the user has to state.

use crate::printable::counted;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::dof::Dof;
use crate::io::{ArrayInfo, Catalog};
use crate::quantity::{FrfUnit, Quantity, Unit};

use super::draft_file::{Content, DraftFile, StatedUnits, file_text, unit_line};
use super::toml_text::{FILL_IN, quoted};

/// Maximum number of columns of an array that is listed column by column.
const MAX_COLUMNS: usize = 16;

/// Roles of columns that hold responses or FRFs; one function may have one column of each.
const RESPONSE_ROLES: [&str; 5] = ["response", "real", "imaginary", "magnitude", "complex"];

/// What a draft takes the columns of a file for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TableContent {
    /// Whether they are FRFs; time records otherwise.
    pub is_functions: bool,
    /// Number of responses or FRFs in the file.
    pub responses: usize,
    /// Whether a heading says what its column holds.
    pub has_known_column: bool,
    /// Number of columns whose heading does not say what they hold.
    pub unknown_columns: usize,
    /// Whether an array has an axis of channels beside those of hits and samples, so that no
    /// column is time or frequency.
    pub has_channel_axis: bool,
}

impl TableContent {
    /// `None` where the file states itself what it holds.
    pub fn of(catalog: &Catalog) -> Option<Self> {
        let is_table = Content::of(catalog) == Content::Arrays;
        is_table.then(|| {
            let arrays = number_arrays(catalog);
            let draft = columns_to_state(&arrays);
            let known = |column: &DraftColumn| column.role.is_some() && !column.is_open();
            TableContent {
                has_known_column: draft.columns.iter().any(known),
                has_channel_axis: has_hit_axis(&arrays),
                ..Self::of_roles(&draft.roles())
            }
        })
    }

    fn of_roles(roles: &[Option<&str>]) -> Self {
        let count = |role: &str| roles.iter().filter(|other| **other == Some(role)).count();
        TableContent {
            is_functions: count("frequency") + count("complex") > 0,
            responses: RESPONSE_ROLES.into_iter().map(count).max().unwrap_or(0),
            has_known_column: false,
            unknown_columns: roles.iter().filter(|role| role.is_none()).count(),
            has_channel_axis: false,
        }
    }

    /// Whether unnamed columns may be this number of responses: all but a force, and but an axis of
    /// time where the columns are no channels of an array.
    pub fn may_hold_responses(&self, count: usize) -> bool {
        let others = if self.has_channel_axis { 1..=1 } else { 1..=2 };
        count > 1
            && self.responses == 0
            && self
                .unknown_columns
                .checked_sub(count)
                .is_some_and(|rest| others.contains(&rest))
    }
}

/// The role and the unit of a column that its heading states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnHeading {
    /// `time`, `force`, `real` or another role of `[[test.channel]]`.
    pub role: &'static str,
    /// Unit of a force, a response or an FRF.
    pub unit: Option<String>,
}

impl ColumnHeading {
    /// Whether its column is the axis of the others.
    #[must_use]
    pub fn is_axis(&self) -> bool {
        ["time", "frequency"].contains(&self.role)
    }

    /// Whether its column needs a unit that the heading does not state.
    #[must_use]
    pub fn lacks_unit(&self) -> bool {
        let has_none = self.is_axis() || ["phase", "coherence"].contains(&self.role);
        !has_none && self.unit.is_none()
    }
}

/// What the headings of an array's columns state, column by column.
pub type ColumnHeadings = Vec<Option<ColumnHeading>>;

/// The roles and units that the headings of each array's columns state, as a draft reads them;
/// nothing for an array that holds no numbers.
#[must_use]
pub fn column_headings(catalog: &Catalog) -> Vec<ColumnHeadings> {
    let draft = columns_to_state(&number_arrays(catalog)).columns;
    let mut stated = BTreeMap::new();
    for DraftColumn { name, role, unit } in draft {
        let heading = role.map(|role| ColumnHeading { role, unit });
        stated.entry(name).or_insert(heading);
    }
    let headings = |array: &ArrayInfo| match is_number(array) {
        true => {
            let columns = columns_of(array).into_iter();
            let heading = |name| stated.get(&name).cloned().flatten();
            columns.map(heading).collect()
        }
        false => Vec::new(),
    };
    catalog.arrays.iter().map(headings).collect()
}

/// Whether an array has an axis of hits beside those of channels and samples.
fn has_hit_axis(arrays: &[&ArrayInfo]) -> bool {
    arrays.iter().any(|array| array.shape.len() > 2)
}

fn is_number(array: &ArrayInfo) -> bool {
    !["text", "struct", "cell"].contains(&array.kind.as_str())
}

fn number_arrays(catalog: &Catalog) -> Vec<&ArrayInfo> {
    let arrays = catalog.arrays.iter();
    arrays.filter(|array| is_number(array)).collect()
}

/// Whether the files of two catalogs have columns of the same names; the name of an only array of
/// several channels does not count, for NumPy files have that of the file.
pub(super) fn has_same_columns(first: &Catalog, second: &Catalog) -> bool {
    let names = |catalog: &Catalog| -> Vec<(String, usize, Option<usize>)> {
        let has_channels = only_channels(&number_arrays(catalog)).is_some();
        let arrays = catalog
            .arrays
            .iter()
            .filter(|array| !has_channels || is_number(array));
        let name = |array: &ArrayInfo| match has_channels {
            true => (String::new(), array.shape.len(), channel_count(array)),
            false => (array.name.clone(), array.shape.len(), None),
        };
        arrays.map(name).collect()
    };
    names(first) == names(second)
}

/// Number of channels of an array with an axis of channels: the second axis of two or three, or
/// the first of two where it is short and the second is not.
fn channel_count(array: &ArrayInfo) -> Option<usize> {
    let is_channels = |count: &usize| (2..=MAX_COLUMNS).contains(count);
    match array.shape.as_slice() {
        [_, count, _] | [_, count] if is_channels(count) => Some(*count),
        [count, _] if is_transposed(array) => Some(*count),
        _ => None,
    }
}

/// Whether the rows of an array are channels, not samples.
fn is_transposed(array: &ArrayInfo) -> bool {
    let is_few = |count: usize| (2..=MAX_COLUMNS).contains(&count);
    matches!(array.shape.as_slice(), [rows, columns] if is_few(*rows) && *columns > MAX_COLUMNS)
}

/// The number of channels of the only array.
fn only_channels(arrays: &[&ArrayInfo]) -> Option<usize> {
    match arrays {
        [only] => channel_count(only),
        _ => None,
    }
}

/// Columns and arrays: their names are known, their meaning where a heading says it.
pub(super) fn arrays_text(files: &[&DraftFile], dofs: &mut BTreeSet<Dof>) -> String {
    let arrays = number_arrays(files[0].catalog);
    let all = arrays.iter().flat_map(|array| columns_of(array)).count();
    let mut draft = columns_to_state(&arrays);
    let names = files.iter().flat_map(|file| number_arrays(file.catalog));
    let names: BTreeSet<&str> = names.map(|array| array.name.as_str()).collect();
    let is_array = has_hit_axis(&arrays);
    if only_channels(&arrays).is_some_and(|count| count == draft.columns.len())
        && (is_array || names.len() > 1)
    {
        // The name of the array is that of one file.
        for (number, column) in (1..).zip(&mut draft.columns) {
            column.name = number.to_string();
        }
    }
    let roles = draft.roles();
    let content = TableContent::of_roles(&roles);
    // Columns without a known heading are FRFs where the user states a unit of FRFs.
    let has_unknown = roles.contains(&None);
    let is_function = content.is_functions || has_unknown && files[0].units.frf.is_some();
    let DraftColumns { columns, unused } = draft;
    let is_known = !has_unknown && unused.is_empty() && columns.iter().all(|c| !c.is_open());
    let has_axis = is_function || roles.contains(&Some("time"));
    let mut text = format!("# The file holds {}", counted(all, "column"));
    let lengths: BTreeSet<usize> = arrays
        .iter()
        .flat_map(|array| array.shape.iter().copied().max())
        .collect();
    if let (Some(most), 1) = (lengths.last(), lengths.len()) {
        let _ = write!(text, " of {most} values each");
    }
    text += match is_known {
        true => "; the names state what they hold\n",
        false => "; the names do not state what all of them hold\n",
    };
    if !unused.is_empty() {
        text += &format!("# Not used below: {}\n", unused.join(", "));
    }
    if !is_function && !is_array {
        text += if files.len() > 1 && has_unknown && content.responses == 0 {
            "# hits = \"files\"          # where these are time records: each file is one hit\n"
        } else if files.len() > 1 {
            "hits = \"files\"            # each file is one hit\n"
        } else {
            "# hits = \"trigger\"        # where the record is continuous and holds several hits\n"
        };
    }
    if !has_axis {
        let _ = match files[0].sampling_rate_hz {
            Some(rate) => writeln!(text, "sampling_rate_hz = {rate}"),
            // A column may turn out to be the axis.
            None if has_unknown && !is_array => writeln!(
                text,
                "# sampling_rate_hz = 1000.0   # samples per second, where no column is time or frequency"
            ),
            None => writeln!(
                text,
                "sampling_rate_hz = \"{FILL_IN}\"   # samples per second, a number without quotes"
            ),
        };
    }
    text += &dimensions_text(&arrays);
    let hit_points: BTreeSet<Option<&Dof>> = files.iter().map(|file| file.reference).collect();
    // One hit point of all files stands with the force, several with their files.
    // No column with a known heading takes the stated points.
    let takes_hit_point = has_unknown && !roles.contains(&Some("force"));
    let states_hit_point = files[0].reference.is_some();
    let by_file = is_function
        || hit_points.len() > 1
        || takes_hit_point && (states_hit_point || is_array && files.len() > 1);
    let responses: BTreeSet<&[Dof]> = files.iter().map(|file| file.responses).collect();
    let states_response = files[0].response().is_some();
    let response_by_file = match content.responses {
        0 => has_unknown && (is_function || states_response) || responses.len() > 1,
        1 => responses.len() > 1,
        _ => false,
    };
    let stated = StatedPoints {
        responses: match files[0].responses {
            stated if stated.len() == content.responses && responses.len() == 1 => stated,
            _ => &[],
        },
        hit_point: files[0].reference.filter(|_| !by_file),
        by_file,
        response_by_file,
        units: files[0].units,
    };
    let unknown = UnknownColumns {
        units: files[0].units,
        responses: match files[0].responses {
            stated if stated.len() > 1 && content.may_hold_responses(stated.len()) => stated,
            _ => &[],
        },
        count: content.unknown_columns,
    };
    for (index, column) in columns.iter().enumerate() {
        // The columns of one role are those of the responses in their order.
        let of_role = |roles: &[Option<&str>]| roles.iter().filter(|r| **r == column.role).count();
        let response = (of_role(&roles) == content.responses)
            .then(|| stated.responses.get(of_role(&roles[..index])));
        let has_several = content.responses > 1;
        text += &match column.role {
            Some(role) => stated.column_text(column, role, response.flatten(), has_several, dofs),
            None => unknown.column_text(&column.name, index, dofs),
        };
    }
    for file in files.iter().filter(|_| by_file || response_by_file) {
        text += &file_text(file, response_by_file, by_file, dofs);
    }
    text
}

/// `dimensions` of arrays whose rows are not samples or that have more than two dimensions.
fn dimensions_text(arrays: &[&ArrayInfo]) -> String {
    let shape = |array: &ArrayInfo| {
        let lengths: Vec<String> = array.shape.iter().map(ToString::to_string).collect();
        lengths.join(" x ")
    };
    let mut all = arrays.iter();
    if let Some(array) = all.clone().find(|array| array.shape.len() > 2) {
        return format!(
            "dimensions = [\"{FILL_IN}\"]   # of {}, slowest first, such as [\"hit\", \"channel\", \"sample\"]; the channels are columns 1, 2, ...\n",
            shape(array)
        );
    }
    all.find(|array| is_transposed(array))
        .map_or_else(String::new, |array| {
            format!(
                "dimensions = [\"channel\", \"sample\"]   # of {}, slowest first\n",
                shape(array)
            )
        })
}

/// A column of a draft.
struct DraftColumn {
    /// As `[[test.channel]] column` names it.
    name: String,
    /// By its name or kind; to be stated by the user without it.
    role: Option<&'static str>,
    /// Unit in brackets behind its heading, where its role has one.
    unit: Option<String>,
}

impl DraftColumn {
    /// Whether the user has to name the column.
    fn is_open(&self) -> bool {
        self.name == quoted(FILL_IN)
    }
}

/// The columns of a draft, and the names of the arrays that it does not use.
struct DraftColumns {
    columns: Vec<DraftColumn>,
    unused: Vec<String>,
}

impl DraftColumns {
    fn roles(&self) -> Vec<Option<&'static str>> {
        self.columns.iter().map(|column| column.role).collect()
    }
}

/// Maximum number of columns without a recognised heading that a draft lists one by one.
const MAX_UNNAMED_COLUMNS: usize = 8;

/// Columns of an array with the roles and units that their headings state.
fn draft_columns(array: &ArrayInfo) -> Vec<DraftColumn> {
    let unit = heading_unit(&array.name);
    let column = |name: String| {
        let role = role_of(&name);
        let is_of_role = |unit: &&str| role.is_some_and(|role| is_unit_of(unit, role));
        DraftColumn {
            unit: unit.filter(is_of_role).map(str::to_owned),
            role,
            name,
        }
    };
    columns_of(array).into_iter().map(column).collect()
}

/// FRFs with their coherence where arrays are recognised as such; else every column, or where most
/// of many columns have no known heading, those that have one and two to be stated.
fn columns_to_state(arrays: &[&ArrayInfo]) -> DraftColumns {
    if let Some(found) = frf_columns(arrays) {
        return found;
    }
    let columns: Vec<DraftColumn> = arrays.iter().copied().flat_map(draft_columns).collect();
    let (known, unknown): (Vec<DraftColumn>, Vec<DraftColumn>) = columns
        .into_iter()
        .partition(|column| column.role.is_some());
    if unknown.len() <= MAX_UNNAMED_COLUMNS {
        let all = arrays.iter().copied().flat_map(draft_columns);
        return DraftColumns {
            columns: all.collect(),
            unused: Vec::new(),
        };
    }
    let has = |role: &str| known.iter().any(|column| column.role == Some(role));
    let wanted: &[&'static str] = match has("frequency") {
        true => &["real", "imaginary"],
        false => &["force", "response"],
    };
    let wanted = wanted.iter().copied().filter(|role| !has(role));
    let to_state: Vec<DraftColumn> = wanted
        .map(|role| DraftColumn {
            name: quoted(FILL_IN),
            role: Some(role),
            unit: None,
        })
        .collect();
    DraftColumns {
        columns: known.into_iter().chain(to_state).collect(),
        unused: unknown.into_iter().map(|column| column.name).collect(),
    }
}

/// Complex arrays of an axis and values, with the coherence of the same channels: `H1_2` with
/// `C1_2`, or any with `FRF` in its name. `None` without such an array.
fn frf_columns(arrays: &[&ArrayInfo]) -> Option<DraftColumns> {
    let channels = |array: &ArrayInfo, letter: char| {
        let channels = array.name.strip_prefix(letter)?;
        let (input, output) = channels.split_once('_')?;
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        (is_number(input) && is_number(output)).then(|| channels.to_owned())
    };
    let is_frf = |array: &ArrayInfo| {
        array.kind.starts_with("complex")
            && matches!(array.shape.as_slice(), [_, 2])
            && (channels(array, 'H').is_some() || array.name.to_uppercase().contains("FRF"))
    };
    // FRFs on the axis of the first.
    let mut frfs: Vec<&ArrayInfo> = arrays.iter().copied().filter(|a| is_frf(a)).collect();
    let axis_length = frfs.first()?.shape.clone();
    frfs.retain(|frf| frf.shape == axis_length);
    let column = |array: &ArrayInfo, number: usize, role: &'static str| DraftColumn {
        name: quoted(&format!("{}:{number}", array.name)),
        role: Some(role),
        unit: None,
    };
    let mut columns = vec![column(frfs.first()?, 1, "frequency")];
    let mut used = Vec::new();
    for frf in frfs {
        columns.push(column(frf, 2, "complex"));
        used.push(frf.name.as_str());
        let pair = channels(frf, 'H');
        let mut others = arrays.iter().copied();
        let coherence = others.find(|array| {
            pair.is_some() && channels(array, 'C') == pair && array.shape == frf.shape
        });
        if let Some(coherence) = coherence {
            columns.push(column(coherence, 2, "coherence"));
            used.push(coherence.name.as_str());
        }
    }
    let names = arrays.iter().map(|array| array.name.as_str());
    let unused = names.filter(|name| !used.contains(name));
    Some(DraftColumns {
        columns,
        unused: unused.map(str::to_owned).collect(),
    })
}

/// The columns of an array, as `[[test.channel]] column` names them.
fn columns_of(array: &ArrayInfo) -> Vec<String> {
    let number = array.name.strip_prefix("column ");
    if let Some(number) = number.and_then(|number| number.parse::<usize>().ok()) {
        return vec![number.to_string()];
    }
    let Some(count) = channel_count(array) else {
        return vec![quoted(heading(&array.name))];
    };
    let channel = |number: usize| match array.name.as_str() {
        "" => number.to_string(),
        name => quoted(&format!("{name}:{number}")),
    };
    (1..=count).map(channel).collect()
}

/// The heading without the unit that is listed behind it.
fn heading(name: &str) -> &str {
    match (name.rfind(" ["), name.ends_with(']')) {
        (Some(at), true) => &name[..at],
        _ => name,
    }
}

/// The unit in brackets behind a heading.
fn heading_unit(name: &str) -> Option<&str> {
    let (open, closed) = match name.chars().last()? {
        ']' => (name.rfind('[')?, ']'),
        ')' => (name.find('(')?, ')'),
        _ => return None,
    };
    name[open + 1..].strip_suffix(closed).map(str::trim)
}

/// Whether a text is a unit of a column of this role.
fn is_unit_of(text: &str, role: &str) -> bool {
    let quantity = || text.parse::<Unit>().ok().map(|unit| unit.quantity);
    match role {
        "force" => quantity() == Some(Quantity::Force),
        "response" => quantity().is_some_and(|quantity| quantity != Quantity::Force),
        "real" | "imaginary" | "magnitude" | "complex" => text.parse::<FrfUnit>().is_ok(),
        _ => false,
    }
}

/// Role of a column by its name.
fn role_of(name: &str) -> Option<&'static str> {
    let text = name.to_lowercase();
    let says = |words: &[&str]| words.iter().any(|word| text.contains(word));
    match () {
        () if says(&["coherence"]) => Some("coherence"),
        () if says(&["phase"]) => Some("phase"),
        () if says(&["magnitude"]) => Some("magnitude"),
        () if says(&["imag"]) => Some("imaginary"),
        () if says(&["real"]) => Some("real"),
        () if says(&["frequency", "freq", "hz"]) => Some("frequency"),
        () if says(&["time"]) => Some("time"),
        () if says(&["force", "hammer"]) => Some("force"),
        () if says(&["acc", "velocity", "displacement", "response"]) => Some("response"),
        () => None,
    }
}

/// Statements of the user on columns without a known heading.
struct UnknownColumns<'a> {
    units: StatedUnits<'a>,
    /// The responses of such columns in their order; none where they are those of the files.
    responses: &'a [Dof],
    /// Number of such columns.
    count: usize,
}

impl UnknownColumns<'_> {
    /// The lines of a column, by its number from 0. The first column is the axis as a rule, so that
    /// a stated unit of FRFs is put on the others.
    fn column_text(&self, name: &str, index: usize, dofs: &mut BTreeSet<Dof>) -> String {
        let units = self.units;
        let mut text = format!(
            "[[test.channel]]\ncolumn = {name}\n\
             role = \"{FILL_IN}\"   # time, frequency, force, response, real, imaginary, complex, magnitude, phase or coherence\n"
        );
        let stated = [
            (units.force, "where it is a force"),
            (units.response, "where it is a response"),
            (units.frf.filter(|_| index == 0), "where it is an FRF"),
        ];
        let stated = stated
            .into_iter()
            .filter_map(|(unit, of)| Some((unit?, of)));
        let remarks: String = stated
            .map(|(unit, of)| format!("# unit = {}   # {of}\n", quoted(unit)))
            .collect();
        text += &match units.frf.filter(|_| index > 0) {
            Some(unit) => format!(
                "unit = {}   # of real, imaginary, complex or magnitude; the others have none\n",
                quoted(unit)
            ),
            None if remarks.is_empty() => {
                "# unit = \"m/s2\"        # of a force, a response or FRF; of an axis only ms, us or kHz\n"
                    .to_owned()
            }
            None => remarks,
        };
        if self.responses.is_empty() {
            return text
                + "# dof = \"1:+Z\"         # point and direction of a sensor or hit; an axis has none\n";
        }
        dofs.extend(self.responses.iter().map(Dof::positive));
        // Columns before this one are responses, force or axis.
        let others = self.count.saturating_sub(self.responses.len());
        let first = index.saturating_sub(others);
        let candidates = self.responses.iter().enumerate();
        for (number, dof) in candidates.take(index + 1).skip(first) {
            let number = number + 1;
            let _ = writeln!(
                text,
                "# dof = \"{dof}\"   # where it is response {number} in the order of the columns"
            );
        }
        text
    }
}

/// Points of columns that the user has stated.
struct StatedPoints<'a> {
    /// One for each response or FRF, or none.
    responses: &'a [Dof],
    hit_point: Option<&'a Dof>,
    /// Whether hit points stand with the files.
    by_file: bool,
    /// Whether the responses do.
    response_by_file: bool,
    units: StatedUnits<'a>,
}

impl StatedPoints<'_> {
    /// `response`: the stated one of this column; `has_several`: whether the file has several
    /// responses, so that a coherence says whose it is.
    fn column_text(
        &self,
        column: &DraftColumn,
        role: &str,
        response: Option<&Dof>,
        has_several: bool,
        dofs: &mut BTreeSet<Dof>,
    ) -> String {
        let mut text = format!("[[test.channel]]\ncolumn = {}\n", column.name);
        let _ = writeln!(text, "role = \"{role}\"   # by its name");
        let (unit, accepted, stated, what) = match role {
            "force" => (
                self.units.force,
                "N, lbf or kN; with `scale` where a calibration is missing",
                self.hit_point,
                "the hit point with its direction",
            ),
            "response" => (
                self.units.response,
                "m/s2, g, m/s or m; with `scale` where a calibration is missing",
                response,
                "the sensor with its direction",
            ),
            "coherence" if has_several => {
                let _ = match response {
                    Some(dof) => writeln!(text, "dof = \"{dof}\""),
                    None => writeln!(text, "dof = \"{FILL_IN}\"   # that of its FRF"),
                };
                return text;
            }
            "real" | "imaginary" | "magnitude" | "complex" => {
                let accepted = "(m/s2)/N, (m/s)/N or m/N";
                (self.units.frf, accepted, response, "the sensor")
            }
            _ => return text,
        };
        text += &match (unit, &column.unit) {
            (None, Some(unit)) => format!("unit = {}   # by its name\n", quoted(unit)),
            (unit, _) => unit_line(unit, accepted),
        };
        let is_by_file = match role {
            "force" => self.by_file,
            _ => self.response_by_file,
        };
        if is_by_file {
            return text;
        }
        dofs.extend(stated.map(Dof::positive));
        let _ = match stated {
            Some(dof) => writeln!(text, "dof = \"{dof}\""),
            None => writeln!(text, "dof = \"{FILL_IN}\"   # {what}, such as 1:+Z"),
        };
        text
    }
}

//! Statements of the user that no line of a drafted scene holds, with the reason.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::io::{Entry, EntryAxis, FunctionType};
use crate::quantity::{FrfKind, FrfUnit, Quantity, Unit};

use super::draft_columns::TableContent;
use super::draft_file::{Content, DraftFile};
use super::toml_text::quoted;

/// A statement of the user in addition to the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statement {
    /// Unit of forces, responses or FRFs.
    Unit,
    /// Response of files.
    Response,
    /// Excitation point of files.
    Reference,
    /// Samples per second.
    SamplingRate,
}

/// A statement that the draft does not use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnusedStatement {
    /// The statement.
    pub statement: Statement,
    /// Its value.
    pub got: String,
    /// The statement that these files need instead, and why.
    pub expected: String,
}

/// The statements that neither the tests of the draft hold, not even in a remark, nor the headers.
pub(super) fn unused_statements(tests: &str, files: &[DraftFile]) -> Vec<UnusedStatement> {
    let holds = |key: &str, value: &str| {
        let wanted = format!("{key} = {value}");
        let lines = tests.lines().map(|line| line.trim_start_matches("# "));
        let mut rest = lines.filter_map(|line| line.strip_prefix(wanted.as_str()));
        rest.any(|rest| rest.is_empty() || rest.starts_with(' '))
    };
    let stated = Headers { files };
    let mut unused = Vec::new();
    let mut add = |statement, got: &str, expected: String| {
        let got = got.to_owned();
        let found = UnusedStatement {
            statement,
            got,
            expected,
        };
        if !unused.contains(&found) {
            unused.push(found);
        }
    };
    for file in files {
        let units = file.units;
        for unit in [units.force, units.response, units.frf]
            .into_iter()
            .flatten()
        {
            if !holds("unit", &quoted(unit)) && !stated.have_unit(unit) {
                add(Statement::Unit, unit, stated.expected_unit(unit));
            }
        }
        let is_test = Content::of(file.catalog) != Content::Nothing;
        let responses = file.responses.iter().map(|dof| (Statement::Response, dof));
        let references = file.reference.map(|dof| (Statement::Reference, dof));
        for (statement, dof) in responses.chain(references).filter(|_| is_test) {
            let value = format!("\"{dof}\"");
            let keys = match statement {
                Statement::Reference => ["dof", "reference"],
                _ => ["dof", "response"],
            };
            let named = stated.points(statement);
            let is_held = keys.iter().any(|key| holds(key, &value));
            if !is_held && !named.contains(&dof.positive()) {
                let expected = expected_points(&named);
                add(statement, &dof.to_string(), expected);
            }
        }
        if let Some(rate) = file.sampling_rate_hz
            && !holds("sampling_rate_hz", &rate.to_string())
            && !stated.have_rate(rate)
        {
            let expected = match stated.rate() {
                Some(hz) => format!("none: the headers state {hz} Hz"),
                None => "none: no file holds time records without a time axis".to_owned(),
            };
            add(Statement::SamplingRate, &rate.to_string(), expected);
        }
    }
    unused
}

/// Maximum number of points that a message lists.
const MAX_LISTED_POINTS: usize = 3;

fn expected_points(named: &BTreeSet<Dof>) -> String {
    let first: Vec<String> = named
        .iter()
        .take(MAX_LISTED_POINTS)
        .map(ToString::to_string)
        .collect();
    let more = if named.len() > first.len() {
        ", ..."
    } else {
        ""
    };
    match named.is_empty() {
        true => "none: the files hold finished modes".to_owned(),
        false => format!("none: the headers state {}{more}", first.join(", ")),
    }
}

/// The headers of the files.
struct Headers<'a> {
    files: &'a [DraftFile<'a>],
}

impl<'a> Headers<'a> {
    fn entries(&self) -> impl Iterator<Item = &'a Entry> {
        self.files.iter().flat_map(|file| &file.catalog.entries)
    }

    fn have_unit(&self, text: &str) -> bool {
        let same = |to_si: f64, entry: &Entry| entry.to_si == Some(to_si);
        match (text.parse::<FrfUnit>(), text.parse::<Unit>()) {
            (Ok(unit), _) => self.entries().any(|entry| {
                let kind = entry.quantity.and_then(FrfKind::from_response);
                let over_force = entry.denominator == Some(Quantity::Force);
                over_force && kind == Some(unit.kind) && same(unit.to_si, entry)
            }),
            (_, Ok(unit)) => self.entries().any(|entry| {
                let is_time = entry.function_type == FunctionType::Time;
                is_time && entry.quantity == Some(unit.quantity) && same(unit.to_si, entry)
            }),
            _ => false,
        }
    }

    fn expected_unit(&self, unit: &str) -> String {
        let is_of_frfs = unit.parse::<FrfUnit>().is_ok();
        let (has_frfs, has_records) = (self.have_frfs(), self.have_records());
        if has_frfs && !has_records && !is_of_frfs {
            "a unit of response over force, such as (m/s2)/N: the files hold FRFs".to_owned()
        } else if has_records && !has_frfs && is_of_frfs {
            "a unit of the force and one of the responses, such as N,m/s2: the files hold time \
             records"
                .to_owned()
        } else if !has_frfs && !has_records {
            "none: the files hold neither time records nor FRFs".to_owned()
        } else if self.have_record_without_unit() {
            "none: a record without unit may be the force or a response, and the scene states \
             which"
                .to_owned()
        } else {
            let labels: BTreeSet<&str> = self
                .entries()
                .map(|entry| entry.unit_label.as_str())
                .filter(|label| !label.is_empty())
                .collect();
            let labels: Vec<&str> = labels.into_iter().take(MAX_LISTED_POINTS).collect();
            match labels.is_empty() {
                true => "a unit of a column of the files".to_owned(),
                false => format!(
                    "none: the headers state {}; `unit` in [[test.channel]] of the scene precedes \
                     them",
                    labels.join(", ")
                ),
            }
        }
    }

    fn have_record_without_unit(&self) -> bool {
        let is_record = |entry: &Entry| entry.function_type == FunctionType::Time;
        self.entries()
            .any(|entry| is_record(entry) && entry.quantity.is_none())
    }

    fn have_frfs(&self) -> bool {
        let is_table = |file: &DraftFile| {
            TableContent::of(file.catalog).is_some_and(|table| table.is_functions)
        };
        let is_functions = |file: &DraftFile| Content::of(file.catalog) == Content::Functions;
        self.files
            .iter()
            .any(|file| is_table(file) || is_functions(file))
    }

    fn have_records(&self) -> bool {
        let is_table = |file: &DraftFile| {
            TableContent::of(file.catalog).is_some_and(|table| !table.is_functions)
        };
        let is_records = |file: &DraftFile| Content::of(file.catalog) == Content::Records;
        self.files
            .iter()
            .any(|file| is_table(file) || is_records(file))
    }

    /// The points that the headers name as responses or as excitation points.
    fn points(&self, statement: Statement) -> BTreeSet<Dof> {
        let point = |entry: &'a Entry| match statement {
            Statement::Reference if entry.is_force() => {
                entry.response.as_ref().or(entry.reference.as_ref())
            }
            Statement::Reference => entry.reference.as_ref(),
            _ => entry.response.as_ref(),
        };
        let of_entries = self.entries().filter_map(point);
        of_entries.map(Dof::positive).collect()
    }

    fn rate(&self) -> Option<f64> {
        self.entries().find_map(|entry| match entry.axis {
            EntryAxis::Time(axis) => Some(axis.sampling_rate_hz()),
            _ => None,
        })
    }

    fn have_rate(&self, rate: f64) -> bool {
        let is_same = |hz: f64| (hz / rate - 1.0).abs() < 1e-9;
        self.rate().is_some_and(is_same)
    }
}

//! A function's note says how the function was made, as far as the file states it.

use crate::frf::{Estimator, Window};

/// The statements of a file about how a function was made. Universal files of modalign hold them in
/// their ID lines 4 and 5.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FunctionMetadata {
    /// Number of averages.
    pub averages: Option<u32>,
    /// Estimator.
    pub estimator: Option<Estimator>,
    /// Decay rate of the exponential window still in the values, rad/s.
    pub added_damping_rad_s: Option<f64>,
    /// Length of the records, s.
    pub record_s: Option<f64>,
    /// Where the function is valid, Hz.
    pub valid_hz: Option<(f64, f64)>,
    /// Degrees of freedom of the variance that belongs to it; modalign's schema alone holds it, as
    /// it does the variance.
    pub variance_dof: Option<f64>,
    /// Whether the lines were interpolated from unevenly measured ones.
    pub interpolated: bool,
    /// Window of the records; `None` where there was none or none is stated.
    pub window: Option<Window>,
}

/// The mark that the line begins with.
const NOTE_MARK: &str = "modalign ";
/// Columns of a line.
const LINE_COLUMNS: usize = 80;

impl FunctionMetadata {
    /// ID lines 4 and 5, such as `modalign averages=5 estimator=h1 added_damping_rad_s=12.5
    /// record_s=1.28`, empty where nothing is known. A line of a universal file holds 80
    /// characters; what does not fit is left away.
    pub fn to_lines(&self) -> [String; 2] {
        let mut lines = [Some(String::new()), Some(String::new())];
        pack_fields(&self.to_fields(), &mut lines);
        lines.map(Option::unwrap_or_default)
    }

    /// The stated properties, as `key=value`.
    pub(in crate::io) fn to_fields(&self) -> Vec<String> {
        let fields = [
            self.averages.map(|n| format!("averages={n}")),
            self.estimator
                .map(|estimator| format!("estimator={}", estimator.name())),
            self.added_damping_rad_s
                .map(|decay| format!("added_damping_rad_s={decay}")),
            self.record_s.map(|length| format!("record_s={length}")),
            self.valid_hz.map(|(lo, hi)| format!("valid_hz={lo}:{hi}")),
            self.interpolated.then(|| "interpolated=1".to_owned()),
        ];
        fields.into_iter().flatten().collect()
    }

    /// The note in the ID lines of a header; empty where they are another program's.
    pub fn from_lines(lines: &[String]) -> Self {
        let mut note = Self::default();
        for (key, value) in note_fields(lines) {
            match key {
                "averages" => note.averages = value.parse().ok(),
                "estimator" => note.estimator = Estimator::from_name(value),
                "added_damping_rad_s" => note.added_damping_rad_s = value.parse().ok(),
                "record_s" => note.record_s = value.parse().ok(),
                "valid_hz" => note.valid_hz = number_pair(value),
                "interpolated" => note.interpolated = value == "1",
                _ => {}
            }
        }
        note
    }
}

/// Whether a line is one of ours.
pub(in crate::io) fn is_note_line(line: &str) -> bool {
    line.starts_with(NOTE_MARK)
}

/// Keys and values of our lines among the ID lines of a header.
pub(in crate::io) fn note_fields(lines: &[String]) -> impl Iterator<Item = (&str, &str)> {
    let marked = lines.iter().filter_map(|line| line.strip_prefix(NOTE_MARK));
    marked
        .flat_map(str::split_whitespace)
        .filter_map(|field| field.split_once('='))
}

/// Puts fields into the first line that has room for them (`None` is a line that is taken) and
/// counts those that found none.
pub(in crate::io) fn pack_fields(fields: &[String], lines: &mut [Option<String>]) -> usize {
    let mut lost = 0;
    for field in fields {
        let room = lines.iter_mut().flatten().find(|line| {
            let mark = if line.is_empty() {
                NOTE_MARK.len() - 1
            } else {
                line.len()
            };
            mark + 1 + field.len() <= LINE_COLUMNS
        });
        match room {
            Some(line) if line.is_empty() => *line = format!("{NOTE_MARK}{field}"),
            Some(line) => *line = format!("{line} {field}"),
            None => lost += 1,
        }
    }
    lost
}

/// Two numbers with a colon between them.
pub(in crate::io) fn number_pair(text: &str) -> Option<(f64, f64)> {
    let (first, second) = text.split_once(':')?;
    Some((first.parse().ok()?, second.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_read_back_and_other_lines_are_no_note() {
        let note = FunctionMetadata {
            averages: Some(5),
            estimator: Some(Estimator::Hv),
            added_damping_rad_s: Some(12.5),
            record_s: Some(1.28),
            valid_hz: Some((0.25, 3276.5)),
            interpolated: true,
            ..FunctionMetadata::default()
        };
        let lines = note.to_lines();
        assert_eq!(FunctionMetadata::from_lines(&lines), note);
        assert_eq!(
            lines[0],
            "modalign averages=5 estimator=hv added_damping_rad_s=12.5 record_s=1.28"
        );
        assert_eq!(lines[1], "modalign valid_hz=0.25:3276.5 interpolated=1");
        assert_eq!(
            FunctionMetadata::from_lines(&["averages=5".to_owned()]),
            FunctionMetadata::default()
        );
        assert_eq!(FunctionMetadata::default().to_lines(), ["", ""]);
    }

    #[test]
    fn fields_go_where_there_is_room() {
        let field = |c: char, len: usize| c.to_string().repeat(len);
        let mut lines = [None, Some(String::new())];
        let fields = [field('a', 40), field('b', 60), field('c', 30)];
        assert_eq!(pack_fields(&fields, &mut lines), 1);
        let expected = format!("modalign {} {}", fields[0], fields[2]);
        assert_eq!((expected.len(), &lines), (80, &[None, Some(expected)]));
    }
}

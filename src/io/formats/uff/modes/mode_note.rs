//! The ID lines in which modalign keeps what the records of dataset 55 cannot hold of a mode: the
//! digits beyond the sixth, the scaling of the shape, the group of a repeated root, and that zeros
//! stand for what was not measured.
//!
//! `modalign frequency_hz=37.123456789 damping_ratio=0.0123456 modal_mass_kg=1
//! scaling=unit-modal-mass group=3 zeros=unmeasured`, wrapped over lines of 80 characters that each
//! start with `modalign`. `damping_ratio=none` says that the damping is not known.

use std::str::SplitWhitespace;

use crate::io::formats::uff::fields::{Line, text};
use crate::modal::{Mode, Scaling};

/// The mark that the lines begin with.
const MARK: &str = "modalign";
/// Characters of an ID line.
const LINE_CHARACTERS: usize = 80;
/// Value of `zeros` in a note where zeros stand for unmeasured directions.
const UNMEASURED: &str = "unmeasured";
const SCALINGS: [Scaling; 3] = [Scaling::UnitModalMass, Scaling::UnitMax, Scaling::Unknown];

/// The contents of the note lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::io::formats::uff) struct ModeNote {
    /// Natural frequency, Hz.
    pub frequency_hz: Option<f64>,
    /// Damping ratio; `Some(None)` when it is stated to be unknown.
    pub damping_ratio: Option<Option<f64>>,
    pub modal_mass_kg: Option<f64>,
    pub scaling: Option<Scaling>,
    pub group: Option<u32>,
    /// Whether a direction that is 0 in every such mode was not measured.
    pub zeros_unmeasured: bool,
}

impl ModeNote {
    /// The note of a mode; `zeros_unmeasured` when it lacks directions of its nodes.
    pub fn of(mode: &Mode, zeros_unmeasured: bool) -> Self {
        Self {
            frequency_hz: Some(mode.frequency_hz),
            damping_ratio: Some(mode.damping_ratio),
            modal_mass_kg: mode.modal_mass_kg,
            scaling: Some(mode.scaling).filter(|scaling| *scaling != Scaling::Unknown),
            group: mode.group,
            zeros_unmeasured,
        }
    }

    /// The lines.
    pub fn to_lines(self) -> Vec<String> {
        let damping = |ratio: Option<f64>| ratio.map_or("none".to_owned(), shortest);
        let fields = [
            self.frequency_hz.map(|v| ("frequency_hz", shortest(v))),
            self.damping_ratio.map(|v| ("damping_ratio", damping(v))),
            self.modal_mass_kg.map(|v| ("modal_mass_kg", shortest(v))),
            self.scaling.map(|v| ("scaling", v.name().to_owned())),
            self.group.map(|v| ("group", v.to_string())),
            self.zeros_unmeasured
                .then(|| ("zeros", UNMEASURED.to_owned())),
        ];
        let mut lines: Vec<String> = Vec::new();
        for (key, value) in fields.into_iter().flatten() {
            let field = format!(" {key}={value}");
            match lines.last_mut() {
                Some(line) if line.len() + field.len() <= LINE_CHARACTERS => line.push_str(&field),
                _ => lines.push(format!("{MARK}{field}")),
            }
        }
        lines
    }

    /// The note in the ID lines; empty where they are another program's.
    pub fn from_lines(lines: &[&Line]) -> Self {
        let mut note = Self::default();
        for line in lines {
            let line = text(&line.bytes);
            if is_note(&line) {
                note.take(line.split_whitespace());
            }
        }
        note
    }

    fn take(&mut self, words: SplitWhitespace<'_>) {
        let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite());
        for (key, value) in words.filter_map(|word| word.split_once('=')) {
            match key {
                "frequency_hz" => self.frequency_hz = number(value),
                "damping_ratio" if value == "none" => self.damping_ratio = Some(None),
                "damping_ratio" => self.damping_ratio = number(value).map(Some),
                "modal_mass_kg" => self.modal_mass_kg = number(value),
                "scaling" => {
                    let named = SCALINGS.iter().find(|scaling| scaling.name() == value);
                    self.scaling = named.copied();
                }
                "zeros" => self.zeros_unmeasured = value == UNMEASURED,
                "group" => self.group = value.parse().ok(),
                _ => {}
            }
        }
    }
}

/// Whether an ID line is one of these: the mark, and nothing but `key=value` behind it.
pub(super) fn is_note(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let marked = words.next() == Some(MARK);
    let mut fields = words.peekable();
    marked && fields.peek().is_some() && fields.all(|word| word.contains('='))
}

/// The shortest text that brings the number back.
fn shortest(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() {
        plain
    } else {
        exponent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::formats::uff::fields::Position;

    fn read(lines: &[String]) -> ModeNote {
        let at = Position {
            line: None,
            byte: 0,
        };
        let lines: Vec<Line> = lines
            .iter()
            .map(|line| Line {
                at,
                bytes: line.as_bytes().to_vec(),
            })
            .collect();
        ModeNote::from_lines(&lines.iter().collect::<Vec<_>>())
    }

    #[test]
    fn a_note_comes_back_from_lines_of_eighty_characters() {
        let note = ModeNote {
            frequency_hz: Some(3.6937677479149547e-11),
            damping_ratio: Some(Some(-3.6937677479149547e-11)),
            modal_mass_kg: Some(-3.6937677479149547e-101),
            scaling: Some(Scaling::UnitModalMass),
            group: Some(u32::MAX),
            zeros_unmeasured: true,
        };
        let lines = note.to_lines();
        assert!(lines.len() == 4 && lines.iter().all(|line| line.len() <= 80));
        assert_eq!(read(&lines), note);
        let unknown = ModeNote {
            frequency_hz: Some(0.0),
            damping_ratio: Some(None),
            ..ModeNote::default()
        };
        let lines = unknown.to_lines();
        assert_eq!(lines, ["modalign frequency_hz=0 damping_ratio=none"]);
        assert_eq!(read(&lines), unknown);
    }

    #[test]
    fn mode_notes_of_other_programs_are_ignored() {
        for line in [
            "frequency_hz=5",
            "modalignment frequency_hz=5",
            "modalign frequency_hz=NaN",
            "modalign frequency_hz=5 x",
        ] {
            assert_eq!(read(&[line.to_owned()]), ModeNote::default(), "{line}");
        }
    }
}

//! Findings on standard error: with `--full` one line each, by default one line for each kind of
//! warning and one for all notes.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use crate::finding::{Code, Finding, Location, Severity, format_hz, format_number};
use crate::printable::listed;
use crate::report::Language;

/// Characters in a line of the screen's findings.
const MAX_LINE_CHARS: usize = 200;
/// Characters of a value with its limit behind a sentence.
const NUMBERS_CHARS: usize = 30;
/// Minimum number of characters of a place that remain: those of a mode.
const MIN_PLACE_CHARS: usize = 24;
/// Maximum number of bad parts of the input of one kind that have a line on the screen.
const MAX_SCREEN_ERRORS: usize = 5;
/// Maximum number of kinds of warnings that have a line on the screen.
const MAX_SCREEN_KINDS: usize = 10;

/// Findings with the name of their test, empty where there is one.
type NamedFinding = (String, Finding);

/// The findings of one severity and code.
struct Kind<'f> {
    severity: Severity,
    code: Code,
    /// Each different one, with its line.
    findings: Vec<(&'f NamedFinding, String)>,
}

/// Every finding in a line, each once, the worst first.
pub(super) fn all_lines(findings: &[NamedFinding], language: Language) -> Vec<String> {
    let kinds = kinds(findings, language).into_iter();
    let findings = kinds.flat_map(|kind| kind.findings);
    findings.map(|(_, line)| line).collect()
}

/// A line for each bad part of the input, for each kind of warning with its places, and one that
/// counts the notes.
pub(super) fn screen_lines(findings: &[NamedFinding], language: Language) -> Vec<String> {
    let is_warning = |kind: &Kind<'_>| kind.severity > Severity::Info;
    let (warnings, notes): (Vec<_>, Vec<_>) =
        kinds(findings, language).into_iter().partition(is_warning);
    let (shown, further) = warnings.split_at(warnings.len().min(MAX_SCREEN_KINDS));
    let mut lines: Vec<String> = shown
        .iter()
        .flat_map(|kind| kind.screen_lines(language))
        .collect();
    let names = |kinds: &[Kind<'_>]| {
        let names = kinds.iter().map(|kind| kind.code.name());
        names.collect::<Vec<_>>().join(", ")
    };
    if !further.is_empty() {
        let (severity, names) = (language.severity(further[0].severity), names(further));
        lines.push(cut(&match language {
            Language::English => format!("{severity}: further kinds (all: --full): {names}"),
            Language::Chinese => format!("{severity}: 其他类别 (全部：--full)：{names}"),
        }));
    }
    if !notes.is_empty() {
        let count: usize = notes.iter().map(|kind| kind.findings.len()).sum();
        let (severity, names) = (language.severity(Severity::Info), names(&notes));
        let plural = if count == 1 { "" } else { "s" };
        lines.push(cut(&match language {
            Language::English => format!(
                "{severity}: {count} note{plural} (all: --full; meaning: --explain CODE): {names}"
            ),
            Language::Chinese => {
                format!("{severity}: {count} 条 (全部：--full；含义：--explain CODE)：{names}")
            }
        }));
    }
    lines
}

/// The findings by severity, the worst first, then those on the verdict, and code.
fn kinds(findings: &[NamedFinding], language: Language) -> Vec<Kind<'_>> {
    let mut kinds: BTreeMap<(Reverse<Severity>, usize, Code), Kind<'_>> = BTreeMap::new();
    for named in findings {
        let Finding { severity, code, .. } = named.1;
        let kind = kinds
            .entry((Reverse(severity), code.rank(), code))
            .or_insert_with(|| Kind {
                severity,
                code,
                findings: Vec::new(),
            });
        let line = line(named, language);
        if kind.findings.iter().all(|(_, listed)| *listed != line) {
            kind.findings.push((named, line));
        }
    }
    kinds.into_values().collect()
}

fn line((test, finding): &NamedFinding, language: Language) -> String {
    let severity = language.severity(finding.severity);
    let name = if test.is_empty() {
        String::new()
    } else {
        format!("{test}: ")
    };
    let (sentence, code) = (language.finding(finding), finding.code.name());
    format!("{severity}: {name}{sentence} [{code}]")
}

impl Kind<'_> {
    fn screen_lines(&self, language: Language) -> Vec<String> {
        match (self.severity, self.findings.as_slice()) {
            (Severity::Error, _) => self.error_lines(language),
            (_, [(_, only)]) => vec![self.single_line(only, language)],
            _ => vec![self.counted_line(language)],
        }
    }

    fn tag(&self) -> String {
        format!(" [{}]", self.code.name())
    }

    /// Bad parts of the input in full, of many the first.
    fn error_lines(&self, language: Language) -> Vec<String> {
        let (shown, further) = self
            .findings
            .split_at(self.findings.len().min(MAX_SCREEN_ERRORS));
        let mut lines: Vec<String> = shown.iter().map(|(_, line)| line.clone()).collect();
        if !further.is_empty() {
            let (severity, tag) = (language.severity(self.severity), self.tag());
            let count = further.len();
            lines.push(match language {
                Language::English => format!("{severity}: {count} more (all: --full){tag}"),
                Language::Chinese => format!("{severity}: 另有 {count} 条 (全部：--full){tag}"),
            });
        }
        lines
    }

    /// A finding; where its text leaves no room for its numbers, with the first sentence alone and,
    /// if that does not suffice, with the end of a long place.
    fn single_line(&self, line: &str, language: Language) -> String {
        let tag = self.tag();
        let text = line.strip_suffix(&tag).unwrap_or(line);
        let sentence = language.sentence(self.code);
        let sentence = sentence.trim_end_matches(['.', '。']);
        let first = first_sentence(sentence);
        match text.split_once(sentence) {
            _ if is_line(text, &tag) => format!("{text}{tag}"),
            Some((place, numbers)) if leaves_no_room(place, sentence, &tag) => {
                let place = shortened_place(place, &[first, numbers, &tag]);
                cut_before(&format!("{place}{first}{numbers}"), &tag)
            }
            _ => cut_before(text, &tag),
        }
    }

    /// Their number, the sentence of the code, and their places.
    fn counted_line(&self, language: Language) -> String {
        let severity = language.severity(self.severity);
        let sentence = language.sentence(self.code);
        let sentence = sentence.trim_end_matches(['.', '。']);
        let count = self.findings.len();
        let places = match places(self.findings.iter().map(|(named, _)| *named)) {
            none if none.is_empty() => none,
            places => match language {
                Language::English => format!(": {places}"),
                Language::Chinese => format!("：{places}"),
            },
        };
        let range = self.range_text(language);
        let line = |sentence: &str| format!("{severity}: {count}× {sentence}{range}{places}");
        match line(sentence) {
            text if is_line(&text, &self.tag()) => format!("{text}{}", self.tag()),
            _ => cut_before(&line(first_sentence(sentence)), &self.tag()),
        }
    }
}

impl Kind<'_> {
    /// The smallest and the largest value of the findings, in parentheses; nothing where one of
    /// them has no value or another unit.
    fn range_text(&self, language: Language) -> String {
        let findings = || self.findings.iter().map(|(named, _)| &named.1);
        let values: Option<Vec<f64>> = findings().map(|finding| finding.value).collect();
        let units: BTreeSet<_> = findings().map(|finding| &finding.unit).collect();
        let Some(values) = values.filter(|_| units.len() == 1) else {
            return String::new();
        };
        let lowest = values.iter().copied().reduce(f64::min);
        let highest = values.iter().copied().reduce(f64::max);
        let Some((lowest, highest)) = lowest.zip(highest) else {
            return String::new();
        };
        let unit = units.into_iter().next().and_then(Option::as_deref);
        let unit = unit.map_or_else(String::new, |unit| format!(" {unit}"));
        let (lowest, highest) = (format_number(lowest), format_number(highest));
        let range = match (lowest == highest, language) {
            (true, _) => lowest,
            (false, Language::English) => format!("{lowest} to {highest}"),
            (false, Language::Chinese) => format!("{lowest} 至 {highest}"),
        };
        match language {
            Language::English => format!(" ({range}{unit})"),
            Language::Chinese => format!("（{range}{unit}）"),
        }
    }
}

/// The places of findings, those of a test after its name.
fn places<'f>(findings: impl Iterator<Item = &'f NamedFinding>) -> String {
    let mut tests: Vec<(&str, Vec<String>)> = Vec::new();
    for (test, finding) in findings {
        let place = match &finding.location {
            Location::Mode(hz) => format_hz(*hz),
            Location::Parameter(name) => name.clone(),
            Location::Whole => String::new(),
            location => location.to_string(),
        };
        match tests.iter_mut().find(|(listed, _)| *listed == test) {
            Some((_, places)) => places.push(place),
            None => tests.push((test, vec![place])),
        }
    }
    let names: Vec<&str> = tests.iter().map(|(test, _)| *test).collect();
    if tests
        .iter()
        .all(|(_, places)| places.iter().all(String::is_empty))
    {
        return listed(&names);
    }
    let texts = tests.into_iter().map(|(test, mut places)| {
        places.retain(|place| !place.is_empty());
        places.dedup();
        format!("{} {}", listed(&[test]), places.join(", "))
            .trim()
            .to_owned()
    });
    let texts: Vec<String> = texts.filter(|text| !text.is_empty()).collect();
    texts.join("; ")
}

/// A place with its severity and its end, where it leaves no room for the numbers otherwise.
fn shortened_place(place: &str, behind: &[&str]) -> String {
    let taken: usize = behind.iter().map(|text| text.chars().count()).sum();
    let room = MAX_LINE_CHARS.saturating_sub(taken);
    let length = place.chars().count();
    let (severity, end) = place.split_once(' ').unwrap_or(("", place));
    let kept = room.saturating_sub(severity.chars().count() + 2);
    let kept = kept.max(MIN_PLACE_CHARS);
    if length <= room {
        return place.to_owned();
    }
    let skipped = end.chars().count().saturating_sub(kept);
    format!(
        "{severity} …{}",
        end.chars().skip(skipped).collect::<String>()
    )
}

/// The first sentence of a text.
fn first_sentence(text: &str) -> &str {
    let end = text.find(". ").into_iter().chain(text.find('。')).min();
    end.map_or(text, |end| &text[..end])
}

/// Whether the numbers of a finding do not fit behind its sentence.
fn leaves_no_room(place: &str, sentence: &str, tag: &str) -> bool {
    let taken: usize = [place, sentence, tag]
        .iter()
        .map(|text| text.chars().count())
        .sum();
    taken + NUMBERS_CHARS > MAX_LINE_CHARS
}

/// A text and its tag, the text cut where both are longer than a line.
fn cut_before(text: &str, tag: &str) -> String {
    if is_line(text, tag) {
        return format!("{text}{tag}");
    }
    let room = MAX_LINE_CHARS.saturating_sub(tag.chars().count() + 1);
    let kept: String = text.chars().take(room.saturating_sub(1)).collect();
    // Between words, where there are any; Chinese has none.
    let end = kept.rfind(' ').filter(|end| *end > kept.len() / 2);
    let kept = kept[..end.unwrap_or(kept.len())].trim_end_matches([' ', ',', ';', ':']);
    format!("{kept} …{tag}")
}

/// Whether a text and its tag fit a line.
fn is_line(text: &str, tag: &str) -> bool {
    text.chars().count() + tag.chars().count() <= MAX_LINE_CHARS
}

fn cut(text: &str) -> String {
    cut_before(text, "")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(test: &str, code: Code, severity: Severity, hz: f64) -> NamedFinding {
        let finding = Finding::new(severity, code, Location::Mode(hz));
        (test.to_owned(), finding.value(hz / 2.0, "Hz"))
    }

    #[test]
    fn warnings_of_one_kind_are_one_line_with_their_places() {
        let findings = [
            mode("", Code::RepeatedRoot, Severity::Info, 50.0),
            mode("disc", Code::CloseModes, Severity::Warning, 10.0),
            mode("disc", Code::CloseModes, Severity::Warning, 20.0),
            mode("ring", Code::CloseModes, Severity::Warning, 30.0),
            mode("ring", Code::CloseModes, Severity::Warning, 30.0),
            mode("ring", Code::FewLines, Severity::Warning, 40.0),
        ];
        let lines = screen_lines(&findings, Language::English);
        assert_eq!(lines.len(), 3);
        let close = lines.iter().find(|line| line.contains("close-modes"));
        let close = close.expect("a line for close modes");
        assert!(close.starts_with("warning: 3× "), "{close}");
        assert!(
            close.contains(" (5 to 15 Hz): disc 10.00 Hz, 20.00 Hz; ring 30.00 Hz [close-modes]")
        );
        let few = lines.iter().find(|line| line.contains("few-lines"));
        assert!(few.is_some_and(|line| line.contains("ring: mode at 40.00 Hz")));
        assert_eq!(
            lines[2],
            "info: 1 note (all: --full; meaning: --explain CODE): repeated-root"
        );
        assert_eq!(all_lines(&findings, Language::English).len(), 5);
    }

    #[test]
    fn a_long_finding_keeps_its_numbers() {
        let finding = Finding::new(
            Severity::Warning,
            Code::DampingBiasedHigh,
            Location::Mode(12.0),
        );
        let named = (
            "a test with a long name".to_owned(),
            finding.value(89.0, "%"),
        );
        let lines = screen_lines(&[named], Language::English);
        let expected = "warning: a test with a long name: mode at 12.00 Hz: \
                        The resonance is few frequency lines wide (89 %) [damping-biased-high]";
        assert_eq!(lines[0], expected);
    }

    #[test]
    fn the_numbers_of_a_finding_stand_behind_its_sentence() {
        let finding = Finding::new(Severity::Warning, Code::Ambiguous, Location::Mode(12.0));
        let test = "a/folder/with/a/long/name/".repeat(7) + "test.modes.json";
        let named = (test, finding.value(0.01, "").limit(0.05));
        let lines = screen_lines(&[named], Language::English);
        assert!(lines[0].starts_with("warning: …"), "{}", lines[0]);
        let expected = "test.modes.json: mode at 12.00 Hz: This pair is ambiguous \
                        (0.0100, limit at least 0.0500) [ambiguous]";
        assert!(lines[0].ends_with(expected), "{}", lines[0]);
        assert!(lines[0].chars().count() <= MAX_LINE_CHARS);
    }

    #[test]
    fn a_bad_part_of_the_input_is_said_in_full() {
        let place = |line| Location::File {
            path: "hits.uff".to_owned(),
            line: Some(line),
            byte: None,
        };
        let long = "got a text in the place of a number, ".repeat(10) + "expected a number";
        let bad = |line| Finding::new(Severity::Error, Code::BadDataset, place(line)).detail(&long);
        let findings: Vec<NamedFinding> = (1..=8).map(|n| (String::new(), bad(n))).collect();
        let lines = screen_lines(&findings, Language::English);
        assert_eq!(lines.len(), MAX_SCREEN_ERRORS + 1);
        assert!(lines[4].starts_with("error: hits.uff:5: "), "{}", lines[4]);
        assert!(
            lines[4].ends_with("expected a number [bad-dataset]"),
            "{}",
            lines[4]
        );
        assert_eq!(lines[5], "error: 3 more (all: --full) [bad-dataset]");
    }

    #[test]
    fn a_screen_has_at_most_twelve_lines_of_two_hundred_characters() {
        let of_code = |&code: &Code| {
            let severity = match code {
                Code::Synthetic => Severity::Info,
                _ => Severity::Warning,
            };
            let long = "a long detail ".repeat(40);
            (0..30).map(move |n| {
                let (_, finding) = mode("", code, severity, f64::from(n));
                (
                    "a test with a long name".to_owned(),
                    finding.detail(long.clone()),
                )
            })
        };
        let findings: Vec<NamedFinding> = Code::ALL.iter().flat_map(of_code).collect();
        for language in [Language::English, Language::Chinese] {
            let lines = screen_lines(&findings, language);
            assert_eq!(lines.len(), MAX_SCREEN_KINDS + 2);
            for line in &lines {
                assert!(line.chars().count() <= MAX_LINE_CHARS, "{line}");
            }
            let others = Code::ALL.iter();
            let others = others.filter(|code| !Code::ON_THE_VERDICT.contains(code));
            let codes = Code::ON_THE_VERDICT.iter().chain(others);
            for (line, code) in lines[..MAX_SCREEN_KINDS].iter().zip(codes) {
                assert!(line.ends_with(&format!("[{}]", code.name())), "{line}");
            }
            assert_eq!(all_lines(&findings, language).len(), findings.len());
        }
    }
}

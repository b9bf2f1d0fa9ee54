//! Verdicts as JUnit XML by the schema of Ant's JUnit reports, which CI servers read.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::printable::printable;
use crate::scene::{LimitCheck, RowVerdict};

/// Significant digits, unless more are needed to tell a value from its limit.
const DIGITS: usize = 6;

/// A suite with a test case for each row; a missed row fails with everything that it missed.
pub fn junit(suite: &str, baseline: &str, rows: &[RowVerdict]) -> String {
    let failures = rows.iter().filter(|row| !row.is_met()).count();
    let seconds = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    let cases: String = rows.iter().map(|row| case(suite, row)).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <testsuites>\n\
         <testsuite package=\"modalign\" id=\"0\" name=\"{}\" timestamp=\"{}\" hostname=\"localhost\" \
         tests=\"{}\" failures=\"{failures}\" errors=\"0\" skipped=\"0\" time=\"0\">\n\
         <properties><property name=\"against\" value=\"{}\"/></properties>\n\
         {cases}<system-out/>\n<system-err/>\n</testsuite>\n</testsuites>\n",
        token(suite),
        timestamp(seconds),
        rows.len(),
        escaped(baseline)
    )
}

fn case(suite: &str, row: &RowVerdict) -> String {
    let head = format!(
        "<testcase classname=\"{}\" name=\"{}\" time=\"0\"",
        token(suite),
        token(&row.row)
    );
    let missed: Vec<String> = row
        .checks
        .iter()
        .filter(|check| !check.is_met())
        .map(sentence)
        .collect();
    if missed.is_empty() {
        return head + "/>\n";
    }
    let message = escaped(&missed.join("; "));
    let lines = escaped(&missed.join("\n"));
    format!("{head}><failure type=\"limit\" message=\"{message}\">{lines}</failure></testcase>\n")
}

fn sentence(check: &LimitCheck) -> String {
    let relation = if check.upper { "at most" } else { "at least" };
    let what = &check.what;
    let Some(value) = check.value else {
        let limit = short(check.limit, DIGITS);
        return format!("{what}: got nothing, expected {relation} {limit}");
    };
    // As many digits as distinguish the two.
    let texts =
        (DIGITS..=17).map(|digits| [value, check.limit].map(|number| short(number, digits)));
    let mut distinct = texts.filter(|[got, limit]| got != limit);
    let [got, limit] = distinct
        .next()
        .unwrap_or_else(|| [value, check.limit].map(|number| number.to_string()));
    format!("{what}: got {got}, expected {relation} {limit}")
}

/// So many significant digits, no trailing zeros.
fn short(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.*e}", digits - 1);
    rounded.parse().unwrap_or(value).to_string()
}

/// Text without runs of blanks, as `xs:token` wants it.
fn token(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    escaped(&words.join(" "))
}

/// Text for XML 1.0, in elements and attributes; of characters that it cannot hold the control
/// characters are shown and the others left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\u{fffe}' | '\u{ffff}' => {}
            c => out.push(c),
        }
    }
    out
}

/// `2026-01-31T12:00:00` of seconds since 1970, UTC, by the calendar's cycle of 400 years that
/// begin in March.
fn timestamp(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = (month_from_march + 2) % 12 + 1;
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    let (hour, minute) = (second / 3_600, second / 60 % 60);
    format!(
        "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{:02}",
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_stamp_has_the_calendar_date() {
        // `date -u -d @N`.
        assert_eq!(timestamp(0), "1970-01-01T00:00:00");
        assert_eq!(timestamp(951_782_399), "2000-02-28T23:59:59");
        assert_eq!(timestamp(951_782_400), "2000-02-29T00:00:00");
        assert_eq!(timestamp(1_709_251_199), "2024-02-29T23:59:59");
        assert_eq!(timestamp(1_795_413_600), "2026-11-23T06:00:00");
    }

    #[test]
    fn names_keep_within_xml() {
        let row = RowVerdict {
            row: "f1  \"a\" <&>\u{1}".to_owned(),
            checks: vec![LimitCheck {
                what: "MAC".to_owned(),
                value: None,
                limit: 0.999_999_999_999,
                upper: false,
            }],
        };
        let text = junit("out/a b.json", "b.json", &[row]);
        assert!(
            text.contains("name=\"f1 &quot;a&quot; &lt;&amp;&gt;\\x01\""),
            "{text}"
        );
        assert!(
            text.contains("message=\"MAC: got nothing, expected at least 1\""),
            "{text}"
        );
    }
}

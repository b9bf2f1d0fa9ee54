//! Numbers and texts fit the columns of a line of a universal file.

/// Columns of a text line.
const LINE_COLUMNS: usize = 80;

/// A number in at most twelve columns, so that a blank stands before it in its thirteen: seven
/// digits or, where sign or exponent take columns, fewer.
pub(in crate::io::formats::uff) fn twelve_columns(value: f64) -> String {
    let mut digits = 6;
    loop {
        let text = fortran(value, digits);
        if text.len() <= 12 || digits == 0 {
            return text;
        }
        digits -= 1;
    }
}

/// `1.500000E-05`: a sign and at least two digits in the exponent.
pub(in crate::io::formats::uff) fn fortran(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$E}");
    match text.split_once('E') {
        Some((mantissa, exponent)) => {
            let (sign, exponent) = match exponent.strip_prefix('-') {
                Some(exponent) => ('-', exponent),
                None => ('+', exponent),
            };
            format!("{mantissa}E{sign}{exponent:0>2}")
        }
        None => text,
    }
}

/// A text that fits a line and is no delimiter: control characters become blanks, what is behind
/// column 80 is cut.
pub(in crate::io::formats::uff) fn line_text(text: &str) -> String {
    let plain: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    let mut plain = plain.trim();
    while plain.len() > LINE_COLUMNS {
        let last = plain.char_indices().next_back().map_or(0, |(at, _)| at);
        plain = plain[..last].trim_end();
    }
    if plain == "-1" {
        "(-1)".to_owned()
    } else {
        plain.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fit_their_columns() {
        for (value, text) in [
            (1.0 / 51_200.0, "1.953125E-05"),
            (-0.05, "-5.00000E-02"),
            (0.0, "0.000000E+00"),
            (1e-120, "1.00000E-120"),
            (-1e300, "-1.0000E+300"),
            (f64::MIN_POSITIVE, "2.22507E-308"),
        ] {
            assert_eq!(twelve_columns(value), text);
        }
    }

    #[test]
    fn a_line_of_text_is_one_line_and_no_delimiter() {
        assert_eq!(line_text(" two\nlines\t"), "two lines");
        assert_eq!(line_text("-1"), "(-1)");
        assert_eq!(line_text(&"é".repeat(60)).len(), 80);
    }
}

//! A complex number as text: `(1.0+2.0j)` of NumPy, `1.0 + 2.0i` of MATLAB, `(1.0,2.0)` of Fortran
//! and C++.

use num_complex::Complex64;

use crate::io::formats::number;

/// Reads the complex number at the start of `bytes`: its value and its length; `None` where there
/// is none, as before a real number.
///
/// Between the parts stands a sign, with blanks around it or none; NumPy also printed both signs
/// (`1.0+-2.0j`). The imaginary part ends with `i` or `j`, behind `*` or `*1` or a blank in some
/// programs. An imaginary part alone is one too.
pub(super) fn prefix(bytes: &[u8], decimal: u8) -> Option<(Complex64, usize)> {
    let is_open = bytes.first() == Some(&b'(');
    let mut at = usize::from(is_open);
    at += blanks(&bytes[at..]);
    let (first, len) = part(&bytes[at..], decimal)?;
    at += len;
    let rest = &bytes[at..];
    let (value, len) = match unit(rest) {
        Some(len) => (Complex64::new(0.0, first), len),
        None => {
            let (imaginary, len) = second_part(rest, decimal, is_open)?;
            (Complex64::new(first, imaginary), len)
        }
    };
    at += len;
    if is_open {
        at += blanks(&bytes[at..]);
        (bytes.get(at) == Some(&b')')).then_some(())?;
        at += 1;
    }
    Some((value, at))
}

/// A whole field as a complex number, blanks around it left away.
pub(super) fn field(bytes: &[u8], decimal: u8) -> Option<Complex64> {
    let bytes = bytes.trim_ascii();
    let (value, len) = prefix(bytes, decimal)?;
    (len == bytes.len()).then_some(value)
}

/// A real number, or a word for one that is not finite.
fn part(bytes: &[u8], decimal: u8) -> Option<(f64, usize)> {
    match number::prefix(bytes, decimal) {
        // `1.#QNAN`
        Some((_, len)) if bytes.get(len) == Some(&b'#') => {
            number::non_finite_prefix(bytes, decimal)
        }
        None => number::non_finite_prefix(bytes, decimal),
        finite => finite,
    }
}

/// The imaginary part behind a real part, with the sign or the comma before it.
fn second_part(bytes: &[u8], decimal: u8, is_open: bool) -> Option<(f64, usize)> {
    let sign_at = blanks(bytes);
    let mut at = sign_at + 1;
    at += blanks(bytes.get(at..)?);
    let (value, len) = part(&bytes[at..], decimal)?;
    at += len;
    match bytes[sign_at] {
        b',' if is_open && decimal != b',' => Some((value, at)),
        sign @ (b'+' | b'-') => {
            at += blanks(&bytes[at..]);
            at += unit(&bytes[at..])?;
            Some((if sign == b'-' { -value } else { value }, at))
        }
        _ => None,
    }
}

/// Length of the imaginary unit at the start: `i`, `j`, `*i` or `*1i`, in any case.
fn unit(bytes: &[u8]) -> Option<usize> {
    let mut at = 0;
    if bytes.first() == Some(&b'*') {
        at = 1 + blanks(&bytes[1..]);
        at += usize::from(bytes.get(at) == Some(&b'1'));
    }
    matches!(bytes.get(at)?, b'i' | b'j' | b'I' | b'J').then_some(())?;
    let behind = bytes.get(at + 1);
    let is_word = behind.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    (!is_word).then_some(at + 1)
}

fn blanks(bytes: &[u8]) -> usize {
    bytes.iter().take_while(|byte| **byte == b' ').count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_notation_of_a_complex_number_is_read() {
        for (text, re, im) in [
            (" (1.0e+00+2.0e+00j)", 1.0, 2.0),
            ("(1+2j)", 1.0, 2.0),
            ("(-1.0-2.0e-3j)", -1.0, -2e-3),
            ("1.0e+00+-2.0e+00j", 1.0, -2.0),
            ("1.0 + 2.0i", 1.0, 2.0),
            ("1.0000 - 2.0000i", 1.0, -2.0),
            ("1.0 +2.0 i", 1.0, 2.0),
            ("1.0+2.0*1i", 1.0, 2.0),
            ("1.0 + 2.0*i", 1.0, 2.0),
            ("1.5D+00-2.5D+00J", 1.5, -2.5),
            ("-3.5j", 0.0, -3.5),
            ("( 1.0, -2.0 )", 1.0, -2.0),
            ("(inf-infj)", f64::INFINITY, f64::NEG_INFINITY),
            ("Inf + Infi", f64::INFINITY, f64::INFINITY),
        ] {
            let value = Complex64::new(re, im);
            assert_eq!(field(text.as_bytes(), b'.'), Some(value), "{text}");
        }
        assert_eq!(field(b"1,5-2,5i", b','), Some(Complex64::new(1.5, -2.5)));
        for text in ["(nan+nanj)", "NaN - 1i", "-1.#IND+1.#QNANj"] {
            let value = field(text.as_bytes(), b'.');
            assert!(value.is_some_and(|value| value.re.is_nan()), "{text}");
        }
    }

    #[test]
    fn real_numbers_and_texts_are_no_complex_numbers() {
        for text in [
            "",
            "1.0",
            "(1.0)",
            "1.0 2.0",
            "1.0 -2.0",
            "1.0+2.0",
            "1.0+2.0k",
            "1.0+2.0in",
            "(1+2j",
            "1+2j)",
            "1,2",
            "i",
            "j",
            "+j",
            "1+j",
            "10 in",
            "3rd",
            "1.0, 2.0i",
        ] {
            assert_eq!(field(text.as_bytes(), b'.'), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn printed_numbers_read_back(re: f64, im: f64) {
            prop_assume!(re.is_finite() && im.is_finite());
            let value = Complex64::new(re, im);
            for text in [format!("({re:e}{im:+e}j)"), format!("{re:?} + {im:?}i"), format!("({re:e},{im:e})")] {
                prop_assert_eq!(field(text.as_bytes(), b'.'), Some(value), "{}", text);
            }
        }

        #[test]
        fn any_bytes_are_survived(bytes in proptest::collection::vec(any::<u8>(), 0..40), text in "[(]?[-+0-9.ij, *e#INFna)]{0,20}") {
            for bytes in [bytes.as_slice(), text.as_bytes()] {
                if let Some((_, len)) = prefix(bytes, b'.') {
                    prop_assert!(len <= bytes.len());
                }
            }
        }
    }
}

//! Decimal numbers from bytes, fast: the one parser of every text format.
//!
//! Up to 15 digits with a decimal exponent of at most 22 in magnitude are exact in one
//! multiplication or division (Clinger 1990, How to read floating point numbers accurately, section
//! 3). Up to 19 digits with one of at most 27 are multiplied by a power of five of 128 bits, which
//! decides the rounding unless the product lies within its error of a tie (Lemire 2021, Number
//! parsing at a gigabyte per second). Everything else goes through the standard library, so that
//! every result is the nearest double.

/// Powers of ten that are exact.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Below it every whole number of 15 digits is exact in a double.
const EXACT_MANTISSA: u64 = 1_000_000_000_000_000;
/// Most digits that never overflow 64 bits.
const SAFE_DIGITS: usize = 19;

/// Reads the longest decimal number at the start of `bytes`: its value and its length; `None` when
/// there is none.
///
/// The exponent letter may be `E`, `e`, `D` or `d`. `decimal` is the decimal mark, `.` or `,`.
/// Digits that overflow a double are no number; `NaN` and `Inf` are not read here.
#[inline(always)]
pub(in crate::io) fn prefix(bytes: &[u8], decimal: u8) -> Option<(f64, usize)> {
    read::<false>(bytes, decimal)
}

/// As [`prefix`] with a decimal point, where the exponent letter may be missing before a sign and
/// three digits (`1.5-105`).
pub(in crate::io) fn fortran_prefix(bytes: &[u8]) -> Option<(f64, usize)> {
    read::<true>(bytes, b'.')
}

#[inline(always)]
fn read<const FORTRAN: bool>(bytes: &[u8], decimal: u8) -> Option<(f64, usize)> {
    let negative = bytes.first() == Some(&b'-');
    let start = usize::from(matches!(bytes.first(), Some(b'-' | b'+')));
    // Digits that are too many for the mantissa wrap around; their number says so.
    let mut mantissa = 0u64;
    let mut at = few_digits(bytes, start, &mut mantissa);
    let mut seen = at - start;
    let mut scale = 0i64;
    if bytes.get(at) == Some(&decimal) {
        let end = digits(bytes, at + 1, &mut mantissa);
        let decimals = end - at - 1;
        (seen, scale, at) = (seen + decimals, -(decimals as i64), end);
    }
    if seen == 0 {
        return None;
    }
    let mantissa_end = at;
    let (exponent, end) = exponent::<FORTRAN>(bytes, at);
    let power = scale + exponent;
    if seen <= SAFE_DIGITS && mantissa < EXACT_MANTISSA && power.unsigned_abs() <= 22 {
        let magnitude = mantissa as f64;
        let factor = EXACT_POWERS[power.unsigned_abs() as usize];
        let value = if power < 0 {
            magnitude / factor
        } else {
            magnitude * factor
        };
        return Some((if negative { -value } else { value }, end));
    }
    if seen <= SAFE_DIGITS
        && power.unsigned_abs() <= MAX_DECIMAL_EXPONENT as u64
        && let Some(value) = scaled(mantissa, power as i32)
    {
        return Some((if negative { -value } else { value }, end));
    }
    // Most are written as the standard library reads them.
    let standard = std::str::from_utf8(&bytes[..end]).ok();
    let value = match standard.and_then(|text| text.parse::<f64>().ok()) {
        Some(value) => value.is_finite().then_some(value),
        None => slow(&bytes[start..mantissa_end], decimal, exponent, negative),
    };
    value.map(|value| (value, end))
}

/// Whole powers of ten.
const TENS: [u64; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// Adds digits that are mostly few, as those before the decimal mark, to `mantissa` and says where
/// they end.
#[inline(always)]
fn few_digits(bytes: &[u8], start: usize, mantissa: &mut u64) -> usize {
    let mut at = start;
    while let Some(digit @ b'0'..=b'9') = bytes.get(at) {
        if at == start + 4 {
            return digits(bytes, at, mantissa);
        }
        *mantissa = 10 * *mantissa + u64::from(digit - b'0');
        at += 1;
    }
    at
}

/// Adds the digits at `at` to `mantissa` and says where they end: eight bytes at a time, so that no
/// branch depends on how many digits the last ones hold.
#[inline(always)]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(eight) = bytes.get(at..).and_then(<[u8]>::first_chunk::<8>) {
        let text = u64::from_le_bytes(*eight);
        let count = leading_digits(text);
        if count < 8 {
            // Zeros take the places of what is behind the digits.
            let value = eight_digits(text << 8 << (56 - 8 * count));
            *mantissa = mantissa
                .wrapping_mul(TENS[count as usize])
                .wrapping_add(value);
            return at + count as usize;
        }
        *mantissa = mantissa
            .wrapping_mul(100_000_000)
            .wrapping_add(eight_digits(text));
        at += 8;
    }
    while let Some(digit @ b'0'..=b'9') = bytes.get(at) {
        *mantissa = mantissa
            .wrapping_mul(10)
            .wrapping_add(u64::from(digit - b'0'));
        at += 1;
    }
    at
}

/// How many of eight bytes, the first in the lowest byte, are digits before the first that is none.
#[inline]
fn leading_digits(text: u64) -> u32 {
    const HIGH: u64 = 0xf0f0_f0f0_f0f0_f0f0;
    const ZEROS: u64 = 0x3030_3030_3030_3030;
    // A carry goes to later bytes alone, from a byte that is no digit.
    let above = text.wrapping_add(0x0606_0606_0606_0606);
    let others = ((text & HIGH) ^ ZEROS) | ((above & HIGH) ^ ZEROS);
    others.trailing_zeros() / 8
}

/// The value of eight digits, the first in the lowest byte; a byte 0 counts as the digit 0.
///
/// Neighbours are put together in three steps: digits to pairs, pairs to fours, fours to the whole.
#[inline]
fn eight_digits(text: u64) -> u64 {
    let digits = text & 0x0f0f_0f0f_0f0f_0f0f;
    let pairs = digits.wrapping_mul(2561) >> 8 & 0x00ff_00ff_00ff_00ff;
    let fours = pairs.wrapping_mul(6_553_601) >> 16 & 0x0000_ffff_0000_ffff;
    fours.wrapping_mul(42_949_672_960_001) >> 32
}

/// Exponent at `at` and where it ends; 0 and `at` where there is none.
fn exponent<const FORTRAN: bool>(bytes: &[u8], at: usize) -> (i64, usize) {
    let (sign_at, letter) = match bytes.get(at) {
        Some(b'E' | b'e' | b'D' | b'd') => (at + 1, true),
        Some(b'+' | b'-') if FORTRAN => (at, false),
        _ => return (0, at),
    };
    let signed = matches!(bytes.get(sign_at), Some(b'+' | b'-'));
    let first = sign_at + usize::from(signed);
    let (mut value, mut last) = (0i64, first);
    while let Some(digit @ b'0'..=b'9') = bytes.get(last) {
        value = (value * 10 + i64::from(digit - b'0')).min(1_000_000);
        last += 1;
    }
    // Without a letter only three digits are an exponent: `1.5-2` is two numbers that touch.
    if last == first || (!letter && (last - first != 3 || bytes.get(last) == Some(&b'.'))) {
        return (0, at);
    }
    let negative = signed && bytes[sign_at] == b'-';
    (if negative { -value } else { value }, last)
}

/// Largest power of ten, in magnitude, of [`scaled`]: 5^27 has 63 bits.
const MAX_DECIMAL_EXPONENT: usize = 27;

/// 5^q for q from −27 to 27: the leading 128 bits, rounded down, and the exponent of the first of
/// them.
const FIVES: [(u128, i32); 2 * MAX_DECIMAL_EXPONENT + 1] = {
    let mut fives = [(0, 0); 2 * MAX_DECIMAL_EXPONENT + 1];
    let (mut q, mut power) = (0, 1u128);
    while q <= MAX_DECIMAL_EXPONENT {
        let above = power.leading_zeros();
        fives[MAX_DECIMAL_EXPONENT + q] = (power << above, 127 - above as i32);
        if q > 0 {
            let bits = 128 - above;
            fives[MAX_DECIMAL_EXPONENT - q] = (reciprocal(power, 127 + bits), -(bits as i32));
        }
        power *= 5;
        q += 1;
    }
    fives
};

/// ⌊2^exponent / divisor⌋, bit by bit.
const fn reciprocal(divisor: u128, exponent: u32) -> u128 {
    let (mut quotient, mut rest, mut bit) = (0, 1, 0);
    while bit < exponent {
        rest <<= 1;
        quotient <<= 1;
        if rest >= divisor {
            rest -= divisor;
            quotient |= 1;
        }
        bit += 1;
    }
    quotient
}

/// The double nearest to mantissa × 10^power, |power| at most 27; `None` where the product of 128
/// bits cannot tell.
fn scaled(mantissa: u64, power: i32) -> Option<f64> {
    if mantissa == 0 {
        return Some(0.0);
    }
    /// Bits of the upper half of the product that a double has not.
    const CUT: u32 = u64::BITS - f64::MANTISSA_DIGITS;
    const HALF: u64 = 1 << (CUT - 1);
    let above = mantissa.leading_zeros();
    let (five, exponent) = FIVES[(power + MAX_DECIMAL_EXPONENT as i32) as usize];
    let normal = u128::from(mantissa << above);
    // What is cut off here, and what the power lacks, is less than 2 in the last place; after the
    // shift less than 4.
    let product = normal * (five >> 64) + ((normal * (five & u128::from(u64::MAX))) >> 64);
    let gap = product.leading_zeros();
    let product = product << gap;
    let (top, bottom) = ((product >> 64) as u64, product as u64);
    let (kept, rest) = (top >> CUT, top & ((1 << CUT) - 1));
    let just_below = rest & (HALF - 1) == HALF - 1 && bottom >= u64::MAX - 3;
    let seems_tie = rest == HALF && bottom == 0;
    let exact = power >= 0;
    if (just_below || seems_tie) && !exact {
        return None;
    }
    let up = rest > HALF || (rest == HALF && (bottom > 0 || kept & 1 == 1));
    let kept = kept + u64::from(up);
    // product 2^(64 − gap) = (mantissa 2^above) five, and five is 5^power 2^(127 − exponent).
    let binary = (CUT + 1) as i32 - gap as i32 + exponent + power - above as i32;
    // A power of two within the normal range, so that the product is exact.
    Some(kept as f64 * f64::from_bits(((binary + 1023) as u64) << 52))
}

#[cold]
fn slow(mantissa: &[u8], decimal: u8, exponent: i64, negative: bool) -> Option<f64> {
    let plain: String = mantissa
        .iter()
        .map(|byte| {
            if *byte == decimal {
                '.'
            } else {
                char::from(*byte)
            }
        })
        .collect();
    let value: f64 = format!("{plain}E{exponent}").parse().ok()?;
    value
        .is_finite()
        .then_some(if negative { -value } else { value })
}

/// A whole field as a number, blanks around it left away; words for NaN and infinity
/// ([`non_finite_prefix`]) are taken as such.
pub(in crate::io) fn field(bytes: &[u8], decimal: u8) -> Option<f64> {
    whole::<false>(bytes, decimal)
}

/// As [`field`] with a decimal point, where the exponent letter may be missing.
pub(in crate::io) fn fortran_field(bytes: &[u8]) -> Option<f64> {
    whole::<true>(bytes, b'.')
}

#[inline]
fn whole<const FORTRAN: bool>(bytes: &[u8], decimal: u8) -> Option<f64> {
    let bytes = bytes.trim_ascii();
    let is_whole = |(value, len): (f64, usize)| (len == bytes.len()).then_some(value);
    let finite = read::<FORTRAN>(bytes, decimal).and_then(is_whole);
    finite.or_else(|| non_finite_prefix(bytes, decimal).and_then(is_whole))
}

/// Words for NaN and infinity in lower case, the longest of those that begin alike first.
const NON_FINITE_WORDS: [(&[u8], f64); 7] = [
    (b"nanq", f64::NAN),
    (b"nans", f64::NAN),
    (b"nan", f64::NAN),
    (b"qnan", f64::NAN),
    (b"snan", f64::NAN),
    (b"infinity", f64::INFINITY),
    (b"inf", f64::INFINITY),
];

/// Reads what libraries print for a value that is not finite at the start of `bytes`: the value and
/// its length; `None` when there is none.
///
/// In any case and with any sign: `nan`, `inf` and `infinity` of C and Fortran, with what C adds in
/// parentheses (`nan(ind)`); `nanq`, `nans`, `qnan` and `snan` of AIX and other systems; `1.#IND`,
/// `1.#QNAN`, `1.#SNAN` and `1.#INF` of the C library of Microsoft, cut and rounded like digits to
/// the printed width (`1.#J` and `1.#IO` are any of them), filled with zeros, with an exponent.
#[cold]
pub(in crate::io) fn non_finite_prefix(bytes: &[u8], decimal: u8) -> Option<(f64, usize)> {
    let sign = usize::from(matches!(bytes.first(), Some(b'-' | b'+')));
    let unsigned = &bytes[sign..];
    let starts = |word: &[u8]| {
        let head = unsigned.get(..word.len());
        head.is_some_and(|head| head.eq_ignore_ascii_case(word))
    };
    let word = NON_FINITE_WORDS.iter().find(|(word, _)| starts(word));
    let (value, len) = match word {
        Some((word, value)) => (*value, word.len() + parenthesis(&unsigned[word.len()..])),
        None => microsoft(unsigned, decimal)?,
    };
    let negative = bytes.first() == Some(&b'-');
    Some((if negative { -value } else { value }, sign + len))
}

/// Length of letters and digits in parentheses at the start; 0 where there are none.
fn parenthesis(bytes: &[u8]) -> usize {
    let Some(inner) = bytes.strip_prefix(b"(") else {
        return 0;
    };
    let is_letter = |byte: &&u8| byte.is_ascii_alphanumeric() || **byte == b'_';
    let count = inner.iter().take_while(is_letter).count();
    match inner.get(count) {
        Some(b')') => count + 2,
        _ => 0,
    }
}

/// `1.#INF`, `1.#QNAN0`, `1.#IND0E+00`, `1.#J`.
fn microsoft(bytes: &[u8], decimal: u8) -> Option<(f64, usize)> {
    let [b'1', mark, b'#', rest @ ..] = bytes else {
        return None;
    };
    // No word has the letter of an exponent.
    let is_letter = |byte: &&u8| byte.is_ascii_uppercase() && **byte != b'E';
    let letters = rest.iter().take_while(is_letter).count();
    if *mark != decimal || letters == 0 {
        return None;
    }
    let value = match &rest[..letters] {
        b"INF" => f64::INFINITY,
        _ => f64::NAN,
    };
    let zeros = rest[letters..].iter().take_while(|byte| **byte == b'0');
    let end = 3 + letters + zeros.count();
    Some((value, exponent::<false>(bytes, end).1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_exponent_form_is_read() {
        for (text, expected, len) in [
            ("1.5", 1.5, 3),
            ("-1.5D-05 ", -1.5e-5, 8),
            ("+5.00000E-005", 5e-5, 13),
            ("1.25-105", 1.25e-105, 8),
            ("1.5-2.5", 1.5, 3),
            ("2.99110e-02-10.0", 2.9911e-2, 11),
            ("1.0E", 1.0, 3),
            (".5e1x", 5.0, 4),
            ("5.", 5.0, 2),
            ("1e-400", 0.0, 6),
            (
                "123456789012345678901234567890",
                123_456_789_012_345_678_901_234_567_890.0,
                30,
            ),
            ("0.00000000000000000000000000000012345", 1.2345e-31, 37),
        ] {
            let (value, end) = fortran_prefix(text.as_bytes()).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(
                (value.to_bits(), end),
                (f64::to_bits(expected), len),
                "{text}"
            );
        }
        assert_eq!(prefix(b"1,25;", b','), Some((1.25, 4)));
        for text in ["", "-", ".", "e5", "x", "1e400", "--1"] {
            assert_eq!(prefix(text.as_bytes(), b'.'), None, "{text}");
        }
    }

    #[test]
    fn a_field_is_a_number_as_a_whole_or_not_at_all() {
        assert_eq!(field(b" 1.5 ", b'.'), Some(1.5));
        assert_eq!(field(b"1.5x", b'.'), None);
        assert_eq!(field(b"1e999", b'.'), None);
        assert!(field(b"NaN", b'.').is_some_and(f64::is_nan));
        assert_eq!(field(b"-inf", b'.'), Some(f64::NEG_INFINITY));
    }

    #[test]
    fn words_of_c_and_fortran_libraries_are_values_that_are_not_finite() {
        for text in [
            "nan",
            "NaN",
            "-nan",
            "NaNQ",
            "NANS",
            "qNaN",
            "sNaN",
            "-nan(ind)",
            "nan(snan)",
            "NaN(0x8000000000000)",
            "1.#QNAN",
            "-1.#IND",
            "-1.#IND0E+00",
            "1.#QNAN0E+000",
            "1.#SNAN00",
            "1.#J",
            "-1.#IO",
            "1.#R",
            "-1.#INDE+000",
            "-1.#INDe+000",
        ] {
            let value = field(text.as_bytes(), b'.');
            assert!(value.is_some_and(f64::is_nan), "{text}: {value:?}");
            assert!(
                fortran_field(text.as_bytes()).is_some_and(f64::is_nan),
                "{text}"
            );
        }
        for (text, value) in [
            ("inf", f64::INFINITY),
            ("+Infinity", f64::INFINITY),
            ("-INF", f64::NEG_INFINITY),
            ("1.#INF", f64::INFINITY),
            ("-1.#INF00E+00", f64::NEG_INFINITY),
        ] {
            assert_eq!(field(text.as_bytes(), b'.'), Some(value), "{text}");
        }
        assert!(field(b"-1,#IND", b',').is_some_and(f64::is_nan));
        for text in [
            "1.#", "1.#0", "2.#IND", "1.#IND5", "1.#INDE", "nanx", "nan(", "nan(ind", "infi",
            "#IND", "1,#IND", "--inf", "1.#ind", "in", "",
        ] {
            assert_eq!(field(text.as_bytes(), b'.'), None, "{text}");
        }
    }

    #[test]
    fn an_exponent_without_letter_is_one_in_universal_files_alone() {
        for text in ["12-345", "1.5-105", "3+002"] {
            assert_eq!(field(text.as_bytes(), b'.'), None, "{text}");
            assert!(fortran_field(text.as_bytes()).is_some(), "{text}");
        }
        assert_eq!(prefix(b"12-345", b'.'), Some((12.0, 2)));
    }

    #[test]
    fn ties_go_to_even() {
        for text in [
            "9007199254740993",
            "9007199254740993e1",
            "9007199254740995.0",
            "4503599627370497.5",
            "4503599627370498.5",
            "0.1000000000000000055",
            "18446744073709551615e-27",
            "1e23",
            "89255e-22",
        ] {
            let expected: f64 = text.parse().expect("a decimal number");
            let (value, len) =
                prefix(text.as_bytes(), b'.').expect("it begins with a digit or a sign");
            assert_eq!(
                (value.to_bits(), len),
                (expected.to_bits(), text.len()),
                "{text}"
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn every_decimal_of_up_to_19_digits_is_rounded_right(mantissa: u64, digits in 1u32..20, power in -27i32..28) {
            let mantissa = mantissa % 10u64.pow(digits);
            let text = format!("{mantissa}e{power}");
            let expected: f64 = text.parse().expect("a decimal number");
            let (value, _) = prefix(text.as_bytes(), b'.').expect("it begins with a digit or a sign");
            prop_assert_eq!(value.to_bits(), expected.to_bits(), "{}", text);
            let value = scaled(mantissa, power).unwrap_or(expected);
            prop_assert_eq!(value.to_bits(), expected.to_bits(), "{}", text);
        }

        #[test]
        fn the_value_is_that_of_the_standard_library(bits: u64, digits in 0usize..20, scale in -30i32..30, mantissa: i64) {
            let random = f64::from_bits(bits);
            let texts = [format!("{random:.digits$e}"), format!("{random:?}"), format!("{mantissa}e{scale}")];
            for text in texts.iter().filter(|text| text.parse::<f64>().is_ok_and(f64::is_finite)) {
                let (value, len) = prefix(text.as_bytes(), b'.').expect("it begins with a digit or a sign");
                prop_assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{}", text);
                prop_assert_eq!(len, text.len());
            }
        }
    }
}

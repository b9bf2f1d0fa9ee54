//! The most memory that the program may take: a file of 10 MB can unpack to more than the machine
//! has, and a machine without memory stops everything that runs on it.

use crate::error::Error;

/// Limits below this leave no room for the program itself.
const MIN_BYTES: usize = 16 << 20;

/// Share of the machine's memory that is the limit where none is stated, in quarters. Larger: the
/// machine stops before a file is refused. Smaller: work that the machine can do is refused.
const DEFAULT_QUARTERS: usize = 3;

/// Sets the limit of `--max-memory`, or by default three quarters of the memory of the machine.
///
/// # Errors
/// [`Error::Argument`] for a text that is no size.
pub(super) fn set(
    stated: Option<&str>,
    limit_memory: impl FnOnce(usize) -> bool,
) -> Result<(), Error> {
    let limit = match stated {
        None => machine_bytes().map(|bytes| bytes / 4 * DEFAULT_QUARTERS),
        Some(text) => Some(
            bytes_of(text)
                .filter(|bytes| *bytes >= MIN_BYTES)
                .ok_or_else(|| Error::Argument {
                    argument: "--max-memory",
                    got: text.to_owned(),
                    expected: "a size of 16M or more, such as 500M or 4G".to_owned(),
                })?,
        ),
    };
    // The limit is refused only where more is taken already, which is less than the smallest.
    limit.map(limit_memory);
    Ok(())
}

/// A number of bytes with K, M, G or T for powers of 1024.
fn bytes_of(text: &str) -> Option<usize> {
    let text = text
        .trim()
        .trim_end_matches(['b', 'B'])
        .trim_end_matches('i');
    let unit = text.chars().next_back()?;
    let power = "KMGT".find(unit.to_ascii_uppercase());
    let digits = power.map_or(text, |_| text.trim_end_matches(unit));
    let number: f64 = digits.trim().parse().ok()?;
    let bytes = number * 1024_f64.powi(power.map_or(0, |power| power as i32 + 1));
    (bytes >= 1.0 && bytes < usize::MAX as f64).then_some(bytes as usize)
}

/// Bytes of the machine's memory, on Linux.
fn machine_bytes() -> Option<usize> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: usize = line.split_whitespace().next()?.parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_powers_of_1024() {
        for (text, bytes) in [
            ("500M", 500 << 20),
            ("4G", 4 << 30),
            ("1.5 GiB", 3 << 29),
            ("16mb", 16 << 20),
            ("1048576", 1 << 20),
        ] {
            assert_eq!(bytes_of(text), Some(bytes), "{text}");
        }
        for text in ["", "G", "-1G", "nan", "four", "1e30T"] {
            assert_eq!(bytes_of(text), None, "{text}");
        }
    }
}

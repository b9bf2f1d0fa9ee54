//! Degrees of freedom as measurement systems print them.

use crate::dof::{Axis, Dof};

/// A degree of freedom from `12+Z`, `12-RX` or `12:+Z`; the point begins with a digit, so that a
/// channel's name is none, and is not 0, which stands for a channel without a position.
pub(in crate::io::formats) fn printed_dof(text: &str) -> Option<Dof> {
    let text = text.trim();
    let sign = text.rfind(['+', '-'])?;
    let (point, direction) = (&text[..sign], &text[sign..]);
    let point = point.strip_suffix(':').unwrap_or(point);
    let unplaced = point.bytes().all(|digit| digit == b'0');
    if unplaced || !point.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let axis = Axis::ALL
        .into_iter()
        .find(|axis| axis.to_string() == direction[1..])?;
    Dof::new(point, axis, direction.starts_with('-')).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_with_a_direction_is_a_dof_and_a_name_is_not() {
        for (text, expected) in [
            ("12+Z", "12:+Z"),
            (" 10-Z ", "10:-Z"),
            ("3:-RX", "3:-RX"),
            ("1a-S", "1a:-S"),
        ] {
            assert_eq!(printed_dof(text).unwrap().to_string(), expected);
        }
        for text in [
            "", "hammer", "PCB-Z", "12", "12+", "12+z", "+Z", "1 2+Z", "²-Z", "0-Z", "00+X",
        ] {
            assert_eq!(printed_dof(text), None, "{text}");
        }
    }
}

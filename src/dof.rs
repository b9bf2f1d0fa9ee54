//! Degrees of freedom: a point, a direction and its sign, and their text form `POINT:±AXIS`.
//!
//! A [`Dof`] names where and in which direction something is measured, hit or predicted. It holds
//! no coordinates and no unit. The sign belongs to the sensor: `3:-Z` reads the negative of `3:+Z`.

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Direction of a degree of freedom at its point; `S` is a scalar without direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// No direction (pressure, temperature, an unlabelled channel).
    S,
    /// Translation along x.
    X,
    /// Translation along y.
    Y,
    /// Translation along z.
    Z,
    /// Rotation about x.
    RX,
    /// Rotation about y.
    RY,
    /// Rotation about z.
    RZ,
}

/// The one table of axis names and universal-file direction codes (0 scalar, 1 to 3 translations, 4
/// to 6 rotations).
const AXES: [(Axis, &str, i32); 7] = [
    (Axis::S, "S", 0),
    (Axis::X, "X", 1),
    (Axis::Y, "Y", 2),
    (Axis::Z, "Z", 3),
    (Axis::RX, "RX", 4),
    (Axis::RY, "RY", 5),
    (Axis::RZ, "RZ", 6),
];

impl Axis {
    /// Every axis, in the order of the universal-file direction codes.
    pub const ALL: [Axis; 7] = [
        Axis::S,
        Axis::X,
        Axis::Y,
        Axis::Z,
        Axis::RX,
        Axis::RY,
        Axis::RZ,
    ];

    fn row(self) -> (Axis, &'static str, i32) {
        AXES[self as usize]
    }

    /// Unit vector of the axis in the global frame; `None` for a scalar.
    pub fn unit_vector(self) -> Option<[f64; 3]> {
        match self {
            Axis::S => None,
            Axis::X | Axis::RX => Some([1.0, 0.0, 0.0]),
            Axis::Y | Axis::RY => Some([0.0, 1.0, 0.0]),
            Axis::Z | Axis::RZ => Some([0.0, 0.0, 1.0]),
        }
    }

    /// Whether the axis is a rotation.
    pub fn is_rotation(self) -> bool {
        matches!(self, Axis::RX | Axis::RY | Axis::RZ)
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().1)
    }
}

/// Why a text is not a degree of freedom.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("got degree of freedom `{got}`, expected {expected}")]
pub struct DofError {
    /// The text as given.
    pub got: String,
    /// What would have been accepted.
    pub expected: &'static str,
}

/// A degree of freedom: point, axis, sign of the sensor, and the number of a repeated measurement.
///
/// Ordered by component, point (numbers by value before names), axis, sign, repeat.
///
/// ```
/// use modalign::dof::Dof;
/// let dof: Dof = "gearbox.12:-Z".parse().unwrap();
/// assert_eq!(dof.to_string(), "gearbox.12:-Z");
/// assert!(dof.is_negative());
/// assert!("2:+X".parse::<Dof>().unwrap() < "10:+X".parse::<Dof>().unwrap());
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Dof {
    point: String,
    axis: Axis,
    negative: bool,
    repeat: u32,
}

const EXPECTED: &str = "a point with a direction, such as 2:+Z or wing.12:-X: a name of letters, digits, _ . - (at most 32), and X, Y, Z, RX, RY, RZ or S (scalar) with its sign";

impl Dof {
    /// A degree of freedom from its parts.
    ///
    /// # Errors
    /// [`DofError`] when the point is empty, longer than its limit or holds another character.
    pub fn new(point: &str, axis: Axis, negative: bool) -> Result<Self, DofError> {
        let name = point.split_once('.').map_or(point, |(_, rest)| rest);
        let legal = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '-');
        if name.is_empty() || name.len() > 32 || point.len() > 65 || !point.chars().all(legal) {
            return Err(DofError {
                got: point.to_owned(),
                expected: EXPECTED,
            });
        }
        Ok(Self {
            point: point.to_owned(),
            axis,
            negative,
            repeat: 1,
        })
    }

    /// A degree of freedom of a numbered universal-file node; direction codes are -6 to 6.
    /// `None` for node 0 (no node) or a code outside that range.
    pub fn from_node(node: i64, direction: i32) -> Option<Self> {
        let axis = AXES.iter().find(|row| row.2 == direction.abs())?.0;
        (node > 0).then(|| Self {
            point: node.to_string(),
            axis,
            negative: direction < 0,
            repeat: 1,
        })
    }

    /// The universal-file node number, when the point is one.
    pub fn node(&self) -> Option<i64> {
        let name = self.point.rsplit('.').next().unwrap_or(&self.point);
        name.parse().ok().filter(|n| *n > 0)
    }

    /// The component name before the point, when there is one.
    pub fn component(&self) -> Option<&str> {
        self.point.split_once('.').map(|(component, _)| component)
    }

    /// The universal-file direction code, -6 to 6.
    pub fn direction_code(&self) -> i32 {
        if self.negative {
            -self.axis.row().2
        } else {
            self.axis.row().2
        }
    }

    /// The point with its component, as written.
    pub fn point(&self) -> &str {
        &self.point
    }

    /// The axis, without its sign.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// Whether the sensor points against the axis.
    pub fn is_negative(&self) -> bool {
        self.negative
    }

    /// `+1.0` or `-1.0`, the factor that turns data of this sensor to the positive axis.
    pub fn sign(&self) -> f64 {
        if self.negative { -1.0 } else { 1.0 }
    }

    /// The same degree of freedom with the sensor along the positive axis.
    pub fn positive(&self) -> Self {
        Self {
            negative: false,
            ..self.clone()
        }
    }

    /// The same degree of freedom with the sensor turned round.
    pub fn opposite(&self) -> Self {
        Self {
            negative: !self.negative,
            ..self.clone()
        }
    }

    /// Which repeated measurement of this degree of freedom it is, from 1.
    pub fn repeat(&self) -> u32 {
        self.repeat
    }

    /// The same degree of freedom as its `repeat`-th measurement (from 1).
    pub fn with_repeat(&self, repeat: u32) -> Self {
        Self {
            repeat: repeat.max(1),
            ..self.clone()
        }
    }

    /// The DOF without the polarity of its sensor and without the number of the measurement.
    pub(crate) fn without_sign_and_repeat(&self) -> Self {
        self.positive().with_repeat(1)
    }

    /// Component (none first), then numbers by value before names.
    fn point_key(&self) -> (&str, bool, u64, &str) {
        let (component, name) = self.point.split_once('.').unwrap_or(("", &self.point));
        let number = name.parse::<u64>().ok();
        (component, number.is_none(), number.unwrap_or(0), name)
    }
}

/// Whether a name is a number without leading zeros that `u64` holds.
fn is_plain_number(name: &str) -> bool {
    let bytes = name.as_bytes();
    let starts = bytes.first().is_some_and(|byte| *byte != b'0');
    starts && bytes.len() <= 19 && bytes.iter().all(u8::is_ascii_digit)
}

impl PartialOrd for Dof {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dof {
    fn cmp(&self, other: &Self) -> Ordering {
        let points = || match is_plain_number(&self.point) && is_plain_number(&other.point) {
            // As the keys, without reading numbers: most points are named so.
            true => (self.point.len().cmp(&other.point.len())).then(self.point.cmp(&other.point)),
            false => self.point_key().cmp(&other.point_key()),
        };
        let key = |dof: &Self| (dof.axis, dof.negative, dof.repeat);
        let same = self.point == other.point;
        let points = if same { Ordering::Equal } else { points() };
        points.then_with(|| key(self).cmp(&key(other)))
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negative { '-' } else { '+' };
        write!(f, "{}:{sign}{}", self.point, self.axis)?;
        if self.repeat > 1 {
            write!(f, "#{}", self.repeat)
        } else {
            Ok(())
        }
    }
}

impl FromStr for Dof {
    type Err = DofError;

    fn from_str(text: &str) -> Result<Self, DofError> {
        let error = || DofError {
            got: text.to_owned(),
            expected: EXPECTED,
        };
        let (body, repeat) = match text.split_once('#') {
            Some((body, count)) => (
                body,
                count.parse().ok().filter(|n| *n > 0).ok_or_else(error)?,
            ),
            None => (text, 1),
        };
        let (point, direction) = body.rsplit_once(':').ok_or_else(error)?;
        let negative = direction.starts_with('-');
        let name = direction.strip_prefix(['+', '-']).unwrap_or(direction);
        let axis = AXES.iter().find(|row| row.1 == name).ok_or_else(error)?.0;
        let dof = Dof::new(point, axis, negative).map_err(|_| error())?;
        Ok(dof.with_repeat(repeat))
    }
}

impl Serialize for Dof {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Dof {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_and_sign_survives_text_and_node_code() {
        for axis in Axis::ALL {
            for negative in [false, true] {
                let dof = Dof::new("7", axis, negative).unwrap();
                assert_eq!(dof.to_string().parse::<Dof>().unwrap(), dof);
                if axis != Axis::S {
                    assert_eq!(Dof::from_node(7, dof.direction_code()), Some(dof));
                }
            }
        }
    }

    #[test]
    fn malformed_text_is_refused() {
        for text in [
            "", "1", "1:", ":+Z", "1:+Q", "1:++Z", "a b:+Z", "1:+Z#0", "é:+X",
        ] {
            assert!(text.parse::<Dof>().is_err(), "{text}");
        }
    }

    #[test]
    fn order_of_points_is_that_of_their_keys() {
        let names = [
            "0",
            "1",
            "2",
            "9",
            "10",
            "007",
            "07",
            "99",
            "100",
            "18446744073709551615",
            "18446744073709551616",
            "9999999999999999999",
            "1000000000000000000",
            "a",
            "1a",
            "a.2",
            "a.10",
            "b.1",
            "1.2",
            "2.1",
            "10.1",
        ];
        let dofs = names.map(|name| Dof::new(name, Axis::Z, false).unwrap());
        for (a, b) in dofs.iter().flat_map(|a| dofs.iter().map(move |b| (a, b))) {
            assert_eq!(a.cmp(b), a.point_key().cmp(&b.point_key()), "{a} {b}");
        }
    }

    #[test]
    fn numbers_sort_by_value_before_names() {
        let mut dofs: Vec<Dof> = ["b.10:+X", "a:+X", "10:+X", "b.9:+X", "9:+Z", "9:+X"]
            .iter()
            .map(|t| t.parse().unwrap())
            .collect();
        dofs.sort();
        let text: Vec<String> = dofs.iter().map(ToString::to_string).collect();
        let expected = ["9:+X", "9:+Z", "10:+X", "a:+X", "b.9:+X", "b.10:+X"];
        assert_eq!(text, expected);
    }
}

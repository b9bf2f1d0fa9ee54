//! Coordinate systems as datasets 18 and 2420 give them, and what becomes of them: units, chains of
//! references.

use std::collections::{BTreeMap, BTreeSet};

use crate::geometry::{CoordinateSystem, SystemKind};
use crate::io::formats::uff::fields::{FieldError, Line, Position};
use crate::linalg::Vector3;

/// Largest error of the unit vectors of a transformation: writers print five digits and more.
const ORTHONORMAL: f64 = 1e-4;
/// Smallest sine of the angle at the origin between the points on the +x axis and on the +xz plane.
const SMALLEST_SINE: f64 = 1e-6;

/// A coordinate system in file units.
#[derive(Clone, Debug)]
pub(in crate::io::formats::uff) struct RawSystem {
    pub at: Position,
    pub label: i64,
    pub name: String,
    pub kind: SystemKind,
    pub placement: Placement,
}

/// Where a system stands, in file units.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::io::formats::uff) enum Placement {
    /// Unit vectors and origin in the global frame.
    Matrix {
        axes: [[f64; 3]; 3],
        origin: [f64; 3],
    },
    /// Origin, a point on the +x axis and one on the +xz plane, in coordinates of another system.
    Points {
        reference: i64,
        points: [[f64; 3]; 3],
    },
}

impl RawSystem {
    /// Checks the label: 0 is the global frame.
    pub fn new(
        line: &Line,
        label: i64,
        name: String,
        kind: SystemKind,
        placement: Placement,
    ) -> Result<Self, FieldError> {
        if label <= 0 {
            let what = "label of a coordinate system";
            return Err(FieldError::line(line, what, "a positive number"));
        }
        Ok(Self {
            at: line.at,
            label,
            name,
            kind,
            placement,
        })
    }

    /// The system whose coordinates the points are in; `None` for the global frame and for itself.
    fn reference(&self) -> Option<i64> {
        match self.placement {
            Placement::Points { reference, .. } if reference != self.label => Some(reference),
            _ => None,
        }
    }

    fn refuse(&self, got: String, expected: &str) -> FieldError {
        FieldError {
            at: self.at,
            what: "coordinate system",
            got,
            expected: expected.to_owned(),
        }
    }

    /// The system in metres; `length` file units are one metre, `reference` is the system of its
    /// points.
    fn placed(
        &self,
        reference: Option<&CoordinateSystem>,
        length: f64,
    ) -> Result<CoordinateSystem, FieldError> {
        let (axes, origin_m) = match &self.placement {
            Placement::Matrix { axes, origin } => (
                self.checked(axes.map(Vector3::from))?,
                Vector3::from(*origin) / length,
            ),
            Placement::Points { points, .. } => {
                let [origin, on_x, on_xz] =
                    points.map(|point| position_m(reference, point, length));
                (self.axes_from(on_x - origin, on_xz - origin)?, origin)
            }
        };
        Ok(CoordinateSystem {
            label: self.label,
            name: self.name.clone(),
            kind: self.kind,
            origin_m,
            axes,
        })
    }

    /// Right-handed axes of unit length at right angles.
    fn checked(&self, axes: [Vector3; 3]) -> Result<[Vector3; 3], FieldError> {
        let [x, y, z] = axes;
        let errors = [x.cross(&y) - z, y.cross(&z) - x, z.cross(&x) - y];
        let lengths = axes.iter().map(|axis| (axis.norm() - 1.0).abs());
        let mut errors = errors.iter().map(Vector3::norm).chain(lengths);
        let good = errors.all(|error| error <= ORTHONORMAL);
        let refuse = || {
            self.refuse(
                format!("axes {x:?} {y:?} {z:?}"),
                "right-handed unit vectors",
            )
        };
        good.then_some(axes).ok_or_else(refuse)
    }

    fn axes_from(&self, to_x: Vector3, to_xz: Vector3) -> Result<[Vector3; 3], FieldError> {
        let refuse = || {
            let got = format!("{to_x:?} and {to_xz:?} from its origin");
            self.refuse(got, "points on the +x axis and on the +xz plane")
        };
        let x = to_x.try_normalize(0.0).ok_or_else(refuse)?;
        let across = to_xz - x * to_xz.dot(&x);
        if across.norm() <= SMALLEST_SINE * to_xz.norm() {
            return Err(refuse());
        }
        let z = across.try_normalize(0.0).ok_or_else(refuse)?;
        Ok([x, z.cross(&x), z])
    }
}

/// The kind of this number in datasets 18 and 2420.
pub(in crate::io::formats::uff) fn kind(code: i64) -> Option<SystemKind> {
    match code {
        0 => Some(SystemKind::Cartesian),
        1 => Some(SystemKind::Cylindrical),
        2 => Some(SystemKind::Spherical),
        _ => None,
    }
}

/// The number of a kind in datasets 18 and 2420.
pub(in crate::io::formats::uff) fn code(kind: SystemKind) -> i64 {
    match kind {
        SystemKind::Cartesian => 0,
        SystemKind::Cylindrical => 1,
        SystemKind::Spherical => 2,
    }
}

/// Global position, m, of coordinates in file units: lengths by `length` units to the metre, angles
/// in degrees.
pub(in crate::io::formats::uff) fn position_m(
    system: Option<&CoordinateSystem>,
    [a, b, c]: [f64; 3],
    length: f64,
) -> Vector3 {
    let Some(system) = system else {
        return Vector3::new(a, b, c) / length;
    };
    system.global_position(match system.kind {
        SystemKind::Cartesian => [a / length, b / length, c / length],
        SystemKind::Cylindrical => [a / length, b.to_radians(), c / length],
        SystemKind::Spherical => [a / length, b.to_radians(), c.to_radians()],
    })
}

/// The systems of a file, in metres, and what is wrong with others.
#[derive(Debug, Default)]
pub(in crate::io::formats::uff) struct Systems {
    /// In file order.
    pub placed: Vec<CoordinateSystem>,
    pub damage: Vec<FieldError>,
    /// Labels of undescribed systems that other systems refer to.
    pub unknown: Vec<(Position, i64)>,
    by_label: BTreeMap<i64, usize>,
}

/// A system that is looked up by its label.
pub(in crate::io::formats::uff) enum Found<'a> {
    /// The global frame.
    Global,
    Local(&'a CoordinateSystem),
    /// No dataset describes it.
    Unknown,
}

impl Systems {
    /// Puts systems in metres; `length` gives the file units in one metre at a place. A system
    /// with an undescribed reference is placed in the global frame; one that refers to itself
    /// through others is damage.
    pub fn new(raw: Vec<RawSystem>, length: impl Fn(Position) -> f64) -> Self {
        let mut systems = Self::default();
        let raw = systems.without_repeats(raw);
        let index: BTreeMap<i64, usize> =
            (raw.iter().map(|system| system.label)).zip(0..).collect();
        let mut placed: Vec<Option<CoordinateSystem>> = vec![None; raw.len()];
        let mut tried = vec![false; raw.len()];
        for start in 0..raw.len() {
            let mut chain = Vec::new();
            let mut next = Some(start);
            while let Some(i) = next.filter(|i| !tried[*i]) {
                tried[i] = true;
                chain.push(i);
                next = raw[i].reference().and_then(|to| index.get(&to)).copied();
            }
            while let Some(i) = chain.pop() {
                placed[i] = systems.place(&raw[i], &index, &placed, &length);
            }
        }
        systems.placed = placed.into_iter().flatten().collect();
        let labels = systems.placed.iter().map(|system| system.label);
        systems.by_label = labels.zip(0..).collect();
        systems
    }

    /// A system that is given twice in one way is one; in two ways it is damage.
    fn without_repeats(&mut self, raw: Vec<RawSystem>) -> Vec<RawSystem> {
        let mut first: BTreeMap<i64, usize> = BTreeMap::new();
        let mut kept: Vec<RawSystem> = Vec::new();
        for system in raw {
            match first.get(&system.label).map(|i| &kept[*i]) {
                None => {
                    first.insert(system.label, kept.len());
                    kept.push(system);
                }
                Some(first_description)
                    if first_description.kind == system.kind
                        && first_description.placement == system.placement => {}
                Some(_) => {
                    let got = format!("{} described again", system.label);
                    self.damage.push(system.refuse(got, "the same as before"));
                }
            }
        }
        kept
    }

    fn place(
        &mut self,
        raw: &RawSystem,
        index: &BTreeMap<i64, usize>,
        placed: &[Option<CoordinateSystem>],
        length: impl Fn(Position) -> f64,
    ) -> Option<CoordinateSystem> {
        let described = |label| index.get(&label).map(|i| placed[*i].as_ref());
        let reference = match raw.reference().map(|label| (label, described(label))) {
            None | Some((0 | 1, None)) => None,
            Some((label, None)) => {
                self.unknown.push((raw.at, label));
                None
            }
            Some((_, Some(Some(reference)))) => Some(reference),
            Some((label, Some(None))) => {
                let got = format!("{} in coordinates of system {label}", raw.label);
                let expected = "a reference system that is described without this one";
                self.damage.push(raw.refuse(got, expected));
                return None;
            }
        };
        raw.placed(reference, length(raw.at))
            .map_err(|error| self.damage.push(error))
            .ok()
    }

    /// The system of a label; 0 and, unless it is described, 1 are the global frame.
    pub fn find(&self, label: i64) -> Found<'_> {
        match (self.by_label.get(&label), label) {
            (Some(i), _) => Found::Local(&self.placed[*i]),
            (None, 0 | 1) => Found::Global,
            (None, _) => Found::Unknown,
        }
    }

    /// Undescribed labels among `asked`, with their positions; each once.
    pub fn undescribed(
        &self,
        asked: impl Iterator<Item = (Position, i64)>,
    ) -> Vec<(Position, i64)> {
        let mut listed = BTreeSet::new();
        let known = self.unknown.iter().copied();
        known
            .chain(asked.filter(|(_, label)| matches!(self.find(*label), Found::Unknown)))
            .filter(|(_, label)| listed.insert(*label))
            .collect()
    }
}

//! Entity name, node and direction of dataset 58, record 6, to and from a [`Dof`].

use crate::dof::{Axis, Dof, DofError};

/// Columns of an entity name.
const NAME_COLUMNS: usize = 10;
/// Node numbers fill at most 9 of their 10 columns, so that fields stay apart.
const LARGEST_NODE: i64 = 999_999_999;

/// The three fields that name one degree of freedom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::io::formats::uff) struct DofFields {
    /// Entity (component) name, trimmed, `NONE` made empty.
    pub name: String,
    /// Node number, 0 for none.
    pub node: i64,
    /// Direction code, -6 to 6.
    pub direction: i32,
}

impl DofFields {
    /// No degree of freedom.
    pub fn none() -> Self {
        Self {
            name: String::new(),
            node: 0,
            direction: 0,
        }
    }

    /// The degree of freedom, when the fields name one.
    ///
    /// A node with a name is `name.node`, unless the name says nothing new (empty, the node's
    /// number, or the point with its direction such as `1+Z`) or holds characters that a point
    /// cannot have. Without a node, a name with a direction is the point.
    pub fn dof(&self) -> Option<Dof> {
        if self.node <= 0 {
            return self.named_point();
        }
        let plain = Dof::from_node(self.node, self.direction)?;
        if self.name.is_empty() || self.repeats(&plain) {
            return Some(plain);
        }
        let point = format!("{}.{}", self.name, self.node);
        Some(Dof::new(&point, plain.axis(), plain.is_negative()).unwrap_or(plain))
    }

    /// The scalar point of a name without node and direction; characters that a point cannot have
    /// become `_`. `None` where there is no such name.
    pub fn scalar(&self) -> Option<Dof> {
        let is_alone = self.node <= 0 && self.direction == 0 && !self.name.is_empty();
        let point = |c: char| match c.is_ascii_alphanumeric() || "_.-".contains(c) {
            true => c,
            false => '_',
        };
        let name: String = self.name.chars().map(point).collect();
        let stated = || self.name.parse().ok();
        let dof = || stated().or_else(|| Dof::new(&name, Axis::S, false).ok());
        is_alone.then(dof).flatten()
    }

    fn named_point(&self) -> Option<Dof> {
        // Axis and sign of the direction code do not depend on the node.
        let direction = Dof::from_node(1, self.direction).filter(|_| self.direction != 0)?;
        Dof::new(&self.name, direction.axis(), direction.is_negative()).ok()
    }

    /// Whether the name is the node, alone or with its direction: `12`, `12+Z`, `12:Z`, `12Z` for
    /// node 12, direction 3.
    fn repeats(&self, plain: &Dof) -> bool {
        let Some(rest) = self.name.strip_prefix(plain.point()) else {
            return false;
        };
        let rest = rest.strip_prefix(':').unwrap_or(rest);
        let sign = if plain.is_negative() { "-" } else { "+" };
        let axis = plain.axis().to_string();
        rest.is_empty()
            || rest.eq_ignore_ascii_case(&format!("{sign}{axis}"))
            || (!plain.is_negative() && rest.eq_ignore_ascii_case(&axis))
    }

    /// The fields that [`DofFields::dof`] reads back as this degree of freedom (the number of a
    /// repeated measurement has no field and is left away).
    ///
    /// # Errors
    /// [`DofError`] when no fields do: a name of more than 10 characters without a node number, or
    /// a name without direction.
    pub fn from_dof(dof: &Dof) -> Result<Self, DofError> {
        let direction = dof.direction_code();
        let by_node = dof
            .node()
            .filter(|node| *node <= LARGEST_NODE)
            .map(|node| Self {
                name: dof.component().unwrap_or_default().to_owned(),
                node,
                direction,
            });
        let by_name = Self {
            name: dof.point().to_owned(),
            node: 0,
            direction,
        };
        let first = dof.with_repeat(1);
        by_node
            .into_iter()
            .chain([by_name])
            .find(|fields| {
                fields.name.len() <= NAME_COLUMNS
                    && fields.name != "NONE"
                    && fields.dof().as_ref() == Some(&first)
            })
            .ok_or_else(|| DofError {
                got: dof.to_string(),
                expected: "a node number of at most 9 digits with a component of at most 10 characters, or a point of \
                           at most 10 characters with a direction (dataset 58)",
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(name: &str, node: i64, direction: i32) -> Option<String> {
        let name = name.to_owned();
        let fields = DofFields {
            name,
            node,
            direction,
        };
        fields.dof().map(|dof| dof.to_string())
    }

    #[test]
    fn a_name_alone_is_a_scalar_point() {
        let scalar = |name: &str, node, direction| {
            let name = name.to_owned();
            let fields = DofFields {
                name,
                node,
                direction,
            };
            fields.scalar().map(|dof| dof.to_string())
        };
        for (name, expected) in [
            ("acc1", "acc1:+S"),
            ("Mic 01", "Mic_01:+S"),
            ("acc1:+Z", "acc1:+Z"),
            ("12:-X", "12:-X"),
        ] {
            assert_eq!(scalar(name, 0, 0).as_deref(), Some(expected));
        }
        for (name, node, direction) in [("", 0, 0), ("acc1", 3, 0), ("acc1", 0, 3)] {
            assert_eq!(scalar(name, node, direction), None);
        }
    }

    #[test]
    fn redundant_names_are_no_component() {
        for name in ["", "1", "1+Z", "1:+Z", "1Z", "1:z"] {
            assert_eq!(read(name, 1, 3).as_deref(), Some("1:+Z"), "{name}");
        }
        assert_eq!(read("1-Z", 1, -3).as_deref(), Some("1:-Z"));
        assert_eq!(read("1-Z", 1, 3).as_deref(), Some("1-Z.1:+Z"));
        assert_eq!(read("TestCase", 1, 1).as_deref(), Some("TestCase.1:+X"));
        assert_eq!(read("Mic 01", 4, 1).as_deref(), Some("4:+X"));
        assert_eq!(read("12", 1, 3).as_deref(), Some("12.1:+Z"));
    }

    #[test]
    fn without_a_node_the_name_is_the_point() {
        assert_eq!(read("bearing", 0, -2).as_deref(), Some("bearing:-Y"));
        assert_eq!(read("Mic 01", 0, 1), None);
        assert_eq!(read("", 0, 0), None);
        assert_eq!(read("bearing", 0, 0), None);
        assert_eq!(read("", 5, 7), None);
    }

    #[test]
    fn dofs_without_fields_are_refused() {
        for text in [
            "a-long-bearing:+Z",
            "bearing:+S",
            "NONE:+X",
            "a-long-gearbox.3:+X",
        ] {
            let dof: Dof = text.parse().unwrap();
            assert_eq!(DofFields::from_dof(&dof).unwrap_err().got, text);
        }
    }

    proptest! {
        #[test]
        fn fields_come_back_as_the_same_degree_of_freedom(
            point in "([a-zA-Z0-9_-]{1,6}\\.)?[A-Za-z0-9_-]{1,10}",
            axis in 0usize..7,
            negative: bool,
        ) {
            let dof = Dof::new(&point, Axis::ALL[axis], negative).unwrap();
            if let Ok(fields) = DofFields::from_dof(&dof) {
                prop_assert_eq!(fields.dof(), Some(dof));
            }
        }

        #[test]
        fn every_numbered_node_has_fields(node in 1i64..=LARGEST_NODE, direction in -6i32..=6) {
            let dof = Dof::from_node(node, direction).unwrap();
            let fields = DofFields::from_dof(&dof).unwrap();
            prop_assert_eq!((fields.node, fields.direction, fields.name.as_str()), (node, direction, ""));
        }
    }
}

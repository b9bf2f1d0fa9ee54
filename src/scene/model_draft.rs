//! Model files to begin with: `modalign new --model beam` writes one beside the scene.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::dof::Dof;
use crate::geometry::Geometry;
use crate::linalg::Vector3;

use super::SceneError;
use super::model::{LoadedModel, model_of_text};

/// Minimum sine between a direction of hits and the line of the points that counts as across it.
/// Larger, at 0.5: hits 30 degrees off the line have no share. Smaller, at 0.01: the direction is
/// that of rounding. Test
/// `a_beam_is_drafted_along_the_points_and_bends_in_the_direction_of_the_hits`.
const MIN_SINE_ACROSS: f64 = 0.1;

/// The line of a drafted beam between the outermost points, behind `to_m`.
const ASSUMED_ENDS: &str = "\nends_status = \"assumed\"            # the outermost points, a guess of its length: state the true ends, \"printed\"";

/// A model file with the values of an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelDraft {
    /// The kind of the model, by which it is asked for.
    pub kind: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

impl ModelDraft {
    /// Every draft.
    pub const ALL: [ModelDraft; 2] = [
        ModelDraft {
            kind: "beam",
            text: include_str!("model_drafts/beam.toml"),
        },
        ModelDraft {
            kind: "lumped",
            text: include_str!("model_drafts/lumped.toml"),
        },
    ];
    /// The name of the file beside the scene.
    pub const FILE: &'static str = "model.toml";

    /// The draft of this kind; `./beam` and `beam/` name a file or a folder.
    pub fn at(path: &Path) -> Option<Self> {
        let mut drafts = Self::ALL.into_iter();
        drafts.find(|draft| path.as_os_str() == draft.kind)
    }

    /// The text of the file; a beam runs along the line of the points where that is known.
    pub fn text_along(self, line: Option<&PointLine>) -> String {
        let Some(line) = line.filter(|_| self.kind == "beam") else {
            return self.text.to_owned();
        };
        let stated = [
            ("from_m", line.from_m),
            ("to_m", line.to_m),
            ("deflection", line.deflection),
        ];
        let with_value = |text: &str| {
            let (key, rest) = text.split_once(" = [")?;
            let (_, value) = stated.iter().find(|(name, _)| *name == key)?;
            let (_, remark) = rest.split_once(']')?;
            let [x, y, z] = value.map(|value| (1e6 * value).round() / 1e6 + 0.0);
            let ends = if key == "to_m" { ASSUMED_ENDS } else { "" };
            Some(format!("{key} = [{x:?}, {y:?}, {z:?}]{remark}{ends}"))
        };
        let lines = self.text.lines();
        let lines = lines.map(|line| with_value(line).unwrap_or_else(|| line.to_owned()) + "\n");
        lines.collect()
    }

    /// The model of its values.
    ///
    /// # Errors
    /// As for a model file.
    pub fn load(self) -> Result<LoadedModel, SceneError> {
        model_of_text(self.text, Path::new(Self::FILE), &BTreeMap::new())
    }
}

/// The line of the points of a test, and the direction in which a beam along it bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLine {
    /// Its beginning, m.
    pub from_m: [f64; 3],
    /// Its end, m.
    pub to_m: [f64; 3],
    /// The direction of most sensors and hits as far as it is across the line.
    pub deflection: [f64; 3],
}

impl PointLine {
    /// Its length, m.
    pub fn length_m(&self) -> f64 {
        (Vector3::from(self.to_m) - Vector3::from(self.from_m)).norm()
    }

    /// The line between the extreme points of these degrees of freedom; `None` where fewer than two
    /// have different positions.
    pub(super) fn of(dofs: &BTreeSet<Dof>, points: &Geometry) -> Option<Self> {
        let positions = dofs.iter().filter_map(|dof| points.node(dof.point()));
        let positions: Vec<Vector3> = positions.map(|node| node.at_m).collect();
        let farthest = |from: &Vector3| {
            let distance = |other: &&Vector3| (**other - *from).norm();
            let found = positions
                .iter()
                .max_by(|a, b| distance(a).total_cmp(&distance(b)));
            found.copied()
        };
        let one = farthest(positions.first()?)?;
        let other = farthest(&one)?;
        let across_from = other - one;
        if across_from.norm() <= 0.0 {
            return None;
        }
        let runs_back = {
            let main =
                (0..3).max_by(|a, b| across_from[*a].abs().total_cmp(&across_from[*b].abs()));
            main.is_some_and(|axis| across_from[axis] < 0.0)
        };
        let (from, to) = if runs_back {
            (other, one)
        } else {
            (one, other)
        };
        Some(PointLine {
            from_m: from.into(),
            to_m: to.into(),
            deflection: deflection(dofs, (to - from).normalize()).into(),
        })
    }
}

/// The direction across a line in which most degrees of freedom are; that of an axis of the frame
/// where they are along the line.
fn deflection(dofs: &BTreeSet<Dof>, line: Vector3) -> Vector3 {
    let axes = dofs.iter().filter_map(|dof| dof.axis().unit_vector());
    let axes: Vec<Vector3> = axes.map(Vector3::from).collect();
    let count = |direction: &Vector3| {
        let alike = axes.iter().filter(|axis| axis.dot(direction).abs() > 0.5);
        alike.count()
    };
    let across = |direction: Vector3| direction - line * direction.dot(&line);
    let frame = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(Vector3::from);
    let lies_across = |direction: &&Vector3| across(**direction).norm() >= MIN_SINE_ACROSS;
    // Of directions with as many degrees of freedom the first of the frame.
    let rank = |direction: &&Vector3| (count(direction), direction[2] > 0.5, direction[1] > 0.5);
    let found = frame.iter().filter(lies_across).max_by_key(rank);
    across(found.copied().unwrap_or(frame[0])).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_is_drafted_along_the_points_and_bends_in_the_direction_of_the_hits() {
        let line = |axis: &str, at: fn(f64) -> [f64; 3]| {
            let mut points = Geometry::default();
            let mut dofs = BTreeSet::new();
            for number in 0..5_u8 {
                let position = at(0.3 * f64::from(number)).into();
                let name = number.to_string();
                points.nodes.push(Node::new(&name, position));
                dofs.insert(format!("{name}:+{axis}").parse().unwrap());
            }
            PointLine::of(&dofs, &points).unwrap()
        };
        let upright = line("X", |s| [0.0, 0.1, 0.2 - s]);
        let is_at = |got: [f64; 3], expected: [f64; 3]| {
            got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(is_at(upright.deflection, [1.0, 0.0, 0.0]));
        assert!(is_at(upright.from_m, [0.0, 0.1, -1.0]) && is_at(upright.to_m, [0.0, 0.1, 0.2]));
        // Hits along the line: it bends across all the same.
        let level = line("X", |s| [s, 0.0, 0.0]);
        assert!(is_at(level.deflection, [0.0, 0.0, 1.0]));
        let draft = ModelDraft::at(Path::new("beam")).unwrap();
        let text = draft.text_along(Some(&upright));
        assert!(text.contains("\nfrom_m = [0.0, 0.1, -1.0]  "), "{text}");
        let ends = "\nto_m = [0.0, 0.1, 0.2]\nends_status = \"assumed\" ";
        assert!(text.contains(ends), "{text}");
        assert!(text.contains("\ndeflection = [1.0, 0.0, 0.0]  "), "{text}");
        assert_eq!(draft.text_along(None), draft.text);
        let loaded = model_of_text(&text, Path::new("model.toml"), &BTreeMap::new()).unwrap();
        assert_eq!(loaded.model.parameters().len(), 1);
        let assumptions = loaded.model.assumptions();
        assert!(assumptions.iter().any(|assumption| assumption.is_guess));
        let stated = text.replace("ends_status = \"assumed\"", "ends_status = \"printed\"");
        let loaded = model_of_text(&stated, Path::new("model.toml"), &BTreeMap::new()).unwrap();
        let assumptions = loaded.model.assumptions();
        assert!(!assumptions.iter().any(|assumption| assumption.is_guess));
    }
    use crate::geometry::Node;
    use crate::theory::ModeOptions;

    #[test]
    fn every_draft_is_a_model_with_modes() {
        for draft in ModelDraft::ALL {
            assert_eq!(ModelDraft::at(Path::new(draft.kind)), Some(draft));
            let loaded = draft.load().unwrap();
            let theory = loaded.solve(&[], &ModeOptions::default()).unwrap();
            let highest = theory.modes.modes.last().unwrap();
            assert!(highest.frequency_hz > 10.0, "{}", draft.kind);
        }
    }
}

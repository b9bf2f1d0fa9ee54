//! Motion of the bodies of a model: displacement and rotation of every point with coordinates, in
//! each mode.

use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::theory::{Coordinate, ModeOptions, Motion, TheoryModes, modes};

use super::super::SceneError;
use super::super::model::LoadedModel;
use super::rounding::rounded;

/// Maximum number of values; a model of more is drawn at the sensors only.
const MAX_NUMBERS: usize = 90_000;

/// Maximum number of coordinates of a sparse model that is solved once more for the figure.
const MAX_SPARSE_COORDINATES: usize = 3000;

/// The modes of a model over its bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TheoryMotion {
    /// Nodes of bodies; a rigid body has one, a beam many.
    pub nodes: Vec<BodyNode>,
    /// Frequencies, Hz, in the order of the theory's modes.
    pub hz: Vec<f64>,
    /// For each mode: x, y, z displacement and rotation about x, y, z of every node, one after the
    /// other; m and rad (m of an arc) for unit modal mass.
    pub modes: Vec<Vec<f64>>,
}

/// A node of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyNode {
    /// Name of the body.
    pub body: String,
    /// Position, m.
    pub at_m: [f64; 3],
    /// Radius of gyration `√(J/m)`, m; `None` where it has no mass or no rotation, and for nodes of
    /// a beam.
    pub radius_m: Option<f64>,
    /// Axes about which it turns.
    pub axes: Vec<[f64; 3]>,
    /// Whether its rotations are arcs at a rim whose radius is not known, m in place of rad.
    #[serde(default)]
    pub arc: bool,
}

/// The motion of a model in a band; `None` for a model with too many coordinates, or without
/// positions.
pub(super) fn theory_motion(
    model: &LoadedModel,
    band: Option<Band>,
) -> Result<Option<TheoryMotion>, SceneError> {
    let sparse = model.model.sparse(&model.values)?;
    if sparse
        .as_ref()
        .is_some_and(|system| system.coordinates.len() > MAX_SPARSE_COORDINATES)
    {
        return Ok(None);
    }
    let options = ModeOptions {
        band,
        ..ModeOptions::default()
    };
    let solved = modes(model.model.as_ref(), &model.values, &[], &options)?;
    let coordinates = &solved.coordinates;
    let positions = body_positions(coordinates);
    let count = positions
        .iter()
        .map(|(_, _, coordinates_there)| coordinates_there.len())
        .sum::<usize>()
        * 6
        * solved.omega_rad_s.len();
    if positions.is_empty() || count > MAX_NUMBERS || have_no_positions(&positions, coordinates) {
        return Ok(None);
    }
    let masses = match sparse {
        Some(_) => None,
        None => Some(model.model.assemble(&model.values)?.mass),
    };
    let mass = |c: usize| masses.as_ref().map(|matrix| matrix[(c, c)]);
    let several = |body: &str| positions.iter().filter(|(name, ..)| *name == body).count() > 1;
    let nodes = positions.iter().map(|(body, at_m, coordinates_there)| {
        let of = |motion: Motion| {
            coordinates_there
                .iter()
                .filter(move |c| coordinates[**c].motion == motion)
        };
        let heaviest = of(Motion::Translation)
            .filter_map(|c| mass(*c))
            .fold(0.0, f64::max);
        let inertia = of(Motion::Rotation)
            .filter_map(|c| mass(*c))
            .fold(0.0, f64::max);
        let radius = (heaviest > 0.0 && inertia > 0.0 && !several(body))
            .then(|| (inertia / heaviest).sqrt());
        let turning = of(Motion::Rotation).chain(of(Motion::Arc));
        BodyNode {
            body: (*body).to_owned(),
            at_m: *at_m,
            radius_m: radius.map(|radius| rounded(radius, 4)),
            axes: if several(body) {
                Vec::new()
            } else {
                turning.map(|c| coordinates[*c].axis).collect()
            },
            arc: of(Motion::Arc).next().is_some(),
        }
    });
    Ok(Some(TheoryMotion {
        nodes: nodes.collect(),
        hz: solved
            .omega_rad_s
            .iter()
            .map(|w| rounded(w / std::f64::consts::TAU, 9))
            .collect(),
        modes: (0..solved.omega_rad_s.len())
            .map(|j| motion(&solved, &positions, j))
            .collect(),
    }))
}

/// Body, position and the indices of the coordinates there, in the order of the model.
type BodyPosition<'a> = (&'a str, [f64; 3], Vec<usize>);

fn body_positions(coordinates: &[Coordinate]) -> Vec<BodyPosition<'_>> {
    let mut all: Vec<BodyPosition> = Vec::new();
    for (index, coordinate) in coordinates.iter().enumerate() {
        let bits = |at: &[f64; 3]| at.map(f64::to_bits);
        let known = all
            .iter_mut()
            .find(|(body, at, _)| *body == coordinate.body && bits(at) == bits(&coordinate.at_m));
        match known {
            Some((_, _, members)) => members.push(index),
            None => all.push((&coordinate.body, coordinate.at_m, vec![index])),
        }
    }
    all
}

/// Whether several bodies coincide, which shows that the model states no positions, unless they
/// rotate about that point.
fn have_no_positions(positions: &[BodyPosition<'_>], coordinates: &[Coordinate]) -> bool {
    let first = positions[0].1;
    let turns = coordinates
        .iter()
        .any(|coordinate| coordinate.motion != Motion::Translation);
    let far = |at: &[f64; 3]| at.iter().zip(&first).any(|(a, b)| (a - b).abs() > 1e-12);
    positions.len() > 1 && !turns && !positions.iter().any(|(_, at, _)| far(at))
}

fn motion(solved: &TheoryModes, positions: &[BodyPosition<'_>], mode: usize) -> Vec<f64> {
    let mut all = Vec::with_capacity(6 * positions.len());
    for (_, _, members) in positions {
        let mut components = [0.0; 6];
        for &c in members {
            let coordinate = &solved.coordinates[c];
            let offset = match coordinate.motion {
                Motion::Translation => 0,
                Motion::Rotation | Motion::Arc => 3,
            };
            for (k, part) in coordinate.axis.iter().enumerate() {
                components[offset + k] += part * solved.vectors[(c, mode)];
            }
        }
        all.extend(components.map(|value| rounded(value, 4)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::LumpedModel;

    /// Two discs; the first turns and moves along y, the second only moves.
    fn discs(at_m: f64) -> LoadedModel {
        let text = format!(
            r#"
[[body]]
name = "disc"
mass_kg = 2.0
inertia_kg_m2 = 0.08
free = ["y", "rz"]
[[body]]
name = "block"
at_m = [{at_m}, 0.0, 0.0]
mass_kg = 1.0
free = ["y"]
[[point]]
name = "rim"
body = "disc"
at_m = [0.1, 0.0, 0.0]
[[point]]
name = "top"
body = "block"
at_m = [{at_m}, 0.0, 0.0]
[[spring]]
name = "link"
from = "rim"
to = "top"
direction = [0.0, 1.0, 0.0]
stiffness_n_per_m = 1e6
"#
        );
        let model = LumpedModel::new(toml::from_str(&text).unwrap()).unwrap();
        LoadedModel {
            model: Box::new(model),
            sensors: Vec::new(),
            values: Vec::new(),
            unused: Vec::new(),
            example_values: false,
        }
    }

    #[test]
    fn a_body_has_the_radius_of_its_inertia_and_moves_as_its_mode() {
        let theory_figure = theory_motion(&discs(0.3), None).unwrap().unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-3 * b.abs().max(1e-9), "{a} {b}");
        assert_eq!(theory_figure.nodes.len(), 2);
        near(theory_figure.nodes[0].radius_m.unwrap(), 0.2);
        assert!(
            theory_figure.nodes[1].radius_m.is_none() && theory_figure.nodes[1].axes.is_empty()
        );
        let [[x, y, z]] = theory_figure.nodes[0].axes[..] else {
            panic!("one axis")
        };
        near(x + y + 1.0, 1.0);
        near(z, 1.0);
        // 1/m + r²/J + 1/m' per unit stiffness: 0.5 + 0.01/0.08 + 1.
        let elastic = theory_figure.hz.len() - 1;
        near(
            theory_figure.hz[elastic],
            (1e6f64 * 1.625).sqrt() / std::f64::consts::TAU,
        );
        let motion = &theory_figure.modes[elastic];
        assert_eq!(motion.len(), 12);
        // Momentum and moment of momentum stay 0: 2 y + y' = 0, 0.08 θ = 0.2 y.
        near(motion[7], -2.0 * motion[1]);
        near(motion[5], 2.0 * motion[1] * 0.1 / 0.08);
    }

    #[test]
    fn bodies_at_one_place_are_not_drawn_unless_one_turns() {
        let coordinate = |body: &str, motion, x| Coordinate {
            name: body.to_owned(),
            body: body.to_owned(),
            motion,
            axis: [0.0, 0.0, 1.0],
            at_m: [x, 0.0, 0.0],
        };
        let is_drawable = |second: Coordinate| {
            let all = [coordinate("a", Motion::Translation, 0.0), second];
            have_no_positions(&body_positions(&all), &all)
        };
        assert!(is_drawable(coordinate("b", Motion::Translation, 0.0)));
        assert!(!is_drawable(coordinate("b", Motion::Translation, 0.1)));
        assert!(!is_drawable(coordinate("b", Motion::Arc, 0.0)));
        assert!(!is_drawable(coordinate("a", Motion::Translation, 0.0)));
    }

    #[test]
    fn modes_outside_the_band_are_omitted() {
        let band = Band::new(1.0, 1e5).unwrap();
        let motion = theory_motion(&discs(0.3), Some(band)).unwrap().unwrap();
        assert_eq!((motion.hz.len(), motion.modes.len()), (1, 1));
    }
}

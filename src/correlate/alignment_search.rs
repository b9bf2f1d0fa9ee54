//! Alignment search finds the frames in which all sensors lie on nodes: a triangle of three sensors
//! is compared with the triangles of nodes, at the ratios of common units of length.

use rayon::prelude::*;

use crate::linalg::Vector3;

use super::nearest::PointTree;
use super::similarity::{Similarity, extent, fit_similarity};

/// Ratios of the units of length of test and theory: metres, millimetres, centimetres, inches and
/// feet.
const UNIT_RATIOS: [f64; 15] = [
    1.0,
    1e-3,
    1e3,
    1e-2,
    1e2,
    0.1,
    10.0,
    0.0254,
    1.0 / 0.0254,
    25.4,
    1.0 / 25.4,
    2.54,
    1.0 / 2.54,
    0.3048,
    1.0 / 0.3048,
];

/// Smallest and largest extent of a test over that of the theory at a ratio of units. Larger than
/// 1.5: only points outside the theory. Smaller than 0.03: a cluster of sensors on a large machine
/// is not found, and at 0 the nodes of a fine mesh fit a test in a wrong unit.
const EXTENT_RATIOS: std::ops::RangeInclusive<f64> = 0.03..=1.5;

/// Maximum distances of sensors from their nodes, in order, over the tolerance: a close fit is
/// preferred to a coarse one.
const LEVELS_OVER_TOLERANCE: [f64; 4] = [0.01, 0.1, 0.3, 1.0];

/// Maximum distance of a sensor from its node over the distance between nodes. Larger, at 0.5:
/// every frame maps each sensor near some node.
const MAX_DISTANCE_OVER_PITCH: f64 = 0.2;

/// Maximum distance of other sensors over that of the triangle: its errors turn the frame.
const MAX_DISTANCE_OVER_LEVEL: f64 = 4.0;

/// Maximum number of triangles that are tried with one node as the first corner. Only a mesh too
/// fine for its tolerance has more.
const MAX_TRIANGLES_OF_NODE: usize = 20_000;

/// Maximum number of nodes whose distances from the nearest other one are compared.
const MAX_NODES_OF_PITCH: usize = 200;

/// Maximum relative difference of a scale from a ratio of units, by errors of positions.
const MAX_DIFFERENCE_OF_UNIT: f64 = 0.02;

/// Whether a scale is a ratio of common units of length.
pub(super) fn is_unit_ratio(scale: f64) -> bool {
    let near = |unit: &f64| (scale / unit - 1.0).abs() <= MAX_DIFFERENCE_OF_UNIT;
    UNIT_RATIOS.iter().any(near)
}

/// Three sensors far apart, and the order in which the others are compared.
struct Base {
    corners: [Vector3; 3],
    /// Whether the third is off the line of the others.
    is_triangle: bool,
}

/// Frames in which each sensor is near a node, of the closest level that has any; empty where none
/// has.
pub(super) fn frames_onto_nodes(
    test: &[Vector3],
    theory: &[Vector3],
    tree: &PointTree,
    tolerance_m: f64,
) -> Vec<Similarity> {
    let base = Base::new(test);
    let largest = MAX_DISTANCE_OVER_PITCH * median_pitch(theory);
    for level in LEVELS_OVER_TOLERANCE {
        let level_m = level * tolerance_m;
        if level_m > largest {
            break;
        }
        let limit = MAX_DISTANCE_OVER_LEVEL * level_m;
        let near = |frame: &Similarity| {
            let distance = |x: &Vector3| tree.distance(frame.position(x).into());
            test.iter().all(|x| distance(x) <= limit)
        };
        for scale in unit_ratios(test, theory) {
            let search = TriangleSearch {
                base: &base,
                scale,
                within_m: 2.0 * level_m,
                theory,
                tree,
            };
            let firsts: Vec<Vec<Similarity>> = theory
                .par_iter()
                .map(|first| search.frames(first).filter(near).collect())
                .collect();
            if firsts.iter().any(|frames| !frames.is_empty()) {
                return firsts.into_iter().flatten().collect();
            }
        }
    }
    Vec::new()
}

/// Median distance of a node from the nearest other one, m; of many nodes of a part of them.
fn median_pitch(theory: &[Vector3]) -> f64 {
    let step = theory.len().div_ceil(MAX_NODES_OF_PITCH);
    let nearest = |at: usize| {
        let others = theory.iter().enumerate().filter(|(other, _)| *other != at);
        let distances = others.map(|(_, p)| (p - theory[at]).norm());
        distances.fold(f64::INFINITY, f64::min)
    };
    let nodes: Vec<usize> = (0..theory.len()).step_by(step.max(1)).collect();
    let mut pitches: Vec<f64> = nodes.into_par_iter().map(nearest).collect();
    pitches.sort_by(f64::total_cmp);
    pitches.get(pitches.len() / 2).copied().unwrap_or(0.0)
}

/// Ratios of units at which the test is about as large as the theory or a part of it.
fn unit_ratios(test: &[Vector3], theory: &[Vector3]) -> Vec<f64> {
    let ratio = extent(test) / extent(theory).max(f64::MIN_POSITIVE);
    let ratios = UNIT_RATIOS.into_iter();
    ratios
        .filter(|unit| EXTENT_RATIOS.contains(&(unit * ratio)))
        .collect()
}

impl Base {
    /// The two sensors farthest apart, as far as the farthest from the first one shows, and the one
    /// farthest from their line.
    fn new(test: &[Vector3]) -> Self {
        let farthest = |of: &dyn Fn(&Vector3) -> f64| {
            let by_distance = |a: &&Vector3, b: &&Vector3| of(a).total_cmp(&of(b));
            test.iter().max_by(by_distance).copied().unwrap_or_default()
        };
        let centre = test.iter().sum::<Vector3>() / test.len().max(1) as f64;
        let first = farthest(&|p| (p - centre).norm());
        let second = farthest(&|p| (p - first).norm());
        let side = second - first;
        let off_line = |p: &Vector3| (p - first).cross(&side).norm() / side.norm();
        let third = farthest(&off_line);
        Self {
            corners: [first, second, third],
            is_triangle: off_line(&third) > 0.02 * side.norm(),
        }
    }
}

/// Triangles of the theory that are as large as that of a base.
struct TriangleSearch<'a> {
    base: &'a Base,
    scale: f64,
    /// Maximum difference of two sides, m.
    within_m: f64,
    theory: &'a [Vector3],
    tree: &'a PointTree,
}

impl TriangleSearch<'_> {
    /// Frames that map the corners of the base onto nodes, the first onto this one.
    fn frames(&self, first: &Vector3) -> impl Iterator<Item = Similarity> + use<'_> {
        let [a, b, c] = self.base.corners;
        let side = |p: &Vector3, q: &Vector3| self.scale * (q - p).norm();
        let (first, theory, within) = (*first, self.theory, self.within_m);
        let ends = |side: f64| {
            let range = side - within..=side + within;
            self.tree.at_distance(first.into(), range)
        };
        let seconds = ends(side(&a, &b));
        let thirds = match self.base.is_triangle && !seconds.is_empty() {
            true => ends(side(&a, &c)),
            false => Vec::new(),
        };
        let (is_triangle, opposite) = (self.base.is_triangle, side(&b, &c));
        let of_second = move |second: usize| {
            let second = theory[second];
            let two = vec![(a, first), (b, second)];
            let fits =
                |third: &&usize| ((theory[**third] - second).norm() - opposite).abs() <= within;
            let three = |third: &usize| [two.clone(), vec![(c, theory[*third])]].concat();
            match is_triangle {
                true => thirds.iter().filter(fits).map(three).collect(),
                false => vec![two],
            }
        };
        let triangles = seconds.into_iter().flat_map(of_second);
        let fits = triangles.take(MAX_TRIANGLES_OF_NODE);
        fits.filter_map(|pairs| fit_similarity(&pairs))
    }
}

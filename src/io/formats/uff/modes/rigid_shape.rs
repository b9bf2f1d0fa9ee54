//! Whether the modes of a file are rigid-body modes, by their shapes.

use std::collections::BTreeMap;

use super::{Measured, RawMode, axes, measured};
use crate::dof::Axis;

/// Rigid-body modes of a body in space.
const MAX_RIGID_MODES: usize = 6;

/// Maximum norm of a shape without its rigid-body part, over that of the shape. Larger than 0.1:
/// the first bending mode of a clamped beam passes (`modes_at_zero_hertz_that_bend_are_damage`).
/// Smaller than 1e-5: shapes printed with five digits do not
/// (`a_file_of_rigid_body_modes_alone_is_not_damage`).
const MAX_ELASTIC_PART: f64 = 1e-2;

/// Minimum norm of a rigid-body motion without the part of those before it, over its norm, for an
/// independent motion: nodes on a line do not show the rotation about it. Larger than 1e-3: the
/// roll of a body 0.2 m wide and 100 m from the origin is none
/// (`rigid_body_modes_far_from_the_origin_are_not_damage`). Smaller than 1e-15: rounding is one.
const MIN_INDEPENDENT_PART: f64 = 1e-6;

/// Whether all modes are rigid-body motions of their nodes, whose positions are known.
pub(in crate::io::formats::uff) fn are_rigid(
    modes: &[RawMode],
    positions: &BTreeMap<i64, [f64; 3]>,
) -> bool {
    let moved = measured(modes.iter());
    modes.len() <= MAX_RIGID_MODES
        && modes
            .iter()
            .all(|mode| is_rigid(mode, &moved, positions).unwrap_or(false))
}

/// Whether a mode is a rigid-body motion; `None` where its nodes do not show it.
fn is_rigid(mode: &RawMode, moved: &Measured, positions: &BTreeMap<i64, [f64; 3]>) -> Option<bool> {
    let axes = axes(mode.definition.per_node);
    let (mut re, mut im) = (Vec::new(), Vec::new());
    let mut motions: [Vec<f64>; 6] = Default::default();
    for (node, row) in mode.nodes.iter().zip(mode.values.chunks_exact(axes.len())) {
        let Some(directions) = moved.directions.get(node) else {
            continue;
        };
        let position = positions.get(node)?;
        for (axis, value) in axes.iter().zip(row) {
            let direction = match axis {
                Axis::X => 0,
                Axis::Y => 1,
                Axis::Z => 2,
                _ => continue,
            };
            if !directions.contains(axis) {
                continue;
            }
            re.push(value.re);
            im.push(value.im);
            for (motion, values) in motions.iter_mut().enumerate() {
                values.push(rigid_motion(motion, *position)[direction]);
            }
        }
    }
    let basis = orthonormal(motions);
    if re.len() <= basis.len() {
        return None;
    }
    let (shape, elastic) = [re, im].iter().fold((0.0, 0.0), |(all, elastic), part| {
        (all + square(part), elastic + square(&without(part, &basis)))
    });
    Some(elastic <= MAX_ELASTIC_PART * MAX_ELASTIC_PART * shape)
}

/// Displacement of a position under a translation (0 to 2) or a rotation (3 to 5).
fn rigid_motion(motion: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match motion {
        0 => [1.0, 0.0, 0.0],
        1 => [0.0, 1.0, 0.0],
        2 => [0.0, 0.0, 1.0],
        3 => [0.0, -z, y],
        4 => [z, 0.0, -x],
        _ => [-y, x, 0.0],
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(values: &[f64]) -> f64 {
    dot(values, values)
}

/// A vector without its part along an orthonormal basis; twice, so that rounding does not stay.
fn without(values: &[f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut rest = values.to_vec();
    for direction in basis.iter().chain(basis) {
        let along = dot(&rest, direction);
        let parts = rest.iter_mut().zip(direction);
        parts.for_each(|(value, part)| *value -= along * part);
    }
    rest
}

/// An orthonormal basis of the vectors.
fn orthonormal(vectors: [Vec<f64>; 6]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for vector in vectors {
        let whole = square(&vector).sqrt();
        let mut rest = without(&vector, &basis);
        let norm = square(&rest).sqrt();
        if norm > MIN_INDEPENDENT_PART * whole {
            rest.iter_mut().for_each(|value| *value /= norm);
            basis.push(rest);
        }
    }
    basis
}

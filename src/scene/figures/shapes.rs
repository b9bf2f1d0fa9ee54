//! Mode shapes on the points of a test, each with the paired shape of the model, and the MAC of all
//! of them.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::correlate::Pairing;
use crate::dof::Dof;
use crate::geometry::{Geometry, Sensor, Target, unit};
use crate::linalg::{Vector3, complex_matrix, least_squares, sort_ascending_by};
use crate::modal::ModeShape;

use super::super::model::Theory;
use super::super::test_result::TestResult;
use super::bodies::TheoryMotion;
use super::rounding::{rounded, to_decimals};

/// Maximum number of modes of the model that are shown at the sensors.
const MAX_MODEL_MODES: usize = 60;
/// Fewest degrees of freedom that are drawn: one alone shows no shape.
const MIN_DOFS: usize = 2;
/// Maximum number of shape values.
const MAX_NUMBERS: usize = 60_000;
/// Maximum number of points of a mesh that is drawn.
const MAX_POINTS: usize = 3000;

/// MAC of every test mode (row) with every theory mode (column).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MacFigure {
    /// Frequencies of the test's modes, Hz.
    pub test_hz: Vec<f64>,
    /// Frequencies of the theory's modes that move at the sensors, Hz.
    pub theory_hz: Vec<f64>,
    /// Their numbers among all its modes, from 1.
    pub theory_modes: Vec<usize>,
    /// Number of theory modes with nodes at all sensors, which are left out.
    pub still: usize,
    /// MAC.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Degrees of freedom it rests on.
    pub dofs: usize,
    /// Pairs: row and column, from 0; of a repeated root all its modes.
    pub pairs: Vec<[usize; 2]>,
}

/// Shapes on points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeFigure {
    /// The points.
    pub points: Vec<ShapePoint>,
    /// Whether no position is known, so that points stand in a row.
    pub in_a_row: bool,
    /// Degrees of freedom that have no position or no direction and are not drawn.
    pub not_drawn: usize,
    /// Lines between points.
    pub lines: Vec<[usize; 2]>,
    /// Readings at the points.
    pub readings: Vec<Reading>,
    /// Shapes of the test.
    pub test: Vec<ShapeValues>,
    /// Shapes of the theory at the same readings.
    pub theory: Vec<ShapeValues>,
    /// Paired model mode of each test mode; `None` for an unmatched one.
    pub partners: Vec<Option<Partner>>,
}

/// A point of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapePoint {
    /// Its name.
    pub name: String,
    /// Position, m.
    pub at_m: [f64; 3],
    /// The body that it is on.
    pub body: Option<String>,
}

/// A displacement that is read at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Its degree of freedom, on the positive axis.
    pub dof: String,
    /// Its point, from 0.
    pub point: usize,
    /// Unit vector along which it is positive.
    pub direction: [f64; 3],
}

/// A shape at the readings; `None` where it has no value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeValues {
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Real parts.
    pub re: Vec<Option<f64>>,
    /// Imaginary parts; empty for a real shape.
    pub im: Vec<f64>,
}

/// The theory's side of a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Partner {
    /// Theory modes, from 0, with the factors (real, imaginary) with which their sum comes nearest
    /// to the test's shape.
    pub modes: Vec<(usize, f64, f64)>,
    /// MAC; with the subspace of a repeated root.
    pub mac: Option<f64>,
    /// Signed frequency error, percent.
    pub error_percent: f64,
}

/// Inputs of a figure of shapes.
pub(super) struct ShapeInputs<'a> {
    pub test: &'a TestResult,
    pub theory: &'a Theory,
    pub pairing: Option<&'a Pairing>,
    pub sensors: &'a [Sensor],
    pub motion: Option<&'a TheoryMotion>,
}

pub(super) fn mac_figure(shown: &ShapeInputs<'_>) -> Option<MacFigure> {
    let pairing = shown.pairing?;
    let theory = &shown.theory.modes.modes;
    let moves = |j: &usize| {
        let paired = pairing.pairs.iter().any(|pair| pair.theory.contains(j));
        paired || pairing.mac.iter().any(|row| row[*j].is_some())
    };
    let columns: Vec<usize> = (0..theory.len()).filter(moves).collect();
    let row = |row: &Vec<Option<f64>>| -> Vec<Option<f64>> {
        let shown = columns.iter().map(|j| row[*j]);
        shown
            .map(|row| row.map(|mac| to_decimals(mac, 3)))
            .collect()
    };
    let mut pairs = Vec::new();
    for pair in &pairing.pairs {
        for partner in &pair.partners {
            let column_indices = pair
                .theory
                .iter()
                .filter_map(|j| columns.iter().position(|column| column == j));
            pairs.extend(column_indices.map(|column| [partner.test, column]));
        }
    }
    let hz = |mode: &crate::modal::Mode| rounded(mode.frequency_hz, 9);
    let any = pairing.mac.iter().flatten().any(Option::is_some);
    any.then(|| MacFigure {
        test_hz: shown.test.modes.modes.iter().map(hz).collect(),
        theory_hz: columns.iter().map(|j| hz(&theory[*j])).collect(),
        theory_modes: columns.iter().map(|j| j + 1).collect(),
        still: theory.len() - columns.len(),
        mac: pairing.mac.iter().map(row).collect(),
        dofs: pairing.map.pairs.len(),
        pairs,
    })
}

/// The shapes of a test; `None` for one without shapes, or with one degree of freedom alone.
pub(super) fn shape_figure(shown: &ShapeInputs<'_>) -> Option<ShapeFigure> {
    let modes = &shown.test.modes.modes;
    let dofs: std::collections::BTreeSet<Dof> = modes
        .iter()
        .flat_map(|mode| {
            mode.shape
                .iter()
                .map(|(dof, _)| dof.positive().with_repeat(1))
        })
        .collect();
    if dofs.len() < MIN_DOFS || dofs.len() * modes.len() > MAX_NUMBERS {
        return None;
    }
    let mut geometry = shown.test.geometry.clone();
    geometry.add(&shown.theory.geometry);
    let known = |dof: &Dof| Some((dof.clone(), reading_position(dof, shown, &geometry)?));
    let mut positions: Vec<(Dof, ReadingPosition)> = dofs.iter().filter_map(known).collect();
    // Points of a model without positions coincide; where its bodies rotate, they are drawn about
    // that point.
    let first = positions.first();
    let same = |a: &ReadingPosition, b: &ReadingPosition| {
        let mut axes = a.at_m.iter().zip(&b.at_m);
        axes.all(|(a, b)| (a - b).abs() < f64::MIN_POSITIVE)
    };
    let one_place =
        first.is_some_and(|(_, position)| positions.iter().all(|(_, p)| same(p, position)));
    let several = first.is_some_and(|(other_dof, _)| {
        positions
            .iter()
            .any(|(d, _)| d.point() != other_dof.point())
    });
    let in_a_row = positions.is_empty() || (several && one_place && shown.motion.is_none());
    if in_a_row {
        positions = positions_in_row(&dofs);
    }
    let mut points: Vec<ShapePoint> = Vec::new();
    let mut readings = Vec::with_capacity(positions.len());
    for (dof, position) in &positions {
        let point = points.iter().position(|point| point.name == dof.point());
        let point = point.unwrap_or_else(|| {
            points.push(ShapePoint {
                name: dof.point().to_owned(),
                at_m: position.at_m.map(|x| rounded(x, 6)),
                body: position.body.clone(),
            });
            points.len() - 1
        });
        readings.push(Reading {
            dof: dof.to_string(),
            point,
            direction: position.direction.map(|x| to_decimals(x, 5)),
        });
    }
    let shown_values = |shape: &ModeShape, hz: f64| shape_values(shape, hz, &positions);
    let lines = drawn_lines(&geometry, &mut points);
    let theory = shown.theory.modes.modes.iter().take(MAX_MODEL_MODES);
    Some(ShapeFigure {
        not_drawn: dofs.len() - positions.len(),
        test: modes
            .iter()
            .map(|mode| shown_values(&mode.shape, mode.frequency_hz))
            .collect(),
        theory: theory
            .map(|mode| shown_values(&mode.shape, mode.frequency_hz))
            .collect(),
        partners: (0..modes.len()).map(|i| partner(shown, i)).collect(),
        points,
        in_a_row,
        lines,
        readings,
    })
}

/// Position and direction of a reading.
struct ReadingPosition {
    at_m: [f64; 3],
    direction: [f64; 3],
    body: Option<String>,
}

/// Position of a reading from the scene's sensor, a coordinate of the model, or the nodes of the
/// files.
fn reading_position(
    dof: &Dof,
    shown: &ShapeInputs<'_>,
    geometry: &Geometry,
) -> Option<ReadingPosition> {
    let same = |sensor: &&Sensor| sensor.dof.positive() == *dof;
    match shown.sensors.iter().find(same).map(|sensor| &sensor.target) {
        Some(Target::BodyPoint {
            body,
            at_m,
            direction,
        }) => {
            let along = unit(*direction).filter(|_| !dof.axis().is_rotation())?;
            Some(ReadingPosition {
                at_m: *at_m,
                direction: along.into(),
                body: Some(body.clone()),
            })
        }
        _ => {
            let along = dof
                .axis()
                .unit_vector()
                .filter(|_| !dof.axis().is_rotation())?;
            let node = geometry.node(dof.point());
            let body = || {
                let mut nodes = shown.motion.iter().flat_map(|motion| &motion.nodes);
                nodes.find(|node| node.body == dof.point())
            };
            let at_m = match node {
                Some(node) => node.at_m.into(),
                None => body()?.at_m,
            };
            let turned = node.and_then(|node| {
                let system = geometry.system(node.displacement_system?)?;
                let axes = system.unit_vectors_at(node.at_m);
                let parts = axes.iter().zip(along).map(|(axis, part)| axis * part);
                Some(parts.sum::<Vector3>().into())
            });
            Some(ReadingPosition {
                at_m,
                direction: turned.unwrap_or(along),
                body: body().map(|node| node.body.clone()),
            })
        }
    }
}

/// Points without positions, in a row at distances of 1 along the first axis in which none moves;
/// scalars move along z.
fn positions_in_row(dofs: &std::collections::BTreeSet<Dof>) -> Vec<(Dof, ReadingPosition)> {
    let mut points: Vec<&str> = dofs.iter().map(Dof::point).collect();
    points.dedup();
    let along = |dof: &Dof| dof.axis().unit_vector().unwrap_or([0.0, 0.0, 1.0]);
    let is_still = |axis: &usize| dofs.iter().all(|dof| along(dof)[*axis] == 0.0);
    let row = (0..3).find(is_still).unwrap_or(0);
    let position = |dof: &Dof| {
        let number = points.iter().position(|name| *name == dof.point())?;
        let mut at_m = [0.0; 3];
        at_m[row] = number as f64;
        let positions = ReadingPosition {
            at_m,
            direction: along(dof),
            body: None,
        };
        (!dof.axis().is_rotation()).then(|| (dof.clone(), positions))
    };
    dofs.iter().filter_map(position).collect()
}

fn shape_values(shape: &ModeShape, hz: f64, positions: &[(Dof, ReadingPosition)]) -> ShapeValues {
    let unit = shape.largest().map_or(1.0, |(_, value)| value.norm());
    let components: Vec<Option<Complex64>> = positions
        .iter()
        .map(|(dof, _)| shape.along_positive(dof))
        .collect();
    let imaginary = |value: &Option<Complex64>| value.map_or(0.0, |v| v.im);
    let real = components
        .iter()
        .all(|value| imaginary(value).abs() <= 1e-6 * unit);
    ShapeValues {
        hz: rounded(hz, 9),
        re: components
            .iter()
            .map(|value| value.map(|v| rounded(v.re, 4)))
            .collect(),
        im: match real {
            true => Vec::new(),
            false => components
                .iter()
                .map(|value| rounded(imaginary(value), 4))
                .collect(),
        },
    }
}

/// Trace lines and edges of elements between points; points that only lines have are added up to a
/// maximum. Without any, points on one line are connected along it.
fn drawn_lines(geometry: &Geometry, points: &mut Vec<ShapePoint>) -> Vec<[usize; 2]> {
    let mut found = Vec::new();
    let mut join = |a: &str, b: &str, points: &mut Vec<ShapePoint>| {
        let ends = [a, b].map(|name| index_of(name, geometry, points));
        if let [Some(a), Some(b)] = ends
            && a != b
        {
            found.push([a.min(b), a.max(b)]);
        }
    };
    for line in &geometry.lines {
        for two in line.points.windows(2) {
            if let [Some(a), Some(b)] = two {
                join(a, b, points);
            }
        }
    }
    for element in &geometry.elements {
        for two in element.points.windows(2) {
            join(&two[0], &two[1], points);
        }
        if let [first, _, .., last] = element.points.as_slice() {
            join(last, first, points);
        }
    }
    found.sort_unstable();
    found.dedup();
    match found.is_empty() {
        true => lines_along_axis(points),
        false => found,
    }
}

fn index_of(name: &str, geometry: &Geometry, points: &mut Vec<ShapePoint>) -> Option<usize> {
    if let Some(known) = points.iter().position(|point| point.name == name) {
        return Some(known);
    }
    let node = geometry.node(name).filter(|_| points.len() < MAX_POINTS)?;
    points.push(ShapePoint {
        name: name.to_owned(),
        at_m: node.at_m.into(),
        body: None,
    });
    Some(points.len() - 1)
}

fn lines_along_axis(points: &[ShapePoint]) -> Vec<[usize; 2]> {
    let at = |i: usize| Vector3::from(points[i].at_m);
    let Some(far) = (1..points.len())
        .max_by(|a, b| (at(*a) - at(0)).norm().total_cmp(&(at(*b) - at(0)).norm()))
    else {
        return Vec::new();
    };
    let along = at(far) - at(0);
    let length = along.norm();
    let distance_from_line =
        |i: usize| (at(i) - at(0)).cross(&along).norm() / length.max(f64::MIN_POSITIVE);
    if length <= 0.0 || (0..points.len()).any(|i| distance_from_line(i) > 1e-6 * length) {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..points.len()).collect();
    let coordinate = |i: usize| (at(i) - at(0)).dot(&along);
    sort_ascending_by(&mut order, |index| coordinate(*index));
    order.windows(2).map(|two| [two[0], two[1]]).collect()
}

/// The modes of the root that a test mode is paired with, with the factors of their best fit to it.
fn partner(shown: &ShapeInputs<'_>, test: usize) -> Option<Partner> {
    let pairing = shown.pairing?;
    let paired = pairing.pairs.iter().find_map(|pair| {
        let partner = pair
            .partners
            .iter()
            .find(|candidate| candidate.test == test)?;
        Some((pair, partner))
    });
    let (pair, partner) = paired?;
    let theory: Vec<&ModeShape> = pair
        .theory
        .iter()
        .map(|j| &shown.theory.modes.modes[*j].shape)
        .collect();
    let shape = &shown.test.modes.modes[test].shape;
    let mut rows: Vec<(Vec<Complex64>, Complex64)> = Vec::new();
    for dofs in &pairing.map.pairs {
        let values: Option<Vec<Complex64>> = theory
            .iter()
            .map(|shape| shape.along_positive(&dofs.theory))
            .collect();
        if let (Some(values), Some(value)) = (values, shape.along_positive(&dofs.test)) {
            rows.push((values, value));
        }
    }
    let count = theory.len();
    let factors =
        match rows.len() >= count && rows.iter().any(|(v, _)| v.iter().any(|v| v.norm() > 0.0)) {
            false => vec![Complex64::ONE; count],
            true => {
                let left = complex_matrix(rows.len(), count, |i, j| rows[i].0[j]);
                let right = complex_matrix(rows.len(), 1, |i, _| rows[i].1);
                let solved = least_squares(&left, &right).ok()?;
                (0..count).map(|j| solved[(j, 0)]).collect()
            }
        };
    let finite = factors.iter().all(|factor| factor.is_finite());
    let modes = pair.theory.iter().zip(factors);
    finite.then(|| Partner {
        modes: modes
            .map(|(j, factor)| (*j, rounded(factor.re, 5), rounded(factor.im, 5)))
            .collect(),
        mac: partner.mac.map(|mac| to_decimals(mac, 4)),
        error_percent: rounded(100.0 * partner.frequency_error, 4),
    })
}

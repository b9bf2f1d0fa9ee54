//! Mass and stiffness matrices of a model give its undamped modes over all coordinates.
//!
//! Rigid-body modes are exactly 0 Hz; repeated roots share a group number; bases and signs are made
//! canonical, so that the same matrices give the same modes on any machine. Nothing here knows what
//! kind of model it solves.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::{self, RealMatrix, sort_ascending_by, sort_descending_by};
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

use super::energy::{StrainShares, kinetic_shares, strain_shares};
use super::repeated_root_basis::{canonicalise, fix_sign};
use super::{Condensation, Coordinate, SystemMatrices, TheoryError};

/// Neighbours closer than this part of their frequency are one repeated root: far above the
/// rounding of a solver (about 1e-10 for a machine of a hundred coordinates), far below what a test
/// can tell apart.
const REPEATED_SPACING: f64 = 1e-6;
/// Part of a frequency within which repeated roots are equal: the accuracy that natural frequencies
/// have. Larger: the closest pair of Wilkinson's matrix of 201 coordinates is off by 1e-8. Smaller:
/// roots of a symmetric machine differ by rounding.
const EQUAL_SPACING: f64 = 1e-9;
/// The same as a multiple of the rounding bound of `omega^2`, where that is larger.
const EQUAL_ROUNDINGS: f64 = 4.0;
/// Rounding bounds of K within which an omega² counts as 0: this many over the number of
/// coordinates, within the range of [`ZERO_RANGE`]. Entries that sum many springs are rounded many
/// times, up to 4 bounds with the 37 coordinates of the cycloid ball drive; those of a mesh are
/// rounded a few times each, and many cancel.
const ZERO_ROUNDINGS: f64 = 150.0;
/// Smaller: the rigid-body modes of free plates are not at 0 (0.11 bounds), nor the rolling balls
/// of the drive. Larger: a bar of 500 elements on a suspension of 0.1 Hz, at 0.34 bounds, is taken
/// for free, and a stiffness that is not semidefinite for one that is.
const ZERO_RANGE: [f64; 2] = [0.25, 4.0];
/// Part of a natural frequency above which the bound of its change by rounding of K is a finding.
const ROUNDING_REPORTED: f64 = 1e-6;
/// Maximum number of further modes that the finding of rounding lists: a line of text.
const MODES_LISTED: usize = 6;

/// Selection of the modes to keep, and their damping.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct ModeOptions {
    /// Keep the modes inside this band; `None` keeps all. Rigid-body modes are at 0 Hz.
    pub band: Option<Band>,
    /// Keep at most this many of them, from the lowest, rigid-body modes counted.
    pub count: Option<usize>,
    /// Damping ratio of every elastic mode. `None`: from the model's damping matrix, or unknown
    /// where it has none.
    pub damping_ratio: Option<f64>,
}

/// Modes of a model: at the sensors as a [`ModalModel`], and over all coordinates.
#[derive(Clone, Debug)]
pub struct TheoryModes {
    /// The modes at the sensors, shapes real and of unit modal mass, on the positive axes of the
    /// sensors.
    pub model: ModalModel,
    /// The same modes over the coordinates, one per column, `phi^T M phi = I`.
    pub vectors: RealMatrix,
    /// Angular frequency of each, rad/s; exactly 0 for rigid-body modes.
    pub omega_rad_s: Vec<f64>,
    /// Number of each among the elastic modes of the model, from 0; `None` for a rigid-body mode.
    pub numbers: Vec<Option<usize>>,
    /// Number of rigid-body modes; these come first.
    pub rigid: usize,
    /// The coordinates, in the order of the rows of `vectors`.
    pub coordinates: Vec<Coordinate>,
    /// Share of the kinetic energy of each coordinate (row) in each mode (column); every column
    /// adds up to 1.
    pub kinetic_shares: RealMatrix,
    /// Distribution of the strain energy by the names of the springs, or of the parts of the
    /// stiffness matrix.
    pub strain_shares: StrainShares,
    /// Static condensation of the motions without mass, which have no mode; `None` where every
    /// motion carries mass, and of a sparse system.
    pub condensation: Option<Arc<Condensation>>,
}

/// Modes of given matrices, with empty shapes: all coordinates are in [`TheoryModes::vectors`].
///
/// `K phi = omega^2 M phi`, solved and checked by [`crate::linalg::symmetric_modes`]. Rounding of
/// the entries of K alone moves each `omega^2` by up to `eps |phi|^T |K| |phi|` (entries without
/// their signs), mostly by far less in a mesh: a mode within four of these bounds of 0, or a
/// quarter of one in a model of 600 coordinates and more, is a rigid-body mode at exactly 0. A
/// suspension below it (0.05 Hz of a bar of 500 elements whose first bending mode is at 148 Hz) is
/// not distinguished from none. Where the bound exceeds a millionth of a natural frequency, a
/// finding states it.
///
/// Neighbours within a millionth of their frequency share a group number and one canonical basis.
/// Those that differ by less than 1e-9 of it, or by what rounding of K may do, have their mean
/// `omega^2`. Damping from a damping matrix is `phi^T C phi / (2 omega)`: exact where the modes
/// uncouple C, else of first order in it.
///
/// Motions without mass are condensed statically, which keeps all finite modes as they are
/// ([`Condensation`]); a finding says how many.
///
/// # Errors
/// [`TheoryError::DampingRatio`], [`TheoryError::Mass`], [`TheoryError::MatrixSize`],
/// [`TheoryError::MatrixEntry`], [`TheoryError::NegativeStiffness`], [`TheoryError::Linalg`].
///
/// # Reference
/// Parlett (1998), The Symmetric Eigenvalue Problem, chapters 4 and 15.
pub fn modes_of_matrices(
    matrices: &SystemMatrices,
    options: &ModeOptions,
) -> Result<TheoryModes, TheoryError> {
    check_arguments(matrices, options)?;
    let condensation = Condensation::of_full(matrices)?;
    let solution = solve(matrices, condensation.as_ref())?;
    if let Some((condensation, c)) = condensation.as_ref().zip(matrices.damping.as_ref()) {
        let (forces, magnitudes) = (c * &solution.vectors, sizes(c) * sizes(&solution.vectors));
        condensation.check_undamped(&forces, &magnitudes, &matrices.coordinates)?;
    }
    let damping = |j: usize| {
        let c = matrices.damping.as_ref()?;
        let forces = c * solution.vectors.subcols(j, 1);
        let energy = dot(solution.vectors.col_as_slice(j), forces.col_as_slice(0));
        Some(energy / (2.0 * solution.omega_rad_s[j]))
    };
    let moved = |vectors: &RealMatrix| &matrices.mass * vectors;
    let mut result = solution.kept(options, &damping, &moved);
    result.strain_shares = strain_shares(&matrices.springs, &result.vectors);
    result.coordinates = matrices.coordinates.clone();
    let finding = condensation.as_ref().map(Condensation::finding);
    result.model.findings.extend(finding);
    result.condensation = condensation.map(Arc::new);
    Ok(result)
}

/// Modes in ascending order, those of repeated roots in their canonical basis.
pub(super) struct Solution {
    pub omega_rad_s: Vec<f64>,
    pub vectors: RealMatrix,
    /// Bound of the change of each omega² by rounding of K, (rad/s)².
    rounding: Vec<f64>,
    rigid: usize,
    groups: Vec<Option<u32>>,
}

impl Solution {
    /// Mass-normalised vectors with their eigenvalues, in any order; `total` is the squared motion
    /// of each coordinate in all modes, or what stands for its scale.
    pub fn arranged(raw: &RealMatrix, eigenvalues: &[Root], total: &[f64]) -> Self {
        let n = eigenvalues.len();
        let value = |j: usize| eigenvalues[j].omega_squared;
        let mut order: Vec<usize> = (0..n).collect();
        sort_ascending_by(&mut order, |&index| value(index));
        let mut vectors = columns(raw, &order);
        let mut omega_squared: Vec<f64> = order.iter().map(|&j| value(j)).collect();
        let roots = repeated_roots(&omega_squared);
        let mut groups = vec![None; n];
        for (number, range) in (1..).zip(roots) {
            let values = &mut omega_squared[range.clone()];
            let bounds = order[range.clone()]
                .iter()
                .map(|&j| eigenvalues[j].rounding);
            let rounding = EQUAL_ROUNDINGS * bounds.fold(0.0, f64::max);
            let equal = |a: &f64, b: &f64| b - a <= rounding.max(2.0 * EQUAL_SPACING * b);
            for equals in values.chunk_by_mut(equal) {
                let mean = equals.iter().sum::<f64>() / equals.len() as f64;
                equals.fill(mean);
            }
            groups[range.clone()].fill(Some(number));
            canonicalise(&mut vectors, range.start, range.len(), total);
        }
        (0..n).for_each(|j| fix_sign(&mut vectors, j));
        Self {
            rigid: omega_squared.partition_point(|&value| value <= 0.0),
            omega_rad_s: omega_squared.iter().map(|value| value.sqrt()).collect(),
            rounding: order.iter().map(|&j| eigenvalues[j].rounding).collect(),
            vectors,
            groups,
        }
    }

    /// The part of the natural frequency that rounding of K may move, `d omega / omega = d omega^2
    /// / (2 omega^2)`, of the modes where it is one to report: the finding is at the mode of the
    /// largest part and lists the others.
    fn rounding_finding(&self, kept: &[usize]) -> Option<Finding> {
        let elastic = kept.iter().filter(|&&j| j >= self.rigid);
        let part = |&j: &usize| {
            let omega = self.omega_rad_s[j];
            (omega / TAU, 0.5 * self.rounding[j] / omega.powi(2))
        };
        let mut moved: Vec<(f64, f64)> = elastic.map(part).collect();
        moved.retain(|(_, part)| *part > ROUNDING_REPORTED);
        sort_descending_by(&mut moved, |mode| mode.1);
        let (&(hz, largest), others) = moved.split_first()?;
        let finding = Finding::new(
            Severity::Warning,
            Code::StiffnessRounding,
            Location::Mode(hz),
        );
        let finding = finding.value(largest, "").limit(ROUNDING_REPORTED);
        let listed = others.iter().take(MODES_LISTED);
        let mut listed: Vec<String> = listed
            .map(|(hz, part)| format!("{part:.1e} at {hz:.4} Hz"))
            .collect();
        if others.len() > MODES_LISTED {
            listed.push(format!("{} more", others.len() - MODES_LISTED));
        }
        Some(if listed.is_empty() {
            finding
        } else {
            finding.detail(format!("also {}", listed.join(", ")))
        })
    }

    /// The modes that the options keep. `damping` gives the ratio of an elastic mode from the
    /// matrices, `moved` is `M Phi`. Coordinates and springs are left to the caller.
    pub fn kept(
        &self,
        options: &ModeOptions,
        damping: &dyn Fn(usize) -> Option<f64>,
        moved: &dyn Fn(&RealMatrix) -> RealMatrix,
    ) -> TheoryModes {
        let frequencies_hz: Vec<f64> = self.omega_rad_s.iter().map(|w| w / TAU).collect();
        let inside = |j: &usize| {
            options
                .band
                .is_none_or(|band| band.contains(frequencies_hz[*j]))
        };
        let kept: Vec<usize> = (0..frequencies_hz.len())
            .filter(inside)
            .take(options.count.unwrap_or(usize::MAX))
            .collect();
        let elastic = |j: usize| j.checked_sub(self.rigid);
        let damping =
            |j: usize| elastic(j).and_then(|_| options.damping_ratio.or_else(|| damping(j)));
        let mode = |&j: &usize| Mode {
            group: self.groups[j],
            modal_mass_kg: Some(1.0),
            method: Some("theory".to_owned()),
            ..Mode::new(
                frequencies_hz[j],
                damping(j),
                ModeShape::default(),
                Scaling::UnitModalMass,
            )
        };
        let vectors = columns(&self.vectors, &kept);
        TheoryModes {
            kinetic_shares: kinetic_shares(&moved(&vectors), &vectors),
            strain_shares: strain_shares(&[], &vectors),
            model: ModalModel {
                producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
                band: options.band,
                modes: kept.iter().map(mode).collect(),
                findings: self.rounding_finding(&kept).into_iter().collect(),
                ..ModalModel::default()
            },
            vectors,
            omega_rad_s: kept.iter().map(|&j| self.omega_rad_s[j]).collect(),
            numbers: kept.iter().map(|&j| elastic(j)).collect(),
            rigid: kept.iter().filter(|&&j| j < self.rigid).count(),
            coordinates: Vec::new(),
            condensation: None,
        }
    }
}

fn solve(
    matrices: &SystemMatrices,
    condensation: Option<&Condensation>,
) -> Result<Solution, TheoryError> {
    let raw = match condensation {
        None => linalg::symmetric_modes(&matrices.stiffness, &matrices.mass)?,
        Some(condensation) => condensation.modes(matrices)?,
    };
    let mut total = row_squares(&raw.vectors);
    // A coordinate without mass is never a pivot, here as in sparse systems: its motion in all
    // modes has no bound.
    let massless = (0..total.len()).filter(|&i| matrices.mass[(i, i)].abs() <= 0.0);
    massless.for_each(|i| total[i] = f64::INFINITY);
    let pairs = raw.omega_squared.iter().zip(raw.rounding);
    let size = raw.vectors.nrows();
    let roots = pairs.map(|(&value, rounding)| Root::new(value, rounding, size));
    let roots = roots.collect::<Result<Vec<_>, _>>()?;
    Ok(Solution::arranged(&raw.vectors, &roots, &total))
}

/// An eigenvalue with the bound of its change by rounding of the stiffness, (rad/s)².
#[derive(Clone, Copy)]
pub(super) struct Root {
    omega_squared: f64,
    rounding: f64,
}

impl Root {
    /// Of a model of so many coordinates; exactly 0 within [`ZERO_ROUNDINGS`] over their number.
    ///
    /// # Errors
    /// [`TheoryError::NegativeStiffness`] for a value below 0 by more than the most of
    /// [`ZERO_RANGE`].
    pub fn new(omega_squared: f64, rounding: f64, size: usize) -> Result<Self, TheoryError> {
        let [least, most] = ZERO_RANGE;
        let limit = most * rounding;
        if omega_squared < -limit {
            return Err(TheoryError::NegativeStiffness {
                got_rad2_s2: omega_squared,
                limit_rad2_s2: limit,
            });
        }
        let zero = rounding * (ZERO_ROUNDINGS / size as f64).clamp(least, most);
        let omega_squared = if omega_squared <= zero {
            0.0
        } else {
            omega_squared
        };
        Ok(Self {
            omega_squared,
            rounding,
        })
    }
}

/// Magnitudes of the entries.
pub(super) fn sizes(of: &RealMatrix) -> RealMatrix {
    linalg::real_matrix(of.nrows(), of.ncols(), |r, c| of[(r, c)].abs())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Runs of two or more neighbours, each within [`REPEATED_SPACING`] of the one before, in ascending
/// order.
fn repeated_roots(omega_squared: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for end in 1..=omega_squared.len() {
        let joined = end < omega_squared.len()
            && omega_squared[end].sqrt() - omega_squared[end - 1].sqrt()
                <= REPEATED_SPACING * omega_squared[end - 1].sqrt();
        if !joined {
            if end - start > 1 {
                runs.push(start..end);
            }
            start = end;
        }
    }
    runs
}

fn row_squares(vectors: &RealMatrix) -> Vec<f64> {
    let square = |i: usize| (0..vectors.ncols()).map(|j| vectors[(i, j)].powi(2)).sum();
    (0..vectors.nrows()).map(square).collect()
}

fn columns(matrix: &RealMatrix, chosen: &[usize]) -> RealMatrix {
    linalg::real_matrix(matrix.nrows(), chosen.len(), |i, j| matrix[(i, chosen[j])])
}

fn check_arguments(matrices: &SystemMatrices, options: &ModeOptions) -> Result<(), TheoryError> {
    if let Some(got) = options.damping_ratio {
        check_damping_ratio(got)?;
    }
    let expected = matrices.coordinates.len();
    check_matrix("mass", &matrices.mass, expected)?;
    check_matrix("stiffness", &matrices.stiffness, expected)?;
    matrices
        .damping
        .as_ref()
        .map_or(Ok(()), |c| check_matrix("damping", c, expected))
}

/// A damping ratio is a fraction from 0 to below 1.
pub(super) fn check_damping_ratio(got: f64) -> Result<(), TheoryError> {
    if (0.0..1.0).contains(&got) {
        Ok(())
    } else {
        Err(TheoryError::DampingRatio { got })
    }
}

fn check_matrix(
    name: &'static str,
    matrix: &RealMatrix,
    expected: usize,
) -> Result<(), TheoryError> {
    let places = (0..expected).flat_map(|row| (0..=row).map(move |column| (row, column)));
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    check_entries(name, expected, rows, columns, places, |i, j| matrix[(i, j)])
}

/// Rows and columns as expected, at least one; the entries of these places finite, each equal to
/// its mirror image up to the rounding of a sum.
pub(super) fn check_entries(
    name: &'static str,
    expected: usize,
    got_rows: usize,
    got_columns: usize,
    places: impl Iterator<Item = (usize, usize)>,
    entry: impl Fn(usize, usize) -> f64,
) -> Result<(), TheoryError> {
    if expected == 0 || got_rows != expected || got_columns != expected {
        return Err(TheoryError::MatrixSize {
            matrix: name,
            got_rows,
            got_columns,
            expected,
        });
    }
    let diagonal: Vec<f64> = (0..expected).map(|i| entry(i, i).abs().sqrt()).collect();
    for (row, column) in places {
        let (got, mirror) = (entry(row, column), entry(column, row));
        // Sums of the same terms in another order differ by a few units in the last place of the
        // largest term.
        let scale = (diagonal[row] * diagonal[column]).max(got.abs());
        let symmetric = (got - mirror).abs() <= 1e-12 * scale;
        if !(got.is_finite() && mirror.is_finite() && symmetric) {
            return Err(TheoryError::MatrixEntry {
                matrix: name,
                row,
                column,
                got,
            });
        }
    }
    Ok(())
}

//! Modes of a viscously damped model with any damping matrix: complex shapes, and the residues they
//! give.
//!
//! Held models only, and only roots that swing: a rigid-body mode or a real root is an error.
//! Shapes are over the model's coordinates; nothing here knows a sensor.

use num_complex::Complex64;

use crate::axis::Band;
use crate::geometry::Sensor;
use crate::linalg::{self, ComplexMatrix, RealMatrix, sort_ascending_by};
use crate::modal::{ModalModel, Mode, ModeShape, Pole, Scaling, modal_phase_collinearity};

use super::sensor_modes::check_sensors;
use super::{
    Coordinate, ModeOptions, SystemMatrices, TheoreticalModel, TheoryError, modes_of_matrices,
};

/// Roots nearer to each other than this part of their size are one: far below what separates roots
/// that differ.
const REPEATED: f64 = 1e-9;
/// Rounding of the solver as a fraction of the highest root, which limits the accuracy of low
/// roots.
const ROUNDING: f64 = 1e-12;

/// Least `|b(q, q)|` over `2 |lambda| |q|^2` of a vector that can be scaled: where two roots meet
/// in one shape it is the root of the rounding, about 1e-8.
const INDEPENDENT: f64 = 1e-6;

/// Complex modes of a damped model.
///
/// Receptance `H(s) = sum_r phi_r phi_r^T / (s - lambda_r) + conj.`, an `n` by `n` matrix.
#[derive(Clone, Debug)]
pub struct DampedModes {
    /// Poles with positive imaginary part, ascending by size, rad/s; roots that are repeated are
    /// equal.
    pub poles_rad_s: Vec<Complex64>,
    /// Vectors over the coordinates, one per column, `phi^T (2 lambda M + C) phi = 1`; free up to
    /// the sign.
    pub vectors: ComplexMatrix,
    /// Modes of one repeated root share a number.
    pub groups: Vec<Option<u32>>,
    /// The coordinates, in the order of the rows of `vectors`.
    pub coordinates: Vec<Coordinate>,
}

impl DampedModes {
    /// Reading of mode `j` by a sensor with the observation row `b`, `b^T phi_j`.
    ///
    /// The residue of a pair is the product of its two readings, m/(N s).
    pub fn reading(&self, row: &[f64], j: usize) -> Complex64 {
        let products = row.iter().enumerate();
        products.map(|(i, b)| *b * self.vectors[(i, j)]).sum()
    }
}

/// Modes of `M x'' + C x' + K x = 0`; a model without a damping matrix counts as undamped. Undamped
/// roots within a millionth of each other count as one ([`modes_of_matrices`]).
///
/// Motions without mass on which no damping force acts follow by statics, with damping as without
/// ([`super::Condensation`]).
///
/// In the coordinates `q` of the undamped modes, `x = Phi q` with `Phi^T M Phi = I`, the state
/// `(Omega q, q')` follows the matrix `[[0, Omega], [-Omega, -Phi^T C Phi]]`, all of whose entries
/// are frequencies. Of each conjugate pair of its roots the one with positive imaginary part is
/// kept. Distinct roots are orthogonal with respect to `b(q, p) = q^T ((lambda_q + lambda_p) I +
/// Phi^T C Phi) p`; vectors of a repeated root are made so.
///
/// # Errors
/// Those of [`modes_of_matrices`]; [`TheoryError::RigidBody`], [`TheoryError::Overdamped`],
/// [`TheoryError::DefectiveRoot`].
///
/// # Reference
/// Foss (1958), Co-ordinates which uncouple the equations of motion of damped linear dynamic
/// systems, J. Appl. Mech. 25; Ewins (2000), Modal Testing, 2nd ed., section 2.6 (general viscous
/// damping).
pub fn damped_modes(matrices: &SystemMatrices) -> Result<DampedModes, TheoryError> {
    let undamped = modes_of_matrices(matrices, &ModeOptions::default())?;
    if undamped.rigid > 0 {
        return Err(TheoryError::RigidBody {
            got: undamped.rigid,
        });
    }
    let omega = &undamped.omega_rad_s;
    let size = undamped.coordinates.len();
    let damping = modal_damping(matrices, &undamped.vectors);
    let roots = roots(omega, &damping)?;
    let mut solution = DampedModes {
        poles_rad_s: Vec::with_capacity(omega.len()),
        vectors: linalg::complex_matrix(size, omega.len(), |_, _| Complex64::ZERO),
        groups: vec![None; omega.len()],
        coordinates: undamped.coordinates,
    };
    for group in &groups(roots) {
        let repeated = group.len() > 1;
        let number = solution.groups.iter().flatten().max().map_or(1, |n| n + 1);
        let lambda = group.iter().map(|root| root.lambda).sum::<Complex64>() / group.len() as f64;
        for q in scaled(group, lambda, &damping)? {
            let j = solution.poles_rad_s.len();
            solution.poles_rad_s.push(lambda);
            solution.groups[j] = repeated.then_some(number);
            for i in 0..size {
                let component = q.iter().enumerate();
                solution.vectors[(i, j)] =
                    component.map(|(k, q)| undamped.vectors[(i, k)] * q).sum();
            }
        }
    }
    Ok(solution)
}

/// Modes of a model with its damping matrix as it is, read by sensors, ascending in frequency,
/// inside the band if one is given.
///
/// Shapes are scaled as those of unit modal mass are: the residue of a pair is `phi_r phi_k/(2 i
/// omega_d)`, so that real ones come out where the damping does not couple the undamped modes. Of
/// the two signs the one that makes the largest component's real part positive.
///
/// # Errors
/// Those of [`TheoreticalModel::assemble`], [`TheoreticalModel::observation_row`] and
/// [`damped_modes`]; [`TheoryError::Undamped`] without a damping matrix.
pub fn damped_model(
    model: &dyn TheoreticalModel,
    values: &[f64],
    sensors: &[Sensor],
    band: Option<Band>,
) -> Result<ModalModel, TheoryError> {
    check_sensors(sensors)?;
    let matrices = model.assemble(values)?;
    if matrices.damping.is_none() {
        return Err(TheoryError::Undamped);
    }
    let rows = sensors
        .iter()
        .map(|sensor| model.observation_row(values, &sensor.target))
        .collect::<Result<Vec<_>, TheoryError>>()?;
    let solved = damped_modes(&matrices)?;
    let mode = |j: usize| {
        let pole = Pole {
            lambda: solved.poles_rad_s[j],
        };
        let scale = Complex64::new(0.0, 2.0 * pole.lambda.im).sqrt();
        let readings: Vec<Complex64> = rows
            .iter()
            .map(|row| scale * solved.reading(row, j))
            .collect();
        let largest = readings.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let sign = largest.map_or(1.0, |value| value.re.signum());
        let values: Vec<Complex64> = readings.iter().map(|value| sign * value).collect();
        let pairs = sensors.iter().zip(&values);
        let shape = ModeShape::new(pairs.map(|(sensor, value)| (sensor.dof.positive(), *value)));
        Mode {
            group: solved.groups[j],
            modal_mass_kg: Some(1.0),
            mpc: modal_phase_collinearity(&values),
            method: Some("theory".to_owned()),
            ..Mode::new(
                pole.natural_frequency_hz(),
                Some(pole.damping_ratio()),
                shape,
                Scaling::UnitModalMass,
            )
        }
    };
    let inside = |mode: &Mode| band.is_none_or(|band| band.contains(mode.frequency_hz));
    Ok(ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        band,
        modes: (0..solved.poles_rad_s.len())
            .map(mode)
            .filter(inside)
            .collect(),
        ..ModalModel::default()
    })
}

/// `Phi^T C Phi`.
fn modal_damping(matrices: &SystemMatrices, vectors: &RealMatrix) -> RealMatrix {
    match &matrices.damping {
        Some(c) => vectors.transpose() * (c * vectors),
        None => linalg::real_matrix(vectors.ncols(), vectors.ncols(), |_, _| 0.0),
    }
}

/// One root with its vector over the undamped modes, of any scale.
#[derive(Clone, Debug)]
struct Root {
    lambda: Complex64,
    q: Vec<Complex64>,
}

/// The roots above the real axis, ascending by size.
fn roots(omega: &[f64], damping: &RealMatrix) -> Result<Vec<Root>, TheoryError> {
    let n = omega.len();
    let state = linalg::real_matrix(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(i == j - n)) * omega[i],
        (false, true) => f64::from(u8::from(i - n == j)) * -omega[j],
        (false, false) => -damping[(i - n, j - n)],
    });
    let solved = linalg::general_modes(&state)?;
    let real = solved.values.iter().filter(|v| v.im.abs() <= 0.0);
    if let Some(slowest) = real.min_by(|a, b| a.norm().total_cmp(&b.norm())) {
        return Err(TheoryError::Overdamped {
            got_rad_s: slowest.re,
        });
    }
    // Both halves of the state hold q; the larger one holds it with more digits.
    let component = |k: usize, column: usize, lambda: Complex64| {
        if omega[k] > lambda.norm() {
            solved.vectors[(k, column)] / omega[k]
        } else {
            solved.vectors[(n + k, column)] / lambda
        }
    };
    let above = solved.values.iter().enumerate().filter(|(_, v)| v.im > 0.0);
    let mut roots: Vec<Root> = above
        .map(|(column, &lambda)| Root {
            lambda,
            q: (0..n).map(|k| component(k, column, lambda)).collect(),
        })
        .collect();
    sort_ascending_by(&mut roots, |root| root.lambda.norm());
    Ok(roots)
}

/// The roots gathered by value, each group where its first root stood. Roots of one size need not
/// be one root: equal oscillators with different dampers all have `|lambda| = omega`, in an order
/// that rounding decides.
fn groups(roots: Vec<Root>) -> Vec<Vec<Root>> {
    let largest = roots.iter().map(|r| r.lambda.norm()).fold(0.0, f64::max);
    let mut groups: Vec<Vec<Root>> = Vec::new();
    for root in roots {
        let limit = (REPEATED * root.lambda.norm()).max(ROUNDING * largest);
        let same = |group: &&mut Vec<Root>| (group[0].lambda - root.lambda).norm() <= limit;
        match groups.iter_mut().find(same) {
            Some(group) => group.push(root),
            None => groups.push(vec![root]),
        }
    }
    groups
}

/// `q^T (2 lambda I + D) p`, without conjugation.
fn form(q: &[Complex64], p: &[Complex64], lambda: Complex64, damping: &RealMatrix) -> Complex64 {
    let row = |i: usize| -> Complex64 {
        let coupled: Complex64 = (0..p.len()).map(|k| damping[(i, k)] * p[k]).sum();
        2.0 * lambda * p[i] + coupled
    };
    q.iter().enumerate().map(|(i, q)| q * row(i)).sum()
}

/// Vectors of one root with `b(q, q) = 1` and, where it is repeated, `b(q, p) = 0`.
///
/// Gram and Schmidt with respect to a form that is not definite: the vector that goes first is the
/// one of largest `|b|` among the remaining vectors and their sums and differences in pairs, one of
/// which is not zero unless the form is.
fn scaled(
    group: &[Root],
    lambda: Complex64,
    damping: &RealMatrix,
) -> Result<Vec<Vec<Complex64>>, TheoryError> {
    let b = |q: &[Complex64], p: &[Complex64]| form(q, p, lambda, damping);
    let share = |q: &[Complex64]| {
        b(q, q).norm() / (2.0 * lambda.norm() * norm_squared(q)).max(f64::MIN_POSITIVE)
    };
    let mut left: Vec<Vec<Complex64>> = group.iter().map(|root| unit(&root.q)).collect();
    let mut done: Vec<Vec<Complex64>> = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let (first, turned) = best(&left, share);
        let got = share(&turned);
        if got < INDEPENDENT {
            return Err(TheoryError::DefectiveRoot {
                frequency_hz: Pole { lambda }.natural_frequency_hz(),
                got,
                expected: INDEPENDENT,
            });
        }
        left.swap_remove(first);
        let scale = b(&turned, &turned).sqrt();
        let vector: Vec<Complex64> = turned.iter().map(|v| v / scale).collect();
        for other in &mut left {
            let part = b(&vector, other);
            let rest: Vec<Complex64> = other
                .iter()
                .zip(&vector)
                .map(|(v, o)| v - part * o)
                .collect();
            *other = unit(&rest);
        }
        done.push(vector);
    }
    Ok(done)
}

/// The vector of largest share among the given ones and their sums and differences, and the number
/// of the one it replaces.
fn best(left: &[Vec<Complex64>], share: impl Fn(&[Complex64]) -> f64) -> (usize, Vec<Complex64>) {
    let mut candidates: Vec<(usize, Vec<Complex64>)> = left.iter().cloned().enumerate().collect();
    for (i, a) in left.iter().enumerate() {
        for b in &left[i + 1..] {
            for sign in [1.0, -1.0] {
                let sum = a.iter().zip(b).map(|(a, b)| a + sign * b).collect();
                candidates.push((i, sum));
            }
        }
    }
    let mut chosen = candidates.swap_remove(0);
    for other in candidates {
        if share(&other.1) > share(&chosen.1) {
            chosen = other;
        }
    }
    chosen
}

fn norm_squared(q: &[Complex64]) -> f64 {
    q.iter().map(Complex64::norm_sqr).sum()
}

fn unit(q: &[Complex64]) -> Vec<Complex64> {
    let norm = norm_squared(q).sqrt().max(f64::MIN_POSITIVE);
    q.iter().map(|v| v / norm).collect()
}

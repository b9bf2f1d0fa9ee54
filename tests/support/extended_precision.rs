//! Lowest eigenvalues of a symmetric pair in twice the working precision, with a proof that none is
//! missing.
//!
//! Numbers are unevaluated sums of two `f64` (32 digits). Inverse iteration with `K + s M = L D
//! L^T` on a block, with Rayleigh-Ritz steps by Jacobi rotations, until the eigenvalues stand
//! still; then the negative entries of D of `K - sigma M` count the eigenvalues below sigma.
//! Nothing is shared with the solvers of the library: start vectors are an argument, and the count
//! does not depend on them.
//!
//! # Reference
//! Dekker (1971), A floating-point technique for extending the available precision, Numer. Math.
//! 18; Parlett (1998), The Symmetric Eigenvalue Problem, chapters 3 and 14.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use modalign::linalg::{LinalgError, RealMatrix, real_matrix, symmetric_modes};

use super::matrix_zoo::Specimen;

/// Unevaluated sum of two numbers, the second below half a unit in the last place of the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Double(pub f64, pub f64);

fn two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    let part = sum - a;
    Double(sum, (a - (sum - part)) + (b - part))
}

fn quick_two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    Double(sum, b - (sum - a))
}

fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

fn two_product(a: f64, b: f64) -> Double {
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Double(product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

impl Double {
    pub const ZERO: Self = Self(0.0, 0.0);

    pub fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self::ZERO;
        }
        let root = self.0.sqrt();
        let rest = self - two_product(root, root);
        quick_two_sum(root, rest.0 / (2.0 * root))
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (s, t) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let s = quick_two_sum(s.0, s.1 + t.0);
        quick_two_sum(s.0, s.1 + t.1)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = two_product(self.0, other.0);
        quick_two_sum(p.0, p.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * first.into();
        let second = rest.0 / other.0;
        let rest = rest - other * second.into();
        quick_two_sum(first, second) + (rest.0 / other.0).into()
    }
}

/// Columns of extended numbers.
type Columns = Vec<Vec<Double>>;

/// A symmetric matrix by the entries of its rows that are not zero.
struct Rows(Vec<Vec<(usize, f64)>>);

impl Rows {
    fn new(a: &RealMatrix) -> Self {
        let row = |i: usize| {
            let entries = (0..a.ncols()).map(|j| (j, a[(i, j)]));
            entries.filter(|(_, value)| *value != 0.0).collect()
        };
        Self((0..a.nrows()).map(row).collect())
    }

    fn times(&self, x: &[Double]) -> Vec<Double> {
        let product = |row: &Vec<(usize, f64)>| {
            row.iter()
                .fold(Double::ZERO, |sum, &(j, a)| sum + x[j] * a.into())
        };
        self.0.iter().map(product).collect()
    }
}

/// `L D L^T` of a symmetric matrix within its envelope.
struct Factor {
    first: Vec<usize>,
    lower: Vec<Vec<Double>>,
    diagonal: Vec<Double>,
}

impl Factor {
    /// Of `K - sigma M`.
    fn new(k: &Rows, m: &Rows, sigma: f64) -> Self {
        let n = k.0.len();
        let lowest = |row: &Vec<(usize, f64)>| row.first().map_or(usize::MAX, |entry| entry.0);
        let first: Vec<usize> = (0..n)
            .map(|i| lowest(&k.0[i]).min(lowest(&m.0[i])).min(i))
            .collect();
        let (mut lower, mut diagonal): (Vec<Vec<Double>>, Vec<Double>) = (Vec::new(), Vec::new());
        for i in 0..n {
            let mut row = vec![Double::ZERO; i + 1 - first[i]];
            for &(j, value) in k.0[i].iter().take_while(|(j, _)| *j <= i) {
                row[j - first[i]] = row[j - first[i]] + value.into();
            }
            for &(j, value) in m.0[i].iter().take_while(|(j, _)| *j <= i) {
                row[j - first[i]] = row[j - first[i]] - two_product(sigma, value);
            }
            // row[j] becomes l_ij d_j, then l_ij.
            for j in first[i]..i {
                let start = first[i].max(first[j]);
                let terms = (start..j).map(|c| row[c - first[i]] * lower[j][c - first[j]]);
                row[j - first[i]] = terms.fold(row[j - first[i]], |sum, term| sum - term);
            }
            let mut pivot = row[i - first[i]];
            for j in first[i]..i {
                let raised = row[j - first[i]];
                row[j - first[i]] = raised / diagonal[j];
                pivot = pivot - raised * row[j - first[i]];
            }
            row.pop();
            lower.push(row);
            diagonal.push(pivot);
        }
        Self {
            first,
            lower,
            diagonal,
        }
    }

    fn negative(&self) -> usize {
        self.diagonal.iter().filter(|pivot| pivot.0 < 0.0).count()
    }

    fn solve(&self, mut x: Vec<Double>) -> Vec<Double> {
        let n = x.len();
        for i in 0..n {
            let terms = self.lower[i].iter().zip(&x[self.first[i]..]);
            x[i] = terms.fold(x[i], |sum, (l, value)| sum - *l * *value);
        }
        x.iter_mut()
            .zip(&self.diagonal)
            .for_each(|(x, pivot)| *x = *x / *pivot);
        for i in (0..n).rev() {
            let value = x[i];
            for (j, l) in (self.first[i]..).zip(&self.lower[i]) {
                x[j] = x[j] - *l * value;
            }
        }
        x
    }
}

fn dot(a: &[Double], b: &[Double]) -> Double {
    a.iter()
        .zip(b)
        .fold(Double::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Orthonormal with respect to the mass.
fn orthonormal(mut block: Columns, m: &Rows) -> Columns {
    for j in 0..block.len() {
        for _ in 0..2 {
            let moved = m.times(&block[j]);
            let along: Vec<Double> = block[..j].iter().map(|other| dot(other, &moved)).collect();
            let (before, rest) = block.split_at_mut(j);
            for (other, c) in before.iter().zip(along) {
                rest[0]
                    .iter_mut()
                    .zip(other)
                    .for_each(|(x, o)| *x = *x - *o * c);
            }
        }
        let norm = dot(&block[j], &m.times(&block[j])).sqrt();
        block[j].iter_mut().for_each(|x| *x = *x / norm);
    }
    block
}

/// Eigenvalues and vectors of a small symmetric matrix by cyclic Jacobi rotations, ascending.
fn jacobi(mut a: Columns) -> (Vec<Double>, Columns) {
    let p = a.len();
    let mut v: Columns = (0..p)
        .map(|j| (0..p).map(|i| f64::from(u8::from(i == j)).into()).collect())
        .collect();
    for _ in 0..30 {
        let mut largest = 0.0_f64;
        for i in 0..p {
            for j in 0..i {
                let size = (a[i][i].0 * a[j][j].0).abs().sqrt().max(f64::MIN_POSITIVE);
                largest = largest.max(a[i][j].0.abs() / size);
                if a[i][j].0.abs() <= 1e-30 * size {
                    continue;
                }
                let theta = (a[j][j] - a[i][i]) / (a[i][j] * 2.0.into());
                let root = (theta * theta + 1.0.into()).sqrt();
                let sum = if theta.0 < 0.0 {
                    theta - root
                } else {
                    theta + root
                };
                let t = Double::from(1.0) / sum;
                let c = Double::from(1.0) / (t * t + 1.0.into()).sqrt();
                rotate(&mut a, &mut v, [i, j], [c, t * c]);
            }
        }
        if largest < 1e-28 {
            break;
        }
    }
    let mut order: Vec<usize> = (0..p).collect();
    order.sort_by(|&i, &j| a[i][i].0.total_cmp(&a[j][j].0));
    let values = order.iter().map(|&i| a[i][i]).collect();
    (values, order.iter().map(|&i| v[i].clone()).collect())
}

fn rotate(a: &mut Columns, v: &mut Columns, [i, j]: [usize; 2], [c, s]: [Double; 2]) {
    for k in 0..a.len() {
        let (x, y) = (a[i][k], a[j][k]);
        (a[i][k], a[j][k]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (v[i][k], v[j][k]);
        (v[i][k], v[j][k]) = (c * x - s * y, s * x + c * y);
    }
    for row in a.iter_mut() {
        let (x, y) = (row[i], row[j]);
        (row[i], row[j]) = (c * x - s * y, s * x + c * y);
    }
}

/// A lowest eigenvalue with the bound of its change by rounding of the entries of K.
pub struct Exact {
    pub omega_squared: f64,
    /// `eps |phi|^T |K| |phi|` of the mass-normalised vector.
    pub rounding: f64,
}

/// As many of the lowest eigenvalues as are separated from the next within the columns of `start`,
/// at least `count` where there is a gap.
///
/// # Panics
/// When the number of eigenvalues below the last one is not that of the inertia.
pub fn lowest(k: &RealMatrix, m: &RealMatrix, start: &RealMatrix, count: usize) -> Vec<Exact> {
    let n = m.nrows();
    let (k, m) = (Rows::new(k), Rows::new(m));
    let ratio = |i: usize| entry(&k, i).abs() / entry(&m, i);
    let shift = 1e-15 * (0..n).map(ratio).fold(0.0, f64::max);
    let factor = Factor::new(&k, &m, -shift);
    let column = |j: usize| (0..n).map(|i| start[(i, j)].into()).collect();
    let mut block = orthonormal((0..start.ncols()).map(column).collect(), &m);
    let mut values: Vec<Double> = Vec::new();
    for _ in 0..8 {
        let image = block.iter().map(|x| factor.solve(m.times(x))).collect();
        let image = orthonormal(image, &m);
        let moved: Columns = image.iter().map(|x| k.times(x)).collect();
        let projected = image
            .iter()
            .map(|x| moved.iter().map(|y| dot(x, y)).collect())
            .collect();
        let (next, turned) = jacobi(projected);
        block = turned.iter().map(|by| combined(&image, by)).collect();
        let change = next.iter().zip(&values).take(count);
        let change = change.map(|(a, b)| (*a - *b).0.abs() / (a.0.abs() + shift));
        let still = !values.is_empty() && change.fold(0.0, f64::max) < 1e-15;
        values = next;
        if still {
            break;
        }
    }
    let gap = |&j: &usize| (values[j] - values[j - 1]).0 > 1e-5 * values[j].0.abs();
    let kept = (count.max(1)..values.len())
        .find(gap)
        .unwrap_or(values.len());
    if kept < values.len() {
        let sigma = 0.5 * (values[kept - 1].0 + values[kept].0);
        assert_eq!(
            Factor::new(&k, &m, sigma).negative(),
            kept,
            "eigenvalues below {sigma:e}"
        );
    }
    (0..kept.min(values.len()))
        .map(|j| exact(&k, &block[j], values[j]))
        .collect()
}

fn entry(a: &Rows, i: usize) -> f64 {
    let found = a.0[i].iter().find(|(j, _)| *j == i);
    found.map_or(0.0, |(_, value)| *value)
}

fn combined(block: &Columns, by: &[Double]) -> Vec<Double> {
    let mut sum = vec![Double::ZERO; block[0].len()];
    for (column, c) in block.iter().zip(by) {
        sum.iter_mut()
            .zip(column)
            .for_each(|(s, x)| *s = *s + *x * *c);
    }
    sum
}

fn exact(k: &Rows, x: &[Double], value: Double) -> Exact {
    let rows = k.0.iter().enumerate();
    let terms =
        rows.flat_map(|(i, row)| row.iter().map(move |&(j, a)| (a * x[i].0 * x[j].0).abs()));
    Exact {
        omega_squared: value.0,
        rounding: f64::EPSILON * terms.sum::<f64>(),
    }
}

/// Lowest frequencies that are compared, elastic ones.
const COMPARED: usize = 30;
/// Error of a natural frequency that is allowed where rounding of K moves it less.
const LIMIT: f64 = 1e-9;
/// Bounds of the change by rounding that are allowed where they are more.
const LIMIT_ROUNDINGS: f64 = 4.0;

/// A specimen solved by the library, beside extended precision.
#[derive(Debug)]
pub struct Compared {
    pub name: String,
    pub size: usize,
    /// Largest relative error of a frequency over its limit, with that error and the bound of
    /// rounding of that frequency.
    pub error_over_limit: f64,
    pub error: f64,
    pub rounding: f64,
    /// Largest omega² of a rigid-body mode over the part of the bound of its rounding within which
    /// it counts as 0.
    pub rigid_over_bound: f64,
    /// Largest entry of `Phi^T M Phi - I`, of the modes compared.
    pub orthogonality: f64,
    /// Largest `|K phi - omega^2 M phi|` over `|omega^2 M phi|` in rows scaled by the mass, of the
    /// highest mode.
    pub residual: f64,
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} coordinates: error {:.1e}",
            self.name, self.size, self.error
        )?;
        write!(f, " with a rounding bound of {:.1e}", self.rounding)?;
        write!(f, ", {:.1e} of the limit", self.error_over_limit)?;
        write!(
            f,
            "; rigid-body modes at {:.1e} of theirs",
            self.rigid_over_bound
        )?;
        write!(f, "; orthogonality {:.1e}", self.orthogonality)?;
        write!(f, "; residual {:.1e}", self.residual)
    }
}

/// Solves a specimen and compares its lowest modes.
pub fn compared(specimen: &Specimen) -> Result<Compared, LinalgError> {
    let (k, m, n) = (&specimen.stiffness, &specimen.mass, specimen.size());
    let modes = symmetric_modes(k, m)?;
    let start = (COMPARED + specimen.rigid + 10).min(n);
    let start = real_matrix(n, start, |i, j| modes.vectors[(i, j)]);
    let count = (COMPARED + specimen.rigid).min(n);
    let exact = lowest(k, m, &start, count);
    let mut row = Compared {
        name: specimen.name.clone(),
        size: n,
        error_over_limit: 0.0,
        error: 0.0,
        rounding: 0.0,
        rigid_over_bound: 0.0,
        orthogonality: 0.0,
        residual: 0.0,
    };
    for (j, exact) in exact.iter().enumerate() {
        let got = modes.omega_squared[j];
        if j < specimen.rigid {
            let zero = (150.0 / n as f64).clamp(0.25, 4.0);
            let over = got.abs() / (zero * modes.rounding[j]);
            row.rigid_over_bound = row.rigid_over_bound.max(over);
            continue;
        }
        // d omega / omega = d omega^2 / (2 omega^2).
        let error = 0.5 * (got / exact.omega_squared - 1.0).abs();
        let rounding = 0.5 * exact.rounding / exact.omega_squared.abs();
        let over = error / LIMIT.max(LIMIT_ROUNDINGS * rounding);
        if over >= row.error_over_limit {
            (row.error_over_limit, row.error, row.rounding) = (over, error, rounding);
        }
    }
    let moved = m * &start;
    let products = start.transpose() * &moved;
    for j in 0..start.ncols() {
        for i in 0..start.ncols() {
            let expected = f64::from(u8::from(i == j));
            row.orthogonality = row.orthogonality.max((products[(i, j)] - expected).abs());
        }
    }
    let last = modes.vectors.subcols(n - 1, 1);
    let (forces, inertia) = (k * last, m * last);
    let omega_squared = modes.omega_squared[n - 1];
    for i in 0..n {
        let difference = (forces[(i, 0)] - omega_squared * inertia[(i, 0)]).abs();
        row.residual = row
            .residual
            .max(difference / (omega_squared * m[(i, i)].sqrt()));
    }
    Ok(row)
}

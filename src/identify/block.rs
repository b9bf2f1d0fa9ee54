//! One step of the maximum likelihood fit of the modes in a window of lines: variable projection.
//!
//! In the window the receptance of function f (output o, input i) is
//! `Σ_j ψ_oj L_ji/(iω − λ_j) + c_f + d_f x + (known terms)`, with known terms for the conjugates and for the modes outside.
//! The noise is circular with variance `s_f² u_k²` (a level per function, a course over the lines that all functions share).
//! What is linear is projected out: constant and slope of every function, which stand for all that is farther away, with one QR
//! that all functions share, then the shapes ψ. What remains depends on λ and L alone, to which Gauss-Newton is applied with the
//! Jacobian of Kaufman (1975). The model is analytic in all unknowns, so that the steps are complex least squares.
//!
//! The first QR takes in `1, x, g_j, g_j'` with `g_j = σ_j/(iω − λ_j)`: the data of all functions are compressed to as many
//! numbers as there are columns, and nothing that a step needs is lost.
//!
//! At the end the matrix of the normal equations is the Fisher information of (λ, L) with all linear unknowns profiled out:
//! its inverse holds the Cramér-Rao bounds, twice the variance of real and imaginary part.
//!
//! References: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10(2); Kaufman (1975), BIT 15; Kay (1993), Fundamentals of
//! Statistical Signal Processing: Estimation Theory, section 15.7.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix};

use super::background::{Background, Outside};
use super::linearised::{Compressed, Linearised, Pattern, Problem, patterns};
use super::noise_profile::Profile;
use super::roots::{Root, in_reach};
use super::sides::Sides;
use super::strength::{Strength, Strengths};

pub(super) use super::linearised::Unknown;

/// Largest step of a pole, in decay rates, and of a participation factor.
const LONGEST_STEP: f64 = 0.5;
/// Damping of the normal equations relative to their diagonal (Marquardt 1963): at first, least and most. The least keeps poles
/// that the data cannot tell apart where they are.
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-10;
const MOST_DAMPING: f64 = 1e6;
/// After a step this short, in decay rates, the next would be its square: what the other blocks changed comes first.
const SMALL: f64 = 1e-2;
/// Rounding of the cost, relative to the energy of the data.
const ROUNDING: f64 = 1e-14;

/// Measured receptances, as the fit sees them.
pub(super) struct Measured<'a> {
    /// Lines, rad/s.
    pub omega: &'a [f64],
    /// Lines × functions, m/N.
    pub values: ComplexMatrix,
    /// Outputs and inputs.
    pub sides: &'a Sides,
    /// What is known of modes outside the lines.
    pub outside: &'a Outside,
}

/// Modes that are fitted together.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Lines of the window.
    pub lines: Range<usize>,
    /// Numbers of the roots in the window, ascending.
    pub members: Vec<usize>,
    /// Places in `members` of those whose poles move.
    pub free: Vec<usize>,
    /// Places in `members` of those that this block decides.
    pub core: Vec<usize>,
}

/// A fitted block.
pub(super) struct Fitted {
    /// Its members with their residues.
    pub members: Vec<Root>,
    /// Unknowns in order.
    pub unknowns: Vec<Unknown>,
    /// Fisher information of the unknowns.
    pub information: ComplexMatrix,
    /// Mean square of what is left over, over that of the noise.
    pub misfit: f64,
    /// How strong the modes of each member are.
    pub strengths: Vec<Strengths>,
    /// The Gauss-Newton step that was not taken, by unknown, poles in decay rates; where no steps were to be taken.
    pub next: Vec<Complex64>,
}

/// Fits a block with so many steps at most; none finds the residues alone.
pub(super) fn fit(
    measured: &Measured,
    roots: &[Root],
    block: &Block,
    (profile, steps): (&Profile, usize),
) -> Fitted {
    let window = Window::new(measured, roots, block, profile);
    let mut members: Vec<Root> = block.members.iter().map(|j| roots[*j].clone()).collect();
    let unknowns = unknowns(&members, &block.free);
    let mut here = window.linearised(&members, &unknowns);
    let mut damping = FIRST_DAMPING;
    let mut taken = 0;
    while taken < steps && damping < MOST_DAMPING {
        let (trial, longest) = moved(&members, &unknowns, &here, damping);
        if !trial.iter().all(|root| in_reach(root.lambda)) {
            damping *= 10.0;
            continue;
        }
        let there = window.linearised(&trial, &unknowns);
        if there.cost <= here.cost + ROUNDING * window.energy {
            (members, here) = (trial, there);
            taken += 1;
            damping = (0.1 * damping).max(LEAST_DAMPING);
            if longest < SMALL {
                break;
            }
        } else {
            damping *= 10.0;
        }
    }
    for (root, residues) in members.iter_mut().zip(here.residues) {
        root.residues = residues;
    }
    for (root, variances) in members.iter_mut().zip(here.residue_variances) {
        root.residue_variances = variances;
    }
    let next = if steps == 0 && !unknowns.is_empty() {
        let step = damped_solution(&here.information, &here.gradient, LEAST_DAMPING);
        (0..unknowns.len()).map(|place| step[(place, 0)]).collect()
    } else {
        Vec::new()
    };
    let misfit = here.cost / window.freedom(&members, &unknowns);
    Fitted {
        misfit,
        next,
        members,
        unknowns,
        information: here.information,
        strengths: here.strength.iter().map(Strength::values).collect(),
    }
}

/// The members after one damped step, and its longest part.
fn moved(
    members: &[Root],
    unknowns: &[Unknown],
    here: &Linearised,
    damping: f64,
) -> (Vec<Root>, f64) {
    let delta = damped_solution(&here.information, &here.gradient, damping);
    let mut moved = members.to_vec();
    let mut longest: f64 = 0.0;
    for (place, unknown) in unknowns.iter().enumerate() {
        let own = delta[(place, 0)];
        let own = own * (LONGEST_STEP / own.norm().max(LONGEST_STEP));
        longest = longest.max(own.norm());
        match *unknown {
            Unknown::Pole(j) => moved[j].lambda += members[j].decay().abs() * own,
            Unknown::Factor(j, part, input) => moved[j].parts[part][input] += own,
        }
    }
    (moved, longest)
}

/// The data of a block: what is known subtracted, over the course of the noise.
struct Window<'a> {
    measured: &'a Measured<'a>,
    profile: &'a Profile,
    omega: &'a [f64],
    background: Background<'a>,
    patterns: Vec<Pattern>,
    /// Lines × functions.
    data: ComplexMatrix,
    /// Of the data, over the noise of each function.
    energy: f64,
}

impl<'a> Window<'a> {
    fn new(measured: &'a Measured, roots: &[Root], block: &Block, profile: &'a Profile) -> Self {
        let omega = &measured.omega[block.lines.clone()];
        let known = known_terms(omega, roots, &block.members);
        let functions = measured.values.ncols();
        let data = linalg::complex_matrix(omega.len(), functions, |k, f| {
            let value = measured.values[(block.lines.start + k, f)] - known[(k, f)];
            value / profile.course[k]
        });
        let energy = |f: usize| {
            let own = data.col(f).iter().map(Complex64::norm_sqr).sum::<f64>();
            own / (profile.level[f] * profile.level[f])
        };
        Self {
            measured,
            profile,
            omega,
            background: Background::new(measured.omega, &block.lines, measured.outside),
            patterns: patterns(measured.sides, profile),
            energy: (0..functions).map(energy).sum(),
            data,
        }
    }

    /// Complex values less complex unknowns, 1 at least.
    fn freedom(&self, members: &[Root], unknowns: &[Unknown]) -> f64 {
        let shapes: usize = members.iter().map(Root::multiplicity).sum();
        let functions = self.measured.values.ncols();
        let fitted = self.background.columns() * functions
            + shapes * self.measured.sides.outputs.len()
            + unknowns.len();
        (self.omega.len() * functions).saturating_sub(fitted).max(1) as f64
    }

    fn linearised(&self, members: &[Root], unknowns: &[Unknown]) -> Linearised {
        let (data, explained) = self.compressed(members, unknowns);
        let columns: Vec<(usize, usize)> = (0..members.len())
            .flat_map(|j| (0..members[j].multiplicity()).map(move |i| (j, i)))
            .collect();
        let of_pattern = |pattern: &Pattern| {
            let problem = Problem {
                data: &data,
                members,
                columns: &columns,
                unknowns,
                pattern,
            };
            problem.linearised()
        };
        let parts: Vec<Linearised> = self.patterns.par_iter().map(of_pattern).collect();
        let functions = self.measured.values.ncols();
        let mut sums = Linearised::none(members, unknowns.len(), functions);
        sums.cost = self.energy - explained;
        for part in parts {
            sums.add(part);
        }
        sums
    }

    /// The data in the coordinates of background, courses and those derivatives that are wanted, and the energy that these
    /// can explain.
    fn compressed(&self, members: &[Root], unknowns: &[Unknown]) -> (Compressed, f64) {
        let (count, lines) = (members.len(), self.omega.len());
        let first = self.background.columns();
        let moving: Vec<usize> = unknowns
            .iter()
            .filter_map(|unknown| match unknown {
                Unknown::Pole(j) => Some(*j),
                Unknown::Factor(..) => None,
            })
            .collect();
        let value = |k: usize, column: usize| {
            let pole = |j: usize| {
                let lambda = members[j].lambda;
                lambda.re.abs() / (Complex64::new(0.0, self.omega[k]) - lambda)
            };
            let value = if column < first {
                self.background.value(column, self.omega, k)
            } else if column < first + count {
                pole(column - first)
            } else {
                let own = pole(moving[column - first - count]);
                own * own
            };
            value / self.profile.course[k]
        };
        let columns = first + count + moving.len();
        let qr = linalg::thin_qr(&linalg::complex_matrix(lines, columns, value));
        let z = linalg::adjoint_product(&qr.q, &self.data);
        let energy = |f: usize| {
            let own = z.col(f).iter().map(Complex64::norm_sqr).sum::<f64>();
            own / (self.profile.level[f] * self.profile.level[f])
        };
        let explained = (0..z.ncols()).map(energy).sum();
        let rows = qr.q.ncols() - first;
        let below = |matrix: &ComplexMatrix, columns: usize, column: &dyn Fn(usize) -> usize| {
            linalg::complex_matrix(rows, columns, |i, j| matrix[(first + i, column(j))])
        };
        let mut courses = linalg::complex_matrix(rows, 2 * count, |_, _| Complex64::ZERO);
        for i in 0..rows {
            for j in 0..count {
                courses[(i, j)] = qr.r[(first + i, first + j)];
            }
            for (place, &j) in moving.iter().enumerate() {
                courses[(i, count + j)] = qr.r[(first + i, first + count + place)];
            }
        }
        let compressed = Compressed {
            z: below(&z, z.ncols(), &|j| j),
            g: below(&qr.r, count, &|j| first + j),
            squares: courses.adjoint() * &courses,
            courses,
        };
        (compressed, explained)
    }
}

fn unknowns(members: &[Root], free: &[usize]) -> Vec<Unknown> {
    let mut unknowns = Vec::new();
    for &j in free {
        unknowns.push(Unknown::Pole(j));
        for part in 0..members[j].multiplicity() {
            let inputs = members[j].free_inputs();
            unknowns.extend(inputs.map(|input| Unknown::Factor(j, part, input)));
        }
    }
    unknowns
}

/// What the other roots and all conjugates put into the window: lines × functions.
fn known_terms(omega: &[f64], roots: &[Root], members: &[usize]) -> ComplexMatrix {
    let outside: Vec<&Root> = (0..roots.len())
        .filter(|j| members.binary_search(j).is_err())
        .map(|j| &roots[j])
        .collect();
    let count = outside.len();
    let of = |place: usize| match place.checked_sub(count) {
        None => (outside[place], false),
        Some(conjugate) => (&roots[conjugate], true),
    };
    let total = count + roots.len();
    let courses = linalg::complex_matrix(omega.len(), total, |k, place| {
        let (root, conjugate) = of(place);
        let lambda = if conjugate {
            root.lambda.conj()
        } else {
            root.lambda
        };
        (Complex64::new(0.0, omega[k]) - lambda).inv()
    });
    let functions = roots.first().map_or(0, |root| root.residues.len());
    let residues = linalg::complex_matrix(total, functions, |place, f| {
        let (root, conjugate) = of(place);
        if conjugate {
            root.residues[f].conj()
        } else {
            root.residues[f]
        }
    });
    courses * residues
}

/// Solution of the normal equations, scaled to a unit diagonal, with a ridge; zero where there is no information.
fn damped_solution(
    information: &ComplexMatrix,
    gradient: &ComplexMatrix,
    damping: f64,
) -> ComplexMatrix {
    let count = information.nrows();
    let scale: Vec<f64> = (0..count)
        .map(|i| information[(i, i)].re.max(f64::MIN_POSITIVE).sqrt().recip())
        .collect();
    let right = linalg::complex_matrix(count, 1, |i, _| gradient[(i, 0)] * scale[i]);
    let mut ridge = damping;
    loop {
        let scaled = linalg::complex_matrix(count, count, |i, j| {
            let own = information[(i, j)] * (scale[i] * scale[j]);
            if i == j { own + ridge } else { own }
        });
        if let Ok(lower) = linalg::cholesky(&scaled) {
            let half = linalg::solve_lower(&lower, &right);
            let solution = linalg::solve_lower_adjoint(&lower, &half);
            return linalg::complex_matrix(count, 1, |i, _| solution[(i, 0)] * scale[i]);
        }
        if ridge > 1.0 {
            return linalg::complex_matrix(count, 1, |_, _| Complex64::ZERO);
        }
        ridge *= 1e3;
    }
}

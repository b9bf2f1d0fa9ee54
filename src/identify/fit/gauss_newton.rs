//! The damped Gauss-Newton iteration moves the poles of one block to the maximum of the likelihood
//! on its range of lines, by variable projection.
//!
//! On these lines the receptance f (output o, input i) is `Σ_j ψ_oj L_ji/(iω − λ_j) + c_f + d_f x +
//! (known terms)`, with known terms for the conjugates and for the poles outside. The noise is
//! circular with variance `s_f² u_k²` (a level per FRF, a profile over the lines common to all
//! FRFs). Linear unknowns are projected out: constant and slope of every FRF, which represent all
//! modes farther away, with one QR common to all FRFs, then the shapes ψ. The remaining problem
//! depends on λ and L alone; Gauss-Newton is applied to it with the Jacobian of Kaufman (1975). The
//! model is analytic in all unknowns, so that the steps are complex least squares.
//!
//! The data of all FRFs are compressed to the coordinates of the functions that poles and
//! out-of-band terms can be ([`compressed_band`](crate::identify::fit::compressed_band)): a step
//! reads no line.
//!
//! At convergence the matrix of the normal equations is the Fisher information of (λ, L) with all
//! linear unknowns profiled out: its inverse holds the Cramér-Rao bounds, twice the variance of
//! real and imaginary part.
//!
//! References: Golub and Pereyra (1973), SIAM J. Numer. Anal. 10(2); Kaufman (1975), BIT 15; Kay
//! (1993), Fundamentals of Statistical Signal Processing: Estimation Theory, section 15.7.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{ModelPole, is_allowed_pole};
use crate::identify::fit::compressed_band::{CompressedBand, CompressedValues, KnownResponse};
use crate::identify::fit::fit_data::FitData;
use crate::identify::fit::mode_strength::{Strength, Strengths};
use crate::identify::fit::shape_covariance::ShapeCovariance;
use crate::identify::fit::shape_solution::BlockShapes;
use crate::identify::fit::variable_projection::{Linearised, Pattern, Problem, patterns};

pub(in crate::identify) use crate::identify::fit::variable_projection::Unknown;

/// Maximum step of a pole, in decay rates, and of a participation factor.
const MAX_STEP_DECAY_RATES: f64 = 0.5;
/// Damping of the normal equations relative to their diagonal (Marquardt 1963): initial, minimum
/// and maximum. The minimum fixes poles that the data cannot separate.
const FIRST_DAMPING: f64 = 1e-3;
const MIN_DAMPING: f64 = 1e-10;
const MAX_DAMPING: f64 = 1e6;
/// Step, in decay rates, below which the next would be its square: the block then waits for the
/// changes by other blocks.
const QUADRATIC_STEP_DECAY_RATES: f64 = 1e-2;
/// Rounding error of the cost, relative to the energy of the data.
const ROUND_OFF_COST: f64 = 1e-14;

/// Poles that are fitted together.
#[derive(Clone, Debug)]
pub(in crate::identify) struct Block {
    /// Lines of the fit.
    pub lines: Range<usize>,
    /// Numbers of the poles on these lines, ascending.
    pub members: Vec<usize>,
    /// Indices in `members` of the poles that are free.
    pub free: Vec<usize>,
    /// Indices in `members` of the poles that this block updates.
    pub core: Vec<usize>,
}

/// A fitted block.
pub(in crate::identify) struct Fitted {
    /// Its members with their residues.
    pub members: Vec<ModelPole>,
    /// Unknowns in order.
    pub unknowns: Vec<Unknown>,
    /// Fisher information of the unknowns.
    pub information: ComplexMatrix,
    /// Reduced chi-square: mean square of the residual over that of the noise.
    pub misfit: f64,
    /// Strength of the modes of each member.
    pub strengths: Vec<Strengths>,
    /// The next Gauss-Newton step, by unknown, poles in decay rates; only for a fit of the residues
    /// alone.
    pub next: Vec<Complex64>,
}

/// Data and poles around a block.
pub(in crate::identify) struct FitContext<'a> {
    pub data: &'a FitData,
    pub frf_matrix: &'a FrfMatrix,
    /// All poles, with their residues.
    pub poles: &'a [ModelPole],
    /// Response of the poles and of the out-of-band terms of all lines, where these are subtracted
    /// first.
    pub known: &'a KnownResponse,
    /// Whether the shapes need standard deviations: all poles have converged.
    pub needs_shape_stds: bool,
}

/// Fits a block with at most `steps` steps; with none, the residues alone. The compressed band is
/// returned as the last step needed it.
pub(in crate::identify) fn fit(
    around: &FitContext,
    block: &Block,
    window: &mut Option<CompressedBand>,
    steps: usize,
) -> Fitted {
    let mut members: Vec<ModelPole> = block
        .members
        .iter()
        .map(|j| around.poles[*j].clone())
        .collect();
    let unknowns = unknowns(&members, &block.free);
    let mut problem = BandProblem::new(around, block, window);
    let mut here = problem.linearised(&members, &unknowns);
    let mut damping = FIRST_DAMPING;
    let mut taken = 0;
    while taken < steps && damping < MAX_DAMPING {
        let (trial, largest) = damped_step(&members, &unknowns, &here, damping);
        if !trial.iter().all(|root| is_allowed_pole(root.lambda)) {
            damping *= 10.0;
            continue;
        }
        let at_trial = problem.linearised(&trial, &unknowns);
        if at_trial.cost <= here.cost + ROUND_OFF_COST * problem.values.energy {
            (members, here) = (trial, at_trial);
            taken += 1;
            damping = (0.1 * damping).max(MIN_DAMPING);
            if largest < QUADRATIC_STEP_DECAY_RATES {
                break;
            }
        } else {
            damping *= 10.0;
        }
    }
    let misfit = here.cost / problem.freedom(&members, &unknowns);
    let shapes = BlockShapes {
        members: &members,
        columns: &columns(&members),
        patterns: &problem.patterns,
        solutions: &here.solutions,
        functions: around.data.frfs.functions(),
    };
    let strengths = shapes.strengths().iter().map(Strength::values).collect();
    let residues = shapes.residues();
    for (root, residues) in members.iter_mut().zip(residues) {
        root.residues = residues.values;
        root.residue_variances = residues.variances;
    }
    if around.needs_shape_stds {
        problem.add_pole_uncertainty(&mut members, &block.core, &here);
    }
    let next = if steps == 0 && !unknowns.is_empty() {
        let step = damped_solution(&here.information, &here.gradient, MIN_DAMPING);
        (0..unknowns.len()).map(|index| step[(index, 0)]).collect()
    } else {
        Vec::new()
    };
    *window = Some(problem.window);
    Fitted {
        misfit,
        next,
        members,
        unknowns,
        information: here.information,
        strengths,
    }
}

/// The members after one damped step, and the largest step of an unknown.
fn damped_step(
    members: &[ModelPole],
    unknowns: &[Unknown],
    here: &Linearised,
    damping: f64,
) -> (Vec<ModelPole>, f64) {
    let delta = damped_solution(&here.information, &here.gradient, damping);
    let mut moved = members.to_vec();
    let mut largest: f64 = 0.0;
    for (index, unknown) in unknowns.iter().enumerate() {
        let step = delta[(index, 0)];
        let step = step * (MAX_STEP_DECAY_RATES / step.norm().max(MAX_STEP_DECAY_RATES));
        largest = largest.max(step.norm());
        match *unknown {
            Unknown::Pole(j) => moved[j].lambda += members[j].decay().abs() * step,
            Unknown::Factor(j, part, input) => moved[j].parts[part][input] += step,
        }
    }
    (moved, largest)
}

/// The problem of a block in its compressed band.
struct BandProblem<'a> {
    around: &'a FitContext<'a>,
    block: &'a Block,
    window: CompressedBand,
    /// Coordinates of the measured values minus all other poles and all conjugates.
    values: CompressedValues,
    patterns: Vec<Pattern>,
}

impl<'a> BandProblem<'a> {
    fn new(around: &'a FitContext, block: &'a Block, window: &mut Option<CompressedBand>) -> Self {
        let poles = evaluated_poles(around, block, None);
        let window = match window.take() {
            Some(mut band) => {
                band.follow(around.data, &poles);
                band
            }
            None => CompressedBand::new(around.data, &block.lines, &poles, block.members.len()),
        };
        Self {
            values: window.without_known_response(around.known, &block.members),
            patterns: patterns(around.frf_matrix, window.profile()),
            around,
            block,
            window,
        }
    }

    /// Number of complex values minus complex unknowns, at least 1.
    fn freedom(&self, members: &[ModelPole], unknowns: &[Unknown]) -> f64 {
        let shapes: usize = members.iter().map(ModelPole::multiplicity).sum();
        let functions = self.around.data.frfs.functions();
        let fitted = self.window.out_of_band_columns() * functions
            + shapes * self.around.frf_matrix.outputs.len()
            + unknowns.len();
        (self.block.lines.len() * functions)
            .saturating_sub(fitted)
            .max(1) as f64
    }

    /// Adds the effect of the errors of the unknowns to the variances of the residues of the core.
    fn add_pole_uncertainty(&self, members: &mut [ModelPole], core: &[usize], here: &Linearised) {
        if here.information.nrows() == 0 {
            return;
        }
        let Some(covariance) = linalg::inverse_hermitian_raised(&here.information) else {
            return;
        };
        let shape_covariance = ShapeCovariance {
            columns: &columns(members),
            patterns: &self.patterns,
            solutions: &here.solutions,
            covariance: &covariance,
        };
        for &j in core {
            let mut variances = std::mem::take(&mut members[j].residue_variances);
            shape_covariance.add_pole_uncertainty(j, &members[j], &mut variances);
            members[j].residue_variances = variances;
        }
    }

    /// Linearises the problem at some poles; the compressed band follows them.
    fn linearised(&mut self, members: &[ModelPole], unknowns: &[Unknown]) -> Linearised {
        let poles = evaluated_poles(self.around, self.block, Some(members));
        if self.window.follow(self.around.data, &poles) {
            let (known, members) = (self.around.known, &self.block.members);
            self.values = self.window.without_known_response(known, members);
        }
        let moving: Vec<usize> = unknowns
            .iter()
            .filter_map(|unknown| match unknown {
                Unknown::Pole(j) => Some(*j),
                Unknown::Factor(..) => None,
            })
            .collect();
        let (data, explained) = self.window.compressed(&self.values, members, &moving);
        let columns = columns(members);
        let linearise = |pattern: &Pattern| {
            let problem = Problem {
                data: &data,
                members,
                columns: &columns,
                unknowns,
                pattern,
            };
            problem.linearised()
        };
        let terms: Vec<Linearised> = self.patterns.par_iter().map(linearise).collect();
        let mut sums = Linearised::none(unknowns.len());
        sums.cost = self.values.energy - explained;
        for term in terms {
            sums.add(term);
        }
        sums
    }
}

/// Member and rank-one term of each column of shapes.
fn columns(members: &[ModelPole]) -> Vec<(usize, usize)> {
    (0..members.len())
        .flat_map(|j| (0..members[j].multiplicity()).map(move |i| (j, i)))
        .collect()
}

fn unknowns(members: &[ModelPole], free: &[usize]) -> Vec<Unknown> {
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

/// The poles that a fit evaluates: all of them, the members of the block where they are now, and
/// the conjugates that are subtracted.
fn evaluated_poles(
    around: &FitContext,
    block: &Block,
    members: Option<&[ModelPole]>,
) -> Vec<Complex64> {
    let mut poles: Vec<Complex64> = around.poles.iter().map(|pole| pole.lambda).collect();
    poles.extend(around.poles.iter().map(|pole| pole.lambda.conj()));
    for (j, member) in block.members.iter().zip(members.into_iter().flatten()) {
        poles[*j] = member.lambda;
    }
    poles
}

/// Solution of the normal equations, scaled to a unit diagonal, with a ridge; zero where there is
/// no information.
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
            let element = information[(i, j)] * (scale[i] * scale[j]);
            if i == j { element + ridge } else { element }
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

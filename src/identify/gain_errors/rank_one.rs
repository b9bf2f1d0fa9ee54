//! Gains of FRFs, common to all modes, with which the residue matrix of each mode has rank one.
//!
//! ```text
//! A_m ≈ G ∘ (ψ_m L_mᵀ)        m = 1 … modes,  G real, outputs × inputs
//! ```
//!
//! Alternating least squares: shapes ψ and participation factors L of each mode for given gains,
//! then the gain of each FRF for given products. Factors of a whole row or column of G belong to ψ
//! or L: the gains of each row and of each column have the weighted geometric mean 1, and most of
//! their signs are positive. From G = 1 the iteration does not reach gains of the other sign.
//! Such signs are therefore searched first: as long as the reversal of one FRF lowers the energy
//! beyond rank one.

use num_complex::Complex64;

use crate::linalg::{self, LinalgError};

/// Alternations, each with so many of the shape and of the participation factors: an unmeasured
/// combination of them converges in ten.
const ALTERNATIONS: usize = 30;
const SHAPE_ALTERNATIONS: usize = 3;
/// The same for given gains.
const SHAPE_ITERATIONS: usize = 10;
/// Weight of a gain of 1, over the mean weight of an FRF, where gains from some modes predict
/// others: FRFs in which all those modes are small determine no gain.
const RIDGE: f64 = 0.03;
/// Maximum number of groups of modes that are left out in turn.
const MAX_FOLDS: usize = 5;
/// Iterations of the means of rows and columns.
const CENTRING_ITERATIONS: usize = 20;
/// Decrease of the energy beyond rank one by the reversal of one FRF, as a fraction, below which
/// no further sign is reversed.
const MIN_SIGN_DECREASE: f64 = 0.1;
/// Mean energy beyond rank one, over that of the residues, below which no sign is searched: an FRF
/// with a part p of the energy leaves up to 4p if its sign is wrong.
const MIN_SIGN_ENERGY: f64 = 1e-3;

/// Residues of one mode: outputs × inputs by rows, of norm 1.
#[derive(Clone, Debug)]
pub(super) struct ModeResidues {
    inputs: usize,
    values: Vec<Complex64>,
    /// Expected energy beyond rank one of their noise.
    noise: f64,
}

/// Gains with what they explain.
pub(super) struct Gains {
    /// Gain by output and input, by rows.
    pub gains: Vec<f64>,
    /// Standard deviation of each, with the energy that remains as noise.
    pub stds: Vec<f64>,
    /// Energy of each mode beyond rank one without gains.
    pub before: Vec<f64>,
    /// The same with signs alone.
    pub with_signs: Vec<f64>,
    /// The same with gains from the other modes.
    pub after: Vec<f64>,
}

/// Shape and participation factors of one mode.
struct RankOne {
    outputs: Vec<Complex64>,
    inputs: Vec<Complex64>,
}

impl ModeResidues {
    /// Residues by rows, with the sum of their variances; `None` where all are zero.
    pub fn new(inputs: usize, values: Vec<Complex64>, variance: f64) -> Option<Self> {
        let norm = values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let outputs = values.len() / inputs;
        let beyond = ((outputs - 1) * (inputs - 1)) as f64 / values.len() as f64;
        (norm > 0.0 && norm.is_finite()).then(|| Self {
            inputs,
            values: values.into_iter().map(|value| value / norm).collect(),
            noise: variance * beyond / (norm * norm),
        })
    }

    /// Energy beyond rank one, over that of the noise.
    ///
    /// # Errors
    /// [`LinalgError`] where singular values do not converge.
    pub fn beyond_rank_one_over_noise(&self) -> Result<f64, LinalgError> {
        Ok(beyond_rank_one(&self.gram(), self.inputs)? / self.noise)
    }

    /// Residue of an FRF by its index in rows.
    pub fn value(&self, index: usize) -> Complex64 {
        self.values[index]
    }

    fn row(&self, output: usize) -> &[Complex64] {
        &self.values[output * self.inputs..][..self.inputs]
    }

    fn outputs(&self) -> usize {
        self.values.len() / self.inputs
    }

    /// `AᴴA`, inputs × inputs by rows.
    fn gram(&self) -> Vec<Complex64> {
        let mut gram = vec![Complex64::ZERO; self.inputs * self.inputs];
        for output in 0..self.outputs() {
            add_product(&mut gram, self.row(output), 1.0);
        }
        gram
    }

    /// The best shape and participation factors for given gains, from previous ones.
    fn refined(&self, gains: &[f64], mut start: RankOne) -> RankOne {
        for _ in 0..SHAPE_ALTERNATIONS {
            let mut by_input = vec![Projection::default(); self.inputs];
            let rows = self
                .values
                .chunks(self.inputs)
                .zip(gains.chunks(self.inputs));
            for (factor, (row, gains)) in start.outputs.iter_mut().zip(rows) {
                let mut by_output = Projection::default();
                for ((value, gain), input) in row.iter().zip(gains).zip(&start.inputs) {
                    by_output.add(value, input * *gain);
                }
                *factor = by_output.factor();
                for ((sum, value), gain) in by_input.iter_mut().zip(row).zip(gains) {
                    sum.add(value, *factor * *gain);
                }
            }
            start.inputs = by_input.iter().map(Projection::factor).collect();
        }
        start
    }

    /// Shape and participation factors for given gains.
    fn fitted(&self, gains: &[f64]) -> RankOne {
        (0..SHAPE_ITERATIONS).fold(self.start(), |start, _| self.refined(gains, start))
    }

    /// Start of the iteration: the participation factors of the strongest output.
    fn start(&self) -> RankOne {
        let energy =
            |output: &usize| -> f64 { self.row(*output).iter().map(Complex64::norm_sqr).sum() };
        let strongest = (0..self.outputs()).max_by(|a, b| energy(a).total_cmp(&energy(b)));
        RankOne {
            outputs: vec![Complex64::ZERO; self.outputs()],
            inputs: self.row(strongest.unwrap_or(0)).to_vec(),
        }
    }

    /// Energy that a rank-one matrix with gains leaves.
    fn remaining(&self, gains: &[f64], rank_one: &RankOne) -> f64 {
        let products = rank_one.products();
        let terms = self.values.iter().zip(gains).zip(products);
        terms
            .map(|((value, gain), product)| (value - gain * product).norm_sqr())
            .sum()
    }
}

impl RankOne {
    /// `ψ_o L_i`, by rows.
    fn products(&self) -> impl Iterator<Item = Complex64> + '_ {
        let row = |output: &'_ Complex64| {
            let output = *output;
            self.inputs.iter().map(move |input| output * input)
        };
        self.outputs.iter().flat_map(row)
    }
}

/// Sums of the least squares solution x of `v ≈ x f`.
#[derive(Clone, Copy, Default)]
struct Projection {
    /// `Σ v conj(f)`.
    along: Complex64,
    /// `Σ|f|²`.
    energy: f64,
}

impl Projection {
    fn add(&mut self, value: &Complex64, factor: Complex64) {
        self.along = self.along + value * factor.conj();
        self.energy += factor.norm_sqr();
    }

    /// x; 0 where f is.
    fn factor(&self) -> Complex64 {
        if self.energy > 0.0 {
            self.along / self.energy
        } else {
            Complex64::ZERO
        }
    }
}

/// Adds `weight rᴴr` of a row r to a Gram matrix.
fn add_product(gram: &mut [Complex64], row: &[Complex64], weight: f64) {
    for (i, a) in row.iter().enumerate() {
        for (j, b) in row.iter().enumerate() {
            gram[i * row.len() + j] += a.conj() * b * weight;
        }
    }
}

/// Gains of the FRFs of some modes, and what those from the other modes explain of each.
///
/// # Errors
/// [`LinalgError`] where singular values do not converge.
pub(super) fn gains(modes: &[ModeResidues]) -> Result<Gains, LinalgError> {
    let functions = modes[0].values.len();
    let mut signs = vec![1.0; functions];
    let before = energies_beyond_rank_one(modes, &signs)?;
    let energy: f64 = before.iter().sum();
    if energy > MIN_SIGN_ENERGY * modes.len() as f64 {
        reverse_signs(modes, &mut signs, energy)?;
    }
    let with_signs = energies_beyond_rank_one(modes, &signs)?;
    let all: Vec<&ModeResidues> = modes.iter().collect();
    let Alternated {
        mut gains,
        weights,
        remaining,
    } = alternate(&all, &signs, 0.0);
    let mut after = vec![0.0; modes.len()];
    let folds = modes.len().min(MAX_FOLDS);
    for fold in 0..folds {
        let others = modes.iter().enumerate().filter(|(m, _)| m % folds != fold);
        let others: Vec<&ModeResidues> = others.map(|(_, mode)| mode).collect();
        let from_others = alternate(&others, &signs, RIDGE);
        for (m, mode) in modes.iter().enumerate().filter(|(m, _)| m % folds == fold) {
            let fitted = mode.fitted(&from_others.gains);
            after[m] = mode.remaining(&from_others.gains, &fitted);
        }
    }
    let independent = functions - functions / modes[0].inputs - modes[0].inputs + 1;
    let variance = remaining / ((2 * modes.len() - 1) * independent) as f64;
    let stds = weights
        .iter()
        .map(|weight| (variance / weight).sqrt())
        .collect();
    centre(&mut gains, &weights, modes[0].inputs);
    Ok(Gains {
        gains,
        stds,
        before,
        with_signs,
        after,
    })
}

/// Gains by alternating least squares.
struct Alternated {
    gains: Vec<f64>,
    /// `Σ_m |ψ_o L_i|²` of each FRF.
    weights: Vec<f64>,
    /// Energy of all modes beyond rank one with these gains.
    remaining: f64,
}

fn alternate(modes: &[&ModeResidues], signs: &[f64], ridge: f64) -> Alternated {
    let functions = signs.len();
    let mut gains = signs.to_vec();
    let mut rank_one: Vec<RankOne> = modes.iter().map(|mode| mode.start()).collect();
    let mut weights = vec![0.0; functions];
    let ridge = ridge * modes.len() as f64 / functions as f64;
    for _ in 0..ALTERNATIONS {
        let pairs = modes.iter().zip(rank_one);
        rank_one = pairs
            .map(|(mode, start)| mode.refined(&gains, start))
            .collect();
        let mut along = vec![0.0; functions];
        weights.fill(0.0);
        for (mode, factors) in modes.iter().zip(&rank_one) {
            for (f, (value, product)) in mode.values.iter().zip(factors.products()).enumerate() {
                along[f] += (value * product.conj()).re;
                weights[f] += product.norm_sqr();
            }
        }
        for f in 0..functions {
            if weights[f] + ridge > 0.0 {
                gains[f] = (along[f] + ridge * signs[f]) / (weights[f] + ridge);
            }
        }
    }
    let pairs = modes.iter().zip(&rank_one);
    let remaining = pairs
        .map(|(mode, factors)| mode.remaining(&gains, factors))
        .sum();
    Alternated {
        gains,
        weights,
        remaining,
    }
}

/// Energy of each mode beyond rank one with the signs of some FRFs reversed.
fn energies_beyond_rank_one(
    modes: &[ModeResidues],
    signs: &[f64],
) -> Result<Vec<f64>, LinalgError> {
    let energy = |mode: &ModeResidues| {
        let mut signed = mode.clone();
        signed
            .values
            .iter_mut()
            .zip(signs)
            .for_each(|(value, sign)| *value *= *sign);
        beyond_rank_one(&signed.gram(), mode.inputs)
    };
    modes.iter().map(energy).collect()
}

/// `tr G − λ_max` of a Gram matrix.
fn beyond_rank_one(gram: &[Complex64], inputs: usize) -> Result<f64, LinalgError> {
    let matrix = linalg::complex_matrix(inputs, inputs, |i, j| gram[i * inputs + j]);
    Ok(linalg::singular_values(&matrix)?.iter().skip(1).sum())
}

/// Reverses the sign of the FRF whose reversal lowers the energy most, as long as it does.
fn reverse_signs(
    modes: &[ModeResidues],
    signs: &mut [f64],
    mut energy: f64,
) -> Result<(), LinalgError> {
    let inputs = modes[0].inputs;
    loop {
        let mut best: Option<(f64, usize)> = None;
        let signed: Vec<ModeResidues> = modes
            .iter()
            .map(|mode| {
                let mut signed = mode.clone();
                signed
                    .values
                    .iter_mut()
                    .zip(&*signs)
                    .for_each(|(value, sign)| *value *= *sign);
                signed
            })
            .collect();
        let grams: Vec<Vec<Complex64>> = signed.iter().map(ModeResidues::gram).collect();
        for f in 0..signs.len() {
            let mut sum = 0.0;
            for (mode, gram) in signed.iter().zip(&grams) {
                let (mut gram, row) = (gram.clone(), mode.row(f / inputs));
                let mut reversed = row.to_vec();
                reversed[f % inputs] *= -1.0;
                add_product(&mut gram, row, -1.0);
                add_product(&mut gram, &reversed, 1.0);
                sum += beyond_rank_one(&gram, inputs)?;
            }
            if best.is_none_or(|(least, _)| sum < least) {
                best = Some((sum, f));
            }
        }
        match best {
            Some((sum, f)) if sum < (1.0 - MIN_SIGN_DECREASE) * energy => {
                signs[f] *= -1.0;
                energy = sum;
            }
            _ => return Ok(()),
        }
    }
}

/// Divides the gains by factors of whole rows and columns: their weighted geometric means become
/// 1, and most of their signs positive.
fn centre(gains: &mut [f64], weights: &[f64], inputs: usize) {
    let outputs = gains.len() / inputs;
    let rows: Vec<Vec<usize>> = (0..outputs)
        .map(|o| (o * inputs..(o + 1) * inputs).collect())
        .collect();
    let columns: Vec<Vec<usize>> = (0..inputs)
        .map(|i| (i..gains.len()).step_by(inputs).collect())
        .collect();
    let groups: Vec<&Vec<usize>> = rows.iter().chain(&columns).collect();
    for _ in 0..CENTRING_ITERATIONS {
        for group in &groups {
            let weight: f64 = group.iter().map(|f| weights[*f]).sum();
            let log = |f: &usize| weights[*f] * gains[*f].abs().max(f64::MIN_POSITIVE).ln();
            let mean = group.iter().map(log).sum::<f64>() / weight;
            let majority: f64 = group.iter().map(|f| gains[*f].signum()).sum();
            let sign = if majority < 0.0 { -1.0 } else { 1.0 };
            if weight > 0.0 {
                group.iter().for_each(|f| gains[*f] *= sign * (-mean).exp());
            }
        }
    }
}

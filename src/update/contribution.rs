//! Contributions are what each configuration of an update says about the shared parameters, and
//! whether it contradicts the others.
//!
//! With the rows `J_c` of the sensitivity that belong to a configuration, it alone knows the
//! parameters with the covariance `(J_c^T J_c + I)^-1`, all together with `(sum J_c^T J_c +
//! I)^-1`. A contradiction is a shared parameter that has another value in one configuration than
//! in the others. Its column `a` is that of the parameter with zeros outside the rows of the
//! configuration; with `P` the projector on what the parameters leave, freeing it lowers the
//! objective by about `(a^T P r)^2/(a^T P a)`. The largest decrease is solved for, and tested
//! against the residuals that remain.
//!
//! # Reference
//! Chow (1960), Tests of equality between sets of coefficients in two linear regressions,
//! Econometrica 28, 591; Rao (1948), Large sample tests of statistical hypotheses concerning
//! several parameters, Proc. Cambridge Philosophical Society 44, 50 (score test).

use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::linalg::{RealMatrix, real_matrix};

use super::configuration::Part;
use super::evaluate::max_chi_square;
use super::identifiability::Identifiability;
use super::trust_region::{Solution, solve_from};
use super::{Evaluation, UpdateError, UpdateProblem};

/// Probability that configurations of right models are named as contradicting each other.
///
/// Larger (0.1): a contradiction is invented in 14 of 200 draws in place of 1. Smaller (0.001): of
/// 67 differences below six of their deviations 18 are named in place of 29. Test:
/// `contradictions_between_configurations_are_named_and_none_is_invented` of the population.
const CONTRADICTION_PROBABILITY: f64 = 0.01;
/// Smallest part of the sum of squares of a column that the parameters leave: below it is rounding,
/// as of a parameter that no other configuration determines.
const MIN_PART_LEFT: f64 = 1e-9;

/// What one configuration contributes to an update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contribution {
    /// Name of the configuration.
    pub configuration: String,
    /// Its tests.
    pub tests: Vec<String>,
    /// Number of its measured roots that are paired.
    pub paired: usize,
    /// Number of its residuals.
    pub residuals: usize,
    /// `sum r^2` of these, with the stated deviations.
    pub chi_square: f64,
    /// Posterior standard deviation of each free parameter from this configuration and the prior
    /// alone, in its unit; `None` for a parameter that it does not have.
    pub std_alone: Vec<Option<f64>>,
}

/// A shared parameter that has another value in one configuration than in the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contradiction {
    /// Name of the configuration.
    pub configuration: String,
    /// Name of the parameter.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Its value there, where it is free apart from the others.
    pub there: f64,
    /// Its value in the others then.
    pub elsewhere: f64,
    /// Decrease of chi-square of the data.
    pub decrease: f64,
    /// Chi-square of the data before.
    pub chi_square: f64,
    /// Whether noise explains what remains.
    pub explains: bool,
    /// Probability of a larger decrease where the configurations agree.
    pub probability: f64,
}

/// What each configuration contributes to the parameters at a solution: `data` are the derivatives
/// of the data's residuals with the deviations that the residuals support, `at` has the stated
/// ones; `widen` gives the posterior over prior deviation of a parameter as it is reported.
pub(super) fn contributions(
    problem: &UpdateProblem<'_>,
    at: &Evaluation,
    data: &RealMatrix,
    widen: impl Fn(usize, f64) -> f64,
) -> Result<Vec<Contribution>, UpdateError> {
    if problem.parts.len() < 2 {
        return Ok(Vec::new());
    }
    let owners = problem.configurations_of_rows(at);
    let of_part = |(c, part): (usize, &Part<'_>)| {
        let rows: Vec<usize> = (0..owners.len()).filter(|&row| owners[row] == c).collect();
        let alone = real_matrix(rows.len(), data.ncols(), |i, j| data[(rows[i], j)]);
        let alone = Identifiability::new(&alone, &problem.free)?;
        let std = |(j, z): (usize, &f64)| {
            let parameter = &problem.free[j];
            let slope = parameter.slope(parameter.value(*z));
            part.has(j).then(|| slope * widen(j, alone.ratio[j]))
        };
        let pairs = at.root_pairs.iter();
        let pairs = pairs.filter(|root_pair| root_pair.configuration == c);
        Ok(Contribution {
            configuration: part.name.clone(),
            tests: problem.reversed[part.tests.clone()]
                .iter()
                .map(|reversed| reversed.test.clone())
                .collect(),
            paired: pairs.map(|root_pair| root_pair.targets.len()).sum(),
            residuals: rows.len(),
            chi_square: rows.iter().map(|&row| at.residual[row].powi(2)).sum(),
            std_alone: at.z.iter().enumerate().map(std).collect(),
        })
    };
    problem.parts.iter().enumerate().map(of_part).collect()
}

/// The shared parameter that contradicts most, where one does.
pub(super) fn contradiction(
    problem: &UpdateProblem<'_>,
    solution: &Solution,
) -> Result<Option<Contradiction>, UpdateError> {
    let candidates = candidates(problem);
    // Lines of FRFs share errors of whole functions, and are no independent evidence.
    if candidates.is_empty() || problem.compares_frfs {
        return Ok(None);
    }
    let at = &solution.at;
    let owners = problem.configurations_of_rows(at);
    let remaining = Remaining::new(&solution.jacobian)?;
    let decrease = |&(c, j): &(usize, usize)| {
        let rows = solution.jacobian.nrows();
        let is_there = |row: usize| owners.get(row) == Some(&c);
        let column = (0..rows).map(|row| match is_there(row) {
            true => solution.jacobian[(row, j)],
            false => 0.0,
        });
        remaining.decrease(&column.collect::<Vec<_>>(), &at.residual)
    };
    let largest = candidates
        .iter()
        .map(|candidate| (*candidate, decrease(candidate)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let Some(((c, j), _)) = largest else {
        return Ok(None);
    };
    let separate = problem.with_separate(c, j);
    let mut z = at.z.clone();
    z.push(at.z[j]);
    let start = separate.at_root_pairs(&z, at.root_pairs.clone())?;
    let found = match solve_from(&separate, start) {
        Ok(found) => found.at,
        Err(UpdateError::Theory(_) | UpdateError::Derivative { .. }) => return Ok(None),
        Err(error) => return Err(error),
    };
    let decrease = at.chi_square() - found.chi_square();
    let nu = problem.data_count(&found).saturating_sub(z.len());
    let pairs = found.root_pairs.len().saturating_sub(z.len());
    let probability = probability(decrease, &found, [nu as f64, pairs as f64]);
    let probability = (probability * candidates.len() as f64).min(1.0);
    let value = |place: usize| separate.free[place].value(found.z[place]);
    let parameter = &problem.free[j];
    Ok(
        (probability < CONTRADICTION_PROBABILITY).then(|| Contradiction {
            configuration: problem.parts[c].name.clone(),
            parameter: parameter.name.clone(),
            unit: parameter.unit.clone(),
            there: value(z.len() - 1),
            elsewhere: value(j),
            decrease,
            chi_square: at.chi_square(),
            explains: found.chi_square() <= max_chi_square((nu as f64).max(1.0)),
            probability,
        }),
    )
}

/// Each parameter of a configuration that others with tests share, with the configuration.
fn candidates(problem: &UpdateProblem<'_>) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for j in 0..problem.free.len() {
        let has = |c: &usize| problem.parts[*c].has(j) && !problem.parts[*c].tests.is_empty();
        let sharing: Vec<usize> = (0..problem.parts.len()).filter(has).collect();
        // Of two configurations the later one is named: a difference has no side.
        let named = match sharing.as_slice() {
            [_, last] => vec![*last],
            [_] | [] => Vec::new(),
            _ => sharing,
        };
        all.extend(named.into_iter().map(|c| (c, j)));
    }
    all
}

/// Probability of a larger decrease by one more parameter: of residuals that noise explains, by
/// their stated deviations; else by the deviations that the residuals show, with the degrees of
/// freedom of root pairs, whose residuals have one cause.
fn probability(decrease: f64, after: &Evaluation, [nu, pairs]: [f64; 2]) -> f64 {
    let decrease = decrease.max(0.0);
    let chi_square = after.chi_square();
    if nu >= 1.0 && chi_square > max_chi_square(nu) {
        let ratio = decrease / (chi_square / nu);
        return FisherSnedecor::new(1.0, pairs.max(1.0)).map_or(1.0, |f| f.sf(ratio));
    }
    ChiSquared::new(1.0).map_or(1.0, |chi| chi.sf(decrease))
}

/// What the free parameters leave of a column.
struct Remaining<'a> {
    jacobian: &'a RealMatrix,
    covariance: RealMatrix,
}

impl<'a> Remaining<'a> {
    fn new(jacobian: &'a RealMatrix) -> Result<Self, UpdateError> {
        let covariance = super::model_error::inverse(&(jacobian.transpose() * jacobian))?;
        Ok(Self {
            jacobian,
            covariance,
        })
    }

    /// `(a^T P r)^2/(a^T P a)`, where `r` is what the parameters leave of the data.
    fn decrease(&self, a: &[f64], r: &[f64]) -> f64 {
        let n = self.jacobian.ncols();
        let with = |j: usize, v: &[f64]| -> f64 {
            (0..v.len())
                .map(|row| self.jacobian[(row, j)] * v[row])
                .sum()
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let of_a: Vec<f64> = (0..n).map(|j| with(j, a)).collect();
        let of_r: Vec<f64> = (0..n).map(|j| with(j, r)).collect();
        let through = |left: &[f64], right: &[f64]| -> f64 {
            let row = |i: usize| {
                (0..n)
                    .map(|j| self.covariance[(i, j)] * right[j])
                    .sum::<f64>()
            };
            (0..n).map(|i| left[i] * row(i)).sum()
        };
        let whole = dot(a, a);
        let left = whole - through(&of_a, &of_a);
        let product = dot(a, r) - through(&of_a, &of_r);
        match left > MIN_PART_LEFT * whole {
            true => product * product / left,
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_decrease_is_that_of_a_linear_fit_with_one_more_column() {
        let columns = [
            [1.0, 0.4, -0.3, 0.8, 0.1],
            [0.2, -1.0, 0.5, 0.6, 0.9],
            [0.0, 0.0, 0.7, -0.4, 1.1],
        ];
        let data = [0.3, -0.8, 1.2, 0.5, -0.6];
        // What Gram-Schmidt leaves of the data, column by column.
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let without = |a: &[f64], unit: &[f64]| -> Vec<f64> {
            let part = dot(a, unit);
            a.iter().zip(unit).map(|(a, u)| a - part * u).collect()
        };
        let mut units: Vec<Vec<f64>> = Vec::new();
        let mut left = vec![data.to_vec()];
        for column in columns {
            let rest = units
                .iter()
                .fold(column.to_vec(), |rest, u| without(&rest, u));
            let length = dot(&rest, &rest).sqrt();
            units.push(rest.iter().map(|x| x / length).collect());
            let next = without(left.last().unwrap(), units.last().unwrap());
            left.push(next);
        }
        let squares = |k: usize| dot(&left[k], &left[k]);
        let jacobian = real_matrix(5, 2, |i, j| columns[j][i]);
        let remaining = Remaining::new(&jacobian).unwrap();
        let decrease = remaining.decrease(&columns[2], &left[2]);
        let expected = squares(2) - squares(3);
        assert!(
            (decrease / expected - 1.0).abs() < 1e-12,
            "{decrease} {expected}"
        );
        // A column that the parameters have leaves nothing.
        assert!(remaining.decrease(&columns[0], &left[2]) <= 0.0);
    }
}

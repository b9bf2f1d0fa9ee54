//! Subset selection ranks parameters that explain the misfit, freed alone, in pairs and in growing
//! sets, and checks the proposed set by prediction of modes that were left out.
//!
//! Every trial solves the problem with some parameters free and all others where they are. It is a
//! fit to the data alone: values that explain a misfit can lie far outside the prior, and BIC is
//! defined at the maximum of the likelihood. The prior's rows weigh a thousandth, which pulls a
//! parameter that the data know by a millionth, and leaves one that they do not know where it was.
//! Its remaining error is `chi^2 = sum r^2` of the data; trials of different size are compared by
//! `BIC = chi^2 + k ln N` with `k` free parameters and `N` residuals, the deviations being taken as
//! known.
//!
//! # Reference
//! Schwarz (1978), Estimating the dimension of a model, Annals of Statistics 6, 461.

use rayon::prelude::*;

use super::evaluate::max_chi_square;
use super::result::{Fit, fit};
use super::solve::solve_from_starts;
use super::trust_region::Solution;
use super::{UpdateError, UpdateProblem};
use crate::linalg::sort_ascending_by;

/// Pairs are tried among this many of the best single parameters.
const PAIRED_PARAMETERS: usize = 8;
/// Weight of the prior's rows in trials.
const PRIOR_WEIGHT: f64 = 1e-3;
/// Largest number of parameters in a set.
const MAX_SUBSET_SIZE: usize = 6;

/// The fit of a subset of the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SubsetFit {
    /// Names of the freed parameters, without those that are always free.
    pub parameters: Vec<String>,
    /// Their values after the fit.
    pub values: Vec<f64>,
    /// All parameters of the model.
    pub model_values: Vec<f64>,
    /// Number of parameters that were free in all.
    pub free: usize,
    /// The model after the fit.
    pub fit: Fit,
    /// `chi^2 + k ln N`.
    pub bic: f64,
}

impl SubsetFit {
    /// Whether the residual is down to its uncertainty: `chi^2` at most `nu + 2 sqrt(2 nu)`, `nu =
    /// N - k`.
    pub fn explains(&self) -> bool {
        let nu = self.fit.data_count.saturating_sub(self.free).max(1) as f64;
        self.fit.chi_square <= max_chi_square(nu)
    }
}

/// A measured root that was left out and predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutPrediction {
    /// Label of the target.
    pub label: String,
    /// Error of the model as it stood, percent, as in [`FitRow`](super::FitRow).
    pub before_percent: f64,
    /// Error of the model updated without it, percent.
    pub after_percent: f64,
}

/// Parameter subsets that explain the misfit.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The fit with the always free parameters alone, or with none.
    pub none: SubsetFit,
    /// Each parameter alone, smallest remaining error first.
    pub single: Vec<SubsetFit>,
    /// Pairs among the best of them, smallest remaining error first.
    pub pairs: Vec<SubsetFit>,
    /// The smallest set that brings the residual to its uncertainty; where none does, the one of
    /// smallest BIC.
    pub proposed: SubsetFit,
    /// Leave-one-out check of that set.
    pub left_out_predictions: Vec<LeftOutPrediction>,
}

/// Fits subsets of the free parameters of the problem; those named in `always` are free in every
/// fit.
///
/// Subsets of more than two grow from the best pair by the parameter that leaves the smallest
/// error.
///
/// # Errors
/// [`UpdateError::Parameter`] for an unknown or repeated name; as
/// [`solve_from_starts`].
pub fn explain(problem: &UpdateProblem<'_>, always: &[String]) -> Result<Explanation, UpdateError> {
    let trials = Trials::new(problem, always)?;
    let none = trials.change(&[])?;
    let single = trials.single()?;
    let best: Vec<usize> = single
        .iter()
        .take(PAIRED_PARAMETERS)
        .map(|(parameters, _)| parameters[0])
        .collect();
    let pairs = best
        .iter()
        .enumerate()
        .flat_map(|(i, &a)| best[i + 1..].iter().map(move |&b| vec![a, b]));
    let pairs = trials.ranked(pairs.collect())?;
    let (chosen, proposed) = trials.proposed(&none, &single, &pairs)?;
    let changes =
        |trials: Vec<(Vec<usize>, SubsetFit)>| trials.into_iter().map(|(_, c)| c).collect();
    Ok(Explanation {
        left_out_predictions: trials.predict_left_out(&chosen)?,
        none,
        single: changes(single),
        pairs: changes(pairs),
        proposed,
    })
}

/// The fits of single parameters alone, smallest remaining error first.
///
/// # Errors
/// As [`explain`].
pub fn single_parameter_fits(
    problem: &UpdateProblem<'_>,
    always: &[String],
) -> Result<Vec<SubsetFit>, UpdateError> {
    let ranked = Trials::new(problem, always)?.single()?;
    Ok(ranked.into_iter().map(|(_, change)| change).collect())
}

/// Checks that every name is that of a free parameter, and none is repeated, as [`explain`]
/// requires of `always`.
///
/// # Errors
/// [`UpdateError::Parameter`].
pub fn check_always(problem: &UpdateProblem<'_>, always: &[String]) -> Result<(), UpdateError> {
    Trials::new(problem, always).map(|_| ())
}

struct Trials<'b> {
    problem: UpdateProblem<'b>,
    /// Places in the problem's list of free parameters.
    always: Vec<usize>,
    candidates: Vec<usize>,
}

type Ranked = Vec<(Vec<usize>, SubsetFit)>;

impl<'b> Trials<'b> {
    fn new(problem: &UpdateProblem<'b>, always: &[String]) -> Result<Self, UpdateError> {
        let error = |name: &String, reason| UpdateError::Parameter {
            name: name.clone(),
            reason,
            known: problem
                .free
                .iter()
                .map(|parameter| parameter.name.clone())
                .collect(),
        };
        let mut places = Vec::with_capacity(always.len());
        for name in always {
            let found = problem
                .free
                .iter()
                .position(|parameter| parameter.name == *name);
            let place = found.ok_or_else(|| error(name, "it is not among the free parameters"))?;
            if places.contains(&place) {
                return Err(error(name, "named twice as always free"));
            }
            places.push(place);
        }
        let always = places;
        let candidates = (0..problem.free.len()).filter(|j| !always.contains(j));
        Ok(Self {
            candidates: candidates.collect(),
            problem: problem.with_prior_weight(PRIOR_WEIGHT),
            always,
        })
    }

    /// The indices of a set of candidates and of the parameters that are always free.
    fn places(&self, chosen: &[usize]) -> Vec<usize> {
        let added = chosen.iter().map(|&c| self.candidates[c]);
        self.always.iter().copied().chain(added).collect()
    }

    fn change(&self, chosen: &[usize]) -> Result<SubsetFit, UpdateError> {
        let part = self.problem.with_free(&self.places(chosen));
        let at = if part.free.is_empty() {
            part.start(&[])?
        } else {
            solve_from_starts(&part)?.best.at
        };
        let fit = fit(&part, &at, None)?;
        let named = chosen
            .iter()
            .map(|&c| &self.problem.free[self.candidates[c]]);
        Ok(SubsetFit {
            parameters: named
                .clone()
                .map(|parameter| parameter.name.clone())
                .collect(),
            values: named
                .zip(&at.z[self.always.len()..])
                .map(|(parameter, z)| parameter.value(*z))
                .collect(),
            model_values: at.values().to_vec(),
            free: part.free.len(),
            bic: fit.chi_square + part.free.len() as f64 * (fit.data_count as f64).ln(),
            fit,
        })
    }

    /// Each candidate alone.
    fn single(&self) -> Result<Ranked, UpdateError> {
        self.ranked((0..self.candidates.len()).map(|c| vec![c]).collect())
    }

    /// All sets, smallest remaining error first.
    fn ranked(&self, sets: Vec<Vec<usize>>) -> Result<Ranked, UpdateError> {
        let change = |set: &Vec<usize>| Ok((set.clone(), self.change(set)?));
        let changes: Vec<Result<(Vec<usize>, SubsetFit), UpdateError>> =
            sets.par_iter().map(change).collect();
        let mut changes = changes.into_iter().collect::<Result<Ranked, _>>()?;
        sort_ascending_by(&mut changes, |change| change.1.fit.chi_square);
        Ok(changes)
    }

    /// The smallest set that explains the misfit, of equal size the one of the smallest error; else
    /// the one of the smallest BIC.
    fn proposed(
        &self,
        none: &SubsetFit,
        single: &Ranked,
        pairs: &Ranked,
    ) -> Result<(Vec<usize>, SubsetFit), UpdateError> {
        let mut tried = vec![(Vec::new(), none.clone())];
        tried.extend(single.first().cloned());
        tried.extend(pairs.first().cloned());
        while !tried.iter().any(|(_, change)| change.explains()) {
            let (chosen, _) = tried.last().expect("the empty set was tried").clone();
            let others = (0..self.candidates.len()).filter(|c| !chosen.contains(c));
            let larger = others.map(|c| chosen.iter().copied().chain([c]).collect());
            let larger: Vec<Vec<usize>> = larger.collect();
            if chosen.len() < 2 || chosen.len() >= MAX_SUBSET_SIZE || larger.is_empty() {
                break;
            }
            tried.extend(self.ranked(larger)?.into_iter().next());
        }
        let first = tried.iter().find(|(_, change)| change.explains());
        let smallest = || tried.iter().min_by(|a, b| a.1.bic.total_cmp(&b.1.bic));
        let chosen = first.or_else(smallest);
        Ok(chosen.expect("the empty set was tried").clone())
    }

    /// Every target left out in turn, and predicted by the set from all others.
    fn predict_left_out(&self, chosen: &[usize]) -> Result<Vec<LeftOutPrediction>, UpdateError> {
        let part = self.problem.with_free(&self.places(chosen));
        let count = part.targets.len();
        if part.free.is_empty() || count < 2 {
            return Ok(Vec::new());
        }
        let start = part.start(&vec![0.0; part.free.len()])?;
        let before = fit(&part, &start, None)?;
        let one = |t: usize| -> Result<Option<LeftOutPrediction>, UpdateError> {
            let without = part.without_target(t);
            let found: Solution = solve_from_starts(&without)?.best;
            let after = fit(&part, &part.start(&found.at.z)?, None)?;
            let errors = before.rows[t]
                .error_percent
                .zip(after.rows[t].error_percent);
            Ok(
                errors.map(|(before_percent, after_percent)| LeftOutPrediction {
                    label: part.targets[t].label.clone(),
                    before_percent,
                    after_percent,
                }),
            )
        };
        let all: Vec<Result<Option<LeftOutPrediction>, UpdateError>> =
            (0..count).into_par_iter().map(one).collect();
        let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
        Ok(all.into_iter().flatten().collect())
    }
}

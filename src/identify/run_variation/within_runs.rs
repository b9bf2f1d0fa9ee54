//! A mode whose natural frequency varied while the FRFs of one run were averaged leaves several
//! poles; here they become one mode again.
//!
//! The average of an FRF over hits h with the poles λ_h is `A Σ_h 1/(iω − λ_h)/n`: a resonance that
//! a few poles p_j with residues A_j fit down to the noise. Far from the resonance both agree in
//! the powers of 1/(iω), so that
//!
//! ```text
//! A_f = Σ_j A_fj        mean of λ_h in run r = Σ_f A_f* Σ_j A_fj p_j / Σ_f |A_f|²,   f in run r
//! ```
//!
//! The mean of a run lies between the poles. Of two modes of a structure, which move half of the
//! sensors in opposite senses, this "mean" lies beyond one of them wherever they do. Where a
//! structure changes, most of its modes vary: one pair of poles alone stays two modes.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::linalg::sort_ascending_by;
use crate::modal::Pole;

use crate::identify::estimator::{Candidate, PoleTable};
use crate::identify::run_variation::run_means::mean_over_runs;
use crate::identify::run_variation::separate_responses::by_point;

/// Maximum distance of neighbouring poles of one mode, half-power bandwidths (mean of both). Shifts
/// by 0.6 bandwidths leave distances of up to 1.3. Larger: separate modes come into question.
const MAX_DISTANCE_BANDWIDTHS: f64 = 1.5;
/// Minimum part of the FRFs, weighted by energy, whose mean lies between the poles: 0.99 and more
/// of one mode, about half of two. Larger: noise near nodes keeps modes apart. Smaller: pairs of
/// modes are merged (`poles_that_may_be_separate_modes_stay`).
const MIN_FRACTION_BETWEEN: f64 = 0.9;
/// Margin on either side over the distance of the outermost poles. Smaller: few poles have the mean
/// of an outlying run beyond them (`a_run_slightly_beyond_the_poles_belongs_to_the_mode`). Larger:
/// the mean of two modes, one of which moves a fifth of what the other does, lies within it.
const MARGIN_OVER_SPAN: f64 = 0.2;
/// Maximum share of the strongest pole in an FRF, averaged over the FRFs. Larger: local modes, each
/// of which moves other sensors, are merged (`local_modes_of_separate_sensors_stay`). Smaller: two
/// poles of a mode that varied little stay apart.
const MAX_STRONGEST_SHARE: f64 = 0.85;
/// Minimum number of FRFs: the means of fewer lie between the poles by chance.
const MIN_FRFS: usize = 6;
/// Minimum number of poles beyond one for each mode and of modes whose frequency scatters between
/// runs, and minimum fraction of the modes that vary. Larger: structures of few modes keep the
/// poles. Smaller: close modes whose shapes look like one are merged.
const MIN_FURTHER_POLES: usize = 3;
const MIN_VARYING_FRACTION: f64 = 0.5;
/// Variance of the mean pole of a run over the reciprocal of its energy, far below noise: the
/// scatter of the decay rates over the runs raises it to what that is.
const VARIANCE_OVER_ENERGY: f64 = 1e-12;

/// Merges the poles of each mode whose frequency varied within the runs.
pub(in crate::identify) fn merge_varying_modes(set: &FrfSet, table: &mut PoleTable) {
    sort_ascending_by(&mut table.candidates, |candidate| candidate.pole.lambda.im);
    let hz = |pole: Pole| {
        let pole = pole.without_added_damping(set.added_damping_rad_s);
        pole.natural_frequency_hz()
    };
    let scatters = |candidate: &Candidate| {
        let of_candidate = |finding: &&Finding| is_at(finding, hz(candidate.pole));
        let codes = [Code::RunsScatter, Code::RunsMerged];
        let mut findings = table.findings.iter().filter(of_candidate);
        findings.any(|finding| codes.contains(&finding.code))
    };
    let modes: Vec<&[Candidate]> = table
        .candidates
        .chunk_by(are_neighbours)
        .flat_map(fewest_modes)
        .collect();
    let is_split = |mode: &[Candidate]| mode.len() > 1;
    let split = modes.iter().filter(|mode| is_split(mode)).count();
    let single = modes.iter().filter(|mode| !is_split(mode));
    let scattering = single.filter(|mode| scatters(&mode[0])).count();
    let further_poles = table.candidates.len() - modes.len();
    let most_vary = (split + scattering) as f64 >= MIN_VARYING_FRACTION * modes.len() as f64;
    if further_poles + scattering < MIN_FURTHER_POLES || !most_vary {
        return;
    }
    let runs = by_point(set.functions());
    let mut merged_candidates = Vec::with_capacity(modes.len());
    let mut findings = Vec::new();
    for mode in modes {
        if !is_split(mode) {
            merged_candidates.push(mode[0].clone());
            continue;
        }
        let (merged, spread) = merged(mode, &runs);
        let at = hz(merged.pole);
        let finding = Finding::new(
            Severity::Warning,
            Code::VariesWithinRuns,
            Location::Mode(at),
        );
        findings.push(finding.value(spread / TAU, "Hz"));
        // What was found about the poles one by one is not about the mode.
        let poles = || mode.iter().map(|candidate| hz(candidate.pole));
        table
            .findings
            .retain(|finding| !poles().any(|hz| is_at(finding, hz)));
        merged_candidates.push(merged);
    }
    table.candidates = merged_candidates;
    table.findings.extend(findings);
}

/// Whether a finding is about a mode of a frequency.
fn is_at(finding: &Finding, hz: f64) -> bool {
    matches!(finding.location, Location::Mode(at) if (at - hz).abs() <= 1e-9 * hz)
}

/// Whether two poles in ascending order may be parts of one mode.
fn are_neighbours(a: &Candidate, b: &Candidate) -> bool {
    let has_shape = |candidate: &Candidate| {
        let residues = candidate.residues.as_ref();
        residues.is_some_and(|values| values.len() >= MIN_FRFS)
    };
    let (p, q) = (a.pole.lambda, b.pole.lambda);
    let bandwidths = (q.im - p.im) / (p.re + q.re).abs();
    has_shape(a) && has_shape(b) && bandwidths < MAX_DISTANCE_BANDWIDTHS
}

/// Cuts a chain of neighbours into as few modes as possible.
fn fewest_modes(chain: &[Candidate]) -> Vec<&[Candidate]> {
    // Modes of the first poles of the chain, for every number of them.
    let mut of_first: Vec<Vec<&[Candidate]>> = vec![Vec::new()];
    for end in 1..=chain.len() {
        let with_last = |start: usize| {
            let last = &chain[start..end];
            (start + 1 == end || is_one_mode(last))
                .then(|| [&of_first[start][..], &[last]].concat())
        };
        let fewest = (0..end).filter_map(with_last).min_by_key(Vec::len);
        of_first.push(fewest.unwrap_or_default());
    }
    of_first.pop().unwrap_or_default()
}

/// Whether poles are those of one mode: their mean lies between them in nearly all FRFs, in which
/// several of them take part.
fn is_one_mode(poles: &[Candidate]) -> bool {
    let residues: Vec<&[Complex64]> = poles
        .iter()
        .flat_map(|pole| pole.residues.as_deref())
        .collect();
    let omega = |j: usize| poles[j].pole.lambda.im;
    let (lowest, highest) = (omega(0), omega(poles.len() - 1));
    let margin = MARGIN_OVER_SPAN * (highest - lowest);
    let (mut all, mut between, mut strongest) = (0.0, 0.0, 0.0);
    for f in 0..residues[0].len() {
        let values = || residues.iter().map(|of_pole| of_pole[f]);
        let sum: Complex64 = values().sum();
        let sizes: f64 = values().map(Complex64::norm).sum();
        let mean = values()
            .enumerate()
            .map(|(j, a)| a * omega(j))
            .sum::<Complex64>()
            / sum;
        all += sizes * sizes;
        strongest += sizes * values().map(Complex64::norm).fold(0.0, f64::max);
        if (lowest - margin..=highest + margin).contains(&mean.re) {
            between += sizes * sizes;
        }
    }
    between > MIN_FRACTION_BETWEEN * all && strongest < MAX_STRONGEST_SHARE * all
}

/// The mode of several poles at the mean of its frequencies, and their standard deviation, rad/s.
fn merged(poles: &[Candidate], runs: &[Vec<usize>]) -> (Candidate, f64) {
    let residues: Vec<&[Complex64]> = poles
        .iter()
        .flat_map(|pole| pole.residues.as_deref())
        .collect();
    let sum = |f: usize| residues.iter().map(|of_pole| of_pole[f]).sum::<Complex64>();
    let total: Vec<Complex64> = (0..residues[0].len()).map(sum).collect();
    let lambda = |j: usize| poles[j].pole.lambda;
    // Share of each pole in the energy of some FRFs, times that energy.
    let shares = |functions: &[usize]| -> Vec<Complex64> {
        let share = |of_pole: &&[Complex64]| {
            let products = functions.iter().map(|f| total[*f].conj() * of_pole[*f]);
            products.sum::<Complex64>()
        };
        residues.iter().map(share).collect()
    };
    let energy =
        |functions: &[usize]| -> f64 { functions.iter().map(|f| total[*f].norm_sqr()).sum() };
    let mean = |functions: &[usize]| {
        let shares = shares(functions).into_iter().enumerate();
        shares
            .map(|(j, share)| share * lambda(j))
            .sum::<Complex64>()
            / energy(functions)
    };
    let all: Vec<usize> = (0..total.len()).collect();
    let middle = mean(&all);
    let shares = shares(&all);
    let squares = (0..poles.len()).map(|j| shares[j].re.abs() * (lambda(j).im - middle.im).powi(2));
    let spread =
        (squares.sum::<f64>() / shares.iter().map(|share| share.re.abs()).sum::<f64>()).sqrt();
    let shift = |run: &Vec<usize>| {
        let energy = energy(run);
        (energy > 0.0).then(|| (mean(run) - middle, VARIANCE_OVER_ENERGY / energy))
    };
    let shifts: Vec<(Complex64, f64)> = runs.iter().filter_map(shift).collect();
    let over_runs = mean_over_runs(&shifts);
    let strongest = |a: &&Candidate, b: &&Candidate| {
        let energy = |candidate: &Candidate| -> f64 {
            let residues = candidate.residues.iter().flatten();
            residues.map(Complex64::norm_sqr).sum()
        };
        energy(a).total_cmp(&energy(b))
    };
    let strongest = poles.iter().max_by(strongest).unwrap_or(&poles[0]);
    let shift = over_runs.map_or(0.0, |mean| mean.shift);
    let merged = Candidate {
        order: strongest.order,
        residues: Some(total),
        frequency_std_hz: over_runs.map(|mean| mean.std / TAU),
        evidence: strongest.evidence,
        ..Candidate::new(Pole {
            lambda: middle + Complex64::new(0.0, shift),
        })
    };
    (merged, spread)
}

//! FRFs that were smoothed over frequency lines have two poles of one shape for each mode, all at
//! the same distance: a mean over three lines leaves poles 1.4 to 1.6 lines apart, with equal
//! residues. The mean of the two replaces them, where there are several pairs at one distance, or
//! where a pair has equal residues and that distance.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::mac;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::estimator::Candidate;
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::fit::pole_covariance::add_noise_model_uncertainty;
use crate::identify::pole_model::PoleModel;

/// Distance of two poles of one mode, half-power bandwidths. Smoothing over three lines leaves
/// poles 1.4 to 1.6 lines apart.
const MAX_DISTANCE_BANDWIDTHS: f64 = 1.0;
/// The same in frequency lines: a mode of a small mass that is tuned to another one may lie as near
/// in bandwidths (`a_tuned_absorber_is_a_mode`).
const MAX_DISTANCE_LINES: f64 = 3.0;
/// Ratio of their decay rates: poles of a mode that depends on the amplitude have 2 to 5 times its
/// decay rate (`a_mode_whose_damping_grows_stays_one_mode`).
const MAX_DECAY_RATIO: f64 = 1.5;
/// Ratio of the largest to the smallest distance of the merged pairs: smoothing leaves the poles of
/// all modes at one distance, two modes that the sensors do not separate are one pair.
const MAX_DISTANCE_RATIO: f64 = 1.3;
const MIN_PAIRS: usize = 2;
/// Distance, lines, of the poles that a symmetric mean over three lines leaves: √2 with the weights
/// of a Hann window, √(8/3) with equal ones, here with a margin of a twentieth for noise. Wider, at
/// 1.1 to 2: equal modes of one shape are merged (`two_modes_of_one_shape_stay`). Narrower, from
/// 1.5: a mode under Hann weights stays two (`a_single_mode_of_smoothed_frfs_is_found_once`). Two
/// modes of one shape and size within these limits are merged.
const SMOOTHED_DISTANCE_LINES: [f64; 2] = [1.34, 1.71];
/// Difference of the residues of such a pair over their sum: smoothing leaves equal residues.
/// Larger, at 0.4: two modes of one shape are merged (`two_modes_of_one_shape_stay`). Smaller, at
/// 0.1: a smoothed mode stays two (`a_single_mode_of_smoothed_frfs_is_found_once`).
const MAX_RESIDUE_DIFFERENCE: f64 = 0.2;
/// MAC of their residues. Two modes of random real shapes at four FRFs have a MAC beyond it in 1 of
/// 200 cases.
const MIN_MAC: f64 = 0.95;
/// Minimum number of FRFs: fewer have one shape by chance.
const MIN_FRFS: usize = 4;

/// Two poles that were merged.
pub(in crate::identify) struct Merged {
    /// Mean of both, rad/s.
    lambda: Complex64,
    /// Their distance in frequency, lines.
    lines: f64,
}

impl Merged {
    /// The finding at the candidate that is nearest; `added_damping`: decay rate of a window.
    pub fn finding(&self, candidates: &[Candidate], added_damping: f64) -> Option<Finding> {
        let distance = |candidate: &&Candidate| (candidate.pole.lambda - self.lambda).norm();
        let nearest = candidates
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let hz = nearest
            .pole
            .without_added_damping(added_damping)
            .natural_frequency_hz();
        let is_near = distance(&nearest) < self.lambda.re.abs();
        let finding = Finding::new(Severity::Warning, Code::PolesMerged, Location::Mode(hz));
        is_near.then(|| finding.value(self.lines, "lines"))
    }
}

impl PoleModel {
    /// Merges the pairs of poles of one shape that lie at one distance of a few lines, else those
    /// that smoothing over three lines leaves, and fits the residues again.
    pub fn merge_same_shapes(&mut self) -> Vec<Merged> {
        let mut pairs = self.same_shapes();
        let distances = pairs.iter().map(|(i, j)| self.lines_between(*i, *j));
        let distances: Vec<f64> = distances.collect();
        let shortest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let longest = distances.iter().copied().fold(0.0, f64::max);
        let are_alike = pairs.len() >= MIN_PAIRS && longest <= MAX_DISTANCE_RATIO * shortest;
        if !are_alike {
            pairs.retain(|pair| self.is_smoothed_mode(*pair));
        }
        if pairs.is_empty() {
            return Vec::new();
        }
        let mut merged = Vec::new();
        for &(kept, other) in &pairs {
            let norm = |pole: &ModelPole| {
                pole.residues
                    .iter()
                    .map(Complex64::norm_sqr)
                    .sum::<f64>()
                    .sqrt()
            };
            let (a, b) = (norm(&self.poles[kept]), norm(&self.poles[other]));
            let lines = self.lines_between(kept, other);
            let lambda = (self.poles[kept].lambda * a + self.poles[other].lambda * b) / (a + b);
            // Far from the pair, the response of one pole with the sum of the residues.
            let of_other = std::mem::take(&mut self.poles[other].residues);
            let pole = &mut self.poles[kept];
            let residues = pole.residues.iter_mut().zip(&of_other);
            residues.for_each(|(residue, other)| *residue += other);
            pole.lambda = lambda;
            pole.pair = None;
            merged.push(Merged { lambda, lines });
        }
        let mut index = 0;
        self.poles.retain(|_| {
            index += 1;
            !pairs.iter().any(|(_, other)| *other == index - 1)
        });
        // The misfit of one pole would draw the others to it.
        self.fixed = true;
        mark_unconverged(&mut self.poles);
        self.refine(Convergence::Residues);
        self.fixed = false;
        self.add_out_of_band_uncertainty();
        add_noise_model_uncertainty(&self.data, &mut self.poles);
        merged
    }

    /// Whether a pair of poles is what smoothing over three lines makes of one mode.
    fn is_smoothed_mode(&self, (i, j): (usize, usize)) -> bool {
        let [shortest, longest] = SMOOTHED_DISTANCE_LINES;
        let residues = || self.poles[i].residues.iter().zip(&self.poles[j].residues);
        let difference: f64 = residues().map(|(a, b)| (a - b).norm_sqr()).sum();
        let sum: f64 = residues().map(|(a, b)| (a + b).norm_sqr()).sum();
        (shortest..longest).contains(&self.lines_between(i, j))
            && difference < MAX_RESIDUE_DIFFERENCE.powi(2) * sum
    }

    fn lines_between(&self, i: usize, j: usize) -> f64 {
        (self.poles[i].lambda.im - self.poles[j].lambda.im).abs() / self.data.frfs.step
    }

    /// Pairs of neighbouring poles of one shape, by their indices, the stronger first; each pole in
    /// one pair at most.
    fn same_shapes(&self) -> Vec<(usize, usize)> {
        let single = |j: &usize| {
            let pole = &self.poles[*j];
            pole.multiplicity() == 1 && !pole.is_companion && pole.residues.len() >= MIN_FRFS
        };
        // Poles are in ascending frequency.
        let singles: Vec<usize> = (0..self.poles.len()).filter(single).collect();
        let mut pairs: Vec<(usize, usize)> = Vec::new();
        for neighbours in singles.windows(2) {
            let (i, j) = (neighbours[0], neighbours[1]);
            let (a, b) = (&self.poles[i], &self.poles[j]);
            let ratio = a.decay().max(b.decay()) / a.decay().min(b.decay());
            let is_pair = 2.0 * a.separation(b) < MAX_DISTANCE_BANDWIDTHS
                && self.lines_between(i, j) < MAX_DISTANCE_LINES
                && ratio < MAX_DECAY_RATIO
                && mac(&a.residues, &b.residues) > Some(MIN_MAC);
            let is_free = pairs.last().is_none_or(|last| last.0 != i && last.1 != i);
            if is_pair && is_free {
                let stronger = a.quality.significance() >= b.quality.significance();
                pairs.push(if stronger { (i, j) } else { (j, i) });
            }
        }
        pairs
    }
}

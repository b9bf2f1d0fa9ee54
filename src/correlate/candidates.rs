//! The candidate table holds the cost of every pair of test mode and root, the chosen pairs and
//! their verdicts.

use std::collections::BTreeMap;

use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::ModalModel;

use super::chance::{ChanceLevel, ChanceSetting, MIN_DOFS_OF_SHAPE, effective_dof_fraction};
use super::global_stiffness_factor::{MacTable, global_stiffness_factor};
use super::mislabelled::exchanged_frequencies;
use super::modal_contribution::{ModalContribution, modal_contributions};
use super::model_roots::{Root, elastic_modes, elastic_roots};
use super::partner::{
    Basis, Competitor, MIN_DIRECTION_CONTRIBUTION, NearMiss, Pair, PairVerdict, Partner,
    UnpairedRoot,
};
use super::shape_match::{ShapeMatch, shape_matches};
use super::shapes::Shapes;
use super::{CorrelateError, DofMap, PairOptions, assign};

/// Cost of an unpaired test mode, and of a pair at both gates: a pair inside its gates costs no
/// more.
const UNPAIRED_COST: f64 = 1.0;

/// Minimum contribution of a root to a test shape, over `min_mac`, for a candidate partner.
const MIN_CONTRIBUTION_OVER_MIN_MAC: f64 = 0.6;

/// Minimum contribution of a competitor that contests a shape: two roots cannot both contribute
/// more than half.
const MIN_CONTESTED_CONTRIBUTION: f64 = 0.5;

/// Weight of the frequency in the cost of a pair; the shape has the other part.
pub(super) const FREQUENCY_WEIGHT: f64 = 0.1;

/// A possible pair of test mode and root.
#[derive(Clone, Copy)]
struct Candidate {
    frequency_error: f64,
    /// `|f_test − f_theory|/f_theory`, whatever the options' reference of the error.
    frequency_distance: f64,
    mac: Option<f64>,
    /// Contribution of the root to the test shape.
    contribution: Option<ModalContribution>,
    /// `None` when a gate forbids the pair.
    cost: Option<f64>,
    /// Whether the pair is inside the frequency gate and forbidden for its MAC.
    low_mac: bool,
}

impl Candidate {
    fn new(
        frequency_error: f64,
        frequency_distance: f64,
        evidence: ShapeEvidence,
        options: &PairOptions,
    ) -> Self {
        let u = frequency_distance / options.max_frequency_error;
        let is_near = u <= 1.0;
        let min_contribution = MIN_CONTRIBUTION_OVER_MIN_MAC * options.min_mac;
        let (mac, contribution) = match evidence {
            ShapeEvidence::Known(mac, contribution) => (mac, contribution),
            _ => (None, None),
        };
        let is_similar = contribution
            .is_some_and(|contribution| contribution.fraction >= min_contribution)
            || mac.is_some_and(|mac| mac >= options.min_mac);
        let shape_cost = |contribution: ModalContribution| {
            let v = ((1.0 - contribution.fraction) / (1.0 - min_contribution)).min(1.0);
            is_similar.then_some(FREQUENCY_WEIGHT * u + (1.0 - FREQUENCY_WEIGHT) * v)
        };
        let cost = match evidence {
            ShapeEvidence::Known(..) => contribution.and_then(shape_cost),
            ShapeEvidence::Unknown => Some(u),
        };
        Self {
            frequency_error,
            frequency_distance,
            mac,
            contribution,
            cost: cost.filter(|_| is_near),
            low_mac: is_near && mac.is_some() && !is_similar,
        }
    }
}

/// The root assigned to every row, with the inputs of the assignment.
struct ChosenPairs<'a> {
    root_of: &'a [Option<usize>],
    /// Shapes as measured.
    shapes: &'a Shapes,
    /// Whether the pairs were assigned with some sensors reversed.
    reversed: bool,
    options: &'a PairOptions,
    /// Whether the MAC of each row reaches the chance level of its root; `None` where too few
    /// degrees of freedom are in common.
    correlated: Vec<Option<bool>>,
}

/// Every elastic test mode (row) against every elastic root (column).
pub(super) struct CandidateTable {
    modes: Vec<usize>,
    pub roots: Vec<Root>,
    candidates: Vec<Vec<Candidate>>,
    /// Effective degrees of freedom over their number.
    effective_fraction: f64,
}

impl CandidateTable {
    pub fn new(
        test: &ModalModel,
        theory: &ModalModel,
        shapes: &Shapes,
        map: &DofMap,
        options: &PairOptions,
    ) -> Self {
        let (modes, roots) = (elastic_modes(test), elastic_roots(theory));
        let frequency_distance = |i: usize, r: usize| {
            let hz = test.modes[i].frequency_hz;
            (hz - roots[r].hz).abs() / roots[r].hz
        };
        // The contributions of each root to the test modes inside the frequency gate.
        let contributions: Vec<BTreeMap<usize, ModalContribution>> = (0..roots.len())
            .map(|r| {
                let near = |i: &usize| frequency_distance(*i, r) <= options.max_frequency_error;
                let near: Vec<usize> = modes.iter().copied().filter(near).collect();
                let of_root = modal_contributions(theory, shapes, &near, r, &roots);
                let known = near.into_iter().zip(of_root);
                known
                    .filter_map(|(i, contribution)| Some((i, contribution?)))
                    .collect()
            })
            .collect();
        let macs = shapes.mac_matrix();
        let candidate = |i: usize, r: usize| {
            let root = &roots[r];
            let hz = test.modes[i].frequency_hz;
            let mac = match root.modes[..] {
                [single] => macs[i][single],
                _ => shapes.mac(i, &root.modes),
            };
            let evidence = match shapes.distinct_common_count(i, &root.modes) {
                // Nothing that the test measures can be a mode of the theory.
                _ if map.is_still_in_theory() => ShapeEvidence::Known(None, None),
                MIN_DOFS_OF_SHAPE.. => ShapeEvidence::Known(mac, contributions[r].get(&i).copied()),
                _ => ShapeEvidence::Unknown,
            };
            let frequency_error = options.error_reference.error(hz, root.hz);
            Candidate::new(frequency_error, frequency_distance(i, r), evidence, options)
        };
        let row = |&i: &usize| (0..roots.len()).map(|r| candidate(i, r)).collect();
        Self {
            candidates: modes.iter().map(row).collect(),
            effective_fraction: effective_dof_fraction(&shapes.of_roots(&roots)),
            modes,
            roots,
        }
    }

    /// The root of every row; a repeated root has as many columns as modes.
    pub fn assign(&self) -> Vec<Option<usize>> {
        let repeated = |r: usize| std::iter::repeat_n(r, self.roots[r].modes.len());
        let columns: Vec<usize> = (0..self.roots.len()).flat_map(repeated).collect();
        let row =
            |candidates: &Vec<Candidate>| columns.iter().map(|&r| candidates[r].cost).collect();
        let costs: Vec<Vec<Option<f64>>> = self.candidates.iter().map(row).collect();
        let chosen = assign(&costs, UNPAIRED_COST);
        chosen
            .into_iter()
            .map(|column| column.map(|c| columns[c]))
            .collect()
    }

    pub fn pairs(
        &self,
        root_of: &[Option<usize>],
        shapes: &Shapes,
        reversed: bool,
        options: &PairOptions,
    ) -> Result<Vec<Pair>, CorrelateError> {
        let mut chosen_pairs = ChosenPairs {
            root_of,
            shapes,
            reversed,
            options,
            correlated: vec![None; root_of.len()],
        };
        let correlated = |i: usize| self.is_correlated(i, &chosen_pairs);
        chosen_pairs.correlated = (0..root_of.len()).map(correlated).collect();
        let mut pairs = Vec::new();
        for (r, root) in self.roots.iter().enumerate() {
            let rows: Vec<usize> = (0..root_of.len())
                .filter(|&i| root_of[i] == Some(r))
                .collect();
            if rows.is_empty() {
                continue;
            }
            let modes: Vec<usize> = rows.iter().map(|&i| self.modes[i]).collect();
            let angles = match root.modes.len() {
                1 => Vec::new(),
                _ => shapes.angles_deg(&modes, &root.modes)?,
            };
            let partner = |&i: &usize| self.partner(i, r, &chosen_pairs);
            pairs.push(Pair {
                theory: root.modes.clone(),
                partners: rows.iter().map(partner).collect(),
                angles_deg: (!angles.is_empty()).then_some(angles),
                weakest_direction: shapes
                    .weakest_direction(&modes, &root.modes)?
                    .filter(|contribution| *contribution < MIN_DIRECTION_CONTRIBUTION),
            });
        }
        Ok(pairs)
    }

    fn partner(&self, i: usize, r: usize, chosen_pairs: &ChosenPairs<'_>) -> Partner {
        let chosen = self.candidates[i][r];
        let cost = chosen.cost.expect("only allowed pairs are assigned");
        let chance_level = self.chance_level(i, r, chosen_pairs);
        let mac = chosen_pairs.shapes.mac(self.modes[i], &self.roots[r].modes);
        Partner {
            test: self.modes[i],
            frequency_error: chosen.frequency_error,
            mac,
            chance_level,
            basis: match chance_level {
                Some(_) => Basis::Shape,
                None => Basis::Frequency,
            },
            cost,
            verdict: match (chance_level, mac) {
                (Some(level), Some(mac)) if mac < level.mac => PairVerdict::Uncorrelated {
                    mac,
                    level,
                    reversed: chosen.mac.filter(|mac| *mac >= level.mac),
                },
                (Some(_), Some(mac))
                    if chosen_pairs.reversed
                        && mac < chosen_pairs.options.min_mac
                        && chosen.mac >= Some(chosen_pairs.options.min_mac) =>
                {
                    PairVerdict::RestsOnReversal {
                        mac,
                        reversed: chosen.mac,
                    }
                }
                _ => self.verdict(i, r, chosen_pairs),
            },
        }
    }

    /// Whether the MAC of a row reaches the chance level of its root; `None` where no root within
    /// the frequency gate has enough degrees of freedom in common.
    fn is_correlated(&self, i: usize, chosen_pairs: &ChosenPairs<'_>) -> Option<bool> {
        if let Some(r) = chosen_pairs.root_of[i] {
            let level = self.chance_level(i, r, chosen_pairs)?;
            let mac = chosen_pairs.shapes.mac(self.modes[i], &self.roots[r].modes);
            return Some(mac? >= level.mac);
        }
        let gate = chosen_pairs.options.max_frequency_error;
        let comparable = |(root, candidate): (&Root, &Candidate)| {
            let dofs = || {
                let shapes = chosen_pairs.shapes;
                shapes.distinct_common_count(self.modes[i], &root.modes)
            };
            candidate.frequency_distance <= gate && dofs() >= MIN_DOFS_OF_SHAPE
        };
        let mut candidates = self.roots.iter().zip(&self.candidates[i]);
        candidates.any(comparable).then_some(false)
    }

    /// Whether most other rows reach their chance levels.
    fn others_correlate(i: usize, chosen_pairs: &ChosenPairs<'_>) -> bool {
        let rows = chosen_pairs.correlated.iter().enumerate();
        let others = rows.filter_map(|(row, significant)| significant.filter(|_| row != i));
        let (reached, all) = others.fold((0, 0), |(reached, all), significant| {
            (reached + usize::from(significant), all + 1)
        });
        2 * reached > all
    }

    /// `None` where fewer degrees of freedom are in common than a pair by shape needs.
    fn chance_level(
        &self,
        i: usize,
        r: usize,
        chosen_pairs: &ChosenPairs<'_>,
    ) -> Option<ChanceLevel> {
        let root = &self.roots[r].modes;
        let dofs = chosen_pairs
            .shapes
            .distinct_common_count(self.modes[i], root);
        let [test, root] = chosen_pairs.shapes.common_values(&[self.modes[i]], root);
        let row = &self.candidates[i];
        let within = |limit: f64| {
            let distances = row.iter().map(|candidate| candidate.frequency_distance);
            distances.filter(|distance| *distance <= limit).count()
        };
        (dofs >= MIN_DOFS_OF_SHAPE).then(|| {
            let setting = ChanceSetting {
                dofs,
                effective_fraction: self.effective_fraction,
                roots: within(chosen_pairs.options.max_frequency_error),
                rank: within(row[r].frequency_distance),
                others_correlate: Self::others_correlate(i, chosen_pairs),
            };
            ChanceLevel::new(&test[0], &root, &setting)
        })
    }

    /// The verdict on a pair whose MAC reaches its chance level.
    fn verdict(&self, i: usize, r: usize, chosen_pairs: &ChosenPairs<'_>) -> PairVerdict {
        let cost = self.candidates[i][r].cost.unwrap_or(UNPAIRED_COST);
        let options = chosen_pairs.options;
        match self.cheapest_competitor(i, r, chosen_pairs.root_of) {
            Some((other_cost, competitor)) if other_cost - cost < options.ambiguous_margin => {
                PairVerdict::Ambiguous {
                    competitor,
                    cost_difference: other_cost - cost,
                }
            }
            _ => self.verdict_by_contribution(i, r, chosen_pairs.root_of, options),
        }
    }

    /// Whether the contribution of root `r` to the shape of row `i` is large enough, and no
    /// competitor has one of half or more.
    fn verdict_by_contribution(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
        options: &PairOptions,
    ) -> PairVerdict {
        let Some(contribution) = self.candidates[i][r].contribution else {
            return PairVerdict::Paired;
        };
        let contesting = self
            .competitors(i, r, root_of)
            .filter_map(|(other, competitor)| {
                let fraction = other.contribution?.fraction;
                (fraction >= MIN_CONTESTED_CONTRIBUTION).then_some((fraction, competitor))
            });
        match contesting.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((contribution, competitor)) => PairVerdict::ContestedShape {
                competitor,
                contribution,
            },
            None if contribution.fraction - contribution.std < options.min_mac => {
                PairVerdict::MixedShape {
                    contribution: contribution.fraction,
                    std: contribution.std,
                }
            }
            None => PairVerdict::Paired,
        }
    }

    /// The allowed competitor of row `i` or root `r` with the lowest cost.
    fn cheapest_competitor(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
    ) -> Option<(f64, Competitor)> {
        let others = self.competitors(i, r, root_of);
        let allowed = others.filter_map(|(other, competitor)| Some((other.cost?, competitor)));
        allowed.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// All other partners of row `i` and of root `r`.
    fn competitors(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
    ) -> impl Iterator<Item = (Candidate, Competitor)> {
        let roots = (0..self.roots.len()).filter(move |&other| other != r);
        let of_test = roots.map(move |other| {
            let competitor = Competitor::Theory(self.roots[other].modes.clone());
            (self.candidates[i][other], competitor)
        });
        let rows = (0..self.modes.len()).filter(move |&other| root_of[other] != Some(r));
        let of_theory = rows.map(move |other| {
            let competitor = Competitor::Test(self.modes[other]);
            (self.candidates[other][r], competitor)
        });
        of_test.chain(of_theory)
    }

    pub fn unpaired_theory(&self, root_of: &[Option<usize>]) -> Vec<UnpairedRoot> {
        let unpaired = (0..self.roots.len()).filter(|&r| !root_of.contains(&Some(r)));
        unpaired
            .map(|r| {
                let rows = (0..self.modes.len()).map(|i| (i, self.candidates[i][r]));
                let nearest = nearest_in_frequency(rows).filter(|(_, c)| c.low_mac);
                UnpairedRoot {
                    theory: self.roots[r].modes.clone(),
                    near_miss: nearest.and_then(|(i, c)| {
                        let test = self.modes[i];
                        c.mac.map(|mac| NearMiss { test, mac })
                    }),
                }
            })
            .collect()
    }

    pub fn unpaired_test(&self, root_of: &[Option<usize>]) -> Vec<usize> {
        let rows = self.modes.iter().zip(root_of);
        rows.filter(|(_, root)| root.is_none())
            .map(|(&i, _)| i)
            .collect()
    }

    /// Findings on doubtful pairs, and on unmatched test modes whose nearest root in frequency was
    /// rejected for its MAC.
    pub fn findings(
        &self,
        test: &ModalModel,
        root_of: &[Option<usize>],
        pairs: &[Pair],
        options: &PairOptions,
    ) -> Vec<Finding> {
        let partners = || pairs.iter().flat_map(|pair| &pair.partners);
        let mut findings = Vec::new();
        for (i, &mode) in self.modes.iter().enumerate() {
            let location = Location::Mode(test.modes[mode].frequency_hz);
            let warn = |code| Finding::new(Severity::Warning, code, location);
            if let Some(partner) = partners().find(|partner| partner.test == mode) {
                let finding = verdict_finding(&partner.verdict, options);
                let finding =
                    finding.map(|(code, value, limit)| warn(code).value(value, "").limit(limit));
                findings.extend(
                    finding.map(|finding| match ambiguous_side(&partner.verdict) {
                        Some(detail) => finding.detail(detail),
                        None => finding,
                    }),
                );
                continue;
            }
            let candidates = self.candidates[i].iter().copied().enumerate();
            let nearest = nearest_in_frequency(candidates).filter(|(_, c)| c.low_mac);
            if let Some(mac) = nearest.and_then(|(_, c)| c.mac) {
                findings.push(warn(Code::LowMac).value(mac, "").limit(options.min_mac));
            }
        }
        let table = self.mac_table(test, options);
        let paired = root_of.iter().flatten().count();
        findings.extend(global_stiffness_factor(&table, paired));
        findings.extend(exchanged_frequencies(&table));
        findings
    }

    /// The modes whose shapes agree at other frequencies, for a test of which none is paired.
    pub fn shape_matches(
        &self,
        test: &ModalModel,
        distinct_dofs: usize,
        options: &PairOptions,
    ) -> Vec<ShapeMatch> {
        shape_matches(&self.mac_table(test, options), distinct_dofs)
    }

    fn mac_table(&self, test: &ModalModel, options: &PairOptions) -> MacTable {
        let hz = |&i: &usize| test.modes[i].frequency_hz;
        let roots = self.roots.iter().map(|root| (root.hz, root.modes.len()));
        let of_row = |row: &Vec<Candidate>| row.iter().map(|candidate| candidate.mac).collect();
        MacTable {
            test_hz: self.modes.iter().map(hz).collect(),
            roots: roots.collect(),
            mac: self.candidates.iter().map(of_row).collect(),
            gate: options.max_frequency_error,
        }
    }
}

/// The side that has two modes of an ambiguous pair.
fn ambiguous_side(verdict: &PairVerdict) -> Option<&'static str> {
    match verdict {
        PairVerdict::Ambiguous { competitor, .. } => Some(match competitor {
            Competitor::Theory(_) => "two model modes fit this test mode",
            Competitor::Test(_) => "another test mode fits the same model mode",
        }),
        _ => None,
    }
}

/// The code, value and limit of the finding on a verdict; `None` for [`PairVerdict::Paired`].
fn verdict_finding(verdict: &PairVerdict, options: &PairOptions) -> Option<(Code, f64, f64)> {
    match verdict {
        PairVerdict::Paired => None,
        PairVerdict::Uncorrelated { mac, level, .. } => {
            Some((Code::BelowChanceLevel, *mac, level.mac))
        }
        PairVerdict::RestsOnReversal { mac, .. } => {
            Some((Code::RestsOnReversal, *mac, options.min_mac))
        }
        PairVerdict::Ambiguous {
            cost_difference, ..
        } => Some((Code::Ambiguous, *cost_difference, options.ambiguous_margin)),
        PairVerdict::ContestedShape { contribution, .. } => Some((
            Code::ClaimedTwice,
            *contribution,
            MIN_CONTESTED_CONTRIBUTION,
        )),
        PairVerdict::MixedShape { contribution, std } => {
            Some((Code::MixedShape, contribution - std, options.min_mac))
        }
    }
}

/// Evidence of the shapes on a pair.
enum ShapeEvidence {
    /// MAC and modal contribution at the common degrees of freedom.
    Known(Option<f64>, Option<ModalContribution>),
    /// Too few degrees of freedom are in common.
    Unknown,
}

fn nearest_in_frequency(
    candidates: impl Iterator<Item = (usize, Candidate)>,
) -> Option<(usize, Candidate)> {
    candidates.min_by(|a, b| a.1.frequency_distance.total_cmp(&b.1.frequency_distance))
}

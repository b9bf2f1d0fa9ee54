//! The candidate table holds the cost of every pair of test mode and root, the chosen pairs and
//! their verdicts.

use std::collections::BTreeMap;

use crate::finding::{Code, Finding, Place, Severity};
use crate::modal::ModalModel;

use super::chance::{ChanceLevel, ChanceSetting, MIN_DOFS_OF_SHAPE, effective_dof_fraction};
use super::global_stiffness_factor::{Unlike, common_factor};
use super::modal_contribution::{ModalContribution, shares};
use super::model_roots::{Root, elastic_modes, elastic_roots};
use super::partner::{
    Basis, Competitor, MIN_DIRECTION_CONTRIBUTION, NearMiss, Pair, Partner, UnpairedRoot, Verdict,
};
use super::shapes::Shapes;
use super::{CorrelateError, PairOptions, assign};

/// Cost of a pair at both gates, and of leaving a test mode and a theory mode over: a pair inside
/// its gates is never dearer.
const ALONE: f64 = 1.0;

/// Minimum contribution of a root to a test shape, over `min_mac`, for a candidate partner.
const MIN_CONTRIBUTION_OVER_MIN_MAC: f64 = 0.6;

/// Fraction of a shape that two roots cannot both contribute.
const HALF: f64 = 0.5;

/// Weight of the frequency beside the shape.
const OF_FREQUENCY: f64 = 0.1;

/// A possible pair of test mode and root.
#[derive(Clone, Copy)]
struct Candidate {
    frequency_error: f64,
    /// `|f_test − f_theory|/f_theory`, whatever the reference of the error is.
    off: f64,
    mac: Option<f64>,
    /// The part of the test shape that the root holds.
    share: Option<ModalContribution>,
    /// `None` when a gate forbids the pair.
    cost: Option<f64>,
    /// Inside the frequency gate, with a MAC under its gate and no other claim.
    low_mac: bool,
}

/// A choice of pairs with what it was made from.
struct Choice<'a> {
    root_of: &'a [Option<usize>],
    /// As measured.
    shapes: &'a Shapes,
    /// Whether some sensors are reversed in the shapes by which the pairs are chosen.
    reversed: bool,
    options: &'a PairOptions,
    /// Whether each row reaches the chance level of its root, all rows being judged alike; `None`
    /// where no shapes can tell.
    correlated: Vec<Option<bool>>,
}

/// Every elastic test mode against every elastic root.
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
        options: &PairOptions,
    ) -> Self {
        let (modes, roots) = (elastic_modes(test), elastic_roots(theory));
        let off = |i: usize, r: usize| {
            let hz = test.modes[i].frequency_hz;
            (hz - roots[r].hz).abs() / roots[r].hz
        };
        // By root, each with the shares of the modes near it.
        let held: Vec<BTreeMap<usize, ModalContribution>> = (0..roots.len())
            .map(|r| {
                let near = |i: &usize| off(*i, r) <= options.max_frequency_error;
                let near: Vec<usize> = modes.iter().copied().filter(near).collect();
                let shares_of_near = shares(theory, shapes, &near, r, &roots);
                let found = near.into_iter().zip(shares_of_near);
                found.filter_map(|(i, share)| Some((i, share?))).collect()
            })
            .collect();
        let candidate = |i: usize, r: usize| {
            let root = &roots[r];
            let hz = test.modes[i].frequency_hz;
            let mac = shapes.compare(i, &root.modes).1;
            let likeness = match shapes.places(&[i], &root.modes).len() {
                MIN_DOFS_OF_SHAPE.. => Likeness::Of(mac, held[r].get(&i).copied()),
                _ => Likeness::Unknown,
            };
            let frequency_error = options.error_reference.error(hz, root.hz);
            candidate(frequency_error, off(i, r), likeness, options)
        };
        let row = |&i: &usize| (0..roots.len()).map(|r| candidate(i, r)).collect();
        Self {
            candidates: modes.iter().map(row).collect(),
            effective_fraction: effective_dof_fraction(&shapes.of_roots(&roots)),
            modes,
            roots,
        }
    }

    /// The root of every row; a repeated root stands in as many columns as it has modes.
    pub fn assign(&self) -> Vec<Option<usize>> {
        let repeated = |r: usize| std::iter::repeat_n(r, self.roots[r].modes.len());
        let columns: Vec<usize> = (0..self.roots.len()).flat_map(repeated).collect();
        let row =
            |candidates: &Vec<Candidate>| columns.iter().map(|&r| candidates[r].cost).collect();
        let costs: Vec<Vec<Option<f64>>> = self.candidates.iter().map(row).collect();
        let chosen = assign(&costs, ALONE);
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
        let mut choice = Choice {
            root_of,
            shapes,
            reversed,
            options,
            correlated: vec![None; root_of.len()],
        };
        let correlated = |i: usize| self.correlated(i, &choice);
        choice.correlated = (0..root_of.len()).map(correlated).collect();
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
            let partner = |&i: &usize| self.partner(i, r, &choice);
            pairs.push(Pair {
                theory: root.modes.clone(),
                partners: rows.iter().map(partner).collect(),
                angles_deg: (!angles.is_empty()).then_some(angles),
                least_direction: shapes
                    .least_direction(&modes, &root.modes)?
                    .filter(|share| *share < MIN_DIRECTION_CONTRIBUTION),
            });
        }
        Ok(pairs)
    }

    fn partner(&self, i: usize, r: usize, choice: &Choice<'_>) -> Partner {
        let chosen = self.candidates[i][r];
        let cost = chosen.cost.expect("only allowed pairs are assigned");
        let chance_level = self.chance_level(i, r, choice);
        let mac = choice.shapes.compare(self.modes[i], &self.roots[r].modes).1;
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
                (Some(level), Some(mac)) if mac < level.mac => Verdict::Uncorrelated {
                    mac,
                    level,
                    reversed: chosen.mac.filter(|mac| *mac >= level.mac),
                },
                (Some(_), Some(mac))
                    if choice.reversed
                        && mac < choice.options.min_mac
                        && chosen.mac >= Some(choice.options.min_mac) =>
                {
                    Verdict::RestsOnReversal {
                        mac,
                        reversed: chosen.mac,
                    }
                }
                _ => self.verdict(i, r, choice),
            },
        }
    }

    /// Whether a row has a root whose chance level it reaches; `None` where no root within the gate
    /// has enough degrees of freedom in common.
    fn correlated(&self, i: usize, choice: &Choice<'_>) -> Option<bool> {
        if let Some(r) = choice.root_of[i] {
            let level = self.chance_level(i, r, choice)?;
            let mac = choice.shapes.compare(self.modes[i], &self.roots[r].modes).1;
            return Some(mac? >= level.mac);
        }
        let gate = choice.options.max_frequency_error;
        let comparable = |(root, candidate): (&Root, &Candidate)| {
            let places = || choice.shapes.places(&[self.modes[i]], &root.modes);
            candidate.off <= gate && places().len() >= MIN_DOFS_OF_SHAPE
        };
        let mut candidates = self.roots.iter().zip(&self.candidates[i]);
        candidates.any(comparable).then_some(false)
    }

    /// Whether most of the other rows reach their levels.
    fn others_correlate(i: usize, choice: &Choice<'_>) -> bool {
        let rows = choice.correlated.iter().enumerate();
        let others = rows.filter_map(|(row, significant)| significant.filter(|_| row != i));
        let (reached, all) = others.fold((0, 0), |(reached, all), significant| {
            (reached + usize::from(significant), all + 1)
        });
        2 * reached > all
    }

    /// `None` where fewer degrees of freedom than a pair by shape needs are in common.
    fn chance_level(&self, i: usize, r: usize, choice: &Choice<'_>) -> Option<ChanceLevel> {
        let root = &self.roots[r].modes;
        let [test, root] = choice.shapes.common(&[self.modes[i]], root);
        let row = &self.candidates[i];
        let within = |off: f64| row.iter().filter(|candidate| candidate.off <= off).count();
        (test[0].len() >= MIN_DOFS_OF_SHAPE).then(|| {
            let setting = ChanceSetting {
                effective_fraction: self.effective_fraction,
                roots: within(choice.options.max_frequency_error),
                rank: within(row[r].off),
                others_correlate: Self::others_correlate(i, choice),
            };
            ChanceLevel::new(&test[0], &root, &setting)
        })
    }

    /// The verdict on a pair that is correlated.
    fn verdict(&self, i: usize, r: usize, choice: &Choice<'_>) -> Verdict {
        let cost = self.candidates[i][r].cost.unwrap_or(ALONE);
        let options = choice.options;
        match self.rival(i, r, choice.root_of) {
            Some((rival_cost, rival)) if rival_cost - cost < options.ambiguous_margin => {
                Verdict::Ambiguous {
                    rival,
                    cost_difference: rival_cost - cost,
                }
            }
            _ => self.by_share(i, r, choice.root_of, options),
        }
    }

    /// Whether row `i` and root `r` are partners without doubt: the root holds enough of the shape,
    /// and nothing else of either side could hold half.
    fn by_share(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
        options: &PairOptions,
    ) -> Verdict {
        let Some(share) = self.candidates[i][r].share else {
            return Verdict::Paired;
        };
        let claim = self.others(i, r, root_of).filter_map(|(other, rival)| {
            let share = other.share.filter(|share| share.part >= HALF)?;
            Some((share.part, rival))
        });
        match claim.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((share, rival)) => Verdict::ContestedShape { rival, share },
            None if share.part - share.std < options.min_mac => Verdict::MixedShape {
                share: share.part,
                std: share.std,
            },
            None => Verdict::Paired,
        }
    }

    /// The cheapest other partner of either side of the pair of row `i` and root `r`.
    fn rival(&self, i: usize, r: usize, root_of: &[Option<usize>]) -> Option<(f64, Competitor)> {
        let others = self.others(i, r, root_of);
        let allowed = others.filter_map(|(other, rival)| Some((other.cost?, rival)));
        allowed.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// All other partners of either side of the pair of row `i` and root `r`.
    fn others(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
    ) -> impl Iterator<Item = (Candidate, Competitor)> {
        let roots = (0..self.roots.len()).filter(move |&other| other != r);
        let of_test = roots.map(move |other| {
            let rival = Competitor::Theory(self.roots[other].modes.clone());
            (self.candidates[i][other], rival)
        });
        let rows = (0..self.modes.len()).filter(move |&other| root_of[other] != Some(r));
        let of_theory = rows.map(move |other| {
            let rival = Competitor::Test(self.modes[other]);
            (self.candidates[other][r], rival)
        });
        of_test.chain(of_theory)
    }

    pub fn unpaired_theory(&self, root_of: &[Option<usize>]) -> Vec<UnpairedRoot> {
        let alone = (0..self.roots.len()).filter(|&r| !root_of.contains(&Some(r)));
        alone
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

    /// Pairs that are not sure, and unmatched test modes whose nearest root in frequency was
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
            let place = Place::Mode(test.modes[mode].frequency_hz);
            let warn = |code| Finding::new(Severity::Warning, code, place);
            if let Some(partner) = partners().find(|partner| partner.test == mode) {
                let finding = doubt(&partner.verdict, options);
                let finding =
                    finding.map(|(code, value, limit)| warn(code).value(value, "").limit(limit));
                findings.extend(finding);
                continue;
            }
            let candidates = self.candidates[i].iter().copied().enumerate();
            let nearest = nearest_in_frequency(candidates).filter(|(_, c)| c.low_mac);
            if let Some(mac) = nearest.and_then(|(_, c)| c.mac) {
                findings.push(warn(Code::LowMac).value(mac, "").limit(options.min_mac));
            }
        }
        findings.extend(self.suggestion(test, root_of, options));
        findings
    }

    /// The stiffness factor that would pair most modes where few are paired.
    fn suggestion(
        &self,
        test: &ModalModel,
        root_of: &[Option<usize>],
        options: &PairOptions,
    ) -> Option<Finding> {
        let hz = |&i: &usize| test.modes[i].frequency_hz;
        let test_hz: Vec<f64> = self.modes.iter().map(hz).collect();
        let roots = self.roots.iter().map(|root| (root.hz, root.modes.len()));
        let of_row = |row: &Vec<Candidate>| row.iter().map(|candidate| candidate.mac).collect();
        let mac: Vec<Vec<Option<f64>>> = self.candidates.iter().map(of_row).collect();
        let unlike = Unlike {
            test_hz: &test_hz,
            roots: &roots.collect::<Vec<_>>(),
            mac: &mac,
            gate: options.max_frequency_error,
        };
        common_factor(&unlike, root_of.iter().flatten().count())
    }
}

/// The finding of a verdict, its value and its limit; `None` of a pair that is sure.
fn doubt(verdict: &Verdict, options: &PairOptions) -> Option<(Code, f64, f64)> {
    match verdict {
        Verdict::Paired => None,
        Verdict::Uncorrelated { mac, level, .. } => Some((Code::BelowChanceLevel, *mac, level.mac)),
        Verdict::RestsOnReversal { mac, .. } => {
            Some((Code::RestsOnReversal, *mac, options.min_mac))
        }
        Verdict::Ambiguous {
            cost_difference, ..
        } => Some((Code::Ambiguous, *cost_difference, options.ambiguous_margin)),
        Verdict::ContestedShape { share, .. } => Some((Code::ClaimedTwice, *share, HALF)),
        Verdict::MixedShape { share, std } => {
            Some((Code::MixedShape, share - std, options.min_mac))
        }
    }
}

/// Correlation of a test shape with a root.
enum Likeness {
    /// MAC and share at the degrees of freedom that both have.
    Of(Option<f64>, Option<ModalContribution>),
    /// Both have too few.
    Unknown,
}

fn candidate(
    frequency_error: f64,
    off: f64,
    likeness: Likeness,
    options: &PairOptions,
) -> Candidate {
    let u = off / options.max_frequency_error;
    let (near, least) = (u <= 1.0, MIN_CONTRIBUTION_OVER_MIN_MAC * options.min_mac);
    let (mac, share) = match likeness {
        Likeness::Of(mac, share) => (mac, share),
        _ => (None, None),
    };
    let alike = share.is_some_and(|share| share.part >= least)
        || mac.is_some_and(|mac| mac >= options.min_mac);
    let of_share = |share: ModalContribution| {
        let v = ((1.0 - share.part) / (1.0 - least)).min(1.0);
        alike.then_some(OF_FREQUENCY * u + (1.0 - OF_FREQUENCY) * v)
    };
    let cost = match likeness {
        Likeness::Of(..) => share.and_then(of_share),
        Likeness::Unknown => Some(u),
    };
    Candidate {
        frequency_error,
        off,
        mac,
        share,
        cost: cost.filter(|_| near),
        low_mac: near && mac.is_some() && !alike,
    }
}

fn nearest_in_frequency(
    candidates: impl Iterator<Item = (usize, Candidate)>,
) -> Option<(usize, Candidate)> {
    candidates.min_by(|a, b| a.1.off.total_cmp(&b.1.off))
}

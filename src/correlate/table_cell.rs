//! A cell of the comparison table holds the test modes paired with a root, or its status and
//! reasons.

use std::collections::BTreeSet;

use crate::finding::{Code, Finding, Location};
use crate::modal::{ModalModel, Mode};

use super::chance::MIN_DOFS_OF_SHAPE;
use super::model_roots::Root;
use super::table_row::{PairedTest, Status, TestCell};
use super::{
    Basis, ChanceLevel, Competitor, ErrorReference, Observability, Pair, PairOptions, PairVerdict,
    Partner, observability,
};

/// Maximum relative spacing of test modes from one pole, whose frequencies differ by rounding.
const MAX_SPACING_OF_ONE_POLE: f64 = 1e-6;

/// Findings that make a test mode a doubtful partner.
const DOUBTFUL_MODES: [Code; 10] = [
    Code::RunsApart,
    Code::LoadedShape,
    Code::CloseModes,
    Code::NotFitted,
    Code::AboveValidBand,
    Code::RepeatsNeighbour,
    Code::WeakerThanMisfit,
    Code::HardlySeparate,
    Code::WeakRepeated,
    Code::ComplexShape,
];

/// A column of the table: a test with the observability of each root.
pub(super) struct TestColumn<'a> {
    test: &'a PairedTest<'a>,
    roots: &'a [Root],
    observability: Vec<Option<Observability>>,
}

impl<'a> TestColumn<'a> {
    /// The column of a test for the roots of a theory.
    pub(super) fn new(theory: &ModalModel, test: &'a PairedTest<'a>, roots: &'a [Root]) -> Self {
        Self {
            observability: observability(theory, test.model, test.frfs),
            test,
            roots,
        }
    }

    /// The cell of root `r`.
    pub(super) fn cell(&self, r: usize, options: &PairOptions) -> TestCell {
        let root = &self.roots[r];
        let observability = self.observability[r].as_ref();
        let cell = match self.test.pair_of(root) {
            Some(pair) => {
                let at_nodes = observability.is_some_and(|observability| observability.at_nodes);
                self.paired_cell(pair, root, at_nodes, options)
            }
            None => self.missed_cell(r, options),
        };
        TestCell {
            observability: observability.cloned(),
            ..cell
        }
    }

    fn paired_cell(
        &self,
        pair: &Pair,
        root: &Root,
        at_nodes: bool,
        options: &PairOptions,
    ) -> TestCell {
        let test = self.test;
        let indices: Vec<usize> = pair.partners.iter().map(|partner| partner.test).collect();
        let macs = pair.partners.iter().filter_map(|partner| partner.mac);
        let cell = test.modes_cell(&indices, Status::Paired);
        let doubt = pair
            .partners
            .iter()
            .find_map(|p| self.verdict_reason(&p.verdict, options));
        let similar = pair.weakest_direction.map(|contribution| {
            let percent = 100.0 * contribution;
            format!(
                "the test shapes are similar: they span {percent:.0} % of one direction of the repeated root, so that one mode may be there twice"
            )
        });
        let ambiguous = doubt.is_some() || similar.is_some();
        let (found, expected) = (indices.len(), root.modes.len());
        let incomplete = (found < expected)
            .then(|| format!("{found} of the {expected} modes of a repeated root"));
        let by_frequency = |partner: &Partner| partner.basis == Basis::Frequency;
        let basis = match pair.partners.iter().any(by_frequency) {
            true => Basis::Frequency,
            false => Basis::Shape,
        };
        let no_mac = pair.partners.iter().all(|partner| partner.mac.is_none());
        let levels = pair
            .partners
            .iter()
            .filter_map(|partner| partner.chance_level);
        let reasons = [
            doubt,
            similar,
            incomplete,
            test.split_reason(&indices),
            basis_reason(basis, no_mac, at_nodes),
        ];
        let reasons = reasons.into_iter().flatten();
        let worst = pair
            .partners
            .iter()
            .max_by(|a, b| a.frequency_error.abs().total_cmp(&b.frequency_error.abs()));
        let worst_mode = worst.map(|partner| &test.model.modes[partner.test]);
        let hz_of_worst = worst_mode.map(|mode| mode.frequency_hz);
        let std_hz = worst_mode.and_then(Mode::frequency_uncertainty_hz);
        TestCell {
            error_percent: worst.map(|partner| 100.0 * partner.frequency_error),
            error_hz: hz_of_worst.map(|hz| match options.error_reference {
                ErrorReference::Theory => hz - root.hz,
                ErrorReference::Test => root.hz - hz,
            }),
            normalised_error: hz_of_worst
                .zip(std_hz.filter(|std| *std > 0.0))
                .map(|(hz, std)| (hz - root.hz) / std),
            mac: macs.reduce(f64::min),
            basis: Some(basis),
            chance_level: levels.max_by(|a, b| a.mac.total_cmp(&b.mac)),
            uncorrelated: pair.partners.iter().any(is_uncorrelated),
            angles_deg: pair.angles_deg.clone(),
            status: if ambiguous {
                Status::Ambiguous
            } else {
                Status::Paired
            },
            reasons: reasons.chain(test.warnings(&indices)).collect(),
            ..cell
        }
    }

    fn verdict_reason(&self, verdict: &PairVerdict, options: &PairOptions) -> Option<String> {
        let (competitor, cost_difference) = match verdict {
            PairVerdict::Paired => return None,
            PairVerdict::Uncorrelated {
                mac,
                level,
                reversed,
            } => {
                return Some(chance_level_reason(*mac, level) + &reversed_mac_clause(*reversed));
            }
            PairVerdict::RestsOnReversal { mac, reversed } => {
                let gate = options.min_mac;
                let measured = format!("the MAC of {mac:.3} as measured is below the gate, {gate}");
                return Some(measured + &reversed_mac_clause(*reversed));
            }
            PairVerdict::MixedShape { contribution, std } => {
                return Some(format!(
                    "the root contributes {:.0} ± {:.0} % of the test shape when all roots explain it together",
                    100.0 * contribution,
                    100.0 * std
                ));
            }
            PairVerdict::ContestedShape {
                competitor,
                contribution,
            } => {
                let (who, percent) = (self.competitor_name(competitor)?, 100.0 * contribution);
                return Some(match competitor {
                    Competitor::Theory(_) => {
                        format!("{who} could contribute {percent:.0} % of the test shape as well")
                    }
                    Competitor::Test(_) => {
                        format!("the root could contribute {percent:.0} % of {who} as well")
                    }
                });
            }
            PairVerdict::Ambiguous {
                competitor,
                cost_difference,
            } => (competitor, cost_difference),
        };
        let who = self.competitor_name(competitor)?;
        let fits = match *cost_difference < 0.0 {
            true => "alone would fit better",
            false => "fits as well",
        };
        Some(format!(
            "{who} {fits} (cost by frequency error and MAC {cost_difference:+.3})"
        ))
    }

    fn competitor_name(&self, competitor: &Competitor) -> Option<String> {
        Some(match competitor {
            Competitor::Theory(modes) => {
                let root = self.roots.iter().find(|root| root.modes == *modes)?;
                format!("the theory's root at {:.2} Hz", root.hz)
            }
            Competitor::Test(i) => {
                let hz = self.test.model.modes[*i].frequency_hz;
                format!("test mode {} at {hz:.2} Hz", i + 1)
            }
        })
    }

    fn missed_cell(&self, r: usize, options: &PairOptions) -> TestCell {
        let (test, root) = (self.test, &self.roots[r]);
        let band = test.model.band;
        if let Some(band) = band.filter(|band| !band.contains(root.hz)) {
            let (lo, hi) = (band.lo_hz, band.hi_hz);
            return TestCell {
                reasons: vec![format!("the test searched {lo} to {hi} Hz")],
                ..test.modes_cell(&[], Status::OutsideBand)
            };
        }
        let no_band = band.is_none().then(|| "the test states no band".to_owned());
        let (status, judged) = self.missed_status(r);
        let reasons = [test.near_miss_reason(root, options), no_band, Some(judged)];
        TestCell {
            reasons: reasons.into_iter().flatten().collect(),
            ..test.modes_cell(&[], status)
        }
    }

    /// Status of an unmatched root inside the band, with its reason.
    fn missed_status(&self, r: usize) -> (Status, String) {
        if self.test.pairing.map.is_still_in_theory() {
            let why = "the model does not move at any sensor of the test, in any mode";
            return (Status::NotObservable, why.to_owned());
        }
        let Some(observability) = &self.observability[r] else {
            let why = "not judged: the test has no pairs of response and hit at which the model has shapes";
            return (Status::MissedUnexpected, why.to_owned());
        };
        if observability.observable() == Some(false) {
            return (Status::NotObservable, observability.reason());
        }
        match self.covering_root(r, observability) {
            Some(reason) => (Status::MissedExpected, reason),
            None => (Status::MissedUnexpected, observability.reason()),
        }
    }

    /// The nearest paired root within one half-power bandwidth, as a reason.
    fn covering_root(&self, r: usize, observability: &Observability) -> Option<String> {
        let hz = self.roots[r].hz;
        let width_hz = 2.0 * observability.damping?.ratio * hz;
        let others = self
            .roots
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != r);
        let paired = others.filter(|(_, other)| self.test.pair_of(other).is_some());
        let distance = |other: &Root| (other.hz - hz).abs();
        let nearest = paired
            .map(|(_, other)| other)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let widths = distance(nearest) / width_hz;
        (widths <= 1.0).then(|| {
            format!(
                "one peak covers it and the paired root at {:.2} Hz, {widths:.2} half-power bandwidths away",
                nearest.hz
            )
        })
    }
}

fn is_uncorrelated(partner: &Partner) -> bool {
    matches!(partner.verdict, PairVerdict::Uncorrelated { .. })
}

/// Clause with the MAC with the reversed sensors corrected.
fn reversed_mac_clause(mac: Option<f64>) -> String {
    mac.map_or_else(String::new, |mac| {
        format!("; with the reversed sensors corrected it is {mac:.3}")
    })
}

/// The reason of a pair whose MAC is below the chance level.
fn chance_level_reason(mac: f64, level: &ChanceLevel) -> String {
    let ChanceLevel {
        dofs, roots, rank, ..
    } = level;
    let effective = if level.effective_dofs < *dofs as f64 - 0.05 {
        format!(", {:.1} effective", level.effective_dofs)
    } else {
        String::new()
    };
    let sensors = format!("{dofs} DOFs{effective}, root {rank} of {roots} in reach");
    // No measured shape has less than a thousandth of noise.
    if level.mac > 0.999 {
        return format!("at these sensors independent shapes have a MAC of 1 as well ({sensors})");
    }
    format!(
        "the MAC of {mac:.3} is below the chance level for independent shapes, {:.3} ({sensors})",
        level.mac
    )
}

/// The reason of a pair that its shapes do not support.
fn basis_reason(basis: Basis, no_mac: bool, at_nodes: bool) -> Option<String> {
    let stands = "these sensors or hits are at nodes of this root in the model: the pair";
    match (basis, at_nodes) {
        (Basis::Frequency, true) => Some(format!(
            "{stands} rests on frequency alone and contradicts the model"
        )),
        (Basis::Frequency, false) if no_mac => {
            Some("paired by frequency alone: no shapes could be compared".to_owned())
        }
        (Basis::Frequency, false) => Some(format!(
            "paired by frequency alone: fewer than {MIN_DOFS_OF_SHAPE} different DOFs in common"
        )),
        (Basis::Shape, true) => Some(format!("{stands} contradicts the model")),
        (Basis::Shape, false) => None,
    }
}

impl PairedTest<'_> {
    fn pair_of(&self, root: &Root) -> Option<&Pair> {
        let mut pairs = self.pairing.pairs.iter();
        pairs.find(|pair| pair.theory == root.modes)
    }

    /// The reason of test modes of one root with different frequencies.
    fn split_reason(&self, indices: &[usize]) -> Option<String> {
        let all = || indices.iter().map(|&i| self.model.modes[i].frequency_hz);
        let (lowest, highest) = (all().reduce(f64::min)?, all().reduce(f64::max)?);
        (highest - lowest > MAX_SPACING_OF_ONE_POLE * highest).then(|| {
            format!(
                "the repeated root is split in the test, from {lowest:.2} to {highest:.2} Hz; the error is that of the farthest"
            )
        })
    }

    /// [`Self::doubts`] as reasons.
    fn warnings(&self, indices: &[usize]) -> Vec<String> {
        let doubts = self.doubts(indices).into_iter();
        doubts
            .map(|code| format!("the test mode is marked {}", code.name()))
            .collect()
    }

    /// Findings of the identification that make these modes doubtful.
    fn doubts(&self, indices: &[usize]) -> Vec<Code> {
        let at_one = |location: &Location| {
            let frequencies = indices.iter().map(|&i| self.model.modes[i].frequency_hz);
            let near =
                |hz: f64| matches!(location, Location::Mode(at) if (at - hz).abs() <= 1e-9 * hz);
            frequencies.into_iter().any(near)
        };
        let doubtful = |finding: &&Finding| DOUBTFUL_MODES.contains(&finding.code);
        let findings = self.model.findings.iter().filter(doubtful);
        let all: BTreeSet<Code> = findings
            .filter(|finding| at_one(&finding.location))
            .map(|finding| finding.code)
            .collect();
        all.into_iter().collect()
    }

    /// The test mode nearest in frequency, where it was rejected for its MAC.
    fn near_miss_reason(&self, root: &Root, options: &PairOptions) -> Option<String> {
        let mut unpaired = self.pairing.unpaired_theory.iter();
        let row = unpaired.find(|other| other.theory == root.modes)?;
        let miss = row.near_miss.as_ref()?;
        let hz = self.model.modes[miss.test].frequency_hz;
        let (number, mac, gate) = (miss.test + 1, miss.mac, options.min_mac);
        Some(format!(
            "test mode {number} at {hz:.2} Hz has a MAC of {mac:.3}, below {gate}"
        ))
    }

    /// A cell with the values of some test modes, without a comparison.
    pub(super) fn modes_cell(&self, indices: &[usize], status: Status) -> TestCell {
        let modes: Vec<&Mode> = indices.iter().map(|&i| &self.model.modes[i]).collect();
        let collect = |value: fn(&Mode) -> Option<f64>| -> Option<Vec<f64>> {
            modes.iter().map(|mode| value(mode)).collect()
        };
        TestCell {
            test: self.name.to_owned(),
            modes: indices.iter().map(|i| i + 1).collect(),
            hz: collect(|mode| Some(mode.frequency_hz)).and_then(mean),
            hz_std: collect(|mode| mode.frequency_std_hz).and_then(std_of_mean),
            error_percent: None,
            error_hz: None,
            normalised_error: None,
            damping_ratio: collect(|mode| mode.damping_ratio).and_then(mean),
            damping_std: collect(|mode| mode.damping_std).and_then(std_of_mean),
            mac: None,
            basis: None,
            chance_level: None,
            uncorrelated: false,
            angles_deg: None,
            status,
            doubts: self.doubts(indices),
            reasons: Vec::new(),
            observability: None,
        }
    }
}

/// Mean of some values; `None` of none.
pub(super) fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn std_of_mean(values: Vec<f64>) -> Option<f64> {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (!values.is_empty()).then(|| squares.sqrt() / values.len() as f64)
}

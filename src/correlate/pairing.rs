//! Pairing of test modes with the roots of a theory.
//!
//! All pairs are decided together: an assignment of smallest total cost, in which a mode may stay alone. Complex test
//! shapes are used as they are; they are not made real first.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Place, Severity};
use crate::modal::ModalModel;

use super::roots::{Root, check_model, elastic_modes, elastic_roots};
use super::share::share;
use super::subspace::{principal_angles_deg, subspace_mac};
use super::{CorrelateError, DofMap, PairOptions, assign};

/// Cost of a pair at both gates, and of leaving a test mode and a theory mode over: a pair inside its gates is never dearer.
const ALONE: f64 = 1.0;

/// Least share of a test shape, over `min_mac`, that makes a root a partner at all.
const LEAST_SHARE: f64 = 0.6;

/// Weight of the frequency beside the shape.
const OF_FREQUENCY: f64 = 0.1;

/// Fewest common degrees of freedom on which a MAC says anything.
const FEWEST_DOFS: usize = 2;

/// Who else fits as well.
#[derive(Clone, Debug, PartialEq)]
pub enum Rival {
    /// Another root of the theory, by the indices of its modes.
    Theory(Vec<usize>),
    /// Another mode of the test, by its index.
    Test(usize),
}

/// How sure a pair is.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// No other partner of either side is as good.
    Paired,
    /// A rival costs less than the margin more.
    Ambiguous {
        /// The cheapest rival.
        rival: Rival,
        /// Its cost minus the pair's; negative when the rival is better by itself and the whole decided against it.
        cost_difference: f64,
    },
    /// No root holds enough of the test shape.
    Mixed {
        /// The part that the paired root holds.
        share: f64,
    },
}

/// A test mode as the partner of a root.
#[derive(Clone, Debug, PartialEq)]
pub struct Partner {
    /// Index of the test mode.
    pub test: usize,
    /// Signed frequency error, a fraction, by the options' reference.
    pub frequency_error: f64,
    /// MAC, for a repeated root that with its subspace; `None` when paired by frequency alone.
    pub mac: Option<f64>,
    /// Cost of the pair, from 0 to 1.
    pub cost: f64,
    /// How sure it is.
    pub verdict: Verdict,
}

/// A root of the theory with its partners.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Indices of the theory modes; several for a repeated root.
    pub theory: Vec<usize>,
    /// Its test modes in ascending index, from one to the multiplicity of the root.
    pub partners: Vec<Partner>,
    /// Principal angles between the test modes and the subspace of a repeated root, ascending, degrees; `None` for a simple
    /// root or without shapes.
    pub angles_deg: Option<Vec<f64>>,
}

/// A mode within the frequency gate that was refused for its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct NearMiss {
    /// Index of the test mode.
    pub test: usize,
    /// Its MAC, below the gate.
    pub mac: f64,
}

/// A root of the theory without a partner.
#[derive(Clone, Debug, PartialEq)]
pub struct UnpairedRoot {
    /// Indices of the theory modes.
    pub theory: Vec<usize>,
    /// The test mode nearest in frequency, when it was refused for its MAC.
    pub near_miss: Option<NearMiss>,
}

/// Who belongs to whom between one test and one theory. Indices are those of the two models' mode lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// The common degrees of freedom.
    pub map: DofMap,
    /// MAC of every test mode (row) with every theory mode (column) by itself; `None` where one has no shape
    /// there or fewer than two degrees of freedom are common.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Roots with partners, in ascending theory frequency.
    pub pairs: Vec<Pair>,
    /// Roots without, in ascending frequency.
    pub unpaired_theory: Vec<UnpairedRoot>,
    /// Test modes without a partner, ascending.
    pub unpaired_test: Vec<usize>,
    /// Theory modes at 0 Hz, which are never paired.
    pub rigid_theory: usize,
    /// Number of theory modes.
    pub theory_modes: usize,
    /// What the shapes and frequencies said on the way.
    pub findings: Vec<Finding>,
}

/// Pairs the modes of a test with those of a theory.
///
/// With `u = |frequency error| / max_frequency_error` and the share `a` of a test shape that a root holds when all roots explain it
/// together (their own module has the formula), a pair is allowed when
/// `u <= 1` and `a >= 0.6 min_mac` or the MAC at the sensors reaches `min_mac`. It costs `0.1 u + 0.9 v`, `v = (1 - a)/(1 - 0.6 min_mac)`
/// up to 1: what the frequency says of mixed shapes is in `a` already. With fewer than two degrees of freedom in common it costs `u`: a
/// MAC over one component is 1 for any two shapes, and says nothing. Leaving a test mode and a theory mode over
/// costs 1 together, so that a pair inside its gates is made rather than not, and a missed mode moves no other row as long
/// as moving costs more than that. The sum is made smallest over all pairs at once. A pair is ambiguous when, for either
/// side, another allowed partner costs less than `ambiguous_margin` more, and mixed when `a` is below `min_mac`.
///
/// Modes of one repeated root of the theory (same group number) are one partner that takes as many test modes as it has
/// modes, by [`subspace_mac`]. Modes at 0 Hz, of either side, are left out.
///
/// # Errors
/// [`CorrelateError::Option`], [`CorrelateError::Frequency`], [`CorrelateError::ShapeValue`],
/// [`CorrelateError::MixedUnits`], [`CorrelateError::Linalg`].
///
/// # Reference
/// Allemang and Brown (1982), A correlation coefficient for modal vector analysis, IMAC 1 (MAC); Kuhn (1955) (assignment).
pub fn pair(
    test: &ModalModel,
    theory: &ModalModel,
    options: &PairOptions,
) -> Result<Pairing, CorrelateError> {
    options.validate()?;
    check_model("test", test)?;
    check_model("theory", theory)?;
    let map = DofMap::of_models(test, theory);
    let shapes = Shapes::new(test, theory, &map, options)?;
    let table = CandidateTable::new(test, theory, &shapes, options);
    let root_of = table.assign();
    let mut findings = map.findings(options.min_dofs);
    findings.extend(table.findings(test, &root_of, options));
    let elastic_count: usize = table.roots.iter().map(|root| root.modes.len()).sum();
    Ok(Pairing {
        mac: shapes.mac_matrix(),
        pairs: table.pairs(&root_of, &shapes, options)?,
        unpaired_theory: table.unpaired_theory(&root_of),
        unpaired_test: table.unpaired_test(&root_of),
        rigid_theory: theory.modes.len() - elastic_count,
        theory_modes: theory.modes.len(),
        map,
        findings,
    })
}

/// Values of every mode at the common degrees of freedom, signs turned and rotations weighed.
pub(super) struct Shapes {
    pub test: Vec<Vec<Option<Complex64>>>,
    pub theory: Vec<Vec<Option<Complex64>>>,
}

impl Shapes {
    pub fn new(
        test: &ModalModel,
        theory: &ModalModel,
        map: &DofMap,
        options: &PairOptions,
    ) -> Result<Self, CorrelateError> {
        let weights = map.weights(options)?;
        let of_test = test.modes.iter();
        let of_theory = theory.modes.iter();
        let theory = of_theory.map(|m| map.theory_values(&m.shape, &weights));
        Ok(Self {
            test: of_test
                .map(|m| map.test_values(&m.shape, &weights))
                .collect(),
            theory: without_rounding(theory.collect()),
        })
    }

    /// The test and theory vectors on the degrees of freedom at which all of these modes have a value.
    pub fn common(&self, test: &[usize], theory: &[usize]) -> [Vec<Vec<Complex64>>; 2] {
        let all = || {
            let test = test.iter().map(|&i| &self.test[i]);
            test.chain(theory.iter().map(|&j| &self.theory[j]))
        };
        let count = all().next().map_or(0, Vec::len);
        let kept: Vec<usize> = (0..count)
            .filter(|&d| all().all(|values| values[d].is_some()))
            .collect();
        let vector =
            |values: &Vec<Option<Complex64>>| kept.iter().filter_map(|&d| values[d]).collect();
        [
            test.iter().map(|&i| vector(&self.test[i])).collect(),
            theory.iter().map(|&j| vector(&self.theory[j])).collect(),
        ]
    }

    /// Whether a test mode and a root have the degrees of freedom in common that a MAC needs, and the MAC there (`None`
    /// for a zero vector).
    fn compare(&self, test: usize, theory: &[usize]) -> (bool, Option<f64>) {
        let [vector, span] = self.common(&[test], theory);
        let comparable = vector[0].len() >= FEWEST_DOFS;
        let mac = comparable.then(|| subspace_mac(&vector[0], &span));
        (comparable, mac.flatten())
    }

    /// Principal angles between test modes and a root; none where there are too few degrees of freedom for a MAC.
    fn angles_deg(&self, test: &[usize], theory: &[usize]) -> Result<Vec<f64>, CorrelateError> {
        let [test, theory] = self.common(test, theory);
        match test[0].len() {
            0..FEWEST_DOFS => Ok(Vec::new()),
            _ => principal_angles_deg(&test, &theory),
        }
    }

    /// At how many degrees of freedom a test and a theory mode have values.
    pub fn common_count(&self, test: usize, theory: usize) -> usize {
        let both = self.test[test].iter().zip(&self.theory[theory]);
        both.filter(|(a, b)| a.is_some() && b.is_some()).count()
    }

    pub fn mac_matrix(&self) -> Vec<Vec<Option<f64>>> {
        let row = |i| {
            (0..self.theory.len())
                .map(|j| self.compare(i, &[j]).1)
                .collect()
        };
        (0..self.test.len()).map(row).collect()
    }
}

/// A theory's values with exact zeros where a mode stands still: below a part of the largest value that any mode has there,
/// only rounding is left, and rounding has every shape.
pub(super) fn without_rounding(
    mut modes: Vec<Vec<Option<Complex64>>>,
) -> Vec<Vec<Option<Complex64>>> {
    /// An eigenvector is known to about 1e-14 of its largest component.
    const ROUNDING: f64 = 1e-10;
    let count = modes.first().map_or(0, Vec::len);
    for d in 0..count {
        let values = modes.iter().filter_map(|values| values[d]);
        let limit = ROUNDING * values.map(Complex64::norm).fold(0.0, f64::max);
        for value in modes.iter_mut().filter_map(|values| values[d].as_mut()) {
            if value.norm() < limit {
                *value = Complex64::ZERO;
            }
        }
    }
    modes
}

/// What a test mode and a root are to each other.
#[derive(Clone, Copy)]
struct Candidate {
    frequency_error: f64,
    mac: Option<f64>,
    /// The part of the test shape that the root holds.
    share: Option<f64>,
    /// `None` when a gate forbids the pair.
    cost: Option<f64>,
    /// Inside the frequency gate, with a MAC under its gate and no other claim.
    low_mac: bool,
}

/// Every elastic test mode against every elastic root.
struct CandidateTable {
    modes: Vec<usize>,
    roots: Vec<Root>,
    candidates: Vec<Vec<Candidate>>,
}

impl CandidateTable {
    fn new(test: &ModalModel, theory: &ModalModel, shapes: &Shapes, options: &PairOptions) -> Self {
        let (modes, roots) = (elastic_modes(test), elastic_roots(theory));
        let candidate = |i: usize, r: usize| {
            let root = &roots[r];
            let hz = test.modes[i].frequency_hz;
            let error = options.error_reference.error(hz, root.hz);
            let near = error.abs() <= options.max_frequency_error;
            let (comparable, mac) = shapes.compare(i, &root.modes);
            let share = || share((theory, shapes), i, (r, &roots));
            let alike = comparable.then(|| (mac, near.then(share).flatten()));
            candidate(error, alike, options)
        };
        let row = |&i: &usize| (0..roots.len()).map(|r| candidate(i, r)).collect();
        Self {
            candidates: modes.iter().map(row).collect(),
            modes,
            roots,
        }
    }

    /// The root of every row; a repeated root stands in as many columns as it has modes.
    fn assign(&self) -> Vec<Option<usize>> {
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

    fn pairs(
        &self,
        root_of: &[Option<usize>],
        shapes: &Shapes,
        options: &PairOptions,
    ) -> Result<Vec<Pair>, CorrelateError> {
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
            let partner = |&i: &usize| self.partner(i, r, root_of, options);
            pairs.push(Pair {
                theory: root.modes.clone(),
                partners: rows.iter().map(partner).collect(),
                angles_deg: (!angles.is_empty()).then_some(angles),
            });
        }
        Ok(pairs)
    }

    fn partner(
        &self,
        i: usize,
        r: usize,
        root_of: &[Option<usize>],
        options: &PairOptions,
    ) -> Partner {
        let chosen = self.candidates[i][r];
        let cost = chosen.cost.expect("only allowed pairs are assigned");
        let verdict = match self.rival(i, r, root_of) {
            Some((rival_cost, rival)) if rival_cost - cost < options.ambiguous_margin => {
                Verdict::Ambiguous {
                    rival,
                    cost_difference: rival_cost - cost,
                }
            }
            _ => match chosen.share {
                Some(share) if share < options.min_mac => Verdict::Mixed { share },
                _ => Verdict::Paired,
            },
        };
        Partner {
            test: self.modes[i],
            frequency_error: chosen.frequency_error,
            mac: chosen.mac,
            cost,
            verdict,
        }
    }

    /// The cheapest other partner of either side of the pair of row `i` and root `r`.
    fn rival(&self, i: usize, r: usize, root_of: &[Option<usize>]) -> Option<(f64, Rival)> {
        let roots = (0..self.roots.len()).filter(|&other| other != r);
        let of_test = roots.filter_map(|other| {
            let rival = || Rival::Theory(self.roots[other].modes.clone());
            self.candidates[i][other].cost.map(|cost| (cost, rival()))
        });
        let rows = (0..self.modes.len()).filter(|&other| root_of[other] != Some(r));
        let of_theory = rows.filter_map(|other| {
            let rival = Rival::Test(self.modes[other]);
            self.candidates[other][r].cost.map(|cost| (cost, rival))
        });
        of_test.chain(of_theory).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn unpaired_theory(&self, root_of: &[Option<usize>]) -> Vec<UnpairedRoot> {
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

    fn unpaired_test(&self, root_of: &[Option<usize>]) -> Vec<usize> {
        let rows = self.modes.iter().zip(root_of);
        rows.filter(|(_, root)| root.is_none())
            .map(|(&i, _)| i)
            .collect()
    }

    /// Ambiguous pairs, and test modes left over whose nearest root in frequency was refused for its MAC.
    fn findings(
        &self,
        test: &ModalModel,
        root_of: &[Option<usize>],
        options: &PairOptions,
    ) -> Vec<Finding> {
        let mut findings = Vec::new();
        for (i, root) in root_of.iter().enumerate() {
            let place = Place::Mode(test.modes[self.modes[i]].frequency_hz);
            let warn = |code| Finding::new(Severity::Warning, code, place);
            if let Some(r) = root {
                let finding = match self.partner(i, *r, root_of, options).verdict {
                    Verdict::Paired => None,
                    Verdict::Ambiguous {
                        cost_difference, ..
                    } => Some((Code::Ambiguous, cost_difference, options.ambiguous_margin)),
                    Verdict::Mixed { share } => Some((Code::MixedShape, share, options.min_mac)),
                };
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
        findings
    }
}

/// `shapes` are the MAC and the share, where the two have enough in common.
fn candidate(
    frequency_error: f64,
    shapes: Option<(Option<f64>, Option<f64>)>,
    options: &PairOptions,
) -> Candidate {
    let u = frequency_error.abs() / options.max_frequency_error;
    let (near, least) = (u <= 1.0, LEAST_SHARE * options.min_mac);
    let (mac, share) = shapes.unwrap_or_default();
    let share = share.or(mac);
    let alike = share.is_some_and(|a| a >= least) || mac.is_some_and(|mac| mac >= options.min_mac);
    let cost = match (shapes, share) {
        (None, _) => Some(u),
        (Some(_), Some(a)) => {
            let v = ((1.0 - a) / (1.0 - least)).min(1.0);
            alike.then_some(OF_FREQUENCY * u + (1.0 - OF_FREQUENCY) * v)
        }
        (Some(_), None) => None,
    };
    Candidate {
        frequency_error,
        mac,
        share,
        cost: cost.filter(|_| near),
        low_mac: near && mac.is_some() && !alike,
    }
}

fn nearest_in_frequency(
    candidates: impl Iterator<Item = (usize, Candidate)>,
) -> Option<(usize, Candidate)> {
    candidates.min_by(|a, b| {
        let error = |c: &Candidate| c.frequency_error.abs();
        error(&a.1).total_cmp(&error(&b.1))
    })
}

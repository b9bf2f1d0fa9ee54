//! Pairing of test modes with the roots of a theory.
//!
//! All pairs are decided together: an assignment of smallest total cost, in which a mode may stay
//! alone. Complex test shapes are used without conversion to real ones.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::finding::{Code, Finding, Place, Severity};
use crate::linalg::{ComplexMatrix, adjoint_product, complex_matrix, singular_values};
use crate::modal::ModalModel;

use super::candidates::CandidateTable;
use super::chance::ChanceLevel;
use super::model_roots::{Root, check_model, highest_rigid_hz};
use super::reversed_sensors::{ReversedSensor, detect, reversed_findings, signs};
use super::subspace::{principal_angles_deg, subspace_mac};
use super::{CorrelateError, DofMap, PairOptions};

/// Minimum singular value of the unit shapes of a root whose directions the sensors separate.
const MIN_SINGULAR_VALUE: f64 = 0.1;

/// Minimum number of common degrees of freedom of a meaningful MAC.
pub(super) const MIN_SHAPE_DOFS: usize = 2;

/// Who else fits as well.
#[derive(Clone, Debug, PartialEq)]
pub enum Competitor {
    /// Another root of the theory, by the indices of its modes.
    Theory(Vec<usize>),
    /// Another mode of the test, by its index.
    Test(usize),
}

/// Verdict on a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// No other partner of either side is as good.
    Paired,
    /// The MAC is below the chance level: independent shapes correlate as well.
    Uncorrelated {
        /// MAC of the pair.
        mac: f64,
        /// Level that it does not reach.
        level: ChanceLevel,
        /// MAC with the reversed sensors corrected, where that reaches the level.
        reversed: Option<f64>,
    },
    /// Sensors are reversed, and the MAC of the shapes as measured is below the gate: only with
    /// these sensors reversed is this a pair.
    RestsOnReversal {
        /// MAC of the shapes as measured.
        mac: f64,
        /// MAC with the reversed sensors corrected.
        reversed: Option<f64>,
    },
    /// A competitor costs at most the margin more.
    Ambiguous {
        /// The competitor of lowest cost.
        rival: Competitor,
        /// Its cost minus the pair's; negative when the competitor alone is better and the
        /// assignment of all modes decided against it.
        cost_difference: f64,
    },
    /// Another root explains half of the test shape or more, or the root as much of another test
    /// shape: both cannot be right.
    ContestedShape {
        /// The competitor with the largest contribution.
        rival: Competitor,
        /// Its contribution, or that of the root to it.
        share: f64,
    },
    /// The contribution of the root to the test shape, less its standard deviation, is too small.
    MixedShape {
        /// Contribution of the paired root.
        share: f64,
        /// Its standard deviation.
        std: f64,
    },
}

/// Evidence on which a pair rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Frequency and shape.
    Shape,
    /// Frequency alone: fewer than three degrees of freedom are in common, or there are no shapes.
    Frequency,
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
    /// Chance level of that MAC; `None` with fewer than three degrees of freedom in common.
    pub chance_level: Option<ChanceLevel>,
    /// Evidence on which the pair rests.
    pub basis: Basis,
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
    /// Principal angles between the test modes and the subspace of a repeated root, ascending,
    /// degrees; `None` for a simple root or without shapes.
    pub angles_deg: Option<Vec<f64>>,
    /// Share of the least direction of the root that several test modes hold together where that is
    /// below a quarter (60 degrees): two of them may be one mode.
    pub least_direction: Option<f64>,
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

/// Who belongs to whom between one test and one theory. Indices are those of the two models' mode
/// lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// The common degrees of freedom.
    pub map: DofMap,
    /// MAC of every test mode (row) with every theory mode (column) alone; `None` where one has
    /// no shape there or fewer than two degrees of freedom are common.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Roots with partners, in ascending theory frequency.
    pub pairs: Vec<Pair>,
    /// Roots without, in ascending frequency.
    pub unpaired_theory: Vec<UnpairedRoot>,
    /// Test modes without a partner, ascending.
    pub unpaired_test: Vec<usize>,
    /// Rigid-body modes of the theory, which are never paired.
    pub rigid_theory: usize,
    /// The highest frequency of one, Hz; 0 where there is none.
    pub highest_rigid_hz: f64,
    /// Number of theory modes.
    pub theory_modes: usize,
    /// Sensors with the opposite sign of the theory. Pairs are chosen with these reversed; MAC is
    /// of the shapes as measured.
    pub reversed: Vec<ReversedSensor>,
    /// Findings on shapes and frequencies.
    pub findings: Vec<Finding>,
}

/// Pairs the modes of a test with those of a theory.
///
/// With `u = |f_test − f_theory| / (max_frequency_error f_theory)`, whatever the options' reference
/// of errors is, and the share `a` of a test shape that a root holds when all roots explain it
/// together (formula in `modal_contribution`), a pair is allowed when `u <= 1` and `a >= 0.6
/// min_mac` or the MAC at the sensors reaches `min_mac`. It costs `0.1 u + 0.9 v`, `v = (1 -
/// a)/(1 - 0.6 min_mac)` up to 1: what the frequency says of mixed shapes is in `a` already. With
/// fewer than three degrees of freedom in common it costs `u`: a MAC over one component is 1 for
/// any two shapes, and over two independent shapes reach 0.9 in a fifth of all cases. Leaving a
/// test mode and a theory mode over costs 1 together, so that a pair inside its gates is made
/// rather than not, and a missed mode moves no other row as long as moving costs more than that.
/// The sum is made smallest over all pairs at once.
///
/// A pair with three degrees of freedom in common or more rests on frequency and shape
/// ([`Basis::Shape`]): its MAC has to reach the [`ChanceLevel`], else it is uncorrelated. With
/// fewer it rests on frequency alone. A pair is ambiguous when, for either side, another allowed
/// partner costs less than `ambiguous_margin` more; claimed when another root holds half of the
/// shape by the same reckoning, or this root half of another; and mixed when `a` less its standard
/// deviation is below `min_mac`.
///
/// Sensors and groups with the opposite sign of the theory ([`super::measures::reversed_sensors`])
/// are reversed while pairs are chosen; MAC and chance level are of the shapes as measured. The
/// shares are then those of the reversed shapes, so that the MAC as measured has to reach `min_mac`
/// as well, else the pair is ambiguous.
///
/// Modes of one repeated root of the theory (same group number) are one partner that takes as many
/// test modes as it has modes, by [`subspace_mac`]. Rigid-body modes of the theory, and test modes
/// at 0 Hz, are left out: modes at 0 Hz and, of the lowest six, those at 0.1 Hz or less below a
/// thousandth of the next one.
///
/// # Errors
/// [`CorrelateError::Option`], [`CorrelateError::Frequency`], [`CorrelateError::ShapeValue`],
/// [`CorrelateError::MixedUnits`], [`CorrelateError::Linalg`].
///
/// # Reference
/// Allemang and Brown (1982), A correlation coefficient for modal vector analysis, IMAC 1 (MAC);
/// Kuhn (1955) (assignment).
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
    let reversed = detect((test, theory), &map, &shapes, options);
    let table = CandidateTable::new(
        test,
        theory,
        &shapes.reversed(&signs(&map, &reversed)),
        options,
    );
    let root_of = table.assign();
    // Without any shape of the theory no DOFs are matched; the rows state that modes are paired by
    // frequency alone.
    let has_shapes = theory.modes.iter().any(|mode| !mode.shape.is_empty());
    let mut findings = Vec::new();
    if has_shapes {
        findings.extend(map.findings(options.min_dofs));
    }
    let pairs = table.pairs(&root_of, (&shapes, !reversed.is_empty()), options)?;
    findings.extend(reversed_findings(&reversed, false));
    findings.extend(table.findings(test, (&root_of, &pairs), options));
    findings.extend(pairs.iter().filter_map(|pair| alike(pair, test)));
    let elastic_count: usize = table.roots.iter().map(|root| root.modes.len()).sum();
    Ok(Pairing {
        mac: shapes.mac_matrix(),
        pairs,
        unpaired_theory: table.unpaired_theory(&root_of),
        unpaired_test: table.unpaired_test(&root_of),
        rigid_theory: theory.modes.len() - elastic_count,
        highest_rigid_hz: highest_rigid_hz(theory),
        theory_modes: theory.modes.len(),
        map,
        reversed,
        findings,
    })
}

/// Minimum contribution of the partners of a repeated root to each of its directions; similar
/// shapes have less.
pub(super) const MIN_DIRECTION_CONTRIBUTION: f64 = 0.25;

/// The finding of partners of a repeated root whose shapes are alike, at the highest of them.
fn alike(pair: &Pair, test: &ModalModel) -> Option<Finding> {
    let share = pair.least_direction?;
    let place = Place::Mode(test.modes[pair.partners.last()?.test].frequency_hz);
    let finding = Finding::new(Severity::Warning, Code::AlikePartners, place);
    Some(finding.value(share, "").limit(MIN_DIRECTION_CONTRIBUTION))
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

    /// The same with the test's values times these signs.
    pub fn reversed(&self, signs: &[f64]) -> Self {
        let signed = |shape: &Vec<Option<Complex64>>| {
            let values = shape.iter().zip(signs);
            values
                .map(|(value, sign)| value.map(|v| v * *sign))
                .collect()
        };
        Self {
            test: self.test.iter().map(signed).collect(),
            theory: self.theory.clone(),
        }
    }

    /// Shapes of all modes of some roots of the theory.
    pub fn of_roots(&self, roots: &[Root]) -> Vec<Vec<Option<Complex64>>> {
        let modes = roots.iter().flat_map(|root| &root.modes);
        modes.map(|&j| self.theory[j].clone()).collect()
    }

    /// The degrees of freedom at which all of these modes have a value.
    pub fn places(&self, test: &[usize], theory: &[usize]) -> Vec<usize> {
        let all = || {
            let test = test.iter().map(|&i| &self.test[i]);
            test.chain(theory.iter().map(|&j| &self.theory[j]))
        };
        let count = all().next().map_or(0, Vec::len);
        (0..count)
            .filter(|&d| all().all(|values| values[d].is_some()))
            .collect()
    }

    /// The test and theory vectors on the degrees of freedom at which all of these modes have a
    /// value.
    pub fn common(&self, test: &[usize], theory: &[usize]) -> [Vec<Vec<Complex64>>; 2] {
        let kept = self.places(test, theory);
        let vector =
            |values: &Vec<Option<Complex64>>| kept.iter().filter_map(|&d| values[d]).collect();
        [
            test.iter().map(|&i| vector(&self.test[i])).collect(),
            theory.iter().map(|&j| vector(&self.theory[j])).collect(),
        ]
    }

    /// Whether a test mode and a root have the degrees of freedom in common that a MAC needs, and
    /// the MAC there (`None` for a zero vector).
    pub fn compare(&self, test: usize, theory: &[usize]) -> (bool, Option<f64>) {
        let [vector, span] = self.common(&[test], theory);
        let comparable = vector[0].len() >= MIN_SHAPE_DOFS;
        let mac = comparable.then(|| subspace_mac(&vector[0], &span));
        (comparable, mac.flatten())
    }

    /// Principal angles between test modes and a root; none where there are too few degrees of
    /// freedom for a MAC.
    pub fn angles_deg(&self, test: &[usize], theory: &[usize]) -> Result<Vec<f64>, CorrelateError> {
        let [test, theory] = self.common(test, theory);
        match test[0].len() {
            0..MIN_SHAPE_DOFS => Ok(Vec::new()),
            _ => principal_angles_deg(&test, &theory),
        }
    }

    /// Share of the least direction of a root that test modes hold together, `cos²` of the largest
    /// principal angle: 0 where they have fewer directions than modes. `None` for one mode, where
    /// these degrees of freedom do not separate the directions of the root (its unit shapes have a
    /// singular value below [`MIN_SINGULAR_VALUE`]), or where they are no more than the modes of
    /// the root.
    ///
    /// # Errors
    /// [`CorrelateError::Linalg`].
    pub fn least_direction(
        &self,
        test: &[usize],
        theory: &[usize],
    ) -> Result<Option<f64>, CorrelateError> {
        if test.len() < 2 {
            return Ok(None);
        }
        let [modes, root] = self.common(test, theory);
        let dofs = modes[0].len();
        if dofs <= theory.len() {
            return Ok(None);
        }
        let norm = |shape: &[Complex64]| shape.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        let unit = complex_matrix(dofs, theory.len(), |dof, mode| {
            root[mode][dof] / norm(&root[mode]).max(f64::MIN_POSITIVE)
        });
        let values = singular_values(&unit)?;
        if values
            .last()
            .is_none_or(|least| *least < MIN_SINGULAR_VALUE)
        {
            return Ok(None);
        }
        let angles = principal_angles_deg(&modes, &root)?;
        let largest = angles.last().filter(|_| angles.len() == test.len());
        Ok(Some(
            largest.map_or(0.0, |angle| angle.to_radians().cos().powi(2)),
        ))
    }

    /// At how many degrees of freedom a test and a theory mode have values.
    pub fn common_count(&self, test: usize, theory: usize) -> usize {
        let both = self.test[test].iter().zip(&self.theory[theory]);
        both.filter(|(a, b)| a.is_some() && b.is_some()).count()
    }

    /// The number of degrees of freedom, where every mode of both has a value at each.
    pub fn count_of_all(&self) -> Option<usize> {
        let mut all = self.test.iter().chain(&self.theory);
        let count = self.test.first().and(self.theory.first())?.len();
        all.all(|shape| shape.iter().all(Option::is_some))
            .then_some(count)
    }

    /// MAC of every test mode with every theory mode; one product of matrices where all modes have
    /// all values.
    pub fn mac_matrix(&self) -> Vec<Vec<Option<f64>>> {
        if let (Some(test), Some(theory)) = (whole(&self.test), whole(&self.theory)) {
            return mac_of_product(&test, &theory);
        }
        let row = |i| {
            (0..self.theory.len())
                .map(|j| self.compare(i, &[j]).1)
                .collect()
        };
        (0..self.test.len()).map(row).collect()
    }
}

/// Shapes as columns, where none misses a value and there are enough for a MAC.
fn whole(shapes: &[Vec<Option<Complex64>>]) -> Option<ComplexMatrix> {
    let points = shapes.first()?.len();
    let full = |shape: &Vec<Option<Complex64>>| shape.iter().all(Option::is_some);
    let value = |p: usize, c: usize| shapes[c][p].unwrap_or_default();
    (points >= MIN_SHAPE_DOFS && shapes.iter().all(full))
        .then(|| complex_matrix(points, shapes.len(), value))
}

/// `|a^H b|²/(a^H a · b^H b)` of all columns, a of the rows.
fn mac_of_product(rows: &ComplexMatrix, columns: &ComplexMatrix) -> Vec<Vec<Option<f64>>> {
    let squares = |of: &ComplexMatrix| -> Vec<f64> {
        let column = |c: usize| (0..of.nrows()).map(|p| of[(p, c)].norm_sqr()).sum();
        (0..of.ncols()).map(column).collect()
    };
    let (a, b) = (squares(rows), squares(columns));
    let products = adjoint_product(rows, columns.as_ref());
    let mac = |i: usize, j: usize| {
        let known = a[i] > 0.0 && b[j] > 0.0;
        known.then(|| (products[(i, j)].norm_sqr() / a[i] / b[j]).min(1.0))
    };
    let row = |i: usize| (0..b.len()).map(|j| mac(i, j)).collect();
    (0..a.len()).map(row).collect()
}

/// A theory's values with exact zeros where a mode stands still: below a part of the largest value
/// that any mode has there, only rounding is left, and rounding has every shape.
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

//! Pairing of test modes with the roots of a theory.
//!
//! All pairs are found together, as the assignment of smallest total cost, in which a mode may stay
//! unpaired. Complex test shapes are used without conversion to real ones.

use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::ModalModel;

use super::candidates::CandidateTable;
use super::mislabelled::reversed_order;
use super::model_roots::{check_model, highest_rigid_hz};
use super::partner::{MIN_DIRECTION_CONTRIBUTION, Pair, UnpairedRoot};
use super::reversed_sensors::{ReversedSensor, detect, reversed_findings, signs};
use super::shape_match::{ShapeMatch, shapes_agree_finding};
use super::shapes::Shapes;
use super::{CorrelateError, DofMap, PairOptions};

/// Assignment of the modes of a test to the roots of a theory. Indices are those of the two models'
/// mode lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairing {
    /// Common degrees of freedom.
    pub map: DofMap,
    /// MAC of every test mode (row) with every single theory mode (column); `None` where one has
    /// no shape there or fewer than two degrees of freedom are common.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Roots with partners, in ascending theory frequency.
    pub pairs: Vec<Pair>,
    /// Roots without partners, in ascending frequency.
    pub unpaired_theory: Vec<UnpairedRoot>,
    /// Test modes without a partner, ascending.
    pub unpaired_test: Vec<usize>,
    /// Rigid-body modes of the theory, which are never paired.
    pub rigid_theory: usize,
    /// The highest frequency of a rigid-body mode, Hz; 0 where there is none.
    pub highest_rigid_hz: f64,
    /// Number of theory modes.
    pub theory_modes: usize,
    /// Sensors with the opposite sign of the theory. Pairs are chosen with these reversed; MAC is
    /// of the shapes as measured.
    pub reversed: Vec<ReversedSensor>,
    /// Modes of test and theory whose shapes agree at other frequencies; only where no mode is
    /// paired.
    pub by_shape_alone: Vec<ShapeMatch>,
    /// Findings on shapes and frequencies.
    pub findings: Vec<Finding>,
}

/// Pairs the modes of a test with those of a theory.
///
/// With `u = |f_test − f_theory| / (max_frequency_error f_theory)`, whatever the options' reference
/// of errors is, and the modal contribution `a` of a root to a test shape (formula in
/// `modal_contribution`), a pair is allowed when `u <= 1` and `a >= 0.6 min_mac` or the MAC at the
/// sensors reaches `min_mac`. It costs `0.1 u + 0.9 v`, `v = (1 - a)/(1 - 0.6 min_mac)` up to 1:
/// the weight of the frequency is small because `a` includes the frequencies. With fewer than three
/// degrees of freedom in common a pair costs `u`: the MAC over one component is 1 for any two
/// shapes, and over two components independent shapes reach 0.9 in a fifth of all cases. Degrees of
/// freedom that move alike in every mode of the theory, as of sensors at one position, are one.
/// Where the theory moves at none of them in any mode, no pair is allowed, by frequency neither. An
/// unpaired test mode costs 1, so that a pair inside its gates is always preferred, and an unpaired
/// mode changes another pair only where that costs less. The assignment minimises the sum over all
/// pairs.
///
/// A pair with three degrees of freedom in common or more rests on frequency and shape
/// ([`Basis::Shape`](super::Basis::Shape)): its MAC has to reach the
/// [`ChanceLevel`](super::ChanceLevel), else it is uncorrelated. With fewer it rests on frequency
/// alone. A pair is ambiguous when, for either side, another allowed partner costs less than
/// `ambiguous_margin` more; its shape is contested when another root contributes half of it, or
/// this root half of another shape; and mixed when `a` less its standard deviation is below
/// `min_mac`.
///
/// Sensors and groups with the opposite sign of the theory ([`super::measures::reversed_sensors`])
/// are reversed while pairs are chosen; MAC and chance level are of the shapes as measured. The
/// contributions are then those to the reversed shapes, so that the MAC as measured has to reach
/// `min_mac` as well, else the pair is ambiguous.
///
/// Modes of one repeated root of the theory (same group number) are one partner that takes as many
/// test modes as it has modes, by [`subspace_mac`](super::subspace_mac). Rigid-body modes of the
/// theory, and test modes at 0 Hz, are left out: modes at 0 Hz and, of the lowest six, those at 0.1
/// Hz or less below a thousandth of the next one.
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
    let reversed = detect(test, theory, &map, &shapes, options);
    let table = CandidateTable::new(
        test,
        theory,
        &shapes.reversed(&signs(&map, &reversed)),
        &map,
        options,
    );
    let root_of = table.assign();
    // Without any shape of the theory no DOFs are matched; the rows state that modes are paired by
    // frequency alone.
    let has_shapes = theory.modes.iter().any(|mode| !mode.shape.is_empty());
    let mut findings = Vec::new();
    if has_shapes {
        findings.extend(map.findings(shapes.all_distinct_count(), options.min_dofs));
    }
    let pairs = table.pairs(&root_of, &shapes, !reversed.is_empty(), options)?;
    let by_shape_alone = match pairs.is_empty() {
        true => table.shape_matches(test, shapes.all_distinct_count(), options),
        false => Vec::new(),
    };
    findings.extend(shapes_agree_finding(&by_shape_alone));
    findings.extend(reversed_findings(&reversed, false));
    findings.extend(reversed_order(&shapes, &map));
    findings.extend(table.findings(test, &root_of, &pairs, options));
    findings.extend(pairs.iter().filter_map(|pair| similar_partners(pair, test)));
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
        by_shape_alone,
        findings,
    })
}

/// The finding on partners of a repeated root with similar shapes, at the highest of them.
fn similar_partners(pair: &Pair, test: &ModalModel) -> Option<Finding> {
    let contribution = pair.weakest_direction?;
    let location = Location::Mode(test.modes[pair.partners.last()?.test].frequency_hz);
    let finding = Finding::new(Severity::Warning, Code::AlikePartners, location);
    Some(
        finding
            .value(contribution, "")
            .limit(MIN_DIRECTION_CONTRIBUTION),
    )
}

//! A result is compared with a baseline: the allowed change follows from the uncertainties that
//! both state, so that the false-alarm probability is known, or from absolute limits.

use std::collections::BTreeMap;

use num_complex::Complex64;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

use crate::correlate::{assign, subspace_mac};
use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, Scaling, mac, modal_scale_factor};

use super::limits::{LimitCheck, percent};

/// Largest change of a frequency whose uncertainty one side does not state, percent.
pub const MAX_FREQUENCY_CHANGE_PERCENT: f64 = 0.05;
/// Largest change of a damping ratio whose uncertainty one side does not state, percent.
pub const MAX_DAMPING_CHANGE_PERCENT: f64 = 5.0;
/// Largest 1 − MAC of a shape whose uncertainty one side does not state, and largest change of a
/// MAC.
pub const MAX_MAC_CHANGE: f64 = 0.01;

/// Maximum factor between the standard deviations of a value in the result and in its baseline.
/// Larger: a result of no certainty passes with wrong values, which its deviations excuse. Smaller:
/// recordings of the same machine fail, whose deviations are estimates; they differ by a factor of
/// 1.2 at most in `check_command::another_recording_of_the_same_machine_passes`.
const MAX_STD_CHANGE: f64 = 3.0;
/// Minimum relative change above rounding: the same input gives the same result to 1e-9 on another
/// machine.
const MIN_RELATIVE_CHANGE: f64 = 1e-6;
/// Maximum relative frequency shift of a mode between baseline and result.
const MAX_SHIFT_OF_ONE_MODE: f64 = 0.02;
/// Minimum component, over the largest one, whose sign is compared. Larger: a small component of
/// the opposite sign passes, which changes the MAC by less than its limit. Smaller: noise turns the
/// sign of a component near a node.
const MIN_COMPONENT_WITH_SIGN: f64 = 0.03;
/// The same of shapes of a model, which have no noise. Smaller: a change of the model within its
/// limits moves a node past a sensor.
const MIN_MODEL_COMPONENT_WITH_SIGN: f64 = 1e-3;
/// Maximum relative change of residues, modal mass and scale of a shape. Larger: a wrong
/// calibration of a sensor passes. Smaller: recordings of the same machine fail, see
/// `check_command::another_recording_of_the_same_machine_passes_and_a_changed_machine_does_not`.
const MAX_AMPLITUDE_CHANGE: f64 = 0.1;
/// Standard deviations of the damping ratio by which an amplitude may change: that of a resonance
/// is estimated with its damping.
const AMPLITUDE_STDS: f64 = 4.0;
/// Most that they may allow: beyond it an amplitude that is lost would pass.
const MAX_AMPLITUDE_CHANGE_BY_STDS: f64 = 0.5;

/// How far a result may lie from its baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeLimits {
    /// Largest change of every frequency, percent; by the stated uncertainties when `None`.
    pub frequency_percent: Option<f64>,
    /// Largest change of every damping ratio, percent; by the stated uncertainties when `None`.
    pub damping_percent: Option<f64>,
    /// Largest 1 − MAC of every shape, and largest change of a MAC; by the stated uncertainties
    /// when `None`.
    pub mac: Option<f64>,
    /// Standard deviation of a frequency from one recording to the next, in addition to the stated
    /// ones, a fraction.
    pub frequency_floor: f64,
    /// Additional standard deviation of a damping ratio, a fraction.
    pub damping_floor: f64,
    /// Additional standard deviation of a shape component, over the root mean square of the shape.
    pub shape_floor: f64,
    /// False-alarm probability over all values: that a result which differs from its baseline by
    /// these uncertainties alone fails.
    pub false_refusals: f64,
}

impl Default for ChangeLimits {
    fn default() -> Self {
        Self {
            frequency_percent: None,
            damping_percent: None,
            mac: None,
            frequency_floor: 1e-4,
            damping_floor: 1e-2,
            shape_floor: 1e-2,
            false_refusals: 0.01,
        }
    }
}

/// Change of one value from the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The row of the result that it belongs to.
    pub row: String,
    /// The quantity.
    pub what: String,
    /// The measure of the change and its limit.
    pub measure: Measure,
}

/// Measure of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// A normally distributed relative difference, tested two-sided.
    Normal {
        /// |difference|, a fraction.
        difference: f64,
        /// Standard deviation of the difference, a fraction.
        std: f64,
    },
    /// A sum of squares over the stated variances.
    ChiSquared {
        /// The sum.
        sum: f64,
        /// Degrees of freedom.
        degrees: f64,
    },
    /// The ratio of two variances with the same number of degrees of freedom, tested two-sided by
    /// the F distribution. Where they contain a model error besides noise, their ratio scatters
    /// less.
    VarianceRatio {
        /// The variance of the result.
        now: f64,
        /// That of the baseline.
        before: f64,
        /// Degrees of freedom, above 0.
        degrees: f64,
    },
    /// A value that may not exceed a limit.
    AtMost(Option<f64>, f64),
    /// A value that may not fall below a limit.
    AtLeast(f64, f64),
}

/// Checks of one row against the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct RowVerdict {
    /// The row: a mode, a root with its test, or the whole.
    pub row: String,
    /// Its checks.
    pub checks: Vec<LimitCheck>,
}

impl RowVerdict {
    /// Whether every check is met.
    pub fn is_met(&self) -> bool {
        self.checks.iter().all(LimitCheck::is_met)
    }
}

/// Checks of all changes, by row in the order of their first change.
///
/// Each of the `n` changes that are compared with stated uncertainties gets the level `1 − (1 −
/// false_refusals)^(1/n)`, which makes `false_refusals` the rate of all together where they are
/// independent.
///
/// # Reference
/// Šidák (1967), Rectangular confidence regions for the means of multivariate normal distributions,
/// JASA 62(318).
pub fn check_changes(changes: &[Change], false_refusals: f64) -> Vec<RowVerdict> {
    let by_uncertainty = |change: &&Change| {
        matches!(
            change.measure,
            Measure::Normal { .. } | Measure::ChiSquared { .. } | Measure::VarianceRatio { .. }
        )
    };
    let count = changes.iter().filter(by_uncertainty).count().max(1);
    let level = -((-false_refusals).ln_1p() / count as f64).exp_m1();
    let mut rows: Vec<RowVerdict> = Vec::new();
    for change in changes {
        let check = check_change(change, level);
        match rows.iter_mut().find(|row| row.row == change.row) {
            Some(row) => row.checks.push(check),
            None => rows.push(RowVerdict {
                row: change.row.clone(),
                checks: vec![check],
            }),
        }
    }
    rows
}

fn check_change(change: &Change, level: f64) -> LimitCheck {
    let check = |value, limit, upper| LimitCheck {
        what: change.what.clone(),
        value,
        limit,
        upper,
    };
    match change.measure {
        Measure::Normal { difference, std } => {
            let deviations = Normal::standard().inverse_cdf(1.0 - 0.5 * level);
            let limit = (deviations * std).max(MIN_RELATIVE_CHANGE);
            check(Some(100.0 * difference), 100.0 * limit, true)
        }
        Measure::ChiSquared { sum, degrees } => {
            // Degrees of freedom are above 0: see `shape_changes`.
            let largest = ChiSquared::new(degrees).map_or(f64::INFINITY, |distribution| {
                distribution.inverse_cdf(1.0 - level)
            });
            check(Some(sum / degrees), largest / degrees, true)
        }
        Measure::VarianceRatio {
            now,
            before,
            degrees,
        } => {
            let largest = FisherSnedecor::new(degrees, degrees).map_or(1.0, |distribution| {
                distribution.inverse_cdf(1.0 - 0.5 * level)
            });
            check(
                Some(factor(now, before)),
                largest.max(1.0 + MIN_RELATIVE_CHANGE),
                true,
            )
        }
        Measure::AtMost(value, limit) => check(value, limit, true),
        Measure::AtLeast(value, limit) => check(Some(value), limit, false),
    }
}

/// A value with the standard deviation that its side states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainValue {
    /// The value.
    pub value: f64,
    /// Its standard deviation, where it is stated.
    pub std: Option<f64>,
}

/// Allowed change of a frequency or damping ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllowedChange {
    /// The absolute limit, percent, in place of uncertainties.
    pub percent: Option<f64>,
    /// Largest change where a side states no uncertainty, percent.
    pub unstated_percent: f64,
    /// Standard deviation in addition to those of both sides, a fraction.
    pub floor: f64,
}

impl ChangeLimits {
    /// Allowed change of a frequency.
    pub fn frequency(&self) -> AllowedChange {
        AllowedChange {
            percent: self.frequency_percent,
            unstated_percent: MAX_FREQUENCY_CHANGE_PERCENT,
            floor: self.frequency_floor,
        }
    }

    /// Allowed change of a damping ratio.
    pub fn damping(&self) -> AllowedChange {
        AllowedChange {
            percent: self.damping_percent,
            unstated_percent: MAX_DAMPING_CHANGE_PERCENT,
            floor: self.damping_floor,
        }
    }
}

/// A change of a value: against the absolute limit where there is one, else against both sides'
/// uncertainties and the floor, else, where a side states none, against the limit for that; limits
/// in percent of the baseline's value.
pub fn relative_change(
    now: Option<UncertainValue>,
    before: UncertainValue,
    allowed: AllowedChange,
) -> Measure {
    let otherwise = allowed.percent.unwrap_or(allowed.unstated_percent);
    let Some(now) = now else {
        return Measure::AtMost(None, otherwise);
    };
    match (allowed.percent, now.std.zip(before.std)) {
        (None, Some((new_std, other))) if before.value != 0.0 => Measure::Normal {
            difference: ((now.value - before.value) / before.value).abs(),
            std: (new_std.hypot(other) / before.value.abs()).hypot(allowed.floor),
        },
        _ => Measure::AtMost(Some(percent(now.value, before.value)), otherwise),
    }
}

/// The change of a standard deviation, to which both sides add the floor as a fraction of the
/// baseline's value: a factor, which a result exceeds that states none. `None` where the baseline
/// states none.
pub fn std_change(
    now: Option<UncertainValue>,
    before: UncertainValue,
    floor: f64,
) -> Option<Measure> {
    let whole = |std: f64| std.hypot(floor * before.value);
    let old = whole(before.std?);
    let new = now.and_then(|now| now.std).map(whole);
    Some(Measure::AtMost(
        new.map(|new| factor(new, old)),
        MAX_STD_CHANGE,
    ))
}

/// The larger of two values over the smaller one, both 0 or more; 1 for two zeros.
fn factor(one: f64, other: f64) -> f64 {
    if one <= 0.0 && other <= 0.0 {
        return 1.0;
    }
    let ratio = one / other;
    ratio.max(ratio.recip())
}

/// Changes of the modes of a baseline: each must be found with its frequency, damping and shape,
/// and no other.
///
/// Modes are assigned one to one, by frequency (within 2 %) and MAC. A shape is compared after its
/// best complex scale: by `Σ |φ − s φ₀|²/(σ² + |s|² σ₀²)`, with the floor, over its components
/// where both sides state their deviations, else by 1 − MAC and the number of components of the
/// opposite sign. Standard deviations may change by a factor of 3; residues, modal mass and the
/// scale of a shape of unit modal mass by 10 %, or by four standard deviations of the damping.
pub fn mode_changes(now: &ModalModel, before: &ModalModel, limits: &ChangeLimits) -> Vec<Change> {
    let partner = partners(now, before);
    let mut changes = Vec::new();
    for (number, (mode, partner)) in (1..).zip(before.modes.iter().zip(&partner)) {
        let row = format!("mode {number} at {} Hz", rounded(mode.frequency_hz));
        let partner_mode = partner.map(|index| &now.modes[index]);
        let found = Measure::AtLeast(f64::from(u8::from(partner_mode.is_some())), 1.0);
        let mut push = |what: &str, measure| {
            changes.push(Change {
                row: row.clone(),
                what: what.to_owned(),
                measure,
            });
        };
        push("found", found);
        let Some(mode_now) = partner_mode else {
            continue;
        };
        let measure = relative_change(
            Some(frequency_of(mode_now)),
            frequency_of(mode),
            limits.frequency(),
        );
        push("frequency change (%)", measure);
        let now_hz = Some(frequency_of(mode_now));
        if let Some(measure) = std_change(now_hz, frequency_of(mode), limits.frequency_floor) {
            push("frequency std change (factor)", measure);
        }
        if let Some(ratio) = damping_of(mode) {
            let measure = relative_change(damping_of(mode_now), ratio, limits.damping());
            push("damping change (%)", measure);
            let std = std_change(damping_of(mode_now), ratio, limits.damping_floor);
            if let Some(measure) = std {
                push("damping std change (factor)", measure);
            }
        }
        let (root_now, root) = (root_of(now, mode_now), root_of(before, mode));
        for (what, measure) in shape_changes(mode_now, mode, limits, &root) {
            push(what, measure);
        }
        for (what, measure) in amplitude_changes(mode_now, mode, &root_now, &root) {
            push(what, measure);
        }
    }
    let extra = (0..now.modes.len()).filter(|index| !partner.contains(&Some(*index)));
    changes.extend(extra.map(|index| Change {
        row: format!(
            "extra mode at {} Hz",
            rounded(now.modes[index].frequency_hz)
        ),
        what: "in the baseline".to_owned(),
        measure: Measure::AtLeast(0.0, 1.0),
    }));
    changes
}

/// The modes of a mode's root; the shapes of a repeated one may turn among themselves.
fn root_of<'a>(model: &'a ModalModel, mode: &'a Mode) -> Vec<&'a Mode> {
    if mode.group.is_none() {
        return vec![mode];
    }
    let same = |other: &&Mode| other.group == mode.group;
    model.modes.iter().filter(same).collect()
}

/// Six significant digits, for the name of a row.
fn rounded(hz: f64) -> f64 {
    format!("{hz:.5e}").parse().unwrap_or(hz)
}

fn frequency_of(mode: &Mode) -> UncertainValue {
    UncertainValue {
        value: mode.frequency_hz,
        std: mode.frequency_uncertainty_hz(),
    }
}

fn damping_of(mode: &Mode) -> Option<UncertainValue> {
    let bias = mode.damping_bias.unwrap_or(0.0);
    mode.damping_ratio.map(|value| UncertainValue {
        value,
        std: mode.damping_std.map(|std| std.hypot(bias)),
    })
}

/// For each mode of the baseline the mode of the result.
fn partners(now: &ModalModel, before: &ModalModel) -> Vec<Option<usize>> {
    let cost = |old: &Mode, new: &Mode| {
        let apart = (new.frequency_hz - old.frequency_hz).abs();
        let part = apart / (MAX_SHIFT_OF_ONE_MODE * old.frequency_hz.abs()).max(f64::MIN_POSITIVE);
        // Another mode, as is one whose frequency is no number.
        if !matches!(part, 0.0..=1.0) {
            return None;
        }
        let common = CommonComponents::new(new, old);
        let unlike = 1.0 - mac(&common.now, &common.before).unwrap_or(1.0);
        // Below 1, the cost of a mode without a partner.
        Some(0.49 * (part + unlike))
    };
    let costs: Vec<Vec<Option<f64>>> = before
        .modes
        .iter()
        .map(|old| now.modes.iter().map(|new| cost(old, new)).collect())
        .collect();
    assign(&costs, 1.0)
}

/// Components that two shapes have in common, along positive axes.
struct CommonComponents {
    now: Vec<Complex64>,
    before: Vec<Complex64>,
    /// Standard deviations of both; `None` where one is not stated.
    stds: Option<Vec<(f64, f64)>>,
}

impl CommonComponents {
    fn new(now: &Mode, before: &Mode) -> Self {
        let mut common = Self {
            now: Vec::new(),
            before: Vec::new(),
            stds: Some(Vec::new()),
        };
        for (dof, value) in before.shape.iter() {
            let Some(new) = now.shape.along_positive(dof) else {
                continue;
            };
            common.now.push(new);
            common.before.push(value * dof.sign());
            let pair = std_at(&now.shape_std, dof).zip(std_at(&before.shape_std, dof));
            common.stds = common.stds.zip(pair).map(|(mut all, pair): (Vec<_>, _)| {
                all.push(pair);
                all
            });
        }
        common
    }
}

fn std_at(stds: &Option<BTreeMap<Dof, f64>>, dof: &Dof) -> Option<f64> {
    let stds = stds.as_ref()?;
    let found = stds.get(dof).or_else(|| stds.get(&dof.opposite()));
    found.copied()
}

fn shape_changes(
    now: &Mode,
    before: &Mode,
    limits: &ChangeLimits,
    root: &[&Mode],
) -> Vec<(&'static str, Measure)> {
    if before.shape.is_empty() {
        return Vec::new();
    }
    let CommonComponents {
        now: new_shape,
        before: other,
        stds,
    } = CommonComponents::new(now, before);
    let points = Measure::AtLeast(new_shape.len() as f64, before.shape.len() as f64);
    let mut changes = vec![("degrees of freedom", points)];
    // One component is a scale and no shape.
    if new_shape.len() < 2 {
        return changes;
    }
    let most = limits.mac.unwrap_or(MAX_MAC_CHANGE);
    if root.len() > 1 {
        let span: Vec<Vec<Complex64>> = root
            .iter()
            .map(|mode| values_at_common_dofs(mode, now, before))
            .collect();
        let outside = subspace_mac(&new_shape, &span).map(|share| 1.0 - share);
        changes.push((
            "part outside the repeated root",
            Measure::AtMost(outside, most),
        ));
        return changes;
    }
    let stated = |(dof, _): (&Dof, Complex64)| std_at(&before.shape_std, dof).is_some();
    if before.shape.iter().all(stated) {
        let largest = stds
            .as_ref()
            .map(|stds| largest_std_change(&new_shape, &other, stds, limits.shape_floor));
        let measure = Measure::AtMost(largest, MAX_STD_CHANGE);
        changes.push(("shape std change (factor)", measure));
    }
    if let (None, Some(stds)) = (limits.mac, stds) {
        let sum = chi_square(&new_shape, &other, &stds, limits.shape_floor);
        let degrees = 2.0 * (new_shape.len() - 1) as f64;
        let measure = Measure::ChiSquared { sum, degrees };
        changes.push(("shape, chi-square per degree of freedom", measure));
        return changes;
    }
    let unlike = mac(&new_shape, &other).map(|mac| 1.0 - mac);
    changes.push(("1 - MAC", Measure::AtMost(unlike, most)));
    let of_models = [now, before].map(|mode| mode.method.as_deref() == Some("theory"));
    let least = match of_models {
        [true, true] => MIN_MODEL_COMPONENT_WITH_SIGN,
        _ => MIN_COMPONENT_WITH_SIGN,
    };
    let reversed = count_reversed_components(&new_shape, &other, least);
    changes.push((
        "reversed components",
        Measure::AtMost(Some(reversed as f64), 0.0),
    ));
    changes
}

/// Changes of what the amplitude of a mode states: its residues (of a repeated root their sums,
/// which do not depend on the basis of the shapes), its modal mass and the scale of its shape.
fn amplitude_changes(
    now: &Mode,
    before: &Mode,
    root_now: &[&Mode],
    root: &[&Mode],
) -> Vec<(&'static str, Measure)> {
    let relative_std = |mode: &Mode| {
        let std = mode.damping_std.zip(mode.damping_ratio);
        std.map_or(0.0, |(std, ratio)| std / ratio)
    };
    let stds = AMPLITUDE_STDS * relative_std(now).hypot(relative_std(before));
    // A deviation that is no number allows nothing more.
    let most = MAX_AMPLITUDE_CHANGE.max(stds.min(MAX_AMPLITUDE_CHANGE_BY_STDS));
    let mut changes = Vec::new();
    if !before.residues.is_empty() {
        let measure = Measure::AtMost(residue_change(root_now, root), most);
        changes.push(("residue change (fraction)", measure));
    }
    let is_changed = f64::from(u8::from(now.scaling != before.scaling));
    changes.push(("scaling changed", Measure::AtMost(Some(is_changed), 0.0)));
    if let Some(mass) = before.modal_mass_kg {
        let change = now.modal_mass_kg.map(|new| (new / mass - 1.0).abs());
        changes.push((
            "modal mass change (fraction)",
            Measure::AtMost(change, most),
        ));
    }
    if before.scaling == Scaling::UnitModalMass && root.len() == 1 {
        let common = CommonComponents::new(now, before);
        let scale = modal_scale_factor(&common.before, &common.now);
        let change = scale.map(|scale| (scale.norm() - 1.0).abs());
        changes.push((
            "shape scale change (fraction)",
            Measure::AtMost(change, most),
        ));
    }
    changes
}

/// `‖R − R₀‖ / ‖R₀‖` of the residues of a root; `None` where one of the baseline's is missing.
fn residue_change(now: &[&Mode], before: &[&Mode]) -> Option<f64> {
    let sums = |root: &[&Mode]| {
        let mut sums: BTreeMap<(Dof, Dof), Complex64> = BTreeMap::new();
        for (pair, residue) in root.iter().flat_map(|mode| &mode.residues) {
            *sums.entry(pair.clone()).or_default() += residue;
        }
        sums
    };
    let (now, before) = (sums(now), sums(before));
    let mut difference = 0.0;
    for (pair, old) in &before {
        difference += (now.get(pair)? - old).norm_sqr();
    }
    let whole: f64 = before.values().map(Complex64::norm_sqr).sum();
    // Residues that are all 0 change by nothing or without measure.
    Some(match difference == 0.0 {
        true => 0.0,
        false => (difference / whole).sqrt(),
    })
}

/// Values of a mode at the degrees of freedom that two others have in common; 0 where it has none.
fn values_at_common_dofs(mode: &Mode, now: &Mode, before: &Mode) -> Vec<Complex64> {
    let dofs = before.shape.iter().map(|(dof, _)| dof);
    let both = dofs.filter(|dof| now.shape.along_positive(dof).is_some());
    both.map(|dof| mode.shape.along_positive(dof).unwrap_or_default())
        .collect()
}

/// The largest factor between the deviations of a component, with the floor, after the scale of
/// the shapes.
fn largest_std_change(
    measured: &[Complex64],
    other: &[Complex64],
    stds: &[(f64, f64)],
    floor: f64,
) -> f64 {
    let floor_std = floor * root_mean_square(measured);
    let scale = root_mean_square(measured) / root_mean_square(other);
    let change = |(new_std, other): &(f64, f64)| {
        factor(new_std.hypot(floor_std), (scale * other).hypot(floor_std))
    };
    // A factor that is no number is the largest.
    stds.iter()
        .map(change)
        .max_by(f64::total_cmp)
        .unwrap_or(1.0)
}

fn root_mean_square(values: &[Complex64]) -> f64 {
    let square: f64 = values.iter().map(|value| value.norm_sqr()).sum();
    (square / values.len() as f64).sqrt()
}

/// `Σ |measured − s other|²/(σ² + |s|² σ₀² + (floor rms)²)`, with the scale `s` that makes it
/// smallest for the weights of its plain value; the deviations are those of real and imaginary part
/// each.
fn chi_square(measured: &[Complex64], other: &[Complex64], stds: &[(f64, f64)], floor: f64) -> f64 {
    let floor_std = floor.max(MIN_RELATIVE_CHANGE) * root_mean_square(measured);
    let plain = modal_scale_factor(other, measured).unwrap_or_default();
    let deviation = |(new_std, other): &(f64, f64)| {
        let stated = new_std.hypot(plain.norm() * other);
        stated.hypot(floor_std).max(f64::MIN_POSITIVE)
    };
    let weighted = |values: &[Complex64]| -> Vec<Complex64> {
        let pairs = values.iter().zip(stds);
        pairs.map(|(value, stds)| value / deviation(stds)).collect()
    };
    let (new_values, other) = (weighted(measured), weighted(other));
    let scale = modal_scale_factor(&other, &new_values).unwrap_or_default();
    let residuals = new_values
        .iter()
        .zip(&other)
        .map(|(new_value, other)| new_value - scale * other);
    residuals.map(|residual| residual.norm_sqr()).sum()
}

/// Number of components with the sign opposite to that of the scaled baseline.
fn count_reversed_components(new_values: &[Complex64], other: &[Complex64], least: f64) -> usize {
    let Some(scale) = modal_scale_factor(other, new_values) else {
        return 0;
    };
    let largest =
        |values: &[Complex64]| values.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let (least_new, least_other) = (least * largest(new_values), least * largest(other));
    let against = |(new_value, other): &(&Complex64, &Complex64)| {
        let both_large = new_value.norm() >= least_new && other.norm() >= least_other;
        both_large && ((scale * **other).conj() * **new_value).re < 0.0
    };
    new_values.iter().zip(other).filter(against).count()
}

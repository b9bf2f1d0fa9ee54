//! Sensors and groups of sensors with the opposite sign of the theory are detected from the shapes.
//!
//! Every hypothesis reverses one sensor, or all of one direction, component or file together, and
//! is evaluated with the best pairs under it: the detection does not need good pairs as measured.
//! Of a group only the sign relative to all other sensors is observable, in modes that move both.

mod hypotheses;
mod overlaps;

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::{ModalModel, ModeShape};

use super::shapes::Shapes;
use super::{CorrelateError, DofMap, PairOptions};

use hypotheses::{Hypothesis, hypotheses};
use overlaps::{Overlaps, PairView, Signed, TrialPairing};

/// Minimum MAC of a pair in the search, with the sensors reversed. Larger: of many
/// reversed sensors none is found, because reversing one alone leaves the MAC low
/// (`one_reversed_sensor_of_many_is_found_and_so_are_more`). Smaller: more pairs of different
/// modes; the final test does not depend on it.
const MIN_SEARCH_MAC: f64 = 0.2;

/// Minimum number of pairs that show a reversal: in one mode the model may be wrong.
const MIN_PAIRS: usize = 2;

/// Maximum correlation of the values as measured with those of the theory, over the pairs. Larger
/// (nearer 0): sensors that are reversed in one mode and not in another. Smaller: noise of 5 %
/// hides sensors that move little (`reversed_sensors_are_found_and_no_others`).
const MAX_SIGN_CORRELATION: f64 = -0.8;

/// Minimum gain of MAC over the gain that a reversed sensor of a correct model has. Larger: model
/// errors hide reversed sensors. Smaller: good sensors of poor models
/// (`a_poor_model_has_no_reversed_sensors`).
const MIN_GAIN_OVER_EXPECTED: f64 = 0.5;

/// Minimum fraction of the squared length, over the mean fraction of as many sensors, of the group
/// and of all others: below it noise decides the sign
/// (`noise_at_sensors_that_hardly_move_reverses_none`).
const MIN_RELATIVE_LENGTH: f64 = 0.1;

/// Maximum expected number of false alarms: good sensors and groups, of all that are tested, that
/// disagree in the same pairs. Larger: good sensors in three poor pairs
/// (`sensors_that_disagree_by_chance_in_three_poor_pairs_are_left`). Smaller: reversed sensors of
/// tests with three or four modes.
const MAX_EXPECTED_FALSE_ALARMS: f64 = 0.1;

/// Maximum number of sensors with which each single sensor gets a pairing of its hypothesis; of
/// more, one sensor changes a MAC by less than 4/64, and no pair.
const MAX_SENSORS_PAIRED_ANEW: usize = 64;

/// A sensor with the opposite sign of the theory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReversedSensor {
    /// As the test names it.
    pub dof: Dof,
    /// The group with which it is reversed; `None` for a single sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Mean MAC of the pairs with the sensors before it reversed.
    pub mac_before: f64,
    /// Mean MAC with this one, or its group, reversed as well.
    pub mac_after: f64,
    /// Correlation of its values, or those of its group, with the theory's over the pairs, near -1.
    pub direction: f64,
}

impl ReversedSensor {
    /// Whether both are reversed with one group.
    pub fn is_grouped_with(&self, other: &Self) -> bool {
        self.group.is_some() && self.group == other.group
    }

    /// Name of the sensor, or of its group with the number of members.
    pub fn name(&self, members: usize) -> String {
        match &self.group {
            Some(group) => format!("{group} ({members} sensors)"),
            None => self.dof.to_string(),
        }
    }
}

/// The sensors of a test with the opposite sign of the theory, those with the largest gain first.
///
/// For every single sensor, and every group of one direction (X, Y, Z, ...), component (the part of
/// a name before the dot) or file, the test modes are paired within the frequency gate at the
/// smallest sum of `0.1 u + 0.9 (1 − MAC)` with its sign changed, `u` being the frequency error
/// over the gate. Repeatedly the hypothesis of the smallest sum is accepted, if over the pairs with
/// a MAC of 0.2 or more
///
/// - the correlation of its values with the theory's, `Σ Re(b* a)/√(Σ|a|² Σ|b|²)` of unit shapes
///   `a`, `b`, is at most −0.8 as measured;
/// - the sum of MAC over all test modes gains half or more of the gain for a correct model,
///   `4 w (√MAC − w)` of each pair with its fraction `w` of the squared length;
/// - it and all others have a tenth or more of the mean fraction of as many sensors.
///
/// Then the false-alarm probability is tested, with all of them reversed, over the pairs whose MAC
/// exceeds the [`super::ChanceLevel`] and that move both sides: in each, a good sensor disagrees as
/// often as others do (their number and one, over all and one), and by no more than `m σ²/Σ|a +
/// b|²`, `σ²` being the mean square difference of the others and `m` the number of its sensors
/// (Chebyshev). The product of the smaller of these over the pairs, two or more, times the number
/// of hypotheses has to be below 0.1.
///
/// A single sensor is never found among fewer than three, and never half of all sensors.
///
/// # Errors
/// [`CorrelateError::MixedUnits`].
pub fn reversed_sensors(
    test: &ModalModel,
    theory: &ModalModel,
    options: &PairOptions,
) -> Result<Vec<ReversedSensor>, CorrelateError> {
    options.validate()?;
    super::model_roots::check_model("test", test)?;
    super::model_roots::check_model("theory", theory)?;
    let map = DofMap::of_models(test, theory);
    let shapes = Shapes::new(test, theory, &map, options)?;
    Ok(detect(test, theory, &map, &shapes, options))
}

/// [`reversed_sensors`] of prepared shapes.
pub(super) fn detect(
    test: &ModalModel,
    theory: &ModalModel,
    map: &DofMap,
    shapes: &Shapes,
    options: &PairOptions,
) -> Vec<ReversedSensor> {
    let overlaps = Overlaps::new(test, theory, shapes, options);
    if overlaps.modes() < MIN_PAIRS {
        return Vec::new();
    }
    let search = Search {
        hypotheses: hypotheses(test, map),
        overlaps,
        sensors: map.len(),
    };
    let all: Vec<usize> = (0..search.hypotheses.len()).collect();
    let suspects = search.select_hypotheses(&all);
    let significant = search.significant_hypotheses(&suspects);
    let found = if significant.len() == suspects.len() {
        suspects
    } else {
        search.select_hypotheses(&significant)
    };
    let sensors = found
        .iter()
        .flat_map(|reversal| search.sensors_of(reversal, map));
    sensors.collect()
}

/// Signs of the degrees of freedom of a map: -1 for reversed sensors.
pub(super) fn signs(map: &DofMap, reversed: &[ReversedSensor]) -> Vec<f64> {
    let count = |dof: &Dof| reversed.iter().filter(|sensor| sensor.dof == *dof).count();
    let sign = |dof: &Dof| if count(dof) % 2 == 1 { -1.0 } else { 1.0 };
    map.pairs.iter().map(|pair| sign(&pair.test)).collect()
}

struct Search {
    overlaps: Overlaps,
    hypotheses: Vec<Hypothesis>,
    sensors: usize,
}

/// An accepted hypothesis.
struct Reversal {
    hypothesis: usize,
    mac_before: f64,
    mac_after: f64,
    direction: f64,
}

impl Search {
    /// Hypotheses of a list whose reversal improves the pairs, the best first.
    fn select_hypotheses(&self, among: &[usize]) -> Vec<Reversal> {
        let mut signed = self.overlaps.signed(vec![1.0; self.sensors]);
        let mut choice = self.overlaps.choose(&signed, &[]);
        let mut left = among.to_vec();
        let mut found = Vec::new();
        let mean = |choice: &TrialPairing| choice.mac / self.overlaps.modes().max(1) as f64;
        while let Some((hypothesis, next, direction)) =
            self.best_hypothesis(&signed, &choice, &left)
        {
            signed = self
                .overlaps
                .signed(self.reversed_signs(&signed.signs, hypothesis));
            left.retain(|remaining| *remaining != hypothesis);
            found.push(Reversal {
                hypothesis,
                mac_before: mean(&choice),
                mac_after: mean(&next),
                direction,
            });
            choice = next;
        }
        found
    }

    /// The hypothesis of smallest cost that passes, its pairs and its direction.
    fn best_hypothesis(
        &self,
        signed: &Signed,
        before: &TrialPairing,
        among: &[usize],
    ) -> Option<(usize, TrialPairing, f64)> {
        let anew = self.sensors <= MAX_SENSORS_PAIRED_ANEW;
        let reversed = signed.signs.iter().filter(|sign| **sign < 0.0).count();
        let tried = among.iter().filter_map(|&number| {
            let Hypothesis { group, members } = &self.hypotheses[number];
            let most = if group.is_some() {
                self.sensors
            } else {
                self.sensors - 1
            };
            if 2 * (reversed + members.len()) > most {
                return None;
            }
            let choice = if anew || group.is_some() {
                self.overlaps.choose(signed, members)
            } else {
                self.overlaps.keep(signed, members, before)
            };
            if choice.cost >= before.cost {
                return None;
            }
            let direction = self.passing_direction(signed, before, number, &choice)?;
            Some((number, choice, direction))
        });
        tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost).then(a.0.cmp(&b.0)))
    }

    /// Direction of a hypothesis that passes all conditions but the false-alarm probability.
    fn passing_direction(
        &self,
        signed: &Signed,
        before: &TrialPairing,
        hypothesis: usize,
        choice: &TrialPairing,
    ) -> Option<f64> {
        let members = &self.hypotheses[hypothesis].members;
        let views = self
            .overlaps
            .views(choice, &self.reversed_signs(&signed.signs, hypothesis));
        let views = views.into_iter().filter(|view| view.mac >= MIN_SEARCH_MAC);
        let parts: Vec<PartialOverlap> = views
            .map(|view| PartialOverlap::new(&view, members))
            .collect();
        let sum = |of: fn(&PartialOverlap) -> f64| parts.iter().map(of).sum::<f64>();
        let direction =
            -sum(|part| part.along) / (sum(|part| part.test) * sum(|part| part.theory)).sqrt();
        let of_reversed =
            sum(|part| 4.0 * part.length_fraction * (part.mac.sqrt() - part.length_fraction));
        let passes = parts.len() >= MIN_PAIRS
            && direction <= MAX_SIGN_CORRELATION
            && choice.mac - before.mac >= MIN_GAIN_OVER_EXPECTED * of_reversed
            && sum(|part| part.relative_length) >= MIN_RELATIVE_LENGTH * parts.len() as f64
            && sum(|part| part.relative_length_of_others)
                >= MIN_RELATIVE_LENGTH * parts.len() as f64;
        passes.then_some(direction)
    }

    /// Hypotheses of a list with a low expected number of false alarms.
    fn significant_hypotheses(&self, suspects: &[Reversal]) -> Vec<usize> {
        let mut signs = vec![1.0; self.sensors];
        let mut suspected = vec![false; self.sensors];
        for suspect in suspects {
            signs = self.reversed_signs(&signs, suspect.hypothesis);
            for &d in &self.hypotheses[suspect.hypothesis].members {
                suspected[d] = true;
            }
        }
        let choice = self
            .overlaps
            .choose(&self.overlaps.signed(signs.clone()), &[]);
        let views = self.overlaps.views(&choice, &signs).into_iter();
        let views: Vec<PairView> = views.filter(|view| view.mac >= view.level).collect();
        let disagreements: Vec<Disagreement> = views
            .iter()
            .map(|view| Disagreement::new(view, &suspected))
            .collect();
        let expected_false = |hypothesis: usize| {
            let members = &self.hypotheses[hypothesis].members;
            let parts = views
                .iter()
                .zip(&disagreements)
                .filter_map(|(view, disagreement)| {
                    let part = PartialOverlap::new(view, members);
                    part.agrees()
                        .then(|| disagreement.probability(&part, members.len()))
                });
            let parts: Vec<f64> = parts.collect();
            let shown = parts.len() >= MIN_PAIRS;
            shown.then(|| self.hypotheses.len() as f64 * parts.iter().product::<f64>())
        };
        let numbers = suspects.iter().map(|suspect| suspect.hypothesis);
        numbers
            .filter(|number| expected_false(*number).is_some_and(|n| n < MAX_EXPECTED_FALSE_ALARMS))
            .collect()
    }

    fn reversed_signs(&self, signs: &[f64], hypothesis: usize) -> Vec<f64> {
        let mut signs = signs.to_vec();
        for &d in &self.hypotheses[hypothesis].members {
            signs[d] = -signs[d];
        }
        signs
    }

    fn sensors_of<'m>(
        &'m self,
        found: &'m Reversal,
        map: &'m DofMap,
    ) -> impl Iterator<Item = ReversedSensor> + 'm {
        let Hypothesis { group, members } = &self.hypotheses[found.hypothesis];
        members.iter().map(move |&d| ReversedSensor {
            dof: map.pairs[d].test.clone(),
            group: group.clone(),
            mac_before: found.mac_before,
            mac_after: found.mac_after,
            direction: found.direction,
        })
    }
}

/// Sums over the sensors of a hypothesis in one pair, of unit test shape `a` and theory shape `b`,
/// with these sensors reversed.
struct PartialOverlap {
    mac: f64,
    /// `Σ Re(b* a)`.
    along: f64,
    /// `Σ |a|²`.
    test: f64,
    /// `Σ |b|²`.
    theory: f64,
    /// `Σ |a + b|²`: squared deviation from the theory as measured.
    deviation: f64,
    /// Fraction of the squared length, mean of test and theory.
    length_fraction: f64,
    /// This fraction over the mean fraction of as many sensors.
    relative_length: f64,
    /// The relative length of all other sensors.
    relative_length_of_others: f64,
}

impl PartialOverlap {
    fn new(view: &PairView, members: &[usize]) -> Self {
        let sum = |of: &dyn Fn(&(num_complex::Complex64, num_complex::Complex64)) -> f64| {
            members.iter().map(|&d| of(&view.values[d])).sum::<f64>()
        };
        let (test, theory) = (sum(&|(a, _)| a.norm_sqr()), sum(&|(_, b)| b.norm_sqr()));
        let length_fraction = 0.5 * (test + theory);
        let (count, all) = (members.len() as f64, view.dofs as f64);
        Self {
            mac: view.mac,
            along: sum(&|(a, b)| (b.conj() * a).re),
            deviation: sum(&|(a, b)| (a + b).norm_sqr()),
            relative_length: length_fraction * all / count,
            relative_length_of_others: (1.0 - length_fraction) * all / (all - count).max(1.0),
            test,
            theory,
            length_fraction,
        }
    }

    /// Whether the pair moves these and the other sensors, and the reversed sensors agree with the
    /// theory.
    fn agrees(&self) -> bool {
        self.relative_length >= MIN_RELATIVE_LENGTH
            && self.relative_length_of_others >= MIN_RELATIVE_LENGTH
            && self.along > 0.0
    }
}

/// Disagreement of test and theory in a pair, at the sensors that are not suspected.
struct Disagreement {
    /// Fraction of the sensors that disagree, `(n + 1)/(N + 1)`.
    disagreeing: f64,
    /// Mean square difference of test and theory at a sensor.
    variance: f64,
}

impl Disagreement {
    fn new(view: &PairView, suspected: &[bool]) -> Self {
        let mean_fraction = (view.dofs as f64).recip();
        let others = view.values.iter().zip(suspected);
        let others = || {
            let kept = others.clone().filter(|(_, suspected)| !**suspected);
            kept.map(|(values, _)| values)
                .filter(|(a, b)| a.norm_sqr() + b.norm_sqr() > 0.0)
        };
        let against = others().filter(|(a, b)| {
            let length_fraction = 0.5 * (a.norm_sqr() + b.norm_sqr());
            length_fraction >= MIN_RELATIVE_LENGTH * mean_fraction && (b.conj() * a).re < 0.0
        });
        let count = others().count() as f64;
        let squares: f64 = others().map(|(a, b)| (a - b).norm_sqr()).sum();
        Self {
            disagreeing: (against.count() as f64 + 1.0) / (count + 1.0),
            variance: squares / (count - 1.0).max(1.0),
        }
    }

    /// Bound on the probability that good sensors deviate as much.
    fn probability(&self, part: &PartialOverlap, members: usize) -> f64 {
        let chebyshev = members as f64 * self.variance / part.deviation.max(f64::MIN_POSITIVE);
        self.disagreeing.min(chebyshev)
    }
}

/// Findings on reversed sensors, one for each group; of severity `Info` where they were corrected.
pub fn reversed_findings(sensors: &[ReversedSensor], corrected: bool) -> Vec<Finding> {
    let severity = if corrected {
        Severity::Info
    } else {
        Severity::Warning
    };
    let groups = sensors.chunk_by(ReversedSensor::is_grouped_with);
    let finding = |sensor: &ReversedSensor| {
        let gain = sensor.mac_after - sensor.mac_before;
        let (code, location) = match &sensor.group {
            Some(group) => (Code::ReversedGroup, Location::Sensors(group.clone())),
            None => (
                Code::ReversedSensor,
                Location::Function {
                    response: Some(sensor.dof.clone()),
                    reference: None,
                },
            ),
        };
        Finding::new(severity, code, location).value(gain, "")
    };
    groups
        .filter_map(|group| group.first())
        .map(finding)
        .collect()
}

/// A model with the values of some degrees of freedom times -1, in shapes and in residues of their
/// responses; a degree of freedom that is named twice is not reversed.
pub fn reverse_sensors(model: &ModalModel, dofs: &[Dof]) -> ModalModel {
    let count = |dof: &Dof| dofs.iter().filter(|other| *other == dof).count();
    let sign = |dof: &Dof| if count(dof) % 2 == 1 { -1.0 } else { 1.0 };
    let mut reversed = model.clone();
    for mode in &mut reversed.modes {
        let values = mode
            .shape
            .iter()
            .map(|(dof, v)| (dof.clone(), v * sign(dof)));
        mode.shape = ModeShape::new(values.collect::<Vec<_>>());
        for ((response, _), residue) in &mut mode.residues {
            *residue *= sign(response);
        }
    }
    reversed
}

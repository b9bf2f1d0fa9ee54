//! Excitation points whose hits do not suffice, each with the reasons, its best hits so far, and
//! the standard deviation of its FRFs that further hits give.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::frf::consistency::resonances::{Resonance, resonances};
use crate::frf::hit_report::HitReport;
use crate::signal::{Check, Outcome, Rule};

/// Good hits of a point. Fewer: with two, neither a level nor an FRF can be found to be the wrong
/// one of the two, and their scatter has two degrees of freedom. More: tests of three hits, the
/// customary number, have every point listed (`three_good_hits_suffice`).
pub const MIN_GOOD_HITS: usize = 3;
/// Force below the median of the hits at the other points from which a hit is weak, dB. Smaller:
/// the scatter of a hand, a factor of two, is weak. Larger: a hit of a tenth of the power, whose
/// FRF has ten times the noise, is not (`a_weak_hit_does_not_count`).
const WEAK_BELOW_MEDIAN_DB: f64 = 10.0;
/// Hits at other points of which a median is taken.
const MIN_OTHER_HITS: usize = 3;
/// Coherence at a resonance: with three hits an FRF has there the standard deviation
/// `√((1 − γ²)/(6 γ²))`, 9 %, as large as the limit of reciprocity. Larger: hits whose levels of
/// response scatter by 20 % are reported, `γ² = 1/(1 + 0.2²)`. Smaller: such an FRF passes
/// (`coherence_at_a_resonance_has_its_limit`).
const MIN_RESONANCE_COHERENCE: f64 = 0.95;

/// The points of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct HitAgain {
    /// Every excitation point, in order.
    pub points: Vec<PointCheck>,
}

impl HitAgain {
    /// The points to hit again.
    pub fn listed(&self) -> impl Iterator<Item = &PointCheck> {
        self.points.iter().filter(|point| point.is_listed())
    }
}

/// The hits at an excitation point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCheck {
    /// The point.
    pub reference: Dof,
    /// Number of its hits.
    pub hits: usize,
    /// Numbers of its good hits, the best one first: those with the fewest remarks, then those with
    /// the largest force.
    pub best: Vec<usize>,
    /// Why it is to be hit again; empty where it is not.
    pub reasons: Vec<Reason>,
    /// The resonance at which its FRFs have the largest standard deviation.
    pub deviation: Option<ResonanceDeviation>,
}

impl PointCheck {
    /// Whether the point is to be hit again.
    pub fn is_listed(&self) -> bool {
        !self.reasons.is_empty()
    }

    /// Good hits that are missing.
    pub fn missing_hits(&self) -> usize {
        MIN_GOOD_HITS.saturating_sub(self.best.len())
    }
}

/// A reason to hit a point again.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The cause.
    pub cause: Cause,
    /// The hit that has it.
    pub hit: Option<usize>,
    /// The response that shows it.
    pub response: Option<Dof>,
    /// Its value.
    pub value: Option<f64>,
    /// The limit of the value.
    pub limit: Option<f64>,
}

impl Reason {
    fn new(cause: Cause) -> Self {
        Self {
            cause,
            hit: None,
            response: None,
            value: None,
            limit: None,
        }
    }

    fn of_check(hit: &HitReport, check: &Check) -> Self {
        Self {
            hit: Some(hit.number),
            response: check.dof.clone(),
            value: check.value,
            limit: check.limit,
            ..Self::new(Cause::Rule(check.rule))
        }
    }
}

/// The cause of a reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// A rule rejected a hit or one of its responses, or the response had not decayed.
    Rule(Rule),
    /// The user rejected a hit.
    Stated,
    /// The force of a hit is below that at the other points: dB above their median.
    WeakForce,
    /// Good hits are missing.
    FewHits,
    /// The coherence at a resonance is low.
    LowCoherence {
        /// Frequency of the resonance.
        hz: f64,
    },
}

/// Standard deviation of the magnitude of an FRF at a resonance, over the magnitude.
#[derive(Clone, Debug, PartialEq)]
pub struct ResonanceDeviation {
    /// The response of the FRF.
    pub response: Dof,
    /// Frequency of the resonance.
    pub hz: f64,
    /// The relative standard deviation.
    pub relative_std: f64,
    /// The hits of which it is the average.
    pub averages: u32,
}

impl ResonanceDeviation {
    /// The standard deviation with further hits like those so far: it falls as one over the square
    /// root of their number.
    pub fn with_more(&self, hits: usize) -> f64 {
        let now = f64::from(self.averages);
        self.relative_std * (now / (now + hits as f64)).sqrt()
    }
}

/// Every excitation point of a test with hits.
pub(super) fn hit_again(hits: &[HitReport], set: &FrfSet) -> HitAgain {
    let mut by_point: BTreeMap<&Dof, Vec<&HitReport>> = BTreeMap::new();
    for hit in hits {
        by_point.entry(&hit.reference).or_default().push(hit);
    }
    let resonances = resonances(set);
    let points = by_point.iter().map(|(reference, of_point)| {
        let functions = set.functions();
        let is_of_point = |r: &&Resonance| functions[r.function].reference == **reference;
        let resonances: Vec<&Resonance> = resonances.iter().filter(is_of_point).collect();
        let others = hits.iter().filter(|hit| hit.reference != **reference);
        let median_n = median_force(others);
        let mut reasons = Vec::new();
        let mut good: Vec<&HitReport> = Vec::new();
        for hit in of_point {
            let of_hit = faults(hit, median_n);
            match of_hit.is_empty() {
                true => good.push(hit),
                false => reasons.extend(of_hit),
            }
        }
        good.sort_by(|a, b| {
            let force_n = |hit: &HitReport| hit.peak_n.map_or(0.0, f64::abs);
            let by_force = || force_n(b).total_cmp(&force_n(a));
            remarks(a).cmp(&remarks(b)).then_with(by_force)
        });
        // Faults of single hits do not matter where enough good ones are left.
        match good.len() < MIN_GOOD_HITS {
            true => reasons.push(Reason {
                value: Some(good.len() as f64),
                limit: Some(MIN_GOOD_HITS as f64),
                ..Reason::new(Cause::FewHits)
            }),
            false => reasons.clear(),
        }
        reasons.extend(low_coherence(set, &resonances));
        reasons.extend(not_decayed(of_point));
        PointCheck {
            reference: (*reference).clone(),
            hits: of_point.len(),
            best: good.iter().map(|hit| hit.number).collect(),
            reasons,
            deviation: largest_deviation(set, &resonances),
        }
    });
    HitAgain {
        points: points.collect(),
    }
}

/// The median peak force of used hits; `None` of few.
fn median_force<'h>(hits: impl Iterator<Item = &'h HitReport>) -> Option<f64> {
    let peaks = hits.filter(|hit| hit.used).filter_map(|hit| hit.peak_n);
    let mut peaks: Vec<f64> = peaks.map(f64::abs).collect();
    let middle = peaks.len() / 2;
    (peaks.len() >= MIN_OTHER_HITS).then(|| *peaks.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Why a hit does not count as a good one. A hit that the user accepts counts.
fn faults(hit: &HitReport, median_n: Option<f64>) -> Vec<Reason> {
    let hit_number = Some(hit.number);
    match (hit.stated, hit.used) {
        (true, true) => return Vec::new(),
        (true, false) => {
            let hit = hit_number;
            return vec![Reason {
                hit,
                ..Reason::new(Cause::Stated)
            }];
        }
        (false, _) => (),
    }
    let rejecting = hit.checks.iter();
    let rejecting = rejecting.filter(|check| check.outcome == Outcome::Rejected);
    let mut faults: Vec<Reason> = Vec::new();
    for check in rejecting {
        // One response of many names the rule.
        if !faults.iter().any(|f| f.cause == Cause::Rule(check.rule)) {
            faults.push(Reason::of_check(hit, check));
        }
    }
    let level_db = median_n
        .zip(hit.peak_n)
        .map(|(median, peak)| 20.0 * (peak.abs() / median).log10());
    if let Some(level_db) = level_db.filter(|level| *level < -WEAK_BELOW_MEDIAN_DB) {
        faults.push(Reason {
            hit: hit_number,
            value: Some(level_db),
            limit: Some(-WEAK_BELOW_MEDIAN_DB),
            ..Reason::new(Cause::WeakForce)
        });
    }
    faults
}

/// Remarks of the rules on a hit; decay and roll-off are those of the whole test.
fn remarks(hit: &HitReport) -> usize {
    let is_remark = |check: &&Check| {
        check.outcome == Outcome::Noted && !matches!(check.rule, Rule::Decay | Rule::RollOff)
    };
    hit.checks.iter().filter(is_remark).count()
}

/// The lowest coherence at a resonance, where it is below its limit.
fn low_coherence(set: &FrfSet, resonances: &[&Resonance]) -> Option<Reason> {
    let with_coherence = resonances.iter().filter_map(|r| Some((r, r.coherence?)));
    let (resonance, coherence) = with_coherence.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (coherence < MIN_RESONANCE_COHERENCE).then(|| Reason {
        response: Some(set.functions()[resonance.function].response.clone()),
        value: Some(coherence),
        limit: Some(MIN_RESONANCE_COHERENCE),
        ..Reason::new(Cause::LowCoherence { hz: resonance.hz })
    })
}

/// The response of a used hit that rings most at the end of its record, where the rule has a
/// remark.
fn not_decayed(hits: &[&HitReport]) -> Option<Reason> {
    let used = hits.iter().filter(|hit| hit.used);
    let remarks = used.flat_map(|hit| hit.checks.iter().map(|check| (*hit, check)));
    let remarks = remarks
        .filter(|(_, check)| check.rule == Rule::Decay && check.outcome == Outcome::Noted)
        .filter(|(_, check)| check.value.is_some());
    let (hit, check) = remarks.max_by(|a, b| {
        let value = |check: &Check| check.value.unwrap_or(0.0);
        value(a.1).total_cmp(&value(b.1))
    })?;
    Some(Reason::of_check(hit, check))
}

fn largest_deviation(set: &FrfSet, resonances: &[&Resonance]) -> Option<ResonanceDeviation> {
    let largest = resonances
        .iter()
        .max_by(|a, b| a.relative_std.total_cmp(&b.relative_std))?;
    let function = &set.functions()[largest.function];
    Some(ResonanceDeviation {
        response: function.response.clone(),
        hz: largest.hz,
        relative_std: largest.relative_std,
        averages: function.averages?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, add_noise};
    use crate::frf::{FrfSet, FunctionData};

    fn hit(number: usize, point: &str, peak_n: f64) -> HitReport {
        HitReport {
            number,
            origin: String::new(),
            reference: point.parse().unwrap(),
            peak_n: Some(peak_n),
            onset: 0,
            checks: Vec::new(),
            used: true,
            stated: false,
        }
    }

    /// Three hits of 100 N at each of two points.
    fn six_hits() -> Vec<HitReport> {
        let points = ["1:+Z", "1:+Z", "1:+Z", "2:+Z", "2:+Z", "2:+Z"];
        let hits = (1..).zip(points);
        hits.map(|(number, point)| hit(number, point, 100.0))
            .collect()
    }

    fn rejected(hit: &mut HitReport, rule: Rule, value: f64, limit: f64) {
        hit.used = false;
        hit.checks.push(Check {
            value: Some(value),
            limit: Some(limit),
            ..Check::new(rule, Outcome::Rejected)
        });
    }

    fn no_frfs() -> FrfSet {
        Beam::default().set(&[])
    }

    /// The causes of the points that are listed.
    fn listed(hits: &[HitReport], set: &FrfSet) -> Vec<(String, Vec<Cause>)> {
        let all = hit_again(hits, set);
        let listed = all.listed().map(|point| {
            let causes = point.reasons.iter().map(|reason| reason.cause).collect();
            (point.reference.to_string(), causes)
        });
        listed.collect()
    }

    #[test]
    fn three_good_hits_suffice() {
        let mut hits = six_hits();
        assert_eq!(listed(&hits, &no_frfs()), []);
        rejected(&mut hits[4], Rule::DoubleHit, 0.3, 0.1);
        let double = Cause::Rule(Rule::DoubleHit);
        let expected = ("2:+Z".to_owned(), vec![double, Cause::FewHits]);
        assert_eq!(listed(&hits, &no_frfs()), [expected]);
        let point = &hit_again(&hits, &no_frfs()).points[1];
        assert_eq!(
            (point.best.as_slice(), point.missing_hits()),
            (&[4, 6][..], 1)
        );
        let reason = &point.reasons[0];
        assert_eq!(
            (reason.hit, reason.value, reason.limit),
            (Some(5), Some(0.3), Some(0.1))
        );
        // Another good one replaces it.
        hits.push(hit(7, "2:+Z", 100.0));
        assert_eq!(listed(&hits, &no_frfs()), []);
        // A hit that was used for want of others is no good one, but one that the user accepts.
        let mut all_bad = six_hits();
        for hit in &mut all_bad[3..] {
            rejected(hit, Rule::Overload, 8.0, 3.0);
            hit.used = true;
        }
        assert!(hit_again(&all_bad, &no_frfs()).points[1].best.is_empty());
        all_bad.iter_mut().for_each(|hit| hit.stated = true);
        assert_eq!(listed(&all_bad, &no_frfs()), []);
    }

    #[test]
    fn a_weak_hit_does_not_count() {
        let mut hits = six_hits();
        hits[1].peak_n = Some(-33.0);
        assert_eq!(listed(&hits, &no_frfs()), []);
        hits[1].peak_n = Some(-31.0);
        let expected = ("1:+Z".to_owned(), vec![Cause::WeakForce, Cause::FewHits]);
        assert_eq!(listed(&hits, &no_frfs()), [expected]);
        let point = &hit_again(&hits, &no_frfs()).points[0];
        assert!(point.reasons[0].value < Some(-10.0));
        // Hits at one point alone have no others.
        assert_eq!(listed(&hits[..3], &no_frfs()), []);
    }

    #[test]
    fn the_best_hits_have_the_fewest_remarks_then_the_largest_force() {
        let mut hits = six_hits();
        hits[0]
            .checks
            .push(Check::new(Rule::DoubleHit, Outcome::Noted));
        hits[1]
            .checks
            .push(Check::new(Rule::RollOff, Outcome::Noted));
        hits[2].peak_n = Some(120.0);
        assert_eq!(hit_again(&hits, &no_frfs()).points[0].best, [3, 2, 1]);
    }

    #[test]
    fn a_response_that_rings_at_the_end_is_a_reason() {
        let mut hits = six_hits();
        for (hit, value) in hits.iter_mut().zip([0.02, 0.05, 0.03]) {
            hit.checks.push(Check {
                value: Some(value),
                limit: Some(0.01),
                ..Check::new(Rule::Decay, Outcome::Noted)
            });
        }
        let point = &hit_again(&hits, &no_frfs()).points[0];
        let reason = Reason {
            hit: Some(2),
            value: Some(0.05),
            limit: Some(0.01),
            ..Reason::new(Cause::Rule(Rule::Decay))
        };
        assert_eq!(point.reasons, [reason]);
        assert_eq!(point.best.len(), 3);
    }

    /// A noisy function at each of two points, the first one with this coherence in a band.
    fn with_coherence(coherence: f64, band_hz: [f64; 2]) -> FrfSet {
        let mut noisy = Beam::default().set(&[("3:+Z", "1:+Z"), ("3:+Z", "2:+Z")]);
        add_noise(&mut noisy, 30.0, 1);
        let mut set = FrfSet::new(*noisy.axis());
        for (i, function) in noisy.functions().iter().enumerate() {
            let of_line = |k: usize| {
                let hz = noisy.axis().hz(k);
                match i == 0 && hz > band_hz[0] && hz < band_hz[1] {
                    true => coherence,
                    false => 1.0,
                }
            };
            let data = FunctionData {
                values: noisy.values(i).to_vec(),
                coherence: Some((0..noisy.axis().len).map(of_line).collect()),
                variance: noisy.variance(i).map(<[f64]>::to_vec),
            };
            set.push(function.clone(), data).unwrap();
        }
        set
    }

    #[test]
    fn coherence_at_a_resonance_has_its_limit() {
        let hits = six_hits();
        let at_resonance = [115.0, 127.0];
        // Levels that scatter by 20 %, and an FRF that is uncertain by 10 %.
        let (scatter, uncertain) = (1.0 / (1.0 + 0.04), 1.0 / (1.0 + 6.0 * 0.01));
        assert_eq!(listed(&hits, &with_coherence(scatter, at_resonance)), []);
        let set = with_coherence(uncertain, at_resonance);
        let point = &hit_again(&hits, &set).points[0];
        let [reason] = point.reasons.as_slice() else {
            panic!("{point:?}")
        };
        assert!(matches!(reason.cause, Cause::LowCoherence { hz } if (hz - 121.0).abs() < 0.5));
        assert!(
            (reason.value.unwrap() - uncertain).abs() < 1e-9,
            "{reason:?}"
        );
        assert!(!hit_again(&hits, &set).points[1].is_listed());
        // Between resonances it is low without consequence.
        assert_eq!(listed(&hits, &with_coherence(0.5, [250.0, 290.0])), []);
    }

    #[test]
    fn the_deviation_falls_with_the_root_of_the_hits() {
        let set = with_coherence(1.0, [0.0, 0.0]);
        let all = hit_again(&six_hits(), &set);
        let deviation = all.points[0].deviation.as_ref().unwrap();
        assert_eq!(deviation.averages, 5);
        assert!((deviation.with_more(15) / deviation.relative_std - 0.5).abs() < 1e-12);
        let found = resonances(&set).into_iter().filter(|r| r.function == 0);
        let largest = found.map(|r| r.relative_std).fold(0.0, f64::max);
        assert!((deviation.relative_std / largest - 1.0).abs() < 1e-12);
    }
}

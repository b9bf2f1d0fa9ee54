//! Linearity of a test: the resonances whose pole depends on the force, or why none was looked for.

use std::collections::BTreeMap;

use crate::dof::Dof;
use crate::finding::{Code, Finding};
use crate::frf::consistency::force_level::MIN_LEVEL_RANGE_DB;
use crate::frf::force_levels::{MIN_HITS, is_sound};
use crate::frf::hit_report::HitReport;

/// Frequency and damping against the force.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearity {
    /// The excitation point with the widest range of force levels.
    pub reference: Dof,
    /// Its hits.
    pub hits: usize,
    /// From its weakest to its strongest hit, dB.
    pub range_db: f64,
    /// Smallest range from which dependence on the force is estimated, dB.
    pub min_range_db: f64,
    /// Smallest number of hits.
    pub min_hits: usize,
    /// The findings on resonances whose pole depends on the force.
    pub dependences: Vec<Finding>,
}

impl Linearity {
    /// Whether hits and their range suffice for an estimate.
    pub fn is_tested(&self) -> bool {
        self.hits >= self.min_hits && self.range_db >= self.min_range_db
    }
}

/// Linearity of a test with hits.
pub(super) fn linearity(hits: &[HitReport], findings: &[Finding]) -> Linearity {
    let mut peaks: BTreeMap<&Dof, Vec<f64>> = BTreeMap::new();
    for hit in hits {
        let of_point = peaks.entry(&hit.reference).or_default();
        of_point.extend(hit.peak_n.filter(|_| is_sound(hit)).map(f64::abs));
    }
    let of_point = peaks.into_iter().map(|(reference, peaks)| {
        let weakest = peaks.iter().copied().fold(f64::INFINITY, f64::min);
        let strongest = peaks.iter().copied().fold(0.0, f64::max);
        let range_db = match peaks.is_empty() {
            true => 0.0,
            false => 20.0 * (strongest / weakest).log10(),
        };
        Linearity {
            reference: reference.clone(),
            hits: peaks.len(),
            range_db,
            min_range_db: MIN_LEVEL_RANGE_DB,
            min_hits: MIN_HITS,
            dependences: Vec::new(),
        }
    });
    let enough = |point: &Linearity| point.hits >= MIN_HITS;
    let widest = of_point.max_by(|a, b| {
        let by_range = a.range_db.total_cmp(&b.range_db);
        enough(a).cmp(&enough(b)).then(by_range)
    });
    let dependences = findings.iter();
    let dependences = dependences.filter(|finding| finding.code == Code::ForceLevelDependent);
    let widest = widest.expect("a test with hits has an excitation point");
    Linearity {
        dependences: dependences.cloned().collect(),
        ..widest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Location, Severity};

    #[test]
    fn three_hits_over_three_decibels_test_linearity() {
        let hits = |peaks: &[(&str, f64)]| -> Vec<HitReport> {
            let hits = (1..).zip(peaks).map(|(number, (point, peak_n))| HitReport {
                number,
                origin: String::new(),
                reference: point.parse().unwrap(),
                peak_n: Some(*peak_n),
                onset: 0,
                checks: Vec::new(),
                used: true,
                stated: false,
            });
            hits.collect()
        };
        let wide = hits(&[
            ("1:+Z", 10.0),
            ("1:+Z", 12.0),
            ("1:+Z", -20.0),
            ("2:+Z", 5.0),
        ]);
        let tested = linearity(&wide, &[]);
        assert!(
            tested.is_tested() && (tested.range_db - 6.02).abs() < 0.01,
            "{tested:?}"
        );
        assert_eq!(tested.reference.to_string(), "1:+Z");
        let narrow = hits(&[("1:+Z", 10.0), ("1:+Z", 12.0), ("1:+Z", 13.0)]);
        assert!(!linearity(&narrow, &[]).is_tested());
        let two = hits(&[("1:+Z", 10.0), ("1:+Z", 20.0)]);
        assert!(!linearity(&two, &[]).is_tested());
        let finding = |code| Finding::new(Severity::Warning, code, Location::Mode(50.0));
        let findings = [
            finding(Code::LowCoherence),
            finding(Code::ForceLevelDependent),
        ];
        assert_eq!(linearity(&wide, &findings).dependences, findings[1..]);
    }
}

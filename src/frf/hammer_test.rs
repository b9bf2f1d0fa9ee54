//! A recorded hammer test becomes FRFs: every hit is checked, the window is chosen once for the
//! whole test, and the accepted hits are averaged.

use std::collections::BTreeSet;

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::record::Recording;
use crate::signal::{ExponentialWindow, Outcome, Rule};

use super::consistency::check_set;
use super::consistency::visits::Drift;
use super::drift::drift;
use super::estimate::{Estimated, estimate_recording};
use super::force_levels::force_level_findings;
use super::hammer_options::{HammerOptions, ResponseWindow};
use super::hit_report::{HitReport, assess_hits};
use super::selection::Selection;
use super::{EstimateOptions, FrfError};

/// Value at the end of the record of a window that is not specified (Fladung and Rost 1997,
/// Application and correction of the exponential window for frequency response functions: about 1
/// %).
const WINDOW_END: f64 = 0.01;

/// Largest truncation error of H at which its sign at a resonance is tested: two degrees of phase.
const MAX_TRUNCATION_ERROR: f64 = 0.035;

/// The result of a hammer test.
#[derive(Clone, Debug)]
pub struct HammerTestResult {
    /// FRFs.
    pub estimated: Estimated,
    /// Every hit with what the rules said of it, in order.
    pub hits: Vec<HitReport>,
    /// The band in which the hammer excites and the filter is open.
    pub usable: Band,
    /// The options as decided, with the exponential window that was used.
    pub estimate: EstimateOptions,
    /// Changes at a point that was hit again after others.
    pub drift: Option<Drift>,
}

/// Assesses every hit that the user does not reject, decides the window and estimates the FRFs of
/// the accepted hits.
///
/// One exponential window serves the whole test, so that every pole gets the same added damping.
/// With it the records begin at their pulse, see [`EstimateOptions::cut_pretrigger`]. Where the
/// rules would reject all hits of an excitation point, its hits are used all the same, with a
/// finding.
///
/// # Errors
/// As [`estimate_recording`]; [`FrfError::HitNumber`] for a stated hit that is not there;
/// [`FrfError::BandEmpty`] when the force excites no band.
pub fn evaluate_hammer_test(
    recording: &mut dyn Recording,
    options: &HammerOptions,
) -> Result<HammerTestResult, FrfError> {
    options.limits.validate()?;
    check_hit_numbers(recording.hits().len(), options)?;
    let mut hits = assess_hits(recording, options)?;
    let mut findings = decide_hits(&mut hits, options);
    let selection = Selection {
        hits: (0..hits.len()).filter(|hit| hits[*hit].used).collect(),
        overloads: (!options.keep_all).then_some(options.limits),
        accepted: options.accept.iter().map(|number| number - 1).collect(),
    };
    let (estimate, finding) = decide_window(recording, &hits, options)?;
    findings.extend(finding);
    let mut estimated = estimate_recording(recording, &selection, &estimate)?;
    let usable = estimated.set.valid_band.ok_or(FrfError::BandEmpty {
        lo_hz: estimated.set.axis().hz(1),
        hi_hz: 0.0,
    })?;
    let estimation_findings = std::mem::take(&mut estimated.set.findings);
    // Hit report and estimation both find a clipped response; the finding is kept once.
    let new: Vec<Finding> = estimation_findings
        .into_iter()
        .filter(|f| !findings.contains(f))
        .collect();
    findings.extend(new);
    // A response that is cut off turns phases at its resonances, as a wrong sign does.
    let cut_off = |f: &Finding| f.code == Code::Truncated && f.value > Some(MAX_TRUNCATION_ERROR);
    let truncated = findings.iter().any(cut_off);
    let checks = check_set(&estimated.set).into_iter();
    findings.extend(checks.filter(|f| !(truncated && f.code == Code::DrivingPointSign)));
    let by_level = force_level_findings(recording, &hits, &estimated.set, &selection, &estimate);
    findings.extend(by_level);
    let drift = drift(recording, &hits, &estimated.set, &selection, &estimate);
    estimated.set.findings = findings;
    Ok(HammerTestResult {
        drift,
        estimated,
        hits,
        usable,
        estimate,
    })
}

/// The hits that the user names must be there, and some must be left.
fn check_hit_numbers(expected: usize, options: &HammerOptions) -> Result<(), FrfError> {
    let stated = options.accept.iter().chain(&options.reject);
    let mut absent = stated.filter(|number| !(1..=expected).contains(*number));
    if let Some(got) = absent.next() {
        return Err(FrfError::HitNumber {
            got: *got,
            expected,
        });
    }
    if let Some(both) = options.accept.intersection(&options.reject).next() {
        return Err(FrfError::HitInBoth { got: *both });
    }
    if options.reject.len() == expected {
        return Err(FrfError::NoHits);
    }
    Ok(())
}

/// Says of every hit whether it is used; the findings of those that the rules do not pass.
fn decide_hits(hits: &mut [HitReport], options: &HammerOptions) -> Vec<Finding> {
    for (index, hit) in hits.iter_mut().enumerate() {
        let number = index + 1;
        let rejected = hit.checks.iter().any(|check| hit.rejects(check));
        hit.stated = options.accept.contains(&number) || options.reject.contains(&number);
        hit.used = options.accept.contains(&number)
            || !(options.reject.contains(&number) || (rejected && !options.keep_all));
    }
    let mut findings = Vec::new();
    let points: BTreeSet<_> = hits.iter().map(|hit| hit.reference.clone()).collect();
    for point in points {
        let assessed = || {
            hits.iter()
                .filter(|hit| hit.reference == point && !hit.stated)
        };
        let none_left = !hits.iter().any(|hit| hit.reference == point && hit.used);
        if none_left && assessed().count() > 0 {
            let location = Location::Function {
                response: None,
                reference: Some(point.clone()),
            };
            let count = assessed().count() as f64;
            findings.push(
                Finding::new(Severity::Warning, Code::NoHitPassed, location).value(count, "hits"),
            );
            for hit in hits.iter_mut().filter(|hit| hit.reference == point) {
                hit.used = !options.reject.contains(&hit.number);
            }
        }
    }
    findings.extend(hits.iter().flat_map(HitReport::findings));
    findings.extend(roll_off_finding(hits));
    findings
}

/// One finding for the hit of which the force spectrum falls off first.
fn roll_off_finding(hits: &[HitReport]) -> Option<Finding> {
    let noted = hits.iter().filter(|hit| hit.used).flat_map(|hit| {
        let checks = hit.checks.iter();
        let checks =
            checks.filter(|check| check.rule == Rule::RollOff && check.outcome == Outcome::Noted);
        checks.filter_map(|check| Some((hit.number, check.at?)))
    });
    let (number, at_hz) = noted.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let finding = Finding::new(Severity::Info, Code::ForceRollOff, Location::Hit(number));
    Some(finding.value(at_hz, "Hz"))
}

/// The options with the window that the responses need, and the finding that says so.
fn decide_window(
    recording: &dyn Recording,
    hits: &[HitReport],
    options: &HammerOptions,
) -> Result<(EstimateOptions, Option<Finding>), FrfError> {
    let (end, finding) = match options.response_window {
        ResponseWindow::Off => (None, largest_end_amplitude(hits).map(not_decayed_finding)),
        ResponseWindow::End(end) => (Some(end), None),
        ResponseWindow::Auto => match largest_end_amplitude(hits) {
            None => (None, None),
            Some(left) => {
                let finding = Finding::new(Severity::Info, Code::WindowAdded, Location::Whole);
                (
                    Some(WINDOW_END),
                    Some(finding.value(left, "").limit(WINDOW_END)),
                )
            }
        },
    };
    let cut = options.cut_pretrigger.unwrap_or(end.is_some());
    let duration_s = shortest_response_s(recording, hits);
    let window = |end| ExponentialWindow::from_end_value(end, duration_s);
    let estimate = EstimateOptions {
        exponential: end.map(window).transpose()?,
        cut_pretrigger: cut,
        ..options.estimate
    };
    Ok((estimate, finding))
}

/// A response still rings at the end of its record and no window is wanted.
fn not_decayed_finding(left: f64) -> Finding {
    Finding::new(Severity::Warning, Code::NotDecayed, Location::Whole)
        .value(left, "")
        .limit(WINDOW_END)
}

/// The largest amplitude that is left at the end of a used record, where it is above its limit.
fn largest_end_amplitude(hits: &[HitReport]) -> Option<f64> {
    hits.iter()
        .filter(|hit| hit.used)
        .flat_map(|hit| &hit.checks)
        .filter(|check| check.rule == Rule::Decay && check.outcome != Outcome::Passed)
        .filter(|check| check.outcome != Outcome::NotDecidable)
        .filter_map(|check| check.value)
        .max_by(f64::total_cmp)
}

/// From the hit to the end of the record, s: the shortest of the used hits.
fn shortest_response_s(recording: &dyn Recording, hits: &[HitReport]) -> f64 {
    let of = |hit: &HitReport| {
        let axis = recording.hits()[hit.number - 1].axis;
        (axis.len - hit.onset) as f64 * axis.step_s
    };
    let used = hits.iter().filter(|hit| hit.used);
    used.map(of).fold(f64::INFINITY, f64::min)
}

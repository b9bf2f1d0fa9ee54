//! A constant delay between force and responses, from the phases of the residues.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use num_complex::Complex64;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};

use super::driving_point::CLEAR_PEAK_OVER_NOISE;
use super::mobility::Mobilities;
use crate::frf::local_pole::{LocalPole, ResonanceLines};
use crate::frf::peaks::{Peak, clear_peaks};

/// Fewest lines between half-power points for the fit of one resonance.
pub(super) const MIN_LINES_PER_BANDWIDTH: f64 = 5.0;
/// Half-power widths fitted on each side of a peak.
pub(super) const FIT_HALF_WIDTH_BANDWIDTHS: f64 = 1.0;
/// Fewest resonances of one response: two determine a line through the origin with its scatter, the
/// third tests it against chance.
const MIN_PEAKS: usize = 3;
/// Largest standard deviation of a phase, rad; above it noise may wrap the phase, and the resonance
/// is not used.
const MAX_PHASE_STD_RAD: f64 = 0.1;
/// Largest delay of the search, sampling intervals, of both signs.
const MAX_DELAY_SAMPLES: f64 = 4.0;
/// Steps per interval: a quarter of the limit.
const STEPS_PER_SAMPLE: f64 = 16.0;
/// Mean `1 − cos 2r` of the residual phases by which two delays are as good as each other: what
/// 0.16 rad make.
const MAX_EQUIVALENT_COST_RISE: f64 = 0.05;
/// Probability of a scatter that looks like a delay, one side.
const FALSE_ALARM_PROBABILITY: f64 = 5e-4;
/// Limit in sampling intervals: converters out of step are late by half an interval or a whole one;
/// half of the lesser.
const MIN_DELAY_LIMIT_SAMPLES: f64 = 0.25;

/// Angular frequency and phase of one residue.
struct ResiduePhase {
    omega: f64,
    phase: f64,
    variance: f64,
}

/// A delay with its limit, s.
struct Delay {
    tau_s: f64,
    limit_s: f64,
}

/// Real modes have residues of the mobility on the real axis, whatever pair they belong to: a delay
/// `τ` turns them by `−ωτ`. All functions of one response are taken together; signs do not count
/// (phases modulo π).
///
/// A positive value is a late response. Complex modes scatter the phases, and the limit is the
/// larger of a quarter of the sampling interval `1/(2 f_max)` and the deviation that the scatter
/// explains, by Student's t with the resonances less one. Responses that are all late or all early
/// alike give one finding for the test (the force is out of step). Less than three clear resonances
/// say nothing. An acausal impulse response would tell early responses alone, and only beyond its
/// ringing.
pub(super) fn findings(data: &Mobilities) -> Vec<Finding> {
    let mut responses = BTreeMap::<Dof, Vec<usize>>::new();
    for (i, function) in data.functions().iter().enumerate() {
        let group = responses.entry(function.response.clone());
        group.or_default().push(i);
    }
    let delays: Vec<(&Dof, Delay)> = responses
        .iter()
        .filter_map(|(response, functions)| {
            let phases: Vec<ResiduePhase> = functions
                .iter()
                .flat_map(|i| residue_phases(data, *i))
                .collect();
            Some((response, estimate_delay(&phases, 0.5 / data.last_hz())?))
        })
        .collect();
    let beyond = |d: &Delay| d.tau_s.abs() > d.limit_s;
    let late = delays.iter().filter(|(_, d)| beyond(d) && d.tau_s > 0.0);
    let late = late.count();
    let out = delays.iter().filter(|(_, d)| beyond(d)).count();
    if out > 1 && out == delays.len() && (late == 0 || late == out) {
        let worst = delays
            .iter()
            .max_by(|a, b| a.1.tau_s.abs().total_cmp(&b.1.tau_s.abs()));
        return worst
            .map(|(_, d)| delay_finding(Location::Whole, d))
            .into_iter()
            .collect();
    }
    let one = |(response, d): &(&Dof, Delay)| {
        let location = Location::Function {
            response: Some((*response).clone()),
            reference: None,
        };
        beyond(d).then(|| delay_finding(location, d))
    };
    delays.iter().filter_map(one).collect()
}

fn delay_finding(location: Location, delay: &Delay) -> Finding {
    Finding::new(Severity::Warning, Code::ChannelDelay, location)
        .value(delay.tau_s, "s")
        .limit(delay.limit_s)
}

/// Residue phases of the clear resonances of one function.
fn residue_phases(data: &Mobilities, i: usize) -> Vec<ResiduePhase> {
    let (values, variance) = (data.values(i), data.variance(i));
    let power: Vec<f64> = values.iter().map(Complex64::norm_sqr).collect();
    let floor: Vec<f64> = data
        .noise(i)
        .iter()
        .map(|noise| CLEAR_PEAK_OVER_NOISE * noise)
        .collect();
    let peaks = clear_peaks(&power, &floor, MIN_LINES_PER_BANDWIDTH);
    let fit = |peak: &Peak| {
        let lines = fit_lines(peak, power.len())?;
        ResonanceLines::of(lines, &data.omega, &values, &variance).fit()
    };
    let phase = |pole: LocalPole| ResiduePhase {
        omega: pole.lambda.im,
        phase: pole.residue.arg(),
        variance: pole.phase_variance,
    };
    let known = MAX_PHASE_STD_RAD * MAX_PHASE_STD_RAD;
    let fits = peaks.iter().filter_map(fit);
    fits.filter(|pole| pole.phase_variance < known && pole.background < 0.5)
        .map(phase)
        .collect()
}

/// The lines that a fit of one resonance uses; `None` when the band ends within them.
pub(super) fn fit_lines(peak: &Peak, lines: usize) -> Option<std::ops::Range<usize>> {
    let first = peak.lower - (FIT_HALF_WIDTH_BANDWIDTHS - 0.5) * peak.width();
    let end = peak.upper + (FIT_HALF_WIDTH_BANDWIDTHS - 0.5) * peak.width() + 1.0;
    (first >= 0.0 && end <= lines as f64).then(|| first.ceil() as usize..end.floor() as usize)
}

/// The smallest delay that explains the phases as well as any does.
fn estimate_delay(phases: &[ResiduePhase], interval_s: f64) -> Option<Delay> {
    if phases.len() < MIN_PEAKS {
        return None;
    }
    let step_s = interval_s / STEPS_PER_SAMPLE;
    let steps = (MAX_DELAY_SAMPLES * STEPS_PER_SAMPLE) as i32;
    let cost = |step: i32| {
        let tau = f64::from(step) * step_s;
        let cosines = phases
            .iter()
            .map(|p| (2.0 * (p.phase + p.omega * tau)).cos());
        1.0 - cosines.sum::<f64>() / phases.len() as f64
    };
    let best = (-steps..=steps).map(cost).min_by(f64::total_cmp)?;
    let nearest = (-steps..=steps)
        .filter(|step| cost(*step) <= best + MAX_EQUIVALENT_COST_RISE)
        .min_by_key(|step| step.abs())?;
    Some(refine_delay(
        phases,
        f64::from(nearest) * step_s,
        interval_s,
    ))
}

/// Least squares of the phases about a first delay, turn by turn: `τ = −Σωφ/Σω²`.
fn refine_delay(phases: &[ResiduePhase], first_s: f64, interval_s: f64) -> Delay {
    let squares: f64 = phases.iter().map(|p| p.omega * p.omega).sum();
    let residual = |p: &ResiduePhase, tau: f64| {
        let turned = p.phase + p.omega * tau;
        turned - PI * (turned / PI).round()
    };
    let mut tau_s = first_s;
    // Each turn is a whole least-squares step; more than one only moves phases that wrapped round.
    for _ in 0..8 {
        let slope: f64 = phases.iter().map(|p| p.omega * residual(p, tau_s)).sum();
        tau_s -= slope / squares;
    }
    let freedom = (phases.len() - 1) as f64;
    let scatter: f64 = phases.iter().map(|p| residual(p, tau_s).powi(2)).sum();
    let noise: f64 = phases.iter().map(|p| p.variance).sum();
    let variance = (scatter / freedom).max(noise / phases.len() as f64) / squares;
    let quantile = StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| {
        t.inverse_cdf(1.0 - FALSE_ALARM_PROBABILITY)
    });
    Delay {
        tau_s,
        limit_s: (MIN_DELAY_LIMIT_SAMPLES * interval_s).max(quantile * variance.sqrt()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::FrfSet;
    use crate::frf::consistency::synthetic::{Beam, add_noise, delayed, joined};

    /// Half of one over the last line, 500 Hz.
    const INTERVAL_S: f64 = 1e-3;

    fn found(set: &FrfSet) -> Vec<Finding> {
        findings(&Mobilities::new(set).unwrap())
    }

    #[test]
    fn delays_of_either_sign_are_measured_at_any_pair() {
        for pair in [("1:+Z", "1:+Z"), ("4:-Z", "1:+Z"), ("5:+Z", "2:+Z")] {
            for samples in [-2.0, -0.5, 0.3, 0.5, 1.0, 3.0] {
                let mut set = delayed(&Beam::default().set(&[pair]), samples * INTERVAL_S);
                add_noise(&mut set, 40.0, 11);
                let findings = found(&set);
                assert_eq!(findings.len(), 1, "{pair:?} {samples}");
                let value = findings[0].value.unwrap() / INTERVAL_S;
                // The delay turns the phase within the fitted lines too, which the model does not
                // hold.
                assert!((value - samples).abs() < 0.02, "{pair:?} {samples} {value}");
            }
            assert!(found(&Beam::default().set(&[pair])).is_empty());
            let little = delayed(&Beam::default().set(&[pair]), 0.2 * INTERVAL_S);
            assert!(found(&little).is_empty());
        }
    }

    #[test]
    fn one_delayed_response_is_reported_and_a_delayed_force_once() {
        let set = Beam::default().set(&[("1:+Z", "1:+Z"), ("4:+Z", "1:+Z")]);
        let late = delayed(&Beam::default().set(&[("2:+Z", "1:+Z")]), INTERVAL_S);
        let findings = found(&joined(&[set.clone(), late]));
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].location.to_string(), "channel 2:+Z");
        let findings = found(&delayed(&set, -INTERVAL_S));
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].location, Location::Whole);
        assert!(findings[0].value.unwrap() < 0.0);
    }

    #[test]
    fn a_wrong_sign_is_no_delay_and_scattered_phases_decide_nothing() {
        let set = Beam::default().relabelled(("1:+Z", "1:+Z"), ("1:-Z", "1:+Z"));
        assert!(found(&set).is_empty());
        let phase = |omega: f64, phase: f64| ResiduePhase {
            omega,
            phase,
            variance: 1e-6,
        };
        let scattered = [
            phase(400.0, 0.4),
            phase(900.0, -0.3),
            phase(1500.0, 0.5),
            phase(2500.0, -0.6),
        ];
        let delay = estimate_delay(&scattered, INTERVAL_S).unwrap();
        assert!(delay.tau_s.abs() < delay.limit_s);
        assert!(super::estimate_delay(&scattered[..2], INTERVAL_S).is_none());
    }
}

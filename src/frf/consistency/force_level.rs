//! Linearity: natural frequency and damping of isolated resonances in single hits, against the
//! force of the hit.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::channel_delay::fit_lines;
use super::mass_loading::SummedFrfs;
use super::mobility::Mobilities;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::frf::local_pole::ResonanceLines;
use crate::frf::peaks::Peak;

/// Probability that noise alone gives a finding for a test.
const FALSE_ALARM_PROBABILITY: f64 = 1e-3;
/// Frequency shift for each doubling of the force, in half-power bandwidths, below which it is
/// without consequence: an FRF at the half-power point then changes by 3 %.
const MIN_SHIFT_BANDWIDTHS: f64 = 0.02;
/// Relative change of the damping for each doubling of the force below which it is without
/// consequence.
const MIN_DAMPING_CHANGE: f64 = 0.03;
/// Doubling of the force, dB.
const DOUBLING_DB: f64 = 6.020_599_913_279_624;

/// FRFs of one hit at each excitation point.
pub(in crate::frf) struct SingleHits {
    pub set: FrfSet,
    /// Peak force of the hit at each excitation point, dB over 1 N.
    pub levels_db: BTreeMap<Dof, f64>,
}

/// Pole of a resonance in one function of one hit.
struct HitPole {
    /// Number of the [`SingleHits`]; with the excitation point it is a hit.
    round: usize,
    response: Dof,
    reference: Dof,
    level_db: f64,
    lambda: Complex64,
    /// Of the decay rate as of the frequency, (rad/s)².
    variance: f64,
}

/// A hit: force and pole less the means of its excitation point.
struct HitDeviation {
    /// Function of the force level on which the pole may depend.
    force: f64,
    lambda: Complex64,
    weight: f64,
}

/// The functions of the level in dB on which a pole may depend: the level itself, and the square of
/// the force, as with a cubic stiffness.
const DEPENDENCES: [fn(f64) -> f64; 2] =
    [|level_db| level_db, |level_db| 10_f64.powf(0.1 * level_db)];

/// A finding for every isolated resonance whose frequency or damping depends on the force level.
///
/// For each hit the pole `λ` of the resonance is fitted to each function of the hit alone. The
/// deviation of a hit is the weighted mean over its functions of `λ` less the mean of that function
/// over all hits: a sensor or a point with another frequency drops out. The slopes of `Im λ` and
/// `-Re λ` against `x = log F` or `x = F²`, F the peak of the force, follow from weighted least
/// squares within each excitation point,
///
/// `b = Σ w x d / Σ w x²`, `var(b) = Σ w (d - b x)² / ((n - 1) Σ w x²)`,
///
/// with n the hits less their excitation points. A slope counts where Student's t of `n - 1`
/// degrees of freedom exceeds its quantile and the change for each doubling of the force is of
/// consequence. Of the two dependences the one with the smaller residual is stated.
///
/// # Reference
/// Worden and Tomlinson (2001), Nonlinearity in Structural Dynamics, section 3.2 (homogeneity).
pub(in crate::frf) fn findings(
    averaged: &FrfSet,
    hits: impl Iterator<Item = SingleHits>,
) -> Vec<Finding> {
    let Some(data) = Mobilities::new(averaged) else {
        return Vec::new();
    };
    let peaks = SummedFrfs::new(&data).isolated_peaks();
    let mut poles: Vec<Vec<HitPole>> = peaks.iter().map(|_| Vec::new()).collect();
    for (round, mut single) in hits.enumerate() {
        // The lines of the peaks are those of the averaged functions.
        single.set.valid_band = averaged.valid_band;
        let Some(hit) = Mobilities::new(&single.set) else {
            continue;
        };
        let of_function = |i: usize| {
            let (values, variance) = (hit.values(i), hit.variance(i));
            let pole = |peak| {
                let lines = fit_lines(peak, data.omega.len())?;
                ResonanceLines::of(lines, &data.omega, &values, &variance).fit()
            };
            peaks.iter().map(pole).collect::<Vec<_>>()
        };
        let functions = hit.functions();
        let fitted: Vec<_> = (0..functions.len())
            .into_par_iter()
            .map(of_function)
            .collect();
        for (function, fitted) in functions.iter().zip(fitted) {
            for (poles, pole) in poles.iter_mut().zip(fitted) {
                let level_db = single.levels_db.get(&function.reference);
                if let (Some(pole), Some(level_db)) = (pole, level_db) {
                    poles.push(HitPole {
                        round,
                        response: function.response.clone(),
                        reference: function.reference.clone(),
                        level_db: *level_db,
                        lambda: pole.lambda,
                        variance: pole.frequency_variance.max(f64::MIN_POSITIVE),
                    });
                }
            }
        }
    }
    // Frequency and damping of each resonance.
    let tests = 2 * DEPENDENCES.len() * peaks.len();
    let finding = |(peak, poles): (&Peak, &Vec<HitPole>)| {
        let width_rad_s = peak.width() * (data.omega[1] - data.omega[0]);
        let slopes = DEPENDENCES.iter().filter_map(|x| Slopes::of(poles, *x));
        let mut slopes: Vec<Slopes> = slopes.collect();
        slopes.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
        let mut findings = slopes
            .iter()
            .filter_map(|s| s.finding(width_rad_s, averaged.added_damping_rad_s, tests));
        findings.next()
    };
    peaks.iter().zip(&poles).filter_map(finding).collect()
}

/// Change of a pole from the weakest to the strongest hit.
struct Slopes {
    /// Mean pole.
    lambda: Complex64,
    change: Complex64,
    /// Standard deviations of its real and its imaginary part.
    stds: [f64; 2],
    /// Weighted sum of squares of what the slopes do not explain.
    misfit: f64,
    freedom: f64,
    hits: usize,
    /// Highest over lowest level at one excitation point, dB.
    range_db: f64,
}

impl Slopes {
    /// `None` where less than one degree of freedom is left.
    fn of(poles: &[HitPole], dependence: fn(f64) -> f64) -> Option<Self> {
        let points = deviations(poles, dependence);
        let hits: usize = points.iter().map(Vec::len).sum();
        let freedom = hits.checked_sub(points.len() + 1).filter(|n| *n > 0)? as f64;
        let all = || points.iter().flatten();
        let square: f64 = all().map(|hit| hit.weight * hit.force.powi(2)).sum();
        let cross: Complex64 = all().map(|hit| hit.weight * hit.force * hit.lambda).sum();
        let slope = cross / square;
        let misfit = |part: fn(Complex64) -> f64| -> f64 {
            let of = |hit: &HitDeviation| hit.weight * part(hit.lambda - hit.force * slope).powi(2);
            all().map(of).sum()
        };
        let misfits = [misfit(|z| z.re), misfit(|z| z.im)];
        let span = points
            .iter()
            .map(|hits| range(hits.iter().map(|hit| hit.force)));
        let span = span.fold(0.0, f64::max);
        let range_db = points_of(poles).into_values();
        let range_db = range_db.map(|poles| range(poles.iter().map(|pole| pole.level_db)));
        let (weights, sum) = poles.iter().fold((0.0, Complex64::ZERO), |(w, sum), pole| {
            (w + 1.0 / pole.variance, sum + pole.lambda / pole.variance)
        });
        Some(Slopes {
            lambda: sum / weights,
            change: span * slope,
            stds: misfits.map(|misfit| span * (misfit / (freedom * square)).sqrt()),
            misfit: misfits[0] + misfits[1],
            freedom,
            hits,
            range_db: range_db.fold(0.0, f64::max),
        })
    }

    /// `tests`: number of slopes among which this is a false alarm with the stated probability.
    fn finding(&self, width_rad_s: f64, added_rad_s: f64, tests: usize) -> Option<Finding> {
        let student = StudentsT::new(0.0, 1.0, self.freedom).ok()?;
        let limit = student.inverse_cdf(1.0 - 0.5 * FALSE_ALARM_PROBABILITY / tests as f64);
        let decay = -self.lambda.re - added_rad_s;
        let doublings = self.range_db / DOUBLING_DB;
        let is_frequency_dependent = self.change.im.abs() > limit * self.stds[1]
            && self.change.im.abs() > MIN_SHIFT_BANDWIDTHS * width_rad_s * doublings;
        let is_damping_dependent = self.change.re.abs() > limit * self.stds[0]
            && decay > 0.0
            && self.change.re.abs() > MIN_DAMPING_CHANGE * decay * doublings;
        if !(is_frequency_dependent || is_damping_dependent) {
            return None;
        }
        let omega = self.lambda.im;
        let percent = 100.0 / omega;
        let of_decay = 100.0 / decay;
        let detail = format!(
            "over {:.1} dB of force: frequency {:+.3} ± {:.3} %, damping {:+.1} ± {:.1} %; {} hits",
            self.range_db,
            percent * self.change.im,
            percent * self.stds[1],
            -of_decay * self.change.re,
            of_decay * self.stds[0],
            self.hits,
        );
        let location = Location::Mode(omega / std::f64::consts::TAU);
        let finding = Finding::new(Severity::Warning, Code::ForceLevelDependent, location);
        Some(finding.value(percent * self.change.im, "%").detail(detail))
    }
}

fn range(values: impl Iterator<Item = f64>) -> f64 {
    let (lowest, highest) = values.fold((f64::MAX, f64::MIN), |(lo, hi), value| {
        (lo.min(value), hi.max(value))
    });
    highest - lowest
}

fn points_of(poles: &[HitPole]) -> BTreeMap<&Dof, Vec<&HitPole>> {
    let mut points: BTreeMap<&Dof, Vec<&HitPole>> = BTreeMap::new();
    for pole in poles {
        points.entry(&pole.reference).or_default().push(pole);
    }
    points
}

/// The hits of each excitation point, their forces and poles less the weighted means of the point.
fn deviations(poles: &[HitPole], dependence: fn(f64) -> f64) -> Vec<Vec<HitDeviation>> {
    let mut functions: BTreeMap<(&Dof, &Dof), Vec<&HitPole>> = BTreeMap::new();
    for pole in poles {
        let key = (&pole.reference, &pole.response);
        functions.entry(key).or_default().push(pole);
    }
    let mut points: BTreeMap<&Dof, BTreeMap<usize, HitDeviation>> = BTreeMap::new();
    for ((reference, _), poles) in functions {
        let weights: f64 = poles.iter().map(|pole| 1.0 / pole.variance).sum();
        let mean = poles.iter().map(|pole| pole.lambda / pole.variance);
        let mean = mean.sum::<Complex64>() / weights;
        for pole in poles {
            let hits = points.entry(reference).or_default();
            let hit = hits.entry(pole.round).or_insert(HitDeviation {
                force: dependence(pole.level_db),
                lambda: Complex64::ZERO,
                weight: 0.0,
            });
            hit.lambda += (pole.lambda - mean) / pole.variance;
            hit.weight += 1.0 / pole.variance;
        }
    }
    let centred = |hits: BTreeMap<usize, HitDeviation>| {
        let mut hits: Vec<HitDeviation> = hits.into_values().collect();
        hits.iter_mut().for_each(|hit| hit.lambda /= hit.weight);
        let weights: f64 = hits.iter().map(|hit| hit.weight).sum();
        let force = hits.iter().map(|hit| hit.weight * hit.force);
        let force = force.sum::<f64>() / weights;
        let lambda = hits.iter().map(|hit| hit.weight * hit.lambda);
        let lambda = lambda.sum::<Complex64>() / weights;
        for hit in &mut hits {
            hit.force -= force;
            hit.lambda -= lambda;
        }
        hits
    };
    points.into_values().map(centred).collect()
}

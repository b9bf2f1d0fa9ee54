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

/// Smallest difference of the force levels of a series of hits from which dependence on the force
/// is estimated, dB: a smaller one divides the scatter of other causes by little.
pub(in crate::frf) const MIN_LEVEL_RANGE_DB: f64 = 3.0;
/// Probability that noise alone gives a finding for a test.
const FALSE_ALARM_PROBABILITY: f64 = 1e-3;
/// Frequency shift for each doubling of the force, in half-power bandwidths, below which it is
/// without consequence: an FRF at the half-power point then changes by 3 %.
const MIN_SHIFT_BANDWIDTHS: f64 = 0.02;
/// Relative change of the damping for each doubling of the force below which it is without
/// consequence.
const MIN_DAMPING_CHANGE: f64 = 0.03;
/// Correlation of force and order of the hits above which a drift looks like a dependence on the
/// force.
const MAX_ORDER_CORRELATION: f64 = 0.8;
/// Doubling of the force, dB.
const DOUBLING_DB: f64 = 6.020_599_913_279_624;

/// FRFs of one hit at each excitation point.
pub(in crate::frf) struct SingleHits {
    pub set: FrfSet,
    /// The hit at each excitation point.
    pub levels: BTreeMap<Dof, HitLevel>,
}

/// The force of a hit.
#[derive(Clone, Copy)]
pub(in crate::frf) struct HitLevel {
    /// Peak force, dB over 1 N.
    pub level_db: f64,
    /// Number of its series: hits at one point with the same sensors.
    pub series: usize,
}

/// Pole of a resonance in one function of one hit.
struct HitPole {
    /// Number of the [`SingleHits`]; with the series it is a hit.
    turn: usize,
    response: Dof,
    level: HitLevel,
    lambda: Complex64,
    /// Of the decay rate as of the frequency, (rad/s)².
    variance: f64,
}

/// A hit: `x` and pole less the means of its series.
struct HitDeviation {
    /// Function of the force level on which the pole may depend.
    x: f64,
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
/// deviation of a hit is the weighted mean over its functions of `λ` less the mean of that
/// function over the hits of its series, those at one point with the same sensors: a sensor or a
/// point with another frequency drops out. The slopes of `Im λ` and `-Re λ` against `x = log F` or
/// `x = F²`, F the peak of the force, follow from weighted least squares within each series,
///
/// `b = Σ w x d / Σ w x²`, `var(b) = Σ w (d - b x)² / ((n - 1) Σ w x²)`,
///
/// with n the hits less their series. A slope counts where Student's t of `n - 1` degrees of
/// freedom exceeds its quantile and the change for each doubling of the force is of consequence.
/// Of the two dependences the one with the smaller residual is stated.
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
    // Lines of the averaged functions; those of a single hit may have another spacing.
    let ranges: Vec<Option<[f64; 2]>> = peaks
        .iter()
        .map(|peak| {
            let lines = fit_lines(peak, data.omega.len())?;
            Some([data.omega[lines.start], data.omega[lines.end - 1]])
        })
        .collect();
    if ranges.iter().all(Option::is_none) {
        return Vec::new();
    }
    let mut poles: Vec<Vec<HitPole>> = peaks.iter().map(|_| Vec::new()).collect();
    for (turn, mut single) in hits.enumerate() {
        single.set.valid_band = averaged.valid_band;
        let Some(hit) = Mobilities::new(&single.set) else {
            continue;
        };
        let of_function = |i: usize| {
            let (values, variance) = (hit.values(i), hit.variance(i));
            let pole = |range: &Option<[f64; 2]>| {
                let [first, last] = (*range)?;
                let start = hit.omega.partition_point(|omega| *omega < first);
                let end = hit.omega.partition_point(|omega| *omega <= last);
                ResonanceLines::of(start..end, &hit.omega, &values, &variance).fit()
            };
            ranges.iter().map(pole).collect::<Vec<_>>()
        };
        let functions = hit.functions();
        let fitted: Vec<_> = (0..functions.len())
            .into_par_iter()
            .map(of_function)
            .collect();
        for (function, fitted) in functions.iter().zip(fitted) {
            let Some(level) = single.levels.get(&function.reference) else {
                continue;
            };
            for (poles, pole) in poles.iter_mut().zip(fitted) {
                poles.extend(pole.map(|pole| HitPole {
                    turn,
                    response: function.response.clone(),
                    level: *level,
                    lambda: pole.lambda,
                    variance: pole.frequency_variance.max(f64::MIN_POSITIVE),
                }));
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
    /// Correlation of the force with the order of the hits.
    order_correlation: f64,
    /// Highest over lowest level of the series with the largest change, dB.
    range_db: f64,
}

impl Slopes {
    /// `None` where less than one degree of freedom is left.
    fn of(poles: &[HitPole], dependence: fn(f64) -> f64) -> Option<Self> {
        let series = deviations(poles, |hit| dependence(hit.level.level_db));
        let hits: usize = series.values().map(Vec::len).sum();
        let freedom = hits.checked_sub(series.len() + 1).filter(|n| *n > 0)? as f64;
        let all = || series.values().flatten();
        let square: f64 = all().map(|hit| hit.weight * hit.x.powi(2)).sum();
        let cross: Complex64 = all().map(|hit| hit.weight * hit.x * hit.lambda).sum();
        let slope = cross / square;
        let misfit = |part: fn(Complex64) -> f64| -> f64 {
            let of = |hit: &HitDeviation| hit.weight * part(hit.lambda - hit.x * slope).powi(2);
            all().map(of).sum()
        };
        let misfits = [misfit(|z| z.re), misfit(|z| z.im)];
        let span = |hits: &Vec<HitDeviation>| range(hits.iter().map(|hit| hit.x));
        let spans = series.iter().map(|(number, hits)| (*number, span(hits)));
        let (widest, span) = spans.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let of_widest = poles.iter().filter(|pole| pole.level.series == widest);
        let (weights, sum) = poles.iter().fold((0.0, Complex64::ZERO), |(w, sum), pole| {
            (w + 1.0 / pole.variance, sum + pole.lambda / pole.variance)
        });
        let order = deviations(poles, |hit| hit.turn as f64);
        let order = order.values().flatten();
        let (mut with_order, mut order_square) = (0.0, 0.0);
        for (hit, order) in all().zip(order) {
            with_order += hit.weight * hit.x * order.x;
            order_square += hit.weight * order.x.powi(2);
        }
        Some(Slopes {
            order_correlation: with_order / (square * order_square).sqrt(),
            lambda: sum / weights,
            change: span * slope,
            stds: misfits.map(|misfit| span * (misfit / (freedom * square)).sqrt()),
            misfit: misfits[0] + misfits[1],
            freedom,
            hits,
            range_db: range(of_widest.map(|pole| pole.level.level_db)),
        })
    }

    /// `tests`: number of slopes among which this is a false alarm with the stated probability.
    fn finding(&self, width_rad_s: f64, added_rad_s: f64, tests: usize) -> Option<Finding> {
        let student = StudentsT::new(0.0, 1.0, self.freedom).ok()?;
        let limit = student.inverse_cdf(1.0 - 0.5 * FALSE_ALARM_PROBABILITY / tests as f64);
        let decay = -self.lambda.re - added_rad_s;
        let doublings = self.range_db / DOUBLING_DB;
        if self.range_db < MIN_LEVEL_RANGE_DB {
            return None;
        }
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
        let damping = match decay > 0.0 {
            true => format!(
                ", damping {:+.1} ± {:.1} %",
                -of_decay * self.change.re,
                of_decay * self.stds[0]
            ),
            false => String::new(),
        };
        let order = match self.order_correlation.abs() > MAX_ORDER_CORRELATION {
            true => "; force and order of the hits go together",
            false => "",
        };
        let detail = format!(
            "from the weakest to the strongest hit ({:.1} dB): frequency {:+.3} ± {:.3} %{damping}; {} hits{order}",
            self.range_db,
            percent * self.change.im,
            percent * self.stds[1],
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

/// The hits of each series, their `x` and poles less the weighted means of the series.
fn deviations(
    poles: &[HitPole],
    x: impl Fn(&HitPole) -> f64,
) -> BTreeMap<usize, Vec<HitDeviation>> {
    let mut functions: BTreeMap<(usize, &Dof), Vec<&HitPole>> = BTreeMap::new();
    for pole in poles {
        let key = (pole.level.series, &pole.response);
        functions.entry(key).or_default().push(pole);
    }
    let mut series: BTreeMap<usize, BTreeMap<usize, HitDeviation>> = BTreeMap::new();
    for ((number, _), poles) in functions {
        let weights: f64 = poles.iter().map(|pole| 1.0 / pole.variance).sum();
        let mean = poles.iter().map(|pole| pole.lambda / pole.variance);
        let mean = mean.sum::<Complex64>() / weights;
        for pole in poles {
            let hits = series.entry(number).or_default();
            let hit = hits.entry(pole.turn).or_insert(HitDeviation {
                x: x(pole),
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
        let x = hits.iter().map(|hit| hit.weight * hit.x).sum::<f64>() / weights;
        let lambda = hits.iter().map(|hit| hit.weight * hit.lambda);
        let lambda = lambda.sum::<Complex64>() / weights;
        for hit in &mut hits {
            hit.x -= x;
            hit.lambda -= lambda;
        }
        hits
    };
    let centred = |(number, hits)| (number, centred(hits));
    series.into_iter().map(centred).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poles of two series of three hits at one function each, with `λ = λ₀ + level · slope`.
    fn poles(slope: Complex64) -> Vec<HitPole> {
        let first = [0.0, 3.0, 6.0].map(|level_db| (level_db, 0));
        let second = [19.0, 10.0, 14.0].map(|level_db| (level_db, 1));
        let hits = first.into_iter().chain(second).enumerate();
        let pole = |(turn, (level_db, series)): (usize, (f64, usize))| HitPole {
            turn,
            response: format!("{}:+Z", series + 1).parse().unwrap(),
            level: HitLevel { level_db, series },
            // Another sensor has another frequency.
            lambda: Complex64::new(-3.0, 300.0 + 2.0 * series as f64) + level_db * slope,
            variance: 1.0 + turn as f64,
        };
        hits.map(pole).collect()
    }

    #[test]
    fn slopes_are_exact_within_series_of_different_sensors() {
        let slope = Complex64::new(-0.02, -0.1);
        let slopes = Slopes::of(&poles(slope), DEPENDENCES[0]).unwrap();
        // The second series is the wider one: 9 dB.
        assert!(
            (slopes.change - 9.0 * slope).norm() < 1e-12,
            "{}",
            slopes.change
        );
        assert_eq!(
            (slopes.freedom, slopes.hits, slopes.range_db),
            (3.0, 6, 9.0)
        );
        assert!(slopes.stds.iter().all(|std| *std < 1e-9));
        let finding = slopes.finding(6.0, 1.0, 4).unwrap();
        let percent = finding.value.unwrap();
        assert!(
            (percent + 90.0 / slopes.lambda.im).abs() < 1e-9,
            "{percent}"
        );
        // The damping without that of the window: 0.18 of the mean decay rate less 1.
        let damping = 18.0 / (-slopes.lambda.re - 1.0);
        let detail = finding.detail.unwrap();
        assert!(
            detail.contains(&format!("damping {damping:+.1} ± 0.0 %")),
            "{detail}"
        );
        // As much in the other direction, and none where it is of no consequence.
        let opposite = Slopes::of(&poles(-slope), DEPENDENCES[0]).unwrap();
        assert!(opposite.finding(6.0, 1.0, 4).unwrap().value > Some(0.0));
        let small = Slopes::of(&poles(slope * 1e-3), DEPENDENCES[0]).unwrap();
        assert_eq!(small.finding(6.0, 1.0, 4), None);
    }
}

//! Mass loading: natural frequencies of isolated modes differ between the positions of a roving
//! sensor or hammer, by the mass of the sensor or because the structure changed.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Severity};

use super::channel_delay::{MIN_LINES_PER_BANDWIDTH, fit_lines};
use super::driving_point::CLEAR_PEAK_OVER_NOISE;
use super::mobility::Mobilities;
use crate::frf::local_pole::{LocalPole, ResonanceLines};
use crate::frf::measurement_runs::{measurement_runs, shifted_run};
use crate::frf::peaks::{Peak, clear_peaks};

/// Half-power widths between an isolated resonance and the next; the slope of its fit then holds
/// the other to 1 %.
const MIN_SEPARATION_BANDWIDTHS: f64 = 5.0;
/// Power of a clear peak per function, over its noise: 13 dB above the sum of all noise, whose
/// scatter is then negligible.
const CLEAR_SUM_OVER_NOISE: f64 = 20.0;
/// Largest response of other modes over the peak of this mode in a function that estimates its
/// pole.
const MAX_BACKGROUND_OVER_PEAK: f64 = 0.5;
/// Shift in half-power widths: at a half-power point it changes the function by `2 · 0.15/√2`, 21
/// %; what the flanks of other modes leave in a local fit stays below.
const MAX_SHIFT_BANDWIDTHS: f64 = 0.15;
/// Standard deviations of a run's frequency: with variances of 20 degrees of freedom one of 14,000
/// by chance.
const MAX_SHIFT_STDS: f64 = 5.0;
/// Fraction of the scatter between runs that the sensor's mass must explain to be reported.
const MIN_EXPLAINED_FRACTION: f64 = 0.5;
/// Fewest runs that test a proportion: two runs always lie on a line.
const MIN_RUNS: usize = 3;

/// One resonance in one run.
struct Run {
    /// A function of the run, the one that knows the frequency best.
    function: usize,
    /// Weighted mean frequency, rad/s, and its variance.
    omega: f64,
    variance: f64,
    /// Weighted mean `|R|²` of its functions.
    power: f64,
}

/// One resonance in all runs.
struct Resonance {
    runs: Vec<Run>,
    /// Weighted mean frequency, rad/s.
    omega: f64,
    /// Half-power width, rad/s.
    width: f64,
}

/// Local frequencies of each clear and isolated resonance of the summed power, run by run, against
/// their mean.
///
/// The worst run is named where it is off by more than 0.15 of the half-power width and more than
/// the noise explains. A mass `m` at a sensor lowers mode `r` by `½ m φ²` of its frequency, so that
/// the shift is proportional to `|R|²` of the run: where that explains half of the scatter, the
/// sensor's mass is named.
///
/// # Reference
/// Ewins (2000), Modal Testing, 2nd ed., section 3.6 (mass loading); Stetson and Palma (1976),
/// first-order perturbation.
pub(super) fn findings(data: &Mobilities) -> Vec<Finding> {
    let (runs, roving_sensor) = measurement_runs(data.functions());
    if runs.len() < 2 {
        return Vec::new();
    }
    let summed = SummedFrfs::new(data);
    let peaks = summed.isolated_peaks();
    let resonances: Vec<Resonance> = peaks
        .iter()
        .filter_map(|peak| summed.resonance(peak, &runs))
        .collect();
    let worst = resonances
        .iter()
        .flat_map(|resonance| resonance.runs.iter().map(move |run| (resonance, run)))
        .filter(|(resonance, run)| resonance.shift(run).abs() > resonance.shift_limit(run))
        .max_by(|a, b| {
            a.0.shift_in_bandwidths(a.1)
                .total_cmp(&b.0.shift_in_bandwidths(b.1))
        });
    let code = match roving_sensor && is_mass_loading(&resonances) {
        true => Code::MassLoading,
        false => Code::RunsDisagree,
    };
    let finding = |(resonance, run): (&Resonance, &Run)| {
        let percent = 100.0 / resonance.omega;
        let location = data.location(run.function);
        Finding::new(Severity::Warning, code, location)
            .value(percent * resonance.shift(run), "%")
            .limit(percent * resonance.shift_limit(run))
            .detail(shifted_run(data.functions(), run.function, resonance.omega))
    };
    worst.map(finding).into_iter().collect()
}

/// All functions with their summed power in units of their noise.
pub(super) struct SummedFrfs<'a> {
    omega: &'a [f64],
    values: Vec<Vec<Complex64>>,
    variance: Vec<Vec<f64>>,
    power: Vec<f64>,
}

impl<'a> SummedFrfs<'a> {
    pub fn new(data: &'a Mobilities) -> Self {
        let functions = 0..data.functions().len();
        let values: Vec<_> = functions.clone().map(|i| data.values(i)).collect();
        let variance: Vec<_> = functions.map(|i| data.variance(i)).collect();
        let mut power = vec![0.0; data.omega.len()];
        for (values, variance) in values.iter().zip(&variance) {
            let mean = variance.iter().sum::<f64>() / variance.len() as f64;
            let weight = if mean > 0.0 { 1.0 / mean } else { 0.0 };
            let lines = power.iter_mut().zip(values);
            lines.for_each(|(sum, y)| *sum += weight * y.norm_sqr());
        }
        Self {
            omega: &data.omega,
            values,
            variance,
            power,
        }
    }

    /// Clear peaks with five lines, far from each other.
    pub fn isolated_peaks(&self) -> Vec<Peak> {
        let floor = vec![
            CLEAR_PEAK_OVER_NOISE + CLEAR_SUM_OVER_NOISE * self.values.len() as f64;
            self.power.len()
        ];
        let all = clear_peaks(&self.power, &floor, 0.0);
        let alone = |peak: &&Peak| {
            let near = MIN_SEPARATION_BANDWIDTHS * peak.width();
            let others = all.iter().filter(|other| other.line != peak.line);
            peak.width() >= MIN_LINES_PER_BANDWIDTH
                && others
                    .clone()
                    .all(|other| other.line.abs_diff(peak.line) as f64 >= near)
        };
        all.iter().filter(alone).copied().collect()
    }

    /// The frequency of one resonance in every run that shows it; `None` when less than two do.
    fn resonance(&self, peak: &Peak, runs: &[Vec<usize>]) -> Option<Resonance> {
        let lines = fit_lines(peak, self.power.len())?;
        let fit = |i: &usize| {
            let (values, variance) = (&self.values[*i], &self.variance[*i]);
            let pole = ResonanceLines::of(lines.clone(), self.omega, values, variance).fit()?;
            (pole.background < MAX_BACKGROUND_OVER_PEAK).then_some((*i, pole))
        };
        let run = |functions: &Vec<usize>| {
            average_run(&functions.iter().filter_map(fit).collect::<Vec<_>>())
        };
        let runs: Vec<Run> = runs.iter().filter_map(run).collect();
        let step = self.omega[1] - self.omega[0];
        let omega = weighted_mean(runs.iter().map(|run| (run.omega, run.variance)));
        let width = peak.width() * step;
        let enough = runs.len() >= 2;
        enough.then_some(Resonance { runs, omega, width })
    }
}

/// Weighted mean over the functions of one run.
fn average_run(poles: &[(usize, LocalPole)]) -> Option<Run> {
    let variance = |pole: &LocalPole| pole.frequency_variance.max(f64::MIN_POSITIVE);
    let best = poles
        .iter()
        .min_by(|a, b| variance(&a.1).total_cmp(&variance(&b.1)))?;
    let pairs = poles.iter().map(|(_, p)| (p.lambda.im, variance(p)));
    let weights: f64 = poles.iter().map(|(_, p)| 1.0 / variance(p)).sum();
    let power = poles.iter().map(|(_, p)| p.residue.norm_sqr()).sum::<f64>();
    Some(Run {
        function: best.0,
        omega: weighted_mean(pairs),
        variance: 1.0 / weights,
        power: power / poles.len() as f64,
    })
}

/// Mean by one over the variance.
fn weighted_mean(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, weights) = pairs.fold((0.0, 0.0), |(sum, weights), (value, variance)| {
        (sum + value / variance, weights + 1.0 / variance)
    });
    sum / weights
}

impl Resonance {
    /// Frequency of a run less the mean of all, rad/s.
    fn shift(&self, run: &Run) -> f64 {
        run.omega - self.omega
    }

    fn shift_limit(&self, run: &Run) -> f64 {
        (MAX_SHIFT_BANDWIDTHS * self.width).max(MAX_SHIFT_STDS * run.variance.sqrt())
    }

    fn shift_in_bandwidths(&self, run: &Run) -> f64 {
        self.shift(run).abs() / self.width
    }

    /// `Σ w d²` over the runs, and the part of it that a shift `d = −b (|R|² − mean)` explains, 0
    /// for `b < 0`.
    fn scatter(&self) -> (f64, f64) {
        let power = weighted_mean(self.runs.iter().map(|run| (run.power, run.variance)));
        let (mut all, mut cross, mut square) = (0.0, 0.0, 0.0);
        for run in &self.runs {
            let (d, x) = (self.shift(run), run.power - power);
            all += d * d / run.variance;
            cross -= d * x / run.variance;
            square += x * x / run.variance;
        }
        let explained = if cross > 0.0 {
            cross * cross / square
        } else {
            0.0
        };
        (all, explained)
    }
}

/// Whether shifts against the power of the runs explain enough of the scatter.
fn is_mass_loading(resonances: &[Resonance]) -> bool {
    let wide = resonances.iter().filter(|r| r.runs.len() >= MIN_RUNS);
    let (all, explained) = wide.fold((0.0, 0.0), |(all, explained), resonance| {
        let one = resonance.scatter();
        (all + one.0, explained + one.1)
    });
    explained > MIN_EXPLAINED_FRACTION * all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::FrfSet;
    use crate::frf::consistency::synthetic::{Beam, add_noise, component, dof, joined};

    fn found(set: &FrfSet) -> Vec<Finding> {
        findings(&Mobilities::new(set).unwrap())
    }

    /// Every point from 1 to 8 in a separate run, mode `m` of point `p` with its frequency times
    /// `1 + shift(p, m)`.
    fn roving(shift: impl Fn(usize, usize) -> f64, hammer: bool) -> FrfSet {
        let run = |point: usize| {
            let beam = Beam {
                shift: std::array::from_fn(|mode| 1.0 + shift(point, mode)),
                ..Beam::default()
            };
            let roving = format!("{point}:+Z");
            let pair = (roving.as_str(), "1:+Z");
            beam.set(&[if hammer { (pair.1, pair.0) } else { pair }])
        };
        let mut set = joined(&(1..=8).map(run).collect::<Vec<_>>());
        add_noise(&mut set, 40.0, 21);
        set
    }

    /// A mass of `mass` (modal mass 1) at the roving sensor.
    fn loaded(mass: f64) -> impl Fn(usize, usize) -> f64 {
        move |point, mode| {
            let phi = component(mode, &dof(&format!("{point}:+Z")));
            -0.5 * mass * phi * phi
        }
    }

    #[test]
    fn the_mass_of_a_roving_sensor_is_named() {
        let findings = found(&roving(loaded(0.01), false));
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].code, Code::MassLoading);
        assert!(findings[0].value.unwrap().abs() > findings[0].limit.unwrap());
        assert!(found(&roving(loaded(0.0003), false)).is_empty());
    }

    #[test]
    fn a_run_with_shifted_frequencies_is_reported_with_its_shift() {
        // 0.5 % up in one of eight runs of about equal weight: 7/8 of it against the mean.
        let changed = |point: usize, _: usize| if point == 5 { 0.005 } else { 0.0 };
        for hammer in [false, true] {
            let findings = found(&roving(changed, hammer));
            assert_eq!(findings.len(), 1);
            assert_eq!(findings[0].code, Code::RunsDisagree);
            let place = if hammer { "1:+Z|5:+Z" } else { "5:+Z|1:+Z" };
            assert_eq!(findings[0].location.to_string(), place);
            let detail = findings[0].detail.as_deref().unwrap();
            let kind = if hammer { "excitation point" } else { "sensor" };
            assert!(detail.starts_with("resonance at "), "{detail}");
            let run = format!("; run of {kind} 5:+Z, of 8 runs");
            assert!(detail.ends_with(&run), "{detail}");
            let value = findings[0].value.unwrap();
            assert!((0.3..0.5).contains(&value), "{value}");
        }
    }

    #[test]
    fn a_fixed_sensor_with_a_roving_hammer_cannot_load_differently() {
        let findings = found(&roving(loaded(0.01), true));
        assert_eq!(findings[0].code, Code::RunsDisagree);
    }

    #[test]
    fn noise_alone_or_a_single_run_gives_no_mass_loading_finding() {
        assert!(found(&roving(|_, _| 0.0, false)).is_empty());
        assert!(found(&Beam::default().set(&[("1:+Z", "1:+Z")])).is_empty());
    }

    #[test]
    fn a_weighted_mean_uses_its_weights() {
        let mean = weighted_mean([(1.0, 1.0), (4.0, 0.5)].into_iter());
        assert!((mean - 3.0).abs() < 1e-15);
    }
}

//! The comparison on measured data lists errors against the refined solution, and the cost, of
//! every method.

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::Code;
use crate::fourier::ForwardPlan;
use crate::frf::FrfSet;
use crate::modal::{ModalModel, Mode};

use super::super::{DetectionCounts, Judge, Meter, Method, StudyError, System, TrueMode};
use super::data::TestSets;
use super::result::{DataRow, SpeedLimits, Timing};
use super::{FrontPoint, SpeedAccuracyOptions, pareto_front};

/// Signal-to-noise ratio of FRFs without a stated variance, dB: all modes count as observable.
const UNSTATED_SNR_DB: f64 = 120.0;

/// The refined solution of whole records.
pub(in crate::study) struct RefinedSolution {
    pub model: ModalModel,
    /// Rms stated deviation of its frequencies, relative.
    pub frequency_std: Option<f64>,
    /// The same of its damping ratios.
    pub damping_std: Option<f64>,
    system: System,
    variances: Vec<f64>,
}

impl RefinedSolution {
    pub fn new(data: &TestSets) -> Result<Self, StudyError> {
        let set = &data.sets[0].set;
        Self::from_modes(Method::REFINED.identify(set, data.band)?, set, data.band)
    }

    /// Of modes that were identified in a band.
    pub fn from_modes(model: ModalModel, set: &FrfSet, band: Band) -> Result<Self, StudyError> {
        let system = System::twin(&model, set, band)?;
        let variances = mean_variances(&system, set)?;
        let frequency = |mode: &Mode| Some(mode.frequency_std_hz? / mode.frequency_hz);
        let damping = |mode: &Mode| Some(mode.damping_std? / mode.damping_ratio?);
        Ok(Self {
            frequency_std: rms(model.modes.iter().map(frequency)),
            damping_std: rms(model.modes.iter().map(damping)),
            model,
            system,
            variances,
        })
    }

    /// Compares modes of other methods with its modes.
    pub fn judge(&self) -> Judge<'_> {
        Judge::new(&self.system, &self.variances)
    }

    /// Stated deviations of frequency and damping ratio of one of its modes, relative.
    pub fn deviations(&self, truth: &TrueMode) -> [Option<f64>; 2] {
        let same = |mode: &&Mode| mode.pole() == Some(truth.pole);
        let mode = self.model.modes.iter().find(same);
        [
            mode.and_then(|found| Some(found.frequency_std_hz? / found.frequency_hz)),
            mode.and_then(|found| Some(found.damping_std? / found.damping_ratio?)),
        ]
    }
}

/// Root mean square; `None` without values or where a value is missing.
fn rms(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let all: Vec<f64> = values.collect::<Option<_>>()?;
    let sum: f64 = all.iter().map(|value| value * value).sum();
    (!all.is_empty()).then(|| (sum / all.len() as f64).sqrt())
}

/// Mean variance over the band of every function of a twin, as its test states it.
fn mean_variances(system: &System, set: &FrfSet) -> Result<Vec<f64>, StudyError> {
    let lines = set.axis().lines(&system.band);
    let exact = system.exact()?;
    let unstated = system.variances(&exact, UNSTATED_SNR_DB);
    let of = |(function, unstated): (&crate::frf::Function, f64)| {
        let pair = [&function.response, &function.reference];
        let same = |other: &crate::frf::Function| {
            let pair_of_other = [&other.response, &other.reference];
            pair_of_other == pair || pair_of_other == [pair[1], pair[0]]
        };
        let i = set.functions().iter().position(same)?;
        let mean = set.variance(i)?[lines.clone()].iter().sum::<f64>() / lines.len() as f64;
        (mean > 0.0).then_some(mean).or(Some(unstated))
    };
    let all = exact.functions().iter().zip(unstated.clone()).map(of);
    Ok(all.collect::<Option<Vec<f64>>>().unwrap_or(unstated))
}

/// Every method on every set, one after the other so that no two are timed at once.
pub(super) fn rows(
    data: &TestSets,
    refined: &RefinedSolution,
    options: &SpeedAccuracyOptions,
    meter: &dyn Meter,
) -> Vec<DataRow> {
    let judge = refined.judge();
    let mut rows = Vec::new();
    for (number, variant) in data.sets.iter().enumerate() {
        // Orders are tried on the FRFs of the scene alone: other variants would repeat the result.
        let orders = options.orders.iter().copied().filter(|_| number == 0);
        for method in Method::all(&orders.collect::<Vec<usize>>()) {
            let identify = || method.identify(&variant.set, data.band).ok();
            let (found, timing) = timed(identify, options.repeats, meter);
            let mut counts = DetectionCounts::default();
            counts.add(&judge, found.as_ref());
            rows.push(DataRow {
                estimator: variant.estimator,
                step_hz: variant.set.axis().step_hz,
                is_reference: number == 0 && method.name == Method::REFINED.name,
                method,
                counts,
                has_close_modes: found.is_some_and(|model| {
                    let mut findings = model.findings.iter();
                    findings.any(|finding| finding.code == Code::CloseModes)
                }),
                timing,
                on_front: false,
            });
        }
    }
    let min_error = refined.frequency_std.unwrap_or(0.0);
    let points: Vec<_> = rows.iter().map(|row| row.point(min_error)).collect();
    for row in pareto_front(&points) {
        rows[row].on_front = true;
    }
    rows
}

impl DataRow {
    /// Its point in the comparison. The refined solution has no error against itself; `min_error`,
    /// the standard deviation of its frequencies, limits what an error can show.
    fn point(&self, min_error: f64) -> FrontPoint {
        let error = match self.is_reference {
            true => Some(min_error),
            false => self.counts.frequency().map(|error| error.max(min_error)),
        };
        FrontPoint {
            cpu_s: self.timing.median_s,
            error,
            mistakes: self.counts.mistakes(),
        }
    }
}

/// Runs the work once, and a number of times more where a meter measures it.
pub(super) fn timed<T>(work: impl Fn() -> T, repeats: usize, meter: &dyn Meter) -> (T, Timing) {
    let result = work();
    let mut times = Vec::new();
    let mut peak_bytes = None;
    for _ in 0..repeats {
        if !meter.measures() {
            break;
        }
        let cost = meter.measure(&mut || {
            std::hint::black_box(work());
        });
        times.extend(cost.cpu_s);
        peak_bytes = peak_bytes.max(cost.peak_bytes);
    }
    times.sort_by(f64::total_cmp);
    let timing = Timing {
        repeats: times.len(),
        median_s: times.get(times.len() / 2).copied(),
        spread_s: (times.len() > 1)
            .then(|| times.first().zip(times.last()).map(|(lo, hi)| hi - lo))
            .flatten(),
        peak_bytes,
    };
    (result, timing)
}

/// Times a transform of every function, as long as its lines, and a pass over its values in the
/// band.
pub(super) fn limits(set: &FrfSet, band: Band, meter: &dyn Meter) -> SpeedLimits {
    let lines = set.axis().lines(&band);
    let plan = ForwardPlan::new(2 * lines.len());
    let record: Vec<f64> = (0..plan.len()).map(|k| (k as f64).sin()).collect();
    let transform = || -> Complex64 {
        let of_one = |_| plan.transform(&record)[1];
        (0..set.len()).map(of_one).sum()
    };
    let pass = || -> Complex64 {
        let of_one = |i| set.values(i)[lines.clone()].iter().sum::<Complex64>();
        (0..set.len()).map(of_one).sum()
    };
    SpeedLimits {
        transform_s: mean_cpu_s(&transform, meter),
        pass_s: mean_cpu_s(&pass, meter),
    }
}

/// Processor time of a short computation, averaged over enough runs for the resolution of the
/// clock.
fn mean_cpu_s(work: &dyn Fn() -> Complex64, meter: &dyn Meter) -> Option<f64> {
    const RUNS: u32 = 20;
    let cost = meter.measure(&mut || {
        for _ in 0..RUNS {
            std::hint::black_box(work());
        }
    });
    cost.cpu_s.map(|time| time / f64::from(RUNS))
}

//! The twin compares all methods over the noise level, in three conditions.

use rayon::prelude::*;

use crate::axis::{Band, FrequencyAxis};
use crate::frf::FrfSet;

use super::super::{
    DetectionCounts, FrfNoise, Judge, Meter, Method, StudyError, System, cell_random, with_noise,
};
use super::test_data::{limits, timed};
use super::{SpeedAccuracyOptions, SpeedLimits, TwinCost, TwinRow, front};

/// Time before the hit, over the time from the hit to the end of a short record. Assumed: a
/// measurement system keeps a few percent.
const PRETRIGGER: f64 = 0.02;
/// Smallest number of modes of a twin whose first and last mode can lie outside the band.
const MIN_MODES_FOR_OUTSIDE: usize = 4;

/// Condition of the twin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The modes of the band alone, in white noise: what every method assumes.
    White,
    /// The band excludes the first and the last mode of the twin.
    Outside,
    /// The record ends before the response has decayed, with the time before the hit in it.
    Truncated,
}

impl Condition {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::White, Self::Outside, Self::Truncated];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white noise",
            Self::Outside => "modes outside the band",
            Self::Truncated => "record ends early",
        }
    }

    /// The twin under this condition; `None` where it has too few modes.
    fn apply_to(
        self,
        twin: &System,
        options: &SpeedAccuracyOptions,
    ) -> Result<Option<System>, StudyError> {
        let inside = twin.modes.iter().filter(|mode| twin.inside(mode)).cloned();
        let alone = System {
            modes: inside.collect(),
            ..twin.clone()
        };
        match self {
            Self::White => thinned(alone, options.lines_per_width).map(Some),
            Self::Outside => {
                let hz: Vec<f64> = alone.modes.iter().map(|mode| mode.hz()).collect();
                let between = |r: usize| 0.5 * (hz[r] + hz[r + 1]);
                let enough = hz.len() >= MIN_MODES_FOR_OUTSIDE;
                let band = enough.then(|| Band::new(between(0), between(hz.len() - 2)).ok());
                let Some(band) = band.flatten() else {
                    return Ok(None);
                };
                let narrow = twin.clone().on_lines(twin.axis, band)?;
                thinned(narrow, options.lines_per_width).map(Some)
            }
            Self::Truncated => {
                let decay = alone.modes.iter().map(|mode| -mode.pole.lambda.re);
                let Some(slowest) = decay.reduce(f64::min) else {
                    return Ok(None);
                };
                let end_s = options.record_time_constants / slowest;
                let ended = System {
                    record_end_s: Some(end_s),
                    ..alone
                };
                let step_hz = (end_s * (1.0 + PRETRIGGER)).recip();
                let axis = FrequencyAxis {
                    start_hz: 0.0,
                    step_hz,
                    len: (twin.band.hi_hz / step_hz) as usize + 2,
                };
                ended.on_lines(axis, twin.band).map(Some)
            }
        }
    }
}

/// The system with at most the stated number of lines per half-power bandwidth of its narrowest
/// mode.
fn thinned(system: System, lines_per_width: Option<f64>) -> Result<System, StudyError> {
    let inside = system.modes.iter().filter(|mode| system.inside(mode));
    let narrowest = inside.map(|mode| mode.width_hz()).reduce(f64::min);
    let Some((wanted, width)) = lines_per_width.zip(narrowest) else {
        return Ok(system);
    };
    let (axis, band) = (system.axis, system.band);
    let every = (width / wanted / axis.step_hz).floor().max(1.0);
    let sparse = FrequencyAxis {
        step_hz: every * axis.step_hz,
        len: (axis.len - 1) / every as usize + 1,
        ..axis
    };
    system.on_lines(sparse, band)
}

/// The results of a twin.
pub(super) struct TwinStudy {
    pub modes: usize,
    pub step_hz: f64,
    pub rows: Vec<TwinRow>,
    pub costs: Vec<TwinCost>,
    pub limits: SpeedLimits,
}

pub(super) fn study(
    twin: System,
    (options, test): (&SpeedAccuracyOptions, Option<usize>),
    (meter, notes): (&dyn Meter, &mut Vec<String>),
) -> Result<TwinStudy, StudyError> {
    let test = test.unwrap_or_default() as u64;
    let methods = Method::all(&[]);
    let mut study = TwinStudy {
        modes: twin.modes.iter().filter(|mode| twin.inside(mode)).count(),
        step_hz: twin.axis.step_hz,
        rows: Vec::new(),
        costs: Vec::new(),
        limits: SpeedLimits::default(),
    };
    for (number, condition) in Condition::ALL.into_iter().enumerate() {
        let Some(system) = condition.apply_to(&twin, options)? else {
            notes.push(format!(
                "no twin with {}: it has fewer than {MIN_MODES_FOR_OUTSIDE} modes",
                condition.name()
            ));
            continue;
        };
        let cell = Cell {
            exact: system.exact()?,
            system,
            coordinates: [test, number as u64],
            options,
        };
        study.rows.extend(cell.rows((condition, &methods), notes)?);
        if condition == Condition::White {
            let noise = FrfNoise {
                snr_db: options.middle_snr_db(),
                averages: None,
            };
            let mut random = cell_random(options.seed, &[test]);
            let set = cell.system.noisy(&noise, &mut random)?;
            let band = cell.system.band;
            study.step_hz = set.axis().step_hz;
            study.costs = costs(&methods, (&set, band), (options, meter));
            mark_front(&mut study, noise.snr_db);
            study.limits = limits(&set, band, meter);
        }
    }
    Ok(study)
}

fn costs(
    methods: &[Method],
    (set, band): (&FrfSet, Band),
    (options, meter): (&SpeedAccuracyOptions, &dyn Meter),
) -> Vec<TwinCost> {
    let cost = |method: &Method| {
        let identify = || method.identify(set, band).ok();
        TwinCost {
            method: *method,
            timing: timed(identify, options.repeats, meter).1,
            on_front: false,
        }
    };
    methods.iter().map(cost).collect()
}

/// Marks the methods on the front of time and error in white noise of a level.
fn mark_front(study: &mut TwinStudy, snr_db: f64) {
    let point = |cost: &TwinCost| {
        let mut rows = study.rows.iter();
        let tally = rows.find(|row| row.method == cost.method && row.snr_db >= snr_db);
        let tally = tally.map(|row| row.tally).unwrap_or_default();
        (cost.timing.median_s, tally.frequency(), tally.mistakes())
    };
    let points: Vec<_> = study.costs.iter().map(point).collect();
    for number in front(&points) {
        study.costs[number].on_front = true;
    }
}

/// The counts of one identification, and the reason where it was refused.
type Judged = (DetectionCounts, Option<String>);

/// A twin under one condition.
struct Cell<'a> {
    system: System,
    exact: FrfSet,
    coordinates: [u64; 2],
    options: &'a SpeedAccuracyOptions,
}

impl Cell<'_> {
    /// Every method at every level, over all draws: draws in the pool, added in their order.
    fn rows(
        &self,
        (condition, methods): (Condition, &[Method]),
        notes: &mut Vec<String>,
    ) -> Result<Vec<TwinRow>, StudyError> {
        let levels = &self.options.snr_db;
        let variances = levels
            .iter()
            .map(|snr_db| self.system.variances(&self.exact, *snr_db));
        let variances: Vec<Vec<f64>> = variances.collect();
        let judges = variances
            .iter()
            .map(|variance| Judge::new(&self.system, variance));
        let judges: Vec<Judge> = judges.collect();
        let draws = self.options.draws;
        let one = |number: usize| {
            let (level, draw) = (number / draws, number % draws);
            self.draw((level, draw), &variances[level], (&judges[level], methods))
        };
        let all = (0..levels.len() * draws).into_par_iter().map(one);
        let all = all.collect::<Result<Vec<Vec<Judged>>, StudyError>>()?;
        for (m, method) in methods.iter().enumerate() {
            let refused = all.iter().find_map(|draw| draw[m].1.as_deref());
            let note = |reason| format!("{method}, {}: {reason}", condition.name());
            notes.extend(refused.map(note));
        }
        let mut rows = Vec::new();
        for (level, draws_of_level) in all.chunks(draws).enumerate() {
            for (m, method) in methods.iter().enumerate() {
                let mut tally = DetectionCounts::default();
                draws_of_level
                    .iter()
                    .for_each(|draw| tally.join(&draw[m].0));
                rows.push(TwinRow {
                    condition,
                    snr_db: levels[level],
                    method: *method,
                    tally,
                });
            }
        }
        Ok(rows)
    }

    /// Every method on one draw.
    fn draw(
        &self,
        (level, draw): (usize, usize),
        variances: &[f64],
        (judge, methods): (&Judge, &[Method]),
    ) -> Result<Vec<Judged>, StudyError> {
        let [test, condition] = self.coordinates;
        let coordinates = [test, condition, level as u64, draw as u64];
        let mut random = cell_random(self.options.seed, &coordinates);
        let set = with_noise(&self.exact, variances, (None, &mut random))?;
        let tally = |method: &Method| {
            let mut tally = DetectionCounts::default();
            let found = method.identify(&set, self.system.band);
            tally.add(judge, found.as_ref().ok());
            (tally, found.err().map(|reason| reason.to_string()))
        };
        Ok(methods.iter().map(tally).collect())
    }
}

//! The twin compares all methods over the noise level, in three conditions.

use rayon::prelude::*;

use crate::axis::Band;
use crate::frf::FrfSet;

use super::super::{
    DetectionCounts, FrfNoise, Judge, Meter, Method, StudyError, System, cell_random, with_noise,
};
use super::condition::{Condition, MIN_MODES_FOR_OUTSIDE};
use super::result::{SpeedLimits, TwinCost, TwinRow};
use super::test_data::{limits, timed};
use super::{FrontPoint, SpeedAccuracyOptions, pareto_front};

/// The results of a twin.
pub(super) struct TwinStudy {
    pub modes: usize,
    pub step_hz: f64,
    pub rows: Vec<TwinRow>,
    pub costs: Vec<TwinCost>,
    pub limits: SpeedLimits,
}

/// Runs every method on the twin of a test of the scene, whose number seeds the draws.
pub(super) fn study(
    twin: System,
    test: usize,
    options: &SpeedAccuracyOptions,
    meter: &dyn Meter,
    notes: &mut Vec<String>,
) -> Result<TwinStudy, StudyError> {
    let test = test as u64;
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
        let in_condition = TwinInCondition {
            exact: system.exact()?,
            system,
            coordinates: [test, number as u64],
            options,
        };
        study
            .rows
            .extend(in_condition.rows(condition, &methods, notes)?);
        if condition == Condition::White {
            let noise = FrfNoise {
                snr_db: options.middle_snr_db(),
                averages: None,
            };
            let mut random = cell_random(options.seed, &[test]);
            let set = in_condition.system.noisy(&noise, &mut random)?;
            let band = in_condition.system.band;
            study.step_hz = set.axis().step_hz;
            study.costs = costs(&methods, &set, band, options.repeats, meter);
            mark_front(&mut study, noise.snr_db);
            study.limits = limits(&set, band, meter);
        }
    }
    Ok(study)
}

fn costs(
    methods: &[Method],
    set: &FrfSet,
    band: Band,
    repeats: usize,
    meter: &dyn Meter,
) -> Vec<TwinCost> {
    let cost = |method: &Method| {
        let identify = || method.identify(set, band).ok();
        TwinCost {
            method: *method,
            timing: timed(identify, repeats, meter).1,
            on_front: false,
        }
    };
    methods.iter().map(cost).collect()
}

/// Marks the methods on the front of time and error in white noise of a level.
fn mark_front(study: &mut TwinStudy, snr_db: f64) {
    let point = |cost: &TwinCost| {
        let mut rows = study.rows.iter();
        let counts = rows.find(|row| row.method == cost.method && row.snr_db >= snr_db);
        let counts = counts.map(|row| row.counts).unwrap_or_default();
        FrontPoint {
            cpu_s: cost.timing.median_s,
            error: counts.frequency(),
            mistakes: counts.mistakes(),
        }
    };
    let points: Vec<_> = study.costs.iter().map(point).collect();
    for number in pareto_front(&points) {
        study.costs[number].on_front = true;
    }
}

/// The counts of one identification, and the reason where the method refused the data.
type Identified = (DetectionCounts, Option<String>);

/// A twin under one condition.
struct TwinInCondition<'a> {
    system: System,
    exact: FrfSet,
    coordinates: [u64; 2],
    options: &'a SpeedAccuracyOptions,
}

impl TwinInCondition<'_> {
    /// Every method at every level, over all draws: draws in the pool, added in their order.
    fn rows(
        &self,
        condition: Condition,
        methods: &[Method],
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
            self.draw(level, draw, &variances[level], &judges[level], methods)
        };
        let all = (0..levels.len() * draws).into_par_iter().map(one);
        let all = all.collect::<Result<Vec<Vec<Identified>>, StudyError>>()?;
        for (m, method) in methods.iter().enumerate() {
            let refused = all.iter().find_map(|draw| draw[m].1.as_deref());
            let note = |reason| format!("{method}, {}: {reason}", condition.name());
            notes.extend(refused.map(note));
        }
        let mut rows = Vec::new();
        for (level, draws_of_level) in all.chunks(draws).enumerate() {
            for (m, method) in methods.iter().enumerate() {
                let mut counts = DetectionCounts::default();
                draws_of_level
                    .iter()
                    .for_each(|draw| counts.merge(&draw[m].0));
                rows.push(TwinRow {
                    condition,
                    snr_db: levels[level],
                    method: *method,
                    counts,
                });
            }
        }
        Ok(rows)
    }

    /// Every method on one draw.
    fn draw(
        &self,
        level: usize,
        draw: usize,
        variances: &[f64],
        judge: &Judge,
        methods: &[Method],
    ) -> Result<Vec<Identified>, StudyError> {
        let [test, condition] = self.coordinates;
        let coordinates = [test, condition, level as u64, draw as u64];
        let mut random = cell_random(self.options.seed, &coordinates);
        let set = with_noise(&self.exact, variances, None, &mut random)?;
        let counts = |method: &Method| {
            let mut counts = DetectionCounts::default();
            let found = method.identify(&set, self.system.band);
            counts.add(judge, found.as_ref().ok());
            (counts, found.err().map(|reason| reason.to_string()))
        };
        Ok(methods.iter().map(counts).collect())
    }
}

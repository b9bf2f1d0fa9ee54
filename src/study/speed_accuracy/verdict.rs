//! The verdict of a test names the fastest accurate method, its cost and where it fails.

use super::super::wording::{counted, listed, two_digits};
use super::super::{DetectionCounts, Method};
use super::{Condition, DataRow, SpeedAccuracy, SpeedAccuracyOptions, TestStudy};

/// Fraction of the modes at a noise level that a method may miss or invent without failing there.
const MAX_MISTAKE_SHARE: f64 = 0.02;

impl TestStudy {
    /// Rows of the FRFs as the scene estimates them, from whole records.
    pub fn scene_rows(&self) -> impl Iterator<Item = &DataRow> {
        let first = self.data.first();
        self.data.iter().filter(move |row| {
            first.is_some_and(|first| {
                row.estimator == first.estimator && row.step_hz.total_cmp(&first.step_hz).is_eq()
            })
        })
    }

    /// The fastest method on the FRFs of the scene that finds every observable mode of the refined
    /// solution and no other within the stated errors, and reports no peak with several modes; of
    /// methods of equal or unknown time the simplest.
    pub fn recommended(&self, options: &SpeedAccuracyOptions) -> Option<&DataRow> {
        let accurate = self.scene_rows().filter(|row| {
            row.is_reference && row.method == Method::REFINED
                || !row.is_reference && !row.has_close_modes && options.is_accurate(&row.counts)
        });
        let seconds = |row: &DataRow| row.timing.median_s.unwrap_or(f64::INFINITY);
        accurate.min_by(|a, b| seconds(a).total_cmp(&seconds(b)))
    }

    /// Whether a method misses or invents more than 2 % of the modes of the twin at a noise level.
    fn fails_at(&self, condition: Condition, method: Method, snr_db: f64) -> bool {
        self.twin_row(condition, snr_db, method).is_some_and(|row| {
            row.counts.mistakes() as f64 > MAX_MISTAKE_SHARE * row.counts.observable as f64
        })
    }

    /// The highest noise level of the twin at which a method misses or invents modes.
    pub fn highest_failing_snr_db(
        &self,
        condition: Condition,
        method: Method,
        levels: &[f64],
    ) -> Option<f64> {
        let failing = levels.iter().copied();
        failing
            .filter(|level| self.fails_at(condition, method, *level))
            .reduce(f64::max)
    }

    /// Largest error of a frequency over the standard deviation of the refined frequencies, rms.
    pub fn largest_error_over_std(&self, row: &DataRow) -> Option<f64> {
        let error = row.counts.largest_frequency()?;
        let std = self.frequency_std.filter(|std| *std > 0.0)?;
        (!row.is_reference).then_some(error / std)
    }
}

impl SpeedAccuracyOptions {
    fn is_accurate(&self, counts: &DetectionCounts) -> bool {
        let within =
            |error: Option<f64>, percent: f64| error.is_none_or(|error| 100.0 * error <= percent);
        counts.found > 0
            && counts.mistakes() == 0
            && within(counts.largest_frequency(), self.frequency_percent)
            && within(counts.largest_damping(), self.damping_percent)
    }
}

/// A verdict for each test: `use circle: 0.16 s, largest frequency error 0.0013 %, 2.6 times the
/// noise floor; ml: 0.58 s, noise floor 0.00050 %.`
pub fn method_verdicts(study: &SpeedAccuracy) -> Vec<String> {
    let of_test = |test: &TestStudy| {
        let sentences = [
            recommendation(test, &study.options),
            failures(test, &study.options),
        ];
        let sentences: Vec<String> = sentences.into_iter().flatten().collect();
        format!("{}: {}", test.name, sentences.join(" "))
    };
    study.tests.iter().map(of_test).collect()
}

fn recommendation(test: &TestStudy, options: &SpeedAccuracyOptions) -> Option<String> {
    let refined = test
        .scene_rows()
        .find(|row| row.is_reference && row.method == Method::REFINED)?;
    let floor = test.frequency_std.map_or(String::new(), |std| {
        format!(", noise floor {} %", two_digits(100.0 * std))
    });
    let refined_cost = format!("{}{}{floor}", Method::REFINED, after_colon(refined));
    let row = test.recommended(options)?;
    if row.method == Method::REFINED {
        return Some(format!(
            "use {refined_cost}; no faster method has all {} and no other, to {} % in frequency and {} % in damping, without a report of close modes.",
            counted(row.counts.observable, "observable mode"),
            options.frequency_percent,
            options.damping_percent
        ));
    }
    let error = row.counts.largest_frequency()?;
    let over_floor = test
        .largest_error_over_std(row)
        .map_or(String::new(), |ratio| {
            format!(", {} times the noise floor", two_digits(ratio))
        });
    Some(format!(
        "use {}{}, largest frequency error {} %{over_floor}; {refined_cost}.",
        with_order(row.method),
        after_colon(row),
        two_digits(100.0 * error)
    ))
}

fn with_order(method: Method) -> String {
    match method.order {
        Some(order) => format!("{} order {order}", method.name),
        None => method.name.to_owned(),
    }
}

fn after_colon(row: &DataRow) -> String {
    row.timing.median_s.map_or(String::new(), |seconds| {
        format!(": {} s", two_digits(seconds))
    })
}

/// Where the recommended method misses or invents modes of the twin.
fn failures(test: &TestStudy, options: &SpeedAccuracyOptions) -> Option<String> {
    // The twin has each method at the order that it chooses alone.
    let method = test.recommended(options)?.method;
    if method.order.is_some() {
        return None;
    }
    let (lowest, highest) = (options.snr_db.first()?, options.snr_db.last()?);
    let has_rows = |condition: &Condition| {
        let mut rows = test.twin.iter();
        rows.any(|row| row.condition == *condition && row.method == method)
    };
    let conditions = Condition::ALL.into_iter().filter(has_rows);
    let (mut failing, mut good) = (Vec::new(), Vec::new());
    for condition in conditions {
        let name = condition.name();
        let fails = |level: &&f64| test.fails_at(condition, method, **level);
        let at: Vec<String> = options
            .snr_db
            .iter()
            .filter(fails)
            .map(|level| format!("{level:.0}"))
            .collect();
        match at.len() {
            0 => good.push(name.to_owned()),
            all if all == options.snr_db.len() => failing.push(format!("{name} (at every level)")),
            _ => failing.push(format!("{name} (at {} dB)", listed(&at))),
        }
    }
    let levels = format!("{lowest:.0} to {highest:.0} dB");
    match (failing.as_slice(), good.as_slice()) {
        ([], []) => None,
        ([], good) => Some(format!(
            "On its synthetic twin {method} misses or invents at most 2 % of the modes from {levels}: {}.",
            listed(good)
        )),
        (failing, _) => Some(format!(
            "On its synthetic twin, {levels}, {method} misses or invents more than 2 % of the modes: {}.",
            listed(failing)
        )),
    }
}

//! Recommendations state in sentences which method is fast and which is accurate, test by test.

use super::super::Method;
use super::{Condition, DataRow, SpeedAccuracy, TestStudy};
use crate::linalg::sort_ascending_by;

/// Smallest fall of the error of an unbiased method, over the fall of the noise, both in dB.
const MIN_ERROR_FALL_OVER_NOISE_FALL: f64 = 0.5;

/// Recommended methods, test by test.
pub fn recommendations(study: &SpeedAccuracy) -> Vec<String> {
    let of_test = |test: &TestStudy| {
        let sentences = [
            fastest_and_most_exact(test),
            in_white_noise(test, study),
            refined_errors(test, study, Condition::Outside),
            refined_errors(test, study, Condition::Truncated),
            methods_with_mistakes(test, study),
            biased_methods(test, study),
        ];
        let sentences: Vec<String> = sentences.into_iter().flatten().collect();
        format!("{}: {}", test.name, sentences.join(" "))
    };
    study.tests.iter().map(of_test).collect()
}

/// The fastest and the most exact method on the data, of those with the fewest mistakes.
fn fastest_and_most_exact(test: &TestStudy) -> Option<String> {
    let mut front: Vec<&DataRow> = test.data.iter().filter(|row| row.on_front).collect();
    let time = |row: &&DataRow| row.timing.median_s.unwrap_or(f64::INFINITY);
    sort_ascending_by(&mut front, time);
    let described = |row: &DataRow| {
        let error = match (row.is_reference, row.counts.frequency()) {
            (true, _) => "the refined solution itself".to_owned(),
            (_, error) => format!(
                "frequencies {:.1e} % rms from the refined ones",
                100.0 * error?
            ),
        };
        let counts = &row.counts;
        Some(format!(
            "{}{}, lines {:.3} Hz apart ({} of {} modes, {} spurious, {error})",
            row.method,
            row.estimator
                .map_or(String::new(), |name| format!(" on {name}")),
            row.step_hz,
            counts.found,
            counts.observable,
            counts.spurious,
        ))
    };
    let (first, last) = (front.first()?, front.last()?);
    let most_exact = match front.len() {
        1 => ", and none is more exact than it by what the data tell".to_owned(),
        _ => format!(", the most exact {}", described(last)?),
    };
    let known = test.frequency_std.map_or(String::new(), |std| {
        format!(
            " The refined frequencies are known to {:.1e} %.",
            100.0 * std
        )
    });
    Some(format!(
        "of those with the fewest mistakes on its data the fastest is {}{most_exact}.{known}",
        described(first)?
    ))
}

/// Noise level and frequency error of a method over its bound, at every level.
fn errors_over_bound(
    test: &TestStudy,
    study: &SpeedAccuracy,
    condition: Condition,
    method: Method,
) -> Vec<(f64, f64)> {
    let level = |snr_db: &f64| {
        let row = test.twin_row(condition, *snr_db, method)?;
        Some((*snr_db, row.counts.frequency_over_bound()?))
    };
    study.options.snr_db.iter().filter_map(level).collect()
}

fn min_and_max(values: &[(f64, f64)]) -> Option<(f64, f64)> {
    let least = values.iter().map(|value| value.1).reduce(f64::min)?;
    let most = values.iter().map(|value| value.1).reduce(f64::max)?;
    Some((least, most))
}

fn in_white_noise(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let errors = errors_over_bound(test, study, Condition::White, Method::REFINED);
    let (least, most) = min_and_max(&errors)?;
    let others = Method::all(&[])
        .into_iter()
        .filter(|method| *method != Method::REFINED);
    let next = others.filter_map(|method| {
        let errors_of_other = errors_over_bound(test, study, Condition::White, method);
        Some((min_and_max(&errors_of_other)?.1, method))
    });
    let next = next.min_by(|a, b| a.0.total_cmp(&b.0));
    let next = next.map_or(String::new(), |(most, method)| {
        format!(", {method}, the next, up to {most:.1} times")
    });
    Some(format!(
        "In white noise from {:.0} to {:.0} dB the frequency errors of {} are {least:.2} to {most:.2} times their Cramér-Rao \
         bound{next}.",
        errors.first()?.0,
        errors.last()?.0,
        Method::REFINED,
    ))
}

/// Error of the refined method over its bound, with modes outside the band or truncated records.
fn refined_errors(test: &TestStudy, study: &SpeedAccuracy, condition: Condition) -> Option<String> {
    let errors = errors_over_bound(test, study, condition, Method::REFINED);
    let (least, most) = (errors.first()?, errors.last()?);
    // The method of the smallest error at the highest signal-to-noise ratio.
    let at_end = Method::all(&[]).into_iter().filter_map(|method| {
        let errors_of_method = errors_over_bound(test, study, condition, method);
        Some((
            errors_of_method.last().filter(|error| error.0 >= most.0)?.1,
            method,
        ))
    });
    let best = at_end.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let other = match best.1 == Method::REFINED {
        true => String::new(),
        false => format!(", where {} is at {:.1}", best.1, best.0),
    };
    let what = match condition {
        Condition::White => return None,
        Condition::Outside => "With modes outside the band".to_owned(),
        Condition::Truncated => format!(
            "Where the record ends after {} time constants",
            study.options.record_time_constants
        ),
    };
    Some(format!(
        "{what} they are {:.1} times at {:.0} dB and {:.1} times at {:.0} dB{other}.",
        least.1, least.0, most.1, most.0
    ))
}

/// Methods with missed or spurious modes in white noise, with the highest level at which they have
/// some.
fn methods_with_mistakes(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let described = |method: Method| {
        let highest =
            test.highest_failing_snr_db(Condition::White, method, &study.options.snr_db)?;
        let is_last = study.options.snr_db.last() == Some(&highest);
        Some(match is_last {
            true => format!("{method} at every level to {highest:.0} dB"),
            false => format!("{method} up to {highest:.0} dB"),
        })
    };
    let described_methods: Vec<String> =
        Method::all(&[]).into_iter().filter_map(described).collect();
    match described_methods.is_empty() {
        true => Some("No method misses or invents modes in white noise.".to_owned()),
        false => Some(format!(
            "Modes are missed or invented by {}.",
            described_methods.join(", ")
        )),
    }
}

/// Methods with a bias: their error does not fall with the noise.
fn biased_methods(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let (low, high) = (
        *study.options.snr_db.first()?,
        *study.options.snr_db.last()?,
    );
    let described = |method: Method| {
        let error = |snr_db| {
            let row = test.twin_row(Condition::White, snr_db, method)?;
            row.counts.frequency()
        };
        let (before, after) = (error(low)?, error(high)?);
        let fallen_db = 20.0 * (before / after).log10();
        let is_biased = fallen_db < MIN_ERROR_FALL_OVER_NOISE_FALL * (high - low);
        is_biased.then(|| format!("{method} ({:.1e} %)", 100.0 * after))
    };
    let described_methods: Vec<String> =
        Method::all(&[]).into_iter().filter_map(described).collect();
    (!described_methods.is_empty()).then(|| {
        format!(
            "The bias of these methods remains at less noise: {}.",
            described_methods.join(", ")
        )
    })
}

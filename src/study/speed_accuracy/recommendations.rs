//! What the numbers teach, in sentences that follow from them.

use super::super::{Method, REFINED};
use super::{Condition, DataRow, SpeedAccuracy, TestStudy};

/// A method is right at a level where it misses and invents no more than this share of the
/// observable modes.
const MOST_MISTAKES: f64 = 0.02;
/// A method follows the noise where its error falls by half of what the noise does or more.
const LEAST_FALL: f64 = 0.5;

/// Which method when, test by test.
pub fn lessons(study: &SpeedAccuracy) -> Vec<String> {
    let of_test = |test: &TestStudy| {
        let own = [
            on_data(test),
            in_white_noise(test, study),
            lifted(test, study, Condition::Outside),
            lifted(test, study, Condition::Truncated),
            mistaken(test, study),
            stuck(test, study),
        ];
        let own: Vec<String> = own.into_iter().flatten().collect();
        format!("{}: {}", test.name, own.join(" "))
    };
    study.tests.iter().map(of_test).collect()
}

fn refined() -> Method {
    Method {
        name: REFINED,
        order: None,
    }
}

/// The fastest and the most exact of those with the fewest mistakes.
fn on_data(test: &TestStudy) -> Option<String> {
    let mut front: Vec<&DataRow> = test.data.iter().filter(|row| row.on_front).collect();
    let time = |row: &&DataRow| row.timing.median_s.unwrap_or(f64::INFINITY);
    front.sort_by(|a, b| time(a).total_cmp(&time(b)));
    let told = |row: &DataRow| {
        let error = match (row.is_reference, row.tally.frequency()) {
            (true, _) => "the refined solution itself".to_owned(),
            (_, error) => format!(
                "frequencies {:.1e} % rms from the refined ones",
                100.0 * error?
            ),
        };
        let tally = &row.tally;
        Some(format!(
            "{}{}, lines {:.3} Hz apart ({} of {} modes, {} spurious, {error})",
            row.method,
            row.estimator
                .map_or(String::new(), |name| format!(" on {name}")),
            row.step_hz,
            tally.found,
            tally.observable,
            tally.spurious,
        ))
    };
    let (first, last) = (front.first()?, front.last()?);
    let most_exact = match front.len() {
        1 => ", and none is more exact than it by what the data tell".to_owned(),
        _ => format!(", the most exact {}", told(last)?),
    };
    let known = test.frequency_std.map_or(String::new(), |std| {
        format!(
            " The refined frequencies are known to {:.1e} %.",
            100.0 * std
        )
    });
    Some(format!(
        "of those with the fewest mistakes on its data the fastest is {}{most_exact}.{known}",
        told(first)?
    ))
}

/// Frequency error over the bound of a method at every level.
fn over_bound(
    test: &TestStudy,
    study: &SpeedAccuracy,
    (condition, method): (Condition, Method),
) -> Vec<(f64, f64)> {
    let level = |snr_db: &f64| {
        let row = test.twin_row(condition, *snr_db, method)?;
        Some((*snr_db, row.tally.frequency_over_bound()?))
    };
    study.options.snr_db.iter().filter_map(level).collect()
}

fn ends(values: &[(f64, f64)]) -> Option<(f64, f64)> {
    let least = values.iter().map(|own| own.1).reduce(f64::min)?;
    let most = values.iter().map(|own| own.1).reduce(f64::max)?;
    Some((least, most))
}

fn in_white_noise(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let own = over_bound(test, study, (Condition::White, refined()));
    let (least, most) = ends(&own)?;
    let others = Method::all(&[])
        .into_iter()
        .filter(|method| method.name != REFINED);
    let next = others.filter_map(|method| {
        let own = over_bound(test, study, (Condition::White, method));
        Some((ends(&own)?.1, method))
    });
    let next = next.min_by(|a, b| a.0.total_cmp(&b.0));
    let next = next.map_or(String::new(), |(most, method)| {
        format!(", {method}, the next, up to {most:.1} times")
    });
    Some(format!(
        "In white noise from {:.0} to {:.0} dB the frequency errors of {REFINED} are {least:.2} to {most:.2} times their Cramér-Rao \
         bound{next}.",
        own.first()?.0,
        own.last()?.0
    ))
}

/// By how much modes outside the band or the end of the record lift the refined method off its
/// bound.
fn lifted(test: &TestStudy, study: &SpeedAccuracy, condition: Condition) -> Option<String> {
    let own = over_bound(test, study, (condition, refined()));
    let (least, most) = (own.first()?, own.last()?);
    // Who is off by least at the end where the noise hides least.
    let at_end = Method::all(&[]).into_iter().filter_map(|method| {
        let own = over_bound(test, study, (condition, method));
        Some((own.last().filter(|own| own.0 >= most.0)?.1, method))
    });
    let best = at_end.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let other = match best.1.name == REFINED {
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

/// Methods that miss or invent modes in white noise, with the highest level at which they do.
fn mistaken(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let told = |method: Method| {
        let wrong = |snr_db: &&f64| {
            let row = test.twin_row(Condition::White, **snr_db, method);
            row.is_some_and(|row| {
                let most = MOST_MISTAKES * row.tally.observable as f64;
                row.tally.mistakes() as f64 > most
            })
        };
        let highest = study.options.snr_db.iter().rev().find(wrong)?;
        Some(match study.options.snr_db.last() == Some(highest) {
            true => format!("{method} at every level to {highest:.0} dB"),
            false => format!("{method} up to {highest:.0} dB"),
        })
    };
    let told: Vec<String> = Method::all(&[]).into_iter().filter_map(told).collect();
    match told.is_empty() {
        true => Some("No method misses or invents modes in white noise.".to_owned()),
        false => Some(format!(
            "Modes are missed or invented by {}.",
            told.join(", ")
        )),
    }
}

/// Methods whose error does not fall with the noise: they have an error of their own.
fn stuck(test: &TestStudy, study: &SpeedAccuracy) -> Option<String> {
    let (low, high) = (
        *study.options.snr_db.first()?,
        *study.options.snr_db.last()?,
    );
    let told = |method: Method| {
        let error = |snr_db| {
            let row = test.twin_row(Condition::White, snr_db, method)?;
            row.tally.frequency()
        };
        let (before, after) = (error(low)?, error(high)?);
        let fallen_db = 20.0 * (before / after).log10();
        let own = fallen_db < LEAST_FALL * (high - low);
        own.then(|| format!("{method} ({:.1e} %)", 100.0 * after))
    };
    let told: Vec<String> = Method::all(&[]).into_iter().filter_map(told).collect();
    (!told.is_empty()).then(|| {
        format!(
            "These have an error of their own, which less noise does not take away: {}.",
            told.join(", ")
        )
    })
}

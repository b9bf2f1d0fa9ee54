//! The FRF tables list estimated FRFs with their coherence, and hits with their verdicts.

use crate::axis::Band;
use crate::frf::{FrfSet, HitReport};
use crate::printable::counted;
use crate::signal::{Check, Outcome, Rule};

use super::verdict::Verdict;
use super::{Block, Cell, Column, Table};

/// One row per FRF, with the median coherence over the usable band.
pub fn frf_block(set: &FrfSet, usable: Band, hits: &[HitReport]) -> Block {
    let used = hits.iter().filter(|hit| hit.used).count();
    let lines = set.axis().lines(&usable);
    let row = |index: usize| {
        let function = &set.functions()[index];
        vec![
            Cell::text(function.response.to_string()),
            Cell::text(function.reference.to_string()),
            Cell::text(function.kind.to_string()),
            Cell::text(function.kind.si_unit()),
            function
                .averages
                .map_or(Cell::Missing, |n| Cell::text(n.to_string())),
            function
                .estimator
                .map_or(Cell::Missing, |estimator| Cell::text(estimator.name())),
            Cell::number(
                set.coherence(index)
                    .and_then(|values| median(&values[lines.clone()])),
                4,
            ),
        ]
    };
    let heads = [
        "response",
        "reference",
        "kind",
        "unit",
        "averages",
        "estimator",
    ];
    Block::Table(Table {
        caption: format!(
            "{} from {used} of {}",
            counted(set.len(), "FRF"),
            counted(hits.len(), "hit")
        ),
        columns: heads
            .map(Column::text)
            .into_iter()
            .chain([Column::number("median coherence")])
            .collect(),
        rows: (0..set.len()).map(row).collect(),
        footnotes: vec![format!(
            "{} by {:.6} Hz; usable band {:.2} to {:.2} Hz (force within 20 dB, below 0.4 of the sampling rate).",
            counted(set.axis().len, "line"),
            set.axis().step_hz,
            usable.lo_hz,
            usable.hi_hz
        )],
    })
}

/// One row per hit, with its verdict and the checks that it does not pass.
pub fn hits_block(caption: &str, hits: &[HitReport]) -> Block {
    let row = |hit: &HitReport| {
        vec![
            Cell::text(hit.number.to_string()),
            Cell::text(hit.reference.to_string()),
            Cell::number(hit.peak_n, 2),
            Cell::text(verdict(hit).text()),
            Cell::text(unpassed_checks(hit)),
        ]
    };
    let rows: Vec<Vec<Cell>> = hits.iter().map(row).collect();
    let not_passed = hits.iter().any(|hit| !unpassed_checks(hit).is_empty());
    let footnote = not_passed.then(|| {
        "Why: rule, channel, value and, in brackets, the limit beyond which a hit is rejected or a remark is made.".to_owned()
    });
    Block::Table(Table {
        caption: caption.to_owned(),
        columns: vec![
            Column::text("hit"),
            Column::text("at"),
            Column::number("peak (N)"),
            Column::text("verdict"),
            Column::text("why"),
        ],
        rows,
        footnotes: footnote.into_iter().collect(),
    })
}

fn verdict(hit: &HitReport) -> Verdict {
    let is_noted = |check: &Check| check.outcome == Outcome::Noted;
    match (hit.used, hit.stated) {
        (true, false) if hit.checks.iter().any(is_noted) => Verdict::UsedWithRemark,
        (true, false) => Verdict::Used,
        (true, true) => Verdict::UsedAsStated,
        (false, false) => Verdict::Rejected,
        (false, true) => Verdict::RejectedAsStated,
    }
}

/// Rule, channel, value and limit of every check that a hit does not pass.
fn unpassed_checks(hit: &HitReport) -> String {
    let unpassed = hit.checks.iter().filter(|check| match check.outcome {
        Outcome::Passed => false,
        // Too few hits for a comparison; the table shows their number.
        Outcome::NotDecidable => !matches!(check.rule, Rule::Level | Rule::InconsistentHit),
        Outcome::Noted | Outcome::Rejected => true,
    });
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.3}"));
    let text = |check: &Check| {
        let channel = check
            .dof
            .as_ref()
            .map_or_else(String::new, |dof| format!(" {dof}"));
        let (value, limit) = (number(check.value), number(check.limit));
        let what = match (check.outcome, check.rule, check.at) {
            (Outcome::NotDecidable, ..) => "not assessable".to_owned(),
            (_, Rule::RollOff, Some(hz)) => format!("from {hz:.1} Hz"),
            (_, Rule::DoubleHit, Some(s)) => format!("{value} ({limit}) after {:.2} ms", 1e3 * s),
            _ => format!("{value} ({limit})"),
        };
        format!("{}{channel} {what}", check.rule.name())
    };
    unpassed.map(text).collect::<Vec<_>>().join("; ")
}

pub(super) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

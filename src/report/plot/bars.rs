//! Bar charts show frequency errors by mode and kinetic energy fractions by natural frequency.

use crate::correlate::Status;
use crate::linalg::sort_descending_by;
use crate::scene::{EnergyBar, Overview, OverviewCell, OverviewRow, TestFigures};

use super::super::test_title::test_title;
use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, COLORS, Canvas, FAINT, INK, LEGEND_ROW_PX, legend_rows};

/// Maximum number of kinds of bodies with an individual colour.
const MAX_COLORED_BODIES: usize = 6;

/// Error of every natural frequency in the band of a test, with its standard deviation, and a cross
/// where the test has no partner; `None` without any.
pub(super) fn frequency_errors(overview: &Overview, figures: &[TestFigures]) -> Option<String> {
    let inside = |row: &&OverviewRow| {
        let seen = row
            .cells
            .iter()
            .any(|cell| cell.status != Status::OutsideBand);
        row.theory_hz.is_some() && seen
    };
    let rows: Vec<&OverviewRow> = overview.rows.iter().filter(inside).collect();
    let ends = rows.iter().flat_map(|row| &row.cells).filter_map(|cell| {
        let spread = cell.error_std_percent.unwrap_or(0.0);
        Some([cell.error_percent? - spread, cell.error_percent? + spread])
    });
    let (lo, hi) = range(ends.flatten().chain([0.0]))?;
    if rows.is_empty() || hi <= lo {
        return None;
    }
    let tests: Vec<&str> = overview
        .tests
        .iter()
        .map(|test| test.test.as_str())
        .collect();
    let titles = titles(&tests, figures);
    let mut names: Vec<(&str, &str)> = titles.iter().map(String::as_str).zip(colors()).collect();
    if any_missed(&rows) {
        names.push(("× unmatched", INK));
    }
    let more = LEGEND_ROW_PX * (legend_rows(70.0, 735.0, &names) - 1) as f64;
    let mut canvas = Canvas::new(735.0, 320.0 + more);
    let pad = 0.08 * (hi - lo);
    let count = rows.len() as f64;
    let x = Axis::linear((0.4, count + 0.6), (70.0, 720.0)).with_step(1.0);
    let y = Axis::linear((lo - pad, hi + pad), (260.0, 34.0));
    let label = match overview.of_theory {
        true => "(test−theory)/theory (%), line ±1 std",
        false => "(theory−test)/test (%), line ±1 std",
    };
    draw_frame(&mut canvas, (&x, &y), ("", label));
    let wide = 0.8 / tests.len().max(1) as f64;
    let every = rows.len().div_ceil(24).max(1);
    for (k, row) in rows.iter().enumerate() {
        let middle = k as f64 + 1.0;
        if k % every == 0 {
            canvas.text([x.position(middle), 276.0], &row.label, Anchor::Middle, INK);
        }
        for cell in &row.cells {
            let Some(n) = tests.iter().position(|test| *test == cell.test) else {
                continue;
            };
            let at = middle + (n as f64 - 0.5 * (tests.len() as f64 - 1.0)) * wide;
            let Some(error) = cell.error_percent else {
                if is_missed(cell) {
                    draw_cross(&mut canvas, [x.position(at), 255.0]);
                }
                continue;
            };
            let (a, b) = (x.position(at - 0.45 * wide), x.position(at + 0.45 * wide));
            canvas.rect(
                [a, y.position(0.0)],
                [b, y.position(error)],
                COLORS[n % COLORS.len()],
                "none",
            );
            if let Some(std) = cell.error_std_percent {
                let x = x.position(at);
                canvas.line(
                    [x, y.position(error - std)],
                    [x, y.position(error + std)],
                    INK,
                    1.0,
                );
            }
        }
    }
    canvas.line([70.0, y.position(0.0)], [720.0, y.position(0.0)], INK, 1.0);
    canvas.legend([70.0, 306.0], &names);
    Some(canvas.finish())
}

/// The names of tests, marked where they are synthetic.
fn titles(tests: &[&str], figures: &[TestFigures]) -> Vec<String> {
    let title = |name: &&str| {
        let figure = figures.iter().find(|figure| figure.name == **name);
        test_title(name, figure.is_some_and(|figure| figure.synthetic))
    };
    tests.iter().map(title).collect()
}

fn colors() -> impl Iterator<Item = &'static str> {
    COLORS.into_iter().cycle()
}

fn any_missed(rows: &[&OverviewRow]) -> bool {
    let mut cells = rows.iter().flat_map(|row| &row.cells);
    cells.any(|cell| cell.error_percent.is_none() && is_missed(cell))
}

fn is_missed(cell: &OverviewCell) -> bool {
    matches!(
        cell.status,
        Status::MissedExpected | Status::MissedUnexpected
    )
}

/// Marks an unmatched natural frequency, which has no error on the axis.
fn draw_cross(canvas: &mut Canvas, [x, y]: [f64; 2]) {
    for rise in [-3.5, 3.5] {
        canvas.line([x - 3.5, y - rise], [x + 3.5, y + rise], INK, 1.2);
    }
}

/// Kinetic energy of every natural frequency by kind of body; `None` without any.
pub(super) fn energies(bars: &[EnergyBar]) -> Option<String> {
    if bars.is_empty() {
        return None;
    }
    let mut totals: Vec<(&str, f64)> = Vec::new();
    for (name, share) in bars.iter().flat_map(|bar| &bar.kinetic) {
        match totals.iter_mut().find(|(body, _)| body == name) {
            Some((_, total)) => *total += share,
            None => totals.push((name, *share)),
        }
    }
    sort_descending_by(&mut totals, |total| total.1);
    let color = |name: &str| {
        let rank = totals.iter().position(|(body, _)| *body == name);
        rank.filter(|rank| *rank < MAX_COLORED_BODIES)
            .map_or("#d0d0d0", |rank| COLORS[rank])
    };
    let bottom = 30.0 + 20.0 * bars.len() as f64;
    let mut canvas = Canvas::new(735.0, bottom + 40.0);
    canvas.text(
        [110.0, 18.0],
        "Fraction of the kinetic energy by natural frequency of the model",
        Anchor::Start,
        INK,
    );
    for (k, bar) in bars.iter().enumerate() {
        let top = 30.0 + 20.0 * k as f64;
        canvas.text(
            [102.0, top + 12.0],
            &format!("{:.1} Hz", bar.hz),
            Anchor::End,
            INK,
        );
        let mut left = 110.0;
        for (name, _) in &totals {
            let Some((_, share)) = bar.kinetic.iter().find(|(body, _)| body == name) else {
                continue;
            };
            let right = left + 600.0 * share;
            canvas.rect([left, top], [right, top + 15.0], color(name), "none");
            left = right;
        }
        canvas.rect([110.0, top], [710.0, top + 15.0], "none", FAINT);
    }
    let names: Vec<(&str, &str)> = totals
        .iter()
        .take(MAX_COLORED_BODIES)
        .map(|(name, _)| (*name, color(name)))
        .collect();
    canvas.legend([110.0, bottom + 26.0], &names);
    Some(canvas.finish())
}

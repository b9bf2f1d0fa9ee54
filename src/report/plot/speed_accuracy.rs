//! The speed and accuracy figures show time and error of every method, and errors over their
//! Cramér-Rao bound against noise.

use crate::linalg::sort_ascending_by;
use crate::study::{Condition, DetectionCounts, Method, SpeedAccuracy, TestStudy};

use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, Canvas, FAINT, INK};
use super::file_name;
use super::mark::{curve_color, draw_mark};

const LEFT_PX: [f64; 2] = [75.0, 475.0];
const WIDTH_PX: f64 = 320.0;
const SIZE_PX: [f64; 2] = [815.0, 446.0];
const TOP_PX: f64 = 48.0;
const BOTTOM_PX: f64 = 320.0;
/// Minimum drawn error over the accuracy limit; smaller errors are drawn there.
const MIN_DRAWN_OVER_LIMIT: f64 = 0.1;

/// The figures of a study: three for each test.
pub fn speed_accuracy_figures(study: &SpeedAccuracy) -> Vec<(String, String)> {
    let of_test = |test: &TestStudy| {
        let stem = format!("speed-accuracy-{}", file_name(&test.name));
        [
            (format!("{stem}-data"), cost_figure(&data_chart(test))),
            (
                format!("{stem}-twin"),
                cost_figure(&twin_chart(study, test)),
            ),
            (format!("{stem}-bound"), errors_over_bound(study, test)),
        ]
    };
    let all = study.tests.iter().flat_map(of_test);
    all.filter_map(|(name, text)| Some((name, text?))).collect()
}

/// Time and errors of a method on some data.
struct Point {
    method: usize,
    label: String,
    time_s: Option<f64>,
    error: [Option<f64>; 2],
    is_faultless: bool,
    on_front: bool,
}

/// CPU time against error for every method.
struct Chart {
    title: String,
    points: Vec<Point>,
    /// Limit of the accuracy of the errors of frequency and damping.
    accuracy_limit: [Option<f64>; 2],
    accuracy_limit_name: &'static str,
    transform_s: Option<f64>,
    pass_s: Option<f64>,
}

fn method_index(method: Method) -> usize {
    let names = Method::all(&[]).into_iter();
    names
        .map(|listed| listed.name)
        .position(|name| name == method.name)
        .unwrap_or(0)
}

fn errors(counts: &DetectionCounts) -> [Option<f64>; 2] {
    [counts.frequency(), counts.damping()]
}

fn data_chart(test: &TestStudy) -> Chart {
    let finest = test
        .data
        .iter()
        .map(|row| row.step_hz)
        .fold(f64::INFINITY, f64::min);
    let points = test.data.iter().filter(|row| !row.is_reference).map(|row| {
        let shorter = if row.step_hz > 1.001 * finest {
            ", short"
        } else {
            ""
        };
        let estimator = row
            .estimator
            .map_or(String::new(), |name| format!(" {name}"));
        Point {
            method: method_index(row.method),
            label: format!("{}{estimator}{shorter}", row.method),
            time_s: row.timing.median_s,
            error: errors(&row.counts),
            is_faultless: row.counts.mistakes() == 0,
            on_front: row.on_front,
        }
    });
    Chart {
        title: format!(
            "{}: every method on the measured FRFs, error relative to the refined solution",
            test.name
        ),
        points: points.collect(),
        accuracy_limit: [test.frequency_std, test.damping_std],
        accuracy_limit_name: "standard deviation of the refined solution",
        transform_s: test.limits[0].transform_s,
        pass_s: test.limits[0].pass_s,
    }
}

fn twin_chart(study: &SpeedAccuracy, test: &TestStudy) -> Chart {
    let snr_db = study.options.middle_snr_db();
    let row = |method| test.twin_row(Condition::White, snr_db, method);
    let points = test.twin_costs.iter().filter_map(|cost| {
        let counts = &row(cost.method)?.counts;
        Some(Point {
            method: method_index(cost.method),
            label: cost.method.to_string(),
            time_s: cost.timing.median_s,
            error: errors(counts),
            is_faultless: counts.mistakes() == 0,
            on_front: cost.on_front,
        })
    });
    let bounds = test
        .twin
        .iter()
        .filter(|row| row.condition == Condition::White);
    let bounds = bounds.filter(|row| row.snr_db.total_cmp(&snr_db).is_eq());
    let highest = |value: &dyn Fn(&DetectionCounts) -> Option<f64>| {
        bounds
            .clone()
            .filter_map(|row| value(&row.counts))
            .reduce(f64::max)
    };
    Chart {
        title: format!(
            "{}: every method on its twin, {snr_db:.0} dB of white noise, against the truth",
            test.name
        ),
        points: points.collect(),
        accuracy_limit: [
            highest(&DetectionCounts::frequency_bound),
            highest(&DetectionCounts::damping_bound),
        ],
        accuracy_limit_name: "Cramér-Rao bound",
        transform_s: test.limits[1].transform_s,
        pass_s: test.limits[1].pass_s,
    }
}

/// Time and error, with frequency and damping in adjacent panels; `None` without a measured time.
fn cost_figure(chart: &Chart) -> Option<String> {
    let limits = [chart.transform_s, chart.pass_s];
    let times = chart.points.iter().map(|point| point.time_s).chain(limits);
    let (first, last) = range(times.flatten().filter(|time| *time > 0.0))?;
    let mut canvas = Canvas::new(SIZE_PX[0], SIZE_PX[1]);
    canvas.text([LEFT_PX[0], 18.0], &chart.title, Anchor::Start, INK);
    for (quantity, left) in LEFT_PX.into_iter().enumerate() {
        let x = Axis::log((0.6e3 * first, 2.0e3 * last), (left, left + WIDTH_PX));
        draw_panel(&mut canvas, chart, quantity, &x);
    }
    draw_method_legend(&mut canvas, [LEFT_PX[0], BOTTOM_PX + 60.0]);
    let names = [
        ("Pareto front", "", INK),
        (chart.accuracy_limit_name, "7 4", INK),
        ("one transform", "2 3", INK),
        ("one pass over the data", "2 3", FAINT),
    ];
    draw_line_legend(&mut canvas, [LEFT_PX[0], BOTTOM_PX + 80.0], &names);
    let notes = [
        "A dot in a mark: every observable mode is found and none is spurious. A ring: on the Pareto front of the methods with the fewest mistakes.",
        "CPU time of one machine, all threads. Errors under a tenth of the dashed line are drawn at a tenth.",
    ];
    for (row, note) in (0..).zip(notes) {
        let y = BOTTOM_PX + 100.0 + 16.0 * f64::from(row);
        canvas.text([LEFT_PX[0], y], note, Anchor::Start, FAINT);
    }
    Some(canvas.finish())
}

fn draw_panel(canvas: &mut Canvas, chart: &Chart, quantity: usize, x: &Axis) {
    let label = ["Frequency error, rms (%)", "Damping error, rms (%)"][quantity];
    let left = LEFT_PX[quantity];
    let bound = chart.accuracy_limit[quantity];
    let all = chart
        .points
        .iter()
        .map(|point| point.error[quantity])
        .chain([bound]);
    let positive = all.flatten().filter(|error| *error > 0.0);
    let Some((lo, hi)) = range(positive) else {
        return;
    };
    // Differences far below the accuracy limit have no significance.
    let lo = bound.map_or(lo, |bound| lo.max(MIN_DRAWN_OVER_LIMIT * bound));
    let y = Axis::log((80.0 * lo, 200.0 * hi), (BOTTOM_PX, TOP_PX));
    draw_frame(canvas, (x, &y), ("CPU time (ms)", label));
    for (time, color) in [(chart.transform_s, INK), (chart.pass_s, FAINT)] {
        let at = time.and_then(|time| x.visible_position(1e3 * time));
        let ends = at.map(|at| [Some([at, TOP_PX]), Some([at, BOTTOM_PX])]);
        canvas.curve("limit", &ends.unwrap_or([None; 2]), color, 1.2, "2 3");
    }
    let at = bound.and_then(|bound| y.visible_position(100.0 * bound));
    let ends = at.map(|at| [Some([left, at]), Some([left + WIDTH_PX, at])]);
    canvas.curve("bound", &ends.unwrap_or([None; 2]), INK, 1.2, "7 4");
    let place = |point: &Point| {
        let x = x.visible_position(1e3 * point.time_s?)?;
        Some([
            x,
            y.visible_position(100.0 * point.error[quantity]?.max(lo))?,
        ])
    };
    let mut front: Vec<&Point> = chart.points.iter().filter(|point| point.on_front).collect();
    sort_ascending_by(&mut front, |entry| entry.time_s.unwrap_or(0.0));
    // The front is that of time and frequency error.
    if quantity == 0 {
        let corners: Vec<_> = front.iter().map(|point| place(point)).collect();
        canvas.curve("front", &corners, INK, 1.0, "");
    }
    for point in &chart.points {
        if let Some(at) = place(point) {
            draw_method_mark(canvas, at, point.method, point.is_faultless);
            if point.on_front && quantity == 0 {
                canvas.dot(at, 8.5, "none", INK);
            }
        }
    }
    if quantity == 0 {
        let named = front
            .iter()
            .filter_map(|point| Some((place(point)?, point.label.as_str())));
        draw_labels(canvas, &named.collect::<Vec<_>>(), left + 0.6 * WIDTH_PX);
    }
}

/// Names below their points, one below the other where they would meet; to the left of points
/// beyond `turn`.
fn draw_labels(canvas: &mut Canvas, named: &[([f64; 2], &str)], turn: f64) {
    let mut taken: Vec<[f64; 2]> = Vec::new();
    for ([x, y], name) in named {
        let (dx, anchor) = match *x > turn {
            true => (-8.0, Anchor::End),
            false => (8.0, Anchor::Start),
        };
        let mut at = [x + dx, y + 14.0];
        let meets = |at: [f64; 2]| {
            let close = |label: &[f64; 2]| {
                (label[0] - at[0]).abs() < 90.0 && (label[1] - at[1]).abs() < 12.0
            };
            taken.iter().any(close)
        };
        while meets(at) {
            at[1] += 3.0;
        }
        taken.push(at);
        canvas.text(at, name, anchor, INK);
    }
}

/// The mark of a method; a dot in it shows that the method made no mistake.
fn draw_method_mark(canvas: &mut Canvas, at: [f64; 2], method: usize, is_faultless: bool) {
    draw_mark(canvas, at, method);
    if is_faultless {
        canvas.dot(at, 1.8, curve_color(method), "none");
    }
}

fn draw_method_legend(canvas: &mut Canvas, [mut x, y]: [f64; 2]) {
    for (number, method) in Method::all(&[]).into_iter().enumerate() {
        draw_method_mark(canvas, [x + 6.0, y - 4.0], number, false);
        canvas.text([x + 16.0, y], method.name, Anchor::Start, INK);
        x += 70.0;
    }
}

fn draw_line_legend(canvas: &mut Canvas, [mut x, y]: [f64; 2], names: &[(&str, &str, &str)]) {
    for (name, dash, color) in names {
        let ends = [Some([x, y - 4.0]), Some([x + 24.0, y - 4.0])];
        canvas.curve("legend", &ends, color, 1.2, dash);
        canvas.text([x + 30.0, y], name, Anchor::Start, INK);
        x += 48.0 + 6.0 * name.chars().count() as f64;
    }
}

/// Errors over their Cramér-Rao bound against noise, a column for each condition, frequency above
/// damping.
fn errors_over_bound(study: &SpeedAccuracy, test: &TestStudy) -> Option<String> {
    const COLUMN: f64 = 240.0;
    const GAP: f64 = 45.0;
    const ROWS: [[f64; 2]; 2] = [[52.0, 262.0], [282.0, 492.0]];
    let levels = &study.options.snr_db;
    let has = |condition: &Condition| test.twin.iter().any(|row| row.condition == *condition);
    let conditions: Vec<Condition> = Condition::ALL.into_iter().filter(has).collect();
    let value = |row: &DetectionCounts, quantity| match quantity {
        0 => row.frequency_over_bound(),
        _ => row.damping_over_bound(),
    };
    let (first, last) = range(levels.iter().copied())?;
    let mut canvas = Canvas::new(55.0 + (COLUMN + GAP) * conditions.len() as f64, 590.0);
    let title = format!(
        "{}: rms error over its Cramér-Rao bound on the twin",
        test.name
    );
    canvas.text([75.0, 18.0], &title, Anchor::Start, INK);
    for (quantity, [top, bottom]) in ROWS.into_iter().enumerate() {
        let all = test
            .twin
            .iter()
            .filter_map(|row| value(&row.counts, quantity));
        let (_, hi) = range(all.filter(|ratio| *ratio > 0.0))?;
        for (column, condition) in conditions.iter().enumerate() {
            let left = 75.0 + (COLUMN + GAP) * column as f64;
            let x = Axis::linear((first - 2.0, last + 2.0), (left, left + COLUMN));
            let y = Axis::log((0.4, 1.5 * hi.max(10.0)), (bottom, top));
            let within = [y.position(1.2), y.position(0.8)];
            canvas.rect(
                [left, within[0]],
                [left + COLUMN, within[1]],
                "#dcdcdc",
                "none",
            );
            let label = ["Frequency error / bound", "Damping error / bound"][quantity];
            let labels = match (column, quantity) {
                (0, 0) => ("", label),
                (0, _) => ("Signal-to-noise ratio (dB)", label),
                (_, 0) => ("", ""),
                _ => ("Signal-to-noise ratio (dB)", ""),
            };
            draw_frame(&mut canvas, (&x, &y), labels);
            if quantity == 0 {
                canvas.text(
                    [left + 4.0, top - 8.0],
                    condition.name(),
                    Anchor::Start,
                    INK,
                );
            }
            canvas.line(
                [left, y.position(1.0)],
                [left + COLUMN, y.position(1.0)],
                INK,
                1.0,
            );
            canvas.clip([left, top], [left + COLUMN, bottom]);
            for (number, method) in Method::all(&[]).into_iter().enumerate() {
                let rows = levels
                    .iter()
                    .map(|level| test.twin_row(*condition, *level, method));
                let points = rows.map(|row| {
                    let row = row?;
                    let at = [
                        x.position(row.snr_db),
                        y.visible_position(value(&row.counts, quantity)?)?,
                    ];
                    Some((at, row.counts.mistakes() == 0))
                });
                let points: Vec<Option<([f64; 2], bool)>> = points.collect();
                let curve: Vec<Option<[f64; 2]>> =
                    points.iter().map(|point| Some(point.as_ref()?.0)).collect();
                canvas.curve("method", &curve, curve_color(number), 1.1, "");
                for (at, is_faultless) in points.into_iter().flatten() {
                    draw_method_mark(&mut canvas, at, number, is_faultless);
                }
            }
            canvas.unclip();
        }
    }
    draw_method_legend(&mut canvas, [75.0, 552.0]);
    canvas.text(
        [75.0, 574.0],
        "Grey: within 20 % of the bound. A dot in a mark: no mode missed or spurious in any draw.",
        Anchor::Start,
        FAINT,
    );
    Some(canvas.finish())
}

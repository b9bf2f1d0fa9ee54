//! The update figures show the objective by iteration, and parameters with their standard
//! deviations and frequency errors before and after.

use super::super::json::{UpdateFile, UpdatedParameterFile};
use crate::update::{ParameterVerdict, measured_mode};

use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, COLORS, Canvas, FAINT, GRID, INK, text_width};

const LEFT_PX: f64 = 75.0;
const RIGHT_PX: f64 = 720.0;
/// Height of the row of a parameter, px.
const ROW_HEIGHT_PX: f64 = 26.0;

/// The figures of an update with their names; `synthetic`: one of its tests is synthetic.
pub fn update_figures_svg(file: &UpdateFile, synthetic: bool) -> Vec<(String, String)> {
    let mark = if synthetic { " (synthetic test)" } else { "" };
    let drawn = [
        ("update-history", history(file, mark)),
        ("update-parameters", parameters(file, mark)),
        ("update-errors", frequency_errors(file, mark)),
    ];
    let drawn = drawn.into_iter();
    drawn
        .filter_map(|(name, svg)| Some((name.to_owned(), svg?)))
        .collect()
}

/// Objective and chi-square after every step, and chi-square of the initial model; `None` without
/// steps.
fn history(file: &UpdateFile, mark: &str) -> Option<String> {
    let steps = &file.history;
    if steps.is_empty() {
        return None;
    }
    let all = steps
        .iter()
        .flat_map(|step| [step.objective, step.chi_square]);
    let (lo, hi) = range(
        all.chain([file.before.chi_square])
            .filter(|value| *value > 0.0),
    )?;
    let mut canvas = Canvas::new(RIGHT_PX + 15.0, 330.0);
    let title = format!("Objective of the update by iteration{mark}");
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    let every = steps.len().div_ceil(12).max(1);
    let x =
        Axis::linear((0.5, steps.len() as f64 + 0.5), (LEFT_PX, RIGHT_PX)).with_step(every as f64);
    let y = Axis::log((lo / 1.3, 1.3 * hi), (260.0, 30.0));
    draw_frame(&mut canvas, (&x, &y), ("Iteration", "Objective"));
    let taken = |value: fn(&super::super::json::IterationFile) -> f64| {
        let all = steps.iter().enumerate();
        let taken = all.filter(|(_, step)| step.accepted);
        let points = taken
            .map(|(k, step)| Some([x.position(k as f64 + 1.0), y.visible_position(value(step))?]));
        points.collect::<Vec<_>>()
    };
    let (objective, data) = (taken(|step| step.objective), taken(|step| step.chi_square));
    let as_it_stands = y.visible_position(file.before.chi_square);
    let across = [LEFT_PX, RIGHT_PX].map(|x| as_it_stands.map(|y| [x, y]));
    canvas.curve("as-it-stands", &across, FAINT, 1.0, "2 3");
    canvas.curve("objective", &objective, COLORS[0], 1.6, "");
    canvas.curve("chi-square", &data, COLORS[1], 1.3, "5 3");
    for at in objective.into_iter().flatten() {
        canvas.dot(at, 2.4, COLORS[0], "none");
    }
    let mut names = vec![
        ("objective: data and prior", COLORS[0]),
        ("χ² of the data", COLORS[1]),
    ];
    if as_it_stands.is_some() {
        names.push(("χ² of the initial model", FAINT));
    }
    for (k, step) in steps.iter().enumerate().filter(|(_, step)| !step.accepted) {
        if let Some(at) = y.visible_position(step.objective) {
            canvas.dot([x.position(k as f64 + 1.0), at], 2.4, "none", COLORS[6]);
        }
    }
    if steps.iter().any(|step| !step.accepted) {
        names.push(("step not taken", COLORS[6]));
    }
    canvas.legend([LEFT_PX, 318.0], &names);
    Some(canvas.finish())
}

/// Change of every parameter in prior standard deviations, with its posterior standard deviation;
/// `None` without parameters.
fn parameters(file: &UpdateFile, mark: &str) -> Option<String> {
    let rows = file.parameters.iter().filter(|row| row.prior_std > 0.0);
    let rows: Vec<&UpdatedParameterFile> = rows.collect();
    let ends = rows.iter().flat_map(|row| {
        let place = (row.updated - row.initial) / row.prior_std;
        let spread = row.std / row.prior_std;
        [place - spread, place + spread]
    });
    let (lo, hi) = range(ends.chain([-1.0, 1.0]))?;
    if rows.is_empty() {
        return None;
    }
    let named = rows.iter().map(|row| text_width(&row.name));
    let left = (named.fold(0.0, f64::max) + 24.0).clamp(LEFT_PX, 260.0);
    let bottom = 32.0 + ROW_HEIGHT_PX * rows.len() as f64;
    let mut canvas = Canvas::new(RIGHT_PX + 235.0, bottom + 74.0);
    let title = format!("Parameters before and after the update{mark}");
    canvas.text([left, 18.0], &title, Anchor::Start, INK);
    let pad = 0.06 * (hi - lo);
    let x = Axis::linear((lo - pad, hi + pad), (left, RIGHT_PX));
    for (k, row) in rows.iter().enumerate() {
        draw_parameter(
            &mut canvas,
            row,
            &x,
            left,
            32.0 + ROW_HEIGHT_PX * (k as f64 + 0.5),
        );
    }
    for tick in x.ticks(8.0) {
        let at = x.position(tick.at);
        canvas.line([at, bottom], [at, bottom + 4.0], FAINT, 1.0);
        canvas.text([at, bottom + 16.0], &tick.text, Anchor::Middle, INK);
    }
    canvas.rect([left, 28.0], [RIGHT_PX, bottom], "none", FAINT);
    canvas.text(
        [0.5 * (left + RIGHT_PX), bottom + 34.0],
        "Change from the model's value (prior standard deviations)",
        Anchor::Middle,
        INK,
    );
    let names = [
        ("prior ±1 std", GRID),
        ("identified, ±1 std", COLORS[0]),
        ("at bound", COLORS[1]),
        ("not supported by the data", COLORS[6]),
    ];
    canvas.legend([left, bottom + 60.0], &names);
    Some(canvas.finish())
}

fn draw_parameter(canvas: &mut Canvas, row: &UpdatedParameterFile, x: &Axis, left: f64, y: f64) {
    let place = |value: f64| x.position((value - row.initial) / row.prior_std);
    let prior = [
        place(row.initial - row.prior_std),
        place(row.initial + row.prior_std),
    ];
    canvas.rect([prior[0], y - 7.0], [prior[1], y + 7.0], GRID, "none");
    canvas.line(
        [place(row.initial), y - 7.0],
        [place(row.initial), y + 7.0],
        FAINT,
        1.0,
    );
    let color = match row.verdict {
        ParameterVerdict::Identified => COLORS[0],
        ParameterVerdict::IdentifiedWithinModelError => COLORS[2],
        ParameterVerdict::AtBound | ParameterVerdict::Ambiguous => COLORS[1],
        ParameterVerdict::NotSupported => COLORS[6],
    };
    let ends = [place(row.updated - row.std), place(row.updated + row.std)];
    canvas.line([ends[0], y], [ends[1], y], color, 1.6);
    for end in ends {
        canvas.line([end, y - 4.0], [end, y + 4.0], color, 1.2);
    }
    canvas.dot([place(row.updated), y], 3.2, color, "none");
    canvas.text([left - 8.0, y + 4.0], &row.name, Anchor::End, INK);
    let unit = match row.unit.as_str() {
        "" | "-" | "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let values = format!(
        "{} → {} ± {}{unit}",
        significant_digits(row.initial, 4),
        significant_digits(row.updated, 4),
        significant_digits(row.std, 2)
    );
    canvas.text([RIGHT_PX + 10.0, y + 4.0], &values, Anchor::Start, INK);
}

/// A number with this many digits; a large or small one with its power of ten.
fn significant_digits(value: f64, digits: i32) -> String {
    let power = if value == 0.0 {
        0
    } else {
        value.abs().log10().floor() as i32
    };
    match power {
        -3..=4 => format!(
            "{value:.*}",
            usize::try_from(digits - 1 - power).unwrap_or(0)
        ),
        _ => format!("{value:.*e}", usize::try_from(digits - 1).unwrap_or(0)),
    }
}

/// Error of the frequency of every mode before and after; `None` where no mode has a partner.
fn frequency_errors(file: &UpdateFile, mark: &str) -> Option<String> {
    let rows: Vec<_> = file.before.rows.iter().zip(&file.after.rows).collect();
    let values = rows
        .iter()
        .flat_map(|(before, after)| [before.error_percent, after.error_percent]);
    let (lo, hi) = range(values.flatten().chain([0.0]))?;
    if hi <= lo {
        return None;
    }
    let longest = rows
        .iter()
        .map(|(row, _)| text_width(&measured_mode(&row.label)))
        .fold(0.0, f64::max);
    let below = 0.87 * longest + 30.0;
    let mut canvas = Canvas::new(RIGHT_PX + 15.0, 280.0 + below);
    let title = format!("Frequency errors before and after the update{mark}");
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    let pad = 0.08 * (hi - lo);
    let x = Axis::linear((0.4, rows.len() as f64 + 0.6), (LEFT_PX, RIGHT_PX)).with_step(1.0);
    let y = Axis::linear((lo - pad, hi + pad), (250.0, 30.0));
    draw_frame(&mut canvas, (&x, &y), ("", "Frequency error (%)"));
    for (k, (before, after)) in rows.iter().enumerate() {
        let middle = k as f64 + 1.0;
        let bars = [
            (before.error_percent, -0.38, COLORS[6]),
            (after.error_percent, 0.02, COLORS[0]),
        ];
        for (error, from, color) in bars {
            let Some(error) = error else { continue };
            let (a, b) = (x.position(middle + from), x.position(middle + from + 0.36));
            canvas.rect([a, y.position(0.0)], [b, y.position(error)], color, "none");
        }
        let at = [x.position(middle) + 4.0, 264.0];
        canvas.rotated_text(at, &measured_mode(&before.label), Anchor::End, INK, -60.0);
    }
    canvas.line(
        [LEFT_PX, y.position(0.0)],
        [RIGHT_PX, y.position(0.0)],
        INK,
        1.0,
    );
    let names = [("before", COLORS[6]), ("after", COLORS[0])];
    canvas.legend([LEFT_PX, 270.0 + below], &names);
    Some(canvas.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPDATE: &str = r#"{
        "schema": "modalign-update/1", "combinations": [], "correlation": [], "stop_reason": "no-decrease",
        "starts": {"count": 1, "reached": 1, "failed": 0, "seed": 1}, "degrees_of_freedom": 1.0, "reduced_chi_square": 1.0,
        "fits": true, "left_out": [], "pairing_changes": [], "explanation": null,
        "assumed": {"frequency_floor": 0.001, "shape_floor": null, "prior_std": 0.3},
        "parameters": [
            {"name": "mount", "unit": "N/m", "status": "assumed", "initial": 2e6, "updated": 1.7e6, "std": 4e4,
             "interval_95": [1.62e6, 1.78e6], "prior_std": 6e5, "posterior_over_prior": 0.08, "lower": null, "upper": null,
             "verdict": "identified", "held": false},
            {"name": "gap", "unit": "-", "status": "assumed", "initial": 0.5, "updated": 0.5, "std": 0.2,
             "interval_95": [0.1, 0.9], "prior_std": 0.2, "posterior_over_prior": 1.0, "lower": null, "upper": null,
             "verdict": "not supported by the data", "held": true}],
        "before": {"paired": 2, "chi_square": 900.0, "data_count": 2, "rms_percent": 3.0, "largest_percent": 4.0,
            "rows": [{"label": "a f1", "test_hz": 10.0, "test_std_hz": 0.01, "model_hz": 10.4, "model_std_hz": null,
                      "error_percent": -4.0, "mac": 0.9},
                     {"label": "a f2", "test_hz": 20.0, "test_std_hz": 0.01, "model_hz": null, "model_std_hz": null,
                      "error_percent": null, "mac": null}]},
        "after": {"paired": 2, "chi_square": 2.0, "data_count": 2, "rms_percent": 0.1, "largest_percent": 0.1,
            "rows": [{"label": "a f1", "test_hz": 10.0, "test_std_hz": 0.01, "model_hz": 10.01, "model_std_hz": null,
                      "error_percent": -0.1, "mac": 0.99},
                     {"label": "a f2", "test_hz": 20.0, "test_std_hz": 0.01, "model_hz": 20.0, "model_std_hz": null,
                      "error_percent": 0.0, "mac": 0.99}]},
        "history": [{"objective": 900.0, "chi_square": 900.0, "radius": 1.0, "accepted": true, "values": []},
                    {"objective": 950.0, "chi_square": 940.0, "radius": 1.0, "accepted": false, "values": []},
                    {"objective": 3.0, "chi_square": 2.0, "radius": 0.5, "accepted": true, "values": []}]
    }"#;

    fn places(svg: &str, name: &str, color: &str) -> Vec<f64> {
        let ours = svg
            .lines()
            .filter(|line| line.starts_with(name) && line.contains(color));
        let number = |line: &str| line.split("x=\"").nth(1)?.split('"').next()?.parse().ok();
        ours.filter_map(number).collect()
    }

    #[test]
    fn update_figures_show_iterations_parameters_and_errors() {
        let file: UpdateFile = serde_json::from_str(UPDATE).unwrap();
        let all = update_figures_svg(&file, true);
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["update-history", "update-parameters", "update-errors"]
        );
        for (name, svg) in &all {
            assert!(
                svg.contains("(synthetic test)") && !svg.contains("NaN"),
                "{name}"
            );
        }
        assert!(
            update_figures_svg(&file, false)
                .iter()
                .all(|(_, svg)| !svg.contains("synthetic"))
        );
        assert!(all[0].1.contains(">step not taken</text>"));
        let parameters = &all[1].1;
        assert!(
            parameters.contains(">2.000e6 → 1.700e6 ± 40000 N/m</text>"),
            "{parameters}"
        );
        // The mount moved by half a prior deviation down: halfway from the model's value to the
        // left end of its prior.
        let dots: Vec<f64> = places(&parameters.replace("cx=", "x="), "<circle", COLORS[0]);
        let band = places(parameters, "<rect", GRID)[0];
        let middle = places(&parameters.replace("cx=", "x="), "<circle", COLORS[6])[0];
        assert!(
            (dots[0] - 0.5 * (band + middle)).abs() < 0.11,
            "{dots:?} {band} {middle}"
        );
        // A mode without a partner before has a bar after alone; that one is of no height.
        assert_eq!(places(&all[2].1, "<rect", COLORS[6]).len(), 1);
        assert_eq!(places(&all[2].1, "<rect", COLORS[0]).len(), 2);
    }

    #[test]
    fn numbers_are_rounded_to_significant_digits() {
        for (value, digits, text) in [
            (2e6, 4, "2.000e6"),
            (0.5, 4, "0.5000"),
            (1234.5, 2, "1234"),
            (0.0, 2, "0.0"),
            (-3.2e-7, 2, "-3.2e-7"),
        ] {
            assert_eq!(significant_digits(value, digits), text);
        }
    }
}

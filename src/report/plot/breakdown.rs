//! Breakdown maps show the failure boundaries of all methods over two factors, with the modes of
//! the user; a second figure shows the digits lost by model order.
//!
//! Methods differ by colour, dash and mark, so that they remain distinct in grey prints and to
//! readers with a colour vision deficiency.

use crate::study::breakdown::{
    Field, MIN_SUCCESS_RATE, Scale, SliceResult, Stability, StabilityPoint, SuccessRate,
    UserModePosition,
};

use super::axis::{Axis, draw_frame};
use super::canvas::{Anchor, Canvas, INK};
use super::mark::{DASHES, curve_color, draw_mark};

const LEFT_PX: f64 = 70.0;
const RIGHT_PX: f64 = 530.0;
const TOP_PX: f64 = 46.0;
const BOTTOM_PX: f64 = 416.0;
const WIDTH_PX: f64 = 740.0;
/// Distance of marks along a contour, px.
const MARK_SPACING_PX: f64 = 70.0;
/// Darkness where every method fails.
const MAX_DARKENING: f64 = 72.0;

/// A slice with the failure boundary of each method: beyond it the method meets the stated error
/// in fewer than 95 % of the draws.
pub fn breakdown_svg(result: &SliceResult, points: &[UserModePosition]) -> String {
    let slice = &result.slice;
    let mut canvas = Canvas::new(WIDTH_PX, BOTTOM_PX + 50.0);
    let title = format!(
        "{}: where methods meet the stated error in 95 % of {} draws",
        slice.name, slice.draws
    );
    canvas.text([LEFT_PX, 20.0], &title, Anchor::Start, INK);
    let (x, y) = (
        axis(&slice.x, (LEFT_PX, RIGHT_PX)),
        axis(&slice.y, (BOTTOM_PX, TOP_PX)),
    );
    let fields: Vec<Field> = (0..slice.methods.len())
        .map(|method| result.field(method, SuccessRate::Counted))
        .collect();
    draw_shades(&mut canvas, &fields);
    let in_test = slice.needs_test();
    let labels = (slice.x.factor.label(in_test), slice.y.factor.label(in_test));
    draw_frame(&mut canvas, (&x, &y), labels);
    canvas.clip([LEFT_PX, TOP_PX], [RIGHT_PX, BOTTOM_PX]);
    for (method, field) in fields.iter().enumerate() {
        for line in field.contour(MIN_SUCCESS_RATE) {
            draw_contour(&mut canvas, method, &line);
        }
    }
    canvas.unclip();
    draw_user_modes(&mut canvas, points);
    draw_legend(&mut canvas, result, &fields);
    canvas.finish()
}

fn axis(factor_axis: &crate::study::breakdown::Axis, ends_px: (f64, f64)) -> Axis {
    let few = factor_axis.factor.is_whole() && factor_axis.hi - factor_axis.lo <= 10.0;
    match factor_axis.scale {
        Scale::Linear if few => {
            Axis::linear((factor_axis.lo, factor_axis.hi), ends_px).with_step(1.0)
        }
        Scale::Linear => Axis::linear((factor_axis.lo, factor_axis.hi), ends_px),
        Scale::Log => Axis::log((factor_axis.lo, factor_axis.hi), ends_px),
    }
}

/// Position on the page, px, of fractions of both axes.
fn map_position([x, y]: [f64; 2]) -> [f64; 2] {
    [
        LEFT_PX + x * (RIGHT_PX - LEFT_PX),
        BOTTOM_PX + y * (TOP_PX - BOTTOM_PX),
    ]
}

/// Shades each element of the map by the number of methods that fail there; equal neighbours of a
/// row share a rectangle.
fn draw_shades(canvas: &mut Canvas, fields: &[Field]) {
    let (columns, rows) = (fields[0].values.len(), fields[0].values[0].len());
    let failing = |i: usize, j: usize| {
        let middle = [
            (i as f64 + 0.5) / (columns - 1) as f64,
            (j as f64 + 0.5) / (rows - 1) as f64,
        ];
        fields
            .iter()
            .filter(|field| field.at(middle) < MIN_SUCCESS_RATE)
            .count()
    };
    let corner = |i: usize, j: usize| {
        map_position([
            i as f64 / (columns - 1) as f64,
            j as f64 / (rows - 1) as f64,
        ])
    };
    for j in 0..rows - 1 {
        let row: Vec<usize> = (0..columns - 1).map(|i| failing(i, j)).collect();
        let mut begin = 0;
        for end in 1..columns {
            if end == columns - 1 || row[end] != row[begin] {
                if row[begin] > 0 {
                    let fill = shade(row[begin], fields.len());
                    canvas.rect(corner(begin, j), corner(end, j + 1), &fill, "none");
                }
                begin = end;
            }
        }
    }
}

fn shade(failing: usize, methods: usize) -> String {
    let level = 255.0 - MAX_DARKENING * failing as f64 / methods as f64;
    let level = level.round() as u8;
    format!("#{level:02x}{level:02x}{level:02x}")
}

/// A contour with marks at a constant distance; the first mark is at a different distance for each
/// method.
fn draw_contour(canvas: &mut Canvas, method: usize, line: &[[f64; 2]]) {
    let points: Vec<[f64; 2]> = line
        .iter()
        .map(|fractions| map_position(*fractions))
        .collect();
    let dash = DASHES[method % DASHES.len()];
    let strokes: Vec<Option<[f64; 2]>> = points.iter().copied().map(Some).collect();
    canvas.curve("contour", &strokes, curve_color(method), 1.8, dash);
    let mut next = MARK_SPACING_PX * (0.25 + 0.5 * (method as f64 * 0.37).fract());
    let mut run = 0.0;
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        while length > 0.0 && run + length >= next {
            let share = (next - run) / length;
            let at = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
            draw_mark(canvas, at, method);
            next += MARK_SPACING_PX;
        }
        run += length;
    }
}

/// Maximum number of labels of user modes.
const MAX_LABELS: usize = 6;

/// Draws the modes of the user as black points. Coincident points share a label. The points nearest
/// to a failure boundary are labelled, as far as there is room.
fn draw_user_modes(canvas: &mut Canvas, points: &[UserModePosition]) {
    let mut groups: Vec<([f64; 2], Vec<&UserModePosition>)> = Vec::new();
    for point in points.iter().filter(|point| point.is_inside()) {
        let at = map_position(point.place);
        let near = |group: &&mut ([f64; 2], Vec<&UserModePosition>)| {
            (group.0[0] - at[0]).hypot(group.0[1] - at[1]) < 8.0
        };
        match groups.iter_mut().find(near) {
            Some((_, all)) => all.push(point),
            None => groups.push((at, vec![point])),
        }
        canvas.dot(at, 3.6, INK, "#ffffff");
    }
    let around = |at: &[f64; 2]| [at[0] - 4.0, at[1] - 4.0, at[0] + 4.0, at[1] + 4.0];
    let mut taken: Vec<[f64; 4]> = groups.iter().map(|(at, _)| around(at)).collect();
    for (at, all) in groups.iter().take(MAX_LABELS) {
        let Some(text) = group_label(all) else {
            continue;
        };
        let width = 5.6 * text.chars().count() as f64;
        let area = |corner: &[f64; 2]| {
            [
                corner[0],
                corner[1] - 10.0,
                corner[0] + width,
                corner[1] + 2.0,
            ]
        };
        let free = |corner: &[f64; 2]| {
            let label = area(corner);
            let inside = label[0] > LEFT_PX
                && label[2] < RIGHT_PX
                && label[1] > TOP_PX
                && label[3] < BOTTOM_PX;
            inside && !taken.iter().any(|other| overlap(&label, other))
        };
        let offers = [-6.0, 14.0, -20.0, 28.0, -34.0, 42.0].into_iter();
        let mut offers = offers.flat_map(|down| {
            [
                [at[0] + 5.0, at[1] + down],
                [at[0] - 5.0 - width, at[1] + down],
            ]
        });
        let Some(at) = offers.find(free) else {
            continue;
        };
        let label = area(&at);
        taken.push(label);
        canvas.rect(
            [label[0] - 1.0, label[1]],
            [label[2] + 1.0, label[3]],
            "#ffffff",
            "none",
        );
        canvas.text(at, &text, Anchor::Start, INK);
    }
}

/// `mode 4`, `modes 1, 2`, `modes 1 to 6`; under the name of the test where there are several.
/// `None` for modes of several tests.
fn group_label(all: &[&UserModePosition]) -> Option<String> {
    let test = all[0].mode.test.as_str();
    if all.iter().any(|point| point.mode.test != test) {
        return None;
    }
    let mut numbers: Vec<usize> = all.iter().map(|point| point.mode.number).collect();
    numbers.sort_unstable();
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    let is_run = last - first + 1 == numbers.len();
    let text = match numbers.as_slice() {
        [one] => format!("mode {one}"),
        [a, b] => format!("modes {a}, {b}"),
        _ if is_run => format!("modes {first} to {last}"),
        _ => format!("{} modes", numbers.len()),
    };
    Some(match test {
        "" => text,
        test => format!("{test}, {text}"),
    })
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn draw_legend(canvas: &mut Canvas, result: &SliceResult, fields: &[Field]) {
    let x = RIGHT_PX + 18.0;
    for (method, name) in result.slice.methods.iter().enumerate() {
        let y = TOP_PX + 12.0 + 24.0 * method as f64;
        let stroke = [Some([x, y - 4.0]), Some([x + 40.0, y - 4.0])];
        let dash = DASHES[method % DASHES.len()];
        canvas.curve("legend", &stroke, curve_color(method), 1.8, dash);
        draw_mark(canvas, [x + 20.0, y - 4.0], method);
        let values = || fields[method].values.iter().flatten();
        let note = match values().any(|v| *v >= MIN_SUCCESS_RATE) {
            false => " (nowhere here)",
            true if values().all(|v| *v >= MIN_SUCCESS_RATE) => " (everywhere here)",
            true => "",
        };
        canvas.text([x + 48.0, y], &format!("{name}{note}"), Anchor::Start, INK);
    }
    let mut y = TOP_PX + 28.0 + 24.0 * result.slice.methods.len() as f64;
    let methods = result.slice.methods.len();
    for (failing, text) in [(0, "no method fails"), (methods, "every method fails")] {
        canvas.rect(
            [x, y - 11.0],
            [x + 40.0, y + 1.0],
            &shade(failing, methods),
            "#8a8a8a",
        );
        canvas.text([x + 48.0, y], text, Anchor::Start, INK);
        y += 20.0;
    }
    canvas.dot([x + 20.0, y - 4.0], 3.6, INK, "#ffffff");
    canvas.text([x + 48.0, y], "user modes", Anchor::Start, INK);
}

const PANEL_HEIGHT_PX: f64 = 300.0;

/// Condition number, and error of the poles in f64 and f32, over the order.
pub fn stability_svg(stability: &Stability) -> String {
    let mut canvas = Canvas::new(WIDTH_PX, 2.0 * PANEL_HEIGHT_PX + 60.0);
    let orders = stability.curves.iter().flat_map(|course| &course.points);
    let highest = orders.map(|point| point.order).max().unwrap_or(2) as f64;
    let title = "Digits lost by order: data without noise, as many modes as the order needs";
    canvas.text([LEFT_PX, 20.0], title, Anchor::Start, INK);
    let x = Axis::linear((0.0, highest), (LEFT_PX, RIGHT_PX));
    let panels = [
        ((0.0, 18.0), 0.0, "Digits lost (log10 of the condition)"),
        (
            (-16.0, 2.0),
            PANEL_HEIGHT_PX,
            "Error of poles (log10, half-power widths)",
        ),
    ];
    for (range, shift, label) in panels {
        let (bottom, top) = (TOP_PX + PANEL_HEIGHT_PX - 50.0 + shift, TOP_PX + shift);
        let y = Axis::linear(range, (bottom, top)).with_step(2.0);
        draw_frame(&mut canvas, (&x, &y), ("Order", label));
        canvas.clip([LEFT_PX, top], [RIGHT_PX, bottom]);
        for (index, course) in stability.curves.iter().enumerate() {
            let courses: &[(Value, &str)] = match shift > 0.0 {
                true => &ERRORS,
                false => &CONDITION,
            };
            for (value, dash) in courses {
                let at = |point: &StabilityPoint| {
                    let value = value(point)?.log10().clamp(range.0, range.1);
                    Some([x.position(point.order as f64), y.position(value)])
                };
                let points: Vec<Option<[f64; 2]>> = course.points.iter().map(at).collect();
                canvas.curve("course", &points, curve_color(index), 1.6, dash);
                if dash.is_empty() {
                    let marked = points.iter().skip(index).step_by(4).flatten();
                    marked.for_each(|at| draw_mark(&mut canvas, *at, index));
                }
            }
        }
        canvas.unclip();
    }
    draw_stability_legend(&mut canvas, stability);
    canvas.finish()
}

/// Quantity that a curve of the figure shows.
type Value = fn(&StabilityPoint) -> Option<f64>;

const CONDITION: [(Value, &str); 1] = [(|point| Some(point.condition), "")];
const ERRORS: [(Value, &str); 3] = [
    (|point| point.error, ""),
    (|point| point.error_f32_data, "7 3"),
    (|point| point.error_f32_matrix, "2 3"),
];

fn draw_stability_legend(canvas: &mut Canvas, stability: &Stability) {
    let x = RIGHT_PX + 18.0;
    for (index, course) in stability.curves.iter().enumerate() {
        let y = TOP_PX + 12.0 + 24.0 * index as f64;
        let stroke = [Some([x, y - 4.0]), Some([x + 40.0, y - 4.0])];
        canvas.curve("legend", &stroke, curve_color(index), 1.8, "");
        draw_mark(canvas, [x + 20.0, y - 4.0], index);
        canvas.text([x + 48.0, y], &course.method, Anchor::Start, INK);
    }
    let kinds = ["all in f64", "data in f32", "data and equations in f32"];
    for (index, (text, (_, dash))) in kinds.iter().zip(&ERRORS).enumerate() {
        let y = TOP_PX + PANEL_HEIGHT_PX + 12.0 + 24.0 * index as f64;
        let stroke = [Some([x, y - 4.0]), Some([x + 40.0, y - 4.0])];
        canvas.curve("legend", &stroke, INK, 1.6, dash);
        canvas.text([x + 48.0, y], text, Anchor::Start, INK);
    }
}

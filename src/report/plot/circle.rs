//! The circle-fit figure shows the Nyquist circle of a mode and its damping surface.

use crate::scene::CircleFigure;

use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, COLORS, Canvas, INK};
use super::mac::heat_color;

const SIDE_PX: f64 = 330.0;

pub(super) fn circle_fit(figure: &CircleFigure, test: &str) -> String {
    let mut canvas = Canvas::new(860.0, 440.0);
    let title = format!(
        "{test}, mode {}: {:.2} Hz, {}",
        figure.mode, figure.hz, figure.function
    );
    canvas.text([75.0, 20.0], &title, Anchor::Start, INK);
    draw_nyquist_circle(&mut canvas, figure);
    draw_damping_surface(&mut canvas, figure);
    canvas.finish()
}

fn draw_nyquist_circle(canvas: &mut Canvas, figure: &CircleFigure) {
    let with_circle = |values: &[f64], center: f64| {
        let ends = [center - figure.radius, center + figure.radius];
        range(values.iter().copied().chain(ends)).unwrap_or((0.0, 1.0))
    };
    let (re, im) = (
        with_circle(&figure.re, figure.center[0]),
        with_circle(&figure.im, figure.center[1]),
    );
    let half = 0.54 * f64::max(re.1 - re.0, im.1 - im.0);
    let around = |(lo, hi): (f64, f64)| (0.5 * (lo + hi) - half, 0.5 * (lo + hi) + half);
    let x = Axis::linear(around(re), (75.0, 75.0 + SIDE_PX));
    let y = Axis::linear(around(im), (40.0 + SIDE_PX, 40.0));
    draw_frame(
        canvas,
        (&x, &y),
        ("Real part (m/N)", "Imaginary part (m/N)"),
    );
    let turn = |k: usize| {
        let angle = k as f64 * std::f64::consts::TAU / 90.0;
        let re = figure.center[0] + figure.radius * angle.cos();
        let im = figure.center[1] + figure.radius * angle.sin();
        Some([x.position(re), y.position(im)])
    };
    let points: Vec<Option<[f64; 2]>> = (0..=90).map(turn).collect();
    canvas.curve("circle", &points, COLORS[1], 1.3, "");
    for (re, im) in figure.re.iter().zip(&figure.im) {
        canvas.dot([x.position(*re), y.position(*im)], 2.4, COLORS[0], "none");
    }
    let [re, im] = figure.resonance;
    canvas.dot([x.position(re), y.position(im)], 4.5, "none", COLORS[2]);
    canvas.legend(
        [75.0, 430.0],
        &[
            ("data with the other modes subtracted", COLORS[0]),
            ("circle", COLORS[1]),
            ("resonance", COLORS[2]),
        ],
    );
}

fn draw_damping_surface(canvas: &mut Canvas, figure: &CircleFigure) {
    let ends = |hz: &[f64]| range(hz.iter().copied());
    let (Some(below), Some(above)) = (ends(&figure.below_hz), ends(&figure.above_hz)) else {
        return;
    };
    let values = figure.damping.iter().flatten().flatten().copied();
    let Some((lowest, highest)) = range(values) else {
        return;
    };
    let steps = [figure.below_hz.len(), figure.above_hz.len()].map(|count| SIDE_PX / count as f64);
    let (left, top) = (490.0, 40.0);
    for (i, row) in figure.damping.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let Some(value) = value else { continue };
            let share = if highest > lowest {
                (value - lowest) / (highest - lowest)
            } else {
                0.5
            };
            let corner = [
                left + i as f64 * steps[0],
                top + SIDE_PX - j as f64 * steps[1],
            ];
            let other = [corner[0] + steps[0], corner[1] - steps[1]];
            canvas.rect(corner, other, &heat_color(0.1 + 0.8 * share), "none");
        }
    }
    canvas.rect([left, top], [left + SIDE_PX, top + SIDE_PX], "none", INK);
    let x = Axis::linear(below, (left, left + SIDE_PX));
    let y = Axis::linear(above, (top + SIDE_PX, top));
    let labels = ("Line below the resonance (Hz)", "Line above (Hz)");
    for tick in x.ticks(4.0) {
        canvas.text(
            [x.position(tick.at), top + SIDE_PX + 15.0],
            &tick.text,
            Anchor::Middle,
            INK,
        );
    }
    for tick in y.ticks(6.0) {
        canvas.text(
            [left - 6.0, y.position(tick.at) + 4.0],
            &tick.text,
            Anchor::End,
            INK,
        );
    }
    canvas.text(
        [left + 0.5 * SIDE_PX, top + SIDE_PX + 32.0],
        labels.0,
        Anchor::Middle,
        INK,
    );
    canvas.rotated_text(
        [left - 52.0, top + 0.5 * SIDE_PX],
        labels.1,
        Anchor::Middle,
        INK,
        -90.0,
    );
    let caption = format!(
        "Damping ratio of each pair of lines: {:.4} % (light) to {:.4} % (dark)",
        100.0 * lowest,
        100.0 * highest
    );
    canvas.text([left, 430.0], &caption, Anchor::Start, INK);
}

//! The Bode plot shows magnitude, phase and coherence of an FRF, with the FRF synthesized from the
//! modes.

use crate::scene::{Curve, FrfFigure, TestFigures};

use super::super::test_title::test_title;
use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, COLORS, Canvas, FAINT, INK};

const LEFT_PX: f64 = 70.0;
const RIGHT_PX: f64 = 700.0;
/// Minimum phase difference between lines that counts as a wrap, degrees.
const MIN_PHASE_WRAP_DEG: f64 = 180.0;

pub(super) fn bode(test: &TestFigures, set: &FrfFigure, curve: &Curve) -> String {
    let coherent = !curve.coherence.is_empty();
    let bottoms = [260.0, 400.0, 490.0];
    let last = if coherent { 2 } else { 1 };
    let mut canvas = Canvas::new(RIGHT_PX + 22.0, bottoms[last] + 44.0);
    let hz: Vec<f64> = curve
        .lines
        .iter()
        .map(|k| set.start_hz + *k as f64 * set.step_hz)
        .collect();
    let x = Axis::linear(
        range(hz.iter().copied()).unwrap_or((0.0, 1.0)),
        (LEFT_PX, RIGHT_PX),
    );
    let title = format!(
        "{}: {} / {}, {}",
        test_title(&test.name, test.synthetic),
        curve.response,
        curve.reference,
        curve.kind
    );
    canvas.text([LEFT_PX, 18.0], &title, Anchor::Start, INK);
    let fitted = !curve.fit_magnitude.is_empty();
    let names: &[(&str, &str)] = &[("data", COLORS[0]), ("fit", COLORS[1])];
    canvas.legend(
        [RIGHT_PX - 110.0, 18.0],
        if fitted { names } else { &names[..1] },
    );

    let all = curve
        .magnitude
        .iter()
        .copied()
        .chain(curve.fit_magnitude.iter().flatten().copied());
    let (lo, hi) = range(all.filter(|value| *value > 0.0)).unwrap_or((1.0, 10.0));
    let y = Axis::log((lo / 1.4, 1.4 * hi), (bottoms[0], 28.0));
    let label = |index: usize| if index == last { "Frequency (Hz)" } else { "" };
    draw_frame(
        &mut canvas,
        (&x, &y),
        (
            label(0),
            &format!("Magnitude ({})", curve.unit.replace("/s2", "/s²")),
        ),
    );
    canvas.clip([LEFT_PX, 28.0], [RIGHT_PX, bottoms[0]]);
    mark_modes(&mut canvas, test, &x, 28.0, bottoms[0]);
    let measured: Vec<Option<f64>> = curve.magnitude.iter().copied().map(Some).collect();
    let data = points(&hz, &measured, &x, &y);
    let fit = points(&hz, &curve.fit_magnitude, &x, &y);
    canvas.curve("magnitude", &data, COLORS[0], 1.1, "");
    canvas.curve("magnitude-fit", &fit, COLORS[1], 1.3, "5 3");
    canvas.unclip();

    let y = Axis::linear((-190.0, 190.0), (bottoms[1], 280.0)).with_step(90.0);
    draw_frame(&mut canvas, (&x, &y), (label(1), "Phase (°)"));
    let measured: Vec<Option<f64>> = curve.phase_deg.iter().copied().map(Some).collect();
    let data = phase_points(&hz, &measured, &x, &y);
    let fit = phase_points(&hz, &curve.fit_phase_deg, &x, &y);
    canvas.curve("phase", &data, COLORS[0], 1.1, "");
    canvas.curve("phase-fit", &fit, COLORS[1], 1.3, "5 3");

    if coherent {
        let y = Axis::linear((0.0, 1.05), (bottoms[2], 420.0));
        draw_frame(&mut canvas, (&x, &y), (label(2), "Coherence"));
        let points: Vec<Option<[f64; 2]>> = hz
            .iter()
            .zip(&curve.coherence)
            .map(|(hz, value)| Some([x.position(*hz), y.position(*value)]))
            .collect();
        canvas.curve("coherence", &points, COLORS[2], 1.0, "");
    }
    canvas.finish()
}

/// Lines at the natural frequencies, with the numbers of the modes.
fn mark_modes(canvas: &mut Canvas, test: &TestFigures, x: &Axis, top: f64, bottom: f64) {
    for (index, mode) in test.modes.iter().enumerate() {
        let at = x.position(mode.hz);
        canvas.line([at, top], [at, bottom], FAINT, 0.5);
        canvas.text(
            [at + 2.0, top + 10.0],
            &(index + 1).to_string(),
            Anchor::Start,
            FAINT,
        );
    }
}

/// Positions of values at frequencies; the pen is lifted where there is none.
fn points(hz: &[f64], values: &[Option<f64>], x: &Axis, y: &Axis) -> Vec<Option<[f64; 2]>> {
    let point =
        |(hz, value): (&f64, &Option<f64>)| Some([x.position(*hz), y.visible_position((*value)?)?]);
    hz.iter().zip(values).map(point).collect()
}

/// Positions of phases, with the pen lifted where the phase wraps.
fn phase_points(
    hz: &[f64],
    phase_deg: &[Option<f64>],
    x: &Axis,
    y: &Axis,
) -> Vec<Option<[f64; 2]>> {
    let mut broken = Vec::with_capacity(phase_deg.len());
    for (k, point) in points(hz, phase_deg, x, y).into_iter().enumerate() {
        let before = k.checked_sub(1).and_then(|before| phase_deg[before]);
        let step = phase_deg[k].zip(before);
        if step.is_some_and(|(phase, before)| (phase - before).abs() > MIN_PHASE_WRAP_DEG) {
            broken.push(None);
        }
        broken.push(point);
    }
    broken
}

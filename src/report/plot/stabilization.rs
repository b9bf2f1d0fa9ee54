//! The stabilization diagram shows the poles of all model orders over the CMIF.

use crate::scene::{StabilizationFigure, TestFigures};

use super::super::test_title::test_title;
use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, COLORS, Canvas, FAINT, INK, text_width};

const LEFT_PX: f64 = 64.0;
const RIGHT_PX: f64 = 720.0;
const TOP_PX: f64 = 30.0;
const BOTTOM_PX: f64 = 420.0;
/// Lower end of the shown CMIF, relative to its peak.
const MIN_SHOWN_OVER_PEAK: f64 = 1e-6;

pub(super) fn stabilization(test: &TestFigures, figure: &StabilizationFigure) -> String {
    let mut canvas = Canvas::new(RIGHT_PX + 16.0, BOTTOM_PX + 64.0);
    let orders = range(figure.order.iter().map(|order| *order as f64)).unwrap_or((0.0, 1.0));
    let pad = f64::max(1.0, 0.06 * (orders.1 - orders.0));
    let x = Axis::linear((figure.band_hz[0], figure.band_hz[1]), (LEFT_PX, RIGHT_PX));
    let y = Axis::linear((orders.0 - pad, orders.1 + pad), (BOTTOM_PX, TOP_PX));
    canvas.text(
        [LEFT_PX, 18.0],
        &format!(
            "{}: poles of {} over the CMIF",
            test_title(&test.name, test.synthetic),
            figure.method
        ),
        Anchor::Start,
        INK,
    );
    draw_frame(&mut canvas, (&x, &y), ("Frequency (Hz)", "Model order"));
    canvas.clip([LEFT_PX, TOP_PX], [RIGHT_PX, BOTTOM_PX]);
    draw_cmif(&mut canvas, figure, &x);
    for mode in &test.modes {
        let at = x.position(mode.hz);
        canvas.line([at, TOP_PX], [at, BOTTOM_PX], FAINT, 0.5);
    }
    let styles = [
        (1.6, ("none", COLORS[6])),
        (2.4, (COLORS[0], "none")),
        (3.4, (COLORS[2], INK)),
    ];
    for (k, status) in figure.status.iter().enumerate() {
        let (radius, (fill, stroke)) = styles[usize::from(*status).min(2)];
        canvas.dot(
            [x.position(figure.hz[k]), y.position(figure.order[k] as f64)],
            radius,
            fill,
            stroke,
        );
    }
    canvas.unclip();
    draw_legend(&mut canvas, &styles);
    canvas.finish()
}

/// Legend of the poles, of the line of an identified mode, and of the CMIF.
fn draw_legend(canvas: &mut Canvas, poles: &[(f64, (&str, &str))]) {
    let (mut x, y) = (LEFT_PX, BOTTOM_PX + 56.0);
    let names = ["unstable", "stable", "selected", "identified modes", "CMIF"];
    for (k, name) in names.into_iter().enumerate() {
        match (poles.get(k), name) {
            (Some((radius, (fill, stroke))), _) => {
                canvas.dot([x + 8.0, y - 4.0], *radius, fill, stroke)
            }
            (None, "CMIF") => canvas.line([x, y - 4.0], [x + 16.0, y - 4.0], "#b5b5b5", 1.0),
            (None, _) => canvas.line([x + 8.0, y - 11.0], [x + 8.0, y + 2.0], FAINT, 0.5),
        }
        canvas.text([x + 21.0, y], name, Anchor::Start, INK);
        x += 39.0 + text_width(name);
    }
}

fn draw_cmif(canvas: &mut Canvas, figure: &StabilizationFigure, x: &Axis) {
    let all = figure
        .cmif
        .values
        .iter()
        .flatten()
        .copied()
        .filter(|value| *value > 0.0);
    let Some((lo, hi)) = range(all) else { return };
    let lo = lo.max(MIN_SHOWN_OVER_PEAK * hi);
    let y = Axis::log((lo, 1.3 * hi), (BOTTOM_PX, TOP_PX));
    for curve in &figure.cmif.values {
        let points = figure.cmif.hz.iter().zip(curve);
        let points: Vec<Option<[f64; 2]>> = points
            .map(|(hz, value)| Some([x.position(*hz), y.visible_position(value.max(lo))?]))
            .collect();
        canvas.curve("cmif", &points, "#b5b5b5", 1.0, "");
    }
}

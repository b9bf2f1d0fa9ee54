//! The order selection figure shows, over the number of modes, the prediction of held-out lines,
//! the reduced chi-square, and BIC.

use crate::identify::{OrderSelection, OrderStep};
use crate::study::{SceneNeeds, TestNeeds};

use super::super::test_title::test_title;
use super::axis::{Axis, draw_frame, range};
use super::canvas::{Anchor, Canvas, FAINT, INK};
use super::file_name;
use super::mark::{curve_color, draw_mark};

const LEFT_PX: [f64; 2] = [75.0, 475.0];
const WIDTH_PX: f64 = 320.0;
const SIZE_PX: [f64; 2] = [815.0, 400.0];
const TOP_PX: f64 = 48.0;
const BOTTOM_PX: f64 = 300.0;
/// Distance of the marks of two curves at one number of modes, so that neither hides the other.
const MARK_OFFSET_MODES: f64 = 0.3;

/// A figure for each test.
pub fn order_figures(needs: &SceneNeeds) -> Vec<(String, String)> {
    let of_test = |test: &TestNeeds| {
        let name = format!("order-{}", file_name(&test.name));
        Some((name, figure(test)?))
    };
    needs.tests.iter().filter_map(of_test).collect()
}

/// A curve over the number of modes.
struct Curve<'a> {
    name: &'static str,
    value: &'a dyn Fn(&OrderStep) -> Option<f64>,
    supported: Option<usize>,
}

fn figure(test: &TestNeeds) -> Option<String> {
    let support = &test.support;
    let min_bic = support.tried.get(support.by_bic())?.bic;
    let bic = |tried: &OrderStep| Some(tried.bic - min_bic + 1.0);
    let residual = |tried: &OrderStep| Some(tried.rest);
    let prediction = |tried: &OrderStep| tried.predicted.map(|score| score.mean);
    let curves = [
        vec![
            Curve {
                name: "held-out lines",
                value: &prediction,
                supported: support.by_prediction(),
            },
            Curve {
                name: "reduced chi-square of all lines",
                value: &residual,
                supported: Some(support.by_residual()),
            },
        ],
        vec![Curve {
            name: "BIC",
            value: &bic,
            supported: Some(support.by_bic()),
        }],
    ];
    let labels = ["Relative to the noise", "BIC above its minimum + 1"];
    let mut canvas = Canvas::new(SIZE_PX[0], SIZE_PX[1]);
    let title = format!(
        "{}: number of modes that the data support",
        test_title(&test.name, test.synthetic)
    );
    canvas.text([LEFT_PX[0], 18.0], &title, Anchor::Start, INK);
    let mut number = 0;
    for ((curves, label), left) in curves.iter().zip(labels).zip(LEFT_PX) {
        draw_panel(&mut canvas, support, curves, number, left, label)?;
        number += curves.len();
    }
    let mut x = LEFT_PX[0];
    for (number, curve) in curves.iter().flatten().enumerate() {
        draw_mark(&mut canvas, [x + 6.0, BOTTOM_PX + 56.0], number);
        canvas.text([x + 16.0, BOTTOM_PX + 60.0], curve.name, Anchor::Start, INK);
        x += 200.0;
    }
    let note = "Dashed: last identified mode; beyond it, further stable poles. A dot in a mark: the supported number of modes.";
    canvas.text([LEFT_PX[0], BOTTOM_PX + 82.0], note, Anchor::Start, FAINT);
    Some(canvas.finish())
}

/// `first`: index of the first of the curves in the figure.
fn draw_panel(
    canvas: &mut Canvas,
    support: &OrderSelection,
    curves: &[Curve],
    first: usize,
    left: f64,
    label: &str,
) -> Option<()> {
    let last = support.tried.len() - 1;
    let x = Axis::linear((-0.5, last as f64 + 0.5), (left, left + WIDTH_PX));
    let x = x.with_step((last as f64 / 12.0).ceil().max(1.0));
    let all = curves
        .iter()
        .flat_map(|curve| support.tried.iter().filter_map(curve.value));
    let (lo, hi) = range(all.filter(|value| *value > 0.0))?;
    let y = Axis::log((0.7 * lo, 1.5 * hi), (BOTTOM_PX, TOP_PX));
    draw_frame(canvas, (&x, &y), ("Modes", label));
    let at = x.position(support.identified as f64 + 0.5);
    let ends = [Some([at, TOP_PX]), Some([at, BOTTOM_PX])];
    canvas.curve("identified", &ends, INK, 1.0, "7 4");
    for (number, curve) in curves.iter().enumerate() {
        let color = curve_color(first + number);
        let offset = MARK_OFFSET_MODES * (number as f64 - 0.5 * (curves.len() - 1) as f64);
        let place = |(roots, tried): (usize, &OrderStep)| {
            let at = x.position(roots as f64 + offset);
            Some([at, y.visible_position((curve.value)(tried)?)?])
        };
        let points: Vec<Option<[f64; 2]>> = support.tried.iter().enumerate().map(place).collect();
        canvas.curve("course", &points, color, 1.1, "");
        for (roots, at) in points.into_iter().enumerate() {
            if let Some(at) = at {
                draw_mark(canvas, at, first + number);
                if Some(roots) == curve.supported {
                    canvas.dot(at, 1.8, color, "none");
                }
            }
        }
    }
    Some(())
}

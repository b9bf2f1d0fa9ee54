//! The shape figure shows test and theory at their maximum deflection, with a panel for each test
//! mode; lines of the theory are dashed.

use crate::scene::{Partner, ShapeFigure, ShapeValues};

use super::canvas::{Anchor, COLORS, Canvas, FAINT, GRID, INK};

const PANEL_WIDTH_PX: f64 = 240.0;
const PANEL_HEIGHT_PX: f64 = 170.0;
/// Height of a title, px.
const TITLE_HEIGHT_PX: f64 = 10.0;
const COLUMNS: usize = 3;
/// Maximum deflection relative to the half size of the structure.
const MAX_DEFLECTION_OVER_HALF_SIZE: f64 = 0.35;

/// Projection of points on the page.
struct View {
    center: [f64; 3],
    size: f64,
    /// View from above, for in-plane motion of a flat structure; otherwise an oblique view.
    above: bool,
    /// Pixels for the half size.
    unit: f64,
}

impl View {
    fn new(figure: &ShapeFigure) -> Self {
        let ends = |k: usize| {
            let all = figure.points.iter().map(|point| point.at_m[k]);
            super::axis::range(all).unwrap_or((0.0, 0.0))
        };
        let bounds = [ends(0), ends(1), ends(2)];
        let half = bounds
            .iter()
            .map(|(lo, hi)| 0.5 * (hi - lo))
            .fold(0.0, f64::max);
        let flat = bounds[2].1 - bounds[2].0 <= 1e-6 * half;
        let mut view = Self {
            center: bounds.map(|(lo, hi)| 0.5 * (lo + hi)),
            size: if half > 0.0 { half } else { 1.0 },
            above: flat
                && figure
                    .readings
                    .iter()
                    .all(|reading| reading.direction[2].abs() < 0.01),
            unit: 1.0,
        };
        let extent = |k: usize| {
            let all = figure
                .points
                .iter()
                .map(|point| view.projected(point.at_m)[k].abs());
            all.fold(0.0, f64::max) + MAX_DEFLECTION_OVER_HALF_SIZE
        };
        view.unit = f64::min(
            0.48 * PANEL_WIDTH_PX / extent(0),
            (0.48 * PANEL_HEIGHT_PX - TITLE_HEIGHT_PX) / extent(1),
        );
        view
    }

    /// Coordinates to the right and up, relative to the half size.
    fn projected(&self, at: [f64; 3]) -> [f64; 2] {
        let [x, y, z] = [0, 1, 2].map(|k| (at[k] - self.center[k]) / self.size);
        match self.above {
            true => [x, y],
            false => [0.94 * x + 0.34 * y, 0.95 * z - 0.1 * x + 0.29 * y],
        }
    }

    fn position(&self, at: [f64; 3], [left, top]: [f64; 2]) -> [f64; 2] {
        let [right, up] = self.projected(at);
        [
            left + 0.5 * PANEL_WIDTH_PX + self.unit * right,
            top + 0.5 * PANEL_HEIGHT_PX + TITLE_HEIGHT_PX - self.unit * up,
        ]
    }
}

pub(super) fn shapes(figure: &ShapeFigure, test: &str) -> String {
    let view = View::new(figure);
    let rows = figure.test.len().div_ceil(COLUMNS);
    let mut canvas = Canvas::new(
        PANEL_WIDTH_PX * COLUMNS as f64,
        PANEL_HEIGHT_PX * rows as f64 + 34.0,
    );
    for k in 0..figure.test.len() {
        let corner = [
            (k % COLUMNS) as f64 * PANEL_WIDTH_PX,
            (k / COLUMNS) as f64 * PANEL_HEIGHT_PX,
        ];
        draw_panel(&mut canvas, figure, &view, corner, k);
    }
    let mut names = vec![(test, COLORS[0])];
    if figure.partners.iter().any(Option::is_some) {
        names.push(("theory", COLORS[1]));
    }
    names.push(match figure.in_a_row {
        true => ("undeformed: points without coordinates, in a row", FAINT),
        false => ("undeformed", FAINT),
    });
    canvas.legend([14.0, PANEL_HEIGHT_PX * rows as f64 + 22.0], &names);
    canvas.finish()
}

fn draw_panel(
    canvas: &mut Canvas,
    figure: &ShapeFigure,
    view: &View,
    corner: [f64; 2],
    index: usize,
) {
    let shape = &figure.test[index];
    let partner = figure.partners.get(index).and_then(Option::as_ref);
    let mac = partner
        .and_then(|partner| partner.mac)
        .map_or_else(String::new, |mac| format!(", MAC {mac:.3}"));
    let title = format!("{}: {:.1} Hz{mac}", index + 1, shape.hz);
    canvas.text(
        [corner[0] + 14.0, corner[1] + 18.0],
        &title,
        Anchor::Start,
        INK,
    );
    let test = at_maximum_deflection(&complex(shape));
    let theory = partner.and_then(|partner| partner_shape(figure, partner));
    // Both at the phase at which the test's shape is largest.
    let phase = test.1;
    let theory = theory.map(|values| at_phase(&values, phase));
    let moved = displacements(figure, &test.0);
    let largest = moved
        .iter()
        .map(|d| d.iter().map(|x| x * x).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let scale = if largest > 0.0 {
        MAX_DEFLECTION_OVER_HALF_SIZE * view.size / largest
    } else {
        0.0
    };
    let mut draw = |moved: Option<&[[f64; 3]]>, (color, width, dash): (&str, f64, &str)| {
        let at = |n: usize| {
            let point = &figure.points[n];
            let shift = moved.map_or([0.0; 3], |moved| moved[n]);
            let at = [0, 1, 2].map(|k| point.at_m[k] + scale * shift[k]);
            view.position(at, corner)
        };
        for [a, b] in &figure.lines {
            canvas.curve("shape", &[Some(at(*a)), Some(at(*b))], color, width, dash);
        }
        for n in 0..figure.points.len() {
            let from = view.position(figure.points[n].at_m, corner);
            canvas.line(from, at(n), color, 0.4);
            canvas.dot(at(n), 1.2 * width, color, "none");
        }
    };
    draw(None, (GRID, 1.0, ""));
    if let Some(theory) = theory {
        draw(
            Some(&displacements(figure, &theory)),
            (COLORS[1], 1.4, "4 3"),
        );
    }
    draw(Some(&moved), (COLORS[0], 1.7, ""));
}

type Values = Vec<Option<[f64; 2]>>;

fn complex(shape: &ShapeValues) -> Values {
    let imaginary = |k: usize| shape.im.get(k).copied().unwrap_or(0.0);
    let values = shape.re.iter().enumerate();
    values
        .map(|(k, re)| re.map(|re| [re, imaginary(k)]))
        .collect()
}

/// Real values at the phase at which the largest component is largest, and that phase, rad.
fn at_maximum_deflection(values: &Values) -> (Vec<Option<f64>>, f64) {
    let components = values.iter().flatten();
    let largest = components.max_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
    let phase = largest.map_or(0.0, |[re, im]| -im.atan2(*re));
    (at_phase(values, phase), phase)
}

fn at_phase(values: &Values, phase: f64) -> Vec<Option<f64>> {
    let (sine, cosine) = phase.sin_cos();
    let each = values.iter();
    each.map(|value| value.map(|[re, im]| re * cosine - im * sine))
        .collect()
}

/// The shape of the partner: sum of its modes with their factors; `None` where one is not shown.
fn partner_shape(figure: &ShapeFigure, partner: &Partner) -> Option<Values> {
    let mut total: Values = vec![Some([0.0; 2]); figure.readings.len()];
    for (j, re, im) in &partner.modes {
        let shape = complex(figure.theory.get(*j)?);
        for (all, one) in total.iter_mut().zip(shape) {
            *all = all.zip(one).map(|(all, one)| {
                [
                    all[0] + re * one[0] - im * one[1],
                    all[1] + re * one[1] + im * one[0],
                ]
            });
        }
    }
    Some(total)
}

fn displacements(figure: &ShapeFigure, values: &[Option<f64>]) -> Vec<[f64; 3]> {
    let mut moved = vec![[0.0; 3]; figure.points.len()];
    for (reading, value) in figure.readings.iter().zip(values) {
        let Some(value) = value else { continue };
        for (part, along) in moved[reading.point].iter_mut().zip(&reading.direction) {
            *part += value * along;
        }
    }
    moved
}

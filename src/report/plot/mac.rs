//! The MAC figure is a labelled heat map.

use crate::printable::counted;
use crate::report::Cell;
use crate::scene::MacFigure;

use super::canvas::{Anchor, COLORS, Canvas, FAINT, GRID, INK, text_width};

/// Colours from 0 to 1: white to dark blue.
const HEAT_COLORS: [[f64; 3]; 5] = [
    [255.0, 255.0, 255.0],
    [198.0, 219.0, 239.0],
    [107.0, 174.0, 214.0],
    [33.0, 113.0, 181.0],
    [8.0, 48.0, 107.0],
];

/// A cell without a value.
const MISSING_FILL: &str = "#f2f2f2";

/// The colour of a value from 0 to 1.
pub(super) fn heat_color(value: f64) -> String {
    let position = value.clamp(0.0, 1.0) * (HEAT_COLORS.len() - 1) as f64;
    let low = (position.floor() as usize).min(HEAT_COLORS.len() - 2);
    let mixed = [0, 1, 2].map(|k| {
        HEAT_COLORS[low][k]
            + (position - low as f64) * (HEAT_COLORS[low + 1][k] - HEAT_COLORS[low][k])
    });
    let [red, green, blue] = mixed.map(|level| level.round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

pub(super) fn mac(figure: &MacFigure, test: &str) -> String {
    let (rows, columns) = (figure.test_hz.len(), figure.theory_hz.len());
    let wide = (620.0 / columns.max(1) as f64).clamp(10.0, 44.0);
    let high = 22.0;
    let (left, top) = (90.0, 42.0);
    let bottom = top + high * rows as f64;
    let right = left + wide * columns as f64;
    let title = format!(
        "MAC of {test} and theory, {}",
        counted(figure.dofs, "degree of freedom")
    );
    let width = (right + 70.0).max(30.0 + text_width(&title));
    let mut canvas = Canvas::new(width, (bottom + 108.0).max(top + 160.0));
    canvas.text([18.0, 18.0], &title, Anchor::Start, INK);
    for (i, row) in figure.mac.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let a = [left + j as f64 * wide, top + i as f64 * high];
            let b = [a[0] + wide, a[1] + high];
            let fill = value.map_or_else(|| MISSING_FILL.to_owned(), heat_color);
            canvas.rect(a, b, &fill, GRID);
            if let Some(value) = value.filter(|value| *value >= 0.05 && wide >= 26.0) {
                let ink = if value > 0.55 { "#ffffff" } else { INK };
                let at = [a[0] + 0.5 * wide, a[1] + 0.5 * high + 4.0];
                canvas.text(
                    at,
                    &Cell::mac(Some(value), 2).display(),
                    Anchor::Middle,
                    ink,
                );
            }
        }
    }
    for [i, j] in &figure.pairs {
        let a = [left + *j as f64 * wide + 1.0, top + *i as f64 * high + 1.0];
        canvas.rect(a, [a[0] + wide - 2.0, a[1] + high - 2.0], "none", COLORS[1]);
    }
    for (i, hz) in figure.test_hz.iter().enumerate() {
        let at = [left - 6.0, top + (i as f64 + 0.5) * high + 4.0];
        canvas.text(at, &format!("{hz:.1}"), Anchor::End, INK);
    }
    for (j, hz) in figure.theory_hz.iter().enumerate() {
        let at = [left + (j as f64 + 0.5) * wide + 4.0, bottom + 10.0];
        canvas.rotated_text(at, &format!("{hz:.1}"), Anchor::End, INK, -60.0);
    }
    canvas.text(
        [0.5 * (left + right), bottom + 76.0],
        "Theory (Hz)",
        Anchor::Middle,
        INK,
    );
    canvas.rotated_text(
        [18.0, 0.5 * (top + bottom)],
        "Test (Hz)",
        Anchor::Middle,
        INK,
        -90.0,
    );
    draw_legend(&mut canvas, [left, bottom + 98.0], figure);
    draw_color_scale(&mut canvas, right + 18.0, top, top + 110.0);
    canvas.finish()
}

/// Legend of the frames and of cells without a value.
fn draw_legend(canvas: &mut Canvas, [mut x, y]: [f64; 2], figure: &MacFigure) {
    let some_missing = figure.mac.iter().flatten().any(Option::is_none);
    let names = [
        (!figure.pairs.is_empty(), "pair", ("none", COLORS[1])),
        (
            some_missing,
            "no common degree of freedom",
            (MISSING_FILL, GRID),
        ),
    ];
    for (_, name, (fill, stroke)) in names.into_iter().filter(|(wanted, ..)| *wanted) {
        canvas.rect([x, y - 10.0], [x + 16.0, y + 1.0], fill, stroke);
        canvas.text([x + 21.0, y], name, Anchor::Start, INK);
        x += 39.0 + text_width(name);
    }
}

fn draw_color_scale(canvas: &mut Canvas, x: f64, top: f64, bottom: f64) {
    let step = (bottom - top) / 20.0;
    for k in 0..20 {
        let y = bottom - f64::from(k) * step;
        canvas.rect(
            [x, y],
            [x + 12.0, y - step],
            &heat_color((f64::from(k) + 0.5) / 20.0),
            "none",
        );
    }
    canvas.rect([x, top], [x + 12.0, bottom], "none", FAINT);
    canvas.text([x - 6.0, top - 10.0], "MAC", Anchor::Start, INK);
    for (share, text) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
        let y = bottom + share * (top - bottom) + 4.0;
        canvas.text([x + 17.0, y], text, Anchor::Start, INK);
    }
}

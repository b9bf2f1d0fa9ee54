//! Marks and dashes distinguish curves without colour.

use super::canvas::{COLORS, Canvas};

/// Dashes of the curves, in turn.
pub(super) const DASHES: [&str; 7] = [
    "",
    "8 3",
    "2 2.5",
    "9 3 2 3",
    "14 4",
    "5 2 1.5 2 1.5 2",
    "4 5",
];

/// The colour of a curve, in turn; black is left for the modes of the user.
pub(super) fn curve_color(curve: usize) -> &'static str {
    COLORS[curve % (COLORS.len() - 1)]
}

/// Half the size of a mark, px.
const HALF_MARK_PX: f64 = 3.6;

/// The mark of a curve: circle, square, triangle, diamond, cross, plus, triangle upside down, in
/// turn.
pub(super) fn draw_mark(canvas: &mut Canvas, [x, y]: [f64; 2], curve: usize) {
    let s = HALF_MARK_PX;
    let color = curve_color(curve);
    let mut draw = |points: &[[f64; 2]]| {
        let points: Vec<_> = points.iter().map(|[u, v]| Some([x + u, y + v])).collect();
        canvas.curve("mark", &points, color, 1.5, "");
    };
    match curve % 7 {
        0 => canvas.dot([x, y], s, "#ffffff", color),
        1 => canvas.rect([x - s, y - s], [x + s, y + s], "#ffffff", color),
        2 => draw(&[[-s, s], [s, s], [0.0, -s], [-s, s]]),
        3 => draw(&[[-s, 0.0], [0.0, s], [s, 0.0], [0.0, -s], [-s, 0.0]]),
        4 => {
            draw(&[[-s, -s], [s, s]]);
            draw(&[[-s, s], [s, -s]]);
        }
        5 => {
            draw(&[[-s, 0.0], [s, 0.0]]);
            draw(&[[0.0, -s], [0.0, s]]);
        }
        _ => draw(&[[-s, -s], [s, -s], [0.0, s], [-s, -s]]),
    }
}

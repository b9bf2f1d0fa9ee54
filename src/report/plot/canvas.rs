//! The canvas writes the elements of an SVG figure.

use std::fmt::Write;

use crate::printable::printable_line;

/// Colours that remain distinct with a red-green colour vision deficiency (Okabe and Ito 2008,
/// Color universal design).
pub(super) const COLORS: [&str; 8] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#000000",
];
/// Text and frames.
pub(super) const INK: &str = "#1b1b1b";
/// Grids and backgrounds.
pub(super) const GRID: &str = "#e2e2e2";
/// Secondary lines and notes.
pub(super) const FAINT: &str = "#8a8a8a";

/// Size of letters, px.
const FONT_SIZE_PX: f64 = 11.0;
/// Distance of the rows of a legend, px.
pub(super) const LEGEND_ROW_PX: f64 = 16.0;

/// Approximate width of a text, px, by classes of letters of Helvetica.
pub(super) fn text_width(text: &str) -> f64 {
    let part = |c: char| match c {
        'i' | 'j' | 'l' | '\'' | '|' | '.' | ',' | ':' | ';' | ' ' | '/' | 't' | 'f' | '('
        | ')' => 0.29,
        'm' | 'w' | 'M' | 'W' | '%' | '—' | '→' => 0.88,
        'A'..='Z' | '+' | '×' | '±' => 0.68,
        c if c > '\u{2e7f}' => 1.0,
        _ => 0.56,
    };
    FONT_SIZE_PX * text.chars().map(part).sum::<f64>()
}

/// Number of rows of a legend that begins at `left` on a canvas of this width, px.
pub(super) fn legend_rows(left: f64, width: f64, names: &[(&str, &str)]) -> usize {
    let (mut x, mut rows) = (left, 1);
    for (name, _) in names {
        let wide = text_width(name);
        if x > left && x + 21.0 + wide > width - 4.0 {
            (x, rows) = (left, rows + 1);
        }
        x += 39.0 + wide;
    }
    rows
}

/// Alignment of a text relative to its position.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A figure that is being drawn.
pub(super) struct Canvas {
    width: f64,
    height: f64,
    body: String,
    clips: usize,
}

impl Canvas {
    /// An empty canvas of this size, px.
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            body: String::new(),
            clips: 0,
        }
    }

    /// The text of the SVG file.
    pub fn finish(self) -> String {
        let (width, height) = (self.width, self.height);
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{FONT_SIZE_PX}\">\n<rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.body
        )
    }

    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], color: &str, width: f64) {
        let _ = writeln!(
            self.body,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\" stroke-width=\"{width}\"/>",
            from[0], from[1], to[0], to[1]
        );
    }

    /// A rectangle by two corners; `fill` and `stroke` may be `none`.
    pub fn rect(&mut self, a: [f64; 2], b: [f64; 2], fill: &str, stroke: &str) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{fill}\" stroke=\"{stroke}\"/>",
            a[0].min(b[0]),
            a[1].min(b[1]),
            (b[0] - a[0]).abs(),
            (b[1] - a[1]).abs()
        );
    }

    /// A circle.
    pub fn dot(&mut self, at: [f64; 2], radius: f64, fill: &str, stroke: &str) {
        let _ = writeln!(
            self.body,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{fill}\" stroke=\"{stroke}\"/>",
            at[0], at[1]
        );
    }

    /// A curve; `None` lifts the pen.
    pub fn curve(
        &mut self,
        class: &str,
        points: &[Option<[f64; 2]>],
        color: &str,
        width: f64,
        dash: &str,
    ) {
        let mut path = String::new();
        let mut down = false;
        for point in points {
            if let Some([x, y]) = point {
                let _ = write!(path, "{}{x:.1} {y:.1}", if down { 'L' } else { 'M' });
            }
            down = point.is_some();
        }
        if !path.is_empty() {
            let _ = writeln!(
                self.body,
                "<path class=\"{class}\" d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-dasharray=\"{dash}\" stroke-linejoin=\"round\"/>"
            );
        }
    }

    pub fn text(&mut self, at: [f64; 2], text: &str, anchor: Anchor, color: &str) {
        self.rotated_text(at, text, anchor, color, 0.0);
    }

    /// A text rotated about its position, degrees.
    pub fn rotated_text(
        &mut self,
        [x, y]: [f64; 2],
        text: &str,
        anchor: Anchor,
        color: &str,
        degrees: f64,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = match degrees {
            0.0 => String::new(),
            _ => format!(" transform=\"rotate({degrees} {x:.1} {y:.1})\""),
        };
        let text = printable_line(text)
            // No XML file can hold them, however they are written.
            .replace(['\u{fffe}', '\u{ffff}'], " ")
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;");
        let _ = writeln!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{color}\"{turn}>{text}</text>"
        );
    }

    /// Clips further drawing to a rectangle, until [`Canvas::unclip`].
    pub fn clip(&mut self, a: [f64; 2], b: [f64; 2]) {
        self.clips += 1;
        let id = self.clips;
        let _ = writeln!(
            self.body,
            "<clipPath id=\"c{id}\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>\n<g clip-path=\"url(#c{id})\">",
            a[0].min(b[0]),
            a[1].min(b[1]),
            (b[0] - a[0]).abs(),
            (b[1] - a[1]).abs()
        );
    }

    /// Ends [`Canvas::clip`].
    pub fn unclip(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// Draws names with their colours in a row, and in further rows below where the canvas ends;
    /// [`legend_rows`] counts them.
    pub fn legend(&mut self, [left, mut y]: [f64; 2], names: &[(&str, &str)]) {
        let mut x = left;
        for (name, color) in names {
            let wide = text_width(name);
            if x > left && x + 21.0 + wide > self.width - 4.0 {
                (x, y) = (left, y + LEGEND_ROW_PX);
            }
            self.line([x, y - 4.0], [x + 16.0, y - 4.0], color, 3.0);
            self.text([x + 21.0, y], name, Anchor::Start, INK);
            x += 39.0 + wide;
        }
    }
}

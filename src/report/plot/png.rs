//! SVG to PNG for papers: the only place that names a rasteriser. The font is in the program, so that no installed one is needed
//! and every machine draws the same.

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

/// Arimo: a free font with the widths of Helvetica and Arial, which the SVG asks for.
const FONT: &[u8] = include_bytes!("font/Arimo-Regular.ttf");
/// Pixels of an SVG to the inch (CSS Values and Units, absolute lengths).
const PX_PER_INCH: f64 = 96.0;
/// Resolution for print.
const DOTS_PER_INCH: f64 = 300.0;
/// Larger figures, such as a MAC of hundreds of modes, have fewer dots to the inch.
const MOST_DOTS: f64 = 3.0e7;
const METRES_PER_INCH: f64 = 0.0254;

/// A figure as PNG at 300 dots to the inch of its SVG's size, which the file states; with fewer where that would be more than 30
/// million dots.
///
/// # Panics
/// For text that is no SVG of [`super::canvas::Canvas`].
pub(super) fn png(svg: &str) -> Vec<u8> {
    let tree = usvg::Tree::from_str(svg, &options()).expect("a canvas writes whole SVG");
    let (width, height) = (
        f64::from(tree.size().width()),
        f64::from(tree.size().height()),
    );
    let scale = (DOTS_PER_INCH / PX_PER_INCH).min((MOST_DOTS / (width * height)).sqrt());
    let dots = [width, height].map(|px| (px * scale).round().max(1.0) as u32);
    let mut image = tiny_skia::Pixmap::new(dots[0], dots[1])
        .expect("a canvas has a size, and dots are limited");
    image.fill(tiny_skia::Color::WHITE);
    let larger = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, larger, &mut image.as_mut());
    encoded(&image, scale * PX_PER_INCH / METRES_PER_INCH)
}

/// Letters up to here, and punctuation and signs from the second to the third, are in the font; the first without need to look.
const LATIN_TO_CYRILLIC: char = '\u{052f}';
const SIGNS: std::ops::RangeInclusive<char> = '\u{2000}'..='\u{22ff}';

/// Whether a figure has letters that the font of its PNG lacks: boxes stand there.
pub fn png_lacks_letters(svg: &str) -> bool {
    let doubtful = |own: char| own > LATIN_TO_CYRILLIC && !SIGNS.contains(&own);
    let tree = svg
        .contains(doubtful)
        .then(|| usvg::Tree::from_str(svg, &options()));
    tree.and_then(Result::ok)
        .is_some_and(|tree| lacks_letters(tree.root()))
}

fn lacks_letters(group: &usvg::Group) -> bool {
    group.children().iter().any(|node| match node {
        usvg::Node::Group(own) => lacks_letters(own),
        usvg::Node::Text(own) => {
            let mut glyphs = own.layouted().iter().flat_map(|own| &own.positioned_glyphs);
            glyphs.any(|own| own.id.0 == 0)
        }
        _ => false,
    })
}

fn options() -> usvg::Options<'static> {
    let mut options = usvg::Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_source(usvg::fontdb::Source::Binary(Arc::new(FONT)));
    fonts.set_sans_serif_family("Arimo");
    options
}

/// The colours alone: the ground is white, nothing shines through.
fn encoded(image: &tiny_skia::Pixmap, dots_per_metre: f64) -> Vec<u8> {
    let colors: Vec<u8> = image
        .data()
        .chunks_exact(4)
        .flat_map(|dot| [dot[0], dot[1], dot[2]])
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    let per_metre = dots_per_metre.round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&colors));
    written.expect("memory takes all bytes of an image of this size");
    bytes
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::canvas::{Anchor, Canvas};
    use super::*;

    /// A PNG as it is read back.
    pub struct Decoded {
        pub width: u32,
        pub height: u32,
        pub dots_per_metre: u32,
        colors: Vec<u8>,
    }

    impl Decoded {
        fn color(&self, x: u32, y: u32) -> [u8; 3] {
            let at = 3 * (y * self.width + x) as usize;
            [self.colors[at], self.colors[at + 1], self.colors[at + 2]]
        }

        /// Columns with a dot that is darker than half.
        fn inked(&self) -> Option<[u32; 2]> {
            let dark = |x: &u32| (0..self.height).any(|y| self.color(*x, y)[1] < 128);
            let mut columns = (0..self.width).filter(dark);
            let first = columns.next()?;
            Some([first, columns.next_back().unwrap_or(first)])
        }
    }

    pub fn decoded(bytes: &[u8]) -> Decoded {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut colors = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut colors).unwrap();
        let info = reader.info();
        let size = info.pixel_dims.unwrap();
        assert!(size.unit == png::Unit::Meter && size.xppu == size.yppu);
        Decoded {
            width: info.width,
            height: info.height,
            dots_per_metre: size.xppu,
            colors,
        }
    }

    fn drawn(draw: impl FnOnce(&mut Canvas)) -> Decoded {
        let mut canvas = Canvas::new(96.0, 48.0);
        draw(&mut canvas);
        decoded(&png(&canvas.finish()))
    }

    #[test]
    fn shapes_and_cuts_are_where_the_svg_has_them() {
        let image = drawn(|canvas| {
            canvas.rect([24.0, 12.0], [48.0, 36.0], ("#0072b2", "none"));
            canvas.clip([72.0, 0.0], [96.0, 24.0]);
            canvas.rect([72.0, 0.0], [96.0, 48.0], ("#d55e00", "none"));
            canvas.unclip();
        });
        assert_eq!((image.width, image.height), (300, 150));
        let (white, blue, red) = ([255; 3], [0x00, 0x72, 0xb2], [0xd5, 0x5e, 0x00]);
        for (x, y, color) in [
            (0, 0, white),
            (74, 75, white),
            (76, 39, blue),
            (148, 111, blue),
            (152, 75, white),
            (226, 1, red),
            (299, 74, red),
            (299, 76, white),
            (299, 149, white),
        ] {
            assert_eq!(image.color(x, y), color, "{x} {y}");
        }
    }

    #[test]
    fn letters_of_figures_are_in_the_font_and_as_wide_as_those_of_helvetica() {
        let width = |text: &str| {
            let text = format!("|{text}|");
            let image = drawn(|canvas| canvas.text([2.0, 24.0], &text, (Anchor::Start, "#000000")));
            let [first, last] = image.inked().unwrap();
            f64::from(last - first) / (300.0 / 96.0)
        };
        // Advances of Helvetica in thousandths of the size (Adobe Core 14 font metrics): a 556, M 833, i 222; the size is 11 px.
        let bare = width("");
        for (text, thousandths) in [("aaaa", 2224.0), ("MM", 1666.0), ("iiiiii", 1332.0)] {
            let own = width(text) - bare;
            // A dot of each end, and hundredths of a pixel by the rounding of the font's units.
            assert!((own - 0.011 * thousandths).abs() < 0.7, "{text}: {own}");
        }
        // Unknown letters are the same box; all that figures write are other than that.
        let shape = |text: &str| {
            drawn(|canvas| canvas.text([20.0, 24.0], text, (Anchor::Start, "#000000"))).colors
        };
        let unknown = shape("\u{e000}");
        for letter in "°±²³·×ζφωσ→−–…⁰¹²³⁴⁵⁶⁷⁸⁹⁻".chars() {
            assert!(shape(&letter.to_string()) != unknown, "{letter}");
        }
        assert!(shape("模") == unknown);
    }

    #[test]
    fn letters_that_the_font_lacks_are_known() {
        let lacks = |text: &str| {
            let mut canvas = Canvas::new(96.0, 48.0);
            canvas.clip([0.0, 0.0], [96.0, 48.0]);
            canvas.text([2.0, 24.0], text, (Anchor::Start, "#000000"));
            canvas.unclip();
            png_lacks_letters(&canvas.finish())
        };
        for text in ["wing, Flügel, крыло, πτερό, כנף", "1 − 2 → 10⁻³ ± …"]
        {
            assert!(!lacks(text), "{text}");
        }
        for text in ["翼", "wing 翼", "ปีก", "जुड़ा"] {
            assert!(lacks(text), "{text}");
        }
    }

    #[test]
    fn names_of_any_letters_are_drawn() {
        drawn(|canvas| {
            canvas.text(
                [2.0, 24.0],
                "a\u{0}<b>&\"'\u{1f}\n]]>\u{fffe}",
                (Anchor::Start, "#000000"),
            );
        });
    }

    #[test]
    fn large_figures_have_fewer_dots() {
        let image = decoded(&png(&Canvas::new(3000.0, 4000.0).finish()));
        assert!(image.width * image.height <= 30_100_000 && image.width > 4000);
        let inches = 3000.0 / 96.0;
        let told = f64::from(image.dots_per_metre) * 0.0254;
        assert!(
            (f64::from(image.width) / inches - told).abs() < 0.1,
            "{told}"
        );
    }
}

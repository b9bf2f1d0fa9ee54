//! The rasteriser converts SVG figures to PNG for papers. The program contains the font, so that
//! every machine draws the same figure.

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

/// Arimo: a free font with the widths of Helvetica and Arial, which the SVG asks for.
const FONT: &[u8] = include_bytes!("font/Arimo-Regular.ttf");
/// Pixels of an SVG to the inch (CSS Values and Units, absolute lengths).
const PX_PER_INCH: f64 = 96.0;
/// Resolution for print.
const DOTS_PER_INCH: f64 = 300.0;
/// Maximum dots of an image; larger figures, such as a MAC of hundreds of modes, have fewer dots to
/// the inch.
const MAX_IMAGE_DOTS: f64 = 3.0e7;
const METRES_PER_INCH: f64 = 0.0254;

/// A figure as PNG at 300 dots to the inch of its SVG's size, which the file states; with fewer
/// where that would be more than 30 million dots.
///
/// # Panics
/// For text that is no SVG of [`super::canvas::Canvas`].
pub(super) fn png(svg: &str) -> Vec<u8> {
    let tree = usvg::Tree::from_str(svg, &options()).expect("a canvas writes whole SVG");
    let (width, height) = (
        f64::from(tree.size().width()),
        f64::from(tree.size().height()),
    );
    let scale = (DOTS_PER_INCH / PX_PER_INCH).min((MAX_IMAGE_DOTS / (width * height)).sqrt());
    let dots = [width, height].map(|px| (px * scale).round().max(1.0) as u32);
    let mut image = tiny_skia::Pixmap::new(dots[0], dots[1])
        .expect("a canvas has a size, and dots are limited");
    image.fill(tiny_skia::Color::WHITE);
    let larger = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, larger, &mut image.as_mut());
    encoded(&image, scale * PX_PER_INCH / METRES_PER_INCH)
}

/// Last letter of the range that the font covers completely.
const LATIN_TO_CYRILLIC: char = '\u{052f}';
/// Punctuation and signs, which the font covers too.
const SIGNS: std::ops::RangeInclusive<char> = '\u{2000}'..='\u{22ff}';

/// Whether a figure has letters that the font of its PNG lacks: boxes stand there.
pub fn png_lacks_letters(svg: &str) -> bool {
    let may_be_missing = |letter: char| letter > LATIN_TO_CYRILLIC && !SIGNS.contains(&letter);
    let tree = svg
        .contains(may_be_missing)
        .then(|| usvg::Tree::from_str(svg, &options()));
    tree.and_then(Result::ok)
        .is_some_and(|tree| lacks_letters(tree.root()))
}

fn lacks_letters(group: &usvg::Group) -> bool {
    group.children().iter().any(|node| match node {
        usvg::Node::Group(group) => lacks_letters(group),
        usvg::Node::Text(text) => {
            let mut glyphs = text
                .layouted()
                .iter()
                .flat_map(|run| &run.positioned_glyphs);
            glyphs.any(|glyph| glyph.id.0 == 0)
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

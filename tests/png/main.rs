//! Figures as PNG, in a program that was built with them: `cargo test --release --features png
//! --test png`.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use modalign::report::{figure_files, png_lacks_letters};

/// A PNG as it is read back.
struct Decoded {
    width: u32,
    height: u32,
    dots_per_metre: u32,
    colors: Vec<u8>,
}

impl Decoded {
    fn color(&self, x: u32, y: u32) -> [u8; 3] {
        let at = 3 * (y * self.width + x) as usize;
        [self.colors[at], self.colors[at + 1], self.colors[at + 2]]
    }

    /// First and last column with a dot that is darker than half.
    fn inked(&self) -> [u32; 2] {
        let dark = |x: &u32| (0..self.height).any(|y| self.color(*x, y)[1] < 128);
        let mut columns = (0..self.width).filter(dark);
        let first = columns.next().expect("a dark dot");
        [first, columns.next_back().unwrap_or(first)]
    }
}

fn decoded(bytes: &[u8]) -> Decoded {
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

/// A figure of so many pixels with the font of all figures.
fn svg([width, height]: [u32; 2], body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
         font-size=\"11\">{body}</svg>"
    )
}

fn text(letters: &str) -> String {
    let body = format!("<text x=\"2\" y=\"24\" fill=\"#000000\">{letters}</text>");
    svg([96, 48], &body)
}

/// The PNG of a figure.
fn drawn(svg: String) -> Decoded {
    let files = figure_files(vec![("figure".to_owned(), svg)], true);
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["figure.svg", "figure.png"]);
    decoded(&files[1].1)
}

#[test]
fn shapes_and_clips_are_where_the_svg_has_them() {
    let image = drawn(svg(
        [96, 48],
        "<rect x=\"24\" y=\"12\" width=\"24\" height=\"24\" fill=\"#0072b2\"/>\
         <clipPath id=\"a\"><rect x=\"72\" y=\"0\" width=\"24\" height=\"24\"/></clipPath>\
         <g clip-path=\"url(#a)\"><rect x=\"72\" y=\"0\" width=\"24\" height=\"48\" fill=\"#d55e00\"/></g>",
    ));
    // 300 dots for 96 pixels, and 300 dots to 0.0254 m.
    assert_eq!((image.width, image.height), (300, 150));
    assert_eq!(image.dots_per_metre, 11811);
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
    let width = |letters: &str| {
        let [first, last] = drawn(text(&format!("|{letters}|"))).inked();
        f64::from(last - first) / (300.0 / 96.0)
    };
    // Advances of Helvetica in thousandths of the size (Adobe Core 14 font metrics): a 556, M 833,
    // i 222; the size is 11 px.
    let bare = width("");
    for (letters, thousandths) in [("aaaa", 2224.0), ("MM", 1666.0), ("iiiiii", 1332.0)] {
        let advance = width(letters) - bare;
        // A dot at each end, and hundredths of a pixel by the rounding of the font's units.
        let error = (advance - 0.011 * thousandths).abs();
        assert!(error < 0.7, "{letters}: {advance}");
    }
    // Letters outside the font are one box; all that figures write differ from it.
    let shape = |letter: &str| drawn(text(letter)).colors;
    let unknown = shape("\u{e000}");
    for letter in "°±²³·×ζφωσ→−–…⁰¹²³⁴⁵⁶⁷⁸⁹⁻".chars() {
        assert!(shape(&letter.to_string()) != unknown, "{letter}");
    }
    assert!(shape("模") == unknown);
}

#[test]
fn letters_that_the_font_lacks_are_found() {
    let lacks = |letters: &str| png_lacks_letters(&text(letters));
    for letters in ["wing, Flügel, крыло, πτερό, כנף", "1 − 2 → 10⁻³ ± …"] {
        assert!(!lacks(letters), "{letters}");
    }
    for letters in ["翼", "wing 翼", "ปีก", "जुड़ा"] {
        assert!(lacks(letters), "{letters}");
    }
}

#[test]
fn large_figures_have_fewer_dots() {
    let image = drawn(svg([3000, 4000], ""));
    assert!(image.width * image.height <= 30_100_000 && image.width > 4000);
    let stated = f64::from(image.dots_per_metre) * 0.0254;
    let dots_per_inch = f64::from(image.width) / (3000.0 / 96.0);
    assert!((dots_per_inch - stated).abs() < 0.1, "{stated}");
}

#[test]
fn every_figure_of_a_run_is_written_as_png_of_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = Command::new(env!("CARGO_BIN_EXE_modalign"))
        .arg("run")
        .arg(root.join("measurements/free-free-beam"))
        .arg("-o")
        .arg(folder.path())
        .arg("--png")
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{errors}");
    let of = |extension: &str| {
        let all = std::fs::read_dir(folder.path().join("figures")).unwrap();
        let paths = all.map(|entry| entry.unwrap().path());
        let of_kind = paths.filter(|path| path.extension().is_some_and(|kind| kind == extension));
        of_kind
            .map(|path| path.with_extension(""))
            .collect::<BTreeSet<_>>()
    };
    let (svgs, pngs) = (of("svg"), of("png"));
    assert!(svgs.len() >= 20 && svgs == pngs, "{svgs:?} {pngs:?}");
    for path in svgs {
        let text = std::fs::read_to_string(path.with_extension("svg")).unwrap();
        let image = decoded(&std::fs::read(path.with_extension("png")).unwrap());
        let size = |side: &str| {
            let value = text.split(&format!("{side}=\"")).nth(1).unwrap();
            let px: f64 = value.split('"').next().unwrap().parse().unwrap();
            (px * 300.0 / 96.0).round() as u32
        };
        assert_eq!(
            [image.width, image.height],
            [size(" width"), size(" height")]
        );
        assert_eq!(image.dots_per_metre, 11811, "{}", path.display());
    }
}

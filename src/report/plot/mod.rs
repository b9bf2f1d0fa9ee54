//! Figures for papers are static SVG, one file each, with axes, units and a legend, on white; and
//! the same as PNG.
//!
//! [`crate::scene::Figures`] and [`crate::study`] supply the data; this module draws them.

mod axis;
mod bars;
mod bode;
mod breakdown;
mod canvas;
mod circle;
mod mac;
mod mark;
mod order;
#[cfg(feature = "png")]
mod png;
mod shapes;
mod speed_accuracy;
mod stabilization;
mod theory;
mod update;

use std::collections::BTreeSet;

use crate::axis::Band;
use crate::printable::file_name_part;
use crate::scene::{Figures, TestFigures, energy_bars};
use crate::theory::ModelRoot;

use super::test_title::test_title;

pub use breakdown::{breakdown_svg, stability_svg};
pub use order::order_figures;
#[cfg(feature = "png")]
pub use png::png_lacks_letters;
pub use speed_accuracy::speed_accuracy_figures;
pub use theory::{details_svg, response_svg, signal_details_svg, sweeps_svg};
pub use update::update_figures_svg;

/// Every figure with its name, unique and made of letters, digits, points and hyphens.
pub fn figures_svg(figures: &Figures) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = Vec::new();
    let overview = figures.overview.as_ref();
    let errors = overview.and_then(|overview| bars::frequency_errors(overview, &figures.tests));
    all.extend(errors.map(|text| ("errors".to_owned(), text)));
    let energies = bars::energies(&figures.energies);
    all.extend(energies.map(|text| ("energies".to_owned(), text)));
    for test in &figures.tests {
        all.extend(figures_of_test(test));
    }
    number_repeated_names(&mut all);
    all
}

/// Kinetic energy of the roots of a model in a band by kind of body; `None` without a root.
pub fn energies_svg(roots: &[ModelRoot], band: Option<Band>) -> Option<String> {
    bars::energies(&energy_bars(roots, band))
}

/// The files of named figures: each `NAME.svg` as it is and, where PNG is wanted, `NAME.png`, drawn
/// from it at 300 dots to the inch in the pool of the caller. Without the feature `png` no PNG is
/// drawn.
///
/// The font of the PNG has Latin, Greek, Cyrillic and Hebrew letters; a name in others has boxes
/// there ([`png_lacks_letters`]). The words of the figures themselves are English.
pub fn figure_files(mut figures: Vec<(String, String)>, png: bool) -> Vec<(String, Vec<u8>)> {
    number_repeated_names(&mut figures);
    let drawn = if png { pngs(&figures) } else { Vec::new() };
    let svgs = figures
        .into_iter()
        .map(|(name, svg)| (format!("{name}.svg"), svg.into_bytes()));
    svgs.chain(drawn).collect()
}

#[cfg(feature = "png")]
fn pngs(figures: &[(String, String)]) -> Vec<(String, Vec<u8>)> {
    use rayon::prelude::*;

    let figures = figures.par_iter();
    let drawn = figures.map(|(name, svg)| (format!("{name}.png"), png::png(svg)));
    drawn.collect()
}

#[cfg(not(feature = "png"))]
fn pngs(_figures: &[(String, String)]) -> Vec<(String, Vec<u8>)> {
    Vec::new()
}

/// Whether a figure has letters that the font of its PNG lacks; none without the feature `png`,
/// where no PNG is drawn.
#[cfg(not(feature = "png"))]
pub fn png_lacks_letters(_svg: &str) -> bool {
    false
}

/// Appends -2, -3 and so on to repeated names: two tests may differ only in letters that file names
/// cannot have.
fn number_repeated_names(figures: &mut [(String, String)]) {
    let mut used: BTreeSet<String> = BTreeSet::new();
    for (name, _) in figures {
        let mut free = name.clone();
        let mut number = 2;
        while !used.insert(free.clone()) {
            free = format!("{name}-{number}");
            number += 1;
        }
        *name = free;
    }
}

fn figures_of_test(test: &TestFigures) -> Vec<(String, String)> {
    let stem = file_name(&test.name);
    let title = test_title(&test.name, test.synthetic);
    let mut all = Vec::new();
    if let Some(set) = &test.frfs {
        for curve in &set.curves {
            let name = format!(
                "{stem}-frf-{}-{}",
                file_name(&curve.response),
                file_name(&curve.reference)
            );
            all.push((name, bode::bode(test, set, curve)));
        }
    }
    let diagram = test.stabilization.as_ref();
    all.extend(diagram.map(|figure| {
        (
            format!("{stem}-stabilisation"),
            stabilization::stabilization(test, figure),
        )
    }));
    let matrix = test.mac.as_ref();
    all.extend(matrix.map(|figure| (format!("{stem}-mac"), mac::mac(figure, &title))));
    for circle in &test.circles {
        all.push((
            format!("{stem}-circle-{}", circle.mode),
            circle::circle_fit(circle, &title),
        ));
    }
    let set = test.shapes.as_ref();
    all.extend(set.map(|figure| (format!("{stem}-shapes"), shapes::shapes(figure, &title))));
    all
}

/// Letters, digits and points of a name, with hyphens between.
fn file_name(text: &str) -> String {
    let legal = |c: char| {
        if c.is_alphanumeric() || c == '.' {
            c
        } else {
            ' '
        }
    };
    let legal: String = text.chars().map(legal).collect();
    let words = legal.split_whitespace().collect::<Vec<_>>();
    file_name_part(&words.join("-").to_lowercase()).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Curve, FrfFigure, MacFigure, ModeMark};

    fn test_figures() -> TestFigures {
        let curve = Curve {
            response: "1:+Z".to_owned(),
            reference: "2:-Z".to_owned(),
            kind: "mobility".to_owned(),
            unit: "m/(N s)".to_owned(),
            lines: vec![1, 2, 3],
            magnitude: vec![1e-3, 1e-1, 1e-2],
            phase_deg: vec![170.0, -170.0, 10.0],
            fit_magnitude: vec![None, Some(1e-1), Some(1e-2)],
            fit_phase_deg: vec![None, Some(-171.0), Some(9.0)],
            coherence: vec![0.9, 1.0, 0.95],
        };
        TestFigures {
            name: "a <test>".to_owned(),
            synthetic: true,
            modes: vec![ModeMark {
                hz: 2.0,
                hz_std: None,
                damping_ratio: Some(0.01),
                damping_std: None,
                mpc: None,
            }],
            frfs: Some(FrfFigure {
                start_hz: 0.0,
                step_hz: 1.0,
                band_hz: [1.5, 3.5],
                functions: 2,
                whole_lines: 3,
                curves: vec![curve.clone(), curve],
            }),
            mac: Some(MacFigure {
                test_hz: vec![2.0],
                theory_hz: vec![1.9, 4.0],
                theory_modes: vec![1, 3],
                still: 1,
                mac: vec![vec![Some(0.998), None]],
                dofs: 4,
                pairs: vec![[0, 0]],
            }),
            ..TestFigures::default()
        }
    }

    #[test]
    fn every_figure_is_complete_and_has_a_unique_name() {
        let figures = Figures {
            tests: vec![test_figures()],
            ..Figures::default()
        };
        let all = figures_svg(&figures);
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["a-test-frf-1-z-2-z", "a-test-frf-1-z-2-z-2", "a-test-mac"]
        );
        for (name, text) in &all {
            assert!(
                text.starts_with("<?xml") && text.ends_with("</svg>\n"),
                "{name}"
            );
            assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
            let open = text.matches("<g").count();
            assert_eq!(open, text.matches("</g>").count(), "{name}");
            // The test is synthetic.
            assert!(text.contains("a &lt;test&gt; (synthetic)"), "{name}");
        }
        let bode = &all[0].1;
        for part in [
            "Frequency (Hz)",
            "Magnitude (m/(N s))",
            "Phase (°)",
            ">-180</text>",
            "Coherence",
        ] {
            assert!(bode.contains(part), "{part}");
        }
        for part in [
            // A MAC below 1 is not printed as 1.
            ">0.99</text>",
            ">pair</text>",
            ">no common degree of freedom</text>",
        ] {
            assert!(all[2].1.contains(part), "{part}");
        }
    }

    #[test]
    fn phase_wrap_breaks_the_phase_curve() {
        let test = test_figures();
        let set = test.frfs.as_ref().expect("the test has FRFs");
        let text = bode::bode(&test, set, &set.curves[0]);
        // Magnitude of the data is one stroke, its phase two: it wraps from 170° to -170°, and from
        // there to 10° by 180°.
        let strokes = |class: &str| {
            let path = text
                .split(&format!("<path class=\"{class}\" d=\""))
                .nth(1)
                .expect("the plot has a path of this class");
            path.split('"')
                .take(1)
                .map(|stroke| stroke.matches('M').count())
                .sum::<usize>()
        };
        assert_eq!((strokes("magnitude"), strokes("phase")), (1, 2));
    }
}

//! Figures as static SVG, for papers: one file each, with axes, units and a legend, on white.
//!
//! What is drawn comes finished from [`crate::scene::Figures`]; here it is only placed.

mod axis;
mod bars;
mod bode;
mod canvas;
mod circle;
mod mac;
mod poles;
mod shapes;

use crate::scene::{Figures, TestFigures};

/// Every figure with its name, unique and made of letters, digits, points and hyphens.
pub fn figures_svg(figures: &Figures) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = Vec::new();
    let own = figures.overview.as_ref().and_then(bars::errors);
    all.extend(own.map(|text| ("errors".to_owned(), text)));
    let own = bars::energies(&figures.energies);
    all.extend(own.map(|text| ("energies".to_owned(), text)));
    for test in &figures.tests {
        all.extend(of_test(test));
    }
    let mut named: Vec<(String, String)> = Vec::with_capacity(all.len());
    for (name, text) in all {
        let taken = |name: &str| named.iter().any(|(own, _)| own == name);
        let mut free = name.clone();
        let mut number = 2;
        while taken(&free) {
            free = format!("{name}-{number}");
            number += 1;
        }
        named.push((free, text));
    }
    named
}

fn of_test(test: &TestFigures) -> Vec<(String, String)> {
    let stem = file_name(&test.name);
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
    let own = test.stabilization.as_ref();
    all.extend(own.map(|own| {
        (
            format!("{stem}-stabilisation"),
            poles::stabilization(test, own),
        )
    }));
    let own = test.mac.as_ref();
    all.extend(own.map(|own| (format!("{stem}-mac"), mac::mac(own))));
    for own in &test.circles {
        all.push((format!("{stem}-circle-{}", own.mode), circle::circle(own)));
    }
    let own = test.shapes.as_ref();
    all.extend(own.map(|own| (format!("{stem}-shapes"), shapes::shapes(own))));
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
    legal
        .split_whitespace()
        .collect::<Vec<_>>()
        .join("-")
        .to_lowercase()
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
                mac: vec![vec![Some(0.98), None]],
                dofs: 4,
                pairs: vec![[0, 0]],
            }),
            ..TestFigures::default()
        }
    }

    #[test]
    fn every_figure_is_whole_and_has_a_name_of_its_own() {
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
        assert!(all[2].1.contains(">0.98</text>"));
    }

    #[test]
    fn a_phase_that_wraps_is_no_line_across_the_plot() {
        let test = test_figures();
        let set = test.frfs.as_ref().unwrap();
        let text = bode::bode(&test, set, &set.curves[0]);
        // Magnitude of the data is one stroke, its phase two: it wraps from 170° to -170°, and from there to 10° by 180°.
        let strokes = |class: &str| {
            let path = text
                .split(&format!("<path class=\"{class}\" d=\""))
                .nth(1)
                .unwrap();
            path.split('"').next().unwrap().matches('M').count()
        };
        assert_eq!((strokes("magnitude"), strokes("phase")), (1, 2));
    }
}

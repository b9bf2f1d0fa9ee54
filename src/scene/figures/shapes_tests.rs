//! Shapes of a test with their partners, in memory.

use num_complex::Complex64;

use super::shapes::{MacFigure, ShapeFigure, ShapeInputs, mac_figure, shape_figure};
use crate::correlate::{PairOptions, Pairing, pair};
use crate::dof::Dof;
use crate::geometry::{Node, Sensor, Target, TraceLine};
use crate::linalg::Vector3;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

use super::super::model::Theory;
use super::super::test_result::TestResult;

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

fn model(modes: &[(f64, Option<u32>, [Complex64; 4])]) -> ModalModel {
    let names = ["1:+Z", "2:+Z", "3:+Z", "4:+Z"];
    let mode = |(hz, group, values): &(f64, Option<u32>, [Complex64; 4])| {
        let shape = ModeShape::new(
            names
                .iter()
                .map(|name| dof(name))
                .zip(values.iter().copied()),
        );
        Mode {
            group: *group,
            ..Mode::new(*hz, Some(0.01), shape, Scaling::Unknown)
        }
    };
    ModalModel {
        modes: modes.iter().map(mode).collect(),
        ..ModalModel::default()
    }
}

fn real(values: [f64; 4]) -> [Complex64; 4] {
    values.map(|value| Complex64::new(value, 0.0))
}

/// A simple root whose test shape is turned by 60° and doubled, and a double root of which the test
/// found a mixture.
fn pair_of_models() -> (TestResult, Theory, Pairing) {
    let theory = model(&[
        (100.0, None, real([1.0, 2.0, 3.0, 1.0])),
        (200.0, Some(1), real([1.0, 0.0, -1.0, 0.0])),
        (200.0, Some(1), real([0.0, 1.0, 0.0, -1.0])),
    ]);
    let turned = Complex64::from_polar(2.0, std::f64::consts::FRAC_PI_3);
    let test = model(&[
        (
            99.0,
            None,
            real([1.0, 2.0, 3.0, 1.0]).map(|value| value * turned),
        ),
        (202.0, None, real([0.6, -0.8, -0.6, 0.8])),
    ]);
    let pairing = pair(&test, &theory, &PairOptions::default()).unwrap();
    let test = TestResult {
        modes: test,
        ..TestResult::default()
    };
    let theory = Theory {
        modes: theory,
        ..Theory::default()
    };
    (test, theory, pairing)
}

fn figure(edit: impl Fn(&mut TestResult)) -> (ShapeFigure, MacFigure) {
    let (mut test, theory, pairing) = pair_of_models();
    edit(&mut test);
    let shown = ShapeInputs {
        test: &test,
        theory: &theory,
        pairing: Some(&pairing),
        sensors: &[],
        motion: None,
    };
    (shape_figure(&shown).unwrap(), mac_figure(&shown).unwrap())
}

#[test]
fn partners_carry_the_factors_that_bring_them_to_the_test() {
    let (figure_data, mac) = figure(|_| ());
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a} {b}");
    let first = figure_data.partners[0].as_ref().unwrap();
    let (mode, re, im) = first.modes[0];
    assert_eq!((mode, first.modes.len()), (0, 1));
    near(re, 1.0);
    near(im, 3f64.sqrt());
    near(first.error_percent, -1.0);
    let second = figure_data.partners[1].as_ref().unwrap();
    assert_eq!(second.modes.len(), 2);
    near(second.modes[0].1, 0.6);
    near(second.modes[1].1, -0.8);
    near(second.mac.unwrap(), 1.0);
    assert_eq!(mac.pairs, [[0, 0], [1, 1], [1, 2]]);
    assert!(!figure_data.test[0].im.is_empty() && figure_data.theory[0].im.is_empty());
}

#[test]
fn without_positions_points_stand_in_a_row() {
    let (figure_data, _) = figure(|_| ());
    assert!(figure_data.in_a_row && figure_data.not_drawn == 0);
    for (n, point) in figure_data.points.iter().enumerate() {
        assert!((point.at_m[0] - n as f64).abs() < 1e-12);
    }
    assert_eq!(figure_data.lines, [[0, 1], [1, 2], [2, 3]]);
}

#[test]
fn points_that_are_all_at_one_place_stand_in_a_row() {
    let all_at = |x: [f64; 4]| {
        let (figure_data, _) = figure(|test| {
            let names = ["1", "2", "3", "4"].iter().zip(x);
            let node = |(name, x): (&&str, f64)| Node::new(*name, Vector3::new(x, 0.0, 0.0));
            test.geometry.nodes = names.map(node).collect();
        });
        figure_data.in_a_row
    };
    assert!(all_at([0.0; 4]));
    assert!(!all_at([0.0, 0.0, 0.0, 0.1]));
}

#[test]
fn files_give_positions_and_lines_with_the_points_between() {
    let (figure_data, _) = figure(|test| {
        let node = |name: &str, x: f64, y: f64| Node::new(name, Vector3::new(x, y, 0.0));
        test.geometry.nodes = vec![
            node("1", 0.0, 0.0),
            node("2", 1.0, 0.0),
            node("3", 1.0, 1.0),
            node("9", 2.0, 2.0),
        ];
        let points = ["1", "2", "9"].map(|name| Some(name.to_owned()));
        test.geometry.lines = vec![TraceLine {
            name: String::new(),
            points: points
                .into_iter()
                .chain([None, Some("3".to_owned())])
                .collect(),
        }];
    });
    assert!(!figure_data.in_a_row);
    // Point 4 has no position; point 9 is on a line alone.
    assert_eq!(
        (
            figure_data.readings.len(),
            figure_data.not_drawn,
            figure_data.points.len()
        ),
        (3, 1, 4)
    );
    assert_eq!(figure_data.lines, [[0, 1], [1, 3]]);
}

#[test]
fn a_sensor_of_the_scene_says_where_and_along_what() {
    let (test, theory, pairing) = pair_of_models();
    let sensors = [Sensor {
        dof: dof("2:+Z"),
        target: Target::BodyPoint {
            body: "disc".to_owned(),
            at_m: [0.1, 0.2, 0.3],
            direction: [0.0, 3.0, 4.0],
        },
    }];
    let shown = ShapeInputs {
        test: &test,
        theory: &theory,
        pairing: Some(&pairing),
        sensors: &sensors,
        motion: None,
    };
    let figure_data = shape_figure(&shown).unwrap();
    assert_eq!((figure_data.readings.len(), figure_data.not_drawn), (1, 3));
    let near = |got: [f64; 3], wanted: [f64; 3]| {
        let off = got.iter().zip(wanted).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{got:?} {wanted:?}");
    };
    near(figure_data.readings[0].direction, [0.0, 0.6, 0.8]);
    near(figure_data.points[0].at_m, [0.1, 0.2, 0.3]);
    assert_eq!(figure_data.points[0].body.as_deref(), Some("disc"));
}

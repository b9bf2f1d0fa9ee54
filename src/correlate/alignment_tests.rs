//! Frames fitted to points, known and found.

use num_complex::Complex64;
use proptest::prelude::*;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::alignment::{Alignment, align_known, align_nearest};
use super::alignment_shapes::mean_largest_mac;
use super::similarity::{Similarity, fit_similarity};
use super::{CorrelateError, LocatedModes, PairOptions};
use crate::dof::Dof;
use crate::geometry::{Geometry, Node};
use crate::linalg::{Matrix3, Vector3};
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

fn turn(axis: [f64; 3], angle: f64) -> Matrix3 {
    let axis = Vector3::from(axis).normalize();
    let cross = axis.cross_matrix();
    Matrix3::identity() + cross * angle.sin() + cross * cross * (1.0 - angle.cos())
}

fn moved(points: &[Vector3], fit: &Similarity) -> Vec<Vector3> {
    points.iter().map(|x| fit.position(x)).collect()
}

fn same(a: &Similarity, b: &Similarity, within: f64) -> bool {
    let shift = (a.shift_m - b.shift_m).norm();
    (a.scale / b.scale - 1.0).abs() < within
        && (a.rotation - b.rotation).norm() < within
        && shift < within * (1.0 + b.shift_m.norm())
}

/// An L-shaped bracket of unequal legs, out of plane at one end.
fn bracket() -> Vec<Vector3> {
    let at = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    let mut points: Vec<Vector3> = (0..6).map(|i| at(0.2 * f64::from(i), 0.0, 0.0)).collect();
    points.extend((1..4).map(|i| at(0.0, 0.15 * f64::from(i), 0.0)));
    points.push(at(0.0, 0.45, 0.1));
    points
}

proptest! {
    #[test]
    fn known_partners_give_the_frame_back(
        numbers in proptest::collection::vec(-1.0..1.0f64, 15),
        axis in (-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64),
        angle in -3.0..3.0f64,
        scale in 1e-3..1e3f64,
    ) {
        let points: Vec<Vector3> = numbers.chunks(3).map(|c| Vector3::new(c[0], c[1], c[2])).collect();
        let truth = Similarity {
            scale,
            rotation: turn([axis.0, axis.1, axis.2], angle),
            shift_m: Vector3::new(3.0, -2.0, 0.5),
        };
        let pairs: Vec<_> = points.iter().copied().zip(moved(&points, &truth)).collect();
        let fit = fit_similarity(&pairs).unwrap();
        // Points that are nearly in one plane leave rounding its room.
        prop_assert!(same(&fit, &truth, 1e-6), "{fit:?} {truth:?}");
        prop_assert!((fit.rotation.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_mirrored_set_is_not_taken_for_a_turned_one() {
    let points = bracket();
    let pairs: Vec<_> = points
        .iter()
        .map(|p| (*p, Vector3::new(p.x, p.y, -p.z)))
        .collect();
    let fit = fit_similarity(&pairs).unwrap();
    assert!((fit.rotation.determinant() - 1.0).abs() < 1e-12);
    let error = align_known(&pairs, 0.01).unwrap_err();
    assert!(
        matches!(error, CorrelateError::NotAligned { .. }),
        "{error}"
    );
}

#[test]
fn the_best_scale_of_a_mirrored_set_is_that_of_the_closed_form() {
    // Covariance diag(9, 4, -1)/3, spread 14/3: s = (9 + 4 - 1)/14.
    let ends = [Vector3::x() * 3.0, Vector3::y() * 2.0, Vector3::z()];
    let points = ends.iter().flat_map(|p| [*p, -p]);
    let pairs: Vec<_> = points.map(|p| (p, Vector3::new(p.x, p.y, -p.z))).collect();
    let fit = fit_similarity(&pairs).unwrap();
    assert!((fit.scale - 12.0 / 14.0).abs() < 1e-12, "{fit:?}");
}

#[test]
fn points_in_millimetres_turned_and_shifted_find_their_partners() {
    let theory = bracket();
    let truth = Similarity {
        scale: 1e-3,
        rotation: turn([1.0, 2.0, -1.0], 2.2),
        shift_m: Vector3::new(0.3, 0.1, -0.7),
    };
    // The test's points by the inverse of the truth, 1 mm off in turn, in another order.
    let back = |(i, y): (usize, &Vector3)| {
        let off = Vector3::new(1.0, -1.0, 1.0) * (1e-3 * if i % 2 == 0 { 1.0 } else { -1.0 });
        truth.rotation.transpose() * (y + off - truth.shift_m) / truth.scale
    };
    let mut test: Vec<Vector3> = theory.iter().enumerate().map(back).collect();
    test.reverse();
    let alignment = align_nearest(&test, &theory, 0.005).unwrap();
    assert!(
        same(&alignment.similarity(), &truth, 0.02),
        "{alignment:?} {truth:?}"
    );
    assert!(
        alignment.largest_m < 0.003 && alignment.rms_m > 0.0005,
        "{alignment:?}"
    );
    assert_eq!(
        (alignment.points, alignment.known, alignment.as_good),
        (10, false, 0)
    );
    let error = align_nearest(&test, &theory, 1e-4).unwrap_err();
    assert!(
        matches!(error, CorrelateError::NotAligned { .. }),
        "{error}"
    );
}

#[test]
fn points_at_one_place_count_once() {
    let theory = bracket();
    // Two nodes for the two directions of one place, the second as a unit conversion rounds it.
    let mut test = theory.clone();
    test.push(theory[3] + Vector3::x() * 1e-15);
    let alignment = align_nearest(&test, &theory, 1e-6).unwrap();
    assert_eq!((alignment.points, alignment.as_good), (10, 0));
    assert!(alignment.largest_m < 1e-12, "{alignment:?}");
    let same = vec![Vector3::x(); 5];
    let error = align_nearest(&same, &theory, 1e-6).unwrap_err();
    let (got, expected) = (1, 3);
    assert_eq!(error, CorrelateError::FewPoints { got, expected });
}

#[test]
fn points_that_share_partners_from_every_start_are_an_error() {
    // Four points in two pairs close together, a theory of four far apart: at no scale do the pairs
    // part.
    let at = |x: f64, y: f64| Vector3::new(x, y, 0.0);
    let test = [at(0.0, 0.0), at(0.01, 0.0), at(0.0, 1.0), at(0.01, 1.0)];
    let theory = [at(0.0, 0.0), at(3.0, 0.0), at(0.0, 3.5), at(40.0, 0.0)];
    let error = align_nearest(&test, &theory, 0.1).unwrap_err();
    let (points, partners) = (4, 4);
    assert_eq!(
        error,
        CorrelateError::NoDistinctPartners { points, partners }
    );
}

/// A plate of 24 by 16 points with a rib of 10 along one edge, 394 points.
fn plate() -> Vec<Vector3> {
    let at = |i: i32, j: i32, z: f64| Vector3::new(0.05 * f64::from(i), 0.04 * f64::from(j), z);
    let flat = (0..24).flat_map(|i| (0..16).map(move |j| at(i, j, 0.0)));
    flat.chain((0..10).map(|i| at(i, 0, 0.06))).collect()
}

#[test]
fn more_points_than_a_sample_are_all_fitted_for_any_number_of_threads() {
    let theory = plate();
    let truth = Similarity {
        scale: 1e-3,
        rotation: turn([0.3, -1.0, 0.4], 1.7),
        shift_m: Vector3::new(-0.2, 0.6, 0.1),
    };
    let back = |y: &Vector3| truth.rotation.transpose() * (y - truth.shift_m) / truth.scale;
    let test: Vec<Vector3> = theory.iter().rev().map(back).collect();
    let in_pool = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| align_nearest(&test, &theory, 0.01).unwrap())
    };
    let alignment = in_pool(1);
    assert!(
        same(&alignment.similarity(), &truth, 1e-9),
        "{alignment:?} {truth:?}"
    );
    assert_eq!((alignment.points, alignment.as_good), (394, 0));
    assert!(alignment.largest_m < 1e-12, "{alignment:?}");
    assert_eq!(in_pool(3), alignment);
}

#[test]
fn a_rectangle_fits_in_four_ways_and_turns_least() {
    let corner = |x: f64, y: f64| Vector3::new(x, y, 0.0);
    let theory: Vec<Vector3> = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
        .map(|(x, y)| corner(x, y))
        .to_vec();
    let alignment = align_nearest(&theory, &theory, 0.01).unwrap();
    assert!(
        same(&alignment.similarity(), &Similarity::identity(), 1e-9),
        "{alignment:?}"
    );
    assert_eq!(alignment.as_good, 3);
}

#[test]
fn points_on_a_line_turn_least() {
    let line = |i: i32, axis: Vector3| axis * (0.1 * f64::from(i * i));
    let test: Vec<Vector3> = (0..5).map(|i| line(i, Vector3::x())).collect();
    let theory: Vec<Vector3> = (0..5).map(|i| line(i, Vector3::y())).collect();
    let pairs: Vec<_> = test.iter().copied().zip(theory).collect();
    let fit = fit_similarity(&pairs).unwrap();
    assert!((fit.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!((fit.rotation * Vector3::z() - Vector3::z()).norm() < 1e-9);
    let against: Vec<_> = test.iter().map(|x| (*x, -x)).collect();
    let fit = fit_similarity(&against).unwrap();
    assert!((fit.rotation * Vector3::x() + Vector3::x()).norm() < 1e-9);
    assert!((fit.rotation.determinant() - 1.0).abs() < 1e-9);
}

/// A beam of 2 m along x with sensors 3 mm off its axis in turn, in both directions across.
fn beam(off_m: f64) -> Vec<Vector3> {
    let point = |i: i32| {
        let (turn, x) = (f64::from(i) * 2.4, 0.2 * f64::from(i));
        Vector3::new(x, off_m * turn.cos(), off_m * turn.sin())
    };
    (0..11).map(point).collect()
}

#[test]
fn partners_on_a_line_within_the_tolerance_tell_no_turn_about_it() {
    let theory = beam(0.003);
    // The test's points were written down within 1 mm of the axis, turned about it by 110 degrees.
    let round = turn([1.0, 0.0, 0.0], 1.92);
    let test: Vec<Vector3> = beam(1e-3).iter().map(|x| round * x).collect();
    let pairs: Vec<_> = test.iter().copied().zip(theory).collect();
    let free = fit_similarity(&pairs).unwrap();
    assert!(free.angle() > 1.5, "{free:?}");
    let loose = align_known(&pairs, 0.01).unwrap();
    assert_eq!(loose.as_good, 1);
    assert!(loose.similarity().angle() < 0.01, "{loose:?}");
    assert!(loose.largest_m < 0.01);
    // To a tenth of a millimetre they tell it.
    let exact: Vec<_> = beam(0.003).into_iter().map(|x| (x, round * x)).collect();
    let alignment = align_known(&exact, 1e-4).unwrap();
    assert_eq!(alignment.as_good, 0);
    assert!((alignment.similarity().rotation - round).norm() < 1e-9);
}

#[test]
fn a_turn_about_a_line_that_no_longer_fits_is_not_taken() {
    // Off the line by less than the tolerance, but turned the other way by more.
    let round = turn([1.0, 0.0, 0.0], 3.0);
    let pairs: Vec<_> = beam(0.003).into_iter().map(|x| (x, round * x)).collect();
    let alignment = align_known(&pairs, 0.004).unwrap();
    assert_eq!(alignment.as_good, 1);
    assert!((alignment.similarity().rotation - round).norm() < 1e-9);
}

#[test]
fn too_few_points_are_refused() {
    let two = [(Vector3::x(), Vector3::x()), (Vector3::y(), Vector3::y())];
    let error = align_known(&two, 1.0).unwrap_err();
    assert_eq!(
        error,
        CorrelateError::FewPoints {
            got: 2,
            expected: 3
        }
    );
    assert!(align_nearest(&bracket(), &bracket()[..4], 1.0).is_err());
}

/// A structure of which some nodes carry sensors, in another frame and unit.
struct Drawn {
    theory: Vec<Vector3>,
    test: Vec<Vector3>,
    /// The node of each sensor.
    nodes: Vec<usize>,
    /// From the test's unit to metres.
    scale: f64,
    /// Largest error of a position, m.
    error_m: f64,
    tolerance_m: f64,
}

/// Structures with their nodes, most of them symmetric: a rectangular plate, a square one, a ring
/// and a tower.
const KINDS: [&str; 4] = ["plate", "square plate", "ring", "tower"];

fn structure(kind: usize, random: &mut ChaCha8Rng) -> (Vec<Vector3>, f64) {
    let grid = |columns: u32, rows: u32, pitch: f64| {
        let at = move |i: u32, j: u32| Vector3::new(f64::from(i), f64::from(j), 0.0) * pitch;
        (0..columns).flat_map(move |i| (0..rows).map(move |j| at(i, j)))
    };
    match kind {
        0 => (
            grid(random.random_range(8..20), random.random_range(5..8), 0.05).collect(),
            0.05,
        ),
        1 => {
            let side = random.random_range(6..14);
            (grid(side, side, 0.08).collect(), 0.08)
        }
        2 => {
            let count = random.random_range(12..48);
            let at = |i: u32| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            let node = |i: u32| Vector3::new(at(i).cos(), at(i).sin(), 0.0) * 0.4;
            let pitch = 0.8 * (std::f64::consts::PI / f64::from(count)).sin();
            ((0..count).map(node).collect(), pitch)
        }
        _ => {
            let storeys = random.random_range(4..12);
            let corner = |i: u32, (x, y): (f64, f64)| Vector3::new(x, y, 3.0 * f64::from(i));
            let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
            let storey = move |i: u32| corners.map(|at| corner(i, at));
            ((0..storeys).flat_map(storey).collect(), 3.0)
        }
    }
}

fn draw(kind: usize, seed: u64) -> Drawn {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (theory, pitch) = structure(kind, &mut random);
    let mut nodes: Vec<usize> = (0..theory.len()).collect();
    nodes.shuffle(&mut random);
    nodes.truncate(random.random_range(6..theory.len().clamp(7, 60)));
    let error_m = pitch * [0.0, 0.01, 0.04][random.random_range(0..3)];
    let scale = [1.0, 1e-3, 1e3][random.random_range(0..3)];
    let mut number = || random.random_range(-1.0..1.0);
    let axis = [number(), number(), number()];
    let truth = Similarity {
        scale,
        rotation: turn(axis, std::f64::consts::PI * number()),
        shift_m: Vector3::new(number(), number(), number()),
    };
    let mut sensor = |node: &usize| {
        let off = Vector3::new(number(), number(), number()) * (error_m / 3f64.sqrt());
        truth.rotation.transpose() * (theory[*node] + off - truth.shift_m) / truth.scale
    };
    let test = nodes.iter().map(&mut sensor).collect();
    Drawn {
        theory,
        test,
        nodes,
        scale,
        error_m,
        tolerance_m: 0.15 * pitch,
    }
}

impl Drawn {
    /// Why an alignment is wrong: it is none, its scale is no unit's, a sensor is farther from a
    /// node than its position is known, or the frame of the truth is not among those that fit.
    fn fault(&self) -> Option<String> {
        let found = match align_nearest(&self.test, &self.theory, self.tolerance_m) {
            Ok(found) => found,
            Err(error) => return Some(error.to_string()),
        };
        if (found.scale / self.scale - 1.0).abs() > 0.02 {
            return Some(format!("scale {} for {}", found.scale, self.scale));
        }
        if found.largest_m > 2.0 * self.error_m + 1e-9 {
            return Some(format!("{} m off", found.largest_m));
        }
        let is_truth = |fit: &Alignment| {
            let mut both = self.test.iter().zip(&self.nodes);
            let near = |at: Vector3, node: usize| (at - self.theory[node]).norm();
            both.all(|(x, node)| {
                near(fit.similarity().position(x), *node) <= 2.0 * self.error_m + 1e-9
            })
        };
        let mut all = std::iter::once(&found).chain(&found.others);
        let listed = all.any(is_truth) || found.as_good > found.others.len();
        (!listed).then(|| format!("truth is none of {} frames", found.as_good + 1))
    }
}

#[test]
fn sensors_on_nodes_in_another_frame_and_unit_find_an_exact_fit() {
    for (kind, name) in KINDS.iter().enumerate() {
        let faults: Vec<(u64, String)> = (0..60)
            .filter_map(|seed| Some((seed, draw(kind, seed).fault()?)))
            .collect();
        assert!(faults.is_empty(), "{name}: {faults:?}");
    }
}

/// Modes of a plate of 6 by 4 points that move across it, and their positions.
fn plate_modes(points: &[Vector3], shapes: [fn(f64, f64) -> f64; 2]) -> ModalModel {
    let mode = |(hz, shape): (f64, fn(f64, f64) -> f64)| {
        let value = |(i, p): (usize, &Vector3)| {
            let dof: Dof = format!("{}:+Z", i + 1).parse().unwrap();
            (dof, Complex64::from(shape(p.x, p.y)))
        };
        let shape = ModeShape::new(points.iter().enumerate().map(value));
        Mode::new(hz, None, shape, Scaling::Unknown)
    };
    ModalModel {
        modes: [100.0, 210.0].into_iter().zip(shapes).map(mode).collect(),
        ..ModalModel::default()
    }
}

/// The alignment of a plate half a turn about x, selected by these shapes.
fn plate_selected_by(shapes: [fn(f64, f64) -> f64; 2]) -> Alignment {
    let at = |i: i32, j: i32| Vector3::new(0.1 * f64::from(i), 0.13 * f64::from(j), 0.0);
    let theory: Vec<Vector3> = (0..6).flat_map(|i| (0..4).map(move |j| at(i, j))).collect();
    let half_turn = turn([1.0, 0.0, 0.0], std::f64::consts::PI);
    let test: Vec<Vector3> = theory.iter().map(|p| half_turn.transpose() * p).collect();
    let geometry = |points: &[Vector3]| Geometry {
        nodes: (1..)
            .zip(points)
            .map(|(n, p): (usize, _)| Node::new(n.to_string(), *p))
            .collect(),
        ..Geometry::default()
    };
    // Both have the motion across the plate at the same points, with the opposite sign.
    let modes = plate_modes(&theory, shapes);
    let nodes = [geometry(&test), geometry(&theory)];
    let [test_modes, theory_modes] = nodes.each_ref().map(|geometry| LocatedModes {
        modes: &modes,
        geometry,
    });
    let options = PairOptions::default();
    let fitted = align_nearest(&test, &theory, 0.005).unwrap();
    fitted.selected_by_shapes(|frame| {
        mean_largest_mac(&test_modes, &theory_modes, frame, 0.005, &options)
    })
}

#[test]
fn shapes_select_among_frames_that_fit_equally_well() {
    let selected = plate_selected_by([|x, y| 1.0 + 3.0 * x - 9.0 * y * x, |x, y| x - 4.0 * y * y]);
    assert_eq!((selected.as_good, selected.as_good_by_shape()), (3, 0));
    assert!(selected.mean_mac.unwrap() > 0.999, "{selected:?}");
    let half_turn = turn([1.0, 0.0, 0.0], std::f64::consts::PI);
    assert!((selected.similarity().rotation - half_turn).norm() < 1e-9);
    let next = selected.others[0].mean_mac.unwrap();
    assert!(next < 0.95, "{next}");
    // Shapes with the symmetry of the plate select none; the smallest rotation is taken.
    let symmetric = plate_selected_by([
        |x, y| (x - 0.25) * (y - 0.195),
        |x, y| (x - 0.25).powi(2) - (y - 0.195).powi(2),
    ]);
    assert_eq!((symmetric.as_good, symmetric.as_good_by_shape()), (3, 3));
    assert!(symmetric.similarity().angle() < 1e-9, "{symmetric:?}");
}

#[test]
fn points_that_only_a_reflection_fits_are_an_error_that_says_so() {
    let mut theory = bracket();
    theory.push(Vector3::new(0.3, 0.1, -0.25));
    let test: Vec<Vector3> = theory
        .iter()
        .map(|p| Vector3::new(-p.x, p.y, p.z))
        .collect();
    let error = align_nearest(&test, &theory, 0.005).unwrap_err();
    assert_eq!(error, CorrelateError::Mirrored { tolerance_m: 0.005 });
}

#[test]
fn scale_that_is_no_ratio_of_units_is_found_and_marked() {
    let theory = bracket();
    let test: Vec<Vector3> = theory.iter().map(|p| p / 0.786).collect();
    let alignment = align_nearest(&test, &theory, 0.005).unwrap();
    assert!((alignment.scale - 0.786).abs() < 1e-9, "{alignment:?}");
    assert!(!alignment.has_unit_scale());
    let inches: Vec<Vector3> = theory.iter().map(|p| p / 0.0254).collect();
    assert!(
        align_nearest(&inches, &theory, 0.005)
            .unwrap()
            .has_unit_scale()
    );
}

//! Frames fitted to points, known and found.

use proptest::prelude::*;

use super::CorrelateError;
use super::alignment::{Similarity, align_known, align_nearest, fit_similarity};
use crate::linalg::{Matrix3, Vector3};

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

//! Tests of the rank-one terms of a residue matrix: sum, pivots and scale.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::identify::modes::rank_one_terms::{RankOneTerm, decompose_residues};
use crate::identify::modes::shape::{Residues, shape_of};
use crate::identify::synthetic::Structure;
use crate::modal::Pole;

fn dof(text: &str) -> Dof {
    text.parse().expect("a point and its direction")
}

fn damped_rad_s() -> f64 {
    Pole::from_frequency(80.0, 0.01).lambda.im
}

/// Residues of a repeated pole with these shapes for all pairs of responses and references.
fn residues(shapes: &[&[f64]], responses: &[&str], references: &[&str]) -> Residues {
    let modes = shapes.iter().map(|shape| (80.0, 0.01, shape.to_vec()));
    let structure = Structure {
        modes: modes.collect(),
    };
    let pairs = responses
        .iter()
        .flat_map(|r| references.iter().map(|k| (dof(r), dof(k))));
    let residue = |pair: (Dof, Dof)| {
        let sum = (0..shapes.len()).map(|j| structure.residue(j, &pair)).sum();
        (pair, sum)
    };
    pairs.map(residue).collect()
}

fn assert_sum(terms: &[RankOneTerm], all: &Residues) {
    let largest = all.values().map(|a| a.norm()).fold(0.0, f64::max);
    for (pair, residue) in all {
        let sum: Complex64 = terms.iter().map(|term| term.residues[pair]).sum();
        assert!((sum - residue).norm() < 1e-13 * largest, "{pair:?}");
    }
}

/// `2iω_d A` of a term: the product of its shape components.
fn product(term: &RankOneTerm, response: &str, reference: &str) -> Complex64 {
    let residue = term.residues[&(dof(response), dof(reference))];
    Complex64::new(0.0, 2.0 * damped_rad_s()) * residue
}

#[test]
fn first_mode_is_the_motion_at_the_first_pivot_where_the_second_is_at_rest() {
    let (a, b) = ([0.6, 0.1, -0.4, 0.2], [-0.2, 0.8, 0.3, 0.5]);
    let points = ["1:+Z", "2:+Z", "3:+Z", "4:+Z"];
    let all = residues(&[&a, &b], &points, &points);
    let terms =
        decompose_residues(&all, 2, damped_rad_s()).expect("every pair is there and finite");
    assert_sum(&terms, &all);
    assert!(terms.iter().all(|term| term.reciprocal));
    // Driving points: 0.40, 0.65, 0.25, 0.29; the first is more than 0.3 of the largest, so that
    // the first vector is (Φ φ_1ᵀ)/|φ_1| with the row φ_1 = (0.6, -0.2), the second its orthogonal
    // complement.
    for p in 0..4 {
        let norm = 0.4f64.sqrt();
        let first = (0.6 * a[p] - 0.2 * b[p]) / norm;
        let second = (0.2 * a[p] + 0.6 * b[p]) / norm;
        let found = |term: usize| product(&terms[term], points[p], points[p]);
        assert!((found(0) - first * first).norm() < 1e-13, "{p}");
        assert!((found(1) - second * second).norm() < 1e-13, "{p}");
    }
}

#[test]
fn pivots_of_equal_size_follow_the_order_of_dofs_whatever_the_round_off() {
    // Both driving points move equally; which is larger is a matter of the last digits.
    for lift in [1.0 - 1e-9, 1.0, 1.0 + 1e-9] {
        let points = ["1:+Z", "2:+Z", "3:+Z"];
        let all = residues(&[&[1.0, 0.0, 0.5], &[0.0, lift, 0.5]], &points, &points);
        let terms =
            decompose_residues(&all, 2, damped_rad_s()).expect("every pair is there and finite");
        assert!((product(&terms[0], "1:+Z", "1:+Z") - 1.0).norm() < 1e-12);
        assert!(product(&terms[1], "1:+Z", "1:+Z").norm() < 1e-12);
    }
}

#[test]
fn sensors_opposite_to_the_hits_are_driving_points() {
    let shapes: [&[f64]; 2] = [&[0.6, 0.1, -0.4], &[-0.2, 0.8, 0.3]];
    let all = residues(
        &shapes,
        &["1:-Z", "2:+Z", "3:-Z"],
        &["1:+Z", "2:+Z", "3:+Z"],
    );
    let terms =
        decompose_residues(&all, 2, damped_rad_s()).expect("every pair is there and finite");
    assert_sum(&terms, &all);
    assert!(terms.iter().all(|term| term.reciprocal));
    assert!((product(&terms[0], "1:-Z", "1:+Z") + 0.4).norm() < 1e-13);
}

#[test]
fn modes_at_rest_at_all_driving_points_have_no_modal_mass_and_still_sum_to_the_residues() {
    let shapes: [&[f64]; 2] = [&[1.0, 0.2, 0.4, 0.3, -0.5], &[0.0, 0.9, -0.4, 0.5, 0.3]];
    let all = residues(
        &shapes,
        &["1:+Z", "2:+Z", "3:+Z"],
        &["1:+Z", "4:+Z", "5:+Z"],
    );
    let one = decompose_residues(&all, 2, damped_rad_s()).expect("every pair is there and finite");
    assert_sum(&one, &all);
    // The only driving point, 1, does not move in the second shape.
    assert!(one[0].reciprocal && !one[1].reciprocal);
    let none = residues(&shapes, &["2:+Z", "3:+Z"], &["1:+Z", "4:+Z", "5:+Z"]);
    let terms =
        decompose_residues(&none, 2, damped_rad_s()).expect("every pair is there and finite");
    assert_sum(&terms, &none);
    assert!(terms.iter().all(|term| !term.reciprocal));
}

#[test]
fn driving_point_without_the_phase_of_a_real_mode_gives_no_modal_mass() {
    let points = ["1:+Z", "2:+Z", "3:+Z"];
    let all = residues(&[&[0.6, 0.1, -0.4], &[-0.2, 0.8, 0.3]], &points, &points);
    for (degrees, reciprocal) in [(19.0, true), (-19.0, true), (21.0, false), (180.0, false)] {
        let rotated = all
            .iter()
            .map(|(pair, a)| (pair.clone(), a * Complex64::cis(f64::to_radians(degrees))));
        let rotated: Residues = rotated.collect();
        let terms = decompose_residues(&rotated, 2, damped_rad_s())
            .expect("every pair is there and finite");
        assert_sum(&terms, &rotated);
        assert!(
            terms.iter().all(|term| term.reciprocal == reciprocal),
            "{degrees}"
        );
    }
}

#[test]
fn mode_at_rest_at_the_first_excitation_point_has_a_shape() {
    let points = ["1:+Z", "2:+Z", "3:+Z"];
    let all = residues(&[&[1.0, 0.0, 0.5], &[0.0, 1.0, 0.5]], &points, &points);
    for term in decompose_residues(&all, 2, damped_rad_s()).expect("every pair is there and finite")
    {
        let scaled = shape_of(&term.residues, damped_rad_s());
        assert_eq!(scaled.shape.len(), 3);
        assert_eq!(scaled.modal_mass_kg, Some(1.0));
    }
}

#[test]
fn terms_beyond_the_rank_are_left_out() {
    let points = ["1:+Z", "2:+Z"];
    // Orthogonal shapes of norms √2 and 0.1√2: the terms of the first alone are the nearest
    // rank-one matrix.
    let all = residues(&[&[1.0, 1.0], &[0.1, -0.1]], &points, &points);
    let first = residues(&[&[1.0, 1.0]], &points, &points);
    assert_sum(
        &decompose_residues(&all, 1, damped_rad_s()).expect("every pair is there and finite"),
        &first,
    );
}

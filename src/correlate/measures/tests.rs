//! Measures of shapes against closed forms and numbers computed by hand.

use num_complex::Complex64;
use proptest::prelude::*;

use super::super::{PairOptions, pair};
use super::models::{complex_model, model};
use super::*;

fn paired(test: &ModalModel, theory: &ModalModel) -> Measures {
    let options = PairOptions {
        min_mac: 0.1,
        ..PairOptions::default()
    };
    let pairing = pair(test, theory, &options).unwrap();
    measures(test, theory, &pairing, &options).unwrap()
}

fn near(got: Option<f64>, expected: f64) {
    let got = got.unwrap();
    assert!(
        (got - expected).abs() < 1e-12,
        "{got} instead of {expected}"
    );
}

#[test]
fn every_mode_meets_every_mode_with_both_frequencies() {
    let test = model(&[(11.0, &[1.0, 1.0, 0.0]), (20.0, &[0.0, 1.0, 1.0])]);
    let theory = model(&[(0.0, &[1.0, 1.0, 1.0]), (10.0, &[1.0, 0.0, 0.0])]);
    let measures = paired(&test, &theory);
    near(measures.mac.mac[0][0], 2.0 / 3.0);
    near(measures.mac.mac[0][1], 0.5);
    near(measures.mac.mac[1][1], 0.0);
    assert_eq!(measures.mac.dofs, DofRange { fewest: 3, most: 3 });
    assert_eq!(measures.frequency_mac.len(), 4);
    near(measures.theory_auto_mac.mac[0][1], 1.0 / 3.0);
    let point = measures.frequency_mac[1];
    assert_eq!((point.test.mode, point.theory.mode), (1, 2));
    near(point.error_percent, 10.0);
    assert_eq!(measures.frequency_mac[0].error_percent, None);
}

#[test]
fn a_degree_of_freedom_that_one_mode_misses_is_not_counted_for_it() {
    let mut test = model(&[(10.0, &[1.0, 1.0, 5.0]), (20.0, &[1.0, -1.0, 2.0])]);
    let theory = model(&[(10.0, &[1.0, 1.0, 0.0]), (20.0, &[1.0, -1.0, 2.0])]);
    let kept = test.modes[0].shape.iter().take(2);
    let kept: Vec<_> = kept.map(|(dof, v)| (dof.clone(), v)).collect();
    test.modes[0].shape = crate::modal::ModeShape::new(kept);
    let measures = paired(&test, &theory);
    near(measures.mac.mac[0][0], 1.0);
    assert_eq!(measures.mac.dofs, DofRange { fewest: 2, most: 3 });
    let pairs: Vec<usize> = measures.coordinates.iter().map(|c| c.pairs).collect();
    assert_eq!(pairs, [2, 2, 1]);
    assert_eq!(measures.coordinates[2].comac, None);
}

#[test]
fn the_scale_factor_leads_from_theory_to_test() {
    let s = Complex64::from_polar(2.0, 30f64.to_radians());
    let shape: Vec<Complex64> = [1.0, -2.0, 0.5].map(Complex64::from).to_vec();
    let test = complex_model(&[(10.0, shape.iter().map(|v| v * s).collect())]);
    let measures = paired(&test, &complex_model(&[(10.0, shape)]));
    let factor = measures.scale_factors[0];
    near(Some(factor.magnitude), 2.0);
    near(Some(factor.phase_deg), 30.0);
    assert_eq!(factor.dofs, 3);
}

#[test]
fn coordinate_mac_of_two_pairs_is_that_computed_by_hand() {
    // Unit shapes: test (0.6, 0.8) and (0.8, -0.6), theory (1, 1)/√2 and (1, -1)/√2.
    let test = model(&[(10.0, &[3.0, 4.0]), (20.0, &[4.0, -3.0])]);
    let theory = model(&[(10.0, &[1.0, 1.0]), (20.0, &[2.0, -2.0])]);
    let coordinates = paired(&test, &theory).coordinates;
    let h = 0.5f64.sqrt();
    // Both columns: Σ|φψ| = 1.4 h, Σφ² = 1, Σψ² = 1.
    for coordinate in &coordinates {
        near(coordinate.comac, 0.98);
        near(coordinate.direction, 1.4 * h);
        near(
            coordinate.enhanced,
            ((0.6 - h).abs() + (0.8 - h).abs()) / 4.0,
        );
        assert_eq!(coordinate.pairs, 2);
    }
}

#[test]
fn a_reversed_sensor_is_seen_by_the_measures_that_see_signs() {
    let theory = model(&[
        (10.0, &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0]),
        (20.0, &[-2.0, -1.0, 0.5, 0.5, 1.0, 2.0]),
        (30.0, &[1.0, -1.0, -1.0, -1.0, -1.0, 1.0]),
    ]);
    let mut test = theory.clone();
    for mode in &mut test.modes {
        let turned = (1..).zip(mode.shape.iter());
        let turned = turned.map(|(n, (dof, v))| (dof.clone(), if n == 3 { -v } else { v }));
        mode.shape = crate::modal::ModeShape::new(turned.collect::<Vec<_>>());
    }
    let coordinates = paired(&test, &theory).coordinates;
    near(coordinates[2].comac, 1.0);
    near(coordinates[2].direction, -1.0);
    near(coordinates[0].direction, 1.0);
    assert!(coordinates[2].enhanced.unwrap() > 5.0 * coordinates[0].enhanced.unwrap());
}

#[test]
fn one_pair_says_nothing_of_a_degree_of_freedom() {
    let one = model(&[(10.0, &[1.0, 2.0])]);
    let coordinate = &paired(&one, &one).coordinates[0];
    assert_eq!(
        (coordinate.comac, coordinate.enhanced, coordinate.pairs),
        (None, None, 1)
    );
}

#[test]
fn close_modes_in_any_mixture_are_one_subspace() {
    let (sin, cos) = 35f64.to_radians().sin_cos();
    let theory = model(&[
        (100.0, &[1.0, 0.0, 0.0, 0.0]),
        (101.0, &[0.0, 1.0, 0.0, 0.0]),
        (150.0, &[0.0, 0.0, 1.0, 0.0]),
    ]);
    let test = model(&[
        (100.0, &[cos, sin, 0.0, 0.0]),
        (101.0, &[-sin, cos, 0.0, 0.0]),
        (150.0, &[0.0, 0.0, 1.0, 0.0]),
    ]);
    let measures = paired(&test, &theory);
    assert_eq!(measures.clusters.len(), 1);
    let cluster = &measures.clusters[0];
    let numbers: Vec<usize> = cluster.test.iter().map(|name| name.mode).collect();
    assert_eq!((numbers, cluster.dofs), (vec![1, 2], 4));
    // An angle of rounding has a sine of about 1e-8.
    assert!((cluster.space_mac.unwrap() - 1.0).abs() < 1e-7);
    near(cluster.mean_mac, 1.0);
    near(measures.mac.mac[0][0], cos * cos);
}

#[test]
fn a_subspace_that_leans_by_an_angle_has_its_criterion() {
    let angle = 25f64.to_radians();
    let theory = model(&[
        (100.0, &[1.0, 0.0, 0.0, 0.0]),
        (101.0, &[0.0, 1.0, 0.0, 0.0]),
    ]);
    let test = model(&[
        (100.0, &[1.0, 0.0, 0.0, 0.0]),
        (101.0, &[0.0, angle.cos(), angle.sin(), 0.0]),
    ]);
    let cluster = &paired(&test, &theory).clusters[0];
    assert!((cluster.space_mac.unwrap() - (1.0 - angle.sin())).abs() < 1e-7);
    near(cluster.mean_mac, (1.0 + angle.cos().powi(2)) / 2.0);
    near(cluster.random_mac, 0.5);
    // Two planes in three dimensions share a line whatever they are.
    let flat = model(&[(100.0, &[1.0, 0.1, 0.0]), (101.0, &[0.1, 1.0, 0.0])]);
    let cluster = &paired(&flat, &flat).clusters[0];
    assert_eq!((cluster.dofs, cluster.space_mac), (3, None));
    assert_eq!((cluster.mean_mac, cluster.random_mac), (None, None));
}

#[test]
fn a_chain_of_close_modes_ends_where_it_grows_wide() {
    let unit = |n: usize| (0..20).map(|i| if i == n { 1.0 } else { 0.0 }).collect();
    // Ten modes, each 1.5 % above the one before: 14 % from end to end.
    let shapes: Vec<Vec<f64>> = (0..10).map(unit).collect();
    let modes: Vec<(f64, &[f64])> = (0..)
        .zip(&shapes)
        .map(|(n, shape)| (100.0 * 1.015f64.powi(n), shape.as_slice()))
        .collect();
    let mut set = model(&modes);
    let sizes = |test: &ModalModel, set: &ModalModel| -> Vec<usize> {
        let clusters = paired(test, set).clusters;
        clusters
            .iter()
            .map(|cluster| cluster.theory.len())
            .collect()
    };
    // 1.015^3 is within 5 %, 1.015^4 is not.
    assert_eq!(sizes(&set, &set), [4, 4, 2]);
    // A repeated root stays whole: 105.2 Hz is within 5 % of 100 Hz, 105.3 Hz is not.
    for (n, hz) in [(2, 103.5), (3, 105.2), (4, 105.3)] {
        set.modes[n].frequency_hz = hz;
    }
    assert_eq!(sizes(&set, &set)[0], 4);
    set.modes[3].group = Some(1);
    set.modes[4].group = Some(1);
    let mut test = set.clone();
    test.modes[3].frequency_hz = 107.0;
    test.modes[4].frequency_hz = 107.1;
    assert_eq!(sizes(&test, &set)[0], 5);
}

#[test]
fn over_all_planes_of_coordinates_the_mean_is_that_at_random() {
    let unit = |n: usize| -> Vec<f64> { (0..5).map(|i| f64::from(u8::from(i == n))).collect() };
    let plane = |a: usize, b: usize| model(&[(100.0, &unit(a)), (101.0, &unit(b))]);
    let options = PairOptions {
        min_mac: 0.0,
        ..PairOptions::default()
    };
    let (theory, mut means) = (plane(0, 1), Vec::new());
    for (a, b) in (0..5).flat_map(|a| (a + 1..5).map(move |b| (a, b))) {
        let test = plane(a, b);
        let pairing = pair(&test, &theory, &options).unwrap();
        let found = measures(&test, &theory, &pairing, &options).unwrap();
        near(found.clusters[0].random_mac, 2.0 / 5.0);
        means.push(found.clusters[0].mean_mac.unwrap());
    }
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    near(Some(mean), 2.0 / 5.0);
}

#[test]
fn modes_of_one_shape_near_in_frequency_are_duplicates() {
    let mut set = model(&[
        (100.0, &[1.0, 2.0, 3.0]),
        (102.0, &[1.0, 2.0, 3.1]),
        (130.0, &[1.0, 2.0, 3.0]),
        (131.0, &[1.0, -2.0, 3.0]),
    ]);
    let limits = DuplicateLimits::default();
    let options = PairOptions::default();
    let narrow = auto_mac(&set, limits, &options).unwrap();
    let found = narrow.duplicates.iter();
    let found: Vec<_> = found.map(|d| (d.first.mode, d.second.mode)).collect();
    assert_eq!(found, [(1, 2)]);
    let mac = (1.0 + 4.0 + 9.3f64).powi(2) / (14.0 * (5.0 + 9.61));
    near(Some(narrow.duplicates[0].mac), mac);
    near(narrow.matrix.mac[2][2], 1.0);
    assert_eq!(narrow.findings()[0].value, Some(narrow.duplicates[0].mac));
    let wide = DuplicateLimits {
        max_frequency_difference: 0.3,
        ..limits
    };
    let broad = auto_mac(&set, wide, &options).unwrap();
    let found = broad.duplicates.iter();
    let found: Vec<_> = found.map(|d| (d.first.mode, d.second.mode)).collect();
    assert_eq!((found.len(), found[0]), (3, (1, 3)));
    // The modes of a repeated root are no duplicates, whatever their basis.
    set.modes[0].group = Some(1);
    set.modes[1].group = Some(1);
    let result = auto_mac(&set, limits, &options).unwrap();
    assert!(result.duplicates.is_empty());
}

/// Six modes of five degrees of freedom from a list of numbers.
fn drawn(numbers: &[(f64, f64)]) -> ModalModel {
    let modes = numbers.chunks(5).zip(1..).map(|(chunk, n)| {
        let shape = chunk.iter().map(|(re, im)| Complex64::new(*re, *im));
        (10.0 * f64::from(n), shape.collect())
    });
    complex_model(&modes.collect::<Vec<_>>())
}

proptest! {
    #[test]
    fn measures_stay_in_their_range_and_do_not_see_scale_and_phase(
        a in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 20),
        b in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 20),
        scales in proptest::collection::vec((0.1..10.0f64, -3.0..3.0f64), 4),
    ) {
        let (test, theory) = (drawn(&a), drawn(&b));
        let options = PairOptions { min_mac: 0.0, ..PairOptions::default() };
        let of = |test: &ModalModel| {
            let pairing = pair(test, &theory, &options).unwrap();
            measures(test, &theory, &pairing, &options).unwrap()
        };
        let one_set = of(&test);
        let mut turned = test.clone();
        for (mode, (size, angle)) in turned.modes.iter_mut().zip(&scales) {
            mode.shape = mode.shape.scaled(Complex64::from_polar(*size, *angle));
        }
        let other = of(&turned);
        for (one, two) in one_set.coordinates.iter().zip(&other.coordinates) {
            let values = [(one.comac, two.comac), (one.enhanced, two.enhanced)];
            for (one, two) in values.into_iter().filter_map(|(a, b)| Some((a?, b?))) {
                prop_assert!((0.0..=1.0).contains(&one));
                prop_assert!((one - two).abs() < 1e-9);
            }
            prop_assert!(one.direction.is_none_or(|d| d * d <= one.comac.unwrap() + 1e-12));
        }
        for (row, other) in one_set.mac.mac.iter().zip(&other.mac.mac) {
            for (one, two) in row.iter().zip(other) {
                prop_assert!((one.unwrap() - two.unwrap()).abs() < 1e-12);
            }
        }
        let auto = auto_mac(&test, DuplicateLimits::default(), &options).unwrap();
        for i in 0..4 {
            prop_assert!((auto.matrix.mac[i][i].unwrap() - 1.0).abs() < 1e-12);
            for j in 0..4 {
                let (one, two) = (auto.matrix.mac[i][j], auto.matrix.mac[j][i]);
                prop_assert!((one.unwrap() - two.unwrap()).abs() < 1e-12);
            }
        }
    }
}

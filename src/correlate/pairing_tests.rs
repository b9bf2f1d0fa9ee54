//! Pairing: missed and swapped modes, gates, ambiguity, repeated roots, signs, missing shapes.

use std::f64::consts::FRAC_1_SQRT_2;

use num_complex::Complex64;
use proptest::prelude::*;

use crate::dof::{Axis, Dof};
use crate::finding::Code;
use crate::modal::{ModalModel, Mode, ModeShape, Scaling};

use super::*;

/// A mode with a real shape at points 1, 2, ... along +Z; an empty list is a mode without a shape.
pub(super) fn mode(frequency_hz: f64, shape: &[f64]) -> Mode {
    let dof = |number: usize| Dof::new(&number.to_string(), Axis::Z, false).unwrap();
    let values = (1..).zip(shape).map(|(number, &v)| (dof(number), v.into()));
    Mode::new(frequency_hz, None, ModeShape::new(values), Scaling::Unknown)
}

pub(super) fn model(modes: Vec<Mode>) -> ModalModel {
    ModalModel {
        modes,
        ..ModalModel::default()
    }
}

/// Five shapes of six points at right angles to one another (columns of a cosine transform).
pub(super) fn shape(number: usize) -> Vec<f64> {
    let point = |p: usize| ((p as f64 + 0.5) * number as f64 * std::f64::consts::PI / 6.0).cos();
    (0..6).map(point).collect()
}

/// (theory mode, test mode) of every pair, from 1.
fn numbers(pairing: &Pairing) -> Vec<(usize, usize)> {
    let of_pair = |pair: &Pair| {
        let theory = pair.theory[0] + 1;
        let partners = pair.partners.iter().map(move |p| (theory, p.test + 1));
        partners.collect::<Vec<_>>()
    };
    pairing.pairs.iter().flat_map(of_pair).collect()
}

pub(super) fn paired(test: &ModalModel, theory: &ModalModel) -> Pairing {
    pair(test, theory, &PairOptions::default()).unwrap()
}

fn codes(pairing: &Pairing) -> Vec<Code> {
    pairing
        .findings
        .iter()
        .map(|finding| finding.code)
        .collect()
}

#[test]
fn the_mac_matrix_is_that_computed_by_hand() {
    let theory = model(vec![
        mode(10.0, &[1.0, 1.0, 0.0]),
        mode(20.0, &[1.0, -1.0, 2.0]),
    ]);
    let mut complex = mode(10.0, &[]);
    let dof = |text: &str| text.parse::<Dof>().unwrap();
    complex.shape = ModeShape::new([
        (dof("1:+Z"), Complex64::new(1.0, 1.0)),
        (dof("2:-Z"), Complex64::new(0.0, -2.0)),
        (dof("7:+Z"), Complex64::new(9.0, 0.0)),
    ]);
    let pairing = paired(&model(vec![complex]), &theory);
    // On points 1 and 2 the test is (1 + i, 2i): |1 + 3i|^2 / (2 * 6) and |1 - i|^2 / (2 * 6).
    let mac: Vec<f64> = pairing.mac[0].iter().map(|v| v.unwrap()).collect();
    assert!((mac[0] - 10.0 / 12.0).abs() < 1e-15 && (mac[1] - 2.0 / 12.0).abs() < 1e-15);
    assert_eq!(codes(&pairing), [Code::DofWithoutPartner, Code::FewDofs]);
}

#[test]
fn a_missed_mode_shifts_no_other_row_with_and_without_shapes() {
    for with_shapes in [true, false] {
        let of = |number: usize, hz: f64| match with_shapes {
            true => mode(hz, &shape(number)),
            false => mode(hz, &[]),
        };
        let theory = [100.0, 118.0, 130.0, 150.0].iter().zip(1..);
        let theory = model(theory.map(|(&hz, number)| of(number, hz)).collect());
        let test = model(vec![of(1, 103.0), of(3, 133.0), of(4, 153.0)]);
        let pairing = paired(&test, &theory);
        assert_eq!(numbers(&pairing), [(1, 1), (3, 2), (4, 3)]);
        assert_eq!(pairing.unpaired_theory[0].theory, [1]);
        assert!(pairing.unpaired_test.is_empty());
        assert_eq!(pairing.pairs[0].partners[0].mac.is_some(), with_shapes);
    }
}

#[test]
fn a_missed_mode_and_an_extra_one_do_not_shift_the_rows_between() {
    // Pairing every test mode with the theory mode below it would also be inside the frequency
    // gate.
    let theory = model(vec![
        mode(100.0, &shape(1)),
        mode(110.0, &shape(2)),
        mode(121.0, &shape(3)),
    ]);
    let test = model(vec![
        mode(110.5, &shape(2)),
        mode(121.5, &shape(3)),
        mode(133.0, &shape(4)),
    ]);
    let pairing = paired(&test, &theory);
    assert_eq!(numbers(&pairing), [(2, 1), (3, 2)]);
    assert_eq!(
        (
            pairing.unpaired_theory[0].theory[0],
            pairing.unpaired_test[0]
        ),
        (0, 2)
    );
}

#[test]
fn shapes_undo_a_swapped_order() {
    let theory = model(vec![mode(100.0, &shape(1)), mode(104.0, &shape(2))]);
    let test = model(vec![mode(101.0, &shape(2)), mode(103.0, &shape(1))]);
    let pairing = paired(&test, &theory);
    assert_eq!(numbers(&pairing), [(1, 2), (2, 1)]);
    assert!((pairing.pairs[0].partners[0].frequency_error - 0.03).abs() < 1e-14);
    // What the deviation allowed to a shape leaves to the other mode and to none is 2e-5.
    let cost = pairing.pairs[0].partners[0].cost;
    assert!((cost - 0.1 * 0.03 / 0.2).abs() < 1e-4, "{cost}");
}

#[test]
fn the_decision_is_for_the_whole_and_not_greedy() {
    // Test 1 is nearest to theory 2, but theory 2 is all that test 2 can have.
    let theory = model(vec![mode(100.0, &[]), mode(110.0, &[])]);
    let test = model(vec![mode(106.0, &[]), mode(124.0, &[])]);
    assert_eq!(numbers(&paired(&test, &theory)), [(1, 1), (2, 2)]);
}

#[test]
fn rows_move_only_when_that_is_cheaper_than_a_missed_and_an_extra_mode() {
    let theory = model(vec![mode(100.0, &[]), mode(110.0, &[])]);
    let against = |low, high| {
        numbers(&paired(
            &model(vec![mode(low, &[]), mode(high, &[])]),
            &theory,
        ))
    };
    // Moved: 0.5 + 0.545 against an exact pair and 1.
    assert_eq!(against(110.0, 122.0), [(2, 1)]);
    // Moved: 0.4 + 0.364 against 0.09 and 1.
    assert_eq!(against(108.0, 118.0), [(1, 1), (2, 2)]);
}

#[test]
fn gates_forbid_by_the_theory_whatever_the_error_is_a_part_of() {
    let theory = model(vec![mode(100.0, &shape(1))]);
    let test = |hz| model(vec![mode(hz, &shape(1))]);
    let of = |reference, hz| {
        let options = PairOptions {
            error_reference: reference,
            ..PairOptions::default()
        };
        pair(&test(hz), &theory, &options).unwrap().pairs
    };
    for reference in [ErrorReference::Theory, ErrorReference::Test] {
        assert_eq!([80.1, 119.9].map(|hz| of(reference, hz).len()), [1, 1]);
        assert_eq!([79.9, 120.1].map(|hz| of(reference, hz).len()), [0, 0]);
    }
    let partner = |reference| of(reference, 119.9)[0].partners[0].clone();
    let (one, other) = (
        partner(ErrorReference::Theory),
        partner(ErrorReference::Test),
    );
    assert!((one.frequency_error - 0.199).abs() < 1e-14, "{one:?}");
    assert!(
        (other.frequency_error + 19.9 / 119.9).abs() < 1e-14,
        "{other:?}"
    );
    assert_eq!(one.cost.to_bits(), other.cost.to_bits());
}

#[test]
fn a_low_mac_at_the_right_frequency_is_a_finding_and_no_pair() {
    let theory = model(vec![mode(100.0, &[1.0, 1.0, 1.0, 1.0])]);
    let test = model(vec![mode(101.0, &[1.0, 1.0, 1.0, -1.0])]);
    let pairing = paired(&test, &theory);
    assert!(pairing.pairs.is_empty());
    let finding = &pairing.findings[0];
    assert_eq!(
        (finding.code, finding.value, finding.limit),
        (Code::LowMac, Some(0.25), Some(0.5))
    );
    assert_eq!(
        pairing.unpaired_theory[0].near_miss,
        Some(NearMiss { test: 0, mac: 0.25 })
    );
}

#[test]
fn two_partners_as_good_are_ambiguous_from_either_side() {
    let twins = vec![mode(100.0, &shape(1)), mode(100.5, &shape(1))];
    let one = vec![mode(100.2, &shape(1))];
    let from_test = paired(&model(one.clone()), &model(twins.clone()));
    let verdict = &from_test.pairs[0].partners[0].verdict;
    assert!(
        matches!(verdict, PairVerdict::Ambiguous { competitor: Competitor::Theory(modes), .. } if modes == &[1])
    );
    let from_theory = paired(&model(twins), &model(one));
    let verdict = &from_theory.pairs[0].partners[0].verdict;
    assert!(
        matches!(verdict, PairVerdict::Ambiguous { competitor: Competitor::Test(1), cost_difference } if *cost_difference > 0.0)
    );
    assert!(codes(&from_test).contains(&Code::Ambiguous));
}

#[test]
fn the_margin_decides_which_pairs_are_ambiguous() {
    let theory = model(vec![mode(100.0, &[]), mode(104.0, &[])]);
    let test = model(vec![mode(100.0, &[])]);
    // The competitor lies 4 % off, which costs 4/104 / 0.2 = 0.192.
    for (margin, expected) in [(0.19, false), (0.195, true)] {
        let options = PairOptions {
            ambiguous_margin: margin,
            ..PairOptions::default()
        };
        let verdict = &pair(&test, &theory, &options).unwrap().pairs[0].partners[0].verdict;
        assert_eq!(
            matches!(verdict, PairVerdict::Ambiguous { .. }),
            expected,
            "{margin}"
        );
    }
}

pub(super) fn repeated() -> ModalModel {
    let mut modes = vec![
        mode(90.0, &shape(3)),
        mode(100.0, &shape(1)),
        mode(100.0, &shape(2)),
    ];
    modes[1].group = Some(1);
    modes[2].group = Some(1);
    model(modes)
}

pub(super) fn blend(a: f64, b: f64) -> Vec<f64> {
    shape(1)
        .iter()
        .zip(shape(2))
        .map(|(x, y)| a * x + b * y)
        .collect()
}

#[test]
fn a_turned_basis_of_a_repeated_root_pairs_with_both() {
    let turned = [
        blend(FRAC_1_SQRT_2, FRAC_1_SQRT_2),
        blend(FRAC_1_SQRT_2, -FRAC_1_SQRT_2),
    ];
    let test = model(vec![
        mode(99.0, &turned[0]),
        mode(101.0, &turned[1]),
        mode(102.0, &turned[1]),
    ]);
    let pairing = paired(&test, &repeated());
    let root = &pairing.pairs[0];
    assert_eq!(
        (root.theory.as_slice(), root.partners.len()),
        (&[1, 2][..], 2)
    );
    assert_eq!((root.partners[0].test, root.partners[1].test), (0, 1));
    for partner in &root.partners {
        assert!(partner.mac.unwrap() > 1.0 - 1e-12);
        assert!((pairing.mac[partner.test][1].unwrap() - 0.5).abs() < 1e-12);
    }
    assert!(
        root.angles_deg
            .as_ref()
            .unwrap()
            .iter()
            .all(|angle| *angle < 1e-5)
    );
    assert_eq!(pairing.unpaired_test, [2], "no more than its multiplicity");
    assert_eq!(pairing.unpaired_theory[0].theory, [0]);
}

#[test]
fn a_vector_half_outside_the_subspace_has_half_a_mac() {
    let outside: Vec<f64> = blend(0.6, 0.8)
        .iter()
        .zip(shape(3))
        .map(|(a, b)| a + b)
        .collect();
    let options = PairOptions {
        min_mac: 0.4,
        ..PairOptions::default()
    };
    let pairing = pair(&model(vec![mode(100.0, &outside)]), &repeated(), &options).unwrap();
    let root = pairing
        .pairs
        .iter()
        .find(|pair| pair.theory.len() == 2)
        .unwrap();
    assert!((root.partners[0].mac.unwrap() - 0.5).abs() < 1e-12);
    assert!((root.angles_deg.as_ref().unwrap()[0] - 45.0).abs() < 1e-9);
}

#[test]
fn reversed_sensors_change_nothing() {
    let theory = model(vec![mode(100.0, &shape(1)), mode(120.0, &shape(2))]);
    let mut test = model(vec![mode(101.0, &shape(1)), mode(121.0, &shape(2))]);
    for mode in &mut test.modes {
        let reversed = |dof: &Dof| Dof::new(dof.point(), dof.axis(), true).unwrap();
        let odd = |dof: &Dof| dof.node().is_some_and(|number| number % 2 == 1);
        let turn = |(dof, value): (&Dof, Complex64)| {
            if odd(dof) {
                (reversed(dof), -value)
            } else {
                (dof.clone(), value)
            }
        };
        mode.shape = ModeShape::new(mode.shape.iter().map(turn).collect::<Vec<_>>());
    }
    let pairing = paired(&test, &theory);
    assert_eq!(numbers(&pairing), [(1, 1), (2, 2)]);
    assert!(
        pairing
            .pairs
            .iter()
            .all(|pair| pair.partners[0].mac.unwrap() > 1.0 - 1e-12)
    );
    assert_eq!(pairing.map.len(), 6);
}

#[test]
fn modes_at_zero_and_modes_that_sensors_cannot_see_do_not_pair() {
    let theory = model(vec![mode(0.0, &shape(0)), mode(100.0, &[0.0; 6])]);
    let test = model(vec![mode(0.0, &shape(0)), mode(100.0, &shape(1))]);
    let pairing = paired(&test, &theory);
    assert!(pairing.pairs.is_empty());
    assert_eq!(
        (pairing.rigid_theory, pairing.unpaired_test.as_slice()),
        (1, &[1][..])
    );
    assert_eq!(pairing.mac[1][1], None);
}

#[test]
fn one_common_degree_of_freedom_pairs_by_frequency_alone() {
    let theory = model(vec![mode(100.0, &shape(1)), mode(200.0, &[0.0; 6])]);
    let test = model([101.0, 199.0].map(|hz| mode(hz, &[-3.0])).to_vec());
    let pairing = paired(&test, &theory);
    assert_eq!(numbers(&pairing), [(1, 1), (2, 2)]);
    let partners = pairing.pairs.iter().flat_map(|pair| &pair.partners);
    assert!(partners.into_iter().all(|partner| partner.mac.is_none()));
    assert_eq!(pairing.mac, vec![vec![None; 2]; 2]);
    assert_eq!(codes(&pairing), [Code::FewDofs]);
}

#[test]
fn two_common_degrees_of_freedom_pair_by_frequency_and_a_repeated_root_at_one_has_no_angles() {
    // By MAC each would be the other's.
    let theory = model(vec![mode(100.0, &[1.0, -1.0]), mode(101.0, &[1.0, 1.0])]);
    let test = model(vec![mode(100.0, &[1.0, 1.0]), mode(101.0, &[1.0, -1.0])]);
    let pairing = paired(&test, &theory);
    assert_eq!(numbers(&pairing), [(1, 1), (2, 2)]);
    for pair in &pairing.pairs {
        assert_eq!(pair.partners[0].basis, Basis::Frequency);
        assert!(pair.partners[0].mac.unwrap() < 1e-12);
    }
    let one = model(vec![mode(100.0, &[1.0]), mode(100.5, &[2.0])]);
    let pairing = paired(&one, &repeated());
    let root = pairing
        .pairs
        .iter()
        .find(|pair| pair.theory.len() == 2)
        .unwrap();
    assert_eq!((root.partners.len(), &root.angles_deg), (2, &None));
}

#[test]
fn non_finite_frequencies_and_shapes_are_errors() {
    let good = model(vec![mode(1.0, &[1.0])]);
    for hz in [-1.0, f64::NAN] {
        let error = pair(
            &good,
            &model(vec![mode(hz, &[1.0])]),
            &PairOptions::default(),
        );
        assert!(matches!(
            error,
            Err(CorrelateError::Frequency {
                model: "theory",
                number: 1,
                ..
            })
        ));
    }
    let error = pair(
        &model(vec![mode(1.0, &[f64::NAN])]),
        &good,
        &PairOptions::default(),
    );
    assert_eq!(
        error,
        Err(CorrelateError::ShapeValue {
            model: "test",
            number: 1
        })
    );
}

proptest! {
    #[test]
    fn pairing_does_not_depend_on_the_scale_of_any_shape(
        blends in proptest::collection::vec((-1.0..1.0f64, 0.9..1.1f64), 4),
        scales in proptest::collection::vec((1e-6..1e6f64, -3.0..3.0f64), 4),
    ) {
        let theory = model((1..5).map(|n| mode(100.0 + 10.0 * n as f64, &shape(n))).collect());
        let blended = |(n, (part, shift)): (usize, &(f64, f64))| {
            let other = shape(n % 4 + 1);
            let values: Vec<f64> = shape(n).iter().zip(other).map(|(a, b)| a + part * b).collect();
            mode((100.0 + 10.0 * n as f64) * shift, &values)
        };
        let test = model((1..).zip(&blends).map(blended).collect());
        let mut scaled = test.clone();
        for (mode, (size, angle)) in scaled.modes.iter_mut().zip(&scales) {
            mode.shape = mode.shape.scaled(Complex64::from_polar(*size, *angle));
        }
        let (a, b) = (paired(&test, &theory), paired(&scaled, &theory));
        prop_assert_eq!(numbers(&a), numbers(&b));
        for (x, y) in a.mac.iter().flatten().zip(b.mac.iter().flatten()) {
            prop_assert!((x.unwrap() - y.unwrap()).abs() < 1e-12);
        }
    }
}

#[test]
fn rounding_errors_at_nodes_are_no_shape() {
    // At 1010 Hz a five-fold root that the sensors do not see but for rounding, which spans nearly
    // every shape.
    let tiny = |number: usize| {
        shape(number)
            .into_iter()
            .map(|v| 1e-15 * v)
            .collect::<Vec<_>>()
    };
    let mut modes = vec![mode(1000.0, &shape(1))];
    modes.extend((1..=5).map(|number| mode(1010.0, &tiny(number))));
    modes[1..].iter_mut().for_each(|mode| mode.group = Some(1));
    let found = paired(&model(vec![mode(1002.0, &shape(1))]), &model(modes));
    assert_eq!(numbers(&found), [(1, 1)]);
    assert_eq!(found.pairs[0].partners[0].verdict, PairVerdict::Paired);
}

#[test]
fn modes_of_a_model_that_moves_at_no_sensor_have_no_partner_by_frequency() {
    let shapes: Vec<Vec<f64>> = (1..=4).map(shape).collect();
    let numbered = || [100.0, 200.0, 300.0, 400.0].into_iter().zip(&shapes);
    let test = model(numbered().map(|(hz, shape)| mode(hz, shape)).collect());
    let still = model(numbered().map(|(hz, _)| mode(hz, &[0.0; 6])).collect());
    let pairing = paired(&test, &still);
    assert_eq!(pairing.pairs, []);
    assert!(pairing.map.is_still_in_theory());
    // Without any shape of the model frequencies are all that there is.
    let bare = model(numbered().map(|(hz, _)| mode(hz, &[])).collect());
    assert_eq!(paired(&test, &bare).pairs.len(), 4);
}

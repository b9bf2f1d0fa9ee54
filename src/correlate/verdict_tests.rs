//! Verdicts of pairing that rest on shares, and MAC of whole sets of modes.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::finding::{Code, Finding, Location};
use crate::modal::ModalModel;

use super::pairing_tests::{blend, mode, model, paired, repeated, shape};
use super::shapes::Shapes;
use super::*;

#[test]
fn the_mac_of_whole_sets_equals_that_of_each_pair() {
    let theory = model((0..5).map(|n| mode(10.0 + n as f64, &shape(n))).collect());
    let sum = |n: usize| -> Vec<f64> {
        let both = shape(n).into_iter().zip(shape(n + 1));
        both.map(|(x, y)| 0.9 * x - 0.3 * y).collect()
    };
    let mut test = model((0..4).map(|n| mode(10.0 + n as f64, &sum(n))).collect());
    test.modes[2] = mode(12.0, &[0.0; 6]);
    let of = |test: &ModalModel| {
        let map = DofMap::of_models(test, &theory);
        let shapes =
            Shapes::new(test, &theory, &map, &PairOptions::default()).expect("finite shapes");
        let single = |i: usize, j: usize| shapes.mac(i, &[j]);
        for (i, row) in shapes.mac_matrix().iter().enumerate() {
            for (j, mac) in row.iter().enumerate() {
                let apart = mac.zip(single(i, j)).map(|(a, b)| (a - b).abs());
                assert_eq!(mac.is_some(), single(i, j).is_some(), "{i} {j}");
                assert!(apart.is_none_or(|apart| apart < 1e-14), "{i} {j}");
            }
        }
        shapes.mac_matrix()
    };
    assert_eq!(of(&test)[2], [None; 5]);
    assert!(
        (of(&test)[0][1].expect("shapes that move") - 0.045 / 0.855).abs() < 1e-12,
        "{:?}",
        of(&test)
    );
    // One that misses a value is compared at the others.
    test.modes[0] = mode(10.0, &sum(0)[..5]);
    of(&test);
}

/// The verdict of the first mode against two roots of which it is a sum of these parts.
fn verdict_of(parts: [f64; 2], hz: [f64; 2], shapes: [Vec<f64>; 2]) -> (PairVerdict, Vec<Finding>) {
    let points = shapes[0].iter().zip(&shapes[1]);
    let sum: Vec<f64> = points.map(|(x, y)| parts[0] * x + parts[1] * y).collect();
    let theory = model(vec![mode(hz[0], &shapes[0]), mode(hz[1], &shapes[1])]);
    let found = paired(&model(vec![mode(hz[0], &sum)]), &theory);
    (found.pairs[0].partners[0].verdict.clone(), found.findings)
}

/// Shapes of 24 points at right angles to one another.
fn wave(number: usize) -> Vec<f64> {
    let point = |p: usize| ((p as f64 + 0.5) * number as f64 * std::f64::consts::PI / 24.0).cos();
    (0..24).map(point).collect()
}

#[test]
fn half_of_a_shape_within_its_deviation_is_mixed() {
    // Of 24 points a share of 0.52 is known to 0.03, so that it may be less than half; one of 0.64
    // may not.
    let of = |share: f64, shapes| {
        let parts = [share.sqrt(), (1.0 - share).sqrt()];
        verdict_of(parts, [100.0, 104.0], shapes)
    };
    let points = || [wave(1), wave(2)];
    assert_eq!(of(0.64, points()).0, PairVerdict::Paired);
    let (verdict, findings) = of(0.52, points());
    assert!(
        matches!(verdict, PairVerdict::MixedShape { contribution, std } if (contribution - 0.52).abs() < 0.01 && (std - 0.03).abs() < 0.005),
        "{verdict:?}"
    );
    // The value compared with the limit.
    let disagreement = findings
        .iter()
        .find(|finding| finding.code == Code::MixedShape);
    let disagreement = disagreement.expect("a finding");
    assert!(
        (disagreement.value.expect("a finding with a value") - 0.49).abs() < 0.01,
        "{disagreement}"
    );
    assert!(disagreement.value < disagreement.limit, "{disagreement}");
}

#[test]
fn mac_below_the_chance_level_is_ambiguous_with_mac_level_and_dofs() {
    // Six points and two roots in reach: independent shapes reach 0.789 with the nearest.
    let (verdict, findings) = verdict_of([0.8, 0.6], [100.0, 104.0], [shape(1), shape(2)]);
    assert!(
        matches!(&verdict, PairVerdict::Uncorrelated { mac, level, .. }
            if (mac - 0.64).abs() < 1e-12 && (level.mac - 0.789).abs() < 1e-3 && (level.dofs, level.roots, level.rank) == (6, 2, 1)),
        "{verdict:?}"
    );
    let found_finding = findings
        .iter()
        .find(|finding| finding.code == Code::BelowChanceLevel);
    let found_finding = found_finding.expect("a finding");
    assert!(
        (found_finding.value.expect("a finding with a value") - 0.64).abs() < 1e-12
            && found_finding.value < found_finding.limit,
        "{found_finding}"
    );
}

#[test]
fn sensors_that_hardly_move_raise_the_chance_level() {
    // Twelve of 24 sensors move a thousandth of the others.
    let weighted = |number: usize, small: f64| -> Vec<f64> {
        let weight = |p: usize| if p < 12 { 1.0 } else { small };
        let points = wave(number).into_iter().enumerate();
        points.map(|(p, value)| weight(p) * value).collect()
    };
    let level = |small: f64| {
        let modes = (1..7).map(|n| mode(100.0 * f64::from(1 << n), &weighted(n, small)));
        let modes = model(modes.collect());
        let pairing = paired(&modes, &modes);
        let level = pairing.pairs[2].partners[0].chance_level;
        level.expect("24 degrees of freedom")
    };
    let (all, half) = (level(1.0), level(1e-3));
    assert_eq!((all.dofs, half.dofs), (24, 24));
    assert!(all.effective_dofs > 22.0, "{all:?}");
    assert!((half.effective_dofs - 12.0).abs() < 1.5, "{half:?}");
    // Of twice the degrees of freedom a level is about half.
    assert!(half.mac > 1.7 * all.mac, "{half:?} {all:?}");
}

#[test]
fn two_degrees_of_freedom_pair_by_frequency_alone_and_three_by_shape() {
    for (points, basis) in [
        (1, Basis::Frequency),
        (2, Basis::Frequency),
        (3, Basis::Shape),
    ] {
        let values = shape(1)[..points].to_vec();
        let found = paired(
            &model(vec![mode(101.0, &values)]),
            &model(vec![mode(100.0, &values)]),
        );
        let partner = &found.pairs[0].partners[0];
        assert_eq!(
            (partner.basis, &partner.verdict),
            (basis, &PairVerdict::Paired),
            "{points}"
        );
        assert_eq!(partner.chance_level.is_some(), basis == Basis::Shape);
    }
}

#[test]
fn two_far_roots_of_one_shape_both_claim_a_mode() {
    // 15 % apart neither mixes into the other, so that each holds all of the shape; their costs
    // differ by more than the margin.
    let (verdict, findings) = verdict_of([1.0, 0.0], [100.0, 115.0], [shape(1), shape(1)]);
    assert!(
        findings
            .iter()
            .any(|finding| finding.code == Code::ClaimedTwice)
    );
    assert!(
        findings
            .iter()
            .all(|finding| finding.code != Code::Ambiguous)
    );
    assert!(
        matches!(&verdict, PairVerdict::ContestedShape { competitor: Competitor::Theory(modes), contribution } if modes == &[1] && *contribution > 0.8),
        "{verdict:?}"
    );
    let theory = model(vec![mode(100.0, &shape(1))]);
    let found = paired(
        &model(vec![mode(101.0, &shape(1)), mode(114.0, &shape(1))]),
        &theory,
    );
    let verdict = &found.pairs[0].partners[0].verdict;
    assert!(
        matches!(
            verdict,
            PairVerdict::ContestedShape {
                competitor: Competitor::Test(1),
                ..
            }
        ),
        "{verdict:?}"
    );
}

/// The pair of a repeated root with two partners.
fn of_both(pairing: &Pairing) -> &Pair {
    let mut pairs = pairing.pairs.iter();
    let both = pairs.find(|pair| (pair.theory.len(), pair.partners.len()) == (2, 2));
    both.expect("both test modes are in the subspace of the root")
}

#[test]
fn one_mode_twice_is_not_both_modes_of_a_repeated_root() {
    let turned = blend(FRAC_1_SQRT_2, FRAC_1_SQRT_2);
    let nearly: Vec<f64> = turned
        .iter()
        .zip(shape(5))
        .map(|(a, b)| a + 0.02 * b)
        .collect();
    for second in [turned.clone(), nearly] {
        let test = model(vec![mode(99.0, &turned), mode(101.0, &second)]);
        let pairing = paired(&test, &repeated());
        assert!(of_both(&pairing).weakest_direction.expect("alike") < 0.3);
        let found_finding = pairing.findings.iter();
        let found_finding: Vec<_> = found_finding
            .filter(|finding| finding.code == Code::AlikePartners)
            .map(|finding| (finding.location.clone(), finding.limit))
            .collect();
        assert_eq!(found_finding, [(Location::Mode(101.0), Some(0.25))]);
    }
    // 60 degrees apart are two directions as well as 90 are.
    let other = blend(-0.258_819, 0.965_926);
    let test = model(vec![mode(99.0, &turned), mode(101.0, &other)]);
    let pairing = paired(&test, &repeated());
    assert!(of_both(&pairing).weakest_direction.is_none());
    // Sensors that see one direction of the root alone tell nothing of the other.
    let one = |values: Vec<f64>| values[..4].to_vec();
    let blind = model(vec![
        mode(100.0, &one(shape(1))),
        mode(100.0, &one(shape(1))),
        mode(150.0, &one(shape(3))),
    ]);
    let test = model(vec![
        mode(99.0, &one(shape(1))),
        mode(101.0, &one(shape(1))),
    ]);
    let pairing = paired(&test, &blind);
    assert!(of_both(&pairing).weakest_direction.is_none());
}

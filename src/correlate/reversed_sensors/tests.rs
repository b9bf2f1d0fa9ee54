//! Reversed sensors: single ones, groups, and good sensors of poor models.

use proptest::prelude::*;

use num_complex::Complex64;

use super::super::measures::models::{dof, model};
use super::super::{PairVerdict, PairedTest, Status, compare, pair};
use super::*;
use crate::modal::InputFile;

/// Bending of a hinged beam at `count` sensors in modes 1 to 4, at 10, 40, 90, 160 Hz.
fn beam(count: usize) -> ModalModel {
    let shape = |n: usize| -> Vec<f64> {
        let at = |q: usize| (q as f64 + 0.7) / (count as f64 + 0.4);
        let value = |q: usize| (n as f64 * std::f64::consts::PI * at(q)).sin();
        (0..count).map(value).collect()
    };
    let modes: Vec<(f64, Vec<f64>)> = (1..=4).map(|n| (10.0 * (n * n) as f64, shape(n))).collect();
    let modes: Vec<(f64, &[f64])> = modes.iter().map(|(hz, s)| (*hz, s.as_slice())).collect();
    model(&modes)
}

fn found(test: &ModalModel, theory: &ModalModel) -> Vec<Dof> {
    let found = reversed_sensors(test, theory, &PairOptions::default())
        .expect("shapes of this test have degrees of freedom in common");
    let mut dofs: Vec<Dof> = found.into_iter().map(|found| found.dof).collect();
    dofs.sort();
    dofs
}

#[test]
fn turning_raises_the_mac_to_that_of_the_shapes() {
    let theory = beam(10);
    let test = reverse_sensors(&theory, &[dof(4)]);
    let found = reversed_sensors(&test, &theory, &PairOptions::default())
        .expect("shapes of this test have degrees of freedom in common");
    assert_eq!(found.len(), 1);
    assert!((found[0].mac_after - 1.0).abs() < 1e-12 && found[0].mac_before < 0.75);
    assert!((found[0].direction + 1.0).abs() < 1e-12);
    assert_eq!(reverse_sensors(&test, &[dof(4)]), theory);
    assert_eq!(
        reversed_findings(&found, false)[0].severity,
        Severity::Warning
    );
    assert_eq!(reversed_findings(&found, true)[0].severity, Severity::Info);
}

proptest! {
    #[test]
    fn reversed_sensors_are_found_and_no_others(
        count in 14usize..40,
        drawn in proptest::collection::btree_set(0usize..1000, 0..3),
        noise in proptest::collection::vec(-0.05..0.05f64, 160),
    ) {
        let theory = beam(count);
        let reversed: std::collections::BTreeSet<usize> = drawn.iter().map(|q| 1 + q % count).collect();
        let reversed: Vec<Dof> = reversed.into_iter().map(dof).collect();
        let mut test = reverse_sensors(&theory, &reversed);
        for (n, mode) in test.modes.iter_mut().enumerate() {
            let noisy = mode.shape.iter().enumerate();
            let noisy = noisy.map(|(q, (dof, v))| (dof.clone(), v + noise[40 * n + q]));
            mode.shape = ModeShape::new(noisy.collect::<Vec<_>>());
        }
        let reported = found(&test, &theory);
        prop_assert!(reported.iter().all(|dof| reversed.contains(dof)), "{reported:?} {reversed:?}");
        // A sensor with a share w of the squared length costs about 4 w of the MAC.
        let share = |dof: &Dof| {
            let of = |mode: &crate::modal::Mode| {
                let all: f64 = mode.shape.iter().map(|(_, v)| v.norm_sqr()).sum();
                mode.shape.get(dof).expect("shapes of this test have degrees of freedom in common").norm_sqr() / all
            };
            theory.modes.iter().map(of).sum::<f64>() / 4.0
        };
        for dof in reversed.iter().filter(|dof| share(dof) > 0.01) {
            prop_assert!(reported.contains(dof), "{dof} {reported:?}");
        }
    }
}

#[test]
fn a_sensor_that_disagrees_in_one_mode_and_agrees_in_another_is_left() {
    let theory = model(&[
        (10.0, &[1.0, 1.0, 0.4, 0.2, 0.1, 0.1]),
        (40.0, &[1.0, -1.0, 0.3, 0.1, -0.1, 0.2]),
    ]);
    let mut test = model(&[
        (10.0, &[1.0, 1.0, -0.4, 0.2, 0.1, 0.1]),
        (40.0, &[1.0, -1.0, 0.3, 0.1, -0.1, 0.2]),
    ]);
    // Turning the third sensor would raise the MAC of mode 1 more than it lowers that of mode 2.
    let (first, second) = ((1.90f64 / 2.22).powi(2), (1.97f64 / 2.15).powi(2));
    assert!(0.5 * ((1.0 + second) - (first + 1.0)) > 0.04);
    assert_eq!(found(&test, &theory), []);
    // In both modes it is one that points the other way.
    test.modes[1] = reverse_sensors(&theory, &[dof(3)]).modes[1].clone();
    assert_eq!(found(&test, &theory), [dof(3)]);
}

#[test]
fn one_reversed_sensor_of_many_is_found_and_so_are_more() {
    let theory = beam(300);
    // Turning one of 300 gains about 4/300 at most, which is less than two pairs alone would need.
    let one = reverse_sensors(&theory, &[dof(75)]);
    let one_reversed = reversed_sensors(&one, &theory, &PairOptions::default())
        .expect("shapes of this test have degrees of freedom in common");
    assert_eq!(one_reversed.len(), 1);
    assert_eq!(one_reversed[0].dof, dof(75));
    assert!(one_reversed[0].mac_after - one_reversed[0].mac_before < 0.02);
    let many: Vec<Dof> = (2..29).map(|n| dof(10 * n)).collect();
    let mut expected = many.clone();
    expected.sort();
    assert_eq!(found(&reverse_sensors(&theory, &many), &theory), expected);
}

#[test]
fn noise_at_sensors_that_hardly_move_reverses_none() {
    // The last 200 of 300 sensors stand on a part that hardly moves: their values are noise of 5 %
    // of the mean.
    let mut theory = beam(300);
    let still = |q: usize| q >= 100;
    let noise = |n: usize, q: usize| {
        let x = (q * 37 + n * 101) as f64;
        0.035 * (x * x * 0.618_034).sin()
    };
    let mut test = theory.clone();
    for (n, (measured, other)) in test.modes.iter_mut().zip(&mut theory.modes).enumerate() {
        let both = |seed: usize, shape: &ModeShape| {
            let values = shape.iter().enumerate().map(|(q, (dof, v))| {
                let kept = if still(q) { Complex64::ZERO } else { v };
                (dof.clone(), kept + noise(n + seed, q))
            });
            ModeShape::new(values.collect::<Vec<_>>())
        };
        (measured.shape, other.shape) = (both(0, &measured.shape), both(50, &other.shape));
    }
    let pairing = pair(&test, &theory, &PairOptions::default())
        .expect("shapes of this test have degrees of freedom in common");
    assert!(pairing.pairs.len() >= 3);
    assert_eq!(found(&test, &theory), []);
}

#[test]
fn sensors_that_disagree_by_chance_in_three_poor_pairs_are_left() {
    // Every fifth sensor disagrees in each mode, drawn separately for each: 300/125 in all three.
    let mut theory = beam(300);
    theory.modes.truncate(3);
    let mut test = theory.clone();
    let mut state = 12345u64;
    let mut fifth = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33).is_multiple_of(5)
    };
    for mode in &mut test.modes {
        let values = mode
            .shape
            .iter()
            .map(|(dof, v)| (dof.clone(), if fifth() { -v } else { v }));
        mode.shape = ModeShape::new(values.collect::<Vec<_>>());
    }
    let against = |dof: &Dof| {
        let both = test.modes.iter().zip(&theory.modes);
        both.clone()
            .all(|(a, b)| a.shape.get(dof) != b.shape.get(dof))
    };
    let dofs: Vec<Dof> = theory.modes[0]
        .shape
        .iter()
        .map(|(dof, _)| dof.clone())
        .collect();
    assert!(dofs.iter().any(against));
    assert_eq!(found(&test, &theory), []);
    // Three good pairs say it of as many.
    let few: Vec<Dof> = dofs.into_iter().filter(against).collect();
    assert_eq!(found(&reverse_sensors(&theory, &few), &theory), few);
}

#[test]
fn a_poor_model_has_no_reversed_sensors() {
    for count in [12, 300] {
        let theory = beam(count);
        assert_eq!(found(&bent(&theory), &theory), [], "{count}");
    }
}

/// A beam that is stiffer at one end: nodes move, and signs near them.
fn bent(theory: &ModalModel) -> ModalModel {
    let mut test = theory.clone();
    for (n, mode) in test.modes.iter_mut().enumerate() {
        let values = mode.shape.iter().enumerate();
        let bent = values.map(|(q, (dof, _))| {
            let x = (q as f64 + 0.7) / (mode.shape.len() as f64 + 0.4);
            let moved = x + 0.06 * (std::f64::consts::PI * x).sin();
            let value = ((n + 1) as f64 * std::f64::consts::PI * moved).sin();
            (dof.clone(), Complex64::from(value))
        });
        mode.shape = ModeShape::new(bent.collect::<Vec<_>>());
    }
    test
}

/// The groups of a test with these degrees of freedom, each with its size.
fn named_groups(test: &ModalModel) -> Vec<(String, usize)> {
    let map = DofMap::of_models(test, test);
    let groups = hypotheses(test, &map).into_iter();
    let named = groups.filter_map(|group| Some((group.group?, group.members.len())));
    named.collect()
}

fn at(dofs: &[&str]) -> ModalModel {
    let values = dofs
        .iter()
        .map(|dof| (dof.parse().unwrap(), Complex64::ONE));
    let shape = ModeShape::new(values.collect::<Vec<(Dof, Complex64)>>());
    let mut set = model(&[(10.0, &[1.0])]);
    set.modes[0].shape = shape;
    set
}

#[test]
fn a_group_of_more_than_half_of_the_sensors_is_named_by_the_others() {
    let named = |groups: &[(&str, usize)]| -> Vec<(String, usize)> {
        groups
            .iter()
            .map(|(name, n)| ((*name).to_owned(), *n))
            .collect()
    };
    let three = at(&["1:+X", "2:+X", "3:+X", "4:+X", "1:+Y", "1:+Z", "2:+Z"]);
    let expected = [("directions Y, Z", 3), ("direction Z", 2)];
    assert_eq!(named_groups(&three), named(&expected));
    // Two directions of as many sensors are one hypothesis.
    let two = at(&["1:+X", "2:+X", "1:+Z", "2:+Z"]);
    assert_eq!(named_groups(&two), named(&[("direction X", 2)]));
    let components = at(&[
        "arm.1:+X",
        "arm.2:+X",
        "base.1:+X",
        "base.2:+X",
        "base.3:+X",
    ]);
    assert_eq!(named_groups(&components), named(&[("component arm", 2)]));
    assert_eq!(named_groups(&at(&["1:+X", "2:+X"])), []);
}

#[test]
fn sensors_of_one_file_are_named_together() {
    let theory = beam(12);
    let dofs: Vec<Dof> = theory.modes[0]
        .shape
        .iter()
        .map(|(dof, _)| dof.clone())
        .collect();
    let mut test = reverse_sensors(&theory, &dofs[..5]);
    let file = |path: &str, dofs: &[Dof]| InputFile {
        path: path.to_owned(),
        sha256: String::new(),
        dofs: dofs.to_vec(),
    };
    test.inputs = vec![file("a.uff", &dofs[..5]), file("b.uff", &dofs[5..])];
    let found = reversed_sensors(&test, &theory, &PairOptions::default()).unwrap();
    assert!(
        found
            .iter()
            .all(|sensor| sensor.group.as_deref() == Some("file a.uff")),
        "{found:?}"
    );
    assert_eq!(found.len(), 5);
    let findings = reversed_findings(&found, false);
    assert_eq!(findings.len(), 1);
    assert_eq!(
        (findings[0].code, &findings[0].location),
        (
            Code::ReversedGroup,
            &Location::Sensors("file a.uff".to_owned())
        )
    );
}

#[test]
fn pair_whose_measured_mac_is_below_the_gate_is_not_paired() {
    let theory = beam(40);
    // MAC as measured is (1 − 2w)², w the share of the reversed sensors: nine of 40 hold a quarter
    // of each shape, three about 0.07.
    let nine: Vec<usize> = (4..37).step_by(4).collect();
    for (reversed, mac, tolerance, status) in [
        (nine, 0.25, 0.01, Status::Ambiguous),
        (vec![4, 17, 29], 0.72, 0.06, Status::Paired),
    ] {
        let count = reversed.len();
        let reversed: Vec<Dof> = reversed.into_iter().map(dof).collect();
        let test = reverse_sensors(&theory, &reversed);
        let mut expected = reversed.clone();
        expected.sort();
        assert_eq!(found(&test, &theory), expected);
        let options = PairOptions::default();
        let pairing = pair(&test, &theory, &options).expect("shapes at 40 sensors");
        let tests = [PairedTest {
            name: "t",
            model: &test,
            pairing: &pairing,
            frfs: &[],
        }];
        let table = compare(&theory, &tests, &options).expect("a pairing of these models");
        assert_eq!(table.rows.len(), 4);
        for row in &table.rows {
            let cell = &row.tests[0];
            let measured = cell.mac.expect("shapes at 40 sensors");
            assert!((measured - mac).abs() < tolerance, "{count}: {measured}");
            let level = cell.chance_level.expect("40 sensors").mac;
            assert!(level < measured, "{level}");
            assert_eq!(cell.status, status, "{count}: {:?}", cell.reasons);
            let rests = "with the reversed sensors corrected it is 1.000";
            let reasons = cell.reasons.join("; ");
            assert_eq!(
                reasons.contains(rests),
                status == Status::Ambiguous,
                "{reasons}"
            );
            assert_eq!(
                cell.status == Status::Paired,
                measured >= options.min_mac,
                "{measured}"
            );
        }
        let findings = pairing.findings.iter();
        let below: Vec<_> = findings
            .filter(|finding| finding.code == Code::RestsOnReversal)
            .collect();
        assert_eq!(below.len(), if status == Status::Ambiguous { 4 } else { 0 });
        assert!(
            below.iter().all(|finding| finding.value < finding.limit),
            "{below:?}"
        );
        // With the signs corrected all are paired.
        let corrected = reverse_sensors(&test, &reversed);
        let pairing = pair(&corrected, &theory, &options).expect("shapes at 40 sensors");
        let mut partners = pairing.pairs.iter().flat_map(|pair| &pair.partners);
        assert!(partners.all(|partner| partner.verdict == PairVerdict::Paired));
    }
}

/// Three modes at 10, 40 and 90 Hz of which the last of six sensors holds these shares with these
/// signs.
fn with_last_sensor(shares: [f64; 3], factors: [f64; 3]) -> ModalModel {
    let others = [
        [0.2f64.sqrt(); 5],
        [0.5, -0.5, 0.5, -0.5, 0.0],
        [0.5, 0.5, -0.5, -0.5, 0.0],
    ];
    let shape = |n: usize| -> Vec<f64> {
        let length = (1.0 - shares[n]).sqrt();
        let kept = others[n].iter().map(|value| length * value);
        kept.chain([factors[n] * shares[n].sqrt()]).collect()
    };
    let shapes: Vec<Vec<f64>> = (0..3).map(shape).collect();
    let modes = [10.0, 40.0, 90.0].into_iter().zip(&shapes);
    let modes: Vec<(f64, &[f64])> = modes.map(|(hz, shape)| (hz, shape.as_slice())).collect();
    model(&modes)
}

#[test]
fn one_of_two_sensors_is_never_named() {
    // Which of the two is reversed cannot be observed.
    let theory = model(&[(10.0, &[1.0, 0.9]), (40.0, &[1.0, -0.8])]);
    for reversed in [1, 2] {
        assert_eq!(
            found(&reverse_sensors(&theory, &[dof(reversed)]), &theory),
            []
        );
    }
}

#[test]
fn sensor_that_agrees_in_one_of_three_modes_is_left() {
    // Correlation with the theory over the pairs: −(0.2 + 0.2 − 0.1)/0.5 = −0.6. The gain of MAC is
    // 0.56 of a reversed sensor's.
    let shares = [0.2, 0.2, 0.1];
    let theory = with_last_sensor(shares, [1.0; 3]);
    assert_eq!(
        found(&with_last_sensor(shares, [-1.0, -1.0, 1.0]), &theory),
        []
    );
    assert_eq!(
        found(&with_last_sensor(shares, [-1.0; 3]), &theory),
        [dof(6)]
    );
}

#[test]
fn sensor_that_hardly_measures_is_not_reversed() {
    // A tenth of its motion with the opposite sign: the MAC gains about a quarter of what a
    // reversed sensor gains.
    let shares = [0.2; 3];
    let theory = with_last_sensor(shares, [1.0; 3]);
    assert_eq!(found(&with_last_sensor(shares, [-0.1; 3]), &theory), []);
}

#[test]
fn two_poor_pairs_of_six_sensors_name_none() {
    // In each pair the five other sensors agree in sign, and their shape is turned by 27 degrees:
    // MAC is 0.83 with the last sensor reversed. None of five that disagree is not never.
    let (share, turn) = (0.08f64, 0.471f64);
    let (flat, alternating) = ([0.2f64.sqrt(); 5], [0.5, -0.5, 0.5, -0.5, 0.0]);
    let pairs = [
        (flat, alternating),
        (alternating, [0.5, 0.5, -0.5, -0.5, 0.0]),
    ];
    let of = |angle: f64, last: f64| {
        let shapes = pairs.map(|(first, other)| -> Vec<f64> {
            let length = (1.0 - share).sqrt();
            let value = |(a, b): (f64, f64)| length * (angle.cos() * a + angle.sin() * b);
            let others = first.into_iter().zip(other).map(value);
            others.chain([last * share.sqrt()]).collect()
        });
        model(&[(10.0, &shapes[0]), (40.0, &shapes[1])])
    };
    let theory = of(0.0, 1.0);
    assert_eq!(found(&of(turn, -1.0), &theory), []);
    // Exact pairs do.
    assert_eq!(found(&of(0.0, -1.0), &theory), [dof(6)]);
}

#[test]
fn sensor_that_alone_disagrees_in_two_pairs_of_forty_sensors_is_named() {
    // Amplitudes are wrong by 60 % at 39 sensors, so that MAC is 0.73, and their signs are right:
    // one of 40 disagrees in each pair. The squared differences by themselves would let good
    // sensors do so in 30 of 100 cases.
    let shape = |alternates: bool, value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let sign = |q: usize| if alternates && q % 2 == 1 { -1.0 } else { 1.0 };
        (0..40).map(|q| sign(q) * value(q)).collect()
    };
    let of = |value: &dyn Fn(usize) -> f64| {
        let shapes = [false, true].map(|alternates| shape(alternates, value));
        model(&[(10.0, &shapes[0]), (40.0, &shapes[1])])
    };
    let theory = of(&|_| 1.0);
    let measured = |q: usize| match (q, q / 2 % 2) {
        (16, _) => -1.0,
        (_, 0) => 1.6,
        _ => 0.4,
    };
    assert_eq!(found(&of(&measured), &theory), [dof(17)]);
}

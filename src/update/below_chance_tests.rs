//! Pairs below the chance level are no observations of an update.

use crate::finding::{Code, Place};
use crate::modal::{ModalModel, ModeShape};

use super::test_models::{chain, free, measured, sensors};
use super::*;

const STIFFNESS: [f64; 8] = [100.0; 8];

/// A test of a chain of eight masses: the first shape holds 0.36 of its root and 0.64 of the seventh, whose frequency is six times as
/// high. Independent shapes at eight sensors reach a MAC of 0.444 with the one root in reach (5 of 100 cases).
fn measured_with_a_poor_shape() -> ModalModel {
    let mut test = measured(&chain(&STIFFNESS), &STIFFNESS, 1e-3, true);
    let [first, seventh] = [0, 6].map(|i| test.modes[i].shape.clone());
    let length = |shape: &ModeShape| {
        let squares = shape.iter().map(|(_, value)| value.norm_sqr());
        squares.sum::<f64>().sqrt()
    };
    let parts = [0.6 / length(&first), 0.8 / length(&seventh)];
    let values = first.iter().map(|(dof, value)| {
        let other = seventh.get(dof).expect("a value at each mass");
        (dof.clone(), parts[0] * value + parts[1] * other)
    });
    test.modes[0].shape = ModeShape::new(values.collect::<Vec<_>>());
    test.modes[0].frequency_hz *= 1.05;
    test
}

fn problem_of(test: &ModalModel, below_chance_level: bool) -> Result<UpdateResult, UpdateError> {
    let model = chain(&STIFFNESS);
    let sensors = sensors(&model, &STIFFNESS);
    let own = [MeasuredModes::new("t", test)];
    let options = UpdateOptions {
        below_chance_level,
        starts: 1,
        ..UpdateOptions::default()
    };
    let chosen = free(&["k1", "k2"]);
    let problem = UpdateProblem::new(&model, &STIFFNESS, &chosen, &own, &sensors, options)?;
    update(&problem)
}

#[test]
fn pair_below_the_chance_level_is_no_observation_unless_asked_for() {
    let test = measured_with_a_poor_shape();
    let found = problem_of(&test, false).expect("seven good pairs");
    assert_eq!((found.after.rows.len(), found.left_out.len()), (7, 1));
    assert_eq!(found.left_out[0].label, "t f1");
    let (mac, level) = found.left_out[0].below_chance.expect("a pair by frequency");
    assert!((mac - 0.36).abs() < 1e-9, "{mac}");
    assert!((level - 0.444).abs() < 1e-3, "{level}");
    // The seven others are those of the model, so that nothing is changed.
    for own in &found.parameters {
        assert!((own.updated / own.initial - 1.0).abs() < 1e-6, "{own:?}");
    }
    let findings = found.findings();
    let mut below = findings
        .iter()
        .filter(|own| own.code == Code::BelowChanceLeftOut);
    let finding = below.next().expect("a finding");
    assert_eq!(finding.place, Place::Mode(test.modes[0].frequency_hz));
    assert_eq!((finding.value, finding.limit), (Some(mac), Some(level)));
    assert_eq!(finding.detail.as_deref(), Some("t f1"));
    assert_eq!(below.next(), None);

    let found = problem_of(&test, true).expect("eight pairs");
    assert_eq!((found.after.rows.len(), found.left_out.len()), (8, 0));
    let findings = found.findings();
    assert!(
        findings
            .iter()
            .all(|own| own.code != Code::BelowChanceLeftOut)
    );
    // Its frequency is 5 % too high: the first springs are stiffer, where it counts.
    assert!(
        found.parameters[0].updated > 101.0,
        "{:?}",
        found.parameters
    );
}

#[test]
fn test_with_pairs_below_the_chance_level_alone_is_an_error_that_says_so() {
    let mut test = measured_with_a_poor_shape();
    test.modes.truncate(1);
    let error = problem_of(&test, false).expect_err("one pair, by frequency alone");
    assert_eq!(error, UpdateError::NothingCorrelated { modes: 1, pairs: 1 });
    assert!(error.to_string().contains("below_chance_level = true"));
    problem_of(&test, true).expect("the pair counts");
}

#[test]
fn test_without_shapes_is_paired_by_frequency_and_loses_no_mode() {
    let test = measured(&chain(&STIFFNESS), &STIFFNESS, 1e-3, false);
    let found = problem_of(&test, false).expect("eight pairs by frequency");
    assert_eq!((found.after.rows.len(), found.left_out.len()), (8, 0));
}

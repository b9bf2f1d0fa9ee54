//! Options and sentences of a study of needs; the tests of its command cover a scene of known
//! truth.

use std::path::Path;

use crate::identify::{OrderStep, PredictiveScore};
use crate::modal::Pole;
use crate::scene::Scene;
use crate::study::StudyError;

use super::*;

fn bar() -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("measurements/free-free-beam");
    Scene::load(&folder).unwrap()
}

#[test]
fn invalid_options_are_reported() {
    let scene = bar();
    let wrong = |options: OrderOptions| match order(&scene, &options, &()) {
        Err(error @ StudyError::Value { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let options = OrderOptions {
        frequency_percent: 0.0,
        ..OrderOptions::default()
    };
    assert_eq!(
        wrong(options),
        "[order] frequency_percent: got 0, expected a number above 0"
    );
    let options = OrderOptions {
        tests: vec!["no such".to_owned()],
        ..OrderOptions::default()
    };
    assert!(wrong(options).starts_with("[order] tests: got \"no such\", expected one of"));
}

/// Two identified roots and one more pole, of which BIC takes a stated number.
fn needs(bic: [f64; 4]) -> SceneNeeds {
    let tried = |(number, bic): (usize, f64)| OrderStep {
        pole: (number > 0).then(|| Pole::from_frequency(10.0 * number as f64, 0.01)),
        identified: (1..=2).contains(&number),
        holding: 3,
        bic,
        predicted: Some(PredictiveScore {
            mean: 1.0 + bic.abs(),
            std: 0.0,
        }),
        rest: 1.0,
    };
    let order = |order, missed| TriedOrder {
        order,
        missed,
        spurious: 0,
    };
    let test = TestNeeds {
        name: "hammer".to_owned(),
        inputs: Vec::new(),
        synthetic: true,
        band: Band::new(1.0, 500.0).unwrap(),
        warnings: Vec::new(),
        support: OrderSelection {
            functions: 3,
            lines: 100,
            segment_lines: 1,
            noise_stated: true,
            identified: 2,
            tried: bic.into_iter().enumerate().map(tried).collect(),
        },
        modes: 3,
        undamped: 0,
        orders: vec![
            LowestOrder {
                method: "lscf",
                chosen: Some(order(36, 0)),
                tried: vec![order(4, 1), order(5, 0)],
            },
            LowestOrder {
                method: "lsce",
                chosen: Some(order(40, 1)),
                tried: vec![order(4, 2)],
            },
        ],
        single: Vec::new(),
        notes: Vec::new(),
    };
    SceneNeeds {
        title: "wing".to_owned(),
        options: OrderOptions::default(),
        tests: vec![test],
        failed: Vec::new(),
        theory: Ok(TheoryNeeds::Coordinates {
            model: "gear".to_owned(),
            up_to_hz: Some(500.0),
            roots: 7,
            simplest: "without balls".to_owned(),
            needed: 19,
            whole: 37,
        }),
        parameters: Ok(ParameterNeeds {
            free: ["k_1", "k_2", "k_3"].map(str::to_owned).to_vec(),
            needed: vec!["k_2".to_owned()],
            not_supported: vec!["k_3".to_owned()],
            chi_square: [900.0, 11.0, 10.5],
            data: 12,
            explains: true,
        }),
    }
}

#[test]
fn sentences_say_where_the_counts_differ() {
    let [modes, orders, theory, parameters] =
        &summarise_needs(&needs([0.0, -90.0, -40.0, 10.0]))[..]
    else {
        panic!("four sentences");
    };
    assert!(
        modes.starts_with("hammer (synthetic): the data support 1 root by BIC"),
        "{modes}"
    );
    assert!(
        modes.contains("`ml` identified 2 (3 modes at roots that modes share)"),
        "{modes}"
    );
    assert!(
        modes.ends_with("the identified root at 20.00 Hz explains less than it costs."),
        "{modes}"
    );
    assert!(
        orders.ends_with(
            "lscf 5 (takes 36 itself) and lsce none that was tried (takes 40 itself and misses 1)."
        ),
        "{orders}"
    );
    assert!(theory.contains("19 of the 37 coordinates of gear are enough (without balls) for its 7 roots up to 500 Hz"), "{theory}");
    assert!(
        parameters.contains("1 of 3 has to change (k_2), which explains the misfit: χ² of 12 residuals is 900.0 before and 11.00 after"),
        "{parameters}"
    );
    assert!(
        parameters.ends_with("Not supported by the data: k_3."),
        "{parameters}"
    );
    let more = &summarise_needs(&needs([0.0, -90.0, -100.0, -200.0]))[0];
    assert!(
        more.contains(
            "poles at 30.00 Hz that `ml` made no damped mode of explain more than they cost"
        ),
        "{more}"
    );
    let all = &summarise_needs(&needs([0.0, -90.0, -100.0, -50.0]))[0];
    assert!(all.ends_with("times the stated noise."), "{all}");
    let near = &summarise_needs(&needs([0.0, -90.0, -100.0, -105.0]))[0];
    assert!(
        near.ends_with("(BIC differs by less than 10: not decided)."),
        "{near}"
    );
}

//! Order selection with known truth.

use crate::axis::{Band, FrequencyAxis};

use crate::identify::estimator::IdentifyOptions;
use crate::identify::identification;
use crate::identify::order_selection::{OrderSelection, support};
use crate::identify::synthetic::{Measurement, Structure};

fn axis() -> FrequencyAxis {
    FrequencyAxis {
        start_hz: 40.0,
        step_hz: 0.1,
        len: 1201,
    }
}

/// Four modes between 40 and 160 Hz; the residues of the last are a tenth of those of the others.
fn structure() -> Structure {
    let shape = |a: f64, size: f64| (1..=6).map(|p| size * (a * f64::from(p)).cos()).collect();
    Structure {
        modes: vec![
            (62.0, 0.008, shape(0.3, 1.0)),
            (88.0, 0.01, shape(0.7, 1.0)),
            (91.0, 0.01, shape(1.1, 1.0)),
            (131.0, 0.012, shape(1.6, 0.3)),
        ],
    }
}

fn supported(structure: &Structure, how: &Measurement, band: Band) -> OrderSelection {
    let set = structure.measured(how);
    let options = IdentifyOptions {
        band: Some(band),
        ..IdentifyOptions::default()
    };
    let result = identification(&set, &options).expect("the set of this test has modes to count");
    support(&set, band, &result).expect("the set of this test has modes to count")
}

fn at(snr_db: f64) -> Measurement {
    Measurement {
        snr_db: Some(snr_db),
        seed: 5,
        ..Measurement::of_sensors(6, axis())
    }
}

#[test]
fn the_selected_order_is_the_number_of_modes_above_the_noise() {
    let band = Band::new(40.0, 160.0).expect("the set of this test has modes to count");
    for variance_given in [true, false] {
        let how = Measurement {
            variance_given,
            ..at(50.0)
        };
        let support = supported(&structure(), &how, band);
        assert_eq!(
            (support.identified, support.by_bic()),
            (4, 4),
            "{support:?}"
        );
        assert_eq!(support.by_prediction(), Some(4), "{support:?}");
        let four = &support.tried[4];
        assert!(four.identified && (four.rest - 1.0).abs() < 0.1, "{four:?}");
        assert!(
            (four
                .predicted
                .expect("the set of this test has modes to count")
                .mean
                - 1.0)
                .abs()
                < 0.1,
            "{four:?}"
        );
        // The weakest comes last, and BIC falls at every step up to it.
        assert!(
            (four
                .pole
                .expect("the set of this test has modes to count")
                .natural_frequency_hz()
                - 131.0)
                .abs()
                < 0.2
        );
        assert!(
            support.tried[..=4]
                .windows(2)
                .all(|two| two[1].bic < two[0].bic)
        );
    }
}

#[test]
fn a_mode_below_the_noise_is_not_selected() {
    let band = Band::new(40.0, 160.0).expect("the set of this test has modes to count");
    let support = supported(&structure(), &at(15.0), band);
    assert_eq!(support.by_bic(), 3, "{support:?}");
}

#[test]
fn modes_outside_the_band_are_not_counted() {
    let band = Band::new(75.0, 110.0).expect("the set of this test has modes to count");
    let support = supported(&structure(), &at(60.0), band);
    assert_eq!(
        (support.identified, support.by_bic()),
        (2, 2),
        "{support:?}"
    );
    assert!((support.tried[2].rest - 1.0).abs() < 0.15, "{support:?}");
}

/// The score of a held-out value rises by the ratio of unknowns to values; too few poles predict
/// poorly.
#[test]
fn held_out_lines_are_predicted_best_by_the_true_number_of_poles() {
    let band = Band::new(75.0, 110.0).expect("the set of this test has modes to count");
    let support = supported(&structure(), &at(40.0), band);
    let (two, none) = (&support.tried[2], &support.tried[0]);
    assert_eq!(
        (support.segment_lines, support.by_prediction()),
        (1, Some(2)),
        "{support:?}"
    );
    let increase = two
        .predicted
        .expect("the set of this test has modes to count")
        .mean
        / two.rest;
    assert!(increase > 1.0 && increase < 1.2, "{increase}");
    assert!(
        none.predicted
            .expect("the set of this test has modes to count")
            .mean
            > 10.0
                * two
                    .predicted
                    .expect("the set of this test has modes to count")
                    .mean
    );
}

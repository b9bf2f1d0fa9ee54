//! Test that a smooth rise of the response between a minimum and an antiresonance is not a mode.

use crate::axis::{Band, FrequencyAxis};
use crate::finding::{Code, Finding, Location};

use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Structure};
use crate::identify::tests::seeds;

#[test]
fn rise_before_an_antiresonance_is_rejected_with_a_finding() {
    // Residues of both signs: between 1300 and 2100 Hz the mobility passes a minimum, rises by less
    // than half power, and falls into an antiresonance.
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 2.441406,
        len: 4000,
    };
    let structure = Structure {
        modes: vec![
            (1296.0, 0.01, vec![1.0, 0.0327]),
            (2095.0, 0.01, vec![1.0, 0.0786]),
            (2351.0, 0.01, vec![1.0, -0.454]),
            (3647.0, 0.01, vec![1.0, 0.928]),
            (5067.0, 0.01, vec![1.0, 0.6]),
            (5867.0, 0.01, vec![1.0, -0.749]),
            (6133.0, 0.01, vec![1.0, -0.629]),
            (6967.0, 0.01, vec![1.0, 0.246]),
            (7552.0, 0.01, vec![1.0, 0.034]),
            (8033.0, 0.01, vec![1.0, 0.1]),
            (8933.0, 0.01, vec![1.0, 0.621]),
        ],
    };
    let options = IdentifyOptions {
        band: Some(Band::new(500.0, 9750.0).unwrap()),
        ..IdentifyOptions::default()
    };
    let expected: Vec<f64> = structure.modes.iter().map(|mode| mode.0).collect();
    let mut humps = 0;
    for seed in seeds(20).map(|draw| draw + 1) {
        let set = structure.measured(&Measurement {
            pairs: vec![("2:+Z".parse().unwrap(), "1:+Z".parse().unwrap())],
            snr_db: Some(60.0),
            seed,
            ..Measurement::of_sensors(2, axis)
        });
        let model = identify(&set, &options).unwrap();
        let found: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(found.len(), expected.len(), "seed {seed}: {found:?}");
        let dropped = |finding: &&Finding| {
            let hump =
                matches!(finding.location, Location::Mode(hz) if (1400.0..2050.0).contains(&hz));
            finding.code == Code::PeakDropped && hump
        };
        humps += model.findings.iter().filter(dropped).count();
    }
    assert!(humps > 0, "the hump was there to be dropped");
}

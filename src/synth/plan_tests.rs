//! A specific error refuses each wrong argument of a plan.

use super::test_systems::{clean_test, dof, free, truth};
use super::{HammerTest, Quantisation, SecondContact, SynthError};
use crate::quantity::Quantity;

fn error(change: impl Fn(&mut HammerTest)) -> SynthError {
    let mut test = clean_test(truth(&[(100.0, 0.01, 0.8), (340.0, 0.006, -1.0)]));
    test.validate().expect("a good plan");
    change(&mut test);
    let error = test.validate().unwrap_err();
    // As text, since NaN is not equal to itself.
    let generating = test.generate().unwrap_err();
    assert_eq!(generating.to_string(), error.to_string());
    error
}

fn out_of_range(change: impl Fn(&mut HammerTest)) -> &'static str {
    match error(change) {
        SynthError::OutOfRange { name, .. } => name,
        other => panic!("{other}"),
    }
}

#[test]
fn a_number_outside_its_range_is_named() {
    assert_eq!(
        out_of_range(|t| t.sampling_rate_hz = f64::NAN),
        "sampling rate"
    );
    assert_eq!(out_of_range(|t| t.samples = 1), "samples of a record");
    assert_eq!(out_of_range(|t| t.pretrigger_s = -1e-3), "pre-trigger");
    assert_eq!(out_of_range(|t| t.pretrigger_s = 1.0), "pre-trigger");
    assert_eq!(out_of_range(|t| t.pulse.peak_n = 0.0), "peak force");
    assert_eq!(
        out_of_range(|t| t.pulse.peak_spread = 1.0),
        "spread of the peak force"
    );
    assert_eq!(out_of_range(|t| t.pulse.duration_s = -1.0), "contact time");
    assert_eq!(
        out_of_range(|t| t.pulse.duration_spread = -0.1),
        "spread of the contact time"
    );
    assert_eq!(out_of_range(|t| t.filter.order = 0), "filter order");
    assert_eq!(
        out_of_range(|t| t.noise.force_snr_db = Some(f64::INFINITY)),
        "signal-to-noise ratio of the force"
    );
    assert_eq!(
        out_of_range(|t| t.noise.response_snr_db = Some(f64::NAN)),
        "signal-to-noise ratio of the response"
    );
    assert_eq!(
        out_of_range(|t| t.faults.offsets.response = f64::NAN),
        "offset of the response"
    );
}

#[test]
fn a_fault_outside_its_range_is_named() {
    let second = SecondContact {
        delay_s: 1e-2,
        ratio: 0.5,
        hits: [0].into(),
    };
    let with = |second: SecondContact| {
        move |t: &mut HammerTest| t.faults.second_contact = Some(second.clone())
    };
    let late = with(SecondContact {
        delay_s: 0.99,
        ..second.clone()
    });
    assert!(matches!(
        error(late),
        SynthError::PulseOutsideRecord { got_s, expected_s } if got_s > 1.0 && expected_s <= 1.0
    ));
    let long = |spread: f64| {
        move |t: &mut HammerTest| {
            t.pulse.duration_s = 0.9;
            t.pulse.duration_spread = spread;
        }
    };
    let mut fits = clean_test(truth(&[(100.0, 0.01, 0.8)]));
    long(0.09)(&mut fits);
    assert_eq!(fits.validate(), Ok(()));
    assert!(matches!(
        error(long(0.1)),
        SynthError::PulseOutsideRecord { .. }
    ));
    let never = with(SecondContact {
        ratio: 0.0,
        ..second.clone()
    });
    assert_eq!(out_of_range(never), "peak ratio of the second contact");
    let beyond = with(SecondContact {
        hits: [1].into(),
        ..second
    });
    assert_eq!(
        error(beyond),
        SynthError::HitIndex {
            got: 1,
            expected: 1
        }
    );
    let one_bit = |t: &mut HammerTest| {
        t.faults.quantisation = Some(Quantisation {
            bits: 1,
            force_full_scale_n: 1.0,
            response_full_scale: 1.0,
        });
    };
    assert_eq!(out_of_range(one_bit), "bits of the converter");
}

#[test]
fn a_plan_without_content_or_with_a_repeated_sensor_is_refused() {
    let empty = |what| SynthError::EmptyPlan { what };
    assert_eq!(error(|t| t.hits.clear()), empty("hit points"));
    assert_eq!(
        error(|t| t.averages_per_point = 0),
        empty("averages per point")
    );
    assert_eq!(
        error(|t| t.hits[0].responses.clear()),
        empty("responses of a hit")
    );
    assert_eq!(
        error(|t| t.hits[0].responses.push(dof("1:+Z"))),
        SynthError::DuplicateResponse {
            hit: dof("1:+Z"),
            response: dof("1:+Z")
        }
    );
}

#[test]
fn a_truth_without_the_planned_dofs_is_refused() {
    assert!(matches!(
        error(|t| t.hits[0].responses.push(dof("3:+Z"))),
        SynthError::MissingResidue { mode: 1, response, .. } if response == dof("3:+Z")
    ));
    assert!(matches!(
        error(|t| {
            t.truth = free(t.truth.clone());
            t.truth.rigid_accelerance.pop_last();
        }),
        SynthError::MissingRigidBody { response, .. } if response == dof("2:+Z")
    ));
    assert_eq!(
        error(|t| {
            t.truth = free(t.truth.clone());
            t.quantity = Quantity::Velocity;
        }),
        SynthError::FreeBodyDrifts {
            quantity: Quantity::Velocity
        }
    );
    assert!(matches!(
        error(|t| t.quantity = Quantity::Force),
        SynthError::NotAResponse { .. }
    ));
    assert_eq!(
        error(|t| t.truth.model.modes.clear()),
        SynthError::EmptyTruth
    );
    assert!(matches!(
        error(|t| t.truth.model.modes[1].damping_ratio = None),
        SynthError::Mode {
            mode: 2,
            got: None,
            ..
        }
    ));
    assert!(matches!(
        error(|t| t.truth.model.modes[0].frequency_hz = 0.0),
        SynthError::Mode {
            mode: 1,
            name: "frequency",
            ..
        }
    ));
}

#[test]
fn a_filter_pole_near_a_mode_is_refused() {
    assert!(matches!(
        error(|t| {
            t.sampling_rate_hz = 240.0;
            t.pretrigger_s = 0.0;
        }),
        SynthError::SamplingTooLow { .. }
    ));
    let on_filter_pole = |t: &mut HammerTest| {
        let q = t.low_pass().unwrap().poles_rad_s[0];
        let mode = &mut t.truth.model.modes[1];
        mode.frequency_hz = q.norm() / std::f64::consts::TAU;
        mode.damping_ratio = Some(-q.re / q.norm() + 1e-5);
    };
    assert!(matches!(
        error(on_filter_pole),
        SynthError::PoleOnFilterPole { mode: 2, got, .. } if got < 2e-5
    ));
}

//! The steady response of the helical planetary gear against the reference, and what follows for the detail that is needed.

use super::helical_motion::Detail;
use super::helical_response::{RATIOS, bearing_points};
use crate::theory::parameter::nominal_values;
use crate::theory::response::{Nonlinear, ResponseSpan};
use crate::theory::{HelicalPlanetary, TheoreticalModel, TheoryError, TimeResponse};

fn response(set: &str) -> TimeResponse {
    let model = HelicalPlanetary::new(set).unwrap();
    let values = nominal_values(model.parameters());
    model.response(&values, ResponseSpan::default()).unwrap()
}

/// rms, std, max, min of the sun mesh; rms, std, max of the ring mesh; largest changes of both angles, deg; load sharing
/// most and least; std of the sun's x.
type Row = (
    Detail,
    [f64; 7],
    Option<[f64; 2]>,
    Option<[f64; 2]>,
    Option<f64>,
);

fn check(set: &str, rows: &[Row]) {
    let found = response(set);
    for (detail, meshes, angles, load, sun) in rows {
        let own = found.detail(detail.name()).unwrap();
        let signal = |name: &str| own.signal(name);
        let (ds, dr) = (signal("delta_sp1").unwrap(), signal("delta_rp1").unwrap());
        let got = [
            ds.rms(),
            ds.deviation(),
            ds.largest(),
            ds.least(),
            dr.rms(),
            dr.deviation(),
            dr.largest(),
        ];
        for (i, (got, wanted)) in got.iter().zip(meshes).enumerate() {
            // The transient left over, 1e-6, and the grid of samples, for six digits.
            assert!(
                (got / wanted - 1.0).abs() < 2e-6,
                "{set} {detail:?} {i}: {got} {wanted}"
            );
        }
        match angles {
            Some(wanted) => {
                for (name, wanted) in ["angle_sp1", "angle_rp1"].iter().zip(wanted) {
                    let got = signal(name).unwrap().magnitude();
                    assert!(
                        (got / wanted - 1.0).abs() < 5e-5,
                        "{set} {detail:?} {name}: {got} {wanted}"
                    );
                }
            }
            None => assert!(signal("angle_sp1").is_none()),
        }
        if let Some([most, least]) = load {
            let own = signal("load_sp1").unwrap();
            assert!(
                (own.largest() - most).abs() < 2e-6,
                "{set} {detail:?}: {} {most}",
                own.largest()
            );
            assert!(
                (own.least() - least).abs() < 2e-6,
                "{set} {detail:?}: {} {least}",
                own.least()
            );
        }
        match sun {
            Some(wanted) => {
                let got = signal("x_s").unwrap().deviation();
                assert!(
                    (got / wanted - 1.0).abs() < 3e-6,
                    "{set} {detail:?}: {got} {wanted}"
                );
            }
            None => assert!(signal("x_s").is_none()),
        }
    }
}

#[test]
fn the_steady_state_with_soft_bearings_is_the_reference() {
    use Detail::{ConstantAngle, ExactAngle, PrintedAngle, Torsional};
    check(
        "kb-1.5e8",
        &[
            (
                ConstantAngle,
                [
                    1.898666933e-7,
                    3.825317845e-8,
                    2.280879746e-7,
                    1.285180849e-7,
                    1.663293270e-7,
                    3.686949960e-8,
                    2.273053549e-7,
                ],
                None,
                Some([1.050287, 0.944189]),
                Some(2.222734e-8),
            ),
            (
                PrintedAngle,
                [
                    1.898667444e-7,
                    3.825317584e-8,
                    2.280863863e-7,
                    1.285196880e-7,
                    1.663293431e-7,
                    3.686949220e-8,
                    2.273012554e-7,
                ],
                Some([2.3181e-4, 2.4927e-4]),
                Some([1.050264, 0.944191]),
                Some(2.221865e-8),
            ),
            (
                ExactAngle,
                [
                    1.898667189e-7,
                    3.825317718e-8,
                    2.280871821e-7,
                    1.285188856e-7,
                    1.663293350e-7,
                    3.686949596e-8,
                    2.273033058e-7,
                ],
                Some([2.3184e-4, 2.4931e-4]),
                Some([1.050276, 0.944190]),
                Some(2.222300e-8),
            ),
            (
                Torsional,
                [
                    1.798035934e-7,
                    1.767280044e-8,
                    2.238943928e-7,
                    1.573006545e-7,
                    1.571002743e-7,
                    1.712104942e-8,
                    1.813571364e-7,
                ],
                None,
                None,
                None,
            ),
        ],
    );
}

#[test]
fn the_steady_state_with_stiff_bearings_is_the_reference() {
    use Detail::{ConstantAngle, ExactAngle, PrintedAngle};
    let load = Some([1.289139, 0.758533]);
    check(
        "kb-1e10",
        &[
            (
                ConstantAngle,
                [
                    1.814317060e-7,
                    1.952664943e-8,
                    2.226191955e-7,
                    1.512905812e-7,
                    1.583405859e-7,
                    1.802822125e-8,
                    1.898392587e-7,
                ],
                None,
                load,
                Some(2.082472e-9),
            ),
            (
                PrintedAngle,
                [
                    1.814317069e-7,
                    1.952665063e-8,
                    2.226191932e-7,
                    1.512905783e-7,
                    1.583405867e-7,
                    1.802822269e-8,
                    1.898392636e-7,
                ],
                Some([1.7919e-5, 1.1997e-5]),
                load,
                Some(2.082477e-9),
            ),
            (
                ExactAngle,
                [
                    1.814317065e-7,
                    1.952665003e-8,
                    2.226191943e-7,
                    1.512905798e-7,
                    1.583405863e-7,
                    1.802822197e-8,
                    1.898392612e-7,
                ],
                Some([1.7919e-5, 1.1997e-5]),
                load,
                Some(2.082474e-9),
            ),
        ],
    );
}

#[test]
fn the_spectrum_of_the_deflection_is_the_reference_and_no_richer_with_a_varying_angle() {
    let found = response("kb-1.5e8");
    let constant = found.detail(Detail::ConstantAngle.name()).unwrap();
    for (name, expected) in [
        (
            "delta_sp1",
            [
                4.9335e-8, 1.6382e-8, 7.6765e-9, 1.0665e-8, 1.0727e-9, 4.2745e-9,
            ],
        ),
        (
            "delta_rp1",
            [
                4.5971e-8, 2.0250e-8, 1.7898e-9, 1.0077e-8, 5.8405e-9, 5.6164e-10,
            ],
        ),
    ] {
        let own = &constant.signal(name).unwrap().harmonics;
        for (got, wanted) in own.iter().zip(expected) {
            assert!((got / wanted - 1.0).abs() < 5e-5, "{name}: {got} {wanted}");
        }
    }
    let lines = |detail: Detail| {
        found
            .detail(detail.name())
            .unwrap()
            .signal("delta_sp1")
            .unwrap()
            .lines_above(0.01)
    };
    assert_eq!(
        [lines(Detail::ConstantAngle), lines(Detail::PrintedAngle)],
        [17, 17]
    );
    let from = |own: Detail, other: Detail| {
        found
            .difference("delta_sp1", own.name(), other.name())
            .unwrap()
    };
    let (constant, printed, exact) = (
        Detail::ConstantAngle,
        Detail::PrintedAngle,
        Detail::ExactAngle,
    );
    assert!((from(printed, constant) / 2.325e-5 - 1.0).abs() < 3e-3);
    assert!((from(exact, constant) / 1.163e-5 - 1.0).abs() < 3e-3);
    // As a part of the torsional one in the reference.
    assert!((from(constant, Detail::Torsional) / 0.1902 - 1.0).abs() < 3e-3);
}

#[test]
fn the_constant_angle_suffices_at_every_bearing_stiffness_and_the_torsional_model_at_none() {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    let values = nominal_values(model.parameters());
    let points = bearing_points(&model, &values).unwrap();
    for (ratio, point) in RATIOS.iter().zip(points) {
        assert!(point.constant < 0.01, "{ratio}: {point:?}");
        assert!(point.torsional > 0.01, "{ratio}: {point:?}");
    }
}

#[test]
fn a_response_without_periods_is_an_error() {
    let model = HelicalPlanetary::new("torsional").unwrap();
    let values = nominal_values(model.parameters());
    for span in [
        ResponseSpan {
            told_periods: 0,
            ..ResponseSpan::default()
        },
        ResponseSpan {
            step_radians: 0.0,
            ..ResponseSpan::default()
        },
    ] {
        assert!(matches!(
            model.response(&values, span),
            Err(TheoryError::NoPeriods { .. })
        ));
    }
    let span = ResponseSpan {
        settling_periods: 1,
        told_periods: 1,
        step_radians: 0.3,
    };
    let found = model.response(&values, span).unwrap();
    assert_eq!((found.details.len(), found.details[0].coordinates), (1, 6));
    assert!((found.excitation_hz - 110.0 - 2.0 / 3.0).abs() < 1e-9);
}

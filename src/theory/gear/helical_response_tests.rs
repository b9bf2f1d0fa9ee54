//! The steady response of the helical planetary gear against the reference, and what follows for
//! the detail that is needed.

use std::sync::OnceLock;

use super::helical_mesh::Detail;
use super::helical_motion::Motion;
use crate::theory::parameter::nominal_values;
use crate::theory::response::{Nonlinear, ResponseSignal, ResponseSpan};
use crate::theory::{HelicalPlanetary, TheoreticalModel, TheoryError, TimeResponse};

/// The steady responses with bearings of 1.5e8 and 1e10 N/m, once for all tests of this file.
fn response(set: &str) -> &'static TimeResponse {
    static ALL: [OnceLock<TimeResponse>; 2] = [OnceLock::new(), OnceLock::new()];
    let index = ["kb-1.5e8", "kb-1e10"].iter().position(|name| *name == set);
    ALL[index.unwrap()].get_or_init(|| {
        let model = HelicalPlanetary::new(set).unwrap();
        let values = nominal_values(model.parameters());
        model.response(&values, ResponseSpan::default()).unwrap()
    })
}

/// The details with bearings that give.
pub(super) const ANGLES: [Detail; 3] = [
    Detail::ConstantAngle,
    Detail::PrintedAngle,
    Detail::ExactAngle,
];

/// The motion with the nominal values.
pub(super) fn nominal_motion(model: &HelicalPlanetary, detail: Detail) -> Motion {
    Motion::new(model, &nominal_values(model.parameters()), detail).unwrap()
}

/// A signal that a detail has.
pub(super) fn signal<'a>(
    found: &'a TimeResponse,
    detail: Detail,
    name: &str,
) -> &'a ResponseSignal {
    found.detail(detail.name()).unwrap().signal(name).unwrap()
}

/// rms, std, max, min of the sun mesh; rms, std, max of the ring mesh; largest changes of both
/// angles, deg; load sharing most and least; std of the sun's x.
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
        let response = found.detail(detail.name()).unwrap();
        let signal = |name: &str| response.signal(name);
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
            // The remaining transient, 1e-6, and the grid of samples, for six digits.
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
            let load = signal("load_sp1").unwrap();
            assert!(
                (load.largest() - most).abs() < 2e-6,
                "{set} {detail:?}: {} {most}",
                load.largest()
            );
            assert!(
                (load.least() - least).abs() < 2e-6,
                "{set} {detail:?}: {} {least}",
                load.least()
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
        let harmonics = &signal(found, Detail::ConstantAngle, name).harmonics;
        for (got, wanted) in harmonics.iter().zip(expected) {
            assert!((got / wanted - 1.0).abs() < 5e-5, "{name}: {got} {wanted}");
        }
    }
    let lines = |detail| signal(found, detail, "delta_sp1").lines_above(0.01);
    assert_eq!(
        [lines(Detail::ConstantAngle), lines(Detail::PrintedAngle)],
        [17, 17]
    );
    let from = |detail: Detail, other: Detail| {
        found
            .difference("delta_sp1", detail.name(), other.name())
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
fn changes_by_a_varying_angle_and_soft_bearings_are_the_reference() {
    use Detail::{ConstantAngle, ExactAngle, PrintedAngle, Torsional};
    let [soft, stiff] = ["kb-1.5e8", "kb-1e10"].map(response);
    let change = |from,
                  name: &str,
                  [compared, reference]: [Detail; 2],
                  figure: fn(&ResponseSignal) -> f64| {
        figure(signal(from, compared, name)) / figure(signal(from, reference, name)) - 1.0
    };
    let (peak, std) = (ResponseSignal::largest, ResponseSignal::deviation);
    let (printed, exact) = ([PrintedAngle, ConstantAngle], [ExactAngle, ConstantAngle]);
    for (from, name, details, figure, expected) in [
        (
            soft,
            "delta_sp1",
            printed,
            peak as fn(&ResponseSignal) -> f64,
            -6.964e-6,
        ),
        (soft, "delta_sp1", printed, std, -6.802e-8),
        (soft, "delta_rp1", printed, peak, -1.804e-5),
        (soft, "delta_rp1", printed, std, -2.010e-7),
        (soft, "x_s", printed, std, -3.909e-4),
        (soft, "delta_sp1", exact, peak, -3.475e-6),
        (soft, "delta_sp1", exact, std, -3.318e-8),
        (soft, "x_s", exact, std, -1.954e-4),
        (stiff, "delta_sp1", printed, std, 6.138e-8),
        (stiff, "x_s", printed, std, 2.440e-6),
        (soft, "delta_sp1", [ConstantAngle, Torsional], std, 1.165),
        (stiff, "delta_sp1", [ConstantAngle, Torsional], std, 0.1049),
        (stiff, "delta_sp1", [PrintedAngle, Torsional], std, 0.1049),
    ] {
        let got = change(from, name, details, figure);
        near(got, expected, &(name, details));
    }
    // From extremes of six digits.
    let range = |signal: &ResponseSignal| signal.largest() - signal.least();
    let shared = change(soft, "load_sp1", printed, range);
    assert!((shared + 2.4e-4).abs() < 1.5e-5, "{shared}");
    let mesh = |from, detail| signal(from, detail, "delta_sp1");
    for (detail, from, expected) in [
        (PrintedAngle, ConstantAngle, 2.133e-8),
        (ExactAngle, ConstantAngle, 1.066e-8),
        (PrintedAngle, Torsional, 3.812e-2),
    ] {
        let found = mesh(stiff, detail).difference(mesh(stiff, from)).unwrap();
        near(found, expected, &(detail, from));
    }
    let angle = |from| signal(from, ExactAngle, "angle_sp1").magnitude();
    assert_eq!(format!("{:.0}", angle(soft) / angle(stiff)), "13");
    // Figure 5 against figure 3, at the instants that both have: steps of 1/400 of the period.
    let (five, three) = (mesh(stiff, PrintedAngle), mesh(soft, ConstantAngle));
    near(
        five.deviation() / three.deviation(),
        0.5105,
        &"figures 5 and 3",
    );
    let thinned = |signal: &ResponseSignal| {
        let step = signal.samples.len() / (400 * ResponseSpan::default().recorded_periods);
        let samples: Vec<f64> = signal.samples.iter().copied().step_by(step).collect();
        ResponseSignal::new(("delta_sp1", "m", "at common instants"), samples, 400, 1)
    };
    let distance = thinned(five).difference(&thinned(three)).unwrap();
    assert!((distance / 0.1450 - 1.0).abs() < 1e-3, "{distance}");
}

/// The four digits that the reference tells, and as much for the different steps.
pub(super) fn near(got: f64, expected: f64, about: &dyn std::fmt::Debug) {
    assert!(
        (got / expected - 1.0).abs() < 1e-3,
        "{about:?}: {got} {expected}"
    );
}

#[test]
fn a_response_without_periods_is_an_error() {
    let model = HelicalPlanetary::new("torsional").unwrap();
    let values = nominal_values(model.parameters());
    for span in [
        ResponseSpan {
            recorded_periods: 0,
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
        recorded_periods: 1,
        step_radians: 0.3,
    };
    let found = model.response(&values, span).unwrap();
    assert_eq!((found.details.len(), found.details[0].coordinates), (1, 6));
    assert!((found.excitation_hz - 110.0 - 2.0 / 3.0).abs() < 1e-9);
}

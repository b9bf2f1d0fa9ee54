//! Estimation on hits made by hand, where every number is known in closed form.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::*;
use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::finding::{Code, Location};
use crate::quantity::{FrfKind, Quantity};
use crate::record::{Channel, Hit, Role, Samples};
use crate::signal::{ExponentialWindow, ForceWindow, SignalError};

const STEP_S: f64 = 1e-3;

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

fn channel(name: &str, quantity: Quantity, samples: Vec<f64>) -> Channel {
    let role = match quantity {
        Quantity::Force => Role::Force,
        _ => Role::Response,
    };
    Channel {
        role,
        dof: dof(name),
        quantity,
        to_si: 1.0,
        samples: Samples::F64(samples),
    }
}

fn hit(force: Channel, responses: Vec<Channel>) -> Hit {
    Hit {
        axis: TimeAxis {
            start_s: 0.0,
            step_s: STEP_S,
            len: force.samples.len(),
        },
        force,
        responses,
        origin: "made by hand".to_owned(),
    }
}

/// 16 samples with one value at a place.
fn impulse(height: f64, place: usize) -> Vec<f64> {
    (0..16)
        .map(|n| if n == place { height } else { 0.0 })
        .collect()
}

/// Force 1, 2, 3 at sample 2; response 2, 3, 7 at sample 5: Gff 14, Gxx 62, |Gfx| 29, a delay of
/// three samples.
fn three_hits() -> Vec<Hit> {
    [(1.0, 2.0), (2.0, 3.0), (3.0, 7.0)]
        .map(|(f, x)| {
            let response = channel("3:-Z", Quantity::Velocity, impulse(x, 5));
            hit(
                channel("1:+X", Quantity::Force, impulse(f, 2)),
                vec![response],
            )
        })
        .to_vec()
}

fn with(estimator: Estimator, noise_ratio: Option<f64>) -> EstimateOptions {
    EstimateOptions {
        estimator,
        noise_ratio,
        ..EstimateOptions::default()
    }
}

fn delay(k: usize, samples: f64) -> Complex64 {
    Complex64::cis(-TAU * k as f64 * samples / 16.0)
}

#[test]
fn three_hits_have_the_closed_forms_of_h1_h2_and_hv() {
    let hv = (34.0 + f64::sqrt(34.0 * 34.0 + 8.0 * 841.0)) / 58.0;
    for (options, magnitude) in [
        (EstimateOptions::default(), 29.0 / 14.0),
        (with(Estimator::H2, None), 62.0 / 29.0),
        (with(Estimator::Hv, Some(2.0)), hv),
    ] {
        let set = estimate(&three_hits(), &options).unwrap();
        assert_eq!(set.axis().len, 9);
        assert!((set.axis().step_hz - 62.5).abs() < 1e-10);
        for k in 0..9 {
            let expected = magnitude * delay(k, 3.0);
            assert!((set.values(0)[k] - expected).norm() < 1e-13);
            let coherence = 841.0 / 868.0;
            assert!((set.coherence(0).unwrap()[k] - coherence).abs() < 1e-14);
            let variance = magnitude.powi(2) * (1.0 - coherence) / (coherence * 2.0);
            assert!((set.variance(0).unwrap()[k] / variance - 1.0).abs() < 1e-11);
        }
    }
}

#[test]
fn the_frf_set_states_kind_axis_and_bands() {
    let set = estimate(&three_hits(), &EstimateOptions::default()).unwrap();
    let expected = Function {
        response: dof("3:-Z"),
        reference: dof("1:+X"),
        kind: FrfKind::Mobility,
        averages: Some(3),
        estimator: Some(Estimator::H1),
        // Five lines of three hits.
        variance_dof: Some(20.0),
    };
    assert_eq!(set.functions(), &[expected]);
    assert_eq!(set.record_duration_s, Some(16.0 * STEP_S));
    assert!(set.added_damping_rad_s.abs() < 1e-300);
    let codes: Vec<Code> = set.findings.iter().map(|f| f.code).collect();
    assert_eq!(codes, [Code::TruncationNotDecidable]);
}

#[test]
fn units_are_taken_to_si_once() {
    let mut hits = three_hits();
    for hit in &mut hits {
        hit.force.to_si = 1e3;
        hit.responses[0].to_si = 0.0254;
    }
    let set = estimate(&hits, &EstimateOptions::default()).unwrap();
    let expected = 29.0 / 14.0 * 2.54e-5 * delay(1, 3.0);
    assert!((set.values(0)[1] - expected).norm() < 1e-17);
}

#[test]
fn each_frf_averages_the_hits_with_its_dofs_in_dof_order() {
    let accelerometers = |names: &[&str], height: f64| {
        let response = |name: &&str| channel(name, Quantity::Acceleration, impulse(height, 3));
        names.iter().map(response).collect::<Vec<_>>()
    };
    let force = |name: &str| channel(name, Quantity::Force, impulse(1.0, 3));
    let hits = [
        hit(force("10:+Z"), accelerometers(&["2:+Z"], 5.0)),
        hit(force("1:+Z"), accelerometers(&["2:+Z", "1:-Z"], 2.0)),
        hit(force("1:+Z"), accelerometers(&["1:-Z"], 4.0)),
        hit(force("1:-Z"), accelerometers(&["1:-Z"], 9.0)),
    ];
    let set = estimate(&hits, &EstimateOptions::default()).unwrap();
    let got: Vec<_> = (0..set.len())
        .map(|i| {
            let function = &set.functions()[i];
            let pair = format!("{}|{}", function.response, function.reference);
            (
                pair,
                function.averages.unwrap(),
                set.values(i)[0].re.round() as i32,
            )
        })
        .collect();
    let expected = [
        ("1:-Z|1:+Z", 2, 3),
        ("1:-Z|1:-Z", 1, 9),
        ("2:+Z|1:+Z", 1, 2),
        ("2:+Z|10:+Z", 1, 5),
    ];
    assert_eq!(got, expected.map(|(p, n, v)| (p.to_owned(), n, v)));
    assert!(set.coherence(0).is_some() && set.variance(0).is_some());
    assert!(set.coherence(1).is_none() && set.variance(1).is_none());
    let absent: Vec<_> = set.findings.iter().map(|f| (f.code, f.value)).collect();
    assert_eq!(absent[0], (Code::CoherenceAbsent, Some(3.0)));
    assert_eq!(absent.len(), 2);
}

/// 64 samples: noise of unit scale on every sample, a pulse of 50 at sample 30, a response of 20
/// at 33.
fn noisy_hits() -> Vec<Hit> {
    let noise = |n: f64, seed: f64| (seed * 12.9898 + n * 78.233).sin();
    (0..3)
        .map(|h| {
            let seed = f64::from(h);
            let samples = |height: f64, place: usize, scale: f64, seed: f64| {
                (0..64)
                    .map(|n| {
                        let pulse = if n == place { height } else { 0.0 };
                        pulse + scale * noise(n as f64, seed)
                    })
                    .collect::<Vec<f64>>()
            };
            let force = channel("1:+Z", Quantity::Force, samples(50.0, 30, 1.0, seed + 1.0));
            let response = samples(20.0, 33, 0.5, seed + 7.0);
            hit(
                force,
                vec![channel("2:+Z", Quantity::Acceleration, response)],
            )
        })
        .collect()
}

fn ratio_of(set: &FrfSet) -> f64 {
    let finding = &set.findings[0];
    assert_eq!(finding.code, Code::NoiseRatioFromRecord);
    finding.value.unwrap()
}

#[test]
fn the_noise_ratio_comes_from_pretrigger_variances() {
    let hits = noisy_hits();
    let variance = |channel: &Channel| {
        let quiet = &channel.si()[..28];
        let mean = quiet.iter().sum::<f64>() / 28.0;
        quiet.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 27.0
    };
    let over_hits = |of: fn(&Hit) -> &Channel| hits.iter().map(|h| variance(of(h))).sum::<f64>();
    let expected = over_hits(|h| &h.responses[0]) / over_hits(|h| &h.force);
    let from_record = estimate(&hits, &with(Estimator::Hv, None)).unwrap();
    assert!((ratio_of(&from_record) / expected - 1.0).abs() < 1e-12);
    let location = from_record.findings[0].location.to_string();
    assert_eq!(location, "2:+Z|1:+Z");
    let stated = estimate(&hits, &with(Estimator::Hv, Some(expected))).unwrap();
    let (a, b) = (from_record.values(0)[7], stated.values(0)[7]);
    assert!((a - b).norm() < 1e-12 * b.norm());
}

#[test]
fn hv_does_not_depend_on_the_units_of_its_channels() {
    let options = with(Estimator::Hv, None);
    let plain = estimate(&noisy_hits(), &options).unwrap();
    let mut hits = noisy_hits();
    for hit in &mut hits {
        hit.force.to_si = 4.448;
        hit.responses[0].to_si = 9.806_65;
    }
    let scaled = estimate(&hits, &options).unwrap();
    for k in 0..plain.axis().len {
        let expected = plain.values(0)[k] * (9.806_65 / 4.448);
        assert!((scaled.values(0)[k] - expected).norm() < 1e-12 * expected.norm());
    }
    // A stated ratio belongs to stated units: it must not follow.
    let stated = with(Estimator::Hv, Some(ratio_of(&plain)));
    let other = estimate(&hits, &stated).unwrap();
    let farthest = (0..plain.axis().len)
        .map(|k| (other.values(0)[k] / scaled.values(0)[k] - 1.0).norm())
        .fold(0.0, f64::max);
    assert!(farthest > 1e-3, "{farthest}");
}

#[test]
fn a_force_window_takes_its_share_of_the_noise_out_of_the_ratio() {
    let plain = ratio_of(&estimate(&noisy_hits(), &with(Estimator::Hv, None)).unwrap());
    let options = EstimateOptions {
        force_window: Some(ForceWindow {
            hold_s: STEP_S,
            flank_s: 0.0,
        }),
        ..with(Estimator::Hv, None)
    };
    // Of the 64 samples the pulse is left and one on either side.
    let windowed = ratio_of(&estimate(&noisy_hits(), &options).unwrap());
    assert!(
        (windowed / plain - 64.0 / 3.0).abs() < 1e-11,
        "{windowed} {plain}"
    );
}

#[test]
fn hv_without_a_known_ratio_is_an_error() {
    let error = estimate(&three_hits(), &with(Estimator::Hv, None)).unwrap_err();
    assert!(
        matches!(
            error,
            FrfError::NoiseUnknown {
                response_noise: None,
                force_noise: None,
                ..
            }
        ),
        "{error}"
    );
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = estimate(&three_hits(), &with(Estimator::Hv, Some(bad))).unwrap_err();
        assert!(matches!(error, FrfError::NoiseRatio { .. }));
    }
}

#[test]
fn incompatible_hits_are_errors() {
    let run = |change: fn(&mut Vec<Hit>)| {
        let mut hits = three_hits();
        change(&mut hits);
        estimate(&hits, &EstimateOptions::default()).unwrap_err()
    };
    assert!(matches!(run(Vec::clear), FrfError::NoHits));
    let error = run(|h| h[1].axis.step_s = 2e-3);
    assert!(matches!(error, FrfError::AxisMismatch { .. }), "{error}");
    let error = run(|h| h[2].axis.len = 15);
    assert!(
        matches!(
            error,
            FrfError::AxisMismatch {
                got_len: 15,
                expected_len: 16,
                ..
            }
        ),
        "{error}"
    );
    let error = run(|h| h[0].force.quantity = Quantity::Velocity);
    assert!(matches!(error, FrfError::NotAForce { .. }), "{error}");
    let error = run(|h| h[0].responses[0].quantity = Quantity::Force);
    assert!(matches!(error, FrfError::NotAResponse { .. }), "{error}");
    let error = run(|h| h[1].responses[0].quantity = Quantity::Acceleration);
    assert!(
        matches!(error, FrfError::QuantityMismatch { .. }),
        "{error}"
    );
    let error = run(|h| {
        let twin = h[1].responses[0].clone();
        h[1].responses.push(twin);
    });
    assert!(
        matches!(error, FrfError::DuplicateResponse { .. }),
        "{error}"
    );
    let error = run(|h| h[1].responses.clear());
    assert!(matches!(error, FrfError::NoResponse { .. }), "{error}");
    let error = run(|h| h.iter_mut().for_each(|h| h.axis.step_s = f64::NAN));
    let signal = FrfError::Signal(SignalError::TimeStep {
        origin: String::new(),
        got_s: 0.0,
    });
    assert_eq!(
        std::mem::discriminant(&error),
        std::mem::discriminant(&signal)
    );
}

#[test]
fn an_unexcited_line_is_an_error_with_its_frequency() {
    // 1, 1 has a zero at half the sampling rate, exactly.
    let mut force = impulse(1.0, 0);
    force[1] = 1.0;
    let response = channel("2:+Z", Quantity::Acceleration, impulse(1.0, 3));
    let hits = [hit(channel("1:+Z", Quantity::Force, force), vec![response])];
    let error = estimate(&hits, &EstimateOptions::default()).unwrap_err();
    assert!(
        matches!(error, FrfError::NoForce { line: 8, frequency_hz, .. } if (frequency_hz - 500.0).abs() < 1e-9),
        "{error}"
    );
}

#[test]
fn a_silent_channel_gives_zero_and_uncorrelated_noise_has_no_h2() {
    let one = |response: Vec<f64>, sign: f64| {
        let scaled = response.iter().map(|v| v * sign).collect();
        let response = channel("2:+Z", Quantity::Acceleration, scaled);
        hit(
            channel("1:+Z", Quantity::Force, impulse(1.0, 0)),
            vec![response],
        )
    };
    let silent = [one(vec![0.0; 16], 1.0)];
    for estimator in [Estimator::H1, Estimator::H2] {
        let set = estimate(&silent, &with(estimator, None)).unwrap();
        assert!(set.values(0).iter().all(|h| h.norm() < 1e-300));
    }
    let noise = [one(impulse(1.0, 0), 1.0), one(impulse(1.0, 0), -1.0)];
    let set = estimate(&noise, &EstimateOptions::default()).unwrap();
    assert!(set.coherence(0).unwrap().iter().all(|c| c.abs() < 1e-300));
    // Gxx / Gff / (n - 1) = 1.
    assert!(
        set.variance(0)
            .unwrap()
            .iter()
            .all(|v| (v - 1.0).abs() < 1e-14)
    );
    let error = estimate(&noise, &with(Estimator::H2, None)).unwrap_err();
    assert!(
        matches!(error, FrfError::NotCorrelated { line: 0, .. }),
        "{error}"
    );
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let options = EstimateOptions {
            exponential: Some(ExponentialWindow { decay_rad_s: 3.0 }),
            ..with(Estimator::Hv, None)
        };
        let work = || estimate(&noisy_hits(), &options).unwrap();
        pool.build().unwrap().install(work)
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn the_usable_band_ends_where_the_force_is_twenty_db_down_or_at_the_filter() {
    // A force of two samples, 1 and 1, is 20 dB down at f dt = 0.468, above the filter.
    let with_force = |width: usize, offset: f64| {
        let sample = |n: usize| offset + f64::from(u8::from((40..40 + width).contains(&n)));
        let force = (0..1001).map(sample).collect();
        let response = channel("2:+Z", Quantity::Acceleration, vec![0.0; 1001]);
        [hit(channel("1:+Z", Quantity::Force, force), vec![response])]
    };
    let band = |hits: &[Hit]| usable_band(hits, &EstimateOptions::default()).unwrap();
    let step = 1000.0 / 1001.0;
    for offset in [0.0, 5.0] {
        let filter = band(&with_force(2, offset));
        assert!((filter.lo_hz - step).abs() < 1e-9);
        assert!((filter.hi_hz - 400.0 * step).abs() < 1e-9, "{filter:?}");
        // Five samples: sin(5x) / (5 sin x) = 0.1 with x = pi f dt at f dt = 0.182513.
        let force = band(&with_force(5, offset));
        assert!((force.hi_hz - 182.0 * step).abs() < 1e-9, "{force:?}");
    }
    let silent_above = with_force(1, 0.0).map(|mut hit| {
        hit.axis.len = 2;
        hit.force.samples = Samples::F64(vec![1.0, 0.0]);
        hit.responses[0].samples = Samples::F64(vec![0.0; 2]);
        hit
    });
    let error = usable_band(&silent_above, &EstimateOptions::default()).unwrap_err();
    assert!(matches!(error, FrfError::BandEmpty { .. }), "{error}");
}

#[test]
fn the_bound_is_there_for_every_pair() {
    let bounds = truncation_bounds(&noisy_hits(), &EstimateOptions::default()).unwrap();
    let pair = (dof("2:+Z"), dof("1:+Z"));
    assert_eq!(bounds.keys().collect::<Vec<_>>(), vec![&pair]);
    assert_eq!(bounds[&pair], Truncation::NOT_DECIDABLE);
    let set = estimate(&noisy_hits(), &EstimateOptions::default()).unwrap();
    assert_eq!(set.findings.last().unwrap().location, Location::Whole);
}

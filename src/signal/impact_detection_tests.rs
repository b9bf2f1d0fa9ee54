use super::*;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::PI;

/// A continuous recording: half-sine pulses `(onset, peak, width in samples)` over noise.
struct Recording {
    len: usize,
    pulses: Vec<(usize, f64, usize)>,
    noise_n: f64,
    /// Offset at the beginning and at the end.
    offset_n: (f64, f64),
    seed: u64,
}

impl Recording {
    fn clean(len: usize, onsets: &[usize]) -> Self {
        Self {
            len,
            pulses: onsets.iter().map(|onset| (*onset, 100.0, 20)).collect(),
            noise_n: 0.1,
            offset_n: (0.0, 0.0),
            seed: 1,
        }
    }

    fn force(&self) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let noise = Normal::new(0.0, self.noise_n).unwrap();
        let (first, last) = self.offset_n;
        let drift = |i: usize| first + (last - first) * i as f64 / self.len as f64;
        let mut force: Vec<f64> = (0..self.len)
            .map(|i| drift(i) + noise.sample(&mut random))
            .collect();
        for (onset, peak, width) in &self.pulses {
            for (i, f) in force[*onset..].iter_mut().take(*width).enumerate() {
                *f += peak * (PI * (i as f64 + 0.5) / *width as f64).sin();
            }
        }
        force
    }

    fn cut(&self, options: &TriggerOptions) -> Segments {
        segments(&self.force(), STEP_S, options).unwrap()
    }
}

const STEP_S: f64 = 1e-4;
const AUTO: TriggerOptions = TriggerOptions {
    level_n: None,
    pretrigger_s: None,
    length_s: None,
};

fn onsets(cut: &Segments) -> Vec<usize> {
    cut.segments.iter().map(|s| s.onset).collect()
}

#[test]
fn hits_of_a_clean_recording_get_one_length_and_do_not_overlap() {
    let cut = Recording::clean(50_000, &[3_000, 13_000, 24_000, 36_000]).cut(&AUTO);
    // A half-sine of 20 samples rises above 5 % of its peak at its first sample (7.8 %).
    assert_eq!(onsets(&cut), [3_000, 13_000, 24_000, 36_000]);
    assert_eq!((cut.cut_off, cut.too_early), (0, 0));
    for segment in &cut.segments {
        assert_eq!(segment.range.len(), 10_000);
        assert_eq!(segment.onset - segment.range.start, 200);
    }
    assert!((cut.noise_n / 0.1 - 1.0).abs() < 0.03);
}

#[test]
fn the_last_hit_shortens_all_or_is_left_out_whichever_keeps_more_samples() {
    // Four hits 10,000 apart: three of 10,000 against four of the samples after the last with its
    // 2 %.
    let last = |len: usize| Recording::clean(len, &[3_000, 13_000, 23_000, 33_000]).cut(&AUTO);
    let cut = last(33_000 + 7_600);
    assert_eq!((cut.segments.len(), cut.cut_off), (4, 0));
    assert_eq!(cut.segments[0].range.len(), 7_600 + 155);
    let cut = last(33_000 + 7_000);
    assert_eq!((cut.segments.len(), cut.cut_off), (3, 1));
    assert_eq!(cut.segments[0].range.len(), 10_000);
}

#[test]
fn a_single_impact_keeps_the_available_record() {
    let cut = Recording::clean(20_000, &[5_000]).cut(&AUTO);
    assert_eq!(cut.segments.len(), 1);
    assert_eq!(cut.segments[0].range.end, 20_000);
    let share = (5_000 - cut.segments[0].range.start) as f64 / cut.segments[0].range.len() as f64;
    assert!((share - 0.02).abs() < 1e-4, "{share}");
}

#[test]
fn impacts_cut_by_the_file_ends_are_omitted_and_counted() {
    let options = TriggerOptions {
        length_s: Some(0.8),
        pretrigger_s: Some(0.05),
        ..AUTO
    };
    let cut = Recording::clean(30_000, &[300, 10_000, 24_000]).cut(&options);
    assert_eq!(onsets(&cut), [10_000]);
    assert_eq!((cut.too_early, cut.cut_off), (1, 1));
    assert_eq!(cut.segments[0].range, 9_500..17_500);
}

#[test]
fn a_second_contact_belongs_to_its_hit() {
    let mut recording = Recording::clean(60_000, &[3_000, 17_000, 31_000, 45_000]);
    // 30 ms and 90 ms later.
    recording.pulses.push((3_300, 30.0, 20));
    recording.pulses.push((17_900, 60.0, 20));
    let cut = recording.cut(&AUTO);
    assert_eq!(onsets(&cut), [3_000, 17_000, 31_000, 45_000]);
    assert_eq!(cut.segments[0].range.len(), 14_000);
    // With a stated length any contact inside it.
    recording.pulses.push((33_000, 80.0, 20));
    let options = TriggerOptions {
        length_s: Some(0.5),
        ..AUTO
    };
    assert_eq!(
        onsets(&recording.cut(&options)),
        [3_000, 17_000, 31_000, 45_000]
    );
    assert_eq!(recording.cut(&AUTO).segments.len(), 5);
}

#[test]
fn a_contact_much_closer_than_the_rest_is_a_second_one() {
    let mut recording = Recording::clean(250_000, &[3_000, 63_000, 123_000, 183_000]);
    recording.pulses.push((63_000 + 2_500, 40.0, 20));
    assert_eq!(recording.cut(&AUTO).segments.len(), 4);
    recording.pulses.push((123_000 + 3_100, 40.0, 20));
    assert_eq!(recording.cut(&AUTO).segments.len(), 5);
}

#[test]
fn a_pretrigger_does_not_reach_into_the_contact_before() {
    let mut recording = Recording::clean(9_000, &[1_000, 3_000, 5_000, 7_000]);
    recording.pulses.push((2_950, 50.0, 20));
    let options = TriggerOptions {
        level_n: Some(5.0),
        length_s: Some(0.19),
        pretrigger_s: Some(0.005),
    };
    let cut = segments(&recording.force(), STEP_S, &options);
    assert!(
        cut.is_ok(),
        "the contact at 2,950 opens a new record: {cut:?}"
    );
    let options = TriggerOptions {
        length_s: Some(0.196),
        ..options
    };
    let error = segments(&recording.force(), STEP_S, &options).unwrap_err();
    assert!(matches!(
        error,
        SignalError::WindowParameter {
            parameter: "pretrigger_s",
            ..
        }
    ));
    let automatic = TriggerOptions {
        pretrigger_s: None,
        ..options
    };
    let cut = recording.cut(&automatic);
    let before = cut.segments[1].onset - cut.segments[1].range.start;
    assert!((28..=32).contains(&before), "{before}");
}

#[test]
fn a_record_without_a_pulse_reports_noise_and_maximum() {
    let noise = Recording::clean(20_000, &[]);
    match segments(&noise.force(), STEP_S, &AUTO).unwrap_err() {
        SignalError::NoHit {
            largest_n,
            noise_n,
            level_n,
        } => {
            assert!((noise_n / 0.1 - 1.0).abs() < 0.05);
            // σ√(2 ln(2e7)) = 5.8 σ; the largest of 20,000 lies near 4 σ.
            assert!((level_n / noise_n - 5.798).abs() < 1e-3);
            assert!((3.2..5.5).contains(&(largest_n.abs() / noise_n)));
        }
        other => panic!("{other}"),
    }
    for silent in [vec![], vec![3.0; 100]] {
        let error = segments(&silent, STEP_S, &AUTO).unwrap_err();
        assert!(matches!(error, SignalError::NoHit { .. }));
    }
    let hit = Recording::clean(20_000, &[5_000]).force();
    let high = TriggerOptions {
        level_n: Some(101.0),
        ..AUTO
    };
    assert!(matches!(
        segments(&hit, STEP_S, &high).unwrap_err(),
        SignalError::NoHit { .. }
    ));
}

#[test]
fn options_out_of_range_are_errors() {
    let force = Recording::clean(20_000, &[5_000]).force();
    let bad = |level_n, pretrigger_s, length_s, step_s| {
        let options = TriggerOptions {
            level_n,
            pretrigger_s,
            length_s,
        };
        let error = segments(&force, step_s, &options).unwrap_err();
        assert!(
            matches!(error, SignalError::WindowParameter { .. }),
            "{error}"
        );
    };
    bad(Some(0.0), None, None, STEP_S);
    bad(None, Some(-0.1), None, STEP_S);
    bad(None, Some(0.5), Some(0.5), STEP_S);
    bad(None, None, Some(-1.0), STEP_S);
    bad(None, None, Some(1.2 * STEP_S), STEP_S);
    bad(None, None, Some(2.1), STEP_S);
    bad(None, None, None, 0.0);
    let mut broken = force.clone();
    broken[77] = f64::NAN;
    assert!(matches!(
        segments(&broken, STEP_S, &AUTO).unwrap_err(),
        SignalError::ForceNotFinite { sample: 77, .. }
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Every hit is found at its onset, whatever its width, sign, offset, drift, noise and its
    /// second contacts. Weak ones are a tenth of the strongest where that is above the noise.
    #[test]
    fn known_onsets_are_found(
        seed in 0u64..1 << 40,
        width in 3usize..200,
        snr_db in 30.0f64..80.0,
        spacings in proptest::collection::vec(4_000usize..16_000, 1..9),
        weak in proptest::collection::vec(proptest::bool::ANY, 9),
        bounces in proptest::collection::vec(proptest::bool::ANY, 9),
        sign in proptest::bool::ANY,
        offset in -300.0f64..300.0,
        drift in -50.0f64..50.0,
    ) {
        let mut expected = vec![2_000];
        for spacing in &spacings {
            expected.push(expected[expected.len() - 1] + spacing);
        }
        let turn = if sign { 1.0 } else { -1.0 };
        let weakest = if snr_db > 42.0 { 10.0 } else { 30.0 };
        let mut pulses = Vec::new();
        for (i, onset) in expected.iter().enumerate() {
            let peak = if weak[i] && i > 0 { weakest } else { 100.0 };
            pulses.push((*onset, turn * peak, width));
            if bounces[i] {
                pulses.push((onset + 3 * width, 0.4 * turn * peak, width));
            }
        }
        let recording = Recording {
            len: expected[expected.len() - 1] + 4_500,
            pulses,
            noise_n: 100.0 * 10f64.powf(-snr_db / 20.0),
            offset_n: (offset, offset + drift),
            seed,
        };
        let cut = recording.cut(&AUTO);
        let found = onsets(&cut);
        prop_assert_eq!(found.len() + cut.cut_off, expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            // The pulse leaves the noise late in its rise, at half its height at worst (asin(1/2)/π
            // of the width); noise may carry the walk back a few samples beyond it.
            let late = *found as f64 - *expected as f64;
            prop_assert!(late >= -4.0 && late <= 1.0 + width as f64 / 4.0, "{} {}", found, expected);
        }
        let length = cut.segments[0].range.len();
        for pair in cut.segments.windows(2) {
            prop_assert_eq!(pair[1].range.len(), length);
            prop_assert!(pair[1].range.start >= pair[0].range.end);
        }
        prop_assert_eq!(cut.level_n > 0.0, sign);
    }
}

//! Tests of the maximum likelihood method: exact without noise, at the Cramér-Rao bound with noise,
//! and without spurious modes.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution};

use crate::axis::{Band, FrequencyAxis};
use crate::finding::{Code, Finding};
use crate::frf::{FrfSet, Function, FunctionData};
use crate::modal::{ModalModel, Pole, mac};
use crate::quantity::FrfKind;

use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{
    Measurement, Pair, Structure, close_pair, separated_modes, white_noise, windowed_noise,
};
use crate::identify::tests::seeds;

fn ml(set: &FrfSet) -> ModalModel {
    let options = IdentifyOptions {
        method: "ml".to_owned(),
        ..IdentifyOptions::default()
    };
    identify(set, &options).unwrap()
}

/// Adds hits at the first sensors, up to a number.
fn with_references(measurement: &mut Measurement, count: usize) {
    let sensors: Vec<_> = measurement
        .pairs
        .iter()
        .map(|pair| pair.0.clone())
        .collect();
    let pairs = sensors[..count].iter().flat_map(|hit| {
        sensors
            .iter()
            .map(move |sensor| (sensor.clone(), hit.clone()))
    });
    measurement.pairs = pairs.collect();
}

#[test]
fn poles_without_noise_are_exact_to_eight_digits() {
    for seed in seeds(6) {
        let (structure, mut how) = separated_modes(seed);
        with_references(&mut how, 1 + seed as usize % 2);
        let model = ml(&structure.measured(&how));
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        for (mode, (hz, zeta, shape)) in model.modes.iter().zip(&structure.modes) {
            let truth = Pole::from_frequency(*hz, *zeta).lambda;
            let pole = mode.pole().unwrap().lambda;
            assert!(
                (pole - truth).norm() < 1e-8 * truth.norm(),
                "{pole} {truth}"
            );
            let found: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
            let truth_shape: Vec<Complex64> = shape.iter().map(|v| Complex64::from(*v)).collect();
            // Degrees of freedom in numeric order, as the points.
            assert!(mac(&found, &truth_shape).unwrap() > 1.0 - 1e-9);
        }
    }
}

#[test]
fn errors_with_noise_match_their_standard_deviations() {
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in seeds(40) {
        let (structure, mut how) = separated_modes(seed);
        how.snr_db = Some(50.0);
        let model = ml(&structure.measured(&how));
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        for (mode, (hz, zeta, _)) in model.modes.iter().zip(&structure.modes) {
            let frequency = (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap();
            let damping = (mode.damping_ratio.unwrap() - zeta) / mode.damping_std.unwrap();
            squares += frequency * frequency + damping * damping;
            count += 2.0;
        }
    }
    // A chi-squared over its n degrees of freedom, some 90 of a quarter of the draws: three times
    // its standard deviation sqrt(2/n).
    let bound = 3.0 * (2.0f64 / count).sqrt();
    assert!(
        (squares / count - 1.0).abs() < bound,
        "{} of {count}",
        squares / count
    );
}

#[test]
fn two_references_separate_a_pair_within_a_half_power_bandwidth() {
    for seed in 0..6 {
        let pair = Pair {
            spacing_widths: 0.3,
            difference: None,
            ratio: 1.0,
            lines_per_width: (5.0, 10.0),
        };
        let (structure, mut how) = close_pair(seed, pair);
        with_references(&mut how, 2);
        how.snr_db = Some(60.0);
        let model = ml(&structure.measured(&how));
        assert_eq!(model.modes.len(), 3, "{seed}");
        for (mode, (hz, zeta, _)) in model.modes.iter().zip(&structure.modes) {
            assert!((mode.frequency_hz - hz).abs() < 0.05 * zeta * hz, "{seed}");
        }
    }
}

#[test]
fn repeated_pole_gives_one_group_with_both_modes() {
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.1,
        len: 1600,
    };
    let first = vec![1.0, 0.4, -0.7, 0.2];
    let second = vec![-0.3, 0.9, 0.5, 0.8];
    let far = vec![0.5, 0.5, -0.5, 0.7];
    let structure = Structure {
        modes: vec![
            (80.0, 0.005, first),
            (80.0, 0.005, second),
            (120.0, 0.005, far),
        ],
    };
    let mut how = Measurement {
        snr_db: Some(55.0),
        ..Measurement::of_sensors(4, axis)
    };
    with_references(&mut how, 3);
    let model = ml(&structure.measured(&how));
    let groups: Vec<Option<u32>> = model.modes.iter().map(|mode| mode.group).collect();
    assert_eq!(groups, [Some(1), Some(1), None]);
    assert!(model.modes.iter().all(|mode| mode.damping_std.is_some()));
}

#[test]
fn noise_alone_has_no_modes() {
    let (mut structure, mut how) = separated_modes(3);
    structure.modes.truncate(1);
    how.snr_db = Some(60.0);
    let width = 2.0 * structure.modes[0].0 * structure.modes[0].1;
    let lo = structure.modes[0].0 + 40.0 * width;
    let set = structure.measured(&how);
    let options = IdentifyOptions {
        method: "ml".to_owned(),
        band: Band::new(lo, 0.95 * how.axis.hz(how.axis.len - 1)).ok(),
        ..IdentifyOptions::default()
    };
    assert!(identify(&set, &options).unwrap().modes.is_empty());
}

#[test]
fn bands_of_few_lines_give_a_result() {
    let (structure, how) = separated_modes(2);
    let set = structure.measured(&Measurement {
        snr_db: Some(60.0),
        ..how
    });
    let top = (structure.modes[0].0 / set.axis().step_hz).round();
    for lines in [8, 9, 10, 12, 16] {
        let half = f64::from(lines / 2);
        let band = |k: f64| (top + k) * set.axis().step_hz;
        let options = IdentifyOptions {
            method: "ml".to_owned(),
            band: Band::new(band(-half), band(f64::from(lines - 1) - half)).ok(),
            ..IdentifyOptions::default()
        };
        let found = identify(&set, &options).unwrap().modes;
        assert!(found.len() <= 1, "{lines}: {}", found.len());
        let mut short = FrfSet::new(FrequencyAxis {
            start_hz: band(-half),
            step_hz: set.axis().step_hz,
            len: lines as usize,
        });
        let first = (top - half) as usize;
        for (i, function) in set.functions().iter().enumerate() {
            let data = FunctionData {
                values: set.values(i)[first..first + lines as usize].to_vec(),
                ..FunctionData::default()
            };
            short.push(function.clone(), data).unwrap();
        }
        let options = IdentifyOptions {
            method: "ml".to_owned(),
            ..IdentifyOptions::default()
        };
        assert!(identify(&short, &options).unwrap().modes.len() <= 1);
    }
}

/// The FRFs of a set with noise correlated over `correlated_lines` lines, 60 dB below each FRF, and
/// its variance.
fn with_shared_noise(set: &FrfSet, (correlated_lines, seed): (usize, u64)) -> FrfSet {
    let lines = set.axis().len;
    let mut noisy = FrfSet::new(*set.axis());
    for (i, function) in set.functions().iter().enumerate() {
        let power = set.values(i).iter().map(Complex64::norm_sqr).sum::<f64>() / lines as f64;
        let variance = 1e-6 * power;
        let white = white_noise(
            lines + correlated_lines,
            variance / correlated_lines as f64,
            100 * seed + i as u64,
        );
        let shared = |k: usize| white[k..k + correlated_lines].iter().sum::<Complex64>();
        let data = FunctionData {
            values: (0..lines).map(|k| set.values(i)[k] + shared(k)).collect(),
            coherence: None,
            variance: Some(vec![variance; lines]),
        };
        noisy.push(function.clone(), data).unwrap();
    }
    noisy
}

#[test]
fn noise_correlated_between_lines_gives_no_spurious_modes() {
    for seed in 0..4 {
        let (structure, mut how) = separated_modes(seed);
        how.pairs.truncate(1);
        let set = with_shared_noise(&structure.measured(&how), (12, seed));
        let model = ml(&set);
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        for (mode, (hz, _, _)) in model.modes.iter().zip(&structure.modes) {
            let ratio = (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap();
            assert!(ratio.abs() < 5.0, "{seed}: {ratio} at {hz} Hz");
        }
    }
}

/// The FRFs of a set without variances, with noise 40 dB below each: white noise under an
/// exponential window.
fn with_windowed_noise(set: &FrfSet, (at_end, seed): (f64, u64)) -> FrfSet {
    let lines = set.axis().len;
    let power = |of: &[Complex64]| of.iter().map(Complex64::norm_sqr).sum::<f64>();
    let mut noisy = FrfSet::new(*set.axis());
    for (i, function) in set.functions().iter().enumerate() {
        let noise = windowed_noise(lines, at_end, 100 * seed + i as u64);
        let size = 0.01 * (power(set.values(i)) / power(&noise)).sqrt();
        let values = set.values(i).iter().zip(&noise);
        let data = FunctionData {
            values: values.map(|(h, z)| h + size * z).collect(),
            ..FunctionData::default()
        };
        noisy.push(function.clone(), data).unwrap();
    }
    noisy
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn noise_under_an_unreported_window_gives_no_spurious_modes() {
    let shape = |n: usize| vec![1.0, 0.4 - 0.7 * (n % 2) as f64, 0.8, 0.3 * n as f64 - 0.5];
    let structure = Structure {
        modes: vec![
            (300.0, 0.02, shape(0)),
            (520.0, 0.015, shape(1)),
            (760.0, 0.02, shape(2)),
        ],
    };
    let axis = FrequencyAxis {
        start_hz: 100.0,
        step_hz: 0.5,
        len: 1800,
    };
    let mut how = Measurement::of_sensors(4, axis);
    how.kind = FrfKind::Receptance;
    for (seed, at_end) in [(1, 10.0), (2, 20.0), (3, 40.0)] {
        let set = with_windowed_noise(&structure.measured(&how), (at_end, seed));
        let model = ml(&set);
        assert_eq!(model.modes.len(), 3, "{at_end}");
        let noise_finding = |finding: &&Finding| finding.code == Code::LinesShareNoise;
        let noise_finding = model.findings.iter().find(noise_finding).unwrap();
        // A record of 2 s.
        let ratio = noise_finding.value.as_ref().unwrap() / (0.5 * at_end);
        assert!((0.7..1.4).contains(&ratio), "{at_end}: {ratio}");
        for (mode, (hz, _, _)) in model.modes.iter().zip(&structure.modes) {
            let error_over_std = (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap();
            assert!(
                error_over_std.abs() < 5.0,
                "{at_end}: {error_over_std} at {hz} Hz"
            );
        }
    }
}

/// The FRFs of a set without variances and with a relative error that is smooth over the lines and
/// similar in all FRFs: echoes within a sixtieth of the record, as a joint or a filter causes them.
fn with_echoes(set: &FrfSet, (share, seed): (f64, u64)) -> FrfSet {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (axis, echoes) = (*set.axis(), 40);
    let mut component = || random.random_range(-1.0..1.0);
    let common: Vec<(Complex64, f64)> = (0..echoes)
        .map(|n| {
            let delay = (n as f64 + 0.5) / (60.0 * echoes as f64 * axis.step_hz);
            (Complex64::new(component(), component()), delay)
        })
        .collect();
    let mut echoing = FrfSet::new(axis);
    for (i, function) in set.functions().iter().enumerate() {
        let echoes_of_frf: Vec<(Complex64, f64)> = common
            .iter()
            .map(|(a, delay)| (a * (1.0 + 0.3 * component()), *delay))
            .collect();
        let size = share / (2.0 / 3.0 * f64::from(echoes)).sqrt();
        let value = |(k, h): (usize, &Complex64)| {
            let echo = |(a, delay): &(Complex64, f64)| a * Complex64::cis(-axis.rad_s(k) * delay);
            h * (1.0 + size * echoes_of_frf.iter().map(echo).sum::<Complex64>())
        };
        let data = FunctionData {
            values: set.values(i).iter().enumerate().map(value).collect(),
            ..FunctionData::default()
        };
        echoing.push(function.clone(), data).unwrap();
    }
    echoing
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn data_that_few_modes_cannot_describe_give_no_spurious_modes() {
    let shape = |n: usize| -> Vec<f64> {
        (0..4)
            .map(|p| (0.9 * (n * p) as f64 + 0.5 * n as f64).cos() + 0.2)
            .collect()
    };
    let structure = Structure {
        modes: vec![
            (1074.0, 0.034, shape(0)),
            (1961.0, 0.045, shape(1)),
            (2617.0, 0.045, shape(2)),
        ],
    };
    let axis = FrequencyAxis {
        start_hz: 500.0,
        step_hz: 2.0,
        len: 1500,
    };
    for seed in seeds(2).map(|draw| draw + 1) {
        let mut how = Measurement::of_sensors(4, axis);
        how.kind = FrfKind::Receptance;
        (how.snr_db, how.seed) = (Some(80.0), seed);
        let model = ml(&with_echoes(&structure.measured(&how), (0.03, seed)));
        let scattered = |finding: &Finding| finding.code == Code::PhasesScatter;
        assert!(model.findings.iter().any(scattered), "{seed}");
        assert_eq!(model.modes.len(), 3, "{seed}");
        for (mode, (hz, zeta, _)) in model.modes.iter().zip(&structure.modes) {
            let error_hz = (mode.frequency_hz - hz).abs();
            assert!(error_hz < 0.01 * hz, "{seed}: {error_hz} at {hz} Hz");
            let damping = mode.damping_ratio.unwrap() / zeta;
            assert!(
                (0.85..1.15).contains(&damping),
                "{seed}: {damping} at {hz} Hz"
            );
        }
    }
}

/// Force noise of three hits: relative standard deviation, whether it is common to all FRFs, and
/// the number of correlated lines.
#[derive(Clone, Copy)]
struct ForceNoise {
    relative_std: f64,
    common: bool,
    lines: usize,
}

/// The FRFs of a set with response noise, 80 dB below each FRF, and force noise, with variances
/// estimated from three hits.
fn with_force_noise(set: &FrfSet, force: ForceNoise, seed: u64) -> FrfSet {
    const DEGREES_OF_FREEDOM: f64 = 4.0;
    const RESPONSE_NOISE_RATIO: f64 = 1e-4;
    let lines = set.axis().len;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let scatter = ChiSquared::new(DEGREES_OF_FREEDOM).unwrap();
    let mut noisy = FrfSet::new(*set.axis());
    for (i, function) in set.functions().iter().enumerate() {
        let clean = set.values(i);
        let power = clean.iter().map(Complex64::norm_sqr).sum::<f64>() / lines as f64;
        let response = white_noise(
            lines,
            RESPONSE_NOISE_RATIO * RESPONSE_NOISE_RATIO * power,
            1000 * seed + i as u64,
        );
        let stream = if force.common { 0 } else { i as u64 };
        let white = white_noise(
            lines + force.lines,
            force.relative_std.powi(2) / force.lines as f64,
            1000 * seed + 500 + stream,
        );
        let error = |k: usize| white[k..k + force.lines].iter().sum::<Complex64>();
        let truth = |h: &Complex64| {
            RESPONSE_NOISE_RATIO * RESPONSE_NOISE_RATIO * power
                + force.relative_std.powi(2) * h.norm_sqr()
        };
        let values = clean.iter().enumerate();
        let values = values.map(|(k, h)| h * (1.0 + error(k)) + response[k]);
        let mut estimated = |h| truth(h) * scatter.sample(&mut random) / DEGREES_OF_FREEDOM;
        let data = FunctionData {
            values: values.collect(),
            coherence: None,
            variance: Some(clean.iter().map(&mut estimated).collect()),
        };
        let function = Function {
            averages: Some(3),
            variance_dof: Some(DEGREES_OF_FREEDOM),
            ..function.clone()
        };
        noisy.push(function, data).unwrap();
    }
    noisy
}

/// Mean square of the errors of frequency and damping over their standard deviations; as many modes
/// as true ones, and no finding of a misfit.
fn errors_over_stated(force: ForceNoise) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in seeds(30) {
        let (structure, mut how) = separated_modes(seed);
        // From 5.5 to 12 lines across the narrowest resonance to 1.4 to 3.
        how.axis.step_hz *= 4.0;
        how.axis.len /= 4;
        let model = ml(&with_force_noise(&structure.measured(&how), force, seed));
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        let missed = |finding: &&Finding| finding.code == Code::ModelMisfit;
        assert_eq!(model.findings.iter().find(missed), None, "{seed}");
        for (mode, (hz, zeta, _)) in model.modes.iter().zip(&structure.modes) {
            let frequency = (mode.frequency_hz - hz) / mode.frequency_std_hz.unwrap();
            let damping = (mode.damping_ratio.unwrap() - zeta) / mode.damping_std.unwrap();
            squares += frequency * frequency + damping * damping;
            count += 2.0;
        }
    }
    squares / count
}

#[test]
fn force_noise_in_resonances_of_few_lines_is_estimated_as_noise() {
    let ratio = errors_over_stated(ForceNoise {
        relative_std: 0.02,
        common: false,
        lines: 1,
    });
    // A chi-squared over its degrees of freedom, some 70 of a quarter of the draws; variances
    // estimated from three hits widen it.
    assert!((0.7..1.6).contains(&ratio), "{ratio}");
}

#[test]
fn force_noise_common_to_all_frfs_gives_no_spurious_modes() {
    let common_error = |lines| ForceNoise {
        relative_std: 0.01,
        common: true,
        lines,
    };
    // Treated as independent noise of each FRF, these would be 5 to 12, the number of FRFs, or
    // more. Under an unreported window the fit absorbs much of the force noise, and the residual is
    // less correlated than the noise.
    let (white, windowed) = (
        errors_over_stated(common_error(1)),
        errors_over_stated(common_error(12)),
    );
    assert!((0.5..2.0).contains(&white), "{white}");
    assert!((0.5..2.5).contains(&windowed), "{windowed}");
}

/// A set with other values, by function and line; without variances.
fn changed(set: &FrfSet, value: impl Fn(usize, usize, Complex64) -> Complex64) -> FrfSet {
    let mut changed = FrfSet::new(*set.axis());
    for (i, function) in set.functions().iter().enumerate() {
        let values = set.values(i).iter().enumerate();
        let data = FunctionData {
            values: values.map(|(k, h)| value(i, k, *h)).collect(),
            ..FunctionData::default()
        };
        changed.push(function.clone(), data).unwrap();
    }
    changed
}

/// Two modes of 40 and 70 Hz at five sensors, and a pole of a fraction of a line at a frequency.
fn modes_beside_a_narrow_pole(hz: f64, lines: f64) -> ModalModel {
    let axis = FrequencyAxis {
        start_hz: 20.0,
        step_hz: 0.125,
        len: 800,
    };
    let structure = Structure {
        modes: vec![
            (40.0, 0.01, vec![1.0, 0.8, 0.5, -0.4, -0.9]),
            (70.0, 0.008, vec![0.9, -0.5, -0.7, 0.6, 0.4]),
        ],
    };
    let set = structure.measured(&Measurement {
        snr_db: Some(60.0),
        ..Measurement::of_sensors(5, axis)
    });
    let power = |i: usize| set.values(i).iter().map(Complex64::norm_sqr).sum::<f64>();
    let disturbed = changed(&set, |i, k, h| {
        let rms = (power(i) / axis.len as f64).sqrt();
        h + 0.3 * rms / Complex64::new(0.5 * lines, (axis.hz(k) - hz) / axis.step_hz)
    });
    ml(&disturbed)
}

#[test]
fn mains_hum_in_the_recordings_is_no_mode() {
    let has = |model: &ModalModel, code: Code| {
        let mut findings = model.findings.iter();
        findings.any(|finding| finding.code == code)
    };
    let hum = modes_beside_a_narrow_pole(50.03, 0.04);
    assert_eq!(hum.modes.len(), 2);
    assert!(has(&hum, Code::MainsHum) && !has(&hum, Code::PeakWithoutMode));
    // A mode of so little damping elsewhere stays, and a mode near 50 Hz that is less narrow.
    for (hz, lines) in [(53.03, 0.04), (50.03, 0.3)] {
        let model = modes_beside_a_narrow_pole(hz, lines);
        assert_eq!(model.modes.len(), 3, "{hz} Hz, {lines} lines");
        assert!(!has(&model, Code::MainsHum));
    }
}

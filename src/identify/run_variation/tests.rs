//! Identification of tests with run variation, compared with known truth.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location};
use crate::frf::{FrfSet, FunctionData};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{
    Measurement, Pair, Structure, close_pair, separated_modes, width_hz,
};
use crate::identify::tests::seeds;
use crate::modal::{ModalModel, Mode, PoleSelection, SelectedPole, mac};

/// Every point in a separate run, mode j of point p shifted by `shift(p, j)` of its half-power
/// bandwidths.
pub(super) fn roving(
    (structure, how): &(Structure, Measurement),
    hammer: bool,
    shift: impl Fn(usize, usize) -> f64,
) -> FrfSet {
    let mut set = FrfSet::new(how.axis);
    for (point, (sensor, hit)) in how.pairs.iter().enumerate() {
        let mut shifted = structure.clone();
        for (j, mode) in shifted.modes.iter_mut().enumerate() {
            mode.0 += shift(point, j) * width_hz(mode);
        }
        let pair = if hammer { (hit, sensor) } else { (sensor, hit) };
        let run = shifted.measured(&Measurement {
            pairs: vec![(pair.0.clone(), pair.1.clone())],
            seed: how.seed + 100 * point as u64,
            ..how.clone()
        });
        let data = FunctionData {
            values: run.values(0).to_vec(),
            coherence: None,
            variance: run.variance(0).map(<[f64]>::to_vec),
        };
        set.push(run.functions()[0].clone(), data).unwrap();
    }
    set
}

/// Three to six separated modes at 60 dB.
fn test(seed: u64) -> (Structure, Measurement) {
    let (structure, mut how) = separated_modes(seed);
    how.snr_db = Some(60.0);
    (structure, how)
}

/// FRFs under a roving sensor, the mass of which shifts the modes by at most `most` half-power
/// bandwidths; with the mass.
fn under_sensor_mass((structure, how): &(Structure, Measurement), most: f64) -> (FrfSet, f64) {
    let mass_kg = |mode: &(f64, f64, Vec<f64>)| {
        let largest = mode.2.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        most * 4.0 * mode.1 / largest.powi(2)
    };
    let mass_kg = structure.modes.iter().map(mass_kg);
    let mass_kg = mass_kg.fold(f64::INFINITY, f64::min);
    let set = structure.measured_under_masses(how, |point| (point, mass_kg));
    (set, mass_kg)
}

/// Shift in proportion to the squared motion, half-power bandwidths; `most`: at the point with the
/// largest motion.
fn loaded(structure: &Structure, most: f64) -> impl Fn(usize, usize) -> f64 {
    move |point, j| {
        let shape = &structure.modes[j].2;
        let largest = shape.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        -most * (shape[point] / largest).powi(2)
    }
}

pub(super) fn found(set: &FrfSet) -> ModalModel {
    identify(set, &IdentifyOptions::default()).unwrap()
}

pub(super) fn findings_of(model: &ModalModel, code: Code) -> Vec<&Finding> {
    let has_code = |finding: &&Finding| finding.code == code;
    model.findings.iter().filter(has_code).collect()
}

#[test]
fn a_mode_shifted_by_the_sensor_mass_is_one_mode_with_the_deviation_of_its_mean() {
    let tests = [(0, 0.3), (2, 0.5), (1, 0.3), (3, 0.5), (4, 0.3)];
    for (seed, most) in tests.into_iter().take(seeds(5).count()) {
        let test = test(seed);
        let (set, mass_kg) = under_sensor_mass(&test, most);
        let modes = &test.0.modes;
        // `f m φ²/2` over `2 f ζ`.
        let shift = |p: usize, j: usize| -mass_kg * modes[j].2[p].powi(2) / (4.0 * modes[j].1);
        let model = found(&set);
        assert_eq!(model.modes.len(), modes.len(), "{seed}");
        assert_eq!(
            findings_of(&model, Code::RunsMerged).len(),
            modes.len(),
            "{seed}"
        );
        for (j, (mode, truth)) in model.modes.iter().zip(modes).enumerate() {
            let shifts: Vec<f64> = (0..truth.2.len()).map(|p| shift(p, j)).collect();
            let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
            let squares: f64 = shifts.iter().map(|d| (d - mean).powi(2)).sum();
            let scatter = (squares / (shifts.len() - 1) as f64).sqrt() * width_hz(truth);
            let error = mode.frequency_hz - truth.0 - mean * width_hz(truth);
            assert!(error.abs() < 0.1 * scatter, "{seed} {j}: {error} {scatter}");
            let std = mode.frequency_std_hz.unwrap();
            // Student's quantile over the normal one is 1.15 for ten runs.
            let of_mean = std * (shifts.len() as f64).sqrt() / scatter;
            assert!((0.9..1.4).contains(&of_mean), "{seed} {j}: {of_mean}");
            let damping = mode.damping_ratio.unwrap() / truth.1 - 1.0;
            assert!(damping.abs() < 0.01, "{seed} {j}: damping {damping}");
            let shape: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
            let true_shape: Vec<Complex64> = truth.2.iter().map(|v| Complex64::from(*v)).collect();
            // What the mass changes in second order remains.
            assert!(mac(&shape, &true_shape).unwrap() > 0.9997);
        }
    }
}

/// Every point in a separate run for each of two references, mode j of point p hit at reference h
/// shifted by `shift(h, p, j)` of its half-power bandwidths.
fn roving_two_references(
    (structure, how): &(Structure, Measurement),
    shift: impl Fn(usize, usize, usize) -> f64,
) -> FrfSet {
    let mut set = FrfSet::new(how.axis);
    for (h, hit) in ["1:+Z", "2:+Z"].into_iter().enumerate() {
        let mut measurement = how.clone();
        for pair in &mut measurement.pairs {
            pair.1 = hit.parse().unwrap();
        }
        let of_reference = |point: usize, j: usize| shift(h, point, j);
        let runs = roving(&(structure.clone(), measurement), false, of_reference);
        for (f, function) in runs.functions().iter().enumerate() {
            let data = FunctionData {
                values: runs.values(f).to_vec(),
                coherence: None,
                variance: runs.variance(f).map(<[f64]>::to_vec),
            };
            set.push(function.clone(), data).unwrap();
        }
    }
    set
}

#[test]
fn a_shifted_mode_is_one_mode_with_two_references_as_well() {
    for seed in seeds(4) {
        let test = test(seed);
        let shift = loaded(&test.0, 0.3);
        let model = found(&roving_two_references(&test, |_, point, j| shift(point, j)));
        let modes = test.0.modes.len();
        assert_eq!(model.modes.len(), modes, "{seed}");
        assert_eq!(findings_of(&model, Code::RunsMerged).len(), modes, "{seed}");
        for (mode, truth) in model.modes.iter().zip(&test.0.modes) {
            let damping = mode.damping_ratio.unwrap() / truth.1 - 1.0;
            assert!(damping.abs() < 0.01, "{seed}: damping {damping}");
        }
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn a_mode_that_shifts_between_the_references_of_a_point_is_one_mode() {
    for seed in seeds(4) {
        let test = test(seed);
        let modes = test.0.modes.len();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let points = test.1.pairs.len();
        let shifts: Vec<f64> = (0..2 * points * modes).map(|_| 0.3 * normal()).collect();
        let shift = |h: usize, p: usize, j: usize| shifts[(h * points + p) * modes + j];
        let model = found(&roving_two_references(&test, shift));
        assert_eq!(model.modes.len(), modes, "{seed}");
        assert_eq!(findings_of(&model, Code::RunsMerged).len(), modes, "{seed}");
    }
}

#[test]
fn selected_poles_keep_the_scatter_between_runs() {
    let test = test(1);
    let set = roving(&test, false, loaded(&test.0, 0.3));
    let automatic = found(&set);
    let pole = |mode: &Mode| SelectedPole {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        order: None,
    };
    let select = |count: usize| {
        let options = IdentifyOptions {
            selection: Some(PoleSelection {
                poles: automatic.modes[..count].iter().map(pole).collect(),
                tolerance_hz: None,
            }),
            ..IdentifyOptions::default()
        };
        identify(&set, &options).unwrap()
    };
    // No pole of the other modes is selected.
    let first = select(1);
    assert_eq!(
        (
            first.modes.len(),
            findings_of(&first, Code::RunsMerged).len()
        ),
        (1, 1)
    );
    let model = select(automatic.modes.len());
    assert_eq!(model.modes.len(), automatic.modes.len());
    assert_eq!(
        findings_of(&model, Code::RunsMerged).len(),
        model.modes.len()
    );
    for (mode, other) in model.modes.iter().zip(&automatic.modes) {
        let ratio = |of: fn(&Mode) -> Option<f64>| of(mode).unwrap() / of(other).unwrap();
        assert!((ratio(|mode| mode.frequency_std_hz) - 1.0).abs() < 0.01);
        let damping = ratio(|mode| mode.damping_std);
        assert!((damping - 1.0).abs() < 0.3, "{damping}");
    }
}

/// Shifts of all modes together in each run, as a fraction of the frequency: normal variables of a
/// given standard deviation.
fn drift(seed: u64, deviation: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    (0..16).map(|_| deviation * normal()).collect()
}

/// Asserts that the modes of a drifting test are merged at their true mean.
fn drifts(seed: u64, test: &(Structure, Measurement), deviation: f64) {
    let drift = drift(seed, deviation);
    let modes = &test.0.modes;
    let widths = |point: usize, j: usize| drift[point] * modes[j].0 / width_hz(&modes[j]);
    let model = found(&roving(test, false, widths));
    assert_eq!(model.modes.len(), modes.len(), "{seed}");
    assert_eq!(
        findings_of(&model, Code::RunsMerged).len(),
        modes.len(),
        "{seed}"
    );
    for (mode, truth) in model.modes.iter().zip(modes) {
        let runs = truth.2.len();
        let mean = drift[..runs].iter().sum::<f64>() / runs as f64;
        let error = mode.frequency_hz / truth.0 - 1.0 - mean;
        assert!(error.abs() < 0.02 * deviation, "{seed}: {error}");
        let damping = mode.damping_ratio.unwrap() / truth.1 - 1.0;
        assert!(damping.abs() < 0.02, "{seed}: damping {damping}");
        let shape: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
        let true_shape: Vec<Complex64> = truth.2.iter().map(|v| Complex64::from(*v)).collect();
        let same = mac(&shape, &true_shape).unwrap();
        assert!(same > 0.999, "{seed}: {same}");
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn modes_that_drift_by_a_bandwidth_are_merged() {
    // Seeds 0 to 11 without those whose first fit, with many poles on long records, takes minutes.
    let short = [0, 1, 3, 4, 5, 7, 8, 10, 11];
    for seed in short.into_iter().take(seeds(9).count()) {
        drifts(seed, &test(seed), 0.005);
    }
}

#[test]
fn two_close_modes_that_drift_together_are_two_modes() {
    for seed in seeds(8) {
        let (structure, mut how) = close_pair(
            seed,
            Pair {
                spacing_widths: 1.2,
                difference: None,
                ratio: 1.0,
                lines_per_width: (6.0, 12.0),
            },
        );
        how.snr_db = Some(60.0);
        drifts(seed, &(structure, how), 0.003);
    }
}

#[test]
fn the_changed_run_is_reported() {
    for hammer in [false, true] {
        let changed = |point: usize, _: usize| if point == 2 { 0.3 } else { 0.0 };
        let test = test(5);
        let model = found(&roving(&test, hammer, changed));
        assert_eq!(model.modes.len(), test.0.modes.len());
        let [finding] = findings_of(&model, Code::RunsDisagree)[..] else {
            panic!("{:?}", model.findings);
        };
        let changed: Dof = "3:+Z".parse().unwrap();
        let Location::Function {
            response,
            reference,
        } = &finding.location
        else {
            panic!("{finding}");
        };
        let dof = if hammer { reference } else { response };
        assert_eq!(dof.as_ref(), Some(&changed));
        assert!(finding.value.unwrap() > finding.limit.unwrap());
        let detail = finding.detail.as_deref().unwrap();
        assert!(detail.contains(" 3:+Z, of "), "{detail}");
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn runs_that_agree_are_not_merged() {
    for seed in seeds(40) {
        let model = found(&roving(&test(seed), false, |_, _| 0.0));
        assert!(findings_of(&model, Code::RunsMerged).is_empty(), "{seed}");
        assert!(findings_of(&model, Code::RunsDisagree).is_empty(), "{seed}");
    }
}

/// Four narrow modes of one to eleven lines, nine points in runs between which all modes drift by a
/// given number of half-power bandwidths, with noise proportional to the response and constant
/// noise.
fn beam(seed: u64, widths: f64) -> (Structure, FrfSet) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let step_hz = 0.02;
    let modes = [(11.2, 1.5), (30.7, 3.7), (59.6, 6.0), (97.4, 10.7)];
    let modes = modes.map(|(hz, lines)| {
        let shape = (0..9).map(|_| normal()).collect();
        (hz, lines * step_hz / (2.0 * hz), shape)
    });
    let structure = Structure {
        modes: modes.to_vec(),
    };
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz,
        len: 5500,
    };
    let how = Measurement {
        snr_db: Some(70.0),
        seed,
        ..Measurement::of_sensors(9, axis)
    };
    let drift: Vec<f64> = (0..9).map(|_| widths * normal()).collect();
    let runs = roving(&(structure.clone(), how), true, |point, _| drift[point]);
    let mut set = FrfSet::new(axis);
    for (f, function) in runs.functions().iter().enumerate() {
        let mut noisy = |h: &Complex64| h * (1.0 + 0.02 * Complex64::new(normal(), normal()));
        let data = FunctionData {
            values: runs.values(f).iter().map(&mut noisy).collect(),
            coherence: None,
            variance: None,
        };
        set.push(function.clone(), data).unwrap();
    }
    (structure, set)
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn narrow_modes_in_proportional_noise_are_not_split_with_or_without_drift() {
    for widths in [0.0, 0.1] {
        for seed in seeds(8) {
            let (structure, set) = beam(seed, widths);
            let model = found(&set);
            let modes = structure.modes.len();
            assert_eq!(model.modes.len(), modes, "{widths} {seed}");
            let merged = findings_of(&model, Code::RunsMerged).len();
            assert_eq!(
                merged,
                if widths > 0.0 { modes } else { 0 },
                "{widths} {seed}"
            );
            for (mode, truth) in model.modes.iter().zip(&structure.modes) {
                let damping = mode.damping_ratio.unwrap() / truth.1 - 1.0;
                assert!(damping.abs() < 0.05, "{widths} {seed}: {damping}");
            }
        }
    }
}

#[test]
fn two_close_modes_are_not_merged() {
    for (seed, spacing_widths) in [(0, 0.5), (1, 0.5), (2, 1.0), (3, 1.0)] {
        let (structure, mut how) = close_pair(
            seed,
            Pair {
                spacing_widths,
                difference: None,
                ratio: 1.0,
                lines_per_width: (6.0, 12.0),
            },
        );
        how.snr_db = Some(60.0);
        let model = found(&structure.measured(&how));
        assert_eq!(model.modes.len(), structure.modes.len(), "{seed}");
        assert!(findings_of(&model, Code::RunsMerged).is_empty(), "{seed}");
    }
}

/// Four modes of four to eight lines at two sensors; the third, 0.8 half-power bandwidths above the
/// second, is the weaker. `None` where it is hardly detectable: its residues are a hundredth of
/// those of the second, or its shape is nearly that of the second.
fn weak_beside_strong(seed: u64) -> Option<(usize, FrfSet)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let modes = [
        (20.0, 2e-3, 1.0),
        (50.0, 1e-3, 1.0),
        (50.08, 1e-3, 0.4),
        (75.0, 1e-3, 1.0),
    ];
    let modes = modes.map(|(hz, damping, scale)| {
        let mut value = || -> f64 { StandardNormal.sample(&mut random) };
        (hz, damping, vec![scale * value(), scale * value()])
    });
    let residues = |mode: usize| -> Vec<Complex64> {
        let shape = &modes[mode].2;
        shape.iter().map(|v| (v * shape[0]).into()).collect()
    };
    let size = |residues: &[Complex64]| residues.iter().map(Complex64::norm_sqr).sum::<f64>();
    let (strong, weak) = (residues(1), residues(2));
    if size(&weak) < 1e-4 * size(&strong) || mac(&strong, &weak) > Some(0.9) {
        return None;
    }
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.02,
        len: 5000,
    };
    let how = Measurement {
        snr_db: Some(75.0),
        variance_given: false,
        seed,
        ..Measurement::of_sensors(2, axis)
    };
    let structure = Structure {
        modes: modes.to_vec(),
    };
    Some((structure.modes.len(), structure.measured(&how)))
}

#[test]
fn a_weak_mode_near_a_strong_one_is_not_taken_for_force_noise() {
    let tests: Vec<_> = seeds(32).filter_map(weak_beside_strong).collect();
    let enough = 21 * seeds(32).count() / 32;
    assert!(tests.len() >= enough, "{}", tests.len());
    for (index, (modes, set)) in tests.iter().enumerate() {
        let found = found(set).modes;
        assert_eq!(found.len(), *modes, "{index}");
        let near = |mode: &Mode| (mode.frequency_hz - 50.08).abs() < 0.03;
        assert!(found.iter().any(near), "{index}");
    }
}

/// Three pairs of modes a given number of half-power bandwidths apart, their shapes in phase, at
/// ten sensors.
fn pairs(seed: u64, widths: f64, references: usize, snr_db: f64) -> (Structure, FrfSet) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut modes = Vec::new();
    for hz in [100.0, 190.0, 300.0] {
        let mut value = || random.random_range(0.3..1.0);
        let first: Vec<f64> = (0..10).map(|_| value()).collect();
        let second = first.iter().map(|v| v * (value() - 0.2)).collect();
        modes.push((hz, 0.01, first));
        modes.push((hz * (1.0 + 0.02 * widths), 0.01, second));
    }
    let axis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.2,
        len: 2000,
    };
    let mut how = Measurement {
        snr_db: Some(snr_db),
        seed,
        ..Measurement::of_sensors(10, axis)
    };
    let sensors: Vec<Dof> = how.pairs.iter().map(|pair| pair.0.clone()).collect();
    let hits = sensors[..references].iter();
    let pairs = hits.flat_map(|hit| {
        sensors
            .iter()
            .map(move |sensor| (sensor.clone(), hit.clone()))
    });
    how.pairs = pairs.collect();
    let structure = Structure { modes };
    let set = structure.measured(&how);
    (structure, set)
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn close_pairs_are_not_merged() {
    for (widths, references, snr_db) in [
        (0.08, 1, 40.0),
        (0.1, 2, 40.0),
        (0.2, 2, 20.0),
        (0.3, 1, 30.0),
    ] {
        for seed in seeds(4) {
            let (_, set) = pairs(seed, widths, references, snr_db);
            let model = found(&set);
            let merged = findings_of(&model, Code::RunsMerged);
            assert!(
                merged.is_empty(),
                "{widths} {references} {seed}: {merged:?}"
            );
        }
    }
}

//! Gains that are the same at all modes are found; repeated roots, and responses that one plane of
//! a shaft hardly has, are none.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::axis::FrequencyAxis;
use crate::frf::FunctionData;
use crate::quantity::FrfKind;

use super::*;

const MODES_HZ: [f64; 5] = [40.0, 62.0, 85.0, 113.0, 140.0];
const DAMPING: f64 = 0.01;
const NOISE: f64 = 2e-4;

/// Shapes of the modes at each pole: at the responses, and at the references.
type Shapes = Vec<Vec<(Vec<f64>, Vec<f64>)>>;

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Random shapes, one mode at each pole.
fn shapes(random: &mut ChaCha8Rng, responses: usize, references: usize) -> Shapes {
    let mut vector = |len: usize| (0..len).map(|_| normal(random)).collect::<Vec<f64>>();
    MODES_HZ
        .map(|_| vec![(vector(responses), vector(references))])
        .to_vec()
}

/// FRFs of these shapes with a gain of each FRF and white noise.
fn measured(
    random: &mut ChaCha8Rng,
    shapes: &Shapes,
    gain: impl Fn(usize, usize) -> f64,
) -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 20.0,
        step_hz: 0.125,
        len: 1200,
    };
    let mut set = FrfSet::new(axis);
    let (responses, references) = (shapes[0][0].0.len(), shapes[0][0].1.len());
    for response in 0..responses {
        for reference in 0..references {
            let value = |k: usize| -> Complex64 {
                let s = Complex64::new(0.0, axis.rad_s(k));
                let terms = shapes.iter().zip(MODES_HZ).map(|(modes, hz)| {
                    let lambda = crate::modal::Pole::from_frequency(hz, DAMPING).lambda;
                    let a: f64 = modes.iter().map(|(o, i)| o[response] * i[reference]).sum();
                    let residue = Complex64::new(0.0, -a);
                    residue / (s - lambda) + residue.conj() / (s - lambda.conj())
                });
                terms.sum::<Complex64>() * gain(response, reference)
            };
            let mut values: Vec<Complex64> = (0..axis.len).map(value).collect();
            for value in &mut values {
                *value += NOISE * Complex64::new(normal(random), normal(random));
            }
            let dof = |letter: &str, point: usize| format!("{letter}{point}:+Z").parse().unwrap();
            let function = Function {
                response: dof("r", response),
                reference: dof("h", reference),
                kind: FrfKind::Receptance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            set.push(
                function,
                FunctionData {
                    values,
                    ..FunctionData::default()
                },
            )
            .unwrap();
        }
    }
    set
}

/// The same FRFs with hits at points named as those of the responses.
fn at_common_points(set: FrfSet) -> FrfSet {
    let mut named = FrfSet::new(*set.axis());
    for (i, function) in set.functions().iter().enumerate() {
        let renamed = |dof: &Dof| dof.to_string().replace(['h', 'r'], "p").parse().unwrap();
        let function = Function {
            response: renamed(&function.response),
            reference: renamed(&function.reference),
            ..function.clone()
        };
        let data = FunctionData {
            values: set.values(i).to_vec(),
            ..FunctionData::default()
        };
        named.push(function, data).unwrap();
    }
    named
}

fn estimated(set: &FrfSet) -> Option<GainErrors> {
    GainErrors::estimate(set, Band::new(20.0, 160.0).unwrap(), 1e-3).unwrap()
}

#[test]
fn gains_that_all_modes_share_are_found_to_within_their_noise() {
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (responses, references) = (random.random_range(5..9), random.random_range(2..4));
        let shapes = shapes(&mut random, responses, references);
        let errors: Vec<f64> = (0..responses * references)
            .map(|_| 0.02 * normal(&mut random))
            .collect();
        let gain = |o: usize, i: usize| 1.0 + errors[o * references + i];
        let set = measured(&mut random, &shapes, gain);
        let found = estimated(&set).expect("gains of 2 %");
        let remaining = estimated(&found.corrected(&set));
        assert!(
            remaining.is_none(),
            "{seed}: {:?}",
            remaining.map(|errors| errors.gains)
        );
    }
}

#[test]
fn one_reversed_sign_is_found_and_named() {
    for (seed, references) in (0..8).zip([2, 3].into_iter().cycle()) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let shapes = shapes(&mut random, 6, references);
        let (o, i) = (
            random.random_range(0..6),
            random.random_range(0..references),
        );
        let gain = |output, input| if (output, input) == (o, i) { -1.0 } else { 1.0 };
        let set = measured(&mut random, &shapes, gain);
        let findings = estimated(&set).expect("one FRF is reversed").findings(&set);
        let [finding] = &findings[..] else {
            panic!("{findings:?}");
        };
        let wrong = &set.functions()[o * references + i];
        let decided = references == 3;
        let expected = Location::Function {
            response: Some(wrong.response.clone()),
            reference: decided.then(|| wrong.reference.clone()),
        };
        let code = if decided {
            Code::TurnedFunction
        } else {
            Code::SignUndecided
        };
        assert_eq!((finding.code, &finding.location), (code, &expected));
    }
}

#[test]
fn a_driving_point_decides_which_of_two_frfs_is_reversed() {
    for (o, i) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut shapes = shapes(&mut random, 6, 2);
        // Real normal modes of unit mass, hit at the first two responses.
        for (responses, hits) in shapes.iter_mut().flatten() {
            hits.copy_from_slice(&responses[..2]);
        }
        let gain = |output, input| if (output, input) == (o, i) { -1.0 } else { 1.0 };
        let set = at_common_points(measured(&mut random, &shapes, gain));
        let findings = estimated(&set).expect("one FRF is reversed").findings(&set);
        let wrong = &set.functions()[o * 2 + i];
        let expected = Location::Function {
            response: Some(wrong.response.clone()),
            reference: Some(wrong.reference.clone()),
        };
        assert_eq!(findings[0].location, expected, "{findings:?}");
    }
}

/// Energy beyond rank one of each mode over that of noise.
fn energies_over_noise(set: &FrfSet) -> Vec<f64> {
    let band = Band::new(20.0, 160.0).unwrap();
    let modes = residues_at_peaks(set, band, &FrfMatrix::new(set.functions()), 1e-3).unwrap();
    let ratio = |mode: &ModeResidues| mode.beyond_rank_one_over_noise().unwrap();
    modes.iter().map(ratio).collect()
}

#[test]
fn energy_beyond_rank_one_is_that_of_noise_where_there_are_no_gain_errors() {
    let mut of_noise = Vec::new();
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let shapes = shapes(&mut random, 8, 3);
        let set = measured(&mut random, &shapes, |_, _| 1.0);
        of_noise.extend(energies_over_noise(&set));
        let errors: Vec<f64> = (0..24).map(|_| 0.02 * normal(&mut random)).collect();
        let set = measured(&mut random, &shapes, |o, i| 1.0 + errors[o * 3 + i]);
        let of_errors = energies_over_noise(&set);
        let fewest = of_errors.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(
            fewest > 3.0 * MIN_ENERGY_OVER_NOISE,
            "{seed}: {of_errors:?}"
        );
    }
    // Fourteen complex values each: a standard deviation of 0.27 of one, and of 0.04 of their mean.
    let mean = of_noise.iter().sum::<f64>() / of_noise.len() as f64;
    assert!((mean - 1.0).abs() < 0.25, "{mean}");
    let above = of_noise
        .iter()
        .filter(|ratio| **ratio > MIN_ENERGY_OVER_NOISE);
    assert!(above.count() <= of_noise.len() / 10, "{of_noise:?}");
}

#[test]
fn right_frfs_have_no_gain_errors() {
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let shapes = shapes(&mut random, 6, 3);
        let set = measured(&mut random, &shapes, |_, _| 1.0);
        assert!(estimated(&set).is_none(), "{seed}");
    }
}

#[test]
fn repeated_roots_are_no_gain_errors() {
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let one = shapes(&mut random, 6, 3);
        let other = shapes(&mut random, 6, 3);
        let both: Shapes = one
            .into_iter()
            .zip(other)
            .map(|(a, b)| [a, b].concat())
            .collect();
        let set = measured(&mut random, &both, |_, _| 1.0);
        assert!(estimated(&set).is_none(), "{seed}");
    }
}

#[test]
fn a_second_plane_of_a_shaft_that_slanting_hits_excite_is_no_gain_error() {
    // Every root is a bending mode in each plane; the hits are 3° and 1° off the first plane, on
    // different sides. Three sensors in the first plane, three in the second.
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let pair = |random: &mut ChaCha8Rng| {
        let at_points: Vec<f64> = (0..3).map(|_| normal(random)).collect();
        let at_hits: Vec<f64> = (0..2).map(|_| normal(random)).collect();
        let slant = [3f64.to_radians(), -1f64.to_radians()];
        let first = [at_points.clone(), vec![0.0; 3]].concat();
        let second = [vec![0.0; 3], at_points].concat();
        let across = at_hits
            .iter()
            .zip(slant)
            .map(|(hit, slant)| hit * slant.sin())
            .collect();
        vec![(first, at_hits), (second, across)]
    };
    let shapes: Shapes = MODES_HZ.map(|_| pair(&mut random)).to_vec();
    let set = measured(&mut random, &shapes, |_, _| 1.0);
    assert!(estimated(&set).is_none());
}

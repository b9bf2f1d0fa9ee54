//! Tests of the methods of rising model order on FRFs that no set of common poles describes: each
//! column of the stabilization diagram that stands on a peak is a mode.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::frf::{FrfSet, FunctionData};
use crate::identify::estimator::IdentifyOptions;
use crate::identify::identify;
use crate::identify::synthetic::{Measurement, Structure, separated_modes, width_hz};
use crate::identify::tests::seeds;
use crate::modal::{ModalModel, Pole};

const METHODS: [&str; 3] = ["lscf", "lsce", "rfp"];

fn identified(set: &FrfSet, method: &str) -> ModalModel {
    let options = IdentifyOptions {
        method: method.to_owned(),
        ..IdentifyOptions::default()
    };
    identify(set, &options).unwrap()
}

/// The FRFs of a measurement with 60 dB, each changed by a function of its number and values.
fn changed(
    structure: &Structure,
    how: &Measurement,
    change: impl Fn(usize, &(Dof, Dof)) -> (Structure, Vec<Complex64>),
) -> FrfSet {
    let mut set = FrfSet::new(how.axis);
    for (index, pair) in how.pairs.iter().enumerate() {
        let (of_pair, added) = change(index, pair);
        assert_eq!(of_pair.modes.len(), structure.modes.len());
        let one = of_pair.measured(&Measurement {
            pairs: vec![pair.clone()],
            snr_db: Some(60.0),
            seed: how.seed * 100 + index as u64,
            ..how.clone()
        });
        let values = one.values(0).iter().zip(added).map(|(h, e)| h + e);
        let data = FunctionData {
            values: values.collect(),
            variance: one.variance(0).map(<[f64]>::to_vec),
            ..FunctionData::default()
        };
        set.push(one.functions()[0].clone(), data).unwrap();
    }
    set
}

/// A roving sensor whose mass lowers each natural frequency by up to a part of the half-power
/// bandwidth, in proportion to the square of the motion there.
fn roving_sensor(structure: &Structure, how: &Measurement, widths: f64) -> FrfSet {
    let none = vec![Complex64::ZERO; how.axis.len];
    changed(structure, how, |index, _| {
        let mut loaded = structure.clone();
        for (hz, zeta, shape) in &mut loaded.modes {
            *hz *= 1.0 - 2.0 * *zeta * widths * shape[index].powi(2);
        }
        (loaded, none.clone())
    })
}

/// Accelerances of a structure whose modes depend on amplitude: beside each pole another one of
/// three times its decay rate, with residues in quadrature.
fn amplitude_dependent(structure: &Structure, how: &Measurement, size: f64) -> FrfSet {
    changed(structure, how, |_, pair| {
        let added = |k: usize| {
            let s = Complex64::new(0.0, how.axis.rad_s(k));
            let term = |(mode, (hz, zeta, _)): (usize, &(f64, f64, Vec<f64>))| {
                let lambda = Pole::from_frequency(*hz, *zeta).lambda;
                let wide = Complex64::new(3.0 * lambda.re, lambda.im);
                let residue = 3.0 * size * Complex64::I * structure.residue(mode, pair);
                residue / (s - wide)
            };
            let modes = structure.modes.iter().enumerate();
            modes.map(term).sum::<Complex64>() * s.powi(2)
        };
        let added = (0..how.axis.len).map(added).collect();
        (structure.clone(), added)
    })
}

/// Asserts that most modes of some sets are found, and that each identified mode lies within two
/// half-power bandwidths of a true one.
fn assert_columns(sets: &[(Structure, FrfSet)]) {
    for method in METHODS {
        let (mut modes, mut found) = (0, 0);
        for (structure, set) in sets {
            let model = identified(set, method);
            let is_near = |mode: &(f64, f64, Vec<f64>), hz: f64, widths: f64| {
                (mode.0 - hz).abs() < widths * width_hz(mode)
            };
            let has_pole = |mode: &&(f64, f64, Vec<f64>)| {
                let mut poles = model.modes.iter();
                poles.any(|pole| is_near(mode, pole.frequency_hz, 1.0))
            };
            modes += structure.modes.len();
            found += structure.modes.iter().filter(has_pole).count();
            for hz in model.modes.iter().map(|pole| pole.frequency_hz) {
                let mut truth = structure.modes.iter();
                assert!(truth.any(|mode| is_near(mode, hz, 2.0)), "{method} {hz}");
            }
        }
        assert!(10 * found >= 7 * modes, "{method}: {found} of {modes}");
    }
}

#[test]
#[ignore = "long: in release by .ci/run"]
fn columns_of_peaks_are_modes_although_frequencies_differ_between_frfs() {
    let set = |seed| {
        let (structure, how) = separated_modes(seed);
        let set = roving_sensor(&structure, &how, 0.3);
        (structure, set)
    };
    assert_columns(&seeds(24).map(set).collect::<Vec<_>>());
}

/// The error of such a pole is that of the method, and its standard deviation says so.
#[test]
fn standard_deviation_of_a_column_contains_the_bias_of_its_method() {
    let mut deviations = Vec::new();
    for seed in seeds(24).step_by(2) {
        let (structure, how) = separated_modes(seed);
        let set = amplitude_dependent(&structure, &how, 0.1);
        for method in METHODS {
            for (mode, truth) in identified(&set, method).modes.iter().zip(&structure.modes) {
                let std = mode.frequency_std_hz.unwrap();
                deviations.push((mode.frequency_hz - truth.0).abs() / std);
            }
        }
    }
    deviations.sort_by(f64::total_cmp);
    let median = deviations[deviations.len() / 2];
    assert!(median < 3.0, "{median}");
}

#[test]
fn noise_has_no_columns() {
    for seed in seeds(40) {
        let (structure, how) = separated_modes(seed);
        let quiet = Structure {
            modes: structure
                .modes
                .iter()
                .map(|(hz, zeta, shape)| (1e4 * hz, *zeta, shape.clone()))
                .collect(),
        };
        let set = quiet.measured(&Measurement {
            snr_db: Some(-40.0),
            variance_given: seed % 2 == 0,
            ..how
        });
        for method in METHODS {
            let model = identified(&set, method);
            assert!(
                model.modes.is_empty(),
                "{method} {seed} {:?}",
                model.modes.len()
            );
        }
    }
}

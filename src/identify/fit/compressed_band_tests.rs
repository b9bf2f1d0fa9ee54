//! A compressed band against the lines themselves.

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::fit::compressed_band::{CompressedBand, CompressedValues, KnownResponse};
use crate::identify::fit::fit_data::FitData;
use crate::identify::synthetic::{Measurement, Structure};
use crate::linalg::{self, ComplexMatrix};
use crate::modal::Pole;

/// More than the FRFs whose whole energy is summed.
const SENSORS: usize = 60;

/// Two modes with large components at the even sensors and small ones at the odd.
fn measured() -> (FitData, [Complex64; 2]) {
    measured_at(50.0)
}

fn measured_at(snr_db: f64) -> (FitData, [Complex64; 2]) {
    let shape = |a: f64| {
        let value = |p: usize| {
            if p.is_multiple_of(2) {
                (a * p as f64).cos()
            } else {
                1e-3
            }
        };
        (0..SENSORS).map(value).collect()
    };
    let modes = [(100.0, 0.01), (103.0, 0.02)];
    let structure = Structure {
        modes: vec![
            (modes[0].0, modes[0].1, shape(0.3)),
            (modes[1].0, modes[1].1, shape(0.7)),
        ],
    };
    let axis = FrequencyAxis {
        start_hz: 80.0,
        step_hz: 0.1,
        len: 401,
    };
    let set = structure.measured(&Measurement {
        snr_db: Some(snr_db),
        seed: 1,
        ..Measurement::of_sensors(SENSORS, axis)
    });
    let data = FitData::guarded(&set, Band::new(80.0, 120.0).unwrap()).unwrap();
    let poles = modes.map(|(hz, zeta)| Pole::from_frequency(hz, zeta).lambda);
    (data, poles)
}

fn members(poles: &[Complex64]) -> Vec<ModelPole> {
    let root = |lambda: &Complex64| ModelPole::single(*lambda, &[Complex64::ONE], SENSORS);
    poles.iter().map(root).collect()
}

/// Coordinates of all values of a compressed band, with nothing subtracted, and their energy.
fn all(window: &CompressedBand, data: &FitData) -> (CompressedValues, f64) {
    let zero = |rows, columns| linalg::complex_matrix(rows, columns, |_, _| Complex64::ZERO);
    let residues: ComplexMatrix = zero(2, SENSORS);
    let known = KnownResponse {
        line_shapes: &zero(window.lines().len(), 2),
        residues: &residues,
        out_of_band: None,
    };
    let near = window.without_known_response(&known);
    let energy = window.energy(data, &known, &near);
    (near, energy)
}

/// Energy of the values that out-of-band terms and powers of the line shapes explain, computed from
/// the lines themselves; and the energy of the values.
fn energies_from_lines(
    data: &FitData,
    window: &CompressedBand,
    poles: &[Complex64],
    powers: usize,
) -> (f64, f64) {
    let (lines, profile) = (window.lines().clone(), window.profile());
    let omega = &data.frfs.omega[lines.clone()];
    let background = OutOfBandBasis::new(&data.frfs.omega, &lines, data.out_of_band_terms());
    let first = background.columns();
    let columns = linalg::complex_matrix(omega.len(), first + powers * poles.len(), |k, column| {
        let value = match column.checked_sub(first) {
            None => background.value(column, omega, k),
            Some(index) => {
                let lambda = poles[index / powers];
                let line_shape = lambda.re.abs() / (Complex64::new(0.0, omega[k]) - lambda);
                line_shape.powu((index % powers) as u32 + 1)
            }
        };
        value / profile.noise_profile[k]
    });
    let values = linalg::complex_matrix(omega.len(), SENSORS, |k, f| {
        data.frfs.values[f][lines.start + k] / (profile.noise_profile[k] * profile.level[f])
    });
    let coordinates = linalg::thin_qr(&columns).unwrap().q.adjoint() * &values;
    (coordinates.squared_norm_l2(), values.squared_norm_l2())
}

#[test]
fn coordinates_explain_the_same_energy_as_the_lines_for_near_and_for_shifted_poles() {
    let (data, truth) = measured();
    let mut window = CompressedBand::new(&data, &(60..341), truth.to_vec());
    // Within range, half a decay rate off one after the other, and back.
    let offsets = [[0.0, 2e-5], [0.5, 2e-5], [0.5, -0.4], [0.0, 0.0]];
    for offsets in offsets {
        let moved = |j: usize| truth[j] + offsets[j] * truth[j].re.abs() * Complex64::new(0.6, 0.8);
        let poles = [0, 1].map(moved);
        if !window.serves(&poles) {
            window.add_missing_expansion_points(&data, poles.to_vec());
        }
        assert!(window.serves(&poles));
        let (near, energy) = all(&window, &data);
        // With the derivatives of both, and with line shapes alone.
        let mut whole = 0.0;
        for (moving, powers) in [(&[0, 1][..], 2), (&[], 1)] {
            let (_, explained) = window.compressed(&near, &members(&poles), moving);
            let (expected, all) = energies_from_lines(&data, &window, &poles, powers);
            // Ten digits of the whole: the residual is 1e-5 of it.
            let difference = (explained - expected).abs();
            assert!(difference < 1e-10 * all, "{explained} {expected}");
            whole = all;
        }
        // The part outside the basis is noise, estimated from 30 FRFs of 281 lines: to 1 %, four
        // times.
        let outside_basis = (energy - near.energy) / (whole - near.energy);
        assert!((outside_basis - 1.0).abs() < 0.04, "{outside_basis}");
    }
}

#[test]
fn truncation_error_of_poles_within_range_is_far_below_the_noise() {
    let (data, truth) = measured_at(90.0);
    let lines = 60..341;
    let window = |offset: f64| {
        let about = truth.map(|lambda| lambda + offset * lambda.re.abs());
        CompressedBand::new(&data, &lines, about.to_vec())
    };
    let offsets = (1..2000).map(|step| f64::from(step) * 1e-5);
    let served = offsets.take_while(|offset| window(*offset).serves(&truth));
    let range = served.last().unwrap();
    // The third power of it is a thousandth of the noise relative to the strongest response; levels
    // are those of 281 lines.
    let strongest = (0..SENSORS).flat_map(|f| {
        let values = data.frfs.values[f][lines.clone()].iter();
        let pairs = values.zip(&data.noise.variance[f][lines.clone()]);
        pairs.map(|(h, v)| h.norm_sqr() / v).collect::<Vec<_>>()
    });
    let expected = (1e-3 / strongest.fold(0.0, f64::max).sqrt()).cbrt();
    assert!((range / expected - 1.0).abs() < 0.15, "{range} {expected}");
    let window = window(range);
    let (near, _) = all(&window, &data);
    let (_, explained) = window.compressed(&near, &members(&truth), &[]);
    let (expected, _) = energies_from_lines(&data, &window, &truth, 1);
    // A thousandth of the noise, added to noise, in each of the FRFs.
    let difference = (explained - expected).abs();
    assert!(difference < 2e-3 * SENSORS as f64, "{explained} {expected}");
}

#[test]
fn a_compressed_band_is_valid_for_its_noise_and_its_lines_only() {
    let (mut data, truth) = measured();
    let window = CompressedBand::new(&data, &(60..341), truth.to_vec());
    assert!(window.is_of(&data));
    assert!(
        window.covers(&(62..340), data.frfs.lines())
            && !window.covers(&(100..340), data.frfs.lines())
    );
    // A band that ends with the data has other out-of-band terms.
    let edge = CompressedBand::new(&data, &(0..341), truth.to_vec());
    assert!(
        !edge.covers(&(1..341), data.frfs.lines()) && edge.covers(&(0..340), data.frfs.lines())
    );
    data.set_out_of_band_terms(
        crate::identify::data::out_of_band_basis::OutOfBandTerms::BasisFunctions(Vec::new()),
    );
    assert!(!window.is_of(&data));
}

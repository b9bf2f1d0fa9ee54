//! A compressed band against the lines themselves.

use num_complex::Complex64;

use crate::axis::{Band, FrequencyAxis};
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::fit::compressed_band::{CompressedBand, CompressedValues, KnownResponse};
use crate::identify::fit::fit_data::FitData;
use crate::identify::synthetic::{Measurement, Structure};
use crate::linalg;
use crate::modal::Pole;

const SENSORS: usize = 60;

/// Two modes with large components at the even sensors and small ones at the odd.
fn measured() -> (FitData, [Complex64; 2]) {
    measured_at(50.0)
}

fn measured_at(snr_db: f64) -> (FitData, [Complex64; 2]) {
    let (data, poles) = structure_at(snr_db, &[(100.0, 0.01), (103.0, 0.02)]);
    (data, [poles[0], poles[1]])
}

/// FRFs of modes from 80 to 120 Hz.
fn structure_at(snr_db: f64, modes: &[(f64, f64)]) -> (FitData, Vec<Complex64>) {
    structure_from(80.0, snr_db, modes)
}

/// FRFs of modes in 40 Hz from some frequency on.
fn structure_from(start_hz: f64, snr_db: f64, modes: &[(f64, f64)]) -> (FitData, Vec<Complex64>) {
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
    let mode = |(j, (hz, zeta)): (usize, &(f64, f64))| (*hz, *zeta, shape(0.3 + 0.4 * j as f64));
    let structure = Structure {
        modes: modes.iter().enumerate().map(mode).collect(),
    };
    let axis = FrequencyAxis {
        start_hz,
        step_hz: 0.1,
        len: 401,
    };
    let set = structure.measured(&Measurement {
        snr_db: Some(snr_db),
        seed: 1,
        ..Measurement::of_sensors(SENSORS, axis)
    });
    let band = Band::new(start_hz.max(0.1), start_hz + 40.0).unwrap();
    let data = FitData::guarded(&set, band).unwrap();
    let pole = |(hz, zeta): &(f64, f64)| Pole::from_frequency(*hz, *zeta).lambda;
    (data, modes.iter().map(pole).collect())
}

fn members(poles: &[Complex64]) -> Vec<ModelPole> {
    let root = |lambda: &Complex64| ModelPole::single(*lambda, &[Complex64::ONE], SENSORS);
    poles.iter().map(root).collect()
}

/// Coordinates of all values of a compressed band, with nothing subtracted.
fn all(window: &CompressedBand) -> CompressedValues {
    window.without_known_response(&KnownResponse::new(&[], SENSORS, None), &[])
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
        data.frfs.values.at(f, lines.start + k) / (profile.noise_profile[k] * profile.level[f])
    });
    let coordinates = linalg::thin_qr(&columns).unwrap().q.adjoint() * &values;
    (coordinates.squared_norm_l2(), values.squared_norm_l2())
}

#[test]
fn coordinates_explain_the_same_energy_as_the_lines_for_near_and_for_shifted_poles() {
    let (data, truth) = measured();
    let mut window = CompressedBand::new(&data, &(60..341), &truth, 2);
    // Within range, half a decay rate off one after the other, and back.
    let offsets = [[0.0, 2e-5], [0.5, 2e-5], [0.5, -0.4], [0.0, 0.0]];
    for offsets in offsets {
        let moved = |j: usize| truth[j] + offsets[j] * truth[j].re.abs() * Complex64::new(0.6, 0.8);
        let poles = [0, 1].map(moved);
        window.follow(&data, &poles);
        assert!(!window.follow(&data, &poles));
        let near = all(&window);
        // With the derivatives of both, and with line shapes alone.
        for (moving, powers) in [(&[0, 1][..], 2), (&[], 1)] {
            let (_, explained) = window.compressed(&near, &members(&poles), moving);
            let (expected, all) = energies_from_lines(&data, &window, &poles, powers);
            // Ten digits of the whole: the residual is 1e-5 of it.
            let difference = (explained - expected).abs();
            assert!(difference < 1e-10 * all, "{explained} {expected}");
            assert!((near.energy / all - 1.0).abs() < 1e-10);
        }
    }
}

#[test]
fn truncation_error_of_poles_within_range_is_far_below_the_noise() {
    let (data, truth) = measured_at(90.0);
    let lines = 60..341;
    let window = |offset: f64| {
        let about = truth.map(|lambda| lambda + offset * lambda.re.abs());
        CompressedBand::new(&data, &lines, &about, 2)
    };
    let offsets = (1..2000).map(|step| f64::from(step) * 1e-5);
    let served = offsets.take_while(|offset| !window(*offset).follow(&data, &truth));
    let range = served.last().unwrap();
    // The third power of it is a thousandth of the noise relative to the strongest response; levels
    // are those of 281 lines.
    let strongest = (0..SENSORS).flat_map(|f| {
        let values = data.frfs.values.of(f, lines.clone());
        let pairs = values
            .iter()
            .zip(data.noise.by_frf[f].variances(lines.clone()));
        pairs.map(|(h, v)| h.norm_sqr() / v).collect::<Vec<_>>()
    });
    let expected = (1e-3 / strongest.fold(0.0, f64::max).sqrt()).cbrt();
    assert!((range / expected - 1.0).abs() < 0.15, "{range} {expected}");
    let window = window(range);
    let (_, explained) = window.compressed(&all(&window), &members(&truth), &[]);
    let (expected, _) = energies_from_lines(&data, &window, &truth, 1);
    // A thousandth of the noise, added to noise, in each of the FRFs.
    let difference = (explained - expected).abs();
    assert!(difference < 2e-3 * SENSORS as f64, "{explained} {expected}");
}

#[test]
fn a_compressed_band_is_valid_for_its_noise_and_its_lines_only() {
    let (mut data, truth) = measured();
    let window = CompressedBand::new(&data, &(60..341), &truth, 2);
    assert!(window.is_of(&data));
    assert!(
        window.covers(&(62..340), data.frfs.lines())
            && !window.covers(&(100..340), data.frfs.lines())
    );
    // A band that ends with the data has other out-of-band terms.
    let edge = CompressedBand::new(&data, &(0..341), &truth, 2);
    assert!(
        !edge.covers(&(1..341), data.frfs.lines()) && edge.covers(&(0..340), data.frfs.lines())
    );
    data.set_out_of_band_terms(
        crate::identify::data::out_of_band_basis::OutOfBandTerms::BasisFunctions(Vec::new()),
    );
    assert!(!window.is_of(&data));
}

#[test]
fn segments_explain_the_same_energy_as_the_lines() {
    // Narrow modes and a wide one, near the ends of the data as well: no segment has more than a
    // few of them.
    let narrow = (0..14).map(|j| (81.0 + 2.8 * f64::from(j), 0.001));
    let modes: Vec<(f64, f64)> = narrow.chain([(99.0, 0.08)]).collect();
    let (data, truth) = structure_at(80.0, &modes);
    let lines = 0..data.frfs.lines();
    let mut window = CompressedBand::new(&data, &lines, &truth, truth.len());
    window = window.in_segments(&data, &truth, 8);
    // Three decay rates off, the wide mode is beyond the data, and hardly differs from the
    // out-of-band terms: what it alone explains has an error of rounding and truncation.
    for (offset, tolerance) in [(0.0, 1e-12), (0.3, 1e-10), (3.0, 1e-7)] {
        let moved = |lambda: &Complex64| lambda + Complex64::new(0.0, offset * lambda.re);
        let poles: Vec<Complex64> = truth.iter().map(moved).collect();
        window.follow(&data, &poles);
        let near = all(&window);
        for (moving, powers) in [((0..poles.len()).collect::<Vec<_>>(), 2), (Vec::new(), 1)] {
            let (_, explained) = window.compressed(&near, &members(&poles), &moving);
            let (expected, all) = energies_from_lines(&data, &window, &poles, powers);
            let difference = (explained - expected).abs();
            assert!(difference < tolerance * all, "{explained} {expected} {all}");
            assert!((near.energy / all - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn other_poles_conjugates_and_out_of_band_terms_are_subtracted_as_on_the_lines() {
    // Conjugates of modes near 0 Hz are near the lines, which begin beside the end of the data.
    let (data, truth) = structure_from(0.0, 80.0, &[(2.0, 0.1), (9.0, 0.02), (30.0, 0.01)]);
    let mut poles = members(&truth);
    for (j, pole) in poles.iter_mut().enumerate() {
        for (f, residue) in pole.residues.iter_mut().enumerate() {
            *residue = Complex64::from_polar(1e-4, (3 * j + f) as f64);
        }
    }
    let conjugates = truth.iter().map(Complex64::conj);
    let evaluated: Vec<Complex64> = truth.iter().copied().chain(conjugates).collect();
    let fit = data.out_of_band_fit();
    let out_of_band = fit.residual_coordinates(&poles);
    let all = data.frfs.lines();
    for lines in [0..200, 3..250, 0..all, 0..all - 2, all - 40..all - 1] {
        let window = CompressedBand::new(&data, &lines, &evaluated, 1);
        let known = KnownResponse::new(&poles, SENSORS, Some(&out_of_band));
        let near = window.without_known_response(&known, &[1]);
        let profile = window.profile();
        let mut expected = 0.0;
        for f in 0..SENSORS {
            for (i, k) in lines.clone().enumerate() {
                let s = Complex64::new(0.0, data.frfs.omega[k]);
                let mut value = data.frfs.values.at(f, k);
                for (j, pole) in poles.iter().enumerate() {
                    let residue = pole.residues[f];
                    value -= residue.conj() / (s - pole.lambda.conj());
                    if j != 1 {
                        value -= residue / (s - pole.lambda);
                    }
                }
                for c in 0..out_of_band.nrows() {
                    value -= fit.columns()[(k, c)] * out_of_band[(c, f)];
                }
                expected +=
                    value.norm_sqr() / (profile.noise_profile[i] * profile.level[f]).powi(2);
            }
        }
        let error = (near.energy / expected - 1.0).abs();
        assert!(error < 1e-9, "{lines:?}: {error:e}");
    }
}

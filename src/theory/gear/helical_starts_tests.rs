//! The helical planetary gear without damping from three starts, as the paper may have computed it,
//! against the reference.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::helical_mesh::Detail;
use super::helical_motion::{COORDINATES, Motion};
use super::helical_response::run;
use super::helical_response_tests::{ANGLES, nominal_motion};
use crate::linalg::{least_squares_real, real_matrix};
use crate::theory::integrate::Equations;
use crate::theory::response::{ResponseSignal, ResponseSpan};
use crate::theory::{DetailResponse, HelicalPlanetary};

/// The reference's runs: forty periods, recorded from the first.
const SPAN: ResponseSpan = ResponseSpan {
    settling_periods: 0,
    recorded_periods: 40,
    step_radians: 0.3,
};

/// Speeds of all bodies at the start of a run.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// Steady rotation under the mean mesh stiffness.
    Equilibrium,
    /// Steady rotation with nothing deflected.
    Undeflected,
    /// The carrier turns; sun and planets do not, the planets against it.
    CarrierAlone,
}

impl Start {
    fn state(self, motion: &Motion) -> Vec<f64> {
        let mut state = vec![0.0; 2 * COORDINATES];
        match self {
            Start::Equilibrium => return settled(motion),
            Start::Undeflected => {}
            Start::CarrierAlone => {
                state[COORDINATES + 5] = -(1.0 + 83.0 / 21.0) * motion.speed_rad_s;
                for planet in 0..4 {
                    state[COORDINATES + 8 + 3 * planet] = -83.0 / 31.0 * motion.speed_rad_s;
                }
            }
        }
        state
    }
}

/// The state in which the motion rests under mean mesh stiffnesses, by its angles: Newton's
/// iteration from that of the constant angle, over the displacements that all planets share.
fn settled(motion: &Motion) -> Vec<f64> {
    let steady = motion.clone().with_steady_meshes();
    let mut state = steady.equilibrium();
    let with = |state: &[f64], i: usize, by: f64| {
        let mut moved = state.to_vec();
        match i {
            3 => moved[5] += by,
            _ => (0..4).for_each(|planet| moved[6 + 3 * planet + i] += by),
        }
        moved
    };
    let accelerations = |state: &[f64]| {
        let mut rate = vec![0.0; state.len()];
        steady.rate(0.0, state, &mut rate);
        [6, 7, 8, 5].map(|i| rate[COORDINATES + i])
    };
    for _ in 0..4 {
        let h = 1e-7;
        let slopes: Vec<[f64; 4]> = (0..4)
            .map(|i| {
                let [up, down] = [h, -h].map(|by| accelerations(&with(&state, i, by)));
                std::array::from_fn(|k| (up[k] - down[k]) / (2.0 * h))
            })
            .collect();
        let residual = accelerations(&state);
        let jacobian = real_matrix(4, 4, |row, column| slopes[column][row]);
        for (i, by) in least_squares_real(&jacobian, &residual)
            .unwrap()
            .into_iter()
            .enumerate()
        {
            state = with(&state, i, -by);
        }
    }
    state
}

/// Lines above 1 % of the largest in the spectrum of a whole record, up to `count` of them.
fn lines(samples: &[f64], count: usize) -> usize {
    // Sums over every n2-th sample first, which repeat after n1 lines.
    let n = samples.len();
    let n1 = (1..)
        .find(|n1| n.is_multiple_of(*n1) && n1 * n1 >= n)
        .unwrap();
    let n2 = n / n1;
    let table: Vec<(f64, f64)> = (0..n)
        .map(|i| (TAU * i as f64 / n as f64).sin_cos())
        .collect();
    let sum = |terms: &mut dyn Iterator<Item = ((f64, f64), usize)>| {
        terms.fold((0.0, 0.0), |(re, im), ((x, y), turn)| {
            let (sin, cos) = table[turn % n];
            (re + x * cos + y * sin, im + y * cos - x * sin)
        })
    };
    let inner = |k: usize, b: usize| {
        let terms = (0..n1).map(|a| ((samples[a * n2 + b], 0.0), a * k * n2));
        sum(&mut terms.into_iter())
    };
    let partial: Vec<Vec<(f64, f64)>> = (0..n1)
        .into_par_iter()
        .map(|k| (0..n2).map(|b| inner(k, b)).collect())
        .collect();
    let amplitude = |k: usize| {
        let (re, im) = sum(&mut (0..n2).map(|b| (partial[k % n1][b], b * k)));
        re.hypot(im)
    };
    let all: Vec<f64> = (1..=count).map(amplitude).collect();
    let largest = all.iter().copied().fold(0.0, f64::max);
    all.iter()
        .filter(|amplitude| **amplitude > 0.01 * largest)
        .count()
}

/// rms, standard deviation, largest and least of the sun mesh's deflection, m; largest change of
/// its angle, deg; lines of its spectrum above 1 %; standard deviation of the sun's x, m; least and
/// largest load sharing, where no mesh is unloaded.
type Row = ([f64; 4], f64, usize, f64, Option<[f64; 2]>);
/// Printed and exact angle against the constant one: distance, changes of standard deviation and of
/// the largest, and of the standard deviation of the sun's x.
type Change = [f64; 4];

/// So many digits, as a number has them that begins with 1; of changes no more than 1e-9, which
/// rounding leaves.
fn digits(got: f64, expected: f64, digits: i32, about: &dyn std::fmt::Debug) {
    let rounding = if digits < 5 { 1e-9 } else { 0.0 };
    let limit = 0.51 * 10f64.powi(1 - digits) * expected.abs() + rounding;
    assert!(
        (got - expected).abs() <= limit,
        "{about:?}: {got:e} {expected:e}"
    );
}

fn check(set: &str, start: Start, steps: usize, rows: [Row; 3], changes: [Change; 2]) {
    let model = HelicalPlanetary::new(set).unwrap();
    let details: Vec<DetailResponse> = ANGLES
        .par_iter()
        .map(|detail| {
            let motion = nominal_motion(&model, *detail).undamped();
            run(&motion, start.state(&motion), SPAN, steps)
        })
        .collect();
    let signal = |detail: usize, name: &str| details[detail].signal(name).unwrap();
    for (detail, (mesh, angle, count, sun, load)) in rows.into_iter().enumerate() {
        let about = (set, start, ANGLES[detail]);
        let ds = signal(detail, "delta_sp1");
        let got = [ds.rms(), ds.deviation(), ds.largest(), ds.least()];
        for (got, wanted) in got.iter().zip(mesh) {
            digits(*got, wanted, 6, &about);
        }
        if ANGLES[detail] != Detail::ConstantAngle {
            digits(signal(detail, "angle_sp1").magnitude(), angle, 5, &about);
        }
        // 22 kHz, twice the highest natural frequency.
        assert_eq!(lines(&ds.samples, 8000), count, "{about:?}");
        digits(signal(detail, "x_s").deviation(), sun, 5, &about);
        if let Some([least, most]) = load {
            let load_signal = signal(detail, "load_sp1");
            assert!(
                (load_signal.least() - least).abs() < 5.1e-5,
                "{about:?}: {}",
                load_signal.least()
            );
            assert!(
                (load_signal.largest() - most).abs() < 5.1e-5,
                "{about:?}: {}",
                load_signal.largest()
            );
        }
    }
    for (detail, change) in [1, 2].into_iter().zip(changes) {
        let about = (set, start, ANGLES[detail], "against the constant angle");
        let ratio = |name: &str, figure: fn(&ResponseSignal) -> f64| {
            figure(signal(detail, name)) / figure(signal(0, name)) - 1.0
        };
        let got = [
            signal(detail, "delta_sp1")
                .difference(signal(0, "delta_sp1"))
                .unwrap(),
            ratio("delta_sp1", ResponseSignal::deviation),
            ratio("delta_sp1", ResponseSignal::largest),
            ratio("x_s", ResponseSignal::deviation),
        ];
        for (got, wanted) in got.iter().zip(change) {
            digits(*got, wanted, 4, &about);
        }
    }
}

#[test]
fn undamped_from_the_equilibrium_the_reference_has_181_and_182_lines() {
    check(
        "kb-1.5e8",
        Start::Equilibrium,
        2000,
        [
            (
                [1.924693e-7, 4.944325e-8, 3.330998e-7, 4.864500e-8],
                0.0,
                181,
                8.3301e-8,
                Some([0.3906, 1.6405]),
            ),
            (
                [1.924691e-7, 4.944175e-8, 3.332542e-7, 4.884779e-8],
                5.3134e-4,
                182,
                8.3197e-8,
                Some([0.3921, 1.6420]),
            ),
            (
                [1.924692e-7, 4.944250e-8, 3.331826e-7, 4.874303e-8],
                5.3174e-4,
                182,
                8.3249e-8,
                Some([0.3913, 1.6413]),
            ),
        ],
        [
            [2.057e-3, -3.030e-5, 4.634e-4, -1.243e-3],
            [1.029e-3, -1.511e-5, 2.485e-4, -6.201e-4],
        ],
    );
}

#[test]
fn undamped_from_rest_of_all_deflections_it_is_the_reference() {
    check(
        "kb-1.5e8",
        Start::Undeflected,
        2000,
        [
            (
                [2.128492e-7, 1.034511e-7, 4.834131e-7, -1.197619e-7],
                0.0,
                188,
                1.7634e-7,
                None,
            ),
            (
                [2.128480e-7, 1.034486e-7, 4.834940e-7, -1.197342e-7],
                1.1824e-3,
                186,
                1.7638e-7,
                None,
            ),
            (
                [2.128486e-7, 1.034498e-7, 4.834537e-7, -1.197492e-7],
                1.1825e-3,
                187,
                1.7636e-7,
                None,
            ),
        ],
        [
            [3.636e-3, -2.481e-5, 1.674e-4, 2.198e-4],
            [1.818e-3, -1.246e-5, 8.397e-5, 1.104e-4],
        ],
    );
}

#[test]
fn undamped_from_the_speed_of_the_carrier_alone_teeth_would_part_as_in_the_reference() {
    check(
        "kb-1.5e8",
        Start::CarrierAlone,
        2000,
        [
            (
                [1.144376e-5, 1.144224e-5, 4.145827e-5, -3.865964e-5],
                0.0,
                526,
                8.7933e-6,
                None,
            ),
            (
                [1.145287e-5, 1.145135e-5, 4.068778e-5, -3.849088e-5],
                1.0136e-1,
                530,
                8.7936e-6,
                None,
            ),
            (
                [1.144777e-5, 1.144625e-5, 4.108100e-5, -3.829964e-5],
                1.0212e-1,
                528,
                8.7900e-6,
                None,
            ),
        ],
        [
            [3.371e-2, 7.960e-4, -1.858e-2, 3.982e-5],
            [1.616e-2, 3.504e-4, -9.100e-3, -3.708e-4],
        ],
    );
}

#[test]
fn undamped_with_stiff_bearings_all_angles_are_alike_as_in_the_reference() {
    check(
        "kb-1e10",
        Start::Equilibrium,
        4000,
        [
            (
                [1.825379e-7, 2.797590e-8, 2.769154e-7, 1.095721e-7],
                0.0,
                331,
                2.5120e-9,
                Some([0.5628, 1.4831]),
            ),
            (
                [1.825379e-7, 2.797590e-8, 2.769170e-7, 1.095479e-7],
                4.2322e-5,
                331,
                2.5120e-9,
                Some([0.5627, 1.4831]),
            ),
            (
                [1.825379e-7, 2.797590e-8, 2.769162e-7, 1.095600e-7],
                4.2317e-5,
                331,
                2.5120e-9,
                Some([0.5628, 1.4831]),
            ),
        ],
        [
            [6.217e-5, 1.888e-7, 5.808e-6, 1.175e-5],
            [3.109e-5, 9.414e-8, 2.914e-6, 5.867e-6],
        ],
    );
}

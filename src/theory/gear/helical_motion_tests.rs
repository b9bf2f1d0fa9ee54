//! The equations of motion of the helical planetary gear: gradients, energy, orders, and the
//! reference's snapshots.

use super::helical_checks::{energy_drift, run};
use super::helical_mesh::{Detail, MeshGeometry};
use super::helical_motion::Motion;
use crate::theory::integrate::{Equations, ExtrapolatedMidpoint, Integrator, RungeKutta4};
use crate::theory::parameter::{index_of, nominal_values};
use crate::theory::{HelicalPlanetary, TheoreticalModel};

fn motion(set: &str, detail: Detail, changes: &[(&str, f64)]) -> Motion {
    let model = HelicalPlanetary::new(set).unwrap();
    let mut values = nominal_values(model.parameters());
    for (name, value) in changes {
        values[index_of("test", model.parameters(), name).unwrap()] = *value;
    }
    Motion::new(&model, &values, detail).unwrap()
}

#[test]
fn gradients_of_the_approach_are_its_differences_and_the_printed_one_doubles_the_second_order() {
    let motion_of = |side| {
        MeshGeometry::new(
            side,
            0.07556497069671986,
            0.36035632401741163,
            0.08075154207198648,
        )
    };
    for side in [1.0, -1.0] {
        let mesh = motion_of(side);
        for detail in [
            Detail::ConstantAngle,
            Detail::PrintedAngle,
            Detail::ExactAngle,
        ] {
            let (u, v) = (mesh.pins + 3e-4, -2e-4);
            let approach = mesh.approach(detail, u, v);
            let h = 2e-7;
            let by_u = mesh.approach(detail, u + h, v).compression
                - mesh.approach(detail, u - h, v).compression;
            let by_v = mesh.approach(detail, u, v + h).compression
                - mesh.approach(detail, u, v - h).compression;
            assert!(
                (approach.by_u - by_u / (2.0 * h)).abs() < 1e-9,
                "{side} {detail:?}"
            );
            assert!(
                (approach.by_v - by_v / (2.0 * h)).abs() < 1e-9,
                "{side} {detail:?}"
            );
        }
        // The planet moved by s(0.6, 0.8).
        for (s, expected) in [(1e-5, [1.999576, 1.999927]), (1e-6, [1.999959, 1.999993])] {
            let at = |detail| {
                mesh.approach(detail, mesh.pins + 0.6 * s, 0.8 * s)
                    .compression
            };
            let constant = at(Detail::ConstantAngle);
            let ratio = (at(Detail::PrintedAngle) - constant) / (at(Detail::ExactAngle) - constant);
            let expected = expected[if side > 0.0 { 0 } else { 1 }];
            // Differences of 1e-12 m and less of numbers of 0.08 m: rounding 1e-17 m.
            assert!(
                (ratio - expected).abs() < 2e-4 * (1e-5 / s),
                "{side} {s}: {ratio}"
            );
        }
    }
}

#[test]
fn the_equilibrium_is_the_reference_and_rests() {
    let motion = motion(
        "kb-1.5e8",
        Detail::ConstantAngle,
        &[("mesh_min", 4e8), ("mesh_max", 4e8)],
    );
    let state = motion.equilibrium();
    for (i, expected) in [
        (6, 5.812015204e-8),
        (7, 8.255782235e-7),
        (5, 6.147291777e-5),
        (8, 2.036654730e-5),
    ] {
        assert!(
            (state[i] / expected - 1.0).abs() < 2e-10,
            "{i}: {}",
            state[i]
        );
    }
    let mut rate = vec![0.0; motion.len()];
    motion.rate(0.123, &state, &mut rate);
    // A centrifugal force of a radius longer by xi, and torques of 40 N m that cancel to rounding
    // over 1e-4 kg m2.
    let largest = rate
        .iter()
        .fold(0.0f64, |most, value| most.max(value.abs()));
    assert!(largest < 1e-4, "{largest}");
}

#[test]
fn without_losses_the_energy_drifts_with_the_order_of_the_integrator() {
    for detail in [
        Detail::ConstantAngle,
        Detail::PrintedAngle,
        Detail::ExactAngle,
    ] {
        let motion = motion("kb-1.5e8", detail, &[("speed", 800.0)]).conservative();
        let mut rule = RungeKutta4::default();
        let coarse = energy_drift(&mut rule, &motion, 4, 250);
        let fine = energy_drift(&mut rule, &motion, 4, 500);
        let order = (coarse / fine).log2();
        assert!(
            (order - 5.0).abs() < 0.2,
            "{detail:?}: {order} {coarse} {fine}"
        );
        let exact = energy_drift(&mut ExtrapolatedMidpoint::default(), &motion, 4, 50);
        assert!(exact < 1e-10, "{detail:?}: {exact}");
    }
}

#[test]
fn after_ten_periods_the_state_is_the_reference_by_both_integrators() {
    let snapshots = [
        (
            Detail::ConstantAngle,
            [
                -7.9556921060e-09,
                5.9827190226e-08,
                -6.3236717645e-08,
                -1.1022460937e-08,
                2.1849759359e-08,
                6.2641966941e-05,
                6.0223389698e-08,
                8.0815500609e-07,
                1.9733943234e-05,
                6.9532430861e-08,
                8.2573620245e-07,
                2.0239996950e-05,
                5.6623250316e-08,
                8.2597231170e-07,
                2.0687700537e-05,
                4.4947097245e-08,
                8.4572648722e-07,
                2.1182568771e-05,
            ],
            [2.1324204022e-7, 1.2823660051e-7],
        ),
        (
            Detail::PrintedAngle,
            [
                -7.9144651186e-09,
                5.9830836791e-08,
                -6.3238114250e-08,
                -1.0991663646e-08,
                2.1834646402e-08,
                6.2641843461e-05,
                6.0220341947e-08,
                8.0816348826e-07,
                1.9733267336e-05,
                6.9507388028e-08,
                8.2575101094e-07,
                2.0240028700e-05,
                5.6592596963e-08,
                8.2596263155e-07,
                2.0688407589e-05,
                4.4937710613e-08,
                8.4570801811e-07,
                2.1182577826e-05,
            ],
            [2.1324706142e-7, 1.2823815927e-7],
        ),
        (
            Detail::ExactAngle,
            [
                -7.9350751618e-09,
                5.9829025240e-08,
                -6.3237417241e-08,
                -1.1007055793e-08,
                2.1842210349e-08,
                6.2641905204e-05,
                6.0221869649e-08,
                8.0815924427e-07,
                1.9733605225e-05,
                6.9519911694e-08,
                8.2574361118e-07,
                2.0240012652e-05,
                5.6607919785e-08,
                8.2596747466e-07,
                2.0688054128e-05,
                4.4942401570e-08,
                8.4571724801e-07,
                2.1182573469e-05,
            ],
            [2.1324454986e-7, 1.2823737922e-7],
        ),
    ];
    for (detail, expected, meshes) in snapshots {
        let motion = motion("kb-1.5e8", detail, &[]);
        let mut state = motion.equilibrium();
        // All corners of the stiffness lie on hundredths of the period.
        run(
            &mut ExtrapolatedMidpoint::default(),
            &motion,
            10,
            400,
            &mut state,
        );
        let followed = state.clone();
        // With a varying angle the free rotation of all bodies, which nothing holds, is off by
        // 1e-10 rad.
        let turn = state[2] - expected[2];
        assert!(turn.abs() < 1.3e-10, "{detail:?}: {turn}");
        state[2] -= turn;
        state[5] -= (1.0 + 83.0 / 21.0) * turn;
        (0..4).for_each(|planet| state[8 + 3 * planet] -= 83.0 / 31.0 * turn);
        for (i, wanted) in expected.iter().enumerate() {
            // The reference's Runge-Kutta method has an error of 4e-10 of the largest displacement
            // left, 1e-6 m.
            assert!(
                (state[i] - wanted).abs()
                    < 3e-9 * wanted.abs() + if i % 3 == 2 { 2e-14 } else { 1e-15 },
                "{detail:?} {i}: {} {wanted}",
                state[i]
            );
        }
        let state = followed;
        let time = 10.0 * motion.mesh_period_s();
        for (got, wanted) in motion.meshes(time, &state, 0).iter().zip(meshes) {
            assert!(
                (got.compression_m / wanted - 1.0).abs() < 2e-9,
                "{detail:?}: {}",
                got.compression_m
            );
        }
        if detail == Detail::ConstantAngle {
            let mut other = motion.equilibrium();
            run(&mut RungeKutta4::default(), &motion, 10, 8000, &mut other);
            let compression = motion.meshes(time, &state, 0)[0].compression_m;
            let theirs = motion.meshes(time, &other, 0)[0].compression_m;
            assert!(
                (compression / theirs - 1.0).abs() < 1e-8,
                "{compression} {theirs}"
            );
        }
    }
}

#[test]
fn with_stiff_bearings_the_motion_becomes_the_torsional_one() {
    let torsional = motion("torsional", Detail::Torsional, &[]);
    let deflection = |motion: &Motion| {
        let mut state = motion.equilibrium();
        let mut rule = ExtrapolatedMidpoint::default();
        run(&mut rule, motion, 1, 1000, &mut state);
        motion.meshes(motion.mesh_period_s(), &state, 0)[0].compression_m
    };
    let limit = deflection(&torsional);
    let changes = |k| [("k_c", k), ("k_s", k), ("k_p", k)];
    let distance = |k| {
        (deflection(&motion("kb-1e10", Detail::ConstantAngle, &changes(k))) / limit - 1.0).abs()
    };
    let (soft, hard) = (distance(1e10), distance(4e10));
    assert!(soft < 0.2 && hard < 0.35 * soft, "{soft} {hard}");
}

#[test]
fn errors_of_the_runge_kutta_method_over_twenty_periods_are_the_reference() {
    const RECORDED_INSTANTS: usize = 200;
    let motion = motion("kb-1.5e8", Detail::ConstantAngle, &[]);
    let deflection = |steps: usize| -> Vec<f64> {
        let (mut rule, mut state) = (RungeKutta4::default(), motion.equilibrium());
        let step_s = motion.mesh_period_s() / steps as f64;
        let mut compressions = Vec::new();
        for step in 0..20 * steps {
            let time_s = step as f64 * step_s;
            if step.is_multiple_of(steps / RECORDED_INSTANTS) {
                compressions.push(motion.meshes(time_s, &state, 0)[0].compression_m);
            }
            rule.step(&motion, time_s, step_s, &mut state);
        }
        compressions
    };
    let fine = deflection(8000);
    let largest = fine.iter().copied().fold(0.0, f64::max);
    for (steps, expected) in [
        (200, 1.024e-1),
        (400, 6.041e-3),
        (1000, 1.282e-4),
        (2000, 7.597e-6),
        (4000, 4.292e-7),
    ] {
        let coarse = deflection(steps);
        let pairs = coarse.iter().zip(&fine);
        let error = pairs.fold(0.0f64, |most, (a, b)| most.max((a - b).abs())) / largest;
        assert!((error / expected - 1.0).abs() < 6e-4, "{steps}: {error:e}");
    }
}

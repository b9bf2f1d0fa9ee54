//! Results are compared with a baseline: how often a correct one is refused, and which errors each
//! row detects.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use modalign::Dof;
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::scene::{ChangeLimits, RowVerdict, check_changes, mode_changes};

const POINTS: usize = 10;
const SHAPE_STD: f64 = 0.01;

/// The stated deviations alone.
fn limits(false_refusals: f64) -> ChangeLimits {
    ChangeLimits {
        frequency_floor: 0.0,
        damping_floor: 0.0,
        shape_floor: 0.0,
        false_refusals,
        ..ChangeLimits::default()
    }
}

fn dof(point: usize) -> Dof {
    format!("{}:+Z", point + 1).parse().unwrap()
}

/// Six modes with stated deviations, without noise.
fn truth() -> ModalModel {
    let mode = |number: usize| {
        let value = |point: usize| (0.7 * (number + 1) as f64 * point as f64 + 0.3).cos();
        let shape = ModeShape::new(
            (0..POINTS).map(|point| (dof(point), Complex64::new(value(point), 0.0))),
        );
        Mode {
            frequency_std_hz: Some(0.002 * (number + 1) as f64),
            damping_std: Some(1e-4),
            shape_std: Some((0..POINTS).map(|point| (dof(point), SHAPE_STD)).collect()),
            ..Mode::new(
                100.0 * (number + 1) as f64,
                Some(0.01),
                shape,
                Scaling::Unknown,
            )
        }
    };
    ModalModel {
        modes: (0..6).map(mode).collect(),
        ..ModalModel::default()
    }
}

/// The truth with the errors of a test: every value with a random error of its standard deviation,
/// and an arbitrary scale of the shapes.
fn seen(truth: &ModalModel, rng: &mut ChaCha8Rng) -> ModalModel {
    let mut model = truth.clone();
    for mode in &mut model.modes {
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        mode.frequency_hz += mode.frequency_std_hz.unwrap() * normal();
        mode.damping_ratio = mode
            .damping_ratio
            .map(|ratio| ratio + mode.damping_std.unwrap() * normal());
        let scale = Complex64::from_polar(2.0, 3.0 * normal());
        let mut off = |(dof, value): (&Dof, Complex64)| {
            let noise = Complex64::new(normal(), normal()) * SHAPE_STD;
            (dof.clone(), scale * (value + noise))
        };
        mode.shape = ModeShape::new(mode.shape.iter().map(&mut off).collect::<Vec<_>>());
        for std in mode.shape_std.iter_mut().flat_map(|stds| stds.values_mut()) {
            *std *= 2.0;
        }
    }
    model
}

fn missed(rows: &[RowVerdict]) -> Vec<String> {
    let missed = rows.iter().filter(|row| !row.is_met());
    missed.map(|row| row.row.clone()).collect()
}

#[test]
fn a_perfect_result_is_refused_as_often_as_stated() {
    let (truth, draws, stated) = (truth(), 4000, 0.05);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut refused = 0;
    for _ in 0..draws {
        let (now, before) = (seen(&truth, &mut rng), seen(&truth, &mut rng));
        let rows = check_changes(&mode_changes(&now, &before, &limits(stated)), stated);
        assert_eq!(rows.len(), 6);
        refused += usize::from(!missed(&rows).is_empty());
    }
    // Binomial, four standard deviations either way.
    let (expected, std) = (
        stated * f64::from(draws),
        (stated * (1.0 - stated) * f64::from(draws)).sqrt(),
    );
    assert!(
        (refused as f64 - expected).abs() < 4.0 * std,
        "{refused} of {draws}, stated {stated}"
    );
}

/// The rows that are missed when `harm` befalls a result that is else off by noise alone.
fn missed_after(seed: u64, harm: impl Fn(&mut ModalModel)) -> Vec<String> {
    let (truth, mut rng) = (truth(), ChaCha8Rng::seed_from_u64(seed));
    let (mut now, before) = (seen(&truth, &mut rng), seen(&truth, &mut rng));
    harm(&mut now);
    let limits = ChangeLimits {
        false_refusals: 1e-6,
        ..ChangeLimits::default()
    };
    missed(&check_changes(
        &mode_changes(&now, &before, &limits),
        limits.false_refusals,
    ))
}

#[test]
fn the_floors_refuse_less_and_never_more() {
    let (truth, mut rng) = (truth(), ChaCha8Rng::seed_from_u64(2));
    for _ in 0..300 {
        let (now, before) = (seen(&truth, &mut rng), seen(&truth, &mut rng));
        let refused = |limits: ChangeLimits| {
            let rows = check_changes(&mode_changes(&now, &before, &limits), limits.false_refusals);
            !missed(&rows).is_empty()
        };
        let with_floors = ChangeLimits {
            false_refusals: 0.2,
            ..ChangeLimits::default()
        };
        assert!(refused(limits(0.2)) || !refused(with_floors));
    }
}

#[test]
fn a_wrong_value_is_detected_in_its_row() {
    for seed in 0..200 {
        assert!(missed_after(seed, |_| ()).is_empty(), "noise alone");
        let row = |number: usize, rows: &[String]| {
            rows.len() == 1 && rows[0].starts_with(&format!("mode {number} at "))
        };
        let shifted = missed_after(seed, |now| now.modes[2].frequency_hz *= 1.002);
        assert!(row(3, &shifted), "{shifted:?}");
        let lost = missed_after(seed, |now| drop(now.modes.remove(4)));
        assert!(row(5, &lost), "{lost:?}");
        let swapped = missed_after(seed, |now| {
            let shape = now.modes[0].shape.clone();
            now.modes[0].shape = std::mem::replace(&mut now.modes[1].shape, shape);
        });
        assert_eq!(swapped.len(), 2, "{swapped:?}");
        let sign = missed_after(seed, |now| {
            let turned = |(dof, value): (&Dof, Complex64)| {
                (
                    dof.clone(),
                    if *dof == self::dof(3) { -value } else { value },
                )
            };
            let shape: Vec<_> = now.modes[1].shape.iter().map(turned).collect();
            now.modes[1].shape = ModeShape::new(shape);
        });
        assert!(row(2, &sign), "{sign:?}");
        let extra = missed_after(seed, |now| {
            let mode = Mode {
                frequency_hz: 250.0,
                ..now.modes[1].clone()
            };
            now.modes.insert(2, mode);
        });
        assert_eq!(extra, ["extra mode at 250 Hz"]);
        let sensor = missed_after(seed, |now| {
            let shape: Vec<_> = now.modes[5]
                .shape
                .iter()
                .skip(1)
                .map(|(dof, value)| (dof.clone(), value))
                .collect();
            now.modes[5].shape = ModeShape::new(shape);
        });
        assert!(row(6, &sensor), "{sensor:?}");
    }
}

#[test]
fn deviations_may_change_by_their_scatter_and_no_more() {
    for seed in 0..50 {
        let assert_missed = |number: usize, harm: &dyn Fn(&mut Mode)| {
            let rows = missed_after(seed, |now| harm(&mut now.modes[number - 1]));
            let row = format!("mode {number} at ");
            assert!(rows.len() == 1 && rows[0].starts_with(&row), "{rows:?}");
        };
        // Wrong values that the deviation would excuse.
        assert_missed(2, &|mode| {
            mode.frequency_hz *= 1.01;
            mode.frequency_std_hz = Some(1e9);
        });
        assert_missed(3, &|mode| {
            mode.damping_ratio = Some(0.02);
            mode.damping_bias = Some(1.0);
        });
        assert_missed(4, &|mode| {
            for std in mode.shape_std.iter_mut().flat_map(|stds| stds.values_mut()) {
                *std *= 1e6;
            }
        });
        assert_missed(4, &|mode| {
            let stds = mode.shape_std.as_mut().unwrap();
            stds.insert(dof(2), 1e6);
        });
        assert_missed(5, &|mode| mode.shape_std = None);
        assert_missed(5, &|mode| mode.frequency_std_hz = None);
        assert_missed(6, &|mode| mode.frequency_std_hz = Some(1.0));
        // Twice as many impacts, or half of them.
        for factor in [0.7, 1.4] {
            let rows = missed_after(seed, |now| {
                for mode in &mut now.modes {
                    mode.frequency_std_hz = mode.frequency_std_hz.map(|std| factor * std);
                    mode.damping_std = mode.damping_std.map(|std| factor * std);
                }
            });
            assert!(rows.is_empty(), "{rows:?}");
        }
    }
}

#[test]
fn without_stated_deviations_absolute_limits_hold() {
    let mut before = truth();
    for mode in &mut before.modes {
        (mode.frequency_std_hz, mode.damping_std, mode.shape_std) = (None, None, None);
    }
    let judged = |harm: &dyn Fn(&mut ModalModel), limits: ChangeLimits| {
        let mut now = before.clone();
        harm(&mut now);
        missed(&check_changes(
            &mode_changes(&now, &before, &limits),
            limits.false_refusals,
        ))
        .len()
    };
    let shift = |by: f64| move |now: &mut ModalModel| now.modes[1].frequency_hz *= 1.0 + by;
    assert_eq!(judged(&|_| (), limits(0.01)), 0);
    assert_eq!(judged(&shift(4.9e-4), limits(0.01)), 0);
    assert_eq!(judged(&shift(5.1e-4), limits(0.01)), 1);
    let tight = ChangeLimits {
        frequency_percent: Some(0.01),
        ..limits(0.01)
    };
    assert_eq!(judged(&shift(2e-4), tight), 1);
    // One of ten components of the other sign, in a shape of many points where the MAC alone would
    // pass.
    let sign = |now: &mut ModalModel| {
        let turned = |(dof, value): (&Dof, Complex64)| {
            (
                dof.clone(),
                if *dof == self::dof(0) { -value } else { value },
            )
        };
        let shape: Vec<_> = now.modes[0].shape.iter().map(turned).collect();
        now.modes[0].shape = ModeShape::new(shape);
    };
    let loose = ChangeLimits {
        mac: Some(1.0),
        ..limits(0.01)
    };
    assert_eq!(judged(&sign, loose), 1);
}

#[test]
fn a_repeated_root_may_turn_within_its_plane_and_not_out_of_it() {
    let mut before = truth();
    before.modes[1].frequency_hz = before.modes[0].frequency_hz;
    (before.modes[0].group, before.modes[1].group) = (Some(1), Some(1));
    let turned = |third: f64| {
        let mut now = before.clone();
        let (a, b, c) = (
            &before.modes[0].shape,
            &before.modes[1].shape,
            &before.modes[2].shape,
        );
        let mix = |x: f64, y: f64| {
            let value = |dof: &Dof| {
                a.get(dof).unwrap() * x + b.get(dof).unwrap() * y + c.get(dof).unwrap() * third
            };
            ModeShape::new((0..POINTS).map(|point| (dof(point), value(&dof(point)))))
        };
        (now.modes[0].shape, now.modes[1].shape) = (mix(0.6, 0.8), mix(-0.8, 0.6));
        missed(&check_changes(
            &mode_changes(&now, &before, &limits(0.01)),
            0.01,
        ))
        .len()
    };
    assert_eq!(turned(0.0), 0);
    assert_eq!(turned(0.5), 2);
}

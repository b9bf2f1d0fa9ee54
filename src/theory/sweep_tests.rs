//! Loci tracked through crossings and veerings: two-degree models in closed form, the torsional
//! gear and the cycloid ball transmission against their references.

use std::f64::consts::TAU;

use super::parameter::{index_of, nominal_values};
use super::{
    BUILT_IN, EventKind, LumpedModel, Sweep, SweepRange, TheoreticalModel, TheoryError, built_in,
    model_roots, modes, sweep,
};

fn swept(
    model: &dyn TheoreticalModel,
    name: &str,
    (lower, upper, count): (f64, f64, usize),
) -> Sweep {
    let values = nominal_values(model.parameters());
    sweep(
        model,
        &values,
        name,
        SweepRange {
            lower,
            upper,
            count,
        },
        None,
    )
    .unwrap()
}

/// Kind, place, gap of every event.
fn events_of(sweep: &Sweep) -> Vec<(EventKind, f64, f64)> {
    let all = sweep.events.iter();
    all.map(|event| (event.kind, event.place, event.gap_hz))
        .collect()
}

/// All roots at every value, sorted, are those that a solver gives there: none lost, none twice.
fn check_complete(model: &dyn TheoreticalModel, sweep: &Sweep) {
    let j = index_of("test", model.parameters(), &sweep.parameter.name).unwrap();
    for (i, &value) in sweep.values.iter().enumerate() {
        let mut values = nominal_values(model.parameters());
        values[j] = value;
        let modes = modes(model, &values, &[], &Default::default()).unwrap();
        let mut expected = modes.omega_rad_s.clone();
        expected.sort_by(f64::total_cmp);
        let each = sweep.loci.iter();
        let mut got: Vec<f64> = each
            .flat_map(|locus| vec![locus.omega_rad_s[i].unwrap(); locus.multiplicity[i]])
            .collect();
        got.sort_by(f64::total_cmp);
        assert_eq!(got, expected, "{} = {value}", sweep.parameter.name);
    }
}

/// Two masses of 1 kg on springs of `left` and 100 N/m, joined by one of `joint`: with a = left +
/// joint and b = 100 + joint the eigenvalues are (a + b)/2 -+ sqrt((a - b)^2/4 + joint^2).
fn pair(joint: f64) -> LumpedModel {
    let body = |name: &str, x: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nat_m = [{x:?}, 0.0, 0.0]\nmass_kg = 1.0\nfree = [\"x\"]\n[[point]]\nname = \"{name}\"\nbody = \"{name}\"\nat_m = [{x:?}, 0.0, 0.0]\n"
        )
    };
    let spring = |name: &str, from: &str, to: &str, k: &str| {
        format!(
            "[[spring]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\ndirection = [1.0, 0.0, 0.0]\nstiffness_n_per_m = {k}\n"
        )
    };
    let parameter = "[[parameter]]\nname = \"left\"\nunit = \"N/m\"\nnominal = 50.0\nlower = 1.0\nupper = 1000.0\nstatus = \"assumed\"\n";
    let text = [
        parameter.to_owned(),
        body("one", 0.0),
        body("two", 1.0),
        spring("left", "one", "ground", "\"left\""),
        spring("right", "two", "ground", "100.0"),
        spring("joint", "one", "two", &format!("{joint:?}")),
    ];
    LumpedModel::new(toml::from_str(&text.concat()).unwrap()).unwrap()
}

#[test]
fn two_masses_veer_where_their_springs_are_equal_however_weak_the_joint_and_however_coarse_the_sweep()
 {
    for joint in [1.0, 1e-1, 1e-2, 1e-3] {
        for count in [2, 3, 50] {
            let model = pair(joint);
            let result = swept(&model, "left", (37.0, 181.0, count));
            check_complete(&model, &result);
            let [event] = &result.events[..] else {
                panic!("{joint} {count}: {:?}", result.events);
            };
            assert_eq!(event.kind, EventKind::Veering, "{joint} {count}");
            // d(omega_2 - omega_1)/da = 0: the difference of the eigenvalues is least at a = b, and
            // that of their roots at da = 2 joint^2/(a + b), to the next power of the joint.
            let nearest = 100.0 + joint * joint / 100.0;
            assert!(
                (event.place - nearest).abs() < 0.05 * joint * joint,
                "{} {nearest}",
                event.place
            );
            let gap = ((100.0 + 2.0 * joint).sqrt() - 10.0) / TAU;
            assert!(
                (event.gap_hz / gap - 1.0).abs() < 1e-3 * joint + 1e-7,
                "{} {gap}",
                event.gap_hz
            );
            // Slopes are equal there, and the coupling is half of the change of slope.
            assert!(event.coupling > 1.0 - 1e-3, "{}", event.coupling);
            assert!((event.width.unwrap() / (2.0 * joint) - 1.0).abs() < 1e-2);
        }
    }
}

#[test]
fn two_masses_without_a_joint_cross_and_keep_their_shapes() {
    let model = pair(0.0);
    for count in [2, 3, 64] {
        let result = swept(&model, "left", (30.0, 170.0, count));
        check_complete(&model, &result);
        let [event] = &result.events[..] else {
            panic!("{count}: {:?}", result.events);
        };
        assert_eq!(
            (event.kind, event.gap_hz, event.width),
            (EventKind::Crossing, 0.0, None)
        );
        assert!((event.place - 100.0).abs() < 1e-9, "{}", event.place);
        assert!((event.frequency_hz[0] - 10.0 / TAU).abs() < 1e-9);
        assert!(event.coupling < 1e-20, "{}", event.coupling);
        assert_eq!(event.loci, [0, 1]);
        // The locus of the mass that does not change stays where it is.
        assert!(
            result.loci[1]
                .omega_rad_s
                .iter()
                .flatten()
                .all(|omega| (omega - 10.0).abs() < 1e-12)
        );
        assert!((result.loci[0].omega_rad_s[count - 1].unwrap() - 170.0f64.sqrt()).abs() < 1e-12);
    }
}

#[test]
fn a_sample_exactly_on_a_crossing_does_not_swap_the_modes() {
    let result = swept(&pair(0.0), "left", (50.0, 150.0, 3));
    assert_eq!(events_of(&result).len(), 1);
    assert_eq!(result.events[0].kind, EventKind::Crossing);
    assert!((result.loci[0].omega_rad_s[2].unwrap() - 150.0f64.sqrt()).abs() < 1e-12);
}

#[test]
fn the_torsional_gear_crosses_its_planet_modes_twice_and_veers_between_over_the_ring_mesh() {
    let model = built_in("torsional-planetary/carrier-fixed").unwrap();
    for count in [8, 60, 200] {
        let result = swept(model.as_ref(), "k_r", (1e7, 1e11, count));
        check_complete(model.as_ref(), &result);
        // Free motion, the planet modes (two), the rotational ones.
        let mut multiplicities: Vec<usize> =
            result.loci.iter().map(|l| l.multiplicity[0]).collect();
        multiplicities.sort_unstable();
        assert_eq!(multiplicities, [1, 1, 1, 2], "{count}");
        let kinds: Vec<EventKind> = result.events.iter().map(|event| event.kind).collect();
        assert_eq!(
            kinds,
            [EventKind::Crossing, EventKind::Veering, EventKind::Crossing],
            "{count}"
        );
        let [lower, veering, upper] = &result.events[..] else {
            panic!()
        };
        for (event, place, hz) in [
            (lower, 4.308891e7, 1538.748113),
            (upper, 3.108191e10, 11734.140088),
        ] {
            assert!(
                (event.place / place - 1.0).abs() < 1.5e-7,
                "{} {place}",
                event.place
            );
            assert!(
                (event.frequency_hz[0] - hz).abs() < 1e-5,
                "{:?}",
                event.frequency_hz
            );
            assert!(event.coupling < 1e-12, "{}", event.coupling);
        }
        assert!(
            (veering.place / 2.502803e9 - 1.0).abs() < 4e-7,
            "{}",
            veering.place
        );
        assert!(
            (veering.gap_hz - 415.611341).abs() < 1e-6,
            "{}",
            veering.gap_hz
        );
        assert!(veering.coupling > 0.99, "{}", veering.coupling);
        // The paper's criterion (7) lies inside the width of the veering.
        assert!((veering.place - 2.512238e9).abs() < 0.1 * veering.width.unwrap());
        // The rotational locus that comes from below crosses the planet modes on both sides; the
        // other one never does.
        let planet = result
            .loci
            .iter()
            .position(|locus| locus.multiplicity[0] == 2)
            .unwrap();
        assert!(lower.loci.contains(&planet) && upper.loci.contains(&planet));
        let rotational =
            |loci: [usize; 2]| loci.into_iter().find(|locus| *locus != planet).unwrap();
        assert_eq!(rotational(lower.loci), rotational(upper.loci));
        assert_eq!(rotational(upper.loci), veering.loci[0]);
    }
}

#[test]
fn over_the_sun_the_gear_veers_and_crosses_where_the_reference_has_it() {
    let model = built_in("torsional-planetary/carrier-fixed").unwrap();
    let result = swept(model.as_ref(), "m_s", (0.1, 40.0, 25));
    check_complete(model.as_ref(), &result);
    let [veering, crossing] = &result.events[..] else {
        panic!("{:?}", result.events);
    };
    assert_eq!(
        (veering.kind, crossing.kind),
        (EventKind::Veering, EventKind::Crossing)
    );
    assert!((veering.place - 1.489840).abs() < 6e-7, "{}", veering.place);
    assert!(
        (veering.gap_hz - 415.611341).abs() < 1e-6,
        "{}",
        veering.gap_hz
    );
    assert!(
        (veering.place - 1.521011).abs() < veering.width.unwrap(),
        "{:?}",
        veering.width
    );
    assert!((crossing.place - 15.93).abs() < 6e-7, "{}", crossing.place);
    assert!((crossing.frequency_hz[0] - 2088.007554).abs() < 1e-5);
}

#[test]
fn the_cycloid_mode_that_jumps_crosses_and_does_not_veer() {
    for (set, place, hz) in [
        ("B", 3.192963e7, 65492.213353 / TAU),
        ("D", 2.529523e7, 65468.220541 / TAU),
    ] {
        let model = built_in(&format!("cycloid-ball/{set}")).unwrap();
        let result = swept(model.as_ref(), "k_03y", (1e7, 9e7, 9));
        check_complete(model.as_ref(), &result);
        let at = |hertz: f64| {
            move |event: &&super::LocusEvent| (event.frequency_hz[0] - hertz).abs() < 1e-3
        };
        let jump = result
            .events
            .iter()
            .find(at(hz))
            .unwrap_or_else(|| panic!("{:?}", result.events));
        assert_eq!(jump.kind, EventKind::Crossing);
        assert!(
            (jump.place / place - 1.0).abs() < 3e-7,
            "{set}: {}",
            jump.place
        );
        assert!(jump.coupling < 1e-12, "{}", jump.coupling);
        // The mode that is met does not move at all.
        let met = jump.loci.into_iter().find(|&locus| {
            let all = &result.loci[locus].omega_rad_s;
            all.iter()
                .flatten()
                .all(|omega| (omega / all[0].unwrap() - 1.0).abs() < 1e-9)
        });
        assert!(met.is_some(), "{set}");
    }
}

#[test]
fn over_the_number_of_balls_roots_are_numbered_and_their_multiplicities_reported() {
    let model = built_in("cycloid-ball").unwrap();
    let result = swept(model.as_ref(), "ball_count", (8.0, 14.0, 7));
    assert_eq!(result.values, [8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0]);
    assert!(!result.followed && result.events.is_empty());
    assert_eq!(result.loci.len(), 17);
    let balls = |less: i32| -> Vec<usize> { (8..15).map(|n| (n + less) as usize).collect() };
    for (number, locus) in (1..).zip(&result.loci) {
        let expected = match number {
            1 => balls(1),
            6 => vec![4; 7],
            12 => balls(-2),
            _ => vec![1; 7],
        };
        assert_eq!(locus.multiplicity, expected, "root {number}");
    }
    // The reference's numbers at Z2 = 8, 12 and 14.
    for (number, value, expected) in [
        (3, 0, 13920.975),
        (4, 4, 14370.959),
        (13, 4, 59611.981),
        (14, 6, 65167.516),
    ] {
        let omega = result.loci[number - 1].omega_rad_s[value].unwrap();
        assert!((omega - expected).abs() < 6e-4, "{number}: {omega}");
    }
    // A range of a factor of ten goes on in equal steps.
    let wide = swept(model.as_ref(), "ball_count", (4.0, 40.0, 4));
    assert_eq!(wide.values, [4.0, 16.0, 28.0, 40.0]);
    let values = nominal_values(model.parameters());
    for (lower, upper, count) in [(8.0, 14.0, 5), (8.5, 14.5, 7)] {
        let range = SweepRange {
            lower,
            upper,
            count,
        };
        let error = sweep(model.as_ref(), &values, "ball_count", range, None).unwrap_err();
        let whole = matches!(
            error,
            TheoryError::SweepNotWhole { .. } | TheoryError::NotWhole { .. }
        );
        assert!(whole, "{error}");
    }
}

#[test]
fn every_built_in_model_keeps_its_modes_over_a_stiffness_and_a_mass() {
    for builtin in BUILT_IN {
        let model = built_in(builtin.name).unwrap();
        for prefix in ["k_", "m_"] {
            let spec = model
                .parameters()
                .iter()
                .find(|spec| spec.name.starts_with(prefix));
            let Some(spec) = spec.filter(|spec| spec.nominal > 0.0) else {
                continue;
            };
            let range = (0.5 * spec.nominal, 2.0 * spec.nominal, 4);
            let swept = swept(model.as_ref(), &spec.name, range);
            check_complete(model.as_ref(), &swept);
            let values = nominal_values(model.parameters());
            let solved = modes(model.as_ref(), &values, &[], &Default::default()).unwrap();
            let roots = model_roots(model.as_ref(), &solved).len();
            assert!(swept.loci.len() >= roots, "{} {}", builtin.name, spec.name);
        }
    }
}

#[test]
fn an_empty_or_fractional_range_is_reported() {
    let model = pair(1.0);
    let values = nominal_values(model.parameters());
    for (lower, upper, count) in [
        (2.0, 2.0, 5),
        (3.0, 2.0, 5),
        (1.0, 2.0, 1),
        (f64::NAN, 2.0, 3),
    ] {
        let got = sweep(
            &model,
            &values,
            "left",
            SweepRange {
                lower,
                upper,
                count,
            },
            None,
        );
        assert!(
            matches!(got, Err(TheoryError::SweepRange { .. })),
            "{lower} {upper} {count}"
        );
    }
    let outside = SweepRange {
        lower: 0.5,
        upper: 2.0,
        count: 3,
    };
    assert!(matches!(
        sweep(&model, &values, "left", outside, None),
        Err(TheoryError::OutOfBounds { .. })
    ));
    assert!(matches!(
        sweep(&model, &values, "loft", outside, None),
        Err(TheoryError::UnknownParameter { .. })
    ));
    let range = SweepRange {
        lower: 1.0,
        upper: 100.0,
        count: 3,
    };
    assert_eq!(range.values().len(), 3);
    assert!((range.values()[1] - 10.0).abs() < 1e-12 && range.is_geometric());
    let range = SweepRange {
        lower: 1.0,
        upper: 3.0,
        count: 3,
    };
    assert_eq!(range.values(), [1.0, 2.0, 3.0]);
}

//! Table 2, closed forms, energies and veering of the torsional planetary gear, against an
//! independent computation from the paper's equations, to its printed digits.

use std::f64::consts::TAU;

use crate::geometry::Target;
use crate::theory::parameter::{nominal_values, override_values};
use crate::theory::{
    EventKind, ModeOptions, ModelQuantity, ModelRoot, SweepRange, TheoreticalModel, TheoryError,
    TheoryModes, TorsionalPlanetary, built_in, model_roots, modes, sweep,
};

fn solved(model: &TorsionalPlanetary, changes: &[(&str, f64)]) -> (TheoryModes, Vec<ModelRoot>) {
    let changes = changes.iter().map(|(name, v)| ((*name).to_owned(), *v));
    let values = override_values("gear", model.parameters(), &changes.collect()).unwrap();
    let solved = modes(model, &values, &[], &ModeOptions::default()).unwrap();
    let roots = model_roots(model, &solved);
    (solved, roots)
}

fn quantity(model: &TorsionalPlanetary, name: &str) -> f64 {
    let all = model
        .quantities(&nominal_values(model.parameters()))
        .unwrap();
    let quantity: &ModelQuantity = all.iter().find(|candidate| candidate.name == name).unwrap();
    quantity.value.unwrap()
}

/// The value rounds to the printed text.
fn printed(value: f64, text: &str) {
    let decimals = text.split('.').nth(1).map_or(0, str::len);
    assert_eq!(format!("{value:.decimals$}"), text);
}

/// The value rounds to the text in scientific notation.
fn scientific(value: f64, text: &str) {
    let digits = text.split('e').next().unwrap().len() - 2;
    assert_eq!(format!("{value:.digits$e}"), text);
}

#[test]
fn table_2_has_a_triple_planet_root_among_three_rotational_ones() {
    let (solved, roots) = solved(&TorsionalPlanetary::new("table-2").unwrap(), &[]);
    let expected = [
        ("0.000000", "0.000000000e0", 1, "free motion"),
        ("1671.427105", "1.102896144e8", 1, "rotational mode"),
        ("2088.007554", "1.721170396e8", 3, "planet mode"),
        ("6472.353995", "1.653804850e9", 1, "rotational mode"),
        ("13742.190360", "7.455412150e9", 1, "rotational mode"),
    ];
    assert_eq!((roots.len(), solved.rigid), (5, 1));
    for (root, (hz, lambda, multiplicity, class)) in roots.iter().zip(expected) {
        printed(root.omega_rad_s / TAU, hz);
        assert_eq!(format!("{:.9e}", root.omega_rad_s.powi(2)), lambda);
        assert_eq!(root.modes.len(), multiplicity);
        assert!(root.class.as_ref().unwrap().starts_with(class), "{root:?}");
    }
}

#[test]
fn the_rotational_shapes_are_the_reference() {
    let (solved, roots) = solved(&TorsionalPlanetary::new("table-2").unwrap(), &[]);
    for (root, expected) in [
        (0, ["0.0000000", "1.0000000", "-1.0000000", "1.0000000"]),
        (1, ["1.0000000", "0.9380067", "0.9730797", "-0.0488187"]),
        (3, ["-0.1914996", "1.0000000", "-0.1403873", "-0.0662353"]),
        (4, ["-0.0351877", "0.0044059", "1.0000000", "0.0117638"]),
    ] {
        let shape: Vec<f64> = (0..4)
            .map(|i| solved.vectors[(i, roots[root].modes[0])])
            .collect();
        let largest = shape
            .iter()
            .copied()
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        // The sign of a shape is free.
        let sign = if expected[1] == "1.0000000" && shape[1] * largest < 0.0 {
            -1.0
        } else {
            1.0
        };
        for (value, text) in shape.iter().zip(expected) {
            let scaled = sign * value / largest;
            let wanted: f64 = text.parse().unwrap();
            assert!((scaled - wanted).abs() <= 5.1e-8, "{scaled} {text}");
        }
    }
}

#[test]
fn closed_forms_with_one_member_fixed_are_the_roots_of_the_matrices() {
    for (planets, set, lower, upper) in [
        (3, "carrier-fixed", "5240.910723", "11743.974628"),
        (3, "ring-fixed", "2513.318779", "11919.434045"),
        (3, "sun-fixed", "2488.183843", "5641.888204"),
        (4, "carrier-fixed", "5993.440689", "13533.028383"),
        (4, "ring-fixed", "2769.757780", "13737.834217"),
        (4, "sun-fixed", "2720.400361", "6468.547891"),
    ] {
        let model = TorsionalPlanetary::with_planets(set, planets).unwrap();
        let (_, roots) = solved(&model, &[]);
        let class = |start: &'static str| {
            let matching = roots
                .iter()
                .filter(move |root| root.class.as_ref().unwrap().starts_with(start));
            matching.collect::<Vec<_>>()
        };
        let rotational = class("rotational");
        for (root, name, text) in [
            (rotational[0], "rotational_lower", lower),
            (rotational[1], "rotational_upper", upper),
            (class("planet")[0], "planet_mode", "2088.007554"),
        ] {
            let (form, hz) = (quantity(&model, name), root.omega_rad_s / TAU);
            printed(form, text);
            assert!(
                (hz / form - 1.0).abs() < 1e-12,
                "{set} {planets}: {hz} {form}"
            );
        }
        assert_eq!(class("planet")[0].modes.len(), planets - 1);
        assert_eq!(class("free").len(), 1);
    }
}

#[test]
fn the_sun_fixed_coefficient_as_printed_misses_the_matrices() {
    for (planets, lower, upper) in [
        (3, "2960.902532", "4741.140555"),
        (4, "3222.194126", "5461.197969"),
    ] {
        let model = TorsionalPlanetary::with_planets("sun-fixed", planets).unwrap();
        printed(quantity(&model, "printed_lower"), lower);
        printed(quantity(&model, "printed_upper"), upper);
    }
}

#[test]
fn places_of_veering_and_crossing_are_the_reference() {
    let model = TorsionalPlanetary::new("carrier-fixed").unwrap();
    for (name, text) in [
        ("veering_k_r", "2.512238e9"),
        ("crossing_k_r_lower", "4.308891e7"),
        ("crossing_k_r_upper", "3.108191e10"),
        ("nearest_k_r", "2.502804e9"),
    ] {
        scientific(quantity(&model, name), text);
    }
    for (name, text) in [
        ("veering_m_s", "1.521011"),
        ("crossing_m_s", "15.930000"),
        ("nearest_m_s", "1.489840"),
        ("delta_2", "302.124900"),
        ("nearest_gap", "415.611341"),
    ] {
        printed(quantity(&model, name), text);
    }
}

/// Frequencies of the lower and the upper rotational mode and of the planet modes.
fn three_roots(changes: &[(&str, f64)]) -> [f64; 3] {
    let (_, roots) = solved(&TorsionalPlanetary::new("carrier-fixed").unwrap(), changes);
    let hz = |root: &ModelRoot| root.omega_rad_s / TAU;
    let planet = |root: &&ModelRoot| root.modes.len() > 1;
    let Some(planet) = roots.iter().find(planet) else {
        // The lower rotational mode is within a millionth of the planet modes: all are one root.
        panic!("no planet root");
    };
    let single: Vec<f64> = roots
        .iter()
        .filter(|r| r.modes.len() == 1)
        .map(hz)
        .collect();
    match single.as_slice() {
        [_, lower, upper] => [*lower, *upper, hz(planet)],
        [_, upper] => [hz(planet), *upper, hz(planet)],
        other => panic!("{other:?}"),
    }
}

#[test]
fn at_the_crossings_the_matrices_have_one_root_and_near_the_veering_two() {
    let model = TorsionalPlanetary::new("carrier-fixed").unwrap();
    for (parameter, name, lower, upper, planet) in [
        (
            "k_r",
            "crossing_k_r_lower",
            "1538.748113",
            "11742.270801",
            "1538.748113",
        ),
        (
            "k_r",
            "crossing_k_r_upper",
            "11734.140088",
            "41356.088119",
            "11734.140088",
        ),
        (
            "m_s",
            "crossing_m_s",
            "2088.007554",
            "5264.546152",
            "2088.007554",
        ),
        (
            "k_r",
            "veering_k_r",
            "11539.571394",
            "11955.769676",
            "3623.903939",
        ),
        (
            "m_s",
            "veering_m_s",
            "5014.810856",
            "5433.426460",
            "2088.007554",
        ),
    ] {
        let found = three_roots(&[(parameter, quantity(&model, name))]);
        for (hz, text) in found.into_iter().zip([lower, upper, planet]) {
            printed(hz, text);
        }
    }
    // The true nearest approach is at the closed form's place: nearer than to either side of it.
    for (parameter, name) in [("k_r", "nearest_k_r"), ("m_s", "nearest_m_s")] {
        let place = quantity(&model, name);
        let gap = |at: f64| {
            let [lower, upper, _] = three_roots(&[(parameter, at)]);
            upper - lower
        };
        let smallest = gap(place);
        printed(smallest, "415.611341");
        assert!(gap(place * 1.001) > smallest && gap(place * 0.999) > smallest);
    }
}

#[test]
fn the_ring_mesh_energy_changes_places_across_the_veering() {
    for (k_r, shares, frequencies) in [
        (5e8, ["0.999610", "0.000390"], ["5240.9107", "11743.9746"]),
        (1.5e9, ["0.995410", "0.004590"], ["9070.5110", "11753.0542"]),
        (
            2.512e9,
            ["0.482958", "0.517042"],
            ["11539.3080", "11955.4772"],
        ),
        (4e9, ["0.005533", "0.994467"], ["11722.5433", "14850.6347"]),
        (1e10, ["0.000558", "0.999442"], ["11732.3287", "23461.3307"]),
    ] {
        let model = TorsionalPlanetary::new("carrier-fixed").unwrap();
        let (_, roots) = solved(&model, &[("k_r", k_r)]);
        let single: Vec<&ModelRoot> = roots
            .iter()
            .filter(|r| r.modes.len() == 1)
            .skip(1)
            .collect();
        for ((root, share), hz) in single.iter().zip(shares).zip(frequencies) {
            printed(root.omega_rad_s / TAU, hz);
            let (name, ring) = &root.strain_energy[0];
            assert_eq!(name, "k_r");
            printed(*ring, share);
        }
        let planet = roots.iter().find(|root| root.modes.len() == 2).unwrap();
        let ring = k_r / (k_r + 5e8);
        assert!((planet.strain_energy[0].1 - ring).abs() < 1e-12);
    }
}

#[test]
fn energies_of_table_2_are_the_reference_and_add_up() {
    let (_, roots) = solved(&TorsionalPlanetary::new("table-2").unwrap(), &[]);
    for (root, [ring, sun, support], kinetic) in [
        (
            1,
            ["0.0118917", "0.0004459", "0.9876624"],
            ["0.8213240", "0.1437627", "0.0288801", "0.0060333"],
        ),
        (
            2,
            ["0.5000000", "0.5000000", "0.0000000"],
            ["0.0000000", "0.0000000", "0.0000000", "1.0000000"],
        ),
        (
            3,
            ["0.9875519", "0.0006782", "0.0117699"],
            ["0.1467676", "0.7961857", "0.0029291", "0.0541176"],
        ),
        (
            4,
            ["0.0005565", "0.9988759", "0.0005676"],
            ["0.0319085", "0.0000995", "0.9569998", "0.0109922"],
        ),
    ] {
        let strain = &roots[root].strain_energy;
        let share = |name: &str| {
            strain
                .iter()
                .find(|(spring_name, _)| spring_name == name)
                .unwrap()
                .1
        };
        for (name, text) in [
            ("k_r", ring),
            ("k_s", sun),
            ("k_cu", support),
            ("k_ru", "0.0000000"),
        ] {
            assert!(
                (share(name) - text.parse::<f64>().unwrap()).abs() <= 5.1e-8,
                "{name} {text}"
            );
        }
        let kinds = roots[root].energy_by_kind();
        for (body, text) in ["carrier", "ring", "sun", "planet"].iter().zip(kinetic) {
            let share = kinds.iter().find(|(kind, _)| kind == body).unwrap().1;
            assert!(
                (share - text.parse::<f64>().unwrap()).abs() <= 5.1e-8,
                "{body} {text}"
            );
        }
        let sum = |shares: &[(String, f64)]| shares.iter().map(|(_, s)| s).sum::<f64>();
        assert!((sum(strain) - 1.0).abs() < 1e-12);
        assert!((sum(&roots[root].kinetic_energy) - 1.0).abs() < 1e-12);
    }
    assert!(
        roots[0].strain_energy.is_empty(),
        "nothing is strained at 0"
    );
}

#[test]
fn a_sensor_reads_a_coordinate_and_no_point() {
    let model = TorsionalPlanetary::new("table-2").unwrap();
    let row = model
        .observation_row(&[], &Target::Coordinate("us".to_owned()))
        .unwrap();
    assert_eq!(row, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let point = Target::BodyPoint {
        body: "sun".to_owned(),
        at_m: [0.0; 3],
        direction: [1.0, 0.0, 0.0],
    };
    assert!(matches!(
        model.observation_row(&[], &point),
        Err(TheoryError::NoRadius { body, .. }) if body == "sun"
    ));
    assert!(built_in("torsional-planetary/sun-fixed").is_ok());
    assert!(TorsionalPlanetary::new("planet-fixed").is_none());
}

#[test]
fn the_quantities_that_the_claims_ask_for_are_those_of_the_matrices() {
    let of = |set: &str| TorsionalPlanetary::new(set).unwrap();
    printed(quantity(&of("table-2"), "printed_carrier"), "1978.04");
    for set in ["table-2", "carrier-fixed", "ring-fixed", "sun-fixed"] {
        assert!(quantity(&of(set), "other_modes").abs() < 0.5, "{set}");
    }
    for (set, low, high) in [
        ("carrier-fixed", 0.0, 1e-9),
        ("ring-fixed", 0.0, 1e-9),
        // 2960.902532 for 2488.183843 Hz.
        ("sun-fixed", 18.9, 19.1),
    ] {
        let error = quantity(&of(set), "closed_form_error");
        assert!((low..high).contains(&error), "{set}: {error}");
    }
    let carrier_fixed = of("carrier-fixed");
    assert!(quantity(&carrier_fixed, "exchange_at_veering") > 0.9);
    assert!(quantity(&carrier_fixed, "exchange_at_crossing") < 1e-3);
    // A support leaves no closed form, and says so by leaving them out.
    let values = override_values(
        "gear",
        carrier_fixed.parameters(),
        &[("k_su".to_owned(), 1e6)].into(),
    );
    let all = carrier_fixed.quantities(&values.unwrap()).unwrap();
    assert!(all.iter().all(|quantity| quantity.name != "veering_k_r"));
    // Without a crossing there is no place of it: delta_2 = N^2 m_p^2 - 4 m_r m_s below 0.
    let values = override_values(
        "gear",
        carrier_fixed.parameters(),
        &[("m_r".to_owned(), 20.0), ("m_s".to_owned(), 20.0)].into(),
    );
    let all = carrier_fixed.quantities(&values.unwrap()).unwrap();
    let lower = all
        .iter()
        .find(|quantity| quantity.name == "crossing_k_r_lower")
        .unwrap();
    assert_eq!(lower.value, None);
}

#[test]
fn equations_13_14_and_19_hold_and_the_rate_of_a_mesh_energy_does_not() {
    let model = TorsionalPlanetary::new("table-2").unwrap();
    let values = nominal_values(model.parameters());
    let all = model.quantities(&values).unwrap();
    let value = |name: &str| {
        let found = all.iter().find(|quantity| quantity.name == name).unwrap();
        found.value.unwrap()
    };
    // Percent: 1e-6 of a root's largest scaled sensitivity for differences, rounding for sums.
    assert!(
        value("equation_13_error") < 1e-4,
        "{}",
        value("equation_13_error")
    );
    for name in ["equation_14_error", "equation_19_error"] {
        assert!(value(name) < 1e-8, "{name}: {}", value(name));
    }
    // The support holds 98.77 % of the energy of the lowest mode: it is counted λ² times.
    assert!(value("equation_19_misread_error") > 1e6);
    // k d²λ/dk² over dλ/dk of the root at 1671 Hz, whose support carries nearly all, is near -2.
    assert!(
        value("mesh_energy_rate_error") > 50.0,
        "{}",
        value("mesh_energy_rate_error")
    );
}

#[test]
fn with_a_free_carrier_one_crossing_with_the_planet_modes_is_left() {
    let model = TorsionalPlanetary::with_planets("table-2", 3).unwrap();
    let values = nominal_values(model.parameters());
    let range = SweepRange {
        lower: 3e6,
        upper: 3e11,
        count: 40,
    };
    let sweep_result = sweep(&model, &values, "k_r", range, None).unwrap();
    let planet = sweep_result
        .loci
        .iter()
        .position(|locus| locus.multiplicity[0] == 2)
        .unwrap();
    let class = sweep_result.loci[planet].class.as_deref();
    assert!(class.unwrap().starts_with("planet mode"));
    let crossings: Vec<_> = sweep_result
        .events
        .iter()
        .filter(|e| e.kind == EventKind::Crossing)
        .collect();
    assert_eq!(crossings.len(), 1, "{:?}", sweep_result.events);
    assert!(crossings[0].loci.contains(&planet));
    assert!(
        (crossings[0].place / 3.206990e10 - 1.0).abs() < 2e-7,
        "{}",
        crossings[0].place
    );
}

#[test]
fn places_by_following_the_loci_are_those_of_the_closed_forms() {
    let model = TorsionalPlanetary::new("carrier-fixed").unwrap();
    let all = model
        .quantities(&nominal_values(model.parameters()))
        .unwrap();
    let value = |name: &str| {
        all.iter()
            .find(|quantity| quantity.name == name)
            .unwrap()
            .value
    };
    for (name, expected) in [
        ("swept_crossing_k_r_lower", 4.308891e7),
        ("swept_crossing_k_r_upper", 3.108191e10),
        ("swept_veering_k_r", 2.502803e9),
        ("swept_gap_k_r", 415.611341),
        ("swept_crossing_m_s_lower", 15.93),
        ("swept_veering_m_s", 1.489840),
        ("swept_gap_m_s", 415.611341),
    ] {
        let got = value(name).unwrap();
        assert!((got / expected - 1.0).abs() < 4e-7, "{name}: {got}");
    }
    assert_eq!(value("swept_crossing_m_s_upper"), None);
    assert_eq!(
        (value("swept_others_k_r"), value("swept_others_m_s")),
        (Some(0.0), Some(0.0))
    );
}

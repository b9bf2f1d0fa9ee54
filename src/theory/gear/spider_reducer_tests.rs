//! Frequencies, energies, crank turn and static balance of the spider reducer, against an
//! independent computation from the paper's equations, to its printed digits.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::linalg::least_squares_real;
use crate::theory::parameter::{nominal_values, override_values};
use crate::theory::{
    ModeOptions, ModelRoot, SpiderReducer, TheoreticalModel, TheoryModes, model_roots, modes,
};

fn solved(model: &SpiderReducer, changes: &[(&str, f64)]) -> TheoryModes {
    let changes = changes.iter().map(|(name, v)| ((*name).to_owned(), *v));
    let values = override_values("reducer", model.parameters(), &changes.collect())
        .expect("changes of parameters that the model has");
    modes(model, &values, &[], &ModeOptions::default()).expect("a model with positive masses")
}

fn frequencies(modes: &TheoryModes) -> Vec<f64> {
    modes.omega_rad_s.iter().map(|omega| omega / TAU).collect()
}

fn roots(model: &SpiderReducer) -> Vec<ModelRoot> {
    model_roots(model, &solved(model, &[]))
}

fn printed(value: f64, text: &str) {
    let decimals = text.split('.').nth(1).map_or(0, str::len);
    assert_eq!(format!("{value:.decimals$}"), text);
}

/// All 35, Hz.
const FREQUENCIES: [&str; 35] = [
    "66.198557",
    "89.001295",
    "115.108361",
    "159.240843",
    "183.679470",
    "186.323068",
    "235.990667",
    "272.600342",
    "272.600342",
    "279.610122",
    "300.224465",
    "357.801143",
    "387.807040",
    "451.198001",
    "504.065030",
    "780.978320",
    "787.211956",
    "1286.427054",
    "1311.433099",
    "1584.959136",
    "1584.959136",
    "1584.959136",
    "1584.959136",
    "1584.959136",
    "1619.370042",
    "1626.906997",
    "1638.141421",
    "1734.752376",
    "1734.752376",
    "1736.064232",
    "1737.964923",
    "1737.964923",
    "1743.286654",
    "1746.226151",
    "1750.055642",
];

#[test]
fn all_frequencies_and_multiplicities_are_the_reference() {
    let model = SpiderReducer::new("paper").expect("the set of the paper");
    let solved = solved(&model, &[]);
    assert_eq!((solved.omega_rad_s.len(), solved.rigid), (35, 0));
    for (hz, text) in frequencies(&solved).into_iter().zip(FREQUENCIES) {
        printed(hz, text);
    }
    let repeated: Vec<Vec<usize>> = roots(&model)
        .into_iter()
        .map(|root| root.modes)
        .filter(|modes| modes.len() > 1)
        .collect();
    assert_eq!(
        repeated,
        [vec![7, 8], (19..24).collect(), vec![27, 28], vec![30, 31]]
    );
}

#[test]
fn the_matrices_are_those_of_the_reference() {
    let model = SpiderReducer::new("paper").expect("the set of the paper");
    let matrices = model
        .assemble(&nominal_values(model.parameters()))
        .expect("nominal values");
    let k = &matrices.stiffness;
    let trace: f64 = (0..35).map(|i| k[(i, i)]).sum();
    let squares: f64 = (0..35)
        .flat_map(|i| (0..35).map(move |j| (i, j)))
        .map(|at| k[at].powi(2))
        .sum();
    assert_eq!(format!("{trace:.10e}"), "3.1593478274e9");
    assert_eq!(format!("{:.10e}", squares.sqrt()), "1.2240388441e9");
    let mass: f64 = (0..35).map(|i| matrices.mass[(i, i)]).sum();
    printed(mass, "219.1476882");
}

#[test]
fn kinetic_shares_of_the_subsystems_are_the_reference() {
    let roots = roots(&SpiderReducer::new("paper").expect("the set of the paper"));
    // output, input, shafts 1 to 4, gears 1 and 2, percent; the pair 8-9 is its mean.
    let expected = [
        [
            "98.809", "0.577", "0.075", "0.085", "0.096", "0.085", "0.050", "0.223",
        ],
        [
            "45.676", "0.725", "6.569", "9.565", "13.111", "9.558", "5.564", "9.232",
        ],
        [
            "67.498", "0.299", "13.779", "1.233", "2.314", "1.234", "8.329", "5.313",
        ],
        [
            "37.845", "0.758", "3.278", "7.166", "12.643", "7.180", "19.809", "11.321",
        ],
        [
            "79.432", "1.091", "9.348", "0.389", "3.407", "0.382", "0.472", "5.478",
        ],
        [
            "97.139", "1.634", "0.304", "0.082", "0.009", "0.090", "0.259", "0.483",
        ],
        [
            "21.759", "7.630", "19.787", "0.305", "18.953", "0.319", "15.318", "15.928",
        ],
        [
            "0.000", "0.000", "12.500", "37.500", "12.500", "37.500", "0.000", "0.000",
        ],
        [
            "0.233", "74.102", "0.367", "0.324", "0.259", "0.279", "15.972", "8.465",
        ],
        [
            "1.318", "86.284", "2.433", "0.402", "7.952", "0.402", "0.856", "0.352",
        ],
        [
            "2.224", "28.756", "0.723", "0.718", "0.813", "0.802", "23.192", "42.773",
        ],
    ];
    for (root, shares) in roots.iter().zip(expected) {
        for ((_, share), text) in root.kinetic_energy.iter().zip(shares) {
            printed(100.0 * share.abs(), text);
        }
        let sum: f64 = root.kinetic_energy.iter().map(|(_, share)| share).sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
    assert_eq!(
        roots[7].class.as_deref(),
        Some("spider shafts alone, gears still")
    );
    assert_eq!(
        roots[8].class.as_deref(),
        Some("compound, input shaft leads")
    );
}

#[test]
fn strain_shares_of_the_springs_are_the_reference() {
    let roots = roots(&SpiderReducer::new("paper").expect("the set of the paper"));
    let expected = [
        [
            "45.266", "31.437", "4.193", "8.138", "7.311", "1.729", "1.923", "0.003",
        ],
        [
            "0.613", "1.194", "5.348", "2.523", "65.044", "8.823", "15.231", "1.223",
        ],
        [
            "3.211", "22.509", "0.306", "0.448", "6.140", "12.523", "53.482", "1.380",
        ],
        [
            "1.482", "1.878", "1.755", "0.162", "7.182", "38.280", "46.558", "2.703",
        ],
        [
            "19.374", "57.756", "1.488", "1.464", "2.343", "3.504", "13.908", "0.164",
        ],
        [
            "26.278", "66.615", "1.763", "1.212", "1.963", "0.958", "1.201", "0.009",
        ],
        [
            "4.004", "2.797", "5.668", "0.850", "0.028", "31.768", "52.766", "2.119",
        ],
        [
            "0.000", "0.000", "0.000", "0.000", "0.000", "13.383", "86.617", "0.000",
        ],
        [
            "0.034", "0.048", "60.471", "1.023", "5.207", "16.940", "16.274", "0.002",
        ],
        [
            "0.051", "0.003", "62.090", "8.460", "13.749", "2.169", "12.685", "0.793",
        ],
        [
            "0.199", "0.243", "11.938", "23.267", "9.811", "29.163", "25.375", "0.004",
        ],
    ];
    let groups: [&[&str]; 8] = [
        &["k_o1"],
        &["k_o2"],
        &["k_i1"],
        &["k_i2"],
        &["k_a"],
        &["k_s1", "k_s2"],
        &["k_p1", "k_p2"],
        &["k_m"],
    ];
    for (root, shares) in roots.iter().zip(expected) {
        for (group, text) in groups.iter().zip(shares) {
            let shares = root
                .strain_energy
                .iter()
                .filter(|(name, _)| group.contains(&name.as_str()));
            printed(100.0 * shares.map(|(_, share)| share).sum::<f64>(), text);
        }
    }
}

#[test]
fn a_turn_of_the_crank_moves_no_frequency_with_three_or_more_equal_shafts() {
    for (shafts, moves) in [(2, true), (3, false), (4, false), (5, false)] {
        let model = SpiderReducer::with_shafts(shafts);
        let reference = frequencies(&solved(&model, &[]));
        let mut largest = 0.0f64;
        for position in 1..12 {
            let angle = TAU * f64::from(position) / 12.0;
            let hz = frequencies(&solved(&model, &[("crank_angle", angle)]));
            let change = |i: usize| (hz[i] / reference[i] - 1.0).abs();
            largest = (0..9).fold(largest, |all, i| all.max(change(i)));
        }
        // The reference's rounding is 4e-13; with two shafts it is a quarter of the frequency.
        assert!(
            if moves {
                largest > 0.1
            } else {
                largest < 1e-11
            },
            "{shafts}: {largest}"
        );
    }
}

#[test]
fn changed_stiffnesses_move_the_frequencies_as_in_the_reference() {
    let model = SpiderReducer::new("paper").expect("the set of the paper");
    for (name, value, expected) in [
        (
            "k_m",
            240e6,
            [
                "66.19828",
                "88.86497",
                "114.91026",
                "158.70468",
                "183.64212",
                "186.32105",
                "235.36636",
                "272.60034",
                "272.60034",
            ],
        ),
        (
            "k_m",
            360e6,
            [
                "66.19874",
                "89.09189",
                "115.24102",
                "159.60040",
                "183.70471",
                "186.32448",
                "236.40777",
                "272.60034",
                "272.60034",
            ],
        ),
        (
            "k_i2",
            10e6,
            [
                "64.1575", "88.1808", "114.9225", "159.1405", "182.6476", "185.4443", "235.1701",
                "272.6003", "272.6003",
            ],
        ),
        (
            "k_i2",
            40e6,
            [
                "67.8000", "89.6887", "115.2682", "159.3159", "184.4686", "186.9820", "236.5525",
                "272.6003", "272.6003",
            ],
        ),
    ] {
        let hz = frequencies(&solved(&model, &[(name, value)]));
        for (hz, text) in hz.into_iter().zip(expected) {
            printed(hz, text);
        }
    }
}

#[test]
fn quantities_are_the_reference() {
    let model = SpiderReducer::new("paper").expect("the set of the paper");
    let all = model
        .quantities(&nominal_values(model.parameters()))
        .expect("quantities at nominal values");
    let value = |name: &str| {
        all.iter()
            .find(|quantity| quantity.name == name)
            .expect("a quantity of this name")
            .value
            .expect("a quantity that exists at these values")
    };
    for (name, text) in [
        ("frequency_1", "66.198557"),
        ("frequency_9", "272.600342"),
        ("repeated_roots", "4"),
        ("compound_modes", "5"),
        ("output_swing_3", "63.6415"),
        ("k_i2_share_3", "0.448"),
        ("k_i2_change_3", "0.16"),
        ("k_m_change", "0.34"),
        ("output_twist", "-0.001912409916"),
        ("mesh_force_1", "3058.406426"),
        ("mesh_force_2", "4180.898149"),
        ("mesh_torque", "1000.000000"),
        ("bearing_force_1", "3303.33969"),
        ("bearing_force_2", "3289.62123"),
        ("input_torque", "20.408163265"),
        ("ratio", "49"),
        ("preload_x", "-147.192959"),
        ("preload_y", "-3.072537"),
    ] {
        printed(value(name), text);
    }
    assert!(value("crank_change") < 1e-9, "percent");
}

#[test]
fn the_bearings_of_gears_on_shafts_carry_the_load_as_in_the_reference() {
    let model = SpiderReducer::new("paper").expect("the set of the paper");
    let matrices = model
        .assemble(&nominal_values(model.parameters()))
        .expect("nominal values");
    let output = matrices.coordinates.iter().position(|c| c.name == "boz");
    let mut load = vec![0.0; matrices.coordinates.len()];
    load[output.expect("the output is a coordinate")] = -1000.0;
    let moved = least_squares_real(&matrices.stiffness, &load).expect("a stiffness of full rank");
    // Squared forces by gear and shaft, x and y together.
    let mut squares: BTreeMap<[&str; 2], f64> = BTreeMap::new();
    for spring in &matrices.springs {
        let parts = spring.row.iter().zip(&matrices.coordinates);
        let bodies: Vec<&str> = parts
            .filter(|(part, _)| part.abs() > 0.0)
            .map(|(_, coordinate)| coordinate.body.as_str())
            .collect();
        let of = |kind: &str| bodies.iter().find(|body| body.starts_with(kind));
        if let (Some(gear), Some(shaft)) = (of("gear-"), of("shaft-")) {
            let stretch: f64 = spring.row.iter().zip(&moved).map(|(a, b)| a * b).sum();
            *squares.entry([gear, shaft]).or_default() += (spring.stiffness * stretch).powi(2);
        }
    }
    let forces: Vec<f64> = squares.values().map(|square| square.sqrt()).collect();
    let expected = [
        "1227.60772",
        "676.45732",
        "1482.94942",
        "1179.77775",
        "1250.97265",
        "2097.91335",
        "1502.34844",
        "1399.59711",
    ];
    assert_eq!(forces.len(), expected.len());
    for (force, text) in forces.into_iter().zip(expected) {
        printed(force, text);
    }
}

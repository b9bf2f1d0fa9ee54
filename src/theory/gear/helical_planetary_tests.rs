//! The matrices of the helical planetary gear against the reference, and what follows for its
//! geometry and torques.

use std::f64::consts::TAU;

use super::helical_mesh::{Detail, MeshGeometry};
use super::helical_motion::Motion;
use crate::theory::parameter::override_values;
use crate::theory::{
    HelicalPlanetary, ModeOptions, ModelRoot, TheoreticalModel, model_roots, modes,
};

fn roots(set: &str, changes: &[(&str, f64)]) -> Vec<ModelRoot> {
    let (model, values) = changed(set, changes);
    let modes = modes(&model, &values, &[], &ModeOptions::default()).unwrap();
    model_roots(&model, &modes)
}

fn changed(set: &str, changes: &[(&str, f64)]) -> (HelicalPlanetary, Vec<f64>) {
    let model = HelicalPlanetary::new(set).unwrap();
    let changes = changes.iter().map(|(name, v)| ((*name).to_owned(), *v));
    let values = override_values("gear", model.parameters(), &changes.collect());
    (model, values.unwrap())
}

fn nominal(name: &str) -> f64 {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    let parameter = model.parameters().iter().find(|spec| spec.name == name);
    parameter.unwrap().nominal
}

fn motion(changes: &[(&str, f64)]) -> Motion {
    let (model, values) = changed("kb-1.5e8", changes);
    Motion::new(&model, &values, Detail::ConstantAngle).unwrap()
}

fn printed(value: f64, text: &str) {
    let decimals = text.split('.').nth(1).map_or(0, str::len);
    assert_eq!(format!("{value:.decimals$}"), text);
}

/// Frequency, Hz, multiplicity and begin of the class of every root.
type Table = &'static [(f64, usize, &'static str)];

#[test]
fn natural_frequencies_and_classes_are_the_reference_for_both_bearings_and_rigid_ones() {
    let tables: [(&str, Table); 3] = [
        (
            "kb-1.5e8",
            &[
                (0.0, 1, "free motion"),
                (779.455615, 2, "trans"),
                (1505.359242, 1, "rot"),
                (1507.206365, 1, "planet"),
                (1599.882536, 2, "trans"),
                (1971.899527, 1, "rot"),
                (2094.582783, 2, "trans"),
                (3742.408653, 1, "planet"),
                (4201.687093, 2, "trans"),
                (4254.469399, 1, "rot"),
                (4781.812398, 1, "planet"),
                (6877.380953, 2, "trans"),
                (10410.218501, 1, "rot"),
            ],
        ),
        (
            "kb-1e10",
            &[
                (0.0, 1, "free motion"),
                (3567.668114, 1, "rot"),
                (4187.750988, 2, "trans"),
                (4559.909989, 1, "planet"),
                (4841.946246, 2, "trans"),
                (10118.675307, 1, "rot"),
                (12905.158819, 1, "planet"),
                (12958.418219, 1, "rot"),
                (13072.177536, 2, "trans"),
                (13274.190181, 1, "planet"),
                (17917.630957, 2, "trans"),
                (18736.084084, 1, "rot"),
                (18783.918490, 2, "trans"),
            ],
        ),
        (
            "torsional",
            &[
                (0.0, 1, "free motion"),
                (3592.877148, 1, "rot"),
                (4585.791645, 3, "planet"),
                (10243.508012, 1, "rot"),
            ],
        ),
    ];
    for (set, expected) in tables {
        check(set, &roots(set, &[]), expected);
    }
}

/// Means of the stiffness wave, over which three pairs of teeth are in contact 0.37 and 0.64 of the
/// period.
#[test]
fn natural_frequencies_with_the_means_of_the_wave_are_the_reference() {
    let motion = motion(&[]);
    let count = 1000;
    let mean = |kind: usize| {
        let at = |i: usize| motion.mesh_period_s() * (i as f64 + 0.5) / count as f64;
        let state = motion.equilibrium();
        let all = (0..count).map(|i| motion.meshes(at(i), &state, 0)[kind].stiffness_n_per_m);
        all.sum::<f64>() / count as f64
    };
    let means = [mean(0), mean(1)];
    assert_eq!(
        means.map(|mean| format!("{mean:.2e}")),
        ["3.74e8", "4.28e8"]
    );
    check(
        "means",
        &roots("kb-1.5e8", &[("k_sp", means[0]), ("k_rp", means[1])]),
        &[
            (0.0, 1, "free motion"),
            (779.095674, 2, "trans"),
            (1506.315826, 1, "rot"),
            (1507.192047, 1, "planet"),
            (1599.569158, 2, "trans"),
            (1976.250145, 1, "rot"),
            (2095.992695, 2, "trans"),
            (3728.619224, 1, "planet"),
            (4326.695353, 2, "trans"),
            (4387.016407, 1, "rot"),
            (4801.489518, 1, "planet"),
            (6680.466215, 2, "trans"),
            (10069.332150, 1, "rot"),
        ],
    );
}

fn check(set: &str, found: &[ModelRoot], expected: Table) {
    assert_eq!(found.len(), expected.len(), "{set}: {found:?}");
    for (root, (hz, multiplicity, class)) in found.iter().zip(expected) {
        let omega_hz = root.omega_rad_s / TAU;
        assert!(
            (omega_hz - hz).abs() < 6e-7 * hz.max(1.0),
            "{set}: {omega_hz} {hz}"
        );
        assert!((omega_hz - hz).abs() < 2e-6, "{set}: {omega_hz} {hz}");
        assert_eq!(root.modes.len(), *multiplicity, "{set}: {hz}");
        assert!(
            root.class.as_ref().unwrap().starts_with(class),
            "{set} {hz}: {:?}",
            root.class
        );
    }
}

#[test]
fn masses_and_radii_are_the_reference() {
    let model = HelicalPlanetary::new("kb-1.5e8").unwrap();
    for (name, expected) in [
        ("m_c", 7.351326809400117),
        ("j_c", 0.036756634047000594),
        ("m_s", 0.7818065082965937),
        ("j_s", 0.00041572183652163655),
        ("m_p", 1.53825966940307),
        ("j_p", 0.0019555068865073594),
        ("pressure_angle", 0.36035632401741163),
        ("base_radius_s", 0.030516622781367637),
        ("base_radius_p", 0.04504834791535222),
    ] {
        let spec = model
            .parameters()
            .iter()
            .find(|spec| spec.name == name)
            .unwrap();
        assert!(
            (spec.nominal / expected - 1.0).abs() < 1e-14,
            "{name}: {}",
            spec.nominal
        );
    }
    assert!(HelicalPlanetary::new("kb-3e8").is_none());
}

#[test]
fn radii_and_the_mesh_frequency_are_the_reference() {
    let module = 2.0 * nominal("base_radius_s") / nominal("pressure_angle").cos() / 21.0;
    assert!(
        (module / 3.105828541230249e-3 - 1.0).abs() < 1e-14,
        "{module}"
    );
    let degrees = nominal("pressure_angle").to_degrees();
    printed(degrees, "20.646896");
    // Turned by one radian, the carrier stretches the ring's mesh by the ring's base radius, and
    // the planets sit on its pins.
    let motion = motion(&[]);
    let mut state = vec![0.0; motion.equilibrium().len()];
    state[2] = 1.0;
    let ring = -motion.meshes(0.0, &state, 0)[1].compression_m;
    assert!((ring / 0.12061331861207208 - 1.0).abs() < 1e-14, "{ring}");
    let (model, values) = changed("kb-1.5e8", &[]);
    let coordinates = model.assemble(&values).unwrap().coordinates;
    let planet = coordinates
        .iter()
        .find(|coordinate| coordinate.body == "planet-1")
        .unwrap();
    let pins = planet.at_m[0];
    assert!((pins / 0.08075154207198648 - 1.0).abs() < 1e-14, "{pins}");
    printed(1.0 / motion.mesh_period_s(), "110.666667");
}

#[test]
fn the_printed_teeth_and_torques_fit_neither_the_pins_nor_each_other() {
    // Of the torsional set the geometry alone is stated.
    let (model, values) = changed("torsional", &[]);
    let all = model.quantities(&values).unwrap();
    let value = |name: &str| {
        let quantity = all.iter().find(|candidate| candidate.name == name).unwrap();
        quantity.value.unwrap()
    };
    for (name, text) in [
        ("centre_distance_sun", "80.751542"),
        ("centre_distance_ring_82", "79.198628"),
        ("centre_distance_ring_83", "80.751542"),
        ("balanced_drive", "8.076923"),
        ("printed_surplus", "7.7905"),
    ] {
        printed(value(name), text);
    }
    let ratio = nominal("load") / value("balanced_drive");
    printed(ratio, "4.952381");
    printed(nominal("load") / 9.65, "4.1451");
    // The printed drive accelerates the gear without its springs, whose free motion has unit modal
    // mass.
    let solved = modes(&model, &values, &[], &ModeOptions::default()).unwrap();
    let carrier = solved
        .coordinates
        .iter()
        .position(|coordinate| coordinate.name == "thc");
    let inertia = solved.vectors[(carrier.unwrap(), 0)].powi(-2);
    printed(inertia, "0.109085");
    let acceleration = value("printed_surplus") / inertia;
    printed(acceleration, "71.42");
    let gained = acceleration * 20.0 * motion(&[]).mesh_period_s() * 60.0 / TAU;
    printed(nominal("speed") + gained, "203.25");
    // Base circles of planet and a ring of 82 teeth at the pins' distance, by equation 11, and
    // those of sun and planet.
    let (sun, planet) = (nominal("base_radius_s"), nominal("base_radius_p"));
    let ring = sun * 82.0 / 21.0;
    let rest_angle = nominal("pressure_angle");
    let pins = (sun + planet) / rest_angle.cos();
    for (side, base, text) in [
        (1.0, sun + planet, "20.646896"),
        (-1.0, ring - planet, "23.396968"),
    ] {
        let mesh = MeshGeometry::new(side, base, rest_angle, pins);
        let angle = mesh.approach(Detail::PrintedAngle, pins, 0.0).angle;
        printed(angle.to_degrees(), text);
    }
}

#[test]
fn at_the_equilibrium_every_mesh_carries_the_drive_in_four_parts() {
    let motion = motion(&[("mesh_min", 4e8), ("mesh_max", 4e8)]);
    let state = motion.equilibrium();
    for planet in 0..4 {
        for mesh in motion.meshes(0.0, &state, planet) {
            printed(mesh.compression_m * mesh.stiffness_n_per_m, "66.168225");
            assert_eq!(format!("{:.9e}", mesh.compression_m), "1.654205631e-7");
        }
    }
}

#[test]
fn contact_ratios_and_shares_of_the_wave_are_the_reference() {
    // Teeth with an addendum of the normal module, 3 mm; face width 30 mm, helix of 15 degrees.
    let angle = nominal("pressure_angle");
    let base = |teeth: f64| nominal("base_radius_s") * teeth / 21.0;
    let pitch = |teeth: f64| base(teeth) / angle.cos();
    let from_base = |teeth: f64, addendum: f64| {
        ((pitch(teeth) + addendum).powi(2) - base(teeth).powi(2)).sqrt()
    };
    let between = (pitch(21.0) + pitch(31.0)) * angle.sin();
    let step = TAU * base(21.0) / 21.0;
    let sun = (from_base(21.0, 3e-3) + from_base(31.0, 3e-3) - between) / step;
    let ring = (from_base(31.0, 3e-3) - from_base(83.0, -3e-3) + between) / step;
    let overlap = 30.0 * 15f64.to_radians().sin() / (3.0 * std::f64::consts::PI);
    for (value, text) in [
        (sun, "1.5430"),
        (ring, "1.8190"),
        (overlap, "0.8238"),
        (sun + overlap, "2.367"),
        (ring + overlap, "2.643"),
        (sun + overlap - 2.0, "0.3668"),
        (ring + overlap - 2.0, "0.6429"),
        ((21.0 + 82.0) / 4.0, "25.75"),
        (1.0 + 82.0 / 21.0, "4.904762"),
        (40.0 / (1.0 + 82.0 / 21.0), "8.155340"),
    ] {
        printed(value, text);
    }
    // Three pairs for these parts of the period, which the sets take to two digits.
    printed(nominal("mesh_share_sp"), "0.37");
    printed(nominal("mesh_share_rp"), "0.64");
}

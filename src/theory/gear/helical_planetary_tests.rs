//! The matrices of the helical planetary gear against the reference.

use std::f64::consts::TAU;

use crate::theory::parameter::nominal_values;
use crate::theory::{
    HelicalPlanetary, ModeOptions, ModelRoot, TheoreticalModel, model_roots, modes,
};

fn roots(set: &str) -> Vec<ModelRoot> {
    let model = HelicalPlanetary::new(set).unwrap();
    let values = nominal_values(model.parameters());
    let modes = modes(&model, &values, &[], &ModeOptions::default()).unwrap();
    model_roots(&model, &modes)
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
        let found = roots(set);
        assert_eq!(found.len(), expected.len(), "{set}: {found:?}");
        for (root, (hz, multiplicity, class)) in found.iter().zip(expected) {
            let own = root.omega_rad_s / TAU;
            assert!((own - hz).abs() < 6e-7 * hz.max(1.0), "{set}: {own} {hz}");
            assert!((own - hz).abs() < 2e-6, "{set}: {own} {hz}");
            assert_eq!(root.modes.len(), *multiplicity, "{set}: {hz}");
            assert!(
                root.class.as_ref().unwrap().starts_with(class),
                "{set} {hz}: {:?}",
                root.class
            );
        }
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

//! Geometry and modes of real writers, where the folder with their files is there.

use num_complex::Complex64;
use serde_json::Value;

use super::recordings::{codes, opened, recording};
use crate::finding::Code;
use crate::modal::{Scaling, mac};

const MODES: &str = "lms-testlab-modes/OOP_inb_new_attach_0_30Hz_no euler.unv";

/// The listed contents of a file.
fn expected(name: &str) -> Value {
    let path = recording("expected.json").expect("it lies beside the recordings");
    let all: Value = serde_json::from_slice(&std::fs::read(path).expect("the file can be read"))
        .expect("the file is JSON");
    all[name].clone()
}

fn numbers(list: &Value) -> Vec<f64> {
    let list = list.as_array().expect("expected values list it");
    list.iter()
        .map(|v| v.as_f64().expect("expected values are numbers"))
        .collect()
}

#[test]
fn modes_of_testlab_have_the_listed_poles_and_shapes() {
    let Some(source) = opened(MODES) else {
        return;
    };
    let (catalog, listed) = (source.catalog(), expected(MODES));
    assert_eq!(codes(source.as_ref()), [Code::UnmeasuredLeftOut]);
    assert_eq!(
        catalog.modes.len() as u64,
        listed["n_modes"]
            .as_u64()
            .expect("expected values are whole numbers")
    );
    let (headers, natural) = (&listed["header_freq_hz"], &listed["undamped_hz"]);
    let (headers, natural) = (numbers(headers), numbers(natural));
    let (damping, poles) = (numbers(&listed["header_damping"]), &listed["eigenvalue"]);
    for (i, entry) in catalog.modes.iter().enumerate() {
        let mode = &entry.mode;
        let pole = mode.pole().expect("the mode has damping");
        let listed_pole = numbers(&poles[i]);
        let listed_pole = Complex64::new(listed_pole[0], listed_pole[1]);
        assert!((pole.lambda - listed_pole).norm() < 1e-12 * listed_pole.norm());
        // Listed with seven digits.
        assert!(
            (mode.frequency_hz / natural[i] - 1.0).abs() < 5e-7,
            "mode {}",
            i + 1
        );
        let damped = pole.damped_frequency_hz();
        assert!((damped / headers[i] - 1.0).abs() < 6e-6, "mode {}", i + 1);
        // The eigenvalue has six digits, the header six decimals.
        let zeta = mode.damping_ratio.expect("the mode has damping");
        assert!((zeta - damping[i]).abs() < 2e-6, "mode {}: {zeta}", i + 1);
        let nodes: std::collections::BTreeSet<&str> =
            mode.shape.iter().map(|(dof, _)| dof.point()).collect();
        assert_eq!(
            nodes.len() as u64,
            listed["n_nodes_per_mode"]
                .as_u64()
                .expect("expected values are whole numbers")
        );
        assert_eq!((entry.title.len(), entry.modal_a.is_some()), (4, true));
        assert_eq!(mode.scaling, Scaling::UnitModalMass);
    }
    let first = &catalog.modes[0].mode.shape;
    for (node, axes) in listed["mode1_first_node_in_file"]
        .as_object()
        .expect("expected values list it")
    {
        for (axis, value) in ["X", "Y", "Z"]
            .iter()
            .zip(axes.as_array().expect("expected values list it"))
        {
            let value = numbers(value);
            let dof = format!("{node}:+{axis}")
                .parse()
                .expect("a name of a degree of freedom");
            match first.get(&dof) {
                Some(got) => assert_eq!((got.re, got.im), (value[0], value[1]), "{dof}"),
                None => assert_eq!(value, [0.0, 0.0], "{dof}"),
            }
        }
    }
}

#[test]
fn the_autocorrelation_of_those_modes_is_the_listed_one() {
    let Some(source) = opened(MODES) else {
        return;
    };
    let listed = expected(MODES);
    let shapes: Vec<Vec<Complex64>> = source
        .catalog()
        .modes
        .iter()
        .map(|entry| entry.mode.shape.iter().map(|(_, value)| value).collect())
        .collect();
    let (pair, count) = (numbers(&listed["automac_max_pair"]), shapes.len());
    let listed = |name: &str| listed[name].as_f64().expect("expected values are numbers");
    let of = |i: usize, j: usize| mac(&shapes[i - 1], &shapes[j - 1]).expect("no shape vanishes");
    for (got, name) in [
        (of(1, 2), "automac_12"),
        (of(1, 3), "automac_13"),
        (of(2, 3), "mac_mode2_vs_mode3"),
    ] {
        assert!((got / listed(name) - 1.0).abs() < 5e-7, "{name}: {got}");
    }
    let pairs = (1..=count).flat_map(|i| (1..i).map(move |j| (j, i)));
    let worst = pairs
        .max_by(|a, b| of(a.0, a.1).total_cmp(&of(b.0, b.1)))
        .unwrap();
    assert_eq!(vec![worst.0 as f64, worst.1 as f64], pair);
    assert!((of(worst.0, worst.1) / listed("automac_max_offdiag") - 1.0).abs() < 5e-7);
}

#[test]
fn real_modes_and_meshes_of_other_writers_are_read() {
    if let Some(source) = opened("uff-formats/uff55_translation.uff") {
        let modes = &source.catalog().modes;
        assert!(!modes.is_empty());
        for entry in modes {
            assert_eq!(entry.mode.damping_ratio, None);
            assert_eq!((entry.mode.modal_mass_kg, entry.title.len()), (None, 0));
            assert!(entry.mode.shape.iter().all(|(_, value)| value.im == 0.0));
        }
    }
    for (name, held, found) in [
        (
            "uff-formats/TestLab 161 164 18 15 82.uff",
            [true, true, true, false, false],
            vec![],
        ),
        (
            "uff-formats/groups_test.uff",
            [true, false, true, true, true],
            vec![],
        ),
        (
            "uff-formats/heat_engine_housing.uff",
            [true, false, false, true, false],
            vec![Code::NotModes],
        ),
        (
            "uff-formats/mesh_Oros-modal_uff15_uff2412.uff",
            [true, false, true, true, false],
            vec![Code::Assumption],
        ),
    ] {
        let Some(source) = opened(name) else {
            return;
        };
        let geometry = &source.catalog().geometry;
        let got = [
            !geometry.nodes.is_empty(),
            !geometry.lines.is_empty(),
            !geometry.systems.is_empty(),
            !geometry.elements.is_empty(),
            !geometry.groups.is_empty(),
        ];
        assert_eq!((got, codes(source.as_ref())), (held, found), "{name}");
    }
}

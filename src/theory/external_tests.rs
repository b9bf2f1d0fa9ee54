//! Models of given matrices against closed forms, dense and sparse.

use crate::finding::Code;
use crate::geometry::Target;
use crate::linalg::SparseMatrix;

use super::*;

type Entries = Vec<(usize, usize, f64)>;

fn matrix(size: usize, entries: &[(usize, usize, f64)]) -> Option<SparseMatrix> {
    Some(SparseMatrix::from_entries(size, entries).unwrap())
}

fn parameter(name: &str, nominal: f64) -> ParameterSpec {
    ParameterSpec {
        name: name.to_owned(),
        unit: "-".to_owned(),
        nominal,
        lower: Some(0.1),
        upper: Some(10.0),
        status: ParameterStatus::Assumed,
        whole: false,
    }
}

/// Two masses of 2 and 3 kg; a spring of 100 N/m to ground at the first, 50 theta N/m between them.
fn two_masses(second: &str) -> ExternalMatrices {
    let sign = if second.contains('-') { 1.0 } else { -1.0 };
    let between = [
        (0, 0, 50.0),
        (0, 1, 50.0 * sign),
        (1, 0, 50.0 * sign),
        (1, 1, 50.0),
    ];
    ExternalMatrices {
        title: "two masses".to_owned(),
        dofs: vec!["1:+X".parse().unwrap(), second.parse().unwrap()],
        fixed: MatrixSet {
            mass: matrix(2, &[(0, 0, 2.0), (1, 1, 3.0)]),
            damping: None,
            stiffness: matrix(2, &[(0, 0, 100.0)]),
        },
        parameters: vec![parameter("coupling", 1.0), parameter("added", 0.5)],
        groups: vec![
            (
                "coupling".to_owned(),
                MatrixSet {
                    stiffness: matrix(2, &between),
                    ..MatrixSet::default()
                },
            ),
            (
                "added".to_owned(),
                MatrixSet {
                    mass: matrix(2, &[(1, 1, 1.0)]),
                    damping: matrix(2, &[(1, 1, 4.0)]),
                    ..MatrixSet::default()
                },
            ),
        ],
        damping: StatedDamping::default(),
        support: None,
    }
}

/// A square of bilinear elements with consistent mass, 40 x 40 nodes inside held edges; `theta`
/// scales its stiffness along y: `lambda = mu_i + theta mu_j`.
fn membrane(damping: StatedDamping) -> (ExternalModel, Vec<f64>) {
    let nodes = 40;
    let h = 1.0 / (nodes + 1) as f64;
    let bar = |diagonal: f64, beside: f64| -> Entries {
        let entry = move |i: usize, j: usize| (i, j, if i == j { diagonal } else { beside });
        let near = |i: usize| (i.saturating_sub(1)..=(i + 1).min(nodes - 1)).map(move |j| (i, j));
        (0..nodes)
            .flat_map(near)
            .map(|(i, j)| entry(i, j))
            .collect()
    };
    let product = |a: &Entries, b: &Entries| -> Option<SparseMatrix> {
        let pairs = a.iter().flat_map(|&(i, j, x)| {
            b.iter()
                .map(move |&(k, l, y)| (i * nodes + k, j * nodes + l, x * y))
        });
        matrix(nodes * nodes, &pairs.collect::<Vec<_>>())
    };
    let (k1, m1) = (bar(2.0 / h, -1.0 / h), bar(4.0 * h / 6.0, h / 6.0));
    let dof = |i: usize| format!("{}:+Z", i + 1).parse().unwrap();
    let along_y = MatrixSet {
        stiffness: product(&m1, &k1),
        ..MatrixSet::default()
    };
    let model = ExternalModel::new(ExternalMatrices {
        title: "membrane".to_owned(),
        dofs: (0..nodes * nodes).map(dof).collect(),
        fixed: MatrixSet {
            mass: product(&m1, &m1),
            damping: None,
            stiffness: product(&k1, &m1),
        },
        parameters: vec![parameter("along y", 1.0)],
        groups: vec![("along y".to_owned(), along_y)],
        damping,
        support: None,
    });
    let root = |i: usize| {
        let angle = i as f64 * std::f64::consts::PI * h;
        12.0 / (h * h) * (0.5 * angle).sin().powi(2) / (2.0 + angle.cos())
    };
    (model.unwrap(), (1..=nodes).map(root).collect())
}

#[test]
fn parameters_scale_their_groups() {
    let model = ExternalModel::new(two_masses("2:+X")).unwrap();
    let built = model.assemble(&[3.0, 2.0]).unwrap();
    let stiffness = [[250.0, -150.0], [-150.0, 150.0]];
    let (mass, damping) = ([[2.0, 0.0], [0.0, 5.0]], [[0.0, 0.0], [0.0, 8.0]]);
    let c = built.damping.unwrap();
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for (entry, expected) in [
            (built.stiffness[(i, j)], stiffness[i][j]),
            (built.mass[(i, j)], mass[i][j]),
            (c[(i, j)], damping[i][j]),
        ] {
            assert!(
                (entry - expected).abs() < 1e-13,
                "{i} {j}: {entry} {expected}"
            );
        }
    }
    let by = model.derivative(&[3.0, 2.0], 0).unwrap();
    assert_eq!((by.stiffness[(0, 1)], by.mass[(1, 1)]), (-50.0, 0.0));
    let by = model.derivative(&[3.0, 2.0], 1).unwrap();
    assert_eq!((by.stiffness[(0, 1)], by.mass[(1, 1)]), (0.0, 1.0));
    assert!(model.sparse(&[3.0, 2.0]).unwrap().is_none());
}

#[test]
fn full_matrices_of_a_large_model_are_not_made() {
    let size = 6000;
    let ones: Entries = (0..size).map(|i| (i, i, 1.0)).collect();
    let model = ExternalModel::new(ExternalMatrices {
        dofs: (1..=size)
            .map(|i| format!("{i}:+X").parse().unwrap())
            .collect(),
        fixed: MatrixSet {
            mass: matrix(size, &ones),
            damping: None,
            stiffness: matrix(size, &ones),
        },
        ..ExternalMatrices::default()
    });
    let model = model.unwrap();
    let error = model.assemble(&[]).unwrap_err();
    assert_eq!(
        error,
        TheoryError::TooLarge {
            got: 6000,
            most: 5000
        }
    );
    assert!(model.sparse(&[]).unwrap().is_some());
}

#[test]
fn a_coordinate_against_its_axis_is_reversed() {
    let solve = |second: &str| {
        let model = ExternalModel::new(two_masses(second)).unwrap();
        let sensors = model.sensors();
        let solved = modes(&model, &[1.0, 0.5], &sensors, &ModeOptions::default()).unwrap();
        solved
            .model
            .modes
            .iter()
            .map(|mode| mode.shape.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(solve("2:+X"), solve("2:-X"));
}

#[test]
fn a_large_model_is_solved_sparse_at_its_double_roots_with_proportional_damping() {
    let damping = StatedDamping {
        mass_per_s: 0.3,
        stiffness_s: 2e-3,
        ratios: Vec::new(),
    };
    let (model, mu) = membrane(damping);
    let sensors = &model.sensors()[..3];
    let solved = modes(&model, &[1.0], sensors, &ModeOptions::default()).unwrap();
    let mut exact: Vec<f64> = mu
        .iter()
        .flat_map(|a| mu.iter().map(move |b| a + b))
        .collect();
    exact.sort_by(f64::total_cmp);
    assert!(solved.omega_rad_s.len() >= 30 && solved.rigid == 0);
    for (mode, (omega, exact)) in solved
        .model
        .modes
        .iter()
        .zip(solved.omega_rad_s.iter().zip(&exact))
    {
        // Rounding of the stiffness against the lowest roots: n^2 eps or so.
        assert!(
            (omega.powi(2) / exact - 1.0).abs() < 1e-10,
            "{omega} {exact}"
        );
        let ratio = 0.5 * (0.3 / omega + 2e-3 * omega);
        assert!((mode.damping_ratio.unwrap() - ratio).abs() < 1e-9 * ratio);
        assert_eq!(mode.shape.iter().count(), 3);
    }
    assert_eq!(solved.model.modes[1].group, solved.model.modes[2].group);
    assert!(solved.model.modes[1].group.is_some());
    let codes: Vec<Code> = solved
        .model
        .findings
        .iter()
        .map(|finding| finding.code)
        .collect();
    assert_eq!(codes, [Code::LowestModesAlone, Code::Assumption]);
    let total: f64 = (0..1600).map(|i| solved.kinetic_shares[(i, 4)]).sum();
    assert!((total - 1.0).abs() < 1e-10);
}

#[test]
fn sparse_sensitivities_split_a_double_root() {
    let (model, mu) = membrane(StatedDamping::default());
    let band = crate::axis::Band::new(0.0, 2.0).unwrap();
    let options = ModeOptions {
        band: Some(band),
        ..ModeOptions::default()
    };
    let solved = modes(&model, &[1.0], &[], &options).unwrap();
    let roots = model_roots(&model, &solved);
    let found = model_sensitivities(&model, &[1.0], &solved, &roots).unwrap();
    // mu_1 + mu_1, then mu_1 + mu_2 twice, whose branches are mu_1 and mu_2.
    let expected = [vec![mu[0]], vec![mu[0], mu[1]], vec![mu[1]]];
    for (sensitivities, expected) in found.iter().zip(expected) {
        assert_eq!(sensitivities.branches[0].len(), expected.len());
        for (sensitivity, expected) in sensitivities.branches[0].iter().zip(expected) {
            assert!(
                (sensitivity / expected - 1.0).abs() < 1e-8,
                "{sensitivity} {expected}"
            );
        }
    }
    assert!(found.len() >= 3);
}

#[test]
fn damping_ratios_stated_by_mode_replace_those_of_the_matrices() {
    let mut matrices = two_masses("2:+X");
    matrices.damping.ratios = vec![0.01];
    let model = ExternalModel::new(matrices).unwrap();
    let solved = modes(&model, &[1.0, 0.5], &[], &ModeOptions::default()).unwrap();
    let ratios: Vec<f64> = solved
        .model
        .modes
        .iter()
        .map(|m| m.damping_ratio.unwrap())
        .collect();
    assert!((ratios[0] - 0.01).abs() < 1e-15);
    // The second mode keeps phi^T C phi / (2 omega) of C = 2 at the second mass.
    let expected = solved.vectors[(1, 1)].powi(2) * 2.0 / (2.0 * solved.omega_rad_s[1]);
    assert!((ratios[1] / expected - 1.0).abs() < 1e-12);
}

#[test]
fn errors_of_matrices_are_reported() {
    let build = |change: &dyn Fn(&mut ExternalMatrices)| {
        let mut matrices = two_masses("2:+X");
        change(&mut matrices);
        ExternalModel::new(matrices).unwrap_err()
    };
    let skew = [(0, 0, 1.0), (0, 1, 0.5), (1, 0, -0.5)];
    let error = build(&|m| m.fixed.stiffness = matrix(2, &skew));
    assert!(
        matches!(
            error,
            TheoryError::MatrixEntry {
                matrix: "stiffness",
                ..
            }
        ),
        "{error}"
    );
    let error = build(&|m| m.fixed.mass = matrix(3, &[(0, 0, 1.0)]));
    assert!(matches!(
        error,
        TheoryError::MatrixSize {
            got_rows: 3,
            expected: 2,
            ..
        }
    ));
    let error = build(&|m| m.groups[0].0 = "cuopling".to_owned());
    assert!(
        matches!(error, TheoryError::UnknownParameter { nearest: Some(n), .. } if n == "coupling")
    );
    let error = build(&|m| m.dofs[1] = "1:-X".parse().unwrap());
    assert!(matches!(error, TheoryError::Duplicate { name, .. } if name == "1:+X"));
    let error = build(&|m| m.damping.stiffness_s = f64::NAN);
    assert!(matches!(
        error,
        TheoryError::PropertyOutOfRange {
            property: "stiffness_s",
            ..
        }
    ));
    let error = build(&|m| m.dofs.clear());
    assert!(matches!(error, TheoryError::NoCoordinates { .. }));
    let error = ExternalModel::new(ExternalMatrices::default()).unwrap_err();
    assert!(matches!(error, TheoryError::NoCoordinates { .. }));
    let error = build(&|m| m.damping.ratios = vec![1.0]);
    assert!(matches!(error, TheoryError::DampingRatio { .. }));
    let model = ExternalModel::new(two_masses("2:+X")).unwrap();
    let point = Target::BodyPoint {
        body: "1".to_owned(),
        at_m: [0.0; 3],
        direction: [1.0, 0.0, 0.0],
    };
    let error = model.observation_row(&[], &point).unwrap_err();
    assert!(matches!(error, TheoryError::NoPositions { body } if body == "1"));
    let error = model.observation_row(&[], &Target::Coordinate("2:+Y".to_owned()));
    assert!(matches!(
        error,
        Err(TheoryError::UnknownCoordinate { count: 2, .. })
    ));
}

#[test]
fn sparse_matrices_of_other_sizes_or_without_symmetry_are_rejected() {
    let whole = || {
        let model = ExternalModel::new(two_masses("2:+X")).unwrap();
        let matrices = model.assemble(&nominal_values(model.parameters())).unwrap();
        let sparse = |dense: &crate::linalg::RealMatrix| {
            let all = (0..2).flat_map(|i| (0..2).map(move |j| (i, j)));
            let entries: Vec<_> = all.map(|(i, j)| (i, j, dense[(i, j)])).collect();
            SparseMatrix::from_entries(2, &entries).unwrap()
        };
        SparseSystem {
            mass: sparse(&matrices.mass),
            damping: None,
            stiffness: sparse(&matrices.stiffness),
            coordinates: matrices.coordinates,
        }
    };
    let options = ModeOptions::default();
    assert_eq!(
        modes_of_sparse(&whole(), &options)
            .unwrap()
            .omega_rad_s
            .len(),
        2
    );
    let three = SparseMatrix::from_entries(3, &[(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0)]).unwrap();
    for part in ["mass", "stiffness", "damping"] {
        for lopsided in [false, true] {
            let mut system = whole();
            let wrong = match lopsided {
                true => {
                    SparseMatrix::from_entries(2, &[(0, 0, 1.0), (1, 0, 0.5), (1, 1, 1.0)]).unwrap()
                }
                false => three.clone(),
            };
            match part {
                "mass" => system.mass = wrong,
                "stiffness" => system.stiffness = wrong,
                _ => system.damping = Some(wrong),
            }
            let named = match modes_of_sparse(&system, &options).unwrap_err() {
                TheoryError::MatrixSize {
                    matrix,
                    expected: 2,
                    ..
                } if !lopsided => matrix,
                TheoryError::MatrixEntry { matrix, .. } if lopsided => matrix,
                other => panic!("{part} {lopsided}: {other}"),
            };
            assert_eq!(named, part);
        }
    }
}

#[test]
fn groups_and_the_rest_share_the_strain_energy() {
    let model = ExternalModel::new(two_masses("2:+X")).unwrap();
    let solved = modes(&model, &[3.0, 2.0], &[], &ModeOptions::default()).unwrap();
    let roots = model_roots(&model, &solved);
    assert_eq!(roots.len(), 2);
    for (j, root) in roots.iter().enumerate() {
        // Of the springs themselves: 150 N/m between the masses, 100 N/m to the ground.
        let phi = [0, 1].map(|i| solved.vectors[(i, j)]);
        let springs = [150.0 * (phi[0] - phi[1]).powi(2), 100.0 * phi[0] * phi[0]];
        let all = springs[0] + springs[1];
        let names: Vec<&str> = root
            .strain_energy
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert_eq!(names, ["coupling", "rest"], "`added` has no stiffness");
        for ((_, share), spring) in root.strain_energy.iter().zip(springs) {
            assert!((share - spring / all).abs() < 1e-14, "{share}");
        }
    }
    // Without groups there are no named parts.
    let mut plain = two_masses("2:+X");
    plain.groups.clear();
    plain.fixed.stiffness = matrix(2, &[(0, 0, 100.0), (1, 1, 40.0)]);
    let plain = ExternalModel::new(plain).unwrap();
    let solved = modes(&plain, &[1.0, 0.5], &[], &ModeOptions::default()).unwrap();
    assert!(model_roots(&plain, &solved)[0].strain_energy.is_empty());
}

#[test]
fn groups_of_a_sparse_model_share_the_strain_energy() {
    let (model, mu) = membrane(StatedDamping::default());
    let theta = 2.3;
    let options = ModeOptions {
        count: Some(6),
        ..ModeOptions::default()
    };
    let solved = modes(&model, &[theta], &[], &options).unwrap();
    // lambda and the part along y of every pair of half-waves.
    let pairs = mu
        .iter()
        .flat_map(|x| mu.iter().map(move |y| (x + theta * y, theta * y)));
    let mut expected: Vec<(f64, f64)> = pairs.collect();
    expected.sort_by(|a, b| a.0.total_cmp(&b.0));
    let roots = model_roots(&model, &solved);
    assert_eq!(roots.len(), 6);
    for (root, (lambda, along_y)) in roots.iter().zip(expected) {
        assert!((root.omega_rad_s.powi(2) / lambda - 1.0).abs() < 1e-9);
        let [(name, share), (rest, other)] = &root.strain_energy[..] else {
            panic!("{root:?}");
        };
        assert_eq!((name.as_str(), rest.as_str()), ("along y", "rest"));
        // Vectors are good to the root of the eigenvalues' rounding at worst.
        assert!((share - along_y / lambda).abs() < 1e-6, "{share} {along_y}");
        assert!((share + other - 1.0).abs() < 1e-12);
    }
}

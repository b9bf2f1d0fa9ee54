//! The stiffness matrix as the paper prints it, entry by entry, against the one from the springs.

use std::f64::consts::TAU;

use crate::linalg::{RealMatrix, real_matrix};
use crate::theory::parameter::nominal_values;
use crate::theory::{
    CycloidBall, ModeOptions, SystemMatrices, TheoreticalModel, modes_of_matrices,
};

/// Values by name.
pub(super) struct Named<'a> {
    pub model: &'a CycloidBall,
    pub values: &'a [f64],
}

impl Named<'_> {
    fn get(&self, name: &str) -> f64 {
        let specs = self.model.parameters();
        self.values[specs.iter().position(|spec| spec.name == name).unwrap()]
    }

    fn normals(&self, balls: usize) -> Vec<f64> {
        let angle = |i: usize| {
            let theta = self.get("ball_phase") + TAU * i as f64 / balls as f64;
            theta.sin().atan2(theta.cos() + self.get("trochoid_ratio"))
        };
        (0..balls).map(angle).collect()
    }
}

/// The printed matrix (section 1.4 of the paper, its misprints cos b1^2 read as cos^2 b1) with any
/// angles Φ4.
fn printed(named: &Named<'_>, phi4: &[f64]) -> RealMatrix {
    let k = |name: &str| named.get(name);
    let (balls, pins) = (phi4.len(), 6);
    let phi3 = named.normals(balls);
    let (cos2, e) = (k("cos2_beta"), k("half_eccentricity"));
    let arm = (balls + 1) as f64 * e;
    let (ab, cd) = ((k("k_a") + k("k_b")) * cos2, (k("k_c") + k("k_d")) * cos2);
    let (c1, c2) = (k("cos2_beta_1"), k("cos2_beta_2"));
    let (g, h) = (
        k("k_da") * c1 + k("k_db") * c2,
        k("k_dd") * c1 + k("k_dc") * c2,
    );
    let sum = |f: &dyn Fn(f64) -> f64| -> f64 { phi3.iter().map(|&p| f(p)).sum() };
    let (ss, cc, sc) = (
        sum(&|p| p.sin().powi(2)),
        sum(&|p| p.cos().powi(2)),
        sum(&|p| p.sin() * p.cos()),
    );
    let n = 11 + 2 * balls + pins;
    let mut m = real_matrix(n, n, |_, _| 0.0);
    let mut set = |i: usize, j: usize, value: f64| {
        m[(i, j)] = value;
        m[(j, i)] = value;
    };
    set(0, 0, k("k_01x") + k("k_03x"));
    set(1, 1, k("k_01y") + k("k_03y"));
    set(0, 2, -2.0 * e * k("k_03x"));
    set(2, 2, 4.0 * e * e * k("k_03x"));
    set(0, 3, -k("k_01x"));
    set(1, 4, -k("k_01y"));
    set(3, 3, k("k_1x") + k("k_01x") + cd * ss);
    set(3, 4, -cd * sc);
    set(3, 5, arm * cd * ss);
    set(4, 4, k("k_1y") + k("k_01y") + cd * cc);
    set(4, 5, -arm * cd * sc);
    set(5, 5, k("k_1u") + cd * arm * arm * ss);
    let p = 6 + 2 * balls;
    for i in 0..balls {
        let ((s3, c3), (s4, c4)) = (phi3[i].sin_cos(), phi4[i].sin_cos());
        let (x, y) = (6 + 2 * i, 7 + 2 * i);
        set(3, x, -cd * s3 * s4);
        set(3, y, cd * s3 * c4);
        set(4, x, cd * c3 * s4);
        set(4, y, -cd * c3 * c4);
        set(5, x, -cd * arm * s3 * s4);
        set(5, y, cd * arm * s3 * c4);
        set(x, x, (ab + cd) * s4 * s4);
        set(x, y, -(ab + cd) * s4 * c4);
        set(y, y, (ab + cd) * c4 * c4);
        set(x, p, -ab * s4 * s3);
        set(x, p + 1, ab * s4 * c3);
        set(x, p + 2, -arm * ab * s4 * s3);
        set(y, p, ab * s3 * c4);
        set(y, p + 1, -ab * c3 * c4);
        set(y, p + 2, arm * ab * c4 * s3);
    }
    set(0, p, -k("k_03x"));
    set(1, p + 1, -k("k_03y"));
    set(2, p, 2.0 * e * k("k_03x"));
    let radius = k("pin_circle_radius");
    let pin = |j: usize| (k("pin_phase") + TAU * j as f64 / pins as f64).sin();
    let sin_sum: f64 = (0..pins).map(pin).sum();
    let sin2_sum: f64 = (0..pins).map(|j| pin(j).powi(2)).sum();
    set(p, p, k("k_03x") + ab * ss);
    set(p, p + 1, -ab * sc);
    set(p, p + 2, arm * ab * ss);
    set(p + 1, p + 1, k("k_03y") + ab * cc + pins as f64 * g);
    set(p + 1, p + 2, -arm * ab * sc + radius * g * sin_sum);
    set(
        p + 2,
        p + 2,
        ab * arm * arm * ss + radius * radius * g * sin2_sum,
    );
    let q = p + 3;
    let o = q + pins;
    for j in 0..pins {
        set(p + 1, q + j, -g);
        set(p + 2, q + j, -g * radius * pin(j));
        set(q + j, q + j, g + h);
        set(o, q + j, -h);
        set(o + 1, q + j, -h * radius * pin(j));
    }
    set(o, o, k("k_5y") + pins as f64 * h);
    set(o, o + 1, radius * h * sin_sum);
    set(o + 1, o + 1, h * radius * radius * sin2_sum);
    m
}

fn changed(model: &CycloidBall, changes: &[(&str, f64)]) -> Vec<f64> {
    let mut values = nominal_values(model.parameters());
    for (name, value) in changes {
        let at = model.parameters().iter().position(|p| p.name == *name);
        values[at.unwrap()] = *value;
    }
    values
}

fn omega(matrices: &SystemMatrices) -> Vec<f64> {
    modes_of_matrices(matrices, &ModeOptions::default())
        .unwrap()
        .omega_rad_s
}

#[test]
fn the_printed_matrix_is_that_of_the_springs_entry_by_entry() {
    for set in ["A", "B", "C", "D"] {
        // Phases that leave no symmetry, so that every entry is put to use.
        for phases in [[0.0, 0.0], [0.1, 0.37]] {
            let model = CycloidBall::new(set).unwrap();
            let values = changed(
                &model,
                &[("ball_phase", phases[0]), ("pin_phase", phases[1])],
            );
            let springs = model.assemble(&values).unwrap().stiffness;
            let named = Named {
                model: &model,
                values: &values,
            };
            let expected = printed(&named, &named.normals(10));
            let all = || (0..37).flat_map(|i| (0..37).map(move |j| (i, j)));
            let largest = all().map(|at| expected[at].abs()).fold(0.0, f64::max);
            for at in all() {
                // A handful of roundings of terms no larger than the largest entry.
                assert!(
                    (springs[at] - expected[at]).abs() <= 4.0 * f64::EPSILON * largest,
                    "set {set}, {at:?}: {} and {}",
                    springs[at],
                    expected[at]
                );
            }
        }
    }
}

#[test]
fn the_roots_do_not_depend_on_the_ball_frames_nor_on_the_phase_of_the_pins() {
    let model = CycloidBall::new("B").unwrap();
    let values = changed(&model, &[]);
    let reference = omega(&model.assemble(&values).unwrap());
    let compare = |other: Vec<f64>| {
        for (a, b) in reference.iter().zip(&other) {
            assert!((a - b).abs() <= 1e-12 * a, "{a} and {b}");
        }
    };
    let named = Named {
        model: &model,
        values: &values,
    };
    // Any frames of the balls will do.
    let phi4: Vec<f64> = (0..10).map(|i| (7 * i * i + 3 * i) as f64 * 0.61).collect();
    let matrices = model.assemble(&values).unwrap();
    compare(omega(&SystemMatrices {
        stiffness: printed(&named, &phi4),
        ..matrices
    }));
    for phase in [0.37, 1.9] {
        let turned = changed(&model, &[("pin_phase", phase)]);
        compare(omega(&model.assemble(&turned).unwrap()));
    }
}

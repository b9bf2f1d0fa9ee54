//! Decompositions: the lowest natural frequencies against extended precision, independence of
//! scale, and checks that find results broken on purpose.

#[path = "../support/extended_precision.rs"]
mod extended_precision;
#[path = "../support/matrix_zoo.rs"]
mod matrix_zoo;

use modalign::linalg::{
    ComplexMatrix, LinalgError, RealMatrix, SymmetricModes, cholesky, complex_eigenvalues,
    complex_matrix, general_modes, least_squares, real_matrix, right_singular_vectors,
    singular_vectors, solve_definite, solve_square, symmetric_eigen, symmetric_modes, thin_qr,
    upper_triangle, verify,
};
use num_complex::Complex64;

use matrix_zoo::{Ends, Random, zoo};

/// Largest specimen of the sample; the population test takes all, with `POPULATION_PARTS` a part.
const SAMPLE: usize = 210;

#[test]
fn lowest_frequencies_of_the_zoo_equal_those_of_extended_precision() {
    let specimens = zoo(SAMPLE);
    assert!(specimens.len() >= 45);
    for specimen in &specimens {
        let row = extended_precision::compared(specimen).unwrap();
        assert!(row.error_over_limit <= 1.0, "{row}");
        assert!(row.rigid_over_bound <= 1.0, "{row}");
        assert!(row.orthogonality < 1e-9, "{row}");
    }
}

#[test]
fn decompositions_are_independent_of_the_scale_of_the_entries() {
    for n in [37, 150] {
        let mut random = Random(n as u64);
        let a = complex_matrix(n + 5, n, |_, _| {
            Complex64::new(random.next(), random.next())
        });
        for factor in [1e-150, 1e-15, 1.0, 1e9, 1e15, 1e150] {
            let a = complex_matrix(n + 5, n, |i, j| a[(i, j)] * factor);
            let square = complex_matrix(n, n, |i, j| a[(i, j)]);
            let real = real_matrix(n + 5, n, |i, j| a[(i, j)].re);
            let symmetric = real_matrix(n, n, |i, j| real[(i.max(j), i.min(j))]);
            let definite = real_matrix(n, n, |i, j| {
                symmetric[(i, j)] + if i == j { 2.0 * n as f64 * factor } else { 0.0 }
            });
            let hermitian = complex_matrix(n, n, |i, j| definite[(i, j)].into());
            let right = complex_matrix(n + 5, 2, |i, j| Complex64::from((i * j) as f64));
            let load = real_matrix(n, 1, |i, _| i as f64);
            // Each of these functions checks its result.
            symmetric_eigen(&symmetric).unwrap();
            general_modes(&real_matrix(n, n, |i, j| real[(i, j)])).unwrap();
            complex_eigenvalues(&square).unwrap();
            singular_vectors(&a).unwrap();
            right_singular_vectors(&real).unwrap();
            thin_qr(&a).unwrap();
            upper_triangle(&real).unwrap();
            least_squares(&a, &right).unwrap();
            cholesky(&hermitian).unwrap();
            solve_definite(&definite, &load).unwrap();
        }
    }
}

#[test]
fn equal_singular_values_and_graded_and_defective_matrices_pass_their_checks() {
    let phase = |i: usize, j: usize| std::f64::consts::PI * (i * j) as f64 / 200.0;
    let fourier = complex_matrix(200, 200, |i, j| Complex64::from_polar(1.0, phase(i, j)));
    let values = singular_vectors(&fourier).unwrap().values;
    assert!(values.is_sorted_by(|a, b| a >= b));
    let squares: f64 = values.iter().map(|s| s * s).sum();
    assert!((squares / 4e4 - 1.0).abs() < 1e-12, "{squares}");
    // [[0, I], [-K, -C]] of a chain: entries over nine decades.
    let n = 150;
    let chain = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2e9,
        1 => -1e9,
        _ => 0.0,
    };
    let state = real_matrix(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => f64::from(u8::from(i == j - n)),
        (false, true) => -chain(i - n, j),
        (false, false) => -1e-5 * chain(i - n, j - n),
    });
    let modes = general_modes(&state).unwrap();
    // omega = 2 sqrt(k) sin(pi / 2 (n + 1)) of the lowest pair.
    let lowest = modes.values.iter().map(|value| value.norm());
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    let exact = 2.0 * 1e9_f64.sqrt() * (std::f64::consts::FRAC_PI_2 / (n as f64 + 1.0)).sin();
    assert!((lowest / exact - 1.0).abs() < 1e-6, "{lowest} {exact}");
    // One eigenvalue of one vector, 40 times.
    let jordan = complex_matrix(40, 40, |i, j| {
        f64::from(u8::from(i == j || i + 1 == j)).into()
    });
    assert_eq!(complex_eigenvalues(&jordan).unwrap().len(), 40);
}

#[test]
fn repeated_root_at_the_limit_of_the_lowest_modes_is_one_root() {
    let identity = real_matrix(20, 20, |i, j| f64::from(u8::from(i == j)));
    let values: Vec<f64> = (0..20)
        .map(|i| match i {
            0..4 => 1e6,
            _ => 1e6 * 10f64.powf(5.0 * (i - 3) as f64 / 16.0),
        })
        .collect();
    for seed in 1..=20 {
        let modes = symmetric_modes(&matrix_zoo::turned(&values, seed), &identity).unwrap();
        for (got, exact) in modes.omega_squared.iter().zip(&values).take(4) {
            // Rounding of the entries, 1e-16 of the largest root.
            assert!((got / exact - 1.0).abs() < 1e-9, "{seed}: {got}");
        }
    }
}

/// What is done to a right result.
type Broken<T> = (&'static str, fn(&mut T));

fn is_caught<T: Clone>(
    right: &T,
    broken: &[Broken<T>],
    check: impl Fn(&T) -> Result<(), LinalgError>,
) {
    check(right).unwrap();
    for (what, change) in broken {
        let mut wrong = right.clone();
        change(&mut wrong);
        assert!(check(&wrong).is_err(), "{what} passes");
    }
}

fn exchange(vectors: &mut RealMatrix, [i, j]: [usize; 2]) {
    for row in 0..vectors.nrows() {
        (vectors[(row, i)], vectors[(row, j)]) = (vectors[(row, j)], vectors[(row, i)]);
    }
}

#[test]
fn modes_broken_on_purpose_are_caught() {
    let off = |modes: &mut SymmetricModes, j: usize| {
        let value = modes.omega_squared[j];
        modes.omega_squared[j] += (1e-6 * value.abs()).max(100.0 * modes.rounding[j]);
    };
    // A beam of condition 1e4 and two of 1e12 and more, one with rigid-body modes; a
    // well-conditioned pair.
    let beam = |elements| matrix_zoo::beam(elements, Ends::Clamped);
    let pairs = [
        beam(4),
        beam(420),
        matrix_zoo::beam(60, Ends::Free),
        matrix_zoo::graded(150, 12.0),
        matrix_zoo::random(150),
    ];
    for (k, m) in &pairs {
        let right = symmetric_modes(k, m).unwrap();
        let check = |modes: &SymmetricModes| verify::symmetric_modes(k, m, modes);
        is_caught(
            &right,
            &[
                ("smallest elastic root doubled", |modes| {
                    let first = modes.omega_squared.iter().zip(&modes.rounding);
                    let first = first.take_while(|(value, rounding)| **value < 4.0 * **rounding);
                    let first = first.count();
                    modes.omega_squared[first] *= 2.0;
                }),
                ("root just above those of shift and invert off", |modes| {
                    let largest = *modes.omega_squared.last().unwrap();
                    let is_low = |value: &f64| *value <= 1e-5 * largest;
                    let first = modes.omega_squared.partition_point(is_low);
                    let last = modes.omega_squared.len() - 1;
                    modes.omega_squared[first.min(last)] *= 1.0 + 1e-6;
                }),
                ("root omitted", |modes| {
                    modes.omega_squared.remove(1);
                    let n = modes.vectors.nrows();
                    let place = |j: usize| j + usize::from(j >= 1);
                    modes.vectors = real_matrix(n, n - 1, |i, j| modes.vectors[(i, place(j))]);
                    modes.rounding.remove(1);
                }),
                ("phantom in the place of the last root", |modes| {
                    let n = modes.vectors.nrows();
                    let between = 0.5 * (modes.omega_squared[1] + modes.omega_squared[2]);
                    modes.omega_squared.pop();
                    modes.omega_squared.insert(2, between);
                    let old = modes.vectors.clone();
                    modes.vectors = real_matrix(n, n, |i, j| match j {
                        0 | 1 => old[(i, j)],
                        2 => (old[(i, 1)] + old[(i, 2)]) / 2f64.sqrt(),
                        _ => old[(i, j - 1)],
                    });
                }),
                ("two vectors exchanged", |modes| {
                    exchange(&mut modes.vectors, [2, 4]);
                }),
                ("last vectors exchanged", |modes| {
                    let n = modes.vectors.ncols();
                    exchange(&mut modes.vectors, [n - 3, n - 1]);
                }),
                ("not a number", |modes| modes.vectors[(0, 0)] = f64::NAN),
            ],
            check,
        );
        for j in [2, 3, k.nrows() / 2, k.nrows() - 1] {
            let mut wrong = right.clone();
            off(&mut wrong, j);
            wrong.omega_squared.sort_by(f64::total_cmp);
            assert!(check(&wrong).is_err(), "value {j} of {} passes", k.nrows());
        }
    }
}

/// A matrix of singular values from 1 down to the reciprocal of the condition.
fn conditioned([m, n]: [usize; 2], condition: f64) -> ComplexMatrix {
    let mut random = Random(m as u64);
    let mut orthonormal = |rows: usize| {
        let a = complex_matrix(rows, n, |_, _| Complex64::new(random.next(), random.next()));
        thin_qr(&a).unwrap().q
    };
    let (u, v) = (orthonormal(m), orthonormal(n));
    let value = |j: usize| condition.powf(-(j as f64) / (n as f64 - 1.0));
    complex_matrix(m, n, |i, j| u[(i, j)] * value(j)) * v.adjoint()
}

/// A hundred times the rounding of a decomposition, `n eps` for n columns, `m n eps` for QR and
/// `(m + n) eps` for singular values, or a millionth.
fn hundred_roundings(n: usize, value: f64) -> f64 {
    (1e-6 * value.abs()).max(100.0 * n as f64 * f64::EPSILON)
}

#[test]
fn general_decompositions_broken_on_purpose_are_caught() {
    for (condition, size) in [
        (1e4, [80, 30]),
        (1e12, [80, 30]),
        (1e4, [160, 140]),
        (1e12, [30, 30]),
    ] {
        let a = conditioned(size, condition);
        let n = size[1];
        let norms: Vec<f64> = (0..n).map(|j| a.col(j).norm_l2()).collect();

        let svd = singular_vectors(&a).unwrap();
        let check = |u: &ComplexMatrix, s: &[f64], v: &ComplexMatrix| {
            verify::singular_vectors(a.as_ref(), u.as_ref(), s, v.as_ref())
        };
        check(&svd.left, &svd.values, &svd.right).unwrap();
        for j in [0, n / 2, n - 1] {
            let mut values = svd.values.clone();
            values[j] += hundred_roundings(n + size[0], values[j]);
            assert!(
                check(&svd.left, &values, &svd.right).is_err(),
                "value {j}, {condition:e}"
            );
        }
        let mut values = svd.values.clone();
        values[n - 1] = values[n - 2];
        values[n - 2] = values[n - 3];
        assert!(
            check(&svd.left, &values, &svd.right).is_err(),
            "smallest omitted"
        );
        let mut wrong = svd.right.clone();
        (0..n).for_each(|i| wrong[(i, 3)] = svd.right[(i, 4)]);
        assert!(
            check(&svd.left, &svd.values, &wrong).is_err(),
            "vector twice"
        );

        let qr = thin_qr(&a).unwrap();
        // The last pivot of R is 1e-12 of the norm in the second: the triangle alone does not show
        // it.
        for (i, j) in [(0, 0), (2, n - 1), (n / 2, n / 2), (n - 1, n - 1)] {
            let mut r = qr.r.clone();
            let rounding = hundred_roundings(n * size[0], qr.r[(i, j)].norm() / norms[j]);
            r[(i, j)] += rounding * norms[j];
            assert!(verify::thin_qr(a.as_ref(), qr.q.as_ref(), r.as_ref()).is_err());
            let mut q = qr.q.clone();
            q[(i, j)] += hundred_roundings(n * size[0], qr.q[(i, j)].norm());
            assert!(verify::thin_qr(a.as_ref(), q.as_ref(), qr.r.as_ref()).is_err());
        }

        let b = complex_matrix(size[0], 3, |i, j| {
            Complex64::new((i + j) as f64, i as f64).sin()
        });
        let x = least_squares(&a, &b).unwrap();
        for (i, j) in [(0, 0), (n / 2, 1), (n - 1, 2)] {
            // What rounding of the data by n eps may change in this entry: the column of the
            // pseudo-inverse.
            let rounding = (n * size[0]) as f64 * f64::EPSILON * condition * x.norm_max();
            let mut wrong = x.clone();
            wrong[(i, j)] += (1e-6 * x[(i, j)].norm()).max(100.0 * rounding);
            assert!(verify::least_squares(a.as_ref(), b.as_ref(), wrong.as_ref()).is_err());
        }

        let gram = complex_matrix(n, n, |i, j| {
            let scale = if i == j { 1.0 + 1e-13 } else { 1.0 };
            let products = (0..size[0]).map(|k| a[(k, i)].conj() * a[(k, j)]);
            products.sum::<Complex64>() * scale
        });
        if let Ok(lower) = cholesky(&gram) {
            for (i, j) in [(0, 0), (n - 1, 0), (n / 2, 1)] {
                let mut wrong = lower.clone();
                let size = gram[(i, i)].re.sqrt();
                wrong[(i, j)] += hundred_roundings(n, lower[(i, j)].norm() / size) * size;
                assert!(verify::cholesky(gram.as_ref(), wrong.as_ref()).is_err());
            }
        } else {
            assert!(
                condition > 1e8,
                "the square of the condition is beyond the precision"
            );
        }
    }
}

#[test]
fn solutions_of_square_systems_broken_on_purpose_are_caught() {
    for (condition, n) in [(1e4, 40), (1e12, 40), (1e4, 150), (1e12, 150)] {
        let a = conditioned([n, n], condition);
        let b = complex_matrix(n, 3, |i, j| {
            Complex64::from_polar(1.0, (i * i + 2 * j) as f64)
        });
        let right = solve_square(&a, &b).unwrap();
        let check = |x: &ComplexMatrix| verify::square_solution(&a, &b, x);
        check(&right).unwrap();
        for (i, j) in [(0, 0), (n / 2, 1), (n - 1, 2)] {
            let rounding = n as f64 * f64::EPSILON * condition * right.norm_max();
            let mut wrong = right.clone();
            wrong[(i, j)] += (1e-6 * right[(i, j)].norm()).max(100.0 * rounding);
            assert!(check(&wrong).is_err(), "({i}, {j}), {condition:e}");
            // The right solution of another matrix.
            let mut other = a.clone();
            let column = (i + 7 * j) % n;
            let entry = a[(i, column)].norm();
            other[(i, column)] += (1e-6 * entry).max(100.0 * n as f64 * f64::EPSILON * entry);
            let wrong = solve_square(&other, &b).unwrap();
            assert!(check(&wrong).is_err(), "A({i}, {column}), {condition:e}");
        }
        let mut wrong = right.clone();
        wrong[(n / 2, 0)] = Complex64::new(f64::NAN, 0.0);
        assert!(check(&wrong).is_err());
    }
}

#[test]
fn solutions_by_cholesky_broken_on_purpose_are_caught() {
    for (condition, n) in [(1e4f64, 40), (1e12, 40), (1e4, 150), (1e12, 150)] {
        let value = |i: usize| condition.powf(-(i as f64) / (n as f64 - 1.0));
        let turned = matrix_zoo::turned(&(0..n).map(value).collect::<Vec<_>>(), 5);
        // As it is, and with coordinates in units over six decades.
        for decades in [0.0, 6.0] {
            let unit = |i: usize| 10f64.powf(decades * i as f64 / n as f64);
            let a = real_matrix(n, n, |i, j| turned[(i, j)] * unit(i) * unit(j));
            let b = real_matrix(n, 2, |i, j| ((i * i + j) as f64).sin() * unit(i));
            let right = solve_definite(&a, &b).unwrap();
            let check = |x: &RealMatrix| verify::definite_solution(&a, &b, x);
            check(&right).unwrap();
            let root = |i: usize| a[(i, i)].sqrt();
            for (i, j) in [(0, 0), (n / 2, 1), (n - 1, 0)] {
                // In units in which the diagonal is 1.
                let size = (0..n).fold(0.0, |m: f64, k| m.max(root(k) * right[(k, j)].abs()));
                let rounding = n as f64 * f64::EPSILON * condition * size / root(i);
                let mut wrong = right.clone();
                wrong[(i, j)] += (1e-6 * right[(i, j)].abs()).max(100.0 * rounding);
                assert!(check(&wrong).is_err(), "({i}, {j}), {condition:e}");
                let mut other = a.clone();
                let entry = a[(i, i)];
                other[(i, i)] += (1e-6 * entry).max(100.0 * n as f64 * f64::EPSILON * entry);
                let wrong = solve_definite(&other, &b).unwrap();
                assert!(check(&wrong).is_err(), "A({i}, {i}), {condition:e}");
            }
        }
    }
}

#[test]
fn least_squares_broken_on_purpose_are_caught_beside_many_right_hand_sides() {
    for (condition, [m, n], count) in [
        (1e4, [200, 20], 1),
        (1e4, [200, 20], 400),
        (1e12, [200, 20], 400),
    ] {
        let a = conditioned([m, n], condition);
        let b = complex_matrix(m, count, |i, k| {
            Complex64::from_polar(1.0, ((i + 1) * (k + 3)) as f64)
        });
        let right = least_squares(&a, &b).unwrap();
        for (i, k) in [(0, 0), (n / 2, count / 2), (n - 1, count - 1)] {
            let rounding = (m * n) as f64 * f64::EPSILON * condition * right.norm_max();
            let mut wrong = right.clone();
            wrong[(i, k)] += (1e-6 * right[(i, k)].norm()).max(100.0 * rounding);
            let check = verify::least_squares(a.as_ref(), b.as_ref(), wrong.as_ref());
            assert!(check.is_err(), "({i}, {k}) of {count}, {condition:e}");
        }
    }
}

#[test]
fn eigenvalues_broken_on_purpose_are_caught() {
    for (condition, n) in [(1e4, 40), (1e12, 40), (1e12, 150)] {
        let a = conditioned([n, n], condition);
        let real = real_matrix(n, n, |i, j| a[(i, j)].re);
        let modes = general_modes(&real).unwrap();
        let norm = real.norm_l2();
        let check = |values: &[Complex64]| {
            verify::general_eigen(real.as_ref(), values, modes.vectors.as_ref())
        };
        check(&modes.values).unwrap();
        for j in [0, n / 2, n - 1] {
            let mut values = modes.values.clone();
            values[j] += hundred_roundings(n, modes.values[j].norm() / norm) * norm;
            assert!(check(&values).is_err(), "value {j}");
            let mut values = modes.values.clone();
            values[j] = values[(j + 1) % n];
            assert!(check(&values).is_err(), "value {j} replaced by another");
        }

        let symmetric = real_matrix(n, n, |i, j| {
            (0..n).map(|k| (a[(k, i)].conj() * a[(k, j)]).re).sum()
        });
        let right = symmetric_eigen(&symmetric).unwrap();
        let largest = right.values[n - 1];
        for j in [0, n / 2, n - 1] {
            let mut wrong = right.clone();
            wrong.values[j] += hundred_roundings(n, wrong.values[j] / largest) * largest;
            assert!(verify::symmetric_eigen(&symmetric, &wrong).is_err());
        }
        let mut wrong = right.clone();
        exchange(&mut wrong.vectors, [n - 1, n - 2]);
        assert!(verify::symmetric_eigen(&symmetric, &wrong).is_err());
        let mut wrong = right.clone();
        (0..n).for_each(|i| wrong.vectors[(i, 0)] = right.vectors[(i, 1)]);
        assert!(
            verify::symmetric_eigen(&symmetric, &wrong).is_err(),
            "one vector twice"
        );
    }
}

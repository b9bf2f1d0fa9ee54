//! Sparse modes against closed forms with exactly repeated roots: products of uniform bars with
//! consistent mass.

use super::pencil::Pencil;
use super::*;

/// Tridiagonal matrix of a uniform bar of `h`-long linear elements, with its ends held or free.
fn bar(nodes: usize, free: bool, diagonal: f64, beside: f64) -> Vec<(usize, usize, f64)> {
    let mut entries = Vec::new();
    for i in 0..nodes {
        let end = i == 0 || i == nodes - 1;
        let entry = if end && free {
            0.5 * diagonal
        } else {
            diagonal
        };
        entries.push((i, i, entry));
        if i + 1 < nodes {
            entries.extend([(i, i + 1, beside), (i + 1, i, beside)]);
        }
    }
    entries
}

/// Kronecker product of matrices given by entries, the second of a size.
fn kronecker(
    a: &[(usize, usize, f64)],
    b: &[(usize, usize, f64)],
    size: usize,
) -> Vec<(usize, usize, f64)> {
    let product = |&(i, j, x): &(usize, usize, f64)| {
        b.iter()
            .map(move |&(k, l, y)| (i * size + k, j * size + l, x * y))
    };
    a.iter().flat_map(product).collect()
}

/// K and M of a unit cube (or square, or bar) of `nodes` to each side in so many dimensions: `K =
/// sum K1 x M1 x M1`, `M = M1 x M1 x M1`, whose eigenvalues are all sums of those of the bar.
fn product(nodes: usize, dimensions: u32, free: bool) -> (SparseMatrix, SparseMatrix) {
    let h = spacing(nodes, free);
    let k1 = bar(nodes, free, 2.0 / h, -1.0 / h);
    let m1 = bar(nodes, free, 4.0 * h / 6.0, h / 6.0);
    let factor = |direction: &dyn Fn(u32) -> Vec<(usize, usize, f64)>| {
        (1..dimensions).fold(direction(0), |all, d| kronecker(&all, &direction(d), nodes))
    };
    let size = nodes.pow(dimensions);
    let stiffness: Vec<(usize, usize, f64)> = (0..dimensions)
        .flat_map(|along| factor(&|d| if d == along { k1.clone() } else { m1.clone() }))
        .collect();
    (
        SparseMatrix::from_entries(size, &stiffness).unwrap(),
        SparseMatrix::from_entries(size, &factor(&|_| m1.clone())).unwrap(),
    )
}

fn spacing(nodes: usize, free: bool) -> f64 {
    1.0 / if free { nodes - 1 } else { nodes + 1 } as f64
}

/// Every eigenvalue, ascending: `mu_i = 6/h^2 (1 - cos(i pi h)) / (2 + cos(i pi h))` summed over
/// the dimensions.
fn closed_form(nodes: usize, dimensions: u32, free: bool) -> Vec<f64> {
    let h = spacing(nodes, free);
    let first = if free { 0 } else { 1 };
    let root = |i: usize| {
        let (sin, cos) = (
            (0.5 * i as f64 * std::f64::consts::PI * h).sin(),
            (i as f64 * std::f64::consts::PI * h).cos(),
        );
        6.0 / (h * h) * 2.0 * sin * sin / (2.0 + cos)
    };
    let mut all = vec![0.0];
    for _ in 0..dimensions {
        let sums = all
            .iter()
            .flat_map(|sum| (first..first + nodes).map(move |i| sum + root(i)));
        all = sums.collect();
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Largest residual as a part of `|K| |phi|`, and largest distance of `Phi^T M Phi` from the
/// identity.
fn quality(k: &SparseMatrix, m: &SparseMatrix, modes: &SparseModes) -> (f64, f64) {
    let (kv, mv) = (k.multiply(&modes.vectors), m.multiply(&modes.vectors));
    let norm = |column: &dyn Fn(usize) -> f64| {
        (0..k.size()).map(|i| column(i).powi(2)).sum::<f64>().sqrt()
    };
    let largest = k.entries().map(|(_, _, v)| v.abs()).fold(0.0, f64::max);
    let residual = modes.omega_squared.iter().enumerate().map(|(j, lambda)| {
        norm(&|i| kv[(i, j)] - lambda * mv[(i, j)]) / (largest * norm(&|i| modes.vectors[(i, j)]))
    });
    let gram = modes.vectors.transpose() * &mv;
    let places = (0..gram.nrows()).flat_map(|i| (0..gram.ncols()).map(move |j| (i, j)));
    let off = places.map(|(i, j)| (gram[(i, j)] - if i == j { 1.0 } else { 0.0 }).abs());
    (residual.fold(0.0, f64::max), off.fold(0.0, f64::max))
}

fn check(nodes: usize, dimensions: u32, free: bool, wanted: usize) -> SparseModes {
    let (k, m) = product(nodes, dimensions, free);
    let modes = sparse_modes(&k, &m, Wanted::Lowest(wanted), 1000).unwrap();
    let exact = closed_form(nodes, dimensions, free);
    let found = modes.omega_squared.len();
    assert!(found >= wanted.min(exact.len()), "{found}");
    let elastic = exact.iter().find(|value| **value > 1e-6).unwrap();
    for (value, exact) in modes.omega_squared.iter().zip(&exact) {
        assert!(
            (value - exact).abs() < 1e-10 * exact.max(*elastic),
            "{value} {exact}"
        );
    }
    let (residual, off) = quality(&k, &m, &modes);
    assert!(residual < 1e-11 && off < 1e-12, "{residual:e} {off:e}");
    if let Some(limit) = modes.counted_below {
        assert_eq!(exact.partition_point(|value| *value < limit), found);
    }
    modes
}

#[test]
fn a_square_membrane_has_its_double_roots() {
    let modes = check(30, 2, false, 20);
    assert!(modes.counted_below.is_some());
}

#[test]
fn roots_of_six_modes_are_found_by_a_block_of_four() {
    // i, j, k all different give six equal sums: with the first 40 of them three roots of six.
    check(9, 3, false, 40);
}

#[test]
fn a_free_membrane_has_its_rigid_body_mode_and_the_others_as_exact() {
    let modes = check(24, 2, true, 25);
    assert!(modes.omega_squared[0].abs() < 1e-9);
    assert!(modes.omega_squared[1] > 9.0);
}

#[test]
fn six_rigid_body_modes_are_one_root_however_few_are_wanted() {
    // Six free bars of 40 nodes that do not touch, of stiffness 1 to 1e8 and as heavy as that.
    let (nodes, bars) = (40, 6);
    let part = |(bar, scale): (usize, f64), entries: &[(usize, usize, f64)]| {
        let shifted = entries.iter();
        let shifted = shifted.map(|&(i, j, v)| (bar * nodes + i, bar * nodes + j, scale * v));
        shifted.collect::<Vec<_>>()
    };
    let (k, m) = (
        bar(nodes, true, 2.0, -1.0),
        bar(nodes, true, 2.0 / 3.0, 1.0 / 6.0),
    );
    let scaled = |entries: &[(usize, usize, f64)], tune: f64| {
        let all = (0..bars).zip([1.0, 3e2, 7e4, 2e6, 9e7, 1e8]);
        let all =
            all.flat_map(|(bar, scale)| part((bar, scale * (1.0 + tune * bar as f64)), entries));
        SparseMatrix::from_entries(nodes * bars, &all.collect::<Vec<_>>()).unwrap()
    };
    // The bars differ in their elastic roots by a tenth of the stiffness each.
    let (k, m) = (scaled(&k, 0.1), scaled(&m, 0.0));
    let first = 2.0 * (1.0 - (std::f64::consts::PI / 39.0).cos());
    let first = 3.0 * first / (2.0 + (std::f64::consts::PI / 39.0).cos());
    for wanted in 1..9 {
        let modes = sparse_modes(&k, &m, Wanted::Lowest(wanted), 100).unwrap();
        assert_eq!(modes.omega_squared.len(), wanted.max(6), "{wanted}");
        for (number, lambda) in modes.omega_squared.iter().enumerate() {
            let expected = match number {
                0..6 => 0.0,
                _ => first * (1.0 + 0.1 * (number - 6) as f64),
            };
            assert!(
                (lambda - expected).abs() < 1e-9 * first,
                "{wanted} {number}: {lambda}"
            );
        }
    }
}

#[test]
fn all_modes_of_a_small_pair_are_found() {
    for free in [false, true] {
        let all = check(4, 2, free, 16);
        assert_eq!((all.omega_squared.len(), all.counted_below), (16, None));
        assert_eq!(check(4, 2, free, 99).omega_squared.len(), 16);
        check(4, 2, free, 1);
    }
    assert_eq!(check(1, 1, false, 1).omega_squared.len(), 1);
}

#[test]
fn a_band_has_exactly_the_modes_below_its_upper_limit() {
    let (k, m) = product(25, 2, false);
    let exact = closed_form(25, 2, false);
    // Between roots, among them just beside a double one, and below all.
    for limit in [exact[10] * 1.000_01, exact[10] * 0.999_99, 300.0, 1.0] {
        let modes = sparse_modes(&k, &m, Wanted::Below(limit), 1000).unwrap();
        let expected = exact.partition_point(|value| *value < limit);
        assert_eq!(modes.omega_squared.len(), expected, "{limit}");
        assert_eq!(modes.counted_below, Some(limit));
    }
    let error = sparse_modes(&k, &m, Wanted::Below(1e5), 50).unwrap_err();
    assert!(matches!(error, LinalgError::TooManyModes { got, most: 50 } if got > 50));
}

#[test]
fn the_eigenvalue_count_equals_the_dense_spectrum() {
    let (k, m) = product(7, 2, true);
    let exact = closed_form(7, 2, true);
    let pencil = pencil::Pencil::new(&k, &m).unwrap();
    for pair in exact.windows(2).filter(|pair| pair[1] - pair[0] > 1e-3) {
        let shift = 0.5 * (pair[0] + pair[1]);
        let expected = exact.partition_point(|value| *value < shift);
        assert_eq!(pencil.count_below(shift).unwrap(), expected, "{shift}");
    }
    assert_eq!(pencil.count_below(-1.0).unwrap(), 0);
    assert_eq!(pencil.count_below(1e9).unwrap(), 49);
}

#[test]
fn equal_uncoupled_oscillators_are_one_repeated_root() {
    // Forty equal roots, ten times the block, and one beside them.
    let diagonal = |value: &dyn Fn(usize) -> f64| -> Vec<(usize, usize, f64)> {
        (0..60).map(|i| (i, i, value(i))).collect()
    };
    let k = diagonal(&|i| if i < 40 { 4.0 } else { 9.0 + i as f64 });
    let k = SparseMatrix::from_entries(60, &k).unwrap();
    let m = SparseMatrix::from_entries(60, &diagonal(&|_| 1.0)).unwrap();
    let modes = sparse_modes(&k, &m, Wanted::Lowest(3), 1000).unwrap();
    assert_eq!(modes.omega_squared.len(), 40);
    assert!(modes.omega_squared.iter().all(|v| (v - 4.0).abs() < 1e-10));
}

#[test]
fn a_root_of_many_modes_among_others_is_found_whole() {
    // Thirty equal roots below 870 others, of which a block of four sees four at first.
    let value = |i: usize| if i % 30 == 7 { 4.0 } else { 9.0 + i as f64 };
    let k: Vec<(usize, usize, f64)> = (0..900).map(|i| (i, i, value(i))).collect();
    let k = SparseMatrix::from_entries(900, &k).unwrap();
    let ones: Vec<(usize, usize, f64)> = (0..900).map(|i| (i, i, 1.0)).collect();
    let m = SparseMatrix::from_entries(900, &ones).unwrap();
    let modes = sparse_modes(&k, &m, Wanted::Lowest(10), 1000).unwrap();
    let equal = modes
        .omega_squared
        .iter()
        .filter(|v| (*v - 4.0).abs() < 1e-10);
    assert_eq!(equal.count(), 30);
}

#[test]
fn the_highest_root_comes_whole_as_well() {
    let diagonal: Vec<(usize, usize, f64)> = (0..4)
        .zip([1.0, 2.0, 3.0, 3.0])
        .map(|(i, k)| (i, i, k))
        .collect();
    let stiffness = SparseMatrix::from_entries(4, &diagonal).unwrap();
    let unit: Vec<(usize, usize, f64)> = (0..4).map(|i| (i, i, 1.0)).collect();
    let mass = SparseMatrix::from_entries(4, &unit).unwrap();
    let modes = sparse_modes(&stiffness, &mass, Wanted::Lowest(3), 10).unwrap();
    assert_eq!(modes.omega_squared.len(), 4);
}

#[test]
fn indefinite_matrices_are_errors() {
    let (k, m) = product(5, 2, false);
    let negative = SparseMatrix::weighted_sum(25, &[(-1.0, &m)]).unwrap();
    let solve = |k, m| sparse_modes(k, m, Wanted::Lowest(3), 1000).unwrap_err();
    let error = solve(&k, &negative);
    assert_eq!(error, LinalgError::MassNotPositiveDefinite { size: 25 });
    let mut entries: Vec<_> = k.entries().collect();
    entries.push((0, 0, -1e6));
    let k = SparseMatrix::from_entries(25, &entries).unwrap();
    let error = solve(&k, &m);
    assert_eq!(error, LinalgError::NotPositiveDefinite { size: 25 });
}

#[test]
fn entries_add_up_and_those_outside_are_refused() {
    let a = SparseMatrix::from_entries(2, &[(1, 0, 2.0), (0, 1, 3.0), (1, 0, 0.5)]).unwrap();
    assert_eq!((a.entry_count(), a.get(1, 0), a.get(0, 0)), (2, 2.5, 0.0));
    let x = real_matrix(2, 1, |i, _| [10.0, 100.0][i]);
    let y = a.multiply(&x);
    assert_eq!((y[(0, 0)], y[(1, 0)]), (300.0, 25.0));
    let form = a.quadratic_form(&[10.0, -1.0]);
    assert_eq!((form.value, form.magnitude), (-55.0, 55.0));
    assert!((a.to_dense()[(0, 1)] - 3.0).abs() < 1e-15);
    let sum = SparseMatrix::weighted_sum(2, &[(2.0, &a), (-1.0, &a)]).unwrap();
    assert_eq!(sum, a);
    let error = SparseMatrix::from_entries(2, &[(2, 0, 1.0)]).unwrap_err();
    assert_eq!(
        error,
        LinalgError::OutsideMatrix {
            row: 2,
            column: 0,
            size: 2
        }
    );
}

#[test]
fn sparse_modes_broken_on_purpose_are_caught() {
    let (k, m) = product(6, 2, true);
    let right = sparse_modes(&k, &m, Wanted::Lowest(8), 100).unwrap();
    let shift = 1.0;
    let pencil = Pencil::new(&k, &m).unwrap();
    let factor = pencil.cholesky(1.0, -shift).unwrap();
    let check = |modes: &SparseModes| {
        verify::sparse_modes(&k, &m, modes, shift, |x: &mut RealMatrix| factor.solve(x))
    };
    check(&right).unwrap();
    let last = right.omega_squared.len() - 1;
    type Change<'a> = (&'a str, &'a dyn Fn(&mut SparseModes));
    let changes: [Change<'_>; 5] = [
        ("smallest elastic root doubled", &|modes| {
            modes.omega_squared[1] *= 2.0
        }),
        ("value off by a millionth", &|modes| {
            modes.omega_squared[last] *= 1.0 + 1e-6
        }),
        ("phantom", &|modes| {
            modes.omega_squared[3] = 0.5 * modes.omega_squared[4]
        }),
        ("vectors exchanged", &|modes| {
            for i in 0..m.size() {
                let (a, b) = (modes.vectors[(i, 1)], modes.vectors[(i, last)]);
                (modes.vectors[(i, 1)], modes.vectors[(i, last)]) = (b, a);
            }
        }),
        ("one vector twice", &|modes| {
            for i in 0..m.size() {
                modes.vectors[(i, 2)] = modes.vectors[(i, 1)];
            }
        }),
    ];
    for (what, change) in changes {
        let mut wrong = right.clone();
        change(&mut wrong);
        assert!(check(&wrong).is_err(), "{what} passes");
    }
    // A factor of another matrix.
    let other = pencil.cholesky(1.0, -1.000_001 * shift).unwrap();
    let sum = SparseMatrix::weighted_sum(m.size(), &[(1.0, &k), (shift, &m)]).unwrap();
    let diagonal: Vec<f64> = (0..m.size()).map(|i| sum.get(i, i).abs()).collect();
    verify::sparse_factor(verify::MAX_CHOLESKY_ERROR, &sum, &diagonal, |x| {
        factor.solve(x)
    })
    .unwrap();
    let wrong = verify::sparse_factor(verify::MAX_CHOLESKY_ERROR, &sum, &diagonal, |x| {
        other.solve(x)
    });
    assert!(matches!(wrong, Err(LinalgError::Inaccurate { .. })));
}

/// The square of the second difference, of condition `0.16 n^4`, with a diagonal of 1 but at its
/// ends.
fn bending(n: usize) -> SparseMatrix {
    let row = |i: usize| [(i, 2.0), (i.wrapping_sub(1), -1.0), (i + 1, -1.0)];
    let entries = (0..n).flat_map(|k| {
        let inside = move |&(i, _): &(usize, f64)| i < n;
        let pairs = row(k).into_iter().filter(inside);
        pairs.flat_map(move |(i, a)| {
            let others = row(k).into_iter().filter(inside);
            others.map(move |(j, b)| (i, j, a * b / 6.0))
        })
    });
    SparseMatrix::from_entries(n, &entries.collect::<Vec<_>>()).unwrap()
}

#[test]
fn factors_broken_on_purpose_are_caught() {
    // Conditions 1e4 and 1e12.
    for n in [16, 1600] {
        let (k, m) = (bending(n), unit(n));
        let pencil = Pencil::new(&k, &m).unwrap();
        // Between the third and the fourth eigenvalue.
        let sigma =
            (2.0 - 2.0 * (3.5 * std::f64::consts::PI / (n as f64 + 1.0)).cos()).powi(2) / 6.0;
        assert_eq!(pencil.count_below(sigma).unwrap(), 3);
        let shifted =
            |factor: f64| SparseMatrix::weighted_sum(n, &[(1.0, &k), (factor, &m)]).unwrap();
        let diagonal =
            |sigma: f64| -> Vec<f64> { (0..n).map(|i| k.get(i, i) + sigma.abs()).collect() };
        let off = |pivot: f64| (1e-6 * pivot.abs()).max(100.0 * n as f64 * f64::EPSILON);
        let right = pencil.indefinite(sigma).unwrap();
        let places = right.pivots();
        for place in [0, n / 3, n - 1].map(|pivot| places[pivot]) {
            let mut wrong = pencil.indefinite(sigma).unwrap();
            wrong.values[place] += off(wrong.values[place]);
            let (matrix, diagonal) = (shifted(-sigma), diagonal(sigma));
            let check = verify::sparse_factor(verify::MAX_INERTIA_ERROR, &matrix, &diagonal, |x| {
                wrong.solve(x)
            });
            assert!(check.is_err(), "pivot at {place} of {n}");
        }
        let shift = 1e-12;
        for place in [0, n / 3, n - 1].map(|pivot| places[pivot]) {
            let mut wrong = pencil.cholesky(1.0, -shift).unwrap();
            // The square of the entry is the pivot.
            let root = wrong.values[place];
            wrong.values[place] = (root * root + off(root * root)).sqrt();
            let (matrix, diagonal) = (shifted(shift), diagonal(shift));
            let check =
                verify::sparse_factor(verify::MAX_CHOLESKY_ERROR, &matrix, &diagonal, |x| {
                    wrong.solve(x)
                });
            assert!(check.is_err(), "root at {place} of {n}");
        }
    }
}

#[test]
fn a_repeated_root_at_the_limit_is_counted_whole() {
    // A square grid of equal oscillators: 4 - 2c (cos a_i + cos a_j), of which a row's number of
    // values are 4.
    for side in [6, 8, 9] {
        let n = side * side;
        let coupling = 1e-3;
        let mut entries: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 4.0)).collect();
        for i in 0..n {
            let right = (i % side + 1 < side).then_some(i + 1);
            let below = (i + side < n).then_some(i + side);
            for j in [right, below].into_iter().flatten() {
                entries.extend([(i, j, -coupling), (j, i, -coupling)]);
            }
        }
        let k = SparseMatrix::from_entries(n, &entries).unwrap();
        let modes = sparse_modes(&k, &unit(n), Wanted::Below(4.0), n).unwrap();
        assert_eq!(modes.omega_squared.len(), (n + side) / 2, "{side}");
    }
}

#[test]
fn eigenvalues_are_counted_where_diagonal_entries_vanish() {
    // A chain between walls, and equal oscillators coupled in a row, with the shift at the mean of
    // their eigenvalues.
    let chain = 1200;
    let angle = |j: f64| 0.5 * std::f64::consts::PI * j / (chain as f64 + 1.0);
    let shift = (2.0 * angle(30.5).sin()).powi(2);
    for oscillators in [2, 3, 6, 10] {
        let n = chain + oscillators;
        let mut entries: Vec<(usize, usize, f64)> = Vec::new();
        for i in 0..n {
            let (diagonal, coupling) = if i < chain {
                (2.0, -1.0)
            } else {
                (shift, -1e-3 * shift)
            };
            entries.push((i, i, diagonal));
            if i > 0 && i != chain {
                entries.extend([(i, i - 1, coupling), (i - 1, i, coupling)]);
            }
        }
        let k = SparseMatrix::from_entries(n, &entries).unwrap();
        let m = unit(n);
        let pencil = Pencil::new(&k, &m).unwrap();
        // An odd number of oscillators has an eigenvalue at their mean. Diagonal entries are 0, or
        // rounding.
        for part in [0.0, 4e-16, -4e-16, 1e-13] {
            let below = shift * (1.0 + part - 1e-5 * (oscillators % 2) as f64);
            let count = pencil.count_below(below).unwrap();
            assert_eq!(count, 30 + oscillators / 2, "{oscillators}, {part:e}");
        }
    }
}

fn unit(n: usize) -> SparseMatrix {
    SparseMatrix::from_entries(n, &(0..n).map(|i| (i, i, 1.0)).collect::<Vec<_>>()).unwrap()
}

#[test]
fn many_modes_of_a_chain_are_exact_at_any_scale() {
    // Between two walls: omega^2 = 4 k/m sin^2(j pi / 2(n + 1)).
    let n = 600;
    let one = 0..n;
    for stiffness in [1.0, 1e10, 1e14] {
        let diagonal = one.clone().map(|i| (i, i, 2.0 * stiffness));
        let beside = (0..n - 1).flat_map(|i| [(i, i + 1, -stiffness), (i + 1, i, -stiffness)]);
        let k = SparseMatrix::from_entries(n, &diagonal.chain(beside).collect::<Vec<_>>());
        let m =
            SparseMatrix::from_entries(n, &one.clone().map(|i| (i, i, 1.0)).collect::<Vec<_>>());
        let modes = sparse_modes(&k.unwrap(), &m.unwrap(), Wanted::Lowest(150), n).unwrap();
        for (j, got) in modes.omega_squared.iter().enumerate().take(150) {
            let angle = (j + 1) as f64 * std::f64::consts::PI / (2.0 * (n + 1) as f64);
            let exact = 4.0 * stiffness * angle.sin().powi(2);
            assert!(
                (got / exact - 1.0).abs() < 1e-11,
                "{stiffness:e} {j}: {got} {exact}"
            );
        }
    }
}

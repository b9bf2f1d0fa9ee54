//! Time of the lowest modes of sparse structures with exactly repeated roots and consistent mass,
//! factorisations and the count included, beside scipy's shift-invert eigsh on the same matrices.
//! Prints ratios; asserts no timing.
//!
//! `cargo bench --bench sparse_modes`. scipy is run with the Python that `MODALIGN_PYTHON` names,
//! else `python3`, by `tests/reference/sparse_eigsh.py`; without it the bench prints this time
//! alone.

use std::process::Command;
use std::time::Instant;

use modalign::linalg::{SparseMatrix, Wanted, sparse_modes};

/// Modes asked for.
const MODES: usize = 30;
/// Each is solved so often, and the fastest counts.
const REPEATS: usize = 3;

type Entries = Vec<(usize, usize, f64)>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (dimensions, nodes) in [(2, 150), (3, 28)] {
        let size = nodes_of(nodes, dimensions);
        let [k, m] = structure(nodes, dimensions)?;
        let mut fastest = f64::MAX;
        let mut found = None;
        for _ in 0..REPEATS {
            let start = Instant::now();
            found = Some(sparse_modes(&k, &m, Wanted::Lowest(MODES), 1000)?);
            fastest = fastest.min(start.elapsed().as_secs_f64());
        }
        let found = found.ok_or("solved at least once")?;
        let exact = closed_form(nodes, dimensions);
        let limit = found.counted_below.ok_or("fewer than all modes")?;
        let expected = exact.partition_point(|value| *value < limit);
        let pairs = found.omega_squared.iter().zip(&exact);
        let error = pairs.map(|(found_value, exact)| (found_value / exact - 1.0).abs());
        println!(
            "{size} coordinates, {} entries of K: {} modes ({expected} exist below the limit), largest relative error {:.1e}, {} solves, {fastest:.3} s",
            k.entry_count(),
            found.omega_squared.len(),
            error.fold(0.0, f64::max),
            found.solves
        );
        match scipy(dimensions, nodes) {
            Some((version, seconds)) => println!(
                "    {version}: {seconds:.3} s; time over scipy's {:.2}",
                fastest / seconds
            ),
            None => println!("    scipy was not found"),
        }
    }
    Ok(())
}

fn nodes_of(nodes: usize, dimensions: usize) -> usize {
    (0..dimensions).map(|_| nodes).product()
}

/// Seconds of scipy on the same matrices.
fn scipy(dimensions: usize, nodes: usize) -> Option<(String, f64)> {
    let python = std::env::var("MODALIGN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/reference/sparse_eigsh.py"
    );
    let numbers = [dimensions, nodes, MODES].map(|number| number.to_string());
    let output = Command::new(python)
        .arg(script)
        .args(numbers)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut lines = text.lines();
    let version = lines.next()?.split(" numpy").next()?.to_owned();
    let seconds = lines.next()?.strip_prefix("seconds ")?.parse().ok()?;
    Some((version, seconds))
}

/// Tridiagonal matrix of a uniform bar whose ends are held.
fn bar(nodes: usize, diagonal: f64, beside: f64) -> Entries {
    let near = |i: usize| {
        [
            i.checked_sub(1),
            Some(i),
            Some(i + 1).filter(|j| *j < nodes),
        ]
    };
    let entry = |i: usize, j: usize| (i, j, if i == j { diagonal } else { beside });
    let rows = (0..nodes).flat_map(|i| near(i).into_iter().flatten().map(move |j| entry(i, j)));
    rows.collect()
}

fn kronecker(a: &Entries, b: &Entries, size: usize) -> Entries {
    let product = |&(i, j, x): &(usize, usize, f64)| {
        b.iter()
            .map(move |&(k, l, y)| (i * size + k, j * size + l, x * y))
    };
    a.iter().flat_map(product).collect()
}

/// K and M of a unit square or cube with `nodes` to each side.
fn structure(
    nodes: usize,
    dimensions: usize,
) -> Result<[SparseMatrix; 2], Box<dyn std::error::Error>> {
    let h = 1.0 / (nodes + 1) as f64;
    let (k1, m1) = (
        bar(nodes, 2.0 / h, -1.0 / h),
        bar(nodes, 4.0 * h / 6.0, h / 6.0),
    );
    let product = |along: Option<usize>| {
        let factor = |d: usize| if along == Some(d) { &k1 } else { &m1 };
        (1..dimensions).fold(factor(0).clone(), |all, d| {
            kronecker(&all, factor(d), nodes)
        })
    };
    let size = nodes_of(nodes, dimensions);
    let stiffness: Entries = (0..dimensions).flat_map(|d| product(Some(d))).collect();
    Ok([
        SparseMatrix::from_entries(size, &stiffness)?,
        SparseMatrix::from_entries(size, &product(None))?,
    ])
}

/// The eigenvalues: sums of those of the bar, `6/h^2 (1 - cos(i pi h)) / (2 + cos(i pi h))`.
fn closed_form(nodes: usize, dimensions: usize) -> Vec<f64> {
    let h = 1.0 / (nodes + 1) as f64;
    let root = |i: usize| {
        let angle = i as f64 * std::f64::consts::PI * h;
        12.0 / (h * h) * (0.5 * angle).sin().powi(2) / (2.0 + angle.cos())
    };
    let mut all = vec![0.0];
    for _ in 0..dimensions {
        all = all
            .iter()
            .flat_map(|sum| (1..=nodes).map(move |i| sum + root(i)))
            .collect();
    }
    all.sort_by(f64::total_cmp);
    all
}

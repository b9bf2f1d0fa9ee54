//! Every specimen of the zoo of matrices against extended precision.

use rayon::prelude::*;

use crate::draws;
use crate::extended_precision::compared;
use crate::matrix_zoo::zoo;

/// Largest number of coordinates, divided as draws are.
const COORDINATES: u64 = 2000;
/// Fewest specimens.
const SPECIMENS: u64 = 60;

#[test]
fn lowest_frequencies_of_every_specimen_are_within_their_bounds() {
    let specimens = zoo(draws(COORDINATES) as usize);
    assert!(
        specimens.len() as u64 >= draws(SPECIMENS),
        "{}",
        specimens.len()
    );
    let rows: Vec<_> = specimens
        .par_iter()
        .map(|specimen| compared(specimen).unwrap())
        .collect();
    for row in &rows {
        println!("{row}");
        assert!(row.error_over_limit <= 1.0, "{row}");
        assert!(row.rigid_over_bound <= 1.0, "{row}");
        assert!(row.orthogonality < 1e-9 && row.residual < 1e-11, "{row}");
    }
}

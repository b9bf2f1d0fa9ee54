//! Every specimen of the zoo of matrices, up to 2,000 coordinates, against extended precision.

use rayon::prelude::*;

use crate::extended_precision::compared;
use crate::matrix_zoo::zoo;

#[test]
fn lowest_frequencies_of_every_specimen_are_within_their_bounds() {
    let specimens = zoo(2000);
    assert!(specimens.len() >= 60, "{}", specimens.len());
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

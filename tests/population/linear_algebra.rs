//! Every specimen of the zoo of matrices against extended precision.

use rayon::prelude::*;

use crate::extended_precision::compared;
use crate::matrix_zoo::zoo;
use crate::parts;

const MAX_COORDINATES: usize = 2000;
const MIN_SPECIMENS: usize = 60;

#[test]
fn lowest_frequencies_of_every_specimen_are_within_their_bounds() {
    let specimens = zoo(MAX_COORDINATES);
    assert!(specimens.len() >= MIN_SPECIMENS, "{}", specimens.len());
    let rows: Vec<_> = specimens
        .par_iter()
        .step_by(parts() as usize)
        .map(|specimen| compared(specimen).unwrap())
        .collect();
    for row in &rows {
        println!("{row}");
        assert!(row.error_over_limit <= 1.0, "{row}");
        assert!(row.rigid_over_bound <= 1.0, "{row}");
        assert!(row.orthogonality < 1e-9 && row.residual < 1e-11, "{row}");
    }
}

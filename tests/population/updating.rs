//! Updating of synthetic twins: 95 % intervals of the parameters cover 94 to 96 % of 2,000 and more, updated frequencies are
//! right, and a stiffness that no sensor sees is named every time.

use rayon::prelude::*;

use crate::twins::{Tally, Twin, lumped, torsional, twin};

#[test]
fn intervals_of_parameters_hold_the_truth_as_often_as_they_say() {
    let mut all = Tally::default();
    for (machine, count) in [(lumped(), 500), (torsional(), 300)] {
        let twins: Vec<Twin> = (0..count)
            .into_par_iter()
            .map(|n| twin(&machine, n))
            .collect();
        let mut own = Tally::default();
        for twin in &twins {
            own.add(&machine, twin);
            all.add(&machine, twin);
        }
        let expected = if machine.unseen.is_some() {
            own.twins
        } else {
            0
        };
        assert_eq!(own.unseen_named, expected, "{own:?}");
        println!("{}: {own:?}", machine.model.name());
    }
    let share = all.inside as f64 / all.intervals as f64;
    assert!(
        all.intervals >= 2000 && (0.94..0.96).contains(&share),
        "{all:?}"
    );
    // Frequencies are known to 0.02 %; five deviations of that.
    assert!(all.largest_error_percent < 0.1, "{all:?}");
}

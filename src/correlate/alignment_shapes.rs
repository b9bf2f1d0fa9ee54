//! Shapes select among frames in which the points of a test fit those of a theory equally well.

use super::dof_names::{DofNames, LocatedModes};
use super::shapes::Shapes;
use super::similarity::Similarity;
use super::{DofMap, PairOptions};

/// Mean over the test modes of the largest MAC with a theory mode within the frequency gate, in a
/// frame; a mode without any within it counts 0. `None` where no mode has a MAC.
///
/// Rotations are left out without [`PairOptions::rotation_length_m`].
pub fn mean_largest_mac(
    test: &LocatedModes<'_>,
    theory: &LocatedModes<'_>,
    frame: &Similarity,
    tolerance_m: f64,
    options: &PairOptions,
) -> Option<f64> {
    let (names, _) = DofNames::nearest(test, theory, frame, tolerance_m).ok()?;
    let (test, theory) = (test.modes, &names.rename(theory.modes));
    let map = DofMap::of_models(test, theory);
    let map = match options.rotation_length_m.is_none() && map.has_both_kinds() {
        true => map.without_rotations().0,
        false => map,
    };
    let matrix = Shapes::new(test, theory, &map, options).ok()?.mac_matrix();
    let of_mode = |(mode, macs): (&crate::modal::Mode, Vec<Option<f64>>)| {
        let near = theory.modes.iter().zip(macs).filter(|(other, _)| {
            let apart = (mode.frequency_hz - other.frequency_hz).abs();
            apart <= options.max_frequency_error * other.frequency_hz
        });
        near.filter_map(|(_, mac)| mac).fold(0.0, f64::max)
    };
    let with_mac = matrix.iter().any(|row| row.iter().any(Option::is_some));
    let largest: Vec<f64> = test.modes.iter().zip(matrix).map(of_mode).collect();
    with_mac.then(|| largest.iter().sum::<f64>() / largest.len() as f64)
}

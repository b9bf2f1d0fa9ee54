//! Roots group the modes of a theory that share a natural frequency; each root is one row of a
//! table and one partner of a test mode.

use crate::modal::ModalModel;

use super::CorrelateError;

/// Maximum relative spacing of modes of one root without a group number: files hold seven digits.
const MAX_SPACING_OF_ONE_ROOT: f64 = 1e-6;

/// Maximum frequency of a rigid-body mode over that of the next root, in modes from a file.
/// Rounding makes of an eigenvalue 0 some 1e-16 of the highest of the model, which is 1e8 to 1e10
/// times the lowest elastic one: 1e-3 to 1e-4 of its frequency or less.
const MAX_RIGID_OVER_NEXT_HZ: f64 = 1e-3;

/// Rigid-body modes of one body: those at 0 Hz and those that rounding moved from 0.
const MAX_RIGID_BODY_MODES: usize = 6;

/// Maximum frequency of a rigid-body mode, Hz: a hammer test measures no mode as low.
const MAX_RIGID_HZ: f64 = 0.1;

/// One elastic root of a theory with all modes that share it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Root {
    /// Indices of its modes, ascending.
    pub modes: Vec<usize>,
    /// Their mean frequency, Hz.
    pub hz: f64,
}

/// The highest frequency of a rigid-body mode, Hz; 0 where none has another.
///
/// The eigensolver of `theory` returns rigid-body modes at exactly 0. In modes from a file, of the
/// lowest six, those above 0 Hz before the first rise by a factor of a thousand are rigid-body
/// modes that rounding moved from 0, if they are at most 0.1 Hz. A rise between higher modes shows
/// no rigid-body modes.
pub(crate) fn highest_rigid_hz(theory: &ModalModel) -> f64 {
    let mut lowest: Vec<f64> = theory.modes.iter().map(|mode| mode.frequency_hz).collect();
    lowest.sort_by(f64::total_cmp);
    // The rise after the sixth mode needs the seventh.
    lowest.truncate(MAX_RIGID_BODY_MODES + 1);
    let mut rises = lowest.windows(2).filter(|next| next[0] > 0.0);
    let rise = rises.find(|next| next[0] <= MAX_RIGID_OVER_NEXT_HZ * next[1]);
    let below = rise.map_or(0.0, |next| next[0]);
    if below <= MAX_RIGID_HZ { below } else { 0.0 }
}

/// The elastic roots in ascending frequency; modes of one group number or one frequency are one
/// root; rigid-body modes are left out.
pub(super) fn elastic_roots(theory: &ModalModel) -> Vec<Root> {
    let root = |modes: Vec<usize>| {
        let sum: f64 = modes.iter().map(|&j| theory.modes[j].frequency_hz).sum();
        Root {
            hz: sum / modes.len() as f64,
            modes,
        }
    };
    let rigid_hz = highest_rigid_hz(theory);
    let elastic = |modes: &Vec<usize>| theory.modes[modes[0]].frequency_hz > rigid_hz;
    let mut roots: Vec<Root> = theory
        .roots()
        .into_iter()
        .filter(elastic)
        .map(root)
        .collect();
    roots.sort_by(|a, b| a.hz.total_cmp(&b.hz).then_with(|| a.modes.cmp(&b.modes)));
    roots.dedup_by(|next, root| {
        let same = next.hz - root.hz <= MAX_SPACING_OF_ONE_ROOT * root.hz;
        if same {
            root.modes.append(&mut next.modes);
            root.modes.sort_unstable();
        }
        same
    });
    roots
}

/// Indices of the modes above 0 Hz.
pub(super) fn elastic_modes(model: &ModalModel) -> Vec<usize> {
    let above = |j: &usize| model.modes[*j].frequency_hz > 0.0;
    (0..model.modes.len()).filter(above).collect()
}

/// Checks that every frequency is finite and not negative, and every shape value finite.
pub(super) fn check_model(name: &'static str, model: &ModalModel) -> Result<(), CorrelateError> {
    for (number, mode) in (1..).zip(&model.modes) {
        let got_hz = mode.frequency_hz;
        if !(got_hz.is_finite() && got_hz >= 0.0) {
            return Err(CorrelateError::Frequency {
                model: name,
                number,
                got_hz,
            });
        }
        if !mode.shape.iter().all(|(_, value)| value.is_finite()) {
            let model = name;
            return Err(CorrelateError::ShapeValue { model, number });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlate::pairing_tests::{mode, model};

    fn elastic_hz(all: &[f64]) -> Vec<f64> {
        let modes = all.iter().map(|hz| mode(*hz, &[])).collect();
        let roots = elastic_roots(&model(modes));
        roots.iter().map(|root| root.hz).collect()
    }

    #[test]
    fn rigid_body_modes_at_rounding_level_are_no_roots() {
        let free = [1e-4, 2e-4, 3.1e-3, 12.0, 30.0];
        assert_eq!(elastic_hz(&free), [12.0, 30.0]);
        // Some of them at exactly 0, others not.
        assert_eq!(elastic_hz(&[0.0, 1e-3, 12.0]), [12.0]);
        assert_eq!(elastic_hz(&[0.0, 0.0, 1e-4, 12.0]), [12.0]);
        // Soft slings are an elastic root, and so is what a test can measure, whatever follows.
        assert_eq!(elastic_hz(&[0.1, 12.0, 30.0]), [0.1, 12.0, 30.0]);
        assert_eq!(elastic_hz(&[0.2, 300.0]), [0.2, 300.0]);
        assert_eq!(elastic_hz(&[]), [0.0; 0]);
    }

    #[test]
    fn a_stiff_mode_above_the_others_does_not_make_them_rigid() {
        let grounded = [5.0, 12.0, 30.0, 50000.0];
        assert_eq!(elastic_hz(&grounded), grounded);
        assert_eq!(elastic_hz(&[1e-4, 12.0, 30.0, 50000.0]), grounded[1..]);
    }

    #[test]
    fn rigid_body_modes_are_six_at_most() {
        let six = [0.0, 0.0, 1e-4, 1e-4, 2e-4, 2e-4, 12.0];
        assert_eq!(elastic_hz(&six), [12.0]);
        let seven = [0.0, 0.0, 1e-4, 1.1e-4, 1.2e-4, 1.3e-4, 1.4e-4, 12.0];
        assert_eq!(elastic_hz(&seven), seven[2..]);
    }
}

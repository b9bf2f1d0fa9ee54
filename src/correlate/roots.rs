//! Modes of a theory gathered by root: what one row of a table, and one partner of a test mode, is.

use crate::modal::ModalModel;

use super::CorrelateError;

/// Frequencies of one root agree to this part, where no group numbers say so: files hold seven digits.
const SAME_ROOT: f64 = 1e-6;

/// One elastic root of a theory with all modes that share it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Root {
    /// Indices of its modes, ascending.
    pub modes: Vec<usize>,
    /// Their mean frequency, Hz.
    pub hz: f64,
}

/// The elastic roots in ascending frequency; modes of one group number or one frequency are one root, modes at 0 Hz are
/// left out.
pub(super) fn elastic_roots(theory: &ModalModel) -> Vec<Root> {
    let root = |modes: Vec<usize>| {
        let sum: f64 = modes.iter().map(|&j| theory.modes[j].frequency_hz).sum();
        Root {
            hz: sum / modes.len() as f64,
            modes,
        }
    };
    let elastic = |modes: &Vec<usize>| theory.modes[modes[0]].frequency_hz > 0.0;
    let mut roots: Vec<Root> = theory
        .roots()
        .into_iter()
        .filter(elastic)
        .map(root)
        .collect();
    roots.sort_by(|a, b| a.hz.total_cmp(&b.hz).then_with(|| a.modes.cmp(&b.modes)));
    roots.dedup_by(|next, own| {
        let same = next.hz - own.hz <= SAME_ROOT * own.hz;
        if same {
            own.modes.append(&mut next.modes);
            own.modes.sort_unstable();
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

/// Every frequency is finite and not negative, every shape value finite.
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

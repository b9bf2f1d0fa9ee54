//! Modes of a theory gathered by root: what one row of a table, and one partner of a test mode, is.

use std::collections::BTreeMap;

use crate::modal::ModalModel;

use super::CorrelateError;

/// One elastic root of a theory with all modes that share it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Root {
    /// Indices of its modes, ascending.
    pub modes: Vec<usize>,
    /// Their mean frequency, Hz.
    pub hz: f64,
}

/// The elastic roots in ascending frequency; modes of one group number are one root, modes at 0 Hz are left out.
pub(super) fn elastic_roots(theory: &ModalModel) -> Vec<Root> {
    let elastic = elastic_modes(theory);
    let mut members: BTreeMap<(usize, u32), Vec<usize>> = BTreeMap::new();
    for &j in &elastic {
        // Modes without a group number are told apart by their own index, which a group number never meets.
        let key = theory.modes[j].group.map_or((j + 1, 0), |g| (0, g));
        members.entry(key).or_default().push(j);
    }
    let root = |modes: Vec<usize>| {
        let sum: f64 = modes.iter().map(|&j| theory.modes[j].frequency_hz).sum();
        Root {
            hz: sum / modes.len() as f64,
            modes,
        }
    };
    let mut roots: Vec<Root> = members.into_values().map(root).collect();
    roots.sort_by(|a, b| a.hz.total_cmp(&b.hz).then_with(|| a.modes.cmp(&b.modes)));
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

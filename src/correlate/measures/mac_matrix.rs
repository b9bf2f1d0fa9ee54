//! A MAC matrix compares every mode of one set with every mode of another.

use serde::Serialize;

use crate::modal::ModalModel;

use super::super::shapes::Shapes;

/// Number of degrees of freedom of the values of a matrix, which differ where shapes have gaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
pub struct DofRange {
    /// The fewest.
    pub fewest: usize,
    /// The most.
    pub most: usize,
}

impl DofRange {
    /// Over some counts; zero of none.
    pub(super) fn over(counts: impl Iterator<Item = usize> + Clone) -> Self {
        Self {
            fewest: counts.clone().min().unwrap_or(0),
            most: counts.max().unwrap_or(0),
        }
    }
}

/// A mode of a row or column.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModeName {
    /// Its number in its model, from 1.
    pub mode: usize,
    /// Its natural frequency, Hz.
    pub hz: f64,
}

impl ModeName {
    pub(super) fn all(model: &ModalModel) -> Vec<Self> {
        let modes = (1..).zip(&model.modes);
        modes
            .map(|(mode, source)| Self {
                mode,
                hz: source.frequency_hz,
            })
            .collect()
    }
}

/// Modal assurance criterion of every mode of one set with every mode of another,
/// [`crate::modal::mac`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MacMatrix {
    /// Modes of the rows: of the test.
    pub rows: Vec<ModeName>,
    /// Modes of the columns: of the theory.
    pub columns: Vec<ModeName>,
    /// MAC; `None` where a mode has no shape or is zero there, or fewer than two degrees of freedom
    /// are common.
    pub mac: Vec<Vec<Option<f64>>>,
    /// Degrees of freedom at which both modes of a pair have values.
    pub dofs: DofRange,
}

impl MacMatrix {
    pub(super) fn new(rows: &ModalModel, columns: &ModalModel, shapes: &Shapes) -> Self {
        let pairs =
            (0..rows.modes.len()).flat_map(|i| (0..columns.modes.len()).map(move |j| (i, j)));
        Self {
            rows: ModeName::all(rows),
            columns: ModeName::all(columns),
            mac: shapes.mac_matrix(),
            dofs: match shapes.full_dof_count() {
                Some(count) => DofRange::over(std::iter::once(count)),
                None => DofRange::over(pairs.map(|(i, j)| shapes.common_dof_count(i, j))),
            },
        }
    }
}

//! AutoMAC compares a set of modes with itself: it shows modes that the sensors cannot separate.

use serde::Serialize;

use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::sort_descending_by;
use crate::modal::ModalModel;

use super::super::model_roots::check_model;
use super::super::shapes::Shapes;
use super::super::{CorrelateError, DofMap, PairOptions};
use super::mac_matrix::{MacMatrix, ModeName};

/// Limits of two modes of one set that are duplicates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DuplicateLimits {
    /// Smallest MAC between them.
    pub min_mac: f64,
    /// Largest difference of their frequencies, as a part of the higher one.
    pub max_frequency_difference: f64,
}

impl Default for DuplicateLimits {
    /// A MAC of 0.9 within 5 % in frequency.
    fn default() -> Self {
        Self {
            min_mac: 0.9,
            max_frequency_difference: 0.05,
        }
    }
}

/// Two modes of one set with nearly the same shape at nearly the same frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Duplicate {
    /// The one of smaller number.
    pub first: ModeName,
    /// The other.
    pub second: ModeName,
    /// Their MAC.
    pub mac: f64,
}

/// MAC of a set of modes with itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AutoMac {
    /// Symmetric, with a diagonal of 1 where a mode has a shape.
    pub matrix: MacMatrix,
    /// Limits of a duplicate.
    pub limits: DuplicateLimits,
    /// The duplicates, the largest MAC first.
    pub duplicates: Vec<Duplicate>,
    /// Rotations that the MAC leaves out, because no length scales them to translations.
    pub rotations_left_out: usize,
}

/// MAC of every mode of a set with every other, and the duplicates.
///
/// Modes of one repeated root (same group number) span a space of which any basis is as good; they
/// are not duplicates. Of translations and rotations without
/// [`PairOptions::rotation_length_m`] only the translations are compared.
///
/// # Errors
/// [`CorrelateError::Frequency`], [`CorrelateError::ShapeValue`].
///
/// # Reference
/// Allemang and Brown (1982), A correlation coefficient for modal vector analysis, IMAC 1.
pub fn auto_mac(
    model: &ModalModel,
    limits: DuplicateLimits,
    options: &PairOptions,
) -> Result<AutoMac, CorrelateError> {
    check_model("test", model)?;
    let map = DofMap::of_models(model, model);
    let is_scaled = options.rotation_length_m.is_some();
    let (map, rotations_left_out) = match map.has_both_kinds() && !is_scaled {
        true => map.without_rotations(),
        false => (map, 0),
    };
    let matrix = matrix(model, &map, options)?;
    Ok(AutoMac {
        duplicates: duplicates(model, &matrix, limits),
        rotations_left_out,
        matrix,
        limits,
    })
}

/// MAC of a set with itself on the degrees of freedom of a map onto itself.
fn matrix(
    model: &ModalModel,
    map: &DofMap,
    options: &PairOptions,
) -> Result<MacMatrix, CorrelateError> {
    let shapes = Shapes::new(model, model, map, options)?;
    Ok(MacMatrix::new(model, model, &shapes))
}

/// MAC of a theory with itself at the sensors of a test, which shows modes that these cannot
/// separate.
pub(super) fn theory_auto_mac(
    theory: &ModalModel,
    map: &DofMap,
    options: &PairOptions,
) -> Result<MacMatrix, CorrelateError> {
    let sensors = || map.pairs.iter().map(|pair| &pair.theory);
    matrix(theory, &DofMap::new(sensors(), sensors()), options)
}

fn duplicates(model: &ModalModel, matrix: &MacMatrix, limits: DuplicateLimits) -> Vec<Duplicate> {
    let mut found = Vec::new();
    for (i, first) in matrix.rows.iter().enumerate() {
        for (j, second) in matrix.rows.iter().enumerate().skip(i + 1) {
            let apart = (first.hz - second.hz).abs();
            let near = apart <= limits.max_frequency_difference * first.hz.max(second.hz);
            let group = model.modes[i].group;
            let one_root = group.is_some() && group == model.modes[j].group;
            let mac = matrix.mac[i][j].filter(|mac| *mac >= limits.min_mac);
            if let Some(mac) = mac.filter(|_| near && !one_root) {
                let (first, second) = (*first, *second);
                found.push(Duplicate { first, second, mac });
            }
        }
    }
    sort_descending_by(&mut found, |entry| entry.mac);
    found
}

impl AutoMac {
    /// The rotations that are left out, and each duplicate as a finding at its second mode.
    pub fn findings(&self) -> Vec<Finding> {
        let finding = |duplicate: &Duplicate| {
            let location = Location::Mode(duplicate.second.hz);
            Finding::new(Severity::Warning, Code::DuplicateModes, location)
                .value(duplicate.mac, "")
                .limit(self.limits.min_mac)
        };
        let rotations = self.rotations_left_out;
        let left_out = (rotations > 0).then(|| {
            Finding::new(Severity::Warning, Code::RotationsLeftOut, Location::Whole)
                .value(rotations as f64, "")
        });
        let duplicates = self.duplicates.iter().map(finding);
        left_out.into_iter().chain(duplicates).collect()
    }
}

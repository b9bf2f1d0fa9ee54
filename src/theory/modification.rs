//! A modified model adds masses, springs and dampers to another model.
//!
//! Each part adds `a b b^T` to a matrix, where `b` is the observation row of the degree of freedom
//! on which it acts, or the difference of two rows. One more parameter scales all added parts from
//! 0 (the model as it is) to 1.
//!
//! # Reference
//! Ewins (2000), Modal Testing, 2nd ed., section 6.4 (structural modification); Sestieri (2000),
//! Structural dynamic modification, Sadhana 25, 247.

use crate::geometry::Target;
use crate::linalg::{RealMatrix, SparseMatrix, real_matrix};

use super::parameter::check_values;
use super::{
    Assumption, ParameterSpec, SparseDerivative, SparseSystem, Spring, StiffnessPart, Support,
    SystemDerivative, SystemMatrices, TheoreticalModel, TheoryError,
};

/// Name of the parameter that scales the added parts.
pub const MODIFICATION: &str = "modification";
/// Name of the added springs among the strain energies.
const ADDED_SPRINGS: &str = "added springs";

/// Matrix to which a part is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddedKind {
    /// Mass, kg; kg m² on a rotation.
    Mass,
    /// Stiffness, N/m; N m/rad on a rotation.
    Spring,
    /// Viscous damping, N s/m; N m s/rad on a rotation.
    Damper,
}

/// A part that is added to a model: `a b b^T` for each of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Addition {
    /// Kind of part.
    pub kind: AddedKind,
    /// Motion of the part per unit of each coordinate; one row for each direction.
    pub rows: Vec<Vec<f64>>,
    /// Mass, stiffness or damping constant.
    pub amount: f64,
}

/// A model with added parts. Its last parameter is [`MODIFICATION`].
#[derive(Debug)]
pub struct ModifiedModel {
    base: Box<dyn TheoreticalModel>,
    parameters: Vec<ParameterSpec>,
    additions: Vec<Addition>,
    added_stiffness: SparseMatrix,
}

impl ModifiedModel {
    /// A model with added parts, whose rows have an entry for each coordinate.
    ///
    /// # Errors
    /// [`TheoryError::Linalg`] for a row of another size.
    pub fn new(
        base: Box<dyn TheoreticalModel>,
        additions: Vec<Addition>,
    ) -> Result<Self, TheoryError> {
        let share = ParameterSpec::fraction(MODIFICATION);
        let mut parameters = base.parameters().to_vec();
        parameters.push(share);
        let size = additions.iter().flat_map(|part| &part.rows).map(Vec::len);
        let size = size.max().unwrap_or(0);
        let entries = entries(&additions, AddedKind::Spring, 1.0);
        Ok(Self {
            base,
            parameters,
            added_stiffness: SparseMatrix::from_entries(size, &entries)?,
            additions,
        })
    }

    fn has(&self, kind: AddedKind) -> bool {
        self.additions.iter().any(|part| part.kind == kind)
    }

    /// The values of the base model and the share of the added parts.
    fn split<'v>(&self, values: &'v [f64]) -> Result<(&'v [f64], f64), TheoryError> {
        check_values(self.name(), &self.parameters, values)?;
        let (share, of_base) = values.split_last().unwrap_or((&0.0, values));
        Ok((of_base, *share))
    }

    fn add(&self, to: &mut RealMatrix, kind: AddedKind, share: f64) {
        for (i, j, value) in entries(&self.additions, kind, share) {
            to[(i, j)] += value;
        }
    }

    fn sparse_sum(
        &self,
        base: &SparseMatrix,
        kind: AddedKind,
        share: f64,
    ) -> Result<SparseMatrix, TheoryError> {
        let mut all: Vec<_> = base.entries().collect();
        all.extend(entries(&self.additions, kind, share));
        Ok(SparseMatrix::from_entries(base.size(), &all)?)
    }
}

/// Entries of the matrix that the parts of a kind add.
fn entries(additions: &[Addition], kind: AddedKind, share: f64) -> Vec<(usize, usize, f64)> {
    let mut all = Vec::new();
    for part in additions.iter().filter(|part| part.kind == kind) {
        for row in &part.rows {
            let moved = || row.iter().enumerate().filter(|(_, b)| **b != 0.0);
            for (i, b) in moved() {
                all.extend(moved().map(|(j, c)| (i, j, share * part.amount * (b * c))));
            }
        }
    }
    all
}

fn zeros(size: usize) -> RealMatrix {
    real_matrix(size, size, |_, _| 0.0)
}

impl TheoreticalModel for ModifiedModel {
    fn name(&self) -> &str {
        self.base.name()
    }

    fn parameters(&self) -> &[ParameterSpec] {
        &self.parameters
    }

    fn assemble(&self, values: &[f64]) -> Result<SystemMatrices, TheoryError> {
        let (of_base, share) = self.split(values)?;
        let mut matrices = self.base.assemble(of_base)?;
        self.add(&mut matrices.mass, AddedKind::Mass, share);
        self.add(&mut matrices.stiffness, AddedKind::Spring, share);
        if self.has(AddedKind::Damper) {
            let size = matrices.coordinates.len();
            let damping = matrices.damping.get_or_insert_with(|| zeros(size));
            self.add(damping, AddedKind::Damper, share);
        }
        if !matrices.springs.is_empty() {
            let springs = self.additions.iter();
            let springs = springs.filter(|part| part.kind == AddedKind::Spring);
            let springs = springs.flat_map(|part| {
                part.rows.iter().map(|row| Spring {
                    name: ADDED_SPRINGS.to_owned(),
                    row: row.clone(),
                    stiffness: share * part.amount,
                })
            });
            matrices.springs.extend(springs);
        }
        Ok(matrices)
    }

    fn observation_row(&self, values: &[f64], target: &Target) -> Result<Vec<f64>, TheoryError> {
        self.base.observation_row(self.split(values)?.0, target)
    }

    fn derivative(&self, values: &[f64], j: usize) -> Result<SystemDerivative, TheoryError> {
        let (of_base, _) = self.split(values)?;
        if j < of_base.len() {
            let mut by = self.base.derivative(of_base, j)?;
            if self.has(AddedKind::Damper) && by.damping.is_none() {
                by.damping = Some(zeros(by.mass.nrows()));
            }
            return Ok(by);
        }
        let size = self.added_stiffness.size();
        let mut by = SystemDerivative {
            mass: zeros(size),
            damping: self.has(AddedKind::Damper).then(|| zeros(size)),
            stiffness: zeros(size),
        };
        self.add(&mut by.mass, AddedKind::Mass, 1.0);
        self.add(&mut by.stiffness, AddedKind::Spring, 1.0);
        if let Some(damping) = &mut by.damping {
            self.add(damping, AddedKind::Damper, 1.0);
        }
        Ok(by)
    }

    fn sparse(&self, values: &[f64]) -> Result<Option<SparseSystem>, TheoryError> {
        let (of_base, share) = self.split(values)?;
        let Some(mut system) = self.base.sparse(of_base)? else {
            return Ok(None);
        };
        system.mass = self.sparse_sum(&system.mass, AddedKind::Mass, share)?;
        system.stiffness = self.sparse_sum(&system.stiffness, AddedKind::Spring, share)?;
        if self.has(AddedKind::Damper) {
            let none = SparseMatrix::from_entries(system.coordinates.len(), &[])?;
            let damping = system.damping.unwrap_or(none);
            system.damping = Some(self.sparse_sum(&damping, AddedKind::Damper, share)?);
        }
        Ok(Some(system))
    }

    fn sparse_derivative(
        &self,
        values: &[f64],
        j: usize,
    ) -> Result<Option<SparseDerivative>, TheoryError> {
        let (of_base, _) = self.split(values)?;
        if j < of_base.len() {
            return self.base.sparse_derivative(of_base, j);
        }
        if self.base.sparse(of_base)?.is_none() {
            return Ok(None);
        }
        let none = SparseMatrix::from_entries(self.added_stiffness.size(), &[])?;
        Ok(Some(SparseDerivative {
            mass: self.sparse_sum(&none, AddedKind::Mass, 1.0)?,
            stiffness: self.added_stiffness.clone(),
        }))
    }

    fn stiffness_parts(&self, values: &[f64]) -> Result<Vec<StiffnessPart<'_>>, TheoryError> {
        let (of_base, share) = self.split(values)?;
        let mut parts = self.base.stiffness_parts(of_base)?;
        if !parts.is_empty() && self.has(AddedKind::Spring) {
            parts.push(StiffnessPart {
                name: ADDED_SPRINGS,
                factor: share,
                matrix: &self.added_stiffness,
            });
        }
        Ok(parts)
    }

    fn stated_damping(&self, elastic: usize) -> Option<f64> {
        self.base.stated_damping(elastic)
    }

    fn mode_class(&self, omega_rad_s: f64, shares: &[f64]) -> Option<&'static str> {
        self.base.mode_class(omega_rad_s, shares)
    }

    fn support(&self) -> Option<Support> {
        self.base.support()
    }

    fn assumptions(&self) -> Vec<Assumption> {
        self.base.assumptions()
    }
}

//! Static condensation of motions without mass, which is exact.
//!
//! With `a` the motions that carry mass and `o` those that do not, `M = diag(M_aa, 0)`, the rows
//! `o` of `K phi = omega^2 M phi` are statics: `phi_o = -K_oo^-1 K_oa phi_a`. The modes of `K_c =
//! K_aa - K_ao K_oo^-1 K_oa` with `M_aa` are all finite modes of the whole. Their derivatives need
//! no more: `dK_c = T^T dK T` with `T = [I; -K_oo^-1 K_oa]`, and `(K - lambda M)^-1 = T (K_c -
//! lambda M_aa)^-1 T^T + G` with `G = diag(0, K_oo^-1)` ([`Condensation::relax`]).
//!
//! # Reference
//! Géradin and Rixen (2015), Mechanical Vibrations, 3rd ed., section 2.8; Guyan (1965), AIAA
//! Journal 3, 380.

use crate::finding::{Code, Finding, Location, Severity};
use crate::linalg::{self, RealMatrix, SparseMatrix, SymmetricModes, real_matrix};

use super::massless::{Division, without_zeros};
use super::{Coordinate, MassError, SystemMatrices, TheoryError};

/// Coordinates whose share in a motion is above this fraction of the largest take part in it.
/// Smaller:
/// coordinates at rest are named (rounding leaves 1e-10). Larger: the soft end of a mechanism is
/// not. Test: `unsupported_massless_coordinates_are_reported`.
const TAKES_PART: f64 = 1e-6;

/// The motions of a model that carry no mass, and the stiffness that holds them.
#[derive(Clone, Debug)]
pub struct Condensation {
    pub(super) division: Division,
    /// `K_oo`.
    held: SparseMatrix,
    pub(super) size: usize,
}

impl Condensation {
    /// Of matrices; `None` where every motion carries mass. The stiffness is asked for only where
    /// one does not.
    ///
    /// # Errors
    /// [`TheoryError::Mass`], [`TheoryError::Linalg`].
    pub(super) fn of(
        mass: &SparseMatrix,
        stiffness: impl FnOnce() -> Result<SparseMatrix, TheoryError>,
        coordinates: &[Coordinate],
    ) -> Result<Option<Self>, TheoryError> {
        let division = Division::of(mass, coordinates)?;
        if division.massless.is_empty() {
            return Ok(None);
        }
        let turned = division.turned(&stiffness()?)?;
        let held = linalg::principal_block(&turned, &division.massless)?;
        let condensation = Self {
            division,
            held,
            size: mass.size(),
        };
        condensation.check_held(coordinates)?;
        Ok(Some(condensation))
    }

    /// Of full matrices.
    ///
    /// # Errors
    /// As [`Condensation::of`].
    pub(super) fn of_full(matrices: &SystemMatrices) -> Result<Option<Self>, TheoryError> {
        let stiffness = || without_zeros(&matrices.stiffness);
        let mass = without_zeros(&matrices.mass)?;
        Self::of(&mass, stiffness, &matrices.coordinates)
    }

    /// Number of motions without mass.
    pub fn massless(&self) -> usize {
        self.division.massless.len()
    }

    /// Stiffness must hold every massless motion where those with mass are at rest. A motion of
    /// negative stiffness could be condensed as well, but has no stable equilibrium: a model that
    /// holds it is refused, as it is where the motion has mass.
    fn check_held(&self, coordinates: &[Coordinate]) -> Result<(), TheoryError> {
        if linalg::null_dimension(&self.held)? == 0 {
            return Ok(());
        }
        let negative = linalg::negative_dimension(&self.held)?;
        let vector = linalg::null_vector(&self.held)?;
        let largest = vector.iter().fold(0.0, |m: f64, v| m.max(v * v));
        let moves = |k: &usize| vector[*k] * vector[*k] > TAKES_PART * largest;
        let moving: Vec<usize> = (0..vector.len()).filter(moves).collect();
        let coordinates = self.division.names(&moving, coordinates);
        Err(match negative {
            0 => MassError::Free {
                coordinates,
                motions: linalg::null_dimension(&self.held)?,
            },
            motions => MassError::Unstable {
                coordinates,
                motions,
            },
        }
        .into())
    }

    /// Checks that no damping force acts on a massless motion in any mode, `(C Phi)_o = 0` within
    /// rounding: so it is without damping there, and with damping proportional to stiffness.
    /// Statics then holds with damping as well.
    ///
    /// `forces` is `C Phi`, `magnitudes` the same product of the sizes of all entries.
    ///
    /// # Errors
    /// [`MassError::Damped`].
    pub(super) fn check_undamped(
        &self,
        forces: &RealMatrix,
        magnitudes: &RealMatrix,
        coordinates: &[Coordinate],
    ) -> Result<(), TheoryError> {
        // Rounding of `C = beta K` was up to 5 eps for frames of 466 and 946 coordinates.
        let limit = linalg::null_limit(self.size);
        let at = self.division.at_massless(forces, |weight| weight);
        let sizes = self.division.at_massless(magnitudes, f64::abs);
        let largest = |of: &RealMatrix, row: usize| {
            (0..of.ncols()).fold(0.0, |m: f64, j| m.max(of[(row, j)].abs()))
        };
        let damped = |row: &usize| largest(&at, *row) > limit * largest(&sizes, *row);
        let damped: Vec<usize> = (0..at.nrows()).filter(damped).collect();
        if damped.is_empty() {
            return Ok(());
        }
        Err(MassError::Damped {
            coordinates: self.division.names(&damped, coordinates),
        }
        .into())
    }

    /// How many motions carry no mass and were condensed.
    pub(super) fn finding(&self) -> Finding {
        let finding = Finding::new(Severity::Info, Code::MasslessCondensed, Location::Whole);
        let of = format!("of {} coordinates", self.size);
        finding.value(self.massless() as f64, &of)
    }

    /// `G f` with `G = diag(0, K_oo^-1)`: deflection of massless motions under forces where those
    /// with mass are at rest. Rows are all coordinates.
    ///
    /// # Errors
    /// [`TheoryError::Linalg`].
    pub fn relax(&self, forces: &RealMatrix) -> Result<RealMatrix, TheoryError> {
        let forces = self.division.at_massless(forces, |weight| weight);
        let displacements = linalg::solve_sparse_definite(&self.held, &forces)?;
        let parts = [(self.division.massless.as_slice(), &displacements)];
        Ok(self.division.lifted(&parts, self.size))
    }

    /// `T`: all coordinates (rows) from the motions that carry mass (columns).
    ///
    /// # Errors
    /// [`TheoryError::Linalg`].
    pub fn expansion(&self, stiffness: &RealMatrix) -> Result<RealMatrix, TheoryError> {
        let massive = &self.division.massive;
        let turned = self.division.turned_full(stiffness)?;
        let followed = self.followed(&self.coupling(&turned))?;
        let identity = real_matrix(massive.len(), massive.len(), |i, j| {
            f64::from(u8::from(i == j))
        });
        Ok(self.whole(&identity, &followed))
    }

    /// `K_oa`.
    fn coupling(&self, turned: &RealMatrix) -> RealMatrix {
        let Division {
            massive, massless, ..
        } = &self.division;
        real_matrix(massless.len(), massive.len(), |i, a| {
            turned[(massless[i], massive[a])]
        })
    }

    /// `-K_oo^-1 K_oa`.
    pub(super) fn followed(&self, coupling: &RealMatrix) -> Result<RealMatrix, TheoryError> {
        let solved = linalg::solve_sparse_definite(&self.held, coupling)?;
        Ok(-solved)
    }

    /// All coordinates from the parts with and without mass.
    pub(super) fn whole(&self, massive: &RealMatrix, massless: &RealMatrix) -> RealMatrix {
        let division = &self.division;
        let parts = [
            (division.massive.as_slice(), massive),
            (division.massless.as_slice(), massless),
        ];
        division.lifted(&parts, self.size)
    }

    /// All modes of full matrices, over all coordinates.
    ///
    /// # Errors
    /// [`TheoryError::Linalg`].
    pub(super) fn modes(&self, matrices: &SystemMatrices) -> Result<SymmetricModes, TheoryError> {
        let massive = &self.division.massive;
        let block = |of: &RealMatrix| {
            real_matrix(massive.len(), massive.len(), |i, j| {
                of[(massive[i], massive[j])]
            })
        };
        let turned = self.division.turned_full(&matrices.stiffness)?;
        let coupling = self.coupling(&turned);
        let followed = self.followed(&coupling)?;
        let condensed = block(&turned) + coupling.transpose() * &followed;
        let symmetric = real_matrix(massive.len(), massive.len(), |i, j| {
            0.5 * (condensed[(i, j)] + condensed[(j, i)])
        });
        let mass = block(&self.division.turned_full(&matrices.mass)?);
        let condensed_modes = linalg::symmetric_modes(&symmetric, &mass)?;
        let massless = &followed * &condensed_modes.vectors;
        let vectors = self.whole(&condensed_modes.vectors, &massless);
        let quotients = linalg::rayleigh_quotients(&matrices.stiffness, &matrices.mass, &vectors);
        let (omega_squared, rounding) = quotients.into_iter().unzip();
        Ok(SymmetricModes {
            omega_squared,
            vectors,
            rounding,
        })
    }
}

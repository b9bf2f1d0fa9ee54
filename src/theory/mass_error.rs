//! Errors of models whose mass matrix, or whose motions without mass, leave natural frequencies
//! undefined.

/// A mass matrix, or motions without mass, with which natural frequencies are not defined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MassError {
    /// A mass matrix of zeros.
    #[error(
        "mass matrix: got zeros for all {size} coordinates, expected mass on at least one (without mass no natural frequency is defined)"
    )]
    AllMassless {
        /// Number of coordinates.
        size: usize,
    },
    /// A negative mass, or an entry in the row of a coordinate without mass on the diagonal.
    #[error(
        "mass matrix: got {got} at row `{row}`, column `{column}` with {diagonal} on the diagonal of `{row}`, expected a positive semidefinite matrix (mass on the diagonal of every coordinate that has an entry)"
    )]
    Indefinite {
        /// Coordinate of the row.
        row: String,
        /// Coordinate of the column.
        column: String,
        /// The entry.
        got: f64,
        /// Diagonal entry of the row.
        diagonal: f64,
    },
    /// A mass that vanishes beside the largest.
    #[error(
        "mass matrix: got {got:e} on the diagonal of `{coordinate}`, expected 0 (it then follows by statics) or at least {limit:.1e} (products of smaller masses are no numbers in double precision)"
    )]
    Vanishing {
        /// Coordinate of the mass.
        coordinate: String,
        /// The diagonal entry.
        got: f64,
        /// Smallest entry.
        limit: f64,
    },
    /// A block of the mass matrix with a negative eigenvalue.
    #[error(
        "mass matrix: got the eigenvalue {got:.6e} of the block of {}, scaled to a unit diagonal, expected none below -{limit:.1e}",
        listed(.coordinates)
    )]
    Negative {
        /// The coordinates of the block.
        coordinates: Vec<String>,
        /// Least eigenvalue of `D^-1/2 M D^-1/2`.
        got: f64,
        /// Its rounding bound.
        limit: f64,
    },
    /// Motions without mass in a large block.
    #[error(
        "mass matrix: got {deficient} motions without mass in a block of {} coordinates ({}), expected a positive definite block (such motions are condensed in blocks of at most {most} coordinates)",
        .coordinates.len(), listed(.coordinates)
    )]
    Rank {
        /// The coordinates of the block.
        coordinates: Vec<String>,
        /// Number of eigenvalues that are 0 to working precision, or negative.
        deficient: usize,
        /// Largest block whose null space is looked for.
        most: usize,
    },
    /// Massless motions that no stiffness holds.
    #[error(
        "got {motions} motions without mass and without stiffness, of the coordinates {}, expected stiffness for every motion without mass (hold these coordinates, or give them mass or stiffness)",
        listed(.coordinates)
    )]
    Free {
        /// The coordinates that take part.
        coordinates: Vec<String>,
        /// Number of independent motions.
        motions: usize,
    },
    /// Massless motions with negative stiffness.
    #[error(
        "got {motions} motions without mass and with negative stiffness, of the coordinates {}, expected positive stiffness for every motion without mass while those with mass are at rest (it has no stable equilibrium: check the signs of the springs and stiffness entries there)",
        listed(.coordinates)
    )]
    Unstable {
        /// The coordinates that take part in the softest of them.
        coordinates: Vec<String>,
        /// Number of independent motions.
        motions: usize,
    },
    /// Modes whose mass is hidden by rounding.
    #[error(
        "got {found} modes that carry mass, expected {needed}: natural frequencies of the others are so far above the ratios of stiffness to mass on the diagonals that rounding hides their mass (ask for fewer modes or a narrower band)"
    )]
    Indistinct {
        /// Modes that carry mass.
        found: usize,
        /// Modes that were asked for.
        needed: usize,
    },
    /// Damping forces on massless coordinates.
    #[error(
        "got damping on coordinates without mass ({}), expected none there, or a damping matrix proportional to stiffness (give them mass, or remove their damping: statics does not describe them)",
        listed(.coordinates)
    )]
    Damped {
        /// The coordinates.
        coordinates: Vec<String>,
    },
}

/// Names that a message lists.
const LISTED: usize = 5;

/// The first names, and how many more there are.
fn listed(names: &[String]) -> String {
    let first: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|n| format!("`{n}`"))
        .collect();
    let more = names.len().saturating_sub(LISTED);
    let rest = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    first.join(", ") + &rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_coordinates_are_named_and_the_others_counted() {
        let coordinates = (1..=7).map(|i| format!("{i}:+RX")).collect();
        let error = MassError::Damped { coordinates };
        let text = error.to_string();
        assert!(
            text.contains("`1:+RX`, `2:+RX`, `3:+RX`, `4:+RX`, `5:+RX` and 2 more"),
            "{text}"
        );
        assert!(!text.contains("6:+RX"));
    }
}

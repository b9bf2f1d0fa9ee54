//! An error states why a matrix problem has no answer.

/// Why a matrix problem has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinalgError {
    /// A mass matrix that is not positive definite.
    #[error(
        "mass matrix of {size} coordinates is not positive definite, expected every coordinate to carry mass"
    )]
    MassNotPositiveDefinite {
        /// Its size.
        size: usize,
    },
    /// A matrix that must be positive definite.
    #[error("a matrix of size {size} is not positive definite to working precision")]
    NotPositiveDefinite {
        /// Its size.
        size: usize,
    },
    /// An entry beyond the edge of a matrix.
    #[error("got an entry at row {row}, column {column} (from 0), expected both below {size}")]
    OutsideMatrix {
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// Rows and columns of the matrix.
        size: usize,
    },
    /// More modes than can be computed.
    #[error(
        "got {got} modes that are asked for, expected at most {most}: a narrower band or a smaller count"
    )]
    TooManyModes {
        /// Asked for.
        got: usize,
        /// The most.
        most: usize,
    },
    /// Another number of modes than are counted by inertia.
    #[error(
        "got {found} converged modes, expected {needed} by the count of eigenvalues below the limit"
    )]
    ModesMissing {
        /// Converged.
        found: usize,
        /// Counted.
        needed: usize,
    },
    /// A decomposition that failed its check.
    #[error(
        "{what} of a {rows} x {columns} matrix failed the check: got {got:.1e}, expected at most {limit:.1e}"
    )]
    Inaccurate {
        /// Which decomposition.
        what: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
        /// Figure of the check.
        got: f64,
        /// Its limit.
        limit: f64,
    },
    /// An iteration that did not converge.
    #[error("{what} of a {rows} x {columns} matrix did not converge")]
    NotConverged {
        /// Which decomposition.
        what: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
}

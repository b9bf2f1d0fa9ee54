//! A pencil factors `K - sigma M` of a sparse symmetric pair and counts its negative eigenvalues.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky, supernodal,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Par, Side};

use super::sparse::{SparseMatrix, lower_column};
use super::{LinalgError, RealMatrix, verify};

/// A symmetric pair (K, M) prepared for factorisations of `K - sigma M`: the pattern of both and
/// its ordering.
pub(super) struct Pencil {
    size: usize,
    starts: Vec<usize>,
    rows: Vec<usize>,
    stiffness: Vec<f64>,
    mass: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
}

/// `L L^T` of a positive definite `K - sigma M`.
pub(super) struct Cholesky<'a> {
    pencil: &'a Pencil,
    pub values: Vec<f64>,
}

impl Pencil {
    /// The pair, of which the lower triangle counts.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`] when there is no memory for the ordering.
    pub fn new(stiffness: &SparseMatrix, mass: &SparseMatrix) -> Result<Self, LinalgError> {
        let size = stiffness.size();
        let (mut starts, mut rows) = (vec![0], Vec::new());
        let (mut k, mut m) = (Vec::new(), Vec::new());
        for column in 0..size {
            let mut in_stiffness = lower_column(stiffness, column).peekable();
            let mut in_mass = lower_column(mass, column).peekable();
            loop {
                let row = match (in_stiffness.peek(), in_mass.peek()) {
                    (Some((a, _)), Some((b, _))) => *a.min(b),
                    (Some((a, _)), None) => *a,
                    (None, Some((b, _))) => *b,
                    (None, None) => break,
                };
                let value = |next: Option<(usize, f64)>| next.map_or(0.0, |(_, value)| value);
                rows.push(row);
                k.push(value(in_stiffness.next_if(|(a, _)| *a == row)));
                m.push(value(in_mass.next_if(|(b, _)| *b == row)));
            }
            starts.push(rows.len());
        }
        let symbolic = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(size, size, &starts, None, &rows),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams {
                // One kind of factor, the one that can be pivoted inside its blocks.
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..CholeskySymbolicParams::default()
            },
        );
        Ok(Self {
            symbolic: symbolic.map_err(|_| LinalgError::NotConverged {
                what: "ordering",
                rows: size,
                columns: size,
            })?,
            size,
            starts,
            rows,
            stiffness: k,
            mass: m,
        })
    }

    fn combined(&self, factor: f64, shift: f64) -> Vec<f64> {
        let pairs = self.stiffness.iter().zip(&self.mass);
        pairs.map(|(k, m)| factor * k - shift * m).collect()
    }

    /// `|factor| |k_ii| + |shift| |m_ii|`.
    fn diagonal_terms(&self, factor: f64, shift: f64) -> Vec<f64> {
        let term = |column: usize| {
            let place = self.starts[column];
            let is_diagonal = self.rows[place..self.starts[column + 1]].first() == Some(&column);
            let terms = [factor * self.stiffness[place], shift * self.mass[place]];
            if is_diagonal {
                terms[0].abs() + terms[1].abs()
            } else {
                0.0
            }
        };
        (0..self.size)
            .map(|column| {
                if self.starts[column] < self.starts[column + 1] {
                    term(column)
                } else {
                    0.0
                }
            })
            .collect()
    }

    fn matrix<'a>(&'a self, values: &'a [f64]) -> SparseColMatRef<'a, usize, f64> {
        let (starts, rows) = (&self.starts, &self.rows);
        let pattern =
            SymbolicSparseColMatRef::new_checked(self.size, self.size, starts, None, rows);
        SparseColMatRef::new(pattern, values)
    }

    /// Cholesky factor of `factor K - shift M`.
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveDefinite`].
    pub fn cholesky(&self, factor: f64, shift: f64) -> Result<Cholesky<'_>, LinalgError> {
        let combined = self.combined(factor, shift);
        let diagonal = self.diagonal_terms(factor, shift);
        let mut values = vec![0.0; self.symbolic.len_val()];
        let scratch = self
            .symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let factored = self.symbolic.factorize_numeric_llt(
            &mut values,
            self.matrix(&combined),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        let failed = factored.is_err();
        if failed || values.iter().any(|value| !value.is_finite()) {
            return Err(LinalgError::NotPositiveDefinite { size: self.size });
        }
        let factor = Cholesky {
            pencil: self,
            values,
        };
        let matrix = self.symmetric(&combined);
        verify::sparse_factor(verify::MAX_CHOLESKY_ERROR, &matrix, &diagonal, |x| {
            factor.solve(x)
        })?;
        Ok(factor)
    }

    /// The whole matrix of values of the lower triangle.
    fn symmetric(&self, values: &[f64]) -> SparseMatrix {
        let mut entries = Vec::with_capacity(2 * values.len());
        for column in 0..self.size {
            let places = self.starts[column]..self.starts[column + 1];
            for (&row, &value) in self.rows[places.clone()].iter().zip(&values[places]) {
                entries.push((row, column, value));
                if row > column {
                    entries.push((column, row, value));
                }
            }
        }
        SparseMatrix::from_entries(self.size, &entries).expect("places of the pencil")
    }

    /// Number of eigenvalues of the pair below `shift`, M positive definite: as many as `K - shift
    /// M` has negative ones.
    ///
    /// A factor that fails its check is computed again beside the shift, by a billionth of it; the
    /// error is that of the first.
    ///
    /// # Errors
    /// [`LinalgError::NotConverged`] when the factor is not finite: `shift` is an eigenvalue to
    /// working precision; [`LinalgError::Inaccurate`].
    ///
    /// # Reference
    /// Parlett (1998), The Symmetric Eigenvalue Problem, theorem 3.3.1 (Sylvester's law of
    /// inertia).
    pub fn count_below(&self, shift: f64) -> Result<usize, LinalgError> {
        let beside = |error| self.indefinite(shift * (1.0 + 1e-9)).map_err(|_| error);
        let factor = self.indefinite(shift).or_else(beside)?;
        Ok(factor.negative_eigenvalues())
    }

    /// Factor of `K - shift M`, checked.
    ///
    /// # Errors
    /// As [`Pencil::count_below`].
    pub fn indefinite(&self, shift: f64) -> Result<Indefinite<'_>, LinalgError> {
        let combined = self.combined(1.0, shift);
        let mut factor = Indefinite {
            pencil: self,
            values: vec![0.0; self.symbolic.len_val()],
            subdiagonal: vec![0.0; self.size],
            forward: vec![0; self.size],
            inverse: vec![0; self.size],
        };
        let scratch = self
            .symbolic
            .factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Default::default());
        self.symbolic.factorize_numeric_intranode_lblt(
            &mut factor.values,
            &mut factor.subdiagonal,
            &mut factor.forward,
            &mut factor.inverse,
            self.matrix(&combined),
            Side::Lower,
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Default::default(),
        );
        let diagonal = factor.diagonal();
        let mut pivots = diagonal.iter().chain(&factor.subdiagonal);
        if pivots.any(|pivot| !pivot.is_finite()) {
            return Err(LinalgError::NotConverged {
                what: "count of eigenvalues",
                rows: self.size,
                columns: self.size,
            });
        }
        let diagonal = self.diagonal_terms(1.0, shift);
        let matrix = self.symmetric(&combined);
        verify::sparse_factor(verify::MAX_INERTIA_ERROR, &matrix, &diagonal, |x| {
            factor.solve(x)
        })?;
        Ok(factor)
    }
}

/// `P (K - shift M) P^T = L B L^T` with blocks B of one or two rows, pivoted inside the supernodes.
pub(super) struct Indefinite<'a> {
    pencil: &'a Pencil,
    /// L, with the diagonal of B.
    pub values: Vec<f64>,
    subdiagonal: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
}

impl Indefinite<'_> {
    /// Places of the diagonal of B in the values, in the order of the factor.
    pub fn pivots(&self) -> Vec<usize> {
        match self.pencil.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => block_diagonal(symbolic),
            // A diagonal matrix: nothing to put into blocks.
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                symbolic.col_ptr()[..self.pencil.size].to_vec()
            }
        }
    }

    fn diagonal(&self) -> Vec<f64> {
        let places = self.pivots();
        places.iter().map(|&place| self.values[place]).collect()
    }

    /// Replaces `x` by the solution of `(K - shift M) y = x`.
    pub fn solve(&self, x: &mut RealMatrix) {
        let Self {
            pencil,
            values,
            subdiagonal,
            ..
        } = self;
        let rows = PermRef::new_checked(&self.forward, &self.inverse, pencil.size);
        let factor = IntranodeLbltRef::new(&pencil.symbolic, values, subdiagonal, rows);
        let scratch = pencil
            .symbolic
            .solve_in_place_scratch::<f64>(x.ncols(), Par::Seq);
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        factor.solve_in_place_with_conj(Conj::No, x.as_mut(), Par::Seq, stack);
    }

    fn negative_eigenvalues(&self) -> usize {
        negative_eigenvalues(&self.diagonal(), &self.subdiagonal)
    }
}

/// Places of the diagonal of the blocks of a factor, in its order.
fn block_diagonal(symbolic: &supernodal::SymbolicSupernodalCholesky<usize>) -> Vec<usize> {
    let mut places = Vec::with_capacity(symbolic.nrows());
    for s in 0..symbolic.n_supernodes() {
        let columns = symbolic.supernode_end()[s] - symbolic.supernode_begin()[s];
        let ends = &symbolic.col_ptr_for_val()[s..s + 2];
        let rows = (ends[1] - ends[0]) / columns.max(1);
        places.extend((0..columns).map(|j| ends[0] + j * rows + j));
    }
    places
}

/// Negative eigenvalues of a matrix of blocks of one row, or of two where the first has an entry
/// below its diagonal.
fn negative_eigenvalues(diagonal: &[f64], subdiagonal: &[f64]) -> usize {
    let (mut at, mut count) = (0, 0);
    while at < diagonal.len() {
        if subdiagonal[at].abs() > 0.0 && at + 1 < diagonal.len() {
            let (a, b, d) = (diagonal[at], subdiagonal[at], diagonal[at + 1]);
            count += match a * d - b * b {
                determinant if determinant < 0.0 => 1,
                _ if a + d < 0.0 => 2,
                _ => 0,
            };
            at += 2;
        } else {
            count += usize::from(diagonal[at] < 0.0);
            at += 1;
        }
    }
    count
}

impl Cholesky<'_> {
    /// Replaces `x` by the solution of `(K - shift M) y = x`.
    pub fn solve(&self, x: &mut RealMatrix) {
        let symbolic = &self.pencil.symbolic;
        let scratch = symbolic.solve_in_place_scratch::<f64>(x.ncols(), Par::Seq);
        LltRef::new(symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            x.as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
        );
    }
}

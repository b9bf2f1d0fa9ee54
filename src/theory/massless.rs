//! Division of the motions of a model into those that carry mass and those that do not.
//!
//! A coordinate is massless whose row and column of the mass matrix are exactly 0. A mass matrix of
//! lower rank whose null space is no set of coordinates (a mass off its node without rotary
//! inertia, a mass between the nodes of a massless beam) is transformed, block by block, to the
//! axes of its null space: `x = Q y`.

use crate::linalg::{self, LinalgError, RealMatrix, SparseMatrix, real_matrix};

use super::{Coordinate, MassError, TheoryError};

/// Largest block of coordinates coupled by mass whose null space is computed: a full eigenproblem
/// of less than a second.
const MAX_BLOCK_COORDINATES: usize = 500;
/// Maximum mass of a motion that counts as massless, over that of its coordinate; it is neglected.
/// Larger: a small mass beside a large one is neglected. Smaller: rounding, 1e-16
/// of the diagonal times the growth of the elimination.
const MAX_RESIDUAL_MASS_RATIO: f64 = 1e-8;
/// Smallest mass over the largest: the root of the smallest normal number, so that the product of
/// two masses is one. Smaller: natural frequencies overflow (test
/// `a_mass_matrix_that_is_not_semidefinite_is_named`). Larger: time without use, as no machine has
/// such masses.
const MIN_MASS_RATIO: f64 = 1.5e-154;

/// The motions `y` of a model that carry mass and those that do not; `Q` is the identity outside
/// the blocks.
#[derive(Clone, Debug)]
pub(super) struct Division {
    blocks: Vec<Block>,
    pub massive: Vec<usize>,
    pub massless: Vec<usize>,
}

/// Coordinates coupled by mass, `x_at = vectors y_at`.
#[derive(Clone, Debug)]
struct Block {
    at: Vec<usize>,
    vectors: RealMatrix,
}

impl Division {
    /// Division by the rows and columns of a mass matrix that are exactly 0, and by the null spaces
    /// of its blocks.
    ///
    /// # Errors
    /// [`TheoryError::Mass`], [`TheoryError::Linalg`].
    pub fn of(mass: &SparseMatrix, coordinates: &[Coordinate]) -> Result<Self, TheoryError> {
        let mut carries = vec![false; mass.size()];
        let mut coupled = false;
        for (i, j, got) in mass.entries().filter(|(_, _, v)| v.abs() > 0.0) {
            let diagonal = mass.get(i, i);
            if diagonal <= 0.0 {
                let [row, column] = [i, j].map(|index| coordinates[index].name.clone());
                return Err(MassError::Indefinite {
                    row,
                    column,
                    got,
                    diagonal,
                }
                .into());
            }
            carries[i] = true;
            coupled |= i != j;
        }
        let largest = (0..mass.size()).map(|i| mass.get(i, i));
        let limit = (MIN_MASS_RATIO * largest.fold(0.0, f64::max)).max(f64::MIN_POSITIVE);
        let vanishes = |&i: &usize| carries[i] && mass.get(i, i) < limit;
        if let Some(i) = (0..mass.size()).find(vanishes) {
            return Err(MassError::Vanishing {
                coordinate: coordinates[i].name.clone(),
                got: mass.get(i, i),
                limit,
            }
            .into());
        }
        let (massive, massless) = (0..mass.size()).partition(|&i| carries[i]);
        let mut division = Self {
            blocks: Vec::new(),
            massive,
            massless,
        };
        if division.massive.is_empty() {
            let size = mass.size();
            return Err(MassError::AllMassless { size }.into());
        }
        let loaded = linalg::principal_block(mass, &division.massive)?;
        if coupled && linalg::null_dimension(&loaded)? > 0 {
            division.turn_blocks(mass, coordinates)?;
        }
        Ok(division)
    }

    /// Turns the blocks of lower rank into the axes of their null spaces.
    fn turn_blocks(
        &mut self,
        mass: &SparseMatrix,
        coordinates: &[Coordinate],
    ) -> Result<(), TheoryError> {
        for at in coupled_blocks(mass, &self.massive) {
            let block = linalg::principal_block(mass, &at)?;
            let deficient = linalg::null_dimension(&block)?;
            let names = || at.iter().map(|&i| coordinates[i].name.clone()).collect();
            if deficient > 0 && at.len() > MAX_BLOCK_COORDINATES {
                return Err(MassError::Rank {
                    coordinates: names(),
                    deficient,
                    most: MAX_BLOCK_COORDINATES,
                }
                .into());
            }
            if deficient > 0 {
                self.turn_block(&block, &at, &names)?;
            }
        }
        self.massless.sort_unstable();
        Ok(())
    }

    /// The rank is that of `D^-1/2 M D^-1/2` with `D` the diagonal. Of as many pivots p, the
    /// largest that are left on the diagonal, `M_rr = M_rp M_pp^-1 M_pr`: a massless motion moves
    /// one other coordinate r, and p with it by `-M_pp^-1 M_pr`. Null vectors of the scaled matrix
    /// would be `D^-1/2` times a basis without order, which for a mass within rounding of its node
    /// is 1e16 of one coordinate in each of them.
    fn turn_block(
        &mut self,
        block: &SparseMatrix,
        at: &[usize],
        names: &dyn Fn() -> Vec<String>,
    ) -> Result<(), TheoryError> {
        let k = at.len();
        let roots: Vec<f64> = (0..k).map(|i| block.get(i, i).sqrt()).collect();
        let scaled = real_matrix(k, k, |i, j| block.get(i, j) / (roots[i] * roots[j]));
        let values = linalg::symmetric_eigen(&scaled)?.values;
        let limit = linalg::null_limit(k);
        let got = values[0];
        if got < -limit {
            return Err(MassError::Negative {
                coordinates: names(),
                got,
                limit,
            }
            .into());
        }
        let null = values.partition_point(|value| *value <= limit);
        let (pivots, others) = pivots(block, k - null)?;
        let rank = pivots.len();
        let loaded = real_matrix(rank, rank, |i, j| block.get(pivots[i], pivots[j]));
        let coupling = real_matrix(rank, k - rank, |i, j| block.get(pivots[i], others[j]));
        let followed = linalg::solve_definite(&loaded, &coupling)?;
        let mut vectors = real_matrix(k, k, |i, j| f64::from(u8::from(i == j)));
        for (i, &pivot) in pivots.iter().enumerate() {
            for (j, &other) in others.iter().enumerate() {
                vectors[(pivot, other)] = -followed[(i, j)];
            }
        }
        let massless: Vec<usize> = others.iter().map(|&other| at[other]).collect();
        self.massive.retain(|i| !massless.contains(i));
        self.massless.extend(massless);
        self.blocks.push(Block {
            at: at.to_vec(),
            vectors,
        });
        Ok(())
    }

    /// `Q^T A Q` of a full matrix.
    pub fn turned_full(&self, a: &RealMatrix) -> Result<RealMatrix, TheoryError> {
        if self.blocks.is_empty() {
            return Ok(a.clone());
        }
        Ok(self.turned(&without_zeros(a)?)?.to_dense())
    }

    /// `Q^T A Q`.
    pub fn turned(&self, a: &SparseMatrix) -> Result<SparseMatrix, TheoryError> {
        if self.blocks.is_empty() {
            return Ok(a.clone());
        }
        let mut rows: Vec<Vec<(usize, f64)>> = (0..a.size()).map(|i| vec![(i, 1.0)]).collect();
        for block in &self.blocks {
            for (k, &i) in block.at.iter().enumerate() {
                let all = block.at.iter().enumerate();
                rows[i] = all.map(|(c, &y)| (y, block.vectors[(k, c)])).collect();
            }
        }
        let rows = &rows;
        let entries = a.entries().flat_map(|(i, j, value)| {
            let of_row = move |&(p, w): &(usize, f64)| {
                let right = rows[j].iter();
                right.map(move |&(q, u)| (p, q, value * (w * u)))
            };
            rows[i].iter().flat_map(of_row)
        });
        let entries: Vec<_> = entries.collect();
        Ok(SparseMatrix::from_entries(a.size(), &entries)?)
    }

    /// `Q y`, from rows of the motions named to rows of all coordinates; the other motions are at
    /// rest.
    pub fn lifted(&self, parts: &[(&[usize], &RealMatrix)], size: usize) -> RealMatrix {
        let columns = parts.first().map_or(0, |(_, motions)| motions.ncols());
        let mut y = real_matrix(size, columns, |_, _| 0.0);
        for (at, motions) in parts {
            place_rows(&mut y, at, motions);
        }
        for block in &self.blocks {
            let displacements = rows_of(&y, &block.at);
            place_rows(&mut y, &block.at, &(&block.vectors * displacements));
        }
        y
    }

    /// `Q^T f` at the massless motions; of magnitudes with the magnitudes of `Q`.
    pub fn at_massless(&self, forces: &RealMatrix, weight: fn(f64) -> f64) -> RealMatrix {
        let mut turned = rows_of(forces, &self.massless);
        for block in &self.blocks {
            let k = block.at.len();
            let transform = real_matrix(k, k, |i, j| weight(block.vectors[(j, i)]));
            let forces_at_motions = transform * rows_of(forces, &block.at);
            for (row, at) in block.at.iter().enumerate() {
                if let Ok(place) = self.massless.binary_search(at) {
                    (0..forces_at_motions.ncols())
                        .for_each(|j| turned[(place, j)] = forces_at_motions[(row, j)]);
                }
            }
        }
        turned
    }

    /// The coordinates that move most in massless motions, by their places among these, each once.
    pub fn names(&self, motions: &[usize], coordinates: &[Coordinate]) -> Vec<String> {
        let leading = |&place: &usize| {
            let motion = self.massless[place];
            let block = self.blocks.iter().find(|block| block.at.contains(&motion));
            let most = block.and_then(|block| {
                let column = block.at.iter().position(|&i| i == motion)?;
                let size = |k: usize| block.vectors[(k, column)].abs();
                let all = 0..block.at.len();
                all.max_by(|&a, &b| size(a).total_cmp(&size(b)))
                    .map(|k| block.at[k])
            });
            most.unwrap_or(motion)
        };
        let mut leading: Vec<usize> = motions.iter().map(leading).collect();
        leading.sort_unstable();
        leading.dedup();
        let names = leading.iter().map(|&i| coordinates[i].name.clone());
        names.collect()
    }
}

/// As many pivots of a semidefinite matrix as its rank, each the largest that is left on the
/// diagonal where more than rounding of its entry is left, and the other rows.
///
/// # Errors
/// [`LinalgError::Inaccurate`] where the residual of the other rows exceeds
/// [`MAX_RESIDUAL_MASS_RATIO`].
fn pivots(a: &SparseMatrix, rank: usize) -> Result<(Vec<usize>, Vec<usize>), TheoryError> {
    let k = a.size();
    let mut left = a.to_dense();
    let (mut pivots, mut others) = (Vec::with_capacity(rank), (0..k).collect::<Vec<_>>());
    let rounding = linalg::null_limit(k);
    for _ in 0..rank {
        let size = |of: usize| left[(of, of)];
        let candidates = others.iter().copied().enumerate();
        let candidates = candidates.filter(|&(_, of)| size(of) > rounding * a.get(of, of));
        let Some((place, pivot)) = candidates.max_by(|x, y| size(x.1).total_cmp(&size(y.1))) else {
            break;
        };
        others.remove(place);
        let column: Vec<f64> = (0..k).map(|i| left[(i, pivot)]).collect();
        for (i, j) in (0..k).flat_map(|j| (0..k).map(move |i| (i, j))) {
            left[(i, j)] -= column[i] * (column[j] / column[pivot]);
        }
        pivots.push(pivot);
    }
    let kept = |&of: &usize| left[(of, of)].abs() / a.get(of, of);
    let got = others.iter().map(kept).fold(0.0, f64::max);
    if got > MAX_RESIDUAL_MASS_RATIO {
        return Err(LinalgError::Inaccurate {
            what: "elimination of the motions with mass",
            rows: k,
            columns: k,
            got,
            limit: MAX_RESIDUAL_MASS_RATIO,
        }
        .into());
    }
    Ok((pivots, others))
}

/// Coordinates that entries of a matrix couple, directly or through others; ascending.
fn coupled_blocks(mass: &SparseMatrix, massive: &[usize]) -> Vec<Vec<usize>> {
    let mut leader: Vec<usize> = (0..mass.size()).collect();
    fn root(leader: &mut [usize], mut i: usize) -> usize {
        while leader[i] != i {
            leader[i] = leader[leader[i]];
            i = leader[i];
        }
        i
    }
    for (i, j, _) in mass.entries().filter(|(_, _, v)| v.abs() > 0.0) {
        let (a, b) = (root(&mut leader, i), root(&mut leader, j));
        leader[a.max(b)] = a.min(b);
    }
    let mut blocks: std::collections::BTreeMap<usize, Vec<usize>> = Default::default();
    for &i in massive {
        let leader_of_block = root(&mut leader, i);
        blocks.entry(leader_of_block).or_default().push(i);
    }
    blocks.into_values().collect()
}

/// Rows of a matrix.
pub(super) fn rows_of(a: &RealMatrix, rows: &[usize]) -> RealMatrix {
    real_matrix(rows.len(), a.ncols(), |i, j| a[(rows[i], j)])
}

fn place_rows(a: &mut RealMatrix, rows: &[usize], source: &RealMatrix) {
    for (i, &row) in rows.iter().enumerate() {
        (0..source.ncols()).for_each(|j| a[(row, j)] = source[(i, j)]);
    }
}

/// A matrix without its zeros.
pub(super) fn without_zeros(a: &RealMatrix) -> Result<SparseMatrix, TheoryError> {
    let mut entries = Vec::new();
    for j in 0..a.ncols() {
        let column = (0..a.nrows()).map(|i| (i, j, a[(i, j)]));
        entries.extend(column.filter(|(_, _, value)| value.abs() > 0.0));
    }
    Ok(SparseMatrix::from_entries(a.nrows(), &entries)?)
}

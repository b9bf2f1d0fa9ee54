//! What roots and background make of all lines of a band, and what they leave over.

use std::ops::Range;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::Root;
use crate::identify::data::out_of_band_basis::{Background, Course, EVERYWHERE, Outside};
use crate::identify::noise::band_profile::Profile;

/// What lies outside the lines, told from all of them together: the background of the whole band.
///
/// A window in the middle has constant and slope alone for what is outside; a strong mode beyond
/// the end of a long band is curved there, and the whole band knows by how much.
pub(in crate::identify) struct Far {
    omega: Vec<f64>,
    line_shape: LineShape,
    level: Vec<f64>,
    /// Columns of the background times their coordinates, and what gives the coordinates: lines ×
    /// columns.
    columns: ComplexMatrix,
    weights: ComplexMatrix,
    /// Of the measured values: columns × functions.
    coordinates: ComplexMatrix,
}

/// What is left over on some lines, over the noise.
pub(in crate::identify) struct Rest {
    /// The lines.
    pub lines: Range<usize>,
    /// Lines × functions.
    pub values: ComplexMatrix,
}

impl Rest {
    /// Lines × functions, from the first line on.
    #[cfg(test)]
    pub fn of_all(values: ComplexMatrix) -> Self {
        Self {
            lines: 0..values.nrows(),
            values,
        }
    }

    /// Of a function at a line.
    pub fn at(&self, function: usize, line: usize) -> Complex64 {
        self.values[(line - self.lines.start, function)]
    }

    /// Of a function on some of the lines.
    pub fn of(&self, function: usize, lines: Range<usize>) -> &[Complex64] {
        let start = lines.start - self.lines.start;
        &self.values.col_as_slice(function)[start..start + lines.len()]
    }

    /// Brings values over the noise of some variances, by function and line, over that of others.
    pub fn over(&mut self, before: &[Vec<f64>], now: &[Vec<f64>]) {
        let lines = self.lines.clone();
        linalg::by_column(&mut self.values, |f, column| {
            let variances = before[f][lines.clone()].iter().zip(&now[f][lines.clone()]);
            for (value, (before, now)) in column.iter_mut().zip(variances) {
                *value *= (before / now).sqrt();
            }
        });
    }

    /// `Σ|rest|²`.
    pub fn energy(&self) -> f64 {
        self.values.squared_norm_l2()
    }

    /// The same of a value.
    pub fn mean_power(&self) -> f64 {
        self.energy() / (self.values.nrows() * self.values.ncols()) as f64
    }
}

impl Far {
    /// Of the lines of a band.
    pub fn new(data: &Receptances, outside: &Outside) -> Self {
        let lines = 0..data.lines();
        let Profile { level, course } = Profile::new(data, lines.clone());
        let background = Background::new(&data.omega, &lines, outside);
        // Orthonormal over the course of the noise.
        let basis = background.basis(&data.omega, &course);
        let of = |scale: &dyn Fn(usize) -> f64| {
            linalg::complex_matrix(basis.nrows(), basis.ncols(), |k, c| {
                basis[(k, c)] * scale(k)
            })
        };
        let weights = of(&|k| course[k].recip());
        Self {
            omega: data.omega.clone(),
            line_shape: data.line_shape,
            coordinates: linalg::adjoint_product(&weights, data.values.matrix().as_ref()),
            columns: of(&|k| course[k]),
            weights,
            level,
        }
    }

    /// The columns of the background: lines × columns.
    pub fn columns(&self) -> &ComplexMatrix {
        &self.columns
    }

    /// Coordinates of what the roots leave over: columns × functions.
    pub fn of_rest(&self, roots: &[Root]) -> ComplexMatrix {
        let courses = self.weights.adjoint() * courses(self.line_shape, &self.omega, roots);
        &self.coordinates - courses * residues(roots, self.level.len())
    }

    /// What roots and background make of the lines.
    pub fn beside<'a>(&'a self, data: &'a Receptances, roots: &'a [Root]) -> Described<'a> {
        let (of_rest, residues) = (self.of_rest(roots), residues(roots, self.level.len()));
        let first = self.columns.ncols();
        let rows = first + residues.nrows();
        let amplitudes = linalg::complex_matrix(rows, self.level.len(), |c, f| {
            if c < first {
                of_rest[(c, f)]
            } else {
                residues[(c - first, f)]
            }
        });
        Described {
            far: self,
            data,
            roots,
            amplitudes,
        }
    }

    /// Coordinates of what the roots leave over, over the noise, without constant and slope:
    /// columns × functions.
    fn beyond(&self, roots: &[Root]) -> ComplexMatrix {
        let rest = self.of_rest(roots);
        let columns = rest.nrows() - EVERYWHERE;
        linalg::complex_matrix(columns, rest.ncols(), |c, f| {
            rest[(EVERYWHERE + c, f)] / self.level[f]
        })
    }

    /// Courses over the lines of what the roots leave over beyond constant and slope, the strongest
    /// first: as many as leave no more of the rest than noise, of which `alike` lines count for
    /// one, and so many at most.
    ///
    /// The coordinates over the noise, a matrix of columns × functions, are noise of unit variance
    /// plus one dyad per course; what r dyads leave has (columns − r)(functions − r) numbers
    /// (reduced rank: Anderson 1951, Annals of Mathematical Statistics 22).
    pub fn strongest(&self, roots: &[Root], alike: f64, most: usize) -> Vec<Course> {
        let beyond = self.beyond(roots);
        let Ok(svd) = linalg::singular_vectors(&beyond) else {
            return Vec::new();
        };
        let left = |rank: usize| svd.values[rank..].iter().map(|s| s * s).sum::<f64>();
        let noise = |rank: usize| {
            let numbers = ((beyond.nrows() - rank) * (beyond.ncols() - rank)) as f64;
            alike * (numbers + numbers.sqrt())
        };
        let all = svd.values.len();
        let needed = (0..all).find(|rank| left(*rank) <= noise(*rank));
        let count = needed.unwrap_or(all).min(most);
        let course = |rank: usize| {
            let at = |k: usize| -> Complex64 {
                let terms = (0..beyond.nrows())
                    .map(|c| self.columns[(k, EVERYWHERE + c)] * svd.left[(c, rank)]);
                terms.sum()
            };
            let shares = (0..beyond.ncols()).map(|f| svd.right[(f, rank)].conj());
            Course {
                values: (0..self.columns.nrows()).map(at).collect(),
                shares: shares.collect(),
            }
        };
        (0..count).map(course).collect()
    }

    /// Energy beyond constant and slope that the background explains of what the roots leave over,
    /// over the noise, with the complex numbers that it has.
    pub fn explained(&self, roots: &[Root]) -> (f64, usize) {
        let beyond = self.beyond(roots);
        (beyond.squared_norm_l2(), beyond.nrows() * beyond.ncols())
    }
}

/// What roots and background make of the lines.
pub(in crate::identify) struct Described<'a> {
    far: &'a Far,
    data: &'a Receptances,
    roots: &'a [Root],
    /// Of background, roots and conjugates: columns × functions.
    amplitudes: ComplexMatrix,
}

impl Described<'_> {
    /// What they leave over on some lines, over the noise at each.
    pub fn left_over(&self, lines: Range<usize>) -> Rest {
        let first = self.far.columns.ncols();
        let roots = courses(
            self.far.line_shape,
            &self.far.omega[lines.clone()],
            self.roots,
        );
        let courses = linalg::complex_matrix(lines.len(), self.amplitudes.nrows(), |k, c| {
            if c < first {
                self.far.columns[(lines.start + k, c)]
            } else {
                roots[(k, c - first)]
            }
        });
        let over_noise = |f: usize, column: &mut [Complex64]| {
            let variance = &self.data.variance[f][lines.clone()];
            for (value, variance) in column.iter_mut().zip(variance) {
                *value /= variance.sqrt();
            }
        };
        let measured = self.data.values.matrix();
        let measured = measured.subrows(lines.start, lines.len());
        let values = linalg::less_product(measured, (&courses, &self.amplitudes), over_noise);
        Rest { lines, values }
    }
}

/// `1/(iω − λ)` of every root and of its conjugate: lines × twice the roots.
pub(in crate::identify) fn courses(
    line_shape: LineShape,
    omega: &[f64],
    roots: &[Root],
) -> ComplexMatrix {
    linalg::complex_matrix(omega.len(), 2 * roots.len(), |k, place| {
        let lambda = roots[place / 2].lambda;
        let lambda = if place % 2 == 0 {
            lambda
        } else {
            lambda.conj()
        };
        line_shape.pole(omega[k], lambda)
    })
}

/// Residues of every root and of its conjugate: twice the roots × functions.
pub(in crate::identify) fn residues(roots: &[Root], functions: usize) -> ComplexMatrix {
    linalg::complex_matrix(2 * roots.len(), functions, |place, f| {
        let residue = roots[place / 2].residues[f];
        if place % 2 == 0 {
            residue
        } else {
            residue.conj()
        }
    })
}

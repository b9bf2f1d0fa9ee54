//! A window of lines, compressed: the values of all functions in the coordinates of what a fit in
//! the window can need.
//!
//! The columns of a fit are background, `g_j = σ_j/(iω − λ_j)` and, where poles move, `g_j²`. About
//! poles `λ_j0` with the courses `x = |σ_j0|/(iω − λ_j0)` and `ε = (λ_j − λ_j0)/|σ_j0|`
//!
//! ```text
//! g = |σ/σ_0| (x + ε x² + ε² x³ + …)      g² = |σ/σ_0|² (x² + 2ε x³ + …)
//! ```
//!
//! (of a smoothed pole, xⁿ is its derivative of order n − 1 by λ, times `|σ_0|ⁿ/(n − 1)!`) so that
//! the coordinates of the values in an orthonormal basis of background, x, x² and x³ serve all
//! poles near λ_0: a step of a fit touches no line, and the values are read once for as long as
//! poles stay near and the noise is the same. What other roots put into the window has coordinates
//! as well, which are taken from those of the values.

use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::linalg::{self, ComplexMatrix, ThinQr};

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::Root;
use crate::identify::data::out_of_band_basis::Background;
use crate::identify::fit::gauss_newton::Surroundings;
use crate::identify::fit::variable_projection::Compressed;
use crate::identify::noise::band_profile::Profile;

/// Powers of each course.
const POWERS: usize = 3;
/// How far poles may be from where the window was made for them, in decay rates, at least and at
/// most: the third power of this is left away of a course, and of the least that is rounding.
const NEAR: [f64; 2] = [3e-5, 1e-2];
/// What is left away at that distance of the strongest response in the window, over the noise of
/// one value.
const LEFT_AWAY: f64 = 1e-3;
/// Functions, most, of which the whole energy is looked at.
const SAMPLED: usize = 48;
/// Coordinates, most, over those that a window made anew would have.
const GROWN: f64 = 1.5;
/// Windows whose ends differ by less than this part of their length are the same.
const SAME: f64 = 1.0 / 32.0;

/// A compressed window.
pub(in crate::identify) struct Window {
    lines: Range<usize>,
    profile: Profile,
    /// Columns of the background.
    background: usize,
    /// λ_0 of each course.
    about: Vec<Complex64>,
    /// Largest ε that it serves.
    near: f64,
    /// Coordinates of background and powers: an upper triangle.
    triangle: ComplexMatrix,
    /// What gives the coordinates of values: lines × coordinates.
    weights: ComplexMatrix,
    /// Those of the measured values, coordinates × functions.
    values: ComplexMatrix,
    /// Those of the columns of the background of all lines.
    far: ComplexMatrix,
    /// Of the data that they were taken from.
    version: u64,
}

/// Values of a window without what is known, in its coordinates.
pub(in crate::identify) struct Near {
    /// Coordinates × functions.
    values: ComplexMatrix,
    /// Their energy, over the noise.
    pub energy: f64,
}

impl Window {
    /// Of some lines, about some poles.
    pub fn new(data: &Receptances, lines: &Range<usize>, about: Vec<Complex64>) -> Self {
        let profile = Profile::new(data, lines.clone());
        let omega = &data.omega[lines.clone()];
        let background = Background::new(&data.omega, lines, data.outside());
        let first = background.columns();
        let columns = first + POWERS * about.len();
        let courses = courses(data.line_shape, omega, &about);
        let value = |k: usize, column: usize| {
            let value = match column.checked_sub(first) {
                None => background.value(column, omega, k),
                Some(place) => courses[(k, place)],
            };
            value / profile.course[k]
        };
        let qr = ThinQr::or_not_a_number(&linalg::complex_matrix(omega.len(), columns, value));
        let weights = over(&qr.q, &profile.course);
        let rows = |matrix: &ComplexMatrix| {
            let own = matrix.subrows(lines.start, lines.len());
            linalg::adjoint_product(&weights, own)
        };
        Self {
            values: rows(data.values.matrix()),
            far: rows(data.far().columns()),
            lines: lines.clone(),
            background: first,
            triangle: qr.r,
            version: data.version(),
            near: near(data, lines, &profile),
            about,
            weights,
            profile,
        }
    }

    pub fn lines(&self) -> &Range<usize> {
        &self.lines
    }

    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Number of columns of the background.
    pub fn background(&self) -> usize {
        self.background
    }

    /// Whether the data are what they were.
    pub fn is_of(&self, data: &Receptances) -> bool {
        self.version == data.version()
    }

    /// Whether its lines are nearly these of so many: it ends with all of them where these do.
    pub fn covers(&self, lines: &Range<usize>, all: usize) -> bool {
        let most = SAME * lines.len() as f64;
        let near = |a: usize, b: usize| a.abs_diff(b) as f64 <= most;
        let ends = |own: &Range<usize>| (own.start == 0, own.end == all);
        let same = near(self.lines.start, lines.start) && near(self.lines.end, lines.end);
        same && ends(&self.lines) == ends(lines)
    }

    /// Whether all of some poles are near enough to those that it was made for.
    pub fn serves(&self, poles: &[Complex64]) -> bool {
        poles.iter().all(|lambda| self.course_of(*lambda).is_some())
    }

    /// Follows poles that it does not serve, by columns for these alone as long as it does not grow
    /// too large.
    pub fn follow(&mut self, data: &Receptances, poles: Vec<Complex64>) {
        let more = poles
            .iter()
            .filter(|lambda| self.course_of(**lambda).is_none());
        let more: Vec<Complex64> = more.copied().collect();
        let anew = self.background + POWERS * poles.len();
        let grown = self.weights.ncols() + POWERS * more.len();
        if grown as f64 > GROWN * anew as f64 || grown > self.lines.len() {
            *self = Self::new(data, &self.lines, poles);
        } else {
            self.grow(data, more);
        }
    }

    fn grow(&mut self, data: &Receptances, more: Vec<Complex64>) {
        let course = &self.profile.course;
        let courses = courses(data.line_shape, &data.omega[self.lines.clone()], &more);
        // Twice, the second time at full length: of columns that nearly lie in the basis the first
        // leaves rounding as well.
        let (above, first) = self.apart(&over(&courses, course));
        let (correction, second) = self.apart(&first.q);
        let above = above + correction * &first.r;
        let triangle = second.r * first.r;
        let own = second.q;
        let weights = over(&own, course);
        let rows = |matrix: &ComplexMatrix| {
            let own = matrix.subrows(self.lines.start, self.lines.len());
            linalg::adjoint_product(&weights, own)
        };
        self.values = stacked(&self.values, &rows(data.values.matrix()));
        self.far = stacked(&self.far, &rows(data.far().columns()));
        let (high, wide) = (self.triangle.nrows(), self.triangle.ncols());
        self.triangle =
            linalg::complex_matrix(high + own.ncols(), wide + own.ncols(), |i, j| {
                match (i.checked_sub(high), j.checked_sub(wide)) {
                    (None, None) => self.triangle[(i, j)],
                    (None, Some(j)) => above[(i, j)],
                    (Some(i), Some(j)) => triangle[(i, j)],
                    (Some(_), None) => Complex64::ZERO,
                }
            });
        let first = self.weights.ncols();
        self.weights = linalg::complex_matrix(own.nrows(), first + own.ncols(), |k, c| {
            if c < first {
                self.weights[(k, c)]
            } else {
                weights[(k, c - first)]
            }
        });
        self.about.extend(more);
    }

    /// Coordinates of columns over the course, and what is left of the columns.
    fn apart(&self, columns: &ComplexMatrix) -> (ComplexMatrix, ThinQr) {
        let course = &self.profile.course;
        let raw = linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
            columns[(k, c)] * course[k]
        });
        let coordinates = linalg::adjoint_product(&self.weights, raw.as_ref());
        let explained = &self.weights * &coordinates;
        let left = linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
            columns[(k, c)] - explained[(k, c)] * course[k]
        });
        (coordinates, ThinQr::or_not_a_number(&left))
    }

    /// Number of the course nearest to a pole, and ε.
    fn course_of(&self, lambda: Complex64) -> Option<(usize, Complex64)> {
        let offset = |own: &Complex64| match lambda - own {
            Complex64::ZERO => Complex64::ZERO,
            apart => apart / own.re.abs(),
        };
        let offsets = self.about.iter().map(offset).enumerate();
        let nearest = offsets.min_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))?;
        (nearest.1.norm() <= self.near).then_some(nearest)
    }

    /// The values without what is known: courses, lines × twice the roots, and the background of
    /// all lines.
    pub fn near(&self, around: &Surroundings, known: &ComplexMatrix) -> Near {
        let courses = linalg::adjoint_product(&self.weights, known.as_ref());
        let mut values = &self.values - courses * around.residues;
        if let Some(coordinates) = around.far {
            values -= &self.far * coordinates;
        }
        let energy = |f: usize| {
            let own: f64 = values.col(f).iter().map(Complex64::norm_sqr).sum();
            own / self.profile.level[f].powi(2)
        };
        Near {
            energy: (0..values.ncols()).map(energy).sum(),
            values,
        }
    }

    /// Energy of the values without what is known, over the noise. What no coordinate holds is that
    /// of some functions, for all.
    pub fn energy(&self, around: &Surroundings, (known, near): (&ComplexMatrix, &Near)) -> f64 {
        let functions = around.data.functions();
        let stride = functions.div_ceil(SAMPLED);
        let sampled: Vec<usize> = (0..functions).step_by(stride).collect();
        let of = |matrix: &ComplexMatrix| {
            linalg::complex_matrix(matrix.nrows(), sampled.len(), |i, place| {
                matrix[(i, sampled[place])]
            })
        };
        let mut left = known * of(around.residues);
        if let Some(coordinates) = around.far {
            let columns = around.data.far().columns();
            left += columns.subrows(self.lines.start, self.lines.len()) * of(coordinates);
        }
        let unheld = |(place, f): (usize, &usize)| {
            let own = around.data.values[*f][self.lines.clone()].iter();
            let terms = own.zip(left.col(place).iter()).zip(&self.profile.course);
            let terms =
                terms.map(|((h, known), course)| (h - known).norm_sqr() / (course * course));
            let held = near.values.col(*f).iter().map(Complex64::norm_sqr);
            (terms.sum::<f64>() - held.sum::<f64>()) / self.profile.level[*f].powi(2)
        };
        let unheld: f64 = sampled.iter().enumerate().map(unheld).sum();
        near.energy + unheld * functions as f64 / sampled.len() as f64
    }

    /// The values in the coordinates of background, courses and those derivatives that are wanted,
    /// and the energy that these can explain.
    pub fn compressed(
        &self,
        near: &Near,
        (members, moving): (&[Root], &[usize]),
    ) -> (Compressed, f64) {
        let (count, first) = (members.len(), self.background);
        let places: Vec<(usize, Complex64)> = members
            .iter()
            .map(|root| {
                let own = self.course_of(root.lambda);
                own.expect("the window follows the poles")
            })
            .collect();
        let value = |i: usize, column: usize| {
            let Some(place) = column.checked_sub(first) else {
                return self.triangle[(i, column)];
            };
            let j = if place < count {
                place
            } else {
                moving[place - count]
            };
            let (course, offset) = places[j];
            let scale = members[j].lambda.re / self.about[course].re;
            let power = |n: usize| self.triangle[(i, first + POWERS * course + n)];
            if place < count {
                scale * (power(0) + offset * (power(1) + offset * power(2)))
            } else {
                scale * scale * (power(1) + 2.0 * offset * power(2))
            }
        };
        let columns = first + count + moving.len();
        let qr = ThinQr::or_not_a_number(&linalg::complex_matrix(
            self.triangle.nrows(),
            columns,
            value,
        ));
        let z = linalg::adjoint_product(&qr.q, near.values.as_ref());
        let energy = |f: usize| {
            let own: f64 = z.col(f).iter().map(Complex64::norm_sqr).sum();
            own / self.profile.level[f].powi(2)
        };
        let explained: f64 = (0..z.ncols()).map(energy).sum();
        let rows = qr.q.ncols() - first;
        let mut courses = linalg::complex_matrix(rows, 2 * count, |_, _| Complex64::ZERO);
        for i in 0..rows {
            for j in 0..count {
                courses[(i, j)] = qr.r[(first + i, first + j)];
            }
            for (place, &j) in moving.iter().enumerate() {
                courses[(i, count + j)] = qr.r[(first + i, first + count + place)];
            }
        }
        let below = |matrix: &ComplexMatrix, columns: usize, before: usize| {
            linalg::complex_matrix(rows, columns, |i, j| matrix[(first + i, before + j)])
        };
        let compressed = Compressed {
            z: below(&z, z.ncols(), 0),
            g: below(&qr.r, count, first),
            squares: courses.adjoint() * &courses,
            courses,
        };
        (compressed, explained)
    }
}

/// How far poles may be from where a window is made for them.
fn near(data: &Receptances, lines: &Range<usize>, profile: &Profile) -> f64 {
    let strongest = |f: usize| {
        let values = data.values[f][lines.clone()].iter().zip(&profile.course);
        let powers = values.map(|(h, course)| h.norm_sqr() / (course * course));
        powers.fold(0.0, f64::max) / profile.level[f].powi(2)
    };
    let functions = (0..data.functions()).into_par_iter();
    let over_noise = functions.map(strongest).reduce(|| 1.0, f64::max).sqrt();
    (LEFT_AWAY / over_noise).cbrt().clamp(NEAR[0], NEAR[1])
}

/// Powers of the course of each pole: lines × powers of all.
fn courses(line_shape: LineShape, omega: &[f64], about: &[Complex64]) -> ComplexMatrix {
    linalg::complex_matrix(omega.len(), POWERS * about.len(), |k, place| {
        let lambda = about[place / POWERS];
        line_shape.power(lambda.re.abs(), (omega[k], lambda), place % POWERS + 1)
    })
}

/// Rows over those of a course.
fn over(columns: &ComplexMatrix, course: &[f64]) -> ComplexMatrix {
    linalg::complex_matrix(columns.nrows(), columns.ncols(), |k, c| {
        columns[(k, c)] / course[k]
    })
}

fn stacked(upper: &ComplexMatrix, lower: &ComplexMatrix) -> ComplexMatrix {
    let rows = upper.nrows();
    linalg::complex_matrix(rows + lower.nrows(), upper.ncols(), |i, j| {
        match i.checked_sub(rows) {
            None => upper[(i, j)],
            Some(i) => lower[(i, j)],
        }
    })
}

//! The linear problem of a block at some poles: shapes, what they leave over, and what the poles would change of it.
//!
//! Outputs that are measured from the same inputs with the same ratio of noise share one matrix, and one QR.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use super::noise_profile::Profile;
use super::roots::Root;
use super::sides::Sides;
use super::strength::Strength;

/// An unknown that is not linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unknown {
    /// Pole of a member, in decay rates.
    Pole(usize),
    /// Participation factor of (member, part, input).
    Factor(usize, usize, usize),
}

/// The data of a window in the coordinates of its columns.
pub(super) struct Compressed {
    /// Columns × functions.
    pub z: ComplexMatrix,
    /// Columns × members.
    pub g: ComplexMatrix,
    /// Derivatives, columns × members.
    pub dg: ComplexMatrix,
}

/// Outputs that are measured from the same inputs with the same ratio of noise.
pub(super) struct Pattern {
    pub inputs: Vec<usize>,
    /// Noise of each input relative to the output's own level.
    pub scale: Vec<f64>,
    /// Functions of each output, in the order of the inputs, and the level.
    pub outputs: Vec<(Vec<usize>, f64)>,
}

/// The linear problem at some poles.
pub(super) struct Linearised {
    /// `Σ|rest|²` over the noise.
    pub cost: f64,
    pub information: ComplexMatrix,
    pub gradient: ComplexMatrix,
    /// How strong each member is.
    pub strength: Vec<Strength>,
    pub residues: Vec<Vec<Complex64>>,
}

/// Ratios of noise that differ by less are the same.
const SAME_RATIO: f64 = 0.1;

/// The patterns of all outputs.
pub(super) fn patterns(sides: &Sides, profile: &Profile) -> Vec<Pattern> {
    let mut patterns: Vec<Pattern> = Vec::new();
    for output in &sides.outputs {
        let inputs: Vec<usize> = output.iter().map(|(input, _)| *input).collect();
        let functions: Vec<usize> = output.iter().map(|(_, f)| *f).collect();
        let level = profile.level[functions[0]];
        let scale: Vec<f64> = functions
            .iter()
            .map(|f| profile.level[*f] / level)
            .collect();
        let same = |pattern: &&mut Pattern| {
            let mut ratios = pattern.scale.iter().zip(&scale);
            pattern.inputs == inputs && ratios.all(|(a, b)| (a / b - 1.0).abs() < SAME_RATIO)
        };
        match patterns.iter_mut().find(same) {
            Some(pattern) => pattern.outputs.push((functions, level)),
            None => patterns.push(Pattern {
                inputs,
                scale,
                outputs: vec![(functions, level)],
            }),
        }
    }
    patterns
}

/// The linear problem of the outputs of a pattern.
pub(super) struct Problem<'a> {
    pub data: &'a Compressed,
    pub members: &'a [Root],
    /// Member and part of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub unknowns: &'a [Unknown],
    pub pattern: &'a Pattern,
}

impl Problem<'_> {
    /// Adds what these outputs say.
    pub fn add_to(&self, sums: &mut Linearised) {
        let rows = self.data.g.nrows();
        let high = rows * self.pattern.inputs.len();
        let factor = |column: usize, input: usize| {
            let (j, part) = self.columns[column];
            self.members[j].parts[part][input]
        };
        let b = linalg::complex_matrix(high, self.columns.len(), |row, column| {
            let place = row / rows;
            let value = self.data.g[(row % rows, self.columns[column].0)];
            value * factor(column, self.pattern.inputs[place]) / self.pattern.scale[place]
        });
        let z = linalg::complex_matrix(high, self.pattern.outputs.len(), |row, o| {
            let (functions, level) = &self.pattern.outputs[o];
            let place = row / rows;
            self.data.z[(row % rows, functions[place])] / (level * self.pattern.scale[place])
        });
        if high < self.columns.len() {
            // More shapes than numbers: nothing is known.
            return;
        }
        let qr = linalg::thin_qr(&b);
        let inverse = linalg::inverse_upper(&qr.r);
        let coordinates = qr.q.adjoint() * &z;
        // Shapes by column and output, in units of the output's noise.
        let shapes = &inverse * &coordinates;
        let rest = z - &qr.q * &coordinates;
        sums.cost += (0..rest.ncols())
            .map(|o| rest.col(o).iter().map(Complex64::norm_sqr).sum::<f64>())
            .sum::<f64>();
        self.add_information(sums, (&qr.q, &shapes, &rest));
        self.add_significance(sums, (&inverse, &shapes));
        self.set_residues(sums, &shapes);
    }

    /// Terms of the derivatives: unknown, column of the shape that multiplies it, course over the rows.
    fn terms(&self) -> Vec<(usize, usize)> {
        let mut terms = Vec::new();
        for (place, unknown) in self.unknowns.iter().enumerate() {
            match *unknown {
                Unknown::Pole(j) => {
                    let own = (0..self.columns.len()).filter(|c| self.columns[*c].0 == j);
                    terms.extend(own.map(|column| (place, column)));
                }
                Unknown::Factor(j, part, input) => {
                    if self.pattern.inputs.contains(&input) {
                        let own = self.columns.iter().position(|c| *c == (j, part));
                        terms.extend(own.map(|column| (place, column)));
                    }
                }
            }
        }
        terms
    }

    fn derivative(&self, (place, column): (usize, usize), row: usize) -> Complex64 {
        let rows = self.data.g.nrows();
        let (within, input) = (row % rows, self.pattern.inputs[row / rows]);
        let scale = self.pattern.scale[row / rows];
        let (j, part) = self.columns[column];
        match self.unknowns[place] {
            Unknown::Pole(_) => {
                self.data.dg[(within, j)] * self.members[j].parts[part][input] / scale
            }
            Unknown::Factor(_, _, own) if own == input => self.data.g[(within, j)] / scale,
            Unknown::Factor(..) => Complex64::ZERO,
        }
    }

    fn add_information(
        &self,
        sums: &mut Linearised,
        (q, shapes, rest): (&ComplexMatrix, &ComplexMatrix, &ComplexMatrix),
    ) {
        let terms = self.terms();
        let raw = linalg::complex_matrix(q.nrows(), terms.len(), |row, t| {
            self.derivative(terms[t], row)
        });
        let courses = &raw - q * (q.adjoint() * &raw);
        let inner = courses.adjoint() * &courses;
        let against = courses.adjoint() * rest;
        let alike = shapes.as_ref() * shapes.adjoint();
        for (a, (p, c)) in terms.iter().enumerate() {
            for o in 0..shapes.ncols() {
                sums.gradient[(*p, 0)] += shapes[(*c, o)].conj() * against[(a, o)];
            }
            for (b, (r, d)) in terms.iter().enumerate() {
                // Σ_o conj(ψ_c) ψ_d.
                sums.information[(*p, *r)] += alike[(*d, *c)] * inner[(a, b)];
            }
        }
    }

    fn add_significance(
        &self,
        sums: &mut Linearised,
        (inverse, shapes): (&ComplexMatrix, &ComplexMatrix),
    ) {
        for (j, strength) in sums.strength.iter_mut().enumerate() {
            let own: Vec<usize> = (0..self.columns.len())
                .filter(|c| self.columns[*c].0 == j)
                .collect();
            let row = |c: usize| (0..inverse.ncols()).map(move |k| (c, k));
            let covariance = linalg::complex_matrix(own.len(), own.len(), |a, b| {
                row(own[a])
                    .zip(row(own[b]))
                    .map(|(p, q)| inverse[p] * inverse[q].conj())
                    .sum()
            });
            let shapes =
                linalg::complex_matrix(own.len(), shapes.ncols(), |a, o| shapes[(own[a], o)]);
            strength.add(covariance, shapes);
        }
    }

    fn set_residues(&self, sums: &mut Linearised, shapes: &ComplexMatrix) {
        for (o, (functions, level)) in self.pattern.outputs.iter().enumerate() {
            for (input, f) in self.pattern.inputs.iter().zip(functions) {
                for (column, (j, part)) in self.columns.iter().enumerate() {
                    let root = &self.members[*j];
                    let value = shapes[(column, o)] * level * root.parts[*part][*input];
                    sums.residues[*j][*f] += value * root.decay().abs();
                }
            }
        }
    }
}

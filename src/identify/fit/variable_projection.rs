//! The linear problem of a block at some poles: shapes, what they leave over, and what the poles
//! would change of it.
//!
//! Outputs that are measured from the same inputs with the same ratio of noise share one matrix,
//! and one QR.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::Root;
use crate::identify::fit::mode_strength::Strength;
use crate::identify::noise::band_profile::Profile;

/// An unknown that is not linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Unknown {
    /// Pole of a member, in decay rates.
    Pole(usize),
    /// Participation factor of (member, part, input).
    Factor(usize, usize, usize),
}

/// The data of a window in the coordinates of its columns.
pub(in crate::identify) struct Compressed {
    /// Columns × functions.
    pub z: ComplexMatrix,
    /// Columns × members.
    pub g: ComplexMatrix,
    /// The same with their derivatives beside them, columns × twice the members; 0 for poles that
    /// stay.
    pub courses: ComplexMatrix,
    /// Products of these with each other.
    pub squares: ComplexMatrix,
}

/// A derivative of the model: a course over the window with a factor for each input, which the
/// shapes of one column multiply.
struct Term {
    /// Of the unknown.
    number: usize,
    /// Of the shapes.
    column: usize,
    /// Of the courses.
    course: usize,
    /// One for each input of the pattern, over its noise.
    factors: Vec<Complex64>,
}

/// Outputs that are measured from the same inputs with the same ratio of noise.
pub(in crate::identify) struct Pattern {
    pub inputs: Vec<usize>,
    /// Noise of each input relative to the output's own level.
    pub scale: Vec<f64>,
    /// Functions of each output, in the order of the inputs, and the level.
    pub outputs: Vec<(Vec<usize>, f64)>,
}

/// The linear problem at some poles.
pub(in crate::identify) struct Linearised {
    /// `Σ|rest|²` over the noise.
    pub cost: f64,
    pub information: ComplexMatrix,
    pub gradient: ComplexMatrix,
    /// How strong each member is.
    pub strength: Vec<Strength>,
    pub residues: Vec<Vec<Complex64>>,
    /// `E|δA|²` of each residue in white noise, with the unknowns where they are.
    pub residue_variances: Vec<Vec<f64>>,
    /// How the shapes follow the unknowns, pattern by pattern.
    pub turns: Vec<Turn>,
}

/// How the shapes of a pattern follow the unknowns.
pub(in crate::identify) struct Turn {
    /// Shapes by shape and term, `R⁻¹QᴴD`, for a shape of 1 that the term has.
    pub moves: ComplexMatrix,
    /// Unknown and shape of each term.
    pub of: Vec<(usize, usize)>,
    /// Shapes by column and output, in units of the output's noise.
    pub shapes: ComplexMatrix,
}

impl Turn {
    /// Of outputs that say nothing.
    fn none() -> Self {
        let nothing = || linalg::complex_matrix(0, 0, |_, _| Complex64::ZERO);
        Self {
            moves: nothing(),
            of: Vec::new(),
            shapes: nothing(),
        }
    }
}

impl Linearised {
    /// Of no output yet.
    pub fn none(members: &[Root], unknowns: usize, functions: usize) -> Self {
        Self {
            cost: 0.0,
            information: linalg::complex_matrix(unknowns, unknowns, |_, _| Complex64::ZERO),
            gradient: linalg::complex_matrix(unknowns, 1, |_, _| Complex64::ZERO),
            strength: members
                .iter()
                .map(|root| Strength::none(root.multiplicity()))
                .collect(),
            residues: vec![vec![Complex64::ZERO; functions]; members.len()],
            residue_variances: vec![vec![0.0; functions]; members.len()],
            turns: Vec::new(),
        }
    }

    /// Takes in what other outputs say.
    pub fn add(&mut self, other: Self) {
        self.cost += other.cost;
        self.turns.extend(other.turns);
        self.information += other.information;
        self.gradient += other.gradient;
        for (own, other) in self.strength.iter_mut().zip(other.strength) {
            own.take_in(other);
        }
        for (own, other) in self.residues.iter_mut().zip(other.residues) {
            for (sum, residue) in own.iter_mut().zip(other) {
                *sum += residue;
            }
        }
        for (own, other) in self
            .residue_variances
            .iter_mut()
            .zip(other.residue_variances)
        {
            for (sum, variance) in own.iter_mut().zip(other) {
                *sum += variance;
            }
        }
    }
}

/// Ratios of noise that differ by less are the same.
const SAME_RATIO: f64 = 0.1;
/// Least part of a derivative that the shapes do not explain: what rounding leaves.
const ROUNDING: f64 = 1e-15;

/// The patterns of all outputs.
pub(in crate::identify) fn patterns(sides: &Sides, profile: &Profile) -> Vec<Pattern> {
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
pub(in crate::identify) struct Problem<'a> {
    pub data: &'a Compressed,
    pub members: &'a [Root],
    /// Member and part of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub unknowns: &'a [Unknown],
    pub pattern: &'a Pattern,
}

impl Problem<'_> {
    /// What these outputs say.
    pub fn linearised(&self) -> Linearised {
        let functions = self.data.z.ncols();
        let mut sums = Linearised::none(self.members, self.unknowns.len(), functions);
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
            sums.turns.push(Turn::none());
            return sums;
        }
        let Ok(qr) = linalg::thin_qr(&b) else {
            sums.turns.push(Turn::none());
            return sums;
        };
        let inverse = linalg::inverse_upper(&qr.r);
        let coordinates = qr.q.adjoint() * &z;
        // Shapes by column and output, in units of the output's noise.
        let shapes = &inverse * &coordinates;
        let rest = z - &qr.q * &coordinates;
        sums.cost += (0..rest.ncols())
            .map(|o| rest.col(o).iter().map(Complex64::norm_sqr).sum::<f64>())
            .sum::<f64>();
        let terms = self.terms();
        let within = self.add_information(&mut sums, &terms, (&qr.q, &shapes, &rest));
        self.add_significance(&mut sums, (&inverse, &shapes));
        self.set_residues(&mut sums, (&inverse, &shapes));
        sums.turns.push(Turn {
            moves: &inverse * &within,
            of: terms.iter().map(|own| (own.number, own.column)).collect(),
            shapes,
        });
        sums
    }

    /// Derivatives by the unknowns, one for each column of shapes that an unknown concerns.
    fn terms(&self) -> Vec<Term> {
        let members = self.members.len();
        let scaled = |place: usize, factor: Complex64| factor / self.pattern.scale[place];
        let mut terms = Vec::new();
        for (number, unknown) in self.unknowns.iter().enumerate() {
            for (column, &(j, part)) in self.columns.iter().enumerate() {
                let (course, factors): (usize, Vec<Complex64>) = match *unknown {
                    Unknown::Pole(own) if own == j => {
                        let factor = |(place, input): (usize, &usize)| {
                            scaled(place, self.members[j].parts[part][*input])
                        };
                        let inputs = self.pattern.inputs.iter().enumerate();
                        (members + j, inputs.map(factor).collect())
                    }
                    Unknown::Factor(own, of, input) if (own, of) == (j, part) => {
                        let factor = |(place, other): (usize, &usize)| {
                            let one = if *other == input { 1.0 } else { 0.0 };
                            scaled(place, one.into())
                        };
                        let inputs = self.pattern.inputs.iter().enumerate();
                        (j, inputs.map(factor).collect())
                    }
                    _ => continue,
                };
                terms.push(Term {
                    number,
                    column,
                    course,
                    factors,
                });
            }
        }
        terms
    }

    /// What the derivatives say beside the columns of the shapes: `(1 − QQᴴ) D`, D = `factor ×
    /// course` input by input; returns `QᴴD`.
    ///
    /// Its squares are those of D without those of QᴴD, each formed from the courses alone, of
    /// which there are far fewer than derivatives. A difference of squares keeps 1e-16 of D: poles
    /// whose derivatives have less of their own are not told apart anyway.
    fn add_information(
        &self,
        sums: &mut Linearised,
        terms: &[Term],
        (q, shapes, rest): (&ComplexMatrix, &ComplexMatrix, &ComplexMatrix),
    ) -> ComplexMatrix {
        let rows = self.data.g.nrows();
        let (inputs, outputs) = (self.pattern.inputs.len(), rest.ncols());
        let zero = |rows, columns| linalg::complex_matrix(rows, columns, |_, _| Complex64::ZERO);
        let mut within = zero(q.ncols(), terms.len());
        let mut against = zero(terms.len(), outputs);
        for place in 0..inputs {
            let own = rows * place;
            let of_q = q.subrows(own, rows).adjoint() * &self.data.courses;
            let of_rest = self.data.courses.adjoint() * rest.subrows(own, rows);
            for (t, term) in terms.iter().enumerate() {
                let factor = term.factors[place];
                if factor == Complex64::ZERO {
                    continue;
                }
                for c in 0..q.ncols() {
                    within[(c, t)] += factor * of_q[(c, term.course)];
                }
                for o in 0..outputs {
                    against[(t, o)] += factor.conj() * of_rest[(term.course, o)];
                }
            }
        }
        let factors =
            linalg::complex_matrix(inputs, terms.len(), |place, t| terms[t].factors[place]);
        let all = factors.adjoint() * &factors;
        let explained = within.adjoint() * &within;
        let alike = shapes.as_ref() * shapes.adjoint();
        for (a, one) in terms.iter().enumerate() {
            for o in 0..outputs {
                sums.gradient[(one.number, 0)] += shapes[(one.column, o)].conj() * against[(a, o)];
            }
            for (b, other) in terms.iter().enumerate() {
                let whole = all[(a, b)] * self.data.squares[(one.course, other.course)];
                let mut inner = whole - explained[(a, b)];
                if a == b {
                    inner.re = inner.re.max(ROUNDING * whole.re);
                }
                // Σ_o conj(ψ_c) ψ_d.
                sums.information[(one.number, other.number)] +=
                    alike[(other.column, one.column)] * inner;
            }
        }
        within
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

    /// Residues, and their variances from those of the shapes, `R⁻¹R⁻ᴴ` in units of the output's
    /// noise.
    fn set_residues(
        &self,
        sums: &mut Linearised,
        (inverse, shapes): (&ComplexMatrix, &ComplexMatrix),
    ) {
        for (place, input) in self.pattern.inputs.iter().enumerate() {
            let factor = |(j, part): &(usize, usize)| {
                let root = &self.members[*j];
                root.parts[*part][*input] * root.decay().abs()
            };
            let mut unit = vec![vec![Complex64::ZERO; inverse.ncols()]; self.members.len()];
            for (column, own) in self.columns.iter().enumerate() {
                for (k, sum) in unit[own.0].iter_mut().enumerate() {
                    *sum += factor(own) * inverse[(column, k)];
                }
            }
            let unit: Vec<f64> = unit
                .iter()
                .map(|row| row.iter().map(Complex64::norm_sqr).sum())
                .collect();
            for (o, (functions, level)) in self.pattern.outputs.iter().enumerate() {
                let f = functions[place];
                for (column, own) in self.columns.iter().enumerate() {
                    sums.residues[own.0][f] += shapes[(column, o)] * level * factor(own);
                }
                for (variances, unit) in sums.residue_variances.iter_mut().zip(&unit) {
                    variances[f] = unit * level * level;
                }
            }
        }
    }
}

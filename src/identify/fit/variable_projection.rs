//! One evaluation of variable projection at given poles of a block computes the shapes by QR, the
//! residual, the gradient by the poles, and the information matrix.
//!
//! Outputs that are measured from the same inputs with the same ratio of noise have one matrix and
//! one QR in common.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::noise::band_profile::BandProfile;

/// A nonlinear unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::identify) enum Unknown {
    /// Pole of a member, in decay rates.
    Pole(usize),
    /// Participation factor of (member, rank-one term, input).
    Factor(usize, usize, usize),
}

/// The data of a compressed band in the coordinates of its columns.
pub(in crate::identify) struct Compressed {
    /// Columns × FRFs.
    pub z: ComplexMatrix,
    /// Columns × members.
    pub g: ComplexMatrix,
    /// The same followed by their derivatives, columns × twice the members; 0 for fixed poles.
    pub line_shapes: ComplexMatrix,
    /// Products of these columns with each other.
    pub squares: ComplexMatrix,
}

/// A derivative of the model: a profile over the lines with a factor for each input, multiplied by
/// the shapes of one column.
struct Term {
    /// Number of the unknown.
    number: usize,
    /// Column of the shapes.
    column: usize,
    /// Column of the line shapes and their derivatives.
    line_shape: usize,
    /// One for each input of the pattern, over its noise.
    factors: Vec<Complex64>,
}

/// Outputs that are measured from the same inputs with the same ratio of noise.
pub(in crate::identify) struct Pattern {
    pub inputs: Vec<usize>,
    /// Noise of each input relative to the level of the output.
    pub scale: Vec<f64>,
    /// FRFs of each output, in the order of the inputs, and the level.
    pub outputs: Vec<(Vec<usize>, f64)>,
}

/// The linear problem at some poles.
pub(in crate::identify) struct Linearised {
    /// `Σ|r|²` of the residual r over the noise.
    pub cost: f64,
    pub information: ComplexMatrix,
    pub gradient: ComplexMatrix,
    /// Shapes of each pattern; `None` for outputs without information. Most steps of a fit read
    /// none of them.
    pub solutions: Vec<Option<ShapeSolution>>,
}

/// Shapes of the outputs of a pattern.
pub(in crate::identify) struct ShapeSolution {
    /// `R⁻¹` of the columns of the shapes.
    pub inverse: ComplexMatrix,
    /// Shapes by column and output, in units of the output's noise.
    pub shapes: ComplexMatrix,
    /// `QᴴD`, shapes × terms, for a shape value of 1 in the term.
    pub within: ComplexMatrix,
    /// Unknown and shape of each term.
    pub of: Vec<(usize, usize)>,
}

impl Linearised {
    /// Sum over no output.
    pub fn none(unknowns: usize) -> Self {
        Self {
            cost: 0.0,
            information: linalg::complex_matrix(unknowns, unknowns, |_, _| Complex64::ZERO),
            gradient: linalg::complex_matrix(unknowns, 1, |_, _| Complex64::ZERO),
            solutions: Vec::new(),
        }
    }

    /// Adds the sum over other outputs.
    pub fn add(&mut self, other: Self) {
        self.cost += other.cost;
        self.solutions.extend(other.solutions);
        self.information += other.information;
        self.gradient += other.gradient;
    }
}

/// Maximum relative difference of equal ratios of noise.
const MAX_RATIO_DIFFERENCE: f64 = 0.1;
/// Minimum squared component of a derivative outside the shapes, over its square: rounding.
const ROUND_OFF_ENERGY: f64 = 1e-15;

/// The patterns of all outputs.
pub(in crate::identify) fn patterns(frf_matrix: &FrfMatrix, profile: &BandProfile) -> Vec<Pattern> {
    let mut patterns: Vec<Pattern> = Vec::new();
    for output in &frf_matrix.outputs {
        let inputs: Vec<usize> = output.iter().map(|(input, _)| *input).collect();
        let functions: Vec<usize> = output.iter().map(|(_, f)| *f).collect();
        let level = profile.level[functions[0]];
        let scale: Vec<f64> = functions
            .iter()
            .map(|f| profile.level[*f] / level)
            .collect();
        let same = |pattern: &&mut Pattern| {
            let mut ratios = pattern.scale.iter().zip(&scale);
            pattern.inputs == inputs
                && ratios.all(|(a, b)| (a / b - 1.0).abs() < MAX_RATIO_DIFFERENCE)
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
    pub members: &'a [ModelPole],
    /// Member and rank-one term of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub unknowns: &'a [Unknown],
    pub pattern: &'a Pattern,
}

impl Problem<'_> {
    /// Solves the linear problem of these outputs.
    pub fn linearised(&self) -> Linearised {
        let mut sums = Linearised::none(self.unknowns.len());
        let rows = self.data.g.nrows();
        let high = rows * self.pattern.inputs.len();
        let factor = |column: usize, input: usize| {
            let (j, part) = self.columns[column];
            self.members[j].parts[part][input]
        };
        let b = linalg::complex_matrix(high, self.columns.len(), |row, column| {
            let index = row / rows;
            let value = self.data.g[(row % rows, self.columns[column].0)];
            value * factor(column, self.pattern.inputs[index]) / self.pattern.scale[index]
        });
        let z = linalg::complex_matrix(high, self.pattern.outputs.len(), |row, o| {
            let (functions, level) = &self.pattern.outputs[o];
            let index = row / rows;
            self.data.z[(row % rows, functions[index])] / (level * self.pattern.scale[index])
        });
        if high < self.columns.len() {
            // More shapes than values: no information.
            sums.solutions.push(None);
            return sums;
        }
        let Ok(qr) = linalg::thin_qr(&b) else {
            sums.solutions.push(None);
            return sums;
        };
        let inverse = linalg::inverse_upper(&qr.r);
        let coordinates = qr.q.adjoint() * &z;
        // Shapes by column and output, over the noise of the output.
        let shapes = &inverse * &coordinates;
        let residual = z - &qr.q * &coordinates;
        sums.cost += (0..residual.ncols())
            .map(|o| residual.col(o).iter().map(Complex64::norm_sqr).sum::<f64>())
            .sum::<f64>();
        let terms = self.terms();
        let within = self.add_information(&mut sums, &terms, &qr.q, &shapes, &residual);
        let of = terms.iter().map(|term| (term.number, term.column));
        sums.solutions.push(Some(ShapeSolution {
            of: of.collect(),
            inverse,
            shapes,
            within,
        }));
        sums
    }

    /// Derivatives by the unknowns, one for each column of shapes that depends on an unknown.
    fn terms(&self) -> Vec<Term> {
        let members = self.members.len();
        let scaled = |index: usize, factor: Complex64| factor / self.pattern.scale[index];
        let mut terms = Vec::new();
        for (number, unknown) in self.unknowns.iter().enumerate() {
            for (column, &(j, part)) in self.columns.iter().enumerate() {
                let (line_shape, factors): (usize, Vec<Complex64>) = match *unknown {
                    Unknown::Pole(member) if member == j => {
                        let factor = |(index, input): (usize, &usize)| {
                            scaled(index, self.members[j].parts[part][*input])
                        };
                        let inputs = self.pattern.inputs.iter().enumerate();
                        (members + j, inputs.map(factor).collect())
                    }
                    Unknown::Factor(member, term, input) if (member, term) == (j, part) => {
                        let factor = |(index, other): (usize, &usize)| {
                            let factor = if *other == input { 1.0 } else { 0.0 };
                            scaled(index, factor.into())
                        };
                        let inputs = self.pattern.inputs.iter().enumerate();
                        (j, inputs.map(factor).collect())
                    }
                    _ => continue,
                };
                terms.push(Term {
                    number,
                    column,
                    line_shape,
                    factors,
                });
            }
        }
        terms
    }

    /// Adds the information of the derivatives orthogonal to the columns of the shapes: `(1 − QQᴴ)
    /// D`, D = `factor × profile` input by input; returns `QᴴD`.
    ///
    /// Its squares are those of D minus those of QᴴD, each formed from the profiles alone, which
    /// are far fewer than the derivatives. A difference of squares is exact to 1e-16 of D: poles
    /// with a smaller component are not separable.
    fn add_information(
        &self,
        sums: &mut Linearised,
        terms: &[Term],
        q: &ComplexMatrix,
        shapes: &ComplexMatrix,
        residual: &ComplexMatrix,
    ) -> ComplexMatrix {
        let rows = self.data.g.nrows();
        let (inputs, outputs) = (self.pattern.inputs.len(), residual.ncols());
        let zero = |rows, columns| linalg::complex_matrix(rows, columns, |_, _| Complex64::ZERO);
        let mut within = zero(q.ncols(), terms.len());
        let mut products = zero(terms.len(), outputs);
        for index in 0..inputs {
            let start = rows * index;
            let of_q = q.subrows(start, rows).adjoint() * &self.data.line_shapes;
            let of_residual = self.data.line_shapes.adjoint() * residual.subrows(start, rows);
            for (t, term) in terms.iter().enumerate() {
                let factor = term.factors[index];
                if factor == Complex64::ZERO {
                    continue;
                }
                let columns = within.col_as_slice_mut(t).iter_mut();
                for (sum, product) in columns.zip(of_q.col_as_slice(term.line_shape)) {
                    *sum = *sum + factor * product;
                }
                for o in 0..outputs {
                    products[(t, o)] =
                        products[(t, o)] + factor.conj() * of_residual[(term.line_shape, o)];
                }
            }
        }
        let factors =
            linalg::complex_matrix(inputs, terms.len(), |index, t| terms[t].factors[index]);
        let all = factors.adjoint() * &factors;
        let explained = within.adjoint() * &within;
        let shape_products = shapes.as_ref() * shapes.adjoint();
        for (a, term) in terms.iter().enumerate() {
            let mut gradient = sums.gradient[(term.number, 0)];
            for o in 0..outputs {
                gradient = gradient + shapes[(term.column, o)].conj() * products[(a, o)];
            }
            sums.gradient[(term.number, 0)] = gradient;
            for (b, other) in terms.iter().enumerate() {
                let whole = all[(a, b)] * self.data.squares[(term.line_shape, other.line_shape)];
                let mut inner = whole - explained[(a, b)];
                if a == b {
                    inner.re = inner.re.max(ROUND_OFF_ENERGY * whole.re);
                }
                // Σ_o conj(ψ_c) ψ_d.
                let place = (term.number, other.number);
                sums.information[place] =
                    sums.information[place] + shape_products[(other.column, term.column)] * inner;
            }
        }
        within
    }
}

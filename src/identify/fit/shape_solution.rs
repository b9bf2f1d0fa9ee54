//! Residues of the members of a block, with their variances and strengths, from the shapes of its
//! patterns.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix};

use crate::identify::data::model_pole::ModelPole;
use crate::identify::fit::mode_strength::Strength;
use crate::identify::fit::variable_projection::{Pattern, ShapeSolution};

/// Shapes of all patterns of a block.
pub(in crate::identify) struct BlockShapes<'a> {
    pub members: &'a [ModelPole],
    /// Member and rank-one term of each column of shapes.
    pub columns: &'a [(usize, usize)],
    pub patterns: &'a [Pattern],
    /// One for each pattern; `None` for outputs without information.
    pub solutions: &'a [Option<ShapeSolution>],
    /// Number of FRFs.
    pub functions: usize,
}

/// Residues of a member by FRF.
pub(in crate::identify) struct MemberResidues {
    pub values: Vec<Complex64>,
    /// `E|δA|²` of each in white noise, for exact unknowns.
    pub variances: Vec<f64>,
}

impl BlockShapes<'_> {
    fn solved(&self) -> impl Iterator<Item = (&Pattern, &ShapeSolution)> {
        let pairs = self.patterns.iter().zip(self.solutions);
        pairs.filter_map(|(pattern, solution)| Some((pattern, solution.as_ref()?)))
    }

    /// Strength of each member.
    pub fn strengths(&self) -> Vec<Strength> {
        let strength = |j: usize| {
            let modes = self.members[j].multiplicity();
            let mut strength = Strength::none(modes);
            for (_, solution) in self.solved() {
                let mut of_pattern = Strength::none(modes);
                self.add_strength(&mut of_pattern, j, solution);
                strength.merge(of_pattern);
            }
            strength
        };
        (0..self.members.len()).map(strength).collect()
    }

    fn add_strength(&self, strength: &mut Strength, member: usize, solution: &ShapeSolution) {
        let ShapeSolution {
            inverse, shapes, ..
        } = solution;
        let columns: Vec<usize> = (0..self.columns.len())
            .filter(|c| self.columns[*c].0 == member)
            .collect();
        let row = |c: usize| (0..inverse.ncols()).map(move |k| (c, k));
        if let [column] = columns[..] {
            let variance = row(column).map(|place| inverse[place].norm_sqr()).sum();
            let shapes = (0..shapes.ncols()).map(|o| shapes[(column, o)]);
            return strength.add_single(variance, shapes);
        }
        let covariance = linalg::complex_matrix(columns.len(), columns.len(), |a, b| {
            row(columns[a])
                .zip(row(columns[b]))
                .map(|(p, q)| inverse[p] * inverse[q].conj())
                .sum()
        });
        let shapes = linalg::complex_matrix(columns.len(), shapes.ncols(), |a, o| {
            shapes[(columns[a], o)]
        });
        strength.add(covariance, shapes);
    }

    /// Residues of each member, and their variances from those of the shapes, `R⁻¹R⁻ᴴ` over the
    /// noise of the output.
    pub fn residues(&self) -> Vec<MemberResidues> {
        let none = || MemberResidues {
            values: vec![Complex64::ZERO; self.functions],
            variances: vec![0.0; self.functions],
        };
        let mut residues: Vec<MemberResidues> = self.members.iter().map(|_| none()).collect();
        for (pattern, solution) in self.solved() {
            self.set_residues(&mut residues, pattern, solution);
        }
        residues
    }

    fn set_residues(
        &self,
        residues: &mut [MemberResidues],
        pattern: &Pattern,
        solution: &ShapeSolution,
    ) {
        let ShapeSolution {
            inverse, shapes, ..
        } = solution;
        for (index, input) in pattern.inputs.iter().enumerate() {
            let factor = |(j, part): &(usize, usize)| {
                let root = &self.members[*j];
                root.parts[*part][*input] * root.decay().abs()
            };
            let unit = self.unit_variances(inverse, factor);
            for (o, (functions, level)) in pattern.outputs.iter().enumerate() {
                let f = functions[index];
                for (column, indices) in self.columns.iter().enumerate() {
                    let value = &mut residues[indices.0].values[f];
                    *value = *value + shapes[(column, o)] * level * factor(indices);
                }
                for (residues, unit) in residues.iter_mut().zip(&unit) {
                    residues.variances[f] = unit * level * level;
                }
            }
        }
    }

    /// Variance of the residue of each member for shapes over the noise, by the factors of an
    /// input.
    fn unit_variances(
        &self,
        inverse: &ComplexMatrix,
        factor: impl Fn(&(usize, usize)) -> Complex64,
    ) -> Vec<f64> {
        let mut unit = vec![vec![Complex64::ZERO; inverse.ncols()]; self.members.len()];
        for (column, indices) in self.columns.iter().enumerate() {
            let factor = factor(indices);
            for (k, sum) in unit[indices.0].iter_mut().enumerate() {
                *sum = *sum + factor * inverse[(column, k)];
            }
        }
        let square = |row: &Vec<Complex64>| row.iter().map(Complex64::norm_sqr).sum();
        unit.iter().map(square).collect()
    }
}

//! The fit within one run: Gauss-Newton steps and initial poles from the FRFs of this run alone,
//! with all other poles and out-of-band terms fitted as well.

use std::rc::Rc;

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr, sort_ascending_by};

use crate::identify::run_variation::resonance::{CONVERGED_STEP_DECAY_RATES, Resonance};

/// Maximum change of a decay rate over that of its frequency.
const MAX_SLOPE: f64 = 0.5;
/// Minimum independent fraction of two profiles.
const MIN_INDEPENDENT_FRACTION: f64 = 1e-6;
/// Minimum distance of two initial poles, decay rates.
const MIN_SEPARATION_DECAY_RATES: f64 = 0.1;
/// Maximum number of steps of an initial pole, and maximum step, decay rates.
const MAX_INITIAL_STEPS: usize = 8;
const MAX_INITIAL_STEP_DECAY_RATES: f64 = 0.5;

/// A straight line of decay rate over frequency.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub middle: Complex64,
    pub slope: f64,
}

impl Line {
    /// The line through poles, each with the weight of its run.
    pub fn through(poles: &[Complex64], steps: &[Step]) -> Self {
        let pairs = || poles.iter().zip(steps);
        let weights: f64 = steps.iter().map(|step| step.weight).sum();
        let middle = pairs().map(|(pole, step)| pole * step.weight);
        let middle = middle.sum::<Complex64>() / weights;
        let (mut cross, mut square) = (0.0, 0.0);
        for (pole, step) in pairs() {
            let from = pole - middle;
            cross += step.weight * from.re * from.im;
            square += step.weight * from.im * from.im;
        }
        // Shifts by rounding have no slope.
        let shifted = square > weights * (CONVERGED_STEP_DECAY_RATES * middle.re).powi(2);
        let slope = if shifted { cross / square } else { 0.0 };
        Self {
            middle,
            slope: slope.clamp(-MAX_SLOPE, MAX_SLOPE),
        }
    }

    pub fn at(&self, omega: f64) -> f64 {
        self.middle.re + self.slope * (omega - self.middle.im)
    }
}

/// The FRFs of a run around a resonance.
pub(super) struct Run<'a> {
    resonance: &'a Resonance<'a>,
    pub functions: &'a [usize],
    /// Orthonormal basis of out-of-band terms and other poles.
    others: Rc<ComplexMatrix>,
    /// Values orthogonal to that basis: lines × FRFs of the run.
    values: ComplexMatrix,
}

/// Fit of FRFs with some poles.
pub(super) struct RunFit {
    /// Amplitudes: poles × FRFs.
    pub amplitudes: ComplexMatrix,
    /// Products of the derivatives of the profiles with the residual: poles × FRFs.
    along: ComplexMatrix,
    /// Products of those derivatives with each other.
    second: ComplexMatrix,
    /// Residual energy `Σ|r|²`.
    pub residual_energy: f64,
}

/// Initial values of one pole or two of a run.
pub(super) struct Best {
    pub one: Complex64,
    /// Energy that one pole explains after a few steps from there.
    pub by_one: f64,
    /// Two poles in ascending order, and the energy that they explain.
    pub two: Option<([Complex64; 2], f64)>,
}

/// One Gauss-Newton step of a pole in a run.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub change: Complex64,
    /// Reciprocal of the variance of the change in noise of unit variance: `Σ|A|²|g|²` of a single
    /// pole.
    pub weight: f64,
}

impl RunFit {
    /// Residual energy of one pole and the derivative of its profile.
    pub fn without_derivative(&self) -> f64 {
        self.residual_energy - self.along.squared_norm_l2() / self.second[(0, 0)].re
    }

    /// Gauss-Newton steps of the poles from some of the FRFs.
    pub fn steps(&self, functions: impl Iterator<Item = usize> + Clone) -> Vec<Step> {
        let poles = self.along.nrows();
        let a = &self.amplitudes;
        let gradient = linalg::complex_matrix(poles, 1, |j, _| {
            let selected = functions.clone();
            selected
                .map(|f| a[(j, f)].conj() * self.along[(j, f)])
                .sum()
        });
        let normal = linalg::complex_matrix(poles, poles, |j, i| {
            let products = functions.clone().map(|f| a[(j, f)].conj() * a[(i, f)]);
            products.sum::<Complex64>() * self.second[(j, i)]
        });
        if let Some(inverse) = linalg::inverse_hermitian(&normal) {
            let changes = &inverse * gradient;
            let step = |j: usize| Step {
                change: changes[(j, 0)],
                weight: inverse[(j, j)].re.recip(),
            };
            return (0..poles).map(step).collect();
        }
        // Inseparable poles have no step, but one near others of no amplitude has.
        let step = |j: usize| {
            let weight = normal[(j, j)].re;
            let alone = (0..poles).all(|i| i == j || normal[(i, i)].re <= 0.0);
            if alone && weight > 0.0 {
                let change = gradient[(j, 0)] / weight;
                return Step { change, weight };
            }
            Step {
                change: Complex64::ZERO,
                weight: 0.0,
            }
        };
        (0..poles).map(step).collect()
    }
}

impl<'a> Run<'a> {
    pub fn new(
        resonance: &'a Resonance<'a>,
        values: &ComplexMatrix,
        functions: &'a [usize],
        others: Rc<ComplexMatrix>,
    ) -> Self {
        let values = linalg::complex_matrix(values.nrows(), functions.len(), |k, index| {
            values[(k, functions[index])]
        });
        Self {
            values: without(&others, &values),
            others,
            resonance,
            functions,
        }
    }

    /// Profiles: powers of `1/(iω − λ)` for some poles over the profile of the noise, lines ×
    /// poles.
    fn profiles(&self, poles: &[Complex64], power: usize) -> ComplexMatrix {
        let Resonance {
            omega,
            profile,
            data,
            ..
        } = self.resonance;
        linalg::complex_matrix(omega.len(), poles.len(), |k, j| {
            data.frfs.line_shape.power(1.0, omega[k], poles[j], power) / profile.noise_profile[k]
        })
    }

    pub fn fit_amplitudes(&self, poles: &[Complex64]) -> RunFit {
        let ThinQr { q, r } =
            ThinQr::or_not_a_number(&without(&self.others, &self.profiles(poles, 1)));
        let derivatives = without(&self.others, &self.profiles(poles, 2));
        let derivatives = without(&q, &derivatives);
        let first = q.adjoint() * &self.values;
        RunFit {
            amplitudes: linalg::inverse_upper(&r) * &first,
            along: derivatives.adjoint() * &self.values,
            second: derivatives.adjoint() * &derivatives,
            residual_energy: self.values.squared_norm_l2() - first.squared_norm_l2(),
        }
    }

    /// Initial poles among trial poles: the one or the two that explain most energy.
    pub fn best(&self, trial_poles: &[Complex64]) -> Best {
        let whole = self.profiles(trial_poles, 1);
        let profiles = without(&self.others, &whole);
        let products = profiles.adjoint() * &profiles;
        let along = profiles.adjoint() * &self.values;
        let power = &along * along.adjoint();
        // A profile that hardly differs from the others carries no information.
        let differs = |j: &usize| {
            products[(*j, *j)].re > MIN_INDEPENDENT_FRACTION * whole.col(*j).squared_norm_l2()
        };
        let places: Vec<usize> = (0..trial_poles.len()).filter(differs).collect();
        let explained = |j: &usize| power[(*j, *j)].re / products[(*j, *j)].re;
        let by_energy = |i: &&usize, j: &&usize| explained(i).total_cmp(&explained(j));
        let one = places.iter().max_by(by_energy).map_or(0, |j| *j);
        let mut two = None;
        let mut by_two = 0.0;
        for (index, i) in places.iter().enumerate() {
            for j in &places[index + 1..] {
                let energy = explained_by_two(&products, &power, *i, *j);
                if let Some(energy) = energy.filter(|energy| *energy > by_two) {
                    (two, by_two) = (Some(vec![trial_poles[*i], trial_poles[*j]]), energy);
                }
            }
        }
        let (alone, left_by_one) = self.refine_initial_poles(vec![trial_poles[one]]);
        // The two poles that explain most may lie near a single strong one.
        let apart =
            |a: Complex64, b: Complex64| (a - b).norm() > MIN_SEPARATION_DECAY_RATES * -a.re;
        let second_poles = |j: &&usize| apart(alone[0], trial_poles[**j]);
        let second_poles = places.iter().filter(second_poles).map(|j| {
            let pair = vec![alone[0], trial_poles[*j]];
            (self.fit_amplitudes(&pair).residual_energy, pair)
        });
        let second = second_poles.min_by(|(a, _), (b, _)| a.total_cmp(b));
        let pairs = two.into_iter().chain(second.map(|(_, pair)| pair));
        let pairs = pairs.map(|pair| self.refine_initial_poles(pair));
        let pairs = pairs.filter(|(pair, _)| apart(pair[0], pair[1]));
        let two = pairs.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let whole = self.values.squared_norm_l2();
        Best {
            one: trial_poles[one],
            by_one: whole - left_by_one,
            two: two.map(|(mut pair, residual_energy)| {
                sort_ascending_by(&mut pair, |pole| pole.im);
                ([pair[0], pair[1]], whole - residual_energy)
            }),
        }
    }

    /// Poles after a few Gauss-Newton steps of this run alone, and their residual energy.
    fn refine_initial_poles(&self, mut poles: Vec<Complex64>) -> (Vec<Complex64>, f64) {
        let mut fit = self.fit_amplitudes(&poles);
        for _ in 0..MAX_INITIAL_STEPS {
            let steps = fit.steps(0..self.functions.len());
            let moved = |(pole, step): (&Complex64, &Step)| {
                let most = -MAX_INITIAL_STEP_DECAY_RATES * pole.re;
                let change = step.change * (most / step.change.norm()).min(1.0);
                let pole = pole + change;
                Complex64::new(pole.re.min(-f64::MIN_POSITIVE), pole.im)
            };
            let now: Vec<Complex64> = poles.iter().zip(&steps).map(moved).collect();
            let then = self.fit_amplitudes(&now);
            if then.residual_energy.is_nan() || then.residual_energy >= fit.residual_energy {
                break;
            }
            (poles, fit) = (now, then);
        }
        (poles, fit.residual_energy)
    }
}

/// Energy that two profiles explain, `tr(G⁻¹ P)` of their products G with each other and P with the
/// values; `None` where they are hardly independent.
fn explained_by_two(
    products: &ComplexMatrix,
    power: &ComplexMatrix,
    i: usize,
    j: usize,
) -> Option<f64> {
    let (a, b) = (products[(i, i)].re, products[(j, j)].re);
    let determinant = a * b - products[(i, j)].norm_sqr();
    let cross = 2.0 * (products[(i, j)] * power[(j, i)]).re;
    let energy = b * power[(i, i)].re + a * power[(j, j)].re - cross;
    (determinant > MIN_INDEPENDENT_FRACTION * a * b).then_some(energy / determinant)
}

/// Columns less what an orthonormal basis explains of them.
pub(super) fn without(basis: &ComplexMatrix, columns: &ComplexMatrix) -> ComplexMatrix {
    columns - basis * (basis.adjoint() * columns)
}

#[cfg(test)]
mod tests {
    use crate::identify::run_variation::run_fit::*;

    #[test]
    fn two_profiles_explain_the_energy_along_their_orthonormal_basis() {
        let value = |k: usize, n: usize| {
            let phase = 0.7 * (k * k) as f64 + 1.3 * (n * (k + 1)) as f64;
            Complex64::from_polar(1.0 + 0.1 * n as f64, phase)
        };
        let column = |k: usize, j: usize| value(k, j) + 0.4 * value(k, 1 - j);
        let values = linalg::complex_matrix(9, 2, |k, f| value(k, 5 + f));
        // The third hardly differs from the first.
        let profiles = linalg::complex_matrix(9, 3, |k, j| match j {
            2 => column(k, 0) * (1.0 + 1e-5 * k as f64),
            _ => column(k, j),
        });
        let products = profiles.adjoint() * &profiles;
        let along = profiles.adjoint() * &values;
        let power = &along * along.adjoint();
        let basis = linalg::thin_qr(&linalg::complex_matrix(9, 2, column))
            .unwrap()
            .q;
        let expected = (basis.adjoint() * &values).squared_norm_l2();
        let energy = explained_by_two(&products, &power, 0, 1).expect("they differ");
        assert!(
            (energy / expected - 1.0).abs() < 1e-12,
            "{energy} {expected}"
        );
        assert_eq!(explained_by_two(&products, &power, 0, 2), None);
    }
}

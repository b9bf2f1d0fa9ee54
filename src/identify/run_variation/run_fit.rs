//! What one run says of a pole: a Gauss-Newton step from where it is, and where to begin, beside
//! all else that is known there.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr};

use crate::identify::run_variation::resonance::{Resonance, STILL};

/// Largest change of a decay rate over that of its frequency.
const STEEPEST: f64 = 0.5;
/// Part of two courses that both must have of their own.
const TOLD_APART: f64 = 1e-6;
/// Distance of two beginnings, decay rates.
const LEAST_APART: f64 = 0.1;
/// Steps of a beginning, and the longest of them, decay rates.
const FIRST_TURNS: usize = 8;
const LONGEST_FIRST: f64 = 0.5;

/// A straight line of decay over frequency.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub middle: Complex64,
    pub slope: f64,
}

impl Line {
    /// Through poles, each by the weight of its run.
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
        // Shifts of rounding have no slope.
        let shifted = square > weights * (STILL * middle.re).powi(2);
        let slope = if shifted { cross / square } else { 0.0 };
        Self {
            middle,
            slope: slope.clamp(-STEEPEST, STEEPEST),
        }
    }

    pub fn at(&self, omega: f64) -> f64 {
        self.middle.re + self.slope * (omega - self.middle.im)
    }
}

/// The functions of a run around a resonance.
pub(super) struct Run<'a> {
    resonance: &'a Resonance<'a>,
    pub functions: &'a [usize],
    /// Orthonormal: background and other poles.
    others: ComplexMatrix,
    /// What those do not explain: lines × functions of the run.
    values: ComplexMatrix,
}

/// What functions say of some poles.
pub(super) struct Look {
    /// Poles × functions.
    pub amplitudes: ComplexMatrix,
    /// Of the courses of the poles' derivatives in what the poles leave over: poles × functions.
    along: ComplexMatrix,
    /// Products of those courses.
    second: ComplexMatrix,
    /// `Σ|rest|²`.
    pub left: f64,
}

/// Where one pole or two of a run may begin.
pub(super) struct Best {
    pub one: Complex64,
    /// What one pole explains after a few steps from there.
    pub by_one: f64,
    /// In ascending order, and what they explain.
    pub two: Option<([Complex64; 2], f64)>,
}

/// One Gauss-Newton step of a pole in a run.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub change: Complex64,
    /// One over the variance of the change in noise of unit variance: `Σ|A|²|g|²` of a pole alone.
    pub weight: f64,
}

impl Look {
    /// What one pole and the course of its derivative leave over.
    pub fn without_derivative(&self) -> f64 {
        self.left - self.along.squared_norm_l2() / self.second[(0, 0)].re
    }

    /// The changes of the poles that some of the functions ask for.
    pub fn steps(&self, functions: impl Iterator<Item = usize> + Clone) -> Vec<Step> {
        let poles = self.along.nrows();
        let a = &self.amplitudes;
        let asked = linalg::complex_matrix(poles, 1, |j, _| {
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
            let changes = &inverse * asked;
            let step = |j: usize| Step {
                change: changes[(j, 0)],
                weight: inverse[(j, j)].re.recip(),
            };
            return (0..poles).map(step).collect();
        }
        // Poles that are not told apart say nothing, but one beside others that are not there does.
        let step = |j: usize| {
            let weight = normal[(j, j)].re;
            let alone = (0..poles).all(|i| i == j || normal[(i, i)].re <= 0.0);
            if alone && weight > 0.0 {
                let change = asked[(j, 0)] / weight;
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
        (values, functions): (&ComplexMatrix, &'a [usize]),
        beside: &[Complex64],
    ) -> Self {
        let others = resonance.basis(beside);
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

    /// Courses of a power of `1/(iω − λ)` for some poles over that of the noise: lines × poles.
    fn courses(&self, poles: &[Complex64], power: usize) -> ComplexMatrix {
        let Resonance {
            omega,
            profile,
            data,
            ..
        } = self.resonance;
        linalg::complex_matrix(omega.len(), poles.len(), |k, j| {
            data.line_shape.power(1.0, (omega[k], poles[j]), power) / profile.course[k]
        })
    }

    pub fn look(&self, poles: &[Complex64]) -> Look {
        let ThinQr { q, r } =
            ThinQr::or_not_a_number(&without(&self.others, &self.courses(poles, 1)));
        let derivatives = without(&self.others, &self.courses(poles, 2));
        let derivatives = without(&q, &derivatives);
        let first = q.adjoint() * &self.values;
        Look {
            amplitudes: linalg::inverse_upper(&r) * &first,
            along: derivatives.adjoint() * &self.values,
            second: derivatives.adjoint() * &derivatives,
            left: self.values.squared_norm_l2() - first.squared_norm_l2(),
        }
    }

    /// Beginnings among the poles that are tried: the one or the two that explain most.
    pub fn best(&self, tried: &[Complex64]) -> Best {
        let whole = self.courses(tried, 1);
        let courses = without(&self.others, &whole);
        let products = courses.adjoint() * &courses;
        let along = courses.adjoint() * &self.values;
        let power = &along * along.adjoint();
        // What hardly differs from what is known says nothing.
        let differs =
            |j: &usize| products[(*j, *j)].re > TOLD_APART * whole.col(*j).squared_norm_l2();
        let places: Vec<usize> = (0..tried.len()).filter(differs).collect();
        let explained = |j: &usize| power[(*j, *j)].re / products[(*j, *j)].re;
        let by_energy = |i: &&usize, j: &&usize| explained(i).total_cmp(&explained(j));
        let one = places.iter().max_by(by_energy).map_or(0, |j| *j);
        let mut two = None;
        let mut by_two = 0.0;
        for (index, i) in places.iter().enumerate() {
            for j in &places[index + 1..] {
                let energy = explained_by_two((&products, &power), (*i, *j));
                if let Some(energy) = energy.filter(|energy| *energy > by_two) {
                    (two, by_two) = (Some(vec![tried[*i], tried[*j]]), energy);
                }
            }
        }
        let (alone, left_by_one) = self.turned(vec![tried[one]]);
        // The two that explain most may be beside a strong one alone.
        let apart = |a: Complex64, b: Complex64| (a - b).norm() > LEAST_APART * -a.re;
        let beside = |j: &&usize| apart(alone[0], tried[**j]);
        let beside = places.iter().filter(beside).map(|j| {
            let pair = vec![alone[0], tried[*j]];
            (self.look(&pair).left, pair)
        });
        let second = beside.min_by(|(a, _), (b, _)| a.total_cmp(b));
        let pairs = two.into_iter().chain(second.map(|(_, pair)| pair));
        let pairs = pairs.map(|pair| self.turned(pair));
        let pairs = pairs.filter(|(pair, _)| apart(pair[0], pair[1]));
        let two = pairs.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let whole = self.values.squared_norm_l2();
        Best {
            one: tried[one],
            by_one: whole - left_by_one,
            two: two.map(|(mut pair, left)| {
                pair.sort_by(|a, b| a.im.total_cmp(&b.im));
                ([pair[0], pair[1]], whole - left)
            }),
        }
    }

    /// Poles after a few Gauss-Newton steps by this run alone, and what they leave over.
    fn turned(&self, mut poles: Vec<Complex64>) -> (Vec<Complex64>, f64) {
        let mut look = self.look(&poles);
        for _ in 0..FIRST_TURNS {
            let steps = look.steps(0..self.functions.len());
            let moved = |(pole, step): (&Complex64, &Step)| {
                let most = -LONGEST_FIRST * pole.re;
                let change = step.change * (most / step.change.norm()).min(1.0);
                let pole = pole + change;
                Complex64::new(pole.re.min(-f64::MIN_POSITIVE), pole.im)
            };
            let now: Vec<Complex64> = poles.iter().zip(&steps).map(moved).collect();
            let then = self.look(&now);
            if then.left.is_nan() || then.left >= look.left {
                break;
            }
            (poles, look) = (now, then);
        }
        (poles, look.left)
    }
}

/// Energy that two courses explain, `tr(G⁻¹ P)` of their products G with each other and P with the
/// values; `None` where they are hardly two.
fn explained_by_two(
    (products, power): (&ComplexMatrix, &ComplexMatrix),
    (i, j): (usize, usize),
) -> Option<f64> {
    let (a, b) = (products[(i, i)].re, products[(j, j)].re);
    let determinant = a * b - products[(i, j)].norm_sqr();
    let cross = 2.0 * (products[(i, j)] * power[(j, i)]).re;
    let energy = b * power[(i, i)].re + a * power[(j, j)].re - cross;
    (determinant > TOLD_APART * a * b).then_some(energy / determinant)
}

/// Columns less what an orthonormal basis explains of them.
pub(super) fn without(basis: &ComplexMatrix, columns: &ComplexMatrix) -> ComplexMatrix {
    columns - basis * (basis.adjoint() * columns)
}

#[cfg(test)]
mod tests {
    use crate::identify::run_variation::run_fit::*;

    #[test]
    fn two_courses_explain_what_their_orthonormal_basis_does() {
        let value = |k: usize, n: usize| {
            let phase = 0.7 * (k * k) as f64 + 1.3 * (n * (k + 1)) as f64;
            Complex64::from_polar(1.0 + 0.1 * n as f64, phase)
        };
        let course = |k: usize, j: usize| value(k, j) + 0.4 * value(k, 1 - j);
        let values = linalg::complex_matrix(9, 2, |k, f| value(k, 5 + f));
        // The third hardly differs from the first.
        let courses = linalg::complex_matrix(9, 3, |k, j| match j {
            2 => course(k, 0) * (1.0 + 1e-5 * k as f64),
            _ => course(k, j),
        });
        let products = courses.adjoint() * &courses;
        let along = courses.adjoint() * &values;
        let power = &along * along.adjoint();
        let basis = linalg::thin_qr(&linalg::complex_matrix(9, 2, course))
            .unwrap()
            .q;
        let expected = (basis.adjoint() * &values).squared_norm_l2();
        let energy = explained_by_two((&products, &power), (0, 1)).expect("they differ");
        assert!(
            (energy / expected - 1.0).abs() < 1e-12,
            "{energy} {expected}"
        );
        assert_eq!(explained_by_two((&products, &power), (0, 2)), None);
    }
}

//! Numbers that carry their derivative by one parameter: geometry written once gives matrices and
//! their derivatives.
//!
//! A dual number `a + b e` with `e² = 0` follows `f(a + b e) = f(a) + f'(a) b e`, so that
//! arithmetic on it is exact differentiation. Nothing here knows a model.
//!
//! # Reference
//! Griewank and Walther (2008), Evaluating Derivatives, 2nd ed., chapter 3 (forward mode).

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::ParameterSpec;

/// A value and its derivative by the chosen parameter.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(super) struct Dual {
    pub value: f64,
    pub slope: f64,
}

impl Dual {
    pub const ZERO: Dual = Dual::constant(0.0);
    pub const ONE: Dual = Dual::constant(1.0);

    /// A number that does not depend on the parameter.
    pub const fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    /// The square root of a number above 0.
    pub fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        Self {
            value,
            slope: self.slope / (2.0 * value),
        }
    }

    pub fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        let dual = |value, slope: f64| Self {
            value,
            slope: slope * self.slope,
        };
        (dual(sin, cos), dual(cos, -sin))
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        Dual {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        self + -other
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        Dual {
            value: -self.value,
            slope: -self.slope,
        }
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual {
            value: self.value * other.value,
            slope: self.slope * other.value + self.value * other.slope,
        }
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual {
            value: self * other.value,
            slope: self * other.slope,
        }
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, other: Dual) -> Dual {
        let value = self.value / other.value;
        Dual {
            value,
            slope: (self.slope - value * other.slope) / other.value,
        }
    }
}

/// Values of a model's parameters by name, one of them perhaps the one to differentiate by.
pub(super) struct Values<'a> {
    pub specs: &'a [ParameterSpec],
    pub values: &'a [f64],
    /// Index of the parameter to differentiate by.
    pub by: Option<usize>,
}

impl Values<'_> {
    /// What a sum of numbers is made of: the number, or its derivative where there is a parameter
    /// to differentiate by.
    pub fn part(&self, number: Dual) -> f64 {
        match self.by {
            Some(_) => number.slope,
            None => number.value,
        }
    }

    /// The value of a parameter; not a number, which no matrix passes, for one that is not there.
    pub fn get(&self, name: &str) -> Dual {
        let at = self.specs.iter().position(|spec| spec.name == name);
        at.map_or(Dual::constant(f64::NAN), |j| Dual {
            value: self.values[j],
            slope: if self.by == Some(j) { 1.0 } else { 0.0 },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_differentiates() {
        // f(x) = (x sin x - 3 / x) / (2 - cos x): value and slope against the quotient rule written
        // out.
        let x = Dual {
            value: 0.7,
            slope: 1.0,
        };
        let (sin, cos) = x.sin_cos();
        let f = (x.sqrt() * x.sqrt() * sin - 3.0 * Dual::ONE / x) / (Dual::constant(2.0) - cos);
        let (s, c) = 0.7f64.sin_cos();
        let (upper, lower) = (0.7 * s - 3.0 / 0.7, 2.0 - c);
        let slope = ((s + 0.7 * c + 3.0 / 0.49) * lower - upper * s) / lower.powi(2);
        assert!((f.value - upper / lower).abs() < 1e-14);
        assert!((f.slope - slope).abs() < 1e-13, "{} {slope}", f.slope);
        assert_eq!(Dual::ZERO - Dual::ONE, -Dual::ONE);
    }
}

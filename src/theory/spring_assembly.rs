//! Assembly of a machine of bodies and springs, every number with its derivative by one parameter.
//!
//! `M = diag(inertia)`, `K = sum k b b^T` with `b` the stretch of a spring per unit of each
//! coordinate; the derivatives are `dK = sum dk b b^T + k (db b^T + b db^T)`. Here are sums alone:
//! what the bodies and springs are is the model's.

use crate::linalg::{RealMatrix, real_matrix};

use super::dual::Dual;
use super::{Coordinate, Motion, Spring, SystemDerivative, SystemMatrices};

/// Stretch per unit of the coordinates that take part, by their index; one that stands twice counts
/// twice.
pub(super) type Stretch = Vec<(usize, Dual)>;

/// A spring with its numbers.
struct MachineSpring {
    name: &'static str,
    stretch: Stretch,
    stiffness: Dual,
}

/// The numbers of a machine.
pub(super) struct Machine {
    coordinates: Vec<Coordinate>,
    /// Mass or moment of inertia of each coordinate.
    inertia: Vec<Dual>,
    springs: Vec<MachineSpring>,
}

impl Machine {
    /// Bodies without springs.
    pub fn new(coordinates: &[Coordinate], inertia: Vec<Dual>) -> Self {
        Self {
            coordinates: coordinates.to_vec(),
            inertia,
            springs: Vec::new(),
        }
    }

    /// Adds a spring.
    pub fn add(&mut self, name: &'static str, stiffness: Dual, stretch: Stretch) {
        self.springs.push(MachineSpring {
            name,
            stretch,
            stiffness,
        });
    }

    /// Displacement of a point of a body along a direction, per unit of the body's coordinates:
    /// `arm` is the point seen from the body's centre.
    pub fn point(&self, body: &str, arm: [Dual; 3], direction: [Dual; 3]) -> Stretch {
        self.read(body, |coordinate, axis| match coordinate.motion {
            Motion::Translation => dot(axis, direction),
            Motion::Rotation => dot(cross(axis, arm), direction),
            // Its radius is inside the coordinate: there is no arm that could be asked for.
            Motion::Arc => Dual::ZERO,
        })
    }

    /// Rotation of a body about a direction, per unit of the body's coordinates.
    pub fn rotation(&self, body: &str, direction: [Dual; 3]) -> Stretch {
        self.read(body, |coordinate, axis| match coordinate.motion {
            Motion::Rotation => dot(axis, direction),
            Motion::Translation | Motion::Arc => Dual::ZERO,
        })
    }

    fn read(&self, body: &str, reading: impl Fn(&Coordinate, [Dual; 3]) -> Dual) -> Stretch {
        let all = self.coordinates.iter().enumerate();
        all.filter(|(_, coordinate)| coordinate.body == body)
            .map(|(index, coordinate)| {
                (
                    index,
                    reading(coordinate, coordinate.axis.map(Dual::constant)),
                )
            })
            .collect()
    }

    /// M and K.
    pub fn matrices(&self) -> SystemMatrices {
        SystemMatrices {
            mass: self.diagonal(|inertia| inertia.value),
            damping: None,
            stiffness: self.sum(|k, a, b| k.value * a.value * b.value),
            springs: self.springs.iter().map(|s| self.spring(s)).collect(),
            coordinates: self.coordinates.clone(),
        }
    }

    /// dM and dK by the parameter by which the numbers are differentiated.
    pub fn derivative(&self) -> SystemDerivative {
        SystemDerivative {
            mass: self.diagonal(|inertia| inertia.slope),
            damping: None,
            stiffness: self.sum(|k, a, b| (k * (a * b)).slope),
        }
    }

    fn diagonal(&self, part: impl Fn(&Dual) -> f64) -> RealMatrix {
        let n = self.inertia.len();
        real_matrix(
            n,
            n,
            |i, j| {
                if i == j { part(&self.inertia[i]) } else { 0.0 }
            },
        )
    }

    fn sum(&self, part: impl Fn(Dual, Dual, Dual) -> f64) -> RealMatrix {
        let n = self.coordinates.len();
        let mut total = real_matrix(n, n, |_, _| 0.0);
        for spring in &self.springs {
            for &(i, a) in &spring.stretch {
                for &(j, b) in &spring.stretch {
                    total[(i, j)] += part(spring.stiffness, a, b);
                }
            }
        }
        total
    }

    fn spring(&self, spring: &MachineSpring) -> Spring {
        let mut row = vec![0.0; self.coordinates.len()];
        for (i, part) in &spring.stretch {
            row[*i] += part.value;
        }
        Spring {
            name: spring.name.to_owned(),
            row,
            stiffness: spring.stiffness.value,
        }
    }
}

/// The first stretch minus the second.
pub(super) fn minus(first: Stretch, second: Stretch) -> Stretch {
    let turned = second.into_iter().map(|(index, part)| (index, -part));
    first.into_iter().chain(turned).collect()
}

fn cross(a: [Dual; 3], b: [Dual; 3]) -> [Dual; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [Dual; 3], b: [Dual; 3]) -> Dual {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

//! Structures of masses and springs have models of wrong stiffnesses and tests with noise; the true
//! pairing of their modes is known.

use std::f64::consts::TAU;

use modalign::dof::Dof;
use modalign::linalg::{SymmetricModes, real_matrix, symmetric_modes};
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use num_complex::Complex64;
use rand::Rng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Frequencies of one root agree to this part.
const MAX_REPEATED_ROOT_DIFFERENCE: f64 = 1e-9;

/// Kinds of structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A hinged beam: bending along Z.
    Beam,
    /// A rectangular plate on hinges: bending along Z.
    Plate,
    /// A chain of masses: motion along X.
    Chain,
    /// A ring of bodies that move along X and Y, with repeated roots, which stay repeated in the
    /// test.
    Ring,
    /// Points in space, X, Y and Z, of two components joined by springs.
    Frame,
}

pub const KINDS: [Kind; 5] = [
    Kind::Beam,
    Kind::Plate,
    Kind::Chain,
    Kind::Ring,
    Kind::Frame,
];

/// Coefficients of the elongation, stiffness, class.
type Spring = (Vec<(usize, f64)>, f64, usize);

/// Unit masses at degrees of freedom, and springs.
pub struct Structure {
    dofs: Vec<Dof>,
    springs: Vec<Spring>,
}

/// What differs between a model and its test.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Standard deviation of the logarithm of each stiffness.
    pub stiffness: f64,
    /// Standard deviation of real and imaginary part of a shape value, over the root mean square of
    /// the shape.
    pub noise: f64,
}

/// A model and a test of one structure.
pub struct Twin {
    pub theory: ModalModel,
    pub test: ModalModel,
    /// The group of the root that holds most of each test mode.
    pub truth: Vec<u32>,
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

impl Structure {
    pub fn new(kind: Kind, random: &mut ChaCha8Rng) -> Self {
        match kind {
            Kind::Beam => line("Z", 40, 3),
            Kind::Chain => line("X", 40, 2),
            Kind::Plate => plate(),
            Kind::Ring => ring(),
            Kind::Frame => frame(random),
        }
    }

    fn modes(&self, factors: &[f64]) -> SymmetricModes {
        let size = self.dofs.len();
        let mut stiffness = real_matrix(size, size, |_, _| 0.0);
        for ((row, spring_stiffness, _), factor) in self.springs.iter().zip(factors) {
            for (i, a) in row {
                for (j, b) in row {
                    stiffness[(*i, *j)] += factor * spring_stiffness * a * b;
                }
            }
        }
        let mass = real_matrix(size, size, |i, j| if i == j { 1.0 } else { 0.0 });
        symmetric_modes(&stiffness, &mass).unwrap()
    }

    /// A model and a test of the lowest `count` modes at `sensors` degrees of freedom drawn at
    /// random. Every spring has a separate error factor, in a ring every class of springs, so
    /// that repeated roots stay.
    pub fn twin(
        &self,
        (kind, count): (Kind, usize),
        sensors: usize,
        errors: Errors,
        random: &mut ChaCha8Rng,
    ) -> Twin {
        let of_class: Vec<f64> = (0..16).map(|_| errors.stiffness * normal(random)).collect();
        let factor = |spring: &(Vec<(usize, f64)>, f64, usize)| match kind {
            Kind::Ring => of_class[spring.2].exp(),
            _ => (errors.stiffness * normal(random)).exp(),
        };
        let factors: Vec<f64> = self.springs.iter().map(factor).collect();
        let theory = self.modes(&vec![1.0; self.springs.len()]);
        let truth = self.modes(&factors);
        let mut places: Vec<usize> = (0..self.dofs.len()).collect();
        places.shuffle(random);
        places.truncate(sensors);
        places.sort_unstable();
        let groups = roots(&theory);
        let part = |j: usize, k: usize| -> f64 {
            let product = |i: usize| truth.vectors[(i, j)] * theory.vectors[(i, k)];
            (0..self.dofs.len()).map(product).sum::<f64>().powi(2)
        };
        let root = |j: usize| {
            let groups = groups
                .iter()
                .map(|group| group.iter().map(|&k| part(j, k)).sum::<f64>());
            let best = groups.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            best.unwrap().0 as u32
        };
        let mut model = ModalModel::default();
        for (g, group) in groups
            .iter()
            .enumerate()
            .filter(|(_, group)| group[0] < count + 8)
        {
            for &j in group {
                let shape = |p: &usize| Complex64::from(theory.vectors[(*p, j)]);
                let mut mode = self.mode(&theory, j, (&places, shape));
                mode.scaling = Scaling::UnitModalMass;
                mode.group = Some(g as u32);
                model.modes.push(mode);
            }
        }
        let mut test = ModalModel::default();
        for j in 0..count {
            let square: f64 = places.iter().map(|p| truth.vectors[(*p, j)].powi(2)).sum();
            let std = errors.noise * (square / sensors as f64).sqrt();
            let shape = |p: &usize| {
                let noise = Complex64::new(normal(random), normal(random));
                truth.vectors[(*p, j)] + std * noise
            };
            test.modes.push(self.mode(&truth, j, (&places, shape)));
        }
        Twin {
            theory: model,
            test,
            truth: (0..count).map(root).collect(),
        }
    }

    fn mode(
        &self,
        modes: &SymmetricModes,
        j: usize,
        (places, shape): (&[usize], impl FnMut(&usize) -> Complex64),
    ) -> Mode {
        let dofs = places.iter().map(|&p| self.dofs[p].clone());
        let shape = ModeShape::new(dofs.zip(places.iter().map(shape)));
        let hz = modes.omega_squared[j].max(0.0).sqrt() / TAU;
        Mode::new(hz, None, shape, Scaling::Unknown)
    }
}

/// Numbers of the modes of each root.
fn roots(modes: &SymmetricModes) -> Vec<Vec<usize>> {
    let mut roots: Vec<Vec<usize>> = Vec::new();
    for (j, eigenvalue) in modes.omega_squared.iter().enumerate() {
        match roots.last_mut() {
            Some(last)
                if eigenvalue - modes.omega_squared[last[0]]
                    <= MAX_REPEATED_ROOT_DIFFERENCE * eigenvalue =>
            {
                last.push(j)
            }
            _ => roots.push(vec![j]),
        }
    }
    roots
}

fn dof(text: &str) -> Dof {
    text.parse().unwrap()
}

/// Masses in a line, held by springs over two (a chain) or three (a hinged beam) neighbours.
fn line(axis: &str, count: usize, order: usize) -> Structure {
    let coefficients: &[f64] = if order == 2 {
        &[1.0, -1.0]
    } else {
        &[1.0, -2.0, 1.0]
    };
    let spring = |start: usize| {
        let row = coefficients.iter().enumerate();
        let row = row.filter_map(|(n, c)| Some((start.checked_add(n)?.checked_sub(1)?, *c)));
        (row.filter(|(i, _)| *i < count).collect(), 1e6, 0)
    };
    Structure {
        dofs: (1..=count).map(|n| dof(&format!("{n}:+{axis}"))).collect(),
        springs: (0..=count + 2 - order).map(spring).collect(),
    }
}

/// Masses on a grid of 9 by 6 with springs over the Laplacian of five points.
fn plate() -> Structure {
    const SIDES: (usize, usize) = (9, 6);
    let at = |x: usize, y: usize| SIDES.1 * x + y;
    let mut springs = Vec::new();
    for x in 0..SIDES.0 {
        for y in 0..SIDES.1 {
            let mut row = vec![(at(x, y), -4.4)];
            if x > 0 {
                row.push((at(x - 1, y), 1.0));
            }
            if x + 1 < SIDES.0 {
                row.push((at(x + 1, y), 1.0));
            }
            if y > 0 {
                row.push((at(x, y - 1), 1.2));
            }
            if y + 1 < SIDES.1 {
                row.push((at(x, y + 1), 1.2));
            }
            springs.push((row, 1e6, 0));
        }
    }
    let count = SIDES.0 * SIDES.1;
    Structure {
        dofs: (1..=count).map(|n| dof(&format!("{n}:+Z"))).collect(),
        springs,
    }
}

/// Bodies on a circle; each is held to the ground and to the next.
fn ring() -> Structure {
    const BODIES: usize = 16;
    let (sin, cos) = (TAU / BODIES as f64).sin_cos();
    let mut springs = Vec::new();
    for body in 0..BODIES {
        let next = (body + 1) % BODIES;
        let [a, b, c, d] = [2 * body, 2 * body + 1, 2 * next, 2 * next + 1];
        springs.push((vec![(a, 1.0)], 1e6, 0));
        springs.push((vec![(b, 1.0)], 3e5, 1));
        springs.push((vec![(c, cos), (d, -sin), (a, -1.0)], 6e6, 2));
        springs.push((vec![(c, sin), (d, cos), (b, -1.0)], 1.2e7, 3));
    }
    let axes = |body: usize| ["X", "Y"].map(|axis| dof(&format!("{}:+{axis}", body + 1)));
    Structure {
        dofs: (0..BODIES).flat_map(axes).collect(),
        springs,
    }
}

/// Points in two boxes side by side, the components `base` and `arm`, each on springs to its
/// nearest neighbours and to the ground.
fn frame(random: &mut ChaCha8Rng) -> Structure {
    const POINTS: usize = 18;
    const NEIGHBOURS: usize = 8;
    let mut point = |n: usize| {
        let shift = if n < POINTS / 2 { 0.0 } else { 1.0 };
        [
            shift + random.random::<f64>(),
            random.random(),
            random.random(),
        ]
    };
    let points: Vec<[f64; 3]> = (0..POINTS).map(&mut point).collect();
    let mut springs = Vec::new();
    for (n, from) in points.iter().enumerate() {
        let to = |m: usize| [0, 1, 2].map(|axis| points[m][axis] - from[axis]);
        let length = |m: usize| to(m).iter().map(|v| v * v).sum::<f64>().sqrt();
        let mut others: Vec<usize> = (0..POINTS).filter(|m| *m != n).collect();
        others.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        for &m in &others[..NEIGHBOURS] {
            let along = to(m).map(|v| v / length(m));
            let ends = |axis: usize| [(3 * m + axis, along[axis]), (3 * n + axis, -along[axis])];
            springs.push(((0..3).flat_map(ends).collect(), 2e6 / length(m), 0));
        }
        let ground = [1.0e5, 1.9e5, 3.3e5];
        springs.extend((0..3).map(|axis| (vec![(3 * n + axis, 1.0)], ground[axis], 0)));
    }
    let axes = |n: usize| {
        let component = if n < POINTS / 2 { "base" } else { "arm" };
        ["X", "Y", "Z"].map(|axis| dof(&format!("{component}.{}:+{axis}", n + 1)))
    };
    Structure {
        dofs: (0..POINTS).flat_map(axes).collect(),
        springs,
    }
}

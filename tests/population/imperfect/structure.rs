//! A structure is drawn by its modes at all points: normal components, or the shapes of a simply
//! supported plate on a grid.

use std::f64::consts::PI;

use modalign::axis::{Band, FrequencyAxis};
use modalign::modal::Pole;
use modalign::quantity::FrfKind;
use modalign::study::{System, TrueMode};
use num_complex::Complex64;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::systems::{dofs, log_uniform};

/// What a family draws structures from.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    pub modes: (usize, usize),
    pub damping: (f64, f64),
    pub responses: (usize, usize),
    pub references: (usize, usize),
    /// Lines of the narrowest half-power bandwidth.
    pub lines_per_bandwidth: (f64, f64),
    /// Smallest distance of two modes, half-power bandwidths of the wider.
    pub separation: f64,
}

/// What most families draw from.
pub const USUAL: Range = Range {
    modes: (4, 10),
    damping: (0.003, 0.015),
    responses: (8, 20),
    references: (1, 2),
    lines_per_bandwidth: (3.0, 8.0),
    separation: 10.0,
};

/// Highest number of lines.
const MAX_LINES: f64 = 6000.0;

/// A structure of unit modal masses.
#[derive(Clone, Debug)]
pub struct Structure {
    pub poles: Vec<Pole>,
    /// Components of each mode at all points, the first of which are hit.
    pub shapes: Vec<Vec<f64>>,
    pub references: usize,
    pub axis: FrequencyAxis,
    pub kind: FrfKind,
}

impl Structure {
    pub fn draw(random: &mut ChaCha8Rng, range: &Range) -> Self {
        let count = random.random_range(range.modes.0..=range.modes.1);
        let references = random.random_range(range.references.0..=range.references.1);
        let responses = random.random_range(range.responses.0..=range.responses.1);
        let mut hz = log_uniform(random, (20.0, 100.0));
        let mut poles: Vec<Pole> = Vec::new();
        while poles.len() < count {
            let zeta = log_uniform(random, range.damping);
            if let Some(last) = poles.last() {
                let wider = zeta.max(last.damping_ratio());
                let least = (2.0 * range.separation * wider).min(0.9);
                hz *= (1.0 + least / (1.0 - 0.5 * least)) * random.random_range(1.01..1.4);
            }
            poles.push(Pole::from_frequency(hz, zeta));
        }
        let shapes = match random.random_bool(0.5) {
            true => (0..count)
                .map(|_| normal_shape(random, responses))
                .collect(),
            false => plate_shapes(random, count, responses),
        };
        let width = |pole: &Pole| pole.half_power_width_hz();
        let narrowest = poles.iter().map(width).fold(f64::MAX, f64::min);
        let first = poles[0].natural_frequency_hz();
        let (lo, hi) = (
            first - (0.3 * first).max(4.0 * width(&poles[0])).min(0.9 * first),
            hz + (0.15 * hz).max(4.0 * width(&poles[count - 1])),
        );
        let step =
            (narrowest / log_uniform(random, range.lines_per_bandwidth)).max((hi - lo) / MAX_LINES);
        let kinds = [FrfKind::Receptance, FrfKind::Accelerance];
        Self {
            poles,
            shapes,
            references,
            axis: FrequencyAxis {
                start_hz: (lo / step).round() * step,
                step_hz: step,
                len: ((hi - lo) / step).round() as usize,
            },
            kind: kinds[random.random_range(0..2)],
        }
    }

    pub fn responses(&self) -> usize {
        self.shapes[0].len()
    }

    /// The truth with these poles and shapes.
    pub fn truth(&self, poles: &[Pole], shapes: &[Vec<Complex64>], band: Band) -> System {
        let mode = |(pole, (shape, truth)): (&Pole, (&Vec<Complex64>, &Vec<f64>))| {
            let at_references: Vec<Complex64> = truth[..self.references]
                .iter()
                .map(|value| (*value).into())
                .collect();
            TrueMode::of_unit_mass(*pole, shape.clone(), &at_references)
        };
        let shapes = shapes.iter().zip(&self.shapes);
        System {
            modes: poles.iter().zip(shapes).map(mode).collect(),
            axis: self.axis,
            band,
            kind: self.kind,
            responses: dofs(self.responses()),
            references: dofs(self.references),
            record_end_s: None,
        }
    }

    /// The shapes as complex numbers.
    pub fn complex_shapes(&self) -> Vec<Vec<Complex64>> {
        let shape = |shape: &Vec<f64>| shape.iter().map(|value| (*value).into()).collect();
        self.shapes.iter().map(shape).collect()
    }
}

fn normal_shape(random: &mut ChaCha8Rng, points: usize) -> Vec<f64> {
    (0..points).map(|_| StandardNormal.sample(random)).collect()
}

/// Shapes `2 sin(mπx) sin(nπy)` at points drawn over a plate, each with another (m, n).
fn plate_shapes(random: &mut ChaCha8Rng, count: usize, points: usize) -> Vec<Vec<f64>> {
    let places: Vec<[f64; 2]> = (0..points)
        .map(|_| {
            [
                random.random_range(0.08..0.92),
                random.random_range(0.08..0.92),
            ]
        })
        .collect();
    let numbers = (2..).flat_map(|sum: usize| (1..sum).map(move |m| (m, sum - m)));
    let shape = |(m, n): (usize, usize)| {
        let at = |[x, y]: &[f64; 2]| 2.0 * (m as f64 * PI * x).sin() * (n as f64 * PI * y).sin();
        places.iter().map(at).collect()
    };
    numbers.take(count).map(shape).collect()
}

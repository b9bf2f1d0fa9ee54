//! Two like chains, weakly coupled or not at all, and a ring: close pairs and repeated roots.

use std::f64::consts::{PI, TAU};

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::error::PopulationError;
use super::span::{Ends, KeyedSpan, MAX_COUNT, Span};
use super::structure::{DrawnMode, Row, Structure, column, elastic};

/// `kind = "close"`: two like chains, weakly coupled, so that each mode of one chain becomes a
/// pair.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CloseSpec {
    /// Number of masses of each chain.
    pub masses: Span,
    /// Each mass, kg, log-uniform.
    pub mass_kg: Span,
    /// Each spring, N/m, log-uniform.
    pub stiffness_n_per_m: Span,
    /// Distance of the two natural frequencies in half-power bandwidths of the lower one,
    /// log-uniform, drawn for each pair.
    pub spacing_widths: Span,
    /// How a pair is shared between the chains, degrees, uniform: 0 leaves each mode in its chain,
    /// 45 gives each half.
    pub sharing_deg: Span,
    /// Damping ratio of each pair, log-uniform.
    pub damping_ratio: Span,
}

/// How roots are repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arrangement {
    /// A ring of equal masses, each tied to its two neighbours and to the ground.
    Ring,
    /// Two identical chains without a tie between them.
    Twins,
}

/// `kind = "repeated"`: exactly repeated roots.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RepeatedSpec {
    /// Which arrangements there are, each with the same probability.
    pub arrangements: Vec<Arrangement>,
    /// Number of masses of the ring, or of each chain.
    pub masses: Span,
    /// Each mass, kg, log-uniform; all of a ring are equal.
    pub mass_kg: Span,
    /// Each spring, N/m, log-uniform; all of a ring are equal.
    pub stiffness_n_per_m: Span,
    /// Spring to the ground over spring between neighbours of a ring, log-uniform.
    pub ground_ratio: Span,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

impl CloseSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        vec![
            ("masses", self.masses, Ends::Whole(1, MAX_COUNT)),
            ("mass_kg", self.mass_kg, Ends::Positive),
            ("stiffness_n_per_m", self.stiffness_n_per_m, Ends::Positive),
            ("spacing_widths", self.spacing_widths, Ends::Positive),
            ("sharing_deg", self.sharing_deg, Ends::Finite),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    /// In the modal coordinates of the two chains the stiffness of pair j is the 2 by 2 matrix with
    /// the eigenvalues `omega_1^2`, `omega_2^2` and the eigenvectors `(cos, sin)`, `(-sin, cos)` of
    /// the sharing angle; the masses stay.
    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let n = self.masses.whole(random);
        let row = Row::draw(n, self.mass_kg, self.stiffness_n_per_m, random);
        let chain = row.modes()?;
        let mut modes = Vec::with_capacity(2 * n);
        for (j, omega) in chain.omega_rad_s.iter().enumerate() {
            let ratio = self.damping_ratio.log_uniform(random);
            let widths = self.spacing_widths.log_uniform(random);
            let (sin, cos) = self.sharing_deg.uniform(random).to_radians().sin_cos();
            let lower_hz = omega / TAU;
            let upper_hz = lower_hz * (1.0 + 2.0 * ratio * widths);
            let shape = column(&chain, j);
            for (hz, first, second) in [(lower_hz, cos, sin), (upper_hz, -sin, cos)] {
                modes.push(DrawnMode {
                    pair: Some(j as u32 + 1),
                    ..elastic(hz, ratio, side_by_side(&shape, first, second))
                });
            }
        }
        Ok(Structure::real(modes))
    }
}

/// The shape of one chain in two of them, each with its factor.
fn side_by_side(shape: &[f64], first: f64, second: f64) -> Vec<f64> {
    let part = |factor: f64| shape.iter().map(move |v| factor * v);
    part(first).chain(part(second)).collect()
}

impl RepeatedSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        let arrangements = Span::from([self.arrangements.len() as f64; 2]);
        vec![
            (
                "arrangements (their number)",
                arrangements,
                Ends::Whole(1, MAX_COUNT),
            ),
            ("masses", self.masses, Ends::Whole(3, MAX_COUNT)),
            ("mass_kg", self.mass_kg, Ends::Positive),
            ("stiffness_n_per_m", self.stiffness_n_per_m, Ends::Positive),
            ("ground_ratio", self.ground_ratio, Ends::Positive),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let chosen = random.random_range(0..self.arrangements.len());
        match self.arrangements[chosen] {
            Arrangement::Ring => Ok(self.ring(random)),
            Arrangement::Twins => self.twins(random),
        }
    }

    /// `omega_k^2 = (k_g + 4 k sin^2(pi k / n)) / m` with the shapes `cos(2 pi k i / n)` and `sin(2
    /// pi k i / n)`.
    ///
    /// # Reference
    /// Thomas (1979), Dynamics of rotationally periodic structures, Int. J. Numer. Meth. Eng. 14.
    fn ring(&self, random: &mut ChaCha8Rng) -> Structure {
        let n = self.masses.whole(random);
        let mass_kg = self.mass_kg.log_uniform(random);
        let stiffness = self.stiffness_n_per_m.log_uniform(random);
        let ground = stiffness * self.ground_ratio.log_uniform(random);
        let mut modes = Vec::with_capacity(n);
        for k in 0..=n / 2 {
            let sine = (PI * k as f64 / n as f64).sin();
            let hz = ((ground + 4.0 * stiffness * sine * sine) / mass_kg).sqrt() / TAU;
            let ratio = self.damping_ratio.log_uniform(random);
            let double = k > 0 && 2 * k < n;
            let norm = if double { 2.0 } else { 1.0 } / (n as f64 * mass_kg);
            let angle = |i: usize| TAU * ((k * i) % n) as f64 / n as f64;
            let shape = |f: fn(f64) -> f64| (0..n).map(|i| norm.sqrt() * f(angle(i))).collect();
            let group = double.then_some(k as u32);
            let mode = |f| DrawnMode {
                group,
                ..elastic(hz, ratio, shape(f))
            };
            modes.push(mode(f64::cos));
            modes.extend(double.then(|| mode(f64::sin)));
        }
        Structure::real(modes)
    }

    fn twins(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let n = self.masses.whole(random);
        let row = Row::draw(n, self.mass_kg, self.stiffness_n_per_m, random);
        let chain = row.modes()?;
        let mut modes = Vec::with_capacity(2 * n);
        for (j, omega) in chain.omega_rad_s.iter().enumerate() {
            let ratio = self.damping_ratio.log_uniform(random);
            let shape = column(&chain, j);
            for (first, second) in [(1.0, 0.0), (0.0, 1.0)] {
                modes.push(DrawnMode {
                    group: Some(j as u32 + 1),
                    ..elastic(omega / TAU, ratio, side_by_side(&shape, first, second))
                });
            }
        }
        Ok(Structure::real(modes))
    }
}

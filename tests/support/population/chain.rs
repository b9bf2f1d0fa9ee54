//! Chains of masses and springs: plain, with a small appended mass, and with discrete dampers.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use modalign::linalg::{RealMatrix, real_matrix};
use modalign::modal::Pole;
use modalign::theory::{ModeOptions, SystemMatrices, TheoryModes, damped_modes, modes_of_matrices};

use super::error::PopulationError;
use super::span::{Ends, KeyedSpan, MAX_COUNT, Span};
use super::structure::{DrawnMode, Row, Shapes, Structure, column, coordinate, damped, elastic};

/// `kind = "chain"`: masses and springs in a row.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSpec {
    /// Number of masses.
    pub masses: Span,
    /// Each mass, kg, log-uniform.
    pub mass_kg: Span,
    /// Each spring, N/m, log-uniform.
    pub stiffness_n_per_m: Span,
    /// How many ends are held, 0 to 2: none, the first, both.
    pub held_ends: Span,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

/// `kind = "local"`: a chain clamped at both ends with a small mass on a spring.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalSpec {
    /// Number of masses, the small one not counted.
    pub masses: Span,
    /// Each mass, kg, log-uniform.
    pub mass_kg: Span,
    /// Each spring, N/m, log-uniform.
    pub stiffness_n_per_m: Span,
    /// The small mass over the one that carries it, log-uniform.
    pub appended_mass_ratio: Span,
    /// Frequency of the small oscillator on a fixed base over that of a mode of the bare chain,
    /// uniform.
    pub tuning: Span,
    /// Damping ratio of each root, log-uniform.
    pub damping_ratio: Span,
}

/// `kind = "dampers"`: a chain held at both ends with discrete dampers, which make its modes
/// complex.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DampersSpec {
    /// Number of masses.
    pub masses: Span,
    /// Each mass, kg, log-uniform.
    pub mass_kg: Span,
    /// Each spring, N/m, log-uniform.
    pub stiffness_n_per_m: Span,
    /// Modal damping ratio of each mode before the dampers are put in, log-uniform.
    pub damping_ratio: Span,
    /// Number of dampers, each from a mass to the ground or to its neighbour.
    pub dampers: Span,
    /// Coefficient of each over `2 sqrt(k m)` of the mass and spring where it is, log-uniform.
    pub damper_ratio: Span,
}

impl ChainSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        vec![
            ("masses", self.masses, Ends::Whole(2, MAX_COUNT)),
            ("mass_kg", self.mass_kg, Ends::Positive),
            ("stiffness_n_per_m", self.stiffness_n_per_m, Ends::Positive),
            ("held_ends", self.held_ends, Ends::Whole(0, 2)),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let n = self.masses.whole(random);
        let held = self.held_ends.whole(random);
        let mut row = Row::draw(n, self.mass_kg, self.stiffness_n_per_m, random);
        if held < 2 {
            row.stiffness_n_per_m[n] = 0.0;
        }
        if held < 1 {
            row.stiffness_n_per_m[0] = 0.0;
        }
        let modes = row.modes()?;
        let shape = |j| column(&modes, j);
        Ok(Structure::real(damped(
            &modes,
            self.damping_ratio,
            shape,
            random,
        )))
    }
}

impl LocalSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        vec![
            ("masses", self.masses, Ends::Whole(2, MAX_COUNT)),
            ("mass_kg", self.mass_kg, Ends::Positive),
            ("stiffness_n_per_m", self.stiffness_n_per_m, Ends::Positive),
            ("appended_mass_ratio", self.appended_mass_ratio, Ends::Share),
            ("tuning", self.tuning, Ends::Positive),
            ("damping_ratio", self.damping_ratio, Ends::Share),
        ]
    }

    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let n = self.masses.whole(random);
        let row = Row::draw(n, self.mass_kg, self.stiffness_n_per_m, random);
        let bare = row.modes()?;
        let carrier = random.random_range(0..n);
        let omega = self.tuning.uniform(random) * bare.omega_rad_s[random.random_range(0..n)];
        let mass_kg = row.mass_kg[carrier] * self.appended_mass_ratio.log_uniform(random);
        let matrices = with_appended(&row, carrier, mass_kg, mass_kg * omega * omega);
        let modes = modes_of_matrices(&matrices, &ModeOptions::default())?;
        let shape = |j| column(&modes, j);
        Ok(Structure::real(damped(
            &modes,
            self.damping_ratio,
            shape,
            random,
        )))
    }
}

/// A row with one more mass, tied to the carrier alone.
fn with_appended(row: &Row, carrier: usize, mass_kg: f64, stiffness: f64) -> SystemMatrices {
    let bare = row.matrices();
    let n = row.mass_kg.len();
    let tie = tie(n + 1, Some(carrier), Some(n));
    let inside = |i: usize, j: usize| i < n && j < n;
    SystemMatrices {
        mass: real_matrix(n + 1, n + 1, |i, j| match inside(i, j) {
            true => bare.mass[(i, j)],
            false if i == j => mass_kg,
            false => 0.0,
        }),
        stiffness: real_matrix(n + 1, n + 1, |i, j| {
            let bare_stiffness = if inside(i, j) {
                bare.stiffness[(i, j)]
            } else {
                0.0
            };
            bare_stiffness + stiffness * tie[(i, j)]
        }),
        coordinates: (0..=n).map(coordinate).collect(),
        springs: Vec::new(),
        damping: None,
    }
}

/// `b b^T` of the motion between two coordinates, `None` being the ground.
fn tie(size: usize, from: Option<usize>, to: Option<usize>) -> RealMatrix {
    let b = |i: usize| f64::from(u8::from(from == Some(i))) - f64::from(u8::from(to == Some(i)));
    real_matrix(size, size, |i, j| b(i) * b(j))
}

impl DampersSpec {
    pub(super) fn spans(&self) -> Vec<KeyedSpan> {
        vec![
            ("masses", self.masses, Ends::Whole(2, MAX_COUNT)),
            ("mass_kg", self.mass_kg, Ends::Positive),
            ("stiffness_n_per_m", self.stiffness_n_per_m, Ends::Positive),
            ("damping_ratio", self.damping_ratio, Ends::Share),
            ("dampers", self.dampers, Ends::Whole(1, MAX_COUNT)),
            ("damper_ratio", self.damper_ratio, Ends::Share),
        ]
    }

    pub(super) fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        let n = self.masses.whole(random);
        let row = Row::draw(n, self.mass_kg, self.stiffness_n_per_m, random);
        let undamped = row.modes()?;
        let ratios: Vec<f64> = (0..n)
            .map(|_| self.damping_ratio.log_uniform(random))
            .collect();
        let mut damping = modal_damping(&row, &undamped, &ratios);
        for _ in 0..self.dampers.whole(random) {
            let at = random.random_range(0..n);
            let to = (at + 1 < n && random.random_bool(0.5)).then_some(at + 1);
            let critical = 2.0 * (row.stiffness_n_per_m[at] * row.mass_kg[at]).sqrt();
            let coefficient = critical * self.damper_ratio.log_uniform(random);
            let tie = tie(n, Some(at), to);
            damping = real_matrix(n, n, |i, j| damping[(i, j)] + coefficient * tie[(i, j)]);
        }
        let modes = damped_modes(&SystemMatrices {
            damping: Some(damping),
            ..row.matrices()
        })?;
        let drawn = modes.poles_rad_s.iter().enumerate().map(|(j, &lambda)| {
            let pole = Pole { lambda };
            DrawnMode {
                shape: (0..n).map(|i| modes.vectors[(i, j)]).collect(),
                group: modes.groups[j],
                ..elastic(
                    pole.natural_frequency_hz(),
                    pole.damping_ratio(),
                    Vec::new(),
                )
            }
        });
        Ok(Structure {
            modes: drawn.collect(),
            shapes: Shapes::Complex,
            reference: None,
        })
    }
}

/// `C = sum 2 zeta omega (M phi)(M phi)^T`: these ratios, and shapes that stay real.
fn modal_damping(row: &Row, modes: &TheoryModes, ratios: &[f64]) -> RealMatrix {
    let n = row.mass_kg.len();
    let side = |i: usize, r: usize| row.mass_kg[i] * modes.vectors[(i, r)];
    real_matrix(n, n, |i, j| {
        let term = |r: usize| 2.0 * ratios[r] * modes.omega_rad_s[r] * side(i, r) * side(j, r);
        (0..n).map(term).sum()
    })
}

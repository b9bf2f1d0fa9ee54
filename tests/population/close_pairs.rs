//! Close pairs and repeated roots are separated by several references.

use modalign::axis::{Band, FrequencyAxis};
use modalign::correlate::principal_angles_deg;
use modalign::modal::Pole;
use modalign::quantity::FrfKind;
use modalign::study::{Detectability, FrfNoise, System, shape_at_responses};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::draws;
use super::identification::identified;
use super::systems::{Drawn, component, dofs, mode};

/// Draws of each cell, each with different shapes, damping and noise.
const DRAWS: u64 = 60;
const RESPONSES: usize = 10;
/// Separation in half-power bandwidths, angle between the participation vectors in degrees, and
/// minimum detection rate of both modes: the bound allows detection in every draw of every cell.
/// Shapes, damping and noise of a draw are the same in all cells.
const CELLS: [(f64, f64, f64); 9] = [
    (0.5, 90.0, 1.0),
    (0.5, 30.0, 1.0),
    (0.5, 10.0, 1.0),
    (0.2, 90.0, 0.99),
    (0.2, 30.0, 0.99),
    (0.2, 10.0, 0.99),
    (0.05, 90.0, 0.9),
    (0.05, 30.0, 0.9),
    (0.05, 10.0, 0.9),
];
/// Largest angle between the subspaces of the shapes of a pair, degrees: five times the 95 %
/// quantile in the last cell.
const MAX_PAIR_ANGLE_DEG: f64 = 0.5;
/// Natural frequency of the lower of the two, Hz.
const PAIR_HZ: f64 = 200.0;
/// Largest angle between the subspaces of the shapes of a repeated root, degrees.
const MAX_ANGLE_DEG: f64 = 2.0;

/// A pair, its distance in half-power widths, with single modes on both sides.
struct Setup {
    spacing_widths: f64,
    /// Of the participation vectors.
    angle_deg: f64,
    references: usize,
    snr_db: f64,
}

impl Setup {
    fn draw(&self, number: u64) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        random.set_stream(number);
        let zeta = 0.005 * 4f64.powf(random.random_range(0.0..1.0));
        let width = 2.0 * zeta * PAIR_HZ;
        let second_hz = PAIR_HZ + self.spacing_widths * width;
        let frequencies = [PAIR_HZ - 60.0, PAIR_HZ, second_hz, PAIR_HZ + 70.0];
        let mut shapes = frequencies.map(|_| -> Vec<Complex64> {
            let components = (0..RESPONSES).map(|_| component(&mut random, 0.0));
            components.collect()
        });
        let (first, second) = self.participation(&mut random);
        shapes[1][..self.references].copy_from_slice(&first);
        shapes[2][..self.references].copy_from_slice(&second);
        let modes = frequencies.iter().zip(shapes);
        let modes =
            modes.map(|(hz, shape)| mode(Pole::from_frequency(*hz, zeta), shape, self.references));
        let step_hz = width / random.random_range(5.0..10.0);
        let band = Band::new(PAIR_HZ - 100.0, PAIR_HZ + 110.0).unwrap();
        let system = System {
            modes: modes.collect(),
            axis: FrequencyAxis {
                start_hz: band.lo_hz,
                step_hz,
                len: (band.width_hz() / step_hz).ceil() as usize + 1,
            },
            band,
            kind: FrfKind::Accelerance,
            responses: dofs(RESPONSES),
            references: dofs(self.references),
            record_end_s: None,
        };
        Drawn {
            number,
            system,
            noise: FrfNoise {
                snr_db: self.snr_db,
                averages: None,
            },
        }
    }

    /// Two vectors of length 1 at the references, the angle apart, in a random plane.
    fn participation(&self, random: &mut ChaCha8Rng) -> (Vec<Complex64>, Vec<Complex64>) {
        let mut vector = || -> Vec<Complex64> {
            let components = (0..self.references).map(|_| component(random, 0.0));
            unit(components.collect())
        };
        let (first, other) = (vector(), vector());
        let along: Complex64 = first.iter().zip(&other).map(|(a, b)| a * b).sum();
        let across = other.iter().zip(&first).map(|(b, a)| b - along * a);
        let across = unit(across.collect());
        let (sin, cos) = self.angle_deg.to_radians().sin_cos();
        let turned = first.iter().zip(&across).map(|(a, b)| cos * a + sin * b);
        let second = turned.collect();
        (first, second)
    }
}

fn unit(vector: Vec<Complex64>) -> Vec<Complex64> {
    let length = vector.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    vector.into_iter().map(|v| v / length).collect()
}

/// The result of one draw.
struct Outcome {
    /// Whether the two poles are separable by the bound.
    allowed: bool,
    /// Distance of the two over the greater of their Cramér-Rao deviations.
    deviations: f64,
    /// Modes found within half a half-power width of the pair.
    found: usize,
    /// Modes found elsewhere.
    others: usize,
    /// Largest principal angle between the two shapes and those found, degrees; `None` unless there
    /// are two.
    angle_deg: Option<f64>,
    /// Whether those found are one repeated root.
    grouped: bool,
}

fn outcome(setup: &Setup, number: u64) -> Outcome {
    let drawn = setup.draw(number);
    let model = identified(&drawn, 1 + number);
    let system = &drawn.system;
    let half = 0.5 * system.modes[1].width_hz();
    let (lo, hi) = (system.modes[1].hz() - half, system.modes[2].hz() + half);
    let of_pair = |m: &&modalign::modal::Mode| m.frequency_hz > lo && m.frequency_hz < hi;
    let near: Vec<_> = model.modes.iter().filter(of_pair).collect();
    let shapes: Vec<_> = near
        .iter()
        .map(|mode| shape_at_responses(system, mode))
        .collect();
    let truth = [system.modes[1].shape.clone(), system.modes[2].shape.clone()];
    let angles = (near.len() == 2).then(|| principal_angles_deg(&shapes, &truth).unwrap());
    let judge = drawn.judge();
    let detectability = judge.detectability();
    let apart = |k: &Detectability| k.spacing_hz / k.bound.unwrap().frequency_hz;
    Outcome {
        allowed: detectability[1].observable && detectability[2].observable,
        deviations: detectability[1..3]
            .iter()
            .map(apart)
            .fold(f64::INFINITY, f64::min),
        found: near.len(),
        others: model.modes.len() - near.len(),
        angle_deg: angles.map(|angles| angles.into_iter().fold(0.0, f64::max)),
        grouped: near.iter().any(|mode| mode.group.is_some()),
    }
}

fn outcomes(setup: &Setup) -> Vec<Outcome> {
    (0..draws(DRAWS))
        .into_par_iter()
        .map(|n| outcome(setup, n))
        .collect()
}

/// Quantile of the angle over the outcomes, degrees.
fn angle_quantile(outcomes: &[Outcome], share: f64) -> f64 {
    let mut angles: Vec<f64> = outcomes.iter().filter_map(|o| o.angle_deg).collect();
    angles.sort_by(f64::total_cmp);
    let place = (share * angles.len() as f64) as usize;
    angles
        .get(place.min(angles.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

/// Prints a line on some outcomes, and counts those allowed and those of them found as two with no
/// mode too many elsewhere.
fn counts(label: &str, outcomes: &[Outcome]) -> (usize, usize) {
    let allowed: Vec<&Outcome> = outcomes.iter().filter(|o| o.allowed).collect();
    let two = allowed.iter().filter(|o| o.found == 2 && o.others == 2);
    let (two, count) = (two.count(), allowed.len());
    let apart = outcomes.iter().map(|o| o.deviations);
    let apart = apart.fold(f64::INFINITY, f64::min);
    let any = outcomes.iter().filter(|o| o.found == 2).count();
    println!(
        "{label}: {two} of {count} that the bound allows found as two, {any} of all {}, {} as one root; \
         {apart:.0} deviations apart at least; subspace {:.2} degrees (median), {:.2} (95 %), {:.2} (all)",
        outcomes.len(),
        outcomes
            .iter()
            .filter(|o| o.found == 2 && o.grouped)
            .count(),
        angle_quantile(outcomes, 0.5),
        angle_quantile(outcomes, 0.95),
        angle_quantile(outcomes, 1.0),
    );
    (two, count)
}

/// Minimum number of successes with 99.9 % probability at this probability of a success.
fn fewest(draws: usize, chance: f64) -> usize {
    let successes = Binomial::new(chance, draws as u64).unwrap();
    let in_band = |k: &usize| successes.cdf(*k as u64) > 0.001;
    (0..draws).find(in_band).unwrap_or(draws)
}

#[test]
fn two_references_tell_close_pairs_where_the_bound_does() {
    let judged = CELLS.map(|(spacing_widths, angle_deg, chance)| {
        let setup = Setup {
            spacing_widths,
            angle_deg,
            references: 2,
            snr_db: 60.0,
        };
        let outcomes = outcomes(&setup);
        let label = format!("{spacing_widths} widths, {angle_deg} degrees");
        let (two, allowed) = counts(&label, &outcomes);
        let worst = angle_quantile(&outcomes, 1.0);
        (label, two, allowed, fewest(allowed, chance), worst)
    });
    for (label, two, allowed, fewest, worst) in judged {
        assert_eq!(allowed as u64, draws(DRAWS), "{label}");
        assert!(two >= fewest, "{label}: {two} of {allowed}, not {fewest}");
        assert!(worst <= MAX_PAIR_ANGLE_DEG, "{label}: {worst}");
    }
}

#[test]
fn three_references_find_both_modes_of_a_repeated_root() {
    let setup = Setup {
        spacing_widths: 0.0,
        angle_deg: 60.0,
        references: 3,
        snr_db: 55.0,
    };
    let outcomes = outcomes(&setup);
    counts("repeated root", &outcomes);
    let angle = |o: &Outcome| o.angle_deg.unwrap_or(f64::INFINITY);
    let worst = outcomes.iter().map(angle).fold(0.0, f64::max);
    assert!(outcomes.iter().all(|o| o.others == 2));
    assert!(worst <= MAX_ANGLE_DEG, "{worst}");
}

//! Companion poles of one mode whose stiffness or damping depends on the amplitude.
//!
//! The free decay of a mode with a weak cubic stiffness is
//!
//! ```text
//! x = a e^(−σt) cos(ωt + κ (1 − e^(−2σt)))      κ = 3βa²/16σω
//! ```
//!
//! (averaging), whose expansion in κ has the poles `λ = −(2n + 1) σ ± iω`: at one frequency, of one
//! shape, with decay rates of 1, 3, 5, ... σ, and the residue of the second `−iκ` times that of the
//! first, in quadrature. Modes of proportional damping have no such poles: residues of one shape
//! are in phase or opposite. A tuned absorber without sensors may have a similar response.
//!
//! Damping that grows with the amplitude, `ζ(a) = ζ (1 + q a/a₀)`, or with its square, has the
//! decays
//!
//! ```text
//! x = a e^(−σt) cos ωt / (1 + q (1 − e^(−σt)))      x = a e^(−σt) cos ωt / √(1 + q (1 − e^(−2σt)))
//! ```
//!
//! with the poles `λ = −(n + 1) σ ± iω` and `−(2n + 1) σ ± iω`, all residues in phase. Only that
//! their frequency is that of the mode tells them from a close mode.
//!
//! Without its companion a mode of large amplitudes takes up part of it: 0.06 % of the frequency,
//! 13 standard deviations, where the stiffness rises by 0.4 % (test
//! `a_mode_of_cubic_stiffness_stays_one_mode`).
//!
//! Reference: Nayfeh and Mook (1979), Nonlinear Oscillations, sections 3.2 and 3.3 (decay by
//! averaging: Duffing oscillator, nonlinear damping).

use num_complex::Complex64;

use crate::modal::mac;

use crate::identify::data::model_pole::ModelPole;
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::fit::pole_covariance::add_noise_model_uncertainty;
use crate::identify::pole_model::PoleModel;
use crate::identify::pole_model::findings::DropReason;

/// Decay rate over that of the mode: 3, but for the next terms of the series, which the fit omits.
/// Half as wide: the companion of a mode of 0.3 % damping whose stiffness rises by 2 % is taken as
/// a mode. Twice as wide: a tuned absorber of 4 % damping is taken as a companion. Tests:
/// `a_mode_of_cubic_stiffness_stays_one_mode`, `a_tuned_absorber_is_a_mode`.
const DECAY_RATIO: std::ops::Range<f64> = 2.4..3.8;
/// The same of the second, 5. Half as wide: the second companion of a mode of 1.2 % damping whose
/// stiffness rises by 4 % is taken as a mode. Twice as wide: no difference in 126 simulations.
/// Test: `a_mode_of_cubic_stiffness_stays_one_mode`.
const SECOND_DECAY_RATIO: std::ops::Range<f64> = 3.8..6.5;
/// Distance in frequency, in decay rates of the companion. Half: companions that the omitted terms
/// move are taken as modes. Twice: no difference in 126 simulations, as the phase rejects the mode
/// of a tuned absorber (0.3 to 0.7). Tests: `a_mode_of_cubic_stiffness_stays_one_mode`,
/// `close_modes_of_a_linear_structure_are_no_companions`.
const MAX_DISTANCE: f64 = 0.5;
/// Decay rate over that of the mode, of a companion in phase: 2 of damping that grows with the
/// amplitude, 3 with its square, up to 4 for the omitted terms. Smaller or larger at its ends:
/// companions are modes (`a_mode_whose_damping_grows_stays_one_mode`).
const IN_PHASE_DECAY_RATIO: std::ops::Range<f64> = 1.7..4.3;
/// Distance in frequency of a companion in phase, in its decay rates. Smaller: companions of real
/// tests, which are accurate to 0.1, are modes. Larger: close modes of a linear structure are one
/// (`close_modes_of_a_linear_structure_are_no_companions`).
const MAX_DISTANCE_IN_PHASE: f64 = 0.12;
/// Largest residue of such a companion over that of its mode, of damping that grows with the
/// amplitude (2 times the decay rate) and with its square (3 times), by the averages above `q/(1 +
/// q)` and `q/2(1 + q)`. Larger: a weak mode hides a strong close one. Smaller: companions of
/// damping that doubles over the decay are modes. Test:
/// `companions_of_damping_are_at_the_frequency_of_their_mode`.
const MAX_RESIDUE_IN_PHASE: [f64; 2] = [0.75, 0.5];
/// Minimum MAC of such a companion and its mode: their phase does not tell them from close modes.
/// Smaller: close modes of similar shapes at few sensors are one. Larger: noise of the residues
/// separates a companion from its mode.
const MIN_MAC_IN_PHASE: f64 = 0.98;
/// Part of a companion's residues in phase with its mode, over that in quadrature: 20 degrees. A
/// tuned absorber has 0.4 to 1. Half: companions that the omitted terms turn are taken as modes.
/// Twice: no difference in 126 simulations. Tests: `a_mode_of_cubic_stiffness_stays_one_mode`,
/// `close_modes_of_a_linear_structure_are_no_companions`.
const MAX_IN_PHASE: f64 = 0.36;
/// Modal assurance criterion of the two shapes, minimum. A second mode of a smooth structure has
/// less. Smaller: a close mode of another shape is taken as a companion. Larger: noise of the
/// residues separates a companion from its mode. Test:
/// `close_modes_of_a_linear_structure_are_no_companions`.
const MIN_MAC: f64 = 0.9;
/// Misfit of a mode above which a companion is tried: what its standard deviations begin to count.
/// It saves trials alone: half and twice make no difference in 126 simulations.
const MIN_MISFIT: f64 = 2.0;

impl PoleModel {
    /// Tries a companion pole at each mode whose misfit exceeds [`MIN_MISFIT`], or near which such
    /// a pole was rejected. Companions that remain significant are kept, and so are all modes.
    pub fn add_companions(&mut self) {
        self.mark_companions();
        let modes: Vec<&ModelPole> = (self.poles.iter().zip(self.pole_metrics()))
            .filter(|(pole, metrics)| self.may_have_companion(pole, metrics.reduced_chi_square))
            .map(|(pole, _)| pole)
            .collect();
        if modes.is_empty() {
            return;
        }
        let tried: Vec<ModelPole> = modes.iter().map(|mode| trial(mode)).collect();
        let before = self.snapshot();
        self.poles.extend(tried);
        mark_unconverged(&mut self.poles);
        self.refine_and_prune(Convergence::ResidualTest);
        self.mark_companions();
        // A pole that was not in the fit before and is no companion is a failed trial.
        let is_mode = |pole: &ModelPole| {
            let distance = |mode: &ModelPole| (mode.lambda - pole.lambda).norm() / mode.decay();
            before.poles.iter().any(|mode| distance(mode) < 1.0)
        };
        let all = self.poles.len();
        self.poles.retain(|pole| pole.is_companion || is_mode(pole));
        if self.poles.len() < all {
            mark_unconverged(&mut self.poles);
            self.refine_and_prune(Convergence::ResidualTest);
            self.mark_companions();
        }
        let modes = |poles: &[ModelPole]| poles.iter().filter(|pole| !pole.is_companion).count();
        let has_companions = self.poles.iter().any(|pole| pole.is_companion);
        if !has_companions || modes(&self.poles) != modes(&before.poles) {
            self.restore(before);
            return;
        }
        let is_fitted = |lambda: Complex64| {
            let mut companions = self.poles.iter().filter(|pole| pole.is_companion);
            companions.any(|pole| (pole.lambda - lambda).norm() < pole.decay())
        };
        let rejected: Vec<_> = self
            .dropped
            .iter()
            .filter(|dropped| !is_fitted(dropped.lambda))
            .copied()
            .collect();
        self.dropped = rejected;
        self.refine_and_prune(Convergence::Fine);
        self.add_out_of_band_uncertainty();
        add_noise_model_uncertainty(&self.data, &mut self.poles);
    }

    fn mark_companions(&mut self) {
        let pairs = companions(&self.poles);
        for (index, pole) in self.poles.iter_mut().enumerate() {
            pole.is_companion = pairs.iter().any(|pair| pair.0 == index);
        }
    }

    fn may_have_companion(&self, pole: &ModelPole, misfit: f64) -> bool {
        let has_one = self.poles.iter().any(|other| is_companion(other, pole));
        let rejected = self.dropped.iter().any(|dropped| {
            let [lambda, of] = [dropped.lambda, pole.lambda];
            matches!(dropped.reason, DropReason::Rejected(_))
                && (is_first(lambda, of) || is_second(lambda, of))
        });
        let is_single = pole.multiplicity() == 1 && !pole.is_companion;
        is_single && !has_one && (misfit > MIN_MISFIT || rejected)
    }
}

/// Initial companion pole of a mode.
fn trial(mode: &ModelPole) -> ModelPole {
    let lambda = Complex64::new(3.0 * mode.lambda.re, mode.lambda.im);
    ModelPole::single(lambda, &mode.parts[0], mode.residues.len())
}

/// Whether a pole is a companion of another, the first or the second.
fn is_companion(pole: &ModelPole, of: &ModelPole) -> bool {
    is_first_companion(pole, of) || has_shape_of(pole, of) && is_second(pole.lambda, of.lambda)
}

fn is_first_companion(pole: &ModelPole, of: &ModelPole) -> bool {
    let of_stiffness = is_first(pole.lambda, of.lambda) && in_quadrature(pole, of);
    has_shape_of(pole, of) && (of_stiffness || is_companion_of_damping(pole, of))
}

fn is_companion_of_damping(pole: &ModelPole, of: &ModelPole) -> bool {
    let ratio = pole.decay() / of.decay();
    let largest = MAX_RESIDUE_IN_PHASE[usize::from(ratio > 2.5)];
    let has_shape = mac(&pole.residues, &of.residues) > Some(MIN_MAC_IN_PHASE);
    let is_weaker = residue_norm(pole) < largest * residue_norm(of);
    has_shape && is_weaker && is_at_frequency(pole.lambda, of.lambda)
}

fn residue_norm(pole: &ModelPole) -> f64 {
    let squares = pole.residues.iter().map(Complex64::norm_sqr);
    squares.sum::<f64>().sqrt()
}

/// Whether both are single and of one shape.
fn has_shape_of(pole: &ModelPole, of: &ModelPole) -> bool {
    let single = pole.multiplicity() == 1 && of.multiplicity() == 1;
    single && mac(&pole.residues, &of.residues) > Some(MIN_MAC)
}

/// Whether a pole lies where the first companion of stiffness would.
fn is_first(lambda: Complex64, of: Complex64) -> bool {
    DECAY_RATIO.contains(&(lambda.re / of.re)) && distance(lambda, of) < MAX_DISTANCE
}

fn is_second(lambda: Complex64, of: Complex64) -> bool {
    SECOND_DECAY_RATIO.contains(&(lambda.re / of.re)) && distance(lambda, of) < MAX_DISTANCE
}

/// Whether a pole lies where the companion of damping would.
fn is_at_frequency(lambda: Complex64, of: Complex64) -> bool {
    let is_near = distance(lambda, of) < MAX_DISTANCE_IN_PHASE;
    IN_PHASE_DECAY_RATIO.contains(&(lambda.re / of.re)) && is_near
}

/// Difference of frequencies in decay rates of the first pole.
fn distance(lambda: Complex64, of: Complex64) -> f64 {
    ((lambda.im - of.im) / lambda.re).abs()
}

/// Indices of the companions among some poles, each with that of its mode. The second companion
/// counts only together with the first.
fn companions(poles: &[ModelPole]) -> Vec<(usize, usize)> {
    let pairs = (0..poles.len()).flat_map(|j| (0..poles.len()).map(move |i| (j, i)));
    let all: Vec<(usize, usize)> = pairs
        .filter(|(j, i)| j != i && is_companion(&poles[*j], &poles[*i]))
        .collect();
    let is_first = |(j, i): &(usize, usize)| is_first_companion(&poles[*j], &poles[*i]);
    let has_first =
        |pair: &&(usize, usize)| all.iter().any(|other| other.1 == pair.1 && is_first(other));
    let counted: Vec<(usize, usize)> = all.iter().filter(has_first).copied().collect();
    // A companion has none.
    let is_of_mode = |pair: &&(usize, usize)| counted.iter().all(|other| other.0 != pair.1);
    counted.iter().filter(is_of_mode).copied().collect()
}

/// Whether residues of one shape differ by a quarter turn rather than by none or a half.
fn in_quadrature(pole: &ModelPole, of: &ModelPole) -> bool {
    let terms = pole.residues.iter().zip(&of.residues);
    let along: Complex64 = terms.map(|(a, b)| a * b.conj()).sum();
    along.re.abs() < MAX_IN_PHASE * along.im.abs()
}

/// Pole of each mode that has companions, with the largest residue of one over that of the mode.
pub(in crate::identify) fn strongest_companions(poles: &[ModelPole]) -> Vec<(Complex64, f64)> {
    let pairs = companions(poles);
    let fitted = pairs.iter().filter(|pair| poles[pair.0].is_companion);
    let strongest = |(index, mode): (usize, &ModelPole)| {
        let of_mode = fitted.clone().filter(|pair| pair.1 == index);
        let residues = of_mode.map(|pair| residue_norm(&poles[pair.0]));
        Some((mode.lambda, residues.reduce(f64::max)? / residue_norm(mode)))
    };
    poles.iter().enumerate().filter_map(strongest).collect()
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::finding::Code;
    use crate::fourier::ForwardPlan;
    use crate::frf::{FrfSet, Function, FunctionData};
    use crate::identify::estimator::IdentifyOptions;
    use crate::identify::identify;
    use crate::identify::ml::amplitude_dependence::*;
    use crate::identify::synthetic::white_noise;
    use crate::modal::{ModalModel, Pole};
    use crate::quantity::FrfKind;

    const HZ: f64 = 432.3;
    /// Damping ratio of small amplitudes, but where a test says another.
    const DAMPING: f64 = 0.006;
    const RATE_HZ: f64 = 2048.0;
    const RECORD: usize = 4096;
    /// Steps of the integration for each sample: 76 for each period, whose error is 1e-6 of the
    /// amplitude.
    const STEPS: usize = 16;

    /// A force on a unit mass by its displacement and velocity, in addition to those of a linear
    /// mode.
    type Force<'a> = &'a dyn Fn(f64, f64) -> f64;

    fn omega() -> f64 {
        std::f64::consts::TAU * HZ
    }

    /// Displacement of a mode of unit mass after a unit impulse.
    fn decay(nonlinear: Force<'_>, damping: f64) -> Vec<f64> {
        let omega = omega();
        let step = (RATE_HZ * STEPS as f64).recip();
        let linear = |x: f64, v: f64| omega * omega * x + 2.0 * damping * omega * v;
        let slope = |(x, v): (f64, f64)| (v, -linear(x, v) - nonlinear(x, v));
        let along = |(x, v): (f64, f64), (a, b): (f64, f64), h: f64| (x + h * a, v + h * b);
        let mut state = (0.0, 1.0);
        let mut samples = Vec::with_capacity(RECORD);
        for n in 0..RECORD * STEPS {
            if n % STEPS == 0 {
                samples.push(state.0);
            }
            let first = slope(state);
            let second = slope(along(state, first, 0.5 * step));
            let third = slope(along(state, second, 0.5 * step));
            let last = slope(along(state, third, step));
            let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
            let slope = (
                mean(first.0, second.0, third.0, last.0),
                mean(first.1, second.1, third.1, last.1),
            );
            state = along(state, slope, step);
        }
        samples
    }

    /// Stiffness `ω² (1 + cubic x²/x₀²)`, x₀ the linear amplitude.
    fn hardening(cubic: f64) -> impl Fn(f64, f64) -> f64 {
        move |x: f64, _| omega().powi(2) * x * cubic * (x * omega()).powi(2)
    }

    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: RATE_HZ / RECORD as f64,
        len: 2 * RECORD / 5,
    };

    /// Modes of FRFs at a number of points of a structure with one mode.
    fn identified(nonlinear: Force<'_>, damping: f64, points: usize) -> ModalModel {
        let spectrum = ForwardPlan::new(RECORD).transform(&decay(nonlinear, damping));
        let receptance = spectrum[..AXIS.len].iter().map(|x| x / RATE_HZ);
        modes_of(&receptance.collect::<Vec<_>>(), points)
    }

    /// Modes of FRFs at a number of points, in the ratio of a shape, with noise of 1e-3 of their
    /// root mean square.
    fn modes_of(receptance: &[Complex64], points: usize) -> ModalModel {
        let axis = AXIS;
        let power = receptance.iter().map(Complex64::norm_sqr).sum::<f64>() / axis.len as f64;
        let mut set = FrfSet::new(axis);
        for point in 0..points {
            let factor = (1.0 + point as f64).cos();
            let noise = white_noise(axis.len, 1e-6 * power, 7 + point as u64);
            let values = receptance.iter().zip(noise);
            let function = Function {
                response: format!("{}:+Z", point + 1).parse().expect("a DOF"),
                reference: "1:+Z".parse().expect("a DOF"),
                kind: FrfKind::Receptance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values: values.map(|(h, z)| h * factor + z).collect(),
                ..FunctionData::default()
            };
            set.push(function, data)
                .expect("a function on the axis of the set");
        }
        identify(&set, &IdentifyOptions::default()).expect("modes of receptances")
    }

    /// Errors of frequency and damping, as parts, of the only mode near the true one, which is
    /// reported as amplitude-dependent.
    fn errors_of_one_mode(model: &ModalModel, damping: f64) -> [f64; 2] {
        let is_near = |hz: f64| (hz / HZ - 1.0).abs() < 0.05;
        let modes: Vec<_> = (model.modes.iter())
            .filter(|mode| is_near(mode.frequency_hz))
            .collect();
        let all: Vec<f64> = modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(modes.len(), 1, "{all:?}");
        let has = |code: Code| model.findings.iter().any(|finding| finding.code == code);
        assert!(has(Code::AmplitudeDependent));
        assert!(!has(Code::LeakageSplit) && !has(Code::RootMinor) && !has(Code::RootPhase));
        let found = modes[0].damping_ratio.expect("a damping ratio");
        [modes[0].frequency_hz / HZ, found / damping].map(|ratio| (ratio - 1.0).abs())
    }

    #[test]
    fn a_mode_of_cubic_stiffness_stays_one_mode() {
        for (cubic, damping, points) in [
            (0.004, 0.006, 1),
            (0.004, 0.006, 5),
            (0.02, 0.006, 5),
            (0.02, 0.003, 5),
            (0.04, 0.012, 1),
        ] {
            let model = identified(&hardening(cubic), damping, points);
            let [of_frequency, of_damping] = errors_of_one_mode(&model, damping);
            // The frequency of large amplitudes is higher by 3/8 of `cubic`.
            assert!(of_frequency < 0.05 * 0.375 * cubic);
            // What the poles beyond the second, (κ²/2 of the response, κ = 3 cubic/16ζ) do to
            // damping.
            let kappa = 3.0 * cubic / (16.0 * damping);
            assert!(of_damping < 0.005 + 0.25 * kappa * kappa, "{of_damping}");
        }
    }

    #[test]
    fn a_mode_whose_damping_grows_stays_one_mode() {
        // Damping larger by 10 and 30 % at the amplitude of the hit: with it, and with its square.
        for (part, points) in [(0.1, 1), (0.1, 5), (0.3, 1), (0.3, 5)] {
            let viscous = part * 2.0 * DAMPING * omega();
            let with_amplitude =
                move |_: f64, v: f64| viscous * 3.0 * std::f64::consts::PI / 8.0 * v.abs() * v;
            let with_square = move |_: f64, v: f64| viscous * 4.0 / 3.0 * v.powi(3);
            let both: [Force<'_>; 2] = [&with_amplitude, &with_square];
            for nonlinear in both {
                let model = identified(nonlinear, DAMPING, points);
                let [of_frequency, of_damping] = errors_of_one_mode(&model, DAMPING);
                assert!(of_frequency < 2e-5, "{part} {points}: {of_frequency}");
                assert!(of_damping < 0.02, "{part} {points}: {of_damping}");
            }
        }
    }

    #[test]
    fn a_linear_mode_has_no_companion() {
        let model = identified(&|_, _| 0.0, DAMPING, 5);
        assert_eq!(model.modes.len(), 1);
        let mut codes = model.findings.iter().map(|finding| finding.code);
        assert!(codes.all(|code| code != Code::AmplitudeDependent));
    }

    #[test]
    fn a_tuned_absorber_is_a_mode() {
        // Mass ratio 0.0003, 4 % damping: a pole of 4.5 times the decay rate of the mode.
        let (mass_ratio, damping) = (3e-4, 0.04);
        let natural = omega();
        let tuned = natural / (1.0 + mass_ratio);
        let receptance = |k: usize| {
            let omega = AXIS.rad_s(k);
            let spring = mass_ratio * Complex64::new(tuned * tuned, 2.0 * damping * tuned * omega);
            let main_system =
                Complex64::new(natural * natural - omega * omega, 0.012 * natural * omega);
            let absorber = spring - mass_ratio * omega * omega;
            (main_system + spring - spring * spring / absorber).inv()
        };
        let receptance: Vec<Complex64> = (0..AXIS.len).map(receptance).collect();
        let model = modes_of(&receptance, 5);
        assert_eq!(model.modes.len(), 2);
        let mut codes = model.findings.iter().map(|finding| finding.code);
        assert!(codes.all(|code| code != Code::AmplitudeDependent));
    }

    /// A pole of one shape, its residues rotated from those of a mode in phase.
    fn pole(hz: f64, damping: f64, turn: f64) -> ModelPole {
        let lambda = Pole::from_frequency(hz, damping).lambda;
        let mut pole = ModelPole::single(lambda, &[Complex64::ONE], 3);
        let phase = Complex64::from_polar(1.0, turn - std::f64::consts::FRAC_PI_2);
        pole.residues = [1.0, -0.5, 2.0].map(|a| a * phase).to_vec();
        pole
    }

    /// Number of companions of a mode of 1 % damping among other poles.
    fn count(others: &[ModelPole]) -> usize {
        let mode = pole(100.0, 0.01, 0.0);
        companions(&[&[mode], others].concat()).len()
    }

    #[test]
    fn close_modes_of_a_linear_structure_are_no_companions() {
        // 0.2 decay rates away, beyond the distance of companions in phase.
        let hz = 100.6;
        let quarter = std::f64::consts::FRAC_PI_2;
        let is_one = |other: ModelPole| count(&[other]) == 1;
        assert!(is_one(pole(hz, 0.03, quarter)));
        // Part in phase over that in quadrature.
        assert!(is_one(pole(hz, 0.03, 0.25f64.atan() + quarter)));
        assert!(!is_one(pole(hz, 0.03, 0.5f64.atan() + quarter)));
        assert!(!is_one(pole(hz, 0.03, 0.3)));
        // Ratio of the decay rates.
        for (damping, expected) in [
            (0.013, false),
            (0.022, false),
            (0.026, true),
            (0.036, true),
            (0.044, false),
        ] {
            assert_eq!(is_one(pole(hz, damping, quarter)), expected, "{damping}");
        }
        // Distance of 0.37, 0.7 and 1 decay rates.
        for (hz, expected) in [(101.1, true), (102.1, false), (103.0, false)] {
            assert_eq!(is_one(pole(hz, 0.03, quarter)), expected, "{hz}");
        }
        // Shapes of MAC 0.94, 0.89 and 0.27.
        for (factor, expected) in [(0.6, true), (0.5, false), (-1.0, false)] {
            let mut other = pole(hz, 0.03, quarter);
            other.residues[2] *= factor;
            assert_eq!(is_one(other), expected, "{factor}");
        }
        // The second companion needs the first, and no quadrature.
        for (damping, expected) in [(0.034, 1), (0.042, 2), (0.06, 2), (0.07, 1)] {
            let all = [pole(hz, 0.03, quarter), pole(hz, damping, 0.0)];
            assert_eq!(count(&all), expected, "{damping}");
        }
        assert!(!is_one(pole(hz, 0.05, 0.0)));
    }

    #[test]
    fn companions_of_damping_are_at_the_frequency_of_their_mode() {
        let is_one_of = |hz: f64, damping: f64, residue: f64, factor: f64| {
            let mut other = pole(hz, damping, 0.0);
            other.residues.iter_mut().for_each(|a| *a *= residue);
            other.residues[2] *= factor;
            count(&[other]) == 1
        };
        let is_one = |hz: f64, damping: f64| is_one_of(hz, damping, 0.3, 1.0);
        // Residues over those of the mode, and shapes of MAC 0.99 and 0.94.
        assert!(is_one_of(100.0, 0.02, 0.7, 1.0) && !is_one_of(100.0, 0.02, 0.8, 1.0));
        assert!(is_one_of(100.0, 0.03, 0.45, 1.0) && !is_one_of(100.0, 0.03, 0.55, 1.0));
        assert!(is_one_of(100.0, 0.02, 0.3, 0.8) && !is_one_of(100.0, 0.02, 0.3, 0.6));
        // Distances of 0.1 and 0.15 decay rates.
        assert!(is_one(100.2, 0.02) && !is_one(100.3, 0.02));
        for (damping, expected) in [
            (0.013, false),
            (0.016, false),
            (0.018, true),
            (0.04, true),
            (0.046, false),
        ] {
            assert_eq!(is_one(100.0, damping), expected, "{damping}");
        }
    }
}

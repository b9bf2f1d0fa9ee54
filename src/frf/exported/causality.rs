//! A structure does not move before it is hit: the impulse response of an FRF is 0 at negative
//! times. With conjugate values, of the convention e^{-iωt}, it is 0 at positive ones.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::fourier::ComplexPlan;
use crate::frf::FrfSet;
use crate::quantity::FrfKind;

/// Largest fraction of the energy at positive times of a conjugate FRF, and its complement for one
/// that is not. Larger: noise has a half of its energy at positive times, and a function of noise
/// alone is taken for either. Smaller: FRFs with one line per half-power bandwidth and less, whose
/// decay wraps around, are not seen (`conjugate_functions_are_turned_at_every_resolution`).
const MAX_FRACTION_OF_CONJUGATE: f64 = 0.25;
/// Part of the band at each end over which values fade. Smaller: a jump at an end spreads over all
/// times. Larger: modes near the ends do not count.
const TAPER: f64 = 0.1;
/// Times around 0 that tell nothing: a jump at time 0 spreads over the main lobe of the taper.
const LOBE: usize = 3;
/// Fewest lines of which a time signal is made. Fewer: noise has most of its energy at either sign
/// of time by chance.
const MIN_LINES: usize = 64;

/// The set with conjugate functions turned, with a finding.
///
/// Where no function is clearly causal and half of them are clearly conjugate, all are turned.
pub(super) fn causal(mut set: FrfSet) -> FrfSet {
    let fractions: Vec<Option<f64>> = (0..set.len())
        .map(|i| fraction_at_positive_times(&set, i))
        .collect();
    let is_conjugate = |i: &usize| fractions[*i] < Some(MAX_FRACTION_OF_CONJUGATE);
    let is_causal = |i: &usize| fractions[*i] > Some(1.0 - MAX_FRACTION_OF_CONJUGATE);
    let clear: Vec<usize> = (0..set.len())
        .filter(|i| fractions[*i].is_some() && is_conjugate(i))
        .collect();
    if clear.is_empty() {
        return set;
    }
    let turned = match (0..set.len()).any(|i| is_causal(&i)) {
        true => clear,
        false if 2 * clear.len() >= set.len() => (0..set.len()).collect(),
        false => return set,
    };
    for &i in &turned {
        set.values_mut(i)
            .iter_mut()
            .for_each(|value| *value = value.conj());
    }
    let location = match turned.as_slice() {
        [only] if set.len() > 1 => {
            let function = &set.functions()[*only];
            Location::Function {
                response: Some(function.response.clone()),
                reference: Some(function.reference.clone()),
            }
        }
        _ => Location::Whole,
    };
    let finding = Finding::new(Severity::Warning, Code::ConjugateTurned, location);
    let finding = finding.value(turned.len() as f64, "functions");
    set.findings.push(finding.limit(set.len() as f64));
    set
}

/// The fraction of the energy of the impulse response at positive times; `None` where there is
/// none.
///
/// Values are tapered at both ends of the band, receptances weighted with the frequency, or those
/// of a free structure at its low end outweigh all others.
fn fraction_at_positive_times(set: &FrfSet, i: usize) -> Option<f64> {
    let axis = set.axis();
    let first = (0..axis.len).find(|k| axis.hz(*k) > 0.0)?;
    let lines = axis.len - first;
    if lines < MIN_LINES {
        return None;
    }
    let is_receptance = set.functions()[i].kind == FrfKind::Receptance;
    let weight = |hz: f64| if is_receptance { hz } else { 1.0 };
    let window = |k: usize| {
        let from_edge = (k.min(lines - 1 - k) as f64 + 0.5) / (TAPER * lines as f64);
        (std::f64::consts::FRAC_PI_2 * from_edge.min(1.0))
            .sin()
            .powi(2)
    };
    let weighted =
        (0..lines).map(|k| set.values(i)[first + k] * weight(axis.hz(first + k)) * window(k));
    let mut signal: Vec<Complex64> = weighted.collect();
    let plan = ComplexPlan::inverse(lines);
    plan.run(&mut signal, &mut plan.scratch());
    let half = lines / 2;
    let energy = |times: std::ops::Range<usize>| -> f64 {
        signal[times].iter().map(Complex64::norm_sqr).sum()
    };
    let positive = energy(LOBE..half);
    let negative = energy(lines - half..lines - LOBE);
    let fraction = positive / (positive + negative);
    fraction.is_finite().then_some(fraction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::dof::Dof;
    use crate::frf::{Residues, synthesise};
    use crate::modal::Pole;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// FRFs of several modes with this number of lines per half-power bandwidth, and noise.
    fn set(seed: u64, kind: FrfKind, lines_per_width: f64, noise: f64) -> FrfSet {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let dof = |point: usize| -> Dof { format!("{point}:+Z").parse().unwrap() };
        let pairs: Vec<(Dof, Dof)> = (1..=4).map(|point| (dof(point), dof(1))).collect();
        let modes: Vec<(Pole, Residues)> = (0..4)
            .map(|_| {
                let pole = Pole::from_frequency(random.random_range(30.0..180.0), 0.01);
                let residue = |pair: &(Dof, Dof)| {
                    let amplitude = random.random_range(-1.0..1.0);
                    (pair.clone(), Complex64::new(0.0, amplitude))
                };
                (pole, pairs.iter().map(residue).collect())
            })
            .collect();
        let terms: Vec<(Pole, &Residues)> = modes.iter().map(|(p, r)| (*p, r)).collect();
        let step_hz = 2.0 * 0.01 * 100.0 / lines_per_width;
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz,
            len: (200.0 / step_hz) as usize,
        };
        let mut set = synthesise(&terms, axis, &pairs, kind, 0.0).unwrap();
        for i in 0..set.len() {
            let energy: f64 = set.values(i).iter().map(Complex64::norm_sqr).sum();
            let size = noise * (energy / axis.len as f64).sqrt();
            for value in set.values_mut(i) {
                let mut part = || -> f64 { size * random.sample::<f64, _>(StandardNormal) };
                *value += Complex64::new(part(), part());
            }
        }
        set
    }

    #[test]
    fn conjugate_functions_are_turned_at_every_resolution() {
        for seed in 0..40 {
            for (kind, lines_per_width, noise) in [
                (FrfKind::Accelerance, 3.0, 0.0),
                (FrfKind::Accelerance, 5.0, 0.3),
                (FrfKind::Mobility, 3.0, 0.1),
                (FrfKind::Receptance, 20.0, 0.1),
            ] {
                let exact = set(seed, kind, lines_per_width, noise);
                assert_eq!(causal(exact.clone()), exact, "{seed} {kind}");
                let mut conjugate = exact.clone();
                for i in 0..conjugate.len() {
                    let values = conjugate.values_mut(i).iter_mut();
                    values.for_each(|value| *value = value.conj());
                }
                let turned = causal(conjugate);
                let codes: Vec<Code> = turned.findings.iter().map(|f| f.code).collect();
                assert_eq!(
                    codes,
                    [Code::ConjugateTurned],
                    "{seed} {kind} {lines_per_width}"
                );
                assert_eq!(turned.values(3), exact.values(3), "{seed} {kind}");
            }
        }
    }

    #[test]
    fn one_conjugate_function_among_others_is_turned_alone() {
        for seed in 0..40 {
            let exact = set(seed, FrfKind::Accelerance, 4.0, 0.05);
            let mut one = exact.clone();
            one.values_mut(2)
                .iter_mut()
                .for_each(|value| *value = value.conj());
            let turned = causal(one);
            assert_eq!(turned.findings[0].value, Some(1.0));
            assert!(
                (0..4).all(|i| turned.values(i) == exact.values(i)),
                "{seed}"
            );
        }
    }

    #[test]
    fn noise_alone_is_not_turned() {
        for seed in 0..200 {
            let noise = set(seed, FrfKind::Accelerance, 3.0, 30.0);
            assert_eq!(causal(noise.clone()), noise, "{seed}");
        }
    }
}

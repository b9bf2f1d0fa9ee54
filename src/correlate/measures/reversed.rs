//! Sensors that point the other way than the theory's, found from the shapes of the pairs.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::modal::{ModalModel, ModeShape};

use super::super::pairing::Shapes;
use super::super::{CorrelateError, PairOptions, pair};
use super::coordinate::{CoordinateMac, coordinates};
use super::pair_shapes::PairShapes;

/// Gate on MAC of the pairs that are looked at: reversed sensors cost MAC, and a pair that is lost says nothing.
const PAIRED: f64 = 0.2;

/// Pairs from which on the direction alone says that a sensor is reversed, whatever its share of the shapes.
const ENOUGH_PAIRS: usize = 3;

/// Over so many pairs a reversed sensor's direction ([`super::CoordinateMac::direction`]) is at most this.
const AGAINST: f64 = -0.8;

/// And turning it gains at least this part of what it would gain were it the theory's sensor reversed.
const PART_OF_GAIN: f64 = 0.5;

/// Share of the squared length, as a part of the mean share of a sensor, below which noise has a say in signs.
const LEAST_SHARE: f64 = 0.1;

/// Over fewer pairs its direction is at most this.
const AGAINST_IN_FEW: f64 = -0.5;

/// And turning it raises the mean MAC by at least this.
const GAIN: f64 = 0.02;

/// So many good sensors or more that would disagree in the same pairs by chance, in the mean, and the sensor may be one of them. Two
/// pairs in which no other sensor disagrees, (1/n)² n = 1/n, are enough from eleven sensors on.
const BY_CHANCE: f64 = 0.1;

/// A sensor that reads against the theory's direction.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ReversedSensor {
    /// As the test names it.
    pub dof: Dof,
    /// Mean MAC of the pairs with the sensors turned that were found before it.
    pub mac_before: f64,
    /// Mean MAC with this one turned as well.
    pub mac_after: f64,
    /// Over the pairs, near -1.
    pub direction: f64,
}

/// The sensors of a test that read against the theory, the worst first.
///
/// With the modes paired at a MAC of 0.2 or more, the sensor whose turning raises the mean MAC most is taken again and again,
/// of those that disagree with the theory. Over three pairs or more these have a direction of at most -0.8, a tenth of a
/// sensor's mean share of the squared length or more, and gain half of what the reversed sensor of a right model would: with
/// its share `w` of a pair and the product `s` of the unit shapes as they stand, `(s + 2w)² − s²`, 4 w where all else agrees.
/// Over two pairs, which agree by chance more often, the direction is at most -0.5 and the gain 0.02 or more.
/// A poor pair says little: with the parts `f` of the other sensors that disagree in each pair, `Π f` over the pairs in which a sensor
/// disagrees is how often a good one does, and times the number of sensors that is to be below 0.1:
/// over two pairs in which no other sensor disagrees there must be eleven sensors at least. Signs of sensors with less than a tenth of
/// the mean share of a pair are noise and count as no disagreement.
/// Never half of the sensors and more are found: which half is then reversed nobody can say.
///
/// # Errors
/// As [`pair`].
pub fn reversed_sensors(
    test: &ModalModel,
    theory: &ModalModel,
    options: &PairOptions,
) -> Result<Vec<ReversedSensor>, CorrelateError> {
    let options = PairOptions {
        min_mac: options.min_mac.min(PAIRED),
        ..options.clone()
    };
    let pairing = pair(test, theory, &options)?;
    let shapes = Shapes::new(test, theory, &pairing.map, &options)?;
    let pairs = PairShapes::of_pairing(&shapes, &pairing);
    let known = coordinates(&pairing.map, &pairs);
    let all: Vec<usize> = (0..known.len()).collect();
    let found = against(&known, &pairs, &all);
    if known.iter().all(|own| own.pairs < ENOUGH_PAIRS) {
        return Ok(found.into_iter().map(|(_, own)| own).collect());
    }
    let suspects: Vec<usize> = found.iter().map(|(q, _)| *q).collect();
    let significant = significant(&pairs, &suspects);
    let found = against(&known, &pairs, &significant);
    Ok(found.into_iter().map(|(_, own)| own).collect())
}

/// Those of some sensors whose turning raises the mean MAC, the worst first, with their numbers.
fn against(
    known: &[CoordinateMac],
    pairs: &[PairShapes],
    sensors: &[usize],
) -> Vec<(usize, ReversedSensor)> {
    let mut products: Vec<Complex64> = pairs.iter().map(product).collect();
    let mut found: Vec<(usize, ReversedSensor)> = Vec::new();
    let mut left = sensors.to_vec();
    while 2 * (found.len() + 1) < known.len() {
        let candidates = left.iter().filter_map(|&q| {
            let direction = known[q].direction?;
            let gain = Gain::new(q, pairs, &products);
            gain.is_reversed((direction, known[q].pairs), known.len())
                .then_some((gain.mac, q, direction))
        });
        let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((gain, q, direction)) = best else {
            break;
        };
        let mac_before = mean_mac(&products);
        turn(q, pairs, &mut products);
        left.retain(|&other| other != q);
        let own = ReversedSensor {
            dof: known[q].dof.clone(),
            mac_before,
            mac_after: mac_before + gain,
            direction,
        };
        found.push((q, own));
    }
    found
}

/// Those of some sensors that disagree in more pairs than a good sensor does by chance.
fn significant(pairs: &[PairShapes], suspects: &[usize]) -> Vec<usize> {
    let mut products: Vec<Complex64> = pairs.iter().map(product).collect();
    for &q in suspects {
        turn(q, pairs, &mut products);
    }
    let both: Vec<(&PairShapes, Complex64)> = pairs.iter().zip(products).collect();
    let disagrees = |(pair, product): &(&PairShapes, Complex64), q: usize| {
        let sensors = pair.values.iter().flatten().count() as f64;
        let counts = share(pair, q) * sensors >= LEAST_SHARE;
        counts && (product.conj() * term(pair, q)).re < 0.0
    };
    let part = |own: &(&PairShapes, Complex64)| {
        let count = own.0.values.len();
        let others = (0..count).filter(|q| !suspects.contains(q) && own.0.values[*q].is_some());
        let (all, against) = others.fold((0, 0), |(all, against), q| {
            (all + 1, against + usize::from(disagrees(own, q)))
        });
        // One more than were seen: none of a few is not never.
        (against + 1) as f64 / (all + 1) as f64
    };
    let parts: Vec<f64> = both.iter().map(part).collect();
    let sensors = pairs.first().map_or(0, |pair| pair.values.len());
    let by_chance = |q: usize| {
        let own = both.iter().zip(&parts).filter(|(own, _)| disagrees(own, q));
        sensors as f64 * own.map(|(_, part)| part).product::<f64>()
    };
    let mut kept = suspects.to_vec();
    kept.retain(|&q| by_chance(q) < BY_CHANCE);
    kept
}

/// `ψ_q* φ_q` of a pair.
fn term(pair: &PairShapes, q: usize) -> Complex64 {
    pair.values[q].map_or(Complex64::ZERO, |(test, theory)| theory.conj() * test)
}

/// A sensor's share of the squared length of a pair of unit shapes, mean of test and theory.
fn share(pair: &PairShapes, q: usize) -> f64 {
    pair.values[q].map_or(0.0, |(a, b)| 0.5 * (a.norm_sqr() + b.norm_sqr()))
}

/// `Σ_q ψ_q* φ_q` of a pair of unit shapes.
fn product(pair: &PairShapes) -> Complex64 {
    (0..pair.values.len()).map(|q| term(pair, q)).sum()
}

/// The products with one sensor turned.
fn turn(q: usize, pairs: &[PairShapes], products: &mut [Complex64]) {
    let both = products.iter_mut().zip(pairs);
    both.for_each(|(product, pair)| *product -= 2.0 * term(pair, q));
}

/// Mean of `|Σ_q s_q ψ_q* φ_q|²` over the pairs.
fn mean_mac(products: &[Complex64]) -> f64 {
    let sum: f64 = products.iter().map(Complex64::norm_sqr).sum();
    sum / products.len().max(1) as f64
}

/// What turning a sensor does, means over the pairs.
struct Gain {
    /// MAC that it gains.
    mac: f64,
    /// MAC that it would gain with equal values of the other sign on both sides.
    of_reversed: f64,
    /// Its share of the squared length, mean of test and theory.
    share: f64,
}

impl Gain {
    fn new(q: usize, pairs: &[PairShapes], products: &[Complex64]) -> Self {
        let mean = |of: &dyn Fn(&PairShapes, Complex64) -> f64| {
            let both = pairs.iter().zip(products);
            both.map(|(pair, product)| of(pair, *product)).sum::<f64>() / pairs.len().max(1) as f64
        };
        let share = |pair: &PairShapes| share(pair, q);
        Self {
            mac: mean(&|pair, s| (s - 2.0 * term(pair, q)).norm_sqr() - s.norm_sqr()),
            of_reversed: mean(&|pair, s| 4.0 * share(pair) * (s.norm() + share(pair))),
            share: mean(&|pair, _| share(pair)),
        }
    }

    /// Whether a sensor of this direction over so many pairs is reversed, of so many sensors.
    fn is_reversed(&self, (direction, pairs): (f64, usize), sensors: usize) -> bool {
        if pairs < ENOUGH_PAIRS {
            return direction <= AGAINST_IN_FEW && self.mac >= GAIN;
        }
        direction <= AGAINST
            && self.share * sensors as f64 >= LEAST_SHARE
            && self.mac >= PART_OF_GAIN * self.of_reversed
    }
}

impl ReversedSensor {
    /// The sensor as a finding; of no more than information where it was turned.
    pub fn finding(&self, turned: bool) -> Finding {
        let severity = if turned {
            Severity::Info
        } else {
            Severity::Warning
        };
        let place = Place::Function {
            response: Some(self.dof.clone()),
            reference: None,
        };
        let gain = self.mac_after - self.mac_before;
        Finding::new(severity, Code::ReversedSensor, place).value(gain, "")
    }
}

/// A model with the values of some degrees of freedom times -1, in shapes and in the residues of responses there.
pub fn turned(model: &ModalModel, dofs: &[Dof]) -> ModalModel {
    let sign = |dof: &Dof| if dofs.contains(dof) { -1.0 } else { 1.0 };
    let mut turned = model.clone();
    for mode in &mut turned.modes {
        let values = mode
            .shape
            .iter()
            .map(|(dof, v)| (dof.clone(), v * sign(dof)));
        mode.shape = ModeShape::new(values.collect::<Vec<_>>());
        for ((response, _), residue) in &mut mode.residues {
            *residue *= sign(response);
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::models::{dof, model};
    use super::*;

    /// Bending of a hinged beam at `count` sensors in modes 1 to 4, at 10, 40, 90, 160 Hz.
    fn beam(count: usize) -> ModalModel {
        let shape = |n: usize| -> Vec<f64> {
            let at = |q: usize| (q as f64 + 0.7) / (count as f64 + 0.4);
            let value = |q: usize| (n as f64 * std::f64::consts::PI * at(q)).sin();
            (0..count).map(value).collect()
        };
        let modes: Vec<(f64, Vec<f64>)> =
            (1..=4).map(|n| (10.0 * (n * n) as f64, shape(n))).collect();
        let modes: Vec<(f64, &[f64])> = modes.iter().map(|(hz, s)| (*hz, s.as_slice())).collect();
        model(&modes)
    }

    fn found(test: &ModalModel, theory: &ModalModel) -> Vec<Dof> {
        let own = reversed_sensors(test, theory, &PairOptions::default())
            .expect("shapes of this test have degrees of freedom in common");
        let mut dofs: Vec<Dof> = own.into_iter().map(|own| own.dof).collect();
        dofs.sort();
        dofs
    }

    #[test]
    fn turning_raises_the_mac_to_that_of_the_shapes() {
        let theory = beam(10);
        let test = turned(&theory, &[dof(4)]);
        let own = reversed_sensors(&test, &theory, &PairOptions::default())
            .expect("shapes of this test have degrees of freedom in common");
        assert_eq!(own.len(), 1);
        assert!((own[0].mac_after - 1.0).abs() < 1e-12 && own[0].mac_before < 0.75);
        assert!((own[0].direction + 1.0).abs() < 1e-12);
        assert_eq!(turned(&test, &[dof(4)]), theory);
        assert_eq!(own[0].finding(false).severity, Severity::Warning);
        assert_eq!(own[0].finding(true).severity, Severity::Info);
    }

    proptest! {
        #[test]
        fn reversed_sensors_are_found_and_no_others(
            count in 14usize..40,
            drawn in proptest::collection::btree_set(0usize..1000, 0..3),
            noise in proptest::collection::vec(-0.05..0.05f64, 160),
        ) {
            let theory = beam(count);
            let reversed: std::collections::BTreeSet<usize> = drawn.iter().map(|q| 1 + q % count).collect();
            let reversed: Vec<Dof> = reversed.into_iter().map(dof).collect();
            let mut test = turned(&theory, &reversed);
            for (n, mode) in test.modes.iter_mut().enumerate() {
                let noisy = mode.shape.iter().enumerate();
                let noisy = noisy.map(|(q, (dof, v))| (dof.clone(), v + noise[40 * n + q]));
                mode.shape = ModeShape::new(noisy.collect::<Vec<_>>());
            }
            let own = found(&test, &theory);
            prop_assert!(own.iter().all(|dof| reversed.contains(dof)), "{own:?} {reversed:?}");
            // A sensor with a share w of the squared length costs about 4 w of the MAC.
            let share = |dof: &Dof| {
                let of = |mode: &crate::modal::Mode| {
                    let all: f64 = mode.shape.iter().map(|(_, v)| v.norm_sqr()).sum();
                    mode.shape.get(dof).expect("shapes of this test have degrees of freedom in common").norm_sqr() / all
                };
                theory.modes.iter().map(of).sum::<f64>() / 4.0
            };
            for dof in reversed.iter().filter(|dof| share(dof) > 0.01) {
                prop_assert!(own.contains(dof), "{dof} {own:?}");
            }
        }
    }

    #[test]
    fn a_sensor_that_disagrees_in_one_mode_and_agrees_in_another_is_left() {
        let theory = model(&[
            (10.0, &[1.0, 1.0, 0.4, 0.2, 0.1, 0.1]),
            (40.0, &[1.0, -1.0, 0.3, 0.1, -0.1, 0.2]),
        ]);
        let mut test = model(&[
            (10.0, &[1.0, 1.0, -0.4, 0.2, 0.1, 0.1]),
            (40.0, &[1.0, -1.0, 0.3, 0.1, -0.1, 0.2]),
        ]);
        // Turning the third sensor would raise the MAC of mode 1 more than it lowers that of mode 2.
        let (first, second) = ((1.90f64 / 2.22).powi(2), (1.97f64 / 2.15).powi(2));
        assert!(0.5 * ((1.0 + second) - (first + 1.0)) > 2.0 * GAIN);
        assert_eq!(found(&test, &theory), []);
        // In both modes it is one that points the other way.
        test.modes[1] = turned(&theory, &[dof(3)]).modes[1].clone();
        assert_eq!(found(&test, &theory), [dof(3)]);
    }

    #[test]
    fn one_reversed_sensor_of_many_is_found_and_so_are_more() {
        let theory = beam(300);
        // Turning one of 300 gains about 4/300 at most, which is less than two pairs alone would need.
        let one = turned(&theory, &[dof(75)]);
        let own = reversed_sensors(&one, &theory, &PairOptions::default())
            .expect("shapes of this test have degrees of freedom in common");
        assert_eq!(own.len(), 1);
        assert_eq!(own[0].dof, dof(75));
        assert!(own[0].mac_after - own[0].mac_before < GAIN);
        let many: Vec<Dof> = (2..29).map(|n| dof(10 * n)).collect();
        let mut expected = many.clone();
        expected.sort();
        assert_eq!(found(&turned(&theory, &many), &theory), expected);
    }

    #[test]
    fn noise_at_sensors_that_hardly_move_reverses_none() {
        // The last 200 of 300 sensors stand on a part that hardly moves: their values are noise of 5 % of the mean.
        let mut theory = beam(300);
        let still = |q: usize| q >= 100;
        let noise = |n: usize, q: usize| {
            let x = (q * 37 + n * 101) as f64;
            0.035 * (x * x * 0.618_034).sin()
        };
        let mut test = theory.clone();
        for (n, (own, other)) in test.modes.iter_mut().zip(&mut theory.modes).enumerate() {
            let both = |seed: usize, shape: &ModeShape| {
                let values = shape.iter().enumerate().map(|(q, (dof, v))| {
                    let kept = if still(q) { Complex64::ZERO } else { v };
                    (dof.clone(), kept + noise(n + seed, q))
                });
                ModeShape::new(values.collect::<Vec<_>>())
            };
            (own.shape, other.shape) = (both(0, &own.shape), both(50, &other.shape));
        }
        let pairing = pair(&test, &theory, &PairOptions::default())
            .expect("shapes of this test have degrees of freedom in common");
        assert!(pairing.pairs.len() >= ENOUGH_PAIRS);
        assert_eq!(found(&test, &theory), []);
    }

    #[test]
    fn sensors_that_disagree_by_chance_in_three_poor_pairs_are_left() {
        // Every fifth sensor disagrees in each mode, drawn for each by itself: 300/125 in all three.
        let mut theory = beam(300);
        theory.modes.truncate(3);
        let mut test = theory.clone();
        let mut state = 12345u64;
        let mut fifth = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33).is_multiple_of(5)
        };
        for mode in &mut test.modes {
            let values = mode
                .shape
                .iter()
                .map(|(dof, v)| (dof.clone(), if fifth() { -v } else { v }));
            mode.shape = ModeShape::new(values.collect::<Vec<_>>());
        }
        let against = |dof: &Dof| {
            let both = test.modes.iter().zip(&theory.modes);
            both.clone()
                .all(|(a, b)| a.shape.get(dof) != b.shape.get(dof))
        };
        let dofs: Vec<Dof> = theory.modes[0]
            .shape
            .iter()
            .map(|(dof, _)| dof.clone())
            .collect();
        assert!(dofs.iter().any(against));
        assert_eq!(found(&test, &theory), []);
        // Three good pairs say it of as many.
        let few: Vec<Dof> = dofs.into_iter().filter(against).collect();
        assert_eq!(found(&turned(&theory, &few), &theory), few);
    }

    #[test]
    fn a_poor_model_has_no_reversed_sensors() {
        for count in [12, 300] {
            let theory = beam(count);
            assert_eq!(found(&bent(&theory), &theory), [], "{count}");
        }
    }

    /// A beam that is stiffer at one end: nodes move, and signs near them.
    fn bent(theory: &ModalModel) -> ModalModel {
        let mut test = theory.clone();
        for (n, mode) in test.modes.iter_mut().enumerate() {
            let values = mode.shape.iter().enumerate();
            let bent = values.map(|(q, (dof, _))| {
                let x = (q as f64 + 0.7) / (mode.shape.len() as f64 + 0.4);
                let moved = x + 0.06 * (std::f64::consts::PI * x).sin();
                let value = ((n + 1) as f64 * std::f64::consts::PI * moved).sin();
                (dof.clone(), Complex64::from(value))
            });
            mode.shape = ModeShape::new(bent.collect::<Vec<_>>());
        }
        test
    }
}

//! Pairs of modes of plates, rings and towers are compared with the true partners.

use std::collections::BTreeMap;

use modalign::correlate::{PairOptions, PairVerdict, pair};
use modalign::modal::Mode;
use rayon::prelude::*;

use super::structures::{KINDS, Kind, Structure};

const STRUCTURES: u64 = 156;
/// Contribution of a partner to a shape, over the largest of any root.
const MIN_CONTRIBUTION_OVER_LARGEST: f64 = 0.5;
/// Difference of the MAC with the true partner and with the chosen one, at the sensors without
/// faults, by which the sensors separate both.
const MIN_SEPARATING_MAC: f64 = 0.1;

/// Numbers of test modes by their pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counts {
    right: usize,
    ambiguous: usize,
    /// Wrong, where the sensors do not separate both roots.
    wrong: usize,
    /// Wrong, although the sensors separate both.
    wrong_separable: usize,
    unpaired: usize,
    /// Test modes of which the root nearest in frequency is wrong.
    wrong_by_frequency: usize,
}

impl Counts {
    fn pairs(&self) -> usize {
        self.right + self.ambiguous + self.wrong + self.wrong_separable
    }

    fn add(&mut self, other: &Self) {
        self.right += other.right;
        self.ambiguous += other.ambiguous;
        self.wrong += other.wrong;
        self.wrong_separable += other.wrong_separable;
        self.unpaired += other.unpaired;
        self.wrong_by_frequency += other.wrong_by_frequency;
    }
}

fn judged(number: u64) -> (Kind, Counts) {
    let structure = Structure::draw(number);
    let pairing = pair(&structure.test, &structure.theory, &PairOptions::default()).unwrap();
    let is_right = |mode: usize, root: usize| {
        let parts = &structure.truth[mode].contributions;
        let largest = parts.iter().copied().fold(0.0, f64::max);
        parts[root] >= MIN_CONTRIBUTION_OVER_LARGEST * largest
    };
    let nearest = |mode: usize| {
        let hz = structure.test.modes[mode].frequency_hz;
        let apart = |other: &&Mode| (other.frequency_hz - hz).abs();
        let mut modes = structure.theory.modes.iter();
        let first = modes.next().unwrap();
        let near = modes.fold(first, |a, b| if apart(&b) < apart(&a) { b } else { a });
        near.group.unwrap() as usize
    };
    let wrong = (0..structure.test.modes.len()).filter(|mode| !is_right(*mode, nearest(*mode)));
    let mut counts = Counts {
        unpaired: pairing.unpaired_test.len(),
        wrong_by_frequency: wrong.count(),
        ..Counts::default()
    };
    for mode_pair in &pairing.pairs {
        let root = structure.theory.modes[mode_pair.theory[0]].group.unwrap() as usize;
        for partner in &mode_pair.partners {
            let truth = &structure.truth[partner.test];
            let largest = truth.contributions.iter().copied().fold(0.0, f64::max);
            if partner.verdict != PairVerdict::Paired {
                counts.ambiguous += 1;
                continue;
            }
            if is_right(partner.test, root) {
                counts.right += 1;
                continue;
            }
            let true_root = truth
                .contributions
                .iter()
                .position(|part| part.total_cmp(&largest).is_eq());
            let macs = &truth.clean_macs;
            let separates = macs[true_root.unwrap()] - macs[root] > MIN_SEPARATING_MAC;
            println!(
                "{number} {:?}: {} sensors, mode {} with root {root}, true {true_root:?}, parts {:.2} {largest:.2}, MAC {:?}, clean {:.2} {:.2}",
                structure.kind,
                structure.sensors,
                partner.test,
                truth.contributions[root],
                partner.mac,
                macs[root],
                macs[true_root.unwrap()],
            );
            match separates {
                true => counts.wrong_separable += 1,
                false => counts.wrong += 1,
            }
        }
    }
    (structure.kind, counts)
}

/// Counts of structures by kind.
fn counts(numbers: std::ops::Range<u64>) -> BTreeMap<String, Counts> {
    let judged: Vec<(Kind, Counts)> = numbers.into_par_iter().map(judged).collect();
    let of_kind = |kind: Kind| {
        let mut sum = Counts::default();
        let of_kind = judged.iter().filter(|(other, _)| *other == kind);
        of_kind.for_each(|(_, counts)| sum.add(counts));
        (format!("{kind:?}"), sum)
    };
    KINDS.into_iter().map(of_kind).collect()
}

// The first half of the draws is for development, the second was run once at the end. Measured: of
// 1,796 pairs 1,490 right, 306 ambiguous, none wrong; by frequency alone 368 modes are wrong.

#[test]
fn pairs_of_plates_rings_and_towers_are_right_or_named_ambiguous() {
    let mut all = Counts::default();
    for half in [0..STRUCTURES / 2, STRUCTURES / 2..STRUCTURES] {
        for (kind, counts) in counts(half) {
            println!("{kind:12} {} pairs: {counts:?}", counts.pairs());
            all.add(&counts);
        }
    }
    println!("all {} pairs: {all:?}", all.pairs());
    assert!(all.wrong <= 3, "{all:?}");
    assert_eq!(all.wrong_separable, 0, "{all:?}");
    // The draws are hard enough to be paired wrongly.
    assert!(all.wrong_by_frequency > 100, "{all:?}");
    assert!(all.right as f64 > 0.7 * all.pairs() as f64, "{all:?}");
}

//! Pairing of test modes with a model of wrong stiffnesses is compared with pairing by frequency,
//! by MAC and by index alone.

use modalign::correlate::{PairOptions, PairVerdict, assign, pair};
use rayon::prelude::*;

use super::machines::{Family, Machine, SENSORS};

const MACHINES: u64 = 500;
/// Smallest part of a shape in the span of a root that makes the root its clear partner.
const MIN_CLEAR_PART: f64 = 0.5;

/// Results of the pairing of test modes.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// Paired with the root of the largest part of the shape, not labelled ambiguous.
    right: usize,
    /// With that root, labelled ambiguous.
    right_ambiguous: usize,
    /// With another, labelled ambiguous.
    wrong_ambiguous: usize,
    /// With another, not labelled ambiguous.
    wrong: usize,
    /// With none.
    alone: usize,
}

impl Counts {
    fn all(&self) -> usize {
        self.right + self.right_ambiguous + self.wrong_ambiguous + self.wrong + self.alone
    }

    /// The part that is with its root.
    fn found(&self) -> f64 {
        (self.right + self.right_ambiguous) as f64 / self.all() as f64
    }

    /// The part that is labelled.
    fn labelled(&self) -> f64 {
        (self.right_ambiguous + self.wrong_ambiguous) as f64 / self.all() as f64
    }

    fn line(&self) -> String {
        format!(
            "{:>5}  {:>5}  {:>9}  {:>8}  {:>5}  {:>4}",
            self.all(),
            self.right,
            self.right_ambiguous,
            self.wrong_ambiguous,
            self.wrong,
            self.alone
        )
    }

    fn add(&mut self, other: &Self) {
        self.right += other.right;
        self.right_ambiguous += other.right_ambiguous;
        self.wrong_ambiguous += other.wrong_ambiguous;
        self.wrong += other.wrong;
        self.alone += other.alone;
    }

    fn count(&mut self, truth: usize, root: Option<usize>, sure: bool) {
        let Some(root) = root else {
            self.alone += 1;
            return;
        };
        *match (root == truth, sure) {
            (true, true) => &mut self.right,
            (true, false) => &mut self.right_ambiguous,
            (false, false) => &mut self.wrong_ambiguous,
            (false, true) => &mut self.wrong,
        } += 1;
    }
}

/// Root of every test mode by some rule, and whether it is sure.
type Choice = Vec<(Option<usize>, bool)>;
type Rule = fn(&Machine) -> Choice;

fn by_tool(machine: &Machine) -> Choice {
    let pairing = pair(&machine.test, &machine.theory, &PairOptions::default()).unwrap();
    let mut choice = vec![(None, true); machine.test.modes.len()];
    for mode_pair in &pairing.pairs {
        let root = machine.theory.modes[mode_pair.theory[0]].group.unwrap() as usize;
        for partner in &mode_pair.partners {
            choice[partner.test] = (Some(root), partner.verdict == PairVerdict::Paired);
        }
    }
    choice
}

/// The rules of thumb: by frequency alone and by MAC alone, each decided for all modes together,
/// and by index.
fn by_rule(machine: &Machine, cost: impl Fn(usize, usize) -> f64) -> Choice {
    let (tests, theory) = (machine.test.modes.len(), &machine.theory.modes);
    let row = |i: usize| (0..theory.len()).map(|j| Some(cost(i, j))).collect();
    let costs: Vec<Vec<Option<f64>>> = (0..tests).map(row).collect();
    let root = |column: usize| theory[column].group.unwrap() as usize;
    let chosen = assign(&costs, 1e3).into_iter();
    chosen.map(|column| (column.map(root), true)).collect()
}

fn by_frequency(machine: &Machine) -> Choice {
    by_rule(machine, |i, j| {
        let (test, theory) = (&machine.test.modes[i], &machine.theory.modes[j]);
        (test.frequency_hz / theory.frequency_hz).ln().abs()
    })
}

fn by_mac(machine: &Machine) -> Choice {
    let options = PairOptions {
        max_frequency_error: 100.0,
        ..PairOptions::default()
    };
    let pairing = pair(&machine.test, &machine.theory, &options).unwrap();
    by_rule(machine, |i, j| 1.0 - pairing.mac[i][j].unwrap_or(0.0))
}

fn by_index(machine: &Machine) -> Choice {
    by_rule(machine, |i, j| i.abs_diff(j) as f64)
}

struct Judged {
    sensors: usize,
    /// Clear modes and the rest, by the tool and by each rule of thumb.
    counts: Vec<[Counts; 2]>,
}

const RULES: [(&str, Rule); 4] = [
    ("frequency and MAC", by_tool),
    ("frequency alone", by_frequency),
    ("MAC alone", by_mac),
    ("index", by_index),
];

fn judged(family: Family, number: u64) -> Judged {
    let machine = Machine::draw(family, number);
    let counts = RULES.iter().map(|(_, rule)| {
        let mut counts = [Counts::default(); 2];
        for ((root, sure), truth) in rule(&machine).into_iter().zip(&machine.truth) {
            counts[usize::from(truth.mac <= MIN_CLEAR_PART)].count(truth.root, root, sure);
        }
        counts
    });
    Judged {
        sensors: machine.sensors,
        counts: counts.collect(),
    }
}

// The machines and their seeds are fixed, so that the counts are too, but for a few on the edge.

/// Limits of a family.
struct Limits {
    /// Smallest share of clear modes paired with their root, with 20 sensors or more and with 8.
    found: [f64; 2],
    /// Largest number of wrong pairs without a label, of clear modes and of others, with any number
    /// of sensors: one more than measured.
    wrong: [usize; 2],
    /// Largest part of clear modes with 20 sensors or more that are labelled ambiguous.
    labelled: f64,
}

/// Measured: 5879 of 5883 and 1545 of 1564 find their root; none of 7447 and none of 63 is wrong
/// without a word; 1.3 % labelled.
const EQUAL: Limits = Limits {
    found: [0.995, 0.98],
    wrong: [1, 1],
    labelled: 0.02,
};
/// Measured: 5708 of 5743 and 1438 of 1472; 1 of 7215 and 1 of 319, shapes shared with an
/// oscillator that carries no sensor; 6.8 %.
const HELD_OUT: Limits = Limits {
    found: [0.99, 0.97],
    wrong: [2, 2],
    labelled: 0.08,
};

#[test]
fn modes_find_their_roots_in_models_whose_stiffnesses_are_wrong() {
    for (family, limits) in [(Family::Equal, EQUAL), (Family::HeldOut, HELD_OUT)] {
        let all = (0..MACHINES).into_par_iter();
        let all: Vec<Judged> = all.map(|number| judged(family, number)).collect();
        print(family, &all);
        check(&all, &limits);
    }
}

fn print(family: Family, all: &[Judged]) {
    println!("{family:?}");
    println!("sensors  rule               part   modes  found  ambiguous  wrong so  wrong  none");
    for &sensors in &SENSORS {
        for (r, (rule, _)) in RULES.iter().enumerate() {
            let counts = sums(all, r, |s| s == sensors);
            for (part, count) in ["clear", "mixed"].iter().zip(counts) {
                println!("{sensors:>7}  {rule:17}  {part}  {}", count.line());
            }
        }
    }
}

fn check(all: &[Judged], limits: &Limits) {
    let [clear, _] = sums(all, 0, |sensors| sensors >= 20);
    let [few, _] = sums(all, 0, |sensors| sensors < 20);
    assert!(clear.found() >= limits.found[0], "{clear:?}");
    assert!(few.found() >= limits.found[1], "{few:?}");
    assert!(clear.labelled() <= limits.labelled, "{clear:?}");
    let [every_clear, every_mixed] = sums(all, 0, |_| true);
    assert!(every_clear.wrong <= limits.wrong[0], "{every_clear:?}");
    assert!(every_mixed.wrong <= limits.wrong[1], "{every_mixed:?}");
    // What all of it is for.
    for rule in 1..RULES.len() {
        let [thumb, _] = sums(all, rule, |_| true);
        assert!(thumb.wrong > 50 * every_clear.wrong.max(1), "{thumb:?}");
    }
}

fn sums(all: &[Judged], rule: usize, counts: impl Fn(usize) -> bool) -> [Counts; 2] {
    let mut sums = [Counts::default(); 2];
    for judged in all.iter().filter(|judged| counts(judged.sensors)) {
        for (sum, counted) in sums.iter_mut().zip(&judged.counts[rule]) {
            sum.add(counted);
        }
    }
    sums
}

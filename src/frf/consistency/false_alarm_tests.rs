//! Clean sets at 30 dB: how often each check speaks.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::check_set;
use super::synthetic::{Beam, add_noise};
use crate::finding::Code;

/// Seeded draws.
const DRAWS: u64 = 200;

/// A check with a false-alarm probability of 0.1 % alarms twice or more in 200 draws with a
/// probability of 1.8 %, three times with 0.1 %: at most one is allowed (below 1 %).
const MAX_FALSE_ALARMS: usize = 1;

#[test]
fn clean_sets_at_30_db_give_no_alarm() {
    let pairs = [
        ("1:+Z", "1:+Z"),
        ("1:+Z#2", "1:+Z"),
        ("2:-Z", "1:+Z"),
        ("3:+Z", "1:+Z"),
        ("4:+Z", "1:+Z"),
        ("1:+Z", "2:+Z"),
        ("2:+Z", "2:+Z"),
        ("1:+Z", "4:+Z"),
    ];
    let clean = Beam::default().set(&pairs);
    let codes = |seed: u64| -> Vec<Code> {
        let mut set = clean.clone();
        add_noise(&mut set, 30.0, 1000 + seed);
        check_set(&set).iter().map(|finding| finding.code).collect()
    };
    let draws: Vec<Vec<Code>> = (0..DRAWS).into_par_iter().map(codes).collect();
    let mut alarms = BTreeMap::<Code, usize>::new();
    for mut codes in draws {
        codes.dedup();
        for code in codes {
            *alarms.entry(code).or_default() += 1;
        }
    }
    assert!(
        alarms.values().all(|n| *n <= MAX_FALSE_ALARMS),
        "{alarms:?}"
    );
}

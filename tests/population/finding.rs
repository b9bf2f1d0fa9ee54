//! The share of found modes of the family stays above its limits, kind by kind.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::judge::Verdict;
use super::members;
use super::pipeline::{Share, Tally, judged, judged_from_frfs_alone};
use crate::population::Member;

// The family and its seeds are fixed, so that the counts are too, but for roots on the edge of a
// limit that another machine's rounding may tip over: each limit leaves room for a few of those,
// and for no loss that matters.

/// Observable and separated modes. Measured: 444.
const MIN_CLEAR_FOUND: usize = 440;
/// Largest number of missed ones among them. Measured: 1.
const MAX_CLEAR_MISSED: usize = 2;
/// Smallest number of found modes among the observable, not separated ones. Measured: 632 of 639.
const MIN_CROWDED_FOUND: usize = 628;
/// Largest number of spurious modes of the close kind. Measured: 1.
const MAX_CLOSE_SPURIOUS: usize = 3;
/// Largest number of spurious modes of the other kinds together. Measured: 12; 5 are required.
const MAX_OTHER_SPURIOUS: usize = 15;

/// The same from FRFs alone: separated modes not found, crowded modes found, spurious modes.
/// Measured: 1, 626 and 9.
const MAX_FRF_ONLY_CLEAR_MISSED: usize = 2;
const MIN_FRF_ONLY_CROWDED_FOUND: usize = 622;
const MAX_FRF_ONLY_SPURIOUS: usize = 13;

#[test]
fn nearly_every_mode_is_found_and_few_are_invented() {
    let tallies = tallies(judged);
    let (all, close) = (&tallies["all"], &tallies["close"]);
    assert!(all.clear.there >= MIN_CLEAR_FOUND, "{}", all.clear.there);
    hold_found(all, (MAX_CLEAR_MISSED, MIN_CROWDED_FOUND));
    assert!(close.spurious <= MAX_CLOSE_SPURIOUS, "{}", close.spurious);
    let others = all.spurious - close.spurious;
    assert!(others <= MAX_OTHER_SPURIOUS, "{others}");
}

#[test]
fn frfs_without_variances_give_the_modes_as_well() {
    let tallies = tallies(judged_from_frfs_alone);
    let all = &tallies["all"];
    hold_found(all, (MAX_FRF_ONLY_CLEAR_MISSED, MIN_FRF_ONLY_CROWDED_FOUND));
    assert!(all.spurious <= MAX_FRF_ONLY_SPURIOUS, "{}", all.spurious);
}

/// The counts of every kind and of all, as they are printed.
fn tallies(judged: fn(&Member) -> Verdict) -> BTreeMap<&'static str, Tally> {
    let members = members();
    let verdicts: Vec<_> = members.par_iter().map(judged).collect();
    let mut tallies: BTreeMap<&str, Tally> = BTreeMap::new();
    for (member, verdict) in members.iter().zip(&verdicts) {
        tallies.entry(member.kind).or_default().add(member, verdict);
        tallies.entry("all").or_default().add(member, verdict);
    }
    println!("kind       members  separated   crowded     hidden    spurious");
    for (kind, tally) in &tallies {
        println!("{}", line(kind, tally));
    }
    tallies
}

fn hold_found(all: &Tally, (most_lost, fewest_crowded): (usize, usize)) {
    let lost = all.clear.there - all.clear.found;
    assert!(lost <= most_lost, "{lost}");
    let crowded = all.crowded.found;
    assert!(crowded >= fewest_crowded, "{crowded}");
}

/// One line of the table.
fn line(kind: &str, tally: &Tally) -> String {
    let share = |s: Share| format!("{:>5}/{:<5}", s.found, s.there);
    format!(
        "{kind:<10}{:>7} {} {} {} {:>8}",
        tally.members,
        share(tally.clear),
        share(tally.crowded),
        share(tally.hidden),
        tally.spurious
    )
}

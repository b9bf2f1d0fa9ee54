//! The share of found modes of the family stays above its limits, kind by kind.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::judge::{Root, Verdict, judge};
use modalign::finding::Code;
use modalign::frf::{HammerOptions, HammerTestResult, evaluate_hammer_test};
use modalign::identify::{IdentifyOptions, identify};
use modalign::modal::ModalModel;
use modalign::record::InMemory;

use super::pipeline::{self, Share, Tally, judged, judged_from_frfs_alone};
use super::{draws, first_members, members_of, parts};
use crate::population::{Member, PopulationSpec};

// The family and its seeds are fixed, so that the counts are too, but for roots on the edge of a
// limit that another machine's rounding may tip over. Each limit is the count of all members or its
// part for fewer (`draws`), with room for a few of those roots and for no loss that matters.

/// Observable modes of all members: separated, and not separated.
const SEPARATED: u64 = 444;
const CROWDED: u64 = 639;

/// Counts of all members.
struct Counts {
    separated_missed: u64,
    crowded_missed: u64,
    spurious: u64,
}

const COUNTS: Counts = Counts {
    separated_missed: 1,
    crowded_missed: 7,
    spurious: 5,
};
/// The same from FRFs alone.
const COUNTS_OF_FRFS_ALONE: Counts = Counts {
    separated_missed: 1,
    crowded_missed: 13,
    spurious: 8,
};
/// The same from hits with the windows that `frf` takes by default.
const COUNTS_BY_DEFAULT: Counts = Counts {
    separated_missed: 1,
    crowded_missed: 8,
    spurious: 1,
};
/// Spurious modes of the close kind, and of the other kinds, from hammer tests.
const CLOSE_SPURIOUS: u64 = 0;
const OTHER_SPURIOUS: u64 = 5;
/// Roots that rounding may tip over.
const ROOM: u64 = 4;

#[test]
fn nearly_every_mode_is_found_and_few_are_invented() {
    let tallies = tallies(judged);
    assert_counts(&tallies["all"], &COUNTS);
    let close = tallies["close"].spurious as u64;
    assert!(close <= draws(CLOSE_SPURIOUS) + 2, "{close}");
    let others = tallies["all"].spurious as u64 - close;
    assert!(others <= draws(OTHER_SPURIOUS) + 3, "{others}");
}

#[test]
fn frfs_without_variances_give_the_modes_as_well() {
    assert_counts(
        &tallies(judged_from_frfs_alone)["all"],
        &COUNTS_OF_FRFS_ALONE,
    );
}

/// Modes of the hits of a member with the windows and options that `frf` takes by default.
fn identified_by_default(member: &Member) -> (HammerTestResult, ModalModel) {
    let hits = member.test.generate().unwrap();
    let options = HammerOptions::default();
    let result = evaluate_hammer_test(&mut InMemory::new(&hits), &options).unwrap();
    let found = identify(&result.estimated.set, &IdentifyOptions::default()).unwrap();
    (result, found)
}

/// As [`judged`], with the windows that `frf` takes by default.
fn judged_by_default(member: &Member) -> Verdict {
    let (result, found) = identified_by_default(member);
    judge(member, &result.estimate, &found)
}

#[test]
fn hits_with_default_windows_give_the_modes_as_well() {
    assert_counts(&tallies(judged_by_default)["all"], &COUNTS_BY_DEFAULT);
}

/// Whether a repeated root is there with two modes or more found, and whether one is claimed.
fn repeated_roots(member: &Member) -> [bool; 2] {
    let (result, found) = identified_by_default(member);
    let verdict = judge(member, &result.estimate, &found);
    let is_found = |root: &Root| root.modes.len() > 1 && root.found > 1;
    let mut codes = found.findings.iter().map(|finding| finding.code);
    [
        verdict.roots.iter().any(is_found),
        codes.any(|code| code == Code::RepeatedRoot),
    ]
}

#[test]
fn repeated_roots_are_claimed_where_they_are() {
    let family = pipeline::family();
    // The family, and another draw of it.
    let seeds = [family.seed, family.seed + 1];
    let families = seeds.map(|seed| PopulationSpec {
        seed,
        ..family.clone()
    });
    let drawn: Vec<Member> = families
        .iter()
        .flat_map(|family| members_of(family, |count| draws(count as u64) as usize))
        .collect();
    let results: Vec<[bool; 2]> = drawn.par_iter().map(repeated_roots).collect();
    let mut by_kind: BTreeMap<&str, [usize; 4]> = BTreeMap::new();
    for (member, [is_there, is_claimed]) in drawn.iter().zip(results) {
        let counts = by_kind.entry(member.kind).or_default();
        let counted = [
            true,
            is_there,
            is_there && is_claimed,
            !is_there && is_claimed,
        ];
        for (count, counted) in counts.iter_mut().zip(counted) {
            *count += usize::from(counted);
        }
    }
    println!("members, with repeated roots, claimed of these, claimed of others: {by_kind:?}");
    let sum = |k: usize| by_kind.values().map(|counts| counts[k]).sum::<usize>();
    assert_eq!(sum(3), 0, "claimed without a repeated root");
    assert!(
        sum(1) > 0 && sum(2) * 20 >= sum(1) * 19,
        "{} of {}",
        sum(2),
        sum(1)
    );
}

fn assert_counts(all: &Tally, expected: &Counts) {
    let missed = |share: Share| (share.there - share.found) as u64;
    let (separated, crowded) = (missed(all.clear), missed(all.crowded));
    assert!(
        separated <= draws(expected.separated_missed) + 1,
        "{separated}"
    );
    assert!(
        crowded <= draws(expected.crowded_missed) + ROOM,
        "{crowded}"
    );
    let spurious = all.spurious as u64;
    assert!(spurious <= draws(expected.spurious) + ROOM, "{spurious}");
    // The first members of each kind have up to a tenth fewer modes than the others.
    for (share, of_all) in [(all.clear, SEPARATED), (all.crowded, CROWDED)] {
        let there = share.there as u64;
        let room = if parts() == 1 {
            ROOM
        } else {
            draws(of_all) / 10
        };
        assert!(there + room >= draws(of_all), "{there} of {of_all}");
    }
}

/// The counts of every kind and of all, as they are printed.
fn tallies(judged: fn(&Member) -> Verdict) -> BTreeMap<&'static str, Tally> {
    let members = first_members(|count| draws(count as u64) as usize);
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

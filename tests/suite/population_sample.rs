//! A small sample of the committed family: the first member of every kind, judged as the whole
//! family is.

#[path = "../population/judge.rs"]
mod judge;
#[path = "../population/pipeline.rs"]
mod pipeline;

use crate::population::Member;
use pipeline::{Tally, family, judged, judged_from_frfs_alone};
use rayon::prelude::*;

use judge::Verdict;

fn tally(judged: fn(&Member) -> Verdict) -> Tally {
    let family = family();
    let members: Vec<_> = (0..family.members.len())
        .map(|kind| family.draw(kind, 0).unwrap())
        .collect();
    let verdicts: Vec<_> = members.par_iter().map(judged).collect();
    let mut all = Tally::default();
    for (member, verdict) in members.iter().zip(&verdicts) {
        all.add(member, verdict);
    }
    assert_eq!(all.members, 8);
    all
}

#[test]
fn separated_modes_of_the_first_members_are_found() {
    let alone = tally(judged_from_frfs_alone);
    for all in [&tally(judged), &alone] {
        // Of the whole family 443 of 444 are found, here all.
        assert!(all.clear.there >= 10, "{}", all.clear.there);
        assert_eq!(all.clear.found, all.clear.there);
    }
    // The whole family has 9 spurious modes in 192 members.
    assert!(alone.spurious <= 1, "{}", alone.spurious);
}

//! The committed family of synthetic hammer tests, drawn whole: that it is what it says, that H1 of
//! it is right, and how many of its modes the present method finds. Identification from FRFs of
//! systems known by their modes, in white noise of known variance. Modes paired with models whose
//! stiffnesses are wrong, and models updated to synthetic twins of their machines. And every reader
//! on damaged files.

mod close_pairs;
mod deviations;
mod efficiency;
#[path = "../support/extended_precision.rs"]
mod extended_precision;
mod finding;
mod gears;
mod hits;
mod identification;
mod judge;
mod linear_algebra;
mod machines;
#[path = "../support/matrix_zoo.rs"]
mod matrix_zoo;
mod mutants;
mod mutation;
mod pairing;
mod pipeline;
mod recording;
mod seeds;
mod systems;
mod twins;
mod updating;
mod variance;
mod window;

use modalign::synth::population::Member;
use rayon::prelude::*;

/// Every member, kind by kind.
fn members() -> Vec<Member> {
    let family = pipeline::family();
    let counts = family.members.iter().map(|member| member.count);
    let numbers: Vec<(usize, usize)> = counts
        .enumerate()
        .flat_map(|(kind, count)| (0..count).map(move |number| (kind, number)))
        .collect();
    let drawn = numbers
        .par_iter()
        .map(|&(kind, number)| family.draw(kind, number));
    drawn.collect::<Result<_, _>>().unwrap()
}

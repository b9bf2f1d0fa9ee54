//! The statistical tests cover the committed family of synthetic hammer tests: its consistency, its
//! H1 and its found modes; the identification of known systems from FRFs in white noise of known
//! variance; the pairing of modes with models of wrong stiffnesses, of machines and of plates,
//! rings and towers; the update of models to synthetic twins of their machines; and every reader on
//! damaged files.

mod close_pairs;
mod configurations;
mod deviations;
mod efficiency;
#[path = "../support/extended_precision.rs"]
mod extended_precision;
mod finding;
mod gears;
mod grounds;
mod hits;
mod identification;
mod imperfect;
mod judge;
mod linear_algebra;
mod machines;
#[path = "../support/matrix_zoo.rs"]
mod matrix_zoo;
mod mutants;
mod mutation;
mod packing;
mod pairing;
mod pairing_of_structures;
mod pipeline;
#[path = "../support/population/mod.rs"]
mod population;
mod readers;
mod recording;
mod scene_updates;
mod seeds;
mod structure;
mod structures;
mod systems;
mod twins;
mod updating;
mod variance;
mod what_if;
mod window;

use rayon::prelude::*;

use population::{Member, PopulationSpec};

/// Number of draws of a long test: all, divided by the environment variable `POPULATION_PARTS`.
fn draws(all: u64) -> u64 {
    all.div_ceil(parts())
}

/// Divisor of the draws.
fn parts() -> u64 {
    std::env::var("POPULATION_PARTS").map_or(1, |parts| parts.parse().unwrap())
}

/// Every member, kind by kind.
fn members() -> Vec<Member> {
    first_members(|count| count)
}

/// The first members of each kind; `number` turns the number of all members of a kind into theirs.
fn first_members(number: impl Fn(usize) -> usize) -> Vec<Member> {
    members_of(&pipeline::family(), number)
}

/// As [`first_members`], of another family.
fn members_of(family: &PopulationSpec, number: impl Fn(usize) -> usize) -> Vec<Member> {
    let counts = family.members.iter().map(|member| number(member.count));
    let numbers: Vec<(usize, usize)> = counts
        .enumerate()
        .flat_map(|(kind, count)| (0..count).map(move |number| (kind, number)))
        .collect();
    let drawn = numbers
        .par_iter()
        .map(|&(kind, number)| family.draw(kind, number));
    drawn.collect::<Result<_, _>>().unwrap()
}

//! The integration tests, one binary: the command line as a user runs it, real recordings, and the
//! architecture.

mod architecture;
mod bad_input;
mod breakdown_command;
mod changes;
mod check_command;
mod claimed_sizes;
mod command;
mod configurations;
mod correlate_command;
mod correlate_tables;
mod cycloid_ball;
mod examples;
mod exchange;
mod exports;
mod faults;
mod faulty_streams;
mod file_circles;
mod first_steps;
mod free_free_beam;
mod gate;
mod gate_mutations;
mod hit_command;
mod hits;
mod identify_command;
mod linear_algebra;
mod manners;
mod massless;
mod matrix_models;
mod misfits;
mod mode_files;
mod mutants;
mod mutated_texts;
#[path = "../population/mutation.rs"]
mod mutation;
mod new_command;
mod new_options;
mod next_steps;
#[path = "../population/packing.rs"]
mod packing;
mod pairs_by_shape;
mod placement;
#[path = "../support/population/mod.rs"]
mod population;
mod population_draws;
mod population_sample;
mod published;
#[path = "../population/readers.rs"]
mod readers;
mod readme;
mod real_modes;
mod recordings;
mod report;
mod roving;
mod screen;
#[path = "../population/seeds.rs"]
mod seeds;
#[path = "../population/structure.rs"]
mod structure;
mod structures;
mod study_command;
mod supports;
mod targets;
mod testlab_sample;
#[path = "../support/text_inputs.rs"]
mod text_inputs;
mod theory_command;
mod torture;
mod transmissions;
mod truncation;
mod tuple_parameters;
#[path = "../population/twins.rs"]
mod twins;
mod unneeded;
mod untrusted_text;
mod updating;
mod vocabulary;
mod watch_command;
mod what_if;
mod writing;
mod wrong_files;

//! The integration tests, one binary: the command line as a user runs it, real recordings, and the architecture.

mod architecture;
mod bad_input;
mod command;
mod cycloid_ball;
mod free_free_beam;
mod gate;
mod population;
mod published;
mod recordings;
mod roving;
mod truncation;

//! `modalign-numerics` has the matrix decompositions and Fourier transforms of `modalign`, and is
//! the only package that names crates for them, benches aside.

#![cfg_attr(not(test), warn(clippy::unwrap_used))]

pub mod fourier;
pub mod linalg;

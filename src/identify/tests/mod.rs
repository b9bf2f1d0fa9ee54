//! Tests of whole identifications: accuracy, methods, options, failures.

mod accuracy;
mod beam;
mod failed_decompositions;
mod high_snr;
mod hump;
mod methods;
mod ml;
mod options;
mod rank;

//! Synthetic hammer tests with exact truth: time histories computed in closed form from any modal
//! model.
//!
//! The chain is `half sine -> structure -> analogue low-pass -> sampling -> noise -> faults`. Up to
//! the sampling it is linear and time invariant with a rational transfer function, so that every
//! sample is a finite sum of exponentials: there is no time stepping, no oversampling and no
//! resampling, and the truth (poles and residues) is exact.
//!
//! | file | what it holds |
//! |---|---|
//! | `truth` | [`Truth`]: modes, residues, rigid-body term, and the true transfer function |
//! | `pulse` | [`Pulse`] as stated, [`HalfSine`] as drawn, its convolution with an exponential |
//! | `filter` | [`LowPass`]: the anti-alias filter of every channel, with poles and partial fractions |
//! | `cascade` | partial fractions of the whole chain, evaluated at the sampling instants |
//! | `channel` | [`Noise`], [`Offsets`], [`Quantisation`]: the faults of the samples of one channel |
//! | `plan` | [`HammerTest`]: excitation points, responses, averages; the checks of all arguments |
//! | `generate` | a checked plan becomes [`crate::record::Hit`]s |
//!
//! ```
//! use modalign::dof::Dof;
//! use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
//! use modalign::quantity::Quantity;
//! use modalign::synth::{Faults, HammerTest, LowPassOptions, Noise, Pulse, Truth, roving_hammer};
//!
//! let dof: Dof = "1:+Z".parse()?;
//! let shape = ModeShape::new([(dof.clone(), 1.0.into())]);
//! let mode = Mode::new(120.0, Some(0.02), shape, Scaling::UnitModalMass);
//! let model = ModalModel { modes: vec![mode], ..ModalModel::default() };
//! let test = HammerTest {
//!     truth: Truth::from_real_shapes(&model, &[dof.clone()], &[dof.clone()])?,
//!     hits: roving_hammer(&[dof.clone()], &[dof]),
//!     averages_per_point: 5,
//!     sampling_rate_hz: 2048.0,
//!     samples: 2048,
//!     pretrigger_s: 0.02,
//!     quantity: Quantity::Acceleration,
//!     pulse: Pulse { peak_n: 100.0, peak_spread: 0.2, duration_s: 2e-3, duration_spread: 0.1 },
//!     filter: LowPassOptions::default(),
//!     noise: Noise { force_snr_db: Some(70.0), response_snr_db: Some(50.0) },
//!     faults: Faults::default(),
//!     seed: 1,
//! };
//! let hits = test.generate()?;
//! assert_eq!(hits.len(), 5);
//! let peak = hits[0].force.si().into_iter().fold(0.0, f64::max);
//! assert!((80.0..125.0).contains(&peak));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! No function here estimates, writes a file, or draws an unseeded number. A synthetic test is
//! never called a measurement: [`HammerTest::truth_model`] carries the finding
//! [`crate::finding::Code::Synthetic`].

mod cascade;
mod channel;
mod error;
mod filter;
mod generate;
mod plan;
mod pulse;
mod truth;

#[cfg(test)]
mod channel_tests;
#[cfg(test)]
mod frf_tests;
#[cfg(test)]
mod plan_tests;
#[cfg(test)]
mod sampled_spectrum_tests;
#[cfg(test)]
mod test_systems;

pub use channel::{Noise, Offsets, Quantisation};
pub use error::SynthError;
pub use filter::{FilterKind, LowPass, LowPassOptions};
pub use plan::{Faults, HammerTest, HitPlan, SecondContact, roving_accelerometer, roving_hammer};
pub use pulse::{HalfSine, Pulse};
pub use truth::Truth;

//! modalign takes a hammer test and a theoretical model of the same machine and says, in numbers, how far apart they
//! are and why, and which of its parameters would bring them together.
//!
//! Files become records, FRFs, modes and geometry (`io`); records become FRFs with their variance (`signal`, `frf`);
//! FRFs become a [`modal::ModalModel`] of the test (`identify`); parameters become matrices and a
//! [`modal::ModalModel`] of the theory (`theory`); the two are paired and compared (`correlate`); the model is brought to the
//! test (`update`); results are written (`report`). Test and theory end in the same type, and nothing after it knows where a mode came from.
//!
//! # Where things are
//!
//! | type | what it is | module |
//! |---|---|---|
//! | [`Dof`] | point, axis and sign of a sensor or hit | `dof` |
//! | [`Finding`] | what the data says that is not a failure | `finding` |
//! | [`io::Format`], [`io::Source`] | a file format; an opened file read in blocks | `io` |
//! | [`record::Hit`], [`record::Recording`] | one hit: a force and its responses; hits read as they are needed | `record` |
//! | [`signal::Check`] | what one rule says of one channel of one hit | `signal` |
//! | [`frf::HammerOptions`] | how recorded hits are judged, windowed and averaged | `frf` |
//! | [`FrfSet`] | FRFs on one axis, with coherence and variance | `frf` |
//! | [`identify::PoleEstimator`] | a method that finds poles | `identify` |
//! | [`ModalModel`] | modes of a test or of a model | `modal` |
//! | [`theory::TheoreticalModel`] | a machine as matrices of its parameters | `theory` |
//! | [`theory::ExternalModel`] | a machine of given matrices, dense or sparse | `theory` |
//! | [`theory::ModelRoot`] | a distinct root with its modes, kinetic energy and class | `theory` |
//! | [`theory::ModelQuantity`] | a number that a model's theory gives beside its matrices | `theory` |
//! | [`theory::direct_receptance`] | FRFs straight from matrices | `theory` |
//! | [`theory::Sweep`] | roots followed over a parameter, with their crossings and veerings | `theory` |
//! | [`theory::DetailComparison`] | a model against simpler ones of the same machine | `theory` |
//! | [`theory::TimeResponse`] | a response over time in growing detail of its model | `theory` |
//! | [`theory::RootSensitivity`] | how a root depends on the parameters | `theory` |
//! | [`correlate::Observability`] | what a test could see of a root | `correlate` |
//! | [`correlate::Alignment`] | a test's frame fitted to that of the theory | `correlate` |
//! | [`correlate::measures::Measures`] | MAC, COMAC, scale factors, subspaces, orthogonality of the pairs | `correlate` |
//! | [`correlate::measures::FrfCorrelation`] | FRFs against FRFs, by function and by line | `correlate` |
//! | [`correlate::Placement`] | where to hit or put a sensor next | `correlate` |
//! | [`correlate::published::RootMatch`] | printed frequencies against a model | `correlate` |
//! | [`correlate::ComparisonTable`] | the table that a validation section prints | `correlate` |
//! | [`update::UpdateProblem`] | a model to be brought to measured modes | `update` |
//! | [`synth::HammerTest`] | a hammer test with known truth | `synth` |
//! | [`synth::population::PopulationSpec`] | a family from which hammer tests are drawn | `synth` |
//! | [`scene::Scene`] | a test, a model and the chain that compares them | `scene` |
//! | [`report::Renderer`] | blocks to text | `report` |
//!
//! # Who may use whom
//!
//! A test holds the code to this table.
//!
//! | stage | may use |
//! |---|---|
//! | `dof` | — |
//! | `quantity` | — |
//! | `axis` | — |
//! | `linalg` | — |
//! | `fourier` | — |
//! | `geometry` | dof linalg |
//! | `finding` | dof quantity |
//! | `record` | axis dof quantity |
//! | `modal` | axis dof finding linalg quantity |
//! | `signal` | axis dof finding fourier linalg quantity record |
//! | `frf` | axis dof finding fourier linalg modal quantity record signal |
//! | `io` | axis dof finding frf geometry linalg modal quantity record |
//! | `identify` | axis dof finding fourier frf linalg modal quantity |
//! | `theory` | axis dof finding frf geometry linalg modal quantity |
//! | `correlate` | axis dof finding frf geometry linalg modal quantity theory |
//! | `update` | axis correlate dof finding frf geometry linalg modal quantity theory |
//! | `synth` | axis dof finding fourier frf geometry linalg modal quantity record theory |
//! | `scene` | axis correlate dof finding fourier frf geometry identify io linalg modal quantity record signal synth theory update |
//! | `report` | axis correlate dof finding frf geometry identify io linalg modal quantity record scene signal synth theory update |
//! | `error` | correlate frf identify io scene signal synth theory update |
//! | `cli` | axis correlate dof error finding fourier frf geometry identify io linalg modal quantity record report scene signal synth theory update |
//!
//! `report` sees result types of every stage, never a computation.
//!
//! # Invariants
//!
//! - Only `io`, `scene` and `cli` touch files; only `cli` prints, parses arguments or exits.
//! - Nothing in the library reads the clock or the environment or draws an unseeded random number.
//! - No global state; parallel work runs in the caller's rayon pool; the same input gives the same bytes for any
//!   number of threads. Matrix kernels run on the calling thread, but for products that say otherwise.
//! - SI units, `f64` and `Complex64`. Sampling rate, unit, FRF kind and calibration have no defaults.
//! - e^{+iωt}; λ = −ζω_n + iω_n√(1−ζ²); H = Σ A/(iω−λ) + conj., residues of a receptance in m/(N s).
//! - Missing is `Option` to the end: an empty field or `null`, never 0.
//! - Two arrays meet through a degree of freedom, never by index.
//! - Bad input is an error with got and expected, never a panic.

#![cfg_attr(not(test), warn(clippy::unwrap_used))]

pub mod axis;
pub mod correlate;
pub mod dof;
pub mod error;
pub mod finding;
pub mod fourier;
pub mod frf;
pub mod geometry;
pub mod identify;
pub mod io;
pub mod linalg;
pub mod modal;
pub mod quantity;
pub mod record;
pub mod report;
pub mod scene;
pub mod signal;
pub mod synth;
pub mod theory;
pub mod update;

#[cfg(feature = "cli")]
pub mod cli;

pub use dof::Dof;
pub use finding::Finding;
pub use frf::FrfSet;
pub use modal::ModalModel;

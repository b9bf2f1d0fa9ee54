//! modalign compares the modes of a hammer or shaker test with those of a theoretical model of the
//! same machine: it quantifies their differences, explains them, and updates the model's
//! parameters.
//!
//! Files become records, FRFs, modes and geometry (`io`); records become FRFs with their variance
//! (`signal`, `frf`); FRFs become a [`modal::ModalModel`] of the test (`identify`); parameters
//! become matrices and a [`modal::ModalModel`] of the theory (`theory`); the two are paired and
//! compared (`correlate`); the model's parameters are updated to the test (`update`); results are
//! written (`report`). Modes of test and theory have the same type, and no later stage knows where
//! a mode came from.
//!
//! # A whole job
//!
//! What `modalign run` does, stage by stage: a hammer test of a bar is recorded (here computed from
//! a stated truth, so that the example needs no file), estimated, identified, and compared with
//! the bar's model.
//!
//! ```
//! use std::collections::BTreeMap;
//! use std::path::Path;
//!
//! use modalign::axis::Band;
//! use modalign::correlate::{PairOptions, Status};
//! use modalign::frf::{HammerOptions, evaluate_hammer_test};
//! use modalign::identify::{IdentifyOptions, identification};
//! use modalign::io::{Hints, HitFile, HitGrouping, group_hits, open_bytes};
//! use modalign::report::{Renderer, TableGroup, Terminal, comparison_blocks};
//! use modalign::scene::{NamedTest, Scene, compare_tests, hammer_test};
//! use modalign::scene::{load_model, load_synth, record};
//! use modalign::theory::ModeOptions;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Files to hits. `io::open_path` opens a file of a measurement system; its samples are read as
//! // they are needed.
//! let spec_path = Path::new("measurements/free-free-beam/synth.toml");
//! let spec = load_synth(spec_path)?;
//! let recorded = record(&spec, &hammer_test(&spec, spec_path)?, spec_path)?;
//! let hints = Hints { path: "hits.uff".to_owned(), ..Hints::default() };
//! let source = open_bytes(recorded.uff, &hints)?;
//! let mut hits = group_hits(vec![HitFile::new(source)], HitGrouping::Records, &[])?;
//!
//! // Hits to FRFs: each hit is checked, the accepted ones are averaged, with variance and
//! // coherence.
//! let estimated = evaluate_hammer_test(&mut hits.recording, &HammerOptions::default())?;
//! let frfs = estimated.estimated.set;
//! assert_eq!(frfs.functions().len(), 11);
//!
//! // FRFs to modes. Each frequency has its standard deviation.
//! let options = IdentifyOptions {
//!     band: Some(Band::new(60.0, 3200.0)?),
//!     method: "circle".to_owned(),
//!     ..IdentifyOptions::default()
//! };
//! let test = identification(&frfs, &options)?.model;
//! assert_eq!(test.modes.len(), 6);
//!
//! // The model to modes, at the sensors of the test: the same type.
//! let scene = Scene::load(Path::new("measurements/free-free-beam"))?;
//! let model = load_model(Path::new("measurements/free-free-beam/model.toml"), &BTreeMap::new())?;
//! let theory = model.solve(&scene.sensors, &ModeOptions::default())?;
//!
//! // Both to the comparison table.
//! let named = NamedTest { name: "hammer", modes: &test, frfs: std::slice::from_ref(&frfs) };
//! let table = compare_tests(&theory.modes, &[named], &PairOptions::default())?.table;
//! let first = &table.rows[0].tests[0];
//! assert_eq!(first.status, Status::Paired);
//! assert!(first.mac.is_some_and(|mac| mac > 0.99));
//! assert!(first.error_percent.is_some_and(|error| error < -2.0));
//!
//! // And to text; `report::json` writes the same for programs.
//! let groups = [TableGroup { caption: "Bar", tests: &["hammer".to_owned()], notes: &[] }];
//! let text = Terminal { width: None }.render(&comparison_blocks(&table, &groups, &theory));
//! assert!(text.contains("paired"));
//! # Ok(())
//! # }
//! ```
//!
//! A scene says all of this in a file; [`scene::run`] does it.
//!
//! # Where to begin
//!
//! Implement the trait, if there is one, and add to the list:
//!
//! | to add | implement | list |
//! |---|---|---|
//! | a file format | [`io::Format`]; its source is an [`io::MemorySource`] or an [`io::Source`] | [`io::FORMATS`], and `READERS` in `tests/population/readers.rs` |
//! | a method of identification | [`identify::PoleEstimator`], and `Method` of `identify`, empty but for one that knows measurement runs | [`identify::ESTIMATORS`] |
//! | a machine | [`theory::TheoreticalModel`] | [`theory::BUILT_IN`] |
//! | an output of tables | [`report::Renderer`] | [`report::RENDERERS`] |
//! | a finding | - | [`finding::Code`] |
//!
//! The command line and its help offer what the lists contain.
//!
//! # Where things are
//!
//! | type | what it is | module |
//! |---|---|---|
//! | [`Dof`] | point, axis and sign of a sensor or hit | `dof` |
//! | [`quantity::Quantity`], [`quantity::Unit`], [`quantity::FrfKind`] | what a channel measures, its factor to SI, the kind of an FRF | `quantity` |
//! | [`axis::FrequencyAxis`], [`axis::TimeAxis`], [`axis::Band`] | evenly spaced axes, and a range of frequency | `axis` |
//! | [`geometry::Geometry`], [`geometry::Sensor`] | nodes and lines of a test; where a sensor or hit is on a model | `geometry` |
//! | [`Finding`] | an observation about the data that is not a failure | `finding` |
//! | [`io::Format`], [`io::Source`] | a file format; an opened file read in blocks | `io` |
//! | [`record::Hit`], [`record::Recording`] | one hit: a force and its responses; hits read as they are needed | `record` |
//! | [`signal::Check`] | the result of one rule for one channel of one hit | `signal` |
//! | [`frf::HammerOptions`] | how recorded hits are assessed, windowed and averaged | `frf` |
//! | [`FrfSet`] | FRFs on one axis, with coherence and variance | `frf` |
//! | [`identify::PoleEstimator`] | a method that finds poles | `identify` |
//! | [`ModalModel`] | modes of a test or of a model | `modal` |
//! | [`theory::TheoreticalModel`] | a machine as matrices of its parameters | `theory` |
//! | [`theory::ExternalModel`] | a machine of given matrices, dense or sparse | `theory` |
//! | [`theory::ModelRoot`] | a distinct root with its modes, kinetic energy and class | `theory` |
//! | [`theory::ModelQuantity`] | a number that a model's theory gives beside its matrices | `theory` |
//! | [`theory::direct_receptance`] | FRFs straight from matrices | `theory` |
//! | [`theory::Sweep`] | roots followed over a parameter, with their crossings and veerings | `theory` |
//! | [`theory::ModifiedModel`], [`theory::ModeChanges`] | a model with added parts; modes followed from a model to a changed one | `theory` |
//! | [`theory::DetailComparison`] | a model against simpler ones of the same machine | `theory` |
//! | [`theory::TimeResponse`] | a response over time in growing detail of its model | `theory` |
//! | [`theory::RootSensitivity`] | how a root depends on the parameters | `theory` |
//! | [`correlate::Observability`] | whether a test could detect a mode of the model | `correlate` |
//! | [`correlate::Alignment`] | a test's frame fitted to that of the theory | `correlate` |
//! | [`correlate::measures::Measures`] | MAC, COMAC, scale factors, subspaces, orthogonality of the pairs | `correlate` |
//! | [`correlate::measures::FrfCorrelation`] | FRFs against FRFs, by function and by line | `correlate` |
//! | [`correlate::Placement`] | where to hit or put a sensor next | `correlate` |
//! | [`correlate::SensorSet`] | the fewest sensors that separate the modes | `correlate` |
//! | [`correlate::published::RootMatch`] | printed frequencies against a model | `correlate` |
//! | [`correlate::ComparisonTable`] | the table that a validation section prints | `correlate` |
//! | [`update::UpdateProblem`] | a model whose parameters are updated to measured modes | `update` |
//! | [`update::Design`] | the least changes of parameters that meet targets of natural frequencies | `update` |
//! | [`synth::HammerTest`] | a hammer test with known truth | `synth` |
//! | [`scene::Scene`] | a test, a model and the chain that compares them | `scene` |
//! | [`scene::RowVerdict`] | a result compared with its baseline, row by row | `scene` |
//! | [`scene::Draft`] | a scene drafted from exported files | `scene` |
//! | [`scene::Observer`] | the receiver of progress reports of long work | `scene` |
//! | [`scene::Figures`] | what the figures of a report show | `scene` |
//! | [`study::System`] | a linear system known by its modes, as studies draw from it | `study` |
//! | [`study::breakdown::Slice`] | where methods fail, over two factors | `study` |
//! | [`study::SceneNeeds`] | the modes, orders, methods, theory and parameters that a scene needs | `study` |
//! | [`report::Renderer`] | blocks to text | `report` |
//! | [`report::json::RunReport`] | a run as its HTML page shows it, [`report::report_page`] | `report` |
//! | [`error::Error`] | the error of callers that run several stages; every stage has an error type | `error` |
//!
//! Matrix decompositions and transforms are in `linalg` and `fourier`, the only places that name a
//! crate for them; the two form the package `modalign-numerics`, so that these generic crates are
//! compiled once. The command line is `cli`, behind the feature of that name.
//!
//! # Who may use whom
//!
//! A test holds the code to this table.
//!
//! | stage | may use |
//! |---|---|
//! | `dof` | — |
//! | `guide` | — |
//! | `quantity` | — |
//! | `printable` | — |
//! | `axis` | — |
//! | `linalg` | — |
//! | `fourier` | — |
//! | `geometry` | dof linalg |
//! | `finding` | dof quantity |
//! | `record` | axis dof quantity |
//! | `modal` | axis dof finding linalg quantity |
//! | `signal` | axis dof finding fourier linalg quantity record |
//! | `frf` | axis dof finding fourier linalg modal quantity record signal |
//! | `io` | axis dof finding frf geometry linalg modal printable quantity record |
//! | `identify` | axis dof finding fourier frf linalg modal quantity |
//! | `theory` | axis dof finding frf geometry linalg modal quantity |
//! | `correlate` | axis dof finding frf geometry linalg modal quantity theory |
//! | `update` | axis correlate dof finding frf geometry linalg modal quantity theory |
//! | `synth` | axis dof finding fourier modal quantity record |
//! | `scene` | axis correlate dof finding fourier frf geometry identify io linalg modal printable quantity record signal synth theory update |
//! | `study` | axis correlate dof finding fourier frf geometry identify io linalg modal printable quantity record scene signal synth theory update |
//! | `report` | axis correlate dof finding frf geometry identify io linalg modal printable quantity record scene signal study synth theory update |
//! | `error` | correlate frf identify io scene signal study synth theory update |
//! | `cli` | axis correlate dof error finding fourier frf geometry identify io linalg modal printable quantity record report scene signal study synth theory update |
//!
//! `report` sees result types of every stage, never a computation.
//!
//! # Invariants
//!
//! - Only `io`, `scene` and `cli` touch files; only `cli` prints, parses arguments or exits.
//! - Nothing in the library reads the clock or the environment or draws an unseeded random number.
//! - No global state but the files of `io` that are open or unfinished; parallel work runs in the
//!   caller's rayon pool; the same input gives the same bytes for any number of threads. Matrix
//!   kernels run on the calling thread, but for products that say otherwise.
//! - SI units, `f64` and `Complex64`. Sampling rate, unit, FRF kind and calibration have no
//!   defaults.
//! - e^{+iωt}; λ = −ζω_n + iω_n√(1−ζ²); H = Σ A/(iω−λ) + conj., residues of a receptance in m/(N
//!   s).
//! - Missing is `Option` to the end: an empty field or `null`, never 0.
//! - Two arrays meet through a degree of freedom, never by index.
//! - Bad input is an error with got and expected, never a panic.

#![cfg_attr(not(test), warn(clippy::unwrap_used))]

pub mod axis;
pub mod correlate;
pub mod dof;
pub mod error;
pub mod finding;
pub mod frf;
pub mod geometry;
pub mod guide;
pub mod identify;
pub mod io;
pub mod modal;
pub mod printable;
pub mod quantity;
pub mod record;
pub mod report;
pub mod scene;
pub mod signal;
pub mod study;
pub mod synth;
pub mod theory;
pub mod update;

#[cfg(feature = "cli")]
pub mod cli;

pub use dof::Dof;
pub use finding::Finding;
pub use frf::FrfSet;
pub use modal::ModalModel;
#[doc(inline)]
pub use modalign_numerics::{fourier, linalg};

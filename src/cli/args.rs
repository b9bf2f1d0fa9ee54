//! The command line as typed.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::Code;
use crate::frf::Window;
use crate::identify::ESTIMATORS;
use crate::io::FORMATS;
use crate::quantity::{FrfUnit, Unit};
use crate::report::Language;
use crate::scene::{BASE_CONFIGURATION, StatedBounds};
use crate::theory::SweepRange;

use super::color::ColorChoice;
use super::hint::nearest;
use super::study_args::StudyArgs;
use super::wrapping::{DEFAULT_WIDTH, wrapped};

/// Compares a hammer test with a theoretical model of the same machine, and updates the model.
#[derive(Debug, Parser)]
#[command(
    name = "modalign",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    after_help = "Examples:\n  modalign inspect hits.uff                   # what a file holds\n  modalign new bar hits.uff --model beam      # drafts the folder bar: a scene and a model\n  modalign run bar -o out                     # modes, comparison and report\nExit codes: 0 done; 1 done, but a limit is missed or data are lacking; 2 error.\nCOLUMNS sets the width of the screen."
)]
pub struct Cli {
    /// The verb.
    #[command(subcommand)]
    pub verb: Option<Verb>,
    /// Options of every verb.
    #[command(flatten)]
    pub global: Global,
}

/// Options of every verb.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Options of every verb")]
pub struct Global {
    /// Number of threads (default: one per core); results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
    /// Print errors alone on standard error, no findings.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Refuse a scene, model or spec that names files outside its folder. For those from a source
    /// that you do not trust.
    #[arg(long, global = true)]
    pub confine: bool,
    /// Maximum memory, such as 4G or 500M (default on Linux: three quarters of the machine's). A
    /// larger array in a file is an error; a computation that needs more ends the program.
    #[arg(long, global = true, value_name = "BYTES")]
    pub max_memory: Option<String>,
    /// Print the result as JSON instead of the screen.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print every table, column, note and finding; by default one screen. Files and JSON are
    /// always complete.
    #[arg(long, global = true)]
    pub full: bool,
    #[arg(long, global = true, value_name = "NAME", help = format_help())]
    pub format: Option<String>,
    /// Language of screens, reports and findings: English or Chinese. Definitions below tables, CSV
    /// and JSON are English.
    #[arg(long, global = true, value_name = "en|zh", default_value = "en", value_parser = language)]
    pub lang: Language,
    /// Colours of messages and verdicts.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: ColorChoice,
    /// Explain a finding by its code in brackets, such as few-lines: cause, consequence, remedy.
    #[arg(long, global = true, value_name = "CODE", value_parser = code)]
    pub explain: Option<Code>,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Run a scene: from recordings and model to the comparison table.
    Run(RunArgs),
    /// List what measurement files contain, and the next command.
    Inspect(InspectArgs),
    /// Convert measurement files to another format.
    Convert(ConvertArgs),
    /// Estimate FRFs from recorded hits.
    Frf(FrfArgs),
    /// Identify modes from FRFs.
    Identify(IdentifyArgs),
    /// Compute natural frequencies and mode shapes of a model.
    Theory(TheoryArgs),
    /// Pair the modes of a test with those of a model.
    Correlate(CorrelateArgs),
    /// Update the parameters of a model to a test, with standard deviations.
    Update(UpdateArgs),
    /// Compute a synthetic hammer test whose true modes are known.
    Synth(SynthArgs),
    /// Study the methods of identification: time, error and limits.
    Study(StudyArgs),
    /// Rebuild the HTML report of a finished run.
    Report(ReportArgs),
    /// Check a result against limits or an earlier result; exit code 1 when one is missed.
    Check(CheckArgs),
    /// Draft a commented scene from exported measurement files.
    New(NewArgs),
    /// Print the completion script of a shell.
    Completions(CompletionsArgs),
    /// Print the manual page, or write the pages of all verbs.
    Man(ManArgs),
}

impl Verb {
    /// The scenes, models and specs that the arguments name, which may name files themselves.
    pub fn scenes_and_models(&self) -> Vec<&Path> {
        let named: Vec<&PathBuf> = match self {
            Verb::Run(args) => vec![&args.scene],
            Verb::Convert(args) => args.inputs.iter().collect(),
            Verb::Frf(args) => args.inputs.iter().collect(),
            Verb::Theory(args) => vec![&args.model],
            Verb::Correlate(args) => args.test.iter().chain(&args.theory).collect(),
            Verb::Update(args) => vec![&args.scene],
            Verb::Synth(args) => vec![&args.spec],
            Verb::Study(args) => vec![args.study.path()],
            Verb::Check(args) => args.against.iter().collect(),
            Verb::New(args) => args.model.iter().collect(),
            Verb::Inspect(_)
            | Verb::Identify(_)
            | Verb::Report(_)
            | Verb::Completions(_)
            | Verb::Man(_) => Vec::new(),
        };
        named.into_iter().map(PathBuf::as_path).collect()
    }
}

/// `run`.
#[derive(Debug, Args)]
#[command(
    after_help = "Limits in scene.toml, of which a missed one is exit code 1:\n  [limits]\n  max_frequency_error_percent = 5    # of paired modes\n  min_mac = 0.9                      # of paired modes\n  max_missed = 0                     # model modes that the test should have shown\nExample:\n  modalign run measurements/cycloid-ball -o out"
)]
pub struct RunArgs {
    /// The scene: its folder, or its TOML file.
    pub scene: PathBuf,
    /// Use the tests and the model of this [[configuration]] of the scene; by default those outside
    /// every configuration.
    #[arg(long, value_name = "NAME", default_value = BASE_CONFIGURATION, hide_default_value = true)]
    pub configuration: String,
    /// Write report.html, tables, modes and FRFs into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Use the intact part of a damaged file instead of stopping; the exit code is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign report out --lang zh")]
pub struct ReportArgs {
    /// The folder of `run -o`. Results of `update -o` and `study ... -o` in the same folder are
    /// included.
    pub folder: PathBuf,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long)]
    pub png: bool,
}

/// `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign inspect hits.uff model.unv --json")]
pub struct InspectArgs {
    /// Measurement files: recordings, FRFs, modes or geometry.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// No effect here: the intact part of a damaged file is always listed, and the exit code is 1.
    #[arg(long)]
    pub partial: bool,
}

/// `convert`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign convert wing.unv -o wing.h5")]
pub struct ConvertArgs {
    /// Measurement files, joined in this order; or a scene, for the files of its first test.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// The file to write; its extension selects the format (.uff .unv .h5 .mat .npz .csv .json).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Write numbers as text: universal dataset 58 instead of the binary 58b.
    #[arg(long)]
    pub text: bool,
    /// Write numbers with 32 bits; by default as the input has them.
    #[arg(long, conflicts_with = "double")]
    pub single: bool,
    /// Write numbers with 64 bits; by default as the input has them.
    #[arg(long)]
    pub double: bool,
    /// No effect here: the intact part of a damaged file is always written, and the exit code is 1.
    #[arg(long)]
    pub partial: bool,
}

/// `frf`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  modalign frf hits.uff --force-window 0.02 --reject 3 -o frfs.h5"
)]
pub struct FrfArgs {
    /// Recordings of hits, or a scene, for the recordings of its first test.
    #[arg(required_unless_present = "watch")]
    pub inputs: Vec<PathBuf>,
    /// Watch this folder during a measurement: print after each new recording which points to hit
    /// again. All recordings of the folder count, in the order of their times. Ctrl-C ends it.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["inputs", "output", "accept", "reject"])]
    pub watch: Option<PathBuf>,
    /// Write the FRFs to this file; its extension selects the format (.uff .h5 .mat .npz .csv).
    /// HDF5 alone keeps everything.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// FRF estimator: h1 (noise on the response), h2 (noise on the force) or hv (noise on both); by
    /// default h1, or that of the scene.
    #[arg(long, value_name = "NAME")]
    pub estimator: Option<String>,
    /// Excitation: hammer, or a shaker with random or sine, whose records are averaged in blocks.
    /// By default hammer.
    #[arg(long, value_name = "hammer|random|sine")]
    pub excitation: Option<String>,
    /// With --excitation random or sine: length of a block in s; by default for about 16 blocks.
    #[arg(long, value_name = "SECONDS")]
    pub block_length: Option<f64>,
    /// Force window: time in s after the pulse beyond which the force is set to zero, such as 0.02;
    /// by default none.
    #[arg(long, value_name = "SECONDS")]
    pub force_window: Option<f64>,
    /// Exponential window on force and responses: its value at the end of the record, such as 0.01.
    /// auto, the default: a window where responses have not decayed to 1 %.
    #[arg(long, value_name = "auto|none|END")]
    pub response_window: Option<String>,
    /// Use these hits although a check rejects them, by number, such as 2,5.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub accept: Vec<usize>,
    /// Do not use these hits, by number, such as 2,5.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub reject: Vec<usize>,
    /// Use all hits but those of --reject; the checks only report.
    #[arg(long)]
    pub keep_all: bool,
    /// For hv: noise variance of the response over that of the force, in SI units; by default from
    /// the signal before the hits.
    #[arg(long, value_name = "RATIO")]
    pub noise_ratio: Option<f64>,
    /// Subtract from each channel its mean before the hit; by default where enough samples precede
    /// the hit.
    #[arg(long)]
    pub remove_offset: bool,
    /// How recordings form hits. records: each force record begins a hit. files: each file is a
    /// hit. trigger: a continuous record holds several hits. By default records, or trigger where
    /// every record shows several hits.
    #[arg(long, value_name = "records|files|trigger")]
    pub hits: Option<String>,
    /// With --hits trigger: force in N above the offset at which a hit begins, such as 20; by
    /// default estimated from the record.
    #[arg(long, value_name = "N")]
    pub trigger_level: Option<f64>,
    /// With --hits trigger: pre-trigger time of each hit in s; by default 2 % of its length.
    #[arg(long, value_name = "SECONDS")]
    pub pretrigger: Option<f64>,
    /// With --hits trigger: length of each hit in s; by default the shortest time between hits.
    #[arg(long, value_name = "SECONDS")]
    pub hit_length: Option<f64>,
    /// Excitation point and direction where the files do not state them, such as 1:+Z.
    #[arg(long, value_name = "DOF")]
    pub reference: Option<Dof>,
    /// Units of the channels of a hit in their order, where the files do not state them, such as
    /// N,m/s2.
    #[arg(long, value_name = "UNIT", value_delimiter = ',')]
    pub unit: Vec<Unit>,
    /// Use the intact part of a damaged file instead of stopping; the exit code is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `identify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign identify frfs.h5 --band 20:400 -o modes.json")]
pub struct IdentifyArgs {
    /// Files of FRFs, such as those of `modalign frf -o`.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Write the modes to this file (.json .csv .uff .unv .ufb .h5 .mat .npz).
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    #[arg(long, value_name = "NAME", help = method_help())]
    pub method: Option<String>,
    /// Frequency band LO:HI in Hz in which modes are searched, such as 20:400; by default the whole
    /// axis.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Highest model order of rfp, lsce, lscf and ml, 4 or more, such as 40; by default from the
    /// number of peaks.
    #[arg(long, value_name = "N")]
    pub order: Option<usize>,
    /// Take only the poles listed in this file, such as the one that the stabilization diagram of
    /// report.html saves (JSON, schema modalign-selection/1: frequency_hz, damping_ratio, order).
    #[arg(long, value_name = "FILE")]
    pub selection: Option<PathBuf>,
    /// Write the stabilization diagram, the poles of all model orders, to this file (.csv).
    #[arg(long, value_name = "FILE")]
    pub stabilization: Option<PathBuf>,
    /// Write the mode indicator functions to this file (.csv): sum of FRFs, NMIF, CMIF, MvMIF.
    #[arg(long, value_name = "FILE")]
    pub indicators: Option<PathBuf>,
    /// Use the FRFs of this excitation point only, such as 1:+Z. May be repeated.
    #[arg(long, value_name = "DOF")]
    pub reference: Vec<Dof>,
    /// Number of averages where the file does not state it, such as 3. With the coherence it gives
    /// the variance of the FRFs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub averages: Option<u32>,
    /// Window of the records where the file does not state it: none (also rectangular, uniform),
    /// hann, flat-top, exponential, force or force-and-exponential. hann and flat-top: ml corrects
    /// the damping for leakage. none: no leakage is reported. exponential: the added damping
    /// remains, as its decay rate is not known.
    #[arg(long, value_name = "NAME", value_parser = window)]
    pub window: Option<Window>,
    /// Unit of the FRFs where the file does not state it, such as (m/s2)/N.
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<FrfUnit>,
    /// Use the intact part of a damaged file instead of stopping; the exit code is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `theory`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign theory cycloid-ball/A --band 0:2000 --energies -o modes.json\n  modalign theory measurements/free-free-beam --modify mass:3=0.05 --modify youngs_modulus=2.05e11\n  modalign theory torsional-planetary --target \"f1 > 1800\" --within k_s=4e8:9e8"
)]
pub struct TheoryArgs {
    /// A model.toml; a scene, for its model and sensors; a file of finished modes; or a built-in
    /// model: cycloid-ball, torsional-planetary, spider-reducer, helical-planetary, also with a
    /// parameter set (cycloid-ball/D).
    pub model: PathBuf,
    /// Write the modes to this file (.json .csv .uff .unv .ufb .h5 .mat .npz), or the figure of
    /// --sweep, --response, --compare or --energies (.svg).
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Use the model of this [[configuration]] of the scene.
    #[arg(long, value_name = "NAME", default_value = BASE_CONFIGURATION, hide_default_value = true)]
    pub configuration: String,
    /// Value of a parameter in its unit of the model, such as youngs_modulus=2.05e11. May be
    /// repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    pub settings: Vec<(String, f64)>,
    /// Modes in the band LO:HI in Hz only, such as 0:2000; by default all.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Compute complex modes with the full damping matrix. By default shapes are real, and damping
    /// ratios are first-order estimates.
    #[arg(long, conflicts_with_all = ["sweep", "response", "compare"])]
    pub damped: bool,
    /// Print the kinetic energy of each mode by body and its strain energy by spring, as fractions.
    #[arg(long)]
    pub energies: bool,
    /// Print the sensitivity of each natural frequency to each parameter: relative change of
    /// frequency over relative change of parameter.
    #[arg(long)]
    pub sensitivities: bool,
    /// Print the quantities of a built-in model by which statements of its publication are judged.
    #[arg(long)]
    pub quantities: bool,
    /// Vary a parameter from LO to HI in N values, track the modes by their shapes, and report
    /// crossings and veerings, such as k_s=1e8:1e9:8. Values have equal ratios where HI is ten
    /// times LO or more, else equal steps. May be repeated.
    #[arg(long, value_name = "NAME=LO:HI:N", value_parser = sweep)]
    pub sweep: Vec<(String, SweepRange)>,
    /// Compute the steady-state response over time with models of increasing detail, with cost and
    /// difference of each (helical-planetary only).
    #[arg(long, conflicts_with = "sweep")]
    pub response: bool,
    /// Compare models of increasing detail, and report the simplest with errors of frequency below
    /// PERCENT (1 without a value).
    #[arg(long, value_name = "PERCENT", value_parser = positive, num_args = 0..=1, default_missing_value = "1", conflicts_with_all = ["sweep", "response"])]
    pub compare: Option<f64>,
    /// Change the model and print its modes before and after: mass:POINT=KG or mass:DOF=KG,
    /// spring:DOF=N/m (to ground) or spring:DOF,DOF=N/m, damper:DOF=Ns/m or damper:DOF,DOF=Ns/m,
    /// NAME=VALUE or NAME*=FACTOR of a parameter. A DOF is that of a sensor (3:+Z) or a coordinate.
    /// All other results are those of the changed model. May be repeated.
    #[arg(long, value_name = "CHANGE", conflicts_with_all = ["sweep", "response", "compare"])]
    pub modify: Vec<String>,
    /// The update.json of this model, for 95 % intervals of the frequencies of --modify; by default
    /// the one beside MODEL.
    #[arg(long, value_name = "UPDATE.JSON", requires = "modify")]
    pub uncertainty: Option<PathBuf>,
    /// Find the smallest changes of parameters that meet a target in Hz: "f3 > 2600", "f3 < 2600",
    /// "f3 = 2600" or "f3 outside 2400:2600". May be repeated; all targets are met together.
    #[arg(long, value_name = "TARGET", conflicts_with_all = ["sweep", "response", "compare"])]
    pub target: Vec<String>,
    /// Bounds of a parameter that --target may change, such as k_s=4e8:9e8; by default those of
    /// [update], or half to twice its value. May be repeated.
    #[arg(long, value_name = "NAME=LO:HI", value_parser = within, requires = "target")]
    pub within: Vec<StatedBounds>,
    /// Parameters that --target may change; by default those of [update], or the stiffnesses.
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        requires = "target"
    )]
    pub free: Vec<String>,
    /// Use the intact part of a damaged file of finished modes instead of stopping; the exit code
    /// is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `correlate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign correlate --test modes.json --theory model.toml -o table.md\n  modalign correlate --test wing.unv --theory wing-model.unv --nearest-node 0.005 --measures\n  modalign correlate --test wing.unv                         # autoMAC, duplicates named\n  modalign correlate --test hammer.h5 --theory model-frfs.uff --band 20:400 --lines lines.csv"
)]
pub struct CorrelateArgs {
    /// Modes of the test: modes.json, or another file with mode shapes, such as universal dataset
    /// 55; or FRFs. May be repeated.
    #[arg(long, required = true)]
    pub test: Vec<PathBuf>,
    /// Modes of the model: a file as for --test, a model.toml, a built-in model, or a scene, for
    /// its model; FRFs where the test is FRFs. Without it each test is compared with itself
    /// (autoMAC).
    #[arg(long)]
    pub theory: Option<PathBuf>,
    /// Print further correlation measures, each with its definition: MAC and autoMAC matrices,
    /// FMAC, modal scale factors, COMAC, close modes as subspaces.
    #[arg(long, requires = "theory")]
    pub measures: bool,
    /// Print cross- and self-orthogonality with the mass matrix of the model, reduced to the
    /// sensors by guyan or serep. serep takes the paired modes, and the lowest others that the
    /// sensors distinguish.
    #[arg(long, value_name = "guyan|serep", requires = "theory")]
    pub orthogonality: Option<String>,
    /// Write the shapes of the test, expanded to all coordinates of the model, to this file (.json,
    /// or .uff for universal dataset 55): by the method of --orthogonality, by default serep.
    #[arg(long, value_name = "FILE", requires = "theory")]
    pub expand: Option<PathBuf>,
    /// Of FRFs: compare the band LO:HI in Hz only, such as 20:400; by default all common lines.
    #[arg(long, value_name = "LO:HI", value_parser = band, requires = "theory")]
    pub band: Option<Band>,
    /// Of FRFs: write the shape and amplitude correlation at each frequency line to this file
    /// (.csv).
    #[arg(long, value_name = "FILE", requires = "theory")]
    pub lines: Option<PathBuf>,
    /// A file of lines TEST,THEORY with the names of the same DOF in both, such as 3:+Z,103:+Z.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with = "nearest_node",
        requires = "theory"
    )]
    pub dof_map: Option<PathBuf>,
    /// Match DOFs by the nearest node within this distance in m, such as 0.005, instead of by name.
    #[arg(long, value_name = "METRES", value_parser = positive, requires = "theory")]
    pub nearest_node: Option<f64>,
    /// With --nearest-node: first rotate, translate and scale the points of the test onto those of
    /// the model, by the points in a file of lines TEST,THEORY, or without a file by the nearest
    /// ones. An error where a point is then farther off than METRES.
    #[arg(long, value_name = "FILE", num_args = 0..=1, requires = "nearest_node")]
    pub align: Option<Option<PathBuf>>,
    /// Reverse sensors whose sign is opposite to the model; by default a finding names them.
    #[arg(long, requires = "theory")]
    pub turn_reversed: bool,
    /// Length in m that rotations are multiplied by in a MAC with translations, such as 0.25.
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub rotation_length: Option<f64>,
    /// Write the table to this file (.md .csv .tex .txt .html .json). As CSV, several tables have a
    /// file each.
    #[arg(short, long, value_name = "TABLE")]
    pub output: Option<PathBuf>,
    /// Maximum frequency error of a pair, as a fraction of the model's frequency; by default 0.2.
    #[arg(long, value_name = "FRACTION", requires = "theory")]
    pub max_frequency_error: Option<f64>,
    /// Minimum MAC of a pair; by default 0.5. A shape that mixes several of the model is paired
    /// from 0.6 times this on, as ambiguous.
    #[arg(long, value_name = "MAC", requires = "theory")]
    pub min_mac: Option<f64>,
    /// Definition of errors. theory, the default: (test − theory)/theory; test: (theory −
    /// test)/test.
    #[arg(long, value_name = "theory|test", requires = "theory")]
    pub error_reference: Option<String>,
    /// Caption of the first table.
    #[arg(long, value_name = "TEXT")]
    pub caption: Option<String>,
    /// Decimals of all numbers in the tables, 0 to 15; by default by column. CSV and JSON keep all
    /// digits.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=15))]
    pub digits: Option<u8>,
    /// Use the intact part of a damaged file instead of stopping; the exit code is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `update`.
#[derive(Debug, Args)]
#[command(
    after_help = "In scene.toml:\n  [update]\n  parameters = [\"mount\", \"bearing\"]\n  prior_std = 0.3            # 30 % around the model's values\n  frequency_floor = 0.001    # 0.1 % that no parameter mends\n  explain = true             # which single change explains the misfit\nExample:\n  modalign update measurements/machine -o out"
)]
pub struct UpdateArgs {
    /// The scene: its folder, or its TOML file. [update] states the parameters to update.
    pub scene: PathBuf,
    /// Write update.json, the updated model.toml and the tables into this folder. In the folder of
    /// `run -o`, report.html includes them.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Use the intact part of a damaged file instead of stopping; the exit code is then 1.
    #[arg(long)]
    pub partial: bool,
}

/// `synth`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign synth spec.toml -o hits.uff")]
pub struct SynthArgs {
    /// Description of the synthetic test (TOML), such as measurements/free-free-beam/synth.toml.
    pub spec: PathBuf,
    /// Write the recording to this file (.uff), and the true modes beside it (.modes.json).
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// `check`.
#[derive(Debug, Args)]
#[command(
    after_help = "In limits.toml, or in scene.toml:\n  [limits]\n  max_frequency_error_percent = 5    # of paired modes\n  min_mac = 0.9                      # of paired modes\n  max_missed = 0                     # model modes that the test should have shown\nExamples:\n  modalign check out/comparison.json --against limits.toml --junit check.xml\n  modalign check modes.json --against modes.json             # an earlier result as the baseline"
)]
pub struct CheckArgs {
    /// The result: comparison.json, modes.json or update.json.
    pub result: PathBuf,
    /// Required: a TOML file with [limits], such as a scene, for comparison.json and modes.json; or
    /// an earlier result of the same kind as the baseline, which update.json needs.
    #[arg(long, value_name = "BASELINE")]
    pub against: Option<PathBuf>,
    /// Maximum change of a frequency from the baseline in %; by default from the standard
    /// deviations of both, or 0.05 without them.
    #[arg(long, value_name = "PERCENT", value_parser = positive)]
    pub frequency_percent: Option<f64>,
    /// Maximum change of a damping ratio from the baseline in %; by default from the standard
    /// deviations of both, or 5 without them.
    #[arg(long, value_name = "PERCENT", value_parser = positive)]
    pub damping_percent: Option<f64>,
    /// Maximum 1 − MAC of a shape with that of baseline modes, or maximum change of MAC from a
    /// baseline comparison; by default from the uncertainty of the shapes, or 0.01 without it.
    #[arg(long, value_name = "MAC", value_parser = fraction)]
    pub mac: Option<f64>,
    /// Probability that the check fails although result and baseline differ by their uncertainties
    /// alone.
    #[arg(long, alias = "false-alarm-probability", value_name = "PROBABILITY", value_parser = probability, default_value = "0.01")]
    pub false_refusals: f64,
    /// Write the verdicts as JUnit XML for a CI server.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// `new`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign new beam hits.uff --model model.toml")]
pub struct NewArgs {
    /// The folder of the new scene; existing files are never overwritten.
    pub folder: PathBuf,
    /// Exported files: recorded hits, FRFs or modes.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// The model: a model.toml, a file of finished modes, or a built-in model. beam
    /// (Euler-Bernoulli beam) and lumped (masses and springs) write a model.toml to complete.
    #[arg(long)]
    pub model: Option<PathBuf>,
    /// Response point and direction where the files do not state them, such as 1:+Z: one for all
    /// files, or one for each file in their order (1:+Z,2:+Z). For tables with several responses:
    /// one for each column.
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    pub response: Vec<Dof>,
    /// Excitation point and direction where the files do not state them, such as 2:+Z: one for all
    /// files, or one for each file in their order (2:+Z,3:+Z).
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    pub reference: Vec<Dof>,
    /// Units that the files do not state: of force and response, such as N,m/s2, or of FRFs, such
    /// as (m/s2)/N.
    #[arg(long, value_name = "UNIT", value_delimiter = ',')]
    pub unit: Vec<String>,
    /// Sampling rate in Hz of tables without a time column, such as 48000.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub sampling_rate: Option<f64>,
    /// Positions of the points: a file of lines POINT,X,Y,Z in m, such as 3,0.25,0,0.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Frequency band LO:HI in Hz in which modes are searched, such as 20:400; by default the whole
    /// axis.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Copy the files into raw/ of the folder; by default the scene refers to them where they are.
    #[arg(long)]
    pub copy: bool,
    /// Use the intact part of a damaged file instead of stopping; the scene states `partial`.
    #[arg(long)]
    pub partial: bool,
}

/// `completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  modalign completions bash > modalign.bash      # bash: to be sourced, or put among its completions"
)]
pub struct CompletionsArgs {
    /// The shell, such as bash or zsh.
    pub shell: Shell,
}

/// `man`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign man -o man1      # then: man man1/modalign-run.1")]
pub struct ManArgs {
    /// Write modalign.1 and a page for each verb, such as modalign-run.1, into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok();
    value
        .filter(|value| value.is_finite() && *value > 0.0)
        .ok_or_else(|| format!("got `{text}`, expected a number above 0"))
}

fn fraction(text: &str) -> Result<f64, String> {
    let value = positive(text).ok().filter(|value| *value < 1.0);
    value.ok_or_else(|| format!("got `{text}`, expected a number between 0 and 1"))
}

fn probability(text: &str) -> Result<f64, String> {
    let value = positive(text).ok().filter(|value| *value < 1.0);
    value.ok_or_else(|| format!("got `{text}`, expected a probability between 0 and 1"))
}

fn band(text: &str) -> Result<Band, String> {
    let expected = || format!("got band `{text}`, expected LO:HI in Hz");
    let (lo, hi) = text.split_once(':').ok_or_else(expected)?;
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| expected());
    Band::new(number(lo)?, number(hi)?).map_err(|error| error.to_string())
}

fn window(name: &str) -> Result<Window, String> {
    let unknown = || format!("got window `{name}`, expected {}", Window::names());
    Window::from_name(name).ok_or_else(unknown)
}

fn sweep(text: &str) -> Result<(String, SweepRange), String> {
    let expected = || format!("got sweep `{text}`, expected NAME=LO:HI:N");
    let (name, range) = text.split_once('=').ok_or_else(expected)?;
    let parts: Vec<&str> = range.split(':').map(str::trim).collect();
    let [lower, upper, count] = parts[..] else {
        return Err(expected());
    };
    let number = |part: &str| part.parse::<f64>().map_err(|_| expected());
    Ok((
        name.trim().to_owned(),
        SweepRange {
            lower: number(lower)?,
            upper: number(upper)?,
            count: count.parse().map_err(|_| expected())?,
        },
    ))
}

fn within(text: &str) -> Result<StatedBounds, String> {
    let expected = || format!("got bounds `{text}`, expected NAME=LO:HI with LO below HI");
    let (name, range) = text.split_once('=').ok_or_else(expected)?;
    let (lower, upper) = range.split_once(':').ok_or_else(expected)?;
    let number = |part: &str| part.trim().parse::<f64>().map_err(|_| expected());
    let bounds = StatedBounds {
        name: name.trim().to_owned(),
        lower: number(lower)?,
        upper: number(upper)?,
    };
    let is_range = bounds.lower < bounds.upper && bounds.upper.is_finite();
    is_range.then_some(bounds).ok_or_else(expected)
}

fn setting(text: &str) -> Result<(String, f64), String> {
    let expected = || format!("got `{text}`, expected NAME=VALUE");
    let (name, value) = text.split_once('=').ok_or_else(expected)?;
    Ok((
        name.trim().to_owned(),
        value.trim().parse().map_err(|_| expected())?,
    ))
}

fn language(text: &str) -> Result<Language, String> {
    Language::from_name(text).ok_or_else(|| format!("got `{text}`, expected en or zh"))
}

fn code(text: &str) -> Result<Code, String> {
    // As findings print it.
    let text = text.trim_start_matches('[').trim_end_matches(']');
    let found = Code::ALL.iter().copied().find(|code| code.name() == text);
    found.ok_or_else(|| {
        let mut all: Vec<String> = Code::ALL.iter().map(|code| code.name()).collect();
        all.sort_unstable();
        let near = nearest(text, all.iter().map(String::as_str));
        match near {
            Some(near) => format!("got code `{text}`; did you mean `{near}`?"),
            None => {
                let list = wrapped(&all.join(" "), DEFAULT_WIDTH);
                format!("got code `{text}`, expected one of\n{list}")
            }
        }
    })
}

fn method_help() -> String {
    let names: Vec<&str> = ESTIMATORS.iter().map(|entry| entry.name).collect();
    format!(
        "Method: one of {}; auto, the default, is ml (maximum likelihood); polymax is lscf",
        names.join(", ")
    )
}

fn format_help() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name()).collect();
    format!(
        "Format of every input; by default detected from its content ({})",
        names.join(", ")
    )
}

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

/// Correlates a hammer test with a theoretical model of the same machine.
#[derive(Debug, Parser)]
#[command(
    name = "modalign",
    version,
    propagate_version = true,
    arg_required_else_help = true
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
pub struct Global {
    /// Number of threads (default: one per core); results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
    /// No findings on standard error; errors stay.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Refuse a scene, model or spec that names files outside its folder: for one from elsewhere.
    #[arg(long, global = true)]
    pub confine: bool,
    /// Most memory that the program takes, such as 4G or 500M (default: three quarters of the
    /// machine's, on Linux). An array of a file that needs more is an error; other work that does
    /// ends the program.
    #[arg(long, global = true, value_name = "BYTES")]
    pub max_memory: Option<String>,
    /// The result as JSON on standard output.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print every table, column, note and finding; by default what fits on a screen. Files and
    /// JSON always have everything.
    #[arg(long, global = true)]
    pub full: bool,
    #[arg(long, global = true, value_name = "NAME", help = format_help())]
    pub format: Option<String>,
    /// Captions and headings of tables and findings in English or Chinese; definitions below the
    /// tables, CSV and JSON stay English.
    #[arg(long, global = true, value_name = "en|zh", default_value = "en", value_parser = language)]
    pub lang: Language,
    /// Colours of words in messages and verdicts; auto: on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: ColorChoice,
    /// Explain the code of a finding.
    #[arg(long, global = true, value_name = "CODE", value_parser = code)]
    pub explain: Option<Code>,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Run a scene: recordings and model to the comparison table.
    Run(RunArgs),
    /// List the contents of files, from their headers.
    Inspect(InspectArgs),
    /// Write what files hold in another format.
    Convert(ConvertArgs),
    /// Estimate FRFs from recorded hits.
    Frf(FrfArgs),
    /// Identify modes from FRFs.
    Identify(IdentifyArgs),
    /// Natural frequencies and shapes of a model.
    Theory(TheoryArgs),
    /// Pair the modes of a test with those of a model.
    Correlate(CorrelateArgs),
    /// Update a model's parameters to a test: values with standard deviations, and which parameters
    /// the test determines.
    Update(UpdateArgs),
    /// Make a synthetic hammer test with its truth.
    Synth(SynthArgs),
    /// Study the methods: how fast and exact they are, and where they fail.
    Study(StudyArgs),
    /// Rebuild the HTML report of a finished run.
    Report(ReportArgs),
    /// Check a result against limits or a baseline; the exit code says whether all are met.
    Check(CheckArgs),
    /// Draft a commented scene from exported files.
    New(NewArgs),
    /// Print a script that completes this command line in a shell.
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
#[command(after_help = "Example:\n  modalign run measurements/cycloid-ball -o out")]
pub struct RunArgs {
    /// A scene's folder or its scene.toml.
    pub scene: PathBuf,
    /// The tests and the model of this [[configuration]]; those of no configuration where not
    /// stated.
    #[arg(long, value_name = "NAME", default_value = BASE_CONFIGURATION, hide_default_value = true)]
    pub configuration: String,
    /// Write tables, modes, FRFs, recordings and the HTML report into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write every figure as PNG, too, 300 dots to the inch (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Continue with the good part of a partly bad file.
    #[arg(long)]
    pub partial: bool,
}

/// `report`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign report out --lang zh")]
pub struct ReportArgs {
    /// The folder that `run -o` wrote; what `update -o` and `study … -o` put into it is in the
    /// report.
    pub folder: PathBuf,
    /// Write every figure as PNG, too, 300 dots to the inch (needs a build with `--features png`).
    #[arg(long)]
    pub png: bool,
}

/// `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign inspect hits.uff model.unv --json")]
pub struct InspectArgs {
    /// Files of any known format.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Continue with the good part of a partly bad file. It is listed without this too; the exit
    /// code is 1 either way.
    #[arg(long)]
    pub partial: bool,
}

/// `convert`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign convert wing.unv -o wing.h5")]
pub struct ConvertArgs {
    /// Files of any known format, put together in this order; or one scene, whose first test's
    /// files are meant as it describes them.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Write here; the extension says the format (.uff .unv .h5 .mat .npz .csv .json).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Numbers as text, where the format has text and bytes (universal file dataset 58 instead of
    /// 58b).
    #[arg(long)]
    pub text: bool,
    /// Numbers of 32 bits, whatever they were.
    #[arg(long, conflicts_with = "double")]
    pub single: bool,
    /// Numbers of 64 bits, whatever they were.
    #[arg(long)]
    pub double: bool,
    /// Continue with the good part of a partly bad file. It is written without this too; the exit
    /// code is 1 either way.
    #[arg(long)]
    pub partial: bool,
}

/// `frf`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  modalign frf hits.uff --force-window 0.02 --reject 3 -o frfs.h5"
)]
pub struct FrfArgs {
    /// Recordings, or one scene whose tests describe them.
    #[arg(required_unless_present = "watch")]
    pub inputs: Vec<PathBuf>,
    /// Watch this folder while a test is measured: after each new or changed file print what to
    /// repeat before you leave, of all its recordings in the order of their times, until Ctrl-C.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["inputs", "output", "accept", "reject"])]
    pub watch: Option<PathBuf>,
    /// Write the FRFs here; the extension says the format (.uff .h5 .mat .npz .csv). HDF5 is
    /// complete.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// h1, h2 or hv.
    #[arg(long, value_name = "NAME")]
    pub estimator: Option<String>,
    /// What excites: hammer; random or sine, averaged over blocks of the records.
    #[arg(long, value_name = "hammer|random|sine")]
    pub excitation: Option<String>,
    /// With --excitation random or sine: length of a block, s; by default for some 16 blocks.
    #[arg(long, value_name = "SECONDS")]
    pub block_length: Option<f64>,
    /// Force window: seconds kept after the pulse, the rest is set to zero.
    #[arg(long, value_name = "SECONDS")]
    pub force_window: Option<f64>,
    /// Exponential window on force and response: its value at the record's end, e.g. 0.01; auto:
    /// where the responses have not decayed to 1 %.
    #[arg(long, value_name = "auto|none|END")]
    pub response_window: Option<String>,
    /// Hits that are used whatever the rules say, by number: 2,5.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub accept: Vec<usize>,
    /// Hits that are not used whatever the rules say.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub reject: Vec<usize>,
    /// Assess the hits, but use all that --reject does not name.
    #[arg(long)]
    pub keep_all: bool,
    /// Response over force noise variance for hv, in SI units.
    #[arg(long, value_name = "RATIO")]
    pub noise_ratio: Option<f64>,
    /// Always subtract the mean before the hit from every channel; by default it is subtracted
    /// where the record has enough samples before the hit.
    #[arg(long)]
    pub remove_offset: bool,
    /// records: a further force record opens the next hit; files: each file is one hit; trigger:
    /// each record is continuous and holds several hits. By default records, or trigger where every
    /// record plainly holds several hits.
    #[arg(long, value_name = "records|files|trigger")]
    pub hits: Option<String>,
    /// With --hits trigger: force above its offset that starts a hit, N; by default estimated from
    /// the record.
    #[arg(long, value_name = "N")]
    pub trigger_level: Option<f64>,
    /// With --hits trigger: pre-trigger time of each hit, s; by default 2 % of the length.
    #[arg(long, value_name = "SECONDS")]
    pub pretrigger: Option<f64>,
    /// With --hits trigger: length of the record of each hit, s; by default the shortest time
    /// between hits.
    #[arg(long, value_name = "SECONDS")]
    pub hit_length: Option<f64>,
    /// Excitation DOF of files that do not name it.
    #[arg(long, value_name = "DOF")]
    pub reference: Option<Dof>,
    /// Units of the records of a hit in their order, such as N,m/s2, where the files do not state
    /// them.
    #[arg(long, value_name = "UNIT", value_delimiter = ',')]
    pub unit: Vec<Unit>,
    /// Continue with the good part of a partly bad file.
    #[arg(long)]
    pub partial: bool,
}

/// `identify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign identify frfs.h5 --band 20:400 -o modes.json")]
pub struct IdentifyArgs {
    /// FRF files.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Write the modes here (.json .csv .uff .unv .ufb .h5 .mat .npz).
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    #[arg(long, value_name = "NAME", help = method_help())]
    pub method: Option<String>,
    /// Band in Hz, LO:HI; the whole axis when not given.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Highest model order of rfp, lsce, lscf and ml, 4 or more; by default from the number of
    /// peaks.
    #[arg(long, value_name = "N")]
    pub order: Option<usize>,
    /// Take these poles of the method only: a file of the schema modalign-selection/1 with a
    /// list of {frequency_hz, damping_ratio, order}.
    #[arg(long, value_name = "FILE")]
    pub selection: Option<PathBuf>,
    /// Write the poles of all model orders (stabilization diagram) here (.csv).
    #[arg(long, value_name = "FILE")]
    pub stabilization: Option<PathBuf>,
    /// Write the mode indicator functions here (.csv): sum of FRFs, NMIF, CMIF, MvMIF.
    #[arg(long, value_name = "FILE")]
    pub indicators: Option<PathBuf>,
    /// Use these references only.
    #[arg(long, value_name = "DOF")]
    pub reference: Vec<Dof>,
    /// Number of averages of FRFs whose file does not state it; the variance of the FRFs follows
    /// from it and the coherence.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub averages: Option<u32>,
    /// Window of the records of FRFs whose file does not state it: none (also rectangular,
    /// uniform), hann, flat-top, exponential, force or force-and-exponential. Under hann and
    /// flat-top, ml corrects the damping for leakage. Under none, no leakage is suspected; that
    /// continuous random force without a window raises damping, too, is not reported. Damping that
    /// an exponential window adds is not removed, as its decay rate is not stated. The window that
    /// a file states takes precedence.
    #[arg(long, value_name = "NAME", value_parser = window)]
    pub window: Option<Window>,
    /// Unit of FRFs that do not state theirs, such as (m/s2)/N.
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<FrfUnit>,
    /// Continue with the good part of a partly bad file.
    #[arg(long)]
    pub partial: bool,
}

/// `theory`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign theory cycloid-ball/A --band 0:2000 --energies -o modes.json\n  modalign theory measurements/free-free-beam --modify mass:3=0.05 --modify youngs_modulus=2.05e11\n  modalign theory torsional-planetary --target \"f1 > 1800\" --within k_s=4e8:9e8"
)]
pub struct TheoryArgs {
    /// A built-in model (cycloid-ball, torsional-planetary, spider-reducer, helical-planetary; with
    /// a parameter set cycloid-ball/D), a model.toml, a scene whose model and sensors are meant, or
    /// a file of finished modes.
    pub model: PathBuf,
    /// Write the modes here (.json .csv .uff .unv .ufb .h5 .mat .npz), or the figure of --sweep,
    /// --response, --compare or --energies (.svg).
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// The model of this [[configuration]] of a scene.
    #[arg(long, value_name = "NAME", default_value = BASE_CONFIGURATION, hide_default_value = true)]
    pub configuration: String,
    /// Set a parameter; may be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting)]
    pub settings: Vec<(String, f64)>,
    /// Modes in this band only, LO:HI in Hz.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Solve with the full damping matrix: complex modes, in the table, the file and the JSON. By
    /// default damping ratios are of first order and shapes real.
    #[arg(long, conflicts_with_all = ["sweep", "response", "compare"])]
    pub damped: bool,
    /// Print the fraction of each mode's energy in every body and spring, or group of matrices.
    #[arg(long)]
    pub energies: bool,
    /// Print the sensitivity of each natural frequency to every parameter: relative change over
    /// relative change.
    #[arg(long)]
    pub sensitivities: bool,
    /// Print the quantities that the model's theory gives in addition to its modes.
    #[arg(long)]
    pub quantities: bool,
    /// Track the modes by their shapes over N values of a parameter and report where natural
    /// frequencies cross or veer; where HI is ten times LO or more in equal ratios, else in equal
    /// steps. May be repeated.
    #[arg(long, value_name = "NAME=LO:HI:N", value_parser = sweep)]
    pub sweep: Vec<(String, SweepRange)>,
    /// Compute the steady-state time response for models of increasing detail, with the cost of
    /// each and its difference from the most detailed (helical-planetary).
    #[arg(long, conflicts_with = "sweep")]
    pub response: bool,
    /// Compare models of increasing detail of the machine and report the simplest within an error,
    /// percent (1 when none is given).
    #[arg(long, value_name = "PERCENT", value_parser = positive, num_args = 0..=1, default_missing_value = "1", conflicts_with_all = ["sweep", "response"])]
    pub compare: Option<f64>,
    /// Change the model and print its modes before and after: mass:POINT=KG or mass:DOF=KG,
    /// spring:DOF=N/m (to ground) or spring:DOF,DOF=N/m, damper:DOF=Ns/m or damper:DOF,DOF=Ns/m,
    /// NAME=VALUE or NAME*=FACTOR of a parameter. A DOF is that of a sensor (3:+Z) or a coordinate.
    /// All other results are those of the changed model. May be repeated.
    #[arg(long, value_name = "CHANGE", conflicts_with_all = ["sweep", "response", "compare"])]
    pub modify: Vec<String>,
    /// Result of the update of this model, for the 95 % interval of each frequency of --modify; by
    /// default the update.json beside MODEL.
    #[arg(long, value_name = "UPDATE.JSON", requires = "modify")]
    pub uncertainty: Option<PathBuf>,
    /// Find the smallest changes of parameters that meet a target: "f3 > 2600", "f3 < 2600",
    /// "f3 = 2600" or "f3 outside 2400:2600", in Hz. May be repeated; all are met together.
    #[arg(long, value_name = "TARGET", conflicts_with_all = ["sweep", "response", "compare"])]
    pub target: Vec<String>,
    /// Bounds of a parameter that --target may change, in addition to the free ones; by default
    /// those of [update], or half to twice its value. May be repeated.
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
    /// Continue with the good part of a partly bad file of finished modes.
    #[arg(long)]
    pub partial: bool,
}

/// `correlate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign correlate --test modes.json --theory model.toml -o table.md\n  modalign correlate --test wing.unv --theory wing-model.unv --nearest-node 0.005 --measures\n  modalign correlate --test wing.unv                         # autoMAC, duplicates named\n  modalign correlate --test hammer.h5 --theory model-frfs.uff --band 20:400 --lines lines.csv"
)]
pub struct CorrelateArgs {
    /// Modes of the test: a modes.json, or a file with mode shapes such as universal datasets 55;
    /// or FRFs. May be repeated.
    #[arg(long, required = true)]
    pub test: Vec<PathBuf>,
    /// Modes of the model: a file as for --test, a model.toml, a built-in model, or a scene whose
    /// model is meant; FRFs where the test is FRFs. Without it each test is compared with itself
    /// (autoMAC).
    #[arg(long)]
    pub theory: Option<PathBuf>,
    /// Print further correlation measures, each with its definition: MAC and autoMAC matrices,
    /// FMAC, modal scale factors, COMAC, close modes as subspaces.
    #[arg(long, requires = "theory")]
    pub measures: bool,
    /// Print cross- and self-orthogonality with the model's mass matrix reduced to the sensors, by
    /// guyan or serep (through the paired modes and the lowest others, as many as the sensors
    /// distinguish).
    #[arg(long, value_name = "guyan|serep", requires = "theory")]
    pub orthogonality: Option<String>,
    /// Write the test's shapes, expanded to all coordinates of the model, here (.json, or .uff for
    /// universal dataset 55): by the method of --orthogonality, else by serep (a sum of the paired
    /// modes).
    #[arg(long, value_name = "FILE", requires = "theory")]
    pub expand: Option<PathBuf>,
    /// FRFs: compare the frequency lines in this band only, LO:HI in Hz.
    #[arg(long, value_name = "LO:HI", value_parser = band, requires = "theory")]
    pub band: Option<Band>,
    /// FRFs: write shape and amplitude criterion at every frequency line here (.csv).
    #[arg(long, value_name = "FILE", requires = "theory")]
    pub lines: Option<PathBuf>,
    /// A list of lines TEST,THEORY, where the degrees of freedom of both have other names.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with = "nearest_node",
        requires = "theory"
    )]
    pub dof_map: Option<PathBuf>,
    /// Match degrees of freedom by the nearest node within this distance, m, instead of by name.
    #[arg(long, value_name = "METRES", value_parser = positive, requires = "theory")]
    pub nearest_node: Option<f64>,
    /// With --nearest-node: first rotate, translate and scale the test's points onto the theory's;
    /// with a list of lines TEST,THEORY by these points, else by the nearest ones from several
    /// starts. Refused where a point remains farther off than METRES.
    #[arg(long, value_name = "FILE", num_args = 0..=1, requires = "nearest_node")]
    pub align: Option<Option<PathBuf>>,
    /// Reverse the sign of sensors whose polarity is opposite to the theory's; by default they are
    /// a finding.
    #[arg(long, requires = "theory")]
    pub turn_reversed: bool,
    /// Length that scales rotations in a MAC that also has translations, m.
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub rotation_length: Option<f64>,
    /// Write the table here (.md, .csv, .tex, .txt, .html or .json); as CSV those of several tests
    /// without --theory, or of FRFs, go to a file each.
    #[arg(short, long, value_name = "TABLE")]
    pub output: Option<PathBuf>,
    /// Largest frequency error of a pair, a fraction of the theory's frequency.
    #[arg(long, value_name = "FRACTION", requires = "theory")]
    pub max_frequency_error: Option<f64>,
    /// Smallest MAC of a pair; a mode with 0.6 of it of a mixed shape pairs too, as ambiguous.
    #[arg(long, value_name = "MAC", requires = "theory")]
    pub min_mac: Option<f64>,
    /// theory: (test − theory)/theory; test: (theory − test)/test.
    #[arg(long, value_name = "theory|test", requires = "theory")]
    pub error_reference: Option<String>,
    /// Caption of the first table.
    #[arg(long, value_name = "TEXT")]
    pub caption: Option<String>,
    /// Digits after the point of every number in the tables, 0 to 15; CSV and JSON keep them all.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=15))]
    pub digits: Option<u8>,
    /// Continue with the good part of a partly bad file.
    #[arg(long)]
    pub partial: bool,
}

/// `update`.
#[derive(Debug, Args)]
#[command(
    after_help = "In scene.toml:\n  [update]\n  parameters = [\"mount\", \"bearing\"]\n  prior_std = 0.3            # 30 % around the model's values\n  frequency_floor = 0.001    # 0.1 % that no parameter mends\n  explain = true             # which single change explains the misfit\nExample:\n  modalign update measurements/machine -o out"
)]
pub struct UpdateArgs {
    /// A scene's folder or its scene.toml; [update] says what is free.
    pub scene: PathBuf,
    /// Write update.json, the updated model.toml and the tables into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write every figure as PNG, too, 300 dots to the inch (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Continue with the good part of a partly bad file.
    #[arg(long)]
    pub partial: bool,
}

/// `synth`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign synth spec.toml -o hits.uff")]
pub struct SynthArgs {
    /// Spec of the synthetic test (TOML).
    pub spec: PathBuf,
    /// Write the recording here (.uff); the true modes are written next to it as .modes.json.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// `check`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  modalign check out/comparison.json --against limits.toml --junit check.xml\n  modalign check modes.json --against modes.json             # an earlier result as the baseline"
)]
pub struct CheckArgs {
    /// comparison.json, modes.json or update.json.
    pub result: PathBuf,
    /// A TOML file with [limits] (a scene or its folder will do), for comparison.json and
    /// modes.json; or an earlier result of the same kind, which update.json needs; required.
    #[arg(long, value_name = "BASELINE")]
    pub against: Option<PathBuf>,
    /// Largest change of every frequency against a baseline result; by default from the
    /// uncertainties of both, else 0.05.
    #[arg(long, value_name = "PERCENT", value_parser = positive)]
    pub frequency_percent: Option<f64>,
    /// Largest change of every damping ratio against a baseline result; by default from the
    /// uncertainties, else 5.
    #[arg(long, value_name = "PERCENT", value_parser = positive)]
    pub damping_percent: Option<f64>,
    /// Largest 1 − MAC of every shape against baseline modes, largest change of MAC against a
    /// baseline comparison; by default from the uncertainties of the shapes, else 0.01.
    #[arg(long, value_name = "MAC", value_parser = fraction)]
    pub mac: Option<f64>,
    /// False-alarm probability: how often a result that differs from the baseline only within the
    /// stated uncertainties may be refused.
    #[arg(long, value_name = "PROBABILITY", value_parser = probability, default_value = "0.01")]
    pub false_refusals: f64,
    /// Write the verdicts as JUnit XML for a CI server.
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// `new`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  modalign new beam hits.uff --model model.toml")]
pub struct NewArgs {
    /// The scene's folder; what is there is never written over.
    pub folder: PathBuf,
    /// Exported files: recorded hits, FRFs or modes of any known format.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// The theory: a model.toml, a file of finished modes, or a built-in model; beam or lumped
    /// writes a model.toml of that kind to complete.
    #[arg(long)]
    pub model: Option<PathBuf>,
    /// Response DOF of files that do not name it: one for all, or one for each file in their order,
    /// 1:+Z,2:+Z; of tables with several responses, one for each in the order of the columns.
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    pub response: Vec<Dof>,
    /// Excitation DOF of files that do not name it: one for all, or one for each file in their
    /// order, 2:+Z,3:+Z.
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    pub reference: Vec<Dof>,
    /// Units that the files do not state: of the force, of the response, or of FRFs, such as
    /// N,m/s2 or (m/s2)/N.
    #[arg(long, value_name = "UNIT", value_delimiter = ',')]
    pub unit: Vec<String>,
    /// Samples per second of tables without a time column.
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub sampling_rate: Option<f64>,
    /// Where the points are: a list of lines POINT,X,Y,Z in metres.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Band in Hz in which modes are searched, LO:HI.
    #[arg(long, value_name = "LO:HI", value_parser = band)]
    pub band: Option<Band>,
    /// Copy the files to raw/ of the folder; else the scene names them where they are.
    #[arg(long)]
    pub copy: bool,
    /// Continue with the good part of a partly bad file; the scene says so.
    #[arg(long)]
    pub partial: bool,
}

/// `completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  modalign completions bash > modalign.bash      # bash: to be sourced, or put among its completions"
)]
pub struct CompletionsArgs {
    /// The shell.
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

/// Characters in a line of the list of codes.
const CODE_LIST_WIDTH: usize = 100;

fn code(text: &str) -> Result<Code, String> {
    // As findings print it.
    let text = text.trim_start_matches('[').trim_end_matches(']');
    let found = Code::ALL.iter().copied().find(|code| code.name() == text);
    found.ok_or_else(|| {
        let all: Vec<String> = Code::ALL.iter().map(|code| code.name()).collect();
        let near = nearest(text, all.iter().map(String::as_str));
        match near {
            Some(near) => format!("got code `{text}`; did you mean `{near}`?"),
            None => {
                let list = textwrap::fill(&all.join(" "), CODE_LIST_WIDTH);
                format!("got code `{text}`, expected one of\n{list}")
            }
        }
    })
}

fn method_help() -> String {
    let names: Vec<&str> = ESTIMATORS.iter().map(|entry| entry.name).collect();
    format!(
        "auto (= ml) or one of {}; polymax is lscf, the polyreference LSCF",
        names.join(", ")
    )
}

fn format_help() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name()).collect();
    format!(
        "Read every input as this format instead of detecting it by content ({})",
        names.join(", ")
    )
}

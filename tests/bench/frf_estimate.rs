//! Speed and memory of FRF estimation on a large hammer test, beside a bare transform of as many
//! samples. Prints ratios; asserts nothing.
//!
//! `cargo bench --bench frf_estimate [-- CHANNELS HITS SAMPLES]` writes the test (200 channels, 10
//! hits, 65,536 single precision samples, 0.5 GB a file) into a temporary folder: dataset 58b hit
//! after hit (`hits.uff`) and channel after channel (`channels.uff`), and HDF5 hit after hit
//! (`hits.h5`). Of each it estimates H1 with coherence and variance (`estimate`), and the same with
//! every hit judged and the set checked (`judged`).
//!
//! The bare loop is a transform in double precision of the same samples, which are in memory as
//! they are stored: one thread, one plan, buffers reused. It runs in the same process before every
//! estimate, so that both meet the same load of the machine, and its samples are gone before the
//! estimate begins. What is printed is the median of the ratios, by the clock and by processor time
//! (of all threads, as the system counts it, in steps of 10 ms), the median throughput by the
//! clock, and the largest resident memory of the process during an estimate. Beside it the ratio to
//! a bare loop over one record again and again, which need not come from memory: it has less to do
//! than any program that is given samples.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use modalign::axis::TimeAxis;
use modalign::frf::{
    EstimateOptions, HammerOptions, ResponseWindow, Selection, estimate_recording,
    evaluate_hammer_test,
};
use modalign::io::{
    Block, FileRecording, Hints, HitFile, HitGrouping, MemorySource, WriteOptions, group_hits,
    hit_source, open_path, write_path,
};
use modalign::quantity::Quantity;
use modalign::record::{Channel, ChannelPlace, ChannelSegment, Hit, Recording, Role, Samples};
use modalign::signal::HitQualityLimits;

/// Runs of which the median counts.
const RUNS: usize = 5;
/// Sampling rate, Hz.
const RATE_HZ: f64 = 51_200.0;

/// Channels, hits and samples.
type Sizes = [usize; 3];

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["child-write", path, sizes @ ..] => write(&sizes_of(sizes), Path::new(path)),
        ["child-run", path, what, threads, sizes @ ..] => {
            run(&sizes_of(sizes), Path::new(path), what, threads);
        }
        sizes => all(&sizes_of(sizes)),
    }
}

fn sizes_of(words: &[&str]) -> Sizes {
    let of = |index: usize, default| {
        let stated = words.get(index).and_then(|text| text.parse().ok());
        stated.unwrap_or(default)
    };
    [of(0, 200), of(1, 10), of(2, 65_536)]
}

fn all(sizes: &Sizes) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [channels, hits, samples] = *sizes;
    println!("{channels} channels, {hits} hits, {samples} samples; median of {RUNS}");
    for name in ["hits.uff", "channels.uff", "hits.h5"] {
        let path = folder.path().join(name).display().to_string();
        let with = |words: &[&str]| {
            let arguments = words.iter().map(|word| (*word).to_owned());
            run_self(
                &arguments
                    .chain(sizes.map(|n| n.to_string()))
                    .collect::<Vec<_>>(),
            )
        };
        with(&["child-write", &path]);
        for what in ["estimate", "judged"] {
            for threads in ["1", "2"] {
                let text = with(&["child-run", &path, what, threads]);
                println!("{name:12} {what:8} {threads} thread(s) {}", text.trim_end());
            }
        }
        std::fs::remove_file(&path).expect("removed");
    }
}

fn run_self(arguments: &[String]) -> String {
    let this_program = std::env::current_exe().expect("this program");
    let output = Command::new(this_program)
        .args(arguments)
        .output()
        .expect("this program runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs the bare loop and the estimate in turns, in this process, and prints their rates.
fn run(sizes: &Sizes, path: &Path, what: &str, threads: &str) {
    let estimates = if what == "judged" { judged } else { estimate };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.parse().expect("a number of threads"))
        .build()
        .expect("threads");
    let bare = BareLoop::new(sizes);
    let mut rates = Vec::new();
    let mut ratios = [const { Vec::new() }; 3];
    let mut peak = 0;
    for _ in 0..RUNS {
        let samples = Records::of(path);
        let count = samples.count() as f64;
        let beside = timed(|| bare.run(samples.each()));
        let one = timed(|| bare.run(samples.first_again_and_again()));
        drop(samples);
        forget_peak();
        let estimation = timed(|| pool.install(|| estimates(path)));
        peak = peak_kibibytes().max(peak);
        rates.push(count / estimation.0 / 1e6);
        let of_bare = [
            beside.0 / estimation.0,
            beside.1 / estimation.1,
            one.0 / estimation.0,
        ];
        for (ratios, ratio) in ratios.iter_mut().zip(of_bare) {
            ratios.push(ratio);
        }
    }
    let [clock, processor, one] = ratios.map(median);
    println!(
        "{:7.1} Msamples/s, {clock:4.2} of bare by the clock, {processor:4.2} by processor time ({one:4.2} of one record), {:4.0} MB",
        median(rates),
        peak as f64 * 1.024e-3
    );
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Seconds by the clock and of processor time.
fn timed(run: impl FnOnce()) -> (f64, f64) {
    let (start, before) = (Instant::now(), processor_s());
    run();
    (start.elapsed().as_secs_f64(), processor_s() - before)
}

/// All records of a test, as they are stored.
struct Records(Vec<Vec<f32>>);

impl Records {
    /// Of this file.
    fn of(path: &Path) -> Self {
        let mut recording = open(path);
        let infos = recording.hits().to_vec();
        let mut records = Vec::new();
        for (hit, info) in infos.iter().enumerate() {
            let responses = (0..info.responses.len()).map(ChannelPlace::Response);
            for channel in std::iter::once(ChannelPlace::Force).chain(responses) {
                let mut samples = Samples::F32(Vec::new());
                let segment = ChannelSegment {
                    hit,
                    channel,
                    samples: 0..info.axis.len,
                };
                recording.read(&segment, &mut samples).expect("samples");
                match samples {
                    Samples::F32(values) => records.push(values),
                    Samples::F64(_) => panic!("single precision is what was written"),
                }
            }
        }
        Self(records)
    }

    fn count(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }

    fn each(&self) -> impl Iterator<Item = &[f32]> {
        self.0.iter().map(Vec::as_slice)
    }

    fn first_again_and_again(&self) -> impl Iterator<Item = &[f32]> {
        self.0.iter().map(|_| self.0[0].as_slice())
    }
}

/// A transform of records.
struct BareLoop(std::sync::Arc<dyn realfft::RealToComplex<f64>>);

impl BareLoop {
    fn new(sizes: &Sizes) -> Self {
        Self(realfft::RealFftPlanner::<f64>::new().plan_fft_forward(sizes[2]))
    }

    fn run<'a>(&self, records: impl Iterator<Item = &'a [f32]>) {
        let mut input = self.0.make_input_vec();
        let mut output = self.0.make_output_vec();
        let mut work = self.0.make_scratch_vec();
        for record in records {
            for (place, sample) in input.iter_mut().zip(std::hint::black_box(record)) {
                *place = f64::from(*sample);
            }
            self.0
                .process_with_scratch(&mut input, &mut output, &mut work)
                .expect("lengths of the plan");
            std::hint::black_box(&output);
        }
    }
}

/// A different decaying cosine for each channel, with noise.
fn write(sizes: &Sizes, path: &Path) {
    let [channels, hits, samples] = *sizes;
    let mut state = 1u64;
    let mut noise = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        1e-3 * ((state >> 40) as f32 / (1u64 << 24) as f32 - 0.5)
    };
    let before = samples / 50;
    let axis = TimeAxis {
        start_s: 0.0,
        step_s: 1.0 / RATE_HZ,
        len: samples,
    };
    let mut all = Vec::new();
    for hit in 0..hits {
        let height = 1.0 + 0.1 * hit as f32;
        let mut channel = |number: usize, role, quantity| {
            let value = |n: usize| {
                let t = n as f32 - before as f32;
                let clean = match role {
                    Role::Force if (0.0..25.0).contains(&t) => (t * 0.125_66).sin(),
                    Role::Response if t >= 0.0 => {
                        (t * (0.01 + 1e-3 * number as f32)).sin() * (-t * 2e-4).exp()
                    }
                    _ => 0.0,
                };
                height * clean + noise()
            };
            Channel {
                role,
                dof: format!("{}:+Z", number + 1).parse().expect("a point"),
                quantity,
                to_si: 1.0,
                samples: Samples::F32((0..samples).map(value).collect()),
            }
        };
        all.push(Hit {
            axis,
            force: channel(0, Role::Force, Quantity::Force),
            responses: (0..channels)
                .map(|number| channel(number, Role::Response, Quantity::Acceleration))
                .collect(),
            origin: String::new(),
        });
    }
    let mut source = hit_source(&all, "bench");
    drop(all);
    if path.file_name().is_some_and(|name| name == "channels.uff") {
        source = by_channel(source, channels + 1, hits);
    }
    write_path(path, &mut source, WriteOptions::default()).expect("written");
}

/// All records of the force, then all of the first response, and so on.
fn by_channel(mut source: MemorySource, channels: usize, hits: usize) -> MemorySource {
    let mut turned = MemorySource::default();
    for channel in 0..channels {
        for entry in (0..hits).map(|hit| hit * channels + channel) {
            let values = std::mem::replace(&mut source.blocks[entry], Block::F32(Vec::new()));
            turned.push(source.catalog.entries[entry].clone(), values, Vec::new());
        }
    }
    turned
}

fn estimate(path: &Path) {
    let mut recording = open(path);
    let selection = Selection {
        overloads: Some(HitQualityLimits::default()),
        ..Selection::all(recording.hits().len())
    };
    let estimate = estimate_recording(&mut recording, &selection, &EstimateOptions::default());
    std::hint::black_box(estimate.expect("FRFs"));
}

/// The same with every hit judged and the set checked.
fn judged(path: &Path) {
    let mut recording = open(path);
    let options = HammerOptions {
        response_window: ResponseWindow::Off,
        ..HammerOptions::default()
    };
    std::hint::black_box(evaluate_hammer_test(&mut recording, &options).expect("FRFs"));
}

fn open(path: &Path) -> FileRecording {
    let hints = Hints {
        path: path.display().to_string(),
        table: None,
    };
    let source = open_path(path, &hints, None).expect("the recording");
    let set = group_hits(vec![HitFile::new(source)], HitGrouping::Records, &[]);
    set.expect("hits").recording
}

/// Begins the largest resident memory anew, where the system can; else it holds the samples of the
/// bare loop.
fn forget_peak() {
    drop(std::fs::write("/proc/self/clear_refs", "5"));
}

/// `VmHWM` of this process; 0 where the system does not say.
fn peak_kibibytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}

/// Processor time of this process so far, s, user and system; not a number where the system does
/// not say.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field is a name in brackets; user and system time are fields 14 and 15, in
    // hundredths.
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = ticks.filter_map(|field| field.parse().ok()).collect();
    match ticks.as_slice() {
        [user, system] => (user + system) / 100.0,
        _ => f64::NAN,
    }
}

//! Speed and memory of FRF estimation on a large hammer test, beside a bare transform of as many samples. Prints ratios;
//! asserts nothing.
//!
//! `cargo bench --bench frf_estimate [-- CHANNELS HITS SAMPLES]` writes the test (200 channels, 10 hits, 65,536 single
//! precision samples, 0.5 GB in each format) into a temporary folder, estimates H1 with coherence and variance (`estimate`),
//! and the same with every hit judged and the set checked (`judged`), and prints the throughput in millions of samples per second, its ratio to the bare loop (`realfft`, double precision, one thread,
//! one plan, buffers reused) and the largest resident memory of a process that does nothing else.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use modalign::axis::TimeAxis;
use modalign::frf::{
    EstimateOptions, HammerOptions, ResponseWindow, Selection, estimate_recording, hammer,
};
use modalign::io::{
    FileRecording, Hints, HitFile, HitGrouping, WriteOptions, group_hits, hit_source, open_path,
    write_path,
};
use modalign::quantity::Quantity;
use modalign::record::{Channel, Hit, Recording, Role, Samples};
use modalign::signal::JudgeLimits;

/// Runs of which the fastest counts.
const RUNS: usize = 3;
/// Sampling rate, Hz.
const RATE_HZ: f64 = 51_200.0;

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|own| own != "--bench")
        .collect();
    match arguments.first().map(String::as_str) {
        Some("child-write") => write(&sizes(&arguments[2..]), Path::new(&arguments[1])),
        Some("child-estimate") => child(Path::new(&arguments[1]), &arguments[2], estimate),
        Some("child-judged") => child(Path::new(&arguments[1]), &arguments[2], judged),
        _ => all(&sizes(&arguments)),
    }
}

/// Channels, hits and samples.
fn sizes(arguments: &[String]) -> [usize; 3] {
    let of = |index: usize, default| {
        let stated = arguments.get(index).and_then(|text| text.parse().ok());
        stated.unwrap_or(default)
    };
    [of(0, 200), of(1, 10), of(2, 65_536)]
}

fn all(sizes: &[usize; 3]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [channels, hits, samples] = *sizes;
    let total = ((channels + 1) * hits * samples) as f64;
    let bare = bare_loop(sizes);
    println!("{channels} channels, {hits} hits, {samples} samples; fastest of {RUNS}");
    println!("bare transforms  {:8.1} Msamples/s", total / bare / 1e6);
    for name in ["hits.uff", "hits.h5"] {
        let path = folder.path().join(name);
        let mut arguments = vec!["child-write".to_owned(), path.display().to_string()];
        arguments.extend(sizes.iter().map(usize::to_string));
        run_self(&arguments);
        let runs = [
            ("estimate", "1"),
            ("estimate", "2"),
            ("judged", "1"),
            ("judged", "2"),
        ];
        for (what, threads) in runs {
            let arguments = [
                format!("child-{what}"),
                path.display().to_string(),
                threads.to_owned(),
            ];
            let text = run_self(&arguments);
            let numbers: Vec<f64> = text
                .split_whitespace()
                .filter_map(|word| word.parse().ok())
                .collect();
            let (seconds, kibibytes) = (numbers[0], numbers[1]);
            println!(
                "{name} {what:8} {threads} thread(s)  {:8.1} Msamples/s, {:5.2} of bare, {:5.0} MB",
                total / seconds / 1e6,
                bare / seconds,
                kibibytes * 1.024e-3
            );
        }
        std::fs::remove_file(&path).expect("removed");
    }
}

fn run_self(arguments: &[String]) -> String {
    let own = std::env::current_exe().expect("this program");
    let output = Command::new(own)
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

/// Seconds of transforming as many samples, from memory.
fn bare_loop(sizes: &[usize; 3]) -> f64 {
    let [channels, hits, samples] = *sizes;
    let plan = realfft::RealFftPlanner::<f64>::new().plan_fft_forward(samples);
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    let mut work = plan.make_scratch_vec();
    let record: Vec<f32> = (0..samples).map(|n| (n as f32 * 0.37).sin()).collect();
    fastest(|| {
        for _ in 0..(channels + 1) * hits {
            for (place, sample) in input.iter_mut().zip(&record) {
                *place = f64::from(*sample);
            }
            plan.process_with_scratch(&mut input, &mut output, &mut work)
                .expect("lengths of the plan");
            std::hint::black_box(&output);
        }
    })
}

fn fastest(mut run: impl FnMut()) -> f64 {
    let seconds = (0..RUNS).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    seconds.fold(f64::INFINITY, f64::min)
}

/// A decaying cosine of its own for each channel, with noise.
fn write(sizes: &[usize; 3], path: &Path) {
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
    write_path(path, &mut source, WriteOptions::default()).expect("written");
}

/// Estimates in this process; prints the seconds and the largest resident memory in KiB.
fn child(path: &Path, threads: &str, run: fn(&Path)) {
    let threads = threads.parse().expect("a number of threads");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    let seconds = fastest(|| pool.install(|| run(path)));
    println!("{seconds} {}", peak_kibibytes());
}

fn estimate(path: &Path) {
    let mut recording = open(path);
    let selection = Selection {
        overloads: Some(JudgeLimits::default()),
        ..Selection::all(recording.hits().len())
    };
    let own = estimate_recording(&mut recording, &selection, &EstimateOptions::default());
    std::hint::black_box(own.expect("FRFs"));
}

/// The same with every hit judged and the set checked.
fn judged(path: &Path) {
    let mut recording = open(path);
    let options = HammerOptions {
        response_window: ResponseWindow::Off,
        ..HammerOptions::default()
    };
    std::hint::black_box(hammer(&mut recording, &options).expect("FRFs"));
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

/// `VmHWM` of this process; 0 where the system does not say.
fn peak_kibibytes() -> u64 {
    let status = std::fs::read_to_string(PathBuf::from("/proc/self/status")).unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok())
        .unwrap_or(0)
}

//! Time of the identification of 40 known modes from FRFs of 8192 lines, stage by stage, beside the
//! LSCF of sdypy-EMA on the same FRFs. Prints times, ratios and how many of the modes each has
//! among its poles; asserts no timing.
//!
//! `cargo bench --bench identify [-- 900 7]`, with a number of functions for that case alone and
//! the seed of the draw. Two of the modes are 0.03 half-power bandwidths apart. The whole
//! identification is timed without and with stated variances and with the method `lscf`, with the
//! largest memory of the process meanwhile (as Linux counts it). Without a number of functions, 120
//! modes of 180 functions and a single FRF of 6401 lines follow.
//! sdypy-EMA is run with the Python that `MODALIGN_PYTHON` names, else `python3`, by
//! `tests/reference/sdypy_lscf.py`, with one BLAS thread, between runs of this program; without it
//! the bench prints our times alone. Times are those of the fastest run by the clock; where the
//! machine has other work, processor time (of all threads, as Linux counts it, in steps of 10 ms)
//! says more, and is printed beside them.
//!
//! sdypy-EMA takes every order from 1 to the highest. Our LSCF is timed at these (`every order`)
//! and at those that an identification looks at, some 20 from a sixth of the highest on (`20
//! orders`). An order is a number of poles with positive frequency in both. The conversion of the
//! FRFs to receptances with their noise is no part of an LSCF, and has a separate line.

use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use modalign::axis::{Band, FrequencyAxis};
use modalign::dof::Dof;
use modalign::frf::{FrfSet, Function, FunctionData};
use modalign::identify::stages::{Lines, residues};
use modalign::identify::{Identification, IdentifyOptions, identification};
use modalign::modal::Pole;
use modalign::quantity::FrfKind;
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Lines from 0 Hz.
const AXIS: FrequencyAxis = FrequencyAxis {
    start_hz: 0.0,
    step_hz: 0.25,
    len: 8194,
};
/// Modes that are spread over them, and their damping ratios.
const MODES: usize = 40;
const DAMPING: std::ops::Range<f64> = 0.001..0.003;
/// Distance of the closest two modes, half-power bandwidths.
const CLOSEST_BANDWIDTHS: f64 = 0.03;
/// Noise of every FRF over its root mean square: 60 dB.
const NOISE: f64 = 1e-3;
/// Highest orders.
const ORDERS: [usize; 2] = [60, 100];
/// Orders that an identification looks at.
const LOOKED_AT: usize = 20;

/// Time by the clock and of all threads, s.
#[derive(Clone, Copy)]
struct Time {
    clock: f64,
    processor: f64,
}

fn main() -> Result<(), Failure> {
    let mut numbers = std::env::args().filter_map(|word| word.parse::<usize>().ok());
    let only = numbers.next();
    let seed = numbers.next().unwrap_or(1) as u64;
    println!(
        "{MODES} modes, {} lines, {} cores; s by the clock (processor time), times over sdypy-EMA's",
        AXIS.len - 1,
        std::thread::available_parallelism()?
    );
    let draw = |outputs, references| Draw::new(MODES, AXIS, outputs, references, seed);
    for (outputs, references, runs) in [(90, 1, 5), (300, 3, 1)] {
        if only.is_none_or(|only| only == outputs * references) {
            case(&draw(outputs, references)?, runs)?;
        }
    }
    if only.is_none() {
        println!("120 modes, 180 functions of {} lines", AXIS.len - 1);
        whole(&Draw::new(120, AXIS, 60, 3, seed)?, 1, None)?;
        println!("1 function of 6401 lines, {MODES} modes");
        let axis = FrequencyAxis { len: 6401, ..AXIS };
        whole(&Draw::new(MODES, axis, 1, 1, seed)?, 1, None)?;
    }
    Ok(())
}

/// Modes and their FRFs with noise.
struct Draw {
    modes: Vec<Mode>,
    set: FrfSet,
    references: usize,
    band: Band,
}

impl Draw {
    fn new(
        modes: usize,
        axis: FrequencyAxis,
        outputs: usize,
        references: usize,
        seed: u64,
    ) -> Result<Self, Failure> {
        let top_hz = axis.hz(axis.len - 1);
        let modes = draw_modes(modes, top_hz, outputs, seed);
        let set = measured(&modes, axis, (outputs, references), seed + 1)?;
        let band = Band::new(10.0, top_hz)?;
        Ok(Self {
            modes,
            set,
            references,
            band,
        })
    }
}

fn case(draw: &Draw, runs: usize) -> Result<(), Failure> {
    let file = tempfile::NamedTempFile::new()?;
    write(&draw.set, file.path())?;
    println!("{} functions", draw.set.len());
    let mut peer = None;
    for order in ORDERS {
        let first = lscf(draw, (order, true, 1), runs)?;
        let competitor = sdypy(file.path(), order, runs);
        let again = lscf(draw, (order, true, 1), runs)?;
        match &competitor {
            Some((version, time, poles)) => println!(
                "order {order}: {version}, every order: {}; {} modes among its poles",
                text(*time, None),
                found(&draw.modes, poles)
            ),
            None => println!("order {order}: sdypy-EMA was not found"),
        }
        let over = competitor.map(|(_, time, _)| time);
        first
            .fastest(&again)
            .print("one reference, 1 thread ", over);
        if draw.references > 1 {
            let several = lscf(draw, (order, false, 2), runs)?;
            several.print(&format!("{} references, 2 threads", draw.references), over);
        }
        peer = peer.or(over);
    }
    for threads in [1, 2] {
        whole(draw, threads, peer)?;
    }
    Ok(())
}

/// Times of the stages of an LSCF.
struct Stages {
    receptances: Time,
    transforms: Time,
    products: Time,
    /// Eigenvalues of some 20 orders, and of all.
    some: Time,
    every: Time,
    found: usize,
}

fn lscf(
    draw: &Draw,
    (order, one_reference, threads): (usize, bool, usize),
    runs: usize,
) -> Result<Stages, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let lowest = order / 6;
    let stride = (order - lowest).div_ceil(LOOKED_AT);
    let some: Vec<usize> = (lowest..=order).step_by(stride).collect();
    let every: Vec<usize> = (1..=order).collect();
    pool.install(|| {
        let (receptances, lines) = timed(1, || Lines::new(&draw.set, draw.band, one_reference))?;
        let (transforms, of_lines) = timed(runs, || Ok::<_, Failure>(lines.transformed(order)))?;
        let (products, equations) = timed(runs, || of_lines.equations())?;
        let (some, _) = timed(runs, || equations.poles(&some))?;
        let (every, poles) = timed(runs, || equations.poles(&every))?;
        Ok(Stages {
            receptances,
            transforms,
            products,
            some,
            every,
            found: poles.last().map_or(0, |poles| found(&draw.modes, poles)),
        })
    })
}

impl Stages {
    fn fastest(&self, other: &Self) -> Self {
        let least = |a: Time, b: Time| if a.clock < b.clock { a } else { b };
        Self {
            receptances: least(self.receptances, other.receptances),
            transforms: least(self.transforms, other.transforms),
            products: least(self.products, other.products),
            some: least(self.some, other.some),
            every: least(self.every, other.every),
            found: self.found,
        }
    }

    fn print(&self, what: &str, over: Option<Time>) {
        let equations = sum(self.transforms, self.products);
        println!(
            "  {what}: every order {}; 20 orders {}; {} modes among the poles",
            text(sum(equations, self.every), over),
            text(sum(equations, self.some), over),
            self.found
        );
        println!(
            "    FFT {}, products {}, eigenvalues of every order {}, of 20 orders {}; receptances before {}",
            text(self.transforms, None),
            text(self.products, None),
            text(self.every, None),
            text(self.some, None),
            text(self.receptances, None)
        );
    }
}

/// The automatic identification without and with stated variances and by the LSCF, and the shares
/// of the first: the stages of its LSCF, which explains these data, and the residues once, the rest
/// refinement.
fn whole(draw: &Draw, threads: usize, over: Option<Time>) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let by = |method: &str| IdentifyOptions {
        band: Some(draw.band),
        method: method.to_owned(),
        ..IdentifyOptions::default()
    };
    let run = |what: &str, set: &FrfSet, method: &str| {
        let mib = reset_peak();
        let (time, result) = pool.install(|| timed(1, || identification(set, &by(method))))?;
        let poles: Vec<Complex64> = result.model.modes.iter().filter_map(pole).collect();
        println!(
            "  {what}, {threads} thread(s): {}; {} modes, {} of the {}; {:.0} MiB beside {mib:.0} before",
            text(time, over),
            poles.len(),
            found(&draw.modes, &poles),
            draw.modes.len(),
            status_mib("VmHWM:") - mib,
        );
        Ok::<_, Failure>((time, result, poles))
    };
    run("with stated variances", &with_variances(&draw.set)?, "ml")?;
    run("method lscf", &draw.set, "lscf")?;
    let (all, result, poles) = run("automatic identification", &draw.set, "ml")?;
    let stages = lscf(
        draw,
        (highest_order(&result), draw.references == 1, threads),
        1,
    )?;
    let shares = [stages.transforms, stages.products, stages.some];
    let (fit, ()) = pool.install(|| timed(1, || residues(&draw.set, draw.band, &poles)))?;
    let rest = |of: fn(&Time) -> f64| {
        let known = shares.iter().map(of).sum::<f64>();
        of(&all) - known - of(&fit)
    };
    let refinement = Time {
        clock: rest(|time| time.clock),
        processor: rest(|time| time.processor),
    };
    let [transforms, products, eigenvalues] = shares.map(|share| text(share, None));
    println!(
        "    FFT {transforms}, products {products}, eigenvalues {eigenvalues}, residues with receptances and noise {}, refinement and tests {}; receptances {}",
        text(fit, None),
        text(refinement, None),
        text(stages.receptances, None)
    );
    Ok(())
}

/// The same FRFs with the variance of their noise.
fn with_variances(set: &FrfSet) -> Result<FrfSet, Failure> {
    let mut stated = FrfSet::new(*set.axis());
    for (number, function) in set.functions().iter().enumerate() {
        let values = set.values(number).to_vec();
        let power = values.iter().map(Complex64::norm_sqr).sum::<f64>();
        let variance = NOISE.powi(2) * power / values.len() as f64;
        let data = FunctionData {
            variance: Some(vec![variance; values.len()]),
            values,
            ..FunctionData::default()
        };
        stated.push(function.clone(), data)?;
    }
    Ok(stated)
}

/// Forgets the largest memory of this process and returns what it holds, MiB.
fn reset_peak() -> f64 {
    // Where the system has no such file, the largest memory is that since the start.
    std::fs::write("/proc/self/clear_refs", "5").ok();
    status_mib("VmRSS:")
}

/// A row of the state of this process, MiB; NaN where the system has no such file.
fn status_mib(row: &str) -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let value = text.lines().find_map(|line| line.strip_prefix(row));
    let kib = value.and_then(|value| value.split_whitespace().next()?.parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib / 1024.0)
}

fn highest_order(result: &Identification) -> usize {
    let orders = result.stabilization.iter().map(|pole| pole.order);
    orders.max().unwrap_or(0)
}

fn pole(mode: &modalign::modal::Mode) -> Option<Complex64> {
    mode.pole().map(|pole| pole.lambda)
}

fn sum(a: Time, b: Time) -> Time {
    Time {
        clock: a.clock + b.clock,
        processor: a.processor + b.processor,
    }
}

fn text(time: Time, over: Option<Time>) -> String {
    let Time { clock, processor } = time;
    let times = over.map_or_else(String::new, |other| {
        format!(
            ", {:.1} times faster (processor {:.1})",
            other.clock / clock,
            other.processor / processor
        )
    });
    format!("{clock:.3} ({processor:.3}){times}")
}

/// The fastest run, its processor time the mean of all runs, and its result.
fn timed<T, E: Into<Failure>>(
    runs: usize,
    mut run: impl FnMut() -> Result<T, E>,
) -> Result<(Time, T), Failure> {
    let before = processor_s();
    let mut clock = f64::MAX;
    let mut result = None;
    for _ in 0..runs {
        let start = Instant::now();
        result = Some(run().map_err(Into::into)?);
        clock = clock.min(start.elapsed().as_secs_f64());
    }
    let processor = (processor_s() - before) / runs as f64;
    Ok((Time { clock, processor }, result.ok_or("one run at least")?))
}

/// Processor time of this process, s; NaN where the system has no such file.
fn processor_s() -> f64 {
    let read = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        let words: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
        let ticks = |place: usize| words.get(place)?.parse::<f64>().ok();
        Some((ticks(11)? + ticks(12)?) / 100.0)
    };
    read().unwrap_or(f64::NAN)
}

/// sdypy-EMA on the same FRFs: version, time and the poles of the highest order, rad/s.
fn sdypy(path: &Path, order: usize, runs: usize) -> Option<(String, Time, Vec<Complex64>)> {
    let python = std::env::var("MODALIGN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/sdypy_lscf.py");
    let numbers = [AXIS.step_hz, order as f64, runs as f64].map(|number| number.to_string());
    let output = Command::new(python)
        .arg(script)
        .arg(path)
        .args(numbers)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut lines = text.lines();
    let version = lines.next()?.to_owned();
    let pair = |line: &str, word: &str| {
        let mut numbers = line.strip_prefix(word)?.split_whitespace();
        let mut next = || numbers.next()?.parse::<f64>().ok();
        Some((next()?, next()?))
    };
    let (clock, processor) = pair(lines.next()?, "seconds")?;
    let poles = lines.filter_map(|line| pair(line, "pole"));
    let poles = poles.map(|(re, im)| Complex64::new(re, im)).collect();
    Some((version, Time { clock, processor }, poles))
}

/// Pole, rad/s, and shape of unit modal mass.
struct Mode {
    lambda: Complex64,
    shape: Vec<f64>,
}

fn draw_modes(count: usize, top_hz: f64, points: usize, seed: u64) -> Vec<Mode> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let spacing = top_hz / (count as f64 + 1.0);
    let mode = |number: usize| {
        let hz = spacing * (number as f64 + 1.0 + random.random_range(-0.2..0.2));
        Mode {
            lambda: Pole::from_frequency(hz, random.random_range(DAMPING)).lambda,
            shape: (0..points)
                .map(|_| random.random_range(-1.0..1.0))
                .collect(),
        }
    };
    let mut modes: Vec<Mode> = (0..count).map(mode).collect();
    let first = random.random_range(0..count - 1);
    let lambda = modes[first].lambda;
    let bandwidth = -2.0 * lambda.re;
    modes[first + 1].lambda = lambda + Complex64::new(0.0, CLOSEST_BANDWIDTHS * bandwidth);
    modes
}

/// Receptances with white noise, hit at the first of the points.
fn measured(
    modes: &[Mode],
    axis: FrequencyAxis,
    (outputs, references): (usize, usize),
    seed: u64,
) -> Result<FrfSet, Failure> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let course = |mode: &Mode| -> Vec<Complex64> {
        let residue = Complex64::new(0.0, 2.0 * mode.lambda.im).inv();
        let value = |k: usize| {
            let s = Complex64::new(0.0, axis.rad_s(k));
            residue / (s - mode.lambda) + residue.conj() / (s - mode.lambda.conj())
        };
        (0..axis.len).map(value).collect()
    };
    let courses: Vec<Vec<Complex64>> = modes.iter().map(course).collect();
    let dof = |point: usize| format!("{}:+Z", point + 1).parse::<Dof>();
    let mut set = FrfSet::new(axis);
    for reference in 0..references {
        for response in 0..outputs {
            let mut values = vec![Complex64::ZERO; axis.len];
            for (mode, course) in modes.iter().zip(&courses) {
                let factor = mode.shape[response] * mode.shape[reference];
                for (value, profile) in values.iter_mut().zip(course) {
                    *value += factor * profile;
                }
            }
            let power = values.iter().map(Complex64::norm_sqr).sum::<f64>();
            let noise = NOISE * (0.5 * power / axis.len as f64).sqrt();
            for value in &mut values {
                *value += noise * Complex64::new(normal(), normal());
            }
            let function = Function {
                response: dof(response)?,
                reference: dof(reference)?,
                kind: FrfKind::Receptance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values,
                ..FunctionData::default()
            };
            set.push(function, data)?;
        }
    }
    Ok(set)
}

/// Functions × lines for numpy.
fn write(set: &FrfSet, path: &Path) -> Result<(), Failure> {
    use npyz::WriterBuilder;
    let shape = [set.len() as u64, set.axis().len as u64];
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&shape)
        .writer(std::io::BufWriter::new(File::create(path)?))
        .begin_nd()?;
    for i in 0..set.len() {
        writer.extend(set.values(i).iter().copied())?;
    }
    Ok(writer.finish()?)
}

/// Modes that have a pole within half a decay rate.
fn found(modes: &[Mode], poles: &[Complex64]) -> usize {
    let near = |mode: &&Mode| {
        let apart = |pole: &Complex64| (pole - mode.lambda).norm();
        poles.iter().any(|pole| apart(pole) < -0.5 * mode.lambda.re)
    };
    modes.iter().filter(near).count()
}

//! Time of the identification of 40 known modes from FRFs of 8192 lines, stage by stage, beside the
//! LSCF of sdypy-EMA on the same FRFs. Prints times, ratios and how many of the modes each has
//! among its poles; asserts no timing.
//!
//! `cargo bench --bench identify [-- 90]`, with a number of functions for that case alone.
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

/// Lines above 0 Hz, and modes of 0.1 to 0.3 % damping that are spread over them.
const AXIS: FrequencyAxis = FrequencyAxis {
    start_hz: 0.0,
    step_hz: 0.25,
    len: 8194,
};
const MODES: usize = 40;
const DAMPING: std::ops::Range<f64> = 0.001..0.003;
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
    let only = std::env::args().find_map(|word| word.parse::<usize>().ok());
    println!(
        "{MODES} modes, {} lines, {} cores; s by the clock (processor time), times over sdypy-EMA's",
        AXIS.len - 1,
        std::thread::available_parallelism()?
    );
    for (outputs, references, runs) in [(90, 1, 5), (300, 3, 1)] {
        if only.is_none_or(|only| only == outputs * references) {
            case((outputs, references), runs)?;
        }
    }
    Ok(())
}

fn case((outputs, references): (usize, usize), runs: usize) -> Result<(), Failure> {
    let modes = modes(outputs);
    let set = measured(&modes, (outputs, references))?;
    let band = Band::new(10.0, AXIS.hz(AXIS.len - 1))?;
    let file = tempfile::NamedTempFile::new()?;
    write(&set, file.path())?;
    println!("{} functions", set.len());
    let mut peer = None;
    for order in ORDERS {
        let first = lscf((&set, &modes), (band, order, true, 1), runs)?;
        let competitor = sdypy(file.path(), order, runs);
        let again = lscf((&set, &modes), (band, order, true, 1), runs)?;
        match &competitor {
            Some((version, time, poles)) => println!(
                "order {order}: {version}, every order: {}; {} modes among its poles",
                text(*time, None),
                found(&modes, poles)
            ),
            None => println!("order {order}: sdypy-EMA was not found"),
        }
        let over = competitor.map(|(_, time, _)| time);
        first
            .fastest(&again)
            .print("one reference, 1 thread ", over);
        if references > 1 {
            let several = lscf((&set, &modes), (band, order, false, 2), runs)?;
            several.print(&format!("{references} references, 2 threads"), over);
        }
        peer = peer.or(over);
    }
    for threads in [1, 2] {
        whole((&set, &modes), (band, references, threads), peer)?;
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
    (set, modes): (&FrfSet, &[Mode]),
    (band, order, one_reference, threads): (Band, usize, bool, usize),
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
        let (receptances, lines) = timed(1, || Lines::new(set, band, one_reference))?;
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
            found: poles.last().map_or(0, |poles| found(modes, poles)),
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

/// The automatic identification, and its shares: the stages of its LSCF, which explains these data,
/// and the residues once by themselves, the rest refinement.
fn whole(
    (set, modes): (&FrfSet, &[Mode]),
    (band, references, threads): (Band, usize, usize),
    over: Option<Time>,
) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let options = IdentifyOptions {
        band: Some(band),
        ..IdentifyOptions::default()
    };
    let (all, result) = pool.install(|| timed(1, || identification(set, &options)))?;
    let poles: Vec<Complex64> = result.model.modes.iter().filter_map(pole).collect();
    println!(
        "  automatic identification, {threads} thread(s): {}; {} modes, {} of the {MODES}",
        text(all, over),
        poles.len(),
        found(modes, &poles)
    );
    let look = (band, highest_order(&result), references == 1, threads);
    let stages = lscf((set, modes), look, 1)?;
    let shares = [stages.transforms, stages.products, stages.some];
    let (fit, ()) = pool.install(|| timed(1, || residues(set, band, &poles)))?;
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

fn modes(points: usize) -> Vec<Mode> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let spacing = AXIS.hz(AXIS.len - 1) / (MODES as f64 + 1.0);
    let mode = |number: usize| {
        let hz = spacing * (number as f64 + 1.0 + random.random_range(-0.2..0.2));
        Mode {
            lambda: Pole::from_frequency(hz, random.random_range(DAMPING)).lambda,
            shape: (0..points)
                .map(|_| random.random_range(-1.0..1.0))
                .collect(),
        }
    };
    (0..MODES).map(mode).collect()
}

/// Receptances with white noise, hit at the first of the points.
fn measured(modes: &[Mode], (outputs, references): (usize, usize)) -> Result<FrfSet, Failure> {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let course = |mode: &Mode| -> Vec<Complex64> {
        let residue = Complex64::new(0.0, 2.0 * mode.lambda.im).inv();
        let value = |k: usize| {
            let s = Complex64::new(0.0, AXIS.rad_s(k));
            residue / (s - mode.lambda) + residue.conj() / (s - mode.lambda.conj())
        };
        (0..AXIS.len).map(value).collect()
    };
    let courses: Vec<Vec<Complex64>> = modes.iter().map(course).collect();
    let dof = |point: usize| format!("{}:+Z", point + 1).parse::<Dof>();
    let mut set = FrfSet::new(AXIS);
    for reference in 0..references {
        for response in 0..outputs {
            let mut values = vec![Complex64::ZERO; AXIS.len];
            for (mode, course) in modes.iter().zip(&courses) {
                let factor = mode.shape[response] * mode.shape[reference];
                for (value, profile) in values.iter_mut().zip(course) {
                    *value += factor * profile;
                }
            }
            let power = values.iter().map(Complex64::norm_sqr).sum::<f64>();
            let noise = NOISE * (0.5 * power / AXIS.len as f64).sqrt();
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
    let shape = [set.len() as u64, AXIS.len as u64];
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

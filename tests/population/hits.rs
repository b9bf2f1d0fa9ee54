//! Hit judging over a population: pulses of 3 to 200 samples, converters of 12 to 24 bits,
//! structures of 0.1 to 5 % damping, noise at 30 to 80 dB, offsets and drifts. Clean hits must
//! pass; faulty ones must be detected where they are detectable.

use std::collections::BTreeMap;

use modalign::dof::Dof;
use modalign::modal::{ModalModel, Mode, ModeShape, Scaling};
use modalign::quantity::Quantity;
use modalign::record::Hit;
use modalign::signal::{
    Check, HitQualityLimits, ONSET_FRACTION, Outcome, Pulse, ResponseRecord, Rule, assess_force,
    assess_response, least_delay_samples,
};
use modalign::synth::{
    Faults, HammerTest, LowPassOptions, Noise, Pulse as Hammer, SecondContact, Truth, roving_hammer,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use crate::{draws, parts};

const WIDTHS: [f64; 7] = [3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
const SNRS_DB: [f64; 6] = [30.0, 40.0, 50.0, 60.0, 70.0, 80.0];
const SAMPLES: usize = 4096;
const ONSET: usize = 400;
const RATE_HZ: f64 = 10_000.0;
/// Hits in each cell of width and noise: clean, with a second contact, with an overload.
const CLEAN: usize = 120;
const DOUBLE: usize = 72;
const OVERLOAD: usize = 36;
/// Twice the detected ratio, so that the noise of the estimate does not decide the detection.
const MIN_RATIO: f64 = 0.02;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Clean,
    Double,
    Overload,
}

/// One drawn hit, judged.
struct AssessedHit {
    kind: Kind,
    width: f64,
    snr_db: f64,
    /// True detectability and ratio of the second contact.
    second: Option<(f64, f64)>,
    /// Samples that the converter clipped.
    clipped: usize,
    checks: Vec<Check>,
}

/// The distribution of one hit.
struct Draw {
    kind: Kind,
    width: f64,
    snr_db: f64,
    random: ChaCha8Rng,
}

fn dof() -> Dof {
    "1:+Z".parse().unwrap()
}

impl Draw {
    fn new(index: usize) -> Self {
        let per_cell = CLEAN + DOUBLE + OVERLOAD;
        let (cell, number) = (index / per_cell, index % per_cell);
        let kind = match number {
            n if n < CLEAN => Kind::Clean,
            n if n < CLEAN + DOUBLE => Kind::Double,
            _ => Kind::Overload,
        };
        Self {
            kind,
            width: WIDTHS[cell / SNRS_DB.len()],
            snr_db: SNRS_DB[cell % SNRS_DB.len()],
            random: ChaCha8Rng::seed_from_u64(0x4e_17 + index as u64),
        }
    }

    fn log_uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.random.random::<f64>())
    }

    /// A structure of one mode under one hit, without noise.
    fn test(&mut self) -> HammerTest {
        let frequency_hz = self.log_uniform(0.01, 0.2) * RATE_HZ;
        let damping = self.log_uniform(0.001, 0.05);
        let shape = ModeShape::new([(dof(), 1.0.into())]);
        let mode = Mode::new(frequency_hz, Some(damping), shape, Scaling::UnitModalMass);
        let model = ModalModel {
            modes: vec![mode],
            ..ModalModel::default()
        };
        HammerTest {
            truth: Truth::from_real_shapes(&model, &[dof()], &[dof()]).unwrap(),
            hits: roving_hammer(&[dof()], &[dof()]),
            averages_per_point: 1,
            sampling_rate_hz: RATE_HZ,
            samples: SAMPLES,
            pretrigger_s: ONSET as f64 / RATE_HZ,
            quantity: Quantity::Acceleration,
            pulse: Hammer {
                peak_n: 100.0,
                peak_spread: 0.5,
                duration_s: self.width / RATE_HZ,
                duration_spread: 0.1,
            },
            filter: LowPassOptions::default(),
            noise: Noise::default(),
            faults: Faults::default(),
            seed: self.random.random(),
        }
    }

    fn judge(mut self) -> AssessedHit {
        let mut test = self.test();
        let single = test.generate_hit(0).unwrap();
        let peak_n = largest(&single.force.si());
        let noise_n = peak_n / 10f64.powf(self.snr_db / 20.0);
        let bits = self.random.random_range(12..=24);
        let over_peak = match self.kind {
            Kind::Overload => self.random.random_range(0.5..0.95),
            _ => self.random.random_range(1.2..4.0),
        };
        let converter = Converter {
            full_scale: over_peak * peak_n,
            step: over_peak * peak_n / 2f64.powi(bits - 1),
            clipped_code_noise: self.kind == Kind::Overload && self.random.random(),
        };
        let energy: f64 = single.force.si().iter().map(|p| p * p).sum();
        let sigma = noise_n.hypot(converter.step / 12f64.sqrt());
        let unit_detectability = energy.sqrt() / sigma;
        let second = (self.kind == Kind::Double).then(|| self.second(unit_detectability));
        let hit = match second {
            Some(ratio) => {
                let delay_s = self.delay(&single) / RATE_HZ;
                let hits = [0].into();
                test.faults.second_contact = Some(SecondContact {
                    delay_s,
                    ratio,
                    hits,
                });
                test.generate_hit(0).unwrap()
            }
            None => single,
        };
        let mut force = hit.force.si();
        let clipped = self.record(&mut force, noise_n, &converter);
        let mut response = hit.responses[0].si();
        let rms = (response.iter().map(|x| x * x).sum::<f64>() / SAMPLES as f64).sqrt();
        let full_scale = 1.5 * largest(&response).max(rms);
        let response_converter = Converter {
            full_scale,
            step: full_scale / 2f64.powi(bits - 1),
            clipped_code_noise: false,
        };
        let noise = rms / 10f64.powf(self.snr_db / 20.0);
        self.record(&mut response, noise, &response_converter);
        let stated = self.random.random::<bool>();
        let full_scale_n = stated.then_some(converter.full_scale);
        AssessedHit {
            kind: self.kind,
            width: self.width,
            snr_db: self.snr_db,
            second: second.map(|ratio| (ratio * unit_detectability, ratio)),
            clipped,
            checks: checks(&force, &response, full_scale_n),
        }
    }

    /// A ratio: in half of the draws the contact is hard to detect.
    fn second(&mut self, unit_detectability: f64) -> f64 {
        let hard = self.log_uniform(4.0, 20.0) / unit_detectability;
        let any = self.log_uniform(MIN_RATIO, 1.0);
        let take_hard = self.random.random() && (MIN_RATIO..1.0).contains(&hard);
        if take_hard { hard } else { any }
    }

    /// A delay, samples: from the least that is separate to the end of the record.
    fn delay(&mut self, single: &Hit) -> f64 {
        let pulse = Pulse::locate(&single.force.si(), ONSET_FRACTION).unwrap();
        // Noise moves the onset and the end by a few samples.
        let least = least_delay_samples(&pulse) as f64 + 4.0 + 0.1 * self.width;
        let most = (SAMPLES - ONSET - 16) as f64 - 1.1 * self.width;
        self.random.random_range(least..most)
    }

    /// Noise, offset, drift and the converter; the number of clipped samples.
    fn record(&mut self, samples: &mut [f64], noise: f64, converter: &Converter) -> usize {
        let scale = 0.02 * converter.full_scale;
        let offset = self.random.random_range(-scale..scale);
        let drift = self.random.random_range(-scale..scale) / SAMPLES as f64;
        let mut clipped = 0;
        for (k, sample) in samples.iter_mut().enumerate() {
            let normal: f64 = self.random.sample(StandardNormal);
            let analogue = *sample + noise * normal + offset + drift * k as f64;
            let code = (analogue / converter.step).round();
            let full_scale_code = (converter.full_scale / converter.step).round();
            let is_clipped = code >= full_scale_code - 1.0 || code <= -full_scale_code;
            clipped += usize::from(is_clipped);
            let clipped_code_noise = if is_clipped && converter.clipped_code_noise {
                f64::from(self.random.random_range(-2i32..=2))
            } else {
                0.0
            };
            *sample = (code.clamp(-full_scale_code, full_scale_code - 1.0) + clipped_code_noise)
                * converter.step;
        }
        clipped
    }
}

struct Converter {
    full_scale: f64,
    step: f64,
    /// Two codes up and down at full scale.
    clipped_code_noise: bool,
}

fn largest(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |m, x| m.max(x.abs()))
}

fn checks(force: &[f64], response: &[f64], full_scale_n: Option<f64>) -> Vec<Check> {
    let limits = HitQualityLimits::default();
    let step_s = 1.0 / RATE_HZ;
    let pulse = Pulse::locate(force, ONSET_FRACTION).unwrap();
    let record = ResponseRecord {
        samples: response,
        step_s,
        dof: &dof(),
        full_scale: None,
    };
    let mut checks = assess_force(force, step_s, &pulse, full_scale_n, 0.1 * RATE_HZ, &limits);
    checks.extend(assess_response(&record, &pulse, &limits));
    checks
}

impl AssessedHit {
    fn force(&self, rule: Rule) -> Outcome {
        let check = self
            .checks
            .iter()
            .find(|c| c.rule == rule && c.dof.is_none());
        check.unwrap().outcome
    }

    fn second_found(&self) -> bool {
        matches!(
            self.force(Rule::DoubleHit),
            Outcome::Noted | Outcome::Rejected
        )
    }

    fn rejected(&self) -> bool {
        self.checks.iter().any(|c| c.outcome == Outcome::Rejected)
    }
}

fn population() -> Vec<AssessedHit> {
    let count = WIDTHS.len() * SNRS_DB.len() * (CLEAN + DOUBLE + OVERLOAD);
    let hits = (0..count).into_par_iter().step_by(parts() as usize);
    hits.map(|index| Draw::new(index).judge()).collect()
}

fn share(part: usize, all: usize) -> String {
    format!("{part}/{all}")
}

/// Prints `count` of what `what` selects out of what `of` selects, over width and noise.
fn print_table(
    title: &str,
    hits: &[AssessedHit],
    of: impl Fn(&AssessedHit) -> bool,
    what: impl Fn(&AssessedHit) -> bool,
) {
    println!("{title}");
    println!(
        "{:>8} {}",
        "width",
        SNRS_DB.map(|snr| format!("{snr:>7} dB")).join(" ")
    );
    for width in WIDTHS {
        let cells = SNRS_DB.map(|snr| {
            let cell = hits
                .iter()
                .filter(|h| (h.width - width).abs() < 0.5 && (h.snr_db - snr).abs() < 0.5 && of(h));
            let (all, part) = cell.fold((0, 0), |(all, part), h| {
                (all + 1, part + usize::from(what(h)))
            });
            format!("{:>10}", share(part, all))
        });
        println!("{width:>8} {}", cells.join(" "));
    }
}

/// The class of a true detectability: its lower edge.
fn class(detectability: f64) -> usize {
    let edges = [0, 4, 6, 8, 10, 14, 20, 50, 200];
    let below = edges.iter().rev().find(|e| detectability >= **e as f64);
    *below.unwrap()
}

fn print_second_contacts(hits: &[AssessedHit]) {
    let mut classes: BTreeMap<usize, [usize; 4]> = BTreeMap::new();
    for hit in hits {
        if let Some((detectability, _)) = hit.second {
            let row = classes.entry(class(detectability)).or_default();
            row[0] += 1;
            row[1] += usize::from(hit.second_found());
            row[2] += usize::from(hit.force(Rule::DoubleHit) == Outcome::NotDecidable);
            row[3] += usize::from(hit.force(Rule::DoubleHit) == Outcome::Passed);
        }
    }
    println!("second contacts by true d'\n  d' from   hits  found  not decidable  passed");
    for (edge, [all, found, open, passed]) in classes {
        println!("{edge:>9} {all:>6} {found:>6} {open:>14} {passed:>7}");
    }
}

#[test]
fn judging_finds_what_can_be_found_and_keeps_what_is_good() {
    let hits = population();
    let is_enough = |there: usize, all: u64| there as u64 >= draws(all);
    assert!(is_enough(hits.len(), 5000), "{} hits", hits.len());
    let clean = |h: &AssessedHit| h.kind == Kind::Clean;
    let visible = |h: &AssessedHit| h.second.is_some_and(|(d, _)| d >= 8.0);
    let clips = |h: &AssessedHit| h.kind == Kind::Overload && h.clipped >= 3;
    let overloaded = |h: &AssessedHit| h.force(Rule::Overload) == Outcome::Rejected;
    println!("{} hits", hits.len());
    print_table(
        "clean: false alarms of the double hit",
        &hits,
        clean,
        AssessedHit::second_found,
    );
    print_table(
        "clean: rejected by any rule",
        &hits,
        clean,
        AssessedHit::rejected,
    );
    print_table(
        "second contacts of d' >= 8 found",
        &hits,
        visible,
        AssessedHit::second_found,
    );
    print_table("overloads found", &hits, clips, overloaded);
    print_second_contacts(&hits);
    let count = |of: &dyn Fn(&AssessedHit) -> bool| hits.iter().filter(|h| of(h)).count();
    let cleans = count(&clean);
    let alarms = count(&|h| clean(h) && h.second_found());
    assert!(
        (alarms as f64) < 0.002 * cleans as f64,
        "{alarms} false alarms of {cleans}"
    );
    let lost = count(&|h| clean(h) && h.rejected());
    assert!(
        (lost as f64) < 0.002 * cleans as f64,
        "{lost} clean hits rejected of {cleans}"
    );
    let lost = count(&|h| clean(h) && h.snr_db < 35.0 && h.rejected());
    assert_eq!(lost, 0, "good hits lost at 30 dB");
    let (seen, there) = (count(&|h| visible(h) && h.second_found()), count(&visible));
    assert!(
        is_enough(there, 1000) && seen as f64 > 0.99 * there as f64,
        "{seen} of {there}"
    );
    let at_edge = |h: &AssessedHit| h.second.is_some_and(|(d, _)| (8.0..14.0).contains(&d));
    let (seen, there) = (count(&|h| at_edge(h) && h.second_found()), count(&at_edge));
    assert!(
        is_enough(there, 200) && seen as f64 > 0.99 * there as f64,
        "{seen} of {there} at 8 to 14"
    );
    let passed = count(&|h| {
        let matters = h.second.is_some_and(|(_, ratio)| ratio >= 0.11);
        matters && h.force(Rule::DoubleHit) == Outcome::Passed
    });
    assert_eq!(passed, 0, "contacts that matter passed");
    let (seen, there) = (count(&|h| clips(h) && overloaded(h)), count(&clips));
    assert!(
        is_enough(there, 1000) && seen as f64 > 0.99 * there as f64,
        "overloads: {seen} of {there}"
    );
}

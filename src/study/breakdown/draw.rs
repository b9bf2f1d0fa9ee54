//! A draw of a case gives FRFs with white noise of known variance, or FRFs estimated from a
//! synthetic hammer test.

use num_complex::Complex64;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::axis::{Band, FrequencyAxis};
use crate::dof::Dof;
use crate::frf::{
    FrfSet, HammerOptions, ResponseWindow, evaluate_hammer_test, modal_terms, synthesise,
};
use crate::modal::ModalModel;
use crate::quantity::Quantity;
use crate::record::{Hit, InMemory};
use crate::study::{StudyError, cell_random, with_noise};
use crate::synth::{
    Faults, HammerTest, HitPlan, LowPassOptions, Noise, Pulse, Quantisation, SecondContact,
    SynthError,
};

use super::{Case, Factor};

/// Random numbers of a draw, seeded by the coordinates of the cell instead of its index in a grid:
/// a cell has the same draws however the slice was refined, split or run.
pub fn draw_random(seed: u64, values: [(Factor, f64); 2], draw: u32) -> ChaCha8Rng {
    let [(x, at_x), (y, at_y)] = values;
    let coordinates = [
        x as u64,
        at_x.to_bits(),
        y as u64,
        at_y.to_bits(),
        u64::from(draw),
    ];
    cell_random(seed, &coordinates)
}

/// FRFs for a method, and the true modes behind them.
pub struct Draw {
    /// FRFs; the error where a test gives none.
    pub set: Result<FrfSet, StudyError>,
    /// Where modes are searched.
    pub band: Band,
    /// The true modes.
    pub truth: ModalModel,
    /// Sensors at which shapes are compared.
    pub responses: Vec<Dof>,
}

impl Draw {
    /// FRFs at the lines of the band with white noise of known variance. Modes are shifted against
    /// the lines by up to a line.
    ///
    /// # Errors
    /// [`SynthError`] for a case that makes no mode.
    pub fn from_frfs(case: &Case, mut random: ChaCha8Rng) -> Result<Self, SynthError> {
        let band = case.band();
        let axis = FrequencyAxis {
            start_hz: band.lo_hz,
            step_hz: band.width_hz() / (case.lines - 1) as f64,
            len: case.lines,
        };
        let shift_hz = axis.step_hz * random.random_range(0.0..1.0);
        let truth = case.truth(shift_hz, 1.0)?.model;
        Ok(Self {
            set: noisy_frfs(case, &truth, axis, &mut random),
            band,
            truth,
            responses: case.responses(),
        })
    }

    /// FRFs of a hammer test, its hits checked, windowed and averaged with default options.
    ///
    /// # Errors
    /// [`SynthError`] for a case that cannot be recorded.
    pub fn from_test(case: &Case, mut random: ChaCha8Rng) -> Result<Self, SynthError> {
        let tests = hammer_tests(case, &mut random)?;
        let mut hits: Vec<Hit> = Vec::new();
        for test in &tests {
            hits.extend(test.generate()?);
        }
        let options = HammerOptions {
            response_window: match case.window_end {
                None => ResponseWindow::Auto,
                Some(end) if end >= 1.0 => ResponseWindow::Off,
                Some(end) => ResponseWindow::End(end),
            },
            ..HammerOptions::default()
        };
        let estimated = evaluate_hammer_test(&mut InMemory::new(&hits), &options);
        let middle = tests.len() / 2;
        // Where a roving sensor loads the structure, no frequency is right; the middle one is the
        // least wrong.
        let truth = tests[middle].truth.model.clone();
        Ok(Self {
            set: estimated
                .map(|test| test.estimated.set)
                .map_err(StudyError::from),
            band: case.band(),
            truth,
            responses: case.responses(),
        })
    }
}

fn noisy_frfs(
    case: &Case,
    truth: &ModalModel,
    axis: FrequencyAxis,
    random: &mut ChaCha8Rng,
) -> Result<FrfSet, StudyError> {
    let hits = case.hits();
    let responses = case.responses();
    let pairs = hits.iter().flat_map(|hit| {
        let dofs = responses.iter();
        dofs.map(move |response| (response.clone(), hit.clone()))
    });
    let pairs: Vec<(Dof, Dof)> = pairs.collect();
    let exact = synthesise(&modal_terms(truth)?, axis, &pairs, Case::kind(), 0.0)?;
    let variance = |i: usize| {
        let power: f64 = exact.values(i).iter().map(Complex64::norm_sqr).sum();
        power / axis.len as f64 * 10f64.powf(-0.1 * case.noise_db)
    };
    let variances: Vec<f64> = (0..exact.len()).map(variance).collect();
    with_noise(&exact, &variances, None, random)
}

/// Sampling rate over the band's upper edge: the anti-alias filter begins at 0.4 of the rate.
const RATE_OVER_BAND: f64 = 2.56;
/// Contact time times the band's upper edge: the force falls by 3 dB there.
const CONTACT_TIMES_BAND_EDGE: f64 = 0.6;
/// Time before the hit, s.
const PRETRIGGER_S: f64 = 0.1;
const PEAK_N: f64 = 100.0;
/// Second contacts: delay in contact times, peak over that of the first.
const SECOND_DELAY: (f64, f64) = (4.0, 20.0);
const SECOND_RATIO: (f64, f64) = (0.2, 0.6);
/// Full scale of the converter over the largest sample.
const HEADROOM: f64 = 4.0;

/// The tests of a draw: one, or with mass loading one for each position of a roving sensor.
fn hammer_tests(case: &Case, random: &mut ChaCha8Rng) -> Result<Vec<HammerTest>, SynthError> {
    // Modes are shifted against the lines by up to a line.
    let record_s = case.record_length * case.time_constant_s();
    let shift_hz = random.random_range(0.0..1.0) / (record_s + PRETRIGGER_S);
    let responses = case.responses();
    if case.mass_loading == 0.0 {
        let plan = hit_plans(case, &responses);
        return Ok(vec![hammer_test(case, shift_hz, 1.0, plan, random)?]);
    }
    let count = responses.len() as f64;
    let drift = |k: usize| {
        let share = k as f64 / (count - 1.0) - 0.5;
        1.0 - share * case.mass_loading * case.width_hz() / case.lowest_hz
    };
    let of_position = |(k, response): (usize, &Dof)| {
        let plan = hit_plans(case, std::slice::from_ref(response));
        hammer_test(case, shift_hz, drift(k), plan, random)
    };
    responses.iter().enumerate().map(of_position).collect()
}

fn hit_plans(case: &Case, responses: &[Dof]) -> Vec<HitPlan> {
    crate::synth::roving_hammer(&case.hits(), responses)
}

fn hammer_test(
    case: &Case,
    shift_hz: f64,
    factor: f64,
    hits: Vec<HitPlan>,
    random: &mut ChaCha8Rng,
) -> Result<HammerTest, SynthError> {
    let band = case.band();
    let rate = RATE_OVER_BAND * band.hi_hz;
    let record_s = PRETRIGGER_S + case.record_length * case.time_constant_s();
    let duration_s = CONTACT_TIMES_BAND_EDGE / band.hi_hz;
    let mut test = HammerTest {
        truth: case.truth(shift_hz, factor)?,
        hits,
        averages_per_point: case.hits,
        sampling_rate_hz: rate,
        samples: (record_s * rate).round() as usize,
        pretrigger_s: PRETRIGGER_S,
        quantity: Quantity::Acceleration,
        pulse: Pulse {
            peak_n: PEAK_N,
            peak_spread: 0.2,
            duration_s,
            duration_spread: 0.05,
        },
        filter: LowPassOptions::default(),
        noise: Noise {
            force_snr_db: Some(case.force_noise_db),
            response_snr_db: Some(case.noise_db),
        },
        faults: Faults::default(),
        seed: random.random(),
    };
    test.faults = faults(case, &test, random)?;
    Ok(test)
}

fn faults(case: &Case, test: &HammerTest, random: &mut ChaCha8Rng) -> Result<Faults, SynthError> {
    let struck = (0..test.hit_count()).filter(|_| random.random_bool(case.second_contacts));
    let hits: std::collections::BTreeSet<usize> = struck.collect();
    let second_contact = SecondContact {
        delay_s: test.pulse.duration_s * random.random_range(SECOND_DELAY.0..SECOND_DELAY.1),
        ratio: random.random_range(SECOND_RATIO.0..SECOND_RATIO.1),
        hits,
    };
    let quantisation = |bits: u32| -> Result<Quantisation, SynthError> {
        let hit = test.generate_hit(0)?;
        let largest = |samples: Vec<f64>| samples.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let responses = hit.responses.iter().map(|channel| largest(channel.si()));
        Ok(Quantisation {
            bits,
            force_full_scale_n: HEADROOM * largest(hit.force.si()),
            response_full_scale: HEADROOM * responses.fold(0.0, f64::max),
        })
    };
    Ok(Faults {
        second_contact: (!second_contact.hits.is_empty()).then_some(second_contact),
        quantisation: case.bits.map(quantisation).transpose()?,
        ..Faults::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(draw: u32) -> ChaCha8Rng {
        draw_random(7, [(Factor::Noise, 40.0), (Factor::Hits, 2.0)], draw)
    }

    #[test]
    fn random_numbers_are_of_the_coordinates_and_of_the_draw() {
        let of = |seed, values, draw| draw_random(seed, values, draw).random::<u64>();
        let cell = [(Factor::Noise, 40.0), (Factor::Hits, 2.0)];
        let reference = of(7, cell, 3);
        assert_eq!(of(7, cell, 3), reference);
        let near = [(Factor::Noise, 40.0 + 1e-12), (Factor::Hits, 2.0)];
        let swapped = [(Factor::Hits, 40.0), (Factor::Noise, 2.0)];
        let others = [
            of(8, cell, 3),
            of(7, cell, 4),
            of(7, near, 3),
            of(7, swapped, 3),
        ];
        assert!(others.iter().all(|other| *other != reference));
    }

    #[test]
    fn noise_of_frfs_has_the_stated_level() {
        let case = Case::default().with(Factor::Noise, 20.0);
        let draw = Draw::from_frfs(&case, random(5)).unwrap();
        let set = draw.set.unwrap();
        let terms = modal_terms(&draw.truth).unwrap();
        let pairs: Vec<_> = set
            .functions()
            .iter()
            .map(|f| (f.response.clone(), f.reference.clone()))
            .collect();
        let exact = synthesise(&terms, *set.axis(), &pairs, Case::kind(), 0.0).unwrap();
        let (mut noise, mut signal) = (0.0, 0.0);
        for i in 0..set.len() {
            let power: f64 = exact.values(i).iter().map(Complex64::norm_sqr).sum();
            let pairs_of_values = set.values(i).iter().zip(exact.values(i));
            noise += pairs_of_values
                .map(|(a, b)| (a - b).norm_sqr())
                .sum::<f64>()
                / power;
            signal += 1.0;
        }
        // 4 functions of 300 lines: the mean of 1200 squares is known to 1/√1200 = 2.9 %; five of
        // these.
        assert!((noise / signal / 0.01 - 1.0).abs() < 0.145, "{noise}");
    }

    #[test]
    fn a_hammer_test_gives_every_function() {
        let case = Case::default().with(Factor::References, 2.0);
        let draw = Draw::from_test(&case, random(11)).unwrap();
        assert_eq!(draw.set.unwrap().len(), 8);
        let roving = Case::default().with(Factor::MassLoading, 0.5);
        let draw = Draw::from_test(&roving, random(11)).unwrap();
        assert_eq!(draw.set.unwrap().len(), 4);
        assert_eq!(draw.truth.modes[0].residues.len(), 4);
    }
}

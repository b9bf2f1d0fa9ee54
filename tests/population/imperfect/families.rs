//! The imperfections, each a family of draws.

use std::f64::consts::TAU;

use modalign::axis::Band;
use modalign::modal::Pole;
use modalign::study::System;
use num_complex::Complex64;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::systems::log_uniform;

use super::Measured;
use super::frfs::{
    Values, frf_set, mean_square, receptance, values, white, windowed_noise, with_noise,
    with_white_noise,
};
use super::structure::{Range, Structure, USUAL};

/// A family with the limits that its draws keep today.
pub struct Family {
    pub name: &'static str,
    pub draw: fn(&mut ChaCha8Rng) -> Measured,
    /// Largest share of the observable modes that is missed.
    pub max_missed: f64,
    /// Largest share of the identified modes that is false.
    pub max_false: f64,
}

impl Family {
    const fn new(
        name: &'static str,
        [max_missed, max_false]: [f64; 2],
        draw: fn(&mut ChaCha8Rng) -> Measured,
    ) -> Self {
        Self {
            name,
            draw,
            max_missed,
            max_false,
        }
    }

    /// Its number among all.
    pub fn number(&self) -> usize {
        let mut families = FAMILIES.iter();
        families.position(|other| other.name == self.name).unwrap()
    }
}

pub const FAMILIES: &[Family] = &[
    Family::new("clean", [0.01, 0.01], |random| {
        let structure = Structure::draw(random, &USUAL);
        let exact = exact(&structure);
        with_white_noise(exact, unchanged(&structure), random)
    }),
    Family::new("roving sensor with mass", [0.03, 0.02], mass_loading),
    Family::new("shift between runs, large", [0.03, 0.06], |random| {
        shift_between_runs(random, (0.05, 0.6), 1)
    }),
    Family::new("shift between runs, small", [0.03, 0.04], |random| {
        shift_between_runs(random, (0.005, 0.05), 1)
    }),
    Family::new("shift between hits", [0.04, 0.02], |random| {
        shift_between_runs(random, (0.05, 0.6), 5)
    }),
    Family::new("faulty channel", [0.01, 0.01], faulty_channel),
    Family::new("one FRF of wrong sign", [0.02, 0.02], one_wrong_sign),
    Family::new("gains", [0.01, 0.03], gains),
    Family::new("noise in proportion to H", [0.02, 0.03], proportional_noise),
    Family::new(
        "noise correlated between lines",
        [0.02, 0.03],
        autoregressive_noise,
    ),
    Family::new("smoothed over three lines", [0.03, 0.1], smoothed),
    Family::new("zero-padded by 4", [0.02, 0.03], zero_padded),
    Family::new(
        "exponential window, unstated",
        [0.02, 0.03],
        unstated_window,
    ),
    Family::new("harmonics on lines", [0.02, 0.03], harmonic_lines),
    Family::new("harmonics in time", [0.02, 0.03], harmonics_in_time),
    Family::new("few lines, leakage", [0.02, 0.02], leakage),
    Family::new("driving point alone", [0.03, 0.02], driving_point),
    Family::new("damping of 10 to 20 %", [0.1, 0.05], heavy_damping),
];

fn exact(structure: &Structure) -> Values {
    values(structure, |points, s| {
        receptance(structure, &structure.poles, points, s)
    })
}

fn unchanged(structure: &Structure) -> System {
    with_poles(structure, &structure.poles)
}

fn with_poles(structure: &Structure, poles: &[Pole]) -> System {
    structure.truth(poles, &structure.complex_shapes(), band(structure))
}

fn band(structure: &Structure) -> Band {
    let axis = &structure.axis;
    Band::new(axis.start_hz, axis.hz(axis.len - 1)).unwrap()
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// The mean of poles in frequency and damping, mode by mode.
fn mean_poles(all: &[Vec<Pole>]) -> Vec<Pole> {
    let count = all.len() as f64;
    let mean = |r: usize| {
        let hz = all.iter().map(|poles| poles[r].natural_frequency_hz());
        let damping = all.iter().map(|poles| poles[r].damping_ratio());
        Pole::from_frequency(hz.sum::<f64>() / count, damping.sum::<f64>() / count)
    };
    (0..all[0].len()).map(mean).collect()
}

/// A sensor of mass m at point o changes all receptances of o to `α/(1 + s² m α_oo)`.
fn mass_loading(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    // The mean square of a shape of unit modal mass is 1/mass.
    let mass_kg = log_uniform(random, (0.0002, 0.01));
    let load = |o: usize, s: Complex64| {
        1.0 + s * s * mass_kg * receptance(&structure, &structure.poles, [o, o], s)
    };
    let loaded = values(&structure, |[o, i], s| {
        receptance(&structure, &structure.poles, [o, i], s) / load(o, s)
    });
    let poles: Vec<Vec<Pole>> = (0..structure.responses())
        .map(|o| {
            let modes = structure.poles.iter().zip(&structure.shapes);
            modes
                .map(|(pole, shape)| {
                    loaded_pole(pole, mass_kg * shape[o] * shape[o], |s| load(o, s))
                })
                .collect()
        })
        .collect();
    let truth = with_poles(&structure, &mean_poles(&poles));
    with_white_noise(loaded, truth, random)
}

/// Root of `1 + s² m α_oo` near a pole, by secants from the shift of first order;
/// `ratio` is m φ².
fn loaded_pole(pole: &Pole, ratio: f64, load: impl Fn(Complex64) -> Complex64) -> Pole {
    if ratio < 1e-12 {
        return *pole;
    }
    let lambda = pole.lambda;
    // Multiplied by the distance from the pole, the function has no pole there.
    let value = |s: Complex64| load(s) * (s - lambda);
    let shift = -0.5 * ratio * lambda;
    let (mut a, mut b) = (lambda + shift, lambda + 0.9 * shift);
    for _ in 0..60 {
        let (fa, fb) = (value(a), value(b));
        if (fb - fa).norm() == 0.0 || (b - a).norm() < 1e-15 * lambda.norm() {
            break;
        }
        let next = b - fb * (b - a) / (fb - fa);
        (a, b) = (b, next);
    }
    Pole::from_frequency(b.norm() / TAU, -b.re / b.norm())
}

/// Natural frequencies that are shifted from run to run, or from hit to hit of each run; the FRFs
/// of one response, or of a few, are a run.
fn shift_between_runs(random: &mut ChaCha8Rng, range: (f64, f64), hits: usize) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    let deviation = log_uniform(random, range);
    let responses_of_run = [1, 2, 4][random.random_range(0..3)];
    let runs = structure.responses().div_ceil(responses_of_run) * structure.references;
    let shifted = |random: &mut ChaCha8Rng, pole: &Pole| {
        let shift = deviation * normal(random) * pole.half_power_width_hz();
        let hz = pole.natural_frequency_hz();
        Pole::from_frequency(hz + shift, pole.damping_ratio() * hz / (hz + shift))
    };
    let poles: Vec<Vec<Pole>> = (0..runs * hits)
        .map(|_| {
            structure
                .poles
                .iter()
                .map(|pole| shifted(random, pole))
                .collect()
        })
        .collect();
    let runs_of_reference = runs / structure.references;
    let measured = values(&structure, |[o, i], s| {
        let run = i * runs_of_reference + o / responses_of_run;
        let of_run = &poles[run * hits..(run + 1) * hits];
        let sum: Complex64 = of_run
            .iter()
            .map(|poles| receptance(&structure, poles, [o, i], s))
            .sum();
        sum / hits as f64
    });
    let truth = with_poles(&structure, &mean_poles(&poles));
    with_white_noise(measured, truth, random)
}

/// A response of wrong sign, without a signal or ten times too large, or two that are exchanged.
/// The truth has the fault.
fn faulty_channel(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    let responses = structure.responses();
    let first = random.random_range(0..responses);
    let other = (first + random.random_range(1..responses)) % responses;
    let fault = random.random_range(0..4);
    let factor = [-1.0, 0.0, 10.0, 1.0][fault];
    let source = |o: usize| match fault == 3 {
        true if o == first => other,
        true if o == other => first,
        _ => o,
    };
    let gain = |o: usize| if o == first { factor } else { 1.0 };
    let measured = values(&structure, |[o, i], s| {
        gain(o) * receptance(&structure, &structure.poles, [source(o), i], s)
    });
    let shape = |shape: &Vec<f64>| -> Vec<Complex64> {
        let at = |o: usize| (gain(o) * shape[source(o)]).into();
        (0..responses).map(at).collect()
    };
    let shapes: Vec<Vec<Complex64>> = structure.shapes.iter().map(shape).collect();
    let truth = structure.truth(&structure.poles, &shapes, band(&structure));
    with_white_noise(measured, truth, random)
}

const SEVERAL_REFERENCES: Range = Range {
    references: (2, 3),
    ..USUAL
};

fn one_wrong_sign(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            references: (2, 2),
            ..USUAL
        },
    );
    let mut measured = exact(&structure);
    let wrong = random.random_range(0..measured.len());
    measured[wrong]
        .iter_mut()
        .for_each(|value| *value = -*value);
    let mut measured = with_white_noise(measured, unchanged(&structure), random);
    let truth = &mut measured.truth;
    let (responses, response) = (truth.responses.len(), wrong % truth.responses.len());
    // Without a driving point no data tell which of the two functions is wrong: the sign of the
    // response in the shapes is not judged.
    if !truth.references.contains(&truth.responses[response]) {
        truth.responses.remove(response);
        for mode in &mut truth.modes {
            mode.shape.remove(response);
        }
        measured.variances.remove(responses + response);
        measured.variances.remove(response);
    }
    measured
}

fn gains(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(random, &SEVERAL_REFERENCES);
    let deviation = log_uniform(random, (0.003, 0.03));
    let mut measured = exact(&structure);
    for values in &mut measured {
        let gain = 1.0 + deviation * normal(random);
        values.iter_mut().for_each(|value| *value *= gain);
    }
    with_white_noise(measured, unchanged(&structure), random)
}

fn proportional_noise(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    let ratio = log_uniform(random, (0.002, 0.03));
    let mut measured = exact(&structure);
    let truth = unchanged(&structure);
    let variances = measured
        .iter()
        .map(|values| ratio * ratio * mean_square(values))
        .collect();
    for value in measured.iter_mut().flatten() {
        *value += ratio * value.norm() * white(random);
    }
    Measured {
        set: frf_set(&truth, measured, None, random),
        truth,
        variances,
        is_damping_known: true,
    }
}

fn autoregressive_noise(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    let coefficient = random.random_range(0.4..0.9);
    let noise = |random: &mut ChaCha8Rng, len: usize| {
        let scale = (1.0f64 - coefficient * coefficient).sqrt();
        let mut last = white(random);
        let next = |_| {
            last = coefficient * last + scale * white(random);
            last
        };
        (0..len).map(next).collect()
    };
    with_noise(
        exact(&structure),
        unchanged(&structure),
        random,
        false,
        noise,
    )
}

fn smoothed(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            lines_per_bandwidth: (6.0, 15.0),
            modes: (3, 5),
            ..USUAL
        },
    );
    let clean = with_noise(
        exact(&structure),
        unchanged(&structure),
        random,
        false,
        |random, len| (0..len).map(|_| white(random)).collect(),
    );
    let smooth = |values: &[Complex64]| -> Vec<Complex64> {
        let at = |k: usize| {
            let [before, after] = [k.saturating_sub(1), (k + 1).min(values.len() - 1)];
            0.25 * values[before] + 0.5 * values[k] + 0.25 * values[after]
        };
        (0..values.len()).map(at).collect()
    };
    let all = 0..clean.set.len();
    let measured = all.map(|f| smooth(clean.set.values(f))).collect();
    Measured {
        set: frf_set(&clean.truth, measured, None, random),
        variances: clean.variances.iter().map(|v| 0.375 * v).collect(),
        is_damping_known: false,
        ..clean
    }
}

fn zero_padded(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            lines_per_bandwidth: (12.0, 24.0),
            modes: (3, 5),
            ..USUAL
        },
    );
    let mut recorded = unchanged(&structure);
    recorded.record_end_s = Some(0.25 / structure.axis.step_hz);
    let set = recorded.exact().unwrap();
    let measured = (0..set.len()).map(|f| set.values(f).to_vec()).collect();
    let noise = |random: &mut ChaCha8Rng, len| windowed_noise(random, len, 0.25, |_| 1.0);
    with_noise(measured, unchanged(&structure), random, false, noise)
}

/// The damping of the data is that of the structure and of the window.
fn unstated_window(random: &mut ChaCha8Rng) -> Measured {
    let mut structure = Structure::draw(random, &USUAL);
    let narrowest = structure.poles.iter().map(|pole| -pole.lambda.re);
    let added = narrowest.fold(f64::MAX, f64::min) * random.random_range(0.3..1.5);
    let windowed = |pole: &Pole| {
        let lambda = pole.lambda - added;
        Pole::from_frequency(lambda.norm() / TAU, -lambda.re / lambda.norm())
    };
    structure.poles = structure.poles.iter().map(windowed).collect();
    let record_s = 1.0 / structure.axis.step_hz;
    let noise = |random: &mut ChaCha8Rng, len| {
        windowed_noise(random, len, 1.0, |time| (-added * record_s * time).exp())
    };
    with_noise(
        exact(&structure),
        unchanged(&structure),
        random,
        false,
        noise,
    )
}

/// One to three multiples of a frequency; amplitude and phase differ between the FRFs. `shape` is
/// the amplitude at a distance in lines.
fn with_harmonics(random: &mut ChaCha8Rng, shape: impl Fn(f64) -> Complex64) -> Measured {
    let structure = Structure::draw(random, &USUAL);
    let mut measured = exact(&structure);
    let axis = &structure.axis;
    let span_hz = axis.hz(axis.len - 1) - axis.start_hz;
    let base_hz = axis.start_hz + random.random_range(0.1..0.4) * span_hz;
    let level = log_uniform(random, (0.1, 3.0));
    for multiple in 1..=random.random_range(1..=3) {
        let centre = (f64::from(multiple) * base_hz - axis.start_hz) / axis.step_hz;
        for values in &mut measured {
            let amplitude = level * mean_square(values).sqrt() * white(random);
            for (k, value) in values.iter_mut().enumerate() {
                *value += amplitude * shape(k as f64 - centre);
            }
        }
    }
    with_white_noise(measured, unchanged(&structure), random)
}

fn harmonic_lines(random: &mut ChaCha8Rng) -> Measured {
    with_harmonics(random, |lines| {
        f64::from(u8::from(lines.abs() <= 0.5)).into()
    })
}

/// The leakage of a sine in a record without a window that begins at time 0.
fn harmonics_in_time(random: &mut ChaCha8Rng) -> Measured {
    with_harmonics(random, |lines| {
        let turn = std::f64::consts::PI * lines;
        let size = if turn.abs() < 1e-9 {
            1.0
        } else {
            turn.sin() / turn
        };
        Complex64::from_polar(1.0, -turn) * size
    })
}

/// Records that end before the response has decayed, with few lines in a half-power bandwidth.
fn leakage(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            lines_per_bandwidth: (0.35, 2.0),
            ..USUAL
        },
    );
    let mut recorded = unchanged(&structure);
    recorded.record_end_s = Some(1.0 / structure.axis.step_hz);
    let set = recorded.exact().unwrap();
    let measured = (0..set.len()).map(|f| set.values(f).to_vec()).collect();
    with_white_noise(measured, unchanged(&structure), random)
}

fn driving_point(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            responses: (1, 1),
            references: (1, 1),
            ..USUAL
        },
    );
    with_white_noise(exact(&structure), unchanged(&structure), random)
}

fn heavy_damping(random: &mut ChaCha8Rng) -> Measured {
    let structure = Structure::draw(
        random,
        &Range {
            modes: (3, 5),
            damping: (0.1, 0.2),
            lines_per_bandwidth: (40.0, 120.0),
            separation: 1.0,
            ..USUAL
        },
    );
    with_white_noise(exact(&structure), unchanged(&structure), random)
}

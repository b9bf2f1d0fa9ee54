//! The sensor that does not fit the motion of a rigid body, and what would make it fit.
//!
//! Each sensor in turn is left out, the motion of the others predicts what it should read, and the
//! hypotheses on what is wrong with it are compared by the sum of squares that they leave.

use super::mass_line::MassLine;
use super::repair::Repair;
use super::rows::{Motion, Rows};
use crate::dof::Dof;

/// Least fall of the sum of squares by a repair. Some thousand hypotheses are tried; noise alone
/// makes one of them fall by this less than once in a hundred tests. Larger: a gain of 3 % is not
/// seen with one hit. Smaller: sound sensors are named (`sound_sensors_are_not_named`).
pub const MIN_FALL: f64 = 30.0;
/// Least fall by leaving out a sensor that may be wrong; of two exchanged ones each takes a part.
const MIN_FALL_OF_ONE: f64 = 6.0;
/// Least part of the sum of squares beyond its freedom that a repair takes away: of two faults the
/// larger alone is no explanation.
const MIN_FALL_PART: f64 = 0.8;
/// Least distance of the best repair from the next of another sensor or kind. Larger: more faults
/// stay unnamed. Smaller: the wrong one of two sensors is repaired
/// (`a_wrong_sensor_is_named_and_repaired`).
const MIN_LEAD: f64 = 9.0;
/// Fall that a free gain must add to that of the other sign: three and a half deviations.
const MIN_FALL_OF_GAIN: f64 = 12.0;

/// A sensor that does not fit, with what makes it fit.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorFault {
    /// The sensor, the first of two exchanged ones.
    pub dof: Dof,
    /// What makes it fit.
    pub repair: Repair,
    /// Fall of the sum of squares by the repair.
    pub fall: f64,
}

/// A change of the test's description with the sum of squares that it leaves.
struct Hypothesis {
    repair: Repair,
    sum_of_squares: f64,
}

/// The motions that fit all sensors but one.
struct FitWithout {
    sensor: usize,
    motions: Vec<Motion>,
}

impl FitWithout {
    fn sum_of_squares(&self) -> f64 {
        sum_of_squares(&self.motions)
    }
}

/// What a sensor reads of one hit, with the variance of errors of calibration.
struct Reading {
    hit: usize,
    line: MassLine,
}

/// The one fault that explains what does not fit; `None` where all sensors fit, or no single fault
/// explains it.
pub(super) fn find(rows: &Rows) -> Option<SensorFault> {
    let seen = rows.seen_rows();
    let all = rows.fit(&seen, &[])?;
    let total = sum_of_squares(&all);
    let freedom: f64 = all.iter().map(|motion| motion.freedom).sum();
    let without = |sensor: usize| {
        let motions = rows.fit(&seen, &[sensor])?;
        Some(FitWithout { sensor, motions })
    };
    // No repair of a sensor takes away more than leaving it out does.
    let fits: Vec<FitWithout> = (0..rows.sensors.len())
        .filter_map(without)
        .filter(|fit| total - fit.sum_of_squares() >= MIN_FALL_OF_ONE)
        .collect();
    let of_sensors = fits.iter().flat_map(|fit| of_sensor(rows, &seen, fit));
    let mut hypotheses: Vec<Hypothesis> = of_sensors.collect();
    let suspects: Vec<usize> = fits.iter().map(|fit| fit.sensor).collect();
    hypotheses.extend(exchanges(rows, &seen, &suspects));
    hypotheses.sort_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares));
    let best = hypotheses.first()?;
    let fall = total - best.sum_of_squares;
    let explained = fall >= MIN_FALL && fall >= MIN_FALL_PART * (total - freedom);
    if !explained {
        return None;
    }
    let dof = best.repair.dof().clone();
    let is_rival = |other: &&Hypothesis| !is_same(&best.repair, &other.repair);
    let rival = hypotheses.iter().skip(1).find(is_rival);
    let lead = rival.map_or(f64::INFINITY, |other| {
        other.sum_of_squares - best.sum_of_squares
    });
    if lead >= MIN_LEAD {
        let repair = best.repair.clone();
        return Some(SensorFault { dof, repair, fall });
    }
    let repair = ambiguous(&hypotheses, best)?;
    let without = fits.iter().find(|fit| rows.sensors[fit.sensor].0 == dof)?;
    let fall = total - without.sum_of_squares();
    Some(SensorFault { dof, repair, fall })
}

/// Of hypotheses that are too near to separate: the sensor, where all are about it.
fn ambiguous(hypotheses: &[Hypothesis], best: &Hypothesis) -> Option<Repair> {
    let is_near = |other: &&Hypothesis| other.sum_of_squares - best.sum_of_squares < MIN_LEAD;
    let near = hypotheses.iter().filter(is_near);
    let mut dofs = near.map(|hypothesis| hypothesis.repair.dof().clone());
    let first = dofs.next()?;
    dofs.all(|dof| dof == first)
        .then_some(Repair::LeftOut(first))
}

/// Whether two repairs say the same of the same sensor: a gain of −1 is the other sign.
fn is_same(one: &Repair, other: &Repair) -> bool {
    match (one, other) {
        (Repair::Sign(a), Repair::Gain { dof: b, gain, .. }) => a == b && *gain < 0.0,
        (Repair::Gain { dof: a, gain, .. }, Repair::Sign(b)) => a == b && *gain < 0.0,
        (a, b) => a == b,
    }
}

fn sum_of_squares(motions: &[Motion]) -> f64 {
    motions.iter().map(|motion| motion.misfit).sum()
}

/// Squared distance of a reading from its prediction, over their variances.
fn distance(measured: &MassLine, predicted: &MassLine) -> f64 {
    (measured.value - predicted.value).powi(2) / (measured.variance + predicted.variance)
}

/// The hypotheses about one sensor; the motions fit the others.
fn of_sensor(rows: &Rows, seen: &[Vec<f64>], fit: &FitWithout) -> Vec<Hypothesis> {
    let (sensor, motions) = (fit.sensor, fit.motions.as_slice());
    let others = fit.sum_of_squares();
    let (dof, placed) = &rows.sensors[sensor];
    let readings: Vec<Reading> = (0..rows.columns)
        .filter_map(|hit| {
            let line = rows.reading(sensor, hit)?;
            Some(Reading { hit, line })
        })
        .collect();
    let left = |row: &[f64], factor: f64| {
        let of_hit = |reading: &Reading| {
            let scaled = MassLine {
                value: factor * reading.line.value,
                variance: factor * factor * reading.line.variance,
            };
            distance(&scaled, &motions[reading.hit].reading(row))
        };
        others + readings.iter().map(of_hit).sum::<f64>()
    };
    let row_of_sensor = &seen[sensor];
    let sign = left(row_of_sensor, -1.0);
    let mut hypotheses = vec![Hypothesis {
        repair: Repair::Sign(dof.clone()),
        sum_of_squares: sign,
    }];
    if let Some(FittedGain { gain, std }) = fit_gain(&readings, motions, row_of_sensor) {
        let left = left(row_of_sensor, gain.recip());
        let is_sign = gain < 0.0 && sign - left < MIN_FALL_OF_GAIN;
        if !is_sign {
            let dof = dof.clone();
            hypotheses.push(Hypothesis {
                repair: Repair::Gain { dof, gain, std },
                sum_of_squares: left,
            });
        }
    }
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            let along: f64 = placed
                .direction
                .iter()
                .zip(direction)
                .map(|(a, b)| a * b)
                .sum();
            let mut turned = *placed;
            turned.direction = direction;
            // The stated axis is a matter of its sign.
            let row = rows.seen_row(&turned).filter(|_| along.abs() < 0.9);
            if let Some(row) = row {
                let dof = dof.clone();
                let repair = Repair::Direction { dof, direction };
                hypotheses.push(Hypothesis {
                    repair,
                    sum_of_squares: left(&row, 1.0),
                });
            }
        }
    }
    hypotheses
}

/// What a sensor reads over what it should, with its standard deviation.
struct FittedGain {
    gain: f64,
    std: f64,
}

/// A gain by least squares with the variances of the readings; `None` where the prediction is too
/// uncertain.
fn fit_gain(readings: &[Reading], motions: &[Motion], row: &[f64]) -> Option<FittedGain> {
    let (mut product, mut square, mut signal) = (0.0, 0.0, 0.0);
    for Reading { hit, line } in readings {
        let predicted = motions[*hit].reading(row);
        product += line.value * predicted.value / line.variance;
        square += predicted.value * predicted.value / line.variance;
        signal += predicted.value * predicted.value / predicted.variance;
    }
    let gain = product / square;
    // A prediction that is all uncertainty fits any gain.
    let is_known = signal > MIN_FALL && gain.is_finite() && gain.abs() > 1e-6;
    // The readings are uncertain, and what they are compared with.
    let std = (square.recip() + gain * gain / signal).sqrt();
    is_known.then_some(FittedGain { gain, std })
}

/// Every two suspects in each other's place. An exchange changes two rows of the normal equations,
/// so that each pair costs the same with any number of sensors.
fn exchanges(rows: &Rows, seen: &[Vec<f64>], suspects: &[usize]) -> Vec<Hypothesis> {
    let equations = rows.normal_equations(seen, &[]);
    let mut hypotheses = Vec::new();
    for (place, &one) in suspects.iter().enumerate() {
        for &other in &suspects[place + 1..] {
            let mut components = seen[one].iter().zip(&seen[other]);
            let is_same_row = components.all(|(a, b)| (a - b).abs() < 1e-9);
            let exchanged = |hit: usize| {
                let mut equations = equations[hit].clone();
                for (sensor, partner) in [(one, other), (other, one)] {
                    if let Some(line) = rows.reading(sensor, hit) {
                        equations.add(&seen[sensor], &line, -1.0);
                        equations.add(&seen[partner], &line, 1.0);
                    }
                }
                equations.motion()
            };
            let motions = || (0..rows.columns).map(exchanged).collect();
            let motions: Option<Vec<Motion>> = if is_same_row { None } else { motions() };
            if let Some(motions) = motions {
                let [a, b] = [one, other].map(|sensor| rows.sensors[sensor].0.clone());
                hypotheses.push(Hypothesis {
                    repair: Repair::Exchanged(a, b),
                    sum_of_squares: sum_of_squares(&motions),
                });
            }
        }
    }
    hypotheses
}

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
const MIN_FALL: f64 = 30.0;
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

/// The one fault that explains what does not fit; `None` where all sensors fit, or no single fault
/// explains it.
pub(super) fn find(rows: &Rows) -> Option<SensorFault> {
    let seen = rows.seen_rows();
    let all = rows.fit(&seen, &[])?;
    let total = sum(&all);
    let freedom: f64 = all.iter().map(|motion| motion.freedom).sum();
    // No repair of a sensor takes away more than leaving it out does.
    let fits: Vec<(usize, Vec<Motion>)> = (0..rows.sensors.len())
        .filter_map(|sensor| Some((sensor, rows.fit(&seen, &[sensor])?)))
        .filter(|(_, without)| total - sum(without) >= MIN_FALL_OF_ONE)
        .collect();
    let suspects: Vec<usize> = fits.iter().map(|(sensor, _)| *sensor).collect();
    let of_fit =
        |(sensor, without): &(usize, Vec<Motion>)| of_sensor(rows, &seen, *sensor, without);
    let mut hypotheses: Vec<(f64, Repair)> = fits.iter().flat_map(of_fit).collect();
    hypotheses.extend(exchanges(rows, &seen, &suspects));
    hypotheses.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (left, repair) = hypotheses.first()?;
    let fall = total - left;
    let explained = fall >= MIN_FALL && fall >= MIN_FALL_PART * (total - freedom);
    let dof = repair_dof(repair);
    let is_rival = |(_, other): &&(f64, Repair)| !is_same(repair, other);
    let rival = hypotheses.iter().skip(1).find(is_rival);
    if !explained {
        return None;
    }
    let lead = rival.map_or(f64::INFINITY, |(other, _)| other - left);
    if lead >= MIN_LEAD {
        let repair = repair.clone();
        return Some(SensorFault { dof, repair, fall });
    }
    let repair = ambiguous(&hypotheses, *left)?;
    let is_it = |(sensor, _): &&(usize, Vec<Motion>)| rows.sensors[*sensor].0 == dof;
    let fall = fits
        .iter()
        .find(is_it)
        .map(|(_, without)| total - sum(without))?;
    Some(SensorFault { dof, repair, fall })
}

/// Of hypotheses that are too near to tell: the sensor, where all are about it.
fn ambiguous(hypotheses: &[(f64, Repair)], best: f64) -> Option<Repair> {
    let near = hypotheses.iter().filter(|(left, _)| left - best < MIN_LEAD);
    let mut dofs = near.map(|(_, repair)| repair_dof(repair));
    let first = dofs.next()?;
    dofs.all(|dof| dof == first)
        .then_some(Repair::LeftOut(first))
}

fn repair_dof(repair: &Repair) -> Dof {
    match repair {
        Repair::Sign(dof) | Repair::LeftOut(dof) | Repair::Exchanged(dof, _) => dof.clone(),
        Repair::Gain { dof, .. } | Repair::Direction { dof, .. } => dof.clone(),
    }
}

/// Whether two repairs say the same of the same sensor: a gain of −1 is the other sign.
fn is_same(one: &Repair, other: &Repair) -> bool {
    match (one, other) {
        (Repair::Sign(a), Repair::Gain { dof: b, gain, .. }) => a == b && *gain < 0.0,
        (Repair::Gain { dof: a, gain, .. }, Repair::Sign(b)) => a == b && *gain < 0.0,
        (a, b) => a == b,
    }
}

fn sum(motions: &[Motion]) -> f64 {
    motions.iter().map(|motion| motion.misfit).sum()
}

/// Squared distance of a reading from its prediction, over their variances.
fn distance(measured: &MassLine, predicted: &MassLine) -> f64 {
    (measured.value - predicted.value).powi(2) / (measured.variance + predicted.variance)
}

/// The hypotheses about one sensor with the sums of squares that they leave; `motions` fit the
/// others.
fn of_sensor(
    rows: &Rows,
    seen: &[Vec<f64>],
    sensor: usize,
    motions: &[Motion],
) -> Vec<(f64, Repair)> {
    let others = sum(motions);
    let (dof, placed) = &rows.sensors[sensor];
    let measured: Vec<(usize, MassLine)> = (0..rows.hits.len())
        .filter_map(|hit| {
            let line = rows.entries[sensor][hit]?;
            let variance = rows.variance(sensor, hit)?;
            Some((hit, MassLine { variance, ..line }))
        })
        .collect();
    let left = |row: &[f64], factor: f64| {
        let of_hit = |(hit, line): &(usize, MassLine)| {
            let scaled = MassLine {
                value: factor * line.value,
                variance: factor * factor * line.variance,
            };
            distance(&scaled, &motions[*hit].reading(row))
        };
        others + measured.iter().map(of_hit).sum::<f64>()
    };
    let row_of_sensor = &seen[sensor];
    let sign = left(row_of_sensor, -1.0);
    let mut hypotheses = vec![(sign, Repair::Sign(dof.clone()))];
    if let Some((gain, std)) = gain(&measured, motions, row_of_sensor) {
        let left = left(row_of_sensor, gain.recip());
        let is_sign = gain < 0.0 && sign - left < MIN_FALL_OF_GAIN;
        if !is_sign {
            let dof = dof.clone();
            hypotheses.push((left, Repair::Gain { dof, gain, std }));
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
                hypotheses.push((left(&row, 1.0), repair));
            }
        }
    }
    hypotheses
}

/// What a sensor reads over what it should, by least squares with the variances of its readings,
/// and its standard deviation.
fn gain(measured: &[(usize, MassLine)], motions: &[Motion], row: &[f64]) -> Option<(f64, f64)> {
    let (mut product, mut square, mut signal) = (0.0, 0.0, 0.0);
    for (hit, line) in measured {
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
    is_known.then_some((gain, std))
}

/// Every two suspects in each other's place.
fn exchanges(rows: &Rows, seen: &[Vec<f64>], suspects: &[usize]) -> Vec<(f64, Repair)> {
    let mut hypotheses = Vec::new();
    for (place, &one) in suspects.iter().enumerate() {
        for &other in &suspects[place + 1..] {
            let mut exchanged = seen.to_vec();
            exchanged.swap(one, other);
            let is_same_row = seen[one]
                .iter()
                .zip(&seen[other])
                .all(|(a, b)| (a - b).abs() < 1e-9);
            let motions = (!is_same_row).then(|| rows.fit(&exchanged, &[])).flatten();
            if let Some(motions) = motions {
                let [a, b] = [one, other].map(|sensor| rows.sensors[sensor].0.clone());
                hypotheses.push((sum(&motions), Repair::Exchanged(a, b)));
            }
        }
    }
    hypotheses
}

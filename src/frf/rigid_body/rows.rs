//! Sensors as rows of the motion of a rigid body.
//!
//! A sensor at r with direction d reads `d·(a + α × r) = [d, r × d]·[a, α]`: a row of six numbers
//! times the acceleration of the body. A hit at a point is such a row too.

use std::collections::{BTreeMap, BTreeSet};

use super::mass_line::MassLine;
use super::misfit::Misfit;
use super::repair::Repair;
use crate::dof::Dof;
use crate::frf::FrfSet;
use crate::linalg::{RealMatrix, real_matrix, solve_definite, symmetric_eigen};

/// Errors of calibrations, positions and directions, over the root mean square of the sensors of a
/// hit. Larger: a gain that is 3 % wrong is not seen. Smaller: a sensor that sits a millimetre
/// beside its stated point is named (`a_wrong_sensor_is_named_and_repaired`).
const CALIBRATION_ERROR: f64 = 0.005;
/// Eigenvalue of the rows' Gram matrix over the largest, below which they do not see a motion.
const MIN_EIGENVALUE: f64 = 1e-6;

/// Least part of a row that lies in the motions that the others see, where they can tell of it.
const MIN_SEEN_PART: f64 = 0.99;

/// Where a degree of freedom is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedSensor {
    /// Position in one frame, m.
    pub at_m: [f64; 3],
    /// Unit direction of its positive axis.
    pub direction: [f64; 3],
}

impl PlacedSensor {
    /// `[d, r × d]` with lengths over `length_m` from `origin_m`.
    pub(super) fn row(&self, frame: &Frame) -> [f64; 6] {
        let [dx, dy, dz] = self.direction;
        let from = |axis: usize| (self.at_m[axis] - frame.origin_m[axis]) / frame.length_m;
        let (x, y, z) = (from(0), from(1), from(2));
        [
            dx,
            dy,
            dz,
            y * dz - z * dy,
            z * dx - x * dz,
            x * dy - y * dx,
        ]
    }
}

/// Origin and unit of length of the rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub origin_m: [f64; 3],
    pub length_m: f64,
}

/// A measured value with its variance; nothing where a sensor has no FRF of a hit.
pub(super) type Entry = Option<MassLine>;

/// Mass lines of placed sensors, by sensor and hit.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub sensors: Vec<(Dof, PlacedSensor)>,
    /// The hits of the columns; none where these are of modes.
    pub hits: Vec<(Dof, PlacedSensor)>,
    /// Number of motions that are measured: of hits, or real and imaginary parts of modes.
    pub columns: usize,
    pub frame: Frame,
    /// By sensor, then by column.
    pub entries: Vec<Vec<Entry>>,
    /// Motions that the sensors see: six × rank.
    pub motions: RealMatrix,
    /// Variance of errors of calibration, by hit.
    calibration: Vec<f64>,
}

impl Rows {
    /// The placed sensors of a set; `None` where they are no more than the motions they see.
    ///
    /// With more hits than sensors, as of a roving hammer, hits and sensors change places: the mass
    /// line is the same either way.
    pub fn new(
        set: &FrfSet,
        placed: &BTreeMap<Dof, PlacedSensor>,
        lines: &[MassLine],
    ) -> Option<Self> {
        let place = |dof: &Dof| placed.get(&dof.positive().with_repeat(1)).copied();
        let mut functions = BTreeMap::new();
        for (function, line) in set.functions().iter().zip(lines) {
            let (response, reference) = (&function.response, &function.reference);
            if place(response).is_some() && place(reference).is_some() {
                let line = MassLine {
                    value: line.value * response.sign() * reference.sign(),
                    ..*line
                };
                functions.insert((response.clone(), reference.clone()), line);
            }
        }
        let responses: BTreeSet<&Dof> = functions.keys().map(|(response, _)| response).collect();
        let references: BTreeSet<&Dof> = functions.keys().map(|(_, reference)| reference).collect();
        let is_roving_hammer = references.len() > responses.len();
        let (sensors, hits) = match is_roving_hammer {
            true => (references, responses),
            false => (responses, references),
        };
        let located = |dofs: BTreeSet<&Dof>| -> Vec<(Dof, PlacedSensor)> {
            let dofs = dofs.into_iter();
            dofs.filter_map(|dof| Some((dof.clone(), place(dof)?)))
                .collect()
        };
        let (sensors, hits) = (located(sensors), located(hits));
        let entry = |sensor: &Dof, hit: &Dof| {
            let (sensor, hit) = (sensor.clone(), hit.clone());
            let pair = if is_roving_hammer {
                (hit, sensor)
            } else {
                (sensor, hit)
            };
            functions.get(&pair).copied()
        };
        let entries = sensors
            .iter()
            .map(|(sensor, _)| hits.iter().map(|(hit, _)| entry(sensor, hit)).collect())
            .collect();
        Self::of_entries(sensors, hits, entries)
    }

    /// From values by sensor and column; without hits where the columns are of modes.
    pub fn of_entries(
        sensors: Vec<(Dof, PlacedSensor)>,
        hits: Vec<(Dof, PlacedSensor)>,
        entries: Vec<Vec<Entry>>,
    ) -> Option<Self> {
        let frame = frame_of(&sensors)?;
        let rows: Vec<[f64; 6]> = sensors
            .iter()
            .map(|(_, placed)| placed.row(&frame))
            .collect();
        let motions = seen_motions(&rows)?;
        let calibration = |hit: usize| {
            let of_hit: Vec<MassLine> = entries.iter().filter_map(|row| row[hit]).collect();
            let power: f64 = of_hit.iter().map(|line| line.value * line.value).sum();
            CALIBRATION_ERROR * CALIBRATION_ERROR * power / of_hit.len().max(1) as f64
        };
        let columns = entries.first().map_or(0, Vec::len);
        let calibration = (0..columns).map(calibration).collect();
        (sensors.len() > motions.ncols()).then_some(Self {
            sensors,
            hits,
            columns,
            frame,
            entries,
            motions,
            calibration,
        })
    }

    /// The row of a sensor at this place in the motions that all sensors see; `None` where it
    /// mostly sees another one.
    pub fn seen_row(&self, placed: &PlacedSensor) -> Option<Vec<f64>> {
        let row = placed.row(&self.frame);
        let seen = self.projected(&row);
        let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        (square(&seen) > MIN_SEEN_PART * square(&row)).then_some(seen)
    }

    fn projected(&self, row: &[f64; 6]) -> Vec<f64> {
        let along = |motion| (0..6).map(|i| row[i] * self.motions[(i, motion)]).sum();
        (0..self.motions.ncols()).map(along).collect()
    }

    /// The rows of all sensors.
    pub fn seen_rows(&self) -> Vec<Vec<f64>> {
        let row = |(_, placed): &(Dof, PlacedSensor)| self.projected(&placed.row(&self.frame));
        self.sensors.iter().map(row).collect()
    }

    /// Variance of an entry with errors of calibration.
    pub fn variance(&self, sensor: usize, hit: usize) -> Option<f64> {
        Some(self.entries[sensor][hit]?.variance + self.calibration[hit])
    }

    /// The motion that fits the sensors of each hit.
    pub fn fit(&self, rows: &[Vec<f64>], left_out: &[usize]) -> Option<Vec<Motion>> {
        let equations = self.normal_equations(rows, left_out);
        equations.iter().map(NormalEquations::motion).collect()
    }

    /// The normal equations of the motion of each hit.
    pub fn normal_equations(&self, rows: &[Vec<f64>], left_out: &[usize]) -> Vec<NormalEquations> {
        let of_hit = |hit: usize| {
            let mut equations = NormalEquations::new(self.motions.ncols());
            for (sensor, row) in rows.iter().enumerate() {
                if !left_out.contains(&sensor)
                    && let Some(line) = self.reading(sensor, hit)
                {
                    equations.add(row, &line, 1.0);
                }
            }
            equations
        };
        (0..self.columns).map(of_hit).collect()
    }

    /// An entry with its variance with errors of calibration.
    pub fn reading(&self, sensor: usize, hit: usize) -> Entry {
        let line = self.entries[sensor][hit]?;
        let variance = self.variance(sensor, hit)?;
        (variance > 0.0).then_some(MassLine { variance, ..line })
    }

    /// How well the sensors fit; `None` where they are no more than the motions they see.
    pub fn misfit(&self) -> Option<Misfit> {
        let motions = self.fit(&self.seen_rows(), &[])?;
        let freedom: f64 = motions.iter().map(|motion| motion.freedom).sum();
        let misfit: f64 = motions.iter().map(|motion| motion.misfit).sum();
        (freedom > 0.0).then(|| Misfit::new(misfit, freedom))
    }

    /// The rows with a repaired sensor.
    pub fn repaired(&self, repair: &Repair) -> Self {
        let mut rows = self.clone();
        let place = |dof: &Dof| self.sensors.iter().position(|(other, _)| other == dof);
        let scale = |rows: &mut Self, sensor: usize, factor: f64| {
            for line in rows.entries[sensor].iter_mut().flatten() {
                line.value *= factor;
                line.variance *= factor * factor;
            }
        };
        match repair {
            Repair::Sign(dof) => {
                if let Some(sensor) = place(dof) {
                    scale(&mut rows, sensor, -1.0);
                }
            }
            Repair::Gain { dof, gain, .. } => {
                if let Some(sensor) = place(dof) {
                    scale(&mut rows, sensor, gain.recip());
                }
            }
            Repair::Direction { dof, direction } => {
                if let Some(sensor) = place(dof) {
                    rows.sensors[sensor].1.direction = *direction;
                }
            }
            Repair::Exchanged(one, other) => {
                if let Some((one, other)) = place(one).zip(place(other)) {
                    rows.entries.swap(one, other);
                }
            }
            Repair::LeftOut(dof) => {
                if let Some(sensor) = place(dof) {
                    rows.entries[sensor].fill(None);
                }
            }
        }
        rows
    }
}

/// Normal equations of the motion of one hit, by least squares with the variances of the readings.
#[derive(Clone, Debug)]
pub(super) struct NormalEquations {
    normal: Vec<f64>,
    right: Vec<f64>,
    /// Sum of squares of the readings, over the variances.
    square: f64,
    count: f64,
}

impl NormalEquations {
    fn new(rank: usize) -> Self {
        Self {
            normal: vec![0.0; rank * rank],
            right: vec![0.0; rank],
            square: 0.0,
            count: 0.0,
        }
    }

    /// Adds a reading `count` times; -1 takes it away.
    pub fn add(&mut self, row: &[f64], line: &MassLine, count: f64) {
        let weight = count / line.variance;
        self.count += count;
        self.square += weight * line.value * line.value;
        for (a, of_a) in row.iter().enumerate() {
            self.right[a] += weight * of_a * line.value;
            for (b, of_b) in row.iter().enumerate() {
                self.normal[a * row.len() + b] += weight * of_a * of_b;
            }
        }
    }

    /// The motion that fits; `None` where the equations are singular.
    pub fn motion(&self) -> Option<Motion> {
        let rank = self.right.len();
        let freedom = self.count - rank as f64;
        if freedom < 0.0 {
            // Too few sensors of this hit say nothing of each other.
            return Some(Motion {
                values: vec![0.0; rank],
                covariance: real_matrix(rank, rank, |a, b| if a == b { f64::MAX } else { 0.0 }),
                misfit: 0.0,
                freedom: 0.0,
            });
        }
        let matrix = real_matrix(rank, rank, |a, b| self.normal[a * rank + b]);
        let columns = real_matrix(rank, rank + 1, |a, column| match column {
            0 => self.right[a],
            column => f64::from(u8::from(column == a + 1)),
        });
        let solved = solve_definite(&matrix, &columns).ok()?;
        let values: Vec<f64> = (0..rank).map(|a| solved[(a, 0)]).collect();
        let products = values.iter().zip(&self.right);
        let explained: f64 = products.map(|(value, right)| value * right).sum();
        Some(Motion {
            covariance: real_matrix(rank, rank, |a, b| solved[(a, b + 1)]),
            values,
            misfit: (self.square - explained).max(0.0),
            freedom,
        })
    }
}

/// The acceleration of the body in the motions that the sensors see.
pub(super) struct Motion {
    pub values: Vec<f64>,
    pub covariance: RealMatrix,
    /// Sum of squares of what does not fit, over the variances.
    pub misfit: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
}

impl Motion {
    /// What a sensor of this row reads, with its variance.
    pub fn reading(&self, row: &[f64]) -> MassLine {
        let value = row
            .iter()
            .zip(&self.values)
            .map(|(row, value)| row * value)
            .sum();
        let of_row = |a: usize| -> f64 {
            (0..row.len())
                .map(|b| self.covariance[(a, b)] * row[b])
                .sum()
        };
        MassLine {
            value,
            variance: (0..row.len()).map(|a| row[a] * of_row(a)).sum(),
        }
    }
}

/// The centre of the sensors and their root mean square distance from it.
fn frame_of(sensors: &[(Dof, PlacedSensor)]) -> Option<Frame> {
    let count = sensors.len() as f64;
    let mean = |axis: usize| sensors.iter().map(|(_, s)| s.at_m[axis]).sum::<f64>() / count;
    let origin_m = [mean(0), mean(1), mean(2)];
    let square = |placed: &PlacedSensor| -> f64 {
        (0..3)
            .map(|axis| (placed.at_m[axis] - origin_m[axis]).powi(2))
            .sum()
    };
    let length_m = (sensors.iter().map(|(_, s)| square(s)).sum::<f64>() / count).sqrt();
    (length_m > 0.0 && length_m.is_finite()).then_some(Frame { origin_m, length_m })
}

/// An orthonormal basis of the motions that rows see.
fn seen_motions(rows: &[[f64; 6]]) -> Option<RealMatrix> {
    let gram = real_matrix(6, 6, |a, b| rows.iter().map(|row| row[a] * row[b]).sum());
    let eigen = symmetric_eigen(&gram).ok()?;
    let largest = eigen.values.iter().copied().fold(0.0, f64::max);
    let seen: Vec<usize> = (0..6)
        .filter(|i| eigen.values[*i] > MIN_EIGENVALUE * largest)
        .collect();
    Some(real_matrix(6, seen.len(), |i, motion| {
        eigen.vectors[(i, seen[motion])]
    }))
}

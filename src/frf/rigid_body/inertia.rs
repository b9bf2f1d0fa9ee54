//! The ten inertia parameters of a rigid body from its mass lines.
//!
//! A hit with row `g` moves the body by `M⁻¹ gᵀ`, and a sensor with row `h` reads `h M⁻¹ gᵀ`. `M`
//! holds mass, first moments and inertia tensor about the origin: `M = [[m 1, −S], [S, J]]` with
//! `S = [m c]×`. Newton's and Euler's equations `M q = gᵀ` are linear in the ten parameters and
//! start the iteration (Almeida, Urgueira and Maia 2007); Gauss-Newton steps with the variances of
//! the mass lines end it.

use super::rows::{Frame, PlacedSensor, Rows};
use crate::linalg::{RealMatrix, real_matrix, solve_definite, symmetric_eigen};

/// Parameters: mass, three first moments, six of the tensor (xx, yy, zz, xy, xz, yz).
const PARAMETERS: usize = 10;
const MAX_STEPS: usize = 30;
/// Relative step at which the iteration ends.
const TOLERANCE: f64 = 1e-10;
/// Largest relative standard deviation of a mass that is shown.
const MAX_MASS_DEVIATION: f64 = 0.2;
/// Least eigenvalue of the sum of `d dᵀ` over the unit directions of hits in three directions: one
/// hit at 15° from the plane of all others.
const MIN_DIRECTION: f64 = 0.067;

/// Inertia of a body, in the frame of the sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Its standard deviation, kg.
    pub mass_std_kg: f64,
    /// Centre of mass, m.
    pub centre_m: [f64; 3],
    /// Its standard deviations, m.
    pub centre_std_m: [f64; 3],
    /// Inertia tensor about the centre of mass: xx, yy, zz, xy, xz, yz, kg m².
    pub tensor_kg_m2: [f64; 6],
}

/// Why a mass line gives no mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoMass {
    /// The sensors do not move as one rigid body.
    SensorsNotRigid,
    /// The sensors see fewer than six motions.
    FewMotions,
    /// Modes of the suspension without a clear peak are in the band.
    SuspensionInBand,
    /// Fewer than three hits in different directions; of a roving hammer, fewer such sensors.
    FewHits,
    /// The standard deviation of the mass is too large: the band is narrow, or the FRFs are noisy.
    Uncertain,
}

impl NoMass {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::SensorsNotRigid => "sensors-not-rigid",
            Self::FewMotions => "few-motions",
            Self::SuspensionInBand => "suspension-in-band",
            Self::FewHits => "few-hits",
            Self::Uncertain => "uncertain",
        }
    }
}

/// Fits the parameters.
pub(super) fn fit(rows: &Rows) -> Result<Inertia, NoMass> {
    if rows.motions.ncols() < 6 {
        return Err(NoMass::FewMotions);
    }
    let cause = match are_in_three_directions(rows) {
        true => NoMass::Uncertain,
        false => NoMass::FewHits,
    };
    fit_parameters(rows).ok_or(cause)
}

/// Whether the hits are in three directions that differ.
fn are_in_three_directions(rows: &Rows) -> bool {
    let directions = rows.hits.iter().map(|(_, hit)| hit.direction);
    let directions: Vec<[f64; 3]> = directions.collect();
    let gram = |a: usize, b: usize| directions.iter().map(|d| d[a] * d[b]).sum::<f64>();
    let eigen = symmetric_eigen(&real_matrix(3, 3, gram));
    eigen.is_ok_and(|eigen| eigen.values.iter().all(|value| *value > MIN_DIRECTION))
}

fn fit_parameters(rows: &Rows) -> Option<Inertia> {
    let hit_rows: Vec<[f64; 6]> = rows
        .hits
        .iter()
        .map(|(_, hit)| hit.row(&rows.frame))
        .collect();
    let mut parameters = start(rows, &hit_rows)?;
    let mut last = None;
    for _ in 0..MAX_STEPS {
        let step = step(rows, &hit_rows, &parameters)?;
        let size = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
        parameters
            .iter_mut()
            .zip(&step.change)
            .for_each(|(p, change)| *p += change);
        let is_last = size(&step.change) <= TOLERANCE * size(&parameters);
        last = Some(step);
        if is_last {
            break;
        }
    }
    described(&parameters, &last?, &rows.frame)
}

/// The inertia matrix of parameters in the frame's units.
fn inertia_matrix(p: &[f64]) -> RealMatrix {
    let [m, x, y, z] = [p[0], p[1], p[2], p[3]];
    let tensor = [[p[4], p[7], p[8]], [p[7], p[5], p[9]], [p[8], p[9], p[6]]];
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    real_matrix(6, 6, |a, b| match (a < 3, b < 3) {
        (true, true) => f64::from(u8::from(a == b)) * m,
        (true, false) => -cross[a][b - 3],
        (false, true) => cross[a - 3][b],
        (false, false) => tensor[a - 3][b - 3],
    })
}

fn derivative(parameter: usize) -> RealMatrix {
    let mut unit = [0.0; PARAMETERS];
    unit[parameter] = 1.0;
    inertia_matrix(&unit)
}

/// Parameters of Newton's and Euler's equations for the fitted motion of every hit.
fn start(rows: &Rows, hits: &[[f64; 6]]) -> Option<Vec<f64>> {
    let motions = rows.fit(&rows.seen_rows(), &[])?;
    let acceleration = |hit: usize, axis: usize| -> f64 {
        let values = motions[hit].values.iter().enumerate();
        values
            .map(|(motion, value)| rows.motions[(axis, motion)] * value)
            .sum()
    };
    let equations: Vec<([f64; PARAMETERS], f64)> = (0..hits.len())
        .flat_map(|hit| (0..6).map(move |axis| (hit, axis)))
        .map(|(hit, axis)| {
            let coefficient = |parameter: usize| -> f64 {
                let of_parameter = derivative(parameter);
                (0..6)
                    .map(|b| of_parameter[(axis, b)] * acceleration(hit, b))
                    .sum()
            };
            (std::array::from_fn(coefficient), hits[hit][axis])
        })
        .collect();
    let normal = real_matrix(PARAMETERS, PARAMETERS, |a, b| {
        equations.iter().map(|(row, _)| row[a] * row[b]).sum()
    });
    let right = real_matrix(PARAMETERS, 1, |a, _| {
        equations.iter().map(|(row, value)| row[a] * value).sum()
    });
    let solved = solve_definite(&normal, &right).ok()?;
    let parameters: Vec<f64> = (0..PARAMETERS).map(|a| solved[(a, 0)]).collect();
    inverse(&inertia_matrix(&parameters)).map(|_| parameters)
}

fn inverse(matrix: &RealMatrix) -> Option<RealMatrix> {
    let unit = real_matrix(6, 6, |a, b| f64::from(u8::from(a == b)));
    solve_definite(matrix, &unit).ok()
}

/// A Gauss-Newton step with the covariance of the parameters.
struct Step {
    change: Vec<f64>,
    covariance: RealMatrix,
}

fn step(rows: &Rows, hits: &[[f64; 6]], parameters: &[f64]) -> Option<Step> {
    let mobility = inverse(&inertia_matrix(parameters))?;
    let times = |row: &[f64; 6]| -> [f64; 6] {
        std::array::from_fn(|a| (0..6).map(|b| mobility[(a, b)] * row[b]).sum())
    };
    let derivatives: Vec<RealMatrix> = (0..PARAMETERS).map(derivative).collect();
    let of_hits: Vec<[f64; 6]> = hits.iter().map(times).collect();
    let mut normal = vec![0.0; PARAMETERS * PARAMETERS];
    let mut right = [0.0; PARAMETERS];
    let (mut square, mut count) = (0.0, 0.0);
    for (sensor, (_, placed)) in rows.sensors.iter().enumerate() {
        let row = PlacedSensor::row(placed, &rows.frame);
        let of_sensor = times(&row);
        for (hit, of_hit) in of_hits.iter().enumerate() {
            let Some(line) = rows.entries[sensor][hit] else {
                continue;
            };
            let computed: f64 = row.iter().zip(of_hit).map(|(a, b)| a * b).sum();
            let gradient: [f64; PARAMETERS] = std::array::from_fn(|parameter| {
                let of_parameter = &derivatives[parameter];
                let pairs = (0..6).flat_map(|a| (0..6).map(move |b| (a, b)));
                -pairs
                    .map(|(a, b)| of_sensor[a] * of_parameter[(a, b)] * of_hit[b])
                    .sum::<f64>()
            });
            let residual = line.value - computed;
            square += residual * residual / line.variance;
            count += 1.0;
            for a in 0..PARAMETERS {
                right[a] += gradient[a] * residual / line.variance;
                for b in 0..PARAMETERS {
                    normal[a * PARAMETERS + b] += gradient[a] * gradient[b] / line.variance;
                }
            }
        }
    }
    let matrix = real_matrix(PARAMETERS, PARAMETERS, |a, b| normal[a * PARAMETERS + b]);
    let columns = real_matrix(PARAMETERS, PARAMETERS + 1, |a, column| match column {
        0 => right[a],
        column => f64::from(u8::from(column == a + 1)),
    });
    let solved = solve_definite(&matrix, &columns).ok()?;
    // Errors of calibration are not in the variances of the lines.
    let freedom = count - PARAMETERS as f64;
    let excess = if freedom > 0.0 {
        (square / freedom).max(1.0)
    } else {
        1.0
    };
    Some(Step {
        change: (0..PARAMETERS).map(|a| solved[(a, 0)]).collect(),
        covariance: real_matrix(PARAMETERS, PARAMETERS, |a, b| excess * solved[(a, b + 1)]),
    })
}

/// The parameters in SI units about the centre of mass; `None` where they are none of a body.
fn described(p: &[f64], last: &Step, frame: &Frame) -> Option<Inertia> {
    let mass = p[0];
    let deviation = |parameter: usize| last.covariance[(parameter, parameter)].max(0.0).sqrt();
    if !(mass > 0.0 && deviation(0) <= MAX_MASS_DEVIATION * mass) {
        return None;
    }
    let length = frame.length_m;
    let centre: [f64; 3] = std::array::from_fn(|axis| p[1 + axis] / mass);
    // c = s/m: var c = (var s + c² var m − 2 c cov(s, m))/m².
    let centre_std_m = std::array::from_fn(|axis| {
        let (s, c) = (1 + axis, centre[axis]);
        let variance = last.covariance[(s, s)] + c * c * last.covariance[(0, 0)]
            - 2.0 * c * last.covariance[(s, 0)];
        length * variance.max(0.0).sqrt() / mass
    });
    let [x, y, z] = centre;
    let shifted = [
        p[4] - mass * (y * y + z * z),
        p[5] - mass * (x * x + z * z),
        p[6] - mass * (x * x + y * y),
        p[7] + mass * x * y,
        p[8] + mass * x * z,
        p[9] + mass * y * z,
    ];
    Some(Inertia {
        mass_kg: mass,
        mass_std_kg: deviation(0),
        centre_m: std::array::from_fn(|axis| frame.origin_m[axis] + length * centre[axis]),
        centre_std_m,
        tensor_kg_m2: shifted.map(|value| value * length * length),
    })
}

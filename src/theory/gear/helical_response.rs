//! The steady response of the helical planetary gear in four details, and the results that the
//! paper states.

use rayon::prelude::*;

use crate::theory::integrate::{Integrator, RungeKutta4};
use crate::theory::parameter::index_of;
use crate::theory::response::{
    DetailResponse, Nonlinear, ResponseSignal, ResponseSpan, TimeResponse,
};
use crate::theory::{ModeOptions, ModelQuantity, TheoreticalModel, TheoryError, modes};

use super::HelicalPlanetary;
use super::helical_checks::check_quantities;
use super::helical_mesh::{Detail, MeshState};
use super::helical_motion::{COORDINATES, Motion};
use super::helical_parameters::{PLANETS, RING_TEETH, SUN_TEETH};

/// Harmonics of the mesh frequency that are reported: up to 22 kHz at 80 rpm, above every natural
/// frequency.
const HARMONICS: usize = 200;
/// Corners of the mesh stiffness lie on multiples of this part of the period.
const CORNERS: usize = 100;
/// A line of the spectrum counts from this part of the largest.
const LINE: f64 = 0.01;
/// Ratios of bearing to mean mesh stiffness at which the details are compared.
/// The second brings a natural frequency to the mesh frequency, where they are farthest apart.
pub(super) const RATIOS: [f64; 8] = [2.5e-3, 7.5e-3, 2.5e-2, 0.1, 0.375, 1.0, 3.75, 25.0];
/// The span for it: the differences are reported to two digits.
const SHORT: ResponseSpan = ResponseSpan {
    settling_periods: 60,
    recorded_periods: 10,
    step_radians: 0.6,
};
/// Bearing stiffness of the paper's figure 5, N/m.
const STIFF_BEARING: f64 = 1e10;
const BEARINGS: [&str; 3] = ["k_c", "k_s", "k_p"];
/// As the paper prints them.
const PRINTED_RING_TEETH: f64 = 82.0;
const PRINTED_PLANET_TEETH: f64 = 31.0;
const PRINTED_DRIVE_NM: f64 = 9.65;

impl Nonlinear for HelicalPlanetary {
    fn response(&self, values: &[f64], span: ResponseSpan) -> Result<TimeResponse, TheoryError> {
        let details: &[Detail] = match self.is_torsional() {
            true => &Detail::ALL[..1],
            false => &Detail::ALL,
        };
        self.responses(values, span, details)
    }
}

impl HelicalPlanetary {
    /// The response with some details, side by side in the caller's pool.
    pub(super) fn responses(
        &self,
        values: &[f64],
        span: ResponseSpan,
        details: &[Detail],
    ) -> Result<TimeResponse, TheoryError> {
        span.check()?;
        let steps = self.steps_per_period(values, span)?;
        let motions = details
            .iter()
            .map(|detail| Motion::new(self, values, *detail));
        let motions: Result<Vec<Motion>, TheoryError> = motions.collect();
        Ok(side_by_side(&motions?, span, steps))
    }

    /// The responses by constant and printed varying angle with the teeth that the ring has in
    /// print.
    fn printed_teeth(
        &self,
        values: &[f64],
        span: ResponseSpan,
    ) -> Result<TimeResponse, TheoryError> {
        let steps = self.steps_per_period(values, span)?;
        let details = [Detail::ConstantAngle, Detail::PrintedAngle].into_iter();
        let motions = details.map(|detail| {
            let motion = Motion::new(self, values, detail)?;
            Ok(motion.with_ring_teeth(PRINTED_RING_TEETH))
        });
        let motions: Result<Vec<Motion>, TheoryError> = motions.collect();
        Ok(side_by_side(&motions?, span, steps))
    }

    /// Steps per mesh period, with every corner of the stiffness on one.
    fn steps_per_period(&self, values: &[f64], span: ResponseSpan) -> Result<usize, TheoryError> {
        let solved = modes(self, values, &[], &ModeOptions::default())?;
        let highest = solved.omega_rad_s.iter().copied().fold(0.0, f64::max);
        let period_s = Motion::new(self, values, Detail::ConstantAngle)?.mesh_period_s();
        let needed = highest * period_s / span.step_radians / (2 * CORNERS) as f64;
        Ok(2 * CORNERS * needed.ceil().max(1.0) as usize)
    }
}

/// Responses of one machine from the equilibrium, with so many steps per period.
fn side_by_side(motions: &[Motion], span: ResponseSpan, steps: usize) -> TimeResponse {
    let run_motion = |motion: &Motion| run(motion, motion.equilibrium(), span, steps);
    TimeResponse {
        excitation_hz: 1.0 / motions[0].mesh_period_s(),
        span,
        details: motions.par_iter().map(run_motion).collect(),
    }
}

/// Signal values of one instant.
fn readings(motion: &Motion, time_s: f64, state: &[f64]) -> [f64; 8] {
    let all: [[MeshState; 2]; PLANETS] =
        std::array::from_fn(|planet| motion.meshes(time_s, state, planet));
    let force = |planet: usize, kind: usize| {
        let mesh = &all[planet][kind];
        mesh.stiffness_n_per_m * mesh.compression_m
    };
    let shared = |kind: usize| {
        let total: f64 = (0..PLANETS).map(|planet| force(planet, kind)).sum();
        PLANETS as f64 * force(0, kind) / total
    };
    let [sun, ring] = &all[0];
    let rest = motion.rest_angles();
    let turned = |kind: usize| (all[0][kind].angle_rad - rest[kind]).to_degrees();
    [
        sun.compression_m,
        ring.compression_m,
        shared(0),
        shared(1),
        turned(0),
        turned(1),
        state[3],
        state[4],
    ]
}

const SIGNALS: [(&str, &str, &str); 8] = [
    (
        "delta_sp1",
        "m",
        "deflection of the mesh of sun and planet 1",
    ),
    (
        "delta_rp1",
        "m",
        "deflection of the mesh of ring and planet 1",
    ),
    (
        "load_sp1",
        "",
        "load sharing of planet 1 at the sun, 4 k δ / sum of k δ",
    ),
    ("load_rp1", "", "load sharing of planet 1 at the ring"),
    (
        "angle_sp1",
        "deg",
        "change of the pressure angle of sun and planet 1",
    ),
    (
        "angle_rp1",
        "deg",
        "change of the pressure angle of ring and planet 1",
    ),
    ("x_s", "m", "displacement of the sun along x"),
    ("y_s", "m", "displacement of the sun along y"),
];

/// The response from a start, with so many steps per period.
pub(super) fn run(
    motion: &Motion,
    mut state: Vec<f64>,
    span: ResponseSpan,
    steps: usize,
) -> DetailResponse {
    let step_s = motion.mesh_period_s() / steps as f64;
    let mut integrator = RungeKutta4::default();
    let settled = span.settling_periods * steps;
    let mut samples: Vec<Vec<f64>> = vec![Vec::new(); SIGNALS.len()];
    for step in 0..settled + span.recorded_periods * steps {
        let time_s = step as f64 * step_s;
        if step >= settled {
            let now = readings(motion, time_s, &state);
            samples
                .iter_mut()
                .zip(now)
                .for_each(|(all, value)| all.push(value));
        }
        integrator.step(motion, time_s, step_s, &mut state);
    }
    let torsional = motion.detail == Detail::Torsional;
    let moving = matches!(motion.detail, Detail::PrintedAngle | Detail::ExactAngle);
    let has = |name: &str| match name {
        "x_s" | "y_s" => !torsional,
        "angle_sp1" | "angle_rp1" => moving,
        _ => true,
    };
    let signals = SIGNALS.into_iter().zip(samples);
    let signals = signals.filter(|((name, _, _), _)| has(name));
    DetailResponse {
        detail: motion.detail.name(),
        coordinates: if torsional { 2 + PLANETS } else { COORDINATES },
        evaluations_per_period: steps * integrator.evaluations(),
        // Of the formulas, though those of an angle at rest are kept: two for the frame; three for
        // each mesh with a varying angle, and two for its printed direction.
        functions_per_evaluation: 2 + match motion.detail {
            Detail::Torsional => 0,
            Detail::ConstantAngle => 2 * 2 * PLANETS,
            Detail::PrintedAngle => 5 * 2 * PLANETS,
            Detail::ExactAngle => 5 * 2 * PLANETS,
        },
        signals: signals
            .map(|(what, samples)| ResponseSignal::new(what, samples, steps, HARMONICS))
            .collect(),
    }
}

/// How far the simpler details are from the exact one at one bearing stiffness.
#[derive(Clone, Copy, Debug)]
pub(super) struct BearingPoint {
    /// Constant angle from the exact one, relative, of the sun mesh's deflection.
    pub constant: f64,
    /// Torsional from the exact one.
    pub torsional: f64,
}

/// The comparison at every ratio of bearing to mesh stiffness.
pub(super) fn bearing_points(
    model: &HelicalPlanetary,
    values: &[f64],
) -> Result<Vec<BearingPoint>, TheoryError> {
    let parameters = model.values(values, None);
    let mesh = 0.5 * (parameters.get("k_sp").value + parameters.get("k_rp").value);
    let point = |ratio: &f64| {
        let values = with_bearings(model, values, ratio * mesh)?;
        let details = [Detail::Torsional, Detail::ConstantAngle, Detail::ExactAngle];
        let found = model.responses(&values, SHORT, &details)?;
        let from_exact = |detail: Detail| {
            found
                .difference("delta_sp1", detail.name(), Detail::ExactAngle.name())
                .unwrap_or(f64::NAN)
        };
        Ok(BearingPoint {
            constant: from_exact(Detail::ConstantAngle),
            torsional: from_exact(Detail::Torsional),
        })
    };
    RATIOS.par_iter().map(point).collect()
}

fn with_bearings(
    model: &HelicalPlanetary,
    values: &[f64],
    bearing: f64,
) -> Result<Vec<f64>, TheoryError> {
    let mut values = values.to_vec();
    for name in BEARINGS {
        values[index_of(model.name(), model.parameters(), name)?] = bearing;
    }
    Ok(values)
}

/// What the paper says in figures and words, for a model with bearings; of a torsional one the
/// geometry alone.
pub(super) fn response_quantities(
    model: &HelicalPlanetary,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let mut all = printed_data(model, values);
    if model.is_torsional() {
        return Ok(all);
    }
    let span = ResponseSpan::default();
    let soft = model.response(values, span)?;
    let stiff = with_bearings(model, values, STIFF_BEARING)?;
    let details = [
        Detail::ConstantAngle,
        Detail::PrintedAngle,
        Detail::ExactAngle,
    ];
    let stiff = model.responses(&stiff, span, &details)?;
    all.extend(check_quantities(model, values)?);
    all.extend(figures_3_to_8(&soft, &stiff));
    all.extend(printed_teeth_quantities(model, values, span)?);
    let points = bearing_points(model, values)?;
    let largest = points
        .iter()
        .map(|point| point.constant)
        .fold(0.0, f64::max);
    let least = points
        .iter()
        .map(|point| point.torsional)
        .fold(f64::MAX, f64::min);
    let tried = RATIOS.map(|ratio| ratio.to_string()).join(", ");
    let tried = format!("at bearing stiffnesses of {tried} times the mesh stiffness");
    all.push(ModelQuantity::new("worst_constant_angle", 100.0 * largest, "%", &format!("largest distance of the sun mesh's deflection by the constant angle from the exact one, {tried}")));
    all.push(ModelQuantity::new(
        "best_torsional",
        100.0 * least,
        "%",
        &format!("least distance of that of the torsional model from the exact one, {tried}"),
    ));
    Ok(all)
}

/// Figures 7 and 8 with the teeth that the ring has in print, and the angles at rest by which the
/// runs differ besides.
pub(super) fn printed_teeth_quantities(
    model: &HelicalPlanetary,
    values: &[f64],
    span: ResponseSpan,
) -> Result<[ModelQuantity; 2], TheoryError> {
    let teeth = model.printed_teeth(values, span)?;
    let ring_degrees = |detail| -> Result<f64, TheoryError> {
        let motion = Motion::new(model, values, detail)?.with_ring_teeth(PRINTED_RING_TEETH);
        Ok(motion.rest_angles()[1].to_degrees())
    };
    let constant = ring_degrees(Detail::ConstantAngle)?;
    let varying = ring_degrees(Detail::PrintedAngle)?;
    let runs = format!(
        "with 82 teeth in the ring, printed varying angle (ring mesh at rest {varying:.2} deg) against constant ({constant:.2} deg): both the variation and the angle at rest differ"
    );
    Ok([
        ModelQuantity::new(
            "load_range_change_82",
            change(&teeth, "load_sp1", range),
            "%",
            &format!("range of the load sharing factor {runs}"),
        ),
        ModelQuantity::new(
            "sun_orbit_change_82",
            change(&teeth, "x_s", ResponseSignal::deviation),
            "%",
            &format!("standard deviation of the sun's displacement {runs}"),
        ),
    ])
}

/// The teeth and torques as printed.
fn printed_data(model: &HelicalPlanetary, values: &[f64]) -> Vec<ModelQuantity> {
    let parameters = model.values(values, None);
    let module = parameters.get("base_radius_s").value
        / parameters.get("pressure_angle").value.cos()
        / SUN_TEETH;
    let distance = |sum: f64| 1e3 * module * sum;
    vec![
        ModelQuantity::new(
            "centre_distance_sun",
            distance(SUN_TEETH + PRINTED_PLANET_TEETH),
            "mm",
            "centre distance of sun and planet by their teeth",
        ),
        ModelQuantity::new(
            "centre_distance_ring_82",
            distance(PRINTED_RING_TEETH - PRINTED_PLANET_TEETH),
            "mm",
            "centre distance of planet and a ring of 82 teeth, as printed",
        ),
        ModelQuantity::new(
            "centre_distance_ring_83",
            distance(RING_TEETH - PRINTED_PLANET_TEETH),
            "mm",
            "the same with 83 teeth",
        ),
        ModelQuantity::new(
            "balanced_drive",
            parameters.get("load").value / (1.0 + RING_TEETH / SUN_TEETH),
            "N m",
            "drive torque that balances the load",
        ),
        ModelQuantity::new(
            "printed_surplus",
            PRINTED_DRIVE_NM * (1.0 + RING_TEETH / SUN_TEETH) - parameters.get("load").value,
            "N m",
            "unbalanced torque on the carrier with the printed drive of 9.65 N m",
        ),
    ]
}

/// A figure of a signal with a detail; not a number where there is none.
fn figure_of(
    response: &TimeResponse,
    detail: Detail,
    name: &str,
    figure: fn(&ResponseSignal) -> f64,
) -> f64 {
    let detail_response = response.detail(detail.name());
    detail_response
        .and_then(|detail_response| detail_response.signal(name))
        .map_or(f64::NAN, figure)
}

/// Change of a figure by the printed varying angle, percent of that with the constant one.
fn change(response: &TimeResponse, name: &str, figure: fn(&ResponseSignal) -> f64) -> f64 {
    let of = |detail| figure_of(response, detail, name, figure);
    100.0 * (of(Detail::PrintedAngle) / of(Detail::ConstantAngle) - 1.0)
}

fn range(signal: &ResponseSignal) -> f64 {
    signal.largest() - signal.least()
}

fn figures_3_to_8(soft: &TimeResponse, stiff: &TimeResponse) -> Vec<ModelQuantity> {
    let (constant, printed, exact) = (
        Detail::ConstantAngle.name(),
        Detail::PrintedAngle.name(),
        Detail::ExactAngle.name(),
    );
    let distance = |response: &TimeResponse, detail: &str, from: &str| {
        100.0
            * response
                .difference("delta_sp1", detail, from)
                .unwrap_or(f64::NAN)
    };
    let lines = |detail| {
        figure_of(soft, detail, "delta_sp1", |signal| {
            signal.lines_above(LINE) as f64
        })
    };
    let angle = |response| {
        let magnitude = ResponseSignal::magnitude;
        figure_of(response, Detail::ExactAngle, "angle_sp1", magnitude)
    };
    let spread =
        |response, detail| figure_of(response, detail, "delta_sp1", ResponseSignal::deviation);
    let figure_5 = spread(stiff, Detail::PrintedAngle);
    let figures_differ = 100.0 * (figure_5 / spread(soft, Detail::ConstantAngle) - 1.0);
    let make_quantity = |name, value, unit, what: &str| ModelQuantity::new(name, value, unit, what);
    vec![
        make_quantity(
            "peak_change",
            change(soft, "delta_sp1", ResponseSignal::largest),
            "%",
            "largest deflection of the sun mesh, printed varying angle against constant",
        ),
        make_quantity(
            "deviation_change",
            change(soft, "delta_sp1", ResponseSignal::deviation),
            "%",
            "the same of its standard deviation",
        ),
        make_quantity(
            "further_lines",
            lines(Detail::PrintedAngle) - lines(Detail::ConstantAngle),
            "",
            "harmonics above 1 % of the largest that the printed varying angle adds to the sun mesh's deflection",
        ),
        make_quantity(
            "printed_from_constant",
            distance(soft, printed, constant),
            "%",
            "distance of both deflections",
        ),
        make_quantity(
            "constant_from_exact",
            distance(soft, constant, exact),
            "%",
            "distance of the constant angle from the exact one",
        ),
        make_quantity(
            "torsional_from_exact",
            distance(soft, Detail::Torsional.name(), exact),
            "%",
            "distance of the torsional model from the exact one",
        ),
        make_quantity(
            "stiff_printed_from_constant",
            distance(stiff, printed, constant),
            "%",
            "distance of printed varying and constant angle with bearings of 1e10 N/m",
        ),
        make_quantity(
            "figure_5_from_figure_3",
            figures_differ,
            "%",
            "standard deviation of the deflection, printed varying angle with bearings of 1e10 N/m against constant angle with these",
        ),
        make_quantity(
            "angle_change",
            angle(soft),
            "deg",
            "largest change of the pressure angle of the sun mesh, exact",
        ),
        make_quantity(
            "angle_change_ratio",
            angle(soft) / angle(stiff),
            "",
            "times that with bearings of 1e10 N/m",
        ),
        make_quantity(
            "load_range_change",
            change(soft, "load_sp1", range),
            "%",
            "range of the load sharing factor, printed varying angle against constant",
        ),
        make_quantity(
            "sun_orbit_change",
            change(soft, "x_s", ResponseSignal::deviation),
            "%",
            "standard deviation of the sun's displacement, printed varying angle against constant",
        ),
    ]
}

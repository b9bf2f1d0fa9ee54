//! The stabilization diagram selects the poles that are stable while the model order rises.
//!
//! A method gives the poles of rising orders, of the whole band or of segments of it; poles that
//! are stable over three or more orders ([`pole_tracks`](crate::identify::mdof::pole_tracks)) are
//! its candidates.

use num_complex::Complex64;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::{ModelPole, is_resonance};
use crate::identify::data::peak_detection::DetectedPeaks;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, PoleAtOrder, PoleStatus, PoleTable};
use crate::identify::fit::fit_data::FitData;
use crate::identify::mdof::pole_tracks::{
    self, GlobalPole, MIN_TRACK_ORDERS, OrderPoles, StablePole, without_duplicates,
};
use crate::identify::pole_model::acceptance::MAX_BANDWIDTH_OVER_BAND;
use crate::modal::Pole;

/// Maximum number of orders.
const MAX_ORDERS: usize = 20;
/// Lowest order, and the lowest highest order that allows a stable pole.
const MIN_ORDER: usize = 2;
pub(crate) const MIN_HIGHEST_ORDER: usize = MIN_ORDER + MIN_TRACK_ORDERS - 1;
/// Largest highest order. A larger one takes minutes for a table of poles that no reader of a
/// stabilization diagram can judge: times grow with the third power.
pub(crate) const MAX_ORDER: usize = 500;
/// Maximum distance of a mode from its listed pole, in decay rates.
const MATCH_DECAY_RATES: f64 = 0.5;
/// Number of estimates with weighted lines.
const WEIGHTED_ROUNDS: usize = 2;

/// A method that estimates the poles that all FRFs share, at rising orders.
pub(in crate::identify) trait MultiModeMethod: Send + Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Whether it gives the participation factors of several inputs.
    fn gives_participation(&self) -> bool;

    /// Whether given poles change the weight of its lines.
    fn weights_lines(&self) -> bool;

    /// Poles over rising orders, by segments of the band; the lines are weighted by
    /// `weight_poles`, rad/s, where there are any.
    ///
    /// # Errors
    /// [`IdentifyError::Linalg`] when a matrix problem has no answer.
    fn segments(
        &self,
        data: &FitData,
        frf_matrix: &FrfMatrix,
        found: &DetectedPeaks,
        weight_poles: &[Complex64],
    ) -> Result<Vec<BandSegment>, IdentifyError>;
}

/// Poles over the orders of the estimate for one segment of the band.
pub(in crate::identify) struct BandSegment {
    /// Lowest damped frequency of the segment, rad/s.
    pub from_rad_s: f64,
    /// Highest.
    pub to_rad_s: f64,
    /// Poles by order, ascending.
    pub tables: Vec<OrderPoles>,
}

/// Stable poles, and the poles of all orders.
pub(in crate::identify) struct StablePoles {
    /// Stable poles, with which a fit starts.
    pub initial_poles: Vec<StablePole>,
    /// All poles in the band, by segment, order and frequency.
    pub poles: Vec<PoleAtOrder>,
}

/// Orders up to a highest one, enough for a stable pole to appear at several.
pub(in crate::identify) fn rising_orders(highest: usize) -> Vec<usize> {
    let lowest = (highest / 6).max(MIN_ORDER);
    let stride = highest.saturating_sub(lowest).div_ceil(MAX_ORDERS).max(1);
    (lowest..=highest).step_by(stride).collect()
}

/// Stable poles of a method within limits of frequency, rad/s; the lines are weighted by
/// `weight_poles`, where there are any.
///
/// # Errors
/// As [`MultiModeMethod::segments`].
pub(in crate::identify) fn stabilise(
    method: &dyn MultiModeMethod,
    data: &FitData,
    frf_matrix: &FrfMatrix,
    found: &DetectedPeaks,
    limits: [f64; 2],
    weight_poles: &[Complex64],
) -> Result<StablePoles, IdentifyError> {
    let (mut stable_poles, mut poles) = (Vec::new(), Vec::new());
    for segment in method.segments(data, frf_matrix, found, weight_poles)? {
        let tables: Vec<OrderPoles> = segment
            .tables
            .into_iter()
            .map(|(order, poles)| (order, poles_inside(&data.frfs, poles, limits)))
            .collect();
        let is_inside = |pole: &GlobalPole| {
            pole.lambda.im > segment.from_rad_s && pole.lambda.im < segment.to_rad_s
        };
        let tracked = pole_tracks::stable_poles(&tables, data.frfs.step);
        for (order, table) in &tables {
            let listed = table.iter().filter(|pole| is_inside(pole));
            poles.extend(listed.map(|pole| PoleAtOrder {
                order: *order,
                pole: Pole {
                    lambda: pole.lambda,
                },
                status: if tracked.iter().any(|seed| seed.contains(*order, pole)) {
                    PoleStatus::Stable
                } else {
                    PoleStatus::Unstable
                },
            }));
        }
        stable_poles.extend(tracked.into_iter().filter(|seed| is_inside(&seed.pole)));
    }
    let stable_poles = without_duplicates(stable_poles);
    Ok(StablePoles {
        initial_poles: stable_poles,
        poles,
    })
}

/// Stable poles of a method, estimated again [`WEIGHTED_ROUNDS`] times with lines weighted by the
/// poles before: each pole moves to the matching one of the new estimate.
///
/// # Errors
/// As [`MultiModeMethod::segments`].
pub(in crate::identify) fn stabilise_weighted(
    method: &dyn MultiModeMethod,
    data: &FitData,
    frf_matrix: &FrfMatrix,
    found: &DetectedPeaks,
    limits: [f64; 2],
) -> Result<StablePoles, IdentifyError> {
    let mut stable = stabilise(method, data, frf_matrix, found, limits, &[])?;
    let rounds = if method.weights_lines() {
        WEIGHTED_ROUNDS
    } else {
        0
    };
    for _ in 0..rounds {
        let weight_poles: Vec<Complex64> = stable
            .initial_poles
            .iter()
            .map(|seed| seed.pole.lambda)
            .collect();
        let again = stabilise(method, data, frf_matrix, found, limits, &weight_poles)?;
        stable.initial_poles = stable
            .initial_poles
            .into_iter()
            .map(|seed| pole_tracks::matching_pole(seed, &again.initial_poles))
            .collect();
        stable.initial_poles = without_duplicates(stable.initial_poles);
        stable.poles = again.poles;
    }
    // Poles without a match in the last estimate keep their position and are listed with it.
    for seed in &stable.initial_poles {
        let point = PoleAtOrder {
            order: seed.order,
            pole: Pole {
                lambda: seed.pole.lambda,
            },
            status: PoleStatus::Stable,
        };
        let same = |other: &PoleAtOrder| other.order == point.order && other.pole == point.pole;
        if !stable.poles.iter().any(same) {
            stable.poles.push(point);
        }
    }
    Ok(stable)
}

/// A model pole of one mode at each stable pole.
pub(in crate::identify) fn model_poles(
    stable_poles: &[StablePole],
    functions: usize,
) -> Vec<ModelPole> {
    let model_pole = |seed: &StablePole| {
        ModelPole::single(seed.pole.lambda, &seed.pole.participation, functions)
    };
    stable_poles.iter().map(model_pole).collect()
}

/// Position of the listed pole of a mode: the nearest within [`MATCH_DECAY_RATES`] decay rates, of
/// the order of the mode where it has one.
fn source_pole(mode: &Candidate, listing: &[PoleAtOrder]) -> Option<usize> {
    let lambda = mode.pole.lambda;
    let distance = |position: &usize| (listing[*position].pole.lambda - lambda).norm();
    let of_order = |position: &usize| {
        mode.order
            .is_none_or(|order| order == listing[*position].order)
    };
    let near = |position: &usize| distance(position) < MATCH_DECAY_RATES * lambda.re.abs();
    let matching = (0..listing.len()).filter(|position| of_order(position) && near(position));
    matching.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Gives modes without an order the order of their listed pole.
pub(in crate::identify) fn set_orders(table: &mut PoleTable) {
    for mode in &mut table.candidates {
        let source = source_pole(mode, &table.stabilization);
        mode.order = mode
            .order
            .or(source.map(|position| table.stabilization[position].order));
    }
}

/// Marks the listed poles of modes as selected.
pub(in crate::identify) fn mark_selected(table: &mut PoleTable) {
    for mode in &table.candidates {
        if let Some(position) = source_pole(mode, &table.stabilization) {
            table.stabilization[position].status = PoleStatus::Selected;
        }
    }
}

fn poles_inside(data: &BandFrfs, poles: Vec<GlobalPole>, [lo, hi]: [f64; 2]) -> Vec<GlobalPole> {
    let widest = MAX_BANDWIDTH_OVER_BAND * data.range();
    let is_inside = |pole: &GlobalPole| {
        let inside = pole.lambda.im > lo && pole.lambda.im < hi;
        inside && -2.0 * pole.lambda.re < widest && is_resonance(pole.lambda)
    };
    poles.into_iter().filter(is_inside).collect()
}

//! Stabilisation over model orders: what stays while the order of a global method rises is a pole
//! of the structure.
//!
//! A method gives the poles of rising orders, of the whole band or of parts of it; poles that stay
//! over three orders and more ([`stable`](crate::identify::mdof::pole_tracks)) are its candidates.

use num_complex::Complex64;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::{Root, resonates};
use crate::identify::data::peak_detection::Found;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, PoleAtOrder, PoleStatus, PoleTable};
use crate::identify::mdof::pole_tracks::{self, FEWEST_ORDERS, GlobalPole, Seed, Table, distinct};
use crate::identify::ml::acceptance::WIDEST;
use crate::modal::Pole;

/// Orders that are looked at.
const ORDERS: usize = 20;
/// Lowest of them; the highest may be as low as leaves so many that a pole can stay.
const LOWEST: usize = 2;
pub(in crate::identify) const LEAST_HIGHEST: usize = LOWEST + FEWEST_ORDERS - 1;
/// A mode within so many decay rates of a listed pole was made of it.
const OWN: f64 = 0.5;
/// Looks with weighted lines.
const ROUNDS: usize = 2;

/// A method that finds the poles that all functions share, at rising orders.
pub(in crate::identify) trait MultiModeMethod: Send + Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Whether its poles come with the participation factors of several inputs.
    fn gives_participation(&self) -> bool;

    /// Whether known poles change the weight of its lines.
    fn weights_lines(&self) -> bool;

    /// Poles over rising orders, by parts of the band; lines may be weighted with poles that are
    /// known, rad/s.
    ///
    /// # Errors
    /// [`IdentifyError::Linalg`] when a matrix problem has no answer.
    fn parts(
        &self,
        on: (&Receptances, &Sides),
        with: (&Found, &[Complex64]),
    ) -> Result<Vec<Part>, IdentifyError>;
}

/// Poles over the orders of an estimate that answers for a part of the band.
pub(in crate::identify) struct Part {
    /// Lowest damped frequency it answers for, rad/s.
    pub from_rad_s: f64,
    /// Highest.
    pub to_rad_s: f64,
    /// Poles by order, ascending.
    pub tables: Vec<Table>,
}

/// Poles that stay, and all there were.
pub(in crate::identify) struct Stabilised {
    /// Poles that stay.
    pub seeds: Vec<Seed>,
    /// All poles in the band, by part, order and frequency.
    pub poles: Vec<PoleAtOrder>,
}

/// Orders up to a highest, so many that a pole that stays is seen at several.
pub(in crate::identify) fn rising_orders(highest: usize) -> Vec<usize> {
    let lowest = (highest / 6).max(LOWEST);
    let stride = highest.saturating_sub(lowest).div_ceil(ORDERS).max(1);
    (lowest..=highest).step_by(stride).collect()
}

/// The poles of a method that stay within limits, rad/s, where others may be known.
///
/// # Errors
/// As [`MultiModeMethod::parts`].
pub(in crate::identify) fn stabilised(
    method: &dyn MultiModeMethod,
    on: (&Receptances, &Sides),
    (found, limits, known): (&Found, (f64, f64), &[Complex64]),
) -> Result<Stabilised, IdentifyError> {
    let data = on.0;
    let (mut seeds, mut poles) = (Vec::new(), Vec::new());
    for part in method.parts(on, (found, known))? {
        let tables: Vec<Table> = part
            .tables
            .into_iter()
            .map(|(order, poles)| (order, inside(data, poles, limits)))
            .collect();
        let answers =
            |pole: &GlobalPole| pole.lambda.im > part.from_rad_s && pole.lambda.im < part.to_rad_s;
        let own = pole_tracks::seeds(&tables, data.step);
        for (order, table) in &tables {
            let listed = table.iter().filter(|pole| answers(pole));
            poles.extend(listed.map(|pole| PoleAtOrder {
                order: *order,
                pole: Pole {
                    lambda: pole.lambda,
                },
                status: if own.iter().any(|seed| seed.holds(*order, pole)) {
                    PoleStatus::Stable
                } else {
                    PoleStatus::Alone
                },
            }));
        }
        seeds.extend(own.into_iter().filter(|seed| answers(&seed.pole)));
    }
    let seeds = distinct(seeds);
    Ok(Stabilised { seeds, poles })
}

/// The poles of a method that stay, looked for once more with lines weighted by what the first look
/// found ([`ROUNDS`] times): each pole moves to the one that takes its place.
///
/// # Errors
/// As [`MultiModeMethod::parts`].
pub(in crate::identify) fn sharpened(
    method: &dyn MultiModeMethod,
    on: (&Receptances, &Sides),
    (found, limits): (&Found, (f64, f64)),
) -> Result<Stabilised, IdentifyError> {
    let mut own = stabilised(method, on, (found, limits, &[]))?;
    let rounds = if method.weights_lines() { ROUNDS } else { 0 };
    for _ in 0..rounds {
        let known: Vec<Complex64> = own.seeds.iter().map(|seed| seed.pole.lambda).collect();
        let again = stabilised(method, on, (found, limits, &known))?;
        own.seeds = own
            .seeds
            .into_iter()
            .map(|seed| pole_tracks::replaced(seed, &again.seeds))
            .collect();
        own.seeds = distinct(own.seeds);
        own.poles = again.poles;
    }
    // Those that the last look has no place for stay where they were.
    for seed in &own.seeds {
        let point = PoleAtOrder {
            order: seed.order,
            pole: Pole {
                lambda: seed.pole.lambda,
            },
            status: PoleStatus::Stable,
        };
        let same = |other: &PoleAtOrder| other.order == point.order && other.pole == point.pole;
        if !own.poles.iter().any(same) {
            own.poles.push(point);
        }
    }
    Ok(own)
}

/// A root of one mode at each pole that stays.
pub(in crate::identify) fn roots_of(seeds: &[Seed], functions: usize) -> Vec<Root> {
    let root = |seed: &Seed| Root::single(seed.pole.lambda, &seed.pole.participation, functions);
    seeds.iter().map(root).collect()
}

/// Place of the listed pole that a mode was made of: the nearest within [`OWN`] decay rates, of the
/// mode's order where that is known.
fn source(mode: &Candidate, listing: &[PoleAtOrder]) -> Option<usize> {
    let lambda = mode.pole.lambda;
    let distance = |place: &usize| (listing[*place].pole.lambda - lambda).norm();
    let of_order = |place: &usize| {
        mode.order
            .is_none_or(|order| order == listing[*place].order)
    };
    let near = |place: &usize| distance(place) < OWN * lambda.re.abs();
    let own = (0..listing.len()).filter(|place| of_order(place) && near(place));
    own.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Gives modes that have no order that of the listed pole they were made of.
pub(in crate::identify) fn state_orders(table: &mut PoleTable) {
    for mode in &mut table.candidates {
        let source = source(mode, &table.stabilization);
        mode.order = mode
            .order
            .or(source.map(|place| table.stabilization[place].order));
    }
}

/// Marks the listed poles that modes were made of as chosen.
pub(in crate::identify) fn mark_chosen(table: &mut PoleTable) {
    for mode in &table.candidates {
        if let Some(place) = source(mode, &table.stabilization) {
            table.stabilization[place].status = PoleStatus::Chosen;
        }
    }
}

fn inside(data: &Receptances, poles: Vec<GlobalPole>, (lo, hi): (f64, f64)) -> Vec<GlobalPole> {
    let widest = WIDEST * data.range();
    let keeps = |pole: &GlobalPole| {
        let inside = pole.lambda.im > lo && pole.lambda.im < hi;
        inside && -2.0 * pole.lambda.re < widest && resonates(pole.lambda)
    };
    poles.into_iter().filter(keeps).collect()
}

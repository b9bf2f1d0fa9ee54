//! Pole tracks join poles of rising model orders; a track of enough orders gives a stable pole.
//!
//! A pole belongs to a track when it lies near the last pole of the track, one or two orders
//! before: within half a decay rate (a quarter of the half-power width) and with the same
//! participation factors. A track of three or more orders gives a stable pole: the pole of the
//! track with the smallest sum of distances to the others.

use num_complex::Complex64;

use crate::linalg::sort_ascending_by;
use crate::modal::mac;

/// Maximum distance from order to order, in decay rates.
const MAX_STEP_DECAY_RATES: f64 = 0.5;
/// Minimum modal assurance criterion of participation factors from order to order.
const MIN_PARTICIPATION_MAC: f64 = 0.8;
/// Maximum number of successive orders without a pole of the track.
const MAX_MISSING_ORDERS: usize = 1;
/// Minimum number of orders of a track.
pub(in crate::identify) const MIN_TRACK_ORDERS: usize = 3;
/// Number of last poles of a track among which the stable pole is chosen.
const LAST_TRACK_POLES: usize = 7;

/// A pole that all functions share, with its participation factors.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct GlobalPole {
    /// λ, rad/s.
    pub lambda: Complex64,
    /// One value per input, of norm 1.
    pub participation: Vec<Complex64>,
}

/// A stable pole.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct StablePole {
    /// Pole and participation factors.
    pub pole: GlobalPole,
    /// Order of that pole.
    pub order: usize,
    /// Orders of its track.
    pub orders: Vec<usize>,
    /// The poles of its track, by order.
    members: Vec<(usize, Complex64)>,
}

impl StablePole {
    /// Whether a pole of an order belongs to its track.
    pub fn contains(&self, order: usize, pole: &GlobalPole) -> bool {
        self.members.contains(&(order, pole.lambda))
    }
}

/// Poles of one order.
pub(in crate::identify) type OrderPoles = (usize, Vec<GlobalPole>);

struct Track {
    poles: Vec<GlobalPole>,
    orders: Vec<usize>,
    last: usize,
}

/// Stable poles over the orders (ascending), in ascending frequency. `step_rad_s` is the spacing of
/// the lines; a tenth of it is added to the tolerance.
pub(in crate::identify) fn stable_poles(tables: &[OrderPoles], step_rad_s: f64) -> Vec<StablePole> {
    let mut tracks: Vec<Track> = Vec::new();
    for (index, (order, poles)) in tables.iter().enumerate() {
        let mut free: Vec<usize> = (0..tracks.len())
            .filter(|t| index - tracks[*t].last <= 1 + MAX_MISSING_ORDERS)
            .collect();
        let mut started = Vec::new();
        for pole in poles {
            let best = nearest(&tracks, &free, pole, step_rad_s);
            match best {
                Some(position) => {
                    let track = &mut tracks[free.swap_remove(position)];
                    track.poles.push(pole.clone());
                    track.orders.push(*order);
                    track.last = index;
                }
                None => started.push(Track {
                    poles: vec![pole.clone()],
                    orders: vec![*order],
                    last: index,
                }),
            }
        }
        tracks.extend(started);
    }
    let stable = tracks
        .into_iter()
        .filter(|track| track.orders.len() >= MIN_TRACK_ORDERS);
    let mut stable_poles: Vec<StablePole> = stable
        .map(|track| {
            let median = medoid(&track.poles);
            StablePole {
                pole: track.poles[median].clone(),
                order: track.orders[median],
                members: members(&track),
                orders: track.orders,
            }
        })
        .collect();
    sort_ascending_by(&mut stable_poles, |stable| stable.pole.lambda.im);
    stable_poles
}

fn members(track: &Track) -> Vec<(usize, Complex64)> {
    let poles = track.poles.iter().map(|pole| pole.lambda);
    track.orders.iter().copied().zip(poles).collect()
}

/// Position in `free` of the track that a pole continues.
fn nearest(tracks: &[Track], free: &[usize], pole: &GlobalPole, step: f64) -> Option<usize> {
    let distance = |position: &usize| {
        let last = tracks[free[*position]].poles.last()?;
        let decay = pole.lambda.re.abs().max(last.lambda.re.abs());
        let distance_rad_s = (pole.lambda - last.lambda).norm();
        let participation_mac = mac(&pole.participation, &last.participation)?;
        (distance_rad_s <= MAX_STEP_DECAY_RATES * decay + 0.1 * step
            && participation_mac >= MIN_PARTICIPATION_MAC)
            .then_some(distance_rad_s)
    };
    let near = (0..free.len()).filter_map(|position| Some((position, distance(&position)?)));
    near.min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(position, _)| position)
}

/// Position of the pole with the smallest sum of distances to the others among the last ones.
fn medoid(poles: &[GlobalPole]) -> usize {
    let first = poles.len().saturating_sub(LAST_TRACK_POLES);
    let last = &poles[first..];
    let sum = |position: &usize| -> f64 {
        let lambda = poles[*position].lambda;
        last.iter().map(|p| (p.lambda - lambda).norm()).sum()
    };
    let best = (first..poles.len()).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    best.unwrap_or(first)
}

/// The nearest of other stable poles within half a decay rate and with the same participation, else
/// the pole itself.
pub(in crate::identify) fn matching_pole(seed: StablePole, others: &[StablePole]) -> StablePole {
    let distance = |other: &&StablePole| {
        let distance_rad_s = (other.pole.lambda - seed.pole.lambda).norm();
        let participation_mac = mac(&other.pole.participation, &seed.pole.participation)?;
        let near = distance_rad_s < MAX_STEP_DECAY_RATES * seed.pole.lambda.re.abs()
            && participation_mac >= MIN_PARTICIPATION_MAC;
        near.then_some(distance_rad_s)
    };
    let near = others
        .iter()
        .filter_map(|other| Some((distance(&other)?, other)));
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(seed.clone(), |(_, other)| other.clone())
}

/// Stable poles without duplicates: nearer than a fifth of a decay rate with the same
/// participation.
pub(in crate::identify) fn without_duplicates(stable_poles: Vec<StablePole>) -> Vec<StablePole> {
    let mut order: Vec<StablePole> = stable_poles;
    order.sort_by_key(|seed| std::cmp::Reverse(seed.orders.len()));
    let mut kept: Vec<StablePole> = Vec::new();
    for seed in order {
        let repeats = |other: &StablePole| {
            let (a, b) = (&seed.pole, &other.pole);
            let decay = a.lambda.re.abs().max(b.lambda.re.abs());
            (a.lambda - b.lambda).norm() < 0.2 * decay
                && mac(&a.participation, &b.participation) > Some(0.9)
        };
        if !kept.iter().any(repeats) {
            kept.push(seed);
        }
    }
    kept
}

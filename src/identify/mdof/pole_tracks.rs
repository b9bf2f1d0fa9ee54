//! Poles that stay while the model order grows: the seeds of the refinement.
//!
//! A pole belongs to a track when it lies near the last pole of the track, one or two orders
//! before: within half a decay rate (a quarter of the half-power width) and with the same
//! participation factors. Tracks of three and more orders are seeds; a seed is the pole of its
//! track with the least sum of distances to the others.

use num_complex::Complex64;

use crate::modal::mac;

/// Distance from order to order, in decay rates.
const NEAR: f64 = 0.5;
/// Least modal assurance criterion of participation factors from order to order.
const SAME_PARTICIPATION: f64 = 0.8;
/// Orders that a pole may be missing from.
const MISSING: usize = 1;
/// Fewest orders of a track.
pub(in crate::identify) const FEWEST_ORDERS: usize = 3;
/// The last poles of a track that choose the seed.
const CHOOSING: usize = 7;

/// A pole that all functions share, with its participation factors.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct GlobalPole {
    /// λ, rad/s.
    pub lambda: Complex64,
    /// One value per input, of norm 1.
    pub participation: Vec<Complex64>,
}

/// A pole that stays.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::identify) struct Seed {
    /// Pole and participation factors.
    pub pole: GlobalPole,
    /// Order of that pole.
    pub order: usize,
    /// Orders at which it was there.
    pub orders: Vec<usize>,
    /// The poles of its track, by order.
    members: Vec<(usize, Complex64)>,
}

impl Seed {
    /// Whether a pole of an order belongs to it.
    pub fn holds(&self, order: usize, pole: &GlobalPole) -> bool {
        self.members.contains(&(order, pole.lambda))
    }
}

/// Poles of one order.
pub(in crate::identify) type Table = (usize, Vec<GlobalPole>);

struct Track {
    poles: Vec<GlobalPole>,
    orders: Vec<usize>,
    last: usize,
}

/// Poles that stay over the orders (ascending), in ascending frequency. `step_rad_s` is the spacing
/// of the lines, below a tenth of which nothing differs.
pub(in crate::identify) fn seeds(tables: &[Table], step_rad_s: f64) -> Vec<Seed> {
    let mut tracks: Vec<Track> = Vec::new();
    for (index, (order, poles)) in tables.iter().enumerate() {
        let mut free: Vec<usize> = (0..tracks.len())
            .filter(|t| index - tracks[*t].last <= 1 + MISSING)
            .collect();
        let mut new = Vec::new();
        for pole in poles {
            let best = nearest(&tracks, &free, pole, step_rad_s);
            match best {
                Some(place) => {
                    let track = &mut tracks[free.swap_remove(place)];
                    track.poles.push(pole.clone());
                    track.orders.push(*order);
                    track.last = index;
                }
                None => new.push(Track {
                    poles: vec![pole.clone()],
                    orders: vec![*order],
                    last: index,
                }),
            }
        }
        tracks.extend(new);
    }
    let stay = tracks
        .into_iter()
        .filter(|track| track.orders.len() >= FEWEST_ORDERS);
    let mut seeds: Vec<Seed> = stay
        .map(|track| {
            let place = medoid(&track.poles);
            Seed {
                pole: track.poles[place].clone(),
                order: track.orders[place],
                members: members(&track),
                orders: track.orders,
            }
        })
        .collect();
    seeds.sort_by(|a, b| a.pole.lambda.im.total_cmp(&b.pole.lambda.im));
    seeds
}

fn members(track: &Track) -> Vec<(usize, Complex64)> {
    let poles = track.poles.iter().map(|pole| pole.lambda);
    track.orders.iter().copied().zip(poles).collect()
}

/// Place in `free` of the track that a pole continues.
fn nearest(tracks: &[Track], free: &[usize], pole: &GlobalPole, step: f64) -> Option<usize> {
    let distance = |place: &usize| {
        let last = tracks[free[*place]].poles.last()?;
        let decay = pole.lambda.re.abs().max(last.lambda.re.abs());
        let apart = (pole.lambda - last.lambda).norm();
        let alike = mac(&pole.participation, &last.participation)?;
        (apart <= NEAR * decay + 0.1 * step && alike >= SAME_PARTICIPATION).then_some(apart)
    };
    let near = (0..free.len()).filter_map(|place| Some((place, distance(&place)?)));
    near.min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(place, _)| place)
}

/// Place of the pole with the least sum of distances to the others among the last.
fn medoid(poles: &[GlobalPole]) -> usize {
    let first = poles.len().saturating_sub(CHOOSING);
    let last = &poles[first..];
    let sum = |place: &usize| -> f64 {
        let own = poles[*place].lambda;
        last.iter().map(|p| (p.lambda - own).norm()).sum()
    };
    let best = (first..poles.len()).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    best.unwrap_or(first)
}

/// The seed among others that takes the place of one: within half a decay rate, with the same
/// participation; itself without one.
pub(in crate::identify) fn replaced(seed: Seed, others: &[Seed]) -> Seed {
    let distance = |other: &&Seed| {
        let apart = (other.pole.lambda - seed.pole.lambda).norm();
        let alike = mac(&other.pole.participation, &seed.pole.participation)?;
        let near = apart < NEAR * seed.pole.lambda.re.abs() && alike >= SAME_PARTICIPATION;
        near.then_some(apart)
    };
    let near = others
        .iter()
        .filter_map(|other| Some((distance(&other)?, other)));
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(seed.clone(), |(_, other)| other.clone())
}

/// Seeds without those that repeat another: nearer than a fifth of a decay rate with the same
/// participation.
pub(in crate::identify) fn distinct(seeds: Vec<Seed>) -> Vec<Seed> {
    let mut order: Vec<Seed> = seeds;
    order.sort_by_key(|seed| std::cmp::Reverse(seed.orders.len()));
    let mut kept: Vec<Seed> = Vec::new();
    for seed in order {
        let repeats = |other: &Seed| {
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

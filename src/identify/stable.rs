//! Poles that stay while the model order grows: the seeds of the refinement.
//!
//! A pole belongs to a track when it lies near the last pole of the track, one or two orders before: within half a decay rate
//! (a quarter of the half-power width) and with the same participation factors. Tracks of three and more orders are seeds; a seed is
//! the pole of its track with the least sum of distances to the others.

use num_complex::Complex64;

use crate::modal::mac;

use super::plscf::LscfPole;

/// Distance from order to order, in decay rates.
const NEAR: f64 = 0.5;
/// Least modal assurance criterion of participation factors from order to order.
const SAME_PARTICIPATION: f64 = 0.8;
/// Orders that a pole may be missing from.
const MISSING: usize = 1;
/// Fewest orders of a track.
pub(super) const FEWEST_ORDERS: usize = 3;
/// The last poles of a track that choose the seed.
const CHOOSING: usize = 7;

/// A pole that stays.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seed {
    /// Pole and participation factors.
    pub pole: LscfPole,
    /// Orders at which it was there.
    pub orders: Vec<usize>,
}

struct Track {
    poles: Vec<LscfPole>,
    orders: Vec<usize>,
    last: usize,
}

/// Poles that stay over the orders (ascending), in ascending frequency. `step_rad_s` is the spacing of the lines, below a tenth of
/// which nothing differs.
pub(super) fn seeds(tables: &[(usize, Vec<LscfPole>)], step_rad_s: f64) -> Vec<Seed> {
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
        .map(|track| Seed {
            pole: medoid(&track.poles),
            orders: track.orders,
        })
        .collect();
    seeds.sort_by(|a, b| a.pole.lambda.im.total_cmp(&b.pole.lambda.im));
    seeds
}

/// Place in `free` of the track that a pole continues.
fn nearest(tracks: &[Track], free: &[usize], pole: &LscfPole, step: f64) -> Option<usize> {
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

fn medoid(poles: &[LscfPole]) -> LscfPole {
    let last = &poles[poles.len().saturating_sub(CHOOSING)..];
    let sum = |lambda: Complex64| -> f64 { last.iter().map(|p| (p.lambda - lambda).norm()).sum() };
    let best = last
        .iter()
        .min_by(|a, b| sum(a.lambda).total_cmp(&sum(b.lambda)));
    best.unwrap_or(&poles[0]).clone()
}

/// Seeds without those that repeat another: nearer than a fifth of a decay rate with the same participation.
pub(super) fn distinct(seeds: Vec<Seed>) -> Vec<Seed> {
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

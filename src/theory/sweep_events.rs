//! Crossings and veerings of tracked loci, and the coupling of the modes there.

use std::f64::consts::TAU;

use crate::linalg::RealMatrix;

use super::TheoryError;
use super::sweep_track::{ModeTrack, ModeTracker, Sample, pairs, zero_between};

/// The least veering index: more than half of how a shape changes comes from the other one of the
/// pair.
const VEERING_INDEX: f64 = 0.5;
/// On both sides a pair must part to this multiple of its least distance in lambda: half of the
/// exchange of shapes lies within.
const PARTED: f64 = std::f64::consts::SQRT_2;

/// Interaction of two loci.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// They meet without interaction and keep their shapes.
    Crossing,
    /// They come near, do not meet, and exchange their shapes.
    Veering,
}

impl EventKind {
    /// Printed name.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::Crossing => "crossing",
            EventKind::Veering => "veering",
        }
    }
}

/// A crossing or a veering.
#[derive(Clone, Debug, PartialEq)]
pub struct LocusEvent {
    /// Crossing or veering.
    pub kind: EventKind,
    /// Indices of the two loci, the one that is lower before the event first.
    pub loci: [usize; 2],
    /// Value of the parameter where they meet, or where their frequencies are nearest.
    pub place: f64,
    /// Their frequencies there, Hz.
    pub frequency_hz: [f64; 2],
    /// Distance of their frequencies there, Hz; 0 at a crossing.
    pub gap_hz: f64,
    /// Coupling factor there, 0 (none) to 1: `c^2/(c^2 + (s_a - s_b)^2/4)` with the slopes `s =
    /// dlambda/dp` and the coupling `c = phi_a^T (dK/dp - lambda dM/dp) phi_b`, lambda the mean of
    /// both (the cross-sensitivity quotient).
    pub coupling: f64,
    /// The change of the parameter over which a veering takes place, `gap in lambda / 2 c`; `None`
    /// for a crossing.
    pub width: Option<f64>,
}

/// Crossings and veerings of families of modes, in the order of their places.
pub(super) fn events(
    tracker: &ModeTracker<'_>,
    track: &ModeTrack,
    families: &[Vec<usize>],
) -> Result<Vec<LocusEvent>, TheoryError> {
    let couplings = track.samples.iter().map(|sample| tracker.couplings(sample));
    let couplings: Vec<RealMatrix> = couplings.collect::<Result<_, _>>()?;
    let mut found = Vec::new();
    for (a, b) in pairs(families.len()) {
        found.extend(crossings(tracker, track, families, [a, b])?);
        found.extend(veerings(tracker, track, &couplings, families, [a, b])?);
    }
    found.sort_by(|x, y| x.place.total_cmp(&y.place).then(x.loci.cmp(&y.loci)));
    Ok(found)
}

fn crossings(
    tracker: &ModeTracker<'_>,
    track: &ModeTrack,
    families: &[Vec<usize>],
    [a, b]: [usize; 2],
) -> Result<Vec<LocusEvent>, TheoryError> {
    let firsts = [families[a][0], families[b][0]];
    let mut found = Vec::new();
    for meeting in &track.meetings {
        let loci = match meeting.modes {
            modes if modes == firsts => [a, b],
            [y, x] if [x, y] == firsts => [b, a],
            _ => continue,
        };
        // Near the crossing, where the two shapes are still distinct.
        let from = before(track, meeting.between[0]);
        let Some(sample) = tracker.track_to(from, meeting.place)? else {
            continue;
        };
        let pair = Pair::new(tracker, from, families, loci)?;
        let hz = 0.5
            * loci
                .map(|locus| sample.omega_rad_s[families[locus][0]])
                .iter()
                .sum::<f64>()
            / TAU;
        found.push(LocusEvent {
            kind: EventKind::Crossing,
            loci,
            place: meeting.place,
            frequency_hz: [hz, hz],
            gap_hz: 0.0,
            coupling: pair.quotient(),
            width: None,
        });
    }
    Ok(found)
}

/// The last sample at or before a value.
fn before(track: &ModeTrack, value: f64) -> &Sample {
    let after = track
        .samples
        .partition_point(|sample| sample.value <= value);
    &track.samples[after.saturating_sub(1)]
}

fn veerings(
    tracker: &ModeTracker<'_>,
    track: &ModeTrack,
    couplings: &[RealMatrix],
    families: &[Vec<usize>],
    [a, b]: [usize; 2],
) -> Result<Vec<LocusEvent>, TheoryError> {
    let firsts = [families[a][0], families[b][0]];
    let mut found = Vec::new();
    let pairs = track.samples.iter().zip(couplings);
    let rates: Vec<Option<f64>> = pairs
        .map(|(sample, couplings)| approach(sample, couplings, firsts))
        .collect();
    for (i, ends) in track.samples.windows(2).enumerate() {
        let (Some(from), Some(to)) = (rates[i], rates[i + 1]) else {
            continue;
        };
        let met = track.meetings.iter().any(|meeting| {
            let both = meeting.modes.iter().all(|mode| firsts.contains(mode));
            both && meeting.between[0] < ends[1].value && meeting.between[1] > ends[0].value
        });
        if met || from >= 0.0 || to <= 0.0 || !parted(track, i, firsts) {
            continue;
        }
        let brackets = [(ends[0].value, from), (ends[1].value, to)];
        let place = zero_between(brackets, |value| {
            let Some(sample) = tracker.track_to(&ends[0], value)? else {
                return Ok(None);
            };
            let couplings = tracker.couplings(&sample)?;
            Ok::<_, TheoryError>(approach(&sample, &couplings, firsts))
        })?;
        let (Ok(place) | Err(place)) = place;
        let Some(sample) = tracker.track_to(&ends[0], place)? else {
            continue;
        };
        let low_first = sample.distance(firsts[0], firsts[1]) > 0.0;
        let loci = if low_first { [a, b] } else { [b, a] };
        let pair = Pair::new(tracker, &sample, families, loci)?;
        if pair.index() >= VEERING_INDEX {
            found.push(pair.veering(loci, place));
        }
    }
    Ok(found)
}

/// Rate of the distance of two frequencies over the parameter, below 0 where they come nearer;
/// `None` for modes of one root and for roots at 0, which stay there.
fn approach(sample: &Sample, couplings: &RealMatrix, [a, b]: [usize; 2]) -> Option<f64> {
    let [x, y] = [a, b].map(|mode| sample.omega_rad_s[mode]);
    let distinct = sample.root[a] != sample.root[b];
    let rate = couplings[(b, b)] / (2.0 * y) - couplings[(a, a)] / (2.0 * x);
    (distinct && x > 0.0 && y > 0.0).then(|| rate * sample.distance(a, b).signum())
}

/// Whether two modes, coming from the least distance between samples `i` and `i + 1`, part on both
/// sides.
fn parted(track: &ModeTrack, i: usize, [a, b]: [usize; 2]) -> bool {
    let gap =
        |sample: &Sample| (sample.omega_rad_s[b].powi(2) - sample.omega_rad_s[a].powi(2)).abs();
    let least = gap(&track.samples[i]).min(gap(&track.samples[i + 1]));
    let reaches = |side: &mut dyn Iterator<Item = &Sample>| {
        let mut last = least;
        for distance in side.map(gap) {
            if distance >= PARTED * least {
                return true;
            }
            if distance < last {
                return false;
            }
            last = distance;
        }
        false
    };
    reaches(&mut track.samples[..=i].iter().rev()) && reaches(&mut track.samples[i + 1..].iter())
}

/// Two families of modes at one value.
struct Pair {
    omega_rad_s: [f64; 2],
    slopes: [f64; 2],
    /// Squared coupling of a mode of the first with all of the second.
    coupling2: f64,
    /// Fraction of the change of a shape of one that comes from the other.
    dependence: [f64; 2],
}

impl Pair {
    fn new(
        tracker: &ModeTracker<'_>,
        sample: &Sample,
        families: &[Vec<usize>],
        loci: [usize; 2],
    ) -> Result<Self, TheoryError> {
        let couplings = tracker.couplings(sample)?;
        let firsts = loci.map(|locus| families[locus][0]);
        let lambda = |mode: usize| sample.omega_rad_s[mode].powi(2);
        let dependence = |from: usize, other: usize| {
            let mode = families[from][0];
            let part = |k: usize| (couplings[(mode, k)] / (lambda(k) - lambda(mode))).powi(2);
            let strangers = (0..sample.root.len()).filter(|&k| sample.root[k] != sample.root[mode]);
            let all: f64 = strangers.map(part).sum();
            let theirs: f64 = families[other].iter().map(|&k| part(k)).sum();
            if all > 0.0 { theirs / all } else { 0.0 }
        };
        let squares = families[loci[1]]
            .iter()
            .map(|&k| couplings[(firsts[0], k)].powi(2));
        Ok(Self {
            omega_rad_s: firsts.map(|mode| sample.omega_rad_s[mode]),
            slopes: firsts.map(|mode| couplings[(mode, mode)]),
            coupling2: squares.sum(),
            dependence: [dependence(loci[0], loci[1]), dependence(loci[1], loci[0])],
        })
    }

    /// The cross-sensitivity quotient (du Bois, Adhikari and Lieven 2011).
    fn quotient(&self) -> f64 {
        let difference = 0.5 * (self.slopes[0] - self.slopes[1]);
        let both = self.coupling2 + difference * difference;
        if both > 0.0 {
            self.coupling2 / both
        } else {
            0.0
        }
    }

    /// The veering index: the quotient times the modal dependence factor of both (the same, their
    /// geometric mean).
    fn index(&self) -> f64 {
        self.quotient() * (self.dependence[0] * self.dependence[1]).sqrt()
    }

    fn veering(&self, loci: [usize; 2], place: f64) -> LocusEvent {
        let [low, high] = self.omega_rad_s;
        let gap = high * high - low * low;
        LocusEvent {
            kind: EventKind::Veering,
            loci,
            place,
            frequency_hz: [low / TAU, high / TAU],
            gap_hz: (high - low) / TAU,
            coupling: self.quotient(),
            width: Some(gap / (2.0 * self.coupling2.sqrt())),
        }
    }
}

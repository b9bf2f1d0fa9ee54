//! Time histories: channels that were sampled together, in memory ([`Hit`]) or read when they are
//! asked for ([`Recording`]).

use std::ops::Range;
use std::sync::Arc;

use crate::axis::TimeAxis;
use crate::dof::Dof;
use crate::quantity::Quantity;

/// The role of a channel in a hammer test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The hammer's force.
    Force,
    /// A response.
    Response,
}

/// Samples as they were stored: single precision stays single until it is transformed.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Samples::F32(values) => values.len(),
            Samples::F64(values) => values.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples in double precision, in order.
    pub fn iter(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Samples::F32(values) => Box::new(values.iter().map(|v| f64::from(*v))),
            Samples::F64(values) => Box::new(values.iter().copied()),
        }
    }

    /// Takes these samples of others, in their precision; `None` when they are not there.
    fn replace(&mut self, from: &Samples, range: Range<usize>) -> Option<()> {
        match (&mut *self, from) {
            (Samples::F32(to), Samples::F32(from)) => copied(to, from.get(range)?),
            (Samples::F64(to), Samples::F64(from)) => copied(to, from.get(range)?),
            (_, Samples::F32(from)) => *self = Samples::F32(from.get(range)?.to_vec()),
            (_, Samples::F64(from)) => *self = Samples::F64(from.get(range)?.to_vec()),
        }
        Some(())
    }

    /// The samples as a new vector of doubles.
    pub fn to_f64(&self) -> Vec<f64> {
        self.iter().collect()
    }
}

fn copied<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.extend_from_slice(from);
}

/// One channel of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its role in the test.
    pub role: Role,
    /// Where it measures: for a force, the hit point.
    pub dof: Dof,
    /// The measured quantity.
    pub quantity: Quantity,
    /// SI value = `to_si` × sample.
    pub to_si: f64,
    /// Samples as stored.
    pub samples: Samples,
}

impl Channel {
    /// The samples in SI units.
    pub fn si(&self) -> Vec<f64> {
        self.samples.iter().map(|v| v * self.to_si).collect()
    }
}

/// One hit: a force and the responses that were sampled with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// Common time axis.
    pub axis: TimeAxis,
    /// The force; its `dof` is the hit point.
    pub force: Channel,
    /// Responses, in file order.
    pub responses: Vec<Channel>,
    /// Where it came from (file and record), for messages.
    pub origin: String,
}

/// One channel of a hit without its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelInfo {
    /// Where it measures: for a force, the hit point.
    pub dof: Dof,
    /// The measured quantity.
    pub quantity: Quantity,
    /// SI value = `to_si` × sample.
    pub to_si: f64,
    /// Largest magnitude that the converter can hold, SI unit; `None` when it is not stated.
    pub full_scale: Option<f64>,
    /// Time from the first sample of the force to that of this channel, s.
    pub delay_s: f64,
}

/// One hit without its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct HitInfo {
    /// Common time axis.
    pub axis: TimeAxis,
    /// The force; its `dof` is the hit point.
    pub force: ChannelInfo,
    /// Responses, in file order.
    pub responses: Vec<ChannelInfo>,
    /// Where it came from (file and record), for messages.
    pub origin: String,
}

/// Which samples of a recording are asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSegment {
    /// Number of the hit, from 0.
    pub hit: usize,
    /// The force, or the number of a response, from 0.
    pub channel: ChannelPlace,
    /// Samples of the hit's axis.
    pub samples: Range<usize>,
}

/// The force or a response of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelPlace {
    /// The force.
    Force,
    /// The response of this number, from 0.
    Response(usize),
}

impl HitInfo {
    /// The channel at this place.
    ///
    /// # Panics
    /// For a response that the hit does not have.
    pub fn channel(&self, place: ChannelPlace) -> &ChannelInfo {
        match place {
            ChannelPlace::Force => &self.force,
            ChannelPlace::Response(number) => &self.responses[number],
        }
    }
}

/// The error of the reader that could not read samples.
#[derive(Clone, Debug, thiserror::Error)]
#[error(transparent)]
pub struct ReadError(Arc<dyn std::error::Error + Send + Sync>);

impl ReadError {
    /// Of the reader's error.
    pub fn new(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self(Arc::new(error))
    }
}

/// Two are equal when they say the same.
impl PartialEq for ReadError {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_string() == other.0.to_string()
    }
}

/// Hits whose samples are read when they are asked for, so that a test need not fit in memory.
pub trait Recording: Send {
    /// The hits, in order.
    fn hits(&self) -> &[HitInfo];

    /// Reads samples as they are stored, in place of what `samples` held.
    ///
    /// # Errors
    /// [`ReadError`] when they cannot be read.
    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError>;
}

/// Hits in memory as a recording.
pub struct InMemory<'a> {
    hits: &'a [Hit],
    infos: Vec<HitInfo>,
}

impl<'a> InMemory<'a> {
    /// Of these hits.
    pub fn new(hits: &'a [Hit]) -> Self {
        let infos = hits.iter().map(Hit::info).collect();
        Self { hits, infos }
    }
}

impl Hit {
    /// The hit without its samples.
    pub fn info(&self) -> HitInfo {
        let info = |channel: &Channel| ChannelInfo {
            dof: channel.dof.clone(),
            quantity: channel.quantity,
            to_si: channel.to_si,
            full_scale: None,
            delay_s: 0.0,
        };
        HitInfo {
            axis: self.axis,
            force: info(&self.force),
            responses: self.responses.iter().map(info).collect(),
            origin: self.origin.clone(),
        }
    }

    fn channel(&self, place: ChannelPlace) -> &Channel {
        match place {
            ChannelPlace::Force => &self.force,
            ChannelPlace::Response(number) => &self.responses[number],
        }
    }
}

/// Samples that are asked for and not there.
#[derive(Debug, thiserror::Error)]
#[error("{origin} {dof}: samples {asked:?} of {there}")]
struct OutOfRecord {
    origin: String,
    dof: Dof,
    asked: Range<usize>,
    there: usize,
}

impl Recording for InMemory<'_> {
    fn hits(&self) -> &[HitInfo] {
        &self.infos
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let hit = &self.hits[segment.hit];
        let channel = hit.channel(segment.channel);
        samples
            .replace(&channel.samples, segment.samples.clone())
            .ok_or_else(|| {
                ReadError::new(OutOfRecord {
                    origin: hit.origin.clone(),
                    dof: channel.dof.clone(),
                    asked: segment.samples.clone(),
                    there: channel.samples.len(),
                })
            })
    }
}

/// Hits cut from longer records.
pub struct Cut {
    whole: Box<dyn Recording>,
    hits: Vec<HitInfo>,
    /// Record of each hit, and its first sample there.
    places: Vec<(usize, usize)>,
}

impl Cut {
    /// Each piece is the number of a record, from 0, and the samples of it that are a hit.
    ///
    /// # Panics
    /// For a record that is not there.
    pub fn new(whole: Box<dyn Recording>, pieces: &[(usize, Range<usize>)]) -> Self {
        let hit = |(record, samples): &(usize, Range<usize>)| {
            let info = &whole.hits()[*record];
            let at_s = samples.start as f64 * info.axis.step_s;
            HitInfo {
                axis: TimeAxis {
                    len: samples.len(),
                    ..info.axis
                },
                origin: format!("{} at {at_s:.3} s", info.origin),
                ..info.clone()
            }
        };
        Self {
            hits: pieces.iter().map(hit).collect(),
            places: pieces
                .iter()
                .map(|piece| (piece.0, piece.1.start))
                .collect(),
            whole,
        }
    }
}

impl Recording for Cut {
    fn hits(&self) -> &[HitInfo] {
        &self.hits
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let (record, first) = self.places[segment.hit];
        let of_record = ChannelSegment {
            hit: record,
            channel: segment.channel,
            samples: first + segment.samples.start..first + segment.samples.end,
        };
        self.whole.read(&of_record, samples)
    }
}

/// Reads every hit whole.
///
/// # Errors
/// [`ReadError`] of the first channel that cannot be read.
pub fn collect(recording: &mut dyn Recording) -> Result<Vec<Hit>, ReadError> {
    let infos = recording.hits().to_vec();
    let mut hits = Vec::with_capacity(infos.len());
    for (number, info) in infos.into_iter().enumerate() {
        let mut read = |place: ChannelPlace, role: Role| {
            let channel_info = info.channel(place);
            let mut samples = Samples::F64(Vec::new());
            let segment = ChannelSegment {
                hit: number,
                channel: place,
                samples: 0..info.axis.len,
            };
            recording.read(&segment, &mut samples)?;
            Ok(Channel {
                role,
                dof: channel_info.dof.clone(),
                quantity: channel_info.quantity,
                to_si: channel_info.to_si,
                samples,
            })
        };
        let force = read(ChannelPlace::Force, Role::Force)?;
        let responses = 0..info.responses.len();
        let responses = responses.map(|r| read(ChannelPlace::Response(r), Role::Response));
        let responses = responses.collect::<Result<_, ReadError>>()?;
        hits.push(Hit {
            axis: info.axis,
            force,
            responses,
            origin: info.origin,
        });
    }
    Ok(hits)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Counting(Vec<HitInfo>);

    impl Recording for Counting {
        fn hits(&self) -> &[HitInfo] {
            &self.0
        }

        fn read(
            &mut self,
            segment: &ChannelSegment,
            samples: &mut Samples,
        ) -> Result<(), ReadError> {
            let value = |n: usize| (1000 * segment.hit + n) as f32;
            *samples = Samples::F32(segment.samples.clone().map(value).collect());
            Ok(())
        }
    }

    #[test]
    fn a_segment_has_the_samples_of_its_range() {
        let channel = |quantity| ChannelInfo {
            dof: "1:+Z".parse().unwrap(),
            quantity,
            to_si: 1.0,
            full_scale: None,
            delay_s: 0.0,
        };
        let record = HitInfo {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 0.5,
                len: 20,
            },
            force: channel(Quantity::Force),
            responses: vec![channel(Quantity::Velocity)],
            origin: "long".to_owned(),
        };
        let whole = Box::new(Counting(vec![record.clone(), record]));
        let mut cut = Cut::new(whole, &[(0, 2..5), (1, 7..10)]);
        let hits = collect(&mut cut).unwrap();
        let samples: Vec<_> = hits.iter().map(|hit| hit.force.samples.to_f64()).collect();
        assert_eq!(samples, [[2.0, 3.0, 4.0], [1007.0, 1008.0, 1009.0]]);
        assert_eq!(hits[1].origin, "long at 3.500 s");
        assert_eq!(hits[1].axis.len, 3);
    }

    #[test]
    fn missing_samples_are_an_error_with_hit_and_channel() {
        let hit = Hit {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 0.5,
                len: 4,
            },
            force: Channel {
                role: Role::Force,
                dof: "1:+Z".parse().unwrap(),
                quantity: Quantity::Force,
                to_si: 1.0,
                samples: Samples::F64(vec![1.0; 3]),
            },
            responses: Vec::new(),
            origin: "short".to_owned(),
        };
        let error = collect(&mut InMemory::new(&[hit])).unwrap_err();
        assert_eq!(error.to_string(), "short 1:+Z: samples 0..4 of 3");
    }
}

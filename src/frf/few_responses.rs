//! A recording reduced to few responses of each hit, for estimates from single hits of tests with
//! many sensors.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::record::{ChannelPlace, ChannelSegment, HitInfo, ReadError, Recording, Samples};

use super::hit_report::assessed_responses;

/// A recording with at most four responses of each hit, spread over its channels.
pub(super) struct FewResponses<'a> {
    recording: &'a mut dyn Recording,
    hits: Vec<HitInfo>,
    /// The number of each response in the recording.
    numbers: Vec<Vec<usize>>,
}

impl<'a> FewResponses<'a> {
    pub fn new(recording: &'a mut dyn Recording) -> Self {
        let mut hits = recording.hits().to_vec();
        let numbers = hits.iter_mut().map(|hit| {
            let numbers: Vec<usize> = assessed_responses(hit.responses.len()).collect();
            hit.responses = numbers.iter().map(|n| hit.responses[*n].clone()).collect();
            numbers
        });
        let numbers = numbers.collect();
        FewResponses {
            recording,
            hits,
            numbers,
        }
    }

    /// Response and excitation point of its functions.
    pub fn pairs(&self) -> BTreeSet<(Dof, Dof)> {
        let pairs = self.hits.iter().flat_map(|hit| {
            let responses = hit.responses.iter();
            responses.map(|response| (response.dof.clone(), hit.force.dof.clone()))
        });
        pairs.collect()
    }
}

impl Recording for FewResponses<'_> {
    fn hits(&self) -> &[HitInfo] {
        &self.hits
    }

    fn read(&mut self, segment: &ChannelSegment, samples: &mut Samples) -> Result<(), ReadError> {
        let channel = match segment.channel {
            ChannelPlace::Force => ChannelPlace::Force,
            ChannelPlace::Response(number) => {
                ChannelPlace::Response(self.numbers[segment.hit][number])
            }
        };
        let segment = ChannelSegment {
            channel,
            ..segment.clone()
        };
        self.recording.read(&segment, samples)
    }
}

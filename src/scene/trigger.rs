//! Continuous recordings to hits: the force is read whole and cut by trigger; the responses are
//! read hit by hit.

use std::ops::Range;

use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfError;
use crate::record::{ChannelPlace, ChannelSegment, Cut, HitInfo, Recording, Samples};
use crate::signal::{Segment, Segments, TriggerOptions, segments, to_si};

/// The hits of continuous records, all of one length, with findings on the rejected ones.
///
/// # Errors
/// [`FrfError`] for records that cannot be read, and as [`segments`].
pub(super) fn cut_hits(
    mut whole: Box<dyn Recording>,
    options: &TriggerOptions,
) -> Result<(Cut, Vec<Finding>), FrfError> {
    let infos: Vec<HitInfo> = whole.hits().to_vec();
    let mut found = Vec::with_capacity(infos.len());
    for (record, info) in infos.iter().enumerate() {
        found.push(detect_hits(whole.as_mut(), record, info, options)?);
    }
    // Without a stated length all records get that of the shortest one.
    let all = || found.iter().flat_map(|record| &record.segments);
    let before = all().map(|hit| hit.onset - hit.range.start).min();
    let before = before.unwrap_or(0);
    let after = all().map(|hit| hit.range.end - hit.onset).min();
    let shortest = before + after.unwrap_or(0);
    let mut pieces: Vec<(usize, Range<usize>)> = Vec::new();
    let mut findings = Vec::new();
    for (record, record_hits) in found.iter().enumerate() {
        let pieces_of = record_hits.segments.iter().map(|hit| {
            let start = hit.onset - before;
            (record, start..start + shortest)
        });
        pieces.extend(pieces_of);
        let left_out = record_hits.cut_off + record_hits.too_early;
        let location = Location::File {
            path: infos[record].origin.clone(),
            line: None,
            byte: None,
        };
        let level = Finding::new(Severity::Info, Code::TriggerLevel, location.clone());
        findings.push(level.value(record_hits.level_n, "N"));
        let length_s = shortest as f64 * infos[record].axis.step_s;
        let length = Finding::new(Severity::Info, Code::HitLength, location.clone());
        findings.push(length.value(length_s, "s"));
        if left_out > 0 {
            let finding = Finding::new(Severity::Warning, Code::HitCutOff, location);
            findings.push(finding.value(left_out as f64, "hits"));
        }
    }
    Ok((Cut::new(whole, &pieces), findings))
}

/// Least distance of hits in a continuous record, over the mean distance. Larger: an unsteady hand
/// makes no continuous record. Smaller: a double hit does (`a_double_hit_is_no_continuous_record`).
const MIN_DISTANCE_OVER_MEAN: f64 = 0.25;
/// Least height of two pulses over the higher. Larger: two hits of an unsteady hand are one record.
/// Smaller: a bounce, some third of the hit, makes a record of two hits
/// (`a_double_hit_is_no_continuous_record`).
const MIN_HEIGHT_OF_TWO: f64 = 0.5;
/// Largest part of a record in which the force of a hammer is above a quarter of its peak. Larger:
/// bursts of a shaker are taken for hits, above that level in a third of a burst. Smaller: the
/// pulse of a soft tip, a hundredth of its record, is none
/// (`bursts_and_double_hits_are_no_hits_of_a_continuous_record`).
const MAX_PULSE_PART: f64 = 0.02;

/// Whether every record plainly holds several hits: pulses at some distance from each other.
/// Records that cannot be read are not; whoever reads them next says why.
pub(super) fn is_continuous(whole: &mut dyn Recording, options: &TriggerOptions) -> bool {
    let infos: Vec<HitInfo> = whole.hits().to_vec();
    let mut records = infos.iter().enumerate();
    let holds_several = |(record, info): (usize, &HitInfo)| {
        let Ok(force) = read_force(whole, record, info) else {
            return false;
        };
        // A preload is no part of the pulse.
        let mean = force.iter().sum::<f64>() / force.len().max(1) as f64;
        let distance = |value: &f64| (value - mean).abs();
        let peak = force.iter().map(distance).fold(0.0, f64::max);
        let high = force.iter().filter(|value| distance(value) > 0.25 * peak);
        let is_pulsed = high.count() as f64 <= MAX_PULSE_PART * force.len() as f64;
        let found = is_pulsed.then(|| segments(&force, info.axis.step_s, options));
        let Some(Ok(found)) = found else {
            return false;
        };
        let onsets: Vec<usize> = found.segments.iter().map(|hit| hit.onset).collect();
        let mean = force.len() as f64 / onsets.len().max(1) as f64;
        let is_apart = |pair: &[usize]| (pair[1] - pair[0]) as f64 >= MIN_DISTANCE_OVER_MEAN * mean;
        let height = |hit: &Segment| {
            force[hit.range.clone()]
                .iter()
                .map(distance)
                .fold(0.0, f64::max)
        };
        let is_high = |hit: &Segment| height(hit) >= MIN_HEIGHT_OF_TWO * peak;
        let are_hits = onsets.len() > 2 || found.segments.iter().all(is_high);
        onsets.len() > 1 && are_hits && onsets.windows(2).all(is_apart)
    };
    !infos.is_empty() && records.all(holds_several)
}

fn read_force(
    whole: &mut dyn Recording,
    record: usize,
    info: &HitInfo,
) -> Result<Vec<f64>, FrfError> {
    let (mut samples, mut force) = (Samples::F32(Vec::new()), Vec::new());
    let segment = ChannelSegment {
        hit: record,
        channel: ChannelPlace::Force,
        samples: 0..info.axis.len,
    };
    whole.read(&segment, &mut samples)?;
    to_si(info, &info.force, &samples, &mut force)?;
    Ok(force)
}

fn detect_hits(
    whole: &mut dyn Recording,
    record: usize,
    info: &HitInfo,
    options: &TriggerOptions,
) -> Result<Segments, FrfError> {
    let force = read_force(whole, record, info)?;
    Ok(segments(&force, info.axis.step_s, options)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::TimeAxis;
    use crate::quantity::Quantity;
    use crate::record::{Channel, Hit, Role, collect};

    const STEP_S: f64 = 1e-3;

    /// A record with pulses at these samples; sample n of the response is n.
    fn record(pulses: &[usize], len: usize) -> Hit {
        let mut force: Vec<f64> = (0..len).map(|n| 1e-3 * (0.7 * n as f64).sin()).collect();
        for pulse in pulses {
            for (n, height) in [3.0, 10.0, 3.0].into_iter().enumerate() {
                force[pulse + n] += height;
            }
        }
        let channel = |role, quantity, samples| Channel {
            role,
            dof: "1:+Z".parse().expect("a degree of freedom as text"),
            quantity,
            to_si: 2.0,
            samples: Samples::F64(samples),
        };
        Hit {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: STEP_S,
                len,
            },
            force: channel(Role::Force, Quantity::Force, force),
            responses: vec![channel(
                Role::Response,
                Quantity::Velocity,
                (0..len).map(|n| n as f64).collect(),
            )],
            origin: "long".to_owned(),
        }
    }

    /// Hits in memory, owned by the recording.
    struct Owned(Vec<Hit>, Vec<HitInfo>);

    impl Recording for Owned {
        fn hits(&self) -> &[HitInfo] {
            &self.1
        }

        fn read(
            &mut self,
            segment: &ChannelSegment,
            samples: &mut Samples,
        ) -> Result<(), crate::record::ReadError> {
            crate::record::InMemory::new(&self.0).read(segment, samples)
        }
    }

    #[test]
    fn hits_of_long_records_have_one_length_and_the_samples_around_their_trigger() {
        let records = vec![
            record(&[500, 2500, 4500], 6500),
            record(&[700, 2300, 3900], 5500),
        ];
        let infos = records.iter().map(Hit::info).collect();
        let whole = Box::new(Owned(records, infos));
        let (mut cut, findings) =
            cut_hits(whole, &TriggerOptions::default()).expect("a record with hits");
        let codes: Vec<Code> = findings.iter().map(|finding| finding.code).collect();
        let each = [Code::TriggerLevel, Code::HitLength];
        assert_eq!(codes, [each, each].concat());
        let hits = collect(&mut cut).expect("hits held in memory");
        assert_eq!(hits.len(), 6);
        let len = hits[0].axis.len;
        assert!((1500..=1600).contains(&len), "{len}");
        for (hit, onset) in hits.iter().zip([500, 2500, 4500, 700, 2300, 3900]) {
            assert_eq!(hit.axis.len, len);
            let force = hit.force.samples.to_f64();
            let peak = force
                .iter()
                .position(|f| *f > 9.0)
                .expect("a pulse above 9 N");
            // The response says which sample of the long record that is.
            let Samples::F64(response) = &hit.responses[0].samples else {
                panic!("double precision stays");
            };
            assert_eq!(response[peak] as usize, onset + 1);
        }
        assert!(
            hits[3].origin.starts_with("long at 0.6"),
            "{}",
            hits[3].origin
        );
    }
}

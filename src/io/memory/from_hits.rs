//! Recorded hits as a source.

use crate::io::{
    Block, Entry, EntryAxis, FunctionType, Identification, MemorySource, SampleFormat,
};
use crate::quantity::Unit;
use crate::record::{Channel, Hit, Role, Samples};

/// Hits as a source: hit after hit the force and then the responses, with the hit's number as
/// version and load case 1. Samples are as stored, each with its factor to SI. The force record's
/// response is the excitation point; the responses' reference is it too.
pub fn hit_source(hits: &[Hit], title: &str) -> MemorySource {
    let mut source = MemorySource::with_title(title);
    for (i, hit) in hits.iter().enumerate() {
        for channel in std::iter::once(&hit.force).chain(&hit.responses) {
            let mut entry = record_entry(hit, channel);
            entry.identification = Identification {
                version: i as i64 + 1,
                load_case: 1,
                ..Identification::with_title(title)
            };
            entry.identification.lines[1] = format!("hit {}", i + 1);
            let values = match &channel.samples {
                Samples::F32(values) => Block::F32(values.clone()),
                Samples::F64(values) => Block::F64(values.clone()),
            };
            source.push(entry, values, Vec::new());
        }
    }
    source
}

fn record_entry(hit: &Hit, channel: &Channel) -> Entry {
    let format = match channel.samples {
        Samples::F32(_) => SampleFormat::RealF32,
        Samples::F64(_) => SampleFormat::RealF64,
    };
    let unit = Unit {
        quantity: channel.quantity,
        to_si: channel.to_si,
    };
    Entry {
        response: Some(channel.dof.clone()),
        reference: (channel.role == Role::Response).then(|| hit.force.dof.clone()),
        quantity: Some(channel.quantity),
        to_si: Some(channel.to_si),
        unit_label: unit.name().unwrap_or_default().to_owned(),
        role: Some(channel.role),
        axis_label: "s".to_owned(),
        ..Entry::new(FunctionType::Time, EntryAxis::Time(hit.axis), format)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::TimeAxis;
    use crate::io::Source;
    use crate::quantity::Quantity;

    #[test]
    fn hits_keep_their_samples_as_stored() {
        let channel = |role, dof: &str, quantity, to_si, samples| Channel {
            role,
            dof: dof.parse().expect("a degree of freedom"),
            quantity,
            to_si,
            samples,
        };
        let force = channel(
            Role::Force,
            "4:-X",
            Quantity::Force,
            1.0,
            Samples::F32(vec![1.0]),
        );
        let response = |to_si| {
            let samples = Samples::F64(vec![2.0]);
            channel(
                Role::Response,
                "1:+Z",
                Quantity::Acceleration,
                to_si,
                samples,
            )
        };
        let hit = Hit {
            axis: TimeAxis {
                start_s: 0.0,
                step_s: 0.5,
                len: 1,
            },
            force,
            responses: vec![response(9.80665), response(0.123)],
            origin: String::new(),
        };
        let source = hit_source(&[hit.clone(), hit], "");
        let entries = &source.catalog().entries;
        let labels: Vec<&str> = entries.iter().map(|e| e.unit_label.as_str()).collect();
        assert_eq!(labels, ["N", "g", "", "N", "g", ""]);
        assert_eq!(entries[0].reference, None);
        assert_eq!(entries[5].reference, entries[3].response);
        assert_eq!(entries[4].identification.version, 2);
        assert_eq!(
            (entries[2].to_si, &source.blocks[2]),
            (Some(0.123), &Block::F64(vec![2.0]))
        );
        assert!(source.catalog().title.is_empty());
    }
}

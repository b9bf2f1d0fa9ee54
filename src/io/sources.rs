//! Recorded hits and FRF sets as sources in memory, so that every writer takes them as it takes an
//! opened file.

use std::ops::Range;

use super::sample_range::check_range;
use super::{
    Block, Catalog, Damage, Entry, EntryAxis, FunctionNote, FunctionType, Identification, IoError,
    MemorySource, SampleFormat, Source,
};
use crate::frf::{FrfSet, Function};
use crate::quantity::{Quantity, Unit};
use crate::record::{Channel, Hit, Role, Samples};

/// Type of a multiple coherence in dataset 58.
const MULTIPLE_COHERENCE: i32 = 26;

/// An FRF set as a source, its values where they are: every function (complex, 64 bits), then the
/// coherences that there are, those of several references, then the variances
/// ([`FunctionType::Variance`], SI unit squared). Values are in SI units; each entry has the note
/// of its function.
pub struct FrfSource<'a> {
    /// Its contents; geometry may be added.
    pub catalog: Catalog,
    set: &'a FrfSet,
    /// Function of each entry; the number of the response for a multiple coherence.
    functions: Vec<usize>,
}

/// The source of a set.
pub fn frf_source<'a>(set: &'a FrfSet, title: &str) -> FrfSource<'a> {
    let mut source = FrfSource {
        catalog: titled(title).catalog,
        set,
        functions: Vec::new(),
    };
    let functions = || set.functions().iter().enumerate();
    for (i, function) in functions() {
        let mut entry = function_entry(set, function, title);
        entry.unit_label = function.kind.si_unit().to_owned();
        source.push(entry, i);
    }
    for (i, function) in functions().filter(|(i, _)| set.coherence(*i).is_some()) {
        let entry = Entry {
            function_type: FunctionType::Coherence,
            quantity: None,
            denominator: None,
            format: SampleFormat::RealF64,
            ..function_entry(set, function, title)
        };
        source.push(entry, i);
    }
    for (i, response) in set.multiple_coherence.keys().enumerate() {
        let axis = EntryAxis::Frequency(*set.axis());
        let entry = Entry {
            identification: identification(title),
            response: Some(response.clone()),
            to_si: Some(1.0),
            axis_label: "Hz".to_owned(),
            ..Entry::new(
                FunctionType::Other(MULTIPLE_COHERENCE),
                axis,
                SampleFormat::RealF64,
            )
        };
        source.push(entry, i);
    }
    for (i, function) in functions().filter(|(i, _)| set.variance(*i).is_some()) {
        let entry = Entry {
            function_type: FunctionType::Variance,
            format: SampleFormat::RealF64,
            unit_label: format!("({})^2", function.kind.si_unit()),
            ..function_entry(set, function, title)
        };
        source.push(entry, i);
    }
    source
}

impl FrfSource<'_> {
    fn push(&mut self, entry: Entry, function: usize) {
        self.catalog.entries.push(entry);
        self.functions.push(function);
    }
}

impl Source for FrfSource<'_> {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn take_damage(&mut self) -> Vec<Damage> {
        std::mem::take(&mut self.catalog.damage)
    }

    fn read(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        check_range(&self.catalog, entry, &range)?;
        let function = self.functions[entry];
        let real = match self.catalog.entries[entry].function_type {
            FunctionType::Coherence => self.set.coherence(function),
            FunctionType::Variance => self.set.variance(function),
            FunctionType::Other(MULTIPLE_COHERENCE) => {
                let mut values = self.set.multiple_coherence.values();
                values.nth(function).map(Vec::as_slice)
            }
            _ => None,
        };
        *block = match real {
            Some(values) => Block::F64(values[range].to_vec()),
            None => Block::Complex(self.set.values(function)[range].to_vec()),
        };
        Ok(())
    }
}

/// Hits as a source: hit after hit the force and then the responses, with the hit's number as
/// version and load case 1. Samples are as stored, each with its factor to SI. The force record's
/// response is the hit point; the responses' reference is it too.
pub fn hit_source(hits: &[Hit], title: &str) -> MemorySource {
    let mut source = titled(title);
    for (i, hit) in hits.iter().enumerate() {
        for channel in std::iter::once(&hit.force).chain(&hit.responses) {
            let mut entry = record_entry(hit, channel);
            entry.identification = Identification {
                version: i as i64 + 1,
                load_case: 1,
                ..identification(title)
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

fn titled(title: &str) -> MemorySource {
    let mut source = MemorySource::default();
    let title = title.trim();
    if !title.is_empty() {
        source.catalog.title.push(title.to_owned());
    }
    source
}

fn identification(title: &str) -> Identification {
    let mut identification = Identification::default();
    title.trim().clone_into(&mut identification.lines[0]);
    identification
}

/// The entry of an FRF; a coherence or variance differs by type and ordinate.
fn function_entry(set: &FrfSet, function: &Function, title: &str) -> Entry {
    let axis = EntryAxis::Frequency(*set.axis());
    Entry {
        identification: identification(title),
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
        quantity: Some(function.kind.response_quantity()),
        denominator: Some(Quantity::Force),
        to_si: Some(1.0),
        axis_label: "Hz".to_owned(),
        note: FunctionNote {
            averages: function.averages,
            estimator: function.estimator,
            added_damping_rad_s: Some(set.added_damping_rad_s).filter(|decay| *decay > 0.0),
            record_s: set.record_duration_s,
            window: set.window,
            variance_dof: function.variance_dof,
            valid_hz: set.valid_band.map(|band| (band.lo_hz, band.hi_hz)),
        },
        ..Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64)
    }
}

fn record_entry(hit: &Hit, channel: &Channel) -> Entry {
    let format = match channel.samples {
        Samples::F32(_) => SampleFormat::RealF32,
        Samples::F64(_) => SampleFormat::RealF64,
    };
    let unit = Unit::of(channel.quantity, channel.to_si);
    Entry {
        response: Some(channel.dof.clone()),
        reference: (channel.role == Role::Response).then(|| hit.force.dof.clone()),
        quantity: Some(channel.quantity),
        to_si: Some(channel.to_si),
        unit_label: unit.map_or_else(String::new, |unit| unit.name.to_owned()),
        role: Some(channel.role),
        axis_label: "s".to_owned(),
        ..Entry::new(FunctionType::Time, EntryAxis::Time(hit.axis), format)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::axis::{FrequencyAxis, TimeAxis};
    use crate::frf::{Estimator, FunctionData};
    use crate::quantity::FrfKind;

    #[test]
    fn functions_then_coherences_then_variances() {
        let axis = FrequencyAxis {
            start_hz: 0.5,
            step_hz: 0.25,
            len: 2,
        };
        let mut set = FrfSet::new(axis);
        set.added_damping_rad_s = 2.5;
        for (response, quality) in [("1:+Z", None), ("2:-X#2", Some(vec![0.5, 0.75]))] {
            let function = Function {
                response: response.parse().expect("a degree of freedom"),
                reference: "1:+Z".parse().expect("a degree of freedom"),
                kind: FrfKind::Mobility,
                averages: Some(3),
                estimator: Some(Estimator::H1),
                variance_dof: None,
            };
            let data = FunctionData {
                values: vec![Complex64::new(1.0, 2.0), Complex64::new(3.0, 4.0)],
                coherence: quality.clone(),
                variance: quality,
            };
            set.push(function, data).expect("a function of the set");
        }
        let mut source = frf_source(&set, " Beam ");
        let types: Vec<FunctionType> = source
            .catalog()
            .entries
            .iter()
            .map(|entry| entry.function_type)
            .collect();
        use FunctionType::{Coherence, Frf, Variance};
        assert_eq!(types, [Frf, Frf, Coherence, Variance]);
        assert_eq!(source.catalog().title, ["Beam"]);
        let variance = &source.catalog().entries[3];
        assert_eq!(variance.unit_label, "((m/s)/N)^2");
        assert_eq!(
            variance.response.as_ref().expect("a response").to_string(),
            "2:-X#2"
        );
        assert_eq!(variance.note.averages, Some(3));
        assert_eq!(variance.note.added_damping_rad_s, Some(2.5));
        assert_eq!(source.catalog().entries[0].axis, EntryAxis::Frequency(axis));
        let mut block = Block::F32(Vec::new());
        source
            .read(2, 1..2, &mut block)
            .expect("samples of the entry");
        assert_eq!(block, Block::F64(vec![0.75]));
    }

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

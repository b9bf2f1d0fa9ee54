//! Tables that modalign writes come back to the bit.

use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::finding::{Code, Finding};
use crate::io::*;
use crate::quantity::Quantity;
use crate::record::Role;

fn written(source: &mut MemorySource) -> (String, Vec<Finding>) {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions {
        path: "o.csv".to_owned(),
        ..WriteOptions::default()
    };
    let findings = Table.write(&mut out, source, &options).unwrap();
    (String::from_utf8(out.into_inner()).unwrap(), findings)
}

fn read_back(text: &str) -> Box<dyn Source> {
    let source = open_bytes(text.as_bytes().to_vec(), &Hints::default()).unwrap();
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    source
}

fn time_axis(start_s: f64, step_s: f64, len: usize) -> EntryAxis {
    EntryAxis::Time(TimeAxis {
        start_s,
        step_s,
        len,
    })
}

fn frf(axis: EntryAxis) -> Entry {
    Entry {
        response: "2:+Z".parse().ok(),
        reference: "1:-X".parse().ok(),
        quantity: Some(Quantity::Acceleration),
        denominator: Some(Quantity::Force),
        to_si: Some(1.0),
        ..Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64)
    }
}

#[test]
fn the_headings_state_everything() {
    let axis = EntryAxis::Frequency(FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.5,
        len: 2,
    });
    let mut source = MemorySource::default();
    let values = vec![Complex64::new(1.0, -2.5), Complex64::new(1e300, 5e-324)];
    source.push(frf(axis), Block::Complex(values.clone()), Vec::new());
    let mut scaled = frf(axis);
    (scaled.to_si, scaled.unit_label) = (Some(0.102), "g/V".to_owned());
    source.push(scaled.clone(), Block::Complex(values), Vec::new());
    let mut coherence = Entry::new(FunctionType::Coherence, axis, SampleFormat::RealF32);
    (coherence.response, coherence.reference) = (scaled.response, scaled.reference);
    coherence.to_si = Some(1.0);
    source.push(coherence, Block::F32(vec![0.1, 1.0]), Vec::new());
    let mut variance = frf(axis);
    (variance.function_type, variance.format) = (FunctionType::Variance, SampleFormat::RealF64);
    source.push(variance, Block::F64(vec![f64::INFINITY, 0.25]), Vec::new());
    let (text, findings) = written(&mut source);
    assert_eq!(
        text,
        "frequency [Hz],re 2:+Z|1:-X [(m/s2)/N],im 2:+Z|1:-X [(m/s2)/N],re 2:+Z|1:-X [0.102 x (m/s2)/N],\
         im 2:+Z|1:-X [0.102 x (m/s2)/N],coherence 2:+Z|1:-X,variance 2:+Z|1:-X [((m/s2)/N)2]\n\
         0.0,1.0,-2.5,1.0,-2.5,0.1,inf\n0.5,1e300,5e-324,1e300,5e-324,1.0,0.25\n"
    );
    assert!(findings.is_empty());
    assert_same(&mut source, read_back(&text).as_mut());
    // A heading that says no role leaves the table to a scene.
    let silent = text.replace("coherence 2:+Z|1:-X", "gamma");
    let source = read_back(&silent);
    assert!(source.catalog().entries.is_empty());
    assert_eq!(source.catalog().arrays.len(), 7);
}

#[test]
fn properties_that_a_table_cannot_hold_are_counted() {
    let mut source = MemorySource::default();
    let axis = time_axis(0.0, 0.25, 2);
    let mut record = Entry::new(FunctionType::Time, axis, SampleFormat::RealF64);
    record.identification.lines[0] = "shaker off".to_owned();
    source.push(record.clone(), Block::F64(vec![1.0, 2.0]), Vec::new());
    record.axis = time_axis(0.0, 0.5, 2);
    source.push(record, Block::F64(vec![1.0, 2.0]), Vec::new());
    source.catalog.title = vec!["a test".to_owned()];
    let (text, findings) = written(&mut source);
    assert_eq!(text, "time [s],record ?\n0.0,1.0\n0.25,2.0\n");
    let lost: Vec<String> = findings
        .iter()
        .map(|finding| {
            assert_eq!(finding.code, Code::NotCarried);
            format!("{} {:?}", finding.location, finding.value)
        })
        .collect();
    assert_eq!(
        lost,
        [
            "parameter entries on other axes Some(1.0)",
            "parameter identification lines Some(1.0)",
            "parameter title lines Some(1.0)"
        ]
    );
    let mut out = Cursor::new(Vec::new());
    let error = Table.write(
        &mut out,
        &mut MemorySource::default(),
        &WriteOptions::default(),
    );
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("no record and no function")
    );
}

fn all(source: &mut dyn Source, entry: usize) -> (Block, Vec<u64>) {
    let len = source.catalog().entries[entry].len();
    let (mut block, mut abscissa) = (Block::F64(Vec::new()), Vec::new());
    source.read(entry, 0..len, &mut block).unwrap();
    source.abscissa(entry, 0..len, &mut abscissa).unwrap();
    (block, abscissa.into_iter().map(f64::to_bits).collect())
}

fn bits(block: &Block) -> Vec<(u64, u64)> {
    let real = |value: f64| (value.to_bits(), 0);
    match block {
        // A single comes back as a double that is the same single.
        Block::F32(values) => values.iter().map(|v| real(f64::from(*v))).collect(),
        Block::F64(values) => values.iter().map(|v| real(*v)).collect(),
        Block::Complex(values) => values
            .iter()
            .map(|v| (v.re.to_bits(), v.im.to_bits()))
            .collect(),
    }
}

/// Everything that the headings state, and every number, to the bit.
fn assert_same(written: &mut MemorySource, read: &mut dyn Source) {
    assert_eq!(
        written.catalog().entries.len(),
        read.catalog().entries.len()
    );
    for index in 0..written.catalog().entries.len() {
        let (wanted, got) = (
            written.catalog().entries[index].clone(),
            read.catalog().entries[index].clone(),
        );
        let stated = |entry: &Entry| {
            (
                (
                    entry.function_type,
                    entry.role,
                    entry.identification.version,
                ),
                (entry.response.clone(), entry.reference.clone()),
                (
                    entry.quantity,
                    entry.denominator,
                    entry.to_si.map(f64::to_bits),
                ),
                entry.axis.domain(),
                entry.axis.even().is_some(),
            )
        };
        assert_eq!(stated(&wanted), stated(&got));
        let ((a, x), (b, y)) = (all(written, index), all(read, index));
        assert_eq!(x, y, "abscissa");
        let narrowed = match (&a, b) {
            (Block::F32(_), Block::F64(values)) => {
                Block::F32(values.into_iter().map(|v| v as f32).collect())
            }
            (_, other) => other,
        };
        assert_eq!(bits(&a), bits(&narrowed));
    }
}

fn finite() -> impl Strategy<Value = f64> {
    any::<u64>()
        .prop_map(f64::from_bits)
        .prop_filter("finite", |v| v.is_finite())
}

fn axis(len: usize) -> impl Strategy<Value = (EntryAxis, Vec<f64>)> {
    let step = prop_oneof![
        (1u32..200_000).prop_map(|rate| 1.0 / f64::from(rate)),
        1e-9f64..1e6,
    ];
    let start = prop_oneof![Just(0.0), -1e3f64..1e3];
    (start, step, 0..4, proptest::collection::vec(finite(), len)).prop_map(
        move |(start, step, kind, values)| {
            let axis = match kind {
                0 => time_axis(start, step, len),
                1 => EntryAxis::Frequency(FrequencyAxis {
                    start_hz: start.abs(),
                    step_hz: step,
                    len,
                }),
                other => EntryAxis::General(GeneralAxis {
                    domain: [Domain::Time, Domain::Other(19)][usize::from(other == 3)],
                    even: None,
                    len,
                }),
            };
            let uneven = axis.even().is_none();
            (axis, if uneven { values } else { Vec::new() })
        },
    )
}

fn entry(axis: EntryAxis, len: usize) -> impl Strategy<Value = (Entry, Block)> {
    let dof = || proptest::option::of("[1-9][0-9]{0,3}:[+-](X|RY|Z)(#2)?");
    let types = prop_oneof![
        Just(FunctionType::Time),
        (0i32..40).prop_map(FunctionType::from_code)
    ];
    let stated = proptest::option::of((finite(), 0usize..4));
    let values = proptest::collection::vec((finite(), finite()), len);
    (types, dof(), dof(), stated, values, 0usize..3, -2i64..9).prop_map(
        move |(function_type, response, reference, unit, values, kind, version)| {
            let (format, block) = match kind {
                0 => {
                    let values = values.iter().map(|v| v.0 as f32);
                    let values = values.map(|v| if v.is_finite() { v } else { 0.5 });
                    (SampleFormat::RealF32, Block::F32(values.collect()))
                }
                1 => (
                    SampleFormat::RealF64,
                    Block::F64(values.iter().map(|v| v.0).collect()),
                ),
                _ => {
                    let values = values.iter().map(|v| Complex64::new(v.0, v.1));
                    (SampleFormat::ComplexF64, Block::Complex(values.collect()))
                }
            };
            let mut entry = Entry::new(function_type, axis, format);
            entry.response = response.map(|text| text.parse().unwrap());
            entry.reference = reference.map(|text| text.parse().unwrap());
            entry.identification.version = version;
            if function_type == FunctionType::Time {
                entry.role = [None, Some(Role::Force), Some(Role::Response)][kind];
            }
            if let Some((to_si, quantity)) = unit {
                let quantities = [Quantity::Force, Quantity::Displacement, Quantity::Velocity];
                entry.quantity = quantities.get(quantity).copied();
                entry.denominator = entry.quantity.filter(|_| version > 0);
                entry.to_si = Some(to_si);
            } else if function_type == FunctionType::Coherence {
                entry.to_si = Some(1.0);
            }
            (entry, block)
        },
    )
}

fn sources() -> impl Strategy<Value = MemorySource> {
    (2usize..9)
        .prop_flat_map(axis_with_len)
        .prop_flat_map(|(axis, abscissa, len)| {
            proptest::collection::vec(entry(axis, len), 1..4).prop_map(move |entries| {
                let mut source = MemorySource::default();
                for (entry, block) in entries {
                    source.push(entry, block, abscissa.clone());
                }
                source
            })
        })
}

fn axis_with_len(len: usize) -> impl Strategy<Value = (EntryAxis, Vec<f64>, usize)> {
    axis(len).prop_map(move |(axis, abscissa)| (axis, abscissa, len))
}

proptest! {
    #[test]
    fn a_written_table_comes_back_to_the_bit(mut source in sources()) {
        let (text, findings) = written(&mut source);
        prop_assert!(findings.is_empty(), "{findings:?}");
        assert_same(&mut source, read_back(&text).as_mut());
    }

    #[test]
    fn any_text_is_a_table_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..200), text in "[0-9,;.\t \n\"#eE+-]{0,80}") {
        let _ = Table.open(Box::new(Cursor::new(bytes)), &Hints::default());
        let _ = Table.open(Box::new(Cursor::new(text.into_bytes())), &Hints::default());
    }
}

//! Sources written by the generic writer are read back unchanged.

use std::io::Cursor;

use num_complex::Complex64;
use proptest::prelude::*;

use super::file_builder::{PATH, all, open};
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::finding::{Code, Finding};
use crate::io::formats::uff::Uff;
use crate::io::{
    Block, Domain, Encoding, Entry, EntryAxis, Format, FunctionType, GeneralAxis, MemorySource,
    Precision, SampleFormat, Source, Window, WriteOptions,
};
use crate::quantity::Quantity;

/// The whole abscissa of an entry.
pub(in crate::io::formats::uff) fn abscissa(source: &mut dyn Source, entry: usize) -> Vec<f64> {
    let len = source.catalog().entries[entry].len();
    let mut out = vec![7.0];
    source
        .abscissa(entry, 0..len, &mut out)
        .expect("the abscissa is there");
    out
}

/// An uneven axis.
pub(in crate::io::formats::uff) fn general(domain: Domain, len: usize) -> EntryAxis {
    EntryAxis::General(GeneralAxis {
        domain,
        even: None,
        len,
    })
}

/// A source as a file, and what is lost.
pub(in crate::io::formats::uff) fn written(
    source: &mut dyn Source,
    encoding: Encoding,
    precision: Option<Precision>,
) -> Result<(Vec<u8>, Vec<Finding>), crate::io::IoError> {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions {
        path: PATH.to_owned(),
        encoding,
        precision,
    };
    let findings = Uff.write(&mut out, source, &options)?;
    Ok((out.into_inner(), findings))
}

/// A source of one entry.
fn single(entry: Entry, values: Block, abscissa: Vec<f64>) -> MemorySource {
    let mut source = MemorySource::default();
    source.catalog.title = vec!["Machine".to_owned(), "second".to_owned()];
    source.push(entry, values, abscissa);
    source
}

/// The entry without what only a file gives it.
fn bare(mut entry: Entry) -> Entry {
    (entry.line, entry.byte) = (None, None);
    for line in &mut entry.identification.lines {
        if line.starts_with("modalign ") {
            line.clear();
        }
    }
    entry
}

fn bits(values: &Block) -> Vec<u64> {
    match values {
        Block::F32(values) => values.iter().map(|v| u64::from(v.to_bits())).collect(),
        Block::F64(values) => values.iter().map(|v| v.to_bits()).collect(),
        Block::Complex(values) => values
            .iter()
            .flat_map(|v| [v.re.to_bits(), v.im.to_bits()])
            .collect(),
    }
}

fn any_axis(len: usize) -> impl Strategy<Value = (EntryAxis, Vec<f64>)> {
    let finite = -1e12..1e12_f64;
    let step = prop_oneof![
        1e-9..1e6_f64,
        (1u32..200_000).prop_map(|hz| 1.0 / f64::from(hz))
    ];
    let uneven = proptest::collection::vec(finite.clone(), len);
    (0..6, finite, step, uneven, 19..40i32).prop_map(move |(kind, start, step, uneven, code)| {
        let even = Some((start, -step));
        match kind {
            kind if kind < 2 || len == 0 => (
                EntryAxis::Time(TimeAxis {
                    start_s: start,
                    step_s: step,
                    len,
                }),
                vec![],
            ),
            2 => (
                EntryAxis::Frequency(FrequencyAxis {
                    start_hz: start,
                    step_hz: step,
                    len,
                }),
                vec![],
            ),
            3 => {
                let domain = Domain::Other(code);
                (
                    EntryAxis::General(GeneralAxis { domain, even, len }),
                    vec![],
                )
            }
            4 => {
                let domain = Domain::Time;
                (
                    EntryAxis::General(GeneralAxis { domain, even, len }),
                    vec![],
                )
            }
            _ => (general(Domain::Other(code), len), uneven),
        }
    })
}

fn any_values(len: usize) -> impl Strategy<Value = (SampleFormat, Block)> {
    let singles = proptest::collection::vec(any::<f32>(), 2 * len);
    let doubles = proptest::collection::vec(any::<f64>(), 2 * len);
    (0..4, singles, doubles).prop_map(move |(kind, singles, doubles)| {
        let pairs = |re: &[f64]| re.chunks(2).map(|p| Complex64::new(p[0], p[1])).collect();
        let wide: Vec<f64> = singles.iter().map(|v| f64::from(*v)).collect();
        match kind {
            0 => (SampleFormat::RealF32, Block::F32(singles[..len].to_vec())),
            1 => (SampleFormat::RealF64, Block::F64(doubles[..len].to_vec())),
            2 => (SampleFormat::ComplexF32, Block::Complex(pairs(&wide))),
            _ => (SampleFormat::ComplexF64, Block::Complex(pairs(&doubles))),
        }
    })
}

/// Function type, quantity, denominator, factor to SI and unit.
type Ordinate = (
    FunctionType,
    Option<Quantity>,
    Option<Quantity>,
    Option<f64>,
    &'static str,
);

/// Ordinates that a file can say.
fn ordinates() -> Vec<Ordinate> {
    use Quantity::{Acceleration, Displacement, Force};
    vec![
        (
            FunctionType::Time,
            Some(Acceleration),
            None,
            Some(9.80665),
            "g",
        ),
        (
            FunctionType::Time,
            Some(Acceleration),
            None,
            None,
            "furlong",
        ),
        (FunctionType::Time, None, None, None, "Pa"),
        (
            FunctionType::Frf,
            Some(Displacement),
            Some(Force),
            Some(1e-3),
            "mm/N",
        ),
        (
            FunctionType::Frf,
            Some(Acceleration),
            Some(Force),
            Some(9.80665e-3),
            "g/kN",
        ),
        (
            FunctionType::Frf,
            Some(Acceleration),
            Some(Force),
            Some(1.0),
            "(m/s2)/N",
        ),
        (
            FunctionType::Frf,
            Some(Acceleration),
            Some(Force),
            None,
            "V/N",
        ),
        (FunctionType::Coherence, None, None, Some(1.0), ""),
        (FunctionType::Other(2), Some(Force), None, None, "N^2"),
        (FunctionType::Other(0), None, None, None, ""),
    ]
}

prop_compose! {
    fn any_source()(len in 0usize..12)(
        (axis, abscissa) in any_axis(len),
        (format, values) in any_values(len),
        which in 0..ordinates().len(),
        version in -9_999i64..=99_999,
        load_case in 0i64..=999_999,
        repeat in 1u32..4,
        averages in proptest::option::of(1u32..100),
        line in "[A-Za-z0-9][A-Za-z0-9 ]{0,30}[a-z]",
    ) -> MemorySource {
        let (function_type, quantity, denominator, to_si, label) = ordinates().remove(which);
        let mut entry = Entry::new(function_type, axis, format);
        (entry.quantity, entry.denominator, entry.to_si) = (quantity, denominator, to_si);
        entry.unit_label = label.to_owned();
        entry.axis_label = match axis.domain() {
            Domain::Time => "s",
            Domain::Frequency => "Hz",
            Domain::Other(_) => "rev",
        }.to_owned();
        (entry.identification.version, entry.identification.load_case) = (version, load_case);
        entry.identification.lines[1] = line;
        entry.response = Some(format!("frame.12:-Z#{repeat}").parse().expect("a name of a degree of freedom"));
        entry.reference = (repeat > 1).then(|| format!("bearing:+X#{repeat}").parse().expect("a name of a degree of freedom"));
        entry.note.averages = averages;
        entry.note.window = averages.and_then(|n| Window::from_code(i64::from(n)));
        single(entry, values, abscissa)
    }
}

proptest! {
    #[test]
    fn bytes_come_back_to_the_bit(mut source in any_source()) {
        let (bytes, lost) = written(&mut source, Encoding::Binary, None).expect("the source can be written");
        prop_assert!(lost.is_empty(), "{:?}", lost);
        let mut again = open(bytes).expect("what was written opens");
        prop_assert!(again.catalog().damage.is_empty(), "{:?}", again.catalog().damage);
        prop_assert_eq!(&again.catalog().title, &source.catalog.title);
        let mut expected = source.catalog.entries[0].clone();
        let got = bare(again.catalog().entries[0].clone());
        if expected.axis.even().is_none() && got.format != expected.format {
            // Abscissae that single precision does not hold widen the values.
            expected.format = got.format;
        } else {
            prop_assert_eq!(bits(&all(again.as_mut(), 0).expect("the values are there")), bits(&source.blocks[0]));
        }
        prop_assert_eq!(got, expected);
        let wanted = abscissa(&mut source, 0);
        prop_assert_eq!(abscissa(again.as_mut(), 0), wanted);
    }

    #[test]
    fn text_keeps_its_digits(mut source in any_source()) {
        let (bytes, _) = written(&mut source, Encoding::Text, None).expect("the source can be written");
        let mut again = open(bytes).expect("what was written opens");
        prop_assert!(again.catalog().damage.is_empty(), "{:?}", again.catalog().damage);
        let entry = source.catalog.entries[0].clone();
        let digits = match entry.format {
            SampleFormat::RealF32 | SampleFormat::ComplexF32 => 5.001e-6,
            _ => 5.001e-13,
        };
        let near = |a: f64, b: f64, digits: f64| {
            a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()) || (a - b).abs() <= digits * b.abs() + 5e-324
        };
        let flat = |block: &Block| -> Vec<f64> { match block {
            Block::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
            Block::F64(values) => values.clone(),
            Block::Complex(values) => values.iter().flat_map(|v| [v.re, v.im]).collect(),
        }};
        let (got, wanted) = (flat(&all(again.as_mut(), 0).expect("the values are there")), flat(&source.blocks[0]));
        prop_assert_eq!(got.len(), wanted.len());
        for (a, b) in got.iter().zip(&wanted) {
            prop_assert!(near(*a, *b, digits), "{a} {b}");
        }
        let (got, wanted) = (abscissa(again.as_mut(), 0), abscissa(&mut source, 0));
        for (a, b) in got.iter().zip(&wanted) {
            prop_assert!(near(*a, *b, 5.001e-6), "{a} {b}");
        }
        if entry.axis.even().is_some() {
            prop_assert_eq!(again.catalog().entries[0].axis, entry.axis);
        }
    }
}

#[test]
fn properties_without_a_field_are_reported() {
    let axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 1.0,
        len: 1,
    });
    let mut entry = Entry::new(FunctionType::Time, axis, SampleFormat::RealF64);
    (entry.quantity, entry.to_si) = (Some(Quantity::Force), Some(0.125));
    let mut source = single(entry.clone(), Block::F64(vec![2.0]), vec![]);
    let (bytes, lost) =
        written(&mut source, Encoding::Binary, None).expect("the source can be written");
    assert!(
        lost.is_empty(),
        "a factor that no unit has makes SI values: {lost:?}"
    );
    let mut again = open(bytes).expect("what was written opens");
    assert_eq!(
        all(again.as_mut(), 0).expect("the values are there"),
        Block::F64(vec![0.25])
    );
    assert_eq!(again.catalog().entries[0].to_si, Some(1.0));
    // A quantity without a stated unit does not get the unit of the file.
    entry.to_si = None;
    let mut source = single(entry.clone(), Block::F64(vec![2.0]), vec![]);
    let (bytes, _) = written(&mut source, Encoding::Text, None).expect("the source can be written");
    assert_eq!(
        open(bytes)
            .expect("what was written opens")
            .catalog()
            .entries[0]
            .to_si,
        None
    );
    entry.identification.lines[0] = "x".repeat(90);
    entry.identification.lines[3] = "theirs".to_owned();
    entry.identification.lines[4] = "theirs".to_owned();
    entry.note.averages = Some(3);
    entry.unit_label = "a unit of more than twenty characters".to_owned();
    let mut source = single(entry.clone(), Block::F64(vec![2.0]), vec![]);
    entry.function_type = FunctionType::Variance;
    source.push(entry, Block::F64(vec![2.0]), vec![]);
    let (bytes, lost) =
        written(&mut source, Encoding::Binary, None).expect("the source can be written");
    let reported: Vec<String> = lost
        .iter()
        .map(|finding| finding.location.to_string())
        .collect();
    let expected = [
        "parameter characters of an identification line",
        "parameter note of how a function was made",
        "parameter variance of FRFs",
    ];
    assert_eq!(reported, expected);
    assert!(
        lost.iter()
            .all(|f| (f.code, f.value) == (Code::NotCarried, Some(1.0)))
    );
    assert_eq!(
        open(bytes)
            .expect("what was written opens")
            .catalog()
            .entries
            .len(),
        1
    );
}

#[test]
fn unwritable_entries_are_errors() {
    let axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 1.0,
        len: 1,
    });
    let entry = Entry::new(FunctionType::Time, axis, SampleFormat::RealF64);
    let refused = |change: &dyn Fn(&mut Entry), precision| {
        let mut entry = entry.clone();
        change(&mut entry);
        let mut source = single(entry, Block::F64(vec![1e300]), vec![]);
        written(&mut source, Encoding::Binary, precision)
            .err()
            .map(|error| error.to_string())
    };
    assert_eq!(refused(&|_| {}, None), None);
    for (change, precision, expected) in [
        (
            (&|_: &mut Entry| {}) as &dyn Fn(&mut Entry),
            Some(Precision::Single),
            "cannot write sample: got 1e300",
        ),
        (
            &|entry: &mut Entry| entry.identification.version = 100_000,
            None,
            "cannot write version number: got 100000, expected -9999 to 99999",
        ),
        (
            &|entry: &mut Entry| entry.response = "a-long-bearing:+Z".parse().ok(),
            None,
            "got degree of freedom `a-long-bearing:+Z`",
        ),
    ] {
        let error = refused(change, precision).unwrap_or_default();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn digits_that_text_cuts_off_are_reported() {
    let time = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 1.0,
        len: 2,
    });
    let losses = |axis, values: [f32; 2], abscissa: &[f64], encoding| {
        let entry = Entry::new(FunctionType::Time, axis, SampleFormat::RealF32);
        let mut source = single(entry, Block::F32(values.to_vec()), abscissa.to_vec());
        let (_, lost) = written(&mut source, encoding, None).expect("the source can be written");
        let names = lost.iter().map(|finding| finding.location.to_string());
        (
            names.collect::<Vec<_>>(),
            lost.first().and_then(|finding| finding.value),
        )
    };
    let (short, long) = ([1.5, -0.25], [1.5, 16_777_215.0]);
    let (none, one) = ((vec![], None), Some(1.0));
    assert_eq!(losses(time, short, &[], Encoding::Text), none);
    assert_eq!(losses(time, long, &[], Encoding::Binary), none);
    let values = "parameter digits of single-precision values".to_owned();
    assert_eq!(losses(time, long, &[], Encoding::Text), (vec![values], one));
    let uneven = general(Domain::Other(19), 2);
    assert_eq!(losses(uneven, short, &[1.0, 2.5], Encoding::Text), none);
    let abscissa = "parameter digits of uneven abscissae".to_owned();
    let near = [1_000.0, 1_000.000_01];
    assert_eq!(losses(uneven, short, &near, Encoding::Binary), none);
    assert_eq!(
        losses(uneven, short, &near, Encoding::Text),
        (vec![abscissa], one)
    );
}

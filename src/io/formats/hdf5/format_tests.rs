//! Written files are read back unchanged, and damage is reported.

use std::io::Cursor;

use hdf5_pure::{Datatype, FileBuilder, make_u8_type};
use proptest::prelude::*;

use super::Hdf5;
use super::list::list_here;
use super::stream::Stream;
use crate::io::formats::arrays::schema::drawn_sources::{assert_same, drawn};
use crate::io::{Confidence, Format, Hints, MemorySource, Source, WriteOptions};

fn written(source: &mut dyn Source) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions::default();
    let findings = Hdf5
        .write(&mut out, source, &options)
        .expect("memory is writable");
    assert!(findings.is_empty(), "{findings:?}");
    out.into_inner()
}

fn opened(bytes: Vec<u8>) -> Box<dyn Source> {
    let hints = Hints {
        path: "test.h5".to_owned(),
        table: None,
    };
    Hdf5.open(Box::new(Cursor::new(bytes)), &hints)
        .expect("a sound file")
}

fn round_trip(mut source: MemorySource) {
    let bytes = written(&mut source);
    assert_eq!(bytes, written(&mut source), "same input, same bytes");
    let head = &bytes[..bytes.len().min(4096)];
    assert_eq!(Hdf5.detect(head), Confidence::Certain);
    let mut back = opened(bytes);
    let damage = &back.catalog().damage;
    assert!(damage.is_empty(), "{damage:?}");
    assert_same(&mut source, back.as_mut());
}

proptest! {
    #[test]
    fn what_is_written_comes_back_to_the_bit(seed: u64) {
        round_trip(drawn(seed));
    }
}

#[test]
fn an_empty_source_comes_back_empty() {
    round_trip(MemorySource::default());
}

#[test]
fn a_header_before_the_signature_is_accepted_and_other_bytes_are_not() {
    for size in [512, 1024, 2048] {
        let mut builder = FileBuilder::new();
        builder.with_userblock(size);
        builder.create_dataset("x").with_f64_data(&[1.0, 2.0]);
        let bytes = builder.finish().expect("a file in memory");
        assert_eq!(
            Hdf5.detect(&bytes[..bytes.len().min(4096)]),
            Confidence::Certain
        );
        assert_eq!(opened(bytes).catalog().arrays.len(), 1);
    }
    assert_eq!(Hdf5.detect(b"MATLAB 5.0 MAT-file"), Confidence::No);
    assert_eq!(Hdf5.detect(b"\x89HDF\r\n"), Confidence::No);
}

#[test]
fn datatypes_in_datatypes_without_end_are_refused_and_the_rest_is_read() {
    // Eight bytes for each level: 8,000 levels fit in a message, and dropping them takes a separate
    // stack.
    let make = || {
        let mut datatype = make_u8_type();
        for _ in 0..8000 {
            datatype = Datatype::VariableLength {
                is_string: false,
                padding: None,
                charset: None,
                base_type: Box::new(datatype),
            };
        }
        let mut builder = FileBuilder::new();
        let deep = builder.create_dataset("deep");
        deep.with_dtype(datatype).with_shape(&[0]);
        builder.create_dataset("x").with_f64_data(&[1.0, 2.0]);
        builder.finish().expect("a file in memory")
    };
    let builder = std::thread::Builder::new().stack_size(256 << 20);
    let bytes = builder
        .spawn(make)
        .expect("a thread starts")
        .join()
        .expect("it ends");
    let source = opened(bytes);
    let catalog = source.catalog();
    assert_eq!(catalog.arrays.len(), 1);
    assert_eq!(catalog.damage.len(), 1);
    let said = catalog.damage[0].to_string();
    assert!(
        said.contains("deep: a datatype nested deeper than 32 levels"),
        "{said}"
    );
}

#[test]
fn an_array_larger_than_its_file_is_refused_before_allocation() {
    let mut builder = FileBuilder::new();
    builder
        .create_dataset("x")
        .with_f64_data(&[1.0, 2.0])
        .with_shape(&[2]);
    let data = builder.create_dataset("c");
    data.with_f64_data(&[1.0; 64])
        .with_chunks(&[16])
        .with_deflate(6);
    let mut bytes = builder.finish().expect("a file in memory");
    // The length 64 of the chunked dataset becomes 2^40; its chunks stay.
    let place = bytes
        .windows(8)
        .position(|window| window == 64_u64.to_le_bytes());
    let place = place.expect("the size is in the file");
    bytes[place..place + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let hints = Hints::default();
    let opened = std::panic::AssertUnwindSafe(|| Hdf5.open(Box::new(Cursor::new(bytes)), &hints));
    let peak = allocation_counter::measure(|| drop(opened())).bytes_max;
    assert!(peak < 1 << 20, "{peak}");
}

#[test]
fn a_listing_takes_no_more_memory_than_its_file_allows() {
    // The listing runs on a separate thread; here it is measured on this one.
    let mut builder = FileBuilder::new();
    for name in 0..40 {
        builder
            .create_dataset(&format!("x{name}"))
            .with_f64_data(&[1.0]);
    }
    let bytes = builder.finish().expect("a file in memory");
    let size = bytes.len() as u64;
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        let stream = Stream::new(Box::new(Cursor::new(damaged))).expect("memory is readable");
        let peak = allocation_counter::measure(|| {
            let _ = list_here(&stream, false, "damaged.h5");
        });
        assert!(
            peak.bytes_max < 64 * size + (4 << 20),
            "byte {at}: {}",
            peak.bytes_max
        );
    }
}

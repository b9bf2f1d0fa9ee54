//! Files of every kind of dataset, made with the writer of `hdf5-pure`.

use std::io::Cursor;

use hdf5_pure::{
    AttrValue, CharacterSet, CompoundTypeBuilder, Datatype, DatatypeByteOrder, EnumTypeBuilder,
    FileBuilder, FloatingPointLayout, StringPadding, make_f32_type, make_f64_type, make_i16_type,
    make_u8_type,
};
use num_complex::Complex64;

use super::open_store;
use super::store::Hdf5Store;
use crate::io::formats::arrays::store::{ArrayStore, Elements, NamedArray};

fn open(builder: FileBuilder) -> Hdf5Store {
    let bytes = builder.finish().unwrap();
    open_store(Box::new(Cursor::new(bytes)), "test.h5").unwrap()
}

fn named(store: &mut Hdf5Store, name: &str) -> NamedArray {
    let index = store.list().iter().position(|info| info.name == name);
    store
        .read(index.unwrap_or_else(|| panic!("{name}")))
        .unwrap()
}

fn doubles(store: &mut Hdf5Store, name: &str) -> Vec<f64> {
    match named(store, name).elements {
        Elements::F64(values) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn texts(store: &mut Hdf5Store, name: &str) -> Vec<String> {
    match named(store, name).elements {
        Elements::Text(values) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn complex(store: &mut Hdf5Store, name: &str) -> Vec<Complex64> {
    match named(store, name).elements {
        Elements::Complex(values) => values,
        other => panic!("{name}: {other:?}"),
    }
}

fn kinds(store: &Hdf5Store) -> Vec<(String, Vec<usize>, String)> {
    let infos = store.list().iter();
    infos
        .map(|info| (info.name.clone(), info.shape.clone(), info.kind.clone()))
        .collect()
}

#[test]
fn datasets_of_groups_are_listed_with_shape_and_kind() {
    let mut builder = FileBuilder::new();
    let data = builder.create_dataset("a");
    data.with_f64_data(&[1.0; 6]).with_shape(&[2, 3]);
    let mut outer = builder.create_group("run 1");
    outer.create_dataset("f").with_f32_data(&[0.5, 1.5]);
    let mut inner = outer.create_group("inner");
    inner.create_dataset("n").with_i16_data(&[-1]);
    outer.add_group(inner.finish());
    builder.add_group(outer.finish());
    let store = open(builder);
    let expected = [
        ("a", vec![2, 3], "f64"),
        ("run 1/f", vec![2], "f32"),
        ("run 1/inner/n", vec![1], "i16"),
    ];
    let expected = expected.map(|(name, shape, kind)| (name.to_owned(), shape, kind.to_owned()));
    assert_eq!(kinds(&store), expected);
}

#[test]
fn integers_and_floats_of_both_byte_orders_are_read_to_the_bit() {
    let mut builder = FileBuilder::new();
    let values = [0.1, -2.5e300, f64::MIN_POSITIVE, -0.0];
    builder.create_dataset("f64").with_f64_data(&values);
    let single = [0.1_f32, -1.5e30];
    builder.create_dataset("f32").with_f32_data(&single);
    builder.create_dataset("i64").with_i64_data(&[-9, 1 << 53]);
    builder.create_dataset("u8").with_u8_data(&[0, 255]);
    let big = Datatype::FloatingPoint {
        size: 8,
        byte_order: DatatypeByteOrder::BigEndian,
        layout: FloatingPointLayout::IEEE754_BINARY64,
    };
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_be_bytes())
        .collect();
    let data = builder.create_dataset("big");
    data.with_raw_data(big, bytes, 4).with_shape(&[4]);
    let Datatype::FixedPoint { size, layout, .. } = make_i16_type() else {
        panic!("an integer type");
    };
    let big_integer = Datatype::FixedPoint {
        size,
        byte_order: DatatypeByteOrder::BigEndian,
        layout,
    };
    let bytes = [-2_i16, 300].iter().flat_map(|v| v.to_be_bytes()).collect();
    let data = builder.create_dataset("i16be");
    data.with_raw_data(big_integer, bytes, 2).with_shape(&[2]);
    let mut store = open(builder);
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(doubles(&mut store, "f64")), bits(values.to_vec()));
    assert_eq!(bits(doubles(&mut store, "big")), bits(values.to_vec()));
    let read = named(&mut store, "f32").elements;
    assert_eq!(read, Elements::F32(single.to_vec()));
    assert_eq!(read, Elements::F32(single.to_vec()));
    assert_eq!(
        bits(doubles(&mut store, "i64")),
        bits(vec![-9.0, 2_f64.powi(53)])
    );
    assert_eq!(bits(doubles(&mut store, "u8")), bits(vec![0.0, 255.0]));
    assert_eq!(bits(doubles(&mut store, "i16be")), bits(vec![-2.0, 300.0]));
}

#[test]
fn complex_numbers_of_h5py_and_of_matlab_are_read() {
    let mut builder = FileBuilder::new();
    let matlab = builder.create_dataset("matlab");
    matlab.with_complex64_data(&[(1.0, -2.0), (0.5, 4.0)]);
    let h5py = CompoundTypeBuilder::new().field("r", make_f32_type());
    let h5py = h5py.field("i", make_f32_type()).build().unwrap();
    let bytes = [1.5_f32, -2.5]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let data = builder.create_dataset("h5py");
    data.with_compound_data(h5py, bytes, 1).with_shape(&[1]);
    let record = CompoundTypeBuilder::new().field("t", make_f64_type());
    let record = record.field("f", make_f64_type()).build().unwrap();
    let data = builder.create_dataset("record");
    data.with_compound_data(record, vec![0; 16], 1)
        .with_shape(&[1]);
    let mut store = open(builder);
    assert_eq!(
        complex(&mut store, "matlab"),
        [Complex64::new(1.0, -2.0), Complex64::new(0.5, 4.0)]
    );
    assert_eq!(complex(&mut store, "h5py"), [Complex64::new(1.5, -2.5)]);
    let kinds: Vec<&str> = store.list().iter().map(|info| info.kind.as_str()).collect();
    assert_eq!(kinds, ["complex f64", "complex f32", "struct"]);
    assert!(!store.can_read(2) && store.read(2).is_err());
    assert!(store.take_damage().is_empty());
}

#[test]
fn texts_and_logical_values_are_read() {
    let mut builder = FileBuilder::new();
    let fixed = builder.create_dataset("fixed");
    fixed.with_strings(&["12:+Z", "m/s²", ""]).unwrap();
    builder
        .create_dataset("variable")
        .with_vlen_strings(&["a", "", "longer text"]);
    let spaces = Datatype::String {
        size: 4,
        padding: StringPadding::SpacePad,
        charset: CharacterSet::Ascii,
    };
    let data = builder.create_dataset("spaces");
    data.with_raw_data(spaces, b"ab  cdef".to_vec(), 2)
        .with_shape(&[2]);
    let truth = EnumTypeBuilder::with_base(make_u8_type());
    let truth = truth
        .u8_value("FALSE", 0)
        .u8_value("TRUE", 1)
        .build()
        .unwrap();
    builder
        .create_dataset("truth")
        .with_enum_u8_data(truth, &[1, 0]);
    let mut store = open(builder);
    assert_eq!(texts(&mut store, "fixed"), ["12:+Z", "m/s²", ""]);
    assert_eq!(texts(&mut store, "variable"), ["a", "", "longer text"]);
    assert_eq!(texts(&mut store, "spaces"), ["ab", "cdef"]);
    assert_eq!(doubles(&mut store, "truth").len(), 2);
    assert_eq!(store.list()[3].kind, "bool");
}

#[test]
fn compressed_chunks_are_read_whole_and_in_part() {
    let values: Vec<f64> = (0..700_u16).map(|i| f64::from(i).sqrt()).collect();
    let mut builder = FileBuilder::new();
    let data = builder.create_dataset("x");
    data.with_f64_data(&values)
        .with_shape(&[70, 10])
        .with_chunks(&[9, 4]);
    data.with_shuffle().with_deflate(6);
    let mut store = open(builder);
    assert_eq!(
        named(&mut store, "x").elements,
        Elements::F64(values.clone())
    );
    for range in [0..700, 5..6, 0..10, 83..412, 699..700, 88..95, 3..3] {
        let part = store.read_part(0, range.clone()).unwrap();
        assert_eq!(part, Elements::F64(values[range].to_vec()));
    }
    assert!(store.read_part(0, 690..701).is_err());
}

#[test]
fn blocks_of_single_precision_are_read_straight_and_nothing_else_is() {
    let values: Vec<f32> = (0..600_u16).map(|i| f32::from(i).sqrt()).collect();
    for user_block in [0, 512] {
        let mut builder = FileBuilder::new();
        if user_block > 0 {
            builder.with_userblock(user_block);
        }
        let block = builder.create_dataset("block");
        block.with_f32_data(&values).with_shape(&[60, 10]);
        let chunked = builder.create_dataset("chunked");
        chunked.with_f32_data(&values).with_shape(&[60, 10]);
        chunked.with_chunks(&[9, 4]);
        let double = builder.create_dataset("double");
        double.with_f64_data(&[1.5; 600]).with_shape(&[600]);
        let mut store = open(builder);
        let place = |store: &Hdf5Store, name: &str| {
            let index = store.list().iter().position(|info| info.name == name);
            index.unwrap_or_else(|| panic!("{name}"))
        };
        let (block, mut read) = (place(&store, "block"), vec![7.0; 3]);
        for range in [0..600, 5..6, 83..412, 599..600, 3..3] {
            assert!(store.read_singles(block, range.clone(), &mut read).unwrap());
            assert_eq!(read, values[range]);
        }
        assert!(store.read_singles(block, 590..601, &mut read).is_err());
        for name in ["chunked", "double"] {
            let other = place(&store, name);
            assert!(!store.read_singles(other, 0..10, &mut read).unwrap());
        }
    }
}

/// A file of MATLAB with what is added to it.
fn matlab() -> FileBuilder {
    let mut builder = FileBuilder::new();
    builder.with_userblock(512);
    builder.with_userblock_content(b"MATLAB 7.3 MAT-file, Platform: test");
    builder
}

fn class(name: &str) -> AttrValue {
    AttrValue::AsciiString(name.to_owned())
}

#[test]
fn arrays_characters_cells_and_structures_of_matlab_are_read() {
    let mut builder = matlab();
    // a = [1 2 3; 4 5 6] is stored by columns.
    let a = builder.create_dataset("a");
    a.with_f64_data(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0])
        .with_shape(&[3, 2]);
    a.set_attr("MATLAB_class", class("double"));
    let text = builder.create_dataset("text");
    text.with_u16_data(&[109, 47, 115, 178]).with_shape(&[4, 1]);
    text.set_attr("MATLAB_class", class("char"));
    let empty = builder.create_dataset("empty");
    empty.with_u64_data(&[0, 3]).with_shape(&[2]);
    empty.set_attr("MATLAB_class", class("double"));
    empty.set_attr("MATLAB_empty", AttrValue::U8(1));
    let cells = builder.create_dataset("c");
    cells
        .with_path_references(&["#refs#/b", "#refs#/c"])
        .with_shape(&[2, 1]);
    cells.set_attr("MATLAB_class", class("cell"));
    let mut structure = builder.create_group("s");
    structure.set_attr("MATLAB_class", class("struct"));
    let flag = structure.create_dataset("flag");
    flag.with_u8_data(&[1]).with_shape(&[1, 1]);
    flag.set_attr("MATLAB_class", class("logical"));
    builder.add_group(structure.finish());
    let mut hidden = builder.create_group("#refs#");
    let first = hidden.create_dataset("b");
    first.with_complex64_data(&[(1.0, 2.0)]).with_shape(&[1, 1]);
    let second = hidden.create_dataset("c");
    second.with_u16_data(&[72, 105]).with_shape(&[2, 1]);
    second.set_attr("MATLAB_class", class("char"));
    builder.add_group(hidden.finish());
    let mut store = open(builder);
    let expected = [
        ("a", vec![2, 3], "f64"),
        ("text", vec![], "text"),
        ("empty", vec![0, 3], "u64"),
        ("c", vec![1, 2], "cell"),
        ("c{1}", vec![1, 1], "complex f64"),
        ("c{2}", vec![], "text"),
        ("s/flag", vec![1, 1], "bool"),
    ];
    let expected = expected.map(|(name, shape, kind)| (name.to_owned(), shape, kind.to_owned()));
    assert_eq!(kinds(&store), expected);
    let rows = Elements::F64(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(named(&mut store, "a").elements, rows);
    assert_eq!(store.read_part(0, 2..4).unwrap(), rows.part(2..4).unwrap());
    assert_eq!(texts(&mut store, "text"), ["m/s²"]);
    assert_eq!(doubles(&mut store, "empty"), [0.0; 0]);
    assert_eq!(complex(&mut store, "c{1}"), [Complex64::new(1.0, 2.0)]);
    assert_eq!(texts(&mut store, "c{2}"), ["Hi"]);
    assert!(!store.can_read(3) && store.read(3).is_err());
    assert!(store.take_damage().is_empty());
}

#[test]
fn a_huge_length_beside_one_of_zero_is_an_empty_array() {
    let mut builder = FileBuilder::new();
    for (name, shape) in [("a", [1 << 50, 0]), ("b", [0, 1 << 50])] {
        let data = builder.create_dataset(name);
        data.with_f64_data(&[]).with_shape(&shape);
    }
    let mut store = open(builder);
    for name in ["a", "b"] {
        assert_eq!(doubles(&mut store, name), [0.0; 0], "{name}");
    }
}

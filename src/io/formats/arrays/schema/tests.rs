use crate::finding::Code;
use proptest::prelude::*;

use super::drawn_sources::{assert_same, drawn};
use super::*;
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::io::formats::arrays::source::open_arrays;
use crate::io::formats::arrays::store::{ArrayStore, Elements};
use crate::io::{
    ArrayInfo, Block, Entry, EntryAxis, FunctionType, Hints, MemorySource, SampleFormat,
};

/// Arrays in memory as a container.
struct Arrays {
    list: Vec<ArrayInfo>,
    arrays: Vec<NamedArray>,
    file_bytes: u64,
}

impl Arrays {
    fn new(arrays: Vec<NamedArray>) -> Self {
        let info = |array: &NamedArray| ArrayInfo {
            name: array.name.clone(),
            shape: array.shape.clone(),
            kind: String::new(),
        };
        Self {
            list: arrays.iter().map(info).collect(),
            file_bytes: u64::MAX,
            arrays,
        }
    }
}

impl ArrayStore for Arrays {
    fn list(&self) -> &[ArrayInfo] {
        &self.list
    }

    fn bytes(&self, index: usize) -> u64 {
        match &self.arrays[index].elements {
            Elements::Text(texts) => texts.iter().map(|text| text.len() as u64).sum(),
            numbers => numbers.len() as u64 * 8,
        }
    }

    fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    fn read(&mut self, index: usize) -> Result<NamedArray, IoError> {
        Ok(self.arrays[index].clone())
    }
}

fn written(source: &mut dyn Source) -> (Vec<NamedArray>, Vec<Finding>) {
    let mut arrays = Vec::new();
    let findings = write_with_schema(source, None, &mut |array| {
        arrays.push(array);
        Ok(())
    });
    (arrays, findings.expect("the source can be written"))
}

fn read_back(arrays: Vec<NamedArray>) -> Box<dyn Source> {
    open_arrays("test", Box::new(Arrays::new(arrays)), &Hints::default())
        .expect("what was written opens")
}

proptest! {
    #[test]
    fn everything_comes_back_to_the_bit(seed: u64) {
        let mut source = drawn(seed);
        let (arrays, findings) = written(&mut source);
        prop_assert!(findings.is_empty(), "{findings:?}");
        for array in &arrays {
            let levels: Vec<&str> = array.name.split('/').collect();
            let legal = |c: char| c.is_ascii_alphanumeric() || c == '_';
            prop_assert!(levels.len() <= 2 && levels.iter().all(|level| level.chars().all(legal)));
            prop_assert!(levels.iter().all(|level| level.len() <= 63), "{}", array.name);
            prop_assert_eq!(array.shape.iter().product::<usize>(), array.elements.len());
        }
        let names: Vec<String> = arrays.iter().map(|array| array.name.clone()).collect();
        prop_assert_eq!(array_names(&mut source, None).expect("every source has names"), names);
        assert_same(&mut source, read_back(arrays).as_mut());
    }
}

fn two_functions() -> MemorySource {
    let axis = EntryAxis::Frequency(FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.5,
        len: 3,
    });
    let mut source = MemorySource::default();
    for response in ["1:+Z", "2:+Z"] {
        let mut entry = Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64);
        entry.response = Some(response.parse().expect("a name of a degree of freedom"));
        let values = (0..3).map(|line| num_complex::Complex64::new(f64::from(line), 0.1));
        source.push(entry, Block::Complex(values.collect()), Vec::new());
    }
    source
}

fn array<'a>(arrays: &'a [NamedArray], name: &str) -> &'a NamedArray {
    arrays
        .iter()
        .find(|array| array.name == name)
        .expect("an array of that name")
}

#[test]
fn the_array_names_of_the_layout_are_written() {
    let (arrays, _) = written(&mut two_functions());
    assert_eq!(
        array(&arrays, "schema").elements,
        Elements::Text(vec![SCHEMA.to_owned()])
    );
    let hz = array(&arrays, "frf/frequency_hz");
    assert_eq!(hz.elements, Elements::F64(vec![0.0, 0.5, 1.0]));
    let re = array(&arrays, "frf/re");
    assert_eq!(re.shape, [2, 3]);
    assert_eq!(
        re.elements,
        Elements::F64(vec![0.0, 1.0, 2.0, 0.0, 1.0, 2.0])
    );
    let im = array(&arrays, "frf/im");
    assert_eq!(im.elements, Elements::F64(vec![0.1; 6]));
    let response = array(&arrays, "frf/response");
    let names = ["1:+Z", "2:+Z"].map(str::to_owned).to_vec();
    assert_eq!(response.elements, Elements::Text(names));
    let Elements::F64(to_si) = &array(&arrays, "frf/to_si").elements else {
        panic!("numbers")
    };
    assert!(
        to_si.iter().all(|value| value.is_nan()),
        "a unit that is not stated is NaN"
    );
}

#[test]
fn the_requested_precision_is_written() {
    let mut arrays = Vec::new();
    let single = Some(Precision::Single);
    write_with_schema(&mut two_functions(), single, &mut |array| {
        arrays.push(array);
        Ok(())
    })
    .unwrap();
    assert_eq!(
        array(&arrays, "frf/im").elements,
        Elements::F32(vec![0.1_f32; 6])
    );
    let source = read_back(arrays);
    assert_eq!(source.catalog().entries[0].format, SampleFormat::ComplexF32);
}

#[test]
fn an_unusable_group_is_damage_and_the_others_are_read() {
    let mut source = two_functions();
    let axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 0.1,
        len: 2,
    });
    let entry = Entry::new(FunctionType::Time, axis, SampleFormat::RealF64);
    source.push(entry, Block::F64(vec![1.0, 2.0]), Vec::new());
    let spoil: [fn(&mut NamedArray); 4] = [
        |array| array.shape = vec![2, 2],
        |array| array.shape = vec![usize::MAX, 3],
        |array| array.name = "frf/other".to_owned(),
        |array| array.shape = vec![0, 3],
    ];
    for spoil in spoil {
        let (mut arrays, _) = written(&mut source);
        let re = arrays
            .iter()
            .position(|array| array.name == "frf/re")
            .unwrap();
        spoil(&mut arrays[re]);
        let read = read_back(arrays);
        let catalog = read.catalog();
        assert_eq!((catalog.entries.len(), catalog.damage.len()), (1, 1));
        assert_eq!(catalog.findings[0].code, Code::BadDataset);
        let error = catalog.damage[0].to_string();
        assert!(error.contains("frf"), "{error}");
    }
}

#[test]
fn properties_that_the_layout_cannot_hold_are_reported() {
    let mut source = two_functions();
    source.catalog.entries[0].identification.version = (1 << 53) + 1;
    source.catalog.arrays.push(ArrayInfo {
        name: "x".to_owned(),
        shape: vec![3],
        kind: "f64".to_owned(),
    });
    let mode = crate::modal::Mode::new(
        1.0,
        Some(f64::NAN),
        crate::modal::ModeShape::new([]),
        crate::modal::Scaling::Unknown,
    );
    source.catalog.modes.push(crate::io::ModeEntry::new(mode));
    let (arrays, findings) = written(&mut source);
    assert!(!arrays.iter().any(|array| array.name.starts_with("modes/")));
    let places: Vec<String> = findings
        .iter()
        .map(|finding| finding.location.to_string())
        .collect();
    assert_eq!(places.len(), 3, "{places:?}");
    assert!(
        findings
            .iter()
            .all(|finding| finding.code == Code::NotCarried)
    );
}

/// The one error of the layout after `spoil` of the named array.
fn spoiled(name: &str, spoil: impl Fn(&mut NamedArray)) -> String {
    let (mut arrays, _) = written(&mut two_functions());
    spoil(
        arrays
            .iter_mut()
            .find(|array| array.name == name)
            .expect("an array of that name"),
    );
    let read = read_back(arrays);
    assert_eq!(read.catalog().damage.len(), 1, "{name}");
    read.catalog().damage[0].to_string()
}

#[test]
fn a_transposed_array_is_an_error() {
    let error = spoiled("frf/re", |array| array.shape.reverse());
    assert!(
        error.contains("[3, 2]") && error.contains("[2, lines]"),
        "{error}"
    );
    let error = spoiled("frf/valid_hz", |array| array.shape = vec![1, 4]);
    assert!(
        error.contains("[1, 4]") && error.contains("[2, 2]"),
        "{error}"
    );
}

#[test]
fn impossible_numbers_are_errors() {
    let cases = [
        ("frf/step", -1.0),
        ("frf/step", f64::NAN),
        ("frf/start", f64::INFINITY),
        ("frf/to_si", 0.0),
        ("frf/to_si", f64::INFINITY),
        ("frf/valid_hz", 1.0),
    ];
    for (name, value) in cases {
        let error = spoiled(name, |array| {
            if let Elements::F64(values) = &mut array.elements {
                values[0] = value;
            }
        });
        assert!(error.contains(name), "{name}: {error}");
    }
}

#[test]
fn another_number_of_the_layout_is_an_error() {
    let open = |schema: &str| {
        let (mut arrays, _) = written(&mut two_functions());
        arrays[0].elements = Elements::Text(vec![schema.to_owned()]);
        open_arrays("test", Box::new(Arrays::new(arrays)), &Hints::default())
    };
    let error = open("modalign-frf/2")
        .err()
        .expect("it is refused")
        .to_string();
    assert!(
        error.contains("modalign-frf/2") && error.contains(SCHEMA),
        "{error}"
    );
    assert!(open("another layout").is_ok());
    let long = format!("{SCHEMA}{}", "x".repeat(2000));
    assert!(open(&long).is_ok(), "a long text is not looked at");
}

#[test]
fn functions_are_no_more_than_the_file_can_hold() {
    let read = |file_bytes: u64| {
        let mut source = drawn(1);
        let (mut arrays, _) = written(&mut source);
        let group = arrays
            .iter()
            .find_map(|array| array.name.strip_suffix("/position"));
        let name = format!("{}/position", group.unwrap());
        for array in arrays.iter_mut().filter(|array| array.name == name) {
            array.shape = vec![10_000];
            array.elements = Elements::F64(vec![0.0; 10_000]);
        }
        let mut store = Arrays::new(arrays);
        store.file_bytes = file_bytes;
        let mut source = open_arrays("test", Box::new(store), &Hints::default()).unwrap();
        let damage = source.take_damage().into_iter();
        damage
            .map(|damage| damage.error.to_string())
            .collect::<Vec<_>>()
            .join("\n")
    };
    assert!(read(1_000).contains("1086 or fewer in a file of this size"));
    assert!(!read(1_000_000).contains("in a file of this size"));
}

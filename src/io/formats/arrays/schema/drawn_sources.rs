//! Sources drawn at random for round trips, and their comparison to the bit.

use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::frf::Estimator;
use crate::geometry::{CoordinateSystem, Element, Group, Node, SystemKind, TraceLine};
use crate::io::{
    Block, Domain, Entry, EntryAxis, FunctionType, GeneralAxis, MemorySource, ModeEntry,
    SampleFormat, Source, Window,
};
use crate::linalg::Vector3;
use crate::modal::{Mode, ModeShape, Scaling};
use crate::quantity::Quantity;
use crate::record::Role;

/// A source with everything that one can hold.
pub fn drawn(seed: u64) -> MemorySource {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut source = MemorySource::default();
    for _ in 0..random.random_range(0..9) {
        let (entry, values, abscissa) = function(&mut random);
        source.push(entry, values, abscissa);
    }
    source.catalog.title = some_texts(&mut random);
    source.catalog.modes = (0..random.random_range(0..4))
        .map(|_| mode(&mut random))
        .collect();
    geometry(&mut random, &mut source);
    source
}

fn maybe<T>(random: &mut ChaCha8Rng, draw: impl FnOnce(&mut ChaCha8Rng) -> T) -> Option<T> {
    random.random_bool(0.6).then(|| draw(random))
}

fn word(random: &mut ChaCha8Rng) -> String {
    let words = [
        "",
        "N",
        "(m/s²)/N",
        " padded ",
        "漢字",
        "a\tb",
        "𝄞 clef",
        "1:+Z|2",
    ];
    words[random.random_range(0..words.len())].to_owned()
}

/// Titles and names are trimmed, and not empty.
fn title_line(random: &mut ChaCha8Rng) -> String {
    format!("title {}", random.random_range(0..100))
}

fn some_texts(random: &mut ChaCha8Rng) -> Vec<String> {
    (0..random.random_range(0..3))
        .map(|_| title_line(random))
        .collect()
}

fn dof(random: &mut ChaCha8Rng) -> Dof {
    let names = [
        "1:+Z",
        "12:-X",
        "wing.7:+RY",
        "104:+S",
        "3:+Y#2",
        "a_b.c-1:-Z",
    ];
    names[random.random_range(0..names.len())]
        .parse()
        .expect("what the test drew can be read")
}

fn number(random: &mut ChaCha8Rng) -> f64 {
    let special = [0.0, -0.0, f64::INFINITY, 5e-324, 1e300, -1.0 / 3.0];
    match random.random_range(0..20) {
        place if place < special.len() => special[place],
        _ => random.random_range(-1e3..1e3),
    }
}

fn finite(random: &mut ChaCha8Rng) -> f64 {
    Some(number(random))
        .filter(|value| value.is_finite())
        .unwrap_or(2.5)
}

fn axis(random: &mut ChaCha8Rng, len: usize) -> EntryAxis {
    let (start, step) = (finite(random), [0.1, 0.5][random.random_range(0..2)]);
    match random.random_range(0..4) {
        0 => EntryAxis::Time(TimeAxis {
            start_s: start,
            step_s: step,
            len,
        }),
        1 => EntryAxis::Frequency(FrequencyAxis {
            start_hz: start,
            step_hz: step,
            len,
        }),
        _ => {
            let domains = [Domain::Time, Domain::Frequency, Domain::Other(19)];
            EntryAxis::General(GeneralAxis {
                domain: domains[random.random_range(0..3)],
                even: maybe(random, |random| (finite(random), -step)),
                len,
            })
        }
    }
}

fn function(random: &mut ChaCha8Rng) -> (Entry, Block, Vec<f64>) {
    let codes = [0, 1, 2, 4, 6, 13, 99, -5];
    let types = codes.map(FunctionType::from_code);
    let function_type = match random.random_range(0..9) {
        8 => FunctionType::Variance,
        place => types[place],
    };
    let len = [0, 1, 5, 8][random.random_range(0..4)];
    let (format, values) = values(random, len);
    let mut entry = Entry::new(function_type, axis(random, len), format);
    let abscissa = match entry.axis.even() {
        Some(_) => Vec::new(),
        None => (0..len).map(|_| number(random)).collect(),
    };
    entry.identification.version = random.random_range(-3..1000);
    entry.identification.load_case = random.random_range(-(1 << 50)..1 << 50);
    entry.identification.lines = std::array::from_fn(|_| word(random));
    entry.response = maybe(random, dof);
    entry.reference = maybe(random, dof);
    entry.quantity = maybe(random, |_| Quantity::Acceleration);
    entry.denominator = maybe(random, |_| Quantity::Force);
    entry.to_si = maybe(random, finite).filter(|factor| *factor != 0.0);
    entry.unit_label = word(random);
    entry.axis_label = word(random);
    entry.role = maybe(random, |_| Role::Response);
    entry.note.averages = maybe(random, |random| random.random());
    entry.note.estimator = maybe(random, |_| Estimator::H2);
    entry.note.added_damping_rad_s = maybe(random, number);
    entry.note.record_s = maybe(random, number);
    entry.note.interpolated = random.random();
    entry.note.variance_dof = maybe(random, number);
    entry.note.valid_hz = maybe(random, |random| (number(random), number(random)));
    entry.note.window = maybe(random, |_| Window::FlatTop);
    (entry, values, abscissa)
}

fn values(random: &mut ChaCha8Rng, len: usize) -> (SampleFormat, Block) {
    let single = |random: &mut ChaCha8Rng| match random.random_range(0..9) {
        0 => f32::NAN,
        1 => -0.0,
        _ => random.random_range(-1.0..1.0_f32),
    };
    match random.random_range(0..4) {
        0 => {
            let values = (0..len).map(|_| single(random)).collect();
            (SampleFormat::RealF32, Block::F32(values))
        }
        1 => {
            let values = (0..len).map(|_| number(random)).collect();
            (SampleFormat::RealF64, Block::F64(values))
        }
        2 => {
            let value = |random: &mut ChaCha8Rng| {
                Complex64::new(f64::from(single(random)), f64::from(single(random)))
            };
            let values = (0..len).map(|_| value(random)).collect();
            (SampleFormat::ComplexF32, Block::Complex(values))
        }
        _ => {
            let value = |random: &mut ChaCha8Rng| Complex64::new(number(random), number(random));
            let values = (0..len).map(|_| value(random)).collect();
            (SampleFormat::ComplexF64, Block::Complex(values))
        }
    }
}

fn mode(random: &mut ChaCha8Rng) -> ModeEntry {
    let value = |random: &mut ChaCha8Rng| {
        Complex64::new(
            random.random_range(-1.0..1.0),
            random.random_range(-1.0..1.0),
        )
    };
    let shape: Vec<_> = (0..3).map(|_| (dof(random), value(random))).collect();
    let frequency = random.random_range(1.0..1e3);
    let damping = maybe(random, |random| random.random_range(1e-4..0.2));
    let mut mode = Mode::new(frequency, damping, ModeShape::new(shape), Scaling::UnitMax);
    mode.frequency_std_hz = maybe(random, |random| random.random_range(0.0..1.0));
    mode.residues
        .insert((dof(random), dof(random)), value(random));
    mode.group = maybe(random, |random| random.random_range(0..9));
    ModeEntry {
        title: some_texts(random),
        modal_a: maybe(random, value),
        modal_b: maybe(random, value),
        ..ModeEntry::new(mode)
    }
}

fn geometry(random: &mut ChaCha8Rng, source: &mut MemorySource) {
    let vector = |random: &mut ChaCha8Rng| Vector3::new(number(random), number(random), 0.1);
    let geometry = &mut source.catalog.geometry;
    for point in 0..random.random_range(0..4) {
        let mut node = Node::new(format!("p{point}"), vector(random));
        node.displacement_system = maybe(random, |random| random.random_range(-5..5));
        geometry.nodes.push(node);
    }
    for _ in 0..random.random_range(0..3) {
        let points = (0..random.random_range(0..5)).map(|i| maybe(random, |_| format!("p{i}")));
        let points = points.collect();
        geometry.lines.push(TraceLine {
            name: word(random),
            points,
        });
        let kinds = [
            SystemKind::Cartesian,
            SystemKind::Cylindrical,
            SystemKind::Spherical,
        ];
        geometry.systems.push(CoordinateSystem {
            label: random.random_range(-9..99),
            name: word(random),
            kind: kinds[random.random_range(0..3)],
            origin_m: vector(random),
            axes: std::array::from_fn(|_| vector(random)),
        });
        let points = (0..random.random_range(0..4))
            .map(|i| format!("p{i}"))
            .collect();
        geometry.elements.push(Element {
            label: random.random_range(0..1 << 40),
            descriptor: 44,
            points,
        });
        let members = (0..random.random_range(0..4)).map(|i| (7, i)).collect();
        geometry.groups.push(Group {
            label: 3,
            name: word(random),
            members,
        });
    }
}

/// Bits of all numbers, so that NaN equals itself and 0 is not -0.
fn bits(block: &Block) -> Vec<u64> {
    match block {
        Block::F32(values) => values.iter().map(|v| u64::from(v.to_bits())).collect(),
        Block::F64(values) => values.iter().map(|v| v.to_bits()).collect(),
        Block::Complex(values) => values
            .iter()
            .flat_map(|v| [v.re.to_bits(), v.im.to_bits()])
            .collect(),
    }
}

/// Both sources hold the same, to the bit.
pub fn assert_same(first: &mut dyn Source, other: &mut dyn Source) {
    let damage = (&first.catalog().damage, &other.catalog().damage);
    assert!(damage.0.is_empty() && damage.1.is_empty(), "{damage:?}");
    assert_eq!(first.catalog().title, other.catalog().title);
    assert_eq!(first.catalog().geometry, other.catalog().geometry);
    assert_eq!(first.catalog().modes, other.catalog().modes);
    assert_eq!(first.catalog().entries, other.catalog().entries);
    for entry in 0..first.catalog().entries.len() {
        let len = first.catalog().entries[entry].len();
        let mut blocks = [Block::F64(Vec::new()), Block::F64(Vec::new())];
        let mut abscissae = [Vec::new(), Vec::new()];
        let middle = len / 2;
        for range in [0..len, middle..len] {
            first
                .read(entry, range.clone(), &mut blocks[0])
                .expect("what the test drew can be read");
            other
                .read(entry, range.clone(), &mut blocks[1])
                .expect("what the test drew can be read");
            assert_eq!(bits(&blocks[0]), bits(&blocks[1]));
            let kinds = blocks.each_ref().map(std::mem::discriminant);
            assert_eq!(kinds[0], kinds[1]);
            if len == 0 {
                continue;
            }
            first
                .abscissa(entry, range.clone(), &mut abscissae[0])
                .expect("what the test drew can be read");
            other
                .abscissa(entry, range, &mut abscissae[1])
                .expect("what the test drew can be read");
            let [a, b] = abscissae.each_ref().map(|x| bits(&Block::F64(x.clone())));
            assert_eq!(a, b);
        }
    }
}

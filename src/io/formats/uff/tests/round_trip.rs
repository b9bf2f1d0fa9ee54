//! Written files are read back unchanged: samples to the bit, and every header field that the
//! format holds.

use num_complex::Complex64;
use proptest::prelude::*;

use super::file_builder::{PATH, all, open};
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::frf::{Estimator, FrfSet, Function, FunctionData};
use crate::io::formats::uff::{FileLabel, write_frfs, write_time_records};
use crate::io::{Block, EntryAxis, FunctionType, IoError, Source};
use crate::io::{Encoding, Precision};
use crate::quantity::{FrfKind, Quantity};
use crate::record::{Channel, Hit, Role, Samples};

const LABEL: FileLabel<'_> = FileLabel {
    path: PATH,
    title: "Synthetic beam",
};
const QUANTITIES: [Quantity; 4] = [
    Quantity::Force,
    Quantity::Displacement,
    Quantity::Velocity,
    Quantity::Acceleration,
];

fn written(hits: &[Hit], precision: Precision) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_time_records(&mut bytes, &LABEL, hits, precision).unwrap();
    bytes
}

fn channel(role: Role, dof: &str, quantity: Quantity, samples: Samples) -> Channel {
    Channel {
        role,
        dof: dof.parse().unwrap(),
        quantity,
        to_si: 1.0,
        samples,
    }
}

fn hit(rate_hz: f64, force: Channel, responses: Vec<Channel>) -> Hit {
    Hit {
        axis: TimeAxis {
            start_s: -0.0125,
            step_s: 1.0 / rate_hz,
            len: force.samples.len(),
        },
        force,
        responses,
        origin: String::new(),
    }
}

fn same(block: &Block, samples: &Samples) -> bool {
    match (block, samples) {
        (Block::F32(a), Samples::F32(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        }
        (Block::F64(a), Samples::F64(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
        }
        _ => false,
    }
}

fn check_record(source: &mut dyn Source, index: usize, number: i64, hit: &Hit, channel: &Channel) {
    let entry = source.catalog().entries[index].clone();
    assert_eq!(entry.function_type, FunctionType::Time);
    assert_eq!(
        (entry.identification.version, entry.identification.load_case),
        (number, 1)
    );
    assert_eq!(entry.identification.lines[0], "Synthetic beam");
    assert_eq!(entry.response.as_ref(), Some(&channel.dof));
    let reference = (channel.role == Role::Response).then_some(&hit.force.dof);
    assert_eq!(entry.reference.as_ref(), reference);
    assert_eq!(
        (entry.quantity, entry.denominator),
        (Some(channel.quantity), None)
    );
    assert_eq!(entry.to_si, Some(1.0));
    assert_eq!(entry.unit_label, channel.quantity.si_unit());
    assert_eq!(entry.axis, EntryAxis::Time(hit.axis));
    assert!(same(&all(source, index).unwrap(), &channel.samples));
}

prop_compose! {
    fn any_channel(len: usize, double: bool)(
        node in 1i64..1_000_000,
        direction in prop_oneof![-6i32..=-1, 1i32..=6],
        quantity in 0usize..4,
        values in proptest::collection::vec(any::<f64>().prop_filter("finite", |v| v.is_finite()), len),
        singles in proptest::collection::vec(any::<f32>().prop_filter("finite", |v| v.is_finite()), len),
    ) -> Channel {
        Channel {
            role: Role::Response,
            dof: Dof::from_node(node, direction).unwrap(),
            quantity: QUANTITIES[quantity],
            to_si: 1.0,
            samples: if double { Samples::F64(values) } else { Samples::F32(singles) },
        }
    }
}

prop_compose! {
    fn any_hit(double: bool)(len in 0usize..40)(
        rate_hz in 1u32..500_000,
        mut channels in proptest::collection::vec(any_channel(len, double), 1..5),
    ) -> Hit {
        let mut force = channels.remove(0);
        (force.role, force.quantity) = (Role::Force, Quantity::Force);
        hit(f64::from(rate_hz), force, channels)
    }
}

proptest! {
    #[test]
    fn records_come_back_to_the_bit(
        (double, hits) in any::<bool>().prop_flat_map(|double| {
            (Just(double), proptest::collection::vec(any_hit(double), 1..4))
        }),
    ) {
        let precision = if double { Precision::Double } else { Precision::Single };
        let mut source = open(written(&hits, precision)).unwrap();
        let catalog = source.catalog();
        prop_assert!(catalog.damage.is_empty(), "{:?}", catalog.damage);
        prop_assert_eq!(&catalog.title, &["Synthetic beam"]);
        let mut index = 0;
        for (i, hit) in hits.iter().enumerate() {
            for channel in std::iter::once(&hit.force).chain(&hit.responses) {
                check_record(source.as_mut(), index, i as i64 + 1, hit, channel);
                index += 1;
            }
        }
        prop_assert_eq!(source.catalog().entries.len(), index);
    }
}

#[test]
fn samples_are_written_in_si_units() {
    let mut response = channel(
        Role::Response,
        "bearing:-Z",
        Quantity::Acceleration,
        Samples::F64(vec![2.0, -1.0]),
    );
    response.to_si = 9.80665;
    let force = channel(
        Role::Force,
        "gearbox.4:+X",
        Quantity::Force,
        Samples::F32(vec![1.0, 0.5]),
    );
    let hits = [hit(2048.0, force, vec![response])];
    let mut source = open(written(&hits, Precision::Double)).unwrap();
    assert_eq!(
        all(source.as_mut(), 1).unwrap(),
        Block::F64(vec![19.6133, -9.80665])
    );
    let entry = &source.catalog().entries[1];
    assert_eq!(entry.response.as_ref().unwrap().to_string(), "bearing:-Z");
    assert_eq!(
        entry.reference.as_ref().unwrap().to_string(),
        "gearbox.4:+X"
    );
    let mut source = open(written(&hits, Precision::Single)).unwrap();
    assert_eq!(
        all(source.as_mut(), 1).unwrap(),
        Block::F32(vec![19.6133, -9.80665])
    );
}

#[test]
fn the_layout_is_the_one_of_a_measurement_system() {
    let force = channel(
        Role::Force,
        "4:-X",
        Quantity::Force,
        Samples::F32(vec![1.0]),
    );
    let response = channel(
        Role::Response,
        "12:+Z",
        Quantity::Velocity,
        Samples::F32(vec![2.0]),
    );
    let bytes = written(&[hit(51_200.0, force, vec![response])], Precision::Single);
    let text = String::from_utf8_lossy(&bytes);
    let first = text.find("    58b").unwrap();
    let second = first + 1 + text[first + 1..].find("    58b").unwrap();
    let expected = [
        "    58b     1     2          11           4     0     0           0           0",
        "Synthetic beam",
        "hit 1",
        "NONE",
        "NONE",
        "NONE",
        "    1         0    1         1 NONE              12   3 NONE               4  -1",
        "         2         1         1 -1.25000E-02 1.953125E-05 0.000000E+00",
        "        17    0    0    0 Time                 s                   ",
        "        11    0    0    0 Velocity             m/s                 ",
        "         0    0    0    0 NONE                 NONE                ",
        "         0    0    0    0 NONE                 NONE                ",
    ];
    for (got, expected) in text[second..].lines().zip(expected) {
        assert_eq!(got, expected);
    }
    assert!(text[first..second].contains("NONE               4  -1 NONE               0   0\n"));
    assert!(bytes.ends_with(&[&2.0_f32.to_le_bytes()[..], b"    -1\n"].concat()));
}

#[test]
fn unwritable_sets_are_refused_before_the_first_byte() {
    let single = |dof: &str, values: Vec<f64>| {
        channel(Role::Force, dof, Quantity::Force, Samples::F64(values))
    };
    let good = hit(100.0, single("1:+Z", vec![1.0]), vec![]);
    let mut short = good.clone();
    short.axis.len = 2;
    let mut still = good.clone();
    still.axis.step_s = 0.0;
    let unnamed = hit(100.0, single("a-long-bearing:+Z", vec![1.0]), vec![]);
    for (hit, name) in [
        (short, "samples"),
        (still, "axis"),
        (unnamed, "a-long-bearing:+Z"),
    ] {
        let mut bytes = Vec::new();
        let error = write_time_records(&mut bytes, &LABEL, &[hit], Precision::Single).unwrap_err();
        assert!(
            error.to_string().contains(name) && bytes.is_empty(),
            "{error}"
        );
    }
    let loud = hit(100.0, single("1:+Z", vec![1e39]), vec![]);
    let error =
        write_time_records(&mut Vec::new(), &LABEL, &[loud], Precision::Single).unwrap_err();
    assert!(matches!(error, IoError::Unwritable { what: "sample", .. }));
}

fn frf_set(values: Vec<Complex64>, coherence: Option<Vec<f64>>) -> FrfSet {
    let axis = FrequencyAxis {
        start_hz: 12.5,
        step_hz: 0.1953125,
        len: values.len(),
    };
    let mut set = FrfSet::new(axis);
    let function = |response: &str, kind, averages| Function {
        response: response.parse().unwrap(),
        reference: "4:+X".parse().unwrap(),
        kind,
        averages,
        estimator: averages.map(|_| Estimator::Hv),
        variance_dof: None,
    };
    let data = |coherence| FunctionData {
        values: values.clone(),
        coherence,
        variance: None,
    };
    set.push(
        function("12:-Z", FrfKind::Accelerance, Some(5)),
        data(coherence),
    )
    .unwrap();
    set.push(function("bearing:+RY", FrfKind::Mobility, None), data(None))
        .unwrap();
    set.push(
        function("gearbox.7:+Y", FrfKind::Receptance, None),
        data(None),
    )
    .unwrap();
    set
}

fn check_functions(source: &dyn Source) {
    let entries = &source.catalog().entries;
    let dofs = ["12:-Z", "bearing:+RY", "gearbox.7:+Y", "12:-Z"];
    let quantities = [
        Some(Quantity::Acceleration),
        Some(Quantity::Velocity),
        Some(Quantity::Displacement),
        None,
    ];
    let labels = ["(m/s2)/N", "(m/s)/N", "m/N", ""];
    for (i, entry) in entries.iter().enumerate() {
        let frf = i < 3;
        let function_type = if frf {
            FunctionType::Frf
        } else {
            FunctionType::Coherence
        };
        assert_eq!(entry.function_type, function_type);
        assert_eq!(entry.response.as_ref().unwrap().to_string(), dofs[i]);
        assert_eq!(entry.reference.as_ref().unwrap().to_string(), "4:+X");
        assert_eq!(entry.quantity, quantities[i]);
        assert_eq!(entry.denominator, frf.then_some(Quantity::Force));
        assert_eq!(
            (entry.to_si, entry.unit_label.as_str()),
            (Some(1.0), labels[i])
        );
        let EntryAxis::Frequency(axis) = entry.axis else {
            panic!("{:?}", entry.axis)
        };
        assert_eq!((axis.start_hz, axis.step_hz), (12.5, 0.1953125));
    }
    assert_eq!(entries.len(), 4);
}

#[test]
fn functions_keep_window_duration_and_quality() {
    let mut set = frf_set(vec![Complex64::new(1.0, 2.0)], Some(vec![0.75]));
    set.added_damping_rad_s = 12.5;
    set.record_duration_s = Some(1.28);
    for encoding in [Encoding::Binary, Encoding::Text] {
        let mut bytes = Vec::new();
        write_frfs(&mut bytes, &LABEL, &set, encoding).unwrap();
        let source = open(bytes).unwrap();
        check_functions(source.as_ref());
        let fourth = |i: usize| source.catalog().entries[i].identification.lines[3].clone();
        assert_eq!(
            fourth(0),
            "modalign averages=5 estimator=hv added_damping_rad_s=12.5 record_s=1.28"
        );
        assert_eq!(fourth(1), "modalign added_damping_rad_s=12.5 record_s=1.28");
        assert_eq!(fourth(3), fourth(0), "the coherence says the same");
    }
    let mut bytes = Vec::new();
    set.added_damping_rad_s = 0.0;
    set.record_duration_s = None;
    write_frfs(&mut bytes, &LABEL, &set, Encoding::Binary).unwrap();
    assert_eq!(
        open(bytes).unwrap().catalog().entries[1]
            .identification
            .lines[3],
        ""
    );
}

proptest! {
    #[test]
    fn functions_come_back(
        parts in proptest::collection::vec((-1e300..1e300_f64, any::<f64>()), 1..30),
        text: bool,
    ) {
        let values: Vec<Complex64> = parts
            .iter()
            .map(|(re, im)| Complex64::new(*re, if im.is_finite() { *im } else { 0.0 }))
            .collect();
        let coherence: Vec<f64> = values.iter().map(|h| h.re.abs() / 1e300).collect();
        let set = frf_set(values.clone(), Some(coherence.clone()));
        let encoding = if text { Encoding::Text } else { Encoding::Binary };
        let mut bytes = Vec::new();
        write_frfs(&mut bytes, &LABEL, &set, encoding).unwrap();
        let mut source = open(bytes).unwrap();
        prop_assert!(source.catalog().damage.is_empty());
        check_functions(source.as_ref());
        // Text has 13 digits, so that it is off by half a unit of the last one at most; subnormal
        // numbers by their step.
        let near = |a: f64, b: f64| match encoding {
            Encoding::Binary => a.to_bits() == b.to_bits(),
            Encoding::Text => (a - b).abs() <= 5.001e-13 * b.abs() + 5e-324,
        };
        for i in 0..3 {
            let Block::Complex(got) = all(source.as_mut(), i).unwrap() else {
                return Err(TestCaseError::fail("complex"));
            };
            prop_assert_eq!(got.len(), values.len());
            for (a, b) in got.iter().zip(&values) {
                prop_assert!(near(a.re, b.re) && near(a.im, b.im), "{a} {b}");
            }
        }
        let Block::F64(got) = all(source.as_mut(), 3).unwrap() else {
            return Err(TestCaseError::fail("real"));
        };
        prop_assert!(got.len() == coherence.len() && got.iter().zip(&coherence).all(|(a, b)| near(*a, *b)));
    }
}

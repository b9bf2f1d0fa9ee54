//! Every layout that must be read, built from bytes.

use num_complex::Complex64;

use super::file_builder::{
    Form, PATH, all, binary_58, dataset, doubles, header, open, singles, text_58,
};
use crate::finding::{Code, Location, Severity};
use crate::io::{Block, Confidence, EntryAxis, Format, FunctionType, SampleFormat, Uff};
use crate::quantity::Quantity;

fn codes(source: &dyn crate::io::Source) -> Vec<Code> {
    source.catalog().findings.iter().map(|f| f.code).collect()
}

#[test]
fn a_header_gives_its_fields() {
    let source = open(text_58(&header(2, 2), &["  1.0  2.0"], "\n")).unwrap();
    let entry = &source.catalog().entries[0];
    assert_eq!(entry.function_type, FunctionType::Time);
    assert_eq!(entry.identification.version, 3);
    assert_eq!(entry.identification.load_case, 7);
    assert_eq!(entry.identification.lines, ["title", "", "", "", ""]);
    assert_eq!(entry.response.as_ref().unwrap().to_string(), "12:-Z");
    assert_eq!(entry.reference.as_ref().unwrap().to_string(), "4:+X");
    assert_eq!(entry.quantity, Some(Quantity::Acceleration));
    assert_eq!(entry.denominator, None);
    assert_eq!(
        entry.to_si.map(f64::to_bits),
        Some(9.80665_f64.to_bits()),
        "g in m/s2"
    );
    assert_eq!(entry.unit_label, "g");
    assert_eq!((entry.line, entry.byte), (Some(2), Some(7)));
    assert_eq!(entry.format, SampleFormat::RealF64);
    let EntryAxis::Time(axis) = entry.axis else {
        panic!("{:?}", entry.axis)
    };
    assert_eq!(axis.sampling_rate_hz().to_bits(), 51_200_f64.to_bits());
    assert_eq!((axis.start_s.to_bits(), axis.len), (0, 2));
    let rounded = &source.catalog().findings[0];
    assert_eq!(
        (rounded.code, rounded.severity),
        (Code::SpacingRounded, Severity::Info)
    );
    assert_eq!(rounded.value.map(f64::to_bits), Some(51_200_f64.to_bits()));
}

#[test]
fn binary_blocks_are_read_in_every_form() {
    let values = [1.5_f32, -2.25, f32::MIN_POSITIVE, 3.0e38];
    for newline in ["\n", "\r\n"] {
        for newline_behind_block in [false, true] {
            for little_endian in [true, false] {
                let form = Form {
                    newline,
                    newline_behind_block,
                    little_endian,
                    count_error: 0,
                };
                let block = singles(&values, little_endian);
                let mut file = binary_58(&header(2, 4), &block, form);
                file.extend(binary_58(&header(2, 4), &block, form));
                let mut source = open(file).unwrap();
                assert_eq!(source.catalog().damage.len(), 0, "{form:?}");
                assert_eq!(codes(source.as_ref()), [Code::SpacingRounded]);
                for entry in 0..2 {
                    let got = all(source.as_mut(), entry).unwrap();
                    assert_eq!(got, Block::F32(values.to_vec()), "{form:?}");
                }
            }
        }
    }
}

#[test]
fn every_data_type_has_its_block() {
    let numbers = [1.5, -2.25, 4.0, 8.5];
    let narrow = [1.5_f32, -2.25, 4.0, 8.5];
    let complex = vec![Complex64::new(1.5, -2.25), Complex64::new(4.0, 8.5)];
    for little in [true, false] {
        let form = Form {
            little_endian: little,
            ..Form::default()
        };
        for (data_type, points, block, format, expected) in [
            (
                4,
                4,
                doubles(&numbers, little),
                SampleFormat::RealF64,
                Block::F64(numbers.to_vec()),
            ),
            (
                5,
                2,
                singles(&narrow, little),
                SampleFormat::ComplexF32,
                Block::Complex(complex.clone()),
            ),
            (
                6,
                2,
                doubles(&numbers, little),
                SampleFormat::ComplexF64,
                Block::Complex(complex.clone()),
            ),
        ] {
            let mut source = open(binary_58(&header(data_type, points), &block, form)).unwrap();
            assert_eq!(source.catalog().entries[0].format, format);
            assert_eq!(all(source.as_mut(), 0).unwrap(), expected);
        }
    }
}

#[test]
fn part_of_an_entry_is_read_alone() {
    let values: Vec<f64> = (0..300_000).map(f64::from).collect();
    let mut source = open(binary_58(
        &header(4, 300_000),
        &doubles(&values, true),
        Form::default(),
    ))
    .unwrap();
    let mut block = Block::F32(vec![]);
    for range in [0..1, 131_071..262_145, 299_999..300_000, 5..5] {
        source.read(0, range.clone(), &mut block).unwrap();
        assert_eq!(block, Block::F64(values[range].to_vec()));
    }
    let mut source = open(text_58(&header(6, 2), &["1 2 3 4"], "\n")).unwrap();
    source.read(0, 1..2, &mut block).unwrap();
    assert_eq!(block, Block::Complex(vec![Complex64::new(3.0, 4.0)]));
    for (entry, range) in [(0, 1..3), (1, 0..0), (0, 2..3)] {
        assert!(source.read(entry, range, &mut block).is_err());
    }
}

#[test]
fn text_blocks_are_read_in_every_form() {
    for (rows, expected) in [
        (vec!["  1.0  2.0  3.0", "  4.0"], [1.0, 2.0, 3.0, 4.0]),
        (
            vec!["-1.00000E-005-2.00000E-005", " 3.0D+00", "4"],
            [-1e-5, -2e-5, 3.0, 4.0],
        ),
        (
            vec!["1.0 2.0 3.0 4.0 0.0 0.0        "],
            [1.0, 2.0, 3.0, 4.0],
        ),
        (vec!["1.0 2.0", "", "3.0 4.0", "   "], [1.0, 2.0, 3.0, 4.0]),
    ] {
        for newline in ["\n", "\r\n"] {
            let mut source = open(text_58(&header(2, 4), &rows, newline)).unwrap();
            assert_eq!(
                all(source.as_mut(), 0).unwrap(),
                Block::F64(expected.to_vec()),
                "{rows:?}"
            );
        }
    }
}

#[test]
fn the_number_of_points_beats_a_wrong_byte_count() {
    let block = singles(&[1.0, 2.0, 3.0, 4.0], true);
    for count_error in [-16, -8, 4, 16, 1_000_000] {
        let form = Form {
            count_error,
            ..Form::default()
        };
        let mut file = binary_58(&header(2, 4), &block, form);
        file.extend(binary_58(&header(2, 4), &block, Form::default()));
        let mut source = open(file).unwrap();
        assert_eq!(source.catalog().damage.len(), 0, "{count_error}");
        assert_eq!(
            all(source.as_mut(), 1).unwrap(),
            Block::F32(vec![1.0, 2.0, 3.0, 4.0])
        );
        let findings = &source.catalog().findings;
        assert_eq!(findings.len(), 2, "{findings:?}");
        assert_eq!(findings[0].code, Code::ByteCountWrong);
        assert_eq!(findings[0].value, Some((16 + count_error) as f64));
        assert_eq!(findings[0].limit, Some(16.0));
    }
}

#[test]
fn delimiters_inside_texts_and_blocks_are_no_delimiters() {
    let mut head = header(2, 8);
    head[1] = "    -1".to_owned();
    head[3] = "-1".to_owned();
    let block = b"\n    -1\n    58\n    -1\n  -1\n  -1\n";
    assert_eq!(block.len(), 32);
    let mut file = binary_58(&head, block, Form::default());
    file.extend(text_58(&header(2, 1), &["1.0"], "\n"));
    let mut source = open(file).unwrap();
    assert_eq!(source.catalog().damage.len(), 0);
    assert_eq!(source.catalog().entries.len(), 2);
    assert_eq!(source.catalog().entries[0].identification.lines[1], "-1");
    let Block::F32(values) = all(source.as_mut(), 0).unwrap() else {
        panic!("single precision")
    };
    assert_eq!(singles(&values, true), block);
    assert_eq!(all(source.as_mut(), 1).unwrap(), Block::F64(vec![1.0]));
}

#[test]
fn latin_1_units_are_read_and_reported_once() {
    let mut head = header(2, 1);
    head[8] = "        12    0    0    0 Acceleration         m/s@                ".to_owned();
    let mut file = text_58(&head, &["1.0"], "\n");
    file.extend(text_58(&head, &["1.0"], "\n"));
    for byte in file.iter_mut().filter(|byte| **byte == b'@') {
        *byte = 0xB2;
    }
    let source = open(file).unwrap();
    for entry in &source.catalog().entries {
        assert_eq!(entry.unit_label, "m/s²");
        assert_eq!(entry.to_si, Some(1.0));
    }
    let reported = codes(source.as_ref());
    assert_eq!(reported, [Code::HeaderNotUtf8, Code::SpacingRounded]);
    let location = Location::File {
        path: PATH.to_owned(),
        line: Some(11),
        byte: None,
    };
    assert_eq!(source.catalog().findings[0].location, location);
}

#[test]
fn units_come_from_the_label_or_else_from_dataset_164() {
    let foot = [
        "   164",
        "         2Foot (pound f)               2",
        "  3.28083989501312334D+00  2.24808943099710480D-01  1.79999999999999999D+00",
        "  4.59670000000000002D+02",
    ];
    let acceleration =
        |unit: &str| format!("        12    0    0    0 Acceleration         {unit:<20}");
    let reaction =
        |unit: &str| format!("         9    0    0    0 Force                {unit:<20}");
    let force = |unit: &str| format!("        13    0    0    0 Force                {unit:<20}");
    let general = |unit: &str| format!("         1    0    0    0 Whatever             {unit:<20}");
    for (ordinate, with_164, quantity, to_si) in [
        (
            acceleration("NONE"),
            true,
            Some(Quantity::Acceleration),
            Some(0.3048),
        ),
        (
            acceleration("mm/s2"),
            true,
            Some(Quantity::Acceleration),
            Some(1e-3),
        ),
        (
            force(""),
            true,
            Some(Quantity::Force),
            Some(4.448_221_615_260_5),
        ),
        (
            acceleration("NONE"),
            false,
            Some(Quantity::Acceleration),
            None,
        ),
        (
            acceleration("furlong"),
            true,
            Some(Quantity::Acceleration),
            None,
        ),
        (acceleration("N"), true, Some(Quantity::Acceleration), None),
        (reaction("kN"), false, Some(Quantity::Force), Some(1e3)),
        (general("kN"), false, Some(Quantity::Force), Some(1e3)),
        (general("NONE"), true, None, None),
    ] {
        let mut head = header(2, 1);
        head[8].clone_from(&ordinate);
        let mut file = text_58(&head, &["1.0"], "\n");
        if with_164 {
            file.extend(dataset(&foot, "\n"));
        }
        let source = open(file).unwrap();
        let entry = &source.catalog().entries[0];
        assert_eq!(entry.quantity, quantity, "{ordinate}");
        match (entry.to_si, to_si) {
            (Some(got), Some(want)) => {
                assert!((got / want - 1.0_f64).abs() < 1e-14, "{ordinate} {got}");
            }
            (got, want) => assert_eq!(got, want, "{ordinate}"),
        }
    }
}

#[test]
fn an_frf_has_a_unit_over_a_unit() {
    let side = |code: i32, unit: &str| {
        format!("{code:>10}    0    0    0 Label                {unit:<20}")
    };
    for (above, below, quantity, denominator, to_si) in [
        (
            side(12, "g"),
            side(13, "kN"),
            Some(Quantity::Acceleration),
            Some(Quantity::Force),
            Some(9.80665e-3),
        ),
        (
            side(8, "(mm)/N"),
            side(13, "NONE"),
            Some(Quantity::Displacement),
            Some(Quantity::Force),
            Some(1e-3),
        ),
        (
            side(0, "(m/s2)/N"),
            side(0, ""),
            Some(Quantity::Acceleration),
            Some(Quantity::Force),
            Some(1.0),
        ),
        (
            side(8, "(m/s2)/N"),
            side(13, ""),
            Some(Quantity::Displacement),
            Some(Quantity::Force),
            None,
        ),
        (
            side(12, "m/s2"),
            side(0, ""),
            Some(Quantity::Acceleration),
            None,
            None,
        ),
        (
            side(12, "m/s2"),
            side(13, "V"),
            Some(Quantity::Acceleration),
            Some(Quantity::Force),
            None,
        ),
    ] {
        let mut head = header(6, 1);
        head[5] = head[5].replacen("    1", "    4", 1);
        head[7] = side(18, "Hz");
        (head[8], head[9]) = (above.clone(), below);
        let source = open(text_58(&head, &["1.0 2.0"], "\n")).unwrap();
        let entry = &source.catalog().entries[0];
        assert_eq!(entry.function_type, FunctionType::Frf);
        assert_eq!(
            (entry.quantity, entry.denominator),
            (quantity, denominator),
            "{above}"
        );
        assert_eq!(
            entry.to_si.map(|v| (v * 1e12).round()),
            to_si.map(|v: f64| (v * 1e12).round())
        );
        let EntryAxis::Frequency(axis) = entry.axis else {
            panic!("{:?}", entry.axis)
        };
        assert_eq!(
            axis.step_hz.to_bits(),
            1.95313e-5_f64.to_bits(),
            "no rate is restored"
        );
    }
}

#[test]
fn nodes_trace_lines_and_title_are_read() {
    let millimetre = ["   164", "         5MM", "1.0D+03 1.0D+00 1.0D+00", "0.0"];
    let nodes = [
        "    15",
        "         7         1         0         1 -1.25000E+01  1.25000E+01  8.00000E+01",
        "         8         0         0         1-1.250000E+01-1.250000E+01-8.000000E+01",
    ];
    let double = [
        "  2411",
        "         9         1         0        11",
        "   1.0000000000000000D+02   -3.750000000000001e-002   0.0000000000000000D+00",
        "         7         1         0         1",
        " -12.5 12.5 80.0",
    ];
    let trace = [
        "    82",
        "         1         5         8",
        "Frame",
        "         7         8         0         9         7         0         0         0",
    ];
    let mut file = dataset(&nodes, "\r\n");
    file.extend(dataset(&double, "\n"));
    file.extend(dataset(&millimetre, "\n"));
    file.extend(dataset(&trace, "\n"));
    file.extend(dataset(
        &["   151", "Machine", "NONE", "", " -1 of 2 "],
        "\n",
    ));
    file.extend(dataset(&["  2415", "anything"], "\n"));
    file.extend(dataset(&["  2415", "anything"], "\n"));
    let source = open(file).unwrap();
    let catalog = source.catalog();
    assert_eq!(catalog.damage.len(), 0, "{:?}", catalog.damage);
    let points: Vec<&str> = catalog
        .geometry
        .nodes
        .iter()
        .map(|n| n.point.as_str())
        .collect();
    assert_eq!(points, ["7", "8", "9"]);
    let at = catalog.geometry.node("8").unwrap().at_m;
    assert!(
        (at.x + 0.0125).abs() < 1e-15 && (at.z + 0.08).abs() < 1e-15,
        "{at}"
    );
    let at = catalog.geometry.node("9").unwrap().at_m;
    assert!((at.y + 3.750_000_000_000_001e-5).abs() < 1e-18, "{at}");
    let line = &catalog.geometry.lines[0];
    let drawn: Vec<&str> = line
        .points
        .iter()
        .map(|p| p.as_deref().unwrap_or("-"))
        .collect();
    assert_eq!(
        (line.name.as_str(), drawn),
        ("Frame", vec!["7", "8", "-", "9", "7"])
    );
    assert_eq!(catalog.title, ["Machine", "-1 of 2"]);
    let unknown = &catalog.findings[0];
    assert_eq!(
        (unknown.code, unknown.value),
        (Code::UnknownDataset, Some(2415.0))
    );
    assert_eq!(catalog.findings.len(), 1, "each number is reported once");
}

#[test]
fn only_universal_files_are_taken() {
    for head in [
        "    -1\n    58\n",
        "\r\n    -1   \r\n   151  \r\n",
        "-1\n58b 1 2 11 4\nx",
    ] {
        assert_eq!(Uff.detect(head.as_bytes()), Confidence::Certain, "{head}");
    }
    for head in [
        "",
        "    -1\n",
        "-1\n-2\n",
        "1 2 3\n",
        "time,force\n-1,58\n",
        "-1.0\n58\n",
    ] {
        assert_eq!(Uff.detect(head.as_bytes()), Confidence::No, "{head}");
    }
}

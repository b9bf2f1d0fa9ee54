//! PULSE and SignalCalc exports, from text made here.

use num_complex::Complex64;

use crate::frf::Estimator;
use crate::io::*;
use crate::quantity::Quantity;

/// A PULSE export of this unit with these keys replaced and these lines behind the header.
fn pulse(unit: &str, size: usize, replaced: &[(&str, &str)], body: &str) -> Vec<u8> {
    let mut text = format!(
        "Header Size:\t 12\t \t \r\nPulse Version:\t 80\t \t \r\nDecimal Symbol:\t.\t \t \r\nData Type:\tComplex\t \t \r\n\
         X-Axis type:\tLinear\t \t \r\nX-Axis size:\t{size}\t \t \r\nX-Axis unit:\tHz\t \t \r\n\
         X-Axis first value:\t 1.0000000000e+001\t \t \r\nX-Axis delta:\t 1.2500000000e-001\t \t \r\n\t \t \t \r\n\
         AmplitudeUnit:\t{unit}\t \t \r\nFunction:\tFrequency Response\t \t \r\nRecordLength:\t 8.0\t \t \r\n\
         Ref_Signal:\t3-X\t \t \r\nSignal:\tAcc 7\t \t \r\nTitle:\tFrequency Response H1(Acc 7,3-X) - Input\t \t \r\n\
         Z-index:\t \t1\t \r\nDate:\t \t01/02/2020\t \r\nTime:\t \t10:00:00:000\t \r\n{body}"
    );
    for (from, to) in replaced {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect()
}

const ROWS: &str = "1\t 1.0000000000e+001\t 1.50000e+000\t-2.50000e-001\r\n2\t 1.0125000000e+001\t 2.50000e+000\t-3.50000e-001\r\n\
                    3\t 1.0250000000e+001\t 3.50000e+000\t 4.50000e-001\r\n";
const TAGS: &str =
    "TagsBegin:\t \t \t \r\nAverageNumber: []\t \t 6.00000e+000\t \r\nTagsEnd:\t \t \t \r\n";

fn opened(bytes: Vec<u8>) -> Result<Box<dyn Source>, IoError> {
    let hints = Hints {
        path: "e.txt".to_owned(),
        table: None,
    };
    open_bytes(bytes, &hints)
}

pub(super) fn whole(source: &mut dyn Source, entry: usize) -> Block {
    let mut block = Block::F64(Vec::new());
    let len = source.catalog().entries[entry].len();
    source.read(entry, 0..len, &mut block).unwrap();
    block
}

pub(super) fn complex(source: &mut dyn Source, entry: usize) -> Vec<Complex64> {
    match whole(source, entry) {
        Block::Complex(values) => values,
        other => panic!("{other:?}"),
    }
}

fn even(source: &dyn Source, entry: usize) -> (f64, f64) {
    source.catalog().entries[entry].axis.even().unwrap()
}

#[test]
fn a_pulse_export_states_function_dofs_and_units() {
    let body = format!("{ROWS}{TAGS}");
    let mut source = opened(pulse("(m/s²)/N", 3, &[], &body)).unwrap();
    assert_eq!(source.catalog().format, "pulse");
    assert!(source.catalog().damage.is_empty());
    let entry = source.catalog().entries[0].clone();
    assert_eq!(entry.function_type, FunctionType::Frf);
    assert_eq!(entry.quantity, Some(Quantity::Acceleration));
    assert_eq!(entry.denominator, Some(Quantity::Force));
    assert_eq!(
        (entry.to_si, entry.unit_label.as_str()),
        (Some(1.0), "(m/s²)/N")
    );
    assert_eq!(entry.response, None);
    assert_eq!(entry.reference.unwrap().to_string(), "3:-X");
    assert_eq!(entry.identification.lines[1], "Acc 7 | 3-X");
    assert_eq!(entry.identification.lines[2], "01/02/2020 10:00:00:000");
    assert_eq!(entry.note.averages, Some(6));
    assert_eq!(entry.note.estimator, Some(Estimator::H1));
    assert_eq!(entry.note.record_s, Some(8.0));
    assert_eq!(even(source.as_ref(), 0), (10.0, 0.125));
    let values = complex(source.as_mut(), 0);
    assert_eq!(values[2], Complex64::new(3.5, 0.45));
    // A unit over volts is a text.
    let source = opened(pulse("V/N", 3, &[], &body)).unwrap();
    let entry = &source.catalog().entries[0];
    assert_eq!((entry.to_si, entry.quantity), (None, None));
    assert_eq!(entry.unit_label, "V/N");
}

#[test]
fn a_pulse_export_may_have_decimal_commas_real_values_and_slices() {
    let rows = ROWS.replace('.', ",");
    let comma = [
        ("Decimal Symbol:\t.", "Decimal Symbol:\t,"),
        ("1.25", "1,25"),
        ("1.00", "1,00"),
        ("8.0", "8,0"),
    ];
    let mut source = opened(pulse("g/kN", 3, &comma, &rows)).unwrap();
    assert_eq!(even(source.as_ref(), 0), (10.0, 0.125));
    assert_eq!(complex(source.as_mut(), 0)[0], Complex64::new(1.5, -0.25));
    let real = [("Complex", "Real"), ("Frequency Response\t", "Coherence\t")];
    let slice = "1\t10.0\t0.5\r\n2\t10.125\t0.75\r\n";
    let body = format!("{slice}Z-index:\t\t2\t\r\nTime:\t\t11:00\t\r\n{slice}{TAGS}");
    let mut source = opened(pulse("", 2, &real, &body)).unwrap();
    assert_eq!(source.catalog().entries.len(), 2);
    assert!(
        source.catalog().damage.is_empty(),
        "{:?}",
        source.catalog().damage
    );
    let entry = &source.catalog().entries[1];
    assert_eq!(
        (entry.function_type, entry.to_si),
        (FunctionType::Coherence, Some(1.0))
    );
    assert_eq!(entry.identification.version, 2);
    assert_eq!(whole(source.as_mut(), 1), Block::F64(vec![0.5, 0.75]));
}

#[test]
fn a_damaged_pulse_export_keeps_its_good_rows() {
    for (body, size, rows, message) in [
        (
            ROWS.to_owned(),
            4,
            3,
            "e.txt:22: rows of numbers: got \"3 rows\", expected 4 (X-Axis size)",
        ),
        (
            ROWS.replace("3.50000e+000", "3.x"),
            3,
            2,
            "e.txt:22: number: got \"3.x\"",
        ),
        (
            ROWS[..ROWS.len() - 16].to_owned(),
            3,
            2,
            "e.txt:22: number: got \"3 columns\"",
        ),
        (
            ROWS.replace("1.0250000000e+001", "1.0950000000e+001"),
            3,
            3,
            "e.txt:22: abscissa: got \"10.95\", expected 10.25",
        ),
    ] {
        let source = opened(pulse("m/N", size, &[], &body)).unwrap();
        let catalog = source.catalog();
        assert_eq!(catalog.entries[0].len(), rows);
        assert!(
            catalog.damage[0].to_string().starts_with(message),
            "{}",
            catalog.damage[0]
        );
        assert_eq!(catalog.findings.len(), 1);
    }
    let error = opened(pulse("m/N", 3, &[], "")).err().unwrap().to_string();
    assert!(error.contains("numbers of a PULSE export: got \"none\", expected rows of 4 numbers"));
}

#[test]
fn a_lost_doubled_or_swapped_row_of_a_pulse_export_ends_the_slice() {
    let rows: Vec<&str> = ROWS.lines().collect();
    for (order, good, got) in [
        (&[0, 2][..], 1, "\"3\", expected 2"),
        (&[0, 1, 1, 2], 2, "\"2\", expected 3"),
        (&[0, 2, 1], 1, "\"3\", expected 2"),
    ] {
        let body: Vec<&str> = order.iter().map(|row| rows[*row].trim_start()).collect();
        let source = opened(pulse("m/N", 3, &[], &(body.join("\r\n") + "\r\n"))).unwrap();
        let catalog = source.catalog();
        assert_eq!((catalog.entries.len(), catalog.entries[0].len()), (1, good));
        let message = format!("e.txt:{}: index of a row: got {got}", 20 + good);
        assert_eq!(catalog.damage.len(), 1);
        assert_eq!(catalog.damage[0].to_string(), message);
    }
}

#[test]
fn as_many_slices_as_are_read_are_no_damage() {
    let real = [("Complex", "Real"), ("Linear", "Logarithmic")];
    let slices = |count: usize| {
        let body = "Z-index:\t\t2\t\r\n1\t10.0\t0.5\r\n".repeat(count);
        opened(pulse("", 1, &real, &body)).unwrap()
    };
    assert!(slices(10_000).catalog().damage.is_empty());
    let more = slices(10_001);
    assert_eq!(more.catalog().entries.len(), 10_000);
    assert_eq!(more.catalog().damage.len(), 1);
}

#[test]
fn exports_are_known_in_every_encoding() {
    let two = "0.0\t0.5\t0.25\r\n0.5\t0.75\t0.125\r\n";
    let words = "Frequency\t Real\t Imaginary";
    for (format, bytes) in [
        ("pulse", pulse("m/N", 3, &[], ROWS)),
        (
            "signalcalc",
            signalcalc("Ratio", "3+Z:12-X", words, "Hz\t(m)(N)", two),
        ),
    ] {
        let text = String::from_utf8(bytes).unwrap();
        let marked = [&[0xef, 0xbb, 0xbf], text.as_bytes()].concat();
        let wide = format!("\u{feff}{text}")
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        let mac = text.replace("\r\n", "\r").into_bytes();
        for bytes in [marked, wide, mac] {
            let source = opened(bytes).unwrap();
            assert_eq!(source.catalog().format, format);
            assert!(
                source.catalog().damage.is_empty(),
                "{:?}",
                source.catalog().damage
            );
            assert_eq!(source.catalog().entries.len(), 1);
        }
    }
}

#[test]
fn an_uneven_abscissa_is_kept_and_reported() {
    let rows = "100\t0.5\t0\r\n101.3\t1\t0\r\n102.1\t1\t0\r\n103.4\t1\t0\r\n104\t1\t0\r\n";
    let words = "Frequency\t Real\t Imaginary";
    let source = opened(signalcalc("Ratio", "3+Z:12-X", words, "Hz\t(m)(N)", rows)).unwrap();
    let catalog = source.catalog();
    assert_eq!(catalog.entries[0].axis.even(), None);
    assert_eq!(catalog.findings.len(), 1);
    assert_eq!(catalog.findings[0].code, crate::finding::Code::UnevenAxis);
}

/// A SignalCalc export with these words, units and rows.
fn signalcalc(kind: &str, channels: &str, words: &str, units: &str, rows: &str) -> Vec<u8> {
    let text = format!(
        "Units: {kind}\r\nRef Chan:Resp Chan\t{channels}\r\nChannel Name\t : \r\nChannel Comment\tbar : tip\r\n\r\n\
         {words}\r\n\r\nUnits:\r\n{units}\t \r\n{rows}"
    );
    text.chars()
        .map(|c| u8::try_from(u32::from(c)).unwrap())
        .collect()
}

#[test]
fn a_signalcalc_export_states_function_dofs_and_units() {
    let rows = "0.000e+000\t  -0.5\t  0\r\n2.500e-001\t 1.5\t-0.25\r\n5.000e-001\t 2.5\t 0.75\r\n";
    let bytes = signalcalc(
        "Ratio",
        "3+Z:12-X",
        "Frequency\t Real\t Imaginary",
        "Hz\t(m/s²)(N)",
        rows,
    );
    let mut source = opened(bytes).unwrap();
    assert_eq!(source.catalog().format, "signalcalc");
    assert!(source.catalog().damage.is_empty());
    let entry = source.catalog().entries[0].clone();
    assert_eq!(entry.function_type, FunctionType::Frf);
    assert_eq!(entry.reference.unwrap().to_string(), "3:+Z");
    assert_eq!(entry.response.unwrap().to_string(), "12:-X");
    assert_eq!(entry.quantity, Some(Quantity::Acceleration));
    assert_eq!(entry.denominator, Some(Quantity::Force));
    assert_eq!(
        (entry.to_si, entry.unit_label.as_str()),
        (Some(1.0), "(m/s²)(N)")
    );
    assert_eq!(entry.identification.lines[0], "bar : tip");
    assert_eq!(even(source.as_ref(), 0), (0.0, 0.25));
    assert_eq!(complex(source.as_mut(), 0)[1], Complex64::new(1.5, -0.25));
}

#[test]
fn other_signalcalc_functions_follow_from_the_header() {
    let two = "0.0\t0.5\t0.25\r\n0.5\t0.75\t0.125\r\n";
    let bytes = signalcalc(
        "EU",
        "1+Z:2+Z\t1+Z:3+Z",
        "Frequency\tCoherence\tCoherence",
        "Hz",
        two,
    );
    let mut source = opened(bytes).unwrap();
    let entry = &source.catalog().entries[1];
    assert_eq!(
        (entry.function_type, entry.to_si),
        (FunctionType::Coherence, Some(1.0))
    );
    assert_eq!(entry.response.as_ref().unwrap().to_string(), "3:+Z");
    assert_eq!(whole(source.as_mut(), 1), Block::F64(vec![0.25, 0.125]));
    let bytes = signalcalc(
        "EU",
        "1+Z:2+Z\t1+Z:3+Z",
        "Time\tReal\tReal",
        "Sec\tN\tg",
        two,
    );
    let source = opened(bytes).unwrap();
    let entries = &source.catalog().entries;
    assert_eq!(entries[1].quantity, Some(Quantity::Acceleration));
    assert_eq!(entries[0].function_type, FunctionType::Time);
    assert!(matches!(entries[0].axis, EntryAxis::Time(_)));
    // A product is no ratio, and no FRF.
    let words = "Frequency\tReal\tImaginary";
    let bytes = signalcalc("EU", "1+Z:2+Z", words, "Hz\t(m/s²)(N)", two);
    let entry = opened(bytes).unwrap().catalog().entries[0].clone();
    assert_eq!(
        (entry.function_type, entry.to_si),
        (FunctionType::Other(0), None)
    );
    let cut = signalcalc(
        "Ratio",
        "1+Z:2+Z",
        words,
        "Hz\t(m)(N)",
        &two[..two.len() - 8],
    );
    let source = opened(cut).unwrap();
    assert_eq!(source.catalog().entries[0].len(), 1);
    assert_eq!(source.catalog().damage.len(), 1);
    let none = signalcalc("Ratio", "1+Z:2+Z", words, "Hz\t(m)(N)", "");
    assert!(opened(none).is_err());
}

//! Binary functions whose header states the opposite of the byte order that their values have.

use super::inspected::inspect;
use super::universal_file::{Function, OneFile, Values, accelerances, even_lines, finds_the_mode};

/// A byte order, as dataset 58b states it and as its values have it.
#[derive(Clone, Copy, Debug)]
struct Order {
    states_little: bool,
    is_little: bool,
}

fn number_bytes(number: f64, is_single: bool, is_little: bool) -> Vec<u8> {
    match (is_single, is_little) {
        (true, true) => (number as f32).to_le_bytes().to_vec(),
        (true, false) => (number as f32).to_be_bytes().to_vec(),
        (false, true) => number.to_le_bytes().to_vec(),
        (false, false) => number.to_be_bytes().to_vec(),
    }
}

/// The function as dataset 58b, its abscissae of 64 bits where it has them.
fn binary(function: &Function, is_single: bool, order: Order) -> Vec<u8> {
    let (numbers, kind) = match &function.values {
        Values::Real(values) => (
            values.iter().map(|value| vec![*value]).collect(),
            if is_single { 2 } else { 4 },
        ),
        Values::Complex(values) => {
            let parts = values.iter().map(|value| vec![value.re, value.im]);
            (parts.collect::<Vec<_>>(), if is_single { 5 } else { 6 })
        }
    };
    let mut block = Vec::new();
    for (index, numbers) in numbers.iter().enumerate() {
        if let Some(abscissae) = &function.uneven {
            block.extend(number_bytes(abscissae[index], is_single, order.is_little));
        }
        for number in numbers {
            block.extend(number_bytes(*number, is_single, order.is_little));
        }
    }
    let mut lines = function.lines()[..13].to_vec();
    lines[1] = format!(
        "    58b{:>6}     2          11{:>12}     0     0           0           0",
        if order.states_little { 1 } else { 2 },
        block.len()
    );
    lines[8].replace_range(..10, &format!("{kind:>10}"));
    let mut bytes = (lines.join("\n") + "\n").into_bytes();
    bytes.extend(block);
    bytes.extend(b"    -1\n");
    bytes
}

fn file(functions: &[Function], is_single: bool, order: Order) -> Vec<u8> {
    functions
        .iter()
        .flat_map(|function| binary(function, is_single, order))
        .collect()
}

const ORDERS: [Order; 4] = [
    Order {
        states_little: true,
        is_little: true,
    },
    Order {
        states_little: true,
        is_little: false,
    },
    Order {
        states_little: false,
        is_little: true,
    },
    Order {
        states_little: false,
        is_little: false,
    },
];

#[test]
fn the_byte_order_in_which_values_make_sense_is_used_and_reported() {
    for order in ORDERS {
        for is_single in [false, true] {
            let file = OneFile::new("order.uff", file(&accelerances(), is_single, order));
            let ran = finds_the_mode(&file.path(), &[]);
            let is_reported = ran.findings().contains("byte-order-wrong");
            assert_eq!(
                is_reported,
                order.states_little != order.is_little,
                "{order:?}: {ran:?}"
            );
        }
    }
}

#[test]
fn functions_that_decide_nothing_are_read_as_the_others_of_the_file() {
    let order = ORDERS[1];
    let mut functions = accelerances();
    let mut coherence = Function::accelerance(1, Vec::new());
    coherence.function_type = 6;
    coherence.values = Values::Real(vec![1.0; even_lines().len()]);
    functions.push(coherence);
    let file = OneFile::new("order.uff", file(&functions, true, order));
    let ran = finds_the_mode(&file.path(), &[]);
    let findings = ran.json()["findings"].clone();
    let wrong = findings
        .as_array()
        .unwrap()
        .iter()
        .find(|finding| finding["code"] == "byte-order-wrong");
    assert_eq!(wrong.unwrap()["value"], 4.0, "{findings}");
    // Read in the stated order, a coherence of 1 is 5e-41, and the variance of the FRF boundless.
    assert!(!ran.findings().contains("coherence-invalid"), "{findings}");
}

#[test]
fn records_with_zeros_before_the_impact_are_judged_by_their_middle() {
    let decay = |sample: usize| match sample {
        0..1000 => 0.0,
        _ => (-0.002 * sample as f64).exp() * (0.3 * sample as f64).sin(),
    };
    let record = Function::record(1, false, (0..3000).map(decay).collect());
    for (order, is_reported) in ORDERS.iter().zip([false, true, true, false]) {
        let file = OneFile::new("order.uff", binary(&record, true, *order));
        let inspected = inspect(&file);
        let count = usize::from(is_reported);
        assert_eq!(
            inspected.count_of("byte-order-wrong"),
            count,
            "{order:?}: {inspected:?}"
        );
    }
}

#[test]
fn uneven_abscissae_are_read_in_the_order_of_the_values() {
    let mut functions = accelerances();
    for function in &mut functions {
        function.uneven = Some(even_lines());
    }
    let file = OneFile::new("order.uff", file(&functions, false, ORDERS[2]));
    let ran = finds_the_mode(&file.path(), &[]);
    assert!(ran.findings().contains("byte-order-wrong"), "{ran:?}");
}

#[test]
fn values_of_any_other_size_keep_the_stated_order() {
    let kinds: [fn(usize) -> f64; 6] = [
        |_| 0.0,
        |_| 1e-30,
        |sample| 1e-40 * (sample as f64).sin(),
        |sample| 1e36 * (0.1 * sample as f64).cos(),
        |sample| sample as f64,
        |sample| f64::from(u8::from(sample == 70)),
    ];
    for kind in kinds {
        for is_single in [false, true] {
            let record = Function::record(1, false, (0..141).map(kind).collect());
            for order in [ORDERS[0], ORDERS[3]] {
                let file = OneFile::new("order.uff", binary(&record, is_single, order));
                let inspected = inspect(&file);
                assert_eq!(inspected.code, Some(0), "{inspected:?}");
                assert!(inspected.items("findings").is_empty(), "{inspected:?}");
            }
        }
    }
}

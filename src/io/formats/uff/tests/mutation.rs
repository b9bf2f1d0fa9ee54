//! Random damage never panics, never hangs and never asks for more memory than the file could fill.

use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::file_builder::{Form, all, binary_58, dataset, doubles, header, open, singles, text_58};

/// Small files of every dataset.
fn seeds() -> Vec<Vec<u8>> {
    let nodes = dataset(
        &["    15", "7 1 0 1 -1.5 2.5 3.5", "8 1 0 1 1. 2. 3."],
        "\n",
    );
    let double = dataset(&["  2411", "7 1 0 1", "-1.5D+00 2.5 3.5"], "\n");
    let units = dataset(&["   164", "5", "1.0D+03 1.0D+00 1.0D+00", "0.0"], "\n");
    let trace = dataset(&["    82", "1 3 8", "Frame", "7 8 0"], "\n");
    let title = dataset(&["   151", "Machine"], "\n");
    let systems = dataset(
        &[
            "    18",
            "9 1 8 1 1",
            "R",
            "1. 2. 3. 2. 2. 3.",
            "1. 2. 4.",
            "8 2 0 1 1",
            "Q",
            "0 0 0 1 0 0",
            "0 0 1",
        ],
        "\n",
    );
    let mesh = dataset(
        &[
            "  2412",
            "1 11 1 1 8 2",
            "0 1 1",
            "7 8",
            "2 41 1 1 8 3",
            "7 8 9",
        ],
        "\n",
    );
    let groups = dataset(&["  2467", "1 0 0 0 0 0 0 2", "G", "8 1 0 0 7 8 0 0"], "\n");
    let local = dataset(&["    15", "7 9 9 1 1.5 25. 3.5", "8 8 8 1 1. 2. 3."], "\n");
    let mode = dataset(
        &[
            "    55",
            "a",
            "",
            "",
            "",
            "",
            "1 3 2 8 5 3",
            "2 6 1 1",
            "-1. 10. 0. 20. 1. 2.",
            "7",
            "1. 2. 3. 4. 5. 6.",
            "8",
            "0 0 0 0 1. 2.",
        ],
        "\n",
    );
    let analysis = dataset(
        &[
            "  2414",
            "1",
            "a",
            "1",
            "",
            "",
            "",
            "",
            "",
            "1 2 3 8 2 6",
            "0 0 0 0 0 1 0 0",
            "0 0",
            "0. 5. 0. 1. 0. .1",
            "0. 0. 0. 0. 0. 0.",
            "7",
            "1. 2. 3. 4. 5. 6.",
        ],
        "\n",
    );
    let conventions = dataset(
        &[
            "  2414",
            "1",
            "a",
            "1",
            "",
            "",
            "",
            "",
            "",
            "1 3 2 8 5 3",
            "0 0 0 0 0 1 0 0",
            "0 0",
            "0. 0. 100. 1. 1.2 .1",
            "1. 10. 0. 0. 0. 0.",
            "7",
            "0. 0. 0. 0. 5. 6.",
        ],
        "\n",
    );
    let normal = dataset(
        &[
            "    55",
            "",
            "",
            "",
            "",
            "",
            "1 2 2 8 2 3",
            "2 4 1 1",
            "0. 0. 1.5 0.",
            "7",
            "0. 0. 3.",
        ],
        "\n",
    );
    let text = text_58(&header(2, 8), &["1.0 2.0 3.0 4.0-5.0E+00", "6 7 8"], "\n");
    let complex = text_58(&header(6, 2), &["1.0 2.0 3.0", "4.0"], "\r\n");
    let form = |little_endian| Form {
        little_endian,
        ..Form::default()
    };
    let single = binary_58(&header(2, 8), &singles(&[1.0; 8], true), form(true));
    let ramp: Vec<f32> = (0..40_u8).map(|n| 0.3 * f32::from(n).sin()).collect();
    let wide = binary_58(&header(4, 8), &doubles(&[1.0; 8], false), form(false));
    let uneven = |data_type: i32| {
        let mut head = header(data_type, 4);
        head[6] = format!("{data_type:>10}         4         0  0.00000E+00  0.00000E+00");
        head
    };
    let pairs = text_58(&uneven(2), &["0. 1. .5 2. 1.5 3.", "2. 4."], "\n");
    let bytes = binary_58(&uneven(4), &doubles(&[0.5; 8], true), form(true));
    let window = dataset(&["  1858", "1 0 0 0 0 0", "1 4 0 0 0 0 0 0 0 0 0 0"], "\n");
    let missing = text_58(&header(2, 3), &["-1.#IND0E+00 nan(ind)-1.#INF"], "\n");
    let swapped = binary_58(&header(2, 40), &singles(&ramp, false), form(true));
    let vax = [
        &b"    -1\n    58b     1     1          11          32\n"[..],
        &wide[95..],
    ]
    .concat();
    let joined = [
        text.trim_ascii_end(),
        b"\x1a",
        single.trim_ascii_end(),
        &missing,
    ]
    .concat();
    let old = text_58(&header(2, 8), &["1. 2. 3. 4. 5.", "6. 7. 8."], "\r");
    let utf_16 = [0xff, 0xfe]
        .into_iter()
        .chain(text.iter().flat_map(|byte| [*byte, 0]));
    vec![
        joined,
        [swapped, vax, double.clone()].concat(),
        ["\u{feff}".as_bytes(), &old, &text, &old].concat(),
        utf_16.collect(),
        [pairs, window, bytes].concat(),
        [title, units, nodes, trace].concat(),
        [systems.clone(), mesh, groups, local.clone()].concat(),
        [mode, local, systems.clone(), analysis].concat(),
        [conventions, normal, systems].concat(),
        [double, text.clone()].concat(),
        [single.clone(), text, wide.clone()].concat(),
        [complex, wide, single].concat(),
    ]
}

/// Opens and reads whatever is there.
fn survive(bytes: Vec<u8>) {
    let size = bytes.len();
    let Ok(mut source) = open(bytes) else {
        return;
    };
    for entry in 0..source.catalog().entries.len() {
        assert!(source.catalog().entries[entry].len() <= size);
        let _ = all(source.as_mut(), entry);
        let len = source.catalog().entries[entry].len();
        let _ = source.abscissa(entry, 0..len, &mut Vec::new());
    }
}

fn mutate(bytes: &mut Vec<u8>, rng: &mut ChaCha8Rng) {
    let at = rng.random_range(0..bytes.len());
    let end = (at + rng.random_range(1..60)).min(bytes.len());
    match rng.random_range(0..10) {
        0 => bytes[at] = rng.random(),
        1 => bytes[at] = b"0123456789-+.ED \n\r"[rng.random_range(0..18)],
        2 => drop(bytes.drain(at..end)),
        3 => {
            let copy = bytes[at..end].to_vec();
            let to = rng.random_range(0..bytes.len());
            drop(bytes.splice(to..to, copy));
        }
        4 => bytes.truncate(at.max(1)),
        5 => drop(bytes.splice(at..at, *b"\n    -1\n")),
        6 => drop(bytes.splice(at..at, *b"    -1    -1\n")),
        7 => drop(bytes.splice(at..at, *b"    -1\x1a\0\r    58\r")),
        8 => drop(bytes.splice(at..at, *b" -1.#IND nan( 1.#")),
        _ => bytes[at..end].fill(b'9'),
    }
    if bytes.is_empty() {
        bytes.push(b'\n');
    }
}

#[test]
fn two_thousand_mutations_are_survived() {
    let seeds = seeds();
    let mut rng = ChaCha8Rng::seed_from_u64(58);
    for i in 0..2_000 {
        let mut bytes = seeds[i % seeds.len()].clone();
        for _ in 0..rng.random_range(1..6) {
            mutate(&mut bytes, &mut rng);
        }
        survive(bytes);
    }
}

proptest! {
    #[test]
    fn random_bytes_are_survived(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        survive(bytes.clone());
        survive([b"    -1\n    58\n".to_vec(), bytes.clone()].concat());
        survive([b"    -1\r    58\r".to_vec(), bytes.clone()].concat());
        survive([b"\xff\xfe-\x001\x00\n\x00".to_vec(), bytes.clone()].concat());
        survive([b"    -1\n    58b     1     2          11          16\n".to_vec(), bytes].concat());
    }
}

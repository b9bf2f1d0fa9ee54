//! Universal files that are odd, damaged or hostile, built from bytes: what must be delivered of
//! each, and where each error must be placed. For every bad one the good functions beside it are
//! still delivered.

mod build;
mod malformed;
mod well_formed;

use modalign::io::{Block, Hints, open_bytes};

use crate::command::modalign;

/// Path that the tests expect in messages.
const PATH: &str = "torture.uff";

/// One function as delivered.
#[derive(Clone, Debug, PartialEq)]
struct Delivered {
    /// First ID line.
    name: String,
    /// Values, real part before imaginary part.
    values: Vec<f64>,
    /// First and last abscissa.
    ends: Option<(f64, f64)>,
}

/// What a file delivers, and its errors as printed (those of opening, then those of reading a
/// function).
fn deliver(bytes: Vec<u8>) -> (Vec<Delivered>, Vec<String>) {
    let hints = Hints {
        path: PATH.to_owned(),
        ..Hints::default()
    };
    let mut source = match open_bytes(bytes, &hints) {
        Ok(source) => source,
        Err(error) => return (Vec::new(), vec![error.to_string()]),
    };
    let damage = source.take_damage();
    let mut errors: Vec<String> = damage.iter().map(ToString::to_string).collect();
    let (mut delivered, mut block, mut abscissa) = (Vec::new(), Block::F64(vec![]), Vec::new());
    for entry in 0..source.catalog().entries.len() {
        let len = source.catalog().entries[entry].len();
        let read = source.read(entry, 0..len, &mut block);
        match read.and_then(|()| source.abscissa(entry, 0..len, &mut abscissa)) {
            Err(error) => errors.push(error.to_string()),
            Ok(()) => delivered.push(Delivered {
                name: source.catalog().entries[entry].identification.lines[0].clone(),
                values: numbers(&block),
                ends: abscissa.first().copied().zip(abscissa.last().copied()),
            }),
        }
    }
    (delivered, errors)
}

/// What `convert` delivers of a file, and its exit code; `--partial` says that this will do, and
/// changes nothing.
fn converted(bytes: &[u8]) -> (Vec<Delivered>, Option<i32>) {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.uff", "out.uff"].map(|name| folder.path().join(name));
    std::fs::write(&input, bytes).unwrap();
    let paths = [input.to_str().unwrap(), "-o", output.to_str().unwrap()];
    let verb = ["convert", "--partial"];
    let stated = bytes.len() % 2;
    let ended = modalign(verb[..1 + stated].iter().chain(&paths));
    let (delivered, errors) = deliver(std::fs::read(&output).unwrap_or_default());
    assert!(errors.is_empty() || !output.exists(), "{errors:?}");
    (delivered, ended.status.code())
}

fn numbers(block: &Block) -> Vec<f64> {
    match block {
        Block::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
        Block::F64(values) => values.clone(),
        Block::Complex(values) => values.iter().flat_map(|v| [v.re, v.im]).collect(),
    }
}

//! Modes to arrays and back. `modes/json` is complete; the other arrays are for users of other
//! programs.

use std::collections::{BTreeMap, BTreeSet};

use num_complex::Complex64;

use crate::dof::Dof;
use crate::io::{IoError, ModeEntry, modes_from_json, modes_to_json};
use crate::modal::{ModalModel, Mode};

use super::array_index::ArrayIndex;
use super::arrays::{Put, numbers, text, texts};
use crate::io::formats::dropped_content::DroppedContent;
use crate::linalg::sort_ascending_by;

/// Emits the modes in ascending frequency. A mode that its text cannot hold (a number that is not
/// finite) is left out.
pub(super) fn write(
    modes: &[ModeEntry],
    put: &mut Put,
    lost: &mut DroppedContent,
) -> Result<(), IoError> {
    let numbered = modes.iter().enumerate();
    let mut carried: Vec<(usize, &ModeEntry)> = numbered
        .filter(|(_, entry)| comes_back(&entry.mode))
        .collect();
    let left_out = modes.len() - carried.len();
    lost.add("modes with numbers that are not finite", left_out);
    if carried.is_empty() {
        return Ok(());
    }
    sort_ascending_by(&mut carried, |mode| mode.1.mode.frequency_hz);
    let count = carried.len();
    let model = model(
        carried
            .iter()
            .map(|(_, entry)| entry.mode.clone())
            .collect(),
    );
    put(text("modes/json", &modes_to_json(&model, None)))?;
    let positions = carried.iter().map(|(position, _)| *position as f64);
    put(numbers("modes/position", &[count], positions.collect()))?;
    let titles = carried.iter().map(|(_, entry)| entry.title.join("\n"));
    put(texts("modes/title", &[count], titles.collect()))?;
    let of_a = carried.iter().flat_map(|(_, entry)| parts(entry.modal_a));
    put(numbers("modes/modal_a", &[count, 2], of_a.collect()))?;
    let of_b = carried.iter().flat_map(|(_, entry)| parts(entry.modal_b));
    put(numbers("modes/modal_b", &[count, 2], of_b.collect()))?;
    write_for_users(&model.modes, put)
}

fn model(modes: Vec<Mode>) -> ModalModel {
    ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        modes,
        ..ModalModel::default()
    }
}

fn comes_back(mode: &Mode) -> bool {
    let model = model(vec![mode.clone()]);
    modes_from_json(&modes_to_json(&model, None), "").is_ok_and(|read| read == model)
}

fn parts(value: Option<Complex64>) -> [f64; 2] {
    value.map_or([f64::NAN; 2], |value| [value.re, value.im])
}

fn write_for_users(modes: &[Mode], put: &mut Put) -> Result<(), IoError> {
    let count = modes.len();
    let frequencies = modes.iter().map(|mode| mode.frequency_hz).collect();
    put(numbers("modes/frequency_hz", &[count], frequencies))?;
    let damping = modes
        .iter()
        .map(|mode| mode.damping_ratio.unwrap_or(f64::NAN));
    put(numbers("modes/damping_ratio", &[count], damping.collect()))?;
    let dofs: BTreeSet<&Dof> = modes
        .iter()
        .flat_map(|mode| mode.shape.iter())
        .map(|v| v.0)
        .collect();
    let names = dofs.iter().map(ToString::to_string).collect();
    put(texts("modes/dof", &[dofs.len()], names))?;
    let (mut re, mut im) = (Vec::new(), Vec::new());
    for mode in modes {
        let values: BTreeMap<&Dof, Complex64> = mode.shape.iter().collect();
        let missing = Complex64::new(f64::NAN, f64::NAN);
        let row = dofs
            .iter()
            .map(|dof| values.get(*dof).copied().unwrap_or(missing));
        for value in row {
            re.push(value.re);
            im.push(value.im);
        }
    }
    put(numbers("modes/shape_re", &[count, dofs.len()], re))?;
    put(numbers("modes/shape_im", &[count, dofs.len()], im))
}

/// Reads the modes, in the order that they had.
pub(super) fn read(
    array_index: &mut ArrayIndex,
    modes: &mut Vec<ModeEntry>,
) -> Result<(), IoError> {
    let Some(json) = array_index.text("modes/json")? else {
        return Ok(());
    };
    let read = modes_from_json(&json, array_index.path())?.modes;
    let count = read.len();
    let positions = array_index.numbers("modes/position", Some(&[count]))?;
    let positions = positions.unwrap_or_else(|| vec![0.0; count]);
    let titles = array_index
        .texts("modes/title", Some(&[count]))?
        .unwrap_or_default();
    let of_a = complex(array_index, "modes/modal_a", count)?;
    let of_b = complex(array_index, "modes/modal_b", count)?;
    let numbered = read.into_iter().zip(positions).enumerate();
    let mut placed: Vec<(f64, ModeEntry)> = numbered
        .map(|(index, (mode, position))| {
            let title = titles.get(index).map_or("", String::as_str);
            let entry = ModeEntry {
                title: lines(title),
                modal_a: of_a.get(index).copied().flatten(),
                modal_b: of_b.get(index).copied().flatten(),
                ..ModeEntry::new(mode)
            };
            (position, entry)
        })
        .collect();
    sort_ascending_by(&mut placed, |entry| entry.0);
    modes.extend(placed.into_iter().map(|(_, entry)| entry));
    Ok(())
}

fn lines(title: &str) -> Vec<String> {
    let lines = title.split('\n').filter(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

fn complex(
    array_index: &mut ArrayIndex,
    name: &str,
    count: usize,
) -> Result<Vec<Option<Complex64>>, IoError> {
    let values = array_index.numbers(name, Some(&[count, 2]))?;
    let values = values.unwrap_or_default();
    let pairs = values.chunks_exact(2);
    let known = |pair: &[f64]| !pair[0].is_nan() || !pair[1].is_nan();
    Ok(pairs
        .map(|pair| known(pair).then(|| Complex64::new(pair[0], pair[1])))
        .collect())
}

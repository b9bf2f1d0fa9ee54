//! Degrees of freedom by file: a file is a group whose sensors may all be reversed.

use std::collections::BTreeSet;

use crate::dof::Dof;
use crate::io::HitFile;

/// For each of several files the degrees of freedom that no other file has.
pub(super) fn dofs_of_files(files: &[HitFile]) -> Vec<Vec<Dof>> {
    let dofs = |file: &HitFile| -> BTreeSet<Dof> {
        let entries = file.source.catalog().entries.iter();
        let stated = [file.response.clone(), file.reference.clone()];
        let named = entries.flat_map(|entry| [entry.response.clone(), entry.reference.clone()]);
        let all = stated.into_iter().chain(named).flatten();
        all.map(|dof| dof.positive()).collect()
    };
    let all: Vec<BTreeSet<Dof>> = files.iter().map(dofs).collect();
    let alone = |dof: &&Dof| all.iter().filter(|dofs| dofs.contains(*dof)).count() == 1;
    let of_file = |dofs: &BTreeSet<Dof>| match all.len() {
        1 => Vec::new(),
        _ => dofs.iter().filter(alone).cloned().collect(),
    };
    all.iter().map(of_file).collect()
}

//! Hypotheses list groups of sensors that may be reversed together, and single sensors.

use std::collections::BTreeMap;

use crate::modal::ModalModel;

use super::super::DofMap;

/// Sensors that are reversed together under one hypothesis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hypothesis {
    /// Name of the group; `None` for a single sensor.
    pub group: Option<String>,
    /// Indices of its degrees of freedom in the map, ascending.
    pub members: Vec<usize>,
}

/// Groups by direction, by component and by file, then every single sensor.
///
/// The complement stands for a class of more than half of the sensors: its reversal is equivalent.
/// Each set of sensors occurs once, under its first name.
pub(super) fn hypotheses(test: &ModalModel, map: &DofMap) -> Vec<Hypothesis> {
    let directions = map.pairs.iter().map(|pair| pair.test.axis().to_string());
    let components = map.pairs.iter().map(|pair| match pair.test.component() {
        Some(component) => component.to_owned(),
        None => "without a name".to_owned(),
    });
    let files = map.pairs.iter().map(|pair| {
        let dof = pair.test.positive();
        let file = test.inputs.iter().find(|file| file.dofs.contains(&dof));
        file.map_or("none", |file| file.path.as_str()).to_owned()
    });
    let mut all = Vec::new();
    all.extend(groups("direction", &classes(directions), map.len()));
    all.extend(groups("component", &classes(components), map.len()));
    all.extend(groups("file", &classes(files), map.len()));
    let mut kept: Vec<Hypothesis> = Vec::new();
    for hypothesis in all {
        let other = complement(&hypothesis.members, map.len());
        let known =
            |known: &Hypothesis| known.members == hypothesis.members || known.members == other;
        if hypothesis.members.len() > 1 && !kept.iter().any(known) {
            kept.push(hypothesis);
        }
    }
    kept.extend((0..map.len()).map(|d| Hypothesis {
        group: None,
        members: vec![d],
    }));
    kept
}

/// Indices by their class.
fn classes(names: impl Iterator<Item = String>) -> BTreeMap<String, Vec<usize>> {
    let mut classes: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (d, name) in names.enumerate() {
        classes.entry(name).or_default().push(d);
    }
    classes
}

fn groups(kind: &str, classes: &BTreeMap<String, Vec<usize>>, count: usize) -> Vec<Hypothesis> {
    let group = |(name, members): (&String, &Vec<usize>)| {
        if 2 * members.len() <= count {
            return Hypothesis {
                group: Some(format!("{kind} {name}")),
                members: members.clone(),
            };
        }
        let others: Vec<&str> = classes
            .keys()
            .filter(|label| *label != name)
            .map(String::as_str)
            .collect();
        let plural = if others.len() > 1 { "s" } else { "" };
        Hypothesis {
            group: Some(format!("{kind}{plural} {}", others.join(", "))),
            members: complement(members, count),
        }
    };
    match classes.len() {
        0 | 1 => Vec::new(),
        _ => classes.iter().map(group).collect(),
    }
}

fn complement(members: &[usize], count: usize) -> Vec<usize> {
    (0..count).filter(|d| !members.contains(d)).collect()
}

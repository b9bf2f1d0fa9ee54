//! Geometry out: coordinate systems (2420), nodes (2411), trace lines (82), elements (2412), groups
//! (2467), in metres.
//!
//! Positions are written in the global frame with 17 digits, so that every double comes back.
//! Displacement systems stay with their nodes: functions of dataset 58 count their directions in
//! them, and shapes are turned back into them (`modes::write`). Points, and labels of more than
//! 9 digits, that are no node number are left out with a finding.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::{dataset_82, dataset_2411, dataset_2412, dataset_2420, dataset_2467};
use crate::finding::Finding;
use crate::geometry::{CoordinateSystem, Element, Geometry, Group, Node};
use crate::io::IoError;
use crate::io::formats::dropped_content::DroppedContent;
use crate::io::formats::uff::modes::Frames;
use crate::linalg::Vector3;

/// Labels fill at most 9 of their 10 columns, so that fields stay apart.
const LARGEST_LABEL: i64 = 999_999_999;

/// Writes the geometry; see the module head.
///
/// # Errors
/// [`IoError::System`] when writing fails.
pub(in crate::io::formats::uff) fn write_geometry(
    out: &mut dyn Write,
    geometry: &Geometry,
    path: &str,
) -> Result<Vec<Finding>, IoError> {
    let mut lost = DroppedContent::default();
    write_all(out, geometry, &mut lost).map_err(|source| IoError::System {
        path: path.to_owned(),
        action: "write",
        source,
    })?;
    Ok(lost.findings())
}

fn write_all(
    out: &mut dyn Write,
    geometry: &Geometry,
    lost: &mut DroppedContent,
) -> io::Result<()> {
    let systems = systems(geometry);
    lost.add("coordinate systems", geometry.systems.len() - systems.len());
    if !systems.is_empty() {
        let is_first = |system: &&CoordinateSystem| {
            let first = systems.get(&system.label);
            first.is_some_and(|first| std::ptr::eq(*first, *system))
        };
        let in_file_order = geometry.systems.iter().filter(is_first);
        dataset_2420::write(out, &in_file_order.collect::<Vec<_>>())?;
    }
    let nodes = nodes(geometry);
    lost.add("nodes", geometry.nodes.len() - nodes.len());
    let displacement = geometry.nodes.iter().filter(|node| {
        let system = node.displacement_system;
        is_node(node) && system.is_some_and(|system| !is_label(system))
    });
    lost.add("displacement systems of nodes", displacement.count());
    if !nodes.is_empty() {
        dataset_2411::write(out, &nodes)?;
    }
    for (i, line) in geometry.lines.iter().enumerate() {
        let mut label = |point: &Option<String>| {
            let point = point.as_deref()?;
            lost.or_add("points of trace lines", node_label(point))
        };
        let points = line.points.iter();
        let labels: Vec<i64> = points.map(|point| label(point).unwrap_or(0)).collect();
        dataset_82::write(out, i + 1, &line.name, &labels)?;
    }
    let elements: Vec<_> = geometry.elements.iter().filter_map(element).collect();
    lost.add("elements", geometry.elements.len() - elements.len());
    if !elements.is_empty() {
        dataset_2412::write(out, &elements)?;
    }
    let groups: Vec<&Group> = geometry
        .groups
        .iter()
        .filter(|group| is_written(group))
        .collect();
    lost.add("groups", geometry.groups.len() - groups.len());
    if !groups.is_empty() {
        dataset_2467::write(out, &groups)?;
    }
    Ok(())
}

/// The node number that a point is, as it would be read back.
pub(in crate::io::formats::uff) fn node_label(point: &str) -> Option<i64> {
    let label: i64 = point.parse().ok()?;
    ((1..=LARGEST_LABEL).contains(&label) && label.to_string() == point).then_some(label)
}

fn is_label(label: i64) -> bool {
    (0..=LARGEST_LABEL).contains(&label)
}

/// The systems that are written, by label: the first of each.
fn systems(geometry: &Geometry) -> BTreeMap<i64, &CoordinateSystem> {
    let mut systems = BTreeMap::new();
    for system in &geometry.systems {
        let mut numbers = system.axes.iter().chain([&system.origin_m]).flatten();
        if system.label > 0 && is_label(system.label) && numbers.all(|v| v.is_finite()) {
            systems.entry(system.label).or_insert(system);
        }
    }
    systems
}

/// Whether a node is written.
fn is_node(node: &Node) -> bool {
    node_label(&node.point).is_some() && node.at_m.iter().all(|v| v.is_finite())
}

/// Label, displacement system and position of the nodes that are written.
fn nodes(geometry: &Geometry) -> Vec<(i64, i64, Vector3)> {
    let written = geometry.nodes.iter().filter(|node| is_node(node));
    let nodes = written.filter_map(|node| {
        let system = node.displacement_system.filter(|system| is_label(*system));
        Some((node_label(&node.point)?, system.unwrap_or(0), node.at_m))
    });
    nodes.collect()
}

fn element(element: &Element) -> Option<(&Element, Vec<i64>)> {
    let nodes: Option<Vec<i64>> = element
        .points
        .iter()
        .map(|point| node_label(point))
        .collect();
    let written = is_label(element.label) && is_label(element.descriptor);
    nodes
        .filter(|nodes| written && !nodes.is_empty())
        .map(|nodes| (element, nodes))
}

fn is_written(group: &Group) -> bool {
    let mut members = group.members.iter();
    is_label(group.label) && members.all(|member| is_label(member.0) && is_label(member.1))
}

/// Displacement directions of the written nodes that do not count them along the global axes.
pub(in crate::io::formats::uff) fn frames(geometry: &Geometry) -> Frames {
    let systems = systems(geometry);
    let mut frames = Frames::new();
    for (label, system, at_m) in nodes(geometry) {
        if let Some(system) = systems.get(&system).filter(|system| !system.is_aligned()) {
            frames.insert(label, system.unit_vectors_at(at_m));
        }
    }
    frames
}

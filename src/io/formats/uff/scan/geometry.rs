//! The part of the pass over a file that collects nodes, coordinate systems, elements, groups and
//! modes, and puts them together at its end: each of them may stand before or behind what it needs.

use std::collections::{BTreeMap, BTreeSet};

use super::scanner::{Scanner, units_at};
use crate::finding::{Code, Finding, Severity};
use crate::geometry::Node;
use crate::io::Part;
use crate::io::convert::needed_parts::directions_lost;
use crate::io::formats::uff::dataset_2400;
use crate::io::formats::uff::fields::{FieldError, Line, Position};
use crate::io::formats::uff::geometry::dataset_82::Traced;
use crate::io::formats::uff::geometry::nodes::RawNode;
use crate::io::formats::uff::geometry::systems::{Found, Systems, position_m};
use crate::io::formats::uff::geometry::{
    dataset_15, dataset_18, dataset_82, dataset_2411, dataset_2412, dataset_2420, dataset_2467,
};
use crate::io::formats::uff::modes::{
    Frames, RawMode, Zeros, conventions, measured, names_measurement_system,
};
use crate::io::formats::uff::modes::{dataset_55, dataset_2414};

/// Largest number of findings about undescribed coordinate systems; a file may have any number of
/// them.
const MAX_REPORTED_SYSTEMS: usize = 20;

/// Whether the dataset of this number is collected here.
pub(super) fn is_geometry(number: u32) -> bool {
    matches!(
        number,
        15 | 18 | 55 | 82 | 781 | 2400 | 2411 | 2412 | 2414 | 2420
    ) || dataset_2467::NUMBERS.contains(&number)
}

impl Scanner {
    /// Reads a dataset for which [`is_geometry`] holds; `first` is its first line.
    pub fn geometry_dataset(
        &mut self,
        number: u32,
        lines: &[Line],
        first: &Line,
    ) -> Result<(), FieldError> {
        let geometry = &mut self.catalog.geometry;
        match number {
            15 => self.described.nodes.extend(dataset_15::nodes(lines)?),
            18 => {
                let systems = dataset_18::systems(lines, first)?;
                self.described.systems.extend(systems);
            }
            55 => self.mode(first, dataset_55::mode(lines, first)?),
            82 => self.trace_line(dataset_82::trace_line(lines, first)?, first),
            2400 => self.described.model_name = dataset_2400::name(lines),
            2412 => geometry
                .elements
                .extend(dataset_2412::elements(lines, first)?),
            2414 => self.mode(first, dataset_2414::mode(lines, first)?),
            2420 => {
                let systems = dataset_2420::systems(lines, first)?;
                self.described.systems.extend(systems);
            }
            781 | 2411 => self.described.nodes.extend(dataset_2411::nodes(lines)?),
            _ => geometry
                .groups
                .extend(dataset_2467::groups(number, lines, first)?),
        }
        Ok(())
    }

    fn trace_line(&mut self, traced: Traced, first: &Line) {
        if traced.found != traced.stated {
            let location = self.location(first.at);
            let finding = Finding::new(Severity::Warning, Code::TraceLineCount, location);
            let finding = finding.value(traced.found as f64, "");
            self.catalog
                .findings
                .push(finding.limit(traced.stated as f64));
        }
        self.catalog.geometry.lines.push(traced.line);
    }

    fn mode(&mut self, first: &Line, mode: Result<RawMode, i64>) {
        match mode {
            Ok(mode) => self.described.modes.push(mode),
            Err(analysis) => {
                if self.described.passed_over.insert(analysis) {
                    let location = self.location(first.at);
                    let finding = Finding::new(Severity::Info, Code::NotModes, location);
                    let finding = finding.value(analysis as f64, "");
                    self.catalog.findings.push(finding);
                }
            }
        }
    }

    /// Puts everything that was collected into the catalogue, in metres and in the global frame.
    pub fn place_geometry(&mut self) {
        let mut described = std::mem::take(&mut self.described);
        if self.catalog.title.is_empty() && !described.model_name.is_empty() {
            self.catalog.title.push(described.model_name);
        }
        let length =
            |at: Position| units_at(&self.units, at.byte).map_or(1.0, |units| units.length);
        let mut systems = Systems::new(described.systems, length);
        for error in std::mem::take(&mut systems.damage) {
            self.damaged(error, Part::Systems);
        }
        self.report_unknown_systems(&systems, &described.nodes);
        let nodes = self.place_nodes(&systems, described.nodes);
        let positions = nodes
            .values()
            .filter(|(_, node)| node.displacement_system.is_none());
        let positions = positions.map(|(label, node)| (*label, node.at_m.into()));
        self.correct_poles(&mut described.modes, &positions.collect());
        self.place_modes(&frames(&systems, &nodes), &described.modes);
        self.catalog.geometry.nodes = nodes.into_values().map(|(_, node)| node).collect();
        self.catalog.geometry.systems = systems.placed;
        self.report_lost_directions(&described.modes);
    }

    /// Reports at the first mode how many nodes of the shapes have directions that are lost with
    /// damaged parts.
    fn report_lost_directions(&mut self, modes: &[RawMode]) {
        let lost: Vec<Part> = self
            .catalog
            .damage
            .iter()
            .map(|damaged| damaged.part)
            .collect();
        let Some(first) = modes.first() else { return };
        if !directions_lost(&lost, &self.catalog) {
            return;
        }
        let geometry = &self.catalog.geometry;
        let is_described = |node: &i64| {
            let found = geometry.node(&node.to_string());
            let system = |label| geometry.system(label).is_some();
            found.is_some_and(|node| node.displacement_system.is_none_or(system))
        };
        let nodes: BTreeSet<&i64> = modes.iter().flat_map(|mode| &mode.nodes).collect();
        let count = nodes.into_iter().filter(|node| !is_described(node)).count();
        let location = self.location(first.at);
        let finding = Finding::new(Severity::Error, Code::DirectionsLost, location);
        self.catalog
            .findings
            .push(finding.value(count as f64, "nodes"));
    }

    fn report_unknown_systems(&mut self, systems: &Systems, nodes: &[RawNode]) {
        let asked = nodes
            .iter()
            .flat_map(|node| [(node.at, node.definition), (node.at, node.displacement)]);
        for (at, label) in systems
            .undescribed(asked)
            .into_iter()
            .take(MAX_REPORTED_SYSTEMS)
        {
            let finding = Finding::new(Severity::Warning, Code::UnknownSystem, self.location(at));
            self.catalog.findings.push(finding.value(label as f64, ""));
        }
    }

    /// Nodes in metres, by their place in the file. A node that is given twice at one place is one,
    /// with the finer of its coordinates; at two places or with two displacement systems it is
    /// damage.
    fn place_nodes(
        &mut self,
        systems: &Systems,
        raw: Vec<RawNode>,
    ) -> BTreeMap<usize, (i64, Node)> {
        if let (Some(first), true) = (
            raw.first(),
            self.units.iter().all(|units| units.1.is_none()),
        ) {
            let location = self.location(first.at);
            let finding = Finding::new(Severity::Warning, Code::Assumption, location);
            self.catalog.findings.push(finding.value(1.0, "m"));
        }
        // Place of the first, and the finest.
        let mut known: BTreeMap<i64, (usize, &RawNode)> = BTreeMap::new();
        for (i, node) in raw.iter().enumerate() {
            let (_, before) = known.entry(node.label).or_insert((i, node));
            match differs(systems, node, before) {
                Some(error) => self.damaged(error, Part::Nodes),
                None if node.is_finer(before) => *before = node,
                None => {}
            }
        }
        let placed = known.into_iter();
        placed
            .map(|(label, (i, node))| (i, (label, self.node(systems, node))))
            .collect()
    }

    fn node(&self, systems: &Systems, raw: &RawNode) -> Node {
        let length = units_at(&self.units, raw.at.byte).map_or(1.0, |units| units.length);
        let definition = match systems.find(raw.definition) {
            Found::Local(system) => Some(system),
            Found::Global | Found::Unknown => None,
        };
        let displacement_system = match systems.find(raw.displacement) {
            Found::Global => None,
            Found::Local(_) | Found::Unknown => Some(raw.displacement),
        };
        Node {
            point: raw.label.to_string(),
            at_m: position_m(definition, raw.coordinates, length),
            displacement_system,
        }
    }

    /// Turns poles of other conventions into those of the format, and takes out modes without a
    /// frequency, which are damage.
    fn correct_poles(&mut self, modes: &mut Vec<RawMode>, positions: &BTreeMap<i64, [f64; 3]>) {
        for error in conventions::remove_without_frequency(modes, positions) {
            self.damaged(error, Part::Mode);
        }
        for observed in conventions::correct(modes) {
            let location = self.location(observed.at);
            let finding = Finding::new(Severity::Warning, observed.code, location);
            self.catalog
                .findings
                .push(finding.value(observed.value, ""));
        }
    }

    fn place_modes(&mut self, frames: &Frames, modes: &[RawMode]) {
        let title = &self.catalog.title;
        let by_title = title.iter().any(|line| names_measurement_system(line));
        let (filled, others): (Vec<&RawMode>, Vec<&RawMode>) =
            modes.iter().partition(|mode| mode.is_filled(by_title));
        let of_filled = measured(filled.iter().copied());
        let of_others = measured(others.iter().copied());
        let others = others.into_iter().flat_map(|mode| &mode.nodes);
        let others: BTreeSet<&i64> = others.collect();
        let is_turned =
            |node: &&i64| of_filled.directions.contains_key(node) || others.contains(node);
        let turned = frames.keys().filter(is_turned).count();
        let first_filled = filled.first().map(|mode| mode.at);
        self.report_count(first_filled, Code::UnmeasuredLeftOut, of_filled.left_out);
        self.report_count(
            modes.first().map(|mode| mode.at),
            Code::LocalSystemApplied,
            turned,
        );
        let (mut unscaled, mut first_unscaled) = (0, None);
        for mode in modes {
            let units = units_at(&self.units, mode.at.byte);
            if mode.loses_scale(units) {
                unscaled += 1;
                first_unscaled.get_or_insert(mode.at);
            }
            let entry = match mode.is_filled(by_title) {
                true => mode.entry(units, &of_filled, Zeros::Unmeasured, frames),
                false => mode.entry(units, &of_others, Zeros::Values, frames),
            };
            self.catalog.modes.push(entry);
        }
        self.report_count(first_unscaled, Code::ModalScaleUnknown, unscaled);
    }

    /// Tells of what there is some, at the first of it.
    fn report_count(&mut self, first: Option<Position>, code: Code, count: usize) {
        if let (Some(first), true) = (first, count > 0) {
            let severity = match code {
                Code::ModalScaleUnknown => Severity::Warning,
                _ => Severity::Info,
            };
            let finding = Finding::new(severity, code, self.location(first));
            self.catalog.findings.push(finding.value(count as f64, ""));
        }
    }
}

/// The error of a second node with a label that differs from the first.
fn differs(systems: &Systems, node: &RawNode, before: &RawNode) -> Option<FieldError> {
    let resolved = |label: i64| match systems.find(label) {
        Found::Global => 0,
        Found::Local(_) | Found::Unknown => label,
    };
    let differs = |what: &'static str, got: String, expected: String| {
        let (at, label) = (node.at, node.label);
        Some(FieldError {
            at,
            what,
            got: format!("{label} {got}"),
            expected: format!("{expected} as before"),
        })
    };
    let place = |node: &RawNode| match resolved(node.definition) {
        0 => format!("at {:?}", node.coordinates),
        system => format!("at {:?} of system {system}", node.coordinates),
    };
    if resolved(node.definition) != resolved(before.definition) || !node.has_coordinates_of(before)
    {
        return differs("second position of a node", place(node), place(before));
    }
    let turned = |node: &RawNode| format!("in system {}", node.displacement);
    if resolved(node.displacement) != resolved(before.displacement) {
        let what = "second displacement system of a node";
        return differs(what, turned(node), turned(before));
    }
    None
}

/// Displacement directions of the nodes that do not count them along the global axes.
fn frames(systems: &Systems, nodes: &BTreeMap<usize, (i64, Node)>) -> Frames {
    let mut frames = Frames::new();
    for (label, node) in nodes.values() {
        let found = node.displacement_system.map(|system| systems.find(system));
        if let Some(Found::Local(system)) = found
            && !system.is_aligned()
        {
            frames.insert(*label, system.unit_vectors_at(node.at_m));
        }
    }
    frames
}

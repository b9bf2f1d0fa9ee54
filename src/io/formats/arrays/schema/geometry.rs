//! Points, trace lines, coordinate systems, elements and groups to arrays and back.

use crate::geometry::{CoordinateSystem, Element, Geometry, Group, Node, SystemKind, TraceLine};
use crate::io::IoError;
use crate::linalg::Vector3;

use super::array_index::ArrayIndex;
use super::arrays::{Put, numbers, texts, whole, whole_numbers};
use crate::io::formats::dropped_content::DroppedContent;

/// Kinds of coordinate systems and their names.
const KINDS: [(SystemKind, &str); 3] = [
    (SystemKind::Cartesian, "cartesian"),
    (SystemKind::Cylindrical, "cylindrical"),
    (SystemKind::Spherical, "spherical"),
];

/// Emits the arrays of what there is.
pub(super) fn write(
    geometry: &Geometry,
    put: &mut Put,
    lost: &mut DroppedContent,
) -> Result<(), IoError> {
    let mut inexact = 0;
    write_nodes(&geometry.nodes, put, &mut inexact)?;
    write_lines(&geometry.lines, put)?;
    write_systems(&geometry.systems, put, &mut inexact)?;
    write_elements(&geometry.elements, put, &mut inexact)?;
    write_groups(&geometry.groups, put, &mut inexact)?;
    lost.add("labels of geometry beyond 2^53", inexact);
    Ok(())
}

/// Emits whole numbers as doubles and counts those that a double cannot hold.
fn put_whole(
    name: &str,
    values: impl Iterator<Item = i64>,
    put: &mut Put,
    inexact: &mut usize,
) -> Result<(), IoError> {
    let (values, beyond) = whole_numbers(values);
    *inexact += beyond;
    put(numbers(name, &[values.len()], values))
}

fn put_counts(
    name: &str,
    values: impl Iterator<Item = usize>,
    put: &mut Put,
) -> Result<(), IoError> {
    let values: Vec<f64> = values.map(|count| count as f64).collect();
    put(numbers(name, &[values.len()], values))
}

fn put_texts(
    name: &str,
    values: impl Iterator<Item = String>,
    put: &mut Put,
) -> Result<(), IoError> {
    let values: Vec<String> = values.collect();
    put(texts(name, &[values.len()], values))
}

fn write_nodes(nodes: &[Node], put: &mut Put, inexact: &mut usize) -> Result<(), IoError> {
    if nodes.is_empty() {
        return Ok(());
    }
    put_texts(
        "geometry/point",
        nodes.iter().map(|node| node.point.clone()),
        put,
    )?;
    let at_m = nodes
        .iter()
        .flat_map(|node| coordinates(&node.at_m))
        .collect();
    put(numbers("geometry/at_m", &[nodes.len(), 3], at_m))?;
    let labels = nodes.iter().filter_map(|node| node.displacement_system);
    *inexact += whole_numbers(labels).1;
    let systems = nodes.iter().map(|node| {
        let label = node.displacement_system;
        label.map_or(f64::NAN, |label| label as f64)
    });
    put(numbers(
        "geometry/displacement_system",
        &[nodes.len()],
        systems.collect(),
    ))
}

fn coordinates(vector: &Vector3) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

fn write_lines(lines: &[TraceLine], put: &mut Put) -> Result<(), IoError> {
    if lines.is_empty() {
        return Ok(());
    }
    put_texts(
        "geometry/line_name",
        lines.iter().map(|line| line.name.clone()),
        put,
    )?;
    put_counts(
        "geometry/line_count",
        lines.iter().map(|line| line.points.len()),
        put,
    )?;
    let points = lines.iter().flat_map(|line| &line.points);
    put_texts(
        "geometry/line_point",
        points.map(|point| point.clone().unwrap_or_default()),
        put,
    )
}

fn write_systems(
    systems: &[CoordinateSystem],
    put: &mut Put,
    inexact: &mut usize,
) -> Result<(), IoError> {
    if systems.is_empty() {
        return Ok(());
    }
    let count = systems.len();
    put_whole(
        "geometry/system_label",
        systems.iter().map(|s| s.label),
        put,
        inexact,
    )?;
    put_texts(
        "geometry/system_name",
        systems.iter().map(|s| s.name.clone()),
        put,
    )?;
    let kind = |system: &CoordinateSystem| {
        let row = KINDS.iter().find(|row| row.0 == system.kind);
        row.map_or("", |row| row.1).to_owned()
    };
    put_texts("geometry/system_kind", systems.iter().map(kind), put)?;
    let origins = systems
        .iter()
        .flat_map(|s| coordinates(&s.origin_m))
        .collect();
    put(numbers("geometry/system_origin_m", &[count, 3], origins))?;
    let axes = systems
        .iter()
        .flat_map(|s| s.axes.iter().flat_map(coordinates));
    put(numbers(
        "geometry/system_axes",
        &[count, 3, 3],
        axes.collect(),
    ))
}

fn write_elements(elements: &[Element], put: &mut Put, inexact: &mut usize) -> Result<(), IoError> {
    if elements.is_empty() {
        return Ok(());
    }
    put_whole(
        "geometry/element_label",
        elements.iter().map(|e| e.label),
        put,
        inexact,
    )?;
    let descriptors = elements.iter().map(|element| element.descriptor);
    put_whole("geometry/element_descriptor", descriptors, put, inexact)?;
    put_counts(
        "geometry/element_count",
        elements.iter().map(|e| e.points.len()),
        put,
    )?;
    let points = elements
        .iter()
        .flat_map(|element| element.points.iter().cloned());
    put_texts("geometry/element_point", points, put)
}

fn write_groups(groups: &[Group], put: &mut Put, inexact: &mut usize) -> Result<(), IoError> {
    if groups.is_empty() {
        return Ok(());
    }
    put_whole(
        "geometry/group_label",
        groups.iter().map(|g| g.label),
        put,
        inexact,
    )?;
    put_texts(
        "geometry/group_name",
        groups.iter().map(|g| g.name.clone()),
        put,
    )?;
    put_counts(
        "geometry/group_count",
        groups.iter().map(|g| g.members.len()),
        put,
    )?;
    let members = || groups.iter().flat_map(|group| &group.members);
    put_whole(
        "geometry/group_type",
        members().map(|member| member.0),
        put,
        inexact,
    )?;
    put_whole(
        "geometry/group_member",
        members().map(|member| member.1),
        put,
        inexact,
    )
}

/// Reads what there is.
pub(super) fn read(array_index: &mut ArrayIndex, geometry: &mut Geometry) -> Result<(), IoError> {
    geometry.nodes = read_nodes(array_index)?;
    geometry.lines = read_lines(array_index)?;
    geometry.systems = read_systems(array_index)?;
    geometry.elements = read_elements(array_index)?;
    geometry.groups = read_groups(array_index)?;
    Ok(())
}

fn vector(values: &[f64]) -> Vector3 {
    Vector3::new(values[0], values[1], values[2])
}

fn read_nodes(array_index: &mut ArrayIndex) -> Result<Vec<Node>, IoError> {
    let Some(points) = array_index.texts("geometry/point", None)? else {
        return Ok(Vec::new());
    };
    let count = points.len();
    let at_m = array_index.needed_numbers("geometry/at_m", Some(&[count, 3]))?;
    let name = "geometry/displacement_system";
    let systems = array_index.numbers(name, Some(&[count]))?;
    let systems = systems.unwrap_or_else(|| vec![f64::NAN; count]);
    let nodes = points.into_iter().zip(at_m.chunks_exact(3)).zip(systems);
    let nodes = nodes.map(|((point, at_m), system)| {
        let mut node = Node::new(point, vector(at_m));
        if !system.is_nan() {
            let label = whole(system);
            let label = label.ok_or_else(|| array_index.error(name, system, "whole numbers"))?;
            node.displacement_system = Some(label);
        }
        Ok(node)
    });
    nodes.collect()
}

/// Cuts a flat list into rows of the stated lengths.
fn cut<T: Clone>(
    array_index: &ArrayIndex,
    name: &str,
    counts: &[i64],
    flat: &[T],
) -> Result<Vec<Vec<T>>, IoError> {
    let mut rest = flat;
    let mut rows = Vec::with_capacity(counts.len());
    for count in counts {
        let count = usize::try_from(*count)
            .ok()
            .filter(|count| *count <= rest.len());
        let count = count.ok_or_else(|| {
            array_index.error(
                name,
                format!("{} values", flat.len()),
                "as many as its counts say",
            )
        })?;
        let (row, after) = rest.split_at(count);
        rows.push(row.to_vec());
        rest = after;
    }
    if rest.is_empty() {
        Ok(rows)
    } else {
        Err(array_index.error(
            name,
            format!("{} values", flat.len()),
            "as many as its counts say",
        ))
    }
}

fn read_lines(array_index: &mut ArrayIndex) -> Result<Vec<TraceLine>, IoError> {
    let Some(names) = array_index.texts("geometry/line_name", None)? else {
        return Ok(Vec::new());
    };
    let counts = array_index.needed_whole("geometry/line_count", Some(&[names.len()]))?;
    let points = array_index.needed_texts("geometry/line_point", None)?;
    let points = points
        .into_iter()
        .map(|point| Some(point).filter(|point| !point.is_empty()));
    let points: Vec<Option<String>> = points.collect();
    let rows = cut(array_index, "geometry/line_point", &counts, &points)?;
    let lines = names.into_iter().zip(rows);
    Ok(lines
        .map(|(name, points)| TraceLine { name, points })
        .collect())
}

fn read_systems(array_index: &mut ArrayIndex) -> Result<Vec<CoordinateSystem>, IoError> {
    if array_index.place("geometry/system_label").is_none() {
        return Ok(Vec::new());
    }
    let labels = array_index.needed_whole("geometry/system_label", None)?;
    let count = labels.len();
    let names = array_index.needed_texts("geometry/system_name", Some(&[count]))?;
    let kinds = array_index.needed_texts("geometry/system_kind", Some(&[count]))?;
    let origins = array_index.needed_numbers("geometry/system_origin_m", Some(&[count, 3]))?;
    let axes = array_index.needed_numbers("geometry/system_axes", Some(&[count, 3, 3]))?;
    let places = origins.chunks_exact(3).zip(axes.chunks_exact(9));
    let systems = labels.into_iter().zip(names).zip(kinds).zip(places);
    let systems = systems.map(|(((label, name), kind), (origin, axes))| {
        let row = KINDS.iter().find(|row| row.1 == kind);
        let kind = row.ok_or_else(|| {
            array_index.error(
                "geometry/system_kind",
                format!("{kind:?}"),
                "cartesian, cylindrical or spherical",
            )
        })?;
        Ok(CoordinateSystem {
            label,
            name,
            kind: kind.0,
            origin_m: vector(origin),
            axes: [0, 3, 6].map(|first| vector(&axes[first..])),
        })
    });
    systems.collect()
}

fn read_elements(array_index: &mut ArrayIndex) -> Result<Vec<Element>, IoError> {
    if array_index.place("geometry/element_label").is_none() {
        return Ok(Vec::new());
    }
    let labels = array_index.needed_whole("geometry/element_label", None)?;
    let shape = [labels.len()];
    let count = Some(shape.as_slice());
    let descriptors = array_index.needed_whole("geometry/element_descriptor", count)?;
    let counts = array_index.needed_whole("geometry/element_count", count)?;
    let points = array_index.needed_texts("geometry/element_point", None)?;
    let rows = cut(array_index, "geometry/element_point", &counts, &points)?;
    let elements = labels.into_iter().zip(descriptors).zip(rows);
    let elements = elements.map(|((label, descriptor), points)| Element {
        label,
        descriptor,
        points,
    });
    Ok(elements.collect())
}

fn read_groups(array_index: &mut ArrayIndex) -> Result<Vec<Group>, IoError> {
    if array_index.place("geometry/group_label").is_none() {
        return Ok(Vec::new());
    }
    let labels = array_index.needed_whole("geometry/group_label", None)?;
    let shape = [labels.len()];
    let count = Some(shape.as_slice());
    let names = array_index.needed_texts("geometry/group_name", count)?;
    let counts = array_index.needed_whole("geometry/group_count", count)?;
    let types = array_index.needed_whole("geometry/group_type", None)?;
    let members = array_index.needed_whole("geometry/group_member", Some(&[types.len()]))?;
    let members: Vec<(i64, i64)> = types.into_iter().zip(members).collect();
    let rows = cut(array_index, "geometry/group_member", &counts, &members)?;
    let groups = labels.into_iter().zip(names).zip(rows);
    let groups = groups.map(|((label, name), members)| Group {
        label,
        name,
        members,
    });
    Ok(groups.collect())
}

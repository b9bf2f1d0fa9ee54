//! Degrees of freedom of a test are matched with those of a theory by a list or by position, where
//! the names differ.

use std::path::Path;

use crate::correlate::{
    Alignment, DofMap, DofNames, LocatedModes, PairOptions, Similarity, align_known, align_nearest,
    mean_largest_mac,
};
use crate::error::Error;
use crate::finding::{Code, Finding, Location, Severity};
use crate::geometry::Geometry;
use crate::linalg::Vector3;
use crate::modal::ModalModel;
use crate::scene::{Theory, read_text};

use super::args::CorrelateArgs;

/// A theory under the names of the test.
pub struct MatchedTheory {
    /// The theory.
    pub theory: Theory,
    /// Model DOFs behind each test name; `None` where test and theory use the same names.
    pub names: Option<DofNames>,
    /// The frame that was fitted.
    pub alignment: Option<Alignment>,
}

/// The theory under the names of the test, where the names differ. Several tests must have the
/// names of the first one.
pub fn match_dofs(
    args: &CorrelateArgs,
    tests: &mut [(String, Theory)],
    theory: Theory,
    options: &PairOptions,
) -> Result<MatchedTheory, Error> {
    if let Some(path) = &args.dof_map {
        let has_shapes = has_shapes(&theory.modes);
        let matched = rename_theory(read_dof_list(path, "--dof-map")?, theory, None);
        if has_shapes {
            check_list(path, &matched)?;
        }
        return Ok(matched);
    }
    let (Some(tolerance), Some((_, first))) = (args.nearest_node, tests.first_mut()) else {
        return Ok(MatchedTheory {
            theory,
            names: None,
            alignment: None,
        });
    };
    check_nodes(&args.test[0], &first.geometry)?;
    check_nodes(
        args.theory.as_deref().unwrap_or(Path::new("")),
        &theory.geometry,
    )?;
    let alignment = match &args.align {
        None => None,
        Some(list) => Some(fit_alignment(
            list.as_deref(),
            first,
            &theory,
            tolerance,
            options,
        )?),
    };
    let frame = alignment.as_ref().map(Alignment::similarity);
    let (names, findings) = DofNames::nearest(
        &located(first),
        &located(&theory),
        &frame.unwrap_or_else(Similarity::identity),
        tolerance,
    )?;
    first
        .modes
        .findings
        .extend(alignment.as_ref().map(alignment_finding));
    first.modes.findings.extend(findings);
    Ok(rename_theory(names, theory, alignment))
}

fn located(modes: &Theory) -> LocatedModes<'_> {
    LocatedModes {
        modes: &modes.modes,
        geometry: &modes.geometry,
    }
}

fn rename_theory(names: DofNames, theory: Theory, alignment: Option<Alignment>) -> MatchedTheory {
    MatchedTheory {
        theory: Theory {
            modes: names.rename(&theory.modes),
            ..theory
        },
        names: Some(names),
        alignment,
    }
}

fn read_dof_list(path: &Path, argument: &'static str) -> Result<DofNames, Error> {
    let text = read_text(path)?;
    DofNames::parse(&text).map_err(|error| Error::Argument {
        argument,
        got: format!("{}: {error}", path.display()),
        expected: "a file with a line TEST,THEORY for each pair".to_owned(),
    })
}

fn has_shapes(model: &ModalModel) -> bool {
    model.modes.iter().any(|mode| !mode.shape.is_empty())
}

/// Checks that a list names a degree of freedom at which a mode of the theory has a value.
fn check_list(path: &Path, matched: &MatchedTheory) -> Result<(), Error> {
    if has_shapes(&matched.theory.modes) {
        return Ok(());
    }
    let names = matched.names.iter().flat_map(DofNames::points);
    let points: Vec<&str> = names.map(|(_, theory)| theory).take(4).collect();
    Err(Error::Argument {
        argument: "--dof-map",
        got: format!(
            "{}, which names no degree of freedom of the model (its points: {}, ...)",
            path.display(),
            points.join(", ")
        ),
        expected: "lines TEST,THEORY with the names of the model second".to_owned(),
    })
}

/// The test's frame fitted to the theory's by a list of partners, or by the nearest points.
fn fit_alignment(
    path: Option<&Path>,
    test: &Theory,
    theory: &Theory,
    tolerance_m: f64,
    options: &PairOptions,
) -> Result<Alignment, Error> {
    let Some(path) = path else {
        let (test, theory) = (located(test), located(theory));
        let positions = [test, theory].map(|modes| modes.sensor_positions());
        let fitted = align_nearest(&positions[0], &positions[1], tolerance_m)?;
        return Ok(fitted.selected_by_shapes(|frame| {
            mean_largest_mac(&test, &theory, frame, tolerance_m, options)
        }));
    };
    let names = read_dof_list(path, "--align")?;
    let position = |geometry: &Geometry, point: &str| geometry.node(point).map(|node| node.at_m);
    let both = |(measured, other): &(&str, &str)| {
        Some((
            position(&test.geometry, measured)?,
            position(&theory.geometry, other)?,
        ))
    };
    let pairs: Vec<(Vector3, Vector3)> = names.points().iter().filter_map(both).collect();
    Ok(align_known(&pairs, tolerance_m)?)
}

/// The fitted frame as a finding: a warning where its scale is no ratio of units, and where shapes
/// do not select among frames that fit equally well.
fn alignment_finding(alignment: &Alignment) -> Finding {
    let others = alignment.as_good_by_shape();
    let not_compared = alignment.as_good.saturating_sub(alignment.others.len());
    let is_undecided = match alignment.mean_mac {
        Some(_) => others > 0 || not_compared > 0,
        None => alignment.as_good > 0,
    };
    let is_odd = !alignment.has_unit_scale() && !alignment.known;
    let severity = match is_undecided || is_odd {
        true => Severity::Warning,
        false => Severity::Info,
    };
    let finding = Finding::new(severity, Code::NodesAligned, Location::Whole);
    let finding = finding.value(alignment.scale, "");
    let mut details = Vec::new();
    if is_odd {
        details.push("no ratio of units of length".to_owned());
    }
    if alignment.as_good > 0 && !alignment.known {
        details.push(format!(
            "other frames that fit as well: {}",
            alignment.as_good
        ));
    }
    if not_compared > 0 && alignment.mean_mac.is_some() {
        details.push(format!(
            "shapes not compared in {not_compared} of them, those of larger rotations"
        ));
    }
    let next = alignment.others.first().and_then(|other| other.mean_mac);
    if let (Some(mac), Some(next)) = (alignment.mean_mac, next) {
        details.push(match others {
            0 => format!("the shapes select this one, mean MAC {mac:.3}, next {next:.3}"),
            _ => format!("{others} of them with the same mean MAC, {mac:.3}"),
        });
    }
    match details.is_empty() {
        true => finding,
        false => finding.detail(details.join("; ")),
    }
}

fn check_nodes(path: &Path, geometry: &Geometry) -> Result<(), Error> {
    if !geometry.nodes.is_empty() {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "--nearest-node",
        got: format!("{} without a position of any point", path.display()),
        expected: "a file with nodes (universal datasets 15 or 2411), or a model with sensors at positions".to_owned(),
    })
}

/// Whether the test has shapes, and none of its degrees of freedom is one of the theory.
pub fn has_no_common_dof(test: &ModalModel, theory: &ModalModel) -> bool {
    let map = DofMap::of_models(test, theory);
    map.is_empty() && !map.test_alone.is_empty()
}

/// Checks that shapes of test and theory have a degree of freedom in common.
pub fn check_common_dofs(name: &str, test: &ModalModel, theory: &ModalModel) -> Result<(), Error> {
    let example = |model: &ModalModel| {
        let mut shapes = model.modes.iter().flat_map(|mode| mode.shape.iter());
        shapes.next().map(|(dof, _)| dof.to_string())
    };
    let (Some(in_test), Some(in_theory)) = (example(test), example(theory)) else {
        return Ok(());
    };
    // A test whose DOFs are all unmeasured is paired by frequency, with a finding.
    let map = DofMap::of_models(test, theory);
    if !map.is_empty() || map.test_alone.is_empty() {
        return Ok(());
    }
    Err(Error::Argument {
        argument: "--test",
        got: format!(
            "{name}, which has no degree of freedom in common with the theory ({in_test}, ... and {in_theory}, ...)"
        ),
        expected: "common names; or tie them with --dof-map FILE or --nearest-node METRES"
            .to_owned(),
    })
}

//! The modal model is formed from candidates: this removes the damping of an exponential window,
//! and adds shapes, groups of repeated poles, and modal overlap.

use std::collections::BTreeMap;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::modal::{
    ModalModel, Mode, ModeShape, Pole, mean_phase, mean_phase_deviation, modal_phase_collinearity,
};

use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, PoleTable};
use crate::identify::modes::quality;
use crate::identify::modes::rank_one_terms;
use crate::identify::modes::shape::{self, Residues, ScaledShape, ShapedTerm};
use crate::linalg::sort_ascending_by;
use crate::quantity::FrfKind;

/// Maximum relative residual of one shape for the residues of one mode at several references.
const MAX_SHAPE_MISFIT: f64 = 0.25;

/// The modal model of a table of candidates. `scales` has what each FRF was multiplied by.
///
/// # Errors
/// [`IdentifyError::Linalg`] when singular values do not converge.
pub(in crate::identify) fn modal_model(
    set: &FrfSet,
    scales: &[f64],
    band: Band,
    method: &'static str,
    table: PoleTable,
) -> Result<ModalModel, IdentifyError> {
    let added = set.added_damping_rad_s;
    let mut findings = table.findings;
    let natural_hz = |candidate: &Candidate| {
        let pole = candidate.pole.without_added_damping(added);
        pole.natural_frequency_hz()
    };
    findings.extend(quality::findings(&table.candidates, natural_hz));
    let mut modes_by_pole: Vec<Vec<Mode>> = Vec::with_capacity(table.candidates.len());
    let results: Vec<_> = table
        .candidates
        .par_iter()
        .map(|candidate| modes_of_pole(set, scales, method, candidate))
        .collect();
    for (candidate, result) in table.candidates.iter().zip(results) {
        let (mut modes, finding) = result?;
        let lines = candidate.pole.half_power_width_hz() / set.axis().step_hz;
        modes
            .iter_mut()
            .for_each(|mode| mode.half_power_lines = Some(lines));
        modes_by_pole.push(modes);
        findings.extend(finding);
    }
    sort_ascending_by(&mut modes_by_pole, |modes| modes[0].frequency_hz);
    let repeated = modes_by_pole.iter_mut().filter(|modes| modes.len() > 1);
    for (group, modes) in (1..).zip(repeated) {
        modes.iter_mut().for_each(|mode| mode.group = Some(group));
    }
    set_modal_overlap(&mut modes_by_pole);
    let modes: Vec<Mode> = modes_by_pole.into_iter().flatten().collect();
    findings.extend(quality::complex_shapes(&modes));
    let mut model = ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        inputs: Vec::new(),
        band: Some(band),
        references: set.references(),
        added_damping_rad_s: (added > 0.0).then_some(added),
        modes,
        findings,
    };
    quality::assess(&mut model);
    Ok(model)
}

/// Sets the modal overlap of every mode with a neighbour: half-power bandwidth over the mean
/// distance to the poles on either side; 1 or more where resonances overlap.
fn set_modal_overlap(modes_by_pole: &mut [Vec<Mode>]) {
    let hz: Vec<f64> = modes_by_pole
        .iter()
        .map(|modes| modes[0].frequency_hz)
        .collect();
    for (j, modes) in modes_by_pole.iter_mut().enumerate() {
        let below = j.checked_sub(1).map(|i| hz[j] - hz[i]);
        let above = hz.get(j + 1).map(|next| next - hz[j]);
        let distance = match (below, above) {
            (Some(a), Some(b)) => Some(0.5 * (a + b)),
            (one, other) => one.or(other),
        };
        for mode in modes {
            let width = mode.pole().map(|pole| pole.half_power_width_hz());
            let overlap = width
                .zip(distance)
                .map(|(width, distance)| width / distance);
            mode.modal_overlap = overlap.filter(|value| value.is_finite());
        }
    }
}

/// The modes of one pole, with their findings.
fn modes_of_pole(
    set: &FrfSet,
    scales: &[f64],
    method: &'static str,
    candidate: &Candidate,
) -> Result<(Vec<Mode>, Vec<Finding>), IdentifyError> {
    let pole = candidate
        .pole
        .without_added_damping(set.added_damping_rad_s);
    let ResiduesByQuantity {
        of_shape: residues,
        group,
        others,
    } = ResiduesByQuantity::new(set, scales, candidate);
    let has_motion = group.is_none();
    let stds = candidate.residue_stds.as_ref().map(|stds| {
        let functions = set.functions().iter().zip(stds.iter().zip(scales));
        functions
            .map(|(function, (std, scale))| {
                ((&function.response, &function.reference), std / scale)
            })
            .collect()
    });
    let frequency_hz = pole.natural_frequency_hz();
    let warning = |code, value: f64, limit: f64| {
        Finding::new(Severity::Warning, code, Location::Mode(frequency_hz))
            .value(value, "")
            .limit(limit)
    };
    let mut findings = Vec::new();
    let damped_rad_s = pole.lambda.im;
    let terms: Vec<ShapedTerm> = if candidate.multiplicity > 1 {
        let terms =
            rank_one_terms::decompose_residues(&residues, candidate.multiplicity, damped_rad_s)?;
        let shaped = terms.into_iter().map(|term| ShapedTerm {
            scaled: match term.reciprocal && has_motion {
                true => shape::shape_of(&term.residues, damped_rad_s),
                false => shape::unit_max_shape_of(&term.residues),
            },
            residues: term.residues,
        });
        shaped.collect()
    } else {
        let scaled = match has_motion {
            true => shape::shape_of(&residues, damped_rad_s),
            false => shape::unit_max_shape_of(&residues),
        };
        if let Some(misfit) = scaled.misfit.filter(|misfit| *misfit > MAX_SHAPE_MISFIT) {
            findings.push(warning(Code::CloseModes, misfit, MAX_SHAPE_MISFIT));
        }
        vec![ShapedTerm { residues, scaled }]
    };
    let mut other_shapes: Vec<BTreeMap<String, ModeShape>> = vec![BTreeMap::new(); terms.len()];
    for (group, residues) in &others {
        let shapes = shape::other_components(&terms, residues, damped_rad_s);
        for (other_shapes, shape) in other_shapes.iter_mut().zip(shapes) {
            if !shape.is_empty() {
                other_shapes.insert((*group).to_owned(), shape);
            }
        }
    }
    let is_distinct = terms.len() == 1;
    let of_others = others.into_values().flatten().filter(|_| is_distinct);
    let of_others: Residues = of_others.collect();
    let modes = terms.into_iter().zip(other_shapes);
    let modes = modes.map(|(term, other_shapes)| {
        let ShapedTerm { residues, scaled } = term;
        let mut mode = mode(&stds, method, candidate, pole, residues, scaled);
        mode.other_shapes = other_shapes;
        mode.residues.extend(of_others.clone());
        match group {
            Some(group) => without_motion(mode, group),
            None => mode,
        }
    });
    let modes = modes.collect();
    let damping = pole.damping_ratio();
    if damping <= 0.0 {
        findings.push(warning(Code::DampingNotPositive, damping, 0.0));
    }
    Ok((modes, findings))
}

/// Standard deviations of residues by (response, reference).
type ResidueStds<'a> = Option<BTreeMap<(&'a Dof, &'a Dof), f64>>;

/// Residues of the shape and of the responses of other quantities, by group.
struct ResiduesByQuantity {
    /// Those of the motion; without any, those of the group with the most FRFs.
    of_shape: Residues,
    /// That group.
    group: Option<&'static str>,
    others: BTreeMap<&'static str, Residues>,
}

impl ResiduesByQuantity {
    fn new(set: &FrfSet, scales: &[f64], candidate: &Candidate) -> Self {
        let mut of_shape = Residues::new();
        let mut others: BTreeMap<&'static str, Residues> = BTreeMap::new();
        let residues = candidate.residues.as_deref().unwrap_or_default();
        for ((function, scale), residue) in set.functions().iter().zip(scales).zip(residues) {
            let group = match function.kind {
                FrfKind::Other(other) => others.entry(other.group()).or_default(),
                _ => &mut of_shape,
            };
            let pair = (function.response.clone(), function.reference.clone());
            group.insert(pair, residue / scale);
        }
        let largest = others.iter().max_by_key(|(_, residues)| residues.len());
        let group = largest.map(|(group, _)| *group);
        let group = group.filter(|_| of_shape.is_empty());
        if let Some(residues) = group.and_then(|group| others.remove(group)) {
            of_shape = residues;
        }
        Self {
            of_shape,
            group,
            others,
        }
    }
}

/// A mode without any response of motion: its shape is that of this group, unless it is one over
/// the points of a roving hammer.
fn without_motion(mode: Mode, group: &str) -> Mode {
    let is_response = |(response, _): &(Dof, Dof)| mode.shape.get(response).is_some();
    if !mode.residues.keys().any(is_response) {
        return mode;
    }
    let mut other_shapes = mode.other_shapes;
    other_shapes.insert(group.to_owned(), mode.shape);
    Mode {
        shape: ModeShape::default(),
        other_shapes,
        shape_std: None,
        mpc: None,
        mean_phase_rad: None,
        mean_phase_deviation_rad: None,
        ..mode
    }
}

fn mode(
    residue_stds: &ResidueStds,
    method: &'static str,
    candidate: &Candidate,
    pole: Pole,
    residues: Residues,
    scaled: ScaledShape,
) -> Mode {
    let ScaledShape {
        shape,
        scaling,
        modal_mass_kg,
        ..
    } = scaled;
    let components: Vec<Complex64> = shape.iter().map(|(_, value)| value).collect();
    let damping = Some(pole.damping_ratio()).filter(|damping| *damping > 0.0);
    let stds = residue_stds.as_ref();
    let shape_std = stds.and_then(|stds| shape::shape_stds(stds, &residues, &shape));
    Mode {
        shape_std,
        frequency_std_hz: candidate.frequency_std_hz,
        damping_std: damping.and(candidate.damping_std),
        frequency_damping_correlation: damping.and(candidate.frequency_damping_correlation),
        frequency_bias_hz: candidate.frequency_bias_hz,
        damping_bias: damping.and(candidate.damping_bias),
        residues,
        modal_mass_kg,
        mpc: modal_phase_collinearity(&components),
        method: Some(method.to_owned()),
        order: candidate.order,
        mean_phase_rad: mean_phase(&components),
        mean_phase_deviation_rad: mean_phase_deviation(&components),
        ..Mode::new(pole.natural_frequency_hz(), damping, shape, scaling)
    }
}

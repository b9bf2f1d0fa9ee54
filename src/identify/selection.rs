//! From candidates to modes: the references that were asked for, poles without the window's damping, shapes.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::{FrfSet, FunctionData};
use crate::modal::{ModalModel, Mode, modal_phase_collinearity};

use super::shape::{self, ScaledShape};
use super::{Candidate, IdentifyError, PoleTable};

/// Share of the residues of one mode that several references may leave unexplained by one shape.
const MOST_MISFIT: f64 = 0.25;

/// The functions of the given references alone; `None` when all are wanted.
///
/// # Errors
/// [`IdentifyError::UnknownReference`] for one that no function has.
pub(super) fn with_references(
    set: &FrfSet,
    references: Option<&[Dof]>,
) -> Result<Option<FrfSet>, IdentifyError> {
    let Some(references) = references else {
        return Ok(None);
    };
    let known = set.references();
    if let Some(got) = references.iter().find(|dof| !known.contains(dof)) {
        return Err(IdentifyError::UnknownReference {
            got: got.clone(),
            known,
        });
    }
    let mut chosen = FrfSet::new(*set.axis());
    chosen.added_damping_rad_s = set.added_damping_rad_s;
    chosen.record_duration_s = set.record_duration_s;
    chosen.valid_band = set.valid_band;
    for (i, function) in set.functions().iter().enumerate() {
        if references.contains(&function.reference) {
            let data = FunctionData {
                values: set.values(i).to_vec(),
                coherence: set.coherence(i).map(<[f64]>::to_vec),
                variance: set.variance(i).map(<[f64]>::to_vec),
            };
            chosen
                .push(function.clone(), data)
                .expect("the functions of a set are of one length and differ");
        }
    }
    Ok(Some(chosen))
}

/// The modal model of a table of candidates.
pub(super) fn modal_model(
    set: &FrfSet,
    band: Band,
    method: &'static str,
    table: PoleTable,
) -> ModalModel {
    let added = set.added_damping_rad_s;
    let mut findings = table.findings;
    let mut modes: Vec<Mode> = Vec::with_capacity(table.candidates.len());
    for candidate in &table.candidates {
        let (mode, finding) = mode(set, method, candidate);
        modes.push(mode);
        findings.extend(finding);
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        inputs: Vec::new(),
        band: Some(band),
        references: set.references(),
        added_damping_rad_s: (added > 0.0).then_some(added),
        modes,
        findings,
    }
}

fn mode(set: &FrfSet, method: &'static str, candidate: &Candidate) -> (Mode, Vec<Finding>) {
    let pole = candidate
        .pole
        .without_added_damping(set.added_damping_rad_s);
    let residues = by_pair(set, candidate.residues.as_deref().unwrap_or_default());
    let ScaledShape {
        shape,
        scaling,
        modal_mass_kg,
        misfit,
    } = shape::shape_of(&residues, pole.lambda.im);
    let frequency_hz = pole.natural_frequency_hz();
    let warning = |code| Finding::new(Severity::Warning, code, Place::Mode(frequency_hz));
    let mut findings = Vec::new();
    if let Some(misfit) = misfit.filter(|misfit| *misfit > MOST_MISFIT) {
        findings.push(
            warning(Code::CloseModes)
                .value(misfit, "")
                .limit(MOST_MISFIT),
        );
    }
    let damping = pole.damping_ratio();
    if damping <= 0.0 {
        findings.push(
            warning(Code::DampingNotPositive)
                .value(damping, "")
                .limit(0.0),
        );
    }
    let components: Vec<Complex64> = shape.iter().map(|(_, value)| value).collect();
    let damping = (damping > 0.0).then_some(damping);
    let mode = Mode {
        frequency_std_hz: candidate.frequency_std_hz,
        damping_std: damping.and(candidate.damping_std),
        residues,
        modal_mass_kg,
        mpc: modal_phase_collinearity(&components),
        method: Some(method.to_owned()),
        order: candidate.order,
        ..Mode::new(frequency_hz, damping, shape, scaling)
    };
    (mode, findings)
}

fn by_pair(set: &FrfSet, residues: &[Complex64]) -> BTreeMap<(Dof, Dof), Complex64> {
    let pair = set.functions().iter().zip(residues);
    pair.map(|(f, a)| ((f.response.clone(), f.reference.clone()), *a))
        .collect()
}

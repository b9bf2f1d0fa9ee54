//! From candidates to modes: the references that were asked for, poles without the window's
//! damping, shapes.

use std::borrow::Cow;
use std::collections::BTreeMap;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::axis::Band;
use crate::dof::Dof;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::{FrfSet, Function};
use crate::modal::{
    ModalModel, Mode, Pole, mean_phase, mean_phase_deviation, modal_phase_collinearity,
};

use super::parts;
use super::receptance::{damaged, looked_at, no_band, whole_band};
use super::shape::{self, Residues, ScaledShape};
use super::{Candidate, IdentifyError, IdentifyOptions, PoleTable};

mod spikes;
mod turned;

use spikes::{filled, without_spikes};
use turned::turned_function;

/// Share of the residues of one mode that several references may leave unexplained by one shape.
const MOST_MISFIT: f64 = 0.25;

/// Most rounds in which spikes are sought.
const ROUNDS: usize = 3;

/// What an identification looks at.
pub(super) struct Chosen<'a> {
    pub set: Cow<'a, FrfSet>,
    pub band: Band,
    /// Of what was left out or replaced.
    pub findings: Vec<Finding>,
}

/// The functions of the references that the options name, and the band: that of the options, else
/// the set's valid band, else its axis; as far as there are lines. Lines without any value and
/// spikes are replaced by what their neighbours say ([`spikes`]).
///
/// # Errors
/// [`IdentifyError::UnknownReference`] for one that no function has; [`IdentifyError::TooFewLines`]
/// for an axis without any band.
pub(super) fn chosen<'a>(
    set: &'a FrfSet,
    options: &IdentifyOptions,
) -> Result<Chosen<'a>, IdentifyError> {
    let mut set = Cow::Borrowed(set);
    if let Some(references) = &options.references {
        let known = set.references();
        if let Some(got) = references.iter().find(|dof| !known.contains(dof)) {
            return Err(IdentifyError::UnknownReference {
                got: got.clone(),
                known,
            });
        }
        let of_them = |i: &usize| references.contains(&set.functions()[*i].reference);
        let own: Vec<usize> = (0..set.len()).filter(of_them).collect();
        set = Cow::Owned(set.part(&own));
    }
    let band = options.band.or(set.valid_band);
    let band = band.or_else(|| whole_band(&set));
    let band = band.ok_or_else(|| no_band(&set))?;
    let (band, mut findings) = cut(&set, band);
    findings.extend(ends_without_numbers(&set, band));
    if let Some((filled, blanks)) = filled(&set, looked_at(&set, band)) {
        set = Cow::Owned(filled);
        findings.extend(blanks);
    }
    if options.partial {
        let damaged = damaged(&set, band);
        let sound = (0..set.len()).filter(|i| !damaged.contains_key(i));
        let sound: Vec<usize> = sound.collect();
        // Of nothing but damage, the error says what it is.
        if !damaged.is_empty() && !sound.is_empty() {
            let left_out = |(i, hz): (&usize, &f64)| left_out(&set.functions()[*i], *hz);
            findings.extend(damaged.iter().map(left_out));
            set = Cow::Owned(set.part(&sound));
        }
    }
    // A weak line beside a strong one is seen when that is gone.
    for _ in 0..ROUNDS {
        let Some((without, spikes)) = without_spikes(&set, looked_at(&set, band)) else {
            break;
        };
        set = Cow::Owned(without);
        findings.extend(spikes);
    }
    Ok(Chosen {
        set,
        band,
        findings,
    })
}

/// A band without what lies beyond the lines by half a step or more, and what was cut off; one
/// beside the lines, or none, stays as it is.
fn cut(set: &FrfSet, band: Band) -> (Band, Vec<Finding>) {
    let inside = |whole: &Band| {
        let lo_hz = band.lo_hz.max(whole.lo_hz);
        Band::new(lo_hz, band.hi_hz.min(whole.hi_hz)).ok()
    };
    let legal = Band::new(band.lo_hz, band.hi_hz).ok();
    let whole = legal.and_then(|_| whole_band(set));
    let Some((whole, own)) = whole.and_then(|whole| Some((whole, inside(&whole)?))) else {
        return (band, Vec::new());
    };
    // From 0 Hz on is from the first line above it.
    let slack = 0.5 * set.axis().step_hz;
    let low = band.lo_hz < whole.lo_hz - slack && set.axis().start_hz > 0.0;
    let high = band.hi_hz > whole.hi_hz + slack;
    let finding = |stated: f64, limit: f64| {
        let finding = Finding::new(Severity::Warning, Code::BandCut, Place::Whole);
        finding.value(stated, "Hz").limit(limit)
    };
    let ends = [
        low.then(|| finding(band.lo_hz, whole.lo_hz)),
        high.then(|| finding(band.hi_hz, whole.hi_hz)),
    ];
    let findings: Vec<Finding> = ends.into_iter().flatten().collect();
    match findings.is_empty() {
        true => (band, findings),
        false => (own, findings),
    }
}

/// The findings of a band at whose ends no function has a number: those lines are left out.
fn ends_without_numbers(set: &FrfSet, band: Band) -> Vec<Finding> {
    let lines = set.axis().lines(&band);
    let none = |k: &usize| (0..set.len()).all(|i| !set.values(i)[*k].is_finite());
    let hz = |k: usize| set.axis().hz(k);
    // Derivatives have no value at 0 Hz, and nobody looks there.
    let first = lines.clone().find(|k| hz(*k) > 0.0 && !none(k));
    let last = lines.clone().rev().find(|k| !none(k));
    let (Some(first), Some(last)) = (first, last) else {
        return Vec::new();
    };
    let finding = |end: usize, limit: usize| {
        let finding = Finding::new(Severity::Warning, Code::BandCut, Place::Whole);
        finding.value(hz(end), "Hz").limit(hz(limit))
    };
    let begin = lines.clone().find(|k| hz(*k) > 0.0);
    let low = begin.filter(|begin| *begin < first);
    let high = Some(lines.end - 1).filter(|end| *end > last);
    let low = low.map(|begin| finding(begin, first));
    low.into_iter()
        .chain(high.map(|end| finding(end, last)))
        .collect()
}

fn left_out(function: &Function, hz: f64) -> Finding {
    let place = Place::Function {
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
    };
    Finding::new(Severity::Error, Code::ValueNotFinite, place).value(hz, "Hz")
}

/// The modal model of a table of candidates.
///
/// # Errors
/// [`IdentifyError::Linalg`] when singular values do not converge.
pub(super) fn modal_model(
    set: &FrfSet,
    band: Band,
    method: &'static str,
    table: PoleTable,
) -> Result<ModalModel, IdentifyError> {
    let added = set.added_damping_rad_s;
    let mut findings = table.findings;
    findings.extend(turned_function(set, &table.candidates));
    let mut roots: Vec<Vec<Mode>> = Vec::with_capacity(table.candidates.len());
    let own: Vec<_> = table
        .candidates
        .par_iter()
        .map(|candidate| modes_of_root(set, method, candidate))
        .collect();
    for (candidate, own) in table.candidates.iter().zip(own) {
        let (mut modes, finding) = own?;
        let lines = candidate.pole.half_power_width_hz() / set.axis().step_hz;
        modes
            .iter_mut()
            .for_each(|mode| mode.half_power_lines = Some(lines));
        roots.push(modes);
        findings.extend(finding);
    }
    roots.sort_by(|a, b| a[0].frequency_hz.total_cmp(&b[0].frequency_hz));
    let repeated = roots.iter_mut().filter(|modes| modes.len() > 1);
    for (group, modes) in (1..).zip(repeated) {
        modes.iter_mut().for_each(|mode| mode.group = Some(group));
    }
    put_overlap(&mut roots);
    let modes = roots.into_iter().flatten().collect();
    Ok(ModalModel {
        producer: concat!("modalign ", env!("CARGO_PKG_VERSION")).to_owned(),
        inputs: Vec::new(),
        band: Some(band),
        references: set.references(),
        added_damping_rad_s: (added > 0.0).then_some(added),
        modes,
        findings,
    })
}

/// Half-power width over the mean distance to the roots on either side, of every mode with a
/// neighbour: 1 and more where resonances run into each other.
fn put_overlap(roots: &mut [Vec<Mode>]) {
    let hz: Vec<f64> = roots.iter().map(|modes| modes[0].frequency_hz).collect();
    for (j, modes) in roots.iter_mut().enumerate() {
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

/// The modes of one pole, with what is to be said of them.
fn modes_of_root(
    set: &FrfSet,
    method: &'static str,
    candidate: &Candidate,
) -> Result<(Vec<Mode>, Vec<Finding>), IdentifyError> {
    let pole = candidate
        .pole
        .without_added_damping(set.added_damping_rad_s);
    let residues = by_pair(set, candidate.residues.as_deref().unwrap_or_default());
    let residues: Residues = residues
        .into_iter()
        .map(|((response, reference), a)| ((response.clone(), reference.clone()), a))
        .collect();
    let frequency_hz = pole.natural_frequency_hz();
    let warning = |code, value: f64, limit: f64| {
        Finding::new(Severity::Warning, code, Place::Mode(frequency_hz))
            .value(value, "")
            .limit(limit)
    };
    let mut findings = Vec::new();
    let modes = if candidate.multiplicity > 1 {
        let parts = parts::parts(&residues, candidate.multiplicity, pole.lambda.im)?;
        let shaped = parts.into_iter().map(|part| {
            let scaled = match part.reciprocal {
                true => shape::shape_of(&part.residues, pole.lambda.im),
                false => shape::unit_max_shape_of(&part.residues),
            };
            mode((set, method), candidate, pole, (part.residues, scaled))
        });
        shaped.collect()
    } else {
        let scaled = shape::shape_of(&residues, pole.lambda.im);
        if let Some(misfit) = scaled.misfit.filter(|misfit| *misfit > MOST_MISFIT) {
            findings.push(warning(Code::CloseModes, misfit, MOST_MISFIT));
        }
        vec![mode((set, method), candidate, pole, (residues, scaled))]
    };
    let damping = pole.damping_ratio();
    if damping <= 0.0 {
        findings.push(warning(Code::DampingNotPositive, damping, 0.0));
    }
    Ok((modes, findings))
}

fn mode(
    (set, method): (&FrfSet, &'static str),
    candidate: &Candidate,
    pole: Pole,
    (residues, scaled): (Residues, ScaledShape),
) -> Mode {
    let ScaledShape {
        shape,
        scaling,
        modal_mass_kg,
        ..
    } = scaled;
    let components: Vec<Complex64> = shape.iter().map(|(_, value)| value).collect();
    let damping = Some(pole.damping_ratio()).filter(|damping| *damping > 0.0);
    let stds = candidate.residue_stds.as_deref();
    let shape_std = stds.and_then(|stds| shape::deviations(&by_pair(set, stds), &residues, &shape));
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

fn by_pair<'a, T: Copy>(set: &'a FrfSet, values: &[T]) -> BTreeMap<(&'a Dof, &'a Dof), T> {
    let pairs = set.functions().iter().zip(values);
    pairs
        .map(|(f, a)| ((&f.response, &f.reference), *a))
        .collect()
}

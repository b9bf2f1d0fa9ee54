//! The FRFs that an identification reads: references that were asked for, the band cut to the
//! data, missing lines and outlier lines interpolated, FRFs without values rejected.

use std::borrow::Cow;

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::{FrfSet, Function};

use crate::identify::data::band_frfs::{
    frfs_with_invalid_values, guarded_lines, no_band_error, whole_band,
};
use crate::identify::data::other_responses;
use crate::identify::data::outlier_lines::{interpolate_missing_lines, replace_outlier_lines};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::IdentifyOptions;

/// Maximum number of passes that search for outlier lines.
const MAX_OUTLIER_PASSES: usize = 3;

/// FRFs and band that an identification reads.
pub(in crate::identify) struct Chosen<'a> {
    pub set: Cow<'a, FrfSet>,
    pub band: Band,
    /// What each FRF was multiplied by.
    pub scales: Vec<f64>,
    /// Findings on rejected FRFs and on replaced lines.
    pub findings: Vec<Finding>,
}

/// Selects the FRFs of the references that the options name, and the band: that of the options,
/// else the set's valid band, else its axis; cut to the lines of the set. Missing lines and outlier
/// lines are interpolated from their neighbours (`outlier_lines`); responses of other quantities
/// are scaled to the motion (`other_responses`).
///
/// # Errors
/// [`IdentifyError::UnknownReference`] for one that no FRF has; [`IdentifyError::TooFewLines`]
/// for an axis without any band.
pub(in crate::identify) fn chosen<'a>(
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
        let is_selected = |i: &usize| references.contains(&set.functions()[*i].reference);
        let selected: Vec<usize> = (0..set.len()).filter(is_selected).collect();
        set = Cow::Owned(set.part(&selected));
    }
    let band = options.band.or(set.valid_band);
    let band = band.or_else(|| whole_band(&set));
    let band = band.ok_or_else(|| no_band_error(&set))?;
    let (band, mut findings) = cut_to_axis(&set, band);
    findings.extend(findings_on_missing_ends(&set, band));
    if let Some((filled, missing)) = interpolate_missing_lines(&set, guarded_lines(&set, band)) {
        set = Cow::Owned(filled);
        findings.extend(missing);
    }
    if options.partial {
        let damaged = frfs_with_invalid_values(&set, band);
        let sound = (0..set.len()).filter(|i| !damaged.contains_key(i));
        let sound: Vec<usize> = sound.collect();
        // Where every FRF is damaged, the identification fails with an error that names the value.
        if !damaged.is_empty() && !sound.is_empty() {
            let finding = |(i, hz): (&usize, &f64)| invalid_frf_finding(&set.functions()[*i], *hz);
            findings.extend(damaged.iter().map(finding));
            set = Cow::Owned(set.part(&sound));
        }
    }
    // A weak outlier next to a strong one is detected once that is replaced.
    for _ in 0..MAX_OUTLIER_PASSES {
        let Some((without, spikes)) = replace_outlier_lines(&set, guarded_lines(&set, band)) else {
            break;
        };
        set = Cow::Owned(without);
        findings.extend(spikes);
    }
    let scales = other_responses::scales(&set, band);
    if !set
        .functions()
        .iter()
        .all(|function| function.kind.is_motion())
    {
        set = Cow::Owned(set.scaled(|i| scales[i]));
    }
    Ok(Chosen {
        set,
        band,
        scales,
        findings,
    })
}

/// The part of a band inside the lines, with findings where half a step or more is cut off; a band
/// outside the lines, or an invalid one, is returned unchanged.
fn cut_to_axis(set: &FrfSet, band: Band) -> (Band, Vec<Finding>) {
    let inside = |whole: &Band| {
        let lo_hz = band.lo_hz.max(whole.lo_hz);
        Band::new(lo_hz, band.hi_hz.min(whole.hi_hz)).ok()
    };
    let legal = Band::new(band.lo_hz, band.hi_hz).ok();
    let whole = legal.and_then(|_| whole_band(set));
    let Some((whole, cut_band)) = whole.and_then(|whole| Some((whole, inside(&whole)?))) else {
        return (band, Vec::new());
    };
    // A band from 0 Hz begins at the first line above it.
    let slack = 0.5 * set.axis().step_hz;
    let low = band.lo_hz < whole.lo_hz - slack && set.axis().start_hz > 0.0;
    let high = band.hi_hz > whole.hi_hz + slack;
    let finding = |stated: f64, limit: f64| {
        let finding = Finding::new(Severity::Warning, Code::BandCut, Location::Whole);
        finding.value(stated, "Hz").limit(limit)
    };
    let ends = [
        low.then(|| finding(band.lo_hz, whole.lo_hz)),
        high.then(|| finding(band.hi_hz, whole.hi_hz)),
    ];
    let findings: Vec<Finding> = ends.into_iter().flatten().collect();
    match findings.is_empty() {
        true => (band, findings),
        false => (cut_band, findings),
    }
}

/// The findings of a band at whose ends no FRF has a finite value: those lines are removed.
fn findings_on_missing_ends(set: &FrfSet, band: Band) -> Vec<Finding> {
    let lines = set.axis().lines(&band);
    let none = |k: &usize| (0..set.len()).all(|i| !set.values(i)[*k].is_finite());
    let hz = |k: usize| set.axis().hz(k);
    // Derivatives have no value at 0 Hz, which no identification reads.
    let first = lines.clone().find(|k| hz(*k) > 0.0 && !none(k));
    let last = lines.clone().rev().find(|k| !none(k));
    let (Some(first), Some(last)) = (first, last) else {
        return Vec::new();
    };
    let finding = |end: usize, limit: usize| {
        let finding = Finding::new(Severity::Warning, Code::BandCut, Location::Whole);
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

fn invalid_frf_finding(function: &Function, hz: f64) -> Finding {
    let location = Location::Function {
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
    };
    Finding::new(Severity::Error, Code::ValueNotFinite, location).value(hz, "Hz")
}

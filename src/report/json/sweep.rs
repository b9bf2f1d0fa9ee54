//! Parameter sweeps are written with the schema `modalign-sweep/1`.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::theory::{Locus, LocusEvent, Sweep};

use super::schema::json_text;

/// The schema of [`sweeps_to_json`].
pub const SWEEP_SCHEMA: &str = "modalign-sweep/1";

#[derive(Serialize)]
struct SweepsFile<'a> {
    schema: &'static str,
    sweeps: Vec<SweepFile<'a>>,
}

#[derive(Serialize)]
struct SweepFile<'a> {
    parameter: &'a str,
    unit: &'a str,
    values: &'a [f64],
    /// Whether loci are tracked by mode shape; otherwise they are the roots by number.
    followed: bool,
    loci: Vec<LocusFile<'a>>,
    events: Vec<EventFile>,
}

#[derive(Serialize)]
struct LocusFile<'a> {
    /// At the first value.
    multiplicity: usize,
    /// At each value, where it changes.
    multiplicities: Option<&'a [usize]>,
    class: Option<&'a str>,
    frequency_hz: Vec<Option<f64>>,
}

#[derive(Serialize)]
struct EventFile {
    kind: &'static str,
    /// Indices in `loci`, from 0.
    loci: [usize; 2],
    place: f64,
    frequency_hz: [f64; 2],
    gap_hz: f64,
    coupling: f64,
    width: Option<f64>,
}

/// The text of sweeps, ending in a newline.
pub fn sweeps_to_json(sweeps: &[Sweep]) -> String {
    let file = SweepsFile {
        schema: SWEEP_SCHEMA,
        sweeps: sweeps.iter().map(sweep_file).collect(),
    };
    json_text(&file)
}

fn sweep_file(sweep: &Sweep) -> SweepFile<'_> {
    let frequencies = |locus: &'_ Locus| {
        let all = locus.omega_rad_s.iter();
        all.map(|omega| omega.map(|omega| omega / TAU)).collect()
    };
    let event = |event: &LocusEvent| EventFile {
        kind: event.kind.name(),
        loci: event.loci,
        place: event.place,
        frequency_hz: event.frequency_hz,
        gap_hz: event.gap_hz,
        coupling: event.coupling,
        width: event.width,
    };
    let loci = sweep.loci.iter().map(|locus| LocusFile {
        multiplicity: locus.multiplicity[0],
        multiplicities: varying_values(&locus.multiplicity),
        class: locus.class.as_deref(),
        frequency_hz: frequencies(locus),
    });
    SweepFile {
        parameter: &sweep.parameter.name,
        unit: &sweep.parameter.unit,
        values: &sweep.values,
        followed: sweep.followed,
        loci: loci.collect(),
        events: sweep.events.iter().map(event).collect(),
    }
}

/// Values that are not all equal; `None` if they are.
fn varying_values(all: &[usize]) -> Option<&[usize]> {
    all.iter().any(|number| *number != all[0]).then_some(all)
}

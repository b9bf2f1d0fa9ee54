//! Hit judging on real recordings keeps the hits that a careful operator kept, and lists the faults
//! that the operator noted.

use std::path::Path;

use modalign::dof::Dof;
use modalign::fourier::ForwardPlan;
use modalign::io::{
    ColumnName, ColumnRole, Dimension, Hints, HitFile, HitGrouping, TableColumn, TableSpec,
    group_hits, open_path,
};
use modalign::record::{Hit, collect};
use modalign::signal::{
    Check, HitQualityLimits, ONSET_FRACTION, Outcome, Pulse, ResponseRecord, assess_force,
    assess_levels, assess_response, inconsistent_hits,
};
use num_complex::Complex64;

use crate::command::shared_data;

fn column(number: usize, role: ColumnRole) -> TableColumn {
    TableColumn {
        column: ColumnName::Number(number),
        role,
        scale: 1.0,
    }
}

fn dof(text: &str) -> Option<Dof> {
    Some(text.parse().unwrap())
}

/// Force in the first column or channel, responses behind it.
fn spec(responses: &[&str], rate_hz: f64, dimensions: Option<Vec<Dimension>>) -> TableSpec {
    let force = ColumnRole::Force {
        dof: dof("1:+Z"),
        unit: "N".parse().unwrap(),
    };
    let responses = responses.iter().enumerate().map(|(k, name)| {
        let role = ColumnRole::Response {
            dof: dof(name),
            unit: "m/s2".parse().unwrap(),
        };
        column(k + 2, role)
    });
    TableSpec {
        dimensions,
        sampling_rate_hz: Some(rate_hz),
        columns: std::iter::once(column(1, force)).chain(responses).collect(),
        ..TableSpec::default()
    }
}

fn read(path: &Path, table: TableSpec, grouping: HitGrouping) -> Vec<Hit> {
    let hints = Hints {
        path: path.display().to_string(),
        table: Some(table),
    };
    let source = open_path(path, &hints, None).unwrap();
    let mut set = group_hits(vec![HitFile::new(source)], grouping, &[]).unwrap();
    collect(&mut set.recording).unwrap()
}

fn pulse_of(hit: &Hit) -> Pulse {
    Pulse::locate(&hit.force.si(), ONSET_FRACTION).unwrap()
}

/// Every check of one hit alone.
fn checks(hit: &Hit, band_end_hz: f64) -> Vec<Check> {
    let limits = HitQualityLimits::default();
    let (force, pulse, step_s) = (hit.force.si(), pulse_of(hit), hit.axis.step_s);
    let mut checks = assess_force(&force, step_s, &pulse, None, band_end_hz, &limits);
    for response in &hit.responses {
        let samples = response.si();
        let record = ResponseRecord {
            samples: &samples,
            step_s,
            dof: &response.dof,
            full_scale: None,
        };
        checks.extend(assess_response(&record, &pulse, &limits));
    }
    checks
}

/// The checks of a series: its levels, and for each response the inconsistent hit over the lines of
/// a band.
fn series_checks(hits: &[Hit], band_hz: (f64, f64)) -> Vec<Check> {
    let limits = HitQualityLimits::default();
    let peaks: Vec<f64> = hits.iter().map(|hit| pulse_of(hit).height_n).collect();
    let axis = hits[0].axis.spectrum_axis();
    let plan = ForwardPlan::new(hits[0].axis.len);
    let lines = |samples: &[f64]| -> Vec<Complex64> {
        let all = plan.transform(samples).into_iter().enumerate();
        let inside = |k: &usize| (band_hz.0..=band_hz.1).contains(&axis.hz(*k));
        all.filter(|(k, _)| inside(k)).map(|(_, x)| x).collect()
    };
    let force: Vec<_> = hits.iter().map(|hit| lines(&hit.force.si())).collect();
    let force: Vec<&[Complex64]> = force.iter().map(Vec::as_slice).collect();
    let mut checks = assess_levels(&peaks, &limits);
    for channel in 0..hits[0].responses.len() {
        let response = hits.iter().map(|hit| lines(&hit.responses[channel].si()));
        let response: Vec<_> = response.collect();
        let response: Vec<&[Complex64]> = response.iter().map(Vec::as_slice).collect();
        checks.extend(inconsistent_hits(&force, &response, &limits));
    }
    checks
}

fn assert_kept(name: &str, hits: &[Hit], band_hz: (f64, f64)) {
    let mut all = series_checks(hits, band_hz);
    all.extend(hits.iter().flat_map(|hit| checks(hit, band_hz.1)));
    for check in all.iter().filter(|c| c.outcome == Outcome::Noted) {
        println!("{name}: {check:?}");
    }
    let rejected: Vec<_> = all
        .iter()
        .filter(|c| c.outcome == Outcome::Rejected)
        .collect();
    assert!(rejected.is_empty(), "{name}: {rejected:#?}");
}

#[test]
fn the_hits_on_a_plate_are_kept() {
    let Some(data) = shared_data() else { return };
    let hits: Vec<Hit> = (1..=5)
        .flat_map(|k| {
            let path = data.join(format!("tonewood-plate1/plate_1_frf_{k}.csv"));
            read(&path, spec(&["2:+Z"], 48_000.0, None), HitGrouping::Files)
        })
        .collect();
    assert_eq!(hits.len(), 5);
    assert_kept("plate", &hits, (20.0, 1000.0));
}

#[test]
fn the_hits_at_three_points_are_kept() {
    let Some(data) = shared_data() else { return };
    let dimensions = vec![Dimension::Hit, Dimension::Channel, Dimension::Sample];
    for name in ["F1", "F2", "F3"] {
        let path = data.join(format!("dewesoft-hammer/{name}.npy"));
        let table = spec(
            &["2:+X", "2:+Y", "2:+Z"],
            20_000.0,
            Some(dimensions.clone()),
        );
        let hits = read(&path, table, HitGrouping::Records);
        assert_eq!(hits.len(), 3);
        assert_kept(name, &hits, (20.0, 3000.0));
    }
}

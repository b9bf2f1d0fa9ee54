//! Grouping of time records into hits, on catalogues made in memory.

use crate::axis::{FrequencyAxis, TimeAxis};
use crate::dof::Dof;
use crate::finding::Code;
use crate::quantity::Quantity;
use crate::record::{Recording, Role, Samples};

use crate::io::*;

/// A file in memory; sample `i` of entry `e` is `100 e + i`.
struct Memory {
    catalog: Catalog,
}

impl Source for Memory {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn catalog_mut(&mut self) -> &mut Catalog {
        &mut self.catalog
    }

    fn read_samples(
        &mut self,
        entry: usize,
        range: std::ops::Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        *block = Block::F32(range.map(|i| (100 * entry + i) as f32).collect());
        Ok(())
    }
}

fn dof(text: &str) -> Option<Dof> {
    Some(text.parse().unwrap())
}

/// A record: force when its quantity is; version and DOFs as given.
fn record(
    quantity: Quantity,
    version: i64,
    response: Option<Dof>,
    reference: Option<Dof>,
) -> Entry {
    let axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 0.001,
        len: 4,
    });
    Entry {
        identification: Identification {
            version,
            ..Identification::default()
        },
        response,
        reference,
        quantity: Some(quantity),
        to_si: Some(1.0),
        line: Some(1),
        ..Entry::new(FunctionType::Time, axis, SampleFormat::RealF32)
    }
}

fn force(version: i64, at: Option<Dof>) -> Entry {
    record(Quantity::Force, version, at, None)
}

fn response(version: i64, at: &str, reference: Option<Dof>) -> Entry {
    record(Quantity::Acceleration, version, dof(at), reference)
}

fn file(entries: Vec<Entry>) -> HitFile {
    let catalog = Catalog {
        path: "t.uff".to_owned(),
        entries,
        ..Catalog::default()
    };
    HitFile::new(Box::new(Memory { catalog }))
}

fn group(entries: Vec<Entry>) -> Result<HitSet, IoError> {
    group_hits(vec![file(entries)], HitGrouping::Records, &[])
}

/// Force point and response points of each hit.
fn points(set: &HitSet) -> Vec<(String, Vec<String>)> {
    let of = |hit: &crate::record::HitInfo| {
        (
            hit.force.dof.to_string(),
            hit.responses.iter().map(|r| r.dof.to_string()).collect(),
        )
    };
    set.recording.hits().iter().map(of).collect()
}

fn expected(hits: &[(&str, &[&str])]) -> Vec<(String, Vec<String>)> {
    hits.iter()
        .map(|(f, r)| ((*f).to_owned(), r.iter().map(|t| (*t).to_owned()).collect()))
        .collect()
}

#[test]
fn the_version_number_groups_hits_in_any_order() {
    let mut set = group(vec![
        response(1, "2:+Z", None),
        response(2, "2:+Z", None),
        force(1, dof("1:+Z")),
        response(2, "3:+Z", None),
        force(2, dof("5:-Z")),
        response(1, "3:+Z", None),
    ])
    .unwrap();
    assert_eq!(
        points(&set),
        expected(&[("1:+Z", &["2:+Z", "3:+Z"]), ("5:-Z", &["2:+Z", "3:+Z"])])
    );
    assert!(set.findings.is_empty(), "{:?}", set.findings);
    let hits = crate::record::collect(&mut set.recording).unwrap();
    assert_eq!(
        hits[0].responses[1].samples,
        Samples::F32(vec![500.0, 501.0, 502.0, 503.0])
    );
}

#[test]
fn a_further_force_or_a_response_already_there_opens_the_next_hit() {
    let forces_first = vec![
        force(0, dof("1:+Z")),
        response(0, "2:+Z", None),
        force(0, dof("1:+Z")),
        response(0, "2:+Z", None),
    ];
    let responses_first: Vec<Entry> = [1, 0, 3, 2]
        .iter()
        .map(|i| forces_first[*i].clone())
        .collect();
    for entries in [forces_first, responses_first] {
        let set = group(entries).unwrap();
        assert_eq!(
            points(&set),
            expected(&[("1:+Z", &["2:+Z"]), ("1:+Z", &["2:+Z"])])
        );
        assert_eq!(set.findings[0].code, Code::GroupedByOrder);
        assert_eq!(set.findings[0].value, Some(2.0));
    }
}

#[test]
fn with_id_lines_differing_by_channel_the_order_groups_hits() {
    let mut entries = vec![
        force(0, dof("1:+Z")),
        response(0, "2:+Z", None),
        response(0, "3:+Z", None),
    ];
    for (index, entry) in entries.iter_mut().enumerate() {
        entry.identification.lines[0] = format!("channel {index}");
    }
    let set = group(entries).unwrap();
    assert_eq!(points(&set), expected(&[("1:+Z", &["2:+Z", "3:+Z"])]));
    assert_eq!(set.findings[0].code, Code::GroupedByOrder);
}

#[test]
fn the_hit_point_is_the_force_then_the_reference_then_the_scene() {
    let with_reference = group(vec![force(1, None), response(1, "2:+Z", dof("7:-Z"))]).unwrap();
    assert_eq!(points(&with_reference), expected(&[("7:-Z", &["2:+Z"])]));
    assert_eq!(with_reference.findings[0].code, Code::HitPointAssumed);
    let silent = || file(vec![force(1, None), response(1, "2:+Z", None)]);
    let stated = HitFile {
        reference: dof("9:+X"),
        ..silent()
    };
    let set = group_hits(vec![stated], HitGrouping::Records, &[]).unwrap();
    assert_eq!(points(&set), expected(&[("9:+X", &["2:+Z"])]));
    let error = group_hits(vec![silent()], HitGrouping::Records, &[])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("the hit point of the hit that starts with record 1 is not stated"),
        "{error}"
    );
}

#[test]
fn differing_references_make_no_excitation_point() {
    let entries = vec![
        force(1, None),
        response(1, "2:+Z", dof("7:-Z")),
        response(1, "3:+Z", dof("8:-Z")),
    ];
    assert!(
        group(entries)
            .unwrap_err()
            .to_string()
            .contains("the hit point")
    );
}

#[test]
fn overrides_name_roles_points_and_units_by_the_number_within_the_hit() {
    let mut entries: Vec<Entry> = (0..6).map(|_| response(0, "1:+Z", None)).collect();
    for entry in &mut entries {
        (entry.response, entry.quantity, entry.to_si) = (None, None, None);
    }
    let channel = |number, role, at: &str, unit: &str| ChannelOverride {
        number,
        role: Some(role),
        dof: dof(at),
        unit: Some(unit.parse().unwrap()),
        missing_unit: None,
        scale: Some(2.0),
        full_scale: None,
    };
    let overrides = [
        channel(1, Role::Force, "4:+Z", "kN"),
        channel(2, Role::Response, "5:+Z", "g"),
        channel(3, Role::Response, "6:-Z", "mm/s2"),
    ];
    let set = group_hits(vec![file(entries)], HitGrouping::Records, &overrides).unwrap();
    assert_eq!(
        points(&set),
        expected(&[("4:+Z", &["5:+Z", "6:-Z"]), ("4:+Z", &["5:+Z", "6:-Z"])])
    );
    assert!((set.recording.hits()[0].force.to_si - 2000.0).abs() < 1e-9);
    assert!((set.recording.hits()[1].responses[0].to_si - 2.0 * 9.80665).abs() < 1e-12);
}

#[test]
fn impossible_hits_are_errors_with_got_and_expected() {
    let message = |entries| group(entries).unwrap_err().to_string();
    let none = message(vec![response(0, "2:+Z", None), response(0, "3:+Z", None)]);
    assert!(
        none.contains("got 0 force and 2 response records")
            && none.contains("expected one force record"),
        "{none}"
    );
    let mut unknown = response(1, "2:+Z", None);
    (unknown.to_si, unknown.unit_label) = (None, "V".to_owned());
    let unit = message(vec![force(1, dof("1:+Z")), unknown]);
    assert!(
        unit.contains("quantity and unit of record 2 (unit label \"V\") is not stated"),
        "{unit}"
    );
    let mut nowhere = response(1, "2:+Z", None);
    nowhere.response = None;
    assert!(
        message(vec![force(1, dof("1:+Z")), nowhere]).contains("the response point of record 2")
    );
}

#[test]
fn responses_of_a_version_without_force_are_an_error() {
    let entries = vec![
        force(1, dof("1:+Z")),
        response(1, "2:+Z", None),
        response(2, "3:+Z", None),
        force(3, dof("1:+Z")),
        response(3, "2:+Z", None),
    ];
    let error = group(entries).unwrap_err().to_string();
    assert!(
        error.contains("0 force and 1 response records in the hit that starts with record 3"),
        "{error}"
    );
}

#[test]
fn with_id_lines_differing_by_channel_the_version_groups_hits() {
    let mut entries = vec![
        force(1, dof("1:+Z")),
        response(1, "2:+Z", None),
        force(2, dof("5:+Z")),
        response(2, "2:+Z", None),
    ];
    for (index, entry) in entries.iter_mut().enumerate() {
        entry.identification.lines[0] = format!("record {index}");
    }
    let set = group(entries).unwrap();
    assert_eq!(
        points(&set),
        expected(&[("1:+Z", &["2:+Z"]), ("5:+Z", &["2:+Z"])])
    );
    assert!(set.findings.is_empty());
}

#[test]
fn records_on_a_frequency_axis_or_with_another_start_make_no_hit() {
    let mut spectrum = response(1, "2:+Z", None);
    spectrum.axis = EntryAxis::Frequency(FrequencyAxis {
        start_hz: 0.0,
        step_hz: 1.0,
        len: 4,
    });
    let mut late = response(1, "2:+Z", None);
    late.axis = EntryAxis::Time(TimeAxis {
        start_s: 0.02,
        step_s: 0.001,
        len: 4,
    });
    for (other, got) in [
        (spectrum, "record 2 on a frequency axis"),
        (late, "from 0.02 s"),
    ] {
        let files = vec![file(vec![force(1, dof("1:+Z")), other])];
        let error = group_hits(files, HitGrouping::Files, &[])
            .unwrap_err()
            .to_string();
        assert!(error.contains(got), "{error}");
    }
}

#[test]
fn each_file_is_one_hit_when_grouping_is_by_files() {
    let one = || file(vec![response(3, "2:+Z", None), force(4, dof("1:+Z"))]);
    let set = group_hits(vec![one(), one()], HitGrouping::Files, &[]).unwrap();
    assert_eq!(set.recording.hits().len(), 2);
    let two_forces = file(vec![
        force(0, dof("1:+Z")),
        response(0, "2:+Z", None),
        force(0, dof("1:+Z")),
    ]);
    assert!(
        group_hits(vec![two_forces], HitGrouping::Files, &[])
            .unwrap_err()
            .to_string()
            .contains("got 2 force")
    );
}

#[test]
fn channels_of_one_hit_must_be_sampled_alike() {
    let mut other = response(1, "2:+Z", None);
    other.axis = EntryAxis::Time(TimeAxis {
        start_s: 0.0,
        step_s: 0.002,
        len: 4,
    });
    let files = vec![file(vec![force(1, dof("1:+Z")), other])];
    let error = group_hits(files, HitGrouping::Files, &[])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("4 samples by 0.001 s from 0 s and 4 samples by 0.002 s from 0 s"),
        "{error}"
    );
}

#[test]
fn a_response_of_another_excitation_point_does_not_join_the_hit() {
    let of = |at: &str, reference: &str| response(0, at, dof(reference));
    let records = vec![
        force(0, dof("1:+Z")),
        of("8:+Z", "1:+Z"),
        of("9:+Z", "2:+Z"),
        force(0, dof("3:+Z")),
        of("8:+Z", "3:+Z"),
    ];
    // The force of hit 2 is not there: its response belongs to no hit.
    assert!(group(records.clone()).is_err());
    let partial = HitFile {
        partial: true,
        ..file(records)
    };
    let set = group_hits(vec![partial], HitGrouping::Records, &[]).unwrap();
    assert_eq!(
        points(&set),
        expected(&[("1:+Z", &["8:+Z"]), ("3:+Z", &["8:+Z"])])
    );
    let left_out: Vec<_> = set
        .findings
        .iter()
        .filter(|f| f.code == Code::HitLeftOut)
        .collect();
    assert_eq!((left_out.len(), left_out[0].value), (1, Some(1.0)));
}

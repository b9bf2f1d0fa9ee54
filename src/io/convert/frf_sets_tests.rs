//! FRF sets from files that hold coherence in every usual way.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::finding::Code;
use crate::frf::FrfSet;
use crate::io::*;
use crate::quantity::Quantity;

const AXIS: EntryAxis = EntryAxis::Frequency(FrequencyAxis {
    start_hz: 0.0,
    step_hz: 0.5,
    len: 3,
});

fn entry(function_type: FunctionType, response: &str) -> Entry {
    Entry {
        response: Some(response.parse().expect("a degree of freedom")),
        reference: Some("1:+Z".parse().expect("a degree of freedom")),
        quantity: Some(Quantity::Acceleration),
        denominator: Some(Quantity::Force),
        to_si: Some(2.0),
        ..Entry::new(function_type, AXIS, SampleFormat::ComplexF64)
    }
}

fn frf(source: &mut MemorySource, response: &str) {
    let values = vec![Complex64::new(3.0, 4.0); 3];
    source.push(
        entry(FunctionType::Frf, response),
        Block::Complex(values),
        Vec::new(),
    );
}

fn real(source: &mut MemorySource, function_type: FunctionType, response: &str, values: [f64; 3]) {
    let block = Block::F64(values.to_vec());
    source.push(entry(function_type, response), block, Vec::new());
}

fn sets(sources: Vec<MemorySource>, averages: Option<u32>) -> Vec<FrfSet> {
    let mut files: Vec<HitFile> = sources
        .into_iter()
        .map(|source| HitFile {
            averages,
            ..HitFile::new(Box::new(source))
        })
        .collect();
    frf_sets(&mut files).expect("functions of one axis")
}

/// |H|²(1−γ²)/(γ²(n−1)) of a value of 10 m/s²/N.
fn expected(coherence: f64, averages: f64) -> f64 {
    100.0 * (1.0 - coherence) / (coherence * (averages - 1.0))
}

fn close(variance: Option<&[f64]>, expected: [f64; 3]) -> bool {
    let pairs = variance.expect("a variance").iter().zip(expected);
    pairs
        .into_iter()
        .all(|(got, expected)| (got - expected).abs() <= 1e-12 * expected)
}

#[test]
fn a_stated_number_of_averages_is_used_and_an_unknown_one_is_an_assumption() {
    for (stated, used) in [(Some(5), 5.0), (None, 3.0)] {
        let mut file = MemorySource::default();
        frf(&mut file, "2:+Z");
        real(&mut file, FunctionType::Coherence, "2:+Z", [0.9, 0.5, 0.99]);
        let set = &sets(vec![file], stated)[0];
        let variance = [
            expected(0.9, used),
            expected(0.5, used),
            expected(0.99, used),
        ];
        assert!(close(set.variance(0), variance), "{stated:?}");
        assert_eq!(set.functions()[0].averages, stated);
        let assumed: Vec<_> = set.findings.iter().filter_map(|f| f.value).collect();
        let expected: &[f64] = if stated.is_none() { &[3.0] } else { &[] };
        assert_eq!(assumed, expected);
        assert!(set.findings.iter().all(|f| f.code == Code::AveragesAssumed));
    }
}

#[test]
fn coherence_of_a_separate_file_joins_its_frf() {
    let (mut functions, mut coherences) = (MemorySource::default(), MemorySource::default());
    frf(&mut functions, "2:+Z");
    frf(&mut functions, "3:+Z");
    real(&mut coherences, FunctionType::Coherence, "3:+Z", [0.8; 3]);
    let set = &sets(vec![functions, coherences], Some(4))[0];
    assert_eq!(set.coherence(0), None);
    assert_eq!(set.coherence(1), Some([0.8; 3].as_slice()));
    assert!(close(set.variance(1), [expected(0.8, 4.0); 3]));
}

#[test]
fn a_coherence_of_one_everywhere_is_ignored() {
    let mut file = MemorySource::default();
    frf(&mut file, "2:+Z");
    real(&mut file, FunctionType::Coherence, "2:+Z", [1.0; 3]);
    let set = &sets(vec![file], None)[0];
    assert_eq!((set.coherence(0), set.variance(0)), (None, None));
    assert!(set.findings.is_empty());
}

#[test]
fn a_stated_variance_takes_precedence_over_the_coherence() {
    let mut file = MemorySource::default();
    frf(&mut file, "2:+Z");
    frf(&mut file, "2:+Z");
    for values in [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]] {
        real(&mut file, FunctionType::Variance, "2:+Z", values);
        real(&mut file, FunctionType::Coherence, "2:+Z", [0.9; 3]);
    }
    let set = &sets(vec![file], None)[0];
    assert!(close(set.variance(0), [2.0, 4.0, 6.0]) && close(set.variance(1), [8.0, 10.0, 12.0]));
    assert!(set.findings.is_empty());
    assert_eq!(set.functions()[1].response.to_string(), "2:+Z#2");
}

#[test]
fn repeated_functions_and_coherences_of_single_files_meet_in_their_order() {
    let mut sources = Vec::new();
    for _ in 0..2 {
        let mut functions = MemorySource::default();
        frf(&mut functions, "2:+Z");
        sources.push(functions);
    }
    for value in [0.5, 0.75] {
        let mut coherences = MemorySource::default();
        real(&mut coherences, FunctionType::Coherence, "2:+Z", [value; 3]);
        sources.push(coherences);
    }
    let set = &sets(sources, Some(4))[0];
    assert_eq!(set.coherence(0), Some([0.5; 3].as_slice()));
    assert_eq!(set.coherence(1), Some([0.75; 3].as_slice()));
}

#[test]
fn only_sets_without_averages_assume_a_number() {
    let (mut stated, mut unstated) = (MemorySource::default(), MemorySource::default());
    frf(&mut stated, "2:+Z");
    real(&mut stated, FunctionType::Coherence, "2:+Z", [0.9; 3]);
    stated.catalog.entries[0].note.averages = Some(5);
    frf(&mut unstated, "2:+Z");
    real(&mut unstated, FunctionType::Coherence, "2:+Z", [0.9; 3]);
    for entry in &mut unstated.catalog.entries {
        entry.axis = EntryAxis::Frequency(FrequencyAxis {
            start_hz: 0.0,
            step_hz: 0.25,
            len: 3,
        });
    }
    let sets = sets(vec![stated, unstated], None);
    let counts: Vec<usize> = sets.iter().map(|set| set.findings.len()).collect();
    assert_eq!(counts, [0, 1]);
}

#[test]
fn an_frf_set_has_the_window_common_to_its_functions() {
    let window_of = |windows: [Option<Window>; 2]| {
        let mut source = MemorySource::default();
        for (response, window) in ["2:+Z", "3:+Z"].into_iter().zip(windows) {
            let mut entry = entry(FunctionType::Frf, response);
            entry.note.window = window;
            let values = vec![Complex64::new(3.0, 4.0); 3];
            source.push(entry, Block::Complex(values), Vec::new());
        }
        let sets = sets(vec![source], None);
        assert_eq!(sets.len(), 1);
        let stated: Vec<Window> = windows.into_iter().flatten().collect();
        let mixed = sets[0].mixed_windows.clone();
        assert_eq!(
            mixed,
            if sets[0].window.is_some() {
                Vec::new()
            } else {
                stated
            }
        );
        let findings = sets[0].findings.iter();
        let findings: Vec<_> = findings
            .map(|finding| {
                (
                    finding.code,
                    finding.value,
                    finding.limit,
                    finding.detail.clone(),
                )
            })
            .collect();
        (sets[0].window, findings)
    };
    let dropped = |stating: f64, detail: &str| {
        let code = Code::WindowNotCommon;
        let finding = (code, Some(stating), Some(2.0), Some(detail.to_owned()));
        (None, vec![finding])
    };
    let hann = Some(Window::HannNarrow);
    assert_eq!(window_of([hann, hann]), (hann, Vec::new()));
    assert_eq!(window_of([None, None]), (None, Vec::new()));
    assert_eq!(
        window_of([hann, None]),
        dropped(1.0, "hann-narrow: 2:+Z|1:+Z; not stated: 3:+Z|1:+Z")
    );
    assert_eq!(
        window_of([None, hann]),
        dropped(1.0, "not stated: 2:+Z|1:+Z; hann-narrow: 3:+Z|1:+Z")
    );
    assert_eq!(
        window_of([hann, Some(Window::FlatTop)]),
        dropped(2.0, "hann-narrow: 2:+Z|1:+Z; flat-top: 3:+Z|1:+Z")
    );
}

//! Recorded hits become FRFs with coherence and variance, after the library has kept or rejected
//! each hit. The recording is synthetic, with one double hit; `io::open_path` in place of
//! `open_bytes` reads a file of a measurement system.

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;

use modalign::frf::{HammerOptions, evaluate_hammer_test};
use modalign::io::{Hints, HitFile, HitGrouping, Need, check_damage, group_hits, open_bytes};
use modalign::scene::{hammer_test, load_synth, record};
use modalign::signal::{Check, Outcome};
use modalign::synth::SecondContact;

/// A universal file of a bar that is hit three times at each of eleven points.
fn universal_file() -> Result<Vec<u8>, Box<dyn Error>> {
    let path = Path::new("measurements/free-free-beam/synth.toml");
    let spec = load_synth(path)?;
    let mut test = hammer_test(&spec, path)?;
    test.faults.second_contact = Some(SecondContact {
        delay_s: 0.004,
        ratio: 0.3,
        hits: BTreeSet::from([4]),
    });
    Ok(record(&spec, &test, path)?.uff)
}

/// A number that one hit alone does not give.
fn text(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.4e}"))
}

/// Prints the hits with the decision on each, and the magnitude of each FRF at the first resonance.
pub fn main() -> Result<(), Box<dyn Error>> {
    let hints = Hints {
        path: "hits.uff".to_owned(),
        ..Hints::default()
    };
    let mut source = open_bytes(universal_file()?, &hints)?;
    check_damage(source.as_mut(), &[Need::Records], false)?;
    let mut findings = source.catalog().findings.clone();
    let mut hits = group_hits(vec![HitFile::new(source)], HitGrouping::Records, &[])?;
    findings.append(&mut hits.findings);
    let result = evaluate_hammer_test(&mut hits.recording, &HammerOptions::default())?;

    for hit in &result.hits {
        let decision = if hit.used { "kept" } else { "rejected" };
        let peak = hit
            .peak_n
            .map_or("no pulse".to_owned(), |peak| format!("{peak:.1} N"));
        print!(
            "hit {} at {}, {peak}: {decision}",
            hit.number, hit.reference
        );
        let rejected = |check: &&Check| check.outcome == Outcome::Rejected;
        for check in hit.checks.iter().filter(rejected) {
            print!(", {} {}", check.rule.name(), text(check.value));
        }
        println!();
    }

    let frfs = &result.estimated.set;
    let line = frfs
        .axis()
        .nearest(143.25)
        .ok_or("expected a line at 143.25 Hz")?;
    for (index, function) in frfs.functions().iter().enumerate() {
        let (response, reference) = (&function.response, &function.reference);
        let (value, unit) = (frfs.values(index)[line].norm(), function.kind.si_unit());
        let variance = text(frfs.variance(index).map(|values| values[line]));
        let coherence = text(frfs.coherence(index).map(|values| values[line]));
        print!("FRF {response}/{reference}: {value:.4e} {unit}, ");
        println!("variance {variance}, coherence {coherence}");
    }
    for finding in findings.iter().chain(&frfs.findings) {
        println!("{}: {finding}", finding.severity);
    }
    Ok(())
}

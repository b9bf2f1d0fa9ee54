//! FRFs become modes by the default method, maximum likelihood, each with its standard deviations.
//! The FRFs are of a synthetic recording; `io::frf_sets` takes those of a file.

use std::error::Error;
use std::path::Path;

use modalign::FrfSet;
use modalign::ModalModel;
use modalign::axis::Band;
use modalign::frf::{HammerOptions, evaluate_hammer_test};
use modalign::identify::{IdentifyOptions, identify};
use modalign::io::{Hints, HitFile, HitGrouping, group_hits, open_bytes};
use modalign::scene::{hammer_test, load_synth, record};

fn frfs() -> Result<FrfSet, Box<dyn Error>> {
    let path = Path::new("measurements/free-free-beam/synth.toml");
    let spec = load_synth(path)?;
    let recorded = record(&spec, &hammer_test(&spec, path)?, path)?;
    let hints = Hints {
        path: "hits.uff".to_owned(),
        ..Hints::default()
    };
    let source = open_bytes(recorded.uff, &hints)?;
    let mut hits = group_hits(vec![HitFile::new(source)], HitGrouping::Records, &[])?;
    let result = evaluate_hammer_test(&mut hits.recording, &HammerOptions::default())?;
    Ok(result.estimated.set)
}

/// The modes between 60 and 3200 Hz.
pub fn modes() -> Result<ModalModel, Box<dyn Error>> {
    let options = IdentifyOptions {
        band: Some(Band::new(60.0, 3200.0)?),
        ..IdentifyOptions::default()
    };
    Ok(identify(&frfs()?, &options)?)
}

/// A number that a method may not give.
fn text(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.3e}"))
}

/// Prints frequency, damping and modal phase collinearity (MPC) of each mode.
pub fn main() -> Result<(), Box<dyn Error>> {
    let model = modes()?;
    println!("    f (Hz)  std f (Hz)    damping  std damping    MPC");
    for mode in &model.modes {
        println!(
            "{:10.4}  {:>10}  {:>9}  {:>11}  {}",
            mode.frequency_hz,
            text(mode.frequency_std_hz),
            text(mode.damping_ratio),
            text(mode.damping_std),
            mode.mpc.map_or("-".to_owned(), |mpc| format!("{mpc:.4}")),
        );
    }
    for finding in &model.findings {
        println!("{}: {finding}", finding.severity);
    }
    Ok(())
}

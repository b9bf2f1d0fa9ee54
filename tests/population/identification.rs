//! Identification finds the observable modes of 300 known systems and no spurious ones.

use modalign::identify::{IdentifyOptions, identify};
use modalign::modal::ModalModel;
use modalign::study::DetectionVerdict;
use rayon::prelude::*;

use super::draws;
use super::systems::{Drawn, SYSTEMS};

/// The method under test.
pub const METHOD: &str = "ml";
/// Smallest share of found modes among the observable ones.
const MIN_RECALL: f64 = 0.995;
/// Largest share of spurious modes among the found ones.
const MAX_SPURIOUS_SHARE: f64 = 0.005;
/// Smallest share of the true modes found that is called good; largest share of the found modes
/// that is spurious and called good.
const MIN_GOOD_SHARE: f64 = 0.93;
const MAX_SPURIOUS_GOOD_SHARE: f64 = 0.003;
/// Smallest share of systems without a missed or spurious mode.
const MIN_RIGHT_SHARE: f64 = 0.97;

/// The modes of one draw of a system.
pub fn identified(drawn: &Drawn, draw: u64) -> ModalModel {
    let options = IdentifyOptions {
        method: METHOD.to_owned(),
        band: Some(drawn.system.band),
        ..IdentifyOptions::default()
    };
    identify(&drawn.measured(draw), &options).unwrap()
}

/// A system of the family with its identified modes.
pub fn judged(number: usize) -> (Drawn, ModalModel, DetectionVerdict) {
    let drawn = Drawn::draw(number as u64);
    let model = identified(&drawn, 0);
    let verdict = drawn.judge().verdict(&model);
    (drawn, model, verdict)
}

/// Counts over systems.
#[derive(Clone, Copy, Default, Debug)]
pub struct Score {
    pub systems: usize,
    pub right: usize,
    /// Modes of the bands.
    pub modes: usize,
    pub observable: usize,
    pub missed: usize,
    pub found: usize,
    pub spurious: usize,
    /// True and spurious modes that are called good.
    pub good: usize,
    pub spurious_good: usize,
}

impl Score {
    pub fn add(&mut self, (drawn, model, verdict): &(Drawn, ModalModel, DetectionVerdict)) {
        self.systems += 1;
        self.right += usize::from(verdict.is_correct());
        let system = &drawn.system;
        self.modes += system.modes.iter().filter(|m| system.inside(m)).count();
        self.observable += verdict.observable;
        self.missed += verdict.missed.len();
        self.found += model.modes.len();
        self.spurious += verdict.spurious.len();
        let is_good = |f: usize| !model.modes[f].is_doubtful();
        let good = (0..model.modes.len()).filter(|f| is_good(*f)).count();
        let spurious_good = verdict.spurious.iter().filter(|f| is_good(**f)).count();
        self.good += good - spurious_good;
        self.spurious_good += spurious_good;
    }

    /// Share of the observable modes that is found.
    pub fn recall(&self) -> f64 {
        1.0 - self.missed as f64 / self.observable as f64
    }

    /// Share of the found modes that is spurious.
    pub fn spurious(&self) -> f64 {
        self.spurious as f64 / self.found as f64
    }

    /// Share of the true modes found that is called good.
    pub fn good(&self) -> f64 {
        self.good as f64 / (self.found - self.spurious) as f64
    }

    /// Share of the found modes that is spurious and called good.
    pub fn spurious_good(&self) -> f64 {
        self.spurious_good as f64 / self.found as f64
    }

    /// Share of systems without a missed or spurious mode.
    pub fn right(&self) -> f64 {
        self.right as f64 / self.systems as f64
    }
}

#[test]
fn every_observable_mode_is_found_and_none_is_invented() {
    let judged: Vec<_> = (0..draws(SYSTEMS as u64) as usize)
        .into_par_iter()
        .map(judged)
        .collect();
    let mut score = Score::default();
    for draw in &judged {
        score.add(draw);
        if !draw.2.is_correct() {
            println!("{}: {}", draw.0, draw.2);
            for reason in draw.0.judge().reasons(&draw.1, &draw.2) {
                println!("    {reason}");
            }
        }
    }
    println!("{score:?}");
    assert!(score.recall() >= MIN_RECALL, "{}", score.recall());
    assert!(
        score.spurious() <= MAX_SPURIOUS_SHARE,
        "{}",
        score.spurious()
    );
    assert!(score.right() >= MIN_RIGHT_SHARE, "{}", score.right());
    assert!(score.good() >= MIN_GOOD_SHARE, "{}", score.good());
    assert!(
        score.spurious_good() <= MAX_SPURIOUS_GOOD_SHARE,
        "{}",
        score.spurious_good()
    );
}

//! The pipeline records a member of the family, estimates its FRFs, identifies its modes, judges
//! them, and counts the results of a kind.

use modalign::FrfSet;
use modalign::frf::{EstimateOptions, Function, FunctionData, estimate};
use modalign::identify::{IdentifyOptions, identify};
use modalign::signal::ForceWindow;
use modalign::synth::HammerTest;

use super::judge::{Verdict, judge};
use crate::population::{Member, PopulationSpec};

/// The one committed family.
pub fn family() -> PopulationSpec {
    toml::from_str(include_str!("family.toml")).unwrap()
}

/// H1 as a scene would ask for it: with a force window that leaves the filter room to ring out.
fn estimate_options(test: &HammerTest) -> EstimateOptions {
    let step_s = 1.0 / test.sampling_rate_hz;
    EstimateOptions {
        force_window: Some(ForceWindow {
            hold_s: 96.0 * step_s,
            flank_s: 64.0 * step_s,
        }),
        ..EstimateOptions::default()
    }
}

/// Records a member, estimates its FRFs, identifies its modes and judges them.
pub fn judged(member: &Member) -> Verdict {
    judged_of(member, |set| set)
}

/// As [`judged`], from FRFs alone: without variances and coherence, as most files hold them.
pub fn judged_from_frfs_alone(member: &Member) -> Verdict {
    judged_of(member, frfs_alone)
}

fn judged_of(member: &Member, change: impl Fn(FrfSet) -> FrfSet) -> Verdict {
    let options = estimate_options(&member.test);
    let hits = member.test.generate().unwrap();
    let set = change(estimate(&hits, &options).unwrap());
    let found = identify(&set, &IdentifyOptions::default()).unwrap();
    judge(member, &options, &found)
}

fn frfs_alone(set: FrfSet) -> FrfSet {
    let mut alone = FrfSet::new(*set.axis());
    alone.added_damping_rad_s = set.added_damping_rad_s;
    alone.record_duration_s = set.record_duration_s;
    alone.valid_band = set.valid_band;
    for (i, function) in set.functions().iter().enumerate() {
        let function = Function {
            variance_dof: None,
            ..function.clone()
        };
        let data = FunctionData {
            values: set.values(i).to_vec(),
            coherence: None,
            variance: None,
        };
        alone.push(function, data).unwrap();
    }
    alone
}

/// Detectable and found modes of some roots.
#[derive(Clone, Copy, Default)]
pub struct Share {
    /// Modes there are; of a repeated root no more than there are references.
    pub there: usize,
    /// Modes found.
    pub found: usize,
}

/// Counts over the members of a kind.
#[derive(Clone, Default)]
pub struct Tally {
    /// Members.
    pub members: usize,
    /// Observable and separated.
    pub clear: Share,
    /// Observable, not separated.
    pub crowded: Share,
    /// Not observable.
    pub hidden: Share,
    /// Spurious modes.
    pub spurious: usize,
}

impl Tally {
    /// Adds a member.
    pub fn add(&mut self, member: &Member, verdict: &Verdict) {
        self.members += 1;
        self.spurious += verdict.spurious;
        for root in &verdict.roots {
            let share = match (root.observable, root.separated) {
                (true, true) => &mut self.clear,
                (true, false) => &mut self.crowded,
                (false, _) => &mut self.hidden,
            };
            share.there += root.modes.len().min(member.test.hits.len());
            share.found += root.found;
        }
    }
}

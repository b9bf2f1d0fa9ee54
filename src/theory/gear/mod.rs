//! Transmissions whose models are built in, by name; one file each.

mod cycloid_ball;
mod cycloid_ball_model;
mod cycloid_ball_parameters;
#[cfg(test)]
mod cycloid_ball_printed_tests;
#[cfg(test)]
mod cycloid_ball_table_tests;
#[cfg(test)]
mod cycloid_ball_tests;
mod cycloid_studies;
#[cfg(test)]
mod cycloid_studies_tests;
mod helical_checks;
#[cfg(test)]
mod helical_limits_tests;
mod helical_mesh;
mod helical_motion;
#[cfg(test)]
mod helical_motion_tests;
mod helical_parameters;
mod helical_planetary;
mod helical_planetary_model;
#[cfg(test)]
mod helical_planetary_tests;
mod helical_response;
#[cfg(test)]
mod helical_response_tests;
#[cfg(test)]
mod helical_starts_tests;
#[cfg(test)]
mod helical_teeth_tests;
mod spider_reducer;
mod spider_reducer_model;
mod spider_reducer_parameters;
mod spider_reducer_results;
#[cfg(test)]
mod spider_reducer_tests;
#[cfg(test)]
mod spider_reducer_variants_tests;
mod torsional_closed_forms;
mod torsional_planetary;
mod torsional_planetary_model;
#[cfg(test)]
mod torsional_planetary_tests;
mod torsional_results;
mod torsional_sensitivities;
#[cfg(test)]
mod torsional_variants_tests;

use super::{TheoreticalModel, TheoryError};

pub use cycloid_ball::CycloidBall;
pub use helical_planetary::HelicalPlanetary;
pub use spider_reducer::SpiderReducer;
pub use torsional_planetary::TorsionalPlanetary;

/// A built-in model.
pub struct BuiltIn {
    /// Name on the command line and in scenes.
    pub name: &'static str,
    /// Its parameter sets; the first is meant when none is named.
    pub sets: &'static [&'static str],
    /// Number of its first elastic root in tables, as its publication counts.
    pub first_root: usize,
    /// Builds it with one of the sets; `None` for another name.
    pub build: fn(set: &str) -> Option<Box<dyn TheoreticalModel>>,
}

/// Every built-in model.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn {
        name: "cycloid-ball",
        sets: cycloid_ball_parameters::SET_NAMES,
        // The paper counts the root at 0 Hz as its first.
        first_root: 2,
        build: |set| Some(Box::new(CycloidBall::new(set)?)),
    },
    BuiltIn {
        name: "torsional-planetary",
        sets: torsional_planetary::SET_NAMES,
        first_root: 1,
        build: |set| Some(Box::new(TorsionalPlanetary::new(set)?)),
    },
    BuiltIn {
        name: "spider-reducer",
        sets: &["paper"],
        first_root: 1,
        build: |set| Some(Box::new(SpiderReducer::new(set)?)),
    },
    BuiltIn {
        name: "helical-planetary",
        sets: helical_parameters::SET_NAMES,
        first_root: 1,
        build: |set| Some(Box::new(HelicalPlanetary::new(set)?)),
    },
];

/// The built-in model of a name such as `cycloid-ball`, or `cycloid-ball/D` for a parameter set.
///
/// # Errors
/// [`TheoryError::UnknownModel`] with every name and set.
pub fn built_in(name: &str) -> Result<Box<dyn TheoreticalModel>, TheoryError> {
    let (model, set) = name
        .split_once('/')
        .map_or((name, None), |(m, s)| (m, Some(s)));
    let entry = BUILT_IN.iter().find(|entry| entry.name == model);
    let found = entry.and_then(|entry| (entry.build)(set.unwrap_or(entry.sets[0])));
    found.ok_or_else(|| TheoryError::UnknownModel {
        got: name.to_owned(),
        known: BUILT_IN
            .iter()
            .flat_map(|entry| {
                entry
                    .sets
                    .iter()
                    .map(move |set| format!("{}/{set}", entry.name))
            })
            .collect(),
    })
}

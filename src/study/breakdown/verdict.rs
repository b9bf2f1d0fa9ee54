//! The verdict of a map names the simplest method that meets the stated error where the user's
//! modes are, or in most of the slices, and where it fails.

use crate::identify::ESTIMATORS;
use crate::study::wording::{counted, listed, two_digits};

use super::{Distance, SliceResult, UserMode, UserModePosition};

/// Modes of a method at which it fails, and its distance from failing at the others.
#[derive(Default)]
struct MethodAtModes {
    /// Modes that a slice locates, counted in each slice.
    located: usize,
    /// Names of the modes at which the method fails, each once, with the slices.
    failing: Vec<(String, Vec<String>)>,
    /// The mode that is nearest to where the method fails, with its distance.
    nearest: Option<(String, Distance)>,
}

/// `Use circle: in these maps it meets the stated error at all 6 modes that they show. It would
/// fail next at mode 6 (2674.3 Hz), 0.74 decades of damping away. lsce fails at 1 mode.` Only
/// methods that were tried at all of these modes are compared.
pub fn breakdown_verdict(slices: &[SliceResult], modes: &[UserMode]) -> Option<String> {
    let located: Vec<(&SliceResult, Vec<UserModePosition>)> = slices
        .iter()
        .map(|slice| (slice, slice.locate_modes(modes)))
        .collect();
    let methods = ESTIMATORS.iter().map(|entry| entry.name);
    let methods: Vec<&str> = methods
        .filter(|name| {
            slices
                .iter()
                .any(|slice| method_index(slice, name).is_some())
        })
        .collect();
    let at_modes: Vec<(&str, MethodAtModes)> = methods
        .iter()
        .map(|method| (*method, at_modes(method, &located)))
        .filter(|(_, at)| at.located > 0)
        .collect();
    let most = at_modes.iter().map(|(_, at)| at.located).max();
    let tried_at_all = at_modes.iter().filter(|(_, at)| Some(at.located) == most);
    let best = tried_at_all.min_by_key(|(_, at)| at.failing.len());
    match best {
        Some((method, at)) => {
            let mut shown: Vec<String> = Vec::new();
            for position in located.iter().flat_map(|(_, positions)| positions) {
                let name = position.mode.name();
                if position.is_inside() && !shown.contains(&name) {
                    shown.push(name);
                }
            }
            Some(verdict_at_modes(method, at, shown.len(), &at_modes))
        }
        None => verdict_by_area(&methods, slices),
    }
}

fn method_index(slice: &SliceResult, method: &str) -> Option<usize> {
    slice.slice.methods.iter().position(|name| name == method)
}

fn at_modes(method: &str, located: &[(&SliceResult, Vec<UserModePosition>)]) -> MethodAtModes {
    let mut at = MethodAtModes::default();
    let mut nearest_share = f64::INFINITY;
    for (slice, position) in located
        .iter()
        .flat_map(|(slice, positions)| positions.iter().map(move |position| (slice, position)))
    {
        let mut margins = position.margins.iter();
        let Some(margin) = margins.find(|margin| margin.method == method) else {
            continue;
        };
        at.located += 1;
        let name = position.mode.name();
        if !margin.inside {
            let slice = slice.slice.name.clone();
            match at.failing.iter_mut().find(|(failing, _)| *failing == name) {
                Some((_, slices)) => slices.push(slice),
                None => at.failing.push((name, vec![slice])),
            }
        } else if let Some(distance) = margin.distance
            && distance.share < nearest_share
        {
            nearest_share = distance.share;
            at.nearest = Some((name, distance));
        }
    }
    at
}

fn verdict_at_modes(
    method: &str,
    at: &MethodAtModes,
    shown: usize,
    all: &[(&str, MethodAtModes)],
) -> String {
    let modes = counted(shown, "mode");
    let mut sentences = vec![match at.failing.as_slice() {
        [] => format!(
            "Use {method}: in these maps it meets the stated error at all {modes} that they show."
        ),
        failing => format!(
            "In these maps no method meets the stated error at all {modes} that they show; {method} fails at the fewest: {}.",
            failing_modes(failing)
        ),
    }];
    sentences.extend(at.nearest.as_ref().map(|(mode, distance)| {
        format!(
            "It would fail next at {mode}, {} {} away.",
            two_digits(distance.value()),
            distance.unit()
        )
    }));
    let others = all
        .iter()
        .filter(|(name, at)| *name != method && !at.failing.is_empty());
    let others: Vec<String> = others
        .map(|(name, at)| format!("{name} fails at {}", counted(at.failing.len(), "mode")))
        .collect();
    if !others.is_empty() {
        sentences.push(format!("{}.", listed(&others)));
    }
    sentences.join(" ")
}

/// `mode 3 (412.3 Hz) in separation-noise, damping-noise`.
fn failing_modes(failing: &[(String, Vec<String>)]) -> String {
    let named = failing
        .iter()
        .map(|(mode, slices)| format!("{mode} in {}", slices.join(", ")));
    listed(&named.collect::<Vec<_>>())
}

/// The method that meets the stated error in the largest part of all slices, and the next.
fn verdict_by_area(methods: &[&str], slices: &[SliceResult]) -> Option<String> {
    let mean_area = |method: &str| {
        let areas = slices.iter().filter_map(|slice| {
            let index = method_index(slice, method)?;
            Some(slice.area(index))
        });
        let areas: Vec<f64> = areas.collect();
        areas.iter().sum::<f64>() / areas.len() as f64
    };
    let mut by_area: Vec<(&str, f64)> = methods
        .iter()
        .map(|name| (*name, mean_area(name)))
        .collect();
    // Of equal areas the simplest method is first.
    by_area.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (best, area) = by_area.first()?;
    let next = by_area.get(1).map_or(String::new(), |(name, area)| {
        format!("; the next is {name} with {:.0} %", 100.0 * area)
    });
    Some(format!(
        "Use {best}: it meets the stated error in {:.0} % of the area of the maps{next}.",
        100.0 * area
    ))
}

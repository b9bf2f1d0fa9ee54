//! The summary of a study states the needs of a scene in sentences.

use crate::identify::OrderStep;
use crate::update::uncertainties_over_errors;

use super::super::wording::{counted, listed};
use super::{LowestOrder, ModeNeeds, ParameterNeeds, SceneNeeds, TestNeeds, TheoryNeeds};

/// Difference of BIC that decides: odds of 150 to 1 (Kass and Raftery 1995, Journal of the American
/// Statistical Association 90).
const MIN_DECISIVE_BIC_DIFFERENCE: f64 = 10.0;
/// Largest misfit over noise at which the highest number of poles tried counts as sufficient.
const MAX_MISFIT_OF_LAST_POLE: f64 = 2.0;
/// Largest number of warnings that are listed.
const MAX_LISTED_WARNINGS: usize = 4;

/// A verdict for each test: `roving hammer: use peak, which is enough for all 6 observable modes.`
pub fn method_sentences(needs: &SceneNeeds) -> Vec<String> {
    let tests = needs.tests.iter();
    tests
        .map(|test| format!("{}: {}", test.name, simplest_method(test)))
        .collect()
}

/// The simplest method that has every observable mode of the refined solution and no other.
fn simplest_method(test: &TestNeeds) -> String {
    if test.modes == 0 {
        return "no mode was identified in the band.".to_owned();
    }
    if test.single.is_empty() {
        return "no mode is observable at this noise.".to_owned();
    }
    let methods = test.single.first().map_or(&[][..], |mode| &mode.single);
    let is_enough = |name: &&str| {
        let mut modes = test.single.iter();
        modes.all(|mode| {
            let mut single = mode.single.iter();
            single.any(|single| single.method == *name && single.is_sufficient)
        })
    };
    let single = methods.iter().map(|single| single.method).find(is_enough);
    if let Some(name) = single {
        return format!(
            "use {name}, which is enough for all {}.",
            counted(test.single.len(), "observable mode")
        );
    }
    let mut with_order = test.orders.iter();
    let lowest = with_order.find_map(|method| Some((method.method, method.lowest()?)));
    let reason = "no method of one mode at a time has all modes";
    match lowest {
        Some((method, order)) => format!("use {method} order {order}: {reason}."),
        None => format!("use ml: {reason}, and no other method at any tried order."),
    }
}

/// The needs of a scene in sentences: modes, orders and methods of every test, theory, parameters.
pub fn summarise_needs(needs: &SceneNeeds) -> Vec<String> {
    let of_test = |test: &TestNeeds| {
        let all = [
            modes(test),
            warnings(test),
            orders(test),
            single(test, needs),
        ];
        let synthetic = if test.synthetic { " (synthetic)" } else { "" };
        let named = |text: String| format!("{}{synthetic}: {text}", test.name);
        all.map(|text| text.map(named))
    };
    let tests = needs.tests.iter().flat_map(of_test).flatten();
    let failed = needs.failed.iter();
    let failed = failed.map(|(name, reason)| format!("{name}: not analysed: {reason}."));
    tests.chain(failed).chain(needs_of_model(needs)).collect()
}

/// The simplest theory and the fewest parameters, in a sentence each.
pub fn needs_of_model(needs: &SceneNeeds) -> [String; 2] {
    let theory = match &needs.theory {
        Ok(simplest) => theory(simplest, needs.options.theory_percent),
        Err(reason) => format!("Theory: nothing simpler to compare with: {reason}."),
    };
    let parameters = match &needs.parameters {
        Ok(needs) => parameters(needs),
        Err(reason) => format!("Parameters: not compared: {reason}."),
    };
    [theory, parameters]
}

fn places(tried: &[OrderStep]) -> String {
    let poles = tried.iter().filter_map(|step| step.pole);
    let text = poles.map(|pole| format!("{:.2}", pole.natural_frequency_hz()));
    format!("{} Hz", listed(&text.collect::<Vec<_>>()))
}

fn modes(test: &TestNeeds) -> Option<String> {
    let selection = &test.support;
    let (by_bic, identified) = (selection.by_bic(), selection.identified);
    let damped = test.modes.saturating_sub(test.undamped);
    let mut repeated = match damped.saturating_sub(identified) {
        0 => String::new(),
        _ => format!(" ({} at roots that modes share)", counted(damped, "mode")),
    };
    if test.undamped > 0 {
        repeated += &format!(
            ", and {} without damping, no roots",
            counted(test.undamped, "mode")
        );
    }
    let taken = selection.tried.get(by_bic)?;
    let against = if by_bic < identified {
        let more = &selection.tried[by_bic + 1..=identified];
        format!(
            "; the identified root at {} explains less than it costs",
            places(more)
        )
    } else if by_bic > identified {
        let more = &selection.tried[identified + 1..=by_bic];
        format!(
            "; poles at {} that `ml` made no damped mode of explain more than they cost: the model misses part of the data there",
            places(more)
        )
    } else {
        String::new()
    };
    let last = match by_bic + 1 == selection.tried.len() && taken.rest > MAX_MISFIT_OF_LAST_POLE {
        true => "at least ",
        false => "",
    };
    let undecided = by_bic != identified
        && selection.tried[identified].bic - taken.bic < MIN_DECISIVE_BIC_DIFFERENCE;
    let undecided = match undecided {
        true => {
            format!(" (BIC differs by less than {MIN_DECISIVE_BIC_DIFFERENCE:.0}: not decided)")
        }
        false => String::new(),
    };
    let predicted = match selection.by_prediction() {
        Some(roots) => format!("{roots} are enough to predict left-out lines"),
        None => "too few lines can be left out to predict them".to_owned(),
    };
    let noise = match selection.noise_stated {
        true => "the stated noise",
        false => "the noise, estimated from the fit residual as the data have no variance",
    };
    Some(format!(
        "the data support {last}{} by BIC, {predicted}, {} leave a residual at most a tenth larger; `ml` identified {identified}{repeated}. With \
         {by_bic} the misfit is {:.2} times {noise}{against}{undecided}.",
        counted(by_bic, "root"),
        selection.by_residual(),
        taken.rest
    ))
}

fn warnings(test: &TestNeeds) -> Option<String> {
    let all = test
        .warnings
        .iter()
        .take(MAX_LISTED_WARNINGS)
        .map(ToString::to_string);
    let all: Vec<String> = all.collect();
    let more = match test.warnings.len().saturating_sub(MAX_LISTED_WARNINGS) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    (!all.is_empty()).then(|| format!("warnings of its identification: {}{more}.", all.join("; ")))
}

fn orders(test: &TestNeeds) -> Option<String> {
    let of = |lowest: &LowestOrder| {
        let itself = match lowest.chosen {
            None => "finds nothing itself".to_owned(),
            Some(taken) if taken.is_correct() => format!("takes {} itself", taken.order),
            Some(taken) => {
                let made = [(taken.missed, "misses"), (taken.spurious, "invents")];
                let made = made.into_iter().filter(|(number, _)| *number > 0);
                let made: Vec<String> = made
                    .map(|(number, what)| format!("{what} {number}"))
                    .collect();
                format!("takes {} itself and {}", taken.order, listed(&made))
            }
        };
        match lowest.lowest() {
            Some(order) => format!("{} {order} ({itself})", lowest.method),
            None if lowest.tried.is_empty() => format!("{} none ({itself})", lowest.method),
            None => format!("{} none that was tried ({itself})", lowest.method),
        }
    };
    let all: Vec<String> = test.orders.iter().map(of).collect();
    (!all.is_empty()).then(|| {
        format!(
            "lowest order that finds every observable mode of `ml` and no other: {}.",
            listed(&all)
        )
    })
}

fn single(test: &TestNeeds, needs: &SceneNeeds) -> Option<String> {
    let (modes, options) = (&test.single, &needs.options);
    if modes.is_empty() {
        return None;
    }
    let several: Vec<String> = modes
        .iter()
        .filter(|mode| mode.simplest().is_none())
        .map(|mode| format!("{:.2}", mode.frequency_hz))
        .collect();
    let simplest = |name: &str| {
        modes
            .iter()
            .filter(|mode| mode.simplest() == Some(name))
            .count()
    };
    let methods = modes[0].single.iter().map(|single| single.method);
    let by: Vec<String> = methods
        .filter(|name| simplest(name) > 0)
        .map(|name| format!("{name} for {}", simplest(name)))
        .collect();
    let by = match by.is_empty() {
        true => String::new(),
        false => format!(" ({})", listed(&by)),
    };
    let rest = match several.is_empty() {
        true => String::new(),
        false => format!("; none alone for {} Hz", listed(&several)),
    };
    Some(format!(
        "one mode at a time is enough for {} of {} observable modes{by}{rest}: within {} % in frequency and {} % in damping of `ml`, or two of its deviations.",
        modes
            .iter()
            .filter(|mode: &&ModeNeeds| mode.simplest().is_some())
            .count(),
        modes.len(),
        options.frequency_percent,
        options.damping_percent
    ))
}

fn theory(needs: &TheoryNeeds, percent: f64) -> String {
    match needs {
        TheoryNeeds::Coordinates {
            model,
            up_to_hz,
            roots,
            simplest,
            needed,
            whole,
        } => {
            let reach = up_to_hz.map_or(String::new(), |hz| format!(" up to {hz:.0} Hz"));
            if needed == whole {
                return format!(
                    "Theory: {model} needs all of its {whole} coordinates for its {}{reach} to {percent} %.",
                    counted(*roots, "root")
                );
            }
            format!(
                "Theory: {needed} of the {whole} coordinates of {model} are enough ({simplest}) for its {}{reach} to {percent} %.",
                counted(*roots, "root")
            )
        }
        TheoryNeeds::Details {
            model,
            signals,
            whole,
        } => {
            let of = |(signal, detail): &(String, Option<String>)| {
                format!("{signal} {}", detail.as_deref().unwrap_or(whole))
            };
            let all: Vec<String> = signals.iter().map(of).collect();
            format!(
                "Theory: the simplest detail of {model} within {percent} % of \"{whole}\": {}.",
                listed(&all)
            )
        }
    }
}

fn parameters(needs: &ParameterNeeds) -> String {
    let [none, needed, all] = needs.chi_square.map(short);
    let which = match needs.needed.len() {
        0 => "none has to change".to_owned(),
        number => format!(
            "{number} of {} {} to change ({})",
            needs.free.len(),
            if number == 1 { "has" } else { "have" },
            listed(&needs.needed)
        ),
    };
    let how = match (needs.explains, needs.needed.is_empty()) {
        (true, true) => "as the misfit is within its uncertainty",
        (true, false) => "which explains the misfit",
        (false, _) => "which is best by BIC and does not explain the misfit",
    };
    let unseen = match needs.not_supported.is_empty() {
        true => String::new(),
        false => format!(
            " Not supported by the data: {}.",
            listed(&needs.not_supported)
        ),
    };
    let beside_all = match needs.needed.len() == needs.free.len() {
        true => String::new(),
        false => format!(", {all} with all {} free", needs.free.len()),
    };
    let freedom = needs.data.saturating_sub(needs.needed.len()) as f64;
    let wide = match uncertainties_over_errors(needs.chi_square[1], freedom) {
        Some(ratio) => format!(
            " χ² this far below its {freedom:.0} degrees of freedom means that the stated uncertainties are about {ratio:.0} times the errors."
        ),
        None => String::new(),
    };
    format!(
        "Parameters: {which}, {how}: χ² of {} residuals is {none} before and {needed} after{beside_all}.{wide}{unseen}",
        needs.data
    )
}

/// Four digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = 3 - value.abs().log10().floor() as i32;
    format!("{value:.*}", decimals.clamp(0, 9) as usize)
}

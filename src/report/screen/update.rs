//! The screen of `update`: parameters, misfit before and after, and whether it converged.

use crate::frf::HitReport;
use crate::printable::listed;
use crate::report::table::significant;
use crate::report::update::{
    alternatives_text, convergence_text, fit_before, fit_summary, misfit_footnote,
    parameter_verdict, reasons_without_support,
};
use crate::report::update_configurations::{
    configurations_block, contradiction_text, scatter_text,
};
use crate::report::{Block, Cell, Column, Table};
use crate::scene::SceneUpdate;
use crate::update::{UpdateResult, UpdatedParameter};

use super::hits::hit_sentence;
use super::{fitted, sentences};

/// Number of parameters above which those that the update held are named below the table.
const MAX_ROWS: usize = 12;
/// Maximum number of fitted tests that are named, not counted.
const MAX_NAMED_TESTS: usize = 6;

/// The fitted tests, their hits and the modes of the model that the tests did not see; the
/// parameters before and after with standard deviation and verdict, the fit before and after, and
/// the end of the iteration.
pub fn update_screen(title: &str, scene_update: &SceneUpdate, width: usize) -> Vec<Block> {
    let row = |parameter: &UpdatedParameter| {
        let change = 100.0 * (parameter.updated / parameter.initial - 1.0);
        vec![
            Cell::text(&parameter.name),
            Cell::text(&parameter.unit),
            Cell::text(significant(parameter.initial, 5)),
            Cell::text(as_fine_as(parameter.updated, parameter.std)),
            Cell::text(significant(parameter.std, 2)),
            Cell::signed(Some(change).filter(|change| change.is_finite()), 2),
            Cell::text(parameter_verdict(parameter)),
        ]
    };
    let numbers = ["before", "after", "std", "change (%)"];
    let mut columns = vec![Column::text("parameter"), Column::text("unit")];
    columns.extend(numbers.map(Column::number));
    columns.push(Column::text("verdict"));
    let result = &scene_update.result;
    let hides_held = result.parameters.len() > MAX_ROWS;
    let is_shown = |parameter: &&UpdatedParameter| !(hides_held && parameter.held);
    let shown: Vec<&UpdatedParameter> = result.parameters.iter().filter(is_shown).collect();
    let parameters = Table {
        columns,
        rows: shown.iter().map(|parameter| row(parameter)).collect(),
        footnotes: [
            hides_held.then(|| held_parameters(result)).flatten(),
            Some(misfit_footnote(result)),
            contradiction_text(result),
            scatter_text(scene_update),
            reasons_without_support(result),
            alternatives_text(result, 1),
        ]
        .into_iter()
        .flatten()
        .collect(),
        ..Table::default()
    };
    let fits = [
        fit_before(scene_update),
        fit_summary("After", &result.after),
        convergence_text(result),
    ];
    let mut blocks = vec![Block::Heading(title.to_owned())];
    let with_hits = scene_update
        .all_tests()
        .filter(|test| !test.hits.is_empty());
    let hits: Vec<HitReport> = with_hits
        .clone()
        .flat_map(|test| test.hits.clone())
        .collect();
    let others = scene_update.configurations.iter();
    let tables = std::iter::once(&scene_update.before).chain(others.map(|other| &other.before));
    let fitted_tests = tables.flat_map(|table| &table.summary);
    let fitted_tests: Vec<&str> = fitted_tests.map(|test| test.test.as_str()).collect();
    let fitted_tests = match fitted_tests.len() {
        count if count > MAX_NAMED_TESTS => format!("Fitted: {count} tests."),
        _ => format!("Fitted: {}.", listed(&fitted_tests)),
    };
    let data = match hits.is_empty() {
        true => fitted_tests,
        false => format!("{fitted_tests} {}", hit_sentence(&hits, with_hits.count())),
    };
    let seen = [
        Some(data),
        sentences::unseen_modes("Modes of the updated model", &scene_update.after),
        sentences::synthetic(scene_update.all_tests()),
    ];
    let seen: Vec<String> = seen.into_iter().flatten().collect();
    blocks.extend((!seen.is_empty()).then(|| Block::Text(seen.join("\n"))));
    blocks.push(Block::Table(fitted(
        parameters,
        &["unit", "change (%)"],
        width,
    )));
    blocks.extend(configurations_block(result));
    blocks.push(Block::Text(fits.join("\n")));
    let proposed = scene_update.explanation.as_ref();
    blocks.extend(proposed.map(crate::report::update::proposal));
    blocks
}

/// The parameters that the update held where they started; `None` without any.
fn held_parameters(result: &UpdateResult) -> Option<String> {
    let held = result.parameters.iter().filter(|parameter| parameter.held);
    let names: Vec<&str> = held.map(|parameter| parameter.name.as_str()).collect();
    (!names.is_empty())
        .then(|| format!("Held, as the test does not see them: {}.", names.join(", ")))
}

/// A value to the second digit of its standard deviation, in two to five significant digits, zeros
/// at the end among them.
fn as_fine_as(value: f64, std: f64) -> String {
    let digits = value.abs().log10().floor() - std.log10().floor() + 2.0;
    if value == 0.0 || !digits.is_finite() {
        return significant(value, MAX_DIGITS);
    }
    let digits = digits.clamp(2.0, MAX_DIGITS as f64) as usize;
    let rounded = format!("{value:.*e}", digits - 1);
    let exponent = rounded.split_once('e').map(|(_, exponent)| exponent);
    match exponent.and_then(|exponent| exponent.parse::<i32>().ok()) {
        Some(exponent @ -3..=5) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            let value: f64 = rounded.parse().unwrap_or(value);
            format!("{value:.decimals$}")
        }
        _ => rounded,
    }
}

/// Most significant digits of a value.
const MAX_DIGITS: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_every_digit_that_its_standard_deviation_supports() {
        for (value, std, expected) in [
            (2.02e11, 2.3e8, "2.0200e11"),
            (0.012, 0.0011, "0.0120"),
            (0.131, 0.042, "0.131"),
            (0.027, 0.031, "0.027"),
            (1234.5, 80.0, "1234"),
            (3.0e-5, 2.3e-6, "3.00e-5"),
            (0.0, 0.1, "0"),
            (7850.0, 0.0, "7850"),
        ] {
            assert_eq!(as_fine_as(value, std), expected);
        }
    }
}

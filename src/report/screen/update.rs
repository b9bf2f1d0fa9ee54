//! The screen of `update`: parameters, misfit before and after, and whether it converged.

use crate::frf::HitReport;
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

use super::hits::hit_sentence;
use super::{fitted, sentences};

/// The hits used and the modes of the model that the tests did not see; the parameters before and
/// after with standard deviation and verdict, the fit before and after, and the end of the
/// iteration.
pub fn update_screen(title: &str, scene_update: &SceneUpdate, width: usize) -> Vec<Block> {
    let row = |parameter: &crate::update::UpdatedParameter| {
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
    let parameters = Table {
        columns,
        rows: result.parameters.iter().map(row).collect(),
        footnotes: [
            Some(misfit_footnote(result)),
            contradiction_text(result),
            scatter_text(result),
            reasons_without_support(result),
            alternatives_text(result),
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
    let hits: Vec<HitReport> = scene_update
        .all_tests()
        .flat_map(|test| test.hits.clone())
        .collect();
    let seen = [
        (!hits.is_empty()).then(|| hit_sentence(&hits)),
        sentences::unseen_modes(&scene_update.after),
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

/// A value to the second digit of its standard deviation, in two to five significant digits.
fn as_fine_as(value: f64, std: f64) -> String {
    let digits = value.abs().log10().floor() - std.log10().floor() + 2.0;
    let digits = match digits.is_finite() {
        true => digits.clamp(2.0, 5.0) as usize,
        false => 5,
    };
    significant(value, digits)
}

//! The tables of an update of several configurations: what each one contributes, and whether they
//! agree.

use crate::printable::counted;
use crate::scene::SceneUpdate;
use crate::update::{Contribution, MAX_POSTERIOR_OVER_PRIOR, UpdateResult};

use super::table::significant;
use super::{Block, Cell, Column, Table};

/// Largest number of parameters that a cell lists.
const MAX_LISTED_PARAMETERS: usize = 4;

/// One row for each configuration: its modes, its residuals, and the parameters that it determines
/// without the others. `None` where there is one configuration.
pub(super) fn configurations_block(result: &UpdateResult) -> Option<Block> {
    let row = |contribution: &Contribution| {
        vec![
            Cell::text(&contribution.configuration),
            Cell::text(contribution.paired.to_string()),
            Cell::text(contribution.residuals.to_string()),
            Cell::text(significant(contribution.chi_square, 3)),
            Cell::text(determined_alone(result, contribution)),
        ]
    };
    let mut columns = vec![Column::text("configuration")];
    columns.extend(["modes", "residuals", "chi-square"].map(Column::number));
    columns.push(Column::text("determines alone"));
    let contributions = &result.contributions;
    (!contributions.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Contribution of each configuration".to_owned(),
            columns,
            rows: contributions.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}

/// Names of the parameters that one configuration determines without the others.
fn determined_alone(result: &UpdateResult, contribution: &Contribution) -> String {
    let parameters = result.parameters.iter().zip(&contribution.std_alone);
    let determined = parameters.filter(|(parameter, std)| {
        // On the scale of the prior, at the updated value.
        let prior_std = parameter.std / parameter.posterior_over_prior;
        std.is_some_and(|std| std <= MAX_POSTERIOR_OVER_PRIOR * prior_std)
    });
    let names: Vec<&str> = determined
        .map(|(parameter, _)| parameter.name.as_str())
        .collect();
    match names.len() {
        0 => "—".to_owned(),
        count if count > MAX_LISTED_PARAMETERS => {
            let listed = names[..MAX_LISTED_PARAMETERS].join(", ");
            format!("{listed}, +{}", count - MAX_LISTED_PARAMETERS)
        }
        _ => names.join(", "),
    }
}

/// The standard deviation of each parameter from all configurations and from each one alone. `None`
/// where there is one configuration.
pub(super) fn deviations_block(result: &UpdateResult) -> Option<Block> {
    let contributions = &result.contributions;
    let mut columns = vec![
        Column::text("parameter"),
        Column::text("unit"),
        Column::number("std"),
    ];
    for contribution in contributions {
        columns.push(Column::number(format!(
            "std by {} alone",
            contribution.configuration
        )));
    }
    let row = |(j, parameter): (usize, &crate::update::UpdatedParameter)| {
        let mut cells = vec![
            Cell::text(&parameter.name),
            Cell::text(&parameter.unit),
            Cell::text(significant(parameter.std, 3)),
        ];
        cells.extend(contributions.iter().map(|contribution| {
            let std = contribution.std_alone[j];
            Cell::text(std.map_or_else(|| "—".to_owned(), |std| significant(std, 3)))
        }));
        cells
    };
    (!contributions.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Standard deviation by each configuration".to_owned(),
            columns,
            rows: result.parameters.iter().enumerate().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}

/// The shared parameter that contradicts most between the configurations.
pub(super) fn contradiction_text(result: &UpdateResult) -> Option<String> {
    let found = result.contradiction.as_ref()?;
    let rest = match found.explains {
        true => "",
        false => " More than this parameter differs.",
    };
    Some(format!(
        "Configurations disagree: {} = {} {} in {}, {} elsewhere explains {} of chi-square {}.{rest}",
        found.parameter,
        significant(found.there, 4),
        found.unit,
        found.configuration,
        significant(found.elsewhere, 4),
        significant(found.decrease, 3),
        significant(found.chi_square, 3)
    ))
}

/// The scatter of the frequencies between tests, where it was requested.
pub(super) fn scatter_text(update: &SceneUpdate) -> Option<String> {
    if !update.options.scatter_between_tests {
        return None;
    }
    let Some(scatter) = &update.result.scatter else {
        let text =
            "Scatter between tests: unknown, no two tests of a configuration measure a root.";
        return Some(text.to_owned());
    };
    let percent = significant(100.0 * scatter.relative_std, 3);
    let freedom = counted(scatter.degrees_of_freedom, "degree of freedom");
    Some(format!(
        "Scatter of the frequencies between tests: {percent} % ({freedom}), part of each deviation."
    ))
}

//! The tables of published results compare them with the model and with each other.

use crate::correlate::ErrorReference;
use crate::correlate::published::{
    ClaimValue, ClaimVerdict, Digits, ErrorSummary, Largest, PublishedRoot, RecomputedRow,
    RecomputedTable, RootMatch, RootRow, TestErrors, frequency_hz,
};
use crate::scene::{ExpectedResult, Source, Theory};
use crate::theory::ModelQuantity;

use super::comparison::theory_sources;
use super::modes::{largest_energy_fractions, root_labels};
use super::table::seven_digits;
use super::verdict::Verdict;
use super::{Block, Cell, Column, Table};

/// The published natural frequencies and those of the model; `None` where none are printed.
///
/// With the number of the first elastic root a published label that looks like that of a mode has
/// the label of the mode beside it where the two differ, because the publication counts otherwise.
pub fn published_roots_block(
    expected: &ExpectedResult,
    theory: &Theory,
    first_root: Option<usize>,
) -> Option<Block> {
    let roots = expected.roots.as_ref()?;
    let in_hz = roots.published().all(|root| root.printed_hz.is_some());
    let (model_head, printed_head) = match in_hz {
        true => ("model (Hz)", "printed (Hz)"),
        false => ("model (rad/s)", "printed (rad/s)"),
    };
    let columns = vec![
        Column::text("root"),
        Column::number("M"),
        Column::number(model_head),
        Column::number("M printed"),
        Column::number(printed_head),
        Column::number("error (%)"),
        Column::text("class of the model"),
        Column::text("class as printed"),
        Column::text("kinetic energy"),
    ];
    let labels = first_root.map(|first| root_labels(&theory.roots, first));
    let modes: Vec<(f64, String)> = theory
        .roots
        .iter()
        .map(|root| root.omega_rad_s)
        .zip(labels.into_iter().flatten())
        .collect();
    // The many roots of a discretised model above the highest printed one are not compared.
    let shown = roots
        .rows
        .iter()
        .rposition(|row| row.published.is_some())
        .map_or(0, |last| last + 1);
    Some(Block::Table(Table {
        caption: "Published natural frequencies and the model".to_owned(),
        columns,
        rows: (1..)
            .zip(&roots.rows[..shown])
            .map(|(number, row)| root_cells(number, row, in_hz, &modes))
            .collect(),
        footnotes: root_footnotes(roots, shown, &expected.source)
            .into_iter()
            .chain(theory_sources(theory))
            .collect(),
    }))
}

/// The published label, with that of the mode where both are such labels and differ.
fn label_with_mode(published: &str, row: &RootRow, modes: &[(f64, String)]) -> String {
    let is_mode_label = |label: &str| {
        let number = label.strip_prefix('f');
        number.is_some_and(|number| number.parse::<usize>().is_ok())
    };
    let omega = row.model.as_ref().map(|root| root.omega_rad_s);
    let mut found = modes.iter();
    let mode = found.find(|(root, label)| omega == Some(*root) && is_mode_label(label));
    match mode {
        Some((_, label)) if is_mode_label(published) && label != published => {
            format!("{published} (mode {label})")
        }
        _ => published.to_owned(),
    }
}

/// `in_hz`: every root is printed as a frequency; `modes`: angular frequencies of the roots of the
/// model with their labels.
fn root_cells(number: usize, row: &RootRow, in_hz: bool, modes: &[(f64, String)]) -> Vec<Cell> {
    let (model, published) = (row.model.as_ref(), row.published.as_ref());
    let whole = |n: usize| Cell::text(n.to_string());
    let text = |text: Option<&String>| text.map_or(Cell::Missing, Cell::text);
    let frequency = model.map(|root| match in_hz {
        true => frequency_hz(root.omega_rad_s),
        false => root.omega_rad_s,
    });
    let printed = |root: &PublishedRoot| match root.printed_hz.filter(|_| in_hz) {
        Some(hz) => hz.to_string(),
        None => root.omega_rad_s.to_string(),
    };
    let energy = model.map(largest_energy_fractions);
    let label = published.map_or_else(
        || format!("root {number}: not printed"),
        |root| label_with_mode(&root.label, row, modes),
    );
    vec![
        Cell::text(label),
        model.map_or(Cell::Missing, |root| whole(root.modes.len())),
        Cell::number(frequency, 6),
        published.map_or(Cell::Missing, |root| whole(root.multiplicity)),
        published.map_or(Cell::Missing, |root| Cell::text(printed(root))),
        Cell::signed(row.error_percent, 4),
        text(model.and_then(|root| root.class.as_ref())),
        text(published.and_then(|root| root.class.as_ref())),
        energy.map_or(Cell::Missing, Cell::Text),
    ]
}

fn root_footnotes(roots: &RootMatch, shown: usize, source: &Source) -> Vec<String> {
    let error_sentence = |what: &str, errors: &Option<ErrorSummary>| {
        errors.as_ref().map(|errors| {
            format!(
                "{what}, {} of them: rms error {:.4} %, largest {:+.4} % at {}.",
                errors.count, errors.rms_percent, errors.largest_percent, errors.largest_at
            )
        })
    };
    let mut notes = vec![
        format!("Printed: {}.", source_text(source)),
        "M: multiplicity. Error = (model - printed)/printed. Matched by frequency alone. Kinetic energy: the largest shares by body, bodies of the same kind are summed.".to_owned(),
    ];
    notes.extend(error_sentence("Single roots above 0", &roots.simple));
    let calibrated = roots.published().filter(|root| root.calibrated);
    let calibrated: Vec<&str> = calibrated.map(|root| root.label.as_str()).collect();
    if !calibrated.is_empty() {
        let labels = calibrated.join(" ");
        notes.push(format!(
            "{labels}: agree by construction, as a parameter of the model was inferred from them."
        ));
    }
    notes.extend(error_sentence("All roots above 0", &roots.elastic));
    let without = roots.rows[..shown]
        .iter()
        .filter(|row| row.model.is_none())
        .filter_map(|row| row.published.as_ref());
    notes.extend(without.map(|root| format!("{}: the model has no root near it.", root.label)));
    if shown < roots.rows.len() {
        let more = roots.rows.len() - shown;
        notes.push(format!(
            "Roots of the model above these: {more}, not shown."
        ));
    }
    notes
}

/// Authors (year), title, journal, DOI.
fn source_text(source: &Source) -> String {
    let mut text = format!("{} ({}), {}", source.authors, source.year, source.paper);
    for part in [
        source.journal.clone(),
        source.doi.as_ref().map(|doi| format!("doi:{doi}")),
    ]
    .into_iter()
    .flatten()
    {
        text.push_str(", ");
        text.push_str(&part);
    }
    text
}

/// A published comparison of theory and tests with its errors; `None` where there is none.
pub fn published_comparison_block(expected: &ExpectedResult) -> Option<Block> {
    let table = expected.comparison.as_ref()?;
    let percent = match table.error_reference {
        ErrorReference::Theory => "(test−theory)/theory (%)",
        ErrorReference::Test => "(theory−test)/test (%)",
    };
    let mut columns = vec![
        Column::text("label"),
        Column::number("theory (Hz)"),
        Column::number("root/2π (Hz)"),
    ];
    for test in &table.tests {
        columns.push(Column::number(format!("{}: test (Hz)", test.test)));
        columns.push(Column::number(format!("{}: error (Hz)", test.test)));
        columns.push(Column::number(format!("{}: {percent}", test.test)));
    }
    let mut rows: Vec<Vec<Cell>> = table.rows.iter().map(comparison_cells).collect();
    rows.push(summary_cells("max |error|", table, |test| {
        let value = |largest: &Option<Largest>| largest.as_ref().map(|largest| largest.value);
        [value(&test.largest_hz), value(&test.largest_percent)]
    }));
    rows.push(summary_cells("mean |error|", table, |test| {
        [None, test.mean_percent]
    }));
    let mut footnotes = vec![
        format!("Printed: {}.", source_text(&expected.source)),
        "Theory and test as printed, errors recomputed. —: missed by the test, or unknown."
            .to_owned(),
    ];
    footnotes.extend(table.tests.iter().filter_map(largest_errors_note));
    Some(Block::Table(Table {
        caption: "The published comparison, recomputed".to_owned(),
        columns,
        rows,
        footnotes,
    }))
}

fn comparison_cells(row: &RecomputedRow) -> Vec<Cell> {
    let mut cells = vec![
        Cell::text(&row.label),
        Cell::text(row.theory_hz.to_string()),
        Cell::number(row.root_hz, 2),
    ];
    for cell in &row.tests {
        cells.extend(cell.map_or([const { Cell::Missing }; 3], |cell| {
            [
                Cell::text(cell.hz.to_string()),
                Cell::signed(Some(cell.error_hz), 0),
                Cell::signed(Some(cell.error_percent), 2),
            ]
        }));
    }
    cells
}

/// A closing row: a number in Hz and one in percent for each test.
fn summary_cells(
    label: &str,
    table: &RecomputedTable,
    values: impl Fn(&TestErrors) -> [Option<f64>; 2],
) -> Vec<Cell> {
    let mut cells = vec![Cell::text(label), Cell::Missing, Cell::Missing];
    for test in &table.tests {
        let [hz, percent] = values(test);
        cells.extend([Cell::Missing, Cell::number(hz, 0), Cell::number(percent, 2)]);
    }
    cells
}

/// The largest errors of a test with their rows.
fn largest_errors_note(test: &TestErrors) -> Option<String> {
    let (hz, percent) = (test.largest_hz.as_ref()?, test.largest_percent.as_ref()?);
    Some(format!(
        "{}: largest error {} Hz at {}, {:.2} % at {}.",
        test.test,
        hz.value,
        hz.rows.join(" "),
        percent.value,
        percent.rows.join(" ")
    ))
}

/// The claims of a publication and whether they are reproduced; `None` without any.
pub fn claims_block(expected: &ExpectedResult) -> Option<Block> {
    let row = |claim: &ClaimVerdict| {
        let [printed, recomputed] = claim_values(claim);
        vec![
            Cell::text(&claim.text),
            printed,
            recomputed,
            Cell::text(claim_verdict(claim.confirmed).text()),
            claim.remark.clone().map_or(Cell::Missing, Cell::Text),
        ]
    };
    (!expected.verdicts.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Statements of the publication, recomputed from its tables and the model"
                .to_owned(),
            columns: vec![
                Column::text("claim"),
                Column::text("printed"),
                Column::text("recomputed"),
                Column::text("verdict"),
                Column::text("remark"),
            ],
            rows: expected.verdicts.iter().map(row).collect(),
            footnotes: vec![
                "A value is reproduced if the recomputed one rounds to it; a largest value must also be at the stated row. Not checkable: no data for the recomputation, or no printed number."
                    .to_owned(),
            ],
        })
    })
}

/// The value of a claim as printed and as recomputed.
pub(super) fn claim_values(claim: &ClaimVerdict) -> [Cell; 2] {
    // Two digits more than printed show how close a rounding is; a count has none to show.
    let counted = claim.unit.is_empty() && claim.digits == Digits::Decimals(0);
    let finer = claim.digits.finer(if counted { 0 } else { 2 });
    let found = claim.recomputed.as_ref();
    [
        stated_cell(&claim.printed, claim.relation, claim.digits, claim.unit),
        found.map_or(Cell::Missing, |found| {
            stated_cell(found, "", finer, claim.unit)
        }),
    ]
}

fn claim_verdict(confirmed: Option<bool>) -> Verdict {
    match confirmed {
        Some(true) => Verdict::Reproduced,
        Some(false) => Verdict::NotReproduced,
        None => Verdict::NotCheckable,
    }
}

/// `7.5 % at f2`, `> 25 Hz`, a count, or labels.
fn stated_cell(stated: &ClaimValue, relation: &str, digits: Digits, unit: &str) -> Cell {
    let rows = stated.rows.join(" ");
    match stated.value {
        None if rows.is_empty() => Cell::Missing,
        None => Cell::text(rows),
        Some(value) => {
            let value = format!("{relation} {} {unit}", digits.text(value));
            let at = if rows.is_empty() { "" } else { " at " };
            Cell::text(format!("{}{at}{rows}", value.trim()))
        }
    }
}

/// Further quantities of the theory of a model; `None` where there are none.
pub fn quantities_block(model: &str, quantities: &[ModelQuantity]) -> Option<Block> {
    let row = |quantity: &ModelQuantity| {
        vec![
            Cell::text(quantity.name),
            quantity
                .value
                .map_or(Cell::Missing, |value| Cell::text(seven_digits(value))),
            Cell::text(quantity.unit),
            Cell::text(&quantity.meaning),
        ]
    };
    (!quantities.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!("Further quantities of the theory of {model}"),
            columns: vec![
                Column::text("quantity"),
                Column::number("value"),
                Column::text("unit"),
                Column::text("meaning"),
            ],
            rows: quantities.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    })
}

//! The tables of an update list the parameters, their identifiable combinations, convergence, the
//! fit before and after, and the changes of one or two parameters.

use crate::correlate::{ComparisonTable, TestSummary};
use crate::finding::Code;
use crate::printable::counted;
use crate::scene::{SceneUpdate, Theory};
use crate::update::{
    Alternative, Explanation, Fit, FitRow, MAX_POSTERIOR_OVER_PRIOR, ModelError, ParameterVerdict,
    Residuals, ShapeWeights, SubsetFit, UpdateResult, UpdatedParameter, measured_mode,
    uncertainties_over_errors,
};

use super::comparison::{comparison_of_all_tests, error_head};
use super::screen::comparison_page_of_all_tests;
use super::table::significant;
use super::update_configurations::{
    configurations_block, contradiction_text, deviations_block, scatter_text,
};
use super::verdict::Verdict;
use super::{Block, Cell, Column, Table};

/// Maximum number of other optima that are printed.
const MAX_ALTERNATIVES: usize = 2;
/// Maximum number of printed changes; `update.json` has all.
const MAX_PRINTED_CHANGES: usize = 10;

/// Why the MAC of an update differs from that of a comparison.
pub(super) const MAC_OF_AN_UPDATE: &str = "MAC as weighted by the update: real parts alone, as those of an undamped model, each component over its standard deviation. A comparison uses the complex shapes, all components with equal weight.";

/// The marks of the numbers of modes.
const NUMBERS_OF_MODES: &str = "#2: second mode of the test, as identified; f2: second mode of the model, with which the comparison pairs it.";

/// All tables of an update.
pub fn update_blocks(title: &str, scene_update: &SceneUpdate) -> Vec<Block> {
    blocks_with(title, scene_update, comparison_of_all_tests)
}

/// All tables of an update, with the essential columns of the comparison.
pub fn update_page(title: &str, scene_update: &SceneUpdate) -> Vec<Block> {
    blocks_with(title, scene_update, comparison_page_of_all_tests)
}

fn blocks_with(
    title: &str,
    scene_update: &SceneUpdate,
    comparison: fn(&ComparisonTable, &Theory) -> Vec<Block>,
) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(title.to_owned())];
    blocks.push(Block::Text("Before".to_owned()));
    blocks.extend(comparison(
        &scene_update.before,
        &scene_update.theory_before,
    ));
    blocks.push(Block::Text("After".to_owned()));
    blocks.extend(comparison(&scene_update.after, &scene_update.theory_after));
    for other in &scene_update.configurations {
        blocks.push(Block::Text(format!("Configuration {}, before", other.name)));
        blocks.extend(comparison(&other.before, &other.theory_before));
        blocks.push(Block::Text(format!("Configuration {}, after", other.name)));
        blocks.extend(comparison(&other.after, &other.theory_after));
    }
    blocks.push(updated_parameters_block(scene_update));
    blocks.extend(configurations_block(&scene_update.result));
    blocks.extend(deviations_block(&scene_update.result));
    blocks.push(combinations_block(&scene_update.result));
    blocks.push(fits_block(scene_update));
    blocks.push(Block::Text(convergence_text(&scene_update.result)));
    blocks.extend(scene_update.explanation.iter().flat_map(explanation_blocks));
    blocks
}

fn updated_parameters_block(scene_update: &SceneUpdate) -> Block {
    let row = |p: &crate::update::UpdatedParameter| {
        vec![
            Cell::text(&p.name),
            Cell::text(&p.unit),
            Cell::text(significant(p.initial, 6)),
            Cell::text(significant(p.updated, 6)),
            Cell::signed(
                Some(100.0 * (p.updated / p.initial - 1.0)).filter(|c| c.is_finite()),
                3,
            ),
            Cell::text(significant(p.std, 3)),
            Cell::text(significant(p.prior_std, 3)),
            Cell::std(Some(p.posterior_over_prior), 3),
            Cell::text(parameter_verdict(p)),
        ]
    };
    let heads = [
        "initial",
        "updated",
        "change (%)",
        "std",
        "prior std",
        "std/prior",
    ];
    let mut columns = vec![Column::text("parameter"), Column::text("unit")];
    columns.extend(heads.map(Column::number));
    columns.push(Column::text("verdict"));
    let mut footnotes = vec![format!(
        "Weights: the standard deviations of the test, and a model error of {} % of each frequency (assumed).",
        without_round_off(100.0 * scene_update.options.frequency_floor)
    )];
    footnotes.extend(shape_footnotes(scene_update));
    footnotes.extend(residual_footnote(scene_update));
    footnotes.push(misfit_footnote(&scene_update.result));
    footnotes.extend(contradiction_text(&scene_update.result));
    footnotes.extend(scatter_text(scene_update));
    footnotes.extend(reasons_without_support(&scene_update.result));
    footnotes.extend(alternatives_text(&scene_update.result, MAX_ALTERNATIVES));
    footnotes.push("std: posterior with all free parameters uncertain; identified: at most half of the prior; held: the test does not determine it even if all others are fixed.".to_owned());
    Block::Table(Table {
        caption: "Updated parameters".to_owned(),
        columns,
        rows: scene_update.result.parameters.iter().map(row).collect(),
        footnotes,
    })
}

/// Whether the data determine a parameter, and whether the update held it.
pub(super) fn parameter_verdict(parameter: &crate::update::UpdatedParameter) -> String {
    match (Verdict::from(parameter.verdict), parameter.held) {
        (verdict, false) => verdict.text().to_owned(),
        (Verdict::NotSupported, true) => Verdict::NotSupportedHeld.text().to_owned(),
        (verdict, true) => format!("{}; held", verdict.text()),
    }
}

/// Footnotes on the standard deviations of the mode shapes.
fn shape_footnotes(scene_update: &SceneUpdate) -> Vec<String> {
    let Some(floor) = scene_update.options.shape_floor else {
        return vec![
            "Mode shapes serve pairing and mode tracking alone; they are not part of the residual."
                .to_owned(),
        ];
    };
    let mut all = vec![format!(
        "Weights of shapes: the standard deviations of the test, and a model error of {} % of the root mean square of the shape (assumed); complex shapes are rotated to the phase at which they are most real.",
        without_round_off(100.0 * floor)
    )];
    let rows = &scene_update.result.after.rows;
    let assumed = |row: &&FitRow| row.shape_weights == Some(ShapeWeights::Assumed);
    let labels: Vec<String> = rows
        .iter()
        .filter(assumed)
        .map(|row| measured_mode(&row.label))
        .collect();
    if !labels.is_empty() {
        let which = if labels.len() == rows.len() {
            "all modes".to_owned()
        } else {
            labels.join(", ")
        };
        all.push(format!(
            "The test states no standard deviations of the shapes of {which}: {} % of their root mean square is assumed.",
            without_round_off(100.0 * scene_update.options.assumed_shape_std)
        ));
    }
    all
}

/// Footnote on the kind of residual, unless it is frequencies and shapes.
fn residual_footnote(scene_update: &SceneUpdate) -> Option<String> {
    let floor = without_round_off(100.0 * scene_update.options.frf_floor);
    let count = scene_update.result.frfs.map(|counts| {
        let (compared, given, lines) = (counts.compared, counts.given, counts.lines);
        format!("{compared} of {given}, {lines} lines in all, ")
    });
    let count = count.unwrap_or_default();
    let frfs = |what: &str| {
        format!(
            "Residuals: {what} of the FRFs, {count}each divided by its standard deviation and a model error of {floor} % of its magnitude (assumed); the update starts from the fit of frequencies and shapes. Chi-square is that of the FRFs. Damping is as identified and is not updated. Errors common to all lines, of damping and calibration, are treated as independent: where the {floor} % exceed the noise, std and intervals are too small; use those of residuals = \"modes\" there."
        )
    };
    match scene_update.options.residuals {
        Residuals::Modes => None,
        Residuals::ModalDynamic => Some(
            "Residuals: dynamic residuals of the equations of motion at the measured modes, weighted by the standard deviations of frequency and shape.".to_owned(),
        ),
        Residuals::FrfComplex => Some(frfs("real and imaginary parts")),
        Residuals::FrfLogMagnitude => Some(frfs("logarithms of the magnitudes")),
    }
}

/// Reduced chi-square of all residuals and of the kinds that exceed noise, and its consequence for
/// the standard deviations.
pub(super) fn misfit_footnote(result: &UpdateResult) -> String {
    let figures = |of_what: &str| {
        format!(
            "Chi-square per degree of freedom{of_what} {} ({}; noise alone reaches {:.2})",
            significant(result.reduced_chi_square(), 4),
            counted(
                result.degrees_of_freedom().round() as usize,
                "degree of freedom"
            ),
            result.largest_reduced_chi_square()
        )
    };
    if result.fits() {
        let (chi_square, nu) = (result.after.chi_square, result.degrees_of_freedom());
        let wide = match uncertainties_over_errors(chi_square, nu) {
            Some(ratio) => format!(
                "\nThe stated uncertainties, frequency_floor among them, are about {} times the errors.",
                significant(ratio, 2)
            ),
            None => String::new(),
        };
        return figures("") + "." + &wide;
    }
    let grown = || {
        let errors = result.model_errors.iter();
        errors.filter(|error| error.growth > 1.0)
    };
    let figures = match result.model_errors.len() {
        0 | 1 => figures(""),
        _ => {
            let of_kind = |error: &ModelError| {
                format!(
                    ", {} {} (noise: {:.2})",
                    error.kind.of_what(),
                    significant(error.reduced_chi_square, 4),
                    error.largest_reduced_chi_square
                )
            };
            let kinds: Vec<String> = grown().map(of_kind).collect();
            figures(" of all residuals") + &kinds.concat()
        }
    };
    let growth = |error: &ModelError| {
        format!(
            "{} {:.1} times the stated ones (from {:.1} degrees of freedom)",
            error.kind.of_what(),
            error.growth,
            error.degrees_of_freedom
        )
    };
    let growths: Vec<String> = grown().map(growth).collect();
    let consequence = match growths.is_empty() {
        true => String::new(),
        false => format!(
            " Deviations are taken as larger, {}; std and verdicts include this model error.",
            growths.join(", ")
        ),
    };
    format!("{figures}: noise does not explain the residuals.{consequence}")
}

/// Why parameters are not supported: their standard deviation, or the modes and residuals that put
/// all in question; `None` where the standard deviation is the only reason.
pub(super) fn reasons_without_support(result: &UpdateResult) -> Option<String> {
    let of_verdict =
        |parameter: &&UpdatedParameter| parameter.verdict == ParameterVerdict::NotSupported;
    let (by_std, others): (Vec<_>, Vec<_>) = result
        .parameters
        .iter()
        .filter(of_verdict)
        .partition(|parameter| parameter.posterior_over_prior > MAX_POSTERIOR_OVER_PRIOR);
    let all = result.parameters.len();
    let lost = result.after.rows.len() - result.after.paired();
    let reason = match (result.unpredicted.len(), lost) {
        _ if result.contradiction.is_some() => "the configurations disagree".to_owned(),
        _ if result.starts.is_scattered() => format!(
            "1 of {} reaches the lowest optimum (more starts in [update])",
            counted(result.starts.count, "start")
        ),
        (0, 0) => "the model error has fewer than 3 degrees of freedom".to_owned(),
        (0, lost) => format!("{} lost the partner", counted(lost, "mode")),
        (count, _) => format!(
            "of {} not predicted from the others (--explain mode-not-predicted)",
            counted(count, "mode")
        ),
    };
    let by_std = match by_std.len() {
        0 => String::new(),
        count => format!("{count} of {all} because of their std, "),
    };
    (!others.is_empty()).then(|| {
        format!(
            "Not supported by the data: {by_std}{} of {all} because {reason}.",
            others.len()
        )
    })
}

/// The first optima of about the same objective, `most` of them, each with what separates it from
/// the best, and the number of further ones.
pub(super) fn alternatives_text(result: &UpdateResult, most: usize) -> Option<String> {
    let text = |other: &Alternative| {
        let parameters = result.parameters.iter().zip(&other.values);
        let values = parameters
            .filter(|(parameter, _)| parameter.verdict == ParameterVerdict::Ambiguous)
            .map(|(parameter, value)| format!("{} = {}", parameter.name, significant(*value, 4)));
        let values: Vec<String> = values.collect();
        let separation = other.separation.as_ref().map_or_else(String::new, |mode| {
            let of = mode.configuration.as_ref();
            let of = of.map_or_else(String::new, |name| format!(" of {name}"));
            format!(
                "; model mode {}{of} differs most: {} Hz against {} Hz, MAC {:.2}",
                mode.mode,
                significant(mode.hz, 5),
                significant(mode.other_hz, 5),
                mode.mac
            )
        });
        format!("Fits as well: {}{separation}.", values.join(", "))
    };
    let others = result.alternatives.iter();
    let listed: Vec<String> = others.take(most).map(text).collect();
    let further = result.alternatives.len() - listed.len();
    let listed = (!listed.is_empty()).then(|| listed.join("\n"))?;
    Some(match further {
        0 => listed,
        _ => format!("{listed} Further optima that fit as well: {further} (update.json)."),
    })
}

fn combinations_block(result: &UpdateResult) -> Block {
    let row = |c: &crate::update::Combination| {
        vec![
            Cell::text(significant(c.singular_value, 4)),
            Cell::std(Some(c.posterior_over_prior), 4),
            Cell::text(&c.text),
        ]
    };
    Block::Table(Table {
        caption: "Identifiable combinations of the parameters, in prior standard deviations"
            .to_owned(),
        columns: vec![
            Column::number("singular value"),
            Column::number("std/prior"),
            Column::text("combination"),
        ],
        rows: result.combinations.iter().map(row).collect(),
        footnotes: Vec::new(),
    })
}

fn fits_block(scene_update: &SceneUpdate) -> Block {
    let (before, after) = (&scene_update.result.before, &scene_update.result.after);
    let error = error_head(scene_update.options.pair.error_reference);
    let (error_before, error_after) = (format!("before\n{error}"), format!("after\n{error}"));
    let row = |(b, a): (&crate::update::FitRow, &crate::update::FitRow)| {
        vec![
            Cell::text(measured_mode(&b.label)),
            Cell::number(Some(b.test_hz), 3),
            Cell::number(b.model_hz, 3),
            Cell::signed(b.error_percent, 3),
            Cell::mac(b.mac, 4),
            Cell::number(a.model_hz, 3),
            Cell::std(a.model_std_hz, 3),
            Cell::signed(a.error_percent, 3),
            Cell::mac(a.mac, 4),
        ]
    };
    let heads = [
        "test (Hz)",
        "before (Hz)",
        &error_before,
        "MAC before",
        "after (Hz)",
        "std (Hz)",
        &error_after,
        "MAC after",
    ];
    let mut columns = vec![Column::text("mode")];
    columns.extend(heads.map(Column::number));
    let all = before.rows.iter().chain(&after.rows);
    let shapes = all.into_iter().any(|row| row.mac.is_some());
    let macs = shapes.then(|| MAC_OF_AN_UPDATE.to_owned());
    Block::Table(Table {
        caption: "Modes used in the update".to_owned(),
        columns,
        rows: before.rows.iter().zip(&after.rows).map(row).collect(),
        footnotes: [fit_summary("Before", before), fit_summary("After", after)]
            .into_iter()
            .chain(macs)
            .chain([NUMBERS_OF_MODES.to_owned()])
            .collect(),
    })
}

/// The fit before the update, with the modes that the update leaves out, and why a comparison with
/// the same model counts other pairs.
pub(super) fn fit_before(update: &SceneUpdate) -> String {
    let findings = update.findings.iter();
    let doubtful = findings
        .filter(|(_, finding)| finding.code == Code::DoubtfulLeftOut)
        .count();
    let left_out = [
        (doubtful, "doubtful test mode"),
        (update.result.left_out.len(), "test mode without partner"),
    ];
    let left_out = left_out.into_iter().filter(|(count, _)| *count > 0);
    let left_out: Vec<String> = left_out
        .map(|(count, what)| {
            counted(count, what).replace("mode without partners", "modes without partner")
        })
        .collect();
    let mut text = fit_summary("Before", &update.result.before);
    if !left_out.is_empty() {
        text += &format!(" Left out: {}.", left_out.join(", "));
    }
    let others = update.configurations.iter().map(|other| &other.before);
    let tables: Vec<&ComparisonTable> = others.chain([&update.before]).collect();
    let sum = |count: fn(&TestSummary) -> usize| -> usize {
        let summaries = tables.iter().flat_map(|table| &table.summary);
        summaries.map(count).sum()
    };
    let (paired, ambiguous) = (sum(|test| test.paired), sum(|test| test.ambiguous));
    if paired != update.result.before.paired() {
        let reasons = [
            (doubtful > 0).then_some("doubtful modes count there"),
            (ambiguous > 0).then_some("ambiguous pairs do not count there"),
        ];
        let mut reasons: Vec<&str> = reasons.into_iter().flatten().collect();
        if reasons.is_empty() {
            reasons.push(
                "modes outside band_hz of [update] count there, repeated roots count once there",
            );
        }
        text += &format!(
            " The comparison has {}: {}.",
            counted(paired, "pair"),
            reasons.join(", ")
        );
    }
    text
}

/// Pairs, errors and chi-square of a fit.
pub(super) fn fit_summary(name: &str, fit: &Fit) -> String {
    let percent = |value: Option<f64>| value.map_or("—".to_owned(), |v| format!("{v:.3} %"));
    format!(
        "{name}: {} of {} paired; largest error {}, rms {}, chi-square {} of {}.",
        fit.paired(),
        counted(fit.rows.len(), "mode"),
        percent(fit.largest_percent),
        percent(fit.rms_percent),
        significant(fit.chi_square, 4),
        counted(fit.data_count, "residual")
    )
}

/// How the best start ended, how many starts ended there, and where the others did.
pub(super) fn convergence_text(result: &UpdateResult) -> String {
    let starts = &result.starts;
    let mut text = format!(
        "{} after {}. {} of {} (seed {}) reach {}",
        result.stop_reason.sentence(),
        counted(result.history.len(), "iteration"),
        starts.reached,
        counted(starts.count, "start"),
        starts.seed,
        if result.frfs.is_some() {
            "the optimum of the modes from which the FRFs were fitted; starts and optima are those of the modes"
        } else {
            "this optimum"
        }
    );
    if let Some(first) = starts.others.first() {
        let count: usize = starts.others.iter().map(|other| other.count).sum();
        let which = match starts.others.len() {
            1 => "another, of".to_owned(),
            others => format!("{others} others, the lowest of"),
        };
        text += &format!(
            ", the lowest, of objective {}; {count} reach {which} {}",
            significant(starts.lowest_objective, 4),
            significant(first.objective, 4)
        );
    }
    if starts.failed > 0 {
        text += &format!(
            "; from {} the model had no modes or no derivatives",
            starts.failed
        );
    }
    text += ".";
    for (label, hz) in &result.left_out {
        text += &format!(
            " Test mode {} ({hz:.2} Hz) has no partner in the model and was not used.",
            measured_mode(label)
        );
    }
    text
}

fn explanation_blocks(explanation: &Explanation) -> Vec<Block> {
    let printed = |changes: &[SubsetFit]| {
        changes
            .iter()
            .take(MAX_PRINTED_CHANGES)
            .map(change_row)
            .collect()
    };
    let mut single: Vec<Vec<Cell>> = vec![change_row(&explanation.none)];
    single.extend::<Vec<Vec<Cell>>>(printed(&explanation.single));
    let predictions = explanation.left_out_predictions.iter().map(|f| {
        vec![
            Cell::text(measured_mode(&f.label)),
            Cell::signed(Some(f.before_percent), 3),
            Cell::signed(Some(f.after_percent), 3),
            Cell::text(if f.after_percent.abs() < f.before_percent.abs() {
                "better"
            } else {
                "worse"
            }),
        ]
    });
    vec![
        changes_block("One parameter changed at a time", single),
        changes_block(
            "Two parameters changed at a time",
            printed(&explanation.pairs),
        ),
        proposal(explanation),
        Block::Table(Table {
            caption:
                "Leave-one-out check: each mode predicted with the proposed set from all others"
                    .to_owned(),
            columns: vec![
                Column::text("mode"),
                Column::number("before (%)"),
                Column::number("predicted (%)"),
                Column::text("verdict"),
            ],
            rows: predictions.collect(),
            footnotes: Vec::new(),
        }),
    ]
}

/// The proposed set of parameters, and whether it explains the misfit.
pub(super) fn proposal(explanation: &Explanation) -> Block {
    let proposed = if explanation.proposed.parameters.is_empty() {
        match explanation.none.free {
            0 => "no change".to_owned(),
            _ => "no change besides the parameters that are always free".to_owned(),
        }
    } else {
        explanation.proposed.parameters.join(", ")
    };
    let verdict = if explanation.proposed.explains() {
        "the smallest set that brings the residual to its uncertainty"
    } else {
        "no set brings the residual to its uncertainty; this one has the smallest BIC"
    };
    Block::Text(format!("Proposed: {proposed} ({verdict})."))
}

fn change_row(change: &SubsetFit) -> Vec<Cell> {
    let values: Vec<String> = change.values.iter().map(|v| significant(*v, 6)).collect();
    let name = if change.parameters.is_empty() {
        "none".to_owned()
    } else {
        change.parameters.join(", ")
    };
    vec![
        Cell::text(name),
        Cell::text(values.join(", ")),
        Cell::number(change.fit.largest_percent, 3),
        Cell::number(change.fit.rms_percent, 3),
        Cell::number(Some(change.fit.chi_square), 2),
        Cell::number(Some(change.bic), 2),
        Cell::text(match change.explains() {
            true => Verdict::Explains.text(),
            false => "no",
        }),
    ]
}

fn changes_block(caption: &str, rows: Vec<Vec<Cell>>) -> Block {
    Block::Table(Table {
        caption: caption.to_owned(),
        columns: vec![
            Column::text("changed"),
            Column::text("to"),
            Column::number("largest error (%)"),
            Column::number("rms (%)"),
            Column::number("chi-square"),
            Column::number("BIC"),
            Column::text("explains the misfit"),
        ],
        rows,
        footnotes: Vec::new(),
    })
}

/// A value without its round-off: nine decimals, less trailing zeros.
fn without_round_off(value: f64) -> String {
    format!("{}", (value * 1e9).round() / 1e9)
}

//! The report stage writes results as blocks, with one renderer per output format, and as JSON
//! files.
//!
//! Renderers know blocks alone, so that a new result needs no new renderer, and a new format no
//! change of results. This stage computes no results; it only rounds them.

mod before_you_leave;
mod block;
mod breakdown;
mod comparison;
mod csv_text;
mod details;
mod error_range;
mod frf;
mod html;
mod indicators;
pub mod json;
mod label_texts;
mod language;
mod latex;
mod markdown;
mod measures;
mod modes;
mod modification;
mod order;
mod phrase_texts;
mod placement;
mod plot;
mod published;
mod regression_check;
mod response;
mod screen;
mod screen_texts;
mod speed_accuracy;
mod stabilization;
mod states;
mod sweep;
mod table;
mod terminal;
mod test_title;
mod text_table;
mod texts;
mod translation;
mod update;
mod update_configurations;
mod verdict;
mod verdict_texts;

pub use before_you_leave::{
    before_you_leave_blocks, before_you_leave_line, before_you_leave_screen,
};
pub use block::Block;
pub use breakdown::{
    breakdown_blocks, breakdown_cells, breakdown_rates, breakdown_times, breakdown_user_modes,
    stability_cells,
};
pub use comparison::{
    TableGroup, comparison_blocks, comparison_of_all_tests, limits_block, parameters_block,
};
pub use csv_text::CsvText;
pub use details::{details_blocks, simplest_details_block};
pub use frf::{frf_block, hits_block};
pub use html::{CompanionResults, Html, report_page};
pub use indicators::{INDICATOR_DEFINITIONS, indicators_block};
pub use language::Language;
pub use latex::Latex;
pub use markdown::Markdown;
pub use measures::{
    alignment_block, auto_mac_blocks, frf_correlation_blocks, frf_lines_block, measures_blocks,
    orthogonality_blocks, reversed_sensors_block,
};
pub use modes::{energies_block, modes_block, roots_block, sensitivities_block, theory_block};
pub use modification::{
    DesignResult, ModifiedMode, ModifiedModes, design_blocks, modification_block,
};
pub use order::{order_blocks, order_table};
pub use placement::placement_blocks;
pub use plot::{
    breakdown_svg, details_svg, energies_svg, figure_files, figures_svg, order_figures,
    png_lacks_letters, response_svg, signal_details_svg, speed_accuracy_figures, stability_svg,
    sweeps_svg, update_figures_svg,
};
pub use published::{
    claims_block, published_comparison_block, published_roots_block, quantities_block,
};
pub use regression_check::regression_check_blocks;
pub use response::response_blocks;
pub use screen::{
    abridged, breakdown_screen, comparison_page, comparison_page_of_all_tests, comparison_screen,
    counts_block, hits_screen, modes_page, modes_screen, next_step, order_screen,
    regression_check_screen, roots_screen, run_screen, speed_accuracy_screen, step_after_update,
    step_to_check, tables_with_values, update_screen, without_whole_shares,
};
pub use speed_accuracy::{speed_accuracy_blocks, speed_accuracy_table, times_table};
pub use stabilization::stabilization_block;
pub use states::states_block;
pub use sweep::sweep_blocks;
pub use table::{Align, Cell, Column, Table};
pub use terminal::Terminal;
#[cfg(feature = "cli")]
pub(crate) use terminal::wrapping;
pub use update::{update_blocks, update_page};

/// Turns blocks into the text of one output format.
pub trait Renderer: Sync {
    /// Name on the command line.
    fn name(&self) -> &'static str;

    /// File name extension, without the dot.
    fn extension(&self) -> &'static str;

    /// The text, ending in a newline.
    fn render(&self, blocks: &[Block]) -> String;
}

/// Every renderer of blocks.
pub const RENDERERS: &[&dyn Renderer] = &[
    &Terminal { width: None },
    &Markdown,
    &CsvText,
    &Latex,
    &Html,
];

/// The renderer for a file name extension.
pub fn renderer_for_extension(extension: &str) -> Option<&'static dyn Renderer> {
    RENDERERS
        .iter()
        .copied()
        .find(|renderer| renderer.extension() == extension)
}

//! The table of the supports and states of the tests of a scene, beside the support of its model.

use crate::scene::{TestResult, TestState, Theory};
use crate::theory::{ModelSupport, Support};

use super::{Block, Cell, Column, Table};

/// A column of the table.
struct StateColumn {
    head: &'static str,
    is_number: bool,
    cell: fn(&TestState) -> Cell,
}

fn number(value: Option<f64>) -> Cell {
    value.map_or(Cell::Missing, |value| Cell::text(value.to_string()))
}

fn text(value: Option<&str>) -> Cell {
    value.map_or(Cell::Missing, Cell::text)
}

const COLUMNS: [StateColumn; 9] = [
    StateColumn {
        head: "support",
        is_number: false,
        cell: |state| text(state.support.map(Support::name)),
    },
    StateColumn {
        head: "highest rigid-body mode (Hz)",
        is_number: true,
        cell: |state| number(state.highest_rigid_body_hz),
    },
    StateColumn {
        head: "mass (kg)",
        is_number: true,
        cell: |state| number(state.mass_kg),
    },
    StateColumn {
        head: "preload (N)",
        is_number: true,
        cell: |state| number(state.preload_n),
    },
    StateColumn {
        head: "torque (N m)",
        is_number: true,
        cell: |state| number(state.torque_nm),
    },
    StateColumn {
        head: "shaft angle (°)",
        is_number: true,
        cell: |state| number(state.shaft_angle_deg),
    },
    StateColumn {
        head: "temperature (°C)",
        is_number: true,
        cell: |state| number(state.temperature_c),
    },
    StateColumn {
        head: "attached",
        is_number: false,
        cell: |state| match state.attached.is_empty() {
            true => Cell::Missing,
            false => Cell::text(state.attached.join("; ")),
        },
    },
    StateColumn {
        head: "date",
        is_number: false,
        cell: |state| text(state.date.as_deref()),
    },
];

/// The stated states of all tests and the support of the model, the columns that are stated; `None`
/// where neither a test nor the model states anything.
pub fn states_block(tests: &[TestResult], theory: &Theory) -> Option<Block> {
    let of_model = TestState {
        support: theory.support.support(),
        ..TestState::default()
    };
    if theory.support.stated.is_none() && tests.iter().all(|test| test.state.is_empty()) {
        return None;
    }
    let states = tests.iter().map(|test| (test.name.as_str(), &test.state));
    let model = (!of_model.is_empty()).then_some(("model", &of_model));
    let states: Vec<(&str, &TestState)> = states.chain(model).collect();
    let is_stated = |column: &&StateColumn| {
        let mut cells = states.iter().map(|(_, state)| (column.cell)(state));
        cells.any(|cell| cell != Cell::Missing)
    };
    let columns: Vec<&StateColumn> = COLUMNS.iter().filter(is_stated).collect();
    let heads = columns.iter().map(|column| match column.is_number {
        true => Column::number(column.head),
        false => Column::text(column.head),
    });
    let row = |(name, state): &(&str, &TestState)| {
        let cells = columns.iter().map(|column| (column.cell)(state));
        std::iter::once(Cell::text(*name)).chain(cells).collect()
    };
    Some(Block::Table(Table {
        caption: "Supports and states of tests and model".to_owned(),
        columns: std::iter::once(Column::text("test")).chain(heads).collect(),
        rows: states.iter().map(row).collect(),
        footnotes: model_source(&theory.support).into_iter().collect(),
    }))
}

/// Whether the model states its support or the matrices show it.
fn model_source(support: &ModelSupport) -> Option<String> {
    let by_matrices = support.derived.map(Support::name);
    match (support.stated, by_matrices) {
        (None, None) => None,
        (None, Some(_)) => Some("Support of the model: by its stiffness matrix.".to_owned()),
        (Some(_), None) => Some("Support of the model: as it states.".to_owned()),
        (Some(_), Some(derived)) => Some(format!(
            "Support of the model: as it states; its stiffness matrix shows {derived}."
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Renderer, Terminal};

    #[test]
    fn states_stand_beside_each_other_with_the_support_of_the_model() {
        let test = |name: &str, preload_n| TestResult {
            name: name.to_owned(),
            state: TestState {
                support: Some(Support::Mounted),
                preload_n: Some(preload_n),
                ..TestState::default()
            },
            ..TestResult::default()
        };
        let theory = Theory {
            support: ModelSupport {
                derived: Some(Support::Fixed),
                ..ModelSupport::default()
            },
            ..Theory::default()
        };
        let block = states_block(&[test("loose", 50.0), test("tight", 200.0)], &theory).unwrap();
        let text = Terminal { width: None }.render(&[block]);
        for part in [
            "support",
            "preload (N)",
            "50",
            "200",
            "fixed",
            "by its stiffness",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(!text.contains("temperature"), "{text}");
        assert_eq!(states_block(&[TestResult::default()], &theory), None);
    }
}

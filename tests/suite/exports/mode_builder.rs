//! Universal files of three modes at five nodes, changed by each test in one place.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::universal_file::printed;

/// Natural frequencies, Hz.
pub const FREQUENCIES_HZ: [f64; 3] = [20.0, 55.0, 110.0];
/// Damping ratios.
pub const DAMPING: [f64; 3] = [0.01, 0.008, 0.012];
/// Nodes 1 to 5.
pub const NODES: i64 = 5;

/// Parameters of a mode as its dataset states them.
#[derive(Clone, Debug)]
pub enum Parameters {
    /// Dataset 55: record 8.
    Dataset55(Vec<f64>),
    /// Dataset 2414: records 12 and 13.
    Dataset2414([f64; 6], [f64; 6]),
}

/// A mode of dataset 55 or 2414.
#[derive(Clone, Debug)]
pub struct ModeDataset {
    pub id_lines: [String; 5],
    /// 2 for a normal mode, 3 for a complex eigenvalue.
    pub analysis: i64,
    pub parameters: Parameters,
    pub is_complex: bool,
    /// Nodes with three or six values each.
    pub rows: Vec<(i64, Vec<Complex64>)>,
}

/// Displacement of a node in a mode, along X, Y and Z.
pub fn displacement(mode: usize, node: i64) -> [f64; 3] {
    let (order, at) = ((mode + 1) as f64, 0.31 + 0.57 * node as f64);
    [
        (0.8 * order * at).cos(),
        0.6 * (1.3 * order * at + 0.4).sin(),
        (order * at).sin(),
    ]
}

/// Rows of a mode with zeros wherever this says that a direction (0 to 2) was not measured.
pub fn rows(mode: usize, is_measured: impl Fn(i64, usize) -> bool) -> Vec<(i64, Vec<Complex64>)> {
    let row = |node: i64| {
        let values = displacement(mode, node).into_iter().enumerate();
        let values = values.map(|(direction, value)| match is_measured(node, direction) {
            true => Complex64::new(value, 0.0),
            false => Complex64::ZERO,
        });
        (node, values.collect())
    };
    (1..=NODES).map(row).collect()
}

/// λ of a mode, rad/s.
pub fn eigenvalue(mode: usize) -> Complex64 {
    let (omega, zeta) = (TAU * FREQUENCIES_HZ[mode], DAMPING[mode]);
    Complex64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt())
}

impl ModeDataset {
    /// A normal mode of dataset 55.
    pub fn normal(mode: usize, rows: Vec<(i64, Vec<Complex64>)>) -> Self {
        Self {
            id_lines: std::array::from_fn(|_| "NONE".to_owned()),
            analysis: 2,
            parameters: Parameters::Dataset55(vec![
                FREQUENCIES_HZ[mode],
                0.0,
                DAMPING[mode],
                2.0 * DAMPING[mode],
            ]),
            is_complex: false,
            rows,
        }
    }

    /// A complex mode of dataset 55.
    pub fn complex(mode: usize, rows: Vec<(i64, Vec<Complex64>)>) -> Self {
        let lambda = eigenvalue(mode);
        Self {
            analysis: 3,
            parameters: Parameters::Dataset55(vec![lambda.re, lambda.im, 0.0, 0.0, 0.0, 0.0]),
            is_complex: true,
            ..Self::normal(mode, rows)
        }
    }

    /// The same mode with the parameters of dataset 2414.
    pub fn with_2414(self, general: [f64; 6], eigenvalue: [f64; 6]) -> Self {
        Self {
            parameters: Parameters::Dataset2414(general, eigenvalue),
            ..self
        }
    }

    pub fn text(&self) -> String {
        let mut lines = vec!["    -1".to_owned()];
        let id_lines = self.id_lines.iter().map(|line| format!("{line:<80}"));
        let per_node = self.rows.first().map_or(3, |(_, values)| values.len());
        let (characteristic, kind) = (per_node / 3 + 1, if self.is_complex { 5 } else { 2 });
        let definition = format!(
            "{:>10}{:>10}{characteristic:>10}{:>10}{kind:>10}{per_node:>10}",
            1, self.analysis, 8
        );
        match &self.parameters {
            Parameters::Dataset55(reals) => {
                lines.push("    55".to_owned());
                lines.extend(id_lines);
                lines.push(definition);
                lines.push(format!("{:>10}{:>10}{:>10}{:>10}", 2, reals.len(), 1, 1));
                lines.extend(number_rows(reals));
            }
            Parameters::Dataset2414(general, eigenvalue) => {
                lines.push("  2414".to_owned());
                lines.extend([
                    format!("{:>10}", 1),
                    "NONE".to_owned(),
                    format!("{:>10}", 1),
                ]);
                lines.extend(id_lines);
                lines.push(definition);
                lines.push(format!("{:>10}", 0).repeat(8));
                lines.push(format!("{:>10}", 0).repeat(2));
                lines.extend(number_rows(general));
                lines.extend(number_rows(eigenvalue));
            }
        }
        for (node, values) in &self.rows {
            lines.push(format!("{node:>10}"));
            let parts = |value: &Complex64| match self.is_complex {
                true => vec![value.re, value.im],
                false => vec![value.re],
            };
            let numbers: Vec<f64> = values.iter().flat_map(parts).collect();
            lines.extend(number_rows(&numbers));
        }
        lines.push("    -1".to_owned());
        lines.join("\n") + "\n"
    }
}

/// Six numbers of 13 columns a line.
fn number_rows(numbers: &[f64]) -> Vec<String> {
    let row = |row: &[f64]| row.iter().map(|number| printed(*number)).collect();
    numbers.chunks(6).map(row).collect()
}

/// The file of these modes.
pub fn mode_file(modes: &[ModeDataset]) -> String {
    modes.iter().map(ModeDataset::text).collect()
}

/// The three modes, each made by this.
pub fn three(mode: impl Fn(usize) -> ModeDataset) -> Vec<ModeDataset> {
    (0..3).map(mode).collect()
}

//! A `report.json` is checked for values that no page can be drawn from.

use crate::scene::{
    CircleFigure, Curve, Figures, FrfFigure, MacFigure, Provenance, ShapeFigure,
    StabilizationFigure, TestFigures, TheoryMotion,
};

use super::super::{Cell, Table};

/// Maximum decimals of a number: more say nothing of a double.
const MAX_DECIMALS: usize = 17;
/// Digits of a SHA-256 hash.
const HASH_DIGITS: usize = 64;
/// Displacements and rotations of a node.
const MOTIONS_OF_NODE: usize = 6;

/// A value that contradicts the others.
#[derive(Debug)]
pub(super) struct Fault {
    /// Its key.
    pub key: String,
    /// The value.
    pub got: String,
    /// The accepted ones.
    pub expected: &'static str,
}

impl Fault {
    fn new(key: impl Into<String>, got: impl ToString, expected: &'static str) -> Self {
        Self {
            key: key.into(),
            got: got.to_string(),
            expected,
        }
    }

    /// The same fault of a value inside of another one.
    pub(super) fn inside(self, key: &str) -> Self {
        Self {
            key: format!("{key}.{}", self.key),
            ..self
        }
    }
}

/// Checks indices and lengths of figures.
pub(super) fn check_figures(figures: &Figures) -> Result<(), Fault> {
    for (index, test) in figures.tests.iter().enumerate() {
        let inside = |key: &'static str| {
            move |fault: Fault| fault.inside(&format!("figures.tests[{index}].{key}"))
        };
        let TestFigures {
            frfs,
            stabilization,
            circles,
            mac,
            shapes,
            ..
        } = test;
        let each = |result: Option<Result<(), Fault>>| result.unwrap_or(Ok(()));
        each(frfs.as_ref().map(check_frfs)).map_err(inside("frfs"))?;
        each(stabilization.as_ref().map(check_poles)).map_err(inside("stabilization"))?;
        each(mac.as_ref().map(check_mac)).map_err(inside("mac"))?;
        each(shapes.as_ref().map(check_shapes)).map_err(inside("shapes"))?;
        circles
            .iter()
            .try_for_each(check_circle)
            .map_err(inside("circles"))?;
    }
    if let Some(motion) = &figures.theory {
        check_motion(motion).map_err(|fault| fault.inside("figures.theory"))?;
    }
    Ok(())
}

/// Checks decimals and rows of a table.
pub(super) fn check_table(table: &Table) -> Result<(), Fault> {
    for (index, row) in table.rows.iter().enumerate() {
        let key = format!("rows[{index}]");
        check_length(
            &key,
            row.len(),
            table.columns.len(),
            "as many cells as columns",
        )?;
        for cell in row {
            if let Cell::Number { decimals, .. } | Cell::Correlation { decimals, .. } = cell
                && *decimals > MAX_DECIMALS
            {
                let key = format!("{key}.decimals");
                return Err(Fault::new(key, decimals, "at most 17 decimals"));
            }
        }
    }
    Ok(())
}

fn check_length(key: &str, got: usize, wanted: usize, expected: &'static str) -> Result<(), Fault> {
    match got == wanted {
        true => Ok(()),
        false => Err(Fault::new(
            key,
            format!("{got} values for {wanted}"),
            expected,
        )),
    }
}

/// Checks the length of values that a figure may also lack.
fn check_optional_length(
    key: &str,
    got: usize,
    wanted: usize,
    expected: &'static str,
) -> Result<(), Fault> {
    match got {
        0 => Ok(()),
        _ => check_length(key, got, wanted, expected),
    }
}

fn check_index(key: &str, index: usize, count: usize, expected: &'static str) -> Result<(), Fault> {
    match index < count {
        true => Ok(()),
        false => Err(Fault::new(key, format!("{index} of {count}"), expected)),
    }
}

fn check_frfs(figure: &FrfFigure) -> Result<(), Fault> {
    let expected = "a value for each line";
    let check = |curve: &Curve| {
        let lines = curve.lines.len();
        check_length("magnitude", curve.magnitude.len(), lines, expected)?;
        check_length("phase_deg", curve.phase_deg.len(), lines, expected)?;
        check_optional_length("fit_magnitude", curve.fit_magnitude.len(), lines, expected)?;
        check_optional_length("fit_phase_deg", curve.fit_phase_deg.len(), lines, expected)?;
        check_optional_length("coherence", curve.coherence.len(), lines, expected)
    };
    let mut curves = figure.curves.iter();
    curves
        .try_for_each(check)
        .map_err(|fault| fault.inside("curves"))
}

fn check_poles(figure: &StabilizationFigure) -> Result<(), Fault> {
    let (poles, expected) = (figure.hz.len(), "a value for each pole");
    check_length("order", figure.order.len(), poles, expected)?;
    check_length("damping", figure.damping.len(), poles, expected)?;
    check_length("status", figure.status.len(), poles, expected)?;
    for status in &figure.status {
        check_index("status", usize::from(*status), 3, "0, 1 or 2")?;
    }
    for curve in &figure.cmif.values {
        let lines = figure.cmif.hz.len();
        check_length("cmif.values", curve.len(), lines, "a value for each line")?;
    }
    Ok(())
}

fn check_circle(figure: &CircleFigure) -> Result<(), Fault> {
    let (lines, expected) = (figure.line_hz.len(), "a value for each line");
    check_length("re", figure.re.len(), lines, expected)?;
    check_length("im", figure.im.len(), lines, expected)?;
    check_matrix(
        "damping",
        &figure.damping,
        &figure.below_hz,
        &figure.above_hz,
    )
}

/// Checks that a matrix has a row and a column for each of these.
fn check_matrix(
    key: &str,
    matrix: &[Vec<Option<f64>>],
    rows: &[f64],
    columns: &[f64],
) -> Result<(), Fault> {
    check_length(key, matrix.len(), rows.len(), "a row for each frequency")?;
    for row in matrix {
        check_length(key, row.len(), columns.len(), "a column for each frequency")?;
    }
    Ok(())
}

fn check_mac(figure: &MacFigure) -> Result<(), Fault> {
    let (rows, columns) = (&figure.test_hz, &figure.theory_hz);
    check_matrix("mac", &figure.mac, rows, columns)?;
    let modes = figure.theory_modes.len();
    check_length(
        "theory_modes",
        modes,
        columns.len(),
        "a number for each column",
    )?;
    for [row, column] in &figure.pairs {
        check_index("pairs", *row, rows.len(), "a row from 0")?;
        check_index("pairs", *column, columns.len(), "a column from 0")?;
    }
    Ok(())
}

fn check_shapes(figure: &ShapeFigure) -> Result<(), Fault> {
    let (points, expected) = (figure.points.len(), "a point from 0");
    for end in figure.lines.iter().flatten() {
        check_index("lines", *end, points, expected)?;
    }
    for reading in &figure.readings {
        check_index("readings.point", reading.point, points, expected)?;
    }
    let (readings, expected) = (figure.readings.len(), "a value for each reading");
    for (key, shapes) in [("test", &figure.test), ("theory", &figure.theory)] {
        for shape in shapes {
            check_length(&format!("{key}.re"), shape.re.len(), readings, expected)?;
            check_optional_length(&format!("{key}.im"), shape.im.len(), readings, expected)?;
        }
    }
    let (partners, modes) = (figure.partners.len(), figure.test.len());
    check_optional_length("partners", partners, modes, "an entry for each test mode")?;
    for (mode, ..) in figure
        .partners
        .iter()
        .flatten()
        .flat_map(|pair| &pair.modes)
    {
        check_index(
            "partners.modes",
            *mode,
            figure.theory.len(),
            "a mode from 0",
        )?;
    }
    Ok(())
}

fn check_motion(motion: &TheoryMotion) -> Result<(), Fault> {
    let (modes, expected) = (motion.hz.len(), "a mode for each frequency");
    check_length("modes", motion.modes.len(), modes, expected)?;
    let values = MOTIONS_OF_NODE * motion.nodes.len();
    for mode in &motion.modes {
        check_length("modes", mode.len(), values, "six values for each node")?;
    }
    Ok(())
}

/// Checks that hashes are hashes.
pub(super) fn check_hashes(provenance: &Provenance) -> Result<(), Fault> {
    let stated = provenance
        .stated
        .iter()
        .map(|file| ("stated", &file.sha256));
    let inputs = provenance
        .inputs
        .iter()
        .map(|[_, _, hash]| ("inputs", hash));
    for (key, hash) in stated.chain(inputs) {
        let is_hash = hash.len() == HASH_DIGITS && hash.chars().all(|c| c.is_ascii_hexdigit());
        if !is_hash {
            let key = format!("provenance.{key} SHA-256");
            return Err(Fault::new(
                key,
                format!("{hash:?}"),
                "64 hexadecimal digits",
            ));
        }
    }
    Ok(())
}

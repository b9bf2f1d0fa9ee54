//! The tables of correlation measures state, for each measure, its definition and the degrees of
//! freedom that it uses.

use crate::correlate::Alignment;
use crate::correlate::measures::{
    AutoMac, CLUSTER_SPAN, CLUSTER_WIDTH, ClusterMac, CoordinateMac, DofRange, FrequencyMac,
    FrfCorrelation, FunctionCorrelation, LineCorrelation, MacMatrix, Measures, ModeName,
    Orthogonality, Reduction, ReversedSensor, ScaleFactor,
};
use crate::printable::counted;

use super::{Block, Cell, Column, Table};

/// Minimum MAC of a pair of modes in the table of MAC with frequencies.
const MIN_LISTED_MAC: f64 = 0.3;

/// Factors of the lowest and the highest test frequency: modes of the theory between them have a
/// column in a matrix.
const COLUMN_FREQUENCY_FACTORS: [f64; 2] = [0.8, 1.25];

const MAC_DEFINITION: &str = "MAC = |a^H b|²/(a^H a · b^H b) (Allemang and Brown 1982)";

/// Every measure of one test against one theory.
pub fn measures_blocks(test: &str, measures: &Measures) -> Vec<Block> {
    let mut tables = vec![
        mac_table(format!("MAC of {test} and theory"), &measures.mac),
        frequency_table(test, &measures.frequency_mac, measures.mac.dofs),
        scale_table(test, &measures.scale_factors),
        coordinate_table(test, &measures.coordinates),
        theory_table(test, measures),
    ];
    if !measures.clusters.is_empty() {
        tables.push(cluster_table(test, &measures.clusters));
    }
    let mut blocks: Vec<Block> = tables.into_iter().map(Block::Table).collect();
    blocks.extend(orthogonality_blocks(test, measures));
    blocks
}

/// The orthogonality tables, where orthogonality was computed.
pub fn orthogonality_blocks(test: &str, measures: &Measures) -> Vec<Block> {
    let found = measures.orthogonality.iter();
    let tables = found.flat_map(|orthogonality| orthogonality_tables(test, orthogonality));
    tables.map(Block::Table).collect()
}

/// The frame of a test fitted to that of a theory.
pub fn alignment_block(alignment: &Alignment) -> Block {
    let row = |i: usize| {
        let mut cells = vec![Cell::text(["x", "y", "z"][i])];
        cells.extend(alignment.rotation[i].map(|value| Cell::number(Some(value), 6)));
        cells.push(Cell::number(Some(alignment.shift_m[i]), 6));
        cells
    };
    let mut columns = vec![Column::text("theory")];
    let heads = ["test x", "test y", "test z", "shift (m)"];
    columns.extend(heads.map(Column::number));
    let partners = if alignment.known {
        "with the partners that were given (Umeyama 1991)"
    } else {
        "with unknown partners: triangles of points, then the nearest point of each (Umeyama 1991; Besl and McKay 1992)"
    };
    let mut footnotes = vec![
        format!(
            "x' = s R x + t of {}, {partners}: s = {:.6}.",
            counted(alignment.points, "point"),
            alignment.scale
        ),
        format!(
            "Distance after the fit: {:.3e} m rms, {:.3e} m at most.",
            alignment.rms_m, alignment.largest_m
        ),
    ];
    if alignment.known && alignment.as_good > 0 {
        footnotes.push(
            "Points on a line within the tolerance determine no rotation about it.".to_owned(),
        );
    } else if alignment.as_good > 0 {
        footnotes.push(other_frames_note(alignment));
    }
    Block::Table(Table {
        caption: "The test's points in the theory's frame".to_owned(),
        columns,
        rows: (0..3).map(row).collect(),
        footnotes,
    })
}

/// The frames that fit as well as the one that was taken, and why this one.
fn other_frames_note(alignment: &Alignment) -> String {
    /// Number of frames that are named; the JSON has all.
    const NAMED: usize = 4;
    let others = alignment.others.iter().take(NAMED).map(|other| {
        let [x, y, z] = other.shift_m;
        let angle = other.similarity().angle().to_degrees();
        let mac = other.mean_mac.map(|mac| format!(", mean MAC {mac:.3}"));
        format!(
            "{angle:.1}° and ({x:.4}, {y:.4}, {z:.4}) m{}",
            mac.unwrap_or_default()
        )
    });
    let others: Vec<String> = others.collect();
    let reason = match (alignment.mean_mac, alignment.as_good_by_shape()) {
        (Some(mac), 0) => format!("the shapes select this one, mean MAC {mac:.3}"),
        (Some(mac), count) => format!(
            "{count} of them with the same mean MAC, {mac:.3}; this one has the smallest rotation"
        ),
        (None, _) => "this one has the smallest rotation".to_owned(),
    };
    format!(
        "Other frames that fit equally well: {}; {reason}. Rotation and shift: {}.",
        alignment.as_good,
        others.join("; ")
    )
}

/// Sign-reversed sensors compared with the theory; `None` without any.
pub fn reversed_sensors_block(
    tests: &[(String, Vec<ReversedSensor>)],
    signs_reversed: bool,
) -> Option<Block> {
    let row = |test: &str, group: &[ReversedSensor]| {
        let sensor = group.first()?;
        Some(vec![
            Cell::text(test),
            Cell::text(sensor.name(group.len())),
            Cell::signed(Some(sensor.direction), 3),
            Cell::number(Some(sensor.mac_before), 4),
            Cell::number(Some(sensor.mac_after), 4),
        ])
    };
    let rows = tests.iter().flat_map(|(test, all)| {
        let groups = all.chunk_by(ReversedSensor::is_grouped_with);
        groups.filter_map(move |group| row(test, group))
    });
    let rows: Vec<_> = rows.collect();
    let mut columns = vec![Column::text("test"), Column::text("sensor")];
    columns.extend(["direction", "mean MAC", "mean MAC, reversed"].map(Column::number));
    let state = match signs_reversed {
        true => "Their signs were reversed.",
        false => "Their signs were not changed.",
    };
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            caption: "Sign-reversed sensors".to_owned(),
            columns,
            rows,
            footnotes: vec![format!(
                "Determined one after the other, each with the sensors above it reversed. {state}"
            )],
        })
    })
}

/// AutoMAC of a set of modes, with its duplicates.
pub fn auto_mac_blocks(name: &str, auto_mac: &AutoMac) -> Vec<Block> {
    if auto_mac.matrix.dofs.most == 1 {
        return vec![Block::Text(format!(
            "AutoMAC of {name}: shapes of one degree of freedom cannot be compared."
        ))];
    }
    let mut table = mac_table(format!("AutoMAC of {name}"), &auto_mac.matrix);
    let (mac, percent) = (
        auto_mac.limits.min_mac,
        100.0 * auto_mac.limits.max_frequency_difference,
    );
    let rule = format!("Duplicates: a MAC of {mac} or more within {percent} % in frequency");
    table.footnotes.push(if auto_mac.duplicates.is_empty() {
        format!("{rule}: none.")
    } else {
        format!("{rule}: {}.", auto_mac.duplicates.len())
    });
    let mut blocks = vec![Block::Table(table)];
    if !auto_mac.duplicates.is_empty() {
        let row = |duplicate: &crate::correlate::measures::Duplicate| {
            vec![
                name_cell(&duplicate.first),
                Cell::number(Some(duplicate.first.hz), 3),
                name_cell(&duplicate.second),
                Cell::number(Some(duplicate.second.hz), 3),
                Cell::number(Some(duplicate.mac), 4),
            ]
        };
        let heads = ["mode", "f (Hz)", "mode", "f (Hz)", "MAC"];
        blocks.push(Block::Table(Table {
            caption: format!("Similar modes of {name}"),
            columns: heads.map(Column::number).to_vec(),
            rows: auto_mac.duplicates.iter().map(row).collect(),
            footnotes: vec![
                "One mode found twice, or two modes that the sensors cannot distinguish."
                    .to_owned(),
            ],
        }));
    }
    blocks
}

/// Correlation of two sets of FRFs, by FRF and by segment of the band.
pub fn frf_correlation_blocks(
    first: &str,
    second: &str,
    correlation: &FrfCorrelation,
) -> Vec<Block> {
    let row = |function: &FunctionCorrelation| {
        vec![
            Cell::text(function.response.to_string()),
            Cell::text(function.reference.to_string()),
            Cell::number(function.frac, 4),
            Cell::signed(function.level_db, 2),
        ]
    };
    let lines = counted(correlation.lines.len(), "line");
    let ends = correlation.lines.first().zip(correlation.lines.last());
    let band = ends.map_or_else(String::new, |(a, b)| {
        format!(" from {} to {} Hz", a.hz, b.hz)
    });
    let mut footnotes = vec![
        "FRAC = |Σ a* b|²/(Σ |a|² · Σ |b|²) over the lines (Heylen and Lammens 1996); level: rms of the second over the first.".to_owned(),
        format!(
            "{}, {lines}{band}, both in {}.",
            counted(correlation.functions.len(), "FRF"),
            correlation.unit
        ),
    ];
    if correlation.first_alone + correlation.second_alone > 0 {
        footnotes.push(format!(
            "FRFs without a partner: {} of the first, {} of the second.",
            correlation.first_alone, correlation.second_alone
        ));
    }
    let columns = vec![
        Column::text("response"),
        Column::text("reference"),
        Column::number("FRAC"),
        Column::number("level (dB)"),
    ];
    vec![
        Block::Table(Table {
            caption: format!("FRFs of {first} and {second}"),
            columns,
            rows: correlation.functions.iter().map(row).collect(),
            footnotes,
        }),
        Block::Table(band_table(first, second, correlation)),
    ]
}

/// Definitions of the columns of correlation over frequency.
const LINE_DEFINITIONS: &str = "At each line, a and b the FRFs as vectors: shape = |a^H b|²/(a^H a · b^H b), independent of amplitude; amplitude = 2|a^H b|/(a^H a + b^H b), 1 for equal vectors (Zang, Grafe and Imregun 2001).";

fn band_table(first: &str, second: &str, correlation: &FrfCorrelation) -> Table {
    let heads = [
        "from (Hz)",
        "to (Hz)",
        "lines",
        "shape, mean",
        "shape, least",
        "amplitude, mean",
        "amplitude, least",
    ];
    let row = |band: &crate::correlate::measures::BandCorrelation| {
        let values = [
            band.mean_shape,
            band.least_shape,
            band.mean_amplitude,
            band.least_amplitude,
        ];
        let ends = [band.lo_hz, band.hi_hz].map(|hz| Cell::number(Some(hz), 2));
        let mut cells = ends.to_vec();
        cells.push(Cell::text(band.lines.to_string()));
        cells.extend(values.map(|value| Cell::number(value, 4)));
        cells
    };
    let count = correlation.functions.len();
    Table {
        caption: format!("FRFs of {first} and {second} over frequency"),
        columns: heads.map(Column::number).to_vec(),
        rows: correlation.bands.iter().map(row).collect(),
        footnotes: vec![format!(
            "{LINE_DEFINITIONS} {} in each vector.",
            counted(count, "FRF")
        )],
    }
}

/// The criteria at every line.
pub fn frf_lines_block(first: &str, second: &str, correlation: &FrfCorrelation) -> Block {
    let row = |line: &LineCorrelation| {
        vec![
            Cell::number(Some(line.hz), 4),
            Cell::number(line.shape, 6),
            Cell::number(line.amplitude, 6),
        ]
    };
    Block::Table(Table {
        caption: format!("FRFs of {first} and {second} by line"),
        columns: ["f (Hz)", "shape", "amplitude"]
            .map(Column::number)
            .to_vec(),
        rows: correlation.lines.iter().map(row).collect(),
        footnotes: vec![LINE_DEFINITIONS.to_owned()],
    })
}

fn dofs_text(dofs: DofRange) -> String {
    match (dofs.fewest, dofs.most) {
        (1, 1) => "1 degree of freedom".to_owned(),
        (min, max) if min == max => format!("{max} degrees of freedom"),
        (min, max) => format!("{min} to {max} degrees of freedom"),
    }
}

fn name_cell(name: &ModeName) -> Cell {
    Cell::text(name.mode.to_string())
}

/// Columns of a matrix with frequencies near those of the rows.
fn columns_near(rows: &[ModeName], columns: &[ModeName]) -> Vec<usize> {
    let lowest = rows
        .iter()
        .map(|mode| mode.hz)
        .fold(f64::INFINITY, f64::min);
    let highest = rows.iter().map(|mode| mode.hz).fold(0.0, f64::max);
    let near = |mode: &ModeName| {
        (COLUMN_FREQUENCY_FACTORS[0] * lowest..=COLUMN_FREQUENCY_FACTORS[1] * highest)
            .contains(&mode.hz)
    };
    (0..columns.len()).filter(|&j| near(&columns[j])).collect()
}

/// A matrix over pairs of modes; rows and columns have mode numbers and frequencies as heads.
pub(super) fn matrix_table(
    caption: String,
    rows: &[ModeName],
    columns: &[ModeName],
    values: &[Vec<Option<f64>>],
) -> Table {
    let kept = columns_near(rows, columns);
    let mut heads = vec![Column::number("mode"), Column::number("f (Hz)")];
    heads.extend(kept.iter().map(|&j| {
        let mode = columns[j];
        let hz = Cell::measured(Some(mode.hz), None).display();
        Column::number(format!("{}\n{hz}", mode.mode))
    }));
    let row = |(mode, values): (&ModeName, &Vec<Option<f64>>)| {
        let mut cells = vec![name_cell(mode), Cell::measured(Some(mode.hz), None)];
        cells.extend(kept.iter().map(|&j| Cell::mac(values[j], 4)));
        cells
    };
    let left_out = columns.len() - kept.len();
    let note = format!(
        "Columns: mode and Hz; {left_out} columns beyond the frequencies of the rows are not shown."
    );
    Table {
        caption,
        columns: heads,
        rows: rows.iter().zip(values).map(row).collect(),
        footnotes: (left_out > 0).then_some(note).into_iter().collect(),
    }
}

fn mac_table(caption: String, matrix: &MacMatrix) -> Table {
    let mut table = matrix_table(caption, &matrix.rows, &matrix.columns, &matrix.mac);
    table
        .footnotes
        .insert(0, format!("{MAC_DEFINITION}; {}.", dofs_text(matrix.dofs)));
    table
}

fn theory_table(test: &str, measures: &Measures) -> Table {
    let matrix = &measures.theory_auto_mac;
    let kept = columns_near(&measures.mac.rows, &matrix.rows);
    let rows: Vec<ModeName> = kept.iter().map(|&i| matrix.rows[i]).collect();
    let mac = kept
        .iter()
        .map(|&i| kept.iter().map(|&j| matrix.mac[i][j]).collect())
        .collect();
    let near = MacMatrix {
        columns: rows.clone(),
        rows,
        mac,
        dofs: matrix.dofs,
    };
    let caption = format!("AutoMAC of the theory at the sensors of {test}");
    let mut table = mac_table(caption, &near);
    table.footnotes.push(
        "These sensors cannot distinguish modes whose MAC with each other is far from 0."
            .to_owned(),
    );
    table
}

fn frequency_table(test: &str, points: &[FrequencyMac], dofs: DofRange) -> Table {
    let row = |pair: &FrequencyMac| {
        vec![
            name_cell(&pair.test),
            Cell::number(Some(pair.test.hz), 2),
            name_cell(&pair.theory),
            Cell::number(Some(pair.theory.hz), 2),
            Cell::signed(pair.error_percent, 2),
            Cell::number(Some(pair.mac), 4),
        ]
    };
    let heads = [
        "test mode",
        "test (Hz)",
        "theory mode",
        "theory (Hz)",
        "error (%)",
        "MAC",
    ];
    let high = points.iter().filter(|pair| pair.mac >= MIN_LISTED_MAC);
    Table {
        caption: format!("MAC over both frequencies (FMAC) of {test} and theory"),
        columns: heads.map(Column::number).to_vec(),
        rows: high.map(row).collect(),
        footnotes: vec![format!(
            "All pairs of modes with a MAC of {MIN_LISTED_MAC} or more and both frequencies (Fotsch and Ewins 2000); {}.",
            dofs_text(dofs)
        )],
    }
}

fn scale_table(test: &str, factors: &[ScaleFactor]) -> Table {
    let row = |factor: &ScaleFactor| {
        vec![
            name_cell(&factor.test),
            name_cell(&factor.theory),
            Cell::text(format!("{:.4e}", factor.magnitude)),
            Cell::signed(Some(factor.phase_deg), 1),
            Cell::text(factor.dofs.to_string()),
        ]
    };
    let heads = ["test mode", "theory mode", "|MSF|", "phase (deg)", "DOFs"];
    Table {
        caption: format!("Modal scale factors from theory to {test}"),
        columns: heads.map(Column::number).to_vec(),
        rows: factors.iter().map(row).collect(),
        footnotes: vec!["Test shape = MSF · theory shape, MSF = a^H b/(a^H a) with a the theory's and b the test's (Allemang 2003, eq. 2). Pairs with repeated roots have no MSF.".to_owned()],
    }
}

fn coordinate_table(test: &str, coordinates: &[CoordinateMac]) -> Table {
    let row = |coordinate: &CoordinateMac| {
        vec![
            Cell::text(coordinate.dof.to_string()),
            Cell::number(coordinate.comac, 4),
            Cell::number(coordinate.enhanced, 4),
            Cell::signed(coordinate.direction, 3),
            Cell::text(coordinate.pairs.to_string()),
        ]
    };
    let mut columns = vec![Column::text("DOF")];
    columns.extend(["COMAC", "ECOMAC", "direction", "pairs"].map(Column::number));
    Table {
        caption: format!("Correlation by degree of freedom of {test} and theory (COMAC)"),
        columns,
        rows: coordinates.iter().map(row).collect(),
        footnotes: vec![
            "Over the pairs, shapes of unit length and one phase, a the test's and b the theory's: COMAC = (Σ |a b|)²/(Σ |a|² · Σ |b|²), independent of sign (Lieven and Ewins 1988); ECOMAC = Σ |a − b|/(2 pairs), 0 for equal shapes (Hunt 1992); direction = Σ Re(b* a)/√(Σ |a|² · Σ |b|²), near −1 for a reversed sensor.".to_owned(),
            format!("{} degrees of freedom.", coordinates.len()),
        ],
    }
}

fn cluster_table(test: &str, clusters: &[ClusterMac]) -> Table {
    let numbers = |names: &[ModeName]| {
        let all: Vec<String> = names.iter().map(|name| name.mode.to_string()).collect();
        Cell::text(all.join(" "))
    };
    let row = |cluster: &ClusterMac| {
        let angles = cluster.angles_deg.iter().flatten();
        let angles: Vec<String> = angles.map(|angle| format!("{angle:.1}")).collect();
        vec![
            numbers(&cluster.theory),
            Cell::number(cluster.theory.first().map(|mode| mode.hz), 2),
            numbers(&cluster.test),
            if angles.is_empty() {
                Cell::Missing
            } else {
                Cell::text(angles.join(" "))
            },
            Cell::number(cluster.space_mac, 4),
            Cell::number(cluster.mean_mac, 4),
            Cell::number(cluster.random_mac, 4),
            Cell::text(cluster.dofs.to_string()),
        ]
    };
    let heads = [
        "theory modes",
        "from (Hz)",
        "test modes",
        "angles (deg)",
        "spaceMAC",
        "mean cos²",
        "at random",
        "DOFs",
    ];
    Table {
        caption: format!("Close modes of {test} and theory as subspaces"),
        columns: heads.map(Column::number).to_vec(),
        rows: clusters.iter().map(row).collect(),
        footnotes: vec![format!(
            "Modes one after the other within {} % in frequency, all within {} %, and repeated roots; principal angles (Björck and Golub 1973); spaceMAC = 1 − sin of the largest angle (Vinze, Allemang and Phillips, there of the smallest); at random: mean cos² of directions drawn at random, modes/DOFs. No angles where the modes are more than half of the DOFs.",
            100.0 * CLUSTER_WIDTH,
            100.0 * CLUSTER_SPAN
        )],
    }
}

fn orthogonality_tables(test: &str, orthogonality: &Orthogonality) -> [Table; 2] {
    let how = match (orthogonality.reduction, orthogonality.reduction_modes) {
        (Reduction::Serep, Some(modes)) => format!(
            "by SEREP through {modes} modes of the theory, the paired ones and the lowest others{} (O'Callahan, Avitabile and Riemer 1989)",
            orthogonality
                .selection
                .as_ref()
                .map_or(String::new(), |selection| {
                    format!(
                        " that keep the condition number of their readings, {:.1}, at most {:.0}",
                        selection.condition_number, selection.max_condition_number
                    )
                })
        ),
        _ => "statically (Guyan 1965)".to_owned(),
    };
    let note = format!(
        "|a^H M b|/√(a^H M a · b^H M b), M the theory's mass matrix reduced {how} to {}.",
        dofs_text(DofRange {
            fewest: orthogonality.dofs,
            most: orthogonality.dofs
        })
    );
    let table = |caption: String, columns: &[ModeName], values: &[Vec<Option<f64>>]| {
        let mut table = matrix_table(caption, &orthogonality.test, columns, values);
        table.footnotes.insert(0, note.clone());
        table
    };
    let mut cross = table(
        format!("Cross-orthogonality of {test} and theory"),
        &orthogonality.theory,
        &orthogonality.cross,
    );
    if orthogonality.reduction == Reduction::Serep {
        cross.columns.push(Column::number("outside (%)"));
        for (row, part) in cross.rows.iter_mut().zip(&orthogonality.outside) {
            row.push(Cell::number(part.map(|part| 100.0 * part), 2));
        }
        cross.footnotes.push("Outside: |ψ − Φ Φ⁺ ψ|²/|ψ|² of the test shape ψ, Φ the modes of the reduction at the sensors; M does not see it.".to_owned());
    }
    let caption = format!("Self-orthogonality of {test}");
    [
        cross,
        table(caption, &orthogonality.test, &orthogonality.self_test),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_degree_of_freedom_is_singular() {
        let text = |fewest, most| dofs_text(DofRange { fewest, most });
        assert_eq!(text(1, 1), "1 degree of freedom");
        assert_eq!(text(3, 3), "3 degrees of freedom");
        assert_eq!(text(1, 3), "1 to 3 degrees of freedom");
    }
}

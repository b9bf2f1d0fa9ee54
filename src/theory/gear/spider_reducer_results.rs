//! Results of the paper on the spider reducer, computed with its model: frequencies over a crank
//! turn, energy shares of bearings, and the static balance under load.

use std::f64::consts::TAU;

use crate::linalg::least_squares_real;
use crate::theory::parameter::index_of;
use crate::theory::quantity::{allowed_or, largest};
use crate::theory::{
    ModeOptions, ModelQuantity, ModelRoot, SpiderReducer, SystemMatrices, TheoreticalModel,
    TheoryError, TheoryModes, model_roots, modes,
};

use super::spider_reducer_parameters::{GEAR_TEETH, RING_TEETH};

/// The modes of which the paper speaks.
const FIRST: usize = 9;
/// Crank positions over one turn.
const POSITIONS: usize = 24;
/// Load on the output, N m.
const LOAD_NM: f64 = 1000.0;
/// Eccentricity error of the input's first eccentric, m.
const ERROR_M: f64 = 1e-5;
/// A mode in which one kind of subsystem has no more than this share of the kinetic energy is
/// compound.
const COMPOUND: f64 = 0.9;

/// Every quantity, by name.
pub(super) fn quantities(
    model: &SpiderReducer,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let solved = solve(model, values)?;
    let mut all = of_modes(&solved, &model_roots(model, &solved));
    all.extend(of_changes(model, values, &solved)?);
    all.extend(of_statics(model, values)?);
    Ok(all)
}

fn solve(model: &SpiderReducer, values: &[f64]) -> Result<TheoryModes, TheoryError> {
    modes(model, values, &[], &ModeOptions::default())
}

fn first_frequencies(modes: &TheoryModes) -> Vec<f64> {
    let all = modes.omega_rad_s.iter().take(FIRST);
    all.map(|omega| omega / TAU).collect()
}

fn of_modes(solved: &TheoryModes, roots: &[ModelRoot]) -> Vec<ModelQuantity> {
    let quantity = ModelQuantity::new;
    let hz = first_frequencies(solved);
    let of_mode = |number: usize| roots.iter().find(|root| root.modes.contains(&(number - 1)));
    let repeated = roots.iter().filter(|root| root.modes.len() > 1).count();
    let compound = (1..=FIRST).filter_map(of_mode).filter(|root| {
        let kinds = root.energy_by_kind();
        kinds.first().is_some_and(|(_, share)| *share <= COMPOUND)
    });
    let compound = compound.count();
    let swing = |name: &str| {
        let row = solved.coordinates.iter().position(|c| c.name == name);
        row.map_or(f64::NAN, |row| solved.kinetic_shares[(row, 2)])
    };
    let swing = 100.0 * (swing("box") + swing("boy"));
    let strain = of_mode(3).map_or(&[][..], |root| &root.strain_energy);
    let share = strain.iter().find(|(name, _)| name == "k_i2");
    let share = 100.0 * share.map_or(f64::NAN, |(_, share)| *share);
    vec![
        quantity("frequency_1", hz[0], "Hz", "lowest natural frequency"),
        quantity(
            "frequency_9",
            hz[FIRST - 1],
            "Hz",
            "ninth natural frequency, repeated roots counted as often as they are",
        ),
        quantity(
            "repeated_roots",
            repeated as f64,
            "",
            "roots of multiplicity 2 or more among all",
        ),
        quantity(
            "compound_modes",
            compound as f64,
            "",
            "of the first nine modes those in which no kind of subsystem has more than 90 % of the kinetic energy",
        ),
        quantity(
            "output_swing_3",
            swing,
            "%",
            "share of the output shaft's swing about x and y in the kinetic energy of mode 3",
        ),
        quantity(
            "k_i2_share_3",
            share,
            "%",
            "share of the bearing between input and output in the strain energy of mode 3: twice the relative change of the frequency by that of the stiffness",
        ),
    ]
}

fn of_changes(
    model: &SpiderReducer,
    values: &[f64],
    nominal: &TheoryModes,
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let reference = first_frequencies(nominal);
    let changed = |name: &str, change: &dyn Fn(f64) -> f64| -> Result<Vec<f64>, TheoryError> {
        let mut values = values.to_vec();
        let at = index_of(model.name(), model.parameters(), name)?;
        values[at] = change(values[at]);
        let hz = solve(model, &values).map(|solved| first_frequencies(&solved));
        allowed_or(vec![f64::NAN; FIRST], hz)
    };
    let relative = |hz: &[f64], mode: usize| (hz[mode] / reference[mode] - 1.0).abs();
    let all = |hz: &[f64]| largest((0..FIRST).map(|mode| relative(hz, mode)));
    let mut third = 0.0f64;
    for factor in [0.5, 2.0] {
        third = largest([third, relative(&changed("k_i2", &|k| factor * k)?, 2)]);
    }
    let mut mesh = 0.0f64;
    for factor in [0.8, 1.2] {
        mesh = largest([mesh, all(&changed("k_m", &|k| factor * k)?)]);
    }
    let mut turn = 0.0f64;
    for position in 1..POSITIONS {
        let angle = TAU * position as f64 / POSITIONS as f64;
        let hz = changed("crank_angle", &|value| {
            value + if value > 0.0 { angle - TAU } else { angle }
        })?;
        turn = largest([turn, all(&hz)]);
    }
    let quantity = ModelQuantity::new;
    Ok(vec![
        quantity(
            "k_i2_change_3",
            100.0 * third,
            "%",
            "largest change of frequency 3 when the bearing between input and output has half or twice its stiffness",
        ),
        quantity(
            "k_m_change",
            100.0 * mesh,
            "%",
            "largest change of the first nine frequencies when the mesh stiffness changes by 20 %",
        ),
        quantity(
            "crank_change",
            100.0 * turn,
            "%",
            "largest change of the first nine frequencies over a turn of the crank, 24 positions: rounding alone, since K(phi) = R^T K(0) R for 3 and more equal shafts",
        ),
    ])
}

fn of_statics(model: &SpiderReducer, values: &[f64]) -> Result<Vec<ModelQuantity>, TheoryError> {
    let matrices = model.assemble(values)?;
    let value = |name: &str| -> Result<f64, TheoryError> {
        Ok(values[index_of(model.name(), model.parameters(), name)?])
    };
    let (e, radius) = (value("eccentricity")?, value("ring_base_radius")?);
    let (sin, cos) = value("crank_angle")?.sin_cos();
    let output = matrices.coordinates.iter().position(|c| c.name == "boz");
    let output = output.unwrap_or_default();
    let mut load = vec![0.0; matrices.coordinates.len()];
    load[output] = -LOAD_NM;
    let moved = least_squares_real(&matrices.stiffness, &load)?;
    let mesh = forces(&matrices, "k_m", &moved);
    // Along x for both phases, then along y.
    let bearing = forces(&matrices, "k_a", &moved);
    let torque = |x: f64, y: f64, side: f64| side * e * (cos * y - sin * x);
    let carried = torque(bearing[0], bearing[2], 1.0) + torque(bearing[1], bearing[3], -1.0);
    let preload = preload(&matrices, [cos, sin])?;
    let quantity = ModelQuantity::new;
    let under = "under 1000 N m on the output, the input held";
    let make_quantity =
        |name, value, unit, what: &str| quantity(name, value, unit, &format!("{what}, {under}"));
    let ratio = RING_TEETH / (RING_TEETH - GEAR_TEETH);
    Ok(vec![
        make_quantity(
            "output_twist",
            moved[output],
            "rad",
            "rotation of the output",
        ),
        make_quantity("mesh_force_1", mesh[0], "N", "mesh force of phase 1"),
        make_quantity("mesh_force_2", mesh[1], "N", "mesh force of phase 2"),
        make_quantity(
            "mesh_torque",
            radius * (mesh[0] + mesh[1]),
            "N m",
            "both mesh forces times the base radius, which balance the load",
        ),
        make_quantity(
            "bearing_force_1",
            bearing[0].hypot(bearing[2]),
            "N",
            "force on the input's bearing in gear 1",
        ),
        make_quantity(
            "bearing_force_2",
            bearing[1].hypot(bearing[3]),
            "N",
            "force on the input's bearing in gear 2",
        ),
        make_quantity(
            "input_torque",
            carried.abs(),
            "N m",
            "torque that the eccentrics carry",
        ),
        quantity(
            "ratio",
            ratio,
            "",
            "transmission ratio z2/(z2 - z1); load over input torque",
        ),
        quantity(
            "preload_x",
            preload[0],
            "N",
            "force along x on the input's bearing in gear 1 from an eccentricity error of 10 µm",
        ),
        quantity("preload_y", preload[1], "N", "force along y on the same"),
    ])
}

/// Force in each spring of one name.
fn forces(matrices: &SystemMatrices, name: &str, moved: &[f64]) -> Vec<f64> {
    let named_springs = matrices.springs.iter().filter(|spring| spring.name == name);
    named_springs
        .map(|spring| {
            let stretch: f64 = spring.row.iter().zip(moved).map(|(a, b)| a * b).sum();
            spring.stiffness * stretch
        })
        .collect()
}

/// An error along `direction` of the first eccentric is a stretch of its two springs that nothing
/// has relieved yet.
fn preload(matrices: &SystemMatrices, direction: [f64; 2]) -> Result<[f64; 2], TheoryError> {
    let named_springs = matrices
        .springs
        .iter()
        .filter(|spring| spring.name == "k_a");
    let springs: Vec<_> = named_springs.step_by(2).collect();
    let mut load = vec![0.0; matrices.coordinates.len()];
    for (spring, part) in springs.iter().zip(direction) {
        for (force, row) in load.iter_mut().zip(&spring.row) {
            *force += spring.stiffness * row * part * ERROR_M;
        }
    }
    let moved = least_squares_real(&matrices.stiffness, &load)?;
    let error_forces = forces(matrices, "k_a", &moved);
    let force = |i: usize| error_forces[2 * i] - springs[i].stiffness * direction[i] * ERROR_M;
    Ok(std::array::from_fn(force))
}

//! The Nyquist circle of each mode in the FRF to which it contributes most.

use std::f64::consts::TAU;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::frf::FrfSet;
use crate::identify::circle_detail;
use crate::modal::{ModalModel, Mode};

use super::super::test_result::TestResult;
use super::curves::{modal_terms, single_set};
use super::rounding::rounded;

/// Half width of the fitted band, half-power bandwidths.
const FIT_BAND_BANDWIDTHS: f64 = 1.5;
/// Minimum number of lines on either side of the resonance.
const MIN_LINES_PER_SIDE: usize = 4;
/// Maximum number of lines of a plot.
const MAX_LINES: usize = 61;

/// The Nyquist plot of one mode with its circle and damping surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CircleFigure {
    /// Number of the mode, from 1.
    pub mode: usize,
    /// Its natural frequency, Hz.
    pub hz: f64,
    /// Response and reference of the function, in which the mode has its largest residue.
    pub function: String,
    /// Frequency of each point, Hz.
    pub line_hz: Vec<f64>,
    /// Real part of the receptance without the other modes, m/N.
    pub re: Vec<f64>,
    /// Imaginary part, m/N.
    pub im: Vec<f64>,
    /// Centre of the circle, m/N.
    pub center: [f64; 2],
    /// Its radius, m/N.
    pub radius: f64,
    /// The point of resonance, m/N.
    pub resonance: [f64; 2],
    /// Frequency of the fastest sweep, Hz.
    pub resonance_hz: f64,
    /// Lines below the resonance, Hz: rows of `damping`.
    pub below_hz: Vec<f64>,
    /// Lines above, Hz: columns.
    pub above_hz: Vec<f64>,
    /// Damping ratio of each pair of lines as in the data, that of an exponential window included.
    pub damping: Vec<Vec<Option<f64>>>,
    /// Damping ratio of an exponential window in it.
    pub window_damping: f64,
}

/// The figure of every mode whose resonance is a circle.
pub(super) fn circle_figures(test: &TestResult) -> Vec<CircleFigure> {
    let Some(set) = single_set(&test.frfs) else {
        return Vec::new();
    };
    let figure_of_mode = |index: usize| circle_figure(set, &test.modes, index);
    (0..test.modes.modes.len())
        .filter_map(figure_of_mode)
        .collect()
}

/// The function in which a mode has its largest residue.
fn best_function(set: &FrfSet, mode: &Mode) -> Option<usize> {
    let size = |i: &usize| {
        let function = &set.functions()[*i];
        let pair = (function.response.clone(), function.reference.clone());
        mode.residues.get(&pair).map_or(0.0, |a| a.norm())
    };
    (0..set.len()).max_by(|a, b| size(a).total_cmp(&size(b)))
}

fn circle_figure(set: &FrfSet, modes: &ModalModel, index: usize) -> Option<CircleFigure> {
    let mode = &modes.modes[index];
    let i = best_function(set, mode)?;
    let terms = modal_terms(set, i, modes)?;
    let pole = mode.pole()?;
    let in_data = pole.lambda - set.added_damping_rad_s;
    let axis = set.axis();
    let width_hz = 2.0 * -in_data.re / TAU;
    let side =
        ((FIT_BAND_BANDWIDTHS * width_hz / axis.step_hz).ceil() as usize).max(MIN_LINES_PER_SIDE);
    let middle = axis.nearest(pole.damped_frequency_hz())?;
    let first = middle
        .saturating_sub(side)
        .max(usize::from(axis.start_hz <= 0.0));
    let last = (middle + side).min(axis.len - 1);
    let stride = (last - first + 1).div_ceil(MAX_LINES).max(1);
    let lines: Vec<usize> = (first..=last).step_by(stride).collect();
    let d = set.functions()[i].kind.derivative_order();
    let alone = |k: &usize| {
        let s = Complex64::new(set.added_damping_rad_s, axis.rad_s(*k));
        let others = terms.iter().enumerate().filter(|(j, _)| *j != index);
        let others: Complex64 = others.map(|(_, term)| term.value(s)).sum();
        set.values(i)[*k] / s.powi(d) - others - terms[index].conjugate_value(s)
    };
    let values: Vec<Complex64> = lines.iter().map(alone).collect();
    let omega: Vec<f64> = lines.iter().map(|k| axis.rad_s(*k)).collect();
    let detail = circle_detail(&omega, &values, in_data)?;
    let hz = |lines: &[usize]| lines.iter().map(|n| rounded(omega[*n] / TAU, 7)).collect();
    let number = |value: f64| rounded(value, 5);
    let function = &set.functions()[i];
    let surface = detail.damping.iter();
    let surface = surface.map(|row| {
        row.iter()
            .map(|cell| cell.map(|zeta| rounded(zeta, 4)))
            .collect()
    });
    Some(CircleFigure {
        mode: index + 1,
        hz: mode.frequency_hz,
        function: format!("{} / {}", function.response, function.reference),
        line_hz: omega.iter().map(|w| rounded(w / TAU, 7)).collect(),
        re: values.iter().map(|v| number(v.re)).collect(),
        im: values.iter().map(|v| number(v.im)).collect(),
        center: [number(detail.center.re), number(detail.center.im)],
        radius: number(detail.radius),
        resonance: [number(detail.resonance.re), number(detail.resonance.im)],
        resonance_hz: rounded(detail.omega_rad_s / TAU, 7),
        below_hz: hz(&detail.below),
        above_hz: hz(&detail.above),
        damping: surface.collect(),
        window_damping: rounded(set.added_damping_rad_s / in_data.norm(), 4),
    })
}

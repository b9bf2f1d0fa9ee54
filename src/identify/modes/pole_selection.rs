//! The user selects poles among those of a method.
//!
//! Each selected pole is the nearest one of the method in the band within the tolerance, of the
//! stated order where the user states one; of equally near poles, a stable one. A pole is selected
//! once. A pole of another order at a selected one is the same mode: it is selected in addition
//! only where the user states its order. The residues are fitted again with the selected poles
//! fixed, and no test rejects these. The other modes of the method are fitted with them, so that
//! their contributions do not bias the selected ones, and are left out of the result.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::modal::{Pole, PoleSelection, SelectedPole};

use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, PoleStatus, PoleTable};
use crate::linalg::sort_ascending_by;

/// Maximum distance of a mode from the selected pole that it belongs to, in decay rates.
const MATCH_DECAY_RATES: f64 = 0.5;
/// Maximum difference of the distances of equally near poles, in decay rates.
const TIE_DECAY_RATES: f64 = 0.1;

/// A pole of the method, without the window's damping.
#[derive(Clone, Copy)]
struct SelectablePole {
    order: Option<usize>,
    as_in_data: Pole,
    pole: Pole,
    status: PoleStatus,
    /// Whether it is a mode of the method.
    mode: bool,
    /// Whether it is selected only where its order is stated: a refined mode is the better answer
    /// otherwise.
    only_by_order: bool,
}

impl SelectablePole {
    /// Whether it is a mode that is selected already, at another order. Two modes of the method are
    /// never the same, however near.
    fn repeats(&self, taken: &Self) -> bool {
        let (lambda, other) = (self.as_in_data.lambda, taken.as_in_data.lambda);
        (lambda - other).norm() < MATCH_DECAY_RATES * other.re.abs() && !(self.mode && taken.mode)
    }
}

/// The modes of the selected poles; `fit_residues` fits the residues of given poles, rad/s.
///
/// # Errors
/// Those of `fit_residues`.
pub(in crate::identify) fn select_poles(
    set: &FrfSet,
    band: Band,
    table: PoleTable,
    selection: &PoleSelection,
    fit_residues: impl FnOnce(&[Complex64]) -> Result<PoleTable, IdentifyError>,
) -> Result<PoleTable, IdentifyError> {
    let mut selectable_poles = selectable_poles(set, band, &table);
    let mut taken: Vec<(SelectedPole, SelectablePole)> = Vec::new();
    let mut missed_selections = Vec::new();
    for wanted in &selection.poles {
        match find_best(
            &selectable_poles,
            wanted,
            &taken,
            selection.tolerance_of(wanted),
        ) {
            Ok(position) => taken.push((*wanted, selectable_poles.swap_remove(position))),
            Err(nearest) => missed_selections.push(missed_selection(wanted, nearest, selection)),
        }
    }
    let frequency = |selected: &(SelectedPole, SelectablePole)| selected.1.as_in_data.lambda.im;
    sort_ascending_by(&mut taken, frequency);
    let chosen: Vec<Complex64> = taken
        .iter()
        .map(|selected| selected.1.as_in_data.lambda)
        .collect();
    let modes = table
        .candidates
        .iter()
        .map(|candidate| candidate.pole.lambda);
    let replaced = |mode: &Complex64| {
        let near = |pole: &Complex64| (pole - mode).norm() < MATCH_DECAY_RATES * mode.re.abs();
        chosen.iter().any(near)
    };
    let others = modes.filter(|mode| !replaced(mode));
    let poles: Vec<Complex64> = chosen.iter().copied().chain(others).collect();
    let mut result = fit_residues(&poles)?;
    let is_chosen = |pole: &Pole| chosen.contains(&pole.lambda);
    result
        .candidates
        .retain(|candidate| is_chosen(&candidate.pole));
    for (wanted, offer) in &taken {
        let same = |candidate: &&mut Candidate| candidate.pole == offer.as_in_data;
        match result.candidates.iter_mut().find(same) {
            Some(candidate) => candidate.order = offer.order,
            None => missed_selections.push(missed_selection(wanted, None, selection)),
        }
    }
    let hz = |candidate: &Candidate| {
        let pole = candidate.pole;
        pole.without_added_damping(set.added_damping_rad_s)
            .natural_frequency_hz()
    };
    let mode_hz: Vec<f64> = result.candidates.iter().map(hz).collect();
    result.findings.retain(|finding| match finding.location {
        Location::Mode(at) => mode_hz.iter().any(|hz| (hz - at).abs() <= 1e-9 * hz),
        _ => true,
    });
    result.findings.extend(missed_selections);
    result.stabilization = table.stabilization;
    Ok(result)
}

/// All poles of a method in the band: those of all orders, and its modes.
fn selectable_poles(set: &FrfSet, band: Band, table: &PoleTable) -> Vec<SelectablePole> {
    let (modes, points) = (&table.candidates, table.stabilization.iter());
    let is_mode = |pole: Pole| modes.iter().any(|mode| mode.pole == pole);
    let refined = !modes.is_empty() && !points.clone().any(|point| is_mode(point.pole));
    let offer = |order, pole: Pole, status| SelectablePole {
        order,
        as_in_data: pole,
        pole: pole.without_added_damping(set.added_damping_rad_s),
        status,
        mode: is_mode(pole),
        only_by_order: refined && !is_mode(pole),
    };
    let mut selectable_poles: Vec<SelectablePole> = points
        .map(|point| offer(Some(point.order), point.pole, point.status))
        .collect();
    for mode in modes {
        if !selectable_poles
            .iter()
            .any(|selectable| selectable.as_in_data == mode.pole)
        {
            selectable_poles.push(offer(mode.order, mode.pole, PoleStatus::Selected));
        }
    }
    let hz = |selectable: &SelectablePole| selectable.as_in_data.natural_frequency_hz();
    selectable_poles
        .retain(|selectable| hz(selectable) >= band.lo_hz && hz(selectable) <= band.hi_hz);
    selectable_poles
}

/// Position of the best pole within the tolerance, else the distance of the nearest one, Hz.
fn find_best(
    selectable_poles: &[SelectablePole],
    wanted: &SelectedPole,
    taken: &[(SelectedPole, SelectablePole)],
    tolerance_hz: f64,
) -> Result<usize, Option<f64>> {
    let fits = |offer: &SelectablePole| match wanted.order {
        None => !offer.only_by_order && !taken.iter().any(|(_, selected)| offer.repeats(selected)),
        order => offer.order == order,
    };
    let hz =
        |offer: &SelectablePole| (offer.pole.natural_frequency_hz() - wanted.frequency_hz).abs();
    let distance_rad_s = |position: &usize| match wanted.damping_ratio {
        Some(zeta) => {
            let wanted_pole = Pole::from_frequency(wanted.frequency_hz, zeta);
            (wanted_pole.lambda - selectable_poles[*position].pole.lambda).norm()
        }
        None => TAU * hz(&selectable_poles[*position]),
    };
    let nearer = |a: &usize, b: &usize| distance_rad_s(a).total_cmp(&distance_rad_s(b));
    let fitting: Vec<usize> = (0..selectable_poles.len())
        .filter(|i| fits(&selectable_poles[*i]))
        .collect();
    let near = fitting.iter().copied();
    let near: Vec<usize> = near
        .filter(|i| hz(&selectable_poles[*i]) <= tolerance_hz)
        .collect();
    let Some(nearest) = near.iter().copied().min_by(nearer) else {
        let distances = fitting.iter().map(|i| hz(&selectable_poles[*i]));
        return Err(distances.min_by(f64::total_cmp));
    };
    let is_tied = |position: &usize| {
        let slack = TIE_DECAY_RATES * selectable_poles[*position].pole.lambda.re.abs();
        distance_rad_s(position) <= distance_rad_s(&nearest) + slack
    };
    let is_stable = |position: &usize| selectable_poles[*position].status != PoleStatus::Unstable;
    let stable = near.into_iter().filter(|i| is_stable(i) && is_tied(i));
    Ok(stable.min_by(nearer).unwrap_or(nearest))
}

fn missed_selection(
    wanted: &SelectedPole,
    nearest_hz: Option<f64>,
    selection: &PoleSelection,
) -> Finding {
    let location = Location::Mode(wanted.frequency_hz);
    let finding = Finding::new(Severity::Error, Code::SelectionMissed, location);
    let finding = match nearest_hz {
        Some(hz) => finding.value(hz, "Hz"),
        None => finding,
    };
    finding.limit(selection.tolerance_of(wanted))
}

#[cfg(test)]
mod tests {
    use crate::identify::modes::pole_selection::*;

    fn selectable(hz: f64, status: PoleStatus) -> SelectablePole {
        let pole = Pole::from_frequency(hz, 0.01);
        SelectablePole {
            order: Some(12),
            as_in_data: pole,
            pole,
            status,
            mode: status == PoleStatus::Selected,
            only_by_order: false,
        }
    }

    fn wanted(hz: f64) -> SelectedPole {
        SelectedPole {
            frequency_hz: hz,
            damping_ratio: Some(0.01),
            order: None,
        }
    }

    #[test]
    fn nearest_pole_is_selected_and_of_equally_near_ones_a_stable_one() {
        // A decay rate is 1 Hz.
        let best_near = |other_hz: f64| {
            let offers = [
                selectable(100.0, PoleStatus::Stable),
                selectable(other_hz, PoleStatus::Unstable),
            ];
            find_best(&offers, &wanted(other_hz), &[], 1.0)
        };
        assert_eq!(best_near(100.5), Ok(1));
        assert_eq!(best_near(100.15), Ok(1));
        assert_eq!(best_near(100.05), Ok(0));
    }

    #[test]
    fn pole_at_a_selected_one_is_selected_only_where_its_order_is_stated_or_both_are_modes() {
        let near = |status| [selectable(100.3, status)];
        let best_beside = |status, order, offers: &[SelectablePole]| {
            let taken = [(wanted(100.0), selectable(100.0, status))];
            let wanted = SelectedPole {
                order,
                ..wanted(100.3)
            };
            find_best(offers, &wanted, &taken, 1.0)
        };
        let (stable, mode) = (PoleStatus::Stable, PoleStatus::Selected);
        assert_eq!(best_beside(mode, None, &near(stable)), Err(None));
        assert_eq!(best_beside(stable, None, &near(mode)), Err(None));
        assert_eq!(best_beside(mode, None, &near(mode)), Ok(0));
        assert_eq!(best_beside(mode, Some(12), &near(stable)), Ok(0));
        assert_eq!(best_beside(mode, None, &[selectable(100.6, stable)]), Ok(0));
    }
}

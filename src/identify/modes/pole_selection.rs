//! A person's choice among the poles of a method.
//!
//! Each chosen pole is the nearest one of the method in the band within the tolerance, of one order
//! alone where the choice names it; of poles that are as near, one that stays. Poles are taken
//! once, and those of other orders that lie on a taken one are the same mode: they are taken beside
//! it only where their order is named. Residues are fitted anew with the chosen poles where they
//! are, and no test undoes the choice; the other modes of the method stay in the fit, so that what
//! they put into the data does not go to those that were chosen, and are left out of the result.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::modal::{Pole, PoleSelection, SelectedPole};

use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, PoleStatus, PoleTable};
use crate::identify::mdof::estimator;

/// A mode within so many decay rates of a chosen pole is that pole.
const OWN: f64 = 0.5;
/// Poles whose distances differ by so many decay rates are as near as each other.
const AS_NEAR: f64 = 0.1;

/// A pole of the method, without the window's damping.
#[derive(Clone, Copy)]
struct Offered {
    order: Option<usize>,
    as_in_data: Pole,
    pole: Pole,
    status: PoleStatus,
    /// Whether it is a mode of the method.
    mode: bool,
    /// Whether it is meant only where its order is named: modes that left the poles of all orders
    /// are the better answer otherwise.
    by_order_alone: bool,
}

impl Offered {
    /// Whether it is a mode that was taken already, seen at another order. Two modes of the method
    /// are two, however near.
    fn repeats(&self, taken: &Self) -> bool {
        let (own, other) = (self.as_in_data.lambda, taken.as_in_data.lambda);
        (own - other).norm() < OWN * other.re.abs() && !(self.mode && taken.mode)
    }
}

/// The modes of chosen poles.
///
/// # Errors
/// [`IdentifyError`] as for an estimate.
pub(in crate::identify) fn chosen(
    (set, band): (&FrfSet, Band),
    table: PoleTable,
    selection: &PoleSelection,
) -> Result<PoleTable, IdentifyError> {
    let mut offers = offers((set, band), &table);
    let mut taken: Vec<(SelectedPole, Offered)> = Vec::new();
    let mut missed = Vec::new();
    for wanted in &selection.poles {
        match best(&offers, (wanted, &taken), selection.tolerance_of(wanted)) {
            Ok(place) => taken.push((*wanted, offers.swap_remove(place))),
            Err(nearest) => missed.push(miss(wanted, nearest, selection)),
        }
    }
    let frequency = |own: &(SelectedPole, Offered)| own.1.as_in_data.lambda.im;
    taken.sort_by(|a, b| frequency(a).total_cmp(&frequency(b)));
    let chosen: Vec<Complex64> = taken.iter().map(|own| own.1.as_in_data.lambda).collect();
    let modes = table.candidates.iter().map(|own| own.pole.lambda);
    let replaced = |mode: &Complex64| {
        let near = |pole: &Complex64| (pole - mode).norm() < OWN * mode.re.abs();
        chosen.iter().any(near)
    };
    let others = modes.filter(|mode| !replaced(mode));
    let poles: Vec<Complex64> = chosen.iter().copied().chain(others).collect();
    let mut own = estimator::at_poles((set, band), &poles, table.moved)?;
    let is_chosen = |pole: &Pole| chosen.contains(&pole.lambda);
    own.candidates.retain(|own| is_chosen(&own.pole));
    for (wanted, offer) in &taken {
        let same = |own: &&mut Candidate| own.pole == offer.as_in_data;
        match own.candidates.iter_mut().find(same) {
            Some(candidate) => candidate.order = offer.order,
            None => missed.push(miss(wanted, None, selection)),
        }
    }
    let hz = |candidate: &Candidate| {
        let pole = candidate.pole;
        pole.without_added_damping(set.added_damping_rad_s)
            .natural_frequency_hz()
    };
    let own_hz: Vec<f64> = own.candidates.iter().map(hz).collect();
    own.findings.retain(|finding| match finding.place {
        Place::Mode(at) => own_hz.iter().any(|hz| (hz - at).abs() <= 1e-9 * hz),
        _ => true,
    });
    own.findings.extend(missed);
    own.stabilization = table.stabilization;
    Ok(own)
}

/// All poles of a method in the band: those of all orders, and its modes.
fn offers((set, band): (&FrfSet, Band), table: &PoleTable) -> Vec<Offered> {
    let (modes, points) = (&table.candidates, table.stabilization.iter());
    let is_mode = |pole: Pole| modes.iter().any(|mode| mode.pole == pole);
    let refined = !modes.is_empty() && !points.clone().any(|point| is_mode(point.pole));
    let offer = |order, pole: Pole, status| Offered {
        order,
        as_in_data: pole,
        pole: pole.without_added_damping(set.added_damping_rad_s),
        status,
        mode: is_mode(pole),
        by_order_alone: refined && !is_mode(pole),
    };
    let mut offers: Vec<Offered> = points
        .map(|point| offer(Some(point.order), point.pole, point.status))
        .collect();
    for mode in modes {
        if !offers.iter().any(|own| own.as_in_data == mode.pole) {
            offers.push(offer(mode.order, mode.pole, PoleStatus::Chosen));
        }
    }
    let hz = |own: &Offered| own.as_in_data.natural_frequency_hz();
    offers.retain(|own| hz(own) >= band.lo_hz && hz(own) <= band.hi_hz);
    offers
}

/// Place of the best offer within the tolerance, else the distance of the nearest pole.
fn best(
    offers: &[Offered],
    (wanted, taken): (&SelectedPole, &[(SelectedPole, Offered)]),
    tolerance_hz: f64,
) -> Result<usize, Option<f64>> {
    let fits = |offer: &Offered| match wanted.order {
        None => !offer.by_order_alone && !taken.iter().any(|(_, own)| offer.repeats(own)),
        order => offer.order == order,
    };
    let hz = |offer: &Offered| (offer.pole.natural_frequency_hz() - wanted.frequency_hz).abs();
    let distance_rad_s = |place: &usize| match wanted.damping_ratio {
        Some(zeta) => {
            let own = Pole::from_frequency(wanted.frequency_hz, zeta);
            (own.lambda - offers[*place].pole.lambda).norm()
        }
        None => TAU * hz(&offers[*place]),
    };
    let nearer = |a: &usize, b: &usize| distance_rad_s(a).total_cmp(&distance_rad_s(b));
    let fitting: Vec<usize> = (0..offers.len()).filter(|i| fits(&offers[*i])).collect();
    let near = fitting.iter().copied();
    let near: Vec<usize> = near.filter(|i| hz(&offers[*i]) <= tolerance_hz).collect();
    let Some(nearest) = near.iter().copied().min_by(nearer) else {
        let distances = fitting.iter().map(|i| hz(&offers[*i]));
        return Err(distances.min_by(f64::total_cmp));
    };
    let as_near = |place: &usize| {
        let slack = AS_NEAR * offers[*place].pole.lambda.re.abs();
        distance_rad_s(place) <= distance_rad_s(&nearest) + slack
    };
    let stays = |place: &usize| offers[*place].status != PoleStatus::Alone;
    let staying = near.into_iter().filter(|i| stays(i) && as_near(i));
    Ok(staying.min_by(nearer).unwrap_or(nearest))
}

fn miss(wanted: &SelectedPole, nearest_hz: Option<f64>, selection: &PoleSelection) -> Finding {
    let place = Place::Mode(wanted.frequency_hz);
    let finding = Finding::new(Severity::Error, Code::SelectionMissed, place);
    let finding = match nearest_hz {
        Some(hz) => finding.value(hz, "Hz"),
        None => finding,
    };
    finding.limit(selection.tolerance_of(wanted))
}

#[cfg(test)]
mod tests {
    use crate::identify::modes::pole_selection::*;

    fn offered(hz: f64, status: PoleStatus) -> Offered {
        let pole = Pole::from_frequency(hz, 0.01);
        Offered {
            order: Some(12),
            as_in_data: pole,
            pole,
            status,
            mode: status == PoleStatus::Chosen,
            by_order_alone: false,
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
    fn the_nearest_pole_is_taken_and_of_poles_as_near_one_that_stays() {
        // A decay rate is 1 Hz.
        let at = |alone: f64| {
            let offers = [
                offered(100.0, PoleStatus::Stable),
                offered(alone, PoleStatus::Alone),
            ];
            best(&offers, (&wanted(alone), &[]), 1.0)
        };
        assert_eq!(at(100.5), Ok(1));
        assert_eq!(at(100.15), Ok(1));
        assert_eq!(at(100.05), Ok(0));
    }

    #[test]
    fn what_lies_on_a_taken_pole_is_taken_where_its_order_is_named_or_both_are_modes() {
        let near = |status| [offered(100.3, status)];
        let of = |status, order, offers: &[Offered]| {
            let taken = [(wanted(100.0), offered(100.0, status))];
            let wanted = SelectedPole {
                order,
                ..wanted(100.3)
            };
            best(offers, (&wanted, &taken), 1.0)
        };
        let (stable, mode) = (PoleStatus::Stable, PoleStatus::Chosen);
        assert_eq!(of(mode, None, &near(stable)), Err(None));
        assert_eq!(of(stable, None, &near(mode)), Err(None));
        assert_eq!(of(mode, None, &near(mode)), Ok(0));
        assert_eq!(of(mode, Some(12), &near(stable)), Ok(0));
        assert_eq!(of(mode, None, &[offered(100.6, stable)]), Ok(0));
    }
}

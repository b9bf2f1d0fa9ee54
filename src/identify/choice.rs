//! A person's choice among the poles of a method.
//!
//! Each chosen pole is the nearest one of the method within the tolerance: of its modes and of the poles that stay first, then of
//! all others of its model orders; of one order alone where the choice names it. Poles are taken once. Residues are fitted anew with the
//! chosen poles where they are, and no test undoes the choice; the other modes of the method stay in the fit, so that what they put
//! into the data does not go to those that were chosen, and are left out of the result.

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::modal::{Pole, PoleSelection, SelectedPole};

use super::multi;
use super::{IdentifyError, PoleStatus, PoleTable};

/// A mode within so many decay rates of a chosen pole is that pole.
const OWN: f64 = 0.5;

/// A pole of the method, without the window's damping.
#[derive(Clone, Copy)]
struct Offered {
    order: Option<usize>,
    as_in_data: Pole,
    pole: Pole,
    status: PoleStatus,
}

/// The modes of chosen poles.
///
/// # Errors
/// [`IdentifyError`] as for an estimate.
pub(super) fn chosen(
    (set, band): (&FrfSet, Band),
    mut table: PoleTable,
    selection: &PoleSelection,
) -> Result<PoleTable, IdentifyError> {
    let mut offers = offers(set, &table);
    let by_order = table.candidates.iter().any(|own| own.order.is_some());
    let (mut taken, mut missed) = (Vec::new(), Vec::new());
    for wanted in &selection.poles {
        match best(&offers, (wanted, by_order), selection.tolerance_of(wanted)) {
            Ok(place) => taken.push(offers.swap_remove(place)),
            Err(nearest) => missed.push(miss(wanted, nearest, selection)),
        }
    }
    taken.sort_by(|a, b| a.as_in_data.lambda.im.total_cmp(&b.as_in_data.lambda.im));
    let chosen: Vec<Complex64> = taken.iter().map(|own| own.as_in_data.lambda).collect();
    let modes = table.candidates.iter().map(|own| own.pole.lambda);
    let replaced = |mode: &Complex64| {
        let near = |pole: &Complex64| (pole - mode).norm() < OWN * mode.re.abs();
        chosen.iter().any(near)
    };
    let others = modes.filter(|mode| !replaced(mode));
    let poles: Vec<Complex64> = chosen.iter().copied().chain(others).collect();
    let mut own = multi::at_poles(set, band, &poles)?;
    let is_chosen = |pole: &Pole| chosen.contains(&pole.lambda);
    own.candidates.retain(|own| is_chosen(&own.pole));
    for candidate in &mut own.candidates {
        let same = |offer: &&Offered| offer.as_in_data == candidate.pole;
        candidate.order = taken.iter().find(same).and_then(|offer| offer.order);
    }
    for point in &mut table.stabilization {
        let same = |offer: &Offered| {
            offer.as_in_data == point.pole && offer.order.is_none_or(|n| n == point.order)
        };
        if taken.iter().any(same) {
            point.status = PoleStatus::Chosen;
        } else if point.status == PoleStatus::Chosen {
            point.status = PoleStatus::Stable;
        }
    }
    own.findings.extend(missed);
    own.stabilization = table.stabilization;
    Ok(own)
}

/// All poles of a method: those of all orders, or where it has none its modes.
fn offers(set: &FrfSet, table: &PoleTable) -> Vec<Offered> {
    let offer = |order, pole: Pole, status| Offered {
        order,
        as_in_data: pole,
        pole: pole.without_added_damping(set.added_damping_rad_s),
        status,
    };
    let points = table.stabilization.iter();
    let mut offers: Vec<Offered> = points
        .map(|point| offer(Some(point.order), point.pole, point.status))
        .collect();
    for candidate in &table.candidates {
        if !offers.iter().any(|own| own.as_in_data == candidate.pole) {
            offers.push(offer(candidate.order, candidate.pole, PoleStatus::Chosen));
        }
    }
    offers
}

/// Place of the best offer within the tolerance, else the distance of the nearest pole. Where modes have no order of their own, poles of
/// an order are meant only where it is named.
fn best(
    offers: &[Offered],
    (wanted, by_order): (&SelectedPole, bool),
    tolerance_hz: f64,
) -> Result<usize, Option<f64>> {
    let fits = |offer: &Offered| match wanted.order {
        None => by_order || offer.order.is_none(),
        order => offer.order == order,
    };
    let hz = |offer: &Offered| (offer.pole.natural_frequency_hz() - wanted.frequency_hz).abs();
    let distance = |offer: &Offered| match wanted.damping_ratio {
        Some(zeta) => {
            let own = Pole::from_frequency(wanted.frequency_hz, zeta);
            (own.lambda - offer.pole.lambda).norm()
        }
        None => hz(offer),
    };
    let fitting: Vec<usize> = (0..offers.len()).filter(|i| fits(&offers[*i])).collect();
    let near = fitting.iter().filter(|i| hz(&offers[**i]) <= tolerance_hz);
    let alone = |i: usize| offers[i].status == PoleStatus::Alone;
    let found = near.min_by(|a, b| {
        let order = alone(**a).cmp(&alone(**b));
        order.then(distance(&offers[**a]).total_cmp(&distance(&offers[**b])))
    });
    found.copied().ok_or_else(|| {
        let nearest = fitting.iter().map(|i| &offers[*i]);
        let nearest = nearest.min_by(|a, b| hz(a).total_cmp(&hz(b)));
        nearest.map(hz)
    })
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

//! The study of methods finds the lowest sufficient order of every method with an order, and the
//! modes for which a single-mode method is sufficient.

use rayon::prelude::*;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::identify::{ESTIMATORS, Entry, identification};
use crate::modal::{ModalModel, Mode};

use super::super::speed_accuracy::RefinedSolution;
use super::super::{Judge, Method};
use super::OrderOptions;

/// Orders that are tried, below the one that the method chooses, or below [`MIN_HIGHEST_ORDER`]
/// where that one is wrong.
const ORDERS: [usize; 17] = [
    4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48, 64, 96, 128,
];
/// All orders below this one are tried where a method is wrong at the order that it chooses.
const MIN_HIGHEST_ORDER: usize = 64;
/// Standard deviations of the refined solution within which an error is not significant.
const MAX_ERROR_STDS: f64 = 2.0;

/// Missed and spurious modes of a method at a highest order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriedOrder {
    /// Highest order.
    pub order: usize,
    /// Observable modes of the refined solution that the method missed.
    pub missed: usize,
    /// Modes that the refined solution does not have.
    pub spurious: usize,
}

impl TriedOrder {
    /// Whether the method found all modes and no other.
    pub fn is_correct(&self) -> bool {
        self.missed + self.spurious == 0
    }
}

/// The lowest order of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct LowestOrder {
    /// Its name in [`ESTIMATORS`].
    pub method: &'static str,
    /// The order that the method chooses, with its missed and spurious modes; `None` where it
    /// refuses the data or finds no pole.
    pub chosen: Option<TriedOrder>,
    /// From the lowest on, until one is correct; orders that the method refuses are left out.
    pub tried: Vec<TriedOrder>,
}

impl LowestOrder {
    /// The lowest order that finds all modes of the refined solution and no other.
    pub fn lowest(&self) -> Option<usize> {
        let mut all = self.tried.iter().chain(&self.chosen);
        all.find(|order| order.is_correct())
            .map(|order| order.order)
    }
}

/// A method of one mode at a time on one mode: relative errors against the refined solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleMode {
    /// Its name in [`ESTIMATORS`].
    pub method: &'static str,
    /// Errors of natural frequency and damping ratio; `None` for a mode that it missed.
    pub errors: Option<[f64; 2]>,
    /// Whether both errors are within the stated ones, or within two standard deviations of the
    /// refined solution.
    pub is_sufficient: bool,
}

/// The sufficient methods of a mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeNeeds {
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// The methods of one mode at a time, the simplest first.
    pub single: Vec<SingleMode>,
}

impl ModeNeeds {
    /// The simplest sufficient method; `None` where only a method of several modes at a time is.
    pub fn simplest(&self) -> Option<&'static str> {
        let mut all = self.single.iter();
        all.find(|method| method.is_sufficient)
            .map(|method| method.method)
    }
}

/// The lowest order of each method against the modes of the refined solution.
pub(super) fn lowest_orders(
    refined: &RefinedSolution,
    set: &FrfSet,
    band: Band,
) -> Vec<LowestOrder> {
    let judge = refined.judge();
    let with_order = ESTIMATORS.par_iter().filter(|entry| entry.has_order);
    with_order
        .map(|entry| lowest_order(entry, &judge, set, band))
        .collect()
}

fn lowest_order(entry: &Entry, judge: &Judge, set: &FrfSet, band: Band) -> LowestOrder {
    let method = |order| Method {
        name: entry.name,
        order,
    };
    let tried = |order, found: &ModalModel| {
        let verdict = judge.verdict(found);
        TriedOrder {
            order,
            missed: verdict.missed.len(),
            spurious: verdict.spurious.len(),
        }
    };
    let result = identification(set, &method(None).options(band)).ok();
    let chosen = result.and_then(|result| {
        let orders = result.stabilization.iter().map(|point| point.order);
        Some(tried(orders.max()?, &result.model))
    });
    let highest = match chosen {
        Some(chosen) if chosen.is_correct() => chosen.order,
        Some(chosen) => chosen.order.max(MIN_HIGHEST_ORDER),
        None => MIN_HIGHEST_ORDER,
    };
    let mut lower = Vec::new();
    for order in ORDERS.into_iter().filter(|order| *order < highest) {
        let found = method(Some(order)).identify(set, band);
        lower.extend(found.ok().map(|found| tried(order, &found)));
        if lower.last().is_some_and(TriedOrder::is_correct) {
            break;
        }
    }
    LowestOrder {
        method: entry.name,
        chosen,
        tried: lower,
    }
}

/// The modes that a method found, with the partner of each mode of the refined solution.
struct Found {
    method: &'static str,
    modes: Vec<Mode>,
    partners: Vec<Option<usize>>,
}

/// Every observable mode of the refined solution by the methods of one mode at a time.
pub(super) fn single_mode_methods(
    refined: &RefinedSolution,
    set: &FrfSet,
    band: Band,
    options: &OrderOptions,
) -> Vec<ModeNeeds> {
    let judge = refined.judge();
    let without_order = ESTIMATORS.iter().filter(|entry| !entry.has_order);
    let found: Vec<Found> = without_order
        .map(|entry| {
            let method = Method {
                name: entry.name,
                order: None,
            };
            let model = method.identify(set, band).ok();
            let partners = model.as_ref().map(|found| judge.verdict(found).partner);
            Found {
                method: entry.name,
                modes: model.map_or(Vec::new(), |found| found.modes),
                partners: partners.unwrap_or_default(),
            }
        })
        .collect();
    let needs = |(r, truth): (usize, &crate::study::TrueMode)| {
        let stds = refined.deviations(truth);
        let of = |found: &Found| {
            let mode = found.partners.get(r).copied().flatten();
            let errors = mode.and_then(|index| {
                let mode = &found.modes[index];
                let damping = mode.damping_ratio? / truth.pole.damping_ratio() - 1.0;
                Some([mode.frequency_hz / truth.hz() - 1.0, damping])
            });
            let wanted = [options.frequency_percent, options.damping_percent];
            let within = |needs: [f64; 2]| {
                let limits = wanted.map(|percent| 0.01 * percent).into_iter().zip(stds);
                needs.into_iter().zip(limits).all(|(error, (wanted, std))| {
                    error.abs() <= wanted.max(MAX_ERROR_STDS * std.unwrap_or(0.0))
                })
            };
            SingleMode {
                method: found.method,
                errors,
                is_sufficient: errors.is_some_and(within),
            }
        };
        ModeNeeds {
            frequency_hz: truth.hz(),
            damping_ratio: truth.pole.damping_ratio(),
            single: found.iter().map(of).collect(),
        }
    };
    let modes = judge.system().modes.iter().enumerate();
    let observable = modes.filter(|(r, _)| judge.detectability()[*r].observable);
    observable.map(needs).collect()
}

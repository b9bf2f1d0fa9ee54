//! The stabilization diagram over the complex mode indicator function.

use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::identify::{
    IdentifyOptions, PoleAtOrder, PoleStatus, cmif_at, identification, method_of_name,
};

use super::super::plan::Scene;
use super::super::test_result::TestResult;
use super::curves::{kept_lines, shown_functions, single_set};
use super::rounding::rounded;

/// Method whose poles are shown where the method of the test has no model orders.
const METHOD_WITH_ORDERS: &str = "lscf";
/// Lines of the indicator.
const MAX_INDICATOR_LINES: usize = 1200;
/// Singular values that are shown.
const MAX_SINGULAR_VALUES: usize = 3;
/// Maximum number of FRFs of a set that all give poles; of a larger set those that are shown do.
const MAX_FUNCTIONS: usize = 64;
/// Maximum number of poles; the lowest orders are omitted first.
const MAX_POLES: usize = 4000;

/// Poles of all model orders.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct StabilizationFigure {
    /// Method that gave the poles.
    pub method: String,
    /// Whether the modes of the test come from this method.
    pub own_method: bool,
    /// Highest model order, where the scene states it.
    pub max_order: Option<usize>,
    /// Functions that the poles rest on.
    pub functions: usize,
    /// Band, Hz.
    pub band_hz: [f64; 2],
    /// Model order of each pole.
    pub order: Vec<usize>,
    /// Natural frequency, Hz.
    pub hz: Vec<f64>,
    /// Damping ratio.
    pub damping: Vec<f64>,
    /// `alone`, `stable` or `chosen` as 0, 1 or 2.
    pub status: Vec<u8>,
    /// The indicator behind them.
    pub cmif: CmifCurve,
}

/// Singular values of the mobilities over frequency.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct CmifCurve {
    /// Frequency of each line, Hz.
    pub hz: Vec<f64>,
    /// First, second, ... value at these lines, m/(N s).
    pub values: Vec<Vec<f64>>,
}

/// Poles of the test's method, else of polyreference LSCF; `None` where neither gives any.
pub(super) fn stabilization_figure(
    scene: &Scene,
    test: &TestResult,
) -> Option<StabilizationFigure> {
    let set = single_set(&test.frfs)?;
    let band = test
        .modes
        .band
        .or(set.valid_band)
        .or_else(|| set.axis().band())?;
    let has_test_method = !test.stabilization.is_empty();
    let (poles, method, functions) = match has_test_method {
        true => {
            let method = method_of_name(scene.method.as_deref().unwrap_or("auto")).to_owned();
            (test.stabilization.clone(), method, set.len())
        }
        false => {
            let (poles, functions) = poles_of_orders(set, band);
            (poles, METHOD_WITH_ORDERS.to_owned(), functions)
        }
    };
    let cmif = cmif_curve(set, band)?;
    let inside = poles.iter().filter(|pole_at_order| {
        let damping = pole_at_order.pole.damping_ratio();
        damping > 0.0 && damping < 1.0 && band.contains(pole_at_order.pole.natural_frequency_hz())
    });
    let mut shown: Vec<&PoleAtOrder> = inside.collect();
    if shown.len() > MAX_POLES {
        shown.sort_by_key(|pole| std::cmp::Reverse(pole.order));
        shown.truncate(MAX_POLES);
        shown.reverse();
    }
    Some(StabilizationFigure {
        method,
        own_method: has_test_method,
        max_order: scene.order.filter(|_| has_test_method),
        functions,
        band_hz: [band.lo_hz, band.hi_hz],
        order: shown.iter().map(|pole| pole.order).collect(),
        hz: shown
            .iter()
            .map(|pole| rounded(pole.pole.natural_frequency_hz(), 8))
            .collect(),
        damping: shown
            .iter()
            .map(|pole| rounded(pole.pole.damping_ratio(), 5))
            .collect(),
        status: shown.iter().map(|pole| status(pole.status)).collect(),
        cmif,
    })
}

fn status(status: PoleStatus) -> u8 {
    match status {
        PoleStatus::Unstable => 0,
        PoleStatus::Stable => 1,
        PoleStatus::Selected => 2,
    }
}

/// Poles of all orders with the number of functions that they rest on; none where the method
/// refuses the set.
fn poles_of_orders(set: &FrfSet, band: Band) -> (Vec<PoleAtOrder>, usize) {
    let part = (set.len() > MAX_FUNCTIONS)
        .then(|| set.part(&shown_functions(set, &set.axis().lines(&band))));
    let set = part.as_ref().unwrap_or(set);
    let options = IdentifyOptions {
        method: METHOD_WITH_ORDERS.to_owned(),
        band: Some(band),
        ..IdentifyOptions::default()
    };
    let found = identification(set, &options).map(|fit| fit.stabilization);
    (found.unwrap_or_default(), set.len())
}

fn cmif_curve(set: &FrfSet, band: Band) -> Option<CmifCurve> {
    let axis = set.axis();
    let mut lines = axis.lines(&band);
    lines.start = lines.start.max(usize::from(axis.start_hz <= 0.0));
    let mut sum = vec![0.0; axis.len];
    for (i, function) in set.functions().iter().enumerate() {
        let d = 1 - function.kind.derivative_order();
        for k in lines.clone() {
            sum[k] += set.values(i)[k].norm() * axis.rad_s(k).powi(d);
        }
    }
    let kept = kept_lines(&sum, lines, MAX_INDICATOR_LINES);
    let values = cmif_at(set, &kept).ok()?;
    let count = values.first().map_or(0, Vec::len).min(MAX_SINGULAR_VALUES);
    let singular_values = |j: usize| {
        values
            .iter()
            .map(|value_row| rounded(value_row[j], 4))
            .collect()
    };
    Some(CmifCurve {
        hz: kept.iter().map(|k| rounded(axis.hz(*k), 7)).collect(),
        values: (0..count).map(singular_values).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::METHOD_WITH_ORDERS;
    use crate::identify::ESTIMATORS;

    #[test]
    fn the_method_of_the_poles_has_orders() {
        let has_order = |name| {
            ESTIMATORS
                .iter()
                .any(|option| option.name == name && option.has_order)
        };
        assert!(has_order(METHOD_WITH_ORDERS));
    }
}

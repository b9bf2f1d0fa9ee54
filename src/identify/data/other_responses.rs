//! Responses of other quantities than motion, such as sound pressure, have the poles of the motion.
//! Their FRFs are scaled to the size of the motion's, for no unit may weigh them in sums over FRFs.

use std::collections::BTreeMap;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::FrfSet;

/// What the FRFs of a set are to be multiplied by: 1 for motions; for a response of another
/// quantity the ratio of the root mean squares of the receptances in the band, of all motions to
/// that response, or to 1 m/N where there are none.
pub(in crate::identify) fn scales(set: &FrfSet, band: Band) -> Vec<f64> {
    let functions = set.functions();
    let mut of_motion = Vec::new();
    let mut by_response: BTreeMap<&Dof, Vec<f64>> = BTreeMap::new();
    for (i, function) in functions.iter().enumerate() {
        let power = mean_square(set, i, band);
        match function.kind.is_motion() {
            true => of_motion.push(power),
            false => by_response
                .entry(&function.response)
                .or_default()
                .push(power),
        }
    }
    let mean = |powers: &[f64]| powers.iter().sum::<f64>() / powers.len() as f64;
    let target = if of_motion.is_empty() {
        1.0
    } else {
        mean(&of_motion)
    };
    let scale = |response: &Dof| (target / mean(&by_response[response])).sqrt();
    functions
        .iter()
        .map(|function| match function.kind.is_motion() {
            true => 1.0,
            false => Some(scale(&function.response))
                .filter(|scale| scale.is_normal())
                .unwrap_or(1.0),
        })
        .collect()
}

/// Mean square of a function divided by the powers of iω of its kind, over the finite lines of a
/// band above 0 Hz.
fn mean_square(set: &FrfSet, i: usize, band: Band) -> f64 {
    let order = set.functions()[i].kind.derivative_order();
    let lines = set.axis().lines(&band);
    let values = lines.filter_map(|k| {
        let omega = set.axis().rad_s(k);
        let value = set.values(i)[k].norm_sqr() / omega.powi(2 * order);
        (omega > 0.0 && value.is_finite()).then_some(value)
    });
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::frf::{Function, FunctionData};
    use crate::quantity::FrfUnit;

    #[test]
    fn another_quantity_is_scaled_to_the_motion() {
        let axis = FrequencyAxis {
            start_hz: 1.0,
            step_hz: 1.0,
            len: 20,
        };
        let set = |units: &[(&str, f64)]| {
            let mut set = FrfSet::new(axis);
            for (point, (unit, size)) in (1..).zip(units) {
                let kind = FrfUnit::of_any_response(unit).unwrap().kind;
                let order = kind.derivative_order();
                let function = Function {
                    response: format!("{point}:+Z").parse().unwrap(),
                    reference: "1:+Z".parse().unwrap(),
                    kind,
                    averages: None,
                    estimator: None,
                    variance_dof: None,
                };
                let value = |k| Complex64::new(size * axis.rad_s(k).powi(order), 0.0);
                let data = FunctionData {
                    values: (0..axis.len).map(value).collect(),
                    ..FunctionData::default()
                };
                set.push(function, data).unwrap();
            }
            scales(&set, Band::new(1.0, 20.0).unwrap())
        };
        let near = |got: &[f64], expected: &[f64]| {
            let mut pairs = got.iter().zip(expected);
            assert!(pairs.all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{got:?}");
        };
        near(
            &set(&[("(m/s2)/N", 1e-6), ("Pa/N", 2.0), ("(rad/s2)/N", 1e-3)]),
            &[1.0, 5e-7, 1e-3],
        );
        near(&set(&[("(m/m)/N", 1e-3), ("Pa/N", 2.0)]), &[1e3, 0.5]);
        near(&set(&[("m/N", 1e-3), ("Pa/N", 0.0)]), &[1.0, 1.0]);
    }
}

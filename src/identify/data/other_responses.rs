//! Responses of other quantities than motion, such as sound pressure, have the poles of the motion.
//! Their FRFs are scaled to the size of the motion's, for no unit may weigh them in sums over FRFs.

use std::collections::BTreeMap;

use crate::axis::Band;
use crate::dof::Dof;
use crate::frf::{FrfSet, Function};

/// What the FRFs of a set are to be multiplied by: 1 for motions; for a response of another
/// quantity the ratio of the root mean squares in the band, as accelerances, of all motions to that
/// response, or to 1 m/(N s²) where there are none.
///
/// As receptances, the modes of a suspension would outweigh all others.
pub(in crate::identify) fn scales(set: &FrfSet, band: Band) -> Vec<f64> {
    let functions = set.functions();
    if functions.iter().all(|function| function.kind.is_motion()) {
        return vec![1.0; functions.len()];
    }
    let mut of_motion = Mean::default();
    let mut of_responses: BTreeMap<&Dof, Mean> = BTreeMap::new();
    for (i, function) in functions.iter().enumerate() {
        let mean = match function.kind.is_motion() {
            true => &mut of_motion,
            false => of_responses.entry(&function.response).or_default(),
        };
        mean.add(mean_square(set, i, band));
    }
    let target = if of_motion.count > 0.0 {
        of_motion.value()
    } else {
        1.0
    };
    let scale = |function: &Function| match function.kind.is_motion() {
        true => 1.0,
        false => Some((target / of_responses[&function.response].value()).sqrt())
            .filter(|scale| scale.is_normal())
            .unwrap_or(1.0),
    };
    functions.iter().map(scale).collect()
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn value(&self) -> f64 {
        self.sum / self.count
    }
}

/// Mean square of a function as an accelerance, over the finite lines of a band.
fn mean_square(set: &FrfSet, i: usize, band: Band) -> f64 {
    let order = set.functions()[i].kind.derivative_order();
    let mut mean = Mean::default();
    for k in set.axis().lines(&band) {
        let value = set.values(i)[k].norm_sqr() * set.axis().rad_s(k).powi(2 * (2 - order));
        if value.is_finite() {
            mean.add(value);
        }
    }
    mean.value()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::frf::FunctionData;
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
        // Without motions to 1 m/(N s²): both are constant as receptances.
        let mean = (0..axis.len).map(|k| axis.rad_s(k).powi(4)).sum::<f64>() / axis.len as f64;
        let rms = mean.sqrt();
        near(
            &set(&[("(m/m)/N", 1e-3), ("Pa/N", 2.0)]),
            &[1e3 / rms, 0.5 / rms],
        );
        near(&set(&[("m/N", 1e-3), ("Pa/N", 0.0)]), &[1.0, 1.0]);
    }

    #[test]
    fn modes_of_a_suspension_do_not_set_the_scale() {
        let axis = FrequencyAxis {
            start_hz: 1.0,
            step_hz: 1.0,
            len: 200,
        };
        let mut set = FrfSet::new(axis);
        // A microphone does not hear the suspension at the first line.
        for (response, unit, first, size) in
            [("1:+Z", "(m/s2)/N", 1.0, 1.0), ("9:+S", "Pa/N", 0.0, 2.0)]
        {
            let function = Function {
                response: response.parse().unwrap(),
                reference: "1:+Z".parse().unwrap(),
                kind: FrfUnit::of_any_response(unit).unwrap().kind,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let value = |k| Complex64::from(if k == 0 { first } else { size });
            let data = FunctionData {
                values: (0..axis.len).map(value).collect(),
                ..FunctionData::default()
            };
            set.push(function, data).unwrap();
        }
        let scale = scales(&set, Band::new(1.0, 200.0).unwrap())[1];
        assert!((scale - 0.5).abs() < 0.01, "{scale}");
    }
}

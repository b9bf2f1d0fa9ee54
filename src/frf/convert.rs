//! An FRF is converted between receptance, mobility and accelerance, away from 0 Hz.

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::quantity::FrfKind;

use super::{FrfSet, FunctionData};

/// The set with every function as `kind`: values times `s^d`, variance times `|s|^(2d)`, `s = iω +
/// a`.
///
/// `d` is the difference of the kinds' derivative orders and `a` the added damping of the set, so
/// that functions with an exponential window convert exactly. Coherence is that of the measured
/// pair and stays. Integration needs `s ≠ 0`: where a function is integrated and the first line is
/// at 0 Hz without added damping, the value there is not in the data, and the new set begins at the
/// first line above. The input is not changed.
/// Functions of other quantities than motion stay as they are.
///
/// ```
/// use modalign::axis::FrequencyAxis;
/// use modalign::frf::{FrfSet, convert};
/// use modalign::quantity::FrfKind;
/// let set = FrfSet::new(FrequencyAxis { start_hz: 0.0, step_hz: 0.5, len: 100 });
/// assert_eq!(convert(&set, FrfKind::Receptance).axis().len, 100);
/// ```
pub fn convert(set: &FrfSet, kind: FrfKind) -> FrfSet {
    let difference = |from: FrfKind| match from.is_motion() {
        true => kind.derivative_order() - from.derivative_order(),
        false => 0,
    };
    let integrates = set.functions().iter().any(|f| difference(f.kind) < 0);
    let first = usize::from(integrates && laplace(set, 0).norm() <= 0.0);
    let mut out = FrfSet::new(axis_from_line(set.axis(), first));
    out.added_damping_rad_s = set.added_damping_rad_s;
    out.window = set.window;
    out.mixed_windows.clone_from(&set.mixed_windows);
    out.is_interpolated = set.is_interpolated;
    out.record_duration_s = set.record_duration_s;
    out.valid_band = set.valid_band;
    out.excited_band = set.excited_band;
    out.multiple_coherence = set
        .multiple_coherence
        .iter()
        .map(|(dof, values)| (dof.clone(), values[first..].to_vec()))
        .collect();
    out.findings.clone_from(&set.findings);
    let lines = first..set.axis().len;
    for (i, function) in set.functions().iter().enumerate() {
        let d = difference(function.kind);
        let values = lines
            .clone()
            .map(|k| set.values(i)[k] * laplace(set, k).powi(d));
        let variance = set.variance(i).map(|variance| {
            let lines = lines.clone();
            lines
                .map(|k| variance[k] * laplace(set, k).norm_sqr().powi(d))
                .collect()
        });
        let data = FunctionData {
            values: values.collect(),
            coherence: set.coherence(i).map(|c| c[lines.clone()].to_vec()),
            variance,
        };
        let mut function = function.clone();
        if function.kind.is_motion() {
            function.kind = kind;
        }
        out.push(function, data)
            .expect("lengths and pairs are those of the set it came from");
    }
    out
}

/// `s = iω + a` of line `k`.
fn laplace(set: &FrfSet, k: usize) -> Complex64 {
    Complex64::new(set.added_damping_rad_s, set.axis().rad_s(k))
}

fn axis_from_line(axis: &FrequencyAxis, first: usize) -> FrequencyAxis {
    FrequencyAxis {
        start_hz: axis.hz(first),
        step_hz: axis.step_hz,
        len: axis.len - first,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::Function;
    use std::f64::consts::TAU;

    fn set(start_hz: f64, added_damping_rad_s: f64, kinds: &[FrfKind]) -> FrfSet {
        let mut set = FrfSet::new(FrequencyAxis {
            start_hz,
            step_hz: 2.0,
            len: 4,
        });
        set.added_damping_rad_s = added_damping_rad_s;
        set.record_duration_s = Some(0.5);
        for (n, kind) in kinds.iter().enumerate() {
            let function = Function {
                response: format!("{}:+Z", n + 1).parse().unwrap(),
                reference: "1:+Z".parse().unwrap(),
                kind: *kind,
                averages: Some(3),
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values: (0..4).map(|k| Complex64::new(f64::from(k), 1.0)).collect(),
                coherence: Some(vec![0.1, 0.2, 0.3, 0.4]),
                variance: Some(vec![1.0, 2.0, 3.0, 4.0]),
            };
            set.push(function, data).unwrap();
        }
        set
    }

    #[test]
    fn receptance_to_accelerance_is_minus_omega_squared() {
        let set = set(0.0, 0.0, &[FrfKind::Receptance]);
        let out = convert(&set, FrfKind::Accelerance);
        assert_eq!(out.axis(), set.axis());
        assert_eq!(out.functions()[0].kind, FrfKind::Accelerance);
        assert_eq!(set.functions()[0].kind, FrfKind::Receptance);
        for k in 0..4 {
            let omega = TAU * 2.0 * k as f64;
            let expected = -omega * omega * set.values(0)[k];
            assert!((out.values(0)[k] - expected).norm() <= 1e-14 * expected.norm());
            let variance = omega.powi(4) * set.variance(0).unwrap()[k];
            assert!((out.variance(0).unwrap()[k] - variance).abs() <= 1e-14 * variance);
        }
        assert_eq!(out.coherence(0), set.coherence(0));
        assert_eq!(out.record_duration_s, Some(0.5));
    }

    #[test]
    fn mobility_to_receptance_turns_the_phase_back_and_leaves_out_zero_hz() {
        let set = set(0.0, 0.0, &[FrfKind::Mobility, FrfKind::Receptance]);
        let out = convert(&set, FrfKind::Receptance);
        assert_eq!((out.axis().len, out.axis().hz(0)), (3, 2.0));
        let expected = Complex64::new(1.0, -1.0) / (TAU * 2.0);
        assert!((out.values(0)[0] - expected).norm() < 1e-16);
        assert_eq!(out.values(1), &set.values(1)[1..]);
        assert_eq!(out.coherence(0).unwrap(), &[0.2, 0.3, 0.4]);
        let variance = out.variance(0).unwrap();
        assert!((variance[0] - 2.0 / (TAU * 2.0).powi(2)).abs() < 1e-16);
    }

    #[test]
    fn added_damping_belongs_to_s_and_keeps_zero_hz() {
        let set = set(0.0, 5.0, &[FrfKind::Accelerance]);
        let out = convert(&set, FrfKind::Receptance);
        assert_eq!(out.axis().len, 4);
        assert!((out.added_damping_rad_s - 5.0).abs() < 1e-15);
        assert!((out.values(0)[0] - Complex64::new(0.0, 0.04)).norm() < 1e-16);
        let s = Complex64::new(5.0, TAU * 6.0);
        assert!((out.values(0)[3] - Complex64::new(3.0, 1.0) / (s * s)).norm() < 1e-16);
    }

    #[test]
    fn there_and_back_is_the_same() {
        let all = [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance];
        for (start, damping) in [(3.0, 0.0), (0.0, 0.7)] {
            for from in all {
                for to in all {
                    let set = set(start, damping, &[from]);
                    let back = convert(&convert(&set, to), from);
                    assert_eq!(back.functions(), set.functions());
                    for k in 0..4 {
                        let (a, b) = (back.values(0)[k], set.values(0)[k]);
                        assert!((a - b).norm() < 1e-14 * b.norm());
                    }
                }
            }
        }
    }
}

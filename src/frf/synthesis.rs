//! FRFs from poles and residues.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::axis::FrequencyAxis;
use crate::dof::Dof;
use crate::modal::{ModalModel, Pole};
use crate::quantity::FrfKind;

use super::{FrfError, FrfSet, Function, FunctionData};

/// Receptance residues of one mode by (response, reference), m/(N s).
pub type Residues = BTreeMap<(Dof, Dof), Complex64>;

/// Poles and residues of a modal model, as [`synthesise`] takes them.
///
/// # Errors
/// [`FrfError::DampingUnknown`] for a mode without a damping ratio, which has no pole.
pub fn modal_terms(model: &ModalModel) -> Result<Vec<(Pole, &Residues)>, FrfError> {
    let term = |mode: &'_ crate::modal::Mode| {
        mode.pole().ok_or(FrfError::DampingUnknown {
            frequency_hz: mode.frequency_hz,
        })
    };
    model
        .modes
        .iter()
        .map(|mode| Ok((term(mode)?, &mode.residues)))
        .collect()
}

/// `H(s) = s^d Σ [A / (s - λ) + A* / (s - λ*)]` at `s = iω + a` of every line, for every (response,
/// reference) pair.
///
/// `A` is a residue of the receptance, `d` 0, 1, 2 for receptance, mobility, accelerance, λ a pole
/// without the added damping `a` (`added_damping_rad_s`, that of an exponential window; 0 without
/// one). Degrees of freedom are matched with their signs. The set has neither coherence nor
/// variance, and no residuals of modes outside.
///
/// # Errors
/// [`FrfError::Axis`] and [`FrfError::AddedDamping`] for numbers out of range;
/// [`FrfError::ResidueMissing`] when a mode has no residue of a pair (absent is not 0);
/// [`FrfError::PoleOnLine`] where H is infinite; [`FrfError::Set`] for a pair that is asked for
/// twice.
pub fn synthesise(
    modes: &[(Pole, &Residues)],
    axis: FrequencyAxis,
    pairs: &[(Dof, Dof)],
    kind: FrfKind,
    added_damping_rad_s: f64,
) -> Result<FrfSet, FrfError> {
    check(modes, &axis, added_damping_rad_s)?;
    let mut set = FrfSet::new(axis);
    set.added_damping_rad_s = added_damping_rad_s;
    for pair in pairs {
        let terms = terms(modes, pair)?;
        let value = |k: usize| {
            let s = Complex64::new(added_damping_rad_s, axis.rad_s(k));
            let term = |(lambda, a): &(Complex64, Complex64)| {
                a / (s - lambda) + a.conj() / (s - lambda.conj())
            };
            terms.iter().map(term).sum::<Complex64>() * s.powi(kind.derivative_order())
        };
        let function = Function {
            response: pair.0.clone(),
            reference: pair.1.clone(),
            kind,
            averages: None,
            estimator: None,
            variance_dof: None,
        };
        let data = FunctionData {
            values: (0..axis.len).map(value).collect(),
            ..FunctionData::default()
        };
        set.push(function, data)?;
    }
    Ok(set)
}

/// λ and residue of every mode for one pair.
fn terms(
    modes: &[(Pole, &Residues)],
    pair: &(Dof, Dof),
) -> Result<Vec<(Complex64, Complex64)>, FrfError> {
    let term = |(pole, residues): &(Pole, &Residues)| match residues.get(pair) {
        Some(residue) => Ok((pole.lambda, *residue)),
        None => Err(FrfError::ResidueMissing {
            frequency_hz: pole.natural_frequency_hz(),
            response: pair.0.clone(),
            reference: pair.1.clone(),
        }),
    };
    modes.iter().map(term).collect()
}

fn check(
    modes: &[(Pole, &Residues)],
    axis: &FrequencyAxis,
    added_damping_rad_s: f64,
) -> Result<(), FrfError> {
    let start = axis.start_hz >= 0.0 && axis.start_hz.is_finite();
    let step = axis.step_hz > 0.0 && axis.step_hz.is_finite();
    if !(start && step) {
        return Err(FrfError::Axis {
            start_hz: axis.start_hz,
            step_hz: axis.step_hz,
            len: axis.len,
        });
    }
    if !(added_damping_rad_s >= 0.0 && added_damping_rad_s.is_finite()) {
        return Err(FrfError::AddedDamping {
            got_rad_s: added_damping_rad_s,
        });
    }
    for (pole, _) in modes {
        let line = axis.nearest(pole.damped_frequency_hz().abs());
        let on_line = line.filter(|k| {
            let s = Complex64::new(added_damping_rad_s, axis.rad_s(*k));
            let distance = (s - pole.lambda)
                .norm()
                .min((s - pole.lambda.conj()).norm());
            distance <= 1e-12 * s.norm()
        });
        if let Some(k) = on_line {
            return Err(FrfError::PoleOnLine {
                pole_hz: pole.natural_frequency_hz(),
                line_hz: axis.hz(k),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::convert;
    use crate::modal::{Mode, ModeShape, Scaling};
    use std::f64::consts::TAU;

    fn dof(text: &str) -> Dof {
        text.parse().unwrap()
    }

    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 0.0,
        step_hz: 0.5,
        len: 81,
    };

    /// m = 2 kg at 10 Hz with 3 % damping: receptance `1 / (k - m ω² + i c ω)`, residue `1 / (2 i m
    /// ω_d)`.
    fn one_mass() -> (f64, f64, f64, Pole, Residues) {
        let (m, omega, zeta) = (2.0, TAU * 10.0, 0.03);
        let pole = Pole::from_frequency(10.0, zeta);
        let residue = 1.0 / (2.0 * Complex64::I * m * pole.lambda.im);
        let residues = BTreeMap::from([((dof("1:+Z"), dof("2:-X")), residue)]);
        (m, m * omega * omega, 2.0 * zeta * m * omega, pole, residues)
    }

    #[test]
    fn one_mass_has_its_textbook_functions() {
        let (m, k, c, pole, residues) = one_mass();
        let pair = [(dof("1:+Z"), dof("2:-X"))];
        for added in [0.0, 4.0] {
            for (kind, d) in [
                (FrfKind::Receptance, 0),
                (FrfKind::Mobility, 1),
                (FrfKind::Accelerance, 2),
            ] {
                let set = synthesise(&[(pole, &residues)], AXIS, &pair, kind, added).unwrap();
                assert!((set.added_damping_rad_s - added).abs() < 1e-15);
                for line in 0..AXIS.len {
                    let s = Complex64::new(added, AXIS.rad_s(line));
                    let expected = s.powi(d) / (m * s * s + c * s + k);
                    let got = set.values(0)[line];
                    assert!((got - expected).norm() <= 1e-13 * expected.norm());
                }
                let receptance = convert(&set, FrfKind::Receptance);
                assert_eq!(receptance.functions()[0].kind, FrfKind::Receptance);
            }
        }
    }

    #[test]
    fn missing_or_infinite_modal_parameters_are_errors() {
        let (_, _, _, pole, residues) = one_mass();
        let run = |modes: &[(Pole, &Residues)], axis, pair: &str, added| {
            let pair = [(dof(pair), dof("2:-X"))];
            synthesise(modes, axis, &pair, FrfKind::Mobility, added).unwrap_err()
        };
        let modes = [(pole, &residues)];
        assert!(matches!(
            run(&modes, AXIS, "1:-Z", 0.0),
            FrfError::ResidueMissing { .. }
        ));
        assert!(matches!(
            run(&modes, AXIS, "1:+Z", -1.0),
            FrfError::AddedDamping { .. }
        ));
        let flat = FrequencyAxis {
            step_hz: 0.0,
            ..AXIS
        };
        assert!(matches!(
            run(&modes, flat, "1:+Z", 0.0),
            FrfError::Axis { .. }
        ));
        let undamped = [(Pole::from_frequency(10.0, 0.0), &residues)];
        assert!(matches!(
            run(&undamped, AXIS, "1:+Z", 0.0),
            FrfError::PoleOnLine { .. }
        ));
    }

    #[test]
    fn a_model_gives_its_terms_unless_a_damping_is_unknown() {
        let (_, _, _, pole, residues) = one_mass();
        let shape = ModeShape::default();
        let mut mode = Mode::new(10.0, Some(0.03), shape, Scaling::Unknown);
        mode.residues = residues.clone();
        let mut model = ModalModel {
            modes: vec![mode],
            ..ModalModel::default()
        };
        assert_eq!(modal_terms(&model).unwrap(), vec![(pole, &residues)]);
        model.modes[0].damping_ratio = None;
        assert!(matches!(
            modal_terms(&model),
            Err(FrfError::DampingUnknown { .. })
        ));
    }
}

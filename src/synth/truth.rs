//! The truth of a synthetic test holds the modes with their residues, and the rigid-body response
//! of a free structure.

use std::collections::BTreeMap;
use std::ops::Mul;

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, Scaling};
use crate::quantity::FrfKind;

use super::SynthError;

/// A structure whose response to a hit is known exactly.
///
/// Receptance `H(s) = sum_r A_r/(s - lambda_r) + conj. + D/s^2` at each (response, hit) pair;
/// `lambda_r` comes from the mode's natural frequency and damping ratio, `A_r` from its residues, D
/// from `rigid_accelerance`.
///
/// A pair is looked up as it stands, and otherwise by point and axis alone: the value is then
/// multiplied by the signs of all four degrees of freedom, and repeats (`#2`) share the value of
/// the first measurement. So the hit `1:-Z` pushes against z and the sensor `2:-Z` reads the
/// negative of `2:+Z`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Truth {
    /// Elastic modes with frequency, damping and residues; shapes are carried along for the
    /// comparison.
    pub model: ModalModel,
    /// `D = sum_j phi_j(response) phi_j(hit) / m_j` over the rigid-body modes, 1/kg, by (response,
    /// hit). Empty for a held structure.
    pub rigid_accelerance: BTreeMap<(Dof, Dof), f64>,
}

impl Truth {
    /// The truth of a model with real shapes and modal (proportional) damping, at all pairs of the
    /// given responses and hits.
    ///
    /// `A = phi(response) phi(hit) / (2 i m omega_d)`, `omega_d` the damped frequency, m the modal
    /// mass for the shape as scaled. Modes at 0 Hz become the rigid-body term and leave the model.
    ///
    /// # Errors
    /// [`SynthError::Mode`] for an elastic mode without damping, a mode without modal mass, or a
    /// complex shape; [`SynthError::MissingShape`] for a degree of freedom that a shape does not
    /// have.
    ///
    /// # Reference
    /// Ewins (2000), Modal Testing, 2nd ed., section 2.4 (proportional damping).
    pub fn from_real_shapes(
        model: &ModalModel,
        responses: &[Dof],
        hits: &[Dof],
    ) -> Result<Self, SynthError> {
        let mut truth = Truth {
            model: ModalModel {
                modes: Vec::new(),
                ..model.clone()
            },
            rigid_accelerance: BTreeMap::new(),
        };
        for (i, mode) in model.modes.iter().enumerate() {
            let mass = modal_mass_kg(mode, i + 1)?;
            let mut products = BTreeMap::new();
            for response in responses {
                for hit in hits {
                    let product =
                        real_component(mode, i + 1, response)? * real_component(mode, i + 1, hit)?;
                    products.insert((response.clone(), hit.clone()), product / mass);
                }
            }
            truth.add_mode(mode, i + 1, products)?;
        }
        Ok(truth)
    }

    fn add_mode(
        &mut self,
        mode: &Mode,
        number: usize,
        products: BTreeMap<(Dof, Dof), f64>,
    ) -> Result<(), SynthError> {
        if mode.frequency_hz <= 0.0 {
            for (pair, product) in products {
                *self.rigid_accelerance.entry(pair).or_default() += product;
            }
            return Ok(());
        }
        let omega_d = checked_pole(mode, number)?.im;
        let divide =
            |(pair, product): (_, f64)| (pair, Complex64::new(0.0, -product / (2.0 * omega_d)));
        self.model.modes.push(Mode {
            residues: products.into_iter().map(divide).collect(),
            ..mode.clone()
        });
        Ok(())
    }

    /// The true FRF of a pair at the complex frequency s, rad/s (`s = i omega` on the frequency
    /// axis).
    ///
    /// # Errors
    /// [`SynthError::Mode`], [`SynthError::MissingResidue`], [`SynthError::MissingRigidBody`] when
    /// the truth does not hold the pair.
    pub fn transfer(
        &self,
        response: &Dof,
        hit: &Dof,
        kind: FrfKind,
        s: Complex64,
    ) -> Result<Complex64, SynthError> {
        Ok(self.pair(response, hit)?.transfer(s, kind))
    }

    /// Poles, residues and rigid-body term of one pair.
    pub(super) fn pair(&self, response: &Dof, hit: &Dof) -> Result<TrueFrf, SynthError> {
        let mut modes = Vec::with_capacity(self.model.modes.len());
        for (i, mode) in self.model.modes.iter().enumerate() {
            let pole = checked_pole(mode, i + 1)?;
            let residue = value_at_pair(&mode.residues, response, hit).ok_or_else(|| {
                SynthError::MissingResidue {
                    mode: i + 1,
                    frequency_hz: mode.frequency_hz,
                    response: response.clone(),
                    hit: hit.clone(),
                }
            })?;
            if !residue.is_finite() {
                return Err(mode_error(
                    i + 1,
                    "residue",
                    Some(residue.norm()),
                    "a finite number",
                    "m/(N s)",
                ));
            }
            modes.push((pole, residue));
        }
        Ok(TrueFrf {
            modes,
            rigid_per_kg: self.rigid(response, hit)?,
        })
    }

    fn rigid(&self, response: &Dof, hit: &Dof) -> Result<f64, SynthError> {
        if self.rigid_accelerance.is_empty() {
            return Ok(0.0);
        }
        let value = value_at_pair(&self.rigid_accelerance, response, hit).ok_or_else(|| {
            SynthError::MissingRigidBody {
                response: response.clone(),
                hit: hit.clone(),
            }
        })?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(SynthError::OutOfRange {
            name: "rigid-body accelerance",
            got: value,
            expected: "a finite number",
            unit: "1/kg",
        })
    }
}

/// The true FRF of one (response, hit) pair.
#[derive(Clone, Debug)]
pub(super) struct TrueFrf {
    /// (lambda, A) of every mode.
    pub modes: Vec<(Complex64, Complex64)>,
    /// D.
    pub rigid_per_kg: f64,
}

impl TrueFrf {
    /// `s^m sum A/(s - lambda) + conj. + s^(m-2) D`.
    pub fn transfer(&self, s: Complex64, kind: FrfKind) -> Complex64 {
        let order = kind.derivative_order();
        let term = |&(pole, residue): &(Complex64, Complex64)| {
            residue / (s - pole) + residue.conj() / (s - pole.conj())
        };
        let elastic: Complex64 = self.modes.iter().map(term).sum();
        let mut value = elastic * s.powi(order);
        if self.rigid_per_kg != 0.0 {
            value += self.rigid_per_kg * s.powi(order - 2);
        }
        value
    }
}

fn mode_error(
    mode: usize,
    name: &'static str,
    got: Option<f64>,
    expected: &'static str,
    unit: &'static str,
) -> SynthError {
    SynthError::Mode {
        mode,
        name,
        got,
        expected,
        unit,
    }
}

/// The pole of a mode that rings and decays.
pub(super) fn checked_pole(mode: &Mode, number: usize) -> Result<Complex64, SynthError> {
    let hz = mode.frequency_hz;
    if !(hz > 0.0 && hz.is_finite()) {
        let expected = "above 0 (rigid-body modes go into the rigid-body accelerance)";
        return Err(mode_error(number, "frequency", Some(hz), expected, "Hz"));
    }
    match mode.damping_ratio.filter(|zeta| *zeta > 0.0 && *zeta < 1.0) {
        Some(zeta) => Ok(crate::modal::Pole::from_frequency(hz, zeta).lambda),
        None => Err(mode_error(
            number,
            "damping ratio",
            mode.damping_ratio,
            "above 0 and below 1",
            "",
        )),
    }
}

fn modal_mass_kg(mode: &Mode, number: usize) -> Result<f64, SynthError> {
    let unit_mass = (mode.scaling == Scaling::UnitModalMass).then_some(1.0);
    let mass = mode.modal_mass_kg.or(unit_mass);
    mass.filter(|m| *m > 0.0 && m.is_finite())
        .ok_or_else(|| mode_error(number, "modal mass", mass, "above 0", "kg"))
}

/// The real shape component that a sensor at `dof` reads.
fn real_component(mode: &Mode, number: usize, dof: &Dof) -> Result<f64, SynthError> {
    let value = mode
        .shape
        .along_positive(&dof.with_repeat(1))
        .ok_or_else(|| SynthError::MissingShape {
            mode: number,
            dof: dof.clone(),
        })?;
    let largest = mode.shape.largest().map_or(0.0, |(_, v)| v.norm());
    if value.im.abs() > 1e-9 * largest {
        let name = "imaginary part of the shape";
        return Err(mode_error(
            number,
            name,
            Some(value.im),
            "0 (a real shape)",
            "",
        ));
    }
    Ok(value.re * dof.sign())
}

/// The value of a pair: exactly, or by point and axis with the product of the signs.
fn value_at_pair<V: Copy + Mul<f64, Output = V>>(
    values: &BTreeMap<(Dof, Dof), V>,
    response: &Dof,
    hit: &Dof,
) -> Option<V> {
    if let Some(value) = values.get(&(response.clone(), hit.clone())) {
        return Some(*value);
    }
    let place = |dof: &Dof| dof.positive().with_repeat(1);
    let wanted = (place(response), place(hit));
    let ((r, h), value) = values
        .iter()
        .find(|((r, h), _)| place(r) == wanted.0 && place(h) == wanted.1)?;
    Some(*value * (r.sign() * h.sign() * response.sign() * hit.sign()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::ModeShape;
    use std::f64::consts::TAU;

    fn dof(text: &str) -> Dof {
        text.parse().unwrap()
    }

    fn mode(hz: f64, zeta: Option<f64>, shape: &[(&str, f64)]) -> Mode {
        let shape = ModeShape::new(shape.iter().map(|(d, v)| (dof(d), Complex64::from(*v))));
        Mode::new(hz, zeta, shape, Scaling::UnitModalMass)
    }

    /// Two masses of 2 kg and 2 kg, free, tied by a spring of 4e4 N/m and a damper of 8 N s/m.
    fn free_pair() -> ModalModel {
        let half = 0.5;
        let omega = (2.0 * 4e4 / 2.0f64).sqrt();
        ModalModel {
            modes: vec![
                mode(0.0, None, &[("1:+X", half), ("2:+X", half)]),
                mode(
                    omega / TAU,
                    Some(8.0 / (2.0 * omega)),
                    &[("1:+X", half), ("2:-X", half)],
                ),
            ],
            ..ModalModel::default()
        }
    }

    #[test]
    fn real_shapes_give_the_transfer_function_of_the_mechanical_system() {
        let pair = [dof("1:+X"), dof("2:+X")];
        let truth = Truth::from_real_shapes(&free_pair(), &pair, &pair).unwrap();
        assert_eq!(truth.model.modes.len(), 1);
        let s = Complex64::new(0.0, 130.0);
        // (2 s^2 + c s + k) x1 - (c s + k) x2 = f at mass 1, and the same mirrored.
        let (tie, mass) = (8.0 * s + 4e4, 2.0 * s * s);
        let determinant = (mass + tie) * (mass + tie) - tie * tie;
        for (response, receptance) in [
            ("1:+X", (mass + tie) / determinant),
            ("2:+X", tie / determinant),
            ("2:-X", -tie / determinant),
        ] {
            for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
                let expected = receptance * s.powi(kind.derivative_order());
                let got = truth
                    .transfer(&dof(response), &dof("1:+X"), kind, s)
                    .unwrap();
                assert!(
                    (got - expected).norm() < 1e-12 * expected.norm(),
                    "{response} {kind}"
                );
            }
        }
    }

    #[test]
    fn an_exact_pair_wins_and_signs_multiply_otherwise() {
        let values: BTreeMap<(Dof, Dof), f64> = [
            ((dof("1:-Z"), dof("2:+Z")), 3.0),
            ((dof("3:+Z"), dof("2:+Z")), 5.0),
            ((dof("3:-Z"), dof("2:+Z")), -7.0),
        ]
        .into();
        let at = |r: &str, h: &str| value_at_pair(&values, &dof(r), &dof(h));
        assert_eq!(at("1:-Z", "2:+Z"), Some(3.0));
        assert_eq!(at("1:+Z", "2:+Z"), Some(-3.0));
        assert_eq!(at("1:+Z#2", "2:-Z"), Some(3.0));
        assert_eq!(at("1:-Z", "2:-Z"), Some(-3.0));
        assert_eq!(at("3:-Z", "2:+Z"), Some(-7.0));
        assert_eq!(at("3:+X", "2:+Z"), None);
    }

    #[test]
    fn missing_parts_of_a_truth_are_named() {
        let pair = [dof("1:+X"), dof("2:+X")];
        let failing = |change: fn(&mut Mode)| {
            let mut model = free_pair();
            change(&mut model.modes[1]);
            Truth::from_real_shapes(&model, &pair, &pair).unwrap_err()
        };
        let name = |error: SynthError| match error {
            SynthError::Mode { mode: 2, name, .. } => name,
            other => panic!("{other}"),
        };
        assert_eq!(name(failing(|m| m.damping_ratio = None)), "damping ratio");
        assert_eq!(
            name(failing(|m| m.damping_ratio = Some(1.0))),
            "damping ratio"
        );
        assert_eq!(
            name(failing(|m| m.scaling = Scaling::UnitMax)),
            "modal mass"
        );
        assert_eq!(
            name(failing(|m| m.shape = m.shape.scaled(Complex64::I))),
            "imaginary part of the shape"
        );
        let other = [dof("3:+X")];
        let error = Truth::from_real_shapes(&free_pair(), &other, &pair).unwrap_err();
        assert_eq!(
            error,
            SynthError::MissingShape {
                mode: 1,
                dof: dof("3:+X")
            }
        );
    }
}

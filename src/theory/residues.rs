//! Residues of a model with given damping, for each pair of response and excitation DOF.
//!
//! Functions are not evaluated here; the parts are in the forms that `frf` and `synth` evaluate.

use num_complex::Complex64;

use crate::dof::Dof;
use crate::modal::Pole;

use super::eigen::check_damping_ratio;
use super::{TheoryError, TheoryModes};

/// The parts of the function between one response and one hit.
///
/// Receptance `H(s) = sum A/(s - lambda) + conj(A)/(s - conj(lambda)) + R/s^2`, accelerance `s^2
/// H`.
#[derive(Clone, Debug, PartialEq)]
pub struct PairResidues {
    /// Response degree of freedom, with its sign.
    pub response: Dof,
    /// Hit degree of freedom, with its sign.
    pub hit: Dof,
    /// Pole and residue (m/(N s)) of each elastic mode, in the order of the modes.
    pub elastic: Vec<(Pole, Complex64)>,
    /// Accelerance constant R of the rigid-body modes, the sum of `phi_j phi_k`, 1/kg; 0 for a
    /// model that is held.
    pub rigid_body_accelerance_per_kg: f64,
}

/// Residues `A_jk = phi_j phi_k / (2 i omega_d)` with `omega_d = omega_n sqrt(1 - zeta^2)`, shapes
/// of unit modal mass.
///
/// `damping_ratios` has one value for each elastic mode in `modes`, in order. Degrees of freedom
/// must be among the sensors at which the modes were computed; one whose sign is negative reads (or
/// hits) with a minus. A pair with both ends at motions without mass has a constant static
/// compliance besides ([`Condensation::relax`](super::Condensation::relax)).
///
/// # Errors
/// [`TheoryError::DampingCount`], [`TheoryError::DampingRatio`], [`TheoryError::NotObserved`].
///
/// # Reference
/// Ewins (2000), Modal Testing: Theory, Practice and Application, 2nd ed., section 2.4
/// (proportional damping).
pub fn residues(
    modes: &TheoryModes,
    damping_ratios: &[f64],
    pairs: &[(Dof, Dof)],
) -> Result<Vec<PairResidues>, TheoryError> {
    let elastic = modes.omega_rad_s.len() - modes.rigid;
    if damping_ratios.len() != elastic {
        return Err(TheoryError::DampingCount {
            got: damping_ratios.len(),
            expected: elastic,
        });
    }
    damping_ratios
        .iter()
        .try_for_each(|&ratio| check_damping_ratio(ratio))?;
    pairs
        .iter()
        .map(|(response, hit)| {
            let (at_response, at_hit) = (readings(modes, response)?, readings(modes, hit)?);
            let products: Vec<f64> = at_response.iter().zip(at_hit).map(|(a, b)| a * b).collect();
            let (rigid, elastic) = products.split_at(modes.rigid);
            let frequencies = &modes.model.modes[modes.rigid..];
            let parts = elastic.iter().zip(frequencies).zip(damping_ratios);
            Ok(PairResidues {
                response: response.clone(),
                hit: hit.clone(),
                elastic: parts
                    .map(|((&product, mode), &ratio)| {
                        let pole = Pole::from_frequency(mode.frequency_hz, ratio);
                        (pole, product / (2.0 * Complex64::I * pole.lambda.im))
                    })
                    .collect(),
                rigid_body_accelerance_per_kg: rigid.iter().sum(),
            })
        })
        .collect()
}

/// Component of each mode at a sensor, with its sign.
fn readings(modes: &TheoryModes, dof: &Dof) -> Result<Vec<f64>, TheoryError> {
    let of_mode = |mode: &crate::modal::Mode| {
        let value = mode.shape.along_positive(dof);
        value
            .map(|v| v.re * dof.sign())
            .ok_or_else(|| TheoryError::NotObserved {
                got: dof.clone(),
                known: mode
                    .shape
                    .iter()
                    .map(|(sensor, _)| sensor.to_string())
                    .collect(),
            })
    };
    modes.model.modes.iter().map(of_mode).collect()
}

//! Sensitivities and modal energies that the paper on the torsional planetary gear states, compared
//! with the matrices.
//!
//! # Reference
//! Wang et al. (2005), equations 13 (derivatives of an eigenvalue), 14 and 19 (kinetic and strain
//! energy of a mode by them) and the rates of the mesh energies after equation 19.

use crate::theory::parameter::index_of;
use crate::theory::quantity::allowed_or;
use crate::theory::{
    ModeOptions, ModelQuantity, ModelRoot, RootSensitivity, TheoreticalModel, TheoryError,
    TheoryModes, TorsionalPlanetary, model_roots, modes, sensitivities, system_derivatives,
};

/// Parameters that equation 13 is printed for, and the supports, for which equation 19 gives it a
/// meaning.
const STIFFNESSES: [&str; 5] = ["k_r", "k_s", "k_cu", "k_ru", "k_su"];
const MASSES: [(&str, &str); 4] = [
    ("m_c", "carrier"),
    ("m_r", "ring"),
    ("m_s", "sun"),
    ("m_p", "planet-"),
];
/// Step of the differences as a part of the value: their error is of its fourth power, their
/// rounding 1e-16 over it.
const STEP: f64 = 1e-3;

/// Modes, roots and sensitivities at some values.
struct State<'a> {
    model: &'a TorsionalPlanetary,
    values: Vec<f64>,
    modes: TheoryModes,
    roots: Vec<ModelRoot>,
    sensitivities: Vec<RootSensitivity>,
}

impl<'a> State<'a> {
    fn new(model: &'a TorsionalPlanetary, values: &[f64]) -> Result<Self, TheoryError> {
        let modes = modes(model, values, &[], &ModeOptions::default())?;
        let roots = model_roots(model, &modes);
        let derivatives = system_derivatives(model, values)?;
        Ok(Self {
            sensitivities: sensitivities(&modes, &roots, &derivatives)?,
            model,
            values: values.to_vec(),
            modes,
            roots,
        })
    }

    fn index(&self, name: &str) -> Result<usize, TheoryError> {
        index_of(self.model.name(), self.model.parameters(), name)
    }

    /// The same with one value changed.
    fn with(&self, j: usize, value: f64) -> Result<Self, TheoryError> {
        let mut values = self.values.clone();
        values[j] = value;
        Self::new(self.model, &values)
    }

    /// Numbers of the roots above 0.
    fn elastic(&self) -> Vec<usize> {
        let all = 0..self.roots.len();
        all.filter(|&i| self.roots[i].omega_rad_s > 0.0).collect()
    }

    fn lambda(&self, root: usize) -> f64 {
        self.roots[root].omega_rad_s.powi(2)
    }

    /// Mean eigenvalue of the modes with these numbers.
    fn mean(&self, modes: &[usize]) -> f64 {
        let squares = modes.iter().map(|&i| self.modes.omega_rad_s[i].powi(2));
        squares.sum::<f64>() / modes.len() as f64
    }

    /// `p dlambda/dp` of a root by equation 13: `k` times the squared compressions, `-lambda m`
    /// times the squared motions, the mean over the modes of the root.
    fn equation_13(&self, root: usize, name: &str) -> Result<f64, TheoryError> {
        let modes = &self.roots[root].modes;
        let vectors = &self.modes.vectors;
        let mut sum = 0.0;
        if let Some((_, body)) = MASSES.iter().find(|(mass, _)| *mass == name) {
            for (i, _) in (self.modes.coordinates.iter().enumerate())
                .filter(|(_, coordinate)| coordinate.body.starts_with(body))
            {
                let squares = modes.iter().map(|&k| vectors[(i, k)].powi(2));
                sum -= self.lambda(root) * squares.sum::<f64>();
            }
        } else {
            let springs = self.model.assemble(&self.values)?.springs;
            for spring in springs.iter().filter(|spring| spring.name == name) {
                let stretch = |k: usize| -> f64 {
                    let parts = spring.row.iter().enumerate();
                    parts.map(|(i, part)| part * vectors[(i, k)]).sum()
                };
                sum += modes.iter().map(|&k| stretch(k).powi(2)).sum::<f64>();
            }
        }
        Ok(self.values[self.index(name)?] * sum / modes.len() as f64)
    }

    /// `p dlambda/dp` of every root above 0 by central differences at two steps, extrapolated.
    fn differences(&self, j: usize) -> Result<Vec<f64>, TheoryError> {
        let p = self.values[j];
        let at = |part: f64| self.with(j, p * (1.0 + part));
        let central = |part: f64| -> Result<Vec<f64>, TheoryError> {
            let (up, down) = (at(part)?, at(-part)?);
            let slope = |root: usize| {
                let modes = &self.roots[root].modes;
                (up.mean(modes) - down.mean(modes)) / (2.0 * part)
            };
            Ok(self.elastic().into_iter().map(slope).collect())
        };
        let (wide, narrow) = (central(STEP)?, central(0.5 * STEP)?);
        let pairs = wide.iter().zip(&narrow);
        Ok(pairs
            .map(|(wide, narrow)| (4.0 * narrow - wide) / 3.0)
            .collect())
    }

    /// Names of the parameters that equation 13 knows and that are above 0 in a gear that has them.
    fn names(&self) -> Result<Vec<&'static str>, TheoryError> {
        let all = STIFFNESSES.into_iter().chain(MASSES.map(|(name, _)| name));
        let mut names = Vec::new();
        for name in all {
            if self.values[self.index(name)?] > 0.0 {
                names.push(name);
            }
        }
        Ok(names)
    }

    /// Largest difference of equation 13 from the differences, as a part of the root's largest `|p
    /// dlambda/dp|`.
    fn equation_13_error(&self) -> Result<f64, TheoryError> {
        let elastic = self.elastic();
        let mut off = vec![0.0f64; elastic.len()];
        let mut largest = vec![0.0f64; elastic.len()];
        for name in self.names()? {
            let expected = self.differences(self.index(name)?)?;
            for (i, &root) in elastic.iter().enumerate() {
                let sensitivity = self.equation_13(root, name)?;
                off[i] = off[i].max((sensitivity - expected[i]).abs());
                largest[i] = largest[i].max(sensitivity.abs());
            }
        }
        let parts = off.iter().zip(&largest);
        Ok(parts
            .map(|(off, largest)| off / largest)
            .fold(0.0, f64::max))
    }

    /// Largest difference from `lambda/2`, as a part of it, of an energy by the sensitivities of a
    /// root.
    fn energy_error(
        &self,
        energy: impl Fn(usize) -> Result<f64, TheoryError>,
    ) -> Result<f64, TheoryError> {
        let mut largest = 0.0f64;
        for root in self.elastic() {
            largest = largest.max((energy(root)? / (0.5 * self.lambda(root)) - 1.0).abs());
        }
        Ok(largest)
    }

    fn rate(&self, root: usize, name: &str) -> Result<f64, TheoryError> {
        Ok(self.slope(root, self.index(name)?))
    }

    /// `dlambda/dp`; not a number for a root that does not exist: roots that meet at a step are one
    /// root there.
    fn slope(&self, root: usize, j: usize) -> f64 {
        let at_root = self.sensitivities.get(root);
        at_root
            .and_then(|sensitivity| sensitivity.mean(j))
            .unwrap_or(f64::NAN)
    }

    fn value(&self, name: &str) -> Result<f64, TheoryError> {
        Ok(self.values[self.index(name)?])
    }

    /// Equation 14: `T = -1/2 sum m dlambda/dm`.
    fn kinetic(&self, root: usize) -> Result<f64, TheoryError> {
        let mut energy = 0.0;
        for (name, _) in MASSES {
            energy -= 0.5 * self.value(name)? * self.rate(root, name)?;
        }
        Ok(energy)
    }

    /// Equation 19, `factor` in front of the last sum: `k_r/2 dlambda/dk_r + k_s/2 dlambda/dk_s -
    /// factor sum k_h dlambda/dm_h`.
    fn strain(&self, root: usize, factor: f64) -> Result<f64, TheoryError> {
        let mut energy = 0.0;
        for name in ["k_r", "k_s"] {
            energy += 0.5 * self.value(name)? * self.rate(root, name)?;
        }
        for (support, mass) in [("k_cu", "m_c"), ("k_ru", "m_r"), ("k_su", "m_s")] {
            energy -= factor * self.value(support)? * self.rate(root, mass)?;
        }
        Ok(energy)
    }

    /// Largest difference of `dU_r/dk_r` from `1/2 dlambda/dk_r`, as a part of the latter, over the
    /// roots above 0. The energy in the ring meshes is `U_r = k_r/2 dlambda/dk_r`; its rate is a
    /// difference.
    fn mesh_rate_error(&self) -> Result<f64, TheoryError> {
        let j = self.index("k_r")?;
        let k_r = self.values[j];
        let (up, down) = (
            self.with(j, k_r * (1.0 + STEP))?,
            self.with(j, k_r * (1.0 - STEP))?,
        );
        let mut largest = 0.0f64;
        for root in self.elastic() {
            let energy = |state: &Self| 0.5 * state.values[j] * state.slope(root, j);
            let rate = (energy(&up) - energy(&down)) / (2.0 * STEP * k_r);
            let claimed = 0.5 * self.slope(root, j);
            largest = largest.max((rate / claimed - 1.0).abs());
        }
        Ok(largest)
    }
}

/// The claims of section 3 about sensitivities as errors in percent, each the largest over the
/// roots above 0.
pub(super) fn sensitivity_quantities(
    model: &TorsionalPlanetary,
    values: &[f64],
) -> Result<Vec<ModelQuantity>, TheoryError> {
    let state = State::new(model, values)?;
    let make_quantity = |name, part: f64, what| ModelQuantity::new(name, 100.0 * part, "%", what);
    let mut all = vec![
        make_quantity(
            "equation_13_error",
            allowed_or(f64::NAN, state.equation_13_error())?,
            "largest difference of dλ/dp by equation 13 from extrapolated differences, of the largest p dλ/dp of its root; a repeated root by its mean",
        ),
        make_quantity(
            "equation_14_error",
            state.energy_error(|root| state.kinetic(root))?,
            "largest difference of the kinetic energy by equation 14 from λ/2",
        ),
        make_quantity(
            "equation_19_error",
            state.energy_error(|root| state.strain(root, 0.5 / state.lambda(root)))?,
            "largest difference of the strain energy by equation 19 from λ/2, its last term with 1/(2λ)",
        ),
    ];
    if state.value("k_cu")? > 0.0 {
        let misread = |root: usize| state.strain(root, 0.5 * state.lambda(root));
        all.push(make_quantity(
            "equation_19_misread_error",
            state.energy_error(misread)?,
            "the same with λ/2 in the last term",
        ));
    }
    all.push(make_quantity(
        "mesh_energy_rate_error",
        allowed_or(f64::NAN, state.mesh_rate_error())?,
        "largest difference of dU_r/dk_r from (1/2) dλ/dk_r: 0 only while the shape stays as it is",
    ));
    Ok(all)
}

//! Comparison of models of growing detail of one machine: the simplest within a stated error.
//!
//! A model's small bodies can be left without mass: with `b` their coordinates and `a` the others,
//! statics gives `x_b = -K_bb^+ K_ba x_a` and `K = K_aa - K_ab K_bb^+ K_ba`; directions in which no
//! spring holds a small body drop out of the pseudo-inverse. Roots are paired with those of the
//! whole model by their shapes, after the motion `x_b` is restored.
//!
//! # Reference
//! Guyan (1965), Reduction of stiffness and mass matrices, AIAA Journal 3, 380.

use crate::linalg::{RealMatrix, real_matrix, symmetric_eigen};

use super::{
    ModeOptions, ModelRoot, SystemMatrices, TheoreticalModel, TheoryError, TheoryModes,
    TimeResponse, model_roots, modes_of_matrices,
};

/// Fraction of the largest eigenvalue of `K_bb` above which a direction counts as held.
const MIN_EIGENVALUE_RATIO: f64 = 1e-10;
/// Minimum share of a root's shapes in a root of a simpler model for both to be the same root.
const MIN_SHAPE_SHARE: f64 = 0.5;

/// A simpler model, or the whole one.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplerModel {
    /// The masses that it leaves out.
    pub name: String,
    /// Its coordinates.
    pub coordinates: usize,
    /// Angular frequency of each root of the whole model in this one, rad/s; `None` for a root that
    /// it does not have.
    pub omega_rad_s: Vec<Option<f64>>,
}

impl SimplerModel {
    /// Work of the eigenproblem as a fraction of that of a model with `whole` coordinates: it grows
    /// with the third power.
    pub fn cost(&self, whole: usize) -> f64 {
        (self.coordinates as f64 / whole as f64).powi(3)
    }
}

/// A model and its simpler ones.
#[derive(Clone, Debug, PartialEq)]
pub struct DetailComparison {
    /// Roots of the whole model above 0.
    pub roots: Vec<ModelRoot>,
    /// From the fewest coordinates to the whole model, which is the last.
    pub models: Vec<SimplerModel>,
}

impl DetailComparison {
    /// Relative error of a root in a model.
    pub fn error(&self, model: usize, root: usize) -> Option<f64> {
        let omega = self.models[model].omega_rad_s[root]?;
        Some(omega / self.roots[root].omega_rad_s - 1.0)
    }

    /// The model with the fewest coordinates that has a root within this error.
    pub fn simplest(&self, root: usize, within: f64) -> Option<&SimplerModel> {
        let all = 0..self.models.len();
        let mut fits =
            all.filter(|&model| self.error(model, root).is_some_and(|e| e.abs() <= within));
        fits.next().map(|model| &self.models[model])
    }

    /// The model with the fewest coordinates that has every root up to an angular frequency within
    /// this error.
    pub fn simplest_up_to(&self, omega_rad_s: f64, within: f64) -> Option<&SimplerModel> {
        let roots: Vec<usize> = (0..self.roots.len())
            .filter(|&root| self.roots[root].omega_rad_s <= omega_rad_s)
            .collect();
        let reproduces_all = |model: &usize| {
            let mut all = roots.iter();
            all.all(|&root| self.error(*model, root).is_some_and(|e| e.abs() <= within))
        };
        (0..self.models.len())
            .find(reproduces_all)
            .map(|model| &self.models[model])
    }
}

/// The simplest detail of a response whose signal is within this distance of the last one's; `None`
/// where the last has no such signal.
pub fn simplest_detail<'a>(
    response: &'a TimeResponse,
    signal: &str,
    within: f64,
) -> Option<&'a str> {
    let last = response.details.last()?.detail;
    let near = |detail: &&'a str| {
        response
            .difference(signal, detail, last)
            .is_some_and(|d| d <= within)
    };
    response
        .details
        .iter()
        .map(|response| response.detail)
        .find(near)
}

/// Compares a model with those without the mass of its small bodies, every combination of them.
///
/// # Errors
/// Those of the model; [`TheoryError::NoSimplerModel`] for one that names no small bodies.
pub fn compare_details(
    model: &dyn TheoreticalModel,
    values: &[f64],
) -> Result<DetailComparison, TheoryError> {
    let small = model.small_bodies();
    if small.is_empty() {
        return Err(TheoryError::NoSimplerModel {
            model: model.name().to_owned(),
        });
    }
    let matrices = model.assemble(values)?;
    let whole = modes_of_matrices(&matrices, &ModeOptions::default())?;
    let all = model_roots(model, &whole);
    let roots: Vec<ModelRoot> = all
        .into_iter()
        .filter(|root| root.omega_rad_s > 0.0)
        .collect();
    let mut models = Vec::new();
    for choice in 0..1usize << small.len() {
        let chosen = small
            .iter()
            .enumerate()
            .filter(|(i, _)| choice >> i & 1 == 1);
        let kinds: Vec<&str> = chosen.map(|(_, kind)| *kind).collect();
        models.push(simpler(&matrices, &whole, &roots, &kinds)?);
    }
    models.sort_by_key(|model| model.coordinates);
    Ok(DetailComparison { roots, models })
}

fn simpler(
    matrices: &SystemMatrices,
    whole: &TheoryModes,
    roots: &[ModelRoot],
    kinds: &[&str],
) -> Result<SimplerModel, TheoryError> {
    let of_kind = |body: &str| {
        let kind = body.rsplit_once('-').map_or(body, |(kind, _)| kind);
        kinds.contains(&kind)
    };
    let all = 0..matrices.coordinates.len();
    let (light, kept): (Vec<usize>, Vec<usize>) =
        all.partition(|&i| of_kind(&matrices.coordinates[i].body));
    let expansion = static_expansion(&matrices.stiffness, &kept, &light)?;
    let simpler_modes = modes_of_matrices(
        &reduced(matrices, &expansion, &kept),
        &ModeOptions::default(),
    )?;
    let shapes = &expansion * &simpler_modes.vectors;
    let overlap = whole.vectors.transpose() * (&matrices.mass * &shapes);
    let groups = simpler_modes.model.roots();
    let matched = |root: &ModelRoot| {
        let share = |group: &Vec<usize>| -> f64 {
            let shares = group.iter().map(|&k| {
                let column: f64 = (0..overlap.nrows()).map(|i| overlap[(i, k)].powi(2)).sum();
                let theirs: f64 = root.modes.iter().map(|&i| overlap[(i, k)].powi(2)).sum();
                theirs / column
            });
            shares.sum::<f64>() / root.modes.len().max(group.len()) as f64
        };
        let best = groups.iter().max_by(|a, b| share(a).total_cmp(&share(b)))?;
        (share(best) >= MIN_SHAPE_SHARE).then(|| simpler_modes.omega_rad_s[best[0]])
    };
    Ok(SimplerModel {
        name: match kinds {
            [] => "every body with its mass".to_owned(),
            _ => format!("without mass: {}", kinds.join(", ")),
        },
        coordinates: kept.len(),
        omega_rad_s: roots.iter().map(matched).collect(),
    })
}

/// Rows of all coordinates, columns of those kept: the others follow by statics.
fn static_expansion(
    stiffness: &RealMatrix,
    kept: &[usize],
    light: &[usize],
) -> Result<RealMatrix, TheoryError> {
    let mut expansion = real_matrix(stiffness.nrows(), kept.len(), |i, a| {
        if kept[a] == i { 1.0 } else { 0.0 }
    });
    if light.is_empty() {
        return Ok(expansion);
    }
    let m = light.len();
    let block = real_matrix(m, m, |i, j| stiffness[(light[i], light[j])]);
    let eigen = symmetric_eigen(&block)?;
    let largest = eigen.values.iter().copied().fold(0.0, f64::max);
    let coupling = real_matrix(m, kept.len(), |i, a| stiffness[(light[i], kept[a])]);
    let mut followed = eigen.vectors.transpose() * coupling;
    for (k, value) in eigen.values.iter().enumerate() {
        for a in 0..kept.len() {
            let held = *value > MIN_EIGENVALUE_RATIO * largest;
            followed[(k, a)] = if held { -followed[(k, a)] / value } else { 0.0 };
        }
    }
    let followed = &eigen.vectors * followed;
    for (i, &row) in light.iter().enumerate() {
        for a in 0..kept.len() {
            expansion[(row, a)] = followed[(i, a)];
        }
    }
    Ok(expansion)
}

/// Matrices over the coordinates kept: their masses, and the stiffness with the others following.
fn reduced(matrices: &SystemMatrices, expansion: &RealMatrix, kept: &[usize]) -> SystemMatrices {
    let stiffness = expansion.transpose() * (&matrices.stiffness * expansion);
    let n = kept.len();
    SystemMatrices {
        mass: real_matrix(n, n, |i, j| matrices.mass[(kept[i], kept[j])]),
        damping: None,
        stiffness: real_matrix(n, n, |i, j| 0.5 * (stiffness[(i, j)] + stiffness[(j, i)])),
        coordinates: kept
            .iter()
            .map(|&i| matrices.coordinates[i].clone())
            .collect(),
        springs: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::parameter::nominal_values;
    use crate::theory::{ResponseSpan, built_in};

    #[test]
    fn without_mass_is_the_limit_of_a_light_mass() {
        let model = built_in("cycloid-ball").unwrap();
        let values = nominal_values(model.parameters());
        let comparison = compare_details(model.as_ref(), &values).unwrap();
        let mut light = model.assemble(&values).unwrap();
        for (i, coordinate) in light.coordinates.iter().enumerate() {
            if coordinate.body.contains("ball-") {
                light.mass[(i, i)] *= 1e-7;
            }
        }
        let options = ModeOptions::default();
        let limit = modes_of_matrices(&light, &options).unwrap().omega_rad_s;
        let found: Vec<f64> = comparison.models[0]
            .omega_rad_s
            .iter()
            .flatten()
            .copied()
            .collect();
        assert!(found.len() >= 8, "{found:?}");
        for omega in found {
            let nearest = limit
                .iter()
                .map(|limit| (limit / omega - 1.0).abs())
                .fold(f64::MAX, f64::min);
            assert!(nearest < 1e-6, "{omega}: {nearest}");
        }
    }

    #[test]
    fn every_combination_is_compared_and_the_simplest_within_the_error_is_named() {
        let model = built_in("cycloid-ball").unwrap();
        let values = nominal_values(model.parameters());
        let comparison = compare_details(model.as_ref(), &values).unwrap();
        let coordinates: Vec<usize> = comparison
            .models
            .iter()
            .map(|model| model.coordinates)
            .collect();
        assert_eq!(coordinates, [11, 17, 31, 37]);
        for root in 0..comparison.roots.len() {
            assert!(
                comparison.error(3, root).unwrap().abs() < 1e-12,
                "the whole model is itself"
            );
        }
        assert_eq!(comparison.simplest(0, 1e-9).unwrap().coordinates, 37);
        // Roots of balls alone exist only with their mass.
        let alone = comparison
            .roots
            .iter()
            .position(|root| root.modes.len() == 8)
            .unwrap();
        assert_eq!(comparison.error(0, alone), None);
        assert_eq!(
            comparison.simplest(alone, 10.0).unwrap().coordinates,
            17 + 20 - 6
        );
        let lowest = comparison.roots[0].omega_rad_s;
        let pins = comparison
            .roots
            .iter()
            .position(|root| root.modes.len() == 4)
            .unwrap();
        assert_eq!(comparison.simplest(pins, 1e-9).unwrap().coordinates, 17);
        let loose = comparison.simplest_up_to(lowest, 1.0).unwrap();
        assert_eq!(loose.coordinates, 11);
        // The two formulas of a cube differ in the last digit.
        assert!((loose.cost(37) / (11.0f64 / 37.0).powi(3) - 1.0).abs() < 1e-12);
        let error = compare_details(built_in("torsional-planetary").unwrap().as_ref(), &[]);
        assert!(matches!(error, Err(TheoryError::NoSimplerModel { .. })));
    }

    #[test]
    fn the_constant_angle_is_the_simplest_for_the_deflection_and_bearings_for_the_orbit() {
        let model = built_in("helical-planetary").unwrap();
        let values = nominal_values(model.parameters());
        let span = ResponseSpan {
            settling_periods: 20,
            recorded_periods: 5,
            step_radians: 0.6,
        };
        let response = model.nonlinear().unwrap().response(&values, span).unwrap();
        assert_eq!(
            simplest_detail(&response, "delta_sp1", 0.01),
            Some("constant angle")
        );
        assert_eq!(
            simplest_detail(&response, "delta_sp1", 0.5),
            Some("torsional")
        );
        assert_eq!(
            simplest_detail(&response, "delta_sp1", 1e-9),
            Some("varying angle, exact")
        );
        assert_eq!(
            simplest_detail(&response, "angle_sp1", 0.01),
            Some("varying angle as printed")
        );
        assert_eq!(simplest_detail(&response, "no such signal", 1.0), None);
    }
}

//! Shapes without the mass of a roving sensor.
//!
//! A mass m at point o lowers the natural frequency of mode r by the fraction `d = m φ_ro²/2`, and
//! adds the other modes s to its shape. To first order its residue at o, hit at i, changes by
//!
//! ```text
//! ΔA_r = 2 d Σ_s A_s (ω_s/ω_r) ω_r²/(ω_s² − ω_r²)
//! ```
//!
//! with the residues A_s of the same FRF, of modes of unit modal mass (change of eigenvectors: Fox
//! and Kapoor 1968, AIAA Journal 6, equation 21). d follows from the shifts of the runs. Where the
//! reference is near a node of mode r, the other modes exceed it: the residues of the runs, each of
//! another structure, then make no shape, and seem to be those of a repeated root with two
//! references.

use num_complex::Complex64;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::run_variation::{RunShifts, explained_by_mass};
use crate::linalg;

/// Change of the residues of a mode over these, above which the mode is doubtful: the expected loss
/// of MAC without the correction is the square. At a change of 1.5 the correction raises the MAC
/// with the structure without the sensor from 0.37 to 0.996; modes beyond the band, whose residues
/// are not known, can leave it at 0.43. Larger: shapes that the mass determines are called good.
/// Smaller: shapes that it hardly changes are doubtful. Test:
/// `a_mode_hit_near_its_node_under_a_roving_mass_has_the_shape_without_it`.
pub(in crate::identify) const MAX_SHAPE_CHANGE: f64 = 0.3;
/// Minimum fraction of the scatter that the mass of the sensor explains in half of the modes. A
/// structure that changes between runs shifts modes independently of their shapes, of which a
/// straight line over ten runs explains 0.1 on average. Test:
/// `drifts_of_the_structure_leave_the_residues`.
const MIN_FRACTION_BY_MASS: f64 = 0.5;
/// Energy beyond the first singular value over that with the mass, below which a repeated root is
/// one mode: half. Test: `a_roving_mass_makes_no_repeated_root`.
const MAX_REMAINING_FRACTION: f64 = 0.5;

/// A mode without the mass of the roving sensor.
pub(in crate::identify) struct Unloaded {
    /// Residue of each FRF, m/(N s).
    pub residues: Vec<Complex64>,
    /// Norm of the change by the mass over that of the residues.
    pub change: f64,
    /// Number of modes of the pole.
    pub multiplicity: usize,
}

impl RunShifts {
    /// A mode without the mass of the roving sensor, beside all others; `None` where the shifts of
    /// the runs have another cause.
    pub fn unloaded(
        &self,
        pole: &ModelPole,
        all: &[&ModelPole],
        frf_matrix: &FrfMatrix,
    ) -> Option<Unloaded> {
        let shifts = self.shifts_of(pole.lambda)?;
        if self.positions.is_empty() {
            return None;
        }
        let fractions = self.modes.iter();
        let mut fractions: Vec<f64> = fractions
            .map(|mode| explained_by_mass(mode, &self.positions))
            .collect();
        fractions.sort_by(f64::total_cmp);
        if fractions[fractions.len() / 2] <= MIN_FRACTION_BY_MASS {
            return None;
        }
        let highest = shifts.iter().map(|shift| shift.im);
        let highest = highest.fold(f64::MIN, f64::max);
        let omega = pole.lambda.im;
        let mut changes = vec![Complex64::ZERO; pole.residues.len()];
        for (run, shift) in self.runs.iter().zip(shifts) {
            let lowered = (highest - shift.im) / omega;
            for other in all.iter().filter(|other| other.lambda != pole.lambda) {
                let ratio = other.lambda.im / omega;
                let distance = ratio * ratio - 1.0;
                // Nearer than the shift, both shapes mix.
                let distance = distance.abs().max(2.0 * lowered).copysign(distance);
                let factor = 2.0 * lowered * ratio / distance;
                run.iter()
                    .for_each(|f| changes[*f] += other.residues[*f] * factor);
            }
        }
        let energy = |values: &[Complex64]| values.iter().map(Complex64::norm_sqr).sum::<f64>();
        let change = (energy(&changes) / energy(&pole.residues)).sqrt();
        let pairs = pole.residues.iter().zip(changes);
        let residues: Vec<Complex64> = pairs.map(|(a, change)| a - change).collect();
        let multiplicity = match pole.multiplicity() {
            1 => 1,
            _ if is_one_mode(pole, &residues, frf_matrix) => 1,
            several => several,
        };
        change.is_finite().then_some(Unloaded {
            residues,
            change,
            multiplicity,
        })
    }
}

/// Whether the mass explains that the residues of a pole are those of several modes.
fn is_one_mode(pole: &ModelPole, residues: &[Complex64], frf_matrix: &FrfMatrix) -> bool {
    // Residues beyond the first singular value.
    let remaining = |residues: &[Complex64]| {
        let svd = linalg::singular_vectors(&frf_matrix.matrix(|f| residues[f])).ok()?;
        Some(svd.values.iter().skip(1).map(|s| s * s).sum::<f64>())
    };
    frf_matrix.is_complete()
        && remaining(residues)
            .zip(remaining(&pole.residues))
            .is_some_and(|(now, before)| now < MAX_REMAINING_FRACTION * before)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::axis::FrequencyAxis;
    use crate::dof::Dof;
    use crate::finding::Code;
    use crate::frf::{FrfSet, FunctionData};
    use crate::identify::run_variation::tests::{findings_of, found};
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::{Grade, Mode, mac};

    const MASS_KG: f64 = 0.004;

    /// Three modes of a structure of 1 kg at ten points; the second moves by `at_reference` at the
    /// first point, where it is hit.
    fn structure(at_reference: f64) -> Structure {
        let shape = |order: f64, phase: f64| -> Vec<f64> {
            let at = |p: usize| 2f64.sqrt() * (order * 0.3 * p as f64 + phase).cos();
            (0..10).map(at).collect()
        };
        let mut second = shape(2.0, 0.9);
        second[0] = at_reference;
        let modes = vec![
            (100.0, 0.004, shape(1.0, 0.2)),
            (140.0, 0.004, second),
            (180.0, 0.004, shape(3.0, 0.4)),
        ];
        Structure { modes }
    }

    fn mac_with_truth(mode: &Mode, structure: &Structure, j: usize) -> f64 {
        let shape: Vec<Complex64> = mode.shape.iter().map(|(_, value)| value).collect();
        let truth = structure.modes[j].2.iter();
        let truth: Vec<Complex64> = truth.map(|v| Complex64::from(*v)).collect();
        mac(&shape, &truth).unwrap()
    }

    /// FRFs of a run for each point of the sensor, with a mass at a point in each:
    /// `α_oi − α_op s² m α_pi/(1 + s² m α_pp)`.
    fn loaded(
        structure: &Structure,
        references: &[&str],
        mass_of_run: impl Fn(usize) -> (usize, f64),
    ) -> FrfSet {
        let axis = FrequencyAxis {
            start_hz: 70.0,
            step_hz: 0.1,
            len: 1500,
        };
        let mut how = Measurement {
            snr_db: Some(70.0),
            ..Measurement::of_sensors(10, axis)
        };
        let sensors = std::mem::take(&mut how.pairs);
        for reference in references {
            let pairs = sensors.iter();
            let pairs = pairs.map(|(sensor, _)| (sensor.clone(), reference.parse().unwrap()));
            how.pairs.extend(pairs);
        }
        let measured = structure.measured(&how);
        let mut set = FrfSet::new(axis);
        for (f, (sensor, hit)) in how.pairs.iter().enumerate() {
            let (point, mass_kg) = mass_of_run(f % 10);
            let loaded: Dof = format!("{}:+Z", point + 1).parse().unwrap();
            let change = |k: usize| {
                let s = Complex64::new(0.0, axis.rad_s(k));
                let receptance = |a: &Dof, b: &Dof| structure.value(&(a.clone(), b.clone()), s, 0);
                let inertia = s * s * mass_kg;
                let both = receptance(sensor, &loaded) * inertia * receptance(&loaded, hit);
                -s * s * both / (1.0 + inertia * receptance(&loaded, &loaded))
            };
            let values = measured.values(f).iter().enumerate();
            let data = FunctionData {
                values: values.map(|(k, value)| value + change(k)).collect(),
                coherence: None,
                variance: measured.variance(f).map(<[f64]>::to_vec),
            };
            set.push(measured.functions()[f].clone(), data).unwrap();
        }
        set
    }

    #[test]
    fn a_mode_hit_near_its_node_under_a_roving_mass_has_the_shape_without_it() {
        for (at_reference, is_doubtful) in [(1.0, false), (0.3, false), (0.02, true), (-0.02, true)]
        {
            let structure = structure(at_reference);
            let model = found(&loaded(&structure, &["1:+Z"], |point| (point, MASS_KG)));
            assert_eq!(model.modes.len(), 3, "{at_reference}");
            for (j, mode) in model.modes.iter().enumerate() {
                let quality = mode.quality.as_ref().unwrap();
                let doubtful = quality.verdict == Grade::Doubtful;
                assert_eq!(quality.shape == Some(Grade::Doubtful), doubtful);
                assert_eq!(
                    doubtful,
                    is_doubtful && j == 1,
                    "{at_reference} {j}: {quality:?}"
                );
                let agrees = mac_with_truth(mode, &structure, j);
                assert!(
                    agrees > if doubtful { 0.99 } else { 0.9998 },
                    "{at_reference} {j}: {agrees}"
                );
            }
            let findings = findings_of(&model, Code::LoadedShape);
            assert_eq!(findings.len(), usize::from(is_doubtful), "{at_reference}");
        }
    }

    #[test]
    fn a_roving_mass_makes_no_repeated_root() {
        let mut structure = structure(0.02);
        structure.modes[1].2[1] = -0.05;
        let model = found(&loaded(&structure, &["1:+Z", "2:+Z"], |point| {
            (point, MASS_KG)
        }));
        assert_eq!(model.modes.len(), 3);
        for (j, mode) in model.modes.iter().enumerate() {
            let agrees = mac_with_truth(mode, &structure, j);
            assert!(agrees > 0.99, "{j}: {agrees}");
        }
    }

    #[test]
    fn drifts_of_the_structure_leave_the_residues() {
        // The mass is at point 7, whichever the sensor, and changes from run to run.
        let changes = [0.1, 0.9, 0.3, 1.0, 0.0, 0.7, 0.2, 0.8, 0.5, 0.4];
        let structure = structure(0.3);
        let model = found(&loaded(&structure, &["1:+Z"], |run| {
            (6, MASS_KG * changes[run])
        }));
        assert_eq!(findings_of(&model, Code::RunsMerged).len(), 3);
        assert!(findings_of(&model, Code::LoadedShape).is_empty());
        // Shapes of a mode that is hit near its node are those of the runs.
        for (j, mode) in model.modes.iter().enumerate() {
            let agrees = mac_with_truth(mode, &structure, j);
            assert!(agrees > 0.999, "{j}: {agrees}");
        }
    }
}

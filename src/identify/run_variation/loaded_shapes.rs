//! Shapes without the mass of a roving sensor of one axis.
//!
//! A mass m at point o lowers the natural frequency of mode r by the fraction `d_r = m φ_ro²/2`,
//! and mixes the other modes s into its shape. To first order its residue at o, hit at i, changes
//! by
//!
//! ```text
//! ΔA_r = −i d_r ω_r α_r + A_r (Σ_s 2 d_s ω_r²/(ω_s² − ω_r²) − d_r)
//! ```
//!
//! with α_r, the receptance of all other modes at ω_r, out-of-band terms included (change of
//! eigenvectors: Fox and Kapoor 1968, AIAA Journal 6, equation 21, for modes of unit modal mass).
//! d follows from the shifts of the runs; the run with the highest frequency counts as one without
//! mass. The structure is taken to move in the direction of the sensor: else the shifts are not in
//! proportion to the squared motion, and nothing is corrected.
//!
//! Where the reference is near a node of mode r, the other modes exceed it: the residues of the
//! runs, each of another structure, then make no shape, and seem to be those of a repeated root
//! with two references.

use num_complex::Complex64;

use crate::identify::data::frf_matrix::FrfMatrix;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::run_variation::{RunShifts, explained_by_mass};
use crate::linalg;

/// Norm of the change of the residues over their norm, or part of another mode in a shape, above
/// which a mode is doubtful: the expected loss of MAC without the correction is the square.
///
/// At a change of 1.5 the correction raises the MAC with the structure without the sensor from 0.37
/// to above 0.99. Larger: shapes that the mass determines are called good. Smaller: shapes that it
/// hardly changes are doubtful. Tests:
/// `a_mode_hit_near_its_node_under_a_roving_mass_has_the_shape_without_it`,
/// `close_modes_that_the_mass_mixes_are_doubtful`.
pub(in crate::identify) const MAX_SHAPE_CHANGE: f64 = 0.3;
/// Minimum fraction of the scatter that the mass of the sensor explains in half of the modes.
///
/// Smaller: shifts that have nothing to do with the shapes, of which a straight line over ten runs
/// explains 0.1 on average, change residues. Larger: modes near whose nodes the reference lies,
/// which the line does not describe, prevent the correction of all. Test:
/// `shifts_without_a_mass_leave_the_residues`.
const MIN_FRACTION_BY_MASS: f64 = 0.8;
/// Energy beyond the first singular value over that with the mass, below which a repeated root is
/// one mode. Larger: the mass explains less than half of the second mode. Smaller: what higher
/// orders leave of it counts as a mode. Test: `a_roving_mass_makes_no_repeated_root`.
const MAX_REMAINING_FRACTION: f64 = 0.5;

/// A mode without the mass of the roving sensor.
pub(in crate::identify) struct Unloaded {
    /// Residue of each FRF, m/(N s); those with the mass where it mixes two modes.
    pub residues: Vec<Complex64>,
    /// Norm of the change by the mass over that of the residues, or the largest part of another
    /// mode in the shape.
    pub change: f64,
    /// Number of modes of the pole.
    pub multiplicity: usize,
}

impl RunShifts {
    /// A mode without the mass of the roving sensor, beside all other poles; `None` where the
    /// shifts of the runs have another cause. `remaining`: receptance of each FRF at the frequency
    /// of the mode without it, m/N.
    pub fn unloaded(
        &self,
        pole: &ModelPole,
        poles: &[ModelPole],
        frf_matrix: &FrfMatrix,
        remaining: impl Fn(usize) -> Complex64,
    ) -> Option<Unloaded> {
        if self.positions.is_empty() || !self.are_by_mass() {
            return None;
        }
        let lowered = self.lowered_by_mass(pole)?;
        let others = poles.iter();
        let others: Vec<(&ModelPole, Vec<f64>)> = others
            .filter(|other| !other.is_companion && other.lambda != pole.lambda)
            .map(|other| {
                let unshifted = || vec![0.0; self.runs.len()];
                let lowered = self.lowered_by_mass(other).unwrap_or_else(unshifted);
                (other, lowered)
            })
            .collect();
        let mut changes = vec![Complex64::ZERO; pole.residues.len()];
        let mut mixed = 0.0f64;
        let omega = pole.lambda.im;
        for (run, functions) in self.runs.iter().enumerate() {
            let of_mode = lowered[run];
            let mut scale = -of_mode;
            for (other, lowered) in &others {
                let ratio = other.lambda.im / omega;
                let coupling = 2.0 / (ratio * ratio - 1.0);
                let part = (of_mode * lowered[run]).sqrt() * coupling.abs();
                // Modes of one frequency mix wholly.
                mixed = mixed.max(if part.is_nan() { f64::INFINITY } else { part });
                scale += lowered[run] * coupling;
            }
            for f in functions {
                let of_others = Complex64::new(0.0, -of_mode * omega) * remaining(*f);
                changes[*f] = of_others + pole.residues[*f] * scale;
            }
        }
        if mixed > MAX_SHAPE_CHANGE {
            return Some(Unloaded {
                residues: pole.residues.clone(),
                change: mixed.min(1.0),
                multiplicity: pole.multiplicity(),
            });
        }
        let energy = |values: &[Complex64]| values.iter().map(Complex64::norm_sqr).sum::<f64>();
        let change = (energy(&changes) / energy(&pole.residues)).sqrt();
        let pairs = pole.residues.iter().zip(changes);
        let residues: Vec<Complex64> = pairs.map(|(a, change)| a - change).collect();
        let multiplicity = match pole.multiplicity() {
            2 if is_one_mode(pole, &residues, frf_matrix) => 1,
            as_fitted => as_fitted,
        };
        change.is_finite().then_some(Unloaded {
            residues,
            change,
            multiplicity,
        })
    }

    /// Whether the mass of the sensor explains the shifts of the runs.
    fn are_by_mass(&self) -> bool {
        let modes = self.modes.iter();
        let mut fractions: Vec<f64> = modes
            .map(|mode| explained_by_mass(mode, &self.positions))
            .collect();
        fractions.sort_by(f64::total_cmp);
        let median = fractions.get(fractions.len() / 2);
        median.is_some_and(|fraction| *fraction > MIN_FRACTION_BY_MASS)
    }

    /// Fraction by which the mass lowers the frequency of a mode in each run.
    fn lowered_by_mass(&self, pole: &ModelPole) -> Option<Vec<f64>> {
        let shifts = self.shifts_of(pole.lambda)?;
        let highest = shifts.iter().map(|shift| shift.im);
        let highest = highest.fold(f64::MIN, f64::max);
        let lowered = |shift: &Complex64| (highest - shift.im) / pole.lambda.im;
        Some(shifts.iter().map(lowered).collect())
    }
}

/// Whether the mass explains that the residues of a pole are those of two modes.
fn is_one_mode(pole: &ModelPole, residues: &[Complex64], frf_matrix: &FrfMatrix) -> bool {
    let beyond_first = |residues: &[Complex64]| {
        let svd = linalg::singular_vectors(&frf_matrix.matrix(|f| residues[f])).ok()?;
        Some(svd.values.iter().skip(1).map(|s| s * s).sum::<f64>())
    };
    frf_matrix.is_complete()
        && beyond_first(residues)
            .zip(beyond_first(&pole.residues))
            .is_some_and(|(now, before)| now < MAX_REMAINING_FRACTION * before)
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use crate::axis::FrequencyAxis;
    use crate::finding::Code;
    use crate::frf::FrfSet;
    use crate::identify::data::frf_matrix::FrfMatrix;
    use crate::identify::data::model_pole::ModelPole;
    use crate::identify::run_variation::RunShifts;
    use crate::identify::run_variation::shifted_mode::ShiftedMode;
    use crate::identify::run_variation::tests::{findings_of, found, roving};
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

    fn measurement(references: &[&str]) -> Measurement {
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
        how
    }

    fn loaded(
        structure: &Structure,
        references: &[&str],
        mass_of_run: impl Fn(usize) -> (usize, f64),
    ) -> FrfSet {
        structure.measured_under_masses(&measurement(references), |f| mass_of_run(f % 10))
    }

    /// Two modes of unit modal mass at five points, the last at rest, with their frequencies
    /// (rad/s) and their residues under a mass at each point, hit at the first.
    fn two_modes_under_mass(mass_kg: f64) -> ([[f64; 5]; 2], [[Complex64; 5]; 2]) {
        let shapes: [[f64; 5]; 2] = [[1.0, -0.8, 1.3, 0.4, 0.0], [0.3, 0.9, -1.1, 1.2, 0.0]];
        let squares = [100.0f64.powi(2), 150.0f64.powi(2)];
        let mut frequencies = [[0.0; 5]; 2];
        let mut residues = [[Complex64::ZERO; 5]; 2];
        for o in 0..5 {
            // (1 + m φφᵀ)⁻¹ diag(ω²) has the squared frequencies; with a = m φ₁², b = m φ₂²:
            let [a, b] = [0, 1].map(|j| mass_kg * shapes[j][o].powi(2));
            let cross = mass_kg * shapes[0][o] * shapes[1][o];
            let determinant = 1.0 + a + b;
            let trace = (squares[0] * (1.0 + b) + squares[1] * (1.0 + a)) / determinant;
            let root = (trace * trace / 4.0 - squares[0] * squares[1] / determinant).sqrt();
            for (j, sign) in [-1.0, 1.0].into_iter().enumerate() {
                let square = trace / 2.0 + sign * root;
                // (ω_i² − x (1 + m φ_i²)) q_i = x m φ₁ φ₂ q_j for x = ω².
                let i = 1 - j;
                let mut part = [1.0f64; 2];
                let inertia = 1.0 + [a, b][i];
                part[i] = square * cross / (squares[i] - square * inertia);
                let mass = part[0].powi(2)
                    + part[1].powi(2)
                    + mass_kg * (part[0] * shapes[0][o] + part[1] * shapes[1][o]).powi(2);
                let at = |point: usize| part[0] * shapes[0][point] + part[1] * shapes[1][point];
                frequencies[j][o] = square.sqrt();
                residues[j][o] =
                    at(o) * at(0) / mass / Complex64::new(0.0, 2.0 * frequencies[j][o]);
            }
        }
        (frequencies, residues)
    }

    #[test]
    fn residues_without_a_small_mass_are_exact_to_first_order() {
        let (frequencies, residues) = two_modes_under_mass(1e-6);
        let (_, exact) = two_modes_under_mass(0.0);
        let mean = |j: usize| frequencies[j].iter().sum::<f64>() / 5.0;
        let runs: Vec<Vec<usize>> = (0..5).map(|run| vec![run]).collect();
        let mode = |j: usize| ShiftedMode {
            lambda: Complex64::new(-1.0, mean(j)),
            scatter: 1.0,
            decay_std: 0.0,
            shifts: frequencies[j]
                .map(|at| Complex64::new(0.0, at - mean(j)))
                .to_vec(),
            stds: vec![0.0; 5],
            residues: residues[j].to_vec(),
        };
        let shifts = RunShifts {
            positions: runs.clone(),
            runs,
            modes: vec![mode(0), mode(1)],
            ..RunShifts::default()
        };
        let pole = |j: usize| {
            let lambda = Complex64::new(-1.0, mean(j));
            let mut pole = ModelPole::single(lambda, &[Complex64::ONE], 5);
            pole.residues = residues[j].to_vec();
            pole
        };
        let poles = [pole(0), pole(1)];
        let matrix = FrfMatrix {
            inputs: 1,
            outputs: (0..5).map(|f| vec![(0, f)]).collect(),
        };
        for j in 0..2 {
            let i = 1 - j;
            let remaining = |f: usize| {
                let product = residues[i][f] * Complex64::new(0.0, 2.0 * frequencies[i][f]);
                product / (frequencies[i][f].powi(2) - mean(j).powi(2))
            };
            let unloaded = shifts
                .unloaded(&poles[j], &poles, &matrix, remaining)
                .unwrap();
            for f in 0..4 {
                let change = residues[j][f] - exact[j][f];
                let error = unloaded.residues[f] - exact[j][f];
                assert!(
                    error.norm() < 2e-4 * change.norm(),
                    "{j} {f}: {error} of {change}"
                );
            }
        }
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
    fn a_heavy_roving_sensor_at_a_point_of_large_motion_makes_no_further_mode() {
        // The mass lowers the second frequency by 4.5 % at one point, by 1 % at most at others.
        let mut structure = structure(1.0);
        structure.modes[1].2[4] = 3.0;
        let model = found(&loaded(&structure, &["1:+Z"], |point| (point, 0.01)));
        let hz: Vec<f64> = model.modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(hz.len(), 3, "{hz:?}");
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
    fn close_modes_that_the_mass_mixes_are_doubtful() {
        // Motion at the reference, frequency of the second mode, mass of the sensor.
        for (at_reference, hz, mass_kg) in [
            (1.0, 110.0, MASS_KG),
            (0.3, 105.0, 0.002),
            (1.0, 101.0, MASS_KG),
        ] {
            let mut structure = structure(at_reference);
            structure.modes[1].0 = hz;
            let model = found(&loaded(&structure, &["1:+Z"], |point| (point, mass_kg)));
            let mut doubtful = 0;
            for (j, mode) in model.modes.iter().enumerate() {
                let is_doubtful = mode.quality.as_ref().unwrap().verdict != Grade::Good;
                doubtful += usize::from(is_doubtful);
                let agrees = mac_with_truth(mode, &structure, j);
                assert!(is_doubtful || agrees > 0.999, "{hz} {j}: {agrees}");
            }
            assert_eq!(doubtful > 0, hz < 102.0, "{hz}");
        }
    }

    #[test]
    fn shifts_without_a_mass_leave_the_residues() {
        // Natural frequencies that change from run to run, with the shapes of the structure.
        let changes = [0.1, 0.9, 0.3, 1.0, 0.0, 0.7, 0.2, 0.8, 0.5, 0.4];
        let structure = structure(0.02);
        let test = (structure, measurement(&["1:+Z"]));
        let model = found(&roving(&test, false, |point, _| changes[point]));
        assert_eq!(findings_of(&model, Code::RunsMerged).len(), 3);
        assert!(findings_of(&model, Code::LoadedShape).is_empty());
        for (j, mode) in model.modes.iter().enumerate() {
            let agrees = mac_with_truth(mode, &test.0, j);
            assert!(agrees > 0.9999, "{j}: {agrees}");
        }
    }

    #[test]
    fn sensors_of_several_axes_keep_their_residues() {
        // Bending in Y and in Z at 100 and 103 Hz: the mass does not couple them.
        let mut structure = structure(1.0);
        structure.modes[1].0 = 103.0;
        let functions = loaded(&structure, &["1:+Z"], |point| (point, 0.0));
        let of_axis = |axis: &str| {
            let mut functions = functions.functions().to_vec();
            for function in &mut functions {
                function.response = function
                    .response
                    .to_string()
                    .replace("+Z", axis)
                    .parse()
                    .unwrap();
            }
            functions
        };
        let both = [of_axis("+Z"), of_axis("+Y")].concat();
        assert!(RunShifts::none(&both).positions.is_empty());
        assert_eq!(RunShifts::none(&of_axis("+Y")).positions.len(), 10);
    }
}

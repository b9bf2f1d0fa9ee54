//! Detection counts sum found, missed and spurious modes and their errors over identifications.

use crate::modal::{ModalModel, Mode, mac};

use super::score::{Judge, shape_at_responses};
use super::system::TrueMode;

/// Counts and errors of the identifications of one system. Errors are taken over the observable
/// modes that were found; an error is `None` where no such mode exists.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DetectionCounts {
    /// Identifications.
    pub runs: usize,
    /// Identifications that the method refused.
    pub refused: usize,
    /// Observable modes, summed.
    pub observable: usize,
    /// Observable modes that were found.
    pub found: usize,
    /// Spurious modes.
    pub spurious: usize,
    /// Found modes that have a bound.
    bounded: usize,
    /// Found modes whose shape has several components.
    shaped: usize,
    largest_frequency: f64,
    largest_damping: f64,
    frequency: f64,
    damping: f64,
    shape: f64,
    frequency_over_bound: f64,
    damping_over_bound: f64,
    frequency_bound: f64,
    damping_bound: f64,
}

impl DetectionCounts {
    /// Counts one identification; `None` for one that was refused.
    pub fn add(&mut self, judge: &Judge, found: Option<&ModalModel>) {
        self.runs += 1;
        let Some(found) = found else {
            self.refused += 1;
            self.observable += judge
                .detectability()
                .iter()
                .filter(|mode| mode.observable)
                .count();
            return;
        };
        let verdict = judge.verdict(found);
        self.observable += verdict.observable;
        self.spurious += verdict.spurious.len();
        for (r, detectability) in judge.detectability().iter().enumerate() {
            let partner = verdict.partner[r].filter(|_| detectability.observable);
            let Some(mode) = partner.map(|f| &found.modes[f]) else {
                continue;
            };
            let truth = &judge.system().modes[r];
            self.found += 1;
            let shape = shape_at_responses(judge.system(), mode);
            if shape.len() > 1 {
                self.shaped += 1;
                self.shape += 1.0 - mac(&truth.shape, &shape).unwrap_or(0.0);
            }
            self.add_pole(truth, mode);
            if let Some(bound) = detectability.bound {
                let [frequency, damping] = errors(truth, mode);
                self.bounded += 1;
                self.frequency_over_bound += (frequency / bound.frequency_hz).powi(2);
                self.damping_over_bound += (damping / bound.damping).powi(2);
                self.frequency_bound += (bound.frequency_hz / truth.hz()).powi(2);
                self.damping_bound += (bound.damping / truth.pole.damping_ratio()).powi(2);
            }
        }
    }

    fn add_pole(&mut self, truth: &TrueMode, mode: &Mode) {
        let [frequency, damping] = errors(truth, mode);
        let relative = [frequency / truth.hz(), damping / truth.pole.damping_ratio()];
        self.frequency += relative[0].powi(2);
        self.damping += relative[1].powi(2);
        self.largest_frequency = larger(self.largest_frequency, relative[0].abs());
        self.largest_damping = larger(self.largest_damping, relative[1].abs());
    }

    /// Adds the counts of other identifications.
    pub fn merge(&mut self, other: &Self) {
        self.runs += other.runs;
        self.refused += other.refused;
        self.observable += other.observable;
        self.found += other.found;
        self.spurious += other.spurious;
        self.bounded += other.bounded;
        self.shaped += other.shaped;
        self.largest_frequency = larger(self.largest_frequency, other.largest_frequency);
        self.largest_damping = larger(self.largest_damping, other.largest_damping);
        self.frequency += other.frequency;
        self.damping += other.damping;
        self.shape += other.shape;
        self.frequency_over_bound += other.frequency_over_bound;
        self.damping_over_bound += other.damping_over_bound;
        self.frequency_bound += other.frequency_bound;
        self.damping_bound += other.damping_bound;
    }

    /// Observable modes that were missed, and spurious ones.
    pub fn mistakes(&self) -> usize {
        self.observable - self.found + self.spurious
    }

    /// Largest relative error of a frequency.
    pub fn largest_frequency(&self) -> Option<f64> {
        (self.found > 0).then_some(self.largest_frequency)
    }

    /// Largest relative error of a damping ratio.
    pub fn largest_damping(&self) -> Option<f64> {
        (self.found > 0).then_some(self.largest_damping)
    }

    /// Rms relative error of the frequencies.
    pub fn frequency(&self) -> Option<f64> {
        rms(self.frequency, self.found)
    }

    /// Rms relative error of the damping ratios.
    pub fn damping(&self) -> Option<f64> {
        rms(self.damping, self.found)
    }

    /// Rms sine of the angle between shapes, `√(1 − MAC)`; one component has no angle.
    pub fn shape(&self) -> Option<f64> {
        rms(self.shape, self.shaped)
    }

    /// Rms error of the frequencies over their Cramér-Rao bound.
    pub fn frequency_over_bound(&self) -> Option<f64> {
        rms(self.frequency_over_bound, self.bounded)
    }

    /// Rms error of the damping ratios over their Cramér-Rao bound.
    pub fn damping_over_bound(&self) -> Option<f64> {
        rms(self.damping_over_bound, self.bounded)
    }

    /// Rms Cramér-Rao bound of the frequencies of the same modes, relative.
    pub fn frequency_bound(&self) -> Option<f64> {
        rms(self.frequency_bound, self.bounded)
    }

    /// Rms Cramér-Rao bound of the damping ratios of the same modes, relative.
    pub fn damping_bound(&self) -> Option<f64> {
        rms(self.damping_bound, self.bounded)
    }
}

/// Of natural frequency (Hz) and damping ratio; a mode without damping has that of 0.
fn errors(truth: &TrueMode, mode: &Mode) -> [f64; 2] {
    let damping = mode.damping_ratio.unwrap_or(0.0);
    [
        mode.frequency_hz - truth.hz(),
        damping - truth.pole.damping_ratio(),
    ]
}

/// The larger value; not a number where one is none.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

fn rms(sum: f64, count: usize) -> Option<f64> {
    (count > 0).then(|| (sum / count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::modal::{ModeShape, Pole, Scaling};
    use crate::quantity::FrfKind;
    use crate::study::System;
    use num_complex::Complex64;

    /// Three modes: one is found with errors of 0.1 % of the frequency and 10 % of the damping, one
    /// is missed, one lies outside the band; one found mode is spurious.
    #[test]
    fn errors_are_averaged_over_found_modes() {
        let dofs = ["1:+Z", "2:+Z"].map(|text| text.parse().unwrap());
        let mode = |hz: f64, shape: [f64; 2]| TrueMode {
            pole: Pole::from_frequency(hz, 0.01),
            shape: shape.map(Complex64::from).to_vec(),
            participation: vec![Complex64::new(0.0, -1.0)],
        };
        let system = System {
            modes: vec![
                mode(30.0, [1.0, 0.0]),
                mode(50.0, [1.0, 1.0]),
                mode(90.0, [1.0, -1.0]),
            ],
            axis: FrequencyAxis {
                start_hz: 20.0,
                step_hz: 0.05,
                len: 1201,
            },
            band: Band::new(20.0, 80.0).unwrap(),
            kind: FrfKind::Receptance,
            responses: dofs.to_vec(),
            references: dofs[..1].to_vec(),
            record_end_s: None,
        };
        let exact = system.exact().unwrap();
        let judge = Judge::new(&system, &system.variances(&exact, 60.0));
        let found = |hz: f64, shape: [f64; 2]| {
            let values = dofs.iter().cloned().zip(shape.map(Complex64::from));
            Mode::new(hz, Some(0.011), ModeShape::new(values), Scaling::Unknown)
        };
        let model = ModalModel {
            modes: vec![found(30.03, [2.0, 0.0]), found(65.0, [1.0, 1.0])],
            ..ModalModel::default()
        };
        let mut counts = DetectionCounts::default();
        counts.add(&judge, Some(&model));
        // The mode at 90 Hz lies outside the band.
        assert_eq!(
            (counts.observable, counts.found, counts.spurious),
            (2, 1, 1)
        );
        assert_eq!(counts.mistakes(), 2);
        assert!((counts.frequency().unwrap() - 1e-3).abs() < 1e-12);
        assert!((counts.damping().unwrap() - 0.1).abs() < 1e-12);
        assert!(counts.shape().unwrap() < 1e-7);
        let largest = [counts.largest_frequency(), counts.largest_damping()];
        assert_eq!(largest, [counts.frequency(), counts.damping()]);
        let bound = judge.detectability()[0].bound.unwrap();
        let over = counts.frequency_over_bound().unwrap();
        assert!((over * bound.frequency_hz - 0.03).abs() < 1e-12);
        let mut both = counts;
        let mut refused = DetectionCounts::default();
        refused.add(&judge, None);
        both.merge(&refused);
        assert_eq!(
            (both.runs, both.refused, both.observable, both.found),
            (2, 1, 4, 1)
        );
        assert_eq!(both.frequency(), counts.frequency());
        assert_eq!(refused.frequency(), None);
    }
}

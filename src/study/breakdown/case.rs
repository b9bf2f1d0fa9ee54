//! Every draw measures the same small structure: a pair of modes and a distant third one, on a
//! line of sensors.

use serde::{Deserialize, Serialize};

use crate::axis::Band;
use crate::dof::Dof;
use crate::modal::{ModalModel, Mode, ModeShape, Pole, Scaling};
use crate::quantity::FrfKind;
use crate::synth::{SynthError, Truth};

use super::Factor;

/// Parameters of a draw, fixed where a slice does not vary them.
///
/// Modes lie at `f_1`, `f_2 = f_1 + s·2ζf_1` and `f_3 = f_2 + g`, all with the damping ratio ζ.
/// Shapes are `sin(rπx)` at `responses` sensors `x = k/(n + 1)` of a supported line, of unit modal
/// mass; the first, last and third sensor are hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// `f_1`, Hz.
    pub lowest_hz: f64,
    /// ζ.
    pub damping: f64,
    /// s, half-power widths.
    pub separation: f64,
    /// g, Hz.
    pub gap_hz: f64,
    /// n.
    pub responses: usize,
    /// Points hit, 1 to 3.
    pub references: usize,
    /// Lines of the band, where FRFs are drawn directly.
    pub lines: usize,
    /// Signal-to-noise ratio of FRFs or responses, dB.
    pub noise_db: f64,
    /// Component of the second mode at the first hit, as a share of its largest; that of its shape
    /// without it.
    pub node_distance: Option<f64>,
    /// Highest model order of the methods that have one; chosen by the method without it.
    pub order: Option<usize>,
    /// Record after the hit, time constants of the first mode.
    pub record_length: f64,
    /// Hits for each function.
    pub hits: usize,
    /// Signal-to-noise ratio of the force, dB.
    pub force_noise_db: f64,
    /// Drift over roving positions, half-power widths of the first mode; all sensors at once
    /// where 0.
    pub mass_loading: f64,
    /// Share of hits with a second contact.
    pub second_contacts: f64,
    /// Bits of the converter; none without it.
    pub bits: Option<u32>,
    /// End value of the exponential window; chosen by the estimation without it.
    pub window_end: Option<f64>,
}

impl Default for Case {
    /// 100 Hz, 1 %, five half-power widths, 60 Hz to the third mode; 4 responses, 1 reference, 300
    /// lines; 50 dB; 10 time constants, 3 hits, 70 dB of force.
    fn default() -> Self {
        Self {
            lowest_hz: 100.0,
            damping: 0.01,
            separation: 5.0,
            gap_hz: 60.0,
            responses: 4,
            references: 1,
            lines: 300,
            noise_db: 50.0,
            node_distance: None,
            order: None,
            record_length: 10.0,
            hits: 3,
            force_noise_db: 70.0,
            mass_loading: 0.0,
            second_contacts: 0.0,
            bits: None,
            window_end: None,
        }
    }
}

/// Modes of the case.
pub const MODES: usize = 3;
/// Share of the lowest frequency that the band reaches below it and beyond the highest mode.
const BAND_MARGIN_OF_LOWEST_FREQUENCY: f64 = 0.4;

impl Case {
    /// The case with a factor at a value.
    pub fn with(mut self, factor: Factor, value: f64) -> Self {
        let whole = value.round() as usize;
        match factor {
            Factor::Noise => self.noise_db = value,
            Factor::Separation => self.separation = value,
            Factor::Damping => self.damping = value,
            Factor::RecordLength => self.record_length = value,
            Factor::Hits => self.hits = whole,
            Factor::References => self.references = whole,
            Factor::NodeDistance => self.node_distance = Some(value),
            Factor::MassLoading => self.mass_loading = value,
            Factor::SecondContacts => self.second_contacts = value,
            Factor::Quantisation => self.bits = Some(whole as u32),
            Factor::ForceNoise => self.force_noise_db = value,
            Factor::ExponentialWindow => self.window_end = Some(value),
            Factor::Order => self.order = Some(whole),
        }
        self
    }

    /// The value of a factor; `None` where the case leaves it open.
    pub fn value(&self, factor: Factor) -> Option<f64> {
        match factor {
            Factor::Noise => Some(self.noise_db),
            Factor::Separation => Some(self.separation),
            Factor::Damping => Some(self.damping),
            Factor::RecordLength => Some(self.record_length),
            Factor::Hits => Some(self.hits as f64),
            Factor::References => Some(self.references as f64),
            Factor::NodeDistance => self.node_distance,
            Factor::MassLoading => Some(self.mass_loading),
            Factor::SecondContacts => Some(self.second_contacts),
            Factor::Quantisation => self.bits.map(f64::from),
            Factor::ForceNoise => Some(self.force_noise_db),
            Factor::ExponentialWindow => self.window_end,
            Factor::Order => self.order.map(|order| order as f64),
        }
    }

    /// Half-power width of the first mode, Hz.
    pub fn width_hz(&self) -> f64 {
        2.0 * self.damping * self.lowest_hz
    }

    /// Natural frequencies, Hz.
    pub fn frequencies_hz(&self) -> [f64; MODES] {
        let second = self.lowest_hz + self.separation * self.width_hz();
        [self.lowest_hz, second, second + self.gap_hz]
    }

    /// Where modes are searched.
    pub fn band(&self) -> Band {
        let [first, _, last] = self.frequencies_hz();
        let margin = BAND_MARGIN_OF_LOWEST_FREQUENCY * self.lowest_hz;
        Band {
            lo_hz: first - margin,
            hi_hz: last + margin,
        }
    }

    /// Time constant of the first mode, s.
    pub fn time_constant_s(&self) -> f64 {
        let pole = Pole::from_frequency(self.lowest_hz, self.damping);
        -1.0 / pole.lambda.re
    }

    /// The sensors.
    pub fn responses(&self) -> Vec<Dof> {
        (1..=self.responses).map(dof).collect()
    }

    /// The points that are hit: both ends of the line, then its third sensor. There the pair's
    /// shapes are independent.
    pub fn hits(&self) -> Vec<Dof> {
        let numbers = [1, self.responses, 3];
        numbers[..self.references].iter().map(|n| dof(*n)).collect()
    }

    /// Components of a mode, from 0, at the sensors, unit modal mass of a line of 1 kg.
    fn shape(&self, mode: usize) -> Vec<f64> {
        let position = |k: usize| (k + 1) as f64 / (self.responses + 1) as f64;
        let wave = |k: usize| (std::f64::consts::PI * (mode + 1) as f64 * position(k)).sin();
        let mut shape: Vec<f64> = (0..self.responses)
            .map(|k| std::f64::consts::SQRT_2 * wave(k))
            .collect();
        if let (1, Some(distance)) = (mode, self.node_distance) {
            let largest = shape.iter().fold(0.0, |a: f64, c| a.max(c.abs()));
            shape[0] = distance * largest;
        }
        shape
    }

    /// The truth with all frequencies shifted, Hz, and scaled.
    ///
    /// # Errors
    /// [`SynthError`] for numbers that make no mode.
    pub fn truth(&self, shift_hz: f64, factor: f64) -> Result<Truth, SynthError> {
        let dofs = self.responses();
        let mode = |(r, hz): (usize, f64)| {
            let shape = self.shape(r).into_iter().map(|c| c.into());
            let shape = ModeShape::new(dofs.iter().cloned().zip(shape));
            let hz = (hz + shift_hz) * factor;
            Mode::new(hz, Some(self.damping), shape, Scaling::UnitModalMass)
        };
        let modes = self.frequencies_hz().into_iter().enumerate().map(mode);
        let model = ModalModel {
            modes: modes.collect(),
            ..ModalModel::default()
        };
        Truth::from_real_shapes(&model, &dofs, &self.hits())
    }

    /// The kind of FRF that is drawn.
    pub fn kind() -> FrfKind {
        FrfKind::Accelerance
    }
}

fn dof(number: usize) -> Dof {
    let text = format!("{number}:+Z");
    text.parse()
        .expect("a number and an axis are a degree of freedom")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_has_the_stated_separation_and_the_third_mode_its_gap() {
        let case = Case::default()
            .with(Factor::Separation, 2.0)
            .with(Factor::Damping, 0.02);
        let truth = case.truth(0.5, 1.0).unwrap();
        let hz: Vec<f64> = truth.model.modes.iter().map(|m| m.frequency_hz).collect();
        for (found, expected) in hz.iter().zip([100.5, 108.5, 168.5]) {
            assert!((found - expected).abs() < 1e-9, "{hz:?}");
        }
        assert!(case.band().contains(60.5) && case.band().contains(208.0));
        assert_eq!(truth.model.modes[0].residues.len(), 4);
    }

    #[test]
    fn every_factor_is_set_and_read_back() {
        for factor in super::super::FACTORS {
            let value = factor.limits().1.min(3.0);
            let case = Case::default().with(factor, value);
            assert_eq!(case.value(factor), Some(value), "{}", factor.name());
        }
    }

    #[test]
    fn a_hit_near_a_node_moves_the_second_mode_little() {
        let case = Case::default().with(Factor::NodeDistance, 0.05);
        let truth = case.truth(0.0, 1.0).unwrap();
        let at = |r: usize| truth.model.modes[r].shape.get(&dof(1)).unwrap().re;
        let largest = |r: usize| truth.model.modes[r].shape.largest().unwrap().1.norm();
        assert!((at(1) / largest(1) - 0.05).abs() < 1e-12);
        assert!(at(0) / largest(0) > 0.4);
    }

    /// With both ends hit the pair's participation factors are orthogonal: noise alone hides a
    /// repeated root.
    #[test]
    fn two_references_separate_the_pair() {
        let case = Case::default();
        let (a, b) = (case.shape(0), case.shape(1));
        assert!((a[0] * b[0] + a[3] * b[3]).abs() < 1e-12);
    }
}

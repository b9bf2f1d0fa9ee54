//! A factor is a quantity that a slice varies, with its unit and limits.

use serde::{Deserialize, Serialize};

/// What an axis of a slice varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// Signal-to-noise ratio: of the FRFs (rms over the band over rms noise of a line), or, where
    /// the slice needs a hammer test, of the responses (rms of the record over rms noise), dB.
    Noise,
    /// Distance of the pair in half-power widths.
    Separation,
    /// Damping ratio of all modes.
    Damping,
    /// Record after the hit, in time constants `1/(ζω)` of the lowest mode.
    RecordLength,
    /// Hits averaged for each function.
    Hits,
    /// References: points that are hit.
    References,
    /// Component of the pair's upper mode at the first hit point, as a share of its largest: its
    /// distance from a node.
    NodeDistance,
    /// Drift of all frequencies between the first and last position of a roving sensor, in
    /// half-power widths of the lowest mode.
    MassLoading,
    /// Share of the hits that have a second contact.
    SecondContacts,
    /// Bits of the converter, whose full scale is four times the largest sample.
    Quantisation,
    /// Signal-to-noise ratio of the force: peak over rms noise, dB.
    ForceNoise,
    /// Value of the exponential window at the end of the record; 1 is none.
    ExponentialWindow,
    /// Highest model order of the methods that have one.
    Order,
}

/// All factors.
pub const FACTORS: [Factor; 13] = [
    Factor::Noise,
    Factor::Separation,
    Factor::Damping,
    Factor::RecordLength,
    Factor::Hits,
    Factor::References,
    Factor::NodeDistance,
    Factor::MassLoading,
    Factor::SecondContacts,
    Factor::Quantisation,
    Factor::ForceNoise,
    Factor::ExponentialWindow,
    Factor::Order,
];

impl Factor {
    /// Its name in `study.toml` and in CSV.
    pub fn name(self) -> &'static str {
        match self {
            Factor::Noise => "noise",
            Factor::Separation => "separation",
            Factor::Damping => "damping",
            Factor::RecordLength => "record_length",
            Factor::Hits => "hits",
            Factor::References => "references",
            Factor::NodeDistance => "node_distance",
            Factor::MassLoading => "mass_loading",
            Factor::SecondContacts => "second_contacts",
            Factor::Quantisation => "quantisation",
            Factor::ForceNoise => "force_noise",
            Factor::ExponentialWindow => "exponential_window",
            Factor::Order => "order",
        }
    }

    /// Label of an axis, with the unit; `in_test`: the slice draws hammer tests.
    pub fn label(self, in_test: bool) -> &'static str {
        match self {
            Factor::Noise if in_test => "Signal-to-noise ratio of the responses (dB)",
            Factor::Noise => "Signal-to-noise ratio of the FRFs (dB)",
            Factor::Separation => "Separation of the pair (half-power widths)",
            Factor::Damping => "Damping ratio (-)",
            Factor::RecordLength => "Record length (time constants)",
            Factor::Hits => "Hits averaged",
            Factor::References => "References (hit points)",
            Factor::NodeDistance => {
                "Distance of the hit from a node (share of the largest component)"
            }
            Factor::MassLoading => "Drift over roving positions (half-power widths)",
            Factor::SecondContacts => "Share of hits with a second contact",
            Factor::Quantisation => "Converter (bits)",
            Factor::ForceNoise => "Signal-to-noise ratio of the force (dB)",
            Factor::ExponentialWindow => "Exponential window at the record's end (1: none)",
            Factor::Order => "Highest model order",
        }
    }

    /// Unit of distances on a linear axis of it.
    pub fn unit(self) -> &'static str {
        match self {
            Factor::Noise | Factor::ForceNoise => "dB",
            Factor::Separation | Factor::MassLoading => "half-power widths",
            Factor::RecordLength => "time constants",
            Factor::Hits => "hits",
            Factor::References => "references",
            Factor::Quantisation => "bits",
            Factor::Order => "orders",
            Factor::Damping
            | Factor::NodeDistance
            | Factor::SecondContacts
            | Factor::ExponentialWindow => "",
        }
    }

    /// Whether its values are whole numbers.
    pub fn is_whole(self) -> bool {
        matches!(
            self,
            Factor::Hits | Factor::References | Factor::Quantisation | Factor::Order
        )
    }

    /// Whether it is a property of the recording, so that a hammer test has to be drawn; for other
    /// factors FRFs with white noise are enough.
    pub fn needs_test(self) -> bool {
        matches!(
            self,
            Factor::RecordLength
                | Factor::Hits
                | Factor::MassLoading
                | Factor::SecondContacts
                | Factor::Quantisation
                | Factor::ForceNoise
                | Factor::ExponentialWindow
        )
    }

    /// Smallest and largest value that can be drawn.
    pub fn limits(self) -> (f64, f64) {
        match self {
            Factor::Noise | Factor::ForceNoise => (-20.0, 200.0),
            Factor::Separation => (0.0, 20.0),
            Factor::Damping => (1e-4, 0.2),
            Factor::RecordLength => (0.2, 100.0),
            Factor::Hits => (1.0, 100.0),
            Factor::References => (1.0, 3.0),
            Factor::NodeDistance => (0.0, 1.0),
            Factor::MassLoading => (0.0, 20.0),
            Factor::SecondContacts => (0.0, 1.0),
            Factor::Quantisation => (4.0, 32.0),
            Factor::ExponentialWindow => (1e-12, 1.0),
            Factor::Order => (4.0, 100.0),
        }
    }
}

/// How values lie between the ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal ratios.
    Log,
}

/// An axis of a slice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// What varies.
    pub factor: Factor,
    /// First value.
    pub lo: f64,
    /// Last value.
    pub hi: f64,
    /// Values of the unrefined grid, 2 or more.
    pub count: usize,
    /// How they lie.
    pub scale: Scale,
}

impl Axis {
    /// The value at a share of the axis, 0 to 1; a whole number where the factor has those.
    pub fn at(&self, share: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => self.lo + share * (self.hi - self.lo),
            Scale::Log => self.lo * (self.hi / self.lo).powf(share),
        };
        if self.factor.is_whole() {
            value.round()
        } else {
            value
        }
    }

    /// The share of the axis at which a value lies; outside 0 to 1 beyond the ends, minus infinity
    /// for 0 on a logarithmic axis; `None` for no number.
    pub fn share(&self, value: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear => (value - self.lo) / (self.hi - self.lo),
            Scale::Log => (value / self.lo).ln() / (self.hi / self.lo).ln(),
        };
        (!share.is_nan()).then_some(share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_spec_and_unique() {
        for factor in FACTORS {
            let text = serde_json::to_string(&factor).unwrap();
            assert_eq!(text, format!("{:?}", factor.name()));
            let same = FACTORS.iter().filter(|other| other.name() == factor.name());
            assert_eq!(same.count(), 1);
            let (lo, hi) = factor.limits();
            assert!(lo < hi);
        }
    }

    #[test]
    fn values_and_shares_are_inverse_and_whole_where_they_should() {
        let log = Axis {
            factor: Factor::Damping,
            lo: 1e-3,
            hi: 0.1,
            count: 5,
            scale: Scale::Log,
        };
        assert!((log.at(0.5) - 0.01).abs() < 1e-15);
        assert!((log.share(0.01).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(log.share(0.0), Some(f64::NEG_INFINITY));
        assert_eq!(log.share(f64::NAN), None);
        let whole = Axis {
            factor: Factor::Hits,
            lo: 1.0,
            hi: 8.0,
            count: 8,
            scale: Scale::Linear,
        };
        assert!((whole.at(0.5) - 5.0).abs() < 1e-15);
    }
}

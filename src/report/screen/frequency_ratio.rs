//! Lowest frequencies of a model over those of tests of which no mode has a partner: a unit of the
//! model may be wrong.

use std::f64::consts::TAU;

use crate::modal::{Grade, Mode};
use crate::report::table::significant;
use crate::scene::SceneResult;

/// Minimum factor between the lowest frequencies of model and test that points at a unit. Larger,
/// at 50: a density in g/cm³, 32 times the frequency, is not named. Smaller, at 3: a beam of wrong
/// length passes for one of a wrong unit. Test `a_wrong_unit_of_the_model_is_named`.
const MIN_FACTOR_OF_A_UNIT: f64 = 10.0;

/// The elastic modes of a model and the good modes of its tests, none of which is paired.
pub(super) struct FrequencyRatio {
    model_hz: (f64, f64),
    test_hz: (f64, f64),
    /// Whether no mode of the model lies in the band of a test.
    is_band_empty: bool,
}

/// The frequencies of model and tests; `None` where a mode is paired, and where the model has no
/// mode or the tests no good one.
pub(super) fn frequency_ratio(result: &SceneResult) -> Option<FrequencyRatio> {
    let table = result.table.as_ref().filter(|table| table.is_empty())?;
    let of_roots = result.theory.roots.iter();
    let of_roots = of_roots.map(|root| root.omega_rad_s / TAU);
    let of_modes = result.theory.modes.modes.iter();
    let of_modes = of_modes.map(|mode| mode.frequency_hz);
    let in_band = |count: usize| count == 0;
    let mut tests = table.summary.iter();
    let is_band_empty =
        tests.all(|test| in_band(test.missed + test.not_observable + test.paired + test.ambiguous));
    // Doubtful modes are often those of the suspension.
    let is_good = |mode: &&Mode| {
        let quality = mode.quality.as_ref();
        quality.is_none_or(|quality| quality.verdict == Grade::Good)
    };
    let of_tests = result.tests.iter().flat_map(|test| &test.modes.modes);
    let of_tests = of_tests.filter(is_good);
    Some(FrequencyRatio {
        model_hz: range(of_roots.chain(of_modes))?,
        test_hz: range(of_tests.map(|mode| mode.frequency_hz))?,
        is_band_empty,
    })
}

/// The smallest and the largest positive frequency.
fn range(all: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let positive = all.filter(|hz| *hz > 0.0);
    positive.fold(None, |range, hz| match range {
        None => Some((hz, hz)),
        Some((lo, hi)) => Some((hz.min(lo), hz.max(hi))),
    })
}

impl FrequencyRatio {
    fn factor(&self) -> f64 {
        self.model_hz.0 / self.test_hz.0
    }

    /// Whether the frequencies differ as far as by a unit.
    pub(super) fn is_of_a_unit(&self) -> bool {
        self.factor().max(1.0 / self.factor()) >= MIN_FACTOR_OF_A_UNIT
    }

    /// Where the modes of model and tests lie; `None` where the model has some in a band and they
    /// differ by less than a unit does.
    pub(super) fn sentence(&self) -> Option<String> {
        let hz = |value: f64| significant(value, 4);
        let span = |(lo, hi): (f64, f64)| format!("{} to {} Hz", hz(lo), hz(hi));
        let (model, test) = (span(self.model_hz), span(self.test_hz));
        let of_a_unit = self.is_of_a_unit();
        let what = match self.is_band_empty {
            true => "The model has no mode in the band of a test",
            false if of_a_unit => "The model is far from the test",
            false => return None,
        };
        let unit = match of_a_unit {
            true => format!(
                " Its lowest is {} times that of the test: a unit of the model may be wrong.",
                significant(self.factor(), 3)
            ),
            false => String::new(),
        };
        Some(format!(
            "{what}: modes of the model from {model}, of the test from {test}.{unit}"
        ))
    }
}

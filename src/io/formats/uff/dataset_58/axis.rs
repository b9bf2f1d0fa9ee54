//! The abscissa of a header of dataset 58: what it measures, and an even axis where there is one.
//! No I/O.
//!
//! A time step printed with few digits is put right where one whole number of samples per second,
//! and only one, lies within its rounding. A note of modalign among the ID lines gives start and
//! step to the bit; it is used where it agrees with the printed values. Abscissae printed value by
//! value are an even axis where every one of them lies within the rounding of its place (and that
//! of the first).

use super::{Header, Spacing};
use crate::axis::{FrequencyAxis, TimeAxis};
use crate::io::{Domain, EntryAxis, GeneralAxis};
use crate::quantity::{frequency_factor, rotation_factor, time_factor};

/// Smallest relative change of the step by a restored sampling rate that is reported.
const MIN_REPORTED_STEP_CHANGE: f64 = 1e-9;
/// Roundings count where they are smaller than this part of the step at the start of the axis; else
/// values must lie on the grid itself.
const ROUNDING_PER_STEP: f64 = 1e-2;

/// An axis, and the sampling rate that was restored for it, when it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io::formats::uff) struct Axis {
    pub axis: EntryAxis,
    pub restored_rate_hz: Option<f64>,
}

/// Values of an uneven abscissa as stored, with how exactly each was printed (half a unit of its
/// last digit).
#[derive(Clone, Debug, Default)]
pub(in crate::io::formats::uff) struct Abscissae {
    pub values: Vec<f64>,
    pub half_units: Vec<f64>,
}

/// The quantity of the abscissa, and its factor to seconds or hertz. A unit that is not known
/// leaves the stored values and the type of the header unchanged, so that they are not taken for
/// seconds or hertz.
pub(in crate::io::formats::uff) fn domain(header: &Header) -> (Domain, f64) {
    let unit = header.abscissa.unit.trim_matches(['(', ')', '[', ']']);
    let unit = unit.trim();
    let function_type = header.function_type;
    let found = match header.abscissa.code {
        17 => time_scale(unit).map(|scale| (Domain::Time, scale)),
        18 => frequency_scale(unit)
            .or_else(|| rotation_factor(unit))
            .map(|scale| (Domain::Frequency, scale)),
        // The unit decides, then the function type: correlations are over time; spectra, FRFs and
        // coherences over frequency.
        0 | 1 => match function_type {
            1 | 7 | 8 if unit.is_empty() => Some((Domain::Time, 1.0)),
            2..=6 | 9 if unit.is_empty() => Some((Domain::Frequency, 1.0)),
            _ if unit.is_empty() => None,
            _ => time_scale(unit)
                .map(|scale| (Domain::Time, scale))
                .or_else(|| frequency_scale(unit).map(|scale| (Domain::Frequency, scale))),
        },
        _ => None,
    };
    let code = i32::try_from(header.abscissa.code).unwrap_or(0);
    found.unwrap_or((Domain::Other(code), 1.0))
}

/// Whether the header says time or frequency, and its unit is not known.
pub(in crate::io::formats::uff) fn has_unknown_unit(header: &Header) -> bool {
    matches!(domain(header).0, Domain::Other(17 | 18))
}

/// Factor to seconds, the default unit of the format where the text is empty.
fn time_scale(unit: &str) -> Option<f64> {
    match unit {
        "" => Some(1.0),
        unit => time_factor(unit),
    }
}

/// Factor to hertz, the default unit of the format where the text is empty.
fn frequency_scale(unit: &str) -> Option<f64> {
    match unit {
        "" => Some(1.0),
        unit => frequency_factor(unit),
    }
}

/// An evenly spaced axis; `note` is start and step in the note of modalign. `None` for several
/// values at one place.
pub(super) fn even_axis(
    domain: Domain,
    scale: f64,
    len: usize,
    printed: &Spacing,
    note: Option<(f64, f64)>,
) -> Option<Axis> {
    let (start, step) = (printed.start * scale, printed.step * scale);
    let half = |half_unit: Option<f64>| half_unit.map(|half| half * scale);
    let (start_half, step_half) = (half(printed.start_half_unit), half(printed.step_half_unit));
    let agrees = |exact: f64, rounded: f64, half: Option<f64>| {
        half.is_some_and(|half| (exact - rounded).abs() <= half * (1.0 + 1e-6))
    };
    let noted = note
        .filter(|(first, by)| agrees(*first, start, start_half) && agrees(*by, step, step_half));
    if let Some((start, step)) = noted {
        return axis(domain, start, step, len);
    }
    let rate = step_half.and_then(|half| whole_rate(step, half));
    match rate.filter(|_| domain == Domain::Time) {
        Some(rate) => axis(domain, start, 1.0 / rate, len).map(|even| Axis {
            restored_rate_hz: Some(rate)
                .filter(|rate| (step * rate - 1.0).abs() > MIN_REPORTED_STEP_CHANGE),
            ..even
        }),
        None => axis(domain, start, step, len),
    }
}

fn axis(domain: Domain, start: f64, step: f64, len: usize) -> Option<Axis> {
    let meaningful = start.is_finite() && step.is_finite() && (step.abs() > 0.0 || len < 2);
    let axis = match domain {
        Domain::Time if step > 0.0 => EntryAxis::Time(TimeAxis {
            start_s: start,
            step_s: step,
            len,
        }),
        Domain::Frequency if step > 0.0 => EntryAxis::Frequency(FrequencyAxis {
            start_hz: start,
            step_hz: step,
            len,
        }),
        _ => EntryAxis::General(GeneralAxis {
            domain,
            even: Some((start, step)),
            len,
        }),
    };
    meaningful.then_some(Axis {
        axis,
        restored_rate_hz: None,
    })
}

/// The axis of abscissae that stand before each value: even where they are time or frequency on an
/// even grid.
pub(super) fn uneven_axis(domain: Domain, scale: f64, abscissae: &Abscissae) -> EntryAxis {
    let general = EntryAxis::General(GeneralAxis {
        domain,
        even: None,
        len: abscissae.values.len(),
    });
    if matches!(domain, Domain::Other(_)) {
        return general;
    }
    let grid = even_grid(abscissae).map(|(start, low, high)| {
        let rate = (domain == Domain::Time)
            .then(|| only_rate(low * scale, high * scale))
            .flatten();
        let step = rate.map_or_else(|| shortest_between(low, high) * scale, |rate| 1.0 / rate);
        (start * scale, step)
    });
    grid.and_then(|(start, step)| axis(domain, start, step, abscissae.values.len()))
        .map_or(general, |even| even.axis)
}

/// Start, and the smallest and largest step of the even grids on which all values lie within their
/// rounding.
fn even_grid(abscissae: &Abscissae) -> Option<(f64, f64, f64)> {
    let (first, last) = (*abscissae.values.first()?, *abscissae.values.last()?);
    let intervals = abscissae.values.len().checked_sub(1).filter(|n| *n > 0)?;
    let mean = (last - first) / intervals as f64;
    let exact = 4.0 * f64::EPSILON * first.abs().max(last.abs());
    if mean <= exact {
        return None;
    }
    // A first value of zero is no rounded number.
    let is_rounded = |i: usize| i > 0 || first.abs() > 0.0;
    let half_unit = |i: usize| abscissae.half_units.get(i).copied().unwrap_or(0.0);
    let rounding = |i: usize| if is_rounded(i) { half_unit(i) } else { 0.0 };
    let counts = rounding(0) + rounding(1) <= ROUNDING_PER_STEP * mean;
    let (mut low, mut high) = (0.0_f64, f64::INFINITY);
    for (i, value) in abscissae.values.iter().enumerate().skip(1) {
        let printed = if counts {
            rounding(0) + rounding(i)
        } else {
            0.0
        };
        let reach = printed.max(exact);
        low = low.max((value - first - reach) / i as f64);
        high = high.min((value - first + reach) / i as f64);
    }
    (first.is_finite() && high.is_finite() && high > 0.0 && low <= high)
        .then_some((first, low, high))
}

/// The number with the fewest digits that is not below `low` nor above `high`.
fn shortest_between(low: f64, high: f64) -> f64 {
    let middle = low + (high - low) / 2.0;
    let rounded = |digits: usize| format!("{middle:.digits$e}").parse::<f64>().ok();
    (0..17)
        .filter_map(rounded)
        .find(|step| (low..=high).contains(step) && *step > 0.0)
        .unwrap_or(middle)
}

/// The whole number of samples per second whose step prints as `step`, when there is one and no
/// other.
fn whole_rate(step: f64, half_unit: f64) -> Option<f64> {
    // A step that ends in 5 lies on the edge itself (1.953125E-05 prints as 1.95313E-05), where
    // rounding must not lose it.
    let half = half_unit * (1.0 + 1e-6);
    (half < step)
        .then(|| only_rate(step - half, step + half))
        .flatten()
}

/// The whole number of samples per second with a step from `low` to `high`, when there is one and
/// no other.
fn only_rate(low: f64, high: f64) -> Option<f64> {
    let first = (1.0 / high).ceil();
    let last = (1.0 / low).floor();
    // Both are whole numbers, and so is their difference.
    ((last - first).abs() < 0.5 && first >= 1.0).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::formats::uff::fields::half_unit;

    fn rate(printed: &str) -> Option<f64> {
        let half = half_unit(printed.as_bytes()).unwrap();
        whole_rate(printed.parse().unwrap(), half)
    }

    #[test]
    fn every_common_rate_comes_back_from_six_digits() {
        // Up to 90 kHz six digits always distinguish one rate from the next; above, only the common
        // rates are distinguished.
        for hz in (1..=90_000).chain([96_000, 102_400, 131_072, 192_000, 204_800, 262_144]) {
            let hz = f64::from(hz);
            let printed = format!("{:.5E}", 1.0 / hz);
            assert_eq!(
                rate(&printed).map(f64::to_bits),
                Some(hz.to_bits()),
                "{printed}"
            );
        }
    }

    #[test]
    fn ambiguous_steps_restore_no_sampling_rate() {
        // 1/3 s is 3 Hz; 0.3 s is none; with two digits or fewer many rates fit, or none does.
        assert_eq!(rate("3.33333E-01").map(f64::to_bits), Some(3f64.to_bits()));
        for printed in ["3.00000E-01", "1.0E-05", "0.01", "0.0", "4.88210E-04"] {
            assert_eq!(rate(printed), None, "{printed}");
        }
    }

    fn printed(values: impl Iterator<Item = f64>) -> Abscissae {
        let texts: Vec<String> = values.map(|value| format!("{value:.5E}")).collect();
        Abscissae {
            values: texts.iter().map(|text| text.parse().unwrap()).collect(),
            half_units: texts
                .iter()
                .map(|text| half_unit(text.as_bytes()).unwrap())
                .collect(),
        }
    }

    fn step(domain: Domain, abscissae: &Abscissae) -> Option<f64> {
        uneven_axis(domain, 1.0, abscissae)
            .even()
            .map(|even| even.1)
    }

    #[test]
    fn a_printed_grid_is_even_and_one_with_a_shifted_value_is_not() {
        let count = 200_000;
        let time = printed((0..count).map(|i| -0.05 + f64::from(i) / 51_200.0));
        assert_eq!(step(Domain::Time, &time), Some(1.0 / 51_200.0));
        let lines = printed((0..6_401).map(|i| 0.1953125 * f64::from(i)));
        assert_eq!(step(Domain::Frequency, &lines), Some(0.1953125));
        assert_eq!(step(Domain::Other(18), &lines), None);
        for place in [1, 2, 3_000, 6_400] {
            let mut moved = lines.clone();
            moved.values[place] += 3.0 * moved.half_units[place].max(moved.half_units[1]);
            assert_eq!(step(Domain::Frequency, &moved), None, "{place}");
        }
    }

    #[test]
    fn coarse_numbers_are_a_grid_only_when_they_lie_on_it() {
        let whole = |values: &[f64]| Abscissae {
            values: values.to_vec(),
            half_units: vec![0.5; values.len()],
        };
        assert_eq!(step(Domain::Time, &whole(&[1.0, 2.0, 3.0])), Some(1.0));
        for values in [
            &[1.0, 2.0, 3.0, 5.0][..],
            &[3.0, 2.0, 1.0],
            &[1.0, 1.0],
            &[1.0],
            &[],
        ] {
            assert_eq!(step(Domain::Time, &whole(values)), None, "{values:?}");
        }
    }

    #[test]
    fn a_note_is_believed_where_it_agrees() {
        let exact = (0.1 + 0.2, 1.0 / 3.0);
        let spacing = Spacing {
            start: 0.3,
            step: 0.333333,
            start_half_unit: Some(5e-7),
            step_half_unit: Some(5e-7),
        };
        let even = |note| {
            let axis = even_axis(Domain::Frequency, 1.0, 8, &spacing, note);
            axis.unwrap().axis.even()
        };
        assert_eq!(even(Some(exact)), Some(exact));
        assert_eq!(even(Some((0.3, 0.4))), Some((0.3, 0.333333)));
        assert_eq!(even(None), Some((0.3, 0.333333)));
    }

    #[test]
    fn a_nonpositive_step_makes_no_even_axis() {
        let general = |domain, step, len| {
            let spacing = Spacing {
                start: 5.0,
                step,
                start_half_unit: None,
                step_half_unit: None,
            };
            even_axis(domain, 1.0, len, &spacing, None).map(|even| even.axis)
        };
        for (domain, step, len) in [(Domain::Time, -1.0, 3), (Domain::Frequency, 0.0, 1)] {
            let even = Some((5.0, step));
            let expected = EntryAxis::General(GeneralAxis { domain, even, len });
            assert_eq!(general(domain, step, len), Some(expected));
        }
        assert_eq!(general(Domain::Time, 0.0, 2), None);
        assert_eq!(general(Domain::Other(19), 0.0, 2), None);
    }
}

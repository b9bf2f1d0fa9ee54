//! The transform of a real record has a value at every multiple of the line spacing up to the
//! sampling rate; above half of it H(f_s − f) = H(f)* repeats the lower half.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;

/// Largest sum of squares of `H(f_s − f) − H(f)*` over that of both sides. Numbers printed with
/// four digits leave 1e-7. Larger: no FRF of one side is near, since its halves have nothing to do
/// with each other (`the_upper_half_of_one_sided_functions_is_kept`). Smaller: a file of few digits
/// keeps its mirror images, and every mode is found twice.
const MAX_DIFFERENCE: f64 = 1e-5;

/// The set without the upper half of its lines, with a finding, where all functions are two-sided;
/// else the set as it is.
pub(super) fn one_sided(set: FrfSet) -> FrfSet {
    let axis = set.axis();
    // The first line is that of 0 Hz, or the one behind it.
    let first = (axis.start_hz / axis.step_hz).round();
    let starts_at_zero = (0.0..=1.0).contains(&first)
        && (axis.start_hz - first * axis.step_hz).abs() < 1e-3 * axis.step_hz;
    // Numbers of a line and its mirror image add up to the last line, or to the one behind it.
    let sums = [axis.len, axis.len.saturating_sub(1)];
    let is_mirrored = |sum: usize| {
        let functions = (0..set.len()).map(|i| set.values(i));
        let mut live = functions.filter(|values| values.iter().any(|v| v.norm_sqr() > 0.0));
        let first = live
            .next()
            .is_some_and(|values| is_mirror_image(values, sum));
        first && live.all(|values| is_mirror_image(values, sum))
    };
    let Some(sum) = sums
        .into_iter()
        .find(|sum| starts_at_zero && is_mirrored(*sum))
    else {
        return set;
    };
    let lower = sum / 2 + 1;
    let half_rate_hz = axis.hz(0) + 0.5 * sum as f64 * axis.step_hz;
    let mut half = set.first_lines(lower.min(axis.len));
    let finding = Finding::new(Severity::Warning, Code::TwoSided, Location::Whole);
    half.findings.push(finding.value(half_rate_hz, "Hz"));
    half
}

/// Whether the values are the conjugates of their mirror images, by the sum of their numbers.
fn is_mirror_image(values: &[Complex64], sum: usize) -> bool {
    let (mut difference, mut energy) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate().take(sum + 1) {
        // The line of 0 Hz may have its image at the sampling rate, or none.
        let Some(image) = values.get(sum - k) else {
            continue;
        };
        difference += (image - value.conj()).norm_sqr();
        energy += image.norm_sqr() + value.norm_sqr();
    }
    values.len() >= MIN_LINES && energy > 0.0 && difference <= MAX_DIFFERENCE * energy
}

/// Fewest lines that tell a mirror image: a few may be equal by chance, as those of a mass are.
const MIN_LINES: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::frf::consistency::synthetic::Beam;
    use crate::frf::{Function, FunctionData};

    const PAIRS: [(&str, &str); 2] = [("1:+Z", "1:+Z"), ("2:+Z", "1:+Z")];

    /// The functions of a record of `len` samples, from line `first` to line `last`.
    fn two_sided(len: usize, first: usize, last: usize) -> FrfSet {
        let set = Beam::default().set(&PAIRS);
        let axis = FrequencyAxis {
            start_hz: first as f64 * set.axis().step_hz,
            step_hz: set.axis().step_hz,
            len: last + 1 - first,
        };
        let mut whole = FrfSet::new(axis);
        for (i, function) in set.functions().iter().enumerate() {
            let value = |line: usize| match line % len {
                line if line <= len / 2 => set.values(i)[line],
                line => set.values(i)[len - line].conj(),
            };
            let rounded = |value: Complex64| {
                let round = |part: f64| format!("{part:.4e}").parse().unwrap();
                Complex64::new(round(value.re), round(value.im))
            };
            let data = FunctionData {
                values: (first..=last).map(|line| rounded(value(line))).collect(),
                ..FunctionData::default()
            };
            let function = Function { ..function.clone() };
            whole.push(function, data).unwrap();
        }
        whole
    }

    #[test]
    fn the_mirror_image_of_the_lower_half_is_left_out() {
        for (len, first, last, lines) in [
            (4000, 0, 3999, 2001),
            (4000, 0, 4000, 2001),
            (4001, 0, 4000, 2001),
            (4000, 1, 3999, 2000),
        ] {
            let half = one_sided(two_sided(len, first, last));
            assert_eq!(half.axis().len, lines, "{len} {first} {last}");
            assert_eq!(half.findings[0].code, Code::TwoSided);
            assert_eq!(half.values(1).len(), lines);
        }
    }

    #[test]
    fn the_upper_half_of_one_sided_functions_is_kept() {
        let set = Beam::default().set(&PAIRS);
        assert_eq!(one_sided(set.clone()), set);
        let mut flat = set.first_lines(40);
        for i in 0..2 {
            flat.values_mut(i).fill(Complex64::ZERO);
        }
        assert_eq!(one_sided(flat.clone()), flat);
    }
}

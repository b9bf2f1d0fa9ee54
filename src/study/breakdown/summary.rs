//! The summary of a slice states the ranges in which each method succeeds.

use super::Axis;
use super::slice::{MIN_SUCCESS_RATE, SliceResult, SuccessRate};

/// Ranges of the first axis in which a method meets the stated error, the second one fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct SuccessRange {
    /// Value of the second axis.
    pub at_y: f64,
    /// Values of the first axis between which the share is 95 % or more.
    pub inside: Vec<(f64, f64)>,
    /// The same for the lower end of the confidence interval of the share.
    pub surely_inside: Vec<(f64, f64)>,
    /// The same for the upper end of the interval.
    pub possibly_inside: Vec<(f64, f64)>,
}

/// Positions on the second axis at which the ranges are stated: both ends and the middle.
const ROWS: [f64; 3] = [0.0, 0.5, 1.0];

impl SliceResult {
    /// Ranges in which a method succeeds, at both ends and in the middle of the second axis.
    pub fn success_ranges(&self, method: usize) -> Vec<SuccessRange> {
        let (x, y) = (self.slice.x, self.slice.y);
        let fields = [SuccessRate::Counted, SuccessRate::Lower, SuccessRate::Upper]
            .map(|b| self.field(method, b));
        let range = |share: &f64| {
            let values_of = |k: usize| {
                let intervals = fields[k]
                    .intervals_above(true, *share, MIN_SUCCESS_RATE)
                    .into_iter();
                intervals.map(|(a, b)| (x.at(a), x.at(b))).collect()
            };
            SuccessRange {
                at_y: y.at(*share),
                inside: values_of(0),
                surely_inside: values_of(1),
                possibly_inside: values_of(2),
            }
        };
        ROWS.iter().map(range).collect()
    }

    /// Share of the slice in which a method meets the stated error, by its axes.
    pub fn area(&self, method: usize) -> f64 {
        let field = self.field(method, SuccessRate::Counted);
        let all = field.values.iter().flatten();
        let (count, inside) = all.fold((0, 0), |(count, inside), value| {
            (count + 1, inside + usize::from(*value >= MIN_SUCCESS_RATE))
        });
        inside as f64 / count as f64
    }
}

/// Stretches of an axis in words: `all`, `none`, `from 2.6`, `to 0.03`, `2 to 5`.
pub fn ranges_text(stretches: &[(f64, f64)], axis: &Axis) -> String {
    let one = |(a, b): &(f64, f64)| match (at_end(*a, axis.lo), at_end(*b, axis.hi)) {
        (true, true) => "all".to_owned(),
        (false, true) => format!("from {}", short_number(*a)),
        (true, false) => format!("to {}", short_number(*b)),
        (false, false) => format!("{} to {}", short_number(*a), short_number(*b)),
    };
    match stretches {
        [] => "none".to_owned(),
        segments => segments.iter().map(one).collect::<Vec<_>>().join(", "),
    }
}

fn at_end(value: f64, end: f64) -> bool {
    (value - end).abs() <= 1e-9 * end.abs().max(1e-12)
}

/// A number with two digits, or all before the point.
pub fn short_number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return format!("{value}");
    }
    let digits = 1 - size.log10().floor() as i32;
    if size < 1e-3 {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Factor, Scale};
    use super::*;

    #[test]
    fn stretches_read_as_words() {
        let axis = Axis {
            factor: Factor::Separation,
            lo: 0.1,
            hi: 10.0,
            count: 7,
            scale: Scale::Log,
        };
        for (stretches, words) in [
            (vec![(0.1, 10.0)], "all"),
            (vec![], "none"),
            (vec![(2.634, 10.0)], "from 2.6"),
            (vec![(0.1, 0.0312), (1.0, 5.0)], "to 0.031, 1 to 5"),
        ] {
            assert_eq!(ranges_text(&stretches, &axis), words);
        }
        assert_eq!(short_number(43.21), "43");
        assert_eq!(short_number(1e-6), "1e-6");
    }
}

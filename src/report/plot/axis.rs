//! An axis converts values to positions on the page, and has ticks at steps of 1, 2 and 5 or at
//! powers of ten.

use super::canvas::{Anchor, Canvas, FAINT, GRID, INK};

/// One axis of a plot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    lo: f64,
    hi: f64,
    log: bool,
    from: f64,
    to: f64,
    /// Distance of ticks; `None` selects a round number.
    step: Option<f64>,
}

/// A tick with its label, which is empty for a minor tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub at: f64,
    pub text: String,
}

impl Axis {
    /// A linear axis over values, between two positions, px.
    pub fn linear((lo, hi): (f64, f64), (from, to): (f64, f64)) -> Self {
        let (lo, hi) = if hi > lo {
            (lo, hi)
        } else {
            (lo - 0.5, lo + 0.5)
        };
        Self {
            lo,
            hi,
            log: false,
            from,
            to,
            step: None,
        }
    }

    /// A logarithmic axis; values must be positive.
    pub fn log((lo, hi): (f64, f64), (from, to): (f64, f64)) -> Self {
        let (lo, hi) = if hi > lo && lo > 0.0 {
            (lo, hi)
        } else {
            (1.0, 10.0)
        };
        Self {
            lo,
            hi,
            log: true,
            from,
            to,
            step: None,
        }
    }

    /// Ticks at multiples of this step.
    pub fn with_step(self, step: f64) -> Self {
        Self {
            step: Some(step),
            ..self
        }
    }

    /// Position of a value on the page, px.
    pub fn position(&self, value: f64) -> f64 {
        let fraction = match self.log {
            true => (value / self.lo).ln() / (self.hi / self.lo).ln(),
            false => (value - self.lo) / (self.hi - self.lo),
        };
        self.from + fraction * (self.to - self.from)
    }

    /// Position of a value that the axis can show; `None` for 0 and below on a logarithmic axis.
    pub fn visible_position(&self, value: f64) -> Option<f64> {
        (value.is_finite() && (!self.log || value > 0.0)).then(|| self.position(value))
    }

    /// About `count` ticks.
    pub fn ticks(&self, count: f64) -> Vec<Tick> {
        match self.log && self.hi / self.lo > 8.0 {
            true => self.decade_ticks(),
            false => self.step_ticks(count),
        }
    }

    /// Common power of ten of the numbers of a linear axis; 0 where they are short without one.
    fn common_power(&self) -> i32 {
        let largest = f64::max(self.lo.abs(), self.hi.abs());
        if self.log || self.step.is_some() || (1e-2..1e5).contains(&largest) || largest == 0.0 {
            0
        } else {
            (largest.log10() + 1e-9).floor() as i32
        }
    }

    /// Ticks and label, with a common power of ten before the unit.
    fn labelled_ticks(&self, count: f64, label: &str) -> (Vec<Tick>, String) {
        let power = self.common_power();
        if power == 0 {
            return (self.ticks(count), label.to_owned());
        }
        let unit = 10f64.powi(power);
        let scaled = Self {
            lo: self.lo / unit,
            hi: self.hi / unit,
            ..*self
        };
        let back = |tick: Tick| Tick {
            at: tick.at * unit,
            ..tick
        };
        let ticks = scaled.ticks(count).into_iter().map(back).collect();
        let ten = power_of_ten(power);
        let label = match label.rsplit_once(" (") {
            Some((name, unit)) => format!("{name} ({ten} {unit}"),
            None => format!("{label} ({ten})"),
        };
        (ticks, label)
    }

    fn step_ticks(&self, count: f64) -> Vec<Tick> {
        let step = self.step.unwrap_or_else(|| {
            let raw = (self.hi - self.lo) / count.max(1.0);
            let power = 10f64.powf(raw.log10().floor());
            let steps = [1.0, 2.0, 5.0].map(|factor| factor * power);
            let wide = steps.into_iter().find(|step| *step >= 0.999 * raw);
            wide.unwrap_or(10.0 * power)
        });
        let first = (self.lo / step - 1e-9).ceil() as i64;
        let last = (self.hi / step + 1e-9).floor() as i64;
        let tick = |n: i64| Tick {
            at: n as f64 * step,
            text: tick_text(n as f64 * step, step),
        };
        (first..=last).map(tick).collect()
    }

    fn decade_ticks(&self) -> Vec<Tick> {
        let (first, last) = (
            self.lo.log10().floor() as i32,
            self.hi.log10().ceil() as i32,
        );
        let every = ((last - first) as f64 / 7.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for n in first..=last {
            for m in 1..10 {
                let at = f64::from(m) * 10f64.powi(n);
                let inside = at >= self.lo * (1.0 - 1e-9) && at <= self.hi * (1.0 + 1e-9);
                if inside {
                    let labelled = m == 1 && n % every == 0;
                    let text = if labelled {
                        power_of_ten(n)
                    } else {
                        String::new()
                    };
                    ticks.push(Tick { at, text });
                }
            }
        }
        ticks
    }
}

fn tick_text(value: f64, step: f64) -> String {
    let value = if value.abs() < 1e-9 * step {
        0.0
    } else {
        value
    };
    let last_digit = (step.log10() + 1e-9).floor();
    if value.abs().max(step) >= 1e5 || step < 1e-4 {
        if value == 0.0 {
            return "0".to_owned();
        }
        let digits = ((value.abs().log10() + 1e-9).floor() - last_digit).max(0.0) as usize;
        return format!("{value:.digits$e}");
    }
    let decimals = (-last_digit).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// `0.01` to `1000` as they are, else `10⁻⁶`.
fn power_of_ten(n: i32) -> String {
    if (-2..=3).contains(&n) {
        return format!("{:.*}", usize::try_from(-n).unwrap_or(0), 10f64.powi(n));
    }
    let raised = |c: char| match c {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹']
            [digit.to_digit(10).unwrap_or(0) as usize],
    };
    format!(
        "10{}",
        n.to_string().chars().map(raised).collect::<String>()
    )
}

/// A frame with grid, ticks and labels around a plot of two axes; an axis with an empty label has
/// no numbers.
pub(super) fn draw_frame(
    canvas: &mut Canvas,
    (x, y): (&Axis, &Axis),
    (x_label, y_label): (&str, &str),
) {
    let (left, right, bottom, top) = (x.from, x.to, y.from, y.to);
    let (ticks, x_title) = x.labelled_ticks((right - left) / 80.0, x_label);
    for tick in ticks {
        let at = x.position(tick.at);
        canvas.line([at, top], [at, bottom], GRID, 0.6);
        if !x_label.is_empty() {
            canvas.text([at, bottom + 15.0], &tick.text, Anchor::Middle, INK);
        }
    }
    let (ticks, y_title) = y.labelled_ticks((bottom - top) / 40.0, y_label);
    for tick in ticks {
        let at = y.position(tick.at);
        canvas.line([left, at], [right, at], GRID, 0.6);
        canvas.text([left - 6.0, at + 4.0], &tick.text, Anchor::End, INK);
    }
    canvas.rect([left, top], [right, bottom], "none", FAINT);
    canvas.text(
        [0.5 * (left + right), bottom + 32.0],
        if x_label.is_empty() { "" } else { &x_title },
        Anchor::Middle,
        INK,
    );
    canvas.rotated_text(
        [left - 48.0, 0.5 * (top + bottom)],
        &y_title,
        Anchor::Middle,
        INK,
        -90.0,
    );
}

/// Smallest and largest of the finite values; `None` without any.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let finite = values.filter(|value| value.is_finite());
    finite.fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((lo, hi)) => Some((f64::min(lo, value), f64::max(hi, value))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, count: f64) -> Vec<String> {
        let ticks = axis.ticks(count).into_iter().map(|tick| tick.text);
        ticks.filter(|text| !text.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        let axis = Axis::linear((-0.31, 1.04), (0.0, 100.0));
        assert_eq!(labels(&axis, 5.0), ["0.0", "0.5", "1.0"]);
        let axis = Axis::linear((60.0, 3200.0), (0.0, 100.0));
        assert_eq!(labels(&axis, 6.0), ["1000", "2000", "3000"]);
        let axis = Axis::linear((-2.6e-5, 1e-6), (0.0, 100.0));
        assert_eq!(
            labels(&axis, 6.0),
            ["-2.5e-5", "-2.0e-5", "-1.5e-5", "-1.0e-5", "-5e-6", "0"]
        );
        let axis = Axis::log((2e-8, 3e-3), (100.0, 0.0));
        assert_eq!(labels(&axis, 5.0), ["10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert!(
            axis.ticks(5.0)
                .iter()
                .all(|tick| tick.at >= 2e-8 * 0.999 && tick.at <= 3e-3 * 1.001)
        );
    }

    #[test]
    fn small_numbers_have_their_power_of_ten_in_the_label() {
        let axis = Axis::linear((-2.6e-8, 1e-9), (0.0, 100.0));
        let (ticks, label) = axis.labelled_ticks(6.0, "Imaginary part (m/N)");
        let texts: Vec<&str> = ticks.iter().map(|tick| tick.text.as_str()).collect();
        assert_eq!(texts, ["-2.5", "-2.0", "-1.5", "-1.0", "-0.5", "0.0"]);
        assert_eq!(label, "Imaginary part (10⁻⁸ m/N)");
        assert!((ticks[0].at + 2.5e-8).abs() < 1e-20);
        let plain = Axis::linear((0.0, 3200.0), (0.0, 100.0));
        assert_eq!(
            plain.labelled_ticks(6.0, "Frequency (Hz)").1,
            "Frequency (Hz)"
        );
    }

    #[test]
    fn positions_run_from_end_to_end() {
        let axis = Axis::log((1.0, 100.0), (200.0, 0.0));
        for (value, position) in [(1.0, 200.0), (10.0, 100.0), (100.0, 0.0)] {
            assert!((axis.position(value) - position).abs() < 1e-9);
        }
        assert!(axis.visible_position(0.0).is_none() && axis.visible_position(f64::NAN).is_none());
        let flat = Axis::linear((3.0, 3.0), (0.0, 10.0));
        assert!((flat.position(3.0) - 5.0).abs() < 1e-12);
    }
}

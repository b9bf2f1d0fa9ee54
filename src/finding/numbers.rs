//! Numbers of findings are written with as many digits as a reader needs.

/// Four significant digits, three below 1; whole numbers as they are, round ones with a power of
/// ten where that is much shorter.
pub(crate) fn format_number(value: f64) -> String {
    let magnitude = value.abs();
    if value.fract().abs() < f64::EPSILON && magnitude < 1e15 {
        let (whole, power) = (format!("{value:.0}"), format!("{value:e}"));
        if power.len() + 4 <= whole.len() {
            power
        } else {
            whole
        }
    } else if (1e-4..1e5).contains(&magnitude) {
        let digits = if magnitude < 1.0 { 2 } else { 3 };
        let decimals = (digits - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// A frequency in Hz with at most five or six significant digits.
pub(crate) fn format_hz(hz: f64) -> String {
    let decimals = match hz.abs() {
        low if low < 1e3 => 2,
        middle if middle < 1e4 => 1,
        _ => 0,
    };
    format!("{hz:.decimals$} Hz")
}

/// A value and its standard deviation, both to the second digit of the standard deviation.
pub(super) fn format_with_std(value: f64, std: f64) -> String {
    if !(1e-9..10.0).contains(&std) {
        return format!("{} ± {}", format_number(value), format_number(std));
    }
    let decimals = (1 - std.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$} ± {std:.decimals$}")
}

//! Numbers of findings are written with as many digits as a reader needs.

/// Four significant digits; whole numbers as they are, round ones with a power of ten where that is
/// much shorter.
pub(super) fn format_number(value: f64) -> String {
    let magnitude = value.abs();
    if value.fract().abs() < f64::EPSILON && magnitude < 1e15 {
        let (whole, power) = (format!("{value:.0}"), format!("{value:e}"));
        if power.len() + 4 <= whole.len() {
            power
        } else {
            whole
        }
    } else if (1e-3..1e5).contains(&magnitude) {
        let decimals = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// A value and its standard deviation, both to the second digit of the standard deviation.
pub(super) fn format_with_std(value: f64, std: f64) -> String {
    if !(1e-9..10.0).contains(&std) {
        return format!("{} ± {}", format_number(value), format_number(std));
    }
    let decimals = (1 - std.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$} ± {std:.decimals$}")
}

//! The Wilson interval states the uncertainty of a counted share.

/// Normal quantile of 95 %, two-sided.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// 95 % interval of a share of which `good` of `draws` were counted: `(p + z²/2n ± z √(p(1−p)/n +
/// z²/4n²)) / (1 + z²/n)`. All of 0 to 1 for no draws.
///
/// # Reference
/// Wilson (1927), Probable inference, the law of succession, and statistical inference, JASA
/// 22(158), eq. 5.
pub fn wilson_interval(good: u32, draws: u32) -> (f64, f64) {
    if draws == 0 {
        return (0.0, 1.0);
    }
    let n = f64::from(draws);
    let p = f64::from(good) / n;
    let z2 = QUANTILE * QUANTILE / n;
    let middle = p + 0.5 * z2;
    let half = (z2 * (p * (1.0 - p) + 0.25 * z2)).sqrt();
    let ends = ((middle - half) / (1.0 + z2), (middle + half) / (1.0 + z2));
    // Rounding may leave the ends that are exact.
    let lower = if good == 0 { 0.0 } else { ends.0 };
    let upper = if good == draws { 1.0 } else { ends.1 };
    (lower, upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_the_literature() {
        // Newcombe (1998), Statistics in Medicine 17, table I, method 3.
        for (good, draws, lower, upper) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let ends = wilson_interval(good, draws);
            assert!((ends.0 - lower).abs() < 5.1e-5, "{ends:?}");
            assert!((ends.1 - upper).abs() < 5.1e-5, "{ends:?}");
        }
        assert_eq!(wilson_interval(0, 0), (0.0, 1.0));
        assert!((wilson_interval(80, 80).1 - 1.0).abs() < 1e-15);
        // 73 draws without a failure are the minimum that proves a share of 95 %.
        assert!(wilson_interval(73, 73).0 > 0.95 && wilson_interval(72, 72).0 < 0.95);
    }
}

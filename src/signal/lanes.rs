//! Sums that do not wait for each addition: eight partial sums, in an order that does not depend on anything.

/// Partial sums side by side, as many as fill the vector units of common processors.
const LANES: usize = 8;

/// `Σ f(x)`.
#[inline]
pub fn lane_sum(values: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let mut sums = [0.0; LANES];
    let chunks = values.chunks_exact(LANES);
    let rest: f64 = chunks.remainder().iter().map(|x| f(*x)).sum();
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += f(*x);
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// `Σ f(x, y)` of values that belong together.
#[inline]
pub fn lane_sum_of_pairs(x: &[f64], y: &[f64], f: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; LANES];
    let (left, right) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest = left.remainder().iter().zip(right.remainder());
    let rest: f64 = rest.map(|(x, y)| f(*x, *y)).sum();
    for (x, y) in left.zip(right) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += f(*x, *y);
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// The smallest and the largest value; infinities the wrong way round without any.
pub fn lane_bounds(values: &[f64]) -> (f64, f64) {
    let (mut lo, mut hi) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let chunks = values.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for ((lo, hi), x) in lo.iter_mut().zip(&mut hi).zip(chunk) {
            *lo = if *x < *lo { *x } else { *lo };
            *hi = if *x > *hi { *x } else { *hi };
        }
    }
    let wider = |(lo, hi): (f64, f64), x: &f64| (lo.min(*x), hi.max(*x));
    let ends = lo.iter().chain(&hi).chain(rest);
    // The start values of lanes without a value lie outside on both sides and must not count.
    ends.filter(|x| x.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), wider)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounds_are_those_of_every_value() {
        for len in [1, 7, 8, 9, 100] {
            let x: Vec<f64> = (0..len).map(|n| f64::from(n * 37 % len) - 3.0).collect();
            assert_eq!(lane_bounds(&x), (-3.0, f64::from(len) - 4.0));
        }
    }

    #[test]
    fn every_value_counts_once() {
        for len in [0, 1, 7, 8, 9, 16, 1003] {
            let x: Vec<f64> = (0..len).map(f64::from).collect();
            let y: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
            let n = f64::from(len);
            let sum = n * (n - 1.0) / 2.0;
            assert!((lane_sum(&x, |x| x) - sum).abs() < 1e-9);
            let squares: f64 = x.iter().map(|x| 2.0 * x * x).sum();
            assert!(
                (lane_sum_of_pairs(&x, &y, |x, y| x * y) - squares).abs() < 1e-9 * squares + 1e-12
            );
        }
    }
}

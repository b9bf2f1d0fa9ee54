//! Sums and bounds of many values, as wide as the processor adds: partial results side by side, in an order that does not depend
//! on anything, compiled for the vector units that are there.

use pulp::Arch;

/// Partial results side by side, as many as keep the vector units of common processors busy.
const LANES: usize = 16;

/// Runs a loop compiled for the vector units that this processor has.
#[inline(always)]
pub fn vectorised<R>(run: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(run)
}

/// `Σ f(x)`.
#[inline]
pub fn lane_sum(values: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    vectorised(
        #[inline(always)]
        || {
            let mut sums = [0.0; LANES];
            let chunks = values.chunks_exact(LANES);
            let rest: f64 = chunks.remainder().iter().map(|x| f(*x)).sum();
            for chunk in chunks {
                for (sum, x) in sums.iter_mut().zip(chunk) {
                    *sum += f(*x);
                }
            }
            sums.iter().sum::<f64>() + rest
        },
    )
}

/// `Σ f(x, y)` of values that belong together.
#[inline]
pub fn lane_sum_of_pairs(x: &[f64], y: &[f64], f: impl Fn(f64, f64) -> f64) -> f64 {
    vectorised(
        #[inline(always)]
        || {
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
        },
    )
}

/// `Σ(x − c)` and `Σ(x − c)²`.
pub fn lane_moments(values: &[f64], about: f64) -> (f64, f64) {
    vectorised(
        #[inline(always)]
        || {
            let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
            let chunks = values.chunks_exact(LANES);
            let rest = chunks.remainder();
            for chunk in chunks {
                for ((sum, square), x) in sums.iter_mut().zip(&mut squares).zip(chunk) {
                    let x = x - about;
                    *sum += x;
                    *square += x * x;
                }
            }
            let rest = rest.iter().map(|x| x - about);
            let total = |sums: [f64; LANES]| sums.iter().sum::<f64>();
            (
                total(sums) + rest.clone().sum::<f64>(),
                total(squares) + rest.map(|x| x * x).sum::<f64>(),
            )
        },
    )
}

/// How many values are so.
#[inline]
pub fn lane_count(values: &[f64], is: impl Fn(f64) -> bool) -> usize {
    lane_sum(values, |x| if is(x) { 1.0 } else { 0.0 }) as usize
}

/// What some values span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Their sum, finite only if all of them are.
    pub sum: f64,
    /// The smallest; infinite without any.
    pub lo: f64,
    /// The largest; negative and infinite without any.
    pub hi: f64,
}

impl Extent {
    /// Of these values.
    pub fn of(values: &[f64]) -> Self {
        vectorised(
            #[inline(always)]
            || {
                let mut lanes = ExtentLanes::NONE;
                let chunks = values.chunks_exact(LANES);
                lanes.add(chunks.remainder());
                chunks.for_each(|chunk| lanes.add(chunk));
                lanes.extent()
            },
        )
    }

    /// Of values times a factor, which are put in place of what `out` held.
    pub fn of_scaled<T: Copy + Into<f64>>(values: &[T], factor: f64, out: &mut Vec<f64>) -> Self {
        out.resize(values.len(), 0.0);
        vectorised(
            #[inline(always)]
            || {
                let mut lanes = ExtentLanes::NONE;
                for (out, values) in out.chunks_mut(LANES).zip(values.chunks(LANES)) {
                    for (place, x) in out.iter_mut().zip(values) {
                        *place = (*x).into() * factor;
                    }
                    lanes.add(out);
                }
                lanes.extent()
            },
        )
    }

    /// From the smallest to the largest.
    pub fn range(&self) -> f64 {
        self.hi - self.lo
    }
}

/// An extent in the making.
struct ExtentLanes {
    sums: [f64; LANES],
    lo: [f64; LANES],
    hi: [f64; LANES],
}

impl ExtentLanes {
    const NONE: Self = Self {
        sums: [0.0; LANES],
        lo: [f64::INFINITY; LANES],
        hi: [f64::NEG_INFINITY; LANES],
    };

    #[inline(always)]
    fn add(&mut self, values: &[f64]) {
        let ends = self.lo.iter_mut().zip(&mut self.hi);
        for ((sum, (lo, hi)), x) in self.sums.iter_mut().zip(ends).zip(values) {
            *sum += x;
            *lo = if *x < *lo { *x } else { *lo };
            *hi = if *x > *hi { *x } else { *hi };
        }
    }

    fn extent(&self) -> Extent {
        Extent {
            sum: self.sums.iter().sum(),
            lo: self.lo.iter().copied().fold(f64::INFINITY, f64::min),
            hi: self.hi.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounds_are_those_of_every_value() {
        for len in [1, 7, 8, 9, 100] {
            let x: Vec<f64> = (0..len).map(|n| f64::from(n * 37 % len) - 3.0).collect();
            let extent = Extent::of(&x);
            assert_eq!((extent.lo, extent.hi), (-3.0, f64::from(len) - 4.0));
            assert!((extent.sum - x.iter().sum::<f64>()).abs() < 1e-9);
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
            let moments = lane_moments(&x, 3.0);
            let about: Vec<f64> = x.iter().map(|x| x - 3.0).collect();
            let squares: f64 = about.iter().map(|x| x * x).sum();
            assert!((moments.0 - about.iter().sum::<f64>()).abs() < 1e-9);
            assert!((moments.1 - squares).abs() < 1e-9 * squares + 1e-12);
            assert_eq!(lane_count(&x, |x| x < 5.0), x.len().min(5));
            let squares: f64 = x.iter().map(|x| 2.0 * x * x).sum();
            assert!(
                (lane_sum_of_pairs(&x, &y, |x, y| x * y) - squares).abs() < 1e-9 * squares + 1e-12
            );
        }
    }
}

//! Sums and bounds of many values, as wide as the processor adds: partial results side by side, in
//! an order that does not depend on anything, compiled for the vector units that are there.

use crate::linalg::vectorised;

/// Partial results side by side, as many as keep the vector units of common processors busy.
const LANES: usize = 16;

/// `Σ f(x)`.
#[inline]
pub fn lane_sum(values: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    vectorised(
        #[inline(always)]
        || {
            let mut sums = [0.0; LANES];
            let (chunks, rest) = values.as_chunks::<LANES>();
            let rest: f64 = rest.iter().map(|x| f(*x)).sum();
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
            let ((left, x), (right, y)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
            let rest: f64 = x.iter().zip(y).map(|(x, y)| f(*x, *y)).sum();
            for (x, y) in left.iter().zip(right) {
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
    // Both of one piece while it is in the nearest cache.
    values
        .chunks(VALUES_PER_BLOCK)
        .fold((0.0, 0.0), |(sum, squares), x| {
            (
                sum + lane_sum(x, |x| x - about),
                squares + lane_sum(x, |x| (x - about) * (x - about)),
            )
        })
}

/// The value that none of the others comes before.
fn lane_first<T: Copy>(values: &[T], start: T, before: impl Fn(T, T) -> bool) -> T {
    let first = |a: T, b: T| if before(b, a) { b } else { a };
    let lanes = vectorised(
        #[inline(always)]
        || {
            let mut lanes = [start; LANES];
            let (chunks, rest) = values.as_chunks::<LANES>();
            for chunk in chunks {
                for (lane, x) in lanes.iter_mut().zip(chunk) {
                    *lane = first(*lane, *x);
                }
            }
            for (lane, x) in lanes.iter_mut().zip(rest) {
                *lane = first(*lane, *x);
            }
            lanes
        },
    );
    lanes.into_iter().fold(start, first)
}

/// Sum, smallest and largest of the values of a piece, which are put in `out`, times a factor. With
/// a value that is no number the sum is none either, and the ends may be any.
fn scale_block<T: Copy + PartialOrd + Into<f64>>(
    piece: &[T],
    factor: f64,
    out: &mut [f64],
) -> (f64, f64, f64) {
    vectorised(
        #[inline(always)]
        || {
            for (place, x) in out.iter_mut().zip(piece) {
                *place = (*x).into() * factor;
            }
        },
    );
    // One result at a time: several at once do not stay in registers.
    // The ends of what is stored, which is often narrower; the factor keeps or turns their order.
    let lo = lane_first(piece, piece[0], |a, b| a < b).into() * factor;
    let hi = lane_first(piece, piece[0], |a, b| a > b).into() * factor;
    (lane_sum(out, |x| x), lo.min(hi), lo.max(hi))
}

/// How many values are so.
#[inline]
pub fn lane_count(values: &[f64], is: impl Fn(f64) -> bool) -> usize {
    lane_sum(values, |x| if is(x) { 1.0 } else { 0.0 }) as usize
}

/// Values of which the ends are known together.
const VALUES_PER_BLOCK: usize = 64 * LANES;

/// The extent of some values and of each piece of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Their sum, finite only if all of them are.
    pub sum: f64,
    /// The smallest; infinite without any.
    pub lo: f64,
    /// The largest; negative and infinite without any.
    pub hi: f64,
    /// The smallest and the largest of each piece.
    pieces: Vec<(f64, f64)>,
}

impl Extent {
    /// Of these values.
    pub fn of(values: &[f64]) -> Self {
        let ends = |piece: &[f64]| {
            let lo = lane_first(piece, piece[0], |a, b| a < b);
            (
                lane_sum(piece, |x| x),
                lo,
                lane_first(piece, piece[0], |a, b| a > b),
            )
        };
        Self::of_pieces(values.chunks(VALUES_PER_BLOCK).map(ends))
    }

    /// Of values times a factor, which are put in place of what `out` held.
    pub fn of_scaled<T: Copy + PartialOrd + Into<f64>>(
        values: &[T],
        factor: f64,
        out: &mut Vec<f64>,
    ) -> Self {
        out.resize(values.len(), 0.0);
        let pieces = values
            .chunks(VALUES_PER_BLOCK)
            .zip(out.chunks_mut(VALUES_PER_BLOCK));
        Self::of_pieces(pieces.map(|(values, out)| scale_block(values, factor, out)))
    }

    fn of_pieces(each: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        let mut whole = Self {
            sum: 0.0,
            lo: f64::INFINITY,
            hi: f64::NEG_INFINITY,
            pieces: Vec::with_capacity(each.size_hint().0),
        };
        for (sum, lo, hi) in each {
            whole.sum += sum;
            whole.lo = whole.lo.min(lo);
            whole.hi = whole.hi.max(hi);
            whole.pieces.push((lo, hi));
        }
        whole
    }

    /// From the smallest to the largest.
    pub fn range(&self) -> f64 {
        self.hi - self.lo
    }

    /// How many of the values, which are those that this is the extent of, are not between two
    /// limits.
    pub fn count_beyond(&self, values: &[f64], low: f64, high: f64) -> usize {
        let pieces = values.chunks(VALUES_PER_BLOCK).zip(&self.pieces);
        let reaching = pieces.filter(|(_, (lo, hi))| *lo <= low || *hi >= high);
        let count = |values| lane_count(values, |x| x >= high || x <= low);
        reaching.map(|(values, _)| count(values)).sum()
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
    fn the_extent_of_scaled_values_holds_for_both_signs() {
        for len in [1, LANES + 3, VALUES_PER_BLOCK, 2 * VALUES_PER_BLOCK + 5] {
            let x: Vec<f32> = (0..len).map(|n| ((n * 37) % 101) as f32 - 7.0).collect();
            for factor in [0.3, -2.5] {
                let mut out = vec![f64::NAN; 3];
                let extent = Extent::of_scaled(&x, factor, &mut out);
                let expected: Vec<f64> = x.iter().map(|x| f64::from(*x) * factor).collect();
                assert_eq!(out, expected);
                let of_each = Extent::of(&expected);
                assert!((extent.sum - of_each.sum).abs() < 1e-9, "{len}");
                assert_eq!(
                    Extent { sum: 0.0, ..extent },
                    Extent {
                        sum: 0.0,
                        ..of_each
                    }
                );
            }
        }
        let mut out = Vec::new();
        for bad in [0, 5, VALUES_PER_BLOCK] {
            let mut x = vec![1.0_f32; VALUES_PER_BLOCK + 9];
            x[bad] = f32::NAN;
            assert!(Extent::of_scaled(&x, 1.0, &mut out).sum.is_nan(), "{bad}");
        }
    }

    #[test]
    fn values_beyond_limits_are_counted_in_every_piece() {
        for len in [
            10,
            VALUES_PER_BLOCK - 1,
            VALUES_PER_BLOCK,
            3 * VALUES_PER_BLOCK + 17,
        ] {
            let x: Vec<f64> = (0..len).map(|n| ((n * 37) % 101) as f64).collect();
            let mut out = Vec::new();
            for extent in [Extent::of(&x), Extent::of_scaled(&x, 1.0, &mut out)] {
                for (low, high) in [(-1.0, 101.0), (0.0, 100.0), (3.0, 97.5), (-1.0, 0.0)] {
                    let expected = x.iter().filter(|x| **x <= low || **x >= high).count();
                    assert_eq!(extent.count_beyond(&x, low, high), expected, "{low} {high}");
                }
            }
            assert_eq!(out, x);
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

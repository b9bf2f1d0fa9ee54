//! Quadratic forms with little more rounding than that of the result.
//!
//! A natural frequency of a slender structure is the small difference of large terms: `phi^T K phi`
//! of the first bending mode of a beam of 500 elements is 1e-9 of the sum of the magnitudes of its
//! terms. Error-free transformations of products and sums keep the rounding of the evaluation out
//! of it; what remains is the rounding of the entries of K.
//!
//! Forms of many vectors with a dense matrix are products of matrices, of which the leading one is
//! exact; sparse ones are summed in twice the working precision.
//!
//! # Reference
//! Ogita, Rump and Oishi (2005), Accurate sum and dot product, SIAM J. Sci. Comput. 26, algorithm
//! 5.3 (Dot2); Ozaki, Ogita, Oishi and Rump (2012), Error-free transformations of matrix
//! multiplication by using fast routines of matrix multiplication and its applications, Numer.
//! Algorithms 59, algorithm 3; Bunch (1971), Equilibration of symmetric matrices in the max-norm,
//! J. ACM 18.

use faer::{Mat, MatRef};

use super::RealMatrix;
use super::scale::exact_reciprocal;
use super::vectorised::vectorised;

/// Largest power of two of [`equilibration`], and the reciprocal of the smallest: the product of
/// two is a normal number.
const MAX_SCALE: f64 = f64::from_bits((1023 + 500) << 52);

/// `x^T A x` with the size of its terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuadraticForm {
    /// `sum A_ij x_i x_j`, of which the rounding of the evaluation is a small part of that of the
    /// entries of A.
    pub value: f64,
    /// `sum |A_ij x_i x_j|`: times the unit roundoff it bounds the change of the value by rounding
    /// of the entries of A.
    pub magnitude: f64,
}

/// A sum carried as a leading part and the sum of what it rounded off.
#[derive(Clone, Copy, Default)]
pub(super) struct CompensatedSum {
    high: f64,
    low: f64,
}

impl CompensatedSum {
    /// Adds `a b`.
    #[inline(always)]
    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        let product_error = a.mul_add(b, -product);
        let sum = self.high + product;
        let part = sum - self.high;
        let sum_error = (self.high - (sum - part)) + (product - part);
        self.high = sum;
        self.low += sum_error + product_error;
    }

    pub fn value(self) -> f64 {
        self.high + self.low
    }

    /// Its two parts.
    #[inline(always)]
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }
}

/// `x_j^T A x_j` of every column `x_j` of a block; A is symmetric.
///
/// With a diagonal D of powers of two ([`equilibration`]), `x' = D^-1 x` and `A' = D A D = A_1 +
/// A_2`, `x' = x_1 + x_2` ([`split`] to b bits):
///
/// `x^T A x = x'^T (A_1 x_1) + x'^T (A_1 x_2 + A_2 x')`.
///
/// The first product of matrices is exact in any order of summation, with fused multiply-add or
/// without: its terms and their partial sums are multiples of one unit of at most `n 2^2b <= 2^53`
/// of it. The second is rounded, but is about `2^-b` of the first. The product with `x'^T` is
/// summed in twice the working precision.
///
/// # Error
/// With the unit roundoff u, `g = (n + 1) u / (1 - (n + 1) u)` and a positive semidefinite A,
///
/// `|error| <= u |value| + 4 (n sqrt(n) + n) 2^-b g magnitude`
///
/// to first order in u, where a plain evaluation has `2 g magnitude`. The second product and the
/// sum of its two parts leave `g (|A_1| |x_2| + |A_2| |x'|)` in each row. A' has a diagonal from 1
/// to 4, so its entries are below 4, by Cauchy and Schwarz; those of A_1 are at most 4, of A_2 at
/// most `4 2^-b` and of x_2 at most `2^-b |x'|_inf`. In total `4 2^-b g
/// (n |x'|_1 |x'|_inf + |x'|_1^2)`, of which `|x'|_1 <= sqrt(n) |x'|_2` and `|x'|_inf <= |x'|_2`;
/// and the terms of the diagonal alone have the magnitude `sum A'_ii x'_i^2 >= |x'|_2^2`.
///
/// `n sqrt(n)` is for a full A' and a vector with one large entry; for a band or a vector without
/// large entries it is nearer to one. An indefinite A has the same bound with `|x'|_2^2` in the
/// place of the magnitude.
pub fn quadratic_forms(a: MatRef<'_, f64>, block: MatRef<'_, f64>) -> Vec<QuadraticForm> {
    let n = a.nrows();
    let scale = equilibration(a);
    let a = Mat::from_fn(n, n, |i, j| a[(i, j)] * (scale[i] * scale[j]));
    let x = Mat::from_fn(n, block.ncols(), |i, j| block[(i, j)] / scale[i]);
    let bits = exact_bits(n);
    let [a_high, a_low] = split(&a, bits);
    let [x_high, x_low] = split(&x, bits);
    // A is its transpose, and the columns of one factor with the columns of the other have the
    // units of `split`.
    let high = a_high.transpose() * x_high;
    let low = a_high.transpose() * x_low + a_low.transpose() * &x;
    let sizes = magnitudes(&a) * magnitudes(&x);
    (0..block.ncols())
        .map(|j| {
            let products = [high.col_as_slice(j), low.col_as_slice(j)];
            compensated_product(x.col_as_slice(j), products, sizes.col_as_slice(j))
        })
        .collect()
}

/// `x_j^T A x_j` of every column by a plain product, with the bound of its error over the
/// magnitude, `2 g` with `g` as in [`quadratic_forms`].
pub(super) fn plain_forms(a: &RealMatrix, block: &RealMatrix) -> (Vec<QuadraticForm>, f64) {
    let (forces, sizes) = (a * block, magnitudes(a) * magnitudes(block));
    let form = |j: usize| QuadraticForm {
        value: block.col(j).transpose() * forces.col(j),
        magnitude: dot_of_magnitudes(block.col_as_slice(j), sizes.col_as_slice(j)),
    };
    let bound = (a.nrows() + 1) as f64 * f64::EPSILON;
    ((0..block.ncols()).map(form).collect(), bound)
}

fn dot_of_magnitudes(x: &[f64], sizes: &[f64]) -> f64 {
    x.iter().zip(sizes).map(|(x, size)| x.abs() * size).sum()
}

/// `x^T (y_1 + y_2)`, and the magnitude `|x|^T z` that goes with it.
fn compensated_product(x: &[f64], [high, low]: [&[f64]; 2], sizes: &[f64]) -> QuadraticForm {
    // A fused multiply-add that is not an instruction takes a hundred times as long.
    vectorised(
        #[inline(always)]
        || {
            let mut form = QuadraticForm::default();
            let mut value = CompensatedSum::default();
            for (((&x, &high), &low), &size) in x.iter().zip(high).zip(low).zip(sizes) {
                value.add_product(x, high);
                value.add_product(x, low);
                form.magnitude += x.abs() * size;
            }
            form.value = value.value();
            form
        },
    )
}

/// `phi^T K phi / phi^T M phi` of every column, with the bound of its change by rounding of the
/// entries of K, `eps |phi|^T |K| |phi| / phi^T M phi`.
pub fn rayleigh_quotients(
    stiffness: &RealMatrix,
    mass: &RealMatrix,
    vectors: &RealMatrix,
) -> Vec<(f64, f64)> {
    let strain = quadratic_forms(stiffness.as_ref(), vectors.as_ref());
    let kinetic = quadratic_forms(mass.as_ref(), vectors.as_ref());
    let pairs = strain.iter().zip(&kinetic);
    pairs
        .map(|(strain, kinetic)| quotient(*strain, *kinetic))
        .collect()
}

/// `phi^T K phi / phi^T M phi` of both forms, with its bound of rounding.
pub(super) fn quotient(strain: QuadraticForm, kinetic: QuadraticForm) -> (f64, f64) {
    let rounding = f64::EPSILON * strain.magnitude / kinetic.value;
    (strain.value / kinetic.value, rounding)
}

/// Powers of two `d_i` that bring the entries `d_i d_j A_ij` of a symmetric matrix below 4, and the
/// diagonal of a positive semidefinite one to at least 1 where it is not zero.
///
/// `1 / d_i` is the root of the diagonal, or half of the largest `d_j |A_ij|`, `j < i`, where that
/// is larger: it is not in a positive semidefinite matrix, of which `|A_ij| <= sqrt(A_ii A_jj)`.
///
/// # Reference
/// Bunch (1971), section 2.
fn equilibration(a: MatRef<'_, f64>) -> Vec<f64> {
    let mut scale: Vec<f64> = Vec::with_capacity(a.nrows());
    for i in 0..a.nrows() {
        let entries = scale.iter().enumerate().map(|(j, d)| d * a[(j, i)].abs());
        let size = entries.fold(0.0, f64::max);
        let size = a[(i, i)].abs().sqrt().max(0.5 * size);
        let factor = if size > 0.0 {
            exact_reciprocal(size)
        } else {
            1.0
        };
        scale.push(factor.clamp(MAX_SCALE.recip(), MAX_SCALE));
    }
    scale
}

/// Most bits b of the entries of two matrices that leave sums of n products exact: `n 2^2b <=
/// 2^53`.
fn exact_bits(n: usize) -> u32 {
    let log2 = n.max(1).next_power_of_two().trailing_zeros();
    (f64::MANTISSA_DIGITS - log2) / 2
}

/// A matrix as the sum of two: the entries of the first are the nearest multiples of a unit of
/// their column of which `2^bits` are the least power of two above its largest entry; those of the
/// second are the rest, without rounding.
fn split(a: &RealMatrix, bits: u32) -> [RealMatrix; 2] {
    // Numbers near 1.5 2^52 units are spaced by one unit.
    let factor = 3.0 * f64::from(f64::MANTISSA_DIGITS - 1 - bits).exp2();
    let large: Vec<f64> = a
        .col_iter()
        .map(|column| factor / exact_reciprocal(column.norm_max()))
        .collect();
    let high = Mat::from_fn(a.nrows(), a.ncols(), |i, j| {
        (a[(i, j)] + large[j]) - large[j]
    });
    let low = a - &high;
    [high, low]
}

fn magnitudes(a: &RealMatrix) -> RealMatrix {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs())
}

#[cfg(test)]
mod tests {
    use super::super::{least_squares_real, real_matrix};
    use super::*;

    /// Half of the distance of 1 to the next number.
    const UNIT_ROUNDOFF: f64 = 0.5 * f64::EPSILON;

    #[test]
    fn terms_cancelling_to_sixteen_digits_leave_the_exact_value() {
        // [1, 1] A [1, 1]^T of a spring of 1e16 between two coordinates with a spring of 1 to
        // ground at the first.
        let a = real_matrix(2, 2, |i, j| match (i, j) {
            (0, 1) | (1, 0) => -1e16,
            (0, 0) => 1e16 + 2.0,
            _ => 1e16,
        });
        let x = real_matrix(2, 6, |_, j| 1.0 + j as f64);
        let forms = quadratic_forms(a.as_ref(), x.as_ref());
        for (j, form) in forms.iter().enumerate() {
            let square = (1.0 + j as f64).powi(2);
            assert_eq!(form.value.to_bits(), (2.0 * square).to_bits());
            assert!((form.magnitude / (4e16 * square) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn quadratic_forms_of_zero_rows_zero_vectors_and_no_vectors_are_defined() {
        let a = real_matrix(5, 5, |i, j| if i == 3 && j == 3 { 7.0 } else { 0.0 });
        let x = real_matrix(5, 2, |i, j| (i * (1 - j)) as f64);
        let forms = quadratic_forms(a.as_ref(), x.as_ref());
        assert_eq!(forms[0].value.to_bits(), 63.0_f64.to_bits());
        assert_eq!(forms[1], QuadraticForm::default());
        assert!(quadratic_forms(a.as_ref(), x.subcols(0, 0)).is_empty());
        let none = real_matrix(0, 0, |_, _| 0.0);
        assert!(quadratic_forms(none.as_ref(), none.as_ref()).is_empty());
    }

    /// Numbers without a pattern from -1 to 1.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
            self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn matrix(&mut self, rows: usize, columns: usize) -> RealMatrix {
            real_matrix(rows, columns, |_, _| self.next())
        }
    }

    /// `x^T A x` of every column with both sums in twice the working precision.
    fn doubled(a: &RealMatrix, block: &RealMatrix) -> Vec<f64> {
        let form = |j: usize| {
            let mut value = CompensatedSum::default();
            for i in 0..a.nrows() {
                let mut row = CompensatedSum::default();
                (0..a.ncols()).for_each(|k| row.add_product(a[(i, k)], block[(k, j)]));
                for part in row.parts() {
                    value.add_product(part, block[(i, j)]);
                }
            }
            value.value()
        };
        (0..block.ncols()).map(form).collect()
    }

    /// Positive semidefinite matrices of different kinds.
    fn semidefinite(n: usize) -> Vec<(&'static str, RealMatrix)> {
        let mut random = Random(n as u64);
        let factor = random.matrix(n, n.div_ceil(2));
        let gram = &factor * factor.transpose();
        let full = real_matrix(n, n, |i, j| gram[(i.max(j), i.min(j))]);
        // The square of the second difference, as the bending of a beam.
        let difference = real_matrix(n, n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        });
        let beam = &difference * &difference;
        let decades = |i: usize| 10f64.powf(-7.0 * (i as f64 + 0.3) / n as f64);
        let graded =
            |a: &RealMatrix| real_matrix(n, n, |i, j| a[(i, j)] * (decades(i) * decades(j)));
        vec![
            ("graded full", graded(&full)),
            ("graded beam", graded(&beam)),
            ("full", full),
            ("beam", beam),
            (
                "ones",
                real_matrix(n, n, |i, j| if i == j { 1.3 } else { 0.7 / 3.0 }),
            ),
        ]
    }

    /// Shapes of which the terms cancel or are of different sizes.
    fn shapes(n: usize, a: &RealMatrix) -> RealMatrix {
        let mut random = Random(3 + n as u64);
        let width = n as f64 + 1.0;
        // Times the root of the diagonal: the same in the scaled matrix.
        real_matrix(n, 9, |i, j| {
            let at = (i as f64 + 1.0) / width;
            let shape = match j {
                0..3 => (std::f64::consts::PI * (j + 1) as f64 * at).sin(),
                3..5 => (-0.5 * j as f64 * (i.abs_diff(n / 3)) as f64).exp(),
                5 => (1e-7 + if i == 0 { 1.0 } else { 0.0 }) / 3.0,
                6 => at * at * (3.0 - at),
                _ => random.next(),
            };
            shape / if j % 2 == 0 { a[(i, i)].sqrt() } else { 1.0 }
        })
    }

    #[test]
    fn forms_equal_those_in_twice_the_precision_within_the_bound() {
        for n in [1, 2, 7, 35, 100, 300] {
            for (name, a) in semidefinite(n) {
                let x = shapes(n, &a);
                let forms = quadratic_forms(a.as_ref(), x.as_ref());
                let size = n as f64;
                let part =
                    4.0 * (size * size.sqrt() + size) * f64::from(exact_bits(n)).exp2().recip();
                let g = (size + 1.0) * UNIT_ROUNDOFF;
                for (j, (form, exact)) in forms.iter().zip(doubled(&a, &x)).enumerate() {
                    let error = (form.value - exact).abs() - 2.0 * UNIT_ROUNDOFF * exact.abs();
                    assert!(
                        error <= part * g * form.magnitude,
                        "{name} of {n}, shape {j}"
                    );
                    // What the sums of rounding errors come to.
                    assert!(
                        error <= 1e-3 * f64::EPSILON * form.magnitude,
                        "{name} of {n}, shape {j}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn forms_of_null_vectors_equal_those_in_twice_the_precision_within_a_part_of_the_rounding_of_the_entries()
     {
        // B B^T and graded D B B^T D of half the rank, with residuals of B z = y, of which the form
        // is rounding alone.
        for n in [20, 100, 300] {
            let mut random = Random(n as u64);
            let factor = random.matrix(n, n / 2);
            let gram = &factor * factor.transpose();
            let mut x = random.matrix(n, 8);
            for j in 0..x.ncols() {
                let y: Vec<f64> = x.col(j).iter().copied().collect();
                let z = least_squares_real(&factor, &y).unwrap();
                (0..n).for_each(|i| {
                    x[(i, j)] -= (0..n / 2).map(|k| factor[(i, k)] * z[k]).sum::<f64>()
                });
            }
            for decades in [0.0, 7.0] {
                let d = |i: usize| 10f64.powf(-decades * (i as f64 + 0.3) / n as f64);
                let a = real_matrix(n, n, |i, j| gram[(i.max(j), i.min(j))] * (d(i) * d(j)));
                let x = real_matrix(n, x.ncols(), |i, j| x[(i, j)] / d(i));
                let forms = quadratic_forms(a.as_ref(), x.as_ref());
                let mut worst = 0.0_f64;
                for (form, exact) in forms.iter().zip(doubled(&a, &x)) {
                    assert!(exact.abs() < 1e-14 * form.magnitude);
                    worst = worst.max((form.value - exact).abs() / (f64::EPSILON * form.magnitude));
                }
                assert!(worst < 1e-6, "{n}, {decades} decades: {worst:e} roundings");
            }
        }
    }

    #[test]
    fn parts_of_a_matrix_add_up_to_it_and_have_an_exact_product() {
        let mut random = Random(11);
        for n in [1, 3, 64, 65, 300] {
            let bits = exact_bits(n);
            assert!(n as f64 * f64::from(2 * bits).exp2() <= 1.0 / UNIT_ROUNDOFF);
            let factors = [4, 3].map(|columns| random.matrix(n, columns));
            let parts = factors.each_ref().map(|factor| split(factor, bits));
            for (whole, [high, low]) in factors.iter().zip(&parts) {
                assert_eq!(*whole, high + low);
                let limit = whole.norm_max() * f64::from(bits).exp2().recip();
                assert!(low.norm_max() <= limit);
            }
            // Largest entries below 1: all are multiples of 2^-60 at least.
            let integer = |value: f64| (value * 60f64.exp2()) as i128;
            let [[left, _], [right, _]] = parts;
            let product = left.transpose() * &right;
            for i in 0..4 {
                for j in 0..3 {
                    let terms = (0..n).map(|k| integer(left[(k, i)]) * integer(right[(k, j)]));
                    let exact = terms.sum::<i128>();
                    assert_eq!(integer(product[(i, j)]) << 60, exact, "{n}");
                }
            }
        }
    }

    #[test]
    fn forms_are_independent_of_the_scale_of_the_entries_and_of_single_coordinates() {
        let (_, a) = semidefinite(30).swap_remove(3);
        let x = shapes(30, &a);
        let expected = quadratic_forms(a.as_ref(), x.as_ref());
        for (exponents, vectors) in [
            ([0, 0], 0),
            ([480, -480], 0),
            ([-500, -500], 300),
            ([500, 500], -300),
        ] {
            let factor = |i: usize| f64::from(exponents[i % 2]).exp2();
            let a = real_matrix(30, 30, |i, j| a[(i, j)] * (factor(i) * factor(j)));
            let x = real_matrix(30, x.ncols(), |i, j| {
                x[(i, j)] / factor(i) * f64::from(vectors).exp2()
            });
            let forms = quadratic_forms(a.as_ref(), x.as_ref());
            let back = f64::from(-2 * vectors).exp2();
            for (form, expected) in forms.iter().zip(&expected) {
                assert_eq!((form.value * back).to_bits(), expected.value.to_bits());
                assert_eq!(
                    (form.magnitude * back).to_bits(),
                    expected.magnitude.to_bits()
                );
            }
        }
        // An indefinite one with nothing but a large entry beside the diagonal.
        let a = real_matrix(2, 2, |i, j| if i == j { 1e-150 } else { 3e150 });
        let form = quadratic_forms(a.as_ref(), real_matrix(2, 1, |_, _| 1.0).as_ref())[0];
        for got in [form.value, form.magnitude] {
            assert!((got / 6e150 - 1.0).abs() < f64::EPSILON, "{got}");
        }
    }
}

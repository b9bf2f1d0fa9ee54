//! The cubic Hermite beam element: its matrices and its interpolation.
//!
//! Over one element of length `h` the deflection is `w(x) = N(xi) (w_1, theta_1, w_2, theta_2)`
//! with `xi = x/h` and `theta = dw/dx`. Nothing here knows of coordinates of a model.
//!
//! # Reference
//! Przemieniecki (1968), Theory of Matrix Structural Analysis, chapters 5 and 11, without shear and
//! rotary inertia.

/// A symmetric 4 × 4 element matrix over (w_1, theta_1, w_2, theta_2).
pub(super) type ElementMatrix = [[f64; 4]; 4];

/// `EI / h^3` times the integral of the products of curvatures; `bending` is EI, N m².
pub(super) fn stiffness(bending: f64, h: f64) -> ElementMatrix {
    let scale = bending / h.powi(3);
    scaled(
        [
            [12.0, 6.0, -12.0, 6.0],
            [6.0, 4.0, -6.0, 2.0],
            [-12.0, -6.0, 12.0, -6.0],
            [6.0, 2.0, -6.0, 4.0],
        ],
        scale,
        h,
    )
}

/// `rho A h / 420` times the integral of the products of shapes (consistent mass);
/// `mass_per_length` is rho A, kg/m.
pub(super) fn mass(mass_per_length: f64, h: f64) -> ElementMatrix {
    let scale = mass_per_length * h / 420.0;
    scaled(
        [
            [156.0, 22.0, 54.0, -13.0],
            [22.0, 4.0, 13.0, -3.0],
            [54.0, 13.0, 156.0, -22.0],
            [-13.0, -3.0, -22.0, 4.0],
        ],
        scale,
        h,
    )
}

/// Every rotation brings one factor `h`.
fn scaled(numbers: ElementMatrix, scale: f64, h: f64) -> ElementMatrix {
    let length = [1.0, h, 1.0, h];
    std::array::from_fn(|i| std::array::from_fn(|j| scale * length[i] * length[j] * numbers[i][j]))
}

/// The shapes N(xi): deflection inside the element.
pub(super) fn deflection(xi: f64, h: f64) -> [f64; 4] {
    let (xi2, xi3) = (xi * xi, xi * xi * xi);
    [
        1.0 - 3.0 * xi2 + 2.0 * xi3,
        h * (xi - 2.0 * xi2 + xi3),
        3.0 * xi2 - 2.0 * xi3,
        h * (xi3 - xi2),
    ]
}

/// Their slopes dN/dx: rotation inside the element.
pub(super) fn slope(xi: f64, h: f64) -> [f64; 4] {
    let xi2 = xi * xi;
    [
        6.0 * (xi2 - xi) / h,
        1.0 - 4.0 * xi + 3.0 * xi2,
        6.0 * (xi - xi2) / h,
        3.0 * xi2 - 2.0 * xi,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three-point Gauss-Legendre would not do: products of cubics are of degree 6 and need four
    /// points.
    const GAUSS: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];

    fn curvature(xi: f64, h: f64) -> [f64; 4] {
        [
            (12.0 * xi - 6.0) / (h * h),
            (6.0 * xi - 4.0) / h,
            (6.0 - 12.0 * xi) / (h * h),
            (6.0 * xi - 2.0) / h,
        ]
    }

    fn integral(h: f64, shape: impl Fn(f64) -> [f64; 4]) -> ElementMatrix {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let term = |&(point, weight): &(f64, f64)| {
                    let n = shape(0.5 + 0.5 * point);
                    0.5 * h * weight * n[i] * n[j]
                };
                GAUSS.iter().map(term).sum()
            })
        })
    }

    #[test]
    fn the_matrices_are_the_integrals_of_the_shapes() {
        let h = 0.37;
        let expected = [
            (stiffness(1.0, h), integral(h, |xi| curvature(xi, h))),
            (mass(1.0, h), integral(h, |xi| deflection(xi, h))),
        ];
        for (got, integrated) in expected {
            for (a, b) in got.iter().flatten().zip(integrated.iter().flatten()) {
                assert!((a - b).abs() <= 1e-13 * b.abs().max(1e-3), "{a} {b}");
            }
        }
    }

    #[test]
    fn a_cubic_is_interpolated_exactly_with_its_slope() {
        let (h, cubic) = (0.6, |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - 5.0 * x * x * x);
        let slope_of = |x: f64| -2.0 + 6.0 * x - 15.0 * x * x;
        let ends = [cubic(0.0), slope_of(0.0), cubic(h), slope_of(h)];
        let dot = |n: [f64; 4]| -> f64 { n.iter().zip(ends).map(|(a, b)| a * b).sum() };
        for xi in [0.0, 0.2, 0.77, 1.0] {
            assert!((dot(deflection(xi, h)) - cubic(xi * h)).abs() < 1e-14);
            assert!((dot(slope(xi, h)) - slope_of(xi * h)).abs() < 1e-13);
        }
    }
}

//! Closed forms of the torsional planetary gear with one member fixed: its roots, and where they
//! cross or veer.
//!
//! The rotational roots above 0 solve `f1 lambda^2 + f2 lambda + f3 = 0`. With the carrier fixed,
//! their sum and product are `s = N k_s/m_s + N k_r/m_r + (k_r + k_s)/m_p` and `p = N k_r k_s (N
//! m_p + m_r + m_s)/(m_r m_s m_p)`; the planet root is met where `f1 lambda_p^2 + f2 lambda_p +
//! f3 = 0`, and `(omega_5 - omega_2)^2 = s - 2 sqrt(p)`.
//!
//! # Reference
//! Wang et al. (2005), equations 3 to 9. The last `m_s` in their f2 with the sun fixed is a
//! misprint of `m_r`: with it the roots are those of the matrices. Their veering criterion (7)
//! makes the discriminant smallest over k_s, which is near the smallest distance of the roots over
//! k_r, but is not its place.

use std::f64::consts::TAU;

use crate::theory::ModelQuantity;

/// The member that does not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fixed {
    Carrier,
    Ring,
    Sun,
}

impl Fixed {
    pub fn body(self) -> &'static str {
        match self {
            Fixed::Carrier => "carrier",
            Fixed::Ring => "ring",
            Fixed::Sun => "sun",
        }
    }

    pub fn coordinate(self) -> String {
        format!("u{}", &self.body()[..1])
    }
}

/// The numbers of a gear with one member fixed, no supports.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosedForms {
    pub fixed: Fixed,
    pub planets: f64,
    pub cos: f64,
    pub m_c: f64,
    pub m_r: f64,
    pub m_s: f64,
    pub m_p: f64,
    pub k_r: f64,
    pub k_s: f64,
}

impl ClosedForms {
    /// f1, f2, f3 of equation 5, and f2 as it is printed.
    fn coefficients(&self) -> ([f64; 3], f64) {
        let Self {
            planets: n,
            m_c,
            m_r,
            m_s,
            m_p,
            k_r,
            k_s,
            ..
        } = *self;
        let (both, cos2) = (k_r + k_s, self.cos * self.cos);
        let product = n * k_s * k_r;
        let carried = |inertia: f64| product * (n * m_p * cos2 + m_c + 4.0 * inertia * cos2);
        match self.fixed {
            Fixed::Carrier => {
                let f2 = -(n * k_s * m_r * m_p + n * k_r * m_s * m_p + both * m_r * m_s);
                let f3 = product * (n * m_p + m_s + m_r);
                ([m_r * m_s * m_p, f2, f3], f2)
            }
            Fixed::Ring => {
                let f2 = -(n * k_s * m_c * m_p + both * m_c * m_s + n * both * m_s * m_p * cos2);
                ([m_c * m_s * m_p, f2, carried(m_s)], f2)
            }
            Fixed::Sun => {
                let f2 = |inertia: f64| {
                    -(n * k_r * m_c * m_p + both * m_c * m_r + n * both * inertia * m_p * cos2)
                };
                ([m_c * m_r * m_p, f2(m_r), carried(m_r)], f2(m_s))
            }
        }
    }

    /// Both frequencies by equation 6 with f2 as printed, Hz.
    pub fn printed_hz(&self) -> [f64; 2] {
        let ([f1, _, f3], printed) = self.coefficients();
        quadratic(f1, printed, f3).map(|lambda| lambda.sqrt() / TAU)
    }

    /// The k_r of equation 7 and the lower one of equation 8; `None` unless the carrier is fixed.
    pub fn veering_and_crossing(&self) -> Option<[f64; 2]> {
        (self.fixed == Fixed::Carrier).then(|| {
            let over_mesh = self.veering_over_mesh();
            [0, 1].map(|i| over_mesh[i].value.unwrap_or(f64::NAN))
        })
    }

    /// Everything, by name.
    pub fn quantities(&self) -> Vec<ModelQuantity> {
        let ([f1, f2, f3], _) = self.coefficients();
        let [lower, upper] = quadratic(f1, f2, f3).map(|lambda| lambda.sqrt() / TAU);
        let mut all = vec![
            ModelQuantity::new(
                "rotational_lower",
                lower,
                "Hz",
                "rotational mode 2 (equation 6)",
            ),
            ModelQuantity::new(
                "rotational_upper",
                upper,
                "Hz",
                "rotational mode N + 2 (equation 6)",
            ),
        ];
        if self.fixed == Fixed::Sun {
            let [lower, upper] = self.printed_hz();
            let misprint = "the same with m_s in f2 as printed, which is a misprint of m_r";
            all.push(ModelQuantity::new("printed_lower", lower, "Hz", misprint));
            all.push(ModelQuantity::new("printed_upper", upper, "Hz", misprint));
        }
        if self.fixed == Fixed::Carrier {
            all.extend(self.veering_over_mesh());
            all.extend(self.veering_over_sun());
        }
        all
    }

    /// Crossings with the planet modes and nearest approach of the rotational ones, over k_r at the
    /// present k_s.
    fn veering_over_mesh(&self) -> [ModelQuantity; 6] {
        let (n_p, m_r, m_s) = (self.planets * self.m_p, self.m_r, self.m_s);
        let criterion = m_r * (n_p + m_s).powi(2)
            / (m_s * (n_p * n_p + n_p * m_r + n_p * m_s - m_r * m_s))
            * self.k_s;
        let delta = n_p * n_p - 4.0 * m_r * m_s;
        let crossing = |sign: f64| (n_p + sign * delta.sqrt()) / (2.0 * m_s) * self.k_s;
        let mass = n_p + m_r + m_s;
        let nearest = n_p * m_r * mass / (m_s * (n_p + m_r).powi(2)) * self.k_s;
        let place = "over k_r at this k_s";
        let make_quantity = |name, value, unit, what: &str| {
            ModelQuantity::new(name, value, unit, &format!("{what}, {place}"))
        };
        [
            make_quantity(
                "veering_k_r",
                criterion,
                "N/m",
                "veering of modes 2 and N + 2 by equation 7",
            ),
            make_quantity(
                "crossing_k_r_lower",
                crossing(-1.0),
                "N/m",
                "mode 2 meets the planet modes (equation 8)",
            ),
            make_quantity(
                "crossing_k_r_upper",
                crossing(1.0),
                "N/m",
                "mode 2 meets the planet modes (equation 8)",
            ),
            make_quantity(
                "delta_2",
                delta,
                "kg2",
                "(N m_p)^2 - 4 m_r m_s (equation 9): below 0 nothing meets",
            ),
            make_quantity(
                "nearest_k_r",
                nearest,
                "N/m",
                "modes 2 and N + 2 are nearest: N m_p m_r (N m_p + m_r + m_s)/(m_s (N m_p + m_r)^2) k_s",
            ),
            make_quantity(
                "nearest_gap",
                Self {
                    k_r: nearest,
                    ..*self
                }
                .gap_hz(),
                "Hz",
                "their distance there",
            ),
        ]
    }

    /// The same over the sun's mass, at the present mesh stiffnesses, which must be equal.
    fn veering_over_sun(&self) -> [ModelQuantity; 3] {
        let (n_p, m_r) = (self.planets * self.m_p, self.m_r);
        let equal = (self.k_r - self.k_s).abs() <= f64::EPSILON * self.k_s;
        let only_equal = |value: f64| if equal { value } else { f64::NAN };
        // Equation 7 with k_r = k_s as a quadratic in m_s:
        // m_r (N m_p + m_s)^2 = m_s (N^2 m_p^2 + N m_p m_r + N m_p m_s - m_r m_s).
        let a = 2.0 * m_r - n_p;
        let b = n_p * m_r - n_p * n_p;
        let criterion = positive_root(a, b, m_r * n_p * n_p);
        // s = a0 + b0 x and p = c0 (x (N m_p + m_r) + 1) with x = 1/m_s: d(s - 2 sqrt(p))/dx = 0.
        let (rate, sum) = (self.planets * self.k_s, n_p + m_r);
        let product = self.planets * self.k_s * self.k_r / (m_r * self.m_p);
        let nearest = sum / (product * (sum / rate).powi(2) - 1.0);
        let place = "over m_s at these k_r = k_s";
        let make_quantity = |name, value, what: &str| {
            ModelQuantity::new(name, value, "kg", &format!("{what}, {place}"))
        };
        [
            make_quantity(
                "veering_m_s",
                only_equal(criterion),
                "veering of modes 2 and N + 2 by equation 7",
            ),
            make_quantity(
                "crossing_m_s",
                only_equal(n_p - m_r),
                "mode 2 meets the planet modes: N m_p - m_r",
            ),
            make_quantity("nearest_m_s", nearest, "modes 2 and N + 2 are nearest"),
        ]
    }

    /// Distance of the rotational roots, Hz.
    fn gap_hz(&self) -> f64 {
        let ([f1, f2, f3], _) = self.coefficients();
        (-f2 / f1 - 2.0 * (f3 / f1).sqrt()).sqrt() / TAU
    }
}

/// Both roots of `a x^2 + b x + c = 0` with `b < 0`, ascending; the smaller one from the product,
/// without cancellation.
fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let larger = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    [c / (a * larger), larger]
}

/// The smallest positive root of `a x^2 + b x + c = 0`; not a number where there is none.
fn positive_root(a: f64, b: f64, c: f64) -> f64 {
    let half = -0.5 * (b + b.signum() * (b * b - 4.0 * a * c).sqrt());
    let roots = [half / a, c / half];
    let positive = roots.into_iter().filter(|root| *root > 0.0);
    positive.reduce(f64::min).unwrap_or(f64::NAN)
}

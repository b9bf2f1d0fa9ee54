//! A similarity maps points by rotation, translation and scale; it is fitted to pairs of points.

use crate::linalg::{Matrix3, Vector3};

/// Maximum second extent of points on one line, over the first.
const MAX_SECOND_EXTENT_OF_LINE: f64 = 1e-6;

/// `x' = s R x + t`: points of the test in the theory's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// `s`, above 0: 0.001 for a test in millimetres that counts them as metres.
    pub scale: f64,
    /// `R`, a rotation without reflection.
    pub rotation: Matrix3,
    /// `t`, m.
    pub shift_m: Vector3,
}

impl Similarity {
    /// The identity.
    pub fn identity() -> Self {
        Self {
            scale: 1.0,
            rotation: Matrix3::identity(),
            shift_m: Vector3::zeros(),
        }
    }

    /// A point of the test in the theory's frame, m.
    pub fn position(&self, point: &Vector3) -> Vector3 {
        self.rotation * point * self.scale + self.shift_m
    }

    /// Angle of the rotation, rad.
    pub fn angle(&self) -> f64 {
        ((self.rotation.trace() - 1.0) / 2.0)
            .clamp(-1.0, 1.0)
            .acos()
    }
}

/// The similarity that brings points `x` nearest to their partners `y` in the sense of least
/// squares.
///
/// With the means taken out, `Σ y x^T / n = U D V^T`: `R = U S V^T`, `s = tr(D S)/σ_x² = tr(R^T
/// Σ)/σ_x²`, `t = ȳ − s R x̄`, where `S = diag(1, 1, det U det V)` keeps `R` from being a
/// reflection. For points on one line it is the smallest rotation. `None` for fewer than two
/// distinct points.
///
/// # Reference
/// Umeyama (1991), Least-squares estimation of transformation parameters between two point
/// patterns, IEEE PAMI 13(4), eq. 39 to 43; Kabsch (1976), Acta Crystallographica A32, 922.
pub fn fit_similarity(pairs: &[(Vector3, Vector3)]) -> Option<Similarity> {
    fit_with_line_limit(pairs, MAX_SECOND_EXTENT_OF_LINE)
}

/// [`fit_similarity`] with the smallest rotation where the second extent is at most `on_a_line` of
/// the first.
pub(super) fn fit_with_line_limit(
    pairs: &[(Vector3, Vector3)],
    on_a_line: f64,
) -> Option<Similarity> {
    let count = pairs.len() as f64;
    let mean = |of: fn(&(Vector3, Vector3)) -> Vector3| {
        pairs.iter().map(of).sum::<Vector3>() / count.max(1.0)
    };
    let (x_mean, y_mean) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let centred = || pairs.iter().map(|(x, y)| (x - x_mean, y - y_mean));
    let spread = centred().map(|(x, _)| x.norm_squared()).sum::<f64>() / count.max(1.0);
    let covariance = centred().map(|(x, y)| y * x.transpose()).sum::<Matrix3>() / count.max(1.0);
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let values = svd.singular_values;
    if pairs.len() < 2 || values[0] <= 0.0 {
        return None;
    }
    let sign = (u.determinant() * v_t.determinant()).signum();
    let rotation = if values[1] <= on_a_line * values[0] {
        least_rotation(v_t.row(0).transpose(), u.column(0).into_owned())
    } else {
        u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t
    };
    let scale = (rotation.transpose() * covariance).trace() / spread;
    Some(Similarity {
        scale,
        rotation,
        shift_m: y_mean - rotation * x_mean * scale,
    })
}

/// The smallest rotation that brings one unit vector onto another: by Rodrigues' formula with `c =
/// a · b`, `w = a × b`, `R = I + [w] + [w]²/(1 + c)`; half a turn about a perpendicular axis where
/// they point against each other.
fn least_rotation(a: Vector3, b: Vector3) -> Matrix3 {
    let (cosine, w) = (a.dot(&b), a.cross(&b));
    if cosine < -1.0 + 1e-12 {
        let least = (0..3).min_by(|&i, &j| a[i].abs().total_cmp(&a[j].abs()));
        let mut other = Vector3::zeros();
        other[least.unwrap_or(0)] = 1.0;
        let axis = a.cross(&other).normalize();
        return axis * axis.transpose() * 2.0 - Matrix3::identity();
    }
    let cross = w.cross_matrix();
    Matrix3::identity() + cross + cross * cross / (1.0 + cosine)
}

/// Root mean square distance from the centre, m; 0 without points.
pub(super) fn extent(points: &[Vector3]) -> f64 {
    let count = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vector3>() / count;
    let squares: f64 = points.iter().map(|p| (p - centre).norm_squared()).sum();
    (squares / count).sqrt()
}

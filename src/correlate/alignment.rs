//! Alignment fits the frame of a test to that of a theory: rotation, translation and scale between
//! their points.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::Serialize;

use crate::linalg::{Matrix3, Vector3, sort_ascending_by};

use super::CorrelateError;
use super::nearest::PointTree;

/// Maximum number of iterations of closest points from one start.
const MAX_ITERATIONS: usize = 60;

/// Maximum difference of the root mean square distances of equally good fits, over the extent of
/// the points.
const MAX_RMS_DIFFERENCE_OVER_EXTENT: f64 = 1e-3;

/// Maximum difference of equal frames: of the rotations (Frobenius norm), and of the points over
/// their extent.
const MAX_DIFFERENCE_OF_EQUAL_FRAMES: f64 = 0.02;

/// Maximum number of test points in the fits from all starts; the best fits are refined with all
/// points.
const MAX_SAMPLE_POINTS: usize = 200;

/// Maximum number of fits that are refined with all points: the number of rotations of principal
/// axes, so that no fit of a symmetric set is lost.
const MAX_REFINED_FITS: usize = 24;

/// Maximum root mean square distance of a refined fit, over the smallest of all fits.
const MAX_RMS_OVER_BEST: f64 = 2.0;

/// Maximum distance of equal points, over the extent of all points.
pub(super) const MAX_DISTANCE_OF_EQUAL_POINTS: f64 = 1e-6;

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

/// A fitted frame with its residual distances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alignment {
    /// `s` of `x' = s R x + t`.
    pub scale: f64,
    /// Rows of `R`.
    pub rotation: [[f64; 3]; 3],
    /// `t`, m.
    pub shift_m: [f64; 3],
    /// Root mean square distance of the points after the fit, m.
    pub rms_m: f64,
    /// Largest distance, m.
    pub largest_m: f64,
    /// Points of the test; equal points count once where the partners were not known.
    pub points: usize,
    /// Whether the partners were known; else they are the closest points.
    pub known: bool,
    /// Number of equally good fits with other frames; this one has the smallest rotation. More than
    /// 0 for points that a rotation maps onto one another, and 1 for points on one line, whose
    /// rotation about it is arbitrary.
    pub as_good: usize,
    #[serde(skip)]
    similarity: Similarity,
}

impl Alignment {
    fn new(fit: Similarity, pairs: &[(Vector3, Vector3)], known: bool) -> Self {
        let (rms_m, largest_m) = distances(&fit, pairs);
        let row = |i: usize| [0, 1, 2].map(|j| fit.rotation[(i, j)]);
        Self {
            scale: fit.scale,
            rotation: [row(0), row(1), row(2)],
            shift_m: fit.shift_m.into(),
            rms_m,
            largest_m,
            points: pairs.len(),
            known,
            as_good: 0,
            similarity: fit,
        }
    }

    /// The fitted frame.
    pub fn similarity(&self) -> Similarity {
        self.similarity
    }

    /// This fit where no distance exceeds `tolerance_m`.
    ///
    /// # Errors
    /// [`CorrelateError::NotAligned`].
    fn check_tolerance(self, tolerance_m: f64) -> Result<Self, CorrelateError> {
        if self.largest_m <= tolerance_m {
            return Ok(self);
        }
        Err(CorrelateError::NotAligned {
            rms_m: self.rms_m,
            largest_m: self.largest_m,
            scale: self.scale,
            tolerance_m,
        })
    }
}

/// Root mean square and largest distance of pairs after a fit, m.
fn distances(fit: &Similarity, pairs: &[(Vector3, Vector3)]) -> (f64, f64) {
    let apart = |(a, b): &(Vector3, Vector3)| (fit.position(a) - b).norm();
    let squares: f64 = pairs.iter().map(|pair| apart(pair).powi(2)).sum();
    let rms = (squares / pairs.len().max(1) as f64).sqrt();
    (rms, pairs.iter().map(apart).fold(0.0, f64::max))
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
fn fit_with_line_limit(pairs: &[(Vector3, Vector3)], on_a_line: f64) -> Option<Similarity> {
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

/// The frame fitted to points whose partners are known.
///
/// For points on one line within the tolerance, on either side, the rotation about it is arbitrary:
/// the result has the smallest rotation, where it fits, and [`Alignment::as_good`] is 1.
///
/// # Errors
/// [`CorrelateError::FewPoints`] for fewer than three, [`CorrelateError::NotAligned`] beyond the
/// tolerance.
pub fn align_known(
    pairs: &[(Vector3, Vector3)],
    tolerance_m: f64,
) -> Result<Alignment, CorrelateError> {
    let few = || CorrelateError::FewPoints {
        got: pairs.len(),
        expected: 3,
    };
    let fit = fit_similarity(pairs)
        .filter(|_| pairs.len() >= 3)
        .ok_or_else(few)?;
    let fitted = Alignment::new(fit, pairs, true).check_tolerance(tolerance_m)?;
    if !are_on_one_line(&fit, pairs, tolerance_m) {
        return Ok(fitted);
    }
    let least = fit_with_line_limit(pairs, 1.0).map(|fit| Alignment::new(fit, pairs, true));
    let least = least.and_then(|fit| fit.check_tolerance(tolerance_m).ok());
    Ok(Alignment {
        as_good: 1,
        ..least.unwrap_or(fitted)
    })
}

/// Whether the points of one side lie within the tolerance of one line, in the theory's frame.
fn are_on_one_line(fit: &Similarity, pairs: &[(Vector3, Vector3)], tolerance_m: f64) -> bool {
    let test: Vec<Vector3> = pairs.iter().map(|(x, _)| fit.position(x)).collect();
    let theory: Vec<Vector3> = pairs.iter().map(|(_, y)| *y).collect();
    [test, theory].iter().any(|points| {
        let (centre, axes) = principal_axes(points);
        let axis = axes.column(0).into_owned();
        let off = |p: &Vector3| (p - centre).cross(&axis).norm();
        points.iter().map(off).fold(0.0, f64::max) <= tolerance_m
    })
}

/// The frame fitted to points whose partners are not known: each point's nearest one, fitted again
/// until nothing changes, from several starts (the frames as they are, and the principal axes of
/// both in every order and direction; at the scale as it is, and at that of both extents).
///
/// Equal points count once. With more than 200 points of the test, the fits use 200 that lie far
/// apart, and up to 24 of the best are refined with all points. A fit counts when it maps the
/// points one-to-one to partners. The smallest root mean square distance wins. Of equally good fits
/// the one with the smallest rotation wins, and the result has their number. Points that cover
/// another part than the theory's may need a list of partners.
///
/// # Errors
/// [`CorrelateError::FewPoints`] for fewer than three points on either side or fewer partners than
/// points; [`CorrelateError::NoDistinctPartners`] where no fit counts;
/// [`CorrelateError::NotAligned`] where none is within the tolerance.
///
/// # Reference
/// Besl and McKay (1992), A method for registration of 3-D shapes, IEEE PAMI 14(2).
pub fn align_nearest(
    test: &[Vector3],
    theory: &[Vector3],
    tolerance_m: f64,
) -> Result<Alignment, CorrelateError> {
    let (test, theory) = (&distinct_points(test), &distinct_points(theory));
    let needed = test.len().max(3);
    if test.len() < 3 || theory.len() < needed {
        let got = test.len().min(theory.len());
        let expected = needed;
        return Err(CorrelateError::FewPoints { got, expected });
    }
    let fits = best_fits(test, theory);
    let Some(best) = fits.first() else {
        return Err(CorrelateError::NoDistinctPartners {
            points: test.len(),
            partners: theory.len(),
        });
    };
    let limit = best.rms_m + MAX_RMS_DIFFERENCE_OVER_EXTENT * extent(theory);
    let as_good = fits.into_iter().filter(|fit| fit.rms_m <= limit);
    let mut different = distinct_fits(as_good, test, extent(theory));
    let angle = |fit: &Alignment| fit.similarity.angle();
    sort_ascending_by(&mut different, angle);
    let as_good = different.len() - 1;
    let chosen = different.swap_remove(0);
    Alignment { as_good, ..chosen }.check_tolerance(tolerance_m)
}

/// The distinct points, of equal ones the first.
fn distinct_points(points: &[Vector3]) -> Vec<Vector3> {
    let width = MAX_DISTANCE_OF_EQUAL_POINTS * extent(points).max(f64::MIN_POSITIVE);
    let mut known = BTreeSet::new();
    let cell = |p: &Vector3| [0, 1, 2].map(|i| ((p[i] - points[0][i]) / width).round() as i64);
    let new = points.iter().filter(|p| known.insert(cell(p)));
    new.copied().collect()
}

/// Fits that map the points one-to-one to partners, the one with the smallest distance first.
fn best_fits(test: &[Vector3], theory: &[Vector3]) -> Vec<Alignment> {
    let tree = PointTree::new(theory.iter().map(|&p| p.into()).collect());
    let from = |starts: Vec<Similarity>, points: &[Vector3]| {
        let runs = starts.into_par_iter();
        let fits: Vec<Option<Alignment>> = runs
            .map(|start| iterate_closest_points(start, points, theory, &tree))
            .collect();
        let mut fits: Vec<Alignment> = fits.into_iter().flatten().collect();
        sort_ascending_by(&mut fits, |fit| fit.rms_m);
        fits
    };
    let sample = farthest_points(test, MAX_SAMPLE_POINTS);
    let fits = from(start_frames(test, theory), &sample);
    let Some(best) = fits.first().filter(|_| sample.len() < test.len()) else {
        return fits;
    };
    let limit = MAX_RMS_OVER_BEST * best.rms_m + MAX_RMS_DIFFERENCE_OVER_EXTENT * extent(theory);
    let near = fits.into_iter().filter(|fit| fit.rms_m <= limit);
    let different = distinct_fits(near, &sample, extent(theory)).into_iter();
    let frames = different.map(|fit| fit.similarity).take(MAX_REFINED_FITS);
    from(frames.collect(), test)
}

/// Up to `count` points, each the farthest from those before it, the first from the centre.
///
/// # Reference
/// Gonzalez (1985), Clustering to minimize the maximum intercluster distance, Theoretical Computer
/// Science 38, 293.
fn farthest_points(points: &[Vector3], count: usize) -> Vec<Vector3> {
    if points.len() <= count {
        return points.to_vec();
    }
    let mut last = points.iter().sum::<Vector3>() / points.len() as f64;
    let mut apart = vec![f64::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    while chosen.len() < count {
        let mut farthest = 0;
        for (i, p) in points.iter().enumerate() {
            let to_last = (p - last).norm_squared();
            // The centre, which selects the first point, is no point of the set.
            apart[i] = if chosen.len() == 1 {
                to_last
            } else {
                apart[i].min(to_last)
            };
            if apart[i] > apart[farthest] {
                farthest = i;
            }
        }
        last = points[farthest];
        chosen.push(last);
    }
    chosen
}

/// Fits without those that map the points like an earlier one.
fn distinct_fits(
    fits: impl IntoIterator<Item = Alignment>,
    test: &[Vector3],
    extent_m: f64,
) -> Vec<Alignment> {
    let same = |a: &Similarity, b: &Similarity| {
        let apart = |x: &Vector3| (a.position(x) - b.position(x)).norm();
        let farthest = test.iter().map(apart).fold(0.0, f64::max);
        (a.rotation - b.rotation).norm() < MAX_DIFFERENCE_OF_EQUAL_FRAMES
            && farthest < MAX_DIFFERENCE_OF_EQUAL_FRAMES * extent_m
    };
    let mut different: Vec<Alignment> = Vec::new();
    for fit in fits {
        let mut known = different.iter();
        if !known.any(|other| same(&fit.similarity, &other.similarity)) {
            different.push(fit);
        }
    }
    different
}

/// Root mean square distance from the centre, m; 0 without points.
pub(super) fn extent(points: &[Vector3]) -> f64 {
    let count = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vector3>() / count;
    let squares: f64 = points.iter().map(|p| (p - centre).norm_squared()).sum();
    (squares / count).sqrt()
}

/// Centre and principal axes (columns, right-handed, longest first).
fn principal_axes(points: &[Vector3]) -> (Vector3, Matrix3) {
    let centre = points.iter().sum::<Vector3>() / points.len() as f64;
    let moments: Matrix3 = points
        .iter()
        .map(|p| (p - centre) * (p - centre).transpose())
        .sum();
    let svd = moments.svd(true, false);
    let mut axes = svd.u.unwrap_or_else(Matrix3::identity);
    let third = axes.column(0).cross(&axes.column(1));
    axes.set_column(2, &third);
    (centre, axes)
}

/// The 24 rotations that map axes onto axes.
fn axis_rotations() -> Vec<Matrix3> {
    let orders = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    let signs = [1.0, -1.0];
    let mut found = Vec::new();
    for order in orders {
        for (a, b) in signs.iter().flat_map(|a| signs.map(|b| (*a, b))) {
            let mut turn = Matrix3::zeros();
            turn[(order[0], 0)] = a;
            turn[(order[1], 1)] = b;
            let third = turn.column(0).cross(&turn.column(1));
            turn.set_column(2, &third);
            found.push(turn);
        }
    }
    found
}

fn start_frames(test: &[Vector3], theory: &[Vector3]) -> Vec<Similarity> {
    let ((x, x_axes), (y, y_axes)) = (principal_axes(test), principal_axes(theory));
    let ratio = extent(theory) / extent(test).max(f64::MIN_POSITIVE);
    let mut found = vec![Similarity::identity()];
    for scale in [1.0, ratio] {
        let turned = |rotation: Matrix3| Similarity {
            scale,
            rotation,
            shift_m: y - rotation * x * scale,
        };
        found.push(turned(Matrix3::identity()));
        let rotations = axis_rotations().into_iter();
        found.extend(rotations.map(|turn| turned(y_axes * turn * x_axes.transpose())));
    }
    found
}

/// Iterates closest points and fit from a start; `None` where two points have the same partner.
fn iterate_closest_points(
    start: Similarity,
    test: &[Vector3],
    theory: &[Vector3],
    tree: &PointTree,
) -> Option<Alignment> {
    let mut fit = start;
    let mut partners: Vec<usize> = Vec::new();
    for _ in 0..MAX_ITERATIONS {
        let at = test.iter().map(|x| fit.position(x).into());
        let nearest: Vec<usize> = at.map(|at| tree.nearest(at)).collect();
        if nearest == partners {
            break;
        }
        partners = nearest;
        fit = fit_similarity(&partner_pairs(test, theory, &partners))?;
    }
    let distinct: BTreeSet<usize> = partners.iter().copied().collect();
    let pairs = partner_pairs(test, theory, &partners);
    (distinct.len() == test.len()).then(|| Alignment::new(fit, &pairs, false))
}

fn partner_pairs(
    test: &[Vector3],
    theory: &[Vector3],
    partners: &[usize],
) -> Vec<(Vector3, Vector3)> {
    let both = test.iter().zip(partners);
    both.map(|(x, &j)| (*x, theory[j])).collect()
}

//! Alignment fits the frame of a test to that of a theory: rotation, translation and scale between
//! their points.

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::Serialize;

use crate::linalg::{Matrix3, Vector3, sort_ascending_by};

use super::CorrelateError;
use super::alignment_search::{frames_onto_nodes, is_unit_ratio};
use super::nearest::PointTree;
use super::similarity::{Similarity, extent, fit_similarity, fit_with_line_limit};

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

/// Maximum difference of equal mean MACs. Larger, at 0.1: a frame is kept although another one
/// fits the shapes better. Smaller, at 0: noise of the shapes selects among the frames of a
/// symmetric machine. Test `shapes_select_among_frames_that_fit_equally_well`.
const MAX_DIFFERENCE_OF_EQUAL_MACS: f64 = 0.02;

/// Maximum number of other frames in a result.
const MAX_OTHERS: usize = 63;

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
    /// Number of equally good fits with other frames; of these and this one the shapes select, then
    /// the smallest rotation. More than 0 for points that a rotation maps onto one another, and 1
    /// for points on one line, whose rotation about it is arbitrary.
    pub as_good: usize,
    /// Mean of the largest MAC of each test mode in this frame, where shapes selected it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_mac: Option<f64>,
    /// Equally good fits with other frames, up to 63, the largest mean MAC first where it is known;
    /// none where the partners were known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<Alignment>,
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
            mean_mac: None,
            others: Vec::new(),
            similarity: fit,
        }
    }

    /// The fitted frame.
    pub fn similarity(&self) -> Similarity {
        self.similarity
    }

    /// Whether the scale is a ratio of common units of length.
    pub fn has_unit_scale(&self) -> bool {
        is_unit_ratio(self.scale)
    }

    /// Number of the other frames with a mean MAC as large as that of this one.
    pub fn as_good_by_shape(&self) -> usize {
        let largest = self.mean_mac.unwrap_or(0.0);
        let macs = self.others.iter().filter_map(|other| other.mean_mac);
        macs.filter(|mac| *mac >= largest - MAX_DIFFERENCE_OF_EQUAL_MACS)
            .count()
    }

    /// The frame of the largest mean MAC among this one and [`Self::others`]; of those that differ
    /// by less than 0.02 the one with the smallest rotation. A frame without a MAC counts as 0.
    pub fn selected_by_shapes(mut self, mean_mac: impl Fn(&Similarity) -> Option<f64>) -> Self {
        if self.others.is_empty() {
            return self;
        }
        let others = std::mem::take(&mut self.others);
        let as_good = self.as_good;
        let mut all = Vec::with_capacity(others.len() + 1);
        for mut fit in std::iter::once(self).chain(others) {
            fit.mean_mac = mean_mac(&fit.similarity);
            all.push(fit);
        }
        let mac = |fit: &Alignment| fit.mean_mac.unwrap_or(0.0);
        let largest = all.iter().map(mac).fold(0.0, f64::max);
        let equal = |fit: &Alignment| mac(fit) >= largest - MAX_DIFFERENCE_OF_EQUAL_MACS;
        // The frames are in the order of their rotation.
        let selected = all.iter().position(equal).unwrap_or(0);
        let mut selected = all.remove(selected);
        all.sort_by(|a, b| mac(b).total_cmp(&mac(a)));
        (selected.as_good, selected.others) = (as_good, all);
        selected
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

/// The frame fitted to points whose partners are not known.
///
/// First, triangles of three test points are compared with triangles of the theory's points, at the
/// ratios of common units of length; frames that map all points near partners are fitted to these.
/// Where no frame does, each point's nearest one is its partner, fitted again until nothing
/// changes, from several starts (the frames as they are, and the principal axes of both in every
/// order and direction; at the scale as it is, and at that of both extents).
///
/// Equal points count once. With more than 200 points of the test, the iterated fits use 200 that
/// lie far apart, and up to 24 of the best are refined with all points. A fit counts when it maps
/// the points one-to-one to partners. The smallest root mean square distance wins. Of equally good
/// fits the one with the smallest rotation wins, then that of the smallest translation; the result
/// has the others. Points that cover another part than the theory's may need a list of partners.
///
/// # Errors
/// [`CorrelateError::FewPoints`] for fewer than three points on either side or fewer partners than
/// points; [`CorrelateError::Mirrored`] where a reflection fits and no rotation;
/// [`CorrelateError::NoDistinctPartners`] where no fit counts; [`CorrelateError::NotAligned`] where
/// none is within the tolerance.
///
/// # Reference
/// Besl and McKay (1992), A method for registration of 3-D shapes, IEEE PAMI 14(2); Aiger, Mitra
/// and Cohen-Or (2008), 4-points congruent sets for robust pairwise surface registration, ACM
/// Transactions on Graphics 27(3) (congruent bases of few points).
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
    let tree = PointTree::new(theory.iter().map(|&p| p.into()).collect());
    let onto_nodes = fits_onto_nodes(test, theory, &tree, tolerance_m);
    if !onto_nodes.is_empty() {
        return Ok(smallest_rotation(onto_nodes));
    }
    let fits = best_fits(test, theory, &tree);
    let fitted = match fits.first() {
        None => Err(CorrelateError::NoDistinctPartners {
            points: test.len(),
            partners: theory.len(),
        }),
        Some(best) => {
            let limit = best.rms_m + MAX_RMS_DIFFERENCE_OVER_EXTENT * extent(theory);
            let as_good = fits.into_iter().filter(|fit| fit.rms_m <= limit);
            let different = distinct_fits(as_good, test, extent(theory));
            smallest_rotation(different).check_tolerance(tolerance_m)
        }
    };
    let mirrored = || -> bool {
        let mirrored: Vec<Vector3> = test.iter().map(|p| Vector3::new(p.x, p.y, -p.z)).collect();
        !fits_onto_nodes(&mirrored, theory, &tree, tolerance_m).is_empty()
    };
    match fitted {
        Err(_) if mirrored() => Err(CorrelateError::Mirrored { tolerance_m }),
        fitted => fitted,
    }
}

/// Fits within the tolerance that map all points near nodes, each set of partners once; of these
/// those with a root mean square distance as small as the best.
fn fits_onto_nodes(
    test: &[Vector3],
    theory: &[Vector3],
    tree: &PointTree,
    tolerance_m: f64,
) -> Vec<Alignment> {
    let frames = frames_onto_nodes(test, theory, tree, tolerance_m);
    let refine = |frame| iterate_closest_points(frame, test, theory, tree);
    let refined: Vec<Option<PartnerFit>> = frames.into_par_iter().map(refine).collect();
    let mut known = BTreeSet::new();
    let mut fits: Vec<Alignment> = refined
        .into_iter()
        .flatten()
        .filter(|fit| fit.alignment.largest_m <= tolerance_m)
        .filter(|fit| known.insert(fit.partners.clone()))
        .map(|fit| fit.alignment)
        .collect();
    sort_ascending_by(&mut fits, |fit| fit.rms_m);
    let best = fits.first().map_or(0.0, |fit| fit.rms_m);
    let limit = MAX_RMS_OVER_BEST * best + MAX_RMS_DIFFERENCE_OVER_EXTENT * extent(theory);
    fits.retain(|fit| fit.rms_m <= limit);
    fits
}

/// The fit of the smallest rotation, then of the smallest translation of the points, with the
/// others.
///
/// # Panics
/// Without a fit.
fn smallest_rotation(mut fits: Vec<Alignment>) -> Alignment {
    let steps = |value: f64| (value * 1e6).round();
    let rank = |fit: &Alignment| {
        let shift = Vector3::from(fit.shift_m).norm();
        [fit.similarity.angle(), shift].map(steps)
    };
    fits.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let as_good = fits.len() - 1;
    let mut chosen = fits.remove(0);
    fits.truncate(MAX_OTHERS);
    (chosen.as_good, chosen.others) = (as_good, fits);
    chosen
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
fn best_fits(test: &[Vector3], theory: &[Vector3], tree: &PointTree) -> Vec<Alignment> {
    let from = |starts: Vec<Similarity>, points: &[Vector3]| {
        let runs = starts.into_par_iter();
        let fits: Vec<Option<PartnerFit>> = runs
            .map(|start| iterate_closest_points(start, points, theory, tree))
            .collect();
        let fits = fits.into_iter().flatten().map(|fit| fit.alignment);
        let mut fits: Vec<Alignment> = fits.collect();
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

/// A fit with the index of the partner of each test point.
struct PartnerFit {
    alignment: Alignment,
    partners: Vec<usize>,
}

/// Iterates closest points and fit from a start; `None` where two points have the same partner.
fn iterate_closest_points(
    start: Similarity,
    test: &[Vector3],
    theory: &[Vector3],
    tree: &PointTree,
) -> Option<PartnerFit> {
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
    (distinct.len() == test.len()).then(|| PartnerFit {
        alignment: Alignment::new(fit, &pairs, false),
        partners,
    })
}

fn partner_pairs(
    test: &[Vector3],
    theory: &[Vector3],
    partners: &[usize],
) -> Vec<(Vector3, Vector3)> {
    let both = test.iter().zip(partners);
    both.map(|(x, &j)| (*x, theory[j])).collect()
}

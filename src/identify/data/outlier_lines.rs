//! Replaces frequency lines that carry no information: missing lines, which have no value in any
//! FRF, and outlier lines, as mains hum leaves them in averages of few hits. Both are interpolated
//! from neighbouring lines, where the data have no variances.
//!
//! A resonance between two lines is visible on all lines around it, as `R/(x − x₀)` with the
//! distance x in lines and its residue R: with γ lines to the half-power point its height is `R/γ`.
//! A deviation of at most three lines from a smooth curve (a cubic polynomial through six lines on
//! either side), without such skirts (`1/x` and `1/x²` fitted jointly), is no resonance that so
//! short a record can contain: its γ would be less than 0.04 lines, or than 0.01 where the skirts
//! are significant.

use std::ops::Range;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::linalg::{self, RealMatrix};

/// Lines on either side that the smooth curve is fitted to.
const NEIGHBOUR_LINES: usize = 6;
/// Largest width of an outlier, lines.
const MAX_OUTLIER_LINES: usize = 3;
/// Coefficients of the smooth curve.
const SMOOTH_COEFFICIENTS: usize = 4;
/// Coefficients with the skirts of a resonance.
const COEFFICIENTS: usize = SMOOTH_COEFFICIENTS + 2;
/// Minimum height of an outlier over the residue of the resonance that could explain it, summed
/// over all FRFs; the second where that residue is significant.
const MIN_HEIGHT_OVER_RESIDUE: f64 = 25.0;
const MIN_HEIGHT_OVER_SIGNIFICANT_RESIDUE: f64 = 100.0;
const MIN_RESIDUE_STDS: f64 = 4.0;
/// Minimum height of an outlier in one FRF, in standard deviations of its noise.
const MIN_OUTLIER_STDS: f64 = 5.0;
/// Minimum squared curvature of a candidate line, over the median of its neighbourhood.
const MIN_CURVATURE_RATIO: f64 = 50.0;
/// Lines on either side that this median is taken over.
const MEDIAN_HALF_WIDTH_LINES: usize = 12;

/// Lines on either side from which a missing line is interpolated.
const INTERPOLATION_LINES: usize = 3;

/// The set with its missing lines interpolated, with a finding for each run of them; `None` where
/// no line is missing.
///
/// A missing line is 0 or not finite in every FRF. Up to three adjacent ones are interpolated by
/// the polynomial through three lines on either side, if no FRF has a variance.
pub(in crate::identify) fn interpolate_missing_lines(
    set: &FrfSet,
    lines: Range<usize>,
) -> Option<(FrfSet, Vec<Finding>)> {
    if (0..set.len()).any(|i| set.variance(i).is_some()) {
        return None;
    }
    let empty = |value: Complex64| value == Complex64::ZERO || !value.is_finite();
    let missing = |k: &usize| (0..set.len()).all(|i| empty(set.values(i)[*k]));
    let missing: Vec<usize> = lines.clone().filter(missing).collect();
    let mut filled: Option<FrfSet> = None;
    let mut findings = Vec::new();
    for run in missing.chunk_by(|a, b| a + 1 == *b) {
        let run = run[0]..run[run.len() - 1] + 1;
        let inside = run.start >= lines.start + INTERPOLATION_LINES
            && run.end + INTERPOLATION_LINES <= lines.end;
        let neighbours = || {
            (run.start - INTERPOLATION_LINES..run.start)
                .chain(run.end..run.end + INTERPOLATION_LINES)
        };
        if !inside || run.len() > MAX_OUTLIER_LINES || neighbours().any(|k| missing.contains(&k)) {
            continue;
        }
        let interpolated = filled.get_or_insert_with(|| set.clone());
        for i in 0..set.len() {
            for k in run.clone() {
                let terms = neighbours().map(|j| set.values(i)[j] * lagrange(k, j, neighbours()));
                interpolated.values_mut(i)[k] = terms.sum();
            }
        }
        let hz = set.axis().hz(run.start + run.len() / 2);
        let finding = Finding::new(Severity::Warning, Code::LineFilled, Location::Whole);
        findings.push(finding.value(hz, "Hz"));
    }
    filled.map(|set| (set, findings))
}

/// Lagrange polynomial at `k`: 1 at node `j` and 0 at the other nodes.
fn lagrange(k: usize, j: usize, nodes: impl Iterator<Item = usize>) -> f64 {
    let others = nodes.filter(|other| *other != j);
    let factor = |other: usize| (k as f64 - other as f64) / (j as f64 - other as f64);
    others.map(factor).product()
}

/// The set with its outlier lines replaced, with a finding for each; `None` where there are none.
pub(in crate::identify) fn replace_outlier_lines(
    set: &FrfSet,
    lines: Range<usize>,
) -> Option<(FrfSet, Vec<Finding>)> {
    let by_coherence = |i: usize| {
        let averages = set.functions()[i].averages;
        set.coherence(i).is_some() && averages.is_some_and(|n| n >= 2)
    };
    let unstated = (0..set.len()).filter(|i| set.variance(*i).is_none() && !by_coherence(*i));
    let functions: Vec<usize> = unstated.collect();
    let candidates = lines_of_high_curvature(set, &functions, lines.clone());
    let mut found: Vec<(Range<usize>, SmoothCurves)> = Vec::new();
    // The narrowest first: a wider outlier may contain it together with valid lines.
    for width in 1..=MAX_OUTLIER_LINES {
        let stencil = Stencil::new(width);
        for line in &candidates {
            let runs = (line + 1).saturating_sub(width)..=*line;
            let runs = runs.map(|start| start..start + width);
            let outlier = runs
                .filter(|run| {
                    run.start >= lines.start + NEIGHBOUR_LINES
                        && run.end + NEIGHBOUR_LINES <= lines.end
                })
                .filter(|run| !found.iter().any(|(other, _)| lines_overlap(run, other)))
                .find_map(|run| Some((run.clone(), stencil.outlier(set, &functions, run)?)));
            found.extend(outlier);
        }
    }
    if found.is_empty() {
        return None;
    }
    found.sort_by_key(|(run, _)| run.start);
    let mut replaced = set.clone();
    let mut findings = Vec::with_capacity(found.len());
    for (run, curves) in found {
        let hz = set.axis().hz(run.start + run.len() / 2);
        let finding = Finding::new(Severity::Warning, Code::SpikeReplaced, Location::Whole);
        findings.push(finding.value(hz, "Hz"));
        for (function, curve) in curves {
            replaced.values_mut(function)[run.clone()].copy_from_slice(&curve);
        }
    }
    Some((replaced, findings))
}

/// FRFs with their smooth curve on the lines of an outlier.
type SmoothCurves = Vec<(usize, Vec<Complex64>)>;

fn lines_overlap(one: &Range<usize>, other: &Range<usize>) -> bool {
    one.start < other.end && other.start < one.end
}

/// Lines where the curvature of the FRFs is far above that of the lines around.
fn lines_of_high_curvature(set: &FrfSet, functions: &[usize], lines: Range<usize>) -> Vec<usize> {
    let inner = lines.start + 1..lines.end.saturating_sub(1).max(lines.start + 1);
    let mut curvature = vec![0.0; inner.len()];
    for f in functions {
        let values = &set.values(*f)[lines.clone()];
        for (sum, three) in curvature.iter_mut().zip(values.windows(3)) {
            *sum += (three[1] - 0.5 * (three[0] + three[2])).norm_sqr();
        }
    }
    let exceeds_median = |k: &usize| {
        let around = k.saturating_sub(MEDIAN_HALF_WIDTH_LINES)
            ..(k + MEDIAN_HALF_WIDTH_LINES + 1).min(curvature.len());
        let mut around = curvature[around].to_vec();
        let middle = around.len() / 2;
        let median = *around.select_nth_unstable_by(middle, f64::total_cmp).1;
        curvature[*k] > MIN_CURVATURE_RATIO * median
    };
    let candidates = (0..curvature.len()).filter(exceeds_median);
    candidates.map(|k| inner.start + k).collect()
}

/// Least-squares fit of a smooth curve and skirts of a resonance to the lines on both sides of an
/// outlier: `coefficients = fit × neighbours`.
struct Stencil {
    /// Orthonormal columns over the neighbours: the smooth curve, then the skirts.
    columns: Vec<[f64; COEFFICIENTS]>,
    /// The smooth curve on the lines of the outlier, in coefficients of its columns.
    curve: Vec<[f64; SMOOTH_COEFFICIENTS]>,
    /// Residue R of `R/x` for each coefficient of the skirts.
    residue: [f64; COEFFICIENTS - SMOOTH_COEFFICIENTS],
    /// Factor D of `D/x²` for the last coefficient: two resonances of opposite residues leave no
    /// other skirts.
    pair: f64,
}

impl Stencil {
    fn new(width: usize) -> Self {
        let centre = NEIGHBOUR_LINES as f64 + 0.5 * (width as f64 - 1.0);
        let all = 2 * NEIGHBOUR_LINES + width;
        let scale = centre.max(1.0);
        let smooth = |line: usize| {
            let x = (line as f64 - centre) / scale;
            [1.0, x, x * x, x * x * x]
        };
        let neighbours: Vec<usize> = (0..NEIGHBOUR_LINES)
            .chain(NEIGHBOUR_LINES + width..all)
            .collect();
        let raw = linalg::real_matrix(neighbours.len(), COEFFICIENTS, |row, column| {
            let x = neighbours[row] as f64 - centre;
            match column {
                0..SMOOTH_COEFFICIENTS => smooth(neighbours[row])[column],
                SMOOTH_COEFFICIENTS => x.recip(),
                _ => (x * x).recip(),
            }
        });
        let upper =
            linalg::upper_triangle(&raw).expect("powers of small numbers, well conditioned");
        let columns =
            (0..neighbours.len()).map(|row| solve_row(&upper, |column| raw[(row, column)]));
        let columns = columns.collect();
        let on_spike = (NEIGHBOUR_LINES..NEIGHBOUR_LINES + width).map(|line| {
            let powers = smooth(line);
            let row: [f64; COEFFICIENTS] =
                solve_row(&upper, |column| powers.get(column).copied().unwrap_or(0.0));
            std::array::from_fn(|column| row[column])
        });
        // The last coefficients from the triangle: R is that of 1/x with 1/x² fitted jointly.
        let (a, b, c) = (
            upper[(SMOOTH_COEFFICIENTS, SMOOTH_COEFFICIENTS)],
            upper[(SMOOTH_COEFFICIENTS, SMOOTH_COEFFICIENTS + 1)],
            upper[(SMOOTH_COEFFICIENTS + 1, SMOOTH_COEFFICIENTS + 1)],
        );
        Self {
            columns,
            curve: on_spike.collect(),
            residue: [a.recip(), -b / (a * c)],
            pair: c.recip(),
        }
    }

    /// The smooth curves of the FRFs that have an outlier on these lines; `None` where the lines
    /// are no outlier.
    fn outlier(
        &self,
        set: &FrfSet,
        functions: &[usize],
        run: Range<usize>,
    ) -> Option<SmoothCurves> {
        let freedom = (self.columns.len() - COEFFICIENTS) as f64;
        let residue_gain: f64 = self.residue.iter().map(|gain| gain * gain).sum();
        let (mut height, mut skirts, mut scatter) = (0.0f64, 0.0f64, 0.0f64);
        let (mut pairs, mut scatter_of_pairs) = (0.0f64, 0.0f64);
        let mut curves = Vec::new();
        for f in functions {
            let values = set.values(*f);
            // Values that are not finite are reported, not replaced.
            let around = &values[run.start - NEIGHBOUR_LINES..run.end + NEIGHBOUR_LINES];
            if around.iter().any(|value| !value.norm_sqr().is_finite()) {
                return None;
            }
            let before = &values[run.start - NEIGHBOUR_LINES..run.start];
            let neighbours = before
                .iter()
                .chain(&values[run.end..run.end + NEIGHBOUR_LINES]);
            let mut coefficients = [Complex64::ZERO; COEFFICIENTS];
            let mut power = 0.0;
            for (value, row) in neighbours.zip(&self.columns) {
                power += value.norm_sqr();
                for (sum, column) in coefficients.iter_mut().zip(row) {
                    *sum += value * column;
                }
            }
            let explained: f64 = coefficients.iter().map(Complex64::norm_sqr).sum();
            let noise = (power - explained).max(f64::EPSILON * power) / freedom;
            let of_resonance = coefficients[SMOOTH_COEFFICIENTS..]
                .iter()
                .zip(&self.residue);
            let residue: Complex64 = of_resonance
                .map(|(coefficient, gain)| coefficient * gain)
                .sum();
            let variance = noise * residue_gain;
            skirts += residue.norm_sqr() - variance;
            scatter += variance * variance;
            let variance = noise * self.pair * self.pair;
            pairs += coefficients[COEFFICIENTS - 1].norm_sqr() * self.pair * self.pair - variance;
            scatter_of_pairs += variance * variance;
            let curve = self.curve.iter().map(|row| {
                let terms = row.iter().zip(&coefficients);
                terms
                    .map(|(power, coefficient)| coefficient * power)
                    .sum::<Complex64>()
            });
            let curve: Vec<Complex64> = curve.collect();
            let off = values[run.clone()].iter().zip(&curve);
            let highest = off.map(|(value, smooth)| (value - smooth).norm_sqr());
            let highest = highest.fold(0.0, f64::max);
            height += highest;
            if highest > MIN_OUTLIER_STDS * MIN_OUTLIER_STDS * noise {
                curves.push((*f, curve));
            }
        }
        // The mean of the skirts that noise alone makes is subtracted above; two standard
        // deviations of them remain.
        let scatter = scatter.sqrt();
        let are_pairs = pairs > MIN_RESIDUE_STDS * scatter_of_pairs.sqrt();
        if are_pairs
            && height
                < MIN_HEIGHT_OVER_SIGNIFICANT_RESIDUE * MIN_HEIGHT_OVER_SIGNIFICANT_RESIDUE * pairs
        {
            return None;
        }
        let over = if skirts > MIN_RESIDUE_STDS * scatter {
            MIN_HEIGHT_OVER_SIGNIFICANT_RESIDUE
        } else {
            MIN_HEIGHT_OVER_RESIDUE
        };
        let skirts = skirts.max(0.0) + 2.0 * scatter;
        (height > over * over * skirts).then_some(curves)
    }
}

/// `x` with `x R = row`, R an upper triangle.
fn solve_row<const N: usize>(upper: &RealMatrix, row: impl Fn(usize) -> f64) -> [f64; N] {
    let mut out = [0.0; N];
    for column in 0..N {
        let substituted: f64 = (0..column).map(|k| out[k] * upper[(k, column)]).sum();
        out[column] = (row(column) - substituted) / upper[(column, column)];
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::axis::FrequencyAxis;
    use crate::frf::{Function, FunctionData};
    use crate::identify::data::outlier_lines::*;
    use crate::quantity::FrfKind;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const LINES: usize = 200;
    const FUNCTIONS: usize = 5;
    /// Line of the resonance.
    const RESONANCE_LINE: f64 = 120.3;

    /// A resonance of γ lines to its half-power point, height 1 in the first FRF, with noise of
    /// this standard deviation.
    fn set(half_width: f64, at: f64, noise: f64, stated: bool) -> FrfSet {
        let step_hz = 0.5;
        let axis = FrequencyAxis {
            start_hz: 0.0,
            step_hz,
            len: LINES,
        };
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut set = FrfSet::new(axis);
        for number in 0..FUNCTIONS {
            let height = half_width / (1.0 + number as f64);
            let values = (0..LINES).map(|k| {
                let resonance = height / Complex64::new(half_width, k as f64 - at);
                resonance + noise * Complex64::new(normal(), normal()) / 2f64.sqrt()
            });
            let function = Function {
                response: format!("{}:+Z", number + 1).parse().expect("a point"),
                reference: "1:+Z".parse().expect("a point"),
                kind: FrfKind::Receptance,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values: values.collect(),
                coherence: None,
                variance: stated.then(|| vec![noise * noise; LINES]),
            };
            set.push(function, data).expect("functions that differ");
        }
        set
    }

    /// With outliers of these heights from a line on, at varying phases.
    fn with_outlier(mut set: FrfSet, from: usize, heights: &[f64]) -> FrfSet {
        for i in 0..set.len() {
            for (j, height) in heights.iter().enumerate() {
                let phase = (i * 7 + j * 3) as f64;
                set.values_mut(i)[from + j] += Complex64::from_polar(*height, phase);
            }
        }
        set
    }

    #[test]
    fn outliers_of_one_to_three_lines_are_interpolated_from_their_neighbours() {
        let noise = 1e-3;
        let clean = set(2.0, RESONANCE_LINE, noise, false);
        for (heights, from) in [
            (vec![0.3], 40),
            (vec![30.0], 100),
            (vec![0.2, 0.4], 60),
            (vec![0.3, 0.5, 0.2], 80),
        ] {
            let with = with_outlier(clean.clone(), from, &heights);
            let (without, findings) =
                replace_outlier_lines(&with, 1..LINES).expect("a outlier far above the noise");
            assert_eq!(findings.len(), 1, "{heights:?}");
            let middle = 0.5 * (from + heights.len() / 2) as f64;
            assert_eq!(findings[0].value, Some(middle));
            for i in 0..FUNCTIONS {
                for k in 0..LINES {
                    let on_it = (from..from + heights.len()).contains(&k);
                    let error = (without.values(i)[k] - clean.values(i)[k]).norm();
                    let limit = if on_it { 5.0 * noise } else { 0.0 };
                    assert!(error <= limit, "{heights:?} {i} {k}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn values_that_are_not_finite_are_not_replaced_as_outliers() {
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            for from in [48, 50, 52] {
                let mut with = with_outlier(set(2.0, RESONANCE_LINE, 1e-3, false), 50, &[1.0]);
                with.values_mut(1)[from] = bad.into();
                assert!(
                    replace_outlier_lines(&with, 1..LINES).is_none(),
                    "{bad} {from}"
                );
            }
        }
    }

    #[test]
    fn frfs_without_the_outlier_are_unchanged() {
        let clean = set(2.0, RESONANCE_LINE, 1e-3, false);
        let mut with = clean.clone();
        with.values_mut(2)[50] += 1.0;
        let (without, _) =
            replace_outlier_lines(&with, 1..LINES).expect("one function has a outlier");
        for i in [0, 1, 3, 4] {
            assert_eq!(without.values(i), clean.values(i));
        }
        assert!((without.values(2)[50] - clean.values(2)[50]).norm() < 5e-3);
    }

    #[test]
    fn the_narrowest_resonance_of_a_record_is_no_outlier_line() {
        for half_width in [0.02, 0.1, 0.2, 0.5, 1.0, 3.0] {
            for at in [120.0, 120.25, 120.5] {
                // The residue of the narrowest is only this far above the noise.
                let largest_noise = if half_width < 0.1 { 1e-3 } else { 1e-2 };
                for noise in [0.0, 1e-6, 1e-3, largest_noise] {
                    let replaced =
                        replace_outlier_lines(&set(half_width, at, noise, false), 1..LINES);
                    assert!(replaced.is_none(), "{half_width} {at} {noise}");
                }
            }
        }
    }

    #[test]
    fn missing_lines_are_interpolated_with_a_finding() {
        let clean = set(8.0, RESONANCE_LINE, 0.0, false);
        for value in [0.0, f64::NAN] {
            for run in [60..61, 80..82, 119..120, 110..113] {
                let mut with = clean.clone();
                for i in 0..FUNCTIONS {
                    with.values_mut(i)[run.clone()].fill(value.into());
                }
                let (whole, findings) =
                    interpolate_missing_lines(&with, 1..LINES).expect("lines without a value");
                let middle = 0.5 * (run.start + run.len() / 2) as f64;
                let reported: Vec<_> = findings.iter().map(|f| (f.code, f.value)).collect();
                assert_eq!(reported, [(Code::LineFilled, Some(middle))]);
                for i in 0..FUNCTIONS {
                    for k in 0..LINES {
                        let error = (whole.values(i)[k] - clean.values(i)[k]).norm();
                        let limit = if run.contains(&k) { 2e-3 } else { 0.0 };
                        assert!(error <= limit, "{run:?} {i} {k} {error:e}");
                    }
                }
                with.values_mut(3)[run.start] = Complex64::ONE;
                with.values_mut(3)[run.end - 1] = Complex64::ONE;
                let partly_missing = interpolate_missing_lines(&with, 1..LINES);
                assert_eq!(partly_missing.is_some(), run.len() == 3, "{run:?}");
            }
        }
        let mut wide = clean.clone();
        for i in 0..FUNCTIONS {
            wide.values_mut(i)[60..64].fill(Complex64::ZERO);
            wide.values_mut(i)[LINES - 2..].fill(Complex64::ZERO);
        }
        assert!(interpolate_missing_lines(&wide, 1..LINES).is_none());
        assert!(
            interpolate_missing_lines(&set(8.0, RESONANCE_LINE, 0.1, true), 1..LINES).is_none()
        );
    }

    #[test]
    fn two_close_modes_of_opposite_residues_are_no_outlier_line() {
        for half_width in [0.05, 0.1, 0.3] {
            for separation in [0.4, 1.0, 1.5] {
                for at in [120.0, 120.3, 120.6] {
                    let noise = 1e-4;
                    let mut both = set(half_width, at, noise, false);
                    let other = set(half_width, at + separation, 0.0, false);
                    for i in 0..FUNCTIONS {
                        let other = other.values(i).iter();
                        let values = both.values_mut(i).iter_mut();
                        values.zip(other).for_each(|(value, other)| *value -= other);
                    }
                    let replaced = replace_outlier_lines(&both, 1..LINES);
                    assert!(replaced.is_none(), "{half_width} {separation} {at}");
                }
            }
        }
    }

    #[test]
    fn outliers_remain_where_the_data_have_variances() {
        let with = with_outlier(set(2.0, RESONANCE_LINE, 1e-3, true), 40, &[1.0]);
        assert!(replace_outlier_lines(&with, 1..LINES).is_none());
    }

    #[test]
    fn outliers_outside_the_searched_lines_are_not_reported() {
        let with = with_outlier(set(2.0, RESONANCE_LINE, 1e-3, false), 40, &[1.0]);
        assert!(replace_outlier_lines(&with, 60..LINES).is_none());
        assert!(replace_outlier_lines(&with, 0..0).is_none());
    }
}

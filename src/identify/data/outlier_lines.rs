//! Lines that tell nothing: without a value in any function, and those that stand alone out of
//! their neighbours, as the mains leave them in averages of few hits: they are replaced by what the
//! neighbours say, where the data bring no variance that would tell.
//!
//! A resonance between two lines is seen on all lines around it, `R/(x − x₀)` with the distance x
//! in lines and its residue R: one of γ lines to the half-power point is `R/γ` high. What stands at
//! most three lines wide on a smooth course (a polynomial of the third degree through six lines on
//! either side) without such skirts (`1/x` and `1/x²` fitted with it) is no resonance that so short
//! a record could hold: it would be narrower than 0.04 lines, or than 0.01 where there are skirts
//! that noise does not explain.

use std::ops::Range;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::linalg::{self, RealMatrix};

/// Lines on either side that tell the course.
const BESIDE: usize = 6;
/// Widest spike, lines.
const WIDEST: usize = 3;
/// Coefficients of the smooth course.
const SMOOTH: usize = 4;
/// Coefficients with the skirts of a resonance.
const ALL: usize = SMOOTH + 2;
/// A spike is higher than this many residues of the resonance that it might be, over all functions,
/// and than more of them where these are so many deviations from 0.
const OVER_SKIRTS: f64 = 25.0;
const OVER_SURE_SKIRTS: f64 = 100.0;
const SURE: f64 = 4.0;
/// A function has part in a spike that is so many deviations of its noise high.
const SEEN: f64 = 5.0;
/// Bend at a line, as power over the median of its neighbourhood, that is looked at more closely.
const BENT: f64 = 50.0;
/// Lines on either side of which that median is.
const AROUND: usize = 12;

/// Lines on either side from which one without a value is filled in.
const FILLED_FROM: usize = 3;

/// The set with its blank lines filled in, with a finding of each run of them; `None` where there
/// are none.
///
/// Blank is a line that is 0 or no number in every function, up to three side by side, of functions
/// without variances. It gets the polynomial through three lines on either side.
pub(in crate::identify) fn filled(
    set: &FrfSet,
    lines: Range<usize>,
) -> Option<(FrfSet, Vec<Finding>)> {
    if (0..set.len()).any(|i| set.variance(i).is_some()) {
        return None;
    }
    let empty = |value: Complex64| value == Complex64::ZERO || !value.is_finite();
    let blank = |k: &usize| (0..set.len()).all(|i| empty(set.values(i)[*k]));
    let blank: Vec<usize> = lines.clone().filter(blank).collect();
    let mut filled: Option<FrfSet> = None;
    let mut findings = Vec::new();
    for run in blank.chunk_by(|a, b| a + 1 == *b) {
        let run = run[0]..run[run.len() - 1] + 1;
        let inside = run.start >= lines.start + FILLED_FROM && run.end + FILLED_FROM <= lines.end;
        let beside = || (run.start - FILLED_FROM..run.start).chain(run.end..run.end + FILLED_FROM);
        if !inside || run.len() > WIDEST || beside().any(|k| blank.contains(&k)) {
            continue;
        }
        let own = filled.get_or_insert_with(|| set.clone());
        for i in 0..set.len() {
            for k in run.clone() {
                let terms = beside().map(|j| set.values(i)[j] * lagrange(k, j, beside()));
                own.values_mut(i)[k] = terms.sum();
            }
        }
        let hz = set.axis().hz(run.start + run.len() / 2);
        let finding = Finding::new(Severity::Warning, Code::LineFilled, Place::Whole);
        findings.push(finding.value(hz, "Hz"));
    }
    filled.map(|set| (set, findings))
}

/// At `k`, the polynomial that is 1 at `j` and 0 at the other places.
fn lagrange(k: usize, j: usize, places: impl Iterator<Item = usize>) -> f64 {
    let others = places.filter(|other| *other != j);
    let factor = |other: usize| (k as f64 - other as f64) / (j as f64 - other as f64);
    others.map(factor).product()
}

/// The set without its spikes, with a finding of each; `None` where there are none.
pub(in crate::identify) fn without_spikes(
    set: &FrfSet,
    lines: Range<usize>,
) -> Option<(FrfSet, Vec<Finding>)> {
    let by_coherence = |i: usize| {
        let averages = set.functions()[i].averages;
        set.coherence(i).is_some() && averages.is_some_and(|n| n >= 2)
    };
    let unstated = (0..set.len()).filter(|i| set.variance(*i).is_none() && !by_coherence(*i));
    let functions: Vec<usize> = unstated.collect();
    let bent = bent(set, &functions, lines.clone());
    let mut found: Vec<(Range<usize>, Courses)> = Vec::new();
    // The narrowest first: a wider one may hold it with sound lines beside it.
    for width in 1..=WIDEST {
        let stencil = Stencil::new(width);
        for line in &bent {
            let runs = (line + 1).saturating_sub(width)..=*line;
            let runs = runs.map(|start| start..start + width);
            let own = runs
                .filter(|run| run.start >= lines.start + BESIDE && run.end + BESIDE <= lines.end)
                .filter(|run| !found.iter().any(|(other, _)| overlap(run, other)))
                .find_map(|run| Some((run.clone(), stencil.spike(set, &functions, run)?)));
            found.extend(own);
        }
    }
    if found.is_empty() {
        return None;
    }
    found.sort_by_key(|(run, _)| run.start);
    let mut replaced = set.clone();
    let mut findings = Vec::with_capacity(found.len());
    for (run, courses) in found {
        let hz = set.axis().hz(run.start + run.len() / 2);
        let finding = Finding::new(Severity::Warning, Code::SpikeReplaced, Place::Whole);
        findings.push(finding.value(hz, "Hz"));
        for (function, course) in courses {
            replaced.values_mut(function)[run.clone()].copy_from_slice(&course);
        }
    }
    Some((replaced, findings))
}

/// Functions with their course on the lines of a spike.
type Courses = Vec<(usize, Vec<Complex64>)>;

fn overlap(one: &Range<usize>, other: &Range<usize>) -> bool {
    one.start < other.end && other.start < one.end
}

/// Lines where the functions bend by far more than around them.
fn bent(set: &FrfSet, functions: &[usize], lines: Range<usize>) -> Vec<usize> {
    let inner = lines.start + 1..lines.end.saturating_sub(1).max(lines.start + 1);
    let mut bend = vec![0.0; inner.len()];
    for f in functions {
        let values = &set.values(*f)[lines.clone()];
        for (sum, three) in bend.iter_mut().zip(values.windows(3)) {
            *sum += (three[1] - 0.5 * (three[0] + three[2])).norm_sqr();
        }
    }
    let stands_out = |k: &usize| {
        let around = k.saturating_sub(AROUND)..(k + AROUND + 1).min(bend.len());
        let mut around = bend[around].to_vec();
        let middle = around.len() / 2;
        let median = *around.select_nth_unstable_by(middle, f64::total_cmp).1;
        bend[*k] > BENT * median
    };
    let bent = (0..bend.len()).filter(stands_out);
    bent.map(|k| inner.start + k).collect()
}

/// What the lines on both sides of a spike of some lines tell of it: `coefficients = fit ×
/// neighbours`, all neighbours in order.
struct Stencil {
    /// Orthonormal columns over the neighbours: the smooth course, then the skirts beside it.
    columns: Vec<[f64; ALL]>,
    /// The smooth course on the lines of the spike, in coefficients of its columns.
    course: Vec<[f64; SMOOTH]>,
    /// Residue R of `R/x` for each coefficient of the skirts.
    residue: [f64; ALL - SMOOTH],
    /// Factor D of `D/x²` for the last coefficient: two resonances of opposite residues leave no
    /// other skirts.
    pair: f64,
}

impl Stencil {
    fn new(width: usize) -> Self {
        let centre = BESIDE as f64 + 0.5 * (width as f64 - 1.0);
        let all = 2 * BESIDE + width;
        let reach = centre.max(1.0);
        let smooth = |line: usize| {
            let x = (line as f64 - centre) / reach;
            [1.0, x, x * x, x * x * x]
        };
        let beside: Vec<usize> = (0..BESIDE).chain(BESIDE + width..all).collect();
        let raw = linalg::real_matrix(beside.len(), ALL, |row, column| {
            let x = beside[row] as f64 - centre;
            match column {
                0..SMOOTH => smooth(beside[row])[column],
                SMOOTH => x.recip(),
                _ => (x * x).recip(),
            }
        });
        let upper =
            linalg::upper_triangle(&raw).expect("powers of small numbers, well conditioned");
        let columns = (0..beside.len()).map(|row| solve_row(&upper, |column| raw[(row, column)]));
        let columns = columns.collect();
        let on_spike = (BESIDE..BESIDE + width).map(|line| {
            let own = smooth(line);
            let row: [f64; ALL] =
                solve_row(&upper, |column| own.get(column).copied().unwrap_or(0.0));
            std::array::from_fn(|column| row[column])
        });
        // The last coefficients from the triangle: R is that of 1/x with 1/x² fitted beside it.
        let (a, b, c) = (
            upper[(SMOOTH, SMOOTH)],
            upper[(SMOOTH, SMOOTH + 1)],
            upper[(SMOOTH + 1, SMOOTH + 1)],
        );
        Self {
            columns,
            course: on_spike.collect(),
            residue: [a.recip(), -b / (a * c)],
            pair: c.recip(),
        }
    }

    /// The courses of the functions that take part in a spike on these lines; `None` where it is
    /// none.
    fn spike(&self, set: &FrfSet, functions: &[usize], run: Range<usize>) -> Option<Courses> {
        let freedom = (self.columns.len() - ALL) as f64;
        let residue_gain: f64 = self.residue.iter().map(|own| own * own).sum();
        let (mut height, mut skirts, mut scatter) = (0.0f64, 0.0f64, 0.0f64);
        let (mut pairs, mut scatter_of_pairs) = (0.0f64, 0.0f64);
        let mut courses = Vec::new();
        for f in functions {
            let values = set.values(*f);
            // What is no measurement at all is to be named, not mended.
            let around = &values[run.start - BESIDE..run.end + BESIDE];
            if around.iter().any(|value| !value.norm_sqr().is_finite()) {
                return None;
            }
            let before = &values[run.start - BESIDE..run.start];
            let beside = before.iter().chain(&values[run.end..run.end + BESIDE]);
            let mut coefficients = [Complex64::ZERO; ALL];
            let mut power = 0.0;
            for (value, row) in beside.zip(&self.columns) {
                power += value.norm_sqr();
                for (sum, column) in coefficients.iter_mut().zip(row) {
                    *sum += value * column;
                }
            }
            let explained: f64 = coefficients.iter().map(Complex64::norm_sqr).sum();
            let noise = (power - explained).max(f64::EPSILON * power) / freedom;
            let of_resonance = coefficients[SMOOTH..].iter().zip(&self.residue);
            let residue: Complex64 = of_resonance.map(|(own, gain)| own * gain).sum();
            let variance = noise * residue_gain;
            skirts += residue.norm_sqr() - variance;
            scatter += variance * variance;
            let variance = noise * self.pair * self.pair;
            pairs += coefficients[ALL - 1].norm_sqr() * self.pair * self.pair - variance;
            scatter_of_pairs += variance * variance;
            let course = self.course.iter().map(|row| {
                let terms = row.iter().zip(&coefficients);
                terms
                    .map(|(own, coefficient)| coefficient * own)
                    .sum::<Complex64>()
            });
            let course: Vec<Complex64> = course.collect();
            let off = values[run.clone()].iter().zip(&course);
            let highest = off.map(|(value, own)| (value - own).norm_sqr());
            let highest = highest.fold(0.0, f64::max);
            height += highest;
            if highest > SEEN * SEEN * noise {
                courses.push((*f, course));
            }
        }
        // Of what the noise makes of skirts that are not there, the mean is known and taken off;
        // two deviations of it stay.
        let scatter = scatter.sqrt();
        let are_pairs = pairs > SURE * scatter_of_pairs.sqrt();
        if are_pairs && height < OVER_SURE_SKIRTS * OVER_SURE_SKIRTS * pairs {
            return None;
        }
        let over = if skirts > SURE * scatter {
            OVER_SURE_SKIRTS
        } else {
            OVER_SKIRTS
        };
        let skirts = skirts.max(0.0) + 2.0 * scatter;
        (height > over * over * skirts).then_some(courses)
    }
}

/// `x` with `x R = row`, R an upper triangle.
fn solve_row<const N: usize>(upper: &RealMatrix, row: impl Fn(usize) -> f64) -> [f64; N] {
    let mut out = [0.0; N];
    for column in 0..N {
        let known: f64 = (0..column).map(|k| out[k] * upper[(k, column)]).sum();
        out[column] = (row(column) - known) / upper[(column, column)];
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
    const AT: f64 = 120.3;

    /// A resonance of γ lines to its half-power point, 1 high in the first function, over noise of
    /// this deviation.
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

    /// With spikes of these heights from a line on, in turning phases.
    fn spiked(mut set: FrfSet, from: usize, heights: &[f64]) -> FrfSet {
        for i in 0..set.len() {
            for (j, height) in heights.iter().enumerate() {
                let phase = (i * 7 + j * 3) as f64;
                set.values_mut(i)[from + j] += Complex64::from_polar(*height, phase);
            }
        }
        set
    }

    #[test]
    fn spikes_of_one_to_three_lines_are_replaced_by_their_neighbours() {
        let noise = 1e-3;
        let clean = set(2.0, AT, noise, false);
        for (heights, from) in [
            (vec![0.3], 40),
            (vec![30.0], 100),
            (vec![0.2, 0.4], 60),
            (vec![0.3, 0.5, 0.2], 80),
        ] {
            let with = spiked(clean.clone(), from, &heights);
            let (without, findings) =
                without_spikes(&with, 1..LINES).expect("a spike far above the noise");
            assert_eq!(findings.len(), 1, "{heights:?}");
            let middle = 0.5 * (from + heights.len() / 2) as f64;
            assert_eq!(findings[0].value, Some(middle));
            for i in 0..FUNCTIONS {
                for k in 0..LINES {
                    let on_it = (from..from + heights.len()).contains(&k);
                    let error = (without.values(i)[k] - clean.values(i)[k]).norm();
                    let most = if on_it { 5.0 * noise } else { 0.0 };
                    assert!(error <= most, "{heights:?} {i} {k}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn a_value_that_is_no_number_is_named_and_not_mended() {
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            for from in [48, 50, 52] {
                let mut with = spiked(set(2.0, AT, 1e-3, false), 50, &[1.0]);
                with.values_mut(1)[from] = bad.into();
                assert!(without_spikes(&with, 1..LINES).is_none(), "{bad} {from}");
            }
        }
    }

    #[test]
    fn a_function_without_the_spike_stays_as_it_is() {
        let clean = set(2.0, AT, 1e-3, false);
        let mut with = clean.clone();
        with.values_mut(2)[50] += 1.0;
        let (without, _) = without_spikes(&with, 1..LINES).expect("one function has a spike");
        for i in [0, 1, 3, 4] {
            assert_eq!(without.values(i), clean.values(i));
        }
        assert!((without.values(2)[50] - clean.values(2)[50]).norm() < 5e-3);
    }

    #[test]
    fn no_resonance_is_a_spike_however_narrow_a_record_lets_it_be() {
        for half_width in [0.02, 0.1, 0.2, 0.5, 1.0, 3.0] {
            for at in [120.0, 120.25, 120.5] {
                // The residue of the narrowest is but so far above the noise.
                let most = if half_width < 0.1 { 1e-3 } else { 1e-2 };
                for noise in [0.0, 1e-6, 1e-3, most] {
                    let own = without_spikes(&set(half_width, at, noise, false), 1..LINES);
                    assert!(own.is_none(), "{half_width} {at} {noise}");
                }
            }
        }
    }

    #[test]
    fn a_line_without_a_value_in_any_function_is_filled_in() {
        let clean = set(8.0, AT, 0.0, false);
        for value in [0.0, f64::NAN] {
            for run in [60..61, 80..82, 119..120, 110..113] {
                let mut with = clean.clone();
                for i in 0..FUNCTIONS {
                    with.values_mut(i)[run.clone()].fill(value.into());
                }
                let (whole, findings) = filled(&with, 1..LINES).expect("lines without a value");
                let middle = 0.5 * (run.start + run.len() / 2) as f64;
                let told: Vec<_> = findings.iter().map(|own| (own.code, own.value)).collect();
                assert_eq!(told, [(Code::LineFilled, Some(middle))]);
                for i in 0..FUNCTIONS {
                    for k in 0..LINES {
                        let error = (whole.values(i)[k] - clean.values(i)[k]).norm();
                        let most = if run.contains(&k) { 2e-3 } else { 0.0 };
                        assert!(error <= most, "{run:?} {i} {k} {error:e}");
                    }
                }
                with.values_mut(3)[run.start] = Complex64::ONE;
                with.values_mut(3)[run.end - 1] = Complex64::ONE;
                let own = filled(&with, 1..LINES);
                assert_eq!(own.is_some(), run.len() == 3, "{run:?}");
            }
        }
        let mut wide = clean.clone();
        for i in 0..FUNCTIONS {
            wide.values_mut(i)[60..64].fill(Complex64::ZERO);
            wide.values_mut(i)[LINES - 2..].fill(Complex64::ZERO);
        }
        assert!(filled(&wide, 1..LINES).is_none());
        assert!(filled(&set(8.0, AT, 0.1, true), 1..LINES).is_none());
    }

    #[test]
    fn two_modes_of_opposite_residues_are_no_spike() {
        for half_width in [0.05, 0.1, 0.3] {
            for apart in [0.4, 1.0, 1.5] {
                for at in [120.0, 120.3, 120.6] {
                    let noise = 1e-4;
                    let mut both = set(half_width, at, noise, false);
                    let other = set(half_width, at + apart, 0.0, false);
                    for i in 0..FUNCTIONS {
                        let other = other.values(i).iter();
                        let own = both.values_mut(i).iter_mut();
                        own.zip(other).for_each(|(own, other)| *own -= other);
                    }
                    let own = without_spikes(&both, 1..LINES);
                    assert!(own.is_none(), "{half_width} {apart} {at}");
                }
            }
        }
    }

    #[test]
    fn what_the_data_state_of_their_noise_is_left_to_them() {
        let with = spiked(set(2.0, AT, 1e-3, true), 40, &[1.0]);
        assert!(without_spikes(&with, 1..LINES).is_none());
    }

    #[test]
    fn spikes_beside_the_lines_that_are_looked_at_are_not_told() {
        let with = spiked(set(2.0, AT, 1e-3, false), 40, &[1.0]);
        assert!(without_spikes(&with, 60..LINES).is_none());
        assert!(without_spikes(&with, 0..0).is_none());
    }
}

//! FRF correlation compares two sets of FRFs: each FRF over frequency (FRAC), and all FRFs at each
//! frequency line.

use std::collections::BTreeMap;

use num_complex::Complex64;
use serde::Serialize;

use crate::axis::Band;
use crate::dof::{Axis, Dof};
use crate::frf::{FrfSet, convert};

use super::super::CorrelateError;

/// Maximum distance of equal lines of two axes, over the spacing of the first axis.
const MAX_LINE_OFFSET: f64 = 0.05;

/// Number of equal bands over which the criteria of the lines are averaged.
const BANDS: usize = 10;

/// One function that both sets have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FunctionCorrelation {
    /// Response, as the first set names it.
    pub response: Dof,
    /// Reference, as the first set names it.
    pub reference: Dof,
    /// Frequency response assurance criterion `|Σ H_a* H_b|² / (Σ |H_a|² Σ |H_b|²)` over the lines,
    /// 0 to 1; `None` where one is zero at all of them.
    pub frac: Option<f64>,
    /// `20 log10(rms H_b / rms H_a)`, dB; `None` as for `frac`.
    pub level_db: Option<f64>,
}

/// All common functions at one line, as two vectors `H_a` and `H_b`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LineCorrelation {
    /// Frequency, Hz.
    pub hz: f64,
    /// Global shape criterion `|H_a^H H_b|² / (H_a^H H_a · H_b^H H_b)`, 0 to 1, independent of
    /// amplitude; `None` where one is zero.
    pub shape: Option<f64>,
    /// Global amplitude criterion `2 |H_a^H H_b| / (H_a^H H_a + H_b^H H_b)`, 0 to 1, 1 for equal
    /// vectors; `None` where both are zero.
    pub amplitude: Option<f64>,
}

/// Statistics of the line criteria over a part of the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BandCorrelation {
    /// Lower edge, Hz.
    pub lo_hz: f64,
    /// Upper edge, Hz.
    pub hi_hz: f64,
    /// Number of lines.
    pub lines: usize,
    /// Mean of the shape criterion over the lines that have one.
    pub mean_shape: Option<f64>,
    /// Least of them.
    pub least_shape: Option<f64>,
    /// Mean of the amplitude criterion.
    pub mean_amplitude: Option<f64>,
    /// Least of them.
    pub least_amplitude: Option<f64>,
}

/// Two sets of FRFs on the lines and functions that both have, in the kind of the first.
///
/// # Reference
/// Heylen and Lammens (1996), FRAC: a consistent way of comparing frequency response functions,
/// Identification in Engineering Systems, Swansea; Zang, Grafe and Imregun (2001), Frequency-domain
/// criteria for correlating and updating dynamic finite element models, Mechanical Systems and
/// Signal Processing 15(1), 139 (shape and amplitude criterion at each line; over the functions of
/// one reference the latter is also known as FAAC).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrfCorrelation {
    /// SI unit in which both are compared: that of the first set.
    pub unit: &'static str,
    /// Functions, by response and reference; their number is that of the components of the vectors
    /// at each line.
    pub functions: Vec<FunctionCorrelation>,
    /// Functions of the first set that the second does not have.
    pub first_alone: usize,
    /// Functions of the second set that the first does not have.
    pub second_alone: usize,
    /// Correlation at each line.
    pub lines: Vec<LineCorrelation>,
    /// Statistics over equal parts of the band.
    pub bands: Vec<BandCorrelation>,
}

type Label = (String, Axis, u32);

fn label(dof: &Dof) -> Label {
    (dof.point().to_owned(), dof.axis(), dof.repeat())
}

/// Compares two sets of FRFs on their common lines and functions, with the signs of sensors and
/// hits.
///
/// The second set is converted to the kind (receptance, mobility, accelerance) of the first one's
/// first function.
///
/// # Errors
/// [`CorrelateError::NoCommonFunction`], [`CorrelateError::NoCommonLine`] where fewer than two
/// lines inside the band are the same.
pub fn frf_correlation(
    first: &FrfSet,
    second: &FrfSet,
    band: Option<Band>,
) -> Result<FrfCorrelation, CorrelateError> {
    let no_function = || CorrelateError::NoCommonFunction {
        got_first: first.len(),
        got_second: second.len(),
    };
    let kind = first.functions().first().ok_or_else(no_function)?.kind;
    let (first, second) = (convert(first, kind), convert(second, kind));
    let pairs = common_functions(&first, &second);
    if pairs.is_empty() {
        return Err(no_function());
    }
    let lines = common_lines(&first, &second, band);
    if lines.len() < 2 {
        return Err(CorrelateError::NoCommonLine {
            got_first_hz: first.axis().step_hz,
            got_second_hz: second.axis().step_hz,
            common: lines.len(),
        });
    }
    let common = CommonLines {
        first: &first,
        second: &second,
        lines: &lines,
    };
    let by_line: Vec<LineCorrelation> = (0..lines.len()).map(|k| common.line(k, &pairs)).collect();
    Ok(FrfCorrelation {
        unit: kind.si_unit(),
        functions: pairs.iter().map(|pair| common.function(pair)).collect(),
        first_alone: first.len() - pairs.len(),
        second_alone: second.len() - pairs.len(),
        bands: bands(&by_line),
        lines: by_line,
    })
}

/// Indices of a function in both sets, and the product of the signs of its sensors and hits.
struct FunctionPair {
    first: usize,
    second: usize,
    sign: f64,
}

fn common_functions(first: &FrfSet, second: &FrfSet) -> Vec<FunctionPair> {
    let key = |set: &FrfSet, i: usize| {
        let function = &set.functions()[i];
        let sign = function.response.sign() * function.reference.sign();
        (
            (label(&function.response), label(&function.reference)),
            sign,
        )
    };
    let of_second: BTreeMap<_, _> = (0..second.len())
        .map(|j| {
            let (name, sign) = key(second, j);
            (name, (j, sign))
        })
        .collect();
    let mut pairs: Vec<FunctionPair> = Vec::new();
    for i in 0..first.len() {
        let (name, sign_of_first) = key(first, i);
        if let Some(&(j, sign)) = of_second.get(&name)
            && pairs.iter().all(|pair| pair.second != j)
        {
            let sign = sign_of_first * sign;
            let (first, second) = (i, j);
            pairs.push(FunctionPair {
                first,
                second,
                sign,
            });
        }
    }
    let name = |pair: &FunctionPair| {
        let function = &first.functions()[pair.first];
        (function.response.clone(), function.reference.clone())
    };
    pairs.sort_by_key(name);
    pairs
}

/// Indices of the lines that both axes have.
fn common_lines(first: &FrfSet, second: &FrfSet, band: Option<Band>) -> Vec<(usize, usize)> {
    let (a, b) = (first.axis(), second.axis());
    let inside = band.map_or(0..a.len, |band| a.lines(&band));
    let same = |k: usize| {
        let other = b.nearest(a.hz(k))?;
        let apart = (b.hz(other) - a.hz(k)).abs();
        (apart <= MAX_LINE_OFFSET * a.step_hz).then_some((k, other))
    };
    inside.filter_map(same).collect()
}

struct CommonLines<'a> {
    first: &'a FrfSet,
    second: &'a FrfSet,
    lines: &'a [(usize, usize)],
}

/// `Σ a* b`, `Σ |a|²`, `Σ |b|²`.
fn sums(values: impl Iterator<Item = (Complex64, Complex64)>) -> (Complex64, f64, f64) {
    let start = (Complex64::ZERO, 0.0, 0.0);
    values.fold(start, |(cross, first, second), (a, b)| {
        let cross = cross + a.conj() * b;
        (cross, first + a.norm_sqr(), second + b.norm_sqr())
    })
}

impl CommonLines<'_> {
    fn value(&self, pair: &FunctionPair, k: usize) -> (Complex64, Complex64) {
        let (a, b) = self.lines[k];
        let second = self.second.values(pair.second)[b] * pair.sign;
        (self.first.values(pair.first)[a], second)
    }

    fn function(&self, pair: &FunctionPair) -> FunctionCorrelation {
        let values = (0..self.lines.len()).map(|k| self.value(pair, k));
        let (cross, a, b) = sums(values);
        let function = &self.first.functions()[pair.first];
        let defined = a > 0.0 && b > 0.0;
        FunctionCorrelation {
            response: function.response.clone(),
            reference: function.reference.clone(),
            frac: defined.then(|| ratio(cross, a, b)),
            level_db: defined.then(|| 10.0 * (b / a).log10()),
        }
    }

    fn line(&self, k: usize, pairs: &[FunctionPair]) -> LineCorrelation {
        let (cross, a, b) = sums(pairs.iter().map(|pair| self.value(pair, k)));
        LineCorrelation {
            hz: self.first.axis().hz(self.lines[k].0),
            shape: (a > 0.0 && b > 0.0).then(|| ratio(cross, a, b)),
            amplitude: (a + b > 0.0).then(|| (2.0 * cross.norm() / (a + b)).min(1.0)),
        }
    }
}

/// `|cross|² / (a b)`, without a square that leaves the range of numbers.
fn ratio(cross: Complex64, a: f64, b: f64) -> f64 {
    (cross.norm() / a.sqrt() / b.sqrt()).powi(2).min(1.0)
}

fn bands(lines: &[LineCorrelation]) -> Vec<BandCorrelation> {
    let size = lines.len().div_ceil(BANDS);
    let mean = |values: &[f64]| {
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let least = |values: &[f64]| values.iter().copied().reduce(f64::min);
    let band = |part: &[LineCorrelation]| {
        let shape: Vec<f64> = part.iter().filter_map(|line| line.shape).collect();
        let amplitude: Vec<f64> = part.iter().filter_map(|line| line.amplitude).collect();
        BandCorrelation {
            lo_hz: part[0].hz,
            hi_hz: part[part.len() - 1].hz,
            lines: part.len(),
            mean_shape: mean(&shape),
            least_shape: least(&shape),
            mean_amplitude: mean(&amplitude),
            least_amplitude: least(&amplitude),
        }
    };
    lines.chunks(size.max(1)).map(band).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::frf::{Function, FunctionData};
    use crate::quantity::FrfKind;

    fn axis(start_hz: f64, step_hz: f64, len: usize) -> FrequencyAxis {
        FrequencyAxis {
            start_hz,
            step_hz,
            len,
        }
    }

    fn set(axis: FrequencyAxis, kind: FrfKind, functions: &[(&str, Vec<Complex64>)]) -> FrfSet {
        let mut set = FrfSet::new(axis);
        for (response, values) in functions {
            let function = Function {
                response: response.parse().expect("a degree of freedom"),
                reference: "9:+Z".parse().expect("a degree of freedom"),
                kind,
                averages: None,
                estimator: None,
                variance_dof: None,
            };
            let data = FunctionData {
                values: values.clone(),
                ..FunctionData::default()
            };
            set.push(function, data)
                .expect("functions of one axis, each once");
        }
        set
    }

    fn curve(len: usize, root: f64) -> Vec<Complex64> {
        let line = |k: usize| Complex64::new(root - k as f64, 0.3).inv();
        (0..len).map(line).collect()
    }

    #[test]
    fn a_set_that_is_larger_by_a_factor_has_its_shape_and_less_amplitude() {
        let (a, b) = (curve(30, 7.2), curve(30, 19.7));
        let turned: Vec<Complex64> = b.iter().map(|v| v * -3.0).collect();
        let larger: Vec<Complex64> = a.iter().map(|v| v * 3.0).collect();
        let kind = FrfKind::Mobility;
        let first = set(axis(10.0, 1.0, 30), kind, &[("1:+Z", a), ("2:+Z", b)]);
        let other = [("2:-Z", turned), ("1:+Z", larger), ("3:+Z", curve(30, 3.0))];
        let second = set(axis(10.0, 1.0, 30), kind, &other);
        let correlation = frf_correlation(&first, &second, None).expect("functions in common");
        assert_eq!((correlation.first_alone, correlation.second_alone), (0, 1));
        for function in &correlation.functions {
            assert!(
                (function.frac.expect("a FRAC of functions that are not 0") - 1.0).abs() < 1e-12
            );
            assert!(
                (function
                    .level_db
                    .expect("a level of functions that are not 0")
                    - 20.0 * 3f64.log10())
                .abs()
                    < 1e-12
            );
        }
        for line in &correlation.lines {
            assert!((line.shape.expect("a value at lines that are not 0") - 1.0).abs() < 1e-12);
            assert!((line.amplitude.expect("a value at lines that are not 0") - 0.6).abs() < 1e-12);
        }
        assert_eq!(
            correlation
                .bands
                .iter()
                .map(|band| band.lines)
                .sum::<usize>(),
            30
        );
        assert!(
            (correlation.bands[0]
                .least_amplitude
                .expect("a value at lines that are not 0")
                - 0.6)
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn functions_of_two_lines_have_the_numbers_computed_by_hand() {
        let c = |re: f64, im: f64| Complex64::new(re, im);
        let of = |functions: &[(&str, Vec<Complex64>)]| {
            set(axis(1.0, 1.0, 2), FrfKind::Receptance, functions)
        };
        let first = of(&[
            ("1:+Z", vec![c(1.0, 0.0), c(0.0, 1.0)]),
            ("2:+Z", vec![c(1.0, 0.0); 2]),
        ]);
        let second = of(&[
            ("1:+Z", vec![c(1.0, 0.0), c(1.0, 0.0)]),
            ("2:+Z", vec![c(0.0, 0.0); 2]),
        ]);
        let correlation = frf_correlation(&first, &second, None).expect("functions in common");
        // |1 - i|² / (2 · 2).
        assert!(
            (correlation.functions[0]
                .frac
                .expect("a FRAC of functions that are not 0")
                - 0.5)
                .abs()
                < 1e-15
        );
        assert_eq!(correlation.functions[1].frac, None);
        // Vectors (1, 1) and (1, 0); (i, 1) and (1, 0).
        for line in &correlation.lines {
            assert!((line.shape.expect("a value at lines that are not 0") - 0.5).abs() < 1e-15);
            assert!(
                (line.amplitude.expect("a value at lines that are not 0") - 2.0 / 3.0).abs()
                    < 1e-15
            );
        }
    }

    #[test]
    fn kinds_and_axes_meet_where_both_are() {
        let values = curve(20, 7.2);
        let first = set(
            axis(5.0, 0.5, 20),
            FrfKind::Accelerance,
            &[("1:+Z", values)],
        );
        let whole = convert(&first, FrfKind::Receptance);
        // Every second line, from 6 Hz on.
        let thinned = (2..20).step_by(2).map(|k| whole.values(0)[k]).collect();
        let second = set(axis(6.0, 1.0, 9), FrfKind::Receptance, &[("1:+Z", thinned)]);
        let correlation = frf_correlation(&first, &second, None).expect("functions in common");
        assert_eq!((correlation.lines.len(), correlation.unit), (9, "(m/s2)/N"));
        assert!(
            (correlation.functions[0]
                .frac
                .expect("a FRAC of functions that are not 0")
                - 1.0)
                .abs()
                < 1e-12
        );
        assert!(
            correlation.functions[0]
                .level_db
                .expect("a level of functions that are not 0")
                .abs()
                < 1e-9
        );
        let narrow = Band::new(7.0, 9.0).expect("a band");
        let narrow_band =
            frf_correlation(&first, &second, Some(narrow)).expect("functions in common");
        assert_eq!(narrow_band.lines.len(), 3);
        let apart = set(
            axis(6.2, 1.0, 9),
            FrfKind::Receptance,
            &[("1:+Z", curve(9, 1.0))],
        );
        let error = frf_correlation(&first, &apart, None).unwrap_err();
        assert!(
            matches!(error, CorrelateError::NoCommonLine { common: 0, .. }),
            "{error}"
        );
        let other = set(
            axis(5.0, 0.5, 20),
            FrfKind::Receptance,
            &[("1:+X", curve(20, 1.0))],
        );
        let error = frf_correlation(&first, &other, None).unwrap_err();
        assert!(
            matches!(error, CorrelateError::NoCommonFunction { .. }),
            "{error}"
        );
    }

    proptest! {
        #[test]
        fn criteria_stay_between_0_and_1_and_do_not_depend_on_who_comes_first(
            a in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 24),
            b in proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 24),
            size in 1e-6..1e6f64,
        ) {
            let of = |numbers: &[(f64, f64)], size: f64| {
                let values: Vec<Complex64> =
                    numbers.iter().map(|(re, im)| size * Complex64::new(*re, *im)).collect();
                let functions = [("1:+Z", values[..12].to_vec()), ("2:+Z", values[12..].to_vec())];
                set(axis(0.0, 1.0, 12), FrfKind::Receptance, &functions)
            };
            let (one, two) = (of(&a, 1.0), of(&b, size));
            let correlation = frf_correlation(&one, &two, None).expect("functions in common");
            let other = frf_correlation(&two, &one, None).expect("functions in common");
            for (function, other) in correlation.functions.iter().zip(&other.functions) {
                let frac = function.frac.expect("a FRAC of functions that are not 0");
                prop_assert!((0.0..=1.0).contains(&frac));
                prop_assert!((frac - other.frac.expect("a FRAC of functions that are not 0")).abs() < 1e-12);
            }
            for (line, other) in correlation.lines.iter().zip(&other.lines) {
                let (shape, amplitude) = (line.shape.expect("a value at lines that are not 0"), line.amplitude.expect("a value at lines that are not 0"));
                prop_assert!((0.0..=1.0).contains(&shape) && (0.0..=1.0).contains(&amplitude));
                prop_assert!((amplitude - other.amplitude.expect("a value at lines that are not 0")).abs() < 1e-12);
                // Means of numbers: geometric below arithmetic.
                prop_assert!(amplitude * amplitude <= shape + 1e-12);
            }
        }
    }
}

//! Tests of the number of shapes of one pole: rank, noise, and poles of weak shapes.

use num_complex::Complex64;

use crate::frf::Function;
use crate::identify::sdof::repeated_poles::{IsolatedLines, PairTable, ShapeCount, count_shapes};
use crate::identify::synthetic::white_noise;
use crate::quantity::FrfKind;

const LAMBDA: Complex64 = Complex64::new(-2.0, 500.0);
const ROWS: usize = 5;
const COLUMNS: usize = 4;

fn functions() -> Vec<Function> {
    let function = |(response, reference): (usize, usize)| Function {
        response: format!("{response}:+Z").parse().unwrap(),
        reference: format!("{reference}:+Z").parse().unwrap(),
        kind: FrfKind::Receptance,
        averages: None,
        estimator: None,
        variance_dof: None,
    };
    let pairs = (1..=ROWS).flat_map(|r| (1..=COLUMNS).map(move |k| (r, k)));
    pairs.map(function).collect()
}

fn omega() -> Vec<f64> {
    (-20..=20).map(|k| 500.0 + 0.5 * f64::from(k)).collect()
}

/// Orthogonal shapes over responses and references.
fn shape(number: usize, index: usize, count: usize) -> f64 {
    (std::f64::consts::PI * number as f64 * (index as f64 + 0.5) / count as f64).cos()
}

/// Strength of a shape, and the shift of its pole, rad/s, by response and reference.
type ShapeTerm<'a> = (f64, &'a dyn Fn(usize, usize) -> f64);

/// Values of all functions.
fn values(shapes: &[ShapeTerm<'_>]) -> Vec<Vec<Complex64>> {
    let value = |r: usize, k: usize, w: f64| {
        let term = |(j, (strength, shift)): (usize, &ShapeTerm<'_>)| {
            let residue = strength * shape(j, r, ROWS) * shape(j, k, COLUMNS);
            residue / (Complex64::new(0.0, w - shift(r, k)) - LAMBDA)
        };
        shapes.iter().enumerate().map(term).sum::<Complex64>()
    };
    let pairs = (0..ROWS).flat_map(|r| (0..COLUMNS).map(move |k| (r, k)));
    let function = |(r, k)| omega().iter().map(|w| value(r, k, *w)).collect();
    pairs.map(function).collect()
}

fn counted_shapes(values: &[Vec<Complex64>], variance: Option<&[f64]>) -> ShapeCount {
    let isolated = IsolatedLines {
        omega: &omega(),
        lambda: LAMBDA,
        values,
        variance,
    };
    count_shapes(&PairTable::complete(&functions()).unwrap(), &isolated).unwrap()
}

#[test]
fn shapes_of_one_pole_are_counted_down_to_the_minimum_singular_value() {
    let no_shift = |_: usize, _: usize| 0.0;
    // The first shape is constant, with a norm √2 times that of each other wave on either side.
    for (ratio, expected) in [(0.06, 3), (0.04, 2)] {
        let frfs = values(&[(1.0, &no_shift), (1.0, &no_shift), (2.0 * ratio, &no_shift)]);
        assert_eq!(
            counted_shapes(&frfs, None),
            ShapeCount::OnePole(expected),
            "{ratio}"
        );
    }
}

#[test]
fn weak_shape_with_another_pole_is_no_repeated_pole() {
    let no_shift = |_: usize, _: usize| 0.0;
    // Half a half-power bandwidth of 2 · 2 rad/s: the second shape is too weak for the FRFs to
    // disagree on the frequency.
    for (bandwidths, repeated) in [(0.5, false), (0.05, true)] {
        let shift = move |_: usize, _: usize| 4.0 * bandwidths;
        let frfs = values(&[(1.0, &no_shift), (0.15, &shift)]);
        match counted_shapes(&frfs, None) {
            ShapeCount::OnePole(multiplicity) => assert!(repeated && multiplicity == 2),
            ShapeCount::SeparatePoles(excess) => {
                assert!(
                    !repeated && excess.value > 0.25 && excess.value < 0.5,
                    "{excess:?}"
                )
            }
        }
    }
}

#[test]
fn frequency_shift_between_excitation_points_is_no_second_shape() {
    let shift = |_: usize, k: usize| 0.1 * k as f64;
    assert_eq!(
        counted_shapes(&values(&[(1.0, &shift)]), None),
        ShapeCount::OnePole(1)
    );
}

#[test]
fn shape_within_the_noise_is_not_counted() {
    let no_shift = |_: usize, _: usize| 0.0;
    let frfs = values(&[(1.0, &no_shift), (0.2, &no_shift)]);
    // Peaks of the first shape are 1/2 high, those of the second 1/10.
    for (noise_std, expected) in [(1e-4, 2), (0.3, 1)] {
        let variance = vec![noise_std * noise_std; ROWS * COLUMNS];
        let noisy: Vec<Vec<Complex64>> = (0..frfs.len())
            .map(|f| {
                let noise = white_noise(frfs[f].len(), variance[f], f as u64);
                frfs[f].iter().zip(noise).map(|(h, z)| h + z).collect()
            })
            .collect();
        for given in [Some(variance.as_slice()), None] {
            assert_eq!(
                counted_shapes(&noisy, given),
                ShapeCount::OnePole(expected),
                "{noise_std} {}",
                given.is_some()
            );
        }
    }
}

#[test]
fn pair_table_needs_two_responses_two_references_and_every_pair() {
    let all = functions();
    assert!(PairTable::complete(&all).is_some());
    assert!(PairTable::complete(&all[1..]).is_none());
    assert!(PairTable::complete(&all[..COLUMNS]).is_none());
    let one_reference: Vec<Function> = all.iter().step_by(COLUMNS).cloned().collect();
    assert!(PairTable::complete(&one_reference).is_none());
}

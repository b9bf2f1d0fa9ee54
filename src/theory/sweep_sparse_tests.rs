//! Loci of a model that is solved sparse, against closed forms: two equal chains, whose roots are
//! double, and two masses on springs with a third between them, whose roots veer where the springs
//! are equal and cross those of the chains.

use std::f64::consts::{PI, TAU};

use crate::axis::Band;
use crate::linalg::SparseMatrix;

use super::{
    EventKind, ExternalMatrices, ExternalModel, MatrixSet, ParameterSpec, ParameterStatus, Sweep,
    SweepRange, TheoreticalModel, sweep,
};

/// Masses of one chain, 1 kg each, held at both ends.
const CHAIN: usize = 550;
/// The root of number `n` of a chain is near so many times `n`, rad/s.
const SPACING: f64 = 100.0;
/// The mass whose spring stays: between the fifth and the sixth root of the chains.
const FIXED_STIFFNESS_N_PER_M: f64 = 550.0 * 550.0;
/// The spring between the masses, N/m.
const JOINT: f64 = 2000.0;
/// Masses that nothing joins: enough for a model to be solved sparse.
const ALONE: usize = 1100;

fn chain_stiffness() -> f64 {
    let half = 0.5 * PI / (CHAIN + 1) as f64;
    (0.5 * SPACING / half.sin()).powi(2)
}

/// The square of root `n` of a chain, `4 k sin^2(n pi / 2 (N + 1))`.
fn chain_root(n: usize) -> f64 {
    let half = 0.5 * PI * n as f64 / (CHAIN + 1) as f64;
    4.0 * chain_stiffness() * half.sin().powi(2)
}

/// Both roots of the masses with `p` the spring of the second to the ground.
fn pair_roots(p: f64) -> [f64; 2] {
    let (a, b) = (FIXED_STIFFNESS_N_PER_M + JOINT, p + JOINT);
    let distance = (0.5 * (a - b)).hypot(JOINT);
    [0.5 * (a + b) - distance, 0.5 * (a + b) + distance]
}

/// The model; the spring of the second mass is `fixed + factor * p` with the swept parameter `p`.
fn model(fixed: f64, factor: f64, (lower, upper): (f64, f64)) -> ExternalModel {
    let size = 2 * CHAIN + 2;
    let k = chain_stiffness();
    let mut stiffness = Vec::new();
    for first in [0, CHAIN] {
        for i in first..first + CHAIN {
            stiffness.push((i, i, 2.0 * k));
            if i + 1 < first + CHAIN {
                stiffness.extend([(i, i + 1, -k), (i + 1, i, -k)]);
            }
        }
    }
    let (still, swept) = (size - 2, size - 1);
    stiffness.extend([
        (still, still, FIXED_STIFFNESS_N_PER_M + JOINT),
        (still, swept, -JOINT),
        (swept, still, -JOINT),
        (swept, swept, fixed + JOINT),
    ]);
    external((size, &stiffness), (swept, factor), (lower, upper))
}

/// Masses of 1 kg on a stiffness, one entry of its diagonal raised by `factor * p`.
fn external(
    (size, stiffness): (usize, &[(usize, usize, f64)]),
    (swept, factor): (usize, f64),
    (lower, upper): (f64, f64),
) -> ExternalModel {
    let matrix = |entries: &[(usize, usize, f64)]| SparseMatrix::from_entries(size, entries).ok();
    let ones: Vec<_> = (0..size).map(|i| (i, i, 1.0)).collect();
    let scaled = MatrixSet {
        stiffness: matrix(&[(swept, swept, factor)]),
        ..MatrixSet::default()
    };
    let model = ExternalModel::new(ExternalMatrices {
        title: "masses on springs".to_owned(),
        dofs: (1..=size)
            .map(|i| format!("{i}:+X").parse().expect("a degree of freedom"))
            .collect(),
        fixed: MatrixSet {
            mass: matrix(&ones),
            stiffness: matrix(stiffness),
            ..MatrixSet::default()
        },
        parameters: vec![ParameterSpec {
            name: "swept".to_owned(),
            unit: "N/m".to_owned(),
            nominal: lower,
            lower: Some(lower),
            upper: Some(upper),
            status: ParameterStatus::Assumed,
            whole: false,
        }],
        groups: vec![("swept".to_owned(), scaled)],
        ..ExternalMatrices::default()
    });
    model.expect("matrices of one size")
}

fn swept(model: &ExternalModel, count: usize, band_rad_s: Option<f64>) -> Sweep {
    let parameter = &model.parameters()[0];
    assert!(
        model
            .sparse(&[parameter.nominal])
            .expect("a nominal value")
            .is_some()
    );
    let range = SweepRange {
        lower: parameter.lower.expect("a lower bound"),
        upper: parameter.upper.expect("an upper bound"),
        count,
    };
    let band = band_rad_s.map(|end| Band::new(0.0, end / TAU).expect("a band"));
    sweep(model, &[parameter.nominal], "swept", range, band).expect("a range within the bounds")
}

/// Every locus is a chain's root, or one of the two masses', through all values; how many of the
/// chains' there are.
fn check_loci(sweep: &Sweep, p: impl Fn(f64) -> f64) -> usize {
    let mut chains = 0;
    let mut pairs = Vec::new();
    for locus in &sweep.loci {
        let squares = locus
            .omega_rad_s
            .iter()
            .map(|w| w.expect("a mode at every value").powi(2));
        let squares: Vec<f64> = squares.collect();
        let all = |expected: &dyn Fn(f64) -> f64| {
            let mut each = sweep.values.iter().zip(&squares);
            each.all(|(value, square)| (square / expected(*value) - 1.0).abs() < 1e-9)
        };
        if locus
            .multiplicity
            .iter()
            .all(|multiplicity| *multiplicity == 2)
        {
            chains += 1;
            assert!(all(&|_| chain_root(chains)), "{chains}: {squares:?}");
        } else {
            assert!(
                locus
                    .multiplicity
                    .iter()
                    .all(|multiplicity| *multiplicity == 1)
            );
            let branch = [0, 1]
                .into_iter()
                .find(|&i| all(&|value| pair_roots(p(value))[i]));
            pairs.push(branch.unwrap_or_else(|| panic!("{squares:?}")));
        }
    }
    assert_eq!(pairs, [0, 1]);
    chains
}

/// Where a root of the masses is one of a chain's: `(a + c - l)(p + c - l) = c^2`.
fn meeting(n: usize) -> f64 {
    let l = chain_root(n);
    l - JOINT + JOINT * JOINT / (FIXED_STIFFNESS_N_PER_M + JOINT - l)
}

fn check_events(sweep: &Sweep, place: impl Fn(f64) -> f64, expected: &[(EventKind, f64)]) {
    let got: Vec<EventKind> = sweep.events.iter().map(|event| event.kind).collect();
    let kinds: Vec<EventKind> = expected.iter().map(|event| event.0).collect();
    assert_eq!(got, kinds, "{:#?}", sweep.events);
    for (event, (kind, wanted)) in sweep.events.iter().zip(expected) {
        let found = place(event.place);
        // A crossing is where roots within rounding are; the least distance in frequency is flat.
        assert!((found / wanted - 1.0).abs() < 1e-6, "{event:?} {wanted}");
        let [low, high] = pair_roots(found);
        if *kind == EventKind::Crossing {
            assert!(event.coupling < 1e-9 && event.gap_hz == 0.0, "{event:?}");
        } else {
            let gap = (high.sqrt() - low.sqrt()) / TAU;
            assert!((event.gap_hz / gap - 1.0).abs() < 1e-6, "{event:?} {gap}");
            assert!(event.coupling > 0.999, "{event:?}");
        }
    }
}

/// Where the frequencies of the two masses are nearest: both change alike, `dl/dp / 2 w`.
fn veering() -> f64 {
    let rate = |p: f64| {
        let slope =
            0.5 * (p - FIXED_STIFFNESS_N_PER_M) / (p - FIXED_STIFFNESS_N_PER_M).hypot(2.0 * JOINT);
        let [low, high] = pair_roots(p).map(f64::sqrt);
        (0.5 + slope) / high - (0.5 - slope) / low
    };
    let (mut low, mut high) = (
        FIXED_STIFFNESS_N_PER_M - JOINT,
        FIXED_STIFFNESS_N_PER_M + JOINT,
    );
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rate(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn a_root_that_rises_crosses_the_chains_and_veers_with_the_other_mass() {
    // The second mass from 420 to 680 rad/s; all that lie in the band at the start are swept.
    let model = model(0.0, 1.0, (420.0f64.powi(2), 680.0f64.powi(2)));
    let sweep = swept(&model, 8, Some(630.0));
    assert!(sweep.followed);
    assert_eq!(check_loci(&sweep, |p| p), 6);
    check_events(
        &sweep,
        |p| p,
        &[
            (EventKind::Crossing, meeting(5)),
            (EventKind::Veering, veering()),
            (EventKind::Crossing, meeting(6)),
        ],
    );
    // A gap of 2 c in the squares over twice the coupling of one half.
    assert!(
        (sweep.events[1].width.expect("a veering has a width") / (2.0 * JOINT) - 1.0).abs() < 1e-4
    );
}

#[test]
fn a_root_that_enters_the_band_from_above_is_tracked_from_outside_the_band() {
    // From 930 rad/s, beyond the band, down to 420: p = 930^2 - the swept parameter.
    let fixed = 930.0f64.powi(2);
    let p = |value: f64| fixed - value;
    let model = model(fixed, -1.0, (1.0, fixed - 420.0f64.powi(2)));
    let sweep = swept(&model, 12, Some(630.0));
    // Seven are in the band at the start; more are followed until the mass is among them.
    let chains = check_loci(&sweep, p);
    assert!(chains >= 9, "{chains}");
    let crossings = |n: usize| (EventKind::Crossing, meeting(n));
    let (above, below) = ([9, 8, 7, 6].map(crossings), crossings(5));
    let mut expected = above.to_vec();
    expected.extend([(EventKind::Veering, veering()), below]);
    check_events(&sweep, p, &expected);
}

#[test]
fn without_a_band_the_lowest_thirty_roots_are_tracked() {
    let model = model(0.0, 1.0, (420.0f64.powi(2), 430.0f64.powi(2)));
    let sweep = swept(&model, 2, None);
    assert!(sweep.events.is_empty(), "{:?}", sweep.events);
    // Two of the masses, and fourteen double roots.
    assert_eq!(check_loci(&sweep, |p| p), 14);
}

/// Masses of 1 kg, each alone on its spring: the first ones at `roots_rad_s`, the last of these
/// with a spring less by the swept parameter, all others above them, `SPACING` apart.
fn masses(roots_rad_s: &[f64], (lower, upper): (f64, f64)) -> ExternalModel {
    let above = |i: usize| SPACING * (10 + i) as f64;
    let root = |i: usize| roots_rad_s.get(i).copied().unwrap_or(above(i));
    let stiffness: Vec<_> = (0..ALONE).map(|i| (i, i, root(i).powi(2))).collect();
    let falls = roots_rad_s.len() - 1;
    external((ALONE, &stiffness), (falls, -1.0), (lower, upper))
}

#[test]
fn a_root_that_falls_into_the_band_across_a_gap_is_tracked() {
    // Followed at 40 Hz with nothing up to the end of the band, 100 Hz; the next from 105 to 80 Hz,
    // never within 5/4 of it.
    let squares = [40.0, 105.0, 80.0].map(|hz: f64| (TAU * hz).powi(2));
    let range = (1.0, squares[1] - squares[2]);
    let at = |value: f64| (squares[1] - value).sqrt();
    for first in [&[TAU * 40.0][..], &[]] {
        let roots: Vec<f64> = first.iter().copied().chain([TAU * 105.0]).collect();
        let model = masses(&roots, range);
        let sweep = swept(&model, 6, Some(TAU * 100.0));
        // Alone it leaves no mode in the band at the first value.
        let tracked = sweep.loci.iter().map(|locus| &locus.omega_rad_s);
        let tracked: Vec<_> = tracked.collect();
        assert_eq!(
            tracked.len(),
            roots.len(),
            "the mass whose frequency falls is swept"
        );
        for (i, &value) in sweep.values.iter().enumerate() {
            let expected = first.iter().copied().chain([at(value)]);
            for (locus, wanted) in tracked.iter().zip(expected) {
                let got = locus[i].expect("a mode at every value");
                // Vectors are exact to 1e-11, their quotients to the square of it times the spread
                // of the squares, 1e6.
                assert!((got / wanted - 1.0).abs() < 1e-9, "{got} {wanted}");
            }
        }
        assert!(sweep.events.is_empty(), "{:?}", sweep.events);
    }
}

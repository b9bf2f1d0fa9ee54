//! The quality of each mode, by the same rules for all methods: whether it is a mode of the
//! structure, and what its frequency, damping and shape are worth.
//!
//! Every rule is a finding of the mode, whose sentence is the reason. The findings of the methods
//! count as well: [`EFFECTS`] says which grade each of them lowers. The standard deviations give
//! the grades of the values.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::finding::{Code, Finding, Location, Severity};
use crate::modal::{Grade, ModalModel, Mode, Quality};

use crate::identify::estimator::Candidate;

/// Standard deviation of a frequency up to which it is good, and doubtful: half-power bandwidths,
/// or as a fraction of the frequency where that is more; and the maximum as a fraction.
const FREQUENCY_STDS_BANDWIDTHS: [f64; 2] = [0.05, 0.25];
const FREQUENCY_STDS_FRACTION: [f64; 2] = [2e-4, 1e-3];
const MAX_FREQUENCY_STDS_FRACTION: [f64; 2] = [5e-3, 2e-2];
/// Standard deviation, half-power bandwidths, above which a mode with other bad values is no mode.
const LOST_STD_BANDWIDTHS: f64 = 0.5;
/// Standard deviation of a damping ratio as a fraction of it, up to which it is good, and doubtful.
const DAMPING_STDS: [f64; 2] = [0.1, 0.3];
/// The same of a shape: norm of its standard deviations over its norm; the expected loss of MAC is
/// its square.
const SHAPE_STDS: [f64; 2] = [0.1, 0.3];
/// Half-power bandwidths (mean of both) within which two poles may be one mode that shifts or is
/// nonlinear.
const NEIGHBOUR_BANDWIDTHS: f64 = 2.0;
/// Agreement in sign of two residue vectors above which two poles may be one mode: `Σ Re(a b*) /
/// Σ |a b|`.
const MIN_SIGN_AGREEMENT: f64 = 0.8;
/// Minimum number of FRFs for that: of four with random signs 1 in 8 agree.
const MIN_FRFS: usize = 4;
/// Modal contribution over the unexplained response, below which a mode is doubtful.
const MIN_CONTRIBUTION_OVER_MISFIT: f64 = 2.0;
/// Distance of two poles, half-power bandwidths (mean of both), and modal contribution of the
/// weaker: nearer and below it the other pole explains nearly all that this one does.
const HARDLY_SEPARATE_BANDWIDTHS: f64 = 0.3;
const HARDLY_SEPARATE_CONTRIBUTION: f64 = 0.06;
/// Modal contribution of the weakest mode of a repeated root below which it is doubtful.
const WEAK_REPEATED_CONTRIBUTION: f64 = 0.05;
/// Modal phase collinearity below which a shape is complex, and the median of all above which the
/// structure has real modes.
const COMPLEX_MPC: f64 = 0.7;
const REAL_MPC: f64 = 0.95;
/// Minimum number of shapes.
const MIN_SHAPES: usize = 5;
/// Minimum number of DOFs of a shape whose phases mean something.
const MIN_DOFS: usize = 3;

/// What a grade belongs to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Value {
    Verdict,
    Frequency,
    Damping,
    Shape,
}

use Value::{Damping, Frequency, Shape, Verdict};

/// Findings of a mode with the grades that they lower, and to what.
const EFFECTS: &[(Code, &[(Value, Grade)])] = &[
    (Code::RepeatsNeighbour, &[(Verdict, Grade::Doubtful)]),
    (Code::WeakerThanMisfit, &[(Verdict, Grade::Doubtful)]),
    (
        Code::HardlySeparate,
        &[(Verdict, Grade::Doubtful), (Shape, Grade::Doubtful)],
    ),
    (
        Code::WeakRepeated,
        &[(Verdict, Grade::Doubtful), (Shape, Grade::Doubtful)],
    ),
    (
        Code::ComplexShape,
        &[(Verdict, Grade::Doubtful), (Shape, Grade::Doubtful)],
    ),
    (Code::RunsApart, &[(Verdict, Grade::Doubtful)]),
    (
        Code::LoadedShape,
        &[(Verdict, Grade::Doubtful), (Shape, Grade::Doubtful)],
    ),
    (
        Code::AboveValidBand,
        &[
            (Verdict, Grade::Doubtful),
            (Damping, Grade::Bad),
            (Shape, Grade::Doubtful),
        ],
    ),
    (
        Code::NotFitted,
        &[
            (Verdict, Grade::Doubtful),
            (Frequency, Grade::Doubtful),
            (Damping, Grade::Bad),
        ],
    ),
    (
        Code::CloseModes,
        &[
            (Verdict, Grade::Doubtful),
            (Frequency, Grade::Doubtful),
            (Damping, Grade::Bad),
            (Shape, Grade::Bad),
        ],
    ),
    (Code::DampingNotPositive, &[(Damping, Grade::Bad)]),
    (Code::FewLines, &[(Damping, Grade::Doubtful)]),
    (Code::HalfPowerMissing, &[(Damping, Grade::Doubtful)]),
    (Code::DampingSpread, &[(Damping, Grade::Doubtful)]),
    (Code::DampingBiasedHigh, &[(Damping, Grade::Doubtful)]),
    (Code::BandDependent, &[(Damping, Grade::Doubtful)]),
    (Code::AmplitudeDependent, &[(Damping, Grade::Doubtful)]),
    (
        Code::ForceLevelDependent,
        &[(Frequency, Grade::Doubtful), (Damping, Grade::Doubtful)],
    ),
    (Code::PolesMerged, &[(Damping, Grade::Doubtful)]),
    (Code::VariesWithinRuns, &[(Damping, Grade::Doubtful)]),
    (Code::FewTimeConstants, &[(Damping, Grade::Doubtful)]),
    (Code::NearBandEdge, &[(Damping, Grade::Doubtful)]),
    (Code::LinesShareNoise, &[(Damping, Grade::Doubtful)]),
    (Code::WindowDecayUnknown, &[(Damping, Grade::Doubtful)]),
];

/// Findings about a whole test that concern all its modes.
const ALL_MODES: [Code; 2] = [Code::LinesShareNoise, Code::WindowDecayUnknown];

/// Findings of each candidate about whether it is a mode.
pub(in crate::identify) fn findings(
    candidates: &[Candidate],
    hz: impl Fn(&Candidate) -> f64,
) -> Vec<Finding> {
    let of = |(j, candidate): (usize, &Candidate)| {
        let warning = |code, value: f64, limit: f64| {
            let finding = Finding::new(Severity::Warning, code, Location::Mode(hz(candidate)));
            finding.value(value, "").limit(limit)
        };
        let mut findings: Vec<Finding> = Vec::new();
        if let Some(agreement) = agreement_with_neighbour(candidates, j) {
            findings.push(warning(
                Code::RepeatsNeighbour,
                agreement,
                MIN_SIGN_AGREEMENT,
            ));
        }
        let Some(evidence) = candidate.evidence else {
            return findings;
        };
        let contribution = evidence.contribution;
        let limit = MIN_CONTRIBUTION_OVER_MISFIT * evidence.misfit;
        if contribution < limit {
            findings.push(warning(Code::WeakerThanMisfit, contribution, limit));
        }
        let norm = |candidate: &Candidate| -> f64 {
            let residues = candidate.residues.iter().flatten();
            residues.map(Complex64::norm_sqr).sum()
        };
        let is_stronger = |other: &&Candidate| norm(other) > norm(candidate);
        let stronger = candidates.iter().filter(is_stronger);
        let nearest = stronger
            .map(|other| bandwidths(candidate, other))
            .reduce(f64::min);
        let is_near = nearest.is_some_and(|nearest| nearest < HARDLY_SEPARATE_BANDWIDTHS);
        let limit = HARDLY_SEPARATE_CONTRIBUTION;
        if contribution < limit && is_near {
            findings.push(warning(Code::HardlySeparate, contribution, limit));
        }
        let limit = WEAK_REPEATED_CONTRIBUTION;
        if candidate.multiplicity > 1 && contribution < limit {
            findings.push(warning(Code::WeakRepeated, contribution, limit));
        }
        findings
    };
    candidates.iter().enumerate().flat_map(of).collect()
}

/// The sign agreement of a candidate with a stronger one close by, above its limit.
fn agreement_with_neighbour(candidates: &[Candidate], j: usize) -> Option<f64> {
    let energy = |residues: &[Complex64]| -> f64 { residues.iter().map(Complex64::norm_sqr).sum() };
    let a = &candidates[j];
    let residues = a
        .residues
        .as_deref()
        .filter(|residues| residues.len() >= MIN_FRFS)?;
    let agreement = |b: &Candidate| {
        let others = b.residues.as_deref()?;
        let agrees = sign_agreement(residues, others);
        let repeats = bandwidths(a, b) < NEIGHBOUR_BANDWIDTHS
            && energy(others) > energy(residues)
            && agrees > MIN_SIGN_AGREEMENT;
        repeats.then_some(agrees)
    };
    let others = candidates.iter().enumerate().filter(|(i, _)| *i != j);
    others.filter_map(|(_, b)| agreement(b)).reduce(f64::max)
}

/// Distance of two poles in frequency, in the mean of their half-power bandwidths.
fn bandwidths(a: &Candidate, b: &Candidate) -> f64 {
    let (p, q) = (a.pole.lambda, b.pole.lambda);
    (p.im - q.im).abs() / (p.re + q.re).abs()
}

/// `Σ Re(a b*) / Σ |a b|`: 1 where all components have the same phase, 0 of random signs.
fn sign_agreement(a: &[Complex64], b: &[Complex64]) -> f64 {
    let pairs = || a.iter().zip(b);
    let product: f64 = pairs().map(|(x, y)| (x * y.conj()).re).sum();
    let size: f64 = pairs().map(|(x, y)| x.norm() * y.norm()).sum();
    if size > 0.0 { product / size } else { 0.0 }
}

/// Findings of shapes that are complex while those of the other modes are real. Noise, and a
/// neighbour within a bandwidth, make any shape complex.
pub(in crate::identify) fn complex_shapes(modes: &[Mode]) -> Vec<Finding> {
    let mpc = |mode: &Mode| mode.mpc.filter(|_| mode.shape.len() >= MIN_DOFS);
    let mut all: Vec<f64> = modes.iter().filter_map(mpc).collect();
    all.sort_by(f64::total_cmp);
    if all.len() < MIN_SHAPES || all[(all.len() - 1) / 2] < REAL_MPC {
        return Vec::new();
    }
    let finding = |mode: &Mode| {
        let mpc = mpc(mode).filter(|mpc| *mpc < COMPLEX_MPC)?;
        let is_noise = relative_shape_std(mode) > Some(SHAPE_STDS[1]);
        let is_coupled = mode.modal_overlap > Some(1.0);
        let location = Location::Mode(mode.frequency_hz);
        let finding = Finding::new(Severity::Warning, Code::ComplexShape, location);
        let finding = finding.value(mpc, "").limit(COMPLEX_MPC);
        (!is_noise && !is_coupled).then_some(finding)
    };
    modes.iter().filter_map(finding).collect()
}

/// Sets the quality of every mode from its standard deviations and from the findings of the model.
pub fn assess(model: &mut ModalModel) {
    let mut ranks: BTreeMap<u32, usize> = BTreeMap::new();
    for mode in &mut model.modes {
        let rank = mode.group.map_or(0, |group| {
            let next = ranks.entry(group).or_default();
            *next += 1;
            *next - 1
        });
        mode.quality = Some(quality(mode, rank, &model.findings));
    }
}

/// The quality of a mode. `rank`: its number among the modes of a repeated root, from 0 for the
/// strongest: contributions of a repeated root are those of its weakest mode.
fn quality(mode: &Mode, rank: usize, findings: &[Finding]) -> Quality {
    let hz = mode.frequency_hz;
    let mut reasons = Vec::new();
    let mut grade = |value: Option<f64>, unit: &str, [good, doubtful]: [f64; 2]| {
        let value = value.filter(|value| value.is_finite())?;
        let grade = Grade::below(value, good, doubtful);
        if grade != Grade::Good {
            let percent = |value: f64| format!("{:.2} %", 100.0 * value);
            let (value, good, doubtful) = (percent(value), percent(good), percent(doubtful));
            reasons.push(format!(
                "standard deviation of the {unit}: {value} of it (good below {good}, bad above {doubtful})"
            ));
        }
        Some(grade)
    };
    let width = mode.damping_ratio.map_or(0.0, |ratio| 2.0 * ratio);
    let limit = |k: usize| {
        let limit = (FREQUENCY_STDS_BANDWIDTHS[k] * width).max(FREQUENCY_STDS_FRACTION[k]);
        limit.min(MAX_FREQUENCY_STDS_FRACTION[k])
    };
    let frequency = mode.frequency_uncertainty_hz().map(|std| std / hz);
    let bias = mode.damping_bias.unwrap_or(0.0);
    let damping = mode
        .damping_std
        .map(|std| std.hypot(bias))
        .zip(mode.damping_ratio);
    let damping = damping.map(|(std, ratio)| std / ratio);
    let mut quality = Quality {
        verdict: Grade::Good,
        frequency: grade(frequency, "frequency", [limit(0), limit(1)]),
        damping: grade(damping, "damping", DAMPING_STDS),
        shape: grade(relative_shape_std(mode), "shape", SHAPE_STDS),
        reasons,
    };
    let of_mode = findings.iter().filter(|finding| concerns(mode, finding));
    for finding in of_mode.filter(|finding| rank > 0 || !is_of_weakest(mode, finding.code)) {
        let Some((code, effects)) = EFFECTS.iter().find(|(code, _)| *code == finding.code) else {
            continue;
        };
        for (value, grade) in *effects {
            value.lower(&mut quality, *grade);
        }
        let numbers = finding.numbers_text();
        let numbers = numbers.map_or_else(String::new, |numbers| format!(" ({numbers})"));
        quality
            .reasons
            .push(format!("{}: {}{numbers}", code.name(), code.sentence()));
    }
    let bad = [quality.frequency, quality.damping, quality.shape];
    let bad = bad
        .iter()
        .filter(|grade| **grade == Some(Grade::Bad))
        .count();
    if quality.frequency == Some(Grade::Bad) && bad > 1 {
        let is_lost = frequency > Some(LOST_STD_BANDWIDTHS * width);
        let grade = if is_lost { Grade::Bad } else { Grade::Doubtful };
        quality.verdict = quality.verdict.max(grade);
    }
    quality
}

/// Whether a finding is about the weakest mode of a repeated root.
fn is_of_weakest(mode: &Mode, code: Code) -> bool {
    let codes = [
        Code::WeakRepeated,
        Code::WeakerThanMisfit,
        Code::HardlySeparate,
    ];
    mode.group.is_some() && codes.contains(&code)
}

impl Value {
    /// Lowers the grade of this value to a grade.
    fn lower(self, quality: &mut Quality, grade: Grade) {
        match self {
            Verdict => quality.verdict = quality.verdict.max(grade),
            Frequency => quality.frequency = quality.frequency.max(Some(grade)),
            Damping => quality.damping = quality.damping.max(Some(grade)),
            Shape => quality.shape = quality.shape.max(Some(grade)),
        }
    }
}

/// Whether a finding is about a mode, or about the damping of all of them.
fn concerns(mode: &Mode, finding: &Finding) -> bool {
    let hz = mode.frequency_hz;
    match finding.location {
        Location::Mode(at) => (at - hz).abs() <= 1e-9 * hz,
        Location::Whole => ALL_MODES.contains(&finding.code),
        _ => false,
    }
}

/// Norm of the standard deviations of a shape over its norm, for shapes of several DOFs.
fn relative_shape_std(mode: &Mode) -> Option<f64> {
    let stds = mode.shape_std.as_ref().filter(|stds| stds.len() > 1)?;
    let variance: f64 = stds.values().map(|std| 2.0 * std * std).sum();
    let energy: f64 = mode.shape.iter().map(|(_, value)| value.norm_sqr()).sum();
    Some((variance / energy).sqrt())
}

#[cfg(test)]
mod tests {
    use crate::dof::Dof;
    use crate::identify::estimator::Evidence;
    use crate::identify::modes::quality::*;
    use crate::modal::{ModeShape, Pole, Scaling};

    fn dof(point: usize) -> Dof {
        format!("{point}:+Z").parse().expect("a DOF")
    }

    /// A mode of four DOFs with these standard deviations over bandwidth, damping and shape.
    fn mode(stds: [f64; 3]) -> Mode {
        let shape = (1..=4).map(|point| (dof(point), Complex64::ONE));
        let mut mode = Mode::new(100.0, Some(0.01), ModeShape::new(shape), Scaling::UnitMax);
        mode.frequency_std_hz = Some(stds[0] * 2.0);
        mode.damping_std = Some(stds[1] * 0.01);
        // Real and imaginary part have one standard deviation each.
        let std = stds[2] * 0.5f64.sqrt();
        mode.shape_std = Some((1..=4).map(|point| (dof(point), std)).collect());
        mode
    }

    #[test]
    fn values_are_graded_by_their_standard_deviations() {
        let grades = |stds| {
            let quality = quality(&mode(stds), 0, &[]);
            assert_eq!(quality.verdict, Grade::Good);
            (
                quality.frequency,
                quality.damping,
                quality.shape,
                quality.reasons.len(),
            )
        };
        let (good, doubtful, bad) = (Some(Grade::Good), Some(Grade::Doubtful), Some(Grade::Bad));
        assert_eq!(grades([0.04998, 0.09996, 0.09996]), (good, good, good, 0));
        assert_eq!(
            grades([0.05002, 0.10004, 0.10004]),
            (doubtful, doubtful, doubtful, 3)
        );
        assert_eq!(
            grades([0.2499, 0.2999, 0.2999]),
            (doubtful, doubtful, doubtful, 3)
        );
        assert_eq!(grades([0.2, 0.301, 0.301]), (doubtful, bad, bad, 3));
        let worst = |std: f64| quality(&mode([std, 0.301, 0.0]), 0, &[]);
        assert_eq!(
            (worst(0.251).frequency, worst(0.251).verdict),
            (bad, Grade::Doubtful)
        );
        assert_eq!(worst(0.51).verdict, Grade::Bad);
        assert_eq!(
            quality(&mode([0.51, 0.0, 0.0]), 0, &[]).verdict,
            Grade::Good
        );
    }

    #[test]
    fn values_without_a_standard_deviation_are_not_assessed() {
        let mut mode = mode([0.0; 3]);
        (mode.frequency_std_hz, mode.damping_std, mode.shape_std) = (None, None, None);
        let quality = quality(&mode, 0, &[]);
        assert_eq!(
            (quality.frequency, quality.damping, quality.shape),
            (None, None, None)
        );
    }

    #[test]
    fn findings_of_the_mode_alone_lower_its_grades() {
        let at = |hz, code| Finding::new(Severity::Warning, code, Location::Mode(hz));
        let findings = [at(100.0, Code::FewLines), at(101.0, Code::RepeatsNeighbour)];
        let graded = quality(&mode([0.0; 3]), 0, &findings);
        assert_eq!(graded.verdict, Grade::Good);
        assert_eq!(graded.damping, Some(Grade::Doubtful));
        assert_eq!(graded.reasons.len(), 1, "{:?}", graded.reasons);
        assert!(
            graded.reasons[0].starts_with("few-lines: "),
            "{:?}",
            graded.reasons
        );
        let graded = quality(&mode([0.0; 3]), 0, &[at(100.0, Code::RepeatsNeighbour)]);
        assert_eq!(graded.verdict, Grade::Doubtful);
    }

    /// A candidate with these residues at a damped frequency in half-power bandwidths from 100.
    fn candidate(bandwidths: f64, residues: &[f64]) -> Candidate {
        Candidate {
            residues: Some(residues.iter().map(|a| Complex64::new(0.0, *a)).collect()),
            ..Candidate::new(Pole {
                lambda: Complex64::new(-0.5, 100.0 + bandwidths),
            })
        }
    }

    /// Codes of the doubts with the frequencies of their poles, rounded.
    fn codes(candidates: &[Candidate]) -> Vec<(Code, f64)> {
        let at = |finding: Finding| match finding.location {
            Location::Mode(hz) => (finding.code, hz.round()),
            _ => panic!("{finding:?}"),
        };
        let frequency = |candidate: &Candidate| candidate.pole.lambda.im;
        super::findings(candidates, frequency)
            .into_iter()
            .map(at)
            .collect()
    }

    #[test]
    fn the_weaker_of_two_close_poles_that_move_all_sensors_alike_is_doubtful() {
        let strong = candidate(0.0, &[-2.0, 1.0, 3.0, 2.0]);
        let alike = [-1.0, 0.2, 1.0, 0.5];
        assert_eq!(
            codes(&[strong.clone(), candidate(1.9, &alike)]),
            [(Code::RepeatsNeighbour, 102.0)]
        );
        assert_eq!(codes(&[strong.clone(), candidate(2.1, &alike)]), []);
        // Another sense at one sensor, and too few sensors.
        assert_eq!(codes(&[strong, candidate(0.5, &[1.0, 0.2, 1.0, 0.5])]), []);
        let few = [
            candidate(0.0, &[2.0, 1.0, 3.0]),
            candidate(0.5, &[1.0, 0.5, 1.0]),
        ];
        assert_eq!(codes(&few), []);
    }

    #[test]
    fn a_contribution_below_twice_the_misfit_is_doubtful() {
        let of = |contribution, misfit| {
            let evidence = Some(Evidence {
                contribution,
                misfit,
            });
            codes(&[Candidate {
                evidence,
                ..candidate(0.0, &[1.0])
            }])
        };
        assert_eq!(of(0.05, 0.026), [(Code::WeakerThanMisfit, 100.0)]);
        assert_eq!(of(0.05, 0.024), []);
    }

    #[test]
    fn a_pole_that_a_close_one_explains_is_doubtful() {
        let of = |bandwidths: f64, contribution| {
            let evidence = Some(Evidence {
                contribution,
                misfit: 0.0,
            });
            let weak = Candidate {
                evidence,
                ..candidate(bandwidths, &[1.0])
            };
            let strong = Candidate {
                evidence,
                ..candidate(0.0, &[2.0])
            };
            codes(&[strong, weak])
        };
        assert_eq!(of(0.29, 0.059), [(Code::HardlySeparate, 100.0)]);
        assert_eq!(of(0.31, 0.059), []);
        assert_eq!(of(0.29, 0.061), []);
    }

    #[test]
    fn the_weak_mode_of_a_repeated_root_alone_is_doubtful() {
        let of = |contribution| {
            let evidence = Some(Evidence {
                contribution,
                misfit: 0.0,
            });
            let weak = Candidate {
                evidence,
                multiplicity: 2,
                ..candidate(0.0, &[1.0])
            };
            super::findings(&[weak], |_| 100.0)
        };
        assert_eq!(of(0.051), []);
        let findings = of(0.049);
        let mode = Mode {
            group: Some(1),
            ..mode([0.0; 3])
        };
        let verdict = |rank| quality(&mode, rank, &findings).verdict;
        assert_eq!((verdict(0), verdict(1)), (Grade::Good, Grade::Doubtful));
    }

    #[test]
    fn a_complex_shape_among_real_ones_is_doubtful() {
        let with_mpc = |mpc: f64, overlap: f64| Mode {
            mpc: Some(mpc),
            modal_overlap: Some(overlap),
            ..mode([0.0; 3])
        };
        let count = |others: f64, mpc: f64, overlap: f64| {
            let mut modes: Vec<Mode> = (0..4).map(|_| with_mpc(others, 0.1)).collect();
            modes.push(with_mpc(mpc, overlap));
            complex_shapes(&modes).len()
        };
        assert_eq!(count(0.98, 0.69, 0.9), 1);
        assert_eq!(count(0.98, 0.71, 0.9), 0);
        // Coupled with its neighbour; a structure with complex modes.
        assert_eq!(count(0.98, 0.69, 1.1), 0);
        assert_eq!(count(0.94, 0.5, 0.9), 0);
    }
}

//! The score of an identification compares its modes with the observable modes of a known system.
//!
//! - **Observable**: a mode of the band whose contribution to some FRF, at the line nearest to its
//!   peak, exceeds the noise by 10 dB, and whose Cramér-Rao bound of the frequency is under a
//!   quarter of the distance to the next mode.
//! - **Found**: a mode within the larger of three such standard deviations (at most one half-power
//!   bandwidth) and a quarter of the half-power bandwidth, with a MAC of 0.9 or more of the MAC
//!   expected under the noise. Inseparable modes (within a half-power bandwidth, and the bound of
//!   either over a quarter of their distance), and modes that the identification reports as one
//!   repeated root, are compared by the span of their shapes.
//! - **Spurious**: a found mode without such a partner, in the band or outside.

use std::f64::consts::TAU;
use std::fmt;

use num_complex::Complex64;

use crate::correlate::subspace_mac;
use crate::linalg::sort_ascending_by;
use crate::modal::{ModalModel, Mode};

use super::bound::{NoisyLines, PoleBound, pole_bounds};
use super::system::{System, TrueMode};

/// Peak over noise, as a power: 10 dB.
const MIN_PEAK_POWER_RATIO: f64 = 10.0;
/// Largest bound of the frequency, over the distance to the next mode, of a separable mode.
const MAX_STD_OVER_SPACING: f64 = 0.25;
/// Modes outside the band within this many half-power bandwidths are parameters of the bound; lower
/// and upper residuals describe modes farther away.
const BOUND_MARGIN_BANDWIDTHS: f64 = 3.0;
/// Smallest MAC of a found mode, over the MAC expected under the noise.
const MIN_MAC_FRACTION: f64 = 0.9;

/// Detectability of a true mode under the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detectability {
    /// `None` for a mode far outside the band.
    pub bound: Option<PoleBound>,
    /// Its peak over the noise in the best function, dB.
    pub peak_db: f64,
    /// Distance to the next mode, Hz.
    pub spacing_hz: f64,
    /// Expected MAC of the best estimate of its shape: `1/(1 + ε²)`, `ε²` the variance of a lone
    /// mode's shape over its square.
    pub mac: f64,
    /// Whether an efficient estimator would find it.
    pub observable: bool,
}

/// Detectability of every mode of a system in noise of these variances ([`System::variances`]).
pub fn detectability(system: &System, variances: &[f64]) -> Vec<Detectability> {
    let bounds = mode_bounds(system, variances);
    let of_mode = |(r, bound): (usize, Option<PoleBound>)| {
        let mode = &system.modes[r];
        let others = system.modes.iter().enumerate().filter(|(o, _)| *o != r);
        let distance = |(_, other): (usize, &TrueMode)| (other.hz() - mode.hz()).abs();
        let spacing_hz = others.map(distance).fold(mode.hz(), f64::min);
        let peak_db = 10.0 * peak(system, mode, variances).log10();
        let separable = bound.is_some_and(|b| b.frequency_hz < MAX_STD_OVER_SPACING * spacing_hz);
        let above = peak_db >= 10.0 * MIN_PEAK_POWER_RATIO.log10();
        Detectability {
            bound,
            peak_db,
            spacing_hz,
            mac: expected_mac(system, mode, variances),
            observable: separable && above && system.inside(mode),
        }
    };
    bounds.into_iter().enumerate().map(of_mode).collect()
}

/// The bound of every mode in the band and near it.
pub fn mode_bounds(system: &System, variances: &[f64]) -> Vec<Option<PoleBound>> {
    let near = |mode: &TrueMode| {
        let margin_hz = BOUND_MARGIN_BANDWIDTHS * mode.width_hz();
        mode.hz() > system.band.lo_hz - margin_hz && mode.hz() < system.band.hi_hz + margin_hz
    };
    let chosen: Vec<usize> = (0..system.modes.len())
        .filter(|r| near(&system.modes[*r]))
        .collect();
    let modes: Vec<&TrueMode> = chosen.iter().map(|r| &system.modes[*r]).collect();
    let mut bounds = vec![None; system.modes.len()];
    let lines = NoisyLines {
        omega: &system.omega(),
        order: system.kind.derivative_order(),
        variances,
    };
    for (r, bound) in chosen.iter().zip(pole_bounds(&modes, &lines)) {
        bounds[*r] = Some(bound);
    }
    bounds
}

/// Squared magnitude of a mode's contribution at the line nearest to its peak, over the noise
/// variance; the maximum over all FRFs.
fn peak(system: &System, mode: &TrueMode, variances: &[f64]) -> f64 {
    let Some(line) = system.axis.nearest(mode.pole.damped_frequency_hz()) else {
        return 0.0;
    };
    let s = Complex64::new(0.0, TAU * system.axis.hz(line));
    let gain = s.powi(system.kind.derivative_order()) / (s - mode.pole.lambda);
    let pairs = system.pairs();
    let height = pairs.iter().zip(variances);
    let height = height.map(|(&(o, i), v)| (gain * mode.residue(o, i)).norm_sqr() / v);
    height.fold(0.0, f64::max)
}

/// With a known pole `ψ_o` has the variance `(σ dω/π) / Σ_i |L_i|²/v_oi`, since `∫ dω/|iω − λ|² =
/// π/σ`.
fn expected_mac(system: &System, mode: &TrueMode, variances: &[f64]) -> f64 {
    let order = system.kind.derivative_order();
    let gain = mode.pole.lambda.norm().powi(2 * order);
    let lines = -mode.pole.lambda.re * TAU * system.axis.step_hz / std::f64::consts::PI;
    let variance = |o: usize| {
        let of =
            |(i, l): (usize, &Complex64)| gain * l.norm_sqr() / variances[i * mode.shape.len() + o];
        let precision = mode.participation.iter().enumerate().map(of);
        lines / precision.sum::<f64>()
    };
    let noise: f64 = (0..mode.shape.len()).map(variance).sum();
    let square: f64 = mode.shape.iter().map(Complex64::norm_sqr).sum();
    (1.0 + noise / square).recip()
}

/// Result of the comparison of an identification with the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectionVerdict {
    /// Number of observable modes.
    pub observable: usize,
    /// Number of the found mode of every true one.
    pub partner: Vec<Option<usize>>,
    /// Numbers of the observable modes that are not found.
    pub missed: Vec<usize>,
    /// Numbers of the spurious modes.
    pub spurious: Vec<usize>,
}

impl DetectionVerdict {
    /// Whether every observable mode is found and no other.
    pub fn is_correct(&self) -> bool {
        self.missed.is_empty() && self.spurious.is_empty()
    }
}

impl fmt::Display for DetectionVerdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{} of {} observable found, {} spurious",
            self.observable - self.missed.len(),
            self.observable,
            self.spurious.len()
        )
    }
}

/// Compares identified modes with the modes of a system.
#[derive(Clone, Debug)]
pub struct Judge<'a> {
    system: &'a System,
    detectability: Vec<Detectability>,
}

impl<'a> Judge<'a> {
    /// The judge of a system in noise of these variances ([`System::variances`]).
    pub fn new(system: &'a System, variances: &[f64]) -> Self {
        Self {
            detectability: detectability(system, variances),
            system,
        }
    }

    /// The system.
    pub fn system(&self) -> &System {
        self.system
    }

    /// Detectability of every mode.
    pub fn detectability(&self) -> &[Detectability] {
        &self.detectability
    }

    /// Found, missed and spurious modes.
    pub fn verdict(&self, found: &ModalModel) -> DetectionVerdict {
        let partner = self.comparison(found).partners();
        let free = |f: &usize| !partner.contains(&Some(*f));
        let spurious = (0..found.modes.len()).filter(free).collect();
        let observable = |r: &usize| self.detectability[*r].observable;
        let all = (0..self.detectability.len()).filter(observable);
        DetectionVerdict {
            observable: all.clone().count(),
            missed: all.filter(|r| partner[*r].is_none()).collect(),
            partner,
            spurious,
        }
    }

    /// A description of every missed and every spurious mode, with the reason.
    pub fn reasons(&self, found: &ModalModel, verdict: &DetectionVerdict) -> Vec<String> {
        let comparison = self.comparison(found);
        let missed = verdict.missed.iter().map(|r| comparison.why_missed(*r));
        let spurious = verdict.spurious.iter().map(|f| comparison.why_spurious(*f));
        missed.chain(spurious).collect()
    }

    fn comparison<'b>(&'b self, found: &'b ModalModel) -> Comparison<'b> {
        let shapes = found.modes.iter();
        Comparison {
            system: self.system,
            detectability: &self.detectability,
            found: &found.modes,
            shapes: shapes
                .map(|mode| shape_at_responses(self.system, mode))
                .collect(),
        }
    }
}

/// A found shape at the responses of a system; empty where a component is missing.
pub fn shape_at_responses(system: &System, mode: &Mode) -> Vec<Complex64> {
    let at = |dof| mode.shape.along_positive(dof);
    let shape: Option<Vec<Complex64>> = system.responses.iter().map(at).collect();
    shape.unwrap_or_default()
}

struct Comparison<'a> {
    system: &'a System,
    detectability: &'a [Detectability],
    found: &'a [Mode],
    shapes: Vec<Vec<Complex64>>,
}

impl Comparison<'_> {
    /// Largest distance of a found mode from a true one, Hz.
    fn tolerance_hz(&self, r: usize) -> f64 {
        let width = self.system.modes[r].width_hz();
        let bound = self.detectability[r]
            .bound
            .map_or(0.0, |b| 3.0 * b.frequency_hz);
        bound.min(width).max(0.25 * width)
    }

    fn distance_hz(&self, r: usize, f: usize) -> f64 {
        (self.found[f].frequency_hz - self.system.modes[r].hz()).abs()
    }

    /// A true mode and the modes that the noise makes inseparable from it.
    fn cluster(&self, r: usize) -> Vec<usize> {
        let mode = &self.system.modes[r];
        let inseparable = |o: &usize| {
            let other = &self.system.modes[*o];
            let apart = (other.hz() - mode.hz()).abs();
            let separable = |r: usize| {
                let bound = self.detectability[r].bound;
                bound.is_some_and(|b| b.frequency_hz < MAX_STD_OVER_SPACING * apart)
            };
            *o == r
                || apart <= other.width_hz().max(mode.width_hz())
                    && !(separable(r) && separable(*o))
        };
        (0..self.system.modes.len()).filter(inseparable).collect()
    }

    fn mac(&self, r: usize, f: usize) -> f64 {
        let shape = &self.shapes[f];
        if shape.is_empty() {
            return 0.0;
        }
        let truth = |r: usize| self.system.modes[r].shape.clone();
        let span: Vec<_> = self.cluster(r).into_iter().map(truth).collect();
        let mac = subspace_mac(shape, &span).unwrap_or(0.0);
        let group = self.found[f].group;
        let same =
            (0..self.found.len()).filter(|o| group.is_some() && self.found[*o].group == group);
        let repeated: Vec<_> = same.map(|o| self.shapes[o].clone()).collect();
        mac.max(subspace_mac(&truth(r), &repeated).unwrap_or(0.0))
    }

    /// The found mode of each true one: as many observable modes as possible have one, then as many
    /// of the others.
    fn partners(&self) -> Vec<Option<usize>> {
        let count = self.detectability.len();
        let candidates: Vec<Vec<usize>> = (0..count).map(|r| self.candidates(r)).collect();
        let mut owner = vec![None; self.found.len()];
        for observable in [true, false] {
            for r in (0..count).filter(|r| self.detectability[*r].observable == observable) {
                assign_partner(
                    r,
                    &candidates,
                    &mut owner,
                    &mut vec![false; self.found.len()],
                );
            }
        }
        let mut partner = vec![None; count];
        for (f, r) in owner.iter().enumerate() {
            if let Some(r) = r {
                partner[*r] = Some(f);
            }
        }
        partner
    }

    /// Found modes that could be a true one, nearest first.
    fn candidates(&self, r: usize) -> Vec<usize> {
        let near = |f: &usize| self.distance_hz(r, *f) <= self.tolerance_hz(r);
        let fits = |f: &usize| self.mac(r, *f) >= MIN_MAC_FRACTION * self.detectability[r].mac;
        let mut candidates: Vec<usize> = (0..self.found.len()).filter(near).filter(fits).collect();
        sort_ascending_by(&mut candidates, |candidate| self.distance_hz(r, *candidate));
        candidates
    }

    fn why_missed(&self, r: usize) -> String {
        let (mode, detectability) = (&self.system.modes[r], &self.detectability[r]);
        let width = mode.width_hz();
        let nearest = (0..self.found.len())
            .min_by(|a, b| self.distance_hz(r, *a).total_cmp(&self.distance_hz(r, *b)));
        let nearest = nearest.map_or("nothing found".to_owned(), |f| {
            format!(
                "nearest found at {:+.3} reaches, MAC {:.3}",
                (self.found[f].frequency_hz - mode.hz()) / self.tolerance_hz(r),
                self.mac(r, f)
            )
        });
        let sigma = detectability.bound.map_or(f64::NAN, |b| b.frequency_hz);
        format!(
            "missed {:.3} Hz {:.2} %: {:.1} dB, {:.1} lines, neighbour {:.3} widths ({:.0} deviations), edge {:.1} widths; {nearest}",
            mode.hz(),
            100.0 * mode.pole.damping_ratio(),
            detectability.peak_db,
            width / self.system.axis.step_hz,
            detectability.spacing_hz / width,
            detectability.spacing_hz / sigma,
            (mode.hz() - self.system.band.lo_hz).min(self.system.band.hi_hz - mode.hz()) / width,
        )
    }

    fn why_spurious(&self, f: usize) -> String {
        let found = &self.found[f];
        let modes = &self.system.modes;
        let nearest = (0..modes.len())
            .min_by(|a, b| self.distance_hz(*a, f).total_cmp(&self.distance_hz(*b, f)))
            .expect("a system has modes");
        let (truth, detectability) = (&modes[nearest], &self.detectability[nearest]);
        format!(
            "spurious {:.3} Hz {:.2} %: from the mode at {:.3} Hz {:.2} % ({}, {:.1} dB) {:+.3} widths, {:.2} reaches, MAC {:.3}",
            found.frequency_hz,
            100.0 * found.damping_ratio.unwrap_or(f64::NAN),
            truth.hz(),
            100.0 * truth.pole.damping_ratio(),
            if detectability.observable {
                "observable"
            } else {
                "not observable"
            },
            detectability.peak_db,
            (found.frequency_hz - truth.hz()) / truth.width_hz(),
            self.distance_hz(nearest, f) / self.tolerance_hz(nearest),
            self.mac(nearest, f),
        )
    }
}

/// Finds a partner for a mode, others giving theirs up for another one where they can (Kuhn 1955,
/// by augmenting paths).
fn assign_partner(
    r: usize,
    candidates: &[Vec<usize>],
    owner: &mut [Option<usize>],
    seen: &mut [bool],
) -> bool {
    for &f in &candidates[r] {
        if std::mem::replace(&mut seen[f], true) {
            continue;
        }
        if owner[f].is_none_or(|other| assign_partner(other, candidates, owner, seen)) {
            owner[f] = Some(r);
            return true;
        }
    }
    false
}

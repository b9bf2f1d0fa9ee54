//! Leakage under an unstated window splits or widens modes; its line shape is tested against the
//! data.
//!
//! Under steady random force with a Hann or flat top window the FRF of one mode has the line shape
//! of a smoothed pole ([`LineShape`]). It raises the damping of a fit of poles, and two poles
//! within the main lobe imitate it better than one. Where resonances are so narrow, poles are
//! fitted under each of these windows as well. If the lines near the modes contradict both, there
//! is no such leakage. If not, the bias of damping is reported for the window that fits them
//! better, and each group of close poles is replaced by the poles under that window where they are
//! fewer. Poles without line shape are then fitted from there: damping remains that of the FRFs as
//! measured.
//!
//! Leakage without a window (rectangular) cannot be distinguished from none. On frequency lines a
//! pole `1/s` becomes `1/s − (1 − e^(λT))/(Ts²)`, a pole of a larger decay rate to first order:
//! with its line shape the squared residual of simulated bridges of 1 to 7 lines is 0.90 to 1.08 of
//! that without it, and that of hammer tests with noise 0.96 and more.

use crate::axis::Band;
use crate::finding::{Code, Finding, Location, Severity};
use crate::frf::FrfSet;
use crate::modal::Pole;

use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::error::IdentifyError;
use crate::identify::fit::block_descent::{Convergence, mark_unconverged};
use crate::identify::ml::estimator::MaximumLikelihood;
use crate::identify::pole_model::PoleModel;
use crate::identify::sdof::findings::MAX_LEAKAGE_BIAS;
use crate::linalg::sort_ascending_by;

/// Largest distance from a mode, frequency lines, of the lines on which line shapes are compared:
/// the first side lobe of the Hann window.
const MAX_LINES_FROM_MODE: f64 = 3.0;
/// Squared residual near the modes under a window over that without, above which the data do not
/// have its line shape. Of 72 simulated bridges with a Hann window and resonances of 1.7 lines or
/// more it is 0.65 to 1.03 (up to 1.5 with 0.8 lines), of 30 with a flat top window 0.56 to 1.9; of
/// 400 hammer tests with close modes of 0.4 to 4 lines, and noise up to 40 % of the response, 1.8
/// or more under a Hann window. Twice: of 132 hammer tests in noise 27 instead of 16 have a bias.
/// Half: of 24 bridges 14 second poles remain instead of none. Tests:
/// `random_force_under_an_unstated_window_makes_no_second_poles`, `close_modes_in_noise_stay_two`,
/// `narrow_resonances_of_a_hammer_test_have_no_bias`.
const MAX_RESIDUAL_RATIO: f64 = 1.6;
/// The same above which the data contradict leakage although close poles remain. Above it with the
/// poles moved from where they are, they are not fitted anew: in 261 fits a new fit then never came
/// below [`MAX_RESIDUAL_RATIO`]. Smaller: split poles, which fit the scatter of leakage as well,
/// have no finding of their bias; larger: hammer tests are fitted twice in vain.
const MIN_CONTRADICTION: f64 = 3.0;
/// Number of FRFs in which the poles are moved, those in which the modes are largest.
///
/// Leakage under one force is proportional to the mode shape, so that further FRFs add little. All
/// of 900 FRFs take 2.5 s longer; a sample without regard to the modes contains none in which a
/// local mode, or any mode of one direction, is visible
/// (`modes_at_few_of_many_sensors_have_no_leakage`).
const TESTED_FRFS: usize = 64;

impl MaximumLikelihood {
    /// Tests data without a stated window against the line shape of each window for steady signals.
    /// Where leakage under the best of these windows had split modes, one pole remains for each.
    /// Returns these modes.
    ///
    /// # Errors
    /// Those of a fit under a window.
    pub(in crate::identify) fn check_leakage(
        &self,
        set: &FrfSet,
        band: Band,
        fit: &mut PoleModel,
    ) -> Result<Vec<SplitMode>, IdentifyError> {
        let shapes = LineShape::unstated(set);
        let is_concerned =
            |shape: &LineShape| has_close_poles(fit, *shape) || is_narrow(fit, *shape);
        if !shapes.iter().any(is_concerned) {
            return Ok(Vec::new());
        }
        let mut sample = fit.sample(TESTED_FRFS);
        let near_modes = NearModes::new(&sample);
        let plain = near_modes.residual(&sample);
        let mut possible = Vec::new();
        // All windows, as the one that concerns no mode may describe the data best.
        for shape in shapes {
            let moved = near_modes.residual_under(&mut sample, shape) / plain;
            if !has_close_poles(fit, shape) {
                possible.extend((moved <= MAX_RESIDUAL_RATIO).then_some(Hypothesis {
                    shape,
                    ratio: moved,
                    smoothed: None,
                }));
                continue;
            }
            // Split poles may be caught where they are: under a window they are no local maximum of
            // one pole each.
            if moved > MIN_CONTRADICTION {
                continue;
            }
            let (smoothed, _) = self.fitted(set, band, shape, fit.run_shifts.as_found())?;
            let in_all = NearModes::new(fit);
            let ratio = in_all.residual(&smoothed) / in_all.residual(fit);
            possible.extend((ratio <= MIN_CONTRADICTION).then_some(Hypothesis {
                shape,
                ratio,
                smoothed: Some(smoothed),
            }));
        }
        let poles = fit.poles.len();
        // Best: fewer poles than without a window, then the least residual.
        let rank = |hypothesis: &Hypothesis| (!hypothesis.has_fewer_poles(poles), hypothesis.ratio);
        let best = possible.into_iter().min_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        fit.data.frfs.leakage = best.as_ref().map(|hypothesis| hypothesis.shape);
        let likely = best.filter(|hypothesis| hypothesis.ratio <= MAX_RESIDUAL_RATIO);
        Ok(
            match likely.map(|hypothesis| (hypothesis.shape, hypothesis.smoothed)) {
                Some((shape, Some(smoothed))) => fit.merge_split_poles(&smoothed, shape),
                _ => Vec::new(),
            },
        )
    }
}

/// Leakage under a window that the data do not contradict.
struct Hypothesis {
    shape: LineShape,
    /// Squared residual near the modes over that without it.
    ratio: f64,
    /// Fit under the window, where close poles may be split.
    smoothed: Option<PoleModel>,
}

impl Hypothesis {
    fn has_fewer_poles(&self, than: usize) -> bool {
        (self.smoothed.as_ref()).is_some_and(|fit| fit.poles.len() < than)
    }
}

/// A mode, or close modes, of which leakage had made more poles.
pub(in crate::identify) struct SplitMode {
    /// Mean frequency of the poles that stand for it, rad/s.
    omega: f64,
    poles: usize,
    shape: LineShape,
}

impl PoleModel {
    /// Whether leakage may have biased the damping of a mode by more than [`MAX_LEAKAGE_BIAS`].
    pub(in crate::identify) fn may_have_leakage(&self) -> bool {
        self.data
            .frfs
            .leakage
            .is_some_and(|shape| is_narrow(self, shape))
    }

    /// Replaces each group of close poles by the poles of a fit under a window, where these are
    /// fewer, and fits again without it. If another mode is lost, nothing changes.
    fn merge_split_poles(&mut self, smoothed: &Self, shape: LineShape) -> Vec<SplitMode> {
        let groups = split_groups(self, smoothed, shape);
        if groups.is_empty() {
            return Vec::new();
        }
        let limit = shape.split_lines() * self.data.frfs.step;
        let is_of = |pole: &ModelPole, group: &Group| group.distance(pole) < limit;
        let is_other = |pole: &&ModelPole| !groups.iter().any(|group| is_of(pole, group));
        let others = |poles: &[ModelPole]| poles.iter().filter(is_other).count();
        let expected = others(&self.poles);
        let before = self.snapshot_with_noise();
        self.poles.retain(|pole| is_other(&pole));
        let merged = groups.iter().flat_map(|group| &group.merged);
        self.poles.extend(merged.cloned());
        sort_ascending_by(&mut self.poles, |pole| pole.lambda.im);
        self.reestimate_noise_and_prune();
        self.complete();
        let is_lost = |group: &Group| !self.poles.iter().any(|pole| is_of(pole, group));
        if others(&self.poles) < expected || groups.iter().any(is_lost) {
            self.restore(before);
            return Vec::new();
        }
        groups.into_iter().map(|group| group.mode(shape)).collect()
    }

    /// A finding for each split mode in a band, at the mode that is nearest.
    pub(in crate::identify) fn split_findings(
        &self,
        split: &[SplitMode],
        band: Band,
    ) -> Vec<Finding> {
        let finding = |mode: &SplitMode| {
            let distance = |pole: &&ModelPole| (pole.lambda.im - mode.omega).abs();
            let poles = self.poles.iter();
            let nearest = poles.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            let hz = Pole {
                lambda: nearest.lambda,
            }
            .natural_frequency_hz();
            let in_band = (band.lo_hz..=band.hi_hz).contains(&hz);
            let finding = Finding::new(Severity::Warning, Code::LeakageSplit, Location::Mode(hz));
            let finding = finding.value(mode.poles as f64, "poles");
            in_band.then(|| finding.detail(mode.shape.window_name()))
        };
        split.iter().filter_map(finding).collect()
    }
}

/// Whether the bias of damping of a mode is worth a finding.
fn is_narrow(fit: &PoleModel, shape: LineShape) -> bool {
    let bias = |pole: &ModelPole| shape.leakage_bias(pole.decay());
    let is_biased = |pole: &ModelPole| bias(pole) > Some(MAX_LEAKAGE_BIAS);
    fit.poles.iter().any(is_biased)
}

/// Frequency lines near the modes of a fit, with its noise variances.
struct NearModes {
    lines: Vec<usize>,
    variance: Vec<Vec<f64>>,
}

impl NearModes {
    fn new(fit: &PoleModel) -> Self {
        let limit = MAX_LINES_FROM_MODE * fit.data.frfs.step;
        let is_near = |line: &usize| {
            let distance = |pole: &ModelPole| (pole.lambda.im - fit.data.frfs.omega[*line]).abs();
            fit.poles.iter().any(|pole| distance(pole) < limit)
        };
        let lines: Vec<usize> = (0..fit.data.frfs.lines()).filter(is_near).collect();
        Self {
            variance: (fit.data.noise.by_frf.iter())
                .map(|noise| lines.iter().map(|k| noise.variance(*k)).collect())
                .collect(),
            lines,
        }
    }

    /// Squared residual of a fit over these variances, summed over FRFs and lines.
    fn residual(&self, fit: &PoleModel) -> f64 {
        let described = fit.data.predict(&fit.poles);
        let mut first = 0;
        let mut sum = 0.0;
        for lines in self.lines.chunk_by(|line, next| line + 1 == *next) {
            let range = lines[0]..lines[lines.len() - 1] + 1;
            let normalised = described.residual(range);
            for (f, variance) in self.variance.iter().enumerate() {
                let of_line = |(k, variance): (&usize, &f64)| {
                    normalised.at(f, *k).norm_sqr() * fit.data.noise.by_frf[f].variance(*k)
                        / variance
                };
                let variance = &variance[first..][..lines.len()];
                sum += lines.iter().zip(variance).map(of_line).sum::<f64>();
            }
            first += lines.len();
        }
        sum
    }

    /// Squared residual of its poles under a line shape, refined from their present values.
    fn residual_under(&self, fit: &mut PoleModel, shape: LineShape) -> f64 {
        let poles = fit.poles.clone();
        let correlation = fit.data.noise.line_correlation.clone();
        fit.data.set_line_shape(shape);
        mark_unconverged(&mut fit.poles);
        fit.refine(Convergence::Trial);
        let residual = self.residual(fit);
        fit.data.set_line_shape(LineShape::EXACT);
        fit.data.noise.line_correlation = correlation;
        fit.poles = poles;
        residual
    }
}

/// Whether two poles lie so close that they may be one mode under a window.
fn has_close_poles(fit: &PoleModel, shape: LineShape) -> bool {
    let mut frequencies: Vec<f64> = fit.poles.iter().map(|pole| pole.lambda.im).collect();
    frequencies.sort_by(f64::total_cmp);
    let limit = shape.split_lines() * fit.data.frfs.step;
    frequencies.windows(2).any(|pair| pair[1] - pair[0] < limit)
}

/// Close poles of a fit, and the fewer that a fit under a window has there.
struct Group {
    split: Vec<ModelPole>,
    merged: Vec<ModelPole>,
}

impl Group {
    /// Distance of a pole from the nearest of the group, rad/s.
    fn distance(&self, pole: &ModelPole) -> f64 {
        let all = self.split.iter().chain(&self.merged);
        all.map(|member| (member.lambda.im - pole.lambda.im).abs())
            .fold(f64::INFINITY, f64::min)
    }

    fn mode(&self, shape: LineShape) -> SplitMode {
        let sum: f64 = self.merged.iter().map(|pole| pole.lambda.im).sum();
        SplitMode {
            omega: sum / self.merged.len() as f64,
            poles: self.split.len(),
            shape,
        }
    }
}

/// The groups in which leakage under a window may have split poles.
fn split_groups(fit: &PoleModel, smoothed: &PoleModel, shape: LineShape) -> Vec<Group> {
    let limit = shape.split_lines() * fit.data.frfs.step;
    let plain = fit.poles.iter().map(|pole| (pole, false));
    let smoothed = smoothed.poles.iter().map(|pole| (pole, true));
    let mut all: Vec<(&ModelPole, bool)> = plain.chain(smoothed).collect();
    sort_ascending_by(&mut all, |entry| entry.0.lambda.im);
    let is_near =
        |a: &(&ModelPole, bool), b: &(&ModelPole, bool)| b.0.lambda.im - a.0.lambda.im < limit;
    let group = |chunk: &[(&ModelPole, bool)]| {
        let of = |is_smoothed: bool| -> Vec<ModelPole> {
            let poles = chunk.iter().filter(|pole| pole.1 == is_smoothed);
            poles.map(|pole| pole.0.clone()).collect()
        };
        Group {
            split: of(false),
            merged: of(true),
        }
    };
    let groups = all.chunk_by(is_near).map(group);
    let is_split = |group: &Group| (1..group.split.len()).contains(&group.merged.len());
    groups.filter(is_split).collect()
}

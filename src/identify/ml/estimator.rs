//! The maximum likelihood method: seeds from the polyreference LSCF, maximum likelihood, and as
//! many modes as the data support.
//!
//! 1. Poles that stay over the orders of the LSCF are seeds; how high the orders go follows from
//!    the peaks that are seen, and the lower parts of a wide band have estimates of their own. With
//!    several references, where the roots of these seeds leave over more than noise, the functions
//!    each by itself say as well where roots are and how many modes share each
//!    ([`several`](crate::identify::ml::multiplicity)).
//! 2. All roots move to the maximum of the likelihood ([`refine`](crate::identify::fit::block_descent)).
//! 3. A root stays when it is above the noise (its amplitude, all else fitted, against a
//!    chi-squared), when its pole is known to a fifth of its decay rate, and when it is told apart
//!    from its neighbours by twice the deviation of the distance. Two roots that cannot be told
//!    apart but have different participation factors are one repeated root
//!    ([`pruning`](crate::identify::ml::acceptance)).
//! 4. Noise that neighbouring lines share looks like modes: how far it hangs together is told from
//!    what is left over where that is noise, and raises limits and deviations
//!    ([`correlation`](crate::identify::noise::line_correlation)). Where the data bring no variances and lines share most
//!    of it, its level tells it, and roots that were fitted to it go.
//! 5. What the model leaves over is searched for what noise does not explain; a root is tried there
//!    and must pass the same tests, and what is left over must become less. Where nothing stands
//!    out, each root is asked whether it stands for two ([`doubled`](crate::identify::ml::close_pole_test)). Where it
//!    hardly does, what speaks against a mode (7) speaks against the root at once.
//! 6. Poles of the background, for modes just outside, go where the data do not need them.
//! 7. What is no mode although it is above the noise goes: roots that explain little where the
//!    model misses the data or many have arbitrary phases, or that repeat a strong neighbour with
//!    another phase than modes have ([`standing`](crate::identify::ml::pole_metrics)). What the model misses around a
//!    mode counts as noise in its deviations.
//!
//! Where the file states a window for steady excitation, poles have the line shape that it makes of
//! them ([`receptance`](crate::identify::data::band_frfs)); where none is stated, close poles are merged that the
//! line shape of a Hann or flat top window explains ([`leakage`](crate::identify::ml::leakage)).
//!
//! Lines on both sides of the band are used where the data have them, so that a mode outside does
//! not lean on one inside. Without variances in the data, the noise is told from what the fit
//! leaves over ([`noise`](crate::identify::noise::input_variance)).

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::axis::Band;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::detection_spectrum::Indicator;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::line_shape::LineShape;
use crate::identify::data::model_pole::Root;
use crate::identify::data::peak_detection::{self, Found};
use crate::identify::data::residual::Rest;
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, MethodOptions, PoleAtOrder, PoleEstimator, PoleTable};
use crate::identify::fit::block_descent::{Stop, apart, refine, unsettle};
use crate::identify::fit::compressed_band::Window;
use crate::identify::mdof::lscf::LeastSquaresComplexFrequency;
use crate::identify::mdof::stabilization::{MultiModeMethod, roots_of, stabilised, state_orders};
use crate::identify::ml::acceptance::{Change, Judge};
use crate::identify::ml::amplitude_dependence::strongest_companions;
use crate::identify::ml::findings::{Dropped, Evidence};
use crate::identify::ml::multiplicity::{alone, completed};
use crate::identify::ml::narrower_bands::NarrowerBands;
use crate::identify::ml::pole_metrics::{Standing, candidate, standings};
use crate::identify::ml::trial_poles::WORTHWHILE;
use crate::identify::run_variation::Moved;

/// Roots may lie outside the lines by this share of their range.
const OUTSIDE: f64 = 0.05;
/// Rounds of pruning after each refinement, and of the search in what is left over.
const PRUNINGS: usize = 12;
const SEARCHES: usize = 4;
/// Relative change of a variance that is none.
const SAME_NOISE: f64 = 0.1;
/// A root stands alone where the next is so many sums of half-power widths away.
const ALONE: f64 = 1.0;
/// Relative residual of poles without the line shape of a stated window, over that with it, below
/// which the data contradict the window. Larger: more poles imitate the line shape of one (0.7 and
/// more under a true window). Smaller: in noise of a hundredth of the peaks a window that was
/// stated in error is believed. Tests: `a_window_that_the_data_contradict_is_not_used`,
/// `damping_under_a_stated_hann_window_is_unbiased_and_within_its_deviation`.
const CONTRADICTED: f64 = 0.25;

/// The maximum likelihood method.
pub(in crate::identify) struct Automatic {
    /// Options of the run.
    pub options: MethodOptions,
}

impl PoleEstimator for Automatic {
    fn name(&self) -> &'static str {
        "ml"
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        let shape = LineShape::of(set);
        let (mut fit, found) = self.fitted(set, band, shape)?;
        let split = self.check_leakage((set, band), &mut fit)?;
        // Poles of leakage are no companions.
        if !shape.is_smoothed() && !fit.may_have_leakage() {
            fit.add_companions();
        }
        let splits = fit.split_findings(&split, band);
        let plain = match shape.is_smoothed() {
            true => Some(self.fitted(set, band, LineShape::EXACT)?),
            false => None,
        };
        let contradicts = |(unsmoothed, _): &(Fit, Found)| {
            unsmoothed.relative_residual() < CONTRADICTED * fit.relative_residual()
        };
        let mut table = match plain.filter(contradicts) {
            Some((mut plain, found)) => {
                plain.data.leakage = None;
                let mut table = plain.table((set, band), &found);
                let code = Code::WindowContradicted;
                let finding = Finding::new(Severity::Warning, code, Place::Whole);
                table.findings.push(finding);
                table
            }
            None => fit.table((set, band), &found),
        };
        table.findings.extend(splits);
        state_orders(&mut table);
        Ok(table)
    }
}

impl Automatic {
    /// The fit of poles with a line shape.
    pub(in crate::identify) fn fitted(
        &self,
        set: &FrfSet,
        band: Band,
        shape: LineShape,
    ) -> Result<(Fit, Found), IdentifyError> {
        let (mut fit, found) = self.merged(set, band, shape)?;
        fit.look_outside();
        fit.complete();
        Ok((fit, found))
    }

    /// First roots of the runs as they are, and again with those brought together that disagree: of
    /// all these fits the one that needs the fewest roots where modes move, the latest of several.
    fn merged(
        &self,
        set: &FrfSet,
        band: Band,
        shape: LineShape,
    ) -> Result<(Fit, Found), IdentifyError> {
        let mut moved = Moved::none(set.functions());
        let mut fits: Vec<(Fit, Found)> = Vec::new();
        loop {
            let mut data = Receptances::guarded(set, band)?;
            data.observe(shape);
            moved.straighten(&mut data);
            let sides = Sides::new(set.functions());
            let sides = if sides.complete() {
                sides
            } else {
                sides.as_one_input()
            };
            let indicator = Indicator::new(&data);
            let found =
                peak_detection::search(&data, &indicator, self.options.false_alarm_probability);
            let mut fit = Fit::new(data, sides, self.options);
            fit.first_roots(&found)?;
            fit.moved = moved.clone();
            let changed = moved.told_by(&fit.data, &fit.roots);
            fits.push((fit, found));
            if !changed {
                break;
            }
        }
        let moves = |root: &&Root| fits.iter().any(|(fit, _)| fit.moved.holds(root.lambda));
        let needed = |(fit, _): &(Fit, Found)| fit.roots.iter().filter(moves).count();
        let fewest = (0..fits.len())
            .rev()
            .min_by_key(|index| needed(&fits[*index]));
        Ok(fits.swap_remove(fewest.unwrap_or(0)))
    }
}

/// A fit on its way.
pub(in crate::identify) struct Fit {
    pub data: Receptances,
    pub sides: Sides,
    pub options: MethodOptions,
    pub roots: Vec<Root>,
    pub dropped: Vec<Dropped>,
    /// Roots that there were where their phases scattered.
    pub scattered: Option<usize>,
    /// Modes that move from run to run.
    pub moved: Moved,
    /// Poles of all model orders.
    pub listing: Vec<PoleAtOrder>,
    /// Whether poles stay where they are and residues alone are fitted.
    pub fixed: bool,
    /// Of the last refinement.
    windows: Vec<Window>,
}

impl Fit {
    pub fn new(data: Receptances, sides: Sides, options: MethodOptions) -> Self {
        Self {
            data,
            sides,
            options,
            roots: Vec::new(),
            dropped: Vec::new(),
            scattered: None,
            moved: Moved::default(),
            listing: Vec::new(),
            fixed: false,
            windows: Vec::new(),
        }
    }

    pub fn limits(&self) -> (f64, f64) {
        let outside = OUTSIDE * self.data.range();
        let (first, last) = (self.data.omega[0], self.data.omega[self.data.lines() - 1]);
        ((first - outside).max(0.5 * first), last + outside)
    }

    /// Roots from the poles that stay over the orders, and from what they leave over.
    ///
    /// Many references leave few orders, and a root that many modes share is then fewer poles than
    /// it has modes. Where the roots of all references together leave over more than noise, the
    /// functions are asked one by one as well.
    fn first_roots(&mut self, found: &Found) -> Result<(), IdentifyError> {
        let lscf = LeastSquaresComplexFrequency {
            max_order: self.options.max_order,
        };
        let seeds = self.stable_roots(&lscf, found)?;
        let several = self.sides.inputs > 1;
        let noise = several.then(|| self.data.noise());
        self.roots = seeds.clone();
        let mut changed = self.settle_and_judge();
        if several && !self.leaves_more_than_noise() {
            return Ok(());
        }
        if let Some(noise) = noise {
            // What so few roots leave over says too much of the noise.
            self.data.set_noise(noise);
            self.ask_functions((&lscf, found), seeds)?;
            changed = self.settle_and_judge();
        }
        self.search_rounds(changed);
        Ok(())
    }

    /// Roots from the functions as outputs of one input, which say where roots are, and whose
    /// residues say how many modes each has ([`several`](crate::identify::ml::multiplicity)).
    fn ask_functions(
        &mut self,
        (lscf, found): (&LeastSquaresComplexFrequency, &Found),
        by_inputs: Vec<Root>,
    ) -> Result<(), IdentifyError> {
        let one = self.sides.as_one_input();
        let sides = std::mem::replace(&mut self.sides, one);
        self.roots = alone(&[by_inputs.clone(), self.stable_roots(lscf, found)?].concat());
        self.settle(Stop::Coarse);
        if !self.data.variance_measured() {
            self.measure_noise();
            self.settle(Stop::Coarse);
        }
        let standings = self.standings();
        let free = std::mem::take(&mut self.roots);
        self.dropped.clear();
        self.sides = sides;
        let chance = self.options.false_alarm_probability / self.data.lines() as f64;
        let frfs = (&self.data, &self.sides);
        self.roots = completed(frfs, by_inputs, (&free, &standings), chance);
        Ok(())
    }

    /// Roots that pass beside the noise that they leave; whether that changed. What was told beside
    /// roots that are gone is not theirs.
    fn settle_and_judge(&mut self) -> bool {
        self.settle(Stop::Coarse);
        loop {
            let before = self.roots.len();
            let changed = self.judge_by_noise();
            if self.roots.len() == before {
                return changed;
            }
        }
    }

    /// Removes what is no mode, and fits the others to the end, with their deviations.
    pub fn complete(&mut self) {
        self.doubt();
        self.settle(Stop::Fine);
        self.reckon_with_outside();
        self.reckon_with_noise();
    }

    pub fn judge_by_noise(&mut self) -> bool {
        let changed = self.measure_noise();
        self.settle(Stop::Judging);
        changed
    }

    /// Searches what is left over until nothing more is found, where the noise may have changed
    /// since it was last judged by.
    fn search_rounds(&mut self, mut changed: bool) {
        for _ in 0..SEARCHES {
            let before = self.roots.clone();
            let gain = self.search();
            let worthwhile = gain.is_some_and(|gain| gain >= WORTHWHILE);
            // Asked with success once.
            if !worthwhile && self.lines_share_noise() {
                return self.search_rounds(true);
            }
            // The noise of the same roots is the same.
            if gain.is_none() && !changed && self.roots == before {
                break;
            }
            // Where more roots leave such doubts and explain little, what the next would fit is not
            // modes.
            let last = gain.is_none() || !worthwhile && self.misses_data(&self.doubts());
            changed = self.judge_by_noise();
            if last {
                break;
            }
        }
    }

    fn stable_roots(
        &mut self,
        method: &dyn MultiModeMethod,
        found: &Found,
    ) -> Result<Vec<Root>, IdentifyError> {
        let frfs = (&self.data, &self.sides);
        let stabilisation = stabilised(method, frfs, (found, self.limits(), &[]))?;
        self.listing.extend(stabilisation.poles);
        Ok(roots_of(&stabilisation.seeds, self.data.functions()))
    }

    pub fn refine(&mut self, stop: Stop) {
        let stop = if self.fixed { Stop::Residues } else { stop };
        let (roots, limits) = (std::mem::take(&mut self.roots), self.limits());
        let frfs = (&self.data, &self.sides);
        self.roots = refine(frfs, &mut self.windows, roots, (limits, stop));
    }

    /// The residues of all roots, of which none is dropped; modes of the very same pole become one
    /// root. Poles that merely lie close stay where they are.
    pub fn residues(&mut self) {
        for i in 0..self.roots.len() {
            for j in i + 1..self.roots.len() {
                let same = self.roots[i].lambda == self.roots[j].lambda;
                if same && !self.roots[j].parts.is_empty() {
                    self.apply(Change::Join(i, j));
                }
            }
        }
        self.roots.retain(|root| !root.parts.is_empty());
        unsettle(&mut self.roots);
        self.refine(Stop::Residues);
    }

    /// Refines and drops roots until all that are left pass.
    pub fn settle(&mut self, stop: Stop) {
        self.refine(stop);
        for _ in 0..PRUNINGS {
            let unfit = self.judge().unfit(&self.roots);
            if unfit.is_empty() {
                break;
            }
            for change in unfit {
                self.apply(change);
            }
            self.roots.retain(|root| !root.parts.is_empty());
            unsettle(&mut self.roots);
            self.refine(stop);
        }
    }

    /// Roots that go lose their parts; they are taken out afterwards.
    pub fn apply(&mut self, change: Change) {
        match change {
            Change::Drop(j, reason) => {
                let lambda = self.roots[j].lambda;
                self.dropped.push(Dropped { lambda, reason });
                self.roots[j].parts.clear();
            }
            Change::Join(i, j) => {
                let parts = std::mem::take(&mut self.roots[j].parts);
                let other = self.roots[j].lambda;
                self.roots[i].lambda = 0.5 * (self.roots[i].lambda + other);
                self.roots[i].suspect &= self.roots[j].suspect;
                self.roots[i].join(parts);
            }
            Change::FewerParts(j, count) => self.roots[j].keep_strongest(count),
        }
    }

    fn judge(&self) -> Judge<'_> {
        Judge {
            sides: &self.sides,
            false_alarm_probability: self.options.false_alarm_probability,
            lines: self.data.lines(),
            step: self.data.step,
        }
    }

    pub fn standings(&self) -> Vec<Standing> {
        standings((&self.data, &self.sides), &self.roots)
    }

    /// How large the noise is, as far as the data do not state it, and how it hangs together over
    /// the lines: from what the fit leaves over. Whether the level of a function or the correlation
    /// changed.
    pub fn measure_noise(&mut self) -> bool {
        unsettle(&mut self.roots);
        let (levels, correlation) = (self.levels(), self.data.correlation.clone());
        let mut rest = self.rest();
        self.data.tell_noise(&mut rest);
        self.data.shared = self.data.shared.of_rest(&self.data, &rest);
        let changed = |(before, now): (&f64, &f64)| (now / before - 1.0).abs() > SAME_NOISE;
        self.data.correlation != correlation || levels.iter().zip(&self.levels()).any(changed)
    }

    /// Mean variance of every function.
    fn levels(&self) -> Vec<f64> {
        let level = |f: usize| self.data.mean_variance(f, 0..self.data.lines());
        (0..self.data.functions())
            .into_par_iter()
            .map(level)
            .collect()
    }

    /// What roots and background leave over.
    pub fn rest(&self) -> Rest {
        let far = self.data.far();
        let described = far.beside(&self.data, &self.roots);
        described.left_over(0..self.data.lines())
    }

    /// Mean over the functions of their residual over their values, each summed in squares over the
    /// lines.
    pub fn relative_residual(&self) -> f64 {
        let rest = self.rest();
        let of = |f: usize| {
            let residual = |k: usize| rest.at(f, k).norm_sqr() * self.data.variance[f][k];
            let lines = 0..self.data.lines();
            let residual: f64 = lines.clone().map(residual).sum();
            residual
                / lines
                    .map(|k| self.data.values[f][k].norm_sqr())
                    .sum::<f64>()
        };
        (0..self.data.functions()).map(of).sum::<f64>() / self.data.functions() as f64
    }

    /// Standard deviations of the parts of a root's residues: from the noise of every function and
    /// how it hangs together over the lines. An error of the pole moves all residues of a mode that
    /// stands alone by one factor, but mixes modes that overlap: `None` for those, and for several
    /// modes of one root.
    fn residue_stds(&self, root: &Root, standing: &Standing) -> Option<Vec<f64>> {
        let modes = self.roots.iter().filter(|other| !other.is_companion);
        let near = modes.filter(|other| apart(root, other) < ALONE);
        if root.multiplicity() > 1 || near.count() > 1 {
            return None;
        }
        let correlation_factor = self
            .data
            .correlation
            .of_amplitude(root.decay(), self.data.step);
        let factor = standing.inflation() * (0.5 * correlation_factor).sqrt();
        let stds = root.residue_variances.iter().map(|v| factor * v.sqrt());
        Some(stds.collect())
    }

    pub fn table(&self, (set, band): (&FrfSet, Band), found: &Found) -> PoleTable {
        let described = self.data.far().beside(&self.data, &self.roots);
        let is_mode = |root: &Root| {
            let hz = root.lambda.norm() / TAU;
            !root.is_companion && hz >= band.lo_hz && hz <= band.hi_hz
        };
        let mut standings = self.standings();
        let narrower_bands = NarrowerBands::new(&self.data, &self.roots, &described);
        let with_standing = self.roots.par_iter().zip(&mut standings);
        let modes = with_standing.filter(|(root, _)| is_mode(root));
        modes.for_each(|(root, metrics)| metrics.band_deviation = narrower_bands.deviation(root));
        let modes = self.roots.iter().zip(&standings);
        let mut kept: Vec<(&Root, &Standing)> = modes.filter(|(root, _)| is_mode(root)).collect();
        if let Some(most) = self.options.max_modes {
            let worth = |(root, _): &(&Root, &Standing)| root.quality.significance();
            kept.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
            kept.truncate(most);
            kept.sort_by(|a, b| a.0.lambda.im.total_cmp(&b.0.lambda.im));
        }
        let evidence = Evidence {
            set,
            data: &self.data,
            described,
            band,
            found,
            kept: &kept,
            dropped: &self.dropped,
            scattered: self.scattered,
            moved: &self.moved,
            companions: &strongest_companions(&self.roots),
        };
        PoleTable {
            candidates: kept
                .iter()
                .map(|(root, metrics)| Candidate {
                    residue_stds: self.residue_stds(root, metrics),
                    ..self
                        .moved
                        .merged(candidate(root, metrics), metrics.inflation() > 1.0)
                })
                .collect(),
            findings: evidence.findings(),
            stabilization: self.listing.clone(),
            moved: self.moved.clone(),
        }
    }
}

//! What the maximum likelihood method says of its modes, and why it took no others.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;
use crate::modal::Pole;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::model_pole::Root;
use crate::identify::data::peak_detection::Found;
use crate::identify::data::residual::Described;
use crate::identify::ml::pole_metrics::{Doubt, LEAST_SHARE, MOST_PHASE, Standing};
use crate::identify::run_variation::Moved;
use crate::identify::run_variation::separate_responses::{by_point, run_partners};
use crate::identify::sdof::findings::{dropped_peak, reach};

/// Lines across a half-power band below which damping rests on the model alone.
const FEWEST_LINES: f64 = 1.0;
/// Standard deviation of the damping by narrower bands, in percent of it, above which it is
/// reported: the limit for misfit. Larger: hammer recordings whose damping changes by 14 % from
/// band to band are not reported.
const MAX_BAND_DEVIATION_PERCENT: f64 = 10.0;
/// A peak belongs to a mode within so many half-power widths, or lines.
const AT_PEAK: f64 = 1.0;
const LINES_AT_PEAK: f64 = 3.0;

/// Why a root was dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) enum Reason {
    /// Its significance is what noise reaches: value and limit.
    Noise(f64, f64),
    /// Its pole is not known: deviation over decay rate.
    Unknown(f64),
    /// It cannot be told from a stronger one: distance in deviations.
    Twin(f64),
    /// Its half-power width is no resonance's: Hz.
    Width(f64),
    /// It is no mode although it is above the noise.
    Doubt(Doubt),
}

/// A root that was dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Dropped {
    /// Its pole then, rad/s.
    pub lambda: Complex64,
    /// Why.
    pub reason: Reason,
}

/// All that the findings are made from.
pub(in crate::identify) struct Evidence<'a> {
    /// The set as it came.
    pub set: &'a FrfSet,
    /// Its receptances on band and guard lines.
    pub data: &'a Receptances,
    /// What all poles and the out-of-band terms make of the lines.
    pub described: Described<'a>,
    /// The band that was asked for.
    pub band: Band,
    /// Peaks of the indicator.
    pub found: &'a Found,
    /// Modes that are reported.
    pub kept: &'a [(&'a Root, &'a Standing)],
    /// Roots that were dropped on the way.
    pub dropped: &'a [Dropped],
    /// Roots that there were where their phases scattered.
    pub scattered: Option<usize>,
    /// Modes that move from run to run.
    pub moved: &'a Moved,
    /// Poles of modes that have companions, and how large these are.
    pub companions: &'a [(Complex64, f64)],
}

impl Evidence<'_> {
    /// Findings of the modes in ascending frequency, then of what was not taken.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        if !self.data.variance_measured() {
            findings.push(Finding::new(
                Severity::Info,
                Code::NoiseFromFit,
                Place::Whole,
            ));
        }
        if self.data.line_shape.is_smoothed() {
            findings.push(Finding::new(
                Severity::Info,
                Code::WindowLineShape,
                Place::Whole,
            ));
        }
        if let Some(rate) = self.data.unstated_decay() {
            let finding = Finding::new(Severity::Warning, Code::LinesShareNoise, Place::Whole);
            findings.push(match rate {
                Some(rate) => finding.value(rate, "1/s"),
                None => finding,
            });
        }
        if let Some(roots) = self.scattered {
            let finding = Finding::new(Severity::Warning, Code::PhasesScatter, Place::Whole);
            findings.push(finding.value(roots as f64, ""));
        }
        findings.extend(self.of_runs());
        findings.extend(self.of_misfit());
        for (root, standing) in self.kept {
            findings.extend(self.of_mode(root, standing));
        }
        findings.extend(self.of_parts());
        findings.extend(self.of_doubts());
        findings.extend(self.of_peaks());
        findings
    }

    /// The run that is farthest from the others, where no check of the set told it.
    fn of_runs(&self) -> Option<Finding> {
        let is_reported =
            |finding: &Finding| matches!(finding.code, Code::RunsDisagree | Code::MassLoading);
        if self.set.findings.iter().any(is_reported) {
            return None;
        }
        let away = self.moved.farthest()?;
        let function = &self.set.functions()[away.function];
        let place = Place::Function {
            response: Some(function.response.clone()),
            reference: Some(function.reference.clone()),
        };
        let finding = Finding::new(Severity::Warning, Code::RunsDisagree, place);
        Some(
            finding
                .value(100.0 * away.shift, "%")
                .limit(100.0 * away.limit),
        )
    }

    /// Modes that share the runs with another one.
    fn of_parts(&self) -> Vec<Finding> {
        let kept: Vec<&Root> = self.kept.iter().map(|(root, _)| *root).collect();
        let partners = run_partners(&kept, &by_point(self.set.functions())).into_iter();
        let finding = |(lambda, widths): (Complex64, f64)| {
            Finding::new(Severity::Warning, Code::RunsApart, self.place(lambda)).value(widths, "")
        };
        partners.map(finding).collect()
    }

    fn of_mode(&self, root: &Root, standing: &Standing) -> Vec<Finding> {
        let place = self.place(root.lambda);
        let warning = |code, value: f64, unit: &str, limit: f64| {
            Finding::new(Severity::Warning, code, place.clone())
                .value(value, unit)
                .limit(limit)
        };
        let mut findings = Vec::new();
        if let Some(mode) = self.moved.of(root.lambda) {
            let finding = Finding::new(Severity::Warning, Code::RunsMerged, place.clone());
            let percent = 100.0 * mode.scatter / mode.lambda.im;
            findings.push(finding.value(percent, "%"));
        }
        if root.multiplicity() > 1 {
            let finding = Finding::new(Severity::Info, Code::RepeatedRoot, place.clone());
            findings.push(finding.value(root.multiplicity() as f64, ""));
        }
        let companion = self
            .companions
            .iter()
            .find(|(pole, _)| *pole == root.lambda);
        if let Some((_, size)) = companion {
            let finding = Finding::new(Severity::Warning, Code::AmplitudeDependent, place.clone());
            findings.push(finding.value(*size, ""));
        }
        let decay = root.decay() - self.set.added_damping_rad_s;
        let limit = MAX_BAND_DEVIATION_PERCENT;
        let percent = 100.0 * standing.band_deviation / decay;
        if percent > limit && decay > 0.0 {
            findings.push(warning(Code::BandDependent, percent, "%", limit));
        } else if standing.band_deviation > 0.0 && decay <= 0.0 {
            // The window's decay is all that there is: the damping is not determined.
            findings.push(Finding::new(
                Severity::Warning,
                Code::BandDependent,
                place.clone(),
            ));
        }
        let lines = root.width() / self.data.step;
        if lines < FEWEST_LINES {
            findings.push(warning(Code::FewLines, lines, "", FEWEST_LINES));
        }
        findings.extend(reach(self.set, self.data, root.lambda, &place));
        findings
    }

    /// Roots above the noise that are no modes, the last word on each.
    fn of_doubts(&self) -> Vec<Finding> {
        let mut reported: Vec<(Complex64, Finding)> = Vec::new();
        for dropped in self.dropped.iter().rev() {
            let Reason::Doubt(doubt) = dropped.reason else {
                continue;
            };
            let lambda = dropped.lambda;
            let same = |(other, _): &(Complex64, Finding)| (other - lambda).norm() < -lambda.re;
            if !self.in_band(lambda) || reported.iter().any(same) {
                continue;
            }
            let (code, value, unit, limit) = match doubt {
                Doubt::Share(share) => (Code::RootMinor, share, "", LEAST_SHARE),
                Doubt::Tiny(share, least) => (Code::RootMinor, share, "", least),
                Doubt::Phase(phase) => (
                    Code::RootPhase,
                    phase.to_degrees(),
                    "°",
                    MOST_PHASE.to_degrees(),
                ),
            };
            let finding = Finding::new(Severity::Info, code, self.place(lambda));
            reported.push((lambda, finding.value(value, unit).limit(limit)));
        }
        reported.sort_by(|a, b| a.0.im.total_cmp(&b.0.im));
        reported.into_iter().map(|(_, finding)| finding).collect()
    }

    /// Peaks that are seen and have no mode.
    fn of_peaks(&self) -> Vec<Finding> {
        let found = self.found;
        let line = |line: usize| self.data.omega[line];
        let bare = |omega: f64| {
            let at = |width: f64, lambda: Complex64| {
                let reach = (AT_PEAK * width).max(LINES_AT_PEAK * self.data.step);
                (lambda.im - omega).abs() < reach
            };
            let doubted = |dropped: &&Dropped| matches!(dropped.reason, Reason::Doubt(_));
            let mut rejected = self.dropped.iter().filter(doubted);
            let inside = self.band.lo_hz * TAU <= omega && omega <= self.band.hi_hz * TAU;
            inside
                && !self
                    .kept
                    .iter()
                    .any(|(root, _)| at(root.width(), root.lambda))
                && !rejected.any(|dropped| at(-2.0 * dropped.lambda.re, dropped.lambda))
        };
        let mut findings: Vec<Finding> = found
            .dropped
            .iter()
            .filter(|(peak, _)| bare(line(peak.line)))
            .map(|(peak, drop)| dropped_peak(self.data, peak, drop))
            .collect();
        let peaks = found.peaks.iter().map(|peak| line(peak.line));
        findings.extend(
            peaks
                .filter(|omega| bare(*omega))
                .map(|omega| self.of_peak(omega)),
        );
        findings
    }

    /// The last reason near a peak that has no mode.
    fn of_peak(&self, omega: f64) -> Finding {
        let near = |dropped: &&Dropped| {
            let reach = (-2.0 * AT_PEAK * dropped.lambda.re).max(LINES_AT_PEAK * self.data.step);
            (dropped.lambda.im - omega).abs() < reach
        };
        let finding = Finding::new(
            Severity::Info,
            Code::PeakWithoutMode,
            Place::Mode(omega / TAU),
        );
        match self
            .dropped
            .iter()
            .rev()
            .find(near)
            .map(|dropped| dropped.reason)
        {
            Some(Reason::Noise(value, limit)) => finding.value(value, "").limit(limit),
            Some(Reason::Unknown(value)) => finding.value(value, "decay rates"),
            Some(Reason::Twin(value)) => finding.value(value, "deviations"),
            Some(Reason::Width(value)) => finding.value(value, "Hz"),
            Some(Reason::Doubt(_)) | None => finding,
        }
    }

    fn in_band(&self, lambda: Complex64) -> bool {
        let hz = lambda.norm() / TAU;
        self.band.lo_hz <= hz && hz <= self.band.hi_hz
    }

    /// The row that a finding belongs to: the mode's frequency without the window's damping.
    pub(in crate::identify) fn place(&self, lambda: Complex64) -> Place {
        let pole = Pole { lambda }.without_added_damping(self.set.added_damping_rad_s);
        Place::Mode(pole.natural_frequency_hz())
    }
}

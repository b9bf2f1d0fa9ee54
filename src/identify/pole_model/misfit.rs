//! Findings about modes near which the residual exceeds the noise so far that their enlarged
//! standard deviations matter.
//!
//! Where the reduced chi-square near a mode exceeds its limit, all its standard deviations are
//! enlarged by its square root ([`PoleMetrics::inflation`]). On measured FRFs of little noise that
//! applies to nearly every mode and has no practical effect. Only modes whose damping, frequency or
//! shape becomes uncertain by it have a finding.

use crate::finding::{Code, Finding, Severity};

use crate::identify::data::model_pole::ModelPole;
use crate::identify::pole_model::findings::FindingContext;
use crate::identify::pole_model::pole_metrics::{
    MAX_CHI_SQUARE, PoleMetrics, lines_of_pole, reduced_chi_square_by_frf,
};
use crate::linalg::sort_descending_by;

/// Residual above the noise over the response, both root mean square near the pole, above which a
/// misfit matters: the unmodelled response moves the frequency by about as large a part of the
/// half-power bandwidth. Larger: hardening that moves a frequency by a fifth of its bandwidth and a
/// damping by 39 % may not be reported. Smaller: hardening with 0.021 is reported, whose
/// frequencies are right to a thirtieth of the bandwidth
/// (`hardening_is_reported_where_it_changes_the_modes`).
const MAX_RESIDUAL_RATIO: f64 = 0.04;
/// Enlarged standard deviation of the damping over the damping above which a misfit matters; that
/// of the frequency is then a twentieth of the half-power bandwidth. Larger: the plate of one
/// recorded function with 14 % is not reported. Smaller: recorded hits with 3 to 5 %, which agree
/// over three hit points, are.
const MAX_DAMPING_STD_RATIO: f64 = 0.1;
/// Expected 1 − MAC of a shape with its true one above which a misfit matters: a MAC of 0.99 counts
/// as the same shape. Larger: the recorded beam's modes with 0.016 and 0.029 are not reported.
/// Smaller: shapes with 0.001 are.
const MAX_SHAPE_MAC_LOSS: f64 = 0.01;
/// Maximum number of FRFs in the detail.
const LISTED_FUNCTIONS: usize = 3;

/// Effect of the misfit near a mode on its results.
struct Consequence<'a> {
    pole: &'a ModelPole,
    metrics: &'a PoleMetrics,
    /// Residual above the noise over the response, root mean square.
    residual: f64,
    /// Enlarged standard deviation of the damping over the damping.
    damping: f64,
    /// Expected 1 − MAC by the enlarged standard deviations of the residues; `None` for a repeated
    /// pole.
    shape: Option<f64>,
}

impl Consequence<'_> {
    fn matters(&self) -> bool {
        let shape = self.shape.is_some_and(|loss| loss > MAX_SHAPE_MAC_LOSS);
        self.residual > MAX_RESIDUAL_RATIO || self.damping > MAX_DAMPING_STD_RATIO || shape
    }

    /// Residual, factor of the standard deviations, and those of frequency (over the half-power
    /// bandwidth), damping and shape.
    fn figures(&self) -> String {
        let factor = self.metrics.inflation();
        let (frequency, damping) = (0.5 * self.damping, 100.0 * self.damping);
        let mut text = format!(
            "residual {:.1} % of the FRF, std × {factor:.1}, σ(f)/Δf₃dB {frequency:.3}, σ(ζ)/ζ {damping:.1} %",
            100.0 * self.residual
        );
        if let Some(loss) = self.shape {
            text += &format!(", 1−MAC {loss:.4}");
        }
        text
    }
}

impl FindingContext<'_> {
    /// The modes whose misfit matters, the worst first.
    pub(in crate::identify) fn misfit_findings(&self) -> Vec<Finding> {
        let misfitting = self
            .kept
            .iter()
            .filter(|mode| mode.1.reduced_chi_square > MAX_CHI_SQUARE);
        let consequences = misfitting.map(|(pole, metrics)| self.consequence(pole, metrics));
        let mut all: Vec<Consequence> = consequences.filter(Consequence::matters).collect();
        let worth = |consequence: &Consequence| consequence.damping.max(consequence.residual);
        sort_descending_by(&mut all, worth);
        let finding = |consequence: &Consequence| {
            let location = self.location(consequence.pole.lambda);
            let ratio = consequence.metrics.reduced_chi_square.sqrt();
            let functions = self.functions_of(consequence.pole);
            Finding::new(Severity::Warning, Code::ModelMisfit, location)
                .value(ratio, "")
                .limit(MAX_CHI_SQUARE.sqrt())
                .detail(format!("{}; {functions}", consequence.figures()))
        };
        all.iter().map(finding).collect()
    }

    fn consequence<'a>(&self, pole: &'a ModelPole, metrics: &'a PoleMetrics) -> Consequence<'a> {
        let decay = pole.decay() - self.set.added_damping_rad_s;
        let correlation = &self.data.noise.line_correlation;
        let squared = metrics.reduced_chi_square
            * correlation.amplitude_noise_factor(pole.decay(), self.data.frfs.step);
        let variance: f64 = pole.residue_variances.iter().sum();
        let size: f64 = pole.residues.iter().map(|a| a.norm_sqr()).sum();
        Consequence {
            pole,
            metrics,
            residual: ((metrics.reduced_chi_square - 1.0) / self.response_over_noise(pole)).sqrt(),
            // Where the decay is that of the window, the damping is not determined.
            damping: match decay > 0.0 {
                true => pole.quality.pole_std * metrics.inflation() / decay,
                false => f64::INFINITY,
            },
            shape: (pole.multiplicity() == 1).then(|| (squared * variance / size).min(1.0)),
        }
    }

    /// Mean square of the response over the noise on the lines on which the misfit is measured.
    fn response_over_noise(&self, pole: &ModelPole) -> f64 {
        let (lines, functions) = (
            lines_of_pole(&self.data.frfs, pole),
            self.data.frfs.functions(),
        );
        let of = |f: usize| {
            let power = |k: usize| {
                self.data.frfs.values.at(f, k).norm_sqr() / self.data.noise.by_frf[f].variance(k)
            };
            lines.clone().map(power).sum::<f64>()
        };
        (0..functions).map(of).sum::<f64>() / (lines.len() * functions) as f64
    }

    /// The FRFs with the largest residual over noise near a pole, and how many exceed the limit.
    fn functions_of(&self, pole: &ModelPole) -> String {
        let residual = self
            .described
            .residual(lines_of_pole(&self.data.frfs, pole));
        let misfits = reduced_chi_square_by_frf(&self.data.frfs, &residual, pole);
        let above = misfits
            .iter()
            .filter(|misfit| **misfit > MAX_CHI_SQUARE)
            .count();
        let mut order: Vec<usize> = (0..misfits.len()).collect();
        sort_descending_by(&mut order, |index| misfits[*index]);
        let named = order
            .iter()
            .take(LISTED_FUNCTIONS.min(above.max(1)))
            .map(|f| {
                let function = &self.set.functions()[*f];
                let (response, reference) = (&function.response, &function.reference);
                format!("{response}|{reference} × {:.1}", misfits[*f].sqrt())
            });
        let named: Vec<String> = named.collect();
        format!("{}; {above} of {} FRFs", named.join(", "), misfits.len())
    }
}

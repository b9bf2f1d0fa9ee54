//! Leakage under a window that no file states.
//!
//! Under steady random force with a Hann window the FRF of one mode has the line shape of a smoothed pole
//! ([`LineShape`]), which raises the damping of a fit of poles, and which two poles within the main lobe imitate better
//! than one. Where resonances are so narrow, poles are fitted under a Hann window as well. If the lines near the modes
//! contradict it, there is no such leakage. If not, the bias of damping is reported, and each group of close poles is
//! replaced by the poles under the window where they are fewer. Poles without line shape are then fitted from there:
//! damping remains that of the FRFs as they are.

use crate::axis::Band;
use crate::finding::{Code, Finding, Place, Severity};
use crate::frf::FrfSet;

use super::IdentifyError;
use super::automatic::{Automatic, Fit};
use super::checks::MAX_LEAKAGE_BIAS;
use super::receptance::{LineShape, leakage_bias};
use super::refine::{Stop, unsettle};
use super::roots::Root;

/// Largest distance of poles that leakage may make of one mode, frequency lines: the main lobe of the Hann window ends at 2,
/// its first side lobe at 3. At 2, second poles 2.6 and 2.9 lines from a mode of simulated bridges remain; at 4, more hammer
/// tests are fitted twice in vain.
const MAX_SPLIT_LINES: f64 = 3.0;
/// Squared residual near the modes under a Hann window over that without, above which the data do not have its line shape. Of 72
/// simulated bridges with a Hann window and resonances of 1.7 lines or more it is 0.65 to 1.03 (up to 1.5 with 0.8 lines); of 400
/// hammer tests with close modes of 0.4 to 4 lines, and noise up to 40 % of the response, 1.8 or more. Larger: close modes in
/// noise become one; smaller: second poles remain. Tests: `random_force_under_an_unstated_window_makes_no_second_poles`,
/// `close_modes_in_noise_stay_two`, `narrow_resonances_of_a_hammer_test_have_no_bias`.
const MAX_RESIDUAL_RATIO: f64 = 1.6;
/// The same of the poles of the fit without it, moved from where they are, above which poles are not fitted anew under the window.
/// Smaller: split poles of random force that are caught beside each other remain; larger: hammer tests are fitted twice in vain.
const MAX_RATIO_OF_SPLIT_POLES: f64 = 10.0;
/// Ratio of the fits above which the data contradict leakage although close poles remain. Smaller: split poles of few sensors,
/// which fit the scatter of leakage as well, have no finding of their bias.
const MIN_CONTRADICTION: f64 = 3.0;

impl Automatic {
    /// Tests data without a stated window against the line shape of a Hann window, and leaves one pole for each mode that leakage had
    /// split. A finding where poles were merged, and whether narrow modes may have leakage.
    ///
    /// # Errors
    /// Those of the fit under a Hann window.
    pub(super) fn check_leakage(
        &self,
        (set, band): (&FrfSet, Band),
        fit: &mut Fit,
    ) -> Result<(Option<Finding>, bool), IdentifyError> {
        let Some(shape) = LineShape::unstated(set) else {
            return Ok((None, false));
        };
        let is_narrow = |root: &Root| leakage_bias(set, root.decay()) > Some(MAX_LEAKAGE_BIAS);
        let may_be_split = has_close_poles(fit);
        let is_any_narrow = fit.roots.iter().any(is_narrow);
        if !may_be_split && !is_any_narrow {
            return Ok((None, false));
        }
        let near_modes = NearModes::new(fit);
        let plain = near_modes.residual(fit);
        let moved = near_modes.residual_under(fit, shape) / plain;
        if !may_be_split {
            fit.data.contradicts_leakage = moved > MAX_RESIDUAL_RATIO;
            return Ok((None, !fit.data.contradicts_leakage));
        }
        // Split poles may be caught where they are: under a Hann window they are no local maximum of one pole each.
        if moved > MAX_RATIO_OF_SPLIT_POLES {
            fit.data.contradicts_leakage = true;
            return Ok((None, false));
        }
        let (smoothed, _) = self.fitted(set, band, shape)?;
        let ratio = near_modes.residual(&smoothed) / plain;
        if ratio > MAX_RESIDUAL_RATIO {
            fit.data.contradicts_leakage = ratio > MIN_CONTRADICTION;
            return Ok((None, is_any_narrow && !fit.data.contradicts_leakage));
        }
        let merged = merged(fit, &smoothed);
        let before = fit.roots.len();
        if merged.len() == before {
            return Ok((None, is_any_narrow));
        }
        let removed = before - merged.len();
        fit.roots = merged;
        fit.judge_by_noise();
        fit.complete();
        let finding = Finding::new(Severity::Warning, Code::LeakageSplit, Place::Whole);
        Ok((Some(finding.value(removed as f64, "")), true))
    }
}

/// Frequency lines near the modes of a fit, with its noise variances.
struct NearModes {
    lines: Vec<usize>,
    variance: Vec<Vec<f64>>,
}

impl NearModes {
    fn new(fit: &Fit) -> Self {
        let limit = MAX_SPLIT_LINES * fit.data.step;
        let is_near = |line: &usize| {
            let distance = |root: &Root| (root.lambda.im - fit.data.omega[*line]).abs();
            fit.roots.iter().any(|root| distance(root) < limit)
        };
        let lines: Vec<usize> = (0..fit.data.lines()).filter(is_near).collect();
        Self {
            variance: (fit.data.variance.iter())
                .map(|variance| lines.iter().map(|k| variance[*k]).collect())
                .collect(),
            lines,
        }
    }

    /// Squared residual of a fit over these variances, summed over functions and lines.
    fn residual(&self, fit: &Fit) -> f64 {
        let rest = fit.rest();
        let of_function = |(f, variance): (usize, &Vec<f64>)| {
            let of_line = |(k, variance): (&usize, &f64)| {
                rest.at(f, *k).norm_sqr() * fit.data.variance[f][*k] / variance
            };
            self.lines.iter().zip(variance).map(of_line).sum::<f64>()
        };
        self.variance.iter().enumerate().map(of_function).sum()
    }

    /// The same of its poles under a line shape, moved from where they are.
    fn residual_under(&self, fit: &mut Fit, shape: LineShape) -> f64 {
        let roots = fit.roots.clone();
        let correlation = fit.data.correlation.clone();
        fit.data.observe(shape);
        unsettle(&mut fit.roots);
        fit.refine(Stop::Coarse);
        let residual = self.residual(fit);
        fit.data.observe(LineShape::EXACT);
        fit.data.correlation = correlation;
        fit.roots = roots;
        residual
    }
}

/// Whether two poles lie so close that they may be one mode.
fn has_close_poles(fit: &Fit) -> bool {
    let mut frequencies: Vec<f64> = fit.roots.iter().map(|root| root.lambda.im).collect();
    frequencies.sort_by(f64::total_cmp);
    let limit = MAX_SPLIT_LINES * fit.data.step;
    frequencies.windows(2).any(|pair| pair[1] - pair[0] < limit)
}

/// Poles of a fit, each group of close ones replaced by the poles that another fit has there, where these are fewer.
fn merged(fit: &Fit, smoothed: &Fit) -> Vec<Root> {
    let limit = MAX_SPLIT_LINES * fit.data.step;
    let plain = fit.roots.iter().map(|root| (root, false));
    let smoothed = smoothed.roots.iter().map(|root| (root, true));
    let mut all: Vec<(&Root, bool)> = plain.chain(smoothed).collect();
    all.sort_by(|a, b| a.0.lambda.im.total_cmp(&b.0.lambda.im));
    let is_near = |a: &(&Root, bool), b: &(&Root, bool)| b.0.lambda.im - a.0.lambda.im < limit;
    let fewer = |group: &[(&Root, bool)]| -> Vec<Root> {
        let of = |is_smoothed: bool| -> Vec<Root> {
            let roots = group.iter().filter(|root| root.1 == is_smoothed);
            roots.map(|root| root.0.clone()).collect()
        };
        let (plain, smoothed) = (of(false), of(true));
        match (1..plain.len()).contains(&smoothed.len()) {
            true => smoothed,
            false => plain,
        }
    };
    all.chunk_by(is_near).flat_map(fewer).collect()
}

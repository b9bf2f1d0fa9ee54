//! The common run of the multi-mode methods: poles that stay over the orders, residues, and as many
//! modes as the data support.
//!
//! 1. The poles that stay while the order rises ([`stabilization`](crate::identify::mdof::stabilization)).
//! 2. Residues of all of them by weighted linear least squares, with upper and lower residuals
//!    (LSFD): the linear part of the maximum likelihood fit ([`block`](crate::identify::fit::gauss_newton)), the poles
//!    where the method put them. A method that knows no participation factors gets them from the
//!    residues ([`several`](crate::identify::ml::multiplicity)).
//! 3. A pole stays a mode when its contribution is above the noise, when it is told apart from its
//!    neighbours, and when nothing speaks against it: the tests of the maximum likelihood method.
//!
//! The stated deviation joins what noise lets anybody know (the Cramér-Rao bound) with the distance
//! of the pole to the maximum of the likelihood, as one Gauss-Newton step sees it: the error of the
//! method itself, which for these methods is not small beside the bound.
//!
//! Reference: Guillaume, Verboven and Vanlanduit (1998), Frequency-domain maximum likelihood
//! identification of modal parameters with confidence intervals, ISMA 23 (least-squares frequency
//! domain residues).

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::axis::Band;
use crate::frf::FrfSet;

use crate::identify::data::band_frfs::Receptances;
use crate::identify::data::detection_spectrum::Indicator;
use crate::identify::data::frf_matrix::Sides;
use crate::identify::data::model_pole::Root;
use crate::identify::data::peak_detection::{self, Found};
use crate::identify::error::IdentifyError;
use crate::identify::estimator::{Candidate, MethodOptions, PoleEstimator, PoleTable};
use crate::identify::fit::block_descent::Stop;
use crate::identify::mdof::pole_tracks::Seed;
use crate::identify::mdof::stabilization::{MultiModeMethod, roots_of, sharpened};
use crate::identify::ml::estimator::Fit;
use crate::identify::ml::multiplicity::{completed, strongest};
use crate::identify::run_variation::Moved;

/// A multi-mode method as an estimator.
pub(in crate::identify) struct MultiModeEstimator<M> {
    /// How the poles of an order are found.
    pub method: M,
    /// Options of the run.
    pub options: MethodOptions,
}

impl<M: MultiModeMethod> PoleEstimator for MultiModeEstimator<M> {
    fn name(&self) -> &'static str {
        self.method.name()
    }

    fn estimate(&self, set: &FrfSet, band: Band) -> Result<PoleTable, IdentifyError> {
        let data = Receptances::guarded(set, band)?;
        let sides = Sides::new(set.functions());
        let several = sides.complete() && sides.inputs > 1;
        let one = sides.as_one_input();
        let scalar = !several || !self.method.gives_participation();
        let indicator = Indicator::new(&data);
        let found = peak_detection::search(&data, &indicator, self.options.false_alarm_probability);
        let mut fit = Fit::new(data, if scalar { one } else { sides.clone() }, self.options);
        fit.fixed = true;
        let on = (&fit.data, &fit.sides);
        let own = sharpened(&self.method, on, (&found, fit.limits()))?;
        fit.roots = roots_of(&own.seeds, fit.data.functions());
        fit.settle(Stop::Coarse);
        fit.measure_noise();
        if several && scalar {
            share_out(&mut fit, sides);
        }
        fit.settle(Stop::Coarse);
        fit.measure_noise();
        fit.settle(Stop::Coarse);
        fit.doubt();
        let mut table = fit.table((set, band), &found);
        let references = set.references().len();
        for candidate in &mut table.candidates {
            complete(candidate, &own.seeds, (&fit, references));
        }
        table.stabilization = own.poles;
        Ok(table)
    }
}

/// The modes of known poles, rad/s, with runs brought together as they are known to move: residues
/// and deviations, and nothing is dropped.
///
/// # Errors
/// [`IdentifyError`] when set and band do not go together.
pub(in crate::identify) fn at_poles(
    (set, band): (&FrfSet, Band),
    poles: &[Complex64],
    moved: Moved,
) -> Result<PoleTable, IdentifyError> {
    let mut data = Receptances::guarded(set, band)?;
    moved.straighten(&mut data);
    let sides = Sides::new(set.functions());
    let several = sides.complete() && sides.inputs > 1;
    let functions = data.functions();
    let mut fit = Fit::new(data, sides.as_one_input(), MethodOptions::default());
    fit.fixed = true;
    fit.moved = moved;
    let root = |pole: &Complex64| Root::single(*pole, &[Complex64::ONE], functions);
    fit.roots = poles.iter().map(root).collect();
    fit.residues();
    fit.measure_noise();
    if several {
        let free = share_out(&mut fit, sides);
        for pole in free {
            if !fit.roots.iter().any(|root| root.lambda == pole.lambda) {
                fit.roots.push(strongest(&fit.sides, &pole)?);
            }
        }
    }
    fit.residues();
    let mut table = fit.table((set, band), &Found::default());
    let references = set.references().len();
    for candidate in &mut table.candidates {
        complete(candidate, &[], (&fit, references));
    }
    Ok(table)
}

/// Replaces poles whose residues are free by roots with participation factors, as many as the
/// residues show; what they were.
fn share_out(fit: &mut Fit, sides: Sides) -> Vec<Root> {
    let standings = fit.standings();
    let free = std::mem::take(&mut fit.roots);
    let chance = fit.options.false_alarm_probability / fit.data.lines() as f64;
    fit.sides = sides;
    let own = (&fit.data, &fit.sides);
    fit.roots = completed(own, Vec::new(), (&free, &standings), chance);
    free
}

/// Order, deviation and participation factors of a candidate: those of the pole that stays nearest
/// to it and of its root. The inputs of a fit are references, or else nothing is said of these.
fn complete(candidate: &mut Candidate, seeds: &[Seed], (fit, references): (&Fit, usize)) {
    let lambda = candidate.pole.lambda;
    let distance = |seed: &&Seed| (seed.pole.lambda - lambda).norm();
    let nearest = seeds
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    candidate.order = nearest.map(|seed| seed.order);
    let Some(root) = fit.roots.iter().find(|root| root.lambda == lambda) else {
        return;
    };
    // Real and imaginary part have half of its square each.
    let offset = root.quality.offset.norm() * std::f64::consts::FRAC_1_SQRT_2;
    let joined = |std: Option<f64>, own: f64| std.map(|std| std.hypot(own));
    candidate.frequency_std_hz = joined(candidate.frequency_std_hz, offset / TAU);
    candidate.damping_std = joined(candidate.damping_std, offset / lambda.norm());
    let single = root.multiplicity() == 1 && root.parts[0].len() == references;
    candidate.participation = single.then(|| root.parts[0].clone());
}

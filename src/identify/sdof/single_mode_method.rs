//! The interface of the single-mode methods: one isolated resonance in, its pole out.

use std::ops::Range;

use num_complex::Complex64;

use crate::identify::sdof::weighted_mean::weighted_mean;

/// Half of the window for residues, in half-power bandwidths: wide enough to separate the skirts of
/// the resonance from the constant.
pub(in crate::identify) const RESIDUE_HALF_WINDOW_BANDWIDTHS: f64 = 2.5;
/// Minimum number of lines on either side of the resonance for residues.
pub(in crate::identify) const MIN_RESIDUE_SIDE_LINES: usize = 6;

/// One resonance in a window of lines, with the other modes subtracted.
pub(in crate::identify) struct Isolated<'a> {
    /// Lines of the window, rad/s.
    pub omega: &'a [f64],
    /// Receptance with the other modes subtracted, m/N, by function.
    pub values: Vec<Vec<Complex64>>,
    /// Noise variance of each function in the window, (m/N)².
    pub variance: Vec<f64>,
    /// The pole of the pass before, rad/s.
    pub lambda: Complex64,
}

/// Pole of one resonance with its standard deviations.
#[derive(Clone, Copy, Debug)]
pub(in crate::identify) struct SingleModeFit {
    /// Pole as in the data, rad/s.
    pub lambda: Complex64,
    /// Standard deviation of Im λ, rad/s.
    pub omega_std_rad_s: Option<f64>,
    /// Standard deviation of −Re λ, rad/s.
    pub decay_std_rad_s: Option<f64>,
    /// Relative standard deviation of the damping surface.
    pub spread: Option<f64>,
    /// Whether a half-power point was missing.
    pub one_sided: bool,
}

/// Pole of a resonance, estimated from one FRF.
pub(in crate::identify) struct FunctionFit {
    /// Weight in the mean over FRFs: power of the resonance over the noise variance.
    pub weight: f64,
    /// Pole as in the data, rad/s.
    pub lambda: Complex64,
    /// Figure of merit of the method: relative scatter that the fit of this FRF does not explain.
    pub spread: f64,
}

impl SingleModeFit {
    /// Weighted mean over the FRFs that could be fitted; `None` where none could.
    pub fn mean_over_functions(
        isolated: &Isolated,
        fit_one: fn(&Isolated, usize) -> Option<FunctionFit>,
    ) -> Option<Self> {
        let fits: Vec<FunctionFit> = (0..isolated.values.len())
            .filter_map(|f| fit_one(isolated, f))
            .collect();
        let mean = |value: fn(&FunctionFit) -> f64| {
            let pairs: Vec<(f64, f64)> = fits.iter().map(|fit| (fit.weight, value(fit))).collect();
            weighted_mean(&pairs)
        };
        let (omega, decay) = (mean(|fit| fit.lambda.im)?, mean(|fit| -fit.lambda.re)?);
        Some(Self {
            lambda: Complex64::new(-decay.mean, omega.mean),
            omega_std_rad_s: omega.std,
            decay_std_rad_s: decay.std,
            spread: mean(|fit| fit.spread).map(|spread| spread.mean),
            one_sided: false,
        })
    }
}

/// A method that fits one resonance at a time.
pub(in crate::identify) trait SingleModeMethod: Send + Sync {
    /// Its name.
    fn name(&self) -> &'static str;
    /// Half of its window in half-power bandwidths, and the minimum number of lines on either side.
    fn window(&self) -> (f64, usize);
    /// The pole of an isolated resonance; `None` where the fit fails.
    fn fit(&self, isolated: &Isolated) -> Option<SingleModeFit>;
}

/// One resonance during the refinement passes.
#[derive(Clone, Debug)]
pub(in crate::identify) struct Resonance {
    /// The pole read from the peak, rad/s.
    pub initial: Complex64,
    /// The current pole, rad/s.
    pub lambda: Complex64,
    /// The latest fit of the method.
    pub fit: Option<SingleModeFit>,
    /// Lines for residues and checks.
    pub lines: Range<usize>,
}

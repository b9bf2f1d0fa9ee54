//! At the lines around a group of poles it is decided whether individual poles of each run replace
//! the poles of the fit.

use num_complex::Complex64;

use crate::linalg::{self, ComplexMatrix, ThinQr};

use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::out_of_band_basis::OutOfBandBasis;
use crate::identify::data::residual::{pole_columns, residues};
use crate::identify::fit::fit_data::FitData;
use crate::identify::noise::band_profile::BandProfile;
use crate::identify::run_variation::shifted_mode::ShiftedMode;

/// Half-width of the fitted lines around a pole, half-power bandwidths.
const HALF_WIDTH_BANDWIDTHS: f64 = 3.0;
/// Minimum number of lines on each side: the flanks of a narrow resonance determine its pole as
/// well.
const MIN_LINES_PER_SIDE: f64 = 10.0;
/// Step that ends the iteration, decay rates.
pub(super) const CONVERGED_STEP_DECAY_RATES: f64 = 1e-6;

/// The lines around a strong pole and the poles of its group, without the response of poles farther
/// away.
pub(super) struct Resonance<'a> {
    pub(super) data: &'a FitData,
    pub(super) omega: Vec<f64>,
    pub(super) profile: BandProfile,
    /// Values over the noise, of aligned runs: lines × FRFs.
    pub(super) aligned: ComplexMatrix,
    /// Values over the noise, as measured; `None` where no mode nearby shifts, so that they are the
    /// aligned ones.
    values: Option<ComplexMatrix>,
    /// Profiles of out-of-band terms, with a curvature: lines × columns.
    background: ComplexMatrix,
    pub(super) group: Vec<&'a ModelPole>,
    /// Poles outside the group.
    pub(super) others: Vec<Complex64>,
}

impl<'a> Resonance<'a> {
    /// The lines around the strong pole of a group; the FRFs are aligned by `shifted` modes. `None`
    /// where too few lines separate the poles around.
    pub fn new(
        data: &'a FitData,
        model_poles: &'a [ModelPole],
        group: &[usize],
        runs: &[Vec<usize>],
        shifted: &[ShiftedMode],
    ) -> Option<Self> {
        let strong = &model_poles[group[0]];
        let distance = |j: &usize| (model_poles[*j].lambda.im - strong.lambda.im).abs();
        let farthest = group.iter().map(distance).fold(0.0, f64::max) / strong.width();
        let side = farthest
            + HALF_WIDTH_BANDWIDTHS.max(MIN_LINES_PER_SIDE * data.frfs.step / strong.width());
        let lines = data.frfs.lines_around(strong.lambda, side);
        let omega = data.frfs.omega[lines.clone()].to_vec();
        let near = |lambda: Complex64| is_nearby(&omega, lambda);
        let (poles_near, farther): (Vec<ModelPole>, Vec<ModelPole>) = model_poles
            .iter()
            .cloned()
            .partition(|model_pole| near(model_pole.lambda));
        let background = OutOfBandBasis::new(&data.frfs.omega, &lines, data.out_of_band_terms());
        let middle = 0.5 * omega.len() as f64;
        let columns = background.columns();
        let background = linalg::complex_matrix(omega.len(), columns + 1, |k, column| {
            if column == columns {
                Complex64::from((k as f64 / middle - 1.0).powi(2))
            } else {
                background.value(column, &omega, k)
            }
        });
        // Out-of-band terms, the pole with its derivative, and as many lines again to detect
        // misfit.
        if omega.len() < 2 * (poles_near.len() + background.ncols() + 2) {
            return None;
        }
        let profile = BandProfile::new(&data.noise, lines.clone());
        let over = |k: usize, f: usize| profile.noise_profile[k] * profile.level[f];
        let explained = pole_columns(data.frfs.line_shape, &omega, &farther)
            * residues(&farther, data.frfs.functions());
        let aligned = linalg::complex_matrix(omega.len(), data.frfs.functions(), |k, f| {
            let value = data.frfs.values.at(f, lines.start + k) - explained[(k, f)];
            value / over(k, f)
        });
        let modes_near: Vec<&ShiftedMode> =
            (shifted.iter()).filter(|mode| near(mode.lambda)).collect();
        let as_measured = || {
            let mut values = aligned.clone();
            for (run, functions) in runs.iter().enumerate() {
                for (f, k) in functions
                    .iter()
                    .flat_map(|f| (0..omega.len()).map(move |k| (*f, k)))
                {
                    let corrections = modes_near
                        .iter()
                        .map(|mode| mode.correction(data.frfs.line_shape, f, run, omega[k]));
                    values[(k, f)] -= corrections.sum::<Complex64>() / over(k, f);
                }
            }
            values
        };
        let values = (!modes_near.is_empty()).then(as_measured);
        let other = |j: &usize| !group.contains(j);
        Some(Self {
            aligned,
            values,
            group: group.iter().map(|j| &model_poles[*j]).collect(),
            others: (0..model_poles.len())
                .filter(other)
                .map(|j| model_poles[j].lambda)
                .collect(),
            data,
            omega,
            profile,
            background,
        })
    }

    /// Orthonormal basis of the out-of-band profiles and of the profiles of the poles that are
    /// near, over the profile of the noise.
    pub(super) fn basis(&self, poles: &[Complex64]) -> ComplexMatrix {
        let near: Vec<Complex64> = (poles.iter().copied())
            .filter(|lambda| is_nearby(&self.omega, *lambda))
            .collect();
        let columns = near.len() + self.background.ncols();
        let columns = linalg::complex_matrix(self.omega.len(), columns, |k, column| {
            let value = match near.get(column) {
                Some(lambda) => self.data.frfs.line_shape.pole(self.omega[k], *lambda) * lambda.re,
                None => self.background[(k, column - near.len())],
            };
            value / self.profile.noise_profile[k]
        });
        ThinQr::or_not_a_number(&columns).q
    }

    /// The strong pole.
    pub fn strong(&self) -> Complex64 {
        self.group[0].lambda
    }

    /// Lowest and highest frequency of the poles of the group, rad/s.
    pub fn span(&self) -> (f64, f64) {
        let frequencies = self.group.iter().map(|model_pole| model_pole.lambda.im);
        frequencies.fold((f64::INFINITY, 0.0), |(lo, hi), at| {
            (at.min(lo), at.max(hi))
        })
    }

    pub fn functions(&self) -> usize {
        self.data.frfs.functions()
    }

    /// Measured values over the noise: lines × FRFs.
    pub fn values(&self) -> &ComplexMatrix {
        self.values.as_ref().unwrap_or(&self.aligned)
    }
}

/// Whether a pole lies within some lines, or so near that it exceeds the out-of-band terms there.
fn is_nearby(omega: &[f64], lambda: Complex64) -> bool {
    let (lo, hi) = (omega[0], omega[omega.len() - 1]);
    let reach = (hi - lo).max(-2.0 * HALF_WIDTH_BANDWIDTHS * lambda.re);
    lambda.im > lo - reach && lambda.im < hi + reach
}

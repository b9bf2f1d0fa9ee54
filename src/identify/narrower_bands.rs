//! How far a pole moves when fewer lines around it are fitted, where that is more than noise explains.
//!
//! Its standard deviation takes the residual for noise that is independent from line to line and from FRF to FRF. What a
//! response that depends on the amplitude, a truncated record or a local mode outside the model leave is neither, and what it does
//! to a pole does not fall with the number of values. It shows when the band changes: one Gauss-Newton step of the pole
//! and its residues on the lines of a narrower band,
//!
//! ```text
//! δλ = Σ_f Σ_k conj(a_f g_k/σ_fk) r_fk / Σ_f Σ_k |a_f g_k/σ_fk|²
//! ```
//!
//! with the residues a, the residual r over its standard deviation σ, and g what out-of-band terms and the poles around leave
//! of `1/(iω − λ)²`. Where the residual is noise, δλ has the variance of the narrower band less that of the fitted one in each
//! part (Hausman 1978, Econometrica 46(6)).

use std::ops::Range;

use num_complex::Complex64;

use super::background::{Background, Outside};
use super::far::{Described, Rest};
use super::influence::orthogonal_derivative;
use super::noise_profile::Profile;
use super::receptance::Receptances;
use super::refine::window;
use super::roots::Root;

/// Narrower bands, in parts of the fitted lines below and above the pole.
const BANDS: [(f64, f64); 5] = [
    (0.5, 0.5),
    (0.25, 0.25),
    (0.125, 0.125),
    (0.1, 1.0),
    (1.0, 0.1),
];
/// Mean square of both parts of a shift over that expected of noise, above which it is not noise. Of noise it has an
/// exponential distribution of mean 1: 4,000 shifts reached 9.8. Larger: shifts of more standard deviations stay out.
const MIN_SHIFT_RATIO: f64 = 10.0;
/// Least variance of a shift over that of the pole: the difference of nearly equal bounds is uncertain, and negative where
/// modes outside the band enlarged that of the fitted one. In noise alone it is 1.3 and more.
const MIN_VARIANCE_RATIO: f64 = 0.5;

/// Standard deviation of each part of a pole, rad/s, from the largest of its shifts over narrower bands that noise does not
/// explain; 0 where noise explains all.
pub(super) fn band_deviation(
    model: (&Receptances, &[Root]),
    described: &Described,
    root: &Root,
) -> f64 {
    let shifts = shifts(model, described, root).into_iter();
    let beyond = shifts.filter_map(|Shift { seen, expected }| {
        (seen > MIN_SHIFT_RATIO * expected).then_some(seen - expected)
    });
    beyond.fold(0.0, f64::max).sqrt()
}

/// How far a narrower band moves a pole: mean squares of real and imaginary part, rad²/s².
struct Shift {
    seen: f64,
    /// By noise alone.
    expected: f64,
}

/// The shift of each narrower band with enough lines.
fn shifts(
    (data, roots): (&Receptances, &[Root]),
    described: &Described,
    root: &Root,
) -> Vec<Shift> {
    let whole = window(data, std::iter::once(root));
    let top = data.line_of(root.lambda);
    let residual = described.left_over(whole.clone());
    let known = root.quality.pole_std.powi(2);
    let noise = known / root.quality.pole_bound.powi(2);
    let shift = |(below, above): (f64, f64)| {
        let below = below * (top - whole.start) as f64;
        let above = above * (whole.end - 1 - top) as f64;
        let lines = top - below.round() as usize..top + above.round() as usize + 1;
        let (step, bound) = step_on((data, roots), &residual, (root, lines))?;
        Some(Shift {
            seen: 0.5 * step.norm_sqr(),
            expected: (bound * noise - known).max(MIN_VARIANCE_RATIO * known),
        })
    };
    BANDS.into_iter().filter_map(shift).collect()
}

/// One step of a pole on some lines, rad/s, and the variance of each part of it in white noise; `None` where the lines are
/// too few.
fn step_on(
    (data, roots): (&Receptances, &[Root]),
    residual: &Rest,
    (root, lines): (&Root, Range<usize>),
) -> Option<(Complex64, f64)> {
    let profile = Profile::new(data, lines.clone());
    let background = Background::new(
        &data.omega[lines.clone()],
        &(0..lines.len()),
        &Outside::Anywhere,
    );
    let derivative = orthogonal_derivative(data, (roots, root), (&lines, &profile, &background))?;
    let scale = root.decay().powi(2);
    let energy: f64 = derivative.iter().map(Complex64::norm_sqr).sum();
    let (mut along, mut weights) = (Complex64::ZERO, 0.0);
    for (f, (a, level)) in root.residues.iter().zip(&profile.level).enumerate() {
        let terms = derivative.iter().zip(residual.of(f, lines.clone()));
        let sum: Complex64 = terms.map(|(g, r)| g.conj() * r).sum();
        along += a.conj() / level * sum;
        weights += (a / level).norm_sqr();
    }
    let step = along * scale / (weights * energy);
    let variance = 0.5 * scale.powi(2) / (weights * energy);
    (step.is_finite() && variance.is_finite()).then_some((step, variance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Band, FrequencyAxis};
    use crate::identify::MethodOptions;
    use crate::identify::automatic::Fit;
    use crate::identify::refine::Stop;
    use crate::identify::sides::Sides;
    use crate::identify::synthetic::{Measurement, Structure};
    use crate::modal::Pole;

    const WHOLE_HZ: [f64; 2] = [60.0, 150.0];
    const AXIS: FrequencyAxis = FrequencyAxis {
        start_hz: 60.0,
        step_hz: 0.2,
        len: 451,
    };

    /// Modes at 90 and 120 Hz over six sensors, and one beside the second with so much of its residues.
    fn structure(beside: f64) -> Structure {
        let shape = |a: f64, size: f64| (1..=6).map(|p| size * (a * f64::from(p)).cos()).collect();
        Structure {
            modes: vec![
                (90.0, 0.005, shape(0.3, 1.0)),
                (120.0, 0.008, shape(0.7, 1.0)),
                (121.0, 0.008, shape(0.9, beside.sqrt())),
            ],
        }
    }

    /// A fit of the first two modes alone on a band; of the second alone where that begins above the first.
    fn fitted(beside: f64, seed: u64, band_hz: [f64; 2]) -> Fit {
        let how = Measurement {
            snr_db: Some(60.0),
            seed,
            ..Measurement::of_sensors(6, AXIS)
        };
        let set = structure(beside).measured(&how);
        let band = Band::new(band_hz[0], band_hz[1]).unwrap();
        let data = Receptances::guarded(&set, band).unwrap();
        let mut fit = Fit::new(data, Sides::new(set.functions()), MethodOptions::default());
        let one = [Complex64::ONE];
        let modes = if band_hz[0] < 90.0 { 0..2 } else { 1..2 };
        fit.roots = modes
            .map(|mode| Root::single(truth(mode), &one, 6))
            .collect();
        fit.refine(Stop::Fine);
        fit.reckon_with_noise();
        fit
    }

    fn truth(mode: usize) -> Complex64 {
        let (hz, zeta, _) = structure(0.0).modes[mode].clone();
        Pole::from_frequency(hz, zeta).lambda
    }

    #[test]
    fn noise_moves_a_pole_over_narrower_bands_as_expected() {
        let mut ratios = vec![Vec::new(); BANDS.len()];
        for seed in 0..60 {
            let fit = fitted(0.0, seed, WHOLE_HZ);
            let far = fit.data.far();
            let described = far.beside(&fit.data, &fit.roots);
            for root in &fit.roots {
                let model = (&fit.data, &fit.roots[..]);
                assert!(band_deviation(model, &described, root) <= 0.0, "{seed}");
                let shifts = shifts(model, &described, root);
                for (ratios, shift) in ratios.iter_mut().zip(shifts) {
                    ratios.push(shift.seen / shift.expected);
                }
            }
        }
        for (ratios, band) in ratios.iter().zip(BANDS) {
            // Exponential of mean 1: 0.09 is the standard deviation of the mean of 120.
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((0.6..1.4).contains(&mean), "{band:?}: {mean}");
        }
    }

    #[test]
    fn the_deviation_covers_narrower_bands_where_a_mode_is_not_in_the_model() {
        const NARROWER_HZ: [[f64; 2]; 5] = [
            [115.0, 125.0],
            [118.0, 122.0],
            [119.0, 150.0],
            [60.0, 121.0],
            [60.0, 130.0],
        ];
        for (beside, seed) in [(0.0, 0), (0.003, 1), (0.01, 2), (0.03, 3), (0.1, 4)] {
            let fit = fitted(beside, seed, WHOLE_HZ);
            let far = fit.data.far();
            let described = far.beside(&fit.data, &fit.roots);
            let root = &fit.roots[1];
            let deviation = band_deviation((&fit.data, &fit.roots), &described, root);
            let by_noise = root.quality.pole_std;
            assert_eq!(deviation > 2.0 * by_noise, beside >= 0.01, "{beside}");
            for band in NARROWER_HZ {
                let other = fitted(beside, seed, band).roots.pop().unwrap();
                let shift = (other.lambda - root.lambda).norm() / 2f64.sqrt();
                let by_noise = by_noise.hypot(other.quality.pole_std);
                let with_bands = shift / by_noise.hypot(deviation);
                assert!(with_bands < 3.0, "{beside} {band:?}: {with_bands}");
                // Beside a mode outside the model, noise explains none of the shifts.
                let explained = shift / by_noise < 3.0;
                assert!(explained || beside > 0.0, "{beside} {band:?}");
            }
        }
    }
}

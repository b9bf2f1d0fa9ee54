//! Factors of the noise model: on the strength and on the variance of a pole, and on the energy of
//! a residual.
//!
//! Response noise is independent between FRFs and has one line correlation, force noise along the
//! response another. A quantity that is split into its components along the response and across it
//! is compared with both.

use num_complex::Complex64;

use crate::identify::data::band_frfs::BandFrfs;
use crate::identify::data::model_pole::ModelPole;
use crate::identify::data::residual::Residual;
use crate::identify::noise::force_noise::per_segment;
use crate::identify::noise::model::NoiseModel;

/// Maximum number of lines of a pole that are compared.
const MAX_COMPARED_LINES: usize = 64;
/// Half-power bandwidths on either side in which a pole is compared with the response.
const COMPARED_BANDWIDTHS: f64 = 2.0;

impl NoiseModel {
    /// Factor by which noise raises the strength of a pole where there is no mode: the component of
    /// the pole along the response of the other poles counts as force noise.
    pub fn amplitude_noise_factor(&self, frfs: &BandFrfs, root: &ModelPole) -> f64 {
        let response_factor = self
            .line_correlation
            .amplitude_noise_factor(root.decay(), frfs.step);
        if !self.force_noise.is_common() {
            return response_factor;
        }
        let force_factor = self
            .force_noise
            .line_correlation()
            .amplitude_noise_factor(root.decay(), frfs.step);
        let parts = self.energy_splits(frfs, root, 1, |k, f| {
            frfs.values.at(f, k) - contribution(frfs, root, k, f)
        });
        let across: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let along: f64 = parts.iter().map(|part| part.along / part.excess).sum();
        ratio_of_at_least_one(whole, across / response_factor + along / force_factor)
            .unwrap_or(response_factor)
    }

    /// Factor of the variance of a pole over that in white noise that is independent between FRFs.
    pub fn pole_noise_factor(&self, frfs: &BandFrfs, root: &ModelPole) -> f64 {
        let response_factor = self
            .line_correlation
            .pole_noise_factor(root.decay(), frfs.step);
        if !self.force_noise.is_common() {
            return response_factor;
        }
        let force_factor = self
            .force_noise
            .line_correlation()
            .pole_noise_factor(root.decay(), frfs.step);
        let parts = self.energy_splits(frfs, root, 2, |k, f| frfs.values.at(f, k));
        let across: f64 = parts.iter().map(|part| part.across).sum();
        let whole: f64 = parts.iter().map(|part| part.across + part.along).sum();
        let along: f64 = parts.iter().map(|part| part.along * part.excess).sum();
        ratio_of_at_least_one(response_factor * across + force_factor * along, whole)
            .unwrap_or(response_factor)
    }

    /// Energy at one line of a value per FRF, with its component along the response divided by the
    /// variance ratio, so that independent noise of the same energy has the same significance.
    pub fn noise_weighted_energy(
        &self,
        frfs: &BandFrfs,
        rest: &Residual,
        line: usize,
        value: impl Fn(usize) -> Complex64,
    ) -> f64 {
        if !self.force_noise.is_common() {
            let of = |f: &usize| value(*f).norm_sqr();
            return self.force_noise.groups().iter().flatten().map(of).sum();
        }
        // Noise common to response and residual would look like force noise.
        let response = |f: usize| frfs.values.at(f, line) / self.std(f, line) - rest.at(f, line);
        let of = |(number, group): (usize, &Vec<usize>)| {
            let part = split_by_direction(group, &value, response);
            part.across + part.along / self.force_noise.variance_ratio(number, line)
        };
        self.force_noise.groups().iter().enumerate().map(of).sum()
    }

    /// The same energy of the residual, at each of its lines.
    pub fn noise_weighted_energy_by_line(&self, frfs: &BandFrfs, rest: &Residual) -> Vec<f64> {
        per_segment(&rest.lines, |lines| {
            if !self.force_noise.is_common() {
                let mut power = vec![0.0; lines.len()];
                for f in 0..frfs.functions() {
                    for (sum, value) in power.iter_mut().zip(rest.of(f, lines.clone())) {
                        *sum += value.norm_sqr();
                    }
                }
                return power;
            }
            let at = |k: usize| self.noise_weighted_energy(frfs, rest, k, |f| rest.at(f, k));
            lines.map(at).collect()
        })
    }

    /// `1/(s − λ)` of a pole to a power on its lines, split into components along the response and
    /// across it, by reference and line.
    fn energy_splits(
        &self,
        frfs: &BandFrfs,
        root: &ModelPole,
        power: usize,
        response: impl Fn(usize, usize) -> Complex64,
    ) -> Vec<EnergySplit> {
        let mut parts = Vec::new();
        let lines = frfs.lines_around(root.lambda, COMPARED_BANDWIDTHS);
        let stride = lines.len().div_ceil(MAX_COMPARED_LINES);
        for k in lines.step_by(stride) {
            let (omega, decay) = (frfs.omega[k], root.decay());
            let line_shape = frfs.line_shape.power(decay, omega, root.lambda, power);
            for (number, group) in self.force_noise.groups().iter().enumerate() {
                let amplitude = |f: usize| root.residues[f] * line_shape / self.std(f, k);
                let part =
                    split_by_direction(group, amplitude, |f| response(k, f) / self.std(f, k));
                let excess = self.force_noise.variance_ratio(number, k);
                // Independent noise has no preferred direction.
                parts.push(match excess > 1.0 {
                    true => EnergySplit { excess, ..part },
                    false => EnergySplit {
                        along: 0.0,
                        across: part.across + part.along,
                        excess,
                    },
                });
            }
        }
        parts
    }
}

fn ratio_of_at_least_one(above: f64, below: f64) -> Option<f64> {
    let ratio = above / below;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio.max(1.0))
}

/// Contribution of a pole to an FRF at a line, with its conjugate.
fn contribution(frfs: &BandFrfs, root: &ModelPole, k: usize, f: usize) -> Complex64 {
    let pole = |lambda| frfs.line_shape.pole(frfs.omega[k], lambda);
    let residue = root.residues[f];
    residue * pole(root.lambda) + residue.conj() * pole(root.lambda.conj())
}

/// Energies at one line of one reference, along the response and across it.
struct EnergySplit {
    along: f64,
    across: f64,
    excess: f64,
}

fn split_by_direction(
    group: &[usize],
    value: impl Fn(usize) -> Complex64,
    response: impl Fn(usize) -> Complex64,
) -> EnergySplit {
    let (mut product, mut square, mut whole) = (Complex64::ZERO, 0.0, 0.0);
    for &f in group {
        let (u, h) = (value(f), response(f));
        product += h.conj() * u;
        square += h.norm_sqr();
        whole += u.norm_sqr();
    }
    let along = if square > 0.0 {
        (product.norm_sqr() / square).min(whole)
    } else {
        0.0
    };
    EnergySplit {
        along,
        across: whole - along,
        excess: 1.0,
    }
}

#[cfg(test)]
mod tests {
    use crate::identify::noise::noise_factors::*;

    #[test]
    fn energies_along_and_across_the_response_add_up() {
        let response = [
            Complex64::new(1.0, 1.0),
            Complex64::new(0.0, -2.0),
            Complex64::ONE,
        ];
        let energies = |value: &dyn Fn(usize) -> Complex64| {
            split_by_direction(&[0, 1, 2], value, |f| response[f])
        };
        let same = energies(&|f| Complex64::new(0.0, 3.0) * response[f]);
        assert!((same.along - 63.0).abs() < 1e-12 && same.across.abs() < 1e-12);
        let other = energies(&|f| if f == 2 { 7.0.into() } else { Complex64::ZERO });
        assert!((other.along - 7.0).abs() < 1e-12 && (other.across - 42.0).abs() < 1e-12);
    }
}

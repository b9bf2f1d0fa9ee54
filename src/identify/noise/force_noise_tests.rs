//! Force noise common to the FRFs of one reference, estimated from residual and variances.

use crate::identify::noise::force_noise::*;
use crate::identify::synthetic::white_noise;

fn lines(excess: f64, variance: f64, seed: u64) -> Vec<ResponseLine> {
    let along = white_noise(400, variance, seed);
    let line = |along| ResponseLine {
        along,
        excess,
        noise: true,
    };
    along.into_iter().map(line).collect()
}

#[test]
fn excess_noise_along_the_response_is_common_force_noise() {
    for seed in 0..20 {
        // 400 squares of one exponential variable each have a mean known to 5 %.
        assert!(common_fraction_of_lines(&lines(3.0, 3.0, seed), 1.0) > 0.7);
        assert!((common_fraction_of_lines(&lines(5.0, 3.0, seed), 1.0) - 0.5).abs() < 0.2);
        assert!(common_fraction_of_lines(&lines(3.0, 1.0, seed), 1.0) <= 0.0);
        // FRFs without force noise have none in common.
        assert!(common_fraction_of_lines(&lines(1.0, 1.0, seed), 1.0) <= 0.0);
    }
}

#[test]
fn variances_of_the_same_impacts_scatter_together() {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{ChiSquared, Distribution};

    const FREEDOM: f64 = 6.0;
    let scatter = ChiSquared::new(FREEDOM).expect("degrees of freedom are positive");
    for seed in 0..10 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut fraction = |same: bool| {
            let mut estimated = vec![Vec::new(); 4];
            for _ in 0..100 {
                let common = scatter.sample(&mut random) / FREEDOM;
                for (f, variances) in estimated.iter_mut().enumerate() {
                    let independent = scatter.sample(&mut random) / FREEDOM;
                    variances.push((1 + f) as f64 * if same { common } else { independent });
                }
            }
            let estimated: Vec<VarianceSamples> = (estimated.into_iter().enumerate())
                .map(|(f, variance)| VarianceSamples {
                    power: vec![(1 + f) as f64; variance.len()],
                    variance,
                    degrees_of_freedom: Some(FREEDOM),
                    lines_per_effective_line: 1.0,
                    response_noise: None,
                })
                .collect();
            let smooth = SmoothedVariance {
                variance: vec![1.0; 100],
                force_fraction: vec![0.95; 100],
            };
            let all: Vec<&VarianceSamples> = estimated.iter().collect();
            common_fraction_from_variances(&all, &vec![smooth; 4])
        };
        assert!(fraction(true) > 0.999);
        assert!(fraction(false) < 0.3);
    }
    // ψ′(1) is π²/6, ψ′(1/2) is π²/2.
    let square = std::f64::consts::PI.powi(2);
    assert!((trigamma(1.0) - square / 6.0).abs() < 1e-4);
    assert!((trigamma(0.5) - square / 2.0).abs() < 1e-4);
}

//! The weighted mean joins the estimates of one quantity from several FRFs and measures their
//! scatter.

/// A weighted mean with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct WeightedMean {
    /// `Σ w x / Σ w`.
    pub mean: f64,
    /// Standard deviation of the mean from the scatter; `None` for fewer than two effective values.
    pub std: Option<f64>,
}

/// Weighted mean of (weight, value) pairs; `None` without any weight.
///
/// The values are independent with variances near `1/w` up to a common factor. With `n = (Σw)²/Σw²`
/// effective values the variance of the mean is `Σ w²(x − x̄)² / (Σw)² · n/(n − 1)`, which holds
/// for wrong weights too.
pub(in crate::identify) fn weighted_mean(pairs: &[(f64, f64)]) -> Option<WeightedMean> {
    let total: f64 = pairs.iter().map(|(w, _)| w).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mean = pairs.iter().map(|(w, x)| w * x).sum::<f64>() / total;
    let squares: f64 = pairs.iter().map(|(w, _)| w * w).sum();
    let effective = total * total / squares;
    let scatter: f64 = pairs.iter().map(|(w, x)| (w * (x - mean)).powi(2)).sum();
    let variance = scatter / (total * total) * effective / (effective - 1.0);
    Some(WeightedMean {
        mean,
        std: (pairs.len() >= 2 && effective > 1.05).then(|| variance.sqrt()),
    })
}

#[cfg(test)]
mod tests {
    use crate::identify::sdof::weighted_mean::*;

    #[test]
    fn equal_weights_give_the_textbook_mean_and_standard_error() {
        let result = weighted_mean(&[(2.0, 1.0), (2.0, 2.0), (2.0, 6.0)]).unwrap();
        assert!((result.mean - 3.0).abs() < 1e-15);
        assert!((result.std.unwrap() - (14.0f64 / 2.0 / 3.0).sqrt()).abs() < 1e-14);
        assert_eq!(weighted_mean(&[(1.0, 5.0)]).unwrap().std, None);
        assert_eq!(weighted_mean(&[]), None);
    }
}

//! Driving points: where force and response meet, the power into a passive structure is never
//! negative.

use num_complex::Complex64;

use crate::finding::{Code, Finding, Severity};

use super::mobility::Mobilities;
use crate::frf::peaks::{Peak, clear_peaks};

/// A clear peak is this far above the noise, as power (25 dB). Its amplitude and that of a
/// half-power point are `0.29 |Y|` apart, and their difference has the standard deviation `√v`: at
/// 300 v noise cuts such a gap into a flank once in 3 million lines (5 deviations), and makes no
/// additional peak.
pub(super) const CLEAR_PEAK_OVER_NOISE: f64 = 300.0;
/// Lines between the half-power points of a peak that shows the sign of its real part.
const MIN_LINES_PER_BANDWIDTH: f64 = 3.0;

/// `Re Y(s) ≥ 0` for `Re s ≥ 0` when force and response are at one point along one axis: with an
/// exponential window too.
///
/// The value is the share of energy with the wrong sign between the half-power points of the
/// function's clear peaks, each peak counted alike. There `|arg Y| ≤ 45°` for one mode, so that
/// noise 25 dB below the peak turns no sign. The limit is half of one peak. A wrong sign of one
/// channel gives 1.
pub(super) fn findings(data: &Mobilities) -> Vec<Finding> {
    let signs = driving_points(data).into_iter();
    signs
        .filter_map(|i| {
            let sign = wrong_sign(data, i)?;
            (sign.value > sign.limit).then(|| {
                Finding::new(Severity::Warning, Code::DrivingPointSign, data.location(i))
                    .value(sign.value, "")
                    .limit(sign.limit)
            })
        })
        .collect()
}

/// The functions whose force and response are at one point along one axis.
pub(super) fn driving_points(data: &Mobilities) -> Vec<usize> {
    let functions = data.functions().iter().enumerate();
    let at_one_point = functions.filter(|(_, f)| {
        f.response.without_sign_and_repeat() == f.reference.without_sign_and_repeat()
    });
    at_one_point.map(|(i, _)| i).collect()
}

/// Share of energy with the wrong sign at the clear peaks of a driving point, with its limit.
pub(super) struct WrongSign {
    pub value: f64,
    pub limit: f64,
}

/// The wrong sign of function `i`; `None` where it has no clear peak.
pub(super) fn wrong_sign(data: &Mobilities, i: usize) -> Option<WrongSign> {
    let values = data.values(i);
    let power: Vec<f64> = values.iter().map(Complex64::norm_sqr).collect();
    let floor: Vec<f64> = data
        .noise(i)
        .iter()
        .map(|noise| CLEAR_PEAK_OVER_NOISE * noise)
        .collect();
    let peaks = clear_peaks(&power, &floor, MIN_LINES_PER_BANDWIDTH);
    let wrong: f64 = peaks
        .iter()
        .map(|peak| wrong_sign_fraction(&values, peak))
        .sum();
    (!peaks.is_empty()).then(|| WrongSign {
        value: wrong / peaks.len() as f64,
        limit: 0.5 / peaks.len() as f64,
    })
}

/// Energy with a negative real part between the half-power points over all of it.
fn wrong_sign_fraction(values: &[Complex64], peak: &Peak) -> f64 {
    let lines = &values[peak.inside()];
    let wrong = lines.iter().filter(|y| y.re < 0.0);
    let energy: f64 = lines.iter().map(Complex64::norm_sqr).sum();
    wrong.map(Complex64::norm_sqr).sum::<f64>() / energy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, add_noise, delayed};
    use crate::frf::{FrfSet, convert};
    use crate::quantity::FrfKind;

    fn found(set: &FrfSet) -> Vec<f64> {
        let found = findings(&Mobilities::new(set).unwrap());
        assert!(found.iter().all(|f| f.code == Code::DrivingPointSign));
        found.iter().filter_map(|f| f.value).collect()
    }

    #[test]
    fn a_true_driving_point_is_quiet_in_every_kind_and_with_a_window() {
        for added in [0.0, 8.0] {
            let beam = Beam {
                added_damping_rad_s: added,
                ..Beam::default()
            };
            for pair in [("1:+Z", "1:+Z"), ("1:-Z", "1:-Z"), ("2:+Z", "2:+Z#2")] {
                let set = beam.set(&[pair]);
                for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
                    assert!(found(&convert(&set, kind)).is_empty());
                }
            }
        }
    }

    #[test]
    fn a_wrong_sign_turns_all_of_it() {
        // The data are those of 1:+Z, the label says 1:-Z.
        let set = Beam::default().relabelled(("1:+Z", "1:+Z"), ("1:-Z", "1:+Z"));
        let values = found(&set);
        assert!(
            values.len() == 1 && (values[0] - 1.0).abs() < 1e-12,
            "{values:?}"
        );
        // A sensor that is turned and says so is right.
        assert!(found(&Beam::default().set(&[("1:-Z", "1:+Z")])).is_empty());
    }

    #[test]
    fn another_point_turns_the_modes_of_opposite_sign() {
        // Points 1 and 3 move against each other in modes 2 and 4 of 5.
        let set = Beam::default().relabelled(("3:+Z", "1:+Z"), ("1:+Z", "1:+Z"));
        let values = found(&set);
        assert!(
            values.len() == 1 && (values[0] - 0.4).abs() < 0.01,
            "{values:?}"
        );
    }

    #[test]
    fn a_delay_turns_the_modes_beyond_a_quarter_period() {
        // 1.1 ms turn 90 degrees at 227 Hz: modes at 310 and 390 Hz of five.
        let set = delayed(&Beam::default().set(&[("1:+Z", "1:+Z")]), 1.1e-3);
        let values = found(&set);
        assert!(
            values.len() == 1 && (0.3..0.5).contains(&values[0]),
            "{values:?}"
        );
    }

    #[test]
    fn noise_alone_has_no_peak() {
        let mut set = Beam::default().relabelled(("1:+Z", "1:+Z"), ("1:-Z", "1:+Z"));
        add_noise(&mut set, -30.0, 3);
        assert!(found(&set).is_empty());
    }
}

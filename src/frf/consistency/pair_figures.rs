//! Figures of reciprocity and of driving points of a whole set, where they are within their limits,
//! too.

use super::discrepancy::difference;
use super::driving_point::{driving_points, wrong_sign};
use super::mobility::Mobilities;
use super::reciprocity::{LIMIT, reciprocal};
use crate::dof::Dof;
use crate::frf::FrfSet;

/// Reciprocity of the pairs that were measured in both directions.
#[derive(Clone, Debug, PartialEq)]
pub struct PairFigures {
    /// Number of pairs.
    pub pairs: usize,
    /// Number of those whose difference is above its limit.
    pub above_limit: usize,
    /// Response of the pair with the largest difference over its limit.
    pub response: Dof,
    /// The excitation point of that pair.
    pub reference: Dof,
    /// Relative difference of its two functions.
    pub difference: f64,
    /// The limit of that difference: of calibration, or of noise where noise explains more.
    pub limit: f64,
}

/// Reciprocity of a set; `None` where no pair was measured in both directions.
pub(in crate::frf) fn reciprocity_figures(set: &FrfSet) -> Option<PairFigures> {
    let data = Mobilities::new(set)?;
    let pairs = reciprocal(&data);
    let compared = pairs.iter().map(|(a, b)| {
        let found = difference(&data, *a, *b);
        let function = &data.functions()[*b];
        PairFigures {
            pairs: pairs.len(),
            above_limit: 0,
            response: function.response.clone(),
            reference: function.reference.clone(),
            difference: found.relative,
            limit: LIMIT.max(found.of_noise),
        }
    });
    let compared: Vec<PairFigures> = compared.collect();
    let above_limit = compared.iter().filter(|pair| pair.difference > pair.limit);
    let above_limit = above_limit.count();
    let excess = |pair: &PairFigures| pair.difference / pair.limit;
    let worst = compared.into_iter();
    let worst = worst.max_by(|a, b| excess(a).total_cmp(&excess(b)))?;
    Some(PairFigures {
        above_limit,
        ..worst
    })
}

/// Signs of the driving points.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivingPoints {
    /// Driving points with a clear peak.
    pub points: usize,
    /// Those whose real part has the wrong sign: response and excitation point.
    pub wrong: Vec<(Dof, Dof)>,
    /// Largest share of energy with the wrong sign.
    pub value: f64,
    /// Its limit: half of one peak.
    pub limit: f64,
}

/// Driving points of a set; `None` where it has none with a clear peak.
pub(in crate::frf) fn driving_point_figures(set: &FrfSet) -> Option<DrivingPoints> {
    let data = Mobilities::new(set)?;
    let mut figures: Option<DrivingPoints> = None;
    for i in driving_points(&data) {
        let Some(sign) = wrong_sign(&data, i) else {
            continue;
        };
        let all = figures.get_or_insert(DrivingPoints {
            points: 0,
            wrong: Vec::new(),
            value: sign.value,
            limit: sign.limit,
        });
        all.points += 1;
        if sign.value - sign.limit > all.value - all.limit {
            (all.value, all.limit) = (sign.value, sign.limit);
        }
        if sign.value > sign.limit {
            let function = &data.functions()[i];
            let pair = (function.response.clone(), function.reference.clone());
            all.wrong.push(pair);
        }
    }
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frf::consistency::synthetic::{Beam, scaled};

    #[test]
    fn reciprocity_has_its_figure_within_and_above_the_limit() {
        let pairs = [
            ("1:+Z", "2:+Z"),
            ("2:+Z", "1:+Z"),
            ("1:+Z", "3:+Z"),
            ("3:+Z", "1:+Z"),
        ];
        let set = Beam::default().set(&pairs);
        let sound = reciprocity_figures(&set).unwrap();
        assert_eq!((sound.pairs, sound.above_limit), (2, 0));
        assert!(sound.difference < 0.01, "{sound:?}");
        let faulty = reciprocity_figures(&scaled(&set, 3, 1.3)).unwrap();
        assert_eq!((faulty.pairs, faulty.above_limit), (2, 1));
        assert_eq!(
            [&faulty.response, &faulty.reference].map(ToString::to_string),
            ["3:+Z", "1:+Z"]
        );
        assert!((0.2..0.3).contains(&faulty.difference), "{faulty:?}");
        assert_eq!(reciprocity_figures(&Beam::default().set(&pairs[..1])), None);
    }

    #[test]
    fn driving_points_have_their_signs() {
        let set = Beam::default().set(&[("1:+Z", "1:+Z"), ("2:+Z", "2:+Z"), ("2:+Z", "1:+Z")]);
        let sound = driving_point_figures(&set).unwrap();
        assert_eq!((sound.points, sound.wrong.len()), (2, 0));
        let faulty = driving_point_figures(&scaled(&set, 1, -1.0)).unwrap();
        assert_eq!(faulty.wrong.len(), 1);
        assert!(faulty.value > 0.99 && faulty.limit < 0.2, "{faulty:?}");
        let none = Beam::default().set(&[("2:+Z", "1:+Z")]);
        assert_eq!(driving_point_figures(&none), None);
    }
}

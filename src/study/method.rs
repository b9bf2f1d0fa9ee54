//! The methods that a study compares are all estimators of [`ESTIMATORS`], those with a model order
//! at several orders.

use std::fmt;

use crate::axis::Band;
use crate::frf::FrfSet;
use crate::identify::{ESTIMATORS, IdentifyError, IdentifyOptions, identify};
use crate::modal::ModalModel;

/// An estimator with its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Method {
    /// Its name in [`ESTIMATORS`].
    pub name: &'static str,
    /// Highest model order; chosen by the method, or none, without it.
    pub order: Option<usize>,
}

impl Method {
    /// Maximum likelihood, whose solution is the reference for other methods.
    pub const REFINED: Self = Self {
        name: "ml",
        order: None,
    };

    /// Every estimator; an estimator with an order once at the order that it chooses and once at
    /// each of these.
    pub fn all(orders: &[usize]) -> Vec<Self> {
        let mut all = Vec::new();
        for entry in ESTIMATORS {
            let name = entry.name;
            all.push(Self { name, order: None });
            if entry.has_order {
                let stated = orders.iter().map(|order| Some(*order));
                all.extend(stated.map(|order| Self { name, order }));
            }
        }
        all
    }

    /// The options of an identification by it.
    pub fn options(&self, band: Band) -> IdentifyOptions {
        let mut options = IdentifyOptions {
            method: self.name.to_owned(),
            band: Some(band),
            ..IdentifyOptions::default()
        };
        options.estimator.max_order = self.order;
        options
    }

    /// The modes that it finds in a band.
    ///
    /// # Errors
    /// As [`identify`].
    pub fn identify(&self, set: &FrfSet, band: Band) -> Result<ModalModel, IdentifyError> {
        identify(set, &self.options(band))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.order {
            Some(order) => write!(f, "{} {order}", self.name),
            None => f.write_str(self.name),
        }
    }
}

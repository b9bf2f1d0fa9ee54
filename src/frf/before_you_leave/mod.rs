//! The list of what to repeat or to add before the structure is gone: points to hit again,
//! linearity, reciprocity, driving points and drift over the test.
//!
//! | file | items |
//! |---|---|
//! | `hit_again` | excitation points whose hits do not suffice, with the reasons |
//! | `linearity` | whether poles depend on the force |
//! | `mass_line` | mass line of a suspended test, and its suspension |

pub(super) mod hit_again;
pub(super) mod linearity;
pub(super) mod mass_line;

use super::consistency::pair_figures::{
    DrivingPoints, PairFigures, driving_point_figures, reciprocity_figures,
};
use super::consistency::visits::Drift;
use super::hammer_test::HammerTestResult;
use hit_again::{HitAgain, hit_again};
use linearity::{Linearity, linearity};
use mass_line::{MassLineCheck, SupportCheck};

/// An item of the list. Where its data are missing, the item says what to measure.
#[derive(Clone, Debug, PartialEq)]
pub enum CheckItem {
    /// Points to hit again; absent without hits.
    HitAgain(HitAgain),
    /// Dependence on the force; absent without hits.
    Linearity(Linearity),
    /// Functions measured in both directions; `None` where there are none.
    Reciprocity(Option<PairFigures>),
    /// Signs of driving points; `None` where there are none.
    DrivingPoints(Option<DrivingPoints>),
    /// A point that was hit again after others; `None` where there is none; absent without hits.
    Drift(Option<Drift>),
    /// The mass line; absent where none is there and neither a suspended structure nor a mass is
    /// stated.
    MassLine(Box<MassLineCheck>),
    /// The support; absent where none is stated.
    Support(SupportCheck),
}

/// The items of a test in the order of the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeforeYouLeave {
    /// The items.
    pub items: Vec<CheckItem>,
}

/// The list of a test. A test with a shaker has no hits and the items of its FRFs alone.
pub fn before_you_leave(result: &HammerTestResult) -> BeforeYouLeave {
    let set = &result.estimated.set;
    let mut items = Vec::new();
    if !result.hits.is_empty() {
        items.push(CheckItem::HitAgain(hit_again(&result.hits, set)));
        items.push(CheckItem::Linearity(linearity(&result.hits, &set.findings)));
    }
    items.push(CheckItem::Reciprocity(reciprocity_figures(set)));
    items.push(CheckItem::DrivingPoints(driving_point_figures(set)));
    if !result.hits.is_empty() {
        items.push(CheckItem::Drift(result.drift.clone()));
    }
    BeforeYouLeave { items }
}

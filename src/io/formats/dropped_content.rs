//! Properties that a writer omits are counted and reported.

use std::collections::BTreeMap;

use crate::finding::{Code, Finding, Location, Severity};

/// How many of what were left out.
#[derive(Debug, Default)]
pub(in crate::io) struct DroppedContent(BTreeMap<&'static str, usize>);

impl DroppedContent {
    /// `count` more of `what`.
    pub fn add(&mut self, what: &'static str, count: usize) {
        if count > 0 {
            *self.0.entry(what).or_default() += count;
        }
    }

    /// The value, when it is there; else one more of `what`.
    pub fn or_add<T>(&mut self, what: &'static str, value: Option<T>) -> Option<T> {
        self.add(what, usize::from(value.is_none()));
        value
    }

    /// A finding for each kind.
    pub fn findings(self) -> Vec<Finding> {
        let finding = |(what, count): (&str, usize)| {
            let location = Location::Parameter(what.to_owned());
            Finding::new(Severity::Warning, Code::NotCarried, location).value(count as f64, "")
        };
        self.0.into_iter().map(finding).collect()
    }
}

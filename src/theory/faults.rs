//! Faults of a file are collected, so that one run names all.

use std::fmt::Display;

/// Maximum number of faults that are collected, more than a message lists. Larger: a file with a
/// fault in each line takes minutes, because each is compared with the others and sought in the
/// file. Smaller: a message cannot say that there are more.
const MAX_COLLECTED: usize = 50;

/// An error that may consist of several.
pub(crate) trait Fault: Display + Sized {
    /// Its faults, each alone; of a single one that one.
    fn split(self) -> Vec<Self>;

    /// The error of two faults or more.
    fn several(faults: Vec<Self>) -> Self;
}

/// Collected faults.
#[derive(Debug)]
pub(crate) struct Faults<E>(pub Vec<E>);

impl<E> Default for Faults<E> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<E: Fault> Faults<E> {
    /// The value of a result, whose error is collected.
    pub fn take<T>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// Adds an error, each once.
    pub fn add(&mut self, error: E) {
        for fault in error.split() {
            if self.0.len() >= MAX_COLLECTED {
                return;
            }
            let text = fault.to_string();
            if self.0.iter().all(|known| known.to_string() != text) {
                self.0.push(fault);
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Nothing where there is no fault.
    ///
    /// # Errors
    /// The fault, or the error of several.
    pub fn into_result(mut self) -> Result<(), E> {
        match self.0.len() {
            0 => Ok(()),
            1 => self.0.pop().map_or(Ok(()), Err),
            _ => Err(E::several(self.0)),
        }
    }
}

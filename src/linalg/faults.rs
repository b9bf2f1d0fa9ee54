//! Decompositions that fail on purpose in tests of their callers, by the order of the calls on one
//! thread; only with the feature `faults`.

use std::cell::Cell;
use std::ops::Range;

use super::LinalgError;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
    static FAILING: Cell<(usize, usize)> = const { Cell::new((0, 0)) };
}

/// Runs with the calls of these numbers failing, the first being 0; with the number of calls.
pub fn with_failing<R>(calls: Range<usize>, run: impl FnOnce() -> R) -> (R, usize) {
    CALLS.set(0);
    FAILING.set((calls.start, calls.end));
    let result = run();
    FAILING.set((0, 0));
    (result, CALLS.get())
}

/// One more call.
///
/// # Errors
/// [`LinalgError::NotConverged`] where it is to fail.
pub(super) fn call(what: &'static str) -> Result<(), LinalgError> {
    let number = CALLS.get();
    CALLS.set(number + 1);
    let (first, end) = FAILING.get();
    if (first..end).contains(&number) {
        let (rows, columns) = (0, 0);
        return Err(LinalgError::NotConverged {
            what,
            rows,
            columns,
        });
    }
    Ok(())
}

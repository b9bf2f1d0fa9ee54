//! Loops compiled for the vector units that a processor has.

use pulp::{Arch, NullaryFnOnce};

/// Runs a loop compiled for the vector units that this processor has: a closure that is
/// `#[inline(always)]`.
#[inline(always)]
pub fn vectorised<R>(run: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Loop(run))
}

/// A loop that is called where it is. As `FnOnce` a closure is called through a function between
/// that has no vector units, and that is not inlined where the loop is long.
struct Loop<F>(F);

impl<R, F: FnMut() -> R> NullaryFnOnce for Loop<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}

//! A verdict of a table has a text, and a class that gives it a colour on a page.

use crate::update;

/// Declares the verdicts with their text and their class in one table.
macro_rules! verdicts {
    ($($(#[$doc:meta])* $name:ident: $text:expr, $class:literal;)*) => {
        /// A verdict of a table.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Verdict { $($(#[$doc])* $name,)* }

        impl Verdict {
            /// Every verdict, in the order of its declaration.
            pub const ALL: &[Verdict] = &[$(Verdict::$name,)*];

            /// The text of a cell.
            pub fn text(self) -> &'static str {
                match self { $(Verdict::$name => $text,)* }
            }

            /// The style class of a page: `good`, `fair`, `bad`, or `dim`.
            pub fn class(self) -> &'static str {
                match self { $(Verdict::$name => $class,)* }
            }
        }
    };
}

verdicts! {
    /// Test and model mode are a pair.
    Paired: "paired", "good";
    /// Another partner of the mode is as good within chance.
    Ambiguous: "ambiguous", "fair";
    /// The unmatched model mode shares a peak with a paired one.
    UnmatchedNearPair: "unmatched, near a paired mode", "fair";
    /// The test should observe the unmatched model mode.
    UnmatchedObservable: "unmatched model mode, should have been seen", "bad";
    /// Whether the test can observe the unmatched model mode is unknown.
    UnmatchedUnknown: "unmatched, observability unknown", "bad";
    /// The test cannot observe the model mode.
    NotObservable: "not-observable", "dim";
    /// The model mode is outside the band of the test.
    OutsideBand: "outside-band", "dim";
    /// The test mode has no partner in the model.
    UnmatchedTestMode: "unmatched test mode", "bad";
    /// The data determine the updated parameter.
    Identified: update::ParameterVerdict::Identified.name(), "good";
    /// The data determine the updated parameter within the error of the model.
    IdentifiedWithinModelError: update::ParameterVerdict::IdentifiedWithinModelError.name(), "good";
    /// The updated parameter is at one of its bounds.
    AtBound: update::ParameterVerdict::AtBound.name(), "fair";
    /// The data do not determine the updated parameter.
    NotSupported: update::ParameterVerdict::NotSupported.name(), "dim";
    /// As [`Verdict::NotSupported`], and the update held the parameter at its initial value.
    NotSupportedHeld: "not supported by the data; held", "dim";
    /// The checks accept the hit.
    Used: "used", "good";
    /// The checks accept the hit, of which one exceeds the limit of a remark.
    UsedWithRemark: "used, with a remark", "fair";
    /// The user accepts the hit.
    UsedAsStated: "used (stated)", "good";
    /// The checks reject the hit.
    Rejected: "rejected", "bad";
    /// The user rejects the hit.
    RejectedAsStated: "rejected (stated)", "bad";
    /// The recomputed value of a claim is the printed one.
    Reproduced: "reproduced", "good";
    /// The recomputed value of a claim is another one.
    NotReproduced: "NOT reproduced", "bad";
    /// The data for the claim, or its number, are missing.
    NotCheckable: "not checkable", "fair";
    /// A value is within its limit.
    Met: "met", "good";
    /// A value is beyond its limit.
    Missed: "MISSED", "bad";
    /// A change of parameters explains the misfit.
    Explains: "yes", "good";
}

impl Verdict {
    /// Verdict on a limit.
    pub fn of_limit(met: bool) -> Self {
        if met { Verdict::Met } else { Verdict::Missed }
    }
}

impl From<update::ParameterVerdict> for Verdict {
    fn from(verdict: update::ParameterVerdict) -> Self {
        match verdict {
            update::ParameterVerdict::Identified => Verdict::Identified,
            update::ParameterVerdict::IdentifiedWithinModelError => {
                Verdict::IdentifiedWithinModelError
            }
            update::ParameterVerdict::Ambiguous => Verdict::Ambiguous,
            update::ParameterVerdict::AtBound => Verdict::AtBound,
            update::ParameterVerdict::NotSupported => Verdict::NotSupported,
        }
    }
}

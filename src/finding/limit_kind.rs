//! The kind of a limit states what it asks of the value that is compared with it.

/// Relation of the limit of a code to its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// Maximum of the value.
    AtMost,
    /// Minimum of the value.
    AtLeast,
    /// The value must be smaller.
    Below,
    /// Maximum of the magnitude of the value.
    Within,
    /// Maximum of the value and of one over it.
    Factor,
    /// The right value.
    Expected,
    /// The number of all, of which the value counts a part.
    Total,
    /// The value that the user stated.
    Stated,
    /// Maximum distance from the location of the finding.
    Tolerance,
    /// The outermost frequency of the data.
    EndOfData,
    /// What the value became.
    After,
    /// Standard deviation of the value.
    StandardDeviation,
    /// The value of all other places.
    Elsewhere,
}

impl LimitKind {
    /// The limit, a number with its unit, in words.
    pub(super) fn english(self, limit: &str) -> String {
        match self {
            LimitKind::AtMost => format!("limit at most {limit}"),
            LimitKind::AtLeast => format!("limit at least {limit}"),
            LimitKind::Below => format!("limit below {limit}"),
            LimitKind::Within => format!("limit ±{limit}"),
            LimitKind::Factor => format!("limit a factor of {limit}"),
            LimitKind::Expected => format!("expected {limit}"),
            LimitKind::Total => format!("of {limit}"),
            LimitKind::Stated => format!("stated {limit}"),
            LimitKind::Tolerance => format!("tolerance ±{limit}"),
            LimitKind::EndOfData => format!("data end at {limit}"),
            LimitKind::After => format!("now {limit}"),
            LimitKind::StandardDeviation => format!("standard deviation {limit}"),
            LimitKind::Elsewhere => format!("elsewhere {limit}"),
        }
    }

    /// [`Self::english`] in Chinese.
    pub(super) fn chinese(self, limit: &str) -> String {
        match self {
            LimitKind::AtMost => format!("限值：至多 {limit}"),
            LimitKind::AtLeast => format!("限值：至少 {limit}"),
            LimitKind::Below => format!("限值：小于 {limit}"),
            LimitKind::Within => format!("限值：±{limit}"),
            LimitKind::Factor => format!("限值：相差至多 {limit} 倍"),
            LimitKind::Expected => format!("应为 {limit}"),
            LimitKind::Total => format!("共 {limit}"),
            LimitKind::Stated => format!("给定 {limit}"),
            LimitKind::Tolerance => format!("容差 ±{limit}"),
            LimitKind::EndOfData => format!("数据止于 {limit}"),
            LimitKind::After => format!("现为 {limit}"),
            LimitKind::StandardDeviation => format!("标准差 {limit}"),
            LimitKind::Elsewhere => format!("其他为 {limit}"),
        }
    }
}

//! Phrases that stand as values in translated sentences, in English and Chinese.

use super::text_table::Text;

/// Phrases that are a value, or a part of one between semicolons or commas.
pub(super) static PHRASES: &[Text] = &[
    text("the test", "试验"),
    text("{} % at {}, smallest MAC {}", "{} % ({})，最小 MAC {}"),
    text("{} % at {}", "{} % ({})"),
    text(
        "{}: smallest MAC {} (at least {})",
        "{}：最小 MAC {} (至少 {})",
    ),
    text(
        "{}: largest |frequency error| (%) {} (at most {})",
        "{}：最大频率误差 (%) {} (至多 {})",
    ),
    text("{} (at least {})", "{} (至少 {})"),
    text("{} (at most {})", "{} (至多 {})"),
    text("{} model modes", "{} 阶模型模态"),
    text(
        "{} ({} model modes in {} tests)",
        "{} ({} 个试验中 {} 阶模型模态)",
    ),
    text("{} ambiguous", "{} 个不明确"),
    text("{} not observable", "{} 个不可观测"),
    text("unmatched: {}", "未配对：{}"),
    text("test modes without partner: {}", "无配对的试验模态：{}"),
    text("{} statements and {}", "{} 条陈述与{}"),
    text("{} statements", "{} 条陈述"),
    text("ends and length of {}, {}", "{} 的两端与长度、{}"),
    text("{} parameters ({})", "{} 个参数 ({})"),
    text("{} parameter ({})", "{} 个参数 ({})"),
    text("{} further tests (--full)", "另有 {} 个试验 (--full)"),
    text("{} more", "另有 {} 个"),
    text("no point to hit again", "没有需要重新锤击的点"),
    text("hit again {}", "需重新锤击 {}"),
    text("not tested: {}", "未检验：{}"),
    text("beyond the limit: {}", "超出限值：{}"),
    text("nothing to repeat", "没有需要重复的"),
    text("{}: {} good hits of {}", "{}：合格锤击 {} / {}"),
    text("{}: {} good hit of {}", "{}：合格锤击 {} / {}"),
    text(
        "a further [[parameter]], such as a mass at a sensor or the stiffness of a support",
        "增加 [[parameter]]，如测点处的质量或支承刚度",
    ),
    text(
        "single changes of it (explain = true in [update])",
        "单项修改见 [update] 中 explain = true",
    ),
    text("the single changes: --full", "单项修改见 --full"),
];

/// The phrases whose values are words.
pub(super) const OF_WORDS: [&str; 2] = ["not tested: {}", "beyond the limit: {}"];

/// Words in such phrases; elsewhere they may be names.
pub(super) static WORDS: &[Text] = &[
    text("linearity", "线性"),
    text("reciprocity", "互易性"),
    text("driving points", "原点"),
    text("drift", "漂移"),
    text("mass line", "质量线"),
    text("support", "支承"),
];

const fn text(english: &'static str, chinese: &'static str) -> Text {
    Text { english, chinese }
}

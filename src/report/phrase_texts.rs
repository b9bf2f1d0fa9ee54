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
    text(
        "smallest MAC of {}, {} (at least {})",
        "{} 的最小 MAC，{} (至少 {})",
    ),
    text(
        "largest |frequency error| (%) of {}, {} (at most {})",
        "{} 的最大频率误差 (%)，{} (至多 {})",
    ),
    text("unmatched test modes", "无配对的试验模态"),
    text("missed modes", "漏检的模态"),
    text("ambiguous pairs", "不明确的配对"),
    text("not observable modes", "不可观测的模态"),
    text("paired modes", "已配对的模态"),
    text("smallest MAC", "最小 MAC"),
    text("largest |frequency error|", "最大频率误差"),
    text("{} with changes (--full)", "{} (有改动，见 --full)"),
    text("excitation point {} and sensor {}", "激励点 {} 与测点 {}"),
    text("excitation point {}", "激励点 {}"),
    text("test {}, model {}", "试验 {}，模型 {}"),
    text("by shape", "按振型"),
    text("by frequency", "按频率"),
    text("worst mode", "最大误差阶次"),
    text("not observable", "不可观测"),
    text("damping (%)", "阻尼比 (%)"),
    text("std (Hz)", "标准差 (Hz)"),
    text("std (%)", "标准差 (%)"),
    text("change (%)", "变化 (%)"),
    text("unit", "单位"),
    text("remark", "备注"),
    text("all {} points", "全部 {} 个点"),
    text("the 1 point", "该点"),
    text("{} iterations", "{} 次迭代"),
    text("{} iteration", "{} 次迭代"),
    text("{} starts", "{} 个起点"),
    text("{} start", "{} 个起点"),
    text("{} pairs", "{} 对"),
    text("{} pair", "{} 对"),
    text("{} doubtful test modes", "{} 个存疑的试验模态"),
    text("{} doubtful test mode", "{} 个存疑的试验模态"),
    text("{} test modes without partner", "{} 个无配对的试验模态"),
    text("{} test mode without partner", "{} 个无配对的试验模态"),
    text("doubtful modes count there", "其中存疑的模态计入"),
    text(
        "ambiguous pairs do not count there",
        "其中不明确的配对不计入",
    ),
    text(
        "modes outside band_hz of [update] count there",
        "其中 [update] 的 band_hz 之外的模态计入",
    ),
    text("repeated roots count once there", "其中重根计一次"),
    text("another, of", "另一最优点，为"),
    text("{} others, the lowest of", "其他 {} 个最优点，最低为"),
    text("of frequencies {} (noise: {})", "频率 {} (仅噪声 {})"),
    text("of shapes {} (noise: {})", "振型 {} (仅噪声 {})"),
    text(
        "of frequencies {} times the stated ones (from {} degrees of freedom)",
        "频率的标准差为规定值的 {} 倍 (由 {} 个自由度估计)",
    ),
    text(
        "of shapes {} times the stated ones (from {} degrees of freedom)",
        "振型的标准差为规定值的 {} 倍 (由 {} 个自由度估计)",
    ),
    text(
        "of all residuals {} times the stated ones (from {} degrees of freedom)",
        "全部残差的标准差为规定值的 {} 倍 (由 {} 个自由度估计)",
    ),
    text("{} of {} because of their std", "{} / {} 个因标准差过大"),
    text(
        "{} of {} because of {} modes not predicted from the others (--explain mode-not-predicted)",
        "{} / {} 个因 {} 阶模态不能由其他模态预测 (--explain mode-not-predicted)",
    ),
    text(
        "{} of {} because of {} mode not predicted from the others (--explain mode-not-predicted)",
        "{} / {} 个因 {} 阶模态不能由其他模态预测 (--explain mode-not-predicted)",
    ),
    text(
        "{} of {} because {} modes lost the partner",
        "{} / {} 个因 {} 阶模态失去配对",
    ),
    text(
        "{} of {} because {} mode lost the partner",
        "{} / {} 个因 {} 阶模态失去配对",
    ),
    text(
        "{} of {} because the configurations disagree",
        "{} / {} 个因各构型不一致",
    ),
    text(
        "{} of {} because 1 of {} starts reaches the lowest optimum (more starts in [update])",
        "{} / {} 个因 {} 个起点中仅 1 个到达最低的最优点 (在 [update] 中增加 starts)",
    ),
    text(
        "{} of {} because the model error has fewer than 3 degrees of freedom",
        "{} / {} 个因模型误差的自由度少于 3",
    ),
    text("the response of functions or records", "函数或记录的响应"),
    text("the reference of FRFs", "频响函数的参考点"),
    text("units", "单位"),
    text("the sampling rate", "采样率"),
    text("{} (at least {})", "{} (至少 {})"),
    text("{} (at most {})", "{} (至多 {})"),
    text("{} model modes", "{} 阶模型模态"),
    text(
        "{} ({} model modes in {} tests)",
        "{} ({} 阶模型模态，{} 个试验)",
    ),
    text("{} ambiguous", "{} 个不明确"),
    text("{} not observable", "{} 个不可观测"),
    text("unmatched: {}", "未配对：{}"),
    text("test modes without partner: {}", "无配对的试验模态：{}"),
    text("{} statements and {}", "{} 条陈述与 {}"),
    text("{} statements", "{} 条陈述"),
    text("ends and length of {}, {}", "{} 的两端与长度、{}"),
    text("{} parameters ({})", "{} 个参数 ({})"),
    text("{} parameter ({})", "{} 个参数 ({})"),
    text("{} further tests (--full)", "另有 {} 个试验 (--full)"),
    text("{} more", "另有 {} 个"),
    text("enough good hits at every point", "各点的合格锤击数足够"),
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
pub(super) const OF_WORDS: [&str; 3] = [
    "not tested: {}",
    "beyond the limit: {}",
    "test {}, model {}",
];

/// Words in such phrases; elsewhere they may be names.
pub(super) static WORDS: &[Text] = &[
    text("linearity", "线性"),
    text("reciprocity", "互易性"),
    text("driving points", "原点"),
    text("drift", "漂移"),
    text("mass line", "质量线"),
    text("support", "支承"),
    text("suspended", "悬挂"),
    text("fixed", "固定"),
    text("mounted", "安装"),
];

const fn text(english: &'static str, chinese: &'static str) -> Text {
    Text { english, chinese }
}

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
    text("{} reach another, of {}", "{} 个到达另一最优点，为 {}"),
    text(
        "{} reach {} others, the lowest of {}",
        "{} 个到达其他 {} 个最优点，最低为 {}",
    ),
    text(
        "from {} the model had no modes or no derivatives",
        "自 {} 个起点模型无模态或无导数",
    ),
    text("no change", "不改变"),
    text(
        "no change besides the parameters that are always free",
        "除始终自由的参数外不改变",
    ),
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
    text("not observable at the points: {}", "在各测点不可观测：{}"),
    text(
        "unmatched, observability unknown: {}",
        "未配对，可观测性未知：{}",
    ),
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
    text("{} responses", "{} 个响应"),
    text("{} response", "{} 个响应"),
    text("{} excitation points", "{} 个激励点"),
    text("{} excitation point", "{} 个激励点"),
    text("{} averages", "{} 次平均"),
    text("{} average", "{} 次平均"),
    text("{} lines", "{} 条谱线"),
    text("{} line", "{} 条谱线"),
    text("{} hits", "{} 次锤击"),
    text("{} hit", "{} 次锤击"),
    text("{} FRFs", "{} 个频响函数"),
    text("{} FRF", "{} 个频响函数"),
    text("{} rows", "{} 行"),
    text("{} row", "{} 行"),
    text("{} checks", "{} 项检查"),
    text("{} check", "{} 项检查"),
    text("{} sensors", "{} 个传感器"),
    text("{} sensor", "{} 个传感器"),
    text("{} points", "{} 点"),
    text("{} point", "{} 点"),
    text("{} nodes", "{} 个节点"),
    text("{} node", "{} 个节点"),
    text("{} trace lines", "{} 条连线"),
    text("{} trace line", "{} 条连线"),
    text("{} elements", "{} 个单元"),
    text("{} element", "{} 个单元"),
    text("{} coordinate systems", "{} 个坐标系"),
    text("{} coordinate system", "{} 个坐标系"),
    text("{} groups", "{} 个组"),
    text("{} group", "{} 个组"),
    text("{} modes", "{} 阶模态"),
    text("{} mode", "{} 阶模态"),
    text("{} arrays", "{} 个数组"),
    text("{} array", "{} 个数组"),
    text("{} damaged parts", "{} 处损坏"),
    text("{} damaged part", "{} 处损坏"),
    text("{} to {} averages", "{} 至 {} 次平均"),
    text("free motion", "自由运动"),
    text("time: {}", "时间记录：{}"),
    text("FRF: {}", "频响函数：{}"),
    text("coherence: {}", "相干：{}"),
    text("multiple coherence: {}", "多重相干：{}"),
    text("variance: {}", "方差：{}"),
    text("{} good hits of {}", "合格锤击 {} / {}"),
    text("{} good hit of {}", "合格锤击 {} / {}"),
    text("rejected by the user in hit {}", "第 {} 次锤击由用户剔除"),
    text("best hits {}", "最好的锤击 {}"),
    text(
        "std of the FRF at {} Hz {} %",
        "频响函数在 {} Hz 处的标准差 {} %",
    ),
    text("with {} more {} %", "再加 {} 次则 {} %"),
    text(
        "hammer force in hit {} {} dB against the others (limit at least {} dB)",
        "第 {} 次锤击的力与其他相差 {} dB (限值：至少 {} dB)",
    ),
    text(
        "coherence {} at {} Hz (limit at least {})",
        "相干 {}，位于 {} Hz (限值：至少 {})",
    ),
    text(
        "coherence of {} {} at {} Hz (limit at least {})",
        "{} 的相干 {}，位于 {} Hz (限值：至少 {})",
    ),
    text(
        "overload of {} in hit {}: {} samples clipped (limit below {})",
        "{} 过载 (第 {} 次锤击)：削波 {} 个样本 (限值：少于 {})",
    ),
    text(
        "overload in hit {}: {} samples clipped (limit below {})",
        "过载 (第 {} 次锤击)：削波 {} 个样本 (限值：少于 {})",
    ),
    text(
        "response of {} not decayed in hit {}: {} % at the end (limit at most {} %)",
        "{} 的响应未衰减 (第 {} 次锤击)：末端 {} % (限值：至多 {} %)",
    ),
    text(
        "double hit in hit {}: {} (limit {})",
        "双击 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "double hit of {} in hit {}: {} (limit {})",
        "{} 的双击 (第 {} 次锤击)：{} (限值 {})",
    ),
    text("double hit in hit {}", "双击 (第 {} 次锤击)"),
    text(
        "peak force over the median in hit {}: {} (limit {})",
        "峰值力与中位数之比 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "peak force over the median of {} in hit {}: {} (limit {})",
        "{} 的峰值力与中位数之比 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "peak force over the median in hit {}",
        "峰值力与中位数之比 (第 {} 次锤击)",
    ),
    text(
        "vibration before the hit in hit {}: {} (limit {})",
        "锤击前的振动 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "vibration before the hit of {} in hit {}: {} (limit {})",
        "{} 的锤击前的振动 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "vibration before the hit in hit {}",
        "锤击前的振动 (第 {} 次锤击)",
    ),
    text(
        "no signal in hit {}: {} (limit {})",
        "无信号 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "no signal of {} in hit {}: {} (limit {})",
        "{} 的无信号 (第 {} 次锤击)：{} (限值 {})",
    ),
    text("no signal in hit {}", "无信号 (第 {} 次锤击)"),
    text(
        "FRF unlike the other hits in hit {}: {} (limit {})",
        "频响函数与其他锤击不一致 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "FRF unlike the other hits of {} in hit {}: {} (limit {})",
        "{} 的频响函数与其他锤击不一致 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "FRF unlike the other hits in hit {}",
        "频响函数与其他锤击不一致 (第 {} 次锤击)",
    ),
    text(
        "roll-off of the force in hit {}: {} (limit {})",
        "力谱滚降 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "roll-off of the force of {} in hit {}: {} (limit {})",
        "{} 的力谱滚降 (第 {} 次锤击)：{} (限值 {})",
    ),
    text("roll-off of the force in hit {}", "力谱滚降 (第 {} 次锤击)"),
    text(
        "negative force in hit {}: {} (limit {})",
        "力为负 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "negative force of {} in hit {}: {} (limit {})",
        "{} 的力为负 (第 {} 次锤击)：{} (限值 {})",
    ),
    text("negative force in hit {}", "力为负 (第 {} 次锤击)"),
    text(
        "offset or drift in hit {}: {} (limit {})",
        "偏置或漂移 (第 {} 次锤击)：{} (限值 {})",
    ),
    text(
        "offset or drift of {} in hit {}: {} (limit {})",
        "{} 的偏置或漂移 (第 {} 次锤击)：{} (限值 {})",
    ),
    text("offset or drift in hit {}", "偏置或漂移 (第 {} 次锤击)"),
    text(
        "[x, y, z] in metres, without quotes",
        "[x, y, z]，单位米，不加引号",
    ),
    text(
        "samples per second, a number without quotes",
        "每秒采样数，不加引号的数",
    ),
    text(
        "with `scale` where a calibration is missing",
        "缺少标定时加 `scale`",
    ),
    text(
        "the hit point with its direction, such as 1:+Z",
        "锤击点及其方向，如 1:+Z",
    ),
    text(
        "the sensor with its direction, such as 1:+Z",
        "传感器及其方向，如 1:+Z",
    ),
    text("{} and {} more", "{} 等另 {} 个"),
    text("smallest MAC {} (at least {})", "最小 MAC {} (至少 {})"),
    text(
        "largest |frequency error| (%) {} (at most {})",
        "最大频率误差 (%) {} (至多 {})",
    ),
    text(
        "{}: frequency change (%) {} (at most {})",
        "{}：频率变化 (%) {} (至多 {})",
    ),
    text(
        "{}: damping change (%) {} (at most {})",
        "{}：阻尼比变化 (%) {} (至多 {})",
    ),
    text(
        "{}: frequency std change (factor) {} (at most {})",
        "{}：频率标准差之比 {} (至多 {})",
    ),
    text(
        "{}: hz_std change (factor) {} (at most {})",
        "{}：频率标准差之比 {} (至多 {})",
    ),
    text(
        "{}: damping std change (factor) {} (at most {})",
        "{}：阻尼比标准差之比 {} (至多 {})",
    ),
    text(
        "{}: frequency change of the test (%) {} (at most {})",
        "{}：试验频率变化 (%) {} (至多 {})",
    ),
    text(
        "{}: frequency change of the model (%) {} (at most {})",
        "{}：模型频率变化 (%) {} (至多 {})",
    ),
    text(
        "{}: value change (%) {} (at most {})",
        "{}：数值变化 (%) {} (至多 {})",
    ),
    text(
        "{}: std change (factor) {} (at most {})",
        "{}：标准差之比 {} (至多 {})",
    ),
    text(
        "{}: reduced chi-square change (factor) {} (at most {})",
        "{}：每自由度卡方之比 {} (至多 {})",
    ),
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

/// Kinds of records and functions, and quantities.
pub(super) static KINDS: &[Text] = &[
    text("time", "时间记录"),
    text("FRF", "频响函数"),
    text("coherence", "相干"),
    text("multiple coherence", "多重相干"),
    text("variance", "方差"),
    text("auto spectrum", "自谱"),
    text("cross spectrum", "互谱"),
    text("force", "力"),
    text("acceleration", "加速度"),
    text("velocity", "速度"),
    text("displacement", "位移"),
];

const fn text(english: &'static str, chinese: &'static str) -> Text {
    Text { english, chinese }
}

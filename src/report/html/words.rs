//! Translations of the words of the page; [`super::super::Language`] translates those of tables.

use serde_json::{Map, Value};

use super::super::Language;
use super::script_words::SCRIPT_WORDS;

/// A text in a language; the text itself where it has no translation.
pub(super) fn word(language: Language, text: &'static str) -> &'static str {
    match language {
        Language::English => text,
        Language::Chinese => {
            let found = WORDS
                .iter()
                .chain(SCRIPT_WORDS)
                .find(|(english, _)| *english == text);
            found.map_or(text, |(_, translated)| translated)
        }
    }
}

/// A sentence with `{}` filled by values, in order.
pub(super) fn sentence(language: Language, text: &'static str, values: &[String]) -> String {
    let mut filled = String::new();
    let mut values = values.iter();
    for (index, part) in word(language, text).split("{}").enumerate() {
        if index > 0 {
            filled += values.next().map_or("", String::as_str);
        }
        filled += part;
    }
    filled
}

/// Translations that the script needs, by the English words; empty for an English page.
pub(super) fn page_words(language: Language) -> Value {
    match language {
        Language::English => Value::Object(Map::new()),
        Language::Chinese => {
            let pairs = SCRIPT_WORDS.iter();
            pairs
                .map(|(from, to)| ((*from).to_owned(), Value::from(*to)))
                .collect()
        }
    }
}

/// Tabs, summary, findings and provenance.
const WORDS: &[(&str, &str)] = &[
    ("identified", "可识别"),
    ("at bound", "位于边界"),
    ("not supported by the data", "数据不支持"),
    ("Skip to content", "跳到正文"),
    ("Light or dark", "浅色或深色"),
    ("Notes", "说明"),
    ("Made by {}", "由 {} 生成"),
    (
        "Figures need a script; tables do not.",
        "图形需要脚本；表格不需要。",
    ),
    ("Summary", "摘要"),
    ("Comparison", "对比"),
    ("Mode shapes", "振型"),
    ("MAC", "MAC"),
    ("FRFs", "频响函数"),
    ("Stabilization diagram", "稳定图"),
    ("Circle fits", "圆拟合"),
    ("Modes", "模态"),
    ("Energies", "能量"),
    ("Update", "模型修正"),
    ("Published results", "文献结果"),
    ("Hits", "锤击"),
    ("Findings", "提示"),
    ("Provenance", "来源"),
    (
        "{} of {} modes of the model in the band have a partner",
        "频带内 {} / {} 阶模型模态已配对",
    ),
    ("rms frequency error", "频率误差均方根"),
    ("largest", "最大"),
    ("smallest MAC", "最小 MAC"),
    ("unmatched (model)", "漏检"),
    ("not observable", "不可观测"),
    ("unmatched (test)", "多余"),
    ("ambiguous", "不明确"),
    ("Unmatched modes", "漏检的模态"),
    ("No unmatched modes in the band.", "频带内无漏检。"),
    ("Recommended changes", "建议的修改"),
    ("Update result", "修正的结果"),
    ("synthetic", "合成"),
    (
        "{}: model mode {} at {} Hz is unmatched, not excited or not sensed: {}",
        "{}：模型第 {} 阶({} Hz)无配对，符合预期：{}",
    ),
    (
        "{}: model mode {} at {} Hz is unmatched, observability unknown: {}",
        "{}：模型第 {} 阶({} Hz)无配对；试验能否观测到它未知：{}",
    ),
    (
        "{}: model mode {} at {} Hz is unmatched, but the test should observe it: {}",
        "{}：模型第 {} 阶({} Hz)无配对，而试验本应观测到它：{}",
    ),
    (
        "{}: test mode at {} Hz is unmatched",
        "{}：试验模态({} Hz)在模型中无配对",
    ),
    (
        "model modes that these sensors and excitation points cannot observe: {}",
        "用这些测点和锤击点无法观测的模型模态：{} 阶",
    ),
    (
        "All paired frequencies of the test lie below the model's: the model is too stiff or too light. One factor {} on all stiffnesses would bring the mean to the test.",
        "试验的配对频率均低于模型：模型过刚或过轻。若所有刚度乘以 {}，平均频率与试验一致。",
    ),
    (
        "All paired frequencies of the test lie above the model's: the model is too soft or too heavy. One factor {} on all stiffnesses would bring the mean to the test.",
        "试验的配对频率均高于模型：模型过软或过重。若所有刚度乘以 {}，平均频率与试验一致。",
    ),
    (
        "The frequency errors have no common sign, so no single stiffness factor explains them; the largest is {} at {}.",
        "误差没有明显偏向一侧，单一系数无法解释；最大为 {}({})。",
    ),
    (
        "`modalign update` estimates the parameters that the test can identify.",
        "`modalign update` 可给出试验能识别的参数。",
    ),
    ("{}: {} → {} ± {} {}", "{}：{} → {} ± {} {}"),
    ("Limit missed: {}", "超出限值：{}"),
    ("All {} stated limits are met.", "{} 项限值全部满足。"),
    (
        "Warnings among the findings: {}.",
        "“提示”中的警告：{} 条。",
    ),
    ("Test only, no model.", "本次运行没有试验与模型的对比。"),
    ("Error of each mode", "各阶误差"),
    ("No findings.", "没有需要说明的事项。"),
    ("whole run", "整体"),
    ("severity", "级别"),
    ("finding", "内容"),
    ("code", "代码"),
    ("meaning", "含义"),
    ("error", "错误"),
    ("warning", "警告"),
    ("info", "信息"),
    ("more of this code", "条同类提示"),
    ("Program", "程序"),
    ("Model", "模型"),
    ("Seed of {}", "{} 的随机种子"),
    ("Files that state the run", "运行设置文件"),
    ("Data", "数据"),
    ("Identification", "识别"),
    ("test", "试验"),
    ("file", "文件"),
    ("method", "方法"),
    ("band (Hz)", "频带 (Hz)"),
    ("Parameters of the model, updated", "修正后的模型参数"),
    ("parameter", "参数"),
    ("unit", "单位"),
    ("before", "修正前"),
    ("after", "修正后"),
    ("std", "标准差"),
    ("change (%)", "变化 (%)"),
    ("verdict", "结论"),
    ("Frequencies before and after", "修正前后的频率"),
    ("mode", "阶次"),
    ("test (Hz)", "试验 (Hz)"),
    ("model (Hz)", "模型 (Hz)"),
    ("error before (%)", "修正前误差 (%)"),
    ("error after (%)", "修正后误差 (%)"),
    (
        "The update explains the test: χ²/ν = {}, and noise alone reaches {}.",
        "修正能解释试验：χ²/ν = {}，仅噪声可达 {}。",
    ),
    (
        "The update does not explain the test: χ²/ν = {}, and noise alone reaches {}.",
        "修正不能解释试验：χ²/ν = {}，仅噪声可达 {}。",
    ),
    (" {}.", "{}。"),
    (
        " Rms frequency error {} % before, {} % after.",
        "频率误差均方根：修正前 {} %，修正后 {} %。",
    ),
    (
        "{} further parameters with smaller changes in standard deviations: tab Update.",
        "另有 {} 个参数的变化(以标准差计)较小：见“模型修正”页。",
    ),
    (
        " {} of {} starts ended at this optimum.",
        "{} / {} 个起点到达此最优点。",
    ),
    (
        "Converged: no step lowers the objective",
        "已收敛：没有步能降低目标函数",
    ),
    (
        "Converged: the steps have become as small as rounding",
        "已收敛：步长已小到舍入误差",
    ),
    (
        "Nothing changed: the test sees none of the free parameters",
        "未改变：试验看不到任何自由参数",
    ),
    (
        "Not converged: the stated number of iterations is reached",
        "未收敛：已达到规定的迭代次数",
    ),
    (
        "Identifiability: parameter combinations, best determined first",
        "可辨识性：参数组合，最确定的在前",
    ),
    ("combination", "组合"),
    ("One parameter changed at a time", "每次改变一个参数"),
    ("rms error (%)", "误差均方根 (%)"),
    ("largest error (%)", "最大误差 (%)"),
    ("no change", "不变"),
    (
        "Proposed: {}, the smallest set that brings the residual to its uncertainty.",
        "建议：{}，使残差降到其不确定度的最小集合。",
    ),
    (
        "No set brings the residual to its uncertainty; {} has the smallest BIC.",
        "没有集合能使残差降到其不确定度；{} 的 BIC 最小。",
    ),
    (
        "This shows the model before the update.",
        "此处为修正前的模型。",
    ),
    (
        "Comparison, MAC and mode shapes show the model before this update.",
        "对比、MAC 与振型显示的是修正前的模型。",
    ),
    (
        "The update in this folder is of other test frequencies or of another model than this run, and is left out; run `modalign update` again.",
        "此文件夹中的修正来自其他试验频率或其他模型，未列出；请重新运行 `modalign update`。",
    ),
    ("Methods", "方法"),
    ("Speed against accuracy", "速度与精度"),
    ("Where methods fail", "方法的失效边界"),
    (
        "Required and unnecessary elements of this scene",
        "本场景需要什么，不需要什么",
    ),
    (
        "The study in order.json is of another scene or of other data than this run, and is left out; run `modalign study order` again.",
        "order.json 中的研究来自其他场景或其他数据，未列出；请重新运行 `modalign study order`。",
    ),
    (
        "Each map is computed from random synthetic structures. Inside its contour a method finds their modes to the stated error in 95 % of the draws; outside, it does not. Points are the modes of this run.",
        "反复抽取小型结构。在等值线之内，方法在 95 % 的抽样中以规定误差找到其模态；在其外则不能。点为本次运行的模态。",
    ),
    (
        "The study in speed-accuracy.json is of another scene or of other data than this run, and is left out; run `modalign study speed-accuracy` again.",
        "speed-accuracy.json 中的研究来自其他场景或其他数据，未列出；请重新运行 `modalign study speed-accuracy`。",
    ),
    (
        "The study in breakdown.json shows the modes of another scene, or other modes than this run, and is left out; run `modalign study breakdown` again: finished slices are kept.",
        "breakdown.json 中的模态来自其他场景或与本次运行不同，未列出；请重新运行 `modalign study breakdown`：已完成的切片会保留。",
    ),
    // Factors of maps, their axes and units.
    ("noise", "噪声"),
    ("separation", "间距"),
    ("record_length", "记录长度"),
    ("hits", "锤击"),
    ("references", "参考点"),
    ("node_distance", "与节点的距离"),
    ("mass_loading", "附加质量"),
    ("second_contacts", "二次接触"),
    ("quantisation", "量化"),
    ("force_noise", "力的噪声"),
    ("exponential_window", "指数窗"),
    ("decades", "个数量级"),
    ("half-power widths", "半功率带宽"),
    ("time constants", "时间常数"),
    ("bits", "位"),
    ("orders", "阶"),
    (
        "Signal-to-noise ratio of the responses (dB)",
        "响应的信噪比 (dB)",
    ),
    (
        "Signal-to-noise ratio of the FRFs (dB)",
        "频响函数的信噪比 (dB)",
    ),
    (
        "Separation of the pair (half-power widths)",
        "两阶的间距 (半功率带宽)",
    ),
    ("Damping ratio (-)", "阻尼比 (-)"),
    ("Record length (time constants)", "记录长度 (时间常数)"),
    ("Hits averaged", "平均的锤击次数"),
    ("References (hit points)", "参考点 (锤击点)"),
    (
        "Distance of the hit from a node (share of the largest component)",
        "锤击点与节点的距离 (占最大分量的比例)",
    ),
    (
        "Drift over roving positions (half-power widths)",
        "移动测点间的频率漂移 (半功率带宽)",
    ),
    (
        "Share of hits with a second contact",
        "有二次接触的锤击比例",
    ),
    ("Converter (bits)", "转换器 (位)"),
    ("Signal-to-noise ratio of the force (dB)", "力的信噪比 (dB)"),
    (
        "Exponential window at the record's end (1: none)",
        "记录末端的指数窗 (1：无)",
    ),
    ("Highest model order", "最高模型阶数"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_one_translation_with_its_values() {
        for words in [WORDS, SCRIPT_WORDS] {
            for (index, (from, to)) in words.iter().enumerate() {
                let count = |text: &str| text.matches("{}").count();
                assert_eq!(count(from), count(to), "{from}");
                assert!(
                    words[..index].iter().all(|(other, _)| other != from),
                    "{from}"
                );
            }
        }
    }

    #[test]
    fn every_word_of_the_script_is_translated() {
        let script = super::super::page::SCRIPT.concat();
        let mut used = Vec::new();
        for part in script.split("T('").skip(1) {
            used.push(part.split("')").next().unwrap());
        }
        assert!(used.len() > 40, "{}", used.len());
        for text in used {
            assert!(
                SCRIPT_WORDS.iter().any(|(english, _)| *english == text),
                "{text}"
            );
        }
        for (english, _) in SCRIPT_WORDS {
            assert!(
                script.contains(&format!("'{english}'")),
                "{english} is not used"
            );
        }
    }

    #[test]
    fn sentences_are_filled_with_values_in_order() {
        let text = sentence(
            Language::English,
            "{}: {} → {} ± {} {}",
            &["k", "1", "2", "0.1", "N/m"].map(str::to_owned),
        );
        assert_eq!(text, "k: 1 → 2 ± 0.1 N/m");
        assert_eq!(word(Language::Chinese, "Modes"), "模态");
    }
}

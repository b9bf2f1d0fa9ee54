//! Chinese texts of findings: sentence and explanation of each code in `zh.toml`, places and
//! numbers here.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::{Code, Finding, LimitKind, Location, Severity, format_hz};

/// Chinese texts of a code.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Texts {
    sentence: String,
    explanation: String,
}

static TEXTS: LazyLock<BTreeMap<Code, Texts>> = LazyLock::new(|| {
    toml::from_str(include_str!("zh.toml")).expect("`zh.toml` has the texts of codes")
});

/// Details of findings with `{}` for names and numbers, and their Chinese texts; the first that
/// fits.
const DETAILS: [(&str, &str); 49] = [
    ("resonance at {} Hz", "{} Hz 处的共振"),
    (
        "run of excitation point {}, of {} runs",
        "激励点 {} 的测量批次，共 {} 批",
    ),
    (
        "run of sensor {}, of {} runs",
        "传感器 {} 的测量批次，共 {} 批",
    ),
    (
        "another test mode fits the same model mode",
        "另一试验模态也符合同一模型模态",
    ),
    (
        "another model mode fits the same test mode",
        "另一模型模态也符合同一试验模态",
    ),
    ("test {}, model {}", "试验 {}，模型 {}"),
    ("stated {}, by the matrices {}", "说明为 {}，按矩阵为 {}"),
    (
        "the model does not tell the effect on its frequencies",
        "模型未给出对其频率的影响",
    ),
    (
        "without stiffness to ground {} Hz becomes {} Hz",
        "去掉对地刚度后 {} Hz 变为 {} Hz",
    ),
    ("modes without a counterpart: {}", "无对应的模态：{}"),
    (
        "raises the mode at {} Hz by about {} %",
        "使 {} Hz 的模态升高约 {} %",
    ),
    ("body {} is held there", "物体 {} 在该处固定"),
    ("body {}: at_m = {}", "物体 {}：at_m = {}"),
    ("points {}: at_m = {}", "测点 {}：at_m = {}"),
    ("rejected stable poles: {}", "剔除的稳定极点：{}"),
    ("also {}", "另有 {}"),
    ("blocks of {} samples", "每块 {} 个样本"),
    (
        "the responses to the burst have not decayed when the record ends",
        "记录结束时对猝发激励的响应尚未衰减",
    ),
    (
        "from the weakest to the strongest hit ({} dB): frequency {} %, damping {} %",
        "从最弱到最强的锤击（{} dB）：频率 {} %，阻尼 {} %",
    ),
    (
        "from the weakest to the strongest hit ({} dB): frequency {} %",
        "从最弱到最强的锤击（{} dB）：频率 {} %",
    ),
    ("{} hits", "{} 次锤击"),
    (
        "force and order of the hits go together",
        "力与锤击次序相关",
    ),
    (
        "{} lines by {} Hz from {} Hz, those used {} lines by {} Hz from {} Hz",
        "{} 条谱线，间隔 {} Hz，从 {} Hz 起；所用的为 {} 条，间隔 {} Hz，从 {} Hz 起",
    ),
    (
        "added damping {} rad/s, those used {} rad/s",
        "附加阻尼 {} rad/s，所用的为 {} rad/s",
    ),
    ("the built-in model was used", "采用了内置模型"),
    ("{} names the file", "{} 指该文件"),
    ("{} sensors, from {} to {} Hz", "{} 个传感器，{} 至 {} Hz"),
    ("{} sensor, from {} to {} Hz", "{} 个传感器，{} 至 {} Hz"),
    (
        "standard deviation {} kg, centre of mass at ({}) m, from {} to {} Hz",
        "标准差 {} kg，质心位于 ({}) m，{} 至 {} Hz",
    ),
    ("mass line {} ± {} kg", "质量线 {} ± {} kg"),
    (
        "mass_kg of [test.state] {} kg",
        "[test.state] 的 mass_kg 为 {} kg",
    ),
    (
        "if the stated mass is right, the FRFs are {} ± {} times what they should be",
        "若所述质量正确，频响函数为应有值的 {} ± {} 倍",
    ),
    ("it fits with the other sign", "反号后相符"),
    (
        "it reads {} ± {} times what it should",
        "读数为应有值的 {} ± {} 倍",
    ),
    (
        "value and limit: fall of the sum of squares",
        "数值与限值：平方和的下降",
    ),
    (
        "check whether their cables or names are exchanged",
        "请检查电缆或名称是否互换",
    ),
    (
        "residual {} % of the FRF, std × {}",
        "残差为频响函数的 {} %，标准差 × {}",
    ),
    ("{} of {} FRFs", "{} / {} 个频响函数"),
    (
        "of {} in common several move alike in every mode of the model and count once",
        "共有的 {} 个自由度中，有些在模型各模态中运动相同，只计一次",
    ),
    ("{} at node {}", "{} 对应节点 {}"),
    ("{} of {} sensors", "{} / {} 个传感器"),
    ("the others are {} m to {} m off", "其余相距 {} m 至 {} m"),
    (
        "{} Hz as {} Hz of the model (MAC {})",
        "{} Hz 与模型的 {} Hz 振型相同（MAC {}）",
    ),
    ("1 of {} lines, at {} Hz", "{} 条谱线中的 1 条，在 {} Hz"),
    (
        "{} of {} lines, from {} to {} Hz",
        "{} / {} 条谱线，{} 至 {} Hz",
    ),
    (
        "{}: {} Hz in {}, {} Hz in {}",
        "{}：{} Hz（{}），{} Hz（{}）",
    ),
    ("{} modes more", "另有 {} 个模态"),
    ("{} mode more", "另有 {} 个模态"),
    ("no ratio of units of length", "不是长度单位之比"),
];

/// Words that are the value of such a `{}`.
const WORDS: [(&str, &str); 3] = [
    ("suspended", "悬挂"),
    ("fixed", "固定"),
    ("mounted", "安装"),
];

/// A detail in Chinese, part by part; parts without a text remain English.
fn chinese_detail(detail: &str) -> String {
    let part = |text: &str| {
        let mut texts = DETAILS.iter();
        let found =
            texts.find_map(|(english, chinese)| Some((chinese, pattern_values(english, text)?)));
        found.map_or_else(
            || text.to_owned(),
            |(chinese, values)| {
                let fill = |text: String, value: &&str| {
                    let word = WORDS.iter().find(|(english, _)| english == value);
                    text.replacen("{}", word.map_or(value, |(_, chinese)| chinese), 1)
                };
                values.iter().fold((*chinese).to_owned(), fill)
            },
        )
    };
    let parts: Vec<String> = detail.split("; ").map(part).collect();
    parts.join("；")
}

/// The texts at the `{}` of a pattern; `None` if the text does not match.
pub(crate) fn pattern_values<'t>(pattern: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut parts = pattern.split("{}");
    let mut remaining = text.strip_prefix(parts.next()?)?;
    let parts: Vec<&str> = parts.collect();
    let mut found = Vec::new();
    for (n, part) in parts.iter().enumerate() {
        let end = if n + 1 == parts.len() {
            remaining
                .len()
                .checked_sub(part.len())
                .filter(|&at| remaining.is_char_boundary(at))?
        } else {
            remaining.find(part)?
        };
        found.push(&remaining[..end]);
        remaining = remaining[end..].strip_prefix(part)?;
    }
    remaining.is_empty().then_some(found)
}

impl Code {
    /// [`Code::sentence`] in Chinese.
    pub fn chinese_sentence(self) -> &'static str {
        &TEXTS[&self].sentence
    }

    /// [`Code::explanation`] in Chinese.
    pub fn chinese_explanation(self) -> &'static str {
        &TEXTS[&self].explanation
    }
}

impl Severity {
    /// The severity in Chinese.
    pub fn chinese(self) -> &'static str {
        match self {
            Severity::Info => "信息",
            Severity::Warning => "警告",
            Severity::Error => "错误",
        }
    }
}

impl Finding {
    /// The sentence in Chinese; [`ToString`] gives the English one.
    pub fn chinese(&self) -> String {
        let in_words = |kind: Option<LimitKind>, limit: &str| match kind {
            Some(kind) => kind.chinese(limit),
            None => format!("限值 {limit}"),
        };
        let numbers = self.numbers(in_words, "，");
        let numbers = numbers.map_or_else(String::new, |numbers| format!("（{numbers}）"));
        let detail = self.detail.as_deref();
        let detail = detail.map_or_else(String::new, |detail| {
            format!("；{}", chinese_detail(detail))
        });
        format!(
            "{}：{}{numbers}{detail}",
            location_text(&self.location),
            self.code.chinese_sentence()
        )
    }
}

fn location_text(location: &Location) -> String {
    match location {
        Location::Whole => "整个试验".to_owned(),
        Location::File { .. } => location.to_string().replace(" at byte ", " 字节 "),
        Location::Hit(n) => format!("第 {n} 次锤击"),
        Location::HitChannel { hit, dof } => format!("第 {hit} 次锤击 {dof}"),
        Location::Function {
            reference: Some(_), ..
        } => location.to_string(),
        Location::Function { response, .. } => {
            let name = response
                .as_ref()
                .map_or_else(|| "?".to_owned(), ToString::to_string);
            format!("通道 {name}")
        }
        Location::Sensors(group) => format!("传感器组 {group}"),
        Location::Mode(hz) => format!("{} 处的模态", format_hz(*hz)),
        Location::Parameter(name) => format!("参数 {name}"),
        Location::Quantity(name) => format!("量 {name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_are_translated_part_by_part_and_names_are_not() {
        let detail = "resonance at 596.37 Hz; run of excitation point 9:+X, of 9 runs; 3:+X";
        let finding = Finding::new(Severity::Info, Code::RunsDisagree, Location::Whole);
        let chinese = finding.detail(detail).chinese();
        let expected = "；596.37 Hz 处的共振；激励点 9:+X 的测量批次，共 9 批；3:+X";
        assert!(chinese.ends_with(expected), "{chinese}");
        let one = "1 sensor, from 20.0 to 80.0 Hz";
        assert_eq!(chinese_detail(one), "1 个传感器，20.0 至 80.0 Hz");
        let supports =
            "test suspended, model fixed; without stiffness to ground 9.1 Hz becomes 0.2 Hz";
        let expected = "试验 悬挂，模型 固定；去掉对地刚度后 9.1 Hz 变为 0.2 Hz";
        assert_eq!(chinese_detail(supports), expected);
        let tests = "f2: 1291.0 Hz in left, 1367.0 Hz in right; f3 5.1 %; 1 mode more";
        let expected = "f2：1291.0 Hz（left），1367.0 Hz（right）；f3 5.1 %；另有 1 个模态";
        assert_eq!(chinese_detail(tests), expected);
        for (english, chinese) in DETAILS {
            let count = |text: &str| text.matches("{}").count();
            assert_eq!(count(english), count(chinese), "{english}");
        }
    }

    /// Whether a text is Chinese: at least a quarter of its letters, as names of options and files
    /// are Latin.
    fn is_chinese(text: &str) -> bool {
        let han = text
            .chars()
            .filter(|c| ('\u{4e00}'..='\u{9fff}').contains(c))
            .count();
        han > 3 && 3 * han > text.chars().filter(char::is_ascii_alphabetic).count()
    }

    #[test]
    fn every_code_has_a_unique_chinese_sentence_and_an_explanation() {
        let mut sentences = std::collections::BTreeSet::new();
        for code in Code::ALL {
            assert!(is_chinese(code.chinese_sentence()), "{code:?}");
            assert!(is_chinese(code.chinese_explanation()), "{code:?}");
            assert!(sentences.insert(code.chinese_sentence()), "{code:?}");
            // Names of options and keys are what is typed: the translation has those of the
            // original.
            let names = |text: &str| -> Vec<String> {
                let parts = text.split('`').skip(1).step_by(2);
                parts.map(str::to_owned).collect()
            };
            let (translated, original) =
                (names(code.chinese_explanation()), names(code.explanation()));
            assert_eq!(translated, original, "{code:?}");
        }
    }

    #[test]
    fn the_sentence_has_location_value_limit_and_unit() {
        let finding = Finding::new(Severity::Warning, Code::FewLines, Location::Mode(123.456))
            .value(2.5, "Hz")
            .limit(5.0);
        let text = finding.chinese();
        assert!(
            text.starts_with("123.46 Hz 处的模态：半功率带宽内"),
            "{text}"
        );
        assert!(text.ends_with("（2.500 Hz，限值：至少 5 Hz）"), "{text}");
        let hit = Finding::new(Severity::Info, Code::DeadChannel, Location::Hit(3));
        assert_eq!(hit.chinese(), "第 3 次锤击：通道没有信号");
        let file = Location::File {
            path: "a.uff".to_owned(),
            line: None,
            byte: Some(7),
        };
        assert_eq!(location_text(&file), "a.uff 字节 7");
    }
}

//! Translation of captions, column heads, row labels, verdicts and findings. Definitions and
//! reasons under the tables remain English.

use serde::{Deserialize, Serialize};

use crate::finding::{Code, Finding, Severity};

use super::phrases::PHRASES_OF_RUNS;
use super::{Block, Cell, Table};

/// A language of headings and findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Simplified Chinese.
    Chinese,
}

impl Language {
    /// The language of this code: `en` or `zh`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "en" => Some(Language::English),
            "zh" => Some(Language::Chinese),
            _ => None,
        }
    }

    /// The sentence of a finding.
    pub fn finding(self, finding: &Finding) -> String {
        match self {
            Language::English => finding.to_string(),
            Language::Chinese => finding.chinese(),
        }
    }

    /// The sentence of a code, without location and numbers.
    pub fn sentence(self, code: Code) -> &'static str {
        match self {
            Language::English => code.sentence(),
            Language::Chinese => code.chinese_sentence(),
        }
    }

    /// Cause, consequence and remedy of a code.
    pub fn explanation(self, code: Code) -> &'static str {
        match self {
            Language::English => code.explanation(),
            Language::Chinese => code.chinese_explanation(),
        }
    }

    /// The name of a severity.
    pub fn severity(self, severity: Severity) -> String {
        match self {
            Language::English => severity.to_string(),
            Language::Chinese => severity.chinese().to_owned(),
        }
    }

    /// A paragraph in this language; one without a translation remains English.
    pub(super) fn translated_text(self, text: String) -> String {
        match self {
            Language::English => text,
            Language::Chinese => best_phrase(HEADLINES.iter(), &text),
        }
    }

    /// Blocks with their headings in this language; a heading without a translation remains
    /// English.
    pub fn translated(self, blocks: Vec<Block>) -> Vec<Block> {
        match self {
            Language::English => blocks,
            Language::Chinese => blocks.into_iter().map(block).collect(),
        }
    }
}

/// Headings in English and in Chinese; `{}` stands for a name.
const PHRASES: &[(&str, &str)] = &[
    ("Theory and test compared", "理论与试验对比"),
    ("Summary", "汇总"),
    ("Parameters of the model", "模型参数"),
    ("Limits", "限值"),
    ("mode", "阶次"),
    ("theory (Hz)", "理论 (Hz)"),
    ("test (Hz)", "试验 (Hz)"),
    ("std (Hz)", "标准差 (Hz)"),
    ("(test−theory)/theory (%)", "(试验−理论)/理论 (%)"),
    ("(theory−test)/test (%)", "(理论−试验)/试验 (%)"),
    ("normalised deviation", "(试验−理论)/标准差"),
    ("damping (%)", "阻尼比 (%)"),
    ("verdict", "结论"),
    ("{}\n(Hz)", "{}\n(Hz)"),
    ("{}\nerror (Hz)", "{}\n误差 (Hz)"),
    ("{}\nerror (%)", "{}\n误差 (%)"),
    ("{}\nverdict", "{}\n结论"),
    ("chance level", "随机水平"),
    ("basis", "依据"),
    ("{}\nbasis", "{}\n依据"),
    ("test", "试验"),
    ("paired", "已配对"),
    ("by shape", "按振型"),
    ("by frequency alone", "仅按频率"),
    ("missed", "漏检"),
    ("not observable", "不可观测"),
    ("unmatched test modes", "多余"),
    ("ambiguous", "不明确"),
    ("max |error| (%)", "最大 |误差| (%)"),
    ("mean |error| (%)", "平均 |误差| (%)"),
    ("rms error (%)", "均方根误差 (%)"),
    ("min MAC", "最小 MAC"),
    ("DOFs used", "自由度数"),
    ("name", "名称"),
    ("value", "数值"),
    ("unit", "单位"),
    ("status", "来源"),
    ("MAC of {} and theory", "{} 与理论的 MAC"),
    ("AutoMAC of {}", "{} 的自 MAC"),
    (
        "AutoMAC of the theory at the sensors of {}",
        "理论在 {} 测点处的自 MAC",
    ),
    ("Similar modes of {}", "{} 中相似的模态"),
    (
        "MAC over both frequencies (FMAC) of {} and theory",
        "{} 与理论的频率 MAC (FMAC)",
    ),
    (
        "Modal scale factors from theory to {}",
        "由理论到 {} 的模态比例因子",
    ),
    (
        "Correlation by degree of freedom of {} and theory (COMAC)",
        "{} 与理论的坐标模态置信准则 (COMAC)",
    ),
    (
        "Close modes of {} and theory as subspaces",
        "{} 与理论的密集模态子空间",
    ),
    (
        "Cross-orthogonality of {} and theory",
        "{} 与理论的互正交性",
    ),
    ("Self-orthogonality of {}", "{} 的自正交性"),
    ("Sign-reversed sensors", "与理论反向的传感器"),
    (
        "The test's points in the theory's frame",
        "试验测点在理论坐标系中的位置",
    ),
    ("f (Hz)", "频率 (Hz)"),
    ("test mode", "试验阶次"),
    ("theory mode", "理论阶次"),
    ("error (%)", "误差 (%)"),
    ("phase (deg)", "相位 (°)"),
    ("DOF", "自由度"),
    ("DOFs", "自由度数"),
    ("direction", "方向"),
    ("pairs", "配对数"),
    ("theory modes", "理论阶次"),
    ("test modes", "试验阶次"),
    ("from (Hz)", "起始 (Hz)"),
    ("to (Hz)", "终止 (Hz)"),
    ("angles (deg)", "主角 (°)"),
    ("at random", "随机值"),
    ("outside (%)", "降阶模态外 (%)"),
    ("response", "响应"),
    ("reference", "参考"),
    ("level (dB)", "幅值比 (dB)"),
    ("lines", "谱线数"),
    ("shape, mean", "形状，平均"),
    ("shape, least", "形状，最小"),
    ("amplitude, mean", "幅值，平均"),
    ("amplitude, least", "幅值，最小"),
    ("FRFs of {} and {}", "{} 与 {} 的频响函数"),
    (
        "FRFs of {} and {} over frequency",
        "{} 与 {} 的频响函数随频率",
    ),
    (
        "{}: number of modes that the data support",
        "{}：数据支持的模态数",
    ),
    ("{}: lowest order of every method", "{}：各方法的最低阶数"),
    (
        "{}: where one mode at a time is enough",
        "{}：单模态方法足够之处",
    ),
    ("modes", "模态数"),
    ("last mode added", "最后加入的模态"),
    ("FRFs that need it", "需要它的频响函数数"),
    ("held-out lines", "留出谱线"),
    ("reduced chi-square", "约化卡方"),
    ("lowest", "最低"),
    ("automatic", "自选"),
    ("tried", "已试"),
    ("enough", "足够"),
    (
        "{}: Pareto front of time and error",
        "{}：时间与误差的帕累托前沿",
    ),
    ("on", "对象"),
    ("FRFs", "频响函数"),
    ("method", "方法"),
    ("CPU time (ms)", "处理器时间 (ms)"),
    ("± spread (ms)", "± 离散 (ms)"),
    ("memory (MiB)", "内存 (MiB)"),
    ("frequency (%)", "频率 (%)"),
    ("shape (%)", "振型 (%)"),
    ("found", "找到"),
    ("of", "共"),
    ("spurious", "虚假"),
    ("Where methods fail: {}", "方法的失效边界：{}"),
    ("share of the slice", "图内有效占比"),
    ("failure mode beyond", "失效时的表现"),
    (
        "Numerical stability: digits lost by order, and the highest order with all poles to a tenth of their half-power width",
        "数值稳定性：随阶数丢失的位数，以及全部极点误差小于十分之一半功率带宽的最高阶数",
    ),
    ("digits, order 10", "位数，10 阶"),
    ("order, f64", "阶数，f64"),
    ("data in f32", "数据为 f32"),
    ("data and equations in f32", "数据与方程为 f32"),
    ("Draws per second", "每秒抽样数"),
    ("draws", "抽样数"),
    ("processor time (s)", "处理器时间 (s)"),
    ("draws per second", "每秒抽样数"),
];

/// Paragraphs in English and in Chinese.
const HEADLINES: &[(&str, &str)] = &[
    (
        "{} paired: {} by shape, {} by frequency alone",
        "{} 个已配对：{} 个按振型，{} 个仅按频率",
    ),
    (
        "{} paired: {} by shape, {} by frequency alone; {} ambiguous",
        "{} 个已配对：{} 个按振型，{} 个仅按频率；{} 个不明确",
    ),
    (
        "{}: {} paired: {} by shape, {} by frequency alone",
        "{}：{} 个已配对：{} 个按振型，{} 个仅按频率",
    ),
    (
        "{}: {} paired: {} by shape, {} by frequency alone; {} ambiguous",
        "{}：{} 个已配对：{} 个按振型，{} 个仅按频率；{} 个不明确",
    ),
];

/// Verdicts, sources and labels of closing rows in English and in Chinese, by the heads of their
/// columns.
const LABELS: &[(&str, &[(&str, &str)])] = &[
    (
        "last mode added",
        &[
            ("out-of-band terms alone", "仅带外项"),
            ("identified", "已识别"),
            ("stable pole", "稳定极点"),
        ],
    ),
    ("enough", &[("none alone", "单独均不足")]),
    (
        "verdict",
        &[
            ("paired", "已配对"),
            ("ambiguous", "不明确"),
            ("unmatched, near a paired mode", "漏检(预期)"),
            (
                "unmatched model mode, should have been seen",
                "漏检(非预期)",
            ),
            ("unmatched, observability unknown", "漏检(未判定)"),
            ("not-observable", "不可观测"),
            ("outside-band", "频带外"),
            ("unmatched test mode", "多余"),
            ("used", "采用"),
            ("used (stated)", "采用(指定)"),
            ("rejected", "剔除"),
            ("rejected (stated)", "剔除(指定)"),
            ("met", "满足"),
            ("MISSED", "未满足"),
            ("reproduced", "已复现"),
            ("NOT reproduced", "未复现"),
            ("not checkable", "无法核对"),
            ("identified", "可识别"),
            ("at bound", "位于边界"),
            ("not supported by the data", "数据不支持"),
            ("not supported by the data; held", "数据不支持；保持不变"),
        ],
    ),
    ("basis", &[("shape", "振型"), ("frequency", "频率")]),
    (
        "status",
        &[
            ("printed", "原文给出"),
            ("inferred", "推断"),
            ("assumed", "假定"),
        ],
    ),
    (
        "mode",
        &[
            ("max |error|", "最大 |误差|"),
            ("mean |error|", "平均 |误差|"),
            ("rms error", "均方根误差"),
        ],
    ),
];

fn block(block: Block) -> Block {
    match block {
        Block::Heading(text) => Block::Heading(phrase(&text)),
        Block::Text(text) => Block::Text(Language::Chinese.translated_text(text)),
        Block::Table(table) => Block::Table(translated_table(table)),
        Block::Findings { findings, .. } => Block::Findings {
            findings,
            language: Language::Chinese,
        },
    }
}

fn translated_table(mut table: Table) -> Table {
    for row in &mut table.rows {
        for (cell, column) in row.iter_mut().zip(&table.columns) {
            if let Cell::Text(text) = cell {
                *text = label(&column.head, text);
            }
        }
    }
    table.caption = phrase(&table.caption);
    for column in &mut table.columns {
        column.head = phrase(&column.head);
    }
    table
}

/// The translation of a label in a column with this head, the last line of which names what the
/// column holds; other text, such as the name of a test, stays as it is.
fn label(head: &str, text: &str) -> String {
    let kind = head.lines().last().unwrap_or_default();
    let mut labels = LABELS
        .iter()
        .filter(|(column, _)| *column == kind)
        .flat_map(|(_, labels)| labels.iter());
    let found = labels.find(|(from, _)| *from == text);
    found.map_or(text, |(_, translated)| translated).to_owned()
}

/// The translation of a heading. Of several matching phrases, the one with the most letters
/// outside `{}` applies.
fn phrase(text: &str) -> String {
    best_phrase(PHRASES.iter().chain(PHRASES_OF_RUNS), text)
}

/// The translation by the best match of some phrases.
fn best_phrase<'p>(phrases: impl Iterator<Item = &'p (&'p str, &'p str)>, text: &str) -> String {
    let letter_count = |phrase: &str| phrase.replace("{}", "").chars().count();
    let fits = phrases
        .filter_map(|(from, to)| Some((letter_count(from), filled(to, &names(from, text)?))));
    let best = fits.max_by_key(|(letters, _)| *letters);
    best.map_or_else(|| text.to_owned(), |(_, translated)| translated)
}

/// The names in a text at the positions of `{}` in a phrase; `None` if the text does not match.
fn names<'t>(phrase: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut parts = phrase.split("{}");
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

fn filled(phrase: &str, names: &[&str]) -> String {
    let mut names = names.iter();
    let mut parts = phrase.split("{}");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text += names.next().copied().unwrap_or_default();
        text += part;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Column;

    #[test]
    fn headings_are_translated_and_keep_their_names() {
        for (text, expected) in [
            ("Summary", "汇总"),
            ("AutoMAC of wing.unv", "wing.unv 的自 MAC"),
            (
                "AutoMAC of the theory at the sensors of a and b",
                "理论在 a and b 测点处的自 MAC",
            ),
            (
                "FRFs of a.h5 and b.uff over frequency",
                "a.h5 与 b.uff 的频响函数随频率",
            ),
            ("large\nerror (%)", "large\n误差 (%)"),
            ("f6 (8-fold)", "f6 (8-fold)"),
        ] {
            assert_eq!(phrase(text), expected);
        }
        let table = Table {
            caption: "Summary".to_owned(),
            columns: vec![Column::text("a\nverdict"), Column::number("MAC")],
            rows: vec![vec![Cell::text("paired"), Cell::number(Some(0.5), 2)]],
            footnotes: vec!["Summary".to_owned()],
        };
        let blocks = vec![Block::Table(table), Block::Text("Summary".to_owned())];
        assert_eq!(Language::English.translated(blocks.clone()), blocks);
        let chinese = Language::Chinese.translated(blocks);
        let Block::Table(table) = &chinese[0] else {
            panic!("a table stays one")
        };
        assert_eq!(table.columns[0].head, "a\n结论");
        assert_eq!(
            table.rows[0],
            [Cell::text("已配对"), Cell::number(Some(0.5), 2)]
        );
        assert_eq!(table.footnotes, ["Summary"]);
        assert_eq!(chinese[1], Block::Text("Summary".to_owned()));
    }

    #[test]
    fn names_in_cells_are_not_translated() {
        let names = ["test", "paired", "Summary", "rms error", "verdict"];
        let table = Table {
            columns: ["test", "name", "unit", "DOF"].map(Column::text).to_vec(),
            rows: names.map(|name| vec![Cell::text(name); 4]).to_vec(),
            ..Table::default()
        };
        let rows = table.rows.clone();
        let chinese = Language::Chinese.translated(vec![Block::Table(table)]);
        let Block::Table(table) = &chinese[0] else {
            panic!("a table stays one")
        };
        assert_eq!(table.columns[0].head, "试验");
        assert_eq!(table.rows, rows);
        let closing = label("mode", "rms error");
        assert_eq!(closing, "均方根误差");
    }

    #[test]
    fn every_phrase_has_one_translation_with_its_names() {
        let mut seen = std::collections::BTreeSet::new();
        for (from, to) in PHRASES.iter().chain(PHRASES_OF_RUNS) {
            let count = |text: &str| text.matches("{}").count();
            assert_eq!(count(from), count(to), "{from}");
            assert!(seen.insert(from), "{from}");
        }
    }
}

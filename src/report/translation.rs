//! Translation of sentences, captions, column heads, row labels and verdicts. What has no
//! translation, such as a reason under a table, remains English.

use crate::finding::{Code, Severity, pattern_values};

use super::phrase_texts::{COLUMN_CONTENTS, KINDS, OF_WORDS, PHRASES, WORDS};
use super::screen_texts::SCREEN_TEXTS;
use super::texts::{TEXTS, Text, labels_of};
use super::verdict_texts::VERDICT_TEXTS;
use super::{Block, Cell, Language, Table};

impl Language {
    /// A paragraph in this language; its lines without a translation remain English.
    pub(super) fn translated_text(self, text: String) -> String {
        match self {
            Language::English => text,
            Language::Chinese => {
                let lines = text
                    .lines()
                    .map(|line| warning(line).unwrap_or_else(|| sentence(line)));
                lines.collect::<Vec<_>>().join("\n")
            }
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

fn block(block: Block) -> Block {
    match block {
        Block::Heading(text) => Block::Heading(heading(&text)),
        Block::Text(text) => Block::Text(Language::Chinese.translated_text(text)),
        Block::Table(table) => Block::Table(translated_table(table)),
        Block::Findings { findings, .. } => Block::Findings {
            findings,
            language: Language::Chinese,
        },
    }
}

/// A line on a finding that puts the verdict in question; `None` of other lines.
fn warning(line: &str) -> Option<String> {
    let line = line.strip_prefix("Warning: ")?;
    let translated = |code: &Code| {
        let places = line.strip_prefix(code.sentence().trim_end_matches('.'))?;
        let (severity, sentence) = (Severity::Warning.chinese(), code.chinese_sentence());
        let places = places.strip_suffix('.').unwrap_or(places);
        let places = places.replacen(": ", "：", 1);
        Some(format!("{severity}：{sentence}{places}。"))
    };
    Code::ON_THE_VERDICT.iter().find_map(translated)
}

fn translated_table(mut table: Table) -> Table {
    for row in &mut table.rows {
        for (cell, column) in row.iter_mut().zip(&table.columns) {
            if let Cell::Text(text) = cell {
                *text = label(&column.head, text);
            }
        }
    }
    table.caption = heading(&table.caption);
    for note in &mut table.footnotes {
        *note = Language::Chinese.translated_text(std::mem::take(note));
    }
    for column in &mut table.columns {
        column.head = heading(&column.head);
    }
    table
}

/// The translation of a label, perhaps wrapped, in a column with this head, the last line of which
/// names what the column holds; other text, such as the name of a test, stays as it is.
fn label(head: &str, text: &str) -> String {
    let kind = head.lines().last().unwrap_or_default();
    let mut heads = TEXTS.headings.iter();
    let column = heads.find(|(_, head)| head.english == kind);
    let labels = column.map_or(&[][..], |(key, _)| labels_of(key));
    let unwrapped = text.replace('\n', " ");
    match best_match(labels.iter().map(|(_, text)| text), &unwrapped) {
        Some((label, names)) => label.filled(Language::Chinese, &names),
        None => {
            let list = LISTS.iter().find(|(head, _)| *head == kind);
            list.map_or_else(
                || text.to_owned(),
                |(_, phrases)| wrapped_as(text, &value(&unwrapped, phrases)),
            )
        }
    }
}

/// Heads of columns whose cells are lists of phrases, with these.
const LISTS: [(&str, &[Text]); 6] = [
    ("by name", COLUMN_CONTENTS),
    ("contents", PHRASES),
    ("responses", PHRASES),
    ("references", PHRASES),
    ("type", KINDS),
    ("quantity", KINDS),
];

/// The new text in lines as wide as those of the old one.
fn wrapped_as(old: &str, new: &str) -> String {
    let width = old.lines().map(|line| line.chars().count()).max();
    match old.contains('\n') {
        true => textwrap::fill(new, width.unwrap_or(0)),
        false => new.to_owned(),
    }
}

/// The translation of a line of a paragraph: as a whole, or of its sentences.
fn sentence(line: &str) -> String {
    let parts = sentences(line);
    let translated: Vec<Option<String>> = parts.iter().map(|part| whole(part)).collect();
    let is_complete = parts.len() > 1 && translated.iter().all(Option::is_some);
    if let Some(text) = whole(line).filter(|_| !is_complete) {
        return text;
    }
    let mut text = String::new();
    for (part, translated) in parts.iter().zip(translated) {
        if !text.is_empty() && !text.ends_with('。') {
            text.push(' ');
        }
        text += translated.as_deref().unwrap_or(part);
    }
    text
}

/// The sentences of a line, each with its full stop.
fn sentences(line: &str) -> Vec<&str> {
    let ends = line.match_indices(". ").map(|(at, _)| at + 1);
    let ends: Vec<usize> = ends.chain([line.len()]).collect();
    let starts = std::iter::once(0).chain(ends.iter().map(|end| end + 1));
    let bounds = starts.zip(&ends).filter(|(start, end)| start < *end);
    bounds.map(|(start, end)| &line[start..*end]).collect()
}

/// The sentence whose value lists captions of tables.
const FURTHER_TABLES: &str = "Further tables (--full): {}.";

/// The translation of a text as a whole, with the phrases that are its values; the texts have
/// plural nouns, also behind a number that is 1.
fn whole(text: &str) -> Option<String> {
    whole_of(text).or_else(|| whole_of(&with_plurals(text)?))
}

/// The text with plural nouns behind a number of 1; `None` without such a number.
fn with_plurals(text: &str) -> Option<String> {
    let words: Vec<&str> = text.split(' ').collect();
    let is_one = |at: usize| {
        at > 0 && words[at - 1].trim_start_matches('(') == "1" && !words[at].ends_with('s')
    };
    let plural = |(at, word): (usize, &&str)| {
        let noun = word.trim_end_matches(['.', ',', ';', ':', ')']);
        // A preposition is shorter than a noun.
        match is_one(at) && noun.len() > 2 && noun.chars().all(|c| c.is_ascii_lowercase()) {
            true => format!("{noun}s{}", &word[noun.len()..]),
            false => (*word).to_owned(),
        }
    };
    let plurals: Vec<String> = words.iter().enumerate().map(plural).collect();
    let plurals = plurals.join(" ");
    (plurals != text).then_some(plurals)
}

fn whole_of(text: &str) -> Option<String> {
    let groups = [TEXTS.paragraphs, VERDICT_TEXTS, SCREEN_TEXTS]
        .into_iter()
        .flatten();
    let (found, names) = best_match(groups.map(|(_, text)| text), text)?;
    let captions = |list: &str| list.split("; ").map(heading).collect::<Vec<_>>().join("；");
    let translated = |name: &str| match found.english {
        FURTHER_TABLES => captions(name),
        _ => value(name, PHRASES),
    };
    let values: Vec<String> = names.into_iter().map(translated).collect();
    Some(without_gaps(&found.filled(Language::Chinese, &values)))
}

/// The text without the blanks between Chinese characters, which stand around values.
fn without_gaps(text: &str) -> String {
    let is_chinese = |c: Option<char>| {
        c.is_some_and(|c| matches!(c, '\u{3000}'..='\u{9fff}' | '\u{ff00}'..='\u{ffef}'))
    };
    let characters: Vec<char> = text.chars().collect();
    let kept = (0..characters.len()).filter(|&at| {
        let before = at.checked_sub(1).map(|before| characters[before]);
        let after = characters.get(at + 1).copied();
        let is_gap = is_chinese(before) && is_chinese(after);
        characters[at] != ' ' || !is_gap
    });
    kept.map(|at| characters[at]).collect()
}

/// The translation of a value, or of its parts where it is a list; names remain as they are.
fn value(text: &str, phrases: &'static [Text]) -> String {
    parts(text, "; ", "；", phrases)
        .or_else(|| list(text, phrases))
        .or_else(|| phrase(text, phrases))
        .or_else(|| parts(text, ", ", "、", phrases))
        .unwrap_or_else(|| text.to_owned())
}

/// The translation of a list whose parts all are phrases: as a whole it may also match a phrase,
/// the values of which would hold other parts.
fn list(text: &str, phrases: &'static [Text]) -> Option<String> {
    let parts: Vec<&str> = text.split(", ").collect();
    let translated = parts.iter().map(|part| phrase(part, phrases));
    let translated: Option<Vec<String>> = translated.collect();
    translated
        .filter(|_| parts.len() > 1)
        .map(|all| all.join("、"))
}

/// The translation of a list, if it is one and a part of it has one.
fn parts(text: &str, separator: &str, chinese: &str, phrases: &'static [Text]) -> Option<String> {
    // A list of one would be translated without end.
    if !text.contains(separator) {
        return None;
    }
    let parts: Vec<&str> = text.split(separator).collect();
    let translated: Vec<String> = parts.iter().map(|part| value(part, phrases)).collect();
    let is_changed = translated.iter().zip(&parts).any(|(new, old)| new != old);
    is_changed.then(|| translated.join(chinese))
}

fn phrase(text: &str, phrases: &'static [Text]) -> Option<String> {
    let (found, names) = best_match(phrases.iter(), text)?;
    // A number with its noun ends a list that is no phrase.
    let first = names.first().filter(|_| found.english.starts_with("{} "));
    if first.is_some_and(|first| first.contains(',')) {
        return None;
    }
    let of_values = match OF_WORDS.contains(&found.english) {
        true => WORDS,
        false => PHRASES,
    };
    let values: Vec<String> = names
        .into_iter()
        .map(|name| value(name, of_values))
        .collect();
    Some(found.filled(Language::Chinese, &values))
}

fn heading(text: &str) -> String {
    let found = best_match(TEXTS.headings.iter().map(|(_, text)| text), text);
    found.map_or_else(
        || text.to_owned(),
        |(found, names)| match found.english {
            RANGE_OF_FACTOR => {
                let names = names.iter().map(|name| value(name, WORDS));
                found.filled(Language::Chinese, &names.collect::<Vec<_>>())
            }
            _ => found.filled(Language::Chinese, &names),
        },
    )
}

/// Head of a column with the range of a factor at the value of another.
const RANGE_OF_FACTOR: &str = "{}\nat {}\n{}";

/// The text that matches, with the names at its `{}`. Of several the one with the most letters
/// outside `{}` applies.
fn best_match(
    texts: impl Iterator<Item = &'static Text>,
    text: &str,
) -> Option<(&'static Text, Vec<&str>)> {
    let letter_count = |text: &str| text.replace("{}", "").chars().count();
    let matches = texts.filter_map(|found| Some((found, pattern_values(found.english, text)?)));
    matches.max_by_key(|(found, _)| letter_count(found.english))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Column;

    #[test]
    fn a_text_with_a_count_of_one_is_that_of_many() {
        for (text, expected) in [
            (
                "After: 1 of 1 mode paired; largest error 1.000 %, rms 1.000 %, chi-square 2.1 of 1 residual.",
                "修正后",
            ),
            (
                "Chi-square per degree of freedom 1.053 (1 degree of freedom; noise alone reaches 1.60).",
                "每自由度卡方",
            ),
        ] {
            let chinese = Language::Chinese.translated_text(text.to_owned());
            assert!(chinese.starts_with(expected), "{chinese}");
        }
    }

    #[test]
    fn warnings_on_the_verdict_are_translated() {
        for code in Code::ON_THE_VERDICT {
            let sentence = code.sentence().trim_end_matches('.');
            let line = format!("Warning: {sentence}: disc; ring.");
            let translated = Language::Chinese.translated_text(line);
            let expected = format!("警告：{}：disc; ring。", code.chinese_sentence());
            assert_eq!(translated, expected);
        }
    }

    #[test]
    fn values_of_sentences_are_translated_and_names_are_not() {
        for (line, expected) in [
            (
                "Within 5 % and MAC 0.9: 3 of 3 modes. The model agrees with the test: rms error 0.148 %, largest -0.173 % at f2, smallest MAC 0.993.",
                "在 5 % 与 MAC 0.9 以内：3 / 3 阶。模型与试验相符：均方根误差 0.148 %，最大 -0.173 % (f2)，最小 MAC 0.993。",
            ),
            (
                "Pairs: 3 of 5 model modes, 3 by shape, 0 by frequency, 1 ambiguous; unmatched: f4, f5.",
                "配对：3 / 5 阶模型模态，按振型 3，仅按频率 0、1 个不明确；未配对：f4, f5。",
            ),
            (
                "Before you leave, drift: hit again 3:+Z: 2 good hits of 3; not tested: drift, support.",
                "离开之前，drift：需重新锤击 3:+Z：合格锤击 2 / 3；未检验：漂移、支承。",
            ),
            (
                "1 of 4 starts (seed 1) reach this optimum, the lowest, of objective 48.95; 3 reach 3 others, the lowest of 233.7.",
                "1 / 4 个起点 (种子 1) 到达此最优点，其目标函数最低，为 48.95；3 个到达其他 3 个最优点，最低为 233.7。",
            ),
            (
                "1 of 2 starts (seed 1) reach this optimum, the lowest, of objective 4; 1 reach another, of 5; from 1 the model had no modes or no derivatives.",
                "1 / 2 个起点 (种子 1) 到达此最优点，其目标函数最低，为 4；1 个到达另一最优点，为 5；自 1 个起点模型无模态或无导数。",
            ),
            (
                "Not supported by the data: 8 of 10 because of their std, 1 of 10 because the model error has fewer than 3 degrees of freedom.",
                "数据不支持：8 / 10 个因标准差过大、1 / 10 个因模型误差的自由度少于 3。",
            ),
            (
                "Fits as well: m_5 = 0.08993; model mode 19 differs most: 7293.9 Hz against 4745.8 Hz, MAC 0.00.",
                "同样符合：m_5 = 0.08993；模型第 19 阶模态差别最大：7293.9 Hz 与 4745.8 Hz，MAC 0.00。",
            ),
            (
                "Proposed: m_3, j_0 (the smallest set that brings the residual to its uncertainty).",
                "建议：m_3, j_0 (使残差降到其不确定度的最小参数组)。",
            ),
            (
                "Not compared with the baseline: before, starts.",
                "未与基线比较：before, starts。",
            ),
            (
                "Further tables (--full): AutoMAC of a; Harmonics of the deflections of gear.",
                "其他表格 (--full)：a 的自 MAC；gear 的变形的谐波。",
            ),
            (
                "Assumed in the model: 3 statements and 1 parameter (support).",
                "模型中的假定：3 条陈述与 1 个参数 (support)。",
            ),
        ] {
            assert_eq!(Language::Chinese.translated_text(line.to_owned()), expected);
        }
    }

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
            assert_eq!(heading(text), expected);
        }
        let table = Table {
            caption: "Summary".to_owned(),
            columns: vec![Column::text("a\nverdict"), Column::number("MAC")],
            rows: ["paired", "paired\nby shape"]
                .map(|verdict| vec![Cell::text(verdict), Cell::number(Some(0.5), 2)])
                .to_vec(),
            footnotes: [
                "Summary",
                "Error = (test - theory)/theory. ~: paired by frequency alone.",
            ]
            .map(str::to_owned)
            .to_vec(),
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
        // A label that was wrapped for the screen.
        assert_eq!(table.rows[1][0], Cell::text("按振型配对"));
        assert_eq!(
            table.footnotes,
            ["Summary", "误差 = (试验 - 理论)/理论。~：仅按频率配对。"]
        );
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
}

//! Texts of the report in English and Chinese, by the keys of `text_table`.
//!
//! The page names its texts by key. Blocks and the script contain English texts; their translation
//! is the one beside the English text.

use super::Language;
use super::label_texts::LABELS;
pub(super) use super::text_table::{Group, TEXTS, Text};

impl Text {
    /// The text in a language.
    pub fn in_language(&self, language: Language) -> &'static str {
        match language {
            Language::English => self.english,
            Language::Chinese => self.chinese,
        }
    }

    /// The text in a language with values at its `{}`, in order.
    pub fn filled(&self, language: Language, values: &[impl AsRef<str>]) -> String {
        let mut parts = self.in_language(language).split("{}");
        let mut filled = parts.next().unwrap_or_default().to_owned();
        let mut values = values.iter();
        for part in parts {
            filled += values.next().map_or("", AsRef::as_ref);
            filled += part;
        }
        filled
    }
}

/// An English text in a language; it remains English where the group lacks it.
pub(super) fn translate<'t>(group: &'t Group, language: Language, english: &'t str) -> &'t str {
    let text = group.iter().find(|(_, text)| text.english == english);
    text.map_or(english, |(_, text)| text.in_language(language))
}

/// The labels in the cells of a column, by the key of its head; empty for a column without labels.
pub(super) fn labels_of(head: &str) -> &'static Group {
    let labels = LABELS.iter().find(|(key, _)| *key == head);
    labels.map_or(&[], |(_, labels)| labels)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::screen_texts::SCREEN_TEXTS;
    use super::super::verdict_texts::VERDICT_TEXTS;
    use super::*;

    /// Headings and labels that the code composes of several literals.
    const COMPOSED: [&str; 16] = [
        "locus {} (Hz)",
        "locus {}, {} modes (Hz)",
        "{} modes",
        "1 mode",
        "{} files",
        "1 file",
        "{} rows, {} MISSED",
        "{} arrays",
        "Hits: {}",
        "Points to hit again: {}",
        "{}: (test−theory)/theory (%)",
        "{}: (theory−test)/test (%)",
        "before\n(test−theory)/theory (%)",
        "after\n(test−theory)/theory (%)",
        "before\n(theory−test)/test (%)",
        "after\n(theory−test)/test (%)",
    ];

    /// The groups whose texts the code finds by their English text.
    fn groups_in_code() -> Vec<&'static Group> {
        let mut groups = vec![TEXTS.headings, TEXTS.stop_reasons, TEXTS.factors];
        groups.extend(LABELS.iter().map(|(_, labels)| *labels));
        groups
    }

    /// The texts of every group.
    fn all_groups() -> Vec<Vec<&'static Text>> {
        let mut groups = groups_in_code();
        groups.extend([TEXTS.paragraphs, TEXTS.script, VERDICT_TEXTS, SCREEN_TEXTS]);
        let texts = |group: &'static Group| group.iter().map(|(_, text)| text).collect();
        let page = TEXTS.page.texts();
        groups.into_iter().map(texts).chain([page]).collect()
    }

    #[test]
    fn every_text_is_unique_in_its_group_and_has_a_translation_with_its_values() {
        assert!(TEXTS.headings.len() > 100);
        for group in all_groups() {
            let mut seen = BTreeSet::new();
            for text in group {
                let count = |text: &str| text.matches("{}").count();
                let english = text.english;
                assert_eq!(count(english), count(text.chinese), "{english}");
                assert!(!text.chinese.is_empty(), "{english}");
                assert!(seen.insert(english), "{english}");
            }
        }
    }

    #[test]
    fn keys_are_unique_and_labels_belong_to_a_head() {
        let keys = |group: &Group| group.iter().map(|(key, _)| *key).collect::<BTreeSet<_>>();
        let groups = groups_in_code().into_iter();
        for group in groups.chain([TEXTS.paragraphs, TEXTS.script, VERDICT_TEXTS, SCREEN_TEXTS]) {
            assert_eq!(keys(group).len(), group.len());
        }
        let heads = keys(TEXTS.headings);
        for (head, labels) in LABELS {
            assert!(heads.contains(head), "{head}");
            assert_eq!(labels_of(head).len(), labels.len());
        }
        assert!(labels_of("frequency").is_empty());
    }

    /// The code without the names inside `{}`.
    fn code_with_empty_placeholders() -> String {
        let mut folders = vec![std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
        let mut code = String::new();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|kind| kind == "rs")
                    && !path.ends_with("report/texts.rs")
                    && !path.ends_with("report/text_table.rs")
                    && !path.ends_with("report/label_texts.rs")
                {
                    code += &std::fs::read_to_string(&path).unwrap();
                }
            }
        }
        let mut parts = code.split('{');
        let mut emptied = parts.next().unwrap().to_owned();
        for part in parts {
            let (name, after) = part.split_once('}').unwrap_or(("", part));
            let is_name = name
                .chars()
                .all(|c| c.is_alphanumeric() || "_.:+".contains(c));
            emptied += "{}";
            emptied += if is_name { after } else { part };
        }
        emptied
    }

    #[test]
    fn a_text_found_by_its_english_is_in_the_code() {
        let code = code_with_empty_placeholders();
        for (_, Text { english, .. }) in groups_in_code().into_iter().flatten() {
            let is_in_code = code.contains(&format!("{english:?}"));
            assert!(is_in_code || COMPOSED.contains(english), "{english}");
        }
    }
}

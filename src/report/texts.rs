//! Texts of the report in English and Chinese, by the keys of `texts.toml`.
//!
//! The page names its texts by key. Blocks and the script contain English texts; their translation
//! is the one beside the English text.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::Language;

/// A text in both languages; `{}` stands for a name or a number.
#[derive(Deserialize)]
pub(super) struct Text {
    pub english: String,
    pub chinese: String,
}

/// Texts by key.
pub(super) type Group = BTreeMap<String, Text>;

/// The content of `texts.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Texts {
    /// Captions and column heads of tables.
    pub headings: Group,
    /// Paragraphs between tables.
    pub paragraphs: Group,
    /// Labels in the cells of a column, by the key of its head.
    pub labels: BTreeMap<String, Group>,
    /// Texts of the page.
    pub page: Page,
    /// Why an update stopped.
    pub stop_reasons: Group,
    /// Names, units and axes of the factors of maps.
    pub factors: Group,
    /// Texts that the script of the page writes.
    pub script: Group,
}

/// Every text of the report.
pub(super) static TEXTS: LazyLock<Texts> = LazyLock::new(|| {
    toml::from_str(include_str!("texts.toml")).expect("`texts.toml` has the keys of `Texts`")
});

impl Text {
    /// The text in a language.
    pub fn in_language(&self, language: Language) -> &str {
        match language {
            Language::English => &self.english,
            Language::Chinese => &self.chinese,
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
    let text = group.values().find(|text| text.english == english);
    text.map_or(english, |text| text.in_language(language))
}

/// Texts of the page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Page {
    pub skip_to_content: Text,
    pub light_or_dark: Text,
    pub notes: Text,
    pub made_by: Text,
    pub figures_need_a_script: Text,
    pub summary: Text,
    pub comparison: Text,
    pub mode_shapes: Text,
    pub mac: Text,
    pub frfs: Text,
    pub stabilization_diagram: Text,
    pub circle_fits: Text,
    pub modes: Text,
    pub energies: Text,
    pub update: Text,
    pub published_results: Text,
    pub hits: Text,
    pub findings: Text,
    pub provenance: Text,
    pub modes_with_a_partner: Text,
    pub rms_frequency_error: Text,
    pub largest: Text,
    pub smallest_mac: Text,
    pub unmatched_model: Text,
    pub not_observable: Text,
    pub unmatched_test: Text,
    pub ambiguous: Text,
    pub unmatched_modes: Text,
    pub no_unmatched_modes: Text,
    pub recommended_changes: Text,
    pub update_result: Text,
    pub synthetic: Text,
    pub unmatched_not_excited: Text,
    pub unmatched_observability_unknown: Text,
    pub unmatched_but_observable: Text,
    pub unmatched_test_mode: Text,
    pub unobservable_model_modes: Text,
    pub model_too_stiff: Text,
    pub model_too_soft: Text,
    pub errors_without_common_sign: Text,
    pub update_estimates_parameters: Text,
    pub parameter_change: Text,
    pub limit_missed: Text,
    pub limits_met: Text,
    pub number_of_warnings: Text,
    pub test_only: Text,
    pub no_findings: Text,
    pub whole_run: Text,
    pub more_of_this_code: Text,
    pub program: Text,
    pub model: Text,
    pub seed_of: Text,
    pub run_files: Text,
    pub data: Text,
    pub identification: Text,
    pub test: Text,
    pub file: Text,
    pub method: Text,
    pub band_hz: Text,
    pub updated_parameters: Text,
    pub parameter: Text,
    pub unit: Text,
    pub before: Text,
    pub after: Text,
    pub std: Text,
    pub change_percent: Text,
    pub verdict: Text,
    pub frequencies_before_and_after: Text,
    pub mode: Text,
    pub test_hz: Text,
    pub model_hz: Text,
    pub error_before_percent: Text,
    pub error_after_percent: Text,
    pub update_explains: Text,
    pub update_does_not_explain: Text,
    pub further_sentence: Text,
    pub rms_before_and_after: Text,
    pub further_parameters: Text,
    pub starts_at_this_optimum: Text,
    pub identifiable_combinations: Text,
    pub combination: Text,
    pub single_changes: Text,
    pub rms_error_percent: Text,
    pub largest_error_percent: Text,
    pub no_change: Text,
    pub smallest_explaining_set: Text,
    pub no_explaining_set: Text,
    pub model_before_update: Text,
    pub tabs_before_update: Text,
    pub update_of_another_run: Text,
    pub methods: Text,
    pub speed_study: Text,
    pub breakdown_study: Text,
    pub order_study: Text,
    pub order_of_another_run: Text,
    pub map_text: Text,
    pub speed_of_another_run: Text,
    pub breakdown_of_another_run: Text,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Headings and labels that the code composes of several literals.
    const COMPOSED: [&str; 3] = [
        "Hits: {}",
        "{}: (test−theory)/theory (%)",
        "{}: (theory−test)/test (%)",
    ];

    fn texts_of(group: &str, table: toml::Table) -> Vec<(String, Text)> {
        let texts = table.into_iter().flat_map(|(key, value)| match value {
            toml::Value::Table(table) => texts_of(&format!("{group}/{key}"), table),
            value => vec![(group.to_owned(), value.try_into().unwrap())],
        });
        texts.collect()
    }

    /// Every text with its group.
    fn all_texts() -> Vec<(String, Text)> {
        texts_of("", toml::from_str(include_str!("texts.toml")).unwrap())
    }

    #[test]
    fn every_text_is_unique_in_its_group_and_has_a_translation_with_its_values() {
        assert!(TEXTS.headings.len() > 100);
        let mut seen = std::collections::BTreeSet::new();
        for (group, text) in all_texts() {
            let count = |text: &str| text.matches("{}").count();
            assert_eq!(
                count(&text.english),
                count(&text.chinese),
                "{}",
                text.english
            );
            assert!(!text.chinese.is_empty(), "{}", text.english);
            assert!(
                seen.insert((group, text.english.clone())),
                "{}",
                text.english
            );
        }
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
        for (group, text) in all_texts() {
            let by_english = !["/page", "/script", "/paragraphs"].contains(&group.as_str());
            if by_english && !COMPOSED.contains(&text.english.as_str()) {
                assert!(
                    code.contains(&format!("{:?}", text.english)),
                    "{}",
                    text.english
                );
            }
        }
    }
}

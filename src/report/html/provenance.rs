//! The provenance tab lists the inputs of a run: program, seeds, methods, and files with their
//! SHA-256 hashes.

use crate::scene::SourceFile;

use super::super::json::RunReport;
use super::super::{Block, Cell, Column, Language, Table};
use super::markup::{escape, fragment};
use super::words::{sentence, word};

/// Program, model, seeds, methods, files with hashes, and the text of the files that state the run.
pub(super) fn provenance(report: &RunReport, language: Language) -> String {
    let provenance = &report.provenance;
    let mut facts = vec![(
        word(language, "Program").to_owned(),
        provenance.producer.clone(),
    )];
    facts.extend(
        provenance
            .model
            .iter()
            .map(|name| (word(language, "Model").to_owned(), name.clone())),
    );
    for (test, seed) in &provenance.seeds {
        facts.push((
            sentence(language, "Seed of {}", std::slice::from_ref(test)),
            seed.to_string(),
        ));
    }
    let facts: String = facts
        .iter()
        .map(|(name, value)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value)))
        .collect();
    let table = |caption: &'static str, heads: [&'static str; 3], rows: &[[String; 3]]| {
        let row = |row: &[String; 3]| row.iter().map(Cell::text).collect();
        Block::Table(Table {
            caption: word(language, caption).to_owned(),
            columns: heads
                .iter()
                .map(|head| Column::text(word(language, head)))
                .collect(),
            rows: rows.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    };
    let mut tables = Vec::new();
    if !provenance.searched.is_empty() {
        tables.push(table(
            "Identification",
            ["test", "method", "band (Hz)"],
            &provenance.searched,
        ));
    }
    if !provenance.inputs.is_empty() {
        tables.push(table(
            "Data",
            ["test", "file", "SHA-256"],
            &provenance.inputs,
        ));
    }
    let files: String = provenance.stated.iter().map(file_text).collect();
    format!(
        "<dl class=\"facts\">\n{facts}</dl>\n{}<h3>{}</h3>\n{files}",
        fragment(&tables, language),
        word(language, "Files that state the run")
    )
}

fn file_text(file: &SourceFile) -> String {
    let head = format!(
        "<code>{}</code> <small class=\"hash\">{}</small>",
        escape(&file.path),
        file.sha256
    );
    match &file.text {
        Some(text) => format!(
            "<details><summary>{head}</summary>\n<pre tabindex=\"0\">{}</pre></details>\n",
            escape(text)
        ),
        None => format!("<p>{head}</p>\n"),
    }
}

//! The provenance tab lists the inputs of a run: program, seeds, methods, and files with their
//! SHA-256 hashes.

use crate::scene::SourceFile;

use super::super::json::RunReport;
use super::super::texts::{TEXTS, Text};
use super::super::{Block, Cell, Column, Language, Table};
use super::markup::{escape, fragment};

/// Program, model, seeds, methods, files with hashes, and the text of the files that state the run.
pub(super) fn provenance(report: &RunReport, language: Language) -> String {
    let (provenance, texts) = (&report.provenance, &TEXTS.page);
    let w = |text: &'static Text| text.in_language(language);
    let mut facts = vec![(w(&texts.program).to_owned(), provenance.producer.clone())];
    facts.extend(
        provenance
            .model
            .iter()
            .map(|name| (w(&texts.model).to_owned(), name.clone())),
    );
    for (test, seed) in &provenance.seeds {
        facts.push((
            texts.seed_of.filled(language, std::slice::from_ref(test)),
            seed.to_string(),
        ));
    }
    let facts: String = facts
        .iter()
        .map(|(name, value)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value)))
        .collect();
    let table = |caption: &Text, heads: [&str; 3], rows: &[[String; 3]]| {
        let row = |row: &[String; 3]| row.iter().map(Cell::text).collect();
        Block::Table(Table {
            caption: caption.in_language(language).to_owned(),
            columns: heads.map(Column::text).to_vec(),
            rows: rows.iter().map(row).collect(),
            footnotes: Vec::new(),
        })
    };
    let mut tables = Vec::new();
    if !provenance.searched.is_empty() {
        tables.push(table(
            &texts.identification,
            [w(&texts.test), w(&texts.method), w(&texts.band_hz)],
            &provenance.searched,
        ));
    }
    if !provenance.inputs.is_empty() {
        tables.push(table(
            &texts.data,
            [w(&texts.test), w(&texts.file), "SHA-256"],
            &provenance.inputs,
        ));
    }
    let files: String = provenance.stated.iter().map(file_text).collect();
    format!(
        "<dl class=\"facts\">\n{facts}</dl>\n{}<h3>{}</h3>\n{files}",
        fragment(&tables, language),
        w(&texts.run_files)
    )
}

fn file_text(file: &SourceFile) -> String {
    let head = format!(
        "<code>{}</code> <small class=\"hash\">{}</small>",
        escape(&file.path),
        escape(&file.sha256)
    );
    match &file.text {
        Some(text) => format!(
            "<details><summary>{head}</summary>\n<pre tabindex=\"0\">{}</pre></details>\n",
            escape(&text.replace("\r\n", "\n"))
        ),
        None => format!("<p>{head}</p>\n"),
    }
}

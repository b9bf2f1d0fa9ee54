//! The LaTeX renderer writes `table` environments with `booktabs` rules.

use super::{Align, Block, Renderer, Table};

/// Renders LaTeX. The document needs `\usepackage{booktabs}` and a UTF-8 engine or input encoding.
pub struct Latex;

impl Renderer for Latex {
    fn name(&self) -> &'static str {
        "latex"
    }

    fn extension(&self) -> &'static str {
        "tex"
    }

    fn render(&self, blocks: &[Block]) -> String {
        let parts: Vec<String> = blocks
            .iter()
            .map(block_text)
            .filter(|text| !text.is_empty())
            .collect();
        parts.join("\n\n") + "\n"
    }
}

fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            '—' => escaped.push_str("---"),
            '−' => escaped.push_str("$-$"),
            'ζ' => escaped.push_str("$\\zeta$"),
            '²' => escaped.push_str("$^2$"),
            '≥' => escaped.push_str("$\\ge$"),
            '|' | '<' | '>' => escaped.extend(['$', c, '$']),
            'ω' => escaped.push_str("$\\omega$"),
            'λ' => escaped.push_str("$\\lambda$"),
            'π' => escaped.push_str("$\\pi$"),
            '·' => escaped.push_str("$\\cdot$"),
            '°' => escaped.push_str("$^\\circ$"),
            '\n' => escaped.push(' '),
            other => escaped.push(other),
        }
    }
    escaped
}

fn block_text(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("\\section*{{{}}}", escape(text)),
        Block::Text(text) => escape(text),
        Block::Table(table) => table_text(table),
        Block::Findings { findings, .. } if findings.is_empty() => String::new(),
        Block::Findings { findings, language } => {
            let items: Vec<String> = findings
                .iter()
                .map(|f| format!("  \\item {}", escape(&language.finding(f))))
                .collect();
            format!("\\begin{{itemize}}\n{}\n\\end{{itemize}}", items.join("\n"))
        }
    }
}

fn row(fields: impl Iterator<Item = String>) -> String {
    format!("  {} \\\\", fields.collect::<Vec<_>>().join(" & "))
}

fn table_text(table: &Table) -> String {
    let columns: String = table
        .columns
        .iter()
        .map(|c| if c.align == Align::Left { 'l' } else { 'r' })
        .collect();
    let mut lines = vec!["\\begin{table}".to_owned(), "  \\centering".to_owned()];
    lines.push(format!("  \\caption{{{}}}", escape(&table.caption)));
    lines.push(format!("  \\begin{{tabular}}{{{columns}}}"));
    lines.push("  \\toprule".to_owned());
    lines.push(row(table.columns.iter().map(|column| escape(&column.head))));
    lines.push("  \\midrule".to_owned());
    lines.extend(
        table
            .rows
            .iter()
            .map(|fields| row(fields.iter().map(|cell| escape(&cell.display())))),
    );
    lines.push("  \\bottomrule".to_owned());
    lines.push("  \\end{tabular}".to_owned());
    lines.extend(
        table
            .footnotes
            .iter()
            .map(|note| format!("  \\par\\footnotesize {}", escape(note))),
    );
    lines.push("\\end{table}".to_owned());
    lines.join("\n")
}

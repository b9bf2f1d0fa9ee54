//! Characters of LaTeX: the commands of those that pdflatex refuses or reads as commands, and their
//! widths in Computer Modern.

use crate::printable::printable;

/// Commands of mathematics for characters that pdflatex refuses or sets from a font that a small
/// installation lacks.
const MATHEMATICS: &[(char, &str)] = &[
    ('|', "|"),
    ('<', "<"),
    ('>', ">"),
    ('−', "-"),
    ('±', "\\pm"),
    ('∓', "\\mp"),
    ('×', "\\times"),
    ('·', "\\cdot"),
    ('√', "\\surd"),
    ('∞', "\\infty"),
    ('∝', "\\propto"),
    ('∫', "\\int"),
    ('∂', "\\partial"),
    ('∈', "\\in"),
    ('≈', "\\approx"),
    ('≠', "\\ne"),
    ('≤', "\\le"),
    ('≥', "\\ge"),
    ('→', "\\to"),
    ('⟨', "\\langle"),
    ('⟩', "\\rangle"),
    ('°', "^\\circ"),
    ('′', "'"),
    ('½', "\\frac12"),
    ('¼', "\\frac14"),
    ('¾', "\\frac34"),
    ('⁰', "^0"),
    ('¹', "^1"),
    ('²', "^2"),
    ('³', "^3"),
    ('⁴', "^4"),
    ('⁵', "^5"),
    ('⁶', "^6"),
    ('⁷', "^7"),
    ('⁸', "^8"),
    ('⁹', "^9"),
    ('⁺', "^+"),
    ('⁻', "^-"),
    ('ⁿ', "^n"),
    ('ᴴ', "^\\mathrm{H}"),
    ('ᵀ', "^\\mathrm{T}"),
    ('₀', "_0"),
    ('₁', "_1"),
    ('₂', "_2"),
    ('₃', "_3"),
    ('₄', "_4"),
    ('₅', "_5"),
    ('₆', "_6"),
    ('₇', "_7"),
    ('₈', "_8"),
    ('₉', "_9"),
    ('₊', "_+"),
    ('₋', "_-"),
    ('α', "\\alpha"),
    ('β', "\\beta"),
    ('γ', "\\gamma"),
    ('δ', "\\delta"),
    ('ε', "\\varepsilon"),
    ('ζ', "\\zeta"),
    ('η', "\\eta"),
    ('θ', "\\theta"),
    ('ι', "\\iota"),
    ('κ', "\\kappa"),
    ('λ', "\\lambda"),
    ('μ', "\\mu"),
    ('µ', "\\mu"),
    ('ν', "\\nu"),
    ('ξ', "\\xi"),
    ('ο', "o"),
    ('π', "\\pi"),
    ('ρ', "\\rho"),
    ('σ', "\\sigma"),
    ('τ', "\\tau"),
    ('υ', "\\upsilon"),
    ('φ', "\\varphi"),
    ('χ', "\\chi"),
    ('ψ', "\\psi"),
    ('ω', "\\omega"),
    ('Γ', "\\Gamma"),
    ('Δ', "\\Delta"),
    ('Θ', "\\Theta"),
    ('Λ', "\\Lambda"),
    ('Ξ', "\\Xi"),
    ('Π', "\\Pi"),
    ('Σ', "\\Sigma"),
    ('Φ', "\\Phi"),
    ('Ψ', "\\Psi"),
    ('Ω', "\\Omega"),
];

/// Commands of text.
const TEXT: &[(char, &str)] = &[
    ('&', "\\&"),
    ('%', "\\%"),
    ('$', "\\$"),
    ('#', "\\#"),
    ('_', "\\_"),
    ('{', "\\{"),
    ('}', "\\}"),
    ('\\', "\\textbackslash{}"),
    ('~', "\\textasciitilde{}"),
    ('^', "\\textasciicircum{}"),
    ('`', "\\textasciigrave{}"),
    ('—', "---"),
    ('–', "--"),
    ('…', "\\ldots{}"),
    ('\u{2011}', "-"),
    ('\u{a0}', "~"),
    ('\u{2009}', "\\,"),
    ('\u{202f}', "\\,"),
];

/// Fewest characters of a word that may be broken at its signs. With fewer, units such as `N/m` are
/// broken; with more, paths and names of parameters run off the page.
const MIN_BREAKABLE_CHARACTERS: usize = 14;
/// Signs after which LaTeX may break a long word.
const BREAKS: &[char] = &['/', '|', '_', ':', '-', '.'];

/// The text in LaTeX, on a line. Words between backticks are set as code.
pub(super) fn escaped(text: &str) -> String {
    escaped_words(text, false)
}

/// The text in LaTeX, whose long words may be broken.
pub(super) fn escaped_paragraph(text: &str) -> String {
    escaped_words(text, true)
}

fn escaped_words(text: &str, breaks_words: bool) -> String {
    // The marks are private characters, which no font has.
    let text = printable(text).replace([CODE, QUOTE], "?");
    let words = text.split([' ', '\n', '\t']);
    let words = words.map(|word| escaped_word(word, breaks_words));
    code_and_quotes(&words.collect::<Vec<_>>().join(" "))
}

/// Marks between which text is code, until the whole text is known.
const CODE: char = '\u{e000}';
/// A straight quotation mark, until the whole text is known.
const QUOTE: char = '\u{e001}';

fn code_and_quotes(text: &str) -> String {
    let paired = |mark: char| text.matches(mark).count().is_multiple_of(2);
    let (codes, quotes) = (paired(CODE), paired(QUOTE));
    let (mut in_code, mut in_quotes) = (false, false);
    let mut written = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            CODE if codes => {
                written.push_str(if in_code { "}" } else { "\\texttt{" });
                in_code = !in_code;
            }
            CODE => written.push_str("\\textasciigrave{}"),
            QUOTE => {
                written.push_str(if in_quotes || !quotes { "''" } else { "``" });
                in_quotes = !in_quotes;
            }
            other => written.push(other),
        }
    }
    written
}

fn escaped_word(word: &str, breaks_words: bool) -> String {
    if let Some(power) = power_of_ten(word) {
        return power;
    }
    let breaks = breaks_words && word.chars().count() >= MIN_BREAKABLE_CHARACTERS;
    let mut written = LatexText::default();
    let mut characters = word.chars().peekable();
    let mut before = None;
    while let Some(c) = characters.next() {
        let next = characters.peek().copied();
        let command = |list: &[(char, &'static str)]| {
            let found = list.iter().find(|(of, _)| *of == c);
            found.map(|(_, command)| *command)
        };
        match (c, next) {
            ('`', _) => written.push_text(CODE.to_string().as_str()),
            ('"', _) => written.push_text(QUOTE.to_string().as_str()),
            ('-', next) if is_sign(before, next) => written.push_mathematics("-"),
            // Two hyphens would be a dash.
            ('-', Some('-')) => written.push_text("-{}"),
            ('^', Some(exponent)) if exponent.is_ascii_alphanumeric() => {
                characters.next();
                written.push_mathematics(&format!("^\\mathrm{{{exponent}}}"));
            }
            _ => match (command(MATHEMATICS), command(TEXT)) {
                (Some(command), _) => written.push_mathematics(command),
                (None, Some(command)) => written.push_text(command),
                (None, None) => written.push_text(c.encode_utf8(&mut [0; 4])),
            },
        }
        // LaTeX breaks words after hyphens without a command.
        if breaks && c != '-' && BREAKS.contains(&c) && next.is_some() {
            written.push_text("\\allowbreak{}");
        }
        before = Some(c);
    }
    written.finished()
}

/// Text of LaTeX, whose adjacent commands of mathematics are in one pair of dollars.
#[derive(Default)]
struct LatexText {
    text: String,
    is_in_mathematics: bool,
}

impl LatexText {
    fn push_text(&mut self, text: &str) {
        self.end_mathematics();
        self.text.push_str(text);
    }

    fn push_mathematics(&mut self, command: &str) {
        if !self.is_in_mathematics {
            self.text.push('$');
            self.is_in_mathematics = true;
        } else if command.starts_with(['^', '_', '\'']) {
            // A second exponent needs a base.
            self.text.push_str("{}");
        } else if command.starts_with(|c: char| c.is_alphanumeric()) {
            self.text.push(' ');
        }
        self.text.push_str(command);
    }

    fn end_mathematics(&mut self) {
        if self.is_in_mathematics {
            self.text.push('$');
            self.is_in_mathematics = false;
        }
    }

    fn finished(mut self) -> String {
        self.end_mathematics();
        self.text
    }
}

/// Whether a hyphen between these characters is the sign of a number.
fn is_sign(before: Option<char>, next: Option<char>) -> bool {
    let begins = before.is_none_or(|c| matches!(c, '(' | '[' | '<' | '>' | '=' | '|' | ':'));
    begins && next.is_some_and(|c| c.is_ascii_digit() || c == '.')
}

/// Mantissa and exponent of a number such as `2.1e-4`, with the signs around it.
struct PowerOfTen<'w> {
    before: &'w str,
    mantissa: &'w str,
    exponent: i32,
    after: &'w str,
}

impl<'w> PowerOfTen<'w> {
    fn of(word: &'w str) -> Option<Self> {
        let start = word.find(|c: char| c.is_ascii_digit() || c == '-')?;
        let (before, rest) = word.split_at(start);
        let end = rest.trim_end_matches([',', ';', ')', '.', ':']).len();
        let (number, after) = rest.split_at(end);
        let (mantissa, exponent) = number.split_once('e')?;
        let is_number = mantissa.parse::<f64>().is_ok()
            && mantissa.ends_with(|c: char| c.is_ascii_digit())
            && !before.ends_with(char::is_alphanumeric);
        let exponent = exponent.parse().ok()?;
        is_number.then_some(Self {
            before,
            mantissa,
            exponent,
            after,
        })
    }
}

fn power_of_ten(word: &str) -> Option<String> {
    let PowerOfTen {
        before,
        mantissa,
        exponent,
        after,
    } = PowerOfTen::of(word)?;
    let factor = match mantissa {
        "1" => String::new(),
        _ => format!("{mantissa}\\times"),
    };
    let (before, after) = (escaped_word(before, false), escaped_word(after, false));
    Some(format!("{before}${factor}10^{{{exponent}}}${after}"))
}

/// Whether pdflatex sets the escaped character: ASCII, and the Latin letters with accents.
pub(super) fn is_set_by_pdflatex(c: char) -> bool {
    c.is_ascii()
        || matches!(c, '\u{c0}'..='\u{17f}' | '‘' | '’' | '“' | '”')
            && !matches!(
                c,
                'Ð' | 'ð'
                    | 'Ą'
                    | 'ą'
                    | 'Ę'
                    | 'ę'
                    | 'Į'
                    | 'į'
                    | 'Ų'
                    | 'ų'
                    | 'Ŀ'
                    | 'ŀ'
                    | 'Þ'
                    | 'þ'
                    | 'Đ'
                    | 'đ'
                    | 'Ŋ'
                    | 'ŋ'
                    | 'Ħ'
                    | 'ħ'
                    | 'Ŧ'
                    | 'ŧ'
                    | 'ĸ'
                    | 'ŉ'
                    | 'ſ'
            )
}

/// Widths of the characters from space to tilde in Computer Modern, thousandths of an em.
const WIDTHS: [u16; 95] = [
    333, 278, 500, 833, 500, 833, 778, 278, 389, 389, 500, 778, 278, 333, 278, 500, 500, 500, 500,
    500, 500, 500, 500, 500, 500, 500, 278, 278, 778, 778, 778, 472, 778, 750, 708, 722, 764, 681,
    653, 785, 750, 361, 514, 778, 625, 917, 750, 778, 681, 778, 736, 556, 722, 750, 750, 1028, 750,
    750, 611, 278, 500, 278, 500, 500, 278, 500, 556, 444, 556, 444, 306, 500, 556, 278, 306, 528,
    278, 833, 556, 500, 556, 528, 392, 394, 389, 556, 528, 722, 528, 528, 444, 500, 278, 500, 500,
];
/// Width of a full em, such as of a dash or of a Chinese character.
const EM: u16 = 1000;
/// Width of a character in an exponent.
const EXPONENT_WIDTH: u16 = 500;
/// Width of `×10`.
const TIMES_TEN_WIDTH: u16 = 2300;

fn character_width(c: char) -> u16 {
    match c {
        ' '..='~' => WIDTHS[usize::from(c as u8 - b' ')],
        '−' | '×' | '±' | '≤' | '≥' | '≈' => 778,
        '·' => 278,
        '\u{b0}'..='\u{b9}' | '⁰'..='₉' | 'ᴴ' | 'ᵀ' => 450,
        '\u{c0}'..='\u{24f}' => 750,
        'α'..='ω' => 660,
        'Γ'..='Ω' => 830,
        _ => EM,
    }
}

/// Width of a text on a line, em.
pub(super) fn width_em(text: &str) -> f64 {
    let words: Vec<u32> = text.split(' ').map(word_width).collect();
    let spaces = (words.len() as u32 - 1) * u32::from(character_width(' '));
    f64::from(words.iter().sum::<u32>() + spaces) / f64::from(EM)
}

fn word_width(word: &str) -> u32 {
    if let Some(power) = PowerOfTen::of(word) {
        let parts = [power.before, power.mantissa, power.after];
        let digits = power.exponent.to_string().len() as u32;
        let exponent = u32::from(TIMES_TEN_WIDTH) + digits * u32::from(EXPONENT_WIDTH);
        return parts.map(characters_width).iter().sum::<u32>() + exponent;
    }
    characters_width(word)
}

fn characters_width(text: &str) -> u32 {
    let mut characters = text.chars().peekable();
    let (mut width, mut before) = (0, None);
    while let Some(c) = characters.next() {
        let is_sign = c == '-' && is_sign(before, characters.peek().copied());
        let shown = if is_sign { '−' } else { c };
        width += u32::from(character_width(shown));
        before = Some(c);
    }
    width
}

/// The pieces of a text between which LaTeX may break a line.
pub(super) fn pieces(text: &str) -> Vec<&str> {
    let words = text.split([' ', '\n']);
    words
        .flat_map(|word| match word.chars().count() {
            MIN_BREAKABLE_CHARACTERS.. => word.split_inclusive(BREAKS).collect(),
            _ => vec![word],
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_have_their_commands() {
        for (text, expected) in [
            ("50 % of k_1 & {m} #2", "50 \\% of k\\_1 \\& \\{m\\} \\#2"),
            ("-0.5, f-1 and (-2)", "$-$0.5, f-1 and ($-$2)"),
            ("Σφ² |λ|", "$\\Sigma\\varphi{}^2$ $|\\lambda|$"),
            ("10⁻³", "10$^-{}^3$"),
            ("a^H b", "a$^\\mathrm{H}$ b"),
            ("2.1e11", "$2.1\\times10^{11}$"),
            ("a-e5 1-2e3", "a-e5 1-2e3"),
            ("--full", "-{}-full"),
            ("s²′", "s$^2{}'$"),
            ("(1.7e-4, 1e7)", "($1.7\\times10^{-4}$, $10^{7}$)"),
            ("beam `bar`: \"x\"", "beam \\texttt{bar}: ``x''"),
            ("one ` alone", "one \\textasciigrave{} alone"),
            ("a\nb", "a b"),
        ] {
            assert_eq!(escaped(text), expected);
        }
    }

    #[test]
    fn only_long_words_of_paragraphs_may_be_broken() {
        let path = "measurements/bar/scene.toml";
        assert_eq!(escaped(path), path);
        let breakable = "measurements/\\allowbreak{}bar/\\allowbreak{}scene.\\allowbreak{}toml";
        assert_eq!(escaped_paragraph(path), breakable);
        assert_eq!(escaped_paragraph("N/m"), "N/m");
        assert_eq!(pieces(path), ["measurements/", "bar/", "scene.", "toml"]);
    }

    #[test]
    fn widths_are_those_of_computer_modern() {
        for (text, expected) in [
            ("0.5", 1.278),
            ("-0.5", 2.056),
            ("mm mm", 3.665),
            ("2.1e11", 4.578),
        ] {
            let width = width_em(text);
            assert!((width - expected).abs() < 0.001, "{text}: {width}");
        }
    }
}

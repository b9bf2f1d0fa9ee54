//! Python literals of text, whole numbers, lists, tuples and dictionaries, which describe the type
//! of the elements of an array.

/// Literals within each other. NumPy nests fields a few levels deep; the parser calls itself for
/// each level, so that without a limit a long row of brackets would exhaust the stack.
const MAX_NESTING: usize = 32;

/// A Python literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Literal {
    /// A quoted text.
    Text(String),
    /// A whole number that is not negative.
    Number(usize),
    /// Values in square brackets.
    List(Vec<Literal>),
    /// Values in parentheses.
    Tuple(Vec<Literal>),
    /// Texts and their values in braces.
    Dictionary(Vec<(String, Literal)>),
}

impl Literal {
    /// The whole of `text` as a literal; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let mut parser = Parser { rest: text.trim() };
        let literal = parser.literal(0)?;
        parser.rest.is_empty().then_some(literal)
    }

    /// The value of a key of a dictionary.
    pub fn value(&self, key: &str) -> Option<&Literal> {
        let Literal::Dictionary(entries) = self else {
            return None;
        };
        let entry = entries.iter().find(|(name, _)| name == key);
        entry.map(|(_, value)| value)
    }

    /// The values of a list or tuple.
    pub fn values(&self) -> Option<&[Literal]> {
        match self {
            Literal::List(values) | Literal::Tuple(values) => Some(values),
            _ => None,
        }
    }

    /// The number.
    pub fn number(&self) -> Option<usize> {
        match self {
            Literal::Number(number) => Some(*number),
            _ => None,
        }
    }
}

/// A text that is being parsed.
struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    /// Takes `mark` and the blanks after it from the front.
    fn take(&mut self, mark: char) -> Option<()> {
        self.rest = self.rest.strip_prefix(mark)?.trim_start();
        Some(())
    }

    fn literal(&mut self, depth: usize) -> Option<Literal> {
        if depth > MAX_NESTING {
            return None;
        }
        match self.rest.chars().next()? {
            '\'' | '"' => self.text().map(Literal::Text),
            '(' => {
                self.take('(')?;
                let (mut values, has_comma) = self.values(')', depth)?;
                // Parentheses around one value without a comma make no tuple.
                match (values.len(), has_comma) {
                    (1, false) => values.pop(),
                    _ => Some(Literal::Tuple(values)),
                }
            }
            '[' => {
                self.take('[')?;
                let (values, _) = self.values(']', depth)?;
                Some(Literal::List(values))
            }
            '{' => self.dictionary(depth),
            _ => self.number().map(Literal::Number),
        }
    }

    /// Values up to the closing mark, and whether a comma follows the last one.
    fn values(&mut self, close: char, depth: usize) -> Option<(Vec<Literal>, bool)> {
        let mut values = Vec::new();
        let mut has_comma = false;
        while self.take(close).is_none() {
            if !values.is_empty() && !has_comma {
                return None;
            }
            values.push(self.literal(depth + 1)?);
            has_comma = self.take(',').is_some();
        }
        Some((values, has_comma))
    }

    fn dictionary(&mut self, depth: usize) -> Option<Literal> {
        self.take('{')?;
        let mut entries = Vec::new();
        let mut is_closed = self.take('}').is_some();
        while !is_closed {
            let key = self.text()?;
            self.take(':')?;
            entries.push((key, self.literal(depth + 1)?));
            let has_comma = self.take(',').is_some();
            is_closed = self.take('}').is_some();
            if !is_closed && !has_comma {
                return None;
            }
        }
        Some(Literal::Dictionary(entries))
    }

    fn number(&mut self) -> Option<usize> {
        let end = self.rest.find(|c: char| !c.is_ascii_digit());
        let (digits, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        // Python 2 wrote `3L`.
        self.rest = rest.strip_prefix('L').unwrap_or(rest).trim_start();
        digits.parse().ok()
    }

    fn text(&mut self) -> Option<String> {
        let mut characters = self.rest.chars();
        let quote = characters.next().filter(|c| matches!(c, '\'' | '"'))?;
        let mut text = String::new();
        loop {
            match characters.next()? {
                '\\' => text.push(escaped(&mut characters)?),
                c if c == quote => break,
                c => text.push(c),
            }
        }
        self.rest = characters.as_str().trim_start();
        Some(text)
    }
}

/// The character of an escape sequence after its `\`.
fn escaped(characters: &mut std::str::Chars) -> Option<char> {
    let digits = match characters.next()? {
        'n' => return Some('\n'),
        't' => return Some('\t'),
        'r' => return Some('\r'),
        'x' => 2,
        'u' => 4,
        'U' => 8,
        c @ ('\\' | '\'' | '"') => return Some(c),
        _ => return None,
    };
    let code = characters.as_str().get(..digits)?;
    let code = u32::from_str_radix(code, 16).ok()?;
    characters.nth(digits - 1);
    char::from_u32(code)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> Literal {
        Literal::Text(text.to_owned())
    }

    #[test]
    fn texts_numbers_lists_tuples_and_dictionaries_are_parsed() {
        use Literal::{Dictionary, List, Number, Tuple};
        let cases = [
            ("'<f8'", text("<f8")),
            (r#""it's \'\xe9\u00b2""#, text("it's 'é²")),
            ("( 3 , 4L )", Tuple(vec![Number(3), Number(4)])),
            ("(3,)", Tuple(vec![Number(3)])),
            ("(3)", Number(3)),
            ("[]", List(vec![])),
            (
                "[('a', 'b'),]",
                List(vec![Tuple(vec![text("a"), text("b")])]),
            ),
            ("{'a': 1, }", Dictionary(vec![("a".to_owned(), Number(1))])),
            ("{}", Dictionary(vec![])),
        ];
        for (source, expected) in cases {
            assert_eq!(Literal::parse(source), Some(expected), "{source}");
        }
    }

    #[test]
    fn other_texts_are_no_literals() {
        let deep = "[".repeat(100_000);
        for source in [
            "", "'a", "[1 2]", "[1", "(,)", "-3", "1.5", "{'a'}", "{1: 2}", "'\\x4'", "'\\é'",
            "None", "3 4", &deep,
        ] {
            assert_eq!(Literal::parse(source), None, "{source}");
        }
    }
}

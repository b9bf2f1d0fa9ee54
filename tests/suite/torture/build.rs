//! Universal files from bytes.

/// Header lines of an acceleration record over time named `name`, 1000 samples per second.
pub fn header(name: &str, data_type: i32, points: i64) -> Vec<String> {
    [
        name,
        "NONE",
        "NONE",
        "NONE",
        "NONE",
        "    1         0    1         1 NONE              12  -3 NONE               4   1",
        &format!("{data_type:>10}{points:>10}         1  0.00000E+00  1.00000E-03  0.00000E+00"),
        "        17    0    0    0 Time                 s                   ",
        "        12    0    0    0 Acceleration         m/s2                ",
        "         0    0    0    0 NONE                 NONE                ",
        "         0    0    0    0 NONE                 NONE                ",
    ]
    .map(str::to_owned)
    .to_vec()
}

/// A header with one line changed.
pub fn changed(mut header: Vec<String>, line: usize, text: &str) -> Vec<String> {
    text.clone_into(&mut header[line - 1]);
    header
}

/// A header with values on an uneven abscissa of a type and unit.
pub fn uneven(data_type: i32, points: i64, code: i32, unit: &str) -> Vec<String> {
    let spacing = format!("{data_type:>10}{points:>10}         0  0.00000E+00  0.00000E+00");
    let abscissa = format!("{code:>10}    0    0    0 Label                {unit:<20}");
    changed(
        changed(header("test", data_type, points), 7, &spacing),
        8,
        &abscissa,
    )
}

/// Lines with an end each.
pub fn lines(lines: &[&str], end: &str) -> Vec<u8> {
    lines
        .iter()
        .flat_map(|line| [line, end].concat().into_bytes())
        .collect()
}

/// A text dataset.
pub fn text(header: &[String], rows: &[&str], end: &str) -> Vec<u8> {
    let mut all = vec!["    -1", "    58"];
    all.extend(header.iter().map(String::as_str));
    all.extend(rows);
    all.push("    -1");
    lines(&all, end)
}

/// A text dataset named `test` with rows of numbers.
pub fn rows(data_type: i32, points: i64, rows: &[&str]) -> Vec<u8> {
    text(&header("test", data_type, points), rows, "\n")
}

/// How a binary dataset is written.
#[derive(Clone, Copy)]
pub struct Binary {
    pub order: i32,
    pub float: i32,
    /// The byte count as stated; the true one when `None`.
    pub count: Option<i64>,
    pub end: &'static str,
    /// What stands between the bytes and the end of the delimiter's line.
    pub tail: &'static str,
}

impl Default for Binary {
    fn default() -> Self {
        Self {
            order: 1,
            float: 2,
            count: None,
            end: "\n",
            tail: "    -1\n",
        }
    }
}

/// A binary dataset around bytes.
pub fn binary(header: &[String], block: &[u8], form: Binary) -> Vec<u8> {
    let count = form.count.unwrap_or(block.len() as i64);
    let (order, float) = (form.order, form.float);
    let first = format!(
        "    58b{order:>6}{float:>6}          11{count:>12}     0     0           0           0"
    );
    let mut all = vec!["    -1", &first];
    all.extend(header.iter().map(String::as_str));
    [
        lines(&all, form.end),
        block.to_vec(),
        form.tail.as_bytes().to_vec(),
    ]
    .concat()
}

/// Bytes of numbers of 32 bits.
pub fn singles(values: &[f32], little: bool) -> Vec<u8> {
    let bytes = |v: &f32| {
        if little {
            v.to_le_bytes()
        } else {
            v.to_be_bytes()
        }
    };
    values.iter().flat_map(bytes).collect()
}

/// Bytes of numbers of 64 bits.
pub fn doubles(values: &[f64], little: bool) -> Vec<u8> {
    let bytes = |v: &f64| {
        if little {
            v.to_le_bytes()
        } else {
            v.to_be_bytes()
        }
    };
    values.iter().flat_map(bytes).collect()
}

/// A good function named `survivor` with the values 4.5 and -2.
pub fn survivor() -> Vec<u8> {
    text(&header("survivor", 4, 2), &["  4.5 -2.0"], "\n")
}

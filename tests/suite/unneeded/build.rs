//! Universal files in text, as the tests of parts that are not needed damage them.

use std::fmt::Write as _;

use num_complex::Complex64;

pub const LINES: usize = 141;

/// One dataset 58 in text: function type, record 6 behind it, abscissa and ordinate records,
/// values.
pub struct Function<'a> {
    pub kind: usize,
    pub points: &'a str,
    pub numerator: &'a str,
    pub denominator: &'a str,
    pub values: Vec<f64>,
}

pub const RESPONSE: &str = "        12    0    0    0 Acceleration         m/s2                ";
pub const FORCE: &str = "        13    0    0    0 Excit Force          N                   ";
pub const NOTHING: &str = "         0    0    0    0 NONE                 NONE                ";

impl Function<'_> {
    /// The dataset.
    pub fn text(&self) -> String {
        let is_time = self.kind == 1;
        let is_complex = self.values.len() == 2 * LINES;
        let (count, code) = match is_complex {
            true => (LINES, 5),
            false => (self.values.len(), 2),
        };
        let (axis, spacing) = match is_time {
            true => (
                "        17    0    0    0 Time                 s                   ",
                "  0.00000E+00  1.95313E-03",
            ),
            false => (
                "        18    0    0    0 Frequency            Hz                  ",
                "  5.00000E+00  2.50000E-01",
            ),
        };
        let mut text = "    -1\n    58\n".to_owned() + &"NONE\n".repeat(5);
        let points = self.points;
        writeln!(text, "{:>5}         0    0         0 {points}", self.kind).unwrap();
        writeln!(
            text,
            "{code:>10}{count:>10}         1{spacing}  0.00000E+00"
        )
        .unwrap();
        for line in [axis, self.numerator, self.denominator, NOTHING] {
            writeln!(text, "{line}").unwrap();
        }
        for row in self.values.chunks(6) {
            let row: String = row.iter().map(|value| format!("{value:>13.5e}")).collect();
            writeln!(text, "{row}").unwrap();
        }
        text + "    -1\n"
    }
}

/// Accelerance of one mode, 20 Hz and 1 %, times a component of its shape.
pub fn accelerance(shape: f64) -> Vec<f64> {
    let omega_n = 20.0 * std::f64::consts::TAU;
    let value = |line: usize| {
        let omega = (5.0 + 0.25 * line as f64) * std::f64::consts::TAU;
        let dynamic = Complex64::new(omega_n.powi(2) - omega.powi(2), 0.02 * omega_n * omega);
        let noise = 1e-6 * ((7 * line) % 11) as f64 * shape;
        -shape * omega.powi(2) / dynamic + noise
    };
    let values = (0..LINES).map(value);
    values.flat_map(|value| [value.re, value.im]).collect()
}

pub fn points(response: usize) -> String {
    format!("NONE      {response:>10}   3 NONE               1   3")
}

/// Three accelerances of one mode.
pub fn frfs() -> String {
    let function = |(node, shape): (usize, f64)| {
        let frf = Function {
            kind: 4,
            points: &points(node),
            numerator: RESPONSE,
            denominator: FORCE,
            values: accelerance(shape),
        };
        frf.text()
    };
    [(1, 1.0), (2, 0.6), (3, -0.8)].map(function).concat()
}

pub fn coherence(node: usize, value: impl Fn(usize) -> f64) -> String {
    let function = Function {
        kind: 6,
        points: &points(node),
        numerator: NOTHING,
        denominator: NOTHING,
        values: (0..LINES).map(value).collect(),
    };
    function.text()
}

pub fn dataset(lines: &[&str]) -> String {
    format!("    -1\n{}\n    -1\n", lines.join("\n"))
}

pub const NODES: [&str; 4] = [
    "    15",
    "         1         0         0         8  0.00000E+00  0.00000E+00  0.00000E+00",
    "         2         0         0         8  1.00000E+00  0.00000E+00  0.00000E+00",
    "         3         0         0         8  2.00000E+00  0.00000E+00  0.00000E+00",
];

pub fn record(node: usize, numerator: &str, version: usize, values: Vec<f64>) -> String {
    let name = if node == 3 {
        "Tacho     "
    } else {
        "NONE      "
    };
    let direction = if node == 3 { 0 } else { 3 };
    let function = Function {
        kind: 1,
        points: &format!("{name}{node:>10}{direction:>4} NONE               0   0"),
        numerator,
        denominator: NOTHING,
        values,
    };
    let text = function.text();
    let head = format!("    1         0{version:>5}         0 ");
    text.replacen("    1         0    0         0 ", &head, 1)
}

/// A pulse and the response of 20 Hz and 2 % to it.
pub fn hit_values(is_force: bool, seed: usize) -> Vec<f64> {
    let value = |k: usize| {
        let t = (k as f64 - 50.0) * 1.95313e-3;
        let noise = 1e-3 * ((13 * k + 5 * seed) % 17) as f64;
        let omega = 20.0 * std::f64::consts::TAU;
        let pulse = match k {
            50 => 50.0,
            51 => 100.0,
            52 => 50.0,
            _ => 0.0,
        };
        let response = match k > 50 {
            true => 40.0 * (-0.02 * omega * t).exp() * (omega * t).sin(),
            false => 0.0,
        };
        noise + if is_force { pulse } else { response }
    };
    (0..1024).map(value).collect()
}

pub fn hits(tacho: bool) -> String {
    let force = "        13    0    0    0 Force                N                   ";
    let volt = "         1    0    0    0 Tacho                V                   ";
    let mut text = String::new();
    for version in 1..=3 {
        text += &record(1, force, version, hit_values(true, version));
        text += &record(2, RESPONSE, version, hit_values(false, version));
        if tacho {
            text += &record(3, volt, version, hit_values(true, 4));
        }
    }
    text
}

/// A damaged mode beside two good ones, at two nodes.
pub fn modes(damaged: bool) -> String {
    let mode = |number: usize, hz: f64, values: [f64; 2]| {
        let head = format!("         2         4{:>10}{number:>10}", 0);
        let row = |value: f64| format!("  0.00000E+00  0.00000E+00{value:>13.5e}");
        let [a, b] = values.map(row);
        dataset(&[
            "    55",
            "NONE",
            "NONE",
            "NONE",
            "NONE",
            "NONE",
            "         1         2         2         8         2         3",
            &head,
            &format!("{hz:>13.5e}  1.00000E+00  1.00000E-02  0.00000E+00"),
            "         1",
            &a,
            "         2",
            &b,
        ])
    };
    let third = mode(3, 30.0, [1.0, -1.0]);
    let third = match damaged {
        true => third.replacen("         2         4", "         2         q", 1),
        false => third,
    };
    mode(1, 10.0, [1.0, 0.5]) + &mode(2, 20.0, [0.5, -1.0]) + &third
}

//! Unit texts are read as products of powers of known symbols.
//!
//! `m/s^2`, `m/s**2`, `m/s²`, `m.s-2`, `mm/sec/sec`, `(g)/lbf` and `kgf` are read from one table
//! of symbols, with SI prefixes where a symbol takes them. Case counts, for it tells milli from
//! mega; a text that is unknown as it stands is tried without case (`MM/S2`).
//!
//! Three symbols mean what analysers mean by them: `g` is the acceleration of free fall and not
//! the gram, `lb` is a force, and `ms-2` is m s⁻².

/// Powers of the base dimensions: length, mass, time, angle, current, temperature, level.
pub(super) type Dimension = [i8; 7];

pub(super) const NONE: Dimension = [0; 7];
const LENGTH: Dimension = [1, 0, 0, 0, 0, 0, 0];
const MASS: Dimension = [0, 1, 0, 0, 0, 0, 0];
pub(super) const TIME: Dimension = [0, 0, 1, 0, 0, 0, 0];
pub(super) const ANGLE: Dimension = [0, 0, 0, 1, 0, 0, 0];
pub(super) const CURRENT: Dimension = [0, 0, 0, 0, 1, 0, 0];
pub(super) const TEMPERATURE: Dimension = [0, 0, 0, 0, 0, 1, 0];
/// Decibels, which are no factor of any unit.
const LEVEL: Dimension = [0, 0, 0, 0, 0, 0, 1];
pub(super) const DISPLACEMENT: Dimension = LENGTH;
pub(super) const VELOCITY: Dimension = [1, 0, -1, 0, 0, 0, 0];
pub(super) const ACCELERATION: Dimension = [1, 0, -2, 0, 0, 0, 0];
pub(super) const FORCE: Dimension = [1, 1, -2, 0, 0, 0, 0];
pub(super) const RECEPTANCE: Dimension = [0, -1, 2, 0, 0, 0, 0];
pub(super) const MOBILITY: Dimension = [0, -1, 1, 0, 0, 0, 0];
pub(super) const ACCELERANCE: Dimension = [0, -1, 0, 0, 0, 0, 0];
pub(super) const ENERGY: Dimension = [2, 1, -2, 0, 0, 0, 0];
pub(super) const POWER: Dimension = [2, 1, -3, 0, 0, 0, 0];
pub(super) const PRESSURE: Dimension = [-1, 1, -2, 0, 0, 0, 0];
pub(super) const FREQUENCY: Dimension = [0, 0, -1, 0, 0, 0, 0];
pub(super) const ROTATION: Dimension = [0, 0, -1, 1, 0, 0, 0];
pub(super) const CHARGE: Dimension = [0, 0, 1, 0, 1, 0, 0];
pub(super) const VOLTAGE: Dimension = [2, 1, -3, 0, -1, 0, 0];
const RESISTANCE: Dimension = [2, 1, -3, 0, -2, 0, 0];

/// A unit as a factor to SI and a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measure {
    pub dimension: Dimension,
    pub to_si: f64,
}

/// Names of one unit.
struct Symbol {
    names: &'static [&'static str],
    dimension: Dimension,
    to_si: f64,
    /// Whether SI prefixes stand before its names.
    prefixed: bool,
}

const fn symbol(names: &'static [&'static str], dimension: Dimension, to_si: f64) -> Symbol {
    Symbol {
        names,
        dimension,
        to_si,
        prefixed: false,
    }
}

const fn prefixed(names: &'static [&'static str], dimension: Dimension, to_si: f64) -> Symbol {
    Symbol {
        prefixed: true,
        ..symbol(names, dimension, to_si)
    }
}

const FREE_FALL: f64 = 9.806_65;
const INCH: f64 = 0.025_4;
const POUND: f64 = 0.453_592_37;
const POUND_FORCE: f64 = 4.448_221_615_260_5;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Every symbol. Factors are exact by definition, those with π apart.
const SYMBOLS: &[Symbol] = &[
    prefixed(&["N", "Newton", "Newtons", "newton", "newtons"], FORCE, 1.0),
    symbol(&["kgf", "kp", "kilopond"], FORCE, FREE_FALL),
    symbol(&["gf", "pond"], FORCE, 1e-3 * FREE_FALL),
    symbol(
        &["lbf", "lb", "lbs", "lbsf", "#f", "pound", "pounds"],
        FORCE,
        POUND_FORCE,
    ),
    symbol(&["ozf"], FORCE, POUND_FORCE / 16.0),
    symbol(&["kip", "kips", "klbf"], FORCE, 4_448.221_615_260_5),
    prefixed(&["dyn", "dyne"], FORCE, 1e-5),
    prefixed(&["m", "meter", "meters", "metre", "metres"], LENGTH, 1.0),
    symbol(&["micron", "microns"], LENGTH, 1e-6),
    symbol(&["in", "inch", "inches"], LENGTH, INCH),
    symbol(&["uin", "µin"], LENGTH, 1e-6 * INCH),
    symbol(&["mil", "mils"], LENGTH, 1e-3 * INCH),
    symbol(&["ft", "foot", "feet"], LENGTH, 12.0 * INCH),
    symbol(&["ips"], VELOCITY, INCH),
    prefixed(&["g", "gn", "G"], ACCELERATION, FREE_FALL),
    prefixed(&["Gal", "gal"], ACCELERATION, 1e-2),
    prefixed(&["s", "sec", "secs", "second", "seconds"], TIME, 1.0),
    symbol(&["min", "minute", "minutes"], TIME, 60.0),
    symbol(&["h", "hr", "hour", "hours"], TIME, 3600.0),
    prefixed(&["Hz", "Hertz", "hertz", "cps"], FREQUENCY, 1.0),
    prefixed(&["rad"], ANGLE, 1.0),
    symbol(&["deg", "degree", "degrees", "°"], ANGLE, DEGREE),
    symbol(
        &["rev", "r", "turn", "cycle", "cycles"],
        ANGLE,
        std::f64::consts::TAU,
    ),
    symbol(
        &["rpm", "RPM", "cpm"],
        ROTATION,
        std::f64::consts::TAU / 60.0,
    ),
    symbol(&["kg"], MASS, 1.0),
    symbol(&["gram", "grams"], MASS, 1e-3),
    symbol(&["lbm"], MASS, POUND),
    symbol(&["slug"], MASS, POUND_FORCE / (12.0 * INCH)),
    symbol(&["Nm"], ENERGY, 1.0),
    symbol(&["mNm", "Nmm"], ENERGY, 1e-3),
    symbol(&["kNm"], ENERGY, 1e3),
    prefixed(&["J"], ENERGY, 1.0),
    prefixed(&["W"], POWER, 1.0),
    prefixed(&["Pa", "Pascal", "pascal"], PRESSURE, 1.0),
    prefixed(&["bar"], PRESSURE, 1e5),
    symbol(&["psi"], PRESSURE, POUND_FORCE / (INCH * INCH)),
    symbol(&["ksi"], PRESSURE, 1e3 * POUND_FORCE / (INCH * INCH)),
    prefixed(&["V", "Volt", "Volts", "volt", "volts"], VOLTAGE, 1.0),
    prefixed(&["A", "Ampere", "ampere"], CURRENT, 1.0),
    prefixed(&["C"], CHARGE, 1.0),
    prefixed(&["Ohm", "ohm", "Ω"], RESISTANCE, 1.0),
    symbol(&["K", "degC", "°C", "degK"], TEMPERATURE, 1.0),
    symbol(&["degF", "°F"], TEMPERATURE, 5.0 / 9.0),
    prefixed(&["strain", "ε"], NONE, 1.0),
    symbol(&["ue", "uE"], NONE, 1e-6),
    symbol(&["%"], NONE, 1e-2),
    symbol(&["‰"], NONE, 1e-3),
    symbol(&["ppm"], NONE, 1e-6),
    symbol(&["dB", "dBA"], LEVEL, 1.0),
];

/// SI prefixes.
const PREFIXES: [(&str, f64); 18] = [
    ("milli", 1e-3),
    ("micro", 1e-6),
    ("nano", 1e-9),
    ("centi", 1e-2),
    ("kilo", 1e3),
    ("mega", 1e6),
    ("da", 10.0),
    ("k", 1e3),
    ("h", 1e2),
    ("d", 1e-1),
    ("c", 1e-2),
    // Before M, for `MM/S2` is in millimetres.
    ("m", 1e-3),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
    ("M", 1e6),
    ("G", 1e9),
];

/// Reads a unit text; `None` where a part of it is no known symbol.
pub(super) fn measure(text: &str) -> Option<Measure> {
    if text.len() > MAX_LENGTH {
        return None;
    }
    // The Greek letter mu and the micro sign look alike.
    let text = text.trim().replace('\u{3bc}', "\u{b5}");
    let read = |case_counts| {
        let mut reader = Reader {
            rest: &text,
            case_counts,
        };
        let product = reader.product(0)?;
        let is_usable = product.to_si.is_normal() && reader.rest.is_empty();
        is_usable.then_some(product)
    };
    read(true).or_else(|| read(false))
}

/// Longest text of a unit, bytes: a field of a header has 20 to 80.
const MAX_LENGTH: usize = 200;
/// Brackets may stand in each other as deeply as this. Deeper: a text of brackets alone overflows
/// the stack. Shallower: `((m/s^2)/N)` is not read.
const MAX_DEPTH: usize = 8;

/// A cursor on a unit text.
struct Reader<'a> {
    rest: &'a str,
    case_counts: bool,
}

impl<'a> Reader<'a> {
    /// Powers with `*`, `/`, `.`, `·`, `-` or a blank between them, from left to right.
    fn product(&mut self, depth: usize) -> Option<Measure> {
        let mut product = self.power(depth)?;
        loop {
            let before = self.rest;
            self.rest = self.rest.trim_start();
            let is_over = self.skip(&["/"]);
            if !is_over {
                self.skip(&["*", "·", "⋅", "×", ".", "-"]);
            }
            self.rest = self.rest.trim_start();
            if self.rest.is_empty() || self.rest.starts_with([')', ']']) {
                return (!is_over).then_some(product);
            }
            // `(m/s2)(N)` is a quotient in some files.
            let is_adjacent = self.rest.len() == before.len();
            let factor = self.power(depth).filter(|_| !is_adjacent)?;
            product = match is_over {
                true => product.over(factor)?,
                false => product.times(factor)?,
            };
        }
    }

    /// A symbol or a bracket with its exponent.
    fn power(&mut self, depth: usize) -> Option<Measure> {
        for (open, close) in [("(", ")"), ("[", "]")] {
            if depth < MAX_DEPTH && self.skip(&[open]) {
                self.rest = self.rest.trim_start();
                let inside = self.product(depth + 1)?;
                self.skip(&[close]).then_some(())?;
                return inside.raised(self.exponent()?);
            }
        }
        if self.rest.starts_with("1/") {
            self.rest = &self.rest[1..];
            return Some(Measure {
                dimension: NONE,
                to_si: 1.0,
            });
        }
        let is_letter = |c: char| c.is_alphabetic() || "°%‰#".contains(c);
        let end = self.rest.find(|c| !is_letter(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        let exponent = self.exponent()?;
        let per_second = name.strip_suffix('s').filter(|_| exponent < 0);
        let length = per_second.and_then(|name| self.symbol(name));
        if let Some(length) = length.filter(|length| length.dimension == LENGTH) {
            return length.times(self.symbol("s")?.raised(exponent)?);
        }
        self.symbol(name)?.raised(exponent)
    }

    /// `2`, `^2`, `**2`, `²`, `-2`, `^(-2)`; 1 where there is none.
    fn exponent(&mut self) -> Option<i8> {
        let before = self.rest;
        let is_marked = self.skip(&["**", "^"]);
        let is_bracketed = is_marked && self.skip(&["("]);
        let mut digits = String::new();
        let mut characters = self.rest.chars();
        while let Some(digit) = characters.clone().next().and_then(plain) {
            if digit == '-' && !digits.is_empty() {
                break;
            }
            digits.push(digit);
            characters.next();
        }
        self.rest = characters.as_str();
        if is_bracketed {
            self.skip(&[")"]).then_some(())?;
        }
        match digits.as_str() {
            "" if is_marked => None,
            "" => Some(1),
            // A hyphen between two symbols.
            "-" if !is_marked => {
                self.rest = before;
                Some(1)
            }
            digits => digits.parse().ok().filter(|power| (-9..=9).contains(power)),
        }
    }

    fn symbol(&self, name: &str) -> Option<Measure> {
        let is_named = |symbol: &&Symbol, name: &str| {
            let mut names = symbol.names.iter();
            names.any(|known| match self.case_counts {
                true => *known == name,
                false => known.eq_ignore_ascii_case(name),
            })
        };
        let whole = SYMBOLS.iter().find(|symbol| is_named(symbol, name));
        if let Some(symbol) = whole {
            return Some(Measure {
                dimension: symbol.dimension,
                to_si: symbol.to_si,
            });
        }
        PREFIXES.iter().find_map(|(prefix, factor)| {
            let starts = match self.case_counts {
                true => name.starts_with(prefix),
                false => {
                    (name.get(..prefix.len())).is_some_and(|head| head.eq_ignore_ascii_case(prefix))
                }
            };
            let stem = name.get(prefix.len()..).filter(|_| starts)?;
            // Without case M is milli or mega, unless mega is not in use.
            let is_milli = |symbol: &Symbol| {
                let never_mega = [LENGTH, TIME, ACCELERATION];
                let is_ambiguous = prefix.eq_ignore_ascii_case("m");
                self.case_counts || !is_ambiguous || never_mega.contains(&symbol.dimension)
            };
            let mut symbols = SYMBOLS.iter().filter(|symbol| symbol.prefixed);
            let symbol = symbols.find(|symbol| is_named(symbol, stem) && is_milli(symbol))?;
            Some(Measure {
                dimension: symbol.dimension,
                to_si: factor * symbol.to_si,
            })
        })
    }

    /// Skips the first of these texts that stands here.
    fn skip(&mut self, texts: &[&str]) -> bool {
        let found = texts.iter().find_map(|text| self.rest.strip_prefix(text));
        self.rest = found.unwrap_or(self.rest);
        found.is_some()
    }
}

/// A digit or sign of an exponent, raised or not.
fn plain(character: char) -> Option<char> {
    match character {
        '0'..='9' | '-' => Some(character),
        '⁻' | '−' => Some('-'),
        '¹' => Some('1'),
        '²' => Some('2'),
        '³' => Some('3'),
        '⁴' => Some('4'),
        _ => None,
    }
}

impl Measure {
    pub fn times(self, other: Self) -> Option<Self> {
        let mut dimension = self.dimension;
        for (power, more) in dimension.iter_mut().zip(other.dimension) {
            *power = power.checked_add(more)?;
        }
        Some(Self {
            dimension,
            to_si: self.to_si * other.to_si,
        })
    }

    /// A quotient of the factors and no product with a reciprocal, which would round twice.
    fn over(self, other: Self) -> Option<Self> {
        let to_si = self.to_si / other.to_si;
        let inverse = Self {
            to_si: 1.0,
            ..other
        };
        let dimension = self.times(inverse.raised(-1)?)?.dimension;
        Some(Self { dimension, to_si })
    }

    fn raised(self, exponent: i8) -> Option<Self> {
        let mut dimension = self.dimension;
        for power in &mut dimension {
            *power = power.checked_mul(exponent)?;
        }
        Some(Self {
            dimension,
            to_si: self.to_si.powi(i32::from(exponent)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(text: &str, dimension: Dimension) -> f64 {
        let measure = measure(text).unwrap_or_else(|| panic!("{text} is not read"));
        assert_eq!(measure.dimension, dimension, "{text}");
        measure.to_si
    }

    #[test]
    fn spellings_of_one_unit_have_one_factor() {
        for (dimension, to_si, texts) in [
            (
                ACCELERATION,
                1.0,
                "m/s2 m/s^2 m/s**2 m/s² m/s/s m/sec^2 m/sec2 m/sec/sec m.s-2 m·s⁻² m*s^-2 ms-2 ms^-2 \
                 (m/s^2) [m/s²] m/(s^2) m/(s*s) meter/second^2 metre/sec**2 M/S2 M/SEC^2",
            ),
            (ACCELERATION, 1e-3, "mm/s2 mm/s^2 mm/s² mms-2 MM/S2 mm/sec²"),
            (
                ACCELERATION,
                0.0254,
                "in/s2 in/s^2 in/s² in/sec^2 inch/s**2 IN/S2 in/sec/sec",
            ),
            (ACCELERATION, 9.80665, "g G gn"),
            (ACCELERATION, 9.80665e-3, "mg mG"),
            (ACCELERATION, 9.80665e-6, "ug µg μg"),
            (VELOCITY, 1e-3, "mm/s mm/sec mm.s-1 mms-1 MM/S"),
            (DISPLACEMENT, 1e-6, "um µm μm micron UM"),
            (DISPLACEMENT, 2.54e-5, "mil mils"),
            (FORCE, 1.0, "N Newton newtons NEWTON kg.m/s2 kg*m/s^2"),
            (FORCE, 10.0, "daN"),
            (FORCE, 1e3, "kN KN"),
            (FORCE, 9.80665, "kgf kp"),
            (FORCE, 4.4482216152605, "lbf lb LBF lbs"),
        ] {
            for text in texts.split_whitespace() {
                let got = factor(text, dimension);
                assert!((got / to_si - 1.0).abs() < 1e-12, "{text}: {got}");
            }
        }
        let with_blank = factor("m s-2", ACCELERATION);
        assert!((with_blank - 1.0).abs() < 1e-15);
    }

    #[test]
    fn unknown_texts_are_no_units() {
        for text in [
            "",
            " ",
            "EU",
            "?",
            "furlong",
            "m/s2 rms",
            "m/s^",
            "m/",
            "/s",
            "(m",
            "m)",
            "m//s",
            "1",
            "5",
            "m^99",
            "(m/s2)(N)",
            "MHZ",
            "MPA",
            "m^(2",
            "acc",
            "NONE",
            "-",
            "*",
            "m/s^2/EU",
            "((((((((((m))))))))))",
            "\u{fffd}",
        ] {
            assert_eq!(measure(text), None, "{text}");
        }
        assert_eq!(measure(&"(".repeat(100_000)), None);
        assert_eq!(measure(&"m*".repeat(100_000)), None);
    }

    #[test]
    fn every_name_is_read_as_itself() {
        for symbol in SYMBOLS {
            for name in symbol.names {
                let same = (symbol.to_si / factor(name, symbol.dimension) - 1.0).abs();
                assert!(same < 1e-15, "{name}");
            }
        }
    }
}

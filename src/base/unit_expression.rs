//! Parser of unit expressions (`N·m/rad`, `kg m^2`) to an SI factor and a dimension.

use std::f64::consts::{PI, TAU};

use super::quantity_kind::Dimension;

/// A unit expression being read: factors joined by `·`, `*`, a space or `/`, left to right, with one level of brackets.
pub(super) struct UnitParser<'a> {
    rest: &'a str,
    factor: f64,
    dimension: Dimension,
}

impl<'a> UnitParser<'a> {
    /// Factor to SI and dimension, or the part that is not known.
    pub(super) fn parse(text: &'a str) -> Result<(f64, Dimension), String> {
        let mut unit = UnitParser {
            rest: text,
            factor: 1.0,
            dimension: Dimension::DIMENSIONLESS,
        };
        let (mut below, mut bracket) = (false, None);
        loop {
            unit.rest = unit.rest.trim_start();
            let Some(next) = unit.rest.chars().next() else {
                break;
            };
            let single = &unit.rest[..next.len_utf8()];
            match next {
                '·' | '⋅' | '*' => unit.skip(single),
                '/' if !below => {
                    below = true;
                    unit.skip(single);
                    continue;
                }
                '(' if bracket.is_none() => {
                    bracket = Some(below);
                    below = false;
                    unit.skip(single);
                }
                ')' if bracket.is_some() => {
                    bracket = None;
                    unit.skip(single);
                }
                '1' => {
                    unit.skip(single);
                    below = false;
                }
                _ => {
                    let inverse = below != bracket.unwrap_or(false);
                    unit.factor_of(inverse).ok_or_else(|| unit.word())?;
                    below = false;
                }
            }
        }
        if below || bracket.is_some() || unit.factor == 0.0 || !unit.factor.is_finite() {
            return Err(text.to_string());
        }
        Ok((unit.factor, unit.dimension))
    }

    fn skip(&mut self, part: &str) {
        self.rest = &self.rest[part.len()..];
    }

    /// The word at the front, as far as it could be one symbol.
    fn word(&self) -> String {
        let length = self.word_length();
        if length == 0 {
            self.rest.to_string()
        } else {
            self.rest[..length].to_string()
        }
    }

    fn word_length(&self) -> usize {
        self.rest
            .find(|c: char| !(c.is_alphabetic() || matches!(c, '°' | '′' | '″' | 'µ')))
            .unwrap_or(self.rest.len())
    }

    /// Takes one symbol with its power from the front.
    fn factor_of(&mut self, inverse: bool) -> Option<()> {
        let length = self.word_length();
        let (factor, dimension) = symbol(&self.rest[..length])?;
        let (power, used) = power(&self.rest[length..])?;
        self.rest = &self.rest[length + used..];
        let power = if inverse { -power } else { power };
        self.factor *= factor.powi(i32::from(power));
        self.dimension = self.dimension.times(dimension, power)?;
        Some(())
    }
}

/// The power after a symbol (`²`, `^2`, `2`, `⁻¹`, `^-1`, `-1`; 1 where there is none) and the bytes it takes.
fn power(text: &str) -> Option<(i8, usize)> {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let caret = usize::from(text.starts_with('^'));
    let mut used = caret;
    let mut minus = false;
    let mut digits = String::new();
    for c in text[caret..].chars() {
        match c {
            '-' | '−' | '⁻' if used == caret => minus = true,
            '0'..='9' => digits.push(c),
            _ => match RAISED.chars().position(|raised| raised == c) {
                Some(digit) => digits.push_str(&digit.to_string()),
                None => break,
            },
        }
        used += c.len_utf8();
    }
    if used == 0 {
        return Some((1, 0));
    }
    let power: i8 = digits.parse().ok().filter(|p| (1..=9).contains(p))?;
    Some((if minus { -power } else { power }, used))
}

/// Unit symbols: factor to SI, powers of m, kg, s, rad, and whether prefixes go before them.
const SYMBOLS: &[(&str, f64, [i8; 4], bool)] = &[
    ("m", 1.0, [1, 0, 0, 0], true),
    ("g", 1e-3, [0, 1, 0, 0], true),
    ("s", 1.0, [0, 0, 1, 0], true),
    ("rad", 1.0, [0, 0, 0, 1], true),
    ("N", 1.0, [1, 1, -2, 0], true),
    ("Pa", 1.0, [-1, 1, -2, 0], true),
    ("J", 1.0, [2, 1, -2, 0], true),
    ("W", 1.0, [2, 1, -3, 0], true),
    ("Hz", TAU, [0, 0, -1, 1], true),
    ("Nm", 1.0, [2, 1, -2, 0], true),
    ("Nmm", 1e-3, [2, 1, -2, 0], false),
    ("Ncm", 1e-2, [2, 1, -2, 0], false),
    ("bar", 1e5, [-1, 1, -2, 0], true),
    ("t", 1e3, [0, 1, 0, 0], false),
    ("min", 60.0, [0, 0, 1, 0], false),
    ("h", 3600.0, [0, 0, 1, 0], false),
    ("rev", TAU, [0, 0, 0, 1], false),
    ("turn", TAU, [0, 0, 0, 1], false),
    ("rpm", TAU / 60.0, [0, 0, -1, 1], false),
    ("deg", PI / 180.0, [0, 0, 0, 1], false),
    ("°", PI / 180.0, [0, 0, 0, 1], false),
    ("arcmin", PI / 10_800.0, [0, 0, 0, 1], false),
    ("′", PI / 10_800.0, [0, 0, 0, 1], false),
    ("arcsec", PI / 648_000.0, [0, 0, 0, 1], false),
    ("″", PI / 648_000.0, [0, 0, 0, 1], false),
    // The inch, the foot and the pound are exact by the agreement of 1959, the pound-force with g = 9.80665 m/s².
    ("in", 0.0254, [1, 0, 0, 0], false),
    ("inch", 0.0254, [1, 0, 0, 0], false),
    ("ft", 0.3048, [1, 0, 0, 0], false),
    ("lb", 0.453_592_37, [0, 1, 0, 0], false),
    ("lbm", 0.453_592_37, [0, 1, 0, 0], false),
    ("lbf", 0.453_592_37 * 9.80665, [1, 1, -2, 0], false),
    ("kgf", 9.80665, [1, 1, -2, 0], false),
    (
        "psi",
        0.453_592_37 * 9.80665 / (0.0254 * 0.0254),
        [-1, 1, -2, 0],
        false,
    ),
];

/// SI prefixes; micro is written µ (U+00B5), μ (U+03BC) or u.
const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("u", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
    ("T", 1e12),
];

/// A unit's factor to SI and its dimension.
fn symbol(word: &str) -> Option<(f64, Dimension)> {
    let find = |name: &str| SYMBOLS.iter().find(|row| row.0 == name);
    if let Some(row) = find(word) {
        return Some((row.1, Dimension(row.2)));
    }
    PREFIXES.iter().find_map(|(prefix, factor)| {
        let row = find(word.strip_prefix(prefix)?)?;
        row.3.then_some((factor * row.1, Dimension(row.2)))
    })
}

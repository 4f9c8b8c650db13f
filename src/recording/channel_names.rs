//! Channel names with a unit in them: `acc [g]`, `Force (N)`, `Kraft / N`, `accel_x_g`.

/// Units logs name, as written there.
const UNITS: &[&str] = &[
    "s",
    "sec",
    "secs",
    "second",
    "seconds",
    "sekunden",
    "ms",
    "msec",
    "us",
    "usec",
    "µs",
    "μs",
    "ns",
    "min",
    "h",
    "hz",
    "khz",
    "rpm",
    "1/min",
    "g",
    "mg",
    "m/s2",
    "m/s^2",
    "m/s²",
    "m/s**2",
    "m/s/s",
    "mm/s2",
    "mm/s^2",
    "mm/s²",
    "m/s",
    "mm/s",
    "cm/s",
    "in/s",
    "m",
    "cm",
    "mm",
    "µm",
    "μm",
    "um",
    "nm",
    "in",
    "mil",
    "n",
    "kn",
    "mn",
    "lbf",
    "nm",
    "n·m",
    "n*m",
    "n.m",
    "knm",
    "v",
    "mv",
    "µv",
    "uv",
    "a",
    "ma",
    "pa",
    "kpa",
    "mpa",
    "bar",
    "mbar",
    "°c",
    "degc",
    "deg c",
    "k",
    "°f",
    "deg",
    "°",
    "rad",
    "mrad",
    "rad/s",
    "deg/s",
    "°/s",
    "dps",
    "%",
    "um/m",
    "µm/m",
    "μm/m",
    "ustrain",
    "µε",
    "w",
    "kw",
    "j",
    "db",
    "-",
    "[-]",
    "kg",
    "l/min",
    "m³/h",
    "g/n",
    "(m/s²)/n",
    "m/s²/n",
    "m/s2/n",
    "m/n",
    "volt",
    "volts",
    "counts",
];

/// Units after the last `_` of a name, distinguished from words by their case, and their displayed form.
const UNIT_SUFFIXES: &[(&str, &str)] = &[
    ("s", "s"),
    ("sec", "s"),
    ("ms", "ms"),
    ("us", "us"),
    ("ns", "ns"),
    ("min", "min"),
    ("g", "g"),
    ("mg", "mg"),
    ("mps2", "m/s²"),
    ("ms2", "m/s²"),
    ("m_s2", "m/s²"),
    ("mm_s", "mm/s"),
    ("m_s", "m/s"),
    ("m", "m"),
    ("mm", "mm"),
    ("um", "µm"),
    ("N", "N"),
    ("kN", "kN"),
    ("Nm", "N·m"),
    ("V", "V"),
    ("mV", "mV"),
    ("A", "A"),
    ("Pa", "Pa"),
    ("kPa", "kPa"),
    ("MPa", "MPa"),
    ("bar", "bar"),
    ("Hz", "Hz"),
    ("hz", "Hz"),
    ("kHz", "kHz"),
    ("rpm", "rpm"),
    ("degC", "°C"),
    ("deg", "deg"),
    ("rad", "rad"),
    ("rad_s", "rad/s"),
    ("deg_s", "deg/s"),
    ("dps", "deg/s"),
    ("W", "W"),
    ("kW", "kW"),
    ("percent", "%"),
    ("dB", "dB"),
];

/// Whether a text is one of the units logs name.
pub fn is_unit(text: &str) -> bool {
    let text = text.trim();
    // Single letters are units in their own case only: a column may be called `a` or `v`.
    if text.len() == 1 {
        return ["s", "g", "m", "h", "N", "V", "A", "K", "W", "J", "%", "-"].contains(&text);
    }
    UNITS.contains(&text.to_lowercase().as_str())
}

/// The unit of a unit row's cell: brackets off, `-` for none.
pub fn unit_of_cell(cell: &str) -> String {
    let cell = cell.trim();
    let inner = match (cell.chars().next(), cell.chars().last()) {
        (Some('['), Some(']')) | (Some('('), Some(')')) if cell.len() > 1 => {
            &cell[1..cell.len() - 1]
        }
        _ => cell,
    };
    let inner = inner.trim();
    if matches!(inner, "-" | "–" | "1" | "none" | "") {
        String::new()
    } else {
        inner.to_string()
    }
}

/// Name and unit of a header's cell. A unit in brackets or after `/` is taken off the name; one after `_` stays in it,
/// since such a name is an identifier.
pub fn split_unit(cell: &str) -> (String, String) {
    let cell = cell.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        let Some(body) = cell.strip_suffix(close) else {
            continue;
        };
        let Some(at) = opening_bracket(body, open, close) else {
            continue;
        };
        let (name, unit) = (
            body[..at].trim_end_matches([' ', '_', '/']),
            &body[at + 1..],
        );
        let round = open == '(';
        if !name.is_empty() && (!round || is_unit(unit) || unit.contains('/')) {
            return (name.to_string(), unit_of_cell(unit));
        }
    }
    for between in [" / ", " in ", ", ", " "] {
        if let Some((name, unit)) = cell.rsplit_once(between) {
            let sure = between != " " || unit.contains(['/', '°', '²', '%']);
            if sure && is_unit(unit) && !name.trim().is_empty() {
                return (name.trim().to_string(), unit_of_cell(unit));
            }
        }
    }
    let suffix = |&&(suffix, _): &&(&str, &str)| {
        cell.strip_suffix(suffix)
            .and_then(|name| name.strip_suffix('_'))
            .is_some_and(|name| !name.is_empty())
    };
    let longest = UNIT_SUFFIXES
        .iter()
        .filter(suffix)
        .max_by_key(|(s, _)| s.len());
    let unit = longest.map_or("", |(_, unit)| unit);
    (cell.to_string(), unit.to_string())
}

/// Byte position of the bracket that closes at the end of a text.
fn opening_bracket(body: &str, open: char, close: char) -> Option<usize> {
    let mut depth = 1;
    for (at, c) in body.char_indices().rev() {
        if c == close {
            depth += 1;
        } else if c == open {
            depth -= 1;
            if depth == 0 {
                return Some(at);
            }
        }
    }
    None
}

/// Whether a user's word means the channel called `name`: as written, or as the header writes it with its unit.
pub fn matches(word: &str, name: &str) -> bool {
    let word = word.trim();
    word == name || split_unit(word).0 == name
}

/// Index of the channel a user's word means: by its name as written, by its name with the unit, else by its name in other letters, where
/// only one has it.
pub fn find_channel(word: &str, known: &[String]) -> Option<usize> {
    let exact = known.iter().position(|name| name == word.trim());
    let meant = || known.iter().position(|name| matches(word, name));
    let folded = || {
        let plain = split_unit(word).0.to_lowercase();
        let mut alike =
            (0..known.len()).filter(|&k| split_unit(&known[k]).0.to_lowercase() == plain);
        alike.next().filter(|_| alike.next().is_none())
    };
    exact.or_else(meant).or_else(folded)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units as the headers of real logs carry them.
    #[test]
    fn exact_units_in_names() {
        let cases = [
            ("X-Axis (m/s2)", "X-Axis", "m/s2"),
            ("ACC01_z [g]", "ACC01_z", "g"),
            ("Time (-)", "Time", ""),
            ("accel_x_g", "accel_x_g", "g"),
            ("time_s", "time_s", "s"),
            ("Kraft / N", "Kraft", "N"),
            ("frequency_Hz", "frequency_Hz", "Hz"),
            ("Motor (left)", "Motor (left)", ""),
            ("H1_re", "H1_re", ""),
            ("H (m/s²/N)", "H", "m/s²/N"),
            ("plain", "plain", ""),
            ("[g]", "[g]", ""),
            ("acc_m_s2", "acc_m_s2", "m/s²"),
            ("Accel [(m/s²)/N]", "Accel", "(m/s²)/N"),
            ("_s", "_s", ""),
            (")", ")", ""),
        ];
        for (cell, name, unit) in cases {
            assert_eq!(
                split_unit(cell),
                (name.to_string(), unit.to_string()),
                "{cell}"
            );
        }
        assert!(matches("X-Axis (m/s2)", "X-Axis") && matches("accel_x_g", "accel_x_g"));
    }
}

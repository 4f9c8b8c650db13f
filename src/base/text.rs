//! Text helpers: suggestions for misspelt words, plurals, lists, line wrapping.

/// The known word nearest to a misspelt one, if any is near.
pub fn suggestion<'k>(word: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    const MAX_LEN: usize = 64;
    if word.len() > MAX_LEN {
        return None;
    }
    let folded = word.to_lowercase();
    let likeness = |name: &str| strsim::jaro_winkler(&name.to_lowercase(), &folded);
    known
        .map(|name| (likeness(name), name))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// A few words in a row, quoted, the rest counted.
pub fn quoted_list<'k>(words: impl Iterator<Item = &'k str>) -> String {
    const SHOWN: usize = 14;
    let words: Vec<&str> = words.collect();
    let shown: Vec<String> = words.iter().take(SHOWN).map(|w| format!("`{w}`")).collect();
    match words.len().saturating_sub(SHOWN) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// So many of a thing: `1 gap`, `2 gaps`, `2 frequencies`, `2 switches`.
pub fn pluralise(count: usize, thing: &str) -> String {
    match (count, thing.strip_suffix("cy")) {
        (1, _) => format!("1 {thing}"),
        (n, Some(stem)) => format!("{n} {stem}cies"),
        (n, None) if thing.ends_with("ch") => format!("{n} {thing}es"),
        (n, None) => format!("{n} {thing}s"),
    }
}

/// A text in lines of at most a terminal's width, the later ones set in.
pub fn wrap_lines(text: &str) -> String {
    const WIDTH: usize = 120;
    let (mut all, mut length) = (String::new(), 0);
    for word in text.split(' ') {
        let more = 1 + word.chars().count();
        if length > 0 && length + more > WIDTH {
            all += "\n  ";
            length = 2;
        } else if length > 0 {
            all.push(' ');
            length += 1;
        }
        all += word;
        length += more - 1;
    }
    all
}

/// Words people write for keys.
pub const KEY_SYNONYMS: &[(&str, &str)] = &[
    ("stiffness", "k"),
    ("spring", "k"),
    ("inertia", "J"),
    ("moment_of_inertia", "J"),
    ("polar_inertia", "J"),
    ("damping", "c"),
    ("damping_coefficient", "c"),
    ("zeta", "damping_ratio"),
    ("eta", "loss_factor"),
    ("number_of_teeth", "teeth"),
    ("tooth_numbers", "teeth"),
    ("alpha", "pressure_angle"),
    ("beta", "helix_angle"),
    ("clearance", "backlash"),
    ("play", "backlash"),
    ("outer_diameter", "diameter"),
    ("inner_diameter", "bore"),
    ("node", "at"),
    ("ends", "between"),
    ("nodes", "between"),
    ("gear", "gear_pair"),
    ("mesh", "gear_pair"),
    ("disc", "inertia"),
    ("disk", "inertia"),
    ("mass", "inertia"),
    ("spring", "shaft"),
    ("support", "bearing"),
];

#[cfg(test)]
mod tests {
    use super::pluralise;

    #[test]
    fn keeps_counts_readable() {
        let said = [0, 1, 2].map(|n| pluralise(n, "frequency"));
        assert_eq!(said, ["0 frequencies", "1 frequency", "2 frequencies"]);
        assert_eq!(pluralise(3, "gap"), "3 gaps");
        assert_eq!(pluralise(2, "switch"), "2 switches");
    }
}

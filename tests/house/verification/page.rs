//! The page: a contents list, a table for each subject, coverage, orders, reference data, what is not verified.

use std::fs;
use std::path::{Path, PathBuf};

use super::cases::{Case, evidence_in};
use super::manual::{Manual, Subject};
use crate::figures::Figure;
use crate::sources::files;

/// A cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn row<const N: usize>(cells: [&str; N]) -> String {
    format!("| {} |\n", cells.map(cell).join(" | "))
}

fn head<const N: usize>(names: [&str; N], right: [bool; N]) -> String {
    let rule = right.map(|right| if right { "---:" } else { "---" });
    format!("\n{}| {} |\n", row(names), rule.join(" | "))
}

/// The anchor of a heading.
fn anchor(title: &str) -> String {
    let kept = |c: char| match c {
        ' ' => Some('-'),
        '-' => Some('-'),
        c if c.is_alphanumeric() => Some(c.to_ascii_lowercase()),
        _ => None,
    };
    title.chars().filter_map(kept).collect()
}

/// The rows of one test: its sentence, and a row for each figure where there are several.
fn case_rows(case: &Case, figures: &[Figure]) -> String {
    let source = match (&case.source, case.name.starts_with("exact_")) {
        (Some(source), _) => source.clone(),
        (None, true) => "closed form".into(),
        (None, false) => String::new(),
    };
    let test = format!("`{}`", case.path());
    let listed: Vec<&Figure> = figures
        .iter()
        .filter(|f| f.kind == "difference" || f.kind == "printed")
        .collect();
    // One bound that is relative needs no row of its own.
    let alone = match listed[..] {
        [one] => one.kind == "difference" && !one.what.contains(','),
        _ => false,
    };
    let orders = figures.iter().filter(|f| f.kind == "order");
    let orders: Vec<&str> = orders.map(|f| f.computed.as_str()).collect();
    let difference = match listed[..] {
        [one] if alone => one.difference.clone(),
        [] if !orders.is_empty() => format!("order {}", orders.join(", ")),
        [] => "holds".into(),
        _ => String::new(),
    };
    let mut text = row([&case.sentence, "", "", &difference, &source, &test]);
    if !alone {
        for f in listed {
            let what = format!("· {}", f.what);
            let [reference, computed] =
                [&f.reference, &f.computed].map(|v| v.replace(' ', "\u{a0}"));
            text += &row([&what, &reference, &computed, &f.difference, "", ""]);
        }
    }
    text
}

fn plural(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn section(title: &str, text: &str) -> String {
    format!("\n## {title}\n\n{}\n", text.trim())
}

fn subject(manual: &Manual, subject: &Subject) -> String {
    let mut text = section(&subject.title, &subject.text);
    let columns = [
        "case",
        "printed",
        "geardyn",
        "difference (relative, or in the unit that the case names)",
        "source",
        "test",
    ];
    text += &head(columns, [false, true, true, true, false, false]);
    for file in &subject.files {
        let listed =
            |case: &&Case| case.file == *file && case.is_evidence() && !manual.is_omitted(case);
        for case in manual.cases.iter().filter(listed) {
            text += &case_rows(case, manual.figures(case));
        }
    }
    text
}

/// The figures of one kind, of every test.
fn of_kind(manual: &Manual, kind: &str, columns: [&str; 4]) -> String {
    let mut text = head(columns, [false, true, true, false]);
    for case in &manual.cases {
        let test = format!("`{}`", case.path());
        for f in manual.figures(case).iter().filter(|f| f.kind == kind) {
            text += &row([&f.what, &f.reference, &f.computed, &test]);
        }
    }
    text
}

/// Who made a file of `data/reference`, as the file says.
fn birthplace(value: &serde_json::Value) -> String {
    let text = |key: &str| value.get(key).and_then(|v| v.as_str());
    let made = match value.get("made_by") {
        Some(serde_json::Value::Object(parts)) => {
            let part = |(key, v): (&String, &serde_json::Value)| match (key.as_str(), v.as_str()) {
                ("script", Some(script)) => script.to_string(),
                (key, Some(version)) => format!("{key} {version}"),
                (key, None) => format!("{v} {key}"),
            };
            Some(parts.iter().map(part).collect::<Vec<_>>().join(", "))
        }
        Some(v) => v.as_str().map(str::to_string),
        None => None,
    };
    let program = text("program").map(|program| match text("script") {
        Some(script) => format!("{script}, {program}"),
        None => program.to_string(),
    });
    let parts = [text("source").map(str::to_string), made, program];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// Reference data, who made them and which tests read them.
fn references() -> String {
    let mut text = head(["file", "made by", "read by"], [false, false, false]);
    let folder = |path: &str| -> Vec<PathBuf> {
        let entries = fs::read_dir(path).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    let mut names = folder("data/reference");
    names.extend(folder("data/reference/gear"));
    names.retain(|path| path.is_file());
    names.sort();
    let tests = files(Path::new("tests"));
    for path in names {
        let stem = path.file_stem().unwrap().to_str().unwrap();
        let value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        let reads = |test: &&PathBuf| {
            let text = fs::read_to_string(test).unwrap();
            let ways = ["reference(", "data/reference", "crate::cases::"];
            let reads_any = ways.iter().any(|way| text.contains(way));
            let file = format!("/{stem}.json");
            text.contains(&file) || reads_any && text.contains(&format!("\"{stem}\""))
        };
        let readers: Vec<String> = tests
            .iter()
            .filter(reads)
            .map(|test| format!("`{}`", test.file_stem().unwrap().to_str().unwrap()))
            .collect();
        assert!(
            !readers.is_empty(),
            "{}: no test reads it; delete it",
            path.display()
        );
        let made = birthplace(&value);
        assert!(
            !made.is_empty(),
            "{}: say in \"made_by\" or \"source\" where it comes from",
            path.display()
        );
        text += &row([&format!("`{stem}.json`"), &made, &readers.join(", ")]);
    }
    text
}

/// Tests that the page does not list, with the reason.
fn omissions(manual: &Manual) -> String {
    let mut text = head(["tests", "count", "reason"], [false, true, false]);
    for omitted in &manual.contents.omitted {
        let in_it = |case: &&Case| {
            case.is_evidence()
                && (omitted.what.contains(&case.file) || omitted.what.contains(&case.path()))
        };
        let count = manual.cases.iter().filter(in_it).count();
        let names: Vec<String> = omitted
            .what
            .iter()
            .map(|name| format!("`{name}`"))
            .collect();
        text += &row([&names.join(", "), &count.to_string(), &omitted.reason]);
    }
    let unit = evidence_in("src");
    let reason =
        "closed forms of single functions, next to their code; `cargo test --lib` runs them";
    text + &row(["`src/`", &unit.to_string(), reason])
}

const INTRODUCTION: &str = "\
<!-- Written by tests/house/verification.rs; change the tests or tests/verification/contents.toml instead. -->
# Verification

What geardyn has been compared with, and how far it agrees.
Every number of this page was computed by the test of its row; a test fails where a number no longer holds or a case is missing here.

- *printed*: the number in the source, to its digits. *geardyn*: the number it gives, with two digits more.
- *difference*: a bound that the test holds, relative, or in the unit that the row names; of states of motion, relative to their \
largest values or to one. Rounding is given as a power of ten, with room for other machines. \"holds\": the test compares counts, texts \
or numbers of many kinds, and passes.
- *test*: `file::name`; `cargo test file::name` runs it. Tests named `ref_` compare with a *reference*: a publication, a standard or \
another program; `exact_` with a *closed form*; `order_` measures an order of convergence.

## Contents
";

pub fn page(manual: &Manual) -> String {
    let mut body = String::new();
    let mut titles = Vec::new();
    for s in &manual.contents.subjects {
        let count = |prefix: &str| {
            let one = |case: &&Case| {
                s.files.contains(&case.file)
                    && case.name.starts_with(prefix)
                    && !manual.is_omitted(case)
            };
            manual.cases.iter().filter(one).count()
        };
        let (references, closed) = (count("ref_"), count("exact_") + count("order_"));
        titles.push((
            s.title.as_str(),
            format!(
                ": {}, {}",
                plural(references, "reference", "references"),
                plural(closed, "closed form", "closed forms")
            ),
        ));
        body += &subject(manual, s);
    }
    let mut add = |title: &'static str, text: &str, table: String| {
        titles.push((title, String::new()));
        body += &section(title, text);
        body += &table;
    };
    add(
        "Coverage of intervals",
        "How often a stated interval holds the truth, counted on simulated data whose truth is known.",
        of_kind(manual, "coverage", ["what", "promised", "held", "test"]),
    );
    add(
        "Orders of convergence",
        "The slope of the error against the step, where the solution is known.",
        of_kind(manual, "order", ["what", "theory", "measured", "test"]),
    );
    add(
        "Independent programs and data",
        "Reference numbers in `data/reference/`, the script or publication they come from, the versions, and the tests that read them. \
         Scripts share no code with geardyn.",
        references(),
    );
    let mut not_verified = String::from("\n");
    for item in &manual.contents.not_verified {
        not_verified += &format!("- {item}\n");
    }
    add(
        "Not verified",
        "No outside number has been compared for what follows. Closed forms or laws may still be held by tests.",
        not_verified,
    );
    add(
        "Tests not listed",
        "Tests of the same kinds of evidence that compare no result of a calculation.",
        omissions(manual),
    );
    let mut text = String::from(INTRODUCTION);
    text += "\n";
    for (title, counts) in titles {
        text += &format!("- [{title}](#{}){counts}\n", anchor(title));
    }
    text + &body
}

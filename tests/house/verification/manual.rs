//! What the manual holds: subjects, cases, figures; and what keeps the page from being made.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::cases::{Case, cases_of};
use super::{CONTENTS, RENEW};
use crate::figures::{self, Figure, Figures};
use crate::sources::files;

/// What `contents.toml` says.
pub struct Contents {
    pub subjects: Vec<Subject>,
    pub omitted: Vec<Omitted>,
    pub not_verified: Vec<String>,
}

pub struct Subject {
    pub title: String,
    pub text: String,
    pub files: Vec<String>,
}

pub struct Omitted {
    /// Test files, or single tests as `file::test`.
    pub what: Vec<String>,
    pub reason: String,
}

fn contents() -> Contents {
    let file = fs::read_to_string(CONTENTS).unwrap();
    let table = DeTable::parse(&file).unwrap_or_else(|error| panic!("{CONTENTS}: {error}"));
    let table = table.get_ref();
    let text = |value: &DeValue| value.as_str().unwrap().to_string();
    let list = |value: &DeValue| -> Vec<String> {
        let items = value.as_array().unwrap().iter();
        items.map(|item| text(item.get_ref())).collect()
    };
    let tables = |key: &str| {
        let items = table[key].get_ref().as_array().unwrap().iter();
        items.map(|item| item.get_ref().as_table().unwrap())
    };
    let subjects = tables("subject").map(|s| Subject {
        title: text(s["title"].get_ref()),
        text: text(s["text"].get_ref()),
        files: list(s["files"].get_ref()),
    });
    let omitted = tables("omitted").map(|o| Omitted {
        what: list(o["what"].get_ref()),
        reason: text(o["reason"].get_ref()),
    });
    Contents {
        subjects: subjects.collect(),
        omitted: omitted.collect(),
        not_verified: list(table["not_verified"].get_ref()),
    }
}

/// The tests, the contents and the figures, from which the page follows.
pub struct Manual {
    pub contents: Contents,
    pub cases: Vec<Case>,
    pub figures: BTreeMap<String, Figures>,
}

pub fn manual() -> Manual {
    let paths = files(Path::new("tests"));
    let holds_tests = |path: &&PathBuf| {
        path.ancestors().nth(2) == Some(Path::new("tests")) && !path.starts_with("tests/support")
    };
    let cases: Vec<Case> = paths
        .iter()
        .filter(holds_tests)
        .flat_map(|path| cases_of(path))
        .collect();
    let files: BTreeSet<String> = cases.iter().map(|case| case.file.clone()).collect();
    let figures = files.into_iter().map(|b| (b.clone(), figures::read(&b)));
    Manual {
        contents: contents(),
        figures: figures.collect(),
        cases,
    }
}

impl Manual {
    pub fn figures(&self, case: &Case) -> &[Figure] {
        let list = self.figures.get(&case.file).and_then(|f| f.get(&case.name));
        list.map_or(&[], Vec::as_slice)
    }

    pub fn is_omitted(&self, case: &Case) -> bool {
        let mut names = self.contents.omitted.iter().flat_map(|o| &o.what);
        names.any(|what| *what == case.file || *what == case.path())
    }

    /// Deletes figures of tests that measure nothing any more.
    pub fn prune(&mut self) {
        for (file, figures) in &mut self.figures {
            let measures = |test: &String| {
                let same = |case: &Case| case.file == *file && case.name == *test;
                self.cases.iter().any(|case| same(case) && case.records)
            };
            let count = figures.len();
            figures.retain(|test, _| measures(test));
            if figures.len() < count {
                figures::write(file, figures);
            }
        }
    }

    /// Everything that keeps the page from being made, one line each with its remedy.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        let subjects: Vec<&String> = self
            .contents
            .subjects
            .iter()
            .flat_map(|s| &s.files)
            .collect();
        for case in self.cases.iter().filter(|case| case.is_evidence()) {
            let path = case.path();
            if !self.is_omitted(case) && !subjects.contains(&&case.file) {
                faults.push(format!(
                    "{path}: name \"{}\" in the files of a subject of {CONTENTS}, or in an [[omitted]] with the reason",
                    case.file
                ));
            } else if !self.is_omitted(case) && case.sentence.is_empty() {
                faults.push(format!(
                    "{path}: write a doc comment that says what is compared"
                ));
            } else if !self.is_omitted(case)
                && case.name.starts_with("ref_")
                && case.source.is_none()
            {
                faults.push(format!(
                    "{path}: end its doc comment with a line `/// Source: author, year, table` or `/// Source: program and version (script)`"
                ));
            }
        }
        for (file, figures) in &self.figures {
            for test in figures.keys() {
                let same = |case: &&Case| case.file == *file && case.name == *test;
                match self.cases.iter().find(same) {
                    Some(case) if case.records => {}
                    _ => faults.push(format!(
                        "tests/verification/{file}.txt: {test} measures nothing any more; run: {RENEW}"
                    )),
                }
            }
        }
        let known: BTreeSet<String> = self
            .cases
            .iter()
            .flat_map(|case| [case.file.clone(), case.path()])
            .collect();
        let omitted = self.contents.omitted.iter().flat_map(|o| &o.what);
        for name in omitted {
            if !known.contains(name) {
                faults.push(format!(
                    "{CONTENTS}: there is no test file or test {name} to omit"
                ));
            }
        }
        faults
    }
}

//! The tests as their sources have them: names, doc comments, whether they enter figures.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

use crate::sources::{doc, files, parse};

/// Prefixes of tests that are cases of the manual.
const EVIDENCE: [&str; 3] = ["ref_", "exact_", "order_"];
/// Functions of `tests/support/verification.rs` that enter figures.
const RECORDERS: [&str; 5] = ["within", "printed", "printed_modes", "order", "coverage"];

/// A test as its source has it.
pub struct Case {
    pub file: String,
    pub name: String,
    pub sentence: String,
    pub source: Option<String>,
    /// Whether it reaches a function that enters figures.
    pub records: bool,
}

impl Case {
    pub fn path(&self) -> String {
        format!("{}::{}", self.file, self.name)
    }

    pub fn is_evidence(&self) -> bool {
        is_evidence(&self.name)
    }
}

/// Names used by a function.
#[derive(Default)]
struct Names(BTreeSet<String>);

impl<'ast> Visit<'ast> for Names {
    fn visit_ident(&mut self, ident: &'ast proc_macro2::Ident) {
        self.0.insert(ident.to_string());
    }
    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        for token in mac.tokens.clone() {
            self.token(token);
        }
        visit::visit_macro(self, mac);
    }
}

impl Names {
    fn token(&mut self, token: proc_macro2::TokenTree) {
        match token {
            proc_macro2::TokenTree::Ident(ident) => {
                self.0.insert(ident.to_string());
            }
            proc_macro2::TokenTree::Group(group) => {
                group.stream().into_iter().for_each(|t| self.token(t));
            }
            _ => {}
        }
    }
}

/// Functions of a file, those in its modules included.
#[derive(Default)]
struct Functions<'ast>(Vec<&'ast syn::ItemFn>);

impl<'ast> Visit<'ast> for Functions<'ast> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.0.push(item);
    }
}

fn is_test(function: &syn::ItemFn) -> bool {
    function.attrs.iter().any(|a| a.path().is_ident("test"))
}

fn is_evidence(name: &str) -> bool {
    EVIDENCE.iter().any(|prefix| name.starts_with(prefix))
}

pub fn cases_of(path: &Path) -> Vec<Case> {
    let stem = path.file_stem().unwrap().to_str().unwrap().to_string();
    let file = parse(path);
    let mut functions = Functions::default();
    functions.visit_file(&file);
    let names: BTreeMap<String, BTreeSet<String>> = functions
        .0
        .iter()
        .map(|f| {
            let mut names = Names::default();
            names.visit_block(&f.block);
            (f.sig.ident.to_string(), names.0)
        })
        .collect();
    let records = |name: &str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![name.to_string()]);
        while let Some(next) = open.pop() {
            if RECORDERS.contains(&next.as_str()) {
                return true;
            }
            if seen.insert(next.clone()) {
                open.extend(names.get(&next).into_iter().flatten().cloned());
            }
        }
        false
    };
    functions
        .0
        .iter()
        .filter(|f| is_test(f))
        .map(|f| {
            let text = doc(&f.attrs);
            let at = text.iter().position(|line| line.starts_with("Source: "));
            let (sentence, source) = text.split_at(at.unwrap_or(text.len()));
            let source = source.join(" ");
            let name = f.sig.ident.to_string();
            Case {
                file: stem.clone(),
                sentence: sentence.join(" ").trim().to_string(),
                source: source.strip_prefix("Source: ").map(str::to_string),
                records: records(&name),
                name,
            }
        })
        .collect()
}

/// How many cases the files of a folder hold.
pub fn evidence_in(folder: &str) -> usize {
    let paths = files(Path::new(folder));
    let in_file = |path: &PathBuf| {
        let file = parse(path);
        let mut functions = Functions::default();
        functions.visit_file(&file);
        let listed = |f: &&&syn::ItemFn| is_test(f) && is_evidence(&f.sig.ident.to_string());
        functions.0.iter().filter(listed).count()
    };
    paths.iter().map(in_file).sum()
}

//! The words of the house: names and first doc sentences use the terms of the field, so that a reader finds them in an index.
//!
//! Each count may only fall: a change that lowers one lowers its limit here.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// Words that are no names: participles, pronoun words and private pictures.
const IN_NAMES: &[&str] = &[
    "freedom",
    "freedoms",
    "swing",
    "swings",
    "doubt",
    "doubts",
    "remark",
    "remarks",
    "told",
    "said",
    "asked",
    "stance",
    "border",
    "borders",
    "ladder",
    "kin",
    "journey",
    "flight",
    "patience",
    "allowance",
    "surprise",
    "wanted",
    "facts",
    "mostly",
    "trouble",
    "taste",
    "stretch",
    "stretches",
    "beside",
    "hopeless",
    "met",
    "held",
    "found",
    "look",
];
/// Words that a first doc sentence does without.
const IN_DOCS: &[&str] = &[
    "swing",
    "swings",
    "doubt",
    "doubts",
    "remark",
    "remarks",
    "told",
    "said",
    "asked",
    "answer",
    "answers",
    "stands",
    "stand",
    "border",
    "borders",
    "beside",
    "mostly",
    "trouble",
    "stretch",
    "stretches",
    "hopeless",
    "surprise",
    "ladder",
    "course",
    "flight",
    "journey",
    "nobody",
    "taste",
];
/// First words that hide the subject of a sentence.
const OPENINGS: &[&str] = &["What", "How", "Where", "Of", "Its"];

/// Names that still hold such a word.
const NAMES: usize = 0;
/// First doc sentences that still hold such a word.
const SENTENCES: usize = 0;
/// First doc sentences that still open with such a word.
const OPENED: usize = 0;

/// Names and first doc sentences with their files.
#[derive(Default)]
struct Words {
    file: PathBuf,
    names: Vec<(PathBuf, String)>,
    sentences: Vec<(PathBuf, String)>,
}

impl Words {
    fn item(&mut self, name: &syn::Ident, attributes: &[syn::Attribute]) {
        self.names.push((self.file.clone(), name.to_string()));
        self.docs(attributes);
    }

    fn docs(&mut self, attributes: &[syn::Attribute]) {
        let lines = attributes
            .iter()
            .filter_map(|attribute| match &attribute.meta {
                syn::Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
                    syn::Expr::Lit(syn::ExprLit {
                        lit: syn::Lit::Str(text),
                        ..
                    }) => Some(text.value().trim().to_string()),
                    _ => None,
                },
                _ => None,
            });
        let first: Vec<String> = lines.take_while(|line| !line.is_empty()).collect();
        let first = first.join(" ");
        if !first.is_empty() {
            let sentence = first.split(". ").next().unwrap_or_default();
            self.sentences
                .push((self.file.clone(), sentence.to_string()));
        }
    }
}

impl<'ast> Visit<'ast> for Words {
    fn visit_file(&mut self, file: &'ast syn::File) {
        self.docs(&file.attrs);
        visit::visit_file(self, file);
    }
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.item(&item.sig.ident, &item.attrs);
    }
    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.item(&item.sig.ident, &item.attrs);
    }
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.item(&item.ident, &item.attrs);
        visit::visit_item_struct(self, item);
    }
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.item(&item.ident, &item.attrs);
        visit::visit_item_enum(self, item);
    }
    fn visit_variant(&mut self, item: &'ast syn::Variant) {
        self.item(&item.ident, &item.attrs);
        visit::visit_variant(self, item);
    }
    fn visit_field(&mut self, item: &'ast syn::Field) {
        if let Some(name) = &item.ident {
            self.item(name, &item.attrs);
        }
    }
    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.item(&item.ident, &item.attrs);
    }
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !item.attrs.iter().any(|a| a.path().is_ident("cfg")) {
            self.item(&item.ident, &item.attrs);
            visit::visit_item_mod(self, item);
        }
    }
}

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// `DynamicModel`, `dynamic_model` and `DYNAMIC_MODEL` are the words dynamic and model.
fn words_of(name: &str) -> Vec<String> {
    let mut snake = String::new();
    let is_constant = !name.chars().any(char::is_lowercase);
    for letter in name.chars() {
        if letter.is_uppercase() && !is_constant {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake.split('_').map(str::to_string).collect()
}

/// The words of a sentence outside of code.
fn prose(sentence: &str) -> Vec<String> {
    let outside = sentence.split('`').step_by(2).collect::<Vec<_>>().join(" ");
    let words = outside.split(|c: char| !c.is_alphabetic());
    words.map(str::to_lowercase).collect()
}

fn all() -> Words {
    let mut paths = Vec::new();
    files(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
        &mut paths,
    );
    paths.sort();
    let mut words = Words::default();
    for path in paths {
        words.file = path.clone();
        let text = fs::read_to_string(&path).unwrap();
        words.visit_file(&syn::parse_file(&text).unwrap());
    }
    words
}

/// Fails where `count` is not the limit: above it the offenders are listed by file.
fn holds(what: &str, limit: usize, offenders: &[(PathBuf, String)]) {
    let mut by_file: BTreeMap<&Path, Vec<&str>> = BTreeMap::new();
    for (file, text) in offenders {
        by_file.entry(file).or_default().push(text);
    }
    let count = offenders.len();
    println!("{what}: {count} (limit {limit})");
    assert!(
        count <= limit,
        "{what}: {count}, limit {limit}: {by_file:#?}"
    );
    assert!(
        count == limit,
        "{what} fell to {count}: lower the limit from {limit}"
    );
}

#[test]
fn names_are_words_of_the_field() {
    let words = all();
    let is_private = |name: &str| {
        words_of(name)
            .iter()
            .any(|w| IN_NAMES.contains(&w.as_str()))
    };
    let names: Vec<_> = words
        .names
        .into_iter()
        .filter(|(_, name)| is_private(name))
        .collect();
    holds("names", NAMES, &names);
}

#[test]
fn first_sentences_are_plain() {
    let words = all();
    let is_private = |s: &str| prose(s).iter().any(|w| IN_DOCS.contains(&w.as_str()));
    let sentences: Vec<_> = words
        .sentences
        .iter()
        .filter(|(_, s)| is_private(s))
        .cloned()
        .collect();
    holds("sentences", SENTENCES, &sentences);
    let opens = |s: &str| OPENINGS.contains(&s.split(' ').next().unwrap_or_default());
    let opened: Vec<_> = words
        .sentences
        .into_iter()
        .filter(|(_, s)| opens(s))
        .collect();
    holds("openings", OPENED, &opened);
}

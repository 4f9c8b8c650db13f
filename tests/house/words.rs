//! The words of the house: names, first doc sentences and messages use the terms of the field, so that a reader finds them in an index.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

use crate::sources::{doc, files, parse};

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

/// Words that a message does without.
const IN_MESSAGES: &[&str] = &[
    "freedoms",
    "swing",
    "swings",
    "doubt",
    "doubts",
    "told",
    "stance",
    "ladder",
    "beside",
    "mostly",
    "stretch",
    "stretches",
    "hopeless",
    "nobody",
];

/// Names, first doc sentences and texts with their files.
#[derive(Default)]
struct Words {
    file: PathBuf,
    names: Vec<(PathBuf, String)>,
    sentences: Vec<(PathBuf, String)>,
    texts: Vec<(PathBuf, String)>,
}

impl Words {
    fn item(&mut self, name: &syn::Ident, attributes: &[syn::Attribute]) {
        self.names.push((self.file.clone(), name.to_string()));
        self.docs(attributes);
    }

    fn docs(&mut self, attributes: &[syn::Attribute]) {
        let lines = doc(attributes).into_iter();
        let first: Vec<String> = lines.take_while(|line| !line.is_empty()).collect();
        let first = first.join(" ");
        if !first.is_empty() {
            let sentence = first.split(". ").next().unwrap_or_default();
            self.sentences
                .push((self.file.clone(), sentence.to_string()));
        }
    }

    /// The texts in the arguments of a macro; placeholders of `format!` are no words.
    fn texts(&mut self, tokens: TokenStream) {
        for token in tokens {
            match token {
                TokenTree::Group(group) => self.texts(group.stream()),
                TokenTree::Literal(literal) => {
                    if let Ok(text) = syn::parse_str::<syn::LitStr>(&literal.to_string()) {
                        self.texts.push((self.file.clone(), text.value()));
                    }
                }
                _ => {}
            }
        }
    }
}

impl<'ast> Visit<'ast> for Words {
    fn visit_file(&mut self, file: &'ast syn::File) {
        self.docs(&file.attrs);
        visit::visit_file(self, file);
    }
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_lit_str(&mut self, text: &'ast syn::LitStr) {
        self.texts.push((self.file.clone(), text.value()));
    }
    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        self.texts(mac.tokens.clone());
    }
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.item(&item.sig.ident, &item.attrs);
        visit::visit_item_fn(self, item);
    }
    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.item(&item.sig.ident, &item.attrs);
        visit::visit_impl_item_fn(self, item);
    }
    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        self.item(&item.sig.ident, &item.attrs);
        visit::visit_trait_item_fn(self, item);
    }
    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.item(&item.ident, &item.attrs);
        visit::visit_item_trait(self, item);
    }
    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.item(&item.ident, &item.attrs);
    }
    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.item(&item.ident, &item.attrs);
        visit::visit_item_static(self, item);
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
        visit::visit_item_const(self, item);
    }
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !item.attrs.iter().any(|a| a.path().is_ident("cfg")) {
            self.item(&item.ident, &item.attrs);
            visit::visit_item_mod(self, item);
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
    let mut words = Words::default();
    for path in files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        let file = parse(&path);
        words.file = path;
        words.visit_file(&file);
    }
    words
}

/// Fails where an entry is an offender, and lists them by file.
fn assert_none(what: &str, entries: &[(PathBuf, String)], offends: impl Fn(&str) -> bool) {
    let mut by_file: BTreeMap<&Path, Vec<&str>> = BTreeMap::new();
    for (file, text) in entries.iter().filter(|(_, text)| offends(text)) {
        by_file.entry(file).or_default().push(text);
    }
    assert!(by_file.is_empty(), "{what}: {by_file:#?}");
}

fn holds_any(words: &[String], private: &[&str]) -> bool {
    words.iter().any(|word| private.contains(&word.as_str()))
}

#[test]
fn names_are_words_of_the_field() {
    assert_none("names", &all().names, |name| {
        holds_any(&words_of(name), IN_NAMES)
    });
}

#[test]
fn first_sentences_are_plain() {
    let words = all();
    assert_none("sentences", &words.sentences, |sentence| {
        holds_any(&prose(sentence), IN_DOCS)
    });
    assert_none("openings", &words.sentences, |sentence| {
        OPENINGS.contains(&sentence.split(' ').next().unwrap_or_default())
    });
    assert_none("sentences cut short", &words.sentences, |sentence| {
        sentence.ends_with('\\') || sentence.matches('`').count() % 2 == 1
    });
}

#[test]
fn messages_are_plain() {
    assert_none("messages", &all().texts, |text| {
        // Placeholders of `format!` are names.
        let mut outside = String::new();
        let mut depth = 0;
        for letter in text.chars() {
            depth += i32::from(letter == '{') - i32::from(letter == '}');
            outside.push(if depth == 0 { letter } else { ' ' });
        }
        holds_any(&prose(&outside), IN_MESSAGES)
    });
}

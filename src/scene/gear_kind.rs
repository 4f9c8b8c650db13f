//! Kind of a gear file: what pair it describes, or why it is none.

use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::truncate;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::text::quoted_list;
use crate::base::toml::{self, Value};

/// Whether a TOML file describes gears.
pub fn is_gear_file(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    ["pair", "helicoid"]
        .iter()
        .any(|key| root.get(key).is_some())
}

/// Refuses a file without any table of a gear file, naming the command that takes it.
///
/// # Errors
/// `Syntax`, or `Usage` at the head of the file.
pub fn check_is_gear_file(source: &Arc<SourceFile>) -> Result<(), Error> {
    let toml::Document {
        root, syntax_error, ..
    } = toml::parse(source);
    if let Some(error) = syntax_error {
        return Err(error);
    }
    if ["pair", "pinion", "gear", "helicoid"]
        .iter()
        .any(|key| root.get(key).is_some())
    {
        return Ok(());
    }
    let path = &source.path;
    let (what, hint) = match root.table("measured_gear") {
        Some((gear, _)) if gear.get("spans").is_some() => (
            "a gear given by readings",
            format!("run `geardyn gear reverse {path}`"),
        ),
        Some(_) => ("a measured gear", format!("run `geardyn measure {path}`")),
        None => (
            "not a gear file",
            format!(
                "a gear file has `pair`, `pinion` and `gear`, or `helicoid`; `geardyn check {path}` says whether it is a machine model"
            ),
        ),
    };
    let error = Error::new(Code::Usage, format!("the file has no `pair`: it is {what}"));
    Err(error
        .with_span(&SourceSpan::new(source.clone(), 0..0))
        .with_hint(hint))
}

/// Kinds of pairs that a gear file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairKind {
    /// Involute gears on parallel axes.
    Cylindrical,
    /// Gears of a varying ratio.
    NonCircular,
    /// Bevel and hypoid gears by machine settings.
    Bevel,
    /// A worm with its wheel.
    Worm,
    /// Helical gears on crossed axes.
    Crossed,
    /// A helicoid with the tool that cuts it.
    Helicoid,
}

/// Kinds of pairs by their words.
const KINDS: [(&str, PairKind); 5] = [
    ("cylindrical", PairKind::Cylindrical),
    ("non-circular", PairKind::NonCircular),
    ("bevel", PairKind::Bevel),
    ("worm", PairKind::Worm),
    ("crossed", PairKind::Crossed),
];

/// The kind of pair in a gear file; cylindrical where it states none.
///
/// # Errors
/// A kind that is not known.
pub fn pair_kind(source: &Arc<SourceFile>) -> Result<PairKind, Error> {
    let root = toml::parse(source).root;
    if root.get("helicoid").is_some() {
        return Ok(PairKind::Helicoid);
    }
    let kind = root.table("pair").and_then(|(pair, _)| pair.get("kind"));
    let Some((Value::String(word), span)) = kind.map(|e| (&e.item.value, &e.item.span)) else {
        return Ok(PairKind::Cylindrical);
    };
    if let Some((_, kind)) = KINDS.iter().find(|(known, _)| known == word) {
        return Ok(*kind);
    }
    let hint = match word.as_str() {
        "hypoid" | "spiral-bevel" | "straight-bevel" => {
            "write \"bevel\"; a hypoid pair also has `offset` in `pair`".into()
        }
        "spur" | "helical" => "write \"cylindrical\"".into(),
        _ => format!(
            "it takes {}",
            quoted_list(KINDS.iter().map(|(word, _)| *word))
        ),
    };
    let message = format!("`kind` cannot be \"{}\"", truncate(word));
    Err(Error::new(Code::OutOfRange, message)
        .with_span(span)
        .with_hint(hint))
}

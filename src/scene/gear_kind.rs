//! Kind of a gear file: what pair it describes, or why it is none.

use std::sync::Arc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::{SourceFile, SourceSpan};
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

/// The kind of pair in a gear file; cylindrical where it states no other kind that is known.
pub fn pair_kind(source: &Arc<SourceFile>) -> PairKind {
    let root = toml::parse(source).root;
    if root.get("helicoid").is_some() {
        return PairKind::Helicoid;
    }
    let kind = root.table("pair").and_then(|(pair, _)| pair.get("kind"));
    match kind.map(|entry| &entry.item.value) {
        Some(Value::String(kind)) if kind == "non-circular" => PairKind::NonCircular,
        Some(Value::String(kind)) if kind == "bevel" => PairKind::Bevel,
        Some(Value::String(kind)) if kind == "worm" => PairKind::Worm,
        Some(Value::String(kind)) if kind == "crossed" => PairKind::Crossed,
        _ => PairKind::Cylindrical,
    }
}

//! Views of a result that only a page shows, because they move: their kind and data.

use serde_json::Value;

/// A view of a result.
#[derive(Debug, Clone)]
pub struct View {
    /// Kind of the view.
    pub kind: ViewKind,
    /// Title.
    pub title: String,
    /// Suffixes of the figures that a page omits, because the view shows what they show.
    pub replaces: &'static [&'static str],
    /// Data of the view, as its script reads them.
    pub data: Value,
}

/// Kind of a view; each has a script of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ViewKind {
    /// Mode shapes in a schematic of the drive train.
    Modes,
    /// Mode shapes on the points of a test.
    Points,
    /// Profiles of cylindrical gears in mesh.
    Teeth,
    /// A pair of gears in space with the contact on its flanks.
    Pair,
    /// Flanks with their deviations as surfaces.
    Surface,
}

impl ViewKind {
    /// Name in the data of a page.
    pub fn name(self) -> &'static str {
        match self {
            ViewKind::Modes => "modes",
            ViewKind::Points => "points",
            ViewKind::Teeth => "teeth",
            ViewKind::Pair => "pair",
            ViewKind::Surface => "surface",
        }
    }
}

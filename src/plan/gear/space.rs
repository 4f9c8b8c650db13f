//! Results of worm pairs, crossed pairs and helicoids by their kind.

use std::sync::Arc;

use super::sheet::GearSheet;
use super::{axodes, crossed, disk_tool, hob, plane_worm, worm};
use crate::base::error::Errors;
use crate::base::flags::Flags;
use crate::base::source_span::SourceFile;
use crate::plan::decision::StageDecision;
use crate::scene::gear_kind::PairKind;
use crate::scene::{crossed_file, helicoid_file, hob_file, plane_worm_file, worm_file};

/// Computes what a file determines.
///
/// # Errors
/// Everything wrong in the file and in the flags; gears that cannot be made or never touch.
pub fn run(kind: PairKind, source: &Arc<SourceFile>, flags: &Flags) -> Result<GearSheet, Errors> {
    Ok(match kind {
        PairKind::Worm if plane_worm_file::is_plane_worm(source) => {
            plane_worm::run(&plane_worm_file::read(source, flags)?)?
        }
        PairKind::Worm => worm::run(&worm_file::read(source, flags)?)?,
        PairKind::Crossed => crossed::run(&crossed_file::read(source, flags)?)?,
        _ if hob_file::is_hob(source) => hob::run(&hob_file::read(source, flags)?)?,
        _ => disk_tool::run(&helicoid_file::read(source, flags)?)?,
    })
}

/// The stages of a file that run, and those left out with the reason.
///
/// # Errors
/// Everything wrong in the file and in the flags.
pub fn plan(
    kind: PairKind,
    source: &Arc<SourceFile>,
    flags: &Flags,
) -> Result<Vec<(&'static str, StageDecision)>, Errors> {
    Ok(match kind {
        PairKind::Worm if plane_worm_file::is_plane_worm(source) => {
            plane_worm::plan(&plane_worm_file::read(source, flags)?)
        }
        PairKind::Worm => worm::plan(&worm_file::read(source, flags)?),
        PairKind::Crossed => crossed::plan(&crossed_file::read(source, flags)?),
        _ if hob_file::is_hob(source) => hob::plan(&hob_file::read(source, flags)?),
        _ => disk_tool::plan(&helicoid_file::read(source, flags)?),
    })
}

/// Suffixes of the figures.
pub fn figures(kind: PairKind, source: &Arc<SourceFile>) -> &'static [&'static str] {
    match kind {
        PairKind::Helicoid if hob_file::is_hob(source) => &hob::FIGURES,
        PairKind::Helicoid => &disk_tool::FIGURES,
        _ => &["", axodes::SUFFIX],
    }
}

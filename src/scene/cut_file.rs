//! Reads a bevel file with `[cut]` and the spindle history that it names.

use std::sync::Arc;

use super::bevel_file::{self, BevelFile};
use super::csv_table::CsvTable;
use super::cut_study::{CutStudy, SpindleHistory};
use super::machine_settings::Process;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceFile;

/// A pair with the cut of its flanks.
#[derive(Debug, Clone)]
pub struct CutFile {
    /// The pair.
    pub bevel: BevelFile,
    /// The cut.
    pub study: CutStudy,
    /// Times, s, and angles, rad, of the spindle history.
    pub history: Option<[Vec<f64>; 2]>,
    /// The gear file and the history.
    pub sources: Vec<Arc<SourceFile>>,
}

/// Reads one.
///
/// # Errors
/// Everything wrong in it, in its history, or a file without `[cut]`.
pub fn read(source: &Arc<SourceFile>) -> Result<CutFile, Errors> {
    let bevel = bevel_file::read(source, &Flags::default())?;
    let Some(study) = bevel.cut.clone() else {
        let error = Error::new(Code::MissingKey, "the file has no [cut]").with_span(&bevel.span);
        let hint = "write [cut] with `blades`, `cutter_speed` and `cradle_speed`";
        return Err(error.with_hint(hint).into());
    };
    check(&bevel, &study)?;
    let mut sources = vec![source.clone()];
    let history = match &study.history {
        None => None,
        Some(history) => {
            let (columns, source) = read_history(history)?;
            sources.push(source);
            Some(columns)
        }
    };
    Ok(CutFile {
        bevel,
        study,
        history,
        sources,
    })
}

/// Whether the cut has flanks to cut and a feed for those that roll.
fn check(bevel: &BevelFile, study: &CutStudy) -> Result<(), Error> {
    let is_cut = |k: &usize| study.member.is_none_or(|member| member == *k);
    let cut: Vec<usize> = [0, 1].into_iter().filter(is_cut).collect();
    let has_flank = |k: &usize| bevel.members[*k].flanks.iter().any(Option::is_some);
    if !cut.iter().any(has_flank) {
        return Err(
            Error::new(Code::MissingKey, "no settings of a flank to cut are given")
                .with_span(&study.span)
                .with_hint("give `concave` or `convex` of the member that is cut"),
        );
    }
    let rolls = |k: &usize| bevel.members[*k].process == Process::Generated;
    if study.cradle_speed.is_none() && cut.iter().any(rolls) {
        return Err(Error::new(Code::MissingKey, "[cut] has no `cradle_speed`")
            .with_span(&study.span)
            .with_hint("generated flanks are cut as the cradle rolls, such as \"4 deg/s\""));
    }
    Ok(())
}

/// Times and angles of a history.
fn read_history(history: &SpindleHistory) -> Result<([Vec<f64>; 2], Arc<SourceFile>), Errors> {
    let names = [
        ("time", QuantityKind::Time),
        (history.column.as_str(), QuantityKind::Angle),
    ];
    let table = CsvTable::read(&history.path, &names)?;
    let [times, angles] = &table.columns[..] else {
        return Err(Error::new(Code::MissingKey, "the history has no columns").into());
    };
    if let Some(row) = times.windows(2).position(|pair| !(pair[1] > pair[0])) {
        let message = format!("row {}: the time does not increase", row + 2);
        return Err(table.locate(Error::new(Code::OutOfRange, message)).into());
    }
    if times.len() < 2 {
        let message = "the history has fewer than two rows";
        return Err(table.locate(Error::new(Code::OutOfRange, message)).into());
    }
    Ok(([times.clone(), angles.clone()], table.source.clone()))
}

//! `geardyn gear`: gears from their theory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::{CorrectArgs, CutArgs, GearAction, GearArgs, OutputArgs, ReverseArgs};
use super::destination::output_error;
use super::present::Outputs;
use super::{files, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::source_span::SourceFile;
use crate::plan::gear::{bevel, correction, cut, non_circular, reversal, run, space, synthesis};
use crate::report::bevel::{BevelReport, FIGURES};
use crate::report::correction::CorrectionReport;
use crate::report::flank_file::{self, FlankFormat};
use crate::report::gear::GearReport;
use crate::report::gear_cut::{self, CutReport};
use crate::report::gear_plan::GearPlan;
use crate::report::gear_reversal::ReversalReport;
use crate::report::non_circular::NonCircularReport;
use crate::report::outline_file::{NamedOutline, OutlineFormat};
use crate::report::presentation::Presentation;
use crate::scene::gear_file;
use crate::scene::gear_kind::{self, PairKind};
use crate::scene::{
    bevel_file, cut_file, ease_off_target, gear_readings, measured_grid, non_circular_file,
};

/// Computes what a file determines and prints it.
///
/// # Errors
/// Whatever is wrong with the file, the flags, the gears, or what is to be written.
pub fn run(args: &GearArgs) -> Result<u8, Errors> {
    match (&args.action, &args.file) {
        (Some(GearAction::Reverse(args)), _) => reverse(args),
        (Some(GearAction::Correct(args)), _) => correct(args),
        (Some(GearAction::Cut(args)), _) => cut_by_blades(args),
        (None, Some(file)) => compute(args, file),
        (None, None) => Err(Error::new(Code::Usage, "no gear file is named")
            .with_hint("see --help")
            .into()),
    }
}

fn compute(args: &GearArgs, path: &Path) -> Result<u8, Errors> {
    let (source, flags) = (load::load(path)?, &args.mesh.flags);
    let quiet = args.out.quiet || args.out.json;
    gear_kind::check_is_gear_file(&source)?;
    match gear_kind::pair_kind(&source)? {
        PairKind::Cylindrical => {
            let file = gear_file::read(&source, flags)?;
            let outputs = GearOutputs::check(args, &CYLINDRICAL_FIGURES, &[path.to_path_buf()])?;
            let result = progress::with_spinner("loaded contact", quiet, || run::run(&file))?;
            let file = &file;
            let answer = GearReport { file, result };
            outputs.present(&answer, || answer.outlines())
        }
        PairKind::NonCircular => {
            let file = non_circular_file::read(&source, flags)?;
            let inputs: Vec<PathBuf> = file
                .sources
                .iter()
                .map(|s| PathBuf::from(&s.path))
                .collect();
            let outputs = GearOutputs::check(args, &["", "ratio"], &inputs)?;
            let result = non_circular::run(&file)?;
            let file = &file;
            let answer = NonCircularReport { file, result };
            outputs.present(&answer, || answer.outlines())
        }
        kind @ (PairKind::Worm | PairKind::Crossed | PairKind::Helicoid) => {
            let inputs = [path.to_path_buf()];
            let outputs = GearOutputs::check(args, space::figures(kind, &source), &inputs)?;
            outputs.present(&space::run(kind, &source, flags)?, Vec::new)
        }
        PairKind::Bevel => {
            let file = bevel_file::read(&source, flags)?;
            let outputs = GearOutputs::check(args, &FIGURES, &[path.to_path_buf()])?;
            let result = progress::with_spinner("tooth contact", quiet, || bevel::run(&file))?;
            outputs.present_bevel(&BevelReport {
                file: &file,
                result,
            })
        }
    }
}

/// The text of a gear file; `None` where the file is of another kind.
///
/// # Errors
/// It cannot be read.
pub fn gear_source(path: &Path) -> Result<Option<Arc<SourceFile>>, Error> {
    let source = load::load(path)?;
    Ok(gear_kind::is_gear_file(&source).then_some(source))
}

/// The stages of a gear file, with its texts.
///
/// # Errors
/// Whatever is wrong with the file.
pub fn stages(source: &Arc<SourceFile>) -> Result<GearPlan, Errors> {
    let flags = Flags::default();
    Ok(match gear_kind::pair_kind(source)? {
        PairKind::Cylindrical => GearPlan {
            stages: run::plan(&gear_file::read(source, &flags)?),
            sources: vec![source.clone()],
        },
        PairKind::NonCircular => {
            let file = non_circular_file::read(source, &flags)?;
            GearPlan {
                stages: non_circular::plan(&file),
                sources: file.sources,
            }
        }
        kind @ (PairKind::Worm | PairKind::Crossed | PairKind::Helicoid) => GearPlan {
            stages: space::plan(kind, source, &flags)?,
            sources: vec![source.clone()],
        },
        PairKind::Bevel => GearPlan {
            stages: bevel::plan(&bevel_file::read(source, &flags)?),
            sources: vec![source.clone()],
        },
    })
}

/// Suffixes of the figures of a cylindrical pair.
const CYLINDRICAL_FIGURES: [&str; 7] = [
    "",
    "sliding",
    "profile",
    "mesh",
    "stiffness",
    "sharing",
    "harris",
];

/// Outputs of `gear FILE`: those of every command, and the outlines.
struct GearOutputs<'a> {
    outputs: Outputs<'a>,
    outline: Option<(&'a Path, OutlineFormat)>,
    flank: Option<(&'a Path, FlankFormat)>,
}

impl<'a> GearOutputs<'a> {
    /// Checks the files before any work.
    fn check(
        args: &'a GearArgs,
        figures: &[&str],
        inputs: &[PathBuf],
    ) -> Result<GearOutputs<'a>, Error> {
        Ok(GearOutputs {
            outline: args.outline.as_deref().map(outline_format).transpose()?,
            flank: args.flank.as_deref().map(flank_format).transpose()?,
            outputs: Outputs::check(&args.out, figures, &[&args.outline, &args.flank], inputs)?,
        })
    }

    /// Writes the outlines and presents the result.
    fn present(
        mut self,
        answer: &dyn Presentation,
        outlines: impl FnOnce() -> Vec<NamedOutline>,
    ) -> Result<u8, Errors> {
        if self.flank.is_some() {
            return Err(
                nothing_to_write("flanks", "omit --flank: only bevel pairs write flanks").into(),
            );
        }
        if let Some((path, format)) = self.outline {
            let outlines = outlines();
            if outlines.is_empty() {
                return Err(nothing_to_write("outlines", NO_OUTLINES).into());
            }
            self.outputs.write(path, |to| {
                let written = format.write(&outlines, to);
                written.map_err(|e| output_error(path, &e))
            })?;
        }
        self.outputs.present(answer)
    }

    /// Writes the flanks and presents the result.
    fn present_bevel(mut self, answer: &BevelReport) -> Result<u8, Errors> {
        if self.outline.is_some() {
            return Err(nothing_to_write("outlines", NO_OUTLINES).into());
        }
        if let Some((path, format)) = self.flank {
            let (result, sides) = (&answer.result, answer.file.contact.side.flanks());
            let failed = |e: std::io::Error| output_error(path, &e);
            match format {
                FlankFormat::Csv => {
                    let table = flank_file::table(result);
                    self.outputs
                        .write(path, |to| table.write_csv(to).map_err(failed))?;
                }
                FlankFormat::Stl => {
                    let solids = flank_file::solids(result, sides);
                    if solids.is_empty() {
                        return Err(nothing_to_write("whole teeth", "describe both flanks with mean_normal_thickness, or write --flank FILE.csv").into());
                    }
                    self.outputs.write(path, |to| {
                        flank_file::write_stl(&solids, to).map_err(failed)
                    })?;
                }
            }
        }
        self.outputs.present(answer)
    }
}

/// An output that this pair does not have.
fn nothing_to_write(what: &str, remedy: &str) -> Error {
    Error::new(Code::Usage, format!("there are no {what} to write")).with_hint(remedy)
}

/// The remedy where a pair has no outlines.
const NO_OUTLINES: &str = "omit --outline: only cylindrical and non-circular gears have outlines";

/// The file of flanks with the format of its suffix.
fn flank_format(path: &Path) -> Result<(&Path, FlankFormat), Error> {
    files::check_extension(path, &FlankFormat::SUFFIXES)?;
    let suffix = path.extension().and_then(|suffix| suffix.to_str());
    Ok((path, FlankFormat::of_suffix(suffix.unwrap_or_default())))
}

/// The file of outlines with the format of its suffix.
fn outline_format(path: &Path) -> Result<(&Path, OutlineFormat), Error> {
    files::check_extension(path, &OutlineFormat::SUFFIXES)?;
    let suffix = path.extension().and_then(|suffix| suffix.to_str());
    let format = OutlineFormat::of_suffix(suffix.unwrap_or_default());
    Ok((path, format))
}

/// Finds the standard gears that readings may come from.
fn reverse(args: &ReverseArgs) -> Result<u8, Errors> {
    let file = gear_readings::read(&load::load(&args.readings)?)?;
    let out = OutputArgs {
        json: args.json,
        csv: args.csv.clone(),
        svg: None,
        log: None,
        page: args.page.clone(),
        quiet: args.quiet,
    };
    let outputs = Outputs::check(&out, &[], &[], std::slice::from_ref(&args.readings))?;
    let result = reversal::run(&file)?;
    outputs.present(&ReversalReport {
        file: &file,
        result,
    })
}

/// The gear file of a bevel pair; another pair is refused.
fn load_bevel(path: &Path, message: &str, hint: &str) -> Result<Arc<SourceFile>, Errors> {
    let source = load::load(path)?;
    gear_kind::check_is_gear_file(&source)?;
    match gear_kind::pair_kind(&source)? {
        PairKind::Bevel => Ok(source),
        _ => Err(Error::new(Code::Usage, message).with_hint(hint).into()),
    }
}

/// Finds the settings of the next cut of a measured bevel gear.
fn correct(args: &CorrectArgs) -> Result<u8, Errors> {
    let source = load_bevel(
        &args.file,
        "only settings of bevel gears can be corrected",
        "name a gear file with pair = { kind = \"bevel\", … }",
    )?;
    let (file, study) = bevel_file::read_for_correction(&source, &args.study.flags)?;
    let measured = args.measured.as_ref().or(args.target.as_ref());
    let inputs: Vec<PathBuf> = measured.into_iter().chain([&args.file]).cloned().collect();
    let outputs = Outputs::check(&args.out, &[""], &[], &inputs)?;
    let result = match (&args.measured, &args.target) {
        (Some(grid), _) => correction::run(&file, &study, &measured_grid::read(grid)?)?,
        (None, Some(target)) => {
            synthesis::run(&file, &study, &ease_off_target::read(&load::load(target)?)?)?
        }
        (None, None) => {
            return Err(Error::new(Code::Usage, "no grid and no target is named")
                .with_hint("see --help")
                .into());
        }
    };
    outputs.present(&CorrectionReport {
        title: file.title.clone(),
        steps: study.steps,
        result,
    })
}

/// Cuts the flanks of a bevel pair by discrete blades.
fn cut_by_blades(args: &CutArgs) -> Result<u8, Errors> {
    let source = load_bevel(
        &args.file,
        "only bevel pairs with machine settings can be cut",
        "name a gear file with pair = { kind = \"bevel\", … } and [cut]",
    )?;
    let file = cut_file::read(&source)?;
    let inputs: Vec<PathBuf> = (file.sources.iter())
        .map(|source| PathBuf::from(&source.path))
        .collect();
    let flank = args.flank.as_deref().map(flank_format).transpose()?;
    let files = [&args.flank, &args.chips];
    let mut outputs = Outputs::check(&args.out, &gear_cut::FIGURES, &files, &inputs)?;
    let quiet = args.out.quiet || args.out.json;
    let result = progress::with_spinner("computing the cut flanks", quiet, || cut::run(&file))?;
    let report = CutReport {
        file: &file,
        result,
    };
    let chips = match &args.chips {
        Some(path) => Some((path, report.chip_table().ok_or_else(|| no_chips(&report))?)),
        None => None,
    };
    if let Some((path, format)) = flank {
        let failed = |e: std::io::Error| output_error(path, &e);
        outputs.write(path, |to| match format {
            FlankFormat::Csv => report.nodes().write_csv(to).map_err(failed),
            FlankFormat::Stl => flank_file::write_stl(&report.surfaces(), to).map_err(failed),
        })?;
    }
    if let Some((path, table)) = chips {
        outputs.write(path, |to| {
            table.write_csv(to).map_err(|e| output_error(path, &e))
        })?;
    }
    outputs.present(&report)
}

/// No member has chips to write, or both have.
fn no_chips(report: &CutReport) -> Error {
    let reasons = report.result.chips.iter().filter_map(|c| c.as_ref().err());
    let reasons: Vec<&str> = reasons.map(String::as_str).collect();
    let (message, hint) = match reasons.is_empty() {
        true => (
            "--chips writes one member, but both have chips".to_string(),
            "set `member` in [cut]",
        ),
        false => (
            format!("no chips to write: {}", reasons.join("; ")),
            "chips need both flanks of a member generated in one setting",
        ),
    };
    Error::new(Code::Usage, message).with_hint(hint)
}

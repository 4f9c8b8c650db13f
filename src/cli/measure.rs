//! `geardyn measure`: a gear's charts and readings, graded.

use std::path::{Path, PathBuf};

use super::args::MeasureArgs;
use super::files::{self, Files};
use super::{epilogue, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::plan::measure::run::{self, Answer};
use crate::report;
use crate::scene::measured::{self, MeasuredGear};

/// Evaluates, grades and prints; 1 where a value is out of what was asked.
///
/// # Errors
/// Whatever is wrong with the files, their charts, or what is to be written.
pub fn run(args: &MeasureArgs) -> Result<u8, Errors> {
    let gear = read(&args.file)?;
    let mut files = planned(args, &gear)?;
    let answer = run::run(&gear)?;
    if let Some(path) = &args.csv {
        files.write(path, report::measure::csv(&gear, &answer).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let title = &gear.title;
        if let Some(picture) = report::measure_picture::unrolled(title, &answer.drawn) {
            files.write(path, picture.as_bytes())?;
        }
        if let Some(picture) = report::measure_polar::polar(title, &answer.drawn) {
            files.write(&files::beside(path, "polar"), picture.as_bytes())?;
        }
    }
    let written = files.finish()?;
    match args.json {
        true => {
            let document = report::measure::json(&gear, &answer);
            output::document(&document)?;
        }
        false => output::print(&report::measure_table::deviations(&gear, &answer))?,
    }
    if !args.quiet && !args.json {
        output::tell(&epilogue(&answer));
        output::tell(&epilogue::written(&written));
        if args.svg.is_some() && answer.drawn.is_empty() {
            output::tell(
                "nothing is drawn: spans, chords, balls and base pitches are single values\n",
            );
        }
    }
    Ok(u8::from(answer.within() == Some(false)))
}

fn read(path: &Path) -> Result<MeasuredGear, Errors> {
    let hint =
        "name a TOML file with [measured_gear], which says what the columns of its charts are";
    if path.extension().is_none_or(|e| e != "toml") {
        let message = format!("{} does not describe a measured gear", path.display());
        return Err(Error::new(Code::Usage, message).hint(hint).into());
    }
    let source = load::load(path)?;
    if !measured::is_measured(&source) {
        // A syntax error says more than a missing table.
        if let Some(broken) = crate::base::toml::parse(&source).broken {
            return Err(broken.into());
        }
        let message = format!("{} has no [measured_gear]", path.display());
        return Err(Error::new(Code::MissingKey, message).hint(hint).into());
    }
    measured::read(&source)
}

/// What was left out, doubts.
fn epilogue(answer: &Answer) -> String {
    let mut text = String::from("\n");
    text += &epilogue::left_out(&answer.plan);
    text += &epilogue::warnings(&answer.warnings);
    text
}

/// The files to write, checked before any work is done.
fn planned(args: &MeasureArgs, gear: &MeasuredGear) -> Result<Files, Error> {
    let mut outputs: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        outputs.extend([path.clone(), files::beside(path, "polar")]);
    }
    let mut inputs = vec![args.file.clone()];
    inputs.extend(gear.charts.iter().map(|chart| chart.file.clone()));
    inputs.extend(gear.demand.iter().filter_map(|d| d.table.clone()));
    Files::new(&outputs, &inputs)
}

//! `geardyn measure`: a gear's charts and readings, graded.

use std::path::{Path, PathBuf};

use super::args::MeasureArgs;
use super::files::{self, OutputFiles};
use super::{footer, output};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::plan::measure::run::{self, MeasurementResult};
use crate::report;
use crate::scene::measured_gear::{self, MeasuredGear};

/// Evaluates, grades and prints; 1 where a value is out of what was asked.
///
/// # Errors
/// Whatever is wrong with the files, their charts, or what is to be written.
pub fn run(args: &MeasureArgs) -> Result<u8, Errors> {
    let gear = read(&args.file)?;
    let mut files = output_files(args, &gear)?;
    let result = run::run(&gear)?;
    if let Some(path) = &args.out.csv {
        files.write(path, report::measure::csv(&gear, &result).as_bytes())?;
    }
    if let Some(path) = &args.out.svg {
        let title = &gear.title;
        if let Some(plot) = report::measure_plot::draw_charts(title, &result.plots) {
            files.write(path, plot.as_bytes())?;
        }
        if let Some(plot) = report::measure_polar_plot::draw_polar(title, &result.plots) {
            files.write(&files::sibling_path(path, "polar"), plot.as_bytes())?;
        }
    }
    let written = files.finish()?;
    match args.out.json {
        true => {
            let document = report::measure::json(&gear, &result);
            output::document(&document)?;
        }
        false => output::print(&report::measure_table::deviations(&gear, &result))?,
    }
    if !args.out.quiet && !args.out.json {
        output::print_note(&footer(&result));
        output::print_note(&footer::written_files(&written));
        if args.out.svg.is_some() && result.plots.is_empty() {
            output::print_note(
                "nothing is drawn: spans, chords, balls and base pitches are single values\n",
            );
        }
    }
    Ok(u8::from(result.is_within_limits() == Some(false)))
}

fn read(path: &Path) -> Result<MeasuredGear, Errors> {
    let hint =
        "name a TOML file with [measured_gear], which says what the columns of its charts are";
    if path.extension().is_none_or(|e| e != "toml") {
        let message = format!("{} does not describe a measured gear", path.display());
        return Err(Error::new(Code::Usage, message).with_hint(hint).into());
    }
    let source = load::load(path)?;
    if !measured_gear::is_measured_gear(&source) {
        // A syntax error says more than a missing table.
        if let Some(broken) = crate::base::toml::parse(&source).syntax_error {
            return Err(broken.into());
        }
        let message = format!("{} has no [measured_gear]", path.display());
        return Err(Error::new(Code::MissingKey, message).with_hint(hint).into());
    }
    measured_gear::read(&source)
}

/// What was left out, warnings.
fn footer(result: &MeasurementResult) -> String {
    let mut text = String::from("\n");
    text += &footer::omitted_steps(&result.plan);
    text += &footer::warnings(&result.diagnostics);
    text
}

/// The files to write, checked before any work is done.
fn output_files(args: &MeasureArgs, gear: &MeasuredGear) -> Result<OutputFiles, Error> {
    let mut outputs: Vec<PathBuf> = args.out.csv.iter().cloned().collect();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        outputs.extend([path.clone(), files::sibling_path(path, "polar")]);
    }
    let mut inputs = vec![args.file.clone()];
    inputs.extend(gear.charts.iter().map(|chart| chart.file.clone()));
    inputs.extend(gear.requirement.iter().filter_map(|d| d.table.clone()));
    OutputFiles::new(&outputs, &inputs)
}

//! `geardyn measure`: a gear's charts and readings, graded.

use std::path::{Path, PathBuf};

use super::args::MeasureArgs;
use super::present::Outputs;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::plan::measure::run::run as evaluate;
use crate::report::measure::MeasurementReport;
use crate::scene::gear_readings;
use crate::scene::measured_gear::{self, MeasuredGear};

/// Evaluates, grades and prints; exit code 1 if a value is outside its required grade.
///
/// # Errors
/// Whatever is wrong with the files, their charts, or what is to be written.
pub fn run(args: &MeasureArgs) -> Result<u8, Errors> {
    let gear = read(&args.file)?;
    let mut inputs = vec![args.file.clone()];
    inputs.extend(gear.charts.iter().map(|chart| chart.file.clone()));
    inputs.extend(gear.gear_file.iter().map(|file| PathBuf::from(&file.path)));
    inputs.extend(gear.requirement.iter().filter_map(|d| d.table.clone()));
    let outputs = Outputs::check(&args.out, &["", "polar"], &[], &inputs)?;
    let result = evaluate(&gear)?;
    outputs.present(&MeasurementReport {
        gear: &gear,
        result,
    })
}

fn read(path: &Path) -> Result<MeasuredGear, Errors> {
    let hint = "name a TOML file with [measured_gear], which describes the columns of its charts";
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
    if gear_readings::is_readings_file(&source) {
        let message = format!("{} has readings of a gear without `module`", path.display());
        let hint = format!("`geardyn gear reverse {}` finds it", path.display());
        return Err(Error::new(Code::MissingKey, message).with_hint(hint).into());
    }
    measured_gear::read(&source)
}

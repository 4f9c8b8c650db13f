//! `geardyn gear`: gears from their theory.

use std::path::Path;

use super::args::{GearAction, GearArgs, OutputArgs, ReverseArgs};
use super::present::Outputs;
use super::progress;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::load;
use crate::plan::gear::{reversal, run};
use crate::report::gear::GearAnswer;
use crate::report::gear_reversal::ReversalReport;
use crate::scene::{gear_file, gear_readings};

/// Computes what a file determines and prints it.
///
/// # Errors
/// Whatever is wrong with the file, the flags, the gears, or what is to be written.
pub fn run(args: &GearArgs) -> Result<u8, Errors> {
    match (&args.action, &args.file) {
        (Some(GearAction::Reverse(args)), _) => reverse(args),
        (None, Some(file)) => compute(args, file),
        (None, None) => Err(Error::new(Code::Usage, "no gear file is named")
            .with_hint("see --help")
            .into()),
    }
}

fn compute(args: &GearArgs, path: &Path) -> Result<u8, Errors> {
    let source = load::load(path)?;
    let file = gear_file::read(&source, &args.mesh.flags)?;
    let figures = ["", "sliding", "mesh", "harris"];
    let outputs = Outputs::check(&args.out, &figures, &[], &[path.to_path_buf()])?;
    let quiet = args.out.quiet || args.out.json;
    let result = progress::with_spinner("loading the teeth", quiet, || run::run(&file))?;
    outputs.present(&GearAnswer {
        file: &file,
        result,
    })
}

/// Finds the standard gears that readings may come from.
fn reverse(args: &ReverseArgs) -> Result<u8, Errors> {
    let file = gear_readings::read(&load::load(&args.readings)?)?;
    let out = OutputArgs {
        json: args.json,
        csv: args.csv.clone(),
        svg: None,
        quiet: args.quiet,
    };
    let outputs = Outputs::check(&out, &[], &[], std::slice::from_ref(&args.readings))?;
    let result = reversal::run(&file)?;
    outputs.present(&ReversalReport {
        file: &file,
        result,
    })
}

//! `geardyn gear`: gears from their theory.

use super::args::GearArgs;
use super::present::Outputs;
use super::progress;
use crate::base::error::Errors;
use crate::base::load;
use crate::plan::gear::run::run as compute;
use crate::report::gear::GearAnswer;
use crate::scene::gear_file;

/// Computes what the file determines and prints it.
///
/// # Errors
/// Whatever is wrong with the file, the flags, the gears, or what is to be written.
pub fn run(args: &GearArgs) -> Result<u8, Errors> {
    let source = load::load(&args.file)?;
    let file = gear_file::read(&source, &args.mesh.flags)?;
    let figures = ["", "sliding", "mesh", "harris"];
    let outputs = Outputs::check(&args.out, &figures, &[], std::slice::from_ref(&args.file))?;
    let quiet = args.out.quiet || args.out.json;
    let result = progress::with_spinner("loading the teeth", quiet, || compute(&file))?;
    outputs.present(&GearAnswer {
        file: &file,
        result,
    })
}

//! `geardyn response`: steady answers to steady excitation.

use super::args::{FrfFormArg, ResponseArgs, ResponseMethodArg};
use super::present::{self, Outputs};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::response::run::{ResponseResult, run as solve};
use crate::report::presentation::StudyReport;
use crate::scene::study::{self, ResponseMethodTag, ResponseQuantity, ResponseStudy, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study_from_args(args, &scene)?;
    let outputs = Outputs::check(&args.out, &["", "nyquist"], &[], &scene.files())?;
    let drawn = args.out.svg.is_some();
    let report = report(&scene, &study, drawn, args.out.quiet)?;
    outputs.present(&report)
}

/// Frequency responses; `drawn`: figures are wanted.
///
/// # Errors
/// Whatever is wrong with the machine, the study or the solution.
pub fn report<'a>(
    scene: &'a Scene,
    study: &ResponseStudy,
    drawn: bool,
    quiet: bool,
) -> Result<StudyReport<'a, ResponseResult>, Error> {
    present::solve(scene, "answering by frequency", quiet, |machine| {
        solve(machine, study, drawn)
    })
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<ResponseStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::Response(response) => Some(response.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let or = |given: &Vec<String>, listed: Vec<String>| {
        if given.is_empty() {
            listed
        } else {
            given.clone()
        }
    };
    if args
        .lines
        .is_some_and(|n| !(2..=study::MAX_LINES).contains(&n))
    {
        let message = format!("--lines takes a count from 2 to {}", study::MAX_LINES);
        return Err(Error::new(Code::OutOfRange, message));
    }
    let speed = args
        .speed
        .as_deref()
        .map(|text| quantity::parse_or_bare(text, QuantityKind::Speed, "rpm", "--speed"))
        .transpose()?;
    let shown = args.kind.map(|word| match word {
        FrfFormArg::Receptance => ResponseQuantity::Receptance,
        FrfFormArg::Mobility => ResponseQuantity::Mobility,
        FrfFormArg::Accelerance => ResponseQuantity::Accelerance,
    });
    let way = args.method.map(|word| match word {
        ResponseMethodArg::Direct => ResponseMethodTag::Direct,
        ResponseMethodArg::Modal => ResponseMethodTag::Modal,
    });
    Ok(ResponseStudy {
        inputs: or(&args.input, listed.inputs),
        outputs: or(&args.output, listed.outputs),
        fixed_dofs: or(&args.hold, listed.fixed_dofs),
        motion_quantity: shown.or(listed.motion_quantity),
        band: args
            .band
            .as_deref()
            .map(|text| study::parse_band(text, "--band"))
            .transpose()?
            .or(listed.band),
        lines: args.lines.or(listed.lines),
        speed: speed.or(listed.speed),
        way: way.or(listed.way),
    })
}

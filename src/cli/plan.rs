//! `geardyn plan`: what would be computed, and what could be left out.

use super::args::PlanArgs;
use super::{output, study};
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::modes::basis;
use crate::modes::equations::Case;
use crate::modes::reduction::{Advice, advise};
use crate::plan::prepared::Prepared;
use crate::plan::stages::{Plan, solver};
use crate::report;
use crate::scene;

/// Prints the plan of a study of modes.
///
/// # Errors
/// Whatever is wrong with the file or the flags.
pub fn run(args: &PlanArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.model)?;
    let study = study::of(&args.study, &scene)?;
    let prepared = Prepared::new(&scene.model)?;
    let plan = Plan::modes(&prepared, &study);
    let band = args
        .advise
        .as_deref()
        .map(|text| units::parse_or_bare(text, Kind::Frequency, "Hz", "--advise"));
    let band_hz = band.transpose()?.map(|omega| omega / std::f64::consts::TAU);
    let advice = band_hz
        .map(|hz| Ok::<_, Error>((hz, could_leave_out(&prepared, hz, args.tolerance)?)))
        .transpose()?;
    if args.json {
        let mut document = report::json::plan(&scene.sources, plan.rows(), &prepared.warnings());
        if let Some((hz, advice)) = &advice {
            document["advice"] = report::systems::advice_json(&prepared.machine, advice, *hz);
        }
        output::print(&format!("{document:#}\n"))?;
        return Ok(0);
    }
    output::print(&report::table::plan(plan.rows()))?;
    if let Some((hz, advice)) = &advice {
        output::print(&report::system_tables::advice(
            &prepared.machine,
            advice,
            *hz,
        ))?;
    }
    Ok(0)
}

fn could_leave_out(prepared: &Prepared, hz: f64, tolerance: f64) -> Result<Advice, Error> {
    let Prepared {
        machine, linear, ..
    } = prepared;
    let basis = basis::solve(linear, solver(linear.n - linear.massless.len()))?;
    let case = Case {
        machine,
        linear,
        basis: &basis,
        speeds: None,
    };
    advise(&case, hz, tolerance)
}

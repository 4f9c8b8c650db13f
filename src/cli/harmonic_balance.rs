//! `geardyn response --harmonic-balance`: periodic motions over speed.

use std::path::PathBuf;

use super::args::ResponseArgs;
use super::files::{self, OutputFiles};
use super::{footer, output, progress};
use crate::base::error::{Error, Errors};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::harmonic_balance::{HarmonicBalanceResult, run as solve};
use crate::report;
use crate::scene::study::{HarmonicBalanceStudy, SpeedRange, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = study_from_args(args, &scene)?;
    let mut outputs: Vec<PathBuf> = args.out.csv.iter().cloned().collect();
    if let Some(path) = &args.out.svg {
        files::ends(path, &["svg"])?;
        outputs.push(path.clone());
    }
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = OutputFiles::new(&outputs, &inputs)?;
    let found = HarmonicBalanceReport::new(&scene, &study, args.out.quiet || args.out.json)?;
    if let Some(path) = &args.out.csv {
        files.write(path, report::harmonic_balance::csv(&found.0).as_bytes())?;
    }
    if let Some(path) = &args.out.svg {
        let plot = report::harmonic_balance::draw(&scene.model.title, &found.0);
        files.write(path, plot.as_bytes())?;
    }
    let written = files.finish()?;
    match args.out.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.out.quiet && !args.out.json {
        output::print_note(&found.epilogue());
        output::print_note(&footer::written_files(&written));
    }
    Ok(0)
}

/// Periodic motions with all that is said of them.
pub struct HarmonicBalanceReport(HarmonicBalanceResult);

impl HarmonicBalanceReport {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(
        scene: &Scene,
        study: &HarmonicBalanceStudy,
        quiet: bool,
    ) -> Result<HarmonicBalanceReport, Error> {
        let machine = PreparedMachine::new(&scene.model)?;
        let bar = progress::progress_bar("following the curve", quiet);
        let found = solve(&machine, study, &mut |share| bar(Some(share)));
        bar(None);
        found.map(HarmonicBalanceReport)
    }

    /// Folds, bifurcations, resonances.
    pub fn text(&self) -> String {
        report::harmonic_balance_table::table(&self.0)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::harmonic_balance::json(&scene.sources, &self.0)
    }

    /// What was done and left out, warnings.
    pub fn epilogue(&self) -> String {
        let (exact, rest) = self.0.refinement_counts();
        let mut text = format!("\n{exact} motions found by events, {rest} by orders\n");
        text += &footer::plan_steps(&self.0.plan);
        text += &footer::warnings(&self.0.diagnostics);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn study_from_args(args: &ResponseArgs, scene: &Scene) -> Result<HarmonicBalanceStudy, Error> {
    let listed = scene.studies.iter().find_map(|study| match &study.kind {
        StudyKind::HarmonicBalance(study) => Some(study.clone()),
        _ => None,
    });
    let listed = listed.unwrap_or_default();
    let speeds = args
        .harmonic_balance
        .as_deref()
        .map(|text| SpeedRange::parse(text, "--harmonic-balance"))
        .transpose()?;
    Ok(HarmonicBalanceStudy {
        speeds: speeds.or(listed.speeds),
        outputs: if args.output.is_empty() {
            listed.outputs
        } else {
            args.output.clone()
        },
        tolerance: args.tolerance.or(listed.tolerance),
        orders: args.orders.or(listed.orders),
        skip_event_refinement: args.orders_alone || listed.skip_event_refinement,
    })
}

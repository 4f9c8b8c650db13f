//! `geardyn response --harmonic-balance`: periodic motions over speed.

use std::path::PathBuf;

use super::args::ResponseArgs;
use super::files::{self, Files};
use super::{epilogue, output, progress};
use crate::base::error::{Error, Errors};
use crate::plan::prepared::Prepared;
use crate::plan::response::harmonic_balance::{Answer, run as solve};
use crate::report;
use crate::scene::study::{HarmonicBalanceStudy, SpeedRange, StudyKind};
use crate::scene::{self, Scene};

/// Solves and prints.
///
/// # Errors
/// Whatever is wrong with the file, the flags or the solution.
pub fn run(args: &ResponseArgs) -> Result<u8, Errors> {
    let scene = scene::read(&args.scene)?;
    let study = asked(args, &scene)?;
    let mut outputs: Vec<PathBuf> = args.csv.iter().cloned().collect();
    if let Some(path) = &args.svg {
        files::ends(path, &["svg"])?;
        outputs.push(path.clone());
    }
    let inputs: Vec<PathBuf> = scene.files();
    let mut files = Files::new(&outputs, &inputs)?;
    let found = Balanced::new(&scene, &study, args.quiet || args.json)?;
    if let Some(path) = &args.csv {
        files.write(path, report::harmonic_balance::csv(&found.0).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let picture = report::harmonic_balance::picture(&scene.model.title, &found.0);
        files.write(path, picture.as_bytes())?;
    }
    let written = files.finish()?;
    match args.json {
        true => output::document(&found.json(&scene))?,
        false => output::print(&found.text())?,
    }
    if !args.quiet && !args.json {
        output::tell(&found.epilogue());
        output::tell(&epilogue::written(&written));
    }
    Ok(0)
}

/// Periodic motions with all that is said of them.
pub struct Balanced(Answer);

impl Balanced {
    /// Prepares and solves.
    ///
    /// # Errors
    /// Whatever is wrong with the machine, the study or the solution.
    pub fn new(
        scene: &Scene,
        study: &HarmonicBalanceStudy,
        quiet: bool,
    ) -> Result<Balanced, Error> {
        let prepared = Prepared::new(&scene.model)?;
        let bar = progress::share("following the curve", quiet);
        let found = solve(&prepared, study, &mut |share| bar(Some(share)));
        bar(None);
        found.map(Balanced)
    }

    /// Folds, bifurcations, resonances.
    pub fn text(&self) -> String {
        report::harmonic_balance_table::table(&self.0)
    }

    /// The document.
    pub fn json(&self, scene: &Scene) -> serde_json::Value {
        report::harmonic_balance::json(&scene.sources, &self.0)
    }

    /// What was done and left out, doubts.
    pub fn epilogue(&self) -> String {
        let (exact, rest) = self.0.counts();
        let mut text = format!("\n{exact} motions found by events, {rest} by orders\n");
        text += &epilogue::steps(&self.0.plan);
        text += &epilogue::warnings(&self.0.warnings);
        text
    }
}

/// The study that is asked for: the first a scene lists, with what the flags say put in its place.
fn asked(args: &ResponseArgs, scene: &Scene) -> Result<HarmonicBalanceStudy, Error> {
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
        orders_alone: args.orders_alone || listed.orders_alone,
    })
}

//! `geardyn plan`: what would be computed, and what could be left out.

use serde_json::json;

use super::args::{IntegrationArgs, PlanArgs};
use super::{motion_flags, output, study};
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::modes::basis;
use crate::modes::equations::Case;
use crate::modes::reduction::{Advice, advise};
use crate::plan::motion::scene::MotionScene;
use crate::plan::motion::{choice, stages};
use crate::plan::prepared::Prepared;
use crate::plan::response::{harmonic_balance, run_up};
use crate::plan::stages::{Plan, Verdict, solver};
use crate::report;
use crate::scene::study::{SimulateStudy, StudyKind};
use crate::scene::{self, Scene};

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
        .map(|hz| {
            let tolerance = args.integration.tolerance.unwrap_or(DOES_NOT_MATTER);
            Ok::<_, Error>((hz, could_leave_out(&prepared, hz, tolerance)?))
        })
        .transpose()?;
    // With --advise the tolerance is that of the advice.
    let asked = IntegrationArgs {
        tolerance: (args.integration.tolerance).filter(|_| args.advise.is_none()),
        ..args.integration.clone()
    };
    let motions = motions(&scene, &prepared, &asked)?;
    if args.json {
        let mut document = report::json::plan(&scene.sources, plan.rows(), &prepared.warnings());
        let motion = |(kind, rows): &(&str, Rows)| json!({ "kind": kind, "stages": report::json::stages(each(rows)) });
        document["motions"] = motions.iter().map(motion).collect();
        if let Some((hz, advice)) = &advice {
            document["advice"] = report::systems::advice_json(&prepared.machine, advice, *hz);
        }
        output::document(&document)?;
        return Ok(0);
    }
    let asks_modes = motions.len() < scene.studies.len();
    if asks_modes || motions.is_empty() {
        output::print(&report::table::plan(plan.rows()))?;
    }
    for (at, (kind, rows)) in motions.iter().enumerate() {
        let gap = if at > 0 || asks_modes { "\n" } else { "" };
        output::print(&format!(
            "{gap}── {kind}\n{}",
            report::table::plan(each(rows))
        ))?;
    }
    if let Some((hz, advice)) = &advice {
        output::print(&report::system_tables::advice(
            &prepared.machine,
            advice,
            *hz,
        ))?;
    }
    Ok(0)
}

/// The plan of one study of motion.
type Rows = Vec<(&'static str, Verdict)>;

fn each(rows: &Rows) -> impl Iterator<Item = (&str, &Verdict)> + Clone {
    rows.iter().map(|(name, verdict)| (*name, verdict))
}

/// Relative change of a frequency that does not matter, where nothing is said.
const DOES_NOT_MATTER: f64 = 1e-3;

/// The plans of every study of motion that a scene lists; where it lists none and the flags ask for one, of that.
fn motions(
    scene: &Scene,
    prepared: &Prepared,
    asked: &IntegrationArgs,
) -> Result<Vec<(&'static str, Rows)>, Error> {
    let mut all = Vec::new();
    let in_time = |kind: &'static str, listed: &SimulateStudy| {
        let motion = motion_flags::integrated(asked, listed.clone())?;
        // `accuracy` and `stability` compare runs of their own.
        let motion = SimulateStudy {
            no_sensitivity: motion.no_sensitivity || kind != "simulate",
            ..motion
        };
        let ready = MotionScene::new(prepared, &scene.start, &motion)?;
        let choice = choice::choose(&ready.moving.train, &motion)?;
        Ok::<_, Error>((kind, stages::plan(&ready, &choice, &motion)))
    };
    let moves = |kind: &StudyKind| {
        matches!(
            kind,
            StudyKind::Simulate(_) | StudyKind::Accuracy(_) | StudyKind::Stability(_)
        )
    };
    if motion_flags::says_how(asked) && !scene.studies.iter().any(|s| moves(&s.kind)) {
        all.push(in_time("simulate", &SimulateStudy::default())?);
    }
    for study in &scene.studies {
        let (kind, motion) = match &study.kind {
            StudyKind::Modes(_) => continue,
            StudyKind::Response(response) => {
                all.push((
                    "response",
                    crate::plan::response::choice::plan(prepared, response),
                ));
                continue;
            }
            StudyKind::HarmonicBalance(balance) => {
                all.push((
                    "harmonic_balance",
                    harmonic_balance::plan(prepared, balance)?,
                ));
                continue;
            }
            StudyKind::RunUp(study) => {
                all.push(("run_up", run_up::plan(prepared, study)?));
                continue;
            }
            StudyKind::Transmission(te) => {
                all.push((
                    "te",
                    crate::plan::transmission::run::plan(&prepared.machine, te),
                ));
                continue;
            }
            StudyKind::Simulate(motion) => ("simulate", motion),
            StudyKind::Accuracy(accuracy) => ("accuracy", &accuracy.motion),
            StudyKind::Stability(stability) => ("stability", &stability.motion),
        };
        all.push(in_time(kind, motion)?);
    }
    Ok(all)
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

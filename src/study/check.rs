//! Check of a scene's studies for refusals, without solving anything.

use super::stability::linear;
use super::{frequencies, parametric, responses, work_precision};
use crate::base::error::Error;
use crate::motion::known;
use crate::plan::motion::simulation_setup::SimulationSetup;
use crate::plan::motion::{cost, method_choice};
use crate::plan::online::OnlineAnalysis;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::{harmonic_balance, run_up};
use crate::plan::stages::ModesPlan;
use crate::plan::{modes_run, response, transmission};
use crate::scene::Scene;
use crate::scene::study::{AccuracyTarget, ModesStudy, SimulateStudy, StudyKind};

/// The refusals of all studies, each at its place.
pub fn refusals(scene: &Scene, machine: &PreparedMachine) -> Vec<Error> {
    let of = |study: &crate::scene::study::Study| {
        let error = of_study(scene, machine, &study.kind).err()?;
        Some(match error.span {
            Some(_) => error,
            None => error.with_span(&study.span),
        })
    };
    let loads = loads(scene);
    match loads.is_empty() {
        true => scene.studies.iter().filter_map(of).collect(),
        false => loads,
    }
}

/// Loads over time that no motion can take.
fn loads(scene: &Scene) -> Vec<Error> {
    let loads = scene.model.loads.iter();
    let wrong = loads.filter_map(|load| {
        let error = known::signal(&load.history).err()?;
        Some(error.with_span(&load.at.span))
    });
    wrong.collect()
}

fn of_study(scene: &Scene, machine: &PreparedMachine, study: &StudyKind) -> Result<(), Error> {
    match study {
        StudyKind::Modes(study) => modes(machine, study),
        StudyKind::Simulate(study) => motion(scene, machine, study),
        StudyKind::Accuracy(study) => match study.target {
            AccuracyTarget::Modes => frequencies::check_study(machine),
            AccuracyTarget::Response => responses::check_study(machine, &study.response),
            AccuracyTarget::Motion => {
                let ready = SimulationSetup::with_single_spring_meshes(
                    machine,
                    &scene.start,
                    &study.motion,
                )?;
                work_precision::check_study(&ready, &study.methods)
            }
        },
        StudyKind::Stability(study) => {
            method_choice::find_methods(&study.methods)?;
            linear::check_study(machine)?;
            if study.motion.end_time.is_none() && study.speeds.is_none() {
                return Ok(());
            }
            let motion = SimulateStudy {
                end_time: study.motion.end_time.or(Some(1.0)),
                ..study.motion.clone()
            };
            let ready = SimulationSetup::with_single_spring_meshes(machine, &scene.start, &motion)?;
            parametric::check_study(machine, &ready, study)
        }
        StudyKind::Response(study) => response::run::check_study(machine, study),
        StudyKind::HarmonicBalance(study) => harmonic_balance::plan(machine, study).map(|_| ()),
        StudyKind::RunUp(study) => run_up::plan(machine, study).map(|_| ()),
        StudyKind::Transmission(study) => transmission::run::check_study(machine, study),
    }
}

fn modes(machine: &PreparedMachine, study: &ModesStudy) -> Result<(), Error> {
    machine.speeds_at(study.speed)?;
    modes_run::check_study(machine, study, &ModesPlan::plan_modes(machine, study))
}

/// A motion: its equations, outputs and start, its method, what it would cost.
fn motion(scene: &Scene, machine: &PreparedMachine, study: &SimulateStudy) -> Result<(), Error> {
    let ready = SimulationSetup::new(machine, &scene.start, study)?;
    let choice = method_choice::choose_method(&ready.model.model, study)?;
    OnlineAnalysis::new(machine, &ready, &study.running)?;
    cost::check_budget(&ready, &choice, study)
}

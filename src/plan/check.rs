//! What the studies of a scene would refuse, found without solving anything.

use super::motion::scene::MotionScene;
use super::motion::{choice, cost};
use super::on_the_fly::OnTheFly;
use super::prepared::Prepared;
use super::response::{harmonic_balance, run_up};
use super::stages::Plan;
use super::{response, run, transmission};
use crate::base::error::Error;
use crate::machine::spin::spinning;
use crate::scene::Scene;
use crate::scene::study::{ModesStudy, SimulateStudy, StudyKind, Subject};

/// The refusals of all studies, each at its place.
pub fn refusals(scene: &Scene, prepared: &Prepared) -> Vec<Error> {
    let of = |study: &crate::scene::study::Study| {
        let error = of_study(scene, prepared, &study.kind).err()?;
        Some(match error.place {
            Some(_) => error,
            None => error.at(&study.place),
        })
    };
    scene.studies.iter().filter_map(of).collect()
}

fn of_study(scene: &Scene, prepared: &Prepared, study: &StudyKind) -> Result<(), Error> {
    match study {
        StudyKind::Modes(study) => modes(prepared, study),
        StudyKind::Simulate(study) => motion(scene, prepared, study),
        StudyKind::Accuracy(study) => match study.of {
            Subject::Modes => Ok(()),
            Subject::Response => response::run::refuse(prepared, &study.response),
            Subject::Motion => {
                choice::each_named(&study.methods)?;
                MotionScene::new(prepared, &scene.start, &study.motion).map(|_| ())
            }
        },
        StudyKind::Stability(study) => {
            choice::each_named(&study.methods)?;
            let moves = study.motion.until.is_some();
            match moves {
                true => MotionScene::new(prepared, &scene.start, &study.motion).map(|_| ()),
                false => Ok(()),
            }
        }
        StudyKind::Response(study) => response::run::refuse(prepared, study),
        StudyKind::HarmonicBalance(study) => harmonic_balance::plan(prepared, study).map(|_| ()),
        StudyKind::RunUp(study) => run_up::plan(prepared, study).map(|_| ()),
        StudyKind::Transmission(study) => transmission::run::refuse(prepared, study),
    }
}

fn modes(prepared: &Prepared, study: &ModesStudy) -> Result<(), Error> {
    let Prepared {
        machine,
        kinematics,
        ..
    } = prepared;
    if study.speed.is_some() {
        spinning(machine, kinematics, study.speed)?;
    }
    run::refuse_hopeless(prepared, study, &Plan::modes(prepared, study))
}

/// A motion: its equations, outputs and start, its method, what it would cost.
fn motion(scene: &Scene, prepared: &Prepared, study: &SimulateStudy) -> Result<(), Error> {
    let ready = MotionScene::new(prepared, &scene.start, study)?;
    let choice = choice::choose(&ready.moving.train, study)?;
    OnTheFly::new(prepared, &ready, &study.running)?;
    cost::refuse(&ready, &choice, study)
}

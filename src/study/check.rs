//! What the studies of a scene would refuse, found without solving anything.

use super::stability::facts;
use super::{accuracy, frequencies, parametric, responses};
use crate::base::error::Error;
use crate::plan::motion::scene::MotionScene;
use crate::plan::motion::{choice, cost};
use crate::plan::on_the_fly::OnTheFly;
use crate::plan::prepared::Prepared;
use crate::plan::response::{harmonic_balance, run_up};
use crate::plan::stages::Plan;
use crate::plan::{response, run, transmission};
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
            Subject::Modes => frequencies::refuse(prepared),
            Subject::Response => responses::refuse(prepared, &study.response),
            Subject::Motion => {
                let ready = MotionScene::new(prepared, &scene.start, &study.motion)?;
                accuracy::refuse(&ready, &study.methods)
            }
        },
        StudyKind::Stability(study) => {
            choice::each_named(&study.methods)?;
            facts::refuse(prepared)?;
            if study.motion.until.is_none() && study.speeds.is_none() {
                return Ok(());
            }
            let motion = SimulateStudy {
                until: study.motion.until.or(Some(1.0)),
                ..study.motion.clone()
            };
            let ready = MotionScene::new(prepared, &scene.start, &motion)?;
            parametric::refuse(prepared, &ready, study)
        }
        StudyKind::Response(study) => response::run::refuse(prepared, study),
        StudyKind::HarmonicBalance(study) => harmonic_balance::plan(prepared, study).map(|_| ()),
        StudyKind::RunUp(study) => run_up::plan(prepared, study).map(|_| ()),
        StudyKind::Transmission(study) => transmission::run::refuse(prepared, study),
    }
}

fn modes(prepared: &Prepared, study: &ModesStudy) -> Result<(), Error> {
    prepared.speeds_at(study.speed)?;
    run::refuse_hopeless(prepared, study, &Plan::modes(prepared, study))
}

/// A motion: its equations, outputs and start, its method, what it would cost.
fn motion(scene: &Scene, prepared: &Prepared, study: &SimulateStudy) -> Result<(), Error> {
    let ready = MotionScene::new(prepared, &scene.start, study)?;
    let choice = choice::choose(&ready.moving.train, study)?;
    OnTheFly::new(prepared, &ready, &study.running)?;
    cost::refuse(&ready, &choice, study)
}

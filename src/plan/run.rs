//! Runs a plan: each stage once, in the order of the table, and keeps the trace.

use std::time::Instant;

use super::prepared::Prepared;
use super::stages::{COMPLEX, Plan, Stage, USUAL, Verdict, solver};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::machine::kinematics::mean_speeds;
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::energy::{Energies, energies};
use crate::modes::lowest::{self, Wanted};
use crate::modes::mode::Mode;
use crate::modes::sensitivity::{Sensitivity, sensitivities};
use crate::modes::{damped, modal, undamped};
use crate::scene::study::ModesStudy;

/// The answer to a study of modes.
pub struct Answer {
    /// The modes, by rising |λ|.
    pub modes: Vec<Mode>,
    /// Their energies.
    pub energies: Vec<Energies>,
    /// Their sensitivities, where they are real.
    pub sensitivities: Option<Vec<Vec<Sensitivity>>>,
    /// Mean speeds, rad/s by freedom, where a speed was asked for.
    pub speeds: Option<Vec<f64>>,
    /// The modes are complex: shapes have phases.
    pub complex: bool,
    /// Stages that ran, with seconds.
    pub trace: Vec<(Stage, &'static str, f64)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Fewer digits of the lowest elastic mode than this ask for the factored form.
const ENOUGH_DIGITS: f64 = 9.0;

/// Runs a plan of modes.
///
/// # Errors
/// Those of the stages.
pub fn run(prepared: &Prepared, study: &ModesStudy, plan: &Plan) -> Result<Answer, Error> {
    let mut run = Run {
        prepared,
        study,
        basis: None,
        answer: Answer::empty(prepared.warnings()),
    };
    for (stage, name, verdict) in &plan.steps {
        if let Verdict::Runs(_) = verdict {
            let start = Instant::now();
            run.stage(*stage)?;
            run.answer
                .trace
                .push((*stage, name, start.elapsed().as_secs_f64()));
        }
    }
    Ok(run.answer)
}

impl Answer {
    fn empty(warnings: Vec<Warning>) -> Answer {
        Answer {
            modes: Vec::new(),
            energies: Vec::new(),
            sensitivities: None,
            speeds: None,
            complex: false,
            trace: Vec::new(),
            warnings,
        }
    }
}

struct Run<'a> {
    prepared: &'a Prepared,
    study: &'a ModesStudy,
    basis: Option<Basis>,
    answer: Answer,
}

impl Run<'_> {
    fn stage(&mut self, stage: Stage) -> Result<(), Error> {
        match stage {
            // Done when the machine was prepared, or part of the solution.
            Stage::Joints | Stage::OperatingPoint | Stage::Massless => Ok(()),
            Stage::Basis => self.basis(),
            Stage::Lowest => self.lowest(),
            Stage::Speeds => self.speeds(),
            Stage::Complex => self.complex(),
            Stage::Energies => {
                let Prepared {
                    machine, linear, ..
                } = self.prepared;
                self.answer.energies = self
                    .answer
                    .modes
                    .iter()
                    .map(|mode| energies(machine, linear, mode))
                    .collect();
                Ok(())
            }
            Stage::Sensitivities => {
                let Prepared {
                    machine, linear, ..
                } = self.prepared;
                self.answer.sensitivities =
                    Some(sensitivities(machine, linear, &self.answer.modes)?);
                Ok(())
            }
            Stage::Campbell => Ok(()),
        }
    }

    fn basis(&mut self) -> Result<(), Error> {
        let linear = &self.prepared.linear;
        let first = solver(linear.n - linear.massless.len());
        let mut basis = basis::solve(linear, first)?;
        let lowest_digits = basis
            .digits
            .get(basis.n_rigid)
            .copied()
            .unwrap_or(f64::INFINITY);
        if first == Solver::Pencil && lowest_digits < ENOUGH_DIGITS {
            basis = basis::solve(linear, Solver::Factored)?;
        }
        self.answer.modes = self.selected(undamped::modes(linear, &basis));
        self.basis = Some(basis);
        Ok(())
    }

    /// The modes the study asks for, of all.
    fn selected(&self, mut modes: Vec<Mode>) -> Vec<Mode> {
        let count = self.study.lowest.map(|n| n as usize);
        if let Some(near) = self.study.near {
            modes.retain(|mode| !mode.rigid);
            modes.sort_by(|a, b| {
                (a.omega() - near)
                    .abs()
                    .total_cmp(&(b.omega() - near).abs())
            });
            modes.truncate(count.unwrap_or(USUAL));
            modes.sort_by(|a, b| a.omega().total_cmp(&b.omega()));
        } else if let Some(count) = count {
            modes.truncate(count);
        }
        modes
    }

    fn lowest(&mut self) -> Result<(), Error> {
        let wanted = Wanted {
            count: self.study.lowest.map_or(USUAL, |n| n as usize),
            near: self.study.near,
        };
        let found = lowest::find(&self.prepared.linear, self.prepared.forest.as_ref(), wanted)?;
        if !found.counted {
            let message = "no Sturm count confirms that no mode among these is missing".to_string();
            self.answer.warnings.push(Warning {
                code: "not-counted",
                message,
                hint: None,
            });
        }
        self.answer.modes = found.modes;
        Ok(())
    }

    fn speeds(&mut self) -> Result<(), Error> {
        let Prepared {
            machine,
            kinematics,
            ..
        } = self.prepared;
        self.answer.speeds = Some(mean_speeds(machine, kinematics, self.study.speed)?);
        Ok(())
    }

    fn complex(&mut self) -> Result<(), Error> {
        let Prepared {
            machine, linear, ..
        } = self.prepared;
        if linear.n > COMPLEX || self.basis.is_none() {
            let message = format!(
                "complex modes of {} freedoms would need a dense decomposition of twice that order",
                linear.n
            );
            let hint = "leave out --damped (the undamped modes show an estimate of each damping ratio), or reduce the machine";
            return Err(Error::new(Code::Hopeless, message).hint(hint));
        }
        if let Some(basis) = &self.basis {
            let speeds = self.answer.speeds.as_deref();
            let modal = modal::project(machine, linear, basis, speeds, self.study.damped);
            self.answer.modes = self.selected(damped::modes(linear, basis, &modal)?);
            self.answer.complex = true;
        }
        Ok(())
    }
}

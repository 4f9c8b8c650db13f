//! Runs a plan: each stage once, in the order of the table, and keeps the trace.

use std::time::Instant;

use super::prepared::Prepared;
use super::stages::{COMPLEX, Plan, Stage, USUAL, Verdict, solver};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::machine::kinematics::mean_speeds;
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::campbell::{self, Campbell, CampbellOptions};
use crate::modes::energy::{Energies, energies};
use crate::modes::lowest::{self, Wanted};
use crate::modes::mode::Mode;
use crate::modes::orders::OrderOptions;
use crate::modes::sensitivity::{Sensitivity, sensitivities};
use crate::modes::tracking::TrackingOptions;
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
    /// Modes over speed, where asked for.
    pub campbell: Option<Campbell>,
    /// The modes are complex: shapes have phases.
    pub complex: bool,
    /// Stages that ran, with seconds.
    pub trace: Vec<(Stage, &'static str, f64)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// The next solver where one leaves too few digits: dearer and more exact.
fn more_exact(solver: Solver) -> Option<Solver> {
    match solver {
        Solver::Pencil => Some(Solver::Singular),
        Solver::Singular => Some(Solver::Factored),
        Solver::Factored => None,
    }
}

fn lowest_digits(basis: &Basis) -> f64 {
    basis
        .digits
        .get(basis.n_rigid)
        .copied()
        .unwrap_or(f64::INFINITY)
}

/// Fewer digits of the lowest elastic mode than this ask for a more exact solver.
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
            campbell: None,
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
            Stage::Campbell => self.campbell(),
        }
    }

    fn basis(&mut self) -> Result<(), Error> {
        let linear = &self.prepared.linear;
        let mut basis = basis::solve(linear, solver(linear.n - linear.massless.len()))?;
        while let (Some(next), true) = (
            more_exact(basis.solver),
            lowest_digits(&basis) < ENOUGH_DIGITS,
        ) {
            basis = basis::solve(linear, next)?;
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

    fn campbell(&mut self) -> Result<(), Error> {
        let Prepared {
            machine,
            kinematics,
            linear,
            ..
        } = self.prepared;
        let (Some(range), Some(basis)) = (self.study.campbell, &self.basis) else {
            let message = format!(
                "a Campbell diagram of {} freedoms needs all their modes at every speed",
                linear.n
            );
            return Err(Error::new(Code::Hopeless, message).hint("reduce the machine first"));
        };
        let step = (range.to - range.from) / f64::from(range.count - 1);
        let options = CampbellOptions {
            speeds: (0..range.count)
                .map(|k| range.from + step * f64::from(k))
                .collect(),
            damped: self.study.damped,
            orders: OrderOptions::default(),
            tracking: TrackingOptions::default(),
        };
        let found = campbell::diagram(machine, kinematics, linear, basis, &options)?;
        let doubtful = found
            .branches
            .iter()
            .filter(|b| !b.uncertain_rpm.is_empty())
            .count();
        if doubtful > 0 {
            let message =
                format!("{doubtful} branches could not be followed without doubt at every speed");
            let hint = Some("see uncertain_rpm in --json; take more points there".to_string());
            self.answer.warnings.push(Warning {
                code: "branch-in-doubt",
                message,
                hint,
            });
        }
        self.answer.campbell = Some(found);
        Ok(())
    }
}

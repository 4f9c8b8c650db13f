//! Runs a plan: each stage once, in the order of the table, and keeps the trace.

use std::time::Instant;

use super::linear_stability;
use super::prepared::Prepared;
use super::stages::{COMPLEX, Plan, Stage, USUAL, Verdict, solver};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::units::duration;
use crate::machine::spin::spinning;
use crate::modes::basis::{self, Basis, Solver};
use crate::modes::campbell::{self, Campbell, CampbellOptions};
use crate::modes::energy::{Energies, energies};
use crate::modes::equations::Case;
use crate::modes::lowest::{self, Wanted};
use crate::modes::mode::Mode;
use crate::modes::orders::OrderOptions;
use crate::modes::reduction::{self, Band, BandError, Keep, Method, Reduced};
use crate::modes::sensitivity::{Sensitivity, sensitivities};
use crate::modes::state_space::StateSpace;
use crate::modes::state_space::participation::{Participation, participation};
use crate::modes::tracking::TrackingOptions;
use crate::modes::{damped, modal, undamped};
use crate::scene::study::{ModesStudy, ReduceMethod};

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
    /// The state-space form, where asked for, and how far each mode takes part in it.
    pub state_space: Option<(StateSpace, Vec<Participation>)>,
    /// The reduced machine, where asked for.
    pub reduction: Option<Reduction>,
    /// The modes are complex: shapes have phases.
    pub complex: bool,
    /// Stages that ran, with seconds.
    pub trace: Vec<(Stage, &'static str, f64)>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// A reduced machine beside the full one.
pub struct Reduction {
    /// The machine.
    pub reduced: Reduced,
    /// Its undamped frequencies, rad/s.
    pub omega: Vec<f64>,
    /// Those of the full machine, as many.
    pub full: Vec<f64>,
    /// Error of the response between the kept freedoms.
    pub error: BandError,
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
    refuse_hopeless(prepared, study, plan)?;
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
    run.warn();
    Ok(run.answer)
}

/// The largest machine whose modes are all found densely: beyond, K alone would take a gigabyte.
const MOST: usize = 10_000;

/// Says at once what would take hours or more memory than there is.
///
/// # Errors
/// `Hopeless`, with what to do instead.
pub fn refuse_hopeless(prepared: &Prepared, study: &ModesStudy, plan: &Plan) -> Result<(), Error> {
    let n = prepared.linear.n;
    let runs =
        |step: &(Stage, &str, Verdict)| matches!(step, (Stage::Complex, _, Verdict::Runs(_)));
    if n > COMPLEX && plan.steps.iter().any(runs) {
        return Err(complex_of_many(n));
    }
    let systems = study.state_space.is_some() || study.reduce.is_some() || study.campbell.is_some();
    let all = systems || !prepared.linear.is_sum_of_squares();
    if (systems && n > COMPLEX) || (all && n > MOST) {
        let message = format!("this needs all modes of {n} freedoms in dense matrices");
        let hint = format!(
            "up to {COMPLEX} freedoms this is a matter of minutes; model the machine with fewer"
        );
        return Err(Error::new(Code::Hopeless, message).hint(hint));
    }
    Ok(())
}

fn complex_of_many(n: usize) -> Error {
    // 3.1 s of a chain of 500 discs, 24 s of 1000.
    let seconds = 2.5e-8 * (n as f64).powi(3);
    let message = format!(
        "complex modes of {n} freedoms would need a dense decomposition of twice that order, about {}, and {COMPLEX} freedoms are allowed",
        duration(seconds)
    );
    let hint = "ask for undamped modes (they show an estimate of each damping ratio): leave out --damped; or model the machine with fewer freedoms";
    Error::new(Code::Hopeless, message).hint(hint)
}

impl Answer {
    fn empty(warnings: Vec<Warning>) -> Answer {
        Answer {
            modes: Vec::new(),
            energies: Vec::new(),
            sensitivities: None,
            speeds: None,
            campbell: None,
            state_space: None,
            reduction: None,
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
    /// What the modes say of stability, and what was left out.
    fn warn(&mut self) {
        let roots = self.answer.modes.iter().filter(|mode| !mode.rigid);
        let unstable = linear_stability::unstable(roots.map(|mode| mode.eigenvalue));
        self.answer.warnings.extend(unstable);
        let left_out = linear_stability::left_out(self.prepared, self.study, self.basis.as_ref());
        self.answer.warnings.extend(left_out);
    }

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
            Stage::StateSpace => self.state_space(),
            Stage::Reduction => self.reduction(),
        }
    }

    fn basis(&mut self) -> Result<(), Error> {
        let linear = &self.prepared.linear;
        let first = solver(linear.n - linear.massless.len());
        let mut basis = basis::solve(linear, first)?;
        if first == Solver::Singular && lowest_digits(&basis) < ENOUGH_DIGITS {
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
        self.answer.speeds = Some(spinning(machine, kinematics, self.study.speed)?);
        Ok(())
    }

    fn complex(&mut self) -> Result<(), Error> {
        let Prepared {
            machine, linear, ..
        } = self.prepared;
        if linear.n > COMPLEX || self.basis.is_none() {
            return Err(complex_of_many(linear.n));
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
        let options = CampbellOptions {
            speeds: range.all(),
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

    fn case(&self) -> Result<Case<'_>, Error> {
        let Prepared {
            machine, linear, ..
        } = self.prepared;
        let Some(basis) = &self.basis else {
            let message = format!("this needs all modes of {} freedoms", linear.n);
            return Err(Error::new(Code::Hopeless, message));
        };
        Ok(Case {
            machine,
            linear,
            basis,
            speeds: self.answer.speeds.as_deref(),
        })
    }

    fn state_space(&mut self) -> Result<(), Error> {
        let Some(wanted) = &self.study.state_space else {
            return Ok(());
        };
        let case = self.case()?;
        if case.linear.n > COMPLEX {
            let message = format!(
                "the state-space form of {} freedoms is a dense matrix of twice that order",
                case.linear.n
            );
            return Err(Error::new(Code::Hopeless, message).hint("reduce the machine first"));
        }
        let space = StateSpace::physical(&case, &wanted.inputs, &wanted.outputs)?;
        let parts = participation(&case, &space.inputs, &space.outputs)?;
        let space = match wanted.sample_time {
            Some(h) => space.sampled(h, wanted.hold)?,
            None => space,
        };
        self.answer.state_space = Some((space, parts));
        Ok(())
    }

    fn reduction(&mut self) -> Result<(), Error> {
        let Some(wanted) = &self.study.reduce else {
            return Ok(());
        };
        let case = self.case()?;
        let coordinate = |name: &String| reduction::coordinate(case.machine, case.linear, name);
        let kept = wanted
            .keep
            .iter()
            .map(coordinate)
            .collect::<Result<Vec<usize>, Error>>()?;
        // Modes up to twice the band: what is left out is then far from resonance in it.
        let keep = wanted
            .modes
            .map_or(Keep::Below(2.0 * wanted.below_hz), |n| {
                Keep::Count(n as usize)
            });
        let freedoms: Vec<usize> = kept.iter().map(|&j| case.linear.free[j]).collect();
        let reduced = Reduced::new(
            &case,
            match wanted.method {
                ReduceMethod::Guyan => Method::Guyan { masters: kept },
                ReduceMethod::Dynamic(at_hz) => Method::Dynamic {
                    masters: kept,
                    at_hz,
                },
                ReduceMethod::CraigBampton => Method::CraigBampton {
                    boundary: kept,
                    keep,
                },
                ReduceMethod::Modal => Method::Modal { keep, ports: kept },
            },
        )?;
        let error = reduced.compare(
            &case,
            &Band::new(wanted.below_hz, freedoms.clone(), freedoms),
        )?;
        let omega = reduction::frequencies(case.linear, &reduced.equations)?;
        let full = case.basis.omega.iter().copied().take(omega.len()).collect();
        self.answer.reduction = Some(Reduction {
            reduced,
            omega,
            full,
            error,
        });
        Ok(())
    }
}

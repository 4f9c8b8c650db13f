//! Modes study: runs its plan stage by stage and records the trace.

use std::time::Instant;

use super::linear_stability;
use super::prepared_machine::PreparedMachine;
use super::stages::{
    DEFAULT_MODE_COUNT, MAX_COMPLEX_ORDER, ModesPlan, Stage, StageDecision, undamped_solver,
};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_duration;
use crate::machine::spin::spinning;
use crate::modes::campbell::{self, CampbellDiagram, CampbellOptions};
use crate::modes::energy::{EnergyShares, energy_shares};
use crate::modes::excitation_orders::OrderOptions;
use crate::modes::modal_basis::{self, BasisSolution, ModalBasis};
use crate::modes::mode::Mode;
use crate::modes::mode_subset::{self, SubsetRequest};
use crate::modes::reduction::{
    self, BandError, ComparisonBand, ModeSelection, ReducedModel, ReductionMethod,
};
use crate::modes::sensitivity::{FrequencySensitivity, sensitivities};
use crate::modes::state_space::StateSpace;
use crate::modes::state_space::participation::{ModalParticipation, participation};
use crate::modes::state_space::signals::{parse_input, parse_output};
use crate::modes::system_matrices::AnalysisContext;
use crate::modes::tracking::TrackingOptions;
use crate::modes::{damped, modal_matrices, undamped};
use crate::numeric::sorting::sort_rising;
use crate::scene::study::{ModesStudy, ReductionKind};

/// Result of a modal study.
pub struct ModesResult {
    /// The modes, by rising |λ|.
    pub modes: Vec<Mode>,
    /// Their energies.
    pub energies: Vec<EnergyShares>,
    /// Their sensitivities, where they are real.
    pub sensitivities: Option<Vec<Vec<FrequencySensitivity>>>,
    /// Solver of all undamped modes, where they were found together.
    pub solution: Option<BasisSolution>,
    /// Mean speeds, rad/s by degree of freedom, where a speed was requested.
    pub speeds: Option<Vec<f64>>,
    /// Modes over speed, on request.
    pub campbell: Option<CampbellDiagram>,
    /// State-space form, on request, and the participation of each mode in it.
    pub state_space: Option<(StateSpace, Vec<ModalParticipation>)>,
    /// Reduced machine, on request.
    pub reduction: Option<ReductionResult>,
    /// The modes are complex: shapes have phases.
    pub complex: bool,
    /// Stages that ran, with seconds.
    pub trace: Vec<(Stage, &'static str, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// A reduced machine next to the full one.
pub struct ReductionResult {
    /// The machine.
    pub model: ReducedModel,
    /// Undamped natural frequencies, rad/s.
    pub omega: Vec<f64>,
    /// Those of the full machine, as many.
    pub full: Vec<f64>,
    /// Error of the response between the kept degrees of freedom.
    pub error: BandError,
}

/// Runs a plan of modes.
///
/// # Errors
/// Those of the stages.
pub fn run(
    machine: &PreparedMachine,
    study: &ModesStudy,
    plan: &ModesPlan,
) -> Result<ModesResult, Error> {
    check_budget(machine, study, plan)?;
    let mut run = ModesRun {
        machine,
        study,
        basis: None,
        result: ModesResult::empty_result(machine.warnings()),
    };
    for (stage, name, decision) in &plan.stages {
        if let StageDecision::Runs(_) = decision {
            let start = Instant::now();
            run.stage(*stage)?;
            run.result
                .trace
                .push((*stage, name, start.elapsed().as_secs_f64()));
        }
    }
    run.warn();
    Ok(run.result)
}

/// The largest machine whose modes are all found densely: beyond, K alone would take a gigabyte.
const MAX_DENSE_DOFS: usize = 10_000;

/// Says at once what would take hours or more memory than there is.
///
/// # Errors
/// `BudgetExceeded`, with what to do instead.
pub fn check_budget(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
    plan: &ModesPlan,
) -> Result<(), Error> {
    let n = prepared_machine.model.n;
    let runs = |step: &(Stage, &str, StageDecision)| {
        matches!(step, (Stage::Complex, _, StageDecision::Runs(_)))
    };
    if n > MAX_COMPLEX_ORDER && plan.stages.iter().any(runs) {
        return Err(complex_of_many(n));
    }
    let systems = study.state_space.is_some() || study.reduce.is_some() || study.campbell.is_some();
    let all = systems || !prepared_machine.model.is_sum_of_squares();
    if (systems && n > MAX_COMPLEX_ORDER) || (all && n > MAX_DENSE_DOFS) {
        let message = format!("this needs all modes of {n} degrees of freedom in dense matrices");
        let hint = format!(
            "up to {MAX_COMPLEX_ORDER} degrees of freedom this is a matter of minutes; model the machine with fewer"
        );
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
    }
    Ok(())
}

/// Refuses what no solution is needed to refuse: the size of the machine, and names of reductions and state-space forms.
///
/// # Errors
/// Those of [`check_budget`], of [`reduction::coordinate_by_name`], [`parse_input`] and [`parse_output`].
pub fn refuse(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
    plan: &ModesPlan,
) -> Result<(), Error> {
    check_budget(prepared_machine, study, plan)?;
    kept_coordinates(prepared_machine, study)?;
    let machine = &prepared_machine.machine;
    if let Some(wanted) = &study.state_space {
        for name in &wanted.inputs {
            parse_input(machine, name)?;
        }
        for name in &wanted.outputs {
            parse_output(machine, name)?;
        }
    }
    Ok(())
}

/// The coordinates that a reduction keeps.
fn kept_coordinates(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
) -> Result<Vec<usize>, Error> {
    let names = study.reduce.iter().flat_map(|wanted| &wanted.keep);
    let (machine, model) = (&prepared_machine.machine, &prepared_machine.model);
    names
        .map(|name| reduction::coordinate_by_name(machine, model, name))
        .collect()
}

fn complex_of_many(n: usize) -> Error {
    // 3.1 s of a chain of 500 discs, 24 s of 1000.
    let seconds = 2.5e-8 * (n as f64).powi(3);
    let message = format!(
        "complex modes of {n} degrees of freedom would need a dense decomposition of twice that order, about {}, and {MAX_COMPLEX_ORDER} degrees of freedom are allowed",
        format_duration(seconds)
    );
    let hint = "request undamped modes (they show an estimate of each damping ratio): omit --damped; or model the machine with fewer degrees of freedom";
    Error::new(Code::BudgetExceeded, message).with_hint(hint)
}

impl ModesResult {
    fn empty_result(diagnostics: Vec<Diagnostic>) -> ModesResult {
        ModesResult {
            modes: Vec::new(),
            energies: Vec::new(),
            sensitivities: None,
            solution: None,
            speeds: None,
            campbell: None,
            state_space: None,
            reduction: None,
            complex: false,
            trace: Vec::new(),
            diagnostics,
        }
    }
}

struct ModesRun<'a> {
    machine: &'a PreparedMachine,
    study: &'a ModesStudy,
    basis: Option<ModalBasis>,
    result: ModesResult,
}

impl ModesRun<'_> {
    /// Warns of unstable modes and of neglected terms.
    fn warn(&mut self) {
        let roots = self.result.modes.iter().filter(|mode| !mode.rigid);
        let unstable = linear_stability::unstable(roots.map(|mode| mode.eigenvalue));
        self.result.diagnostics.extend(unstable);
        let left_out = linear_stability::left_out(self.machine, self.study, self.basis.as_ref());
        self.result.diagnostics.extend(left_out);
    }

    fn stage(&mut self, stage: Stage) -> Result<(), Error> {
        match stage {
            // Done when the machine was prepared, or part of the solution.
            Stage::Meshes | Stage::Joints | Stage::OperatingPoint | Stage::Massless => Ok(()),
            Stage::Basis => self.basis(),
            Stage::Lowest => self.lowest(),
            Stage::Speeds => self.speeds(),
            Stage::Complex => self.complex(),
            Stage::Energies => {
                let PreparedMachine {
                    machine,
                    model: linear,
                    ..
                } = self.machine;
                self.result.energies = self
                    .result
                    .modes
                    .iter()
                    .map(|mode| energy_shares(machine, linear, mode))
                    .collect();
                Ok(())
            }
            Stage::Sensitivities => {
                let PreparedMachine {
                    machine,
                    model: linear,
                    ..
                } = self.machine;
                self.result.sensitivities =
                    Some(sensitivities(machine, linear, &self.result.modes)?);
                Ok(())
            }
            Stage::Campbell => self.campbell(),
            Stage::StateSpace => self.state_space(),
            Stage::Reduction => self.reduction(),
        }
    }

    fn basis(&mut self) -> Result<(), Error> {
        let linear = &self.machine.model;
        let basis = modal_basis::solve(linear, undamped_solver(self.study))?;
        self.result.modes = self.select_modes(undamped::modes(linear, &basis));
        self.result.solution = Some(basis.solution);
        self.basis = Some(basis);
        Ok(())
    }

    /// The modes the study asks for, of all.
    fn select_modes(&self, mut modes: Vec<Mode>) -> Vec<Mode> {
        let count = self.study.lowest.map(|n| n as usize);
        if let Some(near) = self.study.near {
            modes.retain(|mode| !mode.rigid);
            modes.sort_by(|a, b| {
                (a.omega() - near)
                    .abs()
                    .total_cmp(&(b.omega() - near).abs())
            });
            modes.truncate(count.unwrap_or(DEFAULT_MODE_COUNT));
            sort_rising(&mut modes, |a| a.omega());
        } else if let Some(count) = count {
            modes.truncate(count);
        }
        modes
    }

    fn lowest(&mut self) -> Result<(), Error> {
        let request = SubsetRequest {
            count: self.study.lowest.map_or(DEFAULT_MODE_COUNT, |n| n as usize),
            near: self.study.near,
        };
        let found = mode_subset::solve(&self.machine.model, self.machine.forest.as_ref(), request)?;
        if !found.sturm_verified {
            let message = "no Sturm count confirms that no mode among these is missing".to_string();
            self.result.diagnostics.push(Diagnostic {
                code: "not-counted",
                message,
                hint: None,
            });
        }
        self.result.modes = found.modes;
        Ok(())
    }

    fn speeds(&mut self) -> Result<(), Error> {
        let PreparedMachine {
            machine,
            kinematics,
            ..
        } = self.machine;
        self.result.speeds = Some(spinning(machine, kinematics, self.study.speed)?);
        Ok(())
    }

    fn complex(&mut self) -> Result<(), Error> {
        let PreparedMachine {
            machine,
            model: linear,
            ..
        } = self.machine;
        if linear.n > MAX_COMPLEX_ORDER || self.basis.is_none() {
            return Err(complex_of_many(linear.n));
        }
        if let Some(basis) = &self.basis {
            let speeds = self.result.speeds.as_deref();
            let modal = modal_matrices::project(machine, linear, basis, speeds, self.study.damped);
            self.result.modes = self.select_modes(damped::modes(linear, basis, &modal)?);
            self.result.complex = true;
        }
        Ok(())
    }

    fn campbell(&mut self) -> Result<(), Error> {
        let PreparedMachine {
            machine,
            kinematics,
            model: linear,
            ..
        } = self.machine;
        let (Some(range), Some(basis)) = (self.study.campbell, &self.basis) else {
            let message = format!(
                "a Campbell diagram of {} degrees of freedom needs all their modes at every speed",
                linear.n
            );
            return Err(
                Error::new(Code::BudgetExceeded, message).with_hint("reduce the machine first")
            );
        };
        let options = CampbellOptions {
            speeds: range.values(),
            damped: self.study.damped,
            orders: OrderOptions::default(),
            tracking: TrackingOptions::default(),
        };
        let found = campbell::campbell_diagram(machine, kinematics, linear, basis, &options)?;
        let doubtful = found
            .branches
            .iter()
            .filter(|b| !b.uncertain_rpm.is_empty())
            .count();
        if doubtful > 0 {
            let message =
                format!("{doubtful} branches could not be tracked with certainty at every speed");
            let hint = Some("see uncertain_rpm in --json; take more points there".to_string());
            self.result.diagnostics.push(Diagnostic {
                code: "branch-uncertain",
                message,
                hint,
            });
        }
        self.result.campbell = Some(found);
        Ok(())
    }

    fn case(&self) -> Result<AnalysisContext<'_>, Error> {
        let PreparedMachine {
            machine,
            model: linear,
            ..
        } = self.machine;
        let Some(basis) = &self.basis else {
            let message = format!("this needs all modes of {} degrees of freedom", linear.n);
            return Err(Error::new(Code::BudgetExceeded, message));
        };
        Ok(AnalysisContext {
            machine,
            model: linear,
            basis,
            speeds: self.result.speeds.as_deref(),
        })
    }

    fn state_space(&mut self) -> Result<(), Error> {
        let Some(wanted) = &self.study.state_space else {
            return Ok(());
        };
        let context = self.case()?;
        if context.model.n > MAX_COMPLEX_ORDER {
            let message = format!(
                "the state-space form of {} degrees of freedom is a dense matrix of twice that order",
                context.model.n
            );
            return Err(
                Error::new(Code::BudgetExceeded, message).with_hint("reduce the machine first")
            );
        }
        let space = StateSpace::physical(&context, &wanted.inputs, &wanted.outputs)?;
        let parts = participation(&context, &space.inputs, &space.outputs)?;
        let space = match wanted.sample_time {
            Some(h) => space.discretise(h, wanted.method)?,
            None => space,
        };
        self.result.state_space = Some((space, parts));
        Ok(())
    }

    fn reduction(&mut self) -> Result<(), Error> {
        let Some(wanted) = &self.study.reduce else {
            return Ok(());
        };
        let context = self.case()?;
        let kept = kept_coordinates(self.machine, self.study)?;
        // Modes up to twice the band: what is left out is then far from resonance in it.
        let selection = wanted
            .modes
            .map_or(ModeSelection::Below(2.0 * wanted.max_frequency_hz), |n| {
                ModeSelection::Count(n as usize)
            });
        let dofs: Vec<usize> = kept
            .iter()
            .map(|&j| context.model.independent_dofs[j])
            .collect();
        let model = ReducedModel::new(
            &context,
            match wanted.method {
                ReductionKind::Guyan => ReductionMethod::Guyan { masters: kept },
                ReductionKind::Dynamic(at_hz) => ReductionMethod::Dynamic {
                    masters: kept,
                    at_hz,
                },
                ReductionKind::CraigBampton => ReductionMethod::CraigBampton {
                    boundary: kept,
                    selection,
                },
                ReductionKind::Modal => ReductionMethod::Modal {
                    selection,
                    ports: kept,
                },
            },
        )?;
        let error = model.compare(
            &context,
            &ComparisonBand::new(wanted.max_frequency_hz, dofs.clone(), dofs),
        )?;
        let omega = reduction::natural_frequencies(context.model, &model.matrices)?;
        let full = context
            .basis
            .omega
            .iter()
            .copied()
            .take(omega.len())
            .collect();
        self.result.reduction = Some(ReductionResult {
            model,
            omega,
            full,
            error,
        });
        Ok(())
    }
}

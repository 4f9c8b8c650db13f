//! Run of a modal study: executes the stages of its plan and records their times.

use std::time::Instant;

use super::linear_stability;
use super::prepared_machine::PreparedMachine;
use super::stages::{
    DEFAULT_MODE_COUNT, MAX_COMPLEX_ORDER, ModesPlan, Stage, StageDecision, undamped_solver,
};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_duration;
use crate::machine::spin::spin_speeds;
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
use crate::numeric::sorting::sort_ascending;
use crate::scene::study::{ModesStudy, ReductionKind};

/// Result of a modal study.
pub struct ModesResult {
    /// Modes by ascending |λ|.
    pub modes: Vec<Mode>,
    /// Energy shares of each mode.
    pub energies: Vec<EnergyShares>,
    /// Frequency sensitivities of each mode, if the modes are real.
    pub sensitivities: Option<Vec<Vec<FrequencySensitivity>>>,
    /// Method and accuracy of the solution for all undamped modes; `None` if only a subset was computed.
    pub solution: Option<BasisSolution>,
    /// Mean speeds by degree of freedom, rad/s, if a speed was requested.
    pub speeds: Option<Vec<f64>>,
    /// Campbell diagram, on request.
    pub campbell: Option<CampbellDiagram>,
    /// State-space form and the participation of each mode in it, on request.
    pub state_space: Option<(StateSpace, Vec<ModalParticipation>)>,
    /// Reduced machine, on request.
    pub reduction: Option<ReductionResult>,
    /// True if the modes are complex: mode shapes have phases.
    pub complex: bool,
    /// Stages that ran, with their time, s.
    pub trace: Vec<(Stage, &'static str, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reduced machine and its comparison with the full one.
pub struct ReductionResult {
    /// Reduced model.
    pub model: ReducedModel,
    /// Undamped natural frequencies of the reduced model, rad/s.
    pub omega: Vec<f64>,
    /// As many undamped natural frequencies of the full machine, rad/s.
    pub full: Vec<f64>,
    /// Error of the responses between the retained degrees of freedom.
    pub error: BandError,
}

/// Runs the stages of a modal plan.
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

/// Maximum number of degrees of freedom of a dense solution for all modes; K alone then takes about a gigabyte.
const MAX_DENSE_DOFS: usize = 10_000;

/// Refuses a study that exceeds the budget of time or memory.
///
/// # Errors
/// `BudgetExceeded`, with the remedy.
pub fn check_budget(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
    plan: &ModesPlan,
) -> Result<(), Error> {
    let n = prepared_machine.model.n;
    let is_complex_run = |entry: &(Stage, &str, StageDecision)| {
        matches!(entry, (Stage::Complex, _, StageDecision::Runs(_)))
    };
    if n > MAX_COMPLEX_ORDER && plan.stages.iter().any(is_complex_run) {
        return Err(complex_budget_error(n));
    }
    let dense = study.state_space.is_some() || study.reduce.is_some() || study.campbell.is_some();
    let needs_all_modes = dense || !prepared_machine.model.is_sum_of_squares();
    if (dense && n > MAX_COMPLEX_ORDER) || (needs_all_modes && n > MAX_DENSE_DOFS) {
        let message = format!("this needs all modes of {n} degrees of freedom in dense matrices");
        let hint = format!(
            "model the machine with at most {MAX_COMPLEX_ORDER} degrees of freedom (some minutes)"
        );
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
    }
    Ok(())
}

/// Checks the study without a solution: the budget, the coordinates of a reduction, and the signals of a state-space form.
///
/// # Errors
/// Those of [`check_budget`], of [`reduction::coordinate_by_name`], [`parse_input`] and [`parse_output`].
pub fn check_study(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
    plan: &ModesPlan,
) -> Result<(), Error> {
    check_budget(prepared_machine, study, plan)?;
    retained_coordinates(prepared_machine, study)?;
    let machine = &prepared_machine.machine;
    if let Some(request) = &study.state_space {
        for name in &request.inputs {
            parse_input(machine, name)?;
        }
        for name in &request.outputs {
            parse_output(machine, name)?;
        }
    }
    Ok(())
}

/// Coordinates that a reduction retains.
fn retained_coordinates(
    prepared_machine: &PreparedMachine,
    study: &ModesStudy,
) -> Result<Vec<usize>, Error> {
    let names = study.reduce.iter().flat_map(|request| &request.keep);
    let (machine, model) = (&prepared_machine.machine, &prepared_machine.model);
    names
        .map(|name| reduction::coordinate_by_name(machine, model, name))
        .collect()
}

fn complex_budget_error(n: usize) -> Error {
    // Measured: 3.1 s for a chain of 500 discs, 24 s for 1000.
    let seconds = 2.5e-8 * (n as f64).powi(3);
    let message = format!(
        "complex modes of {n} degrees of freedom would need a dense decomposition of twice that order, about {} (limit {MAX_COMPLEX_ORDER} degrees of freedom)",
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
    /// Adds warnings of unstable modes and of neglected terms.
    fn warn(&mut self) {
        let roots = self.result.modes.iter().filter(|mode| !mode.rigid);
        let unstable = linear_stability::unstable(roots.map(|mode| mode.eigenvalue));
        self.result.diagnostics.extend(unstable);
        let left_out = linear_stability::left_out(self.machine, self.study, self.basis.as_ref());
        self.result.diagnostics.extend(left_out);
    }

    fn stage(&mut self, stage: Stage) -> Result<(), Error> {
        match stage {
            // Computed when the machine was prepared, or part of the solution.
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

    /// Selects the modes that the study requests.
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
            sort_ascending(&mut modes, |a| a.omega());
        } else if let Some(count) = count {
            modes.truncate(count);
        }
        modes
    }

    fn lowest(&mut self) -> Result<(), Error> {
        let request = SubsetRequest {
            count: self.study.lowest.map_or(DEFAULT_MODE_COUNT, |n| n as usize),
            near_omega: self.study.near,
        };
        let modes = mode_subset::solve(&self.machine.model, self.machine.forest.as_ref(), request)?;
        if !modes.sturm_verified {
            let message = "a mode may be missing: no Sturm count confirms their number".to_string();
            self.result.diagnostics.push(Diagnostic {
                code: "not-counted",
                message,
                hint: None,
            });
        }
        self.result.modes = modes.modes;
        Ok(())
    }

    fn speeds(&mut self) -> Result<(), Error> {
        let PreparedMachine {
            machine,
            kinematics,
            ..
        } = self.machine;
        self.result.speeds = Some(spin_speeds(machine, kinematics, self.study.speed)?);
        Ok(())
    }

    fn complex(&mut self) -> Result<(), Error> {
        let PreparedMachine {
            machine,
            model: linear,
            ..
        } = self.machine;
        if linear.n > MAX_COMPLEX_ORDER || self.basis.is_none() {
            return Err(complex_budget_error(linear.n));
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
        let diagram = campbell::campbell_diagram(machine, kinematics, linear, basis, &options)?;
        let uncertain = diagram
            .branches
            .iter()
            .filter(|b| !b.uncertain_rpm.is_empty())
            .count();
        if uncertain > 0 {
            let message =
                format!("{uncertain} branches could not be tracked with certainty at every speed");
            let hint = Some("see uncertain_rpm in --json; use more points there".to_string());
            self.result.diagnostics.push(Diagnostic {
                code: "branch-uncertain",
                message,
                hint,
            });
        }
        self.result.campbell = Some(diagram);
        Ok(())
    }

    fn context(&self) -> Result<AnalysisContext<'_>, Error> {
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
        let Some(request) = &self.study.state_space else {
            return Ok(());
        };
        let context = self.context()?;
        if context.model.n > MAX_COMPLEX_ORDER {
            let message = format!(
                "the state-space form of {} degrees of freedom is a dense matrix of twice that order",
                context.model.n
            );
            return Err(
                Error::new(Code::BudgetExceeded, message).with_hint("reduce the machine first")
            );
        }
        let space = StateSpace::physical(&context, &request.inputs, &request.outputs)?;
        let parts = participation(&context, &space.inputs, &space.outputs)?;
        let space = match request.sample_time {
            Some(h) => space.discretise(h, request.method)?,
            None => space,
        };
        self.result.state_space = Some((space, parts));
        Ok(())
    }

    fn reduction(&mut self) -> Result<(), Error> {
        let Some(request) = &self.study.reduce else {
            return Ok(());
        };
        let context = self.context()?;
        let retained = retained_coordinates(self.machine, self.study)?;
        // Modes up to twice the band limit: within the band the truncated modes are far from resonance.
        let selection = request
            .modes
            .map_or(ModeSelection::Below(2.0 * request.max_frequency_hz), |n| {
                ModeSelection::Count(n as usize)
            });
        let dofs: Vec<usize> = retained
            .iter()
            .map(|&j| context.model.independent_dofs[j])
            .collect();
        let model = ReducedModel::new(
            &context,
            match request.method {
                ReductionKind::Guyan => ReductionMethod::Guyan { masters: retained },
                ReductionKind::Dynamic(at_hz) => ReductionMethod::Dynamic {
                    masters: retained,
                    at_hz,
                },
                ReductionKind::CraigBampton => ReductionMethod::CraigBampton {
                    boundary: retained,
                    selection,
                },
                ReductionKind::Modal => ReductionMethod::Modal {
                    selection,
                    ports: retained,
                },
            },
        )?;
        let error = model.compare(
            &context,
            &ComparisonBand::new(request.max_frequency_hz, dofs.clone(), dofs),
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

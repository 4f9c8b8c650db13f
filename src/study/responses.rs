//! Work–precision study of frequency responses: direct, modal sum, reduced models.
//!
//! The error of a method is the largest difference from the direct solution over all lines, relative to the largest value of the
//! same output and input; the worst pair counts.

use super::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use super::monitor::{Monitor, interrupted_error};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::modes::modal_basis::{self, ModalBasis, UndampedSolver as BasisSolver};
use crate::modes::reduction::{ModeSelection, ReducedModel, ReductionMethod};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Complex, ComplexMatrix, Matrix, parallel, symmetric};
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::response::method_choice::DEFAULT_LINES;
use crate::response::frf::{ResponseMethod, ResponseSolver, difference};
use crate::response::ports::{Ports, ResponseInput, ResponseOutput};
use crate::scene::study::ResponseStudy;

/// Maximum number of degrees of freedom of a modal decomposition.
const MAX_DENSE_DOFS: usize = 1000;

/// Checks the study and the machine before any solution.
///
/// # Errors
/// A study without band, input or output; an undamped machine; errors of its speeds.
pub fn check_study(machine: &PreparedMachine, study: &ResponseStudy) -> Result<(), Error> {
    band_and_ports(machine, study)?;
    machine.speeds_at(study.speed).map(|_| ())
}

fn band_and_ports(
    prepared_machine: &PreparedMachine,
    study: &ResponseStudy,
) -> Result<((f64, f64), Ports), Error> {
    let PreparedMachine {
        machine,
        model: linear,
        ..
    } = prepared_machine;
    let Some((from, to)) = study.band else {
        return Err(Error::new(Code::Usage, "no frequencies are stated")
            .with_hint("add --band 1:500, or `band = \"1:500\"` to the study"));
    };
    let ports = Ports::parse(machine, &study.inputs, &study.outputs, &study.fixed_dofs)?;
    if ports.inputs.is_empty() || ports.outputs.is_empty() {
        return Err(
            Error::new(Code::Usage, "no input or no output is named").with_hint(
                "add --input NAME and --output NAME, or `inputs` and `outputs` to the study",
            ),
        );
    }
    if !linear.is_damped(machine) {
        let message = "the machine is undamped: responses at resonance are infinite, and their error is undefined";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("add damping, in [damping] or with each stiffness"));
    }
    Ok(((from, to), ports))
}

/// Compares the methods for the requested responses. If interrupted, it returns the completed methods.
///
/// # Errors
/// Errors of [`check_study`] and of the direct solution.
pub fn compare_responses(
    prepared_machine: &PreparedMachine,
    study: &ResponseStudy,
    monitor: &mut Monitor,
) -> Result<ComparisonResult, Error> {
    let PreparedMachine {
        machine,
        model: linear,
        ..
    } = prepared_machine;
    let ((from, to), ports) = band_and_ports(prepared_machine, study)?;
    let speeds = prepared_machine.speeds_at(study.speed)?;
    let model = prepared_machine.operating_model(speeds.as_deref());
    let lines = study.lines.unwrap_or(DEFAULT_LINES).max(2);
    let step = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines).map(|k| from + step * f64::from(k)).collect();
    let run = |method: ResponseMethod| -> Result<Vec<ComplexMatrix>, Error> {
        let solver = ResponseSolver::new(&model, &ports, method)?;
        omega.iter().map(|&w| solver.response_at(w)).collect()
    };
    if !monitor.proceed("line by line") {
        return Err(interrupted_error());
    }
    let solve_parallel = |method: ResponseMethod| -> Result<Vec<ComplexMatrix>, Error> {
        let solver = ResponseSolver::new(&model, &ports, method)?;
        parallel::try_map(&omega, |&w| solver.response_at(w))
    };
    let exact = solve_parallel(ResponseMethod::Direct)?;
    let is_small = linear.n <= MAX_DENSE_DOFS;
    let modal = match is_small {
        true => solve_parallel(ResponseMethod::Modal).ok(),
        false => None,
    };
    let reference_error = modal.map_or(f64::NAN, |modal| difference(&modal, &exact));
    let floor = match reference_error.is_finite() {
        true => reference_error,
        false => 0.0,
    };
    let judge = |response: Vec<ComplexMatrix>| Ok(difference(&response, &exact).max(floor));
    let mut methods = vec![
        ComparedMethod::time_method("line by line", None, || run(ResponseMethod::Direct), judge),
        ComparedMethod::time_method("all modes", None, || run(ResponseMethod::Modal), judge),
    ];
    match (torque_motion_ports(&ports), is_small) {
        (Some(reduced_ports), true) => {
            let basis = modal_basis::solve(linear, BasisSolver::Factored)?;
            let context = AnalysisContext {
                machine,
                model: linear,
                basis: &basis,
                speeds: speeds.as_deref(),
            };
            for (method, size, reduce) in reductions(&context, &reduced_ports) {
                if !monitor.proceed(method) {
                    break;
                }
                let task = || {
                    let matrices = reduce()?;
                    omega
                        .iter()
                        .map(|&w| reduced_ports.reduced_response(&context, &matrices, w))
                        .collect()
                };
                methods.push(ComparedMethod::time_method(method, Some(size), task, judge));
            }
        }
        (None, _) => methods.push(skipped_method(
            "reduced machines are compared between torques and motions of single degrees of freedom, nothing held",
        )),
        (_, false) => methods.push(skipped_method(&format!(
            "{} degrees of freedom are too many for all modes (limit {MAX_DENSE_DOFS})",
            linear.n
        ))),
    }
    Ok(ComparisonResult {
        quantity: format!(
            "{} over {} to {:.4} Hz",
            pluralise(ports.inputs.len() * ports.outputs.len(), "response"),
            pluralise(lines as usize, "line"),
            to / std::f64::consts::TAU
        ),
        norm: "largest difference over all lines, by the largest value of the same response",
        dofs: Some(linear.n),
        reference: match is_small {
            true => "the direct solution, compared with a sum over all modes",
            false => "the direct solution",
        }
        .to_string(),
        reference_error: floor,
        methods,
        interrupted: monitor.cancel.is_cancelled(),
    })
}

fn skipped_method(reason: &str) -> ComparedMethod {
    ComparedMethod {
        method: "reduced machines",
        size: None,
        error: None,
        seconds: 0.0,
        failure: Some(reason.to_string()),
    }
}

/// Ports of a reduced machine: torques on degrees of freedom, and motions of degrees of freedom.
struct TorqueMotionPorts {
    inputs: Vec<usize>,
    /// Degree of freedom and number of time derivatives.
    outputs: Vec<(usize, u8)>,
}

fn torque_motion_ports(ports: &Ports) -> Option<TorqueMotionPorts> {
    let inputs = ports.inputs.iter().map(|port| match port.kind {
        ResponseInput::Torque(dof) => Some(dof),
        _ => None,
    });
    let outputs = ports.outputs.iter().map(|port| match &port.kind {
        ResponseOutput::Sum(terms, derivatives) => match terms[..] {
            [(dof, 1.0)] => Some((dof, *derivatives)),
            _ => None,
        },
        _ => None,
    });
    Some(TorqueMotionPorts {
        inputs: inputs.collect::<Option<_>>()?,
        outputs: outputs.collect::<Option<_>>()?,
    })
    .filter(|_| ports.fixed.is_empty())
}

impl TorqueMotionPorts {
    /// Response matrix of the reduced equations at ω, rad/s: outputs by inputs.
    fn reduced_response(
        &self,
        context: &AnalysisContext,
        matrices: &SystemMatrices,
        omega: f64,
    ) -> Result<ComplexMatrix, Error> {
        let s = Complex::new(0.0, omega);
        let project = |dof: usize| matrices.project(&context.model.transform[dof]);
        let loads: Vec<Vec<f64>> = self.inputs.iter().map(|&f| project(f)).collect();
        let loads = ComplexMatrix::from_fn(matrices.len(), loads.len(), |i, j| {
            Complex::new(loads[j][i], 0.0)
        });
        let x = symmetric::lu_solve_complex(&matrices.dynamic_stiffness(s), &loads)?;
        let rows: Vec<(Vec<f64>, Complex)> = self
            .outputs
            .iter()
            .map(|&(f, derivatives)| (project(f), s.powu(u32::from(derivatives))))
            .collect();
        Ok(ComplexMatrix::from_fn(
            rows.len(),
            self.inputs.len(),
            |o, i| {
                let (row, factor) = &rows[o];
                let sum: Complex = row.iter().enumerate().map(|(k, a)| x[(k, i)] * a).sum();
                sum * factor
            },
        ))
    }

    /// Coordinates of the inputs and outputs; none if a degree of freedom depends on several.
    fn ports(&self, context: &AnalysisContext) -> Option<Vec<usize>> {
        let dofs = self.inputs.iter().copied();
        let port_dofs = dofs.chain(self.outputs.iter().map(|o| o.0));
        let mut ports = port_dofs
            .map(|f| match context.model.transform[f][..] {
                [(j, _)] => Some(j),
                _ => None,
            })
            .collect::<Option<Vec<usize>>>()?;
        ports.sort_unstable();
        ports.dedup();
        Some(ports)
    }
}

type ReductionFn<'a> = Box<dyn Fn() -> Result<SystemMatrices, Error> + 'a>;

/// Reductions over their sequences of sizes.
fn reductions<'a>(
    context: &'a AnalysisContext<'a>,
    reduced_ports: &TorqueMotionPorts,
) -> Vec<(&'static str, ModelSize, ReductionFn<'a>)> {
    let mut reductions: Vec<(&'static str, ModelSize, ReductionFn)> = Vec::new();
    let elastic = context.basis.omega.len() - context.basis.n_rigid;
    let ports = reduced_ports.ports(context);
    if let Some(masters) = ports.clone() {
        let size = ModelSize::Coordinates(masters.len());
        let reduce = move || {
            let masters = masters.clone();
            Ok(ReducedModel::new(context, ReductionMethod::Guyan { masters })?.matrices)
        };
        reductions.push(("static condensation", size, Box::new(reduce)));
    }
    let mut modes = 1;
    while modes < elastic {
        let truncated = move || Ok(truncated_modes(context, context.basis, modes));
        reductions.push(("modes alone", ModelSize::Modes(modes), Box::new(truncated)));
        if let Some(ports) = ports.clone() {
            let boundary = ports.clone();
            let with_residual = move || {
                let (selection, ports) = (ModeSelection::Count(modes), ports.clone());
                Ok(
                    ReducedModel::new(context, ReductionMethod::Modal { selection, ports })?
                        .matrices,
                )
            };
            let name = "modes and static residual";
            reductions.push((name, ModelSize::Modes(modes), Box::new(with_residual)));
            let fixed_interface = move || {
                let (selection, boundary) = (ModeSelection::Count(modes), boundary.clone());
                Ok(ReducedModel::new(
                    context,
                    ReductionMethod::CraigBampton {
                        boundary,
                        selection,
                    },
                )?
                .matrices)
            };
            reductions.push((
                "fixed-interface modes",
                ModelSize::Modes(modes),
                Box::new(fixed_interface),
            ));
        }
        modes *= 2;
    }
    reductions
}

/// Machine in the coordinates of its rigid-body modes and lowest elastic modes.
fn truncated_modes(context: &AnalysisContext, basis: &ModalBasis, modes: usize) -> SystemMatrices {
    let columns = (basis.n_rigid + modes).min(basis.shapes.ncols());
    let transform = Matrix::from_fn(basis.shapes.nrows(), columns, |i, j| basis.shapes[(i, j)]);
    SystemMatrices::in_basis(context, transform, Vec::new(), basis.n_rigid)
}

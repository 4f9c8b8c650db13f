//! Work–precision study of frequency responses: direct, modal sum, reduced models.
//!
//! The error of a way is the largest difference from the direct solution over all lines, by the largest value of the same
//! output and input; the worst pair counts.

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
use crate::response::frf::{ResponseMethod as How, ResponseSolver, difference};
use crate::response::ports::{Ports, ResponseInput, ResponseOutput};
use crate::scene::study::ResponseStudy;

/// Machines beyond this many degrees of freedom are not taken apart into modes.
const MAX_DENSE_DOFS: usize = 1000;

/// Refuses what can be known before any solution.
///
/// # Errors
/// A study without band, input or output; a machine without damping; those of its speed.
pub fn refuse(machine: &PreparedMachine, study: &ResponseStudy) -> Result<(), Error> {
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
            .with_hint("state `band`, such as 1:500"));
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
        let message = "nothing is damped: at a resonance every response is infinite, and no error can be measured";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give the machine its damping, in [damping] or with each stiffness"));
    }
    Ok(((from, to), ports))
}

/// Compares every way to the responses a study asks for. Ended early, it gives the ways that were finished.
///
/// # Errors
/// What is missing in the study; an undamped machine; those of the direct solution.
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
    let model = prepared_machine.frequency_setting(speeds.as_deref());
    let lines = study.lines.unwrap_or(DEFAULT_LINES).max(2);
    let step = (to - from) / f64::from(lines - 1);
    let omega: Vec<f64> = (0..lines).map(|k| from + step * f64::from(k)).collect();
    let by = |how: How| -> Result<Vec<ComplexMatrix>, Error> {
        let solver = ResponseSolver::new(&model, &ports, how)?;
        omega.iter().map(|&w| solver.response_at(w)).collect()
    };
    if !monitor.proceed("line by line") {
        return Err(interrupted_error());
    }
    let reference = |how: How| -> Result<Vec<ComplexMatrix>, Error> {
        let solver = ResponseSolver::new(&model, &ports, how)?;
        parallel::try_map(&omega, |&w| solver.response_at(w))
    };
    let exact = reference(How::Direct)?;
    let small = linear.n <= MAX_DENSE_DOFS;
    let other = match small {
        true => reference(How::Modal).ok(),
        false => None,
    };
    let reference_error = other.map_or(f64::NAN, |other| difference(&other, &exact));
    let floor = match reference_error.is_finite() {
        true => reference_error,
        false => 0.0,
    };
    let judge = |found: Vec<ComplexMatrix>| Ok(difference(&found, &exact).max(floor));
    let mut list = vec![
        ComparedMethod::time_method("line by line", None, || by(How::Direct), judge),
        ComparedMethod::time_method("all modes", None, || by(How::Modal), judge),
    ];
    match (torque_motion_ports(&ports), small) {
        (Some(plain), true) => {
            let basis = modal_basis::solve(linear, BasisSolver::Factored)?;
            let context = AnalysisContext {
                machine,
                model: linear,
                basis: &basis,
                speeds: speeds.as_deref(),
            };
            for (method, size, reduce) in reductions(&context, &plain) {
                if !monitor.proceed(method) {
                    break;
                }
                let task = || {
                    let matrices = reduce()?;
                    omega
                        .iter()
                        .map(|&w| plain.reduced_response(&context, &matrices, w))
                        .collect()
                };
                list.push(ComparedMethod::time_method(method, Some(size), task, judge));
            }
        }
        (None, _) => list.push(skipped(
            "reduced machines are compared between torques and motions of single degrees of freedom, nothing held",
        )),
        (_, false) => list.push(skipped(&format!(
            "{} degrees of freedom are not taken apart into modes (limit {MAX_DENSE_DOFS})",
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
        reference: match small {
            true => "the direct solution, compared with a sum over all modes",
            false => "the direct solution",
        }
        .to_string(),
        reference_error: floor,
        methods: list,
        interrupted: monitor.cancel.is_cancelled(),
    })
}

fn skipped(why: &str) -> ComparedMethod {
    ComparedMethod {
        method: "reduced machines",
        size: None,
        error: None,
        seconds: 0.0,
        failure: Some(why.to_string()),
    }
}

/// Torques on degrees of freedom and motions of degrees of freedom, all ports of a reduced machine.
struct TorqueMotionPorts {
    inputs: Vec<usize>,
    /// The degree of freedom, and how often it is differentiated.
    outputs: Vec<(usize, u8)>,
}

fn torque_motion_ports(ports: &Ports) -> Option<TorqueMotionPorts> {
    let inputs = ports.inputs.iter().map(|port| match port.kind {
        ResponseInput::Torque(dof) => Some(dof),
        _ => None,
    });
    let outputs = ports.outputs.iter().map(|port| match &port.kind {
        ResponseOutput::Sum(terms, times) => match terms[..] {
            [(dof, 1.0)] => Some((dof, *times)),
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
    /// Outputs by inputs through reduced equations.
    fn reduced_response(
        &self,
        context: &AnalysisContext,
        matrices: &SystemMatrices,
        omega: f64,
    ) -> Result<ComplexMatrix, Error> {
        let s = Complex::new(0.0, omega);
        let sees = |dof: usize| matrices.project(&context.model.transform[dof]);
        let loads: Vec<Vec<f64>> = self.inputs.iter().map(|&f| sees(f)).collect();
        let loads = ComplexMatrix::from_fn(matrices.len(), loads.len(), |i, j| {
            Complex::new(loads[j][i], 0.0)
        });
        let x = symmetric::lu_solve_complex(&matrices.dynamic_stiffness(s), &loads)?;
        let rows: Vec<(Vec<f64>, Complex)> = self
            .outputs
            .iter()
            .map(|&(f, times)| (sees(f), s.powu(u32::from(times))))
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

    /// Coordinates that are loaded or measured, where each degree of freedom follows one alone.
    fn ports(&self, context: &AnalysisContext) -> Option<Vec<usize>> {
        let dofs = self.inputs.iter().copied();
        let all = dofs.chain(self.outputs.iter().map(|o| o.0));
        let mut ports = all
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

/// Every reduction over its series of sizes.
fn reductions<'a>(
    context: &'a AnalysisContext<'a>,
    plain: &TorqueMotionPorts,
) -> Vec<(&'static str, ModelSize, ReductionFn<'a>)> {
    let mut all: Vec<(&'static str, ModelSize, ReductionFn)> = Vec::new();
    let elastic = context.basis.omega.len() - context.basis.n_rigid;
    let ports = plain.ports(context);
    if let Some(masters) = ports.clone() {
        let size = ModelSize::Coordinates(masters.len());
        let reduce = move || {
            let masters = masters.clone();
            Ok(ReducedModel::new(context, ReductionMethod::Guyan { masters })?.matrices)
        };
        all.push(("static condensation", size, Box::new(reduce)));
    }
    let mut kept = 1;
    while kept < elastic {
        let truncated = move || Ok(truncated_modes(context, context.basis, kept));
        all.push(("modes alone", ModelSize::Modes(kept), Box::new(truncated)));
        if let Some(ports) = ports.clone() {
            let boundary = ports.clone();
            let with_rest = move || {
                let (selection, ports) = (ModeSelection::Count(kept), ports.clone());
                Ok(
                    ReducedModel::new(context, ReductionMethod::Modal { selection, ports })?
                        .matrices,
                )
            };
            let name = "modes and static residual";
            all.push((name, ModelSize::Modes(kept), Box::new(with_rest)));
            let fixed = move || {
                let (selection, boundary) = (ModeSelection::Count(kept), boundary.clone());
                Ok(ReducedModel::new(
                    context,
                    ReductionMethod::CraigBampton {
                        boundary,
                        selection,
                    },
                )?
                .matrices)
            };
            all.push((
                "fixed-interface modes",
                ModelSize::Modes(kept),
                Box::new(fixed),
            ));
        }
        kept *= 2;
    }
    all
}

/// The machine over its rigid motions and its lowest elastic modes.
fn truncated_modes(context: &AnalysisContext, basis: &ModalBasis, kept: usize) -> SystemMatrices {
    let columns = (basis.n_rigid + kept).min(basis.shapes.ncols());
    let transform = Matrix::from_fn(basis.shapes.nrows(), columns, |i, j| basis.shapes[(i, j)]);
    SystemMatrices::in_basis(context, transform, Vec::new(), basis.n_rigid)
}

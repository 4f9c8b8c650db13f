//! Work–precision study of natural frequencies: eigensolvers, reduction, shaft elements.
//!
//! The error of a method is the largest relative error of the requested frequencies. Solvers and reductions are compared with
//! the machine as stated; shaft subdivisions with their limit of refinement, by Richardson extrapolation of second order.

use super::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use super::monitor::{Monitor, interrupted_error};
use super::timing::min_time;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::machine::linear::LinearModel;
use crate::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use crate::modes::mode_subset::{self, SubsetRequest};
use crate::modes::reduction::{ModeSelection, ReducedModel, ReductionMethod, natural_frequencies};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Matrix, symmetric};
use crate::plan::meshes::stage::MeshStage;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::{BarMass, Model, ShaftBody};

/// Default number of modes compared.
pub const DEFAULT_MODES: usize = 10;

/// Maximum number of degrees of freedom of a dense eigenvalue problem.
const MAX_DENSE_DOFS: usize = 1000;

/// Maximum number of degrees of freedom of a machine with subdivided shafts.
const MAX_DOFS: usize = 100_000;

/// Subdivisions of the refinement series; the last two give the reference.
const SUBDIVISIONS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Checks that the machine has frequencies to compare.
///
/// # Errors
/// A machine whose strain energy is not a sum of squares, or without elastic modes.
pub fn check_study(prepared_machine: &PreparedMachine) -> Result<(), Error> {
    if !prepared_machine.model.is_sum_of_squares() {
        let message = "negative or cross-coupled stiffness has no undamped frequencies to compare";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("remove it from the model, or compare the motion"));
    }
    if elastic_modes(&prepared_machine.model) == 0 {
        let message = "the machine has no elastic mode";
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give its shafts or meshes a stiffness"));
    }
    Ok(())
}

fn elastic_modes(model: &LinearModel) -> usize {
    model.n - model.massless.len() - model.rigid.len()
}

/// Compares the methods for the lowest elastic frequencies. If interrupted, it returns the completed methods.
///
/// # Errors
/// Errors of [`check_study`] and of the reference.
pub fn compare_eigensolvers(
    prepared_machine: &PreparedMachine,
    model: &Model,
    count: usize,
    monitor: &mut Monitor,
) -> Result<ComparisonResult, Error> {
    let linear_model = &prepared_machine.model;
    check_study(prepared_machine)?;
    let count = count.min(elastic_modes(linear_model));
    if !monitor.proceed("reference") {
        return Err(interrupted_error());
    }
    let is_dense = linear_model.n <= MAX_DENSE_DOFS;
    let basis = match is_dense {
        true => Some(modal_basis::solve(linear_model, UndampedSolver::Factored)?),
        false => None,
    };
    let (omega, digits) = match &basis {
        Some(basis) => elastic_frequencies(basis, count),
        None => lowest_frequencies(prepared_machine, count)?,
    };
    let reference = ReferenceFrequencies {
        omega,
        error: 10f64.powf(-digits),
    };
    let mut methods = Vec::new();
    let mut compare =
        |method: &'static str, size, task: &mut dyn FnMut() -> Result<Vec<f64>, Error>| {
            if !monitor.proceed(method) {
                return;
            }
            methods.push(ComparedMethod::time_method(method, size, task, |omega| {
                reference.relative_error(omega)
            }));
        };
    compare("lowest modes only", None, &mut || {
        lowest_frequencies(prepared_machine, count).map(|f| f.0)
    });
    let dense: [(&'static str, FrequencyFn); 3] = [
        ("all modes, graded", &|| {
            modal_basis::solve(linear_model, UndampedSolver::Factored)
                .map(|b| elastic_frequencies(&b, count).0)
        }),
        ("all modes, energies", &|| {
            modal_basis::solve(linear_model, UndampedSolver::Symmetric(1.0))
                .map(|b| elastic_frequencies(&b, count).0)
        }),
        ("all modes, assembled K", &|| {
            assembled_frequencies(prepared_machine, basis.as_ref(), count)
        }),
    ];
    for (name, solve) in dense {
        match is_dense {
            true => compare(name, None, &mut || solve()),
            false => compare(name, None, &mut || Err(too_large_error(linear_model.n))),
        }
    }
    if let Some(basis) = &basis {
        let context = AnalysisContext {
            machine: &prepared_machine.machine,
            model: linear_model,
            basis,
            speeds: None,
        };
        let order = master_dofs(linear_model);
        for size in size_sequence(count, order.len()) {
            compare(
                "static condensation",
                Some(ModelSize::Coordinates(size)),
                &mut || {
                    let masters = order[..size].to_vec();
                    reduced_frequencies(&context, ReductionMethod::Guyan { masters }, count)
                },
            );
            compare(
                "fixed-interface modes",
                Some(ModelSize::Coordinates(size)),
                &mut || {
                    let boundary = order[..BOUNDARY_DOFS.min(size)].to_vec();
                    let selection = ModeSelection::Count(size - boundary.len());
                    reduced_frequencies(
                        &context,
                        ReductionMethod::CraigBampton {
                            boundary,
                            selection,
                        },
                        count,
                    )
                },
            );
        }
    }
    methods.extend(compare_subdivisions(
        model,
        &prepared_machine.meshes,
        count,
        monitor,
    ));
    let highest = reference.omega.last().copied().unwrap_or(0.0);
    Ok(ComparisonResult {
        quantity: format!(
            "the lowest {} to {:.4} Hz",
            pluralise(count, "elastic mode"),
            highest / std::f64::consts::TAU
        ),
        norm: "largest relative error of the frequencies; of shafts in lengths, against the limit of refinement",
        dofs: Some(linear_model.n),
        reference: match is_dense {
            true => "all modes of the graded factor",
            false => "the lowest modes by elimination",
        }
        .to_string(),
        reference_error: reference.error,
        methods,
        interrupted: monitor.cancel.is_cancelled(),
    })
}

/// Computes natural frequencies, rad/s.
type FrequencyFn<'a> = &'a dyn Fn() -> Result<Vec<f64>, Error>;

/// Reference natural frequencies.
struct ReferenceFrequencies {
    /// Angular frequencies, rad/s.
    omega: Vec<f64>,
    /// Relative error of the reference, below which no error is measurable.
    error: f64,
}

/// Number of boundary coordinates of a fixed-interface reduction.
const BOUNDARY_DOFS: usize = 2;

impl ReferenceFrequencies {
    /// Largest relative error of frequencies; a text if modes are missing.
    fn relative_error(&self, omega: Vec<f64>) -> Result<f64, String> {
        match omega.len() < self.omega.len() {
            true => Err(format!(
                "gives {} of {} modes",
                omega.len(),
                self.omega.len()
            )),
            false => Ok(max_error(&omega, &self.omega).max(self.error)),
        }
    }
}

fn max_error(omega: &[f64], reference: &[f64]) -> f64 {
    omega
        .iter()
        .zip(reference)
        .fold(0.0, |m, (f, t)| ((f - t).abs() / t).max(m))
}

/// Lowest elastic frequencies, rad/s, and the least number of correct digits among them.
fn elastic_frequencies(basis: &ModalBasis, count: usize) -> (Vec<f64>, f64) {
    let range = basis.n_rigid..basis.n_rigid + count;
    let digits = basis.digits[range.clone()]
        .iter()
        .fold(f64::INFINITY, |m, d| m.min(*d));
    (basis.omega[range].to_vec(), digits)
}

fn lowest_frequencies(machine: &PreparedMachine, count: usize) -> Result<(Vec<f64>, f64), Error> {
    let request = SubsetRequest {
        count: count + machine.model.rigid.len(),
        near_omega: None,
    };
    let subset = mode_subset::solve(&machine.model, machine.forest.as_ref(), request)?;
    let elastic: Vec<_> = subset.modes.iter().filter(|m| !m.rigid).collect();
    let digits = elastic
        .iter()
        .fold(f64::INFINITY, |m, e| m.min(e.trusted_digits));
    Ok((elastic.iter().map(|m| m.omega()).collect(), digits))
}

/// Natural frequencies, rad/s, of the assembled K and M by one symmetric eigenvalue problem.
fn assembled_frequencies(
    prepared_machine: &PreparedMachine,
    basis: Option<&ModalBasis>,
    count: usize,
) -> Result<Vec<f64>, Error> {
    let Some(basis) = basis else {
        return Err(too_large_error(prepared_machine.model.n));
    };
    let model = &prepared_machine.model;
    let context = AnalysisContext {
        machine: &prepared_machine.machine,
        model,
        basis,
        speeds: None,
    };
    let identity = Matrix::identity(model.n, model.n);
    let matrices = SystemMatrices::in_basis(&context, identity, Vec::new(), 0);
    let values =
        symmetric::generalised_symmetric_eigen(&matrices.stiffness, &matrices.mass)?.values;
    let elastic = values.iter().skip(model.rigid.len()).take(count);
    Ok(elastic.map(|v| v.max(0.0).sqrt()).collect())
}

fn reduced_frequencies(
    context: &AnalysisContext,
    method: ReductionMethod,
    count: usize,
) -> Result<Vec<f64>, Error> {
    let model = ReducedModel::new(context, method)?;
    let omega = natural_frequencies(context.model, &model.matrices)?;
    let rigid = context.model.rigid.len();
    Ok(omega.into_iter().skip(rigid).take(count).collect())
}

fn too_large_error(n: usize) -> Error {
    let message = format!(
        "{n} degrees of freedom are too many for a full decomposition (limit {MAX_DENSE_DOFS})"
    );
    Error::new(Code::BudgetExceeded, message)
}

/// Coordinates with inertia by rising `k_ii/m_ii`: soft and heavy ones are retained first.
///
/// Henshell and Ong, Earthquake Engineering and Structural Dynamics 3 (1975), pp. 375–383.
fn master_dofs(model: &LinearModel) -> Vec<usize> {
    let (mut k, mut m) = (vec![0.0; model.n], vec![0.0; model.n]);
    for branch in &model.branches {
        for (i, a) in branch.direction.entries() {
            k[i] += branch.stiffness * a * a;
        }
    }
    for mass in &model.masses {
        for (i, a) in mass.direction.entries() {
            m[i] += mass.value * a * a;
        }
    }
    let mut order: Vec<usize> = (0..model.n).filter(|&i| m[i] > 0.0).collect();
    sort_ascending(&mut order, |&a| k[a] / m[a]);
    order
}

/// Sizes of reduced models: doubled from `count + BOUNDARY_DOFS`, below `full_size`.
fn size_sequence(count: usize, full_size: usize) -> Vec<usize> {
    let mut sizes = Vec::new();
    let mut size = count + BOUNDARY_DOFS;
    while size < full_size {
        sizes.push(size);
        size *= 2;
    }
    sizes
}

/// Compares subdivisions of all shafts with distributed mass.
fn compare_subdivisions(
    model: &Model,
    meshes: &MeshStage,
    count: usize,
    monitor: &mut Monitor,
) -> Vec<ComparedMethod> {
    const NAME: &str = "shafts in lengths";
    let is_applicable = model.shafts.iter().any(|s| has_mass(&s.body));
    if !is_applicable {
        return Vec::new();
    }
    let mut runs: Vec<(usize, Result<Vec<f64>, Error>, f64)> = Vec::new();
    for elements in SUBDIVISIONS {
        if !monitor.proceed(NAME) {
            return Vec::new();
        }
        let finer = with_subdivisions(model, elements);
        let (result, seconds) = min_time(|| {
            let machine = PreparedMachine::with_meshes(&finer, meshes.clone())?;
            if machine.model.n > MAX_DOFS {
                return Err(too_large_error(machine.model.n));
            }
            lowest_frequencies(&machine, count).map(|f| f.0)
        });
        let failed = result.is_err();
        runs.push((elements, result, seconds));
        if failed && elements > 1 {
            break;
        }
    }
    // The two finest subdivisions with all requested modes.
    let complete: Vec<&Vec<f64>> = runs
        .iter()
        .filter_map(|r| r.1.as_ref().ok())
        .filter(|f| f.len() == count)
        .collect();
    let [.., coarse, fine] = complete[..] else {
        return Vec::new();
    };
    let omega: Vec<f64> = fine
        .iter()
        .zip(coarse)
        .map(|(f, c)| f + (f - c) / 3.0)
        .collect();
    // The error after the extrapolation is of fourth order.
    let error = max_error(fine, &omega).powi(2);
    let limit = ReferenceFrequencies { omega, error };
    // The finest subdivision determines the limit, so its error cannot be measured.
    runs.pop();
    runs.into_iter()
        .map(|(elements, result, seconds)| {
            ComparedMethod::with_error(
                NAME,
                Some(ModelSize::ShaftElements(elements)),
                result,
                seconds,
                |f| limit.relative_error(f),
            )
        })
        .collect()
}

fn has_mass(body: &Option<ShaftBody>) -> bool {
    matches!(body, Some(ShaftBody::Bar { mass, .. }) if *mass != BarMass::None)
}

fn with_subdivisions(model: &Model, elements: usize) -> Model {
    let mut finer = model.clone();
    for shaft in finer.shafts.iter_mut().filter(|s| has_mass(&s.body)) {
        if let Some(ShaftBody::Bar { segments, .. }) = &mut shaft.body {
            *segments = elements;
        }
    }
    finer
}

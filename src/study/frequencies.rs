//! Work–precision study of natural frequencies: eigensolvers, reduction, shaft elements.
//!
//! The error of a way is the largest relative error of the frequencies asked for. Solvers and reductions are measured against
//! the machine as written; lengths against the limit of ever finer ones, by Richardson's extrapolation of second order.

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
use crate::numeric::sorting::sort_rising;
use crate::numeric::{Matrix, symmetric};
use crate::plan::meshes::stage::MeshStage;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::{BarMass, Model, ShaftBody};

/// Modes compared by default.
pub const DEFAULT_MODES: usize = 10;

/// Machines beyond this many degrees of freedom are not decomposed whole.
const MAX_DENSE_DOFS: usize = 1000;

/// Machines beyond this many degrees of freedom are not built for a comparison of lengths.
const MAX_DOFS: usize = 100_000;

/// Subdivisions of the refinement series; the last two give the reference.
const SUBDIVISIONS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Refuses machines without frequencies to compare.
///
/// # Errors
/// A machine whose strain energy is no sum of squares, or without elastic modes.
pub fn refuse(prepared_machine: &PreparedMachine) -> Result<(), Error> {
    if !prepared_machine.model.is_sum_of_squares() {
        let message =
            "stiffnesses that are negative or act across have no undamped frequencies to compare";
        return Err(Error::new(Code::Conflict, message)
            .with_hint("state the machine without them, or request its motion"));
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

/// Compares every way to the lowest elastic frequencies. Ended early, it gives the ways that were finished.
///
/// # Errors
/// Those of [`refuse`]; those of the reference.
pub fn compare_eigensolvers(
    prepared_machine: &PreparedMachine,
    model: &Model,
    count: usize,
    monitor: &mut Monitor,
) -> Result<ComparisonResult, Error> {
    let linear_model = &prepared_machine.model;
    refuse(prepared_machine)?;
    let count = count.min(elastic_modes(linear_model));
    if !monitor.proceed("reference") {
        return Err(interrupted_error());
    }
    let whole = linear_model.n <= MAX_DENSE_DOFS;
    let basis = match whole {
        true => Some(modal_basis::solve(linear_model, UndampedSolver::Factored)?),
        false => None,
    };
    let (omega, digits) = match &basis {
        Some(basis) => elastic_frequencies(basis, count),
        None => lowest_frequencies(prepared_machine, count)?,
    };
    let truth = ReferenceFrequencies {
        omega,
        error: 10f64.powf(-digits),
    };
    let mut ways = Vec::new();
    let mut add =
        |method: &'static str, size, task: &mut dyn FnMut() -> Result<Vec<f64>, Error>| {
            if !monitor.proceed(method) {
                return;
            }
            ways.push(ComparedMethod::time_method(method, size, task, |found| {
                truth.relative_error(found)
            }));
        };
    add("lowest modes only", None, &mut || {
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
            assembled(prepared_machine, basis.as_ref(), count)
        }),
    ];
    for (name, way) in dense {
        match whole {
            true => add(name, None, &mut || way()),
            false => add(name, None, &mut || Err(too_large(linear_model.n))),
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
        for kept in size_sequence(count, order.len()) {
            add(
                "static condensation",
                Some(ModelSize::Coordinates(kept)),
                &mut || {
                    let masters = order[..kept].to_vec();
                    reduced(&context, ReductionMethod::Guyan { masters }, count)
                },
            );
            add(
                "fixed-interface modes",
                Some(ModelSize::Coordinates(kept)),
                &mut || {
                    let boundary = order[..BOUNDARY_DOFS.min(kept)].to_vec();
                    let selection = ModeSelection::Count(kept - boundary.len());
                    reduced(
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
    ways.extend(compare_subdivisions(
        model,
        &prepared_machine.meshes,
        count,
        monitor,
    ));
    let highest = truth.omega.last().copied().unwrap_or(0.0);
    Ok(ComparisonResult {
        quantity: format!(
            "the lowest {} to {:.4} Hz",
            pluralise(count, "elastic mode"),
            highest / std::f64::consts::TAU
        ),
        norm: "largest relative error of the frequencies; of shafts in lengths, against the limit of ever finer ones",
        dofs: Some(linear_model.n),
        reference: match whole {
            true => "all modes of the graded factor",
            false => "the lowest modes by elimination",
        }
        .to_string(),
        reference_error: truth.error,
        methods: ways,
        interrupted: monitor.cancel.is_cancelled(),
    })
}

/// Finds frequencies, rad/s.
type FrequencyFn<'a> = &'a dyn Fn() -> Result<Vec<f64>, Error>;

/// Reference of the frequencies.
struct ReferenceFrequencies {
    /// rad/s.
    omega: Vec<f64>,
    /// Relative error of the reference, below which no error is measurable.
    error: f64,
}

/// Coordinates that keep their place where the rest is replaced by modes.
const BOUNDARY_DOFS: usize = 2;

impl ReferenceFrequencies {
    /// Relative error of frequencies, where all are there.
    fn relative_error(&self, found: Vec<f64>) -> Result<f64, String> {
        match found.len() < self.omega.len() {
            true => Err(format!(
                "gives {} of {} modes",
                found.len(),
                self.omega.len()
            )),
            false => Ok(max_error(&found, &self.omega).max(self.error)),
        }
    }
}

fn max_error(found: &[f64], truth: &[f64]) -> f64 {
    found
        .iter()
        .zip(truth)
        .fold(0.0, |m, (f, t)| ((f - t).abs() / t).max(m))
}

/// The lowest elastic frequencies of all, rad/s, and the digits of the poorest.
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
        near: None,
    };
    let found = mode_subset::solve(&machine.model, machine.forest.as_ref(), request)?;
    let elastic: Vec<_> = found.modes.iter().filter(|m| !m.rigid).collect();
    let digits = elastic
        .iter()
        .fold(f64::INFINITY, |m, e| m.min(e.trusted_digits));
    Ok((elastic.iter().map(|m| m.omega()).collect(), digits))
}

/// By the textbook's way: K and M assembled, one symmetric eigenvalue problem.
fn assembled(
    prepared_machine: &PreparedMachine,
    basis: Option<&ModalBasis>,
    count: usize,
) -> Result<Vec<f64>, Error> {
    let Some(basis) = basis else {
        return Err(too_large(prepared_machine.model.n));
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

fn reduced(
    context: &AnalysisContext,
    method: ReductionMethod,
    count: usize,
) -> Result<Vec<f64>, Error> {
    let model = ReducedModel::new(context, method)?;
    let all = natural_frequencies(context.model, &model.matrices)?;
    let rigid = context.model.rigid.len();
    Ok(all.into_iter().skip(rigid).take(count).collect())
}

fn too_large(n: usize) -> Error {
    let message =
        format!("{n} degrees of freedom are not decomposed whole (limit {MAX_DENSE_DOFS})");
    Error::new(Code::BudgetExceeded, message)
}

/// Coordinates with inertia by rising `k_ii/m_ii`: the softest and heaviest are kept first.
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
    sort_rising(&mut order, |&a| k[a] / m[a]);
    order
}

/// Doubling from what is just enough, below all.
fn size_sequence(count: usize, all: usize) -> Vec<usize> {
    let mut sizes = Vec::new();
    let mut size = count + BOUNDARY_DOFS;
    while size < all {
        sizes.push(size);
        size *= 2;
    }
    sizes
}

/// Every shaft with a mass of its own cut in more and more lengths.
fn compare_subdivisions(
    model: &Model,
    meshes: &MeshStage,
    count: usize,
    monitor: &mut Monitor,
) -> Vec<ComparedMethod> {
    const NAME: &str = "shafts in lengths";
    let cut = model.shafts.iter().any(|s| has_mass(&s.body));
    if !cut {
        return Vec::new();
    }
    let mut rungs: Vec<(usize, Result<Vec<f64>, Error>, f64)> = Vec::new();
    for lengths in SUBDIVISIONS {
        if !monitor.proceed(NAME) {
            return Vec::new();
        }
        let finer = with_subdivisions(model, lengths);
        let (found, seconds) = min_time(|| {
            let machine = PreparedMachine::with_meshes(&finer, meshes.clone())?;
            if machine.model.n > MAX_DOFS {
                return Err(too_large(machine.model.n));
            }
            lowest_frequencies(&machine, count).map(|f| f.0)
        });
        let ends = found.is_err();
        rungs.push((lengths, found, seconds));
        if ends && lengths > 1 {
            break;
        }
    }
    // The two finest whose modes are all there.
    let whole: Vec<&Vec<f64>> = rungs
        .iter()
        .filter_map(|r| r.1.as_ref().ok())
        .filter(|f| f.len() == count)
        .collect();
    let [.., coarse, fine] = whole[..] else {
        return Vec::new();
    };
    let omega: Vec<f64> = fine
        .iter()
        .zip(coarse)
        .map(|(f, c)| f + (f - c) / 3.0)
        .collect();
    // What is left after the extrapolation is of fourth order.
    let error = max_error(fine, &omega).powi(2);
    let limit = ReferenceFrequencies { omega, error };
    // The finest gave the limit: its own error cannot be told from it.
    rungs.pop();
    rungs
        .into_iter()
        .map(|(lengths, found, seconds)| {
            ComparedMethod::with_error(
                NAME,
                Some(ModelSize::ShaftElements(lengths)),
                found,
                seconds,
                |f| limit.relative_error(f),
            )
        })
        .collect()
}

fn has_mass(body: &Option<ShaftBody>) -> bool {
    matches!(body, Some(ShaftBody::Bar { mass, .. }) if *mass != BarMass::None)
}

fn with_subdivisions(model: &Model, lengths: usize) -> Model {
    let mut finer = model.clone();
    for shaft in finer.shafts.iter_mut().filter(|s| has_mass(&s.body)) {
        if let Some(ShaftBody::Bar { segments, .. }) = &mut shaft.body {
            *segments = lengths;
        }
    }
    finer
}

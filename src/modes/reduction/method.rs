//! Reduction methods: Guyan, dynamic condensation, Craig–Bampton, modal with residual flexibility.
//!
//! Guyan, AIAA J. 3 (1965), p. 380; dynamic condensation: Leung, Int. J. Numer. Methods Eng. 12 (1978), pp. 1705–1715; Craig & Bampton,
//! AIAA J. 6 (1968), pp. 1313–1319; residual flexibility: Rubin, AIAA J. 13 (1975), pp. 995–1006, and MacNeal 1971.

use super::interior::{CoordinatePartition, elastic_stiffness};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::modes::modal_basis::{column, project_direction};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Matrix, graded, symmetric};

/// Reduction methods. Coordinates are indices of independent coordinates; [`coordinate_by_name`] finds them by name.
#[derive(Debug, Clone, PartialEq)]
pub enum ReductionMethod {
    /// Static condensation, exact for static loads on the retained coordinates.
    Guyan {
        /// Retained coordinates.
        masters: Vec<usize>,
    },
    /// Dynamic condensation, exact at one frequency for an undamped model and loads on the retained coordinates, less accurate at others.
    Dynamic {
        /// Retained coordinates.
        masters: Vec<usize>,
        /// Frequency of the condensation, Hz.
        at_hz: f64,
    },
    /// Constraint modes and fixed-interface modes.
    CraigBampton {
        /// Retained coordinates.
        boundary: Vec<usize>,
        /// Selection of the fixed-interface modes.
        selection: ModeSelection,
    },
    /// Rigid-body modes, elastic modes of the machine, and the residual flexibility of the omitted modes for loads at `ports`; for free
    /// machines by inertia relief.
    Modal {
        /// Selection of the elastic modes.
        selection: ModeSelection,
        /// Loaded or measured coordinates.
        ports: Vec<usize>,
    },
}

/// Selection of the retained modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeSelection {
    /// Modes below this frequency, Hz.
    Below(f64),
    /// Number of the lowest modes.
    Count(usize),
}

impl ModeSelection {
    fn count(self, omega: &[f64]) -> usize {
        match self {
            ModeSelection::Below(hz) => omega
                .iter()
                .filter(|&&w| w < hz * std::f64::consts::TAU)
                .count(),
            ModeSelection::Count(n) => n.min(omega.len()),
        }
    }
}

/// A reduced machine.
#[derive(Debug, Clone)]
pub struct ReducedModel {
    /// Reduction method used.
    pub method: ReductionMethod,
    /// Reduced matrices `M_r`, `C_r`, `K_r` and the transformation T_r in `p = T_r r`.
    pub matrices: SystemMatrices,
    /// Lowest natural frequency of the omitted modes, rad/s; `None` if no mode with inertia was omitted.
    pub lowest_omitted: Option<f64>,
    /// Static flexibility of the omitted modes over the independent coordinates.
    pub(super) flexibility: Matrix,
    /// Natural frequencies of the omitted modes, rad/s, ascending.
    pub(super) omitted: Vec<f64>,
}

impl ReducedModel {
    /// Reduces a model by a method.
    ///
    /// # Errors
    /// `Disconnected` if a condensed coordinate can move freely with the retained ones fixed; `OutOfRange` for coordinates that do not
    /// exist; `Indefinite` for a condensation at a fixed-interface frequency.
    pub fn new(context: &AnalysisContext, method: ReductionMethod) -> Result<ReducedModel, Error> {
        match &method {
            ReductionMethod::Guyan { masters } => condense(
                context,
                masters,
                ModeSelection::Count(0),
                None,
                method.clone(),
            ),
            ReductionMethod::Dynamic { masters, at_hz } => condense(
                context,
                masters,
                ModeSelection::Count(0),
                Some(at_hz * std::f64::consts::TAU),
                method.clone(),
            ),
            ReductionMethod::CraigBampton {
                boundary,
                selection,
            } => condense(context, boundary, *selection, None, method.clone()),
            ReductionMethod::Modal { selection, ports } => {
                modal(context, *selection, ports, method.clone())
            }
        }
    }
}

/// Index of the independent coordinate that alone determines a degree of freedom `node.axis` or `node`.
///
/// # Errors
/// Those of the name; `Conflict` for a degree of freedom that follows several coordinates or none.
pub fn coordinate_by_name(
    machine: &Machine,
    model: &LinearModel,
    name: &str,
) -> Result<usize, Error> {
    let dof = crate::modes::state_space::signals::parse_input(machine, name)?;
    match model.transform[dof][..] {
        [(j, _)] => Ok(j),
        _ => {
            let message = format!(
                "`{name}` follows several other degrees of freedom, or none, through rigid joints"
            );
            Err(Error::new(Code::Conflict, message)
                .with_hint("name a degree of freedom outside the rigid joints"))
        }
    }
}

/// Natural frequencies of the model reduced by T, rad/s, ascending, rigid-body ones exactly zero; K is not formed.
///
/// # Errors
/// `Indefinite` if the reduced mass matrix is not positive definite.
pub fn natural_frequencies(
    model: &LinearModel,
    matrices: &SystemMatrices,
) -> Result<Vec<f64>, Error> {
    let springs: Vec<_> = model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
        .collect();
    let rows: Vec<Vec<f64>> = springs
        .iter()
        .map(|b| project_direction(&b.direction, &matrices.transform))
        .collect();
    let n = matrices.len();
    let factor = Matrix::from_fn(n, rows.len(), |j, i| {
        springs[i].stiffness.sqrt() * rows[i][j]
    });
    let l = symmetric::cholesky(&matrices.mass)?;
    let scaled = symmetric::solve_lower(&l, &factor).transpose().to_owned();
    let rank = n.saturating_sub(model.rigid.len());
    Ok(graded::svd(&scaled, Some(rank))?.values)
}

fn condense(
    context: &AnalysisContext,
    masters: &[usize],
    selection: ModeSelection,
    at: Option<f64>,
    method: ReductionMethod,
) -> Result<ReducedModel, Error> {
    let model = context.model;
    let partition = CoordinatePartition::new(model, masters)?;
    let static_modes = partition.constraint_modes(model)?;
    let fixed = partition.fixed_modes(model)?;
    let n_modes = selection.count(&fixed.omega);
    let mut transform = Matrix::zeros(model.n, masters.len() + n_modes);
    for k in 0..masters.len() {
        (0..model.n).for_each(|i| transform[(i, k)] = static_modes[(i, k)]);
    }
    for k in 0..n_modes {
        let at_column = masters.len() + k;
        partition
            .condensed
            .iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, at_column)] = fixed.shapes[(i, k)]);
    }
    if let Some(omega) = at {
        dynamic_condensation(context, &partition, omega, &mut transform)?;
    }
    let dof_names = masters
        .iter()
        .map(|&j| context.machine.dof_name(model.independent_dofs[j]));
    let names = dof_names
        .chain((1..=n_modes).map(|k| format!("interior mode {k}")))
        .collect();
    let omitted = fixed.omega[n_modes..].to_vec();
    let flexibility = partition.flexibility(model)?;
    let matrices = SystemMatrices::in_basis(context, transform, names, 0);
    Ok(ReducedModel {
        method,
        matrices,
        lowest_omitted: omitted.first().copied(),
        flexibility,
        omitted,
    })
}

/// Replaces the rows of the condensed coordinates by `−(K_ss − ω²M_ss)⁻¹ (K_sm − ω²M_sm)`.
fn dynamic_condensation(
    context: &AnalysisContext,
    partition: &CoordinatePartition,
    omega: f64,
    transform: &mut Matrix,
) -> Result<(), Error> {
    let full = SystemMatrices::in_basis(
        context,
        Matrix::identity(context.model.n, context.model.n),
        Vec::new(),
        0,
    );
    let (s, m) = (&partition.condensed, &partition.retained);
    let dynamic_stiffness = |i: usize, j: usize| {
        (full.stiffness[(i, j)] + full.stiffness[(j, i)]) / 2.0 - omega * omega * full.mass[(i, j)]
    };
    let d_ss = Matrix::from_fn(s.len(), s.len(), |i, j| dynamic_stiffness(s[i], s[j]));
    let d_sm = Matrix::from_fn(s.len(), m.len(), |i, j| -dynamic_stiffness(s[i], m[j]));
    let solution = symmetric::lu_solve(&d_ss, &d_sm)?;
    (0..m.len()).for_each(|k| {
        s.iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, k)] = solution[(i, k)])
    });
    Ok(())
}

/// Modal reduction with residual flexibility. A load f adds `Σ φ φᵀf/ω²` over the omitted modes, for a free machine the inertia-relief
/// attachment mode without the share of the retained modes; massless coordinates add their own flexibility.
fn modal(
    context: &AnalysisContext,
    selection: ModeSelection,
    ports: &[usize],
    method: ReductionMethod,
) -> Result<ReducedModel, Error> {
    let (model, basis) = (context.model, context.basis);
    CoordinatePartition::new(model, ports)?;
    let n_modes = basis.n_rigid + selection.count(&basis.omega[basis.n_rigid..]);
    let omitted = basis.omega[n_modes..].to_vec();
    let mut flexibility = massless_flexibility(model)?;
    for (k, omega) in omitted.iter().enumerate() {
        let shape = column(&basis.shapes, n_modes + k);
        for j in 0..model.n {
            (0..model.n).for_each(|i| flexibility[(i, j)] += shape[i] * shape[j] / (omega * omega));
        }
    }
    let attachments = independent_columns(&flexibility, ports);
    let mut transform = Matrix::zeros(model.n, n_modes + attachments.len());
    for j in 0..n_modes {
        (0..model.n).for_each(|i| transform[(i, j)] = basis.shapes[(i, j)]);
    }
    for (k, shape) in attachments.iter().enumerate() {
        (0..model.n).for_each(|i| transform[(i, n_modes + k)] = shape[i]);
    }
    let attachment_names = (1..=attachments.len()).map(|k| format!("attachment {k}"));
    let names = (1..=n_modes)
        .map(|k| format!("mode {k}"))
        .chain(attachment_names)
        .collect();
    let matrices = SystemMatrices::in_basis(context, transform, names, basis.n_rigid);
    Ok(ReducedModel {
        method,
        matrices,
        lowest_omitted: omitted.first().copied(),
        flexibility,
        omitted,
    })
}

/// Flexibility `E K₀₀⁻¹ Eᵀ` of the massless coordinates over the independent ones.
fn massless_flexibility(model: &LinearModel) -> Result<Matrix, Error> {
    let m0 = &model.massless;
    let mut flexibility = Matrix::zeros(model.n, model.n);
    if !m0.is_empty() {
        let k = elastic_stiffness(model);
        let k00 = Matrix::from_fn(m0.len(), m0.len(), |i, j| k[(m0[i], m0[j])]);
        let inverse = symmetric::lu_solve(&k00, &Matrix::identity(m0.len(), m0.len()))?;
        (0..m0.len()).for_each(|j| {
            (0..m0.len()).for_each(|i| flexibility[(m0[i], m0[j])] = inverse[(i, j)])
        });
    }
    Ok(flexibility)
}

/// Columns of a flexibility G at the ports, orthonormal in the energy `gᵀ K g`, without linearly dependent ones.
///
/// The energy product of columns i and j is `G_ij`, so this is a pivoted Cholesky factorisation.
fn independent_columns(flexibility: &Matrix, ports: &[usize]) -> Vec<Vec<f64>> {
    let mut pool: Vec<(Vec<f64>, usize)> =
        ports.iter().map(|&j| (column(flexibility, j), j)).collect();
    let diagonal: Vec<f64> = ports.iter().map(|&j| flexibility[(j, j)]).collect();
    let largest = diagonal.iter().copied().fold(0.0, f64::max);
    let mut columns = Vec::new();
    while let Some(pivot) =
        (0..pool.len()).max_by(|&a, &b| pool[a].0[pool[a].1].total_cmp(&pool[b].0[pool[b].1]))
    {
        let (shape, port) = pool.swap_remove(pivot);
        let energy = shape[port];
        // Relative to the largest flexibility: a smaller remainder of a dependent port is rounding.
        if energy <= 1e-12 * largest {
            break;
        }
        let unit: Vec<f64> = shape.iter().map(|x| x / energy.sqrt()).collect();
        for (candidate, _) in &mut pool {
            let projection = candidate[port] / energy.sqrt();
            candidate
                .iter_mut()
                .zip(&unit)
                .for_each(|(x, u)| *x -= projection * u);
        }
        columns.push(unit);
    }
    columns
}

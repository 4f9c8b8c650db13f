//! Reduction methods: Guyan, dynamic condensation, Craig–Bampton, modal with residual flexibility.
//!
//! Guyan, AIAA J. 3 (1965), p. 380; Leung, Int. J. Numer. Methods Eng. 12 (1978), pp. 1705–1715, for a frequency; Craig &
//! Bampton, AIAA J. 6 (1968), pp. 1313–1319; Rubin, AIAA J. 13 (1975), pp. 995–1006, and MacNeal 1971 for residual flexibility.

use super::interior::{CoordinatePartition, elastic_stiffness};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::modes::modal_basis::{column, project_direction};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Matrix, graded, symmetric};

/// Methods of reduction to fewer coordinates. Coordinates are numbers of those that stay; [`coordinate_by_name`] finds them by name.
#[derive(Debug, Clone, PartialEq)]
pub enum ReductionMethod {
    /// Static condensation: exact at rest for loads on what is kept.
    Guyan {
        /// Coordinates kept.
        masters: Vec<usize>,
    },
    /// Condensation at a frequency: exact there for an undamped machine and loads on what is kept, poorer elsewhere.
    Dynamic {
        /// Coordinates kept.
        masters: Vec<usize>,
        /// The frequency, Hz.
        at_hz: f64,
    },
    /// Static condensation and modes with the kept coordinates at rest.
    CraigBampton {
        /// Coordinates kept.
        boundary: Vec<usize>,
        /// Which modes.
        selection: ModeSelection,
    },
    /// Rigid motions, elastic modes of the whole machine, and how the rest yields statically to loads at `ports`: for free
    /// machines under loads that their inertia relieves.
    Modal {
        /// Which elastic modes.
        selection: ModeSelection,
        /// Coordinates that are loaded or measured.
        ports: Vec<usize>,
    },
}

/// Which modes stay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeSelection {
    /// Those below so many Hz.
    Below(f64),
    /// So many.
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
    /// `M_r`, `C_r`, `K_r` and `transform` T_r, `p = T_r r`.
    pub matrices: SystemMatrices,
    /// The lowest frequency of what was left out, rad/s; absent where nothing with inertia was.
    pub lowest_dropped: Option<f64>,
    /// Static flexibility of what was left out, over the independent coordinates.
    pub(super) flexibility: Matrix,
    /// Frequencies of what was left out, rad/s.
    pub(super) dropped: Vec<f64>,
}

impl ReducedModel {
    /// Reduces a machine.
    ///
    /// # Errors
    /// `Disconnected` where the kept coordinates leave something free; `OutOfRange` for coordinates that do not exist;
    /// `Indefinite` for a condensation at an interior resonance.
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

/// The coordinate a degree of freedom follows alone, `node.axis` or `node`.
///
/// # Errors
/// Those of a name; `Conflict` for a degree of freedom that follows several.
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

/// Natural frequencies over the columns of T, rad/s ascending, rigid ones exactly zero; K is not formed.
///
/// # Errors
/// `Indefinite` where the reduced mass is.
pub fn natural_frequencies(
    model: &LinearModel,
    matrices: &SystemMatrices,
) -> Result<Vec<f64>, Error> {
    let squares: Vec<_> = model
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
        .collect();
    let rows: Vec<Vec<f64>> = squares
        .iter()
        .map(|b| project_direction(&b.direction, &matrices.transform))
        .collect();
    let n = matrices.len();
    let turned = Matrix::from_fn(n, rows.len(), |j, i| {
        squares[i].stiffness.sqrt() * rows[i][j]
    });
    let l = symmetric::cholesky(&matrices.mass)?;
    let scaled = symmetric::solve_lower(&l, &turned).transpose().to_owned();
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
    let interior = CoordinatePartition::new(model, masters)?;
    let static_modes = interior.constraint_modes(model)?;
    let fixed = interior.fixed_modes(model)?;
    let n_kept = selection.count(&fixed.omega);
    let mut transform = Matrix::zeros(model.n, masters.len() + n_kept);
    for k in 0..masters.len() {
        (0..model.n).for_each(|i| transform[(i, k)] = static_modes[(i, k)]);
    }
    for k in 0..n_kept {
        let place = masters.len() + k;
        interior
            .condensed
            .iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, place)] = fixed.shapes[(i, k)]);
    }
    if let Some(omega) = at {
        dynamic_condensation(context, &interior, omega, &mut transform)?;
    }
    let of_masters = masters
        .iter()
        .map(|&j| context.machine.dof_name(model.independent_dofs[j]));
    let names = of_masters
        .chain((1..=n_kept).map(|k| format!("interior mode {k}")))
        .collect();
    let dropped = fixed.omega[n_kept..].to_vec();
    let flexibility = interior.flexibility(model)?;
    let matrices = SystemMatrices::in_basis(context, transform, names, 0);
    Ok(ReducedModel {
        method,
        matrices,
        lowest_dropped: dropped.first().copied(),
        flexibility,
        dropped,
    })
}

/// The others follow as `−(K_ss − ω²M_ss)⁻¹ (K_sm − ω²M_sm)`.
fn dynamic_condensation(
    context: &AnalysisContext,
    interior: &CoordinatePartition,
    omega: f64,
    transform: &mut Matrix,
) -> Result<(), Error> {
    let full = SystemMatrices::in_basis(
        context,
        Matrix::identity(context.model.n, context.model.n),
        Vec::new(),
        0,
    );
    let (s, m) = (&interior.condensed, &interior.retained);
    let at = |i: usize, j: usize| {
        (full.stiffness[(i, j)] + full.stiffness[(j, i)]) / 2.0 - omega * omega * full.mass[(i, j)]
    };
    let inner = Matrix::from_fn(s.len(), s.len(), |i, j| at(s[i], s[j]));
    let side = Matrix::from_fn(s.len(), m.len(), |i, j| -at(s[i], m[j]));
    let follow = symmetric::lu_solve(&inner, &side)?;
    (0..m.len()).for_each(|k| {
        s.iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, k)] = follow[(i, k)])
    });
    Ok(())
}

/// Residual flexibility adds `Σ φ φᵀf/ω²` over the omitted modes for a load f, which for a free machine is the inertia-relief attachment
/// mode without the kept modes' part; massless coordinates add their own flexibility.
fn modal(
    context: &AnalysisContext,
    selection: ModeSelection,
    ports: &[usize],
    method: ReductionMethod,
) -> Result<ReducedModel, Error> {
    let (model, basis) = (context.model, context.basis);
    CoordinatePartition::new(model, ports)?;
    let n_kept = basis.n_rigid + selection.count(&basis.omega[basis.n_rigid..]);
    let dropped = basis.omega[n_kept..].to_vec();
    let mut flexibility = massless_flexibility(model)?;
    for (k, omega) in dropped.iter().enumerate() {
        let shape = column(&basis.shapes, n_kept + k);
        for j in 0..model.n {
            (0..model.n).for_each(|i| flexibility[(i, j)] += shape[i] * shape[j] / (omega * omega));
        }
    }
    let attachments = independent_columns(&flexibility, ports);
    let mut transform = Matrix::zeros(model.n, n_kept + attachments.len());
    for j in 0..n_kept {
        (0..model.n).for_each(|i| transform[(i, j)] = basis.shapes[(i, j)]);
    }
    for (k, shape) in attachments.iter().enumerate() {
        (0..model.n).for_each(|i| transform[(i, n_kept + k)] = shape[i]);
    }
    let of_ports = (1..=attachments.len()).map(|k| format!("attachment {k}"));
    let names = (1..=n_kept)
        .map(|k| format!("mode {k}"))
        .chain(of_ports)
        .collect();
    let matrices = SystemMatrices::in_basis(context, transform, names, basis.n_rigid);
    Ok(ReducedModel {
        method,
        matrices,
        lowest_dropped: dropped.first().copied(),
        flexibility,
        dropped,
    })
}

/// `E K₀₀⁻¹ Eᵀ` of the massless coordinates.
fn massless_flexibility(model: &LinearModel) -> Result<Matrix, Error> {
    let light = &model.massless;
    let mut all = Matrix::zeros(model.n, model.n);
    if !light.is_empty() {
        let k = elastic_stiffness(model);
        let inner = Matrix::from_fn(light.len(), light.len(), |i, j| k[(light[i], light[j])]);
        let inverse = symmetric::lu_solve(&inner, &Matrix::identity(light.len(), light.len()))?;
        (0..light.len()).for_each(|j| {
            (0..light.len()).for_each(|i| all[(light[i], light[j])] = inverse[(i, j)])
        });
    }
    Ok(all)
}

/// Columns of a flexibility G, made orthonormal in its own energy `gᵀ K g`, those that depend left out.
///
/// The energy product of columns i and j is `G_ij`, so that this is a Cholesky factorisation with pivots.
fn independent_columns(flexibility: &Matrix, ports: &[usize]) -> Vec<Vec<f64>> {
    let mut rest: Vec<(Vec<f64>, usize)> =
        ports.iter().map(|&j| (column(flexibility, j), j)).collect();
    let first: Vec<f64> = ports.iter().map(|&j| flexibility[(j, j)]).collect();
    let largest = first.iter().copied().fold(0.0, f64::max);
    let mut found = Vec::new();
    while let Some(at) =
        (0..rest.len()).max_by(|&a, &b| rest[a].0[rest[a].1].total_cmp(&rest[b].0[rest[b].1]))
    {
        let (shape, port) = rest.swap_remove(at);
        let energy = shape[port];
        // Of the largest flexibility: the rest of a port that follows the others is rounding.
        if energy <= 1e-12 * largest {
            break;
        }
        let unit: Vec<f64> = shape.iter().map(|x| x / energy.sqrt()).collect();
        for (other, _) in &mut rest {
            let share = other[port] / energy.sqrt();
            other
                .iter_mut()
                .zip(&unit)
                .for_each(|(x, u)| *x -= share * u);
        }
        found.push(unit);
    }
    found
}

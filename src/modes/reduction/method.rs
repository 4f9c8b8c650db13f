//! The methods: static and dynamic condensation, fixed-interface modes, free modes with what they leave out statically.
//!
//! Guyan, AIAA J. 3 (1965), p. 380; Leung, Int. J. Numer. Methods Eng. 12 (1978), pp. 1705–1715, for a frequency; Craig &
//! Bampton, AIAA J. 6 (1968), pp. 1313–1319; Rubin, AIAA J. 13 (1975), pp. 995–1006, and MacNeal 1971 for residual flexibility.

use super::interior::{Interior, squares_stiffness};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::machine::parts::Machine;
use crate::modes::basis::{column, seen};
use crate::modes::equations::{Case, Equations};
use crate::numeric::{Matrix, definite, graded};

/// How to reduce. Coordinates are numbers of those that stay; [`coordinate`] finds them by name.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
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
        keep: Keep,
    },
    /// Rigid motions, elastic modes of the whole machine, and how the rest yields statically to loads at `ports`: for free
    /// machines under loads that their inertia relieves.
    Modal {
        /// Which elastic modes.
        keep: Keep,
        /// Coordinates that are loaded or measured.
        ports: Vec<usize>,
    },
}

/// Which modes stay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Keep {
    /// Those below so many Hz.
    Below(f64),
    /// So many.
    Count(usize),
}

impl Keep {
    fn of(self, omega: &[f64]) -> usize {
        match self {
            Keep::Below(hz) => omega
                .iter()
                .filter(|&&w| w < hz * std::f64::consts::TAU)
                .count(),
            Keep::Count(n) => n.min(omega.len()),
        }
    }
}

/// A reduced machine.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// How it was reduced.
    pub method: Method,
    /// `M_r`, `C_r`, `K_r` and `transform` T_r, `p = T_r r`.
    pub equations: Equations,
    /// The lowest frequency of what was left out, rad/s; absent where nothing with inertia was.
    pub lowest_dropped: Option<f64>,
    /// Static flexibility of what was left out, over the coordinates that stay.
    pub(super) flexibility: Matrix,
    /// Frequencies of what was left out, rad/s.
    pub(super) dropped: Vec<f64>,
}

impl Reduced {
    /// Reduces a machine.
    ///
    /// # Errors
    /// `Disconnected` where the kept coordinates leave something free; `OutOfRange` for coordinates that do not exist;
    /// `Indefinite` for a condensation at an interior resonance.
    pub fn new(case: &Case, method: Method) -> Result<Reduced, Error> {
        match &method {
            Method::Guyan { masters } => {
                with_interior(case, masters, Keep::Count(0), None, method.clone())
            }
            Method::Dynamic { masters, at_hz } => with_interior(
                case,
                masters,
                Keep::Count(0),
                Some(at_hz * std::f64::consts::TAU),
                method.clone(),
            ),
            Method::CraigBampton { boundary, keep } => {
                with_interior(case, boundary, *keep, None, method.clone())
            }
            Method::Modal { keep, ports } => modal(case, *keep, ports, method.clone()),
        }
    }
}

/// The coordinate a freedom follows alone, `node.axis` or `node`.
///
/// # Errors
/// Those of a name; `Conflict` for a freedom that follows several.
pub fn coordinate(machine: &Machine, linear: &Linear, name: &str) -> Result<usize, Error> {
    let freedom = crate::modes::state_space::signals::input(machine, name)?;
    match linear.transform[freedom][..] {
        [(j, _)] => Ok(j),
        _ => {
            let message =
                format!("`{name}` follows several other freedoms, or none, through rigid joints");
            Err(Error::new(Code::Conflict, message).hint("name a freedom beside the rigid joints"))
        }
    }
}

/// Natural frequencies over the columns of T, rad/s ascending, rigid ones exactly zero; K is not formed.
///
/// # Errors
/// `Indefinite` where the reduced mass is.
pub fn frequencies(linear: &Linear, equations: &Equations) -> Result<Vec<f64>, Error> {
    let squares: Vec<_> = linear
        .branches
        .iter()
        .filter(|b| b.stiffness > 0.0 && b.force.is_none())
        .collect();
    let rows: Vec<Vec<f64>> = squares
        .iter()
        .map(|b| seen(&b.direction, &equations.transform))
        .collect();
    let n = equations.len();
    let turned = Matrix::from_fn(n, rows.len(), |j, i| {
        squares[i].stiffness.sqrt() * rows[i][j]
    });
    let l = definite::cholesky(&equations.mass)?;
    let scaled = definite::solve_lower(&l, &turned).transpose().to_owned();
    let rank = n.saturating_sub(linear.rigid.len());
    Ok(graded::svd(&scaled, Some(rank))?.values)
}

fn with_interior(
    case: &Case,
    masters: &[usize],
    keep: Keep,
    at: Option<f64>,
    method: Method,
) -> Result<Reduced, Error> {
    let linear = case.linear;
    let interior = Interior::new(linear, masters)?;
    let static_modes = interior.constraint_modes(linear)?;
    let fixed = interior.fixed_modes(linear)?;
    let n_kept = keep.of(&fixed.omega);
    let mut transform = Matrix::zeros(linear.n, masters.len() + n_kept);
    for k in 0..masters.len() {
        (0..linear.n).for_each(|i| transform[(i, k)] = static_modes[(i, k)]);
    }
    for k in 0..n_kept {
        let place = masters.len() + k;
        interior
            .slaves
            .iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, place)] = fixed.shapes[(i, k)]);
    }
    if let Some(omega) = at {
        follow_at(case, &interior, omega, &mut transform)?;
    }
    let of_masters = masters
        .iter()
        .map(|&j| case.machine.freedom_name(linear.free[j]));
    let names = of_masters
        .chain((1..=n_kept).map(|k| format!("interior mode {k}")))
        .collect();
    let dropped = fixed.omega[n_kept..].to_vec();
    let flexibility = interior.flexibility(linear)?;
    let equations = Equations::over(case, transform, names, 0);
    Ok(Reduced {
        method,
        equations,
        lowest_dropped: dropped.first().copied(),
        flexibility,
        dropped,
    })
}

/// The others follow as `−(K_ss − ω²M_ss)⁻¹ (K_sm − ω²M_sm)`.
fn follow_at(
    case: &Case,
    interior: &Interior,
    omega: f64,
    transform: &mut Matrix,
) -> Result<(), Error> {
    let full = Equations::over(
        case,
        Matrix::identity(case.linear.n, case.linear.n),
        Vec::new(),
        0,
    );
    let (s, m) = (&interior.slaves, &interior.masters);
    let at = |i: usize, j: usize| {
        (full.stiffness[(i, j)] + full.stiffness[(j, i)]) / 2.0 - omega * omega * full.mass[(i, j)]
    };
    let inner = Matrix::from_fn(s.len(), s.len(), |i, j| at(s[i], s[j]));
    let side = Matrix::from_fn(s.len(), m.len(), |i, j| -at(s[i], m[j]));
    let follow = definite::solve(&inner, &side)?;
    (0..m.len()).for_each(|k| {
        s.iter()
            .enumerate()
            .for_each(|(i, &j)| transform[(j, k)] = follow[(i, k)])
    });
    Ok(())
}

/// What is left out of the modes yields to a load f by `Σ φ φᵀf/ω²` over the modes left out, which for a free machine is the
/// inertia-relief attachment mode without the kept modes' part; massless coordinates add their own flexibility.
fn modal(case: &Case, keep: Keep, ports: &[usize], method: Method) -> Result<Reduced, Error> {
    let (linear, basis) = (case.linear, case.basis);
    Interior::new(linear, ports)?;
    let n_kept = basis.n_rigid + keep.of(&basis.omega[basis.n_rigid..]);
    let dropped = basis.omega[n_kept..].to_vec();
    let mut flexibility = light_flexibility(linear)?;
    for (k, omega) in dropped.iter().enumerate() {
        let shape = column(&basis.shapes, n_kept + k);
        for j in 0..linear.n {
            (0..linear.n)
                .for_each(|i| flexibility[(i, j)] += shape[i] * shape[j] / (omega * omega));
        }
    }
    let attachments = independent_columns(&flexibility, ports);
    let mut transform = Matrix::zeros(linear.n, n_kept + attachments.len());
    for j in 0..n_kept {
        (0..linear.n).for_each(|i| transform[(i, j)] = basis.shapes[(i, j)]);
    }
    for (k, shape) in attachments.iter().enumerate() {
        (0..linear.n).for_each(|i| transform[(i, n_kept + k)] = shape[i]);
    }
    let of_ports = (1..=attachments.len()).map(|k| format!("attachment {k}"));
    let names = (1..=n_kept)
        .map(|k| format!("mode {k}"))
        .chain(of_ports)
        .collect();
    let equations = Equations::over(case, transform, names, basis.n_rigid);
    Ok(Reduced {
        method,
        equations,
        lowest_dropped: dropped.first().copied(),
        flexibility,
        dropped,
    })
}

/// `E K₀₀⁻¹ Eᵀ` of the massless coordinates.
fn light_flexibility(linear: &Linear) -> Result<Matrix, Error> {
    let light = &linear.massless;
    let mut all = Matrix::zeros(linear.n, linear.n);
    if !light.is_empty() {
        let k = squares_stiffness(linear);
        let inner = Matrix::from_fn(light.len(), light.len(), |i, j| k[(light[i], light[j])]);
        let inverse = definite::solve(&inner, &Matrix::identity(light.len(), light.len()))?;
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

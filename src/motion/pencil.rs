//! Linear systems `(s I − ∂f/∂y) x = b` of implicit methods, positions eliminated.

use super::dynamic_model::{ForceElement, ForceLaw};
use super::equations::RegimeProblem;
use super::problem::OdeProblem;
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::problem::IntegrationStats;
use crate::numeric::lu::{ComplexLu, Lu};
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// Jacobian ∂f/∂y as a method of integration shifts and factorises it.
pub enum JacobianPencil {
    /// As it is, and whether an equation of motion moves each state.
    FirstOrder(Matrix, Vec<bool>),
    /// Second-order Jacobian of a machine without inner states, `f = [v, a]`: `∂a/∂q = −K` and `∂a/∂v = −C`.
    SecondOrder {
        /// K.
        stiffness: Matrix,
        /// C.
        damping: Matrix,
    },
}

/// A problem that knows its ∂f/∂y.
pub trait HasPencil: OdeProblem {
    /// ∂f/∂y.
    fn pencil(&self, t: f64, y: &[f64], stats: &mut IntegrationStats) -> JacobianPencil;
}

/// Any problem, with its Jacobian as it is.
pub struct DenseProblem<'a, P>(pub &'a P);

impl<P: OdeProblem> OdeProblem for DenseProblem<'_, P> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.0.derivative(t, y, dy);
    }

    fn jacobian(&self, t: f64, y: &[f64], jacobian: &mut Matrix) {
        self.0.jacobian(t, y, jacobian);
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        self.0.next_discontinuity(t)
    }
}

impl<P: OdeProblem> HasPencil for DenseProblem<'_, P> {
    fn pencil(&self, t: f64, y: &[f64], stats: &mut IntegrationStats) -> JacobianPencil {
        plain(self.0, t, y, stats)
    }
}

fn plain(
    problem: &impl OdeProblem,
    t: f64,
    y: &[f64],
    stats: &mut IntegrationStats,
) -> JacobianPencil {
    let n = problem.len();
    let mut jacobian = Matrix::zeros(n, n);
    problem.jacobian(t, y, &mut jacobian);
    stats.jacobians += 1;
    JacobianPencil::FirstOrder(jacobian, vec![true; n])
}

impl HasPencil for RegimeProblem<'_> {
    fn pencil(&self, t: f64, y: &[f64], stats: &mut IntegrationStats) -> JacobianPencil {
        if self.model.internal_count() > 0 || self.model.has_massless() {
            let mut pencil = plain(self, t, y, stats);
            if let JacobianPencil::FirstOrder(_, moving) = &mut pencil {
                *moving = self.model.differential_states(self.regime);
            }
            return pencil;
        }
        stats.jacobians += 1;
        match self.model.elements.iter().any(is_nonlocal) {
            true => pencil_by_differences(self, t, y, stats),
            false => analytic_pencil(self, t, y),
        }
    }
}

/// Whether a wave of a branch follows an angle.
pub fn follows_angle(branch: &ForceElement) -> bool {
    !branch.angle_waves.is_empty()
        || branch
            .stiffness_wave
            .as_ref()
            .is_some_and(|w| w.phase.angle().is_some())
}

/// Whether the force of a branch goes by what others do.
fn is_nonlocal(branch: &ForceElement) -> bool {
    follows_angle(branch) || matches!(branch.law, ForceLaw::LoadFriction(_))
}

/// By differences.
fn pencil_by_differences(
    frozen: &RegimeProblem,
    t: f64,
    y: &[f64],
    stats: &mut IntegrationStats,
) -> JacobianPencil {
    let n = frozen.model.coordinate_count();
    let mut jacobian = Matrix::zeros(2 * n, 2 * n);
    frozen.jacobian(t, y, &mut jacobian);
    stats.evaluations += 2 * n as u64;
    JacobianPencil::SecondOrder {
        stiffness: Matrix::from_fn(n, n, |i, j| -jacobian[(n + i, j)]),
        damping: Matrix::from_fn(n, n, |i, j| -jacobian[(n + i, n + j)]),
    }
}

/// From the laws of the branches: `∂a/∂q = (I − M⁻¹Wᵀ(W M⁻¹Wᵀ)⁻¹W) M⁻¹ ∂g/∂q`, W the directions that stick.
fn analytic_pencil(frozen: &RegimeProblem, t: f64, y: &[f64]) -> JacobianPencil {
    let model = frozen.model;
    let n = model.coordinate_count();
    let (mut stiffness, mut damping) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
    for (at, branch) in model.elements.iter().enumerate() {
        let (_, k, c) = model.element_force(at, Some(frozen.regime), t, y, 0.0);
        add_outer_product(
            &mut stiffness,
            branch.force_direction(),
            &branch.direction,
            k,
        );
        add_outer_product(&mut damping, branch.force_direction(), &branch.direction, c);
    }
    if let Some((k, c)) = &model.global_matrices {
        stiffness += k;
        damping += c;
    }
    let sticking = frozen.regime.sticking_pairs();
    let zero = vec![0.0; n];
    for j in 0..n {
        let mut unit = vec![0.0; n];
        unit[j] = model.mass_damping;
        let drag = model.momentum(&unit);
        for (matrix, dragged) in [(&mut stiffness, false), (&mut damping, true)] {
            let mut column: Vec<f64> = (0..n).map(|i| matrix[(i, j)]).collect();
            if dragged {
                column.iter_mut().zip(&drag).for_each(|(x, d)| *x += d);
            }
            let held = model.constraint_forces(&sticking, &column, &zero, |_| 0.0);
            for (&at, held) in sticking.iter().zip(held) {
                model.elements[at]
                    .direction
                    .entries()
                    .for_each(|(i, a)| column[i] -= a * held);
            }
            model.apply_inverse_mass(&mut column);
            (0..n).for_each(|i| matrix[(i, j)] = column[i]);
        }
    }
    JacobianPencil::SecondOrder { stiffness, damping }
}

/// `A += x u wᵀ`.
pub fn add_outer_product(a: &mut Matrix, u: &Direction, w: &Direction, x: f64) {
    if x == 0.0 {
        return;
    }
    for (i, ui) in u.entries() {
        for (j, wj) in w.entries() {
            a[(i, j)] += x * ui * wj;
        }
    }
}

/// `s I − ∂f/∂y`, factored; T a real or complex number.
pub struct FactoredPencil<T, L> {
    s: T,
    lu: L,
}

impl JacobianPencil {
    /// For a real s.
    ///
    /// # Errors
    /// `Indefinite` where s is an eigenvalue to working precision.
    pub fn real(&self, s: f64) -> Result<FactoredPencil<f64, Lu>, Error> {
        let n = self.unknowns();
        let diagonal = |i: usize, j: usize, x: f64| if i == j { x } else { 0.0 };
        let matrix = match self {
            JacobianPencil::FirstOrder(a, moving) => Matrix::from_fn(n, n, |i, j| {
                diagonal(i, j, if moving[i] { s } else { 0.0 }) - a[(i, j)]
            }),
            JacobianPencil::SecondOrder { stiffness, damping } => Matrix::from_fn(n, n, |i, j| {
                diagonal(i, j, s) + damping[(i, j)] + stiffness[(i, j)] / s
            }),
        };
        Ok(FactoredPencil {
            s,
            lu: Lu::new(&matrix)?,
        })
    }

    /// For a complex s.
    ///
    /// # Errors
    /// As [`JacobianPencil::real`].
    pub fn complex(&self, s: Complex) -> Result<FactoredPencil<Complex, ComplexLu>, Error> {
        let n = self.unknowns();
        let diagonal = |i: usize, j: usize| if i == j { s } else { Complex::ZERO };
        let matrix = match self {
            JacobianPencil::FirstOrder(a, moving) => {
                ComplexMatrix::from_fn(n, n, |i, j| match moving[i] {
                    true => diagonal(i, j) - a[(i, j)],
                    false => Complex::from(-a[(i, j)]),
                })
            }
            JacobianPencil::SecondOrder { stiffness, damping } => {
                ComplexMatrix::from_fn(n, n, |i, j| {
                    diagonal(i, j) + damping[(i, j)] + Complex::from(stiffness[(i, j)]) / s
                })
            }
        };
        Ok(FactoredPencil {
            s,
            lu: ComplexLu::new(&matrix)?,
        })
    }

    /// `(s I − ∂f/∂y)⁻¹ b`, in place.
    pub fn solve(&self, factored: &FactoredPencil<f64, Lu>, b: &mut [f64]) {
        let s = factored.s;
        match self {
            JacobianPencil::FirstOrder(..) => factored.lu.solve(b),
            JacobianPencil::SecondOrder { stiffness, .. } => {
                let n = stiffness.nrows();
                let (q, v) = b.split_at_mut(n);
                for i in 0..n {
                    v[i] -= (0..n).map(|j| stiffness[(i, j)] * q[j]).sum::<f64>() / s;
                }
                factored.lu.solve(v);
                q.iter_mut().zip(v).for_each(|(q, v)| *q = (*q + *v) / s);
            }
        }
    }

    /// The same for a complex s.
    pub fn solve_complex(&self, factored: &FactoredPencil<Complex, ComplexLu>, b: &mut [Complex]) {
        let s = factored.s;
        match self {
            JacobianPencil::FirstOrder(..) => factored.lu.solve(b),
            JacobianPencil::SecondOrder { stiffness, .. } => {
                let n = stiffness.nrows();
                let (q, v) = b.split_at_mut(n);
                for i in 0..n {
                    let sum = (0..n).fold(Complex::ZERO, |sum, j| sum + q[j] * stiffness[(i, j)]);
                    v[i] -= sum / s;
                }
                factored.lu.solve(v);
                q.iter_mut().zip(v).for_each(|(q, v)| *q = (*q + *v) / s);
            }
        }
    }

    /// One for a state that an equation of motion moves, else zero.
    pub fn mass_entry(&self, state: usize) -> f64 {
        match self {
            JacobianPencil::FirstOrder(_, moving) if !moving[state] => 0.0,
            _ => 1.0,
        }
    }

    /// The order of the linear systems.
    fn unknowns(&self) -> usize {
        match self {
            JacobianPencil::FirstOrder(a, _) => a.nrows(),
            JacobianPencil::SecondOrder { stiffness, .. } => stiffness.nrows(),
        }
    }
}

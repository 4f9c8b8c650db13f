//! The linear systems of implicit methods, `(s I − ∂f/∂y) x = b`, with positions eliminated where the problem is a machine; without the
//! one of I where no equation of motion moves a state.

use super::equations::Frozen;
use super::problem::Problem;
use super::train::{Branch, Law};
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::problem::Effort;
use crate::numeric::lu::{ComplexLu, Lu};
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// ∂f/∂y.
pub enum Pencil {
    /// As it is, and whether an equation of motion moves each state.
    Plain(Matrix, Vec<bool>),
    /// Of a machine without inner states, `f = [v, a]`: `∂a/∂q = −K` and `∂a/∂v = −C`.
    Second {
        /// K.
        stiffness: Matrix,
        /// C.
        damping: Matrix,
    },
}

/// A problem that knows its ∂f/∂y.
pub trait Linearised: Problem {
    /// ∂f/∂y.
    fn pencil(&self, t: f64, y: &[f64], effort: &mut Effort) -> Pencil;
}

/// Any problem, with its Jacobian as it is.
pub struct Plain<'a, P>(pub &'a P);

impl<P: Problem> Problem for Plain<'_, P> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.0.slope(t, y, dy);
    }

    fn jacobian(&self, t: f64, y: &[f64], jacobian: &mut Matrix) {
        self.0.jacobian(t, y, jacobian);
    }

    fn next_break(&self, t: f64) -> f64 {
        self.0.next_break(t)
    }
}

impl<P: Problem> Linearised for Plain<'_, P> {
    fn pencil(&self, t: f64, y: &[f64], effort: &mut Effort) -> Pencil {
        plain(self.0, t, y, effort)
    }
}

fn plain(problem: &impl Problem, t: f64, y: &[f64], effort: &mut Effort) -> Pencil {
    let n = problem.len();
    let mut jacobian = Matrix::zeros(n, n);
    problem.jacobian(t, y, &mut jacobian);
    effort.jacobians += 1;
    Pencil::Plain(jacobian, vec![true; n])
}

impl Linearised for Frozen<'_> {
    fn pencil(&self, t: f64, y: &[f64], effort: &mut Effort) -> Pencil {
        if self.train.inner() > 0 || self.train.has_light() {
            let mut pencil = plain(self, t, y, effort);
            if let Pencil::Plain(_, moving) = &mut pencil {
                *moving = self.train.moving_states(self.regime);
            }
            return pencil;
        }
        effort.jacobians += 1;
        match self.train.branches.iter().any(leans) {
            true => differences(self, t, y, effort),
            false => exact(self, t, y),
        }
    }
}

/// Whether a wave of a branch follows an angle.
pub fn follows(branch: &Branch) -> bool {
    !branch.followed.is_empty()
        || branch
            .variation
            .as_ref()
            .is_some_and(|w| w.phase.angle().is_some())
}

/// Whether the force of a branch goes by what others do.
fn leans(branch: &Branch) -> bool {
    follows(branch) || matches!(branch.law, Law::Pressed(_))
}

/// By differences.
fn differences(frozen: &Frozen, t: f64, y: &[f64], effort: &mut Effort) -> Pencil {
    let n = frozen.train.n();
    let mut jacobian = Matrix::zeros(2 * n, 2 * n);
    frozen.jacobian(t, y, &mut jacobian);
    effort.evaluations += 2 * n as u64;
    Pencil::Second {
        stiffness: Matrix::from_fn(n, n, |i, j| -jacobian[(n + i, j)]),
        damping: Matrix::from_fn(n, n, |i, j| -jacobian[(n + i, n + j)]),
    }
}

/// From the laws of the branches: `∂a/∂q = (I − M⁻¹Wᵀ(W M⁻¹Wᵀ)⁻¹W) M⁻¹ ∂g/∂q`, W the directions that stick.
fn exact(frozen: &Frozen, t: f64, y: &[f64]) -> Pencil {
    let train = frozen.train;
    let n = train.n();
    let (mut stiffness, mut damping) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
    for (at, branch) in train.branches.iter().enumerate() {
        let (_, k, c) = train.force(at, Some(frozen.regime), t, y, 0.0);
        add(&mut stiffness, branch.acts(), &branch.direction, k);
        add(&mut damping, branch.acts(), &branch.direction, c);
    }
    if let Some((k, c)) = &train.general {
        stiffness += k;
        damping += c;
    }
    let sticking = frozen.regime.sticking();
    let zero = vec![0.0; n];
    for j in 0..n {
        let mut unit = vec![0.0; n];
        unit[j] = train.drag;
        let drag = train.momentum(&unit);
        for (matrix, dragged) in [(&mut stiffness, false), (&mut damping, true)] {
            let mut column: Vec<f64> = (0..n).map(|i| matrix[(i, j)]).collect();
            if dragged {
                column.iter_mut().zip(&drag).for_each(|(x, d)| *x += d);
            }
            let held = train.reactions(&sticking, &column, &zero, |_| 0.0);
            for (&at, held) in sticking.iter().zip(held) {
                train.branches[at]
                    .direction
                    .scaled()
                    .for_each(|(i, a)| column[i] -= a * held);
            }
            train.accelerate(&mut column);
            (0..n).for_each(|i| matrix[(i, j)] = column[i]);
        }
    }
    Pencil::Second { stiffness, damping }
}

/// `A += x u wᵀ`.
pub fn add(a: &mut Matrix, u: &Direction, w: &Direction, x: f64) {
    if x == 0.0 {
        return;
    }
    for (i, ui) in u.scaled() {
        for (j, wj) in w.scaled() {
            a[(i, j)] += x * ui * wj;
        }
    }
}

/// `s I − ∂f/∂y`, factored; T a real or complex number.
pub struct Factored<T, L> {
    s: T,
    lu: L,
}

impl Pencil {
    /// For a real s.
    ///
    /// # Errors
    /// `Indefinite` where s is an eigenvalue to working precision.
    pub fn real(&self, s: f64) -> Result<Factored<f64, Lu>, Error> {
        let n = self.unknowns();
        let diagonal = |i: usize, j: usize, x: f64| if i == j { x } else { 0.0 };
        let matrix = match self {
            Pencil::Plain(a, moving) => Matrix::from_fn(n, n, |i, j| {
                diagonal(i, j, if moving[i] { s } else { 0.0 }) - a[(i, j)]
            }),
            Pencil::Second { stiffness, damping } => Matrix::from_fn(n, n, |i, j| {
                diagonal(i, j, s) + damping[(i, j)] + stiffness[(i, j)] / s
            }),
        };
        Ok(Factored {
            s,
            lu: Lu::new(&matrix)?,
        })
    }

    /// For a complex s.
    ///
    /// # Errors
    /// As [`Pencil::real`].
    pub fn complex(&self, s: Complex) -> Result<Factored<Complex, ComplexLu>, Error> {
        let n = self.unknowns();
        let diagonal = |i: usize, j: usize| if i == j { s } else { Complex::ZERO };
        let matrix = match self {
            Pencil::Plain(a, moving) => ComplexMatrix::from_fn(n, n, |i, j| match moving[i] {
                true => diagonal(i, j) - a[(i, j)],
                false => Complex::from(-a[(i, j)]),
            }),
            Pencil::Second { stiffness, damping } => ComplexMatrix::from_fn(n, n, |i, j| {
                diagonal(i, j) + damping[(i, j)] + Complex::from(stiffness[(i, j)]) / s
            }),
        };
        Ok(Factored {
            s,
            lu: ComplexLu::new(&matrix)?,
        })
    }

    /// `(s I − ∂f/∂y)⁻¹ b`, in place.
    pub fn solve(&self, factored: &Factored<f64, Lu>, b: &mut [f64]) {
        let s = factored.s;
        match self {
            Pencil::Plain(..) => factored.lu.solve(b),
            Pencil::Second { stiffness, .. } => {
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
    pub fn solve_complex(&self, factored: &Factored<Complex, ComplexLu>, b: &mut [Complex]) {
        let s = factored.s;
        match self {
            Pencil::Plain(..) => factored.lu.solve(b),
            Pencil::Second { stiffness, .. } => {
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
    pub fn moves(&self, state: usize) -> f64 {
        match self {
            Pencil::Plain(_, moving) if !moving[state] => 0.0,
            _ => 1.0,
        }
    }

    /// The order of the linear systems.
    fn unknowns(&self) -> usize {
        match self {
            Pencil::Plain(a, _) => a.nrows(),
            Pencil::Second { stiffness, .. } => stiffness.nrows(),
        }
    }
}

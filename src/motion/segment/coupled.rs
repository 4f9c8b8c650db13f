//! Decomposition of coupled modal equations by complex eigenpairs of the first-order form.
//!
//! States are `(sη, η̇, ẑ)` with s = ω: their squares are energies, so that eigenvectors are nearly orthogonal under light
//! damping. Positions of rigid motions exert no force and are integrals. The quadratic eigenproblem refines the eigenvalues.

use super::dense::DenseSystem;
use super::equations::ModalEquations;
use super::modal_parts::{ModalParts, NonOscillatoryPart};
use super::modal_transform::ModalTransform;
use super::weak_coupling;
use crate::base::error::Error;
use crate::numeric::quadratic::QuadraticEigenproblem;
use crate::numeric::{Complex, Matrix, eigen, symmetric};

/// Largest eigenvalue condition number (product of the norms of left and right vector) of a separable part.
const MAX_CONDITION: f64 = 1e4;

/// Modal parts, or one dense part if eigenvectors nearly coincide; `pushes` are ω, rad/s, and the forcing phasors of modal states.
///
/// # Errors
/// No convergence; numbers out of range.
pub fn decompose_coupled(
    equations: &ModalEquations,
    pushes: &[(f64, Vec<Complex>)],
) -> Result<(ModalParts, ModalTransform), Error> {
    let states = StateLayout::new(equations);
    if let Some(damped) = weak_coupling::damped_roots(equations) {
        let root = |r: weak_coupling::DampedRoot| ComplexRoot::project(&states, r.value, &r.shape);
        let roots: Vec<ComplexRoot> = damped.into_iter().map(root).collect();
        if let Some(parts) = separate_parts(equations, &states, &roots)? {
            return Ok(parts);
        }
    }
    let matrix = states.matrix(equations);
    let modes = roots(equations, &states, &matrix)?;
    match separate_parts(equations, &states, &modes)? {
        Some(parts) => Ok(parts),
        None => single_part(equations, &states, &matrix, pushes),
    }
}

/// Layout and units of the coupled first-order states.
struct StateLayout {
    /// Modes with a restoring force, and s, 1/s.
    positions: Vec<(usize, f64)>,
    /// First mode with a rate: free modes have none.
    first: usize,
    modes: usize,
    /// Units of the internal states.
    scales: Vec<f64>,
}

impl StateLayout {
    fn new(equations: &ModalEquations) -> StateLayout {
        let stiff = |j: usize| {
            let w = equations.omega[j];
            let coupled = equations.stiffness.as_ref().map_or(0.0, |k| {
                (0..equations.count()).fold(0.0, |m: f64, i| m.max(k[(i, j)].abs()))
            });
            match w.max(coupled.sqrt()) {
                0.0 => 1.0,
                s => s,
            }
        };
        StateLayout {
            positions: (equations.rigid..equations.count())
                .map(|j| (j, stiff(j)))
                .collect(),
            first: equations.free,
            modes: equations.count(),
            scales: equations.inner.iter().map(|inner| inner.scale).collect(),
        }
    }

    fn rates(&self) -> usize {
        self.modes - self.first
    }

    fn len(&self) -> usize {
        self.positions.len() + self.rates() + self.scales.len()
    }

    /// Index of the rate of a mode.
    fn rate(&self, mode: usize) -> usize {
        self.positions.len() + mode - self.first
    }

    fn inner(&self, index: usize) -> usize {
        self.positions.len() + self.rates() + index
    }

    fn matrix(&self, equations: &ModalEquations) -> Matrix {
        let d = equations.damping_matrix();
        let mut a = Matrix::zeros(self.len(), self.len());
        for (index, &(j, s)) in self.positions.iter().enumerate() {
            a[(index, self.rate(j))] = s;
            a[(self.rate(j), index)] = -equations.omega[j] * (equations.omega[j] / s);
            if let Some(k) = &equations.stiffness {
                (self.first..self.modes).for_each(|i| a[(self.rate(i), index)] -= k[(i, j)] / s);
            }
        }
        for i in self.first..self.modes {
            (self.first..self.modes).for_each(|j| a[(self.rate(i), self.rate(j))] = -d[(i, j)]);
        }
        for (index, inner) in equations.inner.iter().enumerate() {
            let state = self.inner(index);
            a[(state, state)] = -inner.decay;
            for j in self.first..self.modes {
                a[(state, self.rate(j))] = inner.velocity_row[j] / inner.scale;
                a[(self.rate(j), state)] = inner.force_column[j] * inner.scale;
            }
        }
        a
    }

    /// Modal state, coupled state and unit of every state except rigid positions and free modes.
    fn modal(&self) -> Vec<(usize, usize, f64)> {
        let positions = self.positions.iter().enumerate();
        let positions = positions.map(|(index, &(j, s))| (j, index, 1.0 / s));
        let rates = (self.first..self.modes).map(|j| (self.modes + j, self.rate(j), 1.0));
        let inner = self.scales.iter().enumerate();
        let inner = inner.map(|(index, &scale)| (2 * self.modes + index, self.inner(index), scale));
        positions.chain(rates).chain(inner).collect()
    }
}

/// Eigenvalue with Im λ ≥ 0 and its eigenvector over the states.
struct ComplexRoot {
    value: Complex,
    vector: Vec<Complex>,
}

impl ComplexRoot {
    /// Eigenvector over the states from a shape over the modes that are not free.
    fn project(states: &StateLayout, value: Complex, shape: &[Complex]) -> ComplexRoot {
        let rate = |j: usize| shape[j - states.first] * value;
        let positions = states.positions.iter();
        let positions = positions.map(|&(j, s)| shape[j - states.first] * s);
        ComplexRoot {
            value,
            vector: positions
                .chain((states.first..states.modes).map(rate))
                .collect(),
        }
    }
}

fn roots(
    equations: &ModalEquations,
    states: &StateLayout,
    matrix: &Matrix,
) -> Result<Vec<ComplexRoot>, Error> {
    let n = states.len();
    let eigen = eigen::eigen(matrix)?;
    let eigenproblem = equations.inner.is_empty().then(|| quadratic(equations));
    let mut refined: Vec<ComplexRoot> = Vec::new();
    for k in (0..n).filter(|&k| eigen.values[k].im >= 0.0) {
        let value = eigen.values[k];
        let vector: Vec<Complex> = (0..n).map(|i| eigen.right[(i, k)]).collect();
        let error = f64::EPSILON * eigen.norm * eigen.condition[k];
        let alone = eigen.values.iter().enumerate().all(|(i, other)| {
            const REPEATED: f64 = 1e-8; // √ε, the accuracy of the vectors of a close pair
            i == k || (other - value).norm() > REPEATED * value.norm()
        });
        let polished = match &eigenproblem {
            Some(eigenproblem) if alone && value.norm() > 0.0 => {
                refine_root(eigenproblem, states, (value, &vector), error)
            }
            _ => None,
        };
        refined.push(polished.unwrap_or(ComplexRoot { value, vector }));
    }
    Ok(refined)
}

/// Quadratic eigenproblem of the modes that are not free.
fn quadratic(equations: &ModalEquations) -> QuadraticEigenproblem {
    let first = equations.free;
    let m = equations.count() - first;
    let d = equations.damping_matrix();
    let stiffness = Matrix::from_fn(m, m, |i, j| {
        let coupled = equations
            .stiffness
            .as_ref()
            .map_or(0.0, |k| k[(first + i, first + j)]);
        let w = equations.omega[first + i];
        if i == j { w * w + coupled } else { coupled }
    });
    QuadraticEigenproblem {
        n_inertial: m,
        damping: Matrix::from_fn(m, m, |i, j| d[(first + i, first + j)]),
        stiffness,
        hysteretic: None,
    }
}

/// Refined eigenvalue; none if the refinement converges to another one.
fn refine_root(
    eigenproblem: &QuadraticEigenproblem,
    states: &StateLayout,
    (value, vector): (Complex, &[Complex]),
    error: f64,
) -> Option<ComplexRoot> {
    let start: Vec<Complex> = (states.first..states.modes)
        .map(|j| vector[states.rate(j)] / value)
        .collect();
    let root = eigenproblem.polish(value, &start).ok()?;
    const SEARCH_RADIUS: f64 = 1e3; // of the error bound of the start
    const RESIDUAL_TOLERANCE: f64 = 1e-12;
    let near = (root.value - value).norm() <= SEARCH_RADIUS * error;
    if !near || root.residual > RESIDUAL_TOLERANCE || root.value.norm() == 0.0 {
        return None;
    }
    let mut polished = root.value;
    if value.im == 0.0 {
        polished = Complex::new(polished.re, 0.0);
    } else if polished.re.abs() <= f64::EPSILON * eigenproblem.condition(&root) * polished.norm() {
        // Damping is below its uncertainty.
        polished = Complex::new(0.0, polished.im);
    }
    let mut polished = ComplexRoot::project(states, polished, &root.right);
    if value.im == 0.0 {
        // A real root has a real vector up to a factor.
        let largest =
            polished.vector.iter().fold(
                Complex::ZERO,
                |m, &x| if x.norm() > m.norm() { x } else { m },
            );
        polished
            .vector
            .iter_mut()
            .for_each(|x| *x = Complex::new((*x / largest).re, 0.0));
    }
    Some(polished)
}

/// Separate modal parts; none if eigenvectors nearly coincide.
fn separate_parts(
    equations: &ModalEquations,
    states: &StateLayout,
    roots: &[ComplexRoot],
) -> Result<Option<(ModalParts, ModalTransform)>, Error> {
    let n = states.len();
    let (oscillations, slow): (Vec<&ComplexRoot>, Vec<&ComplexRoot>) =
        roots.iter().partition(|r| r.value.im > 0.0);
    if 2 * oscillations.len() + slow.len() != n {
        return Ok(None);
    }
    let mut vectors = Matrix::zeros(n, n);
    for (k, root) in oscillations.iter().enumerate() {
        let size = length(&root.vector);
        let cosine = vectors.col_as_slice_mut(2 * k).iter_mut();
        cosine.zip(&root.vector).for_each(|(v, x)| *v = x.re / size);
        let sine = vectors.col_as_slice_mut(2 * k + 1).iter_mut();
        sine.zip(&root.vector).for_each(|(v, x)| *v = -x.im / size);
    }
    for (k, root) in slow.iter().enumerate() {
        let size = length(&root.vector);
        let column = vectors
            .col_as_slice_mut(2 * oscillations.len() + k)
            .iter_mut();
        column.zip(&root.vector).for_each(|(v, x)| *v = x.re / size);
    }
    let Ok(inverse) = symmetric::lu_solve(&vectors, &Matrix::identity(n, n)) else {
        return Ok(None);
    };
    let mut sums = vec![0.0; n];
    for j in 0..n {
        let column = inverse.col_as_slice(j).iter();
        sums.iter_mut()
            .zip(column)
            .for_each(|(sum, x)| *sum += x * x);
    }
    if !sums
        .iter()
        .all(|&square| square < MAX_CONDITION * MAX_CONDITION)
    {
        return Ok(None);
    }

    // σ: oscillations; then coasts (p, v) or decays; then constants of rigid positions; then free modes.
    let (rigid, free) = (equations.free..equations.rigid, 0..equations.free);
    let width = if rigid.is_empty() { 1 } else { 2 };
    let constants = 2 * oscillations.len() + width * slow.len();
    let total = constants + rigid.len() + 2 * free.len();
    let modal = 2 * states.modes + states.scales.len();
    let state_of = |k: usize| match k < 2 * oscillations.len() {
        true => k,
        false => 2 * oscillations.len() + width * (k - 2 * oscillations.len()) + width - 1,
    };
    let (mut out, mut into) = (Matrix::zeros(modal, total), Matrix::zeros(total, modal));
    let states_by_row = states.modal();
    for k in 0..n {
        let (vector, column) = (vectors.col_as_slice(k), out.col_as_slice_mut(state_of(k)));
        let states_by_row = states_by_row.iter();
        states_by_row.for_each(|&(row, state, unit)| column[row] = unit * vector[state]);
    }
    for &(row, state, unit) in &states_by_row {
        let column = into.col_as_slice_mut(row);
        let shares = inverse.col_as_slice(state).iter().enumerate();
        shares.for_each(|(k, x)| column[state_of(k)] = x / unit);
    }
    for (base, mode) in rigid.clone().enumerate() {
        let state = constants + base;
        out[(mode, state)] = 1.0;
        into[(state, mode)] = 1.0;
        for (k, root) in oscillations.iter().enumerate() {
            // The integral of Re(X ζ) is Re(X ζ/λ) and a constant.
            let rate = states.rate(mode);
            let x = Complex::new(vectors[(rate, 2 * k)], -vectors[(rate, 2 * k + 1)]) / root.value;
            out[(mode, 2 * k)] = x.re;
            out[(mode, 2 * k + 1)] = -x.im;
            for i in 0..modal {
                let column = into.col_as_slice_mut(i);
                column[state] -= x.re * column[2 * k] - x.im * column[2 * k + 1];
            }
        }
        for k in 0..slow.len() {
            let column = 2 * oscillations.len() + k;
            out[(mode, state_of(column) - 1)] = vectors[(states.rate(mode), column)];
        }
    }
    for mode in free {
        let base = constants + rigid.len() + 2 * mode;
        for (state, row) in [(base, mode), (base + 1, states.modes + mode)] {
            out[(row, state)] = 1.0;
            into[(state, row)] = 1.0;
        }
    }
    let slow = slow.iter().map(|root| match width {
        1 => NonOscillatoryPart::Decay(root.value.re),
        _ => NonOscillatoryPart::RigidMotion(root.value.re),
    });
    let constants = rigid.map(|_| NonOscillatoryPart::Decay(0.0));
    let coasts = (0..equations.free).map(|_| NonOscillatoryPart::RigidMotion(-equations.drag));
    Ok(Some((
        ModalParts {
            oscillatory: oscillations.iter().map(|root| root.value).collect(),
            others: slow.chain(constants).chain(coasts).collect(),
        },
        ModalTransform::Full { out, into },
    )))
}

fn length(v: &[Complex]) -> f64 {
    v.iter().map(Complex::norm_sqr).sum::<f64>().sqrt()
}

/// One dense part of all states, including rigid positions and free modes.
fn single_part(
    equations: &ModalEquations,
    states: &StateLayout,
    matrix: &Matrix,
    pushes: &[(f64, Vec<Complex>)],
) -> Result<(ModalParts, ModalTransform), Error> {
    let n = states.len();
    let rigid = equations.rigid;
    let total = n + rigid + equations.free;
    let modal = 2 * states.modes + states.scales.len();
    // Coupled states, then rigid positions, then rates of free modes.
    let rate = |mode: usize| match mode < equations.free {
        true => n + rigid + mode,
        false => states.rate(mode),
    };
    let mut a = Matrix::zeros(total, total);
    for i in 0..n {
        (0..n).for_each(|j| a[(i, j)] = matrix[(i, j)]);
    }
    (0..rigid).for_each(|mode| a[(n + mode, rate(mode))] = 1.0);
    (0..equations.free).for_each(|mode| a[(rate(mode), rate(mode))] = -equations.drag);
    let (mut out, mut into) = (Matrix::zeros(modal, total), Matrix::zeros(total, modal));
    for (row, state, unit) in states.modal() {
        out[(row, state)] = unit;
        into[(state, row)] = 1.0 / unit;
    }
    let mut unit_entry = |row: usize, state: usize| {
        out[(row, state)] = 1.0;
        into[(state, row)] = 1.0;
    };
    (0..rigid).for_each(|mode| unit_entry(mode, n + mode));
    (0..equations.free).for_each(|mode| unit_entry(states.modes + mode, rate(mode)));
    let harmonics = pushes.iter().map(|(omega, push)| {
        let state =
            |k: usize| (0..modal).fold(Complex::ZERO, |sum, i| sum + push[i] * into[(k, i)]);
        (*omega, (0..total).map(state).collect())
    });
    let dense = DenseSystem::new(a, harmonics.collect())?;
    Ok((
        ModalParts {
            oscillatory: Vec::new(),
            others: vec![NonOscillatoryPart::Dense(Box::new(dense))],
        },
        ModalTransform::Full { out, into },
    ))
}

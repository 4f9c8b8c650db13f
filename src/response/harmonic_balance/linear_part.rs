//! Linear part of each harmonic, `X_k = H(ikω) (f_k − U N_k)`.
//!
//! H holds a straight law `k δ + c δ̇` in the place of each of them; N is what the true law differs from it by.

use crate::base::error::Error;
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// A branch that is not linear, and the straight law in its place.
#[derive(Debug, Clone, Copy)]
pub struct NonlinearElement {
    /// Branch number in the dynamic model.
    pub branch: usize,
    /// k of the straight law.
    pub stiffness: f64,
    /// c of it.
    pub damping: f64,
}

/// The linear part of a machine.
pub struct LinearPart {
    /// The branches that are not linear.
    pub active: Vec<NonlinearElement>,
    pub(super) mass: Matrix,
    pub(super) damping: Matrix,
    pub(super) stiffness: Matrix,
    /// Branches whose stiffness depends on frequency.
    pub(super) first_order: Vec<FirstOrderElement>,
    /// W, by columns.
    pub(super) input_columns: Vec<Vec<f64>>,
    /// U, by columns.
    pub(super) force_columns: Vec<Vec<f64>>,
    pub(super) free: Vec<Vec<f64>>,
    pub(super) terms: Vec<HarmonicForce>,
    /// e of every active branch: order and complex amplitude.
    pub(super) errors: Vec<Vec<(usize, Complex)>>,
}

/// A law of first order: `F = z`, its column and row.
pub(super) struct FirstOrderElement {
    pub force_columns: Vec<f64>,
    pub input_columns: Vec<f64>,
    pub kind: FirstOrderLaw,
}

pub(super) enum FirstOrderLaw {
    Maxwell { stiffness: f64, damping: f64 },
    Lagged { slope: f64, lag: f64 },
}

impl FirstOrderElement {
    /// F/δ at s, and its derivative.
    fn order_response(&self, s: Complex) -> (Complex, Complex) {
        let one = Complex::new(1.0, 0.0);
        match self.kind {
            FirstOrderLaw::Maxwell { stiffness, damping } => {
                let sum = s * damping + stiffness;
                (
                    s * (stiffness * damping) / sum,
                    one * (stiffness * stiffness * damping) / (sum * sum),
                )
            }
            FirstOrderLaw::Lagged { slope, lag } => {
                let sum = s * lag + 1.0;
                (s * -slope / sum, one * -slope / (sum * sum))
            }
        }
    }
}

/// A force `column (a + s b)` of an order; those of order zero with b act as `ω b`.
pub(super) struct HarmonicForce {
    pub order: usize,
    pub column: Vec<f64>,
    pub plain: Complex,
    pub by_rate: Complex,
}

/// Linear response at one order.
pub struct OrderResponse {
    /// G, actives by actives, row by row, and dG/dω.
    pub compliance: [Vec<Complex>; 2],
    /// p and dp/dω.
    pub drive: [Vec<Complex>; 2],
    /// H U, coordinates by actives.
    moved: ComplexMatrix,
    /// H f.
    driven: Vec<Complex>,
}

impl OrderResponse {
    /// X_k from the forces N_k.
    pub fn motion(&self, forces: &[Complex]) -> Vec<Complex> {
        let mut x = self.driven.clone();
        for (c, n) in forces.iter().enumerate() {
            x.iter_mut()
                .enumerate()
                .for_each(|(i, x)| *x -= self.moved[(i, c)] * n);
        }
        x
    }
}

pub(super) const ZERO: Complex = Complex::new(0.0, 0.0);

impl LinearPart {
    /// Number of coordinates.
    pub fn coordinate_count(&self) -> usize {
        self.mass.nrows()
    }

    /// Amplitudes of the inner states of first-order laws at an order, in the order of their branches.
    pub fn internal_states(&self, order: usize, omega: f64, motion: &[Complex]) -> Vec<Complex> {
        let s = Complex::new(0.0, order as f64 * omega);
        let state = |l: &FirstOrderElement| {
            let delta = l
                .input_columns
                .iter()
                .zip(motion)
                .fold(ZERO, |sum, (w, x)| sum + x * *w);
            let force = l.order_response(s).0 * delta;
            match l.kind {
                FirstOrderLaw::Maxwell { .. } => force,
                FirstOrderLaw::Lagged { .. } => -force,
            }
        };
        self.first_order.iter().map(state).collect()
    }

    /// Order k at ω, rad/s.
    ///
    /// # Errors
    /// `Indefinite` at a resonance that nothing damps.
    pub fn order_response(&self, order: usize, omega: f64) -> Result<OrderResponse, Error> {
        let (n, m) = (self.coordinate_count(), self.active.len());
        let s = Complex::new(0.0, order as f64 * omega);
        // At order zero free motions are held, and what accelerates them is taken off.
        let held = if order == 0 { self.free.len() } else { 0 };
        let late: Vec<(Complex, Complex)> = self
            .first_order
            .iter()
            .map(|l| l.order_response(s))
            .collect();
        let entry = |i: usize, j: usize| {
            let plain =
                s * s * self.mass[(i, j)] + s * self.damping[(i, j)] + self.stiffness[(i, j)];
            self.first_order
                .iter()
                .zip(&late)
                .fold(plain, |sum, (l, at)| {
                    sum + at.0 * (l.force_columns[i] * l.input_columns[j])
                })
        };
        let carried = |r: usize, i: usize| -> f64 {
            (0..n).map(|j| self.mass[(i, j)] * self.free[r][j]).sum()
        };
        let bordered = |i: usize, j: usize| match (i < n, j < n) {
            (true, true) => entry(i, j),
            (true, false) => Complex::new(carried(j - n, i), 0.0),
            (false, true) => Complex::new(carried(i - n, j), 0.0),
            (false, false) => ZERO,
        };
        let all = n + held;
        let dynamic = ComplexMatrix::from_fn(all, all, bordered);
        let transposed = ComplexMatrix::from_fn(all, all, |i, j| dynamic[(j, i)]);
        let (mut force, mut by_omega) = (vec![ZERO; n], vec![ZERO; n]);
        let speed = Complex::new(omega, 0.0);
        for term in self.terms.iter().filter(|t| t.order == order) {
            let (factor, slope) = match order {
                0 => (speed, Complex::new(1.0, 0.0)),
                _ => (s, Complex::new(0.0, order as f64)),
            };
            for i in 0..n {
                force[i] += (term.plain + term.by_rate * factor) * term.column[i];
                by_omega[i] += term.by_rate * slope * term.column[i];
            }
        }
        let right = ComplexMatrix::from_fn(all, m + 1, |i, j| match (i < n, j < m) {
            (true, true) => Complex::new(self.force_columns[j][i], 0.0),
            (true, false) => force[i],
            _ => ZERO,
        });
        let left = ComplexMatrix::from_fn(all, m, |i, j| {
            if i < n {
                Complex::new(self.input_columns[j][i], 0.0)
            } else {
                ZERO
            }
        });
        let moved = symmetric::lu_solve_complex(&dynamic, &right)?;
        let seen = symmetric::lu_solve_complex(&transposed, &left)?;
        let ik = Complex::new(0.0, order as f64);
        let slope = |i: usize, j: usize| {
            let plain = s * (2.0 * self.mass[(i, j)]) + self.damping[(i, j)];
            ik * self
                .first_order
                .iter()
                .zip(&late)
                .fold(plain, |sum, (l, at)| {
                    sum + at.1 * (l.force_columns[i] * l.input_columns[j])
                })
        };
        let mut turned = vec![ZERO; n * (m + 1)];
        if order > 0 {
            for i in 0..n {
                for j in 0..n {
                    let d = slope(i, j);
                    for c in 0..=m {
                        turned[i * (m + 1) + c] += d * moved[(j, c)];
                    }
                }
            }
        }
        let mut line = OrderResponse {
            compliance: [vec![ZERO; m * m], vec![ZERO; m * m]],
            drive: [vec![ZERO; m], vec![ZERO; m]],
            moved: ComplexMatrix::from_fn(n, m, |i, j| moved[(i, j)]),
            driven: (0..n).map(|i| moved[(i, m)]).collect(),
        };
        for b in 0..m {
            for c in 0..=m {
                let mut value = ZERO;
                let mut change = ZERO;
                for i in 0..n {
                    value += moved[(i, c)] * self.input_columns[b][i];
                    change -= seen[(i, b)] * turned[i * (m + 1) + c];
                }
                if c < m {
                    line.compliance[0][b * m + c] = value;
                    line.compliance[1][b * m + c] = change;
                } else {
                    let own = self.errors[b].iter().filter(|e| e.0 == order);
                    line.drive[0][b] = own.fold(value, |sum, e| sum - e.1);
                    line.drive[1][b] =
                        (0..n).fold(change, |sum, i| sum + seen[(i, b)] * by_omega[i]);
                }
            }
        }
        Ok(line)
    }
}

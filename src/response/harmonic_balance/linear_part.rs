//! Linear part of each harmonic, `X_k = H(ikω) (f_k − U N_k)`.
//!
//! H contains a reference law `k δ + c δ̇` in place of each nonlinear one; N is the difference of the true law from it.

use crate::base::error::Error;
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// Nonlinear branch with its linear reference law.
#[derive(Debug, Clone, Copy)]
pub struct NonlinearElement {
    /// Branch number in the dynamic model.
    pub branch: usize,
    /// Stiffness k of the reference law, N/m or N·m/rad.
    pub stiffness: f64,
    /// Damping c of the reference law, N·s/m or N·m·s/rad.
    pub damping: f64,
}

/// Linear part of the harmonic-balance equations of a machine.
pub struct LinearPart {
    /// Nonlinear branches.
    pub active: Vec<NonlinearElement>,
    pub(super) mass: Matrix,
    pub(super) damping: Matrix,
    pub(super) stiffness: Matrix,
    /// Branches with frequency-dependent stiffness.
    pub(super) first_order: Vec<FirstOrderElement>,
    /// Columns of W, from coordinates to deflections.
    pub(super) input_columns: Vec<Vec<f64>>,
    /// Columns of U, from branch forces to coordinates.
    pub(super) force_columns: Vec<Vec<f64>>,
    pub(super) free: Vec<Vec<f64>>,
    pub(super) terms: Vec<HarmonicForce>,
    /// Displacement excitation e of every active branch: orders and complex amplitudes.
    pub(super) errors: Vec<Vec<(usize, Complex)>>,
}

/// First-order force law `F = z` with its force column and its deflection row.
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
    /// Dynamic stiffness F/δ at s and its derivative with respect to s.
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

/// Force `column (a + s b)` of an order; at order zero the second term is `ω b`.
pub(super) struct HarmonicForce {
    pub order: usize,
    pub column: Vec<f64>,
    pub constant: Complex,
    pub rate: Complex,
}

/// Linear response at one order, with derivatives with respect to ω.
pub struct OrderResponse {
    /// Compliance G between active branches by rows, and dG/dω.
    pub compliance: [Vec<Complex>; 2],
    /// Deflections p of the active branches without nonlinear forces, and dp/dω.
    pub drive: [Vec<Complex>; 2],
    /// H U, coordinates by active branches.
    force_response: ComplexMatrix,
    /// H f, one value per coordinate.
    drive_response: Vec<Complex>,
}

impl OrderResponse {
    /// Harmonic amplitudes X_k from the nonlinear forces N_k.
    pub fn motion(&self, forces: &[Complex]) -> Vec<Complex> {
        let mut x = self.drive_response.clone();
        for (c, n) in forces.iter().enumerate() {
            x.iter_mut()
                .enumerate()
                .for_each(|(i, x)| *x -= self.force_response[(i, c)] * n);
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

    /// Amplitudes of the internal states of the first-order laws at an order, in the order of the branches.
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

    /// Linear response at order k and ω, rad/s.
    ///
    /// # Errors
    /// `Indefinite` at an undamped resonance.
    pub fn order_response(&self, order: usize, omega: f64) -> Result<OrderResponse, Error> {
        let (n, m) = (self.coordinate_count(), self.active.len());
        let s = Complex::new(0.0, order as f64 * omega);
        // At order zero the rigid-body motions are constrained, with a multiplier for the resultant load.
        let n_rigid = if order == 0 { self.free.len() } else { 0 };
        let laws: Vec<(Complex, Complex)> = self
            .first_order
            .iter()
            .map(|l| l.order_response(s))
            .collect();
        let entry = |i: usize, j: usize| {
            let sum = s * s * self.mass[(i, j)] + s * self.damping[(i, j)] + self.stiffness[(i, j)];
            self.first_order
                .iter()
                .zip(&laws)
                .fold(sum, |sum, (l, law)| {
                    sum + law.0 * (l.force_columns[i] * l.input_columns[j])
                })
        };
        let inertia = |r: usize, i: usize| -> f64 {
            (0..n).map(|j| self.mass[(i, j)] * self.free[r][j]).sum()
        };
        let bordered = |i: usize, j: usize| match (i < n, j < n) {
            (true, true) => entry(i, j),
            (true, false) => Complex::new(inertia(j - n, i), 0.0),
            (false, true) => Complex::new(inertia(i - n, j), 0.0),
            (false, false) => ZERO,
        };
        let size = n + n_rigid;
        let dynamic = ComplexMatrix::from_fn(size, size, bordered);
        let transposed = ComplexMatrix::from_fn(size, size, |i, j| dynamic[(j, i)]);
        let (mut force, mut by_omega) = (vec![ZERO; n], vec![ZERO; n]);
        let speed = Complex::new(omega, 0.0);
        for term in self.terms.iter().filter(|t| t.order == order) {
            let (factor, slope) = match order {
                0 => (speed, Complex::new(1.0, 0.0)),
                _ => (s, Complex::new(0.0, order as f64)),
            };
            for i in 0..n {
                force[i] += (term.constant + term.rate * factor) * term.column[i];
                by_omega[i] += term.rate * slope * term.column[i];
            }
        }
        let loads = ComplexMatrix::from_fn(size, m + 1, |i, j| match (i < n, j < m) {
            (true, true) => Complex::new(self.force_columns[j][i], 0.0),
            (true, false) => force[i],
            _ => ZERO,
        });
        let outputs = ComplexMatrix::from_fn(size, m, |i, j| {
            if i < n {
                Complex::new(self.input_columns[j][i], 0.0)
            } else {
                ZERO
            }
        });
        let force_response = symmetric::lu_solve_complex(&dynamic, &loads)?;
        let transposed_response = symmetric::lu_solve_complex(&transposed, &outputs)?;
        let ik = Complex::new(0.0, order as f64);
        let slope = |i: usize, j: usize| {
            let sum = s * (2.0 * self.mass[(i, j)]) + self.damping[(i, j)];
            ik * self
                .first_order
                .iter()
                .zip(&laws)
                .fold(sum, |sum, (l, law)| {
                    sum + law.1 * (l.force_columns[i] * l.input_columns[j])
                })
        };
        let mut slope_response = vec![ZERO; n * (m + 1)];
        if order > 0 {
            for i in 0..n {
                for j in 0..n {
                    let d = slope(i, j);
                    for c in 0..=m {
                        slope_response[i * (m + 1) + c] += d * force_response[(j, c)];
                    }
                }
            }
        }
        let mut response = OrderResponse {
            compliance: [vec![ZERO; m * m], vec![ZERO; m * m]],
            drive: [vec![ZERO; m], vec![ZERO; m]],
            force_response: ComplexMatrix::from_fn(n, m, |i, j| force_response[(i, j)]),
            drive_response: (0..n).map(|i| force_response[(i, m)]).collect(),
        };
        for b in 0..m {
            for c in 0..=m {
                let mut value = ZERO;
                let mut change = ZERO;
                for i in 0..n {
                    value += force_response[(i, c)] * self.input_columns[b][i];
                    change -= transposed_response[(i, b)] * slope_response[i * (m + 1) + c];
                }
                if c < m {
                    response.compliance[0][b * m + c] = value;
                    response.compliance[1][b * m + c] = change;
                } else {
                    let errors = self.errors[b].iter().filter(|e| e.0 == order);
                    response.drive[0][b] = errors.fold(value, |sum, e| sum - e.1);
                    response.drive[1][b] = (0..n).fold(change, |sum, i| {
                        sum + transposed_response[(i, b)] * by_omega[i]
                    });
                }
            }
        }
        Ok(response)
    }
}

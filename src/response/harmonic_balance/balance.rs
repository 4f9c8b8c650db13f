//! Harmonic balance `δ_k + G_k(ω) N_k(δ) − p_k(ω) = 0`, with exact Jacobian.
//!
//! Unknowns are real: of every active branch the mean, then real and imaginary part of each order, in units of its size; last
//! the frequency in units of the range.

use super::aft::AftTransform;
use super::family::SpeedFamily;
use super::linear_part::{LinearPart, OrderResponse};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::lu::Lu;
use crate::numeric::{Complex, Matrix};

const ZERO: Complex = Complex::new(0.0, 0.0);

/// The balance with a number of orders.
pub struct HarmonicBalance<'a> {
    /// The machine.
    pub family: &'a SpeedFamily,
    /// Linear part of the machine.
    pub lines: &'a LinearPart,
    /// K.
    pub orders: usize,
    alternating: AftTransform,
    /// Deflection scale of every active branch.
    sizes: Vec<f64>,
    /// Frequency scale, rad/s.
    span: f64,
}

/// A solution: the unknowns.
pub type HarmonicUnknowns = Vec<f64>;

/// The residual and its derivatives, the last column by the frequency.
struct Linearisation {
    residual: Vec<f64>,
    jacobian: Matrix,
}

/// A step this small ends Newton's method, in units of the sizes.
const NEWTON_TOLERANCE: f64 = 1e-10;

/// Newton's method has failed after so many steps.
const MAX_NEWTON: usize = 12;

impl<'a> HarmonicBalance<'a> {
    /// For so many orders; `sizes` of the active branches, `span` of the frequency.
    pub fn new(
        family: &'a SpeedFamily,
        lines: &'a LinearPart,
        orders: usize,
        sizes: &[f64],
        span: f64,
    ) -> HarmonicBalance<'a> {
        HarmonicBalance {
            alternating: AftTransform::new(family, &lines.active, orders),
            family,
            lines,
            orders,
            sizes: sizes.to_vec(),
            span,
        }
    }

    /// Number of unknowns without the frequency.
    pub fn len(&self) -> usize {
        self.sizes.len() * (2 * self.orders + 1)
    }

    /// ω, rad/s.
    pub fn omega(&self, x: &HarmonicUnknowns) -> f64 {
        x[self.len()] * self.span
    }

    /// δ_k of every active branch.
    pub fn deflections(&self, x: &HarmonicUnknowns) -> Vec<Vec<Complex>> {
        let width = 2 * self.orders + 1;
        let of = |(own, size): (usize, &f64)| {
            let part = &x[own * width..(own + 1) * width];
            let order = |k: usize| match k {
                0 => Complex::new(part[0] * size, 0.0),
                _ => Complex::new(part[2 * k - 1], part[2 * k]) * *size,
            };
            (0..=self.orders).map(order).collect()
        };
        self.sizes.iter().enumerate().map(of).collect()
    }

    /// The unknowns of deflections of any number of orders, at ω.
    pub fn unknowns(&self, delta: &[Vec<Complex>], omega: f64) -> HarmonicUnknowns {
        let mut x = Vec::with_capacity(self.len() + 1);
        for (lines, size) in delta.iter().zip(&self.sizes) {
            let line = |k: usize| lines.get(k).copied().unwrap_or(ZERO) / *size;
            x.push(line(0).re);
            (1..=self.orders).for_each(|k| x.extend([line(k).re, line(k).im]));
        }
        x.push(omega / self.span);
        x
    }

    fn linearise(&mut self, x: &HarmonicUnknowns) -> Result<Linearisation, Error> {
        let (omega, delta) = (self.omega(x), self.deflections(x));
        let (m, orders, width) = (self.sizes.len(), self.orders, 2 * self.orders + 1);
        let forces: Vec<_> = (0..m)
            .map(|c| {
                self.alternating
                    .forces(self.family, &self.lines.active, c, &delta[c], omega)
            })
            .collect();
        let total = self.len();
        let mut residual = vec![0.0; total];
        let mut jacobian = Matrix::zeros(total + 1, total + 1);
        for k in 0..=orders {
            let OrderResponse {
                compliance, drive, ..
            } = self.lines.order_response(k, omega)?;
            for b in 0..m {
                let size = self.sizes[b];
                let row = b * width + if k == 0 { 0 } else { 2 * k - 1 };
                let mut put = |column: usize, value: Complex| {
                    jacobian[(row, column)] += value.re;
                    if k > 0 {
                        jacobian[(row + 1, column)] += value.im;
                    }
                };
                let mut left = delta[b][k] - drive[0][b];
                let mut by_omega = -drive[1][b];
                for (c, force) in forces.iter().enumerate() {
                    let [g, dg] = [compliance[0][b * m + c], compliance[1][b * m + c]];
                    left += g * force.value[k];
                    by_omega += dg * force.value[k] + g * force.by_omega[k];
                    let ratio = self.sizes[c] / size;
                    for l in 0..=orders {
                        let [re, im] = force.jacobian_block(k, l, omega);
                        let column = c * width + if l == 0 { 0 } else { 2 * l - 1 };
                        put(column, g * re * ratio);
                        if l > 0 {
                            put(column + 1, g * im * ratio);
                        }
                    }
                }
                put(total, by_omega * (self.span / size));
                residual[row] = left.re / size;
                jacobian[(row, row)] += 1.0;
                if k > 0 {
                    residual[row + 1] = left.im / size;
                    jacobian[(row + 1, row + 1)] += 1.0;
                }
            }
        }
        Ok(Linearisation { residual, jacobian })
    }

    /// The solution nearest to `x` for which `along · (x − x₀)` stays as it is at `x`, and how many steps it took.
    ///
    /// # Errors
    /// `NoConvergence`.
    pub fn correct(
        &mut self,
        x: &HarmonicUnknowns,
        along: &[f64],
    ) -> Result<(HarmonicUnknowns, usize), Error> {
        let total = self.len();
        let mut x = x.clone();
        let mut before = f64::INFINITY;
        for step in 1..=MAX_NEWTON {
            let Linearisation {
                residual,
                mut jacobian,
            } = self.linearise(&x)?;
            along
                .iter()
                .enumerate()
                .for_each(|(j, &t)| jacobian[(total, j)] = t);
            let mut change = residual;
            change.push(0.0);
            Lu::new(&jacobian)?.solve(&mut change);
            let size = change.iter().fold(0.0f64, |most, c| most.max(c.abs()));
            let largest = x.iter().fold(1.0f64, |most, c| most.max(c.abs()));
            if !size.is_finite() || (step > 3 && size > 10.0 * before) {
                break;
            }
            before = size;
            // A frequency of zero or below is no frequency.
            let lowest = 0.05 * x[total];
            x.iter_mut().zip(&change).for_each(|(x, c)| *x -= c);
            x[total] = x[total].max(lowest);
            if size < NEWTON_TOLERANCE * largest {
                return Ok((x, step));
            }
        }
        Err(divergence_error(self.omega(&x)))
    }

    /// The unit tangent at a solution in the sense of `along`.
    ///
    /// # Errors
    /// `Indefinite` where the curve has none.
    pub fn tangent(&mut self, x: &HarmonicUnknowns, along: &[f64]) -> Result<Vec<f64>, Error> {
        let total = self.len();
        let Linearisation { mut jacobian, .. } = self.linearise(x)?;
        along
            .iter()
            .enumerate()
            .for_each(|(j, &t)| jacobian[(total, j)] = t);
        let mut tangent = vec![0.0; total + 1];
        tangent[total] = 1.0;
        Lu::new(&jacobian)?.solve(&mut tangent);
        let size = tangent.iter().map(|t| t * t).sum::<f64>().sqrt();
        tangent.iter_mut().for_each(|t| *t /= size);
        Ok(tangent)
    }

    /// Truncation error: the largest contribution of the orders from K + 1 to 2K, relative to the largest deflection of the branch.
    ///
    /// # Errors
    /// Those of the linear part.
    pub fn truncation_error(&mut self, x: &HarmonicUnknowns) -> Result<f64, Error> {
        let (omega, delta, m) = (self.omega(x), self.deflections(x), self.sizes.len());
        let forces: Vec<_> = (0..m)
            .map(|c| {
                self.alternating
                    .forces(self.family, &self.lines.active, c, &delta[c], omega)
            })
            .collect();
        let mut sums = vec![0.0; m];
        for k in self.orders + 1..=2 * self.orders {
            let line = self.lines.order_response(k, omega)?;
            for (b, sum) in sums.iter_mut().enumerate() {
                let at = (0..m).fold(-line.drive[0][b], |z, c| {
                    z + line.compliance[0][b * m + c] * forces[c].value[k]
                });
                *sum += 2.0 * at.norm();
            }
        }
        let shares = sums.iter().zip(&self.sizes).map(|(sum, size)| sum / size);
        Ok(shares.fold(0.0, f64::max))
    }

    /// A first guess at ω: contacts closed on the flank their mean load presses.
    ///
    /// # Errors
    /// Those of the linear part.
    pub fn initial_guess(&self, omega: f64) -> Result<HarmonicUnknowns, Error> {
        let m = self.sizes.len();
        let mut delta = vec![Vec::new(); m];
        for k in 0..=self.orders {
            let line = self.lines.order_response(k, omega)?;
            for (b, lines) in delta.iter_mut().enumerate() {
                let mut value = line.drive[0][b];
                if k == 0 {
                    for c in 0..m {
                        let active = self.lines.active[c];
                        if let crate::motion::dynamic_model::ForceLaw::Contact(contact) =
                            &self.family.relative.model.elements[active.branch].law
                        {
                            let flank = line.drive[0][c].re.signum();
                            value += line.compliance[0][b * m + c]
                                * (active.stiffness * contact.half_play * flank);
                        }
                    }
                }
                lines.push(value);
            }
        }
        Ok(self.unknowns(&delta, omega))
    }

    /// Coordinates of the machine against its free turning, order by order.
    ///
    /// # Errors
    /// Those of the linear part.
    pub fn motion(&mut self, x: &HarmonicUnknowns) -> Result<Vec<Vec<Complex>>, Error> {
        let (omega, delta, m) = (self.omega(x), self.deflections(x), self.sizes.len());
        let forces: Vec<_> = (0..m)
            .map(|c| {
                self.alternating
                    .forces(self.family, &self.lines.active, c, &delta[c], omega)
            })
            .collect();
        (0..=2 * self.orders)
            .map(|k| {
                let own: Vec<Complex> = forces.iter().map(|f| f.value[k]).collect();
                Ok(self.lines.order_response(k, omega)?.motion(&own))
            })
            .collect()
    }

    /// Time–frequency transforms, for evaluations over a period.
    pub fn alternating(&mut self) -> &mut AftTransform {
        &mut self.alternating
    }
}

fn divergence_error(omega: f64) -> Error {
    let message = format!("Newton's method did not converge at {omega:.6e} rad/s");
    Error::new(Code::NoConvergence, message).with_hint("start the range at a less nonlinear speed")
}

//! Complex modes of `λ² I + λ C̃ + K̃ + i sgn(Im λ) H̃` over modal coordinates.
//!
//! First-order form over `(Ω η, η̇, d)`: the positions of rigid motions are left out, since their root is exactly zero, as
//! are the rates of those that nothing brakes. Each root is then polished by Newton's method on the quadratic (Ruhe 1973,
//! SIAM J. Numer. Anal. 10, 674, sec. 3), which gives small roots beside large ones their digits back and takes loss factors in.

use super::basis::Basis;
use super::modal::Modal;
use super::mode::{Mode, modulus, orient};
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::numeric::{Complex, ComplexMatrix, Matrix, definite, general};

/// Complex modes, sorted by |λ|: rigid ones first, then each pair once, overdamped roots singly.
///
/// # Errors
/// No convergence of the eigenvalue iteration; numbers out of range.
pub fn modes(linear: &Linear, basis: &Basis, modal: &Modal) -> Result<Vec<Mode>, Error> {
    let light = Light::new(modal)?;
    let quadratic = light.condense(modal)?;
    let state = State::new(&quadratic, basis, linear.n_undamped_rigid);
    let mut found = Vec::new();
    if !state.is_empty() {
        let eigen = general::eigen(&state.matrix(&quadratic)?)?;
        for k in 0..eigen.values.len() {
            let lambda = eigen.values[k];
            if lambda.im < 0.0 {
                continue;
            }
            let right: Vec<Complex> = (0..state.len()).map(|i| eigen.right[(i, k)]).collect();
            let start = Root {
                lambda,
                x: state.positions(&quadratic, basis, lambda, &right),
            };
            let error = f64::EPSILON * eigen.norm * eigen.condition[k];
            found.push(polish(&quadratic, start, error));
        }
    }
    found.sort_by(|a, b| modulus(a.root.lambda).total_cmp(&modulus(b.root.lambda)));
    let rigid = (0..basis.n_rigid).filter(|&j| quadratic.is_free(j));
    let rigid = rigid.map(|j| {
        let mut shape: Vec<Complex> = linear
            .recover(&super::basis::column(&basis.shapes, j))
            .iter()
            .map(|&x| Complex::new(x, 0.0))
            .collect();
        orient(&mut shape);
        let zero = Complex::new(0.0, 0.0);
        Mode {
            eigenvalue: zero,
            rigid: true,
            damping_ratio: None,
            shape,
            residual: 0.0,
            digits: f64::INFINITY,
        }
    });
    let damped = modal.is_dissipative();
    let elastic = found.iter().map(|polished| {
        let z = light.expand(&polished.root.x);
        let p: Vec<Complex> = (0..modal.shapes.nrows())
            .map(|i| {
                z.iter()
                    .enumerate()
                    .map(|(j, &x)| x * modal.shapes[(i, j)])
                    .fold(ZERO, |s, t| s + t)
            })
            .collect();
        let mut shape = recover(linear, &p);
        orient(&mut shape);
        let lambda = polished.root.lambda;
        let damping_ratio = (damped && lambda.im != 0.0).then(|| -lambda.re / modulus(lambda));
        Mode {
            eigenvalue: lambda,
            rigid: false,
            damping_ratio,
            shape,
            residual: polished.residual,
            digits: polished.digits,
        }
    });
    Ok(rigid.chain(elastic).collect())
}

const ZERO: Complex = Complex::new(0.0, 0.0);

fn recover(linear: &Linear, p: &[Complex]) -> Vec<Complex> {
    linear
        .transform
        .iter()
        .map(|row| row.iter().map(|&(j, a)| p[j] * a).fold(ZERO, |s, t| s + t))
        .collect()
}

/// The massless coordinates in a basis of those a damper brakes (y) and those that follow statically (z).
struct Light {
    n_modes: usize,
    /// Columns over d: y first, then z.
    turn: Matrix,
    n_braked: usize,
    /// `z = follow · (η, y)`.
    follow: Matrix,
}

/// `λ² I_η + λ C + K + i sgn H` over (η, y).
struct Quadratic {
    n_modes: usize,
    damping: Matrix,
    stiffness: Matrix,
    hysteretic: Option<Matrix>,
}

impl Light {
    fn new(modal: &Modal) -> Result<Light, Error> {
        let (m, l) = (modal.n_modes, modal.n_light);
        let block = Matrix::from_fn(l, l, |i, j| {
            (modal.damping[(m + i, m + j)] + modal.damping[(m + j, m + i)]) / 2.0
        });
        let eigen = definite::symmetric(&block)?;
        let largest = eigen.values.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        // Relative to the largest damper on a massless coordinate: below this is rounding of the rank-one sums.
        let braked: Vec<bool> = eigen
            .values
            .iter()
            .map(|&v| v.abs() > 1e-13 * largest)
            .collect();
        let order: Vec<usize> = (0..l)
            .filter(|&k| braked[k])
            .chain((0..l).filter(|&k| !braked[k]))
            .collect();
        let turn = Matrix::from_fn(l, l, |i, k| eigen.vectors[(i, order[k])]);
        let n_braked = braked.iter().filter(|&&b| b).count();
        Ok(Light {
            n_modes: m,
            turn,
            n_braked,
            follow: Matrix::zeros(l - n_braked, m + n_braked),
        })
    }

    fn condense(&self, modal: &Modal) -> Result<Quadratic, Error> {
        let (m, l) = (modal.n_modes, modal.n_light);
        let keep = m + self.n_braked;
        let turned = |a: &Matrix| -> Matrix {
            let full = Matrix::from_fn(m + l, m + l, |i, j| match (i < m, j < m) {
                (true, true) => f64::from(u8::from(i == j)),
                (false, false) => self.turn[(i - m, j - m)],
                _ => 0.0,
            });
            if l == 0 {
                a.clone()
            } else {
                full.transpose() * a * &full
            }
        };
        let (damping, stiffness) = (turned(&modal.damping), turned(&modal.stiffness));
        let cut = |a: &Matrix| Matrix::from_fn(keep, keep, |i, j| a[(i, j)]);
        let mut quadratic = Quadratic {
            n_modes: m,
            damping: cut(&damping),
            stiffness: cut(&stiffness),
            hysteretic: modal.hysteretic.as_ref().map(|h| cut(&turned(h))),
        };
        if keep < m + l {
            let follow = self.follow_of(&stiffness, keep, m + l)?;
            let up = Matrix::from_fn(keep, m + l - keep, |i, j| stiffness[(i, keep + j)]);
            quadratic.stiffness = &quadratic.stiffness + &up * &follow;
        }
        Ok(quadratic)
    }

    fn follow_of(&self, stiffness: &Matrix, keep: usize, all: usize) -> Result<Matrix, Error> {
        let corner = Matrix::from_fn(all - keep, all - keep, |i, j| {
            stiffness[(keep + i, keep + j)]
        });
        let side = Matrix::from_fn(all - keep, keep, |i, j| -stiffness[(keep + i, j)]);
        definite::solve(&corner, &side)
    }

    /// (η, d) from (η, y); what follows statically beyond the undamped shapes is nil where the strain energy is a sum of squares.
    fn expand(&self, x: &[Complex]) -> Vec<Complex> {
        let m = self.n_modes;
        let mut z: Vec<Complex> = x[..m].to_vec();
        for i in 0..self.turn.nrows() {
            let braked = (0..self.n_braked).map(|k| x[m + k] * self.turn[(i, k)]);
            let follows = (0..self.follow.nrows()).map(|k| {
                let value = (0..x.len())
                    .map(|j| x[j] * self.follow[(k, j)])
                    .fold(ZERO, |s, t| s + t);
                value * self.turn[(i, self.n_braked + k)]
            });
            z.push(braked.chain(follows).fold(ZERO, |s, t| s + t));
        }
        z
    }
}

impl Quadratic {
    fn len(&self) -> usize {
        self.damping.nrows()
    }

    /// A mode that no stiffness holds, so that zero is its root.
    fn is_free(&self, j: usize) -> bool {
        (0..self.len()).all(|i| self.stiffness[(i, j)] == 0.0 && self.stiffness[(j, i)] == 0.0)
    }

    /// `λ² I_η + λ C + K + i sgn(Im λ) H`.
    fn at(&self, lambda: Complex) -> ComplexMatrix {
        let sign = if lambda.im == 0.0 {
            0.0
        } else {
            lambda.im.signum()
        };
        ComplexMatrix::from_fn(self.len(), self.len(), |i, j| {
            let mut value = lambda * self.damping[(i, j)] + self.stiffness[(i, j)];
            if let Some(h) = &self.hysteretic {
                value += Complex::new(0.0, sign * h[(i, j)]);
            }
            if i == j && i < self.n_modes {
                value += lambda * lambda;
            }
            value
        })
    }

    /// `(2λ I_η + C) x`.
    fn slope(&self, lambda: Complex, x: &[Complex]) -> Vec<Complex> {
        (0..self.len())
            .map(|i| {
                let damped = (0..self.len())
                    .map(|j| x[j] * self.damping[(i, j)])
                    .fold(ZERO, |s, t| s + t);
                if i < self.n_modes {
                    damped + lambda * x[i] * 2.0
                } else {
                    damped
                }
            })
            .collect()
    }
}

/// Which components the first-order form has: positions of some modes, rates of some, and y.
struct State {
    positions: Vec<usize>,
    rates: Vec<usize>,
    scale: Vec<f64>,
    n_braked: usize,
    n_modes: usize,
}

impl State {
    fn new(quadratic: &Quadratic, basis: &Basis, n_undamped_rigid: usize) -> State {
        let m = quadratic.n_modes;
        let positions: Vec<usize> = (0..m).filter(|&j| !quadratic.is_free(j)).collect();
        let alone = |j: usize| {
            j < n_undamped_rigid
                && quadratic.is_free(j)
                && (0..quadratic.len())
                    .all(|i| quadratic.damping[(i, j)] == 0.0 && quadratic.damping[(j, i)] == 0.0)
        };
        let rates = (0..m).filter(|&j| !alone(j)).collect();
        let scale = positions
            .iter()
            .map(|&j| {
                if basis.omega[j] > 0.0 {
                    basis.omega[j]
                } else {
                    1.0
                }
            })
            .collect();
        State {
            positions,
            rates,
            scale,
            n_braked: quadratic.len() - m,
            n_modes: m,
        }
    }

    fn len(&self) -> usize {
        self.positions.len() + self.rates.len() + self.n_braked
    }

    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state matrix over `(s η, η̇, y)`, s the scale of each position.
    fn matrix(&self, quadratic: &Quadratic) -> Result<Matrix, Error> {
        let (np, nr, ny, m) = (
            self.positions.len(),
            self.rates.len(),
            self.n_braked,
            self.n_modes,
        );
        let (c, k) = (&quadratic.damping, &quadratic.stiffness);
        let n = self.len();
        let mut a = Matrix::zeros(n, n);
        for (p, &j) in self.positions.iter().enumerate() {
            if let Some(r) = self.rates.iter().position(|&i| i == j) {
                a[(p, np + r)] = self.scale[p];
            }
        }
        // Force rows of every mode and of y, over the state: −K(position, y) − C(rate).
        let row = |i: usize| -> Vec<f64> {
            let mut row = vec![0.0; n];
            self.positions
                .iter()
                .enumerate()
                .for_each(|(p, &j)| row[p] = -k[(i, j)] / self.scale[p]);
            self.rates
                .iter()
                .enumerate()
                .for_each(|(r, &j)| row[np + r] = -c[(i, j)]);
            (0..ny).for_each(|y| row[np + nr + y] = -k[(i, m + y)]);
            row
        };
        if ny > 0 {
            let corner = Matrix::from_fn(ny, ny, |i, j| c[(m + i, m + j)]);
            let rows: Vec<Vec<f64>> = (0..ny).map(|y| row(m + y)).collect();
            let right = Matrix::from_fn(ny, n, |y, s| rows[y][s]);
            let rate = definite::solve(&corner, &right)?;
            (0..ny).for_each(|y| (0..n).for_each(|s| a[(np + nr + y, s)] = rate[(y, s)]));
        }
        for (r, &i) in self.rates.iter().enumerate() {
            let force = row(i);
            for s in 0..n {
                let braked: f64 = (0..ny).map(|y| c[(i, m + y)] * a[(np + nr + y, s)]).sum();
                a[(np + r, s)] = force[s] - braked;
            }
        }
        Ok(a)
    }

    /// (η, y) from an eigenvector of the state matrix.
    fn positions(
        &self,
        quadratic: &Quadratic,
        _basis: &Basis,
        lambda: Complex,
        v: &[Complex],
    ) -> Vec<Complex> {
        let (np, nr) = (self.positions.len(), self.rates.len());
        let mut x = vec![ZERO; quadratic.len()];
        for (r, &j) in self.rates.iter().enumerate() {
            // Where the root is far from zero the rate says the position too; else the stored position does.
            if modulus(lambda) > 0.0 {
                x[j] = v[np + r] / lambda;
            }
        }
        for (p, &j) in self.positions.iter().enumerate() {
            x[j] = v[p] / self.scale[p];
        }
        (0..self.n_braked).for_each(|y| x[self.n_modes + y] = v[np + nr + y]);
        x
    }
}

struct Root {
    lambda: Complex,
    x: Vec<Complex>,
}

struct Polished {
    root: Root,
    residual: f64,
    digits: f64,
}

/// Relative error that the modal matrices and the last Newton step leave in every entry: worst of tests/digits_trusted.rs, 8e-15
/// where the condition is some 7, and a margin.
const PER_ENTRY: f64 = 8.0 * f64::EPSILON;

/// Largest order for which every root is polished: a step is a complex LU of that order.
const POLISH: usize = 160;

/// Newton's method on `(Q(λ) x, eᵀx − 1)`; keeps the start where it does not lower the residual.
fn polish(quadratic: &Quadratic, start: Root, error: f64) -> Polished {
    let size = modulus(start.lambda);
    let mut best_residual = backward_error(quadratic, &start);
    let mut best = start;
    let mut polished = false;
    if quadratic.len() <= POLISH {
        for _ in 0..4 {
            let Some(next) = newton(quadratic, &best) else {
                break;
            };
            let near = modulus(next.lambda - best.lambda)
                <= 1e3 * error + 0.5 * hysteretic_size(quadratic, size);
            let residual = backward_error(quadratic, &next);
            if !near || !residual.is_finite() || residual >= best_residual {
                polished |= near && residual <= 4.0 * best_residual;
                break;
            }
            (best, best_residual, polished) = (next, residual, true);
        }
    }
    normalise(quadratic, &mut best);
    let lost = if polished {
        PER_ENTRY * componentwise_condition(quadratic, &best)
    } else {
        error / modulus(best.lambda)
    };
    let digits = (-lost.log10()).clamp(0.0, 15.0);
    Polished {
        root: best,
        residual: best_residual,
        digits: if lost.is_nan() { 0.0 } else { digits },
    }
}

fn hysteretic_size(quadratic: &Quadratic, size: f64) -> f64 {
    if quadratic.hysteretic.is_some() {
        size
    } else {
        0.0
    }
}

fn newton(quadratic: &Quadratic, root: &Root) -> Option<Root> {
    let n = quadratic.len();
    let lead = (0..n).max_by(|&a, &b| modulus(root.x[a]).total_cmp(&modulus(root.x[b])))?;
    let slope = quadratic.slope(root.lambda, &root.x);
    // y = Q⁻¹ Q′ x; then λ ← λ − x_lead / y_lead and x ← y.
    let right = ComplexMatrix::from_fn(n, 1, |i, _| slope[i]);
    let y = definite::solve_complex(&quadratic.at(root.lambda), &right).ok()?;
    // Beside an exact root y is huge, and its square out of range in a quotient.
    let scale = 1.0 / modulus(y[(lead, 0)]);
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let lead_y = y[(lead, 0)] * scale;
    let lambda = root.lambda - root.x[lead] * scale / lead_y;
    let lambda = if root.lambda.im == 0.0 {
        Complex::new(lambda.re, 0.0)
    } else {
        lambda
    };
    let x: Vec<Complex> = (0..n).map(|i| y[(i, 0)] * scale / lead_y).collect();
    let is_finite = |z: &Complex| z.re.is_finite() && z.im.is_finite();
    (is_finite(&lambda) && x.iter().all(is_finite)).then_some(Root { lambda, x })
}

/// `‖Q(λ) x‖∞ / ‖|Q|(|λ|) |x|‖∞`.
fn backward_error(quadratic: &Quadratic, root: &Root) -> f64 {
    let q = quadratic.at(root.lambda);
    let size = modulus(root.lambda);
    let (mut worst, mut scale) = (0.0f64, 0.0f64);
    for i in 0..quadratic.len() {
        let (mut sum, mut bound) = (ZERO, 0.0);
        for j in 0..quadratic.len() {
            sum += q[(i, j)] * root.x[j];
            let mut entry =
                size * quadratic.damping[(i, j)].abs() + quadratic.stiffness[(i, j)].abs();
            if i == j && i < quadratic.n_modes {
                entry += size * size;
            }
            bound += entry * modulus(root.x[j]);
        }
        worst = worst.max(modulus(sum));
        scale = scale.max(bound);
    }
    if scale > 0.0 { worst / scale } else { 0.0 }
}

/// Relative change of λ per relative change of every entry: `|yᵀ| |Q| |x| / (|λ| |yᵀ Q′ x|)`, y the left vector.
fn componentwise_condition(quadratic: &Quadratic, root: &Root) -> f64 {
    let n = quadratic.len();
    let Some(y) = left_vector(quadratic, root) else {
        return f64::INFINITY;
    };
    let slope = quadratic.slope(root.lambda, &root.x);
    let size = modulus(root.lambda);
    let bottom = modulus((0..n).map(|i| y[i] * slope[i]).fold(ZERO, |s, t| s + t));
    let mut top = 0.0;
    for i in 0..n {
        for j in 0..n {
            let mut entry =
                size * quadratic.damping[(i, j)].abs() + quadratic.stiffness[(i, j)].abs();
            if i == j && i < quadratic.n_modes {
                entry += size * size;
            }
            top += modulus(y[i]) * entry * modulus(root.x[j]);
        }
    }
    top / (size * bottom)
}

/// y of `yᵀ Q(λ) = 0`: one step of inverse iteration on the transpose, beside λ so that it can be solved.
///
/// `Q⁻ᵀ ≈ y xᵀ / …`, so the step starts from the conjugate of x: `xᵀ x` of a whirling shape is nil.
fn left_vector(quadratic: &Quadratic, root: &Root) -> Option<Vec<Complex>> {
    let n = quadratic.len();
    let right = ComplexMatrix::from_fn(n, 1, |i, _| root.x[i].conj());
    let mut beside = 16.0 * f64::EPSILON;
    while beside < 1e-9 {
        let q = quadratic.at(root.lambda * (1.0 + beside));
        let transposed = ComplexMatrix::from_fn(n, n, |i, j| q[(j, i)]);
        let y = definite::solve_complex(&transposed, &right).ok();
        let y = y.map(|y| (0..n).map(|i| y[(i, 0)]).collect::<Vec<_>>());
        if let Some(y) = y.filter(|y| y.iter().all(|z| z.re.is_finite() && z.im.is_finite())) {
            return Some(y);
        }
        beside *= 64.0;
    }
    None
}

/// `xᵀ (2λ I_η + C) x = 1`; where that product vanishes (defective, or with gyroscopic terms) `xᴴx = 1`.
fn normalise(quadratic: &Quadratic, root: &mut Root) {
    let slope = quadratic.slope(root.lambda, &root.x);
    let product = root
        .x
        .iter()
        .zip(&slope)
        .map(|(x, s)| x * s)
        .fold(ZERO, |s, t| s + t);
    let size: f64 = root
        .x
        .iter()
        .zip(&slope)
        .map(|(x, s)| modulus(*x) * modulus(*s))
        .sum();
    let factor = if modulus(product) > 1e-8 * size {
        product.sqrt()
    } else {
        Complex::new(
            root.x
                .iter()
                .map(|x| modulus(*x).powi(2))
                .sum::<f64>()
                .sqrt(),
            0.0,
        )
    };
    if modulus(factor) > 0.0 {
        root.x.iter_mut().for_each(|x| *x /= factor);
    }
}

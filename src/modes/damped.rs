//! Complex modes of `λ² I + λ C̃ + K̃ + i sgn(Im λ) H̃` over modal coordinates.
//!
//! First-order form over `(Ω η, η̇, d)`: the positions of rigid motions are left out, since their root is exactly zero, as
//! are the rates of those that nothing brakes. Each root is then polished on the quadratic itself, which gives small roots beside
//! large ones their digits back and takes loss factors in.

use super::basis::Basis;
use super::gyroscopic::{self, Swing};
use super::modal::Modal;
use super::mode::{Mode, modulus, orient};
use crate::base::error::Error;
use crate::machine::linear::Linear;
use crate::numeric::quadratic::Quadratic;
use crate::numeric::{Complex, Matrix, definite, general};

/// Complex modes, sorted by |λ|: rigid ones first, then each pair once, overdamped roots singly.
///
/// # Errors
/// No convergence of the eigenvalue iteration; numbers out of range.
pub fn modes(linear: &Linear, basis: &Basis, modal: &Modal) -> Result<Vec<Mode>, Error> {
    let light = Light::new(modal)?;
    let quadratic = light.condense(modal)?;
    let state = State::new(&quadratic, basis, linear.n_undamped_rigid);
    let symmetric = linear
        .branches
        .iter()
        .all(|b| b.force.is_none() || b.stiffness == 0.0);
    let lossless = symmetric && !modal.is_dissipative() && state.n_braked == 0;
    let swings = match lossless {
        true => gyroscopic::swings(
            &quadratic.damping,
            &quadratic.stiffness,
            &state.positions,
            &state.rates,
        )?,
        false => None,
    };
    let mut found = match swings {
        Some((swings, error)) => on_the_axis(&quadratic, swings, error),
        None => in_the_plane(&quadratic, &state, basis)?,
    };
    found.sort_by(|a, b| modulus(a.value).total_cmp(&modulus(b.value)));
    let rigid = (0..basis.n_rigid).filter(|&j| is_free(&quadratic, j));
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
        let z = light.expand(&polished.x);
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
        let lambda = polished.value;
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

/// Roots without losses: Newton only where the small ones want digits back, and never off the imaginary axis.
fn on_the_axis(quadratic: &Quadratic, swings: Vec<Swing>, error: f64) -> Vec<Polished> {
    let omega: Vec<Complex> = swings
        .iter()
        .map(|swing| Complex::new(0.0, swing.omega))
        .collect();
    let swings = swings.into_iter().enumerate().map(|(k, swing)| {
        let wants = alone(k, &omega) && error > ENOUGH * swing.omega;
        let start = Start {
            value: omega[k],
            vector: swing.shape,
            error,
        };
        polish(quadratic, start, wants, Root::OnAxis)
    });
    swings.collect()
}

/// Roots of the first-order form.
fn in_the_plane(
    quadratic: &Quadratic,
    state: &State,
    basis: &Basis,
) -> Result<Vec<Polished>, Error> {
    let mut found = Vec::new();
    if state.is_empty() {
        return Ok(found);
    }
    let eigen = general::eigen(&state.matrix(quadratic)?)?;
    for k in (0..eigen.values.len()).filter(|&k| eigen.values[k].im >= 0.0) {
        let value = eigen.values[k];
        let right: Vec<Complex> = (0..state.len()).map(|i| eigen.right[(i, k)]).collect();
        let vector = state.positions(quadratic, basis, value, &right);
        let error = f64::EPSILON * eigen.norm * eigen.condition[k];
        let wants = alone(k, &eigen.values) || quadratic.hysteretic.is_some();
        found.push(polish(
            quadratic,
            Start {
                value,
                vector,
                error,
            },
            wants,
            Root::Anywhere,
        ));
    }
    Ok(found)
}

/// Relative error of a root that needs no polishing.
const ENOUGH: f64 = 1e-13;

/// No other root is so near that polishing would mix their shapes.
fn alone(k: usize, roots: &[Complex]) -> bool {
    const REPEATED: f64 = 1e-8; // relative: √ε, where the shapes of a pair keep half their digits
    roots
        .iter()
        .enumerate()
        .all(|(i, &root)| i == k || modulus(root - roots[k]) > REPEATED * modulus(roots[k]))
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
            inertial: m,
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

/// A mode that no stiffness holds, so that zero is its root.
fn is_free(quadratic: &Quadratic, j: usize) -> bool {
    let k = &quadratic.stiffness;
    (0..quadratic.len()).all(|i| k[(i, j)] == 0.0 && k[(j, i)] == 0.0)
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
        let m = quadratic.inertial;
        let positions: Vec<usize> = (0..m).filter(|&j| !is_free(quadratic, j)).collect();
        let alone = |j: usize| {
            j < n_undamped_rigid
                && is_free(quadratic, j)
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

struct Polished {
    value: Complex,
    x: Vec<Complex>,
    residual: f64,
    digits: f64,
}

/// A root as the first solution left it, with its absolute error.
struct Start {
    value: Complex,
    vector: Vec<Complex>,
    error: f64,
}

/// What is known of a root.
#[derive(Clone, Copy, PartialEq)]
enum Root {
    /// Nothing.
    Anywhere,
    /// It is imaginary: nothing loses energy.
    OnAxis,
}

/// Largest order for which every root is polished: a step is a complex LU of that order.
const POLISH: usize = 160;

/// What a polished root keeps, with a margin: ε times its condition times this.
const MARGIN: f64 = 10.0;

/// Polishes a root where that is wanted; keeps the start where polishing leads elsewhere.
fn polish(quadratic: &Quadratic, start: Start, wanted: bool, known: Root) -> Polished {
    // A loss factor is not in the first-order form, so polishing must bring it in and moves farther.
    let reach = match quadratic.hysteretic.is_some() {
        true => 0.5 * modulus(start.value),
        false => 1e3 * start.error,
    };
    let tries = wanted && quadratic.len() <= POLISH;
    let polished = tries
        .then(|| quadratic.polish(start.value, &start.vector).ok())
        .flatten();
    let near = polished.filter(|root| modulus(root.value - start.value) <= reach);
    let (mut value, mut x, residual, lost) = match near {
        Some(root) => {
            let lost = MARGIN * f64::EPSILON * quadratic.condition(&root);
            (root.value, root.right, root.residual, lost)
        }
        None => {
            let residual = quadratic.residual(start.value, &start.vector);
            (
                start.value,
                start.vector,
                residual,
                MARGIN * start.error / modulus(start.value),
            )
        }
    };
    if known == Root::OnAxis {
        value = Complex::new(0.0, value.im);
    }
    normalise(quadratic, value, &mut x);
    let digits = if lost.is_nan() {
        0.0
    } else {
        (-lost.log10()).clamp(0.0, 15.0)
    };
    Polished {
        value,
        x,
        residual,
        digits,
    }
}

/// `xᵀ (2λ I_η + C) x = 1`; where that product vanishes (defective, or with gyroscopic terms) `xᴴx = 1`.
fn normalise(quadratic: &Quadratic, value: Complex, x: &mut [Complex]) {
    let slope = quadratic.slope(value, x, false);
    let product = x
        .iter()
        .zip(&slope)
        .map(|(x, s)| x * s)
        .fold(ZERO, |s, t| s + t);
    let size: f64 = x
        .iter()
        .zip(&slope)
        .map(|(x, s)| modulus(*x) * modulus(*s))
        .sum();
    let factor = if modulus(product) > 1e-8 * size {
        product.sqrt()
    } else {
        Complex::new(
            x.iter().map(|x| modulus(*x).powi(2)).sum::<f64>().sqrt(),
            0.0,
        )
    };
    if modulus(factor) > 0.0 {
        x.iter_mut().for_each(|x| *x /= factor);
    }
}

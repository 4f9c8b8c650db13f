//! Fewer lines that say the same of smooth functions. Over a block of lines away from the poles every function of a fit is nearly a
//! polynomial; the Gauss rule of the block's own weights, `Σ_k f_k² g(x_k) = Σ_m λ_m g(ξ_m)` for polynomials g of degree below 2d
//! (Golub and Welsch 1969), then stands for all of its lines: nodes ξ_m with factors √λ_m, and the data projected on the polynomials
//! of degree below d. The projection is orthogonal, so that noise of unit variance stays so. Where a pole is near, lines are kept.

use std::borrow::{Borrow, Cow};

use crate::numeric::definite::symmetric;
use crate::numeric::{Complex, Matrix, registers};

use super::basis::{Pole, Problem};
use super::projection::{Model, sum_of_squares};
use super::scan::Peak;

/// Nodes of a block, d.
const NODES: usize = 16;

/// A block of fewer lines is kept as it is.
const FEWEST: usize = 24;

/// The functions of a fit differ from polynomials by less than this, in units of the noise, over all lines together. No parameter moves by
/// more than this share of its standard deviation.
const MISMATCH: f64 = 1e-3;

/// Where the mismatch would have to be a smaller share of the data, all lines are kept: rounding is not far.
const LEAST_SHARE: f64 = 1e-13;

/// A problem of fewer lines.
#[derive(Debug, Clone)]
pub(super) struct Condensed<'a> {
    /// With as many responses, over the nodes.
    pub problem: Cow<'a, Problem>,
    /// Middle and half-width of what was condensed.
    blocks: Vec<(f64, f64)>,
    /// Least sum of half-axes of the ellipse around a block with a pole on it.
    clear: f64,
}

impl Borrow<Problem> for Condensed<'_> {
    fn borrow(&self) -> &Problem {
        &self.problem
    }
}

impl<'a> Condensed<'a> {
    /// All lines of a problem.
    pub fn whole(problem: &'a Problem) -> Condensed<'a> {
        Condensed {
            problem: Cow::Borrowed(problem),
            blocks: Vec::new(),
            clear: 0.0,
        }
    }

    /// All lines were kept.
    pub fn is_whole(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Whether it still holds all there is to poles that have moved.
    pub fn serves(&self, poles: &[Pole]) -> bool {
        let mut blocks = self.blocks.iter();
        blocks.all(|&(middle, half)| is_clear(middle, half, poles, self.clear))
    }
}

/// Half-widths down to this share of a pole's, and of a candidate's, are provided for.
const NARROWER: (f64, f64) = (0.7, 0.35);

/// The lines needed for the poles of a model and for candidates. All of them where there is a delay, which turns the data line by line.
pub(super) fn condensed<'a>(
    problem: &'a Problem,
    model: &Model,
    candidates: &[Peak],
) -> Condensed<'a> {
    if !model.delays.is_empty() {
        return Condensed::whole(problem);
    }
    let narrow = |p: &Pole, share: f64| Pole {
        sigma: share * p.sigma,
        ..*p
    };
    let poles: Vec<Pole> = (model.poles.iter().map(|p| narrow(p, NARROWER.0)))
        .chain(candidates.iter().map(|c| narrow(&c.pole, NARROWER.1)))
        .collect();
    let total = sum_of_squares(&problem.y);
    let share = MISMATCH / total.sqrt();
    if !(share > LEAST_SHARE) {
        return Condensed::whole(problem);
    }
    let clear = share.min(0.1).powf(-1.0 / NODES as f64);
    let mut parts = Vec::new();
    split(&problem.x, 0, problem.lines(), &poles, clear, &mut parts);
    if parts.iter().all(|part| !part.smooth) {
        return Condensed::whole(problem);
    }
    let mut rules = Vec::new();
    for part in parts {
        let rule = part.smooth.then(|| rule(problem, &part)).flatten();
        rules.push((part, rule));
    }
    let n = rules
        .iter()
        .map(|(part, rule)| rule.as_ref().map_or(part.to - part.from, |_| NODES))
        .sum();
    let mut fewer = Problem {
        x: Vec::with_capacity(n),
        factor: Vec::with_capacity(n),
        fixed: Matrix::zeros(2 * n, problem.fixed.ncols()),
        y: Matrix::zeros(2 * n, problem.y.ncols()),
        first: problem.first,
        step: problem.step,
        left_out: 0.0,
    };
    let mut blocks = Vec::new();
    for (part, rule) in &rules {
        let at = fewer.x.len();
        match rule {
            None => {
                fewer.x.extend(&problem.x[part.from..part.to]);
                fewer.factor.extend(&problem.factor[part.from..part.to]);
                copy(&problem.y, part, &mut fewer.y, at);
                copy(&problem.fixed, part, &mut fewer.fixed, at);
            }
            Some(rule) => {
                blocks.push(middle_and_half(&problem.x, part.from, part.to));
                fewer.x.extend(&rule.x);
                fewer.factor.extend(&rule.factor);
                project(&problem.y, part, &rule.onto, &mut fewer.y, at);
                project(&problem.fixed, part, &rule.onto, &mut fewer.fixed, at);
            }
        }
    }
    registers::clear();
    fewer.left_out = problem.left_out + total - sum_of_squares(&fewer.y);
    Condensed {
        problem: Cow::Owned(fewer),
        blocks,
        clear,
    }
}

/// Lines in a row, to be kept or condensed.
struct Part {
    from: usize,
    to: usize,
    smooth: bool,
}

fn split(
    x: &[f64],
    from: usize,
    to: usize,
    poles: &[Pole],
    clear: f64,
    parts: &mut Vec<Part>,
) {
    if to - from <= FEWEST {
        match parts.last_mut() {
            Some(last) if !last.smooth => last.to = to,
            _ => parts.push(Part {
                from,
                to,
                smooth: false,
            }),
        }
        return;
    }
    let (middle, half) = middle_and_half(x, from, to);
    if is_clear(middle, half, poles, clear) {
        parts.push(Part {
            from,
            to,
            smooth: true,
        });
        return;
    }
    let between = from + (to - from) / 2;
    split(x, from, between, poles, clear, parts);
    split(x, between, to, poles, clear, parts);
}

fn middle_and_half(x: &[f64], from: usize, to: usize) -> (f64, f64) {
    let (first, last) = (x[from], x[to - 1]);
    (0.5 * (first + last), 0.5 * (last - first))
}

/// Whether the ellipses around a block through the poles, and through zero where the residual term below is singular, all have
/// half-axes of at least `clear` together: polynomials of degree d then miss a pole's function by about `clear^−d`.
fn is_clear(middle: f64, half: f64, poles: &[Pole], clear: f64) -> bool {
    let axes = |w: f64, sigma: f64| {
        let (x, y) = ((w - middle) / half, sigma / half);
        let sum = 0.5 * ((x - 1.0).hypot(y) + (x + 1.0).hypot(y));
        sum + (sum * sum - 1.0).max(0.0).sqrt()
    };
    axes(0.0, 0.0) > clear && poles.iter().all(|p| axes(p.w, p.sigma) > clear)
}

/// The Gauss rule of a block.
struct Rule {
    x: Vec<f64>,
    factor: Vec<Complex>,
    /// Orthonormal columns, one per node: from values on lines to values at nodes.
    onto: Matrix,
}

/// By Lanczos's method on the lines' places, begun with the factors (Golub and Welsch 1969); `None` where weights vanish on most lines.
fn rule(problem: &Problem, part: &Part) -> Option<Rule> {
    let lines = part.to - part.from;
    let (middle, half) = middle_and_half(&problem.x, part.from, part.to);
    let place: Vec<f64> = problem.x[part.from..part.to]
        .iter()
        .map(|x| (x - middle) / half)
        .collect();
    let factors = &problem.factor[part.from..part.to];
    let total = factors.iter().map(|f| f.norm_sqr()).sum::<f64>().sqrt();
    let phase = factors[0] / factors[0].norm();
    let mut basis = Matrix::zeros(lines, NODES);
    let mut jacobi = Matrix::zeros(NODES, NODES);
    let mut next: Vec<f64> = factors
        .iter()
        .map(|f| f.norm_sqr().sqrt() / total)
        .collect();
    for j in 0..NODES {
        basis.col_as_slice_mut(j).copy_from_slice(&next);
        for k in 0..lines {
            next[k] *= place[k];
        }
        let own = dot(basis.col_as_slice(j), &next);
        jacobi[(j, j)] = own;
        // twice: lines that are few or far from even would lose orthogonality
        for _ in 0..2 {
            for i in (0..=j).rev() {
                let column = basis.col_as_slice(i);
                let share = dot(column, &next);
                next.iter_mut()
                    .zip(column)
                    .for_each(|(n, c)| *n -= share * c);
            }
        }
        let norm = dot(&next, &next).sqrt();
        if !(norm > 1e-8) {
            return None;
        }
        if j + 1 < NODES {
            jacobi[(j, j + 1)] = norm;
            jacobi[(j + 1, j)] = norm;
        }
        next.iter_mut().for_each(|n| *n /= norm);
    }
    let nodes = symmetric(&jacobi).ok()?;
    Some(Rule {
        x: nodes.values.iter().map(|t| middle + half * t).collect(),
        factor: (0..NODES)
            .map(|m| phase * (total * nodes.vectors[(0, m)]))
            .collect(),
        onto: &basis * &nodes.vectors,
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Rows of lines that are kept.
fn copy(all: &Matrix, part: &Part, fewer: &mut Matrix, at: usize) {
    let (n, m) = (all.nrows() / 2, fewer.nrows() / 2);
    let count = part.to - part.from;
    for j in 0..all.ncols() {
        for (from, to) in [(part.from, at), (n + part.from, m + at)] {
            let values = &all.col_as_slice(j)[from..from + count];
            fewer.col_as_slice_mut(j)[to..to + count].copy_from_slice(values);
        }
    }
}

/// Rows of nodes.
fn project(all: &Matrix, part: &Part, onto: &Matrix, fewer: &mut Matrix, at: usize) {
    let (n, m) = (all.nrows() / 2, fewer.nrows() / 2);
    for (from, to) in [(part.from, at), (n + part.from, m + at)] {
        let rows = all.subrows(from, part.to - part.from);
        let values = onto.transpose() * rows;
        fewer.subrows_mut(to, NODES).copy_from(values);
    }
}

//! Data compression: blocks of lines away from poles are replaced by Gauss quadrature nodes.
//!
//! On a block of lines away from the poles every function of a fit is nearly a polynomial. The Gauss rule of the weights of the block,
//! `Σ_k f_k² g(x_k) = Σ_m λ_m g(ξ_m)` for polynomials g of degree below 2d (Golub and Welsch 1969), then replaces its lines by nodes ξ_m
//! with factors √λ_m, and the data by their projection on the polynomials of degree below d. The projection is orthogonal, so that
//! noise keeps its unit variance. Lines close to a pole are not compressed.

use std::borrow::{Borrow, Cow};
use std::collections::HashMap;

use crate::numeric::symmetric::symmetric_eigen;
use crate::numeric::thin_qr::{thin_qr, transposed_product};
use crate::numeric::{Complex, Matrix, registers};

use super::basis::{ScaledPole, WhitenedProblem};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, sum_of_squares};
use super::scan::ScanPeak;

/// Number of nodes of a block, d.
const NODES: usize = 16;

/// Minimum number of lines of a compressed block.
const MIN_BLOCK_LINES: usize = 40;

/// Tolerance of the polynomial approximation in noise standard deviations; parameters shift by a smaller share of their deviation.
const MISMATCH: f64 = 1e-3;

/// Minimum tolerance relative to the data norm: a smaller one is close to rounding, and no line is compressed.
const MIN_MISMATCH_SHARE: f64 = 1e-13;

/// Minimum norm of the part of a weighted polynomial that is independent of those of lower degree.
const INDEPENDENCE_TOLERANCE: f64 = 1e-8;

/// Least-squares problem on compressed lines.
#[derive(Debug, Clone)]
pub(super) struct CompressedProblem<'a> {
    /// Problem with all responses on the retained lines and the nodes.
    pub problem: Cow<'a, WhitenedProblem>,
    /// Middle and half-width of the compressed blocks, in units of the highest line.
    blocks: Vec<(f64, f64)>,
    /// Minimum sum of the half-axes of the ellipse around a block through a pole, in half-widths of the block.
    min_clearance: f64,
}

impl Borrow<WhitenedProblem> for CompressedProblem<'_> {
    fn borrow(&self) -> &WhitenedProblem {
        &self.problem
    }
}

impl<'a> CompressedProblem<'a> {
    /// Problem without compression.
    pub fn uncompressed(problem: &'a WhitenedProblem) -> CompressedProblem<'a> {
        CompressedProblem {
            problem: Cow::Borrowed(problem),
            blocks: Vec::new(),
            min_clearance: 0.0,
        }
    }

    /// True if no line was compressed.
    pub fn is_uncompressed(&self) -> bool {
        self.blocks.is_empty()
    }

    /// True if the compression is accurate for the given poles.
    pub fn is_valid_for(&self, poles: &[ScaledPole]) -> bool {
        let mut blocks = self.blocks.iter();
        blocks.all(|&(middle, half)| is_clear(middle, half, poles, self.min_clearance))
    }
}

/// Shares to which the half-width of a pole, and of a candidate, may decrease before a new compression is needed.
const WIDTH_MARGIN: (f64, f64) = (0.7, 0.35);

/// Maximum number of compressions in a refinement; the poles move little.
pub(super) const MAX_RECOMPRESSIONS: usize = 4;

/// Repeated compression of a problem for moving poles.
#[derive(Debug)]
pub(super) struct Compressor<'a> {
    problem: &'a WhitenedProblem,
    /// `Σ y²`.
    total: f64,
    /// Blocks by first and end line; `None` if the block has no Gauss rule.
    cached_blocks: HashMap<(usize, usize), Option<CompressedBlock>>,
    /// Gauss rules of equally spaced lines of equal weight, by number of lines.
    cached_rules: HashMap<usize, Option<GaussRule>>,
}

impl<'a> Compressor<'a> {
    /// Creates a compressor of a problem.
    pub fn new(problem: &'a WhitenedProblem) -> Compressor<'a> {
        Compressor {
            problem,
            total: sum_of_squares(&problem.y),
            cached_blocks: HashMap::new(),
            cached_rules: HashMap::new(),
        }
    }

    /// Refines the poles and updates the compressed `lines` for them. The number of steps includes all compressions.
    pub fn refine(
        &mut self,
        mut fit: ModelFit,
        lines: &mut CompressedProblem<'a>,
        numerators: usize,
        cancel: StopCriteria,
    ) -> ModelFit {
        let mut steps = 0;
        for round in 1.. {
            fit = refine(&[&*lines.problem], fit, numerators, cancel);
            steps += fit.steps;
            if round == MAX_RECOMPRESSIONS || lines.is_valid_for(&fit.model.poles) {
                break;
            }
            *lines = self.compress(&fit.model, &[]);
            fit = fit_at(&[&*lines.problem], &fit.model, numerators);
        }
        ModelFit { steps, ..fit }
    }

    /// Compresses the problem for the poles of a model and for candidates. A model with a delay, which rotates the data of each line, needs
    /// all lines.
    pub fn compress(
        &mut self,
        model: &PoleModel,
        candidates: &[ScanPeak],
    ) -> CompressedProblem<'a> {
        let problem = self.problem;
        let tolerance = MISMATCH / self.total.sqrt();
        if !model.delays.is_empty() || !(tolerance > MIN_MISMATCH_SHARE) {
            return CompressedProblem::uncompressed(problem);
        }
        let narrow = |p: &ScaledPole, ratio: f64| ScaledPole {
            sigma: ratio * p.sigma,
            ..*p
        };
        let poles: Vec<ScaledPole> = (model.poles.iter().map(|p| narrow(p, WIDTH_MARGIN.0)))
            .chain(candidates.iter().map(|c| narrow(&c.pole, WIDTH_MARGIN.1)))
            .collect();
        let limit = tolerance.min(0.1).powf(-1.0 / NODES as f64);
        let mut ranges = Vec::new();
        split(&problem.x, 0, problem.lines(), &poles, limit, &mut ranges);
        for range in ranges.iter_mut().filter(|range| range.smooth) {
            let block = (self.cached_blocks.entry((range.from, range.to))).or_insert_with(|| {
                CompressedBlock::new(problem, range.from, range.to, &mut self.cached_rules)
            });
            range.smooth = block.is_some();
        }
        if ranges.iter().all(|range| !range.smooth) {
            return CompressedProblem::uncompressed(problem);
        }
        let n = ranges.iter().map(LineRange::rows).sum();
        let mut reduced = WhitenedProblem {
            x: Vec::with_capacity(n),
            factor: Vec::with_capacity(n),
            pole_free_columns: Matrix::zeros(2 * n, problem.pole_free_columns.ncols()),
            y: Matrix::zeros(2 * n, problem.y.ncols()),
            first: problem.first,
            line_spacing: problem.line_spacing,
            omitted_energy: 0.0,
        };
        let mut blocks = Vec::new();
        for range in &ranges {
            let (from, to, at) = (range.from, range.to, reduced.x.len());
            match self.cached_blocks.get(&(from, to)) {
                Some(Some(block)) if range.smooth => {
                    blocks.push(middle_and_half(&problem.x, from, to));
                    reduced.x.extend(&block.x);
                    reduced.factor.extend(&block.factor);
                    copy(&block.y, 0, NODES, &mut reduced.y, at);
                    copy(&block.basis, 0, NODES, &mut reduced.pole_free_columns, at);
                }
                _ => {
                    reduced.x.extend(&problem.x[from..to]);
                    reduced.factor.extend(&problem.factor[from..to]);
                    copy(&problem.y, from, to, &mut reduced.y, at);
                    copy(
                        &problem.pole_free_columns,
                        from,
                        to,
                        &mut reduced.pole_free_columns,
                        at,
                    );
                }
            }
        }
        reduced.omitted_energy = problem.omitted_energy + self.total - sum_of_squares(&reduced.y);
        CompressedProblem {
            problem: Cow::Owned(reduced),
            blocks,
            min_clearance: limit,
        }
    }
}

/// Range of lines; compressed if smooth.
struct LineRange {
    from: usize,
    to: usize,
    smooth: bool,
}

impl LineRange {
    /// Number of lines, or of nodes if compressed.
    fn rows(&self) -> usize {
        match self.smooth {
            true => NODES,
            false => self.to - self.from,
        }
    }
}

fn split(
    x: &[f64],
    from: usize,
    to: usize,
    poles: &[ScaledPole],
    clearance: f64,
    ranges: &mut Vec<LineRange>,
) {
    if to - from <= MIN_BLOCK_LINES {
        match ranges.last_mut() {
            Some(last) if !last.smooth => last.to = to,
            _ => ranges.push(LineRange {
                from,
                to,
                smooth: false,
            }),
        }
        return;
    }
    let (middle, half) = middle_and_half(x, from, to);
    if is_clear(middle, half, poles, clearance) {
        ranges.push(LineRange {
            from,
            to,
            smooth: true,
        });
        return;
    }
    let centre = from + (to - from) / 2;
    split(x, from, centre, poles, clearance, ranges);
    split(x, centre, to, poles, clearance, ranges);
}

fn middle_and_half(x: &[f64], from: usize, to: usize) -> (f64, f64) {
    let (first, last) = (x[from], x[to - 1]);
    (0.5 * (first + last), 0.5 * (last - first))
}

/// True if the ellipses around a block through the poles, and through zero (singular lower residual term), have a sum of half-axes
/// above `clearance`: polynomials of degree d then approximate the function of a pole with an error of about `clearance^−d`.
fn is_clear(middle: f64, half: f64, poles: &[ScaledPole], clearance: f64) -> bool {
    let axes = |w: f64, sigma: f64| {
        let (x, y) = ((w - middle) / half, sigma / half);
        let sum = 0.5 * ((x - 1.0).hypot(y) + (x + 1.0).hypot(y));
        sum + (sum * sum - 1.0).max(0.0).sqrt()
    };
    axes(0.0, 0.0) > clearance && poles.iter().all(|p| axes(p.w, p.sigma) > clearance)
}

/// Compressed block of lines.
#[derive(Debug)]
struct CompressedBlock {
    x: Vec<f64>,
    factor: Vec<Complex>,
    y: Matrix,
    basis: Matrix,
}

impl CompressedBlock {
    /// Compresses a block; `None` if its lines have no Gauss rule.
    fn new(
        problem: &WhitenedProblem,
        from: usize,
        to: usize,
        rules: &mut HashMap<usize, Option<GaussRule>>,
    ) -> Option<CompressedBlock> {
        let (middle, half) = middle_and_half(&problem.x, from, to);
        let t: Vec<f64> = problem.x[from..to]
            .iter()
            .map(|x| (x - middle) / half)
            .collect();
        let factors = &problem.factor[from..to];
        let total = factors.iter().map(|f| f.norm_sqr()).sum::<f64>().sqrt();
        let phase = factors[0] / factors[0].norm();
        let weights: Vec<f64> = (factors.iter().map(|f| f.norm_sqr().sqrt() / total)).collect();
        let new_rule;
        let rule = if factors.iter().all(|f| *f == factors[0]) && is_even(&t) {
            let entry = rules.entry(to - from);
            entry
                .or_insert_with(|| GaussRule::new(&t, &weights))
                .as_ref()?
        } else {
            new_rule = GaussRule::new(&t, &weights)?;
            &new_rule
        };
        let block = CompressedBlock {
            x: rule.nodes.iter().map(|t| middle + half * t).collect(),
            factor: rule
                .root_weights
                .iter()
                .map(|s| phase * (total * s))
                .collect(),
            y: values_at_nodes(&problem.y, from, to, &rule.projection),
            basis: values_at_nodes(&problem.pole_free_columns, from, to, &rule.projection),
        };
        registers::zero_upper();
        Some(block)
    }
}

/// True if positions from −1 to 1 are equally spaced within rounding.
fn is_even(points: &[f64]) -> bool {
    const ROUNDING: f64 = 1e-12;
    let step = 2.0 / (points.len() as f64 - 1.0);
    let error = |(k, t): (usize, &f64)| (t - (k as f64 * step - 1.0)).abs();
    points.iter().enumerate().map(error).all(|e| e < ROUNDING)
}

/// Gauss rule for the discrete weight `f_k²`, `Σ f_k² = 1`, over lines scaled to −1…1.
#[derive(Debug)]
struct GaussRule {
    nodes: Vec<f64>,
    /// Square roots of the Gauss weights.
    root_weights: Vec<f64>,
    /// Orthonormal columns, one per node, that project values on lines to values at nodes.
    projection: Matrix,
}

impl GaussRule {
    /// Computes the nodes as eigenvalues of the line positions projected on the polynomials of degree below d (Golub and Welsch 1969);
    /// `None` if vanishing weights make the polynomials dependent.
    fn new(positions: &[f64], weight: &[f64]) -> Option<GaussRule> {
        let lines = positions.len();
        // Chebyshev polynomials times the weights
        let mut polynomials = Matrix::zeros(lines, NODES);
        for k in 0..lines {
            let (mut previous, mut current) = (0.0, weight[k]);
            for j in 0..NODES {
                polynomials[(k, j)] = current;
                let factor = if j == 0 { 1.0 } else { 2.0 };
                (previous, current) = (current, factor * positions[k] * current - previous);
            }
        }
        let qr = thin_qr(&polynomials);
        if (0..NODES).any(|j| !(qr.r[(j, j)].abs() > INDEPENDENCE_TOLERANCE)) {
            return None;
        }
        let mut shifted = qr.q.clone();
        for j in 0..NODES {
            let column = shifted.col_as_slice_mut(j);
            column.iter_mut().zip(positions).for_each(|(q, t)| *q *= t);
        }
        let eigen = symmetric_eigen(&transposed_product(&qr.q, &shifted)).ok()?;
        let projection = &qr.q * &eigen.vectors;
        let root_weight = |m: usize| {
            projection
                .col_as_slice(m)
                .iter()
                .zip(weight)
                .map(|(q, w)| q * w)
                .sum()
        };
        Some(GaussRule {
            nodes: eigen.values.clone(),
            root_weights: (0..NODES).map(root_weight).collect(),
            projection,
        })
    }
}

/// Projects columns on lines to values at nodes.
fn values_at_nodes(columns: &Matrix, from: usize, to: usize, projection: &Matrix) -> Matrix {
    let n = columns.nrows() / 2;
    let mut values = Matrix::zeros(2 * NODES, columns.ncols());
    for (offset, start) in [(0, from), (NODES, n + from)] {
        let rows = columns.subrows(start, to - from);
        let node_values = projection.transpose() * rows;
        values.subrows_mut(offset, NODES).copy_from(node_values);
    }
    values
}

/// Copies rows `from..to` of the real and the imaginary half to rows from `at` on.
fn copy(source: &Matrix, from: usize, to: usize, target: &mut Matrix, at: usize) {
    let (n, m, count) = (source.nrows() / 2, target.nrows() / 2, to - from);
    for j in 0..source.ncols() {
        for (from, at) in [(from, at), (n + from, m + at)] {
            let values = &source.col_as_slice(j)[from..from + count];
            target.col_as_slice_mut(j)[at..at + count].copy_from_slice(values);
        }
    }
}

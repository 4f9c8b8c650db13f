//! Data compression: blocks of lines away from poles replaced by Gauss quadrature nodes.
//!
//! Over a block of lines away from the poles every function of a fit is nearly a polynomial; the Gauss rule of the block's own
//! weights, `Σ_k f_k² g(x_k) = Σ_m λ_m g(ξ_m)` for polynomials g of degree below 2d (Golub and Welsch 1969), then stands for all
//! of its lines: nodes ξ_m with factors √λ_m, and the data projected on the polynomials of degree below d. The projection is
//! orthogonal, so that noise of unit variance stays so. Where a pole is near, lines are kept.

use std::borrow::{Borrow, Cow};
use std::collections::HashMap;

use crate::numeric::symmetric::symmetric_eigen;
use crate::numeric::thin_qr::{thin_qr, transposed_product};
use crate::numeric::{Complex, Matrix, registers};

use super::basis::{ScaledPole, WhitenedProblem};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine, sum_of_squares};
use super::scan::ScanPeak;

/// Nodes of a block, d.
const NODES: usize = 16;

/// A block of fewer lines is kept as it is.
const MIN_BLOCK_LINES: usize = 40;

/// The functions of a fit differ from polynomials by less than this, in units of the noise, over all lines together. No parameter moves by
/// more than this share of its standard deviation.
const MISMATCH: f64 = 1e-3;

/// Least mismatch as a share of the data: below it all lines are kept, since rounding is not far.
const MIN_MISMATCH_SHARE: f64 = 1e-13;

/// Weighted polynomials of which one is closer than this to those of lower degree are not independent.
const INDEPENDENCE_TOLERANCE: f64 = 1e-8;

/// A problem of fewer lines.
#[derive(Debug, Clone)]
pub(super) struct CompressedProblem<'a> {
    /// With as many responses, over the nodes.
    pub problem: Cow<'a, WhitenedProblem>,
    /// Middle and half-width of what was condensed.
    blocks: Vec<(f64, f64)>,
    /// Least sum of half-axes of the ellipse around a block with a pole on it.
    min_clearance: f64,
}

impl Borrow<WhitenedProblem> for CompressedProblem<'_> {
    fn borrow(&self) -> &WhitenedProblem {
        &self.problem
    }
}

impl<'a> CompressedProblem<'a> {
    /// All lines of a problem.
    pub fn uncompressed(problem: &'a WhitenedProblem) -> CompressedProblem<'a> {
        CompressedProblem {
            problem: Cow::Borrowed(problem),
            blocks: Vec::new(),
            min_clearance: 0.0,
        }
    }

    /// All lines were kept.
    pub fn is_whole(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Whether it still holds all there is to poles that have moved.
    pub fn is_valid_for(&self, poles: &[ScaledPole]) -> bool {
        let mut blocks = self.blocks.iter();
        blocks.all(|&(middle, half)| is_clear(middle, half, poles, self.min_clearance))
    }
}

/// Half-widths down to this share of a pole's, and of a candidate's, are provided for.
const WIDTH_MARGIN: (f64, f64) = (0.7, 0.35);

/// Most changes of the lines on which poles are brought to their places: they have hardly anywhere to go.
pub(super) const MAX_RECOMPRESSIONS: usize = 4;

/// Condenses a problem again and again, for poles that move.
#[derive(Debug)]
pub(super) struct Compressor<'a> {
    problem: &'a WhitenedProblem,
    /// `Σ y²`.
    total: f64,
    /// By first line and end: blocks that were condensed, or could not be.
    cached_blocks: HashMap<(usize, usize), Option<CompressedBlock>>,
    /// By number of lines: rules of evenly spaced lines of equal weight, the same wherever they lie.
    cached_rules: HashMap<usize, Option<GaussRule>>,
}

impl<'a> Compressor<'a> {
    /// Compressor of all lines of a problem.
    pub fn new(problem: &'a WhitenedProblem) -> Compressor<'a> {
        Compressor {
            problem,
            total: sum_of_squares(&problem.y),
            cached_blocks: HashMap::new(),
            cached_rules: HashMap::new(),
        }
    }

    /// Poles brought to their places, and `lines` to those that serve them there. The steps are those of all rounds.
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

    /// The lines needed for the poles of a model and for candidates. All of them where there is a delay, which turns the data line by
    /// line.
    pub fn compress(
        &mut self,
        model: &PoleModel,
        candidates: &[ScanPeak],
    ) -> CompressedProblem<'a> {
        let problem = self.problem;
        let share = MISMATCH / self.total.sqrt();
        if !model.delays.is_empty() || !(share > MIN_MISMATCH_SHARE) {
            return CompressedProblem::uncompressed(problem);
        }
        let narrow = |p: &ScaledPole, share: f64| ScaledPole {
            sigma: share * p.sigma,
            ..*p
        };
        let poles: Vec<ScaledPole> = (model.poles.iter().map(|p| narrow(p, WIDTH_MARGIN.0)))
            .chain(candidates.iter().map(|c| narrow(&c.pole, WIDTH_MARGIN.1)))
            .collect();
        let clear = share.min(0.1).powf(-1.0 / NODES as f64);
        let mut parts = Vec::new();
        split(&problem.x, 0, problem.lines(), &poles, clear, &mut parts);
        for part in parts.iter_mut().filter(|part| part.smooth) {
            let known = (self.cached_blocks.entry((part.from, part.to))).or_insert_with(|| {
                CompressedBlock::new(problem, part.from, part.to, &mut self.cached_rules)
            });
            part.smooth = known.is_some();
        }
        if parts.iter().all(|part| !part.smooth) {
            return CompressedProblem::uncompressed(problem);
        }
        let n = parts.iter().map(LineRange::rows).sum();
        let mut fewer = WhitenedProblem {
            x: Vec::with_capacity(n),
            factor: Vec::with_capacity(n),
            pole_free_columns: Matrix::zeros(2 * n, problem.pole_free_columns.ncols()),
            y: Matrix::zeros(2 * n, problem.y.ncols()),
            first: problem.first,
            line_spacing: problem.line_spacing,
            omitted_energy: 0.0,
        };
        let mut blocks = Vec::new();
        for part in &parts {
            let (from, to, at) = (part.from, part.to, fewer.x.len());
            match self.cached_blocks.get(&(from, to)) {
                Some(Some(block)) if part.smooth => {
                    blocks.push(middle_and_half(&problem.x, from, to));
                    fewer.x.extend(&block.x);
                    fewer.factor.extend(&block.factor);
                    copy(&block.y, 0, NODES, &mut fewer.y, at);
                    copy(&block.fixed, 0, NODES, &mut fewer.pole_free_columns, at);
                }
                _ => {
                    fewer.x.extend(&problem.x[from..to]);
                    fewer.factor.extend(&problem.factor[from..to]);
                    copy(&problem.y, from, to, &mut fewer.y, at);
                    copy(
                        &problem.pole_free_columns,
                        from,
                        to,
                        &mut fewer.pole_free_columns,
                        at,
                    );
                }
            }
        }
        fewer.omitted_energy = problem.omitted_energy + self.total - sum_of_squares(&fewer.y);
        CompressedProblem {
            problem: Cow::Owned(fewer),
            blocks,
            min_clearance: clear,
        }
    }
}

/// Lines in a row, to be kept or condensed.
struct LineRange {
    from: usize,
    to: usize,
    smooth: bool,
}

impl LineRange {
    /// Lines or nodes.
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
    clear: f64,
    parts: &mut Vec<LineRange>,
) {
    if to - from <= MIN_BLOCK_LINES {
        match parts.last_mut() {
            Some(last) if !last.smooth => last.to = to,
            _ => parts.push(LineRange {
                from,
                to,
                smooth: false,
            }),
        }
        return;
    }
    let (middle, half) = middle_and_half(x, from, to);
    if is_clear(middle, half, poles, clear) {
        parts.push(LineRange {
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
fn is_clear(middle: f64, half: f64, poles: &[ScaledPole], clear: f64) -> bool {
    let axes = |w: f64, sigma: f64| {
        let (x, y) = ((w - middle) / half, sigma / half);
        let sum = 0.5 * ((x - 1.0).hypot(y) + (x + 1.0).hypot(y));
        sum + (sum * sum - 1.0).max(0.0).sqrt()
    };
    axes(0.0, 0.0) > clear && poles.iter().all(|p| axes(p.w, p.sigma) > clear)
}

/// A block of lines, condensed.
#[derive(Debug)]
struct CompressedBlock {
    x: Vec<f64>,
    factor: Vec<Complex>,
    y: Matrix,
    fixed: Matrix,
}

impl CompressedBlock {
    /// `None` where there is no rule for its lines.
    fn new(
        problem: &WhitenedProblem,
        from: usize,
        to: usize,
        even: &mut HashMap<usize, Option<GaussRule>>,
    ) -> Option<CompressedBlock> {
        let (middle, half) = middle_and_half(&problem.x, from, to);
        let place: Vec<f64> = problem.x[from..to]
            .iter()
            .map(|x| (x - middle) / half)
            .collect();
        let factors = &problem.factor[from..to];
        let total = factors.iter().map(|f| f.norm_sqr()).sum::<f64>().sqrt();
        let phase = factors[0] / factors[0].norm();
        let weight: Vec<f64> = (factors.iter().map(|f| f.norm_sqr().sqrt() / total)).collect();
        let own;
        let rule = if factors.iter().all(|f| *f == factors[0]) && is_even(&place) {
            let known = even.entry(to - from);
            known
                .or_insert_with(|| GaussRule::new(&place, &weight))
                .as_ref()?
        } else {
            own = GaussRule::new(&place, &weight)?;
            &own
        };
        let block = CompressedBlock {
            x: rule.nodes.iter().map(|t| middle + half * t).collect(),
            factor: rule
                .root_weights
                .iter()
                .map(|s| phase * (total * s))
                .collect(),
            y: values_at_nodes(&problem.y, from, to, &rule.onto),
            fixed: values_at_nodes(&problem.pole_free_columns, from, to, &rule.onto),
        };
        registers::zero_upper();
        Some(block)
    }
}

/// Whether places from −1 to 1 lie evenly, to rounding.
fn is_even(place: &[f64]) -> bool {
    const ROUNDING: f64 = 1e-12;
    let step = 2.0 / (place.len() as f64 - 1.0);
    let off = |(k, t): (usize, &f64)| (t - (k as f64 * step - 1.0)).abs();
    place.iter().enumerate().map(off).all(|off| off < ROUNDING)
}

/// Gauss rule for the discrete weight `f_k²`, `Σ f_k² = 1`, over lines scaled to −1…1.
#[derive(Debug)]
struct GaussRule {
    nodes: Vec<f64>,
    /// Square roots of the Gauss weights.
    root_weights: Vec<f64>,
    /// Orthonormal columns, one per node: from values on lines to values at nodes.
    onto: Matrix,
}

impl GaussRule {
    /// Nodes are the eigenvalues of the lines' places projected on the polynomials of degree below d (Golub and Welsch 1969); `None`
    /// where weights vanish on so many lines that these are not independent.
    fn new(place: &[f64], weight: &[f64]) -> Option<GaussRule> {
        let lines = place.len();
        // Chebyshev's polynomials times the weight
        let mut polynomials = Matrix::zeros(lines, NODES);
        for k in 0..lines {
            let (mut before, mut now) = (0.0, weight[k]);
            for j in 0..NODES {
                polynomials[(k, j)] = now;
                let factor = if j == 0 { 1.0 } else { 2.0 };
                (before, now) = (now, factor * place[k] * now - before);
            }
        }
        let qr = thin_qr(&polynomials);
        if (0..NODES).any(|j| !(qr.r[(j, j)].abs() > INDEPENDENCE_TOLERANCE)) {
            return None;
        }
        let mut moved = qr.q.clone();
        for j in 0..NODES {
            let column = moved.col_as_slice_mut(j);
            column.iter_mut().zip(place).for_each(|(q, t)| *q *= t);
        }
        let nodes = symmetric_eigen(&transposed_product(&qr.q, &moved)).ok()?;
        let onto = &qr.q * &nodes.vectors;
        let size = |m: usize| {
            onto.col_as_slice(m)
                .iter()
                .zip(weight)
                .map(|(q, w)| q * w)
                .sum()
        };
        Some(GaussRule {
            nodes: nodes.values.clone(),
            root_weights: (0..NODES).map(size).collect(),
            onto,
        })
    }
}

/// Values at nodes of columns on lines.
fn values_at_nodes(all: &Matrix, from: usize, to: usize, onto: &Matrix) -> Matrix {
    let n = all.nrows() / 2;
    let mut values = Matrix::zeros(2 * NODES, all.ncols());
    for (half, start) in [(0, from), (NODES, n + from)] {
        let rows = all.subrows(start, to - from);
        let part = onto.transpose() * rows;
        values.subrows_mut(half, NODES).copy_from(part);
    }
    values
}

/// Rows `from..to` of both halves, to those from `at` on.
fn copy(all: &Matrix, from: usize, to: usize, fewer: &mut Matrix, at: usize) {
    let (n, m, count) = (all.nrows() / 2, fewer.nrows() / 2, to - from);
    for j in 0..all.ncols() {
        for (from, at) in [(from, at), (n + from, m + at)] {
            let values = &all.col_as_slice(j)[from..from + count];
            fewer.col_as_slice_mut(j)[at..at + count].copy_from_slice(values);
        }
    }
}

//! AAA algorithm: barycentric interpolation `Σ w_j H(s_j)/(s − s_j) / Σ w_j/(s − s_j)`.
//!
//! Nakatsukasa, Sète & Trefethen, SIAM J. Sci. Comput. 40 (2018), pp. A1494–A1522; many responses at once: Lietaert, Meerbergen,
//! Pérez & Vandereycken, IMA J. Numer. Anal. 42 (2022), pp. 1087–1115. A real system answers at −ω with the conjugate, so lines
//! come in pairs with conjugate weights, whose real and imaginary parts are the unknowns. Poles are zeros of the denominator,
//! which is itself a sum of poles and residues.

use super::elimination::vstack;
use super::partial_fractions;
use super::problem::{CommonPoleFit, CommonPoleOptions, CommonPoleProblem};
use crate::base::error::Error;
use crate::identify::transfer::function::{DirectTerms, TransferFunction};
use crate::numeric::{Complex, Matrix, least_squares};

/// The error, as a share of each response's largest value, at which no line is added: some digits above rounding.
const TOLERANCE: f64 = 1e-13;

/// Froissart doublet: a pole that changes no line of any response by more than this share of its largest value, cancelled by a zero.
const DOUBLET_TOLERANCE: f64 = 1e-11;

/// Poles of responses over lines, Hz, at most `order` of them, conjugates counted. It interpolates: noise goes into the poles.
///
/// Fewer poles come back where fewer describe the lines. Residues are fitted to all lines afterwards.
///
/// # Errors
/// Those of [`super::vector_fitting::vector_fit`].
pub fn aaa(
    frequency_hz: &[f64],
    responses: &[Vec<Complex>],
    order: usize,
    options: CommonPoleOptions,
) -> Result<CommonPoleFit, Error> {
    let problem = CommonPoleProblem::new(frequency_hz, responses, None, order, options)?;
    let mut nodes: Vec<usize> = Vec::new();
    let mut unknowns: Vec<f64> = Vec::new();
    loop {
        let errors = errors(&problem, &nodes, &unknowns);
        let worst = (0..errors.len())
            .filter(|k| !nodes.contains(k))
            .max_by(|&a, &b| errors[a].total_cmp(&errors[b]));
        let Some(worst) = worst.filter(|&k| errors[k] > TOLERANCE) else {
            break;
        };
        // So many nodes, counted with conjugates, have one pole less.
        if !nodes.is_empty() && unknown_count(&problem, &nodes) > order {
            break;
        }
        nodes.push(worst);
        if 2 * (problem.omega.len() - nodes.len()) * responses.len()
            < unknown_count(&problem, &nodes)
        {
            nodes.pop();
            break;
        }
        unknowns = least_squares::smallest_singular(&loewner(&problem, &nodes))?.0;
    }
    let used = nodes.len();
    let mut poles = poles(&problem, &nodes, &unknowns)?;
    problem.rescale_poles(&mut poles);
    let fitted = partial_fractions::fit(&problem, &poles, used)?;
    let kept: Vec<Complex> = (0..poles.len())
        .filter(|&k| is_effective(&problem, &fitted, k))
        .map(|k| poles[k])
        .collect();
    if kept.len() == poles.len() {
        return Ok(fitted);
    }
    partial_fractions::fit(&problem, &kept, used)
}

/// Unknowns: two for a line, one for 0 Hz.
fn unknown_count(problem: &CommonPoleProblem, nodes: &[usize]) -> usize {
    nodes
        .iter()
        .map(|&k| if problem.omega[k] > 0.0 { 2 } else { 1 })
        .sum()
}

/// The weights of nodes from the real unknowns.
fn weights(problem: &CommonPoleProblem, nodes: &[usize], unknowns: &[f64]) -> Vec<Complex> {
    let mut list = unknowns.iter().copied();
    let mut next = || list.next().unwrap_or(0.0);
    let weight = |&k: &usize| {
        let re = next();
        Complex::new(re, if problem.omega[k] > 0.0 { next() } else { 0.0 })
    };
    nodes.iter().map(weight).collect()
}

/// At each line the largest error over the responses, each a share of its largest value.
fn errors(problem: &CommonPoleProblem, nodes: &[usize], unknowns: &[f64]) -> Vec<f64> {
    let weights = weights(problem, nodes, unknowns);
    let mut worst = vec![0.0_f64; problem.omega.len()];
    for (response, factor) in problem.responses.iter().zip(&problem.factors) {
        let largest = response.iter().map(|z| z.norm()).fold(0.0, f64::max);
        if *factor == 0.0 {
            continue;
        }
        let mean = response.iter().fold(0.0, |sum, z| sum + z.re) / response.len() as f64;
        for (k, &w) in problem
            .omega
            .iter()
            .enumerate()
            .filter(|(k, _)| !nodes.contains(k))
        {
            let s = Complex::new(0.0, w);
            let (mut top, mut bottom) = (Complex::ZERO, Complex::ZERO);
            for (&node, &weight) in nodes.iter().zip(&weights) {
                let at = Complex::new(0.0, problem.omega[node]);
                let own = weight / (s - at);
                (top, bottom) = (top + own * response[node], bottom + own);
                if at.im > 0.0 {
                    let twin = weight.conj() / (s + at);
                    (top, bottom) = (top + twin * response[node].conj(), bottom + twin);
                }
            }
            let model = if nodes.is_empty() {
                Complex::new(mean, 0.0)
            } else {
                top / bottom
            };
            worst[k] = worst[k].max((response[k] - model).norm() / largest);
        }
    }
    worst
}

/// Rows `(H(s) − H_j)/(s − s_j)` of all other lines and responses, by real unknowns, in no more rows than needed.
fn loewner(problem: &CommonPoleProblem, nodes: &[usize]) -> Matrix {
    let others: Vec<usize> = (0..problem.omega.len())
        .filter(|k| !nodes.contains(k))
        .collect();
    let (rows, n) = (others.len(), unknown_count(problem, nodes));
    let mut stack = Matrix::zeros(0, n);
    for (response, factor) in problem.responses.iter().zip(&problem.factors) {
        if *factor == 0.0 {
            continue;
        }
        let mut own = Matrix::zeros(2 * rows, n);
        let mut at = 0;
        for &node in nodes {
            let (pole, value) = (Complex::new(0.0, problem.omega[node]), response[node]);
            for (row, &k) in others.iter().enumerate() {
                let s = Complex::new(0.0, problem.omega[k]);
                let one = (response[k] - value) / (s - pole) * *factor;
                if pole.im == 0.0 {
                    (own[(row, at)], own[(rows + row, at)]) = (one.re, one.im);
                    continue;
                }
                let twin = (response[k] - value.conj()) / (s + pole) * *factor;
                let (sum, difference) = (one + twin, one - twin);
                (own[(row, at)], own[(rows + row, at)]) = (sum.re, sum.im);
                (own[(row, at + 1)], own[(rows + row, at + 1)]) = (-difference.im, difference.re);
            }
            at += if pole.im == 0.0 { 1 } else { 2 };
        }
        stack = least_squares::qr_r(&vstack(&stack, &[own]));
    }
    stack
}

/// Zeros of `Σ w_j/(s − s_j)`.
fn poles(
    problem: &CommonPoleProblem,
    nodes: &[usize],
    unknowns: &[f64],
) -> Result<Vec<Complex>, Error> {
    let at = nodes
        .iter()
        .map(|&k| Complex::new(0.0, problem.omega[k]))
        .collect();
    let weights = weights(problem, nodes, unknowns);
    Ok(TransferFunction::new(at, weights, DirectTerms::default())?
        .zeros()?
        .zeros)
}

/// Whether pole k moves any line of any response.
fn is_effective(problem: &CommonPoleProblem, fit: &CommonPoleFit, k: usize) -> bool {
    let pole = fit.poles[k] / problem.scale;
    let nearest = problem
        .omega
        .iter()
        .map(|&w| (Complex::new(0.0, w) - pole).norm())
        .fold(f64::INFINITY, f64::min);
    problem
        .responses
        .iter()
        .zip(&fit.residues)
        .any(|(response, residues)| {
            let largest = response.iter().map(|z| z.norm()).fold(0.0, f64::max);
            residues[k].norm() / problem.scale > DOUBLET_TOLERANCE * largest * nearest
        })
}

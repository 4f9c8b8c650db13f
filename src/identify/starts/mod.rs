//! Rational fits with common poles, each a start for the refined fit or a check of it: linearised least squares, vector
//! fitting, and the AAA algorithm. None of them is the maximum-likelihood answer; with noise their poles are biased.

/// What is fitted, with which terms, and the answer.
pub mod problem;

/// Columns `1/(s − p)` in real arithmetic, and residues of known poles.
mod partial_fractions;

/// What is left of many responses once their own numerators are taken out.
mod reduction;

/// Levy's equations, reweighted, over orthogonal polynomials.
pub mod levy;

/// Poles moved to the zeros of their own correction.
pub mod vector_fitting;

/// Barycentric interpolation where the error is largest.
pub mod aaa;

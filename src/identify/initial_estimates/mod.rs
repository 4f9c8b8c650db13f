//! Initial estimates of common poles: Levy, vector fitting, AAA.
//!
//! None of them is the maximum-likelihood answer; with noise their poles are biased.

pub mod problem;

mod partial_fractions;

mod elimination;

pub mod levy;

pub mod vector_fitting;

pub mod aaa;

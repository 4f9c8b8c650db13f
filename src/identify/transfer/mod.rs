//! Transfer functions by poles and residues: zeros, polynomials, state space, discretisation, export.

pub mod function;

pub mod realisation;

pub mod zeros;

pub mod polynomials;

pub mod discretisation;

pub mod export;

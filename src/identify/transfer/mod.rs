//! Transfer functions by poles and residues, and what follows from them.

/// `H(s)` by poles, residues and direct terms.
pub mod function;

/// Real block-diagonal state space of many functions.
pub mod realisation;

/// Zeros and gain.
pub mod zeros;

/// Numerator and denominator by powers of s.
pub mod polynomials;

/// The same at a sample time.
pub mod sampled;

/// To JSON, CSV and MATLAB.
pub mod export;

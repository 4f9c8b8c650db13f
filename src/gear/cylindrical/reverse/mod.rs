//! Reversal: from spans, diameters and the helix angle of an unknown gear to module or diametral pitch, pressure angle and profile shift.
//!
//! `W_{k+1} − W_k = p_bn = π m_n cos α_n`, `sin β = z m_n tan β_a/d_a`; the level of the spans gives x_E, tip and root diameter the
//! coefficients `h_aP = ±(d_a − d)/(2 m_n) − x` and `h_fP = x_E ± (d − d_f)/(2 m_n)`.
//!
//! Gears of one base pitch, tooth number and span have the same flanks whatever module and pressure angle name them: such candidates
//! differ only in the coefficients of their tip and root diameters.

/// Readings of an unknown gear and its mate.
pub mod readings;

/// Standard tooth sizes, pressure angles and tooth heights.
pub mod standard_sizes;

/// A standard gear fitted to readings.
pub mod candidate;

/// Candidates that readings leave open, and readings that would part them.
pub mod confusion;

/// The candidates, ranked.
pub mod reversal;

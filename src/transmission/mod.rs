//! Transmission error: how far a driven shaft is from where an ideal train would have it; what the errors of a chain's elements do at
//! its end, slowly, under load and at speed, and what two encoders measure.

/// Ratios in exact fractions, and how far the displacement of each branch moves the end.
pub mod chain;

/// Lines at the end of the chain, by order.
pub mod lines;

/// The same lines with elastic joints, slowly and at speed.
pub mod dynamic;

/// What stiffness that changes under load adds.
pub mod loaded;

/// An eccentric pair, exactly.
pub mod eccentric_pair;

/// The range over a window and its percentiles.
pub mod spread;

/// Worst case, root of sum of squares, what a better element buys.
pub mod budget;

/// Flank form and pitch of work that is indexed tooth by tooth.
pub mod indexing;

/// The error over the angle.
pub mod record;

/// Orders that coincide, and which test tells their sources apart.
pub mod coincidence;

/// Measured with two encoders.
pub mod measured;

//! What an analysis of a log needs: stages run at most once, a trace kept.

/// Blocks of samples from a recording.
pub mod blocks;

/// Frequency responses from a recording.
pub mod acquire;

/// What the data cannot tell.
pub mod doubts;

/// The run of an identification.
pub mod identification;

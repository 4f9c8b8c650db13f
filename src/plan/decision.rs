//! Decision about a stage of a study.

/// Whether a stage runs, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StageDecision {
    /// It runs: what it will do.
    Runs(String),
    /// It is left out: why.
    LeftOut(String),
}

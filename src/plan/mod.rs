//! What one study needs: stages announced, run at most once, and a trace kept.

/// Values far outside what machines have.
pub mod plausible;

/// A machine ready to be asked.
pub mod prepared;

/// The table of stages.
pub mod stages;

/// Roots that grow, and terms that were left out.
pub mod linear_stability;

/// The run.
pub mod run;

/// Motion in time.
pub mod motion;

/// Steady answers to steady excitation.
pub mod response;

/// Transmission error.
pub mod transmission;

/// Analyses of logs.
pub mod logs;

/// What is found while a motion runs.
pub mod on_the_fly;

/// A motion with all that is said of it.
pub mod simulate;

/// A gear's charts and readings.
pub mod measure;

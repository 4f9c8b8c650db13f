//! Charts and readings of a gear, each evaluated by its standard. Lengths in m, angles in rad, unless a line says otherwise.

/// A value with its standard uncertainty.
pub mod estimate;

/// What is measured: names of today and of JB 179-60.
pub mod quantity;

/// Tolerances of ISO 1328.
pub mod iso;

/// Limits out of a table somebody typed in.
pub mod limits;

/// Grades as written: `6`, `8-7-7 Dc`.
pub mod notation;

/// Largest ranges in windows of a record.
pub mod ranges;

/// Transmission error of a gear or a pair, split into what repeats each turn and each tooth.
pub mod composite;

/// Pitch readings of one side of the teeth.
pub mod pitch;

/// Radial run-out.
pub mod runout;

/// Profile and helix traces.
pub mod trace;

/// Tooth thickness by chord, span and balls.
pub mod sizes;

/// The record of a pair that rolls rigidly, from its charts.
pub mod rigid;

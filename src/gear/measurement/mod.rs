//! Charts and readings of a gear, each evaluated by its standard. Lengths in one unit of the caller's choice unless a line says
//! otherwise, angles in rad.

/// Largest ranges in windows of a record.
pub mod ranges;

/// Transmission error of a gear or a pair, split into what repeats each turn and each tooth.
pub mod composite;

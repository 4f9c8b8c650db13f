//! One element, one file: its equation, its signs, its limits.

/// Bodies.
pub mod body;

/// Shaft lengths and bars.
pub mod shaft;

/// Rows of equal discs.
pub mod chain;

/// The tooth normal in space.
pub mod tooth;

/// Friction of bearings and teeth.
pub mod rubbing;

/// Spur, helical, bevel and hypoid pairs.
pub mod gear_pair;

/// Worm pairs.
pub mod worm_pair;

/// Planetary stages.
pub mod planetary;

/// Belts and chain drives.
pub mod belt;

/// Screws and what they move.
pub mod screw;

/// Couplings.
pub mod coupling;

/// Bearings and supports.
pub mod bearing;

/// Dampers.
pub mod damper;

/// Declared errors.
pub mod form_error;

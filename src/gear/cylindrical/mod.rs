//! Cylindrical involute gears on parallel axes: basic rack, member, outline with fillet, pair.
//!
//! ISO 21771-1:2024 and -2:2025 with tooth numbers and diameters positive for internal gears too; a positive profile shift thickens the
//! tooth of either kind.

/// The involute function, diameters, thickness and its gauge readings of one gear.
pub mod involute;

/// Basic racks of ISO 53.
pub mod basic_rack;

/// One gear with its rack, tip and thickness allowance.
pub mod member;

/// Readings of the drawing with their limits.
pub mod drawing;

/// Fillet as the trace of the rounded tip of a tool.
mod fillet;

/// Tooth outline: involute and generated fillet.
pub mod outline;

/// Designed modifications of a flank.
pub mod modification;

/// Path of contact, sharing of load along it, and the loss factor.
pub mod path_of_contact;

/// Two gears in mesh.
pub mod pair;

/// Polygons of whole gears, and of a pair in mesh.
pub mod gear_outline;

/// Path of contact of a pair, points A–E, contact ratios.
pub mod path_points;

/// Backlash at a centre distance, and its limits.
pub mod backlash;

/// Warnings of a pair, each with the nearest value that avoids it.
pub mod warnings;

/// Nearest values that can be followed without a new warning.
pub mod remedy;

/// From readings of an unknown gear to its data.
pub mod reverse;

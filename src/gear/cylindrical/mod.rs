//! Cylindrical involute gears on parallel axes: basic rack, member, outline with fillet, pair.
//!
//! ISO 21771-1:2024 and -2:2025 with tooth numbers and diameters positive for internal gears too; a positive profile shift thickens the
//! tooth of either kind.

/// The involute function, diameters, thickness and its gauge readings of one gear.
pub mod involute;

/// Root of a function inside a bracket.
mod bracket;

/// Basic racks of ISO 53.
pub mod basic_rack;

/// One gear with its rack, tip and thickness allowance.
pub mod member;

/// Fillet as the trace of the rounded tip of a tool.
mod fillet;

/// Tooth outline: involute and generated fillet.
pub mod outline;

/// Path of contact, sharing of load along it, and the loss factor.
pub mod path_of_contact;

/// Two gears in mesh.
pub mod pair;

//! Computation of a gear file: geometry of the gears and the pair, stiffness and loaded transmission error.

/// Geometry as a list of quantities with names, symbols and units.
pub mod geometry;

/// Readings of tooth thickness.
pub mod drawing;

/// Stages of a gear file and its result.
pub mod run;

/// Reversal of readings and its stages.
pub mod reversal;

/// Centrodes, flanks and outlines of a pair of varying ratio.
pub mod non_circular;

/// Results that are quantities and tables.
pub mod sheet;

/// Axodes of a pair.
pub mod axodes;

/// Lines of contact of a worm pair.
pub mod worm;

/// Both lines of contact of a plane double-enveloping worm pair.
pub mod plane_worm;

/// Helicoids with the disk tool that cuts them.
pub mod disk_tool;

/// A gear with the hob that cuts it.
pub mod hob;

/// Path of contact of a crossed helical pair.
pub mod crossed;

/// Results of worm pairs, crossed pairs and helicoids.
pub mod space;

/// Contact of a bevel pair.
pub mod bevel_contact;

/// Contacts of a bevel pair moved by V and H.
pub mod pattern_states;

/// Theory of a bevel pair at its pitch point.
pub mod hypoid_theory;

/// Stability of the loaded contact of a bevel pair.
pub mod bevel_stability;

/// Load on a bevel pair.
pub mod bevel_mesh;

/// Flanks and tooth of a bevel gear.
pub mod bevel_member;

/// Limits that bevel flanks meet.
pub mod bevel_limits;

/// Backlash of a bevel pair.
pub mod bevel_backlash;

/// Quantities of a bevel pair.
mod bevel_quantities;

/// Warnings about the blanks of a bevel pair.
mod bevel_blanks;

/// Result and stages of a bevel pair.
pub mod bevel;

/// Nodes of a measured grid on the flanks of a file.
mod measured_nodes;

/// Correction of the settings of a measured bevel gear.
pub mod correction;

/// Causes of the deviations of a cut flank.
pub mod cut_causes;

/// Settings of a pinion for a wanted ease-off.
pub mod synthesis;

/// One flank as discrete blades cut it.
pub mod cut_flank;

/// Transmission error and pattern of a pair as it is cut.
pub mod cut_mesh;

/// Contact of a pair as it is cut.
pub mod cut_contact;

/// Chips of a member that is cut from the solid.
pub mod cut_chips;

/// A pair as discrete blades cut it.
pub mod cut;

/// Size of what discrete blades leave.
pub mod blade_effect;

/// A pair that carries the errors of its generator's roll.
pub mod cut_pair;

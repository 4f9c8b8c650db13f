//! Tooth stiffness, load sharing and loaded transmission error: `C F = δ − g`, `Σ F = W`, e(φ, T) = −δ.

/// Elastic constants.
pub mod material;

/// Stiffness c′ and c_γ of ISO 6336-1:2006.
pub mod iso6336;

/// Line contact of flanks.
pub mod hertz;

/// Contact over an ellipse.
pub mod elliptic_contact;

/// Contact lines in cells, teeth under them.
pub mod contact_line;

/// Half spaces under strips.
mod strip_kernel;

/// Tooth as a plate with shear on an elastic root line.
pub mod tooth_plate;

/// Load sharing of contact lines of any kind of pair.
pub mod loaded_lines;

/// Torques at which cells begin or cease to carry.
pub mod load_path;

/// Results of flanks in space over one pitch.
pub mod flank_result;

/// Load over deflection of a mesh through its phase.
pub mod load_table;

/// Flanks in space at one angle, and a load on them.
pub mod flank_position;

/// Loaded contact of flanks in space.
pub mod flank_mesh;

/// Plates of the teeth of a bevel pair.
pub mod bevel_teeth;

/// Models of the gear body under a tooth.
pub mod body;

/// Tooth as a beam of variable thickness.
pub mod tooth;

/// Places of contact on the line of action and of tip corners off it.
pub mod contact_path;

/// Compliance of a tooth pair by either method, and both side by side.
pub mod compliance;

/// Load sharing at one pinion angle.
pub mod position;

/// Results over one pitch.
pub mod mesh_result;

/// Loaded transmission error, stiffness and load sharing over one pitch.
pub mod mesh;

/// Relief of least peak-to-peak over a range of torques.
pub mod relief;

/// Phase between a planet's meshes with sun and ring.
pub mod planet_phase;

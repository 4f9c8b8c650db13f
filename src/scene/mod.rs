//! The project's TOML files as written: models, scenes, measured gears; SI values with spans.

pub mod laws;

pub mod gear_mesh;

/// Torques at the pinion of a gear file.
mod mesh_torques;

mod cutter_table;

pub mod machine_settings;

pub mod correction_study;

pub mod ease_off_target;

pub mod cut_study;

/// Places of the axes of a bevel pair.
pub mod assembly;

mod bevel_blank;

pub mod bevel_file;

pub mod bevel_mesh;

pub mod pair_mesh;

pub mod model;

mod waveforms;

mod characteristic;

mod shared_keys;

pub mod generator_work;

pub mod materials;

mod bodies;

mod shafts;

mod friction;

pub mod screws;

pub mod gear_kind;

mod gear_member;

pub mod mesh_table;

pub mod gear_file;

pub mod worm_file;

pub mod plane_worm_file;

mod named_gear_file;

mod gears;

mod planetary;

mod supports;

mod factors;

pub mod limit_table;

mod csv_table;

mod face_mill;

mod loads_and_motors;

mod declared_errors;

pub mod initial_conditions;

mod consistency;

mod overrides;

pub mod study;

mod file;

pub mod measured_gear;

pub mod gear_readings;

pub mod cut_file;
pub mod measured_grid;

pub mod non_circular_file;

pub mod helicoid_file;

pub mod hob_file;

pub mod crossed_file;

pub use file::{Scene, read, read_text};

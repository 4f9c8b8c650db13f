//! Meshes of gear files put into a model before its machine is built: stiffness over the mesh cycle, transmission error, tooth pairs.

pub mod curves;

mod bevel_curves;

mod torques;

pub mod work;

mod rows;

pub mod stage;

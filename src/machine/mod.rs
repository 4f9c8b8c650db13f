//! Masses and branches: what a model is made of once it is built, and what is eliminated before anything is solved.

/// A sparse direction in the space of all freedoms.
pub mod direction;

/// The machine: elements, nodes, freedoms, masses, branches.
pub mod parts;

/// The cycle that the stiffness wave of a mesh is counted by.
pub mod mesh_cycle;

/// Force over deflection that is not linear.
pub mod characteristic;

/// Nodes first, then the terms elements put on them.
pub mod builder;

/// One element, one file.
pub mod elements;

/// From a model to a machine.
pub mod build;

/// What can turn: exact ratios, rigid joints, mean speeds.
pub mod kinematics;

/// Which contacts are closed under the mean loads.
pub mod operating;

/// The linear machine at its operating point, in the freedoms that are left.
pub mod linear;

/// Terms of mean speeds: gyroscopic moments and frames that turn.
pub mod spin;

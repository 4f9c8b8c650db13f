//! The machine as masses and branches: build, kinematics, operating point, linear model.

pub mod direction;

pub mod components;

pub mod mesh_cycle;

pub mod characteristic;

pub mod builder;

pub mod elements;

pub mod build;

pub mod kinematics;

pub mod operating_point;

pub mod linear;

pub mod spin;

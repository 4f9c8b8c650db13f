//! Identification from measured responses: transfer functions, modal parameters, uncertainty.
//!
//! On slices; knows neither files nor the terminal.

pub mod modal_parameters;

pub mod pole_shift;

pub mod level_dependence;

pub mod reciprocity;

pub mod rational;

pub mod free_decay;

pub mod transfer;

pub mod initial_estimates;

pub mod compare;

pub mod point_shape;

pub mod modal;

pub mod modal_mass;

mod validation;

pub mod series;

pub mod operational;

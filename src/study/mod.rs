//! Comparison studies: work–precision, stability of methods, parametric stability.

pub mod monitor;

mod timing;

mod method_run;

pub mod reference;

pub mod work_precision;

pub mod comparison;

pub mod frequencies;

pub mod responses;

pub mod mesh_grid;

pub mod contact_grid;

pub mod stability;

pub mod parametric;

pub mod check;

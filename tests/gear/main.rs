//! Gears: the kernel of meshing, plane meshing, cylindrical gears, tooth stiffness and loaded transmission error.

#[path = "../support/verification.rs"]
mod verification;

mod kernel;

mod kernel_space;

mod kernel_bevel;

mod kernel_worm;

mod plane_centrodes;

mod plane_conjugates;

mod plane_rolling_curves;

mod plane_outlines;

//! Gears: the kernel of meshing, plane meshing, cylindrical gears, tooth stiffness and loaded transmission error.

mod cylindrical_outline;

mod cylindrical_laws;

mod cylindrical_pair;

mod cylindrical_reverse;

#[path = "../support/verification.rs"]
mod verification;

mod complementarity;

mod load_laws;

mod load_mesh;

mod load_planet;

mod load_random;

mod load_stiffness;

mod kernel;

mod kernel_space;

mod kernel_bevel;

mod kernel_worm;

//! Gears: the kernel of meshing, plane meshing, cylindrical gears, tooth stiffness and loaded transmission error.

mod cylindrical_pair;
#[path = "../support/verification.rs"]
mod verification;

mod complementarity;
mod load_mesh;
mod load_random;
mod load_stiffness;

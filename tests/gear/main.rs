//! Gears: the kernel of meshing, plane meshing, cylindrical gears, tooth stiffness and loaded transmission error.

#[path = "../support/verification.rs"]
mod verification;

mod complementarity;
mod cylindrical_pair;
mod load_laws;
mod load_mesh;
mod load_planet;
mod load_random;
mod load_stiffness;

//! The kernel of meshing: a surface carried by a motion touches its envelope where `f = n·v = 0`.
//!
//! A `Tool` is a curve swept by a screw, a `Motion` a product of joints with laws, an `Envelope` what the
//! tool leaves of the work under that motion: again a surface, which the next motion carries. Normals point out of the metal of the work,
//! `dn = −W dr`. Frames are types where results leave the kernel; lengths have the unit of the input. The plane is an instance: `plane`.

pub mod vector;

pub mod root;

pub mod newton;

pub mod twist;

pub mod crossed_axes;

pub mod pose;

pub mod jet;

pub mod tool;

pub mod law;

pub mod motion;

pub mod meeting;

pub mod second_order;

pub mod envelope;

pub mod limits;

pub mod plane;

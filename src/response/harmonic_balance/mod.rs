//! Harmonic balance and continuation for models with backlash, friction, varying stiffness.

pub mod relative;

pub mod family;

pub mod linear_part;

mod assemble_linear;

mod aft;

mod balance;

mod multipliers;

pub mod point;

mod continuation;

pub mod bifurcation;

pub mod period_doubling;

pub mod curve;

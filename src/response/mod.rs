//! Steady-state response: frequency responses and nonlinear periodic solutions.

pub mod ports;

mod laplace_factor;

mod dynamic_stiffness;

mod constrained;

mod input_output;

pub mod system;

pub mod direct;

pub mod modal;

pub mod frf;

pub mod peaks;

pub mod refinement;

pub mod harmonic_balance;

pub mod excitation;

pub mod strain_energy;

pub mod run_up;

//! Stability study: linear stability of the model and stress test of the methods.

pub mod amplification;

pub mod linear;

pub mod perturbations;

pub mod stress_test;

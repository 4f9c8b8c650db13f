//! Time integration of a machine: setup, method choice, run, output statistics.

pub mod output_selection;

pub mod simulation_setup;

pub mod structure;

pub mod dense_cost;

pub mod method_choice;

pub mod stages;

pub mod cost;

pub mod run;

pub mod sensitivity;

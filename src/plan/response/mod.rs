//! Steady-state response: frequency responses, run-up, harmonic balance.

pub mod method_choice;

pub mod run;

pub mod harmonic_balance;

pub mod run_up;

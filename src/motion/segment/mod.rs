//! Exact propagation of piecewise linear models: a sum of exponentials in each regime.

pub mod phi;

pub mod double_time;

pub mod inputs;

pub mod time_events;

pub mod mass_normalised;

pub mod modal_transform;

pub mod dense;

pub mod modal_parts;

pub mod event_evaluator;

pub mod trajectory;

pub mod propagator_cache;

pub mod equations;

pub mod uncoupled;

pub mod weak_coupling;

pub mod coupled;

pub mod linear_law;

pub mod run_context;

pub mod stick;

pub mod event_function;

pub mod linear_system;

pub mod piece_load;

pub mod regime_system;

pub mod segment_trajectory;

pub mod event_search;

pub mod regime_cache;

pub mod run;

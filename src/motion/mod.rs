//! Time integration of dynamic models and of plain first-order problems.

pub mod burst;

pub mod signal;

pub mod product;

pub mod wave;

pub mod contact;

pub mod friction;

pub mod curve;

pub mod load_friction;

pub mod regime;

pub mod problem;

pub mod dynamic_model;

pub mod contact_spring;

pub mod algebraic;

pub mod normal_force;

pub mod forces;

pub mod equations;

pub mod regime_at;

pub mod combination;

pub mod prescribed;

pub mod progress;

pub mod diagnostics;

pub mod segment;

pub mod error_scale;

pub mod stepper;

pub mod pencil;

pub mod bernstein;

pub mod switching_surface;

pub mod first_root;

pub mod events;

pub mod taylor;

pub mod methods;

pub mod floquet;

pub mod sensitivity;

pub mod outputs;

pub mod output_statistics;

pub mod block_statistics;

pub mod step_response;

pub mod peak_refinement;

pub mod sampling_check;

pub mod event_log;

pub mod energy;

pub mod energy_balance;

mod cutting;

pub mod known;

mod star_mesh;

pub mod condensation;

pub mod assembled;

pub mod assemble;

pub mod initial_state;

//! The machine side: gears, scenes, machines, modes, responses, motion, transmission error, studies.

#[path = "../support/mod.rs"]
mod support;

mod campbell;
mod characteristics;
mod clutch;
mod digits_trusted;
mod edge_machines;
mod exponential;
mod extremes;
mod floquet;
mod friction;
mod graded_machines;
mod laws_of_motion;
mod light_nodes;
mod linear_stability;
mod loss_factors;
mod maps;
mod measure_composite;
mod measure_readings;
mod measure_rigid;
mod measure_tolerances;
mod mesh_waves;
mod modes_laws;
mod motion_exact;
mod motion_periodic;
mod motion_steps;
mod numeric_damped;
mod numeric_graded;
mod numeric_sparse;
mod operating_point;
mod pictures;
mod plan_left_out;
mod planetary_mass;
mod product_loads;
mod published_cases;
mod published_rotors;
mod reading;
mod reduction;
mod response_frequency;
mod response_harmonic;
mod scenes_in_motion;
mod state_space;
mod te_measured;
mod transmission;
mod transmission_elements;

//! Flanks as they are cut: by the discrete blades of a cutter head, and the settings that bring a measured flank to its nominal one.

pub mod setting;

pub mod dial;

pub mod sensitivity;

pub mod root_point;

pub mod measured_flank;

pub mod outliers;

pub mod node_sensitivities;

pub mod correction;

pub mod next_cut;

pub mod shapes;

pub mod target;

pub mod cutter_head;

pub mod angle_errors;

pub mod blade_passes;

pub mod chips;

pub mod cut_surface;

pub mod roll_errors;

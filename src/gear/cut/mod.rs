//! Correction of machine settings: what each setting moves on a flank, and the settings that bring a measured flank to its nominal one.

pub mod setting;

pub mod dial;

pub mod sensitivity;

pub mod measured_flank;

pub mod linear_system;

pub mod correction;

pub mod next_cut;

pub mod shapes;

pub mod target;

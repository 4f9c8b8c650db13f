//! Analyses of recordings: spectra, FRF estimation, identification, transmission error.

pub mod sample_blocks;

pub mod fault_free;

pub mod segment_samples;

mod stepped_sine;

/// Excited band of an input.
mod excited_band;

pub mod frf_estimation;

pub mod points;

pub mod diagnostics;

mod mains;

mod linearity;

mod level_linearity;

pub mod method;

pub mod identify_study;

pub mod mode_comparison;

pub mod identification_result;

pub mod weak;

mod transfer_functions;

mod sub_bands;

mod frf_modes;

mod rational;

mod pole_consistency;

pub mod modal_mass;

mod running;

mod subspace;

mod wandering_mains;

mod operational_modes;

mod free_decay;

mod time_series;

mod mode_tracking;

pub mod identification;

pub mod spectrum_study;

pub mod expected_lines;

pub mod frequency_spectra;

pub mod order_spectra;

pub mod order_cuts;

pub mod spectrum;

pub mod stored_spectra;

pub mod attribution;

pub mod encoder_study;

mod encoder_readings;

pub mod encoder_analysis;

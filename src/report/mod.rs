//! Results as tables, JSON, CSV and plots. Computes nothing.

pub mod number_format;

pub mod svg;

pub mod axes;

pub mod bode;

pub mod pole_plots;

pub mod spectrum_plot;

pub mod fdd_plot;

pub mod heatmap;

pub mod campbell_plot;

pub mod campbell;

pub mod mode_text;

pub mod state_space;

pub mod json;

pub mod recording;

pub mod mode_tracking;

pub mod identification;

pub mod spectra;

pub mod encoder_te;

pub mod encoder_te_plot;

pub mod modes_csv;

pub mod order_cuts;

pub mod simulation;

pub mod response;

mod amplitude_plot;

pub mod harmonic_balance;

pub mod run_up;

pub mod transmission;

mod work_precision_plot;

mod work_precision_text;

pub mod work_precision;

mod method_comparison_text;

pub mod method_comparison;

pub mod stability;

pub mod stability_regions;

pub mod measure;

#[cfg(feature = "cli")]
pub mod modes_table;

#[cfg(feature = "cli")]
pub mod simulation_table;

pub mod sensitivity;

#[cfg(feature = "cli")]
pub mod sensitivity_table;

#[cfg(feature = "cli")]
pub mod response_table;

#[cfg(feature = "cli")]
pub mod run_up_table;

#[cfg(feature = "cli")]
pub mod harmonic_balance_table;

#[cfg(feature = "cli")]
pub mod transmission_table;

#[cfg(feature = "cli")]
pub mod work_precision_table;

#[cfg(feature = "cli")]
pub mod method_comparison_table;

#[cfg(feature = "cli")]
pub mod stability_table;

#[cfg(feature = "cli")]
pub mod measure_table;

#[cfg(feature = "cli")]
pub mod mode_tracking_table;

#[cfg(feature = "cli")]
pub mod log_tables;

#[cfg(feature = "cli")]
pub mod spectrum_table;

#[cfg(feature = "cli")]
pub mod order_cuts_table;

#[cfg(feature = "cli")]
pub mod encoder_te_table;

pub mod online;

#[cfg(feature = "cli")]
pub mod online_table;

#[cfg(feature = "cli")]
pub mod state_space_tables;

pub mod measure_plot;

pub mod measure_polar_plot;

pub mod node_layout;

pub mod mode_shape_plot;

pub mod energy_matrix_plot;

pub mod transmission_plots;

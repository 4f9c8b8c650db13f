//! Results as tables, JSON, CSV and plots: one [`presentation`] for every result. Computes nothing.

pub mod number_format;

pub mod table;

pub mod svg;

pub mod axes;

pub mod figure;

mod label_placement;

mod heatmap;

mod figure_marks;

mod figure_names;

mod figure_key;

mod figure_svg;

pub mod bode;

pub mod pole_plots;

pub mod fdd_plot;

pub mod campbell_plot;

pub mod campbell;

pub mod node_layout;

pub mod mode_text;

pub mod json;

pub mod plan;

pub mod recording;

pub mod view;

pub mod presentation;

pub mod page;

pub mod check;

pub mod state_space;

pub mod plan_report;

mod train_layout;

pub mod train;

pub mod mode_shape_plot;

pub mod energy_matrix_plot;

pub mod modes_table;

mod mode_view;

pub mod modes;

pub mod mode_tracking;

pub mod identification_table;

mod point_shapes;

mod mac_plot;

pub mod identification;

pub mod spectrum_table;

pub mod spectra;

pub mod order_cuts;

pub mod te_lines;

pub mod work;

pub mod encoder_te_table;

pub mod encoder_te_plot;

pub mod encoder_te;

pub mod transmission_table;

pub mod output_key;

pub mod sensitivity;

pub mod online;

pub mod simulation_table;

pub mod simulation;

pub mod response;

mod amplitude_plot;

pub mod harmonic_balance_table;

pub mod harmonic_balance;

pub mod run_up;

mod work_precision_plot;

mod work_precision_text;

pub mod work_precision;

pub mod method_comparison;

pub mod mesh_accuracy;

pub mod stability_chart;

pub mod stability_regions;

pub mod stability_table;

mod verdict_matrix;

pub mod stability;

pub mod measure_plot;

pub mod measure_polar_plot;

pub mod measure_table;

pub mod measure;

pub mod outline_file;

mod gear_plot;

mod teeth_view;

mod helical_view;

pub mod gear;

mod non_circular_plot;

pub mod non_circular;

pub mod flank_file;

mod bevel_plot;

mod bevel_flank_plot;

mod bevel_mesh_plot;

mod pair_view;

mod gear_cut_plot;

mod surface_view;

mod turning_view;

pub mod gear_sheet;

mod bevel_stability;

mod bevel_mesh;

mod bevel_contact;

pub mod bevel;

pub mod transmission_plots;

pub mod transmission;

mod correction_plot;

pub mod correction;

pub mod gear_cut;

pub mod gear_plan;

pub mod gear_reversal;

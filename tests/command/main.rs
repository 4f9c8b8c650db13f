//! The command as a person uses it: answers, exit codes, documents, files.
#![cfg(feature = "cli")]

#[path = "../support/mod.rs"]
mod support;

mod accuracy_motion;
mod accuracy_ways;
mod acquired_logs;
mod checked_scenes;
mod chromium;
mod commands;
mod firefox;
mod free_decay;
mod gear_bevel;
mod gear_bevel_blanks;
mod gear_bevel_design;
mod gear_command;
mod gear_correct;
mod gear_cut;
mod gear_non_circular;
mod gear_outline;
mod gear_reverse;
mod gear_space;
mod hopeless;
mod hostile;
mod identify_command;
mod large_machines;
mod log_commands;
mod machine_lines;
mod measure_command;
mod measured_logs;
mod measured_shapes;
mod motion_commands;
mod motor_to_noise;
mod on_the_fly;
mod output_files;
mod page_print;
mod pages;
mod response_command;
mod roving;
mod sensitivity;
mod several_inputs;
mod spectrum_command;
mod te_log_command;
mod threads;

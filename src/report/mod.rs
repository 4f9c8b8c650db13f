//! Results as tables, JSON, CSV and pictures. Computes nothing.

/// Columns of numbers.
pub mod number;

/// The surface of every picture.
pub mod style;

/// Axes of curves over frequency.
pub mod axes;

/// Frequency responses as pictures.
pub mod bode;

/// Poles as pictures.
pub mod poles_picture;

/// Spectra as pictures.
pub mod lines_picture;

/// Singular values, bells and decays as a picture.
pub mod decomposition_picture;

/// Levels over time and frequency as a picture.
pub mod map_picture;

/// Frequencies over speed, as a picture.
pub mod campbell_picture;

/// Campbell diagrams.
pub mod campbell;

/// Modes in words.
pub mod words;

/// State-space forms and reduced machines.
pub mod systems;

/// JSON documents.
pub mod json;

/// What was understood of a log.
pub mod recording;

/// Modes in the course of a record.
pub mod mode_course;

/// What was identified from a log.
pub mod identified;

/// Spectra of a log.
pub mod spectra;

/// Encoder records.
pub mod encoders;

/// Encoder records as pictures.
pub mod encoders_picture;

/// CSV files.
pub mod csv;

/// Order cuts of measured run-ups.
pub mod order_cuts;

/// Motion in time.
pub mod motion;

/// Steady answers to steady excitation.
pub mod response;

/// Amplitude over speed, as a picture.
mod jump_curve;

/// Periodic motions over speed.
pub mod harmonic_balance;

/// Run-up maps.
pub mod run_up;

/// Transmission error of a chain.
pub mod transmission;

/// Error over run time, as a picture.
mod work_precision;

/// What is said of error against run time.
mod accuracy_words;

/// Error against run time of a motion.
pub mod accuracy;

/// What is said of what ways to one answer cost.
mod ways_words;

/// What ways to one answer cost.
pub mod ways;

/// Where methods and machine break.
pub mod stability;

/// Regions of stability as a picture.
pub mod regions;

/// Measured gears.
pub mod measure;

/// Tables for a terminal.
#[cfg(feature = "cli")]
pub mod table;

/// Tables of motion in time.
#[cfg(feature = "cli")]
pub mod motion_table;

/// Sensitivity to the start.
pub mod sensitivity;

/// Its table.
#[cfg(feature = "cli")]
pub mod sensitivity_table;

/// Tables of steady answers.
#[cfg(feature = "cli")]
pub mod response_table;

/// Tables of run-ups.
#[cfg(feature = "cli")]
pub mod run_up_table;

/// Tables of periodic motions over speed.
#[cfg(feature = "cli")]
pub mod harmonic_balance_table;

/// Tables of transmission error.
#[cfg(feature = "cli")]
pub mod transmission_table;

/// Tables of error against run time.
#[cfg(feature = "cli")]
pub mod accuracy_table;

/// Tables of what ways to one answer cost.
#[cfg(feature = "cli")]
pub mod ways_table;

/// Tables of stability.
#[cfg(feature = "cli")]
pub mod stability_table;

/// Tables of measured gears.
#[cfg(feature = "cli")]
pub mod measure_table;

/// Tables of modes in the course of a record.
#[cfg(feature = "cli")]
pub mod mode_course_table;

/// Tables of logs.
#[cfg(feature = "cli")]
pub mod log_tables;

/// Tables of spectra.
#[cfg(feature = "cli")]
pub mod spectrum_table;

/// Order cuts as tables.
#[cfg(feature = "cli")]
pub mod order_cuts_table;

/// Tables of encoder records.
#[cfg(feature = "cli")]
pub mod encoders_table;

/// What was found while a motion ran.
pub mod on_the_fly;

/// The same as tables.
#[cfg(feature = "cli")]
pub mod on_the_fly_table;

/// Tables of state-space forms and reduced machines.
#[cfg(feature = "cli")]
pub mod system_tables;

/// Charts of a gear, unrolled.
pub mod measure_picture;

/// Charts of a gear, round its axis.
pub mod measure_polar;

/// The order of nodes along a train.
pub mod train;

/// Pictures of mode shapes.
pub mod shapes;

/// Where the energy of each mode sits, as a picture.
pub mod energy_bars;

/// Lines, budget and speeds of a transmission error as pictures.
pub mod transmission_pictures;

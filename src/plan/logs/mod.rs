//! What an analysis of a log needs: stages run at most once, a trace kept.

/// Blocks of samples from a recording.
pub mod blocks;

/// The parts of a recording without faults of sensors.
pub mod sound;

/// Samples of the channels named, checked and decimated.
pub mod record;

/// Frequency responses from a stepped sine.
mod dwells;

/// Frequency responses from a recording.
pub mod acquire;

/// Files of other points each, joined.
pub mod points;

/// What the data cannot tell.
pub mod doubts;

/// Modes that may be lines of the mains.
mod mains;

/// Resonances that shift with the level of the hits.
mod linearity;

/// The methods of identification.
pub mod method;

/// What is asked.
pub mod study;

/// Responses that reciprocity makes equal.
pub mod reciprocity;

/// What an identification answers.
pub mod found;

/// Weak modes, and stable columns that are no modes.
pub mod weak;

/// Poles and residues as transfer functions.
mod functions;

/// Poles of a wide band, part by part.
mod parts;

/// Modes from responses to a measured input.
mod modal;

/// A rational fit of measured responses.
mod rational;

/// Modal masses from a driving point.
pub mod scaling;

/// Lines of running speed.
mod running;

/// The answer of a subspace identification.
mod subspace;

/// Modes from responses alone.
mod operational;

/// Modes of free decays.
mod free_decay;

/// Modes from difference equations.
mod series;

/// Modes that change in the course of a record.
mod course;

/// The run of an identification.
pub mod identification;

/// What is asked of a spectrum, and what comes back.
pub mod spectrum_study;

/// Lines that a machine may show.
pub mod expected;

/// Spectra over frequency.
pub mod steady;

/// Spectra over the angle of a shaft.
pub mod turning;

/// Orders over the speed of a run-up.
pub mod order_cuts;

/// The run of a spectrum.
pub mod spectrum;

/// Spectra that a file holds.
pub mod held;

/// Measured orders and what a model declares of them.
pub mod attribution;

/// What is asked of a record of two encoders.
pub mod encoder_study;

/// What the readings of encoders mean.
mod readings;

/// Transmission error from two encoders.
pub mod encoders;

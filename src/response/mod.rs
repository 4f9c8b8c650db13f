//! Steady answers to steady excitation: what a machine does at one frequency, by frequency.

/// What drives and what is measured, by name.
pub mod ports;

/// Powers of s.
mod factor;

/// The dynamic stiffness entry by entry.
mod entries;

/// Coordinates beside motions that are prescribed.
mod coordinates;

/// What inputs push and outputs read.
mod columns;

/// Equations between inputs and outputs.
pub mod system;

/// The dynamic stiffness solved line by line.
pub mod direct;

/// Sums over modes.
pub mod modal;

/// Frequency responses over lists of frequencies.
pub mod frequency;

/// Peaks of a response.
pub mod peaks;

/// The course of responses for pictures.
pub mod course;

/// Strongly nonlinear steady motions over speed.
pub mod harmonic;

/// What excites a running machine.
pub mod excitation;

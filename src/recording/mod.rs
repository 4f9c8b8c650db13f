//! Logs: read as labs write them, put on a uniform time base, every repair reported.
//!
//! The data flow one way: a file is opened (`raw::Raw`: values as written, nothing repaired), its time base is settled
//! (`signals::Recording`: channels with units on a uniform time base), and analyses read blocks of samples from it.

/// What channels measure, by their units.
pub mod quantity;

/// Long sequences of samples in bounded memory.
pub mod column;

/// Names of channels with units in them.
pub mod names;

/// Frequency responses, read or estimated.
pub mod responses;

/// Sample rates that a file states.
pub mod stated_rates;

/// What the last digit of time stamps is worth.
pub mod resolution;

/// A log as written.
pub mod raw;

/// What a reader may be told instead of guessing.
pub mod settings;

/// Delimited text.
pub mod text;

/// MATLAB files of level 5.
pub mod mat;

/// UFF 58 files.
pub mod uff;

/// WAV files.
pub mod wav;

/// LabVIEW measurement files.
pub mod lvm;

/// gzip and zip.
mod container;

/// A log of any format.
pub mod open;

/// The clock of a log.
pub mod time_base;

/// Jittered samples to a uniform time base.
pub mod resample;

/// Channels on a uniform time base.
pub mod signals;

/// From numbers in a file to quantities.
pub mod calibrate;

/// A log as written becomes a recording.
pub mod settle;

/// Several files of one test.
pub mod join;

/// Clipping told from samples.
pub mod clipping;

/// Where sensors clipped or were stuck.
pub mod faults;

/// What a channel looks like.
pub mod survey;

/// Signals and frequency responses to files.
pub mod write;

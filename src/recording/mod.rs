//! Logs: read as labs write them, put on a uniform time base, every repair reported.
//!
//! The data flow one way: a file is opened ([`raw::Raw`]: values as written, nothing repaired), its time base is settled
//! ([`signals::Recording`]: channels with units on a uniform time base), and analyses read blocks of samples from it.

/// Long sequences of samples in bounded memory.
pub mod column;

/// What a reader may be told instead of guessing.
pub mod settings;

/// Frequency responses, read or estimated.
pub mod responses;

/// A log as written.
pub mod raw;

/// Channels on a uniform time base.
pub mod signals;

/// MATLAB files of level 5.
pub mod mat;

/// UFF 58 files.
pub mod uff;

/// WAV files.
pub mod wav;

/// LabVIEW measurement files.
pub mod lvm;

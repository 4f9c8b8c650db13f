//! Log files: file → `RawLog` (values as written) → `Recording` (uniform sample rate); writers.
//!
//! The data flow one way: a file is opened (`raw::RawLog`: values as written, nothing repaired), its time base is settled
//! (`signals::Recording`: channels with units on a uniform time base), and analyses read blocks of samples from it.

pub mod channel_unit;

pub mod sample_column;

pub mod channel_names;

pub mod frequency_responses;

pub mod stated_rates;

mod decimal;

pub mod resolution;

pub mod geometry;

pub mod raw;

pub mod read_options;

pub mod text;

pub mod mat;

pub mod uff;

pub mod wav;

pub mod lvm;

mod compression;

pub mod open;

pub mod time_base;

pub mod resample;

pub mod signals;

pub mod calibrate;

pub mod preprocess;

pub mod join;

pub mod clipping;

pub mod faults;

pub mod channel_statistics;

pub mod write;

mod sidecar_geometry;

pub mod sidecar;

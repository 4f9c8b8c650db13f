//! Operational modal analysis (output-only, broad-band excitation): SSI, FDD, harmonic detection.
//!
//! Subspace identification (`ssi`) finds poles with their uncertainty on a ladder of sample rates; frequency-domain decomposition
//! (`fdd`) finds the peaks of the spectra; `sines`, `harmonics` and `spacing` part lines of running speed from modes.

pub mod response_channels;

pub mod harmonics;

pub mod sines;

pub mod spacing;

pub mod spectral_matrix;

pub mod references;

pub mod covariances;

pub mod decimation_levels;

pub mod realisation;

pub mod selection;

pub mod jackknife;

pub mod merge_levels;

pub mod ssi;

pub mod significant_peaks;

pub mod fdd;

pub mod shared_peaks;

//! What frequencies are in a signal: spectra, frequency response estimators, and what turns with a shaft. On slices and blocks of
//! samples; knows neither files nor machines.

/// Windows and their gains.
pub mod window;

/// Averaged spectra and their random error.
pub mod spectra;

/// Spectra averaged over overlapping blocks.
pub mod welch;

/// Frequency response functions from averaged spectra.
pub mod frf;

/// Pulses of a hammer.
pub mod hits;

/// Frequency responses from hits.
pub mod impact;

/// Spectra of one record by several tapers.
pub mod multitaper;

/// Peaks of a spectrum.
pub mod peaks;

/// Spectra of one record by neighbouring lines.
pub mod sweep;

/// Stepped sines.
pub mod sine;

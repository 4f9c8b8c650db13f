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

/// Frequency responses by local polynomials.
pub mod local;

/// Spectra of one record by neighbouring lines.
pub mod sweep;

/// Sines fitted by least squares.
pub mod sine;

/// How a response settles on a dwell.
pub mod settling;

/// Stepped sines.
pub mod stepped;

/// Sines told from noise.
pub mod tones;

/// What every method asks of its samples first.
mod samples;

/// Linear-phase low-pass filters by Kaiser's window.
pub mod lowpass;

/// Decimation without aliases, in blocks that join exactly.
pub mod decimate;

/// One band of a signal: band-pass, analytic signal, zoom.
pub mod band;

/// Envelope and squared-envelope spectrum.
pub mod envelope;

/// Real and power cepstrum, liftering, rahmonics.
pub mod cepstrum;

/// Spectra by time block.
pub mod spectrogram;

/// Between acceleration, velocity and displacement.
pub mod integrate;

/// Lines of the mains.
pub mod mains;

/// Naming measured lines by what was expected.
pub mod label;

/// What turns with a shaft: tacho, angle, orders, averages over revolutions.
pub mod rotation;

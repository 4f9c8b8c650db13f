//! Spectral analysis of sampled signals: spectra, FRF estimators, filters, order analysis.
//!
//! On slices and blocks of samples; knows neither files nor machines.

pub mod window;

pub mod spectra;

pub mod welch;

pub mod frf;

pub mod force_pulses;

pub mod force_aliasing;

pub mod impact;

pub mod multitaper;

pub mod peaks;

pub mod local_polynomial;

pub mod frequency_smoothing;

pub mod sine;

pub mod settling;

pub mod stepped_sine;

pub mod tones;

mod validation;

pub mod kaiser_fir;

pub mod decimate;

pub mod band;

pub mod envelope;

pub mod cepstrum;

pub mod spectrogram;

pub mod integrate;

pub mod mains;

pub mod line_labels;

pub mod rotation;

//! The signal side: recordings, spectra, identification.

#[path = "../support/mod.rs"]
mod support;

mod departing_responses;
mod folded_responses;
mod geometry;
mod identified_logs;
mod local_responses;
mod log_dialects;
mod log_formats;
mod log_reading;
mod modal_methods;
mod operational;
mod rational_fit;
mod rotation;
mod shipped_recordings;
mod short_noise;
mod spectra;
mod time_series;
mod transfer_functions;
mod uncertainty;

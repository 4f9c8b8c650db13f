//! Modes from responses alone, where what drives the machine is not measured: it is taken as broad-band noise.
//!
//! Subspace identification (`subspace`) gives poles with their uncertainty, order by order; frequency-domain decomposition
//! (`decomposition`) shows the peaks of the spectra; `harmonics` tells running-speed lines from modes.

/// The responses, checked once.
pub mod channels;

/// Lines of running speed.
pub mod harmonics;

/// Covariances between responses over lags.
pub mod covariances;

/// Modes from an extended observability matrix, order by order.
pub mod realisation;

/// What the scatter of the covariances does to the poles.
mod uncertainty;

/// Subspace identification from covariances or from data.
pub mod subspace;

/// Which poles come back order after order.
pub mod selection;

/// Spectral matrices of responses.
pub mod spectral_matrix;

/// Peaks of a density that noise does not make.
pub mod significant;

/// Frequency-domain decomposition.
pub mod decomposition;

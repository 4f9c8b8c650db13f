//! Modes from responses alone, where what drives the machine is not measured: it is taken as broad-band noise.
//!
//! Subspace identification (`subspace`) finds poles with their uncertainty on a ladder of sample rates; frequency-domain decomposition
//! (`decomposition`) finds the peaks of the spectra; `sines`, `harmonics` and `spacing` part lines of running speed from modes.

/// The responses, checked once.
pub mod channels;

/// Lines of running speed.
pub mod harmonics;

/// Sines of constant amplitude.
pub mod sines;

/// Series of evenly spaced lines.
pub mod spacing;

/// Spectral matrices of responses.
pub mod spectral_matrix;

/// Reference channels.
pub mod references;

/// Covariances between responses over lags.
pub mod covariances;

/// Sample rates an octave apart.
pub mod ladder;

/// Modes from an extended observability matrix, order by order.
pub mod realisation;

/// Which poles come back order after order.
pub mod selection;

/// The uncertainty of a pole.
pub mod jackknife;

/// One list of modes from all rungs.
pub mod rungs;

/// Stochastic subspace identification.
pub mod subspace;

/// Peaks of a density that noise does not make.
pub mod significant;

/// Frequency-domain decomposition.
pub mod decomposition;

//! Spectrum study and its result.

use crate::base::error::{Diagnostic, Error};
use crate::recording::preprocess::unknown_channel;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::integrate::MotionQuantity;
use crate::spectrum::line_labels::ExpectedLine;
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::SpectrogramRow;
use crate::spectrum::welch::{Averaging, Detrend};
use crate::spectrum::window::Window;

/// Kind of spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpectrumKind {
    /// Power spectral density, unit²/Hz.
    #[default]
    Density,
    /// Amplitude of tones, zero to peak.
    Amplitude,
    /// Root mean square of tones.
    Rms,
    /// Power spectral density by several tapers of the whole record.
    Multitaper,
    /// Lines of the squared envelope of a band.
    Envelope,
    /// Real cepstrum.
    Cepstrum,
    /// Power spectral density by time.
    Spectrogram,
    /// Amplitude over orders of a shaft.
    Order,
    /// Mean over the turns of a shaft.
    SynchronousAverage,
}

/// The study; what is `None` is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpectrumStudy {
    /// Channels analysed.
    pub channels: Vec<String>,
    /// Kind of spectrum.
    pub kind: SpectrumKind,
    /// Between lines, Hz.
    pub frequency_resolution_hz: Option<f64>,
    /// On each block.
    pub window: Option<Window>,
    /// Share of a block that the next has in common with it.
    pub overlap: Option<f64>,
    /// Over the blocks.
    pub averaging: Averaging,
    /// Off each block.
    pub detrend: Detrend,
    /// Lines shown, Hz or order; the band-pass of an envelope, Hz.
    pub band: Option<(f64, f64)>,
    /// The motion wanted instead of the one measured.
    pub history: Option<MotionQuantity>,
    /// The channel of the tacho.
    pub tacho: Option<String>,
    /// Pulses per revolution.
    pub pulses_per_rev: usize,
    /// A steady speed, rad/s.
    pub speed: Option<f64>,
    /// Turns in a block of an order spectrum or cut.
    pub revolutions: Option<usize>,
    /// Orders to cut, cycles a turn.
    pub cuts: Vec<f64>,
    /// Only what does not repeat is analysed.
    pub separate: bool,
    /// Lines that may be there, Hz; orders where the spectrum is one of orders.
    pub expected_lines: Vec<ExpectedLine>,
}

/// Kind of abscissa of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AbscissaKind {
    /// Hz.
    Frequency,
    /// Cycles a turn.
    Order,
    /// s.
    Quefrency,
    /// Degrees of a turn.
    Angle,
}

impl AbscissaKind {
    /// Label of the abscissa and its unit.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            AbscissaKind::Frequency => ("frequency", "Hz"),
            AbscissaKind::Order => ("order", ""),
            AbscissaKind::Quefrency => ("quefrency", "s"),
            AbscissaKind::Angle => ("angle", "deg"),
        }
    }
}

/// A line of a spectrum.
#[derive(Debug, Clone)]
pub struct LabelledPeak {
    /// Between the lines: Hz, order or s.
    pub position: f64,
    /// Height of the curve there, in its unit.
    pub value: f64,
    /// Amplitude of a tone that would make it, zero to peak (root mean square on request).
    pub amplitude: f64,
    /// Power over that of the floor; `None` for cepstra.
    pub signal_to_noise: Option<f64>,
    /// True if the line is above the noise level.
    pub significant: bool,
    /// Candidate names, the nearest first; more than one where the measurement cannot distinguish them.
    pub names: Vec<String>,
}

/// The spectrum of one channel.
#[derive(Debug, Clone)]
pub struct ChannelSpectrum {
    /// The channel.
    pub channel: String,
    /// Unit of the values.
    pub unit: String,
    /// Unit of amplitudes of its lines.
    pub amplitude_unit: String,
    /// One for each place.
    pub value: Vec<f64>,
    /// Peaks, the strongest first.
    pub peaks: Vec<LabelledPeak>,
    /// Rows over time, for spectrograms; over the abscissa of the result.
    pub spectrogram_rows: Vec<SpectrogramRow>,
    /// Speed of the shaft in the middle of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
}

/// Spectra and how they were had.
#[derive(Debug)]
pub struct SpectrumResult {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// In words.
    pub method_text: String,
    /// Requested kind of spectrum.
    pub kind: SpectrumKind,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// Places, rising.
    pub abscissa: Vec<f64>,
    /// One for each channel.
    pub channel_spectra: Vec<ChannelSpectrum>,
    /// Between these quefrencies families of lines were looked for, s.
    pub quefrency_range_s: Option<(f64, f64)>,
    /// Between one place and the next.
    pub abscissa_step: f64,
    /// Independent averages.
    pub averages: Option<f64>,
    /// Between which multiples of a density the true one lies with 95 %.
    pub interval: Option<(f64, f64)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// The spectrum of a channel before it is shown: density, or half the square of an amplitude with a bandwidth of one.
pub struct SpectrumEstimate {
    /// In words.
    pub method_text: String,
    /// Kind of abscissa.
    pub abscissa_kind: AbscissaKind,
    /// One channel's density each.
    pub spectra: Spectra,
    /// By time, for spectrograms.
    pub spectrogram_rows: Vec<Vec<SpectrogramRow>>,
    /// Speed of the shaft in the middle of each row, rad/s; empty without a shaft.
    pub speed: Vec<f64>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// A channel by its name.
///
/// # Errors
/// There is none of that name.
pub fn channel<'r>(recording: &'r Recording, name: &str) -> Result<&'r Channel, Error> {
    recording.channel(name).ok_or_else(|| {
        let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
        unknown_channel(name, &known)
    })
}

//! Flags of `spectrum`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::log::LogArgs;
use super::output::OutputArgs;

/// Arguments of `spectrum`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the spectra, one column a channel")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the spectra with their lines named; spectrograms as a map over time (over speed with --tacho) and frequency")))]
pub struct SpectrumArgs {
    /// A log of signals, or a file of spectra; several logs of one test, or a sidecar that lists them (`files`), are averaged together;
    /// files, no pipes
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Channels analysed
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',', required = true)]
    pub channel: Vec<String>,
    /// What kind of spectrum
    #[arg(long, value_enum, default_value_t = SpectrumKindArg::Psd)]
    pub kind: SpectrumKindArg,
    /// Lines shown, LOW:HIGH (Hz where bare; orders with --kind order); with --kind envelope the band whose envelope is taken
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Between lines (Hz where bare); chosen from the length of the record where left out
    #[arg(long, value_name = "FREQUENCY", allow_negative_numbers = true)]
    pub resolution: Option<String>,
    /// Window on each block: rectangular, hann, hamming, flat-top, blackman-harris, kaiser:BETA; hann where left out
    #[arg(long, value_name = "WINDOW")]
    pub window: Option<String>,
    /// Share of a block that the next has in common with it
    #[arg(long, value_name = "SHARE")]
    pub overlap: Option<f64>,
    /// Over the blocks: linear, exponential:N (N blocks), peak-hold
    #[arg(long, value_name = "WAY", default_value = "linear")]
    pub average: String,
    /// What is taken off each block
    #[arg(long, value_enum, default_value_t = DetrendArg::Mean)]
    pub detrend: DetrendArg,
    /// The motion shown, from the one that the unit of the channel tells
    #[arg(long = "as", value_enum, value_name = "MOTION")]
    pub motion: Option<MotionQuantityArg>,
    /// Only what does not repeat: tones are predicted and taken off first
    #[arg(long)]
    pub separate: bool,
    /// The channel of a tacho, for orders and for a map over speed
    #[arg(
        long,
        value_name = "CHANNEL",
        conflicts_with = "speed",
        help_heading = "The shaft"
    )]
    pub tacho: Option<String>,
    /// Pulses of it a turn
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        requires = "tacho",
        help_heading = "The shaft"
    )]
    pub pulses: usize,
    /// Steady speed of the shaft (rpm where bare)
    #[arg(long, value_name = "SPEED", help_heading = "The shaft")]
    pub speed: Option<String>,
    /// Orders to cut (cycles a turn of the shaft), with --kind order-cut
    #[arg(
        long,
        value_name = "ORDERS",
        value_delimiter = ',',
        help_heading = "The shaft"
    )]
    pub orders: Vec<f64>,
    /// Turns in a block of an order spectrum or an order cut
    #[arg(long, value_name = "N", help_heading = "The shaft")]
    pub turns: Option<usize>,
    /// A machine whose shafts and meshes give lines their names
    #[arg(
        long,
        value_name = "MODEL",
        requires = "at",
        help_heading = "The shaft"
    )]
    pub model: Option<PathBuf>,
    /// The node of it that turns at --speed, or that the tacho is on
    #[arg(
        long,
        value_name = "NODE",
        requires = "model",
        help_heading = "The shaft"
    )]
    pub at: Option<String>,
    /// A rolling bearing on the shaft: rolling elements, their diameter and that of the pitch circle (mm where bare), contact angle (deg where bare)
    #[arg(long, value_name = "n,d,D,angle", help_heading = "The shaft")]
    pub bearing: Option<String>,
    /// What may be said of the log.
    #[command(flatten)]
    pub log: LogArgs,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Words for kinds of spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SpectrumKindArg {
    /// Power spectral density
    Psd,
    /// Amplitude of tones, zero to peak
    Amplitude,
    /// Root mean square of tones
    Rms,
    /// Power spectral density of the whole record by several tapers
    Multitaper,
    /// Lines of the squared envelope of --band
    Envelope,
    /// Real cepstrum
    Cepstrum,
    /// Power spectral density by time; by speed with --tacho
    Spectrogram,
    /// Amplitude over orders of a shaft
    Order,
    /// Mean over the turns of a shaft
    Average,
    /// Amplitude and phase of --orders over the speed of a run-up
    OrderCut,
}

/// Words for what is taken off a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DetrendArg {
    /// Nothing
    None,
    /// Its mean
    Mean,
    /// Its straight line
    Linear,
}

/// Words for motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MotionQuantityArg {
    /// m/s² or rad/s²
    Acceleration,
    /// m/s or rad/s
    Velocity,
    /// m or rad
    Displacement,
}

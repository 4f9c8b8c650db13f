//! Flags of `spectrum`.

use std::path::PathBuf;

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, text, word};
use super::log::LogArgs;
use super::output::OutputArgs;
use crate::plan::logs::spectrum_study::SpectrumKind;
use crate::spectrum::integrate::MotionQuantity;
use crate::spectrum::welch::Detrend;

/// Arguments of `spectrum`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the spectra, one column per channel")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the spectra with their lines named; spectrograms as a map over time (over speed with --tacho) and frequency")))]
pub struct SpectrumArgs {
    /// A log of signals, or a file of spectra; several logs of one test, or a sidecar that lists them (`files`), are averaged together;
    /// no pipes
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Keys of the study.
    #[command(flatten)]
    pub study: KeyFlags<SpectrumKeys>,
    /// A machine whose shafts and meshes name the lines
    #[arg(
        long,
        value_name = "MODEL",
        requires = "at",
        help_heading = "The shaft"
    )]
    pub model: Option<PathBuf>,
    /// Node of the model that turns at --speed or carries the tacho
    #[arg(
        long,
        value_name = "NODE",
        requires = "model",
        help_heading = "The shaft"
    )]
    pub at: Option<String>,
    /// A rolling bearing on the shaft: rolling elements, their diameter and that of the pitch circle (default unit mm), contact angle (default unit deg)
    #[arg(long, value_name = "n,d,D,angle", help_heading = "The shaft")]
    pub bearing: Option<String>,
    /// Keys of the log.
    #[command(flatten)]
    pub log: LogArgs,
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Keys of a study of spectra.
#[derive(Debug)]
pub struct SpectrumKeys;

impl KeyTable for SpectrumKeys {
    const KEYS: KeyGroups = &[(None, SPECTRUM), (Some("The shaft"), SHAFT)];
}

#[rustfmt::skip]
const SPECTRUM: &[Key] = &[
    list("channel", "CHANNELS", "Channels analysed").required(),
    word::<Option<SpectrumKind>>("kind", "KIND", "Kind of spectrum; default psd"),
    number("band", "A:B", "Band shown, LOW:HIGH (default unit Hz; orders with --kind order); with --kind envelope the band demodulated"),
    number("resolution", "FREQUENCY", "Frequency resolution (default unit Hz); by default chosen from the length of the record"),
    text("window", "WINDOW", "Window on each block: rectangular, hann, hamming, flat-top, blackman-harris, kaiser:BETA; default hann"),
    number("overlap", "SHARE", "Overlap of consecutive blocks, as a share of a block"),
    text("average", "WAY", "Averaging over blocks: linear (default), exponential:N (N blocks), peak-hold"),
    word::<Detrend>("detrend", "DETREND", "Trend removed from each block; default its mean"),
    word::<MotionQuantity>("as", "MOTION", "Quantity shown: displacement, velocity or acceleration, converted from the channel's unit"),
    switch("separate", "Only the random part: tones are predicted and subtracted first"),
];

#[rustfmt::skip]
const SHAFT: &[Key] = &[
    text("tacho", "CHANNEL", "Tacho channel, for orders and for a map over speed"),
    number("pulses", "N", "Pulses per revolution; default 1"),
    number("speed", "SPEED", "Steady speed of the shaft (default unit rpm)"),
    list("orders", "ORDERS", "Orders to cut (cycles per turn of the shaft), with --kind order-cut"),
    number("turns", "N", "Turns in a block of an order spectrum or an order cut"),
];

//! Command-line flags of `identify`: files, study keys, log keys and exports.

use std::path::PathBuf;

use clap::Args;

use super::keys::{
    Key, KeyFlags, KeyGroups, KeyTable, list, number, switch, text, word, word_parser,
};
use super::log::LogArgs;
use super::output::OutputArgs;
use crate::base::table_reader::Word;
use crate::identify::rational::DelayModel;
use crate::identify::transfer::realisation::DiscretisationMethod;
use crate::plan::logs::method::IdentificationMethod;
use crate::recording::read_options::Roving;
use crate::scene::study::ResponseQuantity;
use crate::spectrum::frf::Estimator;

/// Arguments of `identify`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the table of modes with their shapes")))]
#[command(mut_arg("svg", |arg| arg.help("Draw the responses, measured and fitted, with coherence; also the complex plane, the poles, the stabilisation diagram, the shapes on the points of the sidecar and the MAC matrix of --compare (FILE-nyquist.svg, FILE-poles.svg, FILE-stabilisation.svg, FILE-shapes.svg, FILE-mac.svg); without input the spectra that the modes were chosen from")))]
pub struct IdentifyArgs {
    /// A log of signals, or a file of frequency responses; several logs of one test, or a sidecar that lists them (`files`), are read
    /// together, each hit and each record separately; no pipes
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Study keys of the identification.
    #[command(flatten)]
    pub study: KeyFlags<IdentifyKeys>,
    /// Each file is another point of the output (roving sensor) or of the input (roving hammer); by default files with equal
    /// channels are hits of one point, files with a unique channel are different points
    #[arg(long, value_parser = word_parser::<Roving>(), value_name = "SIDE", requires = "input")]
    pub roving: Option<Roving>,
    /// Log keys: channels, time axis and units.
    #[command(flatten)]
    pub log: LogArgs,
    /// Compare the modes with those of a document of `modes --json` or `identify --json`: MAC over the channels named as a
    /// component there (`rename` in the sidecar)
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Write the transfer functions and their state space (.json, .csv or .mat)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub export: Option<PathBuf>,
    /// Sampling interval of the exported state space (default unit s)
    #[arg(
        long,
        value_name = "TIME",
        requires = "export",
        help_heading = "Output"
    )]
    pub sample_time: Option<String>,
    /// Sampling of the exported model; default zero-order-hold
    #[arg(long, value_parser = word_parser::<DiscretisationMethod>(), value_name = "MAP", requires = "sample_time", help_heading = "Output")]
    pub map: Option<DiscretisationMethod>,
    /// Write the frequency responses (.csv, .uff or .json)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub frf: Option<PathBuf>,
    /// Output flags: JSON document, files, quiet mode.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Study keys of `identify` that a flag sets.
#[derive(Debug)]
pub struct IdentifyKeys;

impl KeyTable for IdentifyKeys {
    const KEYS: KeyGroups = &[(None, IDENTIFY)];
}

#[rustfmt::skip]
const IDENTIFY: &[Key] = &[
    list("input", "CHANNELS", "Excitation channels (the force); without them modes are identified from the responses alone"),
    list("output", "CHANNELS", "Response channels; default all responses of a file of frequency responses"),
    word::<IdentificationMethod>("method", "METHOD", "Method; default: rational with an input; without one free-decay if every record rings down, otherwise ssi-cov"),
    number("speed", "SPEED", "Speed of the running shaft in a record without input (default unit rpm): its orders are separated from modes"),
    number("band", "A:B", "Band of the fit, LOW:HIGH (default unit Hz); by default where the input has power. Without an input it selects modes of ssi-cov and ssi-data; other methods decimate the signals to it"),
    word::<Estimator>("estimator", "ESTIMATOR", "Estimator: noise on the outputs (h1), on the input (h2), on both (hv); default h1"),
    text("window", "WINDOW", "Window on each block: rectangular, hann, hamming, flat-top, blackman-harris, kaiser:BETA; default hann. On hits: force:SHARE of the block, exponential:END value, rectangular (neither); by default both chosen from the data"),
    number("resolution", "FREQUENCY", "Frequency resolution (default unit Hz); by default chosen from the length of the record"),
    number("overlap", "SHARE", "Overlap of consecutive blocks, as a share of a block"),
    switch("impact", "The input is a hammer; detected from its signal by default"),
    switch("no-impact", "The input is not a hammer").sets("impact").to("false"),
    switch("stepped", "The input is a stepped sine; detected from its signal by default"),
    switch("no-stepped", "The input is not a stepped sine").sets("stepped").to("false"),
    list("dwells", "TIMES", "Dwell times of the stepped sine, FROM:TO after FROM:TO (default unit s, from the first sample); detected from the input by default"),
    number("order", "N", "Number of modes; by default all significant ones"),
    list("driving-point", "CHANNELS", "Driving-point output, at the force and in its direction (INPUT=OUTPUT with several inputs): the first scales the modal masses; with several, reciprocal responses are compared"),
    number("memory", "TIME", "With --method rls: memory time constant (default unit s); by default the one that predicts best"),
    word::<DelayModel>("delay", "DELAY", "Estimate a dead time of the measuring chain; default none"),
    switch("allow-unstable", "Allow unstable poles"),
    switch("all", "List weak modes in the main table"),
    word::<ResponseQuantity>("kind", "KIND", "Kind of the responses, if their units do not determine it"),
];

#[rustfmt::skip]
impl Word for DiscretisationMethod {
    const WORDS: &'static [(&'static str, DiscretisationMethod, &'static str)] = &[
        ("zero-order-hold", DiscretisationMethod::ZeroOrderHold, "Inputs are constant between samples"),
        ("bilinear", DiscretisationMethod::Bilinear, "Tustin's rule"),
        ("impulse", DiscretisationMethod::ImpulseInvariant, "The impulse response is preserved at the samples"),
    ];
}

//! Flags of `identify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::log::LogArgs;

/// Arguments of `identify`.
#[derive(Debug, Args)]
pub struct IdentifyArgs {
    /// A log of signals, or a file of frequency responses; several logs of one test, or a sidecar that lists them (`files`), are read
    /// together, each hit and each record on its own; files, no pipes
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Channels that drive: the force; left out, modes are found from the responses alone
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub input: Vec<String>,
    /// Channels that answer; all responses of a file that holds responses
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub output: Vec<String>,
    /// Of several files each holds another point of the output (a roving sensor) or of the input (a roving hammer); where left out, files
    /// with equal channels are hits of one point, and files with a channel of their own each another point
    #[arg(long, value_enum, value_name = "SIDE", requires = "input")]
    pub roving: Option<RovingWord>,
    /// How modes are found; where left out: rational with an input; without, free-decay where every record rings down, else ssi-cov
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<MethodArg>,
    /// Speed of what turns while nothing drives but noise (rpm where bare): its orders are told from modes
    #[arg(long, value_name = "SPEED", conflicts_with = "input")]
    pub speed: Option<String>,
    /// Lines used, LOW:HIGH (Hz where bare); where the input has power, where left out. Without an input it chooses among the modes of ssi-cov and
    /// ssi-data; for other methods signals are decimated to it
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Where the noise is: on the outputs (h1), on the input (h2), on both (hv)
    #[arg(long, value_enum, default_value_t = EstimatorArg::H1)]
    pub estimator: EstimatorArg,
    /// Window on each block: rectangular, hann, hamming, flat-top, blackman-harris, kaiser:BETA; hann where left out. On hits: force:SHARE
    /// of the block, exponential:END value, rectangular (neither); both chosen from the data where left out
    #[arg(long, value_name = "WINDOW")]
    pub window: Option<String>,
    /// Between lines (Hz where bare); chosen from the length of the record where left out
    #[arg(long, value_name = "FREQUENCY", allow_negative_numbers = true)]
    pub resolution: Option<String>,
    /// Share of a block that the next has in common with it
    #[arg(long, value_name = "SHARE")]
    pub overlap: Option<f64>,
    /// The input is a hammer; seen from its signal where neither is said
    #[arg(long, conflicts_with = "no_impact")]
    pub impact: bool,
    /// The input is no hammer
    #[arg(long)]
    pub no_impact: bool,
    /// The input is a sine that dwells on one frequency after another; seen from its signal where nothing is said
    #[arg(long, conflicts_with_all = ["no_stepped", "impact"])]
    pub stepped: bool,
    /// The input is no stepped sine
    #[arg(long)]
    pub no_stepped: bool,
    /// From when to when the sine dwells, FROM:TO after FROM:TO (s where bare, from the first sample); found in the input where left out
    #[arg(long, value_name = "TIMES", value_delimiter = ',', conflicts_with_all = ["no_stepped", "impact"])]
    pub dwells: Vec<String>,
    /// So many modes instead of as many as are significant
    #[arg(long, value_name = "N")]
    pub order: Option<usize>,
    /// The output where the force acts, along it (INPUT=OUTPUT with several inputs): every mode gets its modal mass, by the first; with
    /// several, points that were driven both ways are compared (reciprocity)
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub driving_point: Vec<String>,
    /// With --method rls: how long a sample counts (s where bare); by what predicts best where left out
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
    pub memory: Option<String>,
    /// Estimate a dead time of the measuring chain
    #[arg(long, value_enum, default_value_t = DelayArg::None)]
    pub delay: DelayArg,
    /// Poles may be unstable
    #[arg(long)]
    pub allow_unstable: bool,
    /// List weak modes in the main table
    #[arg(long)]
    pub all: bool,
    /// What the responses are, where their units do not tell
    #[arg(long, value_enum, value_name = "KIND")]
    pub kind: Option<ResponseFormArg>,
    /// What may be said of the log.
    #[command(flatten)]
    pub log: LogArgs,
    /// Write the transfer functions and their state space (.json, .csv or .mat)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub export: Option<PathBuf>,
    /// Sample the exported state space (s where bare)
    #[arg(
        long,
        value_name = "TIME",
        requires = "export",
        help_heading = "Output"
    )]
    pub sample_time: Option<String>,
    /// How it is sampled
    #[arg(long, value_enum, requires = "sample_time", default_value_t = DiscretisationArg::ZeroOrderHold, help_heading = "Output")]
    pub map: DiscretisationArg,
    /// Write the frequency responses (.csv, .uff or .json)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub frf: Option<PathBuf>,
    /// Write the table of modes with their shapes
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub csv: Option<PathBuf>,
    /// Draw the responses, measured and fitted, with coherence; the complex plane and the poles beside (FILE-nyquist.svg, FILE-poles.svg, FILE-stabilisation.svg); without input what the modes were chosen from
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub svg: Option<PathBuf>,
    /// One JSON document on standard output, nothing else there
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// No warnings, no word about what was done
    #[arg(long, help_heading = "Output")]
    pub quiet: bool,
}

/// Words for what is at another point in every file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum RovingWord {
    /// The force
    Input,
    /// The sensor of the response
    Output,
}

/// Words for methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Common poles by maximum likelihood, with uncertainty
    Rational,
    /// Least-squares complex frequency domain over rising orders
    Plscf,
    /// Least-squares complex exponential over rising orders
    Lsce,
    /// Rational fraction polynomials over rising orders
    Rfp,
    /// A circle through each peak, half power beside it
    Circle,
    /// Poles of vector fitting, refined together, as many as are significant
    VectorFitting,
    /// Poles of barycentric interpolation, refined together, as many as are significant
    Aaa,
    /// No input: stochastic subspace from covariances, with uncertainty
    SsiCov,
    /// No input: stochastic subspace from data
    SsiData,
    /// No input: common poles of free decays, with uncertainty; taken by itself where the record rings down after a release
    FreeDecay,
    /// No input: peaks of the spectral matrix, no damping
    Fdd,
    /// No input: peaks of the spectral matrix, damping from their bells; --svg shows these
    Efdd,
    /// One output, no input: autoregressive
    Ar,
    /// One output, no input: autoregressive, moving average
    Arma,
    /// One input, one output: autoregressive
    Arx,
    /// One input, one output: autoregressive, moving average
    Armax,
    /// One input, one output: noise on the output only
    OutputError,
    /// One output, with or without an input: modes that change in the course of the record, by recursive least squares
    Rls,
}

/// Words for estimators.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EstimatorArg {
    /// Noise on the outputs
    H1,
    /// Noise on the input
    H2,
    /// Noise on both
    Hv,
}

/// Words for delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DelayArg {
    /// None
    None,
    /// One for all responses
    Common,
    /// One for each response
    Each,
}

/// Words for kinds of responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ResponseFormArg {
    /// Displacement over force
    Receptance,
    /// Velocity over force
    Mobility,
    /// Acceleration over force
    Accelerance,
}

/// Words for maps from continuous to sampled models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DiscretisationArg {
    /// Inputs stay between samples
    ZeroOrderHold,
    /// Tustin's rule
    Bilinear,
    /// The impulse response is kept at the samples
    Impulse,
}

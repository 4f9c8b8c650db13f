//! Arguments as typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::log_args::LogArgs;
use super::te_args::TeArgs;

/// Machine dynamics of gear drive trains: models become modes and motion, logs become models.
#[derive(Debug, Parser)]
#[command(
    name = "geardyn",
    version,
    about,
    max_term_width = 100,
    arg_required_else_help = true
)]
#[command(after_help = "Example:\n  geardyn modes models/y2250.toml")]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant, reason = "made once")]
pub enum Command {
    /// Write an annotated model to start from
    #[command(after_help = "Example:\n  geardyn new my_machine.toml")]
    New {
        /// The file to write; it must not exist yet
        file: PathBuf,
    },
    /// Validate models and scenes; say what is understood of logs
    #[command(after_help = "Examples:
  geardyn check models/y2250.toml models/two_disc.toml
  geardyn check data/spindle_impact.csv")]
    Check(CheckArgs),
    /// Explain the word behind an error, a warning or a repair
    #[command(after_help = "Example:\n  geardyn explain contradictory-ratios")]
    Explain {
        /// The word in brackets behind an error or a warning, or before a repair; all of them where left out
        code: Option<String>,
    },
    /// Say what would be computed, what is left out and why, without computing it
    #[command(after_help = "Examples:
  geardyn plan models/y2250.toml --damped
  geardyn plan models/y2250.toml --advise 200 --tolerance 0.01")]
    Plan(PlanArgs),
    /// Natural frequencies, damping, shapes, energies and sensitivities
    #[command(after_help = "Examples:
  geardyn modes models/y2250.toml
  geardyn modes models/y2250.toml --damped --mode 2
  geardyn modes models/uniform_chain.toml --lowest 5 --json
  geardyn modes models/overhung_rotor.toml --campbell 0:12000:61 --svg campbell.svg")]
    Modes(ModesArgs),
    /// Motion in time: histories, extremes, answers to steps
    #[command(after_help = "Examples:
  geardyn simulate examples/linear_chain.toml
  geardyn simulate examples/y2250_step.toml --svg step.svg
  geardyn simulate examples/backlash_pair.toml --method radau5 --tolerance 1e-6
  geardyn simulate examples/linear_chain.toml --until 50 --samples 10000 --spectrum 2048 --no-history")]
    Simulate(SimulateArgs),
    /// Error against run time, of a motion, natural frequencies or responses: every method that applies, against one reference
    #[command(after_help = "Examples:
  geardyn accuracy examples/backlash_pair.toml
  geardyn accuracy models/y2250.toml --of modes --lowest 10
  geardyn accuracy models/y2250.toml --of response --input motor.theta --output cutter_ring.theta --band 1:300
  geardyn accuracy examples/linear_chain.toml --error 1e-9 --svg accuracy.svg")]
    Accuracy(AccuracyArgs),
    /// Where methods and machine break: step limits, parametric stability, the scene at its extremes
    #[command(after_help = "Examples:
  geardyn stability examples/backlash_pair.toml --until 0.005
  geardyn stability examples/smooth_mesh.toml --until 0.005 --speeds 500:12000:200 --svg regions.svg
  geardyn stability examples/smooth_mesh.toml --until 0.005 --speeds 500:12000:200 --over depth=0:4:21 --svg regions.svg")]
    Stability(StabilityArgs),
    /// Frequency responses between torques, transmission errors, base motion and what they move
    #[command(after_help = "Examples:
  geardyn response models/y2250.toml --input motor --output workpiece --band 1:400
  geardyn response models/y2250.toml --input index_drive.te --output workpiece --hold motor --band 1:400 --svg te.svg
  geardyn response models/y2250.toml --run-up 50:3000:120 --svg run_up.svg
  geardyn response examples/backlash_jumps.toml --harmonic-balance 2000:7000:60 --svg jumps.svg")]
    Response(ResponseArgs),
    /// Gear charts and readings: deviations, uncertainty, grades
    #[command(after_help = "Exit code 1 where a value is out of what was asked.

Examples:
  geardyn measure data/index_gear.toml
  geardyn measure data/index_gear.toml --json
  geardyn measure data/index_gear.toml --svg charts.svg")]
    Measure(MeasureArgs),
    /// Transmission error of a chain: which element makes which line at the output, how large, and what cannot be told apart
    #[command(after_help = "Examples:
  geardyn te models/three_stage_chain.toml --output spindle
  geardyn te models/three_stage_chain.toml --output spindle --radius 270mm --speed 1400 --all
  geardyn te examples/y2250_te.toml --svg te.svg --speeds 200:3000:141
  geardyn te models/three_stage_chain.toml --output spindle --record record.csv --window 1
  geardyn te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000
  geardyn te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90 --lines 10000,36000 --model examples/y2250_index_te.toml --at index_gear_1,work_spindle --svg te.svg")]
    Te(TeArgs),
    /// Every study a scene lists
    #[command(after_help = "Example:\n  geardyn run examples/linear_chain.toml")]
    Run(RunArgs),
    /// Frequency responses, transfer functions and modes from a measured log
    #[command(after_help = "Examples:
  geardyn identify data/spindle_impact.csv --input force --output ax,ay
  geardyn identify data/spindle_impact.csv --input force --output ax --export model.mat
  geardyn identify data/spindle_impact.csv --input force --output ax,ay --method plscf")]
    Identify(IdentifyArgs),
    /// Spectra, orders, envelopes and cepstra of a measured log, their lines named
    #[command(after_help = "Examples:
  geardyn spectrum data/spindle_impact.csv --channel ax
  geardyn spectrum data/spindle_impact.csv --channel ax --kind amplitude --svg lines.svg")]
    Spectrum(SpectrumArgs),
    /// A log in another format: CSV, UFF 58 or JSON
    #[command(after_help = "Example:\n  geardyn convert data/spindle_impact.csv --to spindle.uff")]
    Convert(ConvertArgs),
    /// Print completions for a shell
    #[command(after_help = "Example:\n  geardyn completions bash > geardyn.bash")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder
    #[command(after_help = "Example:\n  geardyn man target/man")]
    Man {
        /// The folder; made where it is missing
        folder: PathBuf,
    },
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Models, scenes (.toml) or logs; files, no pipes
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// What may be said of logs.
    #[command(flatten)]
    pub log: LogArgs,
    /// Write what was understood of each log into a sidecar beside it, to be corrected (LOG.toml)
    #[arg(long)]
    pub write: bool,
    /// One JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `identify`.
#[derive(Debug, Args)]
pub struct IdentifyArgs {
    /// A log of signals, or a file of frequency responses; a file, no pipe
    pub file: PathBuf,
    /// Channels that drive: the force; left out, modes are found from the responses alone
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub input: Vec<String>,
    /// Channels that answer; all responses of a file that holds responses
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub output: Vec<String>,
    /// How modes are found; where left out: rational with an input, ssi-cov without
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<MethodWord>,
    /// Speed of what turns while nothing drives but noise (rpm where bare): its orders are told from modes
    #[arg(long, value_name = "SPEED", conflicts_with = "input")]
    pub speed: Option<String>,
    /// Lines used, LOW:HIGH (Hz where bare); where the input has power, where left out. Signals are decimated to it where nothing drives
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Where the noise is: on the outputs (h1), on the input (h2), on both (hv)
    #[arg(long, value_enum, default_value_t = EstimatorWord::H1)]
    pub estimator: EstimatorWord,
    /// Window on each block: rectangular, hann, hamming, flat-top, blackman-harris, kaiser:BETA; hann where left out
    #[arg(long, value_name = "WINDOW")]
    pub window: Option<String>,
    /// Between lines (Hz where bare); chosen from the length of the record where left out
    #[arg(long, value_name = "FREQUENCY")]
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
    /// The output where the force acts, along it (INPUT=OUTPUT with several inputs): every mode gets its modal mass
    #[arg(long, value_name = "CHANNEL")]
    pub driving_point: Option<String>,
    /// With --method rls: how long a sample counts (s where bare); by what predicts best where left out
    #[arg(long, value_name = "TIME")]
    pub memory: Option<String>,
    /// Estimate a dead time of the measuring chain
    #[arg(long, value_enum, default_value_t = DelayWord::None)]
    pub delay: DelayWord,
    /// Poles may be unstable
    #[arg(long)]
    pub allow_unstable: bool,
    /// What the responses are, where their units do not tell
    #[arg(long, value_enum, value_name = "KIND")]
    pub kind: Option<KindWord>,
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
    #[arg(long, value_enum, requires = "sample_time", default_value_t = MapWord::ZeroOrderHold, help_heading = "Output")]
    pub map: MapWord,
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

/// Arguments of `spectrum`.
#[derive(Debug, Args)]
pub struct SpectrumArgs {
    /// A log of signals, or a file of spectra; a file, no pipe
    pub file: PathBuf,
    /// Channels analysed
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',', required = true)]
    pub channel: Vec<String>,
    /// What kind of spectrum
    #[arg(long, value_enum, default_value_t = SpectrumWord::Psd)]
    pub kind: SpectrumWord,
    /// Lines shown, LOW:HIGH (Hz where bare; orders with --kind order); with --kind envelope the band whose envelope is taken
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Between lines (Hz where bare); chosen from the length of the record where left out
    #[arg(long, value_name = "FREQUENCY")]
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
    #[arg(long, value_enum, default_value_t = DetrendWord::Mean)]
    pub detrend: DetrendWord,
    /// The motion shown, from the one that the unit of the channel tells
    #[arg(long = "as", value_enum, value_name = "MOTION")]
    pub motion: Option<MotionWord>,
    /// Only what does not repeat: tones are predicted and taken off first
    #[arg(long)]
    pub separate: bool,
    /// The channel of a tacho, for orders
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
    /// Turns in a block of an order spectrum
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
    /// Write the spectra, one column a channel
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub csv: Option<PathBuf>,
    /// Draw the spectra with their lines named; spectrograms as a map over time and frequency
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub svg: Option<PathBuf>,
    /// One JSON document on standard output, nothing else there
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// No warnings, no word about what was done
    #[arg(long, help_heading = "Output")]
    pub quiet: bool,
}

/// Words for kinds of spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SpectrumWord {
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
    /// Power spectral density by time
    Spectrogram,
    /// Amplitude over orders of a shaft
    Order,
    /// Mean over the turns of a shaft
    Average,
}

/// Words for what is taken off a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DetrendWord {
    /// Nothing
    None,
    /// Its mean
    Mean,
    /// Its straight line
    Linear,
}

/// Words for motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MotionWord {
    /// m/s² or rad/s²
    Acceleration,
    /// m/s or rad/s
    Velocity,
    /// m or rad
    Displacement,
}

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// A log of signals, or a file of frequency responses; a file, no pipe
    pub file: PathBuf,
    /// The file to write (.csv, .uff or .json)
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
    /// Only these channels, in this order
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub channel: Vec<String>,
    /// UFF 58 in bytes, which keeps every bit
    #[arg(long)]
    pub binary: bool,
    /// What may be said of the log.
    #[command(flatten)]
    pub log: LogArgs,
    /// No warnings, no word about what was done
    #[arg(long)]
    pub quiet: bool,
}

/// Words for methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MethodWord {
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
    /// Vector fitting over rising orders
    VectorFitting,
    /// Barycentric interpolation over rising orders
    Aaa,
    /// No input: stochastic subspace from covariances, with uncertainty
    SsiCov,
    /// No input: stochastic subspace from data
    SsiData,
    /// No input: peaks of the spectral matrix, no damping
    Fdd,
    /// No input: peaks of the spectral matrix, damping from their bells
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum EstimatorWord {
    /// Noise on the outputs
    H1,
    /// Noise on the input
    H2,
    /// Noise on both
    Hv,
}

/// Words for delays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DelayWord {
    /// None
    None,
    /// One for all responses
    Common,
    /// One for each response
    Each,
}

/// Words for kinds of responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum KindWord {
    /// Displacement over force
    Receptance,
    /// Velocity over force
    Mobility,
    /// Acceleration over force
    Accelerance,
}

/// Words for maps from continuous to sampled models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MapWord {
    /// Inputs stay between samples
    ZeroOrderHold,
    /// Tustin's rule
    Bilinear,
    /// The impulse response is kept at the samples
    Impulse,
}

/// What is asked of the modes.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Complex modes: damping counts
    #[arg(long)]
    pub damped: bool,
    /// Mean speed of the first node of `[speed]` (rpm where bare); gyroscopic terms count
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// Modes over speed, FIRST:LAST:POINTS (rpm where bare, 50 points where left out), crossed with the orders of every gear
    #[arg(
        long,
        value_name = "A:B:N",
        allow_hyphen_values = true,
        conflicts_with = "speed"
    )]
    pub campbell: Option<String>,
    /// Only the lowest N modes
    #[arg(long, value_name = "N")]
    pub lowest: Option<u32>,
    /// Also the state-space form A, B, C, D, written to FILE (.json, .csv or .mat)
    #[arg(long, value_name = "FILE")]
    pub state_space: Option<PathBuf>,
    /// Inputs of it: freedoms such as motor.theta; all where left out
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "state_space"
    )]
    pub input: Vec<String>,
    /// Outputs of it: motor.theta, motor.theta.speed, motor.theta.acceleration, belt.force
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        requires = "state_space"
    )]
    pub output: Vec<String>,
    /// Sample it (s where bare)
    #[arg(long, value_name = "TIME", requires = "state_space")]
    pub sample_time: Option<String>,
    /// What inputs do between samples
    #[arg(long, value_enum, requires = "sample_time", default_value_t = HoldWord::Zero)]
    pub hold: HoldWord,
    /// Also a reduced machine that keeps --keep, compared with the full one up to --below
    #[arg(long, value_enum, value_name = "METHOD", requires_all = ["keep", "below"])]
    pub reduce: Option<ReduceWord>,
    /// Freedoms kept, loaded and measured
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "reduce")]
    pub keep: Vec<String>,
    /// The band that matters reaches up to here (Hz where bare)
    #[arg(long, value_name = "FREQUENCY", requires = "reduce")]
    pub below: Option<String>,
    /// Where `--reduce dynamic` condenses (Hz where bare)
    #[arg(long, value_name = "FREQUENCY", requires = "reduce")]
    pub condense_at: Option<String>,
    /// Modes kept by craig-bampton and modal; those below twice the band where left out
    #[arg(long, value_name = "N", requires = "reduce")]
    pub keep_modes: Option<u32>,
    /// The modes nearest a frequency (Hz where bare); as many as --lowest says, 20 otherwise
    #[arg(
        long,
        value_name = "FREQUENCY",
        allow_hyphen_values = true,
        conflicts_with = "campbell"
    )]
    pub near: Option<String>,
}

/// Words for holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum HoldWord {
    /// They stay
    Zero,
    /// They go straight to the next sample
    First,
    /// Tustin's rule
    Bilinear,
}

/// Words for reductions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ReduceWord {
    /// Static condensation
    Guyan,
    /// Condensation at --condense-at
    Dynamic,
    /// Static condensation and fixed-interface modes
    CraigBampton,
    /// Modes with a static residual
    Modal,
}

/// What is asked of motion.
#[derive(Debug, Args)]
pub struct MotionArgs {
    /// How long (s where bare)
    #[arg(long, value_name = "TIME")]
    pub until: Option<String>,
    /// Signals: motor.theta, motor.theta.speed, motor.theta.acceleration, belt.force, belt.deflection
    #[arg(long, value_name = "SIGNALS", value_delimiter = ',')]
    pub output: Vec<String>,
    /// Method of integration, chosen from the structure of the machine where left out: exact, switched, periodic; by --tolerance
    /// radau5, exponential, dop853-events, dop853, dopri5, generalized-alpha-controlled; by --step rk4, newmark, hht, generalized-alpha
    #[arg(long, value_name = "METHOD")]
    pub method: Option<String>,
    /// Local error of a step, relative to the size of each state; 1e-8 where left out
    #[arg(long, value_name = "X")]
    pub tolerance: Option<f64>,
    /// Fixed step (s where bare), for methods that go by one
    #[arg(long, value_name = "TIME", conflicts_with = "tolerance")]
    pub step: Option<String>,
    /// Into how many equal parts the outputs divide the time; 1000 where left out
    #[arg(long, value_name = "N")]
    pub samples: Option<u32>,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArgs {
    /// A scene or a model
    pub scene: PathBuf,
    /// What is asked.
    #[command(flatten)]
    pub motion: MotionArgs,
    /// Also the energy balance: stored, put in, lost
    #[arg(long)]
    pub energy: bool,
    /// Found while it runs.
    #[command(flatten)]
    pub running: RunningArgs,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the outputs over time
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the outputs over time
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No word about what was done and left out
    #[arg(long)]
    pub quiet: bool,
}

/// What is found of a motion while it runs.
#[derive(Debug, Args)]
pub struct RunningArgs {
    /// Keep no history of the outputs: however long the motion, memory goes by what is found
    #[arg(long, conflicts_with_all = ["csv", "svg"])]
    pub no_history: bool,
    /// Spectra of the outputs while they run, averaged over blocks of N samples
    #[arg(long, value_name = "N")]
    pub spectrum: Option<u32>,
    /// Orders of the outputs over the angle of a node, such as motor:1,21 or motor:37/12
    #[arg(long, value_name = "NODE:ORDERS")]
    pub track: Option<String>,
    /// Over so many turns each point of the orders is a mean; 8 where left out
    #[arg(long, value_name = "N", requires = "track")]
    pub turns: Option<u32>,
    /// Transmission error of one node against another, as `te` finds it in a log; of the last million samples
    #[arg(long, value_name = "INPUT:OUTPUT")]
    pub te: Option<String>,
    /// Teeth between both, driver first: 21:63 or 21:63,17:40
    #[arg(long, value_name = "PAIRS", requires = "te")]
    pub teeth: Option<String>,
}

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyArgs {
    /// A scene or a model
    pub scene: PathBuf,
    /// What is to be exact
    #[arg(long, value_enum)]
    pub of: Option<SubjectWord>,
    /// Compare so many elastic modes; 10 where left out (with --of modes)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub lowest: Option<u32>,
    /// What drives, such as motor.theta (with --of response; --output measures)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub input: Vec<String>,
    /// Frequencies, LOW:HIGH (Hz where bare; with --of response)
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Lines in the band; 1001 where left out (with --of response)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    pub lines: Option<u32>,
    /// What is asked of the motion.
    #[command(flatten)]
    pub motion: MotionArgs,
    /// Only these methods
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// The error wanted, for which a method is recommended; 1e-6 where left out
    #[arg(long, value_name = "X")]
    pub error: Option<f64>,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the runs
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw error over run time
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No word about what is running
    #[arg(long)]
    pub quiet: bool,
}

/// What `accuracy` compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum SubjectWord {
    /// The motion in time
    Motion,
    /// The lowest natural frequencies
    Modes,
    /// Frequency responses
    Response,
}

/// Arguments of `stability`.
#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// A scene or a model
    pub scene: PathBuf,
    /// What is asked of the motion.
    #[command(flatten)]
    pub motion: MotionArgs,
    /// Only these methods
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Speeds of a chart of parametric stability, FIRST:LAST:POINTS (rpm where bare)
    #[arg(long, value_name = "A:B:N", allow_hyphen_values = true)]
    pub speeds: Option<String>,
    /// A second axis of that chart, factors on what the scene has: depth (of stiffness waves) or damping
    #[arg(long, value_name = "depth=A:B:N")]
    pub over: Option<String>,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Draw the stability regions of explicit methods with the eigenvalues times the step, and the chart over two axes beside
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

/// Arguments of `response`.
#[derive(Debug, Args)]
pub struct ResponseArgs {
    /// A model or a scene
    pub scene: PathBuf,
    /// What drives: motor.theta (a torque), first_pair.te (a displacement imposed in a branch), ground.x, motor.theta.motion
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub input: Vec<String>,
    /// What is measured: work.theta, work.speed, work.acceleration, "work - 1/27*motor", belt.force, belt.deflection
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub output: Vec<String>,
    /// Freedoms held still, such as the driver's angle
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub hold: Vec<String>,
    /// Frequencies, LOW:HIGH (Hz where bare)
    #[arg(long, value_name = "A:B")]
    pub band: Option<String>,
    /// Lines in the band, both ends included; 1001 where left out
    #[arg(long, value_name = "N")]
    pub lines: Option<u32>,
    /// Motions as displacement, speed or acceleration; as named where left out
    #[arg(long, value_enum, value_name = "KIND")]
    pub kind: Option<ResponseKindWord>,
    /// Mean speed of the first node of `[speed]` (rpm where bare); gyroscopic terms count
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// How; chosen from the machine and the number of lines where left out
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<ResponseWayWord>,
    /// Answers to all orders over speed instead: meshes with sidebands, eccentricities, declared errors; speeds of the first node of
    /// `[speed]` (rpm where bare). Amplitudes are those of declared errors; where none is declared, 1 µm is assumed of every order
    #[arg(long, value_name = "A:B:POINTS", allow_hyphen_values = true, conflicts_with_all = ["input", "band", "lines", "kind", "speed", "method", "harmonic_balance"])]
    pub run_up: Option<String>,
    /// Periodic motions over speed instead, with play, friction and varying stiffness: a balance of orders followed by arc length;
    /// speeds of the first node of `[speed]` (rpm where bare), POINTS bounds the steps. --output takes what `simulate` takes
    #[arg(long, value_name = "A:B:POINTS", allow_hyphen_values = true, conflicts_with_all = ["input", "hold", "band", "lines", "kind", "speed", "method"])]
    pub harmonic_balance: Option<String>,
    /// What higher orders may add to the balance, of the size of the deflections; 1e-6 where left out
    #[arg(long, value_name = "SHARE", requires = "harmonic_balance")]
    pub tolerance: Option<f64>,
    /// So many orders; as many as the tolerance asks where left out
    #[arg(long, value_name = "N", requires = "harmonic_balance")]
    pub orders: Option<u32>,
    /// The balance alone, motions not refined by locating every switch
    #[arg(long, requires = "harmonic_balance")]
    pub orders_alone: bool,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the responses, real and imaginary part, one row a line; or the curve, one row a motion or a speed
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw magnitude and phase, and the complex plane beside (FILE-nyquist.svg); or the jump curve, or the map
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No warnings, no word about what was done
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `measure`.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    /// A TOML file with `[measured_gear]`, which names the CSV files of its charts
    pub file: PathBuf,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the values, one row each
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the charts unrolled, and those that go round beside (FILE-polar.svg)
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No warnings, no word about what was left out
    #[arg(long)]
    pub quiet: bool,
}

/// Words for what a motion is shown as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ResponseKindWord {
    /// Displacement
    Receptance,
    /// Speed
    Mobility,
    /// Acceleration
    Accelerance,
}

/// Words for ways to a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ResponseWayWord {
    /// Solved line by line
    Direct,
    /// A sum over all modes
    Modal,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// A scene
    pub scene: PathBuf,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// No word about what was done and left out
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// What would be asked of it.
    #[command(flatten)]
    pub study: StudyArgs,
    /// Also solve, and offer the freedoms that could follow statically while all frequencies up to here (Hz where bare) keep
    /// within --tolerance
    #[arg(long, value_name = "FREQUENCY")]
    pub advise: Option<String>,
    /// Relative change of a frequency that does not matter
    #[arg(long, value_name = "X", requires = "advise", default_value_t = 1e-3)]
    pub tolerance: f64,
    /// One JSON document on standard output
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `modes`.
#[derive(Debug, Args)]
pub struct ModesArgs {
    /// A model or a scene
    pub model: PathBuf,
    /// What is asked.
    #[command(flatten)]
    pub study: StudyArgs,
    /// Show mode N at length: energies, sensitivities, shape
    #[arg(long, value_name = "N", conflicts_with = "json")]
    pub mode: Option<usize>,
    /// Only the N largest entries of every shape and list in JSON
    #[arg(long, value_name = "N", requires = "json")]
    pub top: Option<usize>,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Write the table of modes with their shapes
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the first 8 mode shapes, and the energies of the first 20 modes beside (FILE-energies.svg); with --campbell the diagram
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// No warnings, no word about what was left out
    #[arg(long)]
    pub quiet: bool,
}

//! Flags of `simulate`, `accuracy` and `stability`, and of `plan` what it shares with them.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// How a motion is integrated, and how long.
#[derive(Debug, Clone, Args)]
pub struct IntegrationArgs {
    /// How long (s where bare)
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub until: Option<String>,
    /// Method of integration, chosen from the structure of the machine where left out: exact, switched, periodic; by --tolerance
    /// radau5, exponential, dop853-events, dop853, dopri5, generalized-alpha-controlled; by --step rk4, newmark, hht, generalized-alpha
    #[arg(long, value_name = "METHOD")]
    pub method: Option<String>,
    /// Local error of a step, relative to the size of each state; 1e-8 where left out
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Fixed step (s where bare), for methods that go by one: equal steps from one known jump of a load to the next, so long at most
    #[arg(
        long,
        value_name = "TIME",
        conflicts_with = "tolerance",
        allow_hyphen_values = true
    )]
    pub step: Option<String>,
    /// Into how many equal parts the outputs divide the time, such as 5000 or 1e6; 1000 where left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = parse_count)]
    pub samples: Option<u32>,
}

/// What is asked of motion.
#[derive(Debug, Args)]
pub struct MotionArgs {
    /// How.
    #[command(flatten)]
    pub integration: IntegrationArgs,
    /// Signals: motor.theta, motor.theta.speed, motor.theta.acceleration, motor.theta.load, belt.force, belt.deflection
    #[arg(long, value_name = "SIGNALS", value_delimiter = ',')]
    pub output: Vec<String>,
}

/// A whole number, also written as 1e6.
fn parse_count(text: &str) -> Result<u32, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    match value {
        n if n.fract() != 0.0 || !n.is_finite() => Err(format!("{text} is no whole number")),
        n if (0.0..=f64::from(u32::MAX)).contains(&n) => Ok(n as u32),
        _ => Err(format!("it takes 1 to {}", u32::MAX)),
    }
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
    /// How long the work may take, such as 5h; 1h where left out. What would take longer is refused with the estimate
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub allow: Option<String>,
    /// Skip the second run that measures the sensitivity to initial conditions and the significant digits
    #[arg(long)]
    pub no_sensitivity: bool,
    /// Found while it runs.
    #[command(flatten)]
    pub running: OnlineArgs,
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
pub struct OnlineArgs {
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
    pub of: Option<AccuracyTargetArg>,
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
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AccuracyTargetArg {
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
    /// Speeds of a chart of parametric stability, FIRST:LAST:POINTS (rpm where bare, 50 points where left out)
    #[arg(long, value_name = "A:B:N", allow_hyphen_values = true)]
    pub speeds: Option<String>,
    /// A second axis of that chart, factors on what the scene has: depth (of stiffness waves) or damping
    #[arg(long, value_name = "depth=A:B:N")]
    pub over: Option<String>,
    /// One JSON document on standard output, nothing else there
    #[arg(long)]
    pub json: bool,
    /// Draw the regions of stability with the eigenvalues times the step, what a step of each method makes of them, and the chart over
    /// two axes beside
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

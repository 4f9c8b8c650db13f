//! Flags of `response`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::output::OutputArgs;

/// Arguments of `response`.
#[derive(Debug, Args)]
#[command(mut_arg("csv", |arg| arg.help("Write the responses, real and imaginary part, one row a line; or the curve, one row a motion or a speed")))]
#[command(mut_arg("svg", |arg| arg.help("Draw magnitude and phase, and the complex plane beside (FILE-nyquist.svg); or the jump curve, or the map")))]
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
    pub kind: Option<FrfFormArg>,
    /// Mean speed of the first node of `[speed]` (rpm where bare); gyroscopic terms count
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    pub speed: Option<String>,
    /// How; chosen from the machine and the number of lines where left out
    #[arg(long, value_enum, value_name = "METHOD")]
    pub method: Option<ResponseMethodArg>,
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
    /// Document, files and silence.
    #[command(flatten)]
    pub out: OutputArgs,
}

/// Words for what a motion is shown as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FrfFormArg {
    /// Displacement
    Receptance,
    /// Speed
    Mobility,
    /// Acceleration
    Accelerance,
}

/// Words for ways to a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ResponseMethodArg {
    /// Solved line by line
    Direct,
    /// A sum over all modes
    Modal,
}

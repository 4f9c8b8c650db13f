//! Flags of `te` for records of two encoders.

use std::path::PathBuf;

use clap::Args;

/// What is said of a record of two encoders.
#[derive(Debug, Args, Default)]
#[command(next_help_heading = "Encoder records")]
pub struct EncoderTeArgs {
    /// Column of the input's encoder; two columns are tracks in quadrature. --output names that of the output
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    pub input: Vec<String>,
    /// Teeth from input to output, driver first: 21:63 or 21:63,17:40
    #[arg(long, value_name = "z1:z2,…")]
    pub teeth: Option<String>,
    /// Lines a turn of both encoders, input first: 5000,5000; not asked for where columns are angles
    #[arg(long, value_name = "N1,N2")]
    pub lines: Option<String>,
    /// Counts that a counter makes of a line
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub counts_per_line: usize,
    /// The columns hold instants of pulses, one a line
    #[arg(long)]
    pub stamps: bool,
    /// Rows are not even in time, such as those taken at steps of angle: no speed is told
    #[arg(long, conflicts_with_all = ["stamps", "rate", "time"])]
    pub angle_base: bool,
    /// Column of the input's index pulse (reference mark, Z track), once a turn; with --stamps its instants
    #[arg(long, value_name = "COLUMN")]
    pub input_index: Option<String>,
    /// Column of the output's index pulse: angles and phases begin at its mark, and the counts between marks are checked
    #[arg(long, value_name = "COLUMN")]
    pub output_index: Option<String>,
    /// Multiples of the meshes looked for; four where the rows hold them
    #[arg(long, value_name = "N")]
    pub harmonics: Option<usize>,
    /// Take the steps of lost or extra counts out
    #[arg(long)]
    pub repair: bool,
    /// Transverse pressure angle (deg where bare): of both flanks it tells the encoder's eccentricity from the gear's
    #[arg(long, value_name = "ANGLE")]
    pub pressure_angle: Option<String>,
    /// A model or a scene whose declared errors, shafts and meshes give orders their names
    #[arg(long, value_name = "MODEL", requires = "at")]
    pub model: Option<PathBuf>,
    /// The nodes of it that the encoders sit on, input first
    #[arg(long, value_name = "NODE,NODE", requires = "model")]
    pub at: Option<String>,
}

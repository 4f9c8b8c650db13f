//! Study of a transmission error recorded by two encoders: channels, teeth, lines, options.

use crate::recording::signals::Recording;
use crate::transmission::encoder::gear_train::GearTrain;

/// Request for the analysis of an encoder record.
#[derive(Debug, Clone)]
pub struct EncoderStudy {
    /// Channel of the input; two of them are the tracks of an encoder in quadrature.
    pub input: Vec<String>,
    /// Channels of the output, likewise.
    pub output: Vec<String>,
    /// Channels of the index pulses of input and output.
    pub index: [Option<String>; 2],
    /// Teeth between the shafts.
    pub teeth: GearTrain,
    /// Lines a turn of both encoders, where the readings are not angles.
    pub lines: Option<(usize, usize)>,
    /// Counts that a counter makes of a line.
    pub counts_per_line: usize,
    /// The channels hold instants of pulses, one a line.
    pub pulse_times: bool,
    /// Rows are not uniform in time: no speed is available.
    pub angle_base: bool,
    /// Multiples of the meshes.
    pub multiples: Option<usize>,
    /// Lost counts are taken out.
    pub repair: bool,
    /// Every multiple of the shafts is fitted.
    pub every: bool,
    /// Radius that turns an angle of the output into a length on the line of action, m.
    pub radius: Option<f64>,
    /// Transverse pressure angle of a single pair, rad: tells an encoder's eccentricity from the gear's, of both flanks.
    pub pressure_angle: Option<f64>,
}

/// Recordings of the channels: one for all, or one for each where their rows are their own.
#[derive(Clone, Copy)]
pub struct EncoderRecordings<'r> {
    /// Channels of the input.
    pub input: &'r Recording,
    /// Recording of the output.
    pub output: &'r Recording,
    /// Index pulses of either.
    pub index: [Option<&'r Recording>; 2],
}

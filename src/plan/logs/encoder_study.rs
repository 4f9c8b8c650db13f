//! Study of a transmission error recorded by two encoders: channels, teeth, lines, options.

use std::path::PathBuf;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity::truncate;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::encoder::gear_train::GearTrain;
use crate::recording::signals::Recording;

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
    /// Model whose errors, shafts and meshes name the orders, and the nodes of it that the encoders are on.
    pub model: Option<(PathBuf, [String; 2])>,
}

/// Counts of a line by default: every edge of two tracks in quadrature.
pub const COUNTS_PER_LINE: usize = 4;

/// Counts of a line at most.
const MAX_COUNTS: u32 = 65_536;

impl EncoderStudy {
    /// Reads its keys; `None` without teeth, which is noted.
    pub fn read(f: &mut TableReader) -> Option<EncoderStudy> {
        f.exclusive("stamps", "angle_base");
        for (key, other) in [("model", "at"), ("at", "model")] {
            f.requires(key, other);
        }
        let columns = |f: &mut TableReader, key: &str, shaft: &str| {
            let listed = f.texts(key);
            let columns = listed.iter().flat_map(|text| text.split(','));
            let columns: Vec<String> = columns.map(|column| column.trim().to_string()).collect();
            match columns.len() {
                0 => report_unstated(f, &format!("the encoder column of the {shaft} is"), key),
                1 | 2 => {}
                _ => f.report_key(
                    Code::Usage,
                    key,
                    "an encoder has one column, or two tracks",
                    "",
                ),
            }
            columns
        };
        let (input, output) = (columns(f, "input", "input"), columns(f, "output", "output"));
        let index =
            ["input_index", "output_index"].map(|key| f.optional_text(key).map(str::to_string));
        let shafts = || input.iter().chain(&output);
        let marks: Vec<&String> = index.iter().flatten().collect();
        if input.iter().any(|column| output.contains(column)) {
            let message = "one column is named as input and as output";
            f.report_key(
                Code::Usage,
                "output",
                message,
                "name separate columns for the encoders",
            );
        } else if shafts().any(|s| marks.contains(&s)) || (marks.len() == 2 && marks[0] == marks[1])
        {
            let hint = "name the separate column of the index pulse, such as wheel_z";
            let key = if index[1].is_some() {
                "output_index"
            } else {
                "input_index"
            };
            f.report_key(Code::Usage, key, "one column is named twice", hint);
        }
        let teeth = f.parsed("teeth", |text, _| GearTrain::parse(text));
        if !f.has("teeth") {
            report_unstated(f, "the teeth between the encoders are", "teeth");
        }
        let at = f.parsed("at", parse_two_nodes);
        let model = f.optional_text("model").map(PathBuf::from);
        let count = |f: &mut TableReader, key: &str| {
            f.optional_count(key, 1, MAX_COUNTS)
                .map(|count| count as usize)
        };
        Some(EncoderStudy {
            lines: f.parsed("lines", parse_encoder_lines),
            counts_per_line: count(f, "counts_per_line").unwrap_or(COUNTS_PER_LINE),
            pulse_times: f.flag("stamps"),
            angle_base: f.flag("angle_base"),
            multiples: count(f, "harmonics"),
            repair: f.flag("repair"),
            every: false,
            radius: f.optional_quantity("radius", QuantityKind::Length, ValueRange::Positive),
            pressure_angle: f.optional_quantity("pressure_angle", QuantityKind::Angle, ANGLES),
            model: model.zip(at),
            teeth: teeth?,
            input,
            output,
            index,
        })
    }
}

fn report_unstated(f: &mut TableReader, what: &str, key: &str) {
    const EXAMPLE: &str =
        "input = \"motor\", output = \"spindle\", teeth = \"21:63\", lines = \"5000,5000\"";
    let (message, span) = (format!("{what} not stated: `{key}`"), f.span.clone());
    f.report(Code::Usage, message, &span, EXAMPLE);
}

/// Pressure angles, rad.
const ANGLES: ValueRange = ValueRange::Open(0.05, 1.2, "a pressure angle, such as 20 deg");

/// `N1,N2`: one number for two encoders would be a guess.
fn parse_encoder_lines(text: &str, subject: &str) -> Result<(usize, usize), Error> {
    const MAX_COUNT: usize = 100_000_000;
    let number = |t: &str| {
        t.trim()
            .parse()
            .ok()
            .filter(|n| (1..=MAX_COUNT).contains(n))
    };
    let two = text
        .split_once(',')
        .and_then(|(a, b)| Some((number(a)?, number(b)?)));
    two.ok_or_else(|| {
        let message = match number(text) {
            Some(n) => format!("{subject} is one number, {n}, but there are two encoders"),
            None => format!("\"{}\" is not a pair of line counts", truncate(text)),
        };
        let hint = format!("{subject} takes the lines per turn of both, input first: 5000,5000");
        Error::new(Code::Usage, message).with_hint(hint)
    })
}

fn parse_two_nodes(text: &str, subject: &str) -> Result<[String; 2], Error> {
    let two = text.split_once(',');
    let nodes = two.map(|(a, b)| [a, b].map(|node| node.trim().to_string()));
    nodes.ok_or_else(|| {
        let message = format!("\"{}\" does not name two nodes", truncate(text));
        let hint = format!(
            "{subject} takes the nodes of both encoders, input first: index_gear_1,work_spindle"
        );
        Error::new(Code::Usage, message).with_hint(hint)
    })
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

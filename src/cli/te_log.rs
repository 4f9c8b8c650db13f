//! `geardyn te LOG`: transmission error from the encoders of two shafts.

use std::path::{Path, PathBuf};

use clap::Args;

use super::log_args::LogArgs;
use super::{diagnostic, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::kind::Kind;
use crate::base::units;
use crate::numeric::fraction::Fraction;
use crate::plan::logs::encoders::{EncoderRecord, EncoderStudy, encoders};
use crate::recording::raw::{Raw, Repair};
use crate::recording::settings::{RateSource, Settings};
use crate::recording::signals::Recording;
use crate::recording::{names, settle};
use crate::report;
use crate::transmission::measured::teeth::Teeth;

/// What is said of a record of two encoders.
#[derive(Debug, Args, Default)]
#[command(next_help_heading = "Encoder records")]
pub struct EncoderArgs {
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
    /// Multiples of the meshes looked for; four where the rows hold them
    #[arg(long, value_name = "N")]
    pub harmonics: Option<usize>,
    /// Take the steps of lost or extra counts out
    #[arg(long)]
    pub repair: bool,
    /// Transverse pressure angle (deg where bare): of both flanks it tells the encoder's eccentricity from the gear's
    #[arg(long, value_name = "ANGLE")]
    pub pressure_angle: Option<String>,
}

/// What `te` says of any file.
pub struct Common<'a> {
    /// The log.
    pub file: &'a Path,
    /// Column of the output, or two of them.
    pub output: Option<&'a str>,
    /// Radius on the line of action.
    pub radius: Option<&'a str>,
    /// Every order is shown.
    pub all: bool,
    /// One JSON document.
    pub json: bool,
    /// Where the record goes.
    pub csv: Option<&'a PathBuf>,
    /// Where the picture goes.
    pub svg: Option<&'a PathBuf>,
    /// No word beside.
    pub quiet: bool,
}

/// Whether a file is a log: all that is no TOML, and whatever teeth are stated of.
pub fn is_log(file: &Path, args: &EncoderArgs) -> bool {
    let toml = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    !toml || args.teeth.is_some()
}

/// Evaluates and prints.
///
/// # Errors
/// Whatever is wrong with the flags or the log.
pub fn run(common: &Common, args: &EncoderArgs, log: &LogArgs) -> Result<u8, Errors> {
    let mut study = study(common, args)?;
    let outputs: Vec<PathBuf> = [common.csv, common.svg].into_iter().flatten().cloned().collect();
    for (path, end) in [(common.csv, "csv"), (common.svg, "svg")] {
        if let Some(path) = path {
            output::ends(path, &[end])?;
        }
    }
    let (mut settings, sidecar) = log.settings(common.file)?;
    let inputs: Vec<PathBuf> = sidecar.into_iter().chain([common.file.to_path_buf()]).collect();
    output::check(&outputs, &inputs)?;
    if study.stamps || study.angle_base {
        // No column is a clock of rows.
        settings.time_column = Some("none".into());
        settings.rate = Some(RateSource::Hertz(1.0));
    }
    let (found, repairs) = evaluated(common, &mut study, settings)?;
    let mut written = Vec::new();
    if let Some(path) = common.csv {
        output::write(path, report::encoders::csv(&found).as_bytes())?;
        written.push(path.display().to_string());
    }
    if let Some(path) = common.svg {
        let name = common.file.file_name().unwrap_or_default().to_string_lossy();
        let picture = report::encoders_picture::record(&found, &name);
        output::write(path, picture.as_bytes())?;
        written.push(path.display().to_string());
    }
    if common.json {
        let document = report::encoders::json(&found, &study.teeth, &repairs);
        output::print(&format!("{document:#}\n"))?;
        return Ok(0);
    }
    output::print(&report::encoders_table::record(&found, common.all))?;
    if !common.quiet {
        output::tell(&epilogue(&found, &repairs, &written));
    }
    Ok(0)
}

/// Reads the log and evaluates it; of pulses each shaft by itself, since their columns differ in length.
fn evaluated(
    common: &Common,
    study: &mut EncoderStudy,
    settings: Settings,
) -> Result<(EncoderRecord, Vec<Repair>), Errors> {
    let open = |only: &[String]| -> Result<(Recording, Vec<String>), Errors> {
        let mut settings = Settings {
            only: only.to_vec(),
            ..settings.clone()
        };
        let raw = progress::open(common.file, &settings, common.quiet)?;
        let full: Vec<String> = only.iter().map(|word| full_name(&raw, word)).collect();
        settings.only.clone_from(&full);
        let recording = settle::settle(raw, &settings)?;
        if !recording.repairs.iter().any(|r| r.kind == "resampled") {
            return Ok((recording, full));
        }
        // Rows at uneven instants are evaluated as they were read: both encoders are read at once.
        settings.time_column = Some("none".into());
        settings.rate = Some(RateSource::Hertz(recording.rate_hz));
        let raw = progress::open(common.file, &settings, common.quiet)?;
        Ok((settle::settle(raw, &settings)?, full))
    };
    let evaluate = |a: &Recording, b: &Recording, study: &EncoderStudy| {
        progress::busy("evaluating", common.quiet, || encoders(a, b, study))
            .map_err(|e| Errors::from(e.in_file(&a.path)))
    };
    let (mut found, recording) = if study.stamps {
        let (a, first) = open(&study.input)?;
        let (b, second) = open(&study.output)?;
        (study.input, study.output) = (first, second);
        (evaluate(&a, &b, study)?, a)
    } else {
        let both: Vec<String> = study.input.iter().chain(&study.output).cloned().collect();
        let (a, full) = open(&both)?;
        let (first, second) = full.split_at(study.input.len());
        (study.input, study.output) = (first.to_vec(), second.to_vec());
        (evaluate(&a, &a, study)?, a)
    };
    found.warnings.splice(0..0, recording.warnings);
    Ok((found, recording.repairs))
}

/// The channel a word means, with or without its unit; the word itself where it means none.
fn full_name(raw: &Raw, word: &str) -> String {
    let all = raw.groups.iter().flat_map(|g| &g.channels);
    let known: Vec<String> = all.map(|c| c.name.clone()).collect();
    names::find(word, &known).map_or(word.to_string(), |at| known[at].clone())
}

fn study(common: &Common, args: &EncoderArgs) -> Result<EncoderStudy, Error> {
    let refuse = |message: &str, hint: &str| Err(Error::new(Code::Usage, message).hint(hint));
    const EXAMPLE: &str =
        "such as: geardyn te run.csv --input motor --output spindle --teeth 21:63 --lines 5000,5000";
    let Some(teeth) = &args.teeth else {
        return refuse("nothing says which teeth lie between the encoders: --teeth", EXAMPLE);
    };
    let Some(output) = common.output else {
        return refuse("nothing says which column is the output's encoder: --output", EXAMPLE);
    };
    if args.input.is_empty() {
        return refuse("nothing says which column is the input's encoder: --input", EXAMPLE);
    }
    let output: Vec<String> = output.split(',').map(|w| w.trim().to_string()).collect();
    if args.input.len() > 2 || output.len() > 2 {
        return refuse("an encoder has one column, or two tracks", EXAMPLE);
    }
    if args.input.iter().any(|i| output.contains(i)) {
        return refuse("one column is named as input and as output", EXAMPLE);
    }
    const COUNTS: std::ops::RangeInclusive<usize> = 1..=65_536;
    if !COUNTS.contains(&args.counts_per_line) || args.harmonics == Some(0) {
        return refuse(
            "--counts-per-line and --harmonics are counts of at least 1",
            "a counter that counts every edge of both tracks makes 4 of a line",
        );
    }
    let quantity = |text: Option<&str>, kind, unit: &str, flag: &str| {
        text.map(|t| units::parse_or_bare(t, kind, unit, flag)).transpose()
    };
    let radius = quantity(common.radius, Kind::Length, "mm", "--radius")?;
    if radius.is_some_and(|r| r <= 0.0) {
        return refuse("--radius takes a length above zero", "the base radius of the output's gear: --radius 94.5");
    }
    let pressure_angle = quantity(args.pressure_angle.as_deref(), Kind::Angle, "deg", "--pressure-angle")?;
    const ANGLES: std::ops::Range<f64> = 0.05..1.2;
    if pressure_angle.is_some_and(|a| !ANGLES.contains(&a)) {
        return refuse("--pressure-angle is no pressure angle", "such as --pressure-angle 20");
    }
    Ok(EncoderStudy {
        input: args.input.clone(),
        output,
        teeth: Teeth::parse(teeth)?,
        lines: args.lines.as_deref().map(lines).transpose()?,
        counts_per_line: args.counts_per_line,
        stamps: args.stamps,
        angle_base: args.angle_base,
        multiples: args.harmonics,
        repair: args.repair,
        radius,
        pressure_angle,
        named: Vec::<(Fraction, String)>::new(),
    })
}

/// `N1,N2`, or one number for both.
fn lines(text: &str) -> Result<(usize, usize), Error> {
    const MOST: usize = 100_000_000;
    let wrong = || {
        let message = format!("\"{}\" are no lines of two encoders", units::shortened(text));
        Error::new(Code::Usage, message).hint("write the lines a turn of both: --lines 5000,5000")
    };
    let number = |t: &str| t.trim().parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(wrong);
    match text.split_once(',') {
        Some((a, b)) => Ok((number(a)?, number(b)?)),
        None => number(text).map(|n| (n, n)),
    }
}

/// What was done to the data, doubts, what was written.
fn epilogue(found: &EncoderRecord, repairs: &[Repair], written: &[String]) -> String {
    let mut text = String::from("\n");
    for repair in repairs {
        text += &format!("{}: {}\n", repair.kind, diagnostic::harmless(&repair.message));
    }
    for warning in &found.warnings {
        text += &diagnostic::warning(warning, diagnostic::colour());
    }
    if !written.is_empty() {
        text += &format!("wrote {}\n", written.join(" "));
    }
    text
}

//! `geardyn te LOG`: transmission error from the encoders of two shafts.

use std::path::{Path, PathBuf};

use super::args::{EncoderTeArgs, TeArgs};
use super::present::Outputs;
use super::progress;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::logs::attribution::EncoderModel;
use crate::plan::logs::encoder_analysis::{EncoderResult, evaluate_encoders};
use crate::plan::logs::encoder_study::{EncoderRecordings, EncoderStudy};
use crate::plan::prepared_machine::PreparedMachine;
use crate::recording::raw::{RawLog, Repair};
use crate::recording::read_options::{RateSource, ReadOptions};
use crate::recording::signals::Recording;
use crate::recording::{channel_names, preprocess};
use crate::report::encoder_te::EncoderReport;
use crate::scene;
use crate::transmission::encoder::gear_train::GearTrain;

/// Whether a file is a log: all that is no TOML, and whatever teeth are stated of.
pub fn is_log(file: &Path, args: &EncoderTeArgs) -> bool {
    let toml = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    !toml || args.teeth.is_some()
}

/// Refuses what is said of a log where the file is a model.
///
/// # Errors
/// Names the flag.
pub fn reject_log_flags(args: &TeArgs) -> Result<(), Error> {
    let record = &args.record;
    let given = [
        (!record.input.is_empty(), "--input"),
        (record.lines.is_some(), "--lines"),
        (record.input_index.is_some(), "--input-index"),
        (record.output_index.is_some(), "--output-index"),
        (record.stamps, "--stamps"),
        (record.angle_base, "--angle-base"),
        (record.harmonics.is_some(), "--harmonics"),
        (record.repair, "--repair"),
        (record.pressure_angle.is_some(), "--pressure-angle"),
        (record.model.is_some(), "--model"),
    ];
    match given.iter().find(|g| g.0) {
        None => Ok(()),
        Some((_, flag)) => Err(Error::new(
            Code::Usage,
            format!(
                "{flag} belongs to records of encoders, and {} is a model",
                args.file.display()
            ),
        )
        .with_hint("of a log, state --teeth as well; of a model, leave it out")),
    }
}

/// Refuses what is said of a model where the file is a log.
fn reject_model_flags(args: &TeArgs) -> Result<(), Error> {
    let given = [
        (args.speeds.is_some(), "--speeds"),
        (args.window.is_some(), "--window"),
        (args.index.is_some(), "--index"),
        (args.output_teeth.is_some(), "--output-teeth"),
        (args.written.is_some(), "--record"),
    ];
    match given.iter().find(|g| g.0) {
        None => Ok(()),
        Some((_, flag)) => {
            let message = format!("{flag} is of models, and {} is a log", args.file.display());
            Err(Error::new(Code::Usage, message).with_hint("leave it out"))
        }
    }
}

/// Evaluates and prints.
///
/// # Errors
/// Whatever is wrong with the flags or the log.
pub fn run(args: &TeArgs) -> Result<u8, Errors> {
    reject_model_flags(args)?;
    let mut study = study(args)?;
    let (mut options, sidecar) = args.log.settings(&args.file)?;
    let inputs: Vec<PathBuf> = sidecar.into_iter().chain([args.file.clone()]).collect();
    let outputs = Outputs::check(&args.out, &[""], &[], &inputs)?;
    if study.pulse_times || study.angle_base {
        // No column is a clock of rows.
        options.time_column = Some("none".into());
        options.rate = Some(RateSource::Hertz(1.0));
    }
    let model = model(args)?;
    let (result, repairs) = read_and_evaluate(args, &mut study, model.as_ref(), options)?;
    let name = args.file.file_name().unwrap_or_default().to_string_lossy();
    outputs.present(&EncoderReport {
        title: format!(
            "{name}: {} by {}, {}",
            study.output.join(" and "),
            study.input.join(" and "),
            args.record.teeth.as_deref().unwrap_or_default()
        ),
        repairs,
        result,
        teeth: study.teeth,
        all: args.all,
    })
}

/// The machine that names the orders, and where the encoders sit in it.
fn model(args: &TeArgs) -> Result<Option<EncoderModel>, Errors> {
    let (Some(path), Some(at)) = (&args.record.model, &args.record.at) else {
        return Ok(None);
    };
    let Some((input, output)) = at.split_once(',') else {
        let message = format!("\"{}\" are no two nodes", quantity::truncate(at));
        return Err(Error::new(Code::Usage, message)
            .with_hint(
                "name the nodes of both encoders, input first: --at index_gear_1,work_spindle",
            )
            .into());
    };
    Ok(Some(EncoderModel {
        machine: PreparedMachine::new(&scene::read(path)?.model)?,
        input: input.trim().to_string(),
        output: output.trim().to_string(),
    }))
}

/// Reads the log and evaluates it; of pulses each shaft by itself, since their columns differ in length.
fn read_and_evaluate(
    args: &TeArgs,
    study: &mut EncoderStudy,
    model: Option<&EncoderModel>,
    options: ReadOptions,
) -> Result<(EncoderResult, Vec<Repair>), Errors> {
    let open = |only: &[String]| -> Result<(Recording, Vec<String>), Errors> {
        let mut options = ReadOptions {
            keep_channels: only.to_vec(),
            ..options.clone()
        };
        let log = progress::open(&args.file, &options, args.out.quiet)?;
        let full: Vec<String> = only.iter().map(|word| full_name(&log, word)).collect();
        options.keep_channels.clone_from(&full);
        let recording = preprocess::preprocess(log, &options)?;
        if !recording.repairs.iter().any(|r| r.kind == "resampled") {
            return Ok((recording, full));
        }
        // Rows at uneven instants are evaluated as they were read: both encoders are read at once.
        options.time_column = Some("none".into());
        options.rate = Some(RateSource::Hertz(recording.rate_hz));
        let log = progress::open(&args.file, &options, args.out.quiet)?;
        Ok((preprocess::preprocess(log, &options)?, full))
    };
    let evaluate = |read: EncoderRecordings, study: &EncoderStudy| {
        progress::with_spinner("evaluating", args.out.quiet, || {
            evaluate_encoders(read, study, model)
        })
        .map_err(|e| Errors::from(e.with_file(&read.input.path)))
    };
    let (mut found, recording) = if study.pulse_times {
        let (a, first) = open(&study.input)?;
        let (b, second) = open(&study.output)?;
        (study.input, study.output) = (first, second);
        let mut marks = [None, None];
        for (name, read) in study.index.iter_mut().zip(&mut marks) {
            if let Some(word) = name {
                let (recording, mut full) = open(std::slice::from_ref(word))?;
                *name = full.pop();
                *read = Some(recording);
            }
        }
        let read = EncoderRecordings {
            input: &a,
            output: &b,
            index: [marks[0].as_ref(), marks[1].as_ref()],
        };
        (evaluate(read, study)?, a)
    } else {
        let shafts = study.input.iter().chain(&study.output);
        let all = shafts.chain(study.index.iter().flatten());
        let (a, full) = open(&all.cloned().collect::<Vec<String>>())?;
        let mut full = full.into_iter();
        let named = study.input.iter_mut().chain(&mut study.output);
        let named = named.chain(study.index.iter_mut().flatten());
        named.zip(&mut full).for_each(|(name, known)| *name = known);
        let read = EncoderRecordings {
            input: &a,
            output: &a,
            index: [0, 1].map(|k| study.index[k].as_ref().map(|_| &a)),
        };
        (evaluate(read, study)?, a)
    };
    found.diagnostics.splice(0..0, recording.diagnostics);
    Ok((found, recording.repairs))
}

/// The channel a word means, with or without its unit; the word itself where it means none.
fn full_name(log: &RawLog, word: &str) -> String {
    let all = log.groups.iter().flat_map(|g| &g.channels);
    let known: Vec<String> = all.map(|c| c.name.clone()).collect();
    channel_names::find_channel(word, &known).map_or(word.to_string(), |at| known[at].clone())
}

fn study(args: &TeArgs) -> Result<EncoderStudy, Error> {
    let refuse = |message: &str, hint: &str| Err(Error::new(Code::Usage, message).with_hint(hint));
    for (given, flag) in [
        (args.driver.is_some(), "--driver"),
        (args.against.is_some(), "--against"),
        (args.speed.is_some(), "--speed"),
    ] {
        if given {
            let message = format!(
                "{flag} belongs to models, and {} is a log",
                args.file.display()
            );
            return refuse(
                &message,
                "the shafts of a log are its columns: --input, --output",
            );
        }
    }
    const EXAMPLE: &str = "such as: geardyn te run.csv --input motor --output spindle --teeth 21:63 --lines 5000,5000";
    let Some(teeth) = &args.record.teeth else {
        return refuse(
            "nothing says which teeth lie between the encoders: --teeth",
            EXAMPLE,
        );
    };
    let Some(output) = &args.output else {
        return refuse(
            "nothing says which column is the output's encoder: --output",
            EXAMPLE,
        );
    };
    if args.record.input.is_empty() {
        return refuse(
            "nothing says which column is the input's encoder: --input",
            EXAMPLE,
        );
    }
    let output: Vec<String> = output.split(',').map(|w| w.trim().to_string()).collect();
    if args.record.input.len() > 2 || output.len() > 2 {
        return refuse("an encoder has one column, or two tracks", EXAMPLE);
    }
    if args.record.input.iter().any(|i| output.contains(i)) {
        return refuse("one column is named as input and as output", EXAMPLE);
    }
    let index = [&args.record.input_index, &args.record.output_index].map(Clone::clone);
    let shafts: Vec<&String> = args.record.input.iter().chain(&output).collect();
    let marks: Vec<&String> = index.iter().flatten().collect();
    if marks.iter().any(|m| shafts.contains(m)) || (marks.len() == 2 && marks[0] == marks[1]) {
        return refuse(
            "one column is named twice",
            "the index pulse has a column of its own: --output-index wheel_z",
        );
    }
    const COUNTS: std::ops::RangeInclusive<usize> = 1..=65_536;
    if !COUNTS.contains(&args.record.counts_per_line) || args.record.harmonics == Some(0) {
        return refuse(
            "--counts-per-line and --harmonics are counts of at least 1",
            "a counter that counts every edge of both tracks makes 4 of a line",
        );
    }
    let quantity = |text: Option<&str>, kind, unit: &str, flag: &str| {
        text.map(|t| quantity::parse_or_bare(t, kind, unit, flag))
            .transpose()
    };
    let radius = quantity(
        args.radius.as_deref(),
        QuantityKind::Length,
        "mm",
        "--radius",
    )?;
    if radius.is_some_and(|r| r <= 0.0) {
        return refuse(
            "--radius takes a length above zero",
            "the base radius of the output's gear: --radius 94.5",
        );
    }
    let pressure_angle = quantity(
        args.record.pressure_angle.as_deref(),
        QuantityKind::Angle,
        "deg",
        "--pressure-angle",
    )?;
    const ANGLES: std::ops::Range<f64> = 0.05..1.2;
    if pressure_angle.is_some_and(|a| !ANGLES.contains(&a)) {
        return refuse(
            "--pressure-angle is no pressure angle",
            "such as --pressure-angle 20",
        );
    }
    Ok(EncoderStudy {
        input: args.record.input.clone(),
        output,
        index,
        teeth: GearTrain::parse(teeth)?,
        lines: args
            .record
            .lines
            .as_deref()
            .map(parse_encoder_lines)
            .transpose()?,
        counts_per_line: args.record.counts_per_line,
        pulse_times: args.record.stamps,
        angle_base: args.record.angle_base,
        multiples: args.record.harmonics,
        repair: args.record.repair,
        every: args.all,
        radius,
        pressure_angle,
    })
}

/// `N1,N2`: one number for two encoders would be a guess.
fn parse_encoder_lines(text: &str) -> Result<(usize, usize), Error> {
    const MAX_COUNT: usize = 100_000_000;
    let wrong = || {
        let message = format!(
            "\"{}\" are no lines of two encoders",
            quantity::truncate(text)
        );
        Error::new(Code::Usage, message)
            .with_hint("write the lines a turn of both: --lines 5000,5000")
    };
    let number = |t: &str| {
        t.trim()
            .parse()
            .ok()
            .filter(|n| (1..=MAX_COUNT).contains(n))
            .ok_or_else(wrong)
    };
    match text.split_once(',') {
        Some((a, b)) => Ok((number(a)?, number(b)?)),
        None => {
            let message = format!(
                "--lines {} is one number, and there are two encoders",
                quantity::truncate(text)
            );
            Err(Error::new(Code::Usage, message).with_hint(format!(
                "give two, input first: --lines {text},{text} where both are alike"
            )))
        }
    }
}

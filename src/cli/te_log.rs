//! `geardyn te LOG`: transmission error from the encoders of two shafts.

use std::path::PathBuf;

use super::args::TeArgs;
use super::present::Outputs;
use super::progress;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
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

/// Whether the file is a log: all that is no TOML, and whatever teeth are stated of.
pub fn is_log(args: &TeArgs) -> bool {
    let end = args.file.extension();
    !end.is_some_and(|e| e.eq_ignore_ascii_case("toml")) || args.study.has("teeth")
}

/// Evaluates and prints.
///
/// # Errors
/// Whatever is wrong with the flags or the log.
pub fn run(args: &TeArgs) -> Result<u8, Errors> {
    let mut study = study(args)?;
    let (mut options, sidecar) = args.log.options(&args.file)?;
    let inputs: Vec<PathBuf> = sidecar.into_iter().chain([args.file.clone()]).collect();
    let outputs = Outputs::check(&args.out, &[""], &[], &inputs)?;
    if study.pulse_times || study.angle_base {
        // No column is a clock of rows.
        options.time_column = Some("none".into());
        options.rate = Some(RateSource::Hertz(1.0));
    }
    let model = model(&study)?;
    let (result, repairs) = read_and_evaluate(args, &mut study, model.as_ref(), options)?;
    let name = args.file.file_name().unwrap_or_default().to_string_lossy();
    outputs.present(&EncoderReport {
        title: format!(
            "{name}: {} by {}, {}",
            study.output.join(" and "),
            study.input.join(" and "),
            args.study.flags.text("teeth").unwrap_or_default()
        ),
        repairs,
        result,
        teeth: study.teeth,
        all: args.all,
    })
}

/// The machine that names the orders, and where the encoders sit in it.
fn model(study: &EncoderStudy) -> Result<Option<EncoderModel>, Errors> {
    let Some((path, [input, output])) = study.model.clone() else {
        return Ok(None);
    };
    Ok(Some(EncoderModel {
        machine: PreparedMachine::new(&scene::read(&path)?.model)?,
        input,
        output,
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

fn study(args: &TeArgs) -> Result<EncoderStudy, Errors> {
    let title = "the transmission error of a log";
    let study = (args.study.flags).read(title, None, &[], EncoderStudy::read)?;
    // Without teeth an error was noted.
    let mut study = study.ok_or_else(|| Error::new(Code::Usage, "state the teeth: --teeth"))?;
    study.every = args.all;
    if study.angle_base && (args.log.keys.has("rate") || args.log.keys.has("time")) {
        let message = "--angle-base excludes --rate and --time: its rows have no times";
        return Err(Error::new(Code::Conflict, message).into());
    }
    Ok(study)
}

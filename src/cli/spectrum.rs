//! The command `geardyn spectrum`: frequency or order spectra of a log.

use std::f64::consts::TAU;

use super::args::SpectrumArgs;
use super::present::Outputs;
use super::{logs, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::plan::logs::expected_lines;
use crate::plan::logs::order_cuts;
use crate::plan::logs::spectrum;
use crate::plan::logs::spectrum_study::{SpectrumKind, SpectrumStudy};
use crate::plan::logs::stored_spectra;
use crate::plan::prepared_machine::PreparedMachine;
use crate::recording::channel_names;
use crate::recording::raw::RawLog;
use crate::report::presentation::LogReport;
use crate::scene;
use crate::spectrum::line_labels::{ExpectedLine, RollingBearing};

/// Computes the spectrum of a log and presents it; returns the exit code.
///
/// # Errors
/// Errors of the log, the flags or the model.
pub fn run(args: &SpectrumArgs) -> Result<u8, Errors> {
    let flags = &args.study.flags;
    let mut study = flags.read("a spectrum", None, &[], SpectrumStudy::read)?;
    let logs = logs::open_logs(&args.files, &args.log)?;
    let mut inputs = logs::paths(&logs);
    inputs.extend(args.model.clone());
    let outputs = Outputs::check(&args.out, &[""], &[], &inputs)?;
    study.expected_lines = expected_lines(args, &study)?;
    let selected: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    reject_duplicates(&selected)?;
    let mut settings = logs[0].options.clone();
    settings.keep_channels = selected;
    let log = progress::open(&logs[0].path, &settings, args.out.quiet)?;
    for word in study.channels.iter_mut().chain(&mut study.tacho) {
        *word = full_name(&log, word);
    }
    let selected: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    reject_duplicates(&selected)?;
    let title = logs::title(&args.files);
    if use_file_spectra(&log, &study) {
        if logs.len() > 1 {
            let message = "the file has spectra; only signals of several files can be averaged";
            let error = Error::new(Code::Conflict, message).with_hint("name one file of spectra");
            return Err(error.with_file(&log.path).into());
        }
        let mut result = stored_spectra::analyse_stored(&log.spectra, &study)
            .map_err(|e| e.with_file(&log.path))?;
        result.diagnostics.splice(0..0, log.diagnostics);
        let repairs = log.repairs;
        return outputs.present(&LogReport {
            title,
            repairs,
            result,
        });
    }
    let recording = logs::preprocess(&logs, log, &selected, args.out.quiet)?;
    let (repairs, quiet) = (recording.repairs.clone(), args.out.quiet);
    let warnings = recording.diagnostics.iter().cloned();
    if flags.text("kind") == Some("order-cut") {
        let mut result = progress::with_spinner("cutting orders", quiet, || {
            order_cuts::order_cuts(&recording, &study)
        })?;
        result.diagnostics.splice(0..0, warnings);
        return outputs.present(&LogReport {
            title,
            repairs,
            result,
        });
    }
    let mut result = progress::with_spinner("analysing", quiet, || {
        spectrum::run_spectrum(&recording, &study)
    })?;
    result.diagnostics.splice(0..0, warnings);
    outputs.present(&LogReport {
        title,
        repairs,
        result,
    })
}

/// Whether spectra stored in the file are requested: it contains nothing else, or every channel names one of them.
fn use_file_spectra(log: &RawLog, study: &SpectrumStudy) -> bool {
    let names: Vec<String> = log.spectra.iter().map(|s| s.name.clone()).collect();
    let mut words = study.channels.iter();
    !names.is_empty()
        && (log.groups.is_empty()
            || words.all(|word| channel_names::find_channel(word, &names).is_some()))
}

/// Full name of the channel that `word` denotes, in any case and with or without unit; `word` itself where there is none.
fn full_name(log: &RawLog, word: &str) -> String {
    let channels = log.groups.iter().flat_map(|g| &g.channels);
    let names: Vec<String> = channels.map(|c| c.name.clone()).collect();
    channel_names::find_channel(word, &names).map_or(word.to_string(), |index| names[index].clone())
}

/// Rejects a list with a duplicate channel.
fn reject_duplicates(list: &[String]) -> Result<(), Error> {
    let duplicate = (1..list.len()).find(|&k| list[..k].contains(&list[k]));
    match duplicate {
        Some(k) => Err(Error::new(
            Code::Usage,
            format!("the channel {} is named twice", list[k]),
        )
        .with_hint("name each channel once")),
        None => Ok(()),
    }
}

/// Spectral lines expected from model, speed and bearing.
fn expected_lines(args: &SpectrumArgs, study: &SpectrumStudy) -> Result<Vec<ExpectedLine>, Errors> {
    let in_orders = study.kind == SpectrumKind::Order;
    let Some(turns_per_s) = (match (in_orders, study.speed) {
        (true, _) => Some(1.0),
        (false, speed) => speed.map(|s| s / TAU),
    }) else {
        if args.model.is_some() || args.bearing.is_some() {
            let message = "--model and --bearing need a speed to name lines; none is stated";
            return Err(Error::new(Code::Usage, message)
                .with_hint("state it: --speed 1500; or use --kind order with --tacho")
                .into());
        }
        return Ok(Vec::new());
    };
    let mut lines = match (&args.model, &args.at) {
        (Some(path), Some(at)) => {
            let machine = PreparedMachine::new(&scene::read(path)?.model)?;
            expected_lines::machine_lines(&machine, at, TAU * turns_per_s, in_orders)?
        }
        _ => expected_lines::shaft_lines(turns_per_s),
    };
    if let Some(text) = &args.bearing {
        lines.extend(expected_lines::bearing_lines(&bearing(text)?, turns_per_s)?);
    }
    Ok(lines)
}

/// Parses a rolling bearing from `n,d,D,angle`.
fn bearing(text: &str) -> Result<RollingBearing, Error> {
    let invalid = || {
        Error::new(
            Code::Usage,
            format!("\"{}\" is not a rolling bearing", quantity::truncate(text)),
        )
        .with_hint("--bearing takes the number of rolling elements, their diameter, the pitch diameter and the contact angle: --bearing 9,7.94,39.04,0")
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [rollers, roller, pitch, angle] = parts[..] else {
        return Err(invalid());
    };
    Ok(RollingBearing {
        rollers: rollers.parse().map_err(|_| invalid())?,
        roller_diameter: quantity::parse_or_bare(roller, QuantityKind::Length, "mm", "--bearing")?,
        pitch_diameter: quantity::parse_or_bare(pitch, QuantityKind::Length, "mm", "--bearing")?,
        contact_angle: quantity::parse_or_bare(angle, QuantityKind::Angle, "deg", "--bearing")?,
    })
}

//! `geardyn spectrum`: what frequencies or orders are in a log.

use std::f64::consts::TAU;

use super::args::{DetrendArg, MotionQuantityArg, SpectrumArgs, SpectrumKindArg};
use super::present::Outputs;
use super::{identify, logs, progress};
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
use crate::spectrum::integrate::MotionQuantity;
use crate::spectrum::line_labels::{ExpectedLine, RollingBearing};
use crate::spectrum::welch::{Averaging, Detrend};
use crate::spectrum::window::Window;

/// Analyses and prints.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the model.
pub fn run(args: &SpectrumArgs) -> Result<u8, Errors> {
    let mut study = study(args)?;
    let logs = logs::open_logs(&args.files, &args.log)?;
    let mut inputs = logs::paths(&logs);
    inputs.extend(args.model.clone());
    let outputs = Outputs::check(&args.out, &[""], &[], &inputs)?;
    study.expected_lines = expected_lines(args, &study)?;
    let only: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    reject_duplicates(&only)?;
    let mut settings = logs[0].options.clone();
    settings.keep_channels = only;
    let log = progress::open(&logs[0].path, &settings, args.out.quiet)?;
    for word in study.channels.iter_mut().chain(&mut study.tacho) {
        *word = full_name(&log, word);
    }
    let only: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    reject_duplicates(&only)?;
    let title = logs::title(&args.files);
    if use_file_spectra(&log, &study) {
        if logs.len() > 1 {
            let message = "the file holds spectra; only signals of several files are averaged";
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
    let recording = logs::preprocess(&logs, log, &only, args.out.quiet)?;
    let (repairs, quiet) = (recording.repairs.clone(), args.out.quiet);
    let warnings = recording.diagnostics.iter().cloned();
    if args.kind == SpectrumKindArg::OrderCut {
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

/// Whether what is asked for are spectra that the file holds: it holds nothing else, or all words name one.
fn use_file_spectra(log: &RawLog, study: &SpectrumStudy) -> bool {
    let known: Vec<String> = log.spectra.iter().map(|s| s.name.clone()).collect();
    let mut words = study.channels.iter();
    !known.is_empty()
        && (log.groups.is_empty()
            || words.all(|word| channel_names::find_channel(word, &known).is_some()))
}

/// The channel a word means, with or without its unit, in capitals or not; the word itself where it means none.
fn full_name(log: &RawLog, word: &str) -> String {
    let all = log.groups.iter().flat_map(|g| &g.channels);
    let known: Vec<String> = all.map(|c| c.name.clone()).collect();
    channel_names::find_channel(word, &known).map_or(word.to_string(), |at| known[at].clone())
}

/// Refuses a channel named twice.
fn reject_duplicates(list: &[String]) -> Result<(), Error> {
    let twice = (1..list.len()).find(|&k| list[..k].contains(&list[k]));
    match twice {
        Some(k) => Err(Error::new(
            Code::Usage,
            format!("the channel {} is named twice", list[k]),
        )
        .with_hint("name each channel once")),
        None => Ok(()),
    }
}

fn study(args: &SpectrumArgs) -> Result<SpectrumStudy, Error> {
    let kind = kind(args.kind);
    let resolution = |text: &str| {
        quantity::parse_or_bare(text, QuantityKind::Frequency, "Hz", "--resolution")
            .map(|w| w / TAU)
    };
    let resolution_hz = args.resolution.as_deref().map(resolution).transpose()?;
    let refuse = |message: &str, hint: &str| {
        Err(Error::new(Code::OutOfRange, message.to_string()).with_hint(hint.to_string()))
    };
    if resolution_hz.is_some_and(|r| r <= 0.0) {
        return refuse(
            "--resolution takes a frequency above zero",
            "a quarter of a hertz: --resolution 0.25",
        );
    }
    if args.overlap.is_some_and(|o| !(0.0..1.0).contains(&o)) {
        return refuse(
            "--overlap takes a share of a block, at least 0 and below 1",
            "half of it: --overlap 0.5",
        );
    }
    if args.turns == Some(0) || args.pulses == 0 {
        return refuse(
            "--turns and --pulses are counts of at least 1",
            "such as --pulses 60 --turns 32",
        );
    }
    let speed = |text: &str| quantity::parse_or_bare(text, QuantityKind::Speed, "rpm", "--speed");
    let speed = args.speed.as_deref().map(speed).transpose()?;
    if speed.is_some_and(|s| s <= 0.0) {
        return refuse("--speed takes a speed above zero", "such as --speed 1500");
    }
    let band = match (&args.band, kind) {
        (Some(text), SpectrumKind::Order) => Some(orders(text)?),
        (Some(text), _) => Some(identify::parse_band(text)?),
        (None, _) => None,
    };
    Ok(SpectrumStudy {
        channels: args.channel.clone(),
        kind,
        frequency_resolution_hz: resolution_hz,
        window: args.window.as_deref().map(Window::parse).transpose()?,
        overlap: args.overlap,
        averaging: averaging(&args.average)?,
        detrend: match args.detrend {
            DetrendArg::None => Detrend::None,
            DetrendArg::Mean => Detrend::Mean,
            DetrendArg::Linear => Detrend::Linear,
        },
        band,
        history: args.motion.map(|word| match word {
            MotionQuantityArg::Acceleration => MotionQuantity::Acceleration,
            MotionQuantityArg::Velocity => MotionQuantity::Velocity,
            MotionQuantityArg::Displacement => MotionQuantity::Displacement,
        }),
        tacho: args.tacho.clone(),
        pulses_per_rev: args.pulses,
        speed,
        revolutions: args.turns,
        separate: args.separate,
        cuts: cuts(args)?,
        expected_lines: Vec::new(),
    })
}

fn kind(word: SpectrumKindArg) -> SpectrumKind {
    match word {
        // An order cut is no spectrum and takes its own way.
        SpectrumKindArg::OrderCut => SpectrumKind::default(),
        SpectrumKindArg::Psd => SpectrumKind::Density,
        SpectrumKindArg::Amplitude => SpectrumKind::Amplitude,
        SpectrumKindArg::Rms => SpectrumKind::Rms,
        SpectrumKindArg::Multitaper => SpectrumKind::Multitaper,
        SpectrumKindArg::Envelope => SpectrumKind::Envelope,
        SpectrumKindArg::Cepstrum => SpectrumKind::Cepstrum,
        SpectrumKindArg::Spectrogram => SpectrumKind::Spectrogram,
        SpectrumKindArg::Order => SpectrumKind::Order,
        SpectrumKindArg::Average => SpectrumKind::SynchronousAverage,
    }
}

/// The orders to cut.
fn cuts(args: &SpectrumArgs) -> Result<Vec<f64>, Error> {
    if args.kind != SpectrumKindArg::OrderCut && !args.orders.is_empty() {
        return Err(Error::new(Code::Usage, "--orders does nothing here")
            .with_hint("it is for --kind order-cut"));
    }
    match args.orders.iter().find(|o| !(**o > 0.0 && o.is_finite())) {
        Some(order) => Err(Error::new(
            Code::OutOfRange,
            format!("--orders takes cycles a turn above zero, not {order}"),
        )
        .with_hint("such as --orders 1,2,21.5")),
        None => Ok(args.orders.clone()),
    }
}

/// `linear`, `exponential:N` or `peak-hold`.
fn averaging(word: &str) -> Result<Averaging, Error> {
    let blocks = |text: &str| {
        text.parse()
            .ok()
            .filter(|n: &f64| *n >= 1.0 && n.is_finite())
    };
    match (word, word.strip_prefix("exponential:").and_then(blocks)) {
        ("linear", _) => Ok(Averaging::Linear),
        ("peak-hold", _) => Ok(Averaging::PeakHold),
        (_, Some(n)) => Ok(Averaging::Exponential(n)),
        _ => {
            let message = format!("\"{}\" is no way to average", quantity::truncate(word));
            Err(Error::new(Code::Usage, message).with_hint(
                "--average takes linear, exponential:8 (blocks, at least 1) or peak-hold",
            ))
        }
    }
}

/// `A:B` in orders.
fn orders(text: &str) -> Result<(f64, f64), Error> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let found = text
        .split_once(':')
        .and_then(|(low, high)| number(low).zip(number(high)));
    found
        .filter(|(low, high)| *low >= 0.0 && low < high)
        .ok_or_else(|| {
            let message = format!("\"{}\" is not a band of orders", quantity::truncate(text));
            Error::new(Code::OutOfRange, message).with_hint("--band takes low:high, such as 0.5:40")
        })
}

/// The lines that model, speed and bearing let expect.
fn expected_lines(args: &SpectrumArgs, study: &SpectrumStudy) -> Result<Vec<ExpectedLine>, Errors> {
    let in_orders = study.kind == SpectrumKind::Order;
    let Some(turns_per_s) = (match (in_orders, study.speed) {
        (true, _) => Some(1.0),
        (false, speed) => speed.map(|s| s / TAU),
    }) else {
        if args.model.is_some() || args.bearing.is_some() {
            let message = "--model and --bearing name lines by a speed, and none is stated";
            return Err(Error::new(Code::Usage, message)
                .with_hint("state it: --speed 1500; or take --kind order with --tacho")
                .into());
        }
        return Ok(Vec::new());
    };
    let mut all = match (&args.model, &args.at) {
        (Some(path), Some(at)) => {
            let machine = PreparedMachine::new(&scene::read(path)?.model)?;
            expected_lines::machine_lines(&machine, at, TAU * turns_per_s, in_orders)?
        }
        _ => expected_lines::shaft_lines(turns_per_s),
    };
    if let Some(text) = &args.bearing {
        all.extend(expected_lines::bearing_lines(&bearing(text)?, turns_per_s)?);
    }
    Ok(all)
}

/// `n,d,D,angle`.
fn bearing(text: &str) -> Result<RollingBearing, Error> {
    let wrong = || {
        Error::new(
            Code::Usage,
            format!("\"{}\" is not a rolling bearing", quantity::truncate(text)),
        )
        .with_hint("--bearing takes the number of rolling elements, their diameter, the pitch diameter and the contact angle: --bearing 9,7.94,39.04,0")
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [rollers, roller, pitch, angle] = parts[..] else {
        return Err(wrong());
    };
    Ok(RollingBearing {
        rollers: rollers.parse().map_err(|_| wrong())?,
        roller_diameter: quantity::parse_or_bare(roller, QuantityKind::Length, "mm", "--bearing")?,
        pitch_diameter: quantity::parse_or_bare(pitch, QuantityKind::Length, "mm", "--bearing")?,
        contact_angle: quantity::parse_or_bare(angle, QuantityKind::Angle, "deg", "--bearing")?,
    })
}

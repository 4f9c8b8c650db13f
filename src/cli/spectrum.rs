//! `geardyn spectrum`: what frequencies or orders are in a log.

use std::f64::consts::TAU;
use std::path::PathBuf;

use super::args::{DetrendWord, MotionWord, SpectrumArgs, SpectrumWord};
use super::files::{self, Files};
use super::{epilogue, identify, logs, output, progress};
use crate::base::code::Code;
use crate::base::error::{Error, Errors, Warning};
use crate::base::kind::Kind;
use crate::base::units;
use crate::plan::logs::expected;
use crate::plan::logs::held;
use crate::plan::logs::order_cuts;
use crate::plan::logs::spectrum;
use crate::plan::logs::spectrum_study::{Spectrum, SpectrumKind, SpectrumStudy};
use crate::plan::prepared::Prepared;
use crate::recording::names;
use crate::recording::raw::{Raw, Repair};
use crate::recording::signals::Recording;
use crate::report;
use crate::scene;
use crate::spectrum::integrate::Motion;
use crate::spectrum::label::{Expected, RollingBearing};
use crate::spectrum::welch::{Averaging, Detrend};
use crate::spectrum::window::Window;

/// Analyses and prints.
///
/// # Errors
/// Whatever is wrong with the log, the flags or the model.
pub fn run(args: &SpectrumArgs) -> Result<u8, Errors> {
    let mut study = study(args)?;
    let outputs: Vec<PathBuf> = args.csv.iter().chain(&args.svg).cloned().collect();
    for (path, end) in args
        .csv
        .iter()
        .map(|p| (p, "csv"))
        .chain(args.svg.iter().map(|p| (p, "svg")))
    {
        files::ends(path, &[end])?;
    }
    let logs = logs::named(&args.files, &args.log)?;
    let mut inputs = logs::paths(&logs);
    inputs.extend(args.model.clone());
    let files = Files::new(&outputs, &inputs)?;
    study.expected = expected_lines(args, &study)?;
    let only: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    once(&only)?;
    let mut settings = logs[0].settings.clone();
    settings.only = only;
    let raw = progress::open(&logs[0].path, &settings, args.quiet)?;
    for word in study.channels.iter_mut().chain(&mut study.tacho) {
        *word = full_name(&raw, word);
    }
    let only: Vec<String> = study.channels.iter().chain(&study.tacho).cloned().collect();
    once(&only)?;
    let (mut found, warnings, repairs) = if are_held(&raw, &study) {
        if logs.len() > 1 {
            let message = "the file holds spectra; only signals of several files are averaged";
            let error = Error::new(Code::Conflict, message).hint("name one file of spectra");
            return Err(error.in_file(&raw.path).into());
        }
        let found = held::spectrum(&raw.spectra, &study).map_err(|e| e.in_file(&raw.path))?;
        (found, raw.warnings, raw.repairs)
    } else {
        let recording = logs::settled(&logs, raw, &only, args.quiet)?;
        if args.kind == SpectrumWord::OrderCut {
            return cut(files, args, &recording, &study);
        }
        let found = progress::busy("analysing", args.quiet, || {
            spectrum::spectrum(&recording, &study)
        })?;
        (found, recording.warnings, recording.repairs)
    };
    found.warnings.splice(0..0, warnings);
    let written = written(files, args, &found)?;
    if args.json {
        let document = report::spectra::json(&found, &repairs);
        output::document(&document)?;
        return Ok(0);
    }
    output::print(&report::spectrum_table::spectrum(&found))?;
    if !args.quiet {
        output::tell(&epilogue(&repairs, &found.warnings, &written));
    }
    Ok(0)
}

/// Cuts orders and prints.
fn cut(
    mut files: Files,
    args: &SpectrumArgs,
    recording: &Recording,
    study: &SpectrumStudy,
) -> Result<u8, Errors> {
    let mut found = progress::busy("cutting orders", args.quiet, || {
        order_cuts::order_cuts(recording, study)
    })?;
    found
        .warnings
        .splice(0..0, recording.warnings.iter().cloned());
    if let Some(path) = &args.csv {
        files.write(path, report::order_cuts::csv(&found).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let picture = report::order_cuts::picture(&found, &logs::title(&args.files));
        files.write(path, picture.as_bytes())?;
    }
    let written = files.finish()?;
    if args.json {
        output::document(&report::order_cuts::json(&found, &recording.repairs))?;
        return Ok(0);
    }
    output::print(&report::order_cuts_table::table(&found))?;
    if !args.quiet {
        output::tell(&epilogue(&recording.repairs, &found.warnings, &written));
    }
    Ok(0)
}

/// Whether what is asked for are spectra that the file holds: it holds nothing else, or all words name one.
fn are_held(raw: &Raw, study: &SpectrumStudy) -> bool {
    let known: Vec<String> = raw.spectra.iter().map(|s| s.name.clone()).collect();
    let mut words = study.channels.iter();
    !known.is_empty()
        && (raw.groups.is_empty() || words.all(|word| names::find(word, &known).is_some()))
}

/// The channel a word means, with or without its unit, in capitals or not; the word itself where it means none.
fn full_name(raw: &Raw, word: &str) -> String {
    let all = raw.groups.iter().flat_map(|g| &g.channels);
    let known: Vec<String> = all.map(|c| c.name.clone()).collect();
    names::find(word, &known).map_or(word.to_string(), |at| known[at].clone())
}

/// Refuses a channel named twice.
fn once(list: &[String]) -> Result<(), Error> {
    let twice = (1..list.len()).find(|&k| list[..k].contains(&list[k]));
    match twice {
        Some(k) => Err(Error::new(
            Code::Usage,
            format!("the channel {} is named twice", list[k]),
        )
        .hint("name each channel once")),
        None => Ok(()),
    }
}

fn study(args: &SpectrumArgs) -> Result<SpectrumStudy, Error> {
    let kind = kind(args.kind);
    let resolution = |text: &str| {
        units::parse_or_bare(text, Kind::Frequency, "Hz", "--resolution").map(|w| w / TAU)
    };
    let resolution_hz = args.resolution.as_deref().map(resolution).transpose()?;
    let refuse = |message: &str, hint: &str| {
        Err(Error::new(Code::OutOfRange, message.to_string()).hint(hint.to_string()))
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
    let speed = |text: &str| units::parse_or_bare(text, Kind::Speed, "rpm", "--speed");
    let speed = args.speed.as_deref().map(speed).transpose()?;
    if speed.is_some_and(|s| s <= 0.0) {
        return refuse("--speed takes a speed above zero", "such as --speed 1500");
    }
    let band = match (&args.band, kind) {
        (Some(text), SpectrumKind::Order) => Some(orders(text)?),
        (Some(text), _) => Some(identify::band(text)?),
        (None, _) => None,
    };
    Ok(SpectrumStudy {
        channels: args.channel.clone(),
        kind,
        resolution_hz,
        window: args.window.as_deref().map(Window::parse).transpose()?,
        overlap: args.overlap,
        averaging: averaging(&args.average)?,
        detrend: match args.detrend {
            DetrendWord::None => Detrend::None,
            DetrendWord::Mean => Detrend::Mean,
            DetrendWord::Linear => Detrend::Linear,
        },
        band,
        motion: args.motion.map(|word| match word {
            MotionWord::Acceleration => Motion::Acceleration,
            MotionWord::Velocity => Motion::Velocity,
            MotionWord::Displacement => Motion::Displacement,
        }),
        tacho: args.tacho.clone(),
        pulses: args.pulses,
        speed,
        turns: args.turns,
        separate: args.separate,
        cuts: cuts(args)?,
        expected: Vec::new(),
    })
}

fn kind(word: SpectrumWord) -> SpectrumKind {
    match word {
        // An order cut is no spectrum and takes its own way.
        SpectrumWord::OrderCut => SpectrumKind::default(),
        SpectrumWord::Psd => SpectrumKind::Density,
        SpectrumWord::Amplitude => SpectrumKind::Amplitude,
        SpectrumWord::Rms => SpectrumKind::Rms,
        SpectrumWord::Multitaper => SpectrumKind::Multitaper,
        SpectrumWord::Envelope => SpectrumKind::Envelope,
        SpectrumWord::Cepstrum => SpectrumKind::Cepstrum,
        SpectrumWord::Spectrogram => SpectrumKind::Spectrogram,
        SpectrumWord::Order => SpectrumKind::Order,
        SpectrumWord::Average => SpectrumKind::Average,
    }
}

/// The orders to cut.
fn cuts(args: &SpectrumArgs) -> Result<Vec<f64>, Error> {
    if args.kind != SpectrumWord::OrderCut && !args.orders.is_empty() {
        return Err(Error::new(Code::Usage, "--orders does nothing here")
            .hint("it is for --kind order-cut"));
    }
    match args.orders.iter().find(|o| !(**o > 0.0 && o.is_finite())) {
        Some(order) => Err(Error::new(
            Code::OutOfRange,
            format!("--orders takes cycles a turn above zero, not {order}"),
        )
        .hint("such as --orders 1,2,21.5")),
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
            let message = format!("\"{}\" is no way to average", units::shortened(word));
            Err(Error::new(Code::Usage, message)
                .hint("--average takes linear, exponential:8 (blocks, at least 1) or peak-hold"))
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
            let message = format!("\"{}\" is not a band of orders", units::shortened(text));
            Error::new(Code::OutOfRange, message).hint("--band takes low:high, such as 0.5:40")
        })
}

/// The lines that model, speed and bearing let expect.
fn expected_lines(args: &SpectrumArgs, study: &SpectrumStudy) -> Result<Vec<Expected>, Errors> {
    let in_orders = study.kind == SpectrumKind::Order;
    let Some(turns_per_s) = (match (in_orders, study.speed) {
        (true, _) => Some(1.0),
        (false, speed) => speed.map(|s| s / TAU),
    }) else {
        if args.model.is_some() || args.bearing.is_some() {
            let message = "--model and --bearing name lines by a speed, and none is stated";
            return Err(Error::new(Code::Usage, message)
                .hint("state it: --speed 1500; or take --kind order with --tacho")
                .into());
        }
        return Ok(Vec::new());
    };
    let mut all = match (&args.model, &args.at) {
        (Some(path), Some(at)) => {
            let prepared = Prepared::new(&scene::read(path)?.model)?;
            expected::of_machine(&prepared, at, TAU * turns_per_s, in_orders)?
        }
        _ => expected::of_shaft(turns_per_s),
    };
    if let Some(text) = &args.bearing {
        all.extend(expected::of_bearing(&bearing(text)?, turns_per_s)?);
    }
    Ok(all)
}

/// `n,d,D,angle`.
fn bearing(text: &str) -> Result<RollingBearing, Error> {
    let wrong = || {
        Error::new(
            Code::Usage,
            format!("\"{}\" is not a rolling bearing", units::shortened(text)),
        )
        .hint("--bearing takes the number of rolling elements, their diameter, the pitch diameter and the contact angle: --bearing 9,7.94,39.04,0")
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [rollers, roller, pitch, angle] = parts[..] else {
        return Err(wrong());
    };
    Ok(RollingBearing {
        rollers: rollers.parse().map_err(|_| wrong())?,
        roller_diameter: units::parse_or_bare(roller, Kind::Length, "mm", "--bearing")?,
        pitch_diameter: units::parse_or_bare(pitch, Kind::Length, "mm", "--bearing")?,
        contact_angle: units::parse_or_bare(angle, Kind::Angle, "deg", "--bearing")?,
    })
}

/// Writes what was asked for and says what.
fn written(mut files: Files, args: &SpectrumArgs, found: &Spectrum) -> Result<Vec<PathBuf>, Error> {
    if let Some(path) = &args.csv {
        files.write(path, report::spectra::csv(found).as_bytes())?;
    }
    if let Some(path) = &args.svg {
        let name = logs::title(&args.files);
        let maps = report::spectra::maps(found, &name);
        let picture = match maps.is_empty() {
            true => report::lines_picture::lines(&report::spectra::curves(found, &name)),
            false => report::map_picture::maps(&maps),
        };
        files.write(path, picture.as_bytes())?;
    }
    files.finish()
}

/// What was done to the data, doubts, what was written.
fn epilogue(repairs: &[Repair], warnings: &[Warning], written: &[PathBuf]) -> String {
    let mut text = String::from("\n");
    text += &epilogue::repairs(repairs);
    text += &epilogue::warnings(warnings);
    text += &epilogue::written(written);
    text
}

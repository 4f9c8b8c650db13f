//! The logs of one test: as named on the command line, or listed in a sidecar; read one after the other and joined.

use std::path::{Path, PathBuf};

use super::args::LogArgs;
use super::progress;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::plan::logs::points::PointRecord;
use crate::recording::geometry::Geometry;
use crate::recording::raw::{RawLog, Repair};
use crate::recording::read_options::{ReadOptions, Roving};
use crate::recording::sidecar;
use crate::recording::signals::Recording;
use crate::recording::{channel_names, join, preprocess};

/// A log and what is stated of it.
pub struct LogInput {
    /// The file.
    pub path: PathBuf,
    /// Flags before the sidecar.
    pub options: ReadOptions,
    /// The sidecar that was read.
    pub sidecar: Option<PathBuf>,
}

/// The logs named; a sidecar with `files` is replaced by the files it lists, and applies to each in place of its own sidecar.
///
/// # Errors
/// Flags without sense; everything wrong in a sidecar.
pub fn open_logs(files: &[PathBuf], args: &LogArgs) -> Result<Vec<LogInput>, Errors> {
    let mut all = Vec::new();
    for file in files {
        let Some(mut list) = sidecar::read_list(file, &args.keys.flags)? else {
            let (options, sidecar) = args.options(file)?;
            all.push(LogInput {
                path: file.clone(),
                options,
                sidecar,
            });
            continue;
        };
        list.sidecar_reports.push(Repair {
            kind: "sidecar",
            message: format!("read {}", file.display()),
        });
        let listed = std::mem::take(&mut list.files);
        all.extend(listed.into_iter().map(|path| LogInput {
            path,
            options: list.clone(),
            sidecar: Some(file.clone()),
        }));
    }
    Ok(all)
}

/// Geometry of a test: that of the sidecars, else that of the first log.
///
/// # Errors
/// `conflict` where two sidecars state points and these differ.
pub fn geometry(logs: &[LogInput], first: &mut RawLog) -> Result<Geometry, Error> {
    let own = std::mem::take(&mut first.geometry);
    let mut stated = logs.iter().filter(|log| !log.options.geometry.is_empty());
    let Some(log) = stated.next() else {
        return Ok(own);
    };
    if let Some(other) = stated.find(|other| other.options.geometry != log.options.geometry) {
        let message = format!(
            "{} and {} state different points",
            log.path.display(),
            other.path.display()
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("list the logs in one sidecar (`files`) that states all points"));
    }
    Ok(log.options.geometry.clone())
}

/// Every file that is read, which no output may replace.
pub fn paths(logs: &[LogInput]) -> Vec<PathBuf> {
    let both = |log: &LogInput| log.sidecar.clone().into_iter().chain([log.path.clone()]);
    logs.iter().flat_map(both).collect()
}

/// Title of the logs: the name of the first file, and the number of others.
pub fn title(files: &[PathBuf]) -> String {
    let name = |path: &Path| {
        path.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into()
    };
    match files {
        [] => String::new(),
        [one] => name(one),
        [first, others @ ..] => format!("{} and {} more", name(first), others.len()),
    }
}

/// The channels named by `keep_channels` (all where empty) of every log, joined; `first` is the first log, opened.
///
/// # Errors
/// Whatever is wrong with a log; logs that are not of one test.
pub fn preprocess(
    logs: &[LogInput],
    first: RawLog,
    only: &[String],
    quiet: bool,
) -> Result<Recording, Errors> {
    let all = each(logs, first, quiet, |log, raw_log| {
        settle_only(log, raw_log, only)
    })?;
    Ok(join::join(all)?)
}

/// The signals of a test.
pub enum Test {
    /// Files of the same points.
    Joined(Box<Recording>),
    /// Files of other points each.
    Points(Vec<PointRecord>),
}

/// The channels of a test: files that hold all of them are joined, files that hold some are records of points. `roving` says that files
/// with equal channels are of other points as well.
///
/// # Errors
/// Whatever is wrong with a log; logs that are not of one test.
pub fn test(
    logs: &[LogInput],
    first: RawLog,
    (inputs, outputs): (&[String], &[String]),
    roving: Option<Roving>,
    quiet: bool,
) -> Result<Test, Errors> {
    let roving = roving.or_else(|| logs.iter().find_map(|log| log.options.roving));
    if roving.is_some() && (logs.len() < 2 || inputs.is_empty()) {
        let message = "a roving test has several files and an input";
        let hint =
            "name the file of every point and the excitation channel (--input), or omit --roving";
        return Err(Error::new(Code::Usage, message).with_hint(hint).into());
    }
    let all = each(logs, first, quiet, |log, raw_log| {
        let of = |words: &[String]| -> Vec<String> {
            (words
                .iter()
                .filter(|word| is_in(word, &raw_log, log))
                .cloned())
            .collect()
        };
        let (mut own, mut own_outputs) = (of(inputs), of(outputs));
        if logs.len() == 1 || own.is_empty() || own_outputs.is_empty() {
            // No part of the test: the error names what is missing.
            (own, own_outputs) = (inputs.to_vec(), outputs.to_vec());
        }
        let count = own.len();
        own.append(&mut own_outputs);
        let recording = settle_only(log, raw_log, &own)?;
        Ok((own, count, recording))
    })?;
    let is_held = |word: &&String| all.iter().any(|(own, ..)| own.contains(*word));
    if let Some(word) = inputs.iter().chain(outputs).find(|word| !is_held(word)) {
        let message = format!("no file has the channel {word}, or it holds no number in any");
        let hint = "check the channels of each file: geardyn check FILE";
        return Err(Error::new(Code::NoChannel, message).with_hint(hint).into());
    }
    let is_whole = |own: &[String]| own.len() == inputs.len() + outputs.len();
    if roving.is_none() && all.iter().all(|(own, ..)| is_whole(own)) {
        let all = all.into_iter().map(|one| one.2).collect();
        return Ok(Test::Joined(Box::new(join::join(all)?)));
    }
    let is_named_by_file = roving.is_some() && all.iter().all(|(own, ..)| is_whole(own));
    let mut records: Vec<(Vec<String>, usize, Vec<Recording>)> = Vec::new();
    for (own, count, recording) in all {
        match records.iter_mut().find(|r| r.0 == own && !is_named_by_file) {
            Some(known) => known.2.push(recording),
            None => records.push((own, count, vec![recording])),
        }
    }
    let points = records.into_iter().map(|(_, count, files)| {
        let recording = join::join(files)?;
        let file = is_named_by_file.then(|| point_of(&recording.path, logs));
        let names = recording.channels.iter().map(|c| c.name.clone());
        let (of_inputs, of_outputs): (Vec<_>, Vec<_>) =
            names.enumerate().partition(|(k, _)| *k < count);
        let side = |names: Vec<(usize, String)>, own: Roving| {
            let point = file.as_ref().filter(|_| roving == Some(own));
            let name = |name: &str| match point {
                None => name.to_string(),
                Some(point) if names.len() == 1 => point.clone(),
                Some(point) => format!("{name}@{point}"),
            };
            names.iter().map(|n| (n.1.clone(), name(&n.1))).collect()
        };
        Ok(PointRecord {
            inputs: side(of_inputs, Roving::Input),
            outputs: side(of_outputs, Roving::Output),
            recording,
        })
    });
    Ok(Test::Points(points.collect::<Result<_, Error>>()?))
}

/// The name of a file without its ending; with its folder where another has the same name.
fn point_of(path: &str, logs: &[LogInput]) -> String {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_os_string();
    let own = stem(Path::new(path));
    match logs.iter().filter(|log| stem(&log.path) == own).count() {
        1 => own.to_string_lossy().into(),
        _ => path.to_string(),
    }
}

/// Whether a log has the channel that a word means, by its name or that of its sidecar.
fn is_in(word: &str, raw_log: &RawLog, log: &LogInput) -> bool {
    let renamed = (log.options.channels.iter())
        .find(|s| s.rename.as_ref().is_some_and(|r| r == word))
        .map_or(word, |s| &s.name);
    let channels = raw_log.groups.iter().flat_map(|g| &g.channels);
    let known: Vec<String> = channels.map(|c| c.name.clone()).collect();
    channel_names::find_channel(renamed, &known).is_some()
}

fn settle_only(log: &LogInput, raw_log: RawLog, only: &[String]) -> Result<Recording, Errors> {
    let mut options = log.options.clone();
    options.keep_channels = only.to_vec();
    Ok(preprocess::preprocess(raw_log, &options)?)
}

/// Opens one log after the other.
fn each<T>(
    logs: &[LogInput],
    first: RawLog,
    quiet: bool,
    read: impl Fn(&LogInput, RawLog) -> Result<T, Errors>,
) -> Result<Vec<T>, Errors> {
    let (mut all, mut first) = (Vec::new(), Some(first));
    for log in logs {
        let raw_log = match first.take() {
            Some(raw_log) => raw_log,
            None => progress::open(&log.path, &log.options, quiet)?,
        };
        all.push(read(log, raw_log)?);
    }
    Ok(all)
}

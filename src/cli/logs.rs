//! Logs of one test, named on the command line or listed in a sidecar, read in sequence and joined.

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

/// A log with its read options.
pub struct LogInput {
    /// Path of the log.
    pub path: PathBuf,
    /// Read options; flags override the sidecar.
    pub options: ReadOptions,
    /// Path of the sidecar, if one was read.
    pub sidecar: Option<PathBuf>,
}

/// Lists the logs with their options. A sidecar with `files` is replaced by these files and applies to each in place of its own sidecar.
///
/// # Errors
/// Invalid flags; errors of a sidecar.
pub fn open_logs(files: &[PathBuf], args: &LogArgs) -> Result<Vec<LogInput>, Errors> {
    let mut inputs = Vec::new();
    for file in files {
        let Some(mut list) = sidecar::read_list(file, &args.keys.flags)? else {
            let (options, sidecar) = args.options(file)?;
            inputs.push(LogInput {
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
        let paths = std::mem::take(&mut list.files);
        inputs.extend(paths.into_iter().map(|path| LogInput {
            path,
            options: list.clone(),
            sidecar: Some(file.clone()),
        }));
    }
    Ok(inputs)
}

/// Geometry of a test: from the sidecars, else from the first log.
///
/// # Errors
/// `conflict` if two sidecars state different points.
pub fn geometry(logs: &[LogInput], first: &mut RawLog) -> Result<Geometry, Error> {
    let log_geometry = std::mem::take(&mut first.geometry);
    let mut stated = logs.iter().filter(|log| !log.options.geometry.is_empty());
    let Some(log) = stated.next() else {
        return Ok(log_geometry);
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

/// Paths of all logs and sidecars, which no output may replace.
pub fn paths(logs: &[LogInput]) -> Vec<PathBuf> {
    let files = |log: &LogInput| log.sidecar.clone().into_iter().chain([log.path.clone()]);
    logs.iter().flat_map(files).collect()
}

/// Title of the logs: name of the first file and number of the other files.
pub fn title(files: &[PathBuf]) -> String {
    let name = |path: &Path| {
        path.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into()
    };
    match files {
        [] => String::new(),
        [file] => name(file),
        [first, others @ ..] => format!("{} and {} more", name(first), others.len()),
    }
}

/// Preprocesses the channels `channels` of every log (all if empty) and joins them; `first` is the opened first log.
///
/// # Errors
/// Errors of a log; logs that are not of one test.
pub fn preprocess(
    logs: &[LogInput],
    first: RawLog,
    channels: &[String],
    quiet: bool,
) -> Result<Recording, Errors> {
    let recordings = read_each(logs, first, quiet, |log, raw_log| {
        preprocess_log(log, raw_log, channels)
    })?;
    Ok(join::join(recordings)?)
}

/// Signals of a test.
pub enum Test {
    /// Joined recording of files with the same points.
    Joined(Box<Recording>),
    /// Records of files with different points.
    Points(Vec<PointRecord>),
}

/// Reads the channels of a test: files that hold all channels are joined, files that hold some become records of points. With `roving`,
/// files with equal channels are of different points too.
///
/// # Errors
/// Errors of a log; logs that are not of one test.
pub fn test(
    logs: &[LogInput],
    first: RawLog,
    (inputs, outputs): (&[String], &[String]),
    roving: Option<Roving>,
    quiet: bool,
) -> Result<Test, Errors> {
    let roving = roving.or_else(|| logs.iter().find_map(|log| log.options.roving));
    if roving.is_some() && (logs.len() < 2 || inputs.is_empty()) {
        let message = "a roving test requires several files and an input";
        let hint =
            "name the file of every point and the excitation channel (--input), or omit --roving";
        return Err(Error::new(Code::Usage, message).with_hint(hint).into());
    }
    let parts = read_each(logs, first, quiet, |log, raw_log| {
        let recorded = |channels: &[String]| -> Vec<String> {
            (channels
                .iter()
                .filter(|name| has_channel(name, &raw_log, log))
                .cloned())
            .collect()
        };
        let (mut names, mut output_names) = (recorded(inputs), recorded(outputs));
        if logs.len() == 1 || names.is_empty() || output_names.is_empty() {
            // With all channels requested, the error lists the missing ones.
            (names, output_names) = (inputs.to_vec(), outputs.to_vec());
        }
        let count = names.len();
        names.append(&mut output_names);
        let recording = preprocess_log(log, raw_log, &names)?;
        Ok((names, count, recording))
    })?;
    let is_read = |name: &&String| parts.iter().any(|(names, ..)| names.contains(*name));
    if let Some(name) = inputs.iter().chain(outputs).find(|name| !is_read(name)) {
        let message = format!("no file has a channel {name} with numbers");
        let hint = "check the channels of each file: geardyn check FILE";
        return Err(Error::new(Code::NoChannel, message).with_hint(hint).into());
    }
    let is_complete = |names: &[String]| names.len() == inputs.len() + outputs.len();
    if roving.is_none() && parts.iter().all(|(names, ..)| is_complete(names)) {
        let recordings = parts.into_iter().map(|part| part.2).collect();
        return Ok(Test::Joined(Box::new(join::join(recordings)?)));
    }
    let is_by_file = roving.is_some() && parts.iter().all(|(names, ..)| is_complete(names));
    let mut records: Vec<(Vec<String>, usize, Vec<Recording>)> = Vec::new();
    for (names, count, recording) in parts {
        match records.iter_mut().find(|r| r.0 == names && !is_by_file) {
            Some(record) => record.2.push(recording),
            None => records.push((names, count, vec![recording])),
        }
    }
    let points = records.into_iter().map(|(_, count, files)| {
        let recording = join::join(files)?;
        let file = is_by_file.then(|| point_name(&recording.path, logs));
        let names = recording.channels.iter().map(|c| c.name.clone());
        let (input_names, output_names): (Vec<_>, Vec<_>) =
            names.enumerate().partition(|(k, _)| *k < count);
        let labels = |names: Vec<(usize, String)>, side: Roving| {
            let point = file.as_ref().filter(|_| roving == Some(side));
            let name = |name: &str| match point {
                None => name.to_string(),
                Some(point) if names.len() == 1 => point.clone(),
                Some(point) => format!("{name}@{point}"),
            };
            names.iter().map(|n| (n.1.clone(), name(&n.1))).collect()
        };
        Ok(PointRecord {
            inputs: labels(input_names, Roving::Input),
            outputs: labels(output_names, Roving::Output),
            recording,
        })
    });
    Ok(Test::Points(points.collect::<Result<_, Error>>()?))
}

/// Name of a file without extension; its full path if another file has the same name.
fn point_name(path: &str, logs: &[LogInput]) -> String {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_os_string();
    let name = stem(Path::new(path));
    match logs.iter().filter(|log| stem(&log.path) == name).count() {
        1 => name.to_string_lossy().into(),
        _ => path.to_string(),
    }
}

/// True if a log has the channel `word`, by its name in the log or in the sidecar.
fn has_channel(word: &str, raw_log: &RawLog, log: &LogInput) -> bool {
    let name_in_log = (log.options.channels.iter())
        .find(|s| s.rename.as_ref().is_some_and(|r| r == word))
        .map_or(word, |s| &s.name);
    let channels = raw_log.groups.iter().flat_map(|g| &g.channels);
    let names: Vec<String> = channels.map(|c| c.name.clone()).collect();
    channel_names::find_channel(name_in_log, &names).is_some()
}

fn preprocess_log(log: &LogInput, raw_log: RawLog, names: &[String]) -> Result<Recording, Errors> {
    let mut options = log.options.clone();
    options.keep_channels = names.to_vec();
    Ok(preprocess::preprocess(raw_log, &options)?)
}

/// Opens the logs in sequence and applies `read` to each.
fn read_each<T>(
    logs: &[LogInput],
    first: RawLog,
    quiet: bool,
    read: impl Fn(&LogInput, RawLog) -> Result<T, Errors>,
) -> Result<Vec<T>, Errors> {
    let (mut results, mut first) = (Vec::new(), Some(first));
    for log in logs {
        let raw_log = match first.take() {
            Some(raw_log) => raw_log,
            None => progress::open(&log.path, &log.options, quiet)?,
        };
        results.push(read(log, raw_log)?);
    }
    Ok(results)
}

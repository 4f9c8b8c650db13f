//! The logs of one test: as named on the command line, or listed in a sidecar; read one after the other and joined.

use std::path::{Path, PathBuf};

use super::args::LogArgs;
use super::progress;
use crate::base::error::Errors;
use crate::recording::raw::{Raw, Repair};
use crate::recording::settings::Settings;
use crate::recording::signals::Recording;
use crate::recording::{join, settle};
use crate::scene;

/// A log and what is stated of it.
pub struct Log {
    /// The file.
    pub path: PathBuf,
    /// Flags before the sidecar.
    pub settings: Settings,
    /// The sidecar that was read.
    pub sidecar: Option<PathBuf>,
}

/// The logs named; a sidecar with `files` stands for those it lists, to each of which it applies in place of a sidecar of its own.
///
/// # Errors
/// Flags without sense; everything wrong in a sidecar.
pub fn named(files: &[PathBuf], args: &LogArgs) -> Result<Vec<Log>, Errors> {
    let mut all = Vec::new();
    for file in files {
        let Some(mut list) = scene::log::read_list(file)? else {
            let (settings, sidecar) = args.settings(file)?;
            all.push(Log {
                path: file.clone(),
                settings,
                sidecar,
            });
            continue;
        };
        list.notes.push(Repair {
            kind: "sidecar",
            message: format!("read {}", file.display()),
        });
        let listed = std::mem::take(&mut list.files);
        let settings = args.over(list)?;
        all.extend(listed.into_iter().map(|path| Log {
            path,
            settings: settings.clone(),
            sidecar: Some(file.clone()),
        }));
    }
    Ok(all)
}

/// Every file that is read, which no output may replace.
pub fn paths(logs: &[Log]) -> Vec<PathBuf> {
    let both = |log: &Log| log.sidecar.clone().into_iter().chain([log.path.clone()]);
    logs.iter().flat_map(both).collect()
}

/// What the logs are called in titles: the name of the file, and how many more there are.
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

/// The channels named by `only` (all where empty) of every log, joined; `first` is the first log, opened.
///
/// # Errors
/// Whatever is wrong with a log; logs that are not of one test.
pub fn settled(
    logs: &[Log],
    first: Raw,
    only: &[String],
    quiet: bool,
) -> Result<Recording, Errors> {
    let settled = |log: &Log, raw: Raw| {
        let mut settings = log.settings.clone();
        settings.only = only.to_vec();
        settle::settle(raw, &settings)
    };
    let (mut all, mut first) = (Vec::new(), Some(first));
    for log in logs {
        let raw = match first.take() {
            Some(raw) => raw,
            None => progress::open(&log.path, &log.settings, quiet)?,
        };
        all.push(settled(log, raw)?);
    }
    Ok(join::join(all)?)
}

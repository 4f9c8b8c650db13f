//! Flags of all commands that read a log: keys of the `[log]` table of a sidecar, over which they lie.

use std::path::{Path, PathBuf};

use clap::Args;

use super::keys::{Key, KeyFlags, KeyGroups, KeyTable, number, repeated, switch, text, word};
use crate::base::error::Errors;
use crate::recording::read_options::{RateSource, ReadOptions};
use crate::recording::sidecar;

/// Flags of every command that reads a log.
#[derive(Debug, Args)]
pub struct LogArgs {
    /// Keys of `[log]`.
    #[command(flatten)]
    pub keys: KeyFlags<LogKeys>,
    /// Do not read the sidecar of the log
    #[arg(long, help_heading = "The log")]
    pub no_sidecar: bool,
}

impl LogArgs {
    /// Options of `log`: flags over the sidecar. Also the sidecar's path, where one was read.
    ///
    /// # Errors
    /// Everything wrong in the flags and the sidecar.
    pub fn options(&self, log: &Path) -> Result<(ReadOptions, Option<PathBuf>), Errors> {
        match self.no_sidecar {
            true => Ok((sidecar::from_flags(&self.keys.flags)?, None)),
            false => sidecar::read_for_log(log, &self.keys.flags),
        }
    }
}

/// Keys of `[log]`.
#[derive(Debug)]
pub struct LogKeys;

impl KeyTable for LogKeys {
    const KEYS: KeyGroups = &[(Some("The log"), LOG)];
}

#[rustfmt::skip]
const LOG: &[Key] = &[
    number("rate", "RATE", "Sample rate (default unit Hz); overrides that of the log"),
    word::<RateSource>("rate-from", "SOURCE", "Source of the sample rate if header and time stamps disagree"),
    text("time", "COLUMN", "Column of time stamps, or none"),
    text("time-unit", "UNIT", "Unit of the time stamps"),
    repeated("unit", "CHANNEL=UNIT", "Unit of the values of a channel: --unit ax=g"),
    repeated("sensitivity", "CHANNEL=VALUE", "Sensitivity of a channel's sensor: --sensitivity \"ax=100 mV/g\""),
    repeated("overload", "CHANNEL=LEVEL", "Overload level of a channel, in its values as recorded: --overload force=5"),
    switch("fill-gaps", "Interpolate gaps linearly instead of splitting the record").sets("gaps").to("fill"),
    number("after", "TIME", "Start of the record used (default unit s)"),
    number("before", "TIME", "End of the record used (default unit s)"),
    text("trigger", "CHANNEL=LEVEL", "Start where a channel reaches a level, in its values as recorded: --trigger force=5"),
    number("pre-trigger", "TIME", "Duration kept before the trigger (default unit s)"),
    text("delimiter", "MARK", "Delimiter of cells: , ; tab space |"),
    text("decimal", "MARK", "Decimal mark: . or ,"),
    text("encoding", "NAME", "Encoding of the header, such as latin1, gbk, utf-16le"),
    number("header-lines", "N", "Lines above the first row of numbers"),
    switch("day-first", "Dates such as 03/04/2023 begin with the day").sets("dates").to("day-first"),
    switch("month-first", "Dates such as 03/04/2023 begin with the month").sets("dates").to("month-first"),
];

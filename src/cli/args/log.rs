//! Flags of all commands that read a log; merged with the sidecar.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::recording::read_options::{ChannelOptions, GapPolicy, RateSource, ReadOptions, Trigger};
use crate::scene;

/// Flags of every command that reads a log.
#[derive(Debug, Args, Default)]
#[command(next_help_heading = "The log")]
pub struct LogArgs {
    /// Sample rate (Hz where bare), whatever the log says
    #[arg(
        long,
        value_name = "RATE",
        conflicts_with = "rate_from",
        allow_negative_numbers = true
    )]
    pub rate: Option<String>,
    /// Where header and time stamps disagree about the rate: which is right
    #[arg(long, value_enum, value_name = "SOURCE")]
    pub rate_from: Option<RateSourceArg>,
    /// The column of time stamps; none: no column is one
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// Unit of the time stamps
    #[arg(long, value_name = "UNIT")]
    pub time_unit: Option<String>,
    /// Unit the numbers of a channel are in: --unit ax=g
    #[arg(long, value_name = "CHANNEL=UNIT")]
    pub unit: Vec<String>,
    /// Sensitivity of a channel's sensor: --sensitivity "ax=100 mV/g"
    #[arg(long, value_name = "CHANNEL=VALUE")]
    pub sensitivity: Vec<String>,
    /// Level at which a channel overloads, in its numbers: --overload force=5
    #[arg(long, value_name = "CHANNEL=LEVEL")]
    pub overload: Vec<String>,
    /// Bridge gaps by straight lines instead of splitting the record there
    #[arg(long)]
    pub fill_gaps: bool,
    /// Leave out what lies before this time (s where bare)
    #[arg(long, value_name = "TIME")]
    pub after: Option<String>,
    /// Leave out what lies from this time on (s where bare)
    #[arg(long, value_name = "TIME")]
    pub before: Option<String>,
    /// Begin where a channel reaches a level, in its numbers: --trigger force=5
    #[arg(long, value_name = "CHANNEL=LEVEL")]
    pub trigger: Option<String>,
    /// How much to keep before the trigger (s where bare)
    #[arg(long, value_name = "TIME", requires = "trigger")]
    pub pre_trigger: Option<String>,
    /// Between cells: , ; tab space |
    #[arg(long, value_name = "MARK")]
    pub delimiter: Option<String>,
    /// Decimal mark: . or ,
    #[arg(long, value_name = "MARK")]
    pub decimal: Option<char>,
    /// Encoding of the header, such as latin1, gbk, utf-16le
    #[arg(long, value_name = "NAME")]
    pub encoding: Option<String>,
    /// Lines above the first row of numbers
    #[arg(long, value_name = "N")]
    pub header_lines: Option<usize>,
    /// Dates such as 03/04/2023 begin with the day
    #[arg(long, conflicts_with = "month_first")]
    pub day_first: bool,
    /// Dates such as 03/04/2023 begin with the month
    #[arg(long)]
    pub month_first: bool,
    /// Do not read the sidecar beside the log
    #[arg(long)]
    pub no_sidecar: bool,
}

/// Words for the source of a rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum RateSourceArg {
    /// The time stamps
    Time,
    /// The header
    Header,
}

impl LogArgs {
    /// What is said of `log`: flags before the sidecar. Also the sidecar's path, where one was read.
    ///
    /// # Errors
    /// Flags without sense; everything wrong in the sidecar.
    pub fn settings(&self, log: &Path) -> Result<(ReadOptions, Option<PathBuf>), Errors> {
        let found = match self.no_sidecar {
            true => None,
            false => scene::sidecar::read_for_log(log)?,
        };
        let sidecar = found.is_some().then(|| scene::sidecar::sidecar_path(log));
        Ok((self.merge_into(found.unwrap_or_default())?, sidecar))
    }

    /// The flags over settings from elsewhere.
    ///
    /// # Errors
    /// Flags without sense.
    pub fn merge_into(&self, mut options: ReadOptions) -> Result<ReadOptions, Errors> {
        if let Some(text) = &self.rate {
            let omega = quantity::parse_or_bare(text, QuantityKind::Frequency, "Hz", "--rate")?;
            options.rate = Some(RateSource::Hertz(omega / std::f64::consts::TAU));
        }
        match self.rate_from {
            Some(RateSourceArg::Time) => options.rate = Some(RateSource::TimeStamps),
            Some(RateSourceArg::Header) => options.rate = Some(RateSource::Header),
            None => {}
        }
        let time = |text: &Option<String>, flag| -> Result<Option<f64>, Error> {
            text.as_deref()
                .map(|t| quantity::parse_or_bare(t, QuantityKind::Time, "s", flag))
                .transpose()
        };
        options.from_s = time(&self.after, "--after")?.or(options.from_s);
        options.to_s = time(&self.before, "--before")?.or(options.to_s);
        if let Some(text) = &self.trigger {
            let (channel, level) = parse_channel_level(text, "--trigger")?;
            let before_s = time(&self.pre_trigger, "--pre-trigger")?.unwrap_or(0.0);
            if before_s < 0.0 {
                let message = "--pre-trigger takes a time of at least 0";
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("what is kept before the trigger: --pre-trigger 0.01")
                    .into());
            }
            options.trigger = Some(Trigger {
                channel: channel.to_string(),
                level,
                before_s,
            });
        }
        options.time_column = self.time.clone().or(options.time_column);
        options.time_unit = self.time_unit.clone().or(options.time_unit);
        if self.fill_gaps {
            options.gaps = GapPolicy::Fill;
        }
        self.dialect(&mut options)?;
        self.channels(&mut options)?;
        Ok(options)
    }

    fn dialect(&self, options: &mut ReadOptions) -> Result<(), Error> {
        let dialect = &mut options.dialect;
        if let Some(word) = &self.delimiter {
            let mark = match word.as_str() {
                "tab" | "\\t" | "\t" => '\t',
                "space" | " " => ' ',
                "comma" | "," => ',',
                "semicolon" | ";" => ';',
                "|" => '|',
                other => {
                    let message = format!("--delimiter cannot be \"{other}\"");
                    return Err(
                        Error::new(Code::Usage, message).with_hint("it takes , ; tab space |")
                    );
                }
            };
            dialect.delimiter = Some(mark);
        }
        if let Some(mark) = self.decimal {
            if !matches!(mark, '.' | ',') {
                return Err(
                    Error::new(Code::Usage, format!("--decimal cannot be \"{mark}\""))
                        .with_hint("it takes . or ,"),
                );
            }
            dialect.decimal = Some(mark);
        }
        dialect.encoding = self.encoding.clone().or(dialect.encoding.take());
        if self.day_first || self.month_first {
            dialect.day_first = Some(self.day_first);
        }
        dialect.header_lines = self.header_lines.or(dialect.header_lines);
        Ok(())
    }

    fn channels(&self, options: &mut ReadOptions) -> Result<(), Error> {
        for text in &self.unit {
            let (name, unit) = pair(text, "--unit", "ax=g")?;
            channel_entry(options, name).unit = Some(unit.to_string());
        }
        for text in &self.sensitivity {
            let (name, value) = pair(text, "--sensitivity", "ax=100 mV/g")?;
            channel_entry(options, name).sensitivity = Some(value.to_string());
        }
        for text in &self.overload {
            let (name, level) = parse_channel_level(text, "--overload")?;
            channel_entry(options, name).overload = Some(level);
        }
        Ok(())
    }
}

/// What is said of the channel `name`, made where nothing is said yet.
fn channel_entry<'s>(options: &'s mut ReadOptions, name: &str) -> &'s mut ChannelOptions {
    let at = options
        .channels
        .iter()
        .position(|c| c.name == name)
        .unwrap_or_else(|| {
            options.channels.push(ChannelOptions {
                name: name.to_string(),
                ..ChannelOptions::default()
            });
            options.channels.len() - 1
        });
    &mut options.channels[at]
}

/// A channel and a level above zero of its numbers.
fn parse_channel_level<'t>(text: &'t str, flag: &str) -> Result<(&'t str, f64), Error> {
    let (name, level) = pair(text, flag, "force=5")?;
    let found = level.parse().ok();
    match found.filter(|l: &f64| *l > 0.0 && l.is_finite()) {
        Some(level) => Ok((name, level)),
        None => Err(
            Error::new(Code::Usage, format!("\"{text}\" names no level above zero"))
                .with_hint(format!("write {flag} force=5")),
        ),
    }
}

fn pair<'t>(text: &'t str, flag: &str, example: &str) -> Result<(&'t str, &'t str), Error> {
    // Names may hold an equals sign, units do not.
    text.rsplit_once('=')
        .map(|(name, value)| (name.trim(), value.trim()))
        .filter(|(name, value)| !name.is_empty() && !value.is_empty())
        .ok_or_else(|| {
            let message = format!("\"{text}\" does not name a channel and what is said of it");
            Error::new(Code::Usage, message).with_hint(format!("write {flag} \"{example}\""))
        })
}

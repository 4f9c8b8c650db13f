//! Selection and calibration of the requested channels.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list, suggestion};
use crate::recording::calibrate::{self, Calibration};
use crate::recording::channel_names;
use crate::recording::raw::{ChannelGroup, RawChannel, RawLog, RawTiming};
use crate::recording::read_options::{ChannelOptions, ReadOptions};
use crate::recording::stated_rates::candidates;

/// Group of the requested channels, in the requested order.
pub(super) fn select_channels(
    log: &mut RawLog,
    options: &ReadOptions,
) -> Result<ChannelGroup, Error> {
    let known: Vec<String> = log
        .groups
        .iter()
        .flat_map(|g| &g.channels)
        .map(|c| c.name.clone())
        .collect();
    if known.is_empty() {
        return Err(no_samples(log));
    }
    if options.keep_channels.is_empty() {
        // The longest group, and the groups with the same time base; most files have a single group.
        let largest = (0..log.groups.len()).max_by_key(|&g| (log.groups[g].rows(), usize::MAX - g));
        let mut group = log.groups.remove(largest.unwrap_or(0));
        for other in std::mem::take(&mut log.groups) {
            match share_time_base(&group, &other) {
                true => group.channels.extend(other.channels),
                false => log.diagnostics.push(skipped_other_rate(&other)),
            }
        }
        return Ok(group);
    }
    let (mut group_indices, mut names) = (Vec::new(), Vec::new());
    let requested = options.channels_to_read();
    for request in &requested {
        let is_renamed = |s: &&ChannelOptions| s.rename.as_ref().is_some_and(|r| r == request);
        let request = (options.channels.iter())
            .find(is_renamed)
            .map_or(request, |s| &s.name);
        let name = channel_names::find_channel(request, &known).map(|k| &known[k]);
        let group = name.and_then(|name| {
            let contains = |g: &ChannelGroup| g.channels.iter().any(|c| c.name == *name);
            log.groups.iter().position(contains)
        });
        let (Some(name), Some(group)) = (name, group) else {
            let skipped = log
                .skipped_columns
                .iter()
                .find(|(name, _)| channel_names::matches(request, name));
            return Err(match skipped {
                Some((name, why)) => skipped_column_error(name, why),
                None => unknown_channel(request, &known),
            });
        };
        names.push(name);
        group_indices.push(group);
    }
    let first = group_indices.first().copied().unwrap_or(0);
    if let Some(other) = group_indices.iter().find(|&&g| g != first) {
        let (a, b) = (&log.groups[first], &log.groups[*other]);
        if !share_time_base(a, b) {
            let apart = match a.rows() == b.rows() {
                true => "their time stamps begin or end apart".to_string(),
                false => format!("{} and {} samples", a.rows(), b.rows()),
            };
            let message = format!(
                "the channels {} do not share one clock: {apart}",
                quoted_list(requested.iter().map(String::as_str)),
            );
            let hint = "analyse channels of one clock together; `geardyn check` lists their clocks";
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
    }
    let timing = std::mem::take(&mut log.groups[first].timing);
    let mut channels = Vec::new();
    for (name, &group) in names.into_iter().zip(&group_indices) {
        let index = log.groups[group]
            .channels
            .iter()
            .position(|c| c.name == *name);
        let Some(index) = index else {
            // The trigger may be one of the selected channels under another name.
            if options.trigger.is_some() && channels.len() == options.keep_channels.len() {
                continue;
            }
            return Err(Error::new(Code::Conflict, format!("{name} is named twice"))
                .with_hint("name each channel once"));
        };
        channels.push(log.groups[group].channels.remove(index));
    }
    Ok(ChannelGroup { timing, channels })
}

/// Warning for channels that are skipped because they have another time base.
fn skipped_other_rate(group: &ChannelGroup) -> Diagnostic {
    let names = quoted_list(group.channels.iter().map(|c| c.name.as_str()));
    Diagnostic {
        code: "another-clock",
        message: format!(
            "{names}: {} by another clock, not taken along",
            pluralise(group.rows(), "sample")
        ),
        hint: Some("name the channels of one clock to analyse them".to_string()),
    }
}

/// Error for a file without samples.
fn no_samples(log: &RawLog) -> Error {
    let (held, hint) = match (&log.responses, log.spectra.is_empty()) {
        (Some(_), _) => (
            "frequency responses",
            "`geardyn identify` takes them as they are",
        ),
        (None, false) => (
            "spectra",
            "`geardyn spectrum` shows their peaks; for all else export the signal over time",
        ),
        (None, true) => ("no readable data", "check whether the right file was named"),
    };
    let message = format!("{} contains {held} and no channel of samples", log.path);
    Error::new(Code::EmptyLog, message).with_hint(hint)
}

/// True if two groups agree in length, stated rates, time stamps and start time.
fn share_time_base(a: &ChannelGroup, b: &ChannelGroup) -> bool {
    fn rates(timing: &RawTiming) -> impl Iterator<Item = f64> {
        candidates(&timing.stated_rates).map(|r| r.hertz)
    }
    let first_stamp = |c: &RawTiming| {
        let text = c.stamps.as_ref().map(|s| s.first.clone());
        let number = text
            .as_ref()
            .and_then(|w| w.replace(',', ".").parse::<f64>().ok());
        number.ok_or(text)
    };
    let last_stamp = |c: &RawTiming| -> Option<(f64, f64)> {
        let seconds = &c.stamps.as_ref()?.seconds;
        let mut end = [0.0];
        seconds.read(seconds.len().checked_sub(1)?, &mut end).ok()?;
        Some((end[0], seconds.len() as f64))
    };
    a.rows() == b.rows()
        && rates(&a.timing).eq(rates(&b.timing))
        && last_stamp(&a.timing) == last_stamp(&b.timing)
        && first_stamp(&a.timing) == first_stamp(&b.timing)
        && a.timing.start == b.timing.start
}

/// Error for a channel that does not exist.
pub fn unknown_channel(name: &str, known: &[String]) -> Error {
    let names = known.iter().map(String::as_str);
    let hint = match suggestion(name, names.clone()) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("it has {}", quoted_list(names)),
    };
    Error::new(
        Code::NoChannel,
        format!("the log has no channel \"{name}\""),
    )
    .with_hint(hint)
}

/// Error for a column that holds no channel.
pub(super) fn skipped_column_error(name: &str, why: &str) -> Error {
    Error::new(Code::NoSignal, format!("the channel {name} {why}"))
        .with_hint("check whether its sensor was connected and recorded; name another channel")
}

/// Rejects duplicate options of a channel, and ambiguous new names.
fn check_names(channels: &[RawChannel], options: &ReadOptions) -> Result<(), Error> {
    for (index, entry) in options.channels.iter().enumerate() {
        let earlier = &options.channels[..index];
        if earlier.iter().any(|b| b.name == entry.name) {
            let message = format!("two [[channel]] refer to \"{}\"", entry.name);
            return Err(Error::new(Code::Conflict, message).with_hint("join them"));
        }
        let Some(new) = &entry.rename else { continue };
        if new.trim().is_empty() || new.contains(char::is_control) {
            let message = format!("\"{}\" cannot be renamed to {new:?}", entry.name);
            return Err(Error::new(Code::OutOfRange, message).with_hint("write a name in one line"));
        }
        let same = |c: &RawChannel| {
            let is_renamed = |s: &ChannelOptions| s.name == c.name && s.rename.is_some();
            c.name == *new && !options.channels.iter().any(is_renamed)
        };
        if channels.iter().any(same) || earlier.iter().any(|b| b.rename.as_ref() == Some(new)) {
            let message = format!(
                "\"{}\" is renamed to \"{new}\", and another channel has that name",
                entry.name
            );
            return Err(Error::new(Code::Conflict, message).with_hint("give it a name of its own"));
        }
    }
    Ok(())
}

/// Calibration of each channel by its name.
pub(super) fn calibrations(
    channels: &[RawChannel],
    options: &ReadOptions,
) -> Result<Vec<Calibration>, Error> {
    if options.channels.is_empty() {
        let defaults = channels
            .iter()
            .map(|c| calibrate::for_channel(&c.name, &c.unit, None));
        return defaults.collect();
    }
    check_names(channels, options)?;
    let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
    if options.keep_channels.is_empty() {
        for entry in &options.channels {
            if channel_names::find_channel(&entry.name, &known).is_none() {
                return Err(unknown_channel(&entry.name, &known));
            }
        }
    }
    channels
        .iter()
        .map(|channel| {
            let name = std::slice::from_ref(&channel.name);
            let exact = options.channels.iter().find(|s| s.name == channel.name);
            let entry = exact.or_else(|| {
                options
                    .channels
                    .iter()
                    .find(|s| channel_names::find_channel(&s.name, name).is_some())
            });
            calibrate::for_channel(&channel.name, &channel.unit, entry)
        })
        .collect()
}

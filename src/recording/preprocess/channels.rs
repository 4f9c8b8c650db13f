//! Selection and calibration of the requested channels.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list, suggestion};
use crate::recording::calibrate::{self, Calibration};
use crate::recording::channel_names;
use crate::recording::raw::{ChannelGroup, RawChannel, RawLog, RawTiming};
use crate::recording::read_options::{ChannelOptions, ReadOptions};
use crate::recording::stated_rates::candidates;

/// The group that holds the requested channels, in the requested order.
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
        // The longest group, and what was sampled with it; a file nearly always has one.
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
    let (mut at, mut wanted) = (Vec::new(), Vec::new());
    let words = options.channels_to_read();
    for word in &words {
        let named = |s: &&ChannelOptions| s.rename.as_ref().is_some_and(|r| r == word);
        let word = (options.channels.iter())
            .find(named)
            .map_or(word, |s| &s.name);
        let name = channel_names::find_channel(word, &known).map(|k| &known[k]);
        let group = name.and_then(|name| {
            let holds = |g: &ChannelGroup| g.channels.iter().any(|c| c.name == *name);
            log.groups.iter().position(holds)
        });
        let (Some(name), Some(group)) = (name, group) else {
            let column = log
                .skipped_columns
                .iter()
                .find(|(name, _)| channel_names::matches(word, name));
            return Err(match column {
                Some((name, why)) => skipped_column_error(name, why),
                None => unknown_channel(word, &known),
            });
        };
        wanted.push(name);
        at.push(group);
    }
    let first = at.first().copied().unwrap_or(0);
    if let Some(other) = at.iter().find(|&&g| g != first) {
        let (one, two) = (&log.groups[first], &log.groups[*other]);
        if !share_time_base(one, two) {
            let apart = match one.rows() == two.rows() {
                true => "their time stamps begin or end apart".to_string(),
                false => format!("{} and {} samples", one.rows(), two.rows()),
            };
            let message = format!(
                "the channels {} do not share one clock: {apart}",
                quoted_list(words.iter().map(String::as_str)),
            );
            let hint = "analyse channels of one clock together; `geardyn check` lists their clocks";
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
    }
    let timing = std::mem::take(&mut log.groups[first].timing);
    let mut channels = Vec::new();
    for (name, &group) in wanted.into_iter().zip(&at) {
        let place = log.groups[group]
            .channels
            .iter()
            .position(|c| c.name == *name);
        let Some(place) = place else {
            // The trigger may be one of the channels kept, by another word.
            if options.trigger.is_some() && channels.len() == options.keep_channels.len() {
                continue;
            }
            return Err(Error::new(Code::Conflict, format!("{name} is named twice"))
                .with_hint("name each channel once"));
        };
        channels.push(log.groups[group].channels.remove(place));
    }
    Ok(ChannelGroup { timing, channels })
}

/// Channels that are left aside since they do not go with the others.
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

/// The error of a file that holds something else than samples.
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
        (None, true) => (
            "nothing that is read",
            "check whether the right file was named",
        ),
    };
    let message = format!("{} holds {held} and no channel of samples", log.path);
    Error::new(Code::EmptyLog, message).with_hint(hint)
}

/// Groups of one length, rate and beginning were sampled together, whatever the file makes of it.
fn share_time_base(one: &ChannelGroup, two: &ChannelGroup) -> bool {
    fn rates(timing: &RawTiming) -> impl Iterator<Item = f64> {
        candidates(&timing.stated_rates).map(|r| r.hertz)
    }
    let first = |c: &RawTiming| {
        let written = c.stamps.as_ref().map(|s| s.first.clone());
        let number = written
            .as_ref()
            .and_then(|w| w.replace(',', ".").parse::<f64>().ok());
        number.ok_or(written)
    };
    let ends = |c: &RawTiming| -> Option<(f64, f64)> {
        let seconds = &c.stamps.as_ref()?.seconds;
        let mut end = [0.0];
        seconds.read(seconds.len().checked_sub(1)?, &mut end).ok()?;
        Some((end[0], seconds.len() as f64))
    };
    one.rows() == two.rows()
        && rates(&one.timing).eq(rates(&two.timing))
        && ends(&one.timing) == ends(&two.timing)
        && first(&one.timing) == first(&two.timing)
        && one.timing.start == two.timing.start
}

/// The error of a channel that is not there.
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

/// The error of a column that could not become a channel.
pub(super) fn skipped_column_error(name: &str, why: &str) -> Error {
    Error::new(Code::NoSignal, format!("the channel {name} {why}"))
        .with_hint("check whether its sensor was connected and recorded; name another channel")
}

/// Refuses options given twice for a channel, and new names that cannot be distinguished.
fn check_names(channels: &[RawChannel], options: &ReadOptions) -> Result<(), Error> {
    for (at, said) in options.channels.iter().enumerate() {
        let before = &options.channels[..at];
        if before.iter().any(|b| b.name == said.name) {
            let message = format!("two [[channel]] speak of \"{}\"", said.name);
            return Err(Error::new(Code::Conflict, message).with_hint("join them"));
        }
        let Some(new) = &said.rename else { continue };
        if new.trim().is_empty() || new.contains(char::is_control) {
            let message = format!("\"{}\" cannot be renamed to {new:?}", said.name);
            return Err(Error::new(Code::OutOfRange, message).with_hint("write a name in one line"));
        }
        let stays = |c: &RawChannel| {
            let moved = |s: &ChannelOptions| s.name == c.name && s.rename.is_some();
            c.name == *new && !options.channels.iter().any(moved)
        };
        if channels.iter().any(stays) || before.iter().any(|b| b.rename.as_ref() == Some(new)) {
            let message = format!(
                "\"{}\" is renamed to \"{new}\", and another channel has that name",
                said.name
            );
            return Err(Error::new(Code::Conflict, message).with_hint("give it a name of its own"));
        }
    }
    Ok(())
}

/// Calibration of each channel, found by its name.
pub(super) fn calibrations(
    channels: &[RawChannel],
    options: &ReadOptions,
) -> Result<Vec<Calibration>, Error> {
    if options.channels.is_empty() {
        let plain = channels
            .iter()
            .map(|c| calibrate::for_channel(&c.name, &c.unit, None));
        return plain.collect();
    }
    check_names(channels, options)?;
    let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
    if options.keep_channels.is_empty() {
        for said in &options.channels {
            if channel_names::find_channel(&said.name, &known).is_none() {
                return Err(unknown_channel(&said.name, &known));
            }
        }
    }
    channels
        .iter()
        .map(|channel| {
            let own = std::slice::from_ref(&channel.name);
            let exact = options.channels.iter().find(|s| s.name == channel.name);
            let said = exact.or_else(|| {
                options
                    .channels
                    .iter()
                    .find(|s| channel_names::find_channel(&s.name, own).is_some())
            });
            calibrate::for_channel(&channel.name, &channel.unit, said)
        })
        .collect()
}

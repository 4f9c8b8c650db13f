//! Which channels of a file are wanted, and what is said of each.

use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::{counted, listed, suggestion};
use crate::recording::calibrate::{self, Calibration};
use crate::recording::names;
use crate::recording::raw::{Clock, Group, Raw, RawChannel};
use crate::recording::settings::{ChannelSettings, Settings};
use crate::recording::stated_rates::candidates;

/// The group that holds the channels asked for, those in the order asked for.
pub(super) fn choose(raw: &mut Raw, settings: &Settings) -> Result<Group, Error> {
    let known: Vec<String> = raw
        .groups
        .iter()
        .flat_map(|g| &g.channels)
        .map(|c| c.name.clone())
        .collect();
    if known.is_empty() {
        return Err(no_samples(raw));
    }
    if settings.only.is_empty() {
        // The longest group, and what was sampled with it; a file nearly always has one.
        let largest = (0..raw.groups.len()).max_by_key(|&g| (raw.groups[g].rows(), usize::MAX - g));
        let mut group = raw.groups.remove(largest.unwrap_or(0));
        for other in std::mem::take(&mut raw.groups) {
            match same_clock(&group, &other) {
                true => group.channels.extend(other.channels),
                false => raw.warnings.push(by_another_clock(&other)),
            }
        }
        return Ok(group);
    }
    let (mut at, mut wanted) = (Vec::new(), Vec::new());
    let words = settings.read();
    for word in &words {
        let named = |s: &&ChannelSettings| s.rename.as_ref().is_some_and(|r| r == word);
        let word = (settings.channels.iter())
            .find(named)
            .map_or(word, |s| &s.name);
        let name = names::find(word, &known).map(|k| &known[k]);
        let group = name.and_then(|name| {
            let holds = |g: &Group| g.channels.iter().any(|c| c.name == *name);
            raw.groups.iter().position(holds)
        });
        let (Some(name), Some(group)) = (name, group) else {
            let column = raw
                .left_out
                .iter()
                .find(|(name, _)| names::means(word, name));
            return Err(match column {
                Some((name, why)) => left_out(name, why),
                None => no_channel(word, &known),
            });
        };
        wanted.push(name);
        at.push(group);
    }
    let first = at.first().copied().unwrap_or(0);
    if let Some(other) = at.iter().find(|&&g| g != first) {
        let (one, two) = (&raw.groups[first], &raw.groups[*other]);
        if !same_clock(one, two) {
            let apart = match one.rows() == two.rows() {
                true => "their time stamps begin or end apart".to_string(),
                false => format!("{} and {} samples", one.rows(), two.rows()),
            };
            let message = format!(
                "the channels {} do not share one clock: {apart}",
                listed(words.iter().map(String::as_str)),
            );
            let hint = "analyse channels of one clock together; `geardyn check` tells which are";
            return Err(Error::new(Code::Conflict, message).hint(hint));
        }
    }
    let clock = std::mem::take(&mut raw.groups[first].clock);
    let mut channels = Vec::new();
    for (name, &group) in wanted.into_iter().zip(&at) {
        let place = raw.groups[group]
            .channels
            .iter()
            .position(|c| c.name == *name);
        let Some(place) = place else {
            // The trigger may be one of the channels kept, by another word.
            if settings.trigger.is_some() && channels.len() == settings.only.len() {
                continue;
            }
            return Err(Error::new(Code::Conflict, format!("{name} is named twice"))
                .hint("name each channel once"));
        };
        channels.push(raw.groups[group].channels.remove(place));
    }
    Ok(Group { clock, channels })
}

/// Channels that are left aside since they do not go with the others.
fn by_another_clock(group: &Group) -> Warning {
    let names = listed(group.channels.iter().map(|c| c.name.as_str()));
    Warning {
        code: "another-clock",
        message: format!(
            "{names}: {} by another clock, not taken along",
            counted(group.rows(), "sample")
        ),
        hint: Some("name the channels of one clock to analyse them".to_string()),
    }
}

/// The error of a file that holds something else than samples.
fn no_samples(raw: &Raw) -> Error {
    let (held, hint) = match (&raw.responses, raw.spectra.is_empty()) {
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
            "look whether the right file was named",
        ),
    };
    let message = format!("{} holds {held} and no channel of samples", raw.path);
    Error::new(Code::EmptyLog, message).hint(hint)
}

/// Groups of one length, rate and beginning were sampled together, whatever the file makes of it.
fn same_clock(one: &Group, two: &Group) -> bool {
    fn rates(clock: &Clock) -> impl Iterator<Item = f64> {
        candidates(&clock.stated_rates).map(|r| r.hertz)
    }
    let first = |c: &Clock| {
        let written = c.stamps.as_ref().map(|s| s.first.clone());
        let number = written
            .as_ref()
            .and_then(|w| w.replace(',', ".").parse::<f64>().ok());
        number.ok_or(written)
    };
    let ends = |c: &Clock| -> Option<(f64, f64)> {
        let seconds = &c.stamps.as_ref()?.seconds;
        let mut end = [0.0];
        seconds.read(seconds.len().checked_sub(1)?, &mut end).ok()?;
        Some((end[0], seconds.len() as f64))
    };
    one.rows() == two.rows()
        && rates(&one.clock).eq(rates(&two.clock))
        && ends(&one.clock) == ends(&two.clock)
        && first(&one.clock) == first(&two.clock)
        && one.clock.start == two.clock.start
}

/// The error of a channel that is not there.
pub fn no_channel(name: &str, known: &[String]) -> Error {
    let names = known.iter().map(String::as_str);
    let hint = match suggestion(name, names.clone()) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("it has {}", listed(names)),
    };
    Error::new(
        Code::NoChannel,
        format!("the log has no channel \"{name}\""),
    )
    .hint(hint)
}

/// The error of a column that could not become a channel.
pub(super) fn left_out(name: &str, why: &str) -> Error {
    Error::new(Code::NoSignal, format!("the channel {name} {why}"))
        .hint("look whether its sensor was connected and recorded; name another channel")
}

/// Refuses what is said twice of a channel, and new names that cannot be told apart.
fn refuse_names(channels: &[RawChannel], settings: &Settings) -> Result<(), Error> {
    for (at, said) in settings.channels.iter().enumerate() {
        let before = &settings.channels[..at];
        if before.iter().any(|b| b.name == said.name) {
            let message = format!("two [[channel]] speak of \"{}\"", said.name);
            return Err(Error::new(Code::Conflict, message).hint("join them"));
        }
        let Some(new) = &said.rename else { continue };
        if new.trim().is_empty() || new.contains(char::is_control) {
            let message = format!("\"{}\" cannot be renamed to {new:?}", said.name);
            return Err(Error::new(Code::OutOfRange, message).hint("write a name in one line"));
        }
        let stays = |c: &RawChannel| {
            let moved = |s: &ChannelSettings| s.name == c.name && s.rename.is_some();
            c.name == *new && !settings.channels.iter().any(moved)
        };
        if channels.iter().any(stays) || before.iter().any(|b| b.rename.as_ref() == Some(new)) {
            let message = format!(
                "\"{}\" is renamed to \"{new}\", and another channel has that name",
                said.name
            );
            return Err(Error::new(Code::Conflict, message).hint("give it a name of its own"));
        }
    }
    Ok(())
}

/// What is said of each channel, found by its name.
pub(super) fn calibrations(
    channels: &[RawChannel],
    settings: &Settings,
) -> Result<Vec<Calibration>, Error> {
    if settings.channels.is_empty() {
        let plain = channels
            .iter()
            .map(|c| calibrate::of(&c.name, &c.unit, None));
        return plain.collect();
    }
    refuse_names(channels, settings)?;
    let known: Vec<String> = channels.iter().map(|c| c.name.clone()).collect();
    if settings.only.is_empty() {
        for said in &settings.channels {
            if names::find(&said.name, &known).is_none() {
                return Err(no_channel(&said.name, &known));
            }
        }
    }
    channels
        .iter()
        .map(|channel| {
            let own = std::slice::from_ref(&channel.name);
            let exact = settings.channels.iter().find(|s| s.name == channel.name);
            let said = exact.or_else(|| {
                settings
                    .channels
                    .iter()
                    .find(|s| names::find(&s.name, own).is_some())
            });
            calibrate::of(&channel.name, &channel.unit, said)
        })
        .collect()
}

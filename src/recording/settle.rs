//! A log as written becomes channels on a uniform time base: rate decided, gaps split or filled, jitter resampled, sensors scaled.

use std::ops::Range;

use super::calibrate::{self, Calibration};
use super::column::Column;
use super::names;
use super::raw::{Clock, Group, Raw, RawChannel, Repair};
use super::resample::{self, Grid};
use super::settings::{ChannelSettings, Gaps, RateSource, Settings, Trigger};
use super::signals::{Channel, Recording};
use super::time_base::{self, Spacing, TimeBase};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::place::Place;
use crate::base::words::{counted, listed, suggestion};

/// Samples handled at a time.
const BLOCK: usize = 1 << 16;

/// Rates that differ by more than this say different things.
const SAME_RATE: f64 = 1e-3;

/// Places closer to a whole step than this are on it.
const WHOLE: f64 = 1e-3;

/// Rates that a recorder may have, Hz: a sample in thirty thousand years to one in the time light takes for a third of a millimetre.
const RATES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Settles the time base of a log and scales its channels.
///
/// # Errors
/// No rate or contradicting ones, stamps out of order, channels that do not exist or do not share a clock, units without sense.
pub fn settle(raw: Raw, settings: &Settings) -> Result<Recording, Error> {
    let path = raw.path.clone();
    settled(raw, settings).map_err(|mut e| {
        // The clock knows the lines of its rows and not whose they are.
        e.place = e.place.map(|place| match place.source().path.is_empty() {
            true => Place::of_line(&path, place.line()),
            false => place,
        });
        e.in_file(&path)
    })
}

fn settled(mut raw: Raw, settings: &Settings) -> Result<Recording, Error> {
    let group = choose(&mut raw, settings)?;
    let calibrations = calibrations(&group.channels, settings)?;
    let base = match &group.clock.stamps {
        // A stated rate needs no stamps, unless they are asked for.
        Some(stamps) if !matches!(settings.rate, Some(RateSource::Hertz(_))) => {
            Some(time_base::examine(&group.clock, stamps)?)
        }
        _ => None,
    };
    let (rate_hz, rate_source) = rate(&group, base.as_ref(), settings)?;
    if !RATES.contains(&rate_hz) {
        return Err(no_rate(rate_hz, &format!(" {rate_source}")));
    }
    let rows = group.channels.first().map_or(0, |c| c.samples.len());
    let stated = group.clock.header_samples.filter(|&n| n > rows);
    if let Some(stated) = stated
        && !raw.warnings.iter().any(|w| w.code == "values-missing")
    {
        raw.warnings.push(Warning {
            code: "values-missing",
            message: format!("the header states {stated} samples, the file holds {rows}"),
            hint: Some("look whether the file was cut off".to_string()),
        });
    }
    if let (Some(_), Some(unread), None) = (&base, &group.clock.unread_rate, settings.rate) {
        raw.warnings.push(Warning {
            code: "header-rate-unread",
            message: format!("{}; the time stamps give the rate", unread.message),
            hint: None,
        });
    }
    let mut settled = Settled {
        rate_hz,
        stretches: match &base {
            Some(base) => stretches(base, rate_hz),
            None => vec![Stretch {
                rows: 0..rows,
                start: 0.0,
            }],
        },
        repairs: std::mem::take(&mut raw.repairs),
        warnings: std::mem::take(&mut raw.warnings),
        channels: group.channels,
    };
    if let (Some(base), Some(stamps)) = (&base, &group.clock.stamps) {
        settled.say_gaps(base, settings);
        settled.even_out(base, &stamps.seconds, stamps.resolution_s)?;
    }
    let empty = settled.empty_channels()?;
    if let Some(at) = empty
        .iter()
        .position(|e| *e)
        .filter(|_| !settings.only.is_empty())
    {
        let name = &settled.channels[at].name;
        return Err(left_out(name, "holds no number in any row"));
    }
    settled.split_at_missing(&empty)?;
    settled.crop(settings)?;
    if !settings.only.is_empty() {
        // The trigger was read for its level alone.
        settled.channels.truncate(settings.only.len());
    }
    if settings.gaps == Gaps::Fill {
        settled.fill()?;
    }
    settled.finish(raw, group.clock.start, rate_source, &calibrations)
}

/// Rows without a gap.
struct Stretch {
    rows: Range<usize>,
    /// Where it begins, in steps from the first sample of the log.
    start: f64,
}

impl Stretch {
    /// The place after its last sample.
    fn end(&self) -> f64 {
        self.start + self.rows.len() as f64
    }

    /// A part of it.
    fn part(&self, rows: Range<usize>) -> Stretch {
        let start = self.start + (rows.start - self.rows.start) as f64;
        Stretch { rows, start }
    }
}

/// The stretches of a time base, on whole steps where their stamps are.
fn stretches(base: &TimeBase, rate_hz: f64) -> Vec<Stretch> {
    let first = base.starts.first().copied().unwrap_or(0.0);
    let place = |start_s: &f64| {
        let place = (start_s - first) * rate_hz;
        match (place - place.round()).abs() < WHOLE {
            true => place.round(),
            false => place,
        }
    };
    let both = base.stretches.iter().zip(&base.starts);
    both.map(|(rows, start_s)| Stretch {
        rows: rows.clone(),
        start: place(start_s),
    })
    .collect()
}

/// The channels on their way.
struct Settled {
    rate_hz: f64,
    stretches: Vec<Stretch>,
    channels: Vec<RawChannel>,
    repairs: Vec<Repair>,
    warnings: Vec<Warning>,
}

/// The group that holds the channels asked for, those in the order asked for.
fn choose(raw: &mut Raw, settings: &Settings) -> Result<Group, Error> {
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
        // The longest group; a file nearly always has one.
        let largest =
            (0..raw.groups.len()).max_by_key(|&g| (samples(&raw.groups[g]), usize::MAX - g));
        return Ok(raw.groups.swap_remove(largest.unwrap_or(0)));
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
            let message = format!(
                "the channels {} do not share one clock: {} and {} samples",
                listed(words.iter().map(String::as_str)),
                samples(one),
                samples(two)
            );
            let hint = "analyse channels of one rate together; `geardyn check` lists the groups";
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

fn samples(group: &Group) -> usize {
    group.channels.first().map_or(0, |c| c.samples.len())
}

/// Groups of one length, rate and beginning were sampled together, whatever the file makes of it.
fn same_clock(one: &Group, two: &Group) -> bool {
    let rate = |c: &Clock| c.header_rate.as_ref().map(|r| r.0);
    let ends = |c: &Clock| -> Option<(f64, f64)> {
        let seconds = &c.stamps.as_ref()?.seconds;
        let mut end = [0.0];
        seconds.read(seconds.len().checked_sub(1)?, &mut end).ok()?;
        Some((end[0], seconds.len() as f64))
    };
    samples(one) == samples(two)
        && rate(&one.clock) == rate(&two.clock)
        && ends(&one.clock) == ends(&two.clock)
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
fn left_out(name: &str, why: &str) -> Error {
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
fn calibrations(channels: &[RawChannel], settings: &Settings) -> Result<Vec<Calibration>, Error> {
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

/// The rate, and where it comes from in words.
fn rate(
    group: &Group,
    base: Option<&TimeBase>,
    settings: &Settings,
) -> Result<(f64, String), Error> {
    let header = group.clock.header_rate.as_ref();
    let by_stamps = |base: &TimeBase| {
        let rows = samples(group);
        let how = match base.spacing {
            Spacing::Jittered { .. } => "mean",
            _ => "by regression",
        };
        (base.rate_hz, format!("{how} over {rows} stamps"))
    };
    if let (Some(RateSource::Header), _, None) | (None, None, None) = (settings.rate, base, header)
        && let Some(unread) = &group.clock.unread_rate
    {
        return Err(unread.clone());
    }
    match (settings.rate, base, header) {
        (Some(RateSource::Hertz(rate)), _, _) => Ok((rate, "as stated".to_string())),
        (Some(RateSource::Time), Some(base), _) => Ok(by_stamps(base)),
        (Some(RateSource::Time), None, _) => {
            let message = "the log has no time stamps to take the rate from";
            Err(Error::new(Code::RateUnknown, message).hint("state it: --rate HZ"))
        }
        (Some(RateSource::Header), _, Some((rate, key))) => {
            Ok((*rate, format!("as the header says ({key})")))
        }
        (Some(RateSource::Header), _, None) => {
            let message = "the header of the log states no sample rate";
            Err(Error::new(Code::RateUnknown, message)
                .hint("--rate-from time, or state it: --rate HZ"))
        }
        (None, Some(base), Some((rate, key)))
            if (rate / base.rate_hz - 1.0).abs() > SAME_RATE.max(3.0 * base.rate_std) =>
        {
            Err(disagree(group, base, *rate, key))
        }
        (None, Some(base), _) => Ok(by_stamps(base)),
        (None, None, Some((rate, key))) => Ok((*rate, format!("as the header says ({key})"))),
        (None, None, None) => {
            let message = "the log has neither time stamps nor a sample rate in its header";
            let hint = "state it: --rate HZ, or rate = \"… Hz\" in the sidecar";
            Err(Error::new(Code::RateUnknown, message).hint(hint))
        }
    }
}

/// The error of a rate that no recorder has.
fn no_rate(rate_hz: f64, source: &str) -> Error {
    let message = format!(
        "a sample rate of {rate_hz:e} Hz{source} cannot be: it lies outside of {:e} to {:e} Hz",
        RATES.start(),
        RATES.end()
    );
    Error::new(Code::OutOfRange, message)
        .hint("look at the unit of the rate, or of the time stamps")
}

/// The three ways to the rate, shown side by side.
fn disagree(group: &Group, base: &TimeBase, header: f64, key: &str) -> Error {
    let rows = samples(group);
    let stated = group.clock.header_samples.filter(|&n| n != rows);
    let counts = stated.map_or(String::new(), |n| {
        format!("; the header speaks of {n} samples, the file holds {rows}")
    });
    let message = format!(
        "the header ({key}) says {header} Hz, the time stamps say {:.6} Hz{counts}",
        base.rate_hz
    );
    Error::new(Code::RateDisagrees, message)
        .hint("say which is right: --rate-from time, or --rate-from header")
}

impl Settled {
    fn repair(&mut self, kind: &'static str, message: String) {
        self.repairs.push(Repair { kind, message });
    }

    fn say_gaps(&mut self, base: &TimeBase, settings: &Settings) {
        if let Spacing::Rounded { resolution_s } = base.spacing {
            let message = format!(
                "time stamps are rounded to {}: samples are taken as evenly spaced",
                crate::base::units::seconds(resolution_s)
            );
            self.warnings.push(Warning {
                code: "time-rounded",
                message,
                hint: None,
            });
        }
        if base.gaps.is_empty() || settings.gaps == Gaps::Fill {
            return;
        }
        let missing: usize = base.gaps.iter().map(|g| g.missing).sum();
        let first = &base.gaps[0];
        let place = first
            .line
            .map_or(format!("sample {}", first.row + 1), |line| {
                format!("line {line}")
            });
        let count = base.gaps.len();
        let message = format!(
            "{} of {}{}, the first before {place} ({:.6} s): split into {} stretches",
            counted(count, "gap"),
            if count == 1 { "" } else { "together " },
            counted(missing, "sample"),
            first.seconds,
            base.stretches.len()
        );
        self.repair("gap-split", message);
    }

    /// Resamples jittered rows.
    fn even_out(
        &mut self,
        base: &TimeBase,
        seconds: &Column,
        resolution_s: f64,
    ) -> Result<(), Error> {
        let Spacing::Jittered {
            rms_s,
            most_s,
            steps_s: (short, long),
        } = base.spacing
        else {
            return Ok(());
        };
        let rate = self.rate_hz;
        let longest = base
            .stretches
            .iter()
            .max_by_key(|s| s.len())
            .cloned()
            .unwrap_or(0..0);
        if longest.len() < 3 {
            let message = format!(
                "the longest stretch without a gap has {} samples",
                longest.len()
            );
            return Err(Error::new(Code::TooShort, message));
        }
        /// A clock that runs this many times as fast elsewhere has no rate.
        const UNEVEN: f64 = 2.0;
        /// Rows that tell the drift from the jitter.
        const TELLING: usize = 100;
        if longest.len() >= TELLING && base.drift_hz.1 > UNEVEN * base.drift_hz.0 {
            let text = crate::base::units::seconds;
            let message = format!(
                "the time stamps are too uneven to resample: steps of {} to {}",
                text(short),
                text(long)
            );
            return Err(Error::new(Code::BadTime, message)
                .hint("log with even steps, or leave the stamps aside: --time none --rate HZ"));
        }
        let band = resample::best_band(seconds, &longest, rate)?;
        let columns: Vec<&Column> = self.channels.iter().map(|c| &c.samples).collect();
        let mut outputs: Vec<Column> = columns.iter().map(|_| Column::default()).collect();
        let (mut worst, mut worst_at_ends, mut at) = (0.0f64, 0.0f64, 0);
        for (rows, &start_s) in base.stretches.iter().zip(&base.starts) {
            let grid = Grid {
                rows: rows.clone(),
                start_s,
                count: rows.len(),
            };
            let quality = resample::resample(seconds, &columns, &grid, rate, band, &mut outputs)?;
            worst = worst.max(quality.error);
            worst_at_ends = worst_at_ends.max(quality.error_at_ends);
        }
        // The outputs hold the stretches end to end.
        for stretch in &mut self.stretches {
            stretch.rows = at..at + stretch.rows.len();
            at = stretch.rows.end;
        }
        for (channel, output) in self.channels.iter_mut().zip(outputs) {
            channel.samples = output;
        }
        /// An error this large, −20 dB, is no resampling.
        const USELESS: f64 = 0.1;
        if worst > USELESS {
            let message = format!(
                "the time stamps are too uneven to resample: even below {band:.4} Hz the error would be {:.0} %",
                100.0 * worst
            );
            return Err(Error::new(Code::BadTime, message)
                .hint("log with even steps, or leave the stamps aside: --time none --rate HZ"));
        }
        let decibels = |error: f64| 20.0 * error.max(1e-12).log10();
        let minus = |error: f64| format!("{:.0}", decibels(error)).replace('-', "−");
        let (inside, at_ends) = (minus(worst), minus(worst_at_ends));
        let ends = resample::ENDS;
        let text = crate::base::units::seconds;
        let drift = match (base.drift_hz.1 / base.drift_hz.0 - 1.0).abs() > SAME_RATE {
            true => format!(
                "; the clock drifts between {:.1} and {:.1} Hz",
                base.drift_hz.0, base.drift_hz.1
            ),
            false => String::new(),
        };
        // Stamps whose last digit is a good part of a step are rounded as well.
        const COARSE: f64 = 0.02;
        let rounded = match resolution_s * rate > COARSE {
            true => format!(", rounded to {}", text(resolution_s)),
            false => String::new(),
        };
        let message = format!(
            "resampled to {rate:.6} Hz, band-limited: error below {inside} dB up to {band:.4} Hz, {at_ends} dB within {ends} samples of an end of a stretch (stamps up to {} off an even grid, {} rms, steps of {} to {}{rounded}{drift})",
            text(most_s),
            text(rms_s),
            text(short),
            text(long)
        );
        self.repair("resampled", message);
        let message = format!("the jitter of the time stamps limits trust above {band:.4} Hz");
        self.warnings.push(Warning {
            code: "time-jitter",
            message,
            hint: None,
        });
        Ok(())
    }

    /// Stretches end where a channel has no number.
    fn split_at_missing(&mut self, empty: &[bool]) -> Result<(), Error> {
        let rows = self.channels.first().map_or(0, |c| c.samples.len());
        let mut block = vec![0.0; BLOCK.min(rows)];
        let (mut holes, mut rows_kept) = (0usize, Vec::new());
        let mut bad = vec![false; BLOCK.min(rows)];
        let mut open: Option<usize> = None;
        let starts: Vec<usize> = self.stretches.iter().map(|s| s.rows.start).collect();
        let mut at = 0;
        while at < rows {
            let count = BLOCK.min(rows - at);
            bad[..count].fill(false);
            for (channel, empty) in self.channels.iter().zip(empty) {
                if *empty {
                    continue;
                }
                channel.samples.read(at, &mut block[..count])?;
                for (bad, x) in bad.iter_mut().zip(&block[..count]) {
                    *bad |= !x.is_finite();
                }
            }
            for (j, &bad) in bad[..count].iter().enumerate() {
                let row = at + j;
                if (bad || starts.binary_search(&row).is_ok())
                    && let Some(start) = open.take()
                    && start < row
                {
                    rows_kept.push(start..row);
                }
                holes += usize::from(bad);
                if !bad && open.is_none() {
                    open = Some(row);
                }
            }
            at += count;
        }
        rows_kept.extend(open.map(|start| start..rows));
        if holes > 0 {
            let rows = match holes {
                1 => "1 row has a channel without a number".to_string(),
                n => format!("{n} rows have a channel without a number"),
            };
            let left = match rows_kept.len() {
                1 => "the stretch beside is used".to_string(),
                n => format!("{n} stretches without such rows are used"),
            };
            self.repair("cells-missing", format!("{rows}: {left}"));
        }
        if rows_kept.is_empty() {
            return Err(
                Error::new(Code::NoSignal, "no sample has a number in every channel").hint(
                    "choose channels that have numbers at the same time: --channel, --output",
                ),
            );
        }
        let of = |rows: Range<usize>| {
            let after = starts.partition_point(|&start| start <= rows.start);
            self.stretches[after.saturating_sub(1)].part(rows)
        };
        self.stretches = rows_kept.into_iter().map(of).collect();
        Ok(())
    }

    /// Channels without any number, which are of no use but harm nobody while they are not asked for.
    fn empty_channels(&self) -> Result<Vec<bool>, Error> {
        self.channels
            .iter()
            .map(|channel| {
                let n = channel.samples.len();
                let mut block = vec![0.0; BLOCK.min(n)];
                let mut at = 0;
                while at < n {
                    let count = BLOCK.min(n - at);
                    channel.samples.read(at, &mut block[..count])?;
                    if block[..count].iter().any(|x| x.is_finite()) {
                        return Ok(false);
                    }
                    at += count;
                }
                Ok(true)
            })
            .collect()
    }

    /// Straight lines over gaps of the stamps and over missing numbers.
    fn fill(&mut self) -> Result<(), Error> {
        /// More than this many times what was measured is nothing but straight lines.
        const MOST: f64 = 10.0;
        let (Some(first), Some(last)) = (self.stretches.first(), self.stretches.last()) else {
            return Ok(());
        };
        if self.stretches.len() < 2 {
            return Ok(());
        }
        let (start, length) = (first.start, last.end() - first.start);
        let held: usize = self.stretches.iter().map(|s| s.rows.len()).sum();
        if length > MOST * held as f64 {
            let message = format!(
                "{held} samples lie spread over {:.6} s, {length:.0} steps: filling the gaps would make up nearly all of it",
                length / self.rate_hz
            );
            return Err(Error::new(Code::OutOfRange, message)
                .hint("leave the gaps, or analyse a part without them: --after, --before"));
        }
        let steps = (self.stretches.windows(2)).map(|pair| pair[1].start - pair[0].end());
        let (mut missing, mut off, mut most) = (Vec::new(), 0.0, 0.0f64);
        for steps in steps {
            let whole = (steps + off).round().max(0.0);
            off += steps - whole;
            most = most.max(f64::abs(off));
            missing.push(whole as usize);
        }
        for channel in &mut self.channels {
            let mut whole = Column::default();
            let mut before = 0.0;
            for (at, stretch) in self.stretches.iter().enumerate() {
                let (mut first, mut last) = ([0.0], [0.0]);
                channel.samples.read(stretch.rows.start, &mut first)?;
                channel.samples.read(stretch.rows.end - 1, &mut last)?;
                if let Some(&missing) = at.checked_sub(1).and_then(|at| missing.get(at)) {
                    let step = (first[0] - before) / (missing + 1) as f64;
                    let bridge: Vec<f64> =
                        (1..=missing).map(|k| before + k as f64 * step).collect();
                    whole.push(&bridge)?;
                }
                copy(&channel.samples, stretch.rows.clone(), &mut whole, 1.0)?;
                before = last[0];
            }
            channel.samples = whole;
        }
        let filled: usize = missing.iter().sum();
        self.stretches = vec![Stretch {
            rows: 0..held + filled,
            start,
        }];
        let moved = match most > WHOLE {
            true => format!("; stretches are moved by up to {most:.2} steps to fit"),
            false => String::new(),
        };
        let message = format!(
            "{} filled by straight lines, as asked: spectra near and above the width of the gaps are made up{moved}",
            counted(filled, "missing sample")
        );
        self.repair("gap-filled", message);
        Ok(())
    }

    /// The place, at or after another, before which nothing is kept: the trigger's level is reached there or a little later.
    fn triggered(&mut self, trigger: &Trigger, from: f64) -> Result<f64, Error> {
        let known: Vec<String> = self.channels.iter().map(|c| c.name.clone()).collect();
        let found = names::find(&trigger.channel, &known);
        let at = found.ok_or_else(|| no_channel(&trigger.channel, &known))?;
        let mut largest = 0.0f64;
        let mut reached = None;
        for stretch in &self.stretches {
            let mut block = vec![0.0; BLOCK.min(stretch.rows.len())];
            let mut row = stretch.rows.start;
            while row < stretch.rows.end && reached.is_none() {
                let count = BLOCK.min(stretch.rows.end - row);
                self.channels[at].samples.read(row, &mut block[..count])?;
                for (k, x) in block[..count].iter().enumerate() {
                    let place = stretch.start + (row + k - stretch.rows.start) as f64;
                    if place < from {
                        continue;
                    }
                    largest = largest.max(x.abs());
                    if x.abs() >= trigger.level {
                        reached = Some(place);
                        break;
                    }
                }
                row += count;
            }
        }
        let Some(place) = reached else {
            let message = format!(
                "the channel {} never reaches the level {} of the trigger: {largest:.6} at most",
                known[at], trigger.level
            );
            return Err(Error::new(Code::NoSignal, message)
                .hint("choose a lower level, in the numbers of the log"));
        };
        let start = (place - (trigger.before_s * self.rate_hz).round()).max(from);
        let message = format!(
            "kept from {:.6} s on: {} reaches {} at {:.6} s",
            start / self.rate_hz,
            known[at],
            trigger.level,
            place / self.rate_hz
        );
        self.repair("triggered", message);
        Ok(start)
    }

    /// Only the time that was asked for.
    fn crop(&mut self, settings: &Settings) -> Result<(), Error> {
        let end = self.stretches.last().map_or(0.0, Stretch::end);
        let steps = |t: f64| (t * self.rate_hz).round();
        let (mut from, to) = (
            settings.from_s.map_or(0.0, steps),
            settings.to_s.map_or(end, steps),
        );
        if let Some(trigger) = &settings.trigger {
            from = self.triggered(trigger, from)?;
        }
        if from >= to.min(end) {
            let message = format!(
                "nothing lies between the times asked for: the log lasts {:.6} s",
                end / self.rate_hz
            );
            return Err(Error::new(Code::OutOfRange, message));
        }
        let cut = |s: &Stretch| {
            let row = |place: f64| {
                s.rows.start + (place - s.start).round().clamp(0.0, s.rows.len() as f64) as usize
            };
            s.part(row(from)..row(to))
        };
        self.stretches = self
            .stretches
            .iter()
            .map(cut)
            .filter(|s| !s.rows.is_empty())
            .collect();
        if self.stretches.is_empty() {
            return Err(Error::new(
                Code::NoSignal,
                "no samples lie between the times asked for",
            ));
        }
        Ok(())
    }

    /// Scales, and puts the stretches end to end.
    fn finish(
        self,
        raw: Raw,
        start: Option<String>,
        rate_source: String,
        calibrations: &[Calibration],
    ) -> Result<Recording, Error> {
        let mut channels = Vec::new();
        for (channel, calibration) in self.channels.into_iter().zip(calibrations) {
            let overloads = channel.overloads;
            let whole =
                matches!(&self.stretches[..], [one] if one.rows == (0..channel.samples.len()));
            let samples = match whole && calibration.factor == 1.0 {
                true => channel.samples,
                false => {
                    let mut scaled = Column::default();
                    for stretch in &self.stretches {
                        copy(
                            &channel.samples,
                            stretch.rows.clone(),
                            &mut scaled,
                            calibration.factor,
                        )?;
                    }
                    scaled
                }
            };
            channels.push(Channel {
                name: calibration.name.clone(),
                unit: calibration.unit.clone(),
                samples,
                overload_level: calibration.overload,
                overloads,
            });
        }
        let mut at = 0;
        let packed = |s: &Stretch| {
            let start = at;
            at += s.rows.len();
            start..at
        };
        let stretches: Vec<Range<usize>> = self.stretches.iter().map(packed).collect();
        Ok(Recording {
            path: raw.path,
            dialect: raw.dialect,
            facts: raw.facts,
            rate_hz: self.rate_hz,
            rate_source,
            samples: at,
            stretches,
            starts: self.stretches.iter().map(|s| s.start).collect(),
            start,
            channels,
            repairs: self.repairs,
            warnings: self.warnings,
        })
    }
}

/// Appends a stretch of one column to another, times a factor.
fn copy(from: &Column, rows: Range<usize>, to: &mut Column, factor: f64) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(rows.len())];
    let mut at = rows.start;
    while at < rows.end {
        let count = BLOCK.min(rows.end - at);
        from.read(at, &mut block[..count])?;
        block[..count].iter_mut().for_each(|x| *x *= factor);
        to.push(&block[..count])?;
        at += count;
    }
    Ok(())
}

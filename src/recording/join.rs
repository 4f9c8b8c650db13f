//! Several files of one test become one recording: samples end to end, every file in segments of its own.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use super::channel_names;
use super::raw::Repair;
use super::signals::{Channel, LogFile, Recording};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list};

/// Rates of one test, and with them its spectral lines, differ by less, relative; a frequency is wrong by no more than that. Quartz clocks
/// keep 50e-6.
pub const EQUAL_RATES: f64 = 1e-4;

/// Samples moved at a time.
const BLOCK: usize = 1 << 16;

/// Joins the recordings of one test in their order.
///
/// # Errors
/// `conflict`: channels, their units or overload levels differ, or two files hold the same samples; `rate-disagrees`; samples that
/// cannot be moved.
///
/// # Panics
/// No recording: a mistake of the caller.
pub fn join(recordings: Vec<Recording>) -> Result<Recording, Error> {
    let mut recordings = recordings.into_iter();
    #[allow(clippy::expect_used, reason = "stated under Panics")]
    let mut joined = recordings.next().expect("a test has a file");
    let mut prints = vec![(joined.path.clone(), fingerprint(&joined)?)];
    let (mut repairs, mut warnings) = (MessageCollector::default(), MessageCollector::default());
    let first = joined.path.clone();
    take_messages(&mut joined, &first, &mut repairs, &mut warnings);
    for mut next in recordings {
        let path = next.path.clone();
        refuse_different(&joined, &next).map_err(|e| e.with_file(&path))?;
        let print = fingerprint(&next)?;
        if let Some((other, _)) = prints.iter().find(|(_, p)| *p == print) {
            let message = format!("{path} and {other} contain the same samples");
            return Err(Error::new(Code::Conflict, message).with_hint(
                "name each record once: a record that counts twice makes intervals too narrow",
            ));
        }
        prints.push((path.clone(), print));
        take_messages(&mut next, &path, &mut repairs, &mut warnings);
        append(&mut joined, next)?;
    }
    let files = prints.len();
    let whose = |place: &[String], message: &str| match place.len() == files {
        true => message.to_string(),
        false => format!(
            "{}: {message}",
            quoted_list(place.iter().map(String::as_str))
        ),
    };
    if files > 1 {
        let names = quoted_list(prints.iter().map(|p| p.0.as_str()));
        joined.path = format!("{} ({names})", pluralise(files, "file"));
        let message = format!(
            "{} read as one test, {:.4} s at {} Hz: {names}",
            pluralise(files, "file"),
            joined.duration_s(),
            (joined.rate_hz * 1e6).round() / 1e6
        );
        joined.repairs.push(Repair {
            kind: "files-joined",
            message,
        });
    }
    let repair = |(kind, message, _, place): JoinedMessage| Repair {
        kind,
        message: whose(&place, &message),
    };
    joined.repairs.extend(repairs.0.into_iter().map(repair));
    let warning = |(code, message, hint, place): JoinedMessage| Diagnostic {
        code,
        message: whose(&place, &message),
        hint,
    };
    joined
        .diagnostics
        .extend(warnings.0.into_iter().map(warning));
    Ok(joined)
}

/// A kind, its message, its remedy, and the files it applies to.
type JoinedMessage = (&'static str, String, Option<String>, Vec<String>);

/// Messages of several files, each once.
#[derive(Default)]
struct MessageCollector(Vec<JoinedMessage>);

impl MessageCollector {
    fn take(&mut self, kind: &'static str, message: String, hint: Option<String>, path: &str) {
        let same = |m: &&mut JoinedMessage| m.0 == kind && m.1 == message;
        match self.0.iter_mut().find(same) {
            Some(known) => known.3.push(path.to_string()),
            None => self.0.push((kind, message, hint, vec![path.to_string()])),
        }
    }
}

fn take_messages(
    from: &mut Recording,
    path: &str,
    repairs: &mut MessageCollector,
    warnings: &mut MessageCollector,
) {
    for r in std::mem::take(&mut from.repairs) {
        repairs.take(r.kind, r.message, None, path);
    }
    for w in std::mem::take(&mut from.diagnostics) {
        warnings.take(w.code, w.message, w.hint, path);
    }
}

/// Refuses a file that is not of the same test.
fn refuse_different(first: &Recording, next: &Recording) -> Result<(), Error> {
    let between = |what: String| {
        let message = format!("{what}: files of one test have equal channels, units and rates");
        Error::new(Code::Conflict, message)
    };
    let (one, two) = (first.rate_hz, next.rate_hz);
    if (one / two - 1.0).abs() > EQUAL_RATES {
        let message = format!(
            "the rate is {two:.6} Hz, that of {} is {one:.6} Hz (limit {:.2} %)",
            first.files.first().map_or("the first file", |f| &f.path),
            100.0 * EQUAL_RATES
        );
        return Err(Error::new(Code::RateDisagrees, message)
            .with_hint("identify files of different rates one by one, or state the rate: --rate"));
    }
    let names = |r: &Recording| quoted_list(r.channels.iter().map(|c| c.name.as_str()));
    if first.channels.len() != next.channels.len() {
        let message = format!(
            "the channels are {}, those of the first file {}",
            names(next),
            names(first)
        );
        return Err(between(message).with_hint("name the channels to use: --input, --output"));
    }
    for channel in &first.channels {
        let Some(other) = place(next, channel).map(|at| &next.channels[at]) else {
            let message = format!("no channel {}, only {}", channel.name, names(next));
            return Err(between(message).with_hint("rename channels in the sidecar of the file"));
        };
        if other.unit != channel.unit {
            let word = |unit: &str| match unit {
                "" => "no unit".to_string(),
                unit => unit.to_string(),
            };
            let message = format!(
                "{} has {}, in the first file {}",
                channel.name,
                word(&other.unit),
                word(&channel.unit)
            );
            return Err(between(message).with_hint("state the unit: --unit, or in the sidecar"));
        }
        if other.overload_level != channel.overload_level {
            let message = format!("{} has another overload level", channel.name);
            return Err(between(message).with_hint("state one for all files: --overload"));
        }
    }
    Ok(())
}

/// The place of a channel of another file.
fn place(among: &Recording, channel: &Channel) -> Option<usize> {
    let known: Vec<String> = among.channels.iter().map(|c| c.name.clone()).collect();
    channel_names::find_channel(&channel.name, &known)
}

/// Puts the samples of a file behind those of the others.
fn append(joined: &mut Recording, next: Recording) -> Result<(), Error> {
    let at = joined.samples;
    let mut block = vec![0.0; BLOCK.min(next.samples)];
    for channel in &mut joined.channels {
        let Some(other) = place(&next, channel).map(|at| &next.channels[at]) else {
            continue;
        };
        #[allow(
            clippy::expect_used,
            reason = "a recording that is joined has no parts yet"
        )]
        let samples = Arc::get_mut(&mut channel.samples).expect("columns of its own");
        let mut from = 0;
        while from < next.samples {
            let count = BLOCK.min(next.samples - from);
            other.samples.read(from, &mut block[..count])?;
            samples.push(&block[..count])?;
            from += count;
        }
        channel.overloads += other.overloads;
    }
    let moved = next.segments.iter().map(|s| s.start + at..s.end + at);
    joined.segments.extend(moved);
    joined.segment_starts.extend(next.segment_starts);
    joined.samples += next.samples;
    joined.files.push(LogFile {
        path: next.path,
        samples: at..joined.samples,
        first_s: next.files.first().map_or(0.0, |f| f.first_s),
    });
    Ok(())
}

/// Fingerprint of a record by its samples, which distinguishes it from others.
fn fingerprint(recording: &Recording) -> Result<u64, Error> {
    let mut print = DefaultHasher::new();
    recording.samples.hash(&mut print);
    let mut block = vec![0.0; BLOCK.min(recording.samples)];
    for channel in &recording.channels {
        let mut at = 0;
        while at < recording.samples {
            let count = BLOCK.min(recording.samples - at);
            channel.samples.read(at, &mut block[..count])?;
            (block[..count].iter()).for_each(|x: &f64| x.to_bits().hash(&mut print));
            at += count;
        }
    }
    Ok(print.finish())
}

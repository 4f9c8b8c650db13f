//! Modes of free decays: a decay for each segment of a record, from the release until it has fallen into the noise.

use super::identification_result::{Evidence, IdentifiedMode, SignalIdentification};
use super::identify_study::IdentifyStudy;
use super::method::IdentificationMethod;
use super::rational::{modes_over_table, rule};
use super::{sample_blocks, weak};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::{pluralise, quoted_list};
use crate::identify::free_decay::{TOP, fit};
use crate::identify::rational::RationalOptions;
use crate::numeric::fft::prev_fast_len;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::impact::{decay_length, levels};

/// Length of a decay segment, as a multiple of the time in which the decay exceeds the noise of one sample.
const TAIL: usize = 3;

/// Shorter decays have no lines to fit.
const SHORTEST: usize = 64;

/// Result of the free-decay analysis.
pub struct Decays {
    /// Modes and what they rest on.
    pub identification: SignalIdentification,
    /// Misfit by channel and decay.
    pub fit_error: Vec<f64>,
    /// Description of the segmentation of the record, as text.
    pub how: String,
    /// The band fitted, Hz.
    pub band_hz: (f64, f64),
    /// Number of decays.
    pub count: usize,
}

/// Level of all channels by segment, about the mean of each segment, every channel over its largest.
fn level(channels: &[&[f64]]) -> Vec<f64> {
    let of = |samples: &&[f64]| -> Vec<f64> {
        let segment = samples.len().div_ceil(SEGMENTS).max(2);
        let one = |part: &[f64]| {
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            part.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / part.len() as f64
        };
        let power: Vec<f64> = samples.chunks_exact(segment).map(one).collect();
        let largest = power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        power.iter().map(|p| p / largest).collect()
    };
    let all: Vec<Vec<f64>> = channels.iter().map(of).collect();
    let count = all.first().map_or(0, Vec::len);
    (0..count)
        .map(|k| (all.iter().map(|c| c[k]).sum::<f64>() / all.len() as f64).sqrt())
        .collect()
}

/// Segments of a record whose levels are compared.
const SEGMENTS: usize = 64;

fn largest(level: &[f64]) -> usize {
    (0..level.len())
        .max_by(|&a, &b| level[a].total_cmp(&level[b]))
        .unwrap_or(0)
}

/// Whether segments of a record are free decays: quiet, or held, before the largest level, and falling behind it by 20 dB and
/// more without rising again.
pub fn is_decay(channels: &[&[f64]]) -> bool {
    const QUIET: f64 = 0.3;
    const FALL: f64 = 10.0;
    const RISE: f64 = 1.4;
    let level = level(channels);
    let top = largest(&level);
    let (Some(&last), true) = (level.last(), level.len() >= SEGMENTS / 2) else {
        return false;
    };
    // The release may lie in the segment before the largest.
    let before = &level[..top.saturating_sub(1)];
    let noise = level[top..].iter().copied().fold(f64::INFINITY, f64::min);
    let mut reached = level[top];
    let falls = level[top..].iter().all(|&l| {
        let is_below = l <= RISE * reached + 2.0 * noise;
        reached = reached.min(l);
        is_below
    });
    2 * top < level.len()
        && FALL * last <= level[top]
        && before.iter().all(|&l| l <= QUIET * level[top])
        && falls
}

/// From where to where a segment decays, in samples. The release lies in the segment of the largest level or before it; the
/// decay is taken from the end of that segment, and looked at closer for as long as it takes up a small part of what was looked
/// at.
fn decay(channels: &[&[f64]]) -> std::ops::Range<usize> {
    const CLOSER: usize = 4;
    let length = channels.first().map_or(0, |c| c.len());
    let (mut from, mut to) = (0, length);
    loop {
        let views: Vec<&[f64]> = channels.iter().map(|c| &c[from..to]).collect();
        let segment = (to - from).div_ceil(SEGMENTS).max(2);
        let top = largest(&level(&views));
        let start = from + ((top + 1) * segment).min(to - from);
        let lasts = (channels.iter())
            .map(|c| {
                let tail = &c[to - (to - from) / 8..to];
                let mean = tail.iter().sum::<f64>() / tail.len().max(1) as f64;
                let centred: Vec<f64> = c[start..to].iter().map(|x| x - mean).collect();
                let noise = levels(&centred).into_iter().fold(f64::INFINITY, f64::min);
                decay_length(&centred, noise)
            })
            .max()
            .unwrap_or(0);
        let end = (start + TAIL * lasts).min(to);
        let before = from + top.saturating_sub(1) * segment;
        if CLOSER * (end - before) > to - from || end - before < CLOSER * SHORTEST {
            return start..end;
        }
        (from, to) = (before, end);
    }
}

/// Whether each segment of the channels is a free decay; of records too long to be decays nothing.
///
/// # Errors
/// Samples that cannot be read.
pub fn decaying_segments(recording: &Recording, outputs: &[usize]) -> Result<Vec<bool>, Error> {
    /// Longer records are of something else.
    const MAX_LEN: usize = 20_000_000;
    if recording.samples.saturating_mul(outputs.len()) > MAX_LEN {
        return Ok(Vec::new());
    }
    let channels: Vec<&Channel> = outputs.iter().map(|&c| &recording.channels[c]).collect();
    let samples = sample_blocks::load_channels(recording, &channels, "a free decay")?;
    let one = |s: &std::ops::Range<usize>| {
        let views: Vec<&[f64]> = samples.iter().map(|y| &y[s.clone()]).collect();
        is_decay(&views)
    };
    Ok(recording.segments.iter().map(one).collect())
}

/// Files that do not ring down, of a test in which others do.
pub fn other_files(recording: &Recording, decays: &[bool]) -> Option<String> {
    let of = |wanted: bool| -> Vec<&str> {
        let mut paths: Vec<&str> = Vec::new();
        for (segment, _) in recording
            .segments
            .iter()
            .zip(decays)
            .filter(|s| *s.1 == wanted)
        {
            let file = recording
                .files
                .iter()
                .find(|f| f.samples.contains(&segment.start));
            paths.extend(file.map(|f| f.path.as_str()));
        }
        paths.dedup();
        paths
    };
    let (others, decaying) = (of(false), of(true));
    (recording.files.len() > 1 && !others.is_empty() && !decaying.is_empty()).then(|| {
        let verb = if others.len() == 1 { "does" } else { "do" };
        format!(
            "{} {verb} not ring down as {} does",
            quoted_list(others.into_iter()),
            quoted_list(decaying.into_iter().take(1))
        )
    })
}

/// Misfit of a decay, relative, from which on its modes rest on what the fit does not describe.
const MAX_MISFIT: f64 = 0.5;

/// Names the decays that the fit misses by half their size.
fn poor_fit(
    fit_error: &[f64],
    channels: &[&Channel],
    files: &[Option<String>],
) -> Option<Diagnostic> {
    let one = |(at, error): (usize, &f64)| {
        let (channel, decay) = (at / files.len(), at % files.len());
        let place = match &files[decay] {
            Some(file) => format!(" of {file}"),
            None if files.len() > 1 => format!(" of decay {}", decay + 1),
            None => String::new(),
        };
        format!(
            "{}{place} by {:.0} %",
            channels[channel].name,
            100.0 * error
        )
    };
    let all = fit_error.iter().enumerate();
    let missed: Vec<String> = all.filter(|(_, e)| !(**e <= MAX_MISFIT)).map(one).collect();
    (!missed.is_empty()).then(|| Diagnostic {
        code: "poor-fit",
        message: format!(
            "the fit misses {} of its size: modes and intervals rest on what it does not describe",
            missed.join(", ")
        ),
        hint: Some("omit records that do not ring down, or narrow the band: --band".to_string()),
    })
}

/// Fits the decays of all segments together.
///
/// # Errors
/// `too-short` where nothing decays; those of the fit.
pub fn identify(
    recording: &Recording,
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<Decays, Error> {
    let channels: Vec<&Channel> = outputs.iter().map(|&c| &recording.channels[c]).collect();
    let samples = sample_blocks::load_channels(recording, &channels, "a free decay")?;
    let rate = recording.rate_hz;
    let cut: Vec<std::ops::Range<usize>> = (recording.segments.iter())
        .map(|s| {
            let views: Vec<&[f64]> = samples.iter().map(|y| &y[s.clone()]).collect();
            let own = decay(&views);
            s.start + own.start..s.start + own.end
        })
        .collect();
    let files: Vec<Option<String>> = (cut.iter())
        .map(|r| {
            recording
                .moment(r.start.min(recording.samples.saturating_sub(1)))
                .file
        })
        .collect();
    let shortest = (cut.iter().zip(&files)).min_by_key(|(r, _)| r.len());
    let longest = shortest.map_or(0, |(r, _)| r.len());
    if longest < SHORTEST {
        let message = match longest {
            0 => "nothing rings down: no level falls behind the largest".to_string(),
            n => format!("a decay of {} is too short to fit", pluralise(n, "sample")),
        };
        let error = Error::new(Code::TooShort, message).with_hint(match longest {
            0 => "leave the record out, or take it as driven by noise: --method ssi-cov",
            _ => "record from before the release until nothing moves, or sample faster",
        });
        return Err(match shortest.and_then(|(_, file)| file.as_ref()) {
            Some(file) => error.with_file(file),
            None => error,
        });
    }
    let length = prev_fast_len(longest);
    let decays: Vec<Vec<&[f64]>> = (cut.iter())
        .map(|r| {
            samples
                .iter()
                .map(|y| &y[r.start..r.start + length])
                .collect()
        })
        .collect();
    let apart_hz = rate / length as f64;
    let band_hz = study.band_hz.unwrap_or((apart_hz, TOP * rate));
    let options = RationalOptions {
        band_hz: Some(band_hz),
        order: study.order,
        ..RationalOptions::default()
    };
    let fit = fit(rate, &decays, &options)?;
    let table: Vec<Vec<usize>> = (0..channels.len())
        .map(|c| (c * cut.len()..(c + 1) * cut.len()).collect())
        .collect();
    let modes = modes_over_table(&fit, &table, 0.0)?;
    let is_weak = |m: &IdentifiedMode| weak::reason(m, apart_hz, None);
    let (modes, weak) = weak::split_weak(modes, is_weak, study.all);
    let starts: Vec<String> = (cut.iter().take(6))
        .map(|r| format!("{:.4} s", recording.moment(r.start).time_s))
        .collect();
    let how = format!(
        "{} from {}{}, {:.4} s each: transforms without window or leakage, lines {apart_hz:.4} Hz apart",
        pluralise(cut.len(), "free decay"),
        starts.join(", "),
        if cut.len() > starts.len() {
            ", …"
        } else {
            ""
        },
        length as f64 / rate,
    );
    let mut diagnostics = fit.diagnostics.clone();
    diagnostics.extend(poor_fit(&fit.fit_error, &channels, &files));
    Ok(Decays {
        fit_error: fit.fit_error.clone(),
        how,
        band_hz,
        count: cut.len(),
        identification: SignalIdentification {
            modes,
            weak,
            harmonics: Vec::new(),
            selection_rule: rule(IdentificationMethod::Rational, fit.departs),
            evidence: Evidence::Rational(fit),
            diagnostics,
        },
    })
}

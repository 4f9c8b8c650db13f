//! Modal identification from free decays: one decay per segment of a record, from the release until it reaches the noise.

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

/// Minimum length of a decay, samples; shorter decays have too few spectral lines.
const MIN_SAMPLES: usize = 64;

/// Result of the free-decay analysis.
pub struct FreeDecayResult {
    /// Modes with their evidence.
    pub identification: SignalIdentification,
    /// Relative fit error by channel and decay.
    pub fit_error: Vec<f64>,
    /// Description of the segmentation of the record.
    pub method_text: String,
    /// Fitted band, Hz.
    pub band_hz: (f64, f64),
    /// Number of decays.
    pub count: usize,
}

/// Rms level over all channels by block, about the mean of each block, each channel relative to its maximum.
fn level(channels: &[&[f64]]) -> Vec<f64> {
    let relative_power = |samples: &&[f64]| -> Vec<f64> {
        let length = samples.len().div_ceil(BLOCKS).max(2);
        let variance = |block: &[f64]| {
            let mean = block.iter().sum::<f64>() / block.len() as f64;
            block.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / block.len() as f64
        };
        let power: Vec<f64> = samples.chunks_exact(length).map(variance).collect();
        let largest = power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        power.iter().map(|p| p / largest).collect()
    };
    let powers: Vec<Vec<f64>> = channels.iter().map(relative_power).collect();
    let count = powers.first().map_or(0, Vec::len);
    (0..count)
        .map(|k| (powers.iter().map(|c| c[k]).sum::<f64>() / powers.len() as f64).sqrt())
        .collect()
}

/// Number of blocks of a record whose levels are compared.
const BLOCKS: usize = 64;

fn largest(level: &[f64]) -> usize {
    (0..level.len())
        .max_by(|&a, &b| level[a].total_cmp(&level[b]))
        .unwrap_or(0)
}

/// True if the channels of a segment decay freely: quiet or held before the maximum level, then falling by 20 dB or more without
/// rising again.
pub fn is_decay(channels: &[&[f64]]) -> bool {
    const QUIET: f64 = 0.3;
    const FALL: f64 = 10.0;
    const RISE: f64 = 1.4;
    let level = level(channels);
    let top = largest(&level);
    let (Some(&last), true) = (level.last(), level.len() >= BLOCKS / 2) else {
        return false;
    };
    // The release may lie in the block before the maximum.
    let prior = &level[..top.saturating_sub(1)];
    let noise = level[top..].iter().copied().fold(f64::INFINITY, f64::min);
    let mut lowest = level[top];
    let is_falling = level[top..].iter().all(|&l| {
        let is_below = l <= RISE * lowest + 2.0 * noise;
        lowest = lowest.min(l);
        is_below
    });
    2 * top < level.len()
        && FALL * last <= level[top]
        && prior.iter().all(|&l| l <= QUIET * level[top])
        && is_falling
}

/// Sample range of the decay in a segment. The release lies in the block of maximum level or in the one before it, and the decay
/// starts at the end of that block; the search is repeated on the range of the decay while that is a small part of the range.
fn decay(channels: &[&[f64]]) -> std::ops::Range<usize> {
    const ZOOM: usize = 4;
    let length = channels.first().map_or(0, |c| c.len());
    let (mut from, mut to) = (0, length);
    loop {
        let views: Vec<&[f64]> = channels.iter().map(|c| &c[from..to]).collect();
        let block = (to - from).div_ceil(BLOCKS).max(2);
        let top = largest(&level(&views));
        let start = from + ((top + 1) * block).min(to - from);
        let decay_samples = (channels.iter())
            .map(|c| {
                let tail = &c[to - (to - from) / 8..to];
                let mean = tail.iter().sum::<f64>() / tail.len().max(1) as f64;
                let centred: Vec<f64> = c[start..to].iter().map(|x| x - mean).collect();
                let noise = levels(&centred).into_iter().fold(f64::INFINITY, f64::min);
                decay_length(&centred, noise)
            })
            .max()
            .unwrap_or(0);
        let end = (start + TAIL * decay_samples).min(to);
        let release = from + top.saturating_sub(1) * block;
        if ZOOM * (end - release) > to - from || end - release < ZOOM * MIN_SAMPLES {
            return start..end;
        }
        (from, to) = (release, end);
    }
}

/// True for each segment that is a free decay; empty for records too long to be free decays.
///
/// # Errors
/// Samples that cannot be read.
pub fn decaying_segments(recording: &Recording, outputs: &[usize]) -> Result<Vec<bool>, Error> {
    /// Maximum number of samples over all channels.
    const MAX_LEN: usize = 20_000_000;
    if recording.samples.saturating_mul(outputs.len()) > MAX_LEN {
        return Ok(Vec::new());
    }
    let channels: Vec<&Channel> = outputs.iter().map(|&c| &recording.channels[c]).collect();
    let samples = sample_blocks::load_channels(recording, &channels, "a free decay")?;
    let is_decaying = |s: &std::ops::Range<usize>| {
        let views: Vec<&[f64]> = samples.iter().map(|y| &y[s.clone()]).collect();
        is_decay(&views)
    };
    Ok(recording.segments.iter().map(is_decaying).collect())
}

/// Text naming the files without a free decay, if other files of the test have one.
pub fn files_without_decay(recording: &Recording, decays: &[bool]) -> Option<String> {
    let paths_where = |is_decay: bool| -> Vec<&str> {
        let mut paths: Vec<&str> = Vec::new();
        for (segment, _) in recording
            .segments
            .iter()
            .zip(decays)
            .filter(|s| *s.1 == is_decay)
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
    let (steady, decaying) = (paths_where(false), paths_where(true));
    (recording.files.len() > 1 && !steady.is_empty() && !decaying.is_empty()).then(|| {
        let verb = if steady.len() == 1 { "does" } else { "do" };
        format!(
            "{} {verb} not ring down as {} does",
            quoted_list(steady.into_iter()),
            quoted_list(decaying.into_iter().take(1))
        )
    })
}

/// Relative fit error of a decay above which its modes are unreliable.
const MAX_FIT_ERROR: f64 = 0.5;

/// Warning that names the decays with a fit error above [`MAX_FIT_ERROR`].
fn poor_fit(
    fit_error: &[f64],
    channels: &[&Channel],
    files: &[Option<String>],
) -> Option<Diagnostic> {
    let row = |(index, error): (usize, &f64)| {
        let (channel, decay) = (index / files.len(), index % files.len());
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
    let errors = fit_error.iter().enumerate();
    let poor = errors.filter(|(_, e)| !(**e <= MAX_FIT_ERROR));
    let poor: Vec<String> = poor.map(row).collect();
    (!poor.is_empty()).then(|| Diagnostic {
        code: "poor-fit",
        message: format!(
            "the fit differs from {} of its size: the residual may bias modes and intervals",
            poor.join(", ")
        ),
        hint: Some("omit records that do not ring down, or narrow the band: --band".to_string()),
    })
}

/// Fits the decays of all segments together.
///
/// # Errors
/// `too-short` if no segment decays long enough; those of the fit.
pub fn identify(
    recording: &Recording,
    outputs: &[usize],
    study: &IdentifyStudy,
) -> Result<FreeDecayResult, Error> {
    let channels: Vec<&Channel> = outputs.iter().map(|&c| &recording.channels[c]).collect();
    let samples = sample_blocks::load_channels(recording, &channels, "a free decay")?;
    let rate = recording.rate_hz;
    let ranges: Vec<std::ops::Range<usize>> = (recording.segments.iter())
        .map(|s| {
            let views: Vec<&[f64]> = samples.iter().map(|y| &y[s.clone()]).collect();
            let range = decay(&views);
            s.start + range.start..s.start + range.end
        })
        .collect();
    let files: Vec<Option<String>> = (ranges.iter())
        .map(|r| {
            recording
                .sample_time(r.start.min(recording.samples.saturating_sub(1)))
                .file
        })
        .collect();
    let shortest = (ranges.iter().zip(&files)).min_by_key(|(r, _)| r.len());
    let available = shortest.map_or(0, |(r, _)| r.len());
    if available < MIN_SAMPLES {
        let message = match available {
            0 => "no free decay: no level falls after the maximum".to_string(),
            n => format!("a decay of {} is too short to fit", pluralise(n, "sample")),
        };
        let error = Error::new(Code::TooShort, message).with_hint(match available {
            0 => "omit the record, or treat it as driven by noise: --method ssi-cov",
            _ => "record from before the release until the motion has decayed, or sample faster",
        });
        return Err(match shortest.and_then(|(_, file)| file.as_ref()) {
            Some(file) => error.with_file(file),
            None => error,
        });
    }
    let length = prev_fast_len(available);
    let decays: Vec<Vec<&[f64]>> = (ranges.iter())
        .map(|r| {
            samples
                .iter()
                .map(|y| &y[r.start..r.start + length])
                .collect()
        })
        .collect();
    let spacing_hz = rate / length as f64;
    let band_hz = study.band_hz.unwrap_or((spacing_hz, TOP * rate));
    let options = RationalOptions {
        band_hz: Some(band_hz),
        order: study.order,
        ..RationalOptions::default()
    };
    let fit = fit(rate, &decays, &options)?;
    let table: Vec<Vec<usize>> = (0..channels.len())
        .map(|c| (c * ranges.len()..(c + 1) * ranges.len()).collect())
        .collect();
    let modes = modes_over_table(&fit, &table, 0.0)?;
    let is_weak = |m: &IdentifiedMode| weak::reason(m, spacing_hz, None);
    let (modes, weak) = weak::split_weak(modes, is_weak, study.all);
    let starts: Vec<String> = (ranges.iter().take(6))
        .map(|r| format!("{:.4} s", recording.sample_time(r.start).time_s))
        .collect();
    let method_text = format!(
        "{} from {}{}, {:.4} s each: transforms without window or leakage, lines {spacing_hz:.4} Hz apart",
        pluralise(ranges.len(), "free decay"),
        starts.join(", "),
        if ranges.len() > starts.len() {
            ", …"
        } else {
            ""
        },
        length as f64 / rate,
    );
    let mut diagnostics = fit.diagnostics.clone();
    diagnostics.extend(poor_fit(&fit.fit_error, &channels, &files));
    Ok(FreeDecayResult {
        fit_error: fit.fit_error.clone(),
        method_text,
        band_hz,
        count: ranges.len(),
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

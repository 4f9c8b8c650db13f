//! Spectra over frequency: Welch, multitaper, squared envelope, spectrogram.

use std::ops::Range;

use super::sample_blocks;
use super::spectrum_study::{AbscissaKind, SpectrumEstimate, SpectrumKind, SpectrumStudy};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::numeric::parallel;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::band::FrequencyBand;
use crate::spectrum::envelope::squared_envelope_spectrum;
use crate::spectrum::multitaper::multitaper;
use crate::spectrum::rotation::separation::{SeparationOptions, separate};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::{Spectrogram, SpectrogramOptions, SpectrogramRow};
use crate::spectrum::welch::{Averaging, WelchEstimator, WelchOptions};
use crate::spectrum::window::Window;

/// Longest record, samples, that is analysed as a single block by default: resolution matters more than the variance of the noise.
const MAX_SINGLE_BLOCK: usize = 8192;

/// Shortest default block of a longer record, samples.
const MIN_DEFAULT_BLOCK: usize = 2048;

/// Longest default block, samples.
const MAX_DEFAULT_BLOCK: usize = 1 << 16;

/// Minimum number of blocks of a longer record.
const MIN_BLOCKS: usize = 16;

/// Default number of tapers: twelve degrees of freedom in place of two, bandwidth of about six lines.
const DEFAULT_TAPERS: usize = 6;

/// Maximum number of spectrogram rows; a longer record averages several blocks per row.
const MAX_ROWS: usize = 500;

/// Default number of blocks of a spectrogram.
const SPECTROGRAM_BLOCKS: usize = 64;

/// Longest default block of a spectrogram, samples.
const MAX_SPECTROGRAM_BLOCK: usize = 4096;

/// Shortest block, samples: five lines.
const MIN_BLOCK: usize = 8;

/// Sample range of the longest segment without a gap.
pub fn longest_segment(recording: &Recording) -> Range<usize> {
    let longest = recording.segments.iter().max_by_key(|s| s.len());
    longest.cloned().unwrap_or(0..0)
}

/// Welch spectra, streamed by blocks; on request of the random part of the signals, held in memory.
///
/// # Errors
/// The resolution or the overlap is out of range; the record is too short, or too long for a separation in memory.
pub fn welch_spectra(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let options = WelchOptions {
        block: block_len(recording, study.frequency_resolution_hz)?,
        overlap: study.overlap.unwrap_or(0.5),
        window: study.window.unwrap_or(Window::Hann),
        detrend: study.detrend,
        averaging: study.averaging,
    };
    let mut estimator = WelchEstimator::new(recording.rate_hz, channels.len(), &[], &options)?;
    let mut diagnostics = Vec::new();
    let mut part = String::new();
    if study.separate {
        let signals = longest_segment_signals(recording, channels, study, &mut diagnostics)?;
        let views: Vec<&[f64]> = signals.samples.iter().map(Vec::as_slice).collect();
        estimator.push(&views);
        part = signals.removed_text;
    } else {
        sample_blocks::average(recording, channels, &mut estimator)?;
    }
    let spectra = estimator.finish()?;
    let averages = match (spectra.averages, study.averaging) {
        (None, _) => "maximum of each line".to_string(),
        (Some(n), Averaging::Exponential(_)) => format!("exponential, {n:.1} independent averages"),
        (Some(n), _) => format!("{n:.1} independent averages"),
    };
    let method_text = format!(
        "{} of {:.4} s ({} window, {:.0} % overlap): {averages}, {:.6} Hz lines{part}",
        pluralise(spectra.blocks, "block"),
        options.block as f64 / recording.rate_hz,
        options.window.name(),
        100.0 * options.overlap,
        recording.rate_hz / options.block as f64,
    );
    Ok(to_estimate(method_text, spectra, diagnostics))
}

fn to_estimate(method: String, spectra: Spectra, diagnostics: Vec<Diagnostic>) -> SpectrumEstimate {
    SpectrumEstimate {
        method_text: method,
        abscissa_kind: AbscissaKind::Frequency,
        spectra,
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
        diagnostics,
    }
}

/// Power share of the random part of a channel, as text.
pub fn random_part_text(channel: &Channel, share: f64) -> String {
    format!(
        "; of the random part, {:.3} % of the power of {}; the periodic part is removed",
        100.0 * share,
        channel.name
    )
}

/// Block length, samples: from the requested resolution, else from the length of the longest segment.
fn block_len(recording: &Recording, resolution_hz: Option<f64>) -> Result<usize, Error> {
    let longest = longest_segment(recording).len();
    match resolution_hz {
        Some(df) => block_for_resolution(recording, df),
        None if longest <= MAX_SINGLE_BLOCK => Ok(longest),
        None => {
            let power = (longest / MIN_BLOCKS).max(1).ilog2();
            Ok((1usize << power).clamp(MIN_DEFAULT_BLOCK, MAX_DEFAULT_BLOCK))
        }
    }
}

/// Block length, samples, for a frequency resolution, Hz.
fn block_for_resolution(recording: &Recording, resolution_hz: f64) -> Result<usize, Error> {
    let longest = longest_segment(recording).len();
    let block = (recording.rate_hz / resolution_hz).round();
    if block >= MIN_BLOCK as f64 && block <= longest as f64 {
        return Ok(block as usize);
    }
    let message = format!(
        "a resolution of {resolution_hz:e} Hz needs blocks of {block:e} samples; the longest segment has {longest}, the least block {MIN_BLOCK}"
    );
    let hint = format!(
        "request {:.6} to {:.6} Hz",
        recording.rate_hz / longest.max(1) as f64,
        recording.rate_hz / MIN_BLOCK as f64
    );
    Err(Error::new(Code::OutOfRange, message).with_hint(hint))
}

/// Signals of the longest segment.
pub struct SegmentSignals {
    /// Samples of each channel.
    pub samples: Vec<Vec<f64>>,
    /// Removed components, as text; empty by default.
    pub removed_text: String,
}

/// Loads the longest segment of every channel and, on request, separates its random part.
///
/// # Errors
/// The record exceeds the memory limit, or the segment is too short for a separation.
pub fn longest_segment_signals(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<SegmentSignals, Error> {
    let range = longest_segment(recording);
    if recording.segments.len() > 1 {
        diagnostics.push(Diagnostic {
            code: "longest-segment",
            message: format!(
                "gaps split the record into {} segments; only the longest is analysed, {:.4} s from {:.4} s on",
                recording.segments.len(),
                range.len() as f64 / recording.rate_hz,
                range.start as f64 / recording.rate_hz
            ),
            hint: Some("interpolate the gaps with --fill-gaps, or choose a segment with --after and --before".into()),
        });
    }
    let channel_samples = sample_blocks::load_channels(recording, channels, "this analysis")?;
    let mut removed_text = String::new();
    let crop = |mut samples: Vec<f64>| {
        samples.truncate(range.end);
        samples.drain(..range.start);
        samples
    };
    let mut samples: Vec<Vec<f64>> = channel_samples.into_iter().map(crop).collect();
    if study.separate {
        let random_parts = parallel::try_map(&samples, |samples| random_part(samples))?;
        samples.clear();
        for ((random, share), channel) in random_parts.into_iter().zip(channels) {
            removed_text += &random_part_text(channel, share);
            samples.push(random);
        }
    }
    Ok(SegmentSignals {
        samples,
        removed_text,
    })
}

/// Random part of a signal, and its share of the variance. The periodic part is predicted over a delay of half a block, from blocks of
/// a sixteenth of the record.
///
/// # Errors
/// The signal has too few samples.
pub fn random_part(samples: &[f64]) -> Result<(Vec<f64>, f64), Error> {
    let power = (samples.len() / MIN_BLOCKS).max(4).ilog2();
    let block = (1usize << power).min(MAX_DEFAULT_BLOCK);
    let gap = block / 2;
    let random = separate(samples, SeparationOptions { block, gap })?.random;
    let power = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64
    };
    let share = power(&random) / power(samples);
    Ok((random, share))
}

/// Multitaper spectra of the longest segment with sine tapers.
///
/// # Errors
/// The record is too short, or exceeds the memory limit.
pub fn multitaper_spectra(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let mut diagnostics = Vec::new();
    let signals = longest_segment_signals(recording, channels, study, &mut diagnostics)?;
    let views: Vec<&[f64]> = signals.samples.iter().map(Vec::as_slice).collect();
    let samples = views.first().map_or(0, |v| v.len());
    // K sine tapers have a half-bandwidth of (K + 1)/2 lines.
    let tapers = match study.frequency_resolution_hz {
        Some(df) => (df * samples as f64 / recording.rate_hz - 1.0)
            .round()
            .clamp(1.0, samples as f64) as usize,
        None => DEFAULT_TAPERS,
    };
    let spectra = multitaper(recording.rate_hz, &views, &[], tapers)?;
    let method_text = format!(
        "{tapers} sine tapers on {:.4} s: lines {:.6} Hz apart and {:.6} Hz wide{}",
        samples as f64 / recording.rate_hz,
        recording.rate_hz / (samples + 1) as f64,
        spectra.bandwidth_hz,
        signals.removed_text
    );
    Ok(to_estimate(method_text, spectra, diagnostics))
}

/// Spectra of the squared envelope of a band over the longest segment.
///
/// # Errors
/// The band contains too few lines, or the record exceeds the memory limit.
pub fn envelope_spectra(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let mut diagnostics = Vec::new();
    let (low_hz, high_hz) = study.band.unwrap_or((0.0, 0.5 * recording.rate_hz));
    let band = FrequencyBand { low_hz, high_hz };
    let duration_s = longest_segment(recording).len() as f64 / recording.rate_hz;
    let n_lines = (high_hz.min(0.5 * recording.rate_hz) - low_hz) * duration_s;
    if n_lines < MIN_BLOCK as f64 {
        let message = format!(
            "the band {low_hz:.6} … {high_hz:.6} Hz has {} over {duration_s:.6} s; an envelope needs {MIN_BLOCK}",
            pluralise(n_lines.floor() as usize, "line")
        );
        return Err(Error::new(Code::TooShort, message)
            .with_hint("choose a wider --band, or record for longer"));
    }
    let signals = longest_segment_signals(recording, channels, study, &mut diagnostics)?;
    let mut spectra = Spectra {
        rate_hz: 2.0 * (high_hz.min(0.5 * recording.rate_hz) - low_hz),
        bandwidth_hz: 1.0,
        blocks: 1,
        averages: Some(1.0),
        ..Spectra::default()
    };
    let envelopes = parallel::try_map(&signals.samples, |samples| {
        squared_envelope_spectrum(samples, recording.rate_hz, band)
    })?;
    for envelope in envelopes {
        spectra
            .psd
            .push(envelope.amplitude.iter().map(|a| 0.5 * a * a).collect());
        spectra.frequency_hz = envelope.frequency_hz;
    }
    let method_text = format!(
        "squared envelope of {low_hz:.6} … {high_hz:.6} Hz over {duration_s:.4} s{}",
        signals.removed_text
    );
    if study.band.is_none() {
        diagnostics.push(Diagnostic {
            code: "no-band",
            message: "the envelope is that of the whole signal".into(),
            hint: Some("choose the band excited by the bursts: --band 2000:4000".into()),
        });
    }
    Ok(to_estimate(method_text, spectra, diagnostics))
}

/// Spectrograms of the channels, and their mean density over the rows.
///
/// # Errors
/// No segment is as long as one row.
pub fn spectrograms(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let longest = longest_segment(recording).len();
    let block = match study.frequency_resolution_hz {
        Some(df) => block_for_resolution(recording, df)?,
        None => (1usize << (longest / SPECTROGRAM_BLOCKS).max(1).ilog2())
            .clamp(256, MAX_SPECTROGRAM_BLOCK)
            .min(longest),
    };
    if block < MIN_BLOCK {
        let message = format!("the longest segment has {}", pluralise(longest, "sample"));
        return Err(Error::new(Code::TooShort, message)
            .with_hint(format!("a spectrogram needs rows of {MIN_BLOCK} samples")));
    }
    let overlap = study.overlap.unwrap_or(0.5);
    let step = ((block as f64 * (1.0 - overlap)).round() as usize).max(1);
    let averages = (recording.samples / step).div_ceil(MAX_ROWS).max(1);
    let settings = SpectrogramOptions {
        block,
        step,
        averages,
    };
    let create = || -> Result<Vec<Spectrogram>, Error> {
        (0..channels.len())
            .map(|_| Spectrogram::new(recording.rate_hz, settings))
            .collect()
    };
    let mut active = create()?;
    let mut rows = vec![Vec::<SpectrogramRow>::new(); channels.len()];
    let frequency_hz = active.first().map_or(Vec::new(), Spectrogram::frequency_hz);
    let mut segments = recording.segments.iter().map(|s| s.start);
    let mut start_s = segments.next().unwrap_or(0) as f64 / recording.rate_hz;
    let mut restart_error = None;
    sample_blocks::for_each_block(recording, channels, |block, ends| {
        let mut channels: Vec<_> = active.iter_mut().zip(block).zip(&mut rows).collect();
        parallel::for_each(&mut channels, |((spectrogram, samples), rows)| {
            spectrogram.push(samples, |mut row| {
                row.time_s += start_s;
                rows.push(row);
            });
        });
        if ends {
            start_s = segments.next().unwrap_or(0) as f64 / recording.rate_hz;
            match create() {
                Ok(started) => active = started,
                Err(error) => restart_error = Some(error),
            }
        }
    })?;
    if let Some(error) = restart_error {
        return Err(error);
    }
    let count = rows.first().map_or(0, Vec::len);
    if count == 0 {
        let message = format!(
            "no segment has one row of {averages} blocks of {block} samples; the longest has {longest}"
        );
        return Err(Error::new(Code::TooShort, message)
            .with_hint("request a coarser --resolution, or interpolate gaps with --fill-gaps"));
    }
    let mean = |rows: &Vec<SpectrogramRow>| -> Vec<f64> {
        let mut sum = vec![0.0; frequency_hz.len()];
        for row in rows {
            sum.iter_mut()
                .zip(&row.density)
                .for_each(|(s, d)| *s += d / count as f64);
        }
        sum
    };
    let spectra = Spectra {
        rate_hz: recording.rate_hz,
        psd: rows.iter().map(mean).collect(),
        bandwidth_hz: HANN_BANDWIDTH * recording.rate_hz / block as f64,
        blocks: count * averages,
        averages: Some((count * averages) as f64 * (step as f64 / block as f64).min(1.0)),
        frequency_hz: frequency_hz.clone(),
        ..Spectra::default()
    };
    let method_text = format!(
        "{} of {} of {:.4} s, {:.4} s apart, {:.6} Hz lines; their mean below",
        pluralise(count, "row"),
        pluralise(averages, "block"),
        block as f64 / recording.rate_hz,
        (step * averages) as f64 / recording.rate_hz,
        recording.rate_hz / block as f64
    );
    Ok(SpectrumEstimate {
        spectrogram_rows: rows,
        ..to_estimate(method_text, spectra, Vec::new())
    })
}

/// Equivalent noise bandwidth of the Hann window, lines (Harris 1978).
const HANN_BANDWIDTH: f64 = 1.5;

/// Rejects options of the study that have no effect on its kind of spectrum.
///
/// # Errors
/// An option has no effect.
pub fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    use SpectrumKind::{
        Amplitude, Cepstrum, Density, Multitaper, Order, Rms, Spectrogram, SynchronousAverage,
    };
    let welch = matches!(study.kind, Density | Amplitude | Rms | Cepstrum);
    let refuse = |flag: &str, what: &str| {
        Err(
            Error::new(Code::Usage, format!("{flag} has no effect here"))
                .with_hint(format!("it applies to {what}")),
        )
    };
    if study.window.is_some() && !welch {
        return refuse("--window", "--kind psd, amplitude, rms and cepstrum");
    }
    if study.averaging != Averaging::Linear && !welch {
        return refuse("--average", "--kind psd, amplitude, rms and cepstrum");
    }
    if study.overlap.is_some() && !welch && study.kind != Spectrogram {
        return refuse(
            "--overlap",
            "--kind psd, amplitude, rms, cepstrum and spectrogram",
        );
    }
    if study.frequency_resolution_hz.is_some()
        && !welch
        && !matches!(study.kind, Spectrogram | Multitaper)
    {
        return refuse(
            "--resolution",
            "--kind psd, amplitude, rms, cepstrum, multitaper and spectrogram",
        );
    }
    if study.history.is_some() && (!welch || study.kind == Cepstrum) && study.kind != Multitaper {
        return refuse("--as", "--kind psd, amplitude, rms and multitaper");
    }
    if study.separate && matches!(study.kind, Spectrogram | SynchronousAverage) {
        return refuse("--separate", "every kind but spectrogram and average");
    }
    if study.revolutions.is_some() && study.kind != Order {
        return refuse("--turns", "--kind order and order-cut");
    }
    if study.tacho.is_some() && !matches!(study.kind, Order | SynchronousAverage | Spectrogram) {
        return refuse(
            "--tacho",
            "--kind order, order-cut, average and spectrogram",
        );
    }
    Ok(())
}

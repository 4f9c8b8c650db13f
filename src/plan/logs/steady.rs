//! Spectra over frequency: averaged blocks, tapers, envelopes, rows over time.

use std::ops::Range;

use super::blocks;
use super::spectrum_study::{Across, Found, SpectrumKind, SpectrumStudy};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::band::Band;
use crate::spectrum::envelope::squared_envelope_spectrum;
use crate::spectrum::multitaper::multitaper;
use crate::spectrum::rotation::separation::{SeparationSettings, separate};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::{Row, Spectrogram, SpectrogramSettings};
use crate::spectrum::welch::{Averaging, Welch, WelchOptions};
use crate::spectrum::window::Window;

/// A record up to this length is one block where nobody says how: there its lines are finer than its noise is rough.
const ONE_BLOCK: usize = 8192;

/// The shortest block of a longer record taken unasked.
const SHORTEST: usize = 2048;

/// The longest block taken unasked.
const LONGEST: usize = 1 << 16;

/// Blocks that a longer record is cut into at least.
const LEAST_BLOCKS: usize = 16;

/// Tapers of a multitaper spectrum: ten freedoms more than a single one, lines six times as wide.
const TAPERS: usize = 6;

/// Rows of a spectrogram at most; more blocks are averaged into one row beyond.
const ROWS: usize = 500;

/// Blocks that a spectrogram cuts the record into where nobody says how.
const MOMENTS: usize = 64;

/// The longest block of a spectrogram taken unasked.
const LONGEST_MOMENT: usize = 4096;

/// Samples of the shortest block: fewer lines than five show nothing.
const LEAST: usize = 8;

/// The longest stretch without a gap.
pub fn longest(recording: &Recording) -> Range<usize> {
    let longest = recording.stretches.iter().max_by_key(|s| s.len());
    longest.cloned().unwrap_or(0..0)
}

/// Welch's spectra, streamed; of the random part where that is asked for.
///
/// # Errors
/// A resolution or an overlap without sense, a record too short, samples that cannot be held at once for a separation.
pub fn averaged(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let options = WelchOptions {
        block: block(recording, study.resolution_hz)?,
        overlap: study.overlap.unwrap_or(0.5),
        window: study.window.unwrap_or(Window::Hann),
        detrend: study.detrend,
        averaging: study.averaging,
    };
    let mut welch = Welch::new(recording.rate_hz, channels.len(), &[], &options)?;
    let mut warnings = Vec::new();
    let mut part = String::new();
    if study.separate {
        let parts = longest_parts(recording, channels, study, &mut warnings)?;
        let views: Vec<&[f64]> = parts.samples.iter().map(Vec::as_slice).collect();
        welch.push(&views);
        part = parts.part;
    } else {
        blocks::each(recording, channels, |block, ends| {
            welch.push(block);
            if ends {
                welch.end_stretch();
            }
        })?;
    }
    let spectra = welch.finish()?;
    let averages = match (spectra.averages, study.averaging) {
        (None, _) => "the largest of each line kept".to_string(),
        (Some(n), Averaging::Exponential(_)) => format!("exponential, {n:.1} independent averages"),
        (Some(n), _) => format!("{n:.1} independent averages"),
    };
    let how = format!(
        "{} of {:.4} s ({} window, {:.0} % overlap): {averages}, {:.6} Hz lines{part}",
        counted(spectra.blocks, "block"),
        options.block as f64 / recording.rate_hz,
        options.window.name(),
        100.0 * options.overlap,
        recording.rate_hz / options.block as f64,
    );
    Ok(found(how, spectra, warnings))
}

fn found(how: String, spectra: Spectra, warnings: Vec<Warning>) -> Found {
    Found {
        how,
        across: Across::Frequency,
        spectra,
        rows: Vec::new(),
        speed: Vec::new(),
        warnings,
    }
}

/// How much of a channel what does not repeat is, in words.
pub fn of_random_part(channel: &Channel, share: f64) -> String {
    format!(
        "; of the random part, {:.3} % of the power of {}: the rest repeats and is taken off",
        100.0 * share,
        channel.name
    )
}

/// Samples in a block: as asked, else from the length of the longest stretch.
fn block(recording: &Recording, resolution_hz: Option<f64>) -> Result<usize, Error> {
    let longest = longest(recording).len();
    match resolution_hz {
        Some(df) => asked(recording, df),
        None if longest <= ONE_BLOCK => Ok(longest),
        None => {
            let power = (longest / LEAST_BLOCKS).max(1).ilog2();
            Ok((1usize << power).clamp(SHORTEST, LONGEST))
        }
    }
}

/// Samples in a block of a stated resolution.
fn asked(recording: &Recording, resolution_hz: f64) -> Result<usize, Error> {
    let longest = longest(recording).len();
    let block = (recording.rate_hz / resolution_hz).round();
    if block >= LEAST as f64 && block <= longest as f64 {
        return Ok(block as usize);
    }
    let message = format!(
        "lines of {resolution_hz:e} Hz need blocks of {block:e} samples; the longest stretch has {longest}, and a block at least {LEAST}"
    );
    let hint = format!(
        "ask for {:.6} to {:.6} Hz",
        recording.rate_hz / longest.max(1) as f64,
        recording.rate_hz / LEAST as f64
    );
    Err(Error::new(Code::OutOfRange, message).hint(hint))
}

/// Samples of the longest stretch.
pub struct Parts {
    /// Of each channel.
    pub samples: Vec<Vec<f64>>,
    /// What was taken off them, in words; empty where nothing was.
    pub part: String,
}

/// Every channel's longest stretch, or its random part.
///
/// # Errors
/// More samples than can be held, a stretch too short to be separated.
pub fn longest_parts(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
    warnings: &mut Vec<Warning>,
) -> Result<Parts, Error> {
    let range = longest(recording);
    if recording.stretches.len() > 1 {
        warnings.push(Warning {
            code: "longest-stretch",
            message: format!(
                "gaps split the record into {} stretches; only the longest is analysed, {:.4} s from {:.4} s on",
                recording.stretches.len(),
                range.len() as f64 / recording.rate_hz,
                range.start as f64 / recording.rate_hz
            ),
            hint: Some("bridge the gaps with --fill-gaps, or choose a stretch with --after and --before".into()),
        });
    }
    let all = blocks::whole(recording, channels, "this analysis")?;
    let mut part = String::new();
    let samples = all
        .into_iter()
        .zip(channels)
        .map(|(mut samples, channel)| {
            samples.truncate(range.end);
            samples.drain(..range.start);
            if study.separate {
                let (random, share) = random_part(&samples)?;
                part += &of_random_part(channel, share);
                samples = random;
            }
            Ok(samples)
        })
        .collect::<Result<Vec<Vec<f64>>, Error>>()?;
    Ok(Parts { samples, part })
}

/// What does not repeat, predicted over half a block from blocks of a sixteenth of the record; and its share of the power about the mean.
///
/// # Errors
/// Too few samples.
pub fn random_part(samples: &[f64]) -> Result<(Vec<f64>, f64), Error> {
    let power = (samples.len() / LEAST_BLOCKS).max(4).ilog2();
    let block = (1usize << power).min(LONGEST);
    let gap = block / 2;
    let random = separate(samples, SeparationSettings { block, gap })?.random;
    let power = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64
    };
    let share = power(&random) / power(samples);
    Ok((random, share))
}

/// Spectra of the whole of the longest stretch by tapers.
///
/// # Errors
/// A record too short or too long to be held.
pub fn tapered(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let mut warnings = Vec::new();
    let parts = longest_parts(recording, channels, study, &mut warnings)?;
    let views: Vec<&[f64]> = parts.samples.iter().map(Vec::as_slice).collect();
    let samples = views.first().map_or(0, |v| v.len());
    // Tapers see (K + 1)/2 lines to either side.
    let tapers = match study.resolution_hz {
        Some(df) => (df * samples as f64 / recording.rate_hz - 1.0)
            .round()
            .clamp(1.0, samples as f64) as usize,
        None => TAPERS,
    };
    let spectra = multitaper(recording.rate_hz, &views, &[], tapers)?;
    let how = format!(
        "{tapers} sine tapers on {:.4} s: lines {:.6} Hz apart and {:.6} Hz wide{}",
        samples as f64 / recording.rate_hz,
        recording.rate_hz / (samples + 1) as f64,
        spectra.bandwidth_hz,
        parts.part
    );
    Ok(found(how, spectra, warnings))
}

/// Lines of the squared envelope of the band, of the longest stretch.
///
/// # Errors
/// A band that holds nothing, a record too long to be held.
pub fn enveloped(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let mut warnings = Vec::new();
    let (low_hz, high_hz) = study.band.unwrap_or((0.0, 0.5 * recording.rate_hz));
    let band = Band { low_hz, high_hz };
    let duration_s = longest(recording).len() as f64 / recording.rate_hz;
    let lines = (high_hz.min(0.5 * recording.rate_hz) - low_hz) * duration_s;
    if lines < LEAST as f64 {
        let message = format!(
            "the band {low_hz:.6} … {high_hz:.6} Hz holds {} of {duration_s:.6} s, where an envelope needs {LEAST}",
            counted(lines.floor() as usize, "line")
        );
        return Err(
            Error::new(Code::TooShort, message).hint("choose a wider --band, or record for longer")
        );
    }
    let parts = longest_parts(recording, channels, study, &mut warnings)?;
    let mut spectra = Spectra {
        rate_hz: 2.0 * (high_hz.min(0.5 * recording.rate_hz) - low_hz),
        bandwidth_hz: 1.0,
        blocks: 1,
        averages: Some(1.0),
        ..Spectra::default()
    };
    for samples in &parts.samples {
        let lines = squared_envelope_spectrum(samples, recording.rate_hz, band)?;
        spectra
            .psd
            .push(lines.amplitude.iter().map(|a| 0.5 * a * a).collect());
        spectra.frequency_hz = lines.frequency_hz;
    }
    let how = format!(
        "squared envelope of {low_hz:.6} … {high_hz:.6} Hz over {duration_s:.4} s{}",
        parts.part
    );
    if study.band.is_none() {
        warnings.push(Warning {
            code: "no-band",
            message: "the envelope is that of the whole signal".into(),
            hint: Some("choose the band that the bursts ring in: --band 2000:4000".into()),
        });
    }
    Ok(found(how, spectra, warnings))
}

/// Densities by time, and their mean over the rows.
///
/// # Errors
/// No row fits into any stretch, a window other than Hann's.
pub fn by_time(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let longest = longest(recording).len();
    let block = match study.resolution_hz {
        Some(df) => asked(recording, df)?,
        None => (1usize << (longest / MOMENTS).max(1).ilog2())
            .clamp(256, LONGEST_MOMENT)
            .min(longest),
    };
    if block < LEAST {
        let message = format!("the longest stretch holds {}", counted(longest, "sample"));
        return Err(Error::new(Code::TooShort, message)
            .hint(format!("a spectrogram needs rows of {LEAST} at least")));
    }
    let overlap = study.overlap.unwrap_or(0.5);
    let step = ((block as f64 * (1.0 - overlap)).round() as usize).max(1);
    let averages = (recording.samples / step).div_ceil(ROWS).max(1);
    let settings = SpectrogramSettings {
        block,
        step,
        averages,
    };
    let fresh = || -> Result<Vec<Spectrogram>, Error> {
        (0..channels.len())
            .map(|_| Spectrogram::new(recording.rate_hz, settings))
            .collect()
    };
    let (mut running, mut rows) = (fresh()?, vec![Vec::<Row>::new(); channels.len()]);
    let frequency_hz = running
        .first()
        .map_or(Vec::new(), Spectrogram::frequency_hz);
    let mut stretches = recording.stretches.iter().map(|s| s.start);
    let mut start_s = stretches.next().unwrap_or(0) as f64 / recording.rate_hz;
    let mut failed = None;
    blocks::each(recording, channels, |block, ends| {
        for ((spectrogram, samples), rows) in running.iter_mut().zip(block).zip(&mut rows) {
            spectrogram.push(samples, |mut row| {
                row.time_s += start_s;
                rows.push(row);
            });
        }
        if ends {
            start_s = stretches.next().unwrap_or(0) as f64 / recording.rate_hz;
            match fresh() {
                Ok(new) => running = new,
                Err(error) => failed = Some(error),
            }
        }
    })?;
    if let Some(error) = failed {
        return Err(error);
    }
    let count = rows.first().map_or(0, Vec::len);
    if count == 0 {
        let message = format!(
            "no stretch holds one row of {averages} blocks of {block} samples; the longest has {longest}"
        );
        return Err(Error::new(Code::TooShort, message)
            .hint("ask for a coarser --resolution, or bridge gaps with --fill-gaps"));
    }
    let mean = |rows: &Vec<Row>| -> Vec<f64> {
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
    let how = format!(
        "{} of {} of {:.4} s, {:.4} s apart, {:.6} Hz lines; their mean below",
        counted(count, "row"),
        counted(averages, "block"),
        block as f64 / recording.rate_hz,
        (step * averages) as f64 / recording.rate_hz,
        recording.rate_hz / block as f64
    );
    Ok(Found {
        rows,
        ..found(how, spectra, Vec::new())
    })
}

/// Equivalent noise bandwidth of Hann's window, lines (Harris 1978).
const HANN_BANDWIDTH: f64 = 1.5;

/// What a kind needs that the study forbids.
///
/// # Errors
/// Flags that would be passed over.
pub fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    use SpectrumKind::{
        Amplitude, Average, Cepstrum, Density, Multitaper, Order, Rms, Spectrogram,
    };
    let blocks = matches!(study.kind, Density | Amplitude | Rms | Cepstrum);
    let refuse = |flag: &str, what: &str| {
        Err(Error::new(Code::Usage, format!("{flag} does nothing here"))
            .hint(format!("it is for {what}")))
    };
    if study.window.is_some() && !blocks {
        return refuse("--window", "--kind psd, amplitude, rms and cepstrum");
    }
    if study.averaging != Averaging::Linear && !blocks {
        return refuse("--average", "--kind psd, amplitude, rms and cepstrum");
    }
    if study.overlap.is_some() && !blocks && study.kind != Spectrogram {
        return refuse(
            "--overlap",
            "--kind psd, amplitude, rms, cepstrum and spectrogram",
        );
    }
    if study.resolution_hz.is_some() && !blocks && !matches!(study.kind, Spectrogram | Multitaper) {
        return refuse(
            "--resolution",
            "--kind psd, amplitude, rms, cepstrum, multitaper and spectrogram",
        );
    }
    if study.motion.is_some() && (!blocks || study.kind == Cepstrum) && study.kind != Multitaper {
        return refuse("--as", "--kind psd, amplitude, rms and multitaper");
    }
    if study.separate && matches!(study.kind, Spectrogram | Average) {
        return refuse("--separate", "every kind but spectrogram and average");
    }
    if study.turns.is_some() && study.kind != Order {
        return refuse("--turns", "--kind order and order-cut");
    }
    if study.tacho.is_some() && !matches!(study.kind, Order | Average | Spectrogram) {
        return refuse(
            "--tacho",
            "--kind order, order-cut, average and spectrogram",
        );
    }
    Ok(())
}

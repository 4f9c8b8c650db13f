//! WAV files: integers of 8 to 32 bits scaled to full scale 1, and 32-bit floats.

use std::io::Cursor;

use hound::{SampleFormat, WavReader};

use super::raw::{ChannelGroup, RawChannel, RawLog, RawTiming};
use super::read_options::ReadOptions;
use super::sample_column::SampleColumn;
use super::stated_rates::StatedRate;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};

/// Samples of a channel collected before they are handed on.
const BUFFER_LEN: usize = 1 << 14;

/// Reads a WAV file: full scale is 1, without a unit, unless `settings` say otherwise of the channels later.
///
/// # Errors
/// `broken-file` where the file was cut off or damaged, `unknown-format` where its samples are coded.
pub fn read(path: &str, bytes: &[u8], _settings: &ReadOptions) -> Result<RawLog, Errors> {
    let mut reader = WavReader::new(Cursor::new(bytes)).map_err(|error| wav_error(&error))?;
    let spec = reader.spec();
    let n_channels = usize::from(spec.channels);
    if n_channels == 0 || spec.sample_rate == 0 {
        return Err(Error::new(
            Code::CorruptFile,
            format!(
                "the WAV file states {n_channels} channels at {} Hz",
                spec.sample_rate
            ),
        )
        .into());
    }
    let stated = reader.duration() as usize;
    let (kind, channels) = match spec.sample_format {
        SampleFormat::Float => {
            let samples = reader.samples::<f32>();
            (
                "floats as written",
                collect(samples, n_channels, f64::from)?,
            )
        }
        SampleFormat::Int => {
            let full_scale = 2.0_f64.powi(i32::from(spec.bits_per_sample) - 1);
            let scaled = move |sample: i32| f64::from(sample) / full_scale;
            let samples = reader.samples::<i32>();
            (
                "integers, full scale = 1",
                collect(samples, n_channels, scaled)?,
            )
        }
    };
    if channels
        .iter()
        .any(|channel| channel.len() != channels[0].len())
    {
        return Err(Error::new(
            Code::CorruptFile,
            "the WAV file ends between the samples of one instant",
        )
        .into());
    }
    if channels[0].is_empty() {
        return Err(Error::new(Code::EmptyLog, "the WAV file contains no samples").into());
    }
    let named = channels.into_iter().enumerate();
    let group = ChannelGroup {
        timing: RawTiming {
            stated_rates: vec![StatedRate::is_sample_rate(
                spec.sample_rate.into(),
                "WAV header",
            )],
            header_samples: Some(stated),
            ..RawTiming::default()
        },
        channels: named
            .map(|(at, samples)| RawChannel {
                name: format!("channel {}", at + 1),
                samples,
                ..RawChannel::default()
            })
            .collect(),
    };
    Ok(RawLog {
        path: path.to_string(),
        dialect: format!("WAV, {}-bit {kind}", spec.bits_per_sample),
        groups: vec![group],
        ..RawLog::default()
    })
}

/// The samples of each channel.
fn collect<S>(
    samples: impl Iterator<Item = hound::Result<S>>,
    n_channels: usize,
    scale: impl Fn(S) -> f64,
) -> Result<Vec<SampleColumn>, Error> {
    let mut columns: Vec<SampleColumn> = (0..n_channels).map(|_| SampleColumn::default()).collect();
    let mut blocks: Vec<Vec<f64>> = vec![Vec::new(); n_channels];
    let mut channel = 0;
    for sample in samples {
        let sample = sample.map_err(|error| {
            let read = columns[channel].len() + blocks[channel].len();
            let hint = "the recording was cut off: repair its header with an audio editor";
            wav_error(&error).with_hint(format!(
                "{read} samples of each channel could be read; {hint}"
            ))
        })?;
        blocks[channel].push(scale(sample));
        if blocks[channel].len() == BUFFER_LEN {
            columns[channel].push(&blocks[channel])?;
            blocks[channel].clear();
        }
        channel = (channel + 1) % n_channels;
    }
    for (column, block) in columns.iter_mut().zip(&blocks) {
        column.push(block)?;
    }
    Ok(columns)
}

fn wav_error(error: &hound::Error) -> Error {
    let code = match error {
        hound::Error::Unsupported => Code::UnknownFormat,
        _ => Code::CorruptFile,
    };
    let message = match error {
        hound::Error::Unsupported => {
            "the WAV file contains coded samples or 64-bit floats; supported are integers of 8 to 32 bits and 32-bit floats".to_string()
        }
        other => format!("the WAV file is damaged or was cut off: {other}"),
    };
    Error::new(code, message)
}

//! Spectra over shaft angle: order spectra and synchronous averages.

use std::f64::consts::TAU;

use super::frequency_spectra::{
    longest_segment, longest_segment_signals, random_part, random_part_text,
};
use super::spectrum_study::{AbscissaKind, SpectrumEstimate, SpectrumStudy, channel};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::numeric::statistics::Z_95;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::rotation::angle_curve::AngleCurve;
use crate::spectrum::rotation::angular_resampling::{AngularSignal, resample};
use crate::spectrum::rotation::interpolation::PASS_BAND;
use crate::spectrum::rotation::orders::order_spectrum;
use crate::spectrum::rotation::synchronous_average::SynchronousAverage;
use crate::spectrum::rotation::tacho::{EdgeDirection, find_tacho_pulses};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::SpectrogramRow;

/// Number of instants at which the highest speed is evaluated.
const SPEED_SAMPLES: usize = 1000;

/// Minimum and maximum number of samples per revolution.
const SAMPLES_PER_REV_RANGE: (usize, usize) = (16, 1 << 14);

/// Default minimum number of blocks of a run.
const MIN_BLOCKS: usize = 8;

/// Default maximum number of revolutions in a block.
const MAX_REVOLUTIONS: usize = 64;

/// Number of independent blocks per Hann-windowed block with 50 % overlap: 1/(1 + 2/36), Welch (1967).
const INDEPENDENT_BLOCK_SHARE: f64 = 36.0 / 38.0;

/// Signals over shaft angle, with a description of the resampling.
pub(super) struct AngularSignals {
    /// Resampled signals, by channel.
    pub signals: Vec<AngularSignal>,
    /// Angle of the shaft over time.
    pub curve: AngleCurve,
    /// Highest order within the pass band at all speeds.
    pub max_order: f64,
    /// Description of the method.
    pub method_text: String,
    /// Data-quality warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Resamples the longest segment of channels over the shaft angle.
///
/// # Errors
/// Neither tacho nor speed, a tacho without pulses, a shaft too fast for the sample rate.
pub(super) fn resample_to_angle(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<AngularSignals, Error> {
    let mut diagnostics = Vec::new();
    let unseparated = SpectrumStudy {
        separate: false,
        ..study.clone()
    };
    let segment = longest_segment_signals(recording, channels, &unseparated, &mut diagnostics)?;
    let (curve, method_text) = shaft_angle(recording, study, &segment.samples, &mut diagnostics)?;
    let (first, last) = curve.angle_range();
    let (from, to) = curve.time_range_s();
    let turns_per_s = (last - first) / TAU / (to - from);
    // Minimum number of samples per revolution for the first order, with a margin to half the sample rate.
    const MIN_SAMPLES: f64 = 4.0;
    if turns_per_s * MIN_SAMPLES > recording.rate_hz {
        let message = format!(
            "the shaft turns {turns_per_s:.6} times a second, too fast for {} samples a second",
            recording.rate_hz
        );
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("check --speed, --pulses and --rate")
        );
    }
    let samples_per_rev = ((recording.rate_hz / turns_per_s).ceil() as usize)
        .clamp(SAMPLES_PER_REV_RANGE.0, SAMPLES_PER_REV_RANGE.1)
        .next_power_of_two();
    let mut random_text = String::new();
    let signals = segment
        .samples
        .iter()
        .zip(channels)
        .map(|(samples, channel)| {
            let mut signal = resample(samples, recording.rate_hz, &curve, samples_per_rev)?;
            if study.separate {
                let (random, share) = random_part(&signal.values)?;
                signal.values = random;
                random_text += &random_part_text(channel, share);
            }
            Ok(signal)
        })
        .collect::<Result<Vec<AngularSignal>, Error>>()?;
    let fastest = (0..=SPEED_SAMPLES)
        .map(|k| curve.speed(from + (to - from) * k as f64 / SPEED_SAMPLES as f64))
        .fold(0.0, f64::max);
    let rate_limit = PASS_BAND * 0.5 * recording.rate_hz * TAU / fastest;
    let angle_limits = signals.iter().map(AngularSignal::pass_order);
    Ok(AngularSignals {
        max_order: angle_limits.fold(rate_limit, f64::min),
        signals,
        curve,
        method_text: method_text + &random_text,
        diagnostics,
    })
}

/// Angle of the shaft over the longest segment, with a description; `segment` holds its samples, by channel.
///
/// # Errors
/// Those of `resample_to_angle`.
pub(super) fn shaft_angle(
    recording: &Recording,
    study: &SpectrumStudy,
    segment: &[Vec<f64>],
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<(AngleCurve, String), Error> {
    let rpm = |omega: f64| 60.0 * omega / TAU;
    if let Some(name) = &study.tacho {
        let mut ignored = Vec::new();
        let unseparated = SpectrumStudy {
            separate: false,
            ..study.clone()
        };
        let tacho = longest_segment_signals(
            recording,
            &[channel(recording, name)?],
            &unseparated,
            &mut ignored,
        )?;
        let samples = tacho.samples.first().map_or(&[][..], Vec::as_slice);
        let pulses = find_tacho_pulses(samples, recording.rate_hz, EdgeDirection::Rising, None)?;
        let missing: usize = pulses.missing.iter().map(|m| m.number).sum();
        if missing + pulses.extra_pulses_s.len() > 0 {
            diagnostics.push(Diagnostic {
                code: "tacho-pulses",
                message: format!(
                    "the tacho {name} has {missing} missing and {} extra pulses; its angle was computed without them",
                    pulses.extra_pulses_s.len()
                ),
                hint: Some("check the tacho's signal and --pulses".into()),
            });
        }
        if pulses.pulses.len() <= study.pulses_per_rev {
            let message = format!(
                "the tacho {name} has {} pulses, less than one turn at {} per turn",
                pulses.pulses.len(),
                study.pulses_per_rev
            );
            return Err(Error::new(Code::TooShort, message)
                .with_hint("check --pulses, the pulses per turn"));
        }
        let curve = AngleCurve::from_pulses(&pulses, study.pulses_per_rev)?;
        let (from, to) = curve.time_range_s();
        let text = format!(
            "{} pulses of {name}, {:.2} … {:.2} rpm",
            pulses.pulses.len(),
            rpm(curve.speed(from)),
            rpm(curve.speed(to))
        );
        return Ok((curve, text));
    }
    let Some(speed) = study.speed else {
        return Err(Error::new(
            Code::Usage,
            "orders need the angle of the shaft: neither a tacho nor a speed is stated",
        )
        .with_hint("name the tacho's channel, --tacho COL, or a steady speed, --speed RPM"));
    };
    let samples = segment.first().map_or(0, Vec::len);
    let curve = AngleCurve::constant_speed(speed, samples as f64 / recording.rate_hz)?;
    Ok((curve, format!("steady at {:.4} rpm", rpm(speed))))
}

/// Order spectra: amplitude A by order, stored as density A²/2 with bandwidth 1.
///
/// # Errors
/// Neither tacho nor speed, a tacho without pulses, fewer revolutions than a block.
pub fn order_spectra(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let AngularSignals {
        signals,
        max_order,
        method_text,
        diagnostics,
        ..
    } = resample_to_angle(recording, channels, study)?;
    let revolutions = signals
        .iter()
        .map(AngularSignal::revolutions)
        .min()
        .unwrap_or(0);
    let turns = study
        .revolutions
        .unwrap_or((2 * revolutions / MIN_BLOCKS).clamp(1, MAX_REVOLUTIONS));
    let mut spectra = Spectra {
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    for signal in &signals {
        let lines = order_spectrum(signal, turns)?;
        spectra.rate_hz = signal.samples_per_rev as f64;
        spectra.blocks = lines.blocks;
        spectra.averages = Some((lines.blocks as f64 * INDEPENDENT_BLOCK_SHARE).max(1.0));
        let n_lines = lines.order.partition_point(|order| *order <= max_order);
        let amplitudes = &lines.amplitude[..n_lines];
        spectra
            .psd
            .push(amplitudes.iter().map(|a| 0.5 * a * a).collect());
        spectra.frequency_hz = lines.order;
        spectra.frequency_hz.truncate(n_lines);
    }
    let method_text = format!(
        "{method_text}; {} of {} with lines {} apart, orders up to {max_order:.2}",
        pluralise(spectra.blocks, "block"),
        pluralise(turns, "turn"),
        1.0 / turns as f64,
    );
    Ok(SpectrumEstimate {
        method_text,
        abscissa_kind: AbscissaKind::Order,
        spectra,
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
        diagnostics,
    })
}

/// Assigns the shaft speed at its middle to each row of a spectrogram; rows before the first pulse or after the last are dropped.
///
/// # Errors
/// Those of `resample_to_angle`.
pub fn over_speed(
    mut result: SpectrumEstimate,
    recording: &Recording,
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let (curve, text) = shaft_angle(recording, study, &[], &mut result.diagnostics)?;
    let start_s = longest_segment(recording).start as f64 / recording.rate_hz;
    let (from, to) = curve.time_range_s();
    let is_known = |row: &SpectrogramRow| (from..=to).contains(&(row.time_s - start_s));
    result
        .spectrogram_rows
        .iter_mut()
        .for_each(|rows| rows.retain(is_known));
    let times = result
        .spectrogram_rows
        .first()
        .map_or(&[][..], Vec::as_slice);
    if times.is_empty() {
        let message = "no row of the spectrogram lies between the pulses of the tacho";
        return Err(Error::new(Code::TooShort, message)
            .with_hint("request shorter blocks by a coarser --resolution"));
    }
    result.speed = (times.iter())
        .map(|row| curve.speed(row.time_s - start_s))
        .collect();
    result.method_text += &format!("; {text}");
    Ok(result)
}

/// Synchronous averages over one revolution, by channel.
pub struct SynchronousAverages {
    /// Description of the method.
    pub method_text: String,
    /// Shaft angle of each value, degrees.
    pub angle_deg: Vec<f64>,
    /// Average over one revolution, by channel, in the unit of the channel.
    pub values: Vec<Vec<f64>>,
    /// Number of revolutions averaged.
    pub revolutions: usize,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes the synchronous averages of channels.
///
/// # Errors
/// Those of [`order_spectra`].
pub fn synchronous_averages(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SynchronousAverages, Error> {
    let AngularSignals {
        signals,
        method_text,
        diagnostics,
        ..
    } = resample_to_angle(recording, channels, study)?;
    let averages = signals
        .iter()
        .map(SynchronousAverage::new)
        .collect::<Result<Vec<SynchronousAverage>, Error>>()?;
    let turns = averages.iter().map(|a| a.revolutions).min().unwrap_or(0);
    let noise = averages
        .first()
        .map_or(0.0, SynchronousAverage::noise_reduction_db);
    let errors: Vec<String> = averages
        .iter()
        .zip(channels)
        .map(|(a, c)| {
            format!("{} ± {:.4e} {}", c.name, Z_95 * a.standard_error, c.unit)
                .trim_end()
                .to_string()
        })
        .collect();
    let samples_per_rev = signals.first().map_or(1, |s| s.samples_per_rev);
    Ok(SynchronousAverages {
        method_text: format!(
            "{method_text}; mean of {turns} turns, the non-repeating part {noise:.1} dB lower; {}",
            errors.join(", ")
        ),
        angle_deg: (0..samples_per_rev)
            .map(|i| 360.0 * i as f64 / samples_per_rev as f64)
            .collect(),
        values: averages.into_iter().map(|a| a.values).collect(),
        revolutions: turns,
        diagnostics,
    })
}

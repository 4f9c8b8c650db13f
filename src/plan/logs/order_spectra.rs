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

/// Instants at which the highest speed is looked for.
const SPEED_SAMPLES: usize = 1000;

/// Values a turn at most, and at least.
const SAMPLES_PER_REV_RANGE: (usize, usize) = (16, 1 << 14);

/// Default minimum number of blocks of a run, and maximum number of turns in a block.
const MIN_BLOCKS: usize = 8;

/// See [`MIN_BLOCKS`].
const MAX_REVOLUTIONS: usize = 64;

/// Independent blocks to one of Hann's that overlap by half: 1/(1 + 2/36), Welch (1967).
const INDEPENDENT_BLOCK_SHARE: f64 = 36.0 / 38.0;

/// Signals over angle, and how as text.
pub(super) struct AngularSignals {
    /// By channel.
    pub signals: Vec<AngularSignal>,
    /// The angle of the shaft.
    pub curve: AngleCurve,
    /// The highest order that is kept whole at every speed.
    pub max_order: f64,
    /// In words.
    pub method_text: String,
    /// Data-quality warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Channels over the angle of the shaft.
///
/// # Errors
/// No tacho and no speed, a tacho without pulses, a shaft too fast for the rate.
pub(super) fn resample_to_angle(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<AngularSignals, Error> {
    let mut diagnostics = Vec::new();
    let plain = SpectrumStudy {
        separate: false,
        ..study.clone()
    };
    let parts = longest_segment_signals(recording, channels, &plain, &mut diagnostics)?;
    let (curve, how) = shaft_angle(recording, study, &parts.samples, &mut diagnostics)?;
    let (first, last) = curve.angle_range();
    let (from, to) = curve.time_range_s();
    let turns_per_s = (last - first) / TAU / (to - from);
    // Fewer samples than this in a turn hold not even its first order with room to spare.
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
    let per_turn = ((recording.rate_hz / turns_per_s).ceil() as usize)
        .clamp(SAMPLES_PER_REV_RANGE.0, SAMPLES_PER_REV_RANGE.1)
        .next_power_of_two();
    let mut part = String::new();
    let signals = parts
        .samples
        .iter()
        .zip(channels)
        .map(|(samples, channel)| {
            let mut signal = resample(samples, recording.rate_hz, &curve, per_turn)?;
            if study.separate {
                let (random, share) = random_part(&signal.values)?;
                signal.values = random;
                part += &random_part_text(channel, share);
            }
            Ok(signal)
        })
        .collect::<Result<Vec<AngularSignal>, Error>>()?;
    let fastest = (0..=SPEED_SAMPLES)
        .map(|k| curve.speed(from + (to - from) * k as f64 / SPEED_SAMPLES as f64))
        .fold(0.0, f64::max);
    let by_rate = PASS_BAND * 0.5 * recording.rate_hz * TAU / fastest;
    let by_angle = signals.iter().map(AngularSignal::pass_order);
    Ok(AngularSignals {
        max_order: by_angle.fold(by_rate, f64::min),
        signals,
        curve,
        method_text: how + &part,
        diagnostics,
    })
}

/// The shaft's angle over the longest segment.
///
/// # Errors
/// As for `resample_to_angle`.
pub(super) fn shaft_angle(
    recording: &Recording,
    study: &SpectrumStudy,
    parts: &[Vec<f64>],
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<(AngleCurve, String), Error> {
    let rpm = |omega: f64| 60.0 * omega / TAU;
    if let Some(name) = &study.tacho {
        let mut unheard = Vec::new();
        let plain = SpectrumStudy {
            separate: false,
            ..study.clone()
        };
        let tacho = longest_segment_signals(
            recording,
            &[channel(recording, name)?],
            &plain,
            &mut unheard,
        )?;
        let samples = tacho.samples.first().map_or(&[][..], Vec::as_slice);
        let found = find_tacho_pulses(samples, recording.rate_hz, EdgeDirection::Rising, None)?;
        let missing: usize = found.missing.iter().map(|m| m.number).sum();
        if missing + found.extra_s.len() > 0 {
            diagnostics.push(Diagnostic {
                code: "tacho-pulses",
                message: format!(
                    "the tacho {name} misses {missing} pulses and has {} too many; its angle was put together without them",
                    found.extra_s.len()
                ),
                hint: Some("check the tacho's signal and --pulses".into()),
            });
        }
        if found.pulses.len() <= study.pulses_per_rev {
            let message = format!(
                "the tacho {name} has {} pulses, less than one turn at {} a turn",
                found.pulses.len(),
                study.pulses_per_rev
            );
            return Err(Error::new(Code::TooShort, message)
                .with_hint("is --pulses right? it takes the pulses of one turn"));
        }
        let curve = AngleCurve::from_pulses(&found, study.pulses_per_rev)?;
        let (from, to) = curve.time_range_s();
        let how = format!(
            "{} pulses of {name}, {:.2} … {:.2} rpm",
            found.pulses.len(),
            rpm(curve.speed(from)),
            rpm(curve.speed(to))
        );
        return Ok((curve, how));
    }
    let Some(speed) = study.speed else {
        return Err(Error::new(
            Code::Usage,
            "orders need the angle of the shaft: neither a tacho nor a speed is stated",
        )
        .with_hint("name the tacho's channel, --tacho COL, or a steady speed, --speed RPM"));
    };
    let samples = parts.first().map_or(0, Vec::len);
    let curve = AngleCurve::constant_speed(speed, samples as f64 / recording.rate_hz)?;
    Ok((curve, format!("steady at {:.4} rpm", rpm(speed))))
}

/// Amplitudes over orders, as half their squares with a bandwidth of one.
///
/// # Errors
/// No tacho and no speed, a tacho without pulses, fewer turns than a block.
pub fn order_spectra(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let AngularSignals {
        signals,
        max_order: highest,
        method_text: how,
        diagnostics,
        ..
    } = resample_to_angle(recording, channels, study)?;
    let whole = signals
        .iter()
        .map(AngularSignal::revolutions)
        .min()
        .unwrap_or(0);
    let turns = study
        .revolutions
        .unwrap_or((2 * whole / MIN_BLOCKS).clamp(1, MAX_REVOLUTIONS));
    let mut spectra = Spectra {
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    for signal in &signals {
        let lines = order_spectrum(signal, turns)?;
        spectra.rate_hz = signal.samples_per_rev as f64;
        spectra.blocks = lines.blocks;
        spectra.averages = Some((lines.blocks as f64 * INDEPENDENT_BLOCK_SHARE).max(1.0));
        let kept = lines.order.partition_point(|order| *order <= highest);
        let amplitudes = &lines.amplitude[..kept];
        spectra
            .psd
            .push(amplitudes.iter().map(|a| 0.5 * a * a).collect());
        spectra.frequency_hz = lines.order;
        spectra.frequency_hz.truncate(kept);
    }
    let how = format!(
        "{how}; {} of {} with lines {} apart, orders up to {highest:.2}",
        pluralise(spectra.blocks, "block"),
        pluralise(turns, "turn"),
        1.0 / turns as f64,
    );
    Ok(SpectrumEstimate {
        method_text: how,
        abscissa_kind: AbscissaKind::Order,
        spectra,
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
        diagnostics,
    })
}

/// Gives each row of a spectrogram the speed of the shaft in its middle; rows before the first pulse and after the last are dropped.
///
/// # Errors
/// As for `resample_to_angle`.
pub fn over_speed(
    mut result: SpectrumEstimate,
    recording: &Recording,
    study: &SpectrumStudy,
) -> Result<SpectrumEstimate, Error> {
    let (curve, how) = shaft_angle(recording, study, &[], &mut result.diagnostics)?;
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
    result.method_text += &format!("; {how}");
    Ok(result)
}

/// The mean over turns: angles in degrees, one turn of each channel.
pub struct SynchronousAverages {
    /// In words.
    pub method_text: String,
    /// Degrees.
    pub angle_deg: Vec<f64>,
    /// One turn of each channel.
    pub values: Vec<Vec<f64>>,
    /// Turns averaged.
    pub revolutions: usize,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Averages over turns.
///
/// # Errors
/// As [`order_spectra`].
pub fn synchronous_averages(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SynchronousAverages, Error> {
    let AngularSignals {
        signals,
        method_text: how,
        diagnostics,
        ..
    } = resample_to_angle(recording, channels, study)?;
    let all = signals
        .iter()
        .map(SynchronousAverage::new)
        .collect::<Result<Vec<SynchronousAverage>, Error>>()?;
    let turns = all.iter().map(|a| a.revolutions).min().unwrap_or(0);
    let noise = all
        .first()
        .map_or(0.0, SynchronousAverage::noise_reduction_db);
    let errors: Vec<String> = all
        .iter()
        .zip(channels)
        .map(|(a, c)| {
            format!("{} ± {:.4e} {}", c.name, Z_95 * a.standard_error, c.unit)
                .trim_end()
                .to_string()
        })
        .collect();
    let per_turn = signals.first().map_or(1, |s| s.samples_per_rev);
    Ok(SynchronousAverages {
        method_text: format!(
            "{how}; mean of {turns} turns, what does not repeat {noise:.1} dB lower; {}",
            errors.join(", ")
        ),
        angle_deg: (0..per_turn)
            .map(|i| 360.0 * i as f64 / per_turn as f64)
            .collect(),
        values: all.into_iter().map(|a| a.values).collect(),
        revolutions: turns,
        diagnostics,
    })
}

//! Spectrum analysis of a recording: spectra, cepstra and averages with labelled peaks.

use std::f64::consts::TAU;
use std::time::Instant;

use super::spectrum_study::{
    AbscissaKind, ChannelSpectrum, LabelledPeak, SpectrumEstimate, SpectrumKind, SpectrumResult,
    SpectrumStudy, channel,
};
use super::{fault_free, frequency_spectra, order_spectra, sample_blocks};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::parabola::log_vertex;
use crate::numeric::sorting::sort_descending;
use crate::numeric::statistics::normal_quantile;
use crate::recording::channel_unit::{self, MeasuredQuantity};
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::cepstrum::Cepstrum;
use crate::spectrum::integrate::MotionQuantity;
use crate::spectrum::line_labels::{self, label_lines};
use crate::spectrum::mains;
use crate::spectrum::peaks::{PeakOptions, find_peaks};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::window::Window;

/// Number of lines next to 0 Hz affected by mean and drift under a window.
const DC_LINES: usize = 3;

/// Computes the spectra that a study requests.
///
/// # Errors
/// Missing or constant channels, conflicting flags, and the errors of the method.
pub fn run_spectrum(recording: &Recording, study: &SpectrumStudy) -> Result<SpectrumResult, Error> {
    frequency_spectra::check_flags(study)?;
    let channels = study
        .channels
        .iter()
        .map(|name| channel(recording, name))
        .collect::<Result<Vec<&Channel>, Error>>()?;
    check_band(recording, study)?;
    check_signal(recording, &channels, study.kind)?;
    let start = Instant::now();
    let names: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    let index = |c: &&Channel| names.iter().position(|name| *name == c.name);
    let indices: Vec<usize> = channels.iter().filter_map(index).collect();
    let faults = fault_free::spectrum_warnings(recording, &indices)?;
    let mut result = match study.kind {
        SpectrumKind::Cepstrum => cepstrum(recording, &channels, study)?,
        SpectrumKind::SynchronousAverage => synchronous_average(recording, &channels, study)?,
        _ => {
            let estimate = match study.kind {
                SpectrumKind::Multitaper => {
                    frequency_spectra::multitaper_spectra(recording, &channels, study)?
                }
                SpectrumKind::Envelope => {
                    frequency_spectra::envelope_spectra(recording, &channels, study)?
                }
                SpectrumKind::Spectrogram => {
                    let spectrogram = frequency_spectra::spectrograms(recording, &channels, study)?;
                    match study.tacho {
                        Some(_) => order_spectra::over_speed(spectrogram, recording, study)?,
                        None => spectrogram,
                    }
                }
                SpectrumKind::Order => order_spectra::order_spectra(recording, &channels, study)?,
                _ => frequency_spectra::welch_spectra(recording, &channels, study)?,
            };
            build_result(estimate, &channels, study)?
        }
    };
    let stage = match study.kind {
        SpectrumKind::Cepstrum => "cepstrum",
        SpectrumKind::SynchronousAverage => "average over turns",
        SpectrumKind::Order => "order spectrum",
        _ => "spectrum",
    };
    result.diagnostics.splice(0..0, faults);
    result.trace.push((stage, start.elapsed().as_secs_f64()));
    Ok(result)
}

fn check_band(recording: &Recording, study: &SpectrumStudy) -> Result<(), Error> {
    let half = 0.5 * recording.rate_hz;
    match study.band {
        Some((low, high)) if study.kind != SpectrumKind::Order && low >= half => {
            let message = format!(
                "the band {} … {} Hz lies above half the sample rate, {} Hz",
                format_short(low),
                format_short(high),
                format_short(half)
            );
            Err(Error::new(Code::OutOfRange, message)
                .with_hint(format!("choose a band below {} Hz", format_short(half))))
        }
        _ => Ok(()),
    }
}

/// Rejects constant channels and amplitudes whose squares overflow.
fn check_signal(
    recording: &Recording,
    channels: &[&Channel],
    kind: SpectrumKind,
) -> Result<(), Error> {
    // Range of amplitudes whose squares neither overflow nor underflow; an envelope squares twice.
    let amplitudes = match kind {
        SpectrumKind::Envelope => 1e-70..1e70,
        _ => 1e-140..1e140,
    };
    let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); channels.len()];
    sample_blocks::for_each_block(recording, channels, |block, _| {
        for ((low, high), samples) in ranges.iter_mut().zip(block) {
            for &x in *samples {
                *low = low.min(x);
                *high = high.max(x);
            }
        }
    })?;
    let constant = ranges
        .iter()
        .zip(channels)
        .find(|((low, high), _)| low >= high);
    match constant {
        Some(((low, _), channel)) => {
            let message = format!("the channel {} is {low} throughout", channel.name);
            Err(Error::new(Code::NoSignal, message).with_hint(
                "check whether the sensor was connected, and whether this is its channel",
            ))
        }
        None => {
            let largest = |(low, high): &(f64, f64)| high.abs().max(low.abs());
            let overflowing = ranges
                .iter()
                .zip(channels)
                .find(|(r, _)| !amplitudes.contains(&largest(r)));
            match overflowing {
                Some((range, channel)) => Err(out_of_range(channel, largest(range))),
                None => Ok(()),
            }
        }
    }
}

/// Error for a channel whose squares overflow or underflow.
fn out_of_range(channel: &Channel, size: f64) -> Error {
    let message = format!(
        "the squares of {} overflow: it reaches {size:e}",
        channel.name
    );
    Error::new(Code::OutOfRange, message)
        .with_hint("check its unit, sensitivity and range: geardyn check")
}

/// Conversion of a measured density to the requested one: `scale² ω^(2 power)`.
#[derive(Clone, Copy)]
struct DensityConversion {
    scale: f64,
    power: i32,
    low_hz: f64,
}

impl DensityConversion {
    /// Factor on an amplitude at a frequency, Hz; zero below the low cut-off.
    fn amplitude_factor(self, frequency_hz: f64) -> f64 {
        match self.power {
            _ if frequency_hz < self.low_hz => 0.0,
            0 => self.scale,
            p => self.scale * (TAU * frequency_hz).powi(p),
        }
    }
}

/// Density conversion of a channel to a motion quantity, with the resulting unit.
fn conversion(
    channel: &Channel,
    motion: Option<MotionQuantity>,
    low_hz: f64,
) -> Result<(DensityConversion, String), Error> {
    let unchanged = DensityConversion {
        scale: 1.0,
        power: 0,
        low_hz: 0.0,
    };
    let Some(motion) = motion else {
        return Ok((unchanged, channel.unit.clone()));
    };
    let unknown = || {
        let message = format!(
            "the unit \"{}\" of {} is not a unit of motion",
            channel.unit, channel.name
        );
        Error::new(Code::WrongUnit, message)
            .with_hint(format!("state its unit: --unit \"{}=m/s²\"", channel.name))
    };
    let quantity = channel_unit::parse(&channel.unit).ok_or_else(unknown)?;
    let measured_order = quantity
        .quantity
        .time_derivative_order()
        .ok_or_else(unknown)?;
    let is_angular = matches!(
        quantity.quantity,
        MeasuredQuantity::Angle
            | MeasuredQuantity::AngularVelocity
            | MeasuredQuantity::AngularAcceleration
    );
    let (order, unit) = match (motion, is_angular) {
        (MotionQuantity::Displacement, false) => (0, "m"),
        (MotionQuantity::Velocity, false) => (1, "m/s"),
        (MotionQuantity::Acceleration, false) => (2, "m/s²"),
        (MotionQuantity::Displacement, true) => (0, "rad"),
        (MotionQuantity::Velocity, true) => (1, "rad/s"),
        (MotionQuantity::Acceleration, true) => (2, "rad/s²"),
    };
    let power = order - i32::from(measured_order);
    let conversion = DensityConversion {
        scale: quantity.factor,
        power,
        low_hz: if power < 0 { low_hz } else { 0.0 },
    };
    Ok((conversion, unit.to_string()))
}

/// Builds the result: converted spectrum within the band, with labelled peaks.
fn build_result(
    result: SpectrumEstimate,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    let SpectrumEstimate {
        mut method_text,
        abscissa_kind,
        spectra,
        spectrogram_rows: mut rows,
        speed,
        mut diagnostics,
    } = result;
    let band = match study.kind {
        SpectrumKind::Envelope => None,
        _ => study.band,
    };
    let in_band: Vec<usize> = (0..spectra.frequency_hz.len())
        .filter(|&k| is_inside(band, spectra.frequency_hz[k]))
        .collect();
    let spacing = frequency_resolution(&spectra);
    if in_band.is_empty() {
        let message = match band {
            Some((low, high)) => {
                format!(
                    "no line lies in the band {} … {}",
                    format_short(low),
                    format_short(high)
                )
            }
            None => "the spectrum has no line".to_string(),
        };
        return Err(Error::new(Code::OutOfRange, message).with_hint(format!(
            "lines are {} apart; choose a wider band",
            format_short(spacing)
        )));
    }
    let low_hz = band.map_or(0.0, |b| b.0).max(DC_LINES as f64 * spacing);
    let mut channel_spectra = Vec::new();
    for (c, channel) in channels.iter().enumerate() {
        check_range(channel, &spectra.psd[c])?;
        let (conversion, unit) = conversion(channel, study.history, low_hz)?;
        if conversion.low_hz > 0.0 && c == 0 {
            method_text += &format!("; nothing below {} Hz", format_short(low_hz));
        }
        let (value_unit, amplitude_unit) = units(study.kind, &unit);
        let value = |f: f64, density: f64, edge: f64| -> f64 {
            let converted = conversion.amplitude_factor(f).powi(2) * density;
            match study.kind {
                SpectrumKind::Amplitude | SpectrumKind::Envelope | SpectrumKind::Order => {
                    (edge * converted * spectra.bandwidth_hz).sqrt()
                }
                SpectrumKind::Rms => (converted * spectra.bandwidth_hz).sqrt(),
                _ => converted,
            }
        };
        let edge = |k: usize| {
            let is_real = spectra.is_real_line(k) && study.kind == SpectrumKind::Amplitude;
            if is_real { 1.0 } else { 2.0 }
        };
        let value_at = |&k: &usize| value(spectra.frequency_hz[k], spectra.psd[c][k], edge(k));
        let rms = study.kind == SpectrumKind::Rms;
        let is_flat_top = study.window == Some(Window::FlatTop);
        let mut lines = labelled_peaks(&spectra, c, band, is_flat_top);
        for line in &mut lines {
            let tone = conversion.amplitude_factor(line.position)
                * (spectra.bandwidth_hz * line.value).sqrt();
            line.amplitude = if rms { tone } else { 2f64.sqrt() * tone };
            line.value = value(line.position, line.value, 2.0);
        }
        lines.retain(|line| line.amplitude > 0.0);
        sort_descending(&mut lines, |a| a.amplitude);
        // In a run-up the response lags increasingly: the order is uncertain by a line.
        let uncertainty = match abscissa_kind {
            AbscissaKind::Order => 2.0 * spacing,
            _ => spacing,
        };
        label_peaks(&mut lines, study, uncertainty);
        if abscissa_kind == AbscissaKind::Frequency {
            name_mains(&mut lines, spacing);
        }
        let mut channel_rows = if rows.is_empty() {
            Vec::new()
        } else {
            std::mem::take(&mut rows[c])
        };
        for row in &mut channel_rows {
            row.density = in_band.iter().map(|&k| row.density[k]).collect();
        }
        channel_spectra.push(ChannelSpectrum {
            channel: channel.name.clone(),
            unit: value_unit,
            amplitude_unit,
            value: in_band.iter().map(value_at).collect(),
            peaks: lines,
            spectrogram_rows: channel_rows,
            speed: speed.clone(),
        });
    }
    if channel_spectra
        .iter()
        .all(|c| c.peaks.iter().all(|l| !l.significant))
    {
        diagnostics.push(Diagnostic {
            code: "no-line",
            message: "no line rises above the floor and its neighbours: the strongest is shown"
                .into(),
            hint: Some(
                "average more blocks by a coarser --resolution, or choose another --band".into(),
            ),
        });
    }
    let inner = 1.min(spectra.frequency_hz.len() - 1);
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text,
        kind: study.kind,
        abscissa_kind,
        abscissa: in_band.iter().map(|&k| spectra.frequency_hz[k]).collect(),
        channel_spectra,
        quefrency_range_s: None,
        abscissa_step: spacing,
        averages: spectra.averages,
        interval: spectra.confidence_factors(inner, 0.95),
        diagnostics,
    })
}

/// Rejects a channel whose spectral density is zero or not finite.
fn check_range(channel: &Channel, density: &[f64]) -> Result<(), Error> {
    if density.iter().all(|s| s.is_finite()) && density.iter().any(|s| *s > 0.0) {
        return Ok(());
    }
    let message = format!(
        "no line of {} is above zero: it hardly changes relative to its largest value",
        channel.name
    );
    Err(Error::new(Code::OutOfRange, message)
        .with_hint("check its unit, sensitivity and range: geardyn check"))
}

/// Formats a frequency, Hz, with the digits significant at a relative resolution of `step` · f.
fn format_significant(hertz: f64, step: f64) -> String {
    let digits = (-(step * hertz).log10()).clamp(2.0, 6.0) as usize;
    let exponent = hertz.abs().log10().floor().max(0.0) as usize;
    format!("{hertz:.*}", digits.saturating_sub(exponent))
}

/// Formats a frequency, Hz, without trailing zeros.
fn format_short(hertz: f64) -> String {
    if !(1e-5..1e12).contains(&hertz.abs()) && hertz != 0.0 {
        return format!("{hertz:e}");
    }
    let text = format!("{hertz:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

pub(super) fn is_inside(band: Option<(f64, f64)>, position: f64) -> bool {
    band.is_none_or(|(low, high)| (low..=high).contains(&position))
}

/// Line spacing, in the unit of the abscissa.
fn frequency_resolution(spectra: &Spectra) -> f64 {
    match spectra.frequency_hz[..] {
        [first, second, ..] => second - first,
        _ => 0.0,
    }
}

/// Units of the spectrum and of the amplitudes of its lines.
fn units(kind: SpectrumKind, unit: &str) -> (String, String) {
    let square = match unit {
        "" => String::new(),
        unit if unit.contains(['/', '·', ' ', '²']) => format!("({unit})²"),
        unit => format!("{unit}²"),
    };
    match kind {
        SpectrumKind::Envelope => (square.clone(), square),
        SpectrumKind::Amplitude | SpectrumKind::Rms | SpectrumKind::Order => {
            (unit.to_string(), unit.to_string())
        }
        _ if unit.is_empty() => ("1/Hz".to_string(), String::new()),
        _ => (format!("{square}/Hz"), unit.to_string()),
    }
}

/// Significant peaks in the band with their densities, including the strongest in any case. Under a flat-top window (`flat`) the
/// highest line gives the height of a tone.
pub(super) fn labelled_peaks(
    spectra: &Spectra,
    channel: usize,
    band: Option<(f64, f64)>,
    flat: bool,
) -> Vec<LabelledPeak> {
    let in_band = |f: f64| is_inside(band, f);
    let line = |position: f64, density: f64, ratio: Option<f64>, significant: bool| LabelledPeak {
        position,
        value: density,
        amplitude: 0.0,
        signal_to_noise: ratio,
        significant,
        names: Vec::new(),
    };
    let (psd, f) = (&spectra.psd[channel], &spectra.frequency_hz);
    let peaks = find_peaks(spectra, channel, &PeakOptions::default());
    let mut labelled: Vec<LabelledPeak> = peaks
        .iter()
        .filter(|p| in_band(p.frequency_hz))
        .map(|p| {
            let height = if flat { psd[p.line] } else { p.psd };
            line(p.frequency_hz, height, Some(p.signal_to_noise), true)
        })
        .collect();
    let top = |&k: &usize| psd[k] > psd[k - 1] && psd[k] >= psd[k + 1] && in_band(f[k]);
    let strongest = (DC_LINES..psd.len().saturating_sub(1))
        .filter(top)
        .max_by(|&a, &b| psd[a].total_cmp(&psd[b]));
    if let Some(k) = strongest
        && psd[k] > 0.0
        && !peaks.iter().any(|p| p.line == k)
    {
        let (shift, top) = log_vertex([psd[k - 1], psd[k], psd[k + 1]]);
        let height = if flat { psd[k] } else { top };
        labelled.push(line(f[k] + shift * (f[k] - f[k - 1]), height, None, false));
    }
    labelled
}

/// Labels peaks with the expected lines within the frequency uncertainty.
pub(super) fn label_peaks(lines: &mut [LabelledPeak], study: &SpectrumStudy, spacing: f64) {
    let measured: Vec<line_labels::MeasuredLine> = lines
        .iter()
        .map(|line| line_labels::MeasuredLine {
            position: line.position,
            amplitude: line.amplitude,
            uncertainty: 0.5 * spacing,
        })
        .collect();
    for (line, label) in lines
        .iter_mut()
        .zip(label_lines(&measured, &study.expected_lines))
    {
        for &candidate in label.candidates.iter().take(label.indistinguishable) {
            let name = &study.expected_lines[candidate].name;
            if !line.names.contains(name) {
                line.names.push(name.clone());
            }
        }
    }
}

/// Labels the significant peaks at mains frequencies.
fn name_mains(lines: &mut [LabelledPeak], spacing: f64) {
    let mut peaks: Vec<&mut LabelledPeak> = lines.iter_mut().filter(|l| l.significant).collect();
    let positions: Vec<f64> = peaks.iter().map(|l| l.position).collect();
    let names = mains::names(&positions, 0.5 * spacing);
    for (line, name) in peaks.iter_mut().zip(names) {
        line.names.extend(name);
    }
}

/// Real cepstra with the rahmonics of their strongest family.
fn cepstrum(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    const RAHMONICS: usize = 8;
    // Families closer than four lines are not resolved; at the first samples they merge with the slope of the spectrum.
    const QUEFRENCY_RANGE: (f64, f64) = (8.0, 0.5);
    /// False-alarm probability of a family per cepstrum.
    const FALSE_ALARMS: f64 = 0.01;
    let result = frequency_spectra::welch_spectra(recording, channels, study)?;
    let mut diagnostics = result.diagnostics;
    let lines = result.spectra.frequency_hz.len();
    let block =
        (recording.rate_hz / result.spectra.frequency_hz[1.min(lines - 1)]).round() as usize;
    let cepstrum = |(density, channel): (&Vec<f64>, &&Channel)| {
        check_range(channel, density)?;
        Cepstrum::from_psd(density, block, recording.rate_hz)
    };
    let pairs = result.spectra.psd.iter().zip(channels);
    let all = pairs.map(cepstrum).collect::<Result<Vec<_>, Error>>()?;
    let quefrencies_s = all.first().map_or(Vec::new(), |c| c.quefrency_s());
    let max_s = quefrencies_s.last().copied().unwrap_or(0.0);
    let (low_s, high_s) = match study.band {
        Some((low, high)) => (1.0 / high, (1.0 / low).min(max_s)),
        None => (
            QUEFRENCY_RANGE.0 / recording.rate_hz,
            QUEFRENCY_RANGE.1 * max_s,
        ),
    };
    let n_tested = ((high_s - low_s) * recording.rate_hz).max(1.0);
    let threshold = normal_quantile(1.0 - FALSE_ALARMS / n_tested);
    let channel_spectra: Vec<ChannelSpectrum> = all
        .into_iter()
        .zip(channels)
        .map(|(cepstrum, channel)| {
            let family = cepstrum.rahmonics(low_s, high_s, RAHMONICS);
            let noise = family
                .as_ref()
                .map_or(0.0, |f| cepstrum.noise_std(f.quefrency_s));
            let line = |(k, height): (usize, &f64), first: f64| LabelledPeak {
                position: (k + 1) as f64 * first,
                value: *height,
                amplitude: *height,
                signal_to_noise: (noise > 0.0).then_some((height / noise).powi(2)),
                significant: *height > threshold * noise,
                names: vec![match k {
                    0 => format!("lines {} Hz apart", format_significant(1.0 / first, first)),
                    _ => format!("{}th rahmonic", k + 1)
                        .replace("2th", "2nd")
                        .replace("3th", "3rd"),
                }],
            };
            ChannelSpectrum {
                channel: channel.name.clone(),
                unit: "Np".into(),
                amplitude_unit: "Np".into(),
                peaks: family.map_or(Vec::new(), |family| {
                    let heights = family.height.iter().enumerate();
                    heights.map(|h| line(h, family.quefrency_s)).collect()
                }),
                value: cepstrum.real,
                spectrogram_rows: Vec::new(),
                speed: Vec::new(),
            }
        })
        .collect();
    if channel_spectra
        .iter()
        .all(|c| c.peaks.iter().all(|l| !l.significant))
    {
        diagnostics.push(Diagnostic {
            code: "no-line",
            message: "no family of lines rises above the noise: the strongest is shown".into(),
            hint: Some(
                "average more blocks by a coarser --resolution, or choose another --band".into(),
            ),
        });
    }
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: format!(
            "real cepstrum of {}; families sought of lines {:.4} to {:.4} Hz apart, {low_s:.6} to {high_s:.6} s",
            result.method_text,
            1.0 / high_s,
            1.0 / low_s,
        ),
        kind: study.kind,
        abscissa_kind: AbscissaKind::Quefrency,
        abscissa: quefrencies_s,
        channel_spectra,
        quefrency_range_s: Some((low_s, high_s)),
        abscissa_step: 1.0 / recording.rate_hz,
        averages: result.spectra.averages,
        interval: None,
        diagnostics,
    })
}

/// Synchronous averages over revolutions.
fn synchronous_average(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    let means = order_spectra::synchronous_averages(recording, channels, study)?;
    let curve = |(value, channel): (Vec<f64>, &&Channel)| ChannelSpectrum {
        channel: channel.name.clone(),
        unit: channel.unit.clone(),
        amplitude_unit: channel.unit.clone(),
        value,
        peaks: Vec::new(),
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
    };
    let n_angles = means.angle_deg.len();
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: means.method_text,
        kind: study.kind,
        abscissa_kind: AbscissaKind::Angle,
        abscissa: means.angle_deg,
        channel_spectra: means.values.into_iter().zip(channels).map(curve).collect(),
        quefrency_range_s: None,
        abscissa_step: 360.0 / n_angles as f64,
        averages: Some(means.revolutions as f64),
        interval: None,
        diagnostics: means.diagnostics,
    })
}

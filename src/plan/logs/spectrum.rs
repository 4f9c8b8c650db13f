//! Spectrum run: recording to spectra with labelled peaks.

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
use crate::numeric::sorting::sort_falling;
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

/// Lines next to 0 Hz in which a mean or a drift shows under a window.
const DC_LINES: usize = 3;

/// The spectra a study asks for.
///
/// # Errors
/// Channels that are not there or hold no signal, flags that do not fit, whatever the method refuses.
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
    let known: Vec<String> = recording.channels.iter().map(|c| c.name.clone()).collect();
    let place = |c: &&Channel| known.iter().position(|name| *name == c.name);
    let places: Vec<usize> = channels.iter().filter_map(place).collect();
    let faults = fault_free::spectrum_warnings(recording, &places)?;
    let mut answer = match study.kind {
        SpectrumKind::Cepstrum => cepstrum(recording, &channels, study)?,
        SpectrumKind::SynchronousAverage => synchronous_average(recording, &channels, study)?,
        _ => {
            let result = match study.kind {
                SpectrumKind::Multitaper => {
                    frequency_spectra::multitaper_spectra(recording, &channels, study)?
                }
                SpectrumKind::Envelope => {
                    frequency_spectra::envelope_spectra(recording, &channels, study)?
                }
                SpectrumKind::Spectrogram => {
                    let result = frequency_spectra::spectrograms(recording, &channels, study)?;
                    match study.tacho {
                        Some(_) => order_spectra::over_speed(result, recording, study)?,
                        None => result,
                    }
                }
                SpectrumKind::Order => order_spectra::order_spectra(recording, &channels, study)?,
                _ => frequency_spectra::welch_spectra(recording, &channels, study)?,
            };
            build_result(result, &channels, study)?
        }
    };
    let stage = match study.kind {
        SpectrumKind::Cepstrum => "cepstrum",
        SpectrumKind::SynchronousAverage => "average over turns",
        SpectrumKind::Order => "order spectrum",
        _ => "spectrum",
    };
    answer.diagnostics.splice(0..0, faults);
    answer.trace.push((stage, start.elapsed().as_secs_f64()));
    Ok(answer)
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

/// Refuses channels that never change.
fn check_signal(
    recording: &Recording,
    channels: &[&Channel],
    kind: SpectrumKind,
) -> Result<(), Error> {
    // Squares of samples and of their sums are numbers in this range; of the squares of an envelope they are once more squared.
    let sizes = match kind {
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
    let still = ranges
        .iter()
        .zip(channels)
        .find(|((low, high), _)| low >= high);
    match still {
        Some(((low, _), channel)) => {
            let message = format!("the channel {} is {low} throughout", channel.name);
            Err(Error::new(Code::NoSignal, message).with_hint(
                "check whether the sensor was connected, and whether this is its channel",
            ))
        }
        None => {
            let size = |(low, high): &(f64, f64)| high.abs().max(low.abs());
            let wild = ranges
                .iter()
                .zip(channels)
                .find(|(r, _)| !sizes.contains(&size(r)));
            match wild {
                Some((range, channel)) => Err(out_of_range(channel, size(range))),
                None => Ok(()),
            }
        }
    }
}

/// The error of a channel whose squares are no numbers.
fn out_of_range(channel: &Channel, size: f64) -> Error {
    let message = format!(
        "the squares of {} leave the range of numbers: it reaches {size:e}",
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
    /// On an amplitude at a frequency; nothing below the low cut.
    fn amplitude_factor(self, frequency_hz: f64) -> f64 {
        match self.power {
            _ if frequency_hz < self.low_hz => 0.0,
            0 => self.scale,
            p => self.scale * (TAU * frequency_hz).powi(p),
        }
    }
}

/// The conversion of a channel and the unit that comes out.
fn conversion(
    channel: &Channel,
    history: Option<MotionQuantity>,
    low_hz: f64,
) -> Result<(DensityConversion, String), Error> {
    let unchanged = DensityConversion {
        scale: 1.0,
        power: 0,
        low_hz: 0.0,
    };
    let Some(history) = history else {
        return Ok((unchanged, channel.unit.clone()));
    };
    let unknown = || {
        let message = format!(
            "the unit \"{}\" of {} is not that of a motion",
            channel.unit, channel.name
        );
        Error::new(Code::WrongUnit, message)
            .with_hint(format!("state its unit: --unit \"{}=m/s²\"", channel.name))
    };
    let quantity = channel_unit::parse(&channel.unit).ok_or_else(unknown)?;
    let times = quantity
        .quantity
        .time_derivative_order()
        .ok_or_else(unknown)?;
    let turns = matches!(
        quantity.quantity,
        MeasuredQuantity::Angle
            | MeasuredQuantity::AngularVelocity
            | MeasuredQuantity::AngularAcceleration
    );
    let (wanted, unit) = match (history, turns) {
        (MotionQuantity::Displacement, false) => (0, "m"),
        (MotionQuantity::Velocity, false) => (1, "m/s"),
        (MotionQuantity::Acceleration, false) => (2, "m/s²"),
        (MotionQuantity::Displacement, true) => (0, "rad"),
        (MotionQuantity::Velocity, true) => (1, "rad/s"),
        (MotionQuantity::Acceleration, true) => (2, "rad/s²"),
    };
    let power = wanted - i32::from(times);
    let conversion = DensityConversion {
        scale: quantity.factor,
        power,
        low_hz: if power < 0 { low_hz } else { 0.0 },
    };
    Ok((conversion, unit.to_string()))
}

/// Builds the result: spectrum converted, cut to the band, its lines named.
fn build_result(
    result: SpectrumEstimate,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    let SpectrumEstimate {
        method_text: mut how,
        abscissa_kind: across,
        spectra,
        spectrogram_rows: mut rows,
        speed,
        mut diagnostics,
    } = result;
    let band = match study.kind {
        SpectrumKind::Envelope => None,
        _ => study.band,
    };
    let inside: Vec<usize> = (0..spectra.frequency_hz.len())
        .filter(|&k| is_inside(band, spectra.frequency_hz[k]))
        .collect();
    let spacing = frequency_resolution(&spectra);
    if inside.is_empty() {
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
            how += &format!("; nothing below {} Hz", format_short(low_hz));
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
            let once = spectra.is_real_line(k) && study.kind == SpectrumKind::Amplitude;
            if once { 1.0 } else { 2.0 }
        };
        let at = |&k: &usize| value(spectra.frequency_hz[k], spectra.psd[c][k], edge(k));
        let rms = study.kind == SpectrumKind::Rms;
        let flat = study.window == Some(Window::FlatTop);
        let mut lines = labelled_peaks(&spectra, c, band, flat);
        for line in &mut lines {
            let tone = conversion.amplitude_factor(line.position)
                * (spectra.bandwidth_hz * line.value).sqrt();
            line.amplitude = if rms { tone } else { 2f64.sqrt() * tone };
            line.value = value(line.position, line.value, 2.0);
        }
        lines.retain(|line| line.amplitude > 0.0);
        sort_falling(&mut lines, |a| a.amplitude);
        // While a shaft speeds up, what answers it lags more and more: an order is known to a whole line.
        let known = match across {
            AbscissaKind::Order => 2.0 * spacing,
            _ => spacing,
        };
        label_peaks(&mut lines, study, known);
        if across == AbscissaKind::Frequency {
            name_mains(&mut lines, spacing);
        }
        let mut of_channel = if rows.is_empty() {
            Vec::new()
        } else {
            std::mem::take(&mut rows[c])
        };
        for row in &mut of_channel {
            row.density = inside.iter().map(|&k| row.density[k]).collect();
        }
        channel_spectra.push(ChannelSpectrum {
            channel: channel.name.clone(),
            unit: value_unit,
            amplitude_unit,
            value: inside.iter().map(at).collect(),
            peaks: lines,
            spectrogram_rows: of_channel,
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
            hint: Some("average more blocks by a coarser --resolution, or choose a --band".into()),
        });
    }
    let inner = 1.min(spectra.frequency_hz.len() - 1);
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: how,
        kind: study.kind,
        abscissa_kind: across,
        abscissa: inside.iter().map(|&k| spectra.frequency_hz[k]).collect(),
        channel_spectra,
        quefrency_range_s: None,
        abscissa_step: spacing,
        averages: spectra.averages,
        interval: spectra.confidence_factors(inner, 0.95),
        diagnostics,
    })
}

/// Refuses a channel that changes, but whose squares are none.
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

/// A frequency in as many digits as a relative step of `step` leaves meaning.
fn format_significant(hertz: f64, step: f64) -> String {
    let digits = (-(step * hertz).log10()).clamp(2.0, 6.0) as usize;
    let whole = hertz.abs().log10().floor().max(0.0) as usize;
    format!("{hertz:.*}", digits.saturating_sub(whole))
}

/// A frequency without zeros behind.
fn format_short(hertz: f64) -> String {
    if !(1e-5..1e12).contains(&hertz.abs()) && hertz != 0.0 {
        return format!("{hertz:e}");
    }
    let text = format!("{hertz:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

pub(super) fn is_inside(band: Option<(f64, f64)>, place: f64) -> bool {
    band.is_none_or(|(low, high)| (low..=high).contains(&place))
}

/// Between lines.
fn frequency_resolution(spectra: &Spectra) -> f64 {
    match spectra.frequency_hz[..] {
        [first, second, ..] => second - first,
        _ => 0.0,
    }
}

/// Units of the curve and of the amplitudes of its lines.
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

/// Lines in the band, their values densities: the significant ones, and in any case the strongest. Under a `flat` window the
/// highest line is the height of a tone.
pub(super) fn labelled_peaks(
    spectra: &Spectra,
    channel: usize,
    band: Option<(f64, f64)>,
    flat: bool,
) -> Vec<LabelledPeak> {
    let inside = |f: f64| is_inside(band, f);
    let line = |position: f64, density: f64, ratio: Option<f64>, significant: bool| LabelledPeak {
        position,
        value: density,
        amplitude: 0.0,
        signal_to_noise: ratio,
        significant,
        names: Vec::new(),
    };
    let (psd, f) = (&spectra.psd[channel], &spectra.frequency_hz);
    let found = find_peaks(spectra, channel, &PeakOptions::default());
    let mut all: Vec<LabelledPeak> = found
        .iter()
        .filter(|p| inside(p.frequency_hz))
        .map(|p| {
            let height = if flat { psd[p.line] } else { p.psd };
            line(p.frequency_hz, height, Some(p.signal_to_noise), true)
        })
        .collect();
    let top = |&k: &usize| psd[k] > psd[k - 1] && psd[k] >= psd[k + 1] && inside(f[k]);
    let strongest = (DC_LINES..psd.len().saturating_sub(1))
        .filter(top)
        .max_by(|&a, &b| psd[a].total_cmp(&psd[b]));
    if let Some(k) = strongest
        && psd[k] > 0.0
        && !found.iter().any(|p| p.line == k)
    {
        let (shift, top) = log_vertex([psd[k - 1], psd[k], psd[k + 1]]);
        let height = if flat { psd[k] } else { top };
        all.push(line(f[k] + shift * (f[k] - f[k - 1]), height, None, false));
    }
    all
}

/// Gives lines the names of what was expected within reach.
pub(super) fn label_peaks(lines: &mut [LabelledPeak], study: &SpectrumStudy, spacing: f64) {
    let measured: Vec<line_labels::MeasuredLine> = lines
        .iter()
        .map(|line| line_labels::MeasuredLine {
            position: line.position,
            amplitude: line.amplitude,
            uncertainty: 0.5 * spacing,
        })
        .collect();
    for (line, found) in lines
        .iter_mut()
        .zip(label_lines(&measured, &study.expected_lines))
    {
        for &candidate in found.candidates.iter().take(found.indistinguishable) {
            let name = &study.expected_lines[candidate].name;
            if !line.names.contains(name) {
                line.names.push(name.clone());
            }
        }
    }
}

/// Names the lines of the mains among the significant ones.
fn name_mains(lines: &mut [LabelledPeak], spacing: f64) {
    let mut clear: Vec<&mut LabelledPeak> = lines.iter_mut().filter(|l| l.significant).collect();
    let positions: Vec<f64> = clear.iter().map(|l| l.position).collect();
    let names = mains::names(&positions, 0.5 * spacing);
    for (line, name) in clear.iter_mut().zip(names) {
        line.names.extend(name);
    }
}

/// Real cepstra with their strongest family.
fn cepstrum(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    const RAHMONICS: usize = 8;
    // A family of lines closer than four lines of the spectrum is not resolved, and one of the first samples is not told from its slope.
    const QUEFRENCY_RANGE: (f64, f64) = (8.0, 0.5);
    /// Families that noise alone may show in a hundred cepstra.
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
    let both = result.spectra.psd.iter().zip(channels);
    let all = both.map(cepstrum).collect::<Result<Vec<_>, Error>>()?;
    let places = all.first().map_or(Vec::new(), |c| c.quefrency_s());
    let longest = places.last().copied().unwrap_or(0.0);
    let (low_s, high_s) = match study.band {
        Some((low, high)) => (1.0 / high, (1.0 / low).min(longest)),
        None => (
            QUEFRENCY_RANGE.0 / recording.rate_hz,
            QUEFRENCY_RANGE.1 * longest,
        ),
    };
    let sought = ((high_s - low_s) * recording.rate_hz).max(1.0);
    let least = normal_quantile(1.0 - FALSE_ALARMS / sought);
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
                significant: *height > least * noise,
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
            hint: Some("average more blocks by a coarser --resolution, or choose a --band".into()),
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
        abscissa: places,
        channel_spectra,
        quefrency_range_s: Some((low_s, high_s)),
        abscissa_step: 1.0 / recording.rate_hz,
        averages: result.spectra.averages,
        interval: None,
        diagnostics,
    })
}

/// The mean over turns.
fn synchronous_average(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<SpectrumResult, Error> {
    let found = order_spectra::synchronous_averages(recording, channels, study)?;
    let curve = |(value, channel): (Vec<f64>, &&Channel)| ChannelSpectrum {
        channel: channel.name.clone(),
        unit: channel.unit.clone(),
        amplitude_unit: channel.unit.clone(),
        value,
        peaks: Vec::new(),
        spectrogram_rows: Vec::new(),
        speed: Vec::new(),
    };
    let per_turn = found.angle_deg.len();
    Ok(SpectrumResult {
        trace: Vec::new(),
        method_text: found.method_text,
        kind: study.kind,
        abscissa_kind: AbscissaKind::Angle,
        abscissa: found.angle_deg,
        channel_spectra: found.values.into_iter().zip(channels).map(curve).collect(),
        quefrency_range_s: None,
        abscissa_step: 360.0 / per_turn as f64,
        averages: Some(found.revolutions as f64),
        interval: None,
        diagnostics: found.diagnostics,
    })
}

//! Spectra over the angle of a shaft: orders, and the mean over turns.

use std::f64::consts::TAU;

use super::spectrum_study::{Across, Found, SpectrumStudy, channel};
use super::steady::{longest, longest_parts, of_random_part, random_part};
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::base::words::counted;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::rotation::angle::AngleCurve;
use crate::spectrum::rotation::angular::{AngularSignal, resample};
use crate::spectrum::rotation::averaging::TurnAverage;
use crate::spectrum::rotation::interpolation::PASS;
use crate::spectrum::rotation::orders::order_spectrum;
use crate::spectrum::rotation::tacho::{Slope, pulses};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::spectrogram::Row;

/// Instants at which the highest speed is looked for.
const SPEEDS: usize = 1000;

/// Values a turn at most, and at least.
const PER_TURN: (usize, usize) = (16, 1 << 14);

/// Blocks that a run is cut into at least, and turns in a block at most, where nobody says how.
const LEAST_BLOCKS: usize = 8;

/// See [`LEAST_BLOCKS`].
const MOST_TURNS: usize = 64;

/// Independent blocks to one of Hann's that overlap by half: 1/(1 + 2/36), Welch (1967).
const INDEPENDENT: f64 = 36.0 / 38.0;

/// Signals over angle, and how in words.
pub(super) struct Turned {
    /// By channel.
    pub signals: Vec<AngularSignal>,
    /// The angle of the shaft.
    pub curve: AngleCurve,
    /// The highest order that is kept whole at every speed.
    pub highest: f64,
    /// In words.
    pub how: String,
    /// Data-quality warnings.
    pub warnings: Vec<Warning>,
}

/// Channels over the angle of the shaft.
///
/// # Errors
/// No tacho and no speed, a tacho without pulses, a shaft too fast for the rate.
pub(super) fn turned(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Turned, Error> {
    let mut warnings = Vec::new();
    let plain = SpectrumStudy {
        separate: false,
        ..study.clone()
    };
    let parts = longest_parts(recording, channels, &plain, &mut warnings)?;
    let (curve, how) = angle(recording, study, &parts.samples, &mut warnings)?;
    let (first, last) = curve.angles();
    let (from, to) = curve.times_s();
    let turns_per_s = (last - first) / TAU / (to - from);
    // Fewer samples than this in a turn hold not even its first order with room to spare.
    const LEAST_SAMPLES: f64 = 4.0;
    if turns_per_s * LEAST_SAMPLES > recording.rate_hz {
        let message = format!(
            "the shaft turns {turns_per_s:.6} times a second, too fast for {} samples a second",
            recording.rate_hz
        );
        return Err(
            Error::new(Code::OutOfRange, message).hint("look at --speed, --pulses and --rate")
        );
    }
    let per_turn = ((recording.rate_hz / turns_per_s).ceil() as usize)
        .clamp(PER_TURN.0, PER_TURN.1)
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
                part += &of_random_part(channel, share);
            }
            Ok(signal)
        })
        .collect::<Result<Vec<AngularSignal>, Error>>()?;
    let fastest = (0..=SPEEDS)
        .map(|k| curve.speed(from + (to - from) * k as f64 / SPEEDS as f64))
        .fold(0.0, f64::max);
    let by_rate = PASS * 0.5 * recording.rate_hz * TAU / fastest;
    let by_angle = signals.iter().map(AngularSignal::pass_order);
    Ok(Turned {
        highest: by_angle.fold(by_rate, f64::min),
        signals,
        curve,
        how: how + &part,
        warnings,
    })
}

/// The shaft's angle over the longest stretch.
///
/// # Errors
/// As for `turned`.
pub(super) fn angle(
    recording: &Recording,
    study: &SpectrumStudy,
    parts: &[Vec<f64>],
    warnings: &mut Vec<Warning>,
) -> Result<(AngleCurve, String), Error> {
    let rpm = |omega: f64| 60.0 * omega / TAU;
    if let Some(name) = &study.tacho {
        let mut unheard = Vec::new();
        let plain = SpectrumStudy {
            separate: false,
            ..study.clone()
        };
        let tacho = longest_parts(
            recording,
            &[channel(recording, name)?],
            &plain,
            &mut unheard,
        )?;
        let samples = tacho.samples.first().map_or(&[][..], Vec::as_slice);
        let found = pulses(samples, recording.rate_hz, Slope::Rising, None)?;
        let missing: usize = found.missing.iter().map(|m| m.number).sum();
        if missing + found.extra_s.len() > 0 {
            warnings.push(Warning {
                code: "tacho-pulses",
                message: format!(
                    "the tacho {name} misses {missing} pulses and has {} too many; its angle was put together without them",
                    found.extra_s.len()
                ),
                hint: Some("look at the tacho's signal and at --pulses".into()),
            });
        }
        if found.pulses.len() <= study.pulses {
            let message = format!(
                "the tacho {name} has {} pulses, less than one turn at {} a turn",
                found.pulses.len(),
                study.pulses
            );
            return Err(Error::new(Code::TooShort, message)
                .hint("is --pulses right? it takes the pulses of one turn"));
        }
        let curve = AngleCurve::from_pulses(&found, study.pulses)?;
        let (from, to) = curve.times_s();
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
        .hint("name the tacho's channel, --tacho COL, or a steady speed, --speed RPM"));
    };
    let samples = parts.first().map_or(0, Vec::len);
    let curve = AngleCurve::steady(speed, samples as f64 / recording.rate_hz)?;
    Ok((curve, format!("steady at {:.4} rpm", rpm(speed))))
}

/// Amplitudes over orders, as half their squares with a bandwidth of one.
///
/// # Errors
/// No tacho and no speed, a tacho without pulses, fewer turns than a block.
pub fn orders(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let Turned {
        signals,
        highest,
        how,
        warnings,
        ..
    } = turned(recording, channels, study)?;
    let whole = signals.iter().map(AngularSignal::turns).min().unwrap_or(0);
    let turns = study
        .turns
        .unwrap_or((2 * whole / LEAST_BLOCKS).clamp(1, MOST_TURNS));
    let mut spectra = Spectra {
        bandwidth_hz: 1.0,
        ..Spectra::default()
    };
    for signal in &signals {
        let lines = order_spectrum(signal, turns)?;
        spectra.rate_hz = signal.per_turn as f64;
        spectra.blocks = lines.blocks;
        spectra.averages = Some((lines.blocks as f64 * INDEPENDENT).max(1.0));
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
        counted(spectra.blocks, "block"),
        counted(turns, "turn"),
        1.0 / turns as f64,
    );
    Ok(Found {
        how,
        across: Across::Order,
        spectra,
        rows: Vec::new(),
        speed: Vec::new(),
        warnings,
    })
}

/// Gives each row of a spectrogram the speed of the shaft in its middle; rows before the first pulse and after the last are dropped.
///
/// # Errors
/// As for `turned`.
pub fn over_speed(
    mut found: Found,
    recording: &Recording,
    study: &SpectrumStudy,
) -> Result<Found, Error> {
    let (curve, how) = angle(recording, study, &[], &mut found.warnings)?;
    let start_s = longest(recording).start as f64 / recording.rate_hz;
    let (from, to) = curve.times_s();
    let is_known = |row: &Row| (from..=to).contains(&(row.time_s - start_s));
    found.rows.iter_mut().for_each(|rows| rows.retain(is_known));
    let times = found.rows.first().map_or(&[][..], Vec::as_slice);
    if times.is_empty() {
        let message = "no row of the spectrogram lies between the pulses of the tacho";
        return Err(Error::new(Code::TooShort, message)
            .hint("ask for shorter blocks by a coarser --resolution"));
    }
    found.speed = (times.iter())
        .map(|row| curve.speed(row.time_s - start_s))
        .collect();
    found.how += &format!("; {how}");
    Ok(found)
}

/// The mean over turns: angles in degrees, one turn of each channel.
pub struct TurnMeans {
    /// In words.
    pub how: String,
    /// Degrees.
    pub angle_deg: Vec<f64>,
    /// One turn of each channel.
    pub turn: Vec<Vec<f64>>,
    /// Turns averaged.
    pub turns: usize,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Averages over turns.
///
/// # Errors
/// As [`orders`].
pub fn means(
    recording: &Recording,
    channels: &[&Channel],
    study: &SpectrumStudy,
) -> Result<TurnMeans, Error> {
    let Turned {
        signals,
        how,
        warnings,
        ..
    } = turned(recording, channels, study)?;
    let all = signals
        .iter()
        .map(TurnAverage::new)
        .collect::<Result<Vec<TurnAverage>, Error>>()?;
    let turns = all.iter().map(|a| a.turns).min().unwrap_or(0);
    let noise = all.first().map_or(0.0, TurnAverage::noise_reduction_db);
    let errors: Vec<String> = all
        .iter()
        .zip(channels)
        .map(|(a, c)| {
            format!(
                "{} ± {:.4e} {}",
                c.name,
                HALF_INTERVAL * a.standard_error,
                c.unit
            )
            .trim_end()
            .to_string()
        })
        .collect();
    let per_turn = signals.first().map_or(1, |s| s.per_turn);
    Ok(TurnMeans {
        how: format!(
            "{how}; mean of {turns} turns, what does not repeat {noise:.1} dB lower; {}",
            errors.join(", ")
        ),
        angle_deg: (0..per_turn)
            .map(|i| 360.0 * i as f64 / per_turn as f64)
            .collect(),
        turn: all.into_iter().map(|a| a.turn).collect(),
        turns,
        warnings,
    })
}

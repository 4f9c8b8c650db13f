//! Modes from responses alone: subspace identification with an automatic choice, or peaks of a decomposition.

use std::f64::consts::TAU;

use super::found::{Evidence, FoundHarmonic, FoundMode, FromSignals, Peak, Peaks, apart};
use super::method::Method;
use super::record::Record;
use super::running::{Orders, evenly_spaced, is_on, is_sine, of_harmonics, of_orders, of_series};
use super::study::IdentifyStudy;
use super::subspace::of_subspace;
use crate::base::error::{Error, Warning};
use crate::identify::mode::IdentifiedMode;
use crate::identify::operational::channels::Channels;
use crate::identify::operational::decomposition::{self, Decomposition, decompose};
use crate::identify::operational::harmonics::Running;
use crate::identify::operational::realisation::Weighting;
use crate::identify::operational::sines::take_out_constant;
use crate::identify::operational::subspace;
use crate::identify::series::residuals::ljung_box;
use crate::numeric::Complex;
use crate::spectrum::tones::Tone;

/// Orders of the running speed that are looked for: 1 to this; meshes beyond are seen by their distribution.
const ORDERS: usize = 10;

/// How far the speed is taken to stray, relative: what an unregulated motor slips under load.
const STRAYS: f64 = 0.005;

/// Identifies from the channels of a record.
///
/// # Errors
/// Those of the method: channels without signal, a record too short.
pub fn identify(
    method: Method,
    record: &Record,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<FromSignals, Error> {
    let mut samples = record.samples.clone();
    let tones = take_out_constant(record.rate_hz, &mut samples)?;
    let samples: Vec<&[f64]> = samples.iter().map(Vec::as_slice).collect();
    let channels = Channels::new(&samples, record.rate_hz)?;
    let running = study.speed_hz.map(|speed_hz| Running {
        speed_hz,
        orders: (1..=ORDERS).map(|k| k as f64).collect(),
        tolerance: STRAYS,
    });
    let settings = decomposition::Settings {
        segment: None,
        band_hz: study.band_hz,
        running: running.clone(),
    };
    let orders = Orders {
        running: running.as_ref(),
        tones: &tones,
        line_hz: record.rate_hz / channels.length() as f64,
    };
    let mut found = match method {
        Method::Fdd | Method::Efdd => of_peaks(method, decompose(&channels, &settings)?, &orders),
        _ => {
            let settings = subspace::Settings {
                band_hz: study.band_hz,
                weighting: match method {
                    Method::SsiData => Weighting::Projection,
                    _ => Weighting::Covariances,
                },
                running: running.clone(),
            };
            let poles = subspace::identify(&channels, &settings)?;
            // Behind the diagram only; a record too short for it still has poles.
            let level = decompose(&channels, &decomposition::Settings::default()).ok();
            of_subspace(poles, &orders, level, band_hz)
        }
    };
    found.warnings.extend(record.warnings.iter().cloned());
    found.rule += &match study.speed_hz {
        Some(speed) => format!(
            "; sines are taken out before; what is within {} % of an order 1 to {ORDERS} of {speed:.4} Hz and not damped beside a sine taken out there, or distributed like a sine, is no mode",
            100.0 * STRAYS
        ),
        None => {
            "; sines are taken out before, and what is distributed like one is no mode".to_string()
        }
    };
    let evenly = evenly_spaced(&tones, &found.modes, orders.line_hz);
    let on_series: Vec<FoundMode>;
    (on_series, found.modes) =
        (found.modes.into_iter()).partition(|m| !is_sine(m) && is_on(&evenly, m, orders.line_hz));
    found.warnings.extend(of_series(&evenly));
    let mut poles;
    (found.modes, poles) = apart(found.modes);
    poles.extend(on_series.iter().map(FoundMode::listed_as_harmonic));
    let inside = |t: &&Tone| (band_hz.0..=band_hz.1).contains(&t.frequency_hz);
    let of_tone = |t: &Tone| FoundHarmonic {
        frequency_hz: t.frequency_hz,
        order: running.as_ref().and_then(|r| r.order(t.frequency_hz)),
        amplitude: t.amplitude.clone(),
        probability: Some(t.probability),
        envelope_kurtosis: None,
    };
    found.harmonics = tones
        .iter()
        .filter(inside)
        .map(of_tone)
        .chain(poles)
        .collect();
    (found.harmonics).sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    if let Some(order) = study.order {
        let of = |m: &FoundMode| m.presence.unwrap_or(0.0);
        found.modes.sort_by(|a, b| of(b).total_cmp(&of(a)));
        found.modes.truncate(order);
        let by_frequency =
            |a: &FoundMode, b: &FoundMode| a.frequency_hz().total_cmp(&b.frequency_hz());
        found.modes.sort_by(by_frequency);
    }
    if !found.modes.is_empty() && (is_nothing(&record.samples, &samples) || is_white(&samples)?) {
        found.modes.clear();
    }
    if found.modes.is_empty() {
        found.warnings.push(Warning {
            code: "no-mode",
            message: "no mode stands out of the noise".to_string(),
            hint: Some(
                "take a longer record, another --band, or --method fdd, which shows the peaks"
                    .to_string(),
            ),
        });
    }
    found.warnings.extend(of_harmonics(&found.harmonics));
    found.warnings.extend(of_orders(&found.modes));
    Ok(found)
}

/// Whether sines are all there is, to the digits that logs are written with.
fn is_nothing(whole: &[Vec<f64>], left: &[&[f64]]) -> bool {
    const DIGITS: f64 = 1e-6;
    let deviation = |samples: &[f64]| {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        samples
            .iter()
            .map(|x| (x - mean).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    (whole.iter().zip(left)).all(|(whole, left)| deviation(left) < DIGITS * deviation(whole))
}

/// Whether every channel is white noise, in which nothing resonates.
fn is_white(samples: &[&[f64]]) -> Result<bool, Error> {
    const LAGS: usize = 100;
    const UNLIKELY: f64 = 1e-3;
    for channel in samples {
        let lags = LAGS.min(channel.len() / 4);
        if lags == 0 || ljung_box(channel, lags, 0)?.probability < UNLIKELY {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The other singular values, the larger first.
fn lower_values(found: &Decomposition) -> Vec<Vec<f64>> {
    let count = found.singular_values.first().map_or(0, Vec::len);
    (1..count)
        .map(|k| found.singular_values.iter().map(|v| v[k]).collect())
        .collect()
}

fn of_peaks(method: Method, found: Decomposition, orders: &Orders) -> FromSignals {
    let mut modes = Vec::new();
    let mut peaks = Vec::new();
    let line_hz = found.frequency_hz.get(1).copied().unwrap_or(0.0);
    for peak in &found.peaks {
        let half_width_hz = peak.mode.as_ref().map_or(0.0, |m| m.pole.re.abs() / TAU);
        let reason = match () {
            () if peak.bell.is_none() => "fewer than four lines beside it share its shape",
            () if half_width_hz < line_hz
                && orders.is_beside_a_sine(peak.frequency_hz, line_hz) =>
            {
                "beside a sine that was taken out, and no wider than a line"
            }
            () => "",
        };
        let bell = peak.mode.clone().filter(|_| method == Method::Efdd);
        peaks.push(Peak {
            frequency_hz: peak.frequency_hz,
            prominence: Some(peak.prominence),
            half_power: None,
            bell: peak.bell.clone().filter(|_| method == Method::Efdd),
            reason: reason.to_string(),
        });
        if !reason.is_empty() {
            continue;
        }
        let mut harmonic = peak.harmonic.clone();
        let on_order = orders.beneath(&mut harmonic, half_width_hz);
        let undamped = || IdentifiedMode {
            pole: Complex::new(0.0, TAU * peak.frequency_hz),
            pole_covariance: None,
            shape: peak.shape.clone(),
        };
        modes.push(FoundMode {
            has_damping: bell.is_some(),
            harmonic: Some(harmonic),
            on_order,
            ..FoundMode::from(bell.unwrap_or_else(undamped))
        });
    }
    let rule = match method {
        Method::Efdd => {
            "peaks of the largest singular value that stand out of their valleys, over a width of their own, beyond chance, with lines of one shape about them; damping from the decay of each peak's bell"
        }
        _ => {
            "peaks of the largest singular value that stand out of their valleys, over a width of their own, beyond chance, with lines of one shape about them; it tells no damping"
        }
    };
    FromSignals {
        modes,
        harmonics: Vec::new(),
        rule: rule.to_string(),
        evidence: Evidence::Peaks(Peaks {
            peaks,
            below: lower_values(&found),
            level: found.largest_values(),
        }),
        warnings: Vec::new(),
    }
}

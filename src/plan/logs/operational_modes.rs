//! Operational modal analysis: SSI with automatic selection, or FDD peaks.

use std::f64::consts::TAU;

use super::identification_result::{
    Evidence, IdentifiedHarmonic, IdentifiedMode, PeakPicking, PickedPeak, SignalIdentification,
    split_harmonics,
};
use super::identify_study::IdentifyStudy;
use super::method::IdentificationMethod;
use super::running::{
    SpeedOrders, find_series, harmonic_warning, in_series, is_sine, order_warning, series_warning,
};
use super::segment_samples::SegmentSamples;
use super::subspace::from_ssi;
use super::wandering_mains::{is_wandering_line, label_mains, mains_warning};
use super::weak;
use crate::base::error::{Diagnostic, Error};
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::operational::fdd::{self, FddEstimate, fdd};
use crate::identify::operational::harmonics::RunningSpeed;
use crate::identify::operational::realisation::Weighting;
use crate::identify::operational::response_channels::ResponseChannels;
use crate::identify::operational::sines::remove_constant_sines;
use crate::identify::operational::spacing::HarmonicSeries;
use crate::identify::operational::ssi;
use crate::identify::series::residuals::ljung_box;
use crate::numeric::Complex;
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::spectrum::tones::Tone;

/// Orders of the running speed that are looked for: 1 to this; meshes beyond are seen by their distribution.
const MAX_SPEED_ORDER: usize = 10;

/// Relative tolerance of the running speed: slip of an unregulated motor under load.
const SPEED_TOLERANCE: f64 = 0.005;

/// Identifies from the channels of a record.
///
/// # Errors
/// Those of the method: channels without signal, a record too short.
pub fn identify_operational(
    method: IdentificationMethod,
    record: &SegmentSamples,
    band_hz: (f64, f64),
    study: &IdentifyStudy,
) -> Result<SignalIdentification, Error> {
    let mut samples = record.samples.clone();
    let tones = remove_constant_sines(record.rate_hz, &mut samples)?;
    let samples: Vec<&[f64]> = samples.iter().map(Vec::as_slice).collect();
    let channels = ResponseChannels::new(&samples, record.rate_hz)?;
    let running = study.speed_hz.map(|speed_hz| RunningSpeed {
        speed_hz,
        orders: (1..=MAX_SPEED_ORDER).map(|k| k as f64).collect(),
        tolerance: SPEED_TOLERANCE,
    });
    let options = fdd::FddOptions {
        segment: None,
        band_hz: study.band_hz,
        running_speed: running.clone(),
    };
    let orders = SpeedOrders {
        running: running.as_ref(),
        tones: &tones,
        line_hz: record.rate_hz / channels.n_samples() as f64,
    };
    let mut found = match method {
        IdentificationMethod::Fdd | IdentificationMethod::Efdd => {
            from_fdd(method, fdd(&channels, &options)?, &orders)
        }
        _ => {
            let options = ssi::SsiOptions {
                band_hz: study.band_hz,
                weighting: match method {
                    IdentificationMethod::SsiData => Weighting::Projection,
                    _ => Weighting::Covariances,
                },
                running: running.clone(),
            };
            let poles = ssi::identify(&channels, &options)?;
            // Behind the diagram only; a record too short for it still has poles.
            let level = fdd(&channels, &fdd::FddOptions::default()).ok();
            from_ssi(poles, &orders, level, band_hz)
        }
    };
    found.diagnostics.extend(record.diagnostics.iter().cloned());
    found.selection_rule += &match study.speed_hz {
        Some(speed) => format!(
            "; sines are removed before, and poles distributed like one are rejected; a pole within {} % of an order 1 to {MAX_SPEED_ORDER} of {speed:.4} Hz is a harmonic if its damping interval includes zero, or if it is the residual of a sine removed there",
            100.0 * SPEED_TOLERANCE
        ),
        None => {
            "; sines are removed before, and poles distributed like one are rejected".to_string()
        }
    };
    let evenly = find_series(&tones, &found.modes, orders.line_hz);
    let on_series: Vec<IdentifiedMode>;
    (on_series, found.modes) =
        (found.modes.into_iter()).partition(|m| !is_sine(m) && in_series(&evenly, m, &orders));
    // A stated speed whose orders they are explains a series.
    let is_order = |s: &&HarmonicSeries| {
        study.speed_hz.is_some_and(|speed| {
            let order = s.spacing_hz / speed;
            (order - order.round().max(1.0)).abs() <= SPEED_TOLERANCE * order
        })
    };
    let unexplained = evenly.iter().find(|s| !is_order(s));
    found
        .diagnostics
        .extend(unexplained.and_then(series_warning));
    let mut poles;
    (found.modes, poles) = split_harmonics(found.modes);
    let of_series = "a narrow pole in a series of evenly spaced sines";
    poles.extend(on_series.iter().map(|m| m.listed_as_harmonic(of_series)));
    let on_mains: Vec<IdentifiedMode>;
    (on_mains, found.modes) = (found.modes.into_iter())
        .partition(|m| m.on_order.is_none() && is_wandering_line(&m.mode, &orders));
    poles.extend(
        on_mains
            .iter()
            .map(|m| m.listed_as_harmonic(IdentifiedHarmonic::MAINS)),
    );
    let of_sine = "next to a removed sine, and too narrow for a structural mode";
    let remnants: Vec<IdentifiedMode>;
    (remnants, found.modes) =
        (found.modes.into_iter()).partition(|m| orders.is_remnant_of_sine(&m.mode));
    poles.extend(remnants.iter().map(|m| m.listed_as_harmonic(of_sine)));
    let is_weak = |m: &IdentifiedMode| {
        weak::unresolved_damping(m, orders.line_hz).or_else(|| {
            let has_sine = orders.contains_removed_sine(&m.mode);
            (has_sine && weak::is_frequency_uncertain(&m.mode)).then_some(
                "a sine was removed in its half-power band, and its frequency is uncertain by more than a tenth of that band",
            )
        })
    };
    (found.modes, found.weak) = weak::split_weak(found.modes, is_weak, study.all);
    let inside = |t: &&Tone| (band_hz.0..=band_hz.1).contains(&t.frequency_hz);
    let of_tone = |t: &Tone| IdentifiedHarmonic {
        frequency_hz: t.frequency_hz,
        order: running.as_ref().and_then(|r| r.order(t.frequency_hz)),
        amplitude: t.amplitude.clone(),
        probability: Some(t.probability),
        envelope_kurtosis: None,
        reason: "a sine",
    };
    found.harmonics = tones
        .iter()
        .filter(inside)
        .map(of_tone)
        .chain(poles)
        .collect();
    sort_ascending(&mut found.harmonics, |a| a.frequency_hz);
    label_mains(&mut found.harmonics, &evenly, orders.line_hz);
    if let Some(order) = study.order {
        let of = |m: &IdentifiedMode| m.presence.unwrap_or(0.0);
        sort_descending(&mut found.modes, of);
        found.modes.truncate(order);
        let by_frequency =
            |a: &IdentifiedMode, b: &IdentifiedMode| a.frequency_hz().total_cmp(&b.frequency_hz());
        found.modes.sort_by(by_frequency);
    }
    if !found.modes.is_empty() && (is_only_sines(&record.samples, &samples) || is_white(&samples)?)
    {
        found.modes.clear();
        found.weak.clear();
    }
    if found.modes.is_empty() && found.weak.is_empty() {
        found.diagnostics.push(Diagnostic {
            code: "no-mode",
            message: "no mode rises above the noise".to_string(),
            hint: Some(
                "take a longer record, another --band, or --method fdd, which shows the peaks"
                    .to_string(),
            ),
        });
    }
    found.diagnostics.extend(harmonic_warning(&found.harmonics));
    found.diagnostics.extend(mains_warning(&found.harmonics));
    found.diagnostics.extend(order_warning(&found.modes));
    Ok(found)
}

/// Whether sines are all there is, to the digits that logs are written with.
fn is_only_sines(whole: &[Vec<f64>], left: &[&[f64]]) -> bool {
    const RELATIVE_RESOLUTION: f64 = 1e-6;
    let deviation = |samples: &[f64]| {
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        samples
            .iter()
            .map(|x| (x - mean).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    (whole.iter().zip(left))
        .all(|(whole, left)| deviation(left) < RELATIVE_RESOLUTION * deviation(whole))
}

/// Whether every channel is white noise, in which nothing resonates.
fn is_white(samples: &[&[f64]]) -> Result<bool, Error> {
    const WHITENESS_LAGS: usize = 100;
    const WHITENESS_LEVEL: f64 = 1e-3;
    for channel in samples {
        let lags = WHITENESS_LAGS.min(channel.len() / 4);
        if lags == 0 || ljung_box(channel, lags, 0)?.probability < WHITENESS_LEVEL {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The other singular values, the larger first.
fn lower_values(found: &FddEstimate) -> Vec<Vec<f64>> {
    let count = found.singular_values.first().map_or(0, Vec::len);
    (1..count)
        .map(|k| found.singular_values.iter().map(|v| v[k]).collect())
        .collect()
}

fn from_fdd(
    method: IdentificationMethod,
    found: FddEstimate,
    orders: &SpeedOrders,
) -> SignalIdentification {
    let mut modes = Vec::new();
    let mut peaks = Vec::new();
    let line_hz = found.frequency_hz.get(1).copied().unwrap_or(0.0);
    for peak in &found.peaks {
        let half_width_hz = peak.mode.as_ref().map_or(0.0, |m| m.pole.re.abs() / TAU);
        let reason = match () {
            () if peak.bell.is_none() => "fewer than four neighbouring lines share its shape",
            () if half_width_hz < line_hz
                && orders.is_near_removed_sine(peak.frequency_hz, line_hz) =>
            {
                "next to a removed sine, and no wider than a line"
            }
            () => "",
        };
        let bell = peak
            .mode
            .clone()
            .filter(|_| method == IdentificationMethod::Efdd);
        peaks.push(PickedPeak {
            frequency_hz: peak.frequency_hz,
            prominence: Some(peak.prominence),
            half_power: None,
            bell: peak
                .bell
                .clone()
                .filter(|_| method == IdentificationMethod::Efdd),
            reason: reason.to_string(),
        });
        if !reason.is_empty() {
            continue;
        }
        let mut harmonic = peak.harmonic.clone();
        let undamped = || ModalParameters {
            pole: Complex::new(0.0, TAU * peak.frequency_hz),
            pole_covariance: None,
            shape: peak.shape.clone(),
        };
        let pole = peak.mode.clone().unwrap_or_else(undamped);
        let on_order = orders.coincident_order(&mut harmonic, &pole);
        modes.push(IdentifiedMode {
            has_damping: bell.is_some(),
            harmonic: Some(harmonic),
            on_order,
            ..IdentifiedMode::from(bell.unwrap_or_else(undamped))
        });
    }
    let rule = match method {
        IdentificationMethod::Efdd => {
            "significant peaks of the largest singular value with neighbouring lines of one shape; damping from the decay of each peak's bell"
        }
        _ => {
            "significant peaks of the largest singular value with neighbouring lines of one shape; it gives no damping"
        }
    };
    SignalIdentification {
        modes,
        weak: Vec::new(),
        harmonics: Vec::new(),
        selection_rule: rule.to_string(),
        evidence: Evidence::Peaks(PeakPicking {
            peaks,
            below: lower_values(&found),
            level: found.largest_values(),
        }),
        diagnostics: Vec::new(),
    }
}

//! Spectra of a log as JSON, CSV and curves.

use serde_json::{Value, json};

use super::json::{log_header, warnings};
use super::lines_picture::Lines;
use super::map_picture::Map;
use super::number::brief;
use super::recording::repairs;
use crate::plan::logs::order_cuts::rpm;
use crate::plan::logs::spectrum_study::{Across, Curve, Line, Spectrum, SpectrumKind};
use crate::recording::raw::Repair;

/// The word for a kind of spectrum.
pub fn kind(kind: SpectrumKind) -> &'static str {
    match kind {
        SpectrumKind::Density => "psd",
        SpectrumKind::Amplitude => "amplitude",
        SpectrumKind::Rms => "rms",
        SpectrumKind::Multitaper => "multitaper",
        SpectrumKind::Envelope => "envelope",
        SpectrumKind::Cepstrum => "cepstrum",
        SpectrumKind::Spectrogram => "spectrogram",
        SpectrumKind::Order => "order",
        SpectrumKind::Average => "average",
    }
}

/// The key of the places.
fn key(across: Across) -> &'static str {
    match across {
        Across::Frequency => "frequency_hz",
        Across::Order => "order",
        Across::Quefrency => "quefrency_s",
        Across::Angle => "angle_deg",
    }
}

/// The JSON document of `spectrum`.
pub fn json(found: &Spectrum, done: &[Repair]) -> Value {
    let trace: Vec<&str> = found.trace.iter().map(|t| t.0).collect();
    let place = key(found.across);
    let channels: Vec<Value> = found.curves.iter().map(|c| channel(c, place)).collect();
    let mut document = json!({
        "geardyn": log_header(&trace),
        "kind": kind(found.kind),
        "how": found.how,
        "averages": found.averages,
        "resolution": found.resolution,
        "interval": found.interval.map(|(lower, upper)| json!({ "confidence": 0.95, "lower": lower, "upper": upper })),
        "channels": channels,
        "effort": found.trace.iter().map(|t| json!({ "stage": t.0, "time_s": t.1 })).collect::<Vec<_>>(),
        "repairs": repairs(done),
        "warnings": warnings(&found.warnings),
    });
    document[place] = json!(found.places);
    document
}

fn channel(curve: &Curve, place: &str) -> Value {
    let mut all = json!({
        "channel": curve.channel,
        "unit": curve.unit,
        "value": curve.value,
        "peaks": curve.lines.iter().map(|l| peak(l, curve, place)).collect::<Vec<_>>(),
    });
    if !curve.rows.is_empty() {
        all["rows"] = curve
            .rows
            .iter()
            .enumerate()
            .map(|(at, row)| {
                let speed_rpm = curve.speed.get(at).map(|&s| rpm(s));
                json!({ "time_s": row.time_s, "speed_rpm": speed_rpm, "value": row.density })
            })
            .collect();
    }
    all
}

fn peak(line: &Line, curve: &Curve, place: &str) -> Value {
    let mut all = json!({
        "value": line.value,
        "amplitude": line.amplitude,
        "amplitude_unit": curve.amplitude_unit,
        "signal_to_noise_db": line.signal_to_noise.map(decibels),
        "significant": line.significant,
        "names": line.names,
    });
    all[place] = json!(line.position);
    all
}

/// A ratio of powers in dB.
pub fn decibels(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

/// One row a line, one column a channel; of spectrograms one row a time and line.
pub fn csv(found: &Spectrum) -> String {
    let with_times = found.curves.iter().any(|c| !c.rows.is_empty());
    let speed = found.curves.first().map_or(&[][..], |c| &c.speed);
    let mut text = String::from(if with_times { "time_s," } else { "" });
    text += if speed.is_empty() { "" } else { "speed_rpm," };
    text += key(found.across);
    for curve in &found.curves {
        let head = match curve.unit.is_empty() {
            true => curve.channel.clone(),
            false => format!("{} [{}]", curve.channel, curve.unit),
        };
        text += &format!(",\"{}\"", head.replace('"', "\"\""));
    }
    text.push('\n');
    let mut row = |time: Option<(usize, f64)>, k: usize, values: &mut dyn Iterator<Item = f64>| {
        if let Some((at, time)) = time {
            text += &format!("{time:?},");
            text += &speed
                .get(at)
                .map_or(String::new(), |&s| format!("{:?},", rpm(s)));
        }
        text += &format!("{:?}", found.places[k]);
        values.for_each(|v| text += &format!(",{v:?}"));
        text.push('\n');
    };
    if with_times {
        let rows = found.curves.iter().map(|c| c.rows.len()).min().unwrap_or(0);
        for r in 0..rows {
            for k in 0..found.places.len() {
                let mut values = found.curves.iter().map(|c| c.rows[r].density[k]);
                row(Some((r, found.curves[0].rows[r].time_s)), k, &mut values);
            }
        }
    } else {
        for k in 0..found.places.len() {
            row(None, k, &mut found.curves.iter().map(|c| c.value[k]));
        }
    }
    text
}

/// Spectrograms as maps, one for each channel; none of other spectra.
pub fn maps(found: &Spectrum, title: &str) -> Vec<Map> {
    let map = |curve: &Curve| {
        let (across, times, rows) = match curve.speed.is_empty() {
            true => (
                "time, s",
                curve.rows.iter().map(|row| row.time_s).collect(),
                curve.rows.iter().map(|row| row.density.clone()).collect(),
            ),
            false => over_speed(curve),
        };
        Map {
            title: format!("{title}: {}", curve.channel),
            level: format!("dB re 1 {}", curve.unit),
            across: across.to_string(),
            times,
            places: found.places.clone(),
            rows,
        }
    };
    let with_times = found.curves.iter().filter(|c| !c.rows.is_empty());
    with_times.map(map).collect()
}

/// Columns of a map over speed, at most.
const SPEEDS: usize = 250;

/// Rows of equal speed averaged, by rising speed in rpm.
fn over_speed(curve: &Curve) -> (&'static str, Vec<f64>, Vec<Vec<f64>>) {
    let ends =
        (curve.speed.iter()).fold((f64::INFINITY, 0.0f64), |(l, h), &s| (l.min(s), h.max(s)));
    let width = (ends.1 - ends.0) / SPEEDS.min(curve.rows.len()).max(1) as f64;
    let bin = |speed: f64| ((speed - ends.0) / width.max(f64::MIN_POSITIVE)) as usize;
    let mut order: Vec<usize> = (0..curve.rows.len()).collect();
    order.sort_by(|&a, &b| curve.speed[a].total_cmp(&curve.speed[b]));
    let (mut speeds, mut rows) = (Vec::new(), Vec::new());
    for group in order.chunk_by(|&a, &b| bin(curve.speed[a]) == bin(curve.speed[b])) {
        let share = 1.0 / group.len() as f64;
        speeds.push(group.iter().map(|&at| share * rpm(curve.speed[at])).sum());
        let mut mean = vec![0.0; curve.rows[group[0]].density.len()];
        for &at in group {
            let both = mean.iter_mut().zip(&curve.rows[at].density);
            both.for_each(|(m, d)| *m += share * d);
        }
        rows.push(mean);
    }
    ("speed, rpm", speeds, rows)
}

/// Labels of one picture at most, the strongest lines first.
const LABELS: usize = 12;

/// The spectra as curves, the strongest lines labelled.
pub fn curves(found: &Spectrum, title: &str) -> Lines {
    let (across, unit) = found.across.words();
    let unit_of = |unit: &str| match unit {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    let up = found.curves.first().map_or("", |c| &c.unit);
    let mut strongest: Vec<&Line> = found.curves.iter().flat_map(|c| &c.lines).collect();
    strongest.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    strongest.truncate(LABELS);
    let text = |line: &Line| match line.names.first() {
        Some(name) => format!("{} {name}", brief(line.position)),
        None => brief(line.position),
    };
    // What lies at the shortest quefrencies, the level of the spectrum, would hide the rest.
    let lowest = found.sought.map_or(f64::NEG_INFINITY, |s| s.0);
    let from = found.places.partition_point(|p| *p < lowest);
    Lines {
        title: title.to_string(),
        across: format!("{across}{}", unit_of(unit)),
        up: match found.kind {
            SpectrumKind::Order | SpectrumKind::Average => format!("amplitude{}", unit_of(up)),
            _ => format!("{}{}", kind(found.kind), unit_of(up)),
        },
        curves: found
            .curves
            .iter()
            .map(|c| {
                (
                    c.channel.clone(),
                    found.places[from..].to_vec(),
                    c.value[from..].to_vec(),
                )
            })
            .collect(),
        labels: strongest
            .into_iter()
            .map(|line| (line.position, line.value, text(line)))
            .collect(),
        logarithmic: matches!(
            found.kind,
            SpectrumKind::Density | SpectrumKind::Multitaper | SpectrumKind::Spectrogram
        ),
    }
}
